//! Blocks of pixels: the smallest parts of a picture that can have their own number of samples.

use crate::render::tile::{TILE, Tile};

/// The edge of a block in pixels.
pub(in crate::render) const BLOCK: u32 = 2;
/// The number of blocks in a row of a tile.
const COLUMNS: u32 = TILE / BLOCK;
/// The number of blocks in a tile.
pub(in crate::render) const BLOCKS: usize = (COLUMNS * COLUMNS) as usize;

/// A value for each block of a tile, row by row.
pub type PerBlock<T> = [T; BLOCKS];

/// The block of the pixel at (x, y) among those of its tile.
pub(in crate::render) fn block_of(x: u32, y: u32) -> usize {
    (y % TILE / BLOCK * COLUMNS + x % TILE / BLOCK) as usize
}

/// The parts of a rectangle with edges of `edge` pixels, row by row; those at the right and lower edge may be smaller.
pub(in crate::render) fn parts(tile: Tile, edge: u32) -> impl Iterator<Item = Tile> {
    let starts = move |length: u32| (0..length).step_by(edge as usize);
    starts(tile.height).flat_map(move |y| {
        starts(tile.width).map(move |x| Tile {
            x: tile.x + x,
            y: tile.y + y,
            width: edge.min(tile.width - x),
            height: edge.min(tile.height - y),
        })
    })
}

/// The blocks of a tile that are in the picture, with their indices in [`PerBlock`].
pub(in crate::render) fn blocks_of(tile: Tile) -> impl Iterator<Item = (usize, Tile)> {
    parts(tile, BLOCK).map(|block| (block_of(block.x, block.y), block))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn blocks_cover_a_tile_once() {
        let tile = Tile {
            x: 64,
            y: 32,
            width: 19,
            height: 32,
        };
        let pixels: u32 = blocks_of(tile).map(|(_, block)| block.width * block.height).sum();
        assert_eq!(pixels, 19 * 32);
        let mut places: Vec<usize> = blocks_of(tile).map(|(place, _)| place).collect();
        places.dedup();
        assert_eq!(places.len(), 10 * 16);
        assert!(places.is_sorted() && places.iter().all(|&place| place < BLOCKS));
    }
}
