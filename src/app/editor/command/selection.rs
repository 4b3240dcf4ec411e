//! The selection: things of the scene in the order of selecting.

use super::traits::Traits;

use bevy::ecs::entity::EntityHashSet;
use bevy::prelude::*;

/// The last thing is the active one: panels show it, and pivots and alignments use it.
#[derive(Resource, Clone, Debug, Default, PartialEq, Eq)]
pub struct Selection {
    order: Vec<Entity>,
    /// The entities of `order` as a set, to find out quickly whether it holds one.
    all: EntityHashSet,
}

/// The effect of selecting things on the selection.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Extend {
    /// They replace the selection.
    #[default]
    Replace,
    /// They join the selection.
    Add,
    /// Selected ones are deselected, and the others are selected.
    Toggle,
}

impl Selection {
    /// A selection of the entities in this order; duplicates count once.
    pub fn of(entities: impl IntoIterator<Item = Entity>) -> Self {
        let mut selection = Self::default();
        selection.extend(entities, Extend::Add);
        selection
    }

    /// The entity that was selected last.
    pub fn active(&self) -> Option<Entity> {
        self.order.last().copied()
    }

    /// The selected entities, the active one last.
    pub fn entities(&self) -> &[Entity] {
        &self.order
    }

    /// Whether an entity is selected.
    pub fn contains(&self, entity: Entity) -> bool {
        self.all.contains(&entity)
    }

    /// Whether nothing is selected.
    pub fn is_empty(&self) -> bool {
        self.order.is_empty()
    }

    /// Adds entities in this order, so that the last selected one becomes active.
    pub fn extend(&mut self, entities: impl IntoIterator<Item = Entity>, how: Extend) {
        if how == Extend::Replace {
            *self = Self::default();
        }
        let mut joining = Vec::new();
        let mut moved = EntityHashSet::new();
        for entity in entities {
            if moved.insert(entity) && !(how == Extend::Toggle && self.all.contains(&entity)) {
                joining.push(entity);
            }
        }
        // A selected thing that is added again becomes the active one.
        if !self.order.is_empty() {
            self.order.retain(|entity| !moved.contains(entity));
        }
        self.order.extend(joining);
        self.all = self.order.iter().copied().collect();
    }

    /// Drops the entities for which `keep` is false.
    pub fn retain(&mut self, keep: impl FnMut(&Entity) -> bool) {
        self.order.retain(keep);
        self.all = self.order.iter().copied().collect();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_last_chosen_is_active() {
        let mut world = World::new();
        let [a, b] = [world.spawn_empty().id(), world.spawn_empty().id()];
        let mut selection = Selection::of([a, b]);
        selection.extend([a], Extend::Add);
        assert_eq!(selection.entities(), [b, a]);
        selection.extend([a], Extend::Toggle);
        assert_eq!((selection.active(), selection.contains(a)), (Some(b), false));
        selection.extend([a], Extend::Replace);
        assert_eq!(selection.entities(), [a]);
    }
}

/// The property in which things are equal.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Alike {
    /// The material.
    Material,
    /// The kind of shape or light.
    Type,
}

/// A command about the selection.
#[derive(Clone, Debug, PartialEq)]
pub enum SelectionCommand {
    /// Selects things of the scene, which need not be visible.
    Select(Vec<Entity>, Extend),
    /// Selects everything that the outliner shows.
    SelectAll,
    /// Selects the visible thing at a point of the picture. (0, 0) is its top left corner, (1, 1) its bottom right one.
    Pick(Vec2, Extend),
    /// Selects everything in the group around the active thing. Repeated, it selects everything in the next group
    /// outwards.
    SelectGroup,
    /// Selects everything that has the material of a selected shape, or is of the kind of a selected thing.
    SelectAlike(Alike),
    /// Copies the selection to the clipboard, as XML text.
    Copy,
}

impl SelectionCommand {
    pub(super) fn traits(&self) -> Traits {
        match self {
            Self::Select(..)
            | Self::SelectAll
            | Self::Pick(..)
            | Self::SelectGroup
            | Self::SelectAlike(_)
            | Self::Copy => Traits::NONE,
        }
    }
}
