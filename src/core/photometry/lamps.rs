//! Real lamps and skies, with their light in photometric units and the sources of the figures.
//!
//! A standard gives its figure itself. Where a source gives a range, the table has a number within it.

use super::LightUnit;

/// The form in which a lamp is added to a scene; lengths are in metres, angles in degrees.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum LampForm {
    /// A point that shines in all directions.
    Point,
    /// A cone downwards, by its half angles.
    Spot {
        /// The half angle beyond which there is no light.
        cutoff: f32,
        /// The half angle up to which the intensity is full.
        beam: f32,
    },
    /// A rectangle that shines on one side.
    Rectangle {
        /// Width and height.
        size: [f32; 2],
    },
    /// A cylinder that shines outwards.
    Tube {
        /// The radius.
        radius: f32,
        /// The length.
        length: f32,
    },
    /// Parallel light.
    Parallel,
    /// Even light from all directions.
    Sky,
}

/// A lamp or a sky.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Lamp {
    /// The word for it in scripts and names.
    pub name: &'static str,
    /// The label in menus.
    pub label: &'static str,
    /// How much light it gives, in `unit`.
    pub amount: f32,
    /// The unit of the amount.
    pub unit: LightUnit,
    /// The correlated colour temperature in kelvin.
    pub kelvin: f32,
    /// The distance of the colour from a black body, see [`crate::color::temperature`].
    pub duv: f32,
    /// The form of a new one.
    pub form: LampForm,
    /// Where the figures are from.
    pub source: &'static str,
}

impl Lamp {
    /// The lamp of this name.
    pub fn of_name(name: &str) -> Option<&'static Self> {
        LAMPS.iter().find(|lamp| lamp.name == name)
    }
}

macro_rules! lamps {
    ($($name:literal $label:literal: $amount:literal $unit:ident, $kelvin:literal K $(duv $duv:literal)?, $form:expr,
       $source:expr;)*) => {
        /// All lamps, from the dimmest to those of outdoors.
        pub const LAMPS: &[Lamp] = &[$(Lamp {
            name: $name,
            label: $label,
            amount: $amount,
            unit: LightUnit::$unit,
            kelvin: $kelvin,
            duv: 0.0 $(+ $duv)?,
            form: $form,
            source: $source,
        }),*];
    };
}

const BULBS: &str = "European Commission, How to read the packaging: lamps that replace filament bulbs of 40, 60 and 100 W have 410 to 470, 700 to 810 and 1,300 to 1,530 lm; 2700 K is warm white by ANSI C78.377";
const TUBES: &str =
    "Usual in catalogues of T8 tubes in colour 840, which is 4000 K: 93 lm/W at 36 W, and 90 lm/W at 58 W";
const SODIUM: &str = "van Bommel, Road Lighting, Springer 2015, section 10.2.3: 80 lm/W of small high-pressure sodium lamps, and around 2000 K";
const REFLECTOR: &str =
    "Lux magazine, May 2012: 350 lm of a halogen lamp GU10 of 50 W; beams of 36 degrees and 3000 K are usual";

/// Half of the intensity is 18 degrees beside the axis, since it falls linearly with the angle.
const DOWNLIGHT: LampForm = LampForm::Spot {
    cutoff: 27.0,
    beam: 9.0,
};

lamps! {
    "candle" "Candle": 12.57 Lumen, 1850.0 K, LampForm::Point,
        "One candela in all directions, after which the unit is named; flames have 1850 to 2000 K";
    "bulb-40w" "Bulb, 40 W": 470.0 Lumen, 2700.0 K, LampForm::Point, BULBS;
    "bulb-60w" "Bulb, 60 W": 806.0 Lumen, 2700.0 K, LampForm::Point, BULBS;
    "bulb-100w" "Bulb, 100 W": 1521.0 Lumen, 2700.0 K, LampForm::Point, BULBS;
    "filament-60w" "Filament bulb, 60 W": 700.0 Lumen, 2700.0 K, LampForm::Point,
        "European Commission, How to read the packaging: at least 700 lm of a lamp that replaces a filament bulb of 60 W";
    "spotlight" "Spotlight, 50 W halogen": 350.0 Lumen, 3000.0 K, DOWNLIGHT, REFLECTOR;
    "tube-36w" "Tube T8, 36 W": 3350.0 Lumen, 4000.0 K, LampForm::Tube { radius: 0.013, length: 1.2 }, TUBES;
    "tube-58w" "Tube T8, 58 W": 5200.0 Lumen, 4000.0 K, LampForm::Tube { radius: 0.013, length: 1.5 }, TUBES;
    "street-lamp" "Street lamp, 70 W sodium": 5600.0 Lumen, 2000.0 K,
        LampForm::Spot { cutoff: 80.0, beam: 60.0 }, SODIUM;
    "screen" "Screen": 80.0 Nit, 6504.0 K duv 0.0032, LampForm::Rectangle { size: [0.6, 0.34] },
        "IEC 61966-2-1:1999, reference display of sRGB: 80 cd/m² and D65";
    "hdr-screen" "Screen, HDR white": 203.0 Nit, 6504.0 K duv 0.0032, LampForm::Rectangle { size: [1.2, 0.68] },
        "ITU-R BT.2408: reference white of HDR production, 203 cd/m² and D65";
    "full-moon" "Full moon": 0.25 Lux, 4100.0 K, LampForm::Parallel,
        "Kyba, Mohar and Posch, How bright is moonlight?, Astronomy & Geophysics 58, 2017: up to 0.32 lx high in the sky, and 0.05 to 0.1 lx on level ground as a rule";
    "overcast-sky" "Overcast sky": 10000.0 Lux, 6504.0 K duv 0.0032, LampForm::Sky,
        "A round number of which daylight factors are often told; D65 stands for average daylight (CIE 15)";
    "noon-sun" "Noon sun": 100000.0 Lux, 5500.0 K, LampForm::Parallel,
        "Some four fifths of the solar illuminance constant, 128,000 lx, pass a clear sky";
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::color::temperature::{DUVS, TEMPERATURES};

    #[test]
    fn lamps_have_names_of_their_own_and_colours() {
        for (index, lamp) in LAMPS.iter().enumerate() {
            let first = LAMPS.iter().position(|other| other.name == lamp.name);
            assert_eq!(first, Some(index), "{}", lamp.name);
            assert!(
                TEMPERATURES.contains(&lamp.kelvin) && DUVS.contains(&lamp.duv),
                "{}",
                lamp.name
            );
            assert!(lamp.amount > 0.0 && !lamp.source.is_empty(), "{}", lamp.name);
            let fits = match lamp.form {
                LampForm::Parallel | LampForm::Sky => lamp.unit == LightUnit::Lux,
                LampForm::Rectangle { .. } => matches!(lamp.unit, LightUnit::Nit | LightUnit::Lumen),
                LampForm::Point | LampForm::Spot { .. } | LampForm::Tube { .. } => lamp.unit == LightUnit::Lumen,
            };
            assert!(fits, "{}", lamp.name);
        }
    }
}
