//! Hashes of what files hold, by which it is known whether they were changed.

use std::collections::HashMap;
use std::path::{Path, PathBuf};
use std::time::{Duration, SystemTime};

use super::stable_hash::stable_hash;
use crate::files;

/// The largest file, in bytes, that is read for its hash.
const LARGEST: u64 = 32 << 20;
/// A file that was written within this time may be written again without getting another time: some file systems keep
/// even seconds only.
const CLOCK: Duration = Duration::from_secs(3);

/// The hash of what a file holds. None if it cannot be read, or is too large to be read for this alone.
pub fn hash_of(file: &Path) -> Option<u64> {
    Some(stable_hash(&files::read(file, LARGEST).ok()?))
}

/// The hashes of files that were looked at before. A file with the same length and time is not read again.
#[derive(Debug, Default)]
pub struct FileHashes(HashMap<PathBuf, Known>);

#[derive(Debug)]
struct Known {
    length: u64,
    changed: SystemTime,
    hash: u64,
}

impl FileHashes {
    /// Does what [`hash_of`] does.
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
        // It is not read, so that the other content is not seen.
        write("two", Some(1000));
        assert_eq!(hashes.of(&path), Some(stable_hash(b"one")));
        write("two", Some(2000));
        assert_eq!(hashes.of(&path), Some(stable_hash(b"two")));
        write("three", Some(2000));
        assert_eq!(hashes.of(&path), Some(stable_hash(b"three")));
        // What was written just now is read each time.
        for text in ["four", "five"] {
            write(text, None);
            assert_eq!(hashes.of(&path), Some(stable_hash(text.as_bytes())));
        }
        std::fs::remove_file(&path).expect("it is there");
        assert_eq!(hashes.of(&path), None);
    }
}
