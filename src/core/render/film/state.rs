//! The exact state of a film tile by tile as bytes, for parts and checkpoints ([`crate::render::part`]).

use super::Film;
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
        to.put(u32::from(self.chunks.is_none()));
        if self.chunks.is_none() {
            for index in self.places_of(tile) {
                to.put(self.sums[index]);
                to.put(self.counts[index]);
                to.put(self.noted[index]);
                write_hit(self.first_hits[index], to);
                write_layers(
                    self.layers.values_of(self.kept, index),
                    self.mattes_of(&self.layers, index),
                    to,
                );
            }
            let blocks = self.tile_index(tile.x, tile.y) * BLOCKS;
            to.put_all(&self.errors[blocks..blocks + BLOCKS]);
        }
        to.put(self.chunks_of(tile).count() as u32);
        for chunk in self.chunks_of(tile) {
            to.put([chunk.samples.start, chunk.samples.end]);
            to.put(u32::from(!chunk.first_hits.is_empty()));
            for (pixel, sum) in chunk.pixels.iter().enumerate() {
                to.put(*sum);
                if let Some(hit) = chunk.first_hits.get(pixel) {
                    write_hit(*hit, to);
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
            // A share has no sums: what comes before its samples is in others.
            Damaged::unless(self.chunks.is_none())?;
            for index in self.places_of(tile).collect::<Vec<_>>() {
                self.sums[index] = read_sum(from)?;
                self.counts[index] = from.take()?;
                end = end.max(Some(self.counts[index]));
                from.finites(&mut self.noted[index])?;
                self.first_hits[index] = read_hit(from)?;
                let (values, mattes) = (self.kept.values(), self.kept.matte_count());
                from.finites(&mut self.layers.values[index * values..][..values])?;
                for matte in &mut self.layers.mattes[index * mattes..][..mattes] {
                    *matte = read_matte(u32::MAX, from)?;
                }
            }
            let blocks = self.tile_index(tile.x, tile.y) * BLOCKS;
            let errors = &mut self.errors[blocks..blocks + BLOCKS];
            from.fill(errors)?;
            Damaged::unless(!errors.iter().any(BlockError::has_nan))?;
            self.find_efficiency(self.tile_index(tile.x, tile.y));
            let chunks: u32 = from.take()?;
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
                // Where there are no other samples, old values may stand, which are not read.
                Damaged::unless(count == 0 || totals.all(|total| total <= u64::from(count)))?;
            }
            if let Some(chunk) = &chunk {
                self.add(chunk);
            }
            Damaged::unless(chunks <= 1)?;
            return Ok(end);
        }
        for _ in 0..from.take::<u32>()? {
            let chunk = read_chunk(tile, pixels, self.kept, from)?;
            let length = chunk.samples.len() as u32;
            let mut counts = self.places_of(tile).map(|index| self.counts[index]);
            Damaged::unless(counts.all(|count| count.checked_add(length).is_some()))?;
            end = Some(chunk.samples.end);
            self.add(&chunk);
        }
        Ok(end)
    }

    /// Writes the sums of the splats of all pixels that have any.
    pub fn write_splats(&self, to: &mut Writer) {
        to.put(self.splats.paths);
        let sums = || {
            self.splats
                .sums
                .iter()
                .zip(0..)
                .filter(|(sum, _)| **sum != SplatSum::default())
        };
        to.put(sums().count() as u32);
        for (sum, place) in sums() {
            to.put::<u32>(place);
            to.put(*sum);
        }
    }

    /// Adds the data that [`Self::write_splats`] has written to the film's splats.
    pub fn read_splats(&mut self, from: &mut Reader) -> Result<(), Damaged> {
        let paths = from.take()?;
        self.splats.paths = self.splats.paths.checked_add(paths).ok_or(Damaged)?;
        let places = self.sums.len();
        for _ in 0..from.take::<u32>()? {
            let place = from.take::<u32>()? as usize;
            Damaged::unless(place < places)?;
            self.splats.sums.resize(places, SplatSum::default());
            self.splats.sums[place].append(&from.take()?);
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
    let samples = from.take()?..from.take()?;
    Damaged::unless(!samples.is_empty())?;
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
    Ok(chunk)
}

/// Reads the sums of a pixel. As samples that are not finite count as black, sums are finite. That of squares may be
/// beyond all numbers, but is one.
fn read_sum(from: &mut Reader) -> Result<PixelSum, Damaged> {
    let sum: PixelSum = from.take()?;
    let vectors = [sum.radiance, sum.albedo, sum.normal];
    let is_finite = vectors.iter().all(|vector| vector.is_finite()) && sum.depth.is_finite() && sum.rays.is_finite();
    Damaged::unless(is_finite && !sum.luminance_squared.is_nan())?;
    Ok(sum)
}

fn write_hit(hit: Option<FirstHit>, to: &mut Writer) {
    to.put(u32::from(hit.is_some()));
    to.put_all(hit.as_slice());
}

fn read_hit(from: &mut Reader) -> Result<Option<FirstHit>, Damaged> {
    if !from.flag()? {
        return Ok(None);
    }
    let hit: FirstHit = from.take()?;
    Damaged::unless(hit.uv.is_finite())?;
    Ok(Some(hit))
}

fn write_layers(values: &[f32], mattes: &[Matte], to: &mut Writer) {
    to.put_all(values);
    for matte in mattes {
        to.put(matte.entries().count() as u32);
        matte.entries().for_each(|entry| to.put(entry));
    }
}

/// Reads the ids in a pixel, which together have at most `samples_left` samples.
fn read_matte(mut samples_left: u32, from: &mut Reader) -> Result<Matte, Damaged> {
    let mut matte = Matte::default();
    for _ in 0..from.take::<u32>()? {
        let entry: MatteEntry = from.take()?;
        samples_left = samples_left.checked_sub(entry.samples).ok_or(Damaged)?;
        matte.add_entry(entry);
    }
    Ok(matte)
}
