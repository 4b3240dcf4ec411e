//! Builds a scene in code and renders it with the kernel alone, without Bevy: `cargo run --release -p sunroom-core
//! --example build_scene`

use std::{error::Error, f32::consts::PI, sync::Arc, sync::atomic::AtomicBool};

use glam::{Affine3A, Vec3};
use sunroom_core::accel::{Instance, Primitive, SplitMethod, Tlas};
use sunroom_core::color::Rgb;
use sunroom_core::light::{LightSource, LightTable};
use sunroom_core::material::{MaterialId, MaterialTable};
use sunroom_core::render::image_io::{ImageRgb, write_image};
use sunroom_core::render::scene::{RenderScene, SurfaceSlot, SurfaceTable};
use sunroom_core::render::tile::{render_tile, tiles};
use sunroom_core::render::view::{Integrator, PathSettings, Shown, Strategy, View};
use sunroom_core::render::{camera::Camera, film::Film, filter::PixelFilter, tonemap::Display};
use sunroom_core::sampling::SequenceKind;
use sunroom_core::shading::{Bsdf, Diffuse, Metal};

fn main() -> Result<(), Box<dyn Error>> {
    let reflectance = Rgb::new(0.6, 0.55, 0.5);
    let (color, fuzz) = (Rgb::new(0.95, 0.75, 0.4), 0.2);
    let materials = vec![
        Bsdf::Diffuse(Diffuse { reflectance }).into(),
        Bsdf::Metal(Metal { color, fuzz }).into(),
    ];

    // A rectangle is [-1, 1] x [-1, 1] with the normal +z, which this turn directs upwards; a sphere has radius 1.
    let floor = Affine3A::from_rotation_x(-0.5 * PI) * Affine3A::from_scale(Vec3::splat(8.0));
    let at = |x, y, z| Affine3A::from_translation(Vec3::new(x, y, z));
    let shapes = [
        Instance::new(Primitive::Rectangle, floor),
        Instance::new(Primitive::Sphere, at(0.0, 1.0, 0.0)),
    ];
    // Each shape has one slot, which says what it is made of: here the material of its own number, no light, and
    // empty space on both sides.
    let slot = |material| SurfaceSlot {
        material: MaterialId(material),
        light: None,
        media: Default::default(),
    };
    let (first_slot, slots) = (vec![0, 1], (0..2).map(slot).collect());
    let radiance = Rgb::new(0.6, 0.8, 1.0);
    let sky = LightSource::Constant { radiance };

    // The five tables of a scene. Nothing in them changes while a picture is made.
    let geometry = Arc::new(Tlas::build(shapes.into_iter().flatten().collect(), SplitMethod::Sah));
    let textures = Arc::default();
    let lights = LightTable::build(&[sky.into()], &geometry, &textures);
    let scene = RenderScene {
        media: Arc::default(),
        reach: lights.reach(&geometry),
        lights: Arc::new(lights),
        surfaces: Arc::new(SurfaceTable { first_slot, slots }),
        materials: Arc::new(MaterialTable::new(materials)?),
        textures,
        geometry,
    };

    // The camera looks along its +z: after half a turn about y that is the world's -z.
    let (width, height) = (480, 320);
    let pose = at(0.0, 1.3, 7.0) * Affine3A::from_rotation_y(PI);
    let view = View {
        camera: Camera::new(pose, 40.0, width as f32 / height as f32, 1e-2, 1e4, None),
        film_camera: None,
        width,
        height,
        medium: None,
        filter: PixelFilter::Box,
        integrator: Integrator::Path(PathSettings {
            max_depth: 8,
            rr_depth: 5,
            hide_emitters: false,
            media: false,
            strategy: Strategy::Mis,
        }),
        shown: Shown::Radiance,
        sight: Default::default(),
        light_groups: Default::default(),
        layers: Default::default(),
        before: None,
        sequence: SequenceKind::Sobol,
        seed: 0,
        photons: Default::default(),
        clamp: None,
        guide: None,
    };
    // A tile is a pure function of its arguments: tiles may be rendered in any order, on any threads.
    let mut film = Film::new(width, height);
    for tile in tiles(width, height) {
        film.add(&render_tile(&scene, &view, tile, 0..64, &AtomicBool::new(false)).ok_or("cancelled")?);
    }
    let pixels = film.radiance();
    let image = ImageRgb { width, height, pixels };
    Ok(write_image("build_scene.png".as_ref(), &image, &Display::default())?)
}
