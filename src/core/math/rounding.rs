//! Bounds on accumulated rounding, after PBR 4th ed. section 6.8.1.

/// The largest relative error after `n` correctly rounded f32 operations in a row.
pub(crate) const fn gamma(n: u32) -> f32 {
    let half_ulp = 0.5 * f32::EPSILON;
    n as f32 * half_ulp / (1.0 - n as f32 * half_ulp)
}
