//! What the open scene may read: every file, or only files in its own folder and in folders that the user trusts.

use std::path::{Path, PathBuf};
use std::sync::{Arc, PoisonError, RwLock};

use bevy::prelude::*;

use crate::files::Access;

/// What scenes may read, whichever is opened.
#[derive(Resource, Clone, Debug, Default, PartialEq, Eq)]
pub enum Trust {
    /// Every file.
    #[default]
    Everything,
    /// Files in the folder of the scene, and in these.
    Folders(Vec<PathBuf>),
}

impl Trust {
    /// For a scene in this file.
    pub fn access(&self, scene: &Path) -> Access {
        match self {
            Self::Everything => Access::everywhere(),
            Self::Folders(folders) => {
                let own = scene.parent().unwrap_or(Path::new("/")).to_owned();
                Access::within(folders.iter().cloned().chain([own]))
            }
        }
    }
}

/// What the open scene may read. Shared with the loaders, which run on other threads.
#[derive(Resource, Clone, Debug, Default)]
pub struct SceneAccess(Arc<RwLock<Access>>);

impl SceneAccess {
    pub fn get(&self) -> Access {
        self.0.read().unwrap_or_else(PoisonError::into_inner).clone()
    }

    pub fn set(&self, access: Access) {
        *self.0.write().unwrap_or_else(PoisonError::into_inner) = access;
    }

    /// Permits a folder besides, such as one that the user has chosen a file from.
    pub fn allow(&self, folder: &Path) {
        self.0.write().unwrap_or_else(PoisonError::into_inner).allow(folder);
    }
}
