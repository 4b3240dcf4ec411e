//! The change of an entity by one edit: only the changed components, before and after. The history of the editor
//! consists of these, and most of its memory: a whole `ObjectState` is some kilobytes, one changed component mostly a
//! hundred bytes.

use bevy::prelude::*;

use crate::scene::components::object_state::{with_components, write_component};
use crate::scene::{
    AreaLight, DeclaredIn, DocumentOrder, Emitter, EulerAngles, ExteriorMedium, Film, FirstNested, Hidden, InMedium,
    InstanceOf, InteriorMedium, Keys, Locked, Material, Medium, MemberOf, ObjectState, Placements, Properties, SceneId,
    SecondNested, Sensor, Shape, ShapeGroup, ShapeKind, ToWorld, UsesMaterial,
};

/// The side of a change: the state before or after it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Side {
    Before,
    After,
}

/// The changed components of an entity. Never empty when made by [`ObjectChange::between`].
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct ObjectChange {
    parts: Vec<Part>,
    /// Whether the entity is in the scene, before and after.
    is_there: [bool; 2],
}

macro_rules! object_change {
    ($($field:ident: $component:ident,)*) => {
        /// A component before and after; None if absent.
        #[derive(Clone, Debug, PartialEq)]
        enum Part {
            $($component(Box<[Option<$component>; 2]>),)*
        }

        impl Part {
            fn differs(&self) -> bool {
                match self {
                    $(Self::$component(values) => values[0] != values[1],)*
                }
            }

            fn write(&self, world: &mut World, entity: Entity, side: Side) {
                match self {
                    $(Self::$component(values) => write_component(world, entity, &values[side as usize]),)*
                }
            }

            /// Takes the present state as the state after.
            fn refresh(&mut self, world: &World, entity: Entity) {
                match self {
                    $(Self::$component(values) => values[1] = world.get::<$component>(entity).cloned(),)*
                }
            }

            /// Takes the state after from a later change of the same component; returns it if it is of another
            /// component.
            fn absorb(&mut self, later: Self) -> Option<Self> {
                match (self, later) {
                    $((Self::$component(values), Self::$component(later)) => {
                        let [_, after] = *later;
                        values[1] = after;
                        None
                    })*
                    (_, later) => Some(later),
                }
            }

            fn own_bytes(&self) -> usize {
                match self {
                    $(Self::$component(_) => size_of::<[Option<$component>; 2]>(),)*
                }
            }
        }

        impl ObjectChange {
            /// None if the two are equal.
            pub fn between(before: &ObjectState, after: &ObjectState) -> Option<Self> {
                let mut parts = Vec::new();
                $(
                    if before.$field != after.$field {
                        parts.push(Part::$component(Box::new([before.$field.clone(), after.$field.clone()])));
                    }
                )*
                parts.shrink_to_fit();
                let is_there = [before.is_there(), after.is_there()];
                (!parts.is_empty()).then_some(Self { parts, is_there })
            }
        }
    };
}

with_components!(object_change);

impl Part {
    /// Whether it concerns the file, unlike hiding and locking.
    fn is_of_file(&self) -> bool {
        !matches!(self, Self::Hidden(_) | Self::Locked(_))
    }

    /// An estimate of the allocated memory in bytes. Shared placements count in full.
    fn heap_bytes(&self) -> usize {
        /// The approximate size of a texture with its path.
        const TEXTURE: usize = 256;
        fn sum<C>(values: &[Option<C>; 2], bytes: impl Fn(&C) -> usize) -> usize {
            values.iter().flatten().map(bytes).sum()
        }
        match self {
            Self::Name(values) => sum(values, |name| name.as_str().len()),
            Self::SceneId(values) => sum(values, |id| id.0.len()),
            Self::Placements(values) => sum(values, |placements| size_of_val(placements.places.as_slice())),
            Self::Shape(values) => sum(values, |shape| match &shape.kind {
                ShapeKind::Mesh(mesh) => mesh.path.as_os_str().len(),
                _ => 0,
            }),
            Self::Material(values) => sum(values, |material| {
                let mut textures = 0;
                material.for_each_texture(&mut |_| textures += 1);
                textures * TEXTURE
            }),
            Self::Medium(values) => sum(values, |medium| {
                let mut grids = 0;
                medium.for_each_grid(&mut |_| grids += 1);
                grids * TEXTURE
            }),
            Self::Emitter(_) | Self::AreaLight(_) => 2 * TEXTURE,
            Self::Keys(values) => sum(values, Keys::bytes),
            Self::Properties(values) => sum(values, Properties::bytes),
            _ => 0,
        }
    }
}

impl ObjectChange {
    /// Whether a component differs that a file holds.
    pub fn is_of_file(&self) -> bool {
        self.parts.iter().any(Part::is_of_file)
    }

    /// Whether the id differs.
    pub fn is_about_id(&self) -> bool {
        self.parts.iter().any(|part| matches!(part, Part::SceneId(_)))
    }

    /// An estimate of its memory in bytes.
    pub fn bytes(&self) -> usize {
        let parts = self.parts.iter();
        size_of::<Self>()
            + parts
                .map(|part| size_of::<Part>() + part.own_bytes() + part.heap_bytes())
                .sum::<usize>()
    }

    /// Takes the state after from a later change of the same entity; true if no difference is left.
    pub fn absorb(&mut self, later: Self) -> bool {
        self.is_there[1] = later.is_there[1];
        for part in later.parts {
            let rest = self
                .parts
                .iter_mut()
                .try_fold(part, |part, known| known.absorb(part).ok_or(()));
            self.parts.extend(rest.ok());
        }
        self.parts.retain(Part::differs);
        self.parts.is_empty()
    }

    /// Takes the present state as the state after the edit: a file may have changed it since. If a file has removed the
    /// entity, the change stays as it was.
    pub fn refresh(&mut self, world: &World, entity: Entity) {
        if !self.is_there[1] || !ObjectState::is_in_scene(world, entity) {
            return;
        }
        if self.is_there[0] {
            self.parts.iter_mut().for_each(|part| part.refresh(world, entity));
        } else if let Some(whole) = Self::between(&ObjectState::default(), &ObjectState::of(world, entity)) {
            *self = whole;
        }
    }

    /// Sets the changed components to their state on one side. Other components stay, even if a file has changed them.
    /// An entity that a file has removed stays removed.
    pub fn write(&self, world: &mut World, entity: Entity, side: Side) {
        let [from, to] = match side {
            Side::Before => [self.is_there[1], self.is_there[0]],
            Side::After => self.is_there,
        };
        if from && !ObjectState::is_in_scene(world, entity) {
            return;
        }
        if !to {
            // Components added by others meanwhile are removed as well.
            return ObjectState::default().write(world, entity);
        }
        for part in &self.parts {
            part.write(world, entity, side);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn state(radius: f32, x: f32) -> ObjectState {
        let kind = ShapeKind::Sphere {
            center: Vec3::ZERO,
            radius,
        };
        ObjectState {
            shape: Some(Shape {
                kind,
                ..Shape::default()
            }),
            to_world: Some(ToWorld(bevy::math::Affine3A::from_translation(Vec3::X * x))),
            ..ObjectState::default()
        }
    }

    #[test]
    fn a_change_goes_both_ways_and_leaves_the_rest() {
        let mut world = World::new();
        let entity = world.spawn_empty().id();
        state(1.0, 5.0).write(&mut world, entity);
        let change = ObjectChange::between(&state(1.0, 0.0), &state(2.0, 0.0)).expect("they differ");
        change.write(&mut world, entity, Side::After);
        assert_eq!(ObjectState::of(&world, entity).shape, state(2.0, 5.0).shape);
        assert_eq!(ObjectState::of(&world, entity).to_world, state(2.0, 5.0).to_world);
        change.write(&mut world, entity, Side::Before);
        assert_eq!(ObjectState::of(&world, entity).shape, state(1.0, 5.0).shape);
        assert!(ObjectChange::between(&state(1.0, 0.0), &state(1.0, 0.0)).is_none());
    }

    #[test]
    fn changes_of_a_drag_are_one_change() {
        let between = |a: &ObjectState, b: &ObjectState| ObjectChange::between(a, b).expect("they differ");
        let states = [state(1.0, 0.0), state(1.0, 1.0), state(2.0, 2.0)];
        let mut change = between(&states[0], &states[1]);
        assert!(!change.absorb(between(&states[1], &states[2])));
        assert_eq!(change, {
            let mut whole = between(&states[0], &states[2]);
            whole.parts.sort_by_key(|part| !matches!(part, Part::ToWorld(_)));
            whole
        });
        assert!(change.absorb(between(&states[2], &states[0])), "back where it began");
    }

    #[test]
    fn a_moved_thing_takes_less_than_its_whole_state() {
        let change = ObjectChange::between(&state(1.0, 0.0), &state(1.0, 1.0)).expect("they differ");
        println!("{} bytes of {}", change.bytes(), 2 * size_of::<ObjectState>());
        assert!(change.bytes() < 300, "{}", change.bytes());
        let deleted = ObjectChange::between(&state(1.0, 0.0), &ObjectState::default()).expect("they differ");
        assert!(deleted.bytes() > change.bytes() && !deleted.is_there[1]);
        let mut name = state(1.0, 0.0);
        name.name = Some(Name::new("n".repeat(10_000)));
        let renamed = ObjectChange::between(&state(1.0, 0.0), &name).expect("they differ");
        assert!(renamed.bytes() > 10_000);
    }
}
