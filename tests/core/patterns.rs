//! Procedural textures: the same bits for one point and for sixteen, their statistics, and where joints lie.

use glam::{Affine2, Affine3A, Mat3, Quat, Vec2, Vec3};

use sunroom::color::Rgb;
use sunroom::math::Real;
use sunroom::math::lanes::{LANES, Lanes};
use sunroom::texture::pattern::{Bond, Bricks, CellValue, Cells, Mix, MixMode, Noise, Ramp, Stop, Wood};
use sunroom::texture::{BoxProjection, ObjectPoint, Parameter, Texture, TextureId, TexturePoint, TextureTable, Up};

const GREYS: [Parameter<Rgb>; 2] = [Parameter::Constant(Rgb::ZERO), Parameter::Constant(Rgb::ONE)];

fn noise() -> Noise {
    Noise {
        colors: GREYS,
        octaves: 4,
        gain: 0.5,
        distortion: 0.0,
        ridged: false,
        to_uv: Affine2::IDENTITY,
    }
}

fn cells(value: CellValue) -> Cells {
    Cells {
        colors: GREYS,
        value,
        scatter: 1.0,
        to_uv: Affine2::IDENTITY,
    }
}

/// Bricks of 215 x 65 mm with joints of 10 mm.
fn bricks(bond: Bond) -> Bricks {
    Bricks {
        colors: [Parameter::Constant(Rgb::ONE); 2],
        joint_color: Parameter::Constant(Rgb::ZERO),
        size: [0.215, 0.065],
        joint: 0.01,
        bevel: 0.0,
        bond,
        offset: 0.5,
        to_uv: Affine2::IDENTITY,
    }
}

fn wood() -> Wood {
    Wood {
        colors: GREYS,
        ring: 0.003,
        waviness: 1.0,
        to_uv: Affine2::IDENTITY,
    }
}

/// Points on a grid that is nowhere in step with a lattice of whole numbers.
fn points(count: usize, spacing: f32) -> impl Iterator<Item = [f32; 2]> {
    let at = move |i: usize| spacing * (i as f32 + 0.37) - 0.5 * spacing * count as f32;
    (0..count * count).map(move |i| [at(i % count), at(i / count)])
}

/// The formula for single points, and for lanes.
fn assert_same<const N: usize>(
    name: &str,
    spacing: f32,
    one: impl Fn([f32; 2]) -> [f32; N],
    many: impl Fn([Lanes; 2]) -> [Lanes; N],
) {
    let points: Vec<[f32; 2]> = points(32, spacing).collect();
    for together in points.chunks_exact(LANES) {
        let coordinate = |axis: usize| Lanes::new(std::array::from_fn(|lane| together[lane][axis]));
        let found = many([coordinate(0), coordinate(1)]);
        for (lane, point) in together.iter().enumerate() {
            for (number, lanes) in one(*point).into_iter().zip(&found) {
                let other = lanes.as_array()[lane];
                assert_eq!(
                    number.to_bits(),
                    other.to_bits(),
                    "{name} at {point:?}: {number} {other}"
                );
            }
        }
    }
}

fn numbers<R: Real>(bricks: &Bricks, at: [R; 2]) -> [R; 6] {
    let place = bricks.place(at);
    let [u, v] = place.at;
    let [column, row] = place.brick;
    [u, v, place.share, column, row, Bricks::own(place.brick)]
}

#[test]
fn one_point_and_sixteen_have_the_same_bits() {
    let marble = Noise {
        distortion: 1.5,
        ridged: true,
        ..noise()
    };
    for noise in [noise(), marble] {
        assert_same("noise", 0.171, |at| [noise.share(at)], |at| [noise.share(at)]);
        assert_same("noise far away", 913.7, |at| [noise.share(at)], |at| [noise.share(at)]);
    }
    for value in CellValue::ALL {
        let cells = cells(value);
        assert_same(value.name(), 0.171, |at| [cells.share(at)], |at| [cells.share(at)]);
    }
    for bond in Bond::ALL {
        for bevel in [0.0, 0.004] {
            let bricks = Bricks { bevel, ..bricks(bond) };
            assert_same(
                bond.name(),
                0.0171,
                |at| numbers(&bricks, at),
                |at| numbers(&bricks, at),
            );
        }
    }
    let wood = wood();
    assert_same("wood", 0.0011, |at| [wood.share(at)], |at| [wood.share(at)]);
    let stop = |at: f32, color: [f32; 3]| Stop {
        at,
        color: color.into(),
    };
    let ramp = Ramp {
        input: None,
        stops: [
            stop(-1.0, [0.1, 0.2, 0.3]),
            stop(0.4, [0.7, 0.1, 0.9]),
            stop(0.4, [0.2, 0.0, 1.0]),
            stop(2.0, [0.3, 0.3, 0.3]),
        ]
        .into(),
        to_uv: Affine2::IDENTITY,
    };
    assert_same("ramp", 0.171, |[x, _]| ramp.color(x), |[x, _]| ramp.color(x));
}

fn mean_and_deviation(values: impl Iterator<Item = f32>) -> (f32, f32) {
    let values: Vec<f64> = values.map(f64::from).collect();
    let mean = values.iter().sum::<f64>() / values.len() as f64;
    let variance = values.iter().map(|value| (value - mean).powi(2)).sum::<f64>() / values.len() as f64;
    (mean as f32, variance.sqrt() as f32)
}

/// Gradients are symmetric, so that the mean is a half. The variance of gradient noise with unit gradients follows from
/// the integral of the squared weights: half the sum over the corners of the mean of w(x)^2 w(y)^2 (dx^2 + dy^2), which
/// is 4 * 0.5 * 2 * a * b with a the integral of w^2 and b that of w^2 x^2.
#[test]
fn noise_has_its_mean_and_its_variance() {
    let fade = |t: f64| t * t * t * (t * (6.0 * t - 15.0) + 10.0);
    let steps = 10_000;
    let integral = |f: &dyn Fn(f64) -> f64| (0..steps).map(|i| f((i as f64 + 0.5) / steps as f64)).sum::<f64>();
    let weight = |x: f64| 1.0 - fade(x);
    let a = integral(&|x| weight(x).powi(2)) / steps as f64;
    let b = integral(&|x| (weight(x) * x).powi(2)) / steps as f64;
    // Two for the scale to [-1, 1], squared; a quarter for the map to [0, 1].
    let expected = (2.0 * 4.0 * a * b * 0.25_f64).sqrt() as f32;
    for octaves in [1, 4] {
        let noise = Noise { octaves, ..noise() };
        let (mean, deviation) = mean_and_deviation(points(700, 0.171).map(|at| noise.share(at)));
        assert!((mean - 0.5).abs() < 0.01, "{octaves} octaves: the mean is {mean}");
        assert!(
            (deviation - expected).abs() < 0.05 * expected,
            "{octaves} octaves: the deviation is {deviation}, not {expected}"
        );
    }
    // At the corners of the lattice it is a half.
    let one = Noise { octaves: 1, ..noise() };
    for at in [[0.0, 0.0], [3.0, -2.0], [-0.0, 17.0]] {
        assert_eq!(one.share(at), 0.5, "{at:?}");
    }
    // It is continuous across the lattice, negative zero included.
    for (near, across) in [([-1e-5, 0.3], [1e-5, 0.3]), ([5.999_99, -1e-5], [6.000_01, 1e-5])] {
        assert!((one.share(near) - one.share(across)).abs() < 1e-3);
    }
}

#[test]
fn random_numbers_of_cells_and_bricks_are_even() {
    let cells = cells(CellValue::Random);
    let of_cells = mean_and_deviation(points(300, 1.0).map(|at| cells.share(at)));
    let of_bricks = mean_and_deviation(points(300, 1.0).map(|[x, y]| Bricks::own([x.floor(), y.floor()])));
    for (mean, deviation) in [of_cells, of_bricks] {
        // The deviation of an even distribution is 1 / sqrt(12).
        assert!((mean - 0.5).abs() < 0.01, "{mean}");
        assert!((deviation - 0.2887).abs() < 0.01, "{deviation}");
    }
}

#[test]
fn a_border_is_zero_between_two_cells() {
    // Without scatter the points are the middles of squares.
    let squares = |value| Cells {
        scatter: 0.0,
        ..cells(value)
    };
    let (distance, border) = (squares(CellValue::Distance), squares(CellValue::Border));
    assert_eq!((distance.share([0.5, 0.5]), distance.share([2.5, -0.75])), (0.0, 0.25));
    assert!(border.share([1.0, 0.5]) < 1e-6);
    assert!((border.share([0.75, 0.5]) - 0.5).abs() < 1e-6);
}

#[test]
fn joints_lie_where_their_measures_say() {
    let wall = bricks(Bond::Running);
    let is_joint = |x: f32, y: f32| wall.place([x, y]).share == 0.0;
    for row in -3_i32..4 {
        let low = 0.075 * row as f32;
        let shift = if row.rem_euclid(2) == 1 { 0.1125 } else { 0.0 };
        for column in -3..4 {
            let left = 0.225 * column as f32 + shift;
            let inside = [0.001, 0.107, 0.214].map(|x| is_joint(left + x, low + 0.03));
            assert_eq!(inside, [false; 3], "row {row}, brick {column}");
            let beside = [0.216, 0.220, 0.224].map(|x| is_joint(left + x, low + 0.03));
            assert_eq!(beside, [true; 3], "row {row}, brick {column}");
            let above = [0.0645, 0.066, 0.0745].map(|y| is_joint(left + 0.1, low + y));
            assert_eq!(above, [false, true, true], "row {row}, brick {column}");
        }
    }
    // Nobody's row begins with the same brick.
    let boards = bricks(Bond::Random);
    let starts: Vec<f32> = (0..8)
        .map(|row| boards.place([0.0, 0.03 + 0.075 * row as f32]).at[0])
        .collect();
    assert!(
        starts.windows(2).all(|pair| (pair[0] - pair[1]).abs() > 1e-3),
        "{starts:?}"
    );
}

/// Each brick of a herringbone covers as much as any other, none lies over another, and nothing is left.
#[test]
fn a_herringbone_covers_the_plane() {
    let parquet = Bricks {
        size: [0.49, 0.07],
        joint: 0.0,
        ..bricks(Bond::Herringbone)
    };
    let mut counts = std::collections::BTreeMap::new();
    for at in points(1200, 0.0033) {
        let place = parquet.place(at);
        assert_eq!(place.share, 1.0, "{at:?}");
        assert!((0.0..=0.49 + 1e-4).contains(&place.at[0]) && (0.0..=0.07 + 1e-4).contains(&place.at[1]));
        // Bricks that are surely in sight as a whole.
        if at.iter().all(|x| x.abs() < 1.2) {
            *counts.entry(place.brick.map(|x| (2.0 * x) as i32)).or_insert(0_u32) += 1;
        }
    }
    // As many points of the grid lie along an edge as spacings fit into it, or one more.
    let [least, most] = [0.0, 1.0].map(|more| [0.49, 0.07].map(|edge: f32| (edge / 0.0033).floor() + more));
    let [least, most] = [least, most].map(|[along, across]| (along * across) as u32);
    let full = counts.values().filter(|count| **count >= least).count();
    assert!(full > 80, "{full} of {}", counts.len());
    assert!(counts.values().all(|count| *count <= most));
    let [lying, upright] = [0, 1].map(|odd| counts.keys().filter(|brick| brick[0].rem_euclid(2) == odd).count());
    assert!(lying.abs_diff(upright) < 20, "{lying} {upright}");
}

#[test]
fn a_bevel_rises_from_the_joint() {
    let wall = Bricks {
        bevel: 0.004,
        ..bricks(Bond::Running)
    };
    let at = |x: f32| wall.place([x, 0.03]).share;
    assert_eq!((at(0.22), at(0.1)), (0.0, 1.0));
    assert!((at(0.002) - 0.5).abs() < 1e-3);
}

fn table(textures: Vec<Texture>) -> (TextureTable, TextureId) {
    let last = TextureId(textures.len() as u32 - 1);
    (TextureTable::new(textures), last)
}

#[test]
fn textures_lie_differently_on_every_brick() {
    let noise = Noise {
        to_uv: Affine2::from_scale(Vec2::splat(40.0)),
        ..noise()
    };
    let wall = Bricks {
        colors: [Parameter::Texture(TextureId(0)); 2],
        ..bricks(Bond::Running)
    };
    let (table, id) = table(vec![Texture::Noise(noise), Texture::Bricks(wall)]);
    let color = |x: f32| table.color(Parameter::Texture(id), &TexturePoint::of_uv(Vec2::new(x, 0.03)));
    let values: Vec<f32> = (0..6).map(|brick| color(0.1 + 0.225 * brick as f32).x).collect();
    assert!(
        values.windows(2).all(|pair| (pair[0] - pair[1]).abs() > 1e-4),
        "{values:?}"
    );
    assert_eq!(color(0.22), Rgb::ZERO);
}

#[test]
fn mixtures_follow_their_formulas() {
    let (a, b) = (Rgb::new(0.8, 0.4, 0.2), Rgb::new(0.5, 0.5, 0.1));
    let value = |mode, weight: f32| {
        let mix = Mix {
            colors: [a, b].map(Parameter::Constant),
            weight: Parameter::Constant(Rgb::splat(weight)),
            mode,
        };
        let (table, id) = table(vec![Texture::Mix(mix)]);
        let at = TexturePoint::of_uv(Vec2::ZERO);
        let number = table.float(Parameter::Texture(id), &at);
        (table.color(Parameter::Texture(id), &at), number)
    };
    let near = |found: Rgb, expected: Rgb| assert!(found.abs_diff_eq(expected, 1e-6), "{found} {expected}");
    near(value(MixMode::Mix, 0.25).0, 0.75 * a + 0.25 * b);
    near(value(MixMode::Mix, 7.0).0, b);
    near(value(MixMode::Multiply, 1.0).0, a * b);
    near(value(MixMode::Multiply, 0.5).0, a * (0.5 + 0.5 * b));
    near(value(MixMode::Add, -0.5).0, a - 0.5 * b);
    assert!((value(MixMode::Mix, 0.0).1 - 1.4 / 3.0).abs() < 1e-6);
}

/// A texture that is u, and one that is v.
fn ramps() -> [Texture; 2] {
    let ramp = |to_uv| {
        let stop = |at: f32| Stop {
            at,
            color: Rgb::splat(at),
        };
        Texture::Ramp(Ramp {
            input: None,
            stops: [stop(-100.0), stop(100.0)].into(),
            to_uv,
        })
    };
    [
        ramp(Affine2::IDENTITY),
        ramp(Affine2::from_angle(-std::f32::consts::FRAC_PI_2)),
    ]
}

/// Coordinates are lengths of the world whatever the scale; v is upright, and u grows to the right seen from outside.
#[test]
fn a_box_projection_measures_the_world() {
    let turn = Quat::from_rotation_y(0.4);
    let pose = Affine3A::from_scale_rotation_translation(Vec3::new(4.0, 0.5, 2.0), turn, Vec3::new(5.0, 6.0, 7.0));
    let project = |local: Vec3, normal: Vec3, up: Up| {
        let textures = ramps().map(|ramp| {
            let input = Parameter::Texture(TextureId(0));
            let projection = BoxProjection {
                input,
                up,
                to_uv: Affine2::IDENTITY,
            };
            table(vec![ramp, Texture::BoxProjection(projection)])
        });
        let position = pose.transform_point3(local);
        let object = ObjectPoint::new(&pose, position, turn * normal, [Vec3::ZERO; 2]);
        let at = TexturePoint {
            object: Some(object),
            ..TexturePoint::of_uv(Vec2::ZERO)
        };
        textures.map(|(table, id)| table.float(Parameter::Texture(id), &at))
    };
    let near = |found: [f32; 2], expected: [f32; 2]| {
        let distance = (found[0] - expected[0]).abs().max((found[1] - expected[1]).abs());
        assert!(distance < 1e-4, "{found:?} {expected:?}");
    };
    let local = Vec3::new(0.25, 0.5, 1.0);
    // The place along the axes is (1, 0.25, 2).
    near(project(local, Vec3::Z, Up::Y), [1.0, 0.25]);
    near(project(local, Vec3::NEG_Z, Up::Y), [-1.0, 0.25]);
    near(project(local, Vec3::X, Up::Y), [-2.0, 0.25]);
    near(project(local, Vec3::NEG_X, Up::Y), [2.0, 0.25]);
    near(project(local, Vec3::Y, Up::Y).map(f32::abs), [1.0, 2.0]);
    // With z up the axis nearest to z is upright.
    near(project(local, Vec3::X, Up::Z).map(f32::abs), [0.25, 2.0]);
    // A slope belongs to the side that it faces most.
    near(project(local, Vec3::new(0.2, 0.3, 0.9), Up::Y), [1.0, 0.25]);
}

#[test]
fn a_shape_without_extent_is_no_trouble() {
    let flat = Affine3A::from_mat3(Mat3::from_diagonal(Vec3::new(1.0, 1.0, 0.0)));
    let object = ObjectPoint::new(&flat, Vec3::ONE, Vec3::Z, [Vec3::X, Vec3::Y]);
    assert!(object.place.is_finite() && object.axes.iter().all(|axis| axis.is_finite()));
}

/// Numbers that no scene has on purpose give numbers.
#[test]
fn values_stay_finite() {
    let extreme = Affine2::from_scale(Vec2::splat(3e37));
    let textures = [
        Texture::Noise(Noise {
            to_uv: extreme,
            octaves: 1000,
            gain: 1.0,
            distortion: 1e3,
            ..noise()
        }),
        Texture::Cells(Cells {
            to_uv: extreme,
            ..cells(CellValue::Border)
        }),
        Texture::Bricks(Bricks {
            size: [1e-30, 1e30],
            joint: 0.0,
            ..bricks(Bond::Herringbone)
        }),
        Texture::Bricks(Bricks {
            size: [1e-38, 1e-38],
            joint: 0.0,
            ..bricks(Bond::Random)
        }),
        Texture::Wood(Wood { ring: 1e-38, ..wood() }),
        Texture::Wood(Wood { ring: 1e38, ..wood() }),
    ];
    for texture in textures {
        let (table, id) = table(vec![texture.clone()]);
        for uv in [
            Vec2::ZERO,
            Vec2::splat(1e30),
            Vec2::new(-1e38, 1e-38),
            Vec2::splat(f32::NAN),
        ] {
            let color = table.color(Parameter::Texture(id), &TexturePoint::of_uv(uv));
            assert!(color.is_finite(), "{texture:?} at {uv}: {color}");
        }
    }
}
