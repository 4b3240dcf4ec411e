//! Scenes far from the world's origin, where coordinates in single precision are coarse.

use crate::support::{SceneBuilder, mean_luminance, render, view};
use glam::{Affine3A, Mat3, Vec3};
use sunroom::accel::Primitive;
use sunroom::color::Rgb;
use sunroom::render::camera::{Camera, ThinLens};
use sunroom::render::film::Film;
use sunroom::render::view::Strategy;
use sunroom::shading::{Bsdf, Diffuse};

/// How far along each axis. Numbers of this size are multiples of 1/1024, and so are all coordinates of the room: there
/// it is exactly the same room.
const FAR: Vec3 = Vec3::new(8192.0, -8192.0, 8192.0);
const LENS: ThinLens = ThinLens {
    aperture_radius: 0.0625,
    focus_distance: 3.875,
    blades: 0,
    blade_rotation: 0.0,
};

/// A picture of a room of 2 units with a lamp below its ceiling and two balls on its floor, all of it moved.
fn room(moved: Vec3, lens: Option<ThinLens>, max_depth: u32, samples: u32) -> Film {
    let mut scene = SceneBuilder::default();
    let mut add = |primitive: Primitive, linear: Mat3, place: Vec3, reflectance: f32, radiance: Option<Rgb>| {
        let bsdf = Bsdf::Diffuse(Diffuse {
            reflectance: Rgb::splat(reflectance),
        });
        let to_world = Affine3A::from_mat3_translation(linear, place + moved);
        scene.add(primitive, to_world, bsdf, radiance);
    };
    // The third axis of a rectangle is its normal.
    let facing = |normal: Vec3| {
        let x = if normal.x == 0.0 { Vec3::X } else { Vec3::Y };
        Mat3::from_cols(x, normal.cross(x), normal)
    };
    for (normal, reflectance) in [
        (Vec3::Y, 0.7),
        (Vec3::NEG_Y, 0.7),
        (Vec3::Z, 0.7),
        (Vec3::X, 0.3),
        (Vec3::NEG_X, 0.5),
    ] {
        add(Primitive::Rectangle, facing(normal), -normal, reflectance, None);
    }
    let size = Mat3::from_diagonal(Vec3::new(0.25, 0.1875, 1.0));
    let below_ceiling = Vec3::Y * (1.0 - 1.0 / 128.0);
    let radiance = Some(Rgb::splat(20.0));
    add(
        Primitive::Rectangle,
        facing(Vec3::NEG_Y) * size,
        below_ceiling,
        0.0,
        radiance,
    );
    for (radius, place) in [
        (0.3125, Vec3::new(-0.375, -0.6875, -0.25)),
        (0.25, Vec3::new(0.375, -0.75, 0.375)),
    ] {
        add(
            Primitive::Sphere,
            Mat3::from_diagonal(Vec3::splat(radius)),
            place,
            0.7,
            None,
        );
    }
    let toward_back = Mat3::from_cols(Vec3::NEG_X, Vec3::Y, Vec3::NEG_Z);
    let pose = Affine3A::from_mat3_translation(toward_back, Vec3::Z * 3.875 + moved);
    let camera = Camera::new(pose, 39.3, 1.0, 1e-2, 1e4, lens);
    render(&scene.build(), &view(camera, 32, max_depth, Strategy::Mis), samples)
}

/// Fails unless the moved room has the same mean luminance within four standard errors and a part of `tolerance`.
fn assert_like_unmoved(what: &str, lens: Option<ThinLens>, max_depth: u32, samples: u32, tolerance: f32) {
    let [(here, error), (far, far_error)] =
        [Vec3::ZERO, FAR].map(|moved| mean_luminance(&room(moved, lens, max_depth, samples)));
    let allowed = 4.0 * error.hypot(far_error) + tolerance * here;
    assert!(
        (far - here).abs() < allowed,
        "{what}: {here} +- {error} in the origin, {far} +- {far_error} far from it"
    );
}

#[test]
fn camera_rays_meet_the_same_far_from_the_origin() {
    let [here, far] = [Vec3::ZERO, FAR].map(|moved| room(moved, None, 1, 64));
    let pairs = |a: Vec<f32>, b: Vec<f32>| a.into_iter().zip(b);
    for (here, far) in pairs(here.depth(), far.depth()) {
        assert!((here - far).abs() < 1e-5 * here, "{here} {far}");
    }
    let luminance = |film: &Film| film.radiance().iter().map(|rgb| rgb.x).collect::<Vec<f32>>();
    // The lamp is a narrow strip of the picture: a ray that is off by 1/1024 meets the ceiling.
    for (here, far) in pairs(luminance(&here), luminance(&far)) {
        assert!((here - far).abs() <= 1e-5 * here, "{here} {far}");
    }
}

#[test]
fn lenses_see_as_much_of_a_lamp_far_from_the_origin() {
    assert_like_unmoved("lens", Some(LENS), 1, 1024, 0.0);
}

#[test]
fn light_bounces_as_far_from_the_origin() {
    // Shadow rays begin some multiples of 1/1024 off their surfaces there, below a lamp and between balls and a floor.
    assert_like_unmoved("paths", None, 6, 1024, 1e-3);
}
