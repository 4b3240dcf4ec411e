//! The curve by which lamp makers draw a distribution: its intensities in one plane, as distances from the middle.

use glam::{DVec3, Vec2};

use super::{Distribution, IntensityPicture};

/// The number of steps of a half of the curve, of three degrees.
const STEPS: usize = 60;

/// The intensities in the plane of two opposite horizontal angles, with the figures of the whole lamp.
#[derive(Clone, Debug, PartialEq)]
pub struct PolarCurve {
    /// The luminous flux in lumens.
    pub lumens: f32,
    /// The greatest intensity in any direction, in candela.
    pub peak: f32,
    /// The greatest intensity of the curve, in candela.
    pub farthest: f32,
    /// The points of the closed curve in units of the greatest distance: +y is down, where the beam goes.
    pub points: Vec<Vec2>,
}

impl PolarCurve {
    /// The curve in the plane of the horizontal angles `c` and `c` + 180 degrees.
    pub fn new(distribution: &Distribution, c: f64) -> Self {
        let (sin_c, cos_c) = c.to_radians().sin_cos();
        let at = |sin: f64, cos: f64| distribution.intensity(DVec3::new(sin * cos_c, -sin * sin_c, cos)) as f32;
        Self::of(&distribution.picture(), at)
    }

    /// [`Self::new`] of the picture of a distribution, linear between its pixels.
    pub fn of_picture(picture: &IntensityPicture, c: f64) -> Self {
        let (width, last) = (f64::from(picture.width), f64::from(picture.height.saturating_sub(1)));
        let at = |sin: f64, cos: f64| {
            let gamma = sin.abs().atan2(cos).to_degrees();
            let c = if sin < 0.0 { c + 180.0 } else { c };
            let (row, column) = ((1.0 - gamma / 180.0) * last, (-c / 360.0 * width).rem_euclid(width));
            let pixel = |row: f64, column: f64| {
                let index = row.min(last) as usize * picture.width as usize + (column % width) as usize;
                picture.candela.get(index).copied().unwrap_or_default()
            };
            let in_row = |row: f64| {
                let (left, right) = (pixel(row, column.floor()), pixel(row, column.floor() + 1.0));
                left + (right - left) * column.fract() as f32
            };
            let (above, below) = (in_row(row.floor()), in_row(row.floor() + 1.0));
            above + (below - above) * row.fract() as f32
        };
        Self::of(picture, at)
    }

    /// The curve of an intensity in candela by the sine and cosine of the angle from the axis of the beam.
    fn of(picture: &IntensityPicture, candela: impl Fn(f64, f64) -> f32) -> Self {
        let at = |step: usize| {
            let (sin, cos) = (std::f64::consts::PI * step as f64 / STEPS as f64).sin_cos();
            Vec2::new(sin as f32, cos as f32) * candela(sin, cos)
        };
        let mut points: Vec<Vec2> = (0..2 * STEPS).map(at).collect();
        let farthest = points.iter().map(|point| point.length()).fold(0.0, f32::max);
        if farthest > 0.0 {
            points.iter_mut().for_each(|point| *point /= farthest);
        }
        Self {
            lumens: picture.lumens() as f32,
            peak: picture.candela.iter().copied().fold(0.0, f32::max),
            farthest,
            points,
        }
    }

    /// Whether a place is inside of the curve, in the units of its points.
    pub fn contains(&self, place: Vec2) -> bool {
        let angle = place.x.atan2(place.y).rem_euclid(std::f32::consts::TAU);
        let step = angle / std::f32::consts::PI * STEPS as f32;
        let before = step as usize % self.points.len();
        let after = (before + 1) % self.points.len();
        let [from, to] = [before, after].map(|index| self.points[index].length());
        place.length() < from + (to - from) * step.fract()
    }
}
