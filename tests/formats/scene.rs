//! Scene files as descriptions and as entities: what is read, what is warned of, what is written back.

use std::path::Path;
use std::time::{Duration, Instant};

use bevy::math::Affine3A;
use bevy::prelude::*;
use sunroom::document::{self, Diagnostics, TransformOp};
use sunroom::layer::{Layer, Layers};
use sunroom::scene::description::DeclarationPlace;
use sunroom::scene::read::read;
use sunroom::scene::write::{gather, save_description, to_document};
use sunroom::scene::{Material, *};

use crate::meaning::meaning;

fn describe_at(text: &str, path: &Path) -> (SceneDescription, Diagnostics) {
    let mut document = document::parse_str(text, path, &[]);
    let scene = read(&mut document);
    (scene, document.diagnostics)
}

fn describe(body: &str) -> (SceneDescription, Diagnostics) {
    let text = format!("<scene version=\"3.0.0\">\n{body}\n</scene>");
    describe_at(&text, &std::env::temp_dir().join("scene.xml"))
}

/// The description of a scene that has nothing to complain of, once it has a sensor.
fn clean(body: &str) -> SceneDescription {
    let (scene, diagnostics) = describe(&format!("{body}<sensor type=\"perspective\"/>"));
    assert!(diagnostics.list.is_empty(), "{diagnostics}");
    scene
}

/// "line: severity: message" of everything about the body, whose first line is 2.
fn complaints(body: &str) -> Vec<String> {
    let (_, diagnostics) = describe(&format!("{body}<sensor type=\"perspective\"/>"));
    let line = |d: &document::Diagnostic| {
        d.span
            .and_then(|span| diagnostics.locate(span))
            .map_or(0, |place| place.1)
    };
    let list = diagnostics.list.iter();
    list.map(|d| format!("{}: {}: {}", line(d), d.severity, d.message))
        .collect()
}

fn material(body: &str) -> Material {
    clean(body).materials[0].material.clone()
}

#[test]
fn defaults_are_those_of_the_format() {
    let scene = clean("");
    let sensor = &scene.sensors[0];
    assert_eq!(sensor.sensor.fov_axis, FovAxis::Diagonal);
    // 50 mm before a frame of 36 x 24 mm.
    assert!((sensor.sensor.fov - 46.793).abs() < 1e-3, "{}", sensor.sensor.fov);
    assert_eq!((sensor.sensor.near_clip, sensor.sensor.far_clip), (1e-2, 1e4));
    assert_eq!(
        (sensor.film.width, sensor.film.height, sensor.film.sample_count),
        (768, 576, 4)
    );
    assert_eq!(sensor.film.filter, ReconstructionFilter::Gaussian { stddev: 0.5 });
    assert_eq!(scene.integrator, IntegratorSettings::default());

    assert_eq!(
        material("<bsdf type='diffuse'/>"),
        Material::Diffuse {
            reflectance: Vec3::splat(0.5).into()
        }
    );
    assert_eq!(
        material("<bsdf type='conductor'/>"),
        Material::Conductor {
            ior: ConductorIor::Named("none".into()),
            specular_reflectance: Vec3::ONE.into()
        }
    );
    assert_eq!(
        material("<bsdf type='dielectric'/>"),
        Material::Dielectric {
            interior: Ior::Named("bk7".into()),
            exterior: Ior::Named("air".into()),
            specular_reflectance: Vec3::ONE.into(),
            specular_transmittance: Vec3::ONE.into(),
        }
    );
    assert_eq!(
        material("<bsdf type='roughconductor'><string name='distribution' value='ggx'/></bsdf>"),
        Material::RoughConductor {
            distribution: Distribution::Ggx,
            ior: ConductorIor::Named("none".into()),
            specular_reflectance: Vec3::ONE.into(),
            alpha: Roughness::Isotropic(0.1.into()),
            multiple_scattering: false,
        }
    );
    assert_eq!(
        material("<bsdf type='hair'/>"),
        Material::Hair {
            absorption: Absorption::Melanin {
                eumelanin: 1.3,
                pheomelanin: 0.2,
            },
            longitudinal_roughness: 0.3,
            azimuthal_roughness: 0.3,
            scale_tilt: 2.0,
            interior: Ior::Named("amber".into()),
            exterior: Ior::Named("air".into()),
        }
    );
    let scene = clean("<shape type='sphere'/><emitter type='point'/>");
    assert_eq!(
        scene.shapes[0].shape.kind,
        ShapeKind::Sphere {
            center: Vec3::ZERO,
            radius: 1.0
        }
    );
    assert_eq!(scene.shapes[0].to_world, Affine3A::IDENTITY);
    assert_eq!(scene.shapes[0].material, None);
    assert_eq!(
        scene.emitters[0].emitter,
        EmitterKind::Point { intensity: Vec3::ONE }.into()
    );
}

#[test]
fn parameters_are_read() {
    let scene = clean(
        "<integrator type='path'><integer name='maxDepth' value='7'/><integer name='rr_depth' value='3'/>
           <boolean name='hide_emitters' value='true'/></integrator>
         <sensor type='thinlens'><float name='fov' value='20'/><string name='fovAxis' value='smaller'/>
           <float name='aperture_radius' value='0.2'/><float name='focusDistance' value='6'/>
           <transform name='toWorld'><lookat origin='0,0,5' target='0,0,0' up='0,1,0'/></transform>
           <film type='hdrfilm'><integer name='width' value='320'/><integer name='height' value='200'/><rfilter type='box'/>
             <string name='pixel_format' value='rgb'/></film>
           <sampler type='multijitter'><integer name='sample_count' value='64'/><float name='noise_target' value='0.02'/><boolean name='adaptive' value='true'/></sampler></sensor>
         <shape type='sphere' id='ball'><point name='center' x='1' y='2' z='3'/><float name='radius' value='4'/>
           <boolean name='flip_normals' value='true'/>
           <bsdf type='metal'><rgb name='reflectance' value='0.1,0.2,0.3'/><float name='fuzz' value='0.25'/></bsdf>
           <emitter type='area'><rgb name='radiance' value='5'/></emitter></shape>
         <emitter type='directional'><vector name='direction' x='0' y='-2' z='0'/><rgb name='irradiance' value='1,2,3'/></emitter>",
    );
    assert_eq!((scene.integrator.max_depth, scene.integrator.rr_depth), (Some(7), 3));
    assert!(scene.integrator.hide_emitters);
    let sensor = &scene.sensors[0];
    assert_eq!(
        sensor.sensor.lens,
        Lens::Thin {
            aperture_radius: 0.2,
            focus_distance: 6.0,
            blades: 0,
            blade_rotation: 0.0,
        }
    );
    assert_eq!((sensor.sensor.fov, sensor.sensor.fov_axis), (20.0, FovAxis::Smaller));
    assert_eq!(
        sensor.film,
        Film {
            width: 320,
            height: 200,
            crop: None,
            filter: ReconstructionFilter::Box,
            sample_count: 64,
            storage: FilmStorage {
                pixels: Some(PixelFormat::Rgb),
                components: None,
                file: None,
                compression: None,
            },
            noise_target: Some(0.02),
            adaptive: true,
        }
    );
    assert!(
        sensor
            .to_world
            .transform_vector3(Vec3::Z)
            .abs_diff_eq(Vec3::NEG_Z, 1e-6)
    );
    let ball = &scene.shapes[0];
    assert_eq!(ball.identity.id.as_deref(), Some("ball"));
    assert_eq!(
        ball.shape.kind,
        ShapeKind::Sphere {
            center: Vec3::new(1.0, 2.0, 3.0),
            radius: 4.0
        }
    );
    assert!(ball.shape.flip_normals);
    assert_eq!(
        ball.area_light,
        Some(AreaLight {
            radiance: Vec3::splat(5.0).into(),
            ..AreaLight::default()
        })
    );
    let inside = &scene.materials[ball.material.unwrap()];
    assert_eq!(
        inside.material,
        Material::Metal {
            reflectance: Vec3::new(0.1, 0.2, 0.3).into(),
            fuzz: 0.25.into()
        }
    );
    assert_eq!(inside.declared_in, DeclarationPlace::Shape(0));
    let sun = &scene.emitters[0];
    assert!(sun.to_world.transform_vector3(Vec3::Z).abs_diff_eq(Vec3::NEG_Y, 1e-6));
}

#[test]
fn hair_is_read_by_its_pigments_or_its_absorption() {
    let hair = |absorption| Material::Hair {
        absorption,
        longitudinal_roughness: 0.1,
        azimuthal_roughness: 0.3,
        scale_tilt: -3.0,
        interior: Ior::Named("amber".into()),
        exterior: Ior::Named("air".into()),
    };
    for (given, absorption) in [
        (
            "<float name='pheomelanin' value='0.5'/>",
            Absorption::Melanin {
                eumelanin: 1.3,
                pheomelanin: 0.5,
            },
        ),
        (
            "<rgb name='sigma_a' value='0.2, 0.3, 4'/><float name='scale' value='2'/>",
            Absorption::Given {
                sigma_a: Vec3::new(0.2, 0.3, 4.0).into(),
                scale: 2.0,
            },
        ),
    ] {
        let body = format!(
            "<bsdf type='hair'>{given}<float name='longitudinal_roughness' value='0.1'/>
             <float name='scale_tilt' value='-3'/></bsdf>"
        );
        assert_eq!(material(&body), hair(absorption));
        round_trip(&clean(&body), &std::env::temp_dir().join("hair.xml"));
    }
}

#[test]
fn transforms_apply_in_the_order_of_the_file() {
    let scene = clean(
        "<shape type='cube'><transform name='to_world'><scale value='2'/><translate x='1'/><rotate z='1' angle='90'/></transform></shape>",
    );
    // (1, 0, 0) -> (2, 0, 0) -> (3, 0, 0) -> (0, 3, 0)
    let moved = scene.shapes[0].to_world.transform_point3(Vec3::X);
    assert!(moved.abs_diff_eq(Vec3::new(0.0, 3.0, 0.0), 1e-5), "{moved}");
}

#[test]
fn materials_are_shared_by_reference_and_kept_in_the_order_of_the_file() {
    let scene = clean(
        "<shape type='sphere'><ref id='late'/></shape>
         <shape type='cube'><ref id='late'/></shape>
         <shape type='disk'><bsdf type='twosided'><bsdf type='conductor'/><ref id='late'/></bsdf></shape>
         <bsdf type='diffuse' id='late'/>",
    );
    let late = scene.shapes[0].material.unwrap();
    assert_eq!(scene.shapes[1].material, Some(late));
    assert_eq!(scene.materials[late].identity.id.as_deref(), Some("late"));
    assert_eq!(scene.materials[late].declared_in, DeclarationPlace::TopLevel);
    let two_sided = &scene.materials[scene.shapes[2].material.unwrap()];
    assert_eq!(two_sided.material, Material::TwoSided);
    assert_eq!(two_sided.second, Some(late));
    assert_eq!(scene.materials.len(), 3);
    assert!(scene.materials.is_sorted_by_key(|material| material.identity.order));
}

#[test]
fn what_is_not_supported_gets_a_stand_in_and_a_warning_with_its_line() {
    for (body, expected) in [
        (
            "<bsdf type='velvet' id='a'/>",
            "2: warning: bsdf `velvet` is not supported: grey `diffuse` takes its place",
        ),
        (
            "\n<shape type='sdfgrid'/>",
            "3: warning: shape `sdfgrid` is not supported: it is left out",
        ),
        (
            "<emitter type='sky'/>",
            "2: warning: emitter `sky` is not supported: it is left out",
        ),
        (
            "<integrator type='photonmapper'/>",
            "2: warning: integrator `photonmapper` is not supported: `path` takes its place",
        ),
        (
            "<integrator type='aov'>\n<string name='aovs' value='a:dp_du'/></integrator>",
            "3: warning: the layer `dp_du` is not supported: it is left out",
        ),
        (
            "<integrator type='aov'>\n<string name='aovs' value='a:dept'/></integrator>",
            "3: warning: there is no layer `dept`: it is left out",
        ),
        (
            "<integrator type='aov'/>",
            "2: warning: an `aov` without `aovs`, a list of layers such as `dd:depth,nn:sh_normal`, has none",
        ),
        (
            "<bsdf type='diffuse'>\n<texture type='volume' name='reflectance'/></bsdf>",
            "3: warning: texture `volume` is not supported",
        ),
        (
            "<bsdf type='diffuse'>\n\n<float name='roughness' value='1'/></bsdf>",
            "4: warning: `roughness` is not a parameter of bsdf `diffuse`",
        ),
        (
            "<bsdf type='diffuse'><rgb name='reflectance' value='1.5'/></bsdf>",
            "2: warning: `reflectance` is above 1: more light leaves than arrives",
        ),
    ] {
        assert_eq!(complaints(body), [expected], "{body}");
    }
    let (scene, diagnostics) = describe("");
    assert!(scene.sensors.is_empty());
    assert_eq!(diagnostics.warning_count(), 1, "{diagnostics}");
    // A sensor that cannot be read is not missing as well.
    for sensor in ["<sensor typ='perspective'/>", "<sensor type='perspective' id=/>"] {
        let (_, diagnostics) = describe(sensor);
        assert!(diagnostics.has_errors(), "{diagnostics}");
        assert!(!diagnostics.to_string().contains("no sensor"), "{diagnostics}");
    }
}

#[test]
fn a_ring_of_references_is_one_error_that_names_both_lines() {
    let (_, diagnostics) = describe(
        "<sensor type='perspective'/>\n<bsdf type='twosided' id='a'><ref id='b'/></bsdf>\n<bsdf type='mask' id='b'><ref id='a'/></bsdf>",
    );
    let said = diagnostics.to_string();
    assert_eq!(diagnostics.list.len(), 1, "{said}");
    assert!(said.contains("scene.xml:4:") && said.contains("scene.xml:3:"), "{said}");
    // A reference to nothing has no second error either.
    for body in [
        "<bsdf type='twosided'><ref id='a'/></bsdf>",
        "<shape type='instance'><ref id='a'/></shape>",
        "<bsdf type='bumpmap'><ref id='a'/><bsdf type='diffuse'/></bsdf>",
        "<bsdf type='normalmap'><ref id='a' name='normalmap'/><bsdf type='diffuse'/></bsdf>",
    ] {
        let (_, diagnostics) = describe(&format!("{body}<sensor type='perspective'/>"));
        assert_eq!(diagnostics.list.len(), 1, "{diagnostics}");
    }
}

#[test]
fn plugins_that_nobody_has_are_errors() {
    for (body, expected) in [
        ("<shape type='shpere'/>", "2: error: shape `shpere` is not known"),
        ("<emitter type='glow'/>", "2: error: emitter `glow` is not known"),
    ] {
        assert_eq!(complaints(body), [expected], "{body}");
    }
}

/// What a spectrum gives for the light of an emitter, for a reflectance, and for an index of refraction; None for an
/// error.
type Colors = [Option<[f32; 3]>; 3];

/// Each row: the inside of `<spectrum>`, and its colours in Mitsuba 3.9.1, variant `scalar_rgb`. Of `uniform`, `d65`,
/// `srgb` and `rawconstant` these are the values that `mi.traverse` shows of a loaded emitter and a loaded bsdf, and
/// that renders of a constant emitter and of a white furnace show too. That variant does not evaluate `regular`,
/// `irregular` and `blackbody`: their rows are what it makes of a `<spectrum value="...">` with the same wavelengths
/// and values, of a black body with its radiance at every quarter of a nanometre (`mi.spectrum_list_to_srgb`). Renders
/// of a constant `blackbody` emitter by `scalar_spectral` agree with these to 0.1 %.
#[rustfmt::skip]
fn spectra() -> Vec<(&'static str, Colors)> {
    let all = |color| [Some(color); 3];
    let light = |color| [Some(color), None, None];
    vec![
        ("type='uniform'><float name='value' value='0.5'/>", all([0.5; 3])),
        ("type='uniform'><float name='value' value='1'/><float name='wavelength_min' value='400'/><float name='wavelength_max' value='700'/>", all([1.0; 3])),
        ("type='d65'>", all([1.0; 3])),
        ("type='d65'><float name='scale' value='0.5'/>", all([0.5; 3])),
        ("type='d65'><rgb name='color' value='0.4, 0.2, 0.1'/><float name='scale' value='2'/>", all([0.8, 0.4, 0.2])),
        ("type='srgb'><rgb name='color' value='0.8, 0.2, 0.1'/>", all([0.8, 0.2, 0.1])),
        ("type='srgb'><rgb name='color' value='1.5, 0.2, 0.1'/>", [None; 3]),
        ("type='srgb'><rgb name='color' value='-0.5, 0.2, 0.1'/>", [None; 3]),
        ("type='rawconstant'><vector name='value' value='0.8, 0.2, 0.1'/>", all([0.8, 0.2, 0.1])),
        ("type='rawconstant'><float name='value' value='0.25'/>", all([0.25; 3])),
        ("type='rawconstant'><rgb name='value' value='1, 1, 1'/>", [None; 3]),
        ("type='regular'><float name='wavelength_min' value='400'/><float name='wavelength_max' value='700'/><string name='values' value='0.1, 0.2, 0.9'/>",
            [Some([0.683_862_75, 0.198_951_24, 0.103_903_49]), Some([0.588_794_77, 0.209_877_39, 0.118_282_69]), Some([0.588_794_77, 0.209_877_39, 0.118_282_69])]),
        ("type='irregular'><string name='wavelengths' value='400, 500, 700'/><string name='values' value='0.1, 0.2, 0.9'/>",
            [Some([0.815_080_1, 0.325_279_27, 0.105_921_66]), Some([0.702_162_74, 0.340_679_6, 0.122_438_53]), Some([0.702_162_74, 0.340_679_6, 0.122_438_53])]),
        ("type='irregular'><string name='wavelengths' value='380 480 580 680 780'/><string name='values' value='0.05 0.1 0.6 0.7 0.7'/>",
            [Some([0.872_478_2, 0.391_267_96, 0.035_262_54]), Some([0.755_955_76, 0.407_203_6, 0.045_403_46]), Some([0.755_955_76, 0.407_203_6, 0.045_403_46])]),
        ("type='regular'><float name='wavelength_min' value='360'/><float name='wavelength_max' value='830'/><string name='values' value='2, 4'/>",
            [Some([3.820_851_6, 2.637_766_6, 2.118_213]), Some([1.0; 3]), Some([3.198_560_5, 2.775_591_4, 2.341_143_6])]),
        ("type='irregular'><string name='wavelengths' value='450, 500'/><string name='values' value='1, 0'/>",
            [Some([0.0, 0.002_625_2, 0.331_720_62]), Some([0.0, 0.002_267_68, 0.390_211_82]), Some([0.0, 0.002_267_68, 0.390_211_82])]),
        ("type='blackbody'><float name='temperature' value='2000'/>", light([16.014_284, 4.111_85, 0.130_394_58])),
        ("type='blackbody'><float name='temperature' value='2856'/>", light([499.216_98, 223.559_59, 63.195_35])),
        ("type='blackbody'><float name='temperature' value='5000'/>", light([15_262.982, 12_082.539, 9_592.563])),
        ("type='blackbody'><float name='temperature' value='6504'/>", light([44_014.74, 41_512.402, 43_718.316])),
        ("type='blackbody'><float name='temperature' value='10000'/>", light([158_407.84, 180_718.52, 260_026.69])),
        ("type='blackbody'><float name='temperature' value='5000'/><float name='wavelength_min' value='500'/><float name='wavelength_max' value='600'/>",
            light([3_607.296_4, 12_459.387, 0.0])),
    ]
}

/// Spectra inside of a `d65` as rows of [`spectra`]. The first column is what renders of a constant emitter by
/// Mitsuba's `scalar_spectral` show, whose `scalar_rgb` does not evaluate the spectra of wavelengths; there `scale`
/// counts. The others, and the rows of `uniform` and `d65`, are what `scalar_rgb` shows, or makes of the same spectrum
/// without the `d65`: reflectances are seen under D65 anyway.
#[rustfmt::skip]
fn spectra_inside_d65() -> Vec<(&'static str, Colors)> {
    let all = |color| [Some(color); 3];
    vec![
        ("type='d65'><spectrum type='irregular'><string name='wavelengths' value='400,500,600,700'/><string name='values' value='0.1,0.2,0.9,0.4'/></spectrum>",
            all([0.956, 0.4972, 0.1005])),
        ("type='d65'><spectrum type='irregular'><string name='wavelengths' value='400,500,600,700'/><string name='values' value='0.1,0.2,0.9,0.4'/></spectrum><float name='scale' value='0.5'/>",
            all([0.478, 0.2486, 0.05025])),
        ("type='d65'><spectrum type='regular'><float name='wavelength_min' value='400'/><float name='wavelength_max' value='700'/><string name='values' value='0.1, 0.3, 0.9, 0.2'/></spectrum>",
            all([0.8872, 0.5636, 0.1559])),
        ("type='d65'><spectrum type='blackbody'><float name='temperature' value='5000'/></spectrum>", [Some([12_683.4, 12_719.7, 10_654.4]), None, None]),
        ("type='d65'><spectrum type='uniform'><float name='value' value='0.4'/></spectrum>", all([0.4; 3])),
        ("type='d65'><spectrum type='d65'><float name='scale' value='0.5'/></spectrum>", all([0.5; 3])),
    ]
}

#[test]
fn spectra_are_the_colours_that_mitsuba_gives_them() {
    let contexts = [
        (
            "<shape type='disk'><emitter type='area'><spectrum name='radiance' ",
            "</spectrum></emitter></shape>",
        ),
        (
            "<bsdf type='diffuse'><spectrum name='reflectance' ",
            "</spectrum></bsdf>",
        ),
        (
            "<bsdf type='conductor'><float name='k' value='1'/><spectrum name='eta' ",
            "</spectrum></bsdf>",
        ),
    ];
    for (inside, expected) in spectra().into_iter().chain(spectra_inside_d65()) {
        for ((before, after), expected) in contexts.iter().zip(expected) {
            let body = format!("{before}{inside}{after}<sensor type='perspective'/>");
            let (scene, diagnostics) = describe(&body);
            assert_eq!(!diagnostics.has_errors(), expected.is_some(), "{body}: {diagnostics}");
            let Some(expected) = expected.map(Vec3::from) else {
                continue;
            };
            let found = match scene.shapes.first() {
                Some(shape) => shape.area_light.as_ref().map(|light| light.radiance.clone()),
                None => match &scene.materials[0].material {
                    Material::Diffuse { reflectance } => Some(reflectance.clone()),
                    Material::Conductor {
                        ior: ConductorIor::Given { eta, .. },
                        ..
                    } => Some(eta.clone()),
                    other => panic!("{other:?}"),
                },
            };
            let found = found.and_then(|found| found.constant()).expect("a colour");
            // The sums over the observer's tables differ in the fourth digit.
            let tolerance = 2e-3 * expected + 5e-4 * expected.max_element();
            let is_close = (found - expected).abs().cmple(tolerance).all();
            assert!(is_close, "{body}: {found}, not {expected}");
        }
    }
}

#[test]
fn spectra_stand_wherever_a_colour_or_a_number_may() {
    let scene = clean(
        "<spectrum type='d65' id='dim'><float name='scale' value='0.25'/></spectrum>
         <texture type='checkerboard' id='tiles'/>
         <emitter type='point'><ref id='dim' name='intensity'/></emitter>
         <emitter type='sunsky'><spectrum type='uniform' name='albedo'><float name='value' value='0.5'/></spectrum></emitter>
         <bsdf type='roughconductor'><texture type='uniform' name='alpha'><float name='value' value='0.125'/></texture></bsdf>
         <bsdf type='diffuse'><spectrum type='d65' name='reflectance'><ref id='tiles'/></spectrum></bsdf>",
    );
    let EmitterKind::Point { intensity } = scene.emitters[0].emitter.kind else {
        panic!("{:?}", scene.emitters[0])
    };
    assert_eq!(intensity, Vec3::splat(0.25));
    let EmitterKind::SunSky(sky) = &scene.emitters[1].emitter.kind else {
        panic!("{:?}", scene.emitters[1])
    };
    assert_eq!(sky.albedo, Vec3::splat(0.5));
    let Material::RoughConductor { alpha, .. } = &scene.materials[0].material else {
        panic!("{:?}", scene.materials[0])
    };
    assert_eq!(*alpha, Roughness::Isotropic(0.125.into()));
    let Material::Diffuse { reflectance } = &scene.materials[1].material else {
        panic!("{:?}", scene.materials[1])
    };
    assert!(
        matches!(reflectance, Parameter::Texture(Texture::Checkerboard { .. })),
        "{reflectance:?}"
    );
}

#[test]
fn what_is_wrong_with_a_spectrum_is_said_at_its_place() {
    for (inside, expected) in [
        ("type='uniform'>", "2: error: `uniform` needs a `value`"),
        (
            "type='blackbody'>\n<float name='temperature' value='-1'/>",
            "3: error: `temperature` is -1, but should be above 0",
        ),
        (
            "type='regular'>\n<string name='values' value='1, 2'/><float name='wavelength_max' value='700'/>",
            "2: error: `regular` needs a `wavelength_min`",
        ),
        (
            "type='irregular'><string name='wavelengths' value='400, 500'/>\n<string name='values' value='1'/>",
            "3: error: the number of wavelengths is 2, but the number of values is 1",
        ),
        (
            "type='irregular'><string name='wavelengths' value='500, 400'/>\n<string name='values' value='1, 2'/>",
            "3: error: wavelengths must increase",
        ),
        (
            "type='irregular'><string name='wavelengths' value='400, 500'/>\n<string name='values' value='1, x'/>",
            "3: error: expected a number, found `x`",
        ),
        (
            "type='srgb'>\n<rgb name='color' value='2, 0, 0'/>",
            "3: error: the `color` of `srgb` should be between 0 and 1",
        ),
        (
            "type='uniform'>\n<float name='value' value='-1'/>",
            "2: error: `radiance` is negative",
        ),
        (
            "type='d65'>\n<float name='sclae' value='1'/>",
            "3: warning: `sclae` is not a parameter of texture `d65`",
        ),
        ("type='d56'>", "2: warning: texture `d56` is not supported"),
    ] {
        let body = format!(
            "<shape type='disk'><emitter type='area'><spectrum name='radiance' {inside}</spectrum></emitter></shape>"
        );
        let said = complaints(&body);
        assert!(said.len() == 1 && said[0].starts_with(expected), "{body}: {said:?}");
    }
}

#[test]
fn what_cannot_be_is_an_error_with_its_line() {
    for (body, part) in [
        (
            "\n<bsdf type='roughconductor'><string name='distribution' value='ggx'/>\n<float name='alpha' value='-1'/></bsdf>",
            "4: error: `alpha` is -1",
        ),
        (
            "<shape type='sphere'><float name='radius' value='-1'/></shape>",
            "2: error: `radius` is -1",
        ),
        (
            "<shape type='cube'>\n<transform name='to_world'><scale x='1' y='0' z='1'/></transform></shape>",
            "3: error: `to_world` cannot be undone",
        ),
        (
            "<bsdf type='conductor'><string name='material' value='Xx'/></bsdf>",
            "2: error: `Xx` is not a known metal",
        ),
        (
            "<bsdf type='hair'><float name='eumelanin' value='1'/>\n<rgb name='sigma_a' value='1'/></bsdf>",
            "3: error: `sigma_a` and pigments exclude each other",
        ),
        (
            "<bsdf type='hair'><float name='azimuthal_roughness' value='1.5'/></bsdf>",
            "2: error: `azimuthal_roughness` is 1.5",
        ),
        (
            "<bsdf type='twosided'><bsdf type='hair'/></bsdf>",
            "2: error: `hair` has two sides already",
        ),
        (
            "<bsdf type='dielectric'><float name='int_ior' value='-3'/></bsdf>",
            "2: error: `int_ior` is -3, but should be above 0",
        ),
        (
            "<bsdf type='dielectric'><string name='int_ior' value='watr'/></bsdf>",
            "2: error: `watr` is not a known medium",
        ),
        (
            "<sensor type='perspective'><float name='fov' value='180'/></sensor>",
            "2: error: `fov` is 180",
        ),
        (
            "<sensor type='thinlens'/>",
            "2: error: `thinlens` needs an `aperture_radius`",
        ),
        (
            "<bsdf type='twosided'/>",
            "2: error: `twosided` takes one bsdf or two, found 0",
        ),
        (
            "<bsdf type='diffuse'><rgb name='reflectance' value='-0.5'/></bsdf>",
            "2: error: `reflectance` is -0.5",
        ),
        (
            "<emitter type='point'><rgb name='intensity' value='-1'/></emitter>",
            "2: error: `intensity` is negative",
        ),
        (
            "<sensor type='perspective'><film type='hdrfilm'><integer name='width' value='65536'/><integer name='height' value='65536'/></film></sensor>",
            "2: error: a film of 65536 x 65536 pixels is too large",
        ),
        (
            "<sensor type='perspective'><sampler type='independent'><integer name='sample_count' value='0'/></sampler></sensor>",
            "2: error: `sample_count` is 0",
        ),
        (
            "<sensor type='perspective'><sampler type='independent'><float name='noise_target' value='0'/></sampler></sensor>",
            "2: error: `noise_target` is 0",
        ),
        ("<shape type='obj'/>", "2: error: shape `obj` needs a `filename`"),
    ] {
        let list = complaints(body);
        assert!(list.len() == 1 && list[0].starts_with(part), "{body}: {list:?}");
    }
    // Tiny things are no flat things.
    clean("<shape type='cube'><transform name='to_world'><scale value='1e-12'/></transform></shape>");
}

/// As in Mitsuba 3.9.1, which takes a colour for a number where a texture may be.
#[test]
fn a_colour_for_a_number_is_its_mean() {
    let numbers = [
        ("mask", "opacity", 1),
        ("blendbsdf", "weight", 2),
        ("roughconductor", "alpha", 0),
        ("roughdielectric", "alpha", 0),
        ("roughplastic", "alpha", 0),
        ("principled", "roughness", 0),
        ("principled", "metallic", 0),
        ("principled", "anisotropic", 0),
        ("principled", "spec_trans", 0),
        ("principled", "spec_tint", 0),
        ("principled", "sheen", 0),
        ("principled", "sheen_tint", 0),
        ("principled", "flatness", 0),
        ("principled", "clearcoat", 0),
        ("principled", "clearcoat_gloss", 0),
        ("principledthin", "roughness", 0),
        ("principledthin", "diff_trans", 0),
        ("principledthin", "eta", 0),
        ("metal", "fuzz", 0),
    ];
    let colours = [
        "<rgb name='NAME' value='0.25, 0.5, 0.75'/>",
        "<spectrum name='NAME' value='0.5'/>",
        "<spectrum name='NAME' value='300:0.5, 900:0.5'/>",
        "<spectrum type='uniform' name='NAME'><float name='value' value='0.5'/></spectrum>",
        "<texture type='srgb' name='NAME'><rgb name='color' value='0.25, 0.5, 0.75'/></texture>",
    ];
    for (plugin, name, inside) in numbers {
        for colour in colours {
            let (given, nested) = (colour.replace("NAME", name), "<bsdf type='diffuse'/>".repeat(inside));
            let mut scene = clean(&format!("<bsdf type='{plugin}'>{given}{nested}</bsdf>"));
            // It is written anew then.
            scene.materials.iter_mut().for_each(|it| it.identity.authored = None);
            let text = document::to_xml(&to_document(&scene, Path::new("/scene.xml"))).unwrap();
            let start = format!("<float name=\"{name}\" value=\"");
            let number = text
                .split(&start)
                .nth(1)
                .and_then(|rest| rest.split('"').next()?.parse::<f32>().ok());
            let is_half = number.is_some_and(|number| (number - 0.5).abs() < 1e-3);
            assert!(
                is_half || name == "roughness" && number.is_none(),
                "{plugin}: {given}: {text}"
            );
        }
    }
    // Each of the channels has to be a value that the number may have.
    for (body, part) in [
        (
            "<bsdf type='mask'><rgb name='opacity' value='-1, 1, 1'/><bsdf type='diffuse'/></bsdf>",
            "2: error: `opacity` is -1, but should be at least 0",
        ),
        (
            "<bsdf type='roughconductor'><string name='alpha' value='rough'/></bsdf>",
            "2: error: `alpha` should be a float, a colour or a texture, found a string",
        ),
        (
            "<bsdf type='principled'><rgb name='specular' value='0.2, 0.4, 0.9'/></bsdf>",
            "2: error: `specular` should be a float, found a colour",
        ),
    ] {
        let list = complaints(body);
        assert!(list.len() == 1 && list[0].starts_with(part), "{body}: {list:?}");
    }
    // What is not edited is written as it was read.
    let scene = clean("<bsdf type='mask'><rgb name='opacity' value='0.2, 0.4, 0.9'/><bsdf type='diffuse'/></bsdf>");
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("scene.xml");
    save_description(&scene, &path).unwrap();
    let text = std::fs::read_to_string(&path).unwrap();
    assert!(text.contains("0.2, 0.4, 0.9"), "{text}");
}

/// A mesh that is not there is no error of the text: the scene can be looked at and saved.
#[test]
fn a_scene_keeps_the_names_of_files_that_are_not_there() {
    let body = "<path value='parts'/><shape type='obj' id='a'>\n<string name='filename' value='no/such.obj'/></shape>
        <shape type='ply' id='b'><string name='filename' value='parts/none.ply'/></shape>
        <shape type='obj' id='c'><string name='filename' value='no/such.obj'/></shape>
        <bsdf type='diffuse'><texture type='bitmap' name='reflectance'><string name='filename' value='none.png'/></texture></bsdf>";
    let (scene, diagnostics) = describe(&format!("{body}<sensor type='perspective'/>"));
    assert!(!diagnostics.has_errors(), "{diagnostics}");
    let names: Vec<_> = scene
        .missing
        .keys()
        .map(|path| path.file_name().unwrap().to_str().unwrap())
        .collect();
    assert_eq!(scene.missing.len(), 3, "each once: {names:?}");
    let such = scene
        .missing
        .iter()
        .find(|(path, _)| path.ends_with("no/such.obj"))
        .unwrap()
        .1;
    assert_eq!(such.kind, FileKind::Mesh);
    assert!(
        such.others.iter().any(|place| place.ends_with("parts/no/such.obj")),
        "{such:?}"
    );
    let (file, line, _) = diagnostics.locate(such.span).unwrap();
    assert!(file.ends_with("scene.xml") && line == 3);
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("scene.xml");
    save_description(&scene, &path).unwrap();
    let text = std::fs::read_to_string(&path).unwrap();
    for name in ["no/such.obj", "parts/none.ply", "none.png"] {
        assert!(text.contains(name), "{text}");
    }
}

#[test]
fn a_missing_stanford_mesh_says_where_to_get_it() {
    let scene = clean("<shape type='ply'><string name='filename' value='../assets/models/dragon.ply'/></shape>");
    let help = scene.missing.values().next().unwrap().help.as_deref().unwrap();
    assert!(
        help.contains("graphics.stanford.edu") && help.contains("SUNROOM_ASSETS"),
        "{help}"
    );
}

/// Written, read again, and compared. Returns the text.
fn round_trip(scene: &SceneDescription, target: &Path) -> String {
    let text = document::to_xml(&to_document(scene, target)).unwrap();
    let (again, diagnostics) = describe_at(&text, target);
    assert!(!diagnostics.has_errors(), "{text}\n{diagnostics}");
    assert_eq!(meaning(&again), meaning(scene), "{text}");
    // Written once more, nothing moves any more.
    assert_eq!(document::to_xml(&to_document(&again, target)).unwrap(), text);
    text
}

/// A bump map that has no picture yet is flat, and is there again after saving.
#[test]
fn a_uniform_height_is_written_and_read() {
    let scene = clean(
        "<bsdf type='bumpmap' id='flat'><texture type='uniform'><float name='value' value='0.25'/></texture>
           <bsdf type='diffuse'/></bsdf>",
    );
    let heights = scene.materials.iter().filter_map(|found| match &found.material {
        Material::BumpMap { height, .. } => height.constant(),
        _ => None,
    });
    assert_eq!(heights.collect::<Vec<_>>(), [0.25]);
    round_trip(&scene, &std::env::temp_dir().join("scene.xml"));
}

/// Whatever the editor makes of a plugin's name, a saved file gives back.
#[test]
fn a_new_material_of_every_plugin_is_written_and_read() {
    let mut scene =
        clean("<bsdf type='diffuse' id='inner'/><bsdf type='diffuse' id='other'/><bsdf type='diffuse' id='outer'/>");
    let [inner, other, outer] = ["inner", "other", "outer"].map(|id| {
        let found = scene
            .materials
            .iter()
            .position(|one| one.identity.id.as_deref() == Some(id));
        found.expect("a material of this id")
    });
    for plugin in Material::PLUGINS {
        let outermost = &mut scene.materials[outer];
        outermost.material = Material::of_plugin(plugin).expect("a plugin of this name");
        let nests = ["twosided", "mask", "bumpmap", "normalmap", "blendbsdf"].contains(&plugin);
        outermost.first = nests.then_some(inner);
        outermost.second = (plugin == "blendbsdf").then_some(other);
        round_trip(&scene, &std::env::temp_dir().join("scene.xml"));
    }
}

#[test]
fn layers_are_those_of_mitsuba_and_our_own() {
    let (scene, diagnostics) = describe(
        "<integrator type='aov'><string name='aovs' value='dd.y:depth, nn:sh_normal,x:light_groups'/>
           <integrator type='path'><integer name='max_depth' value='7'/></integrator></integrator>
         <sensor type='perspective'/>",
    );
    assert_eq!(diagnostics.list.len(), 0, "{diagnostics}");
    let layers = Layers::of(&[Layer::Depth, Layer::Normal, Layer::LightGroups]);
    assert_eq!((scene.integrator.layers, scene.integrator.max_depth), (layers, Some(7)));
    let (scene, _) = describe("<sensor type='perspective'/>");
    assert!(scene.integrator.layers.is_empty());
}

const EVERYTHING: &str = "<integrator type='path'><integer name='max_depth' value='7'/></integrator>
  <sensor type='thinlens' id='eye'><string name='focal_length' value='35mm'/><float name='aperture_radius' value='0.1'/>
    <film type='hdrfilm'><string name='pixel_format' value='rgba'/><rfilter type='tent'/></film>
    <transform name='to_world'><lookat origin='1,2,3' target='0,0,0' up='0,1,0'/></transform></sensor>
  <texture type='bitmap' id='wood'><string name='filename' value='wood.png'/></texture>
  <bsdf type='diffuse' id='planks'><ref id='wood' name='reflectance'/></bsdf>
  <bsdf type='bumpmap' id='bumpy'><bsdf type='diffuse'/><ref id='wood'/><float name='scale' value='2'/></bsdf>
  <bsdf type='velvet' id='curtain'><float name='pile' value='3'/></bsdf>
  <bsdf type='roughconductor' id='cu'><string name='material' value='Cu'/><float name='alpha_u' value='0.1'/>
    <float name='alpha_v' value='0.4'/><string name='distribution' value='ggx'/></bsdf>
  <emitter type='area' id='glow'><rgb name='radiance' value='3'/></emitter>
  <shape type='sphere'><ref id='planks'/><float name='mystery' value='4'/></shape>
  <shape type='cylinder' id='pipe'><ref id='planks'/></shape>
  <shape type='cube' id='box'><transform name='to_world'><rotate x='1' angle='30'/><scale x='2' y='3' z='4'/></transform>
    <bsdf type='twosided' id='inner'><bsdf type='diffuse'/><ref id='cu'/></bsdf><ref id='glow'/></shape>
  <shape type='disk'><ref id='inner'/></shape>
  <shape type='disk'><ref id='bumpy'/></shape>
  <emitter type='point'><point name='position' x='1' y='2' z='3'/></emitter>
  <emitter type='directional'><vector name='direction' x='1' y='2' z='3'/></emitter>
  <emitter type='constant'><spectrum name='radiance' value='0.5'/></emitter>
  <emitter type='envmap'><string name='filename' value='sky.exr'/></emitter>";

#[test]
fn what_was_not_understood_survives_being_saved() {
    let (scene, diagnostics) = describe(EVERYTHING);
    assert!(!diagnostics.has_errors(), "{diagnostics}");
    let text = round_trip(&scene, &std::env::temp_dir().join("scene.xml"));
    for kept in [
        "mystery",
        "cylinder",
        "bumpmap",
        "velvet",
        "pile",
        "envmap",
        "sky.exr",
        "wood.png",
        "focal_length",
        "alpha_u",
        "pixel_format",
        "tent",
        "lookat",
        "<ref id=\"glow\"",
        "spectrum",
    ] {
        assert!(text.contains(kept), "{kept} is lost:\n{text}");
    }
    assert!(!text.contains("near_clip"), "defaults were not asked for:\n{text}");
}

#[test]
fn an_edit_changes_what_was_edited_and_nothing_else() {
    let (before, _) = describe(EVERYTHING);
    let target = std::env::temp_dir().join("scene.xml");
    let unedited = document::to_xml(&to_document(&before, &target)).unwrap();
    let mut scene = before.clone();
    let by_id = |id: &str| {
        before
            .materials
            .iter()
            .position(|m| m.identity.id.as_deref() == Some(id))
            .unwrap()
    };
    let Material::RoughConductor { alpha, .. } = &mut scene.materials[by_id("cu")].material else {
        panic!("not rough")
    };
    *alpha = Roughness::Isotropic(0.5.into());
    scene.materials[by_id("planks")].material = Material::Diffuse {
        reflectance: Vec3::new(0.1, 0.2, 0.3).into(),
    };
    scene.sensors[0].sensor.fov = 33.0;
    scene.sensors[0].film.width = 100;
    let cube = scene
        .shapes
        .iter_mut()
        .find(|s| s.shape.kind == ShapeKind::Cube)
        .unwrap();
    cube.area_light = Some(AreaLight {
        radiance: Vec3::X.into(),
        ..AreaLight::default()
    });
    let text = round_trip(&scene, &target);
    let lines = |text: &str| text.lines().map(str::trim).map(str::to_owned).collect::<Vec<_>>();
    let (old, new) = (lines(&unedited), lines(&text));
    let gone: Vec<_> = old.iter().filter(|line| !new.contains(line)).collect();
    // The lens, two roughnesses, the texture of the planks, and the reference to the light, which is written in place
    // now.
    assert_eq!(gone.len(), 5, "{gone:#?}\n{text}");
    assert!(text.contains("pixel_format"), "{text}");
}

#[test]
fn what_was_made_in_the_editor_is_written_too() {
    let (mut scene, _) = describe("<sensor type='perspective'/><shape type='sphere'/><shape type='disk'/>");
    let made = |order| sunroom::scene::description::Identity {
        name: "new".into(),
        order,
        ..Default::default()
    };
    scene.materials.push(sunroom::scene::description::MaterialDescription {
        identity: made(10),
        material: Material::Metal {
            reflectance: Vec3::splat(0.25).into(),
            fuzz: 0.5.into(),
        },
        first: None,
        second: None,
        declared_in: DeclarationPlace::TopLevel,
    });
    for shape in &mut scene.shapes {
        shape.material = Some(0);
        shape.to_world = Affine3A::from_rotation_y(1.0) * Affine3A::from_scale(Vec3::new(1.0, 2.0, 3.0));
    }
    let text = document::to_xml(&to_document(&scene, Path::new("/tmp/scene.xml"))).unwrap();
    let (again, diagnostics) = describe_at(&text, Path::new("/tmp/scene.xml"));
    assert!(diagnostics.list.is_empty(), "{diagnostics}");
    assert_eq!(again.materials.len(), 1);
    assert_eq!(again.materials[0].material, scene.materials[0].material);
    for (a, b) in again.shapes.iter().zip(&scene.shapes) {
        assert_eq!(a.material, Some(0));
        assert!(a.to_world.abs_diff_eq(b.to_world, 1e-5));
    }
    assert!(
        text.contains("<scale") && text.contains("<rotate") && !text.contains("<matrix"),
        "{text}"
    );
}

#[test]
fn file_names_follow_the_scene_to_another_folder() {
    let root = tempfile::tempdir().unwrap();
    let [scenes, models, other] = ["scenes", "models", "elsewhere/deep"].map(|name| root.path().join(name));
    for folder in [&scenes, &models, &other] {
        std::fs::create_dir_all(folder).unwrap();
    }
    std::fs::write(models.join("a.obj"), "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n").unwrap();
    std::fs::write(scenes.join("wood.png"), "").unwrap();
    std::fs::write(
        models.join("part.xml"),
        "<scene version='3.0.0'><shape type='obj'><string name='filename' value='a.obj'/></shape></scene>",
    )
    .unwrap();
    let path = scenes.join("main.xml");
    let text = "<scene version='3.0.0'><sensor type='perspective'/><include filename='../models/part.xml'/>
        <shape type='obj' id='direct'><string name='filename' value='../models/a.obj'/>
          <bsdf type='diffuse'><texture type='bitmap' name='reflectance'><string name='filename' value='wood.png'/></texture></bsdf>
        </shape></scene>";
    let (scene, diagnostics) = describe_at(text, &path);
    assert!(!diagnostics.has_errors(), "{diagnostics}");
    assert_eq!(scene.sources.len(), 2);
    let file = |shape: &Shape| match &shape.kind {
        ShapeKind::Mesh(file) => file.path.clone(),
        other => panic!("{other:?}"),
    };
    assert_eq!(file(&scene.shapes[0].shape), file(&scene.shapes[1].shape));
    assert!(round_trip(&scene, &path).contains("../models/a.obj"));
    let moved = round_trip(&scene, &other.join("moved.xml"));
    assert!(
        moved.contains("../../models/a.obj") && moved.contains("../../scenes/wood.png"),
        "{moved}"
    );
    save_description(&scene, &other.join("moved.xml")).unwrap();
    assert!(other.join("moved.xml").is_file());
}

#[test]
fn scenes_of_other_people_come_back_unchanged() {
    let own = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes");
    let shared = Path::new(env!("CARGO_MANIFEST_DIR"))
        .ancestors()
        .skip(1)
        .map(|folder| folder.join("shared/data"));
    let mut folders = vec![own];
    match shared.into_iter().find(|folder| folder.is_dir()) {
        Some(data) => folders.extend(["mitsuba-scenes", "peer-scenes", "csi-scenes"].map(|name| data.join(name))),
        None => println!("skipped: no folder of shared scenes"),
    }
    let mut count = 0;
    for folder in folders {
        let Ok(entries) = std::fs::read_dir(&folder) else {
            println!("skipped: {}", folder.display());
            continue;
        };
        for path in entries.flatten().map(|entry| entry.path()) {
            if path.extension().is_none_or(|extension| extension != "xml") {
                continue;
            }
            let Ok(mut document) = document::load(&path, &[]) else {
                continue;
            };
            let scene = read(&mut document);
            if document.diagnostics.has_errors() {
                println!("not compared: {}", document.diagnostics);
                continue;
            }
            round_trip(&scene, &path);
            count += 1;
        }
    }
    println!("{count} scenes compared");
    assert!(count >= 4);
}

fn app_with(path: &Path) -> App {
    let mut app = App::new();
    app.add_plugins((MinimalPlugins, FileSourcePlugin, asset_plugin(), ScenePlugin));
    app.finish();
    app.cleanup();
    app.world_mut().write_message(OpenScene {
        path: path.to_owned(),
        defines: Vec::new(),
        ..OpenScene::default()
    });
    let deadline = Instant::now() + Duration::from_secs(600);
    loop {
        app.update();
        let status = app.world().resource::<SceneStatus>();
        if status.is_complete() || status.state == SceneState::Failed {
            return app;
        }
        assert!(Instant::now() < deadline, "{status:?}");
        std::thread::sleep(Duration::from_millis(2));
    }
}

#[test]
fn entities_say_what_the_file_says_and_are_gathered_again() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("scene.xml");
    std::fs::write(&path, format!("<scene version='3.0.0'>{EVERYTHING}</scene>")).unwrap();
    let mut app = app_with(&path);
    let mut document = document::load(&path, &[]).unwrap();
    let expected = read(&mut document);
    let world = app.world_mut();
    let gathered = gather::describe(world);
    assert_eq!(meaning(&gathered), meaning(&expected));
    assert_eq!(gathered.remains, expected.remains);

    let status = world.resource::<SceneStatus>();
    assert_eq!((status.revision, status.fresh_load), (1, true));
    let active = world.resource::<ActiveSensor>().0.unwrap();
    assert_eq!(world.get::<SceneId>(active), Some(&SceneId("eye".into())));
    let users: Vec<_> = world
        .query::<(&Material, &MaterialUsers)>()
        .iter(world)
        .map(|(_, users)| users.iter().count())
        .collect();
    assert_eq!(users.iter().sum::<usize>(), 5);
}

#[test]
fn the_world_is_saved_as_it_is() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("scene.xml");
    std::fs::write(&path, format!("<scene version='3.0.0'>{EVERYTHING}</scene>")).unwrap();
    let mut app = app_with(&path);
    let world = app.world_mut();
    let active = world.resource::<ActiveSensor>().0.unwrap();
    world.get_mut::<ToWorld>(active).unwrap().0 = TransformOp::LookAt {
        origin: Vec3::new(3.0, 2.0, 1.0),
        target: Vec3::ZERO,
        up: Vec3::Y,
    }
    .affine();
    let moved = world.get::<ToWorld>(active).copied().unwrap();
    sunroom::scene::write::save(world, &path).unwrap();
    let mut document = document::load(&path, &[]).unwrap();
    let again = read(&mut document);
    assert!(again.sensors[0].to_world.abs_diff_eq(moved.0, 1e-5));
}

#[test]
fn a_scene_without_a_sensor_is_framed() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("scene.xml");
    std::fs::write(folder.path().join("a.obj"), "v 9 0 0\nv 11 0 0\nv 10 2 0\nf 1 2 3\n").unwrap();
    let text = "<scene version='3.0.0'><shape type='obj'><string name='filename' value='a.obj'/></shape></scene>";
    std::fs::write(&path, text).unwrap();
    let mut app = app_with(&path);
    app.update();
    let world = app.world();
    let active = world.resource::<ActiveSensor>().0.unwrap();
    let pose = world.get::<ToWorld>(active).unwrap().0;
    let sensor = world.get::<Sensor>(active).unwrap();
    let half = (0.5 * sensor.fov.to_radians()).tan();
    for corner in [
        Vec3::new(9.0, 0.0, 0.0),
        Vec3::new(11.0, 0.0, 0.0),
        Vec3::new(10.0, 2.0, 0.0),
    ] {
        let seen = pose.inverse().transform_point3(corner);
        assert!(
            seen.z > 0.0 && seen.x.abs() < half * seen.z && seen.y.abs() < half * seen.z,
            "{seen}"
        );
    }
    let status = world.resource::<SceneStatus>();
    assert_eq!(status.diagnostics.warning_count(), 1);
}

#[test]
fn a_scene_of_tiny_extent_fills_the_view_as_well() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let path = folder.path().join("scene.xml");
    for radius in [1e-6f32, 1.0, 1e6] {
        let text = format!(
            "<scene version='3.0.0'><shape type='sphere'><float name='radius' value='{radius}'/></shape></scene>"
        );
        std::fs::write(&path, text).expect("a temporary folder");
        let mut app = app_with(&path);
        app.update();
        let world = app.world();
        let active = world.resource::<ActiveSensor>().0.expect("a camera");
        let pose = world.get::<ToWorld>(active).expect("it stands somewhere").0;
        let distance = pose.translation.length();
        assert!((2.0..6.0).contains(&(distance / radius)), "{radius}: {distance}");
        let sensor = world.get::<Sensor>(active).expect("a camera");
        assert!(sensor.near_clip < distance - radius && sensor.far_clip > distance + radius);
    }
}

#[test]
fn failures_say_where() {
    let folder = tempfile::tempdir().unwrap();
    let missing = app_with(&folder.path().join("none.xml"));
    let status = missing.world().resource::<SceneStatus>();
    assert_eq!(status.state, SceneState::Failed);
    assert!(
        status.diagnostics.to_string().contains("none.xml"),
        "{}",
        status.diagnostics
    );

    let path = folder.path().join("scene.xml");
    std::fs::write(folder.path().join("bad.obj"), "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 9\n").unwrap();
    let text = "<scene version='3.0.0'><sensor type='perspective'/>\n<shape type='obj'>\n<string name='filename' value='bad.obj'/></shape></scene>";
    std::fs::write(&path, text).unwrap();
    let app = app_with(&path);
    let status = app.world().resource::<SceneStatus>();
    assert!(status.is_complete() && status.has_errors());
    let message = &status.mesh_errors[0].message;
    assert!(
        message.contains("scene.xml:3:1: mesh ") && message.contains("line 4"),
        "{message}"
    );
}
