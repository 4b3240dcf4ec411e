//! Records which files are read through an [`Access`](super::Access) or noted, so that a program can list the files of
//! a scene, and overwrites none of them.

use std::collections::{BTreeSet, HashMap, HashSet};
use std::fs::File;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Mutex, PoisonError};

use super::atomic::followed;

static OPENED: Mutex<Option<Opened>> = Mutex::new(None);

/// Whether the recorded files must not be replaced.
static KEPT: AtomicBool = AtomicBool::new(false);

/// Starts recording the scene files that this process reads.
pub fn record_reads() {
    let mut opened = OPENED.lock().unwrap_or_else(PoisonError::into_inner);
    opened.get_or_insert_default();
}

/// Starts recording the scene files that this process reads, and refuses to overwrite them.
pub fn keep_reads() {
    record_reads();
    KEPT.store(true, Ordering::Relaxed);
}

/// The files that were read since [`record_reads`], in the order of their names.
pub fn recorded_reads() -> Vec<PathBuf> {
    let opened = OPENED.lock().unwrap_or_else(PoisonError::into_inner);
    opened.iter().flat_map(|opened| &opened.names).cloned().collect()
}

/// Records a file of the scene, if recording has started.
pub fn note_read(path: &Path) {
    if let Some(opened) = &mut *OPENED.lock().unwrap_or_else(PoisonError::into_inner) {
        opened.note(path);
    }
}

/// Whether this file was read, under any of its names, and must not be replaced. All links in the path are resolved.
pub(super) fn is_kept(path: &Path) -> bool {
    if !KEPT.load(Ordering::Relaxed) {
        return false;
    }
    let opened = OPENED.lock().unwrap_or_else(PoisonError::into_inner);
    opened.as_ref().is_some_and(|opened| opened.has(path))
}

/// The files that were read.
#[derive(Debug, Default)]
struct Opened {
    names: BTreeSet<PathBuf>,
    /// Their paths after following all links.
    places: HashSet<PathBuf>,
    /// The paths of each file, by its identity when it was read.
    files: HashMap<Identity, Vec<PathBuf>>,
}

impl Opened {
    fn note(&mut self, path: &Path) {
        if !self.names.insert(path.to_owned()) {
            return;
        }
        self.places.extend(followed(path));
        if let Some(file) = Identity::of(path) {
            self.files.entry(file).or_default().push(path.to_owned());
        }
    }

    /// Whether a file was read. This examines only the given file: there may be very many, and a program may ask at
    /// each picture that it writes.
    fn has(&self, path: &Path) -> bool {
        let Some(file) = Identity::of(path) else {
            return false;
        };
        // The identity of a deleted file may be reused by another.
        let names = self.files.get(&file);
        self.places.contains(path) || names.is_some_and(|names| SameFiles::of(names).has(path))
    }
}

/// Whether both paths lead to one file, existing or not. Links are followed.
pub fn is_same_file(one: &Path, other: &Path) -> bool {
    let place = |path: &Path| followed(path).and_then(std::path::absolute).ok();
    one == other || place(one).is_some_and(|one| place(other) == Some(one)) || SameFiles::of([one]).has(other)
}

/// A set of files, which recognises each under any name: a link to it, or its name in other case.
#[derive(Debug)]
pub struct SameFiles(HashSet<Identity>);

impl SameFiles {
    /// Collects the identities of the files. A file that does not exist has none.
    pub fn of(files: impl IntoIterator<Item = impl AsRef<Path>>) -> Self {
        Self(
            files
                .into_iter()
                .filter_map(|file| Identity::of(file.as_ref()))
                .collect(),
        )
    }

    /// Whether a path leads to one of the files.
    pub fn has(&self, path: &Path) -> bool {
        Identity::of(path).is_some_and(|identity| self.0.contains(&identity))
    }
}

/// The identity of a file, equal for all of its names: on Unix its device and inode.
#[derive(Debug, PartialEq, Eq, Hash)]
pub(super) struct Identity {
    #[cfg(unix)]
    numbers: [u64; 2],
    #[cfg(not(unix))]
    path: PathBuf,
}

#[cfg(unix)]
impl Identity {
    fn new(about: &std::fs::Metadata) -> Self {
        use std::os::unix::fs::MetadataExt;
        Self {
            numbers: [about.dev(), about.ino()],
        }
    }

    /// The identity of the file at a path, after following all links; None if there is no file.
    pub fn of(path: &Path) -> Option<Self> {
        path.metadata().ok().map(|about| Self::new(&about))
    }

    /// Whether an open file has this identity.
    pub fn is_of(&self, file: &File) -> bool {
        file.metadata().is_ok_and(|about| *self == Self::new(&about))
    }
}

#[cfg(not(unix))]
impl Identity {
    /// The identity of the file at a path, after following all links; None if there is no file.
    pub fn of(path: &Path) -> Option<Self> {
        path.canonicalize().ok().map(|path| Self { path })
    }

    /// Whether an open file has this identity. This is unknown here, so it is assumed.
    pub fn is_of(&self, _: &File) -> bool {
        true
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[cfg(unix)]
    #[test]
    fn all_names_of_a_file_are_known() {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let path = |name: &str| folder.path().join(name);
        let mut opened = Opened::default();
        for name in ["a", "b"] {
            std::fs::write(path(name), "").expect("a writable folder");
        }
        std::os::unix::fs::symlink("a", path("link")).expect("a writable folder");
        std::fs::hard_link(path("a"), path("other")).expect("a writable folder");
        let files = SameFiles::of([path("a"), path("absent")]);
        for (name, expected) in [
            ("a", true),
            ("link", true),
            ("other", true),
            ("b", false),
            ("absent", false),
        ] {
            assert_eq!(files.has(&path(name)), expected, "{name}");
            assert_eq!(is_same_file(&path("a"), &path(name)), expected, "{name}");
        }
        assert!(is_same_file(&path("absent"), &path("./absent")));
        assert!(is_same_file(Path::new("no-folder/a"), Path::new("./no-folder/a")));
        for name in ["link", "absent"] {
            opened.note(&path(name));
        }
        let place = |name: &str| followed(&path(name)).expect("no circle");
        for (name, expected) in [("a", true), ("other", true), ("b", false), ("absent", false)] {
            assert_eq!(opened.has(&place(name)), expected, "{name}");
        }
        // Another program has replaced the file: the next reading gets the new one.
        std::fs::rename(path("b"), path("a")).expect("a writable folder");
        assert!(opened.has(&place("a")));
        assert!(
            !opened.has(&place("other")),
            "no name that was read leads to it any more"
        );
    }
}
