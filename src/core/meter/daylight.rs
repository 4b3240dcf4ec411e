//! The daylight factor: illuminance inside over that on the open ground, under an overcast sky.
//!
//! The sky is the traditional overcast one of CIE S 011/E:2003 (type 16; Moon and Spencer 1942): at an elevation g it
//! has the luminance Lz (1 + 2 sin g) / 3, where Lz is that of the zenith. The open ground has 7/9 pi Lz. There is no
//! light from below the horizon but what surfaces of the scene reflect: a ground outside is a surface of the scene.

use std::f32::consts::{FRAC_PI_2, PI};
use std::sync::Arc;

use glam::{Mat3, Quat, Vec3};

use crate::light::{EnvironmentMap, LightSource, WeightedSource};
use crate::photometry::LUMENS_PER_WATT;
use crate::render::scene::RenderScene;
use crate::texture::{Image, Samples, Transfer};

/// The illuminance of the open ground in lux: a common overcast noon.
pub const OPEN_GROUND: f32 = 10_000.0;

/// Rows of the picture of the sky, an even number so that the horizon is in the middle of two.
const ROWS: u32 = 1024;
/// Columns of it, which are all alike.
const COLUMNS: u32 = 4;

/// The daylight factor in per cent of an illuminance in lux.
pub fn daylight_factor(lux: f64) -> f64 {
    100.0 * lux / f64::from(OPEN_GROUND)
}

/// The luminance of the overcast sky, relative to that of the zenith, at an elevation in radians; 0 below the horizon.
pub fn relative_luminance(elevation: f32) -> f32 {
    match elevation >= 0.0 {
        true => (1.0 + 2.0 * elevation.sin()) / 3.0,
        false => 0.0,
    }
}

/// The overcast sky that gives the open ground [`OPEN_GROUND`] lux; `up` is a unit vector.
pub fn overcast_sky(up: Vec3) -> LightSource {
    let zenith = OPEN_GROUND / LUMENS_PER_WATT / (7.0 / 9.0 * PI);
    let elevation = |row: u32| FRAC_PI_2 - PI * row as f32 / (ROWS - 1) as f32;
    let row = |row| [zenith * relative_luminance(elevation(row)); COLUMNS as usize];
    let pixels: Vec<f32> = (0..ROWS).flat_map(row).collect();
    let image = Image::new(COLUMNS, ROWS, 1, Samples::F32(pixels), Transfer::Linear);
    match image {
        Some(image) => LightSource::Environment {
            map: Arc::new(EnvironmentMap::new(Arc::new(image), false)),
            // The pole of such pictures is +y.
            world_from_local: Mat3::from_quat(Quat::from_rotation_arc(Vec3::Y, up)),
            scale: 1.0,
        },
        None => unreachable!("there are as many pixels as the size says"),
    }
}

/// The scene with this light in place of all of its own; surfaces that shone do not.
pub fn lit_by(scene: &RenderScene, source: LightSource) -> RenderScene {
    scene.lit_by(&[WeightedSource {
        source,
        sampling_weight: 1.0,
    }])
}
