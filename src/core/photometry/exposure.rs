//! Exposure as photographers say it: by exposure values at ISO 100 (EV100), or by shutter, aperture and sensitivity.
//!
//! A picture of exposure value `EV100` shows white, the value 1, for a luminance of 1.2 * 2^EV100 nits. That is the
//! luminance that saturates a sensor whose saturation-based speed is S: it takes `H = 78 / S` lux seconds (ISO
//! 12232:2019), a lens brings `H = q L t / N^2` to the sensor with `q = 0.65`, and `EV100 = log2(N^2 / t * 100 / S)`,
//! so that `L = 78 / (0.65 * 100) * 2^EV100` (Lagarde and de Rousiers, Moving Frostbite to Physically Based Rendering,
//! SIGGRAPH 2014, section 5.1.2). Radiance times 683 is luminance in nits.

use super::LUMENS_PER_WATT;

/// Nits that are shown white at an exposure value of 0: 78 / (100 q) with q = 0.65.
pub const WHITE_NITS_AT_EV_0: f32 = 1.2;

/// The settings of a camera on which the exposure depends.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CameraExposure {
    /// The aperture as an f-number, above 0.
    pub f_number: f32,
    /// The time that the shutter is open in seconds, above 0.
    pub shutter: f32,
    /// The sensitivity by ISO, above 0.
    pub iso: f32,
}

impl Default for CameraExposure {
    /// Bright sun by the rule of sixteen: f/16 for 1/100 s at ISO 100.
    fn default() -> Self {
        Self {
            f_number: 16.0,
            shutter: 0.01,
            iso: 100.0,
        }
    }
}

impl CameraExposure {
    /// The exposure value at ISO 100: `log2(N^2 / t * 100 / S)`.
    pub fn ev100(&self) -> f32 {
        (self.f_number.powi(2) / self.shutter * 100.0 / self.iso).log2()
    }

    /// The same aperture and sensitivity with the shutter time that gives the exposure value `ev100`.
    pub fn with_ev100(self, ev100: f32) -> Self {
        Self {
            shutter: self.f_number.powi(2) * 100.0 / (self.iso * ev100.exp2()),
            ..self
        }
    }
}

/// The exposure in stops, as powers of two on radiance, of an exposure value.
pub fn stops_of_ev100(ev100: f32) -> f32 {
    (LUMENS_PER_WATT / WHITE_NITS_AT_EV_0).log2() - ev100
}

/// The exposure value of an exposure in stops; the inverse of [`stops_of_ev100`].
pub fn ev100_of_stops(stops: f32) -> f32 {
    // The relation is its own inverse.
    stops_of_ev100(stops)
}

/// Parses an exposure to stops: a number of stops such as `1.5`, an exposure value such as `ev100:12`, or the aperture,
/// shutter time in seconds and sensitivity of a camera such as `f/8,1/60,400`. None for any other text.
pub fn parse(text: &str) -> Option<f32> {
    let number = |text: &str| text.trim().parse().ok().filter(|number: &f32| number.is_finite());
    let text = text.trim();
    if let Some(ev100) = text.strip_prefix("ev100:") {
        return number(ev100).map(stops_of_ev100);
    }
    let Some(camera) = text.strip_prefix("f/") else {
        return number(text);
    };
    let &[f_number, shutter, iso] = &camera.split(',').collect::<Vec<_>>()[..] else {
        return None;
    };
    let shutter = match shutter.split_once('/') {
        Some((above, below)) => number(above)? / number(below)?,
        None => number(shutter)?,
    };
    let camera = CameraExposure {
        f_number: number(f_number)?,
        shutter,
        iso: number(iso)?,
    };
    let is_possible = [camera.f_number, camera.shutter, camera.iso]
        .iter()
        .all(|number| *number > 0.0);
    let stops = stops_of_ev100(camera.ev100());
    (is_possible && stops.is_finite()).then_some(stops)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn assert_near(found: f32, expected: f32) {
        assert!((found - expected).abs() < 2e-3, "{found}, expected {expected}");
    }

    #[test]
    fn exposure_values_are_those_of_photographers() {
        // Tables of exposure values: f/16 with 1/125 s is EV 15, f/2.8 with 1/60 s is EV 9 (rounded series).
        let camera = |f_number, shutter, iso| CameraExposure { f_number, shutter, iso };
        assert_near(camera(16.0, 1.0 / 128.0, 100.0).ev100(), 15.0);
        assert_near(camera(8f32.sqrt(), 1.0 / 64.0, 100.0).ev100(), 9.0);
        assert_near(camera(1.0, 1.0, 100.0).ev100(), 0.0);
        // Four times the sensitivity is two stops.
        assert_near(camera(1.0, 1.0, 400.0).ev100(), -2.0);
        assert_near(camera(5.6, 0.5, 800.0).with_ev100(7.25).ev100(), 7.25);
    }

    #[test]
    fn white_saturates_where_the_standard_says() {
        // At EV100 15, 1.2 * 32768 nits are white.
        let radiance = 1.2 * 32768.0 / LUMENS_PER_WATT;
        assert_near(radiance * stops_of_ev100(15.0).exp2(), 1.0);
        assert_near(ev100_of_stops(stops_of_ev100(7.25)), 7.25);
        // A reflected-light meter with K = 12.5 (ISO 2720) on 4096 nits: 2^15 = 100 * 4096 / 12.5.
        let metered = |nits: f32| (100.0 * nits / 12.5).log2();
        assert_near(metered(4096.0), 15.0);
        let nits = 4096.0;
        let shown = nits / LUMENS_PER_WATT * stops_of_ev100(metered(nits)).exp2();
        assert_near(shown, 1.0 / 9.6);
    }

    #[test]
    fn exposures_are_stops_values_or_cameras() {
        assert_eq!(parse(" -1.5"), Some(-1.5));
        assert_near(parse("ev100:12").expect("a value"), stops_of_ev100(12.0));
        for text in ["f/8,1/64,200", "f/8, 0.015625, 200"] {
            assert_near(parse(text).expect("a camera"), stops_of_ev100(11.0));
        }
        for wrong in [
            "",
            "nan",
            "ev100:",
            "ev12",
            "f/8",
            "f/0,1,1",
            "f/8,1/0,100",
            "f/-8,1,-1",
            "f/8,1,100,2",
            "8,1,100",
        ] {
            assert_eq!(parse(wrong), None, "{wrong}");
        }
    }
}
