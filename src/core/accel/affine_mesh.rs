//! Meshes that are an affine image of a square or a cube, as most walls, floors and boxes are. One test finds the face
//! that a ray meets, and the face's coordinates at the hit tell which of its two triangles is hit.

use glam::{DAffine3, DMat3, DVec3, Vec2, Vec3};

use crate::geometry::mesh::MeshData;

/// The image of the square [-1, 1]² in the plane z = 0, or of the cube [-1, 1]³.
#[derive(Clone, Debug)]
pub(super) struct AffineMesh {
    /// The transform from the square's or cube's space to the mesh's. A square's third axis is a normal of any length.
    pub placed: DAffine3,
    /// The only face of a square, or the faces of a cube in the order x = -1, x = 1, y = -1, and so on.
    pub faces: Vec<Face>,
}

/// Two triangles that make up a parallelogram. A point on it has two coordinates: on a cube's face across an axis those
/// along the next two axes in turn, on the square x and y.
#[derive(Clone, Copy, Debug)]
pub(super) struct Face([Half; 2]);

#[derive(Clone, Copy, Debug)]
struct Half {
    /// Index into the mesh's triangles.
    triangle: u32,
    /// The corner of the face that the triangle does not have.
    lacks: Vec2,
    /// The weights of its corners 1 and 2 are the dot products of `u` and `v` with (point, 1).
    u: Vec3,
    v: Vec3,
}

impl AffineMesh {
    /// None if the mesh is not such an image within the rounding of its corners, or has a triangle twice.
    pub fn of(mesh: &MeshData) -> Option<Self> {
        // Besides 2 or 12 triangles there may be some that no ray can hit.
        if mesh.triangles.len() > 2 * 12 {
            return None;
        }
        let mut points: Vec<DVec3> = Vec::new();
        let mut triangles = Vec::new();
        for index in 0..mesh.triangles.len() {
            let Some(corners) = mesh.regular_corners(index) else {
                continue;
            };
            let corners = corners.map(|corner| {
                let corner = corner.as_dvec3();
                points.iter().position(|&point| point == corner).unwrap_or_else(|| {
                    points.push(corner);
                    points.len() - 1
                })
            });
            triangles.push((index as u32, corners));
        }
        let is_cube = match (triangles.len(), points.len()) {
            (2, 4) => false,
            (12, 8) => true,
            _ => return None,
        };
        // One corner of the first triangle joins two edges of the parallelogram; each of the three is tried.
        let [a, b, c] = triangles[0].1.map(|corner| points[corner]);
        [[a, b, c], [b, c, a], [c, a, b]].into_iter().find_map(|corners| {
            let (placed, signs) = fit(&points, corners, is_cube)?;
            let faces = faces(&triangles, &signs)?;
            Some(Self { placed, faces })
        })
    }
}

/// Finds the transform that takes the corners of the square or cube to the points, and the corner that belongs to each
/// point. `between` is the corner of one face between `s` and `t`.
fn fit(points: &[DVec3], [between, s, t]: [DVec3; 3], is_cube: bool) -> Option<(DAffine3, Vec<DVec3>)> {
    let middle = points.iter().sum::<DVec3>() / points.len() as f64;
    let third = |x: DVec3, y: DVec3, z: DVec3| if is_cube { z } else { x.cross(y).normalize() };
    let (x, y) = (0.5 * (s - between), 0.5 * (t - between));
    let first = DMat3::from_cols(x, y, third(x, y, middle - 0.5 * (s + t))).inverse();
    let own = if is_cube { DVec3::ONE } else { DVec3::new(1.0, 1.0, 0.0) };
    let signs: Vec<DVec3> = points.iter().map(|&p| own * (first * (p - middle)).signum()).collect();

    // The axes are a least squares fit to all corners.
    let axis = |k: usize| points.iter().zip(&signs).map(|(&p, sign)| sign[k] * p).sum::<DVec3>() / points.len() as f64;
    let (x, y) = (axis(0), axis(1));
    let linear = DMat3::from_cols(x, y, third(x, y, axis(2)));
    let inverse = linear.inverse();
    let largest = points.iter().fold(DVec3::ZERO, |largest, p| largest.max(p.abs()));
    let fits = |(&p, &sign): (&DVec3, &DVec3)| {
        let off = (linear * sign + middle - p).abs();
        // A hit's position is that of the triangles; a deviation this small is within the bounds on their rounding.
        off.cmple(f64::from(f32::EPSILON) * largest).all()
            && (inverse * (p - middle) - sign).abs().max_element() < MOST_OFF
    };
    let placed = DAffine3::from_mat3_translation(linear, middle);
    (points.iter().zip(&signs).all(fits) && placed.is_finite()).then_some((placed, signs))
}

/// The farthest that a corner may be off, in units of half an edge. Boxes so thin that their corners are mere rounding
/// exceed it.
const MOST_OFF: f64 = 1e-4;

/// Pairs the triangles that make up a face. `signs` are the coordinates of the corners.
fn faces(triangles: &[(u32, [usize; 3])], signs: &[DVec3]) -> Option<Vec<Face>> {
    let mut halves = vec![Vec::with_capacity(2); triangles.len() / 2];
    for &(triangle, corners) in triangles {
        let corners = corners.map(|corner| signs[corner].as_vec3());
        let axis = (0..3).find(|&k| corners.iter().all(|corner| corner[k] == corners[0][k]))?;
        let number = match corners[0][axis] {
            0.0 => 0,
            side => 2 * axis + usize::from(side > 0.0),
        };
        let [a, b, c] = corners.map(|corner| Vec2::new(corner[(axis + 1) % 3], corner[(axis + 2) % 3]));
        let (to_b, to_c) = (b - a, c - a);
        let weight = |across: Vec2| (across / to_b.perp_dot(to_c)).extend(-across.dot(a) / to_b.perp_dot(to_c));
        halves.get_mut(number)?.push(Half {
            triangle,
            lacks: -(a + b + c),
            u: weight(-to_c.perp()),
            v: weight(to_b.perp()),
        });
    }
    let face = |halves: &Vec<Half>| match halves[..] {
        [a, b] if a.lacks == -b.lacks => Some(Face([a, b])),
        _ => None,
    };
    halves.iter().map(face).collect()
}

impl Face {
    /// The triangle at the point `place`, and the weights of its corners 1 and 2 there.
    #[inline(always)]
    pub fn at(&self, place: Vec2) -> (u32, f32, f32) {
        let half = &self.0[usize::from(place.dot(self.0[0].lacks) > 0.0)];
        let place = place.extend(1.0);
        let u = half.u.dot(place).clamp(0.0, 1.0);
        (half.triangle, u, half.v.dot(place).max(0.0).min(1.0 - u))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::primitives::{unit_cube, unit_triangle};
    use crate::math::Aabb;

    /// A cube, rotated, sheared and moved so that its corners are rounded.
    fn oblique() -> MeshData {
        let mut mesh = unit_cube();
        for p in &mut mesh.positions {
            *p = Vec3::new(0.31, 2.7, 0.2) * p.x
                + Vec3::new(0.7, -0.3, 0.1) * p.y
                + Vec3::new(0.5, 0.4, -0.9) * p.z
                + Vec3::new(7.7, -3.1, 1.3);
        }
        mesh
    }

    #[test]
    fn each_face_knows_its_triangles() {
        for mesh in [unit_cube(), oblique()] {
            let found = AffineMesh::of(&mesh).unwrap();
            assert_eq!(found.faces.len(), 6);
            let mut met = [0; 12];
            for (number, face) in found.faces.iter().enumerate() {
                for place in [
                    [0.1, 0.3],
                    [-0.5, 0.9],
                    [0.2, -0.7],
                    [-0.9, -0.2],
                    [1.0, 1.0],
                    [-1.0, 1.0],
                ] {
                    let (triangle, u, v) = face.at(place.into());
                    met[triangle as usize] += 1;
                    let [a, b, c] = mesh.corners(triangle as usize);
                    let mut local = DVec3::ZERO;
                    let axis = number / 2;
                    local[axis] = [-1.0, 1.0][number % 2];
                    local[(axis + 1) % 3] = f64::from(place[0]);
                    local[(axis + 2) % 3] = f64::from(place[1]);
                    let expected = found.placed.transform_point3(local).as_vec3();
                    // Some roundings of coordinates below 16.
                    let point = (1.0 - u - v) * a + u * b + v * c;
                    assert!(point.abs_diff_eq(expected, 4e-6), "{point} {expected}");
                }
            }
            assert!(met.iter().all(|&times| times > 0), "{met:?}");
        }
    }

    #[test]
    fn a_square_has_one_face_whichever_its_diagonal() {
        let positions = vec![
            Vec3::ZERO,
            2.0 * Vec3::X,
            Vec3::new(3.0, 4.0, 1.0),
            Vec3::new(1.0, 4.0, 1.0),
        ];
        for triangles in [[[0, 1, 2], [0, 2, 3]], [[3, 0, 1], [2, 3, 1]]] {
            let mesh = MeshData {
                positions: positions.clone(),
                triangles: triangles.to_vec(),
                ..MeshData::default()
            };
            let found = AffineMesh::of(&mesh).unwrap();
            assert_eq!(found.faces.len(), 1);
            let corners = [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)]
                .map(|(x, y)| found.placed.transform_point3(DVec3::new(x, y, 0.0)).as_vec3());
            assert!(corners.iter().all(|corner| positions.contains(corner)), "{corners:?}");
            assert_eq!(Aabb::from_points(corners), mesh.bounds());
        }
    }

    #[test]
    fn what_is_no_image_of_either_is_left_alone() {
        assert!(AffineMesh::of(&unit_triangle()).is_none());
        let mut skewed = oblique();
        let corner = skewed.positions[0];
        skewed
            .positions
            .iter_mut()
            .filter(|p| **p == corner)
            .for_each(|p| p.x += 1e-4);
        assert!(AffineMesh::of(&skewed).is_none());
        let mut open = unit_cube();
        open.triangles.truncate(10);
        assert!(AffineMesh::of(&open).is_none());
        // A half that occurs twice, and two halves with the same missing corner.
        for other in [[0, 1, 2], [1, 2, 3]] {
            let mut doubled = unit_cube();
            doubled.triangles[1] = other;
            assert!(AffineMesh::of(&doubled).is_none(), "{other:?}");
        }
    }
}
