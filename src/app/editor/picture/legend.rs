//! The meaning of the picture's colours in display modes that show no light.

use super::painter::{DARKEST, Scales};
use crate::app::editor::command::display::{DisplayMode, HOTTEST_DEPTH, HOTTEST_NOISE, HOTTEST_STEPS, heat};
use crate::app::editor::words::figures::length;
use crate::photometry::units::{Lux, Nit};

/// The legend of a display mode.
#[derive(Clone, Debug, PartialEq)]
pub enum Legend {
    /// Numbers on a colour ramp.
    Ramp {
        /// The colours.
        ramp: Ramp,
        /// The value at the left end of the ramp.
        low: String,
        /// The value at its right end.
        high: String,
    },
    /// Colours with the words for them; sRGB.
    Words(Vec<([u8; 3], &'static str)>),
}

/// The colours of a ramp.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Ramp {
    /// The heat map.
    Heat,
    /// White for near, dark grey for far.
    Nearness,
}

impl Ramp {
    /// The colour at a share of the ramp from 0 to 1; sRGB-encoded.
    pub fn color(self, share: f32) -> [f32; 3] {
        match self {
            Self::Heat => heat(share),
            Self::Nearness => [1.0 - (1.0 - DARKEST) * share; 3],
        }
    }
}

/// The legend; None for modes that need none.
pub fn legend(mode: DisplayMode, scales: &Scales) -> Option<Legend> {
    let heat = |low: &str, high: String| Legend::Ramp {
        ramp: Ramp::Heat,
        low: low.to_owned(),
        high,
    };
    Some(match mode {
        DisplayMode::BvhSteps => heat("0", format!("{HOTTEST_STEPS:.0}+")),
        DisplayMode::OpticalDepth => heat("0", format!("{HOTTEST_DEPTH:.0}+")),
        DisplayMode::Samples => heat("0", scales.most_samples.to_string()),
        DisplayMode::Noise => heat("0 %", format!("{:.0} %+", 100.0 * HOTTEST_NOISE)),
        DisplayMode::Luminance => heat("0", format!("{}+", Nit(scales.brightest.into()))),
        DisplayMode::Illuminance => heat("0", format!("{}+", Lux(scales.brightest.into()))),
        DisplayMode::Depth => {
            let [low, high] = scales.depth.map(length);
            Legend::Ramp {
                ramp: Ramp::Nearness,
                low,
                high,
            }
        }
        // Half of the colour is zero: a normal along an axis has 255 in its channel and 128 in the others.
        DisplayMode::Normal => Legend::Words(vec![
            ([255, 128, 128], "towards +X"),
            ([128, 255, 128], "towards +Y"),
            ([128, 128, 255], "towards +Z"),
        ]),
        DisplayMode::Uv => Legend::Words(vec![
            ([255, 0, 0], "u = 1, v = 0"),
            ([0, 255, 0], "u = 0, v = 1"),
            ([255, 255, 0], "u = 1, v = 1"),
        ]),
        _ => return None,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn false_colours_have_a_legend_and_light_has_none() {
        let scales = Scales {
            most_samples: 64,
            depth: [0.5, 12.25],
            ..Scales::default()
        };
        let ends = |mode| match legend(mode, &scales) {
            Some(Legend::Ramp { low, high, .. }) => Some((low, high)),
            _ => None,
        };
        assert_eq!(ends(DisplayMode::Samples), Some(("0".to_owned(), "64".to_owned())));
        assert_eq!(ends(DisplayMode::Noise).map(|(_, high)| high).as_deref(), Some("25 %+"));
        assert_eq!(ends(DisplayMode::Depth), Some(("0.5".to_owned(), "12.2".to_owned())));
        assert_eq!(legend(DisplayMode::Shaded, &scales), None);
        for mode in [DisplayMode::Normal, DisplayMode::Uv] {
            assert!(matches!(legend(mode, &scales), Some(Legend::Words(_))), "{mode:?}");
        }
    }

    #[test]
    fn near_is_white() {
        assert_eq!(Ramp::Nearness.color(0.0), [1.0; 3]);
        assert!(Ramp::Nearness.color(1.0)[0] < 0.1);
    }
}
