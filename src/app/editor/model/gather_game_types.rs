//! Reads the types of a game's components from the schema that the scene names.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use bevy::prelude::*;

use super::EditorModel;
use super::game_types::{GameTypes, TYPES};
use crate::files::read_text;
use crate::scene::{PropertyValue, SceneAccess, SceneProperties, SceneStatus};

/// The longest schema in bytes. That of a game with all plugins of Bevy has some 2 MB.
const LONGEST: u64 = 1 << 26;

/// Reads the schema when the scene names another one.
pub(crate) fn gather_game_types(
    mut model: ResMut<EditorModel>,
    properties: Res<SceneProperties>,
    status: Res<SceneStatus>,
    access: Option<Res<SceneAccess>>,
    mut known: Local<Option<PathBuf>>,
) {
    let named = properties
        .0
        .get(TYPES)
        .map(PropertyValue::text)
        .filter(|name| !name.is_empty());
    let folder = status.path.as_deref().and_then(Path::parent);
    let path = named.map(|name| folder.map_or_else(|| name.clone().into(), |folder| folder.join(&name)));
    if *known == path {
        return;
    }
    let read = |path: &Path| {
        if access.as_ref().is_some_and(|access| !access.get().covers(path)) {
            return Err("the scene may not read this file".to_owned());
        }
        let text = read_text(path, LONGEST).map_err(|error| error.to_string())?;
        GameTypes::read(&text)
    };
    let types = path.as_deref().map_or_else(|| Ok(GameTypes::default()), read);
    let (types, problem) = match types {
        Ok(types) => (types, None),
        Err(error) => (GameTypes::default(), Some(error)),
    };
    (model.0.game_types, model.0.game_types_problem) = (Arc::new(types), problem);
    *known = path;
}
