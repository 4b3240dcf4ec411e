//! The exact state of a film tile by tile as bytes, for parts and checkpoints ([`crate::render::part`]).

use glam::{Vec2, Vec3};

use super::Film;
use crate::color::Rgb;
use crate::material::MaterialId;
use crate::render::bytes::{Damaged, Reader, Writer};
use crate::render::layers::{FilmLayers, LayerSums, Matte, MatteEntry};
use crate::render::noise::blocks::BLOCKS;
use crate::render::noise::mean_error::BlockError;
use crate::render::scene::FirstHit;
use crate::render::splats::SplatSum;
use crate::render::tile::{PixelSum, Tile, TileSamples};

impl Film {
    /// Writes the film's data of a tile; only the chunks for a share. Splats are written by [`Self::write_splats`].
    pub fn write_tile(&self, tile: Tile, to: &mut Writer) {
        to.u32(u32::from(self.chunks.is_none()));
        if self.chunks.is_none() {
            for index in self.places_of(tile) {
                write_sum(&self.sums[index], to);
                to.u32(self.counts[index]);
                self.noted[index].into_iter().for_each(|mean| to.f32(mean));
                write_hit(self.first_hits[index].as_ref(), to);
                write_layers(
                    self.layers.values_of(self.kept, index),
                    self.mattes_of(&self.layers, index),
                    to,
                );
            }
            let blocks = self.tile_index(tile.x, tile.y) * BLOCKS;
            for error in &self.errors[blocks..blocks + BLOCKS] {
                [error.noted, error.level].into_iter().for_each(|number| to.u32(number));
                let sums = [error.difference, error.difference_before, error.spread, error.luminance];
                sums.into_iter().for_each(|sum| to.f32(sum));
            }
        }
        to.u32(self.chunks_of(tile).count() as u32);
        for chunk in self.chunks_of(tile) {
            [chunk.samples.start, chunk.samples.end]
                .into_iter()
                .for_each(|sample| to.u32(sample));
            to.u32(u32::from(!chunk.first_hits.is_empty()));
            for (pixel, sum) in chunk.pixels.iter().enumerate() {
                write_sum(sum, to);
                if let Some(hit) = chunk.first_hits.get(pixel) {
                    write_hit(hit.as_ref(), to);
                }
                write_layers(
                    chunk.layers.values_of(self.kept, pixel),
                    self.mattes_of(&chunk.layers, pixel),
                    to,
                );
            }
        }
    }

    /// Reads the data that [`Self::write_tile`] has written: sums replace those of the tile, and chunks follow the
    /// samples of the tile. Returns the number of samples at the end of the tile's data, if there are any.
    pub fn read_tile(&mut self, tile: Tile, from: &mut Reader) -> Result<Option<u32>, Damaged> {
        let mut end = None;
        let pixels = (tile.width * tile.height) as usize;
        if from.flag()? {
            // A share has no sums: earlier samples are in other shares.
            if self.chunks.is_some() {
                return Err(Damaged);
            }
            for index in self.places_of(tile).collect::<Vec<_>>() {
                self.sums[index] = read_sum(from)?;
                self.counts[index] = from.u32()?;
                end = end.max(Some(self.counts[index]));
                self.noted[index] = [from.finite()?, from.finite()?];
                self.first_hits[index] = read_hit(from)?;
                let (values, mattes) = (self.kept.values(), self.kept.matte_count());
                from.finites(&mut self.layers.values[index * values..][..values])?;
                for matte in &mut self.layers.mattes[index * mattes..][..mattes] {
                    *matte = read_matte(u32::MAX, from)?;
                }
            }
            let blocks = self.tile_index(tile.x, tile.y) * BLOCKS;
            for error in &mut self.errors[blocks..blocks + BLOCKS] {
                *error = BlockError {
                    noted: from.u32()?,
                    level: from.u32()?,
                    difference: read_estimate(from)?,
                    difference_before: read_estimate(from)?,
                    spread: read_estimate(from)?,
                    luminance: read_estimate(from)?,
                };
            }
            self.find_efficiency(self.tile_index(tile.x, tile.y));
            let chunks = from.u32()?;
            let chunk = match chunks {
                0 => None,
                _ => Some(read_chunk(tile, pixels, self.kept, from)?),
            };
            // The counts include the samples of the incomplete chunk, which are added below.
            let length = chunk.as_ref().map_or(0, |chunk| chunk.samples.len() as u32);
            for index in self.places_of(tile).collect::<Vec<_>>() {
                let count = self.counts[index].checked_sub(length).ok_or(Damaged)?;
                self.counts[index] = count;
                let total = |matte: &Matte| matte.entries().map(|entry| u64::from(entry.samples)).sum::<u64>();
                let mut totals = self.mattes_of(&self.layers, index).iter().map(total);
                // Without further samples, old values may remain, which are never read.
                if count > 0 && totals.any(|total| total > u64::from(count)) {
                    return Err(Damaged);
                }
            }
            if let Some(chunk) = &chunk {
                self.add(chunk);
            }
            return if chunks > 1 { Err(Damaged) } else { Ok(end) };
        }
        for _ in 0..from.u32()? {
            let chunk = read_chunk(tile, pixels, self.kept, from)?;
            let length = chunk.samples.len() as u32;
            let mut counts = self.places_of(tile).map(|index| self.counts[index]);
            if counts.any(|count| count.checked_add(length).is_none()) {
                return Err(Damaged);
            }
            end = Some(chunk.samples.end);
            self.add(&chunk);
        }
        Ok(end)
    }

    /// Writes the sums of the splats of all pixels that have any.
    pub fn write_splats(&self, to: &mut Writer) {
        to.u64(self.splats.paths);
        let sums = || {
            self.splats
                .sums
                .iter()
                .zip(0..)
                .filter(|(sum, _)| **sum != SplatSum::default())
        };
        to.u32(sums().count() as u32);
        for (sum, place) in sums() {
            to.u32(place);
            sum.radiance.into_iter().for_each(|value| to.i128(value));
            to.i128(sum.luminance_squared);
        }
    }

    /// Adds the data that [`Self::write_splats`] has written to the film's splats.
    pub fn read_splats(&mut self, from: &mut Reader) -> Result<(), Damaged> {
        let paths = from.u64()?;
        self.splats.paths = self.splats.paths.checked_add(paths).ok_or(Damaged)?;
        let places = self.sums.len();
        for _ in 0..from.u32()? {
            let place = from.u32()? as usize;
            let radiance = [from.i128()?, from.i128()?, from.i128()?];
            let luminance_squared = from.i128()?;
            if place >= places {
                return Err(Damaged);
            }
            self.splats.sums.resize(places, SplatSum::default());
            self.splats.sums[place].append(&SplatSum {
                radiance,
                luminance_squared,
            });
        }
        Ok(())
    }

    pub(super) fn places_of(&self, tile: Tile) -> impl Iterator<Item = usize> + use<> {
        let start = self.index(tile.x, tile.y);
        let step = crate::render::tile::TILE as usize;
        (0..tile.height as usize).flat_map(move |y| (0..tile.width as usize).map(move |x| start + y * step + x))
    }

    fn mattes_of<'a>(&self, layers: &'a LayerSums, pixel: usize) -> &'a [Matte] {
        let count = self.kept.matte_count();
        &layers.mattes[pixel * count..][..count]
    }
}

fn read_chunk(tile: Tile, pixels: usize, kept: FilmLayers, from: &mut Reader) -> Result<TileSamples, Damaged> {
    let samples = from.u32()?..from.u32()?;
    let has_hits = from.flag()?;
    let mut chunk = TileSamples {
        tile,
        samples,
        blocks: None,
        pixels: Vec::with_capacity(pixels),
        layers: LayerSums::with_capacity(kept, pixels),
        first_hits: Vec::new(),
        splats: Default::default(),
        rays: 0,
        invalid: 0,
    };
    chunk.layers.resize(kept, pixels);
    let (values, mattes) = (kept.values(), kept.matte_count());
    for pixel in 0..pixels {
        chunk.pixels.push(read_sum(from)?);
        if has_hits {
            chunk.first_hits.push(read_hit(from)?);
        }
        from.finites(&mut chunk.layers.values[pixel * values..][..values])?;
        for matte in &mut chunk.layers.mattes[pixel * mattes..][..mattes] {
            *matte = read_matte(chunk.samples.len() as u32, from)?;
        }
    }
    if chunk.samples.is_empty() {
        Err(Damaged)
    } else {
        Ok(chunk)
    }
}

fn write_sum(sum: &PixelSum, to: &mut Writer) {
    for vector in [sum.radiance, sum.albedo, sum.normal] {
        vector.to_array().into_iter().for_each(|value| to.f32(value));
    }
    to.f32(sum.depth);
    to.f32(sum.luminance_squared);
    to.f32(sum.rays);
}

/// Reads the sums of a pixel. They are finite, because samples that are not finite count as black.
fn read_sum(from: &mut Reader) -> Result<PixelSum, Damaged> {
    let mut values = [0.0; 10];
    from.finites(&mut values)?;
    Ok(PixelSum {
        radiance: Rgb::from_slice(&values[..3]),
        albedo: Rgb::from_slice(&values[3..6]),
        normal: Vec3::from_slice(&values[6..9]),
        depth: values[9],
        luminance_squared: read_estimate(from)?,
        rays: from.finite()?,
    })
}

/// Reads a number made of squares of light, which may be infinite, but not NaN.
fn read_estimate(from: &mut Reader) -> Result<f32, Damaged> {
    from.f32()
        .and_then(|number| if number.is_nan() { Err(Damaged) } else { Ok(number) })
}

fn write_hit(hit: Option<&FirstHit>, to: &mut Writer) {
    to.u32(u32::from(hit.is_some()));
    if let Some(hit) = hit {
        to.u32(hit.instance);
        to.u32(hit.material.0);
        hit.uv.to_array().into_iter().for_each(|value| to.f32(value));
    }
}

fn read_hit(from: &mut Reader) -> Result<Option<FirstHit>, Damaged> {
    if !from.flag()? {
        return Ok(None);
    }
    Ok(Some(FirstHit {
        instance: from.u32()?,
        material: MaterialId(from.u32()?),
        uv: Vec2::new(from.finite()?, from.finite()?),
    }))
}

fn write_layers(values: &[f32], mattes: &[Matte], to: &mut Writer) {
    values.iter().for_each(|&value| to.f32(value));
    for matte in mattes {
        to.u32(matte.entries().count() as u32);
        for MatteEntry { id, samples } in matte.entries() {
            [id, samples].into_iter().for_each(|number| to.u32(number));
        }
    }
}

/// Reads the ids in a pixel, which together have at most `samples_left` samples.
fn read_matte(mut samples_left: u32, from: &mut Reader) -> Result<Matte, Damaged> {
    let mut matte = Matte::default();
    for _ in 0..from.u32()? {
        let (id, samples) = (from.u32()?, from.u32()?);
        samples_left = samples_left.checked_sub(samples).ok_or(Damaged)?;
        matte.add_entry(MatteEntry { id, samples });
    }
    Ok(matte)
}
