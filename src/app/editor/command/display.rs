//! The display settings of the film: the shown quantity, and the conversion of light to colours of the display.
//! Independent of rendering and Bevy.

use super::bvh_overlay::BvhOverlay;
use super::compare_view::CompareView;
use super::grid_settings::GridSettings;
use super::light_mix::LightMix;
use super::light_paint::LightPaintCommand;
use super::meter_choice::MeterChoice;
use super::resolution::Enlarging;
use super::traits::Traits;

use std::ops::RangeInclusive;

use crate::render::tonemap::{Display, ToneMap};
use crate::render::white_balance::WhiteBalance;

/// All display settings of the film. A change of them needs no new samples.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DisplaySettings {
    /// The quantity of the film that is shown.
    pub mode: DisplayMode,
    /// The exposure in stops: the radiance is multiplied by two to this power.
    pub exposure: f32,
    /// The white balance of modes that show light, as is the tone map.
    pub white_balance: WhiteBalance,
    /// The curve from linear colours to the display's.
    pub tone_map: ToneMap,
}

impl Default for DisplaySettings {
    fn default() -> Self {
        Self {
            mode: DisplayMode::Shaded,
            exposure: 0.0,
            white_balance: WhiteBalance::default(),
            tone_map: ToneMap::default(),
        }
    }
}

impl DisplaySettings {
    /// The range of exposures, in stops.
    pub const EXPOSURES: RangeInclusive<f32> = -20.0..=20.0;

    /// The part that converts radiance to a colour of the display.
    pub(crate) fn tone(&self) -> Display {
        Display {
            exposure_ev: self.exposure,
            white_balance: self.white_balance,
            tone_map: self.tone_map,
        }
    }
}

/// The quantities of the film that can be shown.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum DisplayMode {
    /// The light of the whole scene.
    #[default]
    Shaded,
    /// The colour of the first surface that is not perfectly specular.
    Albedo,
    /// The world normal of the same surface.
    Normal,
    /// The depth: near is bright, over the range of the picture's depths.
    Depth,
    /// The texture coordinates: u in red, v in green, both modulo 1.
    Uv,
    /// Each material and each object has a colour of its own.
    Material,
    /// Each object has a colour of its own.
    Object,
    /// The samples per pixel, in false colour.
    Samples,
    /// The standard error of the luminance relative to it, in false colour.
    Noise,
    /// The luminance in false colour.
    Luminance,
    /// The illuminance of the surfaces in false colour, with contour lines.
    Illuminance,
    /// The light of one group of lights alone, by its layer of the film. Not among [`Self::ALL`].
    LightGroup(u8),
    /// The number of nodes of the acceleration structure that each camera ray visits, in false colour.
    BvhSteps,
    /// The optical depth of the media before the first surface, in false colour.
    OpticalDepth,
    /// Surfaces in their own colours, lit from the camera alone: visible at once, whatever the lights are.
    Headlight,
    /// All surfaces in the same grey, lit from the camera alone.
    Clay,
}

impl DisplayMode {
    /// The modes with their names, in the order of the menu.
    pub const ALL: [(Self, &'static str); 15] = [
        (Self::Shaded, "Shaded"),
        (Self::Albedo, "Albedo"),
        (Self::Normal, "Normal"),
        (Self::Depth, "Depth"),
        (Self::Uv, "UV"),
        (Self::Material, "Materials"),
        (Self::Object, "Objects"),
        (Self::Samples, "Samples"),
        (Self::Noise, "Noise"),
        (Self::Luminance, "Luminance"),
        (Self::Illuminance, "Illuminance"),
        (Self::OpticalDepth, "Optical depth"),
        (Self::BvhSteps, "BVH steps"),
        (Self::Headlight, "Headlight"),
        (Self::Clay, "Clay"),
    ];

    /// The next mode, cyclically.
    pub fn next(self) -> Self {
        let place = Self::ALL.iter().position(|(mode, _)| *mode == self);
        let next = place.map_or(0, |place| place + 1);
        Self::ALL[next % Self::ALL.len()].0
    }

    /// The name in menus and the status line.
    pub fn name(self) -> &'static str {
        match Self::ALL.iter().find(|(mode, _)| *mode == self) {
            Some((_, name)) => name,
            None => "One light",
        }
    }

    /// The mode itself, if it needs a film of its own, because a film of light lacks its quantity.
    pub(crate) fn with_own_film(self) -> Option<Self> {
        matches!(
            self,
            Self::BvhSteps | Self::OpticalDepth | Self::Illuminance | Self::Headlight | Self::Clay
        )
        .then_some(self)
    }

    /// The meaning of its colours, as a tool tip.
    pub fn about(self) -> &'static str {
        match self {
            Self::Shaded => "The light of the whole scene",
            Self::Albedo => "The colours of the surfaces, without light",
            Self::Normal => "The directions of the surfaces",
            Self::Depth => "The distance from the camera: near is bright",
            Self::Uv => "The texture coordinates: u in red, v in green",
            Self::Material => "A colour of its own for each material",
            Self::Object => "A colour of its own for each object",
            Self::Samples => "The samples of each pixel",
            Self::Noise => "The error that is expected of each pixel, as a share of its brightness",
            Self::Luminance => "How bright the picture is, in candela per square metre (nit)",
            Self::Illuminance => "The light that arrives on each surface, in lux, with lines of equal illuminance",
            Self::LightGroup(_) => "The light of one lamp alone",
            Self::BvhSteps => "The nodes of the acceleration structure that each ray visits",
            Self::OpticalDepth => "The fog before each surface: the share exp(-depth) of its light comes through",
            Self::Headlight => "Surfaces in their own colours, lit from the camera alone",
            Self::Clay => "Surfaces in one grey, lit from the camera alone",
        }
    }

    /// Whether it shows light, with exposure and tone map.
    pub(crate) fn is_light(self) -> bool {
        matches!(self, Self::Shaded | Self::LightGroup(_))
    }
}

/// The number of steps that the heat map paints in its hottest colour.
pub(crate) const HOTTEST_STEPS: f32 = 128.0;

/// The optical depth that is painted in the hottest colour: one fiftieth of the light passes.
pub(crate) const HOTTEST_DEPTH: f32 = 4.0;

/// The relative noise that is painted in the hottest colour.
pub(crate) const HOTTEST_NOISE: f32 = 0.25;

/// The heat map: black, blue, red, yellow, white for 0 to 1; sRGB-encoded.
pub fn heat(x: f32) -> [f32; 3] {
    const STOPS: [[f32; 3]; 5] = [
        [0.0, 0.0, 0.05],
        [0.15, 0.1, 0.75],
        [0.85, 0.15, 0.25],
        [1.0, 0.8, 0.1],
        [1.0, 1.0, 1.0],
    ];
    let x = if x > 0.0 {
        x.min(1.0) * (STOPS.len() - 1) as f32
    } else {
        0.0
    };
    let below = (x as usize).min(STOPS.len() - 2);
    let t = x - below as f32;
    std::array::from_fn(|channel| STOPS[below][channel] * (1.0 - t) + STOPS[below + 1][channel] * t)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::color::Rgb;

    #[test]
    fn a_stop_doubles() {
        let plain = DisplaySettings::default();
        let brighter = DisplaySettings { exposure: 1.0, ..plain };
        let shaded = |level: f32, settings: &DisplaySettings| settings.tone().encode(Rgb::splat(level));
        assert_eq!(shaded(0.2, &brighter), shaded(0.4, &plain));
        assert_ne!(shaded(0.2, &plain), shaded(0.4, &plain));
    }

    #[test]
    fn modes_go_round() {
        let mut mode = DisplayMode::Shaded;
        for _ in 0..DisplayMode::ALL.len() {
            mode = mode.next();
        }
        assert_eq!(mode, DisplayMode::Shaded);
        assert_eq!(DisplayMode::Shaded.next(), DisplayMode::Albedo);
        assert_eq!(DisplayMode::LightGroup(3).next(), DisplayMode::Shaded);
    }

    #[test]
    fn heat_rises() {
        let sum = |x: f32| heat(x).iter().sum::<f32>();
        assert!(sum(0.0) < sum(0.3) && sum(0.3) < sum(0.8) && sum(0.8) < sum(1.0));
        assert_eq!(heat(f32::NAN), heat(0.0));
        assert_eq!(heat(9.0), heat(1.0));
    }
}

/// A command about the display of the picture and the marks over it.
#[derive(Clone, Debug, PartialEq)]
pub enum DisplayCommand {
    /// Sets the display of the film.
    SetDisplay(DisplaySettings),
    /// Sets the exposure so that the picture is middle grey on average.
    ExposeAutomatically,
    /// Sets strength, colour, solo and mute of each light.
    SetLightMix(LightMix),
    /// Says which light is wanted, and by which lamps.
    PaintLight(LightPaintCommand),
    /// Keeps the picture for comparison.
    TakeSnapshot,
    /// Sets the comparison in the viewport.
    SetCompareView(CompareView),
    /// Measures the picture against the snapshot.
    Measure,
    /// Sets the quantities that meters measure.
    SetMeters(MeterChoice),
    /// Sets the overlay of acceleration structure boxes.
    SetOverlay(BvhOverlay),
    /// Shows or hides the safe frames for actions and titles.
    ShowSafeFrame(bool),
    /// Shows or hides the dimensions of the selection in the picture.
    ShowDimensions(bool),
    /// Sets the grid on the ground and the axes of the world.
    SetGrid(GridSettings),
    /// Shows the picture denoised, or as sampled.
    SetDenoising(bool),
    /// Sets the enlarging of a picture that has fewer pixels than its panel.
    SetEnlarging(Enlarging),
}

impl DisplayCommand {
    pub(super) fn traits(&self) -> Traits {
        match self {
            Self::PaintLight(command) => command.traits(),
            Self::TakeSnapshot | Self::Measure => Traits::NONE.of_pixels(),
            Self::SetDisplay(_)
            | Self::SetEnlarging(_)
            | Self::ExposeAutomatically
            | Self::SetLightMix(_)
            | Self::SetCompareView(_)
            | Self::SetMeters(_)
            | Self::SetOverlay(_)
            | Self::ShowSafeFrame(_)
            | Self::ShowDimensions(_)
            | Self::SetGrid(_)
            | Self::SetDenoising(_) => Traits::NONE,
        }
    }
}
