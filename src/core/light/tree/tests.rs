//! Tests the probabilities of the tree, on ordinary and on awkward sets of emitters.

use glam::Vec3;

use super::LightTree;
use crate::light::LightReference;
use crate::light::bounds::{LightBounds, NormalCone};
use crate::math::Aabb;
use crate::sampling::hash::pcg4d;
use crate::sampling::{unit_float, warp};

fn random(index: u32, stream: u32) -> [f32; 4] {
    pcg4d([index, stream, 21, 22]).map(unit_float)
}

fn random_direction(index: u32, stream: u32) -> Vec3 {
    let [a, b, ..] = random(index, stream);
    warp::uniform_sphere([a, b])
}

fn point(position: Vec3, intensity: f32) -> LightBounds {
    LightBounds {
        bounds: Aabb::from_points([position]),
        cone: NormalCone::ALL,
        cos_emission: 0.0,
        intensity,
    }
}

/// A patch without extent, facing `normal`.
fn patch(position: Vec3, normal: Vec3, intensity: f32) -> LightBounds {
    LightBounds {
        cone: NormalCone::single(normal),
        ..point(position, intensity)
    }
}

fn scattered(index: u32) -> Vec3 {
    let [x, y, z, _] = random(index, 1);
    2.0 * Vec3::new(x, y, z) - Vec3::ONE
}

fn cases() -> Vec<(&'static str, Vec<LightBounds>)> {
    let set = |count: u32, emitter: &dyn Fn(u32) -> LightBounds| (0..count).map(emitter).collect::<Vec<_>>();
    let power = |index: u32| random(index, 2)[0] + 0.01;
    vec![
        ("one", set(1, &|_| point(Vec3::X, 1.0))),
        ("two", set(2, &|i| point(scattered(i), power(i)))),
        (
            "three",
            set(3, &|i| patch(scattered(i), random_direction(i, 3), power(i))),
        ),
        ("points", set(300, &|i| point(scattered(i), power(i)))),
        (
            "patches",
            set(300, &|i| patch(scattered(i), random_direction(i, 3), power(i))),
        ),
        (
            "patches facing down from a ceiling",
            set(300, &|i| patch(scattered(i).with_y(1.0), Vec3::NEG_Y, power(i))),
        ),
        ("all at one place", set(100, &|i| point(Vec3::ONE, power(i)))),
        (
            "around one centre",
            set(100, &|i| LightBounds {
                bounds: Aabb {
                    min: Vec3::splat(-1.0 / (1.0 + i as f32)),
                    max: Vec3::splat(1.0 / (1.0 + i as f32)),
                },
                ..patch(Vec3::ZERO, random_direction(i, 3), power(i))
            }),
        ),
        (
            "ever further along a line",
            set(100, &|i| point(Vec3::X * (i as f32 - 50.0).exp2(), power(i))),
        ),
        (
            "of very different strength",
            set(60, &|i| point(scattered(i), (i as f32 - 30.0).exp2())),
        ),
        (
            "a far pair and a near crowd",
            set(50, &|i| {
                let near = 1e-3 * scattered(i);
                point(if i < 2 { near + 1e6 * Vec3::ONE } else { near }, power(i))
            }),
        ),
    ]
}

/// References inside, outside, far away, and at emitters; each with and without a normal.
fn references(lights: &[LightBounds]) -> Vec<LightReference> {
    let at_light = |index: usize| lights[index % lights.len()].bounds.center();
    let mut positions: Vec<Vec3> = (100..110).map(scattered).collect();
    positions.extend([Vec3::splat(3.0), Vec3::new(-40.0, 7.0, 1e3), at_light(0), at_light(7)]);
    let normals = (0..positions.len() as u32).map(|index| random_direction(index, 4));
    let with = positions.iter().zip(normals).map(|(&position, normal)| LightReference {
        position,
        normal: Some(normal),
    });
    let without = positions
        .iter()
        .map(|&position| LightReference { position, normal: None });
    with.chain(without).collect()
}

fn build(lights: &[LightBounds]) -> LightTree {
    let lights: Vec<_> = lights.iter().copied().map(Some).collect();
    LightTree::build(&lights).expect("shining lights")
}

/// Every emitter owns one interval of the random number, as long as its probability. The count of evenly spaced numbers
/// in it differs from that length by less than one.
#[test]
fn emitters_are_chosen_as_often_as_their_probability_says() {
    const DRAWS: u32 = 20_000;
    for (name, lights) in cases() {
        let tree = build(&lights);
        for reference in references(&lights) {
            let mut counted = vec![0u32; lights.len()];
            let mut none = 0;
            for draw in 0..DRAWS {
                let u = (f64::from(draw) + 0.5) / f64::from(DRAWS);
                match tree.sample(&reference, u) {
                    Some((emitter, pmf)) => {
                        counted[emitter as usize] += 1;
                        let again = tree.pmf(&reference, emitter);
                        // One rounding per level, multiplied in the other order, then one to single precision.
                        assert!((pmf / again - 1.0).abs() < 1e-6, "{name}: {pmf} or {again}");
                    }
                    None => none += 1,
                }
            }
            let mut total = 0.0;
            for (emitter, &count) in (0..).zip(&counted) {
                let pmf = tree.pmf(&reference, emitter);
                total += f64::from(pmf);
                let expected = pmf * DRAWS as f32;
                assert!(
                    (count as f32 - expected).abs() <= 1.01,
                    "{name}: emitter {emitter} {count} times instead of {expected} from {reference:?}"
                );
            }
            // The other numbers choose no emitter: one interval for each branch whose emitters have no effect.
            let vain = f64::from(none) / f64::from(DRAWS);
            let tolerance = 1e-5 + (lights.len() as f64) / f64::from(DRAWS);
            assert!(
                (total + vain - 1.0).abs() < tolerance,
                "{name}: {total} and {vain} in vain"
            );
        }
    }
}

#[test]
fn what_contributes_can_be_chosen() {
    for (name, lights) in cases() {
        let tree = build(&lights);
        for reference in references(&lights) {
            for (emitter, light) in (0..).zip(&lights) {
                let to_light = light.bounds.center() - reference.position;
                let apart = light.bounds.extent() + to_light.abs() != Vec3::ZERO;
                let above = reference.normal.is_none_or(|normal| normal.dot(to_light) > 0.0);
                let facing = light.cone.cos_angle == -1.0 || light.cone.axis.dot(to_light) < 0.0;
                if apart && above && facing {
                    let pmf = tree.pmf(&reference, emitter);
                    assert!(
                        pmf > 0.0,
                        "{name}: emitter {emitter} is never chosen from {reference:?}"
                    );
                }
            }
        }
    }
}

#[test]
fn a_patch_that_faces_away_or_lies_below_the_horizon_is_left_out() {
    let lights = [
        patch(Vec3::new(0.0, 1.0, 0.0), Vec3::NEG_Y, 1.0),
        patch(Vec3::new(0.1, 1.0, 0.0), Vec3::Y, 1.0),
        patch(Vec3::new(0.0, -1.0, 0.0), Vec3::Y, 1.0),
    ];
    let tree = build(&lights);
    let pmfs = |normal| {
        let reference = LightReference {
            position: Vec3::ZERO,
            normal,
        };
        [0, 1, 2].map(|emitter| tree.pmf(&reference, emitter) > 0.0)
    };
    assert_eq!(pmfs(None), [true, false, true]);
    assert_eq!(pmfs(Some(Vec3::Y)), [true, false, false]);
}

/// At a distance of a few radii, the choice is proportional to the irradiance within a factor that the balls of the
/// nodes explain.
#[test]
fn near_and_strong_lights_are_preferred() {
    let lights: Vec<_> = (0..200).map(|i| point(scattered(i), 1.0)).collect();
    let tree = build(&lights);
    let reference = LightReference {
        position: Vec3::new(0.2, -0.1, 0.3),
        normal: None,
    };
    let irradiance = |light: &LightBounds| 1.0 / light.bounds.center().distance_squared(reference.position);
    let sum: f32 = lights.iter().map(irradiance).sum();
    // Relative second moment of contribution over probability: 1 for the perfect choice.
    let moment = |pmf: &dyn Fn(u32) -> f32| -> f32 {
        let term = |(emitter, light)| (irradiance(light) / sum).powi(2) / pmf(emitter);
        (0..).zip(&lights).map(term).sum()
    };
    let (tree, even) = (
        moment(&|emitter| tree.pmf(&reference, emitter)),
        moment(&|_| 1.0 / 200.0),
    );
    assert!(
        tree - 1.0 < 0.5 * (even - 1.0),
        "{tree} against {even} by an even choice"
    );
}

#[test]
fn dark_emitters_have_no_place() {
    let lit = Some(point(Vec3::ZERO, 1.0));
    let reference = LightReference {
        position: Vec3::ONE,
        normal: None,
    };
    assert!(LightTree::build(&[None, None]).is_none());
    assert!(LightTree::build(&[]).is_none());
    let tree = LightTree::build(&[None, lit, None, lit]).expect("two lights");
    assert_eq!(
        [0, 1, 2, 3].map(|emitter| tree.pmf(&reference, emitter)),
        [0.0, 0.5, 0.0, 0.5]
    );
}
