//! The inspector with every kind of thing.

use std::path::PathBuf;
use std::sync::{Arc, Mutex};

use bevy::math::{Affine3A, Vec3};
use image::RgbImage;
use sunroom::app::editor::command::media::MediumSide;
use sunroom::app::editor::command::selection::Selection;
use sunroom::app::editor::model::mixed::Mixed;
use sunroom::app::editor::model::{
    Inspected, InspectedMaterial, InspectedMedium, InspectedMesh, MaterialPlace, MissingItem, Model,
};
use sunroom::app::editor::panels::inspector::{InspectorState, inspector};
use sunroom::color::Rgb;
use sunroom::math::Aabb;
use sunroom::scene::{
    AreaLight, Coefficients, Emitter, FileKind, Film, Material, Medium, MeshFile, Opening, Sensor, Shape, ShapeKind,
    Solid, SquarePath,
};

use super::panel;
use super::scene::{OAK, PLASTER, entity, model};

/// The width that the window gives the inspector at first.
const WIDTH: u32 = 300;

fn inspect(inspected: Option<Inspected>) -> RgbImage {
    let selection = inspected.iter().map(|inspected| inspected.entity);
    inspect_in(Model {
        selection: Selection::of(selection),
        inspected,
        ..model()
    })
}

fn inspect_in(model: Model) -> RgbImage {
    let state = Arc::new(Mutex::new(InspectorState::default()));
    let show = move |ui: &mut bevy_egui::egui::Ui, model: &mut Model| {
        let mut state = state.lock().expect("one thread");
        inspector(ui, model, 10.0, &mut state, &mut Vec::new());
    };
    panel([WIDTH, 1100], model, show, |_| ())
}

fn at(x: f32, y: f32, z: f32) -> Option<Affine3A> {
    Some(Affine3A::from_rotation_y(0.5) * Affine3A::from_translation(Vec3::new(x, y, z)))
}

fn shape(kind: ShapeKind) -> Shape {
    Shape {
        kind,
        ..Shape::default()
    }
}

fn material(index: u32, name: &str, material: Material) -> InspectedMaterial {
    InspectedMaterial {
        entity: entity(index),
        name: name.to_owned(),
        material: material.into(),
        place: MaterialPlace::Whole,
        path: Vec::new(),
        mixed: Mixed::default(),
        users: 3,
        inside: Vec::new(),
    }
}

fn plaster() -> InspectedMaterial {
    let reflectance = Rgb::new(0.76, 0.73, 0.68).into();
    material(PLASTER, "plaster", Material::Diffuse { reflectance })
}

/// A shape of plaster.
fn plastered(kind: ShapeKind, name: &str) -> Inspected {
    Inspected {
        to_world: at(1.0, 0.25, -3.5),
        shape: Some(shape(kind)),
        uses_material: Some(entity(PLASTER)),
        materials: vec![plaster()],
        ..Inspected::new(entity(2), name)
    }
}

fn only_material(material: InspectedMaterial) -> RgbImage {
    inspect(Some(Inspected {
        materials: vec![material.clone()],
        ..Inspected::new(material.entity, material.name)
    }))
}

fn plugin(name: &str) -> Material {
    Material::of_plugin(name).expect("a plugin")
}

fn light(plugin: &str) -> RgbImage {
    inspect(Some(Inspected {
        to_world: at(0.0, 2.4, 1.0),
        emitter: Emitter::of_plugin(plugin),
        ..Inspected::new(entity(51), "reading lamp")
    }))
}

pub fn nothing_selected() -> RgbImage {
    inspect(None)
}

pub fn cube() -> RgbImage {
    let mut cube = plastered(ShapeKind::Cube, "block");
    cube.to_world = Some(Affine3A::from_scale(Vec3::new(0.5, 0.25, 1.5)));
    inspect_in(Model {
        selection: Selection::of([cube.entity]),
        inspected: Some(cube),
        extent: Some(Aabb {
            min: Vec3::new(-0.5, -0.25, -1.5),
            max: Vec3::new(0.5, 0.25, 1.5),
        }),
        ..model()
    })
}

pub fn sphere_that_shines() -> RgbImage {
    let center = Vec3::ZERO;
    inspect(Some(Inspected {
        area_light: Some(AreaLight {
            radiance: Rgb::new(12.0, 9.0, 6.0).into(),
            ..AreaLight::default()
        }),
        ..plastered(ShapeKind::Sphere { center, radius: 0.2 }, "globe")
    }))
}

pub fn wall() -> RgbImage {
    let openings = vec![
        Opening::DOOR,
        Opening {
            from: 2.0,
            ..Opening::WINDOW
        },
    ];
    let wall = Solid::Wall {
        length: 4.0,
        height: 2.5,
        thickness: 0.2,
        openings,
    };
    inspect(Some(plastered(ShapeKind::Solid(wall), "wall with window")))
}

pub fn stairs() -> RgbImage {
    let stairs = Solid::Stairs {
        width: 1.0,
        depth: 4.0,
        height: 2.5,
        steps: 14,
    };
    inspect(Some(plastered(ShapeKind::Solid(stairs), "stairs to the attic")))
}

pub fn mesh_that_is_missing() -> RgbImage {
    let path = PathBuf::from("/models/bunny.ply");
    let mut bunny = plastered(
        ShapeKind::Mesh(MeshFile {
            path: path.clone(),
            ..MeshFile::default()
        }),
        "bunny",
    );
    bunny.mesh = Some(InspectedMesh {
        triangles: 69_451,
        curves: [0; 2],
        has_materials: false,
    });
    let kind = FileKind::Mesh;
    inspect_in(Model {
        selection: Selection::of([bunny.entity]),
        inspected: Some(bunny),
        missing: vec![MissingItem { kind, path }].into(),
        ..model()
    })
}

pub fn group() -> RgbImage {
    inspect(Some(Inspected {
        to_world: at(2.0, 0.0, 0.0),
        shape: Some(shape(ShapeKind::Frame)),
        members: Some(5),
        ..Inspected::new(entity(4), "table/")
    }))
}

/// Two boxes that differ in their place and in what they are made of.
pub fn several() -> RgbImage {
    let one = Inspected {
        area_light: Some(AreaLight::default()),
        ..plastered(ShapeKind::Cube, "table top")
    };
    let other = Inspected {
        entity: entity(1),
        to_world: Some(Affine3A::from_scale(Vec3::splat(2.0))),
        uses_material: Some(entity(OAK)),
        area_light: None,
        ..one.clone()
    };
    let mixed = Mixed::of(&one, &[other]);
    inspect_in(Model {
        inspected: Some(Inspected { mixed, ..one }),
        ..model()
    })
}

pub fn principled() -> RgbImage {
    only_material(material(OAK, "oak", plugin("principled")))
}

pub fn rough_conductor() -> RgbImage {
    only_material(material(32, "brass", plugin("roughconductor")))
}

pub fn dielectric() -> RgbImage {
    only_material(material(33, "glass", plugin("dielectric")))
}

pub fn two_sided() -> RgbImage {
    let outer = InspectedMaterial {
        inside: vec![entity(PLASTER)],
        ..material(34, "curtain", Material::TwoSided)
    };
    let inner = InspectedMaterial {
        place: MaterialPlace::Front,
        path: vec![0],
        ..plaster()
    };
    inspect(Some(Inspected {
        materials: vec![outer.clone(), inner],
        ..Inspected::new(outer.entity, outer.name)
    }))
}

pub fn textured() -> RgbImage {
    let mut painted = plugin("principled");
    for (parameter, picture) in [
        ("base_color", "/textures/planks of old oak, 2 m.png"),
        ("roughness", "/textures/worn.png"),
    ] {
        painted.set_picture(parameter, SquarePath::WHOLE, &picture.into());
    }
    only_material(material(OAK, "planks", painted))
}

pub fn point() -> RgbImage {
    light("point")
}

pub fn spot() -> RgbImage {
    light("spot")
}

pub fn sky() -> RgbImage {
    light("envmap")
}

pub fn projector() -> RgbImage {
    light("projector")
}

pub fn sun_and_sky() -> RgbImage {
    light("sunsky")
}

pub fn fog() -> RgbImage {
    let medium = Medium {
        coefficients: Coefficients::Extinction {
            sigma_t: Rgb::splat(0.5).into(),
            albedo: Rgb::splat(0.9).into(),
        },
        ..Medium::default()
    };
    let mut media_at = [None; 3];
    media_at[MediumSide::Interior as usize] = Some(entity(40));
    inspect(Some(Inspected {
        to_world: at(0.0, 0.0, 0.0),
        shape: Some(shape(ShapeKind::Cube)),
        media_at,
        media: vec![InspectedMedium {
            entity: entity(40),
            name: "morning fog".into(),
            medium: medium.into(),
            side: Some(MediumSide::Interior),
            mixed: Mixed::default(),
            users: 1,
            boxes: Vec::new(),
            grids: Vec::new(),
        }],
        ..Inspected::new(entity(5), "box of fog")
    }))
}

pub fn camera() -> RgbImage {
    inspect(Some(Inspected {
        to_world: at(0.0, 1.6, 5.0),
        sensor: Some(Sensor::default()),
        film: Some(Film::default()),
        ..Inspected::new(entity(60), "from the door")
    }))
}
