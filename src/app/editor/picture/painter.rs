//! Paints the film as bytes of the screen, in every display mode. It uses neither the renderer nor Bevy.

use rayon::prelude::*;

use super::compare::PixelComparison;
use super::false_colour::{brightest, depth_range, illuminance, photometric};
use crate::app::editor::command::display::{
    DisplayMode, DisplaySettings, HOTTEST_DEPTH, HOTTEST_NOISE, HOTTEST_STEPS, heat,
};
use crate::color::{Rgb, luminance};
use crate::render::carry::{Blender, Carried, CarriedTile, Clean};
use crate::render::film::Film;
use crate::render::noise::DARK;
use crate::render::tile::{PixelSum, TILE, Tile};
use crate::render::tonemap::{Display, Encoder};

/// The inputs of colours besides the film and the settings. When they change, all pixels do.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Scales {
    /// The nearest and farthest depth of the picture.
    pub depth: [f32; 2],
    /// The most samples of any pixel.
    pub most_samples: u32,
    /// The luminance in cd/m², or the illuminance in lux, of the hottest colour.
    pub brightest: f32,
    /// The factors on the layers of the film; an empty list is the picture as sampled.
    pub mix: Vec<Rgb>,
}

/// The change of a range of depths, as a share, below which the old range stays: every sample moves it a little.
const STEADY: f32 = 0.05;

impl Scales {
    /// The scales of the present film. `mix` is as in [`Self::mix`], `before` are the last scales.
    pub fn of(film: &Film, mode: DisplayMode, mix: Vec<Rgb>, before: &Self) -> Self {
        match mode {
            DisplayMode::Depth => {
                let depth = depth_range(film);
                let slack = STEADY * (before.depth[1] - before.depth[0]);
                let is_steady = (0..2).all(|end| (depth[end] - before.depth[end]).abs() < slack);
                Self {
                    depth: if is_steady { before.depth } else { depth },
                    ..Self::default()
                }
            }
            DisplayMode::Samples => Self {
                most_samples: film.most_samples(),
                ..Self::default()
            },
            DisplayMode::Luminance | DisplayMode::Illuminance => Self {
                brightest: brightest(film),
                ..Self::default()
            },
            DisplayMode::Shaded => Self { mix, ..Self::default() },
            DisplayMode::LightGroup(group) => Self {
                mix: (0..film.layers().groups)
                    .map(|layer| {
                        if layer == usize::from(group) {
                            Rgb::ONE
                        } else {
                            Rgb::ZERO
                        }
                    })
                    .collect(),
                ..Self::default()
            },
            _ => Self::default(),
        }
    }
}

/// The least number of tiles that several threads paint.
const MANY: usize = 64;

/// A row of tiles of the picture, and the tiles of it that are to be painted.
struct Band<'a> {
    rgba: &'a mut [u8],
    tiles: Vec<Tile>,
    carried: &'a mut [Option<CarriedTile>],
}

/// Turns the film's pixels into colours.
pub struct Painter<'a> {
    film: &'a Film,
    mode: DisplayMode,
    scales: &'a Scales,
    tone: Encoder,
    plain: Encoder,
    /// The mean luminance of the picture, only in the display of noise.
    brightness: f32,
    /// The comparison of light.
    comparison: Option<PixelComparison<'a>>,
    /// The denoised picture.
    denoised: Option<Clean<'a>>,
}

impl<'a> Painter<'a> {
    /// A painter for the present state of the film.
    pub fn new(film: &'a Film, settings: &DisplaySettings, scales: &'a Scales) -> Self {
        let brightness = match settings.mode {
            DisplayMode::Noise => mean_luminance(film),
            _ => 0.0,
        };
        Self {
            film,
            mode: settings.mode,
            scales,
            tone: settings.tone().encoder(),
            plain: Display::default().encoder(),
            brightness,
            comparison: None,
            denoised: None,
        }
    }

    /// The painter that compares light with that of a snapshot.
    pub(crate) fn compared(self, comparison: Option<PixelComparison<'a>>) -> Self {
        Self { comparison, ..self }
    }

    /// The painter that shows light as in this denoised picture of the film.
    pub(crate) fn denoised(self, denoised: Option<Clean<'a>>) -> Self {
        Self { denoised, ..self }
    }

    /// Writes the colours of `tiles` into `rgba` (row-major, as large as the film). Pixels without samples stay as they
    /// are.
    pub fn paint(&self, tiles: &[Tile], rgba: &mut [u8]) {
        self.paint_carried(tiles, rgba, None);
    }

    /// The same blended with the carried-over pixels of an earlier picture of equal size. Returns the tiles that show
    /// some of them.
    pub(crate) fn paint_carried(&self, tiles: &[Tile], rgba: &mut [u8], carried: Option<&mut Carried>) -> Vec<Tile> {
        let (blender, mut rows) = carried.map(Carried::rows).unzip();
        let bands = rgba
            .chunks_mut(4 * (self.film.width() * TILE) as usize)
            .map(|rgba| Band {
                rgba,
                tiles: Vec::new(),
                carried: rows.as_mut().and_then(Iterator::next).unwrap_or_default(),
            });
        let mut bands: Vec<Band> = bands.collect();
        for &tile in tiles {
            if let Some(band) = bands.get_mut((tile.y / TILE) as usize) {
                band.tiles.push(tile);
            }
        }
        let paint = |band: &mut Band| self.paint_band(band, blender);
        let carried: Vec<Vec<Tile>> = match tiles.len() {
            // Waiting for other threads would take longer.
            0..MANY => bands.iter_mut().map(paint).collect(),
            _ => bands.par_iter_mut().map(paint).collect(),
        };
        carried.concat()
    }

    /// Paints the tiles of a band. Returns the tiles that show carried-over pixels.
    fn paint_band(&self, band: &mut Band, blender: Option<&Blender>) -> Vec<Tile> {
        let mut carried = Vec::new();
        for &tile in &band.tiles {
            let mut own = band.carried.get_mut((tile.x / TILE) as usize).and_then(Option::as_mut);
            let mut is_carried = false;
            for y in tile.y..tile.y + tile.height {
                let start = ((y - tile.y) * self.film.width() + tile.x) as usize;
                let Some(row) = band.rgba.get_mut(4 * start..4 * (start + tile.width as usize)) else {
                    continue;
                };
                if !self.mode.is_light() {
                    self.paint_other(tile, y, row);
                    continue;
                }
                let mut pixels = [None; TILE as usize];
                self.row_of_light(tile, y, &mut pixels);
                let pixels = &mut pixels[..tile.width as usize];
                if let Some(blender) = blender {
                    let samples = self.denoised.map(|denoised| denoised.samples);
                    is_carried |= blender.blend_row(own.as_deref_mut(), self.film, (tile, y), samples, pixels);
                }
                self.paint_light(tile, y, pixels, row);
            }
            if is_carried {
                carried.push(tile);
                own.into_iter().for_each(CarriedTile::judge);
            } else if let Some(own) = own.filter(|_| self.film.samples(tile.x, tile.y) > 0) {
                own.end();
            }
        }
        carried
    }

    /// The light of a row of a tile, without carried-over pixels.
    fn row_of_light(&self, tile: Tile, y: u32, row: &mut [Option<Rgb>; TILE as usize]) {
        match self.denoised {
            Some(denoised) => {
                let start = (y * self.film.width() + tile.x) as usize;
                for (pixel, &light) in row
                    .iter_mut()
                    .zip(&denoised.radiance[start..start + tile.width as usize])
                {
                    *pixel = Some(light);
                }
            }
            None => self.film.mixed_row(tile, y, &self.scales.mix, row),
        }
    }

    /// Paints a row of a tile in modes that show light.
    fn paint_light(&self, tile: Tile, y: u32, pixels: &[Option<Rgb>], rgba: &mut [u8]) {
        let mut light = [Rgb::ZERO; TILE as usize];
        for ((x, light), pixel) in (tile.x..).zip(&mut light).zip(pixels) {
            let radiance = pixel.unwrap_or_default();
            let comparison = self.comparison.as_ref();
            *light = comparison.map_or(radiance, |comparison| comparison.pixel(x, y, radiance));
        }
        let mut targets = pixels.iter().zip(rgba.chunks_exact_mut(4));
        self.tone.encode_each(&light[..pixels.len()], |[r, g, b]| {
            if let Some((Some(_), target)) = targets.next() {
                target.copy_from_slice(&[r, g, b, u8::MAX]);
            }
        });
    }

    /// Paints a row of a tile in modes that show no light.
    fn paint_other(&self, tile: Tile, y: u32, rgba: &mut [u8]) {
        for (x, target) in (tile.x..).zip(rgba.chunks_exact_mut(4)) {
            if let Some(pixel) = self.film.pixel(x, y) {
                let [r, g, b] = self.encode(x, y, &pixel);
                target.copy_from_slice(&[r, g, b, u8::MAX]);
            }
        }
    }

    /// The colour of a pixel in modes that show no light.
    fn encode(&self, x: u32, y: u32, pixel: &PixelSum) -> [u8; 3] {
        let first = || self.film.first_hit(x, y);
        let nothing = [0; 3];
        match self.mode {
            DisplayMode::Shaded | DisplayMode::LightGroup(_) => self.tone.encode(pixel.radiance),
            DisplayMode::Albedo => self.plain.encode(pixel.albedo),
            DisplayMode::Headlight | DisplayMode::Clay => self.plain.encode(pixel.radiance),
            // The usual picture of normals: taken as encoded values, not as light.
            DisplayMode::Normal => (0.5 * pixel.normal + 0.5).to_array().map(quantized),
            DisplayMode::Depth => [quantized(nearness(pixel.depth, self.scales.depth)); 3],
            DisplayMode::Uv => first().map_or(nothing, |hit| {
                let [u, v] = hit.uv.to_array().map(|x| quantized(x - x.floor()));
                [u, v, 0]
            }),
            DisplayMode::Material => first().map_or(nothing, |hit| color_of_id(hit.material.0)),
            DisplayMode::Object => first().map_or(nothing, |hit| color_of_id(hit.instance)),
            DisplayMode::Samples => {
                let share = self.film.samples(x, y) as f32 / self.scales.most_samples.max(1) as f32;
                heat(share).map(quantized)
            }
            DisplayMode::Noise => {
                let least = DARK * self.brightness;
                let error = self.film.standard_error(x, y).unwrap_or(0.0);
                let relative = error / luminance(pixel.radiance).max(least).max(f32::MIN_POSITIVE);
                heat(relative / HOTTEST_NOISE).map(quantized)
            }
            DisplayMode::Luminance => heat(photometric(pixel) / self.scales.brightest).map(quantized),
            DisplayMode::Illuminance => illuminance(self.film, self.scales.brightest, x, y).map(quantized),
            DisplayMode::BvhSteps => heat(pixel.radiance.x / HOTTEST_STEPS).map(quantized),
            DisplayMode::OpticalDepth => heat(luminance(pixel.radiance) / HOTTEST_DEPTH).map(quantized),
        }
    }
}

fn mean_luminance(film: &Film) -> f32 {
    let radiance = film.radiance();
    radiance.iter().map(|&rgb| luminance(rgb)).sum::<f32>() / radiance.len().max(1) as f32
}

/// The brightness of the far end of the range of depths.
pub(super) const DARKEST: f32 = 0.08;

/// The brightness that stands for a depth: 1 at the near end of the range, a dark grey at its far end, 0 where nothing
/// was hit.
fn nearness(depth: f32, [near, far]: [f32; 2]) -> f32 {
    if depth <= 0.0 {
        return 0.0;
    }
    let share = (depth - near) / (far - near).max(f32::MIN_POSITIVE);
    1.0 - (1.0 - DARKEST) * share.clamp(0.0, 1.0)
}

/// The colour of an id. Neighbours in number are far apart in hue (by the golden section), and differ in brightness;
/// sRGB.
pub(crate) fn color_of_id(id: u32) -> [u8; 3] {
    const GOLDEN: f64 = 0.618_033_988_749_895;
    let hue = (f64::from(id) * GOLDEN).fract() as f32;
    let value = [0.95, 0.7, 0.5][id as usize % 3];
    let channel = |offset: f32| {
        let ramp = (6.0 * (hue + offset).fract() - 3.0).abs() - 1.0;
        quantized(value * (1.0 - SATURATION * (1.0 - ramp.clamp(0.0, 1.0))))
    };
    const SATURATION: f32 = 0.65;
    [channel(0.0), channel(2.0 / 3.0), channel(1.0 / 3.0)]
}

/// Turns [0, 1] into a byte; NaN becomes 0.
fn quantized(encoded: f32) -> u8 {
    (encoded * 255.0 + 0.5) as u8
}

#[cfg(test)]
mod tests {
    use glam::Vec2;

    use super::*;
    use crate::material::MaterialId;
    use crate::render::scene::FirstHit;
    use crate::render::tile::{TilePreview, tiles};

    #[test]
    fn only_pixels_with_something_to_show_are_painted() {
        let mut film = Film::new(64, 32);
        let tiles = tiles(64, 32);
        film.add_preview(TilePreview {
            tile: tiles[1],
            step: 32,
            blocks: vec![PixelSum {
                radiance: Rgb::splat(100.0),
                ..PixelSum::default()
            }],
            layers: Default::default(),
            first_hits: vec![None],
            rays: 0,
        });
        let mut rgba = vec![7; 4 * 64 * 32];
        Painter::new(&film, &DisplaySettings::default(), &Scales::default()).paint(&tiles, &mut rgba);
        assert_eq!(rgba[..4], [7; 4]);
        assert_eq!(rgba[4 * 32..4 * 32 + 4], [255; 4]);
    }

    /// One tile of 32 x 32 pixels: a preview of 4 x 4 blocks, given by `block` for each number.
    fn preview(block: impl Fn(u32) -> (PixelSum, Option<FirstHit>)) -> Film {
        let mut film = Film::new(32, 32);
        let (blocks, first_hits) = (0..16).map(block).unzip();
        film.add_preview(TilePreview {
            tile: tiles(32, 32)[0],
            step: 8,
            blocks,
            layers: Default::default(),
            first_hits,
            rays: 0,
        });
        film
    }

    /// The colours of the 16 blocks.
    fn painted(film: &Film, mode: DisplayMode) -> Vec<[u8; 3]> {
        let settings = DisplaySettings {
            mode,
            ..DisplaySettings::default()
        };
        let scales = Scales::of(film, mode, Vec::new(), &Scales::default());
        let mut rgba = vec![0; 4 * 32 * 32];
        Painter::new(film, &settings, &scales).paint(&tiles(32, 32), &mut rgba);
        (0..16)
            .map(|block| {
                let start = 4 * (block / 4 * 8 * 32 + block % 4 * 8);
                [rgba[start], rgba[start + 1], rgba[start + 2]]
            })
            .collect()
    }

    #[test]
    fn depths_fill_the_range_whatever_the_size_of_the_scene() {
        for size in [1e-3, 1.0, 1e4] {
            let film = preview(|block| {
                let depth = if block == 5 { 0.0 } else { size * (3.0 + block as f32) };
                (
                    PixelSum {
                        depth,
                        ..PixelSum::default()
                    },
                    None,
                )
            });
            let grey: Vec<u8> = painted(&film, DisplayMode::Depth).iter().map(|rgb| rgb[0]).collect();
            assert_eq!((grey[0], grey[5]), (255, 0), "{grey:?}");
            assert!((10..40).contains(&grey[15]) && grey[7] > grey[8], "{grey:?}");
        }
        // A slightly greater distance does not change the range.
        let film = |far: f32| {
            preview(move |block| {
                let depth = if block == 0 { 1.0 } else { far };
                (
                    PixelSum {
                        depth,
                        ..PixelSum::default()
                    },
                    None,
                )
            })
        };
        let before = Scales::of(&film(2.0), DisplayMode::Depth, Vec::new(), &Scales::default());
        assert_eq!(Scales::of(&film(2.01), DisplayMode::Depth, Vec::new(), &before), before);
        assert_ne!(Scales::of(&film(2.5), DisplayMode::Depth, Vec::new(), &before), before);
    }

    #[test]
    fn surfaces_are_told_apart() {
        let film = preview(|block| {
            let hit = FirstHit {
                instance: block / 2,
                material: MaterialId(block % 3),
                uv: Vec2::new(block as f32 / 16.0, -0.25),
            };
            (PixelSum::default(), (block != 15).then_some(hit))
        });
        let (objects, materials) = (
            painted(&film, DisplayMode::Object),
            painted(&film, DisplayMode::Material),
        );
        let uvs = painted(&film, DisplayMode::Uv);
        for a in 0..15 {
            for b in 0..15 {
                assert_eq!(objects[a] == objects[b], a / 2 == b / 2);
                assert_eq!(materials[a] == materials[b], a % 3 == b % 3);
            }
            assert_eq!(uvs[a], [quantized(a as f32 / 16.0), quantized(0.75), 0]);
        }
        assert_eq!([objects[15], materials[15], uvs[15]], [[0; 3]; 3]);
    }

    #[test]
    fn ids_have_colours_that_are_far_apart() {
        for a in 0..12 {
            for b in 0..a {
                let (a, b) = (color_of_id(a), color_of_id(b));
                let apart: u32 = a.iter().zip(b).map(|(&a, b)| u32::from(a.abs_diff(b))).sum();
                assert!(apart > 40, "{a:?} {b:?}");
            }
        }
        assert_eq!(color_of_id(u32::MAX), color_of_id(u32::MAX));
    }
}
