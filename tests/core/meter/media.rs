//! Meters inside of media, and media that glow.

use sunroom::material::Material;
use sunroom::medium::{MediumId, MediumInterface, MediumSource, Phase, Volume};

use super::*;

/// A medium that absorbs `sigma_t` per unit of length, and emits.
fn absorbing(sigma_t: f32, emission: f32) -> MediumSource {
    MediumSource {
        sigma_t: Volume::Constant(Vec3::splat(sigma_t)),
        scale: 1.0,
        albedo: Volume::ZERO,
        emission: Volume::Constant(Vec3::splat(emission)),
        phase: Phase::Isotropic,
    }
}

/// A ball of the medium of radius 1 around the origin, without a surface, below a light of intensity 1 at a height of
/// 3. The camera is outside.
fn ball(medium: MediumSource) -> RenderScene {
    let mut scene = SceneBuilder::with_media(vec![medium]);
    scene.add(Primitive::Sphere, Affine3A::IDENTITY, Material::Null, None);
    scene.between(MediumInterface {
        interior: Some(MediumId(0)),
        exterior: None,
    });
    scene.light(LightSource::Point {
        position: Vec3::Y * 3.0,
        intensity: Rgb::ONE,
    });
    scene.build()
}

#[test]
fn a_point_measures_in_the_medium_that_it_is_in() {
    let (scene, mut off_by) = (ball(absorbing(0.7, 0.0)), Vec::new());
    for (at, inside) in [
        (Vec3::ZERO, 1.0f64),
        (Vec3::Y * 0.5, 0.5),
        (Vec3::NEG_Y * 0.5, 1.5),
        (Vec3::Y * 2.0, 0.0),
    ] {
        let distance = f64::from(3.0 - at.y);
        let expected = K / (distance * distance) * (-f64::from(0.7f32) * inside).exp();
        let reading = &measure(&scene, vec![facing(Vec3::Y, at)], &exactly(1 << 10), 4)[0];
        off_by.push(off(&format!("at {at}"), reading.points[0], expected));
    }
}

#[test]
fn under_the_overcast_sky_media_do_not_glow() {
    let scene = ball(absorbing(0.7, 5.0));
    let meter = || vec![facing(Vec3::NEG_Y, Vec3::Y * 0.2)];
    let lit = measure(&scene, meter(), &exactly(1 << 10), 5)[0].points[0];
    assert!(lit.value > 100.0, "{lit:?}");
    let scene = lit_by(&scene, overcast_sky(Vec3::Y));
    // It faces the ground that is not there.
    assert_eq!(measure(&scene, meter(), &exactly(1 << 10), 5)[0].points[0].value, 0.0);
}
