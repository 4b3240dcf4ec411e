//! The folders from which a scene may read files. A trusted scene may read every folder; an untrusted one only its own
//! folder and the folders that the user has allowed.

use std::collections::BTreeSet;
use std::fs::File;
use std::path::{Component, Path, PathBuf};
use std::sync::{Arc, Mutex, PoisonError};

use super::reading::{self, FileError};
use super::record::note_read;

/// The most refused files that are remembered; a scene can name any number of them.
const MOST_REFUSED: usize = 1000;

/// The most links that are followed in one path, as in the kernel of Linux.
const MOST_LINKS: usize = 40;

/// How often a path is resolved again because a link has meanwhile replaced a part of it.
const MOST_TRIES: usize = 8;

/// A folder that may be read, or a single file.
#[derive(Clone, Debug, PartialEq, Eq)]
struct Folder {
    /// The absolute path as it was named: its own links are the user's, and are followed.
    named: PathBuf,
    canonical: PathBuf,
}

impl Folder {
    fn new(path: &Path) -> Self {
        Self {
            named: std::path::absolute(path).unwrap_or_else(|_| path.to_owned()),
            canonical: canonical(path),
        }
    }
}

/// A permission to read files. Clones share the list of the files that were refused.
#[derive(Clone, Debug, Default)]
pub struct Access {
    /// None if every file may be read.
    folders: Option<Vec<Folder>>,
    /// The scene's own folder, canonical.
    own: Option<PathBuf>,
    refused: Arc<Mutex<BTreeSet<PathBuf>>>,
}

impl Access {
    /// Allows every file.
    pub fn everywhere() -> Self {
        Self::default()
    }

    /// Allows only files in and below these folders.
    pub fn within(folders: impl IntoIterator<Item = PathBuf>) -> Self {
        Self {
            folders: Some(folders.into_iter().map(|folder| Folder::new(&folder)).collect()),
            ..Self::default()
        }
    }

    /// Sets the scene's own folder.
    pub fn of_scene_in(self, folder: &Path) -> Self {
        Self {
            own: Some(canonical(folder)),
            ..self
        }
    }

    /// The same permission with its own, empty list of refused files.
    pub fn apart(&self) -> Self {
        Self {
            refused: Arc::default(),
            ..self.clone()
        }
    }

    /// Whether messages may quote text of a file. Text of a file outside the scene's folder is not shown: messages are
    /// passed on, and a scene may name a private file.
    pub fn may_quote(&self, path: &Path) -> bool {
        let Some(own) = &self.own else {
            return true;
        };
        resolved(path, |_| true).is_some_and(|path| path.starts_with(own))
    }

    /// Permits this folder as well; files in it no longer count as refused. If the path is a file, only that file is
    /// permitted.
    pub fn allow(&mut self, folder: &Path) {
        if let Some(folders) = &mut self.folders {
            let folder = Folder::new(folder);
            if !folders.contains(&folder) {
                folders.push(folder);
            }
            let mut refused = self.refused.lock().unwrap_or_else(PoisonError::into_inner);
            refused.retain(|path| !self.covers(path));
        }
    }

    /// Whether a file or a folder may be accessed, after following its links. One that does not exist is judged by its
    /// name. If it exists and is refused, it is added to the refused files.
    pub fn permits(&self, path: &Path) -> bool {
        let permitted = self.covers(path);
        if !permitted && path.exists() {
            let mut refused = self.refused.lock().unwrap_or_else(PoisonError::into_inner);
            if refused.len() < MOST_REFUSED {
                refused.insert(path.to_owned());
            }
        }
        permitted
    }

    /// The first of these paths that is a file which may be read, or else the first that is a device or a pipe: reading
    /// it gives the error. If there is neither, an existing file at a refused path is added to the refused files; the
    /// result does not depend on it.
    pub fn find<'p>(&self, places: &'p [PathBuf]) -> Option<&'p PathBuf> {
        let permitted = || places.iter().filter(|path| self.covers(path));
        let found = permitted().find(|path| path.is_file());
        let found = found.or_else(|| permitted().find(|path| path.exists() && !path.is_dir()));
        if found.is_none()
            && let Some(wanted) = places.iter().find(|path| path.is_file())
        {
            self.permits(wanted);
        }
        found
    }

    /// [`Self::permits`] without adding to the refused files. A path through other folders is refused even if it ends
    /// in a permitted one: the answer must not reveal whether those folders exist.
    pub fn covers(&self, path: &Path) -> bool {
        match &self.folders {
            Some(folders) => place_in(folders, path).is_some(),
            None => true,
        }
    }

    /// The existing files and folders that were refused so far, in alphabetical order.
    pub fn refused(&self) -> Vec<PathBuf> {
        let refused = self.refused.lock().unwrap_or_else(PoisonError::into_inner);
        refused.iter().cloned().collect()
    }

    /// [`reading::check`] for a permitted file.
    pub fn check(&self, path: &Path, limit: u64) -> Result<(), FileError> {
        self.opened(path, limit).map(drop).inspect(|()| note_read(path))
    }

    /// [`reading::open`] for a permitted file. It opens the very file that was found to be permitted, even if that is
    /// replaced meanwhile.
    pub fn open(&self, path: &Path, limit: u64) -> Result<File, FileError> {
        self.opened(path, limit).inspect(|_| note_read(path))
    }

    /// [`Self::open`] for a permitted file that is no part of the scene, so that it may be replaced later.
    pub fn open_apart(&self, path: &Path, limit: u64) -> Result<File, FileError> {
        self.opened(path, limit)
    }

    /// [`reading::read`] for a permitted file, opened as by [`Self::open`].
    pub fn read(&self, path: &Path, limit: u64) -> Result<Vec<u8>, FileError> {
        let file = self.opened(path, limit)?;
        reading::content(&file, limit).inspect(|_| note_read(path))
    }

    fn opened(&self, path: &Path, limit: u64) -> Result<File, FileError> {
        let Some(folders) = &self.folders else {
            return reading::open(path, limit);
        };
        let mut last = FileError::Outside;
        for _ in 0..MOST_TRIES {
            let Some(place) = place_in(folders, path) else {
                // This adds the file to the refused ones.
                self.permits(path);
                return Err(FileError::Outside);
            };
            match reading::open_without_links(&place, limit) {
                Err(error) if error.is_link() => last = error,
                opened => return opened,
            }
        }
        Err(last)
    }
}

/// Two permissions are equal if they are for the same folders.
impl PartialEq for Access {
    fn eq(&self, other: &Self) -> bool {
        self.folders == other.folders
    }
}

/// The absolute path after following all links, if it lies in one of the folders.
fn place_in(folders: &[Folder], path: &Path) -> Option<PathBuf> {
    let is_inside = |place: &Path| folders.iter().any(|folder| place.starts_with(&folder.canonical));
    let leads_in = |place: &Path| is_inside(place) || folders.iter().any(|folder| folder.canonical.starts_with(place));
    let path = std::path::absolute(path).unwrap_or_else(|_| path.to_owned());
    let from_folder = |folder: &Folder| Some(folder.canonical.join(path.strip_prefix(&folder.named).ok()?));
    let path = folders.iter().find_map(from_folder).unwrap_or(path);
    resolved(&path, leads_in).filter(|path| is_inside(path))
}

fn canonical(folder: &Path) -> PathBuf {
    let resolved = || resolved(folder, |_| true);
    folder
        .canonicalize()
        .ok()
        .or_else(resolved)
        .unwrap_or_else(|| folder.to_owned())
}

/// Makes a path absolute and follows its links, including dangling ones. The part that does not exist is kept. None if
/// that part has a `..`, or if the path leads through more than [`MOST_LINKS`] links or a folder that `may_pass`
/// refuses; nothing is looked up there.
fn resolved(path: &Path, may_pass: impl Fn(&Path) -> bool) -> Option<PathBuf> {
    let mut absolute = std::path::absolute(path).ok()?;
    'links: for _ in 0..=MOST_LINKS {
        let mut place = PathBuf::new();
        let mut parts = absolute.components();
        while let Some(part) = parts.next() {
            match part {
                Component::Prefix(_) => {
                    place.push(part);
                    continue;
                }
                // The canonical root of a drive with a letter is spelt differently.
                Component::RootDir => place = place.join(part).canonicalize().ok()?,
                Component::ParentDir if !place.is_dir() => return None,
                Component::ParentDir => {
                    place.pop();
                }
                _ => place.push(part),
            }
            if !may_pass(&place) {
                return None;
            }
            if let Ok(target) = place.read_link() {
                place.pop();
                absolute = place.join(target).join(parts.as_path());
                continue 'links;
            }
        }
        return Some(place);
    }
    None
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::fs;

    #[test]
    fn only_what_lies_in_the_folders_is_read() {
        let folder = tempfile::tempdir().unwrap();
        let path = |name: &str| folder.path().join(name);
        fs::create_dir_all(path("scene/inside")).unwrap();
        fs::create_dir_all(path("scene-beside")).unwrap();
        for name in ["scene/a", "scene/inside/b", "scene-beside/c", "d"] {
            fs::write(path(name), name).unwrap();
        }
        let mut access = Access::within([path("scene")]);
        for name in ["scene/a", "scene/inside/b", "scene/inside/../a", "scene/../scene/a"] {
            access.read(&path(name), 100).expect(name);
        }
        for name in [
            "d",
            "scene/../d",
            "scene-beside/c",
            "scene/inside/../../d",
            "nowhere",
            "scene/no/../../../d",
        ] {
            let error = access.read(&path(name), 100).expect_err(name);
            assert!(matches!(error, FileError::Outside), "{name}: {error}");
        }
        // A file that does not exist is judged by its name.
        assert!(access.read(&path("scene/nothing"), 100).unwrap_err().is_not_found());
        // Files that do not exist are not recorded as refused.
        let refused = ["d", "scene/../d", "scene-beside/c", "scene/inside/../../d"];
        let sorted = |names: &[&str]| names.iter().map(|name| path(name)).collect::<BTreeSet<PathBuf>>();
        assert_eq!(BTreeSet::from_iter(access.clone().refused()), sorted(&refused));
        access.allow(&path("scene-beside"));
        access.read(&path("scene-beside/c"), 100).unwrap();
        let access_of_scene = access.clone().of_scene_in(&path("scene"));
        for (name, may_quote) in [("scene/a", true), ("scene-beside/c", false), ("d", false)] {
            assert_eq!(access_of_scene.may_quote(&path(name)), may_quote, "{name}");
        }
        access.allow(&path("d"));
        access.read(&path("d"), 100).unwrap();
        assert_eq!(access.refused(), [] as [PathBuf; 0]);
        Access::everywhere().read(&path("d"), 100).unwrap();
    }

    #[test]
    fn a_file_that_may_be_read_wins_and_only_what_is_missed_is_remembered() {
        let folder = tempfile::tempdir().unwrap();
        let path = |name: &str| folder.path().join(name);
        for name in ["outside", "scene", "beside"] {
            fs::create_dir(path(name)).unwrap();
        }
        let places = ["outside/a", "scene/a", "beside/a"].map(path);
        let access = Access::within([path("scene")]);
        assert_eq!((access.find(&places), access.refused()), (None, vec![]));
        fs::write(path("beside/a"), "").unwrap();
        assert_eq!((access.find(&places), access.refused()), (None, vec![path("beside/a")]));
        let access = Access::within([path("scene")]);
        fs::write(path("outside/a"), "").unwrap();
        fs::write(path("scene/a"), "").unwrap();
        assert_eq!((access.find(&places), access.refused()), (Some(&places[1]), vec![]));
    }

    #[cfg(unix)]
    #[test]
    fn links_count_where_they_lead() {
        use std::os::unix::fs::symlink;
        let folder = tempfile::tempdir().unwrap();
        let path = |name: &str| folder.path().join(name);
        fs::create_dir_all(path("scene")).unwrap();
        fs::create_dir_all(path("other")).unwrap();
        for name in ["scene/a", "other/b"] {
            fs::write(path(name), name).unwrap();
        }
        symlink(path("other/b"), path("scene/file-link")).unwrap();
        symlink(path("other"), path("scene/folder-link")).unwrap();
        symlink(path("scene/a"), path("scene/inner-link")).unwrap();
        symlink(path("scene"), path("way-in")).unwrap();
        let access = Access::within([path("way-in")]);
        for name in ["scene/file-link", "scene/folder-link/b", "scene/folder-link/nothing"] {
            assert!(!access.permits(&path(name)), "{name}");
        }
        for name in ["scene/a", "scene/inner-link", "way-in/a"] {
            assert!(access.permits(&path(name)), "{name}");
        }
    }

    #[test]
    fn a_scene_cannot_learn_what_is_outside_by_ways_that_lead_back_in() {
        let folder = tempfile::tempdir().unwrap();
        let path = |name: &str| folder.path().join(name);
        for name in ["own/inside", "other", "beside"] {
            fs::create_dir_all(path(name)).unwrap();
        }
        fs::write(path("own/a"), "").unwrap();
        let access = Access::within([path("own"), path("other")]);
        for name in [
            "own/inside/../a",
            "own/../own/a",
            "other/../own/a",
            "own/../other/../own/a",
        ] {
            assert!(access.covers(&path(name)), "{name}");
        }
        for name in ["own/../beside/../own/a", "own/../absent/../own/a", "beside/../own/a"] {
            assert!(!access.covers(&path(name)), "{name}");
        }
        #[cfg(unix)]
        {
            use std::os::unix::fs::symlink;
            symlink(path("own"), path("way-in")).unwrap();
            symlink(path("beside"), path("own/way-out")).unwrap();
            symlink("../beside/../own/a", path("own/way-round")).unwrap();
            for name in ["own/../way-in/a", "own/way-out/../own/a", "own/way-round"] {
                assert!(!access.covers(&path(name)), "{name}");
            }
        }
    }

    #[cfg(unix)]
    #[test]
    fn links_to_nothing_count_where_they_lead() {
        use std::os::unix::fs::symlink;
        let folder = tempfile::tempdir().unwrap();
        let path = |name: &str| folder.path().join(name);
        fs::create_dir_all(path("scene")).unwrap();
        symlink(path("other/b"), path("scene/absolute")).unwrap();
        symlink("../other/b", path("scene/relative")).unwrap();
        symlink("relative", path("scene/chain")).unwrap();
        symlink("loop", path("scene/loop")).unwrap();
        symlink("absent", path("scene/inner")).unwrap();
        let access = Access::within([path("scene")]);
        for name in ["absolute", "relative", "chain", "relative/c", "loop"] {
            assert!(!access.covers(&path("scene").join(name)), "{name}");
        }
        for name in ["inner", "inner/c", "absent"] {
            assert!(access.covers(&path("scene").join(name)), "{name}");
        }
    }

    /// Files and folders are swapped for links to the outside while they are opened: the targets of the links are never
    /// read.
    #[cfg(unix)]
    #[test]
    fn what_is_swapped_while_it_is_opened_is_not_read() {
        use std::os::unix::fs::symlink;
        use std::sync::atomic::{AtomicBool, Ordering};
        use std::time::{Duration, Instant};
        const READS: usize = 8000;
        // On a busy machine the threads may take turns that are longer than all of these reads.
        let deadline = Instant::now() + Duration::from_secs(60);
        let folder = tempfile::tempdir().unwrap();
        let path = |name: &str| folder.path().join(name);
        fs::create_dir_all(path("scene/inside")).unwrap();
        fs::create_dir_all(path("other")).unwrap();
        for (name, text) in [("scene/inside/a", "own"), ("other/a", "secret")] {
            fs::write(path(name), text).unwrap();
        }
        let is_done = AtomicBool::new(false);
        let swap_files = || {
            while !is_done.load(Ordering::Relaxed) {
                fs::write(path("scene/new"), "own").unwrap();
                fs::rename(path("scene/new"), path("scene/a")).unwrap();
                symlink(path("other/a"), path("scene/new")).unwrap();
                fs::rename(path("scene/new"), path("scene/a")).unwrap();
            }
        };
        let swap_folders = || {
            symlink(path("other"), path("scene/link")).unwrap();
            while !is_done.load(Ordering::Relaxed) {
                fs::rename(path("scene/inside"), path("scene/away")).unwrap();
                fs::rename(path("scene/link"), path("scene/inside")).unwrap();
                fs::rename(path("scene/inside"), path("scene/link")).unwrap();
                fs::rename(path("scene/away"), path("scene/inside")).unwrap();
            }
        };
        let access = Access::within([path("scene")]);
        let (mut own, mut refused, mut others) = (0, 0, Vec::new());
        std::thread::scope(|threads| {
            threads.spawn(swap_files);
            threads.spawn(swap_folders);
            let is_enough = |own: usize, refused: usize| own + refused >= READS && own.min(refused) > 0;
            while others.is_empty() && !is_enough(own, refused) && Instant::now() < deadline {
                for name in ["scene/a", "scene/inside/a"] {
                    match access.read(&path(name), 100) {
                        Ok(bytes) if bytes == b"own" => own += 1,
                        Ok(bytes) => others.push(bytes),
                        Err(_) => refused += 1,
                    }
                }
            }
            is_done.store(true, Ordering::Relaxed);
        });
        assert_eq!(others, Vec::<Vec<u8>>::new());
        assert!(own > 0 && refused > 0, "{own} {refused}");
    }
}
