//! Triangles in the plane of a lightmap, in units of texels.

use glam::{UVec2, Vec2, Vec3};

/// Twice the signed area of a triangle.
pub(super) fn area([a, b, c]: [Vec2; 3]) -> f32 {
    (b - a).perp_dot(c - a)
}

/// The first texel that a triangle may touch and the end of these texels, clipped to `first` and `end`.
pub(super) fn touched(corners: [Vec2; 3], [first, end]: [UVec2; 2]) -> [UVec2; 2] {
    let low = corners.into_iter().fold(Vec2::INFINITY, Vec2::min);
    let high = corners.into_iter().fold(Vec2::NEG_INFINITY, Vec2::max);
    if !(low.is_finite() && high.is_finite()) {
        return [UVec2::ZERO; 2];
    }
    // Casts saturate, which clips to the page.
    let low = (low - 0.5).floor().max(Vec2::ZERO).as_uvec2();
    let high = (high + 0.5).ceil().max(Vec2::ZERO).as_uvec2();
    [low.max(first), high.min(end)]
}

/// The point of a triangle that is nearest to `point`.
pub(super) fn nearest_point(corners: [Vec2; 3], point: Vec2) -> Vec2 {
    let weights = weights(corners, point);
    if weights.min_element() >= 0.0 {
        return point;
    }
    let [a, b, c] = corners;
    let on_edge = |(a, b): (Vec2, Vec2)| {
        let edge = b - a;
        let along = (point - a).dot(edge) / edge.length_squared().max(f32::MIN_POSITIVE);
        a + edge * along.clamp(0.0, 1.0)
    };
    let edges = [(a, b), (b, c), (c, a)].map(on_edge);
    let nearer = |a: Vec2, b: Vec2| {
        if b.distance_squared(point) < a.distance_squared(point) {
            b
        } else {
            a
        }
    };
    nearer(nearer(edges[0], edges[1]), edges[2])
}

/// The barycentric coordinates of `point`.
pub(super) fn weights([a, b, c]: [Vec2; 3], point: Vec2) -> Vec3 {
    let whole = area([a, b, c]);
    let of_b = area([a, point, c]) / whole;
    let of_c = area([a, b, point]) / whole;
    Vec3::new(1.0 - of_b - of_c, of_b, of_c)
}

/// Barycentric coordinates clamped to the triangle: in a thin one they may be a little outside.
pub(super) fn clamped(weights: Vec3) -> Vec3 {
    let weights = weights.clamp(Vec3::ZERO, Vec3::ONE);
    weights / weights.element_sum()
}
