//! The end of a render: its messages, and its exit code.

use std::fmt;
use std::path::Path;
use std::process::ExitCode;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use sunroom::app::interrupt::on_interrupt;
use sunroom::engine::{Outcome, RenderError};
use sunroom::render::denoise::end_all;

use super::report::Failure;
use super::{outputs, report};

/// The exit code after an interrupt by the user; shells use 128 + SIGINT.
pub const INTERRUPTED: u8 = 130;

/// The exit code after SIGTERM if a checkpoint was written: 128 + SIGTERM.
pub const TERMINATED: u8 = 143;

/// The flag that ends work in an orderly fashion. The first interrupt sets it; a second one ends the process.
pub fn cancel_on_interrupt() -> Result<Arc<AtomicBool>, Failure> {
    let cancel = Arc::new(AtomicBool::new(false));
    let flag = cancel.clone();
    on_interrupt(move || {
        if flag.swap(true, Ordering::Relaxed) {
            end_all();
            std::process::exit(i32::from(INTERRUPTED));
        }
    })?;
    Ok(cancel)
}

/// The end of a render whose film has at least some samples.
pub struct Ending {
    /// The reason why the render was broken off. None if the picture is complete, or if the user's time limit is over.
    broken_off_by: Option<Reason>,
    pixels: usize,
    pixels_without_samples: usize,
}

enum Reason {
    Interrupt,
    /// The time limit was reached before every pixel had a sample.
    Time,
    /// A fault of the program.
    Fault(RenderError),
}

impl Ending {
    /// The end of a picture with this number of pixels, and of pixels without a sample. An error if there is nothing to
    /// write: without any sample the picture would be black, and replace an earlier one.
    pub fn new(rendered: Result<Outcome, RenderError>, [pixels, missing]: [usize; 2]) -> Result<Self, String> {
        let mut ending = Self {
            broken_off_by: None,
            pixels,
            pixels_without_samples: missing,
        };
        ending.broken_off_by = match rendered {
            Ok(Outcome::Cancelled) => Some(Reason::Interrupt),
            Ok(Outcome::TimeUp) if !ending.is_whole() => Some(Reason::Time),
            Ok(Outcome::TimeUp | Outcome::Complete) => None,
            Err(error @ RenderError::Failed(_)) => Some(Reason::Fault(error)),
            Err(error) => return Err(error.to_string()),
        };
        match &ending.broken_off_by {
            Some(reason) if ending.pixels_without_samples == ending.pixels => {
                Err(format!("{reason}; no pixel has a sample yet, and nothing is written"))
            }
            _ => Ok(ending),
        }
    }

    /// Whether every pixel has a sample.
    pub fn is_whole(&self) -> bool {
        self.pixels > 0 && self.pixels_without_samples == 0
    }

    /// Whether the render ended before one of its limits was reached in every pixel: by the user, by the time, or by a
    /// fault.
    pub fn is_broken_off(&self) -> bool {
        self.broken_off_by.is_some()
    }

    /// Prints where the picture is, and why the render was broken off, if it was. `samples`: of every pixel; `denoise`:
    /// whether the user asked for denoising; `written`: the outputs with the picture.
    pub fn report(&self, samples: u32, quiet: bool, denoise: bool, written: &[&Path]) {
        let Some(reason) = &self.broken_off_by else {
            if !quiet {
                outputs::report_written(written);
            }
            return;
        };
        let files = outputs::names_of_files(written);
        if !self.is_whole() {
            let (missing, all) = (self.pixels_without_samples, self.pixels);
            let more = if denoise {
                ", and the picture is not denoised"
            } else {
                ""
            };
            report::error(format_args!(
                "{reason}; {missing} of {all} pixels have no sample and are black{more}"
            ));
            return;
        }
        let place = match files.is_empty() {
            true => String::new(),
            false => format!(" and is in {files}"),
        };
        let message = format!("{reason}; the picture has {samples} samples per pixel{place}");
        match reason {
            Reason::Interrupt if quiet => {}
            Reason::Interrupt => report::line(message),
            Reason::Time | Reason::Fault(_) => drop(report::error(message)),
        }
    }

    pub fn exit_code(&self) -> ExitCode {
        match self.broken_off_by {
            None => ExitCode::SUCCESS,
            Some(Reason::Interrupt) if self.is_whole() => ExitCode::from(INTERRUPTED),
            Some(_) => ExitCode::FAILURE,
        }
    }
}

impl fmt::Display for Reason {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        match self {
            Self::Interrupt => f.write_str("interrupted"),
            Self::Time => f.write_str("the time was up"),
            Self::Fault(error) => error.fmt(f),
        }
    }
}

/// A noise above its limit, with as many digits as are needed to show that, at least four decimals.
pub fn above(noise: f32, limit: f32) -> String {
    let is_above = |text: &String| text.parse::<f32>().is_ok_and(|shown| shown > limit);
    // No f32 has more digits.
    let mut texts = (4..150).map(|digits| format!("{noise:.digits$}"));
    texts.find(is_above).unwrap_or_else(|| noise.to_string())
}

#[cfg(test)]
mod tests {
    use sunroom::render::film::Film;
    use sunroom::render::tile::{PixelSum, TileSamples, tiles};

    use super::*;
    use crate::cli::share::pixel_counts;

    /// A film of 2 x 2 tiles of which the first `count` have a sample.
    fn film(count: usize) -> Film {
        let mut film = Film::new(64, 64);
        for tile in tiles(64, 64).into_iter().take(count) {
            film.add(&TileSamples {
                tile,
                samples: 0..1,
                pixels: vec![PixelSum::default(); (tile.width * tile.height) as usize],
                blocks: None,
                layers: Default::default(),
                first_hits: Vec::new(),
                splats: Default::default(),
                rays: 0,
                invalid: 0,
            });
        }
        film
    }

    #[test]
    fn only_a_picture_with_a_sample_of_every_pixel_is_a_success() {
        let failed = || Err(RenderError::Failed("a worker panicked".to_owned()));
        let success = format!("{:?}", ExitCode::SUCCESS);
        let [failure, interrupted] = [1, INTERRUPTED].map(|code| format!("{:?}", ExitCode::from(code)));
        for (tiles, rendered, expected) in [
            (4, Ok(Outcome::Complete), Some(&success)),
            (4, Ok(Outcome::TimeUp), Some(&success)),
            (4, Ok(Outcome::Cancelled), Some(&interrupted)),
            (4, failed(), Some(&failure)),
            (3, Ok(Outcome::TimeUp), Some(&failure)),
            (3, Ok(Outcome::Cancelled), Some(&failure)),
            (3, failed(), Some(&failure)),
            (0, Ok(Outcome::TimeUp), None),
            (0, Ok(Outcome::Cancelled), None),
            (0, failed(), None),
            (0, Err(RenderError::NoSensor), None),
        ] {
            let what = format!("{tiles} tiles, {rendered:?}");
            let code = Ending::new(rendered, pixel_counts(None, &film(tiles)))
                .map(|ending| format!("{:?}", ending.exit_code()));
            assert_eq!(code.ok().as_ref(), expected, "{what}");
        }
    }

    #[test]
    fn a_noise_above_its_limit_is_shown_above_it() {
        for (noise, limit, shown) in [
            (0.03, 0.005, "0.0300"),
            (0.005_000_1, 0.005, "0.0050001"),
            (0.005_04, 0.005_03, "0.00504"),
            (f32::INFINITY, 0.005, "inf"),
        ] {
            assert_eq!(above(noise, limit), shown);
        }
        let limit = 0.005f32;
        let text = above(limit.next_up(), limit);
        assert!(text.parse::<f32>().is_ok_and(|shown| shown > limit), "{text}");
    }
}
