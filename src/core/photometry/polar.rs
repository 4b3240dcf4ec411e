//! The curve by which lamp makers draw a distribution: its intensities in one plane, as distances from the middle.

use glam::{DVec3, Vec2};

use super::Distribution;

/// The number of steps of a half of the curve, of three degrees.
const STEPS: usize = 60;

/// The intensities in the plane of two opposite horizontal angles, with the figures of the whole lamp.
#[derive(Clone, Debug, PartialEq)]
pub struct PolarCurve {
    /// The luminous flux in lumens.
    pub lumens: f32,
    /// The greatest intensity in any direction, in candela.
    pub peak: f32,
    /// The points of the closed curve in units of the greatest distance: +y is down, where the beam goes.
    pub points: Vec<Vec2>,
}

impl PolarCurve {
    /// The curve in the plane of the horizontal angles `c` and `c` + 180 degrees.
    pub fn new(distribution: &Distribution, c: f64) -> Self {
        let picture = distribution.picture();
        let (sin_c, cos_c) = c.to_radians().sin_cos();
        let at = |step: usize| {
            let (sin, cos) = (std::f64::consts::PI * step as f64 / STEPS as f64).sin_cos();
            let candela = distribution.intensity(DVec3::new(sin * cos_c, -sin * sin_c, cos));
            Vec2::new(sin as f32, cos as f32) * candela as f32
        };
        let mut points: Vec<Vec2> = (0..2 * STEPS).map(at).collect();
        let farthest = points.iter().map(|point| point.length()).fold(0.0, f32::max);
        if farthest > 0.0 {
            points.iter_mut().for_each(|point| *point /= farthest);
        }
        Self {
            lumens: picture.lumens() as f32,
            peak: picture.candela.iter().copied().fold(0.0, f32::max),
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
