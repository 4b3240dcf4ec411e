//! The scene as last packed, for queries of the editor such as picking and the display of boxes.

use std::sync::Arc;

use bevy::ecs::entity::EntityHashMap;
use bevy::prelude::*;

use super::light_groups::Lamps;
use crate::material::MaterialId;
use crate::medium::MediumId;
use crate::render::borders;
use crate::render::scene::RenderScene;
use crate::render::view::View;

/// The tables for the next picture. They may be ahead of the shown picture by a frame or two.
#[derive(Resource, Debug, Default)]
pub struct PackedScene {
    /// The tables that are rendered; None until the first scene is packed.
    pub scene: Option<RenderScene>,
    /// The entity of each instance of `scene.geometry`, then of each placement.
    pub entity_of_instance: Arc<[Entity]>,
    /// The index in `scene.materials` of each material.
    pub material_of_entity: Arc<EntityHashMap<MaterialId>>,
    /// The index in `scene.media` of each medium; none if the integrator leaves media out.
    pub medium_of_entity: Arc<EntityHashMap<MediumId>>,
    /// The lights of the scene, with the entity of each.
    pub lamps: Arc<Lamps>,
    /// The view; None before the first camera.
    pub view: Option<View>,
}

impl PackedScene {
    /// The medium at the point `to`, given that `medium` is at the point `from`, both in world space. It is `medium` if
    /// the integrator ignores media.
    pub fn medium_at(&self, from: Vec3, medium: Option<Entity>, to: Vec3) -> Option<Entity> {
        let Some(scene) = self.scene.as_ref().filter(|_| !self.medium_of_entity.is_empty()) else {
            return medium;
        };
        let before = medium.and_then(|medium| self.medium_of_entity.get(&medium).copied());
        let id = borders::medium_at(scene, from, before, to)?;
        let mut media = self.medium_of_entity.iter();
        media.find(|(_, found)| **found == id).map(|(entity, _)| *entity)
    }
}
