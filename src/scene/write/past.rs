//! A scene file as it was before a save, kept for edits that are undone after it.
//!
//! A save edits a text where the scene differs from its reading. Usually that is the present text of the file. After
//! saved edits are undone, the text from before them is closer to the scene: the parts that they changed or deleted are
//! still there, in their old spelling and at their old place.

use std::collections::HashSet;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use bevy::ecs::entity::EntityHashMap;
use bevy::prelude::*;

use super::changed::Expected;
use super::writer::identities;
use crate::document::Document;
use crate::document::paths::settle;
use crate::scene::file::entities::Entities;
use crate::scene::file::file_base::{FileBase, Thing};
use crate::scene::read::read;
use crate::scene::{Authored, AuthoredScene, ObjectState, SceneDescription, SceneId};

/// The former document of a file, and the entities of the things in it.
#[derive(Clone, Debug)]
pub(crate) struct PastFile {
    origin: Arc<Document>,
    /// In the order of the document's reading.
    entities: Entities,
}

/// An id that a thing was given during a save, because something refers to it.
#[derive(Clone, Debug)]
pub(crate) struct GivenId {
    pub entity: Entity,
    pub before: Option<SceneId>,
    pub name_before: Option<Name>,
    pub id: SceneId,
}

impl GivenId {
    /// Removes the id from a thing that still has it, and returns it. A later save gives it again if needed.
    pub(crate) fn take_back(&self, world: &mut World) -> Option<TakenId> {
        let has_it = world.get::<SceneId>(self.entity) == Some(&self.id);
        if !has_it || self.before.is_some() || !ObjectState::is_in_scene(world, self.entity) {
            return None;
        }
        let mut thing = world.entity_mut(self.entity);
        let taken = TakenId {
            entity: self.entity,
            id: thing.take()?,
            name: thing.get().cloned(),
        };
        thing.insert(self.name_before.clone().unwrap_or_default());
        Some(taken)
    }
}

/// An id that was removed from a thing for a save, with its name.
#[derive(Debug)]
pub(crate) struct TakenId {
    entity: Entity,
    id: SceneId,
    name: Option<Name>,
}

impl TakenId {
    /// Restores the ids because the save has failed: the file still has them. A thing that has got another id meanwhile
    /// keeps it, and an id that is taken meanwhile stays there.
    pub(crate) fn give_again(all: Vec<Self>, world: &mut World) {
        if all.is_empty() {
            return;
        }
        let used: HashSet<SceneId> = world.query::<&SceneId>().iter(world).cloned().collect();
        for Self { entity, id, name } in all {
            let has_another = world.get::<SceneId>(entity).is_some();
            if !has_another && !used.contains(&id) && ObjectState::is_in_scene(world, entity) {
                world.entity_mut(entity).insert((id, name.unwrap_or_default()));
            }
        }
    }
}

impl PastFile {
    /// None for a scene that was not read from a scene file.
    pub(in crate::scene) fn new(known: &AuthoredScene, base: &FileBase) -> Option<Self> {
        let origin = known.origin.clone().filter(|origin| !origin.imported)?;
        let entities = base.entities.clone();
        Some(Self { origin, entities })
    }

    /// Whether it was the file at this path.
    pub fn is_at(&self, path: &Path) -> bool {
        settle(&self.origin.path) == settle(path)
    }

    /// The length of its texts in bytes.
    pub fn text_len(&self) -> usize {
        let sources = self.origin.diagnostics.sources.iter();
        sources.map(|source| source.text.len()).sum()
    }

    /// Makes it the source of a scene that will be saved, with these entities. False, without changes, if it does not
    /// fit.
    pub(super) fn put_under(&self, scene: &mut SceneDescription, entities: &Entities, expected: &[Expected]) -> bool {
        let sources = &self.origin.diagnostics.sources;
        let are_known = sources
            .iter()
            .all(|source| expected.iter().any(|file| file.is(&settle(&source.path))));
        let past = read(&mut self.origin.at(scene.time));
        // The name was free in the newer file.
        let is_taken = |id: &Option<String>| {
            let id = id.as_deref().unwrap_or_default();
            past.remains.foreign_ids.contains(id) && !scene.remains.foreign_ids.contains(id)
        };
        let fits = are_known
            && self.entities.all().count() == Thing::all(&past).count()
            && !identities(scene).any(|identity| is_taken(&identity.id));
        if !fits {
            return false;
        }
        let said: EntityHashMap<&Authored> = Thing::all(&past)
            .filter_map(|thing| {
                let authored = thing.identity(&past).authored.as_ref()?;
                Some((thing.entity(&self.entities), authored))
            })
            .collect();
        for thing in Thing::all(scene) {
            let authored = said
                .get(&thing.entity(entities))
                .map(|authored| Authored::clone(authored));
            let identity = thing.identity_mut(scene);
            identity.span = authored
                .as_ref()
                .map(|authored| authored.object.span)
                .unwrap_or_default();
            identity.authored = authored;
        }
        scene.remains = past.remains.clone();
        true
    }

    /// All files to write: `files`, of which the main one is last, preceded by the files that have to be restored.
    pub(super) fn with_others(
        &self,
        mut files: Vec<(PathBuf, String)>,
        expected: &[Expected],
    ) -> Vec<(PathBuf, String)> {
        let mut others = Vec::new();
        for source in &self.origin.diagnostics.sources {
            let path = settle(&source.path);
            let is_written = files.iter().any(|(written, _)| settle(written) == path);
            let is_as_it_was = expected.iter().any(|file| file.is_read_as(&path, source));
            if !is_written && !is_as_it_was {
                others.push((path, source.with_mark()));
            }
        }
        files.splice(0..0, others);
        files
    }
}
