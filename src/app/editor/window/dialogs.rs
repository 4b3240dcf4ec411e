//! The file dialog: one at a time, drawn inside the window.

use std::path::{Path, PathBuf};

use bevy::prelude::Resource;
use bevy_egui::egui;

use super::file_dialog::listing::folders_of;
use super::file_dialog::{FileDialog, Outcome, Place, Purpose};
use crate::app::editor::command::samples::{is_sample, program_folder, program_folders};
use crate::app::editor::command::scene::Replacement;
use crate::app::editor::command::shell::{ShellCommand, SoughtFile};
use crate::app::editor::command::{
    BakeCommand, Command, FileCommand, FileDialogKind, LightPaintCommand, SceneEdit, TextureEdit,
};
use crate::app::editor::session::requests::Requests;
use crate::app::editor::session::toasts::Toasts;
use crate::app::editor::session::trust::asset_folders;
use crate::app::editor::words::files::{
    LAMPS, PICTURES, PICTURES_AND_LAMPS, SCENE_FILES, VOLUMES, extension, is_lamp, noisy_beside,
};
use crate::files::{LARGEST_NOTE, check_writable, read_text};
use crate::render::image_io::FileFormat;
use crate::render::tonemap::ToneMap;
use crate::scene::FileKind;

#[derive(Resource, Default)]
pub struct Dialogs {
    open: Option<(FileDialogKind, FileDialog)>,
    /// The folder in which a picture was last saved, and its scene.
    image_folder: Option<(Option<PathBuf>, PathBuf)>,
    /// The format in which a picture was last saved.
    image_ending: Option<&'static str>,
    /// The folder from which a picture was last taken.
    picture_folder: Option<PathBuf>,
    /// The folder of the last import.
    import_folder: Option<PathBuf>,
    /// The folder to which a scene was last exported.
    export_folder: Option<PathBuf>,
    /// The folder in which a missing file was last found.
    found_folder: Option<PathBuf>,
    /// The parent of the folder that was last chosen.
    around_folder: Option<PathBuf>,
}

/// The inputs of a dialog's defaults.
#[derive(Clone, Copy)]
pub struct DialogModel<'a> {
    /// The file of the open scene.
    pub scene: Option<&'a Path>,
    /// The tone map of saved pictures.
    pub tone_map: ToneMap,
    /// Whether pictures are denoised: radiance is then saved as sampled as well.
    pub denoises: bool,
    /// The recent files, the last first.
    pub recent: &'a [PathBuf],
}

impl Dialogs {
    /// Opens the requested dialog, shows it, and turns a picked file into a command.
    pub fn show(
        &mut self,
        context: &egui::Context,
        model: DialogModel,
        requests: &mut Requests,
        toasts: &mut Toasts,
        commands: &mut Vec<Command>,
    ) {
        let Some(wanted) = requests.dialog else {
            self.open = None;
            return;
        };
        if self.open.as_ref().is_none_or(|(kind, _)| *kind != wanted) {
            let ending = self.image_ending.unwrap_or("png");
            let dialog = opened(
                wanted,
                model,
                &self.start(wanted, model),
                ending,
                requests.sought.as_ref(),
            );
            self.open = Some((wanted, dialog));
        }
        let Some((kind, dialog)) = &mut self.open else {
            return;
        };
        match dialog.show(context) {
            Outcome::Open => return,
            Outcome::Cancelled => {}
            Outcome::Picked(path) => {
                let folder = path.parent().map(Path::to_path_buf);
                match kind {
                    FileDialogKind::SaveImage => {
                        let ending = extension(&path);
                        let format = IMAGES.iter().find(|(_, known)| *known == ending);
                        self.image_ending = format.map(|(_, known)| *known).or(self.image_ending);
                        self.image_folder = folder.map(|folder| (model.scene.map(Path::to_path_buf), folder));
                    }
                    FileDialogKind::OpenPicture { .. }
                    | FileDialogKind::OpenEnvironment
                    | FileDialogKind::WantedPicture => self.picture_folder = folder,
                    FileDialogKind::Import | FileDialogKind::Replace => self.import_folder = folder,
                    FileDialogKind::AssetFolder | FileDialogKind::BakeFolder => self.around_folder = folder,
                    FileDialogKind::ExportScene => self.export_folder = folder,
                    FileDialogKind::FindFile(_) => self.found_folder = folder,
                    FileDialogKind::OpenScene | FileDialogKind::SaveScene => {}
                }
                match picked(*kind, path, requests.sought.take()) {
                    Ok(command) => commands.push(command),
                    Err(message) => toasts.reject(message),
                }
            }
        }
        (self.open, requests.dialog, requests.sought) = (None, None, None);
    }

    /// The folder in which a dialog begins.
    fn start(&self, wanted: FileDialogKind, model: DialogModel) -> PathBuf {
        let last_of_scene = || {
            let (scene, folder) = self.image_folder.as_ref()?;
            (scene.as_deref() == model.scene).then(|| folder.clone())
        };
        let before = match wanted {
            FileDialogKind::SaveImage => last_of_scene()
                .or_else(|| beside(model.scene).filter(|folder| check_writable(&folder.join("picture.png")).is_ok()))
                .or_else(|| own_folder(model)),
            FileDialogKind::SaveScene => own_folder(model),
            FileDialogKind::ExportScene => self.export_folder.clone().or_else(|| own_folder(model)),
            FileDialogKind::OpenPicture { .. } | FileDialogKind::OpenEnvironment | FileDialogKind::WantedPicture => {
                self.picture_folder.clone()
            }
            FileDialogKind::Import | FileDialogKind::Replace => self.import_folder.clone(),
            FileDialogKind::FindFile(_) => self.found_folder.clone(),
            FileDialogKind::AssetFolder => self.around_folder.clone(),
            FileDialogKind::BakeFolder => self.around_folder.clone().or_else(|| own_folder(model)),
            FileDialogKind::OpenScene => None,
        };
        let start = before.or_else(|| beside(model.scene));
        start.or_else(|| program_folder("scenes")).unwrap_or_else(|| ".".into())
    }
}

/// The folder for saves if the open scene is a sample, or has no file: the folder of the last file of the user's own,
/// or else the documents. None for other scenes, which have a folder.
fn own_folder(model: DialogModel) -> Option<PathBuf> {
    if model
        .scene
        .is_some_and(|scene| beside(Some(scene)).is_some() && !is_sample(scene))
    {
        return None;
    }
    let mut own = model.recent.iter().filter(|file| file.is_file() && !is_sample(file));
    let last = own.find_map(|file| beside(Some(file)));
    let home = std::env::home_dir().filter(|home| home.is_dir());
    last.or_else(|| documents(home.as_deref()?).or(home))
}

/// The folder for documents in a home folder: the one in the desktop's settings (`user-dirs.dirs` of freedesktop.org),
/// whose name depends on the language, or else `Documents`. None if neither is there.
fn documents(home: &Path) -> Option<PathBuf> {
    let notes = read_text(&home.join(".config/user-dirs.dirs"), LARGEST_NOTE).unwrap_or_default();
    let noted = notes.lines().find_map(|line| {
        let name = line.trim().strip_prefix("XDG_DOCUMENTS_DIR=")?.trim_matches('"');
        // Without `$HOME` the name is absolute. The home folder itself means that there is none.
        let folder = home.join(
            name.strip_prefix("$HOME")
                .map_or(name, |inside| inside.trim_start_matches('/')),
        );
        (folder.is_dir() && folder != home.join("")).then_some(folder)
    });
    noted.or_else(|| Some(home.join("Documents")).filter(|folder| folder.is_dir()))
}

/// The folder of the scene's file.
fn beside(scene: Option<&Path>) -> Option<PathBuf> {
    let folder = scene.and_then(Path::parent)?;
    (!folder.as_os_str().is_empty()).then(|| folder.to_path_buf())
}

fn absolute(path: &Path) -> PathBuf {
    std::path::absolute(path).unwrap_or_else(|_| path.to_path_buf())
}

/// The shortcuts to folders, each once: of the scene, of samples and assets, of the user, and of recent files.
fn places(scene: Option<&Path>, recent: &[PathBuf]) -> Vec<Place> {
    let named = |name: &str, folder: PathBuf| (name.to_owned(), absolute(&folder), false);
    let called = |folder: PathBuf, is_recent: bool| {
        let name = folder
            .file_name()
            .map_or_else(|| folder.to_string_lossy(), |name| name.to_string_lossy());
        (name.into_owned(), absolute(&folder), is_recent)
    };
    let own = beside(scene).map(|folder| named("The scene's folder", folder));
    let samples = program_folders().map(|(name, folder)| named(name, folder));
    let assets = asset_folders().into_iter().map(|folder| called(folder, false));
    let home = std::env::home_dir().map(|folder| named("Home", folder));
    let root = absolute(Path::new("."))
        .ancestors()
        .last()
        .map(|root| called(root.to_path_buf(), false));
    let recent = folders_of(recent).into_iter().map(|folder| called(folder, true));
    let all = own
        .into_iter()
        .chain(samples)
        .chain(assets)
        .chain(home)
        .chain(root)
        .chain(recent);
    let mut places: Vec<Place> = Vec::new();
    for (name, folder, is_recent) in all {
        // Recent folders may be many, and on a network that is slow or gone, so that they are not checked.
        if (is_recent || folder.is_dir()) && !places.iter().any(|place| place.folder == folder) {
            let place = Place {
                name,
                folder,
                is_recent,
            };
            places.push(place);
        }
    }
    places
}

/// The command of a finished dialog; a message if the file is of another kind.
fn picked(kind: FileDialogKind, path: PathBuf, sought: Option<SoughtFile>) -> Result<Command, String> {
    Ok(match kind {
        FileDialogKind::FindFile(_) => {
            let sought = sought.ok_or("No file is looked for any more.")?;
            Command::from(SceneEdit::FindFile {
                missing: sought.path,
                found: path,
                others: sought.others,
            })
        }
        FileDialogKind::OpenScene => Command::from(FileCommand::OpenScene(path)),
        FileDialogKind::WantedPicture => Command::from(LightPaintCommand::SetTarget(Some(path))),
        FileDialogKind::AssetFolder => Command::Shell(ShellCommand::AddAssetFolder(path)),
        FileDialogKind::BakeFolder => Command::Bake(BakeCommand::ChooseFolder(path)),
        FileDialogKind::SaveScene => Command::from(FileCommand::SaveScene(path)),
        FileDialogKind::ExportScene => Command::from(FileCommand::ExportScene(path)),
        FileDialogKind::SaveImage => Command::from(FileCommand::SaveImage(path)),
        FileDialogKind::OpenEnvironment if !PICTURES.contains(&extension(&path).as_str()) => {
            let known = PICTURES.join(", ");
            return Err(format!(
                "{}: not a picture for an environment ({known})",
                path.display()
            ));
        }
        FileDialogKind::Import | FileDialogKind::OpenEnvironment => Command::from(SceneEdit::Import(path)),
        FileDialogKind::Replace => Command::from(SceneEdit::Replace(Replacement::File(path))),
        FileDialogKind::OpenPicture {
            owner,
            parameter,
            place,
        } => Command::from(TextureEdit::SetPicture {
            owner,
            parameter,
            place,
            path,
        }),
    })
}

/// The extensions of files whose mesh other shapes can get.
const MESHES: &[&str] = &["obj", "ply", "serialized", "glb", "gltf", "xml"];
/// The extensions of files that can be imported: meshes, scenes, volumes, lamps and environments.
const IMPORTS: &[&str] = &[
    "obj",
    "ply",
    "serialized",
    "hdr",
    "exr",
    "xml",
    "glb",
    "gltf",
    "vol",
    "vdb",
    "ies",
    "ldt",
];
const EXPORTS: &[(&str, &str)] = &[("glTF, one file", "glb"), ("glTF, with files beside it", "gltf")];
const IMAGES: &[(&str, &str)] = &[
    ("PNG, as shown", "png"),
    ("JPEG, as shown", "jpg"),
    ("EXR, linear", "exr"),
    ("HDR, linear", "hdr"),
    ("PFM, linear", "pfm"),
];

/// The dialog, in the folder `start`. `ending`: the extension of a picture; `sought`: the missing file to find.
fn opened(
    kind: FileDialogKind,
    model: DialogModel,
    start: &Path,
    ending: &str,
    sought: Option<&SoughtFile>,
) -> FileDialog {
    let proposed = |otherwise, extension| proposed_name(model.scene, otherwise, extension);
    let (title, purpose) = match kind {
        FileDialogKind::OpenScene => ("Open a scene".to_owned(), Purpose::Open(&SCENE_FILES)),
        FileDialogKind::Import => (
            "Import a mesh, a volume, a scene, a lamp or an environment".to_owned(),
            Purpose::Open(IMPORTS),
        ),
        FileDialogKind::Replace => ("Replace by a mesh".to_owned(), Purpose::Open(MESHES)),
        FileDialogKind::FindFile(kind) => (
            sought.map_or_else(
                || "Find the file".to_owned(),
                |sought| {
                    let name = sought.path.file_name().unwrap_or_default().to_string_lossy();
                    format!("Find {name}")
                },
            ),
            Purpose::Open(match kind {
                FileKind::Mesh => &["obj", "ply", "serialized"],
                FileKind::Picture if sought.is_some_and(|sought| is_lamp(&sought.path)) => &LAMPS,
                FileKind::Picture => &PICTURES,
                FileKind::Volume => &VOLUMES,
            }),
        ),
        FileDialogKind::OpenEnvironment => ("Choose an environment map".to_owned(), Purpose::Open(&PICTURES)),
        FileDialogKind::WantedPicture => ("Choose the wanted picture".to_owned(), Purpose::Open(&PICTURES)),
        // The file of an environment or of a lamp.
        FileDialogKind::OpenPicture {
            parameter: "filename", ..
        } => ("Choose a file of light".to_owned(), Purpose::Open(&PICTURES_AND_LAMPS)),
        FileDialogKind::OpenPicture { .. } => ("Choose a picture".to_owned(), Purpose::Open(&PICTURES)),
        FileDialogKind::AssetFolder => ("Add a folder to the assets".to_owned(), Purpose::Folder),
        FileDialogKind::BakeFolder => ("Choose a folder for the level".to_owned(), Purpose::Folder),
        FileDialogKind::SaveScene => (
            "Save the scene".to_owned(),
            Purpose::Save(&[("Scene", "xml")], proposed("scene", "xml")),
        ),
        FileDialogKind::ExportScene => (
            "Export the scene to glTF".to_owned(),
            Purpose::Save(EXPORTS, proposed("scene", "glb")),
        ),
        FileDialogKind::SaveImage => (
            format!("Save the picture (PNG: tone map {})", model.tone_map.name()),
            Purpose::Save(IMAGES, proposed("picture", ending)),
        ),
    };
    let dialog = FileDialog::new(title, purpose, absolute(start), places(model.scene, model.recent));
    match kind {
        FileDialogKind::SaveImage if model.denoises => dialog.with_second(|path| {
            let is_displayed = FileFormat::from_path(path).ok()?.is_displayed();
            (!is_displayed).then(|| noisy_beside(path))
        }),
        _ => dialog,
    }
}

/// The name of the scene's file with this extension; `otherwise` without a scene.
fn proposed_name(scene: Option<&Path>, otherwise: &str, extension: &str) -> String {
    let stem = scene
        .and_then(Path::file_stem)
        .map_or(otherwise.into(), |stem| stem.to_string_lossy());
    format!("{stem}.{extension}")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_environment_is_a_picture() {
        let chosen = |path: &str| picked(FileDialogKind::OpenEnvironment, path.into(), None);
        assert!(chosen("room.xml").is_err() && chosen("room").is_err());
        assert_eq!(chosen("sky.HDR"), Ok(SceneEdit::Import("sky.HDR".into()).into()));
        let imported = picked(FileDialogKind::Import, "room.xml".into(), None);
        assert_eq!(imported, Ok(SceneEdit::Import("room.xml".into()).into()));
    }

    #[test]
    fn places_are_folders_that_are_there_each_once() {
        let folder = tempfile::tempdir().expect("a folder");
        let scene = folder.path().join("room.xml");
        let recent = [scene.clone(), folder.path().join("none/other.xml")];
        let places = places(Some(&scene), &recent);
        assert_eq!(places[0].name, "The scene's folder");
        assert_eq!(places[0].folder, folder.path());
        let same = places.iter().filter(|place| place.folder == folder.path());
        assert_eq!(same.count(), 1);
        // The tests run in a checkout.
        assert!(places.iter().any(|place| place.name == "Sample scenes"));
        assert!(places.iter().all(|place| place.folder.is_dir() != place.is_recent));
    }

    #[test]
    fn what_is_made_of_a_sample_is_saved_among_the_files_of_its_user() {
        let folder = tempfile::tempdir().expect("a folder");
        let own = folder.path().join("room.xml");
        std::fs::write(&own, "").expect("a file");
        let sample = program_folder("scenes").expect("a checkout").join("flat.xml");
        let recent = [sample.clone(), folder.path().join("gone/other.xml"), own.clone()];
        let start = |scene: Option<&Path>, recent: &[PathBuf]| {
            own_folder(DialogModel {
                scene,
                tone_map: ToneMap::Clip,
                denoises: false,
                recent,
            })
        };
        assert_eq!(start(Some(&sample), &recent), Some(folder.path().to_path_buf()));
        assert_eq!(start(None, &recent), Some(folder.path().to_path_buf()));
        assert_eq!(start(Some(&own), &recent), None);
        assert_ne!(start(Some(&sample), &recent[..2]), beside(Some(&sample)));
    }

    #[test]
    fn documents_lie_where_the_desktop_has_noted() {
        let home = tempfile::tempdir().expect("a folder");
        let note = |line: &str| std::fs::write(home.path().join(".config/user-dirs.dirs"), line).expect("a file");
        let of = |name: &str| Some(home.path().join(name));
        assert_eq!(documents(home.path()), None);
        for name in [".config", "Documents", "Dokumente"] {
            std::fs::create_dir(home.path().join(name)).expect("a folder");
        }
        assert_eq!(documents(home.path()), of("Documents"));
        note("# Made by a program\nXDG_MUSIC_DIR=\"$HOME/Musik\"\nXDG_DOCUMENTS_DIR=\"$HOME/Dokumente\"\n");
        assert_eq!(documents(home.path()), of("Dokumente"));
        note("XDG_DOCUMENTS_DIR=\"$HOME/gone\"\n");
        assert_eq!(documents(home.path()), of("Documents"));
        note("XDG_DOCUMENTS_DIR=\"$HOME/\"\n");
        assert_eq!(documents(home.path()), of("Documents"));
    }

    #[test]
    fn pictures_are_saved_beside_their_scene_first() {
        let folder = tempfile::tempdir().expect("a folder");
        let (scene, other) = (folder.path().join("room.xml"), folder.path().join("b/other.xml"));
        std::fs::create_dir(folder.path().join("b")).expect("a folder");
        let start = |dialogs: &Dialogs, scene: Option<&Path>| {
            let model = DialogModel {
                scene,
                tone_map: ToneMap::Clip,
                denoises: false,
                recent: &[],
            };
            dialogs.start(FileDialogKind::SaveImage, model)
        };
        let mut dialogs = Dialogs::default();
        assert_eq!(start(&dialogs, Some(&scene)), folder.path());
        let sample = program_folder("scenes").expect("a checkout").join("cornell-box.xml");
        assert_eq!(Some(start(&dialogs, Some(&sample))), beside(Some(&sample)));
        let pictures = folder.path().join("pictures");
        dialogs.image_folder = Some((Some(scene.clone()), pictures.clone()));
        assert_eq!(start(&dialogs, Some(&scene)), pictures);
        assert_eq!(start(&dialogs, Some(&other)), folder.path().join("b"));
    }

    #[test]
    fn files_are_named_after_the_scene() {
        let scene = Path::new("scenes/cornell-box.xml");
        assert_eq!(proposed_name(Some(scene), "picture", "png"), "cornell-box.png");
        assert_eq!(proposed_name(None, "scene", "xml"), "scene.xml");
    }
}
