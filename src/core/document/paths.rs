//! Handles the file names in scene files.

use std::collections::HashSet;
use std::path::{Component, Path, PathBuf};

use crate::files::Access;

/// The path with all links resolved, or unchanged if no file is there.
pub(super) fn canonical(path: &Path) -> PathBuf {
    path.canonicalize().unwrap_or_else(|_| path.to_owned())
}

/// The path `path` relative to `folder`, with `/` between folders. Both are absolute. The result is absolute only on
/// another drive, and if the folder is a root, as for the clipboard. A `..` of `path`, as below a folder that does not
/// exist, stays.
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
        let is_name = |part: &Component| matches!(part, Component::Normal(_) | Component::ParentDir);
        let names = path.components().filter(is_name);
        names.map(|part| PathBuf::from(part.as_os_str())).collect()
    };
    let (path, folder) = (names(path), names(folder));
    let up = std::iter::repeat_n("..".into(), folder.len() - common);
    let down = path[common..].iter().map(|part| part.to_string_lossy().into_owned());
    let name = up.chain(down).collect::<Vec<String>>().join("/");
    if name.is_empty() { ".".to_owned() } else { name }
}

/// The absolute path, with the folder's links and `..` resolved but not the file's own link: editors replace files, not
/// folders. Below a folder that does not exist the path stays unchanged.
pub fn settle(path: &Path) -> PathBuf {
    let absolute = std::path::absolute(path).unwrap_or_else(|_| path.to_owned());
    let mut folders = absolute.ancestors().skip(1);
    let resolved = folders.find_map(|folder| {
        let rest = absolute.strip_prefix(folder).ok()?;
        Some(folder.canonicalize().ok()?.join(rest))
    });
    match absolute.file_name() {
        Some(_) => resolved.unwrap_or(absolute),
        None => absolute,
    }
}

/// The path that [`settle`] makes of `name` in `folder`, if `access` covers it. Otherwise the path as named, without
/// leading `..`: neither messages nor written files may reveal the targets of links that the scene must not follow.
pub fn settle_covered(folder: &Path, name: &Path, access: &Access) -> PathBuf {
    let joined = folder.join(name);
    if access.covers(&joined) {
        return settle(&joined);
    }
    let mut place = std::path::absolute(folder).unwrap_or_else(|_| folder.to_owned());
    let mut parts = name.components().peekable();
    while let Some(part) = parts.next_if(|part| matches!(part, Component::CurDir | Component::ParentDir)) {
        if part == Component::ParentDir {
            place.pop();
        }
    }
    place.join(parts.collect::<PathBuf>())
}

/// The candidate paths of a file with this name: in the given folders, then in the search folders, the last named
/// first.
pub(super) fn file_candidates(name: &str, folders: &[PathBuf], search_folders: &[PathBuf]) -> Vec<PathBuf> {
    if Path::new(name).is_absolute() {
        return vec![PathBuf::from(name)];
    }
    let mut known = HashSet::new();
    let all = folders.iter().chain(search_folders.iter().rev());
    all.map(|folder| folder.join(name))
        .filter(|candidate| known.insert(candidate.clone()))
        .collect()
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
        assert_eq!(
            name("/a/scenes/absent/../c.png", "/a/other"),
            "../scenes/absent/../c.png"
        );
    }

    #[test]
    fn what_exists_of_a_path_is_resolved() {
        let root = tempfile::tempdir().unwrap();
        std::fs::create_dir_all(root.path().join("a/b")).unwrap();
        let folder = root.path().canonicalize().unwrap();
        for (path, expected) in [
            ("a/b/../c.png", "a/c.png"),
            ("a/../absent/c.png", "absent/c.png"),
            ("a/absent/../c.png", "a/absent/../c.png"),
        ] {
            assert_eq!(settle(&root.path().join(path)), folder.join(expected));
        }
    }
}
