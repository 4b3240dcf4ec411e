//! The monkey's folder: copies of the scenes, files to import, and the editor's settings. No other files are written.

use std::path::{Path, PathBuf};

use bevy::math::{UVec3, Vec3};
use tempfile::TempDir;

use super::edits::PART;
use super::random::Random;
use crate::files::{LARGEST_NOTE, read_text, write_atomically};
use crate::math::Aabb;
use crate::medium::{VolumeGrid, Voxels, write_vol};

/// A temporary folder that is removed with this value.
pub struct Folder {
    temporary: TempDir,
    copies: Vec<SceneCopy>,
}

/// A scene that the monkey edits in place of the user's.
pub struct SceneCopy {
    pub path: PathBuf,
    /// The text of the scene when it was first written.
    text: String,
}

/// The procedure by which a program writes a file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Writing {
    /// The file is emptied and written.
    InPlace,
    /// The file is emptied, half of the content is written, and then all of it.
    Halting,
    /// A new file replaces it by renaming.
    ByRename,
}

impl Writing {
    pub const ALL: [Self; 3] = [Self::InPlace, Self::Halting, Self::ByRename];

    pub fn write(self, path: &Path, content: &[u8]) -> std::io::Result<()> {
        match self {
            Self::InPlace => std::fs::write(path, content),
            Self::Halting => {
                std::fs::write(path, &content[..content.len() / 2])?;
                std::fs::write(path, content)
            }
            Self::ByRename => write_atomically(path, content),
        }
    }
}

/// The files of the folder `imports`.
const IMPORTS: [&str; 6] = [
    "part.xml",
    "hills.obj",
    "hills.ply",
    "sky.pfm",
    "tetrahedron.gltf",
    "smoke.vol",
];
const PICTURE: &str = "picture.ppm";

impl Folder {
    pub fn new(random: &mut Random) -> std::io::Result<Self> {
        let temporary = tempfile::Builder::new().prefix("sunroom-monkey-").tempdir()?;
        let folder = Self {
            temporary,
            copies: Vec::new(),
        };
        std::fs::create_dir(folder.path().join("imports"))?;
        for name in IMPORTS.into_iter().chain([PICTURE]) {
            std::fs::write(folder.import(name), content(name, random))?;
        }
        Ok(folder)
    }

    pub fn path(&self) -> &Path {
        self.temporary.path()
    }

    fn import(&self, name: &str) -> PathBuf {
        self.path().join("imports").join(name)
    }

    /// The path of a scene file with a few things.
    pub fn part(&self) -> PathBuf {
        self.import(IMPORTS[0])
    }

    pub fn any_import(&self, random: &mut Random) -> PathBuf {
        self.import(IMPORTS[random.below(IMPORTS.len())])
    }

    pub fn picture(&self) -> PathBuf {
        self.import(PICTURE)
    }

    /// The path of a mesh or a picture, and new content for it, which is sometimes truncated.
    pub fn changed_import(&self, random: &mut Random) -> (PathBuf, Vec<u8>) {
        let name = ["hills.obj", "hills.ply", "sky.pfm", "smoke.vol", PICTURE][random.below(5)];
        let mut content = content(name, random);
        if random.below(3) == 0 {
            content.truncate(random.below(content.len()));
        }
        (self.import(name), content)
    }

    /// The path at which the picture of the window's viewport is saved.
    pub fn image(&self, random: &mut Random) -> PathBuf {
        self.path()
            .join(["picture.png", "picture.exr", "picture.hdr"][random.below(3)])
    }

    /// The path at which edited scenes are saved to be opened again.
    pub fn saved(&self) -> PathBuf {
        self.path().join("saved.xml")
    }

    /// The path for the copy of a scene.
    pub fn place_for_copy(&self, number: usize) -> PathBuf {
        self.path().join(format!("scene-{number}.xml"))
    }

    /// Adds a copy, with the scene that is in its file.
    pub fn add_copy(&mut self, path: PathBuf) -> std::io::Result<()> {
        let text = read_text(&path, LARGEST_NOTE)?;
        self.copies.push(SceneCopy { path, text });
        Ok(())
    }

    pub fn copies(&self) -> &[SceneCopy] {
        &self.copies
    }

    /// Keeps the folder after the end, to debug a failure.
    pub fn keep(&mut self) -> PathBuf {
        self.temporary.disable_cleanup(true);
        self.path().to_owned()
    }
}

impl SceneCopy {
    /// Writes the original text.
    pub fn restore(&self) -> std::io::Result<()> {
        write_atomically(&self.path, &self.text)
    }
}

fn content(name: &str, random: &mut Random) -> Vec<u8> {
    match name {
        "part.xml" => PART.into(),
        "hills.obj" => hills(random, Mesh::Obj).into(),
        "hills.ply" => hills(random, Mesh::Ply).into(),
        "tetrahedron.gltf" => TETRAHEDRON.into(),
        "smoke.vol" => smoke(random),
        "sky.pfm" => {
            // Little-endian floats (Debevec's Portable FloatMap).
            let mut bytes = b"PF\n16 8\n-1.0\n".to_vec();
            bytes.extend((0..16 * 8 * 3).flat_map(|_| random.fraction().to_le_bytes()));
            bytes
        }
        _ => {
            let edge = 8 << random.below(5);
            let mut bytes = format!("P6\n{edge} {edge}\n255\n").into_bytes();
            bytes.extend((0..edge * edge * 3).map(|_| random.below(256) as u8));
            bytes
        }
    }
}

/// A few voxels.
fn smoke(random: &mut Random) -> Vec<u8> {
    let size = UVec3::from_array([(); 3].map(|()| 1 + random.below(12) as u32));
    let voxels = (0..size.element_product()).map(|_| random.below(256) as u8);
    let unit = Aabb {
        min: Vec3::ZERO,
        max: Vec3::ONE,
    };
    VolumeGrid::new(size, 1, Voxels::U8(voxels.collect())).map_or(Vec::new(), |grid| write_vol(&grid, &unit))
}

enum Mesh {
    Obj,
    Ply,
}

/// A square with hills, of up to some thousand triangles: small ones are built at once and large ones in the
/// background.
fn hills(random: &mut Random, format: Mesh) -> String {
    let edge = 2 + random.below(50);
    let places = (0..edge * edge).map(|place| (place % edge, place / edge));
    let points = places.map(|(x, z)| {
        let [x, z] = [x, z].map(|at| 2.0 * at as f32 / (edge - 1) as f32 - 1.0);
        format!("{x} {} {z}", 0.2 * random.fraction())
    });
    let points: Vec<String> = points.collect();
    let corners = (0..(edge - 1) * edge).filter(|corner| corner % edge < edge - 1);
    let triangles = corners.flat_map(|a| [[a, a + edge, a + 1], [a + 1, a + edge, a + edge + 1]]);
    let triangles: Vec<[usize; 3]> = triangles.collect();
    match format {
        Mesh::Obj => {
            let points = points.iter().map(|point| format!("v {point}\n"));
            let faces = triangles
                .iter()
                .map(|[a, b, c]| format!("f {} {} {}\n", a + 1, b + 1, c + 1));
            points.chain(faces).collect()
        }
        Mesh::Ply => {
            let head = format!(
                "ply\nformat ascii 1.0\nelement vertex {}\nproperty float x\nproperty float y\nproperty float z\n\
                 element face {}\nproperty list uchar int vertex_indices\nend_header\n",
                points.len(),
                triangles.len()
            );
            let points = points.iter().map(|point| format!("{point}\n"));
            let faces = triangles.iter().map(|[a, b, c]| format!("3 {a} {b} {c}\n"));
            std::iter::once(head).chain(points).chain(faces).collect()
        }
    }
}

/// Four points and four triangles; the buffer has the positions and then the indices as unsigned bytes.
const TETRAHEDRON: &str = r#"{"asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}],
"nodes": [{"mesh": 0, "name": "tetrahedron"}],
"meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1}]}],
"accessors": [
  {"bufferView": 0, "componentType": 5126, "count": 4, "type": "VEC3", "min": [0, 0, 0], "max": [1, 1, 1]},
  {"bufferView": 1, "componentType": 5121, "count": 12, "type": "SCALAR"}],
"bufferViews": [{"buffer": 0, "byteOffset": 0, "byteLength": 48}, {"buffer": 0, "byteOffset": 48, "byteLength": 12}],
"buffers": [{"byteLength": 60, "uri": "data:application/octet-stream;base64,AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAAAAAAAAAAAAAAAIA/AAIBAAEDAAMCAQID"}]}"#;
