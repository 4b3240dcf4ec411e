//! `sunroom bench`: how fast this machine and this version are, as tables and as JSON that a later run can be compared with.
//!
//! Machines are shared and noisy: figures are medians over rounds, and a comparison means something only between runs on a machine that had
//! nothing else to do.

mod compare;
mod rays;
mod renders;
mod results;

use std::path::PathBuf;
use std::process::ExitCode;

use clap::{Args, Subcommand};

use super::{MemoryArgs, ThreadArgs, parse, report};
use results::Results;

#[derive(Args)]
#[command(args_conflicts_with_subcommands = true)]
pub struct BenchArgs {
    #[command(subcommand)]
    subject: Option<Subject>,
    #[command(flatten)]
    renders: RenderBenchArgs,
}

#[derive(Subcommand)]
enum Subject {
    /// Rays against one mesh, with a check of every answer
    Rays(RayBenchArgs),
}

#[derive(Args)]
struct RenderBenchArgs {
    /// Scene files [default: all of the folder `scenes`]
    scenes: Vec<PathBuf>,
    /// Samples per pixel
    #[arg(short, long, default_value_t = 16, value_parser = clap::value_parser!(u32).range(1..))]
    spp: u32,
    /// Size of the pictures
    #[arg(long, value_name = "WxH", default_value = "800x600", value_parser = parse::size)]
    size: (u32, u32),
    #[command(flatten)]
    common: CommonArgs,
}

#[derive(Args)]
struct RayBenchArgs {
    /// OBJ or PLY file
    #[arg(long, value_name = "FILE")]
    mesh: PathBuf,
    /// Rays with their answers; may be given several times
    #[arg(long, value_name = "FILE", required = true)]
    rays: Vec<PathBuf>,
    #[command(flatten)]
    common: CommonArgs,
}

#[derive(Args)]
struct CommonArgs {
    /// How often everything is measured
    #[arg(long, default_value_t = 3, value_parser = clap::value_parser!(u32).range(1..))]
    rounds: u32,
    #[command(flatten)]
    threads: ThreadArgs,
    #[command(flatten)]
    memory: MemoryArgs,
    /// Write the results to this file; - is standard output, in place of the table
    #[arg(long, value_name = "FILE")]
    json: Option<PathBuf>,
    /// Compare with the results that an earlier run wrote
    #[arg(long, value_name = "FILE")]
    against: Option<PathBuf>,
}

type Error = Box<dyn std::error::Error>;

pub fn run(args: BenchArgs) -> ExitCode {
    let common = match &args.subject {
        None => &args.renders.common,
        Some(Subject::Rays(args)) => &args.common,
    };
    common.memory.apply();
    common.threads.report_limit();
    let outcome = match &args.subject {
        None => renders::Plan::new(&args.renders).and_then(|plan| {
            let planned = plan.subjects();
            compared(&args.renders.common, &planned, || plan.measure())
        }),
        Some(Subject::Rays(args)) => rays::Plan::new(args).and_then(|plan| {
            let planned = plan.subjects();
            compared(&args.common, &planned, || plan.measure())
        }),
    };
    match outcome {
        Ok(0) => ExitCode::SUCCESS,
        Ok(wrong) => report::error(format_args!("wrong answers: {wrong}; are these rays of another mesh?")),
        Err(error) => report::error(error),
    }
}

/// Measures, prints and writes; how many answers were wrong. What would fail afterwards is an error before.
fn compared(
    common: &CommonArgs,
    planned: &[compare::Subject],
    measure: impl FnOnce() -> Result<Results, Error>,
) -> Result<usize, Error> {
    let earlier = match &common.against {
        Some(path) => {
            let earlier = Results::read(path)?;
            compare::check(planned, &earlier, path)?;
            Some(earlier)
        }
        None => None,
    };
    let is_machine_only = common.json.as_deref().is_some_and(super::outputs::is_stdout);
    if let Some(path) = common.json.as_deref().filter(|_| !is_machine_only) {
        super::outputs::check_text(path)?;
    }
    let results = measure()?;
    if !is_machine_only {
        super::outputs::print(results.table().as_bytes())?;
        if let Some(earlier) = &earlier {
            super::outputs::print(compare::table(&results, earlier).as_bytes())?;
        }
    }
    if let Some(path) = &common.json {
        results.write(path)?;
    }
    Ok(results.rays.iter().map(|rays| rays.wrong).sum())
}

/// Of an odd number the middle one, else the mean of the two in the middle; not a number of none.
fn median(values: impl IntoIterator<Item = f64>) -> f64 {
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
