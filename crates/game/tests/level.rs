//! Loads a level that `sunroom bake tests/level.xml -o tests/level --texels-per-unit 4 --atlas-size 64 --probe-size 16
//! --probe-spacing 1` has written, without a graphics card.

use std::fs;
use std::path::Path;
use std::time::{Duration, Instant};

use bevy::app::PluginsState;
use bevy::asset::AssetPlugin;
use bevy::light::{EnvironmentMapLight, GlobalAmbientLight, IrradianceVolume, LightProbe};
use bevy::pbr::Lightmap;
use bevy::prelude::*;
use bevy::render::RenderPlugin;
use bevy::render::render_resource::TextureViewDimension;
use bevy::render::settings::{RenderCreation, WgpuSettings};
use bevy::window::ExitCondition;
use bevy::winit::WinitPlugin;
use sunroom_game::{Lamps, LevelReady, SunroomLevel, SunroomLevelPlugin};

const FOLDER: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/tests");

/// An app that has loaded the level in a folder of assets.
fn app_with(assets: &Path, level: SunroomLevel) -> App {
    let no_graphics_card = WgpuSettings {
        backends: None,
        ..default()
    };
    let plugins = DefaultPlugins
        .set(AssetPlugin {
            file_path: assets.to_string_lossy().into_owned(),
            ..default()
        })
        .set(WindowPlugin {
            primary_window: None,
            exit_condition: ExitCondition::DontExit,
            ..default()
        })
        .set(RenderPlugin {
            render_creation: RenderCreation::Automatic(Box::new(no_graphics_card)),
            ..default()
        });
    let mut app = App::new();
    app.add_plugins((
        plugins.disable::<WinitPlugin>().disable::<bevy::log::LogPlugin>(),
        SunroomLevelPlugin,
    ));
    while app.plugins_state() == PluginsState::Adding {
        bevy::tasks::tick_global_task_pools_on_main_thread();
    }
    app.finish();
    app.cleanup();
    app.world_mut().spawn(level);
    let begin = Instant::now();
    while app.world_mut().query::<&LevelReady>().iter(app.world()).count() == 0 {
        assert!(begin.elapsed() < Duration::from_secs(60), "the level is not there");
        app.update();
    }
    app
}

/// The lightmap of the one mesh of a node.
fn lightmap(app: &mut App, node: &str) -> Option<Lightmap> {
    let world = app.world_mut();
    let mut nodes = world.query::<(&Name, &Children)>();
    let (_, children) = nodes
        .iter(world)
        .find(|(name, _)| name.as_str() == node)
        .expect("the level has the node");
    let mesh = children
        .iter()
        .find(|child| world.get::<Mesh3d>(*child).is_some())
        .expect("a node with a mesh");
    world.get::<Lightmap>(mesh).cloned()
}

fn bulb(app: &mut App) -> PointLight {
    let world = app.world_mut();
    *world.query::<&PointLight>().single(world).expect("a light")
}

#[test]
fn meshes_get_their_places_in_the_lightmap() {
    let mut app = app_with(Path::new(FOLDER), SunroomLevel::new("level"));
    let [floor, left, right] =
        ["floor", "left crate", "right crate"].map(|node| lightmap(&mut app, node).expect("a lightmap"));
    assert_eq!(floor.uv_rect, Rect::new(0.0, 0.0, 1.0, 1.0));
    assert_eq!(left.image, right.image);
    assert_eq!(left.uv_rect.size(), right.uv_rect.size());
    assert!(left.uv_rect.intersect(right.uv_rect).is_empty());
    let images = app.world().resource::<Assets<Image>>();
    let image = images.get(&floor.image).expect("the picture is loaded");
    assert_eq!(image.width(), 64);
    assert!(lightmap(&mut app, "glass").is_none());
    assert!(lightmap(&mut app, "lamp").is_none());
}

#[test]
fn lights_that_are_baked_do_not_light_twice() {
    let mut app = app_with(Path::new(FOLDER), SunroomLevel::new("level"));
    let bulb = bulb(&mut app);
    // What moves has indirect light from the volume, so that a shadow is not black.
    assert!(!bulb.affects_lightmapped_mesh_diffuse && bulb.shadow_maps_enabled);
    assert_eq!(app.world().resource::<GlobalAmbientLight>().brightness, 0.0);
}

#[test]
fn lights_that_are_left_to_the_game_are_what_the_scene_has() {
    let copy = tempfile::tempdir().expect("a folder");
    fs::create_dir(copy.path().join("level")).expect("a folder");
    for file in fs::read_dir(Path::new(FOLDER).join("level")).expect("the level") {
        let file = &*file.expect("an entry").file_name();
        let mut bytes = fs::read(Path::new(FOLDER).join("level").join(file)).expect("a file of the level");
        if file == "lightmaps.json" {
            let text = String::from_utf8(bytes).expect("text");
            assert!(text.contains(r#""light": "all""#));
            bytes = text
                .replace(r#""light": "all""#, r#""light": "without_direct_punctual""#)
                .into();
        }
        fs::write(copy.path().join("level").join(file), bytes).expect("a copy");
    }
    let mut app = app_with(copy.path(), SunroomLevel::new("level"));
    let bulb = bulb(&mut app);
    assert!(bulb.affects_lightmapped_mesh_diffuse && bulb.shadow_maps_enabled);
    // 8, 2, 0 W/sr in the scene.
    let intensity = bulb.intensity / (4.0 * std::f32::consts::PI);
    let color = bulb.color.to_linear() * intensity;
    let difference = [color.red - 8.0, color.green - 2.0, color.blue];
    assert!(difference.iter().all(|part| part.abs() < 1e-3), "{color:?}");
}

#[test]
fn surfaces_that_shine_follow_the_exposure() {
    let app = app_with(Path::new(FOLDER), SunroomLevel::new("level"));
    let materials = app.world().resource::<Assets<StandardMaterial>>();
    let shining: Vec<_> = materials
        .iter()
        .filter(|(_, material)| material.emissive != LinearRgba::BLACK)
        .collect();
    let [(_, lamp)] = &shining[..] else {
        panic!("{} materials shine", shining.len());
    };
    assert_eq!((lamp.emissive.red, lamp.emissive_exposure_weight), (4.0, 1.0));
}

#[test]
fn probes_stand_where_the_scene_has_them() {
    let mut app = app_with(Path::new(FOLDER), SunroomLevel::new("level"));
    let world = app.world_mut();
    let mut probes = world.query::<(&LightProbe, &EnvironmentMapLight, &GlobalTransform)>();
    let (_, light, place) = probes.single(world).expect("a reflection probe");
    assert!(!light.affects_lightmapped_mesh_diffuse && light.intensity == 1.0);
    // A little larger than the level, of 4 x 2 x 4.
    let corner = place.transform_point(Vec3::splat(0.5));
    assert!(corner.abs_diff_eq(Vec3::new(2.04, 2.02, 2.04), 1e-3), "{corner}");
    let (specular, diffuse) = (light.specular_map.clone(), light.diffuse_map.clone());
    let mut volumes = world.query::<(&LightProbe, &IrradianceVolume, &GlobalTransform)>();
    let (_, light, place) = volumes.single(world).expect("an irradiance volume");
    assert!(!light.affects_lightmapped_meshes && light.intensity == 1.0);
    let corner = place.transform_point(Vec3::splat(-0.5));
    assert!(corner.abs_diff_eq(Vec3::new(-2.0, 0.0, -2.0), 1e-3), "{corner}");
    let voxels = light.voxels.clone();

    let images = world.resource::<Assets<Image>>();
    let kind = |image: &Handle<Image>| {
        let image = images.get(image).expect("the picture is loaded");
        let view = image.texture_view_descriptor.as_ref().and_then(|view| view.dimension);
        let size = image.texture_descriptor.size;
        let sides = [size.width, size.height, size.depth_or_array_layers];
        (view, sides, image.texture_descriptor.mip_level_count)
    };
    assert_eq!(kind(&specular), (Some(TextureViewDimension::Cube), [16, 16, 6], 3));
    assert_eq!(kind(&diffuse), (Some(TextureViewDimension::Cube), [16, 16, 6], 1));
    assert_eq!(kind(&voxels), (Some(TextureViewDimension::D3), [4, 4, 12], 1));
}

#[test]
fn cameras_come_along_if_they_are_wanted() {
    let cameras = |app: &mut App| {
        let world = app.world_mut();
        world.query::<&Camera3d>().iter(world).count()
    };
    let level = SunroomLevel::new("level");
    assert_eq!(cameras(&mut app_with(Path::new(FOLDER), level.clone())), 0);
    let mut app = app_with(Path::new(FOLDER), SunroomLevel { cameras: true, ..level });
    assert_eq!(cameras(&mut app), 1);
}

/// The halves of a texture, all levels of it.
fn halves(app: &App, texture: &Handle<Image>) -> Vec<f32> {
    let image = app
        .world()
        .resource::<Assets<Image>>()
        .get(texture)
        .expect("it is loaded");
    let bytes = image.data.as_ref().expect("it is kept");
    let pairs = bytes.chunks_exact(2);
    pairs
        .map(|pair| half::f16::from_le_bytes([pair[0], pair[1]]).to_f32())
        .collect()
}

#[test]
fn lamps_are_dimmed_in_all_textures() {
    let copy = tempfile::tempdir().expect("a folder");
    let folder = copy.path().join("level");
    fs::create_dir(&folder).expect("a folder");
    for file in fs::read_dir(Path::new(FOLDER).join("level")).expect("the level") {
        let path = file.expect("an entry").path();
        let name = path.file_name().expect("a name").to_string_lossy().into_owned();
        fs::copy(&path, folder.join(&name)).expect("a copy");
        // A lamp that gives all of the light.
        if let Some(stem) = name.strip_suffix(".ktx2") {
            fs::copy(&path, folder.join(format!("{stem}-layer.ktx2"))).expect("a copy");
        }
    }
    let manifest = folder.join("lightmaps.json");
    let text = fs::read_to_string(&manifest).expect("the manifest");
    let mut about: serde_json::Value = serde_json::from_str(&text).expect("JSON");
    about["layers"] = serde_json::json!([{
        "name": "bulb", "kind": "lamp", "factor": [1, 1, 1], "nodes": [],
        "lightmaps": [{ "lightmap": 0, "exr": "lightmap-0-layer.exr", "ktx2": "lightmap-0-layer.ktx2" }],
        "reflection_probes": [{
            "probe": 0, "specular": "reflection-0-specular-layer.ktx2", "diffuse": "reflection-0-diffuse-layer.ktx2",
        }],
        "irradiance_volumes": [{ "volume": 0, "ktx2": "irradiance-0-layer.ktx2" }],
    }]);
    fs::write(&manifest, about.to_string()).expect("a manifest");
    let mut app = app_with(copy.path(), SunroomLevel::new("level"));
    let mut textures = vec![lightmap(&mut app, "floor").expect("a lightmap").image];
    let world = app.world_mut();
    for probe in world.query::<&EnvironmentMapLight>().iter(world) {
        textures.extend([probe.diffuse_map.clone(), probe.specular_map.clone()]);
    }
    for volume in world.query::<&IrradianceVolume>().iter(world) {
        textures.push(volume.voxels.clone());
    }
    assert_eq!(textures.len(), 4);
    let before: Vec<Vec<f32>> = textures.iter().map(|texture| halves(&app, texture)).collect();
    let dim = |app: &mut App, strength: f32| {
        let world = app.world_mut();
        let mut lamps = world.query::<&mut Lamps>().single_mut(world).expect("a level");
        assert!(lamps.set("bulb", strength) && !lamps.set("another", 1.0));
        app.update();
    };
    for strength in [0.5, 0.0, 1.0] {
        dim(&mut app, strength);
        for (texture, before) in textures.iter().zip(&before) {
            let now = halves(&app, texture);
            assert_eq!(now.len(), before.len());
            for (place, (now, before)) in now.iter().zip(before).enumerate() {
                let expected = if place % 4 == 3 { 1.0 } else { strength * before };
                // The smallest half floats have fewer digits.
                assert!((now - expected).abs() < 1e-7, "{now} for {expected}");
            }
        }
    }
}
