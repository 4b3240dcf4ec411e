//! The reasons why a bake fails.

use std::path::PathBuf;

use super::level::LevelError;
use super::placement::PlacementError;
use super::volume::GridError;
use crate::gltf::write::GltfWriteError;
use crate::memory::Shortage;
use crate::render::denoise::DenoiseError;

/// The reason why a bake fails.
#[derive(Debug, thiserror::Error)]
#[allow(missing_docs, reason = "the messages say what the variants mean")]
pub enum BakeError {
    #[error(transparent)]
    Level(#[from] LevelError),
    #[error(transparent)]
    Export(#[from] GltfWriteError),
    #[error("no surface of the level is large enough for a texel: take more texels per unit")]
    NoTexels,
    /// A probe of the scene is impossible.
    #[error("{name}: {source}")]
    Probe { name: String, source: ProbeError },
    /// The irradiance volume around the level is impossible.
    #[error(transparent)]
    Grid(GridError),
    #[error("the probes need {0}; fewer or smaller ones need less")]
    Memory(#[from] Shortage),
    #[error("the sums of a share's groups of samples need {0}")]
    MemoryOfShare(Shortage),
    #[error("the layers need {0}; without --layers, with less --layer-memory or with fewer texels a bake needs less")]
    MemoryOfLayers(Shortage),
    #[error(transparent)]
    Denoise(#[from] DenoiseError),
    /// Cancelled before there was any light to write.
    #[error("interrupted before the first samples: nothing is written")]
    Cancelled,
    #[error("cannot write {}: {reason}", path.display())]
    Write { path: PathBuf, reason: String },
}

/// The reason why a probe is impossible.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[allow(missing_docs, reason = "the messages say what the variants mean")]
pub enum ProbeError {
    #[error(transparent)]
    Placement(#[from] PlacementError),
    #[error(transparent)]
    Grid(#[from] GridError),
}
