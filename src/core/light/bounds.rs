//! The bounds of a set of emitters, for choosing among sets: position, directions of emission and intensity.
//!
//! Conty Estevez and Kulla, Importance Sampling of Many Lights with Adaptive Tree Splitting, 2018; PBR 4th ed., section
//! 12.6.3.

use std::f32::consts::{FRAC_PI_2, PI};

use glam::Vec3;

use crate::math::Aabb;

/// The angle (radians) that is added to merged cones, so that the rounding of `acos` near its ends leaves no emitter
/// outside.
const ANGLE_ROUNDING: f32 = 1e-3;

/// The bounds of one emitter or of a set of them.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct LightBounds {
    pub bounds: Aabb,
    pub cone: NormalCone,
    /// Cosine, in [0, 1], of the angle to its normal up to which an emitter shines; 0 for the hemisphere of a surface.
    pub cos_emission: f32,
    /// The approximate radiant intensity (luminance, W/sr) in the direction in which it is greatest.
    pub intensity: f32,
}

/// The directions within an angle of an axis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct NormalCone {
    /// Unit vector.
    pub axis: Vec3,
    pub cos_angle: f32,
}

impl NormalCone {
    pub const ALL: Self = Self {
        axis: Vec3::Z,
        cos_angle: -1.0,
    };

    pub fn single(axis: Vec3) -> Self {
        Self { axis, cos_angle: 1.0 }
    }

    /// The cone around both cones; nearly the smallest one.
    pub fn union(self, other: Self) -> Self {
        let (wide, narrow) = if self.cos_angle <= other.cos_angle {
            (self, other)
        } else {
            (other, self)
        };
        let (wide_angle, narrow_angle) = (angle(wide.cos_angle), angle(narrow.cos_angle));
        let between = angle(wide.axis.dot(narrow.axis));
        if between + narrow_angle <= wide_angle {
            return wide;
        }
        let union_angle = 0.5 * (wide_angle + between + narrow_angle) + ANGLE_ROUNDING;
        let side = (narrow.axis - wide.axis.dot(narrow.axis) * wide.axis).try_normalize();
        match side {
            Some(side) if union_angle < PI => {
                let (sin, cos) = (union_angle - wide_angle).sin_cos();
                Self {
                    axis: (cos * wide.axis + sin * side).normalize(),
                    cos_angle: union_angle.cos(),
                }
            }
            // The axes are equal up to rounding, which alone has made the cones differ.
            None if union_angle < FRAC_PI_2 => Self {
                cos_angle: union_angle.cos(),
                ..wide
            },
            _ => Self::ALL,
        }
    }

    /// The mean of directions spread evenly over the cone.
    pub fn mean(&self) -> Vec3 {
        0.5 * (1.0 + self.cos_angle) * self.axis
    }
}

impl LightBounds {
    /// The same bounds with `factor` times the intensity; None if the result is not a positive, finite intensity.
    pub fn weighted(self, factor: f32) -> Option<Self> {
        let intensity = factor * self.intensity;
        (intensity > 0.0 && intensity.is_finite()).then_some(Self { intensity, ..self })
    }

    pub fn union(self, other: Self) -> Self {
        Self {
            bounds: self.bounds.union(other.bounds),
            cone: self.cone.union(other.cone),
            cos_emission: self.cos_emission.min(other.cos_emission),
            intensity: self.intensity + other.intensity,
        }
    }
}

fn angle(cos: f32) -> f32 {
    cos.clamp(-1.0, 1.0).acos()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sampling::hash::pcg4d;
    use crate::sampling::{unit_float, warp};

    #[test]
    fn a_union_of_cones_holds_both() {
        let all_but_none = |value: u32| 1.0 - 2.0 * unit_float(value).powi(3);
        for case in 0..2000 {
            let [a, b, c, d] = pcg4d([case, 1, 2, 3]);
            let axis = |a, b| warp::uniform_sphere([unit_float(a), unit_float(b)]);
            let [e, f, ..] = pcg4d([case, 4, 5, 6]);
            let cones = [(axis(a, b), e), (axis(c, d), f)].map(|(axis, value)| NormalCone {
                axis,
                cos_angle: all_but_none(value),
            });
            let union = cones[0].union(cones[1]);
            for cone in cones {
                let (s, t) = cone.axis.any_orthonormal_pair();
                let sin = (1.0 - cone.cos_angle * cone.cos_angle).sqrt();
                for step in 0..16 {
                    let (y, x) = (step as f32 * PI / 8.0).sin_cos();
                    let edge = cone.cos_angle * cone.axis + sin * (x * s + y * t);
                    // A few roundings of numbers around one.
                    let least = union.cos_angle - 1e-6;
                    assert!(edge.dot(union.axis) >= least, "{cones:?}: {union:?} misses {edge}");
                }
            }
        }
    }

    #[test]
    fn equal_normals_stay_narrow_and_opposite_ones_go_everywhere() {
        let up = NormalCone::single(Vec3::Y);
        assert_eq!(up.union(up), up);
        assert_eq!(up.union(NormalCone::single(Vec3::NEG_Y)), NormalCone::ALL);
    }
}
