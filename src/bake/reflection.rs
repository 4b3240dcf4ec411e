//! Reflection probes: what is seen from the middle of a box, for surfaces in the box that reflect it.

use glam::{Affine3A, UVec2};

use super::cube::{CubePicture, windows};
use super::finish::Denoising;
use super::lightmap::Lightmaps;
use super::prefilter::{Prefiltered, prefilter};
use super::texels::Texels;
use crate::color::Rgb;
use crate::render::denoise::{DenoiseError, DenoiseInput, DenoiseQuality, denoise};
use crate::render::outlook::Window;

/// The texels of the probe of a box, which is a cube from -0.5 to 0.5 in its own space. The picture is one of directions of that space, so that a
/// renderer which follows a reflected ray to the side of the box finds there what is on it.
pub fn outlook(world_from_box: &Affine3A, size: u32) -> Texels<Window> {
    windows(world_from_box.translation.into(), &world_from_box.matrix3, size)
}

/// The pictures of the probe of this size whose texels, those of [`outlook`], have this light.
pub fn finish(
    world_from_box: &Affine3A,
    size: u32,
    light: &Lightmaps,
    denoising: Option<Denoising>,
) -> Result<Prefiltered, DenoiseError> {
    let mut picture = CubePicture {
        size,
        texels: (0..light.texel_count()).map(|texel| light.light(texel)).collect(),
    };
    if let Some(denoising) = denoising {
        picture = denoised(&picture, denoising)?;
    }
    Ok(prefilter(picture, &world_from_box.matrix3))
}

/// The picture without noise. Each side is denoised with a border, so that it goes with the one beside it.
fn denoised(picture: &CubePicture, denoising: Denoising) -> Result<CubePicture, DenoiseError> {
    let border = (picture.size / 8).max(8);
    let width = picture.size + 2 * border;
    let mut texels: Vec<Rgb> = Vec::with_capacity(picture.texels.len());
    for side in 0..6 {
        let color = picture.bordered(side, border);
        let input = DenoiseInput {
            width,
            height: width,
            color: &color,
            albedo: None,
            normal: None,
            prefilter: false,
            quality: DenoiseQuality::High,
            threads: denoising.threads,
        };
        let filtered = denoise(&input, denoising.cancel)?;
        let places = (0..picture.size).flat_map(|y| (0..picture.size).map(move |x| UVec2::new(x, y)));
        let inner = places.map(|place| place + border);
        texels.extend(inner.map(|place| filtered[(place.y * width + place.x) as usize]));
    }
    Ok(CubePicture {
        size: picture.size,
        texels,
    })
}
