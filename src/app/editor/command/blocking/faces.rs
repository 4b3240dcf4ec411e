//! Pushing and pulling a face of a box, a wall, stairs or a prism.

use bevy::math::{Affine3A, Vec3};

use crate::scene::{Opening, ShapeKind, Solid};

/// A face of the box around a shape, in the shape's own axes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Face {
    /// The axis across the face: 0, 1 or 2.
    pub axis: usize,
    /// Whether it is the face at the far end of the axis.
    pub is_far: bool,
}

/// The share of a box's extent by which a place may be off its face.
const ON_FACE: f32 = 2e-3;
/// The least extent that a push leaves, as a share of the former one.
const LEAST: f32 = 1e-3;

impl Face {
    /// All six.
    pub fn all() -> impl Iterator<Item = Self> {
        (0..3).flat_map(|axis| [false, true].map(|is_far| Self { axis, is_far }))
    }

    /// The face that a point (in world space, with the normal there) belongs to; None if the shape has no such face.
    pub fn at(kind: &ShapeKind, pose: &Affine3A, place: Vec3, normal: Vec3) -> Option<Self> {
        let [low, high] = extent(kind)?;
        let local = pose.inverse().transform_point3(place);
        // Normals transform by the transposed inverse of a matrix, so that the transposed pose takes this one to local
        // space.
        let facing = pose.matrix3.transpose() * bevy::math::Vec3A::from(normal);
        let facing = Vec3::from(facing);
        let axis = facing.abs().max_position();
        let face = Self {
            axis,
            is_far: facing[axis] > 0.0,
        };
        let bound = if face.is_far { high[axis] } else { low[axis] };
        let is_on = (local[axis] - bound).abs() <= ON_FACE * (high[axis] - low[axis]);
        (is_on && face.can_move(kind)).then_some(face)
    }

    /// The face by a name such as `+x`, in the shape's own axes.
    pub fn of_name(name: &str) -> Option<Self> {
        let (sign, axis) = name.split_at_checked(1)?;
        let axis = ["x", "y", "z"].iter().position(|known| *known == axis)?;
        match sign {
            "+" => Some(Self { axis, is_far: true }),
            "-" => Some(Self { axis, is_far: false }),
            _ => None,
        }
    }

    /// The sides of a prism are not at right angles to its axes, nor are the slopes of a roof.
    fn can_move(self, kind: &ShapeKind) -> bool {
        match kind {
            ShapeKind::Solid(Solid::Prism { .. }) => self.axis == 2,
            ShapeKind::Solid(part) => part.roof().is_none(),
            _ => true,
        }
    }

    /// The outward direction of the face, in world space, of unit length; and the length of the shape's own unit along
    /// it.
    pub fn outward(self, pose: &Affine3A) -> (Vec3, f32) {
        let column = Vec3::from(pose.matrix3.col(self.axis));
        let sign = if self.is_far { 1.0 } else { -1.0 };
        (sign * column.normalize_or_zero(), column.length())
    }

    /// The four corners of the face in world space, in turn around it.
    pub fn corners(self, kind: &ShapeKind, pose: &Affine3A) -> Option<[Vec3; 4]> {
        let [low, high] = extent(kind)?;
        let (u, v) = ((self.axis + 1) % 3, (self.axis + 2) % 3);
        let corner = |far_u: bool, far_v: bool| {
            let mut place = if self.is_far { high } else { low };
            place[u] = if far_u { high[u] } else { low[u] };
            place[v] = if far_v { high[v] } else { low[v] };
            pose.transform_point3(place)
        };
        Some([(false, false), (true, false), (true, true), (false, true)].map(|(u, v)| corner(u, v)))
    }
}

/// Two opposite corners of a shape whose faces can be moved, in its own space.
fn extent(kind: &ShapeKind) -> Option<[Vec3; 2]> {
    match kind {
        ShapeKind::Cube => Some([Vec3::NEG_ONE, Vec3::ONE]),
        ShapeKind::Solid(part) => Some(part.corners()),
        _ => None,
    }
}

/// The extent of a shape across a face, in world units.
pub fn extent_across(kind: &ShapeKind, pose: &Affine3A, face: Face) -> Option<f32> {
    let [low, high] = extent(kind)?;
    Some((high - low)[face.axis] * face.outward(pose).1)
}

/// The shape with this face moved outwards by so many world units; the opposite face stays where it is. None for shapes
/// without such a face.
pub fn pushed(kind: &ShapeKind, pose: &Affine3A, face: Face, by: f32) -> Option<(ShapeKind, Affine3A)> {
    let [low, high] = extent(kind)?;
    let before = (high - low)[face.axis];
    let (_, unit) = face.outward(pose);
    let asked = by / unit;
    let more = asked.max((LEAST - 1.0) * before);
    let after = before + more;
    // A file can hold no smaller or larger extents.
    if !face.can_move(kind) || !asked.is_finite() || !after.is_normal() {
        return None;
    }
    // The point in its own space that becomes the origin of the new one.
    let mut origin = Vec3::ZERO;
    let axis = face.axis;
    let kind = match kind {
        ShapeKind::Cube => {
            let factor = after / before;
            origin[axis] = if face.is_far { factor - 1.0 } else { 1.0 - factor };
            let mut scale = Vec3::ONE;
            scale[axis] = factor;
            let pose = *pose * Affine3A::from_translation(origin) * Affine3A::from_scale(scale);
            return Some((ShapeKind::Cube, pose));
        }
        ShapeKind::Solid(part) => ShapeKind::Solid(resized(part.clone(), face, after, more, &mut origin)),
        _ => return None,
    };
    Some((kind, *pose * Affine3A::from_translation(origin)))
}

fn resized(mut part: Solid, face: Face, after: f32, more: f32, origin: &mut Vec3) -> Solid {
    let starts_before = if face.is_far { 0.0 } else { -more };
    let about_middle = if face.is_far { 0.5 * more } else { -0.5 * more };
    let mut shift = Vec3::ZERO;
    match (&mut part, face.axis) {
        (Solid::Wall { length, openings, .. }, 0) => {
            *length = after;
            shift.x = starts_before;
            openings
                .iter_mut()
                .for_each(|opening: &mut Opening| opening.from -= starts_before);
        }
        (Solid::Wall { thickness, .. }, 1) => {
            *thickness = after;
            shift.y = about_middle;
        }
        (Solid::Wall { height, openings, .. }, _) => {
            *height = after;
            shift.z = starts_before;
            openings
                .iter_mut()
                .for_each(|opening: &mut Opening| opening.sill -= starts_before);
        }
        (Solid::Stairs { width, .. }, 0) => {
            *width = after;
            shift.x = about_middle;
        }
        (Solid::Stairs { depth, .. }, 1) => {
            *depth = after;
            shift.y = starts_before;
        }
        (Solid::Stairs { height, .. } | Solid::Prism { height, .. }, _) => {
            *height = after;
            shift.z = starts_before;
        }
        // The faces of roofs do not move.
        (Solid::GableRoof { .. } | Solid::HipRoof { .. } | Solid::ShedRoof { .. }, _) => {}
    }
    *origin = shift;
    part
}

#[cfg(test)]
mod tests {
    use bevy::math::Quat;

    use super::*;
    use crate::app::editor::command::blocking::block::corners;

    fn bounds(kind: &ShapeKind, pose: &Affine3A) -> [Vec3; 2] {
        let corners = corners(kind, pose).expect("a box");
        let low = corners.into_iter().reduce(Vec3::min).expect("corners");
        let high = corners.into_iter().reduce(Vec3::max).expect("corners");
        [low, high]
    }

    #[test]
    fn only_the_face_that_is_pushed_moves() {
        let pose = Affine3A::from_scale_rotation_translation(
            Vec3::new(2.0, 0.5, 1.0),
            Quat::IDENTITY,
            Vec3::new(1.0, 2.0, 3.0),
        );
        let shapes = ["wall", "stairs"].map(|plugin| ShapeKind::Solid(Solid::of_plugin(plugin).unwrap_or_default()));
        for kind in shapes.iter().chain([&ShapeKind::Cube]) {
            let [low, high] = bounds(kind, &pose);
            for face in Face::all() {
                for by in [0.7, -0.05] {
                    let (kind, pose) = pushed(kind, &pose, face, by).expect("it has the face");
                    let [new_low, new_high] = bounds(&kind, &pose);
                    let (mut expected_low, mut expected_high) = (low, high);
                    match face.is_far {
                        true => expected_high[face.axis] += by,
                        false => expected_low[face.axis] -= by,
                    }
                    assert!(new_low.abs_diff_eq(expected_low, 1e-5), "{kind:?} {face:?} {by}");
                    assert!(new_high.abs_diff_eq(expected_high, 1e-5), "{kind:?} {face:?} {by}");
                }
            }
        }
    }

    #[test]
    fn openings_stay_where_they_are_in_the_world() {
        let wall = Solid::Wall {
            length: 4.0,
            height: 2.5,
            thickness: 0.2,
            openings: vec![Opening::WINDOW],
        };
        let place = |kind: &ShapeKind, pose: &Affine3A| match kind {
            ShapeKind::Solid(Solid::Wall { openings, .. }) => {
                pose.transform_point3(Vec3::new(openings[0].from, 0.0, openings[0].sill))
            }
            _ => Vec3::NAN,
        };
        let kind = ShapeKind::Solid(wall);
        let before = place(&kind, &Affine3A::IDENTITY);
        for face in Face::all() {
            let (kind, pose) = pushed(&kind, &Affine3A::IDENTITY, face, 0.3).expect("it has the face");
            // The middle of the wall moves with its sides.
            let off = (place(&kind, &pose) - before) * Vec3::new(1.0, 0.0, 1.0);
            assert!(off.length() < 1e-6, "{face:?}");
        }
    }

    #[test]
    fn a_face_is_found_by_place_and_normal_and_never_pushed_through() {
        let pose = Affine3A::from_scale(Vec3::new(2.0, 1.0, 1.0));
        let face = Face::at(&ShapeKind::Cube, &pose, Vec3::new(-2.0, 0.3, 0.4), Vec3::NEG_X);
        assert_eq!(face, Face::of_name("-x"));
        let inside = Face::at(&ShapeKind::Cube, &pose, Vec3::new(0.0, 0.3, 0.4), Vec3::X);
        assert_eq!((inside, Face::of_name("x")), (None, None));
        let (kind, pose) = pushed(&ShapeKind::Cube, &pose, Face { axis: 0, is_far: true }, -100.0).expect("a box");
        let [low, high] = bounds(&kind, &pose);
        assert!(high.x > low.x && high.x < low.x + 0.1);
        let face = Face { axis: 0, is_far: true };
        let wall = ShapeKind::Solid(Solid::default());
        for by in [f32::NAN, f32::INFINITY] {
            assert_eq!(pushed(&wall, &pose, face, by), None);
        }
    }
}
