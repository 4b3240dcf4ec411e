use glam::{Affine2, Affine3A, Mat3, Quat, Vec2, Vec3};

use super::super::pattern::{Bond, Bricks, CellValue, Cells, Mix, MixMode, Noise, Ramp, Stop, Wood};
use super::super::{BoxProjection, ObjectPoint, Up};
use super::*;

const GREYS: [Parameter<Rgb>; 2] = [Parameter::Constant(Rgb::ZERO), Parameter::Constant(Rgb::ONE)];

/// Patterns with this map of uv, and the extent of their finest details.
fn patterns(to_uv: Affine2) -> Vec<(&'static str, Texture, f32)> {
    let noise = Noise {
        colors: GREYS,
        octaves: 4,
        gain: 0.5,
        distortion: 0.0,
        ridged: false,
        to_uv,
    };
    let cells = Cells {
        colors: GREYS,
        value: CellValue::Distance,
        scatter: 0.8,
        to_uv,
    };
    let bricks = Bricks {
        colors: [Parameter::Constant(Rgb::ONE); 2],
        joint_color: Parameter::Constant(Rgb::ZERO),
        size: [2.15, 0.65],
        joint: 0.1,
        bevel: 0.2,
        bond: Bond::Running,
        offset: 0.5,
        to_uv,
    };
    let wood = Wood {
        colors: GREYS,
        ring: 0.7,
        waviness: 1.0,
        to_uv,
    };
    let stop = |at: f32, grey: f32| Stop {
        at,
        color: Rgb::splat(grey),
    };
    let ramp = Ramp {
        input: None,
        stops: [stop(0.0, 0.0), stop(1.5, 1.0), stop(1.7, 0.2), stop(4.0, 0.8)].into(),
        to_uv,
    };
    vec![
        ("noise", Texture::Noise(noise), 0.125),
        ("cells", Texture::Cells(cells), 1.0),
        ("bricks", Texture::Bricks(bricks), 0.2),
        ("wood", Texture::Wood(wood), 0.7),
        ("ramp", Texture::Ramp(ramp), 0.2),
    ]
}

/// The derivative of a function by a quotient of fourth order. None beside a kink, where those to both sides differ.
fn derivative(value: impl Fn(f32) -> f32, step: f32) -> Option<f32> {
    let at = |steps: f32| f64::from(value(steps * step));
    let (near, far) = (at(1.0) - at(-1.0), at(2.0) - at(-2.0));
    let central = (8.0 * near - far) / (12.0 * f64::from(step));
    let [ahead, behind] = [1.0, -1.0].map(|side: f32| {
        let side64 = f64::from(side);
        side64 * (-3.0 * at(0.0) + 4.0 * at(8.0 * side) - at(16.0 * side)) / (16.0 * f64::from(step))
    });
    let scale = central.abs().max(0.1);
    ((ahead - behind).abs() < 0.2 * scale).then_some(central as f32)
}

#[test]
fn slopes_are_derivatives_at_every_scale() {
    let at_unit = patterns(Affine2::IDENTITY);
    for scale in [1e-4, 1e-2, 1.0, 1e2, 1e4] {
        // Different scales of both axes, turned.
        let map = Affine2::from_angle(0.3) * Affine2::from_scale(Vec2::new(scale, 0.25 * scale));
        for ((name, texture, _), (_, plain, detail)) in patterns(map).into_iter().zip(&at_unit) {
            let [scaled, plain] = [texture, plain.clone()].map(|texture| TextureTable::new(vec![texture]));
            let id = TextureId(0);
            let mut compared = 0;
            for number in 0..200 {
                let place = Vec2::new(0.0171 * number as f32, 0.618 * number as f32 % 3.7) + 0.03;
                let by = |along: Vec2| {
                    let value = |step: f32| plain.float_of(id, &TexturePoint::of_uv(place + step * along));
                    derivative(value, detail / 128.0)
                };
                let (Some(by_x), Some(by_y)) = (by(Vec2::X), by(Vec2::Y)) else {
                    continue;
                };
                let expected = map.matrix2.transpose() * Vec2::new(by_x, by_y);
                let uv = map.inverse().transform_point2(place);
                let found = scaled.gradient(Parameter::Texture(id), &TexturePoint::of_uv(uv));
                let error = (found - expected).abs().max_element() / scale;
                let allowed = 0.02 * (expected.abs().max_element() / scale).max(1.0 / detail);
                assert!(error < allowed, "{name} at {place}, scale {scale}: {found} {expected}");
                compared += 1;
            }
            assert!(compared > 100, "{name}: {compared}");
        }
    }
}

/// A box projection of noise, by itself, mixed with a constant, and as the input of a ramp.
fn projected(up: Up) -> TextureTable {
    let input = Parameter::Texture(TextureId(0));
    let (_, noise, _) = patterns(Affine2::from_scale(Vec2::splat(1.5))).swap_remove(0);
    let projection = BoxProjection {
        input,
        up,
        to_uv: Affine2::from_angle(0.7) * Affine2::from_scale(Vec2::new(1.0, 2.0)),
    };
    let inside = Parameter::Texture(TextureId(1));
    let mix = Mix {
        colors: [inside, Parameter::Constant(Rgb::ONE)],
        weight: Parameter::Constant(Rgb::splat(0.25)),
        mode: MixMode::Mix,
    };
    let stops = [0.0, 1.0].map(|at| Stop {
        at,
        color: Rgb::splat(3.0 * at),
    });
    let ramp = Ramp {
        input: Some(Parameter::Texture(TextureId(2))),
        stops: stops.into(),
        to_uv: Affine2::IDENTITY,
    };
    TextureTable::new(vec![
        noise,
        Texture::BoxProjection(projection),
        Texture::Mix(mix),
        Texture::Ramp(ramp),
    ])
}

/// The slope is that of the value where the surface really goes, also inside other textures and on sheared shapes.
#[test]
fn box_projections_have_slopes_inside_other_textures() {
    let turned = Affine3A::from_scale_rotation_translation(
        Vec3::new(3.0, 0.5, 2.0),
        Quat::from_rotation_y(0.4) * Quat::from_rotation_x(0.2),
        Vec3::new(5.0, 6.0, 7.0),
    );
    let sheared = Affine3A::from_mat3(Mat3::from_cols(
        Vec3::new(2.0, 0.0, 0.3),
        Vec3::new(0.8, 1.0, 0.0),
        Vec3::new(0.0, 0.4, 1.5),
    ));
    for pose in [turned, sheared] {
        // A part of the side +z, whose u and v run askew.
        let [du, dv] = [Vec3::new(0.7, 0.2, 0.0), Vec3::new(-0.3, 0.9, 0.0)].map(|along| pose.transform_vector3(along));
        let normal = du.cross(dv).normalize();
        for up in Up::ALL {
            let table = projected(up);
            for number in 0..20 {
                let local = Vec3::new(0.05 * number as f32, 0.4 - 0.031 * number as f32, 1.0);
                let point = |uv: Vec2| TexturePoint {
                    object: Some(ObjectPoint::new(
                        &pose,
                        pose.transform_point3(local) + uv.x * du + uv.y * dv,
                        normal,
                        [du, dv],
                    )),
                    ..TexturePoint::of_uv(uv)
                };
                let slopes = [1, 2, 3].map(|id| table.gradient(Parameter::Texture(TextureId(id)), &point(Vec2::ZERO)));
                let step = 5e-4;
                let value = |uv: Vec2| table.float_of(TextureId(1), &point(uv));
                let expected = [Vec2::X, Vec2::Y].map(|axis| (value(step * axis) - value(-step * axis)) / (2.0 * step));
                let expected = Vec2::from(expected);
                for (slope, factor) in slopes.into_iter().zip([1.0, 0.75, 2.25]) {
                    let error = (slope - factor * expected).abs().max_element();
                    assert!(
                        error < 0.02 * factor * expected.length().max(0.5),
                        "{slope} {expected} {factor}"
                    );
                }
                assert!(expected.length() > 1e-2);
            }
        }
    }
}

/// Textures that are alike along an axis, constant, or at a place without an extent in uv are flat.
#[test]
fn slopes_without_a_step_are_zero() {
    let table = projected(Up::Y);
    let object = ObjectPoint::new(&Affine3A::IDENTITY, Vec3::splat(0.3), Vec3::Z, [Vec3::ZERO, Vec3::Y]);
    let at = TexturePoint {
        object: Some(object),
        ..TexturePoint::of_uv(Vec2::ZERO)
    };
    let slope = table.gradient(Parameter::Texture(TextureId(2)), &at);
    assert_eq!(slope.x, 0.0);
    assert!(slope.y != 0.0 && slope.y.is_finite());
    let mix = Mix {
        colors: GREYS,
        weight: Parameter::Constant(Rgb::ONE),
        mode: MixMode::Add,
    };
    let table = TextureTable::new(vec![Texture::Mix(mix)]);
    let slope = table.gradient(
        Parameter::Texture(TextureId(0)),
        &TexturePoint::of_uv(Vec2::splat(f32::NAN)),
    );
    assert_eq!(slope, Vec2::ZERO);
}
