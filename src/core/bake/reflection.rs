//! Reflection probes: the view from the centre of a box, for reflecting surfaces in the box.

use glam::{Affine3A, UVec2};

use super::cube::{CubePicture, windows};
use super::lightmap::Lightmaps;
use super::prefilter::{Prefiltered, prefilter};
use super::progress::Work;
use super::texels::Texels;
use crate::color::Rgb;
use crate::render::denoise::{DenoiseError, DenoiseInput, DenoiseQuality, denoise};
use crate::render::probe_radiance::Window;

/// The texels of the probe of a box, a transformed cube from -0.5 to 0.5. Their directions are in the space of the
/// cube, so that a renderer finds the surface on a side of the box by following a reflected ray to it.
pub fn outlook(world_from_box: &Affine3A, size: u32) -> Texels<Window> {
    windows(world_from_box.translation.into(), &world_from_box.matrix3, size)
}

/// The approximate share of the work that denoising takes.
const DENOISING: f64 = 0.1;

/// The filtered cube maps of a probe of this size, given the light at its texels (see [`outlook`]). None if the work
/// was cancelled.
pub fn finish(
    world_from_box: &Affine3A,
    size: u32,
    light: &Lightmaps,
    denoise: bool,
    work: &mut Work,
) -> Result<Option<Prefiltered>, DenoiseError> {
    let mut picture = CubePicture {
        size,
        texels: (0..light.texel_count()).map(|texel| light.light(texel)).collect(),
    };
    let begin = if denoise { DENOISING } else { 0.0 };
    if denoise {
        match work.part(0.0..begin, |work| denoised(&picture, work)) {
            Err(DenoiseError::Cancelled) => return Ok(None),
            denoised => picture = denoised?,
        }
    }
    Ok(work.part(begin..1.0, |work| prefilter(picture, &world_from_box.matrix3, work)))
}

/// The denoised cube map. Each face is denoised with a border, so that it matches its neighbours.
fn denoised(picture: &CubePicture, work: &mut Work) -> Result<CubePicture, DenoiseError> {
    let border = (picture.size / 8).max(8);
    let width = picture.size + 2 * border;
    let mut texels: Vec<Rgb> = Vec::with_capacity(picture.texels.len());
    for side in 0..6 {
        (work.watch)(side as f64 / 6.0);
        let color = picture.bordered(side, border);
        let input = DenoiseInput {
            width,
            height: width,
            color: &color,
            albedo: None,
            normal: None,
            prefilter: false,
            quality: DenoiseQuality::High,
            threads: Some(work.pool.current_num_threads()),
        };
        let filtered = denoise(&input, work.cancel)?;
        let places = (0..picture.size).flat_map(|y| (0..picture.size).map(move |x| UVec2::new(x, y)));
        let inner = places.map(|place| place + border);
        texels.extend(inner.map(|place| filtered[(place.y * width + place.x) as usize]));
    }
    Ok(CubePicture {
        size: picture.size,
        texels,
    })
}
