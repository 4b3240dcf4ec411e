//! Cuts polygons into triangles.
//!
//! Convex polygons become the fan around their first corner, as in Mitsuba, so that non-planar quads crease along the
//! same diagonal. Concave ones, where a fan would leave the outline, lose one ear after the other (Meisters, "Polygons
//! have ears", 1975). Other polygons (self-intersecting, without area, with very many corners) become a fan too: some
//! picture, never a hang.

use glam::{DVec2, DVec3, Vec3};

/// The most corners of a polygon for ear clipping, whose time is quadratic in them, and worse in bad cases.
const MOST_CORNERS_TO_CLIP: usize = 512;

/// Calls `emit` with each triangle of a polygon, as indices into `corners`; always `corners.len() - 2` of them, in the
/// polygon's winding.
pub fn triangulate(corners: &[Vec3], mut emit: impl FnMut([usize; 3])) {
    let count = corners.len();
    if count > 3
        && count <= MOST_CORNERS_TO_CLIP
        && let Some(outline) = flattened(corners)
        && !is_convex(&outline)
    {
        clip_ears(&outline, emit);
        return;
    }
    for i in 2..count {
        emit([0, i - 1, i]);
    }
}

/// The polygon projected onto its best-fitting plane, counter-clockwise; `None` without area.
fn flattened(corners: &[Vec3]) -> Option<Vec<DVec2>> {
    let origin = corners[0].as_dvec3();
    let local: Vec<DVec3> = corners.iter().map(|corner| corner.as_dvec3() - origin).collect();
    // Newell's normal: twice the projected area along each axis.
    let normal: DVec3 = (0..local.len())
        .map(|i| local[i].cross(local[(i + 1) % local.len()]))
        .sum();
    let size = normal.abs();
    if size.max_element() <= 0.0 || !normal.is_finite() {
        return None;
    }
    let project = |p: &DVec3| {
        if size.x >= size.y && size.x >= size.z {
            DVec2::new(p.y, p.z * normal.x.signum())
        } else if size.y >= size.z {
            DVec2::new(p.z, p.x * normal.y.signum())
        } else {
            DVec2::new(p.x, p.y * normal.z.signum())
        }
    };
    Some(local.iter().map(project).collect())
}

/// Twice the signed area of a triangle; positive if it is counter-clockwise.
fn turn(a: DVec2, b: DVec2, c: DVec2) -> f64 {
    (b - a).perp_dot(c - b)
}

fn is_convex(outline: &[DVec2]) -> bool {
    let count = outline.len();
    (0..count).all(|i| turn(outline[i], outline[(i + 1) % count], outline[(i + 2) % count]) >= 0.0)
}

fn clip_ears(outline: &[DVec2], mut emit: impl FnMut([usize; 3])) {
    let mut left: Vec<usize> = (0..outline.len()).collect();
    let mut is_left = vec![true; outline.len()];
    // For each corner the obstacle that keeps it from being an ear. It stays valid until the obstacle or a neighbour of
    // the corner is clipped.
    let mut obstacles: Vec<Option<usize>> = vec![None; outline.len()];
    let mut tip = 1;
    let mut tried = 0;
    while left.len() > 3 && tried < left.len() {
        let count = left.len();
        let [before, at, after] = [tip + count - 1, tip, tip + 1].map(|i| left[i % count]);
        if !obstacles[at].is_some_and(|other| is_left[other]) {
            obstacles[at] = obstacle(outline, &left, [before, at, after]);
        }
        if obstacles[at].is_none() {
            emit([before, at, after]);
            left.remove(tip % count);
            is_left[at] = false;
            (obstacles[before], obstacles[after]) = (None, None);
            tip = (tip + count - 1) % count % left.len();
            tried = 0;
        } else {
            tip = (tip + 1) % count;
            tried += 1;
        }
    }
    for i in 2..left.len() {
        emit([left[0], left[i - 1], left[i]]);
    }
}

/// The obstacle that keeps a corner from being an ear: another corner in the triangle with its neighbours, or the
/// corner itself, if the outline is concave there.
fn obstacle(outline: &[DVec2], left: &[usize], ear: [usize; 3]) -> Option<usize> {
    let [a, b, c] = ear.map(|i| outline[i]);
    if turn(a, b, c) <= 0.0 {
        return Some(ear[1]);
    }
    let is_outside = |p: DVec2| turn(a, b, p) < 0.0 || turn(b, c, p) < 0.0 || turn(c, a, p) < 0.0;
    left.iter().copied().find(|&i| {
        let p = outline[i];
        // Corners may coincide (a bridge to a hole); such a duplicate is no obstacle.
        p != a && p != b && p != c && !is_outside(p)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn triangles(corners: &[Vec3]) -> Vec<[usize; 3]> {
        let mut triangles = Vec::new();
        triangulate(corners, |triangle| triangles.push(triangle));
        triangles
    }

    /// The areas of all triangles, absolute and with the sign of their winding about `normal`: equal sums of both mean
    /// no overlap, and no part outside.
    fn areas(corners: &[Vec3], normal: Vec3) -> (f32, f32) {
        let signed: Vec<f32> = triangles(corners)
            .iter()
            .map(|t| {
                let [a, b, c] = t.map(|i| corners[i]);
                0.5 * (b - a).cross(c - a).dot(normal)
            })
            .collect();
        (signed.iter().sum(), signed.iter().map(|area| area.abs()).sum())
    }

    #[test]
    fn a_convex_polygon_is_a_fan_even_when_bent() {
        let quad = [Vec3::ZERO, Vec3::X, Vec3::new(1.0, 1.0, 0.3), Vec3::Y];
        assert_eq!(triangles(&quad), [[0, 1, 2], [0, 2, 3]]);
    }

    #[test]
    fn a_dart_is_cut_along_its_inner_diagonal_whichever_corner_comes_first() {
        // A triangle of area 2 less a notch of area 0.5.
        let dart = [(0.0, 0.0), (2.0, 0.0), (0.0, 2.0), (0.5, 0.5)].map(|(x, y)| Vec3::new(x, y, 5.0));
        for first in 0..4 {
            for (axis, normal) in [Vec3::Z, Vec3::X, Vec3::Y].into_iter().enumerate() {
                let mut corners = dart;
                corners.rotate_left(first);
                let mut turned = corners.map(|p| match axis {
                    0 => p,
                    1 => Vec3::new(p.z, p.x, p.y),
                    _ => Vec3::new(p.y, p.z, p.x),
                });
                let (sum, absolute) = areas(&turned, normal);
                assert!(
                    (sum - 1.5).abs() < 1e-6 && (absolute - 1.5).abs() < 1e-6,
                    "{first} {axis}: {sum} {absolute}"
                );
                turned.reverse();
                let (sum, absolute) = areas(&turned, normal);
                assert!(
                    (sum + 1.5).abs() < 1e-6 && (absolute - 1.5).abs() < 1e-6,
                    "{first} {axis}: {sum} {absolute}"
                );
            }
        }
    }

    #[test]
    fn a_comb_keeps_its_area() {
        // The comb has ten teeth of 1 x 3 with gaps of 1 between them, on a back of height 1.
        let mut comb = vec![Vec3::ZERO, Vec3::new(19.0, 0.0, 0.0)];
        for tooth in (0..10).rev() {
            let x = 2.0 * tooth as f32;
            comb.extend([(x + 1.0, 4.0), (x, 4.0)].map(|(x, y)| Vec3::new(x, y, 0.0)));
            if tooth > 0 {
                comb.extend([(x, 1.0), (x - 1.0, 1.0)].map(|(x, y)| Vec3::new(x, y, 0.0)));
            }
        }
        let (sum, absolute) = areas(&comb, Vec3::Z);
        assert!(
            (sum - 49.0).abs() < 1e-4 && (absolute - 49.0).abs() < 1e-4,
            "{sum} {absolute}"
        );
        assert_eq!(triangles(&comb).len(), comb.len() - 2);
    }

    #[test]
    fn a_spiral_keeps_its_area_whichever_corner_comes_first() {
        // Three turns of a band, whose outer and inner outline follow each other.
        let place = |i: usize, out: f32| {
            let angle = 0.2 * i as f32;
            let radius = 1.0 + 0.1 * angle + out;
            Vec3::new(radius * angle.cos(), radius * angle.sin(), 0.0)
        };
        let outer = (0..94).map(|i| place(i, 0.3));
        let mut spiral: Vec<Vec3> = outer.chain((0..94).rev().map(|i| place(i, 0.0))).collect();
        let (expected, _) = areas(&spiral, Vec3::Z);
        for _ in 0..spiral.len() {
            spiral.rotate_left(1);
            let (sum, absolute) = areas(&spiral, Vec3::Z);
            assert!(
                (sum - expected).abs() < 1e-3 && (absolute - expected).abs() < 1e-3,
                "{sum} {absolute}"
            );
        }
    }

    #[test]
    fn nonsense_still_gives_the_full_number_of_triangles() {
        let bow_tie = [Vec3::ZERO, Vec3::ONE, Vec3::X, Vec3::Y];
        assert_eq!(triangles(&bow_tie).len(), 2);
        assert_eq!(triangles(&[Vec3::ONE; 7]).len(), 5);
        assert_eq!(triangles(&[Vec3::ZERO, Vec3::X, Vec3::X * 2.0, Vec3::X * 3.0]).len(), 2);
        let star: Vec<Vec3> = (0..1001)
            .map(|i| Vec3::new((i as f32 * 2.5).cos(), (i as f32 * 2.5).sin(), 0.0))
            .collect();
        assert_eq!(triangles(&star).len(), 999);
        let huge = [Vec3::ZERO, Vec3::MAX, Vec3::MIN, Vec3::X, Vec3::Y];
        assert_eq!(triangles(&huge).len(), 3);
    }
}
