//! Lamps with measured intensities for other formats: their files for those that have such lamps, and the closest
//! standard light for those that have none.

use std::f32::consts::{PI, TAU};
use std::path::Path;

use super::texture_map::load_picture;
use crate::color::{Rgb, luminance};
use crate::files::Access;
use crate::memory::read_data;
use crate::photometry::{Geometry, LUMENS_PER_WATT, is_ies, read_profile, solid_angle_of_row};
use crate::scene::{Cone, Emitter, EmitterKind};
use crate::texture::Image;

/// The half angle in degrees of the widest lamp that becomes a spot.
const WIDEST_SPOT: f32 = 80.0;

/// The share of the greatest intensity below which a lamp counts as dark.
const DARK: f32 = 0.01;

/// A spot with the lamp's cone, or else a point light, with the lamp's flux; None for other lights. An error if the
/// lamp's file cannot be read.
pub(crate) fn standard_light(emitter: &Emitter, access: &Access) -> Option<Result<EmitterKind, String>> {
    let EmitterKind::Luminaire { profile, scale, flux } = &emitter.kind else {
        return None;
    };
    Some(of_file(profile, *scale, *flux, access))
}

/// A lamp as its file and a factor.
pub(crate) struct MeasuredLamp {
    /// The file, IES LM-63.
    pub bytes: Vec<u8>,
    /// The meaning of its angles.
    pub geometry: Geometry,
    /// The factor on its intensities, by colour.
    pub factor: Rgb,
}

/// The file of a lamp with measured intensities, if it is one of IES LM-63; None for other lights and files.
pub(crate) fn measured_lamp(emitter: &Emitter, access: &Access) -> Option<MeasuredLamp> {
    let EmitterKind::Luminaire { profile, scale, flux } = &emitter.kind else {
        return None;
    };
    let bytes = read_data(profile, access).ok()?;
    let distribution = is_ies(&bytes).then(|| read_profile(&bytes).ok()).flatten()?;
    let own = distribution.picture().lumens();
    let replaced = if *flux > 0.0 && own > 0.0 {
        (f64::from(*flux) / own) as f32
    } else {
        1.0
    };
    Some(MeasuredLamp {
        geometry: distribution.geometry(),
        factor: *scale * replaced,
        bytes,
    })
}

fn of_file(profile: &Path, scale: Rgb, flux: f32, access: &Access) -> Result<EmitterKind, String> {
    let picture = load_picture(profile, access).map_err(|error| format!("{}: {error}", profile.display()))?;
    let rows = means_of_rows(&picture.image);
    let step = PI / (rows.len() - 1) as f32;
    // From the axis of the beam, which is in the last row.
    let angle = |row: usize| step * (rows.len() - 1 - row) as f32;
    let of_row = |(row, mean): (u32, &f32)| f64::from(*mean) * solid_angle_of_row(row, rows.len() as u32);
    let watts = match flux > 0.0 {
        true => flux / LUMENS_PER_WATT,
        false => TAU * (0..).zip(&rows).map(of_row).sum::<f64>() as f32,
    };
    let peak = rows.iter().copied().fold(0.0, f32::max);
    let first_above = |share: f32| rows.iter().position(|mean| *mean > share * peak);
    let (Some(lit), Some(bright)) = (first_above(DARK), first_above(0.5)) else {
        return Ok(EmitterKind::Point { intensity: Rgb::ZERO });
    };
    // The light fades out in the row above.
    let cutoff = angle(lit.saturating_sub(1)).max(step);
    if cutoff > WIDEST_SPOT.to_radians() {
        return Ok(EmitterKind::Point {
            intensity: scale * (watts / (4.0 * PI)),
        });
    }
    let beam = angle(bright).min(0.99 * cutoff);
    // The integral of a falloff that is linear in the angle.
    let solid_angle = TAU * (1.0 - (cutoff.sin() - beam.sin()) / (cutoff - beam));
    Ok(EmitterKind::Spot {
        intensity: scale * (watts / solid_angle),
        cone: Cone {
            cutoff_angle: cutoff.to_degrees(),
            beam_width: beam.to_degrees(),
        },
        texture: None,
    })
}

/// The mean luminance of each row, at least two of them.
fn means_of_rows(image: &Image) -> Vec<f32> {
    let mean = |row: u32| {
        let row = row.min(image.height() - 1);
        let pixels = (0..image.width()).map(|column| luminance(image.pixel(column, row)));
        pixels.sum::<f32>() / image.width() as f32
    };
    (0..image.height().max(2)).map(mean).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    const CORPUS: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/corpus/photometry/");

    fn light(file: &str, flux: f32) -> EmitterKind {
        let path = Path::new(CORPUS).join(file);
        of_file(&path, Rgb::ONE, flux, &Access::everywhere()).expect("a lamp")
    }

    #[test]
    fn a_lamp_for_all_directions_becomes_a_point_with_its_flux() {
        let EmitterKind::Point { intensity } = light("even.ies", 0.0) else {
            panic!("no point light")
        };
        assert!((intensity.x * LUMENS_PER_WATT - 100.0).abs() < 1e-2, "{intensity}");
        let EmitterKind::Point { intensity } = light("even.ies", 4.0 * PI * 50.0) else {
            panic!("no point light")
        };
        assert!((intensity.x * LUMENS_PER_WATT - 50.0).abs() < 1e-3, "{intensity}");
    }

    #[test]
    fn a_narrow_lamp_becomes_a_spot_with_its_flux() {
        let text = "IESNA:LM-63-2002\nTILT=NONE\n1 1000 1 4 1 1 2 0 0 0\n1 1 10\n0 20 30 90\n0\n900 900 0 0\n";
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("lamp.ies");
        std::fs::write(&path, text).expect("a file");
        let made = of_file(&path, Rgb::ONE, 0.0, &Access::everywhere()).expect("a lamp");
        let EmitterKind::Spot { intensity, cone, .. } = made else {
            panic!("{made:?}")
        };
        assert!((cone.cutoff_angle - 30.0).abs() < 0.1, "{cone:?}");
        assert!((20.0..26.0).contains(&cone.beam_width), "{cone:?}");
        let (cutoff, beam) = (cone.cutoff_angle.to_radians(), cone.beam_width.to_radians());
        let solid_angle = TAU * (1.0 - (cutoff.sin() - beam.sin()) / (cutoff - beam));
        let expected = TAU * 900.0 * (1.0 - (30f32.to_radians().sin() - 20f32.to_radians().sin()) / 10f32.to_radians());
        let lumens = intensity.x * LUMENS_PER_WATT * solid_angle;
        assert!((lumens / expected - 1.0).abs() < 0.02, "{lumens}, {expected}");
    }
}
