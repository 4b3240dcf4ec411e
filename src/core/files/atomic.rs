//! Replaces files as a whole or not at all, and removes temporary files of killed programs.
//!
//! The new content is written to a temporary file beside the target, which is then renamed. A program that is killed in
//! between leaves the temporary file. Every writer therefore holds a lock on its temporary file, and a later write into
//! the same folder removes old ones that are not locked. The lock makes that safe for two programs that write into one
//! folder at the same time; `O_TMPFILE` would not help, for a file without a name cannot replace one, and not every
//! system and file system has it.
//!
//! Locks folders, so that programs that work on the same files take turns.

use std::collections::HashSet;
use std::fs::{self, DirEntry, File, TryLockError};
use std::io::{self, ErrorKind, Write};
use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};
use std::time::{Duration, Instant};

use tempfile::{NamedTempFile, TempPath};

use super::record::is_kept;
use super::set::finish_all;

/// The prefix of the names of temporary files.
pub(super) const PREFIX: &str = ".sunroom-";
const SUFFIX: &str = ".part";

/// Temporary files younger than this are never removed, since another program may have made one and not locked it yet.
/// That takes microseconds; an hour allows for a suspended program and for the clock of a file server.
const LEFTOVER_AGE: Duration = Duration::from_secs(3600);

/// The most links that are followed to a file, as in the kernel of Linux.
const MOST_LINKS: usize = 40;

/// Replaces a file's content in one step: readers see the old content or the new, never half of it, and after a failure
/// the old content is intact. A symbolic link stays one, even a dangling one; an old file keeps its permissions.
/// Folders, devices and pipes are refused, and so are files that the program has read, if that was [asked
/// for](super::keep_reads).
///
/// The first write of a process into a folder also removes the temporary files that killed programs have left there.
pub fn write_atomically(path: &Path, content: impl AsRef<[u8]>) -> io::Result<()> {
    write_atomically_with(path, |file| file.write_all(content.as_ref()))
}

/// [`write_atomically`] with a function that writes the content piece by piece.
pub fn write_atomically_with(path: &Path, write: impl FnOnce(&mut dyn Write) -> io::Result<()>) -> io::Result<()> {
    let target = Target::new(path)?;
    let folder = target.folder().to_owned();
    target.write(write)?.replace()?;
    remove_leftovers_once(&folder);
    Ok(())
}

/// Checks whether [`write_atomically`] can replace this file, as far as that is known before there is content. The
/// error is the one that the write would give.
pub fn check_writable(path: &Path) -> io::Result<()> {
    Target::new(path)?.temporary_file().map(drop)
}

/// A file to be replaced.
#[derive(Debug)]
pub(super) struct Target {
    /// The path of the file itself, after following all links.
    pub path: PathBuf,
}

/// The new content of a file, in a temporary file beside it, which is removed on drop.
#[derive(Debug)]
pub(super) struct Waiting {
    // The file is closed, since a set may have more files than a program may have open.
    file: TempPath,
    target: PathBuf,
}

impl Target {
    /// An error if nothing can be written there, with any permissions.
    pub fn new(path: &Path) -> io::Result<Self> {
        let target = Self { path: followed(path)? };
        let folder = target.folder();
        if !folder.is_dir() {
            let message = format!("there is no folder {}", folder.display());
            return Err(io::Error::new(ErrorKind::NotFound, message));
        }
        // A rename would replace the device node itself by a file.
        match fs::metadata(&target.path) {
            Ok(about) if about.is_dir() => Err(io::Error::new(ErrorKind::IsADirectory, "it is a folder")),
            Ok(about) if !about.is_file() => {
                let message = "it is a device or a pipe, not a file";
                Err(io::Error::new(ErrorKind::InvalidInput, message))
            }
            Ok(_) if is_kept(&target.path) => {
                let message = "the scene is made of this file; choose another name";
                Err(io::Error::other(message))
            }
            // A temporary file has a short name, and would not reveal that this one is too long.
            Err(error) if error.kind() == ErrorKind::InvalidFilename => Err(error),
            _ => Ok(target),
        }
    }

    pub fn folder(&self) -> &Path {
        folder_of(&self.path)
    }

    /// A locked, empty temporary file beside the target, removed on drop.
    pub fn temporary_file(&self) -> io::Result<NamedTempFile> {
        let mut builder = tempfile::Builder::new();
        builder.prefix(PREFIX).suffix(SUFFIX);
        // The permissions of an ordinary new file: by default only the owner may read temporary files.
        #[cfg(unix)]
        builder.permissions(std::os::unix::fs::PermissionsExt::from_mode(0o666));
        // Only the kind of the error is kept: its full message names the temporary file.
        let file = builder.tempfile_in(self.folder()).map_err(|error| error.kind())?;
        // Where files cannot be locked, the program writes without a lock, and leftovers stay.
        let _ = file.as_file().try_lock();
        Ok(file)
    }

    /// Writes the new content to a temporary file beside the target.
    pub fn write(self, write: impl FnOnce(&mut dyn Write) -> io::Result<()>) -> io::Result<Waiting> {
        let mut file = self.temporary_file()?;
        if let Ok(old) = fs::metadata(&self.path) {
            file.as_file().set_permissions(old.permissions())?;
        }
        fill(&mut file, write)?;
        Ok(Waiting {
            file: file.into_temp_path(),
            target: self.path,
        })
    }
}

impl Waiting {
    /// The file with the new content.
    pub fn path(&self) -> &Path {
        &self.file
    }

    /// The file that is replaced.
    pub fn target(&self) -> &Path {
        &self.target
    }

    /// The same content, whose temporary file stays on drop.
    pub fn kept(mut self) -> Self {
        self.file.disable_cleanup(true);
        self
    }

    /// Renames the temporary file to the target.
    pub fn replace(self) -> io::Result<()> {
        self.file.persist(&self.target).map_err(|error| error.error)
    }
}

/// Writes the content of a temporary file and flushes it to the disk.
pub(super) fn fill(file: &mut NamedTempFile, write: impl FnOnce(&mut dyn Write) -> io::Result<()>) -> io::Result<()> {
    // Writing through `file` itself would give errors that name the temporary file, which the user does not know.
    let mut buffered = io::BufWriter::new(file.as_file_mut());
    write(&mut buffered)?;
    buffered.flush()?;
    drop(buffered);
    file.as_file().sync_all()
}

fn folder_of(path: &Path) -> &Path {
    match path.parent() {
        Some(folder) if !folder.as_os_str().is_empty() => folder,
        _ => Path::new("."),
    }
}

/// The file that a path leads to, even if it does not exist. An error if its links form a cycle.
pub(super) fn followed(path: &Path) -> io::Result<PathBuf> {
    let mut place = path.to_owned();
    for _ in 0..=MOST_LINKS {
        let Ok(target) = place.read_link() else {
            // The folder's path is the same whether the file exists or not.
            let in_folder = || Some(folder_of(&place).canonicalize().ok()?.join(place.file_name()?));
            return Ok(place.canonicalize().ok().or_else(in_folder).unwrap_or(place));
        };
        place = folder_of(&place).join(target);
    }
    Err(io::Error::new(
        ErrorKind::InvalidInput,
        "it is a link that leads in a circle",
    ))
}

/// Removes leftovers unless this process has done so before: listing a folder with many files takes long.
pub(super) fn remove_leftovers_once(folder: &Path) {
    static SEEN: Mutex<Option<HashSet<PathBuf>>> = Mutex::new(None);
    let mut seen = SEEN.lock().unwrap_or_else(PoisonError::into_inner);
    if seen.get_or_insert_default().insert(folder.to_owned()) {
        drop(seen);
        remove_leftovers(folder);
    }
}

/// Removes the temporary files of programs that no longer run, as far as they can be listed, locked and removed.
fn remove_leftovers(folder: &Path) {
    let entries = fs::read_dir(folder).into_iter().flatten().flatten();
    let old: Vec<PathBuf> = entries
        .filter(is_old_temporary_file)
        .map(|entry| entry.path())
        .collect();
    if old.is_empty() {
        return;
    }
    // The files of a set may lie in a folder beside the main file.
    let waiting: HashSet<PathBuf> = folder.ancestors().take(2).flat_map(finish_all).collect();
    for path in old.iter().filter(|path| !waiting.contains(*path)) {
        let file = File::options().read(true).write(true).open(path);
        // The lock is held until the file is gone, so that no two programs remove it.
        if let Ok(file) = file
            && file.try_lock().is_ok()
        {
            let _ = fs::remove_file(path);
        }
    }
}

/// Whether a file has the name of a temporary file.
pub(super) fn is_file_of_write(path: &Path) -> bool {
    let name = path.file_name().unwrap_or_default().as_encoded_bytes();
    name.starts_with(PREFIX.as_bytes()) && name.ends_with(SUFFIX.as_bytes())
}

fn is_old_temporary_file(entry: &DirEntry) -> bool {
    let is_ours = is_file_of_write(&entry.path());
    // The metadata are those of a link itself, not of its target.
    let about = entry.metadata().ok().filter(|about| is_ours && about.is_file());
    let modified = about.and_then(|about| about.modified().ok());
    let age = modified.and_then(|time| time.elapsed().ok());
    age.is_some_and(|age| age >= LEFTOVER_AGE)
}

/// The lock of a folder, released on drop.
#[derive(Debug)]
pub struct FolderLock {
    _folder: Option<File>,
}

/// The error that another program held the lock for the whole time.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct FolderBusy;

/// Waits for the lock of a folder, at most for `longest`. Where folders cannot be locked, this succeeds without a lock:
/// locks only help against other programs that take them, too.
pub fn lock_folder(folder: &Path, longest: Duration) -> Result<FolderLock, FolderBusy> {
    // Only a folder is opened, which neither blocks nor has effects.
    let opened = folder.is_dir().then(|| File::open(folder).ok());
    let Some(file) = opened.flatten() else {
        return Ok(FolderLock { _folder: None });
    };
    let deadline = Instant::now() + longest;
    loop {
        match file.try_lock() {
            Ok(()) => return Ok(FolderLock { _folder: Some(file) }),
            Err(TryLockError::WouldBlock) if Instant::now() < deadline => {
                std::thread::sleep(Duration::from_millis(2));
            }
            Err(TryLockError::WouldBlock) => return Err(FolderBusy),
            Err(TryLockError::Error(_)) => return Ok(FolderLock { _folder: None }),
        }
    }
}

#[cfg(test)]
mod tests {
    use std::time::SystemTime;

    use super::*;

    fn file(folder: &Path, name: &str, age: Duration) -> PathBuf {
        let path = folder.join(name);
        let file = File::create(&path).expect("a temporary folder");
        file.set_modified(SystemTime::now() - age).expect("times can be set");
        path
    }

    #[test]
    fn a_write_removes_what_killed_programs_left() {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let file = |name, age| file(folder.path(), name, age);
        let left = file(".sunroom-aaaaaa.part", 2 * LEFTOVER_AGE);
        let young = file(".sunroom-bbbbbb.part", LEFTOVER_AGE / 2);
        let locked = file(".sunroom-cccccc.part", 2 * LEFTOVER_AGE);
        let writer = File::open(&locked).expect("it was just made");
        writer.lock().expect("nobody else has it");
        let foreign = ["sunroom-a.part", ".sunroom-a", "notes.part"].map(|name| file(name, 10 * LEFTOVER_AGE));
        let nested = folder.path().join(".sunroom-folder.part");
        fs::create_dir(&nested).expect("a temporary folder");
        write_atomically(&folder.path().join("a.txt"), "new").expect("it can be written");
        assert!(!left.exists());
        for kept in foreign.iter().chain([&young, &locked, &nested]) {
            assert!(kept.exists(), "{}", kept.display());
        }
    }

    #[test]
    fn a_file_that_is_being_written_is_locked() {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let target = Target::new(&folder.path().join("a.txt")).expect("a new file");
        let being_written = target.temporary_file().expect("it can be made");
        being_written
            .as_file()
            .set_modified(SystemTime::now() - 2 * LEFTOVER_AGE)
            .expect("times can be set");
        remove_leftovers(folder.path());
        assert!(being_written.path().exists());
        // The same file, left by a program that was killed.
        let (closed, path) = being_written.keep().expect("it can be kept");
        drop(closed);
        remove_leftovers(folder.path());
        assert!(!path.exists());
    }

    #[test]
    fn a_check_leaves_nothing_and_finds_what_a_write_would() {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let path = folder.path().join("a.txt");
        check_writable(&path).expect("it can be written");
        assert_eq!(fs::read_dir(folder.path()).expect("it is there").count(), 0);
        fs::create_dir(&path).expect("a temporary folder");
        for refused in [&path, &folder.path().join("absent/a.txt")] {
            let [checked, written] =
                [check_writable(refused), write_atomically(refused, "")].map(|result| result.unwrap_err().to_string());
            assert_eq!(checked, written);
        }
    }

    /// Root is allowed to replace a device by renaming a file; the writer must refuse before that. A pipe stands for a
    /// device, so that a fault costs the machine none.
    #[cfg(unix)]
    #[test]
    fn devices_stay_devices() {
        use std::os::unix::fs::FileTypeExt;
        let folder = tempfile::tempdir().expect("a temporary folder");
        let (pipe, link) = (folder.path().join("pipe"), folder.path().join("a.png"));
        let made = std::process::Command::new("mkfifo").arg(&pipe).status();
        assert!(made.is_ok_and(|status| status.success()));
        std::os::unix::fs::symlink(&pipe, &link).expect("a temporary folder");
        let message = write_atomically(&link, "picture").unwrap_err().to_string();
        assert_eq!(message, "it is a device or a pipe, not a file");
        assert!(fs::metadata(&link).expect("it is there").file_type().is_fifo());
    }

    #[test]
    fn names_that_are_too_long_are_found_by_the_check() {
        let folder = tempfile::tempdir().expect("a temporary folder");
        check_writable(&folder.path().join("a".repeat(255))).expect("it can be written");
        let error = check_writable(&folder.path().join("a".repeat(256))).expect_err("too long");
        assert_eq!(error.kind(), ErrorKind::InvalidFilename);
    }

    #[cfg(unix)]
    #[test]
    fn links_stay_links() {
        use std::os::unix::fs::symlink;
        let folder = tempfile::tempdir().expect("a temporary folder");
        let path = |name: &str| folder.path().join(name);
        fs::create_dir(path("far")).expect("a temporary folder");
        symlink("far/a.txt", path("a.txt")).expect("a temporary folder");
        symlink("a.txt", path("b.txt")).expect("a temporary folder");
        symlink("absent/a.txt", path("c.txt")).expect("a temporary folder");
        symlink("d.txt", path("d.txt")).expect("a temporary folder");
        // At first the file does not exist.
        for text in ["first", "second"] {
            write_atomically(&path("b.txt"), text).expect("it can be written");
            assert_eq!(fs::read_to_string(path("far/a.txt")).expect("it is there"), text);
            assert!(path("a.txt").is_symlink() && path("b.txt").is_symlink());
        }
        let message = |name: &str| check_writable(&path(name)).expect_err(name).to_string();
        assert!(
            message("c.txt").starts_with("there is no folder"),
            "{}",
            message("c.txt")
        );
        assert_eq!(message("d.txt"), "it is a link that leads in a circle");
        assert!(path("c.txt").is_symlink() && path("d.txt").is_symlink());
    }

    #[test]
    fn a_folder_is_locked_by_one_at_a_time() {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let lock = || lock_folder(folder.path(), Duration::ZERO);
        let first = lock().expect("nobody has it");
        if first._folder.is_some() {
            assert!(lock().is_err());
        }
        drop(first);
        assert!(lock().is_ok());
        assert!(lock_folder(&folder.path().join("missing"), Duration::ZERO).is_ok());
    }
}
