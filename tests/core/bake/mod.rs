//! Lightmaps: the light on texels, the bits of it, the places of surfaces, and the files of what is gathered.

mod bits;
mod files;
mod layers;
mod layout;
mod light;
mod spread;

use std::f32::consts::PI;
use std::sync::atomic::AtomicBool;

use glam::{Affine3A, Quat, UVec2, Vec2, Vec3};
use sunroom::accel::Primitive;
use sunroom::bake::lightmap::Lightmaps;
use sunroom::bake::texels::{BakeSurface, Texels, covered_texels};
use sunroom::color::{Rgb, luminance};
use sunroom::light::LightSource;
use sunroom::render::gathering::Gathering;
use sunroom::render::irradiance::ReceivedLight;
use sunroom::render::scene::RenderScene;
use sunroom::render::view::{Strategy, View};
use sunroom::shading::{Bsdf, Diffuse};

use crate::support::{SceneBuilder, camera, view};

fn diffuse(reflectance: f32) -> Bsdf {
    Bsdf::Diffuse(Diffuse {
        reflectance: Rgb::splat(reflectance),
    })
}

/// A view for its settings; the camera does not matter.
fn settings(strategy: Strategy) -> View {
    View {
        seed: 3,
        ..view(camera(Vec3::ONE, Vec3::ZERO, 90.0), 1, u32::MAX, strategy)
    }
}

fn gathering<'a>(scene: &'a RenderScene, view: &'a View) -> Gathering<'a> {
    Gathering {
        scene,
        view,
        light: ReceivedLight::All,
    }
}

/// A square around `centre` that faces `normal`, with `texels` on each side; the lower left corner lies `offset` texels
/// from that of the lightmap.
fn patch(centre: Vec3, normal: Vec3, half_size: f32, texels: f32, offset: Vec2) -> BakeSurface {
    let (s, t) = normal.any_orthonormal_pair();
    let corners = [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)];
    BakeSurface {
        positions: corners.map(|(x, y)| centre + half_size * (x * s + y * t)).to_vec(),
        coordinates: corners
            .map(|(x, y)| offset + 0.5 * texels * (Vec2::new(x, y) + 1.0))
            .to_vec(),
        triangles: vec![[0, 1, 2], [0, 2, 3]],
        ..BakeSurface::default()
    }
}

fn covered(surfaces: &[BakeSurface], size: UVec2, pages: u32) -> Texels {
    covered_texels(surfaces, size, pages, &AtomicBool::new(false))
}

/// A single texel.
fn point(at: Vec3, normal: Vec3) -> Texels {
    let texels = covered(&[patch(at, normal, 1e-3, 0.01, Vec2::splat(2.5))], UVec2::splat(5), 1);
    assert_eq!(texels.texels.len(), 1, "{texels:?}");
    texels
}

fn gather(gathering: &Gathering, texels: &Texels, samples: u32) -> Lightmaps {
    let mut light = Lightmaps::new(texels.texels.len());
    assert!(light.add(gathering, texels, samples, &AtomicBool::new(false)));
    assert_eq!(light.invalid, 0);
    light
}

/// The mean irradiance of all texels and its standard error.
fn mean(light: &Lightmaps) -> (f32, f32) {
    let (samples, texels) = (f64::from(light.samples()), light.texel_count() as f64);
    let of = |texel: usize| f64::from(luminance(light.light(texel)));
    let sum: f64 = (0..light.texel_count()).map(of).sum();
    let sums = (0..light.texel_count()).map(|texel| (texel, light.sum(texel)));
    let variances =
        sums.map(|(texel, sum)| (sum.luminance_squared / samples - of(texel).powi(2)).max(0.0) / (samples - 1.0));
    ((sum / texels) as f32, (variances.sum::<f64>().sqrt() / texels) as f32)
}

fn rectangle(half_size: Vec2, rotation: Quat, at: Vec3) -> Affine3A {
    Affine3A::from_scale_rotation_translation(half_size.extend(1.0), rotation, at)
}

const DOWN: f32 = PI / 2.0;
const UP: f32 = -PI / 2.0;

/// A lamp of 0.6 x 1 at height 0.8, of radiance 2.
fn add_lamp(scene: &mut SceneBuilder) {
    let place = rectangle(Vec2::new(0.3, 0.5), Quat::from_rotation_x(DOWN), Vec3::Y * 0.8);
    scene.add(Primitive::Rectangle, place, diffuse(0.0), Some(Rgb::splat(2.0)));
}

/// A lamp above a floor with a wall beside it.
fn corner() -> RenderScene {
    corner_lit_by([true, true])
}

/// The same with the lamp, the bulb, or both.
fn corner_lit_by([lamp, bulb]: [bool; 2]) -> RenderScene {
    let mut scene = SceneBuilder::default();
    if lamp {
        add_lamp(&mut scene);
    }
    let floor = rectangle(Vec2::splat(2.0), Quat::from_rotation_x(UP), Vec3::ZERO);
    scene.add(Primitive::Rectangle, floor, diffuse(0.6), None);
    let wall = rectangle(Vec2::splat(2.0), Quat::from_rotation_y(PI / 2.0), Vec3::X * -0.7);
    scene.add(Primitive::Rectangle, wall, diffuse(0.8), None);
    if bulb {
        scene.light(LightSource::Point {
            position: Vec3::new(0.5, 0.5, 0.5),
            intensity: Rgb::splat(0.3),
        });
    }
    scene.build()
}
