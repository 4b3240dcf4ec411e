//! Portals: openings through which a room sees the sky. Directions to the sky are sampled through them, uniformly over
//! the solid angles under which they are seen; a share stays with the density of the sky itself, so that what comes in
//! elsewhere is found as well.
//!
//! A portal counts at the places that it may light ([`learn`]). With the weights `w`, solid angles `s` and shares `a`
//! of those that count at a place, portal `k` is chosen with the probability `a_k w_k s_k / sum(w s)`, so that a
//! direction through some of them has the density `sum(a w) / sum(w s)`, whichever was chosen.

mod learn;

use glam::Vec3;

use super::reference::Reference;
use crate::math::{Aabb, Mask, Real, Same, Vector};
use crate::sampling::{ONE_MINUS_EPSILON, Rectangle};

pub(super) use self::learn::Rooms;

/// A parallelogram in world space through which light may come in, `corner + a edges[0] + b edges[1]` with a and b in
/// [0, 1]. It is a hint where light comes from, and changes no picture but for its noise. Parallelograms without right
/// angles do not help.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Portal {
    /// A corner.
    pub corner: Vec3,
    /// The edges from there.
    pub edges: [Vec3; 2],
}

/// The most sides of portals that are kept for a light. Each costs time at every place that it may light.
const MOST_SIDES: usize = 32;

/// The least factor on the weight of a portal that a surface sees slantwise.
const LEAST_COSINE: f32 = 0.1;

/// A portal does not count at places that are nearer to its plane than this share of its longer edge.
const LEAST_HEIGHT: f32 = 1e-3;

/// A portal with the places on one of its sides.
#[derive(Clone, Debug)]
struct PortalSide {
    rectangle: Rectangle,
    /// 1 if these places are on the side of the rectangle's normal, -1 on the other.
    side: f32,
    /// The box around the places that it may light.
    room: Aabb,
    /// The light through it on a solid angle, relative to others.
    weight: f32,
    /// The share of the samples, in (0, 1).
    share: f32,
}

/// The portals of a light.
#[derive(Clone, Debug)]
pub(super) struct Portals {
    sides: Vec<PortalSide>,
}

/// The portals as seen from one point, or from one per lane.
pub(super) struct Seen<'p, R: Real> {
    origin: R::Vec3,
    sides: &'p [PortalSide],
    /// The number of portals that count anywhere.
    count: usize,
    /// Their numbers.
    numbers: [u8; MOST_SIDES],
    /// The probabilities with which they are chosen.
    chances: [R; MOST_SIDES],
    /// The densities of directions through them.
    densities: [R; MOST_SIDES],
    /// The probability of choosing any.
    share: R,
}

/// Directions through portals.
pub(super) struct Through<R: Real> {
    /// A mask of the points for which a portal was chosen; elsewhere `wi` is undefined.
    pub is_chosen: R::Mask,
    pub wi: R::Vec3,
    /// What is left of the first number where none was chosen, in [0, 1).
    pub rest: R,
}

impl Portals {
    /// The portals that count at these points.
    #[inline(always)]
    pub fn seen_from<R: Real>(&self, from: &Reference<R>) -> Seen<'_, R> {
        let mut seen = Seen {
            origin: from.position,
            sides: &self.sides,
            count: 0,
            numbers: [0; MOST_SIDES],
            chances: [R::ZERO; MOST_SIDES],
            densities: [R::ZERO; MOST_SIDES],
            share: R::ZERO,
        };
        let mut total = R::ZERO;
        for (number, side) in self.sides.iter().enumerate() {
            let here = from.asked & is_inside::<R>(&side.room, from.position);
            if here.any() {
                seen.add(number, side, from, here, &mut total);
            }
        }
        let scale = (R::ONE / total).only(R::is_above(total, 0.0));
        for place in 0..seen.count {
            seen.chances[place] = seen.chances[place] * scale;
            seen.densities[place] = seen.densities[place] * scale;
            seen.share += seen.chances[place];
        }
        seen
    }
}

/// A mask of the points inside of a box.
#[inline(always)]
fn is_inside<R: Real>(room: &Aabb, point: R::Vec3) -> R::Mask {
    let within = |x: R, min: f32, max: f32| !(x.is_less(R::splat(min)) | R::is_above(x, max));
    let Aabb { min, max } = *room;
    within(point.x(), min.x, max.x) & within(point.y(), min.y, max.y) & within(point.z(), min.z, max.z)
}

impl<R: Real> Seen<'_, R> {
    /// Adds a portal where `here` holds, and its weight times its solid angle to `total`.
    #[inline(always)]
    fn add(&mut self, number: usize, side: &PortalSide, from: &Reference<R>, here: R::Mask, total: &mut R) {
        let rectangle = Same::<R>::same(side.rectangle);
        let view = rectangle.seen_from(from.position);
        let is_before = (view.above() * R::splat(side.side)).is_less(R::ZERO);
        let (nearest, middle) = rectangle.heights_over(from.position, from.normal);
        let is_above = R::is_above(nearest, 0.0) | !from.halved;
        let here = here & is_before & is_above & view.is_large() & view.is_apart(LEAST_HEIGHT);
        if !here.any() {
            return;
        }
        let cosine = R::select(from.halved, middle.max(R::splat(LEAST_COSINE)), R::ONE);
        let weight = (R::splat(side.weight) * cosine).only(here);
        let amount = (weight * view.solid_angle()).only(here);
        self.numbers[self.count] = number as u8;
        self.chances[self.count] = amount * R::splat(side.share);
        self.densities[self.count] = weight * R::splat(side.share);
        self.count += 1;
        *total += amount;
    }

    /// The probability that a portal is chosen.
    #[inline(always)]
    pub fn share(&self) -> R {
        self.share
    }

    /// Chooses portals by the first number, and directions through them.
    #[inline(always)]
    pub fn sample(&self, [u, v]: [R; 2]) -> Through<R> {
        let (mut is_chosen, mut below, mut within) = (R::Mask::NEVER, R::ZERO, R::ZERO);
        let mut chosen = Same::<R>::same(self.sides[0].rectangle);
        for place in 0..self.count {
            let above = below + self.chances[place];
            let here = u.is_less(above) & !is_chosen;
            if here.any() {
                let side = &self.sides[usize::from(self.numbers[place])];
                chosen = Rectangle::select(here, Same::<R>::same(side.rectangle), chosen);
                within = R::select(here, (u - below) / self.chances[place], within);
                is_chosen = is_chosen | here;
            }
            below = above;
        }
        let last = R::splat(ONE_MINUS_EPSILON);
        let mut wi = R::Vec3::even(R::ZERO);
        if is_chosen.any() {
            let view = chosen.seen_from(self.origin);
            wi = view.sample_offset([within.max(R::ZERO).min(last), v]).normalize();
        }
        let rest = (u - self.share) / (R::ONE - self.share);
        Through {
            is_chosen,
            wi,
            rest: rest.max(R::ZERO).min(last),
        }
    }

    /// The density per solid angle with which [`Self::sample`] chooses these directions through portals.
    #[inline(always)]
    pub fn pdf(&self, wi: R::Vec3) -> R {
        let mut pdf = R::ZERO;
        for place in 0..self.count {
            let side = &self.sides[usize::from(self.numbers[place])];
            let is_met = Same::<R>::same(side.rectangle).is_met(self.origin, wi);
            pdf += self.densities[place].only(is_met);
        }
        pdf
    }
}
