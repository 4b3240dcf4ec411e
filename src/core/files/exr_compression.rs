//! The compressions of OpenEXR files: scenes name them, and the renderer writes with them.

declare_names! {
    /// The ways in which OpenEXR makes files smaller.
    #[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
    pub enum ExrCompression {
        /// Samples as they are.
        None = "none" => "none",
        /// Runs of equal bytes.
        Rle = "rle" => "rle",
        /// Deflate, row by row.
        Zips = "zips" => "zips",
        /// Deflate of 16 rows at a time.
        #[default]
        Zip = "zip" => "zip",
        /// Wavelets, without loss; best for noise.
        Piz = "piz" => "piz, for noise",
        /// Floats lose their last eight bits; the rest is without loss.
        Pxr24 = "pxr24" => "pxr24, with loss",
        /// Halves in blocks of a fixed size, with loss; the rest is not compressed.
        B44 = "b44" => "b44, with loss",
        /// The method of [`Self::B44`], with smaller blocks where all pixels of a block are equal.
        B44a = "b44a" => "b44a, with loss",
        /// A cosine transform of 32 rows at a time, with loss.
        Dwaa = "dwaa" => "dwaa, with loss",
        /// A cosine transform of 256 rows at a time, with loss.
        Dwab = "dwab" => "dwab, with loss",
    }
}

impl ExrCompression {
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
