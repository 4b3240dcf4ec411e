//! The figures and thresholds for scripts.

use clap::ValueEnum;

use super::figures::Figures;

/// The figures that can be limited.
#[derive(Clone, Copy, Debug, PartialEq, ValueEnum)]
#[value(rename_all = "lower")]
enum Metric {
    Mean,
    Mse,
    RelMse,
    Flip,
    Z,
    Psnr,
    Ssim,
}

impl Metric {
    fn name(self) -> String {
        let value = self.to_possible_value();
        value.map_or_else(String::new, |value| value.get_name().to_owned())
    }

    /// Whether greater values mean more similar pictures.
    fn is_likeness(self) -> bool {
        matches!(self, Self::Psnr | Self::Ssim)
    }

    /// The value of the figure; None if the pictures do not have it.
    fn value(self, figures: &Figures) -> Option<f32> {
        let light = figures.light.as_ref();
        match self {
            Self::Mse => Some(figures.mse),
            // Two black pictures have the same mean.
            Self::Mean if light?.means == [0.0, 0.0] => Some(0.0),
            Self::Mean => Some(light?.mean_ratio.map_or(f32::INFINITY, |ratio| (ratio - 1.0).abs())),
            Self::RelMse => Some(light?.relmse),
            Self::Flip => Some(light?.flip),
            Self::Z => light?.z.map(|z| z.rms),
            Self::Psnr => Some(light?.psnr.unwrap_or(f32::INFINITY)),
            Self::Ssim => light?.ssim,
        }
    }
}

/// A limit on a figure.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Threshold {
    metric: Metric,
    limit: f32,
}

impl Threshold {
    /// `METRIC=VALUE`, or `VALUE` for FLIP.
    pub fn above(text: &str) -> Result<Self, String> {
        let text = if text.contains('=') {
            text
        } else {
            &format!("flip={text}")
        };
        Self::parse(text, false)
    }

    /// `METRIC=VALUE`
    pub fn below(text: &str) -> Result<Self, String> {
        Self::parse(text, true)
    }

    fn parse(text: &str, is_likeness: bool) -> Result<Self, String> {
        let (name, value) = text.split_once('=').ok_or("expected METRIC=VALUE")?;
        let metric = match Metric::from_str(name, true) {
            Ok(metric) if metric.is_likeness() == is_likeness => metric,
            Ok(_) if is_likeness => {
                return Err(format!(
                    "a small `{name}` means that pictures are alike: use --fail-above"
                ));
            }
            Ok(_) => {
                return Err(format!(
                    "a great `{name}` means that pictures are alike: use --fail-below"
                ));
            }
            Err(_) => {
                let possible = Metric::value_variants().iter();
                let possible = possible.filter(|metric| metric.is_likeness() == is_likeness);
                let names: Vec<String> = possible.map(|metric| metric.name()).collect();
                return Err(format!("there is no figure `{name}`: expected {}", names.join(", ")));
            }
        };
        let limit = value.trim().parse().ok().filter(|limit: &f32| limit.is_finite());
        let limit = limit.ok_or_else(|| format!("`{value}` is not a number"))?;
        Ok(Self { metric, limit })
    }

    /// A sentence if the pictures differ too much. An unknown figure, or a picture with NaN or infinite pixels, counts
    /// as beyond the limit.
    pub fn broken_by(&self, figures: &Figures) -> Option<String> {
        let Self { metric, limit } = *self;
        let name = metric.name();
        if figures.not_finite[0] > figures.not_finite[1] {
            return Some(format!(
                "{name} does not count: the picture has pixels that are no numbers"
            ));
        }
        match metric.value(figures) {
            None if figures.data.is_some() => Some(format!("{name} is not known of layers of data: only mse is")),
            None => Some(format!("{name} is not known of these pictures")),
            Some(value) if metric.is_likeness() && value < limit => Some(format!("{name} is {value}, below {limit}")),
            Some(value) if !metric.is_likeness() && value > limit => Some(format!("{name} is {value}, above {limit}")),
            Some(_) => None,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::figures::Light;
    use super::*;

    fn figures() -> Figures {
        Figures {
            width: 1,
            height: 1,
            mse: 0.1,
            light: Some(Light {
                means: [1.01, 1.0],
                mean_ratio: Some(1.01),
                relmse: 0.2,
                psnr: Some(30.0),
                ssim: None,
                flip: 0.05,
                flip_greatest: 0.5,
                flip_exposures: None,
                z: None,
            }),
            data: None,
            not_finite: [0, 0],
        }
    }

    #[test]
    fn limits_are_read_and_kept() {
        let above = |text: &str| Threshold::above(text).expect(text).broken_by(&figures());
        for kept in ["0.05", "flip=0.06", "mean=0.02", "MSE=1", "relmse=0.2"] {
            assert_eq!(above(kept), None, "{kept}");
        }
        for (broken, words) in [
            ("0.04", "flip is 0.05, above 0.04"),
            ("mean=0.005", "mean"),
            ("z=2", "not known"),
        ] {
            let reason = above(broken).expect(broken);
            assert!(reason.contains(words), "{reason}");
        }
        let below = |text: &str| Threshold::below(text).expect(text).broken_by(&figures());
        assert_eq!(below("psnr=30"), None);
        assert!(below("psnr=31").is_some() && below("ssim=0.1").is_some());
        for bad in ["", "flip=", "flip=x", "flip=inf", "psnr=30", "flipp=1", "=1"] {
            assert!(Threshold::above(bad).is_err(), "{bad}");
        }
        assert!(Threshold::below("30").is_err() && Threshold::below("mse=1").is_err());
        let broken = Figures {
            not_finite: [1, 0],
            ..figures()
        };
        assert!(Threshold::above("1").expect("a limit").broken_by(&broken).is_some());
    }
}
