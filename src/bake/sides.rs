//! Which sides of a surface light comes to.

use glam::{UVec2, Vec2, Vec3};

use super::lightmap::Gathering;
use crate::color::Rgb;
use crate::render::irradiance::{ReceivedLight, Receiver, trace_irradiance};
use crate::sampling::{Sampler, warp};

/// The points of a surface that are asked, and the paths from each on either side.
const POINTS: u32 = 64;
const PATHS: u32 = 16;
/// The dimension of the place of a point; the paths from there use others.
const PLACE: u32 = 0;

/// Whether any light comes to the front and to the back of these triangles, as far as some points on them tell.
pub fn lit_sides(gathering: &Gathering, triangles: &[[Vec3; 3]]) -> (bool, bool) {
    let regular: Vec<([Vec3; 3], Vec3)> = triangles
        .iter()
        .filter_map(|triangle| {
            let [a, b, c] = *triangle;
            Some((*triangle, (b - a).cross(c - a).try_normalize()?))
        })
        .collect();
    let mut lit = [false, false];
    for point in 0..POINTS {
        let Some((corners, normal)) = regular.get(point as usize * regular.len() / POINTS as usize) else {
            break;
        };
        let place = Sampler::new(gathering.sequence, UVec2::new(point, 0), 0, gathering.seed).at_2d(PLACE);
        let position = place_in(corners, place);
        for (side, sign) in [(0, 1.0), (1, -1.0)] {
            lit[side] = lit[side] || is_lit(gathering, position, sign * *normal, UVec2::new(point, 1 + side as u32));
        }
    }
    (lit[0], lit[1])
}

fn place_in([a, b, c]: &[Vec3; 3], u: Vec2) -> Vec3 {
    let at = warp::uniform_triangle(u);
    *a + at.x * (*b - *a) + at.y * (*c - *a)
}

fn is_lit(gathering: &Gathering, position: Vec3, normal: Vec3, pixel: UVec2) -> bool {
    let receiver = Receiver {
        position,
        error: 32.0 * f32::EPSILON * position.abs().max_element(),
        normal,
        geometric_normal: normal,
    };
    (0..PATHS).any(|index| {
        let sampler = Sampler::new(gathering.sequence, pixel, index, gathering.seed);
        let (scene, settings) = (gathering.scene, &gathering.settings);
        let sample = trace_irradiance(
            scene,
            settings,
            &receiver,
            ReceivedLight::All,
            sampler,
            gathering.medium,
        );
        sample.irradiance != Rgb::ZERO
    })
}
