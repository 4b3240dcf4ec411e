//! Fills the inspector's part of the panels' model from the selection.

use bevy::prelude::*;

use super::gather::{Naming, shape_kind};
use super::mixed::Mixed;
use super::{EditorModel, Inspected, InspectedMaterial, InspectedMesh, MaterialPlace};
use crate::app::editor::command::selection::Selection;
use crate::scene::{
    AreaLight, Emitter, EmitterKind, Film, FirstNested, Material, MaterialUsers, MeshHandle, Placements, SecondNested,
    Sensor, Shape, ShapeKind, ToWorld, TriangleMesh, UsesMaterial,
};

type Parts = (
    Naming,
    Option<&'static ToWorld>,
    Option<&'static Shape>,
    Option<&'static MeshHandle>,
    Option<&'static AreaLight>,
    Option<&'static Emitter>,
    Option<&'static Sensor>,
    Option<&'static Film>,
    Option<&'static UsesMaterial>,
    Has<Placements>,
);

/// Things have one of these; an entity that was deleted has none.
type IsThing = Or<(With<Shape>, With<Material>, With<Emitter>, With<Sensor>)>;

type MaterialParts = (
    Naming,
    &'static Material,
    Option<&'static MaterialUsers>,
    Option<&'static FirstNested>,
    Option<&'static SecondNested>,
);

/// The depth to which two-sided materials are followed; the format needs one.
const DEEPEST_NESTING: usize = 4;

pub fn gather_selection(
    mut model: ResMut<EditorModel>,
    mut selection: ResMut<Selection>,
    parts: Query<Parts, IsThing>,
    materials: Query<MaterialParts>,
    meshes: Res<Assets<TriangleMesh>>,
) {
    // A reload may have taken things away.
    if selection.entities().iter().any(|entity| !parts.contains(*entity)) {
        selection.retain(|entity| parts.contains(*entity));
    }
    let inspected = |entity: Entity| inspect(entity, &parts, &materials, &meshes);
    model.0.inspected = selection.active().and_then(inspected).map(|shown| {
        let others = selection.entities().iter().filter(|other| **other != shown.entity);
        let others: Vec<Inspected> = others
            .take(MOST_COMPARED)
            .filter_map(|other| inspected(*other))
            .collect();
        shown.compared(&others)
    });
    model.0.selection = selection.clone();
}

/// The most things of a selection that are compared.
const MOST_COMPARED: usize = 256;

fn inspect(
    entity: Entity,
    parts: &Query<Parts, IsThing>,
    materials: &Query<MaterialParts>,
    meshes: &Assets<TriangleMesh>,
) -> Option<Inspected> {
    let (naming, to_world, shape, mesh, area_light, emitter, sensor, film, uses, is_crowd) = parts.get(entity).ok()?;
    let is_material = materials.contains(entity);
    if shape.is_none() && emitter.is_none() && sensor.is_none() && !is_material {
        return None;
    }
    let kind = match (shape, emitter, sensor) {
        (Some(shape), ..) => shape_kind(shape),
        (_, Some(emitter), _) => emitter.info().label,
        (_, _, Some(_)) => "camera",
        _ => "material",
    };
    // A constant environment is everywhere, so that its transform means nothing. That of very many instances is not shown.
    let has_place = !is_crowd && emitter.is_none_or(|emitter| !matches!(emitter.kind, EmitterKind::Constant { .. }));
    let mut inspected = Inspected {
        to_world: to_world.filter(|_| has_place).map(|to_world| to_world.0),
        shape: shape.cloned(),
        mesh: shape.and_then(|shape| inspect_mesh(shape, meshes.get(&mesh?.0)?)),
        area_light: area_light.cloned(),
        emitter: emitter.cloned(),
        sensor: sensor.copied(),
        film: film.copied(),
        uses_material: uses.map(|uses| uses.0),
        ..Inspected::new(entity, naming.name(kind))
    };
    let first = if is_material {
        Some(entity)
    } else {
        inspected.uses_material
    };
    if let Some(first) = first {
        collect_materials(
            first,
            MaterialPlace::Whole,
            Vec::new(),
            materials,
            &mut inspected.materials,
        );
    }
    Some(inspected)
}

fn inspect_mesh(shape: &Shape, mesh: &TriangleMesh) -> Option<InspectedMesh> {
    let ShapeKind::Mesh(file) = &shape.kind else {
        return None;
    };
    mesh.data(file.shape_index).map(|data| InspectedMesh {
        triangles: data.triangles.len(),
        has_materials: !data.materials.is_empty(),
    })
}

fn collect_materials(
    entity: Entity,
    place: MaterialPlace,
    path: Vec<usize>,
    materials: &Query<MaterialParts>,
    found: &mut Vec<InspectedMaterial>,
) {
    let Ok((naming, material, users, first, second)) = materials.get(entity) else {
        return;
    };
    let nested = [first.map(|first| first.0), second.map(|second| second.0)];
    found.push(InspectedMaterial {
        entity,
        name: naming.name(material.info().label),
        material: material.clone(),
        place,
        path: path.clone(),
        mixed: Mixed::default(),
        users: users.map_or(0, |users| users.iter().count()),
        inside: nested.into_iter().flatten().collect(),
    });
    if path.len() == DEEPEST_NESTING {
        return;
    }
    let places = match material {
        Material::TwoSided => [MaterialPlace::Front, MaterialPlace::Back],
        Material::Blend { .. } => [MaterialPlace::First, MaterialPlace::Second],
        _ => [MaterialPlace::Inside; 2],
    };
    let inside = nested
        .into_iter()
        .zip(places)
        .filter_map(|(inner, place)| Some((inner?, place)));
    for (step, (inner, place)) in inside.enumerate() {
        let path = path.iter().copied().chain([step]).collect();
        collect_materials(inner, place, path, materials, found);
    }
}
