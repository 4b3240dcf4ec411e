//! Convolves planes of numbers with separable kernels: products of two one-dimensional ones. Beyond the border the
//! nearest number is repeated.

use rayon::prelude::*;

/// A plane whose value at (x, y) is the sum of `horizontal[i] * vertical[j] * plane(x + i - r, y + j - r)`, where r is
/// half the length of each kernel, which is odd. The plane has at least one row of `width` numbers.
pub fn convolve(plane: &[f32], width: usize, horizontal: &[f32], vertical: &[f32]) -> Vec<f32> {
    let height = plane.len() / width;
    let mut across = vec![0.0; plane.len()];
    let radius = horizontal.len() / 2;
    across
        .par_chunks_mut(width)
        .zip(plane.par_chunks(width))
        .for_each(|(out, row)| {
            let mut wide = vec![row[0]; width + 2 * radius];
            wide[radius..radius + width].copy_from_slice(row);
            wide[radius + width..].fill(row[width - 1]);
            for (offset, weight) in horizontal.iter().enumerate() {
                accumulate(out, *weight, &wide[offset..offset + width]);
            }
        });
    let radius = vertical.len() / 2;
    let mut result = vec![0.0; plane.len()];
    result.par_chunks_mut(width).enumerate().for_each(|(y, out)| {
        for (offset, weight) in vertical.iter().enumerate() {
            let from = (y + offset).saturating_sub(radius).min(height - 1) * width;
            accumulate(out, *weight, &across[from..from + width]);
        }
    });
    result
}

fn accumulate(sum: &mut [f32], weight: f32, row: &[f32]) {
    sum.iter_mut()
        .zip(row)
        .for_each(|(sum, number)| *sum += weight * number);
}

/// The values of `weight` at the whole numbers from `-radius` to `radius`.
pub fn kernel(radius: usize, weight: impl Fn(f32) -> f32) -> Vec<f32> {
    let radius = radius as i32;
    (-radius..=radius).map(|x| weight(x as f32)).collect()
}

/// The kernel of [`kernel`], scaled to the sum 1.
pub fn normalized_kernel(radius: usize, weight: impl Fn(f32) -> f32) -> Vec<f32> {
    let weights = kernel(radius, weight);
    let sum: f32 = weights.iter().sum();
    weights.into_iter().map(|weight| weight / sum).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn borders_go_on_and_kernels_have_a_direction() {
        let plane = [1.0, 2.0, 3.0, 10.0, 20.0, 30.0];
        // The upper left neighbour.
        let found = convolve(&plane, 3, &[1.0, 0.0, 0.0], &[1.0, 0.0, 0.0]);
        assert_eq!(found, [1.0, 1.0, 2.0, 1.0, 1.0, 2.0]);
        // The pixel two to the right, times minus two of the pixel two below.
        let found = convolve(&plane, 3, &[0.0, 0.0, 0.0, 0.0, 1.0], &[0.0, 0.0, 0.0, 0.0, -2.0]);
        assert_eq!(found, [-60.0; 6]);
        // A single pixel is repeated all around.
        assert_eq!(convolve(&[5.0], 1, &[0.25, 0.5, 0.25], &[0.25, 0.5, 0.25]), [5.0]);
    }
}
