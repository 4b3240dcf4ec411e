//! What the open scene may read: every file, or only files in its own folder and in folders that the user trusts.

use std::path::{Path, PathBuf};
use std::sync::{Arc, PoisonError, RwLock, RwLockReadGuard, RwLockWriteGuard};

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
    /// For a scene in this file. An empty path stands for a scene without a file, which has no folder of its own.
    pub fn access(&self, scene: &Path) -> Access {
        let own = scene.parent();
        let access = match self {
            Self::Everything => Access::everywhere(),
            Self::Folders(folders) => Access::within(folders.iter().cloned().chain(own.map(Path::to_owned))),
        };
        match own {
            Some(own) => access.of_scene_in(own),
            None => access,
        }
    }
}

/// What the open scene may read, and what a scene may that is to take its place. Shared with the loaders, which run on other threads.
#[derive(Resource, Clone, Debug, Default)]
pub struct SceneAccess(Arc<RwLock<Accesses>>);

#[derive(Debug, Default)]
struct Accesses {
    open: Access,
    /// With the file of the scene.
    asked: Option<(PathBuf, Access)>,
}

impl SceneAccess {
    /// Of the open scene.
    pub fn get(&self) -> Access {
        self.read().open.clone()
    }

    /// Of the scene in this file, which is open or is to be.
    pub fn of_scene(&self, path: &Path) -> Access {
        let all = self.read();
        let asked = all.asked.as_ref().filter(|(asked, _)| asked == path);
        asked.map_or(&all.open, |(_, access)| access).clone()
    }

    /// For the open scene. No other one is to take its place.
    pub fn set(&self, access: Access) {
        *self.write() = Accesses {
            open: access,
            asked: None,
        };
    }

    /// For a scene that is going to be read. The open one keeps what it has, because it stays if the new one cannot be read.
    pub fn ask(&self, path: PathBuf, access: Access) {
        self.write().asked = Some((path, access));
    }

    /// The scene that was asked for is the open one now.
    pub fn take_over(&self) {
        let mut all = self.write();
        if let Some((_, access)) = all.asked.take() {
            all.open = access;
        }
    }

    /// Permits a folder besides, such as one that the user has chosen a file from.
    pub fn allow(&self, folder: &Path) {
        let mut all = self.write();
        all.open.allow(folder);
        if let Some((_, access)) = &mut all.asked {
            access.allow(folder);
        }
    }

    /// As [`Access::refused`], of both scenes.
    pub fn refused(&self) -> Vec<PathBuf> {
        let all = self.read();
        let asked = all.asked.iter().flat_map(|(_, access)| access.refused());
        let mut refused: Vec<PathBuf> = all.open.refused().into_iter().chain(asked).collect();
        refused.sort();
        refused.dedup();
        refused
    }

    fn read(&self) -> RwLockReadGuard<'_, Accesses> {
        self.0.read().unwrap_or_else(PoisonError::into_inner)
    }

    fn write(&self) -> RwLockWriteGuard<'_, Accesses> {
        self.0.write().unwrap_or_else(PoisonError::into_inner)
    }
}
