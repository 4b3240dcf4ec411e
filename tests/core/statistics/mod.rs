//! Statistical tests shared by the test binaries: chi-squared against a density on the sphere or the square.
#![allow(dead_code, reason = "every test binary uses its own part")]

use glam::Vec3;
use std::f64::consts::PI;
use sunroom::math::Frame;

/// Chance of a false alarm of a whole table of tests; a table of n tests gives each 1 - (1 - SIGNIFICANCE)^(1/n)
/// (Sidak).
pub const SIGNIFICANCE: f64 = 1e-3;

/// Cells expected to hold fewer are pooled: below this the statistic does not follow the chi-squared distribution.
const FEWEST_EXPECTED: f64 = 5.0;

const RINGS: usize = 16;
const SECTORS: usize = 24;

/// Compares counted with expected frequencies; returns the probability of a deviation at least as large.
pub fn chi_squared_p(counted: &[f64], expected: &[f64]) -> f64 {
    let mut order: Vec<usize> = (0..expected.len()).collect();
    order.sort_by(|&a, &b| expected[a].total_cmp(&expected[b]));
    let (mut statistic, mut cells) = (0.0, 0);
    let (mut pooled_counted, mut pooled_expected) = (0.0, 0.0);
    for cell in order {
        pooled_counted += counted[cell];
        pooled_expected += expected[cell];
        if pooled_expected >= FEWEST_EXPECTED {
            statistic += (pooled_counted - pooled_expected).powi(2) / pooled_expected;
            cells += 1;
            (pooled_counted, pooled_expected) = (0.0, 0.0);
        }
    }
    // What is left over was expected to be rare; much of it is a failure on its own (Poisson tail, generously).
    if pooled_counted > pooled_expected + 6.0 * pooled_expected.sqrt() + 6.0 {
        return 0.0;
    }
    if cells < 2 {
        return 1.0;
    }
    upper_gamma((cells - 1) as f64 / 2.0, statistic / 2.0)
}

/// The p value of `count` sampled directions against the solid angle density `pdf`. `sample` gets the number of the
/// draw and returns `None` for an absorbed one; the density may integrate to less than one by that much. Cells are fine
/// around `axis`, where the density has its peak.
pub fn sphere_p(count: u32, axis: Vec3, mut sample: impl FnMut(u32) -> Option<Vec3>, pdf: impl Fn(Vec3) -> f32) -> f64 {
    let frame = Frame::from_normal(axis);
    let absorbed = RINGS * SECTORS;
    let mut counted = vec![0.0; absorbed + 1];
    for i in 0..count {
        counted[sample(i).map_or(absorbed, |dir| sphere_cell(frame.to_local(dir)))] += 1.0;
    }
    let mut expected = sphere_expectation(&frame, &pdf);
    let total: f64 = expected.iter().sum();
    assert!(total < 1.0 + 1e-3, "the density integrates to {total}");
    expected.push((1.0 - total).max(0.0));
    expected.iter_mut().for_each(|e| *e *= f64::from(count));
    chi_squared_p(&counted, &expected)
}

/// The integral over all directions of a function with a peak around `axis`.
pub fn sphere_integral(axis: Vec3, f: impl Fn(Vec3) -> f32) -> f64 {
    sphere_expectation(&Frame::from_normal(axis), &f).iter().sum()
}

/// Rings are equal steps of t, where 1 - z = 2 t^3: the first is 2 degrees wide.
fn sphere_cell(dir: Vec3) -> usize {
    let t = ((1.0 - f64::from(dir.z)).max(0.0) / 2.0).cbrt();
    let phi = (f64::from(dir.y).atan2(f64::from(dir.x)) / (2.0 * PI)).rem_euclid(1.0);
    let ring = ((t * RINGS as f64) as usize).min(RINGS - 1);
    ring * SECTORS + ((phi * SECTORS as f64) as usize).min(SECTORS - 1)
}

fn sphere_expectation(frame: &Frame, f: &impl Fn(Vec3) -> f32) -> Vec<f64> {
    // Over angles, so that a density that is infinite at a pole of its own, as that of a picture of the sky is, does no
    // harm there.
    let density = |theta: f64, phi: f64| {
        let (radius, z) = theta.sin_cos();
        let local = Vec3::new((radius * phi.cos()) as f32, (radius * phi.sin()) as f32, z as f32);
        let dir = frame.to_world(local).normalize();
        let value = f64::from(f(dir));
        assert!(value >= 0.0 && value.is_finite(), "density {value} at {dir}");
        value * radius
    };
    let ring_begins = |ring: usize| (1.0 - 2.0 * (ring as f64 / RINGS as f64).powi(3)).acos();
    let dphi = 2.0 * PI / SECTORS as f64;
    (0..RINGS * SECTORS)
        .map(|cell| {
            let (ring, sector) = (cell / SECTORS, cell % SECTORS);
            let theta = ring_begins(ring);
            let size = [ring_begins(ring + 1) - theta, dphi];
            integrate(&density, [theta, sector as f64 * dphi], size)
        })
        .collect()
}

/// Adaptive integral of `f` over the box at `corner`: Gauss's rule, compared with that of its quarters.
pub fn integrate(f: &impl Fn(f64, f64) -> f64, corner: [f64; 2], size: [f64; 2]) -> f64 {
    const LEAST_DEPTH: u32 = 2;
    const MOST_DEPTH: u32 = 9;
    // Absolute, of a cell's probability: 400 cells of 1e5 samples cannot see this.
    const TOLERANCE: f64 = 2e-7;
    fn gauss(f: &impl Fn(f64, f64) -> f64, corner: [f64; 2], size: [f64; 2]) -> f64 {
        let offset = 0.6f64.sqrt() / 2.0;
        let nodes = [
            (0.5 - offset, 5.0 / 18.0),
            (0.5, 8.0 / 18.0),
            (0.5 + offset, 5.0 / 18.0),
        ];
        let mut sum = 0.0;
        for (x, weight_x) in nodes {
            for (y, weight_y) in nodes {
                sum += weight_x * weight_y * f(corner[0] + x * size[0], corner[1] + y * size[1]);
            }
        }
        sum * size[0] * size[1]
    }
    fn refine(f: &impl Fn(f64, f64) -> f64, corner: [f64; 2], size: [f64; 2], coarse: f64, depth: u32) -> f64 {
        let half = [size[0] / 2.0, size[1] / 2.0];
        let quarters = [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0], [1.0, 1.0]].map(|[x, y]| {
            let corner = [corner[0] + x * half[0], corner[1] + y * half[1]];
            (corner, gauss(f, corner, half))
        });
        let fine: f64 = quarters.iter().map(|(_, value)| value).sum();
        let settled = depth >= LEAST_DEPTH && (fine - coarse).abs() < TOLERANCE;
        if settled || depth == MOST_DEPTH {
            return fine;
        }
        quarters
            .iter()
            .map(|&(corner, value)| refine(f, corner, half, value, depth + 1))
            .sum()
    }
    refine(f, corner, size, gauss(f, corner, size), 0)
}

/// The regularised upper incomplete gamma function Q(a, x): a series below a + 1, Lentz's continued fraction above
/// (Numerical Recipes, section 6.2).
fn upper_gamma(a: f64, x: f64) -> f64 {
    if x <= 0.0 {
        return 1.0;
    }
    let factor = (a * x.ln() - x - ln_gamma(a)).exp();
    if x < a + 1.0 {
        let (mut term, mut sum, mut n) = (1.0 / a, 1.0 / a, a);
        while term > sum * 1e-15 {
            n += 1.0;
            term *= x / n;
            sum += term;
        }
        return 1.0 - factor * sum;
    }
    let tiny = 1e-300;
    let mut b = x + 1.0 - a;
    let (mut c, mut d) = (1.0 / tiny, 1.0 / b);
    let mut h = d;
    for i in 1..10_000 {
        let an = -f64::from(i) * (f64::from(i) - a);
        b += 2.0;
        d = 1.0 / (an * d + b);
        c = b + an / c;
        let delta = c * d;
        h *= delta;
        if (delta - 1.0).abs() < 1e-14 {
            break;
        }
    }
    factor * h
}

/// ln of the gamma function by Stirling's series, after moving the argument above 10.
fn ln_gamma(mut x: f64) -> f64 {
    let mut shift = 0.0;
    while x < 10.0 {
        shift += x.ln();
        x += 1.0;
    }
    (x - 0.5) * x.ln() - x + 0.5 * (2.0 * PI).ln() + 1.0 / (12.0 * x) - 1.0 / (360.0 * x.powi(3))
        + 1.0 / (1260.0 * x.powi(5))
        - shift
}

/// Checks a table of named p values at once.
pub fn assert_all_plausible(results: &[(String, f64)]) {
    let least = 1.0 - (1.0 - SIGNIFICANCE).powf(1.0 / results.len() as f64);
    let failures: Vec<_> = results.iter().filter(|(_, p)| *p < least).collect();
    assert!(failures.is_empty(), "below p = {least:.2e}: {failures:#?}");
}
