//! The measurements of the monkey, and the verdict on them.

use std::collections::BTreeMap;
use std::fmt::{self, Display, Formatter};
use std::time::Duration;

use super::frames::Span;
use super::gauge::Gauge;

/// A measurement of the process at a time of the run.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Mark {
    pub at: Duration,
    /// The share of the run that was done, 0 to 1.
    pub progress: f32,
    pub gauge: Gauge,
    pub entities: usize,
    pub steps: usize,
    /// The longest frame since the last mark.
    pub longest_frame: Duration,
    /// Whether a scene has just been opened and not edited yet: such marks are comparable.
    pub at_start_of_round: bool,
}

/// A frame of the window's own systems, without the monkey's own work.
#[derive(Clone, Debug, Default)]
pub struct Frame {
    /// The duration of the frame.
    pub time: Span,
    /// The time since the run began.
    pub at: Duration,
    /// The command that was applied in it.
    pub doing: String,
    /// The number of threads of the machine that were ready to run, for each core.
    pub load: f32,
}

/// The number of threads ready to run for each core above which a frame is judged by its time on a core: threads that
/// hold locks of the window have to wait as well then.
const BUSY: f32 = 2.0;

impl Frame {
    fn judged(&self) -> Duration {
        if self.load > BUSY {
            self.time.computed
        } else {
            self.time.own
        }
    }
}

/// All results that are reported.
#[derive(Default)]
pub(crate) struct Record {
    pub seed: u64,
    pub scenes: usize,
    pub has_window: bool,
    pub duration: Duration,
    pub frames: u64,
    pub rounds: usize,
    pub done: BTreeMap<&'static str, usize>,
    /// The number of commands that the editor refused with a message. That is no fault: many random commands make no
    /// sense.
    pub refused: usize,
    pub marks: Vec<Mark>,
    /// The longest frames, the longest first.
    pub longest: Vec<Frame>,
    /// The number of frames above the limit.
    pub frames_too_long: u64,
    /// The number of times that the scene was undone to its start and compared.
    pub undone_to_start: usize,
    /// The number of times that the scene was saved and opened again.
    pub opened_again: usize,
    /// The number of times that an awaited change of a file was noticed.
    pub noticed: usize,
    /// The faults in words, by criterion.
    pub faults: Vec<(Criterion, String)>,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Criterion {
    Undo,
    Saving,
    Files,
    /// The monkey itself could not continue.
    Run,
}

/// The limits above which a run has failed.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Bounds {
    /// The longest frame. None: frames are not judged.
    pub longest_frame: Option<Duration>,
}

/// Memory at the start of rounds may grow by this share of it and this many kB from the second quarter of the run to
/// the last. In a short run, or on a slow machine, caches that have a bound are still being filled: the pictures of 128
/// materials alone take some 25 MB.
const MEMORY_SHARE: f64 = 0.05;
const MEMORY_KB: u64 = 32 * 1024;
/// The number of threads and files by which the start of a round in the last quarter may exceed the most of the first
/// half. Pictures of materials are made on threads that come and go.
const MORE_THREADS: u64 = 3;
const MORE_FILES: u64 = 4;
/// The number of listed frames.
const FRAMES_LISTED: usize = 8;
/// The number of lines in the table of marks.
const MARKS_LISTED: usize = 60;

/// The result of one criterion.
pub struct Verdict {
    /// The name of the criterion.
    pub what: &'static str,
    /// Whether it holds. None: it was not judged.
    pub holds: Option<bool>,
    /// The figures behind it.
    pub text: String,
}

impl Record {
    pub fn note_frame(&mut self, frame: Frame, bounds: &Bounds) {
        self.frames += 1;
        if bounds.longest_frame.is_some_and(|longest| frame.judged() > longest) {
            self.frames_too_long += 1;
        }
        let place = self.longest.partition_point(|known| known.time.own >= frame.time.own);
        if place < FRAMES_LISTED {
            self.longest.insert(place, frame);
            self.longest.truncate(FRAMES_LISTED);
        }
    }

    pub fn fault(&mut self, criterion: Criterion, text: impl Into<String>) {
        self.faults.push((criterion, text.into()));
    }

    pub fn steps(&self) -> usize {
        self.done.values().sum()
    }

    /// The verdicts, one for each criterion.
    pub fn verdicts(&self, bounds: &Bounds) -> Vec<Verdict> {
        let of = |what, criterion, text: String| {
            let mut faults = self.faults.iter().filter(|(of, _)| *of == criterion);
            let first = faults.next();
            Verdict {
                what,
                holds: Some(first.is_none()),
                text: first.map_or(text, |(_, fault)| {
                    format!("{} faults, the first: {fault}", 1 + faults.count())
                }),
            }
        };
        vec![
            self.memory(),
            self.flat("threads", |gauge| gauge.threads, MORE_THREADS),
            self.flat("open files", |gauge| gauge.files, MORE_FILES),
            self.frames(bounds),
            of(
                "the saved scene opens again",
                Criterion::Saving,
                format!("{} times", self.opened_again),
            ),
            of(
                "undone to the start it is as at the start",
                Criterion::Undo,
                format!("{} times, and redone to the end as at the end", self.undone_to_start),
            ),
            of(
                "changes of the scene's file are noticed",
                Criterion::Files,
                format!("{} times", self.noticed),
            ),
            of(
                "the run came to its end",
                Criterion::Run,
                format!("{} steps", self.steps()),
            ),
        ]
    }

    /// The marks at the start of rounds within a part of the run.
    fn starts(&self, from: f32, to: f32) -> impl Iterator<Item = &Gauge> {
        let marks = self.marks.iter().filter(|mark| mark.at_start_of_round);
        let within = marks.filter(move |mark| (from..=to).contains(&mark.progress));
        within.map(|mark| &mark.gauge)
    }

    fn memory(&self) -> Verdict {
        let median = |from, to| {
            let mut values: Vec<u64> = self.starts(from, to).map(|gauge| gauge.memory_kb).collect();
            values.sort();
            values.get(values.len() / 2).copied()
        };
        let what = "memory is flat";
        let quarters = [(0.25, 0.5), (0.5, 0.75), (0.75, 1.0)];
        let [Some(second), Some(third), Some(last)] = quarters.map(|(from, to)| median(from, to)) else {
            return not_judged(what);
        };
        let allowed = |before: u64| (MEMORY_SHARE * before as f64) as u64 + MEMORY_KB;
        // A single allocation, such as the memory of the denoiser when it is first used, is no leak: a leak continues.
        let rises = |from: u64, to: u64| to > from + allowed(from) / 2;
        let goes_on = rises(second, third) && rises(third, last);
        Verdict {
            what,
            holds: Some(last <= second + allowed(second) || !goes_on && last <= 2 * second),
            text: format!(
                "medians at the start of rounds {}, {} and {} in the second, third and last quarter; more than {} is a leak if it goes on",
                megabytes(second),
                megabytes(third),
                megabytes(last),
                megabytes(second + allowed(second)),
            ),
        }
    }

    fn flat(&self, what: &'static str, value: fn(&Gauge) -> u64, more: u64) -> Verdict {
        let most = |from, to| self.starts(from, to).map(value).max();
        let (Some(before), Some(after)) = (most(0.0, 0.5), most(0.75, 1.0)) else {
            return not_judged(what);
        };
        Verdict {
            what,
            holds: Some(after <= before + more),
            text: format!(
                "at the start of rounds at most {before} in the first half, {after} in the last quarter; at most {more} more are allowed"
            ),
        }
    }

    fn frames(&self, bounds: &Bounds) -> Verdict {
        let what = "frames of the window's own systems";
        let Some(longest) = bounds.longest_frame else {
            return not_judged(what);
        };
        let found = self.longest.first().map_or(Duration::ZERO, |frame| frame.time.own);
        Verdict {
            what,
            holds: Some(self.frames_too_long == 0),
            text: format!(
                "the longest of {} took {} ms; {} took more than {} ms, or that on a core where the machine had more than {BUSY} threads for each",
                self.frames,
                found.as_millis(),
                self.frames_too_long,
                longest.as_millis()
            ),
        }
    }
}

fn not_judged(what: &'static str) -> Verdict {
    Verdict {
        what,
        holds: None,
        text: "not judged".to_owned(),
    }
}

fn megabytes(kb: u64) -> String {
    format!("{:.1} MB", kb as f64 / 1024.0)
}

fn clock(time: Duration) -> String {
    let seconds = time.as_secs();
    format!("{}:{:02}:{:02}", seconds / 3600, seconds / 60 % 60, seconds % 60)
}

impl Display for Record {
    fn fmt(&self, f: &mut Formatter) -> fmt::Result {
        writeln!(
            f,
            "monkey: seed {}, {} of time, {} steps in {} rounds, {} frames, {} scene{}, {}",
            self.seed,
            clock(self.duration),
            self.steps(),
            self.rounds,
            self.frames,
            self.scenes,
            if self.scenes == 1 { "" } else { "s" },
            if self.has_window {
                "in a window"
            } else {
                "without a window"
            },
        )?;
        let done = self.done.iter().map(|(kind, count)| format!("{kind} {count}"));
        writeln!(f, "done: {}", done.collect::<Vec<_>>().join(", "))?;
        writeln!(f, "commands that were refused with a reason: {}", self.refused)?;
        writeln!(f)?;
        writeln!(
            f,
            "     time     memory  threads  files  entities    steps  longest own frame"
        )?;
        let every = self.marks.len().div_ceil(MARKS_LISTED).max(1);
        let last = self.marks.len().saturating_sub(1);
        let mut longest = Duration::ZERO;
        for (number, mark) in self.marks.iter().enumerate() {
            longest = longest.max(mark.longest_frame);
            if number % every != 0 && number != last {
                continue;
            }
            writeln!(
                f,
                "{:>9} {:>10} {:>8} {:>6} {:>9} {:>8}  {:>14} ms",
                clock(mark.at),
                megabytes(mark.gauge.memory_kb),
                mark.gauge.threads,
                mark.gauge.files,
                mark.entities,
                mark.steps,
                longest.as_millis()
            )?;
            longest = Duration::ZERO;
        }
        writeln!(f)?;
        writeln!(
            f,
            "longest frames of the window's own systems, without the time in which other threads had the cores (with it; on a core; the machine's threads per core):"
        )?;
        for frame in &self.longest {
            writeln!(
                f,
                "{:>6} ms ({} ms; {} ms; {:.1}) at {}: {}",
                frame.time.own.as_millis(),
                frame.time.wall.as_millis(),
                frame.time.computed.as_millis(),
                frame.load,
                clock(frame.at),
                frame.doing
            )?;
        }
        Ok(())
    }
}

impl Display for Verdict {
    fn fmt(&self, f: &mut Formatter) -> fmt::Result {
        let word = match self.holds {
            Some(true) => "ok",
            Some(false) => "FAILED",
            None => "-",
        };
        write!(f, "{word:<6} {}: {}", self.what, self.text)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn record(memory: impl Fn(usize) -> u64) -> Record {
        let mark = |number: usize| Mark {
            at: Duration::from_secs(number as u64),
            progress: number as f32 / 100.0,
            gauge: Gauge {
                memory_kb: memory(number),
                threads: 10 + number as u64 % 2,
                files: 20 + number as u64 / 10,
            },
            entities: 0,
            steps: number,
            longest_frame: Duration::ZERO,
            at_start_of_round: number.is_multiple_of(3),
        };
        Record {
            marks: (0..=100).map(mark).collect(),
            ..Record::default()
        }
    }

    fn holds(record: &Record, what: &str) -> Option<bool> {
        let bounds = Bounds {
            longest_frame: Some(Duration::from_millis(250)),
        };
        let verdicts = record.verdicts(&bounds);
        verdicts.iter().find(|verdict| verdict.what == what).expect(what).holds
    }

    #[test]
    fn memory_that_rises_is_not_flat() {
        let flat = record(|number| 200_000 + number as u64 % 7 * 1000);
        assert_eq!(holds(&flat, "memory is flat"), Some(true));
        assert_eq!(holds(&flat, "threads"), Some(true));
        // 24 in the first half and 29 in the last quarter.
        assert_eq!(holds(&flat, "open files"), Some(false));
        let rising = record(|number| 200_000 + number as u64 * 2000);
        assert_eq!(holds(&rising, "memory is flat"), Some(false));
        // Something is allocated once, and something large.
        let once = |size: u64| record(move |number| 200_000 + if number > 55 { size } else { 0 });
        assert_eq!(holds(&once(90_000), "memory is flat"), Some(true));
        assert_eq!(holds(&once(300_000), "memory is flat"), Some(false));
        assert_eq!(holds(&Record::default(), "memory is flat"), None);
    }

    #[test]
    fn a_long_frame_fails_and_is_named() {
        let mut record = Record::default();
        let bounds = Bounds {
            longest_frame: Some(Duration::from_millis(250)),
        };
        for millis in [3, 300, 7] {
            let frame = Frame {
                time: Span {
                    own: Duration::from_millis(millis),
                    ..Span::default()
                },
                doing: format!("{millis}"),
                ..Frame::default()
            };
            record.note_frame(frame, &bounds);
        }
        assert_eq!(record.longest[0].doing, "300");
        assert_eq!(holds(&record, "frames of the window's own systems"), Some(false));
        let mut record = Record::default();
        let waits = Frame {
            time: Span {
                own: Duration::from_millis(700),
                computed: Duration::from_millis(20),
                ..Span::default()
            },
            load: 6.0,
            ..Frame::default()
        };
        record.note_frame(waits, &bounds);
        assert_eq!(holds(&record, "frames of the window's own systems"), Some(true));
    }
}
