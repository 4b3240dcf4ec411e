//! Locks folders, so that programs that work on the same files take turns.

use std::fs::{File, TryLockError};
use std::path::Path;
use std::time::{Duration, Instant};

/// A folder is locked while this is there.
#[derive(Debug)]
pub struct FolderLock {
    _folder: Option<File>,
}

/// Another program held the lock for the whole time.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct FolderBusy;

/// Waits for the lock of a folder, at most for `longest`. Where folders cannot be locked, no lock is taken, and that is
/// no error: locks only help other programs that take them, too.
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
    use super::*;

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
