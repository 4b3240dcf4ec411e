//! The results of a benchmark: a table for people, and JSON for later runs.

use std::fmt::Write;
use std::path::Path;

use serde::{Deserialize, Serialize};
use sunroom::files::{self, LARGEST_NOTE};

/// The reason why a measurement cannot be made or compared.
pub type Error = Box<dyn std::error::Error>;

/// The version of the JSON format.
const VERSION: u32 = 1;

#[derive(Clone, Debug, Serialize, Deserialize, PartialEq)]
pub struct Results {
    pub version: u32,
    /// The version of the program that measured.
    pub program: String,
    pub threads: usize,
    /// None in older files without it.
    pub rounds: Option<u32>,
    #[serde(default)]
    pub renders: Vec<RenderResult>,
    #[serde(default)]
    pub rays: Vec<RayResult>,
}

/// One scene. Times are medians over the rounds, in seconds.
#[derive(Clone, Debug, Serialize, Deserialize, PartialEq)]
pub struct RenderResult {
    pub scene: String,
    pub width: u32,
    pub height: u32,
    pub spp: u32,
    /// The time of rendering, without loading and building.
    pub seconds: f64,
    /// The processor time of all threads, with loading and building. None if the system does not give it.
    pub cpu_seconds: Option<f64>,
    pub msamples_per_s: f64,
    pub mrays_per_s: f64,
    /// The relative error: the mean over the pixels of the squared error divided by the squared picture plus 0.01, see
    /// [`super::renders`].
    pub rel_mse: f64,
    /// `rel_mse` times `seconds`: the time for a given noise.
    pub cost: f64,
}

/// One set of rays against one mesh; rates are medians over the rounds, in 10^6 rays a second.
#[derive(Clone, Debug, Serialize, Deserialize, PartialEq)]
pub struct RayResult {
    pub mesh: String,
    pub rays: String,
    pub triangles: usize,
    pub count: usize,
    pub build_seconds: f64,
    /// The memory of BVH nodes and leaves, without the mesh itself.
    pub bytes_per_triangle: f64,
    /// The rate of single rays.
    pub closest: Rate,
    pub any: Rate,
    /// The rate in packets of sixteen rays. None in files from before it was measured.
    pub closest_together: Option<Rate>,
    pub any_together: Option<Rate>,
    /// The number of rays with wrong answers, singly or in packets.
    pub wrong: usize,
    /// The number of further rays with another triangle at the same distance, singly or in packets: rays through a
    /// common edge.
    pub ties: usize,
}

#[derive(Clone, Copy, Debug, Serialize, Deserialize, PartialEq)]
pub struct Rate {
    pub one_thread: f64,
    pub all_threads: f64,
}

impl Results {
    pub fn new(threads: usize, rounds: u32) -> Self {
        Self {
            version: VERSION,
            program: concat!("sunroom ", env!("CARGO_PKG_VERSION")).to_owned(),
            threads,
            rounds: Some(rounds),
            renders: Vec::new(),
            rays: Vec::new(),
        }
    }

    pub fn read(path: &Path) -> Result<Self, Error> {
        let place = path.display();
        let text = files::read_text(path, LARGEST_NOTE).map_err(|error| format!("{place}: {error}"))?;
        let results: Self = serde_json::from_str(&text).map_err(|error| {
            let (line, column) = (error.line(), error.column());
            format!("{place}:{line}:{column}: expected what `sunroom bench --json` writes: {error}")
        })?;
        if results.version != VERSION {
            let found = results.version;
            return Err(format!("{place}: expected results of version {VERSION}, found {found}").into());
        }
        Ok(results)
    }

    /// Replaces the file in one step.
    pub fn write(&self, path: &Path) -> Result<(), Error> {
        let text = serde_json::to_string_pretty(self)? + "\n";
        if super::super::outputs::is_stdout(path) {
            super::super::outputs::print(text.as_bytes())?;
        } else {
            files::write_atomically(path, text).map_err(|error| format!("{}: {error}", path.display()))?;
        }
        Ok(())
    }

    pub fn table(&self) -> String {
        let mut text = String::new();
        // Writing to a string does not fail.
        let _ = self.write_table(&mut text);
        text
    }

    fn write_table(&self, text: &mut String) -> std::fmt::Result {
        if !self.renders.is_empty() {
            writeln!(
                text,
                "{:36} {:>9} {:>9} {:>10} {:>9} {:>11} {:>13}",
                "scene", "seconds", "CPU s", "Msamples/s", "Mrays/s", "relMSE", "relMSE x s"
            )?;
        }
        for render in &self.renders {
            let cpu = render.cpu_seconds.map_or("-".to_owned(), |cpu| format!("{cpu:.2}"));
            writeln!(
                text,
                "{:36} {:>9.3} {cpu:>9} {:>10.2} {:>9.2} {:>11.6} {:>13.6}",
                render.scene, render.seconds, render.msamples_per_s, render.mrays_per_s, render.rel_mse, render.cost,
            )?;
        }
        if !self.renders.is_empty() {
            let renders = 2 * self.rounds.unwrap_or_default();
            writeln!(
                text,
                "medians of {renders} renders; CPU s: of all threads, loading included"
            )?;
        }
        for rays in &self.rays {
            writeln!(
                text,
                "{}, {} triangles: built in {:.3} s, {:.1} bytes per triangle\n  {}, {} rays: {} wrong, {} ties (another triangle at the same distance)",
                rays.mesh,
                rays.triangles,
                rays.build_seconds,
                rays.bytes_per_triangle,
                rays.rays,
                rays.count,
                rays.wrong,
                rays.ties,
            )?;
            let rates = [
                ("closest hit", Some(rays.closest)),
                ("closest hit, sixteen rays together", rays.closest_together),
                ("any hit", Some(rays.any)),
                ("any hit, sixteen rays together", rays.any_together),
            ];
            for (name, rate) in rates {
                let Some(rate) = rate else { continue };
                write!(text, "  {name:36} {:>8.2} Mrays/s with one thread", rate.one_thread)?;
                match self.threads {
                    1 => writeln!(text)?,
                    threads => writeln!(text, ", {:>8.2} with {threads}", rate.all_threads)?,
                }
            }
        }
        Ok(())
    }
}

/// The median: the mean of the two middle ones of an even number of values, and NaN for none.
pub fn median(values: impl IntoIterator<Item = f64>) -> f64 {
    let mut values: Vec<f64> = values.into_iter().collect();
    values.sort_by(f64::total_cmp);
    let middle = values.len() / 2;
    match values.len() {
        0 => f64::NAN,
        count if count % 2 == 1 => values[middle],
        _ => 0.5 * (values[middle - 1] + values[middle]),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn medians_are_in_the_middle() {
        assert_eq!(median([3.0, 1.0, 2.0]), 2.0);
        assert_eq!(median([4.0, 1.0, 2.0, 3.0]), 2.5);
        assert!(median([]).is_nan());
    }
}
