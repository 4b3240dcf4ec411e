//! From the film to the bytes on the screen: which of its quantities is shown, and how it becomes a colour. No rendering, no Bevy.

use crate::color::Rgb;
use crate::render::film::Film;
use crate::render::tile::{PixelSum, Tile};
use crate::render::tonemap::{Display, ToneMap};

/// Everything that decides how the film is shown; changing it needs no new samples.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DisplaySettings {
    pub mode: DisplayMode,
    /// Stops: the radiance is multiplied by two to this power.
    pub exposure: f32,
    pub tone_map: ToneMap,
}

impl Default for DisplaySettings {
    fn default() -> Self {
        Self {
            mode: DisplayMode::Shaded,
            exposure: 0.0,
            tone_map: ToneMap::default(),
        }
    }
}

impl DisplaySettings {
    /// The part that turns a radiance into a colour of the display.
    pub fn tone(&self) -> Display {
        Display {
            exposure_ev: self.exposure,
            tone_map: self.tone_map,
        }
    }
}

#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum DisplayMode {
    #[default]
    Shaded,
    Albedo,
    Normal,
    /// Near is bright.
    Depth,
    /// How much of the acceleration structure each camera ray visits, in false colour.
    BvhSteps,
}

impl DisplayMode {
    pub const ALL: [(Self, &'static str); 5] = [
        (Self::Shaded, "Shaded"),
        (Self::Albedo, "Albedo"),
        (Self::Normal, "Normal"),
        (Self::Depth, "Depth"),
        (Self::BvhSteps, "BVH steps"),
    ];

    /// The one after this, round and round.
    pub fn next(self) -> Self {
        let place = Self::ALL.iter().position(|(mode, _)| *mode == self).unwrap_or(0);
        Self::ALL[(place + 1) % Self::ALL.len()].0
    }

    pub fn name(self) -> &'static str {
        Self::ALL
            .iter()
            .find(|(mode, _)| *mode == self)
            .map_or("", |(_, name)| name)
    }
}

/// The steps that the heat map paints in its hottest colour.
pub const HOTTEST_STEPS: f32 = 128.0;

/// The sRGB bytes of one pixel.
pub fn encode(pixel: &PixelSum, settings: &DisplaySettings, scene_size: f32) -> [u8; 4] {
    match settings.mode {
        DisplayMode::Shaded => shaded(pixel.radiance, settings),
        DisplayMode::Albedo => opaque(Display::default().encode(pixel.albedo)),
        // The usual picture of normals: taken as encoded values, not as light.
        DisplayMode::Normal => opaque((0.5 * pixel.normal + 0.5).to_array().map(quantized)),
        DisplayMode::Depth => opaque([quantized(nearness(pixel.depth, scene_size)); 3]),
        DisplayMode::BvhSteps => opaque(heat(pixel.radiance.x / HOTTEST_STEPS).map(quantized)),
    }
}

/// The sRGB bytes of a radiance.
pub fn shaded(radiance: Rgb, settings: &DisplaySettings) -> [u8; 4] {
    opaque(settings.tone().encode(radiance))
}

/// 1 at the camera, falling with the distance; 0 where nothing was hit.
fn nearness(depth: f32, scene_size: f32) -> f32 {
    if depth > 0.0 {
        (-depth / scene_size.max(f32::MIN_POSITIVE)).exp()
    } else {
        0.0
    }
}

/// Black, blue, red, yellow, white for 0 to 1; sRGB-encoded.
pub fn heat(x: f32) -> [f32; 3] {
    const STOPS: [[f32; 3]; 5] = [
        [0.0, 0.0, 0.05],
        [0.15, 0.1, 0.75],
        [0.85, 0.15, 0.25],
        [1.0, 0.8, 0.1],
        [1.0, 1.0, 1.0],
    ];
    let x = if x > 0.0 {
        x.min(1.0) * (STOPS.len() - 1) as f32
    } else {
        0.0
    };
    let below = (x as usize).min(STOPS.len() - 2);
    let t = x - below as f32;
    std::array::from_fn(|channel| STOPS[below][channel] * (1.0 - t) + STOPS[below + 1][channel] * t)
}

fn opaque([r, g, b]: [u8; 3]) -> [u8; 4] {
    [r, g, b, u8::MAX]
}

/// [0, 1] to a byte; NaN becomes 0.
fn quantized(encoded: f32) -> u8 {
    (encoded * 255.0 + 0.5) as u8
}

/// Writes what the film has in `tiles` into `rgba` (row-major, as large as the film). Pixels the film has nothing for stay as they are.
pub fn paint(film: &Film, tiles: &[Tile], settings: &DisplaySettings, scene_size: f32, rgba: &mut [u8]) {
    let width = film.width() as usize;
    // Within a preview's block neighbours are equal: most of its pixels need no tone mapping.
    let mut last = (PixelSum::default(), encode(&PixelSum::default(), settings, scene_size));
    for tile in tiles {
        for y in tile.y..tile.y + tile.height {
            for x in tile.x..tile.x + tile.width {
                let start = 4 * (y as usize * width + x as usize);
                let (Some(pixel), Some(target)) = (film.pixel(x, y), rgba.get_mut(start..start + 4)) else {
                    continue;
                };
                if pixel != last.0 {
                    last = (pixel, encode(&pixel, settings, scene_size));
                }
                target.copy_from_slice(&last.1);
            }
        }
    }
}

/// Writes a whole picture of radiance into `rgba`.
pub fn paint_radiance(radiance: &[Rgb], settings: &DisplaySettings, rgba: &mut [u8]) {
    settings.tone().encode_rgba(radiance, rgba);
}

/// A picture of one size shown at another until the new one is there: nearest neighbours.
pub fn resized(rgba: &[u8], from: [u32; 2], to: [u32; 2]) -> Vec<u8> {
    let [width, height] = to.map(|n| n as usize);
    let mut resized = vec![0; 4 * width * height];
    for (place, target) in resized.chunks_exact_mut(4).enumerate() {
        let (x, y) = (place % width, place / width);
        let source = (y * from[1] as usize / height) * from[0] as usize + x * from[0] as usize / width;
        match rgba.get(4 * source..4 * source + 4) {
            Some(color) => target.copy_from_slice(color),
            None => target[3] = u8::MAX,
        }
    }
    resized
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::render::tile::{TilePreview, tiles};

    #[test]
    fn only_pixels_with_something_to_show_are_painted() {
        let mut film = Film::new(64, 32);
        let tiles = tiles(64, 32);
        film.add_preview(&TilePreview {
            tile: tiles[1],
            step: 32,
            blocks: vec![PixelSum {
                radiance: Rgb::splat(100.0),
                ..PixelSum::default()
            }],
            first_hits: vec![None],
            rays: 0,
        });
        let mut rgba = vec![7; 4 * 64 * 32];
        paint(&film, &tiles, &DisplaySettings::default(), 1.0, &mut rgba);
        assert_eq!(rgba[..4], [7; 4]);
        assert_eq!(rgba[4 * 32..4 * 32 + 4], [255; 4]);
    }

    #[test]
    fn a_stop_doubles() {
        let plain = DisplaySettings::default();
        let brighter = DisplaySettings { exposure: 1.0, ..plain };
        assert_eq!(shaded(Rgb::splat(0.2), &brighter), shaded(Rgb::splat(0.4), &plain));
        assert_ne!(shaded(Rgb::splat(0.2), &plain), shaded(Rgb::splat(0.4), &plain));
    }

    #[test]
    fn resizing_keeps_corners_and_is_opaque() {
        let quarters = [[1, 0, 0, 255], [2, 0, 0, 255], [3, 0, 0, 255], [4, 0, 0, 255]].concat();
        let large = resized(&quarters, [2, 2], [4, 4]);
        assert_eq!((large[0], large[4 * 3], large[4 * 12], large[4 * 15]), (1, 2, 3, 4));
        assert!(
            resized(&[], [0, 0], [2, 1])
                .chunks(4)
                .all(|pixel| pixel == [0, 0, 0, 255])
        );
    }

    #[test]
    fn modes_go_round() {
        let mut mode = DisplayMode::Shaded;
        for _ in 0..DisplayMode::ALL.len() {
            mode = mode.next();
        }
        assert_eq!(mode, DisplayMode::Shaded);
        assert_eq!(DisplayMode::Shaded.next(), DisplayMode::Albedo);
    }

    #[test]
    fn heat_rises() {
        let sum = |x: f32| heat(x).iter().sum::<f32>();
        assert!(sum(0.0) < sum(0.3) && sum(0.3) < sum(0.8) && sum(0.8) < sum(1.0));
        assert_eq!(heat(f32::NAN), heat(0.0));
        assert_eq!(heat(9.0), heat(1.0));
    }
}
