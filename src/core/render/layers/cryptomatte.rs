//! Cryptomatte: the objects or materials in each pixel with their coverage, so that a compositor can cut out any of
//! them by name (Friedman and Jones, Fully automatic ID mattes with support for motion blur and transparency, 2015;
//! specification 1.2).

use std::collections::{BTreeMap, HashMap};

use bytemuck::{Pod, Zeroable};

use crate::render::layered_image::{Attribute, LayeredImage};

/// The number of ids per pixel that are written, those with the largest coverage; a layer of four channels has two.
const RANKS: usize = 6;

/// The hash MurmurHash3_x86_32 of a text, with the seed 0 (Appleby, SMHasher).
fn murmur_hash(text: &str) -> u32 {
    let scramble = |k: u32| k.wrapping_mul(0xcc9e_2d51).rotate_left(15).wrapping_mul(0x1b87_3593);
    let mut hash = 0_u32;
    let mut blocks = text.as_bytes().chunks_exact(4);
    for block in &mut blocks {
        let k = block.iter().rev().fold(0, |k, &byte| k << 8 | u32::from(byte));
        hash = (hash ^ scramble(k))
            .rotate_left(13)
            .wrapping_mul(5)
            .wrapping_add(0xe654_6b64);
    }
    let tail = blocks.remainder();
    if !tail.is_empty() {
        hash ^= scramble(tail.iter().rev().fold(0, |k, &byte| k << 8 | u32::from(byte)));
    }
    hash ^= text.len() as u32;
    hash = (hash ^ hash >> 16).wrapping_mul(0x85eb_ca6b);
    hash = (hash ^ hash >> 13).wrapping_mul(0xc2b2_ae35);
    hash ^ hash >> 16
}

/// The hash of a name, changed so that its bits are those of a float that is neither denormal, infinite nor NaN: files
/// and programs may change such floats.
fn id_of(name: &str) -> u32 {
    let hash = murmur_hash(name);
    match hash >> 23 & 255 {
        0 | 255 => hash ^ 1 << 23,
        _ => hash,
    }
}

/// Adds the channels and attributes of a cryptomatte with the name `layer`. `name_of` gives the names of the ids in
/// `mattes`, each of which is a pixel's with its number of samples; ids with the same name are merged.
pub(super) fn add_cryptomatte(
    image: &mut LayeredImage,
    layer: &str,
    mattes: &[(Matte, u32)],
    name_of: &dyn Fn(u32) -> String,
) {
    let mut manifest = BTreeMap::new();
    let mut hashes: HashMap<u32, u32> = HashMap::new();
    let mut channels = vec![vec![0.0; mattes.len()]; 2 * RANKS];
    for (pixel, (matte, samples)) in mattes.iter().enumerate() {
        let mut ranks: Vec<MatteEntry> = Vec::new();
        for entry in matte.entries() {
            let id = *hashes.entry(entry.id).or_insert_with(|| {
                let name = name_of(entry.id);
                let id = id_of(&name);
                manifest.insert(name, id);
                id
            });
            match ranks.iter_mut().find(|known| known.id == id) {
                Some(known) => known.samples += entry.samples,
                None => ranks.push(MatteEntry { id, ..entry }),
            }
        }
        ranks.sort_unstable_by_key(|entry| (u32::MAX - entry.samples, entry.id));
        for (rank, entry) in ranks.iter().take(RANKS).enumerate() {
            channels[2 * rank][pixel] = f32::from_bits(entry.id);
            channels[2 * rank + 1][pixel] = entry.samples as f32 / *samples as f32;
        }
    }
    for (place, channel) in channels.into_iter().enumerate() {
        let name = format!("{layer}{:02}.{}", place / 4, ["R", "G", "B", "A"][place % 4]);
        image.add_float(&name, channel);
    }
    let manifest: serde_json::Map<_, _> = manifest
        .into_iter()
        .map(|(name, id)| (name, format!("{id:08x}").into()))
        .collect();
    let key = &format!("{:08x}", murmur_hash(layer))[..7];
    let mut set =
        |name: &str, text: String| image.set_attribute(&format!("cryptomatte/{key}/{name}"), Attribute::Text(text));
    set("name", layer.to_owned());
    set("hash", "MurmurHash3_32".to_owned());
    set("conversion", "uint32_to_float32".to_owned());
    set("manifest", serde_json::Value::Object(manifest).to_string());
}

/// The number of ids that a pixel remembers. Those that come when all places are taken are left out while they have
/// fewer samples.
const PLACES: usize = 8;

/// The ids in one pixel.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Matte([MatteEntry; PLACES]);

/// An id, and the number of samples that met it; the place is free if there are none.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Pod, Zeroable)]
#[repr(C)]
pub struct MatteEntry {
    /// The instance or the material.
    pub id: u32,
    /// The number of samples.
    pub samples: u32,
}

impl Matte {
    /// Counts a sample.
    pub(super) fn add(&mut self, id: u32) {
        self.add_entry(MatteEntry { id, samples: 1 });
    }

    /// Adds the samples of another range of the same pixel.
    pub(in crate::render) fn merge(&mut self, other: &Self) {
        other.entries().for_each(|entry| self.add_entry(entry));
    }

    pub(in crate::render) fn add_entry(&mut self, new: MatteEntry) {
        for place in &mut self.0 {
            if place.samples == 0 {
                *place = new;
                return;
            }
            if place.id == new.id {
                place.samples = place.samples.saturating_add(new.samples);
                return;
            }
        }
        if let Some(least) = self.0.iter_mut().min_by_key(|entry| entry.samples)
            && least.samples < new.samples
        {
            *least = new;
        }
    }

    /// The ids with their samples.
    pub fn entries(&self) -> impl Iterator<Item = MatteEntry> {
        self.0.iter().copied().take_while(|entry| entry.samples > 0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The values in SMHasher's own test for the seed 0.
    #[test]
    fn the_hash_is_murmur_hash_3() {
        for (text, hash) in [
            ("", 0),
            ("test", 0xba6b_d213),
            ("Hello, world!", 0xc036_3e43),
            ("The quick brown fox jumps over the lazy dog", 0x2e4f_f723),
        ] {
            assert_eq!(murmur_hash(text), hash, "{text}");
        }
    }

    #[test]
    fn ids_are_ordinary_floats() {
        for number in 0..20_000 {
            assert!(f32::from_bits(id_of(&format!("shape {number}"))).is_normal());
        }
        // The hashes of these names would not be normal floats.
        let odd = (0..20_000).map(|number| murmur_hash(&format!("shape {number}")));
        assert!(odd.filter(|&hash| !f32::from_bits(hash).is_normal()).count() > 20);
    }

    #[test]
    fn channels_have_ranks_and_a_manifest() {
        let mut matte = Matte::default();
        for (id, samples) in [(7, 1), (3, 5), (4, 2)] {
            (0..samples).for_each(|_| matte.add(id));
        }
        let name = |id: u32| ["ball", "floor"][usize::from(id != 3)].to_owned();
        let mut image = LayeredImage::new(2, 1);
        add_cryptomatte(
            &mut image,
            "CryptoObject",
            &[(matte, 10), (Matte::default(), 10)],
            &name,
        );
        let value = |name: &str, pixel: usize| image.channel(name).expect("a channel").samples.value(pixel);
        assert_eq!(value("CryptoObject00.R", 0).to_bits(), id_of("ball"));
        assert_eq!(value("CryptoObject00.G", 0), 0.5);
        // Two ids with the same name are merged.
        assert_eq!(value("CryptoObject00.B", 0).to_bits(), id_of("floor"));
        assert_eq!((value("CryptoObject00.A", 0), value("CryptoObject01.G", 0)), (0.3, 0.0));
        assert_eq!((value("CryptoObject00.R", 1), value("CryptoObject02.A", 1)), (0.0, 0.0));
        let Some(Attribute::Text(manifest)) = image.attribute("cryptomatte/3ae39a5/manifest") else {
            panic!("{:?}", image.attributes);
        };
        let expected = format!(r#"{{"ball":"{:08x}","floor":"{:08x}"}}"#, id_of("ball"), id_of("floor"));
        assert_eq!(*manifest, expected);
    }

    #[test]
    fn a_pixel_keeps_what_covers_most() {
        let mut matte = Matte::default();
        for id in 0..PLACES as u32 + 1 {
            matte.add(id);
        }
        assert_eq!(matte.entries().count(), PLACES, "the last one finds no place");
        let mut many = Matte::default();
        (0..3).for_each(|_| many.add(100));
        matte.add(0);
        matte.merge(&many);
        let samples = |matte: &Matte, id| matte.entries().find(|entry| entry.id == id).map(|entry| entry.samples);
        assert_eq!((samples(&matte, 100), samples(&matte, 0)), (Some(3), Some(2)));
        matte.merge(&many);
        assert_eq!(samples(&matte, 100), Some(6));
    }
}
