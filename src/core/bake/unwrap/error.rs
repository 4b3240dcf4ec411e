//! Why meshes cannot be laid out in lightmaps, with advice.

use crate::memory::Shortage;

/// The most texels of all lightmaps together.
pub(super) const MOST_TEXELS: f64 = (1u64 << 30) as f64;

/// The reason why meshes cannot be unwrapped.
#[derive(Debug, PartialEq, thiserror::Error)]
#[allow(missing_docs, reason = "the messages say what the variants mean")]
pub enum UnwrapError {
    #[error("nothing in the level has a surface that a lightmap could lie on")]
    Nothing,
    #[error("a lightmap of {0} texels: the width is between 16 and 16384")]
    AtlasSize(u32),
    #[error("{0} texels per unit: the number has to be above 0")]
    TexelsPerUnit(f32),
    #[error("`{0}` has vertices that are no numbers: mend its mesh, or give it a lightmap scale of 0")]
    Broken(String),
    #[error("`{0}` has no surface that a lightmap could lie on: give it a lightmap scale of 0")]
    Flat(String),
    /// The suggested number of texels per unit is about the largest with which the shape fits.
    #[error(
        "`{name}` needs {width} x {height} texels, and a lightmap has {size} x {size}: take larger lightmaps, or at most about {texels_per_unit} texels per unit, or a smaller lightmap scale for this shape"
    )]
    TooLarge {
        name: String,
        width: u32,
        height: u32,
        size: u32,
        texels_per_unit: f32,
    },
    #[error(
        "`{name}` has so many pieces that a lightmap of {size} x {size} texels has no room for them: take larger lightmaps, or give the shape a lightmap scale of 0"
    )]
    TooManyPieces { name: String, size: u32 },
    #[error(
        "the level needs {} texels, of which `{largest}` has the most, and at most {} are possible: take fewer texels per unit, or a smaller lightmap scale for this shape",
        number(*texels),
        number(MOST_TEXELS)
    )]
    TooMany { texels: f64, largest: String },
    #[error("the lightmaps need {0}; fewer texels per unit or smaller lightmaps need less")]
    Memory(#[from] Shortage),
    #[error("the shapes cannot be laid out: {0}")]
    Other(String),
    #[error("interrupted")]
    Cancelled,
}

/// A whole number in words; from 1e15 on it is rounded to two digits, such as 4.2e24.
fn number(number: f64) -> String {
    match number < 1e15 {
        true => format!("{number:.0}"),
        false => format!("about {number:.1e}"),
    }
}
