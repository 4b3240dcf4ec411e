//! Reusable vectors for collecting elements.
//!
//! A vector that grows and is then shrunk leaves a hole behind it in memory. With a million small ones the holes take
//! as much as the vectors do. Elements are therefore collected in a spare vector and moved into one of the right size.

use crate::document::{Child, Property, TransformOp};

/// The length above which a vector is shrunk in place.
const LONGEST: usize = 64;

/// Empty vectors with spare capacity.
#[derive(Default)]
pub(super) struct Spare {
    pub properties: Pool<Property>,
    pub children: Pool<Child>,
    pub steps: Pool<TransformOp>,
}

/// Vectors for reuse, at most as many as tags can be nested.
pub(super) struct Pool<T>(Vec<Vec<T>>);

impl<T> Default for Pool<T> {
    fn default() -> Self {
        Self(Vec::new())
    }
}

impl<T> Pool<T> {
    /// An empty vector.
    pub fn take(&mut self) -> Vec<T> {
        self.0.pop().unwrap_or_default()
    }

    /// Moves the elements into a vector without spare capacity.
    pub fn fitted(&mut self, mut full: Vec<T>) -> Vec<T> {
        if full.len() > LONGEST {
            full.shrink_to_fit();
            return full;
        }
        let mut fitted = Vec::with_capacity(full.len());
        fitted.append(&mut full);
        self.0.push(full);
        fitted
    }
}
