//! Finds the file of a mesh that a scene file names.
//!
//! A relative name is tried, in this order, in the folder of the file that holds it, the folder of the scene, the
//! scene's `<path>` folders (the last first), the folders of `$SUNROOM_ASSETS` and `assets/` beside the scene's folder.
//! In the last two a leading `../assets/` of the name is stripped, so that the scenes of the project find meshes that
//! are kept elsewhere.

use std::collections::{HashMap, HashSet};
use std::path::{Component, Path, PathBuf};
use std::sync::{Arc, Mutex, PoisonError};

use crate::document::paths::{settle, settle_covered};
use crate::files::{Access, FolderNames};

/// The environment variable with further folders, separated as in `$PATH`.
pub(crate) const ASSETS_VARIABLE: &str = "SUNROOM_ASSETS";

/// The search folders of one scene, for one reading or writing of it: each folder is listed at most once for all files.
#[derive(Clone, Debug)]
pub(crate) struct MeshSearch {
    scene_folder: PathBuf,
    search_folders: Vec<PathBuf>,
    asset_folders: Vec<PathBuf>,
    access: Access,
    looks: Arc<Mutex<Looks>>,
}

/// The cached facts about folders and files. Clones of a search share it.
#[derive(Debug, Default)]
struct Looks {
    names: FolderNames,
    /// Folders with their links resolved.
    settled: HashMap<PathBuf, PathBuf>,
    /// The results by the folder of the file that holds the name, and the name.
    found: HashMap<(PathBuf, String), Found>,
}

impl Looks {
    /// [`settle`] with cached folders.
    fn settle(&mut self, path: &Path) -> PathBuf {
        let (Some(folder), Some(name)) = (path.parent(), path.file_name()) else {
            return settle(path);
        };
        if let Some(known) = self.settled.get(folder) {
            return known.join(name);
        }
        let settled = settle(path);
        if let Some(parent) = settled.parent() {
            self.settled.insert(folder.to_owned(), parent.to_owned());
        }
        settled
    }
}

/// The result of a search.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Found {
    /// The file, absolute. If there is none, the path in the folder of the file with the name, if the scene may not
    /// read it.
    At(PathBuf),
    /// The paths that were tried, the first of them in the folder of the file with the name.
    Nowhere(Vec<PathBuf>),
}

impl MeshSearch {
    pub fn new(scene_folder: &Path, search_folders: &[PathBuf]) -> Self {
        let variable = std::env::var_os(ASSETS_VARIABLE).unwrap_or_default();
        let mut asset_folders: Vec<PathBuf> = std::env::split_paths(&variable)
            .filter(|folder| !folder.as_os_str().is_empty())
            .collect();
        if let Some(parent) = scene_folder.parent() {
            asset_folders.push(parent.join("assets"));
        }
        Self {
            scene_folder: scene_folder.to_owned(),
            search_folders: search_folders.iter().rev().cloned().collect(),
            asset_folders,
            access: Access::everywhere(),
            looks: Arc::default(),
        }
    }

    /// Limits the search to files that `access` permits.
    pub fn within(self, access: Access) -> Self {
        Self {
            access,
            looks: Arc::default(),
            ..self
        }
    }

    /// A search only in the folders where every reader of the format looks.
    pub fn of_format(scene_folder: &Path, search_folders: &[PathBuf]) -> Self {
        Self {
            asset_folders: Vec::new(),
            ..Self::new(scene_folder, search_folders)
        }
    }

    /// Finds the file. `folder` is the folder of the file with the name.
    pub fn find(&self, name: &str, folder: &Path) -> Found {
        let mut looks = self.looks.lock().unwrap_or_else(PoisonError::into_inner);
        let key = (folder.to_owned(), name.to_owned());
        if let Some(known) = looks.found.get(&key) {
            return known.clone();
        }
        let found = self.look(Path::new(name), folder, &mut looks);
        looks.found.insert(key, found.clone());
        found
    }

    fn look(&self, name: &Path, folder: &Path, looks: &mut Looks) -> Found {
        let mut places: Vec<PathBuf> = Vec::new();
        let mut known = HashSet::new();
        let mut add = |folder: &Path, name: &Path| {
            let joined = folder.join(name);
            let path = match self.access.covers(&joined) {
                true => looks.settle(&joined),
                false => settle_covered(folder, name, &self.access),
            };
            if known.insert(path.clone()) {
                places.push(path);
            }
        };
        add(folder, name);
        if name.is_relative() {
            add(&self.scene_folder, name);
            for folder in &self.search_folders {
                add(folder, name);
            }
            let inside = inside_assets(name);
            for assets in &self.asset_folders {
                add(assets, &inside);
                if let Some(file) = name.file_name() {
                    add(assets, Path::new(file));
                }
            }
        }
        let likely: Vec<PathBuf> = places
            .iter()
            .filter(|path| looks.names.may_have(path, &self.access))
            .cloned()
            .collect();
        if let Some(found) = self.access.find(&likely) {
            return Found::At(found.clone());
        }
        let first = places.first().cloned().unwrap_or_default();
        if !self.access.covers(&first) {
            return Found::At(first);
        }
        places.retain(|path| self.access.covers(path));
        Found::Nowhere(places)
    }
}

impl MeshSearch {
    /// [`Self::find`] without the paths that were tried.
    pub fn find_file(&self, name: &str, folder: &Path) -> Option<PathBuf> {
        match self.find(name, folder) {
            Found::At(path) => Some(path),
            Found::Nowhere(_) => None,
        }
    }
}

/// The path inside the assets: `../assets/models/a.ply` becomes `models/a.ply`; other names only lose their leading
/// `..`.
fn inside_assets(name: &Path) -> PathBuf {
    let mut parts = name
        .components()
        .skip_while(|part| matches!(part, Component::ParentDir | Component::CurDir))
        .peekable();
    parts.next_if(|part| part.as_os_str() == "assets");
    parts.collect()
}

/// Where to get a well-known mesh, if `name` is one.
pub(crate) fn advice(name: &str) -> Option<String> {
    let stem = Path::new(name).file_stem()?.to_str()?;
    if !["bunny", "dragon"].contains(&stem) {
        return None;
    }
    let file = Path::new(name).file_name()?.to_str()?;
    Some(format!(
        "the Stanford {stem} may not be passed on with this program: get it from https://graphics.stanford.edu/data/3Dscanrep/ and put it \
         at assets/models/{file} beside scenes/, or into a folder named by ${ASSETS_VARIABLE}"
    ))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::document::paths::settle;

    #[test]
    fn names_lose_their_way_out_of_the_scene_folder() {
        assert_eq!(
            inside_assets(Path::new("../assets/models/a.ply")),
            Path::new("models/a.ply")
        );
        assert_eq!(inside_assets(Path::new("../../b.obj")), Path::new("b.obj"));
        assert_eq!(inside_assets(Path::new("models/c.obj")), Path::new("models/c.obj"));
    }

    #[test]
    fn the_scene_folder_wins_and_assets_beside_it_are_found() {
        let root = tempfile::tempdir().unwrap();
        let scenes = root.path().join("scenes");
        let models = root.path().join("assets/models");
        std::fs::create_dir_all(&scenes).unwrap();
        std::fs::create_dir_all(&models).unwrap();
        // Within one search, folders are listed only once.
        let search = || MeshSearch::new(&scenes, &[]);
        let Found::Nowhere(places) = search().find("models/a.ply", &scenes) else {
            panic!("found a file that is not there");
        };
        assert!(places.len() >= 3, "{places:?}");

        std::fs::write(models.join("a.ply"), "").unwrap();
        let found = |name: &str| match search().find(name, &scenes) {
            Found::At(path) => path,
            Found::Nowhere(places) => panic!("{places:?}"),
        };
        assert_eq!(found("models/a.ply"), settle(&models.join("a.ply")));
        assert_eq!(found("../assets/models/a.ply"), settle(&models.join("a.ply")));
        std::fs::create_dir(scenes.join("models")).unwrap();
        std::fs::write(scenes.join("models/a.ply"), "").unwrap();
        assert_eq!(found("models/a.ply"), settle(&scenes.join("models/a.ply")));
    }
    #[test]
    fn a_mesh_beside_an_untrusted_scene_is_enough() {
        let root = tempfile::tempdir().unwrap();
        let path = |name: &str| root.path().join(name);
        for name in ["scenes", "assets"] {
            std::fs::create_dir(path(name)).unwrap();
            std::fs::write(path(name).join("a.ply"), "").unwrap();
        }
        std::fs::write(path("assets/b.ply"), "").unwrap();
        let access = Access::within([path("scenes")]);
        let search = MeshSearch::new(&path("scenes"), &[]).within(access.clone());
        let beside = settle(&path("scenes/a.ply"));
        assert_eq!(search.find("a.ply", &path("scenes")), Found::At(beside));
        assert_eq!(access.refused(), [] as [PathBuf; 0]);
        // The message is the same for a file outside and for one that does not exist, but the former is recorded as
        // refused.
        for name in ["b.ply", "c.ply"] {
            let places = vec![settle(&path("scenes").join(name))];
            assert_eq!(search.find(name, &path("scenes")), Found::Nowhere(places));
        }
        assert_eq!(access.refused(), [settle(&path("assets/b.ply"))]);
        let first = settle(&path("assets/c.ply"));
        assert_eq!(search.find("../assets/c.ply", &path("scenes")), Found::At(first));
        // The refusal is reported for the first path, even if other folders may be searched.
        let access = Access::within(["scenes", "assets"].map(path));
        let search = MeshSearch::new(&path("scenes"), &[]).within(access);
        let named = settle(&path("elsewhere/c.ply"));
        assert_eq!(search.find("../elsewhere/c.ply", &path("scenes")), Found::At(named));
    }
}
