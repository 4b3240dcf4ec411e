//! The meaning of the false colours of the picture.

use super::painter::Scales;
use crate::app::editor::command::display::{DisplayMode, HOTTEST_NOISE, HOTTEST_STEPS};

/// The meaning of a mode's false colours.
#[derive(Clone, Debug, PartialEq)]
pub struct Legend {
    /// The value where the heat map is 0.
    pub low: String,
    /// The value where the heat map is 1.
    pub high: String,
}

/// The legend; None for modes without false colours.
pub fn legend(mode: DisplayMode, scales: &Scales) -> Option<Legend> {
    let (low, high) = match mode {
        DisplayMode::BvhSteps => ("0".to_owned(), format!("{HOTTEST_STEPS:.0}+")),
        DisplayMode::Samples => ("0".to_owned(), scales.most_samples.to_string()),
        DisplayMode::Noise => ("0 %".to_owned(), format!("{:.0} %+", 100.0 * HOTTEST_NOISE)),
        _ => return None,
    };
    Some(Legend { low, high })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn false_colours_have_a_legend_and_light_has_none() {
        let scales = Scales {
            most_samples: 64,
            ..Scales::default()
        };
        let high = |mode| legend(mode, &scales).map(|legend| legend.high);
        assert_eq!(high(DisplayMode::Samples).as_deref(), Some("64"));
        assert_eq!(high(DisplayMode::Noise).as_deref(), Some("25 %+"));
        assert_eq!(high(DisplayMode::Shaded), None);
    }
}
