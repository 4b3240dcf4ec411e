//! The frames of an animation: their numbers, their times, and the names of their files.

use std::ops::RangeInclusive;
use std::path::{Path, PathBuf};

use bevy::prelude::*;
use clap::Args;
use sunroom::document::{TransformOp, Value};
use sunroom::engine::{PackedScene, active_film};
use sunroom::render::shutter::Shutter;
use sunroom::scene::{ActiveSensor, Authored, PictureFormat, Sensor, ToWorld, Turntable, show_moment};

use super::outputs::{check_pictures, is_stdout};
use super::parse::within;
use super::report::Failure;
use super::share::Settings;

/// The most frames of a sequence: a day at 24 frames a second has fewer.
const MOST_FRAMES: u32 = 10_000_000;

/// The digits of a frame's number if the file name does not set them.
const DIGITS: usize = 4;

#[derive(Args)]
pub struct SequenceArgs {
    /// Render frames, such as 17 or 1..120 (the last one included): frame n is the scene at n / fps seconds, and
    /// `####` in an output stands for n
    #[arg(long, value_name = "FIRST..LAST", value_parser = frames)]
    pub frames: Option<RangeInclusive<u32>>,
    /// Frames per second
    #[arg(long, default_value_t = 24.0, value_parser = frame_rate, requires = "frames")]
    pub fps: f64,
    /// Part of the time of a frame for which the shutter is open, such as 0.5: what moves is blurred [default: the
    /// camera's shutter times]
    #[arg(long, value_name = "PART", value_parser = part_of_frame, requires = "frames")]
    pub shutter: Option<f64>,
    /// Turn the camera once around the middle of the scene in the course of the frames, or from frame 0 to frame COUNT
    /// if some of COUNT frames are rendered
    #[arg(long, value_name = "COUNT", requires = "frames", num_args = 0..=1, require_equals = true, value_parser = turn_frames)]
    pub turntable: Option<Option<u32>>,
}

/// `17` or `1..120`
pub fn frames(text: &str) -> Result<RangeInclusive<u32>, String> {
    let number = |text: &str| text.trim().parse::<u32>().ok();
    let (first, last) = text.split_once("..").unwrap_or((text, text));
    let last = last.strip_prefix('=').unwrap_or(last);
    match (number(first), number(last)) {
        (Some(first), Some(last)) if first <= last && last < MOST_FRAMES => Ok(first..=last),
        _ => Err(format!(
            "expected a frame such as 17, or the first and the last such as 1..120, below {MOST_FRAMES}"
        )),
    }
}

fn frame_rate(text: &str) -> Result<f64, String> {
    within(text, 0.001..=100_000.0, "frames per second, from 0.001 to 100000")
}

fn part_of_frame(text: &str) -> Result<f64, String> {
    within(text, 0.0..=1.0, "a part of a frame's time from 0 to 1")
}

fn turn_frames(text: &str) -> Result<u32, String> {
    within(
        text,
        1..=MOST_FRAMES,
        &format!("a number of frames from 1 to {MOST_FRAMES}"),
    )
}

/// The file of a frame: its number replaces the last run of `#`, with at least as many digits, or is inserted before
/// the extension.
pub fn frame_path(path: &Path, frame: u32) -> PathBuf {
    let name = path.file_name().unwrap_or_default().to_string_lossy();
    let numbered = match name.rfind('#') {
        Some(end) => {
            let start = name[..end].trim_end_matches('#').len();
            let digits = end + 1 - start;
            format!("{}{frame:0digits$}{}", &name[..start], &name[end + 1..])
        }
        None => {
            let stem = path.file_stem().unwrap_or_default().to_string_lossy();
            let extension = path.extension().unwrap_or_default().to_string_lossy();
            format!("{stem}-{frame:0DIGITS$}.{extension}")
        }
    };
    path.with_file_name(numbered)
}

impl SequenceArgs {
    /// The files of the first picture. An error if frames would share a file.
    pub fn first_outputs(&self, outputs: &[PathBuf]) -> Result<Vec<PathBuf>, Failure> {
        let Some(frames) = &self.frames else {
            return Ok(outputs.to_vec());
        };
        if self.turntable == Some(None) && frames.start() == frames.end() {
            let message = "one frame is no turn: --turntable=COUNT says how many frames the whole turn has";
            return Err(Failure::Usage(message.to_owned()));
        }
        if outputs.iter().any(|path| is_stdout(path)) {
            return Err(Failure::Usage("frames cannot go to standard output".to_owned()));
        }
        Ok(outputs.iter().map(|path| frame_path(path, *frames.start())).collect())
    }

    /// The default file of the picture: beside the scene, with the extension of the film's format. It never replaces a
    /// file, which may be a picture of the scene.
    pub fn default_output(&self, world: &World, scene: &Path) -> Result<PathBuf, Failure> {
        let format = active_film(world).and_then(|film| film.storage.file);
        let path = scene.with_extension(format.unwrap_or(PictureFormat::OpenExr).extension());
        let first = self.first_outputs(std::slice::from_ref(&path))?;
        check_pictures(&first)?;
        match first.iter().find(|path| path.exists()) {
            Some(taken) => {
                let taken = taken.display();
                Err(Failure::Usage(format!(
                    "{taken} is there already: name a file with `-o`"
                )))
            }
            None => Ok(path),
        }
    }

    /// The files of the last picture, whose names may be longer than those of the first.
    pub fn last_outputs(&self, outputs: &[PathBuf]) -> Vec<PathBuf> {
        match &self.frames {
            Some(frames) => outputs.iter().map(|path| frame_path(path, *frames.end())).collect(),
            None => Vec::new(),
        }
    }

    /// The files of each picture, one picture after the other.
    pub fn outputs<'p>(&self, outputs: &'p [PathBuf]) -> Box<dyn Iterator<Item = Vec<PathBuf>> + 'p> {
        let Some(frames) = self.frames.clone() else {
            return Box::new(std::iter::once(outputs.to_vec()));
        };
        let of_frame = move |frame| -> Vec<PathBuf> { outputs.iter().map(|path| frame_path(path, frame)).collect() };
        Box::new(frames.map(of_frame))
    }

    /// The settings on which the samples of a frame depend, apart from the scene, by name. `moments` are in frames.
    pub fn settings(&self, frame: u32, moments: &[f64], has_motion: bool) -> Settings {
        let seconds = |moments: &mut dyn Iterator<Item = f64>| {
            let times: Vec<String> = moments.map(|moment| (moment / self.fps).to_string()).collect();
            times.join(", ")
        };
        let mut settings = vec![
            ("the frame".to_owned(), frame.to_string()),
            (
                "the list of moments in seconds".to_owned(),
                seconds(&mut moments.iter().copied()),
            ),
        ];
        if has_motion {
            let before = seconds(&mut moments.iter().map(|moment| moment - 1.0));
            settings.push(("the list of moments a frame earlier in seconds".to_owned(), before));
        }
        if let Some((start, count)) = self.turn() {
            settings.push(("the turntable".to_owned(), format!("{count} frames from {start} on")));
        }
        settings
    }

    /// The first frame of the turntable, and its number of frames.
    fn turn(&self) -> Option<(u32, u32)> {
        let frames = self.frames.as_ref()?;
        Some(match self.turntable? {
            Some(count) => (0, count),
            None => (*frames.start(), frames.end() - frames.start() + 1),
        })
    }

    /// Sets the scene to the time of a frame, or between two frames.
    pub fn show(&self, world: &mut World, frame: f64, camera: Option<&TurningCamera>) {
        show_moment(world, frame / self.fps);
        if let (Some(camera), Some((start, count))) = (camera, self.turn()) {
            camera.turn(world, (frame - f64::from(start)) / f64::from(count));
        }
    }

    /// The times, in frames, that `samples` per pixel of a frame sample.
    pub fn moments(&self, world: &World, frame: u32, samples: u32) -> Vec<f64> {
        let frame = f64::from(frame);
        let sensor = world.get_resource::<ActiveSensor>().and_then(|active| active.0);
        let sensor = sensor.and_then(|sensor| world.get::<Sensor>(sensor));
        let of_sensor = sensor.map_or([0.0; 2], |sensor| {
            [sensor.shutter_open, sensor.shutter_close].map(|time| f64::from(time) * self.fps)
        });
        let [open, close] = self.shutter.map_or(of_sensor, |share| [0.0, share]);
        if close <= open {
            return vec![frame + open];
        }
        Shutter::times(frame + open, frame + close, Shutter::moments_for(samples)).collect()
    }
}

/// The active camera on its turntable.
pub struct TurningCamera {
    camera: Entity,
    turntable: Turntable,
}

impl TurningCamera {
    /// A turntable around the target of the active camera in the file, or else the centre of all shapes. None without a
    /// camera.
    pub fn of(world: &World) -> Option<Self> {
        let camera = world.get_resource::<ActiveSensor>()?.0?;
        let start = world.get::<ToWorld>(camera)?.0;
        let target = world.get::<Authored>(camera).and_then(|authored| {
            let mut properties = authored.object.properties.iter();
            match &properties.find(|property| property.name == "to_world")?.value {
                Value::Transform(steps) => match steps[..] {
                    [TransformOp::LookAt { target, .. }] => Some(target),
                    _ => None,
                },
                _ => None,
            }
        });
        let middle = target.or_else(|| {
            let scene = world.get_resource::<PackedScene>()?.scene.as_ref()?;
            Some(scene.geometry.bounds().center())
        })?;
        let turntable = Turntable::new(start, middle);
        Some(Self { camera, turntable })
    }

    /// Places the camera after this fraction of a full rotation.
    fn turn(&self, world: &mut World, share: f64) {
        if let Some(mut to_world) = world.get_mut::<ToWorld>(self.camera) {
            to_world.0 = self.turntable.at(share);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn frames_are_one_or_a_range_with_its_end() {
        assert_eq!(frames("17"), Ok(17..=17));
        assert_eq!(frames("0..47"), Ok(0..=47));
        assert_eq!(frames("1..=120"), Ok(1..=120));
        for bad in ["", "..", "5..", "..5", "5..4", "-1..4", "a..b", "0..10000000", "1.5"] {
            assert!(frames(bad).is_err(), "{bad}");
        }
        assert_eq!(frame_rate("23.976"), Ok(23.976));
        for bad in ["0", "-24", "inf", "NaN", "", "1e9"] {
            assert!(frame_rate(bad).is_err(), "{bad}");
        }
    }

    #[test]
    fn the_number_stands_where_the_name_says_or_before_the_extension() {
        let name = |path: &str, frame| frame_path(Path::new(path), frame).display().to_string();
        assert_eq!(name("out/a-###.exr", 7), "out/a-007.exr");
        assert_eq!(name("out/a-#.exr", 1234), "out/a-1234.exr");
        assert_eq!(name("#x##y.png", 5), "#x05y.png");
        assert_eq!(name("out/a.tar.exr", 17), "out/a.tar-0017.exr");
        // The names of folders stay unchanged.
        assert_eq!(name("##/a.png", 2), "##/a-0002.png");
    }
}
