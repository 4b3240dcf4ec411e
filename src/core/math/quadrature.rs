//! Gauss-Legendre quadrature.

use std::f64::consts::PI;

/// The `count` nodes, ascending in (0, 1), and weights, adding to 1, that integrate polynomials of degree 2 `count` - 1
/// over the unit interval exactly. Newton's method on the Legendre polynomial (Press et al., Numerical Recipes, section
/// 4.6).
pub(crate) fn gauss_legendre(count: u32) -> Vec<(f32, f32)> {
    let n = f64::from(count);
    (0..count)
        .rev()
        .map(|i| {
            let mut x = (PI * (f64::from(i) + 0.75) / (n + 0.5)).cos();
            let mut derivative = 0.0;
            // The guess is good to 1e-3 and worse at count 1 only; the steps double the digits.
            for _ in 0..6 {
                let (mut previous, mut value) = (0.0, 1.0);
                for k in 0..count {
                    let k = f64::from(k);
                    (previous, value) = (value, ((2.0 * k + 1.0) * x * value - k * previous) / (k + 1.0));
                }
                derivative = n * (x * value - previous) / (x * x - 1.0);
                x -= value / derivative;
            }
            let weight = 1.0 / ((1.0 - x * x) * derivative * derivative);
            ((0.5 + 0.5 * x) as f32, weight as f32)
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn polynomials_are_integrated() {
        for count in [1, 2, 5, 32] {
            let nodes = gauss_legendre(count);
            assert!(nodes.is_sorted_by(|a, b| a.0 < b.0) && nodes[0].0 > 0.0 && nodes[nodes.len() - 1].0 < 1.0);
            for degree in 0..(2 * count).min(12) {
                let integral: f32 = nodes.iter().map(|(x, w)| w * x.powi(degree as i32)).sum();
                assert!(
                    (integral * (degree + 1) as f32 - 1.0).abs() < 1e-5,
                    "{count} {degree}: {integral}"
                );
            }
        }
    }
}
