//! The finished picture with its layers, by the names of the scene.

use std::collections::{HashMap, HashSet};

use bevy::prelude::*;

use super::film::RenderFilm;
use super::packed_scene::PackedScene;
use crate::color::Rgb;
use crate::render::image_io::ImageRgb;
use crate::render::layered_image::LayeredImage;
use crate::render::layers::{LayerNames, layered_image};
use crate::scene::{DocumentOrder, SceneId};

/// The picture with the layers that the film keeps. `denoised` is the layer of that name.
pub fn layered_picture(world: &World, picture: &ImageRgb, denoised: Option<&[Rgb]>) -> LayeredImage {
    let film = world.resource::<RenderFilm>();
    let packed = world.resource::<PackedScene>();
    let materials = packed.material_of_entity.iter();
    let entity_of_material: HashMap<u32, Entity> = materials.map(|(&entity, id)| (id.0, entity)).collect();
    let shape_names = DistinctNames::new(world, "shape", packed.entity_of_instance.iter().copied());
    let object = |instance: u32| match packed.entity_of_instance.get(instance as usize) {
        Some(&entity) => shape_names.of(entity),
        None => format!("shape {instance}"),
    };
    let material_names = DistinctNames::new(world, "material", entity_of_material.values().copied());
    let material = |id: u32| match entity_of_material.get(&id) {
        Some(&entity) => material_names.of(entity),
        None => format!("material {id}"),
    };
    let light_groups: Vec<String> = film
        .light_groups
        .iter()
        .map(|group| match group.entities[..] {
            [entity] => name_of(world, entity, "light"),
            _ => "others".to_owned(),
        })
        .collect();
    let names = LayerNames {
        object: &object,
        material: &material,
        light_groups: &light_groups,
    };
    match &packed.view {
        Some(view) => layered_image(picture, &film.film, &view.camera, &names, denoised),
        None => LayeredImage::from(picture),
    }
}

/// The names by which layers tell things apart. Where several things without an id have the same name, the name is followed by the place in the file.
struct DistinctNames<'w> {
    world: &'w World,
    kind: &'w str,
    repeated: HashSet<String>,
}

impl<'w> DistinctNames<'w> {
    /// `entities` may hold an entity several times.
    fn new(world: &'w World, kind: &'w str, entities: impl Iterator<Item = Entity>) -> Self {
        let (mut known, mut repeated) = (HashSet::new(), HashSet::new());
        for entity in entities.collect::<HashSet<_>>() {
            let name = name_of(world, entity, kind);
            if !known.insert(name.clone()) {
                repeated.insert(name);
            }
        }
        Self { world, kind, repeated }
    }

    fn of(&self, entity: Entity) -> String {
        let name = name_of(self.world, entity, self.kind);
        match self.world.get::<DocumentOrder>(entity) {
            Some(order) if self.repeated.contains(&name) && !self.world.entity(entity).contains::<SceneId>() => {
                format!("{name} {}", order.0)
            }
            _ => name,
        }
    }
}

/// The name that the scene has for a thing, or its kind and its place in the file.
fn name_of(world: &World, entity: Entity, kind: &str) -> String {
    let name = || Some(world.get::<Name>(entity)?.to_string());
    let id = world.get::<SceneId>(entity).map(|id| id.0.to_string());
    let order = || world.get::<DocumentOrder>(entity).map_or(0, |order| order.0);
    id.or_else(name).unwrap_or_else(|| format!("{kind} {}", order()))
}
