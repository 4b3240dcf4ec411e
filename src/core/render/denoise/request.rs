//! The input of the denoiser, and its errors.

use glam::Vec3;
use thiserror::Error;

use crate::color::Rgb;

/// The trade of quality for time. On a CPU the last two cost about the same.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum DenoiseQuality {
    /// The quality for a moving picture.
    Fast,
    /// Between the speed of `Fast` and the quality of `High`.
    Balanced,
    /// The best quality of the library.
    #[default]
    High,
}

/// A noisy picture, row by row from the top left. All slices are `width * height` long.
#[derive(Clone, Copy, Debug)]
pub struct DenoiseInput<'a> {
    /// The number of pixels in a row.
    pub width: u32,
    /// The number of rows.
    pub height: u32,
    /// Linear radiance, before exposure and tone mapping. NaN and infinite values are replaced before filtering.
    pub color: &'a [Rgb],
    /// The colour of the first surface that is not a mirror, in [0, 1] per component; 1 for mirrors that are not
    /// followed.
    pub albedo: Option<&'a [Rgb]>,
    /// The normal of the same surface in world space, of any length up to 1. It needs `albedo`.
    pub normal: Option<&'a [Vec3]>,
    /// Whether to denoise `albedo` and `normal` on their own first. Edges are better wherever these are noisy, at up to
    /// three times the time.
    pub prefilter: bool,
    /// The library's quality setting.
    pub quality: DenoiseQuality,
    /// The number of threads; `None` is one for each core.
    pub threads: Option<usize>,
}

impl DenoiseInput<'_> {
    /// Checks that the images have the same size, and that normals come with albedo.
    pub(super) fn check(&self) -> Result<(), DenoiseError> {
        let (width, height) = (self.width, self.height);
        let images = [
            ("color", Some(self.color)),
            ("albedo", self.albedo),
            ("normal", self.normal),
        ];
        for (what, pixels) in images {
            let len = pixels.map_or(self.color.len(), <[Vec3]>::len);
            if len != width as usize * height as usize {
                return Err(DenoiseError::WrongSize {
                    what,
                    len,
                    width,
                    height,
                });
            }
        }
        if self.normal.is_some() && self.albedo.is_none() {
            return Err(DenoiseError::NormalWithoutAlbedo);
        }
        Ok(())
    }
}

/// The reason why there is no denoised picture.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
#[allow(missing_docs, reason = "the messages say what the variants mean")]
pub enum DenoiseError {
    #[error("this program was built without the denoiser (cargo feature `denoise`)")]
    NotBuilt,
    /// The flag was set, which is not a fault.
    #[error("denoising was cancelled")]
    Cancelled,
    #[error("{what} has {len} pixels, the picture {width} x {height}")]
    WrongSize {
        what: &'static str,
        len: usize,
        width: u32,
        height: u32,
    },
    #[error("the denoiser takes normals only together with albedo")]
    NormalWithoutAlbedo,
    #[error("the denoiser finds no processor that it can run on: {0}")]
    NoDevice(String),
    #[error("the denoiser failed: {0}")]
    Failed(String),
}
