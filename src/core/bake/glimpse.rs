//! A reduced picture of a lightmap while its light is gathered. It is cheap: nothing is denoised, and gaps are not
//! filled.

use std::f32::consts::FRAC_1_PI;

use glam::UVec2;

use super::blueprint::Blueprint;
use super::finish::LightmapPicture;
use super::lightmap::Lightmaps;
use super::texels::Texels;
use crate::color::Rgb;

/// A reduced picture of a lightmap.
#[derive(Clone, Debug, PartialEq)]
pub struct Glimpse {
    /// Width and height.
    pub size: UVec2,
    /// The radiance of a white diffuse surface, row by row from the top; None if the pixel covers no surface, or only
    /// texels buried in walls, whose light is not known yet.
    pub white: Vec<Option<Rgb>>,
}

/// Sums of texels for each pixel of the reduced picture.
struct Cells {
    size: UVec2,
    /// The texels along the side of a cell.
    side: u32,
    sums: Vec<(Rgb, u32)>,
}

impl Cells {
    fn new(size: UVec2, most: u32) -> Self {
        let side = size.max_element().div_ceil(most.max(1)).max(1);
        let size = UVec2::new(size.x.div_ceil(side), size.y.div_ceil(side));
        Self {
            size,
            side,
            sums: vec![(Rgb::ZERO, 0); size.x as usize * size.y as usize],
        }
    }

    fn add(&mut self, place: UVec2, light: Rgb) {
        let cell = place / self.side;
        let (sum, count) = &mut self.sums[(cell.y * self.size.x + cell.x) as usize];
        *sum += light;
        *count += 1;
    }

    fn means(self) -> Glimpse {
        let mean = |(sum, count)| (count > 0).then(|| sum * (FRAC_1_PI / count as f32));
        Glimpse {
            size: self.size,
            white: self.sums.into_iter().map(mean).collect(),
        }
    }
}

impl Blueprint {
    /// A reduced picture, with sides of at most `most` pixels, of the light gathered so far on a page.
    pub fn glimpse(&self, page: usize, light: &Lightmaps, most: u32) -> Glimpse {
        let mut cells = Cells::new(self.places.size, most);
        for texel in self.places.pages[page].clone() {
            if !light.is_buried(texel) {
                cells.add(self.places.texels[texel].place, light.light(texel));
            }
        }
        cells.means()
    }

    /// A reduced picture of a finished lightmap, with sides of at most `most` pixels.
    pub fn glimpse_of(&self, page: usize, picture: &LightmapPicture, most: u32) -> Glimpse {
        finished(&self.places, page, picture, most)
    }
}

fn finished(places: &Texels<()>, page: usize, picture: &LightmapPicture, most: u32) -> Glimpse {
    let mut cells = Cells::new(picture.size, most);
    for texel in places.pages[page].clone() {
        let place = places.texels[texel].place;
        let index = place.y as usize * picture.size.x as usize + place.x as usize;
        cells.add(place, picture.irradiance[index]);
    }
    cells.means()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bake::texels::Texel;

    #[test]
    fn a_small_picture_has_the_means_of_the_large_one() {
        let picture = LightmapPicture {
            size: UVec2::new(5, 2),
            irradiance: (0..10).map(|texel| Rgb::splat(texel as f32)).collect(),
        };
        let places = |covered: &[u32]| {
            let place = |index: &u32| UVec2::new(index % 5, index / 5);
            let texel = |index| Texel {
                place: place(index),
                receiver: (),
            };
            Texels {
                size: picture.size,
                texels: covered.iter().map(texel).collect(),
                pages: std::iter::once(0..covered.len()).collect(),
                spreads: Vec::new(),
            }
        };
        let all: Vec<u32> = (0..10).collect();
        let small = finished(&places(&all), 0, &picture, 3);
        assert_eq!(small.size, UVec2::new(3, 1));
        let means = [3.0, 5.0, 6.5].map(|mean: f32| Some(Rgb::splat(mean * FRAC_1_PI)));
        assert_eq!(small.white, means);
        assert_eq!(finished(&places(&all), 0, &picture, 5).size, picture.size);
        // The gaps between surfaces are left out of the means.
        let small = finished(&places(&[0, 1, 2, 3, 5, 6, 7]), 0, &picture, 3);
        let means = [Some(3.0), Some(4.0), None];
        assert_eq!(
            small.white,
            means.map(|mean: Option<f32>| Some(Rgb::splat(mean? * FRAC_1_PI)))
        );
    }

    #[test]
    fn cells_without_texels_are_known() {
        let mut cells = Cells::new(UVec2::splat(4), 2);
        cells.add(UVec2::new(3, 1), Rgb::ONE);
        let expected = [None, Some(Rgb::splat(FRAC_1_PI)), None, None];
        assert_eq!(cells.means().white, expected);
    }
}
