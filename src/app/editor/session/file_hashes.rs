//! Hashes of the contents of files, which tell whether files were changed.

use std::collections::HashMap;
use std::path::{Path, PathBuf};
use std::time::{Duration, SystemTime};

use super::stable_hash::stable_hash;
use crate::files;

/// The largest file, in bytes, that is read for its hash.
const LARGEST: u64 = 32 << 20;
/// A file that was written within this time may be written again with the same time stamp: some file systems keep only
/// seconds.
const CLOCK: Duration = Duration::from_secs(3);

/// The hash of a file's content. None if it cannot be read, or is too large.
pub fn hash_of(file: &Path) -> Option<u64> {
    Some(stable_hash(&files::read(file, LARGEST).ok()?))
}

/// The cached hashes of files. A file with the same length and time stamp is not read again.
#[derive(Debug, Default)]
pub struct FileHashes(HashMap<PathBuf, Known>);

#[derive(Debug)]
struct Known {
    length: u64,
    changed: SystemTime,
    hash: u64,
}

impl FileHashes {
    /// The same as [`hash_of`], from the cache if the file is unchanged.
    pub fn of(&mut self, file: &Path) -> Option<u64> {
        let about = std::fs::metadata(file).ok()?;
        let (length, changed) = (about.len(), about.modified().ok());
        let known = self.0.get(file);
        let known = known.filter(|known| (known.length, Some(known.changed)) == (length, changed));
        if let Some(known) = known {
            return Some(known.hash);
        }
        let hash = hash_of(file)?;
        let is_old = |time: &SystemTime| time.elapsed().is_ok_and(|age| age > CLOCK);
        if let Some(changed) = changed.filter(is_old) {
            let known = Known { length, changed, hash };
            self.0.insert(file.to_owned(), known);
        }
        Some(hash)
    }
}

#[cfg(test)]
mod tests {
    use std::fs::File;
    use std::time::UNIX_EPOCH;

    use super::*;

    #[test]
    fn a_file_is_read_again_only_if_it_may_have_changed() {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let path = folder.path().join("scene.xml");
        let write = |text: &str, seconds: Option<u64>| {
            std::fs::write(&path, text).expect("a temporary folder");
            if let Some(seconds) = seconds {
                let file = File::options().append(true).open(&path).expect("it is there");
                let time = UNIX_EPOCH + Duration::from_secs(seconds);
                file.set_modified(time).expect("a time");
            }
        };
        let mut hashes = FileHashes::default();
        write("one", Some(1000));
        assert_eq!(hashes.of(&path), hash_of(&path));
        // The file is not read, so that its new content is not noticed.
        write("two", Some(1000));
        assert_eq!(hashes.of(&path), Some(stable_hash(b"one")));
        write("two", Some(2000));
        assert_eq!(hashes.of(&path), Some(stable_hash(b"two")));
        write("three", Some(2000));
        assert_eq!(hashes.of(&path), Some(stable_hash(b"three")));
        // A file that was written just now is read each time.
        for text in ["four", "five"] {
            write(text, None);
            assert_eq!(hashes.of(&path), Some(stable_hash(text.as_bytes())));
        }
        std::fs::remove_file(&path).expect("it is there");
        assert_eq!(hashes.of(&path), None);
    }
}
