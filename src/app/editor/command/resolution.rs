//! The settings of the number of rendered pixels, and of the enlarging of a picture with few pixels.

use std::path::PathBuf;

use serde::{Deserialize, Serialize};

declare_names! {
    /// The pixels that are traced while the user works. None of these changes the file's film.
    #[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
    #[serde(rename_all = "kebab-case")]
    pub enum Resolution {
        /// The picture has as many pixels as the window shows, and no more than the film has.
        #[default]
        View = "view" => "as shown",
        /// The picture has as many pixels as the window shows, and those of the film once nothing has changed for some
        /// seconds.
        AfterRest = "after-rest" => "as shown, then full",
        /// The picture has the pixels of the film.
        Full = "full" => "full film",
    }
}

declare_names! {
    /// The look of a picture that has fewer pixels than its place in the window.
    #[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
    #[serde(rename_all = "kebab-case")]
    pub enum Enlarging {
        /// Colours between the pixels are interpolated.
        #[default]
        Smooth = "smooth" => "smooth",
        /// Each pixel is a square of one colour.
        Sharp = "sharp" => "sharp",
    }
}

/// A request to trace the whole film once.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct FullFilm {
    /// The file for the picture, which is saved when it has the samples that it had before.
    pub save_to: Option<PathBuf>,
    /// Whether the user has confirmed its need of memory.
    pub is_confirmed: bool,
}
