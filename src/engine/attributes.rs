//! Warnings about mesh attributes that textures name and meshes lack.

use std::collections::{BTreeSet, HashMap, HashSet};
use std::sync::Arc;

use bevy::ecs::entity::EntityHashMap;
use bevy::prelude::*;

use super::authored::Authored;
use super::pack::group::Layout;
use crate::accel::Primitive;
use crate::scene::{Parameter, ShapeKind, Texture};

/// Warns about shapes without an attribute that a texture of their material or light names. There is one message for
/// each mesh and attribute, since a mesh may have many shapes.
pub(super) fn missing_attributes(authored: &Authored, layout: &Layout) -> Vec<String> {
    let of_materials = attributes_of_materials(authored);
    let of_light = |entity: Entity| {
        let mut names = BTreeSet::new();
        let light = authored.surface_bindings.get(entity).ok().and_then(|found| found.3);
        if let Some(Parameter::Texture(texture)) = light.map(|light| &light.radiance) {
            add_attributes(texture, &mut names);
        }
        names
    };
    let mut known = HashSet::new();
    let mut messages = Vec::new();
    for record in &layout.shapes {
        let of_material = record.material.and_then(|material| of_materials.get(&material));
        let lit_by = if record.has_light {
            of_light(record.entity)
        } else {
            BTreeSet::new()
        };
        for name in of_material.into_iter().flatten().chain(&lit_by) {
            let mesh = match &record.primitive {
                Primitive::Mesh(blas) => Some(blas.mesh()),
                _ => None,
            };
            if mesh.is_some_and(|mesh| mesh.attribute(name).is_some())
                || !known.insert((mesh.map(Arc::as_ptr), name.clone()))
            {
                continue;
            }
            let Ok(shape) = authored.shapes.get(record.entity) else {
                continue;
            };
            let what = match &shape.shape.kind {
                ShapeKind::Mesh(mesh) => format!("its mesh {} has", mesh.path.display()),
                _ => "it is no mesh of a file, and has".to_owned(),
            };
            messages.push(format!(
                "{}: {what} no attribute `{name}`; 0 is taken for it, which is black",
                shape.name()
            ));
        }
    }
    messages
}

/// The attributes of each material that names some, with those of the materials inside it.
fn attributes_of_materials(authored: &Authored) -> EntityHashMap<BTreeSet<String>> {
    let mut found = EntityHashMap::default();
    let mut outer: HashMap<Entity, Vec<Entity>> = HashMap::new();
    for (entity, _, _, material, first, second) in authored.materials.iter() {
        let mut names = BTreeSet::new();
        material.for_each_texture(&mut |texture| add_attributes(texture, &mut names));
        if !names.is_empty() {
            found.insert(entity, names);
        }
        for inner in [first.map(|first| first.0), second.map(|second| second.0)]
            .into_iter()
            .flatten()
        {
            outer.entry(inner).or_default().push(entity);
        }
    }
    // Spreads from inner to outer materials until nothing changes, so that cycles of materials end.
    let mut pending: Vec<Entity> = found.keys().copied().collect();
    while let Some(inner) = pending.pop() {
        let names = found.get(&inner).cloned().unwrap_or_default();
        for &entity in outer.get(&inner).into_iter().flatten() {
            let all: &mut BTreeSet<String> = found.entry(entity).or_default();
            let before = all.len();
            all.extend(names.iter().cloned());
            if all.len() > before {
                pending.push(entity);
            }
        }
    }
    found
}

fn add_attributes(texture: &Texture, names: &mut BTreeSet<String>) {
    if let Texture::MeshAttribute { name, .. } = texture {
        names.insert(name.clone());
    }
    texture.for_each_nested(&mut |nested| add_attributes(nested, names));
}
