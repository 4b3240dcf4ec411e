//! A wall with a pattern of light, seen by a camera that moves.

use std::sync::Arc;

use glam::{Affine3A, UVec2, Vec2, Vec3};

use super::{Carried, CarriedTile, Clean, Earlier, Light, Reprojection, WORTH_OF_DENOISED, pixels_of, place_of};
use crate::color::{Rgb, luminance};
use crate::render::camera::Camera;
use crate::render::film::Film;
use crate::render::gbuffer::{Texel, TileGBuffer, middle_ray};
use crate::render::tile::{PixelSum, TILE, Tile, TileSamples, tiles};

const SIZE: UVec2 = UVec2::new(96, 64);
const WALL: f32 = 4.0;

fn camera(x: f32) -> Camera {
    Camera::new(
        Affine3A::from_translation(Vec3::new(x, 0.0, 0.0)),
        60.0,
        1.5,
        0.1,
        100.0,
        None,
    )
}

/// The light at the coordinate `x` of the wall.
fn pattern(x: f32) -> f32 {
    1.0 + 0.5 * (2.0 * x).sin()
}

/// The point on the wall at a pixel, and its distance.
fn place_on_wall(camera: &Camera, x: u32, y: u32) -> (Vec3, f32) {
    let ray = middle_ray(camera, SIZE.as_vec2(), x, y);
    let distance = WALL / ray.dir.z;
    (ray.at(distance), distance)
}

fn gbuffer(of: impl Fn(u32, u32) -> Texel) -> Vec<TileGBuffer> {
    let of_tile = |tile: Tile| TileGBuffer {
        tile,
        texels: pixels_of(tile).map(|(x, y)| of(x, y)).collect(),
        rays: 0,
    };
    tiles(SIZE.x, SIZE.y).into_iter().map(of_tile).collect()
}

fn wall(camera: &Camera, albedo: f32) -> Vec<TileGBuffer> {
    gbuffer(|x, y| Texel::new(place_on_wall(camera, x, y).1, -Vec3::Z, Rgb::splat(albedo), false))
}

/// A film of `samples` samples, whose pixels have this mean radiance, and its square as variance.
fn film(samples: u32, of: impl Fn(u32, u32) -> f32) -> Film {
    let mut film = Film::new(SIZE.x, SIZE.y);
    for tile in tiles(SIZE.x, SIZE.y) {
        let sum = |(x, y)| {
            let radiance = Rgb::splat(of(x, y));
            PixelSum {
                radiance: radiance * samples as f32,
                luminance_squared: 2.0 * luminance(radiance).powi(2) * samples as f32,
                ..PixelSum::default()
            }
        };
        let sums = pixels_of(tile).map(sum).collect();
        film.add(&TileSamples::of_pixels(tile, 0..samples, sums));
    }
    film
}

/// The wall in the colour `albedo`, seen by a camera at x = 0.
fn earlier(albedo: f32) -> Arc<Earlier> {
    let camera = camera(0.0);
    let film = film(64, |x, y| pattern(place_on_wall(&camera, x, y).0.x));
    let mut carried = Carried::begin(None, &camera, SIZE);
    add(&mut carried, wall(&camera, albedo));
    shown(&mut carried, &film);
    carried.into_earlier().expect("the G-buffer is whole")
}

fn add(carried: &mut Carried, gbuffer: Vec<TileGBuffer>) {
    for tile in gbuffer {
        carried.add(CarriedTile::find(carried.reprojection().map(Arc::as_ref), tile));
    }
}

/// The picture as displayed.
fn shown(carried: &mut Carried, film: &Film) -> Vec<Option<Rgb>> {
    blended(carried, film, None).0
}

/// The same with a denoised picture in place of the film, if given, and the tiles that still show carried light.
fn blended(carried: &mut Carried, film: &Film, clean: Option<Clean>) -> (Vec<Option<Rgb>>, Vec<Tile>) {
    let (mut picture, mut still_carried) = (vec![None; (SIZE.x * SIZE.y) as usize], Vec::new());
    let (blender, rows) = carried.rows();
    let tiles = tiles(SIZE.x, SIZE.y).into_iter().zip(rows.flatten());
    for (tile, own) in tiles {
        let mut is_carried = false;
        for y in tile.y..tile.y + tile.height {
            let places = place_of(SIZE, tile.x, y)..place_of(SIZE, tile.x + tile.width, y);
            let mut row = [None; TILE as usize];
            match clean {
                Some(clean) => (row.iter_mut().zip(&clean.radiance[places.clone()]))
                    .for_each(|(pixel, &light)| *pixel = Some(light)),
                None => film.mixed_row(tile, y, &[], &mut row),
            }
            let row = &mut row[..tile.width as usize];
            is_carried |= blender.blend_row(own.as_mut(), film, (tile, y), clean.map(|clean| clean.samples), row);
            picture[places].copy_from_slice(row);
        }
        still_carried.extend(is_carried.then_some(tile));
    }
    (picture, still_carried)
}

#[test]
fn light_stays_on_its_surface_when_the_camera_moves() {
    let moved = camera(0.3);
    let mut carried = Carried::begin(Some(earlier(0.5)), &moved, SIZE);
    let expected = |x, y| pattern(place_on_wall(&moved, x, y).0.x);
    let errors = |carried: &mut Carried| {
        let picture = shown(carried, &Film::new(SIZE.x, SIZE.y));
        let (mut errors, mut unknown) = (Vec::new(), 0);
        for (x, y) in pixels_of(whole()) {
            match picture[place_of(SIZE, x, y)] {
                Some(light) => errors.push((light.x - expected(x, y)).abs()),
                None => unknown += 1,
            }
        }
        errors.sort_by(f32::total_cmp);
        (errors[errors.len() * 4 / 5], unknown)
    };
    let (guessed, _) = errors(&mut carried);
    assert!(guessed < 0.05, "{guessed}");
    add(&mut carried, wall(&moved, 0.5));
    let (found, unknown) = errors(&mut carried);
    assert!(found < 0.01, "{found}");
    // Of a width of 4.6, the camera sees 0.3 for the first time.
    let share = unknown as f32 / (SIZE.x * SIZE.y) as f32;
    assert!((0.05..0.08).contains(&share), "{share}");
    assert!((carried.coverage() - (1.0 - share)).abs() < 1e-3);
}

#[test]
fn there_is_no_light_far_outside_of_the_film() {
    let reprojection = Reprojection::new(earlier(0.5), camera(0.0), SIZE);
    let found = |x: f32, y: f32| reprojection.between(Vec2::new(x, y), |_| true);
    assert!(found(0.5, 0.5).worth > 0.0);
    for far in [-1e30, 2.0, 1e9, 1e30, f32::INFINITY, f32::NAN] {
        assert_eq!(found(far, 0.5), Light::default(), "{far}");
        assert_eq!(found(0.5, far), Light::default(), "{far}");
    }
}

fn whole() -> Tile {
    Tile {
        x: 0,
        y: 0,
        width: SIZE.x,
        height: SIZE.y,
    }
}

#[test]
fn a_surface_of_another_colour_is_shown_in_that_at_once() {
    let mut carried = Carried::begin(Some(earlier(0.48)), &camera(0.0), SIZE);
    add(&mut carried, wall(&camera(0.0), 0.23));
    let picture = shown(&mut carried, &Film::new(SIZE.x, SIZE.y));
    for (x, y) in pixels_of(whole()) {
        let light = picture[place_of(SIZE, x, y)].expect("all of it is known").x;
        let expected = 0.5 * pattern(place_on_wall(&camera(0.0), x, y).0.x);
        assert!((light - expected).abs() < 0.02 * expected, "{light} {expected}");
    }
}

#[test]
fn what_is_new_in_the_picture_takes_over_nothing() {
    let still = camera(0.0);
    let mut carried = Carried::begin(Some(earlier(0.5)), &still, SIZE);
    let is_box = |x, y| (30..50).contains(&x) && (20..40).contains(&y);
    let texel = |x, y| {
        let (normal, distance) = (-Vec3::Z, place_on_wall(&still, x, y).1);
        let nearer = if is_box(x, y) { 0.8 } else { 1.0 };
        Texel::new(nearer * distance, normal, Rgb::splat(0.5), false)
    };
    add(&mut carried, gbuffer(texel));
    let picture = shown(&mut carried, &Film::new(SIZE.x, SIZE.y));
    for (x, y) in pixels_of(whole()) {
        assert_eq!(picture[place_of(SIZE, x, y)].is_none(), is_box(x, y), "{x} {y}");
    }
}

#[test]
fn the_film_alone_is_shown_once_it_is_worth_more() {
    let still = camera(0.0);
    let mut carried = Carried::begin(Some(earlier(0.5)), &still, SIZE);
    add(&mut carried, wall(&still, 0.5));
    let light = |x, y| 0.9 + 1e-3 * (x + 2 * y) as f32;
    let young = film(4, light);
    assert_ne!(shown(&mut carried, &young)[0], Some(Rgb::splat(light(0, 0))));
    // The earlier picture has 64 samples.
    let old = film(192, light);
    let expected: Vec<Option<Rgb>> = old.radiance().into_iter().map(Some).collect();
    assert_eq!(shown(&mut carried, &old), expected);
    let denoised = vec![Rgb::ONE; expected.len()];
    let clean = |samples| Clean {
        radiance: &denoised,
        samples,
    };
    let after = (3.0 * 64.0 / WORTH_OF_DENOISED) as u32;
    let alone: Vec<Option<Rgb>> = denoised.iter().copied().map(Some).collect();
    assert_eq!(
        blended(&mut carried, &young, Some(clean(after))),
        (alone.clone(), Vec::new())
    );
    let (mixed, still_carried) = blended(&mut carried, &young, Some(clean(1)));
    assert_ne!(mixed, alone);
    assert_eq!(still_carried, tiles(SIZE.x, SIZE.y));
}

/// Noise of mean 1 and a standard deviation of 1.
fn noise(x: u32, y: u32) -> f32 {
    let hash = (x.wrapping_mul(0x9e37_79b9) ^ y.wrapping_mul(0x85eb_ca6b)).wrapping_mul(0xc2b2_ae35);
    let hash = (hash ^ (hash >> 15)).wrapping_mul(0x27d4_eb2f);
    // Exponentially distributed.
    -(((hash >> 8) as f32 + 0.5) / (1 << 24) as f32).ln()
}

/// The mean of the picture, and that of a block in its centre, after a single noisy sample of every pixel in the light
/// `of`.
fn means_after_a_sample(of: impl Fn(u32, u32) -> f32) -> (f32, f32) {
    let still = camera(0.0);
    let mut carried = Carried::begin(Some(earlier(0.5)), &still, SIZE);
    add(&mut carried, wall(&still, 0.5));
    let film = film(1, |x, y| noise(x, y) * of(x, y));
    carried.learn(&tiles(SIZE.x, SIZE.y), &film);
    let picture = shown(&mut carried, &film);
    let mean = |area: Tile| {
        let light: Vec<f32> = pixels_of(area)
            .map(|(x, y)| picture[place_of(SIZE, x, y)].unwrap_or_default().x)
            .collect();
        light.iter().sum::<f32>() / light.len() as f32
    };
    (mean(whole()), mean(middle_block()))
}

fn middle_block() -> Tile {
    Tile {
        x: 36,
        y: 20,
        width: 8,
        height: 8,
    }
}

#[test]
fn light_that_has_not_changed_stays_as_it_was() {
    let still = camera(0.0);
    let unchanged = |x, y| pattern(place_on_wall(&still, x, y).0.x);
    let area =
        |tile: Tile| pixels_of(tile).map(|(x, y)| unchanged(x, y)).sum::<f32>() / (tile.width * tile.height) as f32;
    let (whole_mean, block) = means_after_a_sample(unchanged);
    assert!((whole_mean / area(whole()) - 1.0).abs() < 0.02, "{whole_mean}");
    assert!((block / area(middle_block()) - 1.0).abs() < 0.05, "{block}");
}

#[test]
fn a_dimmed_lamp_is_noticed_in_the_first_sample() {
    let still = camera(0.0);
    let (whole_mean, block) = means_after_a_sample(|x, y| 0.3 * pattern(place_on_wall(&still, x, y).0.x));
    assert!((0.28..0.36).contains(&whole_mean), "{whole_mean}");
    let before = pattern(place_on_wall(&still, 40, 24).0.x);
    assert!((0.2..0.45).contains(&(block / before)), "{block} of {before}");
}

#[test]
fn a_new_shadow_is_noticed_where_it_falls() {
    let still = camera(0.0);
    let is_shadow = |x: u32, y: u32| (32..48).contains(&x) && (16..32).contains(&y);
    let light = |x, y| {
        let shadow = if is_shadow(x, y) { 0.05 } else { 1.0 };
        shadow * pattern(place_on_wall(&still, x, y).0.x)
    };
    let (whole_mean, block) = means_after_a_sample(light);
    let before = pattern(place_on_wall(&still, 40, 24).0.x);
    assert!(block < 0.3 * before, "{block} of {before}");
    assert!(whole_mean > 0.85, "{whole_mean}");
}
