//! Opens glTF files as scenes: splits them into files in the cache, and makes a document that names these.
//!
//! A part is stored under the hash of its content. So meshes and pictures that do not change with the glTF file keep
//! their names, and are not loaded again.

use std::collections::HashSet;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use bevy::math::Affine3A;

use super::parts_cache::{CACHE, allow_parts};
use crate::document::source::MAX_FILE_BYTES;
use crate::document::{Category, Diagnostics, Document, Object, Severity, SourceFile};
use crate::files::Access;
use crate::geometry::mesh::MeshData;
use crate::gltf::files::take_apart;
use crate::gltf::scene::Imported;
use crate::gltf::{Gltf, GltfError};
use crate::scene::components::missing::NOT_THERE;

/// The most bytes of a glTF file, and of each file that it names: the length in the binary container has 32 bits.
const MAX_GLTF_BYTES: u64 = 4 << 30;

/// Whether a file is a glTF file for [`import`], by its content or else by its name.
pub(crate) fn is_gltf(bytes: &[u8], path: &Path) -> bool {
    Gltf::is_gltf(bytes) || is_called_gltf(path)
}

/// Whether the file name has an extension of glTF.
pub(crate) fn is_called_gltf(path: &Path) -> bool {
    let extension = path.extension().unwrap_or_default().to_ascii_lowercase();
    extension == "gltf" || extension == "glb"
}

/// The size limit of a scene file in bytes. The format follows from the name, because the file has not been read yet.
pub(crate) fn largest(path: &Path) -> u64 {
    match is_called_gltf(path) {
        true => MAX_GLTF_BYTES,
        false => MAX_FILE_BYTES,
    }
}

/// The scene in a file with these bytes. The files it is read from are the diagnostics' sources, without their text.
pub fn import(bytes: &[u8], path: &Path, access: Access) -> Document {
    let mut sources = vec![path.to_owned()];
    let mut known: HashSet<PathBuf> = sources.iter().cloned().collect();
    let folder = path.parent().unwrap_or(Path::new(""));
    let mut read = |name: &str| {
        let file = folder.join(name);
        if known.insert(file.clone()) {
            sources.push(file.clone());
        }
        Ok(access.read(&file, MAX_GLTF_BYTES)?)
    };
    let taken = Gltf::open(bytes, &mut read).and_then(|gltf| {
        let mut keep = |name: &str, bytes: &[u8]| CACHE.keep(name, bytes);
        take_apart(&gltf, &mut keep, &mut read)
    });
    CACHE.tidy();
    let mut access = access;
    allow_parts(|folder| access.allow(folder));
    Document {
        access,
        ..into_document(taken, path, &sources)
    }
}

/// The meshes of a glTF file, each with the transform world from local by its scene. Nothing is stored in the cache.
/// `limit`: the most bytes of the file, and of each file that it names. The error says why it cannot be read.
pub(crate) fn placed_meshes(
    path: &Path,
    access: &Access,
    limit: u64,
) -> Result<Vec<(Arc<MeshData>, Affine3A)>, String> {
    let folder = path.parent().unwrap_or(Path::new(""));
    let bytes = access.read(path, limit).map_err(|error| error.to_string())?;
    let mut read = |name: &str| Ok(access.read(&folder.join(name), limit)?);
    let opened = Gltf::open(&bytes, &mut read).and_then(|gltf| gltf.placed_meshes());
    opened.map_err(|error| error.to_string())
}

fn into_document(taken: Result<Imported, GltfError>, path: &Path, sources: &[PathBuf]) -> Document {
    let mut diagnostics = Diagnostics::default();
    diagnostics.sources.extend(sources.iter().map(|path| SourceFile {
        path: path.clone(),
        text: Default::default(),
        byte_order_mark: false,
    }));
    let (root, stand_in_light) = match taken {
        Ok(imported) => {
            for warning in imported.warnings {
                diagnostics.push(Severity::Warning, None, warning, None);
            }
            (imported.root, imported.stand_in)
        }
        Err(GltfError::Missing(missing)) => {
            let folder = path.parent().unwrap_or(Path::new(""));
            let buffers = missing.buffers.iter().map(|name| (Severity::Error, "buffer", name));
            let pictures = missing.images.iter().map(|name| (Severity::Warning, "picture", name));
            for (severity, kind, name) in buffers.chain(pictures) {
                let message = format!("{kind} {}: {NOT_THERE}", folder.join(name).display());
                diagnostics.push(severity, None, message, None);
            }
            (Object::new(Category::Scene, ""), None)
        }
        Err(error) => {
            diagnostics.push(Severity::Error, None, error.to_string(), None);
            (Object::new(Category::Scene, ""), None)
        }
    };
    Document {
        imported: true,
        stand_in_light,
        diagnostics,
        ..Document::new(path, root)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::fs;

    use crate::files::{self, FileError};

    #[test]
    fn models_may_be_larger_than_text() {
        let folder = tempfile::tempdir().expect("a temporary folder");
        for (name, limit) in [
            ("a.glb", MAX_GLTF_BYTES),
            ("a.GLTF", MAX_GLTF_BYTES),
            ("a.xml", MAX_FILE_BYTES),
        ] {
            let path = folder.path().join(name);
            let file = fs::File::create(&path).expect(name);
            // The file is sparse, so that it takes no space on the disk.
            file.set_len(limit).expect(name);
            files::check(&path, largest(&path)).expect(name);
            file.set_len(limit + 1).expect(name);
            let error = files::check(&path, largest(&path)).expect_err(name);
            assert!(matches!(error, FileError::TooLarge { .. }), "{name}");
        }
    }
}
