//! Makes pictures, which can be filtered on display, of the light at texels.

use std::sync::atomic::AtomicBool;

use glam::UVec2;

use super::lightmap::Lightmaps;
use super::seams::{Seam, even_out};
use super::texels::Texels;
use crate::color::Rgb;
use crate::render::denoise::{DenoiseError, denoise_lightmap};

/// A lightmap as a picture.
#[derive(Clone, Debug, PartialEq)]
pub struct LightmapPicture {
    /// Width and height.
    pub size: UVec2,
    /// Irradiance row by row from the top, linear Rec. 709; black far from any surface.
    pub irradiance: Vec<Rgb>,
}

impl LightmapPicture {
    /// The sum of the layers of a picture, in their order.
    pub(super) fn sum<'a>(size: UVec2, layers: impl Iterator<Item = &'a Self>) -> Self {
        let mut irradiance = vec![Rgb::ZERO; size.x as usize * size.y as usize];
        for layer in layers {
            add(&mut irradiance, &layer.irradiance);
        }
        Self { size, irradiance }
    }
}

/// Adds the texels of a layer.
pub(super) fn add(sums: &mut [Rgb], more: &[Rgb]) {
    sums.iter_mut().zip(more).for_each(|(sum, more)| *sum += *more);
}

/// The settings of Open Image Denoise.
#[derive(Clone, Copy, Debug)]
pub struct Denoising<'a> {
    /// The number of threads; None means one per core.
    pub threads: Option<usize>,
    /// Ends it when set.
    pub cancel: &'a AtomicBool,
}

/// How far, in texels, light is spread into walls: as far as texture filters reach, but not through to the room behind
/// the wall.
const INTO_WALLS: usize = 2;
/// How far, in texels, the gaps between charts are filled.
const INTO_GAPS: usize = 8;

/// The value of each texel of a page; None if unknown.
type Known = Vec<Option<Rgb>>;

/// Makes the picture of a page. `seams` are the seams of this page.
pub fn finish<S>(
    texels: &Texels<S>,
    page: usize,
    light: &Lightmaps,
    seams: &[Seam],
    denoising: Option<Denoising>,
) -> Result<LightmapPicture, DenoiseError> {
    let size = texels.size;
    let index_of = |place: UVec2| (place.y * size.x + place.x) as usize;
    let own = texels.pages[page].clone();
    let mut values: Known = vec![None; size.x as usize * size.y as usize];
    let mut buried = vec![false; values.len()];
    for texel in own {
        let index = index_of(texels.texels[texel].place);
        match light.is_buried(texel) {
            true => buried[index] = true,
            false => values[index] = Some(light.light(texel)),
        }
    }
    for _ in 0..INTO_WALLS {
        spread(&mut values, size, |index| buried[index]);
    }
    for (value, buried) in values.iter_mut().zip(&buried) {
        if *buried && value.is_none() {
            *value = Some(Rgb::ZERO);
        }
    }
    if let Some(denoising) = denoising {
        denoise(&mut values, size, denoising)?;
    }
    fill_gaps(&mut values, size);
    let mut irradiance: Vec<Rgb> = values.into_iter().map(Option::unwrap_or_default).collect();
    even_out(&mut irradiance, size, seams);
    Ok(LightmapPicture { size, irradiance })
}

/// Denoises the known texels.
fn denoise(values: &mut Known, size: UVec2, denoising: Denoising) -> Result<(), DenoiseError> {
    // The denoiser must not take black gaps for shadows.
    let mut filled = values.clone();
    fill_gaps(&mut filled, size);
    let color: Vec<Rgb> = filled.into_iter().map(Option::unwrap_or_default).collect();
    let filtered = denoise_lightmap(size.x, size.y, &color, denoising.threads, denoising.cancel)?;
    for (value, filtered) in values.iter_mut().zip(filtered) {
        if let Some(value) = value {
            *value = filtered;
        }
    }
    Ok(())
}

fn fill_gaps(values: &mut Known, size: UVec2) {
    for _ in 0..INTO_GAPS {
        spread(values, size, |_| true);
    }
}

/// Gives each unknown texel for which `may` holds the mean of its known neighbours.
fn spread(values: &mut Known, size: UVec2, may: impl Fn(usize) -> bool) {
    let before = values.clone();
    for y in 0..size.y {
        for x in 0..size.x {
            let index = (y * size.x + x) as usize;
            if before[index].is_some() || !may(index) {
                continue;
            }
            let (mut sum, mut count) = (Rgb::ZERO, 0.0);
            for row in y.saturating_sub(1)..size.y.min(y + 2) {
                for column in x.saturating_sub(1)..size.x.min(x + 2) {
                    if let Some(value) = before[(row * size.x + column) as usize] {
                        sum += value;
                        count += 1.0;
                    }
                }
            }
            if count > 0.0 {
                values[index] = Some(sum / count);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn light_spreads_one_texel_at_a_time_where_it_may() {
        let size = UVec2::new(5, 1);
        let mut values: Known = vec![Some(Rgb::ONE), None, None, None, Some(Rgb::ZERO)];
        spread(&mut values, size, |index| index != 3);
        assert_eq!(values, [Some(Rgb::ONE), Some(Rgb::ONE), None, None, Some(Rgb::ZERO)]);
        spread(&mut values, size, |_| true);
        assert_eq!(values[2..4], [Some(Rgb::ONE), Some(Rgb::ZERO)]);
    }
}
