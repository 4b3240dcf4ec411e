//! Finds the cache folders, whose files can be recreated at any time.

use std::fs::{self, Metadata};
use std::io;
use std::path::{Path, PathBuf};

/// The canonical cache folder of this name, which is made if it does not exist. None if none can be written.
pub(crate) fn cache_folder(name: &str) -> Option<PathBuf> {
    let folder = cache_folders(name).find(|folder| prepare(folder).is_ok());
    folder.and_then(|folder| folder.canonicalize().ok())
}

/// The candidates for a cache folder, best first, absolute.
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
    // All users share the folder for temporary files, and a user's cache must not be used by another.
    let shared = (std::env::temp_dir(), format!("sunroom{}", suffix_of_user()));
    let all = of_user.chain([shared]).filter(|(folder, _)| folder.is_absolute());
    all.map(move |(folder, own)| folder.canonicalize().unwrap_or(folder).join(own).join(name))
}

#[cfg(target_os = "linux")]
fn suffix_of_user() -> String {
    format!("-{}", rustix::process::geteuid().as_raw())
}

/// Elsewhere the folder for temporary files belongs to the user.
#[cfg(not(target_os = "linux"))]
fn suffix_of_user() -> String {
    String::new()
}

/// Makes the cache folder. An error if it or a folder above it is a link, or if it belongs to another user: such a
/// folder may hold links and files of that user.
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

/// Makes a folder with access for the user only.
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
