//! The figures of a comparison, for people and for machines.

use std::fmt::Write as _;

use glam::DVec3;
use serde::Serialize;
use sunroom::color::{Rgb, luminance};
use sunroom::metrics::{Errors, ZScores, errors, ssim, z_scores};

use super::pair::{Pair, Seen};

#[derive(Serialize)]
pub struct Figures {
    pub width: u32,
    pub height: u32,
    /// Mean squared difference of the numbers.
    pub mse: f32,
    /// The figures of colours; None for data.
    #[serde(flatten)]
    pub light: Option<Light>,
    /// The figures of data; None for colours.
    #[serde(flatten)]
    pub data: Option<Data>,
    /// The number of pixels in each picture with NaN or infinite values, which count as black.
    pub not_finite: [usize; 2],
}

/// The differences of two pictures of light.
#[derive(Serialize)]
pub struct Light {
    /// Mean luminances of the picture and of the reference.
    pub means: [f32; 2],
    /// The mean of the picture divided by that of the reference; None if the reference is black.
    pub mean_ratio: Option<f32>,
    pub relmse: f32,
    /// Decibels; None for pictures that look equal on a display.
    pub psnr: Option<f32>,
    /// None for pictures of less than 11 pixels along a side.
    pub ssim: Option<f32>,
    /// The mean and the maximum over the pixels.
    pub flip: f32,
    pub flip_greatest: f32,
    /// First and last exposure in stops; None for display-referred pictures.
    pub flip_exposures: Option<[f32; 2]>,
    /// None if neither picture has variances.
    pub z: Option<ZScores>,
}

/// The differences of two layers of data.
#[derive(Serialize)]
pub struct Data {
    /// The means of each component of the picture and of the reference.
    pub component_means: [Vec<f64>; 2],
    /// The greatest difference of a component.
    pub greatest_difference: f32,
}

impl Figures {
    pub fn of(pair: &Pair) -> Self {
        let errors = errors(&pair.picture.pixels, &pair.reference.pixels).expect("the pair is finite and of one size");
        // With two components the blue is 0 in both.
        let mse = match pair.components {
            2 => errors.mse * 1.5,
            _ => errors.mse,
        };
        Self {
            width: pair.picture.width,
            height: pair.picture.height,
            mse,
            light: pair.seen.as_ref().map(|seen| Light::of(pair, seen, &errors)),
            data: pair.seen.is_none().then(|| Data::of(pair)),
            not_finite: pair.not_finite,
        }
    }

    /// The names and values of all figures.
    pub fn rows(&self) -> Vec<(&'static str, String)> {
        let mut rows = Vec::new();
        let mse = ("MSE", format!("{:.6e}", self.mse));
        if let Some(data) = &self.data {
            let [means, others] = data.component_means.each_ref().map(|means| {
                let numbers: Vec<String> = means.iter().map(|mean| format!("{mean:.6}")).collect();
                numbers.join(" ")
            });
            rows.push(("mean", format!("{means} against {others}")));
            rows.push(mse.clone());
            rows.push(("greatest difference", format!("{:.6e}", data.greatest_difference)));
        }
        if let Some(light) = &self.light {
            light.add_rows(mse, &mut rows);
        }
        if self.not_finite != [0, 0] {
            let [picture, reference] = self.not_finite;
            rows.push(("pixels that are no numbers", format!("{picture} against {reference}")));
        }
        rows
    }

    /// The rows as a table.
    pub fn text(&self, pair: &Pair) -> String {
        let [picture, reference] = pair.paths.each_ref().map(|path| path.display());
        let (width, height) = (self.width, self.height);
        let layer = match pair.layer.as_str() {
            "" => String::new(),
            layer => format!(", layer {layer}"),
        };
        let mut text = format!("{picture} against {reference}, {width} x {height} pixels{layer}\n");
        let rows = self.rows();
        let widest = rows.iter().map(|row| row.0.len()).max().unwrap_or(0);
        for (name, value) in rows {
            let _ = writeln!(text, "{name:widest$}  {value}");
        }
        text
    }
}

impl Light {
    fn of(pair: &Pair, seen: &Seen, errors: &Errors) -> Self {
        let (picture, reference) = (&pair.picture.pixels, &pair.reference.pixels);
        let [mean, other] = errors.means;
        let flip_sum: f64 = seen.flip.iter().map(|&error| f64::from(error)).sum();
        Self {
            means: errors.means,
            mean_ratio: (other != 0.0).then_some(mean / other),
            relmse: errors.relative_mse,
            psnr: errors.psnr.is_finite().then_some(errors.psnr),
            ssim: ssim(picture, reference, pair.picture.width as usize),
            flip: (flip_sum / seen.flip.len() as f64) as f32,
            flip_greatest: seen.flip.iter().copied().fold(0.0, f32::max),
            flip_exposures: seen.exposures.map(|exposures| [exposures.start, exposures.stop]),
            z: scores(pair),
        }
    }

    fn add_rows(&self, mse: (&'static str, String), rows: &mut Vec<(&'static str, String)>) {
        let [mean, other] = self.means;
        rows.push(("mean luminance", format!("{mean:.6} against {other:.6}")));
        let or_none = |number: Option<String>, none: &str| number.unwrap_or_else(|| none.to_owned());
        let ratio = self.mean_ratio.map(|ratio| format!("{ratio:.6}"));
        rows.push(("mean ratio", or_none(ratio, "none, the reference is black")));
        rows.push(mse);
        rows.push(("relMSE", format!("{:.6e}", self.relmse)));
        rows.push((
            "PSNR",
            or_none(self.psnr.map(|psnr| format!("{psnr:.3} dB")), "infinite"),
        ));
        let ssim = self.ssim.map(|ssim| format!("{ssim:.6}"));
        rows.push(("SSIM", or_none(ssim, "none, the pictures are smaller than its window")));
        let at = match self.flip_exposures {
            Some([start, stop]) => format!("radiance at {start:+.2} to {stop:+.2} stops"),
            None => "as displayed".to_owned(),
        };
        rows.push((
            "FLIP",
            format!("{:.6}, at most {:.6}, {at}", self.flip, self.flip_greatest),
        ));
        if let Some(z) = self.z {
            let percent = 100.0 * z.beyond_three;
            let text = format!(
                "mean {:+.4}, rms {:.4}, {percent:.2} % beyond 3 (0.27 % by chance)",
                z.mean, z.rms
            );
            rows.push(("z-scores", text));
        }
    }
}

impl Data {
    fn of(pair: &Pair) -> Self {
        let means = |pixels: &[Rgb]| {
            let sum: DVec3 = pixels.iter().map(|pixel| pixel.as_dvec3()).sum();
            (sum / pixels.len() as f64).to_array()[..pair.components].to_vec()
        };
        let differences = pair.absolute().pixels;
        let greatest = differences.iter().map(|pixel| pixel.max_element());
        Self {
            component_means: [means(&pair.picture.pixels), means(&pair.reference.pixels)],
            greatest_difference: greatest.fold(0.0, f32::max),
        }
    }
}

/// The variances of both must be of the same quantity: luminance if one of them is.
fn scores(pair: &Pair) -> Option<ZScores> {
    let known = || pair.variances.iter().flatten();
    let is_of_luminance = known().any(|variance| variance.is_of_luminance);
    if !is_of_luminance {
        let variances = pair
            .variances
            .each_ref()
            .map(|variance| Some(variance.as_ref()?.pixels.as_slice()));
        return z_scores(&pair.picture.pixels, &pair.reference.pixels, variances);
    }
    // One component stands for the luminance, so that each pixel counts once.
    let in_red = |value: f32| Rgb::new(value, 0.0, 0.0);
    let luminances = |pixels: &[Rgb]| pixels.iter().map(|&rgb| in_red(luminance(rgb))).collect::<Vec<Rgb>>();
    let variances = pair.variances.each_ref().map(|variance| {
        // The variance of the luminance does not follow from the variances of components.
        let variance = variance.as_ref().filter(|variance| variance.is_of_luminance)?;
        Some(
            variance
                .pixels
                .iter()
                .map(|pixel| in_red(pixel.x))
                .collect::<Vec<Rgb>>(),
        )
    });
    let variances = variances.each_ref().map(|variance| variance.as_deref());
    z_scores(
        &luminances(&pair.picture.pixels),
        &luminances(&pair.reference.pixels),
        variances,
    )
}
