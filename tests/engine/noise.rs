//! That the noise a picture is said to have is the true one where it cannot be foretold from the samples.

use bevy::math::Affine3A;
use bevy::prelude::*;
use sunroom::color::luminance;
use sunroom::engine::{RenderControl, RenderFilm, RenderStatus, StopReason};
use sunroom::render::film::Film;
use sunroom::scene::{
    DocumentOrder, Film as FilmSettings, IntegratorSettings, ReconstructionFilter, SamplerSettings, Sensor, Shape,
    ShapeKind, ToWorld,
};

use crate::{ball, finish};

const SIZE: [u32; 2] = [72, 56];
/// Half of the edge of the square in pixels.
const HALF: f32 = 20.0;

/// A black square before an even sky. Its edges alone are noisy, and they are 17/32 of a pixel from a border of pixels:
/// of 16 well spread samples of a pixel one may lie on either side, and of 32 always as many are on each.
fn square(seed: u32, control: impl FnOnce(&mut RenderControl)) -> (Film, RenderStatus) {
    // The ball is behind the camera.
    let mut app = ball(Vec3::Z * -40.0, SIZE[0], SIZE[1]);
    let world = app.world_mut();
    let pixel = 2.0 * (0.5 * Sensor::default().fov.to_radians()).tan() / SIZE[0] as f32;
    let place = Vec3::new(17.0 / 32.0 * pixel, 17.0 / 32.0 * pixel, 1.0);
    let pose = Affine3A::from_scale_rotation_translation(Vec3::splat(HALF * pixel), Quat::IDENTITY, place);
    let shape = Shape {
        kind: ShapeKind::Rectangle,
        ..Shape::default()
    };
    world.spawn((DocumentOrder(2), shape, ToWorld(pose)));
    let mut films = world.query::<&mut FilmSettings>();
    films
        .iter_mut(world)
        .for_each(|mut film| film.filter = ReconstructionFilter::Box);
    world.resource_mut::<IntegratorSettings>().max_depth = Some(1);
    world.resource_mut::<SamplerSettings>().seed = seed;
    control(&mut world.resource_mut::<RenderControl>());
    let status = finish(&mut app);
    (app.world().resource::<RenderFilm>().film.clone(), status)
}

/// The true noise of pictures with so many samples, and what their samples foretell of it.
fn noise(samples: u32) -> [f64; 2] {
    let pictures: Vec<(Film, RenderStatus)> = (100..106)
        .map(|seed| square(seed, |control| control.target_samples = Some(samples)))
        .collect();
    let count = pictures.len() as f64;
    let foretold = pictures
        .iter()
        .map(|(_, status)| f64::from(status.noise.expect("samples")));
    let foretold = foretold.sum::<f64>() / count;
    let light: Vec<Vec<f64>> = pictures
        .iter()
        .map(|(film, _)| film.radiance().iter().map(|&rgb| f64::from(luminance(rgb))).collect())
        .collect();
    let pixels = light[0].len();
    let mean = |pixel: usize| light.iter().map(|light| light[pixel]).sum::<f64>() / count;
    let dark = 0.1 * (0..pixels).map(mean).sum::<f64>() / pixels as f64;
    let squared = |pixel: usize| {
        let mean = mean(pixel);
        let squares = light.iter().map(|light| (light[pixel] - mean).powi(2));
        squares.sum::<f64>() / (count - 1.0) / mean.max(dark).powi(2)
    };
    [((0..pixels).map(squared).sum::<f64>() / pixels as f64).sqrt(), foretold]
}

#[test]
fn noise_is_known_where_it_falls_in_jumps() {
    let until = |limit| {
        let (_, status) = square(1, |control| {
            control.target_samples = Some(1 << 20);
            control.noise_target = Some(limit);
        });
        assert_eq!(status.stopped_by, Some(StopReason::Noise));
        (status.samples, f64::from(status.noise.expect("samples")))
    };
    // Before the jump replicas and samples say about the same.
    let ([truth, _], (samples, said)) = (noise(16), until(0.1));
    assert!(
        samples == 16 && (said / truth - 1.0).abs() < 0.2,
        "{samples} {said} {truth}"
    );
    // The next doubling takes nearly all of it, and the samples do not know.
    let [truth, foretold] = noise(32);
    assert!(truth < 0.002 && foretold > 0.01, "{truth} {foretold}");
    // On the way there is less than they foretell.
    let limit = 0.008_f64;
    let (samples, _) = until(limit as f32);
    let [truth, foretold] = noise(samples);
    assert!(samples <= 32, "{samples}");
    assert!(truth < limit && foretold > 1.2 * limit, "{samples} {truth} {foretold}");
}
