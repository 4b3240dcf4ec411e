//! `sunroom convert`: loads a scene and writes it back, as the program understands it.

use std::path::PathBuf;
use std::process::ExitCode;

use clap::Args;
use sunroom::document;
use sunroom::scene::{read, write};

use super::{SceneArgs, report};

#[derive(Args)]
pub struct ConvertArgs {
    #[command(flatten)]
    scene: SceneArgs,
    /// Scene file to write
    #[arg(value_name = "OUT.xml")]
    output: PathBuf,
    /// Treat warnings as errors
    #[arg(long)]
    strict: bool,
}

pub fn run(args: ConvertArgs) -> ExitCode {
    let mut document = match document::load(&args.scene.scene, &args.scene.defines.defines) {
        Ok(document) => document,
        Err(error) => return report::error(error),
    };
    let scene = read::read(&mut document);
    report::diagnostics(&document.diagnostics);
    if !report::acceptable(&document.diagnostics, args.strict) {
        return ExitCode::FAILURE;
    }
    match write::write_anew(&scene, &args.output) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => report::error(error),
    }
}
