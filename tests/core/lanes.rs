//! Paths traced side by side, as pictures are, against the same paths one by one.

use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use glam::{Affine2, Affine3A, Quat, UVec2, Vec2, Vec3};
use sunroom::accel::{Blas, Primitive, SplitMethod};
use sunroom::geometry::mesh::MeshData;
use sunroom::light::LightSource;
use sunroom::material::{BumpOptions, Material, MaterialId, TexturedBsdf};
use sunroom::medium::{MediumId, MediumInterface, MediumSource, Phase, Volume};
use sunroom::render::camera::{Camera, ThinLens};
use sunroom::render::filter::{FilterKernel, PixelFilter};
use sunroom::render::path::trace_path;
use sunroom::render::scene::RenderScene;
use sunroom::render::tile::{render_preview, render_tile, tiles};
use sunroom::render::view::{Integrator, PathSettings, Strategy, View};
use sunroom::sampling::SequenceKind;
use sunroom::shading::{
    Bsdf, CoatedBase, Compensation, Conductor, ConductorSpecular, Dielectric, DielectricModel, Diffuse, Fiber, Hair,
    Metal, Microfacet, MicrofacetKind, Plastic, Principled, PrincipledThin, RoughConductor, RoughDielectric,
    RoughPlastic, SamplingRates, ShadingTables, SmoothCoat, ThinDielectric, ThinSamplingRates,
};
use sunroom::texture::{Checkerboard, Parameter, Texture, TextureId, TextureTable};

use crate::support::{SceneBuilder, camera, square_mesh, triangle_mesh, view};
use crate::wavy_sphere::wavy_sphere;

const SIZE: u32 = 48;
const SAMPLES: u32 = 6;

fn diffuse(reflectance: [f32; 3]) -> Bsdf {
    Bsdf::Diffuse(Diffuse {
        reflectance: Vec3::from(reflectance),
    })
}

fn gold() -> ConductorSpecular {
    ConductorSpecular {
        eta: Vec3::new(0.14, 0.37, 1.44),
        k: Vec3::new(3.98, 2.39, 1.6),
        specular_reflectance: Vec3::ONE,
    }
}

fn placed(at: Vec3, turned: Quat, size: f32) -> Affine3A {
    Affine3A::from_scale_rotation_translation(Vec3::splat(size), turned, at)
}

/// A room with a floor and walls, and balls of every kind of model: those that are traced in lanes and those that are
/// not.
fn room() -> SceneBuilder {
    let mut room = SceneBuilder::with_textures(squares());
    let down = Quat::from_rotation_x(-std::f32::consts::FRAC_PI_2);
    let floor = placed(Vec3::NEG_Y, down, 3.0);
    room.add(Primitive::Rectangle, floor, diffuse([0.5, 0.6, 0.7]), None);
    room.add(
        square_mesh(),
        placed(Vec3::NEG_Z * 2.0, Quat::IDENTITY, 3.0),
        diffuse([0.8, 0.3, 0.3]),
        None,
    );
    let ball = |x: f32, z: f32| placed(Vec3::new(x, -0.6, z), Quat::IDENTITY, 0.4);
    let rough = Bsdf::RoughConductor(RoughConductor {
        specular: gold(),
        distribution: Microfacet::new(MicrofacetKind::Ggx, 0.2, 0.2),
        multiple_scattering: Compensation::NONE,
    });
    let glass = Bsdf::Dielectric(Dielectric {
        eta: 1.5,
        model: DielectricModel::Exact,
        specular_reflectance: Vec3::ONE,
        specular_transmittance: Vec3::ONE,
    });
    let fuzzy = Bsdf::Metal(Metal {
        color: Vec3::new(0.9, 0.8, 0.7),
        fuzz: 0.3,
    });
    room.add(Primitive::Sphere, ball(-1.0, 0.0), rough, None);
    room.add(Primitive::Sphere, ball(0.0, 0.3), glass, None);
    room.add(Primitive::Sphere, ball(1.0, 0.0), fuzzy, None);
    room.add(
        Primitive::Sphere,
        ball(-0.5, -1.0),
        Bsdf::Conductor(Conductor { specular: gold() }),
        None,
    );
    // Black from behind on its own, here the same on both sides; materials count in the order they are added.
    let two_sided = Material::TwoSided {
        front: MaterialId(0),
        back: MaterialId(1),
    };
    let leaning = Quat::from_rotation_y(0.7) * Quat::from_rotation_x(-0.4);
    room.add(
        square_mesh(),
        placed(Vec3::new(0.8, -0.4, -1.0), leaning, 0.5),
        two_sided,
        None,
    );
    let bumped = Material::BumpMap {
        nested: MaterialId(0),
        height: Parameter::Constant(1.0),
        scale: 1.0,
        options: BumpOptions {
            flip_invalid_normals: true,
            use_shadowing_function: true,
        },
    };
    room.add(
        Primitive::Disk,
        placed(Vec3::new(-1.2, 0.0, -1.5), Quat::IDENTITY, 0.5),
        bumped,
        None,
    );
    // Maps whose normals lean, about a plain model, glass, and both sides of a sheet.
    for (i, nested) in [0, 3, 6].into_iter().enumerate() {
        let leaning = Material::NormalMap {
            nested: MaterialId(nested),
            normals: Parameter::Constant(Vec3::new(0.7, 0.35, 0.9)),
            gltf_tangents: false,
            options: BumpOptions {
                flip_invalid_normals: true,
                use_shadowing_function: true,
            },
        };
        let at = Vec3::new(0.7 * i as f32 - 0.8, 0.1, -0.9);
        room.add(Primitive::Sphere, placed(at, Quat::IDENTITY, 0.2), leaning, None);
    }
    for (i, material) in others(&mut room.tables).into_iter().enumerate() {
        let at = Vec3::new(0.37 * i as f32 - 1.5, 0.5, -1.2);
        room.add(Primitive::Sphere, placed(at, Quat::IDENTITY, 0.18), material, None);
    }
    room
}

/// Models with several lobes, with tables or with frames of their own; a texture, and a mixture.
fn others(tables: &mut ShadingTables) -> [Material; 9] {
    let base = CoatedBase {
        diffuse_reflectance: Vec3::new(0.7, 0.6, 0.5),
        specular_reflectance: Vec3::ONE,
        nonlinear: true,
    };
    let satin = Microfacet::new(MicrofacetKind::Beckmann, 0.3, 0.2);
    let brushed = Microfacet::new(MicrofacetKind::Ggx, 0.4, 0.4);
    let compensation = Compensation::new(tables.microalbedo_of(MicrofacetKind::Ggx), &brushed, &gold());
    [
        Material::Plain(Bsdf::Plastic(Plastic {
            coat: SmoothCoat::new(1.5),
            base,
        })),
        Material::Plain(Bsdf::RoughPlastic(RoughPlastic {
            coat: tables.uniform_coat(MicrofacetKind::Ggx, 1.5, 0.3),
            alpha: 0.3,
            base,
        })),
        Material::Plain(Bsdf::RoughDielectric(RoughDielectric {
            eta: 1.5,
            model: DielectricModel::Exact,
            distribution: satin,
            specular_reflectance: Vec3::ONE,
            specular_transmittance: Vec3::ONE,
        })),
        Material::Plain(Bsdf::RoughConductor(RoughConductor {
            specular: gold(),
            distribution: satin,
            multiple_scattering: Compensation::NONE,
        })),
        Material::Plain(Bsdf::RoughConductor(RoughConductor {
            specular: gold(),
            distribution: brushed,
            multiple_scattering: compensation,
        })),
        Material::Plain(Bsdf::Principled(Principled {
            base_color: Vec3::new(0.7, 0.3, 0.2),
            roughness: 0.4,
            anisotropic: 0.6,
            metallic: 0.2,
            spec_trans: 0.3,
            eta: 1.4,
            spec_tint: 0.3,
            sheen: 0.4,
            sheen_tint: 0.5,
            flatness: 0.3,
            clearcoat: 0.5,
            clearcoat_gloss: 0.6,
            rates: SamplingRates::default(),
        })),
        Material::Plain(Bsdf::PrincipledThin(PrincipledThin {
            base_color: Vec3::new(0.3, 0.7, 0.4),
            roughness: 0.5,
            anisotropic: 0.3,
            spec_trans: 0.4,
            diff_trans: 0.8,
            eta: 1.5,
            spec_tint: 0.2,
            sheen: 0.3,
            sheen_tint: 0.4,
            flatness: 0.2,
            rates: ThinSamplingRates::default(),
        })),
        Material::Textured(TexturedBsdf::Diffuse {
            reflectance: Parameter::Texture(TextureId(0)),
        }),
        Material::Blend {
            first: MaterialId(0),
            second: MaterialId(2),
            weight: Parameter::Constant(0.4),
        },
    ]
}

/// Squares of two colours.
fn squares() -> TextureTable {
    TextureTable::new(vec![Texture::Checkerboard(Checkerboard {
        colors: [Vec3::new(0.8, 0.7, 0.2), Vec3::new(0.1, 0.2, 0.3)].map(Parameter::Constant),
        to_uv: Affine2::from_scale(Vec2::splat(6.0)),
    })])
}

/// Light passes straight through a pane, the holes of a screen, and out of a fibre.
fn behind_panes() -> RenderScene {
    let mut room = room();
    let pane = Bsdf::ThinDielectric(ThinDielectric {
        eta: 1.5,
        model: DielectricModel::Exact,
        specular_reflectance: Vec3::ONE,
        specular_transmittance: Vec3::new(0.9, 1.0, 0.8),
    });
    let screen = Material::Mask {
        nested: MaterialId(0),
        opacity: Parameter::Constant(0.3),
    };
    let at = |x: f32, y: f32| placed(Vec3::new(x, y, 0.8), Quat::IDENTITY, 0.5);
    room.add(Primitive::Rectangle, at(-0.6, -0.3), pane, None);
    room.add(Primitive::Rectangle, at(0.6, -0.3), screen, None);
    let hair = Bsdf::Hair(Hair {
        fiber: Fiber::new(1.55, 0.3, 0.3, 0.03),
        sigma_a: Vec3::new(0.1, 0.2, 0.4),
    });
    let standing = placed(Vec3::new(0.0, -0.8, 0.9), Quat::from_rotation_x(-1.5), 0.2);
    room.add(Primitive::Cylinder, standing, hair, None);
    room.light(LightSource::Point {
        position: Vec3::new(-0.5, 0.8, 2.0),
        intensity: Vec3::splat(4.0),
    });
    room.light(LightSource::Constant {
        radiance: Vec3::new(0.1, 0.2, 0.3),
    });
    room.build()
}

fn with_lamp() -> RenderScene {
    let mut room = room();
    let up = Quat::from_rotation_x(std::f32::consts::FRAC_PI_2);
    room.add(
        Primitive::Rectangle,
        placed(Vec3::new(0.2, 1.5, 0.5), up, 0.5),
        diffuse([0.2, 0.2, 0.2]),
        Some(Vec3::new(9.0, 8.0, 7.0)),
    );
    room.build()
}

fn under_an_even_sky() -> RenderScene {
    let mut room = room();
    room.light(LightSource::Constant {
        radiance: Vec3::new(0.5, 0.6, 0.7),
    });
    room.build()
}

fn with_many_lights() -> RenderScene {
    let mut room = room();
    room.add(
        Primitive::Sphere,
        placed(Vec3::new(1.0, 1.0, 0.5), Quat::IDENTITY, 0.2),
        diffuse([0.2, 0.2, 0.2]),
        Some(Vec3::new(9.0, 8.0, 7.0)),
    );
    room.light(LightSource::Point {
        position: Vec3::new(-1.0, 1.0, 1.0),
        intensity: Vec3::splat(2.0),
    });
    room.light(LightSource::Constant {
        radiance: Vec3::new(0.1, 0.2, 0.3),
    });
    room.build()
}

/// Rectangles and spheres of different sizes, and a point.
fn with_seven_lamps() -> RenderScene {
    let mut room = room();
    let up = Quat::from_rotation_x(std::f32::consts::FRAC_PI_2);
    for lamp in 0..6 {
        let (x, size) = (0.5 * lamp as f32 - 1.3, 0.05 + 0.03 * lamp as f32);
        let (shape, turn) = match lamp % 2 {
            0 => (Primitive::Rectangle, up),
            _ => (Primitive::Sphere, Quat::IDENTITY),
        };
        let light = Vec3::new(4.0, 2.0 + lamp as f32, 9.0 - lamp as f32);
        room.add(
            shape,
            placed(Vec3::new(x, 1.5, 0.3), turn, size),
            diffuse([0.2; 3]),
            Some(light),
        );
    }
    room.light(LightSource::Point {
        position: Vec3::new(-1.0, 1.0, 1.0),
        intensity: Vec3::splat(2.0),
    });
    room.build()
}

fn settings(max_depth: u32, rr_depth: u32, hide_emitters: bool, strategy: Strategy) -> PathSettings {
    PathSettings {
        max_depth,
        rr_depth,
        hide_emitters,
        strategy,
        media: false,
    }
}

fn look(settings: PathSettings, sequence: SequenceKind) -> View {
    let camera = camera(Vec3::new(0.0, 0.3, 4.0), Vec3::new(0.0, -0.2, 0.0), 45.0);
    View {
        integrator: Integrator::Path(settings),
        sequence,
        ..view(camera, SIZE, settings.max_depth, settings.strategy)
    }
}

/// Pixels that may differ: where rounding sends a path elsewhere, after many a bounce off balls.
const STRAYS: usize = (SIZE * SIZE) as usize / 100;

fn compare(what: &str, scene: &RenderScene, view: &View) {
    let settings = view.integrator.settings();
    let (mut strays, mut rays, mut expected_rays) = (0, 0, 0);
    for tile in tiles(SIZE, SIZE) {
        let found = render_tile(scene, view, tile, 0..SAMPLES, &AtomicBool::new(false)).expect("not cancelled");
        assert_eq!(found.invalid, 0, "{what}");
        rays += found.rays;
        let places =
            (tile.y..tile.y + tile.height).flat_map(|y| (tile.x..tile.x + tile.width).map(move |x| UVec2::new(x, y)));
        for (number, (place, pixel)) in places.zip(&found.pixels).enumerate() {
            let mut sums = [Vec3::ZERO; 3];
            let mut depth = 0.0;
            for index in 0..SAMPLES {
                let begin = view.camera_sample(place, index);
                let sample = trace_path(scene, &settings, begin.ray, begin.sampler, view.medium, &mut ());
                expected_rays += u64::from(sample.rays);
                sums[0] += sample.radiance * begin.weight;
                sums[1] += sample.albedo;
                sums[2] += sample.normal;
                depth += sample.depth;
                if index == 0 {
                    let instance = sample.first_hit.map(|hit| hit.instance);
                    assert_eq!(
                        found.first_hits[number].map(|hit| hit.instance),
                        instance,
                        "{what} at {place}"
                    );
                }
            }
            assert!(
                (pixel.depth - depth).abs() <= 1e-5 * depth,
                "{what}: camera rays are the same, at {place}"
            );
            let mut pairs = sums.into_iter().zip([pixel.radiance, pixel.albedo, pixel.normal]);
            let is_near = |(a, b): (Vec3, Vec3)| a.abs_diff_eq(b, 1e-3 * a.abs().max_element() + 1e-4);
            strays += usize::from(!pairs.all(is_near));
        }
    }
    assert!(strays <= STRAYS, "{what}: {strays} pixels differ");
    let difference = rays.abs_diff(expected_rays);
    assert!(
        difference * 1000 <= expected_rays,
        "{what}: {rays} rays, {expected_rays}"
    );
}

#[test]
fn pictures_are_those_of_paths_one_by_one() {
    let scenes = [
        ("one lamp", with_lamp()),
        ("an even sky", under_an_even_sky()),
        ("many lights", with_many_lights()),
        ("seven lamps", with_seven_lamps()),
        ("panes", behind_panes()),
    ];
    for (what, scene) in &scenes {
        for strategy in [Strategy::Mis, Strategy::Light, Strategy::Bsdf] {
            compare(what, scene, &look(settings(8, 5, false, strategy), SequenceKind::Sobol));
        }
        let endless = settings(u32::MAX, 1, false, Strategy::Mis);
        compare(what, scene, &look(endless, SequenceKind::Independent));
        for (max_depth, hide_emitters) in [(2, true), (8, true), (1, false), (0, false)] {
            let short = settings(max_depth, 5, hide_emitters, Strategy::Mis);
            compare(what, scene, &look(short, SequenceKind::Sobol));
        }
    }
}

/// A ball of fog and a ball of glass around a medium of this albedo, under a lamp, in thin haze or in empty space.
/// Where the glass scatters light, the lamp is the only light; else there is a sky.
fn with_media(haze: bool, albedo: f32) -> RenderScene {
    let fog = |sigma_t: [f32; 3], albedo: f32, phase: Phase| MediumSource {
        sigma_t: Volume::Constant(Vec3::from(sigma_t)),
        scale: 1.0,
        albedo: Volume::Constant(Vec3::splat(albedo)),
        emission: Volume::ZERO,
        phase,
    };
    let mut scene = SceneBuilder::with_media(vec![
        fog([0.05, 0.1, 0.15], 0.9, Phase::Rayleigh),
        fog([1.0, 2.0, 3.0], 0.8, Phase::HenyeyGreenstein { g: 0.6 }),
        fog([3.0, 1.0, 2.0], albedo, Phase::Isotropic),
    ]);
    let exterior = haze.then_some(MediumId(0));
    let down = Quat::from_rotation_x(-std::f32::consts::FRAC_PI_2);
    scene.add(
        Primitive::Rectangle,
        placed(Vec3::NEG_Y, down, 3.0),
        diffuse([0.5, 0.6, 0.7]),
        None,
    );
    let glass = Bsdf::Dielectric(Dielectric {
        eta: 1.5,
        model: DielectricModel::Exact,
        specular_reflectance: Vec3::ONE,
        specular_transmittance: Vec3::ONE,
    });
    for (x, material, medium) in [(-0.8, Material::Null, 1), (0.8, glass.into(), 2)] {
        let place = placed(Vec3::new(x, -0.3, 0.0), Quat::IDENTITY, 0.7);
        scene.add(Primitive::Sphere, place, material, None);
        scene.between(MediumInterface {
            interior: Some(MediumId(medium)),
            exterior,
        });
    }
    let up = Quat::from_rotation_x(std::f32::consts::FRAC_PI_2);
    let lamp = placed(Vec3::new(0.0, 2.0, 0.5), up, 0.5);
    scene.add(
        Primitive::Rectangle,
        lamp,
        diffuse([0.2; 3]),
        Some(Vec3::new(9.0, 8.0, 7.0)),
    );
    if albedo == 0.0 {
        scene.light(LightSource::Constant {
            radiance: Vec3::new(0.1, 0.2, 0.3),
        });
    }
    scene.build()
}

#[test]
fn pictures_with_media_are_those_of_paths_one_by_one() {
    for (haze, albedo) in [(false, 0.0), (true, 0.0), (true, 0.8)] {
        let scene = with_media(haze, albedo);
        for strategy in [Strategy::Mis, Strategy::Light, Strategy::Bsdf] {
            for max_depth in [1, 2, 3, u32::MAX] {
                let mut settings = settings(max_depth, 5, false, strategy);
                settings.media = true;
                let mut view = look(settings, SequenceKind::Sobol);
                view.medium = haze.then_some(MediumId(0));
                compare(
                    &format!("haze {haze}, albedo {albedo}, {strategy:?}, {max_depth}"),
                    &scene,
                    &view,
                );
            }
        }
    }
}

/// Each model over most of the picture, so that no stray pixels could hide it.
#[test]
fn every_other_model_is_that_of_paths_one_by_one() {
    let mut tables = ShadingTables::default();
    let models = others(&mut tables);
    for (number, model) in models.into_iter().enumerate() {
        let mut scene = SceneBuilder::with_textures(squares());
        scene.tables = tables.clone();
        let down = Quat::from_rotation_x(-std::f32::consts::FRAC_PI_2);
        let floor = placed(Vec3::NEG_Y, down, 3.0);
        scene.add(Primitive::Rectangle, floor, diffuse([0.5, 0.6, 0.7]), None);
        let away = placed(Vec3::new(0.0, -90.0, 0.0), down, 1.0);
        for plain in [
            diffuse([0.1, 0.2, 0.3]),
            Bsdf::Conductor(Conductor { specular: gold() }),
        ] {
            scene.add(Primitive::Disk, away, plain, None);
        }
        scene.add(Primitive::Sphere, placed(Vec3::ZERO, Quat::IDENTITY, 0.9), model, None);
        scene.light(LightSource::Point {
            position: Vec3::new(1.0, 1.5, 2.0),
            intensity: Vec3::splat(3.0),
        });
        scene.light(LightSource::Constant {
            radiance: Vec3::new(0.1, 0.2, 0.3),
        });
        let scene = scene.build();
        for max_depth in [2, 3] {
            let short = settings(max_depth, 5, false, Strategy::Mis);
            compare(&format!("model {number}"), &scene, &look(short, SequenceKind::Sobol));
        }
    }
}

#[test]
fn any_camera_and_filter_will_do() {
    let scene = with_lamp();
    let plain = look(settings(3, 5, false, Strategy::Mis), SequenceKind::Sobol);
    let place = Affine3A::from_rotation_translation(Quat::from_rotation_y(std::f32::consts::PI), Vec3::Z * 4.0);
    let lens = ThinLens {
        aperture_radius: 0.1,
        focus_distance: 4.0,
        blades: 0,
        blade_rotation: 0.0,
    };
    let cameras = [
        plain.camera.cropped(Vec2::new(0.2, 0.3), Vec2::new(0.9, 0.8)),
        Camera::new(place, 40.0, 1.0, 0.1, 100.0, Some(lens)),
        Camera::orthographic(place, Vec2::splat(1.5), 0.1, 100.0),
    ];
    for camera in cameras {
        compare(
            "a camera",
            &scene,
            &View {
                camera,
                ..plain.clone()
            },
        );
    }
    let with_negative_lobes = PixelFilter::tabulated(FilterKernel::CATMULL_ROM);
    for filter in [PixelFilter::Tent { radius: 1.0 }, with_negative_lobes] {
        compare(
            "a filter",
            &scene,
            &View {
                filter,
                ..plain.clone()
            },
        );
    }
}

/// A rough gold sphere of waves on a floor, both of many triangles.
fn meshes() -> RenderScene {
    let mut scene = SceneBuilder::default();
    let blas = |mesh: MeshData| Primitive::Mesh(Arc::new(Blas::build(Arc::new(mesh), SplitMethod::Sah)));
    let rough = Bsdf::RoughConductor(RoughConductor {
        specular: gold(),
        distribution: Microfacet::new(MicrofacetKind::Ggx, 0.2, 0.2),
        multiple_scattering: Compensation::NONE,
    });
    let floor: Vec<[Vec3; 3]> = (0..60 * 60)
        .flat_map(|cell| {
            let corner = |dx: i32, dz: i32| {
                Vec3::new(
                    (cell % 60 + dx) as f32 / 10.0 - 3.0,
                    -1.0,
                    (cell / 60 + dz) as f32 / 10.0 - 3.0,
                )
            };
            let (a, b, c, d) = (corner(0, 0), corner(0, 1), corner(1, 1), corner(1, 0));
            [[a, b, c], [a, c, d]]
        })
        .collect();
    scene.add(
        blas(wavy_sphere(60)),
        Affine3A::from_scale(Vec3::splat(0.8)),
        rough,
        None,
    );
    scene.add(triangle_mesh(floor), Affine3A::IDENTITY, diffuse([0.6, 0.5, 0.4]), None);
    scene.light(LightSource::Constant {
        radiance: Vec3::new(0.6, 0.8, 1.0),
    });
    scene.build()
}

const SAMPLES_TOGETHER: u32 = 40;

/// Whatever the tile, and whatever else is traced beside it, a sample is the same.
#[test]
fn samples_do_not_depend_on_their_neighbours() {
    let view = look(settings(8, 5, false, Strategy::Mis), SequenceKind::Sobol);
    let go = AtomicBool::new(false);
    for scene in [with_lamp(), meshes()] {
        let tile = tiles(SIZE, SIZE)[0];
        let preview = render_preview(&scene, &view, tile, 4, &go).expect("not cancelled");
        let whole = render_tile(&scene, &view, tile, 0..1, &go).expect("not cancelled");
        for (number, block) in preview.blocks.iter().enumerate() {
            let (x, y) = (number as u32 % 8 * 4 + 2, number as u32 / 8 * 4 + 2);
            assert_eq!(*block, whole.pixels[(y * tile.width + x) as usize], "block {number}");
        }
        for tile in tiles(SIZE, SIZE) {
            let together = render_tile(&scene, &view, tile, 0..SAMPLES_TOGETHER, &go).expect("not cancelled");
            let mut sums = vec![Vec3::ZERO; together.pixels.len()];
            for sample in 0..SAMPLES_TOGETHER {
                let one = render_tile(&scene, &view, tile, sample..sample + 1, &go).expect("not cancelled");
                sums.iter_mut()
                    .zip(&one.pixels)
                    .for_each(|(sum, pixel)| *sum += pixel.radiance);
            }
            let together: Vec<Vec3> = together.pixels.iter().map(|pixel| pixel.radiance).collect();
            assert!(sums == together && sums.iter().any(|sum| *sum != Vec3::ZERO));
        }
    }
}
