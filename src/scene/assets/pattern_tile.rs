//! Tiles of patterns: rectangles of which pictures are made for programs that do not have patterns, and which repeat.

use glam::{Affine2, Vec2};

use crate::color::Rgb;
use crate::scene::{Parameter, Pattern, Texture};

/// A rectangle of a texture that a box projection lays on shapes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Tile {
    /// The map from lengths on the sides of the box to the unit square of the picture.
    pub to_uv: Affine2,
    /// The share of the picture at its right and its upper end in which it turns into its beginning; 0 where joints of
    /// bricks lie at the end.
    margin: f32,
}

/// The least extent of a tile, in the coordinates of the texture inside the projection: metres in materials of the
/// library.
const EXTENT: f32 = 2.0;

/// The margin of tiles that do not end with a joint.
const MARGIN: f32 = 0.125;

/// The most rows after which a bond is expected to repeat.
const MOST_ROWS: usize = 12;

impl Tile {
    /// The tile of a texture; None unless it is a box projection.
    pub fn of(texture: &Texture) -> Option<Self> {
        let Texture::Pattern(pattern) = texture else {
            return None;
        };
        let Pattern::BoxProjection { input, to_uv, .. } = &**pattern else {
            return None;
        };
        let period = match input {
            Parameter::Texture(inside) => period(inside),
            Parameter::Constant(_) => None,
        };
        let extent = match period {
            Some(period) => (EXTENT / period).ceil().max(Vec2::ONE) * period,
            None => Vec2::splat(EXTENT),
        };
        let to_uv = Affine2::from_scale(extent.recip()) * *to_uv;
        let has_inverse = to_uv.is_finite() && to_uv.matrix2.determinant() != 0.0;
        has_inverse.then_some(Self {
            to_uv,
            margin: if period.is_some() { 0.0 } else { MARGIN },
        })
    }

    /// The value of the picture at a place of its unit square, given the values at places of that square and beyond.
    pub fn value(&self, at: Vec2, value: impl Fn(Vec2) -> Rgb) -> Rgb {
        let fade = |x: f32| match self.margin > 0.0 {
            true => ((x - 1.0) / self.margin + 1.0).clamp(0.0, 1.0),
            false => 0.0,
        };
        let (right, up) = (fade(at.x), fade(at.y));
        let shares = [
            (Vec2::ZERO, (1.0 - right) * (1.0 - up)),
            (Vec2::X, right * (1.0 - up)),
            (Vec2::Y, (1.0 - right) * up),
            (Vec2::ONE, right * up),
        ];
        let parts = shares.into_iter().filter(|(_, share)| *share > 0.0);
        parts.map(|(moved, share)| share * value(at - moved)).sum()
    }

    /// The place in the coordinates of the box.
    pub fn place(&self, at: Vec2) -> Vec2 {
        self.to_uv.inverse().transform_point2(at)
    }
}

/// The extents after which the first bricks in a texture repeat along both axes; None without bricks, or if they are
/// turned otherwise than by quarters, and herringbones by eighths.
fn period(texture: &Texture) -> Option<Vec2> {
    if let Texture::Pattern(pattern) = texture
        && let Pattern::Bricks {
            width,
            height,
            joint,
            bond,
            offset,
            to_uv,
            ..
        } = &**pattern
    {
        let pitch = Vec2::new(*width, *height) + *joint;
        let x = to_uv.matrix2.x_axis;
        let is_turned_by = |angle: f32| {
            let turned = Affine2::from_angle(angle);
            turned.matrix2.abs_diff_eq(to_uv.matrix2, 1e-4)
        };
        let is_even = |x: f32| (x - x.round()).abs() < 1e-4;
        if bond.name() == "herringbone" {
            let long = (pitch.x / pitch.y).round().max(1.0) * pitch.y;
            let period = match x.x.abs() - x.y.abs() {
                difference if difference.abs() < 1e-4 => std::f32::consts::SQRT_2 * long,
                _ => 2.0 * long,
            };
            let quarters = (0..8).any(|eighth| is_turned_by(eighth as f32 * std::f32::consts::FRAC_PI_4));
            return quarters.then_some(Vec2::splat(period));
        }
        let rows = match bond.name() {
            "running" => (1..=MOST_ROWS).find(|rows| is_even(*rows as f32 * offset)).unwrap_or(1),
            _ => 1,
        };
        let period = pitch * Vec2::new(1.0, rows as f32);
        // A small strip of the very long rows that stand for stripes is enough.
        let period = period.min(Vec2::splat(4.0 * EXTENT));
        return if is_turned_by(0.0) || is_turned_by(std::f32::consts::PI) {
            Some(period)
        } else {
            let quarter = std::f32::consts::FRAC_PI_2;
            (is_turned_by(quarter) || is_turned_by(-quarter)).then_some(Vec2::new(period.y, period.x))
        };
    }
    let mut found = None;
    texture.for_each_nested(&mut |nested| {
        if found.is_none() {
            found = period(nested);
        }
    });
    found
}

#[cfg(test)]
mod tests {
    use super::*;

    fn projected(input: Pattern) -> Texture {
        let Some(Pattern::BoxProjection { up, .. }) = Pattern::of_plugin("boxprojection") else {
            panic!("a plugin")
        };
        Texture::Pattern(Box::new(Pattern::BoxProjection {
            input: Parameter::Texture(Texture::Pattern(Box::new(input))),
            up,
            to_uv: Affine2::IDENTITY,
        }))
    }

    #[test]
    fn a_tile_holds_whole_bricks() {
        let bricks = Pattern::of_plugin("bricks").expect("a plugin");
        let tile = Tile::of(&projected(bricks)).expect("a tile");
        // 9 bricks of 225 mm, and 14 pairs of rows of 75 mm.
        let extent = tile.place(Vec2::ONE);
        assert!(extent.abs_diff_eq(Vec2::new(2.025, 2.1), 1e-4), "{extent}");
        let noise = Pattern::of_plugin("noise").expect("a plugin");
        let tile = Tile::of(&projected(noise.clone())).expect("a tile");
        assert_eq!(tile.place(Vec2::ONE), Vec2::splat(EXTENT));
        assert_eq!(Tile::of(&Texture::Pattern(Box::new(noise))), None);
    }

    #[test]
    fn a_tile_of_noise_ends_as_it_begins() {
        let noise = Pattern::of_plugin("noise").expect("a plugin");
        let tile = Tile::of(&projected(noise)).expect("a tile");
        let value = |at: Vec2| Rgb::splat(at.x + 10.0 * at.y);
        for y in [0.0, 0.4, 0.999] {
            let [begin, end] = [0.0, 1.0].map(|x| tile.value(Vec2::new(x, y), value).x);
            assert!((begin - end).abs() < 1e-4, "{begin} {end}");
        }
        assert_eq!(tile.value(Vec2::splat(0.5), value), value(Vec2::splat(0.5)));
    }
}
