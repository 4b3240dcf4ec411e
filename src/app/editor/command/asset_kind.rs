//! The kinds of files that a scene can use, by their extensions, and the use of one.

use std::path::{Path, PathBuf};

use bevy::math::{Vec2, Vec3};

/// A kind of file.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum AssetKind {
    /// A picture for a texture.
    Picture,
    /// A picture with radiance, usually an environment light.
    Environment,
    /// Triangles: OBJ, PLY, serialized or glTF.
    Mesh,
    /// A grid of voxels, for smoke and clouds.
    Volume,
    /// The intensities of a lamp: IES or EULUMDAT.
    Lamp,
    /// A scene or materials in XML.
    Scene,
}

impl AssetKind {
    /// The kinds in the order in which they are offered, with their names.
    pub const ALL: [(Self, &str); 6] = [
        (Self::Picture, "Pictures"),
        (Self::Environment, "Environments"),
        (Self::Mesh, "Meshes"),
        (Self::Volume, "Volumes"),
        (Self::Lamp, "Lamps"),
        (Self::Scene, "Scenes and materials"),
    ];

    /// The kind of a file of this name; None for files that the program does not read.
    pub fn of(path: &Path) -> Option<Self> {
        let extension = path.extension()?.to_str()?.to_ascii_lowercase();
        match extension.as_str() {
            "png" | "jpg" | "jpeg" | "bmp" | "tga" | "ppm" | "pgm" | "pfm" => Some(Self::Picture),
            "hdr" | "exr" => Some(Self::Environment),
            "obj" | "ply" | "serialized" | "gltf" | "glb" => Some(Self::Mesh),
            "vol" | "vdb" => Some(Self::Volume),
            "ies" | "ldt" => Some(Self::Lamp),
            "xml" => Some(Self::Scene),
            _ => None,
        }
    }
}

/// A file that is put into the scene: a picture onto a shape or all around, a mesh onto a surface, a material onto a
/// shape.
#[derive(Clone, Debug, PartialEq)]
pub struct FileUse {
    /// The absolute path.
    pub path: PathBuf,
    /// The place in the picture where it was dropped, (0, 0) top left, (1, 1) bottom right. None: it applies to the
    /// selection.
    pub at: Option<Vec2>,
    /// The least and the greatest coordinates of a mesh, if they are known: then its lower side is put onto the
    /// surface.
    pub bounds: Option<[Vec3; 2]>,
}
