//! The false colours of luminance and illuminance: their scale, and lines of equal illuminance. The scale of depths.

use crate::app::editor::command::display::heat;
use crate::color::luminance;
use crate::photometry::LUMENS_PER_WATT;
use crate::render::film::Film;
use crate::render::tile::PixelSum;

/// The reciprocal of the share of pixels that are brighter than the hottest colour tells.
const FEW: usize = 50;
/// The lines of equal illuminance from nothing to the hottest colour.
const CONTOURS: f32 = 10.0;
/// The share of the hottest illuminance above which lines are black, and below which they are light.
const BRIGHT: f32 = 0.4;
/// The largest difference of neighbouring pixels on one surface, and the largest standard error of a pixel where lines
/// are drawn, both in steps from line to line.
const EDGE: f32 = 0.7;
const NOISIEST: f32 = 0.2;
const LINES: [[f32; 3]; 2] = [[0.8; 3], [0.0; 3]];

/// Pixels from all over the film that have samples, at most some 20,000.
fn some_pixels(film: &Film) -> impl Iterator<Item = PixelSum> {
    const ASKED: usize = 20_000;
    let pixels = (0..film.height()).flat_map(|y| (0..film.width()).map(move |x| (x, y)));
    let every = (film.width() as usize * film.height() as usize).div_ceil(ASKED).max(1);
    pixels.step_by(every).filter_map(|(x, y)| film.pixel(x, y))
}

/// The range of all depths without the least and greatest hundredth: at silhouettes a pixel's mean depth is on no
/// surface. Only some pixels are read.
pub(super) fn depth_range(film: &Film) -> [f32; 2] {
    let depths = some_pixels(film).map(|pixel| pixel.depth);
    let mut depths: Vec<f32> = depths.filter(|depth| *depth > 0.0).collect();
    depths.sort_unstable_by(f32::total_cmp);
    let end = depths.len() / 100;
    match (depths.get(end), depths.get(depths.len().wrapping_sub(1 + end))) {
        (Some(&near), Some(&far)) => [near, far],
        _ => [0.0, 0.0],
    }
}

/// The luminance in cd/m², or the illuminance in lux, of the hottest colour: few pixels exceed it. It is a round
/// number, so that it seldom changes while a picture is rendered.
pub(super) fn brightest(film: &Film) -> f32 {
    let mut values: Vec<f32> = some_pixels(film).map(|pixel| photometric(&pixel)).collect();
    values.sort_unstable_by(f32::total_cmp);
    let place = values.len() - values.len() / FEW;
    rounded_up(values.get(place.saturating_sub(1)).copied().unwrap_or_default())
}

/// The luminance in cd/m², or the illuminance in lux, of a pixel.
pub(super) fn photometric(pixel: &PixelSum) -> f32 {
    LUMENS_PER_WATT * luminance(pixel.radiance)
}

/// The next round number; 1 for what is not above 0.
fn rounded_up(value: f32) -> f32 {
    if !(value > f32::MIN_POSITIVE && value.is_finite()) {
        return 1.0;
    }
    let power = 10f32.powf(value.log10().floor());
    let steps = [1.0, 1.5, 2.0, 3.0, 5.0, 7.0, 10.0].map(|step| step * power);
    steps.into_iter().find(|step| *step >= value).unwrap_or(10.0 * power)
}

/// The false colour of a pixel by its illuminance in lux, or that of a line of equal illuminance, which lies where a
/// tenth of the scale is crossed towards the next pixel to the right or below. There are no lines at the edges of
/// things, and none where noise would draw them.
pub(super) fn illuminance(film: &Film, brightest: f32, x: u32, y: u32) -> [f32; 3] {
    let share = |x, y| CONTOURS * share(film, brightest, x, y);
    let own = share(x, y);
    let is_crossed = |x, y| {
        let next = share(x, y);
        next.floor() != own.floor() && (next - own).abs() < EDGE
    };
    let error = film.standard_error(x, y).unwrap_or(f32::INFINITY);
    let is_clear = CONTOURS * LUMENS_PER_WATT * error < NOISIEST * brightest;
    let is_inside = x + 1 < film.width() && y + 1 < film.height();
    match is_inside && is_clear && own < CONTOURS && (is_crossed(x + 1, y) || is_crossed(x, y + 1)) {
        true => LINES[usize::from(own > BRIGHT * CONTOURS)],
        false => heat(own / CONTOURS),
    }
}

/// The illuminance around a pixel as a share of the hottest: the mean over its neighbours, so that noise does not break
/// the lines.
fn share(film: &Film, brightest: f32, x: u32, y: u32) -> f32 {
    let (mut sum, mut count) = (0.0, 0.0);
    for near_y in y.saturating_sub(1)..=y + 1 {
        for near_x in x.saturating_sub(1)..=x + 1 {
            let is_inside = near_x < film.width() && near_y < film.height();
            if let Some(pixel) = is_inside.then(|| film.pixel(near_x, near_y)).flatten() {
                sum += photometric(&pixel);
                count += 1.0;
            }
        }
    }
    (sum / f32::max(count, 1.0) / brightest).min(1.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn scales_end_at_round_numbers() {
        for (value, round) in [
            (0.0, 1.0),
            (f32::NAN, 1.0),
            (1.2, 1.5),
            (180.0, 200.0),
            (512.0, 700.0),
            (7.5e4, 1e5),
        ] {
            assert!(
                (rounded_up(value) / round - 1.0).abs() < 1e-5,
                "{value}: {}",
                rounded_up(value)
            );
        }
    }
}
