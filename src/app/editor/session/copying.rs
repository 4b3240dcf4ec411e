//! An autosave of the scene in progress. The scene is copied over several frames if it is large.

use std::path::{Path, PathBuf};

use bevy::prelude::World;
use bevy::tasks::{IoTaskPool, Task};

use super::aside::write_aside;
use super::file_hashes::hash_of;
use crate::scene::SceneStatus;
use crate::scene::write::snapshot::Snapshot;

/// An autosave in progress.
pub struct Copying {
    /// The part of the scene that is copied.
    pub scene: Snapshot,
    /// The file of the scene.
    pub path: Option<PathBuf>,
    /// The hash of the file's content when the copy was begun. Later edits of the file by others may not be in the
    /// copy.
    file: Task<Option<u64>>,
}

impl Copying {
    pub fn begin(world: &mut World) -> Self {
        let path = world.resource::<SceneStatus>().path.clone();
        let file = path.clone();
        let file = IoTaskPool::get().spawn(async move { hash_of(file.as_deref()?) });
        let scene = Snapshot::begin(world);
        Self { scene, path, file }
    }

    /// Writes the complete copy.
    pub async fn write(self, folder: &Path) -> Result<(), String> {
        let file = self.file.await;
        write_aside(folder, &self.scene.describe().0, self.path, file)
    }
}

#[cfg(test)]
mod tests {
    use std::time::{Duration, Instant};

    use bevy::tasks::{TaskPool, block_on};

    use super::super::aside::left_over;
    use super::super::file_hashes::FileHashes;
    use super::*;
    use crate::app::editor::commands::bare_world::bare_world;

    #[test]
    fn what_others_write_after_a_copy_was_begun_is_not_in_it() {
        let home = tempfile::tempdir().expect("a temporary folder");
        let path = home.path().join("box.xml");
        std::fs::write(&path, "<scene/>").expect("a temporary folder");
        IoTaskPool::get_or_init(TaskPool::default);
        let mut world = bare_world();
        world.resource_mut::<SceneStatus>().path = Some(path.clone());
        let mut copy = Copying::begin(&mut world);
        let begun = Instant::now();
        while !copy.file.is_finished() {
            assert!(begun.elapsed() < Duration::from_secs(60), "the file is not read");
            std::thread::sleep(Duration::from_millis(1));
        }
        std::fs::write(&path, "<scene version='3.0.0'/>").expect("a temporary folder");
        while !copy.scene.step(&mut world, 256) {}
        let all = home.path().join("recovery");
        block_on(copy.write(&all.join("copy"))).expect("it can be written");
        let left = left_over(&all, |_| false, &mut FileHashes::default());
        assert!(left.len() == 1 && left[0].is_outdated);
    }
}
