//! Finds the mesh or picture that a file of this dialect names, and whether an OBJ brings its own materials.

use std::path::{Path, PathBuf};

use super::import::Import;
use crate::document::paths::settle;

impl Import<'_> {
    /// The folder of the scene file, absolute.
    pub fn folder(&self) -> PathBuf {
        settle(self.path).parent().unwrap_or(Path::new("/")).to_owned()
    }

    /// Finds a file beside the scene, in the `assets` folders above it and above where the program was started, then
    /// anywhere below these by its file name alone: an absolute name is often one of its author's machine.
    pub fn find_file(&mut self, name: &str) -> Option<PathBuf> {
        let name = Path::new(name.trim());
        if name.as_os_str().is_empty() {
            return None;
        }
        let (folder, access) = (self.folder(), self.access);
        let started_in = std::env::current_dir().unwrap_or_default();
        let above = folder.ancestors().chain(started_in.ancestors());
        let assets = above
            .map(|folder| folder.join("assets"))
            .filter(|folder| folder.is_dir());
        let mut folders = vec![folder.clone()];
        for folder in assets {
            if !folders.contains(&folder) {
                folders.push(folder);
            }
        }
        // Joining an absolute name gives that name.
        let places: Vec<PathBuf> = folders.iter().map(|folder| folder.join(name)).collect();
        let direct = places.iter().find(|path| access.covers(path) && path.is_file());
        folders.retain(|folder| access.covers(folder));
        let by_name = || {
            let named = self.files.below(&folders).get(name.file_name()?)?;
            named.iter().find(|path| access.covers(path)).cloned()
        };
        let found = direct.cloned().or_else(by_name);
        if found.is_none() {
            // The result is not needed: `access` remembers the places.
            access.find(&places);
        }
        Some(settle(&found?))
    }

    /// Whether an OBJ uses materials of a library that is there.
    pub fn has_own_materials(&mut self, path: PathBuf) -> bool {
        self.files.has_own_materials(path, self.access)
    }
}
