//! Finds the folders for files that can be made again at any time.

use std::fs::{self, Metadata};
use std::io;
use std::path::{Path, PathBuf};

/// The canonical folder of this name for files that can be made again. It is made if it is not there. None if nothing can be written.
pub(crate) fn cache_folder(name: &str) -> Option<PathBuf> {
    let folder = cache_folders(name).find(|folder| prepare(folder).is_ok());
    folder.and_then(|folder| folder.canonicalize().ok())
}

/// The places of such a folder, best place first, absolute.
pub(super) fn cache_folders(name: &str) -> impl Iterator<Item = PathBuf> {
    let folder = |variable: &str| std::env::var_os(variable).map(PathBuf::from);
    let caches = [
        folder("XDG_CACHE_HOME"),
        folder("LOCALAPPDATA"),
        folder("HOME").map(|home| home.join(".cache")),
        Some(std::env::temp_dir()),
    ];
    let absolute = caches.into_iter().flatten().filter(|folder| folder.is_absolute());
    absolute.map(move |folder| folder.canonicalize().unwrap_or(folder).join("sunroom").join(name))
}

/// Makes the folder of the cache. An error if a link stands in its place or above it, or if it belongs to another user: such a folder may hold
/// links and files that another user has put there.
pub(super) fn prepare(folder: &Path) -> io::Result<()> {
    let planted = || io::Error::other("the folder is a link, or belongs to another user");
    for folder in folder.ancestors().take(2).collect::<Vec<_>>().into_iter().rev() {
        fs::create_dir_all(folder)?;
        let about = fs::symlink_metadata(folder)?;
        if !about.is_dir() || !is_ours(&about) {
            return Err(planted());
        }
    }
    Ok(())
}

#[cfg(target_os = "linux")]
fn is_ours(about: &Metadata) -> bool {
    std::os::unix::fs::MetadataExt::uid(about) == rustix::process::geteuid().as_raw()
}

#[cfg(not(target_os = "linux"))]
fn is_ours(_: &Metadata) -> bool {
    true
}
