//! Surfaces whose radiance is a texture: their samples against their density, whatever the shape and whatever the
//! texture, and one picture whatever samples it.

use crate::statistics;
use std::f32::consts::FRAC_PI_2;
use std::sync::Arc;

use crate::support::{SceneBuilder, all_around, assert_close, camera, mean_luminance, render, view};
use glam::{Affine2, Affine3A, UVec2, Vec2, Vec3};
use sunroom::accel::{Blas, Primitive, SplitMethod};
use sunroom::color::{Rgb, luminance};
use sunroom::geometry::attribute::{self, AttributeDomain, AttributeValues};
use sunroom::geometry::mesh::MeshData;
use sunroom::light::{LightId, LightSample, SurfaceHit};
use sunroom::math::Ray;
use sunroom::render::scene::RenderScene;
use sunroom::render::view::Strategy;
use sunroom::sampling::{Sampler, SequenceKind, hash::pcg3d, unit_float};
use sunroom::shading::{Bsdf, Diffuse};
use sunroom::texture::{
    Bitmap, Checkerboard, Filter, Image, MeshAttribute, Parameter, Samples, Texture, TextureId, TextureTable, Transfer,
    Wrap,
};

fn diffuse(reflectance: f32) -> Bsdf {
    Bsdf::Diffuse(Diffuse {
        reflectance: Rgb::splat(reflectance),
    })
}

fn checkerboard(to_uv: Affine2) -> Texture {
    Texture::Checkerboard(Checkerboard {
        colors: [
            Parameter::Constant(Rgb::new(0.2, 0.0, 0.0)),
            Parameter::Constant(Rgb::new(1.0, 2.0, 4.0)),
        ],
        to_uv,
    })
}

/// Two by two squares over the unit square of uv, dark red where both halves are the same.
fn squares() -> Texture {
    checkerboard(Affine2::IDENTITY)
}

/// 7 by 5 texels of noise, of which a few are very bright if `contrast` is high; samples in eight bits are encoded.
fn bitmap(filter: Filter, wrap: Wrap, to_uv: Affine2, contrast: i32, eight_bits: bool) -> Texture {
    let noise = (0..7 * 5 * 3).map(|i| unit_float(pcg3d([i, 3, 1])[0]));
    let (samples, transfer) = match eight_bits {
        true => {
            let bytes = noise.map(|x| (255.0 * x) as u8).collect();
            (Samples::U8(bytes), Transfer::Srgb)
        }
        false => {
            let floats = noise.map(|x| x.powi(contrast) * 4f32.powi(contrast)).collect();
            (Samples::F32(floats), Transfer::Linear)
        }
    };
    Texture::Bitmap(Bitmap {
        image: Arc::new(Image::new(7, 5, 3, samples, transfer).expect("a whole picture")),
        filter,
        wrap: [wrap; 2],
        raw: false,
        to_uv,
    })
}

/// The square [-1, 1]^2 as two triangles with texture coordinates and a colour per corner.
fn textured_mesh() -> Primitive {
    let corners = [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)];
    let mesh = MeshData {
        positions: corners.map(|(x, y)| Vec3::new(x, y, 0.0)).to_vec(),
        uvs: corners.map(|(x, y)| Vec2::new(0.5 * x + 0.5, 0.5 * y + 0.5)).to_vec(),
        triangles: vec![[0, 1, 2], [0, 2, 3]],
        attributes: vec![attribute::MeshAttribute {
            name: "vertex_glow".to_owned(),
            domain: AttributeDomain::Vertex,
            channels: 1,
            values: AttributeValues::F32(vec![0.5, 8.0, 1.0, 0.1]),
        }],
        ..MeshData::default()
    };
    Primitive::Mesh(Arc::new(Blas::build(Arc::new(mesh), SplitMethod::Sah)))
}

/// A floor under a textured surface that shines down.
fn textured_area(primitive: Primitive, to_world: Affine3A, texture: Texture) -> RenderScene {
    let mut scene = SceneBuilder::with_textures(TextureTable::new(vec![texture]));
    let down = Affine3A::from_translation(Vec3::new(0.2, 1.0, 0.1)) * Affine3A::from_rotation_x(FRAC_PI_2);
    scene.add_textured(
        primitive,
        down * to_world,
        diffuse(0.0),
        Parameter::Texture(TextureId(0)),
    );
    let floor = Affine3A::from_rotation_x(-FRAC_PI_2) * Affine3A::from_scale(Vec3::splat(20.0));
    scene.add(
        Primitive::Rectangle,
        Affine3A::from_translation(Vec3::Y * -0.5) * floor,
        diffuse(0.5),
        None,
    );
    scene.build()
}

/// Rectangles, the only ones that are sampled as their texture shines.
fn rectangles() -> Vec<(&'static str, RenderScene)> {
    let shear = Affine3A::from_mat3(glam::Mat3::from_cols(Vec3::X, Vec3::new(0.5, 0.8, 0.0), Vec3::Z));
    let twice = Affine2::from_scale(Vec2::splat(2.0));
    let askew = Affine2::from_scale_angle_translation(Vec2::new(1.5, 0.7), 0.6, Vec2::new(0.3, -0.2));
    let plain = |filter, wrap, to_uv| bitmap(filter, wrap, to_uv, 1, false);
    let pictures = vec![
        ("squares", squares()),
        ("many squares", checkerboard(Affine2::from_scale(Vec2::new(3.0, 5.0)))),
        ("askew squares", checkerboard(askew)),
        ("nearest", plain(Filter::Nearest, Wrap::Repeat, Affine2::IDENTITY)),
        ("bilinear", plain(Filter::Bilinear, Wrap::Repeat, Affine2::IDENTITY)),
        ("repeated", plain(Filter::Bilinear, Wrap::Repeat, twice)),
        ("clamped", plain(Filter::Bilinear, Wrap::Clamp, twice)),
        ("mirrored", plain(Filter::Nearest, Wrap::Mirror, askew)),
        (
            "contrast",
            bitmap(Filter::Bilinear, Wrap::Repeat, Affine2::IDENTITY, 6, false),
        ),
        (
            "eight bits",
            bitmap(Filter::Bilinear, Wrap::Clamp, Affine2::IDENTITY, 1, true),
        ),
    ];
    let upright = |(name, texture)| (name, textured_area(Primitive::Rectangle, Affine3A::IDENTITY, texture));
    let mut scenes: Vec<_> = pictures.into_iter().map(upright).collect();
    scenes.push(("parallelogram", textured_area(Primitive::Rectangle, shear, squares())));
    scenes
}

/// Every other shape; the parts of a mesh are chosen by their brightness.
fn others() -> Vec<(&'static str, RenderScene)> {
    let glow = Texture::MeshAttribute(MeshAttribute {
        name: "vertex_glow".into(),
        scale: 1.5,
        times: None,
    });
    let small = Affine3A::from_scale(Vec3::splat(0.5));
    let tube = Affine3A::from_translation(Vec3::X * 0.6) * Affine3A::from_scale(Vec3::new(0.3, 0.3, 0.8));
    let egg = Affine3A::from_scale(Vec3::new(0.7, 0.3, 0.5));
    vec![
        ("disk", textured_area(Primitive::Disk, Affine3A::IDENTITY, squares())),
        ("cylinder", textured_area(Primitive::Cylinder, tube, squares())),
        ("sphere", textured_area(Primitive::Sphere, small, squares())),
        ("ellipsoid", textured_area(Primitive::Sphere, egg, squares())),
        ("mesh", textured_area(textured_mesh(), Affine3A::IDENTITY, squares())),
        (
            "mesh with values",
            textured_area(textured_mesh(), Affine3A::IDENTITY, glow),
        ),
    ]
}

/// Radiance and density of the light in a direction from the origin.
fn found(scene: &RenderScene, wi: Vec3) -> Option<(Rgb, f32)> {
    let ray = Ray::new(Vec3::ZERO, wi);
    let hit = scene.geometry.intersect(&ray).filter(|hit| hit.instance == 0)?;
    let point = scene.geometry.surface(&ray, &hit);
    let on_light = SurfaceHit::at(&hit, &point);
    let radiance = scene.lights.emitted(LightId(0), &on_light, -wi);
    let pdf = scene.lights.pdf_of_hit(LightId(0), &all_around(Vec3::ZERO), &on_light);
    (radiance != Rgb::ZERO).then_some((radiance, pdf))
}

fn draw(scene: &RenderScene, index: u32) -> Option<LightSample> {
    let sampler = Sampler::new(SequenceKind::Independent, UVec2::new(9, 1), index, 3);
    let chosen = scene
        .lights
        .sample(&all_around(Vec3::ZERO), sampler.at_1d(0), sampler.at_2d(1));
    chosen.map(|(_, sample)| sample)
}

#[test]
fn sampled_points_are_those_found() {
    for (name, scene) in rectangles().into_iter().chain(others()) {
        let (mut sampled, mut differing) = (0, 0);
        for sample in (0..4000).filter_map(|index| draw(&scene, index)) {
            sampled += 1;
            let same = found(&scene, sample.wi).is_some_and(|(radiance, pdf)| {
                let error = (radiance - sample.radiance).abs().max_element();
                error <= 2e-3 * radiance.max_element() && (pdf / sample.pdf - 1.0).abs() < 3e-3
            });
            differing += u32::from(!same);
        }
        // At silhouettes and between squares and texels the two may fall on different sides.
        assert!(
            sampled > 500 && differing <= sampled / 50,
            "{name}: {differing} of {sampled} differ"
        );
    }
}

#[test]
fn points_of_rectangles_follow_their_density() {
    // Counted over the rectangle's own square, whose halves and fifths are whole numbers of bins.
    const BINS: usize = 20;
    let count = 50_000;
    let mut results = Vec::new();
    for (name, scene) in rectangles() {
        let world_from_local = scene.geometry.instances()[0].world_from_local;
        let edges = [Vec3::X, Vec3::Y].map(|axis| world_from_local.transform_vector3(2.0 * axis));
        let area_normal = edges[0].cross(edges[1]);
        let density = |a: f64, b: f64| {
            let local = Vec3::new(2.0 * a as f32 - 1.0, 2.0 * b as f32 - 1.0, 0.0);
            let at = world_from_local.transform_point3(local);
            let pdf = found(&scene, at.normalize()).map_or(0.0, |(_, pdf)| pdf);
            f64::from(pdf * area_normal.dot(at).abs() / at.length().powi(3))
        };
        let size = 1.0 / BINS as f64;
        let bin_mass = |bin| {
            let corner = [(bin % BINS) as f64 * size, (bin / BINS) as f64 * size];
            statistics::integrate(&density, corner, [size, size]) * f64::from(count)
        };
        let expected: Vec<f64> = (0..BINS * BINS).map(bin_mass).collect();
        let mut counted = vec![0.0; BINS * BINS];
        for sample in (0..count).filter_map(|index| draw(&scene, index + 10_000)) {
            let ray = Ray::new(Vec3::ZERO, sample.wi);
            let hit = scene.geometry.intersect(&ray).expect("a sampled point");
            let bin = |x: f32| (((0.5 * x + 0.5) * BINS as f32) as usize).min(BINS - 1);
            counted[bin(hit.v) * BINS + bin(hit.u)] += 1.0;
        }
        let total = expected.iter().sum::<f64>() / f64::from(count);
        assert!((total - 1.0).abs() < 2e-3, "{name}: the density integrates to {total}");
        results.push((name.to_owned(), statistics::chi_squared_p(&counted, &expected)));
    }
    statistics::assert_all_plausible(&results);
}

#[test]
fn directions_to_other_shapes_follow_their_density() {
    let results: Vec<(String, f64)> = others()
        .iter()
        .map(|(name, scene)| {
            let sampled = |index| draw(scene, index).map(|sample| sample.wi);
            let density = |wi| found(scene, wi).map_or(0.0, |(_, pdf)| pdf);
            (
                name.to_string(),
                statistics::sphere_p(60_000, Vec3::Y, sampled, density),
            )
        })
        .collect();
    statistics::assert_all_plausible(&results);
}

/// The mean of radiance over density is what arrives in all; where the density follows the texture, it hardly varies.
#[test]
fn samples_add_up_to_the_whole_with_little_noise() {
    for (name, scene) in rectangles().into_iter().chain(others()) {
        let brightness = |wi| found(&scene, wi).map_or(0.0, |(radiance, _)| luminance(radiance));
        let whole = statistics::sphere_integral(Vec3::Y, brightness);
        let count = 40_000;
        let (mut sum, mut squares) = (0.0, 0.0);
        for sample in (0..count).filter_map(|index| draw(&scene, index)) {
            let value = f64::from(luminance(sample.radiance) / sample.pdf);
            sum += value;
            squares += value * value;
        }
        let mean = sum / f64::from(count);
        let deviation = (squares / f64::from(count) - mean * mean).sqrt();
        let error = deviation / f64::from(count).sqrt();
        // Plus the quadrature's error at the edges of squares.
        assert!(
            (mean - whole).abs() < 4.0 * error + 4e-3 * whole,
            "{name}: {mean} +- {error}, {whole}"
        );
        // 0.4 is what cosine and distance make of even points. The rest: a share of the samples goes evenly over the
        // surface, and the edges of squares are blurred by a cell of 128. Points by solid angle alone would
        // have more than 1 for squares.
        if let Primitive::Rectangle = scene.geometry.instances()[0].primitive {
            assert!(deviation < 0.6 * whole, "{name}: noise {deviation} of {whole}");
        }
    }
}

#[test]
fn they_light_the_same_however_they_are_found() {
    let scenes = rectangles()
        .into_iter()
        .filter(|(name, _)| matches!(*name, "squares" | "contrast" | "parallelogram"));
    for (name, scene) in scenes.chain(others()) {
        let by = |strategy| {
            let look = view(camera(Vec3::new(2.5, 0.4, 0.0), Vec3::Y * -0.5, 20.0), 4, 2, strategy);
            mean_luminance(&render(&scene, &look, 4096))
        };
        let reference = by(Strategy::Mis);
        assert!(reference.0 > 0.005, "{name}: {reference:?}");
        for strategy in [Strategy::Bsdf, Strategy::Light] {
            let (mean, error) = by(strategy);
            assert_close(
                &format!("{name}, {strategy:?}"),
                (mean, error.hypot(reference.1)),
                reference.0,
            );
        }
    }
}
