//! The places that are taken already where room is looked for.

use bevy::ecs::entity::EntityHashMap;
use bevy::math::Vec3;
use bevy::prelude::*;

use crate::app::editor::camera::picking;
use crate::engine::PackedScene;
use crate::math::Aabb;
use crate::scene::{AreaLight, Emitter, MemberOf, Shape, ToWorld};

/// The part of space between two parallel planes. The feet of new things are looked for on one upright plane.
pub(super) struct Slab {
    pub through: Vec3,
    /// The normal of the planes.
    pub across: Vec3,
    pub half_width: f32,
}

impl Slab {
    pub fn contains(&self, place: Vec3) -> bool {
        (place - self.through).dot(self.across).abs() <= self.half_width
    }
}

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

/// The middles of the lights, or of the shapes, that exist already.
pub(super) struct Taken(Vec<Vec3>);

impl Taken {
    /// Finds those in a slab that are like what is new. Things in whose middle something may stand, such as a floor, are not among them.
    pub fn find(
        world: &World,
        things: &mut Things,
        packed: &PackedScene,
        lights: bool,
        slab: &Slab,
        is_like: impl Fn(&Aabb) -> bool,
    ) -> Self {
        let is_meant = |shape: Option<&Shape>, shines: bool, emitter: Option<&Emitter>| match lights {
            true => shines || emitter.is_some_and(Emitter::has_place),
            false => shape.is_some() && !shines,
        };
        let mut outside_picture: EntityHashMap<Vec3> = things
            .iter(world)
            .filter(|(_, _, shape, shines, emitter)| is_meant(*shape, *shines, *emitter))
            .map(|(entity, pose, shape, ..)| {
                let middle = shape.map_or(Vec3::ZERO, Shape::middle);
                (entity, pose.0.transform_point3(middle))
            })
            .filter(|(_, place)| slab.contains(*place))
            .collect();
        let mut places = Vec::new();
        // What is in the picture has its middle there.
        picking::each_bounds(packed, |entity, bounds| {
            outside_picture.remove(&entity);
            if slab.contains(bounds.center())
                && is_like(&bounds)
                && let Ok((_, _, shape, shines, emitter)) = things.get_manual(world, entity)
                && is_meant(shape, shines, emitter)
            {
                places.push(bounds.center());
            }
        });
        places.extend(outside_picture.values());
        Self(places)
    }

    /// Whether something new would be in one of them. `upwards`: as long as half its size.
    pub fn is_at(&self, foot: Vec3, upwards: Vec3, lift: f32) -> bool {
        let size = upwards.length();
        self.0.iter().any(|place| {
            let from = *place - foot;
            let height = from.dot(upwards) / (size * size);
            height > -1.0 && height < lift + 1.0 && from.reject_from(upwards).length() < size
        })
    }
}
