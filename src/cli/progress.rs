//! Shows the progress of a render. On a terminal it is a bar. Otherwise it is a line when every pixel has a sample, one
//! for each tenth, one after some seconds without a line, and one at the end. A quiet render shows nothing.

use std::io::IsTerminal;
use std::ops::RangeInclusive;
use std::time::{Duration, Instant};

use indicatif::{ProgressBar, ProgressStyle};
use sunroom::engine::RenderStatus;

use super::report;

pub struct Progress {
    form: Form,
    /// The time limit, which ends the render if its samples do not.
    time: Option<Duration>,
    sequence: Option<InSequence>,
}

/// The progress of some work.
#[derive(Default)]
pub struct Shown {
    /// The finished share, from 0 to 1.
    pub done: f64,
    /// The number of samples so far, or another growing count.
    pub samples: u32,
    /// The time so far.
    pub seconds: f64,
    pub message: String,
}

/// The place of a picture in a sequence of frames.
#[derive(Clone)]
pub struct InSequence {
    frame: u32,
    /// The number of frames before it.
    done: u32,
    count: u32,
    began: Instant,
}

impl InSequence {
    /// The first frame, which begins now.
    pub fn begin(frames: &RangeInclusive<u32>) -> Self {
        Self {
            frame: *frames.start(),
            done: 0,
            count: frames.end() - frames.start() + 1,
            began: Instant::now(),
        }
    }

    /// Goes on to the next frame.
    pub fn next(&mut self) {
        self.frame += 1;
        self.done += 1;
    }

    /// Whether there are frames that were not rendered.
    pub fn is_broken_off(&self) -> bool {
        self.done < self.count
    }

    /// The frame, and the time left for all frames once a share of this one is done.
    fn message(&self, done: f64) -> String {
        let (frame, number, count) = (self.frame, self.done + 1, self.count);
        let share = (f64::from(self.done) + done) / f64::from(count);
        let left = self.began.elapsed().as_secs_f64() * (1.0 / share.max(1e-9) - 1.0);
        match self.done == 0 && done < 0.05 {
            true => format!("frame {frame} ({number} of {count})"),
            false => format!("frame {frame} ({number} of {count}, {left:.0} s to go)"),
        }
    }
}

enum Form {
    Quiet,
    Bar(ProgressBar),
    Lines(Lines),
}

/// The content of the last line; None before the first.
#[derive(Default)]
struct Lines(Option<Said>);

struct Said {
    tenths: u32,
    samples: u32,
    seconds: f64,
}

/// The number of seconds after which another line is printed, with any progress.
const LONGEST_SILENCE: f64 = 5.0;

/// The number of steps of the bar.
const STEPS: u64 = 1000;

impl Progress {
    pub fn new(quiet: bool, time: Option<Duration>) -> Self {
        let form = if quiet {
            Form::Quiet
        } else if std::io::stderr().is_terminal() {
            let bar = ProgressBar::new(STEPS);
            if let Ok(style) = ProgressStyle::with_template("{wide_bar} {percent} %  {msg}  {elapsed} (ETA {eta})") {
                bar.set_style(style);
            }
            Form::Bar(bar)
        } else {
            Form::Lines(Lines::default())
        };
        Self {
            form,
            time,
            sequence: None,
        }
    }

    /// The progress of a frame, together with that of the sequence.
    pub fn within(self, sequence: InSequence) -> Self {
        Self {
            sequence: Some(sequence),
            ..self
        }
    }

    pub fn update(&mut self, status: &RenderStatus) {
        let shown = self.shown(status);
        self.show(&shown);
    }

    /// Shows the end of the render. `status` belongs to the written picture.
    pub fn finish(&mut self, status: &RenderStatus) {
        let shown = self.shown(status);
        self.end(&shown);
    }

    /// Shows the progress of any work.
    pub fn show(&mut self, shown: &Shown) {
        match &mut self.form {
            Form::Quiet => {}
            Form::Bar(bar) => {
                bar.set_position((shown.done * STEPS as f64) as u64);
                bar.set_message(shown.message.clone());
            }
            Form::Lines(lines) => {
                if lines.is_due(shown) {
                    shown.print();
                }
            }
        }
    }

    /// Shows the end of any work.
    pub fn end(&mut self, shown: &Shown) {
        match &self.form {
            Form::Quiet => {}
            Form::Bar(bar) => bar.finish_and_clear(),
            Form::Lines(lines) => {
                if lines.lack_the_end(shown) {
                    shown.print();
                }
            }
        }
    }

    fn shown(&self, status: &RenderStatus) -> Shown {
        let done = self.done(status);
        Shown {
            done,
            samples: status.samples.saturating_sub(status.first),
            seconds: status.seconds,
            message: self.message(done, status),
        }
    }

    fn message(&self, done: f64, status: &RenderStatus) -> String {
        let picture = message(status, self.time);
        match &self.sequence {
            Some(sequence) => format!("{}  {picture}", sequence.message(done)),
            None => picture,
        }
    }

    /// The finished share of the render, from 0 to 1.
    fn done(&self, status: &RenderStatus) -> f64 {
        let by_time = self.time.map_or(0.0, |time| status.seconds / time.as_secs_f64());
        status.done().max(by_time).min(1.0)
    }
}

fn message(status: &RenderStatus, time: Option<Duration>) -> String {
    // A share of a picture counts samples of the whole picture; its own number is shown.
    let [samples, target] = [status.samples, status.target].map(|samples| samples.saturating_sub(status.first));
    let samples = match time.is_some() || status.target == u32::MAX {
        true => format!("{samples} spp"),
        false => format!("{samples}/{target} spp"),
    };
    let noise = match (status.noise, status.noise_target) {
        (Some(noise), Some(target)) => format!("  noise {noise:.4}/{target}"),
        _ => String::new(),
    };
    format!("{samples}{noise}  {:.2} Msamples/s", status.msamples_per_s)
}

impl Shown {
    fn print(&self) {
        let Self {
            done, seconds, message, ..
        } = self;
        let percent = (100.0 * done) as u32;
        let left = match *done > 0.0 {
            true => format!(", {:.1} s to go", seconds * (1.0 / done - 1.0)),
            false => String::new(),
        };
        report::line(format_args!("{percent:3} %  {message}  {seconds:.1} s{left}"));
    }
}

impl Lines {
    /// Whether a line is due before the end; it is then counted as printed.
    fn is_due(&mut self, shown: &Shown) -> bool {
        if shown.done >= 1.0 {
            return false;
        }
        let tenths = (10.0 * shown.done) as u32;
        let is_due = match &self.0 {
            // The line about the first samples also shows when an interrupt leaves a whole picture.
            None => shown.samples > 0 || tenths > 0,
            Some(said) => tenths > said.tenths || shown.seconds >= said.seconds + LONGEST_SILENCE,
        };
        if is_due {
            self.0 = Some(Said {
                tenths,
                samples: shown.samples,
                seconds: shown.seconds,
            });
        }
        is_due
    }

    /// Whether there are new samples since the last line.
    fn lack_the_end(&self, shown: &Shown) -> bool {
        self.0.as_ref().map_or(0, |said| said.samples) != shown.samples
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_come_every_few_seconds_and_the_last_one_has_the_final_samples() {
        let mut lines = Lines::default();
        let at = |done: f64, samples, seconds| Shown {
            done,
            samples,
            seconds,
            message: String::new(),
        };
        let status = |samples, seconds| at(f64::from(samples) / 1000.0, samples, seconds);
        let said: Vec<bool> = [
            (0, 4.0),
            (1, 5.0),
            (2, 6.0),
            (3, 9.9),
            (4, 10.0),
            (99, 10.1),
            (100, 10.2),
            (199, 15.1),
            (200, 15.3),
        ]
        .map(|(samples, seconds)| lines.is_due(&status(samples, seconds)))
        .to_vec();
        assert_eq!(said, [false, true, false, false, true, false, true, false, true]);
        assert!(!lines.lack_the_end(&status(200, 16.0)));
        assert!(lines.lack_the_end(&status(201, 16.0)));
        assert!(!Lines::default().lack_the_end(&status(0, 16.0)));
        // The end of the time may come before the last samples.
        assert!(!lines.is_due(&at(1.0, 201, 17.0)));
        assert!(Lines::default().lack_the_end(&status(1, 16.0)));
    }
}
