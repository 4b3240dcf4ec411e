//! The settings of how many pixels of the film are traced, and how a picture of few pixels is enlarged.

use std::path::PathBuf;

use serde::{Deserialize, Serialize};

/// The pixels that are traced while the user works. None of these changes the file's film.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Resolution {
    /// The picture has as many pixels as the window shows, and no more than the film has.
    #[default]
    View,
    /// The picture has as many pixels as the window shows, and those of the film once nothing has changed for some
    /// seconds.
    AfterRest,
    /// The picture has the pixels of the film.
    Full,
}

impl Resolution {
    /// The choices with their names in scripts and in panels.
    pub const ALL: [(Self, &'static str, &'static str); 3] = [
        (Self::View, "view", "as shown"),
        (Self::AfterRest, "after-rest", "as shown, then full"),
        (Self::Full, "full", "full film"),
    ];
}

/// The look of a picture that has fewer pixels than its place in the window.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Enlarging {
    /// Colours between the pixels are interpolated.
    #[default]
    Smooth,
    /// Each pixel is a square of one colour.
    Sharp,
}

impl Enlarging {
    /// The choices with their names in scripts and in panels.
    pub const ALL: [(Self, &'static str); 2] = [(Self::Smooth, "smooth"), (Self::Sharp, "sharp")];
}

/// A request to trace the whole film once.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct FullFilm {
    /// The file to which the picture is saved when it has the samples that the picture had before.
    pub save_to: Option<PathBuf>,
    /// Whether the user knows how much memory it takes.
    pub is_confirmed: bool,
}
