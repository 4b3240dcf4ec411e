use glam::{UVec2, Vec3Swizzles};

use super::*;
use crate::geometry::cylinder;
use crate::geometry::round_cone::RoundCone;
use crate::sampling::{RandomStream, Sampler, SequenceKind};

const RAYS: usize = 20_000;

fn stream(seed: u32) -> RandomStream {
    Sampler::new(SequenceKind::Independent, UVec2::ZERO, 0, seed).stream(0)
}

fn between(rng: &mut RandomStream, low: f32, high: f32) -> f32 {
    low + (high - low) * rng.draw()
}

fn vector(rng: &mut RandomStream) -> Vec3 {
    Vec3::from_array([(); 3].map(|()| between(rng, -1.0, 1.0)))
}

/// A ray from outside to somewhere near the origin, with a direction of any length.
fn ray(rng: &mut RandomStream, spread: f32) -> Ray {
    let from = 6.0 * vector(rng).try_normalize().unwrap_or(Vec3::X);
    let to = spread * vector(rng);
    Ray::new(from, (to - from) * between(rng, 0.1, 3.0))
}

fn meet(points: [Vec4; 4], ray: &Ray) -> Option<SegmentHit> {
    Spline::new(points).intersect(Part::WHOLE, &CurveRay::new(ray)?, f32::INFINITY)
}

/// The polynomials of a uniform B-spline at `v`: its value, first and second derivative.
fn basis(points: &[Vec4; 4], v: f64) -> [[f64; 4]; 3] {
    let w = 1.0 - v;
    let weights = [
        [
            w * w * w,
            3.0 * v * v * v - 6.0 * v * v + 4.0,
            3.0 * w * w * w - 6.0 * w * w + 4.0,
            v * v * v,
        ],
        [
            -3.0 * w * w,
            9.0 * v * v - 12.0 * v,
            -9.0 * w * w + 12.0 * w,
            3.0 * v * v,
        ],
        [6.0 * w, 18.0 * v - 12.0, 18.0 * w - 12.0, 6.0 * v],
    ];
    weights.map(|weights| {
        std::array::from_fn(|axis| {
            let terms = points.iter().zip(weights);
            terms.map(|(point, weight)| f64::from(point[axis]) * weight / 6.0).sum()
        })
    })
}

/// The nearest hit of the outside, by a search along the curve: the ray meets the plane of each cross-section in a
/// point, whose distance from the centre is compared with the radius. With it the cosine between ray and normal.
fn searched(points: [Vec4; 4], ray: &Ray) -> Option<(f64, f64)> {
    const STEPS: usize = 4000;
    let (o, d) = (ray.origin.as_dvec3(), ray.dir.as_dvec3());
    let at = |v: f64| {
        let [c, first, second] = basis(&points, v);
        let xyz = |of: [f64; 4]| DVec3::new(of[0], of[1], of[2]);
        let (center, tangent) = (xyz(c), xyz(first));
        let slope = d.dot(tangent);
        let t = (center - o).dot(tangent) / slope;
        let x = o + t * d - center;
        let normal = x * (tangent.length_squared() - x.dot(xyz(second))) - tangent * (c[3] * first[3]);
        (x.length() - c[3], t, normal.normalize().dot(d.normalize()), slope)
    };
    let mut nearest: Option<(f64, f64)> = None;
    for step in 0..STEPS {
        let (mut low, mut high) = (step as f64 / STEPS as f64, (step + 1) as f64 / STEPS as f64);
        let (first, last) = (at(low), at(high));
        if first.0 * last.0 > 0.0 || first.3 * last.3 <= 0.0 {
            continue;
        }
        for _ in 0..60 {
            let middle = 0.5 * (low + high);
            if at(middle).0 * first.0 > 0.0 {
                low = middle
            } else {
                high = middle
            }
        }
        let (_, t, cos, _) = at(0.5 * (low + high));
        if t > 0.0 && cos < 0.0 && nearest.is_none_or(|(found, _)| t < found) {
            nearest = Some((t, cos));
        }
    }
    nearest
}

#[test]
fn a_straight_spline_is_a_cylinder() {
    let mut rng = stream(1);
    let points = [-1.0, 0.0, 1.0, 2.0].map(|z| Vec4::new(0.0, 0.0, z, 1.0));
    let mut hits = 0;
    for _ in 0..RAYS {
        let ray = ray(&mut rng, 2.0);
        // The cylinder has an inside, too.
        let expected = cylinder::intersect(&ray).filter(|hit| {
            let place = ray.origin + hit.t * ray.dir;
            place.truncate().dot(ray.dir.truncate()) < 0.0
        });
        let found = meet(points, &ray);
        assert_eq!(found.is_some(), expected.is_some(), "{ray:?} {found:?} {expected:?}");
        if let (Some(found), Some(expected)) = (found, expected) {
            hits += 1;
            assert!(
                (found.t - expected.t).abs() <= 1e-5 * expected.t,
                "{found:?} {expected:?}"
            );
            let place = ray.origin + found.t * ray.dir;
            assert!((found.v - place.z).abs() < 1e-5);
            let surface = Spline::new(points).surface(found.u, found.v);
            assert!(surface.position.abs_diff_eq(place, 1e-5), "{surface:?} {place}");
            assert!(surface.normal.abs_diff_eq(place.with_z(0.0), 1e-5));
        }
    }
    assert!(hits > RAYS / 20, "{hits}");
}

/// The segments of curves from nearly straight hairs to bent, tapered tubes, whose radius is below that of their bends.
#[test]
fn bent_splines_are_met_where_a_search_along_them_finds_the_ray() {
    let mut rng = stream(2);
    let (mut hits, mut missed) = (0, 0);
    for case in 0..400 {
        let bend = [0.05, 0.3, 0.6, 0.9][case % 4];
        let radius = [0.003, 0.03, 0.12][case / 4 % 3];
        let points = std::array::from_fn(|index| {
            let place = Vec3::new(2.0 * index as f32 - 3.0, 0.0, 0.0) + bend * vector(&mut rng);
            place.extend(radius * between(&mut rng, 0.5, 1.5))
        });
        let spline = Spline::new(points);
        for _ in 0..60 {
            // Most rays go to a place near the curve.
            let near = spline.at(between(&mut rng, -0.1, 1.1));
            let to = near.xyz() + 1.3 * near.w * vector(&mut rng);
            let from = ray(&mut rng, 1.0).origin;
            let ray = Ray::new(from, (to - from) * between(&mut rng, 0.1, 3.0));
            let (found, expected) = (meet(points, &ray), searched(points, &ray));
            let tolerance = 1e-4 * 6.0 / f64::from(ray.dir.length());
            if let Some(found) = found {
                let [c, tangent, _] = basis(&points, found.v.into()).map(|of| DVec3::new(of[0], of[1], of[2]));
                let x = ray.origin.as_dvec3() + f64::from(found.t) * ray.dir.as_dvec3() - c;
                let radius = basis(&points, found.v.into())[0][3];
                // t and v are rounded, places up to 6 away.
                assert!((x.length() - radius).abs() < 1e-5, "{points:?} {ray:?} {found:?}");
                assert!(
                    (x.dot(tangent.normalize())).abs() < 1e-5,
                    "{points:?} {ray:?} {found:?}"
                );
            }
            let Some((t, cos)) = expected else {
                continue;
            };
            hits += 1;
            // The search misses rays that touch the surface between two steps, and those along a cross-section. What
            // is found instead was checked above.
            let is_met = found.is_some_and(|found| f64::from(found.t) < t + tolerance);
            missed += usize::from(!is_met);
            assert!(is_met || cos > -0.05, "{points:?}\n{ray:?}\n{found:?} {expected:?}");
        }
    }
    assert!(hits > 10_000, "{hits}");
    assert!(missed <= hits / 1000, "{missed} of {hits}");
}

#[test]
fn parts_together_are_the_whole() {
    let mut rng = stream(3);
    let mut hits = 0;
    for _ in 0..RAYS {
        let points = std::array::from_fn(|index| {
            let place = Vec3::new(2.0 * index as f32 - 3.0, 0.0, 0.0) + 0.7 * vector(&mut rng);
            place.extend(between(&mut rng, 0.02, 0.1))
        });
        let spline = Spline::new(points);
        let near = spline.at(between(&mut rng, 0.0, 1.0));
        let from = ray(&mut rng, 1.0).origin;
        let ray = Ray::new(from, near.xyz() + near.w * vector(&mut rng) - from);
        let prepared = CurveRay::new(&ray).unwrap();
        let whole = spline.intersect(Part::WHOLE, &prepared, f32::INFINITY);
        let parts = (8..16).filter_map(|part| {
            let part = Part(part);
            let hit = spline.intersect(part, &prepared, f32::INFINITY)?;
            let place = ray.origin + hit.t * ray.dir;
            let Aabb { min, max } = spline.bounds(part);
            // The place on the ray is rounded.
            assert!(
                place.cmpge(min - 1e-5).all() && place.cmple(max + 1e-5).all(),
                "{part:?} {hit:?}"
            );
            Some(hit)
        });
        let nearest = parts.reduce(|a, b| if b.t < a.t { b } else { a });
        assert_eq!(
            whole.is_some(),
            nearest.is_some(),
            "{points:?} {ray:?} {whole:?} {nearest:?}"
        );
        if let (Some(whole), Some(nearest)) = (whole, nearest) {
            hits += 1;
            assert!((whole.t - nearest.t).abs() < 1e-5 * whole.t, "{whole:?} {nearest:?}");
        }
    }
    assert!(hits > RAYS / 3, "{hits}");
}

/// The least distance from a place to the spheres along a linear segment.
fn to_spheres([a, b]: [Vec4; 2], place: DVec3) -> f64 {
    let from = |v: f64| {
        let center = a.xyz().as_dvec3().lerp(b.xyz().as_dvec3(), v);
        (place - center).length() - (f64::from(a.w) * (1.0 - v) + f64::from(b.w) * v)
    };
    // The distance is convex in v.
    let (mut low, mut high) = (0.0, 1.0);
    for _ in 0..100 {
        let (one, other) = (low + (high - low) / 3.0, high - (high - low) / 3.0);
        if from(one) < from(other) {
            high = other
        } else {
            low = one
        }
    }
    from(0.5 * (low + high))
}

#[test]
fn linear_segments_are_the_hull_of_their_spheres() {
    let mut rng = stream(4);
    let mut hits = [0; 3];
    for case in 0..RAYS {
        let spheres = std::array::from_fn(|_| vector(&mut rng).extend(between(&mut rng, 0.0, 0.7)));
        let spheres = if case % 50 == 0 {
            [spheres[0], spheres[0].with_w(0.4)]
        } else {
            spheres
        };
        let mut ray = ray(&mut rng, 1.5);
        if case % 10 == 0 {
            // Along the axis, where the quadratic degenerates.
            ray.dir = (spheres[1] - spheres[0]).xyz();
        }
        let found = CurveRay::new(&ray)
            .and_then(|prepared| RoundCone::new(spheres).intersect(&prepared, f32::INFINITY, || true));
        // Spheres are traced: steps of the distance never enter the hull.
        let (o, d) = (ray.origin.as_dvec3(), ray.dir.as_dvec3().normalize_or_zero());
        let mut s = 0.0;
        let mut left = to_spheres(spheres, o);
        for _ in 0..2000 {
            if left < 1e-9 || s > 20.0 {
                break;
            }
            s += left;
            left = to_spheres(spheres, o + s * d);
        }
        let is_met = left < 1e-6 && d != DVec3::ZERO;
        let Some((hit, place)) = found else {
            assert!(!is_met || left > 1e-10, "{spheres:?} {ray:?} misses, but is met at {s}");
            continue;
        };
        // Tangential rays stop before they are near.
        assert!(is_met || left < 1e-3, "{spheres:?} {ray:?} {hit:?} {left}");
        assert!(to_spheres(spheres, place).abs() < 1e-9, "{spheres:?} {ray:?} {hit:?}");
        let surface = RoundCone::new(spheres).surface(&ray, hit.t, hit.v);
        assert!(surface.position.abs_diff_eq(place.as_vec3(), 1e-5));
        // The normal is the gradient of the distance.
        let outside = to_spheres(spheres, place + 1e-4 * surface.normal.as_dvec3());
        assert!((outside - 1e-4).abs() < 1e-8, "{outside}");
        hits[(hit.v == 0.0) as usize + 2 * (hit.v == 1.0) as usize] += 1;
    }
    assert!(hits.iter().all(|&count| count > RAYS / 100), "{hits:?}");
}

#[test]
fn rays_from_within_pass() {
    let points = [-1.0, 0.0, 1.0, 2.0].map(|z| Vec4::new(0.0, 0.0, z, 1.0));
    let out = Ray::new(Vec3::new(0.1, 0.0, 0.5), Vec3::X);
    assert_eq!(meet(points, &out), None);
    let into = Ray::new(Vec3::new(0.0, 0.0, 3.0), Vec3::new(0.1, 0.0, -1.0));
    assert_eq!(meet(points, &into), None, "it is open at its ends");
    let cone = RoundCone::new([points[1], points[2]]);
    assert!(
        cone.intersect(&CurveRay::new(&out).unwrap(), f32::INFINITY, || true)
            .is_none()
    );
}

#[test]
fn tangents_are_the_derivatives_of_the_surface() {
    let mut rng = stream(5);
    for _ in 0..1000 {
        let points = std::array::from_fn(|index| {
            let place = Vec3::new(2.0 * index as f32 - 3.0, 0.0, 0.0) + 0.7 * vector(&mut rng);
            place.extend(between(&mut rng, 0.05, 0.3))
        });
        let spline = Spline::new(points);
        let [u, v] = [0.1, 0.1].map(|low| between(&mut rng, low, 0.9));
        let Parametrisation { uv, dp_du, dp_dv } = spline.parametrisation([u, v], [2, 5], Vec3::Z);
        assert!(uv.abs_diff_eq(Vec2::new(u, (2.0 + v) / 5.0), 1e-5), "{uv}");
        let at = |u: f32, v: f32| spline.surface(u, v).position;
        let by_u = (at(u + 1e-3, v) - at(u - 1e-3, v)) / 2e-3;
        assert!(by_u.abs_diff_eq(dp_du, 1e-2 * dp_du.length()), "{by_u} {dp_du}");
        // Along v Mitsuba's frame turns around the tangent, which is no part of the derivative here.
        let by_v = 5.0 * (at(u, v + 1e-3) - at(u, v - 1e-3)) / 2e-3;
        let across = by_v - dp_du * by_v.dot(dp_du) / dp_du.length_squared();
        assert!(across.abs_diff_eq(dp_dv, 2e-2 * dp_dv.length()), "{across} {dp_dv}");
        let normal = spline.surface(u, v).normal;
        assert!(dp_du.cross(dp_dv).normalize().abs_diff_eq(normal, 1e-4));
    }
}

/// Where three control points coincide, the spline reaches them with a derivative of zero. It is open there, too.
#[test]
fn splines_that_reach_their_ends_are_open() {
    const RADIUS: f32 = 0.05;
    let mut rng = stream(6);
    let (begin, end) = (Vec4::new(-1.0, 0.0, 0.0, RADIUS), Vec4::new(0.0, 0.0, 0.0, RADIUS));
    for points in [[begin, end, end, end], [end, end, end, begin]] {
        let down = Ray::new(Vec3::new(0.02, 0.0, 1.0), Vec3::NEG_Z);
        assert_eq!(meet(points, &down), None);
        let (mut hits, mut missed) = (0, 0);
        for _ in 0..RAYS {
            let to = Vec3::new(between(&mut rng, -0.2, 0.1), between(&mut rng, -0.06, 0.06), 0.0);
            let from = to + Vec3::Z + 0.5 * vector(&mut rng);
            let ray = Ray::new(from, to - from);
            // The place where it enters the cylinder around the x axis.
            let (o, d) = (ray.origin.as_dvec3(), ray.dir.as_dvec3());
            let ([a, b], c) = ([d.yz().length_squared(), o.yz().dot(d.yz())], o.yz().length_squared());
            let discriminant = b * b - a * (c - f64::from(RADIUS * RADIUS));
            if discriminant < 1e-8 {
                continue;
            }
            let x = o.x - d.x * (b + discriminant.sqrt()) / a;
            // Rounded coordinates, and the last part of the curve, which is shorter than a thousandth of its radius.
            if [0.0, -1.0 / 6.0].iter().any(|end| (x - end).abs() < 1e-4) {
                continue;
            }
            let is_expected = x > -1.0 / 6.0 && x < 0.0;
            let is_met = meet(points, &ray).is_some();
            hits += usize::from(is_met);
            missed += usize::from(is_expected && !is_met);
            assert!(is_expected || !is_met, "{points:?} {ray:?} at {x}");
        }
        assert!(hits > RAYS / 4 && missed == 0, "{hits} {missed}");
    }
}

/// Coordinates of 1000 are rounded to 6e-5 in f32, far more than the overlap of segments.
#[test]
fn no_ray_passes_between_segments_far_from_the_origin() {
    let mut rng = stream(7);
    let mut rays = 0;
    for _ in 0..200 {
        let from = 1000.0 * vector(&mut rng);
        let points: [Vec4; 6] = std::array::from_fn(|index| {
            let place = from + 0.5 * index as f32 * Vec3::X + 0.05 * vector(&mut rng);
            place.extend(0.1)
        });
        let segment = |first: usize| std::array::from_fn(|index| points[first + index]);
        let [place, tangent, _] = basis(&segment(1), 0.0).map(|of| DVec3::new(of[0], of[1], of[2]));
        for _ in 0..100 {
            let beside = tangent.cross(vector(&mut rng).as_dvec3()).normalize_or_zero();
            let to = place + f64::from(between(&mut rng, -1e-4, 1e-4)) * tangent;
            let ray = Ray::new((to + beside).as_vec3(), -beside.as_vec3());
            rays += 1;
            assert!(
                (0..3).any(|first| meet(segment(first), &ray).is_some()),
                "{points:?} {ray:?}"
            );
        }
    }
    assert_eq!(rays, 20_000);
}

#[test]
fn normals_are_of_unit_length_where_the_surface_has_none() {
    for radius in [0.0, 0.2] {
        let surface = Spline::new([Vec4::new(1.0, 2.0, 3.0, radius); 4]).surface(0.3, 0.5);
        assert!(surface.normal.is_normalized(), "{radius} {surface:?}");
    }
}
