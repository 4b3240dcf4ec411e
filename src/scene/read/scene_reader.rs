//! The description under construction, and the reading common to every kind of object.

use std::borrow::Cow;
use std::collections::{HashMap, HashSet};
use std::path::{Path, PathBuf};
use std::sync::Arc;

use smol_str::SmolStr;

use super::mesh_search::MeshSearch;
use super::picture_search::PictureSearch;
use crate::document::animation::animated_objects;
use crate::document::paths::settle;
use crate::document::{Category, Child, Crowd, Diagnostics, Document, Index, Object, Reader, Span, Value};
use crate::scene::components::description::{Identity, SceneDescription};
use crate::scene::encode::with_properties;
use crate::scene::{Authored, EulerAngles, Keys, Material, MissingFiles, Properties, ShapeKind};

/// An object's order among all objects of the document.
pub struct Place<'a> {
    pub object: &'a Arc<Object>,
    pub order: u32,
    pub top_level: bool,
}

/// The description under construction.
pub struct SceneReader<'a> {
    /// Whether things keep their source in the file.
    pub keeps_source: bool,
    pub root: &'a Object,
    pub search_folders: &'a [PathBuf],
    pub index: Index<'a>,
    pub diagnostics: Diagnostics,
    pub meshes: MeshSearch,
    pub pictures: PictureSearch,
    pub folder: PathBuf,
    pub places: HashMap<usize, Place<'a>>,
    /// The index of the medium for each object read; None for an unreadable one.
    pub medium_of: HashMap<usize, Option<usize>>,
    pub material_of: HashMap<usize, usize>,
    pub group_of: HashMap<usize, usize>,
    pub crowds: &'a [Crowd],
    /// The order of the first instance of each crowd.
    pub crowd_orders: Vec<u32>,
    /// The number of crowds that have become shapes.
    pub crowds_read: usize,
    /// The addresses of the objects with animated values in their subtree.
    pub animated: HashSet<usize>,
    pub description: SceneDescription,
}

/// The address of an object as its key: the document does not move while it is read.
pub fn address(object: &Object) -> usize {
    std::ptr::from_ref(object).addr()
}

/// The nested objects, without references.
fn inside(object: &Object) -> impl Iterator<Item = &Arc<Object>> {
    object.children.iter().filter_map(|child| match child {
        Child::Object(object) => Some(object),
        Child::Reference { .. } => None,
    })
}

/// The order of all objects, and of the first instance of each crowd, counted in the order of the file.
fn places(document: &Document) -> (HashMap<usize, Place<'_>>, Vec<u32>) {
    let mut places = HashMap::new();
    let mut crowd_orders = Vec::new();
    let mut order = 0;
    let mut waiting: Vec<&Arc<Object>> = Vec::new();
    let mut crowds = document.crowds.iter().peekable();
    for (position, child) in document.root.children.iter().enumerate() {
        while let Some(crowd) = crowds.next_if(|crowd| crowd.position <= position) {
            crowd_orders.push(order);
            order += crowd.places.len() as u32;
        }
        let Child::Object(top) = child else { continue };
        waiting.push(top);
        while let Some(object) = waiting.pop() {
            let place = Place {
                object,
                order,
                top_level: std::ptr::eq(object, top),
            };
            places.insert(address(object), place);
            order += 1;
            let first = waiting.len();
            waiting.extend(inside(object));
            waiting[first..].reverse();
        }
    }
    for crowd in crowds {
        crowd_orders.push(order);
        order += crowd.places.len() as u32;
    }
    (places, crowd_orders)
}

impl<'a> SceneReader<'a> {
    pub fn new(document: &'a Document, diagnostics: Diagnostics, keeps_source: bool) -> Self {
        let sources: Vec<PathBuf> = diagnostics.sources.iter().map(|file| settle(&file.path)).collect();
        let path = settle(&document.path);
        let folder = path.parent().unwrap_or(Path::new("/")).to_owned();
        let (places, crowd_orders) = places(document);
        let meshes = MeshSearch::new(&folder, &document.search_folders).within(document.access.clone());
        Self {
            keeps_source,
            root: &document.root,
            index: document.index(),
            pictures: PictureSearch {
                folders: meshes.clone(),
                places: HashMap::new(),
                volume_places: HashMap::new(),
                grids: HashMap::new(),
                missing: MissingFiles::new(),
            },
            meshes,
            search_folders: &document.search_folders,
            diagnostics,
            places,
            medium_of: HashMap::new(),
            material_of: HashMap::new(),
            group_of: HashMap::new(),
            crowds: &document.crowds,
            crowd_orders,
            crowds_read: 0,
            animated: animated_objects(&document.root),
            description: SceneDescription {
                path,
                sources,
                time: document.time,
                ..Default::default()
            },
            folder,
        }
    }

    pub fn reader<'d>(&'d mut self, object: &'a Object) -> Reader<'a, 'd> {
        Reader::new(&self.index, object, &mut self.diagnostics)
    }

    pub fn order(&self, object: &Object) -> u32 {
        self.places.get(&address(object)).map_or(0, |place| place.order)
    }

    /// The shared pointer of the document to this object.
    pub fn shared(&self, object: &Object) -> Arc<Object> {
        let place = self.places.get(&address(object));
        place.map_or_else(|| Arc::new(object.clone()), |place| place.object.clone())
    }

    pub fn is_top_level(&self, object: &Object) -> bool {
        self.places.get(&address(object)).is_some_and(|place| place.top_level)
    }

    /// The identity of an object of any kind. `as_read` makes the plugin that would be written for it into a
    /// file of a folder, without its properties.
    pub fn identity(&mut self, object: &Object, as_read: impl FnOnce(&Path) -> Object) -> Identity {
        let properties = Properties::of(object, &mut self.diagnostics);
        // Messages about files need the spans of the names.
        let names_file = || object.properties.iter().any(|property| property.name == "filename");
        Identity {
            id: object.id.as_ref().map(SmolStr::to_string),
            name: match &object.id {
                Some(id) => Cow::Owned(id.to_string()),
                None => name_of_plugin(&object.plugin),
            },
            order: self.order(object),
            span: object.span,
            authored: (self.keeps_source || names_file()).then(|| {
                let as_read = with_properties(as_read(&self.folder), properties.as_ref());
                self.authored(object, as_read)
            }),
            angles: angles_of(object),
            keys: self.keys(object),
            properties,
        }
    }

    /// The tracks of an object; None if it has none.
    pub fn keys(&self, object: &Object) -> Option<Keys> {
        let moves = !self.animated.is_empty();
        moves.then(|| Keys::of(object, &self.index, &self.animated)).flatten()
    }

    pub fn authored(&self, object: &Object, as_read: Object) -> Authored {
        let category = |child: &Child| match child {
            Child::Object(object) => Some(object.category),
            Child::Reference { id, .. } => self.index.get(id).map(|object| object.category),
        };
        let categories = object.children.iter().map(category).collect();
        Authored::new(self.shared(object), as_read, categories)
    }

    /// The folder to which paths in a file are relative.
    pub fn folder_of(&self, span: Span) -> PathBuf {
        let source = self.diagnostics.source(span.source);
        let parent = source.and_then(|file| settle(&file.path).parent().map(Path::to_owned));
        parent.unwrap_or_else(|| self.folder.clone())
    }
}

/// The angles in the transform of a thing. A camera has none, since it is written as a look-at.
pub fn angles_of(object: &Object) -> Option<EulerAngles> {
    let mut properties = object.properties.iter();
    match &properties.find(|property| property.name == "to_world")?.value {
        Value::Transform(steps) if object.category != Category::Sensor => EulerAngles::of_steps(steps),
        _ => None,
    }
}

/// A plugin's name, without an allocation for known ones.
fn name_of_plugin(plugin: &str) -> Cow<'static, str> {
    let mut known = ShapeKind::PLUGINS.into_iter().chain(Material::PLUGINS);
    let known = known.find(|known| *known == plugin);
    known.map_or_else(|| Cow::Owned(plugin.to_owned()), Cow::Borrowed)
}
