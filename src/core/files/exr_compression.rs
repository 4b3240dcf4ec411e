//! The compressions of OpenEXR files: scenes name them, and the renderer writes with them.

declare_names! {
    /// The compression methods of OpenEXR.
    #[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
    pub enum ExrCompression {
        /// Uncompressed.
        None = "none" => "none",
        /// Runs of equal bytes.
        Rle = "rle" => "rle",
        /// Deflate, row by row.
        Zips = "zips" => "zips",
        /// Deflate of 16 rows at a time.
        #[default]
        Zip = "zip" => "zip",
        /// Wavelets, lossless; best for noise.
        Piz = "piz" => "piz, for noise",
        /// Floats lose their last eight bits; other types are lossless.
        Pxr24 = "pxr24" => "pxr24, with loss",
        /// Halves in blocks of a fixed size, lossy; other types are not compressed.
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
    /// Whether floats are stored without loss.
    pub fn keeps_floats(self) -> bool {
        !matches!(self, Self::Pxr24 | Self::Dwaa | Self::Dwab)
    }

    /// Whether float channels whose names end in `.Y` are taken for luminances and compressed with the loss that is
    /// meant for colours: the method looks only at the last part of a name, whatever the layer is (`Classifier` in
    /// OpenEXR's `internal_dwa_classifier.h`).
    pub fn takes_y_for_luminance(self) -> bool {
        matches!(self, Self::Dwaa | Self::Dwab)
    }
}
