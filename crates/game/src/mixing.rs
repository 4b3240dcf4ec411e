//! Adds up the layers of a texture, each with a factor.

use half::f16;
use half::slice::HalfFloatSliceExt;

/// The largest half float.
pub(crate) const LARGEST: f32 = 65504.0;
/// Half floats that are mixed in one go: they stay in the cache of a core.
const RUN: usize = 4096;

/// The sum of layers of half floats (red, green, blue, alpha) times the factors of their colours, `length` bytes. Alpha
/// is 1. What a layer lacks is black.
pub(crate) fn mix<'a>(layers: impl Iterator<Item = (&'a [u8], [f32; 3])> + Clone, length: usize) -> Vec<u8> {
    let mut mixed = vec![0; length];
    let (mut sums, mut halves, mut numbers) = ([0.0; RUN], [f16::ZERO; RUN], [0.0; RUN]);
    for (run, target) in mixed.chunks_mut(2 * RUN).enumerate() {
        let count = target.len() / 2;
        sums.fill(0.0);
        for (bytes, [red, green, blue]) in layers.clone() {
            let bytes = bytes.get(2 * RUN * run..).unwrap_or_default();
            let pairs = bytes.chunks_exact(2).take(count);
            let given = pairs.len();
            for (half, pair) in halves.iter_mut().zip(pairs) {
                *half = f16::from_le_bytes([pair[0], pair[1]]);
            }
            halves[..given].convert_to_f32_slice(&mut numbers[..given]);
            let factors = [red, green, blue, 0.0];
            for (sum, number) in sums.chunks_exact_mut(4).zip(numbers[..given].chunks_exact(4)) {
                for channel in 0..4 {
                    sum[channel] += factors[channel] * number[channel];
                }
            }
        }
        for texel in sums.chunks_exact_mut(4) {
            texel[..3]
                .iter_mut()
                .for_each(|value| *value = value.clamp(0.0, LARGEST));
            texel[3] = 1.0;
        }
        halves[..count].convert_from_f32_slice(&sums[..count]);
        for (pair, half) in target.chunks_exact_mut(2).zip(&halves) {
            pair.copy_from_slice(&half.to_le_bytes());
        }
    }
    mixed
}

#[cfg(test)]
mod tests {
    use super::*;

    fn bytes(numbers: &[f32]) -> Vec<u8> {
        numbers
            .iter()
            .flat_map(|number| f16::from_f32(*number).to_le_bytes())
            .collect()
    }

    fn mixed(layers: &[(Vec<u8>, [f32; 3])]) -> Vec<u8> {
        let length = layers[0].0.len();
        mix(layers.iter().map(|(bytes, factor)| (&bytes[..], *factor)), length)
    }

    #[test]
    fn layers_are_added_with_the_factors_of_their_colours() {
        let one = bytes(&[1.0, 2.0, 3.0, 1.0, 0.5, 0.25, 8.0, 1.0]);
        let other = bytes(&[4.0, 0.0, 1.0, 1.0, 0.0, 1.0, 60000.0, 1.0]);
        assert_eq!(mixed(&[(one.clone(), [1.0; 3])]), one);
        let found = mixed(&[(one.clone(), [2.0, 1.0, 0.0]), (other.clone(), [0.5, 3.0, 1.0])]);
        assert_eq!(found, bytes(&[4.0, 2.0, 1.0, 1.0, 1.0, 3.25, 60000.0, 1.0]));
        // Beyond all half floats, and below nothing.
        let found = mixed(&[(other, [-1.0, 1.0, 3.0])]);
        assert_eq!(found, bytes(&[0.0, 0.0, 3.0, 1.0, 0.0, 1.0, 65504.0, 1.0]));
        // All lamps are off.
        assert_eq!(
            mixed(&[(one, [0.0; 3])]),
            bytes(&[0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0])
        );
    }

    #[test]
    fn every_run_of_a_long_texture_is_mixed() {
        let numbers: Vec<f32> = (0..3 * RUN + 8).map(|place| (place % 97) as f32 / 8.0).collect();
        let found = mixed(&[(bytes(&numbers), [1.0, 2.0, 4.0]), (bytes(&numbers), [0.0, 0.0, 1.0])]);
        let expected = numbers.iter().enumerate().map(|(place, number)| match place % 4 {
            3 => 1.0,
            channel => number * [1.0, 2.0, 5.0][channel],
        });
        assert!(found == bytes(&expected.collect::<Vec<_>>()));
    }
}
