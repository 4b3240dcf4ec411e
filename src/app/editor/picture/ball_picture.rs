//! The finished pictures of material balls: denoised ones, and those of the library's materials that are shipped with
//! the program.
//!
//! `assets/library` holds the shipped ones: `balls.jpg` with the pictures in rows, and `balls.txt` with the key of each
//! material in a line. A material that has changed since has no picture there and is traced. `cargo run --release
//! --example make_assets -- balls` writes both files.

use std::collections::HashMap;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use bevy::math::Vec3;
use bevy_egui::egui::ColorImage;
use image::{ExtendedColorType, ImageFormat, RgbImage};
use rayon::prelude::*;

use super::material_ball::{BallMaterial, MaterialBall};
use crate::app::editor::command::material_tree::{MaterialTree, flattened};
use crate::app::editor::command::presets::{self, Preset};
use crate::app::editor::session::stable_hash::stable_hash;
use crate::color::Rgb;
use crate::engine::{pack_loose, pack_medium_without_files};
use crate::render::denoise::denoise_film;
use crate::render::film::Film;
use crate::render::tonemap::Display;
use crate::scene::LengthUnit;

/// The edge of a picture of the library in pixels: sharp at twice its size in points.
pub(crate) const EDGE: u32 = 128;
/// The samples per pixel of the shipped pictures.
const SAMPLES: u32 = 128;
/// The pictures in a row.
const COLUMNS: u32 = 10;

const ATLAS: &[u8] = include_bytes!("../../../../assets/library/balls.jpg");
const LIST: &str = include_str!("../../../../assets/library/balls.txt");

/// The radius of a ball in millimetres, on which its transparency depends.
const MILLIMETRES: f32 = 25.0;

/// The materials of presets as the kernel has them, in the same order.
pub(crate) fn looks(presets: &[Preset]) -> Vec<BallMaterial> {
    // The ball is a metre high.
    let trees: Vec<MaterialTree> = presets
        .iter()
        .map(|preset| preset.tree_in(LengthUnit::Metre, Vec3::Z))
        .collect();
    let (materials, outermost) = flattened(trees.iter());
    let (materials, textures, ids) = pack_loose(&materials);
    let (materials, textures) = (Arc::new(materials), Arc::new(textures));
    let looks = outermost.into_iter().zip(presets).map(|(place, preset)| BallMaterial {
        materials: materials.clone(),
        textures: textures.clone(),
        material: ids[place],
        inside: preset.medium_at(MILLIMETRES).as_ref().map(pack_medium_without_files),
    });
    looks.collect()
}

/// All inputs of the picture of a preset as text. Presets that look different have different keys.
pub(crate) fn key(preset: &Preset) -> String {
    let mut parts = format!("{:?}", preset.tree);
    if let Some(medium) = &preset.medium {
        parts += &format!("{medium:?} {MILLIMETRES}");
    }
    format!("ball {EDGE} {:016x}", stable_hash(parts.as_bytes()))
}

/// The shipped pictures, by [`key`].
pub(crate) fn shipped() -> HashMap<&'static str, ColorImage> {
    let Ok(atlas) = image::load_from_memory_with_format(ATLAS, ImageFormat::Jpeg) else {
        return HashMap::new();
    };
    let atlas = atlas.to_rgba8();
    let pictures = LIST.lines().enumerate().filter_map(|(place, line)| {
        let (key, _) = line.split_once('\t')?;
        let [x, y] = cell(place as u32);
        let is_inside = x + EDGE <= atlas.width() && y + EDGE <= atlas.height();
        let part = is_inside.then(|| image::imageops::crop_imm(&atlas, x, y, EDGE, EDGE).to_image())?;
        Some((key, ColorImage::from_rgba_unmultiplied([EDGE as usize; 2], &part)))
    });
    pictures.collect()
}

/// The upper left corner of a picture in the atlas.
fn cell(place: u32) -> [u32; 2] {
    [(place % COLUMNS) * EDGE, (place / COLUMNS) * EDGE]
}

/// Makes the two files of the folder `assets/library`: the pictures as JPEG, and the list. `show` is called with the
/// path of each preset when it has been rendered. The error says which preset cannot be rendered, or why the pictures
/// cannot be encoded.
pub fn make_shipped(show: impl Fn(&str) + Sync) -> Result<(Vec<u8>, String), String> {
    let presets = presets::built_in();
    let render = |(preset, look): (&Preset, BallMaterial)| {
        let (mut film, go_on) = (Film::new(EDGE, EDGE), AtomicBool::new(false));
        let ball = MaterialBall::new(&look, EDGE);
        let done = ball.and_then(|ball| ball.refine(&mut film, SAMPLES, &go_on));
        done.ok_or_else(|| format!("{} cannot be rendered", preset.path()))?;
        show(&preset.path());
        Ok(without_noise(&film, Some(1), &go_on))
    };
    let pictures: Result<Vec<Vec<Rgb>>, String> = presets.par_iter().zip(looks(&presets)).map(render).collect();
    let rows = (presets.len() as u32).div_ceil(COLUMNS);
    let mut atlas = RgbImage::new(COLUMNS * EDGE, rows * EDGE);
    let encoder = Display::default().encoder();
    for (place, pixels) in pictures?.iter().enumerate() {
        let [left, top] = cell(place as u32);
        for (index, radiance) in pixels.iter().enumerate() {
            let (x, y) = (index as u32 % EDGE, index as u32 / EDGE);
            atlas.put_pixel(left + x, top + y, image::Rgb(encoder.encode(*radiance)));
        }
    }
    let mut jpeg = Vec::new();
    const QUALITY: u8 = 93;
    image::codecs::jpeg::JpegEncoder::new_with_quality(&mut jpeg, QUALITY)
        .encode(&atlas, atlas.width(), atlas.height(), ExtendedColorType::Rgb8)
        .map_err(|error| error.to_string())?;
    let lines = presets
        .iter()
        .map(|preset| format!("{}\t{}\n", key(preset), preset.path()));
    Ok((jpeg, lines.collect()))
}

/// The denoised radiance, or the noisy one if there is no denoiser. `threads` is the number that the denoiser may use;
/// None is one for each core.
pub(crate) fn without_noise(film: &Film, threads: Option<usize>, cancel: &AtomicBool) -> Vec<Rgb> {
    denoise_film(film, threads, cancel).unwrap_or_else(|_| film.radiance())
}

#[cfg(test)]
mod tests {
    use super::*;
    use bevy_egui::egui::Color32;

    #[test]
    fn every_material_of_the_library_comes_with_its_picture() {
        let shipped = shipped();
        let presets = presets::built_in();
        let keys: Vec<String> = presets.iter().map(key).collect();
        for (preset, key) in presets.iter().zip(&keys) {
            let is_there = shipped.contains_key(key.as_str());
            assert!(
                is_there,
                "{} has changed: run `cargo run --release --example make_assets -- balls`",
                preset.path()
            );
        }
        assert_eq!(shipped.len(), presets.len());
        assert_eq!(LIST.lines().count(), presets.len());
    }

    #[test]
    fn another_material_has_another_key() {
        let mut preset = presets::built_in().swap_remove(0);
        let before = key(&preset);
        preset.name += " of another name";
        assert_eq!(key(&preset), before);
        preset.tree = preset.tree.wrapped("twosided");
        assert_ne!(key(&preset), before);
    }

    #[test]
    fn a_medium_belongs_to_the_key() {
        let mut preset = presets::built_in().pop().expect("one of the last group");
        let before = key(&preset);
        preset.medium.as_mut().expect("a medium").scale = 2.0;
        assert_ne!(key(&preset), before);
    }

    /// The mean of the pixels of some columns and rows, each component in [0, 255].
    fn mean(image: &ColorImage, [left, right]: [usize; 2], [top, bottom]: [usize; 2]) -> [f32; 3] {
        let places = (top..bottom).flat_map(|y| (left..right).map(move |x| (x, y)));
        let pixels: Vec<Color32> = places.map(|place| image[place]).collect();
        let sum = |component: fn(&Color32) -> u8| pixels.iter().map(|pixel| f32::from(component(pixel))).sum::<f32>();
        [sum(Color32::r), sum(Color32::g), sum(Color32::b)].map(|sum| sum / pixels.len() as f32)
    }

    #[test]
    fn the_pictures_show_what_the_kernel_traces() {
        let (presets, shipped) = (presets::built_in(), shipped());
        let looks = looks(&presets);
        // One of each group: the presets with the largest and the smallest differences between neighbours.
        for chunk in presets.chunk_by(|a, b| a.group == b.group) {
            let place = presets
                .iter()
                .position(|preset| preset == &chunk[0])
                .expect("it is one of them");
            let ball = MaterialBall::new(&looks[place], EDGE).expect("the material is there");
            let mut film = ball.film();
            // Noise makes the mean of displayed pixels darker, and subsurface scattering has much noise.
            let samples = if chunk[0].medium.is_some() { 256 } else { 16 };
            ball.refine(&mut film, samples, &AtomicBool::new(false))
                .expect("not cancelled");
            let mut rgba = vec![0; (4 * EDGE * EDGE) as usize];
            Display::default().encode_rgba(&film.radiance(), &mut rgba);
            let traced = ColorImage::from_rgba_unmultiplied([EDGE as usize; 2], &rgba);
            for [columns, rows] in [[[48, 80], [40, 72]], [[0, 32], [0, 32]], [[32, 96], [100, 124]]] {
                let picture = &shipped[key(&presets[place]).as_str()];
                let (known, traced) = (mean(picture, columns, rows), mean(&traced, columns, rows));
                let difference = known.iter().zip(traced).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max);
                assert!(difference < 6.0, "{}: {known:?} {traced:?}", presets[place].path());
            }
        }
    }
}
