//! Writes a file, with the error of saving.

use std::path::Path;

use super::error::SaveError;
use crate::files::write_atomically;

pub(super) fn write_file(path: &Path, content: impl AsRef<[u8]>) -> Result<(), SaveError> {
    write_atomically(path, content).map_err(|source| SaveError::File {
        path: path.to_owned(),
        source,
    })
}
