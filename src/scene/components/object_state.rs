//! The state of one entity as one value: an edit keeps it for undo, and a reload compares it.
//!
//! Handles of meshes and pictures are not part of it (they follow the components that name files), nor is
//! [`crate::scene::Authored`]: the source in the file is not edited.

use std::mem::discriminant;

use bevy::prelude::*;

use super::carry_over::{Vectors, carry_over};
use crate::scene::{
    AreaLight, Authored, DeclaredIn, DocumentOrder, Emitter, EulerAngles, ExteriorMedium, Film, FirstNested, Hidden,
    InMedium, InstanceOf, InteriorMedium, Keys, Locked, Material, Medium, MemberOf, Placements, Properties, SceneId,
    SecondNested, Sensor, Shape, ShapeGroup, ToWorld, UsesMaterial,
};

macro_rules! object_state {
    ($($field:ident: $component:ident,)*) => {
        /// The components of an entity; None if absent. All None: the entity is not (or no longer) in the scene.
        #[derive(Clone, Debug, Default, PartialEq)]
        pub(crate) struct ObjectState {
            $(pub $field: Option<$component>,)*
        }

        impl ObjectState {
            /// The state of an entity; empty if it does not exist.
            pub fn of(world: &World, entity: Entity) -> Self {
                let Ok(entity) = world.get_entity(entity) else {
                    return Self::default();
                };
                Self {
                    $($field: entity.get::<$component>().cloned(),)*
                }
            }

            /// Gives the entity exactly these components; writes only those that differ.
            pub fn write(&self, world: &mut World, entity: Entity) {
                $(write_component(world, entity, &self.$field);)*
            }

            /// Gives a new entity these components and its source in the file. Most are inserted together, because each
            /// insertion moves the entity.
            pub fn write_new(mut self, world: &mut World, entity: Entity, authored: Option<Authored>) {
                let Ok(mut new) = world.get_entity_mut(entity) else {
                    return;
                };
                if let (Some(shape), Some(pose), Some(order), Some(name)) =
                    (&self.shape, self.to_world, self.order, &self.name)
                {
                    let common = (shape.clone(), pose, order, name.clone());
                    match (self.id.take(), authored) {
                        (Some(id), Some(authored)) => new.insert((common, id, authored)),
                        (Some(id), None) => new.insert((common, id)),
                        (None, Some(authored)) => new.insert((common, authored)),
                        (None, None) => new.insert(common),
                    };
                    (self.shape, self.to_world, self.order, self.name) = (None, None, None, None);
                } else if let Some(authored) = authored {
                    new.insert(authored);
                }
                $(
                    if let Some(value) = self.$field {
                        new.insert(value);
                    }
                )*
            }

            /// Three-way merge: changes from `base` to `theirs` are applied, otherwise `ours` stays. Our side began as
            /// `start`, which may be spelled otherwise than `base` and mean the same.
            fn merged_parts(base: &Self, theirs: &Self, start: &Self, ours: &Self) -> Merged {
                let mut merged = Merged {
                    state: ours.clone(),
                    ..Merged::default()
                };
                $(
                    if theirs.$field != base.$field {
                        merged.replaced |= ours.$field != start.$field && ours.$field != theirs.$field;
                        merged.state.$field.clone_from(&theirs.$field);
                    } else {
                        merged.kept |= ours.$field != start.$field;
                    }
                )*
                merged
            }
        }
    };
}

/// Calls a macro with the list of components.
macro_rules! with_components {
    ($macro:ident) => {
        $macro! {
            order: DocumentOrder,
            id: SceneId,
            name: Name,
            to_world: ToWorld,
            angles: EulerAngles,
            shape: Shape,
            material: Material,
            medium: Medium,
            emitter: Emitter,
            sensor: Sensor,
            film: Film,
            group: ShapeGroup,
            uses: UsesMaterial,
            area_light: AreaLight,
            first: FirstNested,
            second: SecondNested,
            interior: InteriorMedium,
            exterior: ExteriorMedium,
            in_medium: InMedium,
            declared_in: DeclaredIn,
            member_of: MemberOf,
            instance_of: InstanceOf,
            placements: Placements,
            keys: Keys,
            properties: Properties,
            hidden: Hidden,
            locked: Locked,
        }
    };
}
pub(in crate::scene) use with_components;

with_components!(object_state);

/// The result of a three-way merge.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Merged {
    pub state: ObjectState,
    /// Whether an edit of the editor was kept that the file lacks.
    pub kept: bool,
    /// Whether both sides edited a value, so that the file's was taken.
    pub replaced: bool,
}

impl ObjectState {
    /// Three-way merge: changes from `base` to `theirs` are applied, otherwise `ours` stays. Our side began as `start`,
    /// which may be spelled otherwise than `base` and mean the same. The numbers of a shape are merged one by one: its
    /// centre may be edited on one side and its radius on the other. If both sides have moved it, by whatever numbers,
    /// it gets the position of `theirs`. Properties are merged by their names.
    pub fn merged(base: &Self, theirs: &Self, start: &Self, ours: &Self) -> Merged {
        let mut merged = Self::merged_shapes(base, theirs, start, ours);
        let [before, new, own] = [base, theirs, ours].map(|state| state.properties.clone().unwrap_or_default());
        let properties = Properties::merged(&before, &new, &own);
        merged.kept |= properties != new;
        merged.state.properties = properties.some();
        merged
    }

    fn merged_shapes(base: &Self, theirs: &Self, start: &Self, ours: &Self) -> Merged {
        let shapes = [base, theirs, start, ours].map(|state| state.shape.as_ref());
        let [Some(base_shape), Some(their_shape), Some(start_shape), Some(our_shape)] = shapes else {
            return Self::merged_parts(base, theirs, start, ours);
        };
        let are_of_one_kind = discriminant(&their_shape.kind) == discriminant(&our_shape.kind);
        let [was, there, began, here] = [base, theirs, start, ours].map(Self::place);
        let are_both_moved =
            are_of_one_kind && their_shape.has_own_place() && was != there && began != here && there != here;
        let mut shape = our_shape.clone();
        let mut is_replaced = are_both_moved;
        if are_of_one_kind && their_shape != base_shape && our_shape != start_shape && their_shape != our_shape {
            let mut other = their_shape.clone();
            carry_over(base_shape, their_shape, &mut shape, Vectors::Whole);
            carry_over(start_shape, our_shape, &mut other, Vectors::Whole);
            // The two orders agree if no number was edited on both sides.
            is_replaced |= shape != other;
        } else if !are_both_moved {
            return Self::merged_parts(base, theirs, start, ours);
        } else if their_shape != base_shape {
            shape = their_shape.clone();
        }
        let mut here = ours.clone();
        if are_both_moved {
            shape = shape.placed_as(their_shape);
            (here.to_world, here.angles) = (theirs.to_world, theirs.angles);
        }
        let is_kept = shape != *their_shape;
        here.shape = Some(shape);
        let there = Self {
            shape: here.shape.clone(),
            ..theirs.clone()
        };
        let merged = Self::merged_parts(base, &there, start, &here);
        Merged {
            kept: merged.kept || is_kept,
            replaced: merged.replaced || is_replaced,
            ..merged
        }
    }

    /// The position of a shape in the world.
    fn place(&self) -> Option<Vec3> {
        let middle = self.shape.as_ref()?.middle();
        Some(self.to_world?.0.transform_point3(middle))
    }

    /// The state without its order in the file.
    pub fn unordered(&self) -> Self {
        Self {
            order: None,
            ..self.clone()
        }
    }

    /// The state without the components that files do not hold.
    pub fn for_file(&self) -> Self {
        Self {
            hidden: None,
            locked: None,
            ..self.clone()
        }
    }

    /// Whether an entity is in the scene, see [`Self::is_there`].
    pub fn is_in_scene(world: &World, entity: Entity) -> bool {
        world.get_entity(entity).is_ok_and(|entity| {
            entity.contains::<Shape>()
                || entity.contains::<Material>()
                || entity.contains::<Medium>()
                || entity.contains::<Emitter>()
                || entity.contains::<Sensor>()
                || entity.contains::<ShapeGroup>()
        })
    }

    /// Whether the entity is in the scene.
    pub fn is_there(&self) -> bool {
        self.shape.is_some()
            || self.material.is_some()
            || self.medium.is_some()
            || self.emitter.is_some()
            || self.sensor.is_some()
            || self.group.is_some()
    }
}

/// Writes a component by insertion, since relationships cannot be changed in place.
pub(in crate::scene) fn write_component<C: Component + Clone + PartialEq>(
    world: &mut World,
    entity: Entity,
    value: &Option<C>,
) {
    let Ok(mut entity) = world.get_entity_mut(entity) else {
        return;
    };
    if entity.get::<C>() == value.as_ref() {
        return;
    }
    match value {
        Some(value) => {
            entity.insert(value.clone());
        }
        None => {
            entity.remove::<C>();
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::ShapeKind;

    fn ball(radius: f32) -> Option<Shape> {
        let kind = ShapeKind::Sphere {
            center: Vec3::ZERO,
            radius,
        };
        Some(Shape {
            kind,
            ..Shape::default()
        })
    }

    #[test]
    fn what_was_taken_away_comes_back() {
        let mut world = World::new();
        let material = world.spawn(Material::default()).id();
        let shape = world
            .spawn((
                ball(1.0).unwrap_or_default(),
                ToWorld::default(),
                UsesMaterial(material),
            ))
            .id();
        let before = ObjectState::of(&world, shape);
        ObjectState::default().write(&mut world, shape);
        assert!(!ObjectState::of(&world, shape).is_there());
        assert!(world.get::<crate::scene::MaterialUsers>(material).is_none());
        before.write(&mut world, shape);
        assert_eq!(ObjectState::of(&world, shape), before);
        assert!(world.get::<crate::scene::MaterialUsers>(material).is_some());
    }

    #[test]
    fn each_side_of_a_merge_keeps_what_it_alone_changed() {
        let state = |radius, x: f32| ObjectState {
            shape: ball(radius),
            to_world: Some(ToWorld(bevy::math::Affine3A::from_translation(Vec3::X * x))),
            ..ObjectState::default()
        };
        let start = state(1.0, 0.0);
        let merged = |ours: &ObjectState| ObjectState::merged(&start, &state(2.0, 0.0), &start, ours);
        let one = merged(&state(1.0, 5.0));
        assert_eq!(one.state, state(2.0, 5.0));
        assert!(one.kept && !one.replaced);
        let both = merged(&state(3.0, 0.0));
        assert_eq!(both.state, state(2.0, 0.0));
        assert!(both.replaced && !both.kept);
    }

    #[test]
    fn the_numbers_of_a_shape_are_merged_one_by_one() {
        let state = |center: Vec3, radius| ObjectState {
            shape: Some(Shape {
                kind: ShapeKind::Sphere { center, radius },
                ..Shape::default()
            }),
            ..ObjectState::default()
        };
        let (start, ours) = (state(Vec3::ZERO, 1.0), state(Vec3::X, 1.0));
        let merged = |theirs: &ObjectState| ObjectState::merged(&start, theirs, &start, &ours);
        let grown = merged(&state(Vec3::ZERO, 2.0));
        assert_eq!(grown.state, state(Vec3::X, 2.0));
        assert!(grown.kept && !grown.replaced);
        // Neither side has asked for anything between the two centres.
        let moved = merged(&state(Vec3::NEG_X, 2.0));
        assert_eq!(moved.state, state(Vec3::NEG_X, 2.0));
        assert!(moved.replaced);
        // The same holds if one of them has moved it by a transform.
        let by_transform = ObjectState {
            to_world: Some(ToWorld(bevy::math::Affine3A::from_translation(Vec3::Y))),
            ..state(Vec3::ZERO, 1.0)
        };
        let at_origin = |state: ObjectState| ObjectState {
            to_world: Some(ToWorld::default()),
            ..state
        };
        let (start, ours) = (at_origin(start), at_origin(ours));
        let merged = ObjectState::merged(&start, &by_transform, &start, &ours);
        assert_eq!((merged.state, merged.replaced), (by_transform.clone(), true));
        let merged = ObjectState::merged(&start, &ours, &start, &by_transform);
        assert_eq!((merged.state, merged.replaced), (ours, true));
    }
}
