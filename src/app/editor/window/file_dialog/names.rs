//! Names and paths of files as they are typed: detection of paths, and extensions.

use std::path::{Component, Path, PathBuf};

use crate::app::editor::words::files::extension;

/// Whether a text is a path, and not a part of a name: names have no separators.
pub(super) fn is_path(text: &str) -> bool {
    let is_drive = matches!(Path::new(text).components().next(), Some(Component::Prefix(_)));
    is_drive || text.contains(std::path::is_separator)
}

/// A path without `.` and `..`. Links are not followed, so that `..` leads back to the folder one came from.
pub(super) fn without_dots(path: &Path) -> PathBuf {
    let mut plain = PathBuf::new();
    for part in path.components() {
        match part {
            Component::CurDir => {}
            Component::ParentDir => {
                plain.pop();
            }
            part => plain.push(part),
        }
    }
    plain
}

/// Whether the file has the extension of one of the formats.
pub(super) fn is_of(formats: &[(&str, &str)], path: &Path) -> bool {
    formats.iter().any(|(_, known)| *known == extension(path))
}

/// The path with `.` and an extension appended.
pub(super) fn with_end(path: PathBuf, extension: &str) -> PathBuf {
    let mut name = path.into_os_string();
    name.push(format!(".{extension}"));
    name.into()
}

/// The name of a file in the format with this extension.
pub(super) fn in_format(name: &str, formats: &[(&str, &str)], extension: &str) -> String {
    let path = Path::new(name);
    let bare = match is_of(formats, path) {
        true => path.with_extension(""),
        false => path.to_path_buf(),
    };
    with_end(bare, extension).to_string_lossy().into_owned()
}
