//! `sunroom completions` and `sunroom man`: what shells and readers of manuals need, generated from the definitions of the command line.

use std::path::PathBuf;
use std::process::ExitCode;

use clap::{Args, Command};

use super::{outputs, report};

#[derive(Args)]
pub struct CompletionsArgs {
    /// Shell whose completions are printed on standard output
    shell: clap_complete::Shell,
}

#[derive(Args)]
pub struct ManArgs {
    /// Folder that gets one page for each command
    folder: PathBuf,
}

pub fn completions(mut program: Command, args: CompletionsArgs) -> ExitCode {
    let mut script = Vec::new();
    clap_complete::generate(args.shell, &mut program, "sunroom", &mut script);
    match outputs::print(&script) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => report::error(format_args!("standard output: {error}")),
    }
}

pub fn man(program: Command, args: ManArgs) -> ExitCode {
    let written = std::fs::create_dir_all(&args.folder).and_then(|()| clap_mangen::generate_to(program, &args.folder));
    match written {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => report::error(format_args!("{}: {error}", args.folder.display())),
    }
}
