use glam::Vec2;

use super::*;
use crate::material::MaterialId;

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
    // What has no samples yet has a preview with all light in it, or nothing.
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
