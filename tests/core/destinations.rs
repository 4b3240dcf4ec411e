//! Where the light of lamps goes: solid angles, and closed rooms in which nothing gets lost.

use std::f32::consts::PI;

use crate::breakdown::{diffuse, two_bulbs};
use crate::support::SceneBuilder;
use glam::{Affine3A, Quat, Vec3};
use sunroom::accel::Primitive;
use sunroom::color::Rgb;
use sunroom::light::LightSource;
use sunroom::material::Material;
use sunroom::render::breakdown::{Progress, destinations};

/// A point lamp over a disk in empty space sends its solid angle's part there, and the rest leaves.
#[test]
fn a_disk_takes_the_solid_angle_of_a_lamp() {
    let albedo = 0.3;
    let mut scene = SceneBuilder::default();
    scene.add(Primitive::Disk, Affine3A::IDENTITY, diffuse(albedo), None);
    // Nothing arrives at an invisible border around both.
    let border = Affine3A::from_scale(Vec3::splat(5.0));
    scene.add(Primitive::Sphere, border, Material::Null, None);
    scene.light(LightSource::Point {
        position: Vec3::Z,
        intensity: Rgb::splat(2.0),
    });
    let (scene, (_, look)) = (scene.build(), two_bulbs());
    let found = destinations(&scene, &look, 1 << 15, &Progress::default()).expect("it is not cancelled");
    let near = |[value, error]: [f32; 2], expected: f32| {
        let most = 4.5 * error + 1e-5 * expected;
        assert!(
            (value - expected).abs() < most,
            "{value} ± {error}, expected {expected}"
        );
    };
    let power = 8.0 * PI;
    near(found.emitted(), power);
    assert_eq!(found.paths(), 1 << 15);
    let few = destinations(&scene, &look, 4, &Progress::default()).expect("it is not cancelled");
    assert_eq!(few.paths(), 32);
    let solid_angle = 0.5 * (1.0 - 0.5_f32.sqrt());
    let disk = found.by(|instance| instance);
    assert_eq!(disk.len(), 1);
    near([disk[0].share, disk[0].share_error], solid_angle * (1.0 - albedo));
    near([disk[0].received, disk[0].received_error], solid_angle * power);
    near(found.escaped(), 1.0 - solid_angle * (1.0 - albedo));
}

/// In a closed room nothing gets lost, and walls of reflectance r receive 1 / (1 - r) times the light of the lamp.
#[test]
fn all_light_stays_in_a_closed_room() {
    let albedo = 0.5;
    let mut scene = SceneBuilder::default();
    let room = Affine3A::from_scale(Vec3::splat(3.0));
    scene.add(Primitive::Sphere, room, diffuse(albedo), None).flip_normals = true;
    let lamp = Affine3A::from_scale_rotation_translation(Vec3::splat(0.2), Quat::IDENTITY, Vec3::X);
    scene.add(Primitive::Sphere, lamp, diffuse(0.0), Some(Rgb::ONE));
    let (scene, (_, look)) = (scene.build(), two_bulbs());
    let found = destinations(&scene, &look, 1 << 15, &Progress::default()).expect("it is not cancelled");
    let [emitted, error] = found.emitted();
    let expected = 4.0 * PI * 0.04 * PI;
    assert!(
        (emitted - expected).abs() < 4.5 * error + 1e-4 * expected,
        "{emitted} ± {error}"
    );
    let things = found.by(|instance| instance);
    let [escaped, _] = found.escaped();
    assert_eq!(escaped, 0.0);
    let shares: f32 = things.iter().map(|thing| thing.share).sum();
    assert!((shares - 1.0).abs() < 1e-5, "{things:?}");
    let [walls, lamp] = &things[..] else {
        panic!("{things:?}");
    };
    // What the walls send back is absorbed by the black lamp, or by themselves.
    let most = 4.5 * walls.received_error + 1e-4 * emitted;
    let received = emitted * (1.0 - lamp.share) / (1.0 - albedo);
    assert!((walls.received - received).abs() < most, "{walls:?} {received}");
    assert!(lamp.share > 3.0 * lamp.share_error, "{lamp:?}");
}
