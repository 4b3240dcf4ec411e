//! Layers of pictures: what they tell of surfaces by formulas, how the light in them sums up, and that they change
//! nothing.

use std::sync::atomic::AtomicBool;

use glam::{Affine3A, Quat, UVec2, Vec2, Vec3};
use sunroom::accel::Primitive;
use sunroom::color::Rgb;
use sunroom::layer::{Layer, Layers};
use sunroom::light::LightSource;
use sunroom::material::{Material, MaterialId};
use sunroom::math::Ray;
use sunroom::render::camera::{Camera, ThinLens};
use sunroom::render::film::Film;
use sunroom::render::filter::{FilterKernel, PixelFilter};
use sunroom::render::image_io::ImageRgb;
use sunroom::render::layered_image::{is_cryptomatte, split_name};
use sunroom::render::layers::{LayerNames, LayerPixels, layered_image};
use sunroom::render::light_layers::LightGroups;
use sunroom::render::scene::RenderScene;
use sunroom::render::tile::{render_tile, tiles};
use sunroom::render::view::{Shown, Strategy, View};
use sunroom::shading::{Bsdf, Dielectric, DielectricModel, Diffuse, ThinDielectric};
use sunroom::texture::Parameter;

use crate::support::{SceneBuilder, camera, render, view};

const SIZE: u32 = 40;
const SAMPLES: u32 = 8;

fn diffuse(r: f32, g: f32, b: f32) -> Bsdf {
    Bsdf::Diffuse(Diffuse {
        reflectance: Rgb::new(r, g, b),
    })
}

fn all() -> Layers {
    Layer::ALL.into_iter().collect()
}

fn with_layers(layers: Layers, view: View) -> View {
    View { layers, ..view }
}

fn vectors(film: &Film, layer: Layer, camera: &Camera) -> Vec<Vec3> {
    match film.layer(layer, camera).expect("it is kept") {
        LayerPixels::Colors(pixels) | LayerPixels::Vectors(pixels) => pixels,
        LayerPixels::Pairs(pairs) => pairs.into_iter().map(|pair| pair.extend(0.0)).collect(),
        LayerPixels::Numbers(numbers) => numbers.into_iter().map(Vec3::splat).collect(),
        LayerPixels::Ids(ids) => ids.into_iter().map(|id| Vec3::splat(id as f32)).collect(),
    }
}

const WALL_SIZE: f32 = 1.5;
const WALL_Z: f32 = -1.0;
const BALL: Rgb = Rgb::new(0.6, 0.4, 0.2);
const WALL: Rgb = Rgb::new(0.1, 0.5, 0.7);

/// A unit ball before a wall that does not fill the picture.
fn ball_and_wall() -> RenderScene {
    let mut scene = SceneBuilder::default();
    scene.add(
        Primitive::Sphere,
        Affine3A::IDENTITY,
        diffuse(BALL.x, BALL.y, BALL.z),
        None,
    );
    let wall =
        Affine3A::from_scale_rotation_translation(Vec3::splat(WALL_SIZE), Quat::IDENTITY, Vec3::new(0.2, 0.1, WALL_Z));
    scene.add(Primitive::Rectangle, wall, diffuse(WALL.x, WALL.y, WALL.z), None);
    scene.light(LightSource::Constant { radiance: Rgb::ONE });
    scene.build()
}

/// The surface of that scene on a ray: its number from 1, distance, normal, albedo and texture coordinates (of the wall
/// alone).
fn surface_on(ray: &Ray) -> Option<(u32, f32, Vec3, Rgb, Option<Vec2>)> {
    let along = ray.origin.dot(ray.dir);
    let discriminant = along * along - ray.origin.length_squared() + 1.0;
    if discriminant > 0.0 {
        let t = -along - discriminant.sqrt();
        return Some((1, t, ray.at(t), BALL, None));
    }
    let t = (WALL_Z - ray.origin.z) / ray.dir.z;
    let place = (ray.at(t) - Vec3::new(0.2, 0.1, WALL_Z)).truncate() / WALL_SIZE;
    (place.abs().max_element() < 1.0).then(|| (2, t, Vec3::Z, WALL, Some(place * 0.5 + 0.5)))
}

#[test]
fn layers_of_surfaces_are_means_over_the_samples() {
    let scene = ball_and_wall();
    let eye = Vec3::new(0.5, 0.6, 4.0);
    let pinhole = camera(eye, Vec3::ZERO, 45.0);
    let with_lens = {
        let forward = -eye.normalize();
        let left = Vec3::Y.cross(forward).normalize();
        let axes = glam::Mat3::from_cols(left, forward.cross(left), forward);
        let lens = ThinLens {
            aperture_radius: 0.2,
            focus_distance: 3.0,
            blades: 0,
            blade_rotation: 0.0,
        };
        Camera::new(
            Affine3A::from_mat3_translation(axes, eye),
            45.0,
            1.0,
            0.1,
            1e3,
            Some(lens),
        )
    };
    let gaussian = PixelFilter::tabulated(FilterKernel::Gaussian { stddev: 0.5 });
    for (camera, filter) in [(pinhole, PixelFilter::Box), (with_lens, gaussian)] {
        let look = View {
            filter,
            ..with_layers(all(), view(camera, SIZE, 3, Strategy::Mis))
        };
        let film = render(&scene, &look, SAMPLES);
        let layer = |layer| vectors(&film, layer, &camera);
        let (alpha, albedo, depth) = (layer(Layer::Alpha), layer(Layer::Albedo), layer(Layer::Depth));
        let (position, normal, geometric) = (
            layer(Layer::Position),
            layer(Layer::Normal),
            layer(Layer::GeometricNormal),
        );
        let (in_camera, uv, id) = (layer(Layer::CameraNormal), layer(Layer::Uv), layer(Layer::ObjectId));
        let mut borders = 0;
        for place in 0..(SIZE * SIZE) as usize {
            let pixel = UVec2::new(place as u32 % SIZE, place as u32 / SIZE);
            let rays = (0..SAMPLES).map(|index| look.camera_sample(pixel, index).ray);
            let found: Vec<_> = rays.map(|ray| surface_on(&ray).map(|found| (ray, found))).collect();
            let hits: Vec<_> = found.iter().flatten().collect();
            borders += u32::from(!hits.is_empty() && hits.len() < SAMPLES as usize);
            let mean = |of: &dyn Fn(&Ray, f32, Vec3) -> Vec3| -> Vec3 {
                let sum: Vec3 = hits.iter().map(|(ray, (_, t, normal, ..))| of(ray, *t, *normal)).sum();
                sum / hits.len().max(1) as f32
            };
            let is = |what: &str, value: Vec3, expected: Vec3| {
                assert!(
                    value.abs_diff_eq(expected, 2e-4),
                    "{what} at {pixel}: {value}, not {expected}"
                );
            };
            is("alpha", alpha[place], Vec3::splat(hits.len() as f32 / SAMPLES as f32));
            let colours: Rgb = hits.iter().map(|(_, (_, _, _, colour, _))| *colour).sum();
            is("albedo", albedo[place], colours / SAMPLES as f32);
            is("depth", depth[place], mean(&|_, t, _| Vec3::splat(t)));
            is("position", position[place], mean(&|ray, t, _| ray.at(t)));
            is("normal", normal[place], mean(&|_, _, normal| normal));
            is("geometric normal", geometric[place], normal[place]);
            let turned = in_camera[place];
            assert!((turned.length() - normal[place].length()).abs() < 1e-5);
            if hits.len() == SAMPLES as usize {
                assert!(turned.z < 0.0, "it looks back to the camera");
            }
            if hits.len() == SAMPLES as usize && hits.iter().all(|(_, found)| found.0 == 2) {
                let sum: Vec2 = hits.iter().filter_map(|(_, found)| found.4).sum();
                is("uv", uv[place], (sum / SAMPLES as f32).extend(0.0));
            }
            let first = found[0].map_or(0, |(_, found)| found.0);
            assert_eq!(id[place], Vec3::splat(first as f32));
            assert_eq!(layer_at(&film, Layer::MaterialId, place), first as f32);
        }
        assert!(borders > 20, "the scene has a border");
        assert!(layer(Layer::Samples).iter().all(|samples| samples.x == SAMPLES as f32));
        let variance = layer(Layer::Variance);
        let expected = film.standard_error(20, 20).expect("two samples or more").powi(2);
        assert_eq!(variance[(20 * SIZE + 20) as usize].x, expected);
    }
}

fn layer_at(film: &Film, layer: Layer, place: usize) -> f32 {
    vectors(film, layer, &camera(Vec3::Z, Vec3::ZERO, 40.0))[place].x
}

/// A box open to the front with lamps, a ball of glass, a pane and a screen with holes, under a sky.
fn room() -> (RenderScene, LightGroups) {
    let mut scene = SceneBuilder::default();
    let quarter = std::f32::consts::FRAC_PI_2;
    let white = diffuse(0.7, 0.7, 0.7);
    for (axis, angle, paint) in [
        (Vec3::X, -quarter, white),
        (Vec3::X, quarter, white),
        (Vec3::Y, quarter, diffuse(0.6, 0.1, 0.1)),
        (Vec3::Y, -quarter, diffuse(0.1, 0.6, 0.1)),
        (Vec3::X, 0.0, white),
    ] {
        let rotation = Affine3A::from_quat(Quat::from_axis_angle(axis, angle));
        let away = Affine3A::from_translation(-rotation.transform_vector3(Vec3::Z));
        scene.add(Primitive::Rectangle, away * rotation, paint, None);
    }
    let placed =
        |scale, rotation, place| Affine3A::from_scale_rotation_translation(Vec3::splat(scale), rotation, place);
    let glass = Bsdf::Dielectric(Dielectric {
        eta: 1.5,
        model: DielectricModel::Exact,
        specular_reflectance: Rgb::ONE,
        specular_transmittance: Rgb::ONE,
    });
    let ball = placed(0.3, Quat::IDENTITY, Vec3::new(0.4, -0.7, 0.2));
    scene.add(Primitive::Sphere, ball, glass, None);
    let lamp = placed(0.3, Quat::from_rotation_x(quarter), Vec3::new(-0.4, 0.98, 0.0));
    scene.add(Primitive::Rectangle, lamp, white, Some(Rgb::new(6.0, 5.0, 4.0)));
    let bulb = placed(0.15, Quat::IDENTITY, Vec3::new(0.5, 0.3, -0.4));
    scene.add(Primitive::Sphere, bulb, white, Some(Rgb::new(3.0, 5.0, 8.0)));
    let pane = Bsdf::ThinDielectric(ThinDielectric {
        eta: 1.5,
        model: DielectricModel::Exact,
        specular_reflectance: Rgb::ONE,
        specular_transmittance: Rgb::new(0.9, 1.0, 0.8),
    });
    scene.add(
        Primitive::Rectangle,
        placed(0.4, Quat::IDENTITY, Vec3::new(-0.5, 0.2, 0.8)),
        pane,
        None,
    );
    let screen = Material::Mask {
        nested: MaterialId(0),
        opacity: Parameter::Constant(0.3),
    };
    scene.add(
        Primitive::Rectangle,
        placed(0.4, Quat::IDENTITY, Vec3::new(0.5, 0.2, 0.8)),
        screen,
        None,
    );
    scene.light(LightSource::Constant {
        radiance: Rgb::new(0.3, 0.4, 0.5),
    });
    (scene.build(), LightGroups::new(&[0, 1, 2]))
}

/// A closed scene of the commonest models with one lamp, which has a way of its own through the lanes.
fn one_lamp() -> (RenderScene, LightGroups) {
    let mut scene = SceneBuilder::default();
    let down = Quat::from_rotation_x(-std::f32::consts::FRAC_PI_2);
    let placed =
        |scale, rotation, place| Affine3A::from_scale_rotation_translation(Vec3::splat(scale), rotation, place);
    scene.add(
        Primitive::Rectangle,
        placed(2.0, down, Vec3::NEG_Y),
        diffuse(0.7, 0.6, 0.5),
        None,
    );
    scene.add(
        Primitive::Sphere,
        placed(0.5, Quat::IDENTITY, Vec3::new(0.2, -0.5, 0.0)),
        diffuse(0.2, 0.6, 0.7),
        None,
    );
    let lamp = placed(0.5, down.inverse(), Vec3::new(0.0, 0.9, 0.0));
    scene.add(
        Primitive::Rectangle,
        lamp,
        diffuse(0.0, 0.0, 0.0),
        Some(Rgb::new(7.0, 6.0, 5.0)),
    );
    (scene.build(), LightGroups::new(&[0]))
}

fn look(depth: u32, strategy: Strategy) -> View {
    view(
        camera(Vec3::new(0.1, 0.1, 4.0), Vec3::ZERO, 40.0),
        SIZE,
        depth,
        strategy,
    )
}

/// Two sums of the same numbers, which are about 1 or below, in two orders differ by their roundings.
const REORDERED: f32 = 1e-4;

fn assert_near(what: &str, found: &[Rgb], expected: &[Rgb]) {
    for (place, (found, expected)) in found.iter().zip(expected).enumerate() {
        let error = (*found - *expected).abs().max_element();
        assert!(
            error <= REORDERED * (expected.abs().max_element() + 0.1),
            "{what} at {place}: {found}, not {expected}"
        );
    }
}

fn sums(layers: &[Vec<Rgb>]) -> Vec<Rgb> {
    (0..layers[0].len())
        .map(|place| layers.iter().map(|layer| layer[place]).sum())
        .collect()
}

#[test]
fn direct_indirect_and_emitted_light_sum_up_to_the_picture() {
    for (scene, light_groups) in [room(), one_lamp()] {
        for strategy in [Strategy::Mis, Strategy::Bsdf, Strategy::Light] {
            let look = View {
                filter: PixelFilter::tabulated(FilterKernel::CATMULL_ROM),
                light_groups: light_groups.clone(),
                ..with_layers(all(), look(7, strategy))
            };
            let film = render(&scene, &look, 32);
            let light =
                [Layer::Direct, Layer::Indirect, Layer::Emitted].map(|layer| vectors(&film, layer, &look.camera));
            for layer in &light {
                assert!(layer.iter().filter(|light| **light != Rgb::ZERO).count() > 50);
            }
            assert_near("light by bounces", &sums(&light), &film.radiance());
            let groups: Vec<Vec<Rgb>> = (0..light_groups.count())
                .map(|group| film.light_group(group).expect("it is kept"))
                .collect();
            assert_near("light by lamps", &sums(&groups), &film.radiance());
            assert_eq!(film.light_group(light_groups.count()), None);
        }
    }
}

/// Paths of other lengths have the same random numbers.
#[test]
fn direct_light_is_that_of_short_paths() {
    let (scene, _) = one_lamp();
    let film = render(&scene, &with_layers(all(), look(7, Strategy::Mis)), 16);
    let layer = |layer| vectors(&film, layer, &look(7, Strategy::Mis).camera);
    let emitted = render(&scene, &look(1, Strategy::Mis), 16).radiance();
    let with_direct = render(&scene, &look(2, Strategy::Mis), 16).radiance();
    assert_near("emitted", &layer(Layer::Emitted), &emitted);
    assert_near(
        "direct",
        &sums(&[layer(Layer::Direct), layer(Layer::Emitted)]),
        &with_direct,
    );
    assert!(layer(Layer::Indirect).iter().any(|light| light.min_element() > 0.01));
}

#[test]
fn channels_of_pictures_have_the_names_of_their_layers() {
    let (scene, light_groups) = room();
    let groups = ["key", "fill", "back"].map(str::to_owned);
    let look = View {
        light_groups,
        ..with_layers(all(), look(2, Strategy::Mis))
    };
    let film = render(&scene, &look, 2);
    let name = |number: u32| number.to_string();
    let names = LayerNames {
        object: &name,
        material: &name,
        light_groups: &groups,
    };
    let pixels = film.radiance();
    let picture = ImageRgb {
        width: film.width(),
        height: film.height(),
        pixels: pixels.clone(),
    };
    let image = layered_image(&picture, &film, &look.camera, &names, Some(&pixels));
    let of_layer = |layer: Layer| -> Vec<String> {
        let name = layer.name_in_pictures();
        let layers = match layer {
            Layer::Alpha => return vec![name.to_owned()],
            Layer::LightGroups => groups.iter().map(|group| format!("{name}.{group}")).collect(),
            _ => vec![name.to_owned()],
        };
        let channels = layer.channels_in_pictures();
        let named = |name: &String| channels.iter().map(|channel| format!("{name}.{channel}")).collect();
        layers.iter().flat_map(|name| -> Vec<String> { named(name) }).collect()
    };
    let mut expected: Vec<String> = ["R", "G", "B"].map(str::to_owned).to_vec();
    expected.extend(Layer::ALL.into_iter().flat_map(of_layer));
    let (mattes, mut found): (Vec<String>, Vec<String>) = image
        .channels
        .iter()
        .map(|channel| channel.name.clone())
        .partition(|name| is_cryptomatte(split_name(name).0));
    expected.sort();
    found.sort();
    assert_eq!(found, expected);
    for layer in Layer::ALL
        .into_iter()
        .filter(|layer| layer.channels_in_pictures().is_empty())
    {
        assert!(
            mattes.iter().any(|name| name.starts_with(layer.name_in_pictures())),
            "{layer:?}"
        );
    }
}

#[test]
fn pictures_have_the_same_bits_with_and_without_layers() {
    for (scene, light_groups) in [room(), one_lamp()] {
        for strategy in [Strategy::Mis, Strategy::Bsdf, Strategy::Light] {
            let plain = look(6, strategy);
            let without = render(&scene, &plain, SAMPLES);
            let every = View {
                light_groups: light_groups.clone(),
                ..with_layers(all(), plain.clone())
            };
            for layers in Layer::ALL.map(|layer| with_layers(Layers::of(&[layer]), plain.clone())) {
                let film = render(&scene, &layers, SAMPLES);
                assert!(film.radiance() == without.radiance(), "{:?}", layers.layers);
            }
            let film = render(&scene, &every, SAMPLES);
            assert!(film.radiance() == without.radiance());
            assert!(film.albedo() == without.albedo() && film.normal() == without.normal());
            assert!(film.depth() == without.depth());
        }
    }
}

/// In the last third all strategies are combined, as everywhere in the picture without thirds, whose paths are traced
/// side by side.
#[test]
fn layers_of_paths_in_lanes_are_those_of_paths_one_by_one() {
    let (scene, light_groups) = room();
    let side_by_side = View {
        light_groups,
        ..with_layers(all(), look(6, Strategy::Mis))
    };
    let one_by_one = View {
        shown: Shown::StrategyThirds,
        ..side_by_side.clone()
    };
    let films = [&side_by_side, &one_by_one].map(|look| render(&scene, look, SAMPLES));
    let mut pairs: Vec<(String, [Vec<Vec3>; 2])> = Vec::new();
    for layer in Layer::ALL {
        if films[0].layer(layer, &side_by_side.camera).is_some() {
            let both = [&films[0], &films[1]].map(|film| vectors(film, layer, &side_by_side.camera));
            pairs.push((layer.name().to_owned(), both));
        }
    }
    for group in 0..3 {
        let both = [&films[0], &films[1]].map(|film| film.light_group(group).expect("it is kept"));
        pairs.push((format!("group {group}"), both));
    }
    for (name, [lanes, alone]) in &pairs {
        let right = (0..lanes.len()).filter(|place| *place as u32 % SIZE > 2 * SIZE / 3);
        let strays =
            right.filter(|&place| !lanes[place].abs_diff_eq(alone[place], 1e-3 * lanes[place].length() + 1e-4));
        // Rounding may send a path elsewhere.
        assert!(strays.count() <= 10, "{name}");
    }
    let mattes = [&films[0], &films[1]].map(|film| film.mattes(Layer::CryptoObject).expect("it is kept"));
    let right = (0..mattes[0].len()).filter(|place| *place as u32 % SIZE > 2 * SIZE / 3);
    assert!(right.filter(|&place| mattes[0][place] != mattes[1][place]).count() <= 10);
}

/// Behind a screen of which 0.3 is there, and around it.
#[test]
fn what_is_seen_through_holes_counts() {
    let mut scene = SceneBuilder::default();
    scene.add(
        Primitive::Sphere,
        Affine3A::from_translation(Vec3::X * 100.0),
        diffuse(1.0, 1.0, 1.0),
        None,
    );
    let screen = Material::Mask {
        nested: MaterialId(0),
        opacity: Parameter::Constant(0.3),
    };
    scene.add(
        Primitive::Rectangle,
        Affine3A::from_scale(Vec3::splat(9.0)),
        screen,
        None,
    );
    let wall =
        Affine3A::from_scale_rotation_translation(Vec3::new(9.0, 9.0, 1.0), Quat::IDENTITY, Vec3::new(9.0, 0.0, -2.0));
    scene.add(Primitive::Rectangle, wall, diffuse(0.5, 0.5, 0.5), None);
    let scene = scene.build();
    let samples = 64;
    let look = with_layers(
        Layers::of(&[Layer::Alpha, Layer::Depth, Layer::CryptoObject, Layer::ObjectId]),
        view(camera(Vec3::Z * 5.0, Vec3::ZERO, 20.0), SIZE, 6, Strategy::Mis),
    );
    let film = render(&scene, &look, samples);
    let layer = |layer| vectors(&film, layer, &look.camera);
    let (alpha, depth, id) = (layer(Layer::Alpha), layer(Layer::Depth), layer(Layer::ObjectId));
    let mattes = film.mattes(Layer::CryptoObject).expect("it is kept");
    let place = |x: u32| (SIZE / 2 * SIZE + x) as usize;
    // The wall is behind the right half.
    let mean = |of: &dyn Fn(usize) -> f32, columns: std::ops::Range<u32>| {
        let count = columns.len() as f32;
        columns.map(|x| of(place(x))).sum::<f32>() / count
    };
    let (before_nothing, before_wall) = (0..SIZE / 2 - 4, SIZE / 2 + 4..SIZE);
    assert_eq!(mean(&|place| alpha[place].x, before_wall.clone()), 1.0);
    // 16 pixels of 64 samples each: four standard errors are 0.06.
    let opacity = mean(&|place| alpha[place].x, before_nothing.clone());
    assert!((opacity - 0.3).abs() < 0.06, "{opacity}");
    assert!(
        before_nothing.clone().all(|x| (depth[place(x)].x - 5.0).abs() < 0.1),
        "the screen alone"
    );
    // The wall is 7 away and seen 0.7 of the time.
    let seen = mean(&|place| depth[place].x, before_wall.clone());
    assert!((seen - (0.3 * 5.0 + 0.7 * 7.0)).abs() < 0.2, "{seen}");
    assert!(
        before_nothing.clone().all(|x| id[place(x)].x == 2.0),
        "the screen is hit first"
    );
    let covered = |place: usize, id: u32| {
        let of_id = mattes[place].0.entries().find(|entry| entry.id == id);
        of_id.map_or(0, |entry| entry.samples) as f32 / mattes[place].1 as f32
    };
    for x in before_nothing.chain(before_wall) {
        let sum = covered(place(x), 1) + covered(place(x), 2);
        assert!((sum - alpha[place(x)].x).abs() < 1e-6, "{sum} {}", alpha[place(x)].x);
    }
}

#[test]
fn the_order_of_tiles_and_passes_does_not_matter() {
    let (scene, light_groups) = room();
    let look = View {
        light_groups,
        ..with_layers(all(), look(5, Strategy::Mis))
    };
    let mut films: Vec<Film> = Vec::new();
    for is_turned in [false, true] {
        let mut order = tiles(SIZE, SIZE);
        if is_turned {
            order.reverse();
        }
        let mut film = Film::with_layers(SIZE, SIZE, look.film_layers());
        for range in [0..1, 1..2, 2..8] {
            for &tile in &order {
                let samples = render_tile(&scene, &look, tile, range.clone(), &AtomicBool::new(false));
                film.add(&samples.expect("not cancelled"));
            }
        }
        films.push(film);
    }
    assert!(films[0] == films[1]);
    // A film that is used again has nothing of the old one.
    let [first, mut used] = <[Film; 2]>::try_from(films).expect("two");
    used.begin(SIZE, SIZE, look.film_layers());
    for range in [0..1, 1..2, 2..8] {
        for tile in tiles(SIZE, SIZE) {
            let samples = render_tile(&scene, &look, tile, range.clone(), &AtomicBool::new(false));
            used.add(&samples.expect("not cancelled"));
        }
    }
    assert!(used == first);
    let plain = Film::memory_bytes(SIZE, SIZE, Default::default());
    assert!(Film::memory_bytes(SIZE, SIZE, look.film_layers()) > 2 * plain);
}
