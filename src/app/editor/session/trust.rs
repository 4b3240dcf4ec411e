//! Asks about files outside the scene's folder that a scene names. Files are read only from folders that the user has
//! allowed, which are remembered beside the preferences. A scene with other files is shown without them, and the user
//! is asked.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use bevy::prelude::*;

use super::requests::CommandQueue;
use super::toasts::{Toasts, Topic};
use crate::app::editor::command::file_access::Question;
use crate::app::editor::command::{Command, SceneEdit};
use crate::document::Severity;
use crate::document::paths::settle;
use crate::files::{FileError, LARGEST_NOTE, read, write_atomically};
use crate::scene::assets::gltf_scene::is_called_gltf;
use crate::scene::assets::parts_cache::allow_parts;
use crate::scene::read::mesh_search::ASSETS_VARIABLE;
use crate::scene::{OpenScene, SceneAccess, SceneFile, SceneState, SceneStatus, Trust, ask_for};

const FILE: &str = "trusted-folders.json";
/// The number of remembered folders, above which the oldest are dropped.
const MOST_FOLDERS: usize = 1000;
/// The most files that the message about loaded files names.
const MOST_NAMED: usize = 3;

/// The file of the allowed folders, and the question to the user.
#[derive(Resource, Debug, Default)]
pub struct TrustedFolders {
    /// The path of the file. None: nothing is remembered.
    path: Option<PathBuf>,
    /// The open question, if there is one.
    pub question: Option<Question>,
    /// A scene that could not be read before its files were allowed. It is to be opened, unless that would lose edits.
    pub opens: Option<PathBuf>,
    /// The refused files that the user has been asked about.
    asked: Vec<PathBuf>,
    /// The folders that were allowed for the open scene since it was last read.
    news: Vec<PathBuf>,
}

impl TrustedFolders {
    /// A message about the files that the open scene has loaded because they were allowed; None if there are none.
    pub(crate) fn take_news(&mut self) -> Option<String> {
        let mut names: Vec<String> = std::mem::take(&mut self.news)
            .iter()
            .filter_map(|path| Some(path.file_name()?.to_string_lossy().into_owned()))
            .collect();
        let more = names.split_off(names.len().min(MOST_NAMED)).len();
        if more > 0 {
            names.push(format!("{more} more"));
        }
        let last = names.pop()?;
        Some(match names.is_empty() {
            true => format!("Read {last}"),
            false => format!("Read {} and {last}", names.join(", ")),
        })
    }

    /// Opens the file, and returns the folders that scenes may read at first: remembered ones and the program's own.
    /// `folder` is that of the preferences.
    pub fn open(folder: Option<&Path>) -> (Self, Trust) {
        let trusted = Self {
            path: folder.map(|folder| folder.join(FILE)),
            ..Self::default()
        };
        let remembered = trusted.path.as_deref().map_or(Vec::new(), remembered);
        let own = folder.map(Path::to_owned).into_iter().chain(asset_folders());
        (trusted, Trust::Folders(remembered.into_iter().chain(own).collect()))
    }

    /// Adds folders to the file, which other windows may have changed in the meantime.
    fn remember(&self, folders: &[PathBuf]) -> std::io::Result<()> {
        let Some(path) = self.path.as_ref().filter(|_| !folders.is_empty()) else {
            return Ok(());
        };
        let mut all = remembered(path);
        all.retain(|known| !folders.contains(known));
        // Names that JSON cannot hold are left out.
        all.extend(folders.iter().filter(|folder| folder.to_str().is_some()).cloned());
        let first = all.len().saturating_sub(MOST_FOLDERS);
        std::fs::create_dir_all(path.parent().unwrap_or(Path::new(".")))?;
        write_atomically(path, serde_json::to_vec_pretty(&all[first..])?)
    }
}

/// The folders in the file. A file that cannot be parsed allows none.
fn remembered(path: &Path) -> Vec<PathBuf> {
    let bytes = read(path, LARGEST_NOTE).unwrap_or_default();
    let all: Vec<PathBuf> = serde_json::from_slice(&bytes).unwrap_or_default();
    all.into_iter().filter(|folder| folder.is_absolute()).collect()
}

/// The folders of `$SUNROOM_ASSETS`, and the program's own folder of assets, below the working directory or above the
/// program.
pub fn asset_folders() -> Vec<PathBuf> {
    let variable = std::env::var_os(ASSETS_VARIABLE).unwrap_or_default();
    let named = std::env::split_paths(&variable).filter(|folder| !folder.as_os_str().is_empty());
    let program = std::env::current_exe().unwrap_or_default();
    let started_in = std::env::current_dir().unwrap_or_default();
    let homes = program.ancestors().skip(1).take(4).chain([started_in.as_path()]);
    named.chain(homes.filter_map(own_assets)).collect()
}

/// The folder of meshes and pictures beside the program's scenes, if they are in `home`. A link is not followed: the
/// program may have been started in a folder of strangers, who would choose what it may read.
fn own_assets(home: &Path) -> Option<PathBuf> {
    let assets = home.join("assets");
    (home.join("scenes/cornell-box.xml").is_file() && !assets.is_symlink()).then_some(assets)
}

/// Asks the user after a scene was refused files that the user has not been asked about.
pub fn follow_access(access: Res<SceneAccess>, status: Res<SceneStatus>, mut trusted: ResMut<TrustedFolders>) {
    let outside = FileError::Outside.to_string();
    let mut faults = status.diagnostics.list.iter();
    let is_needed = status.state == SceneState::Failed
        && faults.any(|fault| fault.severity == Severity::Error && fault.message.contains(&outside));
    if trusted
        .question
        .as_ref()
        .is_some_and(|question| question.is_needed != is_needed && question.edit.is_none())
        && let Some(question) = &mut trusted.question
    {
        question.is_needed = is_needed;
    }
    let refused = access.refused();
    let is_about_edit = trusted
        .question
        .as_ref()
        .is_some_and(|question| question.edit.is_some());
    if refused == trusted.asked || is_about_edit {
        return;
    }
    let open = trusted.question.take().map_or(Vec::new(), |question| question.files);
    let is_meant = |file: &&PathBuf| open.contains(file) || !trusted.asked.contains(file);
    let question = Question::about(refused.iter().filter(is_meant).cloned().collect());
    trusted.question = question.map(|question| Question { is_needed, ..question });
    trusted.asked = refused;
}

/// Asks about the files that an edit needs.
pub(crate) fn ask_about_edit(world: &mut World, edit: SceneEdit, files: Vec<PathBuf>) {
    if let Some(mut trusted) = world.get_resource_mut::<TrustedFolders>() {
        let question = Question::about(files);
        trusted.question = question.map(|question| Question {
            edit: Some(edit),
            ..question
        });
    }
}

/// Allows the folders from now on, remembers them, and loads the files, or repeats the edit that needs them. Edits of
/// the open scene stay.
pub fn allow(world: &mut World, question: &Question) {
    if let Some(edit) = &question.edit {
        allow_answered(world, question, question.file().unwrap_or(Path::new("")));
        world.resource_mut::<CommandQueue>().0.push(Command::from(edit.clone()));
        return;
    }
    let status = world.resource::<SceneStatus>();
    let (own, loads) = (status.path.clone(), status.state == SceneState::Loading);
    let other = status.asked.clone().filter(|asked| Some(asked) != own.as_ref());
    // These files are the cause of another scene's failure only if it names them.
    let access = world.resource::<SceneAccess>();
    let names_them = |scene: &PathBuf| {
        let refused = access.of_scene(scene).refused();
        refused.iter().any(|file| question.files.contains(file))
    };
    let opens = other.clone().filter(names_them);
    let scene = opens.as_ref().or(own.as_ref()).cloned().unwrap_or_default();
    allow_answered(world, question, &scene);
    let server = world.resource::<AssetServer>();
    for file in &question.files {
        server.reload(bevy::asset::AssetPath::from_path_buf(file.clone()));
    }
    if opens.is_some() {
        world.resource_mut::<TrustedFolders>().opens = opens;
        return;
    }
    // Includes, search folders and the places of files are resolved when the scene itself is read. A recovered scene is
    // in no file: reading its former file would lose it.
    let is_followed = world.resource::<SceneFile>().is_followed();
    let is_awaited = loads && other.is_some();
    if let Some(path) = own.filter(|_| is_followed && !is_awaited) {
        world.resource_mut::<TrustedFolders>().news.clone_from(&question.shown);
        let defines = world.resource::<super::options::SceneDefines>().0.clone();
        let request = OpenScene {
            path,
            defines,
            keeps_edits: true,
        };
        ask_for(world, request);
    }
}

/// Allows the folders of the answer to a question about this scene. A link from outside of all allowed folders is not
/// followed. So the link is allowed as well: the folder that the scene names if it leads into the folders of the
/// answer, else the file itself.
fn allow_answered(world: &mut World, question: &Question, scene: &Path) {
    allow_folders(world, &question.folders);
    let access = world.resource::<Trust>().access(scene);
    let is_way_in = |folder: &&Path| {
        let target = folder.canonicalize();
        target.is_ok_and(|target| question.folders.iter().any(|allowed| target.starts_with(allowed)))
    };
    let refused = question.files.iter().filter(|file| !access.covers(file));
    let links: BTreeSet<&Path> = refused
        .map(|file| file.parent().filter(is_way_in).unwrap_or(file))
        .collect();
    let links: Vec<PathBuf> = links.into_iter().map(Path::to_owned).collect();
    allow_folders(world, &links);
}

/// Lets scenes read a file that the user has chosen, and its neighbours if it may name some.
pub(crate) fn allow_chosen(world: &mut World, file: &Path) {
    let (Some(access), Some(trust)) = (world.get_resource::<SceneAccess>(), world.get_resource::<Trust>()) else {
        return;
    };
    if is_called_gltf(file) {
        allow_parts(|folder| access.allow(folder));
    }
    let file = settle(file);
    let Ok(target) = file.canonicalize() else {
        return;
    };
    let wanted = match has_neighbours(&file) {
        true => [&file, &target]
            .map(|file| file.parent().unwrap_or(file).to_owned())
            .to_vec(),
        false => vec![file],
    };
    let known = trust.access(&open_scene(world));
    let new: Vec<PathBuf> = wanted.into_iter().filter(|path| !known.covers(path)).collect();
    allow_folders(world, &new);
}

/// Lets scenes read those of the files that are in the folder of a chosen one, which is absolute and has no links. The
/// scene has named the files, which may be anywhere: the user is asked about the others once the scene is refused them.
pub(crate) fn allow_beside<'f>(world: &mut World, folder: &Path, files: impl Iterator<Item = &'f PathBuf>) {
    let (Some(_), Some(trust)) = (world.get_resource::<SceneAccess>(), world.get_resource::<Trust>()) else {
        return;
    };
    let known = trust.access(&open_scene(world));
    let is_there = |file: &&PathBuf| file.canonicalize().is_ok_and(|target| target.starts_with(folder));
    let new: Vec<PathBuf> = files
        .filter(is_there)
        .filter(|file| !known.covers(file))
        .cloned()
        .collect();
    allow_folders(world, &new);
}

fn open_scene(world: &World) -> PathBuf {
    let status = world.get_resource::<SceneStatus>();
    status.and_then(|status| status.path.clone()).unwrap_or_default()
}

/// Whether files of this kind name other files beside them.
fn has_neighbours(file: &Path) -> bool {
    let extension = file.extension().unwrap_or_default().to_ascii_lowercase();
    ["obj", "xml", "gltf", "glb"].iter().any(|known| extension == *known)
}

/// Lets this and all scenes read these folders and files from now on.
fn allow_folders(world: &mut World, folders: &[PathBuf]) {
    match &mut *world.resource_mut::<Trust>() {
        Trust::Everything | Trust::OwnFolder => return,
        Trust::Folders(all) => all.extend(folders.iter().cloned()),
    }
    let access = world.resource::<SceneAccess>();
    folders.iter().for_each(|folder| access.allow(folder));
    if let Err(error) = world.resource::<TrustedFolders>().remember(folders) {
        let message = format!("The folders cannot be remembered: {error}");
        world.resource_mut::<Toasts>().error(Topic::Other, &message, None);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[cfg(unix)]
    #[test]
    fn a_link_in_the_place_of_the_assets_allows_nothing() {
        let home = tempfile::tempdir().expect("a temporary folder");
        let (scenes, assets) = (home.path().join("scenes"), home.path().join("assets"));
        assert_eq!(own_assets(home.path()), None);
        std::fs::create_dir(&scenes).expect("a writable folder");
        std::fs::write(scenes.join("cornell-box.xml"), "").expect("a writable folder");
        assert_eq!(own_assets(home.path()), Some(assets.clone()));
        std::os::unix::fs::symlink("/", assets).expect("a writable folder");
        assert_eq!(own_assets(home.path()), None);
    }

    #[test]
    fn folders_are_remembered_once_and_a_broken_file_allows_none() {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let (trusted, _) = TrustedFolders::open(Some(folder.path()));
        for names in [&["/a", "/b"][..], &["/a"]] {
            let folders: Vec<PathBuf> = names.iter().map(PathBuf::from).collect();
            trusted.remember(&folders).expect("a writable folder");
        }
        let (_, trust) = TrustedFolders::open(Some(folder.path()));
        let Trust::Folders(folders) = trust else {
            panic!("{trust:?}");
        };
        assert_eq!(folders[..2], [PathBuf::from("/b"), PathBuf::from("/a")]);
        assert!(folders.contains(&folder.path().to_owned()));
        for broken in ["{", "[\"relative\"]", "[1]"] {
            std::fs::write(folder.path().join(FILE), broken).expect("a writable folder");
            assert!(remembered(&folder.path().join(FILE)).is_empty(), "{broken}");
        }
    }
}
