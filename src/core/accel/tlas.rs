//! The hierarchy over all shapes in the world, against which the integrator traces rays.

use std::cell::Cell;
use std::collections::HashMap;
use std::sync::Arc;

use super::build::SplitMethod;
use super::bvh::{Bvh, BvhStats};
use super::edited_part::{EditedPart, FEWEST_EDITED};
use super::hit::Hit;
use super::instance::{Instance, Primitive};
use super::instances::Instances;
use super::memory::{CACHE, SHARED_CACHE};
use super::placement::Placement;
use super::ray_lanes::RayLanes;
use super::shape_block::{Members, ShapeBlock};
use super::shape_blocks::ShapeBlocks;
use super::small_scene::{MOST_ALONE, Shapes, SmallScene};
use super::traverse::TraversalStats;
use crate::math::lanes::{LANES, each_lane};
use crate::math::{Aabb, Ray};

/// The shapes of a scene and its groups of shapes, which are placed many times, with a hierarchy over their world
/// bounds.
///
/// A group is itself a `Tlas` without groups, in its own space, shared by all its placements.
#[derive(Clone, Debug)]
pub struct Tlas {
    pub(super) instances: Instances,
    pub(super) groups: Vec<Arc<Tlas>>,
    /// The number of shapes before the first member of each group.
    pub(super) first_shape: Vec<usize>,
    pub(super) placements: Vec<Placement>,
    pub(super) blocks: ShapeBlocks,
    /// The hierarchy over items, which are numbered instances first (those in blocks are left out), then placements,
    /// then blocks.
    pub(super) bvh: Bvh,
    /// The order in which sixteen rays are tested against the shapes, in scenes that [`SmallScene`] takes.
    pub(super) small_scene: Option<SmallScene>,
    /// Whether the hierarchies, with those of all meshes and groups, are too large for the cache of a core.
    pub(super) is_large: bool,
    /// Whether they are too large for the cache that cores share. Rays are then interleaved.
    pub(super) waits_for_memory: bool,
    /// Whether any mesh has vertex normals that are used.
    pub(super) has_vertex_normals: bool,
    /// The edits since the hierarchy was built; None before the first.
    pub(super) edited: Option<EditedPart>,
}

/// An item that a leaf of the hierarchy holds.
pub(super) enum Item<'a> {
    Shape(&'a Instance),
    Placement(&'a Placement),
    Block(&'a ShapeBlock, &'a Members),
}

impl Tlas {
    /// Builds over shapes, without groups.
    pub fn build(instances: Vec<Instance>, method: SplitMethod) -> Self {
        Self::with_placements(instances, Vec::new(), Vec::new(), method)
    }

    /// Builds over shapes and placed groups. A placement of a group that does not exist, or that has placements itself,
    /// is empty.
    pub fn with_placements(
        instances: Vec<Instance>,
        groups: Vec<Arc<Tlas>>,
        placements: Vec<Placement>,
        method: SplitMethod,
    ) -> Self {
        Self::over(instances.into(), groups, placements, method)
    }

    /// Builds over the shapes of a group, which rays enter one by one.
    pub fn group(instances: Vec<Instance>, method: SplitMethod) -> Self {
        Self::made(instances.into(), Vec::new(), Vec::new(), method, false)
    }

    /// [`Self::with_placements`] over shapes that need not be copied.
    pub fn over(instances: Instances, groups: Vec<Arc<Tlas>>, placements: Vec<Placement>, method: SplitMethod) -> Self {
        // With `Linear` the caller wants a list, so that only a short one is a small scene. Scenes of `FEWEST_EDITED`
        // shapes or more are edited in place, which a small scene cannot follow.
        let is_list = method == SplitMethod::Linear && instances.len() > MOST_ALONE;
        let may_be_small = placements.is_empty() && !is_list && instances.len() < FEWEST_EDITED;
        Self::made(instances, groups, placements, method, may_be_small)
    }

    fn made(
        instances: Instances,
        groups: Vec<Arc<Tlas>>,
        placements: Vec<Placement>,
        method: SplitMethod,
        may_be_small: bool,
    ) -> Self {
        let instances = instances.made_anew();
        let mut shapes = instances.len();
        let first_shape = groups
            .iter()
            .map(|group| {
                let first = shapes;
                shapes += group.instances.len();
                first
            })
            .collect();
        let blocks: ShapeBlocks = ShapeBlock::gather(&instances, method).into();
        let small_scene = may_be_small
            .then(|| {
                SmallScene::new(Shapes {
                    instances: instances.made(),
                    blocks: blocks.made(),
                })
            })
            .flatten();
        let has_vertex_normals = groups.iter().any(|group| group.has_vertex_normals)
            || instances.iter().any(|shape| shape.with_vertex_normals().is_some());
        let mut tlas = Self {
            instances,
            groups,
            first_shape,
            placements,
            blocks,
            bvh: Bvh::build(&[], method, LEAF_SIZE),
            small_scene,
            is_large: false,
            waits_for_memory: false,
            has_vertex_normals,
            edited: None,
        };
        let in_block = tlas.in_block();
        let bounds = |number: usize| tlas.item_bounds(number as u32, in_block.get(number) == Some(&true));
        tlas.bvh = Bvh::over(tlas.item_count(), bounds, None, method, LEAF_SIZE);
        let bytes = tlas.bytes();
        (tlas.is_large, tlas.waits_for_memory) = (bytes > CACHE, bytes > SHARED_CACHE);
        tlas
    }

    /// A hierarchy over some of the shapes and placements, given by [`Hit::instance`] in ascending order, which get new
    /// numbers from 0 on. Numbers beyond the last are ignored.
    pub fn part(&self, items: &[u32], method: SplitMethod) -> Self {
        let items = items.iter().map(|item| *item as usize);
        let instances: Vec<Instance> = (items.clone())
            .filter_map(|item| self.instances.get(item).cloned())
            .collect();
        let placements: Vec<Placement> = items
            .filter_map(|item| self.placements.get(item.checked_sub(self.instances.len())?).copied())
            .collect();
        let groups = match placements.is_empty() {
            true => Vec::new(),
            false => self.groups.clone(),
        };
        Self::with_placements(instances, groups, placements, method)
    }

    /// The shapes outside groups, by [`Hit::instance`].
    pub fn instances(&self) -> &Instances {
        &self.instances
    }

    /// The hierarchies of the groups that are placed.
    pub fn groups(&self) -> &[Arc<Tlas>] {
        &self.groups
    }

    /// The placements of the groups.
    pub fn placements(&self) -> &[Placement] {
        &self.placements
    }

    pub(super) fn shapes(&self) -> Shapes<'_> {
        Shapes {
            instances: self.instances.made(),
            blocks: self.blocks.made(),
        }
    }

    /// The hierarchy over instances and placements.
    pub fn bvh(&self) -> &Bvh {
        &self.bvh
    }

    /// World bounds of all shapes; empty if there is none.
    pub fn bounds(&self) -> Aabb {
        self.bvh.bounds()
    }

    /// The number of triangles of all meshes; those of a group count once per placement.
    pub fn triangles(&self) -> u64 {
        let of_shape = |instance: &Instance| match &instance.primitive {
            Primitive::Mesh(blas) => blas.mesh().triangles.len() as u64,
            _ => 0,
        };
        let of_groups: Vec<u64> = self.groups.iter().map(|group| group.triangles()).collect();
        let placed = self
            .placements
            .iter()
            .filter_map(|placement| of_groups.get(placement.group as usize));
        self.instances.iter().map(of_shape).sum::<u64>() + placed.sum::<u64>()
    }

    /// The world bounds of the instance or placement that [`Hit::instance`] names.
    pub fn bounds_of(&self, item: u32) -> Option<Aabb> {
        let item = item as usize;
        match item.checked_sub(self.instances.len()) {
            None => self.instances.get(item).map(Instance::world_bounds),
            Some(place) => self
                .placements
                .get(place)
                .map(|placement| self.placed_bounds(placement)),
        }
    }

    /// [`bounds_of`](Self::bounds_of) without the margin for rounding, for display and measurement. A group of very
    /// many shapes keeps its margin.
    pub fn exact_bounds_of(&self, item: u32) -> Option<Aabb> {
        /// A placement of more shapes than this keeps its margin.
        const MANY: usize = 256;
        let item = item as usize;
        let Some(place) = item.checked_sub(self.instances.len()) else {
            return self.instances.get(item).map(Instance::exact_bounds);
        };
        let placement = self.placements.get(place)?;
        let group = self.groups.get(placement.group as usize);
        let Some(group) = group.filter(|group| group.placements.is_empty() && group.instances.len() <= MANY) else {
            return Some(self.placed_bounds(placement));
        };
        let members = group.instances.iter().map(Instance::exact_bounds);
        Some(placement.exact_bounds(&members.fold(Aabb::EMPTY, Aabb::union)))
    }

    /// World bounds of all instances and placements but `left_out`, which are numbers of [`Hit::instance`], ascending;
    /// empty if there are no others.
    pub fn bounds_without(&self, left_out: &[u32]) -> Aabb {
        let found = Cell::new(Aabb::EMPTY);
        let add = |number: u32, bounds: Aabb| {
            if left_out.binary_search(&number).is_err() {
                found.set(found.get().union(bounds));
            }
        };
        // Shapes within the bounds of others do not change them.
        let is_outside = |bounds: &Aabb| {
            let found = found.get();
            bounds.min.cmplt(found.min).any() || bounds.max.cmpgt(found.max).any()
        };
        self.bvh.any_item(is_outside, |number| {
            match self.item(number) {
                Item::Shape(shape) => add(number, shape.world_bounds()),
                Item::Placement(placement) => add(number, self.placed_bounds(placement)),
                Item::Block(_, members) => (members.indices().iter())
                    .for_each(|&member| add(member, self.instances[member as usize].world_bounds())),
            }
            false
        });
        found.get()
    }

    fn placed_bounds(&self, placement: &Placement) -> Aabb {
        let group = self.groups.get(placement.group as usize);
        let flat = group.filter(|group| group.placements.is_empty());
        placement.world_bounds(&flat.map_or(Aabb::EMPTY, |group| group.bounds()))
    }

    /// Whether each instance is in a block.
    fn in_block(&self) -> Vec<bool> {
        let mut in_block = vec![false; self.instances.len()];
        for &member in self.blocks.members().iter().flat_map(Members::indices) {
            in_block[member as usize] = true;
        }
        in_block
    }

    fn item_count(&self) -> usize {
        self.instances.len() + self.placements.len() + self.blocks.len()
    }

    /// The world bounds of an item of the hierarchy. An instance that is in a block has empty bounds.
    pub(super) fn item_bounds(&self, number: u32, in_block: bool) -> Aabb {
        match self.item(number) {
            Item::Shape(_) if in_block => Aabb::EMPTY,
            Item::Shape(shape) => shape.world_bounds(),
            Item::Placement(placement) => self.placed_bounds(placement),
            Item::Block(block, _) => block.bounds,
        }
    }

    #[inline(always)]
    pub(super) fn item(&self, number: u32) -> Item<'_> {
        let number = number as usize;
        if let Some(shape) = self.instances.get(number) {
            return Item::Shape(shape);
        }
        let beyond = number - self.instances.len();
        match self.placements.get(beyond) {
            Some(placement) => Item::Placement(placement),
            None => {
                let (block, members) = self.blocks.get(beyond - self.placements.len());
                Item::Block(block, members)
            }
        }
    }

    /// The shape that was hit: an instance, or a member of a placed group.
    #[inline(always)]
    pub fn shape_at(&self, hit: &Hit) -> &Instance {
        match self.instances.get(hit.instance as usize) {
            Some(shape) => shape,
            None => self.member_at(hit),
        }
    }

    #[inline(never)]
    fn member_at(&self, hit: &Hit) -> &Instance {
        let place = hit.instance as usize - self.instances.len();
        &self.group_of(&self.placements[place]).instances[hit.member as usize]
    }

    /// The number of the shape that was hit: instances come first, then the members of each group.
    pub fn shape_index(&self, hit: &Hit) -> usize {
        match self.placement_at(hit) {
            Some(placement) => self.first_shape[placement.group as usize] + hit.member as usize,
            None => hit.instance as usize,
        }
    }

    pub(super) fn placement_at(&self, hit: &Hit) -> Option<&Placement> {
        let place = (hit.instance as usize).checked_sub(self.instances.len())?;
        Some(&self.placements[place])
    }

    #[inline(always)]
    pub(super) fn group_of(&self, placement: &Placement) -> &Tlas {
        &self.groups[placement.group as usize]
    }

    /// The memory of all hierarchies in bytes. A mesh that is in several groups is counted in each.
    pub fn bytes(&self) -> usize {
        let meshes: HashMap<*const (), usize> = self
            .instances
            .iter()
            .filter_map(|instance| match &instance.primitive {
                Primitive::Mesh(blas) => Some((Arc::as_ptr(blas).cast(), blas.bytes())),
                Primitive::Curves(curves) => Some((Arc::as_ptr(curves).cast(), curves.bytes())),
                _ => None,
            })
            .collect();
        let own = self.bvh.bytes() + self.instances.len() * size_of::<Instance>() + self.blocks.bytes();
        own + meshes.values().sum::<usize>() + self.groups.iter().map(|group| group.bytes()).sum::<usize>()
    }

    /// Statistics of the hierarchy over instances and placements, without those of groups and meshes. `bytes` includes
    /// the placements and blocks.
    pub fn stats(&self) -> BvhStats {
        let mut stats = self.bvh.stats();
        stats.bytes += size_of_val(self.placements.as_slice()) + self.blocks.bytes();
        stats
    }

    /// [`Bvh::validate`] against the bounds of instances, placements and blocks.
    pub fn validate(&self) -> Result<(), String> {
        let in_block = self.in_block();
        let bounds: Vec<Aabb> = (0..self.item_count())
            .map(|number| self.item_bounds(number as u32, in_block.get(number) == Some(&true)))
            .collect();
        self.bvh.validate(&bounds)
    }

    /// Whether `is_sought` is true for any instance or placement whose world bounds touch a box. It gets the number, as
    /// in [`Hit::instance`], and the bounds.
    pub fn any_touching(&self, sought: &Aabb, mut is_sought: impl FnMut(u32, &Aabb) -> bool) -> bool {
        let touches = |bounds: &Aabb| bounds.min.cmple(sought.max).all() && bounds.max.cmpge(sought.min).all();
        let mut is_found = |number: u32, bounds: Aabb| touches(&bounds) && is_sought(number, &bounds);
        self.bvh.any_item(touches, |number| match self.item(number) {
            Item::Shape(shape) => is_found(number, shape.world_bounds()),
            Item::Placement(placement) => is_found(number, self.placed_bounds(placement)),
            Item::Block(_, members) => (members.indices().iter())
                .any(|&member| is_found(member, self.instances[member as usize].world_bounds())),
        })
    }

    /// The nearest hit with t_min < t < t_max.
    pub fn intersect(&self, ray: &Ray) -> Option<Hit> {
        self.closest::<false>(ray, &mut TraversalStats::default())
    }

    /// [`Tlas::intersect`], adding its work at every level to `stats`.
    pub fn intersect_counting(&self, ray: &Ray, stats: &mut TraversalStats) -> Option<Hit> {
        self.closest::<true>(ray, stats)
    }

    fn closest<const COUNT: bool>(&self, ray: &Ray, stats: &mut TraversalStats) -> Option<Hit> {
        let mut nearest = None;
        let mut inner = TraversalStats::default();
        self.bvh.closest::<COUNT>(ray, stats, |range, t_max| {
            for &number in &self.bvh.order()[range] {
                let ray = Ray { t_max: *t_max, ..*ray };
                let found = match self.item(number) {
                    Item::Shape(shape) => shape.closest::<COUNT>(number, &ray, &mut inner),
                    Item::Placement(placement) => self.closest_placed::<COUNT>(number, placement, &ray, &mut inner),
                    Item::Block(block, members) => {
                        if COUNT {
                            inner.primitives += members.indices().len() as u32 - 1;
                        }
                        block.closest(members, &ray)
                    }
                };
                if let Some(hit) = found {
                    *t_max = hit.t;
                    nearest = Some(hit);
                }
            }
        });
        *stats += inner;
        nearest
    }

    /// Kept out of line, because most scenes have no groups, and their rays should not carry the stack of a second
    /// traversal.
    #[inline(never)]
    pub(super) fn closest_placed<const COUNT: bool>(
        &self,
        number: u32,
        placement: &Placement,
        ray: &Ray,
        stats: &mut TraversalStats,
    ) -> Option<Hit> {
        let hit = self
            .group_of(placement)
            .closest::<COUNT>(&placement.group_ray(ray), stats)?;
        Some(Hit {
            instance: number,
            member: hit.instance,
            ..hit
        })
    }

    /// [`Self::intersect`] for each of the lanes in `active`; None in the others. The normals are prefetched, since
    /// callers look them up next.
    pub fn intersect_lanes(&self, rays: &RayLanes, active: u32) -> [Option<Hit>; LANES] {
        let active = active & rays.valid_mask();
        let hits = if let Some(small) = &self.small_scene {
            small.closest::<false>(self.shapes(), rays, active)
        } else if self.waits_for_memory {
            self.intersect_interleaved(&rays.rays(), active)
        } else {
            let mut hits = [None; LANES];
            for lane in each_lane(active) {
                hits[lane] = self.intersect(&rays.get(lane));
            }
            hits
        };
        self.prefetch_normals(&hits);
        hits
    }
}

/// The most items in a leaf: an instance costs much more to test than a box.
pub(super) const LEAF_SIZE: usize = 1;
