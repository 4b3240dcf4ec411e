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

use std::collections::HashMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use self::mesh_search::MeshSearch;
use self::textures::PictureSearch;
use super::description::{DeclarationPlace, Identity, SceneDescription};
use super::{Authored, AuthoredScene};
pub use crate::document::paths::settle;
use crate::document::{Category, Child, Diagnostics, Document, Index, Object, Reader, Severity, Span};

/// Everything the document says; its diagnostics grow by what is wrong with it.
pub fn read(document: &mut Document) -> SceneDescription {
    let diagnostics = std::mem::take(&mut document.diagnostics);
    let mut origin = document.clone();
    origin.diagnostics.sources.clone_from(&diagnostics.sources);
    let mut scene = SceneReader::new(document, diagnostics);
    scene.read_root();
    let SceneReader {
        mut description,
        diagnostics,
        pictures,
        ..
    } = scene;
    description.picture_places = pictures.places;
    description.remains.origin = Some(Arc::new(origin));
    sort_materials(&mut description);
    document.diagnostics = diagnostics;
    description
}

/// An object's place among all objects of the document.
struct Place {
    order: u32,
    top_level: bool,
}

/// The description while it grows.
struct SceneReader<'a> {
    root: &'a Object,
    search_folders: &'a [PathBuf],
    index: Index<'a>,
    diagnostics: Diagnostics,
    meshes: MeshSearch,
    pictures: PictureSearch,
    folder: PathBuf,
    places: HashMap<usize, Place>,
    material_of: HashMap<usize, usize>,
    group_of: HashMap<usize, usize>,
    description: SceneDescription,
}

/// Objects are told apart by where they are; the document does not move while it is read.
fn address(object: &Object) -> usize {
    std::ptr::from_ref(object).addr()
}

impl<'a> SceneReader<'a> {
    fn new(document: &'a Document, diagnostics: Diagnostics) -> Self {
        let sources: Vec<PathBuf> = diagnostics.sources.iter().map(|file| settle(&file.path)).collect();
        let path = settle(&document.path);
        let folder = path.parent().unwrap_or(Path::new("/")).to_owned();
        let mut places = HashMap::new();
        let mut order = 0;
        let mut waiting: Vec<(&Object, bool)> = document.root.objects().map(|object| (object, true)).collect();
        waiting.reverse();
        while let Some((object, top_level)) = waiting.pop() {
            places.insert(address(object), Place { order, top_level });
            order += 1;
            let first = waiting.len();
            waiting.extend(object.objects().map(|child| (child, false)));
            waiting[first..].reverse();
        }
        let meshes = MeshSearch::new(&folder, &document.search_folders);
        Self {
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
        let mut crowd = 0..0;
        for (place, child) in root.children.iter().enumerate() {
            if crowd.contains(&place) {
                continue;
            }
            if let Some(instances) = self.read_crowd(place) {
                crowd = instances;
                last_order = self
                    .description
                    .shapes
                    .last()
                    .map_or(last_order, |crowd| crowd.identity.order);
                continue;
            }
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
        self.description.remains = remains;

        let mut reader = Reader::new(&self.index, root, &mut self.diagnostics);
        for category in Category::ALL {
            reader.children(category);
        }
        reader.finish();
        if self.description.sensors.is_empty() {
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

    fn is_top_level(&self, object: &Object) -> bool {
        self.places.get(&address(object)).is_some_and(|place| place.top_level)
    }

    /// What an object brings along whatever it is. `as_read` is what would be written for it.
    fn identity(&self, object: &Object, as_read: Object) -> Identity {
        Identity {
            id: object.id.clone(),
            name: object.id.clone().unwrap_or_else(|| object.plugin.clone()),
            order: self.order(object),
            span: object.span,
            authored: Some(self.authored(object, as_read)),
        }
    }

    fn authored(&self, object: &Object, as_read: Object) -> Authored {
        let category = |child: &Child| match child {
            Child::Object(object) => Some(object.category),
            Child::Reference { id, .. } => self.index.get(id).map(|object| object.category),
        };
        Authored {
            object: object.clone(),
            as_read,
            child_categories: object.children.iter().map(category).collect(),
        }
    }

    /// The folder a path in a file is relative to.
    fn folder_of(&self, span: Span) -> PathBuf {
        let source = self.diagnostics.source(span.source);
        let parent = source.and_then(|file| settle(&file.path).parent().map(Path::to_owned));
        parent.unwrap_or_else(|| self.folder.clone())
    }
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
