//! Opens regular files of a bounded length. Devices, pipes, sockets and folders are refused, even behind symbolic
//! links, and opening one never blocks.

use std::fs::{File, FileType, Metadata};
use std::io::{self, Read};
use std::path::Path;

/// The size limit of a mesh, picture or set of rays in bytes, more than the memory of a usual machine.
pub const LARGEST_DATA: u64 = 64 << 30;

/// The size limit of a script, preferences file or other small text in bytes.
pub const LARGEST_NOTE: u64 = 64 << 20;

/// The reason why a file is not read. The messages do not name the file; the caller adds its name.
#[derive(Debug, thiserror::Error)]
#[allow(missing_docs, reason = "the messages say what the variants mean")]
pub enum FileError {
    #[error(transparent)]
    Io(#[from] io::Error),
    #[error("is a folder, not a file")]
    Folder,
    /// `kind` is a noun with its article, such as "a device".
    #[error("is {kind}, not a file")]
    NotRegular { kind: &'static str },
    /// `limit` is in bytes.
    #[error("is larger than {} MiB, the most that is read of such a file", limit >> 20)]
    TooLarge { limit: u64 },
    /// The text of the error of the memory budget.
    #[error("is larger than {0}")]
    OverBudget(String),
    #[error("is not UTF-8 text")]
    NotUtf8,
    /// The reason why an interrupted set of files cannot be completed, and advice.
    #[error("is one of several files that were being replaced together when the program ended: {0}")]
    BrokenOff(String),
    /// An [`Access`](super::Access) refused the file.
    #[error("lies outside the scene's folder, and the scene is not allowed to read it, whether it exists or not")]
    Outside,
}

impl FileError {
    /// Whether a link has replaced the file or a folder in its path.
    #[cfg(unix)]
    pub(super) fn is_link(&self) -> bool {
        use rustix::io::Errno;
        matches!(self, Self::Io(error) if matches!(Errno::from_io_error(error), Some(Errno::LOOP | Errno::NOTDIR)))
    }

    #[cfg(not(unix))]
    pub(super) fn is_link(&self) -> bool {
        false
    }

    /// Whether there is no file of that name.
    pub fn is_not_found(&self) -> bool {
        matches!(self, Self::Io(error) if error.kind() == io::ErrorKind::NotFound)
    }
}

impl From<FileError> for io::Error {
    fn from(error: FileError) -> Self {
        match error {
            FileError::Io(error) => error,
            other => io::Error::other(other),
        }
    }
}

/// Checks, by metadata alone, whether a file of at most `limit` bytes can be opened.
pub fn check(path: &Path, limit: u64) -> Result<(), FileError> {
    check_metadata(&path.metadata()?, limit)
}

/// Opens a regular file of at most `limit` bytes for reading.
pub fn open(path: &Path, limit: u64) -> Result<File, FileError> {
    // Opening a device may have effects of its own, so the path is checked first.
    check(path, limit)?;
    let file = open_without_blocking(path)?;
    // Another file may have replaced the checked one.
    check_metadata(&file.metadata()?, limit)?;
    Ok(file)
}

/// The content of a regular file of at most `limit` bytes.
pub fn read(path: &Path, limit: u64) -> Result<Vec<u8>, FileError> {
    content(&open(path, limit)?, limit)
}

/// The content of an open file of at most `limit` bytes.
pub(super) fn content(file: &File, limit: u64) -> Result<Vec<u8>, FileError> {
    let mut bytes = Vec::new();
    let length = usize::try_from(file.metadata()?.len()).map_err(|_| FileError::TooLarge { limit })?;
    // One byte more shows the end of the file without a second allocation.
    bytes
        .try_reserve_exact(length.saturating_add(1))
        .map_err(|_| io::Error::from(io::ErrorKind::OutOfMemory))?;
    // Some files of the system have no length, and files may grow while they are read.
    file.take(limit.saturating_add(1)).read_to_end(&mut bytes)?;
    if bytes.len() as u64 > limit {
        return Err(FileError::TooLarge { limit });
    }
    Ok(bytes)
}

/// [`read()`] as UTF-8 text.
pub fn read_text(path: &Path, limit: u64) -> Result<String, FileError> {
    String::from_utf8(read(path, limit)?).map_err(|_| FileError::NotUtf8)
}

fn check_metadata(about: &Metadata, limit: u64) -> Result<(), FileError> {
    if about.is_dir() {
        Err(FileError::Folder)
    } else if !about.is_file() {
        let kind = kind(about.file_type());
        Err(FileError::NotRegular { kind })
    } else if about.len() > limit {
        Err(FileError::TooLarge { limit })
    } else {
        Ok(())
    }
}

#[cfg(unix)]
fn kind(file_type: FileType) -> &'static str {
    use std::os::unix::fs::FileTypeExt;
    if file_type.is_fifo() {
        "a pipe"
    } else if file_type.is_socket() {
        "a socket"
    } else {
        "a device"
    }
}

#[cfg(not(unix))]
fn kind(_: FileType) -> &'static str {
    "a device or a pipe"
}

/// Opening a pipe without this flag waits for a writer. Reading a regular file is not affected by it.
#[cfg(unix)]
fn open_without_blocking(path: &Path) -> io::Result<File> {
    use rustix::fs::{Mode, OFlags};
    let flags = OFlags::RDONLY | OFlags::NONBLOCK | OFlags::NOCTTY | OFlags::CLOEXEC;
    Ok(File::from(rustix::fs::open(path, flags, Mode::empty())?))
}

#[cfg(not(unix))]
fn open_without_blocking(path: &Path) -> io::Result<File> {
    File::open(path)
}

/// [`open`] for an absolute path without links: it opens the file at exactly this path, even if other programs move and
/// replace files meanwhile. If a link has replaced any part of the path, it fails with [`FileError::is_link`].
#[cfg(unix)]
pub(super) fn open_without_links(path: &Path, limit: u64) -> Result<File, FileError> {
    use std::os::fd::OwnedFd;

    use rustix::fs::{AtFlags, CWD, FileType, Mode, OFlags, openat, statat};

    // Each folder is opened in the one before. Only Linux opens folders that may be traversed but not listed.
    let passing = OFlags::DIRECTORY | OFlags::NOFOLLOW | OFlags::CLOEXEC;
    #[cfg(target_os = "linux")]
    let passing = passing | OFlags::PATH;
    let mut folder: Option<OwnedFd> = None;
    let mut parts = path.components().peekable();
    while let Some(part) = parts.next() {
        let open = |flags: OFlags| match &folder {
            Some(folder) => openat(folder, part.as_os_str(), flags, Mode::empty()),
            None => openat(CWD, part.as_os_str(), flags, Mode::empty()),
        };
        if parts.peek().is_some() {
            folder = Some(open(passing).map_err(io::Error::from)?);
            continue;
        }
        // Opening a device may have effects of its own, so the type is checked first. Opening a link fails.
        if let Some(folder) = &folder {
            let about = statat(folder, part.as_os_str(), AtFlags::SYMLINK_NOFOLLOW).map_err(io::Error::from)?;
            match FileType::from_raw_mode(about.st_mode) {
                FileType::RegularFile | FileType::Symlink => {}
                FileType::Directory => return Err(FileError::Folder),
                FileType::Fifo => return Err(FileError::NotRegular { kind: "a pipe" }),
                FileType::Socket => return Err(FileError::NotRegular { kind: "a socket" }),
                _ => return Err(FileError::NotRegular { kind: "a device" }),
            }
        }
        let reading = OFlags::RDONLY | OFlags::NONBLOCK | OFlags::NOCTTY | OFlags::NOFOLLOW | OFlags::CLOEXEC;
        let file = File::from(open(reading).map_err(io::Error::from)?);
        check_metadata(&file.metadata()?, limit)?;
        return Ok(file);
    }
    Err(FileError::Folder)
}

/// [`open`]: without a system call to open a file in an open folder, the path is resolved once more.
#[cfg(not(unix))]
pub(super) fn open_without_links(path: &Path, limit: u64) -> Result<File, FileError> {
    open(path, limit)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::fs;

    #[test]
    fn the_length_is_bounded_before_and_while_reading() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("text");
        fs::write(&path, "12345").unwrap();
        assert_eq!(read(&path, 5).unwrap(), b"12345");
        assert!(matches!(read(&path, 4), Err(FileError::TooLarge { limit: 4 })));
        assert_eq!(read_text(&path, 5).unwrap(), "12345");
        fs::write(&path, [0xff]).unwrap();
        assert!(matches!(read_text(&path, 5), Err(FileError::NotUtf8)));
        assert!(read(&folder.path().join("nothing"), 5).unwrap_err().is_not_found());
        assert!(matches!(read(folder.path(), 5), Err(FileError::Folder)));
        // A system file that is longer than its metadata says.
        let endless = Path::new("/proc/self/maps");
        if endless.is_file() {
            assert!(matches!(read(endless, 10), Err(FileError::TooLarge { .. })));
        }
    }

    #[cfg(unix)]
    #[test]
    fn devices_pipes_and_sockets_are_refused_at_once_also_behind_links() {
        let folder = tempfile::tempdir().unwrap();
        let [pipe, socket] = ["pipe", "socket"].map(|name| folder.path().join(name));
        rustix::fs::mknodat(
            rustix::fs::CWD,
            &pipe,
            rustix::fs::FileType::Fifo,
            rustix::fs::Mode::RUSR,
            0,
        )
        .unwrap();
        let _listener = std::os::unix::net::UnixListener::bind(&socket).unwrap();
        for (target, expected) in [
            (Path::new("/dev/zero"), "a device"),
            (&pipe, "a pipe"),
            (&socket, "a socket"),
        ] {
            let link = folder.path().join(expected);
            std::os::unix::fs::symlink(target, &link).unwrap();
            for path in [target, &link] {
                let found = read(path, 5).unwrap_err();
                assert!(
                    matches!(found, FileError::NotRegular { kind } if kind == expected),
                    "{found}"
                );
            }
        }
        // The handle is checked as well: opening does not wait, even if the path was replaced.
        let handle = open_without_blocking(&pipe).unwrap();
        assert!(check_metadata(&handle.metadata().unwrap(), 5).is_err());
    }
}
