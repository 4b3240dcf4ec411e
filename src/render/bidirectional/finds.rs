//! What path tracing would make of the paths that bidirectional path tracing finds.

use glam::UVec2;

use super::Sample;
use crate::color::{Rgb, luminance};

/// A path with light, and what path tracing would make of it.
#[derive(Clone, Copy, Debug)]
pub(in crate::render) struct Find {
    /// The pixel that it brings light to; None for the sample's own.
    pub pixel: Option<UVec2>,
    /// The luminance that it has brought.
    pub light: f32,
    /// The luminance of the path by path tracing, whenever that finds it: its contribution over the density with which its ways find it. Infinite if it never does.
    ///
    /// The mean of `light * in_one` is the second moment that such paths have there, so that what path tracing finds once in a million samples need not be waited
    /// for.
    pub in_one: f32,
}

impl Sample<'_, '_> {
    /// Notes a path with light, if it is asked for. `whole` is its light without a weight, and `of_paths` the sum of the squared densities of path tracing's ways
    /// relative to that by which it was found.
    pub(super) fn note(&mut self, pixel: Option<UVec2>, light: Rgb, whole: Rgb, of_paths: impl FnOnce() -> f32) {
        let Some(finds) = &mut self.finds else { return };
        let light = luminance(light);
        if light > 0.0 && light.is_finite() {
            let in_one = luminance(whole) / of_paths().sqrt();
            finds.push(Find { pixel, light, in_one });
        }
    }
}
