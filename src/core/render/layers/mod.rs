//! Computation of the layers of a picture ([`Layer`]).
//!
//! The values of the layers chosen in [`View::layers`](super::view::View::layers) are recorded along the paths
//! (`notes`), summed up by pixel (`sums`), stored in the film, and computed from its sums at the end (`read`). Other
//! layers cost nothing, and the picture has the same bits either way.

mod cryptomatte;
mod image;
mod notes;
mod read;
mod sums;

pub use self::cryptomatte::{Matte, MatteEntry};
pub use self::image::{LayerNames, layered_image, picture_of_camera};
pub use self::read::LayerPixels;
pub use self::sums::{FilmLayers, LayerSums};

pub use crate::layer::{Layer, Layers};

pub(super) use self::notes::{LayerNotes, NoteTaker};
pub(super) use self::sums::PixelLayers;
