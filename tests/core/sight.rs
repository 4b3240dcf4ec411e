//! What camera rays pass through: alike one by one and in lanes, and without a change of the light.

use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use crate::support::{SceneBuilder, camera, render, view};
use glam::{Affine3A, Quat, UVec2, Vec3};
use sunroom::accel::{Primitive, SplitMethod, Tlas};
use sunroom::color::Rgb;
use sunroom::light::LightSource;
use sunroom::math::Ray;
use sunroom::render::path::trace_path;
use sunroom::render::scene::RenderScene;
use sunroom::render::tile::{render_tile, tiles};
use sunroom::render::view::{Strategy, View};
use sunroom::render::visibility::sight::{CutPlane, Isolated, Sight};
use sunroom::shading::{Bsdf, Diffuse};

const FLOOR: u32 = 0;
const BALL: u32 = 1;
const NEAR_WALL: u32 = 2;

fn grey() -> Bsdf {
    Bsdf::Diffuse(Diffuse {
        reflectance: Rgb::splat(0.5),
    })
}

/// A room of squares whose fronts look inwards, with a ball and a sky that comes in where there is no ceiling. The
/// camera looks along -z from outside, through the near wall.
fn room() -> RenderScene {
    let mut room = SceneBuilder::default();
    let side = |at: Vec3, turned: Quat| Affine3A::from_scale_rotation_translation(Vec3::splat(2.0), turned, at);
    let quarter = std::f32::consts::FRAC_PI_2;
    let floor = side(Vec3::NEG_Y * 2.0, Quat::from_rotation_x(-quarter));
    room.add(Primitive::Rectangle, floor, grey(), None);
    let ball = Affine3A::from_translation(Vec3::NEG_Y);
    room.add(Primitive::Sphere, ball, grey(), None);
    let near = side(Vec3::Z * 2.0, Quat::from_rotation_y(2.0 * quarter));
    room.add(Primitive::Rectangle, near, grey(), None);
    let far = side(Vec3::NEG_Z * 2.0, Quat::IDENTITY);
    room.add(Primitive::Rectangle, far, grey(), None);
    room.light(LightSource::Constant { radiance: Rgb::ONE });
    room.build()
}

fn look(sight: Sight) -> View {
    View {
        sight,
        ..view(
            camera(Vec3::new(0.0, -0.5, 7.0), Vec3::NEG_Y * 0.5, 40.0),
            40,
            5,
            Strategy::Mis,
        )
    }
}

fn backs() -> Sight {
    Sight {
        passes_backs: true,
        ..Sight::default()
    }
}

fn cut(normal: Vec3, offset: f32) -> Sight {
    Sight {
        cut: Some(CutPlane { normal, offset }),
        ..Sight::default()
    }
}

fn alone(scene: &RenderScene, instance: u32) -> Sight {
    let shape = scene.geometry.instances()[instance as usize].clone();
    Sight {
        only: Some(Isolated(Arc::new(Tlas::build(vec![shape], SplitMethod::default())))),
        ..Sight::default()
    }
}

/// The instance in the middle of the picture.
fn in_the_middle(scene: &RenderScene, sight: Sight) -> Option<u32> {
    render(scene, &look(sight), 1).first_hit(20, 20).map(|hit| hit.instance)
}

#[test]
fn walls_between_the_camera_and_the_room_are_passed() {
    let scene = room();
    assert_eq!(in_the_middle(&scene, Sight::default()), Some(NEAR_WALL));
    assert_eq!(in_the_middle(&scene, backs()), Some(BALL));
    assert_eq!(in_the_middle(&scene, cut(Vec3::Z, 1.5)), Some(BALL));
    assert_eq!(in_the_middle(&scene, cut(Vec3::Z, 2.5)), Some(NEAR_WALL));
    // The ball ends at z = 1; below it there is the floor.
    assert_eq!(in_the_middle(&scene, alone(&scene, BALL)), Some(BALL));
    assert_eq!(in_the_middle(&scene, alone(&scene, FLOOR)), None);
}

#[test]
fn light_does_not_pass_with_the_camera() {
    // From within the room the near wall is in nobody's way; from outside it is only not seen.
    let scene = room();
    let seen = render(&scene, &look(backs()), 64);
    let without = cut(Vec3::Z, 1.9);
    let cut_open = render(&scene, &look(without), 64);
    let mean = |film: &sunroom::render::film::Film| {
        let all = film.radiance();
        let middle = (14..26).flat_map(|y| (14..26).map(move |x| all_index(x, y)));
        middle.map(|index| all[index].x).sum::<f32>() / 144.0
    };
    let (a, b) = (mean(&seen), mean(&cut_open));
    assert!((a - b).abs() < 0.02 * b, "{a} and {b}");
    // Were the wall gone, its light from the sky would come in.
    let mut open = SceneBuilder::default();
    open.light(LightSource::Constant { radiance: Rgb::ONE });
    let ball = Affine3A::from_translation(Vec3::NEG_Y);
    open.add(Primitive::Sphere, ball, grey(), None);
    let open = render(&open.build(), &look(Sight::default()), 64);
    assert!(mean(&open) > 1.1 * a, "{} and {a}", mean(&open));
}

fn all_index(x: usize, y: usize) -> usize {
    y * 40 + x
}

#[test]
fn lanes_see_what_single_paths_see() {
    let scene = room();
    let mut both = backs();
    both.cut = cut(Vec3::X, 0.4).cut;
    for sight in [Sight::default(), backs(), cut(Vec3::Z, 0.5), both, alone(&scene, BALL)] {
        let look = look(sight);
        let settings = look.integrator.settings();
        let (mut differ, mut total) = (0, 0);
        for tile in tiles(40, 40) {
            let found = render_tile(&scene, &look, tile, 0..1, &AtomicBool::new(false)).expect("not cancelled");
            let pixels = (tile.y..tile.y + tile.height)
                .flat_map(|y| (tile.x..tile.x + tile.width).map(move |x| UVec2::new(x, y)));
            for (place, pixel) in pixels.enumerate() {
                let start = look.camera_sample(pixel, 0);
                let ray = look.sight.narrow(&scene.geometry, start.ray);
                let expected = trace_path(&scene, &settings, ray, start.sampler, None, &mut ());
                let found = (
                    found.pixels[place].depth,
                    found.first_hits[place].map(|hit| hit.instance),
                );
                let is_same =
                    (found.0 - expected.depth).abs() < 1e-4 && found.1 == expected.first_hit.map(|hit| hit.instance);
                differ += u32::from(!is_same);
                total += 1;
            }
        }
        assert!(differ <= total / 200, "{differ} of {total} with {:?}", look.sight);
    }
}

#[test]
fn rays_stay_as_they_are_where_nothing_is_passed() {
    let scene = room();
    let ray = look(Sight::default()).camera_sample(UVec2::new(3, 4), 0).ray;
    assert_eq!(Sight::default().narrow(&scene.geometry, ray), ray);
    // Distances count from the camera, whatever is passed.
    let passed = backs().narrow(&scene.geometry, ray);
    assert_eq!(
        (passed.origin, passed.dir, passed.t_max),
        (ray.origin, ray.dir, ray.t_max)
    );
}

#[test]
fn a_plane_cuts_rays_from_either_side() {
    let plane = CutPlane {
        normal: Vec3::Y,
        offset: 1.0,
    };
    let ray = |y: f32, dir: Vec3| Ray {
        t_max: 10.0,
        ..Ray::new(Vec3::Y * y, dir)
    };
    let interval = |ray: Ray| {
        let part = plane.clip(ray);
        (part.t_min, part.t_max)
    };
    assert_eq!(interval(ray(3.0, Vec3::NEG_Y)), (2.0, 10.0));
    assert_eq!(interval(ray(-3.0, Vec3::Y)), (0.0, 4.0));
    assert_eq!(interval(ray(-3.0, Vec3::NEG_Y)), (0.0, 10.0));
    assert_eq!(interval(ray(-3.0, Vec3::X)), (0.0, 10.0));
    assert_eq!(interval(ray(3.0, Vec3::Y)).1, 0.0);
    assert_eq!(interval(ray(3.0, Vec3::X)).1, 0.0);
}
