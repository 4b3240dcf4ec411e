//! Lines on standard error. Unlike `eprintln!` they do not end the program when standard error is closed, such as with
//! its terminal.

use std::fmt::Display;
use std::io::Write;

/// Prints one line. An error is ignored, since there is no other place to report it.
pub fn line(message: impl Display) {
    let _ = writeln!(std::io::stderr(), "{message}");
}
