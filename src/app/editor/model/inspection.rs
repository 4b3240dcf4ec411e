//! Fills the inspector's part of the panels' model from the selection.

use std::sync::Arc;

use bevy::ecs::query::ROQueryItem;
use bevy::prelude::*;

use super::gather::{Naming, shape_kind};
use super::inspected_media::Media;
use super::mixed::Mixed;
use super::{EditorModel, Inspected, InspectedMaterial, InspectedMesh, MaterialPlace};
use crate::app::editor::command::media::MediumSide;
use crate::app::editor::command::selection::Selection;
use crate::app::editor::session::view_settings::ViewSettings;
use crate::scene::{
    AreaLight, Emitter, EmitterKind, EulerAngles, ExteriorMedium, Film, FirstNested, InMedium, InteriorMedium,
    Material, MaterialUsers, Medium, MeshHandle, Placements, Properties, SecondNested, Sensor, Shape, ShapeKind,
    ToWorld, TriangleMesh, UsesMaterial,
};

type Parts = (
    Naming,
    (Option<&'static ToWorld>, Option<&'static EulerAngles>),
    Option<&'static Shape>,
    Option<&'static MeshHandle>,
    Option<&'static AreaLight>,
    Option<&'static Emitter>,
    Option<&'static Sensor>,
    Option<&'static Film>,
    Option<&'static UsesMaterial>,
    Has<Placements>,
    MediaParts,
    Option<&'static Properties>,
);

/// The media that a thing refers to.
type MediaParts = (
    Option<&'static InteriorMedium>,
    Option<&'static ExteriorMedium>,
    Option<&'static InMedium>,
);

/// Each thing has one of these components; a deleted entity has none.
type IsThing = Or<(With<Shape>, With<Material>, With<Medium>, With<Emitter>, With<Sensor>)>;

type MaterialParts = (
    Naming,
    &'static Material,
    Option<&'static MaterialUsers>,
    Option<&'static FirstNested>,
    Option<&'static SecondNested>,
);

type MaterialItem<'w, 's> = ROQueryItem<'w, 's, MaterialParts>;

/// The depth to which nested two-sided materials are followed; the format needs one.
const DEEPEST_NESTING: usize = 4;

pub fn gather_selection(
    mut model: ResMut<EditorModel>,
    mut selection: ResMut<Selection>,
    parts: Query<Parts, IsThing>,
    materials: Query<MaterialParts>,
    media: Media,
    meshes: Res<Assets<TriangleMesh>>,
    settings: Option<Res<ViewSettings>>,
) {
    let up = settings.map_or(Vec3::Y, |settings| settings.navigation.up);
    // A reload may have removed selected things.
    if selection.entities().iter().any(|entity| !parts.contains(*entity)) {
        selection.retain(|entity| parts.contains(*entity));
    }
    let inspected = |entity: Entity| inspect(entity, up, &parts, &materials, &meshes, &media);
    let before = model.0.inspected.take();
    let (before, media_before) = before.map_or_else(Default::default, |before| (before.materials, before.media));
    model.0.inspected = selection.active().and_then(inspected).map(|mut shown| {
        shown.materials = inspected_materials(&shown, &materials, &before);
        shown.media = media.inspected(&shown, &media_before);
        shown.leak = shown.media_at[MediumSide::Interior as usize].and_then(|_| media.leak(shown.entity));
        let others = selection.entities().iter().filter(|other| **other != shown.entity);
        let mut others: Vec<Inspected> = others
            .take(MOST_COMPARED)
            .filter_map(|other| inspected(*other))
            .collect();
        let is_group = shown.shape.as_ref().is_some_and(Shape::is_frame);
        let are_all_known = others.len() + 1 == selection.entities().len();
        if is_group && are_all_known && others.iter().all(|other| other.name.starts_with(&shown.name)) {
            shown.members = Some(others.len());
            others.clear();
        }
        let materials: Vec<_> = others.iter().map(|other| placed_materials(other, &materials)).collect();
        media.compare(shown.compared(&others, &materials), &others)
    });
    model.0.selection = selection.clone();
}

/// The most things of a selection that are compared.
const MOST_COMPARED: usize = 256;

fn inspect(
    entity: Entity,
    up: Vec3,
    parts: &Query<Parts, IsThing>,
    materials: &Query<MaterialParts>,
    meshes: &Assets<TriangleMesh>,
    media: &Media,
) -> Option<Inspected> {
    let (naming, (to_world, angles), shape, mesh, area_light, emitter, sensor, film, uses, is_crowd, sides, properties) =
        parts.get(entity).ok()?;
    let is_material = materials.contains(entity);
    if shape.is_none() && emitter.is_none() && sensor.is_none() && !is_material && !media.contains(entity) {
        return None;
    }
    let kind = match (shape, emitter, sensor) {
        (Some(shape), ..) => shape_kind(shape),
        (_, Some(emitter), _) => emitter.info().label,
        (_, _, Some(_)) => "camera",
        _ if is_material => "material",
        _ => "medium",
    };
    // A constant environment has no transform. The transform of packed instances is not shown.
    let has_place = !is_crowd && emitter.is_none_or(|emitter| !matches!(emitter.kind, EmitterKind::Constant { .. }));
    Some(Inspected {
        to_world: to_world.filter(|_| has_place).map(|to_world| to_world.0),
        angles: angles.copied(),
        rest: shape.map_or(Vec3::ZERO, |shape| shape.rest_angles(up)),
        shape: shape.cloned(),
        mesh: shape.and_then(|shape| inspect_mesh(shape, meshes.get(&mesh?.0)?)),
        area_light: area_light.cloned(),
        emitter: emitter.cloned(),
        sensor: sensor.copied(),
        film: film.copied(),
        uses_material: uses.map(|uses| uses.0),
        properties: (!is_crowd).then(|| properties.cloned().unwrap_or_default()),
        media_at: [
            sides.0.map(|medium| medium.0),
            sides.1.map(|medium| medium.0),
            sides.2.map(|medium| medium.0),
        ],
        ..Inspected::new(entity, naming.name(kind))
    })
}

fn inspect_mesh(shape: &Shape, mesh: &TriangleMesh) -> Option<InspectedMesh> {
    let ShapeKind::Mesh(file) = &shape.kind else {
        return None;
    };
    mesh.data(file.shape_index).map(|data| InspectedMesh {
        triangles: data.triangles.len(),
        curves: [data.strands.firsts.len(), data.strands.points.len()],
        has_materials: !data.materials.is_empty(),
    })
}

/// The shown materials of a thing: the thing itself if it is a material, or else the material that it uses, with nested
/// ones. Unchanged materials are shared with the last frame's list.
fn inspected_materials(
    thing: &Inspected,
    materials: &Query<MaterialParts>,
    before: &[InspectedMaterial],
) -> Vec<InspectedMaterial> {
    let shared = |entity, material: &Material| {
        let known = before.iter().find(|known| known.entity == entity);
        let unchanged = known.filter(|known| *known.material == *material);
        unchanged.map_or_else(|| Arc::new(material.clone()), |known| known.material.clone())
    };
    let mut found = Vec::new();
    let mut meet = |path, place, (naming, material, users, first, second): MaterialItem| {
        found.push(InspectedMaterial {
            entity: naming.entity,
            name: naming.name(material.info().label),
            material: shared(naming.entity, material),
            place,
            path,
            mixed: Mixed::default(),
            users: users.map_or(0, |users| users.iter().count()),
            inside: nested(first, second).into_iter().flatten().collect(),
        });
    };
    for_each_material(
        outermost(thing, materials),
        MaterialPlace::Whole,
        Vec::new(),
        materials,
        &mut meet,
    );
    found
}

/// The same materials by their paths, for the comparison.
fn placed_materials<'q>(thing: &Inspected, materials: &'q Query<MaterialParts>) -> Vec<(Vec<usize>, &'q Material)> {
    let mut found = Vec::new();
    let mut meet = |path, _, (_, material, ..): MaterialItem<'q, '_>| found.push((path, material));
    for_each_material(
        outermost(thing, materials),
        MaterialPlace::Whole,
        Vec::new(),
        materials,
        &mut meet,
    );
    found
}

fn outermost(thing: &Inspected, materials: &Query<MaterialParts>) -> Option<Entity> {
    let is_material = materials.contains(thing.entity);
    if is_material {
        Some(thing.entity)
    } else {
        thing.uses_material
    }
}

fn nested(first: Option<&FirstNested>, second: Option<&SecondNested>) -> [Option<Entity>; 2] {
    [first.map(|first| first.0), second.map(|second| second.0)]
}

fn for_each_material<'q, 's>(
    entity: Option<Entity>,
    place: MaterialPlace,
    path: Vec<usize>,
    materials: &'q Query<'_, 's, MaterialParts>,
    meet: &mut impl FnMut(Vec<usize>, MaterialPlace, MaterialItem<'q, 's>),
) {
    let Some(parts) = entity.and_then(|entity| materials.get(entity).ok()) else {
        return;
    };
    let (_, material, _, first, second) = &parts;
    let places = match material {
        Material::TwoSided => [MaterialPlace::Front, MaterialPlace::Back],
        Material::Blend { .. } => [MaterialPlace::First, MaterialPlace::Second],
        _ => [MaterialPlace::Inside; 2],
    };
    let inside = nested(*first, *second)
        .into_iter()
        .zip(places)
        .filter(|(inner, _)| inner.is_some());
    meet(path.clone(), place, parts);
    if path.len() == DEEPEST_NESTING {
        return;
    }
    for (step, (inner, place)) in inside.enumerate() {
        let path = path.iter().copied().chain([step]).collect();
        for_each_material(inner, place, path, materials, meet);
    }
}

#[cfg(test)]
mod tests {
    use bevy::ecs::system::RunSystemOnce;

    use super::*;
    use crate::app::editor::model::leaks::Leaks;

    #[test]
    fn a_material_is_copied_only_when_it_has_changed() {
        let mut world = World::new();
        world.init_resource::<EditorModel>();
        world.init_resource::<Assets<TriangleMesh>>();
        world.init_resource::<Leaks>();
        let entity = world.spawn(Material::default()).id();
        world.insert_resource(Selection::of([entity]));
        let shown = |world: &mut World| {
            world.run_system_once(gather_selection).expect("it has all it needs");
            let inspected = world.resource::<EditorModel>().0.inspected.as_ref();
            inspected.expect("it is selected").materials[0].material.clone()
        };
        let first = shown(&mut world);
        // Writing the same value marks it as changed for the ECS.
        world.entity_mut(entity).insert(Material::default());
        assert!(Arc::ptr_eq(&first, &shown(&mut world)));
        world.entity_mut(entity).insert(Material::Null);
        assert_eq!(*shown(&mut world), Material::Null);
    }
}
