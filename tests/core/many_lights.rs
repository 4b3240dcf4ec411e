//! Pictures with many lights of all kinds: the choice among them does not shift the picture. Light adds up, so the
//! picture with all of them is the sum of the pictures with one each, where there is nothing to choose.

use crate::support::{SceneBuilder, camera, render, triangle_mesh, view};
use glam::{Affine3A, Quat, Vec3};
use sunroom::accel::Primitive;
use sunroom::color::{Rgb, luminance};
use sunroom::light::LightSource;
use sunroom::render::film::Film;
use sunroom::render::scene::RenderScene;
use sunroom::render::view::{Strategy, View};
use sunroom::sampling::{Sampler, SequenceKind};
use sunroom::shading::{Bsdf, Diffuse};

fn grey() -> Bsdf {
    let reflectance = Rgb::splat(0.6);
    Bsdf::Diffuse(Diffuse { reflectance })
}

fn random(index: u32, stream: u32) -> Vec3 {
    let sampler = Sampler::new(SequenceKind::Independent, glam::UVec2::new(index, stream), 0, 4);
    2.0 * Vec3::new(sampler.at_1d(0), sampler.at_1d(1), sampler.at_1d(2)) - 1.0
}

const LIGHTS: u32 = 24;

/// A floor and a wall under lights of every kind, of which `lit` says which shine. The others stay in place, dark.
fn scene(lit: impl Fn(u32) -> bool) -> RenderScene {
    let mut scene = SceneBuilder::default();
    let floor = Affine3A::from_rotation_x(-std::f32::consts::FRAC_PI_2) * Affine3A::from_scale(Vec3::splat(2.0));
    scene.add(Primitive::Rectangle, floor, grey(), None);
    let wall = Affine3A::from_translation(Vec3::new(0.0, 1.0, -1.5)) * Affine3A::from_scale(Vec3::splat(1.5));
    scene.add(Primitive::Rectangle, wall, grey(), None);
    for index in 0..LIGHTS {
        let shine = |strength: f32| if lit(index) { Rgb::splat(strength) } else { Rgb::ZERO };
        let center = Vec3::new(0.0, 1.1, 0.0) + random(index, 0);
        let placed = |size: f32| {
            let turn = Quat::from_rotation_arc(Vec3::Z, random(index, 1).normalize());
            Affine3A::from_scale_rotation_translation(Vec3::splat(size), turn, center)
        };
        match index {
            0 => {
                scene.light(LightSource::Constant { radiance: shine(0.05) });
            }
            1 => {
                let direction = Vec3::new(0.3, -0.9, -0.4).normalize();
                let irradiance = shine(0.2);
                scene.light(LightSource::Directional { direction, irradiance });
            }
            _ if index % 4 == 0 => {
                scene.add(Primitive::Sphere, placed(0.08), grey(), Some(shine(2.0)));
            }
            _ if index % 4 == 1 => {
                scene.add(Primitive::Rectangle, placed(0.15), grey(), Some(shine(2.0)));
            }
            _ if index % 4 == 2 => {
                let triangles =
                    (0..6).map(|part| [2, 3, 4].map(|corner| center + 0.2 * random(10 * index + part, corner)));
                scene.add(triangle_mesh(triangles), Affine3A::IDENTITY, grey(), Some(shine(3.0)));
            }
            _ => {
                scene.light(LightSource::Point {
                    position: center,
                    intensity: shine(0.05),
                });
            }
        }
    }
    scene.build()
}

fn overview(strategy: Strategy) -> View {
    view(
        camera(Vec3::new(0.0, 1.6, 4.5), Vec3::new(0.0, 0.7, 0.0), 40.0),
        24,
        3,
        strategy,
    )
}

/// Per block of 4 x 4 pixels, the mean and its variance.
fn blocks(film: &Film) -> Vec<(f64, f64)> {
    let radiance = film.radiance();
    let (width, height) = (film.width(), film.height());
    let corners = (0..height / 4).flat_map(|y| (0..width / 4).map(move |x| (4 * x, 4 * y)));
    corners
        .map(|(left, top)| {
            let (mut mean, mut variance) = (0.0, 0.0);
            for (x, y) in (0..4).flat_map(|y| (0..4).map(move |x| (left + x, top + y))) {
                mean += f64::from(luminance(radiance[(y * width + x) as usize])) / 16.0;
                variance += f64::from(film.standard_error(x, y).unwrap_or(0.0) / 16.0).powi(2);
            }
            (mean, variance)
        })
        .collect()
}

/// Fails if the blocks differ by more than chance explains: none by five standard errors, and their squares not by much
/// in the mean.
fn assert_same(what: &str, ours: &[(f64, f64)], theirs: &[(f64, f64)]) {
    let z: Vec<f64> = ours
        .iter()
        .zip(theirs)
        .map(|(a, b)| (a.0 - b.0) / (a.1 + b.1 + 1e-12).sqrt())
        .collect();
    let worst = z.iter().fold(0.0f64, |worst, z| worst.max(z.abs()));
    let mean_square = z.iter().map(|z| z * z).sum::<f64>() / z.len() as f64;
    // The mean of n squares of unit normals has a standard deviation of sqrt(2 / n); fireflies make the tails somewhat
    // heavier.
    let bound = 1.0 + 5.0 * (2.0 / z.len() as f64).sqrt();
    assert!(
        worst < 5.0 && mean_square < bound,
        "{what}: worst {worst}, mean square {mean_square} of {bound}"
    );
}

#[test]
fn all_lights_together_are_the_sum_of_each_alone() {
    let together = blocks(&render(&scene(|_| true), &overview(Strategy::Mis), 600));
    let mut sum = vec![(0.0, 0.0); together.len()];
    for index in 0..LIGHTS {
        let alone = View {
            seed: 100 + index,
            ..overview(Strategy::Mis)
        };
        let film = render(&scene(|other| other == index), &alone, 100);
        for (sum, (mean, variance)) in sum.iter_mut().zip(blocks(&film)) {
            *sum = (sum.0 + mean, sum.1 + variance);
        }
    }
    assert_same("together and each alone", &together, &sum);
}

/// Of all lights but those that only sampling of lights can find.
#[test]
fn the_strategies_agree_on_many_lights() {
    let scene = scene(|index| index != 1 && (index == 0 || index % 4 != 3));
    let of = |strategy, seed, samples| {
        blocks(&render(
            &scene,
            &View {
                seed,
                ..overview(strategy)
            },
            samples,
        ))
    };
    let bsdf = of(Strategy::Bsdf, 1, 1200);
    assert_same("lights and bsdf", &of(Strategy::Light, 2, 400), &bsdf);
    assert_same("both and bsdf", &of(Strategy::Mis, 3, 400), &bsdf);
}
