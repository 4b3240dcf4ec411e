//! A wall with openings.

use glam::Vec3;

use super::facets::Facets;
use crate::geometry::mesh::MeshData;

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
/// along y. Openings may overlap, and end where the wall does. The faces are cut along the edges of all openings, so
/// that neighbours share whole edges.
pub fn wall(length: f32, height: f32, thickness: f32, holes: &[Hole]) -> MeshData {
    // There is no wall if a number is no possible length.
    let [length, height] = [length, height].map(|extent| extent.max(0.0));
    let inside: Vec<[f32; 4]> = holes
        .iter()
        .map(|hole| {
            let [left, right] = [hole.from, hole.from + hole.width].map(|x| x.clamp(0.0, length));
            let [low, high] = [hole.sill, hole.sill + hole.height].map(|z| z.clamp(0.0, height));
            [left, right, low, high]
        })
        .filter(|[left, right, low, high]| left < right && low < high)
        .collect();
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

/// The sorted places of all edges between 0 and the end, each once.
fn cuts(end: f32, edges: impl Iterator<Item = f32>) -> Vec<f32> {
    let mut cuts: Vec<f32> = edges.chain([0.0, end]).collect();
    cuts.sort_by(f32::total_cmp);
    cuts.dedup();
    cuts
}
