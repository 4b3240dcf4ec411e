//! A picture over the uv square. Conventions are Mitsuba 3's: v = 0 is the upper edge of the picture, texel centres lie
//! at half-integers, and texels are made linear before they are interpolated.

use std::sync::Arc;

use glam::{Affine2, Vec2};

use super::Image;
use crate::color::{Rgb, luminance};

/// The interpolation of values between texel centres.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Filter {
    /// The texel that the point lies in.
    Nearest,
    /// The mean of the four texels around the point, weighted by their distances.
    #[default]
    Bilinear,
}

/// The continuation of a picture outside of the unit square.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Wrap {
    /// The picture is repeated.
    #[default]
    Repeat,
    /// The picture is repeated, and every other repetition is mirrored.
    Mirror,
    /// The texels of the edge.
    Clamp,
}

/// A picture with its filter, wrap mode and transform; the picture itself is shared.
#[derive(Clone, Debug)]
pub struct Bitmap {
    /// The picture, which is sampled at `to_uv` times uv.
    pub image: Arc<Image>,
    /// The interpolation between texel centres.
    pub filter: Filter,
    /// The continuation outside of the unit square, along u and along v.
    pub wrap: [Wrap; 2],
    /// Whether samples are used without decoding to linear, for pictures of data.
    pub raw: bool,
    /// The transform of uv before sampling.
    pub to_uv: Affine2,
}

/// Two bitmaps are equal if they share a picture and its settings; samples are not compared.
impl PartialEq for Bitmap {
    fn eq(&self, other: &Self) -> bool {
        Arc::ptr_eq(&self.image, &other.image)
            && (self.filter, self.wrap, self.raw, self.to_uv) == (other.filter, other.wrap, other.raw, other.to_uv)
    }
}

/// A coordinate more texels than this from the origin has no fraction left.
const FARTHEST: f32 = (1 << 30) as f32;

impl Bitmap {
    pub(super) fn color(&self, uv: Vec2) -> Rgb {
        let at = self.in_texels(uv);
        match self.filter {
            Filter::Nearest => self.texel(whole(at.x), whole(at.y)),
            Filter::Bilinear => {
                let ([a, b, c, d], weight) = self.cell(at);
                a.lerp(b, weight.x).lerp(c.lerp(d, weight.x), weight.y)
            }
        }
    }

    /// The derivative of the luminance by u and v; zero for the nearest texel. (Mitsuba 3.9 scales by the picture's
    /// size after `to_uv` instead of before it, which differs where `to_uv` rotates a picture that is not square.)
    pub(super) fn gradient(&self, uv: Vec2) -> Vec2 {
        if self.filter == Filter::Nearest {
            return Vec2::ZERO;
        }
        let (corners, weight) = self.cell(self.in_texels(uv));
        let [a, b, c, d] = corners.map(luminance);
        let lerp = |from: f32, to: f32, weight: f32| from + (to - from) * weight;
        let by_texel = Vec2::new(lerp(b - a, d - c, weight.y), lerp(c - a, d - b, weight.x));
        self.to_uv.matrix2.transpose() * (by_texel * self.size())
    }

    /// Average colour of the picture.
    pub(super) fn mean(&self) -> Rgb {
        self.image.mean(self.raw)
    }

    /// The extent of a texel, in coordinates after `to_uv`.
    pub(super) fn texel_extent(&self) -> f32 {
        self.size().recip().min_element()
    }

    fn size(&self) -> Vec2 {
        Vec2::new(self.image.width() as f32, self.image.height() as f32)
    }

    fn in_texels(&self, uv: Vec2) -> Vec2 {
        self.to_uv.transform_point2(uv) * self.size()
    }

    /// The four texels whose centres surround a point (upper left, upper right, lower left, lower right), and the
    /// weights of the right and the lower ones.
    fn cell(&self, at: Vec2) -> ([Rgb; 4], Vec2) {
        let at = at - 0.5;
        let (x, y) = (whole(at.x), whole(at.y));
        let fraction = at - at.floor();
        let corners = [(x, y), (x + 1, y), (x, y + 1), (x + 1, y + 1)].map(|(x, y)| self.texel(x, y));
        // A NaN coordinate has no fraction.
        (corners, if fraction.is_finite() { fraction } else { Vec2::ZERO })
    }

    fn texel(&self, x: i64, y: i64) -> Rgb {
        let (width, height) = (self.image.width(), self.image.height());
        let [across, down] = self.wrap;
        self.image
            .texel(across.apply(x, width), down.apply(y, height), self.raw)
    }
}

/// The texel index of a coordinate; 0 for NaN.
fn whole(coordinate: f32) -> i64 {
    coordinate.floor().clamp(-FARTHEST, FARTHEST) as i64
}

impl Wrap {
    /// The texel in `0..count` used for the index `at`.
    fn apply(self, at: i64, count: u32) -> u32 {
        let count = i64::from(count);
        let within = match self {
            Self::Repeat => at.rem_euclid(count),
            Self::Mirror => {
                let there_and_back = at.rem_euclid(2 * count);
                there_and_back.min(2 * count - 1 - there_and_back)
            }
            Self::Clamp => at.clamp(0, count - 1),
        };
        within as u32
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::texture::{Samples, Transfer};

    /// Two texels wide, two high: 0, 1 above, 2, 4 below.
    fn four(filter: Filter, wrap: Wrap) -> Bitmap {
        let samples = Samples::F32(vec![0.0, 1.0, 2.0, 4.0]);
        Bitmap {
            image: Arc::new(Image::new(2, 2, 1, samples, Transfer::Linear).unwrap()),
            filter,
            wrap: [wrap; 2],
            raw: false,
            to_uv: Affine2::IDENTITY,
        }
    }

    fn value(bitmap: &Bitmap, u: f32, v: f32) -> f32 {
        bitmap.color(Vec2::new(u, v)).x
    }

    #[test]
    fn nearest_takes_the_texel_around_the_point() {
        let bitmap = four(Filter::Nearest, Wrap::Repeat);
        for (u, v, expected) in [
            (0.0, 0.0, 0.0),
            (0.499, 0.499, 0.0),
            (0.5, 0.0, 1.0),
            (0.0, 0.5, 2.0),
            (0.99, 0.99, 4.0),
            (1.0, 1.0, 0.0),
            (-0.01, 0.0, 1.0),
        ] {
            assert_eq!(value(&bitmap, u, v), expected, "{u} {v}");
        }
    }

    #[test]
    fn bilinear_is_exact_at_centres_and_even_between() {
        let bitmap = four(Filter::Bilinear, Wrap::Clamp);
        for (u, v, expected) in [
            (0.25, 0.25, 0.0),
            (0.75, 0.25, 1.0),
            (0.25, 0.75, 2.0),
            (0.75, 0.75, 4.0),
            (0.5, 0.25, 0.5),
            (0.5, 0.5, 1.75),
            // Outside of the outermost centres the edge continues.
            (0.1, -3.0, 0.0),
            (7.0, 0.5, 2.5),
        ] {
            assert!((value(&bitmap, u, v) - expected).abs() < 1e-6, "{u} {v}");
        }
    }

    #[test]
    fn wraps_meet_their_neighbours() {
        // u = 0 shows half of the last texel with repeat, and the first texel alone with mirror and clamp.
        for (wrap, expected) in [(Wrap::Repeat, 0.5), (Wrap::Mirror, 0.0), (Wrap::Clamp, 0.0)] {
            assert_eq!(value(&four(Filter::Bilinear, wrap), 0.0, 0.25), expected);
        }
        let row = |wrap: Wrap| (-5..6).map(|at| wrap.apply(at, 3)).collect::<Vec<_>>();
        assert_eq!(row(Wrap::Repeat), [1, 2, 0, 1, 2, 0, 1, 2, 0, 1, 2]);
        assert_eq!(row(Wrap::Mirror), [1, 2, 2, 1, 0, 0, 1, 2, 2, 1, 0]);
        assert_eq!(row(Wrap::Clamp), [0, 0, 0, 0, 0, 0, 1, 2, 2, 2, 2]);
    }

    #[test]
    fn u_and_v_are_continued_each_in_its_own_way() {
        let mut bitmap = four(Filter::Nearest, Wrap::Clamp);
        bitmap.wrap = [Wrap::Clamp, Wrap::Repeat];
        // Right of the picture its last column continues, and below it the rows repeat.
        let below = [1.25, 1.75].map(|v| value(&bitmap, 3.25, v));
        assert_eq!(below, [1.0, 4.0]);
        bitmap.wrap = [Wrap::Mirror, Wrap::Clamp];
        assert_eq!([1.25, 1.75].map(|u| value(&bitmap, u, 5.0)), [4.0, 2.0]);
    }

    #[test]
    fn texels_are_decoded_before_they_are_mixed() {
        let samples = Samples::U8(vec![0, 255]);
        let image = Arc::new(Image::new(2, 1, 1, samples, Transfer::Srgb).unwrap());
        let mut bitmap = Bitmap {
            image,
            ..four(Filter::Bilinear, Wrap::Clamp)
        };
        assert_eq!(value(&bitmap, 0.5, 0.5), 0.5);
        bitmap.image = Arc::new(Image::new(2, 1, 1, Samples::U8(vec![188, 188]), Transfer::Srgb).unwrap());
        assert!((value(&bitmap, 0.5, 0.5) - 0.502_886).abs() < 1e-5);
        bitmap.raw = true;
        assert!((value(&bitmap, 0.5, 0.5) - 188.0 / 255.0).abs() < 1e-6);
    }

    #[test]
    fn gradients_are_differences() {
        for wrap in [Wrap::Repeat, Wrap::Mirror, Wrap::Clamp] {
            let mut bitmap = four(Filter::Bilinear, wrap);
            bitmap.to_uv = Affine2::from_cols_array(&[2.0, 0.5, -1.0, 3.0, 0.3, 0.1]);
            for i in 0..100 {
                let uv = Vec2::new((i * 37 % 100) as f32, (i * 59 % 100) as f32) * 0.023;
                // Central differences of a bilinear patch are exact but for rounding, where they do not leave the
                // patch.
                let h = 1e-3;
                let cell = |uv: Vec2| (bitmap.in_texels(uv) - 0.5).floor();
                let steps = [Vec2::X * h, Vec2::Y * h];
                if steps.iter().any(|&step| cell(uv + step) != cell(uv - step)) {
                    continue;
                }
                let [du, dv] =
                    steps.map(|step| luminance(bitmap.color(uv + step) - bitmap.color(uv - step)) / (2.0 * h));
                let error = (bitmap.gradient(uv) - Vec2::new(du, dv)).abs().max_element();
                // Values up to 4 with 24 bits, twice, over 2 h.
                assert!(error < 2e-3, "{wrap:?} {uv}: {error}");
            }
            bitmap.filter = Filter::Nearest;
            assert_eq!(bitmap.gradient(Vec2::splat(0.3)), Vec2::ZERO);
        }
    }

    #[test]
    fn what_is_no_place_is_a_texel_nevertheless() {
        for filter in [Filter::Nearest, Filter::Bilinear] {
            for wrap in [Wrap::Repeat, Wrap::Mirror, Wrap::Clamp] {
                let bitmap = four(filter, wrap);
                for odd in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY, f32::MAX, -1e30, 1e10] {
                    for uv in [Vec2::new(odd, 0.3), Vec2::new(0.3, odd), Vec2::splat(odd)] {
                        let color = bitmap.color(uv);
                        assert!((0.0..=4.0).contains(&color.x), "{filter:?} {wrap:?} {uv}: {color}");
                        assert!(bitmap.gradient(uv).is_finite());
                    }
                }
            }
        }
    }
}
