//! Lights from the scene file to the renderer: what is read, what is warned of, what is written back, and the light
//! that comes of it.

use std::f32::consts::{FRAC_PI_2, PI, TAU};
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use bevy::math::{Affine3A, Quat};
use bevy::prelude::*;
use sunroom::app::headless::headless;
use sunroom::color::{Rgb, linear_from_srgb};
use sunroom::document::{self, Diagnostics};
use sunroom::engine::{PackedScene, RenderControl};
use sunroom::light::{LightId, LightReference, LightSample, SurfaceHit};
use sunroom::material::Material as Packed;
use sunroom::math::Ray;
use sunroom::render::image_io::{ImageRgb, write_image};
use sunroom::render::scene::RenderScene;
use sunroom::render::tonemap::Display;
use sunroom::sampling::{Sampler, SequenceKind};
use sunroom::scene::read::read;
use sunroom::scene::write::to_document;
use sunroom::scene::*;
use sunroom::shading::Bsdf;

fn describe(body: &str) -> (SceneDescription, Diagnostics) {
    let text = format!("<scene version='3.0.0'>\n{body}\n<sensor type='perspective'/></scene>");
    describe_text(&text)
}

fn describe_text(text: &str) -> (SceneDescription, Diagnostics) {
    let mut document = document::parse_str(text, Path::new("/somewhere/scene.xml"), &[]);
    let scene = read(&mut document);
    (scene, document.diagnostics)
}

fn only_emitter(body: &str) -> (Emitter, Affine3A) {
    let (scene, diagnostics) = describe(body);
    assert!(diagnostics.list.is_empty(), "{diagnostics}");
    (scene.emitters[0].emitter.clone(), scene.emitters[0].to_world)
}

#[test]
fn defaults_are_those_of_the_format() {
    for (plugin, needed) in [
        ("point", ""),
        ("directional", ""),
        ("constant", ""),
        ("envmap", "<string name='filename' value='sky.exr'/>"),
        ("spot", ""),
        ("projector", "<float name='fov' value='45'/>"),
        ("ies", "<string name='filename' value='lamp.ies'/>"),
        ("sunsky", ""),
    ] {
        let (mut emitter, to_world) = only_emitter(&format!("<emitter type='{plugin}'>{needed}</emitter>"));
        if let EmitterKind::Environment { picture, .. } = &mut emitter.kind {
            assert_eq!(std::mem::take(picture), Path::new("/somewhere/sky.exr"));
        }
        if let EmitterKind::Luminaire { profile, .. } = &mut emitter.kind {
            assert_eq!(std::mem::take(profile), Path::new("/somewhere/lamp.ies"));
        }
        assert_eq!(Some(emitter), Emitter::of_plugin(plugin));
        assert_eq!(to_world, Affine3A::IDENTITY);
    }
    let (spot, _) = only_emitter("<emitter type='spot'><float name='cutoff_angle' value='40'/></emitter>");
    assert!(
        matches!(spot.kind, EmitterKind::Spot { cone, .. } if cone.beam_width == 30.0),
        "{spot:?}"
    );
    // A frame of 36 x 24 mm behind 50 mm.
    let (projector, _) = only_emitter("<emitter type='projector'/>");
    let diagonal = 2.0 * (0.5 * 36f32.hypot(24.0) / 50.0).atan().to_degrees();
    assert!(
        matches!(projector.kind, EmitterKind::Projector { field_of_view: FieldOfView { fov, axis: FovAxis::Diagonal }, .. } if (fov - diagonal).abs() < 1e-4),
        "{projector:?}"
    );
}

/// Every parameter with a value of its own.
const EVERYTHING: &str = "
<texture type='bitmap' id='slide'><string name='filename' value='slide.png'/><boolean name='raw' value='true'/></texture>
<emitter type='envmap'><string name='filename' value='pictures/sky.hdr'/><float name='scale' value='2.5'/>
  <boolean name='mis_compensation' value='false'/><float name='sampling_weight' value='0.25'/>
  <transform name='to_world'><scale x='-1'/><rotate y='1' angle='33'/></transform></emitter>
<emitter type='spot' id='key'><rgb name='intensity' value='3, 2, 1'/><float name='cutoff_angle' value='32'/>
  <ref id='slide' name='texture'/>
  <transform name='to_world'><lookat origin='1, 2, 3' target='0, 0, 0' up='0, 1, 0'/></transform></emitter>
<emitter type='spot'><float name='beam_width' value='5'/></emitter>
<emitter type='projector'><ref id='slide' name='irradiance'/><float name='scale' value='4'/><float name='fov' value='20'/>
  <string name='fov_axis' value='y'/></emitter>
<emitter type='sunsky'><float name='turbidity' value='5'/><rgb name='albedo' value='0.1, 0.2, 0.3'/>
  <vector name='sun_direction' x='1' y='2' z='3'/><float name='sun_scale' value='0.5'/><float name='sky_scale' value='2'/>
  <float name='sun_aperture' value='5'/><boolean name='complex_sun' value='true'/></emitter>
<emitter type='sunsky'><float name='latitude' value='48.5'/><float name='longitude' value='9'/><float name='timezone' value='1'/>
  <integer name='year' value='2024'/><integer name='month' value='2'/><integer name='day' value='29'/>
  <float name='hour' value='11'/><float name='minute' value='30'/><float name='second' value='15'/></emitter>
<shape type='rectangle'><emitter type='area'><ref id='slide' name='radiance'/><float name='sampling_weight' value='3'/></emitter></shape>
<shape type='disk'><emitter type='area'><texture type='checkerboard' name='radiance'><rgb name='color0' value='5'/></texture>
  </emitter></shape>";

fn lights(scene: &SceneDescription) -> Vec<(Option<Emitter>, Option<AreaLight>, Affine3A)> {
    let emitters = scene
        .emitters
        .iter()
        .map(|it| (Some(it.emitter.clone()), None, it.to_world));
    let surfaces = scene.shapes.iter().map(|it| (None, it.area_light.clone(), it.to_world));
    emitters.chain(surfaces).collect()
}

fn text_of(scene: &SceneDescription) -> String {
    document::to_xml(&to_document(scene, Path::new("/somewhere/scene.xml"))).unwrap()
}

#[test]
fn every_parameter_survives_being_saved() {
    let (scene, diagnostics) = describe(EVERYTHING);
    // Both skies come after the picture around the scene.
    let more_skies = |message: &str| message.contains("`sunsky` is another light around the scene");
    let list = &diagnostics.list;
    assert!(
        list.len() == 2 && list.iter().all(|it| more_skies(&it.message)),
        "{diagnostics}"
    );
    let bitmap = Bitmap {
        path: "/somewhere/slide.png".into(),
        raw: true,
        ..Bitmap::default()
    };
    let slide = Texture::Bitmap(Box::new(bitmap));
    let spot = &scene.emitters[1].emitter.kind;
    assert!(
        matches!(spot, EmitterKind::Spot { texture: Some(texture), cone, .. } if *texture == slide && cone.beam_width == 24.0),
        "{spot:?}"
    );
    assert_eq!(scene.emitters[0].emitter.sampling_weight, 0.25);
    let expected = AreaLight {
        radiance: Parameter::Texture(slide),
        two_sided: false,
        sampling_weight: 3.0,
    };
    assert_eq!(scene.shapes[0].area_light, Some(expected));

    // Once over the old text, once without it.
    let mut bare = scene.clone();
    bare.remains.origin = None;
    let emitters = bare.emitters.iter_mut().map(|it| &mut it.identity);
    let shapes = bare.shapes.iter_mut().map(|it| &mut it.identity);
    emitters.chain(shapes).for_each(|identity| identity.authored = None);
    for version in [&scene, &bare] {
        let text = text_of(version);
        let (again, diagnostics) = describe_text(&text);
        assert!(!diagnostics.has_errors(), "{text}\n{diagnostics}");
        for (one, other) in lights(&scene).iter().zip(lights(&again)) {
            assert_eq!((&one.0, &one.1), (&other.0, &other.1), "{text}");
            assert!(one.2.abs_diff_eq(other.2, 1e-6), "{text}");
        }
        assert_eq!(lights(&scene).len(), lights(&again).len());
    }
}

/// What an edit does to the text, and whether reading it again gives what was edited.
fn edited(body: &str, edit: impl Fn(&mut SceneDescription)) -> String {
    let (mut scene, _) = describe(body);
    edit(&mut scene);
    let text = text_of(&scene);
    let (again, diagnostics) = describe_text(&text);
    assert!(diagnostics.list.is_empty(), "{text}\n{diagnostics}");
    assert_eq!(lights(&again), lights(&scene), "{text}");
    text
}

#[test]
fn edits_write_what_they_need_and_no_more() {
    // Another cone keeps the beam it had by default.
    let text = edited("<emitter type='spot'/>", |scene| {
        let EmitterKind::Spot { cone, .. } = &mut scene.emitters[0].emitter.kind else {
            panic!("{:?}", scene.emitters)
        };
        cone.cutoff_angle = 60.0;
    });
    assert!(text.contains("beam_width") && !text.contains("intensity"), "{text}");

    let with_texture = "<emitter type='spot'><texture type='checkerboard' name='texture'/></emitter>";
    let text = edited(with_texture, |scene| {
        let EmitterKind::Spot { texture, .. } = &mut scene.emitters[0].emitter.kind else {
            panic!("{:?}", scene.emitters)
        };
        *texture = None;
    });
    assert!(!text.contains("checkerboard"), "{text}");

    // The sun by place and time, and back.
    let by_time = "<emitter type='sunsky'><float name='hour' value='9'/></emitter>";
    let set_sun = |sun: SunPosition| {
        move |scene: &mut SceneDescription| {
            let EmitterKind::SunSky(sky) = &mut scene.emitters[0].emitter.kind else {
                panic!("{:?}", scene.emitters)
            };
            sky.sun = sun;
        }
    };
    let text = edited(by_time, set_sun(SunPosition::Direction(Vec3::new(0.0, 1.0, 2.0))));
    assert!(text.contains("sun_direction") && !text.contains("hour"), "{text}");
    let by_direction = "<emitter type='sunsky'><vector name='sun_direction' x='1' y='0' z='1'/></emitter>";
    let text = edited(
        by_direction,
        set_sun(SunPosition::PlaceAndTime(PlaceAndTime::default())),
    );
    assert!(!text.contains("sun_direction") && text.contains("hour"), "{text}");

    let lamp = "<shape type='disk'><emitter type='area'><rgb name='radiance' value='7'/></emitter></shape>";
    let text = edited(lamp, |scene| {
        let light = scene.shapes[0].area_light.as_mut().unwrap();
        light.radiance.set_picture("/somewhere/slide.png".into());
    });
    assert!(text.contains("slide.png") && !text.contains("rgb"), "{text}");
    let text = edited(lamp, |scene| {
        scene.shapes[0].area_light.as_mut().unwrap().sampling_weight = 0.0;
    });
    assert!(text.contains("sampling_weight") && text.contains("7, 7, 7"), "{text}");
}

#[test]
fn what_is_wrong_is_said_with_its_place() {
    for (body, expected) in [
        (
            "\n<emitter type='envmap'/>",
            "3:1: error: emitter `envmap` needs a `filename`",
        ),
        (
            "<emitter type='envmap'>\n<string name='filename' value='a.exr'/><float name='scale' value='-1'/></emitter>",
            "3:40: error: `scale` is -1",
        ),
        (
            "<emitter type='spot'><float name='cutoff_angle' value='200'/></emitter>",
            "2:22: error: `cutoff_angle` is 200",
        ),
        (
            "<emitter type='spot'><float name='beam_width' value='30'/></emitter>",
            "2:22: warning: `beam_width` is above `cutoff_angle`",
        ),
        (
            "<emitter type='spot'><texture type='checkerboard' name='intensity'/></emitter>",
            "2:22: warning: `intensity` of emitter `spot` is the same everywhere",
        ),
        (
            "<emitter type='projector'><float name='fov' value='180'/></emitter>",
            "2:27: error: `fov` is 180",
        ),
        (
            "<emitter type='sunsky'><float name='turbidity' value='0.5'/></emitter>",
            "2:24: error: `turbidity` is 0.5, but should be at least 1 and at most 10",
        ),
        (
            "<emitter type='sunsky'><vector name='sun_direction' value='0, 0, 1'/>\n<float name='hour' value='3'/></emitter>",
            "3:1: error: `sun_direction` and `hour` exclude each other",
        ),
        (
            "<emitter type='sunsky'><integer name='month' value='13'/></emitter>",
            "2:24: error: `month` is 13",
        ),
        (
            "<emitter type='sunsky'><vector name='sun_direction' x='0' y='0' z='0'/></emitter>",
            "2:24: error: `sun_direction` has no length",
        ),
        (
            "<emitter type='sunsky'><vector name='sun_direction' x='0' y='0.6' z='-0.8'/></emitter>",
            "2:24: warning: the sun is 53.1 degrees below the horizon",
        ),
        (
            "<emitter type='point'><float name='sampling_weight' value='-1'/></emitter>",
            "2:23: error: `sampling_weight` is -1",
        ),
        (
            "<emitter type='point'><rgb name='intensity' value='1, -1, 1'/></emitter>",
            "2:23: error: `intensity` is negative",
        ),
        (
            "<shape type='disk'><emitter type='area'><texture type='volume' name='radiance'/></emitter></shape>",
            "2:41: warning: texture `volume` is not supported",
        ),
        ("<emitter type='sunski'/>", "2:1: error: emitter `sunski` is not known"),
    ] {
        let (_, diagnostics) = describe(body);
        // A scene that is refused has its missing files named as well.
        let is_of_parameters = |message: &str| !message.starts_with("picture /somewhere/a.exr: no such file");
        let list: Vec<String> = diagnostics
            .list
            .iter()
            .filter(|it| is_of_parameters(&it.message))
            .map(|it| {
                let (_, line, column) = it.span.and_then(|span| diagnostics.locate(span)).unwrap();
                format!("{line}:{column}: {}: {}", it.severity, it.message)
            })
            .collect();
        assert!(list.len() == 1 && list[0].starts_with(expected), "{body}: {list:?}");
    }
}

/// A scene with its files, loaded and packed but not rendered.
struct Open {
    app: App,
    folder: tempfile::TempDir,
}

impl Open {
    fn new(body: &str, write_files: impl Fn(&Path)) -> Self {
        let folder = tempfile::tempdir().unwrap();
        write_files(folder.path());
        let path = folder.path().join("scene.xml");
        let text = format!("<scene version='3.0.0'>{body}<sensor type='perspective'/></scene>");
        std::fs::write(&path, text).unwrap();
        let open = OpenScene {
            path,
            defines: Vec::new(),
            ..OpenScene::default()
        };
        let mut app = headless(open, Some(1));
        app.world_mut().resource_mut::<RenderControl>().paused = true;
        app.finish();
        app.cleanup();
        let mut open = Self { app, folder };
        open.until("the scene is loaded", |world| {
            world.resource::<SceneStatus>().is_complete()
        });
        // What was loaded last is packed in the frame after.
        open.app.update();
        let status = open.app.world().resource::<SceneStatus>();
        assert!(
            !status.has_errors() && status.diagnostics.list.is_empty(),
            "{}",
            status.diagnostics
        );
        open
    }

    fn until(&mut self, what: &str, done: impl Fn(&World) -> bool) {
        let deadline = Instant::now() + Duration::from_secs(600);
        loop {
            self.app.update();
            if done(self.app.world()) {
                return;
            }
            let diagnostics = &self.app.world().resource::<SceneStatus>().diagnostics;
            assert!(Instant::now() < deadline, "not in time: {what}\n{diagnostics}");
            std::thread::sleep(Duration::from_millis(5));
        }
    }

    fn scene(&self) -> RenderScene {
        let packed = self.app.world().resource::<PackedScene>();
        packed.scene.clone().expect("the scene has been packed")
    }

    /// Of the first light, from far away in this direction.
    fn radiance(&self, towards: Vec3) -> Rgb {
        self.scene().lights.radiance_from(LightId(0), towards.normalize())
    }

    /// From the only light, at a point.
    fn arriving(&self, at: Vec3) -> Rgb {
        let sample = sample(&self.scene(), at, 0.5);
        sample.map_or(Rgb::ZERO, |sample| sample.radiance / sample.pdf)
    }
}

fn sample(scene: &RenderScene, position: Vec3, u_choice: f32) -> Option<LightSample> {
    let reference = LightReference { position, normal: None };
    let chosen = scene.lights.sample(&reference, u_choice, Vec2::splat(0.5));
    chosen.map(|(_, sample)| sample)
}

fn close(value: Rgb, expected: Rgb, tolerance: f32) -> bool {
    value.abs_diff_eq(expected, tolerance * expected.max_element().max(1e-6))
}

/// Colours that every format of picture holds exactly.
fn write_picture(path: PathBuf, width: u32, pixels: &[Rgb]) {
    let picture = ImageRgb {
        width,
        height: pixels.len() as u32 / width,
        pixels: pixels.to_vec(),
    };
    write_image(&path, &picture, &Display::default()).unwrap();
}

/// A pole, the four pixels of the equator, the other pole. Bright ones are at most 1, so that a PNG holds them, and
/// what its eight bits make of them is taken into account.
fn sky() -> [Rgb; 12] {
    let [up, down] = [Rgb::new(0.5, 0.0, 1.0), Rgb::new(0.0, 1.0, 0.0)];
    let equator = [Rgb::X, Rgb::new(0.0, 0.5, 0.0), Rgb::new(0.25, 0.25, 1.0), Rgb::ONE];
    let [a, b, c, d] = equator;
    [up, up, up, up, a, b, c, d, down, down, down, down]
}

#[test]
fn an_environment_is_where_its_transform_turns_it() {
    for format in ["exr", "hdr", "png"] {
        let body = format!(
            "<emitter type='envmap'><string name='filename' value='sky.{format}'/><float name='scale' value='2'/>
             <transform name='to_world'><rotate y='1' angle='90'/><rotate x='1' angle='30'/></transform></emitter>"
        );
        let open = Open::new(&body, |folder| {
            write_picture(folder.join(format!("sky.{format}")), 4, &sky());
        });
        let to_world = Quat::from_rotation_x(PI / 6.0) * Quat::from_rotation_y(FRAC_PI_2);
        let eight_bits = |linear: f32| match format {
            "png" => {
                let code = (0..=255).map(|code| linear_from_srgb(code as f32 / 255.0));
                let nearest = code.min_by(|a, b| (a - linear).abs().total_cmp(&(b - linear).abs()));
                nearest.unwrap()
            }
            _ => linear,
        };
        for (place, color) in sky().into_iter().enumerate() {
            // Columns from their centres on, from -z over +x; rows from pole to pole.
            let (phi, theta) = (TAU * ((place % 4) as f32 + 0.5) / 4.0, FRAC_PI_2 * (place / 4) as f32);
            let local = Vec3::new(phi.sin() * theta.sin(), theta.cos(), -phi.cos() * theta.sin());
            let expected = 2.0 * Rgb::from_array(color.to_array().map(eight_bits));
            let found = open.radiance(to_world * local);
            assert!(
                close(found, expected, 1e-3),
                "{format}, {place}: {found}, not {expected}"
            );
        }
    }
}

#[test]
fn an_edited_picture_is_another_sky() {
    let body = "<emitter type='envmap'><string name='filename' value='sky.exr'/></emitter>";
    let mut open = Open::new(body, |folder| write_picture(folder.join("sky.exr"), 4, &[Rgb::ONE; 12]));
    assert!(close(open.radiance(Vec3::X), Rgb::ONE, 1e-3));
    let old = open.scene().lights;
    write_picture(open.folder.path().join("sky.exr"), 4, &[Rgb::new(3.0, 2.0, 1.0); 12]);
    open.until("the other sky", |world| {
        let scene = world.resource::<PackedScene>().scene.as_ref();
        scene.is_some_and(|scene| {
            close(
                scene.lights.radiance_from(LightId(0), Vec3::X),
                Rgb::new(3.0, 2.0, 1.0),
                1e-3,
            )
        })
    });
    assert!(!std::sync::Arc::ptr_eq(&old, &open.scene().lights));
}

/// Top left, top right, bottom left, bottom right.
const CORNERS: [Rgb; 4] = [Rgb::X, Rgb::Y, Rgb::Z, Rgb::ONE];

fn write_slide(folder: &Path) {
    write_picture(folder.join("slide.exr"), 2, &CORNERS);
}

const SLIDE: &str = "<string name='filename' value='slide.exr'/><string name='filter_type' value='nearest'/>";

#[test]
fn a_projector_shows_its_picture_upright() {
    // From above, the top of the picture to the north (-z): west (-x) is left.
    let body = format!(
        "<emitter type='projector'><texture type='bitmap' name='irradiance'>{SLIDE}</texture><float name='fov' value='90'/>
         <float name='scale' value='2'/>
         <transform name='to_world'><lookat origin='0, 4, 0' target='0, 0, 0' up='0, 0, -1'/></transform></emitter>"
    );
    let open = Open::new(&body, write_slide);
    for (place, color) in CORNERS.into_iter().enumerate() {
        let (x, z) = (
            if place % 2 == 0 { -2.0 } else { 2.0 },
            if place < 2 { -2.0 } else { 2.0 },
        );
        let at = Vec3::new(x, 0.0, z);
        // What falls on the floor is even: pi times the irradiance at z = 1, and a sixteenth of that at z = 4.
        let cos = 4.0 / at.distance(Vec3::Y * 4.0);
        let irradiance = open.arriving(at) * cos;
        assert!(
            close(irradiance, 2.0 * PI / 16.0 * color, 1e-3),
            "{place}: {irradiance}"
        );
    }
    assert_eq!(open.arriving(Vec3::new(4.1, 0.0, 0.0)), Rgb::ZERO, "beyond its edge");
}

/// A lamp of 100 cd in all directions but up, in a file.
fn write_lamp(folder: &Path) {
    let text = "IES:LM-63-2019\nTILT=NONE\n1 -1 1 3 1 1 2 0 0 0\n1 1.1 10\n0 90 180\n0\n100 100 0\n";
    std::fs::write(folder.join("lamp.ies"), text).unwrap();
}

#[test]
fn a_lamp_has_the_lumens_of_its_file_or_its_own() {
    let body = |flux: f32| {
        format!(
            "<emitter type='ies'><string name='filename' value='lamp.ies'/><rgb name='scale' value='1, 0.5, 0.25'/>
             <float name='flux' value='{flux}'/>
             <transform name='to_world'><lookat origin='0, 4, 0' target='0, 0, 0' up='0, 0, -1'/></transform></emitter>"
        )
    };
    // In the upper half the intensity falls linearly with the angle: the integral of (2 - 2 theta / pi) sin(theta) is
    // 2 / pi.
    let of_file = 100.0 * TAU * (1.0 + 2.0 / PI);
    for (flux, candela) in [(0.0, 100.0), (of_file, 100.0), (3.0 * of_file, 300.0)] {
        let open = Open::new(&body(flux), write_lamp);
        let expected = Rgb::new(1.0, 0.5, 0.25) * (candela / 683.0 / 16.0);
        let arriving = open.arriving(Vec3::ZERO);
        assert!(close(arriving, expected, 1e-3), "{flux}: {arriving}, {expected}");
        let above = open.arriving(Vec3::Y * 8.0);
        assert!(above.max_element() < 1e-3 * expected.x, "{flux}: {above}");
    }
}

#[test]
fn an_edited_lamp_file_shines_anew() {
    let body = "<emitter type='ies'><string name='filename' value='lamp.ies'/></emitter>";
    let mut open = Open::new(body, write_lamp);
    let before = open.arriving(Vec3::Z);
    let path = open.folder.path().join("lamp.ies");
    let text = std::fs::read_to_string(&path).unwrap();
    std::fs::write(&path, text.replace("100 100", "300 100")).unwrap();
    open.until("the other lamp", |world| {
        let scene = world.resource::<PackedScene>().scene.as_ref();
        let sample = scene.and_then(|scene| sample(scene, Vec3::Z, 0.5));
        sample.is_some_and(|sample| close(sample.radiance / sample.pdf, 3.0 * before, 1e-3))
    });
}

#[test]
fn a_wide_picture_is_projected_widely() {
    let body = "<emitter type='projector'><texture type='bitmap' name='irradiance'><string name='filename' value='wide.exr'/></texture>
        <float name='fov' value='90'/><string name='fov_axis' value='smaller'/></emitter>";
    let open = Open::new(body, |folder| write_picture(folder.join("wide.exr"), 3, &[Rgb::ONE; 3]));
    // Its height is 2 at the distance 1, its width 6.
    for (x, y, lit) in [
        (2.9, 0.9, true),
        (-2.9, -0.9, true),
        (3.1, 0.0, false),
        (0.0, 1.1, false),
    ] {
        assert_eq!(open.arriving(Vec3::new(x, y, 1.0)) != Rgb::ZERO, lit, "{x} {y}");
    }
}

#[test]
fn a_spot_shines_along_its_axis_through_its_texture() {
    let body = format!(
        "<emitter type='spot'><texture type='bitmap' name='texture'>{SLIDE}</texture><rgb name='intensity' value='8'/>
         <float name='cutoff_angle' value='45'/><float name='beam_width' value='45'/>
         <transform name='to_world'><lookat origin='0, 4, 0' target='0, 0, 0' up='0, 0, -1'/></transform></emitter>"
    );
    let open = Open::new(&body, write_slide);
    for (place, color) in CORNERS.into_iter().enumerate() {
        // As Mitsuba has it, seen from the spot the picture is turned by half a turn.
        let (x, z) = (
            if place % 2 == 0 { 1.0 } else { -1.0 },
            if place < 2 { 1.0 } else { -1.0 },
        );
        let at = Vec3::new(x, 0.0, z);
        let found = open.arriving(at);
        assert!(close(found, 8.0 / 18.0 * color, 1e-3), "{place}: {found}");
    }
}

#[test]
fn a_surface_shines_as_its_texture_says() {
    let body = format!(
        "<shape type='rectangle'><emitter type='area'><texture type='bitmap' name='radiance'>{SLIDE}</texture></emitter></shape>"
    );
    let open = Open::new(&body, write_slide);
    let scene = open.scene();
    for (place, color) in CORNERS.into_iter().enumerate() {
        let uv = Vec2::new(
            if place % 2 == 0 { 0.25 } else { 0.75 },
            // v begins at the top of a picture.
            if place < 2 { 0.25 } else { 0.75 },
        );
        let hit = SurfaceHit {
            position: (2.0 * uv - Vec2::ONE).extend(0.0),
            normal: Vec3::Z,
            shading_normal: Vec3::Z,
            primitive: 0,
            barycentric: Vec2::ZERO,
            uv,
        };
        let front = scene.lights.emitted(LightId(0), &hit, Vec3::Z);
        assert!(close(front, color, 1e-3), "{place}: {front}");
        assert_eq!(scene.lights.emitted(LightId(0), &hit, Vec3::NEG_Z), Rgb::ZERO);
    }
}

/// Radiance by Mitsuba 3.9.1 (`scalar_rgb`, which has the same fit of the model): five digits of its `sunsky`'s `eval`.
/// The sun is ten times as wide as it is, for in single precision the solid angle of the real one is off by half a
/// percent there.
#[test]
fn the_sky_is_that_of_the_format() {
    let y_up = "<transform name='to_world'><rotate x='1' angle='-90'/></transform>";
    let afternoon = [
        ([0.0, 0.0, 1.0], [0.024_351, 0.042_309, 0.085_595]),
        ([1.0, 0.0, 1.0], [0.031_592, 0.056_863, 0.110_28]),
        ([0.0, -1.0, 1.0], [0.024_801, 0.048_787, 0.100_39]),
        ([-1.0, -1.0, 0.2], [0.101_28, 0.158_12, 0.233_30]),
    ];
    let given = [
        ([0.0, 1.0, 0.0], [0.049_719, 0.079_713, 0.141_61]),
        ([1.0, 1.0, 0.0], [0.079_440, 0.121_31, 0.197_73]),
        ([0.0, 1.0, -1.0], [0.051_777, 0.094_818, 0.171_52]),
        ([-1.0, 0.2, -1.0], [0.184_47, 0.276_62, 0.385_90]),
        ([1.0, 2.0, 3.0], [107.60, 84.822, 58.198]),
    ];
    let leap_day = [
        ([0.0, 1.0, 0.0], [0.017_373, 0.032_662, 0.065_467]),
        ([1.0, 1.0, 0.0], [0.077_035, 0.101_85, 0.139_74]),
        ([0.0, 1.0, -1.0], [0.023_891, 0.045_071, 0.085_169]),
        ([-1.0, 0.2, -1.0], [0.105_18, 0.161_71, 0.216_49]),
    ];
    let given_body = format!(
        "<float name='turbidity' value='5'/><rgb name='albedo' value='0.1, 0.2, 0.3'/><float name='sun_scale' value='0.5'/>
         <float name='sky_scale' value='2'/><vector name='sun_direction' x='1' y='2' z='3'/>
         <float name='sun_aperture' value='5'/>{y_up}"
    );
    let leap_day_body = format!(
        "<float name='latitude' value='48.5'/><float name='longitude' value='9'/><float name='timezone' value='1'/>
         <integer name='year' value='2024'/><integer name='month' value='2'/><integer name='day' value='29'/>
         <float name='hour' value='11'/><float name='minute' value='30'/><float name='second' value='15'/>{y_up}"
    );
    for (body, expected) in [
        ("", &afternoon[..]),
        (&given_body, &given[..]),
        (&leap_day_body, &leap_day[..]),
    ] {
        let open = Open::new(&format!("<emitter type='sunsky'>{body}</emitter>"), |_| ());
        for &(towards, radiance) in expected {
            let (found, radiance) = (open.radiance(Vec3::from(towards)), Rgb::from(radiance));
            // Five digits, less what is lost in adding up the model's nine terms.
            assert!(
                close(found, radiance, 1e-3),
                "{body} {towards:?}: {found}, not {radiance}"
            );
        }
    }
}

#[test]
fn what_shines_reflects_nothing_unless_it_has_a_bsdf() {
    let lamp = "<emitter type='area'/>";
    let body = format!(
        "<shape type='disk'>{lamp}</shape><shape type='disk'>{lamp}<bsdf type='diffuse'/></shape><shape type='disk'/>"
    );
    let scene = Open::new(&body, |_| ()).scene();
    let reflectance = |shape: usize| {
        let slot = scene.surfaces.slots[scene.surfaces.first_slot[shape] as usize];
        match scene.materials.get(slot.material) {
            Some(Packed::Plain(Bsdf::Diffuse(diffuse))) => diffuse.reflectance,
            other => panic!("{other:?}"),
        }
    };
    assert_eq!(
        [0, 1, 2].map(reflectance),
        [Rgb::ZERO, Rgb::splat(0.5), Rgb::splat(0.5)]
    );
}

#[test]
fn lights_are_chosen_by_their_sampling_weight() {
    let body = "<emitter type='point'><point name='position' value='1, 0, 0'/><float name='sampling_weight' value='3'/></emitter>
        <emitter type='point'><point name='position' value='-1, 0, 0'/></emitter>
        <emitter type='point'><point name='position' value='0, 1, 0'/><float name='sampling_weight' value='0'/></emitter>";
    let scene = Open::new(body, |_| ()).scene();
    for step in 0..20 {
        let sample = sample(&scene, Vec3::ZERO, (step as f32 + 0.5) / 20.0).expect("both shine here");
        let expected = if sample.wi.x > 0.0 { 0.75 } else { 0.25 };
        assert!(
            sample.wi.y.abs() < 1e-6 && (sample.pdf - expected).abs() < 1e-3,
            "{sample:?}"
        );
    }
}

/// A square that faces +z as an OBJ or PLY file, with or without vertex normals.
fn write_squares(folder: &Path) {
    const CORNERS: [&str; 4] = ["-1 -1 0", "1 -1 0", "1 1 0", "-1 1 0"];
    let vertices: String = CORNERS.map(|corner| format!("v {corner}\n")).concat();
    std::fs::write(folder.join("plain.obj"), format!("{vertices}f 1 2 3\nf 1 3 4\n")).unwrap();
    let with_normals = format!("{vertices}vn 0 0 1\nf 1//1 2//1 3//1\nf 1//1 3//1 4//1\n");
    std::fs::write(folder.join("normals.obj"), with_normals).unwrap();
    for (name, properties, normal) in [("plain", "x y z", ""), ("normals", "x y z nx ny nz", " 0 0 1")] {
        let properties: String = properties
            .split(' ')
            .map(|it| format!("property float {it}\n"))
            .collect();
        let vertices: String = CORNERS.map(|corner| format!("{corner}{normal}\n")).concat();
        let text = format!(
            "ply\nformat ascii 1.0\nelement vertex 4\n{properties}element face 2\n\
             property list uchar int vertex_indices\nend_header\n{vertices}3 0 1 2\n3 0 2 3\n"
        );
        std::fs::write(folder.join(format!("{name}.ply")), text).unwrap();
    }
}

/// The side that shines, which is that of the shading normal, as Mitsuba 3.9.1 has it (`scalar_rgb`; `eval` and
/// `sample_direction` of the `area` emitter agree but for mirrored cylinders, where the former counts). Per shape for a
/// `to_world` that does nothing, mirrors x, and mirrors z: 1 is +z of a flat shape and the outside of a closed one.
/// `flip_normals` turns all of them around. Spheres are the exception: those that a transform mirrors shine inwards
/// there.
#[test]
fn mirrored_lights_shine_to_the_side_that_they_shine_to_in_mitsuba() {
    const FLAT: bool = false;
    const CLOSED: bool = true;
    let mut table: Vec<(String, bool, [i32; 3])> = [
        ("type='rectangle'>", FLAT, [1, 1, -1]),
        ("type='disk'>", FLAT, [1, 1, -1]),
        ("type='cube'>", CLOSED, [1, 1, 1]),
        ("type='sphere'>", CLOSED, [1, 1, 1]),
        (
            "type='cylinder'><point name='p0' value='0 0 -1'/><point name='p1' value='0 0 1'/>",
            CLOSED,
            [1, 1, 1],
        ),
    ]
    .map(|(shape, kind, sides)| (shape.to_owned(), kind, sides))
    .into();
    for plugin in ["obj", "ply"] {
        for (file, face_normals, sides) in [
            ("normals", false, [1, 1, -1]),
            ("normals", true, [1, -1, 1]),
            ("plain", false, [1, -1, 1]),
            ("plain", true, [1, -1, 1]),
        ] {
            let shape = format!(
                "type='{plugin}'><string name='filename' value='{file}.{plugin}'/>\
                 <boolean name='face_normals' value='{face_normals}'/>"
            );
            table.push((shape, FLAT, sides));
        }
    }
    let (mut body, mut cases) = (String::new(), Vec::new());
    for (shape, is_closed, sides) in &table {
        for (mirror, side) in ["1 1 1", "-1 1 1", "1 1 -1"].into_iter().zip(sides) {
            for flips in [false, true] {
                let place = Vec3::X * 10.0 * cases.len() as f32;
                body += &format!(
                    "<shape {shape}<transform name='to_world'><scale value='{mirror}'/><translate x='{}'/></transform>\
                     <boolean name='flip_normals' value='{flips}'/>\
                     <emitter type='area'/></shape>\n",
                    place.x
                );
                let side = if flips { -side } else { *side };
                cases.push((format!("{shape} {mirror} {flips}"), *is_closed, place, side));
            }
        }
    }
    let scene = Open::new(&body, write_squares).scene();
    for (case, is_closed, place, side) in cases {
        for seen_side in [1, -1] {
            let (from, dir) = match (is_closed, seen_side) {
                (CLOSED, 1) => (Vec3::new(0.1, 5.0, 0.2), Vec3::NEG_Y),
                (CLOSED, _) => (Vec3::new(0.1, 0.0, 0.2), Vec3::Y),
                (FLAT, _) => (Vec3::new(0.1, 0.2, 5.0 * seen_side as f32), Vec3::Z * -seen_side as f32),
            };
            let ray = Ray::new(place + from, dir);
            let hit = scene
                .geometry
                .intersect(&ray)
                .unwrap_or_else(|| panic!("{case}: no hit"));
            let point = scene.geometry.surface(&ray, &hit);
            let light = scene.slot(&hit).light.unwrap_or_else(|| panic!("{case}: no light"));
            let on_light = SurfaceHit::at(&hit, &point);
            let shines = side == seen_side;
            let emitted = scene.lights.emitted(light, &on_light, -dir);
            assert_eq!(emitted != Rgb::ZERO, shines, "{case}, from {seen_side}: emission");
            assert_eq!(
                point.shading_normal.dot(-dir) > 0.0,
                shines,
                "{case}, from {seen_side}: front"
            );
            // From outside the far inner side of a closed shape can be chosen, though the near one hides it.
            if is_closed && seen_side == 1 && !shines {
                continue;
            }
            let reference = LightReference {
                position: ray.origin,
                normal: None,
            };
            let chosen = (0..512u32).any(|index| {
                let sampler = Sampler::new(SequenceKind::Sobol, UVec2::ZERO, index, 1);
                let (u_choice, u) = (sampler.at_1d(0), sampler.at_2d(1));
                let sample = scene.lights.sample(&reference, u_choice, u);
                sample.is_some_and(|(id, _)| id == light)
            });
            assert_eq!(chosen, shines, "{case}, from {seen_side}: sampling");
        }
    }
}
