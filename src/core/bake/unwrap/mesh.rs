//! A mesh that is to be unwrapped.

use glam::{DVec3, Vec3};

/// Gets the finished share, from 0 to 1, and the name of the present step. It may be called on any thread.
pub type Told<'a> = &'a (dyn Fn(f64, &str) + Sync);

/// A mesh to be unwrapped, in its size in the world.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct UnwrapMesh {
    /// The name in messages, such as the path of its shape.
    pub name: String,
    /// The vertices.
    pub positions: Vec<Vec3>,
    /// The corners.
    pub triangles: Vec<[u32; 3]>,
    /// The part of the mesh that each triangle belongs to. No chart has triangles of two parts.
    pub part_of_triangle: Vec<u32>,
    /// The number of instances in the world; each gets a rectangle of its own in the lightmaps.
    pub places: usize,
}

/// The least height of a triangle relative to its mesh's extent. The crate drops triangles below half of that, and
/// cannot lay out a mesh that has no others.
const LEAST_HEIGHT: f64 = 2e-6;

/// The most triangles of a mesh that is unwrapped as a whole.
const LARGEST_WHOLE: usize = 10_000;

impl UnwrapMesh {
    /// Whether any triangle can have lightmap texels: not if all are so thin that single precision takes them for
    /// lines.
    pub fn has_surface(&self) -> bool {
        let least = LEAST_HEIGHT * self.extent();
        self.triangles.iter().any(|triangle| {
            let [a, b, c] = triangle.map(|corner| self.positions[corner as usize].as_dvec3());
            let longest = (b - a).length().max((c - b).length()).max((a - c).length());
            (b - a).cross(c - a).length() / longest > least
        })
    }

    /// Whether the mesh is cut into pieces before it is unwrapped.
    pub(super) fn is_large(&self) -> bool {
        self.triangles.len() > LARGEST_WHOLE
    }

    /// The length of the diagonal of the bounding box.
    pub(super) fn extent(&self) -> f64 {
        let places = || self.positions.iter().map(|place| place.as_dvec3());
        let extent = places().fold(DVec3::NEG_INFINITY, DVec3::max) - places().fold(DVec3::INFINITY, DVec3::min);
        extent.length()
    }

    /// The area of all instances.
    pub(super) fn area(&self) -> f64 {
        let of = |triangle: &[u32; 3]| {
            let [a, b, c] = triangle.map(|corner| self.positions[corner as usize].as_dvec3());
            0.5 * (b - a).cross(c - a).length()
        };
        self.places as f64 * self.triangles.iter().map(of).sum::<f64>()
    }
}
