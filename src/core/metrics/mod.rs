//! Measures of the difference between two pictures.
//!
//! Pictures are slices of linear Rec. 709 colours, row by row from the top left. One of the two is the reference.

mod convolution;
mod errors;
pub mod flip;
mod magma;
mod ssim;
mod z_scores;

pub use errors::{Errors, errors};
pub use magma::magma;
pub use ssim::ssim;
pub use z_scores::{ZScores, z_scores};

#[cfg(test)]
mod tests;
