//! The brightness of a texture over the uv unit square, by which textured lights are chosen and sampled.

use glam::Vec2;

use crate::color::{Rgb, luminance};
use crate::sampling::PiecewiseBilinear2d;
use crate::texture::{Parameter, TexturePoint, TextureTable};

/// The cells of the density along each axis, and the texture lookups along each axis of a cell.
const CELLS: usize = 128;
const LOOKUPS: usize = 4;

/// The least density, as a multiple of the average: lookups may miss details finer than their spacing.
const FLOOR: f32 = 0.1;

/// The approximate average luminance.
pub(super) fn mean_luminance(textures: &TextureTable, color: Parameter<Rgb>) -> f32 {
    luminance(textures.mean_color(color)).max(0.0)
}

/// A density that follows the luminance; None if it is constant or zero.
pub(super) fn density(textures: &TextureTable, color: Parameter<Rgb>) -> Option<PiecewiseBilinear2d> {
    if let Parameter::Constant(_) = color {
        return None;
    }
    const NODES: usize = CELLS + 1;
    let cell = 1.0 / CELLS as f32;
    let mut values: Vec<f32> = (0..NODES * NODES)
        .map(|node| {
            let center = Vec2::new((node % NODES) as f32, (node / NODES) as f32) * cell;
            mean_around(textures, color, center, cell)
        })
        .collect();
    let mean = values.iter().sum::<f32>() / values.len() as f32;
    values
        .iter_mut()
        .for_each(|value| *value = value.max(0.0) + FLOOR * mean);
    PiecewiseBilinear2d::new(NODES, NODES, &values)
}

/// Average luminance over the part within the unit square of the square of size `size` around `center`.
fn mean_around(textures: &TextureTable, color: Parameter<Rgb>, center: Vec2, size: f32) -> f32 {
    let low = (center - 0.5 * size).max(Vec2::ZERO);
    let step = ((center + 0.5 * size).min(Vec2::ONE) - low) / LOOKUPS as f32;
    let at = |index: usize| {
        let uv = low + step * Vec2::new((index % LOOKUPS) as f32 + 0.5, (index / LOOKUPS) as f32 + 0.5);
        luminance(textures.light(color, &TexturePoint::of_uv(uv)))
    };
    (0..LOOKUPS * LOOKUPS).map(at).sum::<f32>() / (LOOKUPS * LOOKUPS) as f32
}
