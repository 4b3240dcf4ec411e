//! What happens while a picture is rendered: progress, events for machines, checkpoints, and pictures so far.

use std::path::Path;
use std::time::{Duration, Instant};

use bevy::prelude::*;
use serde_json::{Value, json};
use sunroom::app::signals::take_show;
use sunroom::engine::RenderFilm;
use sunroom::engine::{RenderStatus, layered_picture};
use sunroom::render::image_io::ImageRgb;
use sunroom::render::layered_image::LayeredImage;

use super::progress::Progress;
use super::share::{Share, earlier_stays};
use super::stats::{memory_bytes, peak_memory_bytes};
use super::{outputs, report};

/// The time between two events of progress.
const EVENT_TIME: Duration = Duration::from_secs(1);

/// Watches a render.
pub struct Watch<'a> {
    pub progress: Progress,
    pub share: Option<&'a Share>,
    /// The file of checkpoints and the time between two of them.
    pub checkpoint: Option<(&'a Path, Duration)>,
    /// The time between two pictures so far.
    pub partial: Option<Duration>,
    /// Whether events are printed.
    pub has_events: bool,
    /// Writes attributes to a picture.
    pub describe: &'a dyn Fn(&mut LayeredImage, &World),
    /// Writes the picture so far to the outputs, and returns whether it could.
    pub write: &'a dyn Fn(&World, &LayeredImage) -> bool,
    pub last: Last,
}

/// When what was done last; at first, when the render began.
pub struct Last {
    event: Instant,
    checkpoint: Instant,
    picture: Instant,
    /// The samples of the last checkpoint.
    saved: Option<u64>,
    has_begun: bool,
}

impl Default for Last {
    fn default() -> Self {
        let now = Instant::now();
        Self {
            event: now,
            checkpoint: now,
            picture: now,
            saved: None,
            has_begun: false,
        }
    }
}

impl Watch<'_> {
    /// Looks at the world between two updates of the app.
    pub fn look(&mut self, world: &World) {
        let status = world.resource::<RenderStatus>();
        self.progress.update(status);
        if self.has_events {
            if !self.last.has_begun {
                self.last.has_begun = true;
                event(json!({
                    "event": "begin", "width": status.size.x, "height": status.size.y,
                    "first": status.first, "target": target(status),
                }));
            } else if self.last.event.elapsed() >= EVENT_TIME {
                self.last.event = Instant::now();
                event(progress(status));
            }
        }
        if let Some((_, every)) = self.checkpoint
            && self.last.checkpoint.elapsed() >= every
        {
            self.save(world);
        }
        let is_due = self.partial.is_some_and(|every| self.last.picture.elapsed() >= every);
        if take_show() || is_due {
            self.show(world);
        }
    }

    /// Writes a checkpoint, if there is anything new. One that fails is reported, and an earlier one stays. Returns
    /// whether there is one.
    pub fn save(&mut self, world: &World) -> bool {
        let (Some((path, _)), Some(share)) = (self.checkpoint, self.share) else {
            return false;
        };
        let status = world.resource::<RenderStatus>();
        if self.last.saved == Some(status.rays) {
            return true;
        }
        let film = &world.resource::<RenderFilm>().film;
        if film.width() == 0 {
            return false;
        }
        let mut described = LayeredImage::new(film.width(), film.height());
        (self.describe)(&mut described, world);
        let result = share.piece.write_checkpoint(world, path, &described);
        self.last.checkpoint = Instant::now();
        match result {
            Ok(()) => {
                self.last.saved = Some(status.rays);
                if self.has_events {
                    event(
                        json!({ "event": "checkpoint", "file": path.display().to_string(), "samples": status.samples }),
                    );
                }
                true
            }
            Err(error) => {
                report::line(format_args!("warning: {error}{}", earlier_stays(path)));
                false
            }
        }
    }

    /// Writes the picture so far, if every pixel has a sample.
    fn show(&mut self, world: &World) {
        let film = &world.resource::<RenderFilm>().film;
        self.last.picture = Instant::now();
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
        (self.describe)(&mut picture, world);
        if (self.write)(world, &picture) && self.has_events {
            let samples = world.resource::<RenderStatus>().samples;
            event(json!({ "event": "picture", "samples": samples }));
        }
    }
}

fn target(status: &RenderStatus) -> Option<u32> {
    Some(status.target).filter(|&target| target != u32::MAX)
}

fn progress(status: &RenderStatus) -> Value {
    json!({
        "event": "progress", "samples": status.samples, "target": target(status), "done": status.done(),
        "noise": status.noise, "seconds": status.seconds, "seconds_left": status.seconds_left(),
        "msamples_per_s": status.msamples_per_s, "memory_bytes": memory_bytes(), "peak_memory_bytes": peak_memory_bytes(),
    })
}

/// Prints an event as a line of its own. A reader that went away misses it.
pub fn event(event: Value) {
    let _ = outputs::print(format!("{event}\n").as_bytes());
}
