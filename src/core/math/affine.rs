use glam::{Affine3A, Vec3};

/// Whether the map can be inverted: its three axes, whatever their lengths, span a space. They do if the volume of the
/// box of unit edges along them is well above the rounding of single precision.
pub fn is_invertible(map: &Affine3A) -> bool {
    const LEAST_VOLUME: f32 = 1e-6;
    let axes =
        [map.matrix3.x_axis, map.matrix3.y_axis, map.matrix3.z_axis].map(|axis| Vec3::from(axis).try_normalize());
    let [Some(x), Some(y), Some(z)] = axes else {
        return false;
    };
    map.is_finite() && map.inverse().is_finite() && x.cross(y).dot(z).abs() > LEAST_VOLUME
}
