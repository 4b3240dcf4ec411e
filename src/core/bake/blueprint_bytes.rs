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
        bytes.u32(u32::from(self.light == BakedLight::WithoutDirectPunctual));
        bytes.u32(self.seed);
        bytes.u32(u32::from(self.denoise));
        bytes.f32(self.texels_per_unit);
        bytes.u64(self.nodes.len() as u64);
        for node in &self.nodes {
            bytes.u64(node.node as u64);
            blob(bytes, node.path.as_bytes());
            bytes.u32(node.lightmap);
            node.rect.iter().for_each(|number| bytes.f32(*number));
        }
        bytes.u32(self.places.size.x);
        bytes.u32(self.places.size.y);
        bytes.u32(self.places.pages.len() as u32);
        for page in &self.places.pages {
            bytes.u32(page.len() as u32);
            for texel in &self.places.texels[page.clone()] {
                bytes.u32(texel.place.y * self.places.size.x + texel.place.x);
            }
        }
        for seams in &self.seams {
            bytes.u64(seams.len() as u64);
            let places = seams.iter().flat_map(|seam| [seam.one, seam.other].concat());
            places
                .flat_map(|place| place.to_array())
                .for_each(|number| bytes.f32(number));
        }
        bytes.u32(self.probes.len() as u32);
        for probe in &self.probes {
            blob(bytes, probe.name.as_bytes());
            probe
                .world_from_box
                .to_cols_array()
                .iter()
                .for_each(|number| bytes.f32(*number));
            let numbers = match probe.kind {
                ProbeKind::Reflection { size, parallax } => [0, size, u32::from(parallax), 0],
                ProbeKind::Volume { points } => [1, points.x, points.y, points.z],
            };
            numbers.iter().for_each(|number| bytes.u32(*number));
        }
    }

    /// Reads what [`Self::write`] has written. No number leads out of a picture, and all of them are finite.
    pub(super) fn read(bytes: &mut Reader) -> Result<Self, Damaged> {
        let level = take_blob(bytes)?.to_vec();
        let light = match bytes.flag()? {
            true => BakedLight::WithoutDirectPunctual,
            false => BakedLight::All,
        };
        let (seed, denoise, texels_per_unit) = (bytes.u32()?, bytes.flag()?, bytes.f32()?);
        let mut nodes = Vec::new();
        for _ in 0..bytes.u64()? {
            nodes.push(BakedNode {
                node: usize::try_from(bytes.u64()?).map_err(|_| Damaged)?,
                path: text(bytes)?,
                lightmap: bytes.u32()?,
                rect: [bytes.f32()?, bytes.f32()?, bytes.f32()?, bytes.f32()?],
            });
        }
        let places = read_places(bytes)?;
        let is_possible = |node: &BakedNode| {
            (node.lightmap as usize) < places.pages.len() && node.rect.iter().all(|number| number.is_finite())
        };
        if !nodes.iter().all(is_possible) || !texels_per_unit.is_finite() {
            return Err(Damaged);
        }
        let mut seams = Vec::new();
        for _ in &places.pages {
            let mut list = Vec::new();
            for _ in 0..bytes.u64()? {
                list.push(Seam {
                    one: [read_place(bytes, places.size)?, read_place(bytes, places.size)?],
                    other: [read_place(bytes, places.size)?, read_place(bytes, places.size)?],
                });
            }
            seams.push(list);
        }
        let mut probes = Vec::new();
        for _ in 0..bytes.u32()? {
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
    let size = UVec2::new(bytes.u32()?, bytes.u32()?);
    let is_possible = |side: u32| (1..=*ATLAS_SIZES.end()).contains(&side);
    if !is_possible(size.x) || !is_possible(size.y) {
        return Err(Damaged);
    }
    let mut places = Texels {
        size,
        texels: Vec::new(),
        pages: Vec::new(),
        spreads: Vec::new(),
    };
    for _ in 0..bytes.u32()? {
        let first = places.texels.len();
        for _ in 0..bytes.u32()? {
            let index = bytes.u32()?;
            let place = UVec2::new(index % size.x, index / size.x);
            if place.y >= size.y {
                return Err(Damaged);
            }
            places.texels.push(Texel { place, receiver: () });
        }
        places.pages.push(first..places.texels.len());
    }
    Ok(places)
}

fn read_place(bytes: &mut Reader, size: UVec2) -> Result<Vec2, Damaged> {
    let place = Vec2::new(bytes.f32()?, bytes.f32()?);
    let is_within = place.cmpge(Vec2::ZERO).all() && place.cmple(size.as_vec2()).all();
    if is_within { Ok(place) } else { Err(Damaged) }
}

fn read_probe(bytes: &mut Reader) -> Result<Probe, Damaged> {
    let name = text(bytes)?;
    let mut columns = [0.0; 12];
    bytes.finites(&mut columns)?;
    let world_from_box = Affine3A::from_cols_array(&columns);
    let size = world_from_box.matrix3.determinant();
    if !size.is_normal() {
        return Err(Damaged);
    }
    let kind = match [bytes.u32()?, bytes.u32()?, bytes.u32()?, bytes.u32()?] {
        [0, size, parallax @ (0 | 1), 0] if is_size(size) => ProbeKind::Reflection {
            size,
            parallax: parallax == 1,
        },
        [1, x, y, z] if [x, y, z].iter().all(|side| (1..=MOST_ALONG).contains(side)) && x * y * z <= MOST_POINTS => {
            ProbeKind::Volume {
                points: UVec3::new(x, y, z),
            }
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
    bytes.u64(content.len() as u64);
    bytes.0.extend_from_slice(content);
}

fn take_blob<'a>(bytes: &mut Reader<'a>) -> Result<&'a [u8], Damaged> {
    let length = usize::try_from(bytes.u64()?).map_err(|_| Damaged)?;
    bytes.bytes(length)
}

fn text(bytes: &mut Reader) -> Result<String, Damaged> {
    String::from_utf8(take_blob(bytes)?.to_vec()).map_err(|_| Damaged)
}
