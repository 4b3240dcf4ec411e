//! The light of pixels by its routes: known scenes, sums, errors, and the same result on any number of threads.

use std::f32::consts::PI;

use crate::support::{SceneBuilder, camera, render, view};
use glam::{Affine3A, Quat, UVec2, Vec3};
use sunroom::accel::Primitive;
use sunroom::color::{Rgb, luminance};
use sunroom::light::{LightId, LightSource};
use sunroom::material::{Material, MaterialId};
use sunroom::render::breakdown::{
    Area, Batches, Breakdown, Kind, Portion, Progress, Route, Source, Trouble, Way, break_down, contributions,
    followed, of_batch,
};
use sunroom::render::filter::{FilterKernel, PixelFilter};
use sunroom::render::scene::RenderScene;
use sunroom::render::view::{Strategy, View};
use sunroom::sampling::SequenceKind;
use sunroom::shading::{Bsdf, Conductor, ConductorSpecular, Dielectric, DielectricModel, Diffuse, ThinDielectric};
use sunroom::texture::Parameter;

const SIZE: u32 = 8;
const UNBOUNDED: u32 = u32::MAX;

pub fn diffuse(reflectance: f32) -> Bsdf {
    Bsdf::Diffuse(Diffuse {
        reflectance: Rgb::splat(reflectance),
    })
}

fn glass() -> Bsdf {
    Bsdf::Dielectric(Dielectric {
        eta: 1.5,
        model: DielectricModel::Exact,
        specular_reflectance: Rgb::ONE,
        specular_transmittance: Rgb::ONE,
    })
}

pub fn broken_down(scene: &RenderScene, view: &View, area: Area, samples: u32) -> Breakdown {
    let batches = Batches::of(samples);
    break_down(scene, view, area, batches, &Progress::default()).expect("it is not cancelled")
}

fn of<K: PartialEq + std::fmt::Debug>(portions: &[Portion<K>], key: &K) -> Portion<()> {
    let found = portions.iter().find(|portion| portion.key == *key);
    let found = found.unwrap_or_else(|| panic!("no {key:?} in {portions:?}"));
    Portion {
        key: (),
        light: found.light,
        luminance: found.luminance,
        error: found.error,
        share: found.share,
        share_error: found.share_error,
        noise: found.noise,
    }
}

/// Errors have 31 degrees of freedom, with which 4.5 of them are exceeded once in ten thousand cases.
#[track_caller]
fn assert_share<K: PartialEq + std::fmt::Debug>(portions: &[Portion<K>], key: &K, expected: f32) {
    let found = of(portions, key);
    let most = 4.5 * found.share_error + 1e-5;
    assert!(
        (found.share - expected).abs() < most,
        "{key:?}: {found:?}, expected {expected}"
    );
}

/// A floor under two bare bulbs, seen through a narrow lens.
pub fn two_bulbs() -> (RenderScene, View) {
    let mut scene = SceneBuilder::default();
    let scale = Affine3A::from_scale(Vec3::splat(3.0));
    scene.add(Primitive::Rectangle, scale, diffuse(0.6), None);
    for (distance, intensity) in [(1.0, 1.0), (2.0, 1.0)] {
        scene.light(LightSource::Point {
            position: Vec3::Z * distance,
            intensity: Rgb::splat(intensity),
        });
    }
    let look = view(
        camera(Vec3::new(0.0, -1.0, 2.5), Vec3::ZERO, 0.02),
        1,
        UNBOUNDED,
        Strategy::Mis,
    );
    (scene.build(), look)
}

#[test]
fn bulbs_share_as_the_inverse_square_says() {
    let (scene, look) = two_bulbs();
    let found = broken_down(&scene, &look, Area::pixel(UVec2::ZERO), 1024);
    let value = found.value();
    let expected = 0.6 / PI * 1.25;
    assert!((value.luminance - expected).abs() < 1e-3 * expected + 3.0 * value.error);
    let lamps = found.portions(|route| Some(route.source));
    assert_share(&lamps, &Source::Light(LightId(0)), 0.8);
    assert_share(&lamps, &Source::Light(LightId(1)), 0.2);
    assert_share(&found.portions(|route| Some(route.kind)), &Kind::Direct, 1.0);
    assert_share(&found.portions(|route| Some(route.bounces)), &1, 1.0);
    let straight = Way::Straight { through: None };
    assert_share(&found.portions(|route| Some(route.way)), &straight, 1.0);
}

/// In a closed furnace of reflectance r light after n bounces has the share (1 - r) r^n.
#[test]
fn bounces_in_a_furnace_are_a_geometric_series() {
    let albedo: f32 = 0.6;
    let mut scene = SceneBuilder::default();
    scene
        .add(Primitive::Sphere, Affine3A::IDENTITY, diffuse(albedo), Some(Rgb::ONE))
        .flip_normals = true;
    let scene = scene.build();
    for strategy in [Strategy::Mis, Strategy::Bsdf, Strategy::Light] {
        let look = view(camera(Vec3::new(0.2, 0.1, -0.3), Vec3::X, 90.0), 4, UNBOUNDED, strategy);
        let area = Area {
            x: 1,
            y: 0,
            width: 3,
            height: 4,
        };
        let found = broken_down(&scene, &look, area, 256);
        let bounces = found.portions(|route| Some(route.bounces));
        for count in 0..8 {
            assert_share(&bounces, &count, (1.0 - albedo) * albedo.powi(count as i32));
        }
        let kinds = found.portions(|route| Some(route.kind));
        assert_share(&kinds, &Kind::Seen, 1.0 - albedo);
        assert_share(&kinds, &Kind::Direct, (1.0 - albedo) * albedo);
        assert_share(&kinds, &Kind::Diffuse, albedo * albedo);
        let wall = Way::Surface {
            instance: 0,
            is_through: false,
        };
        let ways = found.portions(|route| Some(route.way));
        assert_share(&ways, &wall, albedo * albedo);
        assert_share(&ways, &Way::Straight { through: None }, 1.0 - albedo * albedo);
    }
}

/// A floor, a ball of glass, a mirror, a veil, a pane over it, a lamp, a bulb and a sky.
pub fn everything(has_lamp: bool) -> (RenderScene, View) {
    let mut scene = SceneBuilder::default();
    let placed =
        |scale: f32, rotation, place| Affine3A::from_scale_rotation_translation(Vec3::splat(scale), rotation, place);
    let square = Primitive::Rectangle;
    scene.add(
        square.clone(),
        placed(3.0, Quat::IDENTITY, Vec3::NEG_Z),
        diffuse(0.8),
        None,
    );
    scene.add(
        Primitive::Sphere,
        placed(0.6, Quat::IDENTITY, Vec3::X * 0.7),
        glass(),
        None,
    );
    let veil = Material::Mask {
        nested: MaterialId(0),
        opacity: Parameter::Constant(0.5),
    };
    scene.add(Primitive::Disk, placed(0.6, Quat::IDENTITY, Vec3::X * -0.7), veil, None);
    let side = Quat::from_rotation_y(1.2);
    let mirror = Bsdf::Conductor(Conductor {
        specular: ConductorSpecular {
            eta: Rgb::ZERO,
            k: Rgb::ONE,
            specular_reflectance: Rgb::ONE,
        },
    });
    scene.add(
        square.clone(),
        placed(0.8, side, Vec3::new(-2.0, 0.0, 0.0)),
        mirror,
        None,
    );
    let down = Quat::from_rotation_x(2.5);
    let radiance = if has_lamp { Rgb::new(7.0, 6.0, 5.0) } else { Rgb::ZERO };
    scene.add(
        square,
        placed(0.5, down, Vec3::new(0.0, 1.5, 1.0)),
        diffuse(0.1),
        Some(radiance),
    );
    scene.light(LightSource::Point {
        position: Vec3::new(1.0, -1.0, 2.0),
        intensity: Rgb::new(1.0, 2.0, 3.0),
    });
    scene.light(LightSource::Constant {
        radiance: Rgb::splat(0.3),
    });
    let mut look = view(
        camera(Vec3::new(0.0, -1.0, 5.0), Vec3::ZERO, 70.0),
        SIZE,
        6,
        Strategy::Mis,
    );
    look.filter = PixelFilter::tabulated(FilterKernel::CATMULL_ROM);
    look.sequence = SequenceKind::Sobol;
    (scene.build(), look)
}

const WHOLE: Area = Area {
    x: 0,
    y: 0,
    width: SIZE,
    height: SIZE,
};

fn sum<K>(portions: &[Portion<K>]) -> [f64; 4] {
    portions
        .iter()
        .fold([0.0; 4], |[light, luminance, share, noise], portion| {
            [
                light + f64::from(portion.light.y),
                luminance + f64::from(portion.luminance),
                share + f64::from(portion.share),
                noise + f64::from(portion.noise),
            ]
        })
}

#[test]
fn portions_of_each_grouping_sum_up_to_the_very_samples_of_the_picture() {
    let (scene, look) = everything(true);
    let batches = Batches { count: 2, samples: 16 };
    let films = [0, 1].map(|batch| render(&scene, &of_batch(&followed(&look), batch), batches.samples));
    for pixel in (0..SIZE * SIZE).map(|place| UVec2::new(place % SIZE, place / SIZE)) {
        let found = break_down(&scene, &look, Area::pixel(pixel), batches, &Progress::default());
        let found = found.expect("it is not cancelled");
        let value = found.value();
        let shown = films
            .each_ref()
            .map(|film| film.radiance()[(pixel.y * SIZE + pixel.x) as usize]);
        let shown = 0.5 * (shown[0] + shown[1]);
        // Both are sums of some hundred contributions in single precision.
        let scale = shown.abs().max_element().max(1.0);
        assert!(
            value.light.abs_diff_eq(shown, 1e-5 * scale),
            "{pixel}: {value:?} {shown}"
        );
        let groupings = [
            sum(&found.portions(|route| Some(route.source))),
            sum(&found.portions(|route| Some(route.way))),
            sum(&found.portions(|route| Some(route.bounces))),
            sum(&found.portions(|route| Some(route.kind))),
            sum(&found.portions(|route| Some(*route))),
        ];
        for [light, luminance, share, noise] in groupings {
            let scale = f64::from(scale);
            assert!((light - f64::from(value.light.y)).abs() < 1e-6 * scale);
            assert!((luminance - f64::from(value.luminance)).abs() < 1e-6 * scale);
            assert!((share - 1.0).abs() < 1e-5, "{share}");
            assert!((noise - 1.0).abs() < 1e-4, "{noise}");
        }
    }
}

#[test]
fn the_value_agrees_with_independent_pictures() {
    let (scene, look) = everything(true);
    let found = broken_down(&scene, &look, WHOLE, 512).value();
    let other = View {
        seed: 4711,
        ..followed(&look)
    };
    let film = render(&scene, &other, 4096);
    let mean = film.radiance().iter().map(|&rgb| luminance(rgb)).sum::<f32>() / (SIZE * SIZE) as f32;
    assert!((found.luminance - mean).abs() < 4.0 * found.error, "{found:?} {mean}");
    assert!(found.error < 0.01 * mean, "{found:?} {mean}");
}

#[test]
fn without_a_lamp_its_portion_is_missing() {
    let (scene, look) = everything(true);
    let (dark, _) = everything(false);
    let before = broken_down(&scene, &look, WHOLE, 4096);
    let after = broken_down(&dark, &View { seed: 99, ..look }, WHOLE, 4096);
    let lamps = before.portions(|route| Some(route.source));
    let lamp = of(&lamps, &Source::Light(LightId(0)));
    // The lamp is missing in both, so that its noise hides nothing.
    let others = before.portions(|route| (route.source != Source::Light(LightId(0))).then_some(()));
    let (rest, after) = (of(&others, &()), after.value());
    let error = rest.error.hypot(after.error);
    assert!(
        (rest.luminance - after.luminance).abs() < 3.0 * error,
        "{rest:?} {after:?}"
    );
    assert!(lamp.luminance > 30.0 * error, "{lamp:?} {error}");
}

#[test]
fn every_number_of_threads_gives_the_same() {
    let (scene, look) = everything(true);
    let with = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
        let pool = pool.expect("threads can be started");
        pool.install(|| broken_down(&scene, &look, WHOLE, 70))
    };
    let [one, many] = [with(1), with(5)];
    assert_eq!(one.portions(|route| Some(*route)), many.portions(|route| Some(*route)));
    assert_eq!(one.value(), many.value());
}

#[test]
fn mirrors_and_glass_have_their_kinds() {
    let (scene, look) = everything(true);
    let found = broken_down(&scene, &look, WHOLE, 128);
    let routes: Vec<Route> = found.routes().copied().collect();
    let has = |test: &dyn Fn(&Route) -> bool| routes.iter().any(test);
    let through = |instance| Way::Straight {
        through: Some(instance),
    };
    // Light comes straight through the veil, and so it does through no opaque shape.
    assert!(has(&|route| route.way == through(2) && route.kind == Kind::Direct));
    assert!(!has(&|route| [0, 1, 3, 4].map(through).contains(&route.way)));
    // The ball focuses light of the lamp onto the floor.
    let ball = |is_through| Way::Surface {
        instance: 1,
        is_through,
    };
    assert!(has(&|route| route.is_caustic
        && route.way == ball(true)
        && route.kind == Kind::Glass));
    // The floor is seen in the mirror.
    let floor = Way::Surface {
        instance: 0,
        is_through: false,
    };
    assert!(has(&|route| !route.is_caustic
        && route.way == floor
        && route.kind == Kind::Mirror));
    for route in &routes {
        assert_eq!(
            route.bounces == 0 && route.kind != Kind::Medium,
            route.kind == Kind::Seen
        );
        assert!(route.kind != Kind::Direct || route.bounces == 1);
        assert_eq!(
            matches!(route.way, Way::Straight { .. }),
            route.bounces < 2,
            "{route:?}"
        );
    }
}

#[test]
fn light_through_a_pane_names_the_pane() {
    let mut scene = SceneBuilder::default();
    let scale = Affine3A::from_scale(Vec3::splat(30.0));
    scene.add(Primitive::Rectangle, scale, diffuse(0.5), None);
    let pane = Bsdf::ThinDielectric(ThinDielectric {
        eta: 1.5,
        model: DielectricModel::Exact,
        specular_reflectance: Rgb::ZERO,
        specular_transmittance: Rgb::ONE,
    });
    let above = Affine3A::from_scale_rotation_translation(Vec3::splat(900.0), Quat::IDENTITY, Vec3::Z * 5.0);
    scene.add(Primitive::Rectangle, above, pane, None);
    scene.light(LightSource::Constant { radiance: Rgb::ONE });
    let look = view(
        camera(Vec3::new(0.0, -1.0, 2.0), Vec3::ZERO, 5.0),
        1,
        UNBOUNDED,
        Strategy::Mis,
    );
    let found = broken_down(&scene.build(), &look, Area::pixel(UVec2::ZERO), 256);
    let ways = found.portions(|route| Some(route.way));
    // The pane covers all but a few thousandths of the sky.
    let share = of(&ways, &Way::Straight { through: Some(1) }).share;
    assert!(share > 0.98, "{ways:?}");
}

#[test]
fn caustics_are_advised_against_by_light_paths() {
    let mut scene = SceneBuilder::default();
    let scale = Affine3A::from_scale(Vec3::splat(3.0));
    scene.add(Primitive::Rectangle, scale, diffuse(0.5), None);
    let ball = Affine3A::from_scale_rotation_translation(Vec3::splat(0.5), Quat::IDENTITY, Vec3::Z);
    scene.add(Primitive::Sphere, ball, glass(), None);
    let down = Quat::from_rotation_x(PI);
    let lamp = Affine3A::from_scale_rotation_translation(Vec3::splat(0.2), down, Vec3::Z * 3.0);
    scene.add(Primitive::Rectangle, lamp, diffuse(0.0), Some(Rgb::splat(20.0)));
    let look = view(
        camera(Vec3::new(0.0, -2.0, 0.6), Vec3::ZERO, 1.0),
        1,
        UNBOUNDED,
        Strategy::Mis,
    );
    let advice = broken_down(&scene.build(), &look, Area::pixel(UVec2::ZERO), 2048).advice();
    assert_eq!(
        advice.first().map(|advice| advice.trouble),
        Some(Trouble::Caustic),
        "{advice:?}"
    );
}

/// Three samples of a batch, whose sums single precision would round.
#[test]
fn samples_that_are_alike_have_no_noise() {
    let mut scene = SceneBuilder::default();
    scene.light(LightSource::Constant {
        radiance: Rgb::new(0.1, 0.7, 0.3),
    });
    let look = view(camera(Vec3::ZERO, Vec3::X, 50.0), 4, UNBOUNDED, Strategy::Mis);
    let found = broken_down(&scene.build(), &look, Area::pixel(UVec2::ONE), 96);
    let value = found.value();
    assert!(value.luminance > 0.1 && value.noise == 0.0, "{value:?}");
    assert!(found.advice().is_empty(), "{:?}", found.advice());
}

#[test]
fn areas_outside_of_the_picture_have_no_light() {
    let (scene, look) = two_bulbs();
    let outside = [
        Area::pixel(UVec2::X),
        Area {
            width: 0,
            ..Area::pixel(UVec2::ZERO)
        },
        Area {
            width: u32::MAX,
            ..Area::pixel(UVec2::ONE)
        },
    ];
    for area in outside {
        assert!(break_down(&scene, &look, area, Batches::of(8), &Progress::default()).is_none());
    }
    let cancelled = Progress::default();
    cancelled.cancel();
    let pixel = Area::pixel(UVec2::ZERO);
    assert!(break_down(&scene, &look, pixel, Batches::of(8), &cancelled).is_none());
    assert_eq!(Batches::of(0), Batches { count: 8, samples: 2 });
    assert_eq!(Batches::of(1000).total(), 1024);
}

#[test]
fn examples_of_a_group_are_paths_with_its_light() {
    let (scene, look) = everything(true);
    let found = broken_down(&scene, &look, WHOLE, 64);
    let lamp = Source::Light(LightId(0));
    let is_of_group = |route: &Route| route.source == lamp && route.kind == Kind::Glass;
    let paths = found.example_paths(&scene, &look, is_of_group, 5);
    assert_eq!(paths.len(), 5);
    for path in &paths {
        let all = contributions(&scene, path);
        assert!(all.iter().any(|found| is_of_group(&found.route)), "{path:?}");
    }
    // They are spread over the picture, and do not all come from its first pixels.
    let most = found.example_paths(&scene, &look, is_of_group, 64);
    let rows = most.iter().filter(|path| path.camera_ray.dir.y < 0.0).count();
    assert!(rows > 0 && rows < most.len(), "{rows} of {}", most.len());
    let none = found.example_paths(&scene, &look, |route| route.bounces > 100, 5);
    assert!(none.is_empty());
    let pixels = WHOLE.spread(16);
    assert!(pixels.len() > 12, "{pixels:?}");
    // Every quarter has some.
    for corner in [[0, 0], [4, 0], [0, 4], [4, 4]].map(UVec2::from_array) {
        let is_there = |pixel: &&UVec2| pixel.cmpge(corner).all() && pixel.cmplt(corner + 4).all();
        assert!(pixels.iter().filter(is_there).count() > 1, "{pixels:?}");
    }
    assert_eq!(Area::pixel(UVec2::new(3, 4)).spread(8), [UVec2::new(3, 4)]);
}
