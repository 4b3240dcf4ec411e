//! Curves prepared for rays: a hierarchy over their segments.
//!
//! Thin segments fill little of their boxes, so they are cut into parts with boxes of their own, unless there are so
//! many that the hierarchy would be far larger than caches. A leaf holds the number of a segment's first control point
//! and of its part; control points stay in the order of the file.

use std::sync::Arc;

use glam::{DVec3, Vec3, Vec4};
use rayon::prelude::*;

use super::build::SplitMethod;
use super::bvh::{Bvh, BvhStats};
use super::collapse::NO_PRIMITIVE;
use super::hit::{CurveHit, Hit};
use super::traverse::TraversalStats;
use crate::geometry::curve::{Basis, CurveRay, Part, SegmentHit, Spline};
use crate::geometry::local::{LocalSurface, Parametrisation};
use crate::geometry::mesh::MeshData;
use crate::geometry::round_cone::RoundCone;
use crate::geometry::strands::{MOST_HALVINGS, Strands, halvings_of};
use crate::math::{Aabb, Ray};

/// The acceleration structure of the curves of one file, in their local space.
#[derive(Clone, Debug)]
pub struct CurveBlas {
    mesh: Arc<MeshData>,
    basis: Basis,
    /// The number of all segments.
    segments: usize,
    /// The hierarchy over parts. Its order holds [`Piece`]s.
    bvh: Bvh,
}

/// A part of a segment: the index of its first control point, followed by four bits with the part.
#[derive(Clone, Copy)]
struct Piece(u32);

impl Piece {
    const PART_BITS: u32 = 4;

    fn new(start: u32, part: Part) -> Self {
        Self(start << Self::PART_BITS | part.0)
    }

    fn start(self) -> u32 {
        self.0 >> Self::PART_BITS
    }

    fn part(self) -> Part {
        Part(self.0 & ((1 << Self::PART_BITS) - 1))
    }
}

/// The most parts in a leaf.
const LEAF_SIZE: usize = 1;
/// A part is halved if the boxes of its halves have together less than this share of its own surface.
const WORTH_HALVING: f32 = 0.8;

impl CurveBlas {
    /// Builds over the strands of `mesh`. B-splines of fewer than four points have no segments.
    pub fn build(mesh: Arc<MeshData>, basis: Basis, method: SplitMethod) -> Self {
        let mut curves = Self {
            segments: mesh.strands.segment_count(basis),
            mesh,
            basis,
            bvh: Bvh::build(&[], method, LEAF_SIZE),
        };
        let starts: Vec<u32> = curves.strands().segments(basis).collect();
        let halvings = halvings_of(curves.segments);
        let of_segment = |&start: &u32| curves.pieces(start, halvings);
        let pieces: Vec<Piece> = starts.par_iter().flat_map_iter(of_segment).collect();
        let bounds = |index: usize| curves.bounds_of(pieces[index]);
        let mut bvh = Bvh::over(pieces.len(), bounds, None, method, LEAF_SIZE);
        for entry in bvh.order.iter_mut().filter(|entry| **entry != NO_PRIMITIVE) {
            *entry = pieces[*entry as usize].0;
        }
        curves.bvh = bvh;
        curves
    }

    /// The parts of a segment, which is halved up to `halvings` times.
    fn pieces(&self, start: u32, halvings: u32) -> impl Iterator<Item = Piece> + use<> {
        let mut pieces = arrayvec::ArrayVec::<Piece, { 1 << MOST_HALVINGS }>::new();
        match self.basis {
            Basis::Linear => pieces.push(Piece::new(start, Part::WHOLE)),
            Basis::BSpline => {
                let spline = self.spline(start);
                divide(&spline, Part::WHOLE, halvings, &mut |part| {
                    pieces.push(Piece::new(start, part))
                });
            }
        }
        pieces.into_iter()
    }

    /// The mesh whose strands the curves are.
    pub fn mesh(&self) -> &Arc<MeshData> {
        &self.mesh
    }

    #[inline(always)]
    fn strands(&self) -> &Strands {
        &self.mesh.strands
    }

    #[inline(always)]
    fn control_points<const N: usize>(&self, start: u32) -> [Vec4; N] {
        let points = &self.strands().points[start as usize..];
        std::array::from_fn(|index| points[index])
    }

    #[inline(always)]
    fn spline(&self, start: u32) -> Spline {
        Spline::new(self.control_points(start))
    }

    fn cone(&self, start: u32) -> RoundCone {
        RoundCone::new(self.control_points(start))
    }

    fn bounds_of(&self, piece: Piece) -> Aabb {
        match self.basis {
            Basis::BSpline => self.spline(piece.start()).bounds(piece.part()),
            Basis::Linear => RoundCone::bounds(self.control_points(piece.start())),
        }
    }

    /// The local bounds of all curves.
    pub fn bounds(&self) -> Aabb {
        self.bvh.bounds()
    }

    /// The hierarchy over the parts of segments.
    pub fn bvh(&self) -> &Bvh {
        &self.bvh
    }

    /// Statistics of the hierarchy; `bytes` is without the control points.
    pub fn stats(&self) -> BvhStats {
        self.bvh.stats()
    }

    /// The memory of the hierarchy in bytes.
    pub(super) fn bytes(&self) -> usize {
        self.bvh.bytes()
    }

    /// The number of all segments.
    pub fn segments(&self) -> usize {
        self.segments
    }

    /// Lines along the middle of the curves, for display. Of curves with more than `most` segments some are left out.
    pub fn center_lines(&self, most: usize) -> Vec<[Vec3; 2]> {
        let step = self.segments.div_ceil(most.max(1)).max(1);
        let starts = self.strands().segments(self.basis).step_by(step);
        starts
            .map(|start| match self.basis {
                Basis::BSpline => self.spline(start).ends(),
                Basis::Linear => self.control_points::<2>(start).map(|point| point.truncate()),
            })
            .collect()
    }

    /// The nearest hit with t_min < t < t_max; `ray` is in local space.
    pub fn intersect(&self, ray: &Ray) -> Option<CurveHit> {
        self.closest::<false>(ray, &mut TraversalStats::default())
    }

    #[inline(never)]
    pub(super) fn closest<const COUNT: bool>(&self, ray: &Ray, stats: &mut TraversalStats) -> Option<CurveHit> {
        let prepared = CurveRay::new(ray)?;
        let mut nearest = None;
        self.bvh.closest::<COUNT>(ray, stats, |leaf, t_max| {
            for &piece in &self.bvh.order[leaf] {
                if let Some((start, hit)) = self.meet(piece, &prepared, *t_max) {
                    *t_max = hit.t;
                    let SegmentHit { t, u, v } = hit;
                    nearest = Some(CurveHit { t, start, u, v });
                }
            }
        });
        nearest
    }

    /// Whether a local ray hits any curve.
    #[inline(never)]
    pub fn occluded(&self, ray: &Ray) -> bool {
        let Some(prepared) = CurveRay::new(ray) else {
            return false;
        };
        // From near to far: the first curves of dense hair hide the others.
        let mut is_met = false;
        let mut stats = TraversalStats::default();
        self.bvh.closest::<false>(ray, &mut stats, |leaf, t_max| {
            let mut pieces = self.bvh.order[leaf].iter();
            if pieces.any(|&piece| self.meet(piece, &prepared, *t_max).is_some()) {
                is_met = true;
                // Nothing is as near.
                *t_max = f32::NEG_INFINITY;
            }
        });
        is_met
    }

    /// The hit of a piece in the order of the leaves, with the first control point of its segment.
    #[inline(always)]
    fn meet(&self, piece: u32, ray: &CurveRay, t_max: f32) -> Option<(u32, SegmentHit)> {
        if piece == NO_PRIMITIVE {
            return None;
        }
        let piece = Piece(piece);
        let start = piece.start();
        let hit = match self.basis {
            Basis::BSpline => self.spline(start).intersect(piece.part(), ray, t_max)?,
            Basis::Linear => {
                let (hit, place) = self
                    .cone(start)
                    .intersect(ray, t_max, || self.strands().is_first(start))?;
                if self.is_joined(start, hit.v < 0.5, place) {
                    return None;
                }
                hit
            }
        };
        Some((start, hit))
    }

    /// Whether a place on the linear segment that begins with the point `start` is within the segment before or after
    /// it, so that it is no part of the surface.
    fn is_joined(&self, start: u32, at_begin: bool, place: DVec3) -> bool {
        let strands = self.strands();
        let next = start + 1;
        let neighbour = match at_begin {
            true => (!strands.is_first(start)).then(|| start - 1),
            false => (next as usize + 1 < strands.points.len() && !strands.is_first(next + 1)).then_some(next),
        };
        neighbour.is_some_and(|neighbour| self.cone(neighbour).holds(place))
    }

    /// The surface at a hit of the local `ray`.
    pub(super) fn surface(&self, ray: &Ray, hit: &Hit) -> LocalSurface {
        match self.basis {
            Basis::BSpline => self.spline(hit.primitive).surface(hit.u, hit.v),
            Basis::Linear => self.cone(hit.primitive).surface(ray, hit.t, hit.v),
        }
    }

    /// The parametrisation at a hit of the local `ray`: u is the angle in turns, v the number of the segment and the
    /// place on it over the number of all segments. `up`: see [`Spline::parametrisation`].
    pub(super) fn parametrisation(&self, ray: &Ray, hit: &Hit, up: Vec3) -> Parametrisation {
        let place = [self.strands().segment_number(hit.primitive, self.basis), self.segments];
        match self.basis {
            Basis::BSpline => self.spline(hit.primitive).parametrisation([hit.u, hit.v], place, up),
            Basis::Linear => self.cone(hit.primitive).parametrisation((ray, hit.t, hit.v), place, up),
        }
    }
}

/// Calls `found` with the parts into which a part is cut, which is halved up to `halvings` times.
fn divide(spline: &Spline, part: Part, halvings: u32, found: &mut impl FnMut(Part)) {
    let halves = part.halves();
    let area = |part| spline.bounds(part).half_area();
    let is_worth = halvings > 0 && halves.map(area).iter().sum::<f32>() < WORTH_HALVING * area(part);
    match is_worth {
        true => halves
            .into_iter()
            .for_each(|half| divide(spline, half, halvings - 1, found)),
        false => found(part),
    }
}
