//! Texture coordinates from world positions, in tiles: u to the right and v down, as seen in the texture.

use std::collections::HashMap;
use std::f32::consts::TAU;

use bevy::math::{Affine2, Affine3A, Mat2, Vec2, Vec3};

use crate::geometry::attribute::{AttributeDomain, AttributeValues};
use crate::geometry::mesh::MeshData;
use crate::math::Aabb;

/// A map from world positions to tiles.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Mapping {
    /// Each face from the side of a box that it faces most.
    Box {
        /// The upward direction.
        up: Vec3,
        /// The edge of a tile in world units.
        tile: f32,
    },
    /// From one direction.
    Plane(Plane),
    /// Around an upright axis.
    Around {
        /// The middle.
        middle: Vec3,
        /// The upward direction.
        up: Vec3,
        /// The tiles around the axis, a whole number, so that the texture closes.
        turn: f32,
        /// The tiles from pole to pole of a sphere; None for a cylinder.
        poles: Option<f32>,
        /// The edge of a tile, for the height of a cylinder.
        tile: f32,
    },
}

/// A side from which a texture is projected.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Plane {
    /// Tiles to the right and down, per unit of the world.
    axes: [Vec3; 2],
}

impl Plane {
    /// The plane that a normal points to. `top` is the direction of the texture's upper edge, projected into the plane.
    pub fn facing(normal: Vec3, top: Vec3, tile: f32) -> Self {
        let is_level = normal.dot(top).abs() >= 0.999 * normal.length() * top.length();
        let upright = top.reject_from(normal).try_normalize().filter(|_| !is_level);
        // On level faces the upper edge points along -z, or along +y if z is up.
        let top = upright.unwrap_or(match top.y.abs() > 0.5 {
            true => Vec3::NEG_Z,
            false => Vec3::Y,
        });
        let right = top.cross(normal).normalize_or(Vec3::X);
        let down = right.cross(normal).normalize_or(Vec3::NEG_Y);
        Self {
            axes: [right / tile, down / tile],
        }
    }

    pub fn tiles(&self, place: Vec3) -> Vec2 {
        Vec2::from(self.axes.map(|axis| place.dot(axis)))
    }

    /// The tiles of a flat shape from its uv. `world_from_uv` takes uv as x and y.
    pub fn tiles_from_uv(&self, world_from_uv: &Affine3A) -> Affine2 {
        let [x, y, origin] = [Vec3::X, Vec3::Y, Vec3::ZERO].map(|uv| self.tiles(world_from_uv.transform_point3(uv)));
        Affine2::from_mat2_translation(Mat2::from_cols(x - origin, y - origin), origin)
    }
}

impl Mapping {
    /// The tiles at the corners of a triangle of the world.
    pub fn tiles(&self, corners: [Vec3; 3]) -> [Vec2; 3] {
        match self {
            Self::Box { up, tile } => {
                let [a, b, c] = corners;
                let side = side((b - a).cross(c - a));
                let plane = Plane::facing(side, *up, *tile);
                corners.map(|corner| plane.tiles(corner))
            }
            Self::Plane(plane) => corners.map(|corner| plane.tiles(corner)),
            Self::Around {
                middle,
                up,
                turn,
                poles,
                tile,
            } => {
                let x = Plane::facing(Vec3::Z, *up, 1.0).axes[0]
                    .reject_from(*up)
                    .normalize_or(up.any_orthonormal_vector());
                let y = up.cross(x);
                let places = corners.map(|corner| corner - middle);
                let turns = places.map(|place| {
                    let (along, across) = (place.dot(x), place.dot(y));
                    let is_pole = along.hypot(across) <= 1e-5 * place.length();
                    (!is_pole).then(|| across.atan2(along) / TAU)
                });
                let unwound = unwound(turns);
                std::array::from_fn(|corner| {
                    let place = places[corner];
                    let down = match poles {
                        Some(poles) => place.angle_between(*up) / (0.5 * TAU) * poles,
                        None => -corners[corner].dot(*up) / tile,
                    };
                    Vec2::new(unwound[corner] * turn, down)
                })
            }
        }
    }
}

/// The axis of the world, or its opposite, nearest to a face's normal.
pub(super) fn side(normal: Vec3) -> Vec3 {
    // Among equal axes the first is taken, so that rounding errors do not matter.
    let steepness = normal.abs() * Vec3::new(1.0, 0.9999, 0.9998);
    let axis = steepness.max_position();
    let mut side = Vec3::ZERO;
    side[axis] = normal[axis].signum();
    side
}

/// Angles in turns within half a turn of the first. A pole, which has no angle, gets the mean of the others.
fn unwound(turns: [Option<f32>; 3]) -> [f32; 3] {
    let first = turns.into_iter().flatten().next().unwrap_or(0.0);
    let near = turns.map(|turn| turn.map(|turn| turn - (turn - first).round()));
    let known: Vec<f32> = near.into_iter().flatten().collect();
    let mean = known.iter().sum::<f32>() / known.len().max(1) as f32;
    near.map(|turn| turn.unwrap_or(mean))
}

/// The mesh with texture coordinates: `uv_from_tiles` of the tiles at each world position. Vertices are split where the
/// coordinates of adjacent faces differ.
pub(super) fn mapped(mesh: &MeshData, pose: &Affine3A, mapping: &Mapping, uv_from_tiles: &Affine2) -> MeshData {
    let mut made = MeshData::default();
    let mut sources = Vec::new();
    let mut known: HashMap<(u32, [u32; 2]), u32> = HashMap::new();
    // A mirroring pose flips normals that were computed from the triangles, but not those of a file.
    let side = match mesh.has_computed_normals && pose.matrix3.determinant() < 0.0 {
        true => -1.0,
        false => 1.0,
    };
    for triangle in &mesh.triangles {
        let places = triangle.map(|corner| pose.transform_point3(mesh.positions[corner as usize]));
        let tiles = mapping.tiles(places);
        made.triangles.push(std::array::from_fn(|corner| {
            let vertex = triangle[corner];
            let uv = uv_from_tiles.transform_point2(tiles[corner]) + Vec2::ZERO;
            *known
                .entry((vertex, uv.to_array().map(f32::to_bits)))
                .or_insert_with(|| {
                    made.positions.push(mesh.positions[vertex as usize]);
                    made.normals
                        .extend(mesh.normals.get(vertex as usize).map(|normal| side * *normal));
                    made.uvs.push(uv);
                    sources.push(vertex as usize);
                    made.positions.len() as u32 - 1
                })
        }));
    }
    made.attributes = mesh.attributes.clone();
    for attribute in made
        .attributes
        .iter_mut()
        .filter(|attribute| attribute.domain == AttributeDomain::Vertex)
    {
        let places = sources
            .iter()
            .flat_map(|vertex| attribute.channels * vertex..attribute.channels * (vertex + 1));
        attribute.values = match &attribute.values {
            AttributeValues::Srgb8(values) => AttributeValues::Srgb8(places.map(|place| values[place]).collect()),
            AttributeValues::F32(values) => AttributeValues::F32(places.map(|place| values[place]).collect()),
        };
    }
    made
}

/// The direction that most of a surface faces, by area.
pub(super) fn main_direction(mesh: &MeshData, pose: &Affine3A) -> Option<Vec3> {
    let mut sums: HashMap<[i32; 3], Vec3> = HashMap::new();
    for triangle in 0..mesh.triangles.len() {
        let [a, b, c] = mesh.corners(triangle).map(|corner| pose.transform_point3(corner));
        let area = (b - a).cross(c - a);
        if let Some(normal) = area.try_normalize() {
            let cell = (8.0 * normal).round().as_ivec3().to_array();
            *sums.entry(cell).or_default() += area;
        }
    }
    // The cell breaks ties, so that the order of the map does not.
    let largest = sums.into_iter().max_by(|(cell, a), (other, b)| {
        let by_area = a.length().total_cmp(&b.length());
        by_area.then_with(|| cell.cmp(other))
    });
    let direction = largest.and_then(|(_, sum)| sum.try_normalize())?;
    let axis = side(direction);
    let turned = if pose.matrix3.determinant() < 0.0 { -1.0 } else { 1.0 };
    Some(turned * if direction.dot(axis) > 0.9999 { axis } else { direction })
}

/// The map for a shape of these bounds around an upright axis.
pub(super) fn around(bounds: &Aabb, up: Vec3, tile: f32, is_sphere: bool) -> Mapping {
    let across = 0.5 * bounds.extent().reject_from(up).abs().max_element();
    let radius = if is_sphere {
        0.5 * bounds.extent().max_element()
    } else {
        across
    };
    let whole = |length: f32| (length / tile).round().max(1.0);
    Mapping::Around {
        middle: bounds.center(),
        up,
        turn: whole(TAU * radius),
        poles: is_sphere.then(|| whole(0.5 * TAU * radius)),
        tile,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::primitives::unit_cube;

    #[test]
    fn a_box_has_tiles_of_one_size_on_all_faces() {
        let pose = Affine3A::from_scale(Vec3::new(2.5, 1.25, 0.1));
        let mapping = Mapping::Box { up: Vec3::Y, tile: 0.5 };
        let mesh = mapped(&unit_cube(), &pose, &mapping, &Affine2::IDENTITY);
        assert_eq!((mesh.positions.len(), mesh.triangles.len()), (24, 12));
        for triangle in &mesh.triangles {
            let [a, b, c] = triangle.map(|corner| {
                let corner = corner as usize;
                (pose.transform_point3(mesh.positions[corner]), mesh.uvs[corner])
            });
            for (from, to) in [(a, b), (b, c), (c, a)] {
                let (length, tiles) = ((to.0 - from.0).length(), (to.1 - from.1).length());
                assert!((length - 0.5 * tiles).abs() < 1e-4, "{length} is {tiles} tiles");
            }
            // Upright: v grows downwards where the face is upright.
            let normal = mesh.normals[triangle[0] as usize];
            if normal.y == 0.0 {
                let down = [a, b, c].map(|(place, uv)| place.y + 0.5 * uv.y);
                assert!(down.iter().all(|sum| (sum - down[0]).abs() < 1e-4), "{down:?}");
            }
        }
    }

    #[test]
    fn pictures_are_not_mirrored_from_outside() {
        for normal in [Vec3::X, Vec3::NEG_X, Vec3::Y, Vec3::NEG_Y, Vec3::Z, Vec3::NEG_Z] {
            for up in [Vec3::Y, Vec3::Z] {
                let plane = Plane::facing(normal, up, 1.0);
                let [right, down] = plane.axes;
                // Right, down and away from the viewer is a right-handed frame.
                assert!(right.cross(down).dot(normal) < -0.999, "{normal} {up}");
                if normal.dot(up) == 0.0 {
                    assert!(down.dot(up) < -0.999, "{normal} {up}");
                }
            }
        }
    }

    #[test]
    fn a_texture_closes_around_a_sphere() {
        let bounds = Aabb {
            min: Vec3::NEG_ONE,
            max: Vec3::ONE,
        };
        let mapping = around(&bounds, Vec3::Y, 1.0, true);
        let Mapping::Around { turn, poles, .. } = mapping else {
            panic!("{mapping:?}")
        };
        assert_eq!((turn, poles), (6.0, Some(3.0)));
        // Across the seam of the angle, corners stay near each other.
        let angles = [3.1_f32, 3.2, 3.15];
        let corners = angles.map(|angle| Vec3::new(angle.cos(), 0.1 * angle, angle.sin()));
        let tiles = mapping.tiles(corners);
        assert!(tiles.iter().all(|tile| (tile.x - tiles[0].x).abs() < 0.5), "{tiles:?}");
        let at_pole = mapping.tiles([Vec3::Y, Vec3::new(0.5, 0.5, 0.0), Vec3::new(0.0, 0.5, 0.5)]);
        assert!(
            (at_pole[0].x - 0.5 * (at_pole[1].x + at_pole[2].x)).abs() < 1e-4,
            "{at_pole:?}"
        );
        assert_eq!(at_pole[0].y, 0.0);
    }

    #[test]
    fn the_main_direction_is_that_of_most_area() {
        let pose = Affine3A::from_scale(Vec3::new(3.0, 2.0, 0.1));
        let direction = main_direction(&unit_cube(), &pose).expect("it has an area");
        assert_eq!(direction.abs(), Vec3::Z);
        assert_eq!(main_direction(&MeshData::default(), &pose), None);
    }
}
