//! Checkpoints and shares of a bake: the exact sums of the samples so far. A bake is resumed from a checkpoint; shares
//! are merged.
//!
//! The file is `SUNBAKE`, a line feed, and a state in the format of pictures: the header; in a share, the blueprint;
//! and the sums.

use std::io::{self, Read, Seek, Take};
use std::path::Path;
use std::sync::atomic::AtomicBool;
use std::time::Duration;

use glam::DVec3;
use serde::{Deserialize, Serialize};

use super::blueprint::Blueprint;
use super::error::BakeError;
use super::job::{BakeJob, Watch};
use super::layers::Division;
use super::lightmap::{BLOCK, Lightmaps, TexelSum};
use super::limits::BakeLimits;
use crate::files::{self, FileError, LARGEST_DATA, write_atomically_with};
use crate::memory;
use crate::render::bytes::{Damaged, Reader, Writer};
use crate::render::part::{FORMAT, Origin, PartError as StateError, StateWriter, open_state, write_state};
use crate::render::passes::chunks_in;

const MAGIC: &[u8; 8] = b"SUNBAKE\n";
/// Bytes of the sums of a texel.
const TEXEL: usize = 4 * 8 + 4;
/// Bytes of the light of a layer at a texel.
const LAYER: usize = 3 * 8;

/// What a file holds.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct PartHeader {
    /// The scene, settings and version on which the samples depend.
    pub origin: Origin,
    /// The range of samples of each texel of a lightmap: the first, and the end of the samples asked for.
    pub samples: [u32; 2],
    /// The number of samples of each texel in the whole bake; None if unknown.
    #[serde(default)]
    pub samples_of_whole: Option<u32>,
    /// Whether all samples asked for are there.
    pub is_finished: bool,
    /// Whether the file is a share, which has a blueprint.
    pub is_share: bool,
    /// The layers of the light, whose sums follow on those of the whole.
    #[serde(default, skip_serializing_if = "Division::is_none")]
    pub division: Division,
}

/// The sums in a file.
#[derive(Clone, Debug, PartialEq)]
pub struct PartLight {
    /// The light of the lightmaps, followed by that of each probe.
    pub lights: Vec<Lightmaps>,
    /// The time spent gathering each element of `lights`.
    pub spent: Vec<Duration>,
}

/// The reason why a file cannot be read. The messages do not name the file.
#[derive(Debug, thiserror::Error)]
#[allow(missing_docs, reason = "the messages say what the variants mean")]
pub enum PartError {
    #[error(transparent)]
    File(#[from] FileError),
    #[error(transparent)]
    Io(#[from] io::Error),
    #[error("it is no checkpoint or share of a bake, which begins with `SUNBAKE`")]
    Foreign,
    #[error("it was written by another version of Sunroom: its format is {0}, and this version reads {FORMAT}")]
    Format(u32),
    #[error("it is damaged: its content and its checksum do not belong together")]
    Damaged,
}

impl From<Damaged> for PartError {
    fn from(_: Damaged) -> Self {
        Self::Damaged
    }
}

impl From<StateError> for PartError {
    fn from(error: StateError) -> Self {
        match error {
            StateError::Io(error) => Self::Io(error),
            _ => Self::Damaged,
        }
    }
}

/// Whether a file begins with the signature of a checkpoint or share of a bake.
pub fn is_part(path: &Path) -> bool {
    let mut start = [0; MAGIC.len()];
    let file = files::open(path, LARGEST_DATA);
    file.is_ok_and(|mut file| file.read_exact(&mut start).is_ok()) && start == *MAGIC
}

/// Writes a file in one step: after a failure the old file is intact. A share has a blueprint.
pub fn write_part(
    path: &Path,
    header: &PartHeader,
    blueprint: Option<&Blueprint>,
    lights: &[Lightmaps],
    spent: &[Duration],
) -> io::Result<()> {
    write_atomically_with(path, |file| {
        file.write_all(MAGIC)?;
        write_state(file, header, |state| {
            let mut bytes = Writer::default();
            blueprint.into_iter().for_each(|blueprint| blueprint.write(&mut bytes));
            bytes.put(lights.len() as u32);
            state.write(&bytes.0)?;
            let mut lights = lights.iter().zip(spent);
            lights.try_for_each(|(light, spent)| write_light(light, *spent, state))
        })
    })
}

fn write_light(light: &Lightmaps, spent: Duration, file: &mut StateWriter) -> io::Result<()> {
    let mut start = Writer::default();
    start.put(light.texel_count() as u64);
    start.put([light.first, light.groups.len() as u32]);
    start.put([light.rays, light.invalid]);
    start.put(spent.as_secs_f64());
    start.put_all(&light.ends);
    file.write(&start.0)?;
    for (group, layers) in light.groups.iter().zip(&light.layer_sums) {
        for sums in group.chunks(1 << 14) {
            let mut bytes = Writer(Vec::with_capacity(sums.len() * TEXEL));
            for sum in sums {
                bytes.put(sum.light);
                bytes.put(sum.luminance_squared);
                bytes.put(sum.backs);
            }
            file.write(&bytes.0)?;
        }
        for sums in layers.chunks(1 << 14) {
            let mut bytes = Writer(Vec::with_capacity(sums.len() * LAYER));
            bytes.put_all(sums);
            file.write(&bytes.0)?;
        }
    }
    Ok(())
}

fn read_light(bytes: &mut Reader, layers: usize) -> Result<(Lightmaps, Duration), Damaged> {
    let count = usize::try_from(bytes.take::<u64>()?).map_err(|_| Damaged)?;
    let [first, groups]: [u32; 2] = bytes.take()?;
    let (rays, invalid) = (bytes.count()?, bytes.count()?);
    let spent = bytes.duration()?;
    let mut ends = Reader(bytes.bytes(count.div_ceil(BLOCK).checked_mul(4).ok_or(Damaged)?)?);
    let ends: Result<Vec<u32>, Damaged> = (0..count.div_ceil(BLOCK)).map(|_| ends.take()).collect();
    let ends = ends?;
    // A bake has texels, and groups of no texels would take memory that no bytes of the file stand for.
    if count == 0 || groups == 0 || (first == 0 && groups != 1) || ends.iter().any(|end| *end < first) {
        return Err(Damaged);
    }
    // The bytes are read before memory is allocated for the texels that they declare.
    let mut of_groups: Vec<Vec<TexelSum>> = Vec::new();
    let mut layer_sums: Vec<Vec<DVec3>> = Vec::new();
    for _ in 0..groups {
        let mut sums = Reader(bytes.bytes(count.checked_mul(TEXEL).ok_or(Damaged)?)?);
        let sums: Result<_, Damaged> = (0..count).map(|_| read_sum(&mut sums)).collect();
        of_groups.push(sums?);
        let length = count.checked_mul(layers).ok_or(Damaged)?;
        let mut sums = Reader(bytes.bytes(length.checked_mul(LAYER).ok_or(Damaged)?)?);
        let sums: Result<Vec<DVec3>, Damaged> = (0..length).map(|_| sums.take()).collect();
        layer_sums.push(sums?);
    }
    let light = Lightmaps {
        first,
        groups: of_groups,
        layers,
        layer_sums,
        ends,
        rays,
        invalid,
    };
    Damaged::unless((0..count).all(|texel| light.is_possible(texel)))?;
    Ok((light, spent))
}

fn read_sum(bytes: &mut Reader) -> Result<TexelSum, Damaged> {
    Ok(TexelSum {
        light: bytes.take()?,
        luminance_squared: bytes.take()?,
        backs: bytes.take()?,
    })
}

/// Reads the header of a file.
pub fn read_header(path: &Path) -> Result<PartHeader, PartError> {
    let mut file = files::open(path, LARGEST_DATA)?;
    Ok(open(&mut file)?.0)
}

/// The content of a file: a share has a blueprint.
pub type Part = (PartHeader, Option<Blueprint>, PartLight);

/// Reads a whole file.
pub fn read_part(path: &Path) -> Result<Part, PartError> {
    decode(&mut files::open(path, LARGEST_DATA)?)
}

/// Decodes a file. All numbers are finite, and it takes no more memory than a small multiple of the file's length.
pub fn decode(file: &mut (impl Read + Seek)) -> Result<Part, PartError> {
    let (header, mut state) = open(file)?;
    let mut content = Vec::new();
    state.read_to_end(&mut content)?;
    let mut bytes = Reader(&content);
    let blueprint = match header.is_share {
        true => Some(Blueprint {
            division: header.division.clone(),
            ..Blueprint::read(&mut bytes)?
        }),
        false => None,
    };
    let (mut lights, mut spent) = (Vec::new(), Vec::new());
    for _ in 0..bytes.take::<u32>()? {
        let (light, time) = read_light(&mut bytes, header.division.layers.len())?;
        lights.push(light);
        spent.push(time);
    }
    let fits = blueprint.as_ref().is_none_or(|blueprint| {
        let counts = lights.iter().map(Lightmaps::texel_count);
        counts.eq(blueprint.texel_counts())
            && lights.iter().enumerate().all(|(number, light)| {
                let [first, end] = header.samples.map(|samples| blueprint.samples_of(number, samples));
                light.first == first && (light.reached() >= end || !header.is_finished)
            })
    });
    Damaged::unless(fits && bytes.0.is_empty() && !lights.is_empty())?;
    Ok((header, blueprint, PartLight { lights, spent }))
}

/// The header of a file, and a reader of its content.
fn open<F: Read + Seek>(file: &mut F) -> Result<(PartHeader, Take<&mut F>), PartError> {
    let mut start = Vec::new();
    file.take(MAGIC.len() as u64 + 4).read_to_end(&mut start)?;
    let format = start.strip_prefix(MAGIC).ok_or(PartError::Foreign)?;
    let format = Reader(format).take()?;
    if format != FORMAT {
        return Err(PartError::Format(format));
    }
    let (header, state) = open_state::<PartHeader, _>(file)?;
    Damaged::unless(header.samples[0] < header.samples[1] && header.division.is_possible())?;
    Ok((header, state))
}

impl BakeJob {
    /// Makes the job a share with these samples of each texel of a lightmap, and with a multiple of them for the points
    /// of volumes. The first sample begins a group, see [`crate::render::passes::is_cut`]. Nothing is gathered yet.
    pub fn begin_share(&mut self, samples: [u32; 2]) -> Result<(), BakeError> {
        let [first, end] = samples;
        let texels_and_groups = self.blueprint.texel_counts().zip(0..).map(|(texels, number)| {
            let range = self.blueprint.samples_of(number, first)..self.blueprint.samples_of(number, end);
            let groups = if range.start == 0 { 1 } else { chunks_in(range) };
            (texels as u64, groups)
        });
        // The bytes of a texel include one group.
        let sums: u64 = texels_and_groups.map(|(texels, groups)| texels * (groups - 1)).sum();
        let layers = self.blueprint.division.layers.len();
        let memory = memory::reserve(sums * (size_of::<TexelSum>() + layers * LAYER) as u64);
        let begun = self.blueprint.texel_counts().zip(0..);
        let begun =
            begun.map(|(texels, number)| Lightmaps::beginning_at(self.blueprint.samples_of(number, first), texels));
        self.lights = begun.map(|light| light.with_layers(layers)).collect();
        self.memory.push(memory.map_err(BakeError::MemoryOfShare)?);
        Ok(())
    }

    /// Gathers all light up to sample `end` of each texel of a lightmap, and finishes no pictures. False if cancelled.
    pub fn gather_share(&mut self, end: u32, cancel: &AtomicBool, watch: Watch) -> bool {
        (0..self.lights.len()).all(|number| {
            let end = self.blueprint.samples_of(number, end);
            self.gather(number, end, &BakeLimits::default(), cancel, watch)
        })
    }

    /// Resumes from the light of a file. The error says what differs; it does not name the file.
    pub fn take_up(&mut self, light: PartLight) -> Result<(), String> {
        let PartLight { lights, spent } = light;
        let counts = |lights: &[Lightmaps]| lights.iter().map(Lightmaps::texel_count).collect::<Vec<_>>();
        let (found, expected) = (counts(&lights), counts(&self.lights));
        if found != expected {
            return Err(format!(
                "its lightmaps and probes have {found:?} texels, and those of this bake have {expected:?}"
            ));
        }
        let mut pairs = lights.iter().zip(&self.lights);
        if pairs.any(|(one, other)| one.first != other.first) {
            return Err("it is of other samples".to_owned());
        }
        let mut pairs = lights.iter().zip(&self.lights);
        if pairs.any(|(one, other)| one.layers != other.layers) {
            return Err("it has other layers".to_owned());
        }
        (self.lights, self.spent) = (lights, spent);
        Ok(())
    }

    /// Writes the sums of all samples so far in one step: as a share, or as a checkpoint from which only this bake can
    /// be resumed. `of` is the header, in which this sets the layers, and whether the file is finished.
    pub fn save(&self, path: &Path, of: &PartHeader) -> io::Result<()> {
        let ends = (0..self.lights.len()).map(|number| self.blueprint.samples_of(number, of.samples[1]));
        let header = PartHeader {
            is_finished: self.lights.iter().zip(ends).all(|(light, end)| light.reached() >= end),
            division: self.blueprint.division.clone(),
            ..of.clone()
        };
        let blueprint = of.is_share.then_some(&self.blueprint);
        write_part(path, &header, blueprint, &self.lights, &self.spent)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_light_without_texels_is_damaged() {
        // Two groups of samples of no texels take no bytes, whatever their declared number.
        let light = |count: u64, groups: u32| light(count, groups, [0; 2], 0.0);
        assert!(read_light(&mut Reader(&light(1, 2)), 0).is_ok());
        assert!(read_light(&mut Reader(&light(0, 2)), 0).is_err());
        assert!(read_light(&mut Reader(&light(0, u32::MAX)), 0).is_err());
    }

    #[test]
    fn rays_and_times_of_a_light_can_be_added() {
        for (rays, seconds, is_possible) in [(7, 2.0, true), (u64::MAX, 2.0, false), (7, 1.8e19, false)] {
            let bytes = light(1, 1, [rays, 0], seconds);
            assert_eq!(
                read_light(&mut Reader(&bytes), 0).is_ok(),
                is_possible,
                "{rays} {seconds}"
            );
        }
    }

    /// The bytes of a light whose texels have only the first 16 samples.
    fn light(count: u64, groups: u32, rays: [u64; 2], seconds: f64) -> Vec<u8> {
        let mut bytes = Writer::default();
        bytes.put(count);
        bytes.put([16, groups]);
        bytes.put(rays);
        bytes.put(seconds);
        (0..count).for_each(|_| bytes.put(16u32));
        bytes
            .0
            .resize(bytes.0.len() + count as usize * groups as usize * TEXEL, 0);
        bytes.0
    }
}
