//! The parts of a scene that `sunroom bake` and the window bake: its level and its probes.

use std::path::{Path, PathBuf};

use bevy::math::{Affine3A, Vec3};
use bevy::prelude::{Entity, Name, World};

use crate::bake::files::replaceable;
use crate::bake::layers::{Lamp, LampLayers, LayerKind};
use crate::bake::probes::{AskedKind, AskedProbe};
use crate::engine::{PackedScene, named_lamps};
use crate::files::Access;
use crate::gltf::write::GltfWriter;
use crate::light::LightSource;
use crate::scene::description::SceneDescription;
use crate::scene::export::{Collected, ExportError, Hidden, collect, first_in_use};
use crate::scene::{DocumentOrder, Emitter, EmitterKind, ToWorld};

/// The part of a [`crate::bake::job::BakeSource`] that comes from the description of a scene.
#[derive(Debug)]
pub struct BakedLevel {
    /// The writer of the level as a glTF file.
    pub writer: GltfWriter,
    /// The probes of the scene.
    pub probes: Vec<AskedProbe>,
    /// One sentence for each thing of the level that the file cannot hold as the scene does.
    pub messages: Vec<String>,
}

/// Makes the level that will be written to `output`, a folder or the file of a share. It may not replace files of the
/// scene. Entities in `hidden` are left out; meshes and pictures are read as far as `access` permits.
pub fn baked_level(
    scene: &SceneDescription,
    hidden: &Hidden,
    output: &Path,
    access: &Access,
) -> Result<BakedLevel, ExportError> {
    let Collected {
        writer,
        messages,
        pictures_of_libraries,
    } = collect(scene, hidden, true, access)?;
    let mut replaced = replaceable(output);
    replaced.push(output.to_owned());
    if let Some(path) = first_in_use(scene, &pictures_of_libraries, replaced.iter().map(PathBuf::as_path)) {
        let path = path.to_owned();
        return Err(ExportError::InUse { path });
    }
    let shown = scene.emitters.iter().enumerate();
    let shown = shown.filter(|(index, _)| !hidden.emitters.contains(index));
    Ok(BakedLevel {
        writer,
        probes: shown
            .filter_map(|(_, about)| asked_probe(&about.identity.name, &about.emitter, &about.to_world))
            .collect(),
        messages,
    })
}

/// The probe that an emitter stands for; None if it is a light.
fn asked_probe(name: &str, emitter: &Emitter, to_world: &Affine3A) -> Option<AskedProbe> {
    let kind = match emitter.kind {
        EmitterKind::ReflectionProbe { parallax } => AskedKind::Reflection { parallax },
        EmitterKind::IrradianceVolume { spacing } => AskedKind::Volume { spacing },
        _ => return None,
    };
    Some(AskedProbe {
        name: name.to_owned(),
        // The cube of a scene is from -1 to 1.
        world_from_box: *to_world * Affine3A::from_scale(Vec3::splat(2.0)),
        kind,
    })
}

/// The layers of the lamps of the packed scene, whose textures take at most so many bytes in a game. A sky has its sun
/// in its layer.
pub fn lamp_layers(world: &World, memory: u64) -> LampLayers {
    let (named, lamp_of_light) = named_lamps(world);
    let sources = &world.resource::<PackedScene>().lamps.sources;
    let mut kinds = vec![LayerKind::Lamp; named.len()];
    for (lamp, source) in lamp_of_light.iter().zip(sources) {
        kinds[*lamp as usize] = kind_of(&source.source);
    }
    let lamp = |((entity, name), kind): ((Entity, String), LayerKind)| Lamp {
        name,
        kind,
        order: world.get::<DocumentOrder>(entity).map_or(0, |order| order.0),
    };
    LampLayers::new(named.into_iter().zip(kinds).map(lamp).collect(), &lamp_of_light, memory)
}

fn kind_of(source: &LightSource) -> LayerKind {
    match source {
        LightSource::Constant { .. } | LightSource::Environment { .. } | LightSource::SunSky { .. } => LayerKind::Sky,
        LightSource::Directional { .. } => LayerKind::Sun,
        LightSource::Surface { .. }
        | LightSource::Point { .. }
        | LightSource::Spot(_)
        | LightSource::Luminaire(_)
        | LightSource::Projector(_) => LayerKind::Lamp,
    }
}

/// The problems with the probes of an open scene that can be found without tracing rays: a sentence for each.
pub fn probe_faults(world: &mut World) -> Vec<String> {
    let scene = world.resource::<PackedScene>().scene.as_ref();
    let bounds = scene
        .map(|scene| scene.geometry.bounds())
        .filter(|bounds| !bounds.is_empty());
    let mut emitters = world.query::<(&Emitter, &ToWorld, Option<&Name>)>();
    let asked = emitters
        .iter(world)
        .filter_map(|(emitter, to_world, name)| asked_probe(name.map_or("", Name::as_str), emitter, &to_world.0));
    let fault = |probe: AskedProbe| {
        let error = probe.check(bounds.as_ref()).err()?;
        Some(format!("{}: {error}", probe.title()))
    };
    asked.filter_map(fault).collect()
}
