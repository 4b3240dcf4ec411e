//! A node of the light tree in 32 bytes, and the estimate of its contribution to a point.

use glam::{I16Vec2, U16Vec2, Vec2, Vec3};

use crate::light::bounds::{LightBounds, NormalCone};
use crate::light::reference::Reference;
use crate::math::{Real, Vector};

/// The content of a node's child.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Content {
    Emitter(u32),
    Pair(u32),
}

/// The emitters below a node, as a ball of points with normals in a cone.
#[derive(Clone, Copy, Debug)]
pub(super) struct Node {
    center: Vec3,
    /// The squared radius of the ball.
    radius_squared: f32,
    intensity: f32,
    /// The index of a pair or an emitter; the highest bit tells which.
    link: u32,
    /// The axis of the cone of normals, octahedrally encoded.
    axis: I16Vec2,
    /// The cosines of that cone's angle, from -1 to 1, and of the angle of emission, from 0 to 1, both rounded down.
    cosines: U16Vec2,
}

const EMITTER: u32 = 1 << 31;

/// Added to the squared sine of the angle subtended by a node, so that rounding hides no emitter behind a horizon: a
/// thousandth of a radian, where the encoding of an axis loses a tenth of that and a narrow cone a quarter in the
/// cosine of its angle.
const SINE_SQUARED_ROUNDING: f32 = 1e-6;

/// The least squared distance to a ball's centre, in squared radii: within it, emitters are all around.
const NEAREST_SQUARED: f32 = 0.25;

impl Node {
    /// A placeholder, to be overwritten.
    pub const EMPTY: Self = Self {
        center: Vec3::ZERO,
        radius_squared: 0.0,
        intensity: 0.0,
        link: 0,
        axis: I16Vec2::ZERO,
        cosines: U16Vec2::ZERO,
    };

    pub fn new(light: &LightBounds, content: Content) -> Self {
        let round_down = |unit: f32| (unit.clamp(0.0, 1.0) * f32::from(u16::MAX)) as u16;
        Self {
            center: light.bounds.center(),
            radius_squared: 0.25 * light.bounds.extent().length_squared(),
            intensity: light.intensity,
            link: match content {
                Content::Emitter(emitter) => emitter | EMITTER,
                Content::Pair(pair) => pair,
            },
            axis: octahedron_from(light.cone.axis),
            cosines: U16Vec2::new(
                round_down(0.5 + 0.5 * light.cone.cos_angle),
                round_down(light.cos_emission),
            ),
        }
    }

    pub fn content(&self) -> Content {
        if self.link & EMITTER != 0 {
            Content::Emitter(self.link & !EMITTER)
        } else {
            Content::Pair(self.link)
        }
    }

    fn cone(&self) -> NormalCone {
        NormalCone {
            axis: from_octahedron(self.axis),
            cos_angle: f32::from(self.cosines.x) * (2.0 / f32::from(u16::MAX)) - 1.0,
        }
    }

    /// The node as seen from the reference: its most favourable direction, at the distance of its centre.
    #[inline(always)]
    pub fn seen_from<R: Real>(&self, from: &Reference<R>) -> Seen<R> {
        let to_center = R::Vec3::same(self.center) - from.position;
        let radius_squared = R::splat(self.radius_squared);
        let distance_squared = to_center.length_squared();
        let direction = to_center / distance_squared.sqrt();
        let size = Angle::from_sine_squared(radius_squared / distance_squared + R::splat(SINE_SQUARED_ROUNDING));
        let facing = Angle::from_cosine(from.normal.dot(direction)).less(size).cos;
        let mut cosines = R::select(from.halved, facing.max(R::ZERO), R::ONE);
        if self.cosines.x > 0 {
            let cone = self.cone();
            let leaving = Angle::from_cosine(-direction.dot(R::Vec3::same(cone.axis)));
            let cone_angle = Angle::from_cosine(R::splat(cone.cos_angle));
            let cos = leaving.less(cone_angle).less(size).cos;
            let cos_emission = f32::from(self.cosines.y) * (1.0 / f32::from(u16::MAX));
            cosines = (cosines * cos).only(R::is_above(cos, cos_emission));
        }
        // Within the ball, light may come from all directions. A point does not light itself.
        let is_within = distance_squared.is_at_most(radius_squared);
        let of_ball = R::splat(if self.radius_squared > 0.0 { 1.0 } else { 0.0 });
        let nearest = distance_squared.max(R::splat(NEAREST_SQUARED) * radius_squared);
        Seen {
            cosines: R::select(is_within, of_ball, cosines),
            distance_squared: R::select(is_within, nearest, distance_squared).min(R::splat(f32::MAX)),
            intensity: self.intensity,
        }
    }
}

/// A node as seen from a point, or from one per lane.
#[derive(Clone, Copy)]
pub(super) struct Seen<R: Real> {
    /// The product of the cosines at both ends; zero only where it sends no light to the point.
    cosines: R,
    distance_squared: R,
    intensity: f32,
}

impl<R: Real> Seen<R> {
    /// Whether it sends any light to the point.
    #[inline(always)]
    pub fn is_lit(&self) -> R::Mask {
        R::is_above(self.cosines, 0.0)
    }

    /// The approximate ratio of the irradiances from this node and another, with all their light at the ball's
    /// distance. Defined where both are [`Self::is_lit`].
    #[inline(always)]
    pub fn over(&self, other: &Self) -> R {
        // The limits keep the product of two such quotients finite.
        let within = |quotient: R| quotient.max(R::splat(1e-18)).min(R::splat(1e18));
        within(R::splat(self.intensity) / R::splat(other.intensity))
            * within(other.distance_squared / self.distance_squared)
            * (self.cosines / other.cosines)
    }
}

/// An angle in [0, pi] by its cosine and sine.
#[derive(Clone, Copy)]
struct Angle<R: Real> {
    cos: R,
    sin: R,
}

impl<R: Real> Angle<R> {
    #[inline(always)]
    fn from_cosine(cos: R) -> Self {
        let sin = (R::ONE - cos * cos).max(R::ZERO).sqrt();
        Self { cos, sin }
    }

    /// An angle below a right angle, from the square of its sine.
    #[inline(always)]
    fn from_sine_squared(sine_squared: R) -> Self {
        let sine_squared = sine_squared.min(R::ONE);
        Self {
            cos: (R::ONE - sine_squared).sqrt(),
            sin: sine_squared.sqrt(),
        }
    }

    /// The difference, but not below zero.
    #[inline(always)]
    fn less(self, other: Self) -> Self {
        let is_less = !self.cos.is_less(other.cos);
        let cos = self.cos * other.cos + self.sin * other.sin;
        let sin = self.sin * other.cos - self.cos * other.sin;
        Self {
            cos: R::select(is_less, R::ONE, cos),
            sin: R::select(is_less, R::ZERO, sin),
        }
    }
}

/// Encodes unit vectors as points of a square: the unfolded octahedron (Meyer et al., On Floating-Point Normal Vectors,
/// 2010).
fn octahedron_from(v: Vec3) -> I16Vec2 {
    let p = v / v.abs().element_sum();
    let folded = if p.z >= 0.0 { p.truncate() } else { fold(p.truncate()) };
    (folded * f32::from(i16::MAX)).round().as_i16vec2()
}

fn from_octahedron(point: I16Vec2) -> Vec3 {
    let p = point.as_vec2() / f32::from(i16::MAX);
    let z = 1.0 - p.x.abs() - p.y.abs();
    let xy = if z >= 0.0 { p } else { fold(p) };
    xy.extend(z).normalize()
}

/// Swaps the inner and the outer half of the square.
fn fold(p: Vec2) -> Vec2 {
    (Vec2::ONE - Vec2::new(p.y, p.x).abs()) * Vec2::ONE.copysign(p)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::light::LightReference;
    use crate::math::Aabb;
    use crate::sampling::hash::pcg4d;
    use crate::sampling::{unit_float, warp};

    fn directions() -> impl Iterator<Item = Vec3> {
        let random = (0..4000).map(|i| {
            let [a, b, ..] = pcg4d([i, 7, 8, 9]);
            warp::uniform_sphere([unit_float(a), unit_float(b)])
        });
        random.chain([Vec3::X, Vec3::NEG_X, Vec3::Y, Vec3::NEG_Y, Vec3::Z, Vec3::NEG_Z])
    }

    #[test]
    fn a_packed_cone_is_the_one_it_was_made_from() {
        for axis in directions() {
            let light = LightBounds {
                bounds: Aabb::from_points([Vec3::ZERO]),
                cone: NormalCone::single(axis),
                cos_emission: 0.0,
                intensity: 1.0,
            };
            let packed = Node::new(&light, Content::Emitter(3)).cone();
            // The difference is measured by the chord, because the cosine of so small an angle is one.
            assert!(packed.axis.distance(axis) < 1e-4, "{axis}: {packed:?}");
            assert_eq!(packed.cos_angle, 1.0);
        }
        assert_eq!(size_of::<Node>(), 32);
    }

    #[test]
    fn a_small_light_facing_the_point_has_the_importance_of_its_irradiance() {
        let light = LightBounds {
            bounds: Aabb::from_points([Vec3::new(0.0, 2.0, 0.0)]),
            cone: NormalCone::single(Vec3::NEG_Y),
            cos_emission: 0.0,
            intensity: 5.0,
        };
        let node = Node::new(&light, Content::Emitter(0));
        for x in [0.0, 1.0, -4.0] {
            let reference = LightReference {
                position: Vec3::new(x, 0.0, 0.0),
                normal: Some(Vec3::Y),
            };
            let square: f32 = 4.0 + x * x;
            let seen = node.seen_from::<f32>(&(&reference).into());
            // Two angles, each reduced by the margin for rounding.
            assert!((seen.cosines * square / 4.0 - 1.0).abs() < 0.01, "{x}");
            assert_eq!((seen.distance_squared, seen.intensity), (square, 5.0));
        }
        let behind = LightReference {
            position: Vec3::new(0.3, 2.5, 0.0),
            normal: None,
        };
        assert!(!node.seen_from::<f32>(&(&behind).into()).is_lit());
        let turned_away = LightReference {
            position: Vec3::ZERO,
            normal: Some(Vec3::NEG_Y),
        };
        assert!(!node.seen_from::<f32>(&(&turned_away).into()).is_lit());
    }
}
