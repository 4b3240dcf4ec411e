//! Path guiding: paths sample directions from which light comes, not by the BSDF alone (Jensen, "Importance Driven Path
//! Tracing Using the Photon Map", 1995).
//!
//! The guide is learnt from photons of light paths with their own random numbers. At each point they measure the light
//! from other surfaces; light straight from a lamp is found by light sampling. The density of photons is that of light
//! times cosine, as a diffuse surface needs it. They are not samples of the picture, which stays unbiased, and they do
//! not depend on the camera, so that a guide belongs to the scene.

mod bins;
mod cell;
mod field;
mod store;

pub(super) use self::bins::BinLanes;
pub(super) use self::cell::UNITS;
pub(super) use self::field::{Field, PhotonArrival};
pub use self::store::Guide;
pub(super) use self::store::{PhotonPaths, Photons};

/// The light paths from which a guide is learnt: some 0.2 seconds of one thread.
const PATHS: u32 = 1 << 16;
/// The most photons kept per path: paths may be far longer where the roulette begins late.
pub(super) const MOST_OF_PATH: usize = 64;
