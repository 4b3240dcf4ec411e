//! Reads EULUMDAT files (Stockmar, EULUMDAT - ein Leuchtendatenformat fuer den europaeischen Beleuchtungsplaner,
//! Licht '90): one value on each line, intensities in candela per 1000 lumens of the lamps.

use super::cursor::{Cursor, ProfileError, number_of};
use super::distribution::{Distribution, Geometry};

/// The most C-planes, and the most angles in each.
const MOST_PLANES: usize = 721;

/// The most sets of lamps.
const MOST_LAMPS: usize = 20;

/// The number of direct ratios for room indices.
const DIRECT_RATIOS: usize = 10;

/// Whether the second to seventh lines are the numbers that say how many values there are.
pub(super) fn is_eulumdat(bytes: &[u8]) -> bool {
    let mut lines = bytes.split(|byte| *byte == b'\n').skip(1);
    let mut number = || {
        let line = std::str::from_utf8(lines.next()?).ok()?;
        if line.trim().is_empty() {
            Some(0.0)
        } else {
            number_of(line)
        }
    };
    let Some([kind, symmetry, planes, _, angles, _]) = (|| {
        let mut all = [0.0; 6];
        for value in &mut all {
            *value = number()?;
        }
        Some(all)
    })() else {
        return false;
    };
    (0.0..=3.0).contains(&kind) && (0.0..=4.0).contains(&symmetry) && planes >= 1.0 && angles >= 1.0
}

pub(super) fn read(text: &str) -> Result<Distribution, ProfileError> {
    let mut cursor = Cursor::new(text);
    cursor.next_line();
    cursor.number_of_line("the type of the source")?;
    let symmetry = count(&mut cursor, "the symmetry", 0, 4)?;
    let planes = count(&mut cursor, "the number of C-planes", 1, MOST_PLANES)?;
    cursor.number_or_blank("the distance of C-planes")?;
    let angles = count(&mut cursor, "the number of intensities in a C-plane", 1, MOST_PLANES)?;
    cursor.number_or_blank("the distance of intensities")?;
    // The report, three names and the date.
    for _ in 0..5 {
        cursor.next_line();
    }
    for _ in 0..9 {
        cursor.number_or_blank("a measure of the luminaire in millimetres")?;
    }
    cursor.number_or_blank("the share of light downwards")?;
    cursor.number_or_blank("the light output ratio")?;
    let conversion = cursor.number_or_blank("the conversion factor of intensities")?;
    cursor.number_or_blank("the tilt of the luminaire")?;
    let sets = count(&mut cursor, "the number of sets of lamps", 1, MOST_LAMPS)?;
    let lumens = lamps(&mut cursor, sets)?;
    for _ in 0..DIRECT_RATIOS {
        cursor.number_or_blank("a direct ratio")?;
    }
    let of_angles = cursor.line();
    let mut lines = |count: usize, what: &str| -> Result<Vec<f64>, ProfileError> {
        (0..count).map(|_| cursor.number_of_line(what)).collect()
    };
    let all_planes = lines(planes, "the angle of a C-plane")?;
    let gamma = lines(angles, "an angle gamma")?;
    let (first, kept) = match symmetry {
        0 => (0, planes),
        1 => (0, 1),
        2 => (0, planes / 2 + 1),
        // The planes from C270 over C0 to C90.
        3 => (3 * planes / 4, planes / 2 + 1),
        _ => (0, planes / 4 + 1),
    };
    // Blank files have a conversion factor of 0.
    let factor = lumens / 1000.0 * if conversion > 0.0 { conversion } else { 1.0 };
    let mut given = Vec::new();
    for plane in 0..kept {
        let angle = all_planes[(first + plane) % planes];
        let candela = lines(angles, "an intensity in candela per 1000 lumens")?;
        given.push((angle, candela.iter().map(|value| value * factor).collect()));
    }
    let (horizontal, values) = unfolded(symmetry, given).map_err(|message| ProfileError::new(of_angles, message))?;
    Distribution::new(Geometry::TypeC, horizontal, gamma, values)
        .map_err(|message| ProfileError::new(of_angles, message))
}

/// The lumens of the first set of lamps, which the luminaire has when it is sold. Absolute photometry writes a negative
/// number of lamps.
fn lamps(cursor: &mut Cursor, sets: usize) -> Result<f64, ProfileError> {
    let mut lumens = 0.0;
    let mut line = cursor.line();
    for set in 0..sets {
        let is_absolute = cursor.number_or_blank("the number of lamps")? < 0.0;
        cursor.next_line();
        if set == 0 {
            line = cursor.line();
        }
        let of_set = cursor.number_or_blank("the lumens of the lamps")?;
        for _ in 0..3 {
            cursor.next_line();
        }
        if set == 0 {
            lumens = of_set.abs();
            if is_absolute && lumens == 0.0 {
                lumens = 1000.0;
            }
        }
    }
    match lumens > 0.0 {
        true => Ok(lumens),
        false => Err(ProfileError::new(line, "the lamps have no lumens")),
    }
}

fn count(cursor: &mut Cursor, what: &str, least: usize, most: usize) -> Result<usize, ProfileError> {
    let line = cursor.line();
    let number = cursor.number_of_line(what)?;
    match number.fract() == 0.0 && (least as f64..=most as f64).contains(&number) {
        true => Ok(number as usize),
        false => Err(ProfileError::new(
            line,
            format!("expected {what} from {least} to {most}, found {number}"),
        )),
    }
}

/// The planes around the whole circle, by ascending angle. The mirror of a plane at angle `c` is at `360 - c`, or at
/// `180 - c` for symmetry to the plane C90-C270. An error if two planes are at the same angle.
fn unfolded(symmetry: usize, given: Vec<(f64, Vec<f64>)>) -> Result<(Vec<f64>, Vec<Vec<f64>>), String> {
    let mut all = given;
    // The plane at 360 degrees is the first one again.
    if all.len() > 1 && all[0].0 == 0.0 && all[all.len() - 1].0 == 360.0 {
        all.pop();
    }
    ascend(&mut all);
    if let Some(pair) = all.windows(2).find(|pair| pair[0].0 == pair[1].0) {
        return Err(format!("two C-planes are at {} degrees", pair[0].0));
    }
    let mirrored = |all: &mut Vec<(f64, Vec<f64>)>, mirror: fn(f64) -> f64| {
        let others: Vec<_> = all
            .iter()
            .map(|(angle, plane)| (mirror(*angle), plane.clone()))
            .collect();
        all.extend(others);
    };
    match symmetry {
        2 => mirrored(&mut all, |angle| 360.0 - angle),
        3 => mirrored(&mut all, |angle| 180.0 - angle),
        4 => {
            mirrored(&mut all, |angle| 180.0 - angle);
            mirrored(&mut all, |angle| 360.0 - angle);
        }
        _ => {}
    }
    ascend(&mut all);
    all.dedup_by(|one, other| one.0 == other.0);
    // The circle is closed.
    if let (true, Some((first, plane))) = (all.len() > 1, all.first().cloned()) {
        all.push((first + 360.0, plane));
    }
    Ok(all.into_iter().unzip())
}

/// Sorts planes by their angles from 0 to less than 360 degrees.
fn ascend(planes: &mut [(f64, Vec<f64>)]) {
    for (angle, _) in planes.iter_mut() {
        *angle = angle.rem_euclid(360.0);
    }
    planes.sort_by(|one, other| one.0.total_cmp(&other.0));
}
