//! Prisms, and pyramids as prisms with a pointed top.

use std::f32::consts::{FRAC_PI_2, TAU};

use glam::Vec3;

use super::facets::Facets;
use crate::geometry::mesh::MeshData;

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
