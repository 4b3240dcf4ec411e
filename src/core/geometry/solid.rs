//! Meshes of parametric building parts: walls with openings, stairs, prisms, roofs.
//!
//! All stand on the plane z = 0 of their own space, with z upwards; the eaves of roofs hang below it. They are closed
//! surfaces with flat normals outward. Texture coordinates are lengths on the face in the units of the space, u to the
//! right and v downwards as seen from outside, so that textures stand upright and keep their size on faces of all
//! sizes.

mod roof;

use std::f32::consts::{FRAC_PI_2, TAU};
use std::fmt::Write;

use glam::{DVec3, Vec2, Vec3};

use super::mesh::MeshData;
use super::polygon::triangulate;
pub use roof::{Roof, RoofForm, roof};

/// An opening, as a rectangle of the wall's face.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Hole {
    /// The distance from the wall's start.
    pub from: f32,
    /// The height of the lower edge.
    pub sill: f32,
    /// The extent along the wall.
    pub width: f32,
    /// The extent upwards.
    pub height: f32,
}

/// The box from (0, -thickness / 2, 0) to (length, thickness / 2, height) without its openings, which go through it
/// along y. Openings may overlap, and are clipped to the wall. The faces are cut along the edges of all openings, so
/// that neighbours share whole edges.
pub fn wall(length: f32, height: f32, thickness: f32, holes: &[Hole]) -> MeshData {
    // An invalid length gives an empty mesh.
    let [length, height] = [length, height].map(|extent| extent.max(0.0));
    let inside = clipped(length, height, holes);
    let xs = cuts(length, inside.iter().flat_map(|[left, right, ..]| [*left, *right]));
    let zs = cuts(height, inside.iter().flat_map(|[.., low, high]| [*low, *high]));
    let is_open = |i: usize, j: usize| {
        let (x, z) = (xs[i], zs[j]);
        let covers = |[left, right, low, high]: &[f32; 4]| *left <= x && x < *right && *low <= z && z < *high;
        inside.iter().any(covers)
    };
    let (columns, rows) = (xs.len() - 1, zs.len() - 1);
    let is_solid = |i: Option<usize>, j: Option<usize>| match (i, j) {
        (Some(i), Some(j)) => i < columns && j < rows && !is_open(i, j),
        _ => false,
    };
    let (front, back) = (-0.5 * thickness, 0.5 * thickness);
    let mut facets = Facets::new(Vec3::new(0.0, 0.0, height));
    for i in 0..columns {
        for j in (0..rows).filter(|&j| !is_open(i, j)) {
            let (x0, x1, z0, z1) = (xs[i], xs[i + 1], zs[j], zs[j + 1]);
            let at = Vec3::new;
            facets.polygon(&[
                at(x0, front, z0),
                at(x1, front, z0),
                at(x1, front, z1),
                at(x0, front, z1),
            ]);
            facets.polygon(&[at(x1, back, z0), at(x0, back, z0), at(x0, back, z1), at(x1, back, z1)]);
            if !is_solid(i.checked_sub(1), Some(j)) {
                facets.polygon(&[at(x0, back, z0), at(x0, front, z0), at(x0, front, z1), at(x0, back, z1)]);
            }
            if !is_solid(Some(i + 1), Some(j)) {
                facets.polygon(&[at(x1, front, z0), at(x1, back, z0), at(x1, back, z1), at(x1, front, z1)]);
            }
            if !is_solid(Some(i), j.checked_sub(1)) {
                facets.polygon(&[at(x0, back, z0), at(x1, back, z0), at(x1, front, z0), at(x0, front, z0)]);
            }
            if !is_solid(Some(i), Some(j + 1)) {
                facets.polygon(&[at(x0, front, z1), at(x1, front, z1), at(x1, back, z1), at(x0, back, z1)]);
            }
        }
    }
    facets.finish()
}

/// The ends of the openings along the wall and upwards, without what reaches beyond the wall.
fn clipped(length: f32, height: f32, holes: &[Hole]) -> Vec<[f32; 4]> {
    holes
        .iter()
        .map(|hole| {
            let [left, right] = [hole.from, hole.from + hole.width].map(|x| x.clamp(0.0, length));
            let [low, high] = [hole.sill, hole.sill + hole.height].map(|z| z.clamp(0.0, height));
            [left, right, low, high]
        })
        .filter(|[left, right, low, high]| left < right && low < high)
        .collect()
}

/// The openings of a [`wall`] as rectangles in its middle: a corner, and the edges from there.
pub fn openings(length: f32, height: f32, holes: &[Hole]) -> Vec<(Vec3, [Vec3; 2])> {
    let [length, height] = [length, height].map(|extent| extent.max(0.0));
    clipped(length, height, holes)
        .into_iter()
        .map(|[left, right, low, high]| {
            let corner = Vec3::new(left, 0.0, low);
            (corner, [Vec3::X * (right - left), Vec3::Z * (high - low)])
        })
        .collect()
}

/// The sorted positions of all edges between 0 and `end`, without duplicates.
fn cuts(end: f32, edges: impl Iterator<Item = f32>) -> Vec<f32> {
    let mut cuts: Vec<f32> = edges.chain([0.0, end]).collect();
    cuts.sort_by(f32::total_cmp);
    cuts.dedup();
    cuts
}

/// Solid stairs: they begin at y = 0, rise along +y over `depth` to `height`, and reach from -width / 2 to width / 2
/// along x. All steps are equal.
pub fn stairs(width: f32, depth: f32, height: f32, steps: u32) -> MeshData {
    let steps = steps.max(1);
    let half = 0.5 * width;
    let at = |step: u32, size: f32| step as f32 / steps as f32 * size;
    let mut facets = Facets::new(Vec3::new(0.0, 0.0, height));
    // A rectangle across the stairs, between two lines along x: the right end of each is given as y and z.
    let across = |facets: &mut Facets, a: (f32, f32), b: (f32, f32)| {
        let corner = |x: f32, (y, z): (f32, f32)| Vec3::new(x, y, z);
        facets.polygon(&[corner(half, b), corner(half, a), corner(-half, a), corner(-half, b)]);
    };
    for step in 0..steps {
        let [front, back] = [step, step + 1].map(|step| at(step, depth));
        let [below, top] = [step, step + 1].map(|step| at(step, height));
        across(&mut facets, (front, 0.0), (back, 0.0));
        across(&mut facets, (back, top), (front, top));
        across(&mut facets, (front, top), (front, below));
        // The sides have a corner wherever the step before has one, so that no edge ends inside another. All triangles
        // have an area: the edges of the steps lie on a line, and three of them would make none.
        for x in [half, -half] {
            let side = |facets: &mut Facets, outline: &[(f32, f32)]| {
                let mut corners: Vec<Vec3> = outline.iter().map(|&(y, z)| Vec3::new(x, y, z)).collect();
                if x < 0.0 {
                    corners.reverse();
                }
                facets.polygon(&corners);
            };
            side(&mut facets, &[(back, 0.0), (back, top), (front, top), (front, below)]);
            if step > 0 {
                side(&mut facets, &[(back, 0.0), (front, below), (front, 0.0)]);
            }
        }
    }
    across(&mut facets, (depth, 0.0), (depth, height));
    facets.finish()
}

/// A regular prism around the z axis. Its corners are `radius` away from the axis at the foot and `top_radius` at
/// `height`; with a top of 0 it is a pyramid. One side faces -y.
pub fn prism(radius: f32, top_radius: f32, height: f32, sides: u32) -> MeshData {
    let sides = sides.max(3);
    let corner = |radius: f32, z: f32, k: u32| {
        let angle = (k % sides) as f32 * TAU / sides as f32 - FRAC_PI_2 - 0.5 * TAU / sides as f32;
        Vec3::new(radius * angle.cos(), radius * angle.sin(), z)
    };
    let foot = |k| corner(radius, 0.0, k);
    let top = |k| corner(top_radius, height, k);
    let mut facets = Facets::new(Vec3::new(0.0, 0.0, height));
    let ring: Vec<Vec3> = (0..sides).rev().map(foot).collect();
    facets.polygon(&ring);
    for k in 0..sides {
        match top_radius > 0.0 {
            true => facets.polygon(&[foot(k), foot(k + 1), top(k + 1), top(k)]),
            false => facets.polygon(&[foot(k), foot(k + 1), Vec3::new(0.0, 0.0, height)]),
        }
    }
    if top_radius > 0.0 {
        let ring: Vec<Vec3> = (0..sides).map(top).collect();
        facets.polygon(&ring);
    }
    facets.finish()
}

/// The flat polygons of a mesh under construction.
struct Facets {
    mesh: MeshData,
    /// The point with the texture coordinates (0, 0).
    origin: Vec3,
}

impl Facets {
    fn new(origin: Vec3) -> Self {
        Self {
            mesh: MeshData::default(),
            origin,
        }
    }

    /// Adds a flat polygon, counter-clockwise as seen from outside. A polygon without area adds nothing.
    fn polygon(&mut self, corners: &[Vec3]) {
        let [first, ..] = corners else { return };
        // Newell's normal holds for polygons that are not convex, too. It needs double precision, because squares of
        // large lengths overflow in single precision.
        let turned = corners.iter().zip(corners.iter().cycle().skip(1));
        let from_first = |corner: &Vec3| corner.as_dvec3() - first.as_dvec3();
        let area: DVec3 = turned.map(|(a, b)| from_first(a).cross(from_first(b))).sum();
        let size = area.length();
        if !(size > 0.0 && size.is_finite()) {
            return;
        }
        // Unlike the product with a reciprocal, this is exactly 1 along an axis.
        let normal = (area / size).as_vec3();
        let (u, v) = directions(normal);
        let base = self.mesh.positions.len() as u32;
        for corner in corners {
            let along = *corner - self.origin;
            self.mesh.positions.push(*corner);
            self.mesh.normals.push(normal);
            self.mesh.uvs.push(Vec2::new(along.dot(u), along.dot(v)));
        }
        let triangles = &mut self.mesh.triangles;
        triangulate(corners, |triangle| {
            triangles.push(triangle.map(|corner| base + corner as u32));
        });
    }

    fn finish(self) -> MeshData {
        self.mesh
    }
}

/// The directions in which u and v grow on a face: to the right and down as seen from outside, on level faces along x
/// and against y.
fn directions(normal: Vec3) -> (Vec3, Vec3) {
    let right = match Vec3::Z.cross(normal) {
        level if level.length_squared() < 1e-6 => Vec3::X,
        right => right.normalize(),
    };
    (right, right.cross(normal))
}

/// The mesh with its normals and texture coordinates as PLY text, for programs that do not know its parameters.
pub fn to_ply(mesh: &MeshData) -> String {
    let mut text = format!(
        "ply\nformat ascii 1.0\nelement vertex {}\nproperty float x\nproperty float y\nproperty float z\nproperty float nx\nproperty float ny\n\
         property float nz\nproperty float u\nproperty float v\nelement face {}\nproperty list uchar int vertex_indices\nend_header\n",
        mesh.positions.len(),
        mesh.triangles.len(),
    );
    let vertices = mesh.positions.iter().zip(&mesh.normals).zip(&mesh.uvs);
    for ((position, normal), uv) in vertices {
        let numbers = [position.to_array(), normal.to_array()].concat();
        let numbers: Vec<String> = numbers.iter().chain(&uv.to_array()).map(f32::to_string).collect();
        // Writing to a text cannot fail.
        let _ = writeln!(text, "{}", numbers.join(" "));
    }
    for [a, b, c] in &mesh.triangles {
        let _ = writeln!(text, "3 {a} {b} {c}");
    }
    text
}
