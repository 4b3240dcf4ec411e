//! Limits on the output made of a file. By naming one element again and again, a small file could ask for far more than
//! its size: for thousands of meshes of the same vertices, curves of the same numbers, and copies of the same picture.

use std::collections::HashSet;

use super::picture::PictureFile;
use super::zeros::MOST_ZEROS;
use super::{Gltf, GltfError};
use crate::geometry::mesh::MeshData;

/// The most instances of all nodes together. An instance of a mesh with several primitives counts for each of them,
/// since each becomes a shape.
pub(super) const MOST_INSTANCES: usize = 1 << 16;

/// The most repeated placements of primitives. In a file of 200 kB, thousands of nodes may each place thousands of
/// primitives.
pub(super) const MOST_REPEATS: usize = 1 << 20;

/// The most vectors of morph targets that are added in a file. Each target is named in a few bytes, and may have any
/// number of vectors.
pub(super) const MOST_MOVES: usize = 1 << 28;

/// The most bytes of meshes for each byte of the buffers. If primitives share nothing, a byte becomes at most twenty.
const MESH_BYTES: u64 = 32;
/// More bytes of meshes, for small files whose primitives share their vertices.
const MORE_MESH_BYTES: u64 = 64 << 20;
/// The approximate bytes of a vertex and of a triangle in the file of a mesh.
const VERTEX_BYTES: u64 = 32;
const TRIANGLE_BYTES: u64 = 12;

/// The most bytes of curve values for each byte of the buffers: a number becomes four bytes, and has one at least.
const CURVE_BYTES: u64 = 4;
/// More bytes of curve values.
const MORE_CURVE_BYTES: u64 = 16 << 20;

/// The most pixels of all pictures that are made of an image that was used before.
const MOST_PIXELS: u64 = 1 << 31;

impl Gltf {
    /// The bytes of the buffers, and the number of zeros that are in no buffer.
    fn sizes(&self) -> [u64; 2] {
        let bytes = self.buffers.iter().map(|buffer| buffer.len() as u64).sum();
        [bytes, self.zeros.min(MOST_ZEROS) as u64]
    }

    /// The most bytes that the values of curves may have.
    pub(super) fn curve_allowance(&self) -> u64 {
        let [bytes, zeros] = self.sizes();
        CURVE_BYTES * bytes + 16 * zeros + MORE_CURVE_BYTES
    }

    /// The source of an image, which identifies its file.
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

/// The bytes of meshes that may still be made of a file, and the vectors of morph targets that may be added to them.
pub(super) struct MeshAllowance {
    bytes: u64,
    moves: usize,
}

impl MeshAllowance {
    /// The allowance of a file before any mesh is made.
    pub fn of(gltf: &Gltf) -> Self {
        let [bytes, zeros] = gltf.sizes();
        Self {
            bytes: MESH_BYTES * bytes + (VERTEX_BYTES + TRIANGLE_BYTES) * zeros + MORE_MESH_BYTES,
            moves: MOST_MOVES,
        }
    }

    /// Whether no more meshes may be made.
    pub fn is_spent(&self) -> bool {
        self.bytes == 0
    }

    /// Whether some morph targets may still be added.
    pub fn has_moves(&self) -> bool {
        self.moves > 0
    }

    /// Subtracts the morph targets of a mesh, which may be read again at each node with a shape of its own. False if
    /// too few are left for them.
    pub fn spend_moves(&mut self, moves: usize) -> bool {
        let left = self.moves.checked_sub(moves);
        self.moves = left.unwrap_or(0);
        left.is_some()
    }

    /// Subtracts a mesh.
    pub fn spend(&mut self, mesh: &MeshData) {
        let bytes = VERTEX_BYTES * mesh.positions.len() as u64 + TRIANGLE_BYTES * mesh.triangles.len() as u64;
        self.bytes = self.bytes.saturating_sub(bytes);
    }
}

/// The number of repeated placements of primitives that are left.
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
    /// Counts placements of a primitive. Returns how many of them are allowed.
    pub fn spend(&mut self, primitive: u32, places: usize) -> usize {
        let first = usize::from(places > 0 && self.placed.insert(primitive));
        let again = (places - first).min(self.left);
        self.left -= again;
        first + again
    }
}

/// The source of an image's file.
#[derive(PartialEq, Eq, Hash)]
enum Source<'a> {
    Uri(&'a str),
    /// In this buffer, from this byte on.
    Bytes(usize, usize),
    Nothing,
}

/// The pixels of pictures that may still be made of a file.
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
    /// Makes a picture of one or two images, and counts it unless both are new. An error if images used before have
    /// given too many pixels.
    pub fn spend(
        &mut self,
        gltf: &'a Gltf,
        (image, second): (usize, Option<usize>),
        make: impl FnOnce() -> Result<PictureFile, GltfError>,
    ) -> Result<PictureFile, GltfError> {
        let first = gltf.source_of(image);
        // The picture has the size of the larger image, which may be the second one.
        let second = second.map(|second| gltf.source_of(second));
        let is_second_new = match second.filter(|second| *second != first) {
            Some(second) => self.made.insert(second),
            None => true,
        };
        let is_new = self.made.insert(first) && is_second_new;
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
    fn morph_targets_are_bounded_in_sum() {
        let mut allowance = MeshAllowance { bytes: 1, moves: 5 };
        assert_eq!(
            [3, 2, 0, 1].map(|moves| allowance.spend_moves(moves)),
            [true, true, true, false]
        );
        assert!(!allowance.is_spent());
    }

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
        let text = br#"{"asset": {"version": "2.0"}, "images": [{"uri": "a.png"}, {"uri": "b.png"}, {"uri": "a.png"},
                {"uri": "c.png"}, {"uri": "d.png"}]}"#;
        let gltf = Gltf::open(text, &mut |_| Err(std::io::ErrorKind::NotFound.into())).expect("opens");
        let mut allowance = PictureAllowance {
            pixels_left: 100,
            ..PictureAllowance::default()
        };
        let mut makings = 0;
        // The last image is the file of the first.
        for (images, left) in [
            ((0, None), Some(100)),
            ((0, None), Some(36)),
            ((2, None), Some(0)),
            ((0, None), None),
            ((2, None), None),
            // Each of these has one new image.
            ((3, Some(0)), None),
            ((0, Some(4)), None),
            ((1, Some(1)), Some(0)),
            ((1, None), None),
        ] {
            let made = allowance.spend(&gltf, images, || {
                makings += 1;
                Ok(PictureFile {
                    bytes: Vec::new(),
                    extension: "png",
                    is_as_written: true,
                    pixels: 64,
                })
            });
            assert_eq!(made.is_ok(), left.is_some(), "{images:?}");
            assert_eq!(allowance.pixels_left, left.unwrap_or(0));
        }
        assert_eq!(makings, 4);
    }
}
