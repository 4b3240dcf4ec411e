//! The bilinear density on the unit square: what it samples against an integral of the given values that the test makes
//! itself.

use crate::statistics::{assert_all_plausible, chi_squared_p, integrate};
use glam::{UVec2, Vec2};
use sunroom::math::lanes::{LANES, Lanes};
use sunroom::sampling::{ONE_MINUS_EPSILON, PiecewiseBilinear2d, Sampler, SequenceKind, hash::pcg3d, unit_float};

struct Map {
    name: &'static str,
    columns: usize,
    rows: usize,
    values: Vec<f32>,
}

fn map(name: &'static str, columns: usize, rows: usize, value: impl Fn(usize, usize) -> f32) -> Map {
    let values = (0..rows * columns)
        .map(|at| value(at % columns, at / columns))
        .collect();
    Map {
        name,
        columns,
        rows,
        values,
    }
}

fn random(x: usize, y: usize) -> f32 {
    unit_float(pcg3d([x as u32, y as u32, 11])[0])
}

fn maps() -> Vec<Map> {
    vec![
        map("constant", 5, 4, |_, _| 3.0),
        map("least", 2, 2, |x, y| (1 + x + 2 * y) as f32),
        map(
            "one bright inner node",
            9,
            7,
            |x, y| if (x, y) == (4, 3) { 1e6 } else { 0.0 },
        ),
        map(
            "one bright corner",
            9,
            7,
            |x, y| if (x, y) == (8, 0) { 1e-20 } else { 0.0 },
        ),
        map("two rows", 16, 2, |x, _| (x % 3) as f32),
        map("two columns", 2, 12, |_, y| y as f32),
        map("noise", 17, 11, random),
        map("contrast", 12, 12, |x, y| 10f32.powf(8.0 * random(x, y))),
        map("not numbers", 6, 6, |x, y| match (x + y) % 4 {
            0 => f32::NAN,
            1 => -5.0,
            2 => f32::INFINITY,
            _ => 2.0,
        }),
        // A sun that holds half of the light of two million nodes.
        map("large", 2049, 1025, |x, y| {
            let sky = 0.5 + random(x, y);
            if (1300..1304).contains(&x) && (200..204).contains(&y) {
                130_000.0
            } else {
                sky
            }
        }),
    ]
}

/// The values as a function of the square, integrating to 1.
fn density(map: &Map) -> impl Fn(f64, f64) -> f64 {
    let usable = |value: f32| {
        if value.is_finite() {
            f64::from(value.max(0.0))
        } else {
            0.0
        }
    };
    let (cells_x, cells_y) = (map.columns - 1, map.rows - 1);
    let value = move |x: usize, y: usize| usable(map.values[y * map.columns + x]);
    let mean = |cell: usize| {
        let (x, y) = (cell % cells_x, cell / cells_x);
        (value(x, y) + value(x + 1, y) + value(x, y + 1) + value(x + 1, y + 1)) / 4.0
    };
    let total = (0..cells_x * cells_y).map(mean).sum::<f64>() / (cells_x * cells_y) as f64;
    move |x, y| {
        let (x, y) = (x * cells_x as f64, y * cells_y as f64);
        let (i, j) = ((x as usize).min(cells_x - 1), (y as usize).min(cells_y - 1));
        let (s, t) = (x - i as f64, y - j as f64);
        let lower = (1.0 - s) * value(i, j) + s * value(i + 1, j);
        let upper = (1.0 - s) * value(i, j + 1) + s * value(i + 1, j + 1);
        ((1.0 - t) * lower + t * upper) / total
    }
}

fn point(index: u32, dimension: u32) -> Vec2 {
    Sampler::new(SequenceKind::Independent, UVec2::new(3, 5), index, 1).at_2d(dimension)
}

#[test]
fn points_follow_the_values() {
    let count = 60_000;
    let mut results = Vec::new();
    for (case, map) in maps().iter().enumerate() {
        let distribution = PiecewiseBilinear2d::new(map.columns, map.rows, &map.values).expect(map.name);
        let density = density(map);
        // Four bins to a cell of the grid show its shape inside; large grids are counted by blocks of cells.
        let bins = |nodes: usize| if nodes < 20 { 2 * (nodes - 1) } else { 64 };
        let (across, down) = (bins(map.columns), bins(map.rows));
        let (width, height) = (1.0 / across as f64, 1.0 / down as f64);
        let expected: Vec<f64> = (0..across * down)
            .map(|bin| {
                let (left, top) = ((bin % across) as f64 * width, (bin / across) as f64 * height);
                let (inner_x, inner_y) = (map.columns.div_ceil(across).max(1), map.rows.div_ceil(down).max(1));
                let size = [width / inner_x as f64, height / inner_y as f64];
                let part = |at: usize| {
                    let corner = [
                        left + (at % inner_x) as f64 * size[0],
                        top + (at / inner_x) as f64 * size[1],
                    ];
                    match map.columns < 20 {
                        true => integrate(&density, corner, size),
                        false => density(corner[0] + size[0] / 2.0, corner[1] + size[1] / 2.0) * size[0] * size[1],
                    }
                };
                f64::from(count) * (0..inner_x * inner_y).map(part).sum::<f64>()
            })
            .collect();
        let mut counted = [vec![0.0; across * down], vec![0.0; across * down]];
        let mut count_in = |form: usize, [x, y]: [f32; 2]| {
            assert!((0.0..=1.0).contains(&x) && (0.0..=1.0).contains(&y), "{}", map.name);
            let bin = |x: f32, bins: usize| ((x * bins as f32) as usize).min(bins - 1);
            counted[form][bin(y, down) * across + bin(x, across)] += 1.0;
        };
        for start in (0..count).step_by(LANES) {
            let points: [Vec2; LANES] = std::array::from_fn(|lane| point(start + lane as u32, case as u32));
            points
                .iter()
                .for_each(|u| count_in(0, distribution.sample(u.to_array()).position));
            let numbers = [points.map(|u| u.x), points.map(|u| u.y)].map(Lanes::new);
            let together = distribution.sample(numbers).position;
            (0..LANES).for_each(|lane| count_in(1, together.map(|numbers| numbers.as_array()[lane])));
        }
        for (form, counted) in ["one", "sixteen"].into_iter().zip(&counted) {
            results.push((format!("{}, {form}", map.name), chi_squared_p(counted, &expected)));
        }
    }
    assert_all_plausible(&results);
}

#[test]
fn density_is_that_of_the_values_and_of_the_samples() {
    for (case, map) in maps().iter().enumerate() {
        let distribution = PiecewiseBilinear2d::new(map.columns, map.rows, &map.values).expect(map.name);
        let density = density(map);
        // A position is rounded to 2^-24; between nodes of very different density that is this much of the higher one.
        let rounding = |x: f32, y: f32| {
            let (cell_x, cell_y) = (1.0 / (map.columns - 1) as f32, 1.0 / (map.rows - 1) as f32);
            let near = |dx: f32, dy: f32| {
                density(
                    f64::from((x + dx * cell_x).clamp(0.0, 1.0)),
                    f64::from((y + dy * cell_y).clamp(0.0, 1.0)),
                )
            };
            let highest =
                [-1.0, 0.0, 1.0].map(|dx| [-1.0, 0.0, 1.0].map(|dy| near(dx, dy)).into_iter().fold(0.0, f64::max));
            let highest = highest.into_iter().fold(0.0, f64::max);
            highest * 2.0 * f64::from(f32::EPSILON) * (map.columns + map.rows) as f64
        };
        for index in 0..4000 {
            let uniform = point(index, 50 + case as u32);
            let expected = density(f64::from(uniform.x), f64::from(uniform.y));
            let found = f64::from(distribution.pdf(uniform.to_array()));
            let tolerance = 1e-5 * expected + rounding(uniform.x, uniform.y);
            assert!(
                (found - expected).abs() <= tolerance,
                "{}: {found}, {expected}",
                map.name
            );

            let sample = distribution.sample(point(index, 80 + case as u32).to_array());
            assert!(sample.pdf > 0.0 && sample.pdf.is_finite(), "{}: {sample:?}", map.name);
            let [x, y] = sample.position;
            let found = f64::from(distribution.pdf(sample.position));
            let tolerance = 1e-5 * found + rounding(x, y);
            assert!(
                (f64::from(sample.pdf) - found).abs() <= tolerance,
                "{}: {sample:?}, {found}",
                map.name
            );
        }
        for u in [[0.0, 0.0], [1.0, 1.0], [1.0, 0.0], [0.0, 1.0]] {
            assert!(
                distribution.sample(u.map(|u: f32| u.min(ONE_MINUS_EPSILON))).pdf > 0.0,
                "{}",
                map.name
            );
        }
        for outside in [[-0.1, 0.5], [0.5, 1.1], [f32::NAN; 2]] {
            assert_eq!(distribution.pdf(outside), 0.0);
        }
    }
}

#[test]
fn sixteen_points_are_the_points_of_one() {
    for (case, map) in maps().iter().enumerate() {
        let distribution = PiecewiseBilinear2d::new(map.columns, map.rows, &map.values).expect(map.name);
        let highest = highest_density(map);
        for index in (0..8000).step_by(LANES) {
            let edges = [0.0, ONE_MINUS_EPSILON, 0.5];
            let points: [Vec2; LANES] = std::array::from_fn(|lane| match index {
                0 => Vec2::new(edges[lane % 3], edges[lane / 3 % 3]),
                _ => point((index + lane) as u32, 20 + case as u32),
            });
            let together = distribution.sample([Lanes::new(points.map(|u| u.x)), Lanes::new(points.map(|u| u.y))]);
            let pdf = distribution.pdf(together.position);
            for (lane, &u) in points.iter().enumerate() {
                let one = distribution.sample(u.to_array());
                // Where cells have little of the whole, the rounding of sums moves points within them and across their
                // borders.
                let [x, y] = together.position.map(|numbers| numbers.as_array()[lane]);
                let moved = (x - one.position[0]).abs().max((y - one.position[1]).abs());
                let share = f64::from(one.pdf / highest);
                let name = map.name;
                assert!(f64::from(moved) * share < 1e-6, "{name}: {:?} {x} {y}", one.position);
                // Beside a node that is much higher its rounding counts.
                let (density, most) = (distribution.pdf([x, y]), 1e-6 * highest);
                let error = (density - pdf.as_array()[lane]).abs();
                assert!(error <= 1e-5 * density + most, "{name}: {density}");
            }
        }
    }
}

/// The highest density.
fn highest_density(map: &Map) -> f32 {
    let density = density(map);
    let (columns, rows) = (map.columns - 1, map.rows - 1);
    let at = |node: usize| {
        density(
            (node % map.columns) as f64 / columns as f64,
            (node / map.columns) as f64 / rows as f64,
        )
    };
    (0..map.values.len()).map(at).fold(0.0, f64::max) as f32
}

#[test]
fn well_spread_numbers_give_well_spread_points() {
    // An increasing map in both directions keeps the points of a net apart: no two of them fall together.
    let map = map("noise", 17, 11, random);
    let distribution = PiecewiseBilinear2d::new(map.columns, map.rows, &map.values).expect("values");
    let at = |x: u32, y: u32| {
        let [x, y] = distribution.sample([x as f32 / 64.0, y as f32 / 64.0]).position;
        Vec2::new(x, y)
    };
    for y in 0..63 {
        for x in 0..63 {
            assert!(at(x, y).x < at(x + 1, y).x && at(x, y).y < at(x, y + 1).y, "{x} {y}");
        }
    }
}

#[test]
fn nothing_to_choose_gives_none() {
    for (columns, rows, values) in [
        (3, 3, vec![0.0; 9]),
        (1, 4, vec![1.0; 4]),
        (4, 1, vec![1.0; 4]),
        (2, 2, vec![1.0; 5]),
        (2, 2, vec![f32::NAN, -1.0, f32::INFINITY, 0.0]),
        (0, 0, Vec::new()),
    ] {
        assert!(
            PiecewiseBilinear2d::new(columns, rows, &values).is_none(),
            "{columns} x {rows}"
        );
    }
}
