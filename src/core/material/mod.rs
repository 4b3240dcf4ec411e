//! Materials of surfaces: scattering models whose parameters may be textured, and materials made of other materials.
//!
//! At a hit the table resolves textures and nesting once, into a [`Scattering`]: plain models with the shares they
//! have. Light transport asks that, in world space. Numbers are in range already but for what textures say, which is
//! brought into range here.

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
