//! The meshes of building parts.

use glam::Vec3;

use crate::geometry::mesh::MeshData;
use crate::geometry::solid::{self, Hole, to_ply};
use crate::scene::{Opening, Solid};

/// The mesh of a building part in its own space: closed, with flat normals outward.
pub fn solid_mesh(part: &Solid) -> MeshData {
    match part {
        Solid::Wall {
            length,
            height,
            thickness,
            openings,
        } => solid::wall(*length, *height, *thickness, &holes(openings)),
        Solid::Stairs {
            width,
            depth,
            height,
            steps,
        } => solid::stairs(*width, *depth, *height, *steps),
        Solid::Prism {
            radius,
            top_radius,
            height,
            sides,
        } => solid::prism(*radius, *top_radius, *height, *sides),
        Solid::GableRoof { .. } | Solid::HipRoof { .. } | Solid::ShedRoof { .. } => {
            part.roof().map_or_else(MeshData::default, |roof| solid::roof(&roof))
        }
    }
}

/// The openings of a building part as rectangles in its own space: a corner, and the edges from there.
pub fn openings_of(part: &Solid) -> Vec<(Vec3, [Vec3; 2])> {
    match part {
        Solid::Wall {
            length,
            height,
            thickness: _,
            openings,
        } => solid::openings(*length, *height, &holes(openings)),
        Solid::Stairs { .. }
        | Solid::Prism { .. }
        | Solid::GableRoof { .. }
        | Solid::HipRoof { .. }
        | Solid::ShedRoof { .. } => Vec::new(),
    }
}

fn holes(openings: &[Opening]) -> Vec<Hole> {
    openings
        .iter()
        .map(|opening| Hole {
            from: opening.from,
            sill: opening.sill,
            width: opening.width,
            height: opening.height,
        })
        .collect()
}

/// The mesh of a building part as a PLY file; None if it has no triangles, such as a wall that openings cover entirely.
pub fn solid_ply(part: &Solid) -> Option<String> {
    let mesh = solid_mesh(part);
    (!mesh.triangles.is_empty()).then(|| to_ply(&mesh))
}
