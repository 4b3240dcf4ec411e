//! Chunks in the film: a chunk is summed up from zero beside the film's sums, and added to them when it is complete.
//! Readers add both.

use std::borrow::Cow;

use super::Film;
use crate::render::layers::{LayerSums, Matte};
use crate::render::passes::chunk_of;
use crate::render::tile::{PixelSum, TILE, Tile, TileSamples};

/// Whether the samples reach the end of the chunk in which they begin.
pub(super) fn is_whole(samples: &TileSamples) -> bool {
    samples.samples.end >= chunk_of(samples.samples.start).end
}

/// A copy without splats, for the film's chunks.
pub(super) fn without_splats(samples: &TileSamples) -> TileSamples {
    TileSamples {
        splats: Default::default(),
        ..samples.clone()
    }
}

impl Film {
    /// Keeps the chunks from now on: the samples of a share, which start where another share ends.
    pub fn keep_chunks(&mut self) {
        self.chunks = Some(vec![Vec::new(); self.previews.len()]);
    }

    /// The chunks of a tile of a share, in the order of their samples. The last one may be incomplete.
    pub fn chunks_of(&self, tile: Tile) -> impl Iterator<Item = &TileSamples> {
        let place = self.tile_index(tile.x, tile.y);
        let kept = self.chunks.iter().flat_map(move |chunks| &chunks[place]);
        kept.chain(self.begun[place].as_deref())
    }

    /// Keeps an incomplete chunk, or adds a complete one to the sums.
    pub(super) fn add_if_whole(&mut self, place: usize, chunk: Box<TileSamples>) {
        match is_whole(&chunk) {
            true => self.add_chunk(&chunk),
            false => self.begun[place] = Some(chunk),
        }
    }

    /// Adds a chunk whose samples are in the counts.
    pub(super) fn add_chunk(&mut self, chunk: &TileSamples) {
        let (tile, width) = (chunk.tile, chunk.tile.width as usize);
        for (y, from) in (tile.y..).zip((0..chunk.pixels.len()).step_by(width)) {
            let row = self.index(tile.x, y)..self.index(tile.x, y) + width;
            let mut before = [0; TILE as usize];
            for ((x, before), count) in (tile.x..).zip(&mut before).zip(&self.counts[row.clone()]) {
                *before = count - chunk.count(x, y);
            }
            let before = &before[..width];
            self.layers.add(self.kept, row.start, &chunk.layers, from, before);
            for ((sum, before), new) in self.sums[row].iter_mut().zip(before).zip(&chunk.pixels[from..]) {
                if *before == 0 {
                    *sum = PixelSum::default();
                }
                sum.add(new);
            }
        }
        self.compare_halves(tile);
        let place = self.tile_index(tile.x, tile.y);
        if let Some(chunks) = &mut self.chunks {
            chunks[place].push(without_splats(chunk));
        }
    }

    /// The incomplete chunk of a pixel, the index of the pixel in it, and whether the film's sums have samples before
    /// it.
    pub(super) fn begun_at(&self, x: u32, y: u32) -> Option<(&TileSamples, usize, bool)> {
        let chunk = self.begun[self.tile_index(x, y)].as_deref()?;
        let place = (y - chunk.tile.y) * chunk.tile.width + (x - chunk.tile.x);
        Some((chunk, place as usize, self.samples(x, y) > chunk.count(x, y)))
    }

    /// The sum over all samples of a pixel, which must have some.
    pub(super) fn sum(&self, x: u32, y: u32) -> PixelSum {
        let mut sum = self.sums[self.index(x, y)];
        if let Some((chunk, place, has_more)) = self.begun_at(x, y) {
            if !has_more {
                sum = PixelSum::default();
            }
            sum.add(&chunk.pixels[place]);
        }
        sum
    }

    /// The sums of the layers over all samples of a pixel, which must have some.
    pub(super) fn layer_values(&self, x: u32, y: u32) -> Cow<'_, [f32]> {
        let values = self.layers.values_of(self.kept, self.index(x, y));
        match self.begun_at(x, y) {
            None => Cow::Borrowed(values),
            Some((chunk, place, has_more)) => {
                let new = chunk.layers.values_of(self.kept, place);
                match has_more {
                    true => values.iter().zip(new).map(|(sum, new)| sum + new).collect(),
                    false => Cow::Borrowed(new),
                }
            }
        }
    }

    /// A cryptomatte over all samples of a pixel, which must have some.
    pub(super) fn matte_sum(&self, x: u32, y: u32, place: usize) -> Matte {
        let count = self.kept.matte_count();
        let of = |layers: &LayerSums, pixel: usize| layers.mattes[pixel * count + place];
        let mut matte = of(&self.layers, self.index(x, y));
        if let Some((chunk, pixel, has_more)) = self.begun_at(x, y) {
            if !has_more {
                matte = Matte::default();
            }
            matte.merge(&of(&chunk.layers, pixel));
        }
        matte
    }
}
