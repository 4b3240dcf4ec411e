//! Automatic exposure of a picture.

use crate::color::{Rgb, luminance};

/// The luminance to which the average of a picture is exposed: middle grey.
const KEY: f32 = 0.18;

/// The share of the pixels at either end, darkest and brightest, that is ignored: visible lamps, black corners,
/// fireflies.
const LEFT_OUT: f32 = 0.1;

/// The exposure in stops with which the logarithmic average of the picture's luminance becomes middle grey (Reinhard et
/// al., "Photographic Tone Reproduction for Digital Images", 2002, eq. 1). Black pixels, usually empty background, do
/// not count; None if all are black.
pub fn auto_exposure(radiance: &[Rgb]) -> Option<f32> {
    let stops = radiance.iter().map(|&rgb| luminance(rgb).log2());
    let mut stops: Vec<f32> = stops.filter(|stops| stops.is_finite()).collect();
    stops.sort_unstable_by(f32::total_cmp);
    let end = (LEFT_OUT * stops.len() as f32) as usize;
    let middle = stops.get(end..stops.len() - end).filter(|middle| !middle.is_empty())?;
    let mean = middle.iter().map(|&stops| f64::from(stops)).sum::<f64>() / middle.len() as f64;
    Some(KEY.log2() - mean as f32)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_even_picture_becomes_middle_grey() {
        for level in [1e-4, 0.18, 700.0] {
            let stops = auto_exposure(&[Rgb::splat(level); 50]).expect("not black");
            // The tolerance is a few roundings of logarithms up to 13.
            assert!((level * stops.exp2() / KEY - 1.0).abs() < 1e-4, "{level}: {stops}");
        }
        assert_eq!(auto_exposure(&[]), None);
        assert_eq!(auto_exposure(&[Rgb::ZERO, Rgb::NAN, Rgb::INFINITY]), None);
    }

    #[test]
    fn few_extremes_do_not_matter_and_a_brighter_scene_is_exposed_less() {
        let picture: Vec<Rgb> = (0..100).map(|i| Rgb::splat(0.1 + 0.01 * i as f32)).collect();
        let plain = auto_exposure(&picture).expect("not black");
        let mut spoilt = picture.clone();
        spoilt[99] = Rgb::splat(1e9);
        spoilt[0] = Rgb::splat(1e-9);
        spoilt.extend([Rgb::ZERO; 400]);
        assert_eq!(auto_exposure(&spoilt), Some(plain));
        let brighter: Vec<Rgb> = picture.iter().map(|&rgb| rgb * 8.0).collect();
        assert!((auto_exposure(&brighter).expect("not black") - (plain - 3.0)).abs() < 1e-4);
    }
}
