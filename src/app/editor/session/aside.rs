//! The folders in which edits are written aside that no file has.
//!
//! Each scene and each run of the program has one of its own. It holds the scene as it was then, a note of which file it is, and a file that is locked while the
//! program runs.

use std::fs::{File, TryLockError};
use std::path::{Path, PathBuf};
use std::time::{Duration, SystemTime, UNIX_EPOCH};

use crate::app::editor::command::recovery_offer::{Note, Offer};
use crate::files::{self, LARGEST_NOTE, write_atomically};
use crate::scene::SceneDescription;
use crate::scene::write::save_description;

/// The name of the scene in a folder.
pub const SCENE: &str = "scene.xml";
const NOTE: &str = "about.json";
const LOCK: &str = "lock";
const FRAGMENT_AGE: Duration = Duration::from_secs(3600);

/// A folder that no other window offers or removes while this value exists.
#[derive(Debug)]
pub struct Aside {
    pub folder: PathBuf,
    /// The lock; None where files cannot be locked.
    lock: Option<File>,
}

impl Aside {
    /// Claims a folder. None: another run of the program has it.
    pub fn claim(folder: &Path) -> Option<Self> {
        // A folder that cannot be written to is complained of when it is written to.
        let _ = std::fs::create_dir_all(folder);
        let lock = File::create(folder.join(LOCK)).ok();
        let is_taken = |lock: &File| matches!(lock.try_lock(), Err(TryLockError::WouldBlock));
        (!lock.as_ref().is_some_and(is_taken)).then(|| Self {
            folder: folder.to_owned(),
            lock,
        })
    }

    pub fn remove(self) {
        // Some systems remove no file that is open.
        drop(self.lock);
        remove(&self.folder);
    }
}

/// The note comes first: as soon as the scene is there, it is offered.
pub fn write_aside(folder: &Path, scene: &SceneDescription, path: Option<PathBuf>) -> Result<(), String> {
    let described = |error: std::io::Error| format!("{}: {error}", folder.display());
    std::fs::create_dir_all(folder).map_err(described)?;
    let since_1970 = SystemTime::now().duration_since(UNIX_EPOCH).unwrap_or_default();
    let note = Note {
        scene: path,
        time: since_1970.as_secs(),
        things: Some(scene.shapes.len() + scene.emitters.len() + scene.sensors.len()),
    };
    let text = serde_json::to_vec_pretty(&note).map_err(|error| error.to_string())?;
    write_atomically(&folder.join(NOTE), text).map_err(described)?;
    save_description(scene, &folder.join(SCENE)).map_err(|error| error.to_string())
}

/// Removes a folder, if it is one of this program's.
fn remove(folder: &Path) {
    if folder.join(NOTE).is_file() {
        // A folder that cannot be removed is offered again, which does no harm.
        let _ = std::fs::remove_dir_all(folder);
    }
}

/// The newest folder that ended programs have left in `all` and whose note fits.
pub fn find(all: &Path, is_meant: impl Fn(&Note) -> bool) -> Option<Offer> {
    let folders = std::fs::read_dir(all).ok()?;
    let offers = folders.filter_map(|entry| {
        let folder = entry.ok()?.path();
        let note: Note = serde_json::from_slice(&files::read(&folder.join(NOTE), LARGEST_NOTE).ok()?).ok()?;
        Some(Offer { folder, note })
    });
    offers
        .filter(|offer| is_meant(&offer.note) && offer.folder.join(SCENE).is_file() && !is_in_use(&offer.folder))
        .max_by_key(|offer| offer.note.time)
}

/// Removes folders that a program left which was killed before its first copy was complete. Young ones stay: their program may just have made
/// them and not locked them yet.
pub fn remove_fragments(all: &Path) {
    for entry in std::fs::read_dir(all).into_iter().flatten().flatten() {
        let folder = entry.path();
        let made = std::fs::metadata(folder.join(LOCK)).and_then(|about| about.modified());
        let age = made.ok().and_then(|time| time.elapsed().ok());
        let is_old = age.is_some_and(|age| age > FRAGMENT_AGE);
        if is_old && !folder.join(SCENE).exists() && !is_in_use(&folder) {
            // A folder that cannot be removed now is removed another time.
            let _ = std::fs::remove_dir_all(folder);
        }
    }
}

/// Finds the recovery copy of this scene, or else, when a run begins, of a scene that was never saved, which no file leads to.
pub fn left_over(all: &Path, scene: Option<&Path>, is_first: bool) -> Option<Offer> {
    let own = find(all, |note| scene.is_some() && note.scene.as_deref() == scene);
    own.or_else(|| find(all, |note| is_first && note.scene.is_none()))
}

/// Whether another window may be using it. Where files cannot be locked, none is in use.
pub fn is_in_use(folder: &Path) -> bool {
    let lock = files::open(&folder.join(LOCK), LARGEST_NOTE);
    lock.is_ok_and(|lock| matches!(lock.try_lock(), Err(TryLockError::WouldBlock)))
}

#[cfg(test)]
mod tests {
    use super::super::recovery::discard;
    use super::*;

    fn aside(all: &Path, name: &str, note: &Note) -> PathBuf {
        let folder = all.join(name);
        std::fs::create_dir_all(&folder).expect("a temporary folder");
        std::fs::write(folder.join(SCENE), "<scene version=\"3.0.0\"/>").expect("a temporary folder");
        let text = serde_json::to_vec(note).expect("plain data");
        std::fs::write(folder.join(NOTE), text).expect("a temporary folder");
        folder
    }

    fn note(scene: Option<&Path>, time: u64) -> Note {
        Note {
            scene: scene.map(Path::to_owned),
            time,
            things: None,
        }
    }

    #[test]
    fn the_newest_is_offered_also_when_the_scene_is_newer() {
        let all = tempfile::tempdir().expect("a temporary folder");
        let path = all.path().join("box.xml");
        let lost = aside(all.path(), "a", &note(None, 1000));
        let newest = aside(all.path(), "b", &note(Some(&path), 2000));
        let folder = |offer: Option<Offer>| offer.map(|offer| offer.folder);
        assert_eq!(folder(find(all.path(), |_| true)), Some(newest.clone()));
        // The scene was saved long after.
        std::fs::write(&path, "<scene/>").expect("a temporary folder");
        assert_eq!(folder(left_over(all.path(), Some(&path), true)), Some(newest));
        // The program opens some scene even if none is named.
        let other = Some(Path::new("/other.xml"));
        assert_eq!(folder(left_over(all.path(), other, true)), Some(lost));
        assert_eq!(left_over(all.path(), other, false), None);
    }

    #[test]
    fn what_is_half_written_or_in_use_is_left_alone() {
        let all = tempfile::tempdir().expect("a temporary folder");
        let path = Path::new("/box.xml");
        let half = aside(all.path(), "half", &note(Some(path), 1000));
        std::fs::remove_file(half.join(SCENE)).expect("it is there");
        std::fs::write(aside(all.path(), "odd", &note(None, 1)).join(NOTE), "{").expect("a temporary folder");
        let folder = aside(all.path(), "running", &note(Some(path), 3000));
        let running = Aside::claim(&folder).expect("nobody has it");
        assert_eq!(find(all.path(), |_| true), None);
        let offer = Offer {
            folder: folder.clone(),
            note: note(Some(path), 3000),
        };
        assert!(discard(&offer).is_err() && folder.join(SCENE).is_file());
        // The program crashes.
        drop(running);
        assert_eq!(find(all.path(), |_| true), Some(offer));
        // Folders without a note do not belong to this program.
        let other = all.path().join("other");
        std::fs::create_dir(&other).expect("a temporary folder");
        remove(&other);
        assert!(other.exists());
    }
}
