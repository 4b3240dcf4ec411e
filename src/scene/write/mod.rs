//! From a [`SceneDescription`] back to a document; [`gather`] makes the description from the entities.
//!
//! What nobody edited is written as it was read, parameters that were not understood included. Materials stay where they were declared:
//! in place, or at the top level and referred to.

pub mod gather;
pub mod objects;
mod patch;

use std::collections::HashSet;
use std::path::{Path, PathBuf};

use bevy::prelude::World;

use self::patch::Draft;
use super::description::{DeclarationPlace, Identity, SceneDescription};
use super::read::settle;
use super::{Authored, IntegratorSettings};
use crate::document::{self, Category, Child, Document, Object, Span, Value};

/// Materials inside materials; deeper ones are written at the top level instead. More than reading allows.
const DEEPEST: usize = 40;

#[derive(Debug, thiserror::Error)]
pub enum SaveError {
    #[error(transparent)]
    Write(#[from] document::WriteError),
    #[error("{}: {source}", path.display())]
    File { path: PathBuf, source: std::io::Error },
}

/// Writes the entities as a scene file, replacing it in one step.
pub fn save(world: &mut World, path: &Path) -> Result<(), SaveError> {
    save_description(&gather::describe(world), path)
}

/// Writes a scene file, replacing it in one step.
pub fn save_description(scene: &SceneDescription, path: &Path) -> Result<(), SaveError> {
    let text = document::to_xml(&to_document(scene, path))?;
    document::write_atomically(path, &text).map_err(|source| SaveError::File {
        path: path.to_owned(),
        source,
    })
}

/// The document of a scene that will be written to `target`; file names in it are relative to that.
pub fn to_document(scene: &SceneDescription, target: &Path) -> Document {
    let target = settle(target);
    let folder = target.parent().unwrap_or(Path::new("/")).to_owned();
    let writer = Writer::new(scene, &folder);
    let mut root = writer.root();
    if let Some(old_folder) = scene.path.parent()
        && old_folder != folder
    {
        move_file_names(&mut root, old_folder, &folder);
    }
    Document {
        search_folders: scene.remains.search_folders.clone(),
        ..Document::new(target, root)
    }
}

struct Writer<'s> {
    scene: &'s SceneDescription,
    folder: &'s Path,
    /// Per material: its id in the file, if it has one or is referred to.
    ids: Vec<Option<String>>,
    /// Per material: where it is written; None for those that nobody needs any more.
    places: Vec<Option<DeclarationPlace>>,
}

impl<'s> Writer<'s> {
    fn new(scene: &'s SceneDescription, folder: &'s Path) -> Self {
        let count = scene.materials.len();
        let mut writer = Self {
            scene,
            folder,
            ids: scene
                .materials
                .iter()
                .map(|material| material.identity.id.clone())
                .collect(),
            places: vec![None; count],
        };
        // Who uses what, in the order in which it is written.
        let mut uses: Vec<(DeclarationPlace, usize)> = Vec::new();
        for (owner, shape) in scene.shapes.iter().enumerate() {
            uses.extend(
                shape
                    .material
                    .map(|material| (DeclarationPlace::Shape(owner), material)),
            );
        }
        for (owner, material) in scene.materials.iter().enumerate() {
            let nested = material.first.into_iter().chain(material.second);
            uses.extend(nested.map(|inner| (DeclarationPlace::Material(owner), inner)));
        }
        let mut is_used = vec![false; count];
        for &(owner, material) in &uses {
            is_used[material] = true;
            if scene.materials[material].declared_in == owner && writer.depth(material) < DEEPEST {
                writer.places[material] = Some(owner);
            }
        }
        for (index, material) in scene.materials.iter().enumerate() {
            let was_top_level = material.declared_in == DeclarationPlace::TopLevel;
            if writer.places[index].is_none() && (was_top_level || is_used[index] || material.identity.id.is_some()) {
                writer.places[index] = Some(DeclarationPlace::TopLevel);
            }
        }
        writer.name_what_is_referred_to(&uses);
        writer
    }

    /// How many materials this one is declared inside of.
    fn depth(&self, mut material: usize) -> usize {
        let mut depth = 0;
        while let DeclarationPlace::Material(owner) = self.scene.materials[material].declared_in
            && depth < DEEPEST
        {
            material = owner;
            depth += 1;
        }
        depth
    }

    /// The first use by the owner is the declaration; every other use needs an id to refer to.
    fn name_what_is_referred_to(&mut self, uses: &[(DeclarationPlace, usize)]) {
        let mut taken: HashSet<String> = HashSet::new();
        for identity in identities(self.scene) {
            taken.extend(identity.id.clone());
        }
        for (_, child) in &self.scene.remains.rest {
            collect_ids(child, &mut taken);
        }
        let mut is_declared = vec![false; self.ids.len()];
        let mut number = 0;
        for &(owner, material) in uses {
            if self.places[material] == Some(owner) && !std::mem::replace(&mut is_declared[material], true) {
                continue;
            }
            if self.ids[material].is_none() {
                loop {
                    number += 1;
                    let id = format!("material-{number}");
                    if taken.insert(id.clone()) {
                        self.ids[material] = Some(id);
                        break;
                    }
                }
            }
        }
    }

    fn root(&self) -> Object {
        let scene = self.scene;
        let mut parts: Vec<(u32, Child)> = Vec::new();
        if let Some((order, child)) = self.integrator() {
            parts.push((order, Child::Object(child)));
        }
        for sensor in &scene.sensors {
            let current = objects::sensor(&sensor.sensor, &sensor.film, &sensor.to_world);
            parts.push(self.finish(&sensor.identity, current));
        }
        for (index, material) in scene.materials.iter().enumerate() {
            if self.places[index] == Some(DeclarationPlace::TopLevel) {
                parts.push((material.identity.order, Child::Object(self.material(index))));
            }
        }
        for (index, shape) in scene.shapes.iter().enumerate() {
            let area_light = shape.area_light.as_ref();
            let current = objects::shape(&shape.shape, &shape.to_world, area_light, self.folder);
            let draft = Draft::new(shape.identity.authored.as_ref(), current);
            let mut object = draft.set_bsdfs(self.nested(DeclarationPlace::Shape(index), &[shape.material]));
            object.id.clone_from(&shape.identity.id);
            parts.push((shape.identity.order, Child::Object(object)));
        }
        for emitter in &scene.emitters {
            let current = objects::emitter(&emitter.emitter, &emitter.to_world);
            parts.push(self.finish(&emitter.identity, current));
        }
        parts.extend(scene.remains.rest.iter().cloned());
        // Stable: things without a place of their own follow what they followed.
        parts.sort_by_key(|(order, _)| *order);
        let mut root = Object::new(Category::Scene, "");
        root.properties.clone_from(&scene.remains.properties);
        root.children = parts.into_iter().map(|(_, child)| child).collect();
        root
    }

    fn integrator(&self) -> Option<(u32, Object)> {
        let settings = &self.scene.integrator;
        let current = objects::integrator(settings);
        match &self.scene.remains.integrator {
            Some((order, authored)) => Some((*order, Draft::new(Some(authored), current).object)),
            None => (current != objects::integrator(&IntegratorSettings::default())).then_some((0, current)),
        }
    }

    fn finish(&self, identity: &Identity, current: Object) -> (u32, Child) {
        let mut object = Draft::new(identity.authored.as_ref(), current).object;
        object.id.clone_from(&identity.id);
        (identity.order, Child::Object(object))
    }

    fn material(&self, index: usize) -> Object {
        let material = &self.scene.materials[index];
        let authored: Option<&Authored> = material.identity.authored.as_ref();
        let draft = Draft::new(authored, objects::material(&material.material));
        // What a stand-in stands for may have bsdfs inside that were never read; they stay.
        let is_stand_in = authored.is_some_and(|authored| authored.object.plugin != authored.as_read.plugin);
        let nested = self.nested(DeclarationPlace::Material(index), &[material.first, material.second]);
        let mut object = if is_stand_in && nested.is_empty() {
            draft.object
        } else {
            draft.set_bsdfs(nested)
        };
        object.id.clone_from(&self.ids[index]);
        object
    }

    /// The materials inside of `owner`: in place where they are declared there, or else as references.
    fn nested(&self, owner: DeclarationPlace, materials: &[Option<usize>]) -> Vec<Child> {
        let mut declared = Vec::new();
        let mut children = Vec::new();
        for &material in materials.iter().flatten() {
            if self.places[material] == Some(owner) && !declared.contains(&material) {
                declared.push(material);
                children.push(Child::Object(self.material(material)));
            } else if let Some(id) = &self.ids[material] {
                children.push(Child::Reference {
                    name: None,
                    id: id.clone(),
                    span: Span::default(),
                });
            }
        }
        children
    }
}

fn identities(scene: &SceneDescription) -> impl Iterator<Item = &Identity> {
    let sensors = scene.sensors.iter().map(|sensor| &sensor.identity);
    let materials = scene.materials.iter().map(|material| &material.identity);
    let shapes = scene.shapes.iter().map(|shape| &shape.identity);
    let emitters = scene.emitters.iter().map(|emitter| &emitter.identity);
    sensors.chain(materials).chain(shapes).chain(emitters)
}

fn collect_ids(child: &Child, ids: &mut HashSet<String>) {
    let Child::Object(object) = child else {
        return;
    };
    ids.extend(object.id.clone());
    for inner in &object.children {
        collect_ids(inner, ids);
    }
}

/// Relative file names of what was not understood, made relative to another folder.
fn move_file_names(object: &mut Object, from: &Path, to: &Path) {
    for property in &mut object.properties {
        if property.name == "filename"
            && let Value::String(name) = &mut property.value
            && Path::new(name).is_relative()
            && from.join(&*name).is_file()
            && !to.join(&*name).is_file()
        {
            *name = objects::file_name(&settle(&from.join(&*name)), to);
        }
    }
    for child in &mut object.children {
        if let Child::Object(inner) = child {
            move_file_names(inner, from, to);
        }
    }
}
