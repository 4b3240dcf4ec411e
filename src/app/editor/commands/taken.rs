//! The occupied places in a search for room.

use bevy::math::Vec3;
use bevy::prelude::*;

use crate::app::editor::camera::picking;
use crate::engine::PackedScene;
use crate::math::Aabb;
use crate::scene::{AreaLight, Emitter, MemberOf, Shape, ToWorld};

// Members of groups are where the instances of the groups are.
pub(super) type Things = QueryState<
    (
        Entity,
        &'static ToWorld,
        Option<&'static Shape>,
        Has<AreaLight>,
        Option<&'static Emitter>,
    ),
    Without<MemberOf>,
>;

/// The existing lights, or the existing shapes.
pub(super) struct Taken<'a> {
    pub world: &'a World,
    pub things: &'a mut Things,
    pub packed: &'a PackedScene,
    pub lights: bool,
}

/// An upright cylinder around a new thing, in which no other thing may have its middle.
struct Column {
    foot: Vec3,
    /// The vector upwards. Its length is half the size of the new thing.
    upwards: Vec3,
    /// The distance from the foot to the position, in half sizes.
    lift: f32,
}

impl Column {
    fn contains(&self, place: Vec3) -> bool {
        let size = self.upwards.length();
        let from = place - self.foot;
        let height = from.dot(self.upwards) / (size * size);
        height > -1.0 && height < self.lift + 1.0 && from.reject_from(self.upwards).length() < size
    }

    /// Bounds of at least the column.
    fn bounds(&self) -> Aabb {
        let [low, high] = [-1.0, self.lift + 1.0].map(|height| self.foot + height * self.upwards);
        let around = Vec3::splat(self.upwards.length());
        Aabb {
            min: low.min(high) - around,
            max: low.max(high) + around,
        }
    }
}

impl Taken<'_> {
    /// Whether a new thing would overlap one of them. `upwards` is as long as half its size. A floor, in whose middle a
    /// thing may stand, does not count: `is_like` rejects its bounds.
    pub fn is_at(&mut self, foot: Vec3, upwards: Vec3, lift: f32, is_like: impl Fn(&Aabb) -> bool) -> bool {
        let column = Column { foot, upwards, lift };
        self.is_in_picture(&column, is_like) || self.is_outside_picture(&column)
    }

    fn is_in_picture(&self, column: &Column, is_like: impl Fn(&Aabb) -> bool) -> bool {
        let Some(scene) = &self.packed.scene else {
            return false;
        };
        scene.geometry.any_touching(&column.bounds(), |item, bounds| {
            column.contains(bounds.center())
                && is_like(bounds)
                && (self.packed.entity_of_instance.get(item as usize))
                    .and_then(|entity| self.things.get_manual(self.world, *entity).ok())
                    .is_some_and(|(_, _, shape, shines, emitter)| is_meant(self.lights, shape, shines, emitter))
        })
    }

    /// Things that the picture does not have yet are tested by their poses.
    fn is_outside_picture(&mut self, column: &Column) -> bool {
        let meant = (self.things.iter(self.world))
            .filter(|(_, _, shape, shines, emitter)| is_meant(self.lights, *shape, *shines, *emitter))
            .filter(|(_, pose, shape, ..)| {
                let middle = shape.map_or(Vec3::ZERO, Shape::middle);
                column.contains(pose.0.transform_point3(middle))
            });
        let meant: Vec<Entity> = meant.map(|(entity, ..)| entity).collect();
        !meant.is_empty() && picking::bounds_of_each(self.packed, &meant).contains(&None)
    }
}

fn is_meant(lights: bool, shape: Option<&Shape>, shines: bool, emitter: Option<&Emitter>) -> bool {
    match lights {
        true => shines || emitter.is_some_and(|emitter| emitter.has_place() && emitter.shines()),
        false => shape.is_some() && !shines,
    }
}
