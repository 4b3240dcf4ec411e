//! A distribution of luminous intensity over directions, and its picture by latitude and longitude.

use glam::DVec3;

/// The meaning of the angles (IES LM-75-01, Goniophotometer Types and Photometric Coordinates; CIE 121-1996).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Geometry {
    /// Vertical planes around the axis of the beam, the nadir of a ceiling lamp: vertical angles from the axis,
    /// horizontal ones counterclockwise as seen from above.
    TypeC,
    /// Planes around a horizontal axis, of floodlights: vertical angles around that axis, horizontal ones to the side
    /// within a plane, to the right as seen along the beam.
    TypeB,
    /// Planes around a vertical axis, of vehicle lamps: horizontal angles around that axis, vertical ones up within a
    /// plane.
    TypeA,
}

/// Luminous intensities in candela, bilinear between the given angles and zero beyond the vertical ones.
#[derive(Clone, Debug, PartialEq)]
pub struct Distribution {
    geometry: Geometry,
    /// Ascending angles in degrees.
    horizontal: Vec<f64>,
    /// Ascending angles in degrees.
    vertical: Vec<f64>,
    /// The intensities at the vertical angles, for each horizontal angle.
    planes: Vec<Vec<f64>>,
}

/// A picture of intensities by latitude and longitude.
#[derive(Clone, Debug, PartialEq)]
pub struct IntensityPicture {
    /// The number of columns: column `i` is at the horizontal angle `-360 i / width` of type C.
    pub width: u32,
    /// The number of rows, from the opposite of the beam's axis in the first to the axis in the last.
    pub height: u32,
    /// Candela, row by row.
    pub candela: Vec<f32>,
}

/// The step of pictures in hundredths of a degree, for angles that are on no grid.
const USUAL_STEP: u32 = 25;

/// The widest step of pictures of types A and B, and of beams that end abruptly, in hundredths of a degree.
const FINE_STEP: u32 = 50;

/// The widest step of rows in hundredths of a degree: a picture of directions has three rows.
const WIDEST_ROWS: u32 = 9_000;

/// The most pixels of a picture, for which its steps become wider than those of the angles.
const MOST_PIXELS: u32 = 1 << 20;

/// The greatest intensity in candela.
const BRIGHTEST: f64 = 1e12;

impl IntensityPicture {
    /// The luminous flux in lumens, exact for intensities that are linear between the rows.
    pub fn lumens(&self) -> f64 {
        let rows = self.candela.chunks_exact(self.width as usize);
        let mean = |row: &[f32]| row.iter().map(|candela| f64::from(*candela)).sum::<f64>() / f64::from(self.width);
        let sum: f64 = (0..)
            .zip(rows)
            .map(|(row, pixels)| solid_angle_of_row(row, self.height) * mean(pixels))
            .sum();
        std::f64::consts::TAU * sum
    }
}

impl Distribution {
    /// A distribution with intensities `planes[horizontal][vertical]` in candela at these angles in degrees; negative
    /// intensities become 0. An error if angles do not ascend or are out of their range, or intensities too great.
    pub(super) fn new(
        geometry: Geometry,
        mut horizontal: Vec<f64>,
        vertical: Vec<f64>,
        mut planes: Vec<Vec<f64>>,
    ) -> Result<Self, String> {
        let (lowest, highest) = match geometry {
            Geometry::TypeC => (0.0, 180.0),
            Geometry::TypeA | Geometry::TypeB => (-180.0, 180.0),
        };
        ascending("vertical", &vertical, lowest, highest)?;
        ascending("horizontal", &horizontal, -360.0, 720.0)?;
        for candela in planes.iter_mut().flatten() {
            if *candela > BRIGHTEST || candela.is_nan() {
                return Err(format!("an intensity of {candela} candela is beyond {BRIGHTEST:e}"));
            }
            *candela = candela.max(0.0);
        }
        // Some files leave out the plane at 360 degrees, which is the first one.
        let (first, last) = (horizontal[0], horizontal[horizontal.len() - 1]);
        if geometry == Geometry::TypeC && first == 0.0 && last > 270.0 && last < 360.0 {
            horizontal.push(360.0);
            planes.push(planes[0].clone());
        }
        let (first, last) = (horizontal[0], horizontal[horizontal.len() - 1]);
        let is_known = match last - first {
            span if geometry != Geometry::TypeC => span <= 360.0,
            0.0 | 360.0 => true,
            90.0 => first == 0.0,
            180.0 => first == 0.0 || first == 90.0,
            _ => false,
        };
        if !is_known {
            return Err(format!(
                "the horizontal angles go from {first} to {last} degrees; expected 0 alone, 0 to 90, 0 to 180, 90 to 270 \
                 or 0 to 360"
            ));
        }
        Ok(Self {
            geometry,
            horizontal,
            vertical,
            planes,
        })
    }

    /// The meaning of its angles.
    pub fn geometry(&self) -> Geometry {
        self.geometry
    }

    /// The intensity in candela in a unit direction. The beam goes along +z; +y is up for types A and B, and +x is at
    /// the horizontal angle 0 of type C, with -y at 90 degrees.
    pub fn intensity(&self, direction: DVec3) -> f64 {
        let DVec3 { x, y, z } = direction;
        let angles = match self.geometry {
            Geometry::TypeC => (x.hypot(y).atan2(z), (-y).atan2(x)),
            Geometry::TypeB => (y.atan2(z), (-x).clamp(-1.0, 1.0).asin()),
            Geometry::TypeA => (y.clamp(-1.0, 1.0).asin(), (-x).atan2(z)),
        };
        self.at(angles.0.to_degrees(), angles.1.to_degrees())
    }

    /// The intensity in candela at a vertical and a horizontal angle in degrees.
    fn at(&self, vertical: f64, horizontal: f64) -> f64 {
        let is_half = self.vertical[0] == 0.0 && self.geometry != Geometry::TypeC;
        let vertical = if is_half { vertical.abs() } else { vertical };
        let (Some(row), Some(plane)) = (
            place(&self.vertical, vertical),
            place(&self.horizontal, self.folded(horizontal)),
        ) else {
            return 0.0;
        };
        let along = |plane: &[f64]| lerp(plane[row.0], plane[row.1], row.2);
        lerp(along(&self.planes[plane.0]), along(&self.planes[plane.1]), plane.2)
    }

    /// The given horizontal angle that has the intensities of this one, by the symmetry that the first and last given
    /// angles tell.
    fn folded(&self, angle: f64) -> f64 {
        let (first, last) = (self.horizontal[0], self.horizontal[self.horizontal.len() - 1]);
        if first == last {
            return first;
        }
        if self.geometry != Geometry::TypeC {
            return if first == 0.0 { angle.abs() } else { angle };
        }
        // A quadrant is mirrored at both planes, a half at its last one.
        let turned = match last - first <= 90.0 {
            true => angle.rem_euclid(180.0),
            false => (angle - first).rem_euclid(360.0) + first,
        };
        if turned <= last {
            return turned;
        }
        2.0 * last - turned
    }

    /// The picture. Of type C it is as fine as the angles, so that it has the same intensities between them as well,
    /// unless that takes more than a million pixels. Types A and B, and beams that end abruptly, have steps of half a
    /// degree at most.
    pub fn picture(&self) -> IntensityPicture {
        let end = self.vertical.len() - 1;
        let ends_abruptly = |angle: f64, row: usize| {
            let is_pole = angle.abs() == 180.0 || angle == 0.0 && end > 0;
            !is_pole && self.planes.iter().any(|plane| plane[row] > 0.0)
        };
        let is_abrupt = ends_abruptly(self.vertical[0], 0) || ends_abruptly(self.vertical[end], end);
        let is_of_type_c = self.geometry == Geometry::TypeC;
        let is_round = is_of_type_c && self.horizontal.len() == 1;
        let widest = if is_abrupt || !is_of_type_c {
            FINE_STEP
        } else {
            WIDEST_ROWS
        };
        let mut vertical = step(&self.vertical, 18_000).min(widest);
        let mut horizontal = match is_round {
            true => 36_000,
            false if is_of_type_c => step(&self.horizontal, 36_000),
            false => step(&self.horizontal, 36_000).min(FINE_STEP),
        };
        let size = |vertical: u32, horizontal: u32| (18_000 / vertical + 1, 36_000 / horizontal);
        let (mut rows, mut columns) = size(vertical, horizontal);
        while rows * columns > MOST_PIXELS {
            match vertical <= horizontal {
                true => vertical = next_divisor(18_000, vertical),
                false => horizontal = next_divisor(36_000, horizontal),
            }
            (rows, columns) = size(vertical, horizontal);
        }
        let mut candela = Vec::with_capacity(rows as usize * columns as usize);
        for row in 0..rows {
            let gamma = 180.0 - f64::from(row * vertical) / 100.0;
            let (sin_gamma, cos_gamma) = gamma.to_radians().sin_cos();
            for column in 0..columns {
                let c = -360.0 * f64::from(column) / f64::from(columns);
                let (sin_c, cos_c) = c.to_radians().sin_cos();
                let direction = DVec3::new(sin_gamma * cos_c, -sin_gamma * sin_c, cos_gamma);
                // At the poles the planes of a file may differ, where a direction has no horizontal angle.
                candela.push(match is_of_type_c {
                    true => self.at(gamma, c) as f32,
                    false => self.intensity(direction) as f32,
                });
            }
        }
        IntensityPicture {
            width: columns,
            height: rows,
            candela,
        }
    }
}

/// The step of the grid of all angles, in hundredths of a degree, a divisor of `whole`.
fn step(angles: &[f64], whole: u32) -> u32 {
    let divisor = |one: u32, other: u32| {
        let (mut one, mut other) = (one, other);
        while other != 0 {
            (one, other) = (other, one % other);
        }
        one
    };
    let mut step = whole;
    for angle in angles {
        let hundredths = (angle * 100.0).round();
        if (angle * 100.0 - hundredths).abs() > 1e-6 {
            return USUAL_STEP;
        }
        step = divisor(step, hundredths.abs() as u32);
    }
    step
}

/// The smallest divisor of `whole` above another one.
fn next_divisor(whole: u32, divisor: u32) -> u32 {
    (divisor + 1..=whole)
        .find(|next| whole.is_multiple_of(*next))
        .unwrap_or(whole)
}

/// The integral of the hat function of a row over its directions, divided by 2 pi: the solid angles by which rows
/// from pole to pole count, for values that are linear in the angle between them. `rows` is at least 2.
pub fn solid_angle_of_row(row: u32, rows: u32) -> f64 {
    let step = std::f64::consts::PI / f64::from(rows - 1);
    match row == 0 || row == rows - 1 {
        true => 1.0 - step.sin() / step,
        false => (f64::from(row) * step).sin() * (2.0 * (0.5 * step).sin()).powi(2) / step,
    }
}

/// The two neighbours of a number in an ascending list, and the share of the second; None outside.
fn place(list: &[f64], number: f64) -> Option<(usize, usize, f64)> {
    /// Rounding of angles by inverse functions, in degrees.
    const MARGIN: f64 = 1e-6;
    let (first, last) = (list[0], list[list.len() - 1]);
    if !(first - MARGIN..=last + MARGIN).contains(&number) {
        return None;
    }
    let after = list.partition_point(|value| *value <= number).min(list.len() - 1);
    let before = after.saturating_sub(1);
    let width = list[after] - list[before];
    let share = if width > 0.0 {
        (number - list[before]) / width
    } else {
        0.0
    };
    Some((before, after, share.clamp(0.0, 1.0)))
}

fn lerp(from: f64, to: f64, share: f64) -> f64 {
    from + (to - from) * share
}

fn ascending(what: &str, angles: &[f64], lowest: f64, highest: f64) -> Result<(), String> {
    if let Some(pair) = angles.windows(2).find(|pair| pair[0] >= pair[1]) {
        return Err(format!(
            "the {what} angle {} follows {}; they must ascend",
            pair[1], pair[0]
        ));
    }
    let mut outside = angles.iter().filter(|angle| !(lowest..=highest).contains(*angle));
    match outside.next() {
        Some(angle) => Err(format!(
            "the {what} angle {angle} is not between {lowest} and {highest} degrees"
        )),
        None if angles.is_empty() => Err(format!("there are no {what} angles")),
        None => Ok(()),
    }
}
