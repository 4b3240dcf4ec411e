//! Shares of a picture, checkpoints, and resuming.

use std::fmt::Display;
use std::ops::Range;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;
use std::time::{Duration, Instant};

use bevy::prelude::*;
use clap::Args;
use sunroom::app::checkpoint::Piece;
use sunroom::app::origin::{self, origin};
use sunroom::app::signals::{is_terminated, note_termination};
use sunroom::bake::part::is_part;
use sunroom::engine::{OpenShutter, PackedScene, RenderControl, active_film};
use sunroom::render::film::Film;
use sunroom::render::part::{Crop, Origin, PartError, PartFile};
use sunroom::render::passes::{chunk_of, is_cut};

use super::ending::{TERMINATED, cancel_on_interrupt};
use super::outputs::{self, is_exr, is_stdout};
use super::parse;
use super::report::{self, Failure};

#[derive(Args)]
pub struct ShareArgs {
    /// Render only these samples of each pixel, such as 0..256 (256 is not one of them); `sunroom merge` puts the
    /// parts together
    #[arg(long, value_name = "A..B", value_parser = parse::samples, conflicts_with_all = ["time", "noise", "adaptive", "denoise"])]
    pub samples: Option<Range<u32>>,
    /// Render only this part of the picture: its upper left corner and its size in pixels, at multiples of 32
    #[arg(long, value_name = "X,Y,W,H", value_parser = parse::crop, conflicts_with_all = ["time", "noise", "adaptive", "denoise"])]
    crop: Option<Crop>,
}

#[derive(Args)]
pub struct CheckpointArgs {
    /// Save what is rendered to this file from time to time, to go on after an interruption
    #[arg(long, value_name = "FILE")]
    pub checkpoint: Option<PathBuf>,
    /// The time between two checkpoints
    #[arg(long, value_name = "TIME", default_value = "60s", value_parser = parse::duration, requires = "checkpoint")]
    pub every: Duration,
    /// Go on with what a checkpoint has; if it is the file of --checkpoint and does not exist, begin
    #[arg(long, value_name = "FILE")]
    pub resume: Option<PathBuf>,
    /// Go on even if the scene, the settings or the version have changed
    #[arg(long, requires = "resume")]
    pub force: bool,
}

impl CheckpointArgs {
    /// Whether checkpoints are written or resumed.
    pub fn are_given(&self) -> bool {
        self.checkpoint.is_some() || self.resume.is_some()
    }

    /// The flag that ends work in an orderly fashion. The first interrupt sets it, as does SIGTERM if checkpoints are
    /// written; a second interrupt ends the process.
    pub fn cancel(&self) -> Result<Arc<AtomicBool>, Failure> {
        let cancel = cancel_on_interrupt()?;
        if self.checkpoint.is_some() {
            note_termination(cancel.clone());
        }
        Ok(cancel)
    }

    /// The exit code of terminated work whose checkpoint was saved, with a message about the work `done` (rendered,
    /// gathered); None otherwise.
    pub fn terminated(&self, is_saved: bool, done: &str) -> Option<ExitCode> {
        let path = self.checkpoint.as_ref().filter(|_| is_saved && is_terminated())?;
        report::line(format_args!("terminated; {} has what was {done}", path.display()));
        Some(ExitCode::from(TERMINATED))
    }

    /// Refuses a checkpoint file that is an output as well, that cannot be written, or that has other content, which
    /// would be lost. `is_checkpoint` says whether a file is a checkpoint of such a `work` (a picture, a bake),
    /// possibly of another scene.
    pub fn check(
        &self,
        work: &str,
        is_output: impl Fn(&Path) -> bool,
        is_checkpoint: impl Fn(&Path) -> bool,
    ) -> Result<(), Failure> {
        let Some(path) = &self.checkpoint else {
            return Ok(());
        };
        if is_output(path) {
            return Err(Failure::Usage(format!(
                "{}: the checkpoint and an output cannot be the same file; name another one by --checkpoint",
                path.display()
            )));
        }
        outputs::check_text(path)?;
        let has_content = path.metadata().is_ok_and(|about| about.len() > 0);
        match has_content && !is_checkpoint(path) {
            true => Err(format!(
                "{} is there already and is no checkpoint of a {work}: it is not replaced; name another file by --checkpoint",
                path.display()
            )
            .into()),
            false => Ok(()),
        }
    }
}

/// Writes checkpoints of work at intervals.
pub struct Checkpoints<'a> {
    args: &'a CheckpointArgs,
    last: Instant,
    /// The number of rays traced at the last checkpoint, and at the last attempt.
    saved: Option<u64>,
    tried: Option<u64>,
}

impl<'a> Checkpoints<'a> {
    pub fn new(args: &'a CheckpointArgs) -> Self {
        let last = Instant::now();
        Self {
            args,
            last,
            saved: None,
            tried: None,
        }
    }

    /// Whether the next checkpoint is due.
    pub fn are_due(&self) -> bool {
        self.args.checkpoint.is_some() && self.last.elapsed() >= self.args.every
    }

    /// Whether a checkpoint was already attempted at this number of rays.
    pub fn were_tried(&self, rays: u64) -> bool {
        self.tried == Some(rays)
    }

    /// Writes a checkpoint, if there is new work. A failure is reported, and the earlier one stays. Returns whether the
    /// checkpoint has the present work.
    pub fn save<E: Display>(&mut self, rays: u64, write: impl FnOnce(&Path) -> Result<(), E>) -> bool {
        let Some(path) = &self.args.checkpoint else {
            return false;
        };
        if self.saved != Some(rays) {
            let result = write(path);
            (self.last, self.tried) = (Instant::now(), Some(rays));
            match result {
                Ok(()) => self.saved = Some(rays),
                Err(error) => report::line(format_args!("warning: {error}{}", earlier_stays(path))),
            }
        }
        self.saved == Some(rays)
    }
}

/// Opens a checkpoint or a part of a picture. The error names the file.
fn open_checkpoint(path: &Path) -> Result<PartFile, String> {
    let name = path.display();
    PartFile::open(path).map_err(|error| match error {
        PartError::NoState | PartError::NoPicture if is_part(path) => {
            format!("{name}: it is a checkpoint or share of a bake, and a picture cannot go on with it")
        }
        PartError::NoState => {
            format!(
                "{name}: it is damaged or no checkpoint: the exact sums, which are the end of a checkpoint, are missing"
            )
        }
        PartError::NoPicture => format!("{name}: it is no EXR file: a checkpoint of a picture is one"),
        error => format!("{name}: {error}"),
    })
}

/// Whether a file is a checkpoint or a part of a picture, possibly of another version, or damaged except for its end.
pub fn is_checkpoint_of_picture(path: &Path) -> bool {
    matches!(
        PartFile::open(path),
        Ok(_) | Err(PartError::Format | PartError::Damaged(_))
    )
}

/// The settings on which the samples of a picture depend, apart from the scene and the view, by name.
pub type Settings = Vec<(String, String)>;

/// The rendered share of the picture, which is all of it for an ordinary picture.
pub struct Share {
    pub piece: Piece,
    /// Whether the outputs are parts.
    pub is_part: bool,
}

impl ShareArgs {
    /// Whether only a part of the picture is rendered.
    pub fn is_given(&self) -> bool {
        self.samples.is_some() || self.crop.is_some()
    }

    /// Refuses missing outputs, outputs that cannot be parts, and ranges that cannot be merged.
    pub fn check(&self, outputs: &[PathBuf]) -> Result<(), Failure> {
        if !self.is_given() {
            return Ok(());
        }
        if outputs.is_empty() {
            let message =
                "a part of a picture needs a name of its own, by `-o`: the film names the file of the whole picture";
            return Err(Failure::Usage(message.to_owned()));
        }
        if let Some(path) = outputs.iter().find(|path| is_stdout(path) || !is_exr(path)) {
            return Err(Failure::Usage(format!(
                "{}: a part of a picture is an EXR file, which has the exact sums for `sunroom merge`",
                path.display()
            )));
        }
        self.samples.as_ref().map_or(Ok(()), check_cut)
    }
}

/// Refuses a range of samples that cannot be merged with earlier ones.
pub fn check_cut(samples: &Range<u32>) -> Result<(), Failure> {
    let (start, around) = (samples.start, chunk_of(samples.start));
    match is_cut(start) {
        true => Ok(()),
        false => Err(Failure::Usage(format!(
            "samples are summed up in fixed groups, and a range cannot begin at {start}: {} and {} are the nearest",
            around.start, around.end
        ))),
    }
}

/// Resolves `auto` to its choice in the checkpoint that is resumed. False if there is no such checkpoint.
pub fn take_choice(world: &mut World, checkpoints: &CheckpointArgs) -> Result<bool, Failure> {
    let Some(path) = checkpoints.resume.as_ref().filter(|path| path.exists()) else {
        return Ok(false);
    };
    let file = open_checkpoint(path)?;
    Ok(origin::take_choice(world, &file.header().origin))
}

/// Prepares a picture that is a share, has checkpoints or is resumed; None for an ordinary one. The scene is packed.
/// `samples`: the number of samples asked for; `samples_of_whole`: that of the whole picture, `u32::MAX` if unknown;
/// `settings`: other settings on which samples depend.
pub fn begin(
    world: &mut World,
    scene: &Path,
    shares: &ShareArgs,
    checkpoints: &CheckpointArgs,
    samples: u32,
    samples_of_whole: u32,
    mut settings: Settings,
) -> Result<Option<Share>, Failure> {
    if !shares.is_given() && !checkpoints.are_given() {
        return Ok(None);
    }
    let Some(view) = &world.resource::<PackedScene>().view else {
        return Ok(None);
    };
    let size = [view.width, view.height];
    let crop = shares.crop.unwrap_or(Crop::whole(size[0], size[1]));
    crop.check(size[0], size[1]).map_err(Failure::Usage)?;
    let range = shares.samples.clone().unwrap_or(0..samples);
    let is_adaptive = active_film(world).is_some_and(|film| film.adaptive);
    if shares.is_given() && is_adaptive {
        let message = "the scene asks for adaptive sampling, which decides by the noise of the whole picture: its samples cannot be divided into parts";
        return Err(Failure::Usage(message.to_owned()));
    }
    if let Some(shutter) = &world.resource::<OpenShutter>().shutter {
        settings.push((
            "the number of moments of the shutter".to_owned(),
            shutter.moments().to_string(),
        ));
    }
    settings.push((
        "adaptive sampling".to_owned(),
        world
            .resource::<RenderControl>()
            .adaptive
            .unwrap_or(is_adaptive)
            .to_string(),
    ));
    let share = Share {
        piece: Piece {
            origin: origin(world, scene, settings)?,
            size,
            crop,
            samples: [range.start, range.end],
            samples_of_whole: Some(samples_of_whole).filter(|&samples| samples != u32::MAX),
        },
        is_part: shares.is_given(),
    };
    let mut control = world.resource_mut::<RenderControl>();
    if share.is_part {
        let [width, height] = size.map(|side| side as f32);
        let (x, y) = (crop.x as f32 + 0.5, crop.y as f32 + 0.5);
        // The centres of the outer pixels: edges might be rounded into the next tile.
        let [right, bottom] = [(x, crop.width), (y, crop.height)].map(|(start, length)| start + (length - 1) as f32);
        control.region = Some(Rect::new(x / width, y / height, right / width, bottom / height));
        control.share = Some(range.start);
        control.target_samples = Some(range.end);
    }
    if let Some(path) = &checkpoints.resume
        && !is_begun(checkpoints, path, "picture")
    {
        share.take_up(world, path, checkpoints.force)?;
    }
    Ok(Some(share))
}

impl Share {
    /// Resumes the picture from a checkpoint.
    fn take_up(&self, world: &mut World, path: &Path, force: bool) -> Result<(), Failure> {
        let name = path.display();
        let file = open_checkpoint(path)?;
        accept_origin(path, "picture", &self.piece.origin, &file.header().origin, force)?;
        let taken = self.piece.take_up(world, &file);
        let samples = taken.map_err(|error| format!("{name}: {error}"))?;
        let asked = self.piece.samples[1] - self.piece.samples[0];
        warn_of_more(path, ["pixel", "picture"], samples, asked);
        Ok(())
    }
}

/// The end of a message about a checkpoint that cannot be written: it says that an earlier one stays, if there is one.
fn earlier_stays(path: &Path) -> &'static str {
    match path.metadata().is_ok_and(|about| about.len() > 0) {
        true => "; the checkpoint before it stays",
        false => "",
    }
}

/// Whether the file to resume does not exist and is the checkpoint to be written, so that the `work` (a picture, a
/// bake) begins anew. This is reported.
pub fn is_begun(checkpoints: &CheckpointArgs, path: &Path, work: &str) -> bool {
    let is_begun = checkpoints.checkpoint.as_deref() == Some(path) && !path.exists();
    if is_begun {
        report::line(format_args!(
            "{} does not exist yet: the {work} is begun",
            path.display()
        ));
    }
    is_begun
}

/// Refuses a checkpoint whose `work` differs; with `force` it only warns.
pub fn accept_origin(path: &Path, work: &str, now: &Origin, then: &Origin, force: bool) -> Result<(), Failure> {
    let differences = now.differences(then);
    if differences.is_empty() {
        return Ok(());
    }
    let message = format!(
        "{} is a checkpoint of another {work}: {}",
        path.display(),
        differences.join("; ")
    );
    if !force {
        return Err(format!("{message} (--force goes on with it)").into());
    }
    report::line(format_args!("warning: {message}"));
    Ok(())
}

/// Warns of a checkpoint with more samples of each `place` of the `work` than are asked for.
pub fn warn_of_more(path: &Path, [place, work]: [&str; 2], samples: u32, asked: u32) {
    if samples > asked {
        let name = path.display();
        report::line(format_args!(
            "warning: {name} has {samples} samples per {place} already, and {asked} are asked for: the {work} keeps all of them"
        ));
    }
}

/// Warns if parts end before the number of samples asked for, if that is known. The samples are of each `place`.
pub fn warn_of_missing(place: &str, samples: u32, of_whole: Option<u32>) {
    if let Some(all) = of_whole.filter(|&all| samples < all) {
        report::line(format_args!(
            "warning: the parts have {samples} of {all} samples per {place}: those of samples {samples}..{all} are missing"
        ));
    }
}

/// The number of pixels of the share, or else of the film, and how many of them have no sample.
pub fn pixel_counts(share: Option<&Share>, film: &Film) -> [usize; 2] {
    match share {
        Some(share) => [
            share.piece.counts(film).count(),
            share.piece.counts(film).filter(|&count| count == 0).count(),
        ],
        None => [
            film.width() as usize * film.height() as usize,
            film.pixels_without_samples(),
        ],
    }
}
