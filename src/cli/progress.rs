//! How far a render has come: a bar on a terminal, a line per tenth elsewhere, nothing when quiet.

use std::io::IsTerminal;

use indicatif::{ProgressBar, ProgressStyle};
use sunroom::engine::RenderStatus;

use super::report;

pub enum Progress {
    Quiet,
    Bar(ProgressBar),
    /// The tenths that have been reported.
    Lines(u32),
}

impl Progress {
    pub fn new(quiet: bool) -> Self {
        if quiet {
            Self::Quiet
        } else if std::io::stderr().is_terminal() {
            let bar = ProgressBar::new(0);
            let style = ProgressStyle::with_template("{wide_bar} {pos}/{len} spp  {msg}  {elapsed} (ETA {eta})");
            if let Ok(style) = style {
                bar.set_style(style);
            }
            Self::Bar(bar)
        } else {
            Self::Lines(0)
        }
    }

    pub fn update(&mut self, status: &RenderStatus) {
        let speed = format!("{:.2} Msamples/s", status.msamples_per_s);
        match self {
            Self::Quiet => {}
            Self::Bar(bar) => {
                bar.set_length(u64::from(status.target));
                bar.set_position(u64::from(status.samples));
                bar.set_message(speed);
            }
            Self::Lines(reported) => {
                let tenths = (10 * u64::from(status.samples) / u64::from(status.target.max(1))) as u32;
                if tenths > *reported {
                    *reported = tenths;
                    let left = status.seconds * f64::from(status.target - status.samples.min(status.target))
                        / f64::from(status.samples.max(1));
                    report::line(format_args!(
                        "{:3} %  {}/{} spp  {speed}  {:.1} s, {left:.1} s to go",
                        10 * tenths,
                        status.samples,
                        status.target,
                        status.seconds
                    ));
                }
            }
        }
    }

    pub fn finish(&self) {
        if let Self::Bar(bar) = self {
            bar.finish_and_clear();
        }
    }
}
