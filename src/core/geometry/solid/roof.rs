//! Roofs over rectangles: a slab along the slopes of a gable, a hip or a shed roof, with the walls below its ends.
//!
//! The plan is divided into convex pieces whose sides are shared whole, and each piece has flat faces above and below,
//! so that the surface is closed whatever the numbers are.

use std::collections::HashMap;

use glam::{Vec2, Vec3};

use super::Facets;
use crate::geometry::mesh::MeshData;

/// The form of a roof.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum RoofForm {
    /// Two slopes that rise from the long sides to a ridge along x, over the middle.
    Gable,
    /// Four slopes of one pitch, from all sides.
    Hip,
    /// One slope, which rises along +y.
    Shed,
}

/// A roof over the rectangle of `width` by `depth` around the z axis. The underside of the slab is at z = 0 over the
/// sides from which it rises, and at `height` in its highest place over the rectangle. All numbers are lengths.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Roof {
    /// The form.
    pub form: RoofForm,
    /// The extent of the rectangle along x, above 0.
    pub width: f32,
    /// The extent of the rectangle along y, above 0.
    pub depth: f32,
    /// The rise of the underside, above 0.
    pub height: f32,
    /// The level distance by which the slab goes on beyond the rectangle, 0 or more.
    pub overhang: f32,
    /// The thickness of the slab across its slopes, above 0.
    pub thickness: f32,
    /// The thickness of the walls from z = 0 up to the slab: at both ends of a gable roof, at the ends and the high
    /// side of a shed roof. With 0 there are none; a hip roof has none.
    pub gable: f32,
}

/// A convex piece of the plan, counter-clockwise as seen from above.
struct Piece {
    corners: Vec<Vec2>,
    /// Whether there is a wall below the slab.
    is_walled: bool,
}

impl Roof {
    /// The rise of the slopes for each unit of level distance.
    pub fn slope(&self) -> f32 {
        match self.form {
            RoofForm::Gable => self.height / (0.5 * self.depth),
            RoofForm::Hip => self.height / (0.5 * self.width.min(self.depth)),
            RoofForm::Shed => self.height / self.depth,
        }
    }

    /// The extent of the slab along z.
    pub fn slab_height(&self) -> f32 {
        self.thickness * self.slope().hypot(1.0)
    }

    /// Two opposite corners of the bounding box; the origin if a number is none or too large for a roof.
    pub fn corners(&self) -> [Vec3; 2] {
        self.finite_corners().unwrap_or_default()
    }

    /// None if they are beyond single precision.
    fn finite_corners(&self) -> Option<[Vec3; 2]> {
        let reach = 0.5 * Vec2::new(self.width, self.depth) + self.overhang;
        let hangs = self.overhang * self.slope();
        // Only the slope of a shed roof goes on upwards.
        let rises = if self.form == RoofForm::Shed { hangs } else { 0.0 };
        let top = self.height + rises + self.slab_height();
        let corners = [(-reach).extend(-hangs), reach.extend(top)];
        corners.iter().all(|corner| corner.is_finite()).then_some(corners)
    }

    /// The height of the underside of the slab.
    fn underside(&self, at: Vec2) -> f32 {
        let from_eaves = match self.form {
            RoofForm::Gable => 0.5 * self.depth - at.y.abs(),
            RoofForm::Hip => (0.5 * self.width - at.x.abs()).min(0.5 * self.depth - at.y.abs()),
            RoofForm::Shed => 0.5 * self.depth + at.y,
        };
        from_eaves * self.slope()
    }

    fn pieces(&self) -> Vec<Piece> {
        let (half, reach) = (
            0.5 * Vec2::new(self.width, self.depth),
            0.5 * Vec2::new(self.width, self.depth) + self.overhang,
        );
        if self.form == RoofForm::Hip {
            return hips(half, reach);
        }
        // A wall that is thicker than half the roof fills it.
        let gable = self.gable.clamp(0.0, half.x);
        let xs = cuts(&[-reach.x, -half.x, -half.x + gable, half.x - gable, half.x, reach.x]);
        let back = half.y - self.gable.clamp(0.0, self.depth);
        let ys = match self.form {
            RoofForm::Shed => cuts(&[-reach.y, -half.y, back, half.y, reach.y]),
            _ => cuts(&[-reach.y, -half.y, 0.0, half.y, reach.y]),
        };
        let mut pieces = Vec::new();
        for x in xs.windows(2) {
            for y in ys.windows(2) {
                let is_inside = x[0] >= -half.x && x[1] <= half.x && y[0] >= -half.y && y[1] <= half.y;
                let is_end = x[1] <= -half.x + gable || x[0] >= half.x - gable;
                let is_back = self.form == RoofForm::Shed && y[0] >= back;
                pieces.push(Piece {
                    corners: [(x[0], y[0]), (x[1], y[0]), (x[1], y[1]), (x[0], y[1])]
                        .map(|(x, y)| Vec2::new(x, y))
                        .to_vec(),
                    is_walled: is_inside && gable > 0.0 && (is_end || is_back),
                });
            }
        }
        pieces
    }
}

/// The plan of the four slopes of a hip roof.
fn hips(half: Vec2, reach: Vec2) -> Vec<Piece> {
    let ridge = (half - half.min_element()).max(Vec2::ZERO);
    let corner = |x: f32, y: f32| Vec2::new(x * reach.x, y * reach.y);
    let (far, near) = (ridge, -ridge);
    let outlines = match ridge.y > 0.0 {
        false => [
            vec![corner(-1.0, -1.0), corner(1.0, -1.0), far, near],
            vec![corner(1.0, -1.0), corner(1.0, 1.0), far],
            vec![corner(1.0, 1.0), corner(-1.0, 1.0), near, far],
            vec![corner(-1.0, 1.0), corner(-1.0, -1.0), near],
        ],
        true => [
            vec![corner(-1.0, -1.0), corner(1.0, -1.0), near],
            vec![corner(1.0, -1.0), corner(1.0, 1.0), far, near],
            vec![corner(1.0, 1.0), corner(-1.0, 1.0), far],
            vec![corner(-1.0, 1.0), corner(-1.0, -1.0), near, far],
        ],
    };
    let pieces = outlines.map(|mut corners| {
        // The ridge over a square is a point.
        corners.dedup();
        Piece {
            corners,
            is_walled: false,
        }
    });
    pieces.into()
}

/// The roof as a mesh; without triangles if a number is none or too large for it.
pub fn roof(roof: &Roof) -> MeshData {
    let numbers = [roof.width, roof.depth, roof.height, roof.thickness];
    let rests = [roof.overhang, roof.gable];
    let is_sound = numbers.iter().all(|number| *number > 0.0 && number.is_finite())
        && rests.iter().all(|number| *number >= 0.0 && number.is_finite())
        && roof.finite_corners().is_some();
    if !is_sound {
        return MeshData::default();
    }
    let pieces = roof.pieces();
    let rise = roof.slab_height();
    let (low, high) = (
        |at: &Vec2| at.extend(roof.underside(*at)),
        |at: &Vec2| at.extend(roof.underside(*at) + rise),
    );
    let ground = |at: &Vec2| at.extend(0.0);
    let mut facets = Facets::new(Vec3::new(0.0, 0.0, roof.height));
    // Whether the piece at the left of each side has a wall.
    let mut sides = HashMap::new();
    for piece in &pieces {
        for (from, to) in around(&piece.corners) {
            sides.insert((key(from), key(to)), piece.is_walled);
        }
    }
    for piece in &pieces {
        let top: Vec<Vec3> = piece.corners.iter().map(high).collect();
        facets.polygon(&top);
        let foot = |at: &Vec2| if piece.is_walled { ground(at) } else { low(at) };
        let bottom: Vec<Vec3> = piece.corners.iter().rev().map(foot).collect();
        facets.polygon(&bottom);
        for (from, to) in around(&piece.corners) {
            let beside = sides.get(&(key(to), key(from)));
            if beside.is_none() {
                upright(&mut facets, [low(from), low(to), high(to), high(from)]);
            }
            if piece.is_walled && beside != Some(&true) {
                upright(&mut facets, [ground(from), ground(to), low(to), low(from)]);
            }
        }
    }
    facets.finish()
}

/// The sides of an outline.
fn around(corners: &[Vec2]) -> impl Iterator<Item = (&Vec2, &Vec2)> {
    corners.iter().zip(corners.iter().cycle().skip(1))
}

/// The place by its bits; both zeros are one place.
fn key(at: &Vec2) -> [u32; 2] {
    at.to_array().map(|number| (number + 0.0).to_bits())
}

/// Adds a face whose corners may coincide.
fn upright(facets: &mut Facets, corners: [Vec3; 4]) {
    let mut corners = corners.to_vec();
    corners.dedup();
    if corners.first() == corners.last() {
        corners.pop();
    }
    if corners.len() > 2 {
        facets.polygon(&corners);
    }
}

/// The numbers in order, each once.
fn cuts(places: &[f32]) -> Vec<f32> {
    let mut places = places.to_vec();
    places.sort_by(f32::total_cmp);
    places.dedup();
    places
}
