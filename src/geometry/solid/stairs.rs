//! Straight stairs.

use glam::Vec3;

use super::facets::Facets;
use crate::geometry::mesh::MeshData;

/// Solid stairs: they begin at y = 0, rise along +y over `depth` to `height`, and reach from -width / 2 to width / 2 along x. All steps are equal.
pub fn stairs(width: f32, depth: f32, height: f32, steps: u32) -> MeshData {
    let steps = steps.max(1);
    let share = |step: u32| step as f32 / steps as f32;
    // The outline in the plane of y and z, counter-clockwise as seen from +x.
    let mut outline = vec![(0.0, 0.0), (depth, 0.0), (depth, height)];
    for step in (0..steps).rev() {
        let y = share(step) * depth;
        outline.push((y, share(step + 1) * height));
        if step > 0 {
            outline.push((y, share(step) * height));
        }
    }
    let half = 0.5 * width;
    let mut facets = Facets::new(Vec3::new(0.0, 0.0, height));
    let side: Vec<Vec3> = outline.iter().map(|&(y, z)| Vec3::new(half, y, z)).collect();
    facets.polygon(&side);
    let side: Vec<Vec3> = outline.iter().rev().map(|&(y, z)| Vec3::new(-half, y, z)).collect();
    facets.polygon(&side);
    for (a, b) in outline.iter().zip(outline.iter().cycle().skip(1)) {
        let [left, right] = [-half, half];
        facets.polygon(&[
            Vec3::new(right, b.0, b.1),
            Vec3::new(right, a.0, a.1),
            Vec3::new(left, a.0, a.1),
            Vec3::new(left, b.0, b.1),
        ]);
    }
    facets.finish()
}
