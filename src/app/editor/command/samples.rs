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
pub const SAMPLES: [Sample; 6] = [
    sample!("flat", "A furnished flat"),
    sample!("cornell-box", "The Cornell box"),
    sample!("materials", "Materials"),
    sample!("hundred-spheres", "A hundred spheres"),
    sample!("knot", "A knot of 115,200 triangles"),
    sample!("pool", "A pool in the sun"),
];

impl Sample {
    /// The path of the scene: in the folder `scenes` below the working directory, or else below a folder above the
    /// program, as in a build folder or a release. None where there is no such file.
    pub fn path(&self) -> Option<PathBuf> {
        let file = Path::new("scenes").join(self.file);
        places_of(&file).find(|path| path.is_file())
    }
}

/// Whether a scene lies in the folder of the samples.
pub(crate) fn is_sample(scene: &Path) -> bool {
    let is_there = |folder: &Path| SAMPLES.iter().all(|sample| folder.join(sample.file).is_file());
    scene.parent().is_some_and(is_there)
}

/// A folder shipped with the program, such as `assets/environments`, searched like the scenes of [`Sample::path`].
pub(crate) fn program_folder(name: &str) -> Option<PathBuf> {
    places_of(Path::new(name)).find(|path| path.is_dir())
}

/// The existing folders shipped with the program, with their names.
pub(crate) fn program_folders() -> impl Iterator<Item = (&'static str, PathBuf)> {
    let known = [
        ("Environments", "assets/environments"),
        ("Models", "assets/models"),
        ("Sample scenes", "scenes"),
    ];
    known
        .into_iter()
        .filter_map(|(name, folder)| Some((name, program_folder(folder)?)))
}

/// The places where a file or a folder of the program may be.
fn places_of(name: &Path) -> impl Iterator<Item = PathBuf> {
    let program = std::env::current_exe().unwrap_or_default();
    let here = std::env::current_dir().unwrap_or_default();
    let beside: Vec<PathBuf> = program.ancestors().skip(1).take(4).map(Path::to_owned).collect();
    std::iter::once(here).chain(beside).map(move |folder| folder.join(name))
}
