//! Exports a scene to glTF 2.0, and reports the losses.
//!
//! [`export`] makes the files of a description in memory, with a sentence for each loss; [`Export::write`] writes them.
//! glTF files are built in [`crate::gltf::write`], and the table of docs/scene-format.md lists the counterparts.

mod error;
mod extras;
mod form;
mod groups;
mod in_use;
mod layers;
mod level;
mod lights;
mod look;
mod looks;
mod materials;
mod messages;
mod motion;
mod mtl_look;
mod pictures;
mod placing;
mod poses;
mod shapes;
mod tangents;

use std::collections::{BTreeSet, HashSet};
use std::path::{Path, PathBuf};

pub use self::error::ExportError;
use self::extras::extras_of;
pub use self::in_use::first_in_use;
use self::lights::Stage;
use self::messages::Messages;
use self::poses::Folders;
use self::shapes::Shapes;
use crate::files::{Access, FileSet, WriteError};
use crate::gltf::write::GltfWriter;
use crate::scene::Film;
use crate::scene::components::description::{SceneDescription, SensorDescription};

/// The files of an export, which are not written yet.
#[derive(Debug)]
pub struct Export {
    /// The files; the main one, which names the others, comes last.
    pub files: Vec<(PathBuf, Vec<u8>)>,
    /// One sentence for each loss.
    pub messages: Vec<String>,
    /// A sentence about the settings of the film, which do not affect light and are lost in every export.
    pub note: Option<String>,
}

/// Whether this file name has an extension of glTF.
pub fn is_export(path: &Path) -> bool {
    Kind::of(path).is_some()
}

#[derive(Clone, Copy, PartialEq)]
enum Kind {
    Binary,
    Text,
}

impl Kind {
    fn of(path: &Path) -> Option<Self> {
        match path.extension()?.to_ascii_lowercase().to_str()? {
            "glb" => Some(Self::Binary),
            "gltf" => Some(Self::Text),
            _ => None,
        }
    }
}

/// Makes the files of a scene for writing to `target`, a name that ends with `.glb` or `.gltf`. `hidden`: the shapes
/// and emitters that are left out. Meshes and pictures are read as far as `access` permits.
pub fn export(
    scene: &SceneDescription,
    hidden: &Hidden,
    target: &Path,
    access: &Access,
) -> Result<Export, ExportError> {
    let Some(kind) = Kind::of(target) else {
        let path = target.to_owned();
        return Err(ExportError::Ending { path });
    };
    let mut settings = Messages::default();
    report_settings(scene, &mut settings);
    let Collected {
        writer,
        messages,
        pictures_of_libraries,
    } = collect(scene, hidden, false, access)?;
    let files: Vec<(PathBuf, Vec<u8>)> = match kind {
        Kind::Binary => vec![(target.to_owned(), writer.binary()?)],
        Kind::Text => {
            let stem = target.file_stem().unwrap_or_default().to_string_lossy();
            let (text, beside) = writer.text(&stem)?;
            let beside = beside
                .into_iter()
                .map(|file| (target.with_file_name(file.name), file.bytes));
            beside.chain([(target.to_owned(), text)]).collect()
        }
    };
    let names = files.iter().map(|(path, _)| path.as_path());
    if let Some(path) = first_in_use(scene, &pictures_of_libraries, names) {
        let path = path.to_owned();
        return Err(ExportError::InUse { path });
    }
    Ok(Export {
        files,
        messages: [settings.sentences(), messages].concat(),
        note: lost_film(scene),
    })
}

/// The content of a scene's files, which may still be changed.
#[derive(Debug)]
pub struct Collected {
    /// The content.
    pub writer: GltfWriter,
    /// One sentence for each loss, except for settings of the picture.
    pub messages: Vec<String>,
    /// The pictures named by materials of mesh files, for [`first_in_use`].
    pub pictures_of_libraries: BTreeSet<PathBuf>,
}

/// Collects the content of the files of a scene. `hidden` and `access` as for [`export`]; `is_baked`: lightmaps and
/// probes are written beside the file, so that their light is not reported as left out.
pub fn collect(
    scene: &SceneDescription,
    hidden: &Hidden,
    is_baked: bool,
    access: &Access,
) -> Result<Collected, ExportError> {
    let mut writer = GltfWriter::default();
    let mut messages = Messages::default();
    let frames = scene.shapes.iter().filter(|shape| shape.shape.is_frame());
    let frames = frames.filter_map(|frame| {
        let folder = frame.identity.id.as_deref()?.strip_suffix('/')?;
        // Things in an animated folder have keys of their own.
        Some((folder.to_owned(), frame.to_world))
    });
    let extras = scene.shapes.iter().filter(|shape| shape.shape.is_frame());
    let extras = extras.filter_map(|frame| {
        let folder = frame.identity.id.as_deref()?.strip_suffix('/')?;
        Some((folder.to_owned(), extras_of(frame.identity.properties.as_ref())?))
    });
    let extras = extras.collect();
    let mut folders = Folders::new(frames, extras);
    report_media_around(scene, &mut messages);
    let mut stage = Stage {
        writer: &mut writer,
        folders: &mut folders,
        messages: &mut messages,
        access,
        is_baked,
    };
    for sensor in &scene.sensors {
        stage.camera(sensor);
    }
    for (index, emitter) in scene.emitters.iter().enumerate() {
        match hidden.emitters.contains(&index) {
            true => stage.messages.left_out("light", &emitter.identity.name, HIDDEN),
            false => stage.light(emitter),
        }
    }
    let mut shapes = Shapes::new(scene, is_baked, access);
    for (index, shape) in scene.shapes.iter().enumerate() {
        if shape.shape.is_frame() || shape.member_of.is_some() {
            continue;
        }
        match hidden.shapes.contains(&index) {
            true => messages.left_out("shape", &shape.identity.name, HIDDEN),
            false => shapes.write(shape, &mut writer, &mut folders, &mut messages)?,
        }
    }
    Ok(Collected {
        pictures_of_libraries: shapes.pictures_of_libraries(),
        messages: messages.sentences(),
        writer,
    })
}

const HIDDEN: &str = "hidden in the window";

/// The things that are hidden in the window.
#[derive(Clone, Debug, Default)]
pub struct Hidden {
    /// Indices into [`SceneDescription::shapes`].
    pub shapes: HashSet<usize>,
    /// Indices into [`SceneDescription::emitters`].
    pub emitters: HashSet<usize>,
}

/// Reports lost settings that affect the picture.
fn report_settings(scene: &SceneDescription, messages: &mut Messages) {
    let integrator = &scene.integrator;
    if let Some(depth) = integrator.max_depth {
        messages.left_out(
            "setting",
            "max_depth",
            format!("paths are not ended after {depth} segments"),
        );
    }
    if integrator.hide_emitters {
        messages.left_out("setting", "hide_emitters", "cameras see lamps");
    }
}

/// The settings of the film that differ from the defaults; glTF has none of them.
fn lost_film(scene: &SceneDescription) -> Option<String> {
    let usual = Film::of_format();
    let mut messages = Messages::default();
    for SensorDescription { film, .. } in &scene.sensors {
        let settings = [
            ("width", film.width != usual.width),
            ("height", film.height != usual.height),
            ("rfilter", film.filter != usual.filter),
            ("sample_count", film.sample_count != usual.sample_count),
            ("noise_target", film.noise_target != usual.noise_target),
            ("adaptive", film.adaptive != usual.adaptive),
        ];
        for (name, _) in settings.iter().filter(|(_, is_set)| *is_set) {
            messages.left_out("setting", name, "glTF has no film");
        }
    }
    messages.sentences().pop()
}

/// Reports cameras and lights in a medium, which is lost.
fn report_media_around(scene: &SceneDescription, messages: &mut Messages) {
    let integrator = &scene.integrator;
    let sensors = scene
        .sensors
        .iter()
        .filter_map(|sensor| Some((sensor.medium?, "camera")));
    let emitters = scene
        .emitters
        .iter()
        .filter_map(|emitter| Some((emitter.medium?, "light")));
    for (medium, what) in sensors.chain(emitters).filter(|_| integrator.plugin.traces_media()) {
        if let Some(medium) = scene.media.get(medium) {
            let why = format!("no {what} of glTF is in a medium");
            messages.left_out("medium", &medium.identity.name, why);
        }
    }
}

impl Export {
    /// Writes the files, which replace older ones in one step.
    pub fn write(&self) -> Result<(), ExportError> {
        let Some((main, _)) = self.files.last() else {
            return Ok(());
        };
        let mut set = FileSet::new(main);
        for (path, bytes) in &self.files {
            set.add(path, bytes)?;
        }
        Ok(set.replace()?)
    }
}

impl From<WriteError> for ExportError {
    fn from(WriteError { path, source }: WriteError) -> Self {
        Self::File { path, source }
    }
}
