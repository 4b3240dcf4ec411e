//! The options of the window besides the scene.

use std::path::PathBuf;
use std::time::Duration;

use bevy::prelude::*;

use crate::document::paths::settle;

/// The options of the window, and of automation in it without a user.
#[derive(Clone, Debug, PartialEq)]
pub struct WindowOptions {
    /// The scene; None opens an empty window.
    pub scene: Option<PathBuf>,
    /// Whether the start page is shown, because no scene was named.
    pub begins: bool,
    /// The values for the scene file's `$name` parameters.
    pub defines: Vec<(String, String)>,
    /// The name or index of the camera for the first scene; None is its first.
    pub camera: Option<String>,
    /// The size of the window's content in points. None: the size that it had when it was last closed, or else
    /// [`Self::FIRST_SIZE`].
    pub size: Option<UVec2>,
    /// The number of worker threads; see [`crate::app::threads::worker_count`].
    pub threads: Option<i32>,
    /// Saves the whole window as PNG once the picture has `after_spp` samples.
    pub screenshot: Option<PathBuf>,
    /// The script of commands, one a line: see [`crate::app::editor::automation::script`].
    pub script: Option<PathBuf>,
    /// The samples per pixel for `screenshot` and `exit`.
    pub after_spp: u32,
    /// Ends the program after the screenshot or the measurement, or else after `after_spp` samples.
    pub exit: bool,
    /// Repeats edits of several kinds this many times and prints the time until the picture followed.
    pub measure_latency: Option<u32>,
    /// Does edits of several kinds and prints the error of the shown picture against the converged one soon after them.
    pub measure_settling: Option<SettlingOptions>,
    /// Runs random acts and checks the program; the program ends with the outcome.
    pub monkey: Option<MonkeyOptions>,
    /// Whether the window is not drawn, as if the graphics driver took no time.
    pub undrawn: bool,
    /// Whether the picture is denoised from the beginning.
    pub denoise: bool,
    /// The time after which the program fails if `exit` has not ended it.
    pub timeout: Duration,
}

impl Default for WindowOptions {
    fn default() -> Self {
        Self {
            scene: None,
            begins: false,
            defines: Vec::new(),
            camera: None,
            size: None,
            threads: None,
            screenshot: None,
            script: None,
            after_spp: 1,
            exit: false,
            measure_latency: None,
            measure_settling: None,
            monkey: None,
            undrawn: false,
            denoise: false,
            timeout: Duration::from_secs(600),
        }
    }
}

impl WindowOptions {
    /// Width and height of the window at the first start, and without a user, in points.
    pub const FIRST_SIZE: [u32; 2] = [1280, 720];

    /// Whether a measurement needs the window as a user would see it.
    pub(crate) fn is_measured(&self) -> bool {
        self.measure_latency.is_some() || self.measure_settling.is_some()
    }

    /// Whether there is a user.
    pub(crate) fn is_attended(&self) -> bool {
        !self.exit && self.script.is_none() && self.monkey.is_none() && !self.is_measured()
    }
}

/// The values of the file's parameters, kept for reloads.
#[derive(Resource, Clone, Debug, Default)]
pub struct SceneDefines(pub Vec<(String, String)>);

/// The scene that the program opened because none was named. None once the user has chosen one, or saved that one.
#[derive(Resource, Clone, Debug, Default)]
pub(crate) struct BegunWith(pub Option<PathBuf>);

impl BegunWith {
    pub fn new(options: &WindowOptions) -> Self {
        let scene = options.scene.as_deref().filter(|_| options.begins);
        Self(scene.map(settle))
    }
}

/// The requested camera, until a scene is loaded.
#[derive(Resource, Clone, Debug, Default)]
pub(crate) struct WantedCamera {
    pub name: Option<String>,
    /// Whether the program ends with an error if the camera does not exist, because no user is there to choose another.
    pub is_required: bool,
}

/// The options of the measurement of how soon the picture settles.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct SettlingOptions {
    /// The samples per pixel of a converged picture, at least 1.
    pub samples: u32,
    /// The folder for the compared pictures. None: they are not written.
    pub pictures: Option<PathBuf>,
    /// Whether one JSON object is printed in place of the table.
    pub json: bool,
}

/// The length of a monkey's run.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Length {
    /// At least this time.
    Time(Duration),
    /// This number of acts: such a run can be repeated exactly.
    Steps(usize),
}

/// The options of the monkey.
#[derive(Clone, Debug, PartialEq)]
pub struct MonkeyOptions {
    /// The condition under which the run ends.
    pub length: Length,
    /// The seed of all random numbers.
    pub seed: u64,
    /// The scenes, at least one. Copies of them are edited, and other files are never touched.
    pub scenes: Vec<PathBuf>,
    /// The file that logs every act, one a line. Lines without a comment sign are lines of a script.
    pub log: Option<PathBuf>,
    /// The longest frame of the window's own systems; longer ones are faults. None: frames are not judged.
    pub longest_frame: Option<Duration>,
}
