//! The permissions of the open scene: it may read every file, or only files in its own folder and in folders that the
//! user trusts.

use std::path::{Path, PathBuf};
use std::sync::{Arc, PoisonError, RwLock, RwLockReadGuard, RwLockWriteGuard};

use bevy::prelude::*;

use crate::files::Access;

/// The permission given to every scene that is opened.
#[derive(Resource, Clone, Debug, Default, PartialEq, Eq)]
pub enum Trust {
    /// Scenes may read every file.
    #[default]
    Everything,
    /// Scenes may read the files in their own folder and in these. The scene file itself may be a link to elsewhere:
    /// the user has named it.
    Folders(Vec<PathBuf>),
    /// Scenes may read the files in their own folder, and no links out of it.
    OwnFolder,
}

impl Trust {
    /// The permission of a scene in this file. An empty path stands for a scene without a file, which has no folder of
    /// its own.
    pub fn access(&self, scene: &Path) -> Access {
        let own = scene.parent();
        let access = match self {
            Self::Everything => Access::everywhere(),
            Self::Folders(folders) => {
                let named = own.into_iter().flat_map(|own| [own, scene]);
                Access::within(folders.iter().cloned().chain(named.map(Path::to_owned)))
            }
            Self::OwnFolder => Access::within(own.map(Path::to_owned)),
        };
        match own {
            Some(own) => access.of_scene_in(own),
            None => access,
        }
    }
}

/// The permissions of the open scene, and of a scene that is to replace it. They are shared with the loaders, which run
/// on other threads.
#[derive(Resource, Clone, Debug, Default)]
pub struct SceneAccess(Arc<RwLock<Accesses>>);

#[derive(Debug, Default)]
struct Accesses {
    open: Access,
    /// The permission of the scene that is to replace the open one, with its file.
    asked: Option<(PathBuf, Access)>,
}

impl SceneAccess {
    /// The permission of a world's open scene. A world without this resource limits nothing.
    pub(crate) fn of(world: &World) -> Access {
        world.get_resource::<Self>().map(Self::get).unwrap_or_default()
    }

    /// The permission of the open scene.
    pub fn get(&self) -> Access {
        self.read().open.clone()
    }

    /// The permission of the scene in this file, which is open or requested.
    pub(crate) fn of_scene(&self, path: &Path) -> Access {
        let all = self.read();
        let asked = all.asked.as_ref().filter(|(asked, _)| asked == path);
        asked.map_or(&all.open, |(_, access)| access).clone()
    }

    /// Sets the permission of the open scene, and drops that of a requested one.
    pub fn set(&self, access: Access) {
        *self.write() = Accesses {
            open: access,
            asked: None,
        };
    }

    /// Sets the permission of a requested scene. The open one keeps its own, because it stays if the new one cannot be
    /// read.
    pub(crate) fn ask(&self, path: PathBuf, access: Access) {
        self.write().asked = Some((path, access));
    }

    /// Makes the requested scene the open one.
    pub(crate) fn take_over(&self) {
        let mut all = self.write();
        if let Some((_, access)) = all.asked.take() {
            all.open = access;
        }
    }

    /// Permits one more folder, such as one from which the user has chosen a file.
    pub fn allow(&self, folder: &Path) {
        let mut all = self.write();
        all.open.allow(folder);
        if let Some((_, access)) = &mut all.asked {
            access.allow(folder);
        }
    }

    /// The refused paths of both scenes, as [`Access::refused`].
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
