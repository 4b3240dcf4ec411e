//! How far a render has come: a bar on a terminal; elsewhere a line when every pixel has a sample and one for each tenth; nothing when quiet.

use std::io::IsTerminal;
use std::time::Duration;

use indicatif::{ProgressBar, ProgressStyle};
use sunroom::engine::RenderStatus;

use super::report;

pub struct Progress {
    form: Form,
    /// What ends the render beside its samples.
    time: Option<Duration>,
}

enum Form {
    Quiet,
    Bar(ProgressBar),
    /// The tenths that have been reported; None before the first line.
    Lines(Option<u32>),
}

/// Steps of the bar.
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
            Form::Lines(None)
        };
        Self { form, time }
    }

    pub fn update(&mut self, status: &RenderStatus) {
        let by_samples = f64::from(status.samples) / f64::from(status.target.max(1));
        let by_time = self.time.map_or(0.0, |time| status.seconds / time.as_secs_f64());
        let done = by_samples.max(by_time).min(1.0);
        let samples = match self.time {
            Some(_) => format!("{} spp", status.samples),
            None => format!("{}/{} spp", status.samples, status.target),
        };
        let message = format!("{samples}  {:.2} Msamples/s", status.msamples_per_s);
        match &mut self.form {
            Form::Quiet => {}
            Form::Bar(bar) => {
                bar.set_position((done * STEPS as f64) as u64);
                bar.set_message(message);
            }
            Form::Lines(reported) => {
                let tenths = (10.0 * done) as u32;
                // The line about the first samples also tells when an interrupt leaves a whole picture.
                let is_first = reported.is_none() && status.samples > 0;
                if is_first || tenths > reported.unwrap_or(0) {
                    *reported = Some(tenths);
                    let left = status.seconds * (1.0 / done - 1.0);
                    let percent = 10 * tenths;
                    report::line(format_args!(
                        "{percent:3} %  {message}  {:.1} s, {left:.1} s to go",
                        status.seconds
                    ));
                }
            }
        }
    }

    pub fn finish(&self) {
        if let Form::Bar(bar) = &self.form {
            bar.finish_and_clear();
        }
    }
}
