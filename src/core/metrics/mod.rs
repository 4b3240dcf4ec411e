//! Figures of how much two pictures differ.
//!
//! Pictures are slices of linear Rec. 709 colours, row by row from the top left. One is the reference, which the other
//! is measured against.

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
