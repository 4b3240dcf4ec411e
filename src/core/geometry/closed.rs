//! Whether a mesh encloses space: whether each of its edges has a triangle on both sides.

use std::collections::HashMap;

use glam::Vec3;

use super::mesh::MeshData;

impl MeshData {
    /// The number of edges that do not have as many triangles on one side as on the other; 0 for a mesh without holes.
    /// Vertices at the same place count as one, because files repeat those where texture coordinates or normals
    /// differ. Triangles without area do not count.
    pub fn open_edges(&self) -> usize {
        let vertices = self.welded();
        let mut edges: Vec<(u32, u32, i32)> = Vec::with_capacity(3 * self.triangles.len());
        for triangle in &self.triangles {
            let [a, b, c] = triangle.map(|vertex| vertices[vertex as usize]);
            if a == b || b == c || c == a {
                continue;
            }
            edges.extend([(a, b), (b, c), (c, a)].map(|(from, to)| match from < to {
                true => (from, to, 1),
                false => (to, from, -1),
            }));
        }
        edges.sort_unstable();
        let of_edge = edges.chunk_by(|one, other| (one.0, one.1) == (other.0, other.1));
        of_edge
            .filter(|sides| sides.iter().map(|side| side.2).sum::<i32>() != 0)
            .count()
    }

    /// For each vertex the first one at its place.
    fn welded(&self) -> Vec<u32> {
        // Zero of either sign is the same place.
        let key = |place: Vec3| (place + Vec3::ZERO).to_array().map(f32::to_bits);
        let mut first = HashMap::with_capacity(self.positions.len());
        let places = self.positions.iter().zip(0..);
        places
            .map(|(place, index)| *first.entry(key(*place)).or_insert(index))
            .collect()
    }
}

#[cfg(test)]
mod tests {
    use super::super::primitives::unit_cube;
    use super::*;

    #[test]
    fn a_cube_is_closed_and_one_without_a_triangle_is_not() {
        // Each face of the cube has corners of its own.
        let mut cube = unit_cube();
        assert_eq!(cube.open_edges(), 0);
        cube.triangles.pop();
        assert_eq!(cube.open_edges(), 3);
        // A triangle that is turned around does not close the hole.
        let turned = unit_cube().triangles[11];
        cube.triangles.push([turned[0], turned[2], turned[1]]);
        assert_eq!(cube.open_edges(), 3);
    }

    #[test]
    fn a_zero_has_no_sign_and_what_has_no_area_no_edge() {
        let mut cube = unit_cube();
        for place in &mut cube.positions {
            *place = (*place + 1.0) * 0.5;
        }
        for (index, place) in cube.positions.iter_mut().enumerate() {
            if index % 2 == 0 && place.x == 0.0 {
                place.x = -0.0;
            }
        }
        cube.triangles.push([0, 0, 1]);
        assert_eq!(cube.open_edges(), 0);
    }

    #[test]
    fn two_cubes_that_share_an_edge_are_closed() {
        let mut both = unit_cube();
        let other = unit_cube();
        let first = both.positions.len() as u32;
        both.positions
            .extend(other.positions.iter().map(|place| *place + Vec3::new(2.0, 2.0, 0.0)));
        both.triangles.extend(
            other
                .triangles
                .iter()
                .map(|corners| corners.map(|corner| corner + first)),
        );
        assert_eq!(both.open_edges(), 0);
    }
}
