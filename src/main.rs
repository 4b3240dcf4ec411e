//! The `sunroom` program.

extern crate sunroom_core;

mod cli;

fn main() -> std::process::ExitCode {
    cli::run()
}
