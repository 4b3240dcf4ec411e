//! Walls, stairs, prisms and roofs: read, edited and saved as numbers, rendered as meshes, and written as PLY files for
//! other programs.

use std::path::Path;

use bevy::math::Vec3;
use bevy::prelude::*;
use sunroom::document;
use sunroom::engine::{EnginePlugin, PackedScene, RenderControl};
use sunroom::math::Ray;
use sunroom::scene::assets::solid_mesh::solid_mesh;
use sunroom::scene::assets::triangle_mesh::load_mesh;
use sunroom::scene::read::read;
use sunroom::scene::write::{Extensions, save_description, write_anew};
use sunroom::scene::*;

const FLAT: &str = "<scene version=\"3.0.0\">
  <sensor type=\"perspective\"/>
  <!-- towards the street -->
  <shape type=\"wall\" id=\"front\">
    <float name=\"length\" value=\"5\"/>
    <string name=\"openings\" value=\"0.5 0 0.9 2.1; 2, 0.9, 1.2, 1.2\"/>
  </shape>
  <shape type=\"stairs\"><integer name=\"steps\" value=\"10\"/><transform name=\"to_world\"><translate z=\"3\"/></transform></shape>
  <shape type=\"prism\"><float name=\"top_radius\" value=\"0\"/><bsdf type=\"diffuse\"/></shape>
</scene>
";

fn describe(path: &Path) -> (SceneDescription, Vec<String>) {
    let mut document = document::load(path, &[]).unwrap();
    let scene = read(&mut document);
    let messages = document.diagnostics.list.iter();
    (scene, messages.map(|message| message.message.clone()).collect())
}

fn solids(scene: &SceneDescription) -> Vec<Solid> {
    let part = |kind: &ShapeKind| match kind {
        ShapeKind::Solid(solid) => solid.clone(),
        other => panic!("{other:?} is no building part"),
    };
    scene.shapes.iter().map(|shape| part(&shape.shape.kind)).collect()
}

#[test]
fn an_edit_of_a_wall_changes_its_line_and_nothing_else() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("main.xml");
    std::fs::write(&path, FLAT).unwrap();
    let (mut scene, messages) = describe(&path);
    assert_eq!(messages, [""; 0]);
    let window = Opening {
        from: 2.0,
        ..Opening::WINDOW
    };
    let front = Solid::Wall {
        length: 5.0,
        height: 2.5,
        thickness: 0.2,
        openings: vec![Opening::DOOR, window],
    };
    assert_eq!(solids(&scene)[0], front);
    save_description(&scene, &path).unwrap();
    assert_eq!(std::fs::read_to_string(&path).unwrap(), FLAT);

    let ShapeKind::Solid(Solid::Wall { openings, .. }) = &mut scene.shapes[0].shape.kind else {
        panic!("no wall")
    };
    openings[1].from = 2.5;
    save_description(&scene, &path).unwrap();
    let saved = std::fs::read_to_string(&path).unwrap();
    let expected = FLAT.replace("2.1; 2, 0.9, 1.2, 1.2", "2.1; 2.5 0.9 1.2 1.2");
    assert_eq!(saved, expected);
    assert_eq!(solids(&describe(&path).0), solids(&scene));
}

#[test]
fn roofs_are_saved_as_their_numbers() {
    const ROOFS: &str = "<scene version=\"3.0.0\">
  <sensor type=\"perspective\"/>
  <shape type=\"gableroof\" id=\"house\"><float name=\"overhang\" value=\"0\"/></shape>
  <shape type=\"hiproof\"><float name=\"width\" value=\"9\"/></shape>
  <shape type=\"shedroof\"><float name=\"gable\" value=\"0\"/></shape>
</scene>
";
    let folder = tempfile::tempdir().unwrap();
    let [path, new] = ["main.xml", "new.xml"].map(|name| folder.path().join(name));
    std::fs::write(&path, ROOFS).unwrap();
    let (mut scene, messages) = describe(&path);
    assert_eq!(messages, [""; 0]);
    let known = solids(&scene);
    assert!(matches!(
        known[0],
        Solid::GableRoof {
            overhang: 0.0,
            gable: 0.2,
            ..
        }
    ));
    assert!(matches!(
        known[1],
        Solid::HipRoof {
            width: 9.0,
            depth: 5.0,
            ..
        }
    ));
    assert!(matches!(
        known[2],
        Solid::ShedRoof {
            gable: 0.0,
            height: 1.2,
            ..
        }
    ));
    save_description(&scene, &path).unwrap();
    assert_eq!(std::fs::read_to_string(&path).unwrap(), ROOFS);
    if let ShapeKind::Solid(Solid::HipRoof { width, .. }) = &mut scene.shapes[1].shape.kind {
        *width = 7.5;
    }
    save_description(&scene, &path).unwrap();
    assert_eq!(
        std::fs::read_to_string(&path).unwrap(),
        ROOFS.replace("value=\"9\"", "value=\"7.5\"")
    );
    assert_eq!(solids(&describe(&path).0), solids(&scene));
    // Other programs get the meshes that are rendered here.
    write_anew(&scene, &new, Extensions::Keep).unwrap();
    let (portable, messages) = describe(&new);
    assert_eq!(messages, [""; 0]);
    assert_eq!(portable.shapes.len(), solids(&scene).len());
    for (shape, part) in portable.shapes.iter().zip(solids(&scene)) {
        let ShapeKind::Mesh(file) = &shape.shape.kind else {
            panic!("{:?} is no mesh", shape.shape.kind);
        };
        let mesh = load_mesh(&file.path, &sunroom::files::Access::everywhere()).unwrap();
        let (read, made) = (&mesh.shapes[0].data, solid_mesh(&part));
        assert!(!read.triangles.is_empty());
        assert_eq!((&read.positions, &read.triangles), (&made.positions, &made.triangles));
    }
}

#[test]
fn numbers_that_make_no_building_part_are_errors_at_their_place() {
    let cases = [
        ("wall", "<float name='length' value='0'/>", "`length`"),
        ("wall", "<string name='openings' value='1 2 3'/>", "four numbers"),
        ("wall", "<float name='openings' value='1'/>", "a string"),
        ("stairs", "<integer name='steps' value='201'/>", "`steps`"),
        ("prism", "<integer name='sides' value='2'/>", "`sides`"),
        ("prism", "<float name='top_radius' value='-1'/>", "`top_radius`"),
        ("gableroof", "<float name='thickness' value='0'/>", "`thickness`"),
        ("shedroof", "<float name='overhang' value='-1'/>", "`overhang`"),
    ];
    for (plugin, parameter, expected) in cases {
        let text = format!(
            "<scene version='3.0.0'><sensor type='perspective'/><shape type='{plugin}'>{parameter}</shape></scene>"
        );
        let mut document = document::parse_str(&*text, Path::new("/a.xml"), &[]);
        let scene = read(&mut document);
        assert!(document.diagnostics.has_errors(), "{parameter}");
        let message = &document.diagnostics.list[0].message;
        assert!(message.contains(expected), "{message}");
        // The part is shown as if the parameter was not given.
        assert_eq!(solids(&scene), [Solid::of_plugin(plugin).unwrap()]);
    }
}

#[test]
fn other_programs_get_meshes() {
    let folder = tempfile::tempdir().unwrap();
    let [old, new] = ["old.xml", "new.xml"].map(|name| folder.path().join(name));
    let twice = FLAT.replace(
        "</scene>",
        "  <shape type=\"stairs\"><integer name=\"steps\" value=\"10\"/></shape>\n</scene>",
    );
    std::fs::write(&old, twice).unwrap();
    let (scene, _) = describe(&old);
    write_anew(&scene, &new, Extensions::Keep).unwrap();
    let (portable, messages) = describe(&new);
    assert_eq!(messages, [""; 0]);
    let text = std::fs::read_to_string(&new).unwrap();
    assert!(
        !text.contains("openings") && !text.contains("steps") && !text.contains("top_radius"),
        "{text}"
    );
    let files: Vec<&MeshFile> = portable
        .shapes
        .iter()
        .map(|shape| match &shape.shape.kind {
            ShapeKind::Mesh(file) => file,
            other => panic!("{other:?} is no mesh"),
        })
        .collect();
    for (file, part) in files.iter().zip(solids(&scene)) {
        let mesh = load_mesh(&file.path, &sunroom::files::Access::everywhere()).unwrap();
        let (read, made) = (&mesh.shapes[0].data, solid_mesh(&part));
        assert_eq!(
            (&read.positions, &read.triangles, &read.uvs),
            (&made.positions, &made.triangles, &made.uvs)
        );
    }
    assert_eq!(files[1].path, files[3].path, "equal parts share a file");
    let names: Vec<_> = files
        .iter()
        .map(|file| file.path.file_name().unwrap().to_string_lossy().into_owned())
        .collect();
    assert_eq!(names[..3], ["new.wall-1.ply", "new.stairs-2.ply", "new.prism-3.ply"]);
    for (one, two) in scene.shapes.iter().zip(&portable.shapes) {
        assert_eq!(one.to_world, two.to_world);
    }
}

#[test]
fn a_wall_without_triangles_is_left_out_for_other_programs() {
    let folder = tempfile::tempdir().unwrap();
    let [old, new] = ["old.xml", "new.xml"].map(|name| folder.path().join(name));
    let covered = FLAT.replace("0.5 0 0.9 2.1;", "-1 -1 9 9;").replace(
        "<float name=\"length\" value=\"5\"/>",
        "<bsdf type=\"diffuse\" id=\"plaster\"/>",
    );
    let covered = covered.replace("<bsdf type=\"diffuse\"/>", "<ref id=\"plaster\"/>");
    std::fs::write(&old, covered).unwrap();
    let (scene, messages) = describe(&old);
    assert_eq!((scene.shapes.len(), messages.as_slice()), (3, &[][..]));
    write_anew(&scene, &new, Extensions::Keep).unwrap();
    let (portable, messages) = describe(&new);
    assert_eq!((portable.shapes.len(), messages.as_slice()), (2, &[][..]));
    // What the wall declared is still there for others.
    let material = portable.shapes[1]
        .material
        .map(|index| portable.materials[index].identity.id.as_deref());
    assert_eq!(material, Some(Some("plaster")));
}

#[test]
fn parts_of_tiny_scenes_are_read_as_they_were_written() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("main.xml");
    std::fs::write(&path, FLAT).unwrap();
    let (mut scene, _) = describe(&path);
    for shape in &mut scene.shapes {
        if let ShapeKind::Solid(part) = &mut shape.shape.kind {
            *part = part.clone().scaled(1e-20);
        }
    }
    save_description(&scene, &path).unwrap();
    let (again, messages) = describe(&path);
    assert_eq!((solids(&again), messages), (solids(&scene), vec![]));
}

#[test]
fn one_sees_through_the_openings_of_a_wall() {
    let mut document = document::parse_str(FLAT, Path::new("/a.xml"), &[]);
    let scene = read(&mut document);
    let mut app = App::new();
    app.add_plugins((MinimalPlugins, FileSourcePlugin, asset_plugin()));
    app.add_plugins((ScenePlugin, EnginePlugin));
    app.world_mut().resource_mut::<RenderControl>().interactive = false;
    app.finish();
    app.cleanup();
    spawn::spawn_fresh(app.world_mut(), &scene.into());
    app.update();
    let scene = app
        .world()
        .resource::<PackedScene>()
        .scene
        .clone()
        .expect("the scene is packed");
    let is_hit = |x: f32, z: f32| {
        let ray = Ray::new(Vec3::new(x, -5.0, z), Vec3::Y);
        scene.geometry.intersect(&ray).is_some_and(|hit| hit.t < 5.5)
    };
    assert!(is_hit(0.2, 1.0) && is_hit(1.7, 1.0) && is_hit(4.5, 2.4), "the wall");
    assert!(!is_hit(1.0, 1.0) && !is_hit(2.6, 1.5), "its door and its window");
    assert!(is_hit(1.0, 2.3) && is_hit(2.6, 0.5), "above the door, below the window");
}
