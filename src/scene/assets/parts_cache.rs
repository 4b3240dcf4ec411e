//! The cache of the parts of opened glTF files. It can be recreated, so that it may be removed at any time.
//!
//! A part lies in a folder named by the hash of its content, and is reused only if its content is the same. Links are
//! never followed: a link in the place of a folder or a part is removed. The cache is kept below 4 GiB: the least
//! recently used parts are removed first, but none that a running program uses.

use std::collections::HashSet;
use std::ffi::OsStr;
use std::fs::{self, File};
use std::hash::{DefaultHasher, Hasher};
use std::io::{self, Read, Write};
use std::path::{Path, PathBuf};
use std::sync::{LazyLock, Mutex, PoisonError};
use std::time::{Duration, SystemTime};

use tempfile::NamedTempFile;

use super::cache_folder::{cache_folder, cache_folders};
use crate::files::{self, LARGEST_DATA, LARGEST_NOTE};

/// The time after which unused parts are removed.
const KEPT: Duration = Duration::from_secs(30 * 24 * 3600);

/// The size limit of the cache in bytes. It holds the parts of one file of the largest size that is read.
const MOST_BYTES: u64 = 4 << 30;

/// A file in the folder of a part. Its modification time is that of the last use. The part itself is not touched,
/// because programs that watch it would take that for a change.
const MARKER: &str = "last-used";

/// The prefix of the lists of parts in use.
const LIST: &str = "in-use-";

/// The name of the cache folder.
const NAME: &str = "gltf";

/// The cache of this program.
pub(crate) static CACHE: LazyLock<PartsCache> = LazyLock::new(|| PartsCache::new(cache_folder(NAME)));

pub(crate) struct PartsCache {
    /// The cache folder; None if none can be written.
    folder: Option<PathBuf>,
    in_use: Mutex<InUse>,
}

/// The parts that this program has used. Other programs read them in a file that is locked while this one runs.
#[derive(Default)]
struct InUse {
    hashes: HashSet<String>,
    list: Option<File>,
}

/// A part in the cache.
struct Part {
    folder: PathBuf,
    bytes: u64,
    used: SystemTime,
}

impl PartsCache {
    fn new(folder: Option<PathBuf>) -> Self {
        Self {
            folder,
            in_use: Mutex::default(),
        }
    }

    /// Stores a file with these bytes, and returns its absolute path.
    pub fn keep(&self, name: &str, bytes: &[u8]) -> io::Result<String> {
        let nowhere = || io::Error::other("there is no folder where the parts of the file can be kept");
        let cache = self.folder.as_ref().ok_or_else(nowhere)?;
        let mut hasher = DefaultHasher::new();
        hasher.write(bytes);
        let hash = format!("{:016x}", hasher.finish());
        fs::create_dir_all(cache)?;
        self.list_as_used(cache, &hash)?;
        let folder = cache.join(&hash);
        make_folder(&folder)?;
        let path = folder.join(name);
        if !holds(&path, bytes)? {
            // The new file replaces a link, not the target of the link.
            let mut file = NamedTempFile::new_in(&folder)?;
            // Writing through `file` itself would give errors that name the temporary file, which the user does not
            // know.
            file.as_file_mut().write_all(bytes)?;
            file.persist(&path).map_err(|error| error.error)?;
        }
        mark(&folder)?;
        Ok(path.to_string_lossy().into_owned())
    }

    /// Removes old parts, and parts above the size limit. Parts that cannot be examined or removed now are left for
    /// later.
    pub fn tidy(&self) {
        self.tidy_down_to(MOST_BYTES);
    }

    fn tidy_down_to(&self, most_bytes: u64) {
        let Some(cache) = &self.folder else { return };
        let Ok(in_use) = used_by_programs(cache) else { return };
        let mut parts = parts(cache);
        parts.sort_by_key(|part| part.used);
        let mut total: u64 = parts.iter().map(|part| part.bytes).sum();
        for part in parts {
            let name = part.folder.file_name().unwrap_or_default();
            let is_used = name.to_str().is_some_and(|name| in_use.contains(name));
            let is_old = part.used.elapsed().is_ok_and(|age| age > KEPT);
            if !is_used && (is_old || total > most_bytes) && fs::remove_dir_all(&part.folder).is_ok() {
                total -= part.bytes;
            }
        }
    }

    fn list_as_used(&self, cache: &Path, hash: &str) -> io::Result<()> {
        let mut in_use = self.in_use.lock().unwrap_or_else(PoisonError::into_inner);
        if !in_use.hashes.insert(hash.to_owned()) {
            return Ok(());
        }
        let list = match &mut in_use.list {
            Some(list) => list,
            empty => {
                let file = tempfile::Builder::new().prefix(LIST).tempfile_in(cache)?;
                let (file, _) = file.keep().map_err(|error| error.error)?;
                file.lock()?;
                empty.insert(file)
            }
        };
        list.write_all(format!("{hash}\n").as_bytes())
    }
}

/// Makes the folder of a part. It replaces a file or link of that name.
fn make_folder(folder: &Path) -> io::Result<()> {
    match fs::symlink_metadata(folder) {
        Ok(about) if about.is_dir() => return Ok(()),
        Ok(_) => fs::remove_file(folder)?,
        Err(_) => {}
    }
    fs::create_dir_all(folder)
}

/// Whether a regular file with exactly this content exists.
fn holds(path: &Path, bytes: &[u8]) -> io::Result<bool> {
    let Ok(about) = fs::symlink_metadata(path) else {
        return Ok(false);
    };
    if about.is_dir() {
        fs::remove_dir_all(path)?;
        return Ok(false);
    }
    if !about.is_file() || about.len() != bytes.len() as u64 {
        return Ok(false);
    }
    let mut rest = bytes;
    let mut file = files::open(path, LARGEST_DATA)?;
    let mut piece = vec![0; 1 << 16];
    loop {
        let length = file.read(&mut piece)?;
        let Some(same) = rest.strip_prefix(&piece[..length]) else {
            return Ok(false);
        };
        if length == 0 {
            return Ok(same.is_empty());
        }
        rest = same;
    }
}

/// Sets the time of last use of the part in a folder to now.
fn mark(folder: &Path) -> io::Result<()> {
    let marker = folder.join(MARKER);
    if fs::symlink_metadata(&marker).is_ok_and(|about| !about.is_file()) {
        fs::remove_file(&marker)?;
    }
    let file = File::options().create(true).append(true).open(marker)?;
    file.set_modified(SystemTime::now())
}

/// The parts in the cache. Files that were not made by [`PartsCache::keep`] are left out.
fn parts(cache: &Path) -> Vec<Part> {
    let entries = fs::read_dir(cache).into_iter().flatten().flatten();
    let folders = entries.filter(|entry| is_hash(&entry.file_name()));
    folders.filter_map(|entry| part(entry.path()).ok().flatten()).collect()
}

/// The part in a folder; None for an empty folder and for a link.
fn part(folder: PathBuf) -> io::Result<Option<Part>> {
    if !fs::symlink_metadata(&folder)?.is_dir() {
        return Ok(None);
    }
    let (mut bytes, mut used, mut marked) = (0, None, None);
    for file in fs::read_dir(&folder)? {
        let file = file?;
        // For a link these are the metadata of the link itself, not of its target.
        let about = file.metadata()?;
        bytes += about.len();
        let time = about.modified()?;
        if file.file_name() == MARKER {
            marked = Some(time);
        }
        used = used.max(Some(time));
    }
    let used = marked.or(used);
    Ok(used.map(|used| Part { folder, bytes, used }))
}

/// The parts in the lists of all running programs. The list of a program that has ended is removed. An error if a list
/// cannot be read, or is longer than [`LARGEST_NOTE`], which is four million parts: any part may be in use then.
fn used_by_programs(cache: &Path) -> io::Result<HashSet<String>> {
    let mut hashes = HashSet::new();
    for entry in fs::read_dir(cache).into_iter().flatten().flatten() {
        let is_list = entry.file_name().to_str().is_some_and(|name| name.starts_with(LIST));
        if !is_list || !entry.file_type().is_ok_and(|kind| kind.is_file()) {
            continue;
        }
        let mut list = match files::open(&entry.path(), LARGEST_NOTE) {
            Ok(list) => list,
            // Another program has removed it meanwhile.
            Err(error) if error.is_not_found() => continue,
            Err(error) => return Err(error.into()),
        };
        if list.try_lock_shared().is_ok() {
            // Its program has ended, or has not locked it yet. A new list is kept for a while.
            let age = entry.metadata().and_then(|about| about.modified());
            if age.is_ok_and(|time| time.elapsed().is_ok_and(|age| age > Duration::from_secs(60))) {
                let _ = fs::remove_file(entry.path());
            }
        }
        let mut text = String::new();
        list.read_to_string(&mut text)?;
        hashes.extend(text.lines().map(str::to_owned));
    }
    Ok(hashes)
}

/// Whether a folder has a name as made by [`PartsCache::keep`]. Other folders are ignored.
fn is_hash(name: &OsStr) -> bool {
    let is_digit = |byte: &u8| matches!(byte, b'0'..=b'9' | b'a'..=b'f');
    name.len() == 16 && name.as_encoded_bytes().iter().all(is_digit)
}

/// Whether a file is a part in a cache, and may be removed later.
pub fn is_part(path: &Path) -> bool {
    cache_folders(NAME).any(|folder| path.starts_with(folder))
}

/// Permits the folder where this program keeps parts of glTF files. Other folders of such a name may be links of
/// unknown origin.
pub(crate) fn allow_parts(allow: impl FnOnce(&Path)) {
    if let Some(folder) = &CACHE.folder {
        allow(folder);
    }
}

/// Whether this canonical path is a part in the cache.
pub(crate) fn is_cached_part(path: &Path) -> bool {
    CACHE.folder.as_ref().is_some_and(|folder| path.starts_with(folder))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::assets::cache_folder::prepare;

    const DAY: u64 = 24 * 3600;

    fn cache() -> (tempfile::TempDir, PartsCache) {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let cache = PartsCache::new(Some(folder.path().to_owned()));
        (folder, cache)
    }

    /// Stores a part as by a program that ended some days ago.
    fn keep(folder: &Path, bytes: &[u8], days: u64) -> PathBuf {
        let program = PartsCache::new(Some(folder.to_owned()));
        let path = PathBuf::from(program.keep("part", bytes).expect("can be kept"));
        make_old(&path.with_file_name(MARKER), days);
        path
    }

    fn make_old(path: &Path, days: u64) {
        let file = File::options().append(true).open(path).expect("is there");
        let time = SystemTime::now() - Duration::from_secs(days * DAY);
        file.set_modified(time).expect("can be set");
    }

    #[test]
    fn only_parts_of_ours_are_forgotten() {
        let (folder, cache) = cache();
        let old = keep(folder.path(), b"old", 31);
        let recent = keep(folder.path(), b"recent", 29);
        let foreign = ["letters", "0123456789abcde", "0123456789ABCDEF", "0123456789abcdef0"].map(|name| {
            let folder = folder.path().join(name);
            fs::create_dir(&folder).expect(name);
            fs::write(folder.join("file"), name).expect(name);
            make_old(&folder.join("file"), 400);
            folder.join("file")
        });
        cleared_lists(folder.path());
        cache.tidy();
        assert!(!old.exists() && !old.parent().is_some_and(Path::exists));
        assert!(recent.is_file());
        for file in foreign {
            assert!(file.is_file(), "{}", file.display());
        }
    }

    /// Removes the lists of ended programs, which are too recent to be removed at once.
    fn cleared_lists(folder: &Path) {
        for entry in fs::read_dir(folder).expect("is there").flatten() {
            if entry.file_name().to_string_lossy().starts_with(LIST) {
                make_old(&entry.path(), 1);
            }
        }
        // The first look removes them.
        used_by_programs(folder).expect("all can be read");
    }

    #[test]
    fn parts_not_used_for_the_longest_time_make_room_but_none_in_use() {
        let (folder, cache) = cache();
        let parts: Vec<PathBuf> = (0..5)
            .map(|i| keep(folder.path(), &[i; 100], 10 - u64::from(i)))
            .collect();
        cleared_lists(folder.path());
        // The oldest is used again by a running program; the second oldest by this one.
        let other = PartsCache::new(Some(folder.path().to_owned()));
        other.keep("part", &[0; 100]).expect("can be kept");
        cache.keep("part", &[1; 100]).expect("can be kept");
        parts[..2]
            .iter()
            .for_each(|part| make_old(&part.with_file_name(MARKER), 20));
        cache.tidy_down_to(350);
        let left: Vec<bool> = parts.iter().map(|part| part.exists()).collect();
        assert_eq!(left, [true, true, false, false, true]);
        // They are kept even beyond the size limit, or after a month.
        make_old(&parts[0].with_file_name(MARKER), 40);
        cache.tidy_down_to(0);
        let left: Vec<bool> = parts.iter().map(|part| part.exists()).collect();
        assert_eq!(left, [true, true, false, false, false]);
    }

    #[test]
    fn while_a_list_is_too_long_to_be_read_nothing_is_removed() {
        let (folder, cache) = cache();
        let old = keep(folder.path(), b"old", 31);
        cleared_lists(folder.path());
        let list = folder.path().join(format!("{LIST}long"));
        // The file is sparse, so that it takes no space on the disk.
        let file = File::create(&list).expect("a temporary folder");
        file.lock().expect("no program else has it");
        file.set_len(LARGEST_NOTE + 1).expect("it can be longer");
        cache.tidy_down_to(0);
        assert!(old.is_file());
        fs::remove_file(list).expect("it is there");
        cache.tidy_down_to(0);
        assert!(!old.exists());
    }

    #[test]
    fn a_part_is_used_again_only_with_the_same_content_and_not_written_then() {
        let (_folder, cache) = cache();
        let path = PathBuf::from(cache.keep("part", b"bytes").expect("can be kept"));
        make_old(&path, 3);
        let modified = || path.metadata().and_then(|about| about.modified()).expect("is known");
        let before = modified();
        cache.keep("part", b"bytes").expect("can be kept");
        assert_eq!(modified(), before);
        for other in [&b"BYTES"[..], b"", b"longer than that"] {
            fs::write(&path, other).expect("can be written");
            cache.keep("part", b"bytes").expect("can be kept");
            assert_eq!(fs::read(&path).expect("is there"), b"bytes");
        }
        fs::remove_file(&path).expect("is there");
        fs::create_dir(&path).expect("can be made");
        cache.keep("part", b"bytes").expect("can be kept");
        assert_eq!(fs::read(&path).expect("is there"), b"bytes");
    }

    #[cfg(unix)]
    #[test]
    fn links_are_replaced_and_never_followed() {
        use std::os::unix::fs::symlink;
        let (folder, cache) = cache();
        let outside = tempfile::tempdir().expect("a temporary folder");
        let precious = outside.path().join("part");
        fs::write(&precious, b"bytes").expect("can be written");
        make_old(&precious, 400);
        let before = precious
            .metadata()
            .and_then(|about| about.modified())
            .expect("is known");
        let path = PathBuf::from(cache.keep("part", b"bytes").expect("can be kept"));
        let own = path.parent().expect("has a folder");
        for linked in [&path, &own.join(MARKER)] {
            fs::remove_file(linked).expect("is there");
            symlink(&precious, linked).expect("can be linked");
            cache.keep("part", b"bytes").expect("can be kept");
            assert!(fs::symlink_metadata(linked).expect("is there").is_file());
        }
        fs::remove_dir_all(own).expect("is there");
        symlink(outside.path(), own).expect("can be linked");
        cache.tidy_down_to(0);
        cache.keep("part", b"bytes").expect("can be kept");
        assert!(fs::symlink_metadata(own).expect("is there").is_dir());
        let names: Vec<_> = fs::read_dir(outside.path())
            .expect("is there")
            .flatten()
            .map(|entry| entry.file_name())
            .collect();
        assert_eq!(names, ["part"]);
        assert_eq!(
            precious
                .metadata()
                .and_then(|about| about.modified())
                .expect("is known"),
            before
        );
        // A cache that is a link is not used at all.
        let link = folder.path().join("link");
        symlink(outside.path(), &link).expect("can be linked");
        assert!(prepare(&link).is_err() && prepare(&link.join("gltf")).is_err());
        prepare(&folder.path().join("sunroom/gltf")).expect("a folder of our own");
    }

    #[test]
    fn without_a_folder_nothing_is_kept_or_removed() {
        let nowhere = PartsCache::new(None);
        nowhere.tidy();
        let error = nowhere
            .keep("part", b"bytes")
            .expect_err("there is no place")
            .to_string();
        assert!(error.contains("no folder"), "{error}");
    }
}
