//! Gives things that name missing files other paths, where the files are now.

use std::collections::HashMap;
use std::path::{Path, PathBuf};

use bevy::prelude::*;

use crate::app::editor::command::error::CommandError;
use crate::app::editor::session::history::Edit;
use crate::app::editor::session::toasts::Toasts;
use crate::app::editor::session::trust;
use crate::app::editor::words::files::{LAMPS, PICTURES, extension};
use crate::document::paths::settle;
use crate::scene::{AreaLight, Emitter, Material, Medium, NamesFiles, SceneStatus, Shape};

/// Replaces the path `missing` by `found` wherever it is named. With `others` the other missing files are searched
/// beside it.
pub fn find(edit: &mut Edit, missing: &Path, found: &Path, others: bool) -> Result<(), CommandError> {
    let found = settle(found);
    if !found.is_file() {
        return Err(format!("{}: there is no such file.", found.display()).into());
    }
    let kinds = [missing, &found].map(extension);
    let are_all = |known: &[&str]| kinds.iter().all(|kind| known.contains(&kind.as_str()));
    if kinds[0] != kinds[1] && !are_all(&PICTURES) && !are_all(&LAMPS) {
        let [wanted, given] = kinds;
        return Err(
            format!("The scene names a file of the kind .{wanted}, and this is one of the kind .{given}.").into(),
        );
    }
    let status = edit.world.resource::<SceneStatus>();
    let all: Vec<PathBuf> = status.missing_files().map(|problem| problem.path.clone()).collect();
    let mut moves = HashMap::from([(missing.to_owned(), found.clone())]);
    if others {
        let sought = all.iter().filter(|path| path.as_path() != missing);
        moves.extend(sought.filter_map(|path| Some((path.clone(), beside(missing, &found, path)?))));
    }
    let mut named = Vec::new();
    relink::<Shape>(edit, &moves, &mut named);
    relink::<Material>(edit, &moves, &mut named);
    relink::<AreaLight>(edit, &moves, &mut named);
    relink::<Emitter>(edit, &moves, &mut named);
    relink::<Medium>(edit, &moves, &mut named);
    named.sort();
    named.dedup();
    if !named.iter().any(|path| path == missing) {
        let name = name(missing);
        return Err(format!("Nothing in the scene names {name}; the materials of a mesh file may do so.").into());
    }
    trust::allow_chosen(edit.world, &found);
    if let Some(folder) = found.parent() {
        trust::allow_beside(edit.world, folder, named.iter().filter_map(|path| moves.get(path)));
    }
    let left = all.iter().filter(|path| !named.contains(path)).count();
    edit.world
        .resource_mut::<Toasts>()
        .info(summary(missing, named.len(), left));
    Ok(())
}

/// Replaces paths in the components of this kind; old paths that occurred are added to `named`.
fn relink<C: Component + NamesFiles + Clone + PartialEq>(
    edit: &mut Edit,
    moves: &HashMap<PathBuf, PathBuf>,
    named: &mut Vec<PathBuf>,
) {
    let mut changed = Vec::new();
    for (entity, before) in edit.world.query::<(Entity, &C)>().iter(edit.world) {
        let mut after = before.clone();
        let mut has_changed = false;
        after.for_each_file(&mut |path| {
            if let Some(found) = moves.get(path) {
                named.push(std::mem::replace(path, found.clone()));
                has_changed = true;
            }
        });
        if has_changed {
            changed.push((entity, after));
        }
    }
    for (entity, after) in changed {
        edit.set(entity, after);
    }
}

/// The present path of another missing file: at the same relative path from the found one, or by its name in the same
/// folder.
fn beside(missing: &Path, found: &Path, other: &Path) -> Option<PathBuf> {
    let folder = found.parent()?;
    let as_before = relative(missing.parent()?, other).map(|way| folder.join(way));
    let by_name = other.file_name().map(|name| folder.join(name));
    let places = as_before.into_iter().chain(by_name);
    places.map(|path| settle(&path)).find(|path| path.is_file())
}

/// The relative path from a folder to a file.
fn relative(folder: &Path, file: &Path) -> Option<PathBuf> {
    let (mut up, mut base) = (PathBuf::new(), folder);
    loop {
        if let Ok(down) = file.strip_prefix(base) {
            return Some(up.join(down));
        }
        up.push("..");
        base = base.parent()?;
    }
}

fn name(path: &Path) -> String {
    path.file_name().unwrap_or_default().to_string_lossy().into_owned()
}

fn summary(missing: &Path, found: usize, left: usize) -> String {
    let others = match found.saturating_sub(1) {
        0 => String::new(),
        1 => " and another file".to_owned(),
        more => format!(" and {more} other files"),
    };
    let left = match left {
        0 => String::new(),
        1 => "; one file is still missing".to_owned(),
        left => format!("; {left} files are still missing"),
    };
    format!("Found {}{others}{left}", name(missing))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn others_are_found_where_they_lay_before_and_in_the_same_folder() {
        let root = tempfile::tempdir().expect("a folder");
        let root = root.path().canonicalize().expect("a folder");
        let path = |name: &str| root.join(name);
        for folder in ["new/models", "new/textures"] {
            std::fs::create_dir_all(path(folder)).expect("a folder");
        }
        for file in [
            "new/models/a.ply",
            "new/models/b.ply",
            "new/textures/c.png",
            "new/models/c.png",
        ] {
            std::fs::write(path(file), "").expect("a file");
        }
        let (missing, found) = (Path::new("/old/level/models/a.ply"), path("new/models/a.ply"));
        for (other, expected) in [
            ("/old/level/models/b.ply", Some("new/models/b.ply")),
            ("/old/level/textures/c.png", Some("new/textures/c.png")),
            ("/elsewhere/b.ply", Some("new/models/b.ply")),
            ("/old/level/models/d.ply", None),
        ] {
            let place = beside(missing, &found, Path::new(other));
            assert_eq!(place, expected.map(path), "{other}");
        }
    }

    #[test]
    fn what_was_found_is_told() {
        let path = Path::new("/a/chair.obj");
        assert_eq!(summary(path, 1, 0), "Found chair.obj");
        assert_eq!(
            summary(path, 2, 1),
            "Found chair.obj and another file; one file is still missing"
        );
        assert_eq!(
            summary(path, 4, 2),
            "Found chair.obj and 3 other files; 2 files are still missing"
        );
    }
}
