//! What is given to the inspector: one of each kind, and values that no control can show exactly.

use bevy::math::{Affine2, Affine3A, Mat3A, UVec3, Vec3};
use sunroom::app::editor::command::media::MediumSide;
use sunroom::app::editor::model::{Inspected, InspectedGrid, InspectedMaterial, InspectedMedium, MaterialPlace};
use sunroom::color::Rgb;
use sunroom::math::Aabb;
use sunroom::scene::{
    Coefficients, ConductorIor, Cone, Crop, Distribution, Emitter, EmitterKind, FieldOfView, Film, FovAxis, GridFile,
    Ior, Lens, Material, Medium, Parameter, PhaseBlend, PhaseFunction, PlaceAndTime, ReconstructionFilter, Roughness,
    Sensor, Shape, ShapeKind, SquarePath, SunPosition, SunSky, Texture, VolumeParameter,
};

use super::{entity, light};

pub fn with_material(material: Material) -> Inspected {
    Inspected {
        materials: vec![InspectedMaterial {
            entity: entity(7),
            name: "paint".into(),
            material: material.into(),
            place: MaterialPlace::Whole,
            path: Vec::new(),
            mixed: Default::default(),
            users: 1,
            inside: Vec::new(),
        }],
        ..Inspected::new(entity(7), "paint")
    }
}

/// Values that no control can show exactly.
pub fn awkward() -> Vec<Inspected> {
    let nothing = Inspected::new(entity(7), "it");
    let sheared = Mat3A::from_cols(Vec3::X.into(), Vec3::new(0.3, 2.0, 0.0).into(), Vec3::Z.into());
    let third = Rgb::new(1.0 / 3.0, 0.123_456_79, 1.7);
    let materials = [
        Material::Diffuse {
            reflectance: third.into(),
        },
        Material::Metal {
            reflectance: third.into(),
            fuzz: 1.234_567.into(),
        },
        Material::RoughConductor {
            distribution: Distribution::Ggx,
            ior: ConductorIor::Named("unobtainium".into()),
            specular_reflectance: third.into(),
            alpha: Roughness::Anisotropic {
                u: 3.3.into(),
                v: 1e-5.into(),
            },
            multiple_scattering: true,
        },
        Material::Conductor {
            ior: ConductorIor::Given {
                eta: third.into(),
                k: (-third).into(),
            },
            specular_reflectance: third.into(),
        },
        Material::Dielectric {
            interior: Ior::Number(7.654_321),
            exterior: Ior::Named("mud".into()),
            specular_reflectance: third.into(),
            specular_transmittance: third.into(),
        },
        Material::TwoSided,
    ];
    let mut cases: Vec<Inspected> = materials.into_iter().map(with_material).collect();
    cases.extend([
        Inspected {
            to_world: Some(Affine3A {
                matrix3: sheared,
                translation: Vec3::splat(1e7 / 3.0).into(),
            }),
            shape: Some(Shape {
                kind: ShapeKind::Sphere {
                    center: third,
                    radius: -2.0,
                },
                flip_normals: true,
                ..Shape::default()
            }),
            area_light: Some(light(Rgb::new(1e5 / 3.0, 7.0, 0.0))),
            uses_material: Some(entity(99)),
            ..nothing.clone()
        },
        Inspected {
            to_world: Some(
                Affine3A::from_rotation_x(0.123_456_7) * Affine3A::from_scale(Vec3::new(-1e-3, 3e3, 1.0 / 3.0)),
            ),
            emitter: Some(EmitterKind::Point { intensity: Rgb::ZERO }.into()),
            ..nothing.clone()
        },
        Inspected {
            sensor: Some(Sensor {
                fov: 179.876_54,
                near_clip: 0.0,
                lens: Lens::Thin {
                    aperture_radius: 1e4,
                    focus_distance: 0.0,
                    blades: 7,
                    blade_rotation: -1e5,
                },
                ..Sensor::default()
            }),
            film: Some(Film {
                width: 3,
                height: 100_000,
                crop: Some(Crop {
                    x: 5,
                    y: 0,
                    width: 0,
                    height: 7,
                }),
                filter: ReconstructionFilter::Mitchell { b: 3.0, c: -3.0 },
                sample_count: 0,
                noise_target: Some(0.1),
                ..Film::default()
            }),
            emitter: Some(EmitterKind::Directional { irradiance: third }.into()),
            ..nothing
        },
    ]);
    cases.extend(media());
    cases.extend(awkward_lights().into_iter().map(|emitter| Inspected {
        to_world: Some(Affine3A::from_rotation_z(0.3)),
        emitter: Some(emitter),
        ..Inspected::new(entity(8), "lamp")
    }));
    cases
}

/// Out of every range there is.
fn awkward_lights() -> Vec<Emitter> {
    let slide = Texture::of_picture("/pictures/slide.png".into(), None);
    let sky = SunSky {
        turbidity: 1e3,
        albedo: Rgb::splat(7.0 / 3.0),
        sun: SunPosition::Direction(Vec3::new(1e6 / 3.0, 0.0, -1e-6)),
        sun_aperture: 400.0,
        ..SunSky::default()
    };
    let at = PlaceAndTime {
        latitude: 123.456_79,
        month: 77,
        hour: -1e7 / 3.0,
        ..PlaceAndTime::default()
    };
    let kinds = [
        EmitterKind::Environment {
            picture: "/pictures/sky.exr".into(),
            scale: -1.0 / 3.0,
            mis_compensation: false,
        },
        EmitterKind::Spot {
            intensity: Rgb::new(1e5 / 3.0, 0.0, 1e-9),
            cone: Cone {
                cutoff_angle: 179.0,
                beam_width: 1e3 / 3.0,
            },
            texture: Some(slide.clone()),
        },
        EmitterKind::Projector {
            irradiance: Parameter::Texture(slide),
            scale: 1e-7,
            field_of_view: FieldOfView {
                fov: 179.99,
                axis: FovAxis::Larger,
            },
        },
        EmitterKind::SunSky(sky),
        EmitterKind::SunSky(SunSky {
            sun: SunPosition::PlaceAndTime(at),
            ..sky
        }),
    ];
    let light = |kind| Emitter {
        kind,
        sampling_weight: -0.123_456,
    };
    kinds.map(light).to_vec()
}

pub fn textured(texture: Texture) -> Material {
    Material::Diffuse {
        reflectance: Parameter::Texture(texture),
    }
}

pub fn checkerboard() -> Texture {
    Texture::Checkerboard {
        color0: Box::new(Rgb::splat(0.4).into()),
        color1: Box::new(Parameter::Texture(Texture::of_picture("/pictures/a.png".into(), None))),
        to_uv: Box::new(Affine2::IDENTITY),
    }
}

/// Every plugin with its parameters constant, and once as textures.
pub fn every_inspected() -> Vec<Inspected> {
    let long = Texture::of_picture(
        "/pictures/a-picture-whose-name-is-much-too-long-for-the-panel.png".into(),
        None,
    );
    let mut cases: Vec<Inspected> = Vec::new();
    for plugin in Material::PLUGINS {
        let material = Material::of_plugin(plugin).expect("a plugin");
        let mut pictured = material.clone();
        for parameter in [
            "reflectance",
            "base_color",
            "roughness",
            "alpha",
            "height",
            "normalmap",
            "weight",
        ] {
            pictured.set_picture(
                parameter,
                SquarePath::WHOLE,
                &"/pictures/a-long-name-of-a-file.exr".into(),
            );
        }
        cases.extend([with_material(material), with_material(pictured)]);
    }
    cases.push(with_material(textured(long.clone())));
    cases.push(with_material(textured(checkerboard())));
    for plugin in Emitter::PLUGINS {
        let mut emitter = Emitter::of_plugin(plugin).expect("a plugin");
        let case = |emitter: &Emitter| Inspected {
            to_world: Some(Affine3A::from_rotation_y(0.5)),
            emitter: Some(emitter.clone()),
            ..Inspected::new(entity(8), "lamp")
        };
        cases.push(case(&emitter));
        emitter.set_picture(SquarePath::WHOLE, "/pictures/a-long-name-of-a-file.exr".into());
        cases.push(case(&emitter));
    }
    cases.extend(media());
    cases.push(Inspected {
        shape: Some(Shape::default()),
        area_light: Some(light(Rgb::new(1234.5, 7.0, 0.125))),
        ..Inspected::new(entity(5), "lamp")
    });
    cases
}

pub fn with_medium(medium: Medium) -> Inspected {
    let mut grids = Vec::new();
    medium.for_each_grid(&mut |grid| {
        let content = InspectedGrid {
            resolution: UVec3::new(1234, 567, 8901),
            channels: 3,
            bounds: Some(Aabb {
                min: Vec3::ZERO,
                max: Vec3::ONE,
            }),
            world_from_local: Affine3A::IDENTITY,
        };
        grids.push((grid.path.clone(), Some(content)));
    });
    let mut media_at = [None; 3];
    media_at[MediumSide::Interior as usize] = Some(entity(9));
    Inspected {
        shape: Some(Shape::default()),
        media_at,
        media: vec![InspectedMedium {
            entity: entity(9),
            name: "fog of a name that is too long for the panel".into(),
            medium: medium.into(),
            side: Some(MediumSide::Interior),
            mixed: Default::default(),
            users: 2,
            boxes: Vec::new(),
            grids,
        }],
        leak: Some("12345 edges of its mesh have no triangle on their other side.".to_owned()),
        ..Inspected::new(entity(5), "box")
    }
}

/// Media of all forms, with values that no control can show exactly.
fn media() -> Vec<Inspected> {
    let third = Rgb::new(1.0 / 3.0, 1e-7, 1e5 / 3.0);
    let grid = VolumeParameter::Grid(GridFile {
        path: "/volumes/a-file-whose-name-is-much-too-long-for-the-panel.vol".into(),
        to_world: Affine3A::from_rotation_y(0.3) * Affine3A::from_scale(Vec3::new(1.0 / 3.0, 7e4, 1e-3)),
        ..GridFile::default()
    });
    let boxed = VolumeParameter::Box {
        value: third,
        to_world: Affine3A::from_scale(Vec3::splat(1.0 / 3.0)),
    };
    let of = |sigma_t: VolumeParameter<Rgb>| Coefficients::Extinction {
        sigma_t,
        albedo: third.min(Rgb::ONE).into(),
    };
    let separate = Coefficients::Separate {
        sigma_s: third,
        sigma_a: Rgb::ZERO,
    };
    let coefficients = [of(third.into()), of(grid), of(boxed), separate];
    let table = PhaseFunction::Tabulated {
        values: vec![1.0 / 3.0; 77],
    };
    let blend = PhaseBlend {
        of: [PhaseFunction::HenyeyGreenstein { g: 0.123_456_7 }, table.clone()],
        ..PhaseBlend::default()
    };
    let phases = [
        PhaseFunction::HenyeyGreenstein { g: -1.0 / 3.0 },
        PhaseFunction::Rayleigh,
        table,
        PhaseFunction::Blend(blend.into()),
    ];
    let all = coefficients
        .into_iter()
        .zip(phases)
        .map(|(coefficients, phase)| Medium {
            coefficients,
            phase,
            scale: 1.234_567_8,
            emission: third.into(),
            emission_scale: 1.0 / 3.0,
        });
    all.map(with_medium).collect()
}
