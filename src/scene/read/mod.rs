//! From a document to a [`SceneDescription`]: which plugins and parameters exist, their defaults and their ranges.
//!
//! No ECS and no rendering; of the disk only whether mesh files exist. Defaults are those of Mitsuba 3.6 to 3.9. What a file asks for
//! that is not supported gets a stand-in and a warning with its place; what cannot be is an error, and the description is then only good
//! for finding more errors. Reading never stops early.

mod bsdfs;
mod emitters;
mod groups;
mod integrator;
pub mod ior_names;
pub mod mesh_search;
mod parameters;
pub use parameters::frame_along;
mod sensors;
mod shapes;
pub mod spectra;
mod textures;

use std::borrow::Cow;
use std::collections::HashMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use smol_str::SmolStr;

use self::mesh_search::MeshSearch;
use self::textures::PictureSearch;
use super::description::{DeclarationPlace, Identity, SceneDescription};
use super::{Authored, AuthoredScene, Material};
pub use crate::document::paths::settle;
use crate::document::{Category, Child, Crowd, Diagnostics, Document, Index, Object, Reader, Severity, Span};

/// Everything the document says; its diagnostics grow by what is wrong with it.
pub fn read(document: &mut Document) -> SceneDescription {
    let mut origin = document.clone();
    origin.diagnostics = Diagnostics::default();
    origin.diagnostics.sources.clone_from(&document.diagnostics.sources);
    let mut description = read_as(document, true);
    description.remains.origin = Some(Arc::new(origin));
    description
}

/// As [`read`], for a scene that is not written again: what the file said is not kept, but for the places of file names.
pub fn read_meaning(document: &mut Document) -> SceneDescription {
    read_as(document, false)
}

fn read_as(document: &mut Document, keeps_source: bool) -> SceneDescription {
    let diagnostics = std::mem::take(&mut document.diagnostics);
    let mut scene = SceneReader::new(document, diagnostics, keeps_source);
    scene.read_root();
    let SceneReader {
        mut description,
        diagnostics,
        pictures,
        ..
    } = scene;
    description.picture_places = pictures.places;
    sort_materials(&mut description);
    document.diagnostics = diagnostics;
    description
}

/// An object's place among all objects of the document.
struct Place<'a> {
    object: &'a Arc<Object>,
    order: u32,
    top_level: bool,
}

/// The description while it grows.
struct SceneReader<'a> {
    /// Whether things keep what the file said of them.
    keeps_source: bool,
    root: &'a Object,
    search_folders: &'a [PathBuf],
    index: Index<'a>,
    diagnostics: Diagnostics,
    meshes: MeshSearch,
    pictures: PictureSearch,
    folder: PathBuf,
    places: HashMap<usize, Place<'a>>,
    material_of: HashMap<usize, usize>,
    group_of: HashMap<usize, usize>,
    crowds: &'a [Crowd],
    /// Per crowd, the place of its first instance among all objects.
    crowd_orders: Vec<u32>,
    /// So many crowds have become shapes.
    crowds_read: usize,
    description: SceneDescription,
}

/// Objects are told apart by where they are; the document does not move while it is read.
fn address(object: &Object) -> usize {
    std::ptr::from_ref(object).addr()
}

/// The objects given in place.
fn inside(object: &Object) -> impl Iterator<Item = &Arc<Object>> {
    object.children.iter().filter_map(|child| match child {
        Child::Object(object) => Some(object),
        Child::Reference { .. } => None,
    })
}

/// The places of all objects, and of the first instance of each crowd: they are counted through in the order of the file.
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
    fn new(document: &'a Document, diagnostics: Diagnostics, keeps_source: bool) -> Self {
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
            },
            meshes,
            search_folders: &document.search_folders,
            diagnostics,
            places,
            material_of: HashMap::new(),
            group_of: HashMap::new(),
            crowds: &document.crowds,
            crowd_orders,
            crowds_read: 0,
            description: SceneDescription {
                path,
                sources,
                ..Default::default()
            },
            folder,
        }
    }

    fn read_root(&mut self) {
        let root = self.root;
        let mut remains = AuthoredScene {
            search_folders: self.search_folders.to_vec(),
            properties: root.properties.clone(),
            ..Default::default()
        };
        self.list_groups();
        let mut last_order = 0;
        for (position, child) in root.children.iter().enumerate() {
            last_order = self.read_crowds(position).unwrap_or(last_order);
            let Child::Object(object) = child else {
                remains.rest.push((last_order, child.clone()));
                continue;
            };
            last_order = self.order(object);
            let taken = match object.category {
                Category::Integrator => self.read_integrator(object, &mut remains),
                Category::Sensor => self.read_sensor(object),
                Category::Bsdf => {
                    self.read_bsdf(object, DeclarationPlace::TopLevel, 0);
                    true
                }
                Category::Shape => self.read_shape(object, None),
                Category::Emitter => self.read_emitter(object),
                // Of use only to those who refer to them, and reported there.
                _ => false,
            };
            if !taken {
                remains.rest.push((last_order, child.clone()));
            }
        }
        self.read_crowds(usize::MAX);
        self.description.remains = remains;

        let mut reader = Reader::new(&self.index, root, &mut self.diagnostics);
        for category in Category::ALL {
            reader.children(category);
        }
        reader.finish();
        // After an error the scene is not shown, and its sensor may be what could not be read.
        if self.description.sensors.is_empty() && !self.diagnostics.has_errors() {
            let message = "the scene has no sensor: one that sees everything takes its place".to_owned();
            self.diagnostics.push(Severity::Warning, Some(root.span), message, None);
        }
    }

    fn reader<'d>(&'d mut self, object: &'a Object) -> Reader<'a, 'd> {
        Reader::new(&self.index, object, &mut self.diagnostics)
    }

    fn order(&self, object: &Object) -> u32 {
        self.places.get(&address(object)).map_or(0, |place| place.order)
    }

    /// The same object as the document holds it.
    fn shared(&self, object: &Object) -> Arc<Object> {
        let place = self.places.get(&address(object));
        place.map_or_else(|| Arc::new(object.clone()), |place| place.object.clone())
    }

    fn is_top_level(&self, object: &Object) -> bool {
        self.places.get(&address(object)).is_some_and(|place| place.top_level)
    }

    /// What an object brings along whatever it is. `as_read` is what would be written for it.
    fn identity(&self, object: &Object, as_read: impl FnOnce() -> Object) -> Identity {
        // Messages about files name the places of their names.
        let names_file = || object.properties.iter().any(|property| property.name == "filename");
        Identity {
            id: object.id.as_ref().map(SmolStr::to_string),
            name: match &object.id {
                Some(id) => Cow::Owned(id.to_string()),
                None => name_of_plugin(&object.plugin),
            },
            order: self.order(object),
            span: object.span,
            authored: (self.keeps_source || names_file()).then(|| self.authored(object, as_read())),
        }
    }

    fn authored(&self, object: &Object, as_read: Object) -> Authored {
        let category = |child: &Child| match child {
            Child::Object(object) => Some(object.category),
            Child::Reference { id, .. } => self.index.get(id).map(|object| object.category),
        };
        let categories = object.children.iter().map(category).collect();
        Authored::new(self.shared(object), as_read, categories)
    }

    /// The folder a path in a file is relative to.
    fn folder_of(&self, span: Span) -> PathBuf {
        let source = self.diagnostics.source(span.source);
        let parent = source.and_then(|file| settle(&file.path).parent().map(Path::to_owned));
        parent.unwrap_or_else(|| self.folder.clone())
    }
}

/// A plugin's name without an allocation if it is known.
fn name_of_plugin(plugin: &str) -> Cow<'static, str> {
    let mut known = shapes::SHAPES.into_iter().chain(Material::PLUGINS);
    let known = known.find(|known| *known == plugin);
    known.map_or_else(|| Cow::Owned(plugin.to_owned()), Cow::Borrowed)
}

/// Materials are found in the order they are referred to; the description has them in the order of the file.
fn sort_materials(description: &mut SceneDescription) {
    let materials = std::mem::take(&mut description.materials);
    let mut by_order: Vec<usize> = (0..materials.len()).collect();
    by_order.sort_by_key(|&old| materials[old].identity.order);
    let mut new_place = vec![0; materials.len()];
    for (new, &old) in by_order.iter().enumerate() {
        new_place[old] = new;
    }
    let mut slots: Vec<_> = materials.into_iter().map(Some).collect();
    for &old in &by_order {
        if let Some(mut material) = slots[old].take() {
            material.first = material.first.map(|old| new_place[old]);
            material.second = material.second.map(|old| new_place[old]);
            if let DeclarationPlace::Material(old) = material.declared_in {
                material.declared_in = DeclarationPlace::Material(new_place[old]);
            }
            description.materials.push(material);
        }
    }
    for shape in &mut description.shapes {
        shape.material = shape.material.map(|old| new_place[old]);
    }
}
