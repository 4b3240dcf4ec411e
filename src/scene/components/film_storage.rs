//! How a film is stored in files.

use bevy::prelude::*;

use crate::files::ExrCompression;

/// The file settings of `hdrfilm`. None for settings that the scene does not give.
#[derive(Reflect, Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct FilmStorage {
    /// `pixel_format`.
    pub pixels: Option<PixelFormat>,
    /// `component_format`.
    pub components: Option<ComponentFormat>,
    /// `file_format`.
    pub file: Option<PictureFormat>,
    /// `compression`, which Mitsuba does not have.
    #[reflect(ignore)]
    pub compression: Option<ExrCompression>,
}

declare_names! {
    /// The kind of file for a picture whose file is not named.
    #[derive(Reflect, Clone, Copy, Debug, PartialEq, Eq)]
    pub enum PictureFormat {
        /// OpenEXR.
        OpenExr = "openexr",
        /// Radiance.
        Rgbe = "rgbe",
        /// Portable float map.
        Pfm = "pfm",
    }
}

impl PictureFormat {
    /// The names in files; those that are written come first.
    pub const NAMES: [(&str, Self); 4] = [
        ("openexr", Self::OpenExr),
        ("rgbe", Self::Rgbe),
        ("pfm", Self::Pfm),
        ("exr", Self::OpenExr),
    ];

    /// The file extension, without its dot.
    pub fn extension(self) -> &'static str {
        match self {
            Self::OpenExr => "exr",
            Self::Rgbe => "hdr",
            Self::Pfm => "pfm",
        }
    }
}

declare_names! {
    /// The channels of a pixel.
    #[derive(Reflect, Clone, Copy, Debug, PartialEq, Eq)]
    pub enum PixelFormat {
        /// The luminance alone.
        Luminance = "luminance",
        /// Luminance and opacity.
        LuminanceAlpha = "luminance_alpha",
        /// Linear Rec. 709.
        Rgb = "rgb",
        /// Linear Rec. 709 and opacity.
        Rgba = "rgba",
        /// CIE XYZ.
        Xyz = "xyz",
        /// CIE XYZ and opacity.
        Xyza = "xyza",
    }
}

impl PixelFormat {
    /// Whether pixels have an opacity.
    pub fn has_alpha(self) -> bool {
        matches!(self, Self::LuminanceAlpha | Self::Rgba | Self::Xyza)
    }
}

declare_names! {
    /// The precision of a channel.
    #[derive(Reflect, Clone, Copy, Debug, PartialEq, Eq)]
    pub enum ComponentFormat {
        /// Half precision.
        Float16 = "float16",
        /// Single precision.
        Float32 = "float32",
    }
}
