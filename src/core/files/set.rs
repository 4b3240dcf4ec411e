//! Replaces several files that belong together: a level and its lightmaps, a glTF file and its buffer, a scene and its
//! meshes.
//!
//! All new contents are first written to temporary files beside their targets, which is where disks become full and
//! where time goes. Then a journal, called the note, is written that lists the renames, and the files are renamed, the
//! main file, which names the others, last. Before the first rename all files are the old ones. From there on, all will
//! be the new ones: a program that is killed among the renames leaves the note, and the next program that reads or
//! replaces the set completes it ([`finish_set`]). That takes no space on the disk. The note is removed at the end, and
//! with the new files if not even the first rename succeeds.
//!
//! The note lies in the folder of the main file. It may come from a third party with that folder, so it can only do
//! what that party could do itself: rename files in and below the folder, if the files that are replaced or removed
//! have not changed since.

use std::collections::HashSet;
use std::fs::{self, File, Metadata, TryLockError};
use std::io::{self, ErrorKind, Write};
use std::path::{Component, Path, PathBuf};
use std::time::{Duration, Instant, UNIX_EPOCH};

use flate2::Crc;
use serde::{Deserialize, Serialize};

use super::access::Access;
use super::atomic::{PREFIX, Target, Waiting, fill, followed, is_file_of_write, remove_leftovers_once};
use super::reading::{FileError, LARGEST_NOTE, content, open};
use super::record::Identity;

/// The name of a note is [`PREFIX`], the checksum of the name of the main file, and this suffix.
const NOTE_SUFFIX: &str = ".set";

/// The longest wait for another program that is renaming the files of the same set, which takes milliseconds.
const LONGEST_WAIT: Duration = Duration::from_secs(5);

/// The difference of file times, in seconds, up to which they count as equal: some file systems keep even seconds only.
const CLOCK: u64 = 2;

/// The CRC-32 of some bytes, as in ZIP and PNG files, in eight hexadecimal digits.
pub fn checksum(bytes: &[u8]) -> String {
    let mut crc = Crc::new();
    crc.update(bytes);
    format!("{:08x}", crc.sum())
}

/// The reason why a file is not written.
#[derive(Debug, thiserror::Error)]
#[error("cannot write {}: {source}", path.display())]
pub struct WriteError {
    /// The file.
    pub path: PathBuf,
    /// The error of the system.
    pub source: io::Error,
}

fn failed(path: &Path) -> impl FnOnce(io::Error) -> WriteError {
    let path = path.to_owned();
    |source| WriteError { path, source }
}

/// New contents of files, which replace the old ones together. Until then they are in temporary files, which are
/// removed on drop.
#[derive(Debug)]
pub struct FileSet {
    main: PathBuf,
    /// The files with their paths as named by the caller.
    files: Vec<(PathBuf, Waiting)>,
    outdated: Vec<PathBuf>,
}

impl FileSet {
    /// A set without files. `main` is the file that names the others.
    pub fn new(main: &Path) -> Self {
        Self {
            main: main.to_owned(),
            files: Vec::new(),
            outdated: Vec::new(),
        }
    }

    /// Adds a file with this content. Folders, devices and files that the program has read are refused.
    pub fn add(&mut self, path: &Path, content: impl AsRef<[u8]>) -> Result<(), WriteError> {
        self.add_with(path, |file| file.write_all(content.as_ref()))
    }

    /// [`Self::add`] with a function that writes the content piece by piece.
    pub fn add_with(
        &mut self,
        path: &Path,
        write: impl FnOnce(&mut dyn Write) -> io::Result<()>,
    ) -> Result<(), WriteError> {
        let waiting = Target::new(path).and_then(|target| target.write(write));
        self.files.push((path.to_owned(), waiting.map_err(failed(path))?));
        Ok(())
    }

    /// Marks a file of the old set for removal once the new files are in place.
    pub fn remove(&mut self, path: &Path) {
        self.outdated.push(path.to_owned());
    }

    /// Replaces the files. After an error before the first rename all are as they were; after a later one
    /// [`finish_set`] completes the set, if possible.
    pub fn replace(self) -> Result<(), WriteError> {
        self.replace_until(usize::MAX)
    }

    /// [`Self::replace`], stopped after `stop` renames and removals, as if the program was killed.
    fn replace_until(mut self, stop: usize) -> Result<(), WriteError> {
        // The others keep their order.
        self.files.sort_by_key(|(path, _)| *path == self.main);
        let main = Target::new(&self.main).map_err(failed(&self.main))?;
        let folder = main.folder().to_owned();
        // The file may belong to another set, of which only some files are replaced. If that cannot be completed, its
        // reader gets the error.
        for note in notes_of_others(&main.path) {
            let _ = finish(&note, &Access::everywhere());
        }
        let note = Note::publish(&self, &main)?;
        let mut left = stop;
        let mut files = self.files.into_iter();
        if left > 0
            && let Some((path, waiting)) = files.next()
        {
            left -= 1;
            if let Err(error) = waiting.replace() {
                // All files are the old ones. The note is removed first, then the new files that it lists.
                if let Some(note) = note {
                    let _ = fs::remove_file(&note.path);
                }
                return Err(failed(&path)(error));
            }
        }
        let files = files.map(|(path, waiting)| {
            // The files listed by the note stay.
            let waiting = if note.is_some() { waiting.kept() } else { waiting };
            (path, waiting)
        });
        for (path, waiting) in files.collect::<Vec<_>>() {
            if left == 0 {
                return Ok(());
            }
            left -= 1;
            waiting.replace().map_err(|error| {
                let main = self.main.display();
                let what = format!("{error}; other files of its set are new already, and what opens or writes {main} next replaces the rest");
                failed(&path)(io::Error::new(error.kind(), what))
            })?;
        }
        for path in &self.outdated {
            if left == 0 {
                return Ok(());
            }
            left -= 1;
            // A file that is already gone needs no removal.
            let _ = fs::remove_file(path);
        }
        if left > 0 {
            if let Some(note) = note {
                let _ = fs::remove_file(&note.path);
            }
            remove_leftovers_once(&folder);
        }
        Ok(())
    }
}

/// The length of a file and its modification time, in seconds since 1970.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
struct Stamp {
    length: u64,
    time: u64,
}

impl Stamp {
    fn new(about: &Metadata) -> Self {
        let time = about.modified().ok();
        let time = time.and_then(|time| time.duration_since(UNIX_EPOCH).ok());
        Self {
            length: about.len(),
            time: time.map_or(0, |time| time.as_secs()),
        }
    }

    /// The stamp of a regular file; None if the path has no regular file. A link does not count as its target.
    fn of(path: &Path) -> Option<Self> {
        let about = fs::symlink_metadata(path).ok()?;
        about.is_file().then(|| Self::new(&about))
    }

    /// The stamp of a regular file that is below a folder or that `access` permits.
    fn within(folder: &Path, name: &Path, access: &Access) -> Option<Self> {
        let path = folder.join(name);
        let is_seen = access.covers(&path) || is_inside(folder, name);
        is_seen.then(|| Self::of(&path)).flatten()
    }

    fn matches(self, other: Self) -> bool {
        self.length == other.length && self.time.abs_diff(other.time) <= CLOCK
    }
}

/// A pending rename. Paths below the folder of the note are relative to it; others are absolute.
#[derive(Debug, Serialize, Deserialize)]
struct Rename {
    from: PathBuf,
    to: PathBuf,
    new: Stamp,
    /// The stamp of the file that is replaced; None if there was none.
    old: Option<Stamp>,
}

/// The content of a note.
#[derive(Debug, Default, Serialize, Deserialize)]
struct Plan {
    files: Vec<Rename>,
    /// The files that are removed at the end.
    outdated: Vec<(PathBuf, Stamp)>,
}

impl Plan {
    fn of(set: &FileSet, folder: &Path) -> io::Result<Self> {
        let relative = |path: &Path| path.strip_prefix(folder).unwrap_or(path).to_owned();
        let files = set.files.iter().map(|(_, waiting)| {
            Ok(Rename {
                from: relative(waiting.path()),
                to: relative(waiting.target()),
                new: Stamp::of(waiting.path()).ok_or(ErrorKind::NotFound)?,
                old: Stamp::of(waiting.target()),
            })
        });
        let outdated = set.outdated.iter().filter_map(|path| {
            let path = path.canonicalize().ok()?;
            Some((relative(&path), Stamp::of(&path)?))
        });
        Ok(Self {
            files: files.collect::<io::Result<_>>()?,
            outdated: outdated.collect(),
        })
    }

    /// Completes the remaining renames and removals, or none if some are impossible; the error says why. Files
    /// elsewhere that `access` does not permit count as missing.
    fn finish(&self, folder: &Path, access: &Access) -> Result<(), String> {
        let stamp = |name: &Path| Stamp::within(folder, name, access);
        let mut renames = Vec::new();
        for file in &self.files {
            let place = folder.join(&file.to);
            let name = file.to.display();
            let Some(from) = stamp(&file.from) else {
                match stamp(&file.to).is_some_and(|there| there.matches(file.new)) {
                    true => continue,
                    false => return Err(format!("{name} is not the new one, which is gone")),
                }
            };
            let is_old = match (stamp(&file.to), file.old) {
                (Some(there), Some(old)) => there.matches(old),
                (there, old) => there == old,
            };
            if !from.matches(file.new) || !is_old {
                return Err(format!("{name} was changed since"));
            }
            if !is_inside(folder, &file.from) || !is_inside(folder, &file.to) || !is_file_of_write(&file.from) {
                return Err(format!("{name} is in another folder"));
            }
            renames.push((folder.join(&file.from), place));
        }
        for (from, to) in renames {
            fs::rename(from, &to).map_err(|error| format!("{}: {error}", to.display()))?;
        }
        for (name, stamp) in &self.outdated {
            let path = folder.join(name);
            if is_inside(folder, name) && Stamp::of(&path).is_some_and(|there| there.matches(*stamp)) {
                let _ = fs::remove_file(path);
            }
        }
        Ok(())
    }

    /// Whether no file has been renamed, as far as `access` permits to see it.
    fn is_not_begun(&self, folder: &Path, access: &Access) -> bool {
        let stamp = |name: &Path| Stamp::within(folder, name, access);
        let mut files = self.files.iter();
        files.all(|file| stamp(&file.from).is_some_and(|from| from.matches(file.new)))
    }

    /// The temporary files that are to be renamed.
    fn waiting(&self, folder: &Path) -> impl Iterator<Item = PathBuf> {
        let names = self.files.iter().map(|file| &file.from);
        let own = names.filter(|name| is_inside(folder, name) && is_file_of_write(name));
        own.map(|name| folder.join(name))
    }
}

/// Whether a relative path stays below the folder, with its links followed.
fn is_inside(folder: &Path, name: &Path) -> bool {
    if !name.components().all(|part| matches!(part, Component::Normal(_))) {
        return false;
    }
    let around = folder.join(name.parent().unwrap_or(Path::new("")));
    let real = around.canonicalize().ok().zip(folder.canonicalize().ok());
    real.is_some_and(|(around, folder)| around.starts_with(folder))
}

/// A written note, locked until drop.
#[derive(Debug)]
struct Note {
    path: PathBuf,
    _file: File,
}

impl Note {
    /// Writes the note of a set; None if it needs none. Other notes at that path are completed first, or replaced if
    /// that fails.
    fn publish(set: &FileSet, main: &Target) -> Result<Option<Self>, WriteError> {
        let is_alone = set.files.len() < 2 && set.outdated.is_empty();
        let folder = main.folder();
        let path = note_path(&main.path);
        if is_alone && !path.exists() {
            return Ok(None);
        }
        let deadline = Instant::now() + LONGEST_WAIT;
        loop {
            let left = finish(&path, &Access::everywhere());
            if let Err(FileError::Io(error)) = left {
                return Err(failed(&set.main)(error));
            }
            let stale = match &left {
                // That note is replaced, so its temporary files are no longer needed.
                Err(_) => waiting_for(&path, folder),
                Ok(()) => Vec::new(),
            };
            if is_alone && left.is_ok() {
                return Ok(None);
            }
            // Names that are not UTF-8 cannot be in a note, nor in main files.
            let plan = Plan::of(set, folder).map_err(failed(&set.main))?;
            let Ok(text) = serde_json::to_vec(&plan) else {
                return Ok(None);
            };
            let written = main.temporary_file().and_then(|mut file| {
                fill(&mut file, |file| file.write_all(&text))?;
                Ok(file)
            });
            let written = written.map_err(failed(&set.main))?;
            let published = match left.is_ok() {
                true => written.persist_noclobber(&path),
                false => written.persist(&path),
            };
            let published = published.or_else(|error| match error.error.kind() {
                ErrorKind::AlreadyExists => Err(error),
                // Some file systems have neither exclusive renames nor hard links.
                _ => error.file.persist(&path),
            });
            match published.map_err(|error| error.error) {
                Ok(file) => {
                    sync_folder(folder);
                    stale.iter().for_each(|path| drop(fs::remove_file(path)));
                    return Ok(Some(Self { path, _file: file }));
                }
                Err(error) if error.kind() == ErrorKind::AlreadyExists && Instant::now() < deadline => {}
                Err(error) => return Err(failed(&set.main)(error)),
            }
        }
    }
}

/// The path of the note for a main file whose links are resolved.
fn note_path(main: &Path) -> PathBuf {
    let name = main.file_name().unwrap_or_default().as_encoded_bytes();
    main.with_file_name(format!("{PREFIX}{}{NOTE_SUFFIX}", checksum(name)))
}

fn is_note(name: &[u8]) -> bool {
    name.starts_with(PREFIX.as_bytes()) && name.ends_with(NOTE_SUFFIX.as_bytes())
}

/// Flushes the note to the disk before the renames. Where folders cannot be flushed, the system decides.
fn sync_folder(folder: &Path) {
    let _ = File::open(folder).and_then(|folder| folder.sync_all());
}

/// Completes a replacement that a killed program has begun, of a file and those that belong to it. Call it before
/// reading the file. An error says that the files do not belong together, and why that cannot be repaired.
pub fn finish_set(main: &Path) -> Result<(), FileError> {
    finish_set_within(main, &Access::everywhere())
}

/// [`finish_set`] for a file from a third party: no file is looked up that `access` does not permit, so that the error
/// reveals nothing.
pub fn finish_set_within(main: &Path, access: &Access) -> Result<(), FileError> {
    match followed(main) {
        Ok(main) => {
            finish(&note_path(&main), access)?;
            notes_of_others(&main).try_for_each(|note| finish(&note, access))
        }
        // The reader of the file gets this error.
        Err(_) => Ok(()),
    }
}

/// The notes of other main files in the folder of a file that is replaced together with them.
fn notes_of_others(file: &Path) -> impl Iterator<Item = PathBuf> {
    let own = note_path(file);
    notes_in(file.parent().unwrap_or(Path::new(""))).filter(move |note| {
        let names_it = |plan: Plan| {
            plan.files
                .iter()
                .any(|renamed| Some(renamed.to.as_os_str()) == file.file_name())
        };
        *note != own && plan_at(note).is_some_and(names_it)
    })
}

/// The notes in a folder.
fn notes_in(folder: &Path) -> impl Iterator<Item = PathBuf> + use<> {
    let entries = fs::read_dir(folder).into_iter().flatten().flatten();
    let notes = entries.filter(|entry| is_note(entry.file_name().as_encoded_bytes()));
    notes.map(|entry| entry.path())
}

/// The content of a note; None if it cannot be read.
fn plan_at(note: &Path) -> Option<Plan> {
    read_plan(&open(note, LARGEST_NOTE).ok()?).ok()
}

/// Completes the note, if there is one. Waits for a program that is doing so.
fn finish(note: &Path, access: &Access) -> Result<(), FileError> {
    let deadline = Instant::now() + LONGEST_WAIT;
    let broken = |why: String| {
        let note = note.display();
        FileError::BrokenOff(format!(
            "{why}; write them again, or remove {note} to keep the files as they are"
        ))
    };
    loop {
        if !fs::symlink_metadata(note).is_ok_and(|about| about.is_file()) {
            return Ok(());
        }
        let file = match open(note, LARGEST_NOTE) {
            Ok(file) => file,
            Err(error) if error.is_not_found() => return Ok(()),
            Err(error) => return Err(broken(error.to_string())),
        };
        match file.try_lock() {
            Err(TryLockError::WouldBlock) if Instant::now() < deadline => {
                std::thread::sleep(Duration::from_millis(2));
                continue;
            }
            Err(TryLockError::WouldBlock) => {
                let message = "another program is replacing this file and those that belong to it";
                return Err(io::Error::new(ErrorKind::WouldBlock, message).into());
            }
            // Where files cannot be locked, continue without a lock.
            Ok(()) | Err(TryLockError::Error(_)) => {}
        }
        // Another program may have completed this note before the lock was free, and written the next.
        if !Identity::of(note).is_some_and(|there| there.is_of(&file)) {
            continue;
        }
        let folder = note.parent().unwrap_or(Path::new(""));
        let plan = read_plan(&file).map_err(broken)?;
        return match plan.finish(folder, access) {
            Ok(()) => fs::remove_file(note).map_err(|error| broken(error.to_string())),
            // The old files still belong together. If the note cannot be removed, it needs its temporary files.
            Err(_) if plan.is_not_begun(folder, access) => {
                if fs::remove_file(note).is_ok() {
                    plan.waiting(folder).for_each(|path| drop(fs::remove_file(path)));
                }
                Ok(())
            }
            Err(why) => Err(broken(why)),
        };
    }
}

/// Reads an open note: where locks are mandatory, it cannot be opened a second time while it is locked.
fn read_plan(note: &File) -> Result<Plan, String> {
    let text = content(note, LARGEST_NOTE).map_err(|error| error.to_string())?;
    serde_json::from_slice(&text).map_err(|error| error.to_string())
}

/// The temporary files of a note in this folder.
fn waiting_for(note: &Path, folder: &Path) -> Vec<PathBuf> {
    plan_at(note).map_or_else(Vec::new, |plan| plan.waiting(folder).collect())
}

/// Completes all sets in a folder, as far as possible. Returns the temporary files of sets that cannot be completed.
pub(super) fn finish_all(folder: &Path) -> HashSet<PathBuf> {
    let mut waiting = HashSet::new();
    for note in notes_in(folder) {
        if finish(&note, &Access::everywhere()).is_err() {
            waiting.extend(waiting_for(&note, folder));
        }
    }
    waiting
}

#[cfg(test)]
mod tests;
