use glam::Vec2;

use super::*;
use crate::layer::{Layer, Layers};
use crate::material::MaterialId;
use crate::render::bytes::{Damaged, Reader, Writer};

fn hit(instance: u32) -> FirstHit {
    FirstHit {
        instance,
        material: MaterialId(0),
        uv: Vec2::ZERO,
    }
}

fn samples(tile: Tile, range: std::ops::Range<u32>, value: f32) -> TileSamples {
    let sum = PixelSum {
        radiance: Rgb::splat(value * range.len() as f32),
        ..PixelSum::default()
    };
    TileSamples {
        tile,
        samples: range.clone(),
        pixels: vec![sum; (tile.width * tile.height) as usize],
        blocks: None,
        layers: LayerSums::default(),
        first_hits: match range.start {
            0 => vec![Some(hit(1)); (tile.width * tile.height) as usize],
            _ => Vec::new(),
        },
        splats: Default::default(),
        rays: 0,
        invalid: 0,
    }
}

#[test]
fn tiles_cover_every_pixel_once() {
    let mut seen = vec![0; 70 * 33];
    for tile in tiles(70, 33) {
        for y in tile.y..tile.y + tile.height {
            for x in tile.x..tile.x + tile.width {
                seen[(y * 70 + x) as usize] += 1;
            }
        }
    }
    assert!(seen.iter().all(|&count| count == 1));
}

#[test]
fn samples_replace_the_preview_and_average() {
    let mut film = Film::new(40, 8);
    let [left, right] = tiles(40, 8)[..] else {
        panic!("two tiles")
    };
    assert_eq!(film.pixel(0, 0), None);
    let block = PixelSum {
        radiance: Rgb::splat(9.0),
        ..PixelSum::default()
    };
    film.add_preview(TilePreview {
        tile: left,
        step: 4,
        blocks: vec![block; 16],
        layers: LayerSums::default(),
        first_hits: (0..16).map(|i| (i != 15).then(|| hit(7))).collect(),
        rays: 0,
    });
    assert_eq!(film.pixel(31, 7).map(|p| p.radiance), Some(Rgb::splat(9.0)));
    assert_eq!((film.first_hit(0, 0), film.first_hit(31, 7)), (Some(hit(7)), None));
    film.add(&samples(left, 0..1, 1.0));
    film.add(&samples(left, 1..4, 3.0));
    assert_eq!(
        (film.first_hit(0, 0), film.first_hit(31, 7)),
        (Some(hit(1)), Some(hit(1)))
    );
    assert_eq!(film.pixel(0, 0).map(|p| p.radiance), Some(Rgb::splat(2.5)));
    assert_eq!((film.samples(0, 0), film.sample_count()), (4, 0));
    film.add(&samples(right, 0..4, 1.0));
    assert_eq!(film.sample_count(), 4);
    film.begin(40, 8, FilmLayers::default());
    assert_eq!((film.pixel(0, 0), film.sample_count()), (None, 0));
    assert_eq!(film.first_hit(0, 0), None);
    assert!(film.radiance().iter().all(|&radiance| radiance == Rgb::ZERO));
}

#[test]
fn chunks_keep_no_light_for_other_pixels() {
    let (mut film, tile) = (Film::new(8, 8), tiles(8, 8)[0]);
    let splats = || TileSplats {
        list: vec![
            crate::render::splats::Splat {
                pixel: glam::UVec2::ONE,
                radiance: Rgb::ONE,
            };
            16
        ],
        paths: 16 * 64,
    };
    let mut begun = 0;
    for start in (0..288).step_by(16) {
        film.add(&TileSamples {
            splats: splats(),
            ..samples(tile, start..start + 16, 1.0)
        });
        let chunks = film.begun.iter().flatten();
        begun += chunks.clone().count();
        assert!(
            chunks.into_iter().all(|chunk| chunk.splats == TileSplats::default()),
            "{start}"
        );
    }
    assert!(begun > 0, "chunks of several passes");
    assert_eq!(film.pixel(1, 1).expect("samples").radiance, Rgb::splat(2.0));
    // A pixel without samples has a preview with all light, or no colour.
    let mut film = Film::new(40, 8);
    film.add(&TileSamples {
        splats: splats(),
        ..samples(tiles(40, 8)[0], 0..16, 1.0)
    });
    assert_eq!(film.mixed_pixel(39, 0, &[]), None);
}

#[test]
fn a_film_of_another_size_has_nothing_of_the_old_picture() {
    let mut film = Film::new(40, 8);
    let groups_of = |groups: usize| FilmLayers {
        groups,
        ..FilmLayers::default()
    };
    for (width, height, groups) in [(16, 8, 2), (40, 33, 0), (2, 2, 1)] {
        for tile in tiles(film.width(), film.height()) {
            let pixels = (tile.width * tile.height) as usize;
            film.add(&TileSamples {
                layers: LayerSums {
                    values: vec![1.0; pixels * film.layers().values()],
                    ..LayerSums::default()
                },
                ..samples(tile, 0..2, 1.0)
            });
        }
        film.begin(width, height, groups_of(groups));
        assert_eq!(
            (film.width(), film.height(), film.layers()),
            (width, height, groups_of(groups))
        );
        assert_eq!(film.radiance(), vec![Rgb::ZERO; (width * height) as usize]);
        assert!((0..width).all(|x| film.pixel(x, height - 1).is_none() && film.first_hit(x, 0).is_none()));
        for tile in tiles(width, height) {
            let pixels = (tile.width * tile.height) as usize;
            film.add(&TileSamples {
                layers: LayerSums {
                    values: vec![0.5; pixels * 3 * groups],
                    ..LayerSums::default()
                },
                ..samples(tile, 0..1, 0.5)
            });
        }
        // The film is as a new one.
        assert_eq!(film.radiance(), vec![Rgb::splat(0.5); (width * height) as usize]);
        let doubled = vec![Rgb::splat(2.0); groups];
        let expected = if groups > 0 { groups as f32 } else { 0.5 };
        assert_eq!(
            film.mixed(&doubled),
            vec![Rgb::splat(expected); (width * height) as usize]
        );
    }
}

/// A chunk of the only tile of a small film, as in a share, without light. Each pixel has these ids, with their
/// samples, in each of its mattes.
fn bytes_of_chunk(kept: FilmLayers, samples: std::ops::Range<u32>, ids: &[[u32; 2]]) -> Vec<u8> {
    let mut to = Writer::default();
    // Chunks alone, of which there is one without first hits.
    to.put([0, 1, samples.start, samples.end, 0]);
    for _ in 0..8 * 8 {
        (0..12 + kept.values()).for_each(|_| to.put(0f32));
        for _ in 0..kept.matte_count() {
            to.put(ids.len() as u32);
            to.put_all(ids);
        }
    }
    to.0
}

#[test]
fn numbers_of_samples_that_cannot_be_are_damaged() {
    let tile = tiles(8, 8)[0];
    let most = bytes_of_chunk(FilmLayers::default(), 0..u32::MAX, &[]);
    let mut film = Film::new(8, 8);
    assert_eq!(film.read_tile(tile, &mut Reader(&most)), Ok(Some(u32::MAX)));
    assert_eq!(film.read_tile(tile, &mut Reader(&most)), Err(Damaged));

    let kept = FilmLayers {
        layers: Layers::of(&[Layer::CryptoObject]),
        ..FilmLayers::default()
    };
    assert_eq!(kept.matte_count(), 1);
    for (ids, is_possible) in [
        ([[7, 1], [8, 1]], true),
        ([[7, 2], [8, 1]], false),
        ([[7, 1], [7, u32::MAX]], false),
    ] {
        let bytes = bytes_of_chunk(kept, 0..2, &ids);
        let read = Film::with_layers(8, 8, kept).read_tile(tile, &mut Reader(&bytes));
        assert_eq!(read.is_ok(), is_possible, "{ids:?}");
    }

    // Sums of some samples before a chunk of one more. Without samples, an id of an older picture may remain.
    for (count, samples, is_possible) in [(2, 1, true), (2, 2, false), (1, 5, true), (0, 0, false)] {
        let mut to = Writer::default();
        to.put(1u32);
        for _ in 0..8 * 8 {
            to.put([0f32; 12]);
            to.put::<u32>(count);
            to.put([0f32; 2]);
            to.put(0u32);
            (0..kept.values()).for_each(|_| to.put(0f32));
            to.put::<[u32; 3]>([1, 7, samples]);
        }
        for _ in 0..BLOCKS {
            to.put([0u32; 6]);
        }
        to.0.extend(&bytes_of_chunk(kept, 1..2, &[[7, 1]])[4..]);
        let read = Film::with_layers(8, 8, kept).read_tile(tile, &mut Reader(&to.0));
        assert_eq!(read.is_ok(), is_possible, "{count} {samples}");
    }
}

/// A film with two groups and the layer of albedos: 16 samples of a complete chunk and 3 of an incomplete one, in which
/// the groups have 1 and 2, alternating with black samples, and the albedo is 0.5.
fn two_lamps() -> (Film, FilmLayers) {
    let kept = FilmLayers {
        groups: 2,
        layers: Layers::of(&[Layer::Albedo]),
        splats: false,
    };
    let mut film = Film::with_layers(40, 8, kept);
    for tile in tiles(40, 8) {
        for range in [0..16, 16..19] {
            let count = range.len() as f32;
            let mut new = samples(tile, range, 3.0);
            // Half of the samples have all of the light.
            let squares = count * 0.5 * luminance(Rgb::splat(6.0)).powi(2);
            new.pixels.iter_mut().for_each(|sum| sum.luminance_squared = squares);
            let one = [1.0, 1.0, 1.0, 2.0, 2.0, 2.0, 0.5, 0.5, 0.5].map(|value| value * count);
            new.layers.values = one.repeat(new.pixels.len());
            film.add(&new);
        }
    }
    (film, kept)
}

#[test]
fn lamps_go_and_come_back_and_leave_other_layers_alone() {
    let (mut film, kept) = two_lamps();
    let is_near = |film: &Film, light: f32, groups: &[f32]| {
        for (x, y) in [(0, 0), (31, 7), (39, 3)] {
            let pixel = film.pixel(x, y).expect("samples");
            assert!(
                (pixel.radiance - Rgb::splat(light)).abs().max_element() < 1e-5,
                "{pixel:?}"
            );
            let values = film.layer_values(x, y);
            let expected: Vec<f32> = groups
                .iter()
                .chain([&0.5])
                .flat_map(|value| [19.0 * value; 3])
                .collect();
            assert!(
                values.iter().zip(&expected).all(|(a, b)| (a - b).abs() < 1e-3),
                "{values:?}"
            );
            assert_eq!(values.len(), expected.len());
        }
    };
    is_near(&film, 3.0, &[1.0, 2.0]);
    let second = film.set_aside(1, 19);
    // A single group has no layer of its own.
    film.relight(0, &[(LightFrom::Layer(0), Rgb::splat(2.0))]);
    is_near(&film, 2.0, &[]);
    let first = film.set_aside(0, 19);
    film.relight(0, &[(LightFrom::Nowhere, Rgb::ZERO)]);
    is_near(&film, 0.0, &[]);
    film.relight(0, &[(LightFrom::Aside(&first), Rgb::splat(0.5))]);
    is_near(&film, 1.0, &[]);
    // The groups are exchanged.
    film.relight(
        2,
        &[(LightFrom::Aside(&second), Rgb::ONE), (LightFrom::Layer(0), Rgb::ONE)],
    );
    is_near(&film, 3.0, &[2.0, 1.0]);
    assert_eq!(film.layers(), kept);
    film.relight(2, &[(LightFrom::Layer(1), Rgb::ONE), (LightFrom::Layer(0), Rgb::ONE)]);
    is_near(&film, 3.0, &[1.0, 2.0]);
}

#[test]
fn light_that_comes_back_has_the_error_of_its_own_samples() {
    let (film, _) = two_lamps();
    let error_of = |samples| {
        let mut film = film.clone();
        let mut second = film.set_aside(1, 19);
        second.samples = samples;
        film.relight(2, &[(LightFrom::Layer(0), Rgb::ONE), (LightFrom::Nowhere, Rgb::ZERO)]);
        film.relight(
            2,
            &[(LightFrom::Layer(0), Rgb::ONE), (LightFrom::Aside(&second), Rgb::ONE)],
        );
        film.standard_error(0, 0).expect("samples")
    };
    let before = film.standard_error(0, 0).expect("samples");
    assert!((error_of(19) / before - 1.0).abs() < 0.01, "{before} {}", error_of(19));
    assert!(error_of(5) > 1.3 * error_of(19));
    // The result is the same after several removals and returns.
    let (mut film, _) = two_lamps();
    for _ in 0..10 {
        let second = film.set_aside(1, 19);
        film.relight(
            2,
            &[(LightFrom::Layer(0), Rgb::splat(0.5)), (LightFrom::Nowhere, Rgb::ZERO)],
        );
        film.relight(
            2,
            &[
                (LightFrom::Layer(0), Rgb::splat(2.0)),
                (LightFrom::Aside(&second), Rgb::ONE),
            ],
        );
    }
    let after = film.standard_error(0, 0).expect("samples");
    assert!((after / before - 1.0).abs() < 0.01, "{before} {after}");
}
