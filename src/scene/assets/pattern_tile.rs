//! Tiles of patterns: rectangles of which pictures are made for programs that do not have patterns, and which repeat.

use glam::{Affine2, BVec2, Vec2};

use super::packed_pattern::packed_pattern;
use crate::color::Rgb;
use crate::scene::{Parameter, Pattern, Texture, TextureWrap};
use crate::texture::{self, Bricks, TextureId};

/// A rectangle of a texture that a box projection lays on shapes, or of bricks that lie by uv.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Tile {
    /// The map from the coordinates of the surface (lengths on the sides of the box, or uv) to the unit square of the
    /// picture.
    pub to_uv: Affine2,
    /// The extent of the tile along the axes of the texture that repeats.
    lengths: Vec2,
    end: End,
}

/// The end of a picture, at which it begins again.
#[derive(Clone, Copy, Debug, PartialEq)]
enum End {
    /// In a margin at its right and its upper end it turns into its beginning. Textures of which the tile holds whole
    /// periods are not changed by that.
    Fading,
    /// Bricks that begin outside of the tile look like those on the opposite side, so that each of them is whole.
    Bricks {
        bricks: Bricks,
        /// The axes along which the tile holds whole periods.
        repeats: BVec2,
    },
}

/// The least extent of a tile of a box projection, in the coordinates of the texture inside: metres in materials of the
/// library.
const EXTENT: f32 = 2.0;

/// The least extent of a tile of bricks that lie by uv.
const EXTENT_OF_UV: f32 = 1.0;

/// The greatest extent of a tile, in least ones. A strip of the very long rows that stand for stripes is enough.
const MOST_EXTENTS: f32 = 4.0;

/// The margin in which a picture turns into its beginning, as a share of its extent.
const MARGIN: f32 = 0.125;

/// The greatest ratio of the sides of a tile that may become a square.
const SQUARE: f32 = 1.02;

/// The rounding of places, as a share of an extent.
const ROUNDING: f32 = 1e-4;

impl Tile {
    /// The tile of a texture; None unless it is a box projection, or a pattern with bricks.
    pub fn of(texture: &Texture) -> Option<Self> {
        let Texture::Pattern(pattern) = texture else {
            return None;
        };
        let Pattern::BoxProjection { input, to_uv, .. } = &**pattern else {
            return Period::of_bricks(texture)?.tile(&Affine2::IDENTITY, EXTENT_OF_UV);
        };
        let Parameter::Texture(inside) = input else {
            return Period::PLANE.tile(to_uv, EXTENT);
        };
        let period = Period::of_bricks(inside).or_else(|| Period::of_picture(inside));
        // A picture by itself keeps its resolution.
        let least = if matches!(inside, Texture::Bitmap(_)) {
            0.0
        } else {
            EXTENT
        };
        period.unwrap_or(Period::PLANE).tile(to_uv, least)
    }

    /// The value of the picture at a place of its unit square, given the values at places of that square and beyond.
    pub fn value(&self, at: Vec2, value: impl Fn(Vec2) -> Rgb) -> Rgb {
        if let End::Bricks { bricks, repeats } = &self.end {
            let corner = Vec2::from(bricks.corner((at * self.lengths).to_array()));
            let tiles = (corner / self.lengths + ROUNDING).floor();
            return value(at - Vec2::select(*repeats, tiles, Vec2::ZERO));
        }
        let fade = |x: f32| ((x - 1.0) / MARGIN + 1.0).clamp(0.0, 1.0);
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

    /// The place in the coordinates of the surface.
    pub fn place(&self, at: Vec2) -> Vec2 {
        self.to_uv.inverse().transform_point2(at)
    }

    /// [`Self::to_uv`] as if the tile was square along its own axes, if it is nearly: a map of that kind is a scale,
    /// then a rotation.
    pub fn square_to_uv(&self) -> Option<Affine2> {
        let [short, long] = [self.lengths.min_element(), self.lengths.max_element()];
        let to_axes = Affine2::from_scale(self.lengths) * self.to_uv;
        (long <= SQUARE * short).then(|| Affine2::from_scale(Vec2::splat(long.recip())) * to_axes)
    }

    /// The lengths of the tile's sides, in the coordinates of the surface.
    pub fn extent(&self) -> Vec2 {
        let sides = self.to_uv.matrix2.inverse();
        Vec2::new(sides.x_axis.length(), sides.y_axis.length())
    }
}

/// Whether a texture is laid on shapes by box projection.
pub(crate) fn is_projected(texture: &Texture) -> bool {
    matches!(texture, Texture::Pattern(pattern) if matches!(**pattern, Pattern::BoxProjection { .. }))
}

/// The extent after which a texture repeats.
#[derive(Clone, Copy, Debug)]
struct Period {
    /// The map to coordinates along whose axes it repeats.
    to_axes: Affine2,
    /// The lengths after which it repeats there.
    lengths: Vec2,
    bricks: Option<Bricks>,
}

impl Period {
    /// The period of a texture that does not repeat.
    const PLANE: Self = Self {
        to_axes: Affine2::IDENTITY,
        lengths: Vec2::splat(EXTENT),
        bricks: None,
    };

    /// The period of the first bricks in a texture; None without any.
    fn of_bricks(texture: &Texture) -> Option<Self> {
        if let Texture::Pattern(pattern) = texture
            && let Pattern::Bricks { .. } = **pattern
            && let texture::Texture::Bricks(bricks) = packed_pattern(pattern, &mut |_| TextureId(0))
        {
            return Some(Self {
                to_axes: bricks.to_uv,
                lengths: bricks.period().into(),
                bricks: Some(bricks),
            });
        }
        Self::nested(texture, &Self::of_bricks)
    }

    /// The period of the first picture or checkerboard in a texture; None without any.
    fn of_picture(texture: &Texture) -> Option<Self> {
        let (to_axes, lengths) = match texture {
            Texture::Bitmap(bitmap) => {
                let length = |wrap: TextureWrap| match wrap {
                    TextureWrap::Repeat => Some(1.0),
                    TextureWrap::Mirror => Some(2.0),
                    TextureWrap::Clamp => None,
                };
                let [u, v] = bitmap.wraps().map(length);
                (bitmap.to_uv, Vec2::new(u?, v?))
            }
            Texture::Checkerboard { to_uv, .. } => (**to_uv, Vec2::ONE),
            _ => return Self::nested(texture, &Self::of_picture),
        };
        Some(Self {
            to_axes,
            lengths,
            bricks: None,
        })
    }

    /// The period of the first texture inside another that repeats.
    fn nested(texture: &Texture, of: &dyn Fn(&Texture) -> Option<Self>) -> Option<Self> {
        let mut found = None;
        texture.for_each_nested(&mut |nested| found = found.or_else(|| of(nested)));
        if let Texture::Pattern(pattern) = texture
            && let Pattern::BoxProjection { to_uv, .. } = &**pattern
        {
            found = found.map(|period: Self| Self {
                to_axes: period.to_axes * *to_uv,
                ..period
            });
        }
        found
    }

    /// The tile of whole periods that is at least so long in the coordinates of the texture, which are those of the
    /// surface after `to_texture`. None if a map has no inverse.
    fn tile(&self, to_texture: &Affine2, least: f32) -> Option<Tile> {
        let sides = self.to_axes.matrix2.inverse();
        let lengths = self.lengths * Vec2::new(sides.x_axis.length(), sides.y_axis.length());
        let most = MOST_EXTENTS * EXTENT;
        // Rounding does not add a period.
        let count = (least / lengths - ROUNDING).ceil().max(Vec2::ONE);
        let repeats = lengths.cmple(Vec2::splat(most));
        let turn = (self.to_axes * *to_texture).matrix2;
        let is_turned = |axis: Vec2| axis.abs().min_element() > ROUNDING * axis.length();
        let count = match is_turned(turn.x_axis) && repeats.all() {
            true => self.squarest(count, most / lengths),
            false => count,
        };
        let periods = Vec2::select(repeats, count, most / lengths);
        let own_lengths = periods * self.lengths;
        let to_uv = Affine2::from_scale(own_lengths.recip()) * self.to_axes * *to_texture;
        let end = match self.bricks {
            Some(bricks) => End::Bricks { bricks, repeats },
            None => End::Fading,
        };
        let has_inverse = to_uv.is_finite() && to_uv.inverse().is_finite() && to_uv.matrix2.determinant() != 0.0;
        has_inverse.then_some(Tile {
            to_uv,
            lengths: own_lengths,
            end,
        })
    }

    /// The numbers of periods from `least` to `most` that are most nearly a square, the least ones among equals.
    fn squarest(&self, least: Vec2, most: Vec2) -> Vec2 {
        let candidates = (least.x as u32..=most.x as u32).map(|along| {
            let across = along as f32 * self.lengths.x / self.lengths.y;
            Vec2::new(along as f32, across.round().max(least.y))
        });
        let deviation = |count: Vec2| {
            let sides = count * self.lengths;
            sides.max_element() / sides.min_element() - 1.0
        };
        let allowed = candidates.filter(|count| count.y <= most.y);
        allowed.fold(least, |best, count| {
            if deviation(count) < deviation(best) - ROUNDING {
                count
            } else {
                best
            }
        })
    }
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

    /// Whatever the bond and the turn, bricks at the end of the tile go on at its beginning: the number of each is that
    /// of its continuation.
    #[test]
    fn bricks_at_the_end_go_on_at_the_beginning() {
        let base = Pattern::of_plugin("bricks").expect("a plugin");
        let bonds = ["running", "random", "herringbone"];
        let maps = [
            Affine2::IDENTITY,
            Affine2::from_angle(0.5) * Affine2::from_scale(Vec2::splat(1.7)),
            Affine2::from_angle(std::f32::consts::FRAC_PI_4),
        ];
        for (bond_name, map) in bonds.iter().flat_map(|bond| maps.map(|map| (*bond, map))) {
            let mut pattern = base.clone();
            if let Pattern::Bricks { bond, to_uv, .. } = &mut pattern {
                *bond = bond.of_name(bond_name).expect("a bond");
                *to_uv = map;
            }
            let texture::Texture::Bricks(bricks) = packed_pattern(&pattern, &mut |_| TextureId(0)) else {
                panic!("bricks")
            };
            let tile = Tile::of(&projected(pattern)).expect("a tile");
            let look = |at: Vec2| {
                tile.value(at, |at| {
                    let place = bricks.place(map.transform_point2(tile.place(at)).to_array());
                    let number = Bricks::own(place.brick);
                    Rgb::new(if place.share > 0.0 { number } else { -1.0 }, place.at[0], place.at[1])
                })
            };
            let mut differing = 0;
            for number in 0..500 {
                let along = (number as f32 + 0.5) / 500.0;
                for (end, begin) in [
                    (Vec2::new(1.0, along), Vec2::new(0.0, along)),
                    (Vec2::new(along, 1.0), Vec2::new(along, 0.0)),
                ] {
                    let inwards = 1e-4 * (end - begin);
                    let (end, begin) = (look(end - inwards), look(begin + inwards));
                    // The rows of random bonds differ where a joint lies between them.
                    let is_joint = end.x < 0.0 || begin.x < 0.0;
                    differing += u32::from(!is_joint && (end.x - begin.x).abs() > 1e-6);
                }
            }
            assert!(differing < 20, "{bond_name}, {map:?}: {differing}");
        }
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
