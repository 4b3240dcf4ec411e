//! Loads levels that `sunroom bake` has written into Bevy games.
//!
//! ```no_run
//! # use bevy::prelude::*;
//! # use sunroom_game::{SunroomLevel, SunroomLevelPlugin, exposure};
//! fn main() {
//!     App::new().add_plugins((DefaultPlugins, SunroomLevelPlugin)).add_systems(Startup, setup).run();
//! }
//!
//! fn setup(mut commands: Commands) {
//!     // The folder lies in `assets`.
//!     commands.spawn(SunroomLevel::new("level"));
//!     // As bright as the picture that Sunroom shows.
//!     commands.spawn((Camera3d::default(), exposure(0.0)));
//! }
//! ```
//!
//! The entity gets the scene of `level.glb` as its children, and [`LevelReady`] when everything is there:
//!
//! * Every mesh with a place in a lightmap has a [`Lightmap`].
//! * Lights whose direct light is in the lightmaps do not light these meshes a second time. They light what moves, with
//!   shadows where the level has an irradiance volume. After `sunroom bake --indirect-only` they light everything, with
//!   shadows.
//! * Reflection probes are what metals mirror, and an irradiance volume lights what has no lightmap.
//! * The lamps of a level that was baked with `--layers` can be dimmed: see [`Lamps`].
//! * Surfaces that shine follow the exposure of the camera, as everything else does.
//!
//! The light of a level is in the units of its scene, for which Bevy's ambient light of 80 cd/m² is far too bright: the
//! plugin sets [`GlobalAmbientLight`] to none.

mod lamps;
mod manifest;
mod mixing;
mod probes;

use bevy::camera::Exposure;
use bevy::gltf::{GltfExtras, GltfLoaderSettings};
use bevy::image::{ImageLoaderSettings, ImageSampler};
use bevy::light::GlobalAmbientLight;
use bevy::pbr::Lightmap;
use bevy::prelude::*;
use bevy::world_serialization::WorldInstanceReady;
use serde::Deserialize;

pub use lamps::{Lamp, Lamps};
pub use manifest::{
    LayerFiles, LayerKind, LevelManifest, LightmapFiles, LightmapLayer, ManifestError, ReflectionFiles,
    ReflectionLayer, VolumeFiles, VolumeLayer,
};

use lamps::{Mixer, of_layers};

/// Loads [`SunroomLevel`]s.
pub struct SunroomLevelPlugin;

impl Plugin for SunroomLevelPlugin {
    fn build(&self, app: &mut App) {
        app.init_asset::<LevelManifest>()
            .register_asset_loader(manifest::ManifestLoader)
            .insert_resource(GlobalAmbientLight::NONE)
            .add_observer(begin)
            .add_observer(note_scene)
            .add_systems(Update, (settle, finish, lamps::follow).chain());
    }
}

/// A level; the entity is the parent of everything in it.
#[derive(Component, Clone, Debug, PartialEq, Eq)]
#[require(Transform, Visibility)]
pub struct SunroomLevel {
    /// The folder that `sunroom bake -o` wrote, as a path of assets.
    pub folder: String,
    /// Whether lightmaps are filtered bicubically, which is smoother and slower.
    pub bicubic: bool,
    /// Whether the cameras of the level come along, the first of them active. They have the exposure of 0 stops.
    pub cameras: bool,
}

impl SunroomLevel {
    /// The level in this folder, filtered bilinearly, without its cameras.
    pub fn new(folder: impl Into<String>) -> Self {
        Self {
            folder: folder.into(),
            bicubic: false,
            cameras: false,
        }
    }
}

/// A level has this once its meshes, its lightmaps and its probes are loaded and in their places.
#[derive(Component, Clone, Copy, Debug, PartialEq, Eq)]
pub struct LevelReady;

/// The exposure with which Bevy's picture is as bright as Sunroom's at an exposure of so many stops.
pub fn exposure(stops: f32) -> Exposure {
    // Bevy's factor is 2^-ev100 / 1.2.
    Exposure {
        ev100: -stops - 1.2f32.log2(),
    }
}

/// The manifest of a level that is being loaded.
#[derive(Component)]
struct Manifest(Handle<LevelManifest>);

/// A level whose scene has been spawned.
#[derive(Component)]
struct Spawned;

/// A level that waits for its lightmaps and probes alone.
#[derive(Component)]
struct Waiting {
    images: Vec<Handle<Image>>,
    /// Meshes and lights that are parts of lamps, with the numbers of their layers.
    parts_of_lamps: Vec<(usize, Entity)>,
}

/// What a node says of its lamp.
#[derive(Deserialize)]
struct LampExtras {
    sunroom_lamp: usize,
}

/// What a node says of its lightmap.
#[derive(Deserialize)]
struct Extras {
    sunroom_lightmap: Place,
}

#[derive(Deserialize)]
struct Place {
    lightmap: usize,
    rect: [f32; 4],
}

fn begin(level: On<Add, SunroomLevel>, mut commands: Commands, levels: Query<&SunroomLevel>, assets: Res<AssetServer>) {
    let Ok(SunroomLevel { folder, cameras, .. }) = levels.get(level.entity) else {
        return;
    };
    let cameras = *cameras;
    let scene = assets
        .load_builder()
        .with_settings(move |settings: &mut GltfLoaderSettings| settings.load_cameras = cameras)
        .load(GltfAssetLabel::Scene(0).from_asset(format!("{folder}/level.glb")));
    let manifest = assets.load(format!("{folder}/lightmaps.json"));
    commands
        .entity(level.entity)
        .insert((WorldAssetRoot(scene), Manifest(manifest)));
}

fn note_scene(scene: On<WorldInstanceReady>, mut commands: Commands, levels: Query<(), With<SunroomLevel>>) {
    if levels.contains(scene.entity) {
        commands.entity(scene.entity).insert(Spawned);
    }
}

/// Adapts what has been spawned, once the manifest is there as well.
fn settle(
    mut commands: Commands,
    levels: Query<(Entity, &SunroomLevel, &Manifest), With<Spawned>>,
    manifests: Res<Assets<LevelManifest>>,
    assets: Res<AssetServer>,
    children: Query<&Children>,
    mut parts: Parts,
) {
    for (entity, level, manifest) in &levels {
        let Some(manifest) = manifests.get(&manifest.0) else {
            continue;
        };
        let load = |file: &str| {
            assets
                .load_builder()
                // Whatever the game's pictures have: texels of lightmaps are means, which are filtered.
                .with_settings(|settings: &mut ImageLoaderSettings| settings.sampler = ImageSampler::linear())
                .load::<Image>(format!("{}/{file}", level.folder))
        };
        let of_layer = |file: &str| {
            let loader = assets.load_builder().with_settings(of_layers);
            loader.load::<Image>(format!("{}/{file}", level.folder))
        };
        let mut mixer = Mixer::new(manifest);
        let layers = || manifest.layers.iter().enumerate();
        let of_files = manifest.lightmaps.iter().map(|files| load(&files.ktx2));
        let lightmaps: Vec<Handle<Image>> = of_files.collect();
        let mut waiting = lightmaps.clone();
        for (number, lightmap) in lightmaps.iter().enumerate() {
            let own = layers().flat_map(|(layer, files)| files.lightmaps.iter().map(move |files| (layer, files)));
            let own = own.filter(|(_, files)| files.lightmap == number);
            waiting.extend(mixer.add(lightmap, own.map(|(layer, files)| (layer, of_layer(&files.ktx2)))));
        }
        for (number, files) in manifest.reflection_probes.iter().enumerate() {
            let [diffuse, specular] = [&files.diffuse, &files.specular].map(|file| load(file));
            let own = || {
                let all =
                    layers().flat_map(|(layer, files)| files.reflection_probes.iter().map(move |files| (layer, files)));
                all.filter(|(_, files)| files.probe == number)
            };
            waiting.extend(mixer.add(&diffuse, own().map(|(layer, files)| (layer, of_layer(&files.diffuse)))));
            waiting.extend(mixer.add(
                &specular,
                own().map(|(layer, files)| (layer, of_layer(&files.specular))),
            ));
            waiting.extend([diffuse.clone(), specular.clone()]);
            commands.spawn((probes::reflection(files, diffuse, specular), ChildOf(entity)));
        }
        for (number, files) in manifest.irradiance_volumes.iter().enumerate() {
            let voxels = load(&files.ktx2);
            waiting.push(voxels.clone());
            let own =
                layers().flat_map(|(layer, files)| files.irradiance_volumes.iter().map(move |files| (layer, files)));
            let own = own.filter(|(_, files)| files.volume == number);
            waiting.extend(mixer.add(&voxels, own.map(|(layer, files)| (layer, of_layer(&files.ktx2)))));
            commands.spawn((probes::volume(files, voxels), ChildOf(entity)));
        }
        let mut parts_of_lamps = Vec::new();
        for part in children.iter_descendants(entity) {
            parts.settle_light(
                part,
                manifest.has_direct_light(),
                !manifest.irradiance_volumes.is_empty(),
                manifest.lumens_per_watt(),
            );
            parts.settle_material(part);
            if let Some(layer) = parts.lamp(part).filter(|layer| *layer < manifest.layers.len()) {
                let of_node = children.get(part).into_iter().flatten().copied();
                parts_of_lamps.extend(of_node.chain([part]).map(|part| (layer, part)));
            }
            if parts.cameras.contains(part) {
                commands.entity(part).insert(exposure(0.0));
            }
            let Some(Place { lightmap, rect }) = parts.place(part) else {
                continue;
            };
            let Some(image) = lightmaps.get(lightmap) else {
                warn!("{}: there is no lightmap {lightmap}", level.folder);
                continue;
            };
            let [left, top, right, bottom] = rect;
            let meshes = children.get(part).into_iter().flatten();
            for mesh in meshes.filter(|mesh| parts.has_coordinates(**mesh)) {
                commands.entity(*mesh).insert(Lightmap {
                    image: image.clone(),
                    uv_rect: Rect::new(left, top, right, bottom),
                    bicubic_sampling: level.bicubic,
                });
            }
        }
        commands
            .entity(entity)
            .insert((
                mixer,
                Waiting {
                    images: waiting,
                    parts_of_lamps,
                },
            ))
            .remove::<(Manifest, Spawned)>();
    }
}

fn finish(
    mut commands: Commands,
    mut levels: Query<(Entity, &mut Waiting, &mut Mixer)>,
    assets: Res<AssetServer>,
    mut images: ResMut<Assets<Image>>,
    mut parts: Parts,
) {
    for (entity, mut waiting, mut mixer) in &mut levels {
        if !waiting.images.iter().all(|image| assets.is_loaded(image)) {
            continue;
        }
        for (layer, part) in waiting.parts_of_lamps.drain(..) {
            if let Some(color) = parts.color_of_light(part) {
                mixer.add_light(layer, part, color);
            }
            if let Some((material, emissive)) = parts.own_shining_material(part) {
                mixer.add_surface(layer, material, emissive);
            }
        }
        mixer.take_texels(&mut images);
        commands
            .entity(entity)
            .insert((mixer.lamps(), LevelReady))
            .remove::<Waiting>();
    }
}

/// What a level consists of.
#[derive(bevy::ecs::system::SystemParam)]
struct Parts<'w, 's> {
    extras: Query<'w, 's, &'static GltfExtras>,
    meshes: Query<'w, 's, &'static Mesh3d>,
    mesh_assets: Res<'w, Assets<Mesh>>,
    materials: Query<'w, 's, &'static mut MeshMaterial3d<StandardMaterial>>,
    material_assets: ResMut<'w, Assets<StandardMaterial>>,
    cameras: Query<'w, 's, (), With<Camera3d>>,
    points: Query<'w, 's, &'static mut PointLight>,
    spots: Query<'w, 's, &'static mut SpotLight>,
    suns: Query<'w, 's, &'static mut DirectionalLight>,
}

impl Parts<'_, '_> {
    /// The place of a node in the lightmaps.
    fn place(&self, node: Entity) -> Option<Place> {
        let extras = self.extras.get(node).ok()?;
        let Extras { sunroom_lightmap } = serde_json::from_str(&extras.value).ok()?;
        Some(sunroom_lightmap)
    }

    /// The number of the layer of the lamp that a node is.
    fn lamp(&self, node: Entity) -> Option<usize> {
        let extras = self.extras.get(node).ok()?;
        let LampExtras { sunroom_lamp } = serde_json::from_str(&extras.value).ok()?;
        Some(sunroom_lamp)
    }

    /// Gives a surface that shines a material of its own, which no other lamp has.
    fn own_shining_material(&mut self, mesh: Entity) -> Option<(Handle<StandardMaterial>, LinearRgba)> {
        let mut material = self.materials.get_mut(mesh).ok()?;
        let own = self.material_assets.get(&material.0)?.clone();
        let emissive = own.emissive;
        if emissive == LinearRgba::BLACK {
            return None;
        }
        material.0 = self.material_assets.add(own);
        Some((material.0.clone(), emissive))
    }

    /// The colour of a light.
    fn color_of_light(&self, light: Entity) -> Option<LinearRgba> {
        let point = self.points.get(light).map(|light| light.color);
        let spot = || self.spots.get(light).map(|light| light.color);
        let sun = || self.suns.get(light).map(|light| light.color);
        let color = point.or_else(|_| spot()).or_else(|_| sun()).ok()?;
        Some(color.to_linear())
    }

    /// Whether a mesh has coordinates for lightmaps. A part of glass has none.
    fn has_coordinates(&self, mesh: Entity) -> bool {
        let asset = self.meshes.get(mesh).ok().and_then(|mesh| self.mesh_assets.get(mesh));
        asset.is_some_and(|mesh| mesh.contains_attribute(Mesh::ATTRIBUTE_UV_1))
    }

    /// Makes a surface that shines follow the exposure.
    fn settle_material(&mut self, mesh: Entity) {
        let material = self.materials.get(mesh).ok();
        if let Some(mut material) = material.and_then(|material| self.material_assets.get_mut(material)) {
            material.emissive_exposure_weight = 1.0;
        }
    }

    /// Turns a light into what the file says, and keeps it from lighting meshes with lightmaps if these have its light.
    /// It then lights what moves, and casts shadows only if `has_volume`: without one it is the sole light there,
    /// which must come through to what stands in its shadow. So many of its lumens are one watt, of which the lightmaps
    /// are.
    fn settle_light(&mut self, light: Entity, is_baked: bool, has_volume: bool, lumens_per_watt: f32) {
        // Its light ends nowhere; that of Bevy's loader ends after 20 units.
        let range = 1e4;
        let casts = !is_baked || has_volume;
        if let Ok(mut light) = self.points.get_mut(light) {
            light.color = linear(light.color);
            light.intensity /= lumens_per_watt;
            light.range = range;
            (light.affects_lightmapped_mesh_diffuse, light.shadow_maps_enabled) = (!is_baked, casts);
        } else if let Ok(mut light) = self.spots.get_mut(light) {
            light.color = linear(light.color);
            light.intensity /= lumens_per_watt;
            light.range = range;
            (light.affects_lightmapped_mesh_diffuse, light.shadow_maps_enabled) = (!is_baked, casts);
        } else if let Ok(mut light) = self.suns.get_mut(light) {
            light.color = linear(light.color);
            light.illuminance /= lumens_per_watt;
            (light.affects_lightmapped_mesh_diffuse, light.shadow_maps_enabled) = (!is_baked, casts);
        }
    }
}

/// The colour of a light in the file, which is linear; Bevy's loader takes it for sRGB.
fn linear(color: Color) -> Color {
    let Srgba { red, green, blue, .. } = color.to_srgba();
    Color::linear_rgb(red, green, blue)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_exposure_of_no_stops_changes_nothing() {
        assert!((exposure(0.0).exposure() - 1.0).abs() < 1e-6);
        assert!((exposure(2.0).exposure() - 4.0).abs() < 1e-5);
    }
}
