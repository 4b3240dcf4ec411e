//! Bounds on what is made of a file. By naming one thing again and again, a small file could ask for far more than its
//! size: for thousands of meshes of the same vertices, curves of the same numbers, and pictures of the same picture.

use std::collections::HashSet;

use super::picture::PictureFile;
use super::zeros::MOST_ZEROS;
use super::{Gltf, GltfError};
use crate::geometry::mesh::MeshData;

/// The most instances of all nodes together. One of a mesh with several primitives counts for each of them, for each
/// becomes a shape.
pub(super) const MOST_INSTANCES: usize = 1 << 16;

/// The most places of primitives that stand elsewhere as well. In a file of 200 kB, thousands of nodes may each place
/// thousands of primitives.
pub(super) const MOST_REPEATS: usize = 1 << 20;

/// The most vectors of the targets of a file that are added. Each target is named in a few bytes, and may have any
/// number of vectors.
pub(super) const MOST_MOVES: usize = 1 << 28;

/// The bytes of meshes for each byte of the buffers. Where primitives share nothing, a byte becomes at most twenty.
const MESH_BYTES: u64 = 32;
/// The bytes of meshes beside these, for small files whose primitives share their vertices.
const MORE_MESH_BYTES: u64 = 64 << 20;
/// The bytes of a vertex and of a triangle in the file of a mesh, about.
const VERTEX_BYTES: u64 = 32;
const TRIANGLE_BYTES: u64 = 12;

/// The bytes of numbers of curves for each byte of the buffers: a number becomes four bytes, and has one at least.
const CURVE_BYTES: u64 = 4;
/// The bytes of numbers of curves beside these.
const MORE_CURVE_BYTES: u64 = 16 << 20;

/// The most pixels of all pictures that are made of images of which one was made before.
const MOST_PIXELS: u64 = 1 << 31;

impl Gltf {
    /// The bytes of the buffers, and the zeros that stand in no buffer.
    fn sizes(&self) -> [u64; 2] {
        let bytes = self.buffers.iter().map(|buffer| buffer.len() as u64).sum();
        [bytes, self.zeros.min(MOST_ZEROS) as u64]
    }

    /// The bytes that the numbers of curves may have.
    pub(super) fn curve_allowance(&self) -> u64 {
        let [bytes, zeros] = self.sizes();
        CURVE_BYTES * bytes + 16 * zeros + MORE_CURVE_BYTES
    }

    /// What identifies the file of an image.
    fn source_of(&self, image: usize) -> Source<'_> {
        let image = self.root.images.get(image);
        let view = |image: &super::schema::Image| self.root.buffer_views.get(image.buffer_view?);
        match image.map(|image| (&image.uri, view(image))) {
            Some((Some(uri), _)) => Source::Uri(uri),
            Some((None, Some(view))) => Source::Bytes(view.buffer, view.byte_offset),
            _ => Source::Nothing,
        }
    }
}

/// The meshes that may still be made of a file.
pub(super) struct MeshAllowance(u64);

impl MeshAllowance {
    /// What a file may have before any of its meshes is made.
    pub fn of(gltf: &Gltf) -> Self {
        let [bytes, zeros] = gltf.sizes();
        Self(MESH_BYTES * bytes + (VERTEX_BYTES + TRIANGLE_BYTES) * zeros + MORE_MESH_BYTES)
    }

    /// Whether no mesh may be made any more.
    pub fn is_spent(&self) -> bool {
        self.0 == 0
    }

    /// Counts a mesh.
    pub fn spend(&mut self, mesh: &MeshData) {
        let bytes = VERTEX_BYTES * mesh.positions.len() as u64 + TRIANGLE_BYTES * mesh.triangles.len() as u64;
        self.0 = self.0.saturating_sub(bytes);
    }
}

/// How often primitives may still be placed that stand elsewhere as well.
pub(super) struct RepeatAllowance {
    placed: HashSet<u32>,
    left: usize,
}

impl Default for RepeatAllowance {
    fn default() -> Self {
        Self {
            placed: HashSet::new(),
            left: MOST_REPEATS,
        }
    }
}

impl RepeatAllowance {
    /// Counts places of a primitive. Returns how many of them there may be.
    pub fn spend(&mut self, primitive: u32, places: usize) -> usize {
        let first = usize::from(places > 0 && self.placed.insert(primitive));
        let again = (places - first).min(self.left);
        self.left -= again;
        first + again
    }
}

/// The file that an image is read from.
#[derive(PartialEq, Eq, Hash)]
enum Source<'a> {
    Uri(&'a str),
    /// In a buffer, from a byte on.
    Bytes(usize, usize),
    Nothing,
}

/// The pictures that may still be made of a file.
pub(super) struct PictureAllowance<'a> {
    made: HashSet<Source<'a>>,
    pixels_left: u64,
}

impl Default for PictureAllowance<'_> {
    fn default() -> Self {
        Self {
            made: HashSet::new(),
            pixels_left: MOST_PIXELS,
        }
    }
}

impl<'a> PictureAllowance<'a> {
    /// Makes a picture of an image, and counts it. An error if too many were made of images that had been used before.
    pub fn spend(
        &mut self,
        gltf: &'a Gltf,
        image: usize,
        make: impl FnOnce() -> Result<PictureFile, GltfError>,
    ) -> Result<PictureFile, GltfError> {
        let is_new = self.made.insert(gltf.source_of(image));
        if !is_new && self.pixels_left == 0 {
            return Err(GltfError::Image {
                index: image,
                what: "too many pictures are made of the same images".to_owned(),
            });
        }
        let made = make()?;
        if !is_new {
            let cost = made.pixels.max(made.bytes.len() as u64);
            self.pixels_left = self.pixels_left.saturating_sub(cost);
        }
        Ok(made)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_first_place_of_a_primitive_is_free() {
        let mut repeats = RepeatAllowance {
            left: 3,
            ..RepeatAllowance::default()
        };
        let places = [(0, 0), (0, 1), (1, 2), (0, 1), (0, 5), (1, 1), (2, 2)];
        let placed = places.map(|(primitive, places)| repeats.spend(primitive, places));
        assert_eq!(placed, [0, 1, 2, 1, 1, 0, 1]);
    }

    #[test]
    fn the_first_picture_of_an_image_is_free() {
        let text =
            br#"{"asset": {"version": "2.0"}, "images": [{"uri": "a.png"}, {"uri": "b.png"}, {"uri": "a.png"}]}"#;
        let gltf = Gltf::open(text, &mut |_| Err(std::io::ErrorKind::NotFound.into())).expect("opens");
        let mut allowance = PictureAllowance {
            pixels_left: 100,
            ..PictureAllowance::default()
        };
        let mut makings = 0;
        // The last image is the file of the first.
        for (image, left) in [
            (0, Some(100)),
            (0, Some(36)),
            (2, Some(0)),
            (0, None),
            (2, None),
            (1, Some(0)),
            (1, None),
        ] {
            let made = allowance.spend(&gltf, image, || {
                makings += 1;
                Ok(PictureFile {
                    bytes: Vec::new(),
                    extension: "png",
                    is_as_written: true,
                    pixels: 64,
                })
            });
            assert_eq!(made.is_ok(), left.is_some(), "{image}");
            assert_eq!(allowance.pixels_left, left.unwrap_or(0));
        }
        assert_eq!(makings, 4);
    }
}
