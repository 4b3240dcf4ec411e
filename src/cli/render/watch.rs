//! The output while a picture is rendered: progress, events for machines, checkpoints, and unfinished pictures.

use std::path::PathBuf;
use std::time::{Duration, Instant};

use bevy::prelude::*;
use serde_json::{Value, json};
use sunroom::app::signals::take_show;
use sunroom::engine::RenderFilm;
use sunroom::engine::{RenderStatus, layered_picture};
use sunroom::render::image_io::{ImageIoError, ImageRgb};
use sunroom::render::layered_image::LayeredImage;

use super::picture::Picture;
use crate::cli::outputs;
use crate::cli::progress::Progress;
use crate::cli::share::{Checkpoints, Share};
use crate::cli::stats::{memory_bytes, peak_memory_bytes};

/// The time between two progress events.
const EVENT_TIME: Duration = Duration::from_secs(1);

/// Watches a render.
pub struct Watch<'a> {
    pub picture: &'a Picture<'a>,
    pub progress: Progress,
    pub share: Option<&'a Share>,
    pub checkpoints: Checkpoints<'a>,
    /// The time of the last event; None before the first.
    pub last_event: Option<Instant>,
    /// The time when the unfinished picture was last written; initially the start of the render.
    pub last_picture: Instant,
}

impl Watch<'_> {
    /// Writes the output that is due, between two updates of the app.
    pub fn look(&mut self, world: &World) {
        let status = world.resource::<RenderStatus>();
        self.progress.update(status);
        if self.picture.has_events() {
            match self.last_event {
                Some(last) if last.elapsed() < EVENT_TIME => {}
                last => {
                    self.last_event = Some(Instant::now());
                    event(last.map_or_else(|| begin(status), |_| progress(status)));
                }
            }
        }
        if self.checkpoints.are_due() {
            self.save(world);
        }
        let is_due = self
            .picture
            .args
            .partial
            .is_some_and(|every| self.last_picture.elapsed() >= every);
        if take_show() || is_due {
            self.show(world);
        }
    }

    /// Writes a checkpoint, if there are new samples. Returns whether a checkpoint exists.
    pub fn save(&mut self, world: &World) -> bool {
        let (status, film) = (world.resource::<RenderStatus>(), &world.resource::<RenderFilm>().film);
        let Some(share) = self.share.filter(|_| film.width() > 0) else {
            return false;
        };
        self.checkpoints.save(status.rays, |path| {
            let mut described = LayeredImage::new(film.width(), film.height());
            self.picture.describe(&mut described, world);
            share.piece.write_checkpoint(world, path, &described)?;
            if self.picture.has_events() {
                event(json!({ "event": "checkpoint", "file": path.display().to_string(), "samples": status.samples }));
            }
            Ok::<_, ImageIoError>(())
        })
    }

    /// Writes the unfinished picture, if every pixel has a sample.
    fn show(&mut self, world: &World) {
        let film = &world.resource::<RenderFilm>().film;
        self.last_picture = Instant::now();
        let is_whole = match self.share {
            Some(share) => share.piece.is_whole(film),
            None => film.width() > 0 && film.pixels_without_samples() == 0,
        };
        if !is_whole {
            return;
        }
        let image = ImageRgb {
            width: film.width(),
            height: film.height(),
            pixels: film.radiance(),
        };
        let mut picture = layered_picture(world, &image, None);
        self.picture.describe(&mut picture, world);
        // Standard output takes one picture only, the finished one.
        let files = self.picture.outputs.iter().filter(|path| !outputs::is_stdout(path));
        let files: Vec<PathBuf> = files.cloned().collect();
        let written = self.picture.write(self.share, world, &picture, &files);
        if written.len() == files.len() && self.picture.has_events() {
            let samples = world.resource::<RenderStatus>().samples;
            event(json!({ "event": "picture", "samples": samples }));
        }
    }
}

fn target(status: &RenderStatus) -> Option<u32> {
    Some(status.target).filter(|&target| target != u32::MAX)
}

fn begin(status: &RenderStatus) -> Value {
    json!({
        "event": "begin", "width": status.size.x, "height": status.size.y,
        "first": status.first, "target": target(status),
    })
}

fn progress(status: &RenderStatus) -> Value {
    json!({
        "event": "progress", "samples": status.samples, "target": target(status), "done": status.done(),
        "noise": status.noise, "seconds": status.seconds, "seconds_left": status.seconds_left(),
        "msamples_per_s": status.msamples_per_s, "memory_bytes": memory_bytes(), "peak_memory_bytes": peak_memory_bytes(),
    })
}

/// Prints an event as one line. If the reader is gone, the event is lost.
pub fn event(event: Value) {
    let _ = outputs::print(format!("{event}\n").as_bytes());
}
