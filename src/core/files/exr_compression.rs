//! The compressions of OpenEXR files: scenes name them, and the renderer writes with them.

/// The ways in which OpenEXR makes files smaller.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum ExrCompression {
    /// Samples as they are.
    None,
    /// Runs of equal bytes.
    Rle,
    /// Deflate, row by row.
    Zips,
    /// Deflate of 16 rows at a time.
    #[default]
    Zip,
    /// Wavelets, without loss; best for noise.
    Piz,
    /// Floats lose their last eight bits; the rest is without loss.
    Pxr24,
    /// Halves in blocks of a fixed size, with loss; the rest is not compressed.
    B44,
    /// The method of [`Self::B44`], with smaller blocks where all pixels of a block are equal.
    B44a,
    /// A cosine transform of 32 rows at a time, with loss.
    Dwaa,
    /// A cosine transform of 256 rows at a time, with loss.
    Dwab,
}

impl ExrCompression {
    /// All methods in the order in which they are offered.
    pub const ALL: [Self; 10] = [
        Self::None,
        Self::Rle,
        Self::Zips,
        Self::Zip,
        Self::Piz,
        Self::Pxr24,
        Self::B44,
        Self::B44a,
        Self::Dwaa,
        Self::Dwab,
    ];

    /// The name on the command line and in scenes, as other programs call it.
    pub fn name(self) -> &'static str {
        match self {
            Self::None => "none",
            Self::Rle => "rle",
            Self::Zips => "zips",
            Self::Zip => "zip",
            Self::Piz => "piz",
            Self::Pxr24 => "pxr24",
            Self::B44 => "b44",
            Self::B44a => "b44a",
            Self::Dwaa => "dwaa",
            Self::Dwab => "dwab",
        }
    }

    /// Whether the bits of a float survive.
    pub fn keeps_floats(self) -> bool {
        !matches!(self, Self::Pxr24 | Self::Dwaa | Self::Dwab)
    }

    /// Whether floats in channels whose names end in `.Y` are taken for luminances and stored with the loss that the
    /// eye forgives in colours: the method decides by the last part of a name, whatever the layer is (`Classifier`
    /// in OpenEXR's `internal_dwa_classifier.h`).
    pub fn takes_y_for_luminance(self) -> bool {
        matches!(self, Self::Dwaa | Self::Dwab)
    }
}
