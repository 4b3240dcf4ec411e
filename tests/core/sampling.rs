//! Samplers, warps and distributions against their stated densities, and the sequence against what it promises.

use crate::statistics::{assert_all_plausible, chi_squared_p, integrate, sphere_integral, sphere_p};
use glam::{DVec2, UVec2, Vec2, Vec3};
use sunroom::sampling::{
    DiscreteDistribution, ONE_MINUS_EPSILON, PiecewiseConstant1d, Rectangle, Sampler, SequenceKind, SphericalRectangle,
    warp,
};

const KINDS: [SequenceKind; 2] = [SequenceKind::Independent, SequenceKind::Sobol];

fn sampler(kind: SequenceKind, pixel: u32, index: u32) -> Sampler {
    Sampler::new(kind, UVec2::new(pixel % 640, pixel / 640), index, 1)
}

fn noise(index: u32, dimension: u32) -> Vec2 {
    sampler(SequenceKind::Independent, 7, index).at_2d(dimension)
}

#[test]
fn numbers_are_a_pure_function_of_the_counters() {
    for kind in KINDS {
        let one = Sampler::new(kind, UVec2::new(3, 4), 5, 6);
        let drawn = [one.at_2d(0), Vec2::splat(one.at_1d(1)), one.at_2d(2)];
        let same = Sampler::new(kind, UVec2::new(3, 4), 5, 6);
        assert_eq!(same.at_2d(2), drawn[2]);
        assert_eq!(same.at_2d(0), drawn[0]);
        let others = [
            Sampler::new(kind, UVec2::new(4, 3), 5, 6),
            Sampler::new(kind, UVec2::new(3, 4), 6, 6),
            Sampler::new(kind, UVec2::new(3, 4), 5, 7),
        ];
        for other in others {
            assert_ne!(other.at_2d(0), drawn[0]);
        }
    }
}

#[test]
fn numbers_stay_below_one() {
    for kind in KINDS {
        let largest = (0..1 << 20)
            .map(|index| sampler(kind, index % 5, index).at_2d(3).max_element())
            .fold(0.0, f32::max);
        assert!(largest < 1.0 && largest > 0.999_99, "{kind:?}: {largest}");
    }
    assert_eq!(sunroom::sampling::unit_float(u32::MAX), ONE_MINUS_EPSILON);
    assert!(ONE_MINUS_EPSILON < 1.0 && ONE_MINUS_EPSILON.next_up() == 1.0);
}

#[test]
fn every_prefix_is_stratified_in_all_elementary_intervals() {
    for (pixel, dimension) in [(0, 0), (1, 0), (1000, 1), (77, 40), (5, 1_000_000)] {
        for log_count in 0..=10u32 {
            let count = 1 << log_count;
            let cell = |x: f32, parts: u32| (x * parts as f32) as usize;
            let mut strata = vec![false; count as usize];
            for index in 0..count {
                let x = sampler(SequenceKind::Sobol, pixel, index).at_1d(dimension);
                assert!(
                    !std::mem::replace(&mut strata[cell(x, count)], true),
                    "1D, {count} points"
                );
            }
            for log_columns in 0..=log_count {
                let (columns, rows) = (1 << log_columns, 1 << (log_count - log_columns));
                let mut strata = vec![false; count as usize];
                for index in 0..count {
                    let p = sampler(SequenceKind::Sobol, pixel, index).at_2d(dimension);
                    let stratum = cell(p.x, columns) * rows as usize + cell(p.y, rows);
                    assert!(
                        !std::mem::replace(&mut strata[stratum], true),
                        "{columns} x {rows}, pixel {pixel}, dimension {dimension}"
                    );
                }
            }
        }
    }
}

/// The pixels that share a sequence: in 2 x 2, 4 x 8, 8 x 16 and 16 x 16 pixels those whose quads have one colour, as
/// on a chess board of quads.
fn pixels_together(corner: UVec2, log_width: u32, colour: u32) -> Vec<UVec2> {
    let width = 1 << log_width;
    let height = [2, 8, 16, 16][log_width as usize - 1];
    let corner = corner + UVec2::X * if width == 2 { 2 * colour } else { 0 };
    let all = (0..width * height).map(|pixel: u32| corner + UVec2::new(pixel % width, pixel / width));
    all.filter(|pixel| (pixel.x / 2 + pixel.y / 2) % 2 == colour).collect()
}

/// For 2^n samples (rows, from one on) of such pixels: in each elementary interval of 2^t of all their points are 2^t.
const SLACK_OF_NEIGHBOURS: [[u32; 4]; 13] = [
    [0, 0, 1, 2],
    [0, 0, 2, 3],
    [0, 0, 1, 2],
    [0, 0, 1, 2],
    [0, 1, 2, 3],
    [1, 1, 1, 2],
    [1, 1, 2, 3],
    [2, 2, 1, 2],
    [2, 2, 2, 3],
    [2, 3, 2, 3],
    [2, 1, 1, 2],
    [2, 2, 2, 3],
    [1, 3, 3, 4],
];

#[test]
fn samples_of_neighbouring_pixels_complete_each_other() {
    for (dimension, colour) in [0, 3, 6]
        .into_iter()
        .flat_map(|dimension| [(dimension, 0), (dimension, 1)])
    {
        for (n, slack) in (0..).zip(SLACK_OF_NEIGHBOURS) {
            for (log_width, t) in (1..).zip(slack) {
                let pixels = pixels_together(UVec2::new(16 * 5, 16 * 9), log_width, colour);
                let log_count = n + pixels.len().ilog2();
                let points: Vec<Vec2> = pixels
                    .into_iter()
                    .flat_map(|pixel| (0..1 << n).map(move |index| (pixel, index)))
                    .map(|(pixel, index)| Sampler::new(SequenceKind::Sobol, pixel, index, 2).at_2d(dimension))
                    .collect();
                for log_columns in 0..=log_count - t {
                    let (columns, rows) = (1 << log_columns, 1 << (log_count - t - log_columns));
                    let mut counts = vec![0; columns * rows];
                    for point in &points {
                        counts[(point.x * columns as f32) as usize * rows + (point.y * rows as f32) as usize] += 1;
                    }
                    let is_even = counts.iter().all(|&count| count == 1 << t);
                    assert!(
                        is_even,
                        "width 2^{log_width}, 2^{n} samples, {columns} x {rows}, dimension {dimension}"
                    );
                }
            }
        }
    }
}

/// By what the mean square error of sixteen pixels that share a sequence is less than it would be if pixels were
/// independent, for the mean of `value` of two draws from `dimension` on.
fn gain_of_neighbours(samples: u32, dimension: u32, value: fn(DVec2, DVec2) -> f64, exact: f64) -> f64 {
    let error = |pixel: &UVec2| {
        let sum: f64 = (0..samples)
            .map(|index| {
                let sampler = Sampler::new(SequenceKind::Sobol, *pixel, index, 4);
                let [a, b] = [dimension, dimension + 1].map(|dimension| sampler.at_2d(dimension).as_dvec2());
                value(a, b)
            })
            .sum();
        sum / f64::from(samples) - exact
    };
    let (mut of_pixels, mut of_all) = (0.0, 0.0);
    for group in 0..1024 {
        let corner = UVec2::new(group / 2 % 32 * 4, group / 64 * 8);
        let errors: Vec<f64> = pixels_together(corner, 2, group % 2).iter().map(error).collect();
        of_pixels += errors.iter().map(|error| error * error).sum::<f64>() / 16.0;
        of_all += (errors.iter().sum::<f64>() / 16.0).powi(2);
    }
    of_pixels / 16.0 / of_all
}

#[test]
fn errors_of_neighbours_cancel() {
    let smooth = |a: DVec2, _: DVec2| (-a.x).exp() * (1.0 + a.y);
    let exact_of_smooth = (1.0 - (-1.0f64).exp()) * 1.5;
    let edge = |a: DVec2, _: DVec2| f64::from(a.length_squared() < 0.5);
    let exact_of_edge = std::f64::consts::PI / 8.0;
    let product = |a: DVec2, b: DVec2| (a.x - 0.5) * (b.y - 0.5);
    for samples in [1, 2, 4, 8, 64, 256] {
        let gains = [
            gain_of_neighbours(samples, 3, smooth, exact_of_smooth),
            gain_of_neighbours(samples, 3, edge, exact_of_edge),
            gain_of_neighbours(samples, 3, product, 0.0),
        ];
        // Where two draws count as a product, errors of both may add up; more than so much is lost nowhere.
        let least = [10.0, 2.5, 0.5];
        let is_enough = gains.iter().zip(least).all(|(&gain, least)| gain > least);
        assert!(is_enough, "{samples} samples: {gains:.2?} of {least:?}");
        // A thousand groups of a normal distribution: their mean is known to about 4.5 %.
        let later = gain_of_neighbours(samples, 7, smooth, exact_of_smooth);
        assert!((0.8..1.25).contains(&later), "later draws are independent: {later}");
    }
}

/// Mean square error, over many pixels, of the mean of a smooth function of two draws' four numbers.
fn mean_square_error(kind: SequenceKind, count: u32) -> f64 {
    let pixels = 200;
    let exact = (1.0f64 - (-1.0f64).exp()).powi(2) * 0.5 * (1.0 + 1.0 / 3.0);
    (0..pixels)
        .map(|pixel| {
            let sum: f64 = (0..count)
                .map(|index| {
                    let sampler = sampler(kind, pixel, index);
                    let [a, b] = [0, 1].map(|dimension| sampler.at_2d(dimension).as_dvec2());
                    (-a.x - a.y).exp() * 0.5 * (b.x + b.y * b.y + 0.5)
                })
                .sum();
            (sum / f64::from(count) - exact).powi(2)
        })
        .sum::<f64>()
        / f64::from(pixels)
}

#[test]
fn sobol_converges_faster_than_independent_numbers() {
    let exact_of_independent =
        mean_square_error(SequenceKind::Independent, 256) / mean_square_error(SequenceKind::Independent, 4096);
    // The error's mean square goes as 1/n (16), each mean of 200 squares is known to about 10 %.
    assert!((11.0..22.0).contains(&exact_of_independent), "{exact_of_independent}");
    for count in [16, 256, 4096] {
        let gain = mean_square_error(SequenceKind::Independent, count) / mean_square_error(SequenceKind::Sobol, count);
        assert!(gain > 4.0, "{count} samples: only {gain} times better");
    }
}

#[test]
fn sobol_error_of_one_smooth_draw_falls_nearly_as_the_cube() {
    let error = |count: u32| {
        (0..100)
            .map(|pixel| {
                let sum: f64 = (0..count)
                    .map(|index| {
                        let p = sampler(SequenceKind::Sobol, pixel, index).at_2d(2).as_dvec2();
                        (-p.x - p.y).exp()
                    })
                    .sum();
                (sum / f64::from(count) - (1.0 - (-1.0f64).exp()).powi(2)).powi(2)
            })
            .sum::<f64>()
    };
    // n^-3 log n would be 4096 / 2; white noise 16.
    let ratio = error(64) / error(1024);
    assert!(ratio > 500.0, "{ratio}");
}

#[test]
fn pixels_and_dimensions_are_decorrelated() {
    let count = 4096u32;
    let mut results = Vec::new();
    for kind in KINDS {
        // Pairs of coordinates (pixel, dimension, axis) that must not know of each other. In the first draws neighbours
        // do.
        let pairs = [
            ((0, 0, 0), (0, 0, 1)),
            ((0, 0, 0), (0, 1, 0)),
            ((0, 1, 1), (0, 2, 0)),
            ((0, 3, 1), (0, 3 + 8, 1)),
            ((0, 7, 0), (1, 7, 0)),
            ((0, 8, 1), (640, 8, 1)),
            ((15, 0, 0), (16, 0, 0)),
            ((0, 5, 0), (1, 6, 0)),
            ((123, 1, 0), (124, 0, 1)),
        ];
        for (a, b) in pairs {
            let value =
                |(pixel, dimension, axis): (u32, u32, usize), index| sampler(kind, pixel, index).at_2d(dimension)[axis];
            let mut counted = vec![0.0; 64];
            for index in 0..count {
                let (x, y) = (value(a, index), value(b, index));
                counted[(x * 8.0) as usize * 8 + (y * 8.0) as usize] += 1.0;
            }
            let p = chi_squared_p(&counted, &vec![f64::from(count) / 64.0; 64]);
            results.push((format!("{kind:?} {a:?} {b:?}"), p));
        }
        // The first sample of many pixels covers the square.
        let mut counted = vec![0.0; 256];
        for pixel in 0..20_000 {
            let p = sampler(kind, pixel, 0).at_2d(0) * 16.0;
            counted[p.x as usize * 16 + p.y as usize] += 1.0;
        }
        results.push((
            format!("{kind:?} across pixels"),
            chi_squared_p(&counted, &[20_000.0 / 256.0; 256]),
        ));
    }
    assert_all_plausible(&results);
}

#[test]
fn directions_follow_their_densities() {
    let count = 100_000;
    let cone = |omc: f32| {
        move |d: Vec3| {
            if 1.0 - d.z <= omc {
                warp::uniform_cone_pdf(omc)
            } else {
                0.0
            }
        }
    };
    assert!((sphere_integral(Vec3::Z, |d| warp::cosine_hemisphere_pdf(d.z)) - 1.0).abs() < 1e-5);
    let mut results = vec![
        (
            "cosine".to_owned(),
            sphere_p(
                count,
                Vec3::Z,
                |i| Some(warp::cosine_hemisphere(noise(i, 0).to_array())),
                |d| warp::cosine_hemisphere_pdf(d.z),
            ),
        ),
        (
            "sphere".to_owned(),
            sphere_p(
                count,
                Vec3::Z,
                |i| Some(warp::uniform_sphere(noise(i, 1).to_array())),
                |_| warp::UNIFORM_SPHERE_PDF,
            ),
        ),
        (
            "hemisphere".to_owned(),
            sphere_p(
                count,
                Vec3::Z,
                |i| Some(warp::uniform_hemisphere(noise(i, 2).to_array())),
                |d| if d.z >= 0.0 { warp::UNIFORM_HEMISPHERE_PDF } else { 0.0 },
            ),
        ),
    ];
    for omc in [0.125, 0.5, 1.25, 2.0] {
        assert!((sphere_integral(Vec3::Z, cone(omc)) - 1.0).abs() < 1e-3, "cone {omc}");
        results.push((
            format!("cone {omc}"),
            sphere_p(
                count,
                Vec3::Z,
                |i| Some(warp::uniform_cone(noise(i, 3).to_array(), omc)),
                cone(omc),
            ),
        ));
    }
    assert_all_plausible(&results);
    for i in 0..1000 {
        let u = noise(i, 4);
        let directions = [
            warp::cosine_hemisphere(u.to_array()),
            warp::uniform_sphere(u.to_array()),
            warp::uniform_cone(u.to_array(), 1e-7),
            warp::uniform_cone(u.to_array(), 2.0),
        ];
        for d in directions {
            assert!((d.length() - 1.0).abs() < 1e-6, "{d}");
        }
    }
}

#[test]
fn points_are_uniform_in_disk_triangle_and_ball() {
    let count = 100_000;
    let mut results = Vec::new();
    // Twelve rings of equal area by sixteen sectors.
    let mut counted = vec![0.0; 192];
    for i in 0..count {
        let p = Vec2::from(warp::concentric_disk(noise(i, 0).to_array()));
        let sector = (p.y.atan2(p.x) / std::f32::consts::TAU).rem_euclid(1.0);
        counted[((p.length_squared() * 12.0) as usize).min(11) * 16 + ((sector * 16.0) as usize).min(15)] += 1.0;
    }
    results.push((
        "disk".to_owned(),
        chi_squared_p(&counted, &[f64::from(count) / 192.0; 192]),
    ));

    // The square-root map takes the triangle to the square with constant Jacobian, independently of the map under test.
    let mut counted = vec![0.0; 256];
    for i in 0..count {
        let b = warp::uniform_triangle(noise(i, 1));
        assert!(b.min_element() >= 0.0 && b.x + b.y <= 1.0);
        let sum = b.x + b.y;
        let (s, t) = (sum * sum, b.x / sum);
        counted[((s * 16.0) as usize).min(15) * 16 + ((t * 16.0) as usize).min(15)] += 1.0;
    }
    results.push((
        "triangle".to_owned(),
        chi_squared_p(&counted, &[f64::from(count) / 256.0; 256]),
    ));

    let mut counted = vec![0.0; 8 * 8 * 8];
    for i in 0..count {
        let p = warp::unit_ball(noise(i, 2).to_array(), noise(i, 3).x);
        let radius = p.length();
        let sector = (p.y.atan2(p.x) / std::f32::consts::TAU).rem_euclid(1.0);
        let shell = ((radius.powi(3) * 8.0) as usize).min(7);
        let zone = (((p.z / radius + 1.0) * 4.0) as usize).min(7);
        counted[(shell * 8 + zone) * 8 + ((sector * 8.0) as usize).min(7)] += 1.0;
    }
    results.push((
        "ball".to_owned(),
        chi_squared_p(&counted, &[f64::from(count) / 512.0; 512]),
    ));
    assert_all_plausible(&results);
}

fn seen(corner: Vec3, edge_u: Vec3, edge_v: Vec3, origin: Vec3) -> Option<SphericalRectangle> {
    let seen = Rectangle::new(corner, edge_u, edge_v)?.seen_from(origin);
    seen.is_large().then_some(seen)
}

#[test]
fn spherical_rectangle_is_uniform_in_solid_angle() {
    // Corner, edges, origin: frontal, from behind, oblique, close, beside, long and thin, far away, rotated.
    let tilt = |v: Vec3| glam::Quat::from_euler(glam::EulerRot::XYZ, 0.3, 1.1, -0.7) * v;
    let cases = [
        (Vec3::new(-1.0, -1.0, 2.0), Vec3::X * 2.0, Vec3::Y * 2.0, Vec3::ZERO),
        (Vec3::new(-1.0, -1.0, -2.0), Vec3::X * 2.0, Vec3::Y * 2.0, Vec3::ZERO),
        (Vec3::new(1.0, 0.5, 0.3), Vec3::X * 2.0, Vec3::Y * 3.0, Vec3::ZERO),
        (Vec3::new(-0.3, -0.4, 0.01), Vec3::X, Vec3::Y, Vec3::ZERO),
        (Vec3::new(0.2, -3.0, 1.0), Vec3::X * 0.1, Vec3::Y * 6.0, Vec3::ZERO),
        (Vec3::new(4.0, 1.0, 20.0), Vec3::X, Vec3::Y, Vec3::new(1.0, 0.0, 0.0)),
        (
            tilt(Vec3::new(-1.0, 0.2, 1.0)),
            tilt(Vec3::X),
            tilt(Vec3::Z * 2.0),
            tilt(Vec3::new(0.1, -0.8, 0.5)),
        ),
    ];
    let mut results = Vec::new();
    for (case, &(corner, u, v, origin)) in cases.iter().enumerate() {
        let rectangle = seen(corner, u, v, origin).expect("a rectangle of good size");
        let normal = u.cross(v).normalize().as_dvec3();
        let density = |a: f64, b: f64| {
            let d = corner.as_dvec3() + a * u.as_dvec3() + b * v.as_dvec3() - origin.as_dvec3();
            d.dot(normal).abs() / d.length().powi(3) * f64::from(u.length() * v.length())
        };
        const PARTS: usize = 12;
        let step = 1.0 / PARTS as f64;
        let expected: Vec<f64> = (0..PARTS * PARTS)
            .map(|c| {
                integrate(
                    &density,
                    [(c / PARTS) as f64 * step, (c % PARTS) as f64 * step],
                    [step, step],
                )
            })
            .collect();
        let solid_angle: f64 = expected.iter().sum();
        let error = (f64::from(rectangle.solid_angle()) / solid_angle - 1.0).abs();
        assert!(
            error < 1e-4,
            "case {case}: {} sr, should be {solid_angle}",
            rectangle.solid_angle()
        );
        assert!((rectangle.pdf_solid_angle() * rectangle.solid_angle() - 1.0).abs() < 1e-6);

        let count = 50_000;
        let mut counted = vec![0.0; PARTS * PARTS];
        for i in 0..count {
            let local = rectangle.sample(noise(i, case as u32).to_array()) - corner;
            let (a, b) = (local.dot(u) / u.length_squared(), local.dot(v) / v.length_squared());
            assert!(local.dot(normal.as_vec3()).abs() < 1e-5);
            assert!(
                (-1e-5..1.00001).contains(&a) && (-1e-5..1.00001).contains(&b),
                "{a} {b}"
            );
            let part = |x: f32| ((x.max(0.0) * PARTS as f32) as usize).min(PARTS - 1);
            counted[part(a) * PARTS + part(b)] += 1.0;
        }
        let expected: Vec<f64> = expected.iter().map(|e| e / solid_angle * f64::from(count)).collect();
        results.push((format!("case {case}"), chi_squared_p(&counted, &expected)));
    }
    assert_all_plausible(&results);
}

#[test]
fn spherical_rectangle_leaves_the_rest_to_area_sampling() {
    let unit = |origin| seen(Vec3::ZERO, Vec3::X, Vec3::Y, origin);
    assert!(unit(Vec3::new(0.5, 0.5, 1.0)).is_some());
    assert!(unit(Vec3::new(3.0, 0.5, 0.0)).is_none(), "in its plane");
    assert!(unit(Vec3::new(0.5, 0.5, 1e5)).is_none(), "tiny");
    const TAU_OVER_NEAREST: f32 = std::f32::consts::TAU / 0.3;
    // What nearly touches it sees half of everything, and beside it nothing.
    for height in [1e-4, 1e-6, 1e-9] {
        let touching = unit(Vec3::new(0.3, 0.6, height)).expect("before it").solid_angle();
        // In every direction it ends at least 0.3 away, so low above the horizon.
        let missing = std::f32::consts::TAU - touching;
        assert!(
            (-1e-6..TAU_OVER_NEAREST * height + 1e-6).contains(&missing),
            "{missing}"
        );
        let beside = unit(Vec3::new(1.5, 0.6, height)).map_or(0.0, |seen| seen.solid_angle());
        assert!(beside < 10.0 * height, "{beside}");
    }
    assert!(
        seen(Vec3::ZERO, Vec3::X, Vec3::new(0.1, 1.0, 0.0), Vec3::Z).is_none(),
        "parallelogram"
    );
    assert!(seen(Vec3::ZERO, Vec3::ZERO, Vec3::Y, Vec3::Z).is_none(), "no extent");
}

#[test]
fn discrete_choices_follow_their_weights() {
    let many: Vec<f32> = (0..3000).map(|i| ((i * 7919) % 101) as f32).collect();
    let cases: Vec<Vec<f32>> = vec![
        vec![2.0],
        vec![1.0, 3.0],
        vec![0.0, 1.0, 0.0, 0.0, 2.0, 0.0],
        vec![f32::NAN, 1.0, f32::INFINITY, -5.0, 1.0],
        vec![1e30, 3e30, f32::MAX / 1e7],
        vec![1e-40, 3e-40],
        many,
    ];
    let mut results = Vec::new();
    for (case, weights) in cases.iter().enumerate() {
        let distribution = DiscreteDistribution::new(weights).expect("something to choose");
        assert_eq!(distribution.len(), weights.len());
        let usable = |w: &f32| if w.is_finite() { f64::from(w.max(0.0)) } else { 0.0 };
        let total: f64 = weights.iter().map(usable).sum();
        let mut sum = 0.0;
        for (i, weight) in weights.iter().enumerate() {
            let pmf = f64::from(distribution.pmf(i as u32));
            let cells = 1.0 / f64::from(1 << 24) * (weights.len() + 1) as f64;
            assert!((pmf - usable(weight) / total).abs() <= cells, "case {case}, {i}");
            assert_eq!(pmf > 0.0, usable(weight) > 0.0, "case {case}, {i}");
            sum += pmf;
        }
        assert!((sum - 1.0).abs() < 1e-6);
        assert_eq!(distribution.pmf(weights.len() as u32), 0.0);

        let count = 100_000;
        let mut counted = vec![0.0; weights.len()];
        let mut remapped = vec![0.0; 16];
        for i in 0..count {
            let sample = distribution.sample(noise(i, case as u32).x);
            assert_eq!(sample.pmf, distribution.pmf(sample.index));
            assert!((0.0..1.0).contains(&sample.remapped_u));
            counted[sample.index as usize] += 1.0;
            remapped[(sample.remapped_u * 16.0) as usize] += 1.0;
        }
        let expected: Vec<f64> = weights.iter().map(|w| usable(w) / total * f64::from(count)).collect();
        results.push((format!("choice, case {case}"), chi_squared_p(&counted, &expected)));
        let even = [f64::from(count) / 16.0; 16];
        results.push((format!("rest, case {case}"), chi_squared_p(&remapped, &even)));
        for u in [0.0, ONE_MINUS_EPSILON, 1.0] {
            assert!(distribution.sample(u).pmf > 0.0, "case {case}, u {u}");
        }
    }
    assert_all_plausible(&results);
}

#[test]
fn choices_increase_with_the_number_and_tiny_weights_stay_possible() {
    let distribution = DiscreteDistribution::new(&[1e-12, 1.0, 1e-12, 5.0, 1e-12]).expect("something to choose");
    let chosen: Vec<u32> = (0..1 << 24)
        .map(|i| distribution.sample(i as f32 / (1 << 24) as f32).index)
        .collect();
    assert!(chosen.is_sorted());
    for index in 0..5 {
        let frequency = chosen.iter().filter(|&&c| c == index).count() as f32 / (1 << 24) as f32;
        assert_eq!(frequency, distribution.pmf(index));
    }
}

#[test]
fn nothing_positive_is_no_distribution() {
    for weights in [&[][..], &[0.0], &[0.0, -1.0, f32::NAN, f32::INFINITY]] {
        assert!(DiscreteDistribution::new(weights).is_none());
        assert!(PiecewiseConstant1d::new(weights).is_none());
    }
}

#[test]
fn piecewise_constant_density_matches_its_samples() {
    let mut results = Vec::new();
    for (case, values) in [
        vec![1.0],
        vec![1.0, 0.0, 3.0, 2.0],
        vec![0.0, 0.0, 5.0, 1e-3, 0.0],
        vec![0.5; 37],
    ]
    .iter()
    .enumerate()
    {
        let distribution = PiecewiseConstant1d::new(values).expect("something positive");
        let sum: f32 = values.iter().sum();
        assert!((distribution.integral() - sum / values.len() as f32).abs() < 1e-6);
        let count = 50_000;
        let mut counted = vec![0.0; values.len() * 4];
        for i in 0..count {
            let sample = distribution.sample(noise(i, case as u32).y);
            assert!(sample.pdf > 0.0 && (0.0..1.0).contains(&sample.x));
            assert_eq!((sample.x * values.len() as f32) as u32, sample.cell);
            assert_eq!(distribution.pdf(sample.x), sample.pdf);
            let bin = (sample.x * counted.len() as f32) as usize;
            counted[bin] += 1.0;
        }
        let expected: Vec<f64> = (0..counted.len())
            .map(|i| f64::from(values[i / 4] / sum / 4.0) * f64::from(count))
            .collect();
        results.push((format!("case {case}"), chi_squared_p(&counted, &expected)));
        assert!(distribution.sample(1.0).pdf > 0.0);
        assert_eq!(distribution.pdf(1.0), 0.0);
        assert_eq!(distribution.pdf(-0.1), 0.0);
    }
    assert_all_plausible(&results);
}
