//! `sunroom bench`: the speed of this machine and this version, as tables and as JSON with which a later run can be
//! compared.
//!
//! Machines are shared and noisy: figures are medians over rounds, and only runs on an otherwise idle machine can be
//! compared.

mod args;
mod compare;
mod rays;
mod renders;
mod results;

use std::path::PathBuf;
use std::process::ExitCode;

use clap::{Args, Subcommand};
use sunroom::files::keep_reads;

use super::outputs;
use super::report::Failure;
use args::{CommonArgs, RayBenchArgs, RenderBenchArgs};
use results::{Error, Results};

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

pub fn run(args: &BenchArgs) -> Result<ExitCode, Failure> {
    let common = match &args.subject {
        None => &args.renders.common,
        Some(Subject::Rays(args)) => &args.common,
    };
    common.memory.apply();
    common.threads.report_limit();
    keep_reads();
    let wrong = match &args.subject {
        None => renders::Plan::new(&args.renders).and_then(|plan| {
            let planned = plan.subjects();
            compared(&args.renders.common, plan.scenes(), &planned, || plan.measure())
        }),
        Some(Subject::Rays(args)) => rays::Plan::new(args).and_then(|plan| {
            let planned = plan.subjects();
            compared(&args.common, &plan.files(), &planned, || plan.measure())
        }),
    }?;
    match wrong {
        0 => Ok(ExitCode::SUCCESS),
        _ => Err(format!("wrong answers: {wrong}; are these rays of another mesh?").into()),
    }
}

/// Measures, prints and writes; returns the number of wrong answers. Errors are found before the measurement if
/// possible. `measured`: the measured files.
fn compared(
    common: &CommonArgs,
    measured: &[PathBuf],
    planned: &[compare::Subject],
    measure: impl FnOnce() -> Result<Results, Error>,
) -> Result<usize, Error> {
    let (written, read) = (common.json.as_slice(), common.against.as_slice());
    outputs::check_inputs_stay(written, read, "what it is compared with")?;
    outputs::check_inputs_stay(written, measured, "one of the files that are measured")?;
    let earlier = match &common.against {
        Some(path) => {
            let earlier = Results::read(path)?;
            compare::check(planned, &earlier, path)?;
            Some(earlier)
        }
        None => None,
    };
    let is_machine_only = common.json.as_deref().is_some_and(outputs::is_stdout);
    if let Some(path) = common.json.as_deref().filter(|_| !is_machine_only) {
        outputs::check_text(path)?;
    }
    let results = measure()?;
    if !is_machine_only {
        outputs::print(results.table().as_bytes())?;
        if let Some(earlier) = &earlier {
            outputs::print(compare::table(&results, earlier).as_bytes())?;
        }
    }
    if let Some(path) = &common.json {
        results.write(path)?;
    }
    Ok(results.rays.iter().map(|rays| rays.wrong).sum())
}
