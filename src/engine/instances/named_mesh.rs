//! Finds the mesh that a shape names, built or being built.

use bevy::math::Affine3A;

use crate::engine::authored::Authored;
use crate::engine::blas_cache::{BlasCache, BuildPolicy, BuiltMesh, MeshKey};
use crate::geometry::strands::stretch_of;
use crate::scene::assets::triangle_mesh::basis_of;
use crate::scene::{MeshHandle, Shape, ShapeKind};

/// The mesh that a shape names.
pub(super) struct NamedMesh<'c> {
    /// None if the mesh does not exist or is not built yet.
    pub built: Option<&'c BuiltMesh>,
    /// Whether its file is still being read.
    pub is_loading: bool,
}

pub(super) fn mesh_of<'c>(
    shape: &Shape,
    to_world: &Affine3A,
    handle: Option<&MeshHandle>,
    authored: &Authored,
    cache: &'c mut BlasCache,
    policy: &BuildPolicy,
) -> NamedMesh<'c> {
    let mut is_loading = false;
    let built = match (&shape.kind, handle) {
        (ShapeKind::Cube, _) => {
            let cube = cache.cube();
            cache.get(MeshKey::Cube, &cube, policy)
        }
        (ShapeKind::Triangle { .. }, _) => {
            let triangle = cache.triangle();
            cache.get(MeshKey::Triangle, &triangle, policy)
        }
        (ShapeKind::Solid(solid), _) => {
            let (key, mesh) = cache.solid(solid);
            cache.get(key, &mesh, policy)
        }
        (ShapeKind::Mesh(file), Some(MeshHandle(handle))) => match authored.meshes.get(handle) {
            Some(mesh) => {
                let key = match basis_of(file.format) {
                    Some(basis) => MeshKey::Curves {
                        id: handle.id(),
                        basis,
                        stretch: stretch_of(to_world).to_cols_array().map(f32::to_bits),
                    },
                    None => MeshKey::Asset {
                        id: handle.id(),
                        shape_index: file.shape_index,
                        upside_down: file.flip_tex_coords != file.format.flips_tex_coords(),
                    },
                };
                mesh.data(file.shape_index)
                    .and_then(|data| cache.get(key, data, policy))
            }
            None => {
                is_loading = !authored.has_failed(handle.id());
                None
            }
        },
        (ShapeKind::Mesh(_), None) => {
            is_loading = true;
            None
        }
        _ => None,
    };
    NamedMesh { built, is_loading }
}
