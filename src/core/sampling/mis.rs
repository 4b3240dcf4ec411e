//! Weights of multiple importance sampling.

use crate::math::Real;

/// The power heuristic with exponent 2 (Veach 1997, section 9.2) for one sample from each of two techniques: the weight
/// of a sample that was drawn with density `pdf` and could have been drawn by the other technique with density
/// `other_pdf`.
///
/// Both densities are in the same measure. The weight is zero if the sample was impossible (`pdf` 0), one if only its
/// density is infinite, and one half if both are. No finite densities overflow.
#[inline(always)]
pub fn power_heuristic<R: Real>(pdf: R, other_pdf: R) -> R {
    let (zero, one) = (R::splat(0.0), R::splat(1.0));
    // Equal densities get equal weights, also where their ratio is NaN.
    let ratio = R::select(other_pdf.equals(pdf), one, other_pdf / pdf);
    R::select(pdf.equals(zero), zero, one / ratio.mul_add(ratio, one))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::lanes::{LANES, Lanes};

    #[test]
    fn weights_of_both_techniques_sum_to_one() {
        let densities = [1e-38, 1e-20, 0.5, 1.0, 3.0, 1e20, f32::MAX, f32::INFINITY];
        for a in densities {
            for b in densities {
                let sum = power_heuristic(a, b) + power_heuristic(b, a);
                assert!((sum - 1.0).abs() < 1e-6, "{a} {b} {sum}");
            }
            assert_eq!(power_heuristic(a, 0.0), 1.0);
            assert_eq!(power_heuristic(0.0, a), 0.0);
        }
        assert_eq!(power_heuristic(0.0, 0.0), 0.0);
        assert!((power_heuristic(1.0, 2.0) - 0.2f32).abs() < 1e-6);
    }

    #[test]
    fn weights_in_lanes_are_those_of_one() {
        let densities = [0.0, 1e-38, 1e-20, 0.5, 1.0, 3.0, 1e20, f32::MAX, f32::INFINITY];
        for a in densities {
            let others: [f32; LANES] = std::array::from_fn(|lane| densities[lane % densities.len()]);
            let weights = power_heuristic(Lanes::splat(a), others.into());
            for (&weight, b) in weights.as_array().iter().zip(others) {
                assert!((weight - power_heuristic(a, b)).abs() < 1e-6, "{a} {b} {weight}");
            }
        }
    }
}
