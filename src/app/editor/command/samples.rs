//! The sample scenes that come with the program, with a picture of each for the start page.

use std::path::{Path, PathBuf};

/// A sample scene.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sample {
    /// The name of its file in the folder `scenes`.
    pub file: &'static str,
    /// Its title.
    pub title: &'static str,
    /// The bytes of its picture, a JPEG file of 240 x 150 pixels.
    pub picture: &'static [u8],
}

macro_rules! sample {
    ($name:literal, $title:literal) => {
        Sample {
            file: concat!($name, ".xml"),
            title: $title,
            picture: include_bytes!(concat!("../../../../assets/start/", $name, ".jpg")),
        }
    };
}

/// The samples, in the order of the start page.
pub const SAMPLES: [Sample; 5] = [
    sample!("flat", "A furnished flat"),
    sample!("cornell-box", "The Cornell box"),
    sample!("materials", "Materials"),
    sample!("hundred-spheres", "A hundred spheres"),
    sample!("knot", "A knot of 115,200 triangles"),
];

impl Sample {
    /// The path of the scene: in the folder `scenes` below the working directory, or else below a folder above the program, as in a build folder or
    /// a release. None where there is no such file.
    pub fn path(&self) -> Option<PathBuf> {
        let program = std::env::current_exe().ok();
        let beside = program.iter().flat_map(|program| program.ancestors().skip(1).take(4));
        let here = std::env::current_dir().unwrap_or_default();
        std::iter::once(here.as_path())
            .chain(beside)
            .map(|folder| folder.join("scenes").join(Path::new(self.file)))
            .find(|path| path.is_file())
    }
}
