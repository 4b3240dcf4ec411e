//! The files of one kind that are used in the scene. Each is loaded once for all uses, and released after the last.
//! Paths are those of assets, which differ from the file's for a grid of a `.vdb` file.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

use bevy::asset::AssetPath;
use bevy::prelude::*;

/// The assets of the files in use, by absolute path.
#[derive(Resource, Debug)]
pub struct FilesInUse<A: Asset>(BTreeMap<PathBuf, Handle<A>>);

impl<A: Asset> Default for FilesInUse<A> {
    fn default() -> Self {
        Self(BTreeMap::new())
    }
}

impl<A: Asset> FilesInUse<A> {
    /// The asset of a file, which may still be loading; None for an unused path.
    pub fn get(&self, path: &Path) -> Option<&Handle<A>> {
        self.0.get(path)
    }

    /// The absolute paths of all files in use, sorted.
    pub fn paths(&self) -> impl Iterator<Item = &Path> {
        self.0.keys().map(PathBuf::as_path)
    }

    /// The files with their assets, sorted.
    pub(in crate::scene) fn iter(&self) -> impl Iterator<Item = (&PathBuf, &Handle<A>)> {
        self.0.iter()
    }

    /// Loads the new files in `wanted` and releases the others. The resource is marked as changed only if the list
    /// changes.
    pub(in crate::scene) fn keep(files: &mut ResMut<Self>, wanted: BTreeSet<PathBuf>, server: &AssetServer) {
        if wanted.iter().eq(files.0.keys()) {
            return;
        }
        let mut old = std::mem::take(&mut files.0);
        for path in wanted {
            let handle = old
                .remove(&path)
                .unwrap_or_else(|| server.load(AssetPath::from_path_buf(path.clone())));
            files.0.insert(path, handle);
        }
    }
}
