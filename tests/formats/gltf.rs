//! glTF files where scenes are expected: rendered, checked, converted, saved and read again when they change.

use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::{Duration, Instant};

use bevy::prelude::*;
use sunroom::geometry::mesh::MeshData;
use sunroom::scene::assets::scene_asset::read_scene;
use sunroom::scene::write::{SaveError, save_description};
use sunroom::scene::{Material, *};

use crate::gltf_support::Parts;
use crate::workshop::Workshop;

/// Side by side a wall and a smaller one, in their materials, before a camera, in sunlight.
const REST: &str = r#"
  "materials": [{"name": "plaster", "pbrMetallicRoughness": {"baseColorFactor": [0.8, 0.2, 0.1, 1], "metallicFactor": 0}},
    {"name": "tin", "pbrMetallicRoughness": {"roughnessFactor": 0.4}, "doubleSided": true}],
  "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "mode": 6, "material": 0}]},
    {"primitives": [{"attributes": {"POSITION": 1}, "mode": 6, "material": 1}]}],
  "cameras": [{"type": "perspective", "perspective": {"yfov": 0.8, "aspectRatio": 1, "znear": 0.1}}],
  "extensions": {"KHR_lights_punctual": {"lights": [{"type": "directional", "intensity": 2049}]}},
  "nodes": [{"name": "wall", "mesh": 0, "translation": [-1, 0, 0]}, {"name": "plate", "mesh": 1},
    {"camera": 0, "translation": [0, 0.5, 3]}, {"extensions": {"KHR_lights_punctual": {"light": 0}}}]"#;

fn squares(size: f32) -> Parts {
    let mut parts = Parts::default();
    for side in [1.0, size] {
        let corners = [[0.0, 0.0], [side, 0.0], [side, side], [0.0, side]];
        let numbers: Vec<f32> = corners.iter().flat_map(|[x, y]| [*x, *y, 0.0]).collect();
        parts.floats("VEC3", &numbers);
    }
    parts
}

impl Workshop {
    /// `model.gltf`, with its buffer in `model.bin`.
    fn put_model(&self, size: f32, rest: &str) -> PathBuf {
        let parts = squares(size);
        self.put("model.bin", &parts.bytes);
        self.put("model.gltf", parts.json(r#", "uri": "model.bin""#, rest))
    }
}

#[test]
fn a_binary_file_renders_as_the_scene_it_is_converted_to() {
    let shop = Workshop::new();
    shop.put("model.glb", squares(0.5).binary(REST));
    let render = |scene: &str, picture: &str| {
        shop.done(&[
            "render", scene, "-o", picture, "--width", "32", "--spp", "4", "--strict", "-q",
        ]);
    };
    shop.done(&["check", "--strict", "model.glb"]);
    render("model.glb", "direct.exr");
    shop.done(&["convert", "--strict", "model.glb", "out/scene.xml"]);
    // What is written stands on its own.
    std::fs::remove_dir_all(shop.path("cache")).expect("parts were kept here");
    std::fs::remove_file(shop.path("model.glb")).expect("is there");
    std::fs::rename(shop.path("out"), shop.path("moved")).expect("can be moved");
    render("moved/scene.xml", "converted.exr");
    assert!(colors(&shop, "direct.exr") == colors(&shop, "converted.exr"));
    for part in ["mesh-0.ply", "mesh-1.ply"] {
        assert!(shop.path("moved/scene-files").join(part).is_file(), "{part}");
    }
    let image = sunroom::texture::load_image(&shop.read("direct.exr")).expect("a picture");
    // Reddish plaster at the left, dark where nothing is.
    let plaster = image.pixel(10, 16);
    assert!(plaster.x > 0.3 && plaster.x > 2.0 * plaster.y, "{plaster}");
    assert_eq!(image.pixel(1, 1), Vec3::ZERO);
}

/// The colours of a picture.
fn colors(shop: &Workshop, name: &str) -> Vec<[u32; 3]> {
    let image = sunroom::texture::load_image(&shop.read(name)).expect("a picture");
    let row = |y| (0..image.width()).map(move |x| (x, y));
    let places = (0..image.height()).flat_map(row);
    places
        .map(|(x, y)| image.pixel(x, y).to_array().map(f32::to_bits))
        .collect()
}

/// A shining square of one unit hangs on a node that turns by 180 degrees about z in a second; the camera rises by a
/// unit in the next second.
const MOVING: &str = r#"
  "materials": [{"emissiveFactor": [1, 1, 1]}],
  "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "mode": 6, "material": 0}]}],
  "cameras": [{"type": "orthographic", "orthographic": {"xmag": 2, "ymag": 2, "znear": 0.1, "zfar": 10}}],
  "nodes": [{"children": [1]}, {"mesh": 0, "translation": [0.5, -0.5, 0]}, {"camera": 0, "translation": [0, 0, 4]}],
  "animations": [{"samplers": [{"input": 2, "output": 3}, {"input": 4, "output": 5}],
    "channels": [{"sampler": 0, "target": {"node": 0, "path": "rotation"}}, {"sampler": 1, "target": {"node": 2, "path": "translation"}}]}]"#;

#[test]
fn frames_show_what_the_animations_of_a_file_move() {
    let shop = Workshop::new();
    let mut parts = squares(0.5);
    parts.floats("SCALAR", &[0.0, 0.5, 1.0]);
    let half = 0.5f32.sqrt();
    parts.floats("VEC4", &[0.0, 0.0, 0.0, 1.0, 0.0, 0.0, half, half, 0.0, 0.0, 1.0, 0.0]);
    parts.floats("SCALAR", &[1.0, 2.0]);
    parts.floats("VEC3", &[0.0, 0.0, 4.0, 0.0, 1.0, 4.0]);
    shop.put("model.glb", parts.binary(MOVING));
    let options = [
        "--frames", "0..4", "--fps", "2", "--size", "32x32", "--spp", "1", "--strict", "-q",
    ];
    shop.done(&[&["render", "model.glb", "-o", "#.exr"], &options[..]].concat());
    // A unit is eight pixels, and the middle is at (16, 16).
    for (frame, [x, y]) in [[24, 16], [16, 8], [8, 16], [8, 20], [8, 24]].into_iter().enumerate() {
        let picture = sunroom::texture::load_image(&shop.read(&format!("{frame}.exr"))).expect("a picture");
        for (far, expected) in [(1, 1.0), (7, 0.0)] {
            for (right, down) in [(-far, 0), (far, 0), (0, -far), (0, far)] {
                let (x, y) = ((x + right) as u32, (y + down) as u32);
                assert_eq!(picture.pixel(x, y).x, expected, "{frame}: {x}, {y}");
            }
        }
    }
    // The scene that it is converted to has the same key frames.
    shop.done(&["convert", "--strict", "model.glb", "scene.xml"]);
    shop.done(&[&["render", "scene.xml", "-o", "converted-#.exr"], &options[..]].concat());
    for frame in 0..5 {
        let names = ["", "converted-"].map(|kind| format!("{kind}{frame}.exr"));
        assert!(colors(&shop, &names[0]) == colors(&shop, &names[1]), "{frame}");
    }
}

/// A shining square over a floor, both alike at the left and at the right, seen from the front. `NORMAL` stands for
/// what the square has besides positions, `PLACE` for where it stands, and `MORE` for more of its material.
const LAMP: &str = r#"
  "materials": [{"emissiveFactor": [1, 1, 1], "pbrMetallicRoughness": {"baseColorFactor": [0, 0, 0, 1]}MORE},
    {"pbrMetallicRoughness": {"metallicFactor": 0}}],
  "meshes": [{"primitives": [{"attributes": {"POSITION": 0NORMAL}, "mode": 6, "material": 0}]},
    {"primitives": [{"attributes": {"POSITION": 1}, "mode": 6, "material": 1}]}],
  "cameras": [{"type": "perspective", "perspective": {"yfov": 0.8, "aspectRatio": 1, "znear": 0.1}}],
  "nodes": [{"mesh": 0, PLACE}, {"camera": 0, "translation": [0, 0.5, 4]},
    {"mesh": 1, "rotation": [-0.70710678, 0, 0, 0.70710678], "translation": [-2, -0.2, 4]}]"#;

impl Workshop {
    /// The mean of the picture of a file. A render that does not come to an end fails.
    fn mean(&self, file: &[u8]) -> Vec3 {
        self.put("lamp.glb", file);
        self.done(&[
            "render", "lamp.glb", "-o", "lamp.exr", "--width", "32", "--spp", "32", "--time", "100s", "-q",
        ]);
        let image = sunroom::texture::load_image(&self.read("lamp.exr")).expect("a picture");
        image.mean(false)
    }
}

/// As glTF has it (section 3.7.4), lamps shine to the front also where a node mirrors them.
#[test]
fn mirrored_lamps_give_the_light_of_others() {
    let shop = Workshop::new();
    let mut parts = squares(4.0);
    parts.floats("VEC3", &[0.0, 0.0, 1.0].repeat(4));
    for normal in ["", r#", "NORMAL": 2"#] {
        let [plain, mirrored, turned] = [[1, 1, 1], [-1, 1, 1], [-1, 1, -1]].map(|scale| {
            let place = format!(r#""scale": {scale:?}"#);
            let rest = LAMP.replace("NORMAL", normal).replace("PLACE", &place);
            shop.mean(&parts.binary(&rest.replace("MORE", ""))).x
        });
        assert!(plain > 0.05, "{plain}");
        assert!(
            (mirrored / plain - 1.0).abs() < 0.02,
            "{normal}: {mirrored}, not {plain}"
        );
        // It is turned around, and its back is dark.
        assert!(turned < 0.2 * plain, "{normal}: {turned}");
    }
}

/// Shadow rays end a rounding before the faces of such a lamp, meet them all the same now and then, and must not do so
/// for ever.
#[test]
fn a_lamp_that_a_mask_takes_away_ends_the_render() {
    let shop = Workshop::new();
    shop.put(
        "lamp.xml",
        r#"<scene version="3.0.0"><sensor type="perspective"><transform name="to_world"><lookat origin="0, 0.5, 4" target="0, 0, 0" up="0, 1, 0"/></transform></sensor>
          <shape type="cube"><transform name="to_world"><scale value="0.5"/></transform><emitter type="area"/>
            <bsdf type="mask"><float name="opacity" value="0"/><bsdf type="diffuse"/></bsdf></shape>
          <shape type="rectangle"><transform name="to_world"><scale value="4"/><rotate x="1" angle="-90"/><translate y="-0.6"/></transform></shape></scene>"#,
    );
    shop.done(&[
        "render", "lamp.xml", "-o", "lamp.exr", "--size", "32x18", "--spp", "32", "--time", "100s", "-q",
    ]);
    let image = sunroom::texture::load_image(&shop.read("lamp.exr")).expect("a picture");
    // As in Mitsuba, a lamp shines even where it lets all light pass.
    assert!(image.mean(false).x > 0.05, "{}", image.mean(false));
}

#[test]
fn what_is_wrong_is_one_error_with_the_name_of_the_file() {
    let shop = Workshop::new();
    let good = squares(0.5).binary(REST);
    shop.put("cut.glb", &good[..good.len() / 2]);
    let required = r#""extensionsRequired": ["KHR_physics_rigid_bodies"], "#;
    shop.put("physics.gltf", squares(0.5).text(&format!("{required}{REST}")));
    shop.put("empty.gltf", "");
    shop.put("foreign.glb", [0x1f, 0x8b, 0x08, 0x00]);
    let without_buffer = squares(0.5).json(r#", "uri": "gone.bin""#, REST);
    shop.put("bare.gltf", without_buffer);
    for (file, what) in [
        ("cut.glb", "ends before"),
        ("physics.gltf", "KHR_physics_rigid_bodies"),
        ("empty.gltf", "the file is empty"),
        ("foreign.glb", "neither binary glTF"),
        ("bare.gltf", "gone.bin"),
    ] {
        let output = shop.sunroom(&["check", file]);
        let said = String::from_utf8_lossy(&output.stderr).replace('\n', " ");
        assert_eq!(output.status.code(), Some(1), "{said}");
        assert!(said.contains(file) && said.contains(what), "{file}: {said}");
        assert_eq!(said.matches('×').count(), 1, "{file}: {said}");
    }
}

#[test]
fn all_files_that_are_missing_are_named_at_once() {
    let shop = Workshop::new();
    shop.put("here.bin", [0; 8]);
    shop.put(
        "model.gltf",
        r#"{"asset": {"version": "2.0"},
            "buffers": [{"uri": "gone.bin", "byteLength": 4}, {"uri": "here.bin", "byteLength": 8},
                {"uri": "data:,1234", "byteLength": 4}, {"uri": "more%20gone.bin", "byteLength": 4},
                {"uri": "gone.bin", "byteLength": 4}],
            "images": [{"uri": "gone.png"}, {"bufferView": 0}]}"#,
    );
    let output = shop.sunroom(&["check", "model.gltf"]);
    let said = String::from_utf8_lossy(&output.stderr).replace('\n', " ");
    assert_eq!(output.status.code(), Some(1), "{said}");
    assert!(said.contains("2 errors, 1 warning"), "{said}");
    for name in ["gone.bin", "more gone.bin", "gone.png"] {
        assert!(said.contains(&format!("{name}: no such file")), "{name}: {said}");
    }
    assert!(!said.contains("here.bin"), "{said}");
}

#[test]
fn it_is_saved_under_another_name_with_its_parts_beside_it() {
    let shop = Workshop::new();
    let path = shop.put("model.glb", squares(0.5).binary(REST));
    let read = |path: &Path| read_scene(std::fs::read(path).expect("is there"), path, &[]);
    let opened = read(&path);
    assert!(!opened.diagnostics.has_errors(), "{}", opened.diagnostics);
    let Err(SaveError::Foreign { proposal, .. }) = save_description(&opened.description, &path) else {
        panic!("the model was replaced");
    };
    assert_eq!(proposal.file_name(), Some("model.xml".as_ref()));
    let mut edited = (*opened.description).clone();
    edited.shapes[1].to_world.translation.x += 0.25;
    save_description(&edited, &proposal).expect("can be written");
    let saved = read(&proposal);
    assert_eq!(saved.diagnostics.list, []);
    assert_eq!(saved.description.shapes[1].to_world, edited.shapes[1].to_world);
    for (shape, part) in saved.description.shapes.iter().zip(["mesh-0.ply", "mesh-1.ply"]) {
        let ShapeKind::Mesh(mesh) = &shape.shape.kind else {
            panic!("{shape:?}")
        };
        let expected = shop.path("model-files").join(part);
        assert_eq!(mesh.path, expected.canonicalize().expect("is there"));
    }
    let names = |scene: &SceneDescription| {
        let materials = scene.materials.iter();
        materials
            .map(|material| (material.identity.id.clone(), material.material.clone()))
            .collect::<Vec<_>>()
    };
    assert_eq!(names(&saved.description), names(&edited));
}

/// An app that has a file open.
struct Open(App);

impl Open {
    fn new(path: PathBuf) -> Self {
        let mut app = App::new();
        app.add_plugins((MinimalPlugins, FileSourcePlugin, asset_plugin(), ScenePlugin));
        app.finish();
        app.cleanup();
        app.world_mut().write_message(OpenScene {
            path,
            defines: vec![],
            ..OpenScene::default()
        });
        let mut open = Self(app);
        open.until_revision(1);
        // The watch needs frames to hear of the files, which no message tells.
        open.wait();
        open
    }

    /// For longer than the watch holds changes back.
    fn wait(&mut self) {
        let end = Instant::now() + Duration::from_millis(500);
        while Instant::now() < end {
            self.0.update();
            std::thread::sleep(Duration::from_millis(5));
        }
    }

    fn data(&mut self, id: &str) -> Arc<MeshData> {
        let handle = self.get::<MeshHandle>(id);
        let meshes = self.0.world().resource::<Assets<TriangleMesh>>();
        meshes.get(&handle.0).expect("is loaded").shapes[0].data.clone()
    }

    fn until_revision(&mut self, revision: u64) {
        self.until(|open| open.0.world().resource::<SceneStatus>().revision >= revision);
    }

    /// Until that is so and everything is loaded; the deadline is for tests that hang.
    fn until(&mut self, is_so: impl Fn(&mut Self) -> bool) {
        let deadline = Instant::now() + Duration::from_secs(600);
        loop {
            self.0.update();
            if is_so(self) && self.0.world().resource::<SceneStatus>().is_complete() {
                return;
            }
            let status = self.0.world().resource::<SceneStatus>();
            assert!(Instant::now() < deadline, "not in time: {status:?}");
            std::thread::sleep(Duration::from_millis(5));
        }
    }

    fn get<C: Component + Clone>(&mut self, id: &str) -> C {
        let world = self.0.world_mut();
        let mut all = world.query::<(&SceneId, &C)>();
        let found = all.iter(world).find(|(found, _)| found.0 == id);
        found.unwrap_or_else(|| panic!("no {id}")).1.clone()
    }
}

#[test]
fn of_a_changed_file_only_what_changed_is_loaded_again() {
    let shop = Workshop::new();
    let path = shop.put_model(0.5, REST);
    let mut open = Open::new(path);
    let [wall, plate] = ["wall", "plate"].map(|id| open.get::<MeshHandle>(id));
    let [wall_data, plate_data] = ["wall", "plate"].map(|id| open.data(id));

    shop.put_model(0.5, &REST.replace("0.8, 0.2, 0.1", "0.1, 0.2, 0.8"));
    open.until_revision(2);
    let Material::Principled(principled) = open.nested("plaster") else {
        panic!("no principled material")
    };
    assert_eq!(principled.base_color.constant(), Some(Vec3::new(0.1, 0.2, 0.8)));
    assert_eq!(
        ["wall", "plate"].map(|id| open.get::<MeshHandle>(id)),
        [wall.clone(), plate.clone()]
    );
    open.wait();
    assert!(Arc::ptr_eq(&open.data("wall"), &wall_data));
    assert!(Arc::ptr_eq(&open.data("plate"), &plate_data));

    // Of the buffer beside it only the second square changes.
    shop.put("model.bin", squares(0.75).bytes);
    open.until(|open| open.get::<MeshHandle>("plate") != plate);
    assert_eq!(open.get::<MeshHandle>("wall"), wall);
    assert_ne!(open.get::<MeshHandle>("plate"), plate);
    assert_eq!(open.data("plate").bounds().extent(), Vec3::new(0.75, 0.75, 0.0));
    open.wait();
    assert!(Arc::ptr_eq(&open.data("wall"), &wall_data));
}

impl Open {
    /// The material inside the two-sided one of this id.
    fn nested(&mut self, id: &str) -> Material {
        let inner = self.get::<FirstNested>(id).0;
        self.0.world().get::<Material>(inner).expect("is a material").clone()
    }
}

/// Two halves of a board whose normals lean up by a map, side by side before a camera. The light comes from above,
/// along the leaning normals.
const BOARD: &str = r#"
  "materials": [{"name": "leaning", "pbrMetallicRoughness": {"metallicFactor": 0, "roughnessFactor": 1}, "normalTexture": {"index": 0},
    "extensions": {"KHR_materials_specular": {"specularFactor": 0}}}],
  "images": [{"uri": "lean.png"}], "textures": [{"source": 0}],
  "meshes": [{"primitives": [
    {"attributes": {"POSITION": 0, "NORMAL": 2, "TEXCOORD_0": 3TANGENT}, "mode": 6, "material": 0},
    {"attributes": {"POSITION": 1, "NORMAL": 2, "TEXCOORD_0": 4TANGENT}, "mode": 6, "material": 0}]}],
  "cameras": [{"type": "orthographic", "orthographic": {"xmag": 1, "ymag": 1, "znear": 0.1, "zfar": 10}}],
  "extensions": {"KHR_lights_punctual": {"lights": [{"type": "directional", "intensity": 2145.71}]}},
  "nodes": [{"mesh": 0SCALE}, {"camera": 0, "translation": [0, 0, 4]},
    {"rotation": [-0.3826834, 0, 0, 0.9238795], "extensions": {"KHR_lights_punctual": {"light": 0}}}]"#;

/// The light of both halves. `mirrored`: on which of them the picture lies mirrored.
fn leaning_board(shop: &Workshop, mirrored: [bool; 2], tangent: Option<[f32; 4]>, scale: [f32; 3]) -> [f32; 2] {
    let mut lean = image::RgbImage::new(2, 2);
    lean.pixels_mut().for_each(|pixel| *pixel = image::Rgb([128, 218, 218]));
    lean.save(shop.path("lean.png")).expect("a picture");
    let mut parts = Parts::default();
    for x in [-1.0f32, 0.0] {
        let corners = [[x, -1.0, 0.0], [x + 1.0, -1.0, 0.0], [x + 1.0, 1.0, 0.0], [x, 1.0, 0.0]];
        parts.floats("VEC3", corners.as_flattened());
    }
    parts.floats("VEC3", &[0.0, 0.0, 1.0].repeat(4));
    for mirrored in mirrored {
        let along = |u: f32| if mirrored { 1.0 - u } else { u };
        parts.floats(
            "VEC2",
            &[along(0.0), 1.0, along(1.0), 1.0, along(1.0), 0.0, along(0.0), 0.0],
        );
    }
    parts.floats("VEC4", &tangent.unwrap_or_default().repeat(4));
    let attribute = if tangent.is_some() { r#", "TANGENT": 5"# } else { "" };
    let scale = format!(r#", "scale": {scale:?}"#);
    let rest = BOARD
        .replace("TANGENT}", &format!("{attribute}}}"))
        .replace("SCALE", &scale);
    shop.put("board.glb", parts.binary(&rest));
    let options = ["--size", "16x16", "--spp", "4", "--strict", "-q"];
    shop.done(&[&["render", "board.glb", "-o", "board.exr"], &options[..]].concat());
    shop.done(&["convert", "--strict", "board.glb", "board.xml"]);
    shop.done(&[&["render", "board.xml", "-o", "again.exr"], &options[..]].concat());
    assert!(colors(shop, "board.exr") == colors(shop, "again.exr"));
    let image = sunroom::texture::load_image(&shop.read("board.exr")).expect("a picture");
    [4, 12].map(|x| image.pixel(x, 8).x)
}

/// Green is up in glTF, also where a picture or a node is mirrored; tangents of the file say otherwise if they want to.
#[test]
fn normals_lean_as_the_handedness_of_coordinates_says() {
    let shop = Workshop::new();
    let (one, turned) = ([1.0; 3], [-1.0, 1.0, 1.0]);
    let (upright, mixed) = ([false; 2], [false, true]);
    for (mirrored, tangent, scale, expected) in [
        (upright, None, one, 1.0),
        ([true; 2], None, one, 1.0),
        (mixed, None, one, 1.0),
        (upright, None, turned, 1.0),
        (mixed, None, turned, 1.0),
        (upright, Some([1.0, 0.0, 0.0, 1.0]), one, 1.0),
        (mixed, Some([1.0, 0.0, 0.0, 1.0]), one, 1.0),
        (upright, Some([1.0, 0.0, 0.0, -1.0]), one, 0.0),
        (upright, Some([1.0, 0.0, 0.0, 1.0]), turned, 1.0),
        // x is up, and y to the left.
        (upright, Some([0.0, 1.0, 0.0, 1.0]), one, 0.5),
    ] {
        let found = leaning_board(&shop, mirrored, tangent, scale);
        for half in found {
            assert!(
                (half - expected).abs() < 0.04,
                "{mirrored:?} {tangent:?} {scale:?}: {found:?}, not {expected}"
            );
        }
    }
}

/// The sphere with its normals, each as its corner.
fn ball(parts: &mut Parts) {
    let (rows, columns) = (24u16, 48u16);
    let mut corners: Vec<f32> = Vec::new();
    for row in 0..=rows {
        for column in 0..=columns {
            let (theta, phi) = (
                std::f32::consts::PI * f32::from(row) / f32::from(rows),
                std::f32::consts::TAU * f32::from(column) / f32::from(columns),
            );
            corners.extend([phi.sin() * theta.sin(), theta.cos(), phi.cos() * theta.sin()]);
        }
    }
    let corner = |row: u16, column: u16| row * (columns + 1) + column;
    let cells = (0..rows).flat_map(|row| (0..columns).map(move |column| (row, column)));
    let triangles: Vec<u16> = cells
        .flat_map(|(row, column)| {
            let [a, b] = [corner(row, column), corner(row + 1, column)];
            [a, b, b + 1, a, b + 1, a + 1]
        })
        .collect();
    parts.floats("VEC3", &corners);
    parts.floats("VEC3", &corners);
    let bytes: Vec<u8> = triangles.iter().flat_map(|corner| corner.to_le_bytes()).collect();
    let view = parts.view(&bytes, "");
    parts.accessor(view, 5123, "SCALAR", triangles.len(), "");
}

/// White things and mirrors are seen before what stands in for light.
#[test]
fn white_and_metal_are_seen_without_a_light() {
    let shop = Workshop::new();
    for (what, pbr) in [
        ("chrome", r#""roughnessFactor": 0"#),
        ("white", r#""metallicFactor": 0"#),
    ] {
        let mut parts = Parts::default();
        ball(&mut parts);
        let rest = format!(
            r#""materials": [{{"pbrMetallicRoughness": {{{pbr}}}}}], "nodes": [{{"mesh": 0}}],
               "meshes": [{{"primitives": [{{"attributes": {{"POSITION": 0, "NORMAL": 1}}, "indices": 2, "material": 0}}]}}]"#
        );
        shop.put("ball.glb", parts.binary(&rest));
        shop.done(&[
            "render", "ball.glb", "-o", "ball.exr", "--size", "32x32", "--spp", "32", "--strict", "-q",
        ]);
        let image = sunroom::texture::load_image(&shop.read("ball.exr")).expect("a picture");
        let pixels: Vec<f32> = (0..32 * 32).map(|at| image.pixel(at % 32, at / 32).x).collect();
        let mean = pixels.iter().sum::<f32>() / pixels.len() as f32;
        let variance = pixels.iter().map(|pixel| (pixel - mean).powi(2)).sum::<f32>() / pixels.len() as f32;
        assert!((0.6..1.3).contains(&mean), "{what}: {mean}");
        assert!(variance.sqrt() > 0.05, "{what}: {}", variance.sqrt());
    }
}

/// The picture behind what fades is seen through it, and colours of vertices multiply pictures.
#[test]
fn colours_of_vertices_and_both_sides_of_lamps_are_seen() {
    let shop = Workshop::new();
    let square = |material: &str, attributes: &str, turn: &str| {
        let mut parts = Parts::default();
        parts.floats(
            "VEC3",
            &[-1.0, -1.0, 0.0, 1.0, -1.0, 0.0, 1.0, 1.0, 0.0, -1.0, 1.0, 0.0],
        );
        parts.floats("VEC4", &[[1.0, 0.5, 0.25, 0.5]; 4].concat());
        parts.floats("VEC2", &[0.0, 1.0, 1.0, 1.0, 1.0, 0.0, 0.0, 0.0]);
        let rest = format!(
            r#""materials": [{material}], "images": [{{"uri": "grey.png"}}], "textures": [{{"source": 0}}],
               "cameras": [{{"type": "orthographic", "orthographic": {{"xmag": 0.5, "ymag": 0.5, "znear": 0.1, "zfar": 10}}}}],
               "meshes": [{{"primitives": [{{"attributes": {{"POSITION": 0, "TEXCOORD_0": 2{attributes}}}, "mode": 6, "material": 0}}]}}],
               "nodes": [{{"mesh": 0{turn}}}, {{"camera": 0, "translation": [0, 0, 4]}}]"#
        );
        let mut grey = image::RgbImage::new(1, 1);
        grey.put_pixel(0, 0, image::Rgb([188; 3]));
        grey.save(shop.path("grey.png")).expect("a picture");
        shop.put("square.glb", parts.binary(&rest));
        shop.done(&[
            "render",
            "square.glb",
            "-o",
            "square.exr",
            "--size",
            "8x8",
            "--spp",
            "256",
            "--strict",
            "-q",
        ]);
        let image = sunroom::texture::load_image(&shop.read("square.exr")).expect("a picture");
        image.mean(false)
    };
    let matt = r#""extensions": {"KHR_materials_specular": {"specularFactor": 0}}"#;
    let colors = r#", "COLOR_0": 1"#;
    // Half of the white that the picture has beside its alpha.
    let painted = square(
        &format!(r#"{{"pbrMetallicRoughness": {{"metallicFactor": 0, "baseColorTexture": {{"index": 0}}}}, {matt}}}"#),
        colors,
        "",
    );
    assert!((0.35..0.55).contains(&painted.x), "{painted}");
    assert!(
        ((painted / painted.x) - Vec3::new(1.0, 0.5, 0.25)).abs().max_element() < 0.02,
        "{painted}"
    );
    let fading = square(
        &format!(
            r#"{{"alphaMode": "BLEND", "pbrMetallicRoughness": {{"baseColorFactor": [0, 0, 0, 0.5], "metallicFactor": 0}}, {matt}}}"#
        ),
        colors,
        "",
    );
    // The backdrop of the studio is 1, of which 1 - 0.5 * 0.5 comes through.
    assert!((fading.x - 0.75).abs() < 0.05, "{fading}");
    let lamp = |more: &str| {
        let material = format!(
            r#"{{"emissiveFactor": [1, 1, 1], "pbrMetallicRoughness": {{"baseColorFactor": [0, 0, 0, 1], "metallicFactor": 0}}, {matt}{more}}}"#
        );
        square(&material, "", r#", "rotation": [0, 1, 0, 0]"#).x
    };
    assert_eq!(lamp(""), 0.0);
    assert!((lamp(r#", "doubleSided": true"#) - 1.0).abs() < 1e-3);
}

/// The left half of a pane is polished metal, which reflects the dark before it, and the right half is glass before a
/// lamp.
#[test]
fn metal_beside_glass_lets_no_light_through() {
    let shop = Workshop::new();
    let mut parts = squares(1.0);
    parts.floats("VEC2", &[0.0, 1.0, 1.0, 1.0, 1.0, 0.0, 0.0, 0.0]);
    let mut halves = image::RgbImage::new(2, 1);
    halves.put_pixel(0, 0, image::Rgb([0, 0, 255]));
    halves.save(shop.path("halves.png")).expect("a picture");
    let rest = r#"
      "materials": [{"name": "leaded", "pbrMetallicRoughness": {"roughnessFactor": 0, "metallicRoughnessTexture": {"index": 0}},
          "extensions": {"KHR_materials_transmission": {"transmissionFactor": 1}}},
        {"emissiveFactor": [1, 1, 1], "pbrMetallicRoughness": {"baseColorFactor": [0, 0, 0, 1], "metallicFactor": 0}}],
      "images": [{"uri": "halves.png"}], "samplers": [{"magFilter": 9728, "minFilter": 9728}], "textures": [{"source": 0, "sampler": 0}],
      "meshes": [{"primitives": [{"attributes": {"POSITION": 0, "TEXCOORD_0": 2}, "mode": 6, "material": 0}]},
        {"primitives": [{"attributes": {"POSITION": 0}, "mode": 6, "material": 1}]}],
      "cameras": [{"type": "orthographic", "orthographic": {"xmag": 0.5, "ymag": 0.5, "znear": 0.1, "zfar": 10}}],
      "nodes": [{"mesh": 0}, {"mesh": 1, "translation": [0, 0, -1]}, {"camera": 0, "translation": [0.5, 0.5, 4]}]"#;
    shop.put("pane.glb", parts.binary(rest));
    let size = ["--size", "16x16", "--spp", "64", "--strict", "-q"];
    shop.done(&[&["render", "pane.glb", "-o", "pane.exr"], &size[..]].concat());
    let image = sunroom::texture::load_image(&shop.read("pane.exr")).expect("a picture");
    let (metal, glass) = (image.pixel(4, 8).x, image.pixel(12, 8).x);
    assert!(metal < 0.02, "{metal}");
    assert!((0.8..1.0).contains(&glass), "{glass}");
}
