//! The panel with all editable values of the active thing.

use std::collections::HashMap;

use bevy::math::{Affine3A, Vec3};
use bevy::prelude::Entity;
use bevy_egui::egui::{self, Ui};

use super::key_marks::{moving, take_asked};
use super::material;
use super::material_header::{material_header, presets};
use super::material_tree::{self, material_tree};
use super::medium_section::{EditedMedia, medium_rows};
use super::properties::{PropertiesState, properties_section};
use super::section::section;
use super::{
    camera_angles, dimensions, fields, lengths, light_section, look, medium_section, missing_files, sensor, solid,
    transform,
};
use crate::app::editor::command::properties::PropertyOwner;
use crate::app::editor::command::{ArrangeEdit, Command, EditCommand, MaterialEdit, ValueEdit, ViewCommand};
use crate::app::editor::model::freedom::Freedom;
use crate::app::editor::model::{Inspected, InspectedMaterial, InspectedMesh, MaterialPlace, MissingItem, Model};
use crate::math::Aabb;
use crate::scene::{EmitterKind, EulerAngles, FileKind, Material, MeshFile, Shape, ShapeKind};
use transform::PoseEdit;

/// The state that the panel keeps between frames.
#[derive(Debug, Default)]
pub struct InspectorState {
    materials: EditedMaterials,
    media: EditedMedia,
    /// The part of a nested material that was chosen in the tree.
    part: Option<Entity>,
    properties: PropertiesState,
}

/// Copies of the shown materials, for their rows to edit. Only a changed material is copied again.
#[derive(Debug, Default)]
struct EditedMaterials(HashMap<Entity, Material>);

impl EditedMaterials {
    /// The copy, which is equal to `shown`.
    fn of(&mut self, entry: &InspectedMaterial) -> &mut Material {
        let copy = self.0.entry(entry.entity).or_insert_with(|| (*entry.material).clone());
        if *copy != *entry.material {
            copy.clone_from(&entry.material);
        }
        copy
    }

    /// Drops the materials that are not shown any more.
    fn keep(&mut self, shown: &[InspectedMaterial]) {
        self.0
            .retain(|entity, _| shown.iter().any(|entry| entry.entity == *entity));
    }
}

/// Shows the parameters of the active thing. An edit applies to all selected things of the same kind. `scene_size` is
/// in world units.
pub fn inspector(ui: &mut Ui, model: &Model, scene_size: f32, state: &mut InspectorState, commands: &mut Vec<Command>) {
    fields::leave_scroll_bar(ui);
    let Some(inspected) = &model.inspected else {
        ui.add_space(8.0);
        ui.weak("Nothing is selected. Click in the picture or in the list at the left.");
        properties_section(ui, PropertyOwner::Scene, model, &mut state.properties, commands);
        return;
    };
    let mut edits = Vec::new();
    lengths::in_unit(ui, model.unit, |ui| {
        fields::compared(ui, &inspected.mixed, |ui| {
            moving(ui, &model.timeline, (inspected.entity, ""), |ui| {
                sections(ui, inspected, model, scene_size, state, &mut edits);
            });
        });
    });
    commands.extend(take_asked(ui));
    let several = others(inspected, model) > 0;
    commands.extend(edits.into_iter().map(|edit| match edit {
        Command::Edit(EditCommand::Value(value)) if several => EditCommand::OnSelection(Box::new(value)).into(),
        other => other,
    }));
}

/// The number of selected things that are edited together with the shown one.
pub(super) fn others(inspected: &Inspected, model: &Model) -> usize {
    match inspected.members {
        Some(_) => 0,
        None => model.selection.entities().len().saturating_sub(1),
    }
}

fn sections(
    ui: &mut Ui,
    inspected: &Inspected,
    model: &Model,
    scene_size: f32,
    state: &mut InspectorState,
    commands: &mut Vec<Command>,
) {
    ui.horizontal(|ui| {
        ui.add(egui::Label::new(egui::RichText::new(inspected.name.trim_end_matches('/')).heading()).truncate());
    });
    let others = others(inspected, model);
    match inspected.members {
        Some(_) => _ = ui.weak("A group. Its transform moves everything in it."),
        None if others > 0 => _ = ui.weak(format!("and {others} more. Changes every selected object.")),
        None => {}
    }
    if let Some(to_world) = inspected.pose() {
        section(ui, "Transform", |ui| {
            pose(ui, inspected, to_world, scene_size, commands);
            match (&model.extent, model.sizes.filter(|_| others > 0)) {
                (_, Some(sizes)) => {
                    let edited = dimensions::sizes(ui, &sizes);
                    commands.extend(edited.map(|(axis, size)| ArrangeEdit::Resize(axis, size).into()));
                }
                (Some(bounds), None) => size(ui, inspected, to_world, bounds, others > 0, commands),
                (None, None) => {}
            }
        });
    }
    if let Some(shape) = &inspected.shape {
        section(ui, "Shape", |ui| {
            let mut edited = shape.clone();
            if shape_rows(ui, &mut edited, inspected.mesh) {
                commands.push(ValueEdit::SetShape(inspected.entity, edited).into());
            }
            missing_mesh(ui, shape, &model.missing, commands);
        });
    }
    let has_surface = inspected.shape.as_ref().is_some_and(|shape| !shape.is_frame());
    if has_surface || !inspected.materials.is_empty() {
        section(ui, "Material", |ui| {
            material_rows(ui, inspected, model, state, commands)
        });
    }
    if medium_section::has_media(inspected) {
        section(ui, "Medium", |ui| {
            medium_rows(ui, inspected, model, &mut state.media, commands);
        });
    }
    if has_surface && !inspected.shape.as_ref().is_some_and(Shape::is_of_curves) {
        section(ui, "Emission", |ui| {
            light_section::emission_rows(ui, inspected, model, commands)
        });
    }
    if let Some(emitter) = &inspected.emitter {
        let title = if emitter.is_marker() { "Marker" } else { "Light" };
        section(ui, title, |ui| {
            light_section::light_rows(ui, inspected, emitter, model, commands)
        });
    }
    if let Some(given) = inspected.sensor {
        section(ui, "Camera", |ui| {
            let mut edited = given;
            let film = inspected.film.unwrap_or_default();
            let aspect = film.width.max(1) as f32 / film.height.max(1) as f32;
            if sensor::sensor(ui, &mut edited, aspect, scene_size) {
                commands.push(ValueEdit::SetSensor(inspected.entity, edited).into());
            }
            if fields::buttons(ui, |ui| ui.button("Look through this camera")).clicked() {
                commands.push(ViewCommand::LookThrough(inspected.entity).into());
            }
        });
    }
    if inspected.properties.is_some() {
        let owner = match inspected.members {
            Some(_) => PropertyOwner::Things(vec![inspected.entity]),
            None => PropertyOwner::Things(model.selection.entities().to_vec()),
        };
        properties_section(ui, owner, model, &mut state.properties, commands);
    }
    if let Some(given) = inspected.film {
        section(ui, "Film", |ui| {
            let mut edited = given;
            if moving(ui, &model.timeline, (inspected.entity, "film."), |ui| {
                sensor::film(ui, &mut edited)
            }) {
                commands.push(ValueEdit::SetFilm(inspected.entity, edited).into());
            }
        });
    }
}

fn pose(ui: &mut Ui, inspected: &Inspected, to_world: Affine3A, scene_size: f32, commands: &mut Vec<Command>) {
    let mut edited = to_world;
    let freedom = match (&inspected.shape, &inspected.emitter) {
        (Some(_), _) => Freedom::Affine,
        (None, Some(emitter)) if !emitter.shines() => Freedom::Affine,
        (None, Some(emitter)) if emitter.is_environment() => Freedom::Turning,
        (None, _) => Freedom::Rigid,
    };
    let spun = match &inspected.emitter {
        Some(emitter) if emitter.is_environment() => transform::turn(ui, &mut edited, up_axis(&emitter.kind)),
        _ => false,
    };
    let edit = match inspected.sensor {
        Some(_) => {
            let moved = transform::position(ui, &mut edited, scene_size);
            match camera_angles::camera_angles(ui, &mut edited) || moved {
                true => PoseEdit::Moved,
                false => PoseEdit::None,
            }
        }
        None => {
            let angles = inspected.angles.map(|angles| angles.0);
            transform::transform(ui, &mut edited, freedom, scene_size, angles, inspected.rest)
        }
    };
    if edited.is_finite() {
        commands.extend(match edit {
            PoseEdit::Turned(degrees) => Some(ValueEdit::Turn(inspected.entity, edited, EulerAngles(degrees)).into()),
            PoseEdit::None if !spun => None,
            PoseEdit::None | PoseEdit::Moved => Some(ValueEdit::Transform(vec![(inspected.entity, edited)]).into()),
        });
    }
}

/// Shows the size of the whole selection, which can be edited for a single thing.
fn size(
    ui: &mut Ui,
    inspected: &Inspected,
    mut to_world: Affine3A,
    bounds: &Aabb,
    is_one_of_several: bool,
    commands: &mut Vec<Command>,
) {
    let pose = (!is_one_of_several).then_some(&mut to_world);
    if dimensions::dimensions(ui, bounds, pose, inspected.shape.as_ref()) {
        commands.push(ValueEdit::Transform(vec![(inspected.entity, to_world)]).into());
    }
}

/// The axis of the light's own space that points up in the file format.
fn up_axis(kind: &EmitterKind) -> Vec3 {
    match kind {
        EmitterKind::SunSky(_) => Vec3::Z,
        _ => Vec3::Y,
    }
}

/// Shows the rows of a shape; returns true if edited.
fn shape_rows(ui: &mut Ui, shape: &mut Shape, mesh: Option<InspectedMesh>) -> bool {
    let mut changed = false;
    match &mut shape.kind {
        // The centre of a sphere is its position.
        ShapeKind::Sphere { radius, .. } => {
            fields::note(ui, ("Type", "kind"), "sphere");
            let speed = 0.01 * radius.abs().max(1e-3);
            changed |= lengths::length(ui, ("Radius", "radius"), radius, speed, 1e-4..=f32::MAX);
        }
        ShapeKind::Rectangle => fields::note(ui, ("Type", "kind"), "rectangle"),
        ShapeKind::Cube => fields::note(ui, ("Type", "kind"), "cube"),
        ShapeKind::Disk => fields::note(ui, ("Type", "kind"), "disk"),
        ShapeKind::Triangle { corners } => {
            fields::note(ui, ("Type", "kind"), "triangle");
            let size = corners[0].distance(corners[1]).max(corners[0].distance(corners[2]));
            for (label, corner) in ["Corner 1", "Corner 2", "Corner 3"].into_iter().zip(corners) {
                changed |= lengths::vector(ui, label, corner, 0.01 * size.max(1e-3));
            }
        }
        ShapeKind::Cylinder { p0, p1, radius } => {
            fields::note(ui, ("Type", "kind"), "cylinder");
            let speed = 0.01 * radius.abs().max(1e-3);
            changed |= lengths::vector(ui, ("From", "p0"), p0, speed);
            changed |= lengths::vector(ui, ("To", "p1"), p1, speed);
            changed |= lengths::length(ui, ("Radius", "radius"), radius, speed, 1e-4..=f32::MAX);
        }
        ShapeKind::Solid(part) => changed |= solid::rows(ui, part),
        ShapeKind::Instance => {
            fields::note(ui, ("Type", "kind"), "instance");
            return lightmap_scale(ui, shape);
        }
        ShapeKind::Frame => {
            fields::note(ui, ("Type", "kind"), "group");
            return false;
        }
        ShapeKind::Mesh(MeshFile {
            path,
            format,
            shape_index,
            face_normals,
            ..
        }) => {
            fields::note(ui, ("Type", "kind"), format.label());
            let file = path.file_name().unwrap_or_default().to_string_lossy();
            fields::note(ui, ("File", "kind.path"), file);
            if *shape_index > 0 {
                fields::note(ui, "Shape", shape_index.to_string());
            }
            if format.is_of_curves() {
                if let Some([curves, points]) = mesh.map(|mesh| mesh.curves) {
                    fields::note(ui, "Curves", curves.to_string());
                    fields::note(ui, "Control points", points.to_string());
                }
                return false;
            }
            if let Some(mesh) = mesh {
                fields::note(ui, "Triangles", mesh.triangles.to_string());
            }
            changed |= fields::checkbox(ui, ("Flat shading", "kind.face_normals"), face_normals);
        }
    }
    changed |= fields::checkbox(ui, ("Flip normals", "flip_normals"), &mut shape.flip_normals);
    lightmap_scale(ui, shape) || changed
}

/// Says that the file of a mesh is missing, and offers to find it.
fn missing_mesh(ui: &mut Ui, shape: &Shape, missing: &[MissingItem], commands: &mut Vec<Command>) {
    let ShapeKind::Mesh(mesh) = &shape.kind else { return };
    let is_it = |item: &&MissingItem| item.kind == FileKind::Mesh && item.path == mesh.path;
    if let Some(item) = missing.iter().find(is_it) {
        ui.colored_label(
            ui.visuals().warn_fg_color,
            "The file is missing: a box stands in place of the mesh.",
        );
        fields::buttons(ui, |ui| missing_files::find_button(ui, item, true, commands));
    }
}

fn lightmap_scale(ui: &mut Ui, shape: &mut Shape) -> bool {
    let caption = ("Lightmap scale", "lightmap_scale");
    fields::number(ui, caption, &mut shape.lightmap_scale, 0.01, Shape::LIGHTMAP_SCALES)
}

/// The text about a shape without a material of the scene.
fn without_material(inspected: &Inspected) -> &'static str {
    match inspected.mesh {
        Some(mesh) if mesh.has_materials => "from the mesh file",
        // A light without a material reflects nothing.
        _ if inspected.area_light.is_some() => "none (black)",
        _ => "none (grey)",
    }
}

/// The selected shapes, or the one that is inspected.
fn several_or(inspected: Entity, model: &Model) -> Vec<Entity> {
    let selected = model.selected_shapes();
    match selected.contains(&inspected) {
        true => selected,
        false => vec![inspected],
    }
}

fn material_rows(
    ui: &mut Ui,
    inspected: &Inspected,
    model: &Model,
    state: &mut InspectorState,
    commands: &mut Vec<Command>,
) {
    if inspected.shape.is_some() {
        let mut used = inspected.uses_material;
        let mut options: Vec<(Option<_>, &str)> = vec![(None, without_material(inspected))];
        options.extend(
            model
                .outline
                .materials
                .iter()
                .map(|item| (Some(item.entity), item.name.as_str())),
        );
        if fields::choice(ui, ("Made of", "uses_material"), &mut used, &options) {
            commands.push(
                MaterialEdit::UseMaterial {
                    shapes: several_or(inspected.entity, model),
                    material: used,
                }
                .into(),
            );
        }
        fields::buttons(ui, |ui| {
            // A shape without a material needs one next, so that the button is the primary one.
            let text = "New material";
            let button = look::primary_if(ui, inspected.materials.is_empty(), text);
            if ui.add(button).clicked() {
                commands.push(
                    MaterialEdit::GiveMaterial {
                        shape: inspected.entity,
                    }
                    .into(),
                );
            }
            if inspected.materials.is_empty() {
                presets(ui, inspected.entity, MaterialPlace::Whole, model, commands);
            }
        });
    }
    let copies = &mut state.materials;
    copies.keep(&inspected.materials);
    if inspected.materials.len() > 1 {
        material_tree(ui, &inspected.materials, model, &mut state.part, commands);
    }
    if let Some(entry) = material_tree::edited(&inspected.materials, state.part) {
        ui.push_id(entry.entity, |ui| {
            material_header(ui, entry, model, commands);
            let edited = copies.of(entry);
            let edit = fields::compared(ui, &entry.mixed, |ui| {
                moving(ui, &model.timeline, (entry.entity, ""), |ui| {
                    material::material(ui, edited, entry.place, &model.textures)
                })
            });
            if edit.changed {
                commands.push(ValueEdit::SetMaterial(entry.entity, Box::new(edited.clone())).into());
            }
            light_section::choose_picture(entry.entity, edit, commands);
        });
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use egui_kittest::Harness;

    use super::*;
    use crate::app::editor::model::mixed::Mixed;

    #[test]
    fn a_frame_without_edits_copies_no_material() {
        let entity = Entity::PLACEHOLDER;
        let material = Material::of_plugin("principled").expect("a plugin");
        let entry = InspectedMaterial {
            entity,
            name: "paint".into(),
            material: Arc::new(material),
            place: MaterialPlace::Whole,
            path: Vec::new(),
            mixed: Mixed::default(),
            users: 1,
            inside: Vec::new(),
        };
        let model = Model {
            inspected: Some(Inspected {
                materials: vec![entry],
                ..Inspected::new(entity, "paint")
            }),
            ..Model::default()
        };
        let mut harness = Harness::new_ui_state(
            move |ui, (state, places): &mut (InspectorState, Vec<*const _>)| {
                let mut commands = Vec::new();
                inspector(ui, &model, 1.0, state, &mut commands);
                assert_eq!(commands, []);
                // The parameters of a copy would belong to another material.
                let copy = state.materials.0.get(&entity);
                if let Some(Material::Principled(parameters)) = copy {
                    places.push(Arc::as_ptr(parameters));
                }
            },
            Default::default(),
        );
        harness.run_steps(4);
        let (_, places) = harness.state();
        assert!(
            places.len() >= 4 && places.iter().all(|place| *place == places[0]),
            "{places:?}"
        );
    }
}
