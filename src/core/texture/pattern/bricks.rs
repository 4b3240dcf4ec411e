//! Bricks, tiles and boards with joints between them.

use glam::Affine2;

use super::hash::{hash, pair, unit};
use super::*;

/// Rectangles of one size with joints between them.
///
/// The textures of `colors` are looked up in coordinates of the brick: along its length and across it from its lower
/// left corner, moved by a random distance for each brick, so that no two of them look the same. The pattern begins
/// with the lower left corner of a brick at the origin; joints lie on its right and above it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bricks {
    /// The colours between which a brick has a random one, each of which may be a texture before this one in the table.
    pub colors: [Parameter<Rgb>; 2],
    /// The colour of the joints; it may be a texture before this one in the table.
    pub joint_color: Parameter<Rgb>,
    /// The length and the height of a brick without joints, above 0.
    pub size: [f32; 2],
    /// The width of a joint, at least 0.
    pub joint: f32,
    /// The width of the strip along a brick's edges in which the joint's colour turns into that of the brick, at least
    /// 0: as a height, a rounded edge.
    pub bevel: f32,
    /// The arrangement of the bricks.
    pub bond: Bond,
    /// The distance by which each row is moved against the one below, as a share of brick and joint. For
    /// [`Bond::Running`].
    pub offset: f32,
    /// The transform of uv before the look-up.
    pub to_uv: Affine2,
}

declare_names! {
    /// The arrangement of bricks.
    #[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
    pub enum Bond {
        /// Rows, each moved against the one below by the same distance.
        #[default]
        Running = "running",
        /// Rows, each moved by a random distance, as the boards of a floor.
        Random = "random",
        /// Bricks at right angles in steps, as in parquet. The length of a brick with its joint is rounded to a
        /// multiple of its height with the joint.
        Herringbone = "herringbone",
    }
}

/// The place of a point in its brick.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BrickPlace<R> {
    /// The distances from the lower left corner of the brick along its length and across.
    pub at: [R; 2],
    /// The share of the brick, from 0 in the joint to 1.
    pub share: R,
    /// The whole numbers by which random numbers of the brick are found.
    pub brick: [R; 2],
}

/// The seeds of the offsets of rows, of the brick's own number, and of the place of its textures.
const ROW: u32 = 301;
const OWN: u32 = 302;
const PLACE: u32 = 303;

/// The most rows after which a bond is taken to repeat.
const MOST_ROWS: u32 = 12;

/// The bricks are moved within the plane of their textures by up to so many lengths.
const FAR: f32 = 16.0;

impl Bricks {
    /// The place of a point of the pattern in its brick.
    pub fn place<R: Real>(&self, at: [R; 2]) -> BrickPlace<R> {
        let (at, brick) = match self.bond {
            Bond::Running | Bond::Random => self.in_rows(at),
            Bond::Herringbone => self.in_herringbone(at),
        };
        let [length, height] = self.drawn_size().map(R::splat);
        let to_edge = at[0].min(length - at[0]).min(at[1]).min(height - at[1]);
        let share = match self.bevel > 0.0 {
            true => smooth(to_edge * R::splat(1.0 / self.bevel)),
            false => R::select(R::ZERO.is_at_most(to_edge), R::ONE, R::ZERO),
        };
        BrickPlace { at, share, brick }
    }

    /// The lower left corner of the brick at a point, in coordinates of the pattern.
    pub fn corner(&self, at: [f32; 2]) -> [f32; 2] {
        let place = self.place(at);
        let [along, across] = match self.is_upright(place.brick) {
            true => [place.at[1], place.at[0]],
            false => place.at,
        };
        [at[0] - along, at[1] - across]
    }

    /// Whether a brick of a herringbone stands upright.
    fn is_upright(&self, brick: [f32; 2]) -> bool {
        self.bond == Bond::Herringbone && brick[0] != brick[0].floor()
    }

    /// The lengths after which bricks repeat along both axes, apart from their random numbers: whole bricks and rows.
    /// If no number of rows up to 12 repeats exactly, or if rows are moved at random, the bond changes there at a
    /// joint.
    pub fn period(&self) -> [f32; 2] {
        let [length, height] = self.pitch();
        match self.bond {
            Bond::Herringbone => [2.0 * self.steps() * height; 2],
            Bond::Random => [length, height],
            Bond::Running => {
                let deviation = |rows: u32| {
                    let moved = rows as f32 * self.offset;
                    // Rounding does not decide between equal numbers.
                    (moved - moved.round()).abs().max(1e-4)
                };
                let best = |best: u32, rows: u32| if deviation(rows) < deviation(best) { rows } else { best };
                [length, (2..=MOST_ROWS).fold(1, best) as f32 * height]
            }
        }
    }

    /// The random number of a brick in [0, 1).
    pub fn own<R: Real>(brick: [R; 2]) -> R {
        unit::<R>(hash(brick, OWN))
    }

    /// The length and height of a brick with its joints.
    fn pitch(&self) -> [f32; 2] {
        self.size.map(|size| size + self.joint)
    }

    /// The number of heights in a length, joints included, of a herringbone.
    fn steps(&self) -> f32 {
        let [length, height] = self.pitch();
        (length / height).round().max(1.0)
    }

    /// The size of a brick as it is drawn.
    fn drawn_size(&self) -> [f32; 2] {
        match self.bond {
            Bond::Running | Bond::Random => self.size,
            Bond::Herringbone => [self.steps() * self.pitch()[1] - self.joint, self.size[1]],
        }
    }

    fn in_rows<R: Real>(&self, [x, y]: [R; 2]) -> ([R; 2], [R; 2]) {
        let [length, height] = self.pitch().map(R::splat);
        let row = (y / height).floor();
        let moved = match self.bond {
            Bond::Random => unit::<R>(hash([row, R::ZERO], ROW)),
            _ => {
                let moved = row * R::splat(self.offset);
                moved - moved.floor()
            }
        };
        let x = x - moved * length;
        let column = (x / length).floor();
        ([x - column * length, y - row * height], [column, row])
    }

    /// Squares of the lattice whose edge is the height belong to a lying brick or to an upright one by the number of
    /// their diagonal: as many diagonals as a brick has squares belong to the one, and as many to the other.
    fn in_herringbone<R: Real>(&self, [x, y]: [R; 2]) -> ([R; 2], [R; 2]) {
        let edge = R::splat(self.pitch()[1]);
        let steps = R::splat(self.steps());
        let (column, row) = ((x / edge).floor(), (y / edge).floor());
        let period = steps + steps;
        let diagonal = column - row - period * ((column - row) / period).floor();
        let lies = diagonal.is_less(steps);
        let (first, lowest) = (column - diagonal, row - (period - R::ONE - diagonal));
        let (lying, upright) = (
            [x - first * edge, y - row * edge],
            [y - lowest * edge, x - column * edge],
        );
        let select = |yes: R, no: R| R::select(lies, yes, no);
        // Half numbers tell upright bricks from lying ones that begin at the same square.
        (
            [select(lying[0], upright[0]), select(lying[1], upright[1])],
            [select(first, column + R::HALF), select(row, lowest + R::HALF)],
        )
    }

    /// The value at a point of a surface.
    pub(in crate::texture) fn value<V: TextureValue>(&self, table: &TextureTable, at: &TexturePoint) -> V {
        let place = self.place(point(&self.to_uv, at.uv));
        let joint = || V::nested(table, self.joint_color, at);
        if place.share <= 0.0 {
            return joint();
        }
        let [length, height] = self.size;
        let [right, up] = pair(place.brick, PLACE);
        let moved = Vec2::new(right * length, up * height) * FAR;
        let inside = TexturePoint {
            uv: Vec2::from(place.at) + moved,
            ..*at
        };
        let brick = mixed::<V>(table, self.colors, Self::own(place.brick), &inside);
        match place.share < 1.0 {
            true => joint() * (1.0 - place.share) + brick * place.share,
            false => brick,
        }
    }

    /// The step for derivatives, in coordinates of the pattern. Edges without a bevel get slopes that are narrower than
    /// the joint.
    pub(in crate::texture) fn step(&self) -> f32 {
        let [length, height] = self.size;
        let widths = [8.0 * self.joint, self.bevel];
        let finest = widths.into_iter().filter(|width| *width > 0.0);
        STEP * finest.fold(length.min(height), f32::min)
    }

    /// The largest coordinate of the textures on a brick.
    pub(in crate::texture) fn farthest(&self) -> f32 {
        let [length, height] = self.size;
        (FAR + 1.0) * length.max(height)
    }
}
