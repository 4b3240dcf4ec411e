//! Where sixteen paths have come to, as far as their surfaces are of the common kinds.

use crate::accel::{Detail, Hit, SurfacePoint};
use crate::material::PlainSide;
use crate::math::Ray;
use crate::math::lanes::{Lanes, Vec3Lanes};
use crate::render::scene::{RenderScene, SurfaceSlot};
use crate::shading::lanes::BsdfLanes;

/// Surfaces and their models; only the lanes of `lanes` mean something.
pub(super) struct Vertices {
    /// A bit per lane.
    pub lanes: u32,
    pub position: Vec3Lanes,
    /// As in [`SurfacePoint`].
    pub error: Lanes,
    pub geometric_normal: Vec3Lanes,
    pub shading_normal: Vec3Lanes,
    /// The side of the shading normal that the model is seen from: 1, or -1 from behind.
    pub side: Lanes,
    pub bsdf: BsdfLanes,
}

/// One of them.
pub(super) struct PlainVertex<'a> {
    pub point: SurfacePoint,
    pub made_of: PlainSide<'a>,
}

impl Vertices {
    pub fn new() -> Self {
        Self {
            lanes: 0,
            position: Vec3Lanes::ZERO,
            error: Lanes::ZERO,
            geometric_normal: Vec3Lanes::ZERO,
            shading_normal: Vec3Lanes::ZERO,
            side: Lanes::ONE,
            bsdf: BsdfLanes::new(),
        }
    }

    pub fn clear(&mut self) {
        self.lanes = 0;
        self.bsdf.clear();
    }

    /// The surface that `ray` has met at `hit`, if its model is one for lanes.
    #[inline(always)]
    pub fn plain<'a>(scene: &'a RenderScene, ray: &Ray, hit: &Hit, slot: &SurfaceSlot) -> Option<PlainVertex<'a>> {
        if !scene.materials.is_for_lanes(slot.material) {
            return None;
        }
        let point = scene.geometry.surface_in(ray, hit, Detail::Plain);
        let made_of = scene
            .materials
            .plain(slot.material, -point.shading_normal.dot(ray.dir))?;
        Some(PlainVertex { point, made_of })
    }

    #[inline(always)]
    pub fn set(&mut self, lane: usize, vertex: &PlainVertex) {
        self.lanes |= 1 << lane;
        self.position.set(lane, vertex.point.position);
        self.error.as_mut_array()[lane] = vertex.point.error;
        self.geometric_normal.set(lane, vertex.point.geometric_normal);
        self.shading_normal.set(lane, vertex.point.shading_normal);
        self.side.as_mut_array()[lane] = vertex.made_of.side;
        self.bsdf.set(lane, vertex.made_of.bsdf);
    }
}
