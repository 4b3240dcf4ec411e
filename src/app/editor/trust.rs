//! Scenes that name files outside their folder. Such files are read only from folders that the user has allowed; these are remembered in a
//! file beside the preferences. A scene that needs others is shown without them, and the user is asked.

use std::path::{Path, PathBuf};

use bevy::prelude::*;

use super::state::EditorState;
use super::toasts::Topic;
use crate::document::paths::settle;
use crate::files::{LARGEST_NOTE, read, write_atomically};
use crate::scene::assets::gltf_scene::is_called_gltf;
use crate::scene::assets::parts_cache::allow_parts;
use crate::scene::read::mesh_search::ASSETS_VARIABLE;
use crate::scene::{OpenScene, SceneAccess, SceneState, SceneStatus, Trust};

const FILE: &str = "trusted-folders.json";
/// The folders that were allowed first are forgotten beyond this number.
const MOST_FOLDERS: usize = 1000;

/// The file of the folders, and what the user is to be asked about.
#[derive(Resource, Debug, Default)]
pub struct TrustedFolders {
    /// None: nothing is remembered.
    path: Option<PathBuf>,
    pub question: Option<Question>,
    /// The refused files that the user has been asked about.
    asked: Vec<PathBuf>,
}

/// Files outside the scene's folder that it names.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Question {
    pub files: Vec<PathBuf>,
}

impl Question {
    /// The folders of the files, each once.
    pub fn folders(&self) -> Vec<PathBuf> {
        let folder = |file: &PathBuf| settle(file).parent().map(Path::to_owned);
        let mut folders: Vec<PathBuf> = self.files.iter().filter_map(folder).collect();
        // A link is allowed with the folder that it leads to.
        let targets = self.files.iter().filter_map(|file| file.canonicalize().ok());
        folders.extend(targets.filter_map(|file| file.parent().map(Path::to_owned)));
        folders.sort();
        folders.dedup();
        folders
    }
}

impl TrustedFolders {
    /// With what scenes may read at first: the remembered folders and the program's own. `folder` is that of the preferences.
    pub fn open(folder: Option<&Path>) -> (Self, Trust) {
        let trusted = Self {
            path: folder.map(|folder| folder.join(FILE)),
            ..Self::default()
        };
        let remembered = trusted.path.as_deref().map_or(Vec::new(), remembered);
        let own = folder.map(Path::to_owned).into_iter().chain(asset_folders());
        (trusted, Trust::Folders(remembered.into_iter().chain(own).collect()))
    }

    /// Others may have written to the file meanwhile.
    fn remember(&self, folders: &[PathBuf]) -> std::io::Result<()> {
        let Some(path) = &self.path else {
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

/// A file that cannot be understood allows nothing.
fn remembered(path: &Path) -> Vec<PathBuf> {
    let bytes = read(path, LARGEST_NOTE).unwrap_or_default();
    let all: Vec<PathBuf> = serde_json::from_slice(&bytes).unwrap_or_default();
    all.into_iter().filter(|folder| folder.is_absolute()).collect()
}

/// The folders of `$SUNROOM_ASSETS`, and the program's own folder of assets, below the working directory or above the program.
fn asset_folders() -> Vec<PathBuf> {
    let variable = std::env::var_os(ASSETS_VARIABLE).unwrap_or_default();
    let named = std::env::split_paths(&variable).filter(|folder| !folder.as_os_str().is_empty());
    let program = std::env::current_exe().unwrap_or_default();
    let started_in = std::env::current_dir().unwrap_or_default();
    let homes = program.ancestors().skip(1).take(4).chain([started_in.as_path()]);
    let own = homes
        .filter(|home| home.join("scenes/cornell-box.xml").is_file())
        .map(|home| home.join("assets"));
    named.chain(own).collect()
}

/// Asks when the open scene was refused other files than before.
pub fn follow_access(access: Res<SceneAccess>, mut trusted: ResMut<TrustedFolders>) {
    let refused = access.get().refused();
    if refused != trusted.asked {
        trusted.question = (!refused.is_empty()).then(|| Question { files: refused.clone() });
        trusted.asked = refused;
    }
}

/// Allows the folders of the files from now on, remembers them, and reads the files.
pub fn allow(world: &mut World, question: &Question) {
    let folders = question.folders();
    if let Trust::Folders(all) = &mut *world.resource_mut::<Trust>() {
        all.extend(folders.iter().cloned());
    }
    if let Err(error) = world.resource::<TrustedFolders>().remember(&folders) {
        let message = format!("The folders cannot be remembered: {error}");
        world
            .resource_mut::<EditorState>()
            .complain(Topic::Other, &message, None);
    }
    let access = world.resource::<SceneAccess>();
    folders.iter().for_each(|folder| access.allow(folder));
    let server = world.resource::<AssetServer>();
    for file in &question.files {
        server.reload(bevy::asset::AssetPath::from_path_buf(file.clone()));
    }
    // Includes and search folders count when the scene itself is read; so does the place where a file was found.
    let status = world.resource::<SceneStatus>();
    let has_failed = status.state == SceneState::Failed;
    let asked = status.asked.clone().filter(|_| has_failed);
    if let Some(path) = asked.or_else(|| status.path.clone()) {
        let defines = world.resource::<super::options::SceneDefines>().0.clone();
        world.write_message(OpenScene {
            path,
            defines,
            keeps_edits: !has_failed,
        });
    }
}

/// Lets the open scene read a file that the user has chosen, and its neighbours.
pub fn allow_chosen(world: &World, file: &Path) {
    if let (Some(access), Some(folder)) = (world.get_resource::<SceneAccess>(), settle(file).parent()) {
        access.allow(folder);
        if is_called_gltf(file) {
            allow_parts(|folder| access.allow(folder));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

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
