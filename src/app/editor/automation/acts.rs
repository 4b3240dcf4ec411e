//! The edits that measurements repeat. They alternate so that the scene stays about the same.

use bevy::math::{Affine3A, Vec3};
use bevy::prelude::*;
use tempfile::TempDir;

use super::script::assign;
use crate::app::editor::camera::pose::view_pose;
use crate::app::editor::command::addition::AdditionKind;
use crate::app::editor::command::selection::Extend;
use crate::app::editor::command::{
    Command, FileCommand, HistoryCommand, OutlineEdit, SceneEdit, SelectionCommand, ValueEdit, ViewCommand,
};
use crate::app::editor::session::history::History;
use crate::app::editor::session::requests::CommandQueue;
use crate::app::editor::session::view_settings::ViewSettings;
use crate::scene::{
    AreaLight, Emitter, Hidden, Material, MeshHandle, Shape, ShapeKind, ToWorld, TriangleMesh, UsesMaterial,
};

/// The sign, -1 and 1 alternately, so that the scene stays about the same.
fn sign(time: usize) -> f32 {
    if time.is_multiple_of(2) { 1.0 } else { -1.0 }
}

pub fn fly(world: &mut World, time: usize) -> Option<Command> {
    let pose = view_pose(world)?;
    let turned = Affine3A {
        matrix3: pose.matrix3 * bevy::math::Mat3A::from_axis_angle(Vec3::Y, 0.01 * sign(time)),
        translation: pose.translation,
    };
    Some(ViewCommand::MoveView(turned).into())
}

/// Moves the mesh with the most triangles by a hundredth of the scene's size.
pub fn drag(world: &mut World, time: usize) -> Option<Command> {
    let (entity, pose) = largest_mesh(world)?;
    let by = 0.01 * world.resource::<ViewSettings>().navigation.scene_size * sign(time);
    Some(ValueEdit::Transform(vec![(entity, Affine3A::from_translation(Vec3::X * by) * pose)]).into())
}

pub fn read_mesh(world: &mut World) -> Option<()> {
    let (entity, _) = largest_mesh(world)?;
    let path = world.get::<MeshHandle>(entity)?.0.path()?.clone();
    world.resource::<AssetServer>().reload(path);
    Some(())
}

/// Saves the scene into this folder, which is created on the first call.
pub fn save(world: &mut World, folder: &mut Option<TempDir>) -> Option<()> {
    if folder.is_none() {
        *folder = tempfile::tempdir().ok();
    }
    let path = folder.as_ref()?.path().join("scene.xml");
    world
        .resource_mut::<CommandQueue>()
        .0
        .push(FileCommand::SaveScene(path).into());
    Some(())
}

fn largest_mesh(world: &mut World) -> Option<(Entity, Affine3A)> {
    let mut shapes = world.query::<(Entity, &ToWorld, &Shape, Option<&MeshHandle>)>();
    let meshes = world.get_resource::<Assets<TriangleMesh>>();
    let triangles = |shape: &Shape, handle: Option<&MeshHandle>| {
        let ShapeKind::Mesh(file) = &shape.kind else {
            return None;
        };
        let data = meshes?.get(&handle?.0)?.data(file.shape_index)?;
        Some(data.triangles.len())
    };
    let largest = shapes
        .iter(world)
        .max_by_key(|(_, _, shape, handle)| triangles(shape, *handle));
    largest.map(|(entity, pose, ..)| (entity, pose.0))
}

/// Changes the first colour that can be set in the material of that mesh, or in any material.
pub fn change_material(world: &mut World, time: usize) -> Option<Command> {
    let of_mesh = largest_mesh(world).and_then(|(entity, _)| world.get::<UsesMaterial>(entity).map(|uses| uses.0));
    let mut all: Vec<Entity> = of_mesh.into_iter().collect();
    all.extend(world.query_filtered::<Entity, With<Material>>().iter(world));
    let color = format!("{}", 0.5 + 0.1 * sign(time));
    all.into_iter().find_map(|entity| {
        let mut material = world.get::<Material>(entity)?.clone();
        let names = [
            "reflectance",
            "base_color",
            "diffuse_reflectance",
            "specular_reflectance",
        ];
        names
            .iter()
            .find(|name| assign::material(&mut material, name, &color).is_ok())?;
        Some(ValueEdit::SetMaterial(entity, Box::new(material)).into())
    })
}

pub fn change_light(world: &mut World, time: usize) -> Option<Command> {
    let color = format!("{}", 5.0 + sign(time));
    let mut lights = world.query::<(Entity, &AreaLight)>();
    if let Some((entity, light)) = lights.iter(world).next() {
        let mut light = light.clone();
        assign::area_light(&mut light, "radiance", &color).ok()?;
        return Some(ValueEdit::SetAreaLight(entity, Some(light)).into());
    }
    let mut emitters = world.query::<(Entity, &Emitter)>();
    emitters.iter(world).find_map(|(entity, emitter)| {
        let mut emitter = emitter.clone();
        let names = ["radiance", "intensity", "irradiance", "scale"];
        names
            .iter()
            .find(|name| assign::emitter(&mut emitter, name, &color).is_ok())?;
        Some(ValueEdit::SetEmitter(entity, emitter).into())
    })
}

/// Undoes or redoes a step of the history, alternately.
pub fn undo(world: &mut World, time: usize) -> Option<Command> {
    if world.resource::<History>().len() == (0, 0) {
        return None;
    }
    Some(if time.is_multiple_of(2) {
        Command::from(HistoryCommand::Undo)
    } else {
        Command::from(HistoryCommand::Redo)
    })
}

/// A shape from the middle of the list, a different one each time.
pub fn middle_shape(world: &mut World, time: usize) -> Option<Entity> {
    let mut shapes = world.query_filtered::<Entity, (With<Shape>, Without<Hidden>)>();
    let count = shapes.iter(world).count();
    shapes
        .iter(world)
        .nth((count / 2 + time / 2).min(count.checked_sub(1)?))
}

pub fn select(shape: Entity, _: usize) -> Command {
    Command::from(SelectionCommand::Select(vec![shape], Extend::Replace))
}

pub fn rename(shape: Entity, time: usize) -> Command {
    Command::from(OutlineEdit::Rename(shape, format!("renamed {time}")))
}

pub fn hide(shape: Entity, _: usize) -> Command {
    Command::from(OutlineEdit::Hide(vec![shape], true))
}

pub fn add(_: &mut World, _: usize) -> Option<Command> {
    Some(SceneEdit::Add(AdditionKind::Sphere.into()).into())
}
