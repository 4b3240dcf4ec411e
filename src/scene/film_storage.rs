//! How a film asks to be stored in files.

use bevy::prelude::*;

use crate::files::ExrCompression;

/// The settings of `hdrfilm` about files. None where the scene does not say.
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

/// The kind of file for a picture whose file is not named.
#[derive(Reflect, Clone, Copy, Debug, PartialEq, Eq)]
pub enum PictureFormat {
    /// OpenEXR.
    OpenExr,
    /// Radiance.
    Rgbe,
    /// Portable float map.
    Pfm,
}

impl PictureFormat {
    /// The names in files, those that are written first.
    pub const NAMES: [(&str, Self); 4] = [
        ("openexr", Self::OpenExr),
        ("rgbe", Self::Rgbe),
        ("pfm", Self::Pfm),
        ("exr", Self::OpenExr),
    ];

    /// The name that is written.
    pub fn name(self) -> &'static str {
        match self {
            Self::OpenExr => "openexr",
            Self::Rgbe => "rgbe",
            Self::Pfm => "pfm",
        }
    }

    /// The ending of names of files, without its dot.
    pub fn extension(self) -> &'static str {
        match self {
            Self::OpenExr => "exr",
            Self::Rgbe => "hdr",
            Self::Pfm => "pfm",
        }
    }
}

/// The channels of a pixel.
#[derive(Reflect, Clone, Copy, Debug, PartialEq, Eq)]
pub enum PixelFormat {
    /// The luminance alone.
    Luminance,
    /// Luminance and opacity.
    LuminanceAlpha,
    /// Linear Rec. 709.
    Rgb,
    /// Linear Rec. 709 and opacity.
    Rgba,
    /// CIE XYZ.
    Xyz,
    /// CIE XYZ and opacity.
    Xyza,
}

impl PixelFormat {
    /// All of them.
    pub const ALL: [Self; 6] = [
        Self::Luminance,
        Self::LuminanceAlpha,
        Self::Rgb,
        Self::Rgba,
        Self::Xyz,
        Self::Xyza,
    ];

    /// The name in the file.
    pub fn name(self) -> &'static str {
        match self {
            Self::Luminance => "luminance",
            Self::LuminanceAlpha => "luminance_alpha",
            Self::Rgb => "rgb",
            Self::Rgba => "rgba",
            Self::Xyz => "xyz",
            Self::Xyza => "xyza",
        }
    }

    /// Whether pixels have an opacity.
    pub fn has_alpha(self) -> bool {
        matches!(self, Self::LuminanceAlpha | Self::Rgba | Self::Xyza)
    }
}

/// The precision of a channel.
#[derive(Reflect, Clone, Copy, Debug, PartialEq, Eq)]
pub enum ComponentFormat {
    /// Half precision.
    Float16,
    /// Single precision.
    Float32,
}

impl ComponentFormat {
    /// Both.
    pub const ALL: [Self; 2] = [Self::Float16, Self::Float32];

    /// The name in the file.
    pub fn name(self) -> &'static str {
        match self {
            Self::Float16 => "float16",
            Self::Float32 => "float32",
        }
    }
}
