//! A histogram over directions, ready to be sampled.

use super::bins::BINS;

/// The units that a cell's bins share: each has a whole number of units, so that a number from 0 to 1 leads to its bin
/// without a search.
pub(in crate::render) const UNITS: usize = 255;

#[derive(Clone, Debug)]
#[repr(C, align(64))]
pub(in crate::render) struct Cell {
    /// The bin of each unit.
    bin_of_unit: [u8; 256],
    /// The first unit of each bin, times 256, and their number.
    units_of_bin: [u16; BINS],
    /// The part of a diffuse lobe's directions that is sampled from the histogram, from 0 to 1.
    part: f32,
}

impl Cell {
    /// A cell whose bins have these shares, which sum up to 1.
    pub fn new(shares: &[f32; BINS], part: f32) -> Self {
        let mut counts = shares.map(|share| (share * UNITS as f32) as usize);
        let mut left = UNITS.saturating_sub(counts.iter().sum());
        let mut order: Vec<usize> = (0..BINS).collect();
        let rest = |bin: usize| shares[bin] * UNITS as f32 - counts[bin] as f32;
        let rests: Vec<f32> = (0..BINS).map(rest).collect();
        order.sort_by(|&a, &b| rests[b].total_cmp(&rests[a]).then(a.cmp(&b)));
        for bin in order.into_iter().cycle() {
            if left == 0 {
                break;
            }
            counts[bin] += 1;
            left -= 1;
        }
        let mut cell = Self {
            bin_of_unit: [0; 256],
            units_of_bin: [0; BINS],
            part,
        };
        let mut start = 0;
        for (bin, &count) in counts.iter().enumerate() {
            let count = count.min(UNITS - start);
            cell.units_of_bin[bin] = (start << 8 | count) as u16;
            cell.bin_of_unit[start..start + count].fill(bin as u8);
            start += count;
        }
        cell
    }

    /// The part of a diffuse lobe's directions that is sampled from the histogram, from 0 to 1.
    #[inline(always)]
    pub fn part(&self) -> f32 {
        self.part
    }

    /// The bin of a unit, its first unit and their number.
    #[inline(always)]
    pub fn unit(&self, unit: u32) -> (u32, u32, u32) {
        let bin = self.bin_of_unit[unit as usize & 255];
        let units = u32::from(self.units_of_bin[usize::from(bin) & (BINS - 1)]);
        (u32::from(bin), units >> 8, units & 255)
    }

    /// The number of units of a bin.
    #[inline(always)]
    pub fn count(&self, bin: u32) -> u32 {
        u32::from(self.units_of_bin[bin as usize & (BINS - 1)]) & 255
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn units_are_those_of_their_bins() {
        let uneven = |bin: usize| if bin.is_multiple_of(3) { (bin + 1) as f32 } else { 0.01 };
        let all: f32 = (0..BINS).map(uneven).sum();
        let uneven = std::array::from_fn(|bin| uneven(bin) / all);
        let mut single = [0.0; BINS];
        single[77] = 1.0;
        for shares in [uneven, single, [1.0 / BINS as f32; BINS]] {
            let cell = Cell::new(&shares, 0.5);
            let counts: Vec<u32> = (0..BINS as u32).map(|bin| cell.count(bin)).collect();
            assert_eq!(counts.iter().sum::<u32>(), UNITS as u32);
            for (count, share) in counts.iter().zip(shares) {
                assert!((*count as f32 - share * UNITS as f32).abs() <= 1.0, "{count} {share}");
            }
            for unit in 0..UNITS as u32 {
                let (bin, first, count) = cell.unit(unit);
                assert_eq!(count, counts[bin as usize]);
                assert!((first..first + count).contains(&unit), "{unit} {bin}");
            }
        }
    }
}
