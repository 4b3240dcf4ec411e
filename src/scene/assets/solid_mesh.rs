//! The meshes of building parts.

use crate::geometry::mesh::MeshData;
use crate::geometry::solid::{self, Hole, to_ply};
use crate::scene::Solid;

/// The mesh of a building part in its own space: closed, with flat normals outward.
pub fn solid_mesh(part: &Solid) -> MeshData {
    match part {
        Solid::Wall {
            length,
            height,
            thickness,
            openings,
        } => {
            let holes: Vec<Hole> = openings
                .iter()
                .map(|opening| Hole {
                    from: opening.from,
                    sill: opening.sill,
                    width: opening.width,
                    height: opening.height,
                })
                .collect();
            solid::wall(*length, *height, *thickness, &holes)
        }
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

/// The mesh of a building part as a PLY file; None if it has no triangles, such as a wall that openings cover entirely.
pub fn solid_ply(part: &Solid) -> Option<String> {
    let mesh = solid_mesh(part);
    (!mesh.triangles.is_empty()).then(|| to_ply(&mesh))
}
