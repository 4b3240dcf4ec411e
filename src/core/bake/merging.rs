//! Merges the shares of a bake, with the same bits as a bake in one go.

use std::path::PathBuf;

use super::blueprint::Blueprint;
use super::lightmap::Lightmaps;
use super::part::{PartError, PartHeader, read_header, read_part};
use crate::memory::{self, Reservation, Shortage};
use crate::render::part::{Fault, FileDigest, fault};

/// The reason why shares cannot be merged.
#[derive(Debug, thiserror::Error)]
#[allow(missing_docs, reason = "the messages say what the variants mean")]
pub enum MergeError {
    #[error("there are no shares")]
    Nothing,
    #[error("{name}: {source}")]
    Part { name: String, source: PartError },
    #[error(
        "{0} is a checkpoint: `sunroom bake --resume` goes on with it, and a share is made by `sunroom bake --samples`"
    )]
    Checkpoint(String),
    #[error("{0} is not finished: resume it by `sunroom bake --samples ... --resume {0}`")]
    Unfinished(String),
    #[error("{name} is a share of another bake than {first}: {text}")]
    Foreign { name: String, first: String, text: String },
    #[error("{name} is a share of another bake than {first}: its texels or probes are others")]
    Other { name: String, first: String },
    #[error(transparent)]
    Samples(#[from] Fault),
    #[error("the lightmaps: {0}")]
    Memory(#[from] Shortage),
}

/// A merged bake.
#[derive(Debug)]
pub struct Merged {
    /// Everything but the light.
    pub blueprint: Blueprint,
    /// The light of the lightmaps, and then that of each probe.
    pub lights: Vec<Lightmaps>,
    /// The number of samples of each texel of a lightmap.
    pub samples: u32,
    /// The number of samples that was asked for; None if unknown.
    pub samples_of_whole: Option<u32>,
    /// The files of the scene.
    pub files: Vec<FileDigest>,
    _memory: Reservation,
}

/// Merges shares given in any order. `force` also merges shares of other scenes, settings or versions, as long as they
/// have the same texels.
pub fn merge(paths: &[PathBuf], force: bool) -> Result<Merged, MergeError> {
    let mut parts: Vec<(String, &PathBuf, PartHeader)> = Vec::new();
    for path in paths {
        let name = path.display().to_string();
        match read_header(path) {
            Ok(header) => parts.push((name, path, header)),
            Err(source) => return Err(MergeError::Part { name, source }),
        }
    }
    check(&parts, force)?;
    parts.sort_by_key(|(_, _, header)| header.samples);
    let origins = parts.iter().map(|(_, _, header)| &header.origin);
    let files: Vec<FileDigest> = origins.flat_map(|origin| origin.files.iter().cloned()).collect();
    let headers = || parts.iter().map(|(_, _, header)| header);
    let samples = headers().map(|header| header.samples[1]).max().unwrap_or(0);
    let samples_of_whole = headers().filter_map(|header| header.samples_of_whole).max();
    let mut merged: Option<Merged> = None;
    for (name, path, _) in &parts {
        let failed = |source| MergeError::Part {
            name: name.clone(),
            source,
        };
        // Memory for the file and the sums decoded from it.
        let length = std::fs::metadata(path).map_or(0, |file| file.len());
        let _share = memory::reserve(2 * length)?;
        let (_, blueprint, light) = read_part(path).map_err(failed)?;
        let blueprint = blueprint.ok_or_else(|| MergeError::Checkpoint(name.clone()))?;
        let Some(merged) = &mut merged else {
            merged = Some(Merged {
                _memory: memory::reserve(blueprint.memory_bytes())?,
                samples,
                samples_of_whole,
                files: files.clone(),
                blueprint,
                lights: light.lights,
            });
            continue;
        };
        let other = || MergeError::Other {
            name: name.clone(),
            first: parts[0].0.clone(),
        };
        let fits = match force {
            true => blueprint.has_texels_of(&merged.blueprint),
            false => blueprint == merged.blueprint,
        };
        if !fits {
            return Err(other());
        }
        for (sum, more) in merged.lights.iter_mut().zip(light.lights) {
            if !sum.append(more) {
                return Err(other());
            }
        }
    }
    merged.ok_or(MergeError::Nothing)
}

/// Refuses files that are no finished shares of one bake, and shares that do not cover all samples.
fn check(parts: &[(String, &PathBuf, PartHeader)], force: bool) -> Result<(), MergeError> {
    let Some((first_name, _, first)) = parts.first() else {
        return Err(MergeError::Nothing);
    };
    for (name, _, header) in parts {
        if !header.is_share {
            return Err(MergeError::Checkpoint(name.clone()));
        }
        if !header.is_finished {
            return Err(MergeError::Unfinished(name.clone()));
        }
        let differences = header.origin.differences(&first.origin);
        if !differences.is_empty() && !force {
            return Err(MergeError::Foreign {
                name: name.clone(),
                first: first_name.clone(),
                text: differences.join("; "),
            });
        }
    }
    let samples = parts.iter().map(|(name, _, header)| (name, header.samples));
    Ok(fault("share", samples, 0)?)
}
