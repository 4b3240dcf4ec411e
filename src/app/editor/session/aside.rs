//! The autosave folders, which hold edits that no file has.
//!
//! Each scene and each run of the program has one of its own. It holds a copy of the scene, a note that names its file,
//! and a file that is locked while the program runs.

use std::cmp::Reverse;
use std::fs::{File, TryLockError};
use std::path::{Path, PathBuf};
use std::time::{Duration, SystemTime, UNIX_EPOCH};

use super::file_hashes::FileHashes;
use crate::app::editor::command::recovery_offer::{Note, Offer};
use crate::app::editor::words::times::changed_at;
use crate::files::{self, LARGEST_NOTE, finish_set, write_atomically};
use crate::scene::SceneDescription;
use crate::scene::write::save_description;

/// The name of the scene in a folder.
pub const SCENE: &str = "scene.xml";
const NOTE: &str = "about.json";
const LOCK: &str = "lock";
const FRAGMENT_AGE: Duration = Duration::from_secs(3600);

/// An autosave folder that no other window offers or removes while this value exists.
#[derive(Debug)]
pub struct Aside {
    pub folder: PathBuf,
    /// The lock; None where files cannot be locked.
    lock: Option<File>,
}

impl Aside {
    /// Claims a folder. None if another run of the program has claimed it.
    pub fn claim(folder: &Path) -> Option<Self> {
        // An error of a folder that cannot be written to is reported by the first write.
        let _ = std::fs::create_dir_all(folder);
        let lock = File::create(folder.join(LOCK)).ok();
        let is_taken = |lock: &File| matches!(lock.try_lock(), Err(TryLockError::WouldBlock));
        (!lock.as_ref().is_some_and(is_taken)).then(|| Self {
            folder: folder.to_owned(),
            lock,
        })
    }

    pub fn remove(self) {
        // Some systems cannot remove an open file.
        drop(self.lock);
        remove(&self.folder);
    }
}

/// Writes an autosave. `path` is the scene's file, and `file` the hash of its content at that time. The note comes
/// first: as soon as the scene is written, it is offered.
pub fn write_aside(
    folder: &Path,
    scene: &SceneDescription,
    path: Option<PathBuf>,
    file: Option<u64>,
) -> Result<(), String> {
    let described = |error: std::io::Error| format!("{}: {error}", folder.display());
    std::fs::create_dir_all(folder).map_err(described)?;
    let since_1970 = SystemTime::now().duration_since(UNIX_EPOCH).unwrap_or_default();
    let note = Note {
        file,
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

/// The autosaves that ended programs have left in `all`, the newest first. `is_own` names the folders of this run.
pub fn left_over(all: &Path, is_own: impl Fn(&Path) -> bool, hashes: &mut FileHashes) -> Vec<Offer> {
    let folders = std::fs::read_dir(all).into_iter().flatten().flatten();
    let folders = folders.map(|folder| folder.path()).filter(|folder| !is_own(folder));
    let mut offers: Vec<Offer> = folders.filter_map(|folder| offer_of(folder, hashes)).collect();
    offers.sort_by_key(|offer| (Reverse(offer.note.time), offer.folder.clone()));
    offers
}

fn offer_of(folder: PathBuf, hashes: &mut FileHashes) -> Option<Offer> {
    let scene = folder.join(SCENE);
    if !folder.join(NOTE).is_file() || is_in_use(&folder) || !is_complete(&scene) {
        return None;
    }
    let text = files::read(&folder.join(NOTE), LARGEST_NOTE);
    let note: Option<Note> = text.ok().and_then(|text| serde_json::from_slice(&text).ok());
    Some(match note {
        Some(note) => Offer {
            is_outdated: is_outdated(&note, hashes),
            folder,
            note,
            is_damaged: false,
        },
        // The note is missing or damaged, but the scene beside it may be whole.
        None => Offer {
            note: Note {
                time: changed_at(&scene).unwrap_or_default(),
                ..Note::default()
            },
            folder,
            is_damaged: true,
            is_outdated: false,
        },
    })
}

/// Whether the scene of an autosave is complete. Finishes a first autosave whose program was killed while it moved the
/// files into place.
fn is_complete(scene: &Path) -> bool {
    scene.is_file() || finish_set(scene).is_ok() && scene.is_file()
}

/// Whether the scene's file was changed after the autosave was written, judged by content, since clocks may be wrong.
fn is_outdated(note: &Note, hashes: &mut FileHashes) -> bool {
    let Some(path) = &note.scene else {
        return false;
    };
    match (note.file, hashes.of(path)) {
        (Some(then), Some(now)) => then != now,
        _ => changed_at(path).is_some_and(|changed| changed > note.time),
    }
}

/// Removes folders of programs that were killed before their first autosave was complete. Young folders stay: their
/// program may just have made and not locked them yet.
pub fn remove_fragments(all: &Path) {
    for entry in std::fs::read_dir(all).into_iter().flatten().flatten() {
        let folder = entry.path();
        let made = std::fs::metadata(folder.join(LOCK)).and_then(|about| about.modified());
        let age = made.ok().and_then(|time| time.elapsed().ok());
        let is_old = age.is_some_and(|age| age > FRAGMENT_AGE);
        if is_old && !is_in_use(&folder) && !is_complete(&folder.join(SCENE)) {
            // A folder that cannot be removed now is removed another time.
            let _ = std::fs::remove_dir_all(folder);
        }
    }
}

/// The autosave of this scene, or else, at the start of a run, of a scene without a file.
pub fn copy_of<'o>(offers: &'o [Offer], scene: Option<&Path>, is_first: bool) -> Option<&'o Offer> {
    let is_its = |offer: &&Offer| {
        let of_copy = offer.note.scene.as_deref();
        scene
            .zip(of_copy)
            .is_some_and(|(scene, of_copy)| files::is_same_file(scene, of_copy))
    };
    let own = offers.iter().find(is_its);
    own.or_else(|| offers.iter().find(|offer| is_first && offer.note.scene.is_none()))
}

/// Whether another window may be using it. Without file locks, no folder counts as in use.
pub fn is_in_use(folder: &Path) -> bool {
    let lock = files::open(&folder.join(LOCK), LARGEST_NOTE);
    lock.is_ok_and(|lock| matches!(lock.try_lock(), Err(TryLockError::WouldBlock)))
}

#[cfg(test)]
mod tests {
    use super::super::file_hashes::hash_of;
    use super::super::recovery::discard;
    use super::*;
    use crate::files::FileSet;

    fn left_over(all: &Path) -> Vec<Offer> {
        super::left_over(all, |_| false, &mut FileHashes::default())
    }

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
            ..Note::default()
        }
    }

    fn folder(offer: Option<&Offer>) -> Option<PathBuf> {
        offer.map(|offer| offer.folder.clone())
    }

    #[test]
    fn the_newest_is_offered_also_when_the_scene_is_newer() {
        let all = tempfile::tempdir().expect("a temporary folder");
        let path = all.path().join("box.xml");
        let lost = aside(all.path(), "a", &note(None, 1000));
        aside(all.path(), "b", &note(Some(&path), 500));
        let newest = aside(all.path(), "c", &note(Some(&path), 2000));
        let offers = left_over(all.path());
        assert_eq!(
            offers.iter().map(|offer| offer.note.time).collect::<Vec<_>>(),
            [2000, 1000, 500]
        );
        assert!(!offers[0].is_outdated);
        // The scene was saved long after the autosave.
        std::fs::write(&path, "<scene/>").expect("a temporary folder");
        let offers = left_over(all.path());
        assert!(offers[0].is_outdated);
        assert_eq!(folder(copy_of(&offers, Some(&path), true)), Some(newest.clone()));
        // The program opens some scene even if none is named.
        let other = Some(Path::new("/other.xml"));
        assert_eq!(folder(copy_of(&offers, other, true)), Some(lost));
        assert_eq!(copy_of(&offers, other, false), None);
        #[cfg(unix)]
        {
            let link = all.path().join("link.xml");
            std::os::unix::fs::symlink(&path, &link).expect("a temporary folder");
            assert_eq!(folder(copy_of(&offers, Some(&link), false)), Some(newest));
        }
    }

    /// Clocks are set, and files get the times of archives.
    #[test]
    fn a_copy_is_outdated_if_the_file_holds_something_else_than_then() {
        let home = tempfile::tempdir().expect("a temporary folder");
        let (all, path) = (home.path().join("recovery"), home.path().join("box.xml"));
        std::fs::write(&path, "<scene/>").expect("a temporary folder");
        let (scene, file) = (SceneDescription::empty(), hash_of(&path));
        write_aside(&all.join("a"), &scene, Some(path.clone()), file).expect("it can be written");
        let is_outdated = || left_over(&all)[0].is_outdated;
        assert!(!is_outdated());
        let set_time = |seconds: u64| {
            let file = File::options().append(true).open(&path).expect("it is there");
            file.set_modified(UNIX_EPOCH + Duration::from_secs(seconds))
                .expect("a time");
        };
        set_time(1 << 33);
        assert!(!is_outdated());
        std::fs::write(&path, "<scene version='3.0.0'/>").expect("a temporary folder");
        set_time(1000);
        assert!(is_outdated());
        std::fs::remove_file(&path).expect("it is there");
        assert!(!is_outdated());
    }

    #[test]
    fn what_is_half_written_or_in_use_is_left_alone() {
        let all = tempfile::tempdir().expect("a temporary folder");
        let path = Path::new("/box.xml");
        let half = aside(all.path(), "half", &note(Some(path), 1000));
        std::fs::remove_file(half.join(SCENE)).expect("it is there");
        let running_folder = aside(all.path(), "running", &note(Some(path), 3000));
        let running = Aside::claim(&running_folder).expect("nobody has it");
        assert_eq!(left_over(all.path()), []);
        let offer = Offer {
            folder: running_folder,
            note: note(Some(path), 3000),
            ..Offer::default()
        };
        assert!(discard(&offer).is_err() && offer.folder.join(SCENE).is_file());
        // The program crashes.
        drop(running);
        assert_eq!(left_over(all.path()), [offer]);
        // Folders without a note do not belong to this program.
        let other = aside(all.path(), "other", &note(None, 4000));
        std::fs::remove_file(other.join(NOTE)).expect("it is there");
        assert_eq!(left_over(all.path()).len(), 1);
        remove(&other);
        assert!(other.exists());
    }

    /// A scene with parts of glTF files has several files.
    #[test]
    fn a_first_copy_that_was_broken_off_among_its_files_is_finished() {
        let all = tempfile::tempdir().expect("a temporary folder");
        let folder = aside(all.path(), "broken-off", &note(None, 1000));
        let path = |name: &str| folder.join(name);
        std::fs::remove_file(path(SCENE)).expect("it is there");
        let mut set = FileSet::new(&path(SCENE));
        for name in ["first.bin", "second.bin", SCENE] {
            set.add(&path(name), "new").expect("a temporary folder");
        }
        // The second file cannot be renamed, and later ones are not either.
        std::fs::create_dir(path("second.bin")).expect("a temporary folder");
        assert!(set.replace().is_err() && path("first.bin").is_file());
        std::fs::remove_dir(path("second.bin")).expect("it is there");
        let lock = File::create(path(LOCK)).expect("a temporary folder");
        let long_ago = UNIX_EPOCH + Duration::from_secs(1000);
        lock.set_modified(long_ago).expect("a time");
        drop(lock);
        assert!(!path(SCENE).exists());
        remove_fragments(all.path());
        assert_eq!(left_over(all.path()).len(), 1);
        assert!(path(SCENE).is_file() && path("second.bin").is_file());
        // Without any waiting file it is a fragment.
        std::fs::remove_file(path(SCENE)).expect("it is there");
        remove_fragments(all.path());
        assert!(!folder.exists());
    }

    #[test]
    fn a_scene_whose_note_is_damaged_is_offered_without_its_name() {
        let all = tempfile::tempdir().expect("a temporary folder");
        let odd = aside(all.path(), "odd", &note(Some(Path::new("/box.xml")), 1));
        for damage in ["{", "", "[]", "\0\0\0\0"] {
            std::fs::write(odd.join(NOTE), damage).expect("a temporary folder");
            let offers = left_over(all.path());
            assert_eq!((offers.len(), offers[0].is_damaged), (1, true), "{damage:?}");
            assert_eq!(folder(copy_of(&offers, None, true)), Some(odd.clone()));
            assert!(offers[0].note.time > 1_000_000_000, "that of the scene");
        }
        let offer = left_over(all.path()).remove(0);
        assert!(discard(&offer).is_ok() && !odd.exists());
        // Another window was quicker.
        assert!(discard(&offer).is_err() && !odd.exists());
    }
}
