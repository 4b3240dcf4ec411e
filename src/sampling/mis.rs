//! Weights of multiple importance sampling.

/// The power heuristic with exponent 2 (Veach 1997, section 9.2) for one sample from each of two techniques: the weight of a sample
/// that was drawn with density `pdf` and could have been drawn by the other technique with density `other_pdf`.
///
/// Both in the same measure. Zero if the sample was impossible (`pdf` 0); a density without bound wins; two of those share. No
/// overflow for any finite densities.
pub fn power_heuristic(pdf: f32, other_pdf: f32) -> f32 {
    if pdf == 0.0 {
        return 0.0;
    }
    if pdf.is_infinite() {
        return if other_pdf.is_infinite() { 0.5 } else { 1.0 };
    }
    let ratio = other_pdf / pdf;
    1.0 / (1.0 + ratio * ratio)
}

#[cfg(test)]
mod tests {
    use super::*;

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
        assert!((power_heuristic(1.0, 2.0) - 0.2).abs() < 1e-6);
    }
}
