//! Components of every entity of a scene: its position in the file, its id there, its transform.

use bevy::math::Affine3A;
use bevy::prelude::*;

use crate::math::is_invertible;

/// The position in the scene file. Every table is ordered by it, never by the order of the ECS.
#[derive(Component, Reflect, Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash)]
#[reflect(Component, PartialEq)]
pub struct DocumentOrder(pub u32);

/// The `id` attribute of the file; entities without one were declared in place.
#[derive(Component, Reflect, Clone, Debug, Default, PartialEq, Eq, Hash)]
#[reflect(Component, PartialEq)]
pub struct SceneId(pub String);

/// World from local, an invertible affine map (`to_world` of the file). A sensor looks along +z, with +x to its left
/// and +y up; a point light is at the origin, and a directional light shines along +z.
#[derive(Component, Reflect, Clone, Copy, Debug, Default, PartialEq)]
#[reflect(Component, PartialEq)]
pub struct ToWorld(pub Affine3A);

impl ToWorld {
    /// Whether it has an inverse, see [`is_invertible`].
    pub(crate) fn is_invertible(&self) -> bool {
        is_invertible(&self.0)
    }
}

/// Hides an entity while the user works on others. The mark is not saved: the entity is visible when the scene is
/// opened again.
#[derive(Component, Reflect, Clone, Copy, Debug, Default, PartialEq, Eq)]
#[reflect(Component, PartialEq)]
pub struct Hidden;

/// Marks an entity that cannot be picked in the picture or moved. The mark is not saved.
#[derive(Component, Reflect, Clone, Copy, Debug, Default, PartialEq, Eq)]
#[reflect(Component, PartialEq)]
pub struct Locked;
