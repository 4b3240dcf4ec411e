//! Replaces files as a whole or not at all.

use std::io::{self, Write as _};
use std::path::Path;

/// Replaces a file's content in one step: readers see the old content or the new, never half of it, and after a failure the old one is
/// there. A symbolic link stays one, an old file keeps its permissions.
pub fn write_atomically(path: &Path, content: impl AsRef<[u8]>) -> io::Result<()> {
    let target = path.canonicalize().unwrap_or_else(|_| path.to_owned());
    let folder = match target.parent() {
        Some(folder) if !folder.as_os_str().is_empty() => folder,
        _ => Path::new("."),
    };
    // Otherwise the message would be about the name of a file that is not the user's.
    if !folder.is_dir() {
        let message = format!("there is no folder {}", folder.display());
        return Err(io::Error::new(io::ErrorKind::NotFound, message));
    }
    let mut builder = tempfile::Builder::new();
    builder.prefix(".sunroom-").suffix(".part");
    // As an ordinary new file would be: temporary ones are for their owner only.
    #[cfg(unix)]
    builder.permissions(std::os::unix::fs::PermissionsExt::from_mode(0o666));
    // By its kind: the full message names the temporary file.
    let mut file = builder.tempfile_in(folder).map_err(|error| error.kind())?;
    if let Ok(old) = std::fs::metadata(&target) {
        file.as_file().set_permissions(old.permissions())?;
    }
    file.write_all(content.as_ref())?;
    file.as_file().sync_all()?;
    file.persist(&target).map_err(|error| error.error)?;
    Ok(())
}
