//! What the file said, kept beside what it meant: saving starts from it, so that what was not understood, and what was not touched, stays
//! as it was written.

use std::path::PathBuf;
use std::sync::Arc;

use bevy::prelude::*;

use crate::document::{Category, Child, Document, Object, Property};

/// The source of an entity. Absent on entities made in the editor.
#[derive(Component, Clone, Debug, PartialEq)]
pub struct Authored {
    /// As it stands in the file.
    pub object: Object,
    /// As [`super::write`] would have written it from the components it became. What differs from this at the time of saving was edited.
    pub as_read: Object,
    /// What each child of `object` is, references followed; None for those that lead nowhere or were left out.
    pub child_categories: Vec<Option<Category>>,
}

/// The owner inside of which a material is written in the file; absent on those at the top level.
#[derive(Component, Reflect, Clone, Copy, Debug, PartialEq, Eq)]
#[reflect(Component, PartialEq)]
#[relationship(relationship_target = Declares)]
pub struct DeclaredIn(pub Entity);

/// The materials written inside this entity.
#[derive(Component, Reflect, Clone, Debug, Default, PartialEq, Eq)]
#[relationship_target(relationship = DeclaredIn)]
pub struct Declares(Vec<Entity>);

/// Of the scene as a whole: what became no entity.
#[derive(Resource, Clone, Debug, Default, PartialEq)]
pub struct AuthoredScene {
    /// The files as they were read, without messages; None if there was none.
    pub origin: Option<Arc<Document>>,
    /// The integrator with its place in the file.
    pub integrator: Option<(u32, Authored)>,
    /// Where files are looked for besides the scene's folder (`<path>`), absolute.
    pub search_folders: Vec<PathBuf>,
    /// Properties of the scene itself.
    pub properties: Vec<Property>,
    /// Plugins and references that were left out, with their places in the file.
    pub rest: Vec<(u32, Child)>,
}
