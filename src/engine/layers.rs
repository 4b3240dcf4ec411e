//! The finished picture with its layers, named as in the scene.

use std::collections::{BTreeMap, HashMap, HashSet};
use std::path::Path;

use bevy::prelude::*;

use super::film::RenderFilm;
use super::light_groups::LightGroup;
use super::packed_scene::PackedScene;
use super::status::RenderStatus;
use crate::color::Rgb;
use crate::layer::Layer;
use crate::render::camera::Camera;
use crate::render::film::Film;
use crate::render::image_io::{FileOptions, ImageRgb};
use crate::render::layered_image::{Attribute, LayeredImage, StoredColors};
use crate::render::layers::{LayerNames, layered_image, picture_of_camera};
use crate::render::tonemap::Display;
use crate::scene::{ActiveSensor, ComponentFormat, DocumentOrder, FilmStorage, PixelFormat, SamplerSettings, SceneId};

/// The names that layers refer to.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct PictureNames {
    /// The names of the shapes, by instance; empty if no layer names them.
    pub objects: Vec<String>,
    /// The names of the materials, by [`crate::material::MaterialId`]; empty if no layer names them.
    pub materials: Vec<String>,
    /// The names of the light groups.
    pub light_groups: Vec<String>,
}

impl PictureNames {
    /// The names of the scene for the layers that the film keeps.
    pub fn of(world: &World) -> Self {
        let film = world.resource::<RenderFilm>();
        let packed = world.resource::<PackedScene>();
        let mut names = Self::default();
        let kept = film.film.layers().layers;
        if kept.contains(Layer::CryptoObject) {
            let shapes = || packed.entity_of_instance.iter().copied();
            let distinct = DistinctNames::new(world, "shape", shapes());
            names.objects = shapes().map(|shape| distinct.of(shape)).collect();
        }
        if kept.contains(Layer::CryptoMaterial) {
            let materials = packed.material_of_entity.iter();
            let chosen: BTreeMap<u32, Entity> = materials.map(|(&entity, id)| (id.0, entity)).collect();
            let distinct = DistinctNames::new(world, "material", chosen.values().copied());
            let count = chosen.last_key_value().map_or(0, |(&last, _)| last + 1);
            let name = |id: u32| chosen.get(&id).map_or_else(String::new, |&entity| distinct.of(entity));
            names.materials = (0..count).map(name).collect();
        }
        let group = |group: &LightGroup| match group.entities[..] {
            [entity] => name_of(world, entity, "light"),
            _ => "others".to_owned(),
        };
        names.light_groups = film.light_groups.iter().map(group).collect();
        names
    }

    /// The picture with the layers that the film keeps. `denoised` is the layer of that name.
    pub fn layered(&self, picture: &ImageRgb, film: &Film, camera: &Camera, denoised: Option<&[Rgb]>) -> LayeredImage {
        let name = |names: &[String], place: u32, kind: &str| {
            let known = names.get(place as usize).filter(|name| !name.is_empty());
            known.cloned().unwrap_or_else(|| format!("{kind} {place}"))
        };
        let names = LayerNames {
            object: &|instance| name(&self.objects, instance, "shape"),
            material: &|id| name(&self.materials, id, "material"),
            light_groups: &self.light_groups,
        };
        layered_image(picture, film, camera, &names, denoised)
    }
}

/// The picture with the layers that the film keeps. `denoised` is the layer of that name.
pub fn layered_picture(world: &World, picture: &ImageRgb, denoised: Option<&[Rgb]>) -> LayeredImage {
    let film = &world.resource::<RenderFilm>().film;
    match &world.resource::<PackedScene>().view {
        Some(view) => PictureNames::of(world).layered(picture, film, &view.camera, denoised),
        None => LayeredImage::from(picture),
    }
}

/// The picture without layers, with the pose of the view's camera.
pub fn single_picture(world: &World, picture: &ImageRgb) -> LayeredImage {
    match &world.resource::<PackedScene>().view {
        Some(view) => picture_of_camera(picture, &view.camera),
        None => LayeredImage::from(picture),
    }
}

/// Adds the picture's origin to its metadata: the version, the scene's file, the camera, the choice of `auto`, the
/// samples and the seed. `scene` is the file of the scene, if it has one. `seconds` is the rendering time, for pictures
/// that depend on it: with None the same render gives the same file.
pub fn describe_picture(picture: &mut LayeredImage, world: &World, scene: Option<&Path>, seconds: Option<f64>) {
    let status = world.resource::<RenderStatus>();
    let mut text = |name: &str, value: String| picture.set_attribute(name, Attribute::Text(value));
    text("software", concat!("Sunroom ", env!("CARGO_PKG_VERSION")).to_owned());
    if let Some(scene) = scene {
        text("sunroom:scene", scene.display().to_string());
    }
    let camera = world.resource::<ActiveSensor>().0;
    if let Some(name) = camera.and_then(|camera| world.get::<Name>(camera)) {
        text("sunroom:camera", name.as_str().to_owned());
    }
    if let Some(auto) = status.auto {
        text("sunroom:auto", auto.integrator.to_owned());
    }
    let mut int = |name: &str, value: u32| {
        picture.set_attribute(name, Attribute::Int(i32::try_from(value).unwrap_or(i32::MAX)));
    };
    int("sunroom:spp", status.samples.saturating_sub(status.first));
    int("sunroom:seed", world.resource::<SamplerSettings>().seed);
    if let Some(seconds) = seconds {
        picture.set_attribute("sunroom:seconds", Attribute::Float(seconds as f32));
    }
}

/// The lamps of the packed scene, in the order of their first lights, with unique names; and the number of the lamp of
/// each light.
pub fn named_lamps(world: &World) -> (Vec<(Entity, String)>, Vec<u32>) {
    let owners = &world.resource::<PackedScene>().lamps.owners;
    let names = DistinctNames::new(world, "light", owners.iter().copied());
    let mut lamps: Vec<(Entity, String)> = Vec::new();
    let mut known: HashMap<Entity, u32> = HashMap::new();
    let lamp_of_light = owners.iter().map(|&owner| {
        *known.entry(owner).or_insert_with(|| {
            lamps.push((owner, names.of(owner)));
            lamps.len() as u32 - 1
        })
    });
    let lamp_of_light = lamp_of_light.collect();
    (lamps, lamp_of_light)
}

/// Unique names for layers. Where several entities without an id have the same name, the name is followed by the index
/// in the file.
struct DistinctNames<'w> {
    world: &'w World,
    kind: &'w str,
    repeated: HashSet<String>,
}

impl<'w> DistinctNames<'w> {
    /// `entities` may repeat an entity.
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

/// The storage of a picture in files, as the film of the scene sets it.
pub fn file_options(storage: FilmStorage, display: Display) -> FileOptions {
    FileOptions {
        display,
        exr_half: storage.components == Some(ComponentFormat::Float16),
        exr_compression: storage.compression.unwrap_or_default(),
        stored: match storage.pixels {
            None | Some(PixelFormat::Rgb | PixelFormat::Rgba) => StoredColors::Rgb,
            Some(PixelFormat::Luminance | PixelFormat::LuminanceAlpha) => StoredColors::Luminance,
            Some(PixelFormat::Xyz | PixelFormat::Xyza) => StoredColors::Xyz,
        },
        ..FileOptions::default()
    }
}

/// The entity's name in the scene, or its kind and its index in the file.
pub(super) fn name_of(world: &World, entity: Entity, kind: &str) -> String {
    name_by(world.get(entity), world.get(entity), world.get(entity), kind)
}

/// [`name_of`] by the components of the entity.
pub(super) fn name_by(id: Option<&SceneId>, name: Option<&Name>, order: Option<&DocumentOrder>, kind: &str) -> String {
    let name = || Some(name?.to_string());
    let order = || order.map_or(0, |order| order.0);
    let id = id.map(|id| id.0.to_string());
    id.or_else(name).unwrap_or_else(|| format!("{kind} {}", order()))
}
