//! Converts components to plugins of the file, with every parameter spelled out. References to materials and media are
//! added elsewhere.

use std::path::Path;

use bevy::math::Affine3A;

use super::FRAME;
use super::into_object::{
    declared, with, with_child, with_flag, with_float, with_integer, with_nonzero, with_string, with_to_world,
    with_view,
};
use super::lights::area_light;
use crate::document::paths::file_name;
use crate::document::{Category, Object, Value};
use crate::layer::Layer;
use crate::scene::{
    AreaLight, EulerAngles, Film, IntegratorSettings, Lens, Material, Medium, MeshFormat, PhaseFunction, Sensor, Shape,
    ShapeKind,
};

/// `folder`: the folder of the written file, to which names of pictures are relative.
pub fn material(material: &Material, folder: &Path) -> Object {
    declared(Category::Bsdf, material.plugin(), material, folder)
}

/// `folder`: as for [`material`]; names of volumes are relative to it.
pub fn medium(medium: &Medium, folder: &Path) -> Object {
    let object = declared(Category::Medium, medium.plugin(), medium, folder);
    with_child(object, phase(&medium.phase, folder))
}

fn phase(function: &PhaseFunction, folder: &Path) -> Object {
    let object = declared(Category::Phase, function.plugin(), function, folder);
    let inside = function.inside().iter().map(|part| phase(part, folder));
    inside.fold(object, with_child)
}

/// `angles`: the rotation angles, if known. `folder`: the folder of the written file, to which the mesh's name is
/// relative.
pub fn shape(
    shape: &Shape,
    to_world: &Affine3A,
    angles: Option<EulerAngles>,
    area: Option<&AreaLight>,
    folder: &Path,
) -> Object {
    let object = |plugin: &str| Object::new(Category::Shape, plugin);
    let object = match &shape.kind {
        ShapeKind::Sphere { center, radius } => {
            let object = with(object("sphere"), "center", Value::Point(*center));
            with_float(object, "radius", *radius)
        }
        ShapeKind::Rectangle => object("rectangle"),
        ShapeKind::Cube => object("cube"),
        ShapeKind::Disk => object("disk"),
        ShapeKind::Triangle { corners: [a, b, c] } => {
            let object = with(object("triangle"), "v0", Value::Point(*a));
            with(with(object, "v1", Value::Point(*b)), "v2", Value::Point(*c))
        }
        ShapeKind::Cylinder { p0, p1, radius } => {
            let object = with(object("cylinder"), "p0", Value::Point(*p0));
            with_float(with(object, "p1", Value::Point(*p1)), "radius", *radius)
        }
        ShapeKind::Solid(solid) => declared(Category::Shape, solid.plugin(), solid, folder),
        // The reference to its group is added elsewhere, and it has no other parameters.
        ShapeKind::Instance => {
            return with_to_world(with_lightmap_scale(object("instance"), shape), to_world, angles);
        }
        ShapeKind::Frame => {
            let volume = Object::new(Category::Volume, FRAME);
            return with_to_world(with_float(volume, "value", 1.0), to_world, angles);
        }
        ShapeKind::Mesh(file) => {
            let object = with_string(object(file.format.name()), "filename", &file_name(&file.path, folder));
            let object = match file.format {
                MeshFormat::BSplineCurve | MeshFormat::LinearCurve => object,
                MeshFormat::Serialized => with_integer(object, "shape_index", file.shape_index),
                MeshFormat::Obj | MeshFormat::Ply => with_flag(object, "flip_tex_coords", file.flip_tex_coords),
            };
            match file.format.is_of_curves() {
                true => object,
                false => with_flag(object, "face_normals", file.face_normals),
            }
        }
    };
    let object = with_flag(object, "flip_normals", shape.flip_normals);
    let object = with_flag(object, "portal", shape.portal && shape.kind == ShapeKind::Rectangle);
    let object = with_to_world(with_lightmap_scale(object, shape), to_world, angles);
    match area {
        Some(light) => with_child(object, area_light(light, folder)),
        None => object,
    }
}

fn with_lightmap_scale(object: Object, shape: &Shape) -> Object {
    match shape.lightmap_scale {
        1.0 => object,
        scale => with_float(object, "lightmap_scale", scale),
    }
}

/// The `<sensor>` with its film and sampler count.
pub fn sensor(sensor: &Sensor, film: &Film, to_world: &Affine3A) -> Object {
    let object = |plugin: &str| Object::new(Category::Sensor, plugin);
    let object = match sensor.lens {
        Lens::Pinhole => with_fov(object("perspective"), sensor),
        Lens::Thin {
            aperture_radius,
            focus_distance,
            blades,
            blade_rotation,
        } => {
            let object = with_float(object("thinlens"), "aperture_radius", aperture_radius);
            let object = with_float(object, "focus_distance", focus_distance);
            let object = with_fov(object, sensor);
            // An extension, which is left out where it has no effect, since other readers do not know it.
            if blades < 3 {
                object
            } else {
                with_float(with_integer(object, "blades", blades), "blade_rotation", blade_rotation)
            }
        }
        Lens::Orthographic => object("orthographic"),
    };
    let object = with_float(object, "near_clip", sensor.near_clip);
    let object = with_float(object, "far_clip", sensor.far_clip);
    let offset = sensor.principal_point_offset;
    let object = with_nonzero(object, "principal_point_offset_x", offset.x);
    let object = with_nonzero(object, "principal_point_offset_y", offset.y);
    let object = with_nonzero(object, "shutter_open", sensor.shutter_open);
    let object = with_nonzero(object, "shutter_close", sensor.shutter_close);
    let object = with_view(object, to_world, None);
    let sampler = Object::new(Category::Sampler, "independent");
    let mut sampler = with_integer(sampler, "sample_count", film.sample_count);
    if let Some(noise) = film.noise_target {
        sampler = with_float(sampler, "noise_target", noise);
    }
    if film.adaptive {
        sampler = with_flag(sampler, "adaptive", true);
    }
    with_child(with_child(object, film_object(film)), sampler)
}

fn with_fov(object: Object, sensor: &Sensor) -> Object {
    let object = with_float(object, "fov", sensor.fov);
    with_string(object, "fov_axis", sensor.fov_axis.name())
}

fn film_object(film: &Film) -> Object {
    let object = with_integer(Object::new(Category::Film, "hdrfilm"), "width", film.width);
    let mut object = with_integer(object, "height", film.height);
    if let Some(crop) = film.crop {
        object = with_integer(object, "crop_offset_x", crop.x);
        object = with_integer(object, "crop_offset_y", crop.y);
        object = with_integer(object, "crop_width", crop.width);
        object = with_integer(object, "crop_height", crop.height);
    }
    if let Some(pixels) = film.storage.pixels {
        object = with_string(object, "pixel_format", pixels.name());
    }
    if let Some(components) = film.storage.components {
        object = with_string(object, "component_format", components.name());
    }
    if let Some(file) = film.storage.file {
        object = with_string(object, "file_format", file.name());
    }
    if let Some(compression) = film.storage.compression {
        object = with_string(object, "compression", compression.name());
    }
    let filter = &film.filter;
    // A filter has no file names.
    let filter = declared(Category::ReconstructionFilter, filter.plugin(), filter, Path::new(""));
    with_child(object, filter)
}

/// The `<integrator>`; settings for which the format has no parameter are left out.
pub fn integrator(settings: &IntegratorSettings) -> Object {
    let depth = settings.max_depth.map_or(-1, i64::from);
    let object = with(
        Object::new(Category::Integrator, settings.plugin.name()),
        "max_depth",
        Value::Integer(depth),
    );
    let mut object = with_integer(object, "rr_depth", settings.rr_depth);
    if settings.plugin.has_photons() {
        object = with_integer(object, "photons", settings.photons.unwrap_or(0));
        object = with(object, "merge_radius", Value::Float(settings.merge_radius));
    }
    if let Some(percentile) = settings.clamp_percentile {
        object = with(object, "clamp_percentile", Value::Float(percentile));
    }
    if settings.guided && settings.plugin.is_guidable() {
        object = with_flag(object, "guided", true);
    }
    let path = with_flag(object, "hide_emitters", settings.hide_emitters);
    if settings.layers.is_empty() {
        return path;
    }
    let entry = |layer: Layer| format!("{}:{}", layer.name_in_pictures(), layer.name_in_file());
    let entries: Vec<String> = settings.layers.iter().map(entry).collect();
    let object = with_string(Object::new(Category::Integrator, "aov"), "aovs", &entries.join(","));
    with_child(object, path)
}
