//! Puts a file into the scene where it was dropped, or onto the selection.

use std::path::Path;

use bevy::math::{Affine3A, Vec2, Vec3};
use bevy::prelude::*;

use super::importing::{add_lamp, import_chosen};
use super::spot::rounded_place;
use super::texturing::set_picture;
use super::things::{need_surface, pose_of};
use super::{grouping, materials, things, volumes};
use crate::app::editor::camera::picking;
use crate::app::editor::command::asset_kind::{AssetKind, FileUse};
use crate::app::editor::command::error::CommandError;
use crate::app::editor::command::material_tree::materials_inside;
use crate::app::editor::command::presets::{self, FileContent};
use crate::app::editor::command::selection::Selection;
use crate::app::editor::session::history::Edit;
use crate::app::editor::session::trust;
use crate::app::editor::session::view_settings::ViewSettings;
use crate::engine::PackedScene;
use crate::files::{self, Access};
use crate::math::Ray;
use crate::scene::assets::gltf_scene::{is_called_gltf, placed_meshes};
use crate::scene::assets::triangle_mesh::load_mesh;
use crate::scene::{Declared, Locked, Material, ParameterRef, Shape, ShapeKind, SquarePath, Trust, read};

/// The depth to which nested materials are searched.
const DEEPEST: usize = 8;

pub fn use_file(edit: &mut Edit, file: &FileUse) -> Result<(), CommandError> {
    let FileUse { path, at, bounds } = file;
    match AssetKind::of(path) {
        Some(AssetKind::Picture | AssetKind::Environment) => {
            let shapes = takers(edit, *at)?;
            if shapes.is_empty() {
                return import_chosen(edit, path);
            }
            let path = read::settle(path);
            if !path.is_file() {
                return Err(CommandError::file(format!(
                    "{}: there is no such file.",
                    path.display()
                )));
            }
            materials::of_their_own(edit, &shapes)
                .into_iter()
                .try_for_each(|material| cover(edit, material, &path))?;
            trust::allow_chosen(edit.world, &path);
            Ok(())
        }
        Some(AssetKind::Mesh) => {
            import_chosen(edit, path)?;
            match at {
                Some(at) => stand(edit, *at, bounds.or_else(|| bounds_of(path))),
                None => Ok(()),
            }
        }
        Some(AssetKind::Volume) => {
            let place = at.and_then(|at| place_at(edit.world, at));
            let Some(place) = place else {
                return import_chosen(edit, path);
            };
            let path = read::settle(path);
            volumes::import(edit, &path, Some(place))?;
            trust::allow_chosen(edit.world, &path);
            Ok(())
        }
        Some(AssetKind::Lamp) => {
            let path = read::settle(path);
            if !path.is_file() {
                return import_chosen(edit, &path);
            }
            let place = at.and_then(|at| hanging_at(edit.world, at));
            add_lamp(edit, path.clone(), place)?;
            trust::allow_chosen(edit.world, &path);
            Ok(())
        }
        Some(AssetKind::Scene) => match content_of(edit, path)? {
            FileContent::Materials(preset) => {
                let shapes = takers(edit, *at)?;
                if shapes.is_empty() {
                    return Err("There is no shape that could take the material.".into());
                }
                materials::use_preset(edit, &preset, &shapes)?;
                trust::allow_chosen(edit.world, path);
                Ok(())
            }
            FileContent::Scene(_) => import_chosen(edit, path),
        },
        None => import_chosen(edit, path),
    }
}

/// The kind of content of an XML file, such as a scene or a material.
fn content_of(edit: &Edit, path: &Path) -> Result<FileContent, CommandError> {
    let trust = edit.world.get_resource::<Trust>().cloned().unwrap_or_default();
    let found = presets::content_of(path, trust.access(path));
    found.map_err(|error| CommandError::file(format!("{}: {error}", path.display())))
}

/// The shape at the place, or the selected shapes. An error if the shape is locked.
fn takers(edit: &Edit, at: Option<Vec2>) -> Result<Vec<Entity>, CommandError> {
    let Some(at) = at else {
        let selected = edit.world.resource::<Selection>().entities().iter().copied();
        let is_free =
            |entity: &Entity| need_surface(edit, *entity).is_ok() && edit.world.get::<Locked>(*entity).is_none();
        return Ok(selected.filter(is_free).collect());
    };
    let found = picking::pick(edit.world.resource::<PackedScene>(), at);
    let Some(shape) = found else { return Ok(Vec::new()) };
    if edit.world.get::<Locked>(shape).is_some() {
        return Err("What is there is locked.".into());
    }
    need_surface(edit, shape)?;
    Ok(vec![shape])
}

/// Replaces the colour of a material by a picture.
fn cover(edit: &mut Edit, material: Entity, picture: &Path) -> Result<(), CommandError> {
    let (owner, parameter) = colored(edit.world, material, DEEPEST)
        .ok_or("The material of the shape has no colour that could be a picture.")?;
    set_picture(edit, owner, parameter, SquarePath::WHOLE, picture.to_owned());
    Ok(())
}

/// The material, or its first nested material, that has a surface colour, with the name of that parameter.
fn colored(world: &World, material: Entity, deepest: usize) -> Option<(Entity, &'static str)> {
    let mut found = None;
    world.get::<Material>(material)?.visit(&mut |info, value| {
        let is_color = ["reflectance", "base_color", "diffuse_reflectance"].contains(&info.name);
        if is_color && matches!(value, ParameterRef::Reflectance(_)) && found.is_none() {
            found = Some((material, info.name));
        }
    });
    let deepest = deepest.checked_sub(1)?;
    let inside = || materials_inside(world, material).into_iter();
    found.or_else(|| inside().find_map(|inner| colored(world, inner, deepest)))
}

/// The bounds of a mesh file that the scene has not loaded. None for large files, which would block the window.
fn bounds_of(path: &Path) -> Option<[Vec3; 2]> {
    const LARGEST: u64 = 16 << 20;
    files::check(path, LARGEST).ok()?;
    // The user has chosen the file.
    let access = Access::everywhere();
    let meshes = match is_called_gltf(path) {
        true => placed_meshes(path, &access, LARGEST).ok()?,
        false => {
            let shapes = load_mesh(path, &access).ok()?.shapes;
            shapes
                .iter()
                .map(|shape| (shape.data.clone(), Affine3A::IDENTITY))
                .collect()
        }
    };
    let points = meshes
        .iter()
        .flat_map(|(mesh, pose)| mesh.positions.iter().map(|point| pose.transform_point3(*point)));
    points.fold(None, |bounds, point| {
        let [low, high] = bounds.unwrap_or([point; 2]);
        Some([low.min(point), high.max(point)])
    })
}

/// Moves the imported mesh or group onto the surface at a point of the picture, or else onto the ground.
fn stand(edit: &mut Edit, at: Vec2, bounds: Option<[Vec3; 2]>) -> Result<(), CommandError> {
    let imported = edit.world.resource::<Selection>();
    let Some(lead) = imported.active() else {
        return Ok(());
    };
    let is_alone = imported.entities().len() == 1;
    let is_movable = |shape: &Shape| match shape.kind {
        ShapeKind::Mesh(_) => is_alone,
        ref other => *other == ShapeKind::Frame,
    };
    if !edit.world.get::<Shape>(lead).is_some_and(is_movable) {
        return Ok(());
    }
    let Some(place) = place_at(edit.world, at) else {
        return Ok(());
    };
    let up = edit.world.resource::<ViewSettings>().navigation.up;
    let [low, high] = bounds.unwrap_or_default();
    let middle = 0.5 * (low + high);
    let foot = middle - up * (0.5 * (high - low)).dot(up.abs());
    let size = (high - low).max_element();
    let goal = match size > 0.0 {
        true => rounded_place(place - foot, 0.5 * size),
        false => place,
    };
    let pose = pose_of(edit.world, lead).unwrap_or_default();
    let moved = Affine3A::from_translation(goal) * pose;
    let poses = grouping::with_members(edit, vec![(lead, moved)]);
    things::transform(edit, poses)
}

/// The place on a surface, or else on the ground, that is seen at a place of the picture.
fn place_at(world: &World, at: Vec2) -> Option<Vec3> {
    let up = world.resource::<ViewSettings>().navigation.up;
    let packed = world.resource::<PackedScene>();
    let ray = packed.view.as_ref()?.camera.sharp().ray(at, Vec2::ZERO);
    let seen = picking::seen_surface(packed, &ray, |_| false).map(|surface| surface.position);
    seen.or_else(|| ground(&ray, up))
}

/// The place of a lamp at a place of the picture: a little in front of the surface that is seen there, and well above
/// surfaces that face up, which it lights.
fn hanging_at(world: &World, at: Vec2) -> Option<Vec3> {
    /// The distance from the surface, and that from surfaces that face up, relative to the distance from the eye.
    const GAP: f32 = 0.01;
    const HEADROOM: f32 = 0.3;
    /// The least cosine of the angle between the upward axis and the normal of a surface that faces up.
    const FACING_UP: f32 = 0.5;
    let up = world.resource::<ViewSettings>().navigation.up;
    let packed = world.resource::<PackedScene>();
    let ray = packed.view.as_ref()?.camera.sharp().ray(at, Vec2::ZERO);
    let seen = picking::seen_surface(packed, &ray, |_| false);
    let faces_up = seen.as_ref().is_none_or(|seen| seen.normal.dot(up) > FACING_UP);
    let place = seen.map(|seen| seen.position).or_else(|| ground(&ray, up))?;
    let distance = place.distance(ray.origin);
    let lifted = match faces_up {
        true => place + HEADROOM * distance * up,
        false => place + GAP * (ray.origin - place),
    };
    Some(rounded_place(lifted, GAP * distance))
}

/// The place where a ray meets the plane through the origin across `up`, if it is not too far away for a mesh to be
/// seen there.
fn ground(ray: &Ray, up: Vec3) -> Option<Vec3> {
    /// In heights of the eye above the ground.
    const FARTHEST: f32 = 30.0;
    let (height, fall) = (ray.origin.dot(up), -ray.dir.dot(up));
    let t = height / fall;
    (t.is_finite() && t > 0.0 && t * ray.dir.length() < FARTHEST * height.abs()).then(|| ray.at(t))
}
