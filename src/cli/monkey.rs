//! The arguments of `sunroom edit --monkey`.

use std::path::PathBuf;
use std::time::Duration;

use clap::Args;

use super::parse;
#[cfg(feature = "window")]
use sunroom::app::editor::session::options::{Length, MonkeyOptions};

/// A time or a number of actions.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MonkeyLength {
    Time(Duration),
    Steps(usize),
}

/// `1h`, `2m`, or a number of actions without a unit.
fn length(text: &str) -> Result<MonkeyLength, String> {
    match text.parse() {
        Ok(0) => Err("expected a time or a number of acts above zero".to_owned()),
        Ok(steps) => Ok(MonkeyLength::Steps(steps)),
        Err(_) => parse::duration(text).map(MonkeyLength::Time),
    }
}

/// A time, or `none`.
fn limit(text: &str) -> Result<Limit, String> {
    match text {
        "none" => Ok(Limit(None)),
        text => Ok(Limit(Some(parse::duration(text)?))),
    }
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Limit(Option<Duration>);

#[derive(Args)]
pub struct MonkeyArgs {
    /// Let a monkey use the editor: random commands on copies of the scenes for a time (1h, 2m), or so many of them
    /// (5000); print a report
    #[arg(long, value_name = "TIME|N", value_parser = length, group = "unattended",
          conflicts_with_all = ["script", "screenshot", "measure_latency", "exit"])]
    pub monkey: Option<MonkeyLength>,
    /// Everything random comes from this number: the same number of acts with the same seed is the same run
    #[arg(long, value_name = "N", default_value_t = 1, requires = "monkey")]
    pub seed: u64,
    /// Write every act of the monkey, one a line, as in a script
    #[arg(long, value_name = "FILE", requires = "monkey")]
    pub monkey_log: Option<PathBuf>,
    /// The monkey fails if a frame of the window's own systems takes longer, waiting for a core not counted; none:
    /// frames are not judged
    #[arg(long, value_name = "TIME|none", default_value = "250ms", value_parser = limit, requires = "monkey")]
    pub longest_frame: Limit,
    /// The monkey plays without a window; frames are not judged
    #[arg(long, requires = "monkey")]
    pub no_window: bool,
    /// More scenes for the monkey
    #[arg(value_name = "SCENES", requires = "monkey")]
    pub more_scenes: Vec<PathBuf>,
}

#[cfg(feature = "window")]
impl MonkeyArgs {
    /// The options of the monkey; None if it is not requested.
    pub fn options(&self, scene: Option<&PathBuf>) -> Option<MonkeyOptions> {
        let length = match self.monkey? {
            MonkeyLength::Time(time) => Length::Time(time),
            MonkeyLength::Steps(steps) => Length::Steps(steps),
        };
        Some(MonkeyOptions {
            length,
            seed: self.seed,
            scenes: scene.into_iter().chain(&self.more_scenes).cloned().collect(),
            log: self.monkey_log.clone(),
            longest_frame: self.longest_frame.0.filter(|_| !self.no_window),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_length_is_a_time_or_a_number() {
        assert_eq!(length("2m"), Ok(MonkeyLength::Time(Duration::from_secs(120))));
        assert_eq!(length("5000"), Ok(MonkeyLength::Steps(5000)));
        assert!(length("0").is_err() && length("-1").is_err() && length("long").is_err());
        assert_eq!(limit("none"), Ok(Limit(None)));
        assert_eq!(limit("250ms"), Ok(Limit(Some(Duration::from_millis(250)))));
    }
}
