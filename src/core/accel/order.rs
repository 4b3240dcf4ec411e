//! Sorts the children that a ray meets from far to near, so that a traversal can push them on its stack as they are.
//!
//! The sort of eight lanes has no branches (bitonic: Batcher, Sorting networks and their applications, 1968), because
//! processors cannot predict how many children are met and in which order.

use wide::{f32x8, u32x4, u32x8};

use super::node::WIDTH;

/// Sorted children. Those that the ray meets come first in both arrays; the remaining entries are arbitrary.
#[derive(Clone, Copy, Debug)]
pub(super) struct FarToNear {
    /// The distances at which the ray enters, rounded down by at most 7 units in the last place.
    pub entries: [f32; WIDTH],
    pub children: [u32; WIDTH],
}

/// The lowest bits of an entry distance, which are replaced by the number of the lane.
const LANE: u32 = WIDTH as u32 - 1;
/// Flips all bits of a distance but the sign and the lane, so that the order of distances is reversed.
const REVERSED: u32 = !LANE & i32::MAX as u32;

/// Sorts `children` by `entries`, which are not negative. `met` has all bits set in the lanes whose box the ray meets
/// and none in the others.
#[inline(always)]
pub(super) fn far_to_near(entries: f32x8, met: f32x8, children: [u32; WIDTH]) -> FarToNear {
    let met: u32x8 = bytemuck::cast(met);
    // Children that are not met come last.
    let mut keys = keys(entries) | !met;

    // Each lane is compared with a partner; the upper one of the two keeps the greater.
    let mut exchange = |partner: [u32; WIDTH]| {
        let other = keys.shuffle_wrapping(u32x8::new(partner));
        let is_upper = std::array::from_fn(|lane| if partner[lane] < lane as u32 { u32::MAX } else { 0 });
        keys = u32x8::new(is_upper).bitselect(keys.max(other), keys.min(other));
    };
    exchange([1, 0, 3, 2, 5, 4, 7, 6]);
    exchange([3, 2, 1, 0, 7, 6, 5, 4]);
    exchange([1, 0, 3, 2, 5, 4, 7, 6]);
    exchange([7, 6, 5, 4, 3, 2, 1, 0]);
    exchange([2, 3, 0, 1, 6, 7, 4, 5]);
    exchange([1, 0, 3, 2, 5, 4, 7, 6]);

    FarToNear {
        entries: bytemuck::cast((keys ^ REVERSED) & !LANE),
        children: u32x8::new(children).shuffle_wrapping(keys).to_array(),
    }
}

/// The lane of the nearest child that is met, the one that [`far_to_near`] puts last. At least one must be met.
#[inline(always)]
pub(super) fn nearest(entries: f32x8, met: f32x8) -> usize {
    let met: u32x8 = bytemuck::cast(met);
    let [low, high]: [u32x4; 2] = bytemuck::cast(keys(entries) & met);
    let [a, b, c, d] = low.max(high).to_array();
    (a.max(b).max(c.max(d)) & LANE) as usize
}

/// Sort keys: greater for nearer children, and all different, since the lane is in the lowest bits.
#[inline(always)]
fn keys(entries: f32x8) -> u32x8 {
    let distance: u32x8 = bytemuck::cast(entries);
    let lanes = u32x8::new([0, 1, 2, 3, 4, 5, 6, 7]);
    ((distance & !LANE) | lanes) ^ REVERSED
}

/// Puts the children whose bits are set in `met` first, in their order; the remaining entries are arbitrary.
#[inline(always)]
pub(super) fn met_first(met: u32, children: [u32; WIDTH]) -> [u32; WIDTH] {
    let lanes = u32x8::new(LANES_OF[met as usize % LANES_OF.len()]);
    u32x8::new(children).shuffle_wrapping(lanes).to_array()
}

/// The positions of the bits set in each byte, followed by zeros.
static LANES_OF: [[u32; WIDTH]; 1 << WIDTH] = {
    let mut table = [[0; WIDTH]; 1 << WIDTH];
    let mut mask = 0;
    while mask < table.len() {
        let (mut lane, mut count) = (0, 0);
        while lane < WIDTH {
            if mask >> lane & 1 == 1 {
                table[mask][count] = lane as u32;
                count += 1;
            }
            lane += 1;
        }
        mask += 1;
    }
    table
};

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn children_that_are_met_come_first() {
        for mask in 0..1u32 << WIDTH {
            let children = met_first(mask, [0, 1, 2, 3, 4, 5, 6, 7]);
            let expected = (0..WIDTH as u32).filter(|lane| mask >> lane & 1 == 1);
            assert!(expected.eq(children.into_iter().take(mask.count_ones() as usize)));
        }
    }

    #[test]
    fn children_come_from_far_to_near() {
        let distances = [0.0, 3.5, f32::MIN_POSITIVE, 1e30, 3.5, 1.0, f32::MAX, 2.0];
        let children = [10, 11, 12, 13, 14, 15, 16, 17];
        for rotation in 0..WIDTH {
            let mut entries = distances;
            entries.rotate_left(rotation);
            for mask in 0..1u32 << WIDTH {
                let met = std::array::from_fn(|lane| f32::from_bits(if mask >> lane & 1 == 1 { u32::MAX } else { 0 }));
                let sorted = far_to_near(f32x8::from(entries), f32x8::from(met), children);
                let count = mask.count_ones() as usize;
                assert!(sorted.entries[..count].is_sorted_by(|a, b| a >= b));
                let mut seen = 0;
                for (entry, child) in sorted.entries.into_iter().zip(sorted.children).take(count) {
                    let lane = child as usize - 10;
                    seen |= 1 << lane;
                    let below = entries[lane].to_bits() - entry.to_bits();
                    assert!(below < WIDTH as u32, "{entry} for {}", entries[lane]);
                }
                assert_eq!(seen, mask);
                if count > 0 {
                    let nearest = nearest(f32x8::from(entries), f32x8::from(met));
                    assert_eq!(children[nearest], sorted.children[count - 1]);
                }
            }
        }
    }
}
