//! Discomfort glare from an eye: the unified glare rating, UGR (CIE 117-1995, Discomfort Glare in Interior Lighting).
//!
//! UGR = 8 log10(0.25 / Lb * sum L^2 w / p^2), with the luminance L of each source in cd/m^2, its solid angle w in sr,
//! its position index p (Guth), and the background luminance Lb, which is the illuminance on the eye without the
//! sources over pi. The eye sees half of all directions, whatever the field of view of a camera, in windows of about a
//! degree.
//!
//! A window counts as a source if its luminance is more than [`TIMES`] the mean of what the eye sees. Sources below the
//! line of sight count as if they were as far above it, because the position index is not known there. Lights without
//! extent have no luminance, and are left out.

use std::sync::atomic::AtomicBool;

use glam::{Mat3, Mat3A, Vec3};
use rayon::prelude::*;

use super::estimate::Estimate;
use crate::bake::cube::windows;
use crate::bake::lightmap::Lightmaps;
use crate::bake::texels::Texels;
use crate::color::luminance;
use crate::photometry::LUMENS_PER_WATT;
use crate::render::camera::Camera;
use crate::render::gathering::Gathering;
use crate::render::irradiance::ReceivedLight;
use crate::render::light_layers::LightGroups;
use crate::render::probe_radiance::Window;
use crate::render::scene::RenderScene;
use crate::render::view::View;
use crate::sampling::hash::pcg3d;

/// How many times the mean luminance a source has at least.
pub const TIMES: f64 = 5.0;

/// Windows along the edge of a face of the cube around the eye.
const SIZE: u32 = 96;
/// Independent sets of samples, and the samples of each.
const SETS: usize = 8;
const SAMPLES: u32 = 16;

/// The glare of a view.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Glare {
    /// The unified glare rating; None without a source, or without any light beside the sources.
    pub rating: Option<Estimate>,
    /// The luminance of the background in cd/m^2.
    pub background: Estimate,
    /// The luminance above which a direction counts as a source, in cd/m^2.
    pub threshold: f64,
    /// The solid angle of all sources in sr.
    pub solid_angle: f64,
}

/// What the eye sees through a window.
struct Seen {
    /// In sr.
    solid_angle: f64,
    /// The cosine to the line of sight.
    cosine: f64,
    /// The index of the position.
    position: f64,
}

/// The position index of a direction in the space of a camera, with y up and z along the line of sight (Guth 1963, as
/// given by the IES Lighting Handbook, 10th edition).
pub fn position_index(direction: Vec3) -> f64 {
    // From the line of sight, and of the plane through both from the vertical, in degrees.
    let direction = direction.as_dvec3().normalize();
    let off = direction.z.clamp(-1.0, 1.0).acos().to_degrees();
    let aside = direction.x.abs().atan2(direction.y.abs()).to_degrees();
    let first = 35.2 - 0.31889 * aside - 1.22 * (-2.0 * aside / 9.0).exp();
    let second = 21.0 + 0.26667 * aside - 0.002_963 * aside * aside;
    (1e-3 * first * off + 1e-5 * second * off * off).exp()
}

/// The glare of a scene for an eye in the place of a camera. None if `cancel` was set meanwhile, or if the camera has
/// no place, as an orthographic one.
pub fn glare(scene: &RenderScene, view: &View, camera: &Camera, cancel: &AtomicBool) -> Option<Glare> {
    let eye = camera.eye()?;
    let from_world = Mat3::from_cols(
        camera.direction_in_camera(Vec3::X),
        camera.direction_in_camera(Vec3::Y),
        camera.direction_in_camera(Vec3::Z),
    );
    let all = windows(eye, &Mat3A::from(from_world.transpose()), SIZE);
    let is_ahead = |window: &Window| (from_world * window.middle()).z > 0.0;
    let texels: Vec<_> = all
        .texels
        .into_iter()
        .filter(|texel| is_ahead(&texel.receiver))
        .collect();
    let texels = Texels {
        pages: std::iter::once(0..texels.len()).collect(),
        texels,
        ..all
    };
    let seen: Vec<Seen> = texels
        .texels
        .iter()
        .map(|texel| {
            let direction = (from_world * texel.receiver.middle()).normalize();
            Seen {
                solid_angle: texel.receiver.solid_angle().into(),
                cosine: direction.z.into(),
                position: position_index(direction),
            }
        })
        .collect();
    let sets: Option<Vec<Lightmaps>> = (0..SETS)
        .into_par_iter()
        .map(|set| {
            let view = View {
                seed: pcg3d([view.seed, set as u32, SETS as u32])[0],
                light_groups: LightGroups::default(),
                ..view.clone()
            };
            let gathering = Gathering {
                scene,
                view: &view,
                light: ReceivedLight::All,
            };
            let mut light = Lightmaps::new(texels.texels.len());
            light.add(&gathering, &texels, SAMPLES, cancel).then_some(light)
        })
        .collect();
    Some(rating(&seen, &sets?))
}

/// The rating by the light that all windows have in each set of samples.
fn rating(seen: &[Seen], sets: &[Lightmaps]) -> Glare {
    let lumens = f64::from(LUMENS_PER_WATT);
    let mean = |window: usize| {
        let sum: f64 = sets.iter().map(|light| f64::from(luminance(light.light(window)))).sum();
        lumens * sum / sets.len() as f64
    };
    let means: Vec<f64> = (0..seen.len()).map(mean).collect();
    let whole: f64 = seen.iter().map(|window| window.solid_angle).sum();
    let average: f64 = seen
        .iter()
        .zip(&means)
        .map(|(window, mean)| window.solid_angle * mean)
        .sum::<f64>()
        / whole;
    let threshold = TIMES * average;
    let is_source = |window: usize| means[window] > threshold;
    let of_set = |light: &Lightmaps| {
        let (mut background, mut sources) = (0.0, 0.0);
        for (
            window,
            Seen {
                solid_angle,
                cosine,
                position,
            },
        ) in seen.iter().enumerate()
        {
            match is_source(window) {
                // The mean of squares, because a window may hold the edge of a lamp.
                true => {
                    let squares = light.sum(window).luminance_squared / f64::from(SAMPLES);
                    sources += lumens * lumens * squares * solid_angle / (position * position);
                }
                false => background += lumens * f64::from(luminance(light.light(window))) * solid_angle * cosine,
            }
        }
        (background / std::f64::consts::PI, sources)
    };
    let found: Vec<(f64, f64)> = sets.iter().map(of_set).collect();
    let background = Estimate::of(&found.iter().map(|(background, _)| *background).collect::<Vec<_>>());
    let has_both = found
        .iter()
        .all(|(background, sources)| *background > 0.0 && *sources > 0.0);
    let ratings: Vec<f64> = found
        .iter()
        .map(|(background, sources)| 8.0 * (0.25 / background * sources).log10())
        .collect();
    let angles = seen.iter().enumerate().filter(|(window, _)| is_source(*window));
    Glare {
        rating: has_both.then(|| Estimate::of(&ratings)),
        background,
        threshold,
        solid_angle: angles.map(|(_, window)| window.solid_angle).sum(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Against the table of position indices of CIE 117, by the tangents of the angles up and aside.
    #[test]
    fn the_position_index_follows_its_table() {
        for (up, aside, index) in [
            (0.0, 0.0, 1.0),
            (0.2, 0.0, 1.53),
            (0.5, 0.0, 2.86),
            (1.0, 0.0, 7.0),
            (0.0, 0.5, 1.43),
            (0.0, 1.0, 2.11),
        ] {
            let found = position_index(Vec3::new(aside, up, 1.0));
            assert!((found / index - 1.0).abs() < 0.05, "{up} {aside}: {found} for {index}");
        }
    }
}
