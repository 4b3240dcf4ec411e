//! Makes the built-in meshes: triangle and cube.

use glam::{Vec2, Vec3};

use super::mesh::MeshData;

/// The triangle (0, 0, 0), (1, 0, 0), (0, 1, 0), which faces +z.
pub fn unit_triangle() -> MeshData {
    MeshData {
        positions: vec![Vec3::ZERO, Vec3::X, Vec3::Y],
        triangles: vec![[0, 1, 2]],
        ..MeshData::default()
    }
}

/// The cube [-1, 1]³ with the vertex order, normals and uvs of Mitsuba's `cube`: four vertices per face, each face [0,
/// 1]² in uv, flat normals outward, triangles counter-clockwise from outside.
pub fn unit_cube() -> MeshData {
    // The directions in which u and v grow on each face; the outward normal is v × u.
    const FACES: [(Vec3, Vec3); 6] = [
        (Vec3::Z, Vec3::X),
        (Vec3::NEG_X, Vec3::NEG_Z),
        (Vec3::Y, Vec3::NEG_Z),
        (Vec3::Y, Vec3::X),
        (Vec3::Y, Vec3::Z),
        (Vec3::NEG_Y, Vec3::X),
    ];
    const UVS: [Vec2; 4] = [Vec2::new(0.0, 1.0), Vec2::ONE, Vec2::new(1.0, 0.0), Vec2::ZERO];

    let mut cube = MeshData::default();
    for (face, (along_u, along_v)) in (0u32..).zip(FACES) {
        let normal = along_v.cross(along_u);
        for uv in UVS {
            let corner = normal + (2.0 * uv.x - 1.0) * along_u + (2.0 * uv.y - 1.0) * along_v;
            cube.positions.push(corner);
            cube.normals.push(normal);
            cube.uvs.push(uv);
        }
        let first = 4 * face;
        cube.triangles.push([first, first + 1, first + 2]);
        cube.triangles.push([first + 3, first, first + 2]);
    }
    cube
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_cube_is_closed_and_faces_outward() {
        let cube = unit_cube();
        assert_eq!((cube.positions.len(), cube.triangles.len()), (24, 12));
        assert_eq!((cube.bounds().min, cube.bounds().max), (Vec3::NEG_ONE, Vec3::ONE));
        for (i, triangle) in cube.triangles.iter().enumerate() {
            let [a, b, c] = cube.corners(i);
            let outward = (b - a).cross(c - a);
            // Half of a 2 x 2 face each, towards the side the vertex normals name.
            assert_eq!(outward, 4.0 * cube.normals[triangle[0] as usize]);
            assert!(outward.dot(a) > 0.0);
            assert_eq!(cube.area_of_triangle(i), 2.0);
        }
    }

    #[test]
    fn first_face_is_laid_out_as_in_mitsuba() {
        let cube = unit_cube();
        assert_eq!(cube.positions[0], Vec3::new(1.0, -1.0, -1.0));
        assert_eq!(cube.positions[1], Vec3::new(1.0, -1.0, 1.0));
        assert_eq!(cube.positions[2], Vec3::new(-1.0, -1.0, 1.0));
        assert_eq!(cube.positions[3], Vec3::new(-1.0, -1.0, -1.0));
        assert_eq!(cube.normals[0], Vec3::NEG_Y);
    }
}
