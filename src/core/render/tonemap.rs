//! Maps linear radiance to the bytes of a display: white balance, exposure, tone curve, sRGB encoding.
//!
//! Not part of the accumulated or saved EXR data: it can be changed at any time without rendering again.
//!
//! Sources of the curves: E. Reinhard et al., "Photographic Tone Reproduction for Digital Images", 2002, eq. 3; S.
//! Hill's fit of the ACES reference rendering transform and sRGB output transform; J. Hable, "Uncharted 2: HDR
//! Lighting", GDC 2010; T. Sobotka's AgX in B. Wrensch's polynomial form, "Minimal AgX Implementation", 2023.

use std::ops::RangeInclusive;
use std::sync::LazyLock;

use glam::{Mat3, Vec3};

use super::white_balance::WhiteBalance;
use crate::color::{LUMINANCE, Rgb, linear_from_srgb, srgb_from_linear};
use crate::math::Vector;
use crate::math::lanes::{LANES, Lanes, Vec3Lanes};

declare_names! {
    /// The curve that brings radiance beyond the range of the display into it.
    #[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
    pub enum ToneMap {
        /// Each component is cut off at 1: exact below, and what other renderers write by default.
        #[default]
        Clip = "clip",
        /// Reinhard's L / (1 + L) on luminance: it keeps the hue and never reaches white.
        Reinhard = "reinhard",
        /// The film look of ACES: contrast, and bright colours that bleach towards white.
        Aces = "aces",
        /// The film curve of Uncharted 2: a soft foot and a long shoulder, white at four stops above middle grey and
        /// more.
        Filmic = "filmic",
        /// AgX: it has low contrast over 16.5 stops, and bright colours bleach without a shift of hue.
        AgX = "agx",
    }
}

/// The settings for displaying a picture.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Display {
    /// The exposure in stops: the radiance is first multiplied by two to this power.
    pub exposure_ev: f32,
    /// The white balance, applied to linear colours before the tone map.
    pub white_balance: WhiteBalance,
    /// The curve from linear colours to display values.
    pub tone_map: ToneMap,
}

impl Display {
    /// The exposures with distinct effects, in stops: beyond them every picture is black or white.
    pub const EXPOSURES: RangeInclusive<f32> = -MOST_STOPS..=MOST_STOPS;

    /// One pixel, sRGB-encoded. NaN and negative components are black, infinite ones white.
    pub fn encode(&self, radiance: Rgb) -> [u8; 3] {
        self.encoder().encode(radiance)
    }

    /// A whole picture as R, G, B, 255 per pixel, for a texture. The shorter of the two slices ends it.
    pub fn encode_rgba(&self, radiance: &[Rgb], rgba: &mut [u8]) {
        let mut targets = rgba.chunks_exact_mut(4);
        self.encoder().encode_each(radiance, |[red, green, blue]| {
            if let Some(bytes) = targets.next() {
                bytes.copy_from_slice(&[red, green, blue, 255]);
            }
        });
    }

    /// A whole picture as R, G, B per pixel, for a file.
    pub(crate) fn encode_rgb(&self, radiance: &[Rgb]) -> Vec<u8> {
        let mut bytes = Vec::with_capacity(3 * radiance.len());
        self.encoder().encode_each(radiance, |pixel| bytes.extend(pixel));
        bytes
    }

    /// Prepares the conversion for many pixels.
    pub fn encoder(&self) -> Encoder {
        let scale = self.exposure_ev.clamp(-MOST_STOPS, MOST_STOPS).exp2();
        Encoder {
            scale,
            balance: self.white_balance.adaptation().map(|matrix| scale * matrix),
            tone_map: self.tone_map,
            srgb: &SRGB,
        }
    }
}

/// Radiance after exposure is clamped to this: every curve is flat there, and none of them overflows.
const BRIGHTEST: f32 = 65_504.0;

/// The limit keeps the factor from being 0 or infinite: zero radiance stays black and infinite radiance white.
const MOST_STOPS: f32 = 100.0;

/// A [`Display`] prepared for many pixels.
pub struct Encoder {
    scale: f32,
    /// The white balance with the scale; None if there is only the scale.
    balance: Option<Mat3>,
    tone_map: ToneMap,
    srgb: &'static SrgbTable,
}

impl Encoder {
    /// Encodes one pixel as [`Display::encode`]. For many pixels [`Self::encode_each`] is several times as fast.
    #[inline]
    pub fn encode(&self, radiance: Rgb) -> [u8; 3] {
        self.bytes(self.shown(Vec3Lanes::splat(radiance)))[0]
    }

    /// Encodes pixels, which are passed to `take` one after the other.
    #[inline]
    pub fn encode_each(&self, radiance: &[Rgb], mut take: impl FnMut([u8; 3])) {
        for pixels in radiance.chunks(LANES) {
            let bytes = self.bytes(self.shown(side_by_side(pixels)));
            bytes.into_iter().take(pixels.len()).for_each(&mut take);
        }
    }

    /// Encodes pixels as [`Self::encode_each`] does, with 16 bits.
    pub fn encode_each_16(&self, radiance: &[Rgb], mut take: impl FnMut([u16; 3])) {
        for pixels in radiance.chunks(LANES) {
            let shown = self.shown(side_by_side(pixels));
            for lane in 0..pixels.len() {
                let encoded = match &shown {
                    Shown::Linear(linear) => linear.get(lane).clamp(Vec3::ZERO, Vec3::ONE).map(srgb_from_linear),
                    Shown::Encoded(encoded) => encoded.get(lane),
                };
                take(encoded.to_array().map(|x| (x * 65_535.0 + 0.5) as u16));
            }
        }
    }

    #[inline]
    fn bytes(&self, shown: Shown) -> [[u8; 3]; LANES] {
        match shown {
            Shown::Linear(linear) => bytes_of(&linear, |x| self.srgb.encode(x)),
            Shown::Encoded(encoded) => bytes_of(&encoded, |x| (x * 255.0 + 0.5) as u8),
        }
    }

    #[inline]
    fn shown(&self, radiance: Vec3Lanes) -> Shown {
        let scaled = radiance * Lanes::splat(self.scale);
        let balanced = match &self.balance {
            Some(balance) => {
                // The matrix would turn an infinite value into NaN.
                let is_finite = radiance.x.is_finite() & radiance.y.is_finite() & radiance.z.is_finite();
                Vec3Lanes::select(is_finite, product(balance, radiance), scaled)
            }
            None => scaled,
        };
        // NaN is not above zero.
        let exposed = balanced.map(|x| x.fast_min(Lanes::splat(BRIGHTEST)) & x.simd_gt(Lanes::ZERO));
        Shown::Linear(match self.tone_map {
            ToneMap::Clip => exposed,
            ToneMap::Reinhard => {
                let luminance = exposed.dot(Vec3Lanes::splat(LUMINANCE));
                exposed.map(|x| x / (Lanes::ONE + luminance))
            }
            ToneMap::Aces => aces(exposed),
            ToneMap::Filmic => exposed.map(filmic),
            // AgX ends in display values: its own curve is the encoding.
            ToneMap::AgX => return Shown::Encoded(agx(exposed)),
        })
    }
}

/// Colours after the tone map.
enum Shown {
    /// Linear, perhaps beyond [0, 1].
    Linear(Vec3Lanes),
    /// Display-encoded, in [0, 1].
    Encoded(Vec3Lanes),
}

/// Up to sixteen pixels in lanes; further lanes are black.
#[inline]
fn side_by_side(pixels: &[Rgb]) -> Vec3Lanes {
    let of = |pixels: &[Rgb; LANES]| {
        let channel = |channel: usize| Lanes::new(std::array::from_fn(|lane| pixels[lane][channel]));
        Vec3Lanes::of(channel(0), channel(1), channel(2))
    };
    pixels.try_into().map_or_else(
        |_| {
            let mut all = [Rgb::ZERO; LANES];
            all[..pixels.len()].copy_from_slice(pixels);
            of(&all)
        },
        of,
    )
}

#[inline]
fn bytes_of(colors: &Vec3Lanes, byte: impl Fn(f32) -> u8) -> [[u8; 3]; LANES] {
    let [x, y, z] = [&colors.x, &colors.y, &colors.z].map(Lanes::as_array);
    std::array::from_fn(|lane| [byte(x[lane]), byte(y[lane]), byte(z[lane])])
}

#[inline]
fn product(matrix: &Mat3, v: Vec3Lanes) -> Vec3Lanes {
    let row = |index: usize| {
        let row = matrix.row(index).to_array().map(Lanes::splat);
        row[0].mul_add(v.x, row[1].mul_add(v.y, row[2] * v.z))
    };
    Vec3Lanes::of(row(0), row(1), row(2))
}

/// Maps linear colours to linear ones, from 0 to about 1.
#[inline]
fn aces(linear: Vec3Lanes) -> Vec3Lanes {
    let rendering_from_srgb = Mat3::from_cols_array_2d(&[
        [0.59719, 0.07600, 0.02840],
        [0.35458, 0.90834, 0.13383],
        [0.04823, 0.01566, 0.83777],
    ]);
    let srgb_from_output = Mat3::from_cols_array_2d(&[
        [1.60475, -0.10208, -0.00327],
        [-0.53108, 1.10813, -0.07276],
        [-0.07367, -0.00605, 1.07602],
    ]);
    let fit = |seen: Lanes| {
        let numerator = seen * (seen + 0.024_578_6) - 0.000_090_537;
        let denominator = seen * (seen * 0.983_729 + 0.432_951) + 0.238_081;
        numerator / denominator
    };
    product(&srgb_from_output, product(&rendering_from_srgb, linear).map(fit))
}

/// Maps linear values to linear ones, from 0 to a little above 1.
#[inline]
fn filmic(linear: Lanes) -> Lanes {
    /// The linear white: exposed twice as bright, it becomes white.
    const WHITE: f32 = 11.2;
    let curve = |x: Lanes| {
        let (shoulder, slope, angle, toe, rise, run) = (0.15, 0.5, 0.1, 0.2, 0.02, 0.3);
        (x * (x * shoulder + angle * slope) + toe * rise) / (x * (x * shoulder + slope) + toe * run) - rise / run
    };
    (curve(linear * 2.0) / curve(Lanes::splat(WHITE))).fast_max(Lanes::ZERO)
}

/// Maps linear colours to display-encoded ones.
#[inline]
fn agx(linear: Vec3Lanes) -> Vec3Lanes {
    const LOWEST_STOP: f32 = -12.473_93;
    const HIGHEST_STOP: f32 = 4.026_069;
    let inset = Mat3::from_cols_array_2d(&[
        [0.842_479_1, 0.042_328_24, 0.042_375_65],
        [0.078_433_6, 0.878_468_6, 0.078_433_6],
        [0.079_223_745, 0.079_166_13, 0.879_143],
    ]);
    let outset = Mat3::from_cols_array_2d(&[
        [1.196_879, -0.052_896_85, -0.052_971_635],
        [-0.098_020_88, 1.151_903_1, -0.098_043_45],
        [-0.099_029_74, -0.098_961_18, 1.151_073_7],
    ]);
    let curve = |x: Lanes| {
        let stops = x.fast_max(Lanes::splat(1e-10)).ln() * std::f32::consts::LOG2_E;
        let stops = stops
            .fast_max(Lanes::splat(LOWEST_STOP))
            .fast_min(Lanes::splat(HIGHEST_STOP));
        let x = (stops - LOWEST_STOP) / (HIGHEST_STOP - LOWEST_STOP);
        ((((((x * 15.5 - 40.14) * x + 31.96) * x) - 6.868) * x + 0.4298) * x + 0.1191) * x - 0.002_32
    };
    let encoded = product(&outset, product(&inset, linear).map(curve));
    encoded.map(|x| x.fast_max(Lanes::ZERO).fast_min(Lanes::ONE))
}

/// The sRGB curve to eight bits without powers, and without error: the same byte as rounding the exact curve.
///
/// The range is cut into cells so narrow that none holds two changes of the byte (near black the curve rises by 12.92 *
/// 255 / 4096 = 0.8 bytes per cell). Each cell knows its first byte; one comparison decides on the next.
struct SrgbTable {
    first_byte: [u8; CELLS + 1],
    /// The smallest linear value with at least this byte; the last is out of reach.
    starts: [f32; 257],
}

const CELLS: usize = 4096;

static SRGB: LazyLock<SrgbTable> = LazyLock::new(|| {
    let mut starts = [f32::INFINITY; 257];
    for (byte, start) in starts.iter_mut().enumerate().take(256) {
        *start = linear_from_srgb((byte as f32 - 0.5) / 255.0);
    }
    let mut first_byte = [0; CELLS + 1];
    for (cell, byte) in first_byte.iter_mut().enumerate() {
        let linear = cell as f32 / CELLS as f32;
        *byte = starts[1..].partition_point(|start| *start <= linear) as u8;
    }
    SrgbTable { first_byte, starts }
});

impl SrgbTable {
    #[inline]
    fn encode(&self, linear: f32) -> u8 {
        let linear = linear.clamp(0.0, 1.0);
        let byte = self.first_byte[(linear * CELLS as f32) as usize];
        byte + u8::from(linear >= self.starts[usize::from(byte) + 1])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn table_is_the_rounded_curve() {
        for step in 0..=1_000_000 {
            let linear = step as f32 / 1_000_000.0;
            let exact = 255.0 * f64::from(srgb_from_linear(linear)) + 0.5;
            let byte = f64::from(SRGB.encode(linear));
            // Within 1e-4 of a rounding border f32 itself cannot distinguish the two bytes.
            assert!(
                byte <= exact + 1e-4 && exact - 1e-4 < byte + 1.0,
                "{linear}: {byte}, {exact}"
            );
        }
    }

    #[test]
    fn every_byte_survives_the_way_there_and_back() {
        for byte in 0..=255_u8 {
            let linear = linear_from_srgb(f32::from(byte) / 255.0);
            assert_eq!(Display::default().encode(Vec3::splat(linear)), [byte; 3]);
        }
    }

    #[test]
    fn broken_numbers_are_black_or_white() {
        for tone_map in ToneMap::ALL {
            for exposure_ev in [-200.0, -3.0, 0.0, 3.0, 200.0] {
                let display = Display {
                    exposure_ev,
                    tone_map,
                    ..Display::default()
                };
                let black = display.encode(Vec3::ZERO);
                assert!(black.iter().all(|byte| *byte == 0), "{tone_map:?}");
                assert_eq!(display.encode(Vec3::NAN), black);
                assert_eq!(display.encode(Vec3::splat(-1.0)), black);
                assert_eq!(display.encode(Vec3::NEG_INFINITY), black);
                let white = display.encode(Vec3::INFINITY);
                assert!(white.iter().all(|byte| *byte >= 254), "{tone_map:?} {white:?}");
            }
        }
    }

    #[test]
    fn curves_rise_and_keep_grey() {
        for tone_map in ToneMap::ALL {
            let display = Display {
                tone_map,
                ..Display::default()
            };
            let mut last = 0;
            for step in 0..400 {
                let grey = (step as f32 * 0.05 - 12.0).exp2();
                let [red, green, blue] = display.encode(Vec3::splat(grey));
                assert!(green >= last, "{tone_map:?} falls at {grey}");
                // The matrices' rows sum to 1 only to four digits: one byte.
                assert!(red.abs_diff(green) <= 1 && blue.abs_diff(green) <= 1, "{tone_map:?}");
                last = green;
            }
            assert!(last > 230, "{tone_map:?} ends at {last}");
        }
    }

    /// The values are worked by hand from the formulas. Middle grey, 0.18: clip 0.18 -> sRGB 117.65; Reinhard 0.18 /
    /// 1.18 = 0.152_54 -> 108.87; filmic 0.093_06 / 0.725_13 = 0.128_34 -> 100.34; ACES (0.18 * 0.204_579 -
    /// 0.000_091) / (0.18 * 0.610_022 + 0.238_081) = 0.105_59 -> 91.4. AgX's curve pivots at middle grey, which it
    /// takes to one half of the display's range, 127.5.
    #[test]
    fn middle_grey() {
        let byte = |tone_map| {
            Display {
                tone_map,
                ..Display::default()
            }
            .encode(Vec3::splat(0.18))[1]
        };
        assert_eq!(byte(ToneMap::Clip), 118);
        assert_eq!(byte(ToneMap::Reinhard), 109);
        assert_eq!(byte(ToneMap::Aces), 91);
        assert_eq!(byte(ToneMap::Filmic), 100);
        assert!(byte(ToneMap::AgX).abs_diff(127) <= 1, "{}", byte(ToneMap::AgX));
    }

    /// The bytes are those of independent programs, rounded: `aces`, OpenColorIO 2.6's own "ACES-OUTPUT -
    /// ACES2065-1_to_CIE-XYZ-D65 - SDR-VIDEO_1.0" between the matrices of colour-science 0.4.7, whose curve Hill's
    /// fit approximates; `filmic`, `tonemapping_operator_filmic` of colour-hdri 0.2.6 with the constants of
    /// Uncharted 2; `reinhard`, NumPy; `agx`, OpenColorIO with Sobotka's configuration and lookup table of AgX ("AgX
    /// Base"), followed by the inverse of its matrix, which later versions have.
    #[test]
    fn curves_are_those_of_other_programs() {
        let colors = [
            [0.01, 0.01, 0.01],
            [0.18, 0.18, 0.18],
            [1.0, 1.0, 1.0],
            [4.0, 4.0, 4.0],
            [0.8, 0.2, 0.05],
            [2.0, 0.5, 4.0],
            [0.02, 0.3, 0.9],
            [10.0, 1.0, 0.1],
        ];
        let filmic = [
            [21, 21, 21],
            [100, 100, 100],
            [186, 186, 186],
            [246, 246, 246],
            [175, 105, 55],
            [220, 150, 246],
            [33, 124, 181],
            [255, 186, 77],
        ];
        let reinhard = [
            [25, 25, 25],
            [109, 109, 109],
            [188, 188, 188],
            [231, 231, 231],
            [205, 109, 55],
            [251, 135, 255],
            [33, 133, 218],
            [255, 139, 45],
        ];
        let aces = [
            [3, 3, 3],
            [91, 91, 91],
            [207, 207, 207],
            [244, 244, 244],
            [194, 104, 44],
            [241, 180, 246],
            [0, 127, 202],
            [255, 224, 156],
        ];
        let agx = [
            [25, 25, 25],
            [127, 128, 128],
            [201, 201, 201],
            [239, 239, 239],
            [200, 136, 90],
            [226, 188, 242],
            [93, 154, 201],
            [255, 211, 173],
        ];
        // Formulas agree up to rounding; the fit of ACES is within four bytes in saturated colours, and the polynomial
        // of AgX within two.
        for (tone_map, expected, tolerance) in [
            (ToneMap::Filmic, filmic, 1),
            (ToneMap::Reinhard, reinhard, 1),
            (ToneMap::Aces, aces, 4),
            (ToneMap::AgX, agx, 2),
        ] {
            let display = Display {
                tone_map,
                ..Display::default()
            };
            for (color, expected) in colors.into_iter().zip(expected) {
                let found = display.encode(Vec3::from_array(color));
                let is_near = (0..3).all(|i| found[i].abs_diff(expected[i]) <= tolerance);
                assert!(is_near, "{tone_map:?} of {color:?}: {found:?}, not {expected:?}");
            }
        }
    }

    #[test]
    fn a_stop_doubles() {
        let darker = Display::default().encode(Vec3::new(0.5, 0.25, 0.125));
        let display = Display {
            exposure_ev: 1.0,
            ..Display::default()
        };
        assert_eq!(display.encode(Vec3::new(0.25, 0.125, 0.0625)), darker);
        let mut rgba = [7; 8];
        display.encode_rgba(&[Vec3::ZERO, Vec3::ONE], &mut rgba);
        assert_eq!(rgba, [0, 0, 0, 255, 255, 255, 255, 255]);
        assert_eq!(display.encode_rgb(&[Vec3::ZERO, Vec3::ONE]), [0, 0, 0, 255, 255, 255]);
        // sRGB of 0.25 is 0.537099.
        let mut deep = Vec::new();
        let encoder = Display::default().encoder();
        encoder.encode_each_16(&[Vec3::new(0.25, 7.0, f32::NAN)], |pixel| deep.push(pixel));
        assert_eq!(deep, [[35_199, 65_535, 0]]);
    }
}
