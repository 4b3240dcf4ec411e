//! Makes the thumbnails of picture files for panels.

use std::collections::HashMap;
use std::path::PathBuf;
use std::sync::{Arc, Weak};

use bevy::prelude::*;
use bevy_egui::{EguiContexts, egui};

use super::panel_textures::Thumbnail;
use super::{EditorModel, Model};
use crate::render::tonemap::{Display, Encoder};
use crate::scene::{Emitter, Material, Parameter, Pictures, Texture, TextureMap};
use crate::texture::Image;

/// The longer edge of a thumbnail in pixels: sharp in a tooltip, too.
const EDGE: u32 = 96;

struct Made {
    /// A weak pointer keeps the address, so that no other picture can be taken for it, but not the pixels.
    of: Weak<Image>,
    texture: egui::TextureHandle,
    size: [u32; 2],
}

#[derive(Resource, Default)]
pub(crate) struct Thumbnails(HashMap<PathBuf, Made>);

/// Makes the thumbnails of the inspected thing, and drops those that are no longer shown.
pub(crate) fn update_thumbnails(
    mut thumbnails: ResMut<Thumbnails>,
    mut model: ResMut<EditorModel>,
    mut contexts: EguiContexts,
    pictures: Res<Pictures>,
    maps: Res<Assets<TextureMap>>,
) -> Result {
    let wanted = pictures_of(&model.0);
    thumbnails.0.retain(|path, _| wanted.contains(path));
    for path in wanted {
        let image = pictures
            .get(&path)
            .and_then(|handle| maps.get(handle))
            .map(|map| &map.image);
        let Some(image) = image else {
            thumbnails.0.remove(&path);
            continue;
        };
        let is_made = |made: &Made| made.of.as_ptr() == Arc::as_ptr(image);
        if !thumbnails.0.get(&path).is_some_and(is_made) {
            let small = shrunk(image, EDGE, &Display::default().encoder());
            let texture = contexts
                .ctx_mut()?
                .load_texture(path.to_string_lossy(), small, egui::TextureOptions::LINEAR);
            let made = Made {
                of: Arc::downgrade(image),
                texture,
                size: [image.width(), image.height()],
            };
            thumbnails.0.insert(path, made);
        }
    }
    let shown = thumbnails.0.iter().map(|(path, made)| {
        let thumbnail = Thumbnail {
            texture: made.texture.id(),
            size: made.size,
        };
        (path.clone(), thumbnail)
    });
    model.0.textures.pictures = shown.collect();
    Ok(())
}

/// The pictures of the inspected thing.
fn pictures_of(model: &Model) -> Vec<PathBuf> {
    let mut found = Vec::new();
    let Some(inspected) = &model.inspected else {
        return found;
    };
    for entry in &inspected.materials {
        material_pictures(&entry.material, &mut found);
    }
    if let Some(Parameter::Texture(texture)) = inspected.area_light.as_ref().map(|light| &light.radiance) {
        texture_pictures(texture, &mut found);
    }
    if let Some(emitter) = &inspected.emitter {
        emitter_pictures(emitter, &mut found);
    }
    found.sort();
    found.dedup();
    found
}

fn material_pictures(material: &Material, found: &mut Vec<PathBuf>) {
    material.for_each_texture(&mut |texture| texture_pictures(texture, found));
}

fn texture_pictures(texture: &Texture, found: &mut Vec<PathBuf>) {
    texture.for_each_bitmap(&mut |bitmap| found.push(bitmap.path.clone()));
}

fn emitter_pictures(emitter: &Emitter, found: &mut Vec<PathBuf>) {
    emitter.for_each_picture(&mut |path| found.push(path.clone()));
}

/// The picture with its longer edge at most `edge` pixels, each the mean of a few pixels of the picture.
pub(crate) fn shrunk(image: &Image, edge: u32, encoder: &Encoder) -> egui::ColorImage {
    /// Samples per pixel along each edge: enough that lines do not vanish, few enough for pictures of any size.
    const SAMPLES: u32 = 3;
    let longer = image.width().max(image.height());
    let scaled = |side: u32| (u64::from(side) * u64::from(edge.min(longer)) / u64::from(longer)).max(1) as u32;
    let (width, height) = (scaled(image.width()), scaled(image.height()));
    let mut pixels = Vec::with_capacity((width * height) as usize);
    for y in 0..height {
        for x in 0..width {
            let place = |at: u32, look: u32, size: u32, from: u32| {
                let step = u64::from(at * SAMPLES + look) * 2 + 1;
                (step * u64::from(from) / (2 * u64::from(size * SAMPLES))) as u32
            };
            let samples = (0..SAMPLES).flat_map(|v| (0..SAMPLES).map(move |u| (u, v)));
            let sum: bevy::math::Vec3 = samples
                .map(|(u, v)| image.pixel(place(x, u, width, image.width()), place(y, v, height, image.height())))
                .sum();
            let [r, g, b] = encoder.encode(sum / (SAMPLES * SAMPLES) as f32);
            pixels.push(egui::Color32::from_rgb(r, g, b));
        }
    }
    egui::ColorImage::new([width as usize, height as usize], pixels)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::texture::{Samples, Transfer};

    fn picture(width: u32, height: u32, of: impl Fn(u32, u32) -> f32) -> Image {
        let values = (0..height).flat_map(|y| (0..width).map(move |x| (x, y)));
        let samples = values.map(|(x, y)| of(x, y)).collect();
        Image::new(width, height, 1, Samples::F32(samples), Transfer::Linear).expect("as many samples as pixels")
    }

    fn small(image: &Image) -> egui::ColorImage {
        shrunk(image, EDGE, &Display::default().encoder())
    }

    #[test]
    fn thumbnails_keep_the_shape_of_their_pictures() {
        let wide = small(&picture(1000, 10, |_, _| 0.5));
        assert_eq!(wide.size, [96, 1]);
        assert_eq!(small(&picture(3, 2, |_, _| 0.5)).size, [3, 2]);
        assert!(wide.pixels.iter().all(|pixel| pixel.r() == 188), "0.5 is 188 in sRGB");
    }

    #[test]
    fn left_stays_left_and_top_stays_top() {
        let small = small(&picture(200, 200, |x, y| if x < 100 && y < 100 { 1.0 } else { 0.0 }));
        let at = |x: usize, y: usize| small.pixels[y * 96 + x].r();
        assert_eq!([at(10, 10), at(80, 10), at(10, 80), at(80, 80)], [255, 0, 0, 0]);
    }
}
