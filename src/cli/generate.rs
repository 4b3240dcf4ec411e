//! `sunroom completions` and `sunroom man`: completions for shells and manual pages, generated from the definitions of
//! the command line.

use std::path::{Path, PathBuf};
use std::process::ExitCode;

use clap::{Args, Command};
use clap_mangen::Man;
use sunroom::files::{FileSet, WriteError};

use super::outputs;
use super::report::Failure;

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

pub fn completions(mut program: Command, args: &CompletionsArgs) -> Result<ExitCode, Failure> {
    let mut script = Vec::new();
    clap_complete::generate(args.shell, &mut program, "sunroom", &mut script);
    outputs::print(&script).map_err(|error| format!("standard output: {error}"))?;
    Ok(ExitCode::SUCCESS)
}

pub fn man(program: Command, args: &ManArgs) -> Result<ExitCode, Failure> {
    let mut program = program.disable_help_subcommand(true);
    program.build();
    write_pages(&program, &args.folder)?;
    Ok(ExitCode::SUCCESS)
}

/// Writes the pages of a command and its subcommands, all or none.
fn write_pages(program: &Command, folder: &Path) -> Result<(), WriteError> {
    let failed = |source| WriteError {
        path: folder.to_owned(),
        source,
    };
    std::fs::create_dir_all(folder).map_err(failed)?;
    let place = |command: &Command| folder.join(Man::new(command.clone()).get_filename());
    let mut set = FileSet::new(&place(program));
    let mut waiting = vec![program];
    while let Some(command) = waiting.pop() {
        set.add_with(&place(command), |file| Man::new(command.clone()).render(file))?;
        waiting.extend(command.get_subcommands().filter(|below| !below.is_hide_set()));
    }
    set.replace()
}
