//! The origin of a picture, for parts and checkpoints: digests of the scene's files, and the settings.

use std::collections::BTreeMap;
use std::collections::btree_map::Entry;
use std::io::{self, Read};
use std::path::{Path, PathBuf};

use bevy::prelude::*;

use crate::document::paths::file_name;
use crate::engine::{PackedScene, RenderStatus, set_choice};
use crate::files;
use crate::layer::Layers;
use crate::render::auto::{Choice, Method};
use crate::render::part::{FileDigest, Origin};
use crate::scene::assets::parts_cache::is_cached_part;
use crate::scene::{IntegratorSettings, SceneWatch};

/// Digests of the files that were read so far: each file is hashed once, however many frames are rendered. None stands
/// for a file that is derived from others.
#[derive(Resource, Default)]
struct Digests(BTreeMap<PathBuf, Option<FileDigest>>);

/// The inputs of the picture of the packed scene. The files are those that were [recorded](files::record_reads); paths
/// are relative to the folder of `scene`. Parts of glTF files in the user's cache are left out: they are derived from
/// the glTF files, and lie elsewhere on another machine. `others` are further settings by name. An error names a file
/// that cannot be read any more.
pub fn origin(world: &mut World, scene: &Path, others: Vec<(String, String)>) -> Result<Origin, String> {
    let folder = folder_of(scene);
    let mut known = world.get_resource_or_init::<Digests>();
    for path in files::recorded_reads() {
        if let Entry::Vacant(place) = known.0.entry(path) {
            let digest = digest_within(&folder, place.key())?;
            place.insert(digest);
        }
    }
    let digests = known.0.values().flatten().cloned().collect();
    Ok(assemble(world, digests, others))
}

/// The same for a scene that is open in a window: its existing files are hashed as they are now.
pub fn origin_of_open(world: &World, scene: &Path, others: Vec<(String, String)>) -> Result<Origin, String> {
    let folder = folder_of(scene);
    let files = world.resource::<SceneWatch>().files().filter(|file| file.is_file());
    let digests: Result<Vec<_>, String> = files.map(|file| digest_within(&folder, file)).collect();
    Ok(assemble(world, digests?.into_iter().flatten().collect(), others))
}

/// The name of the setting that exists if `auto` has chosen another integrator than `path`.
const CHOICE: &str = "the choice of the integrator auto";
/// Its value for guided paths.
const GUIDED: &str = "guided path";

/// Makes `auto` choose the same integrator as in a picture of this origin, so that the picture can resume. Returns
/// false if `auto` is not set.
pub fn take_choice(world: &mut World, then: &Origin) -> bool {
    if world.resource::<RenderStatus>().auto.is_none() {
        return false;
    }
    let chosen = then.settings.iter().find(|(name, _)| name == CHOICE);
    let choice = Choice {
        method: match chosen.map(|(_, value)| value.as_str()) {
            None => Method::Path,
            Some(GUIDED) => Method::GuidedPath,
            Some(_) => Method::Bidirectional,
        },
        ..Choice::UNTRIED
    };
    set_choice(world, choice);
    let is_guided = world.resource::<IntegratorSettings>().guided;
    if let Some(auto) = &mut world.resource_mut::<RenderStatus>().auto {
        auto.choice = choice;
        auto.integrator = choice.or_guided(is_guided).name(false);
    }
    true
}

fn folder_of(scene: &Path) -> PathBuf {
    let scene = scene.canonicalize().unwrap_or_else(|_| scene.to_owned());
    scene.parent().map_or_else(PathBuf::new, Path::to_owned)
}

/// The digest of a file by its path relative to a folder; None for a file derived from others.
fn digest_within(folder: &Path, path: &Path) -> Result<Option<FileDigest>, String> {
    let full = path.canonicalize().unwrap_or_else(|_| path.to_owned());
    if is_cached_part(&full) {
        return Ok(None);
    }
    Ok(Some(FileDigest {
        path: file_name(&full, folder),
        digest: digest(&full).map_err(|error| format!("{}: {error}", path.display()))?,
    }))
}

fn assemble(world: &World, mut digests: Vec<FileDigest>, others: Vec<(String, String)>) -> Origin {
    digests.sort_by(|a, b| a.path.cmp(&b.path));
    digests.dedup();
    let mut settings = Vec::new();
    if let Some(view) = &world.resource::<PackedScene>().view {
        let mut add = |name: &str, value: String| settings.push((name.to_owned(), value));
        add("the size", format!("{} x {}", view.width, view.height));
        add("the seed", view.seed.to_string());
        add("the sampler", format!("{:?}", view.sequence));
        add("the camera", format!("{:?}", view.camera));
        add("the reconstruction filter", short(format!("{:?}", view.filter)));
        // The layers have a setting of their own.
        let integrator = IntegratorSettings {
            layers: Layers::default(),
            ..*world.resource::<IntegratorSettings>()
        };
        add("the integrator", format!("{integrator:?}"));
        add(
            "the list of layers",
            view.layers
                .iter()
                .map(|layer| layer.name())
                .collect::<Vec<_>>()
                .join(","),
        );
        add("the grouping of lights", short(format!("{:?}", view.light_groups)));
    }
    let auto = world.get_resource::<RenderStatus>().and_then(|status| status.auto);
    if let Some(auto) = auto.filter(|auto| auto.choice.method != Method::Path) {
        settings.push((CHOICE.to_owned(), auto.choice.name(false).to_owned()));
    }
    settings.extend(others.into_iter().map(|(name, value)| (name, short(value))));
    Origin {
        version: env!("CARGO_PKG_VERSION").to_owned(),
        samples: Origin::SAMPLES,
        files: digests,
        settings,
    }
}

/// A digest of the content of a file.
pub fn digest(path: &Path) -> io::Result<String> {
    let mut file = files::open(path, files::LARGEST_DATA)?;
    let (mut hasher, mut buffer) = (blake3::Hasher::new(), vec![0; 1 << 20]);
    loop {
        match file.read(&mut buffer)? {
            0 => return Ok(hasher.finalize().to_hex().to_string()),
            count => drop(hasher.update(&buffer[..count])),
        }
    }
}

/// A digest of a long text.
fn short(text: String) -> String {
    match text.len() > 200 {
        true => blake3::hash(text.as_bytes()).to_hex().to_string(),
        false => text,
    }
}
