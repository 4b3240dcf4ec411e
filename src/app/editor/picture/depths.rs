//! The depths of the surfaces in the picture, which hide lines that are drawn over it, and their colours.

use bevy::math::Vec2;

use crate::color::{Rgb, luminance};
use crate::engine::RenderFilm;
use crate::render::film::Film;
use crate::render::tile::PixelSum;

/// The depths of the picture's first hits. Without a film none is known.
#[derive(Clone, Copy, Debug, Default)]
pub struct Depths<'f> {
    film: Option<&'f Film>,
    version: Option<[u64; 2]>,
}

impl<'f> Depths<'f> {
    /// Depths that stay unknown, so that nothing is hidden.
    pub const UNKNOWN: Self = Self {
        film: None,
        version: Some([0, 0]),
    };

    /// The depths in a film.
    pub fn of(film: &'f Film) -> Self {
        Self {
            film: Some(film).filter(|film| film.width() > 0 && film.height() > 0),
            version: None,
        }
    }

    /// The depths of the picture that is being rendered. Once every pixel has samples they have a version, which
    /// changes after each pass.
    pub fn rendered(film: &'f RenderFilm) -> Self {
        Self {
            version: (film.samples > 0).then_some([film.job, film.samples.into()]),
            ..Self::of(&film.film)
        }
    }

    /// Depths of one version are equal, or so nearly that the difference is invisible. None: they may change at any
    /// time.
    pub fn version(&self) -> Option<[u64; 2]> {
        self.version
    }

    /// The distance in world units along the ray through a place of the picture, (0, 0) top left, (1, 1) bottom right:
    /// infinity if nothing is hit, and None if it is not known yet.
    pub fn at(&self, place: Vec2) -> Option<f32> {
        let depth = self.pixel(place)?.depth;
        Some(if depth > 0.0 { depth } else { f32::INFINITY })
    }

    /// The luminance of a place of the picture, as [`Self::at`], as radiance (W/(m^2 sr)), with its standard error if
    /// it is known; None before there is a sample.
    pub fn luminance_at(&self, place: Vec2) -> Option<(f32, Option<f32>)> {
        let film = self.film?;
        let [x, y] = pixel_at(film, place);
        Some((luminance(film.pixel(x, y)?.radiance), film.standard_error(x, y)))
    }

    /// The colour of the surface at a place of the picture, as [`Self::at`]: its albedo, linear Rec. 709 in [0, 1].
    /// Where nothing is hit, or a light as `is_light` says, it is the radiance, scaled down to that range. None if it
    /// is not known yet.
    pub fn color_at(&self, place: Vec2, is_light: bool) -> Option<Rgb> {
        let pixel = self.pixel(place)?;
        // The albedo of lights in the film is 1.
        let color = match pixel.depth > 0.0 && !is_light {
            true => pixel.albedo,
            false => pixel.radiance,
        };
        Some((color / color.max_element().max(1.0)).max(Rgb::ZERO))
    }

    fn pixel(&self, place: Vec2) -> Option<PixelSum> {
        let film = self.film?;
        let [x, y] = pixel_at(film, place);
        film.pixel(x, y)
    }

    /// The number of depths in a row; 0 if none is known.
    pub fn width(&self) -> u32 {
        self.film.map_or(0, Film::width)
    }
}

/// The pixel at a place of a picture that has some.
fn pixel_at(film: &Film, place: Vec2) -> [u32; 2] {
    let pixel = |share: f32, count: u32| ((share * count as f32).max(0.0) as u32).min(count - 1);
    [pixel(place.x, film.width()), pixel(place.y, film.height())]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::render::tile::{TileSamples, tiles};

    /// A film of one sample per pixel, all of them alike.
    fn film(pixel: PixelSum) -> Film {
        let mut film = Film::new(4, 4);
        for tile in tiles(4, 4) {
            film.add(&TileSamples {
                tile,
                samples: 0..1,
                pixels: vec![pixel; (tile.width * tile.height) as usize],
                blocks: None,
                layers: Default::default(),
                first_hits: Vec::new(),
                splats: Default::default(),
                rays: 0,
                invalid: 0,
            });
        }
        film
    }

    #[test]
    fn surfaces_have_their_albedo_and_lights_and_the_sky_their_radiance() {
        let surface = PixelSum {
            radiance: Rgb::new(4.0, 2.0, 1.0),
            albedo: Rgb::new(0.5, 0.25, 0.75),
            depth: 2.0,
            ..PixelSum::default()
        };
        let color = |pixel: PixelSum, is_light| Depths::of(&film(pixel)).color_at(Vec2::splat(0.5), is_light);
        let orange = Some(Rgb::new(1.0, 0.5, 0.25));
        assert_eq!(color(surface, false), Some(surface.albedo));
        let lamp = PixelSum {
            albedo: Rgb::ONE,
            ..surface
        };
        assert_eq!(color(lamp, true), orange);
        let sky = PixelSum { depth: 0.0, ..surface };
        assert_eq!(color(sky, false), orange);
        // Dark light keeps its strength.
        let dim = PixelSum {
            radiance: Rgb::new(0.2, 0.1, 0.0),
            ..sky
        };
        assert_eq!(color(dim, false), Some(dim.radiance));
        assert_eq!(Depths::of(&Film::new(4, 4)).color_at(Vec2::splat(0.5), false), None);
        assert_eq!(Depths::default().color_at(Vec2::splat(0.5), false), None);
    }
}
