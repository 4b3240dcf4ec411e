//! What is selected: things of the scene in the order in which they were chosen.

use bevy::prelude::*;

/// The last one is the active one: panels show it, and pivots and alignments go by it.
#[derive(Resource, Clone, Debug, Default, PartialEq, Eq)]
pub struct Selection(Vec<Entity>);

/// How things join a selection.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Extend {
    /// They become the selection.
    #[default]
    Replace,
    Add,
    /// What was selected is so no more, and the other way round.
    Toggle,
}

impl Selection {
    pub fn of(entities: impl IntoIterator<Item = Entity>) -> Self {
        let mut selection = Self::default();
        selection.extend(entities, Extend::Add);
        selection
    }

    pub fn active(&self) -> Option<Entity> {
        self.0.last().copied()
    }

    pub fn entities(&self) -> &[Entity] {
        &self.0
    }

    pub fn contains(&self, entity: Entity) -> bool {
        self.0.contains(&entity)
    }

    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    pub fn extend(&mut self, entities: impl IntoIterator<Item = Entity>, how: Extend) {
        if how == Extend::Replace {
            self.0.clear();
        }
        for entity in entities {
            let was_selected = self.contains(entity);
            self.0.retain(|known| *known != entity);
            if !(was_selected && how == Extend::Toggle) {
                self.0.push(entity);
            }
        }
    }

    pub fn retain(&mut self, keep: impl FnMut(&Entity) -> bool) {
        self.0.retain(keep);
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
