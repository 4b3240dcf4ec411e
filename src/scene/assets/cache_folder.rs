//! Finds the folders for files that can be made again at any time.

use std::fs::{self, Metadata};
use std::io;
use std::path::{Path, PathBuf};

/// The canonical folder of this name for files that can be made again. It is made if it is not there. None if nothing
/// can be written.
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
    ];
    let of_user = caches
        .into_iter()
        .flatten()
        .map(|folder| (folder, "sunroom".to_owned()));
    // All users share the folder for temporary files, and nobody may use what belongs to another.
    let shared = (std::env::temp_dir(), format!("sunroom{}", suffix_of_user()));
    let all = of_user.chain([shared]).filter(|(folder, _)| folder.is_absolute());
    all.map(move |(folder, own)| folder.canonicalize().unwrap_or(folder).join(own).join(name))
}

#[cfg(target_os = "linux")]
fn suffix_of_user() -> String {
    format!("-{}", rustix::process::geteuid().as_raw())
}

/// The folder for temporary files is the user's own elsewhere.
#[cfg(not(target_os = "linux"))]
fn suffix_of_user() -> String {
    String::new()
}

/// Makes the folder of the cache. An error if a link stands in its place or above it, or if it belongs to another user:
/// such a folder may hold links and files that another user has put there.
pub(super) fn prepare(folder: &Path) -> io::Result<()> {
    let planted = || io::Error::other("the folder is a link, or belongs to another user");
    for folder in folder.ancestors().take(2).collect::<Vec<_>>().into_iter().rev() {
        make_private(folder)?;
        let about = fs::symlink_metadata(folder)?;
        if !about.is_dir() || !is_ours(&about) {
            return Err(planted());
        }
    }
    Ok(())
}

/// Makes a folder that only the user can look into.
fn make_private(folder: &Path) -> io::Result<()> {
    let mut builder = fs::DirBuilder::new();
    #[cfg(unix)]
    std::os::unix::fs::DirBuilderExt::mode(&mut builder, 0o700);
    builder.recursive(true).create(folder)
}

#[cfg(target_os = "linux")]
fn is_ours(about: &Metadata) -> bool {
    std::os::unix::fs::MetadataExt::uid(about) == rustix::process::geteuid().as_raw()
}

#[cfg(not(target_os = "linux"))]
fn is_ours(_: &Metadata) -> bool {
    true
}
