//! Divides shapes into those of the world and those of groups, and builds the hierarchy over all of them.

use std::sync::Arc;

use bevy::prelude::Entity;
use glam::Affine3;
use rayon::prelude::*;

use super::Checker;
use super::instance::InstanceRecord;
use crate::accel::{Instance, Instances, Placement, SplitMethod, Tlas};
use crate::light::Portal;

/// The placements of a group by one entity.
#[derive(Clone, Debug)]
pub(in crate::engine) struct PlacedGroup {
    pub entity: Entity,
    pub name: String,
    /// The index of the group among all groups.
    pub group: usize,
    pub places: Arc<Vec<Affine3>>,
}

/// The shapes of the world, and those of each group, for the hierarchy.
#[derive(Debug)]
pub(in crate::engine) struct PackedShapes {
    in_world: Instances,
    members: Vec<Vec<Instance>>,
}

/// All shapes, in the order in which [`Tlas::shape_index`] counts them.
#[derive(Clone, Debug, Default)]
pub(in crate::engine) struct Layout {
    /// The records of the shapes of the world, then of the members of each group.
    pub shapes: Vec<InstanceRecord>,
    pub in_world: usize,
    /// The number of members of each group.
    members: Vec<usize>,
    pub placed: Vec<PlacedGroup>,
    /// The portals of the shapes of the world; None if they have to be collected.
    portals: Option<Arc<[Portal]>>,
}

impl Layout {
    /// Divides the shapes of the world and of each group, in order, into the input of the hierarchy and the record of
    /// each, which is kept.
    pub fn new(
        in_world: (Instances, Vec<InstanceRecord>),
        members: Vec<(Vec<Instance>, Vec<InstanceRecord>)>,
        placed: Vec<PlacedGroup>,
    ) -> (Self, PackedShapes) {
        let (in_world, mut shapes) = in_world;
        let (members, records): (Vec<_>, Vec<_>) = members.into_iter().unzip();
        shapes.extend(records.into_iter().flatten());
        let layout = Self {
            in_world: in_world.len(),
            members: members.iter().map(Vec::len).collect(),
            shapes,
            placed,
            portals: None,
        };
        (layout, PackedShapes { in_world, members })
    }

    /// Whether each shape has moved or changed; true for all if the list differs.
    pub(crate) fn moved_since(&self, old: &Self) -> Vec<bool> {
        let same =
            |(i, record): (usize, &InstanceRecord)| old.shapes.get(i).is_some_and(|old| record.same_geometry(old));
        let numbered = self.shapes.iter().enumerate();
        let regrouped = self.in_world != old.in_world || self.members != old.members;
        numbered.map(|pair| regrouped || !same(pair)).collect()
    }

    /// Removes, replaces and inserts shapes of the world; the numbers are those of [`ShapeEdits`].
    pub(crate) fn edit(
        &mut self,
        removed: &[u32],
        replaced: Vec<(u32, InstanceRecord)>,
        inserted: Vec<(u32, InstanceRecord)>,
    ) {
        /// Up to this number of edits, moving all later entries is faster than making a new list.
        const FEW: usize = 8;
        let gone = removed.iter().chain(replaced.iter().map(|(number, _)| number));
        let old = gone.map(|&number| &self.shapes[number as usize]);
        let new = replaced.iter().chain(&inserted).map(|(_, record)| record);
        if old.chain(new).any(|record| !record.portals.is_empty()) {
            self.portals = None;
        }
        for (number, record) in replaced {
            self.shapes[number as usize] = record;
        }
        self.in_world = self.in_world - removed.len() + inserted.len();
        if removed.len() + inserted.len() <= FEW {
            for &number in removed.iter().rev() {
                self.shapes.remove(number as usize);
            }
            for (number, record) in inserted {
                self.shapes.insert(number as usize, record);
            }
            return;
        }
        let mut gone = removed.iter().peekable();
        let mut number = 0..;
        self.shapes
            .retain(|_| gone.next_if(|&&gone| Some(gone) == number.next()).is_none());
        let mut left = std::mem::take(&mut self.shapes).into_iter();
        let mut new = inserted.into_iter().peekable();
        let count = left.len() + new.len();
        self.shapes = (0..count as u32)
            .filter_map(|number| match new.next_if(|(at, _)| *at == number) {
                Some((_, record)) => Some(record),
                None => left.next(),
            })
            .collect();
    }

    /// The portals of the shapes of the world, in their order.
    pub fn portals(&mut self) -> Arc<[Portal]> {
        let in_world = &self.shapes[..self.in_world];
        let collect = || {
            in_world
                .iter()
                .flat_map(|record| record.portals.iter().copied())
                .collect()
        };
        self.portals.get_or_insert_with(collect).clone()
    }

    /// Whether the placements of every group are unchanged.
    pub(crate) fn placed_as(&self, old: &Self) -> bool {
        let same = |(a, b): (&PlacedGroup, &PlacedGroup)| {
            let places = Arc::ptr_eq(&a.places, &b.places) || a.places == b.places;
            (a.entity, a.group) == (b.entity, b.group) && places
        };
        self.placed.len() == old.placed.len() && self.placed.iter().zip(&old.placed).all(same)
    }

    /// Whether the shapes belong to the same entities.
    pub(crate) fn is_of_same_entities(&self, old: &Self) -> bool {
        let old = old.shapes.iter().map(|record| record.entity);
        self.shapes.iter().map(|record| record.entity).eq(old)
    }

    /// Whether the shape is a member of a group, which cannot emit light.
    pub(crate) fn is_member(&self, shape: usize) -> bool {
        shape >= self.in_world
    }

    /// Builds the hierarchy over all shapes, and returns the entity of each of its items. `instances` must come from
    /// the same [`Self::new`].
    pub fn build(&self, instances: PackedShapes, method: SplitMethod, errors: &mut Vec<String>) -> (Tlas, Vec<Entity>) {
        let members = instances.members.into_iter();
        let groups = members.map(|members| Arc::new(Tlas::group(members, method))).collect();
        let in_world = &self.shapes[..self.in_world];
        let mut entities: Vec<Entity> = in_world.iter().map(|record| record.entity).collect();
        let mut placements = Vec::new();
        for placed in &self.placed {
            let before = placements.len();
            let places = placed.places.par_iter();
            placements.par_extend(places.filter_map(|&place| Placement::new(placed.group as u32, &place.into())));
            let left_out = placed.places.len() - (placements.len() - before);
            if left_out > 0 {
                let name = &placed.name;
                let what = match placed.places.len() {
                    1 => "its transform cannot be inverted, the shape is left out".to_owned(),
                    _ => format!("the transforms of {left_out} cannot be inverted, they are left out"),
                };
                Checker { name, errors }.report(what);
            }
            entities.resize(in_world.len() + placements.len(), placed.entity);
        }
        (Tlas::over(instances.in_world, groups, placements, method), entities)
    }
}
