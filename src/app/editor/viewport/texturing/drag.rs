//! A drag of a tile: the transform of uv that follows the pointer or the numbers that are typed.

use bevy::math::{Affine2, Mat2, Vec2};

use super::sheet::Tile;
use crate::app::editor::viewport::gizmo::typed::Typed;
use crate::scene::LengthUnit;

/// The dragged part of a tile.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Part {
    /// The inside: the picture moves with the pointer.
    Inside,
    /// One of its corners, at shares of the edges: the tile grows evenly from the opposite one.
    Corner(Vec2),
    /// The middle of an edge across an axis, 0 or 1, at this share: the tile grows along the axis.
    Edge(usize, f32),
    /// The arm beyond the upper edge: the tile turns about its middle.
    Arm,
}

impl Part {
    /// The parts that are points, with their shares of the edges.
    pub const POINTS: [(Self, Vec2); 8] = [
        (Self::Corner(Vec2::ZERO), Vec2::ZERO),
        (Self::Corner(Vec2::X), Vec2::X),
        (Self::Corner(Vec2::ONE), Vec2::ONE),
        (Self::Corner(Vec2::Y), Vec2::Y),
        (Self::Edge(0, 0.0), Vec2::new(0.0, 0.5)),
        (Self::Edge(0, 1.0), Vec2::new(1.0, 0.5)),
        (Self::Edge(1, 0.0), Vec2::new(0.5, 0.0)),
        (Self::Edge(1, 1.0), Vec2::new(0.5, 1.0)),
    ];
}

/// Steps with Control: of offsets and repeats in tiles, of angles in degrees.
const TILE_STEP: f32 = 0.1;
const DEGREE_STEP: f32 = 15.0;
/// The least and the largest factor of the size of a tile in one drag.
const FACTORS: [f32; 2] = [0.01, 100.0];

/// A drag.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Drag {
    pub part: Part,
    /// The tile as it was at the press.
    pub start: Tile,
    /// The texture coordinates at which the pointer took hold.
    pub grabbed: Vec2,
    pub typed: Typed,
}

impl Drag {
    /// The transform of uv that puts the grabbed coordinates under the pointer; None if none does. `snaps` rounds to
    /// steps.
    pub fn placed(&self, pointer: Vec2, snaps: bool) -> Option<Affine2> {
        let numbers = self.typed.numbers();
        let placed = match self.part {
            Part::Inside => self.moved(pointer, snaps, numbers.as_deref()),
            Part::Corner(share) => {
                let factor = self.factor(pointer, share, snaps, numbers.as_deref())?;
                self.scaled(share, Vec2::splat(factor))
            }
            Part::Edge(axis, at) => {
                let mut share = Vec2::splat(0.5);
                share[axis] = at;
                let mut factors = Vec2::ONE;
                factors[axis] = self.factor(pointer, share, snaps, numbers.as_deref())?;
                self.scaled(share, factors)
            }
            Part::Arm => self.turned(pointer, snaps, numbers.as_deref()),
        };
        let has_inverse = placed.is_finite() && placed.matrix2.determinant() != 0.0;
        has_inverse.then_some(placed)
    }

    /// The transform moved by typed tiles, or to the pointer.
    fn moved(&self, pointer: Vec2, snaps: bool, numbers: Option<&[f32]>) -> Affine2 {
        let start = self.start.to_uv;
        let by = |axis: usize| numbers.and_then(|numbers| numbers.get(axis)).copied().unwrap_or(0.0);
        let offset = match numbers {
            Some(_) => start.translation - Vec2::new(by(0), by(1)),
            None => {
                let offset = start.transform_point2(self.grabbed) - start.matrix2 * pointer;
                if snaps {
                    (offset / TILE_STEP).round() * TILE_STEP
                } else {
                    offset
                }
            }
        };
        Affine2::from_mat2_translation(start.matrix2, short(offset))
    }

    /// The scale factor of the tile from its fixed part, which is opposite of `share`.
    fn factor(&self, pointer: Vec2, share: Vec2, snaps: bool, numbers: Option<&[f32]>) -> Option<f32> {
        let start = &self.start;
        if let Some(numbers) = numbers {
            return numbers.first().copied().filter(|factor| *factor > 0.0);
        }
        let held = (2.0 * share - Vec2::ONE) * start.span;
        let moved = start.to_uv.transform_vector2(pointer - self.grabbed);
        // Along the line from the fixed part to the dragged one, as it looks on the surface.
        let lengths = start.lengths_from_texture();
        let along = lengths * held;
        let factor = 1.0 + (lengths * moved).dot(along) / along.length_squared();
        let factor = factor.clamp(FACTORS[0], FACTORS[1]);
        if !snaps {
            return Some(factor);
        }
        let axis = usize::from(held.x == 0.0);
        let repeats = repeats(&start.to_uv)[axis];
        let rounded = ((repeats / factor / TILE_STEP).round() * TILE_STEP).max(TILE_STEP);
        Some(repeats / rounded)
    }

    /// The tile scaled by factors along its axes, with the part opposite of `share` fixed.
    fn scaled(&self, share: Vec2, factors: Vec2) -> Affine2 {
        let start = self.start.to_uv;
        let fixed = self.start.uv(self.start.texture(Vec2::ONE - share));
        let linear = Mat2::from_diagonal(1.0 / factors) * start.matrix2;
        about(start, fixed, linear)
    }

    /// The tile turned about its middle. Angles are positive to the left as the surface is seen.
    fn turned(&self, pointer: Vec2, snaps: bool, numbers: Option<&[f32]>) -> Affine2 {
        let tile = &self.start;
        let middle = tile.uv(tile.texture(Vec2::splat(0.5)));
        let lengths = tile.sheet.lengths_from_uv();
        let angle = |uv: Vec2| (lengths * (uv - middle)).to_angle();
        let by = match numbers {
            Some(numbers) => numbers.first().copied().unwrap_or(0.0).to_radians(),
            None => angle(pointer) - angle(self.grabbed),
        };
        let by = match snaps && numbers.is_none() {
            true => {
                let before = tile.lengths_from_texture().x_axis.to_angle();
                let step = DEGREE_STEP.to_radians();
                ((before + by) / step).round() * step - before
            }
            false => by,
        };
        let turn = lengths.inverse() * Mat2::from_angle(-by) * lengths;
        about(tile.to_uv, middle, tile.to_uv.matrix2 * turn)
    }

    /// The text about the change so far.
    pub fn text(&self, now: &Affine2, unit: LengthUnit) -> String {
        let tile = Tile {
            to_uv: *now,
            ..self.start
        };
        let text = match self.part {
            Part::Inside => format!("offset {:.3}, {:.3}", now.translation.x, now.translation.y),
            Part::Corner(_) | Part::Edge(..) => {
                let (size, repeats) = (tile.size(), repeats(now));
                format!(
                    "tile {} x {}   repeats {:.3}, {:.3}",
                    unit.text(size.x),
                    unit.text(size.y),
                    repeats.x,
                    repeats.y
                )
            }
            Part::Arm => {
                let edge = |tile: &Tile| tile.lengths_from_texture().x_axis;
                let by = edge(&self.start).angle_to(edge(&tile)).to_degrees();
                format!("turned by {by:.1}°")
            }
        };
        match self.typed.is_empty() {
            true => text,
            false => format!("{text}   [{}]", self.typed.text()),
        }
    }
}

/// The tiles in a unit of uv along each axis of the texture.
fn repeats(to_uv: &Affine2) -> Vec2 {
    let uv_from_texture = to_uv.matrix2.inverse();
    Vec2::new(uv_from_texture.x_axis.length(), uv_from_texture.y_axis.length()).recip()
}

/// A transform with another linear part that keeps the texture fixed at some coordinates.
fn about(start: Affine2, fixed: Vec2, linear: Mat2) -> Affine2 {
    let largest = linear.to_cols_array().map(f32::abs).into_iter().fold(0.0, f32::max);
    let places = 5 - largest.log10().floor() as i32;
    let round = |number: f32| rounded(number, places);
    let linear = Mat2::from_cols(linear.x_axis.map(round), linear.y_axis.map(round));
    Affine2::from_mat2_translation(linear, short(start.transform_point2(fixed) - linear * fixed))
}

/// An offset rounded to the digits that matter.
fn short(offset: Vec2) -> Vec2 {
    offset.map(|number| rounded(number, 4))
}

/// A number rounded to so many decimal places; tiny numbers become 0 without a sign.
fn rounded(number: f32, places: i32) -> f32 {
    let scale = 10.0_f64.powi(places.clamp(-30, 30));
    ((f64::from(number) * scale).round() / scale) as f32 + 0.0
}
