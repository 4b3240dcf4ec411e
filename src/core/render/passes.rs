//! The division of a pixel's samples: passes, which are rendered in one go, and chunks, at whose ends a picture may be
//! cut into shares.
//!
//! A sum of floating-point numbers depends on its grouping, and equal seeds shall give equal bits, however a picture
//! was rendered. So the grouping is fixed. The samples of a pass are summed up from zero, the passes of a chunk are
//! summed up from zero, and the film adds chunk after chunk. A program that renders the samples from the end of one
//! chunk to the end of another only has to keep the sums of its chunks, and the film adds them later as if it had
//! rendered them itself.
//!
//! Chunks are as long as an eighth of the samples before them, so that a share of a long picture has few of them. Up to
//! 256 samples each pass is a chunk. Sums of sums also lose fewer digits than one long sum (Higham, The accuracy of
//! floating point summation, SIAM Journal on Scientific Computing 14(4), 1993).

use std::iter::successors;
use std::ops::Range;

/// The longest pass, in samples per pixel.
const LONGEST_PASS: u32 = 16;
/// The number of chunks between one power of two and the next.
const CHUNKS_TO_DOUBLE: u32 = 8;

/// The end of the pass that begins after `done` samples: passes of 1, 1, 2, 4, 8, 16, 16, ... samples.
pub fn pass_end(done: u32) -> u32 {
    if done < LONGEST_PASS {
        done.saturating_add(1).next_power_of_two()
    } else {
        (done / LONGEST_PASS).saturating_add(1).saturating_mul(LONGEST_PASS)
    }
}

/// The chunk of sample number `sample`, counted from 0.
pub fn chunk_of(sample: u32) -> Range<u32> {
    if sample < LONGEST_PASS {
        let start = sample.checked_ilog2().map_or(0, |power| 1 << power);
        return start..pass_end(start);
    }
    let length = ((1 << sample.ilog2()) / CHUNKS_TO_DOUBLE).max(LONGEST_PASS);
    let start = sample / length * length;
    start..start.saturating_add(length)
}

/// The number of chunks that these samples touch.
pub fn chunks_in(samples: Range<u32>) -> u64 {
    let starts = successors(Some(samples.start), |&start| Some(chunk_of(start).end));
    starts.take_while(|&start| start < samples.end).count() as u64
}

/// Whether a picture may be cut before sample number `sample`.
pub fn is_cut(sample: u32) -> bool {
    chunk_of(sample).start == sample
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn chunks_are_counted() {
        assert_eq!(chunks_in(0..0), 0);
        // 0..1, 1..2, 2..4, 4..8 and 8..16
        assert_eq!(chunks_in(0..16), 5);
        assert_eq!(
            [chunks_in(16..256), chunks_in(256..512), chunks_in(256..513)],
            [15, 8, 9]
        );
        assert_eq!(chunks_in(1 << 31..u32::MAX), 8);
    }

    #[test]
    fn passes_double_and_then_stay() {
        let ends = |n| {
            std::iter::successors(Some(0), |&done| Some(pass_end(done)))
                .take(n)
                .collect::<Vec<_>>()
        };
        assert_eq!(ends(9), [0, 1, 2, 4, 8, 16, 32, 48, 64]);
        assert_eq!(pass_end(37), 48);
        assert_eq!(pass_end(u32::MAX), u32::MAX);
    }

    #[test]
    fn chunks_are_whole_passes_and_end_at_powers_of_two() {
        let ends: Vec<u32> = std::iter::successors(Some(0), |&end| Some(chunk_of(end).end))
            .take(80)
            .collect();
        assert_eq!(ends[..10], [0, 1, 2, 4, 8, 16, 32, 48, 64, 80]);
        assert_eq!(ends[19..23], [240, 256, 288, 320]);
        assert!((0..12).all(|power| ends.contains(&(1 << power))));
        assert!(ends.iter().all(|&end| is_cut(end) && (end < 16 || end % 16 == 0)));
        // Eight equal shares of a power of two from 128 on.
        assert!((7..20).all(|power| (0..8).all(|share| is_cut((1 << power) / 8 * share))));
        assert!(!is_cut(300) && !is_cut(1000));
        assert!((0..5000).all(|sample| chunk_of(sample).contains(&sample)));
        assert_eq!(chunk_of(300), 288..320);
        assert_eq!(chunk_of(u32::MAX).end, u32::MAX);
    }
}
