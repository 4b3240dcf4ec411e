//! Parts of a picture with their exact sums: shares that are merged, and checkpoints that are resumed.
//!
//! A part is an EXR file. Any program shows the picture in it, which is the picture rendered so far. The state follows
//! after the picture, where readers of EXR do not look: a header in JSON, the sums of each tile bit by bit, and the
//! state of the engine's job. A checkpoint is a part that is not finished.

mod cover;
mod file;
mod origin;
mod state;

use serde::{Deserialize, Serialize};

pub use self::cover::{CoverError, Fault, check_cover, fault};
pub use self::file::{PartError, PartFile, write_part};
pub use self::origin::{FileDigest, Origin};
pub(crate) use self::state::{FORMAT, StateWriter, open_state, write_state};

use super::layers::FilmLayers;
use super::tile::{TILE, Tile, tiles};
use crate::layer::{Layer, Layers};

/// A rectangle of whole tiles of the picture, in pixels.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Crop {
    /// The first column.
    pub x: u32,
    /// The first row.
    pub y: u32,
    /// The number of columns, above 0.
    pub width: u32,
    /// The number of rows, above 0.
    pub height: u32,
}

impl Crop {
    /// The whole picture.
    pub fn whole(width: u32, height: u32) -> Self {
        Self {
            x: 0,
            y: 0,
            width,
            height,
        }
    }

    /// An error in words if it is not inside a picture of this size, or cuts tiles.
    pub fn check(self, width: u32, height: u32) -> Result<(), String> {
        let axes = [("X", self.x, self.width, width), ("Y", self.y, self.height, height)];
        for (axis, start, length, all) in axes {
            let end = start.saturating_add(length);
            if length == 0 || end > all {
                return Err(format!(
                    "the crop does not lie in the picture, which has {width} x {height} pixels"
                ));
            }
            let cut = [start, end].into_iter().find(|edge| edge % TILE != 0 && *edge != all);
            if let Some(cut) = cut {
                let (before, after) = (cut / TILE * TILE, cut.next_multiple_of(TILE).min(all));
                return Err(format!(
                    "a crop begins and ends at multiples of {TILE} pixels or at the edge of the picture, and not at {axis} = {cut}: {before} and {after} \
                     are the nearest"
                ));
            }
        }
        Ok(())
    }

    /// Whether it contains the tile.
    pub fn has(self, tile: Tile) -> bool {
        (self.x..self.x + self.width).contains(&tile.x) && (self.y..self.y + self.height).contains(&tile.y)
    }

    /// Its tiles, in a picture of this size.
    pub fn tiles(self, width: u32, height: u32) -> impl Iterator<Item = Tile> {
        tiles(width, height).into_iter().filter(move |&tile| self.has(tile))
    }
}

/// The header of a part.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct PartHeader {
    /// The scene, settings and version on which the samples depend.
    pub origin: Origin,
    /// The width of the whole picture in pixels.
    pub width: u32,
    /// The height of the whole picture in pixels.
    pub height: u32,
    /// The pixels of the part.
    pub crop: Crop,
    /// The first sample of each pixel, and the end of the samples asked for.
    pub samples: [u32; 2],
    /// The number of samples of each pixel in the whole picture; None if unknown.
    #[serde(default)]
    pub samples_of_whole: Option<u32>,
    /// Whether the part has all of these samples.
    pub is_finished: bool,
    /// The names of the layers.
    pub layers: Vec<String>,
    /// Whether pixels receive splats of paths from lights.
    pub splats: bool,
    /// The metadata of the picture.
    pub about: About,
}

/// The metadata with which the picture of a part is written without its scene.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct About {
    /// The string attributes of the picture.
    pub texts: Vec<(String, String)>,
    /// The seed, as in the picture's attribute.
    pub seed: u32,
    /// The names of the shapes by instance, if a layer needs them.
    pub objects: Vec<String>,
    /// The names of the materials, if a layer needs them.
    pub materials: Vec<String>,
    /// The names of the light groups.
    pub light_groups: Vec<String>,
    /// The bits of the camera axes in world space, for layers in camera space.
    pub camera_axes: [u32; 9],
    /// The bits of the attributes `worldToCamera` and `worldToNDC`, see
    /// [`crate::render::layered_image::Attribute::Matrix`].
    pub matrices: [[u32; 16]; 2],
    /// The film's `pixel_format`, `component_format` and `compression`.
    pub storage: [Option<String>; 3],
}

impl PartHeader {
    /// The layers of the film.
    pub fn film_layers(&self) -> FilmLayers {
        let known = self.layers.iter().filter_map(|name| Layer::of_name(name));
        FilmLayers {
            groups: self.about.light_groups.len(),
            layers: Layers::of(&known.collect::<Vec<_>>()),
            splats: self.splats,
        }
    }
}
