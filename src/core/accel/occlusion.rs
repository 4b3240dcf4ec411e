//! Tests whether shadow rays are blocked, and whether light may pass straight through all obstacles.
//!
//! Most shadow rays that meet a pane of glass meet a wall as well. The search for any hit therefore goes on behind
//! clear shapes, and only rays that meet nothing else have to be traced from one hit to the next. Shapes have the
//! numbers of [`Tlas::shape_index`].

use super::obstacle::{Obstacle, Obstacles};
use super::placement::Placement;
use super::ray_lanes::RayLanes;
use super::tlas::{Item, Tlas};
use crate::math::Ray;
use crate::math::lanes::each_lane;

/// The search for an opaque shape ends after this many clear ones: in a tree of leaves with holes it would go through
/// all of them.
const MOST_CLEAR: u32 = 4;

impl Tlas {
    /// Whether the ray hits any shape with t_min < t < t_max.
    pub fn occluded(&self, ray: &Ray) -> bool {
        self.obstacle(ray, |_| false) == Obstacle::Opaque
    }

    /// [`Self::occluded`] for each of the lanes in `active`, a bit per lane; all other bits are zero.
    pub fn occluded_lanes(&self, rays: &RayLanes, active: u32) -> u32 {
        if self.small_scene.is_none() && self.waits_for_memory {
            return self.occluded_interleaved(&rays.rays(), active & rays.valid_mask());
        }
        self.obstacles(rays, active, |_| false).opaque
    }

    /// The obstacle with t_min < t < t_max, where `is_clear` is true for shapes that light may pass straight through.
    /// Behind `MOST_CLEAR` clear shapes it may miss an opaque one.
    pub fn obstacle(&self, ray: &Ray, is_clear: impl Fn(usize) -> bool) -> Obstacle {
        self.obstacle_from(0, ray, &is_clear)
    }

    /// [`Self::obstacle`] for each of the lanes in `active`. In small scenes it does not miss an opaque shape behind
    /// many clear ones.
    pub fn obstacles(&self, rays: &RayLanes, active: u32, is_clear: impl Fn(usize) -> bool) -> Obstacles {
        let active = active & rays.valid_mask();
        if let Some(small) = &self.small_scene {
            return small.any::<false>(self.shapes(), rays, active, is_clear);
        }
        let asked = match self.waits_for_memory {
            true => self.occluded_interleaved(&rays.rays(), active),
            false => active,
        };
        let mut met = Obstacles::default();
        for lane in each_lane(asked) {
            met.add_lane(lane, self.obstacle(&rays.get(lane), &is_clear));
        }
        met
    }

    /// [`Self::obstacle`] where this hierarchy's first shape has the number `first`.
    fn obstacle_from(&self, first: usize, ray: &Ray, is_clear: &impl Fn(usize) -> bool) -> Obstacle {
        let (mut found, mut clear) = (Obstacle::Nothing, 0);
        self.bvh.any(ray, |range| {
            self.bvh.order()[range].iter().any(|&number| {
                let met = match self.item(number) {
                    Item::Shape(shape) if shape.occluded(ray) => Obstacle::of(is_clear(first + number as usize)),
                    Item::Shape(_) => Obstacle::Nothing,
                    Item::Placement(placement) => self.obstacle_placed(placement, ray, is_clear),
                    Item::Block(block, members) => block.obstacle(members, ray, |member| is_clear(first + member)),
                };
                if met != Obstacle::Nothing {
                    found = met;
                    clear += 1;
                }
                met == Obstacle::Opaque || clear == MOST_CLEAR
            })
        });
        found
    }

    #[inline(never)]
    pub(super) fn obstacle_placed(
        &self,
        placement: &Placement,
        ray: &Ray,
        is_clear: &impl Fn(usize) -> bool,
    ) -> Obstacle {
        let first = self.first_shape[placement.group as usize];
        self.group_of(placement)
            .obstacle_from(first, &placement.group_ray(ray), is_clear)
    }
}
