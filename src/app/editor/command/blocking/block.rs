//! A box, floor or wall as it is drawn: two points on a plane and a height.

use bevy::math::{Affine3A, Mat3, Vec3};

use super::BlockKind;
use crate::scene::{ShapeKind, Solid};

/// A drawn thing.
#[derive(Clone, Debug, PartialEq)]
pub struct Block {
    /// Its kind.
    pub kind: BlockKind,
    /// The name. None: it is named after its kind.
    pub name: Option<String>,
    /// One corner of the rectangle, or the start of the wall's middle line; in world space.
    pub from: Vec3,
    /// The opposite corner, or the end of the middle line.
    pub to: Vec3,
    /// The plane that it is drawn on.
    pub plane: Plane,
    /// The extent above the plane, or below it for a floor; world units. A negative extent of a box goes below the
    /// plane.
    pub height: f32,
    /// The thickness of a wall; world units.
    pub thickness: f32,
}

/// A plane with the directions of its grid.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Plane {
    /// The normal of the side that is drawn on, of unit length.
    pub normal: Vec3,
    /// A direction in the plane, of unit length: one side of rectangles is parallel to it.
    pub along: Vec3,
}

impl Plane {
    /// A plane of this normal. Its directions are axes of the world if they lie in it, else one of them is level.
    pub fn of_normal(normal: Vec3, up: Vec3) -> Self {
        let normal = match Vec3::AXES.into_iter().find(|axis| normal.dot(*axis).abs() > 0.9999) {
            Some(axis) => axis * normal.dot(axis).signum(),
            None => normal,
        };
        let level = up.cross(normal);
        let along = match level.try_normalize().filter(|_| level.length_squared() > 1e-6) {
            Some(level) => level,
            // The ground: the first axis of the world that lies in it.
            None => Vec3::AXES
                .into_iter()
                .find(|axis| axis.dot(normal).abs() < 0.5)
                .unwrap_or(Vec3::X),
        };
        let positive = along.dot(Vec3::ONE) >= 0.0;
        Self {
            normal,
            along: if positive { along } else { -along },
        }
    }

    /// The other direction in the plane.
    pub fn across(&self) -> Vec3 {
        self.normal.cross(self.along)
    }

    /// The extents from one point to another along the two directions.
    pub fn extents(&self, from: Vec3, to: Vec3) -> [f32; 2] {
        [(to - from).dot(self.along), (to - from).dot(self.across())]
    }
}

impl Block {
    /// Moves the start and the end of a wall outwards by these distances in world units; negative ones move inwards.
    pub fn lengthen(&mut self, [before, after]: [f32; 2]) {
        let direction = (self.to - self.from).normalize_or_zero();
        self.from -= direction * before;
        self.to += direction * after;
    }

    /// The shape, and its pose as world from local; None as long as it has no extent.
    pub fn shape(&self) -> Option<(ShapeKind, Affine3A)> {
        let Plane { normal, along } = self.plane;
        let [wide, deep] = self.plane.extents(self.from, self.to);
        if self.kind == BlockKind::Wall {
            let line = self.to - self.from;
            let (length, direction) = (line.length(), line.try_normalize()?);
            if !(length > 0.0 && self.height > 0.0 && self.thickness > 0.0) {
                return None;
            }
            let axes = Mat3::from_cols(direction, normal.cross(direction), normal);
            let wall = Solid::Wall {
                length,
                height: self.height,
                thickness: self.thickness,
                openings: Vec::new(),
            };
            return Some((ShapeKind::Solid(wall), Affine3A::from_mat3_translation(axes, self.from)));
        }
        let up = if self.kind == BlockKind::Floor {
            -self.height
        } else {
            self.height
        };
        let diagonal = along * wide + self.plane.across() * deep + normal * up;
        let has_extent = [wide, deep, up]
            .iter()
            .all(|extent| extent.is_finite() && *extent != 0.0);
        let center = self.from + 0.5 * diagonal;
        let is_level = Vec3::AXES.contains(&along.abs()) && Vec3::AXES.contains(&normal.abs());
        let axes = match is_level {
            // The box has the axes of the world, so that its pose is a scale and a place.
            true => Mat3::from_diagonal(0.5 * diagonal.abs()),
            false => Mat3::from_cols(
                0.5 * wide.abs() * along,
                0.5 * deep.abs() * self.plane.across(),
                0.5 * up.abs() * normal,
            ),
        };
        has_extent.then(|| (ShapeKind::Cube, Affine3A::from_mat3_translation(axes, center)))
    }
}

/// The corners of a shape that is a box or is fitted into one, the lower four first, each four in turn around; in world
/// space.
pub fn corners(kind: &ShapeKind, pose: &Affine3A) -> Option<[Vec3; 8]> {
    let [low, high] = match kind {
        ShapeKind::Cube => [Vec3::NEG_ONE, Vec3::ONE],
        ShapeKind::Solid(part) => part.corners(),
        _ => return None,
    };
    let ring = [(low.x, low.y), (high.x, low.y), (high.x, high.y), (low.x, high.y)];
    let at = |(x, y): (f32, f32), z: f32| pose.transform_point3(Vec3::new(x, y, z));
    let [a, b, c, d] = ring.map(|corner| at(corner, low.z));
    let [e, f, g, h] = ring.map(|corner| at(corner, high.z));
    Some([a, b, c, d, e, f, g, h])
}

/// The edges of such a box, as indices of [`corners`].
pub const EDGES: [[usize; 2]; 12] = [
    [0, 1],
    [1, 2],
    [2, 3],
    [3, 0],
    [4, 5],
    [5, 6],
    [6, 7],
    [7, 4],
    [0, 4],
    [1, 5],
    [2, 6],
    [3, 7],
];

#[cfg(test)]
impl Block {
    /// A wall on level ground, 2.5 high and 0.2 thick.
    pub(crate) fn wall(from: Vec3, to: Vec3) -> Self {
        Self {
            kind: BlockKind::Wall,
            name: None,
            from,
            to,
            plane: Plane::of_normal(Vec3::Y, Vec3::Y),
            height: 2.5,
            thickness: 0.2,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn block(kind: BlockKind, from: Vec3, to: Vec3, height: f32) -> Block {
        Block {
            kind,
            name: None,
            from,
            to,
            plane: Plane::of_normal(Vec3::Y, Vec3::Y),
            height,
            thickness: 0.2,
        }
    }

    #[test]
    fn a_box_stands_between_its_corners_whichever_came_first() {
        let (a, b) = (Vec3::new(1.0, 0.5, 2.0), Vec3::new(-3.0, 0.5, 4.0));
        for (from, to) in [(a, b), (b, a)] {
            let (kind, pose) = block(BlockKind::Box, from, to, 2.0).shape().expect("a box");
            assert_eq!(kind, ShapeKind::Cube);
            let expected = Affine3A::from_scale_rotation_translation(
                Vec3::new(2.0, 1.0, 1.0),
                bevy::math::Quat::IDENTITY,
                Vec3::new(-1.0, 1.5, 3.0),
            );
            assert_eq!(pose, expected);
        }
        assert_eq!(block(BlockKind::Box, a, a, 2.0).shape(), None);
        assert_eq!(block(BlockKind::Box, a, b, 0.0).shape(), None);
    }

    #[test]
    fn the_upper_side_of_a_floor_is_where_it_was_drawn() {
        let floor = block(BlockKind::Floor, Vec3::ZERO, Vec3::new(4.0, 0.0, 3.0), 0.1);
        let (kind, pose) = floor.shape().expect("a floor");
        let corners = corners(&kind, &pose).expect("a box");
        let highest = corners.iter().map(|corner| corner.y).fold(f32::MIN, f32::max);
        assert!(highest.abs() < 1e-6, "{highest}");
    }

    #[test]
    fn a_wall_goes_along_its_line_and_stands_on_the_plane() {
        let (from, to) = (Vec3::new(1.0, 0.0, 1.0), Vec3::new(1.0, 0.0, 4.0));
        let (kind, pose) = block(BlockKind::Wall, from, to, 2.5).shape().expect("a wall");
        let corners = corners(&kind, &pose).expect("a box");
        let low = corners.iter().copied().reduce(Vec3::min).expect("corners");
        let high = corners.iter().copied().reduce(Vec3::max).expect("corners");
        assert!(low.abs_diff_eq(Vec3::new(0.9, 0.0, 1.0), 1e-6), "{low}");
        assert!(high.abs_diff_eq(Vec3::new(1.1, 2.5, 4.0), 1e-6), "{high}");
        assert!(pose.matrix3.determinant() > 0.0);
    }

    #[test]
    fn planes_have_level_directions() {
        let ground = Plane::of_normal(Vec3::Y, Vec3::Y);
        assert_eq!((ground.along, ground.across()), (Vec3::X, Vec3::NEG_Z));
        for normal in [Vec3::X, Vec3::NEG_Z, Vec3::new(0.6, 0.0, 0.8), Vec3::new(0.6, 0.8, 0.0)] {
            let plane = Plane::of_normal(normal, Vec3::Y);
            assert!(
                plane.along.y.abs() < 1e-6 && plane.along.dot(normal).abs() < 1e-6,
                "{normal}"
            );
            assert!((plane.across().length() - 1.0).abs() < 1e-6);
        }
    }
}
