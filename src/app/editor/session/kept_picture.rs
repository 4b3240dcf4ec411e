//! The picture that is kept beside its scene to be resumed later: its file, its view, and whether there is a picture
//! worth keeping.

use std::path::{Path, PathBuf};

use bevy::prelude::*;
use serde::{Deserialize, Serialize};

use crate::app::editor::command::stored_view::StoredView;
use crate::document::animation::MOST_TIME;
use crate::render::part::PartFile;

/// The seconds of rendering from which on the user is asked before a picture is lost.
const WORTH_A_QUESTION: f64 = 60.0;

/// The file in which the picture of a scene is kept.
pub fn kept_file(scene: &Path) -> PathBuf {
    let mut name = scene.file_name().unwrap_or_default().to_owned();
    name.push(".unfinished.exr");
    scene.with_file_name(name)
}

/// The state of the window that a picture depends on besides the scene.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Shown {
    /// The index of the camera in use, in the order of the file.
    pub camera: usize,
    /// The view; None for that of the camera.
    pub view: Option<StoredView>,
    /// The time of the scene in seconds.
    pub time: f64,
    /// The samples per pixel to stop at; None for those of the film.
    pub samples: Option<u32>,
    /// The seconds of rendering to stop at.
    pub seconds: Option<f32>,
    /// The noise to stop at; None for that of the film.
    pub noise: Option<f32>,
    /// Whether sampling is adaptive; None if the film says so.
    pub adaptive: Option<bool>,
    /// The corners of the rendered region, see [`RenderControl::region`](crate::engine::RenderControl::region).
    pub region: Option<[[f32; 2]; 2]>,
    /// The width and height of the picture in widths and heights of the film.
    #[serde(default = "film_alone")]
    pub extent: [f32; 2],
    /// Whether the film has a layer for each light.
    pub keeps_lights_apart: bool,
    /// Whether lights can be edited without a restart, see
    /// [`RenderControl::lights_are_free`](crate::engine::RenderControl::lights_are_free).
    #[serde(default)]
    pub lights_are_free: bool,
}

fn film_alone() -> [f32; 2] {
    [1.0; 2]
}

/// The largest distance of a region's edge from the film, in widths or heights of the film.
const MOST_FILMS: f32 = 1e3;

impl Shown {
    /// Reads the text of a kept picture. Drops impossible values: the file may come from others.
    pub fn read(text: &str) -> Option<Self> {
        let shown: Self = serde_json::from_str(text).ok()?;
        let is_part = |corners: &[[f32; 2]; 2]| corners.as_flattened().iter().all(|side| side.abs() <= MOST_FILMS);
        Some(Self {
            view: shown.view.filter(StoredView::is_possible),
            time: if shown.time.abs() <= MOST_TIME { shown.time } else { 0.0 },
            samples: shown.samples.map(|samples| samples.max(1)),
            seconds: shown.seconds.filter(|seconds| seconds.is_finite() && *seconds > 0.0),
            // 0 is no limit.
            noise: shown.noise.filter(|noise| (0.0..=1.0).contains(noise)),
            region: shown.region.filter(is_part),
            extent: match shown.extent.iter().all(|extent| (1.0..=MOST_FILMS).contains(extent)) {
                true => shown.extent,
                false => film_alone(),
            },
            ..shown
        })
    }
}

/// A kept picture that is resumed as soon as the scene is in the same state.
#[derive(Resource)]
pub struct Returning {
    /// The scene.
    pub scene: PathBuf,
    /// The picture.
    pub file: PartFile,
    /// The width and height of the picture in widths and heights of the film.
    pub extent: Vec2,
    /// Whether the picture was given the size of the kept one.
    pub is_sized: bool,
}

/// The state of the kept picture, and of the samples that no file has.
#[derive(Resource, Debug, Default)]
pub struct KeptPictures {
    /// Whether rendering resumes from the kept picture when a scene is opened.
    returns: bool,
    /// The last seen load of the scene.
    seen: u64,
    /// The number of the last saved picture as [`RenderFilm`](crate::engine::RenderFilm) counts them, and its seconds
    /// of rendering, which need not be kept.
    kept: (u64, f64),
    /// Whether the next picture is the resumed one.
    resumes: bool,
    /// Whether a picture is kept beside the open scene.
    pub is_there: bool,
    /// Whether the user is asked before the picture is lost.
    pub is_offered: bool,
    /// The reason why the kept picture was not resumed when that was last asked for.
    pub failure: Option<String>,
}

impl KeptPictures {
    /// Makes the state; with `returns`, scenes resume their pictures when they are opened.
    pub fn new(returns: bool) -> Self {
        Self {
            returns,
            ..Self::default()
        }
    }

    /// Returns whether a scene that may resume its picture was opened since the last call. `revision` counts the loads.
    pub fn take_opened(&mut self, revision: u64, is_fresh: bool) -> bool {
        let is_new = std::mem::replace(&mut self.seen, revision) != revision;
        is_new && is_fresh && self.returns
    }

    /// Notes the picture and its seconds of rendering. Returns whether much of that is in no file.
    pub fn note(&mut self, job: u64, seconds: f64) -> bool {
        if self.kept.0 != job {
            let kept = if std::mem::take(&mut self.resumes) {
                seconds
            } else {
                0.0
            };
            self.kept = (job, kept);
        }
        seconds - self.kept.1 >= WORTH_A_QUESTION
    }

    /// Notes that the picture was kept.
    pub fn note_kept(&mut self, job: u64, seconds: f64) {
        self.kept = (job, seconds);
    }

    /// Notes that the next picture is the resumed one.
    pub fn note_resumed(&mut self) {
        self.resumes = true;
    }
}

#[cfg(test)]
mod tests {
    use bevy::math::Affine3A;

    use super::*;

    #[test]
    fn one_is_asked_only_about_what_no_file_has() {
        let mut kept = KeptPictures::default();
        assert!(!kept.note(1, WORTH_A_QUESTION - 1.0));
        assert!(kept.note(1, WORTH_A_QUESTION));
        kept.note_kept(1, WORTH_A_QUESTION);
        assert!(!kept.note(1, WORTH_A_QUESTION + 1.0));
        assert!(kept.note(1, 2.0 * WORTH_A_QUESTION));
        assert!(!kept.note(2, 1.0), "another picture");
        kept.note_resumed();
        assert!(!kept.note(2, 2.0), "it is still to come");
        assert!(!kept.note(3, 5000.0), "all of it is in the file");
        assert!(kept.note(3, 5000.0 + WORTH_A_QUESTION));
        assert!(kept.note(4, WORTH_A_QUESTION));
    }

    #[test]
    fn a_scene_that_is_opened_goes_on_once() {
        let mut kept = KeptPictures::new(true);
        assert!(kept.take_opened(1, true));
        assert!(!kept.take_opened(1, true));
        assert!(!kept.take_opened(2, false), "it was read again");
        assert!(kept.take_opened(3, true));
        assert!(!KeptPictures::new(false).take_opened(1, true));
    }

    #[test]
    fn what_cannot_be_shown_is_left_out() {
        let view = StoredView {
            pose: Affine3A::IDENTITY,
            orthographic: false,
            hides_walls: false,
        };
        let shown = Shown {
            camera: 1,
            view: Some(view),
            time: -2.5,
            samples: Some(7),
            seconds: Some(60.0),
            noise: Some(0.0),
            adaptive: Some(true),
            region: Some([[0.0, 0.25], [0.5, 1.0]]),
            extent: film_alone(),
            keeps_lights_apart: true,
            lights_are_free: true,
        };
        let text = serde_json::to_string(&shown).expect("a text");
        assert_eq!(Shown::read(&text), Some(shown.clone()));
        let wild = [
            ("-2.5", "1e300"),
            ("\"samples\":7", "\"samples\":0"),
            ("60.0", "1e39"),
            ("\"noise\":0.0", "\"noise\":-1.0"),
            ("[0.5,1.0]", "[1e39,1.0]"),
            ("[1.0,0.0,0.0]", "[0.0,0.0,0.0]"),
        ];
        let wild = wild.into_iter().fold(text, |text, (from, to)| {
            assert!(text.contains(from), "{text}");
            text.replacen(from, to, 1)
        });
        let expected = Shown {
            view: None,
            time: 0.0,
            samples: Some(1),
            seconds: None,
            noise: None,
            region: None,
            ..shown
        };
        assert_eq!(Shown::read(&wild), Some(expected), "{wild}");
        assert_eq!(Shown::read("{}"), None);
    }

    #[test]
    fn the_file_is_beside_the_scene() {
        let file = kept_file(Path::new("/a.b/room.xml"));
        assert_eq!(file, Path::new("/a.b/room.xml.unfinished.exr"));
    }
}
