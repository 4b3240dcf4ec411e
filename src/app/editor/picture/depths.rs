//! The depths of the surfaces in the picture, which hide lines that are drawn over it, and their colours.

use bevy::math::Vec2;

use crate::color::Rgb;
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

    /// The colour of the surface at a place of the picture, as [`Self::at`]: its albedo, linear Rec. 709 in [0, 1].
    /// Where nothing is hit it is the radiance, scaled down to that range. None if it is not known yet.
    pub fn color_at(&self, place: Vec2) -> Option<Rgb> {
        let pixel = self.pixel(place)?;
        let color = if pixel.depth > 0.0 {
            pixel.albedo
        } else {
            pixel.radiance
        };
        Some((color / color.max_element().max(1.0)).max(Rgb::ZERO))
    }

    fn pixel(&self, place: Vec2) -> Option<PixelSum> {
        let film = self.film?;
        let pixel = |share: f32, count: u32| ((share * count as f32).max(0.0) as u32).min(count - 1);
        film.pixel(pixel(place.x, film.width()), pixel(place.y, film.height()))
    }

    /// The number of depths in a row; 0 if none is known.
    pub fn width(&self) -> u32 {
        self.film.map_or(0, Film::width)
    }
}
