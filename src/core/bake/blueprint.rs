//! The part of a bake that needs no light: all data with which its files can be made of the sums of samples.

use std::sync::atomic::{AtomicBool, Ordering};

use glam::{Affine3A, UVec2, UVec3, Vec2};
use rayon::ThreadPool;

use super::finish::{Denoising, LightmapPicture, finish};
use super::layers::{Division, Parts, merged_in, texture_texels};
use super::level::BakedNode;
use super::lightmap::Lightmaps;
use super::manifest::BakedLight;
use super::prefilter::is_size;
use super::probes::{Probe, ProbeKind, ProbePicture};
use super::progress::{Stage, Work};
use super::seams::Seam;
use super::texels::{Texel, Texels};
use super::unwrap::{ATLAS_SIZES, TEXEL_BYTES};
use super::volume::{MOST_ALONG, MOST_POINTS};
use crate::render::bytes::{Damaged, Reader, Writer};
use crate::render::denoise::DenoiseError;

/// A bake without its light.
#[derive(Clone, Debug, PartialEq)]
pub struct Blueprint {
    /// The glTF file of the level.
    pub level: Vec<u8>,
    /// The light that the lightmaps hold: all of it, or indirect light alone.
    pub light: BakedLight,
    /// The seed of the random numbers.
    pub seed: u32,
    /// Whether noise is removed.
    pub denoise: bool,
    /// Texels per unit of length.
    pub texels_per_unit: f32,
    /// The nodes that have a place in a lightmap.
    pub nodes: Vec<BakedNode>,
    /// The covered texels of the lightmaps, without receivers.
    pub places: Texels<()>,
    /// The seams of each lightmap.
    pub seams: Vec<Vec<Seam>>,
    /// Reflection probes, then irradiance volumes.
    pub probes: Vec<Probe>,
    /// The layers of its light.
    pub division: Division,
}

/// A finished bake.
#[derive(Clone, Debug, PartialEq)]
pub struct Baked {
    /// The lightmaps.
    pub lightmaps: Vec<LightmapPicture>,
    /// The number of samples of each texel of a lightmap.
    pub samples: u32,
    /// The filtered pictures of each probe; None for a probe that is not finished.
    pub probes: Vec<Option<ProbePicture>>,
    /// The layers of each lightmap, in ascending order; none without layers. Their sum is the lightmap.
    pub lightmap_layers: Vec<Layered<LightmapPicture>>,
    /// The layers of each probe likewise.
    pub probe_layers: Vec<Layered<ProbePicture>>,
    /// The number of pairs of a picture and a lamp that is merged into the rest there.
    pub merged: usize,
}

/// A finished probe.
pub(super) struct BakedProbe {
    whole: ProbePicture,
    layers: Layered<ProbePicture>,
    /// The number of lamps that are merged into the rest.
    merged: usize,
}

impl Baked {
    /// Adds a probe.
    pub(super) fn take_probe(&mut self, number: usize, probe: BakedProbe) {
        self.probes[number] = Some(probe.whole);
        self.probe_layers[number] = probe.layers;
        self.merged += probe.merged;
    }
}

/// The layers of a picture, with their indices in [`Division::layers`].
pub type Layered<T> = Vec<(usize, T)>;

impl Blueprint {
    /// The number of lightmaps.
    pub fn page_count(&self) -> usize {
        self.places.pages.len()
    }

    /// The picture of page `page` made of the light gathered so far.
    pub fn lightmap(
        &self,
        page: usize,
        light: &Lightmaps,
        denoising: Option<Denoising>,
    ) -> Result<LightmapPicture, DenoiseError> {
        finish(&self.places, page, light, &self.seams[page], denoising)
    }

    /// The denoiser, if denoising is asked for.
    fn denoising<'a>(&self, threads: usize, cancel: &'a AtomicBool) -> Option<Denoising<'a>> {
        self.denoise.then_some(Denoising {
            threads: Some(threads),
            cancel,
        })
    }

    /// The pictures of all lightmaps. `watch` gets the finished share, from 0 to 1. An error soon after `discards` is
    /// set. An interrupt alone does not set it, since the light gathered by then shall be written.
    pub(super) fn lightmaps(
        &self,
        light: &Lightmaps,
        threads: usize,
        discards: &AtomicBool,
        mut watch: impl FnMut(f64),
    ) -> Result<Baked, DenoiseError> {
        let parts: Vec<Parts> = self
            .places
            .pages
            .iter()
            .map(|page| self.division.parts(light, page.clone()))
            .collect();
        let count: usize = match self.division.is_some() {
            true => parts.iter().map(Vec::len).sum(),
            false => self.page_count(),
        };
        let mut done = 0;
        let mut picture = |page, light: &Lightmaps| {
            watch(done as f64 / count.max(1) as f64);
            done += 1;
            match discards.load(Ordering::Relaxed) {
                true => Err(DenoiseError::Cancelled),
                false => self.lightmap(page, light, self.denoising(threads, discards)),
            }
        };
        let pages = 0..self.page_count();
        let mut layers: Vec<Layered<LightmapPicture>> = vec![Vec::new(); pages.len()];
        let lightmaps = match self.division.is_some() {
            false => pages.map(|page| picture(page, light)).collect::<Result<_, _>>()?,
            true => {
                for layer in 0..self.division.layers.len() {
                    let of_page = |page: usize| parts[page].iter().find(|(number, _)| *number == layer);
                    let lit: Vec<usize> = pages.clone().filter(|page| of_page(*page).is_some()).collect();
                    if lit.is_empty() {
                        continue;
                    }
                    let light = light.part(|texel| {
                        let page = self.places.pages.partition_point(|page| page.end <= texel);
                        of_page(page).map_or(&[], |(_, layers)| layers)
                    });
                    for page in lit {
                        layers[page].push((layer, picture(page, &light)?));
                    }
                }
                let size = self.places.size;
                let sum = |layers: &Layered<LightmapPicture>| {
                    LightmapPicture::sum(size, layers.iter().map(|(_, layer)| layer))
                };
                layers.iter().map(sum).collect()
            }
        };
        Ok(Baked {
            lightmaps,
            samples: light.samples(),
            probes: vec![None; self.probes.len()],
            lightmap_layers: layers,
            probe_layers: vec![Vec::new(); self.probes.len()],
            merged: parts.iter().map(merged_in).sum(),
        })
    }

    /// The filtered pictures of a probe, made of its light; None if the work was cancelled.
    pub(super) fn probe(
        &self,
        number: usize,
        light: &Lightmaps,
        work: &mut Work,
    ) -> Result<Option<BakedProbe>, DenoiseError> {
        let probe = &self.probes[number];
        let parts = self.division.parts(light, 0..light.texel_count());
        if parts.is_empty() {
            let picture = probe.finished(light, self.denoise, work)?;
            return Ok(picture.map(|whole| BakedProbe {
                whole,
                layers: Vec::new(),
                merged: 0,
            }));
        }
        let (mut sum, mut layers): (Option<ProbePicture>, _) = (None, Vec::new());
        let share = 1.0 / parts.len() as f64;
        for (done, (layer, part)) in parts.iter().enumerate() {
            let light = light.part(|_| part);
            let begin = done as f64 * share;
            let picture = work.part(begin..begin + share, |work| probe.finished(&light, self.denoise, work))?;
            let Some(picture) = picture else {
                return Ok(None);
            };
            match &mut sum {
                Some(sum) => sum.add(&picture),
                None => sum = Some(picture.clone()),
            }
            layers.push((*layer, picture));
        }
        Ok(sum.map(|whole| BakedProbe {
            whole,
            layers,
            merged: merged_in(&parts),
        }))
    }

    /// Makes the pictures of all lightmaps and probes.
    pub fn finished(&self, lights: &[Lightmaps], pool: &ThreadPool) -> Result<Baked, DenoiseError> {
        let work = &mut Work {
            pool,
            cancel: &AtomicBool::new(false),
            watch: &mut |_| {},
        };
        let mut baked = self.lightmaps(&lights[0], pool.current_num_threads(), work.cancel, |_| {})?;
        for (number, light) in lights[1..].iter().enumerate() {
            if let Some(probe) = self.probe(number, light, work)? {
                baked.take_probe(number, probe);
            }
        }
        Ok(baked)
    }

    /// The number of texels of all lightmaps together, followed by that of each probe.
    pub(super) fn texel_counts(&self) -> impl Iterator<Item = usize> {
        std::iter::once(self.places.texels.len()).chain(self.probes.iter().map(Probe::texel_count))
    }

    /// The samples per texel of the lightmaps (`number` 0) or of a probe (its index + 1) if lightmaps get `samples`.
    pub(super) fn samples_of(&self, number: usize, samples: u32) -> u32 {
        match number.checked_sub(1) {
            None => samples,
            Some(number) => self.probes[number].samples(samples),
        }
    }

    /// Whether both bakes have the same texels, so that the sums of light of one can be used for the other.
    pub(super) fn has_texels_of(&self, other: &Self) -> bool {
        self.places == other.places && self.texel_counts().eq(other.texel_counts())
    }

    /// Bytes of memory needed while all pictures are made.
    pub(super) fn memory_bytes(&self) -> u64 {
        let page = u64::from(self.places.size.x) * u64::from(self.places.size.y);
        let probes: u64 = self.probes.iter().map(Probe::memory_bytes).sum();
        let pages = TEXEL_BYTES.saturating_mul(page * self.page_count() as u64);
        pages.saturating_add(probes).saturating_add(self.memory_of_layers())
    }

    /// Bytes of memory that the layers take.
    pub(super) fn memory_of_layers(&self) -> u64 {
        let texels: usize = self.texel_counts().sum();
        self.division.memory_bytes(texels as u64, self.texture_texels())
    }

    /// The number of texels of all textures.
    fn texture_texels(&self) -> u64 {
        texture_texels(self.places.size, self.page_count(), &self.probes)
    }
}

impl Blueprint {
    pub(super) fn write(&self, bytes: &mut Writer) {
        blob(bytes, &self.level);
        bytes.put(u32::from(self.light == BakedLight::WithoutDirectPunctual));
        bytes.put([self.seed, u32::from(self.denoise)]);
        bytes.put(self.texels_per_unit);
        bytes.put(self.nodes.len() as u64);
        for node in &self.nodes {
            bytes.put(node.node as u64);
            blob(bytes, node.path.as_bytes());
            bytes.put(node.lightmap);
            bytes.put(node.rect);
        }
        let size = self.places.size;
        bytes.put(size);
        bytes.put(self.places.pages.len() as u32);
        for page in &self.places.pages {
            bytes.put(page.len() as u32);
            let texels = self.places.texels[page.clone()].iter();
            texels.for_each(|texel| bytes.put(texel.place.y * size.x + texel.place.x));
        }
        for seams in &self.seams {
            bytes.put(seams.len() as u64);
            bytes.put_all(seams);
        }
        bytes.put(self.probes.len() as u32);
        for probe in &self.probes {
            blob(bytes, probe.name.as_bytes());
            bytes.put(probe.world_from_box.to_cols_array());
            bytes.put(match probe.kind {
                ProbeKind::Reflection { size, parallax } => [0, size, u32::from(parallax), 0],
                ProbeKind::Volume { points } => [1, points.x, points.y, points.z],
            });
        }
    }

    /// Reads a blueprint written by [`Self::write`], without its division, which headers of files have. All numbers are
    /// finite, and all texels lie inside their pages.
    pub(super) fn read(bytes: &mut Reader) -> Result<Self, Damaged> {
        let level = take_blob(bytes)?.to_vec();
        let light = match bytes.flag()? {
            true => BakedLight::WithoutDirectPunctual,
            false => BakedLight::All,
        };
        let (seed, denoise, texels_per_unit) = (bytes.take()?, bytes.flag()?, bytes.finite()?);
        let mut nodes = Vec::new();
        for _ in 0..bytes.take::<u64>()? {
            nodes.push(BakedNode {
                node: usize::try_from(bytes.take::<u64>()?).map_err(|_| Damaged)?,
                path: text(bytes)?,
                lightmap: bytes.take()?,
                rect: bytes.take()?,
            });
        }
        let places = read_places(bytes)?;
        Damaged::unless(nodes.iter().all(|node| {
            (node.lightmap as usize) < places.pages.len() && node.rect.iter().all(|number| number.is_finite())
        }))?;
        let mut seams = Vec::new();
        for _ in &places.pages {
            let mut list = Vec::new();
            for _ in 0..bytes.take::<u64>()? {
                let seam: Seam = bytes.take()?;
                let size = places.size.as_vec2();
                let is_within = |place: &Vec2| place.cmpge(Vec2::ZERO).all() && place.cmple(size).all();
                Damaged::unless([seam.one, seam.other].as_flattened().iter().all(is_within))?;
                list.push(seam);
            }
            seams.push(list);
        }
        let mut probes = Vec::new();
        for _ in 0..bytes.take::<u32>()? {
            probes.push(read_probe(bytes)?);
        }
        Ok(Self {
            level,
            light,
            seed,
            denoise,
            texels_per_unit,
            nodes,
            places,
            seams,
            probes,
            division: Division::default(),
        })
    }
}

fn read_places(bytes: &mut Reader) -> Result<Texels<()>, Damaged> {
    let size: UVec2 = bytes.take()?;
    let is_possible = |side: u32| (1..=*ATLAS_SIZES.end()).contains(&side);
    Damaged::unless(is_possible(size.x) && is_possible(size.y))?;
    let mut places = Texels {
        size,
        texels: Vec::new(),
        pages: Vec::new(),
        spreads: Vec::new(),
    };
    for _ in 0..bytes.take::<u32>()? {
        let first = places.texels.len();
        for _ in 0..bytes.take::<u32>()? {
            let index: u32 = bytes.take()?;
            let place = UVec2::new(index % size.x, index / size.x);
            Damaged::unless(place.y < size.y)?;
            places.texels.push(Texel { place, receiver: () });
        }
        places.pages.push(first..places.texels.len());
    }
    Ok(places)
}

fn read_probe(bytes: &mut Reader) -> Result<Probe, Damaged> {
    let name = text(bytes)?;
    let mut columns = [0.0; 12];
    bytes.finites(&mut columns)?;
    let world_from_box = Affine3A::from_cols_array(&columns);
    Damaged::unless(world_from_box.matrix3.determinant().is_normal())?;
    let kind = match bytes.take::<[u32; 4]>()? {
        [0, size, parallax @ (0 | 1), 0] if is_size(size) => ProbeKind::Reflection {
            size,
            parallax: parallax == 1,
        },
        [1, x, y, z] if [x, y, z].iter().all(|side| (1..=MOST_ALONG).contains(side)) && x * y * z <= MOST_POINTS => {
            let points = UVec3::new(x, y, z);
            ProbeKind::Volume { points }
        }
        _ => return Err(Damaged),
    };
    Ok(Probe {
        name,
        world_from_box,
        kind,
    })
}

fn blob(bytes: &mut Writer, content: &[u8]) {
    bytes.put(content.len() as u64);
    bytes.0.extend_from_slice(content);
}

fn take_blob<'a>(bytes: &mut Reader<'a>) -> Result<&'a [u8], Damaged> {
    let length = usize::try_from(bytes.take::<u64>()?).map_err(|_| Damaged)?;
    bytes.bytes(length)
}

fn text(bytes: &mut Reader) -> Result<String, Damaged> {
    String::from_utf8(take_blob(bytes)?.to_vec()).map_err(|_| Damaged)
}

impl Stage {
    /// The work being done, in words. `blueprint` gives the names of probes.
    pub fn words(self, blueprint: Option<&Blueprint>) -> String {
        let probe = |number: usize| blueprint.and_then(|blueprint| blueprint.probes.get(number));
        let name = |number: usize| probe(number).map_or("", |probe| probe.name.as_str());
        match self {
            Self::PlacingProbes => "placing the probes".to_owned(),
            Self::Unwrapping => "unwrapping the level".to_owned(),
            Self::Lightmaps => "gathering the light of the lightmaps".to_owned(),
            Self::FinishingLightmaps => "finishing the lightmaps".to_owned(),
            Self::Probe(number) => match probe(number).map(|probe| probe.kind) {
                Some(ProbeKind::Volume { .. }) => format!("irradiance volume `{}`", name(number)),
                _ => format!("reflection probe `{}`", name(number)),
            },
            Self::FinishingProbe(number) => format!("filtering `{}`", name(number)),
        }
    }
}
