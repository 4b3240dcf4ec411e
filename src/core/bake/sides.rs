//! Finds the sides of a surface that light reaches.

use std::sync::atomic::AtomicBool;

use glam::{UVec2, Vec2, Vec3};

use crate::color::Rgb;
use crate::render::gathering::{Gathering, Site};
use crate::render::irradiance::{ReceivedLight, Receiver};
use crate::sampling::{Sampler, warp};

/// The number of points tested on a surface, and of paths from each on either side.
const POINTS: u32 = 64;
const PATHS: u32 = 16;
/// The random dimension of a point's position; the paths from there use others.
const PLACE: u32 = 0;

/// Whether light reaches the front and the back of these triangles, estimated at some points. False for both once
/// `cancel` is set.
pub fn lit_sides(gathering: &Gathering, triangles: &[[Vec3; 3]], cancel: &AtomicBool) -> (bool, bool) {
    let regular: Vec<([Vec3; 3], Vec3)> = triangles
        .iter()
        .filter_map(|triangle| {
            let [a, b, c] = *triangle;
            Some((*triangle, (b - a).cross(c - a).try_normalize()?))
        })
        .collect();
    let places: Vec<(Vec3, Vec3)> = (0..POINTS)
        .filter_map(|point| {
            let (corners, normal) = regular.get(point as usize * regular.len() / POINTS as usize)?;
            Some((place_in(corners, sampler(gathering, point, 0, 0).at_2d(PLACE)), *normal))
        })
        .collect();
    let is_lit = |sign| is_lit(gathering, &places, sign, cancel);
    (is_lit(1.0), is_lit(-1.0))
}

fn sampler(gathering: &Gathering, point: u32, side: u32, index: u32) -> Sampler {
    Sampler::new(
        gathering.view.sequence,
        UVec2::new(point, side),
        index,
        gathering.view.seed,
    )
}

fn place_in([a, b, c]: &[Vec3; 3], u: Vec2) -> Vec3 {
    let at = warp::uniform_triangle(u);
    *a + at.x * (*b - *a) + at.y * (*c - *a)
}

/// Whether light reaches one of these points with normals, on the side given by `sign`.
fn is_lit(gathering: &Gathering, places: &[(Vec3, Vec3)], sign: f32, cancel: &AtomicBool) -> bool {
    let side = if sign > 0.0 { 1 } else { 2 };
    let sites: Vec<(Receiver, Sampler)> = (0..)
        .zip(places)
        .flat_map(|(point, &(position, normal))| {
            let normal = sign * normal;
            let receiver = Receiver {
                position,
                error: 32.0 * f32::EPSILON * position.abs().max_element(),
                normal,
                geometric_normal: normal,
            };
            (0..PATHS).map(move |index| (receiver, sampler(gathering, point, side, index)))
        })
        .collect();
    let all = Gathering {
        light: ReceivedLight::All,
        ..gathering.clone()
    };
    let samples = Site::trace(&all, &sites, cancel);
    samples.is_some_and(|arrived| arrived.samples.iter().any(|sample| sample.light != Rgb::ZERO))
}
