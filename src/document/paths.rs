//! File names as they stand in scene files.

use std::path::{Component, Path, PathBuf};

/// `path` as seen from `folder`, with `/` between folders. Both are absolute. The result is absolute only for another drive, and for a
/// folder that is a root, as that of the clipboard.
pub fn file_name(path: &Path, folder: &Path) -> String {
    let root = |path: &Path| {
        let parts = path.components();
        parts
            .take_while(|part| !matches!(part, Component::Normal(_)))
            .collect::<PathBuf>()
    };
    if root(path) != root(folder) || folder.file_name().is_none() {
        return path.to_string_lossy().into_owned();
    }
    let common = path
        .components()
        .zip(folder.components())
        .take_while(|(a, b)| a == b)
        .filter(|(part, _)| matches!(part, Component::Normal(_)))
        .count();
    let names = |path: &Path| -> Vec<PathBuf> {
        let normal = path.components().filter(|part| matches!(part, Component::Normal(_)));
        normal.map(|part| PathBuf::from(part.as_os_str())).collect()
    };
    let (path, folder) = (names(path), names(folder));
    let up = std::iter::repeat_n("..".into(), folder.len() - common);
    let down = path[common..].iter().map(|part| part.to_string_lossy().into_owned());
    let name = up.chain(down).collect::<Vec<String>>().join("/");
    if name.is_empty() { ".".to_owned() } else { name }
}

/// Absolute, with the folder's links and `..` resolved but not the file's own link: editors replace files, not folders.
pub fn settle(path: &Path) -> PathBuf {
    let absolute = std::path::absolute(path).unwrap_or_else(|_| path.to_owned());
    match (absolute.parent().map(Path::canonicalize), absolute.file_name()) {
        (Some(Ok(folder)), Some(name)) => folder.join(name),
        _ => absolute,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_relative_where_that_helps() {
        let name = |path: &str, folder: &str| file_name(Path::new(path), Path::new(folder));
        assert_eq!(name("/a/b/c.obj", "/a/b"), "c.obj");
        assert_eq!(name("/a/models/c.obj", "/a/scenes"), "../models/c.obj");
        assert_eq!(name("/x/c.obj", "/a/scenes"), "../../x/c.obj");
        assert_eq!(name("/x/c.obj", "/"), "/x/c.obj");
        assert_eq!(name("c.obj", "/a"), "c.obj");
    }
}
