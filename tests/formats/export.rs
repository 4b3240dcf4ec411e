//! Scenes that are exported to glTF: read again they are the same scene, and show the same picture, but for what the
//! messages say.

use std::path::Path;

use bevy::math::{Affine3A, Vec3};
use sunroom::color::luminance;
use sunroom::document::parse_str;
use sunroom::files::Access;
use sunroom::geometry::mesh::MeshData;
use sunroom::scene::assets::scene_asset::read_scene;
use sunroom::scene::assets::triangle_mesh::load_mesh;
use sunroom::scene::description::{EmitterDescription, MaterialDescription, ShapeDescription};
use sunroom::scene::export::{Export, Hidden, export};
use sunroom::scene::read::read;
use sunroom::scene::*;

use crate::workshop::Workshop;

impl Workshop {
    /// The warnings of the program when it exports a scene.
    #[track_caller]
    fn convert(&self, scene: &str, output: &str) -> Vec<String> {
        let mut said = self.said_of_export(scene, output);
        said.retain(|line| !line.starts_with("note: "));
        said
    }

    #[track_caller]
    fn said_of_export(&self, scene: &str, output: &str) -> Vec<String> {
        let output = self.sunroom(&["convert", scene, output]);
        let said = String::from_utf8_lossy(&output.stderr).into_owned();
        assert!(output.status.success(), "{said}");
        said.lines().map(str::to_owned).collect()
    }

    fn describe(&self, name: &str) -> SceneDescription {
        let path = self.path(name);
        let bytes = std::fs::read(&path).expect("the file is there");
        let asset = read_scene(bytes, &path, &[]);
        assert!(!asset.diagnostics.has_errors(), "{}", asset.diagnostics.render(false));
        SceneDescription::clone(&asset.description)
    }

    /// The scene after the way through a file of this name, without messages.
    #[track_caller]
    fn round_trip(&self, xml: &str, file: &str) -> SceneDescription {
        self.put("scene.xml", xml);
        let said = self.convert("scene.xml", file);
        assert_eq!(said, [""; 0]);
        self.describe(file)
    }

    /// The pixels of a picture of the scene.
    fn render(&self, scene: &str, options: &[&str]) -> Vec<Vec3> {
        self.done(&[&["render", scene, "-o", "picture.exr", "-q"], options].concat());
        let bytes = std::fs::read(self.path("picture.exr")).expect("it is there");
        let image = sunroom::texture::load_image(&bytes).expect("a picture");
        let row = |y| (0..image.width()).map(move |x| (x, y));
        (0..image.height())
            .flat_map(row)
            .map(|(x, y)| image.pixel(x, y))
            .collect()
    }
}

/// The whole of a scene around what is inside.
fn scene(inside: &str) -> String {
    format!(r#"<scene version="3.0.0">{inside}</scene>"#)
}

const CAMERA: &str = r#"<sensor type="perspective" id="main camera"><float name="fov" value="40"/>
  <transform name="to_world"><lookat origin="1, 2, 7" target="0, 0.5, 0" up="0, 1, 0"/></transform>
  <film type="hdrfilm"><integer name="width" value="64"/><integer name="height" value="48"/></film></sensor>"#;

const MATT: &str =
    r#"<bsdf type="twosided"><bsdf type="diffuse"><rgb name="reflectance" value="0.2, 0.4, 0.6"/></bsdf></bsdf>"#;

fn shape<'s>(scene: &'s SceneDescription, name: &str) -> &'s ShapeDescription {
    let mut shapes = scene.shapes.iter();
    shapes.find(|shape| shape.identity.name == name).unwrap_or_else(|| {
        let names: Vec<_> = scene.shapes.iter().map(|shape| &shape.identity.name).collect();
        panic!("{name} is not among {names:?}")
    })
}

fn material<'s>(scene: &'s SceneDescription, name: &str) -> &'s MaterialDescription {
    let mut materials = scene.materials.iter();
    materials
        .find(|material| material.identity.name == name)
        .expect("the material is there")
}

/// The material itself, without the two sides around it.
fn front<'s>(scene: &'s SceneDescription, name: &str) -> &'s Material {
    let outer = material(scene, name);
    match outer.first {
        Some(first) => &scene.materials[first].material,
        None => &outer.material,
    }
}

/// The mesh of a shape whose kind is one.
fn mesh_of(shape: &ShapeDescription) -> std::sync::Arc<MeshData> {
    let ShapeKind::Mesh(file) = &shape.shape.kind else {
        panic!("{:?} is no mesh", shape.shape.kind)
    };
    let mesh = load_mesh(&file.path, &Access::everywhere()).expect("it can be read");
    mesh.data(file.shape_index).expect("it is there").clone()
}

/// The corners of a shape in the world.
fn corners(shape: &ShapeDescription) -> Vec<Vec3> {
    let positions = mesh_of(shape).positions.clone();
    positions
        .iter()
        .map(|at| shape.to_world.transform_point3(*at))
        .collect()
}

#[track_caller]
fn assert_near(found: Vec3, expected: Vec3) {
    let error = (found - expected).abs().max_element();
    assert!(
        error < 1e-5 * (1.0 + expected.abs().max_element()),
        "{found}, not {expected}"
    );
}

#[test]
fn shapes_keep_their_names_places_and_normals() {
    let shop = Workshop::new();
    let shapes = r#"
      <shape type="sphere" id="ball"><point name="center" value="1, 2, 3"/><float name="radius" value="0.5"/>MATT</shape>
      <shape type="cube" id="crate"><transform name="to_world"><scale x="2" y="0.5" z="1"/><rotate y="1" angle="30"/><translate x="4"/></transform>MATT</shape>
      <shape type="cube" id="sheared"><transform name="to_world"><rotate z="1" angle="30"/><scale x="3"/></transform>MATT</shape>
      <shape type="cylinder" id="pole"><point name="p0" value="0, 0, 1"/><point name="p1" value="2, 1, 1"/><float name="radius" value="0.25"/>MATT</shape>
      <shape type="rectangle" id="mirrored"><transform name="to_world"><scale x="-1"/></transform>MATT</shape>
      <shape type="rectangle" id="flipped"><boolean name="flip_normals" value="true"/>MATT</shape>
      <shape type="triangle" id="sail"><point name="v0" value="0, 0, 0"/><point name="v1" value="1, 0, 0"/><point name="v2" value="0, 1, 0"/>MATT</shape>
      <shape type="triangle" id="mirrored sail"><point name="v0" value="0, 0, 0"/><point name="v1" value="1, 0, 0"/><point name="v2" value="0, 1, 0"/>
        <transform name="to_world"><scale x="-1"/></transform>MATT</shape>
      <shape type="prism" id="column"><integer name="sides" value="8"/>MATT</shape>
      <shape type="stairs" id="way up">MATT</shape>
      <shape type="wall" id="Wand „Süd“">MATT</shape>
      <emitter type="point"/>"#;
    let text = scene(&format!("{CAMERA}{}", shapes.replace("MATT", MATT)));
    let before = {
        shop.put("before.xml", &text);
        shop.describe("before.xml")
    };
    for file in ["level.glb", "level.gltf"] {
        let after = shop.round_trip(&text.replace("MATT", MATT), file);
        assert_eq!(after.shapes.len(), before.shapes.len());
        let ball = shape(&after, "ball");
        for (corner, normal) in mesh_of(ball).positions.iter().zip(&mesh_of(ball).normals) {
            let world = ball.to_world.transform_point3(*corner);
            assert!((world.distance(Vec3::new(1.0, 2.0, 3.0)) - 0.5).abs() < 1e-5, "{world}");
            assert_near(*normal, *corner);
        }
        for name in ["crate", "sheared"] {
            // Each corner of the cube is three vertices.
            let to_world = shape(&before, name).to_world;
            let found = corners(shape(&after, name));
            assert_eq!(found.len(), 24);
            for i in 0..8 {
                let side = |bit: i32| if i & bit == 0 { -1.0 } else { 1.0 };
                let corner = to_world.transform_point3(Vec3::new(side(1), side(2), side(4)));
                let count = found.iter().filter(|at| at.distance(corner) < 1e-5).count();
                assert_eq!(count, 3, "{name}: {corner}");
            }
        }
        let axis = Vec3::new(2.0, 1.0, 0.0);
        for corner in corners(shape(&after, "pole")) {
            let from = corner - Vec3::Z;
            let along = from.dot(axis) / axis.length_squared();
            assert!(along.abs() < 1e-5 || (along - 1.0).abs() < 1e-5, "{along}");
            assert!((from - along * axis).length() - 0.25 < 1e-5);
        }
        // Which side they show is that of the scene: +z, unless it is turned around.
        for (name, expected) in [
            ("mirrored", 1.0),
            ("flipped", -1.0),
            ("sail", 1.0),
            ("mirrored sail", -1.0),
        ] {
            let shape = shape(&after, name);
            let mesh = mesh_of(shape);
            let [a, b, c] = mesh.corners(0).map(|at| shape.to_world.transform_point3(at));
            let ShapeKind::Mesh(file) = &shape.shape.kind else {
                panic!("a mesh")
            };
            let side = match file.face_normals {
                true => (b - a).cross(c - a).z.signum(),
                false => (shape.to_world.matrix3.inverse().transpose() * mesh.normals[0]).z,
            };
            let side = if shape.shape.flip_normals { -side } else { side };
            assert_eq!(side.signum(), expected, "{name}");
        }
        for (name, triangles) in [("column", 28), ("way up", 114)] {
            let mesh = mesh_of(shape(&after, name));
            let solid = match &shape(&before, name).shape.kind {
                ShapeKind::Solid(solid) => sunroom::scene::assets::solid_mesh::solid_mesh(solid),
                other => panic!("{other:?}"),
            };
            assert_eq!(mesh.positions, solid.positions, "{name}");
            assert_eq!(mesh.triangles.len(), solid.triangles.len(), "{name}: {triangles}");
            assert_eq!(mesh.uvs, solid.uvs, "{name}");
        }
        // Quotation marks are no characters of ids.
        shape(&after, "Wand _Süd_");
    }
    let names: Vec<String> = std::fs::read_dir(shop.path(""))
        .expect("a folder")
        .map(|entry| entry.expect("readable").file_name().to_string_lossy().into_owned())
        .filter(|name| name.starts_with("level"))
        .collect();
    assert_eq!(names.len(), 3, "{names:?}");
}

#[test]
fn shapes_of_one_form_share_their_vertices_and_groups_are_one_mesh() {
    let shop = Workshop::new();
    let instance = |id: &str, x: f32| {
        format!(
            r#"<shape type="instance" id="{id}"><ref id="tree"/><transform name="to_world"><scale value="2"/><translate x="{x}"/></transform></shape>"#
        )
    };
    let text = scene(&format!(
        r#"{CAMERA}<emitter type="point"/>
        <bsdf type="diffuse" id="red"><rgb name="reflectance" value="0.8, 0.1, 0.1"/></bsdf>
        <bsdf type="diffuse" id="green"><rgb name="reflectance" value="0.1, 0.8, 0.1"/></bsdf>
        <shape type="shapegroup" id="tree">
          <shape type="sphere"><point name="center" value="0, 3, 0"/><ref id="green"/></shape>
          <shape type="cube"><transform name="to_world"><scale x="0.2" z="0.2"/></transform><ref id="red"/></shape>
        </shape>
        {}{}
        <shape type="sphere" id="a"><ref id="red"/></shape>
        <shape type="sphere" id="b"><float name="radius" value="3"/><ref id="red"/></shape>
        <shape type="sphere" id="c"><ref id="green"/></shape>"#,
        instance("left", -5.0),
        instance("right", 5.0)
    ));
    shop.put("scene.xml", &text);
    assert_eq!(shop.convert("scene.xml", "level.gltf"), [""; 0]);
    let json: serde_json::Value =
        serde_json::from_slice(&std::fs::read(shop.path("level.gltf")).expect("it is there")).expect("JSON");
    let list = |name: &str| json[name].as_array().expect("a list").clone();
    // The tree, the red sphere, the green sphere.
    assert_eq!(list("meshes").len(), 3);
    let node = |name: &str| {
        let nodes = list("nodes");
        nodes
            .into_iter()
            .find(|node| node["name"] == name)
            .expect("it is there")
    };
    assert_eq!(node("left")["mesh"], node("right")["mesh"]);
    assert_eq!(node("a")["mesh"], node("b")["mesh"]);
    let primitive =
        |name: &str| list("meshes")[node(name)["mesh"].as_u64().expect("a number") as usize]["primitives"][0].clone();
    assert_eq!(primitive("a")["attributes"], primitive("c")["attributes"]);
    assert_ne!(primitive("a")["material"], primitive("c")["material"]);
    let after = shop.describe("level.gltf");
    let tops: Vec<f32> = ["left", "right"]
        .map(|name| {
            corners(shape(&after, name))
                .iter()
                .map(|at| at.y)
                .fold(f32::MIN, f32::max)
        })
        .into();
    assert_eq!(tops, [8.0, 8.0]);
    let trunk = corners(shape(&after, "right-2"));
    assert!(
        trunk.iter().all(|at| (at.x - 5.0).abs() < 0.401 && at.y.abs() < 2.001),
        "{trunk:?}"
    );
}

#[test]
fn folders_become_nodes_with_their_transforms() {
    let shop = Workshop::new();
    let text = scene(&format!(
        r#"{CAMERA}
        <volume type="constvolume" id="house/"><transform name="to_world"><scale value="2"/><translate x="10"/></transform></volume>
        <shape type="cube" id="house/room/table"><transform name="to_world"><translate x="12" y="2"/></transform>{MATT}</shape>
        <emitter type="point" id="house/lamp"><point name="position" value="10, 5, 0"/></emitter>"#
    ));
    shop.put("scene.xml", &text);
    assert_eq!(shop.convert("scene.xml", "level.gltf"), [""; 0]);
    let json: serde_json::Value =
        serde_json::from_slice(&std::fs::read(shop.path("level.gltf")).expect("it is there")).expect("JSON");
    let node = |name: &str| {
        let nodes = json["nodes"].as_array().expect("a list");
        let index = nodes.iter().position(|node| node["name"] == name).expect(name);
        (index, nodes[index].clone())
    };
    let (house, room, table) = (node("house"), node("room"), node("table"));
    assert_eq!(house.1["translation"], serde_json::json!([10.0, 0.0, 0.0]));
    assert_eq!(house.1["scale"], serde_json::json!([2.0, 2.0, 2.0]));
    assert!(
        house.1["children"]
            .as_array()
            .is_some_and(|children| children.contains(&room.0.into()))
    );
    assert_eq!(room.1["children"], serde_json::json!([table.0]));
    assert_eq!(table.1["translation"], serde_json::json!([1.0, 1.0, 0.0]));
    // And nodes become folders.
    let after = shop.describe("level.gltf");
    assert_near(
        shape(&after, "house/room/table").to_world.transform_point3(Vec3::ONE),
        Vec3::new(13.0, 3.0, 1.0),
    );
    let EmitterDescription { to_world, identity, .. } = &after.emitters[0];
    assert_eq!(identity.name, "house/lamp");
    assert_near(to_world.translation.into(), Vec3::new(10.0, 5.0, 0.0));
    let frames: Vec<&ShapeDescription> = after
        .shapes
        .iter()
        .filter(|shape| shape.shape.kind == ShapeKind::Frame)
        .collect();
    let [house] = frames[..] else { panic!("{frames:?}") };
    assert_eq!(house.identity.id.as_deref(), Some("house/"));
    assert_near(house.to_world.transform_point3(Vec3::ONE), Vec3::new(12.0, 2.0, 2.0));
}

/// The number at the beginning of a text of JSON.
fn leading_number(text: &str) -> f32 {
    let end = text.find([',', '}']).unwrap_or(text.len());
    text[..end].parse().expect("a number")
}

#[test]
fn lights_and_cameras_keep_what_they_are() {
    let shop = Workshop::new();
    let text = scene(
        r#"<sensor type="perspective" id="first"><string name="fov_axis" value="smaller"/><float name="fov" value="30"/>
          <float name="near_clip" value="0.5"/><float name="far_clip" value="50"/>
          <transform name="to_world"><scale value="3"/><lookat origin="1, 2, 7" target="0, 0.5, 0" up="0, 1, 0"/></transform>
          <film type="hdrfilm"><integer name="width" value="300"/><integer name="height" value="400"/></film></sensor>
        <sensor type="orthographic" id="plan"><transform name="to_world"><scale value="4"/><lookat origin="0, 9, 0" target="0, 0, 0" up="0, 0, 1"/></transform>
          <film type="hdrfilm"><integer name="width" value="200"/><integer name="height" value="100"/></film></sensor>
        <emitter type="point" id="bulb"><point name="position" value="1, 2, 3"/><rgb name="intensity" value="20, 10, 5"/></emitter>
        <emitter type="spot" id="spot"><rgb name="intensity" value="0.5, 0.25, 0"/><float name="cutoff_angle" value="35"/><float name="beam_width" value="10"/>
          <transform name="to_world"><lookat origin="0, 4, 0" target="1, 0, 2" up="0, 0, 1"/></transform></emitter>
        <emitter type="directional" id="sun"><vector name="direction" value="1, -2, 0.5"/><rgb name="irradiance" value="3, 2.5, 2"/></emitter>
        <shape type="rectangle" id="panel"><transform name="to_world"><scale value="0.5"/></transform>
          <bsdf type="twosided"><bsdf type="diffuse"/></bsdf><emitter type="area"><rgb name="radiance" value="12, 6, 3"/></emitter></shape>
        <shape type="rectangle" id="dim"><bsdf type="twosided"><bsdf type="diffuse"/></bsdf>
          <emitter type="area"><rgb name="radiance" value="0.5, 0.25, 0"/></emitter></shape>"#,
    );
    shop.put("before.xml", &text);
    let before = shop.describe("before.xml");
    let after = shop.round_trip(&text, "level.glb");
    // The file has candela and lux, at 683 lm/W.
    let bytes = shop.read("level.glb");
    let json = String::from_utf8_lossy(&bytes);
    let intensities: Vec<f32> = json.split("\"intensity\":").skip(1).map(leading_number).collect();
    assert!(
        intensities.contains(&(20.0 * 683.0)) && intensities.contains(&(3.0 * 683.0)),
        "{intensities:?}"
    );
    assert_eq!(before.emitters.len(), after.emitters.len());
    for (old, new) in before.emitters.iter().zip(&after.emitters) {
        assert_eq!(old.identity.name, new.identity.name);
        assert_near(power(&new.emitter.kind), power(&old.emitter.kind));
        assert_near(new.to_world.translation.into(), old.to_world.translation.into());
        assert_near(new.to_world.matrix3.z_axis.into(), old.to_world.matrix3.z_axis.into());
        if let (EmitterKind::Spot { cone: old, .. }, EmitterKind::Spot { cone: new, .. }) =
            (&old.emitter.kind, &new.emitter.kind)
        {
            assert!(
                (old.cutoff_angle - new.cutoff_angle).abs() < 1e-4 && (old.beam_width - new.beam_width).abs() < 1e-4
            );
        }
    }
    for (name, radiance) in [("panel", Vec3::new(12.0, 6.0, 3.0)), ("dim", Vec3::new(0.5, 0.25, 0.0))] {
        let light = shape(&after, name).area_light.as_ref().expect("it shines");
        assert_near(light.radiance.constant().expect("a colour"), radiance);
    }
    for (old, new) in before.sensors.iter().zip(&after.sensors) {
        assert_eq!(old.identity.name, new.identity.name);
        assert_near(new.to_world.translation.into(), old.to_world.translation.into());
        let direction = |map: &Affine3A, axis: Vec3| map.transform_vector3(axis).normalize();
        for axis in [Vec3::Y, Vec3::Z] {
            assert_near(direction(&new.to_world, axis), direction(&old.to_world, axis));
        }
        let aspect = |film: &Film| film.width as f32 / film.height as f32;
        assert!((aspect(&old.film) - aspect(&new.film)).abs() < 1e-3);
        let across = |sensor: &Sensor, film: &Film| sensor.fov_axis.horizontal(sensor.fov, aspect(film));
        match old.sensor.lens {
            Lens::Orthographic => {
                assert_eq!(new.sensor.lens, Lens::Orthographic);
                assert!((new.to_world.matrix3.x_axis.length() - 4.0).abs() < 1e-4);
            }
            _ => {
                let [old_fov, new_fov] = [across(&old.sensor, &old.film), across(&new.sensor, &new.film)];
                assert!((old_fov - new_fov).abs() < 1e-3, "{old_fov} {new_fov}");
                assert_eq!((new.sensor.near_clip, new.sensor.far_clip), (0.5, 50.0));
            }
        }
    }
}

#[test]
fn lamps_keep_the_files_of_their_intensities() {
    let shop = Workshop::new();
    let photometry = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/corpus/photometry/");
    for name in ["half.ies", "type_b.ies", "without_symmetry.ldt"] {
        std::fs::copy(Path::new(photometry).join(name), shop.path(name)).expect("it is copied");
    }
    let lamp = |id: &str, file: &str, rest: &str| {
        format!(
            r#"<emitter type="ies" id="{id}"><string name="filename" value="{file}"/>{rest}<transform name="to_world">
              <rotate x="1" angle="110"/><rotate y="1" angle="20"/><translate x="1" y="2" z="3"/></transform></emitter>"#
        )
    };
    let half = r#"<rgb name="scale" value="2, 1, 0.5"/><float name="flux" value="500"/>"#;
    let text = scene(
        &[
            CAMERA,
            &lamp("half", "half.ies", half),
            &lamp("flood", "type_b.ies", ""),
        ]
        .concat(),
    );
    shop.put("before.xml", &text);
    let before = shop.describe("before.xml");
    for file in ["lamps.glb", "lamps.gltf"] {
        let after = shop.round_trip(&text, file);
        assert_eq!(after.emitters.len(), 2, "{file}");
        for (old, new) in before.emitters.iter().zip(&after.emitters) {
            assert_eq!(old.identity.name, new.identity.name);
            assert_near(new.to_world.translation.into(), old.to_world.translation.into());
            for axis in [Vec3::X, Vec3::Y, Vec3::Z] {
                assert_near(
                    new.to_world.transform_vector3(axis),
                    old.to_world.transform_vector3(axis),
                );
            }
            let [old, new] = [old, new].map(|light| match &light.emitter.kind {
                EmitterKind::Luminaire { profile, scale, flux } => {
                    (std::fs::read(profile).expect("a file"), *scale, *flux)
                }
                other => panic!("{file}: {other:?}"),
            });
            assert_eq!(old.0, new.0);
            let own = sunroom::photometry::read_profile(&old.0)
                .expect("a lamp")
                .picture()
                .lumens() as f32;
            let factor = if old.2 > 0.0 { old.2 / own } else { 1.0 };
            assert_near(new.1 / factor, old.1);
            assert_eq!(new.2, 0.0);
        }
    }
    assert!(shop.path("lamps-lamp-1.ies").is_file());
    // glTF has no EULUMDAT: the closest standard light takes its place, as a message says.
    shop.put(
        "scene.xml",
        scene(&[CAMERA, &lamp("even", "without_symmetry.ldt", "")].concat()),
    );
    let said = shop.convert("scene.xml", "other.glb");
    assert!(
        said.concat().contains("without the intensities of its file"),
        "{said:?}"
    );
    let after = shop.describe("other.glb");
    assert!(matches!(
        after.emitters[0].emitter.kind,
        EmitterKind::Point { .. } | EmitterKind::Spot { .. }
    ));
}

fn power(kind: &EmitterKind) -> Vec3 {
    match kind {
        EmitterKind::Point { intensity } | EmitterKind::Spot { intensity, .. } => *intensity,
        EmitterKind::Directional { irradiance } => *irradiance,
        other => panic!("{other:?}"),
    }
}

/// Materials that glTF has: each with its name, its plugin inside of two sides or glass, and the numbers that it has
/// after the way there and back.
#[test]
fn materials_keep_their_parameters() {
    let shop = Workshop::new();
    let bsdfs = r#"
      <bsdf type="twosided" id="matt"><bsdf type="diffuse"><rgb name="reflectance" value="0.2, 0.4, 0.6"/></bsdf></bsdf>
      <bsdf type="twosided" id="lacquer"><bsdf type="principled"><rgb name="base_color" value="0.3, 0.5, 0.1"/><float name="metallic" value="0.25"/>
        <float name="roughness" value="0.4"/><float name="eta" value="1.8"/><float name="sheen" value="0.3"/><float name="clearcoat" value="0.75"/>
        <float name="clearcoat_gloss" value="0.9"/><float name="anisotropic" value="0.5"/><float name="spec_tint" value="0.6"/>
        <float name="sheen_tint" value="0.4"/></bsdf></bsdf>
      <bsdf type="principledthin" id="leaf"><rgb name="base_color" value="0.3, 0.5, 0.1"/><float name="diff_trans" value="0.8"/></bsdf>
      <bsdf type="principled" id="frosted"><rgb name="base_color" value="0.9, 0.8, 0.7"/><float name="roughness" value="0.2"/>
        <float name="spec_trans" value="0.8"/><float name="eta" value="1.33"/></bsdf>
      <bsdf type="principledthin" id="film"><rgb name="base_color" value="0.9, 0.8, 0.7"/><float name="roughness" value="0.2"/>
        <float name="spec_trans" value="0.6"/><float name="eta" value="1.4"/></bsdf>
      <bsdf type="dielectric" id="glass"><float name="int_ior" value="1.6"/><float name="ext_ior" value="1"/>
        <rgb name="specular_transmittance" value="0.5, 0.9, 1"/></bsdf>
      <bsdf type="twosided" id="chrome"><bsdf type="conductor"><rgb name="specular_reflectance" value="0.9, 0.8, 0.7"/></bsdf></bsdf>
      <bsdf type="twosided" id="brushed"><bsdf type="roughconductor"><string name="distribution" value="ggx"/><float name="alpha" value="0.09"/>
        <rgb name="specular_reflectance" value="0.9, 0.8, 0.7"/></bsdf></bsdf>
      <bsdf type="mask" id="veil"><float name="opacity" value="0.25"/><bsdf type="twosided"><bsdf type="diffuse"/></bsdf></bsdf>"#;
    let names = [
        "matt", "lacquer", "leaf", "frosted", "film", "glass", "chrome", "brushed", "veil",
    ];
    let shapes: String = names
        .iter()
        .map(|name| format!(r#"<shape type="sphere" id="ball of {name}"><ref id="{name}"/></shape>"#))
        .collect();
    let text = scene(&format!(r#"{CAMERA}<emitter type="point"/>{bsdfs}{shapes}"#));
    let after = shop.round_trip(&text, "level.glb");
    let principled = |name: &str| match front(&after, name) {
        Material::Principled(principled) => principled.clone(),
        other => panic!("{name}: {other:?}"),
    };
    let number = |parameter: &Parameter<f32>| parameter.constant().expect("a number");
    let is = |found: f32, expected: f32| assert!((found - expected).abs() < 1e-5, "{found}, not {expected}");
    let index = |index: &PrincipledIndex| match index {
        PrincipledIndex::Eta(eta) => *eta,
        other => panic!("{other:?}"),
    };
    match front(&after, "matt") {
        Material::Diffuse { reflectance } => {
            assert_near(reflectance.constant().expect("a colour"), Vec3::new(0.2, 0.4, 0.6));
        }
        other => panic!("{other:?}"),
    }
    let lacquer = principled("lacquer");
    assert_near(
        lacquer.base_color.constant().expect("a colour"),
        Vec3::new(0.3, 0.5, 0.1),
    );
    for (parameter, expected) in [
        (&lacquer.metallic, 0.25),
        (&lacquer.roughness, 0.4),
        (&lacquer.sheen, 0.3),
        (&lacquer.clearcoat, 0.75),
        (&lacquer.clearcoat_gloss, 0.9),
        (&lacquer.spec_trans, 0.0),
        (&lacquer.anisotropic, 0.5),
        (&lacquer.spec_tint, 0.6),
        (&lacquer.sheen_tint, 0.4),
    ] {
        is(number(parameter), expected);
    }
    is(index(&lacquer.index), 1.8);
    let frosted = principled("frosted");
    is(number(&frosted.spec_trans), 0.8);
    is(number(&frosted.roughness), 0.2);
    is(index(&frosted.index), 1.33);
    assert_near(
        frosted.base_color.constant().expect("a colour"),
        Vec3::new(0.9, 0.8, 0.7),
    );
    match front(&after, "leaf") {
        Material::PrincipledThin(thin) => {
            is(number(&thin.diff_trans), 0.8);
            is(number(&thin.spec_trans), 0.0);
        }
        other => panic!("{other:?}"),
    }
    match front(&after, "film") {
        Material::PrincipledThin(thin) => {
            is(number(&thin.spec_trans), 0.6);
            is(number(&thin.roughness), 0.2);
            is(number(&thin.eta), 1.4);
        }
        other => panic!("{other:?}"),
    }
    // Light crosses the surface twice, each time by the root of the base colour.
    let glass = principled("glass");
    assert_near(
        glass.base_color.constant().expect("a colour"),
        Vec3::new(0.25, 0.81, 1.0),
    );
    is(index(&glass.index), 1.6);
    for (name, roughness) in [("chrome", 0.0), ("brushed", 0.3)] {
        let metal = principled(name);
        is(number(&metal.metallic), 1.0);
        is(number(&metal.roughness), roughness);
        assert_near(metal.base_color.constant().expect("a colour"), Vec3::new(0.9, 0.8, 0.7));
    }
    match &material(&after, "veil").material {
        Material::Mask { opacity } => is(number(opacity), 0.25),
        other => panic!("{other:?}"),
    }
}

/// Glass that absorbs light, and bubbles, where the outside is the denser side.
#[test]
fn media_of_glass_and_bubbles_are_kept() {
    let shop = Workshop::new();
    let text = scene(&format!(
        r#"{CAMERA}<integrator type="volpath"/><emitter type="point"/>
        <medium type="homogeneous" id="ink"><rgb name="sigma_t" value="0.5, 2, 4"/><float name="albedo" value="0"/></medium>
        <shape type="sphere" id="drop"><bsdf type="dielectric" id="water"><float name="int_ior" value="1.33"/><float name="ext_ior" value="1"/></bsdf>
          <ref name="interior" id="ink"/></shape>
        <shape type="sphere" id="bubble"><bsdf type="dielectric" id="air"><float name="int_ior" value="1"/><float name="ext_ior" value="1.25"/></bsdf></shape>"#
    ));
    let after = shop.round_trip(&text, "level.glb");
    let medium = &after.media[shape(&after, "drop").interior.expect("it is filled")].medium;
    let (sigma_t, albedo) = medium.coefficients.sigma_t_and_albedo();
    assert_near(
        medium.scale * sigma_t.constant().expect("uniform"),
        Vec3::new(0.5, 2.0, 4.0),
    );
    assert_eq!(albedo.constant(), Some(Vec3::ZERO));
    // The same surface seen from the other side: normals inwards, and the denser side where they do not point.
    match front(&after, "air") {
        Material::Principled(air) => {
            assert!(
                matches!(air.index, PrincipledIndex::Eta(eta) if (eta - 1.25).abs() < 1e-5),
                "{:?}",
                air.index
            );
        }
        other => panic!("{other:?}"),
    }
    let mesh = mesh_of(shape(&after, "bubble"));
    assert!(
        mesh.positions
            .iter()
            .zip(&mesh.normals)
            .all(|(at, normal)| at.dot(*normal) < -0.9)
    );
}

/// Textures: a picture as it is, one that is not decoded, a checkerboard, a mask and normals, moved about.
#[test]
fn textures_keep_their_values_and_their_places() {
    let shop = Workshop::new();
    let mut picture = image::RgbImage::new(8, 4);
    for (x, y, pixel) in picture.enumerate_pixels_mut() {
        *pixel = image::Rgb([(30 * x) as u8, (60 * y) as u8, 128]);
    }
    picture.save(shop.path("tiles.png")).expect("a picture");
    let bitmap = |name: &str, more: &str| {
        format!(r#"<texture type="bitmap" name="{name}"><string name="filename" value="tiles.png"/>{more}</texture>"#)
    };
    let raw = r#"<boolean name="raw" value="true"/>"#;
    let moved = r#"<transform name="to_uv"><scale x="2" y="3"/><rotate z="1" angle="25"/><translate x="0.1" y="0.2"/></transform>
      <string name="wrap_mode" value="mirror"/>"#;
    let text = scene(&format!(
        r#"{CAMERA}<emitter type="point"/>
        <bsdf type="twosided" id="tiled"><bsdf type="diffuse">{}</bsdf></bsdf>
        <bsdf type="twosided" id="worn"><bsdf type="principled">{}</bsdf></bsdf>
        <bsdf type="twosided" id="chess"><bsdf type="diffuse"><texture type="checkerboard" name="reflectance"><rgb name="color0" value="0.2, 0.5, 0.1"/>
          <rgb name="color1" value="0.9, 0.8, 0.7"/><transform name="to_uv"><scale value="4"/></transform></texture></bsdf></bsdf>
        <bsdf type="mask" id="leaf">{}<bsdf type="twosided"><bsdf type="diffuse">{}</bsdf></bsdf></bsdf>
        <bsdf type="twosided" id="dented"><bsdf type="normalmap">{}<bsdf type="diffuse"/></bsdf></bsdf>
        <shape type="rectangle"><ref id="tiled"/></shape><shape type="rectangle"><ref id="worn"/></shape>
        <shape type="rectangle"><ref id="chess"/></shape><shape type="rectangle"><ref id="leaf"/></shape><shape type="rectangle"><ref id="dented"/></shape>"#,
        bitmap("reflectance", moved),
        bitmap("roughness", raw),
        bitmap("opacity", raw),
        bitmap("reflectance", ""),
        bitmap("normalmap", raw),
    ));
    for file in ["level.glb", "level.gltf"] {
        let after = shop.round_trip(&text, file);
        let given = |name: &str| match front(&after, name) {
            Material::Diffuse {
                reflectance: Parameter::Texture(Texture::Bitmap(bitmap)),
            } => bitmap.clone(),
            other => panic!("{name}: {other:?}"),
        };
        let tiled = given("tiled");
        let (original, copy) = (shop.path("tiles.png"), &tiled.path);
        assert_eq!(
            std::fs::read(original).expect("there"),
            std::fs::read(copy).expect("there")
        );
        assert_eq!((tiled.wrap, tiled.raw), (TextureWrap::Mirror, false));
        let expected = bevy::math::Affine2::from_translation(bevy::math::Vec2::new(0.1, 0.2))
            * bevy::math::Affine2::from_angle(25f32.to_radians())
            * bevy::math::Affine2::from_scale(bevy::math::Vec2::new(2.0, 3.0));
        assert!(tiled.to_uv.abs_diff_eq(expected, 1e-5), "{:?}", tiled.to_uv);
        let chess = given("chess");
        assert_eq!(
            (chess.filter, chess.wrap),
            (TextureFilter::Nearest, TextureWrap::Repeat)
        );
        let board = load(&chess.path);
        assert_eq!((board.width(), board.height()), (2, 2));
        // 8 bits of sRGB.
        for (x, y, expected) in [(0, 0, Vec3::new(0.2, 0.5, 0.1)), (1, 0, Vec3::new(0.9, 0.8, 0.7))] {
            assert!(
                (board.pixel(x, y) - expected).abs().max_element() < 5e-3,
                "{}",
                board.pixel(x, y)
            );
        }
        // The luminance of the picture, in steps of 1/255.
        let expected = |x: u32, y: u32| luminance(Vec3::new(30.0 * x as f32, 60.0 * y as f32, 128.0)) / 255.0;
        let raw_value =
            |image: &sunroom::texture::Image, x: u32, y: u32| sunroom::color::srgb_from_linear(image.pixel(x, y).x);
        let worn = match front(&after, "worn") {
            Material::Principled(worn) => match &worn.roughness {
                Parameter::Texture(Texture::Bitmap(bitmap)) => load(&bitmap.path),
                other => panic!("{other:?}"),
            },
            other => panic!("{other:?}"),
        };
        let leaf = match &material(&after, "leaf").material {
            Material::Mask {
                opacity: Parameter::Texture(Texture::Bitmap(bitmap)),
            } => load(&bitmap.path),
            other => panic!("{other:?}"),
        };
        let dented = match front(&after, "dented") {
            Material::NormalMap {
                normals: Parameter::Texture(Texture::Bitmap(bitmap)),
                ..
            } => load(&bitmap.path),
            other => panic!("{other:?}"),
        };
        for (x, y) in [(0, 0), (3, 2), (7, 3)] {
            for image in [&worn, &leaf] {
                let found = raw_value(image, x, y);
                assert!((found - expected(x, y)).abs() < 3e-3, "{found}, not {}", expected(x, y));
            }
            // The importer gives normals the length 1.
            let direction = |code: Vec3| (2.0 * code - 1.0).normalize();
            // v points up on a rectangle, so that pictures lie mirrored on it, and green has turned around.
            let code = Vec3::new(30.0 * x as f32, 255.0 - 60.0 * y as f32, 128.0) / 255.0;
            let found = dented.pixel(x, y).map(sunroom::color::srgb_from_linear);
            let angle = direction(found).angle_between(direction(code));
            assert!(angle < 0.02, "{angle}");
        }
    }
}

fn load(path: &Path) -> sunroom::texture::Image {
    sunroom::texture::load_image(&std::fs::read(path).expect("it is there")).expect("a picture")
}

#[test]
fn what_is_lost_is_said_with_its_name() {
    let shop = Workshop::new();
    shop.put("cloud.txt", "");
    let text = scene(
        r#"<sensor type="thinlens" id="lens"><float name="aperture_radius" value="0.1"/><float name="focus_distance" value="3"/></sensor>
        <integrator type="volpath"><integer name="max_depth" value="5"/></integrator>
        <emitter type="constant" id="sky"/>
        <emitter type="sunsky" id="noon"/>
        <emitter type="point" id="fly"><animation name="position"><point time="-1" value="0, 0, 0"/><point time="1" value="1, 0, 0"/></animation>
          <animation name="intensity"><rgb time="0" value="1, 1, 1"/><rgb time="1" value="2, 2, 2"/></animation></emitter>
        <medium type="homogeneous" id="fog"/>
        <shape type="cube" id="box of fog"><bsdf type="null"/><ref name="interior" id="fog"/></shape>
        <shape type="sphere"><bsdf type="roughconductor" id="gold"><string name="material" value="Au"/></bsdf></shape>
        <shape type="sphere"><bsdf type="plastic" id="paint"/></shape>
        <shape type="sphere"><bsdf type="hair" id="fur"/></shape>
        <shape type="sphere"><bsdf type="principled" id="satin"><float name="flatness" value="0.5"/></bsdf></shape>
        <shape type="sphere"><bsdf type="blendbsdf" id="rust"><float name="weight" value="0.5"/><bsdf type="diffuse"/><bsdf type="conductor"/></bsdf></shape>
        <shape type="rectangle" id="sheet"><bsdf type="diffuse"/></shape>"#,
    );
    shop.put("scene.xml", text);
    let said = shop.convert("scene.xml", "level.glb").join("\n");
    for expected in [
        "camera `lens`: the lens is lost",
        "setting `max_depth` is left out",
        "light `sky` is left out: glTF has no counterpart of light from all directions",
        "light `noon`: only the sun is kept",
        "light `fly`: only the place moves, `intensity` does not",
        "light `fly`: the keys before 0 s are left out",
        "medium `fog` is left out",
        "shape `box of fog` is left out",
        "material `gold`: the facets are spread by GGX",
        "material `gold`: the index of refraction becomes the colour",
        "material `paint`: the clear layer",
        "material `fur`: a rough surface",
        "material `satin`: the surface is not flatter than matt",
        "material `rust`: the two materials inside become one",
        "shape `sheet`: the back, which is black here",
    ] {
        assert!(said.contains(expected), "{expected}:\n{said}");
    }
    // With `--strict`, an export that loses something writes no file.
    std::fs::remove_file(shop.path("level.glb")).expect("it is there");
    let output = shop.sunroom(&["convert", "--strict", "scene.xml", "level.glb"]);
    assert_eq!(output.status.code(), Some(1));
    assert!(!shop.path("level.glb").exists());
}

/// The irradiance on surfaces that face the sun, and its direction, as the path tracer sees them: a white floor in the
/// sun of a black sky.
#[test]
fn the_sun_becomes_a_light_from_one_direction() {
    let shop = Workshop::new();
    let floor = r#"<sensor type="orthographic"><transform name="to_world"><lookat origin="0, 5, 0" target="0, 0, 0" up="0, 0, 1"/></transform></sensor>
        <shape type="rectangle"><transform name="to_world"><rotate x="1" angle="-90"/><scale value="3"/></transform>
        <bsdf type="twosided"><bsdf type="diffuse"><rgb name="reflectance" value="0.8"/></bsdf></bsdf></shape>"#;
    let sun = |direction: &str| {
        format!(
            r#"<emitter type="sunsky" id="noon"><float name="sky_scale" value="0"/><vector name="sun_direction" value="{direction}"/>
            <transform name="to_world"><rotate x="1" angle="-90"/></transform></emitter>"#
        )
    };
    shop.put("scene.xml", scene(&format!("{floor}{}", sun("1, 2, 0.5"))));
    let said = shop.convert("scene.xml", "level.glb").join("\n");
    assert!(said.contains("light `noon`: only the sun is kept"), "{said}");
    let after = shop.describe("level.glb");
    let EmitterKind::Directional { .. } = after.emitters[0].emitter.kind else {
        panic!("{:?}", after.emitters[0])
    };
    let brightness = |scene: &str| mean(&shop.render(scene, &["--size", "8x8", "--spp", "256"]));
    let (before, after) = (brightness("scene.xml"), brightness("level.glb"));
    assert!((after / before - 1.0).abs() < 0.01, "{after} for {before}");
    shop.put("night.xml", scene(&format!("{floor}{}", sun("1, -2, 0.5"))));
    let said = shop.convert("night.xml", "night.glb").join("\n");
    assert!(said.contains("light `noon` is left out"), "{said}");
}

/// Descriptions may hold what no file gives them.
#[test]
fn many_instances_in_one_stand_still() {
    let shop = Workshop::new();
    shop.put(
        "scene.xml",
        scene(&format!(
            r#"{CAMERA}<emitter type="point"/><shape type="shapegroup" id="tree"><shape type="cube">{MATT}</shape></shape>
            <shape type="instance" id="wood"><ref id="tree"/><animation name="to_world"><transform time="0"/>
            <transform time="1"><translate x="3"/></transform></animation></shape>"#
        )),
    );
    let mut scene = shop.describe("scene.xml");
    let wood = scene.shapes.iter_mut().find(|shape| shape.identity.name == "wood");
    let wood = wood.expect("it is there");
    let places = [0.0, 5.0].map(|x| Affine3A::from_translation(Vec3::new(x, 0.0, 0.0)).into());
    wood.placements = Some(Placements {
        places: places.to_vec().into(),
    });
    let target = shop.path("level.glb");
    let made = export(&scene, &Hidden::default(), &target, &Access::everywhere()).expect("it is made");
    assert_eq!(
        made.messages,
        ["shape `wood`: nothing moves, because these are many instances in one"]
    );
}

/// The settings of the film are lost by every export, so that they do not count as a loss of the scene.
#[test]
fn lost_settings_of_the_film_are_said_once() {
    let shop = Workshop::new();
    let film = |settings: &str| {
        let film = format!("<film type='hdrfilm'>{settings}</film>");
        let sensor = |name: &str| {
            format!(
                "<sensor type='perspective' id='{name}'>{film}<sampler type='independent'><integer name='sample_count' value='64'/></sampler></sensor>"
            )
        };
        scene(&format!("{}{}<emitter type='point'/>", sensor("a"), sensor("b")))
    };
    shop.put(
        "set.xml",
        film("<integer name='width' value='320'/><rfilter type='box'/>"),
    );
    let note = "note: settings `width`, `rfilter`, `sample_count` are left out: glTF has no film";
    assert_eq!(shop.said_of_export("set.xml", "level.glb"), [note]);
    let output = shop.sunroom(&["convert", "--strict", "set.xml", "level.glb"]);
    assert!(output.status.success(), "{output:?}");
    shop.put(
        "usual.xml",
        scene("<sensor type='perspective'/><emitter type='point'/>"),
    );
    assert_eq!(shop.said_of_export("usual.xml", "level.glb"), [""; 0]);
}

/// An RGBA picture is opaque here: if a mask makes alpha count, the file may not bring any of its own.
#[test]
fn alpha_of_pictures_does_not_count_below_masks() {
    let shop = Workshop::new();
    let picture = image::RgbaImage::from_fn(4, 4, |x, y| image::Rgba([60 * x as u8, 60 * y as u8, 128, 77]));
    picture.save(shop.path("tiles.png")).expect("a picture");
    let matt = "<bsdf type='twosided'><bsdf type='diffuse'><texture type='bitmap' name='reflectance'>\
                <string name='filename' value='tiles.png'/></texture></bsdf></bsdf>";
    for (opacity, is_as_it_is) in [(1.0, true), (0.5, false)] {
        let mask = format!("<bsdf type='mask' id='veil'><float name='opacity' value='{opacity}'/>{matt}</bsdf>");
        let text = scene(&format!(
            "{CAMERA}<emitter type='point'/>{mask}<shape type='cube'><ref id='veil'/></shape>"
        ));
        shop.put("scene.xml", text);
        assert_eq!(shop.convert("scene.xml", "level.gltf"), [""; 0]);
        let json: serde_json::Value = serde_json::from_slice(&shop.read("level.gltf")).expect("JSON");
        let factor = json["materials"][0]["pbrMetallicRoughness"]["baseColorFactor"][3].as_f64();
        assert_eq!(factor.unwrap_or(1.0), opacity);
        let written = shop.read("level-picture-0.png");
        assert_eq!(written == shop.read("tiles.png"), is_as_it_is);
        let written = image::load_from_memory(&written).expect("a picture");
        assert_eq!(written.color().has_alpha(), is_as_it_is);
        assert_eq!(written.to_rgb8(), image::DynamicImage::from(picture.clone()).to_rgb8());
    }
}

/// A mesh of two materials in a group, whose place in the group moves its vertices.
#[test]
fn moved_vertices_of_groups_are_written_once() {
    let shop = Workshop::new();
    shop.put("two.mtl", "newmtl red\nKd 1 0 0\nnewmtl green\nKd 0 1 0\n");
    shop.put(
        "two.obj",
        "mtllib two.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nv 1 1 0\nusemtl red\nf 1 2 3\nusemtl green\nf 2 4 3\n",
    );
    shop.put(
        "scene.xml",
        scene(&format!(
            r#"{CAMERA}<emitter type="point"/><shape type="shapegroup" id="tree"><shape type="obj"><string name="filename" value="two.obj"/>
            <transform name="to_world"><translate x="3"/></transform></shape></shape>
            <shape type="instance" id="one"><ref id="tree"/></shape><shape type="instance" id="two"><ref id="tree"/></shape>"#
        )),
    );
    shop.convert("scene.xml", "level.gltf");
    let json: serde_json::Value = serde_json::from_slice(&shop.read("level.gltf")).expect("JSON");
    let meshes = json["meshes"].as_array().expect("a list");
    assert_eq!(meshes.len(), 1);
    let parts = meshes[0]["primitives"].as_array().expect("a list");
    assert_eq!(parts.len(), 2);
    assert_eq!(parts[0]["attributes"], parts[1]["attributes"]);
    assert_ne!(parts[0]["material"], parts[1]["material"]);
}

#[test]
fn no_file_of_the_scene_is_overwritten() {
    let shop = Workshop::new();
    shop.put("cube.xml", scene(&format!("{CAMERA}<shape type='cube'>{MATT}</shape>")));
    assert_eq!(shop.convert("cube.xml", "level.gltf"), [""; 0]);
    // It names the buffer of the other one.
    shop.put("other.gltf", shop.read("level.gltf"));
    let header = "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\nelement face 1\n\
                  property list uchar int vertex_indices\nend_header\n";
    shop.put("mesh.glb", format!("{header}0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n"));
    let mesh = format!("<shape type='ply'><string name='filename' value='mesh.glb'/>{MATT}</shape>");
    shop.put("mesh.xml", scene(&format!("{CAMERA}{mesh}")));
    // Only the library of a mesh names the picture.
    let picture = image::RgbImage::from_pixel(2, 2, image::Rgb([9, 90, 200]));
    picture.save(shop.path("tile-picture-0.png")).expect("a picture");
    shop.put("tile.mtl", "newmtl tiled\nmap_Kd tile-picture-0.png\n");
    shop.put(
        "tile.obj",
        "mtllib tile.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl tiled\nf 1 2 3\n",
    );
    let tiled = "<texture type='checkerboard' name='reflectance'/>";
    let mesh = format!(
        "<shape type='obj'><string name='filename' value='tile.obj'/></shape>\
         <shape type='cube'><bsdf type='twosided'><bsdf type='diffuse'>{tiled}</bsdf></bsdf></shape>"
    );
    shop.put("tile.xml", scene(&format!("{CAMERA}{mesh}")));
    for (scene, file, kept) in [
        ("other.gltf", "level.gltf", "level.bin"),
        ("mesh.xml", "mesh.glb", "mesh.glb"),
        ("tile.xml", "tile.gltf", "tile-picture-0.png"),
    ] {
        let before = shop.read(kept);
        let output = shop.sunroom(&["convert", scene, file]);
        let said = String::from_utf8_lossy(&output.stderr).into_owned();
        assert_eq!(output.status.code(), Some(1), "{said}");
        assert!(
            said.contains(&format!("{kept}: the scene is made of this file")),
            "{said}"
        );
        assert_eq!(shop.read(kept), before);
    }
    // Another scene may replace what an earlier export has left.
    assert_eq!(shop.convert("cube.xml", "level.gltf"), [""; 0]);
}

#[test]
fn what_cannot_be_written_is_an_error() {
    let shop = Workshop::new();
    shop.put("scene.xml", scene(CAMERA));
    std::fs::create_dir(shop.path("folder.glb")).expect("a folder");
    std::fs::create_dir(shop.path("taken.bin")).expect("a folder");
    shop.put("good.xml", scene(&format!("{CAMERA}<shape type='cube'>{MATT}</shape>")));
    for (scene, file, what) in [
        ("scene.xml", "absent/level.glb", "there is no folder"),
        ("scene.xml", "folder.glb", "it is a folder"),
        ("good.xml", "taken.gltf", "taken.bin: it is a folder"),
    ] {
        let output = shop.sunroom(&["convert", scene, file]);
        let said = String::from_utf8_lossy(&output.stderr).into_owned();
        assert_eq!(output.status.code(), Some(1), "{said}");
        assert!(said.contains(what), "{said}");
    }
    // The file that names the others is written last.
    assert!(!shop.path("taken.gltf").exists());
    // A scene of nothing but a camera is a file all the same.
    assert_eq!(shop.convert("scene.xml", "empty.glb"), [""; 0]);
    assert_eq!(shop.describe("empty.glb").shapes.len(), 0);
}

/// Descriptions may hold what no file gives them.
#[test]
fn flattened_shapes_are_left_out_and_bare_meshes_are_written() {
    let shop = Workshop::new();
    let header = "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\nelement face 1\n\
                  property list uchar int vertex_indices\nend_header\n";
    shop.put("bare.ply", format!("{header}0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n"));
    shop.put(
        "scene.xml",
        scene(&format!(
            r#"{CAMERA}<emitter type="point"/><shape type="cube" id="flat">{MATT}</shape><shape type="cube" id="hidden">{MATT}</shape>
            <shape type="ply" id="bare"><string name="filename" value="bare.ply"/>{MATT}</shape>
            <shape type="ply" id="faceted"><string name="filename" value="bare.ply"/><boolean name="face_normals" value="true"/>{MATT}</shape>"#
        )),
    );
    let mut scene = shop.describe("scene.xml");
    let index = |name: &str| {
        scene
            .shapes
            .iter()
            .position(|shape| shape.identity.name == name)
            .expect("there")
    };
    let hidden = Hidden {
        shapes: [index("hidden")].into(),
        ..Hidden::default()
    };
    let flat = index("flat");
    scene.shapes[flat].to_world = Affine3A::from_scale(Vec3::new(1.0, 0.0, 1.0));
    let target = shop.path("level.glb");
    let made: Export = export(&scene, &hidden, &target, &Access::everywhere()).expect("it is made");
    assert_eq!(
        made.messages,
        [
            "shape `flat` is left out: the transform cannot be inverted",
            "shape `hidden` is left out: hidden in the window"
        ]
    );
    made.write().expect("it is written");
    let after = shop.describe("level.glb");
    assert_eq!(after.shapes.len(), 2);
    for (name, is_flat) in [("bare", false), ("faceted", true)] {
        let shape = shape(&after, name);
        assert!(
            matches!(&shape.shape.kind, ShapeKind::Mesh(file) if file.face_normals == is_flat),
            "{name}"
        );
        assert_eq!(mesh_of(shape).triangles.len(), 1);
    }
}

/// The mean of the squared differences of two pictures, relative to the brightness.
fn difference(a: &[Vec3], b: &[Vec3]) -> f32 {
    assert_eq!(a.len(), b.len());
    let one = |(a, b): (&Vec3, &Vec3)| (*a - *b).length_squared() / (0.01 + 0.25 * (*a + *b).length_squared());
    a.iter().zip(b).map(one).sum::<f32>() / a.len() as f32
}

fn mean(picture: &[Vec3]) -> f32 {
    picture.iter().map(|pixel| luminance(*pixel)).sum::<f32>() / picture.len() as f32
}

/// A room with one of most things that glTF has.
const ROOM: &str = r#"
  <shape type="rectangle" id="floor"><transform name="to_world"><scale value="6"/><rotate x="1" angle="-90"/></transform>
    <bsdf type="twosided"><bsdf type="diffuse"><texture type="checkerboard" name="reflectance"><rgb name="color0" value="0.3, 0.25, 0.2"/>
      <rgb name="color1" value="0.7, 0.7, 0.65"/><transform name="to_uv"><scale value="4"/></transform></texture></bsdf></bsdf></shape>
  <shape type="sphere" id="matt"><point name="center" value="-1.6, 0.6, 0"/><float name="radius" value="0.6"/>
    <bsdf type="diffuse"><rgb name="reflectance" value="0.6, 0.3, 0.2"/></bsdf></shape>
  <shape type="sphere" id="rough"><point name="center" value="1.6, 0.6, 0"/><float name="radius" value="0.6"/>
    <bsdf type="principled"><rgb name="base_color" value="0.8, 0.6, 0.3"/><float name="metallic" value="1"/><float name="roughness" value="0.5"/></bsdf></shape>
  <shape type="cube" id="crate"><transform name="to_world"><scale value="0.5"/><rotate y="1" angle="30"/><translate y="0.5" z="-0.5"/></transform>
    <bsdf type="principled"><rgb name="base_color" value="0.2, 0.4, 0.7"/><float name="roughness" value="0.6"/></bsdf></shape>
  <shape type="prism" id="post"><transform name="to_world"><rotate x="1" angle="-90"/><scale x="-1"/><translate x="0.2" z="1.4"/></transform>
    <bsdf type="diffuse"/></shape>
  <shape type="rectangle" id="panel"><transform name="to_world"><rotate x="1" angle="90"/><translate y="3.5"/></transform>
    <bsdf type="twosided"><bsdf type="diffuse"/></bsdf><emitter type="area"><rgb name="radiance" value="4, 3.6, 3"/></emitter></shape>
  <emitter type="spot"><rgb name="intensity" value="20, 14, 10"/><float name="cutoff_angle" value="30"/><float name="beam_width" value="20"/>
    <transform name="to_world"><lookat origin="3, 4, 3" target="0, 0, 0" up="0, 0, 1"/></transform></emitter>
  <emitter type="directional"><vector name="direction" value="-1, -1, -1"/><rgb name="irradiance" value="0.4, 0.5, 0.7"/></emitter>"#;

/// The picture of the exported scene differs from that of the scene by no more than two pictures of the scene with
/// other random numbers do, and by a little for round shapes, which have corners then.
#[test]
fn pictures_are_the_same_after_the_way_there_and_back() {
    let shop = Workshop::new();
    shop.put("room.xml", scene(&format!("{CAMERA}{ROOM}")));
    let scenes = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes");
    let water = scenes.join("cornell-box-water.xml").display().to_string();
    let cornell = scenes.join("cornell-box.xml").display().to_string();
    // The Cornell boxes are seen with a bound on the length of paths, which glTF does not have.
    for (path, depth, factor, bias) in [
        ("room.xml", "-1", 1.3, 0.01),
        (cornell.as_str(), "8", 1.1, 0.01),
        (water.as_str(), "8", 1.3, 0.03),
    ] {
        shop.convert(path, "level.glb");
        let render = |scene: &str, seed: &str| {
            shop.render(
                scene,
                &["--size", "64x48", "--spp", "128", "--max-depth", depth, "--seed", seed],
            )
        };
        let [one, other] = ["1", "2"].map(|seed| render(path, seed));
        let again = render("level.glb", "3");
        let (noise, error) = (difference(&one, &other), difference(&one, &again));
        assert!(error < factor * noise, "{path}: {error}, where noise is {noise}");
        let ratio = 2.0 * mean(&again) / (mean(&one) + mean(&other));
        assert!((ratio - 1.0).abs() < bias, "{path}: {ratio}");
        assert!(noise > 0.0);
    }
}

#[test]
fn what_moves_moves_on() {
    let shop = Workshop::new();
    let text = scene(
        r#"<sensor type="orthographic" id="camera">
          <transform name="to_world"><scale value="4"/><lookat origin="0, 0, 5" target="0, 0, 0" up="0, 1, 0"/></transform>
          <film type="hdrfilm"><integer name="width" value="48"/><integer name="height" value="48"/></film></sensor>
        <shape type="rectangle" id="hand"><animation name="to_world">
            <transform time="0"><scale x="0.4" y="0.4"/><translate x="2"/><rotate z="1" angle="0"/></transform>
            <transform time="2"><scale x="0.4" y="0.4"/><translate x="2"/><rotate z="1" angle="360"/></transform></animation>
          <bsdf type="twosided"><bsdf type="diffuse"/></bsdf><emitter type="area"/></shape>
        <shape type="cube" id="step"><animation name="to_world" interpolation="step">
            <transform time="0"><scale value="0.3"/></transform>
            <transform time="1"><scale value="0.3"/><translate x="3" y="-3"/></transform></animation>
          <bsdf type="twosided"><bsdf type="diffuse"/></bsdf><emitter type="area"/></shape>
        <emitter type="point" id="fly"><animation name="position" interpolation="ease">
          <point time="0" value="-3, 0, 1"/><point time="2" value="3, 0, 1"/></animation></emitter>
        <shape type="rectangle" id="back"><transform name="to_world"><scale value="5"/><translate z="-1"/></transform>
          <bsdf type="twosided"><bsdf type="diffuse"/></bsdf></shape>"#,
    );
    shop.put("scene.xml", text);
    assert_eq!(shop.convert("scene.xml", "level.glb"), [""; 0]);
    let frames = |scene: &str| {
        let options = [
            "--frames",
            "0..4",
            "--fps",
            "2",
            "--size",
            "48x48",
            "--spp",
            "64",
            "--max-depth",
            "2",
            "-q",
        ];
        shop.done(&[&["render", scene, "-o", "#.exr"], &options[..]].concat());
        [0, 1, 2, 3, 4].map(|frame| {
            let image = load(&shop.path(&format!("{frame}.exr")));
            let pixels = (0..48 * 48).map(|i| image.pixel(i % 48, i / 48));
            pixels.collect::<Vec<_>>()
        })
    };
    let (before, after) = (frames("scene.xml"), frames("level.glb"));
    for frame in 0..5 {
        let error = difference(&before[frame], &after[frame]);
        let moved = difference(&before[frame], &before[(frame + 2) % 5]);
        assert!(
            error < 0.02 * moved,
            "{frame}: {error}, where what moves changes {moved}"
        );
    }
}

/// Boards with a normal map: upright pictures, mirrored ones, both on one, mirrored poses, a sphere.
#[test]
fn normal_maps_keep_their_side() {
    let shop = Workshop::new();
    let mut lean = image::RgbImage::new(4, 4);
    for (x, y, pixel) in lean.enumerate_pixels_mut() {
        *pixel = image::Rgb([100 + 20 * (x / 2) as u8, 190 + 10 * (y / 2) as u8, 210]);
    }
    lean.save(shop.path("lean.png")).expect("a picture");
    let board = |normals: &str| {
        let vn = if normals.is_empty() { "" } else { "vn 0 0 1\n" };
        let corner = |vertex: usize, uv: usize| match normals.is_empty() {
            true => format!("{vertex}/{uv}"),
            false => format!("{vertex}/{uv}/1"),
        };
        let face = |corners: [(usize, usize); 4]| {
            let corners = corners.map(|(vertex, uv)| corner(vertex, uv));
            format!("f {}\n", corners.join(" "))
        };
        // The right half, or both, have u run the other way.
        let [plain, mirrored] = [[1, 2, 3, 4], [2, 1, 4, 3]];
        let halves = [[1, 2, 5, 4], [2, 3, 6, 5]];
        let half = |corners: [usize; 4], uvs: [usize; 4]| face(std::array::from_fn(|i| (corners[i], uvs[i])));
        let vertices = "v -1 -1 0\nv 0 -1 0\nv 1 -1 0\nv -1 1 0\nv 0 1 0\nv 1 1 0\nvt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\n";
        [[plain, plain], [mirrored, mirrored], [plain, mirrored]]
            .map(|uvs| format!("{vertices}{vn}{}{}", half(halves[0], uvs[0]), half(halves[1], uvs[1])))
    };
    for (kind, files) in [("bare", board("")), ("smooth", board("yes"))] {
        for (name, text) in ["upright", "mirrored", "mixed"].iter().zip(files) {
            shop.put(&format!("{kind}-{name}.obj"), text);
        }
    }
    let material = |more: &str| {
        format!(
            r#"<bsdf type="twosided"><bsdf type="normalmap"><texture type="bitmap" name="normalmap"><string name="filename" value="lean.png"/>
              <boolean name="raw" value="true"/></texture>{more}<bsdf type="diffuse"><rgb name="reflectance" value="0.8"/></bsdf></bsdf></bsdf>"#
        )
    };
    let light = r#"<emitter type="directional"><vector name="direction" value="0.3, -1, -1"/><rgb name="irradiance" value="6"/></emitter>"#;
    let pictures = |shape: &str, name: &str, tolerance: f32| {
        shop.put("scene.xml", scene(&format!("{CAMERA}{light}{shape}")));
        assert_eq!(shop.convert("scene.xml", "level.gltf"), [""; 0], "{name}");
        let render = |file: &str| shop.render(file, &["--size", "32x24", "--spp", "64", "--max-depth", "2"]);
        let (before, after) = (render("scene.xml"), render("level.gltf"));
        assert!(mean(&before) > 0.01, "{name}");
        let error = difference(&before, &after);
        assert!(error < tolerance, "{name}: {error}");
        let json: serde_json::Value = serde_json::from_slice(&shop.read("level.gltf")).expect("JSON");
        let parts = json["meshes"][0]["primitives"].as_array().expect("a list").clone();
        let first = image::open(shop.path("level-picture-0.png"))
            .expect("a picture")
            .to_rgb8();
        (parts, first.get_pixel(0, 0).0[1])
    };
    let flag = r#"<boolean name="gltf_tangents" value="true"/>"#;
    for kind in ["bare", "smooth"] {
        for (name, green, count) in [("upright", 190, 1), ("mirrored", 65, 1), ("mixed", 190, 2)] {
            for (mirror, more) in [("1", ""), ("-1", ""), ("1", flag), ("-1", flag)] {
                let shape = format!(
                    r#"<shape type="obj"><string name="filename" value="{kind}-{name}.obj"/>
                      <transform name="to_world"><scale x="{mirror}"/></transform>{}</shape>"#,
                    material(more)
                );
                let what = format!("{kind} {name} {mirror} {more}");
                let (parts, found) = pictures(&shape, &what, 2e-3);
                assert_eq!(parts.len(), count, "{what}");
                for part in &parts {
                    assert!(part["attributes"]["TANGENT"].is_u64(), "{what}: {part}");
                }
                if !more.is_empty() {
                    assert_eq!(found, 190, "{what}");
                } else if mirror == "1" {
                    assert_eq!(found, green, "{what}");
                }
            }
        }
    }
    // v points up on a rectangle, as in Mitsuba, and pictures lie mirrored.
    let (_, found) = pictures(
        &format!(r#"<shape type="rectangle">{}</shape>"#, material("")),
        "rectangle",
        2e-3,
    );
    assert_eq!(found, 65);
    pictures(
        &format!(r#"<shape type="sphere">{}</shape>"#, material("")),
        "sphere",
        0.02,
    );
}

/// Bubbles with a normal map run the other way in glTF: all of their triangles are written, also those whose
/// coordinates have no area.
#[test]
fn turned_surfaces_with_normal_maps_keep_all_triangles() {
    let shop = Workshop::new();
    let lean = image::RgbImage::from_pixel(2, 2, image::Rgb([150, 128, 220]));
    lean.save(shop.path("lean.png")).expect("a picture");
    let vertices = "v -1 -1 0\nv 1 -1 0\nv 1 1 0\nv -1 1 0\n";
    let corners = "vt 0 0\nvt 1 0\nvt 1 1\n";
    for (name, faces) in [
        ("bare", "f 1 2 3\nf 1 3 4\n"),
        ("upright", "f 1/1 2/2 3/3\nf 1/1 3/1 4/1\n"),
        ("mirrored", "f 1/1 2/3 3/2\nf 1/1 3/1 4/1\n"),
    ] {
        shop.put("board.obj", format!("{vertices}{corners}{faces}"));
        let text = scene(&format!(
            r#"{CAMERA}<emitter type="point"/><shape type="obj"><string name="filename" value="board.obj"/>
            <bsdf type="normalmap"><texture type="bitmap" name="normalmap"><string name="filename" value="lean.png"/>
              <boolean name="raw" value="true"/></texture>
              <bsdf type="dielectric"><float name="int_ior" value="1"/><float name="ext_ior" value="1.25"/></bsdf></bsdf></shape>"#
        ));
        shop.put("scene.xml", text);
        let said = shop.convert("scene.xml", "level.gltf");
        let after = shop.describe("level.gltf");
        let triangles = after.shapes.iter().map(|shape| mesh_of(shape).triangles.len());
        assert_eq!(triangles.sum::<usize>(), 2, "{name}: {said:?}");
    }
}

#[test]
fn properties_are_extras_and_markers_are_empty_nodes() {
    let text = r#"<scene version="3.0.0"><sensor type="perspective" id="eye"/>
        <volume type="constvolume" id="room/"><float name="value" value="1"/><default name="dark: boolean" value="true"/></volume>
        <shape type="sphere" id="room/coin">
          <default name="value: integer" value="5"/><default name="tint: color list" value="1, 0.5, 0"/>
          <default name="game::Spin: component" value='{"speed": 1.5}'/><default name="game::Shiny: component" value="{}"/>
        </shape>
        <volume type="constvolume" id="start"><float name="value" value="1"/><default name="marker: form" value="point"/>
          <transform name="to_world"><translate value="0, 0, 4"/></transform><default name="type: text" value="spawn"/></volume>
        <volume type="constvolume" id="pit"><float name="value" value="1"/><default name="marker: form" value="box"/>
          <transform name="to_world"><scale value="2"/></transform></volume></scene>"#;
    let mut document = parse_str(text, Path::new("/scene.xml"), &[]);
    let scene = read(&mut document);
    assert!(document.diagnostics.list.is_empty(), "{}", document.diagnostics);
    let export = export(
        &scene,
        &Hidden::default(),
        Path::new("/level.gltf"),
        &Access::everywhere(),
    )
    .unwrap();
    assert_eq!(export.messages, Vec::<String>::new());
    let json: serde_json::Value = serde_json::from_slice(&export.files.last().unwrap().1).unwrap();
    let nodes = json["nodes"].as_array().unwrap();
    let node = |name: &str| nodes.iter().find(|node| node["name"] == name).unwrap();
    assert_eq!(
        node("coin")["extras"],
        serde_json::json!({
            "value": 5, "tint": [[1.0, 0.5, 0.0]],
            "skein": [{ "game::Shiny": {} }, { "game::Spin": { "speed": 1.5 } }],
        })
    );
    assert_eq!(node("room")["extras"], serde_json::json!({ "dark": true }));
    assert_eq!(
        node("start")["extras"],
        serde_json::json!({ "marker": "point", "type": "spawn" })
    );
    assert!(node("start").get("mesh").is_none());
    // Forward is -z in glTF: a half turn about y.
    let rotation: Vec<f32> = serde_json::from_value(node("start")["rotation"].clone()).unwrap();
    assert!((rotation[1].abs() - 1.0).abs() < 1e-5, "{rotation:?}");
    assert_eq!(node("pit")["scale"], serde_json::json!([2.0, 2.0, 2.0]));
    assert!(node("eye").get("extras").is_none());
}
