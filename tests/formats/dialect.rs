//! The course project's scene files: how each part of them is read, and that they come through conversion.

use std::path::{Path, PathBuf};

use bevy::math::{Affine3A, Mat3, Vec3};
use sunroom::document::{self, Diagnostics, Severity};
use sunroom::scene::description::MaterialDescription;
use sunroom::scene::read::read;
use sunroom::scene::write::{Extensions, SaveError, files, write_anew};
use sunroom::scene::{
    EmitterKind, FovAxis, Ior, Material, PathPlugin, ReconstructionFilter, SceneDescription, Shape, ShapeKind,
};

fn read_text(text: &str, path: &Path, defines: &[(String, String)]) -> (SceneDescription, Diagnostics) {
    let mut document = document::parse_str(text, path, defines);
    let scene = read(&mut document);
    (scene, document.diagnostics)
}

fn read_file(path: &Path) -> (SceneDescription, Diagnostics) {
    let mut document = document::load(path, &[]).unwrap();
    let scene = read(&mut document);
    (scene, document.diagnostics)
}

/// A whole scene around these parts, which is read without a warning.
fn describe(materials: &str, objects: &str) -> SceneDescription {
    let (scene, diagnostics) = messages_of(materials, objects);
    let worst = diagnostics
        .list
        .iter()
        .map(|message| message.severity)
        .collect::<Vec<_>>();
    assert!(
        worst.iter().all(|severity| *severity == Severity::Note),
        "{diagnostics}"
    );
    scene
}

fn messages_of(materials: &str, objects: &str) -> (SceneDescription, Diagnostics) {
    let text = format!(
        "<?xml version='1.0'?>\n<ItemContainer><Config><Width value='100'/><Aspect_ratio value='1.5'/><Samples_Per_Pixel value='4'/>\
         <Max_Depth value='3'/></Config><Camera/><Lights><Sun/></Lights>\n<Materials>{materials}</Materials>\n<Objects>{objects}</Objects></ItemContainer>"
    );
    read_text(&text, &std::env::temp_dir().join("dialect.xml"), &[])
}

/// Whether one of the messages of this severity contains the text.
fn says(diagnostics: &Diagnostics, severity: Severity, part: &str) -> bool {
    let mut all = diagnostics.list.iter().filter(|message| message.severity == severity);
    all.any(|message| message.message.contains(part))
}

/// The material under a `twosided`.
fn inner<'s>(scene: &'s SceneDescription, id: &str) -> &'s Material {
    let outer = material(scene, id);
    match outer.first {
        Some(inner) => &scene.materials[inner].material,
        None => &outer.material,
    }
}

fn material<'s>(scene: &'s SceneDescription, id: &str) -> &'s MaterialDescription {
    let mut all = scene.materials.iter();
    all.find(|material| material.identity.id.as_deref() == Some(id))
        .unwrap()
}

#[test]
fn config_and_camera_give_the_film_and_the_view() {
    let text = "<ItemContainer><Config><Width value='101'/><Aspect_ratio value='1.77777'/><Samples_Per_Pixel value='7'/><Max_Depth value='5'/></Config>
      <Camera><Look_From x='1' y='2' z='3'/><Look_at x='1' y='2' z='-7'/><FOV angle='60'/><Focal_Length value='9'/></Camera>
      <Lights><Sun/></Lights><Objects/></ItemContainer>";
    let (scene, diagnostics) = read_text(text, Path::new("/tmp/a.xml"), &[]);
    assert!(!diagnostics.has_errors(), "{diagnostics}");
    let sensor = &scene.sensors[0];
    // 101 / 1.77777 = 56.8, cut.
    assert_eq!(
        (sensor.film.width, sensor.film.height, sensor.film.sample_count),
        (101, 56, 7)
    );
    assert_eq!(sensor.film.filter, ReconstructionFilter::Box);
    assert_eq!((sensor.sensor.fov, sensor.sensor.fov_axis), (60.0, FovAxis::Y));
    assert_eq!(scene.integrator.max_depth, Some(5));
    let pose = sensor.to_world;
    assert!(Vec3::from(pose.translation) == Vec3::new(1.0, 2.0, 3.0));
    assert!(Vec3::from(pose.matrix3.z_axis).abs_diff_eq(Vec3::NEG_Z, 1e-6));
    assert!(Vec3::from(pose.matrix3.y_axis).abs_diff_eq(Vec3::Y, 1e-6));

    let odd = "<ItemContainer><Config><Width value=''/></Config><Camera><Look_at z='1'/></Camera><Objects/><Wood/></ItemContainer>";
    let (scene, diagnostics) = read_text(odd, Path::new("/tmp/a.xml"), &[]);
    assert!(!diagnostics.has_errors(), "{diagnostics}");
    for part in [
        "<Width> is empty; 800 takes its place",
        "looks at where it stands",
        "<Wood> is not known",
        "no <Sun>",
    ] {
        assert!(says(&diagnostics, Severity::Warning, part), "{part}: {diagnostics}");
    }
    assert_eq!((scene.sensors[0].film.width, scene.sensors[0].film.height), (800, 450));
    assert!(scene.emitters.is_empty());
}

/// What is typed wrong is an error with its place: none of it is replaced without being asked.
#[test]
fn slips_of_the_hand_are_errors() {
    let config = |inside: &str| format!("<Config>{inside}</Config><Camera/><Lights><Sun/></Lights><Objects/>");
    let camera = |inside: &str| format!("<Camera>{inside}</Camera><Lights><Sun/></Lights><Objects/>");
    let objects = |inside: &str| format!("<Camera/><Lights><Sun/></Lights><Objects>{inside}</Objects>");
    let ball = |inside: &str| objects(&format!("<Sphere>{inside}</Sphere>"));
    for (text, place, expected) in [
        (
            config("<Width value='wide'/>"),
            "2:23",
            "expected a number, found `wide`",
        ),
        (config("<Width value='8o0'/>"), "2:23", "expected a number, found `8o0`"),
        (config("<Width value='nan'/>"), "2:23", "expected a number, found `nan`"),
        (
            config("<Width value='0'/>"),
            "2:23",
            "expected 1 or more for <Width>, found 0",
        ),
        (
            config("<Aspect_ratio value='0'/>"),
            "2:30",
            "expected 0.001 or more for <Aspect_ratio>, found 0",
        ),
        (
            config("<Samples value='-4'/>"),
            "2:25",
            "expected 1 or more for <Samples>, found -4",
        ),
        (
            config("<Depth value='0'/>"),
            "2:23",
            "expected 1 or more for <Depth>, found 0",
        ),
        (
            camera("<FOV angle='200'/>"),
            "2:9",
            "expected a field of view between 0 and 180 degrees, found 200",
        ),
        (camera("<Look_at x='1,5'/>"), "2:21", "expected a number, found `1,5`"),
        (ball("<Radius value='big'/>"), "2:65", "expected a number, found `big`"),
        (
            objects("<Triangle><V0/><V1 x='1'/><V2 y='high'/></Triangle>"),
            "2:75",
            "expected a number, found `high`",
        ),
        (
            objects("<Quad><U x='wide'/></Quad>"),
            "2:54",
            "expected a number, found `wide`",
        ),
    ] {
        let text = format!("<ItemContainer>\n{text}</ItemContainer>");
        let (_, diagnostics) = read_text(&text, Path::new("/tmp/a.xml"), &[]);
        let said = diagnostics.to_string();
        assert_eq!(diagnostics.error_count(), 1, "{said}");
        assert!(
            said.contains(&format!("a.xml:{place}: error: {expected}")),
            "{place} {expected}: {said}"
        );
        // Nothing is said of what follows from it.
        assert!(!said.contains("is left out") && !said.contains("is none"), "{said}");
    }
}

/// They would be read as if they were not there.
#[test]
fn attributes_that_are_not_known_are_told_of() {
    let told = |text: &str| {
        let text = format!("<ItemContainer>\n{text}</ItemContainer>");
        let (_, diagnostics) = read_text(&text, Path::new("/tmp/a.xml"), &[]);
        assert!(!diagnostics.has_errors(), "{diagnostics}");
        diagnostics.to_string()
    };
    let rest = "<Lights><Sun/></Lights>";
    for (text, place, expected) in [
        (
            format!("<Config Width='wide'/><Camera/>{rest}<Objects/>"),
            "2:9",
            "the attribute `Width` is not known in <Config>, which has none; it is ignored",
        ),
        (
            format!("<Config><Width Value='5'/></Config><Camera/>{rest}<Objects/>"),
            "2:16",
            "the attribute `Value` is not known in <Width>, which has `value`; it is ignored",
        ),
        (
            format!("<Config/><Camera/>{rest}<Objects><Sphere Radius='big'/></Objects>"),
            "2:59",
            "the attribute `Radius` is not known in <Sphere>, which has `name`, `material`; it is ignored",
        ),
        (
            format!("<Config/><Camera/>{rest}<Objects><Sphere><Center X='1'/></Sphere></Objects>"),
            "2:67",
            "the attribute `X` is not known in <Center>, which has `x`, `y`, `z`; it is ignored",
        ),
    ] {
        let said = told(&text);
        assert!(
            said.contains(&format!("a.xml:{place}: warning: {expected}")),
            "{expected}: {said}"
        );
        assert_eq!(said.matches("is not known").count(), 1, "{said}");
    }
    // An element that is not known is told of alone.
    let said = told(&format!("<Config/><Camera/>{rest}<Objects/><Wood grain='3'/>"));
    assert!(
        said.contains("<Wood> is not known") && !said.contains("grain` is"),
        "{said}"
    );
}

#[test]
fn the_second_variant_has_other_names() {
    let text = "<Scene><Config><Width value='128'/><Height value='72'/><Samples value='3'/><Depth value='12'/></Config>
      <Camera><LookFrom x='0' y='3' z='8'/><LookAt x='0' y='1' z='0'/><FOV value='45'/></Camera><Sun><Dir x='0' y='0' z='2'/><Intensity value='1.5'/></Sun>
      <Materials><Lambertian name='floor'><Color r='.9' g='.8' b='.7'/></Lambertian></Materials>
      <Objects><Sphere material='floor'><Center x='1' y='2' z='3'/><Radius value='4'/></Sphere>
      <Triangle material='floor'><Vertex0 x='0' y='0' z='0'/><Vertex1 x='1' y='0' z='0'/><Vertex2 x='0' y='1' z='0'/></Triangle></Objects></Scene>";
    let (scene, diagnostics) = read_text(text, Path::new("/tmp/a.xml"), &[]);
    assert_eq!(
        diagnostics.warning_count() + diagnostics.error_count(),
        0,
        "{diagnostics}"
    );
    assert_eq!((scene.sensors[0].film.width, scene.sensors[0].film.height), (128, 72));
    assert_eq!(scene.sensors[0].sensor.fov, 45.0);
    let EmitterKind::Directional { irradiance } = scene.emitters[0].emitter.kind else {
        panic!("{:?}", scene.emitters)
    };
    assert_eq!(irradiance, Vec3::splat(1.5));
    assert!(Vec3::from(scene.emitters[0].to_world.matrix3.z_axis).abs_diff_eq(Vec3::NEG_Z, 1e-6));
    let sphere = &scene.shapes[0];
    assert!(
        matches!(sphere.shape.kind, ShapeKind::Sphere { center, radius: 4.0 } if center == Vec3::new(1.0, 2.0, 3.0))
    );
    assert_eq!(sphere.material, scene.shapes[1].material);
}

#[test]
fn materials_become_those_of_the_format() {
    let scene = describe(
        "<Lambertian name='l'><Color r='.1' g='.2' b='.3'/></Lambertian><Metal name='m'><Color r='1' g='.5' b='0'/><Fuzz value='3'/></Metal>
         <Dielectric name='d'><Color r='0' g='0' b='0'/><IOR value='1.33'/></Dielectric><Dielectric name='r'><Refraction_Index value='2.4'/></Dielectric>
         <Lambertian name='plain'/>",
        "",
    );
    let diffuse = |color: Vec3| Material::Diffuse {
        reflectance: color.into(),
    };
    assert_eq!(inner(&scene, "l"), &diffuse(Vec3::new(0.1, 0.2, 0.3)));
    assert_eq!(material(&scene, "l").material, Material::TwoSided);
    assert_eq!(inner(&scene, "plain"), &diffuse(Vec3::splat(0.5)));
    let metal = Material::Metal {
        reflectance: Vec3::new(1.0, 0.5, 0.0).into(),
        fuzz: 1.0.into(),
    };
    assert_eq!(inner(&scene, "m"), &metal);
    for (id, ior) in [("d", 1.33), ("r", 2.4)] {
        let tint = Vec3::new(0.95, 0.97, 1.0);
        let expected = Material::Dielectric {
            interior: Ior::Number(ior),
            exterior: Ior::Number(1.0),
            specular_reflectance: tint.into(),
            specular_transmittance: tint.into(),
        };
        assert_eq!(inner(&scene, id), &expected);
    }
}

#[test]
fn lights_shine_and_reflect_nothing() {
    let ball = |material: &str| format!("<Sphere><Material name='{material}'/></Sphere>");
    let materials = "<Emissive name='s'><Color r='1' g='.5' b='0'/><Strength value='4'/></Emissive><Emissive name='i'><Intensity value='3'/></Emissive>";
    let scene = describe(materials, &format!("{}{}{}", ball("s"), ball("i"), ball("emissive")));
    let radiance: Vec<Vec3> = scene
        .shapes
        .iter()
        .map(|shape| shape.area_light.as_ref().unwrap().radiance.constant().unwrap())
        .collect();
    assert_eq!(radiance, [Vec3::new(4.0, 2.0, 0.0), Vec3::splat(1.5), Vec3::ONE]);
    let black = Material::Diffuse {
        reflectance: Vec3::ZERO.into(),
    };
    assert!(
        scene
            .shapes
            .iter()
            .all(|shape| scene.materials[shape.material.unwrap()].material == black)
    );
}

#[test]
fn names_of_materials_lead_to_the_last_of_that_name_or_to_what_is_built_in() {
    let ball = |material: &str| format!("<Sphere><Material name='{material}'/></Sphere>");
    let materials = "<Lambertian name='a'><Color r='0' g='0' b='0'/></Lambertian><Lambertian name='a'><Color r='1' g='1' b='1'/></Lambertian><Wood name='w'/><Metal/>";
    let objects: String = ["a", "shinyGold", "w", "nothing"].map(ball).concat();
    let (scene, diagnostics) = messages_of(materials, &(objects + "<Sphere name='a'/>"));
    let looks: Vec<&Material> = scene
        .shapes
        .iter()
        .map(|shape| {
            let outer = &scene.materials[shape.material.unwrap()];
            &scene.materials[outer.first.unwrap()].material
        })
        .collect();
    assert_eq!(
        looks[0],
        &Material::Diffuse {
            reflectance: Vec3::ONE.into(),
        }
    );
    assert!(matches!(looks[1], Material::Metal { fuzz, .. } if fuzz.constant() == Some(1.0)));
    let grey = Material::Diffuse {
        reflectance: Vec3::splat(0.5).into(),
    };
    assert_eq!(looks[2..], [&grey, &grey, &grey]);
    for part in [
        "`a` is given again",
        "<Wood> is no kind",
        "without a name",
        "no material `nothing`",
    ] {
        assert!(says(&diagnostics, Severity::Warning, part), "{part}: {diagnostics}");
    }
    // The material has the id already.
    assert_eq!(scene.shapes[4].identity.id.as_deref(), Some("a-2"));
}

#[test]
fn spheres_stay_round_and_quads_are_where_their_edges_say() {
    let (scene, diagnostics) = messages_of(
        "",
        "<Sphere><Radius value='2'/><Position x='1' y='2' z='3'/><Scale x='1' y='1' z='11'/></Sphere>
         <Quad><Position x='1' y='2' z='3'/><U x='4' y='0' z='0'/><V x='1' y='5' z='0'/></Quad><Quad><U x='0' y='0' z='1'/></Quad>
         <Triangle><V0 x='1' y='0' z='0'/><V1 x='0' y='2' z='0'/></Triangle>",
    );
    assert_eq!(scene.shapes.len(), 2);
    assert_eq!(scene.shapes[0].to_world, Affine3A::IDENTITY);
    assert!(says(&diagnostics, Severity::Note, "stay round"));
    assert!(says(&diagnostics, Severity::Warning, "a quad without an area"));
    assert!(says(&diagnostics, Severity::Warning, "without three corners"));
    let quad = scene.shapes[1].to_world;
    for (corner, expected) in [
        (Vec3::new(-1.0, -1.0, 0.0), Vec3::new(1.0, 2.0, 3.0)),
        (Vec3::new(1.0, -1.0, 0.0), Vec3::new(5.0, 2.0, 3.0)),
        (Vec3::new(-1.0, 1.0, 0.0), Vec3::new(2.0, 7.0, 3.0)),
    ] {
        assert!(quad.transform_point3(corner).abs_diff_eq(expected, 1e-5));
    }
}

const TRIANGLE: &str = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";

#[test]
fn meshes_are_found_turned_in_degrees_and_left_out_when_missing() {
    let folder = tempfile::tempdir().unwrap();
    let scenes = folder.path().join("course/scenes");
    let models = folder.path().join("course/assets/models");
    std::fs::create_dir_all(&scenes).unwrap();
    std::fs::create_dir_all(&models).unwrap();
    std::fs::write(models.join("a.obj"), TRIANGLE).unwrap();
    std::fs::write(
        models.join("own.obj"),
        format!("mtllib own.mtl\nusemtl red\n{TRIANGLE}"),
    )
    .unwrap();
    std::fs::write(models.join("own.mtl"), "newmtl red\nKd 1 0 0\n").unwrap();
    let mesh = |name: &str, more: &str| format!("<Mesh><File name='{name}'/>{more}<Material name='shinyGold'/></Mesh>");
    let turned = "<Position x='1' y='2' z='3'/><Scale x='2' y='3' z='4'/><Rotation x='90' y='30' z='-60'/>";
    let objects = [
        mesh("C:/Users/me/a.obj", turned),
        mesh("models/own.obj", ""),
        mesh("none.obj", ""),
        mesh("a.obj", "<Scale x='0' y='1' z='1'/>"),
    ];
    let text = format!(
        "<ItemContainer><Lights><Sun/></Lights><Objects>{}</Objects></ItemContainer>",
        objects.concat()
    );
    let path = scenes.join("room.xml");
    let (scene, diagnostics) = read_text(&text, &path, &[]);
    assert!(!diagnostics.has_errors(), "{diagnostics}");
    assert_eq!(scene.shapes.len(), 2);
    assert!(
        says(&diagnostics, Severity::Warning, "`none.obj`; the object is left out"),
        "{diagnostics}"
    );
    assert!(says(&diagnostics, Severity::Warning, "scaled by 0"));
    assert!(says(&diagnostics, Severity::Note, "rotations are read as degrees"));
    assert!(says(&diagnostics, Severity::Note, "win over `shinyGold`"));
    assert_eq!(scene.shapes[1].material, None);
    let ShapeKind::Mesh(file) = &scene.shapes[0].shape.kind else {
        panic!("no mesh")
    };
    assert!(file.face_normals && file.path.ends_with("course/assets/models/a.obj"));

    // Written out: T RX RY RZ S.
    let product = |[x, y, z]: [f32; 3]| {
        let turn = Mat3::from_rotation_x(x) * Mat3::from_rotation_y(y) * Mat3::from_rotation_z(z);
        let scaled = turn * Mat3::from_diagonal(Vec3::new(2.0, 3.0, 4.0));
        Affine3A::from_mat3_translation(scaled, Vec3::new(1.0, 2.0, 3.0))
    };
    let degrees = [90.0f32, 30.0, -60.0];
    let expected = product(degrees.map(f32::to_radians));
    assert!(scene.shapes[0].to_world.abs_diff_eq(expected, 1e-5));
    let define = |value: &str| vec![("rotation".to_owned(), value.to_owned())];
    let (scene, _) = read_text(&text, &path, &define("radians"));
    assert!(scene.shapes[0].to_world.abs_diff_eq(product(degrees), 1e-4));
    let (_, diagnostics) = read_text(&text, &path, &define("turns"));
    assert!(says(&diagnostics, Severity::Warning, "expected `degrees` or `radians`"));
}

#[test]
fn a_dark_sun_gives_no_sky_and_point_lights_are_read_wherever_they_stand() {
    let text = |sun: &str| {
        format!(
            "<ItemContainer><Lights><Sun><Intensity value='{sun}'/><Color r='3' g='0' b='0'/></Sun><PointLight name='one' enabled='false'/>
             <PointLights><PointLight name='two'><Position x='1' y='2' z='3'/><Color r='1' g='.5' b='0'/><Intensity value='30'/></PointLight></PointLights></Lights><Objects/></ItemContainer>"
        )
    };
    let emitters = |sun| read_text(&text(sun), Path::new("/tmp/a.xml"), &[]).0.emitters;
    let dark = emitters("0");
    assert_eq!(dark.len(), 1);
    assert_eq!(
        dark[0].emitter.kind,
        EmitterKind::Point {
            intensity: Vec3::new(30.0, 15.0, 0.0)
        }
    );
    assert_eq!(Vec3::from(dark[0].to_world.translation), Vec3::new(1.0, 2.0, 3.0));
    let half = emitters("0.5");
    assert_eq!(half.len(), 3);
    let EmitterKind::Constant { radiance } = half[1].emitter.kind else {
        panic!("{half:?}")
    };
    // Half of the mean of the sky, whose red runs from 1 to 0.5 above and below, staying there for half of the way
    // below.
    assert!((radiance.x - 0.5 * 0.6875).abs() < 1e-6, "{radiance}");
}

#[test]
fn what_is_no_xml_is_one_error_with_its_place() {
    for (text, line) in [
        ("<ItemContainer>\n<Config>\n</ItemContainer>", 3),
        ("<ItemContainer>\n<Objects>", 2),
        ("<!-- <ItemContainer> <!-- a -->\n</Camera>\n</ItemContainer> -->", 2),
    ] {
        let (_, diagnostics) = read_text(text, Path::new("/tmp/a.xml"), &[]);
        assert_eq!(diagnostics.error_count(), 1, "{diagnostics}");
        let error = diagnostics
            .list
            .iter()
            .find(|message| message.severity == Severity::Error)
            .unwrap();
        let place = error
            .span
            .and_then(|span| diagnostics.locate(span))
            .map(|place| place.1);
        assert_eq!(place, Some(line), "{diagnostics}");
    }
}

fn shared_scenes() -> Vec<PathBuf> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let mut folders = root
        .ancestors()
        .skip(1)
        .map(|folder| folder.join("shared/data/csi-scenes"));
    let Some(folder) = folders.find(|folder| folder.is_dir()) else {
        println!("skipped: no scenes of the course project");
        return Vec::new();
    };
    let entries = std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path());
    let mut files: Vec<PathBuf> = entries
        .filter(|path| path.extension().is_some_and(|e| e == "xml"))
        .collect();
    files.sort();
    files
}

/// What can be compared: without names, places in files, and the difference between a triangle and a mesh of one.
fn shapes(scene: &SceneDescription) -> Vec<(Option<Shape>, [Vec3; 3], Option<Vec3>, Option<usize>)> {
    let unit = [Vec3::ZERO, Vec3::X, Vec3::Y];
    let each = scene.shapes.iter().map(|shape| {
        let light = shape.area_light.as_ref().and_then(|light| light.radiance.constant());
        let (kind, corners) = match &shape.shape.kind {
            ShapeKind::Triangle { corners } => (None, *corners),
            ShapeKind::Mesh(file) if file.path.to_string_lossy().ends_with(".triangle.obj") => (None, unit),
            _ => (Some(shape.shape.clone()), unit),
        };
        let corners = corners.map(|corner| shape.to_world.transform_point3(corner));
        // To the rounding of an edge added to a corner.
        (
            kind,
            corners.map(|corner| (corner * 1e4).round()),
            light,
            shape.material,
        )
    });
    each.collect()
}

#[test]
fn every_scene_opens_and_comes_through_conversion() {
    let folder = tempfile::tempdir().unwrap();
    for path in shared_scenes() {
        let (scene, diagnostics) = read_file(&path);
        if path.to_string_lossy().contains("commented_prolog") {
            assert_eq!(diagnostics.error_count(), 1, "{diagnostics}");
            continue;
        }
        assert!(!diagnostics.has_errors(), "{diagnostics}");
        assert!(
            !scene.shapes.is_empty() && scene.sensors.len() == 1,
            "{}",
            path.display()
        );
        let target = folder.path().join(path.file_name().unwrap());
        write_anew(&scene, &target, Extensions::Keep).unwrap();
        let (again, diagnostics) = read_file(&target);
        assert!(!diagnostics.has_errors(), "{diagnostics}");
        assert_eq!(shapes(&again), shapes(&scene), "{}", path.display());
        let sensor = |scene: &SceneDescription| {
            let sensor = &scene.sensors[0];
            (sensor.sensor, sensor.film, sensor.to_world)
        };
        assert_eq!(sensor(&again), sensor(&scene));
        assert_eq!(again.integrator, scene.integrator);
        let emitters = |scene: &SceneDescription| {
            scene
                .emitters
                .iter()
                .map(|e| (e.emitter.clone(), e.to_world))
                .collect::<Vec<_>>()
        };
        assert_eq!(emitters(&again), emitters(&scene));
        assert_eq!(again.materials.len(), scene.materials.len());
        // Its own text is not replaced by another format without being asked.
        assert!(matches!(files(&scene, &path), Err(SaveError::Foreign { .. })));
        assert!(matches!(
            write_anew(&scene, &path, Extensions::Keep),
            Err(SaveError::Foreign { .. })
        ));
    }
}

#[test]
fn metal_is_written_in_words_of_mitsuba_where_there_are_some() {
    let folder = tempfile::tempdir().unwrap();
    let scene = describe(
        "<Metal name='sharp'><Color r='1' g='.5' b='0'/></Metal><Metal name='fuzzy'><Fuzz value='0.5'/></Metal>",
        "",
    );
    let written = |extensions| {
        let target = folder.path().join("new.xml");
        write_anew(&scene, &target, extensions).unwrap();
        std::fs::read_to_string(target).unwrap()
    };
    let kept = written(Extensions::Keep);
    assert_eq!(kept.matches("\"conductor\"").count(), 1, "{kept}");
    assert_eq!(kept.matches("\"metal\"").count(), 1, "{kept}");
    assert!(
        kept.contains("<rgb name=\"specular_reflectance\" value=\"1, 0.5, 0\"/>"),
        "{kept}"
    );
    let portable = written(Extensions::Approximate);
    assert!(
        !portable.contains("metal") && portable.contains("\"roughconductor\""),
        "{portable}"
    );
    assert!(
        portable.contains("<float name=\"alpha\" value=\"0.15811388\"/>"),
        "{portable}"
    );
}

/// Christensen and Burley 2015: the mean free path of a reflectance of 0.8 is 1.1 times the distance.
#[test]
fn light_goes_below_the_surface_of_closed_things() {
    let wax = "<SSS name='wax'><Color r='0.8' g='0.8' b='0.8'/><ScatterColor r='1' g='0.5' b='0'/><ScatterDistance value='0.5'/></SSS>";
    let objects = "<Sphere name='ball' material='wax'/><Quad name='sheet' material='wax'/>";
    let scene = describe(wax, objects);
    let [ball, sheet] = ["ball", "sheet"].map(|id| {
        let mut shapes = scene.shapes.iter();
        shapes
            .find(|shape| shape.identity.id.as_deref() == Some(id))
            .expect("a shape")
    });
    let (sigma_t, albedo) = scene.media[ball.interior.expect("a medium")]
        .medium
        .coefficients
        .sigma_t_and_albedo();
    let path = sigma_t.constant().expect("the same everywhere").recip();
    let expected = Vec3::new(0.55, 0.275, 0.0055);
    assert!(path.abs_diff_eq(expected, 1e-5), "{path}");
    let albedo = albedo.constant().expect("the same everywhere");
    assert!(albedo.abs_diff_eq(Vec3::splat(0.990_08), 1e-4), "{albedo}");
    let of = |shape: &sunroom::scene::description::ShapeDescription| {
        &scene.materials[shape.material.expect("a material")].material
    };
    assert_eq!((of(ball), of(sheet)), (&Material::Null, &Material::TwoSided));
    assert_eq!(sheet.interior, None);
    assert_eq!(
        (scene.integrator.plugin, scene.integrator.max_depth),
        (PathPlugin::VolPath, Some(256))
    );
    let (_, diagnostics) = messages_of(wax, objects);
    for part in [
        "light goes below the surface of <SSS>",
        "a depth of 3 is too little",
        "only closed objects have an inside",
    ] {
        assert!(says(&diagnostics, Severity::Note, part), "{diagnostics}");
    }
    // Without a distance it is what the original shows.
    for scattered in ["", "<ScatterDistance value='0'/>", "<ScatterDistance value='-1'/>"] {
        let wax = format!("<SSS name='wax'><Color r='0.8' g='0.1' b='0'/>{scattered}</SSS>");
        let scene = describe(&wax, objects);
        assert_eq!(scene.media.len(), 0);
        assert_eq!(scene.integrator.plugin, PathPlugin::Path);
        assert!(matches!(inner(&scene, "wax"), Material::Diffuse { .. }));
    }
}
