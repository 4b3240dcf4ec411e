//! The scene as it was last packed, for queries of the editor: what is under the mouse, which boxes to draw.

use std::sync::Arc;

use bevy::ecs::entity::EntityHashMap;
use bevy::prelude::*;

use crate::material::MaterialId;
use crate::render::scene::RenderScene;
use crate::render::view::View;

/// The tables that the next picture is rendered from. They may be ahead of the shown picture by a frame or two.
#[derive(Resource, Debug, Default)]
pub struct PackedScene {
    /// The tables that are rendered; None until the first scene is packed.
    pub scene: Option<RenderScene>,
    /// The shape behind each instance of `scene.geometry`, then behind each placement.
    pub entity_of_instance: Arc<[Entity]>,
    /// The index in `scene.materials` of each material.
    pub material_of_entity: Arc<EntityHashMap<MaterialId>>,
    /// The view; None until there has been a camera.
    pub view: Option<View>,
}
