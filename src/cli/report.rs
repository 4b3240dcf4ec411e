//! Messages to the user, on standard error.

use std::fmt::Display;
use std::io::IsTerminal;
use std::path::Path;
use std::process::ExitCode;

use sunroom::document::Diagnostics;
use sunroom::render::denoise::DenoiseError;

/// The exit code for a wrong command line, as in clap.
pub const WRONG_USAGE: u8 = 2;

/// The number with its noun: `1 shape`, `2 shapes`.
pub fn counted(number: impl Display, what: &str) -> String {
    let number = number.to_string();
    let ending = if number == "1" { "" } else { "s" };
    format!("{number} {what}{ending}")
}

/// The reason why a command fails.
pub enum Failure {
    /// The command line is wrong.
    Usage(String),
    /// A scene, a file or the machine is at fault.
    Fault(Box<dyn std::error::Error>),
}

impl<E: Into<Box<dyn std::error::Error>>> From<E> for Failure {
    fn from(error: E) -> Self {
        Self::Fault(error.into())
    }
}

impl Failure {
    /// Prints `error: ...` and returns the exit code.
    pub fn report(self) -> ExitCode {
        match self {
            Self::Usage(message) => wrong_usage(message),
            Self::Fault(cause) => error(cause),
        }
    }
}

/// How to render without a denoiser.
pub const RENDERS_WITHOUT: &str = "leave --denoise out";

/// Refuses denoising if the program has no denoiser. `otherwise` says how the command works without it.
pub fn check_denoiser(denoise: bool, otherwise: &str) -> Result<(), Failure> {
    match denoise && !cfg!(feature = "denoise") {
        true => Err(Failure::Usage(format!("{}; {otherwise}", DenoiseError::NotBuilt))),
        false => Ok(()),
    }
}

/// Prints `error: ...` and returns the exit code for a wrong command line.
pub fn wrong_usage(message: impl Display) -> ExitCode {
    error(message);
    ExitCode::from(WRONG_USAGE)
}

/// Prints `error: ...` and returns the exit code for a fault of a scene or a file.
pub fn error(message: impl Display) -> ExitCode {
    line(format_args!("error: {message}"));
    ExitCode::FAILURE
}

pub use sunroom::app::terminal::line;

/// Prints the messages about a scene with the lines that they are about.
pub fn diagnostics(diagnostics: &Diagnostics) {
    if !diagnostics.list.is_empty() {
        let color = std::io::stderr().is_terminal() && std::env::var_os("NO_COLOR").is_none();
        line(diagnostics.render(color).trim_end());
    }
}

/// Prints the last line about a scene without errors, but with warnings that `--strict` counts as errors.
pub fn refused_for_warnings(scene: &Path) {
    line(format_args!("{}: refused for its warnings", scene.display()));
}

/// Prints the last line about a scene whose only errors are missing files.
pub fn refused_for_missing(scene: &Path) {
    line(format_args!(
        "{}: refused because files are missing; --allow-missing does without them",
        scene.display()
    ));
}

/// Whether the scene is accepted: no errors, and if `strict` no warnings.
pub fn acceptable(diagnostics: &Diagnostics, strict: bool) -> bool {
    !diagnostics.has_errors() && (!strict || diagnostics.warning_count() == 0)
}
