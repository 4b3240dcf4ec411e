//! Moves the cached parts of opened glTF files: the parts named by a written scene go into a folder beside it.

use std::collections::{BTreeMap, HashSet};
use std::path::{Path, PathBuf};
use std::sync::Arc;

use crate::document::paths::{file_name, settle};
use crate::document::{Child, Object, Value};
use crate::scene::assets::parts_cache::is_part;

/// The moves of parts, from and to absolute paths.
pub type Moves = BTreeMap<PathBuf, PathBuf>;

/// Renames the parts named in a document for writing to `target` (absolute). Names are relative to `folder`, before and
/// after.
pub fn take_along(root: &mut Object, folder: &Path, target: &Path) -> Moves {
    let mut moves = Moves::new();
    // Files beside the scene from an earlier save stay there.
    let mut named = HashSet::new();
    for_each_name(root, &mut |name| {
        named.insert(settle(&folder.join(&*name)));
    });
    for_each_name(root, &mut |name| {
        let part = settle(&folder.join(&*name));
        if is_part(&part) {
            *name = file_name(&place(part, target, &named, &mut moves), folder);
        }
    });
    moves
}

/// Calls `meet` with the name of each file.
fn for_each_name(object: &mut Object, meet: &mut dyn FnMut(&mut String)) {
    for property in &mut object.properties {
        if property.name != "filename" {
            continue;
        }
        let keys = property.keys.as_mut().map(|track| &mut Arc::make_mut(track).keys);
        let keyed = keys.into_iter().flatten().map(|key| &mut key.value);
        for value in std::iter::once(&mut property.value).chain(keyed) {
            if let Value::String(name) = value {
                meet(name);
            }
        }
    }
    for child in &mut object.children {
        if let Child::Object(inner) = child {
            for_each_name(Arc::make_mut(inner), meet);
        }
    }
}

/// The new path of a part in the folder of this scene. Parts of several files may have the same name. `named`: the
/// files that the scene names.
fn place(part: PathBuf, target: &Path, named: &HashSet<PathBuf>, moves: &mut Moves) -> PathBuf {
    if let Some(place) = moves.get(&part) {
        return place.clone();
    }
    let stem = target.file_stem().unwrap_or_default().to_string_lossy();
    let folder = target.with_file_name(format!("{stem}-files"));
    let name = part.file_name().unwrap_or_default().to_string_lossy().into_owned();
    let numbered = (2..).map(|number| format!("{number}-{name}"));
    let mut places = std::iter::once(name.clone())
        .chain(numbered)
        .map(|name| folder.join(name));
    let free = places.find(|place| !named.contains(place) && !moves.values().any(|taken| taken == place));
    let place = free.unwrap_or_else(|| folder.join(&name));
    moves.insert(part, place.clone());
    place
}
