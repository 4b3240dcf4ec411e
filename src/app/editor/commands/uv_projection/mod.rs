//! Gives shapes new texture coordinates.
//!
//! Walls, stairs, prisms and boxes keep their parameters: their coordinates are lengths already, so that a transform of
//! uv in the material suffices. For rectangles it suffices if no other shape has the material. All others become
//! meshes, in a file of their own that is saved with the scene. Other textures of the material keep their transform
//! relative to the first one.

mod mapping;

use bevy::asset::Assets;
use bevy::ecs::entity::EntityHashMap;
use bevy::math::{Affine2, Affine3A, Vec2, Vec3};
use bevy::prelude::*;

use super::materials::copied;
use super::texturing::material_parts;
use super::things::{outer_materials, replace, set_pose};
use crate::app::editor::camera::pose;
use crate::app::editor::command::blocking::openings::box_as_wall;
use crate::app::editor::command::error::CommandError;
use crate::app::editor::command::texture_placing::{texture_groups, upright};
use crate::app::editor::command::uv_projection::{ProjectedFrom, Projection};
use crate::app::editor::session::history::Edit;
use crate::app::editor::session::toasts::Toasts;
use crate::app::editor::session::view_settings::ViewSettings;
use crate::geometry::mesh::MeshData;
use crate::geometry::ply_write::binary_ply;
use crate::math::Aabb;
use crate::scene::assets::parts_cache::{CACHE, allow_parts};
use crate::scene::assets::shape_mesh::shape_mesh;
use crate::scene::{
    Locked, Material, MaterialUsers, MeshFile, MeshFormat, MeshHandle, SceneAccess, Shape, ShapeKind, Solid, ToWorld,
    TriangleMesh, UsesMaterial,
};
use mapping::{Mapping, Plane};

/// The transform of uv that suits a shape without a change of its geometry.
struct Fitting {
    shape: Entity,
    /// Tiles from the shape's uv.
    to_uv: Affine2,
    /// The wall with the same surface that replaces a box.
    wall: Option<(Solid, Affine3A)>,
    /// Whether the shape should keep its parameters even if that takes a material of its own.
    is_part: bool,
}

/// The facts for the message to the user.
#[derive(Default)]
struct Notes {
    meshes: Vec<String>,
    copies: Vec<String>,
}

/// Projects texture coordinates. An error if a shape has no surface that can have any.
pub fn project(edit: &mut Edit, shapes: &[Entity], projection: Projection) -> Result<(), CommandError> {
    if !(projection.tile > 0.0 && projection.tile.is_finite()) {
        return Err("The tile needs a size above 0.".into());
    }
    let is_shape = |entity: &Entity| edit.world.get::<Shape>(*entity).is_some_and(|shape| !shape.is_frame());
    let shapes: Vec<Entity> = shapes.iter().copied().filter(is_shape).collect();
    if shapes.is_empty() {
        return Err("Only shapes have texture coordinates.".into());
    }
    let mut notes = Notes::default();
    let mut fittings = Vec::new();
    let mut others = Vec::new();
    for shape in shapes {
        if edit.world.get::<Locked>(shape).is_some() {
            return Err("That is locked.".into());
        }
        match fitting(edit.world, shape, projection) {
            Some(fitting) => fittings.push(fitting),
            None => others.push(shape),
        }
    }
    others.extend(fit(edit, fittings, &mut notes)?);
    for shape in others {
        into_mesh(edit, shape, projection)?;
        notes.meshes.push(name_of(edit.world, shape));
    }
    notes.tell(edit.world);
    Ok(())
}

/// The transform of uv that suffices for a shape; None if none does.
fn fitting(world: &World, entity: Entity, projection: Projection) -> Option<Fitting> {
    let shape = world.get::<Shape>(entity)?;
    let pose = world.get::<ToWorld>(entity)?.0;
    let up = up(world);
    match &shape.kind {
        ShapeKind::Rectangle => {
            let side = if shape.flip_normals { Vec3::NEG_Z } else { Vec3::Z };
            let normal = (pose.matrix3.inverse().transpose() * bevy::math::Vec3A::from(side)).try_normalize()?;
            let plane = match projection.from {
                ProjectedFrom::Box => Plane::facing(mapping::side(normal.into()), up, projection.tile),
                ProjectedFrom::Face => Plane::facing(normal.into(), up, projection.tile),
                from => plane(world, from, projection.tile)?,
            };
            let local_from_uv = Affine3A::from_scale_rotation_translation(
                Vec3::new(2.0, 2.0, 1.0),
                Quat::IDENTITY,
                Vec3::new(-1.0, -1.0, 0.0),
            );
            let to_uv = plane.tiles_from_uv(&(pose * local_from_uv));
            (to_uv.matrix2.determinant() != 0.0).then_some(Fitting {
                shape: entity,
                to_uv,
                wall: None,
                is_part: false,
            })
        }
        ShapeKind::Solid(_) | ShapeKind::Cube if projection.from == ProjectedFrom::Box => {
            let (part, pose) = match &shape.kind {
                ShapeKind::Cube => box_as_wall(&pose, up).map(|(wall, pose)| (Some(wall), pose))?,
                _ => (None, pose),
            };
            let to_uv = Affine2::from_scale(Vec2::splat(even_scale(&pose)? / projection.tile));
            Some(Fitting {
                shape: entity,
                to_uv,
                wall: part.map(|wall| (wall, pose)),
                is_part: true,
            })
        }
        _ => None,
    }
}

/// The scale of a pose that scales evenly and does not mirror.
fn even_scale(pose: &Affine3A) -> Option<f32> {
    let columns = [pose.matrix3.x_axis, pose.matrix3.y_axis, pose.matrix3.z_axis];
    let [x, y, z] = columns.map(|column| column.length());
    let is_even = (x - y).abs().max((x - z).abs()) < 1e-4 * x;
    let is_right = pose.matrix3.determinant() > 0.999 * x * y * z;
    (is_even && is_right).then_some(x)
}

fn up(world: &World) -> Vec3 {
    world.resource::<ViewSettings>().navigation.up
}

/// The plane of a projection with the same direction for all shapes.
fn plane(world: &World, from: ProjectedFrom, tile: f32) -> Option<Plane> {
    match from {
        ProjectedFrom::View => {
            let pose = pose::view_pose(world)?;
            let [top, ahead] =
                [pose.matrix3.y_axis, pose.matrix3.z_axis].map(|axis| Vec3::from(axis).normalize_or_zero());
            Some(Plane::facing(-ahead, top, tile))
        }
        ProjectedFrom::Above => Some(Plane::facing(up(world), up(world), tile)),
        _ => None,
    }
}

/// Places the textures of shapes for which a transform suffices. Returns the shapes for which it does not, because
/// others use their material.
fn fit(edit: &mut Edit, fittings: Vec<Fitting>, notes: &mut Notes) -> Result<Vec<Entity>, CommandError> {
    let mut rest = Vec::new();
    let mut copies: Vec<(Entity, Affine2, Entity)> = Vec::new();
    let placings: EntityHashMap<Affine2> = fittings.iter().map(|fitting| (fitting.shape, fitting.to_uv)).collect();
    for fitting in &fittings {
        let Fitting {
            shape,
            to_uv,
            wall,
            is_part,
        } = fitting;
        let (shape, to_uv) = (*shape, *to_uv);
        let used = edit.world.get::<UsesMaterial>(shape).map(|uses| uses.0);
        let first = used.and_then(|material| first_placing(edit.world, material));
        let (Some(material), Some(first)) = (used, first) else {
            return Err(format!("{} has no picture or checkerboard yet.", name_of(edit.world, shape)).into());
        };
        // A texture with this transform, from before or for an earlier shape, needs no change.
        if !first.abs_diff_eq(to_uv, 1e-5 * to_uv.matrix2.x_axis.length().max(1.0)) {
            let suits_all = || {
                let mut users = shapes_of(edit.world, material).into_iter();
                users.all(|user| placings.get(&user) == Some(&to_uv))
            };
            let target = match copies.iter().find(|(of, with, _)| *of == material && *with == to_uv) {
                Some((.., copy)) => Some(*copy),
                None if suits_all() => {
                    place_first(edit, material, first, to_uv);
                    None
                }
                None if *is_part => {
                    let copy = copied(edit, material).ok_or("The material is nested too deeply to be copied.")?;
                    place_first(edit, copy, first, to_uv);
                    copies.push((material, to_uv, copy));
                    notes.copies.push(name_of(edit.world, copy));
                    Some(copy)
                }
                None => {
                    rest.push(shape);
                    continue;
                }
            };
            if let Some(target) = target {
                edit.set(shape, UsesMaterial(target));
            }
        }
        if let Some((wall, pose)) = wall {
            let before = edit.world.get::<Shape>(shape).cloned().unwrap_or_default();
            let kind = ShapeKind::Solid(wall.clone());
            replace(edit, shape, Shape { kind, ..before })?;
            set_pose(edit, shape, *pose);
        }
    }
    Ok(rest)
}

/// The transform of the first texture of a material.
fn first_placing(world: &World, material: Entity) -> Option<Affine2> {
    let parts = material_parts(world, material);
    let materials = parts.iter().filter_map(|part| world.get::<Material>(*part));
    texture_groups(materials).first().map(|group| group.to_uv)
}

/// Replaces the transform of a material's first texture, and keeps all others fixed relative to it.
fn place_first(edit: &mut Edit, material: Entity, before: Affine2, after: Affine2) {
    let back = before.inverse();
    let change = if back.is_finite() {
        back * after
    } else {
        Affine2::IDENTITY
    };
    for part in material_parts(edit.world, material) {
        let Some(mut edited) = edit.world.get::<Material>(part).cloned() else {
            continue;
        };
        edited.for_each_placing(&mut |_, to_uv| {
            *to_uv = match *to_uv == before {
                true => after,
                false => *to_uv * change,
            };
        });
        edit.set(part, edited);
    }
}

/// The shapes that use a material, also nested in others.
fn shapes_of(world: &World, material: Entity) -> Vec<Entity> {
    let mut materials = vec![material];
    let mut found = Vec::new();
    let mut next = 0;
    while let Some(&material) = materials.get(next) {
        found.extend(
            world
                .get::<MaterialUsers>(material)
                .into_iter()
                .flat_map(|users| users.iter()),
        );
        for outer in outer_materials(world, material) {
            if !materials.contains(&outer) {
                materials.push(outer);
            }
        }
        next += 1;
    }
    found
}

/// Makes a shape a mesh with new coordinates.
fn into_mesh(edit: &mut Edit, entity: Entity, projection: Projection) -> Result<(), CommandError> {
    let name = name_of(edit.world, entity);
    let (Some(shape), Some(ToWorld(pose))) = (edit.world.get::<Shape>(entity), edit.world.get::<ToWorld>(entity))
    else {
        return Err("Only shapes have texture coordinates.".into());
    };
    let (shape, pose) = (shape.clone(), *pose);
    let material = edit.world.get::<UsesMaterial>(entity).map(|uses| uses.0);
    let mesh = mesh_of(edit.world, entity, &shape, material.is_some()).map_err(|why| format!("{name} {why}"))?;
    let map = mapping_of(edit.world, &mesh, &pose, projection)
        .ok_or_else(|| format!("{name} has no extent to project a texture onto."))?;
    let first = material.and_then(|material| first_placing(edit.world, material));
    let to_uv = first.filter(|first| first.inverse().is_finite());
    // A picture that is chosen later will be put upright.
    let to_uv = to_uv.unwrap_or(Affine2::IDENTITY);
    // A picture that was flipped for its shape is flipped for the mesh as well, and the other way round.
    let flip_tex_coords = to_uv.matrix2.determinant() > 0.0;
    let uv_from_tiles = upright(flip_tex_coords) * to_uv.inverse();
    let mapped = mapping::mapped(&mesh, &pose, &map, &uv_from_tiles);
    if !mapped.uvs.iter().all(|uv| uv.is_finite()) {
        return Err(format!("{name} is too large for tiles of this size.").into());
    }
    let path = CACHE
        .keep(&format!("{}.ply", file_name(&name)), &binary_ply(&mapped))
        .map_err(|error| format!("The mesh of {name} cannot be kept: {error}."))?;
    if let Some(access) = edit.world.get_resource::<SceneAccess>() {
        allow_parts(|folder| access.allow(folder));
    }
    let face_normals = match &shape.kind {
        ShapeKind::Mesh(file) => file.face_normals,
        _ => false,
    };
    let file = MeshFile {
        path: path.into(),
        format: MeshFormat::Ply,
        shape_index: 0,
        face_normals,
        flip_tex_coords,
    };
    let kind = ShapeKind::Mesh(file);
    replace(edit, entity, Shape { kind, ..shape })
}

/// The triangles of a shape; the rest of a sentence about the shape if there are none.
fn mesh_of(world: &World, entity: Entity, shape: &Shape, has_material: bool) -> Result<MeshData, &'static str> {
    let ShapeKind::Mesh(file) = &shape.kind else {
        return shape_mesh(&shape.kind).ok_or("has no surface of its own.");
    };
    let handle = world.get::<MeshHandle>(entity);
    let loaded = handle.and_then(|handle| world.get_resource::<Assets<TriangleMesh>>()?.get(&handle.0));
    let data = loaded.and_then(|mesh| mesh.data(file.shape_index));
    let data = data.ok_or("has no mesh yet.")?;
    if shape.is_of_curves() {
        return Err("has texture coordinates along its curves alone.");
    }
    if !has_material && !data.materials.is_empty() {
        return Err("has the materials of its file, which would be lost: give it a material first.");
    }
    Ok(MeshData::clone(data))
}

fn mapping_of(world: &World, mesh: &MeshData, pose: &Affine3A, projection: Projection) -> Option<Mapping> {
    let (up, tile) = (up(world), projection.tile);
    let corners = mesh.triangles.iter().flatten();
    let places = corners.map(|corner| pose.transform_point3(mesh.positions[*corner as usize]));
    let bounds = Aabb::from_points(places);
    if bounds.is_empty() {
        return None;
    }
    Some(match projection.from {
        ProjectedFrom::Box => Mapping::Box { up, tile },
        ProjectedFrom::Face => Mapping::Plane(Plane::facing(mapping::main_direction(mesh, pose)?, up, tile)),
        ProjectedFrom::Sphere => mapping::around(&bounds, up, tile, true),
        ProjectedFrom::Cylinder => mapping::around(&bounds, up, tile, false),
        from => Mapping::Plane(plane(world, from, tile)?),
    })
}

fn name_of(world: &World, entity: Entity) -> String {
    world
        .get::<Name>(entity)
        .map_or_else(|| "it".to_owned(), Name::to_string)
}

/// A name as a file name: letters, digits and dashes.
fn file_name(name: &str) -> String {
    let plain = |c: char| if c.is_ascii_alphanumeric() { c } else { '-' };
    let name: String = name.chars().map(plain).take(40).collect();
    match name.trim_matches('-') {
        "" => "mesh".to_owned(),
        name => name.to_owned(),
    }
}

impl Notes {
    fn tell(&self, world: &mut World) {
        let listed = |names: &[String]| match names {
            [one] => one.clone(),
            [one, two] => format!("{one} and {two}"),
            [first, .., last] => format!("{first}, \u{2026}, {last} ({} in all)", names.len()),
            [] => String::new(),
        };
        let mut sentences = Vec::new();
        if !self.meshes.is_empty() {
            let verb = if self.meshes.len() == 1 {
                "is now a mesh"
            } else {
                "are now meshes"
            };
            sentences.push(format!("{} {verb} with texture coordinates.", listed(&self.meshes)));
        }
        if !self.copies.is_empty() {
            let verb = if self.copies.len() == 1 {
                "is a copy of its"
            } else {
                "are copies of their"
            };
            let rest = "material, because other shapes have that, too.";
            sentences.push(format!("{} {verb} {rest}", listed(&self.copies)));
        }
        if let Some(mut toasts) = world.get_resource_mut::<Toasts>().filter(|_| !sentences.is_empty()) {
            toasts.info(sentences.join(" "));
        }
    }
}
