//! What is carried over from an earlier picture goes where the scene has changed.

use std::f32::consts::PI;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use glam::{Affine3A, Quat, UVec2, Vec3};
use sunroom::accel::Primitive;
use sunroom::color::{Rgb, luminance};
use sunroom::render::carry::{Carried, CarriedTile, Earlier};
use sunroom::render::film::{Film, Moments};
use sunroom::render::gbuffer::render_gbuffer;
use sunroom::render::passes::pass_end;
use sunroom::render::scene::RenderScene;
use sunroom::render::tile::{TILE, Tile, render_tile, tiles};
use sunroom::render::view::{Strategy, View};
use sunroom::shading::{Bsdf, Conductor, ConductorSpecular, Diffuse};

use crate::support::{SceneBuilder, camera, render, view};

const SIZE: u32 = 64;
/// The samples of the picture after a change: so many there are in a window after about a second.
const SAMPLES: u32 = 16;
const BLOCK: u32 = 8;

fn diffuse(r: f32, g: f32, b: f32) -> Bsdf {
    Bsdf::Diffuse(Diffuse {
        reflectance: Rgb::new(r, g, b),
    })
}

fn mirror() -> Bsdf {
    Bsdf::Conductor(Conductor {
        specular: ConductorSpecular {
            eta: Rgb::ZERO,
            k: Rgb::ONE,
            specular_reflectance: Rgb::splat(0.9),
        },
    })
}

/// What changes in the room.
#[derive(Clone, Copy)]
struct Room {
    /// The place of a ball that shines.
    bright: Vec3,
    /// The strength of the lamp below the ceiling.
    lamp: f32,
    /// How far the door is open, from 0 to 1. Behind it is light.
    door: f32,
    /// The place of a ball that the mirror shows.
    seen: Vec3,
}

const ROOM: Room = Room {
    bright: Vec3::new(-0.5, -0.7, 0.2),
    lamp: 6.0,
    door: 0.0,
    seen: Vec3::new(0.1, -0.75, 0.6),
};

/// A room of five walls, open towards +z: the right one has a door, and a mirror stands at the rear.
fn scene(room: Room) -> RenderScene {
    let mut scene = SceneBuilder::default();
    let mut square = |scale: Vec3, turn: Quat, place: Vec3, material: Bsdf, light: Option<f32>| {
        let to_world = Affine3A::from_scale_rotation_translation(scale, turn, place);
        scene.add(Primitive::Rectangle, to_world, material, light.map(Rgb::splat));
    };
    let [up, down] = [-PI / 2.0, PI / 2.0].map(Quat::from_rotation_x);
    let [right, left] = [PI / 2.0, -PI / 2.0].map(Quat::from_rotation_y);
    square(Vec3::ONE, up, Vec3::NEG_Y, diffuse(0.6, 0.6, 0.6), None);
    square(Vec3::ONE, down, Vec3::Y, diffuse(0.7, 0.7, 0.7), None);
    square(Vec3::ONE, Quat::IDENTITY, Vec3::NEG_Z, diffuse(0.6, 0.6, 0.5), None);
    square(Vec3::ONE, right, Vec3::NEG_X, diffuse(0.6, 0.2, 0.2), None);
    square(
        Vec3::splat(0.2),
        down,
        Vec3::new(0.0, 0.99, 0.0),
        diffuse(0.0, 0.0, 0.0),
        Some(room.lamp),
    );
    // The right wall around a door, which slides upwards, and a lamp outside.
    let wall = diffuse(0.2, 0.5, 0.2);
    square(Vec3::new(0.3, 1.0, 1.0), left, Vec3::new(1.0, 0.0, 0.7), wall, None);
    square(Vec3::new(0.3, 1.0, 1.0), left, Vec3::new(1.0, 0.0, -0.7), wall, None);
    square(
        Vec3::new(0.4, 1.0, 1.0),
        left,
        Vec3::new(1.0, 2.0 * room.door, 0.0),
        wall,
        None,
    );
    square(
        Vec3::ONE,
        left,
        Vec3::new(2.0, 0.0, 0.0),
        diffuse(0.0, 0.0, 0.0),
        Some(4.0),
    );
    square(
        Vec3::new(0.4, 0.6, 1.0),
        Quat::from_rotation_y(0.3),
        Vec3::new(-0.4, -0.3, -0.8),
        mirror(),
        None,
    );
    let mut ball = |place: Vec3, material: Bsdf, light: Option<f32>| {
        let to_world = Affine3A::from_scale_rotation_translation(Vec3::splat(0.2), Quat::IDENTITY, place);
        scene.add(Primitive::Sphere, to_world, material, light.map(Rgb::splat));
    };
    ball(room.bright, diffuse(0.0, 0.0, 0.0), Some(3.0));
    ball(room.seen, diffuse(0.1, 0.2, 0.7), None);
    scene.build()
}

fn look(seed: u32) -> View {
    let camera = camera(Vec3::new(0.0, 0.0, 3.2), Vec3::ZERO, 40.0);
    View {
        seed,
        ..view(camera, SIZE, 8, Strategy::Mis)
    }
}

/// A picture of the scene that begins with the earlier one, without samples.
fn begin(earlier: Option<Arc<Earlier>>, scene: &RenderScene, view: &View) -> Carried {
    let mut carried = Carried::begin(earlier, &view.camera, UVec2::splat(SIZE));
    for tile in tiles(SIZE, SIZE) {
        let gbuffer = render_gbuffer(scene, view, tile, &AtomicBool::new(false)).expect("not cancelled");
        carried.add(CarriedTile::find(carried.reprojection().map(Arc::as_ref), gbuffer));
    }
    carried
}

/// Paints the picture; row by row.
fn paint(carried: &mut Carried, film: &Film) -> Vec<Rgb> {
    let mut picture = vec![Rgb::ZERO; (SIZE * SIZE) as usize];
    let (blender, rows) = carried.rows();
    for (tile, own) in tiles(SIZE, SIZE).into_iter().zip(rows.flatten()) {
        for y in tile.y..tile.y + tile.height {
            let mut row = [None; TILE as usize];
            film.mixed_row(tile, y, &[], &mut row);
            blender.blend_row(own.as_mut(), film, (tile, y), None, &mut row);
            for (x, pixel) in (tile.x..).zip(row) {
                picture[(y * SIZE + x) as usize] = pixel.unwrap_or_default();
            }
        }
    }
    picture
}

/// The picture of [`SAMPLES`] samples that is shown after a change of the room, the film alone, and the truth.
fn after(change: impl Fn(&mut Room)) -> (Vec<Rgb>, Film, Film) {
    let before = scene(ROOM);
    let mut carried = begin(None, &before, &look(1));
    paint(&mut carried, &render(&before, &look(1), 256));
    let mut room = ROOM;
    change(&mut room);
    let scene = scene(room);
    let view = look(2);
    let mut carried = begin(carried.into_earlier(), &scene, &view);
    let (mut film, mut done) = (Film::new(SIZE, SIZE), 0);
    while done < SAMPLES {
        let end = pass_end(done).min(SAMPLES);
        for tile in tiles(SIZE, SIZE) {
            film.add(&render_tile(&scene, &view, tile, done..end, &AtomicBool::new(false)).expect("not cancelled"));
            carried.learn(&[tile], &film);
        }
        paint(&mut carried, &film);
        done = end;
    }
    (paint(&mut carried, &film), film, render(&scene, &look(3), 1024))
}

/// The mean luminance of a block, and its variance.
fn block(film: &Film, place: UVec2) -> (f32, f32) {
    let (mut mean, mut variance) = (0.0, 0.0);
    for y in place.y..place.y + BLOCK {
        let tile = Tile {
            x: place.x / TILE * TILE,
            y: y / TILE * TILE,
            width: TILE,
            height: TILE,
        };
        let mut row = [Moments::default(); TILE as usize];
        film.moments_row(tile, y, &mut row);
        for pixel in &row[(place.x - tile.x) as usize..][..BLOCK as usize] {
            mean += luminance(pixel.radiance);
            variance += pixel.variance / pixel.samples as f32;
        }
    }
    let pixels = (BLOCK * BLOCK) as f32;
    (mean / pixels, variance / (pixels * pixels))
}

/// Fails where blocks are farther from the truth than their own samples would leave them in doubt. Returns the mean
/// squared errors of blocks of the picture as it is shown, and of the film alone.
#[track_caller]
fn assert_no_ghosts(change: impl Fn(&mut Room)) -> [f32; 2] {
    let (shown, film, truth) = after(change);
    let blocks = (0..SIZE / BLOCK).flat_map(|y| (0..SIZE / BLOCK).map(move |x| BLOCK * UVec2::new(x, y)));
    let (mut wrong, mut errors) = (Vec::new(), [0.0, 0.0]);
    for place in blocks {
        let ((own, variance), (expected, of_truth)) = (block(&film, place), block(&truth, place));
        let pixels = (0..BLOCK * BLOCK).map(|i| (place.y + i / BLOCK) * SIZE + place.x + i % BLOCK);
        let shown = pixels.map(|pixel| luminance(shown[pixel as usize])).sum::<f32>() / (BLOCK * BLOCK) as f32;
        for (error, light) in errors.iter_mut().zip([shown, own]) {
            *error += (light - expected).powi(2) / ((SIZE / BLOCK) * (SIZE / BLOCK)) as f32;
        }
        let deviation = (variance + of_truth).sqrt();
        if (shown - expected).abs() > 4.0 * deviation {
            wrong.push((place, shown, expected, deviation));
        }
    }
    assert!(wrong.is_empty(), "{wrong:?}");
    errors
}

#[test]
fn a_picture_in_which_nothing_changes_keeps_its_light() {
    let [shown, alone] = assert_no_ghosts(|_| {});
    assert!(shown < 0.25 * alone, "{shown} {alone}");
}

#[test]
fn a_bright_thing_that_was_moved_leaves_no_ghost() {
    assert_no_ghosts(|room| room.bright = Vec3::new(0.5, -0.2, 0.0));
}

#[test]
fn a_lamp_that_goes_off_leaves_no_light() {
    assert_no_ghosts(|room| room.lamp = 0.0);
}

#[test]
fn a_door_that_is_opened_lets_light_in() {
    assert_no_ghosts(|room| room.door = 0.8);
}

#[test]
fn a_mirror_shows_where_a_thing_is_now() {
    assert_no_ghosts(|room| room.seen = Vec3::new(-0.3, -0.75, 0.1));
}
