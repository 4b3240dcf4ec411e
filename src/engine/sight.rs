//! The shapes that the camera sees exclusively and the walls that it sees through, as tables of the kernel.

use std::collections::HashSet;
use std::sync::Arc;

use bevy::prelude::Entity;

use crate::accel::{SplitMethod, Tlas};
use crate::render::visibility::outer_walls::OuterWalls;
use crate::render::visibility::sight::Isolated;

/// The last hierarchy over the shapes that are seen exclusively.
#[derive(Default)]
pub(super) struct SeenAlone {
    of: Option<(Arc<Tlas>, Vec<Entity>)>,
    shapes: Option<Isolated>,
}

impl SeenAlone {
    /// The hierarchy over the shapes of the entities `wanted`; None if there are none, and all shapes are visible.
    /// `entity_of_instance` has the entity of each instance and placement of `geometry`.
    pub fn update(
        &mut self,
        wanted: &[Entity],
        geometry: &Arc<Tlas>,
        entity_of_instance: &[Entity],
    ) -> Option<Isolated> {
        if wanted.is_empty() {
            *self = Self::default();
            return None;
        }
        let is_same = |(of, entities): &(Arc<Tlas>, Vec<Entity>)| Arc::ptr_eq(of, geometry) && entities == wanted;
        if !self.of.as_ref().is_some_and(is_same) {
            let entities: HashSet<Entity> = wanted.iter().copied().collect();
            let items = (0..).zip(entity_of_instance);
            let items: Vec<u32> = items
                .filter_map(|(item, entity)| entities.contains(entity).then_some(item))
                .collect();
            // Hidden and unloaded shapes are not in the tables: if all of these are missing, all shapes are shown.
            self.shapes = (!items.is_empty()).then(|| {
                let part = geometry.part(&items, SplitMethod::default());
                Isolated(Arc::new(part))
            });
            self.of = Some((geometry.clone(), wanted.to_vec()));
        }
        self.shapes.clone()
    }
}

/// The last outer walls found in the scene.
#[derive(Default)]
pub(crate) struct SeenThrough {
    of: Option<Arc<Tlas>>,
    walls: OuterWalls,
}

impl SeenThrough {
    /// The outer walls of `geometry` if they are `wanted`, otherwise none.
    pub fn update(&mut self, wanted: bool, geometry: &Arc<Tlas>) -> OuterWalls {
        if !wanted {
            *self = Self::default();
        } else if !self.of.as_ref().is_some_and(|of| Arc::ptr_eq(of, geometry)) {
            self.walls = OuterWalls::find(geometry);
            self.of = Some(geometry.clone());
        }
        self.walls.clone()
    }
}
