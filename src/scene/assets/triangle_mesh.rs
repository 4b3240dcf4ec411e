//! Triangle meshes loaded from an OBJ, PLY or serialized file, and curves.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use bevy::asset::io::Reader;
use bevy::asset::{AssetLoader, LoadContext};
use bevy::prelude::*;
use rayon::prelude::*;

use crate::document::paths::settle_covered;
use crate::files::{Access, FileError, LARGEST_NOTE};
use crate::geometry::curve::Basis;
use crate::geometry::mesh::MeshData;
use crate::geometry::mesh_file::{LoadedMesh, MeshError};
use crate::geometry::serialized::{self, SerializedFile};
use crate::geometry::{curve_file, obj, ply};
use crate::math::Aabb;
use crate::memory;
use crate::scene::{MeshFormat, SceneAccess};

/// The content of a mesh file: all of its shapes.
#[derive(Asset, TypePath, Clone, Debug)]
pub struct TriangleMesh {
    /// One shape of an OBJ or PLY file or one of curves, at least one of a serialized one.
    pub shapes: Vec<MeshShape>,
    /// The other files it was read from (material libraries), absolute, including missing ones.
    pub dependencies: Vec<PathBuf>,
}

/// A mesh in its own space; its texture coordinates are already flipped if that is the format's default.
#[derive(Clone, Debug)]
pub struct MeshShape {
    /// A new `Arc` after each reload.
    pub data: Arc<MeshData>,
    /// The bounding box of all vertices.
    pub bounds: Aabb,
    /// One sentence for each part that was left out or repaired.
    pub warnings: Vec<String>,
}

impl MeshShape {
    /// A mesh with these warnings.
    pub fn new(data: MeshData, warnings: Vec<String>) -> Self {
        Self {
            bounds: data.bounds(),
            data: Arc::new(data),
            warnings,
        }
    }
}

/// How the curves of a file of this format are made of control points; None for meshes.
pub(crate) fn basis_of(format: MeshFormat) -> Option<Basis> {
    match format {
        MeshFormat::BSplineCurve => Some(Basis::BSpline),
        MeshFormat::LinearCurve => Some(Basis::Linear),
        MeshFormat::Obj | MeshFormat::Ply | MeshFormat::Serialized => None,
    }
}

impl MeshShape {
    /// The reason why it is not what a shape with a file of this format needs, if so.
    pub(crate) fn misfit(&self, format: MeshFormat) -> Option<String> {
        let strands = &self.data.strands;
        match basis_of(format) {
            None if strands.is_empty() => None,
            None => Some("the file holds curves, not triangles".into()),
            Some(_) if strands.is_empty() => Some("the file holds no curves".into()),
            Some(basis) => {
                let (points, line) = strands.shortest;
                let least = basis.points();
                ((points as usize) < least).then(|| {
                    format!("line {line}: expected a curve of {least} control points or more, found one of {points}")
                })
            }
        }
    }
}

impl TriangleMesh {
    /// The mesh of a shape with this index in the file.
    pub fn data(&self, shape_index: u32) -> Option<&Arc<MeshData>> {
        self.shapes.get(shape_index as usize).map(|shape| &shape.data)
    }
}

/// The loaded file of a shape of kind `Mesh`. It follows the shape's path: it is set with the path, and removed if the
/// shape is no mesh.
#[derive(Component, Reflect, Clone, Debug, Default, PartialEq, Eq)]
#[reflect(Component, PartialEq)]
pub struct MeshHandle(pub Handle<TriangleMesh>);

/// Loads OBJ, PLY and serialized files and those of curves, recognised by their content.
#[derive(Default, TypePath)]
pub(crate) struct MeshLoader {
    pub access: SceneAccess,
}

/// The reason why a mesh file gives no mesh.
#[derive(Debug, thiserror::Error)]
#[allow(missing_docs, reason = "the messages say what the variants mean")]
pub enum MeshLoadError {
    #[error(transparent)]
    File(#[from] FileError),
    #[error(transparent)]
    Mesh(#[from] MeshError),
}

impl AssetLoader for MeshLoader {
    type Asset = TriangleMesh;
    type Settings = ();
    type Error = MeshLoadError;

    async fn load(
        &self,
        _reader: &mut dyn Reader,
        _settings: &(),
        context: &mut LoadContext<'_>,
    ) -> Result<TriangleMesh, MeshLoadError> {
        let path = context.path().path().to_owned();
        let access = self.access.get();
        load_mesh(&path, &access)
    }

    fn extensions(&self) -> &[&str] {
        &["obj", "ply", "serialized"]
    }
}

impl From<LoadedMesh> for MeshShape {
    fn from(loaded: LoadedMesh) -> Self {
        Self::new(loaded.mesh, loaded.warnings)
    }
}

/// A mesh file of any format, read from the disk if `access` permits.
pub fn load_mesh(path: &Path, access: &Access) -> Result<TriangleMesh, MeshLoadError> {
    let bytes = &memory::read_data(path, access)?;
    if !serialized::is_serialized(bytes) {
        return read_mesh(bytes, path, access);
    }
    let file = SerializedFile::open(bytes)?;
    let load = |shape| file.load(shape).map(MeshShape::from);
    let shapes: Vec<_> = (0..file.count()).into_par_iter().map(load).collect();
    Ok(TriangleMesh {
        // If several shapes are broken, the first error counts.
        shapes: shapes.into_iter().collect::<Result<_, _>>()?,
        dependencies: Vec::new(),
    })
}

/// Reads an OBJ or PLY file, or one of curves. `path` is the file of the bytes. Material libraries are searched beside
/// it, as far as `access` permits, and the paths of their pictures become absolute.
pub(crate) fn read_mesh(bytes: &[u8], path: &Path, access: &Access) -> Result<TriangleMesh, MeshLoadError> {
    let folder = path.parent().unwrap_or(Path::new(""));
    let mut dependencies = Vec::new();
    let mut may_quote = access.may_quote(path);
    let loaded = if bytes.starts_with(b"ply") {
        ply::load_ply(bytes)
    } else if curve_file::is_curve_file(bytes) {
        curve_file::load_curves(bytes)
    } else {
        let loaded = obj::load_obj(bytes, &mut |name| {
            let library = folder.join(name);
            dependencies.push(library.clone());
            let content = access.read(&library, LARGEST_NOTE)?;
            may_quote &= access.may_quote(&library);
            Ok(content)
        });
        loaded.map(|mut loaded| {
            loaded.mesh.flip_tex_coords();
            loaded
        })
    };
    let mut loaded = match may_quote {
        true => loaded?,
        false => loaded.map_err(MeshError::without_quotes)?.without_quotes(),
    };
    for map in loaded
        .mesh
        .materials
        .iter_mut()
        .flat_map(|material| material.maps.iter_mut())
    {
        map.file = settle_covered(folder, &map.file, access);
    }
    Ok(TriangleMesh {
        shapes: vec![loaded.into()],
        dependencies,
    })
}
