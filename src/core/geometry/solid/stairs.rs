//! Straight stairs.

use glam::Vec3;

use super::facets::Facets;
use crate::geometry::mesh::MeshData;

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
