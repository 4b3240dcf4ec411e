//! Materials of surfaces: scattering models whose parameters may be textured, and materials made of other materials.
//!
//! At a hit the table resolves textures and nesting once, into a [`Scattering`]: plain models with their weights, which
//! light transport evaluates and samples in world space. Constant parameters are already in range; textured ones are
//! clamped here.

mod bump;
mod definition;
mod lookup;
mod nesting;
mod principled;
mod scattering;
mod table;
mod tangents;
mod textured;

pub use bump::BumpOptions;
pub(crate) use bump::BumpShadow;
pub use definition::{Material, MaterialId};
pub use lookup::{TexturedBase, TexturedFacets, TexturedSpecular};
pub use nesting::{MaterialTableError, NestingProblem};
pub use principled::{TexturedPrincipled, TexturedPrincipledThin};
pub use scattering::{Lobe, ScatterSample, Scattering, Single};
pub use table::{MaterialTable, PlainSide};
pub use textured::TexturedBsdf;
