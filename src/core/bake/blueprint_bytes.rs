//! A blueprint as bytes, for the file of a share.

use glam::{Affine3A, UVec2, UVec3, Vec2};

use super::blueprint::Blueprint;
use super::level::BakedNode;
use super::manifest::BakedLight;
use super::prefilter::is_size;
use super::probes::{Probe, ProbeKind};
use super::seams::Seam;
use super::texels::{Texel, Texels};
use super::unwrap::ATLAS_SIZES;
use super::volume::{MOST_ALONG, MOST_POINTS};
use crate::render::bytes::{Damaged, Reader, Writer};

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

    /// Reads what [`Self::write`] has written. No number leads out of a picture, and all of them are finite.
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
