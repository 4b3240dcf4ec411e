//! Path guiding: directions that paths take because light comes from there, and not by the bsdf alone (Jensen,
//! "Importance Driven Path Tracing Using the Photon Map", 1995).
//!
//! The guide is learnt from photons: paths from the lights, with random numbers of their own. What they tell of a place
//! is what comes to it from other surfaces; light that comes straight from a lamp is found by sampling lamps. The
//! density of photons is that of light times cosine, which is what a diffuse surface needs. They are no samples of the
//! picture, so that it stays without bias, and they know nothing of the camera, so that a guide belongs to the scene.

mod bins;
mod cell;
mod field;
mod store;

pub(super) use self::bins::BinLanes;
pub(super) use self::cell::UNITS;
pub(super) use self::field::{Field, PhotonArrival};
pub use self::store::Guide;
pub(super) use self::store::{PhotonPaths, Photons};

/// The paths from the lights that a guide is learnt from: some 0.2 seconds of one thread.
const PATHS: u32 = 1 << 16;
/// What is kept of a path at most: paths may be far longer where the roulette begins late.
pub(super) const MOST_OF_PATH: usize = 64;
