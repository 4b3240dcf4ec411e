//! Shares keep their word: without the thing that they name their light is missing, and their errors have the size of
//! their deviations.

use crate::breakdown::{broken_down, diffuse, everything, two_bulbs};
use crate::support::{SceneBuilder, camera, view};
use glam::{Affine3A, Quat, UVec2, Vec3};
use sunroom::accel::Primitive;
use sunroom::color::Rgb;
use sunroom::light::{LightId, LightSource};
use sunroom::medium::{MediumId, MediumSource, Phase, Volume};
use sunroom::render::breakdown::{Area, Breakdown, Kind, Progress, Route, Source, Way, destinations};
use sunroom::render::scene::RenderScene;
use sunroom::render::view::{Strategy, View};
use sunroom::shading::{DielectricModel, ThinDielectric};

const UNBOUNDED: u32 = u32::MAX;

/// A scene with a thing or without it, and the routes of light that are those of the thing.
type Scene = (&'static str, fn(bool) -> (RenderScene, View), fn(&Route) -> bool);

fn bulb(scene: &mut SceneBuilder, x: f32) {
    scene.light(LightSource::Point {
        position: Vec3::new(x, 0.3, 2.0),
        intensity: Rgb::new(3.0, 2.0, 1.0),
    });
}

fn floor(scene: &mut SceneBuilder) {
    scene.add(
        Primitive::Rectangle,
        Affine3A::from_scale(Vec3::splat(4.0)),
        diffuse(0.6),
        None,
    );
}

/// A view of the middle of the floor.
fn look(max_depth: u32) -> View {
    view(
        camera(Vec3::new(0.0, -1.0, 0.6), Vec3::ZERO, 12.0),
        2,
        max_depth,
        Strategy::Mis,
    )
}

/// Two bulbs between two boards.
fn boards(has_bulb: bool, has_board: bool, max_depth: u32) -> (RenderScene, View) {
    let mut scene = SceneBuilder::default();
    floor(&mut scene);
    for (is_there, x) in [(true, -1.5_f32), (has_board, 1.5)] {
        let stand = Affine3A::from_scale_rotation_translation(
            Vec3::splat(0.7),
            Quat::from_rotation_y(-x.signum() * std::f32::consts::FRAC_PI_2),
            Vec3::new(x, 0.0, 0.7),
        );
        if is_there {
            scene.add(Primitive::Rectangle, stand, diffuse(0.8), None);
        }
    }
    bulb(&mut scene, -0.2);
    if has_bulb {
        bulb(&mut scene, 0.2);
    }
    (scene.build(), look(max_depth))
}

/// A bulb under a sky.
fn outdoors(has_sky: bool) -> (RenderScene, View) {
    let mut scene = SceneBuilder::default();
    floor(&mut scene);
    scene.add(
        Primitive::Sphere,
        Affine3A::from_scale_rotation_translation(Vec3::splat(0.4), Quat::IDENTITY, Vec3::new(0.6, 0.0, 0.4)),
        diffuse(0.5),
        None,
    );
    bulb(&mut scene, 0.0);
    if has_sky {
        scene.light(LightSource::Constant {
            radiance: Rgb::new(0.2, 0.3, 0.5),
        });
    }
    (scene.build(), look(UNBOUNDED))
}

/// A pane over the floor, which without its light is a black board in the same place.
fn under_a_pane(has_pane: bool) -> (RenderScene, View) {
    let mut scene = SceneBuilder::default();
    floor(&mut scene);
    let above = Affine3A::from_scale_rotation_translation(Vec3::splat(1.5), Quat::IDENTITY, Vec3::Z);
    let pane = ThinDielectric {
        eta: 1.5,
        model: DielectricModel::Exact,
        specular_reflectance: Rgb::ZERO,
        specular_transmittance: Rgb::ONE,
    };
    let pane = match has_pane {
        true => sunroom::shading::Bsdf::ThinDielectric(pane),
        false => diffuse(0.0),
    };
    scene.add(Primitive::Rectangle, above, pane, None);
    scene.light(LightSource::Constant { radiance: Rgb::ONE });
    (scene.build(), look(UNBOUNDED))
}

/// A bulb in haze, which without its light absorbs as much, but scatters nothing.
fn in_haze(scatters: bool) -> (RenderScene, View) {
    let haze = MediumSource {
        sigma_t: Volume::Constant(Rgb::splat(0.3)),
        scale: 1.0,
        albedo: Volume::Constant(Rgb::splat(if scatters { 0.8 } else { 0.0 })),
        emission: Volume::ZERO,
        phase: Phase::Isotropic,
    };
    let mut scene = SceneBuilder::with_media(vec![haze]);
    floor(&mut scene);
    bulb(&mut scene, 0.0);
    let mut look = look(UNBOUNDED);
    look.medium = Some(MediumId(0));
    look.integrator.settings_mut().media = true;
    (scene.build(), look)
}

/// A shape's emission, a point light, the last thing before the seen surface, a sky, a pane and a medium. The board is
/// seen with paths that meet nothing but it between floor and bulb: longer ones that it is part of are missing as well.
const SCENES: [Scene; 6] = [
    ("lamp", everything, |route| route.source == Source::Light(LightId(0))),
    (
        "bulb",
        |has| boards(has, true, UNBOUNDED),
        |route| route.source == Source::Light(LightId(1)),
    ),
    (
        "board",
        |has| boards(true, has, 3),
        |route| matches!(route.way, Way::Surface { instance: 2, .. }),
    ),
    ("sky", outdoors, |route| route.source == Source::Light(LightId(1))),
    ("pane", under_a_pane, |route| {
        route.way == Way::Straight { through: Some(1) }
    }),
    ("haze", in_haze, |route| route.kind == Kind::Medium),
];

fn whole(view: &View) -> Area {
    Area {
        x: 0,
        y: 0,
        width: view.width,
        height: view.height,
    }
}

#[test]
fn without_the_thing_its_share_is_missing() {
    for (name, scene, is_of_thing) in SCENES {
        let broken = |has: bool, seed: u32| {
            let (scene, look) = scene(has);
            let look = View { seed, ..look };
            broken_down(&scene, &look, whole(&look), 1 << 12)
        };
        let (before, after) = (broken(true, 1), broken(false, 2).value());
        let part = |of_thing: bool| {
            let mut found = before.portions(|route| (is_of_thing(route) == of_thing).then_some(()));
            found.pop().unwrap_or_else(|| panic!("{name}: no light"))
        };
        let (own, rest, value) = (part(true), part(false), before.value());
        let sum = own.luminance + rest.luminance;
        assert!(
            (sum - value.luminance).abs() < 1e-5 * value.luminance,
            "{name}: {own:?} {rest:?} {value:?}"
        );
        assert!((own.share + rest.share - 1.0).abs() < 1e-5, "{name}: {own:?} {rest:?}");
        // The light of the thing is missing in both, so that its noise hides nothing.
        let error = rest.error.hypot(after.error) + 1e-5 * value.luminance;
        assert!(
            (rest.luminance - after.luminance).abs() < 3.0 * error,
            "{name}: {rest:?} {after:?}"
        );
        assert!(own.luminance > 10.0 * error, "{name}: {own:?} {error}");
    }
}

/// The mean of the squares of deviations from the mean, each in units of the error that was told for it.
fn variance_of_scores(values: &[[f64; 2]]) -> f64 {
    let count = values.len() as f64;
    let mean = values.iter().map(|[value, _]| value).sum::<f64>() / count;
    let squares = values.iter().map(|[value, error]| ((value - mean) / error).powi(2));
    squares.sum::<f64>() / (count - 1.0)
}

const SEEDS: u32 = 200;

/// Enough for sums of rare bright samples to be nearly normal.
const SAMPLES: u32 = 256;

/// Errors of 32 batches have 31 degrees of freedom, with which the variance of scores is 31 / 29. That of 200 seeds
/// deviates by 0.1 from it, and by four times that once in ten thousand cases.
#[track_caller]
fn assert_calibrated(what: &str, values: &[[f64; 2]]) {
    let variance = variance_of_scores(values);
    assert!(
        (variance - 31.0 / 29.0).abs() < 0.4,
        "{what}: the variance of scores is {variance}"
    );
}

#[test]
fn errors_of_shares_have_the_size_of_their_deviations() {
    // The light that haze scatters near a point light has no finite variance, so that no error can be calibrated.
    let calibrated = SCENES.into_iter().filter(|(name, ..)| *name != "haze");
    for (name, scene, is_of_thing) in calibrated {
        let (scene, look) = scene(true);
        let pixel = Area::pixel(UVec2::ONE);
        let found: Vec<Breakdown> = (0..SEEDS)
            .map(|seed| broken_down(&scene, &View { seed, ..look.clone() }, pixel, SAMPLES))
            .collect();
        let own = |found: &Breakdown| {
            let mut own = found.portions(|route| is_of_thing(route).then_some(()));
            own.pop().unwrap_or_else(|| panic!("{name}: no light"))
        };
        let shares: Vec<[f64; 2]> = found
            .iter()
            .map(own)
            .map(|own| [own.share, own.share_error].map(f64::from))
            .collect();
        assert_calibrated(&format!("{name}, share"), &shares);
        let values: Vec<[f64; 2]> = found
            .iter()
            .map(|found| found.value())
            .map(|value| [value.luminance, value.error].map(f64::from))
            .collect();
        assert_calibrated(&format!("{name}, value"), &values);
    }
}

#[test]
fn errors_of_destinations_have_the_size_of_their_deviations() {
    let mut scene = SceneBuilder::default();
    floor(&mut scene);
    let ball = Affine3A::from_scale_rotation_translation(Vec3::splat(0.5), Quat::IDENTITY, Vec3::new(0.5, 0.0, 0.5));
    scene.add(Primitive::Sphere, ball, diffuse(0.7), None);
    bulb(&mut scene, 0.0);
    let (scene, (_, look)) = (scene.build(), two_bulbs());
    let mut shares = [const { Vec::new() }; 2];
    let mut received = Vec::new();
    for seed in 0..SEEDS {
        let found = destinations(&scene, &View { seed, ..look.clone() }, 2048, &Progress::default());
        let found = found.expect("it is not cancelled");
        for thing in found.by(|instance| instance) {
            shares[thing.key as usize].push([thing.share, thing.share_error].map(f64::from));
            if thing.key == 1 {
                received.push([thing.received, thing.received_error].map(f64::from));
            }
        }
    }
    assert_calibrated("floor, share", &shares[0]);
    assert_calibrated("ball, share", &shares[1]);
    assert_calibrated("ball, received", &received);
}
