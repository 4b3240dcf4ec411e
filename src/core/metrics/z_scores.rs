//! Errors in units of their standard deviation, for pictures whose noise is known.
//!
//! The pixels of two unbiased pictures have z-scores of mean 0 and of root mean square 1; 0.27 % of them are beyond 3
//! if the noise is Gaussian. So z-scores tell a real difference from noise, which errors alone cannot.

use serde::Serialize;

use crate::color::Rgb;

/// Figures of the z-scores of all components whose variance is known.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct ZScores {
    /// The mean, which bias shifts away from 0.
    pub mean: f32,
    /// The root mean square.
    pub rms: f32,
    /// The share of z-scores beyond 3 and -3, in [0, 1].
    pub beyond_three: f32,
    /// The number of components with a variance above zero.
    pub count: u64,
}

/// The z-scores of the difference of two pictures. `variances` belong to the values of the first and of the second
/// picture, None for an exact one; each has as many pixels as the pictures. None if sizes differ or no component has a
/// variance.
pub fn z_scores(picture: &[Rgb], reference: &[Rgb], variances: [Option<&[Rgb]>; 2]) -> Option<ZScores> {
    let is_wrong = |variance: &&[Rgb]| variance.len() != picture.len();
    if picture.len() != reference.len() || variances.iter().flatten().any(is_wrong) {
        return None;
    }
    let (mut sum, mut squares, mut beyond, mut count) = (0.0, 0.0, 0_u64, 0_u64);
    for (i, (a, b)) in picture.iter().zip(reference).enumerate() {
        let variance: Rgb = variances.iter().flatten().map(|variance| variance[i]).sum();
        for axis in 0..3 {
            let z = (a[axis] - b[axis]) / variance[axis].sqrt();
            if variance[axis] > 0.0 && z.is_finite() {
                let z = f64::from(z);
                sum += z;
                squares += z * z;
                beyond += u64::from(z.abs() > 3.0);
                count += 1;
            }
        }
    }
    let share = 1.0 / count as f64;
    (count > 0).then_some(ZScores {
        mean: (sum * share) as f32,
        rms: (squares * share).sqrt() as f32,
        beyond_three: (beyond as f64 * share) as f32,
        count,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn differences_are_measured_in_deviations() {
        let picture = [Rgb::new(1.0, 2.0, 3.0), Rgb::splat(4.0)];
        let reference = [Rgb::new(2.0, 2.0, 3.0), Rgb::splat(1.0)];
        // Deviations: (1, none, none) and 0.6 = sqrt(0.16 + 0.2): z = -1 and three times 5.
        let noise = [Rgb::X, Rgb::splat(0.16)];
        let more = [Rgb::ZERO, Rgb::splat(0.2)];
        let found = z_scores(&picture, &reference, [Some(&noise), Some(&more)]).expect("variances");
        assert_eq!(found.count, 4);
        assert!((found.mean - 14.0 / 4.0).abs() < 1e-5, "{found:?}");
        assert!((found.rms - (76.0f32 / 4.0).sqrt()).abs() < 1e-5, "{found:?}");
        assert_eq!(found.beyond_three, 0.75);
        assert_eq!(z_scores(&picture, &reference, [None, None]), None);
        assert_eq!(z_scores(&picture, &reference, [Some(&noise[..1]), None]), None);
    }
}
