//! Groups of shapes and their instances, from the file to the hierarchy and back; shapes of serialized files.

use std::io::Write;
use std::path::Path;
use std::time::{Duration, Instant};

use bevy::math::Affine3A;
use bevy::prelude::*;
use flate2::Compression;
use flate2::write::ZlibEncoder;
use sunroom::app::headless::{headless, render_only};
use sunroom::color::Rgb;
use sunroom::document;
use sunroom::engine::{EnginePlugin, Limits, PackedScene, RenderControl, RenderFilm, render_to_completion};
use sunroom::math::Ray;
use sunroom::render::scene::RenderScene;
use sunroom::scene::read::read;
use sunroom::scene::write::to_document;
use sunroom::scene::*;

const GROUP: &str = "<bsdf type='diffuse' id='red'><rgb name='reflectance' value='0.8,0.1,0.1'/></bsdf>
  <shape type='shapegroup' id='g'>
    <shape type='sphere'><float name='radius' value='0.5'/><ref id='red'/></shape>
    <shape type='cylinder'><point name='p0' value='0,0.2,0'/><point name='p1' value='1,0.2,0'/><float name='radius' value='0.3'/>
      <bsdf type='conductor'/></shape>
    <shape type='cube'><transform name='to_world'><scale value='0.2'/><translate y='-1'/></transform></shape>
  </shape>";

fn place(i: usize) -> String {
    format!(
        "<transform name='to_world'><rotate x='0.6' y='0.8' angle='{}'/><scale value='1,2,0.5'/><translate x='{}' z='{}'/></transform>",
        37 * i,
        3 * (i % 40),
        4 * (i / 40)
    )
}

fn instance(i: usize) -> String {
    format!("<shape type='instance'><ref id='g'/>{}</shape>\n", place(i))
}

fn read_scene(body: &str) -> (SceneDescription, Vec<String>) {
    let text = format!("<scene version='3.0.0'>\n<sensor type='perspective'/>\n{body}\n</scene>");
    let mut document = document::parse_str(&*text, &std::env::temp_dir().join("scene.xml"), &[]);
    let scene = read(&mut document);
    let messages = document.diagnostics.list.iter();
    (scene, messages.map(|message| message.message.clone()).collect())
}

fn clean(body: &str) -> SceneDescription {
    let (scene, messages) = read_scene(body);
    assert_eq!(messages, [""; 0]);
    scene
}

fn app() -> App {
    let mut app = App::new();
    app.add_plugins((
        MinimalPlugins,
        FileSourcePlugin,
        asset_plugin(),
        ScenePlugin,
        EnginePlugin,
    ));
    app.world_mut().resource_mut::<RenderControl>().interactive = false;
    app.finish();
    app.cleanup();
    app
}

fn packed(scene: &SceneDescription) -> (App, RenderScene) {
    let mut app = app();
    spawn::spawn_fresh(app.world_mut(), &scene.clone().into());
    app.update();
    let packed = app.world().resource::<PackedScene>().scene.clone();
    (app, packed.expect("a scene that was packed"))
}

#[test]
fn instances_show_the_group_as_if_its_shapes_were_written_there() {
    let count = 6;
    let instances: String = (0..count).map(instance).collect();
    // One of them before the group it refers to.
    let grouped = clean(&format!("{}{GROUP}{}<shape type='disk'/>", instance(count), instances));
    assert_eq!((grouped.groups.len(), grouped.shapes.len()), (1, count + 5));
    let members = [
        "<shape type='sphere'><float name='radius' value='0.5'/><ref id='red'/>",
        "<shape type='cylinder'><point name='p0' value='0,0.2,0'/><point name='p1' value='1,0.2,0'/><float name='radius' value='0.3'/>
           <ref id='mirror'/>",
        "<shape type='cube'>",
    ];
    let mut flat = "<bsdf type='diffuse' id='red'><rgb name='reflectance' value='0.8,0.1,0.1'/></bsdf><bsdf type='conductor' id='mirror'/>".to_owned();
    for i in 0..=count {
        for (m, member) in members.iter().enumerate() {
            let inner = if m == 2 {
                "<scale value='0.2'/><translate y='-1'/>"
            } else {
                ""
            };
            let place = place(i).replace("<rotate", &format!("{inner}<rotate"));
            flat += &format!("{member}{place}</shape>");
        }
    }
    let flat = clean(&format!("{flat}<shape type='disk'/>"));

    let (_app, grouped) = packed(&grouped);
    let (_app, flat) = packed(&flat);
    assert_eq!(grouped.geometry.placements().len(), count + 1);
    assert_eq!(grouped.geometry.triangles(), flat.geometry.triangles());
    let mut hits = 0;
    for i in 0..4000 {
        // A lattice of rays through the row of instances, from above and slanted.
        let at = Vec3::new(0.02 * (i % 1000) as f32 - 1.5, 6.0, 0.15 * (i / 1000) as f32 - 0.4);
        let ray = Ray::new(at, Vec3::new(0.05, -1.0, 0.02));
        match (grouped.geometry.intersect(&ray), flat.geometry.intersect(&ray)) {
            (Some(hit), Some(expected)) => {
                // Rounding of coordinates up to 20, a few times; more at grazing rays, hence not tighter.
                assert!((hit.t - expected.t).abs() < 1e-3, "{hit:?} {expected:?}");
                let material = |scene: &RenderScene, hit| scene.slot(hit).material;
                assert_eq!(material(&grouped, &hit), material(&flat, &expected));
                hits += 1;
            }
            (hit, expected) => assert_eq!(hit.is_some(), expected.is_some()),
        }
    }
    assert!(hits > 1000, "{hits}");
}

#[test]
fn very_many_instances_are_one_thing_and_stay_as_they_were_written() {
    let count = 3000;
    let instances: String = (0..count).map(instance).collect();
    let body = format!("{GROUP}{instances}<shape type='disk'/>{}", instance(7));
    let scene = clean(&body);
    let crowd = &scene.shapes[3];
    assert_eq!(crowd.placements.as_ref().map(|many| many.places.len()), Some(count));
    // Members, crowd, disk and the one on its own.
    assert_eq!(scene.shapes.len(), 6);

    let (mut app, packed) = packed(&scene);
    assert_eq!(packed.geometry.placements().len(), count + 1);
    let packed = app.world().resource::<PackedScene>();
    assert_eq!(packed.entity_of_instance.len(), count + 2);
    assert_eq!(packed.entity_of_instance[1], packed.entity_of_instance[count]);
    assert_ne!(packed.entity_of_instance[1], packed.entity_of_instance[count + 1]);

    // Written back and read again nothing is different.
    let gathered = write::gather::describe(app.world_mut());
    let written = to_document(&gathered, Path::new("/tmp/scene.xml"));
    assert_eq!(
        written.root.children.len(),
        scene.remains.origin.as_ref().unwrap().unpacked().root.children.len()
    );
    let text = document::to_xml(&written).unwrap();
    let mut again = document::parse_str(&*text, Path::new("/tmp/scene.xml"), &[]);
    let again = read(&mut again);
    assert_eq!(again.shapes.len(), scene.shapes.len());
    let (a, b) = (&again.shapes[3].placements, &crowd.placements);
    assert_eq!(a.as_ref().map(|many| &many.places), b.as_ref().map(|many| &many.places));
}

#[test]
fn members_and_instances_that_were_edited_are_saved_where_they_stand() {
    let mut scene = clean(&format!("{GROUP}{}", instance(1)));
    let cube = scene
        .shapes
        .iter()
        .position(|shape| shape.shape.kind == ShapeKind::Cube)
        .unwrap();
    scene.shapes[cube].to_world = Affine3A::from_translation(Vec3::new(5.0, 6.0, 7.0));
    let placed = scene
        .shapes
        .iter()
        .position(|shape| shape.shape.kind == ShapeKind::Instance)
        .unwrap();
    scene.shapes[placed].to_world = Affine3A::from_translation(Vec3::new(-3.0, 0.0, 2.0));
    let written = to_document(&scene, Path::new("/tmp/scene.xml"));
    let mut again = document::parse_str(document::to_xml(&written).unwrap(), Path::new("/tmp/scene.xml"), &[]);
    let again = read(&mut again);
    assert!(
        again.shapes[cube]
            .to_world
            .abs_diff_eq(scene.shapes[cube].to_world, 1e-6)
    );
    assert!(
        again.shapes[placed]
            .to_world
            .abs_diff_eq(scene.shapes[placed].to_world, 1e-6)
    );
    assert_eq!(again.shapes[placed].instance_of, Some(0));
    let of_group = again.shapes.iter().filter(|shape| shape.member_of == Some(0));
    assert_eq!(of_group.count(), 3);
}

#[test]
fn what_groups_cannot_hold_is_reported() {
    let (scene, messages) = read_scene(
        "<shape type='shapegroup' id='g'><shape type='sphere'><emitter type='area'/></shape>
           <shape type='shapegroup'/><shape type='instance'><ref id='g'/></shape></shape>
         <shape type='sphere' id='ball'/><shape type='instance'><ref id='ball'/></shape><shape type='instance'/>
         <shape type='instance'><ref id='g'/><bsdf type='diffuse'/></shape>",
    );
    let expected = [
        "a shape of a shapegroup cannot be an emitter",
        "shape `shapegroup` cannot be part of a shapegroup",
        "shape `instance` cannot be part of a shapegroup",
        "shape `instance` needs a reference to one shapegroup: it is left out",
        "shape `instance` needs a reference to one shapegroup: it is left out",
    ];
    for text in expected {
        assert!(messages.iter().any(|message| message == text), "{text}: {messages:#?}");
    }
    assert!(
        messages.len() > expected.len(),
        "the bsdf of an instance is mentioned: {messages:#?}"
    );
    let kinds: Vec<_> = scene
        .shapes
        .iter()
        .map(|shape| (&shape.shape.kind, shape.area_light.clone()))
        .collect();
    let ball = ShapeKind::Sphere {
        center: Vec3::ZERO,
        radius: 1.0,
    };
    assert_eq!(kinds, [(&ball, None), (&ball, None), (&ShapeKind::Instance, None)]);
}

/// A file of serialized shapes, each one triangle of this size.
fn serialized(sizes: &[f32]) -> Vec<u8> {
    let mut bytes = Vec::new();
    let mut table = Vec::new();
    for &size in sizes {
        table.extend((bytes.len() as u64).to_le_bytes());
        bytes.extend([0x1c, 4, 4, 0]);
        let mut content = 0x1000u32.to_le_bytes().to_vec();
        content.push(0);
        content.extend(3u64.to_le_bytes());
        content.extend(1u64.to_le_bytes());
        for number in [0.0, 0.0, 0.0, size, 0.0, 0.0, 0.0, size, 0.0] {
            content.extend(f32::to_le_bytes(number));
        }
        content.extend([0, 1, 2].map(u32::to_le_bytes).concat());
        let mut packer = ZlibEncoder::new(&mut bytes, Compression::default());
        packer.write_all(&content).unwrap();
        packer.finish().unwrap();
    }
    bytes.extend(table);
    bytes.extend((sizes.len() as u32).to_le_bytes());
    bytes
}

/// Opens a scene of shapes with these properties, all of them from `shapes.serialized`.
fn open_serialized(folder: &Path, shapes: &[&str]) -> App {
    let shape = |index: &&str| {
        format!("<shape type='serialized'><string name='filename' value='shapes.serialized'/>{index}</shape>")
    };
    let body: String = shapes.iter().map(shape).collect();
    let text = format!("<scene version='3.0.0'><sensor type='perspective'/>{body}</scene>");
    std::fs::write(folder.join("scene.xml"), text).unwrap();
    let mut app = app();
    app.world_mut().write_message(OpenScene {
        path: folder.join("scene.xml"),
        defines: Vec::new(),
        ..OpenScene::default()
    });
    update_until(&mut app, |app| app.world().resource::<SceneStatus>().is_complete());
    app.update();
    app
}

fn update_until(app: &mut App, condition: impl Fn(&App) -> bool) {
    let deadline = Instant::now() + Duration::from_secs(600);
    while !condition(app) {
        app.update();
        assert!(Instant::now() < deadline, "{:?}", app.world().resource::<SceneStatus>());
        std::thread::sleep(Duration::from_millis(5));
    }
}

/// Of each shape that is there.
fn widths(app: &App) -> Vec<f32> {
    let scene = app.world().resource::<PackedScene>().scene.clone().unwrap();
    let instances = scene.geometry.instances();
    instances.iter().map(|one| one.world_bounds().extent().x).collect()
}

#[test]
fn every_shape_of_a_serialized_file_can_be_asked_for() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("shapes.serialized"), serialized(&[1.0, 2.0, 3.0])).unwrap();
    let shapes = [
        "",
        "<integer name='shape_index' value='2'/>",
        "<integer name='shape_index' value='7'/>",
    ];
    let app = open_serialized(folder.path(), &shapes);
    let status = app.world().resource::<SceneStatus>();
    let errors: Vec<&str> = status.mesh_errors.iter().map(|error| error.message.as_str()).collect();
    let text = std::fs::read_to_string(folder.path().join("scene.xml")).unwrap();
    let place = format!("scene.xml:1:{}: ", 1 + text.find(shapes[2]).unwrap());
    assert!(
        matches!(errors[..], [one] if one.contains(&place) && one.ends_with("there is no shape 7: the file has 3")),
        "{errors:?}"
    );
    let widths = widths(&app);
    // The bounds are a little wider than the triangles.
    assert!(
        matches!(widths[..], [a, b] if (a - 1.0).abs() < 1e-4 && (b - 3.0).abs() < 1e-4),
        "{widths:?}"
    );
}

/// The file's asset stays; what is asked of it changes.
#[test]
fn another_shape_of_a_serialized_file_can_be_asked_for_later() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("shapes.serialized"), serialized(&[1.0, 2.0])).unwrap();
    let [second, missing] = [1, 7].map(|index| format!("<integer name='shape_index' value='{index}'/>"));
    let mut app = open_serialized(folder.path(), &[&missing]);
    let errors = |app: &App| app.world().resource::<SceneStatus>().mesh_errors.len();
    assert_eq!((errors(&app), widths(&app).len()), (1, 0));
    let text = std::fs::read_to_string(folder.path().join("scene.xml")).unwrap();
    std::fs::write(folder.path().join("scene.xml"), text.replace(&missing, &second)).unwrap();
    update_until(&mut app, |app| errors(app) == 0 && widths(app).len() == 1);
    std::fs::write(folder.path().join("scene.xml"), text).unwrap();
    update_until(&mut app, |app| errors(app) == 1 && widths(app).is_empty());
}

#[test]
fn a_serialized_file_whose_first_shape_nobody_uses_is_read_again() {
    let folder = tempfile::tempdir().unwrap();
    let write = |second: f32| {
        std::fs::write(folder.path().join("shapes.serialized"), serialized(&[1.0, second])).unwrap();
    };
    write(2.0);
    let mut app = open_serialized(folder.path(), &["<integer name='shape_index' value='1'/>"]);
    let is_about = |app: &App, expected: f32| matches!(widths(app)[..], [width] if (width - expected).abs() < 1e-4);
    assert!(is_about(&app, 2.0), "{:?}", widths(&app));
    write(5.0);
    update_until(&mut app, |app| is_about(app, 5.0));
}

/// What became of a scene file: the picture, the messages with the lines that they speak of, how many entities know
/// what the file said of them, and the length of the texts that are kept.
fn rendered(path: &Path, make: fn(OpenScene, Option<i32>) -> App) -> (Vec<Rgb>, String, usize, usize) {
    let open = OpenScene {
        path: path.to_owned(),
        ..OpenScene::default()
    };
    let mut app = make(open, Some(1));
    app.world_mut().resource_mut::<RenderControl>().film_size_override = Some(UVec2::new(24, 16));
    let limits = Limits {
        samples: Some(2),
        ..Limits::default()
    };
    render_to_completion(&mut app, &limits, |_| {}).expect("a picture");
    let authored = app.world_mut().query::<&Authored>().iter(app.world()).count();
    let status = app.world().resource::<SceneStatus>();
    let kept = status.diagnostics.sources.iter().map(|source| source.text.len()).sum();
    let messages = status.all_diagnostics().render(false);
    let picture = app.world().resource::<RenderFilm>().film.radiance();
    (picture, messages, authored, kept)
}

#[test]
fn a_scene_that_is_only_rendered_keeps_nothing_of_its_file_but_what_messages_need() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let path = folder.path().join("scene.xml");
    let camera = "<sensor type='perspective'><transform name='to_world'><lookat origin='9,6,-12' target='9,0,9' up='0,1,0'/></transform></sensor>";
    let instances: String = (0..2000).map(instance).collect();
    let texture = "<shape type='sphere'><bsdf type='diffuse'><texture type='bitmap' name='reflectance'><string name='filename' value='gone.png'/></texture></bsdf></shape>";
    for (what, more, is_clean) in [
        (
            "nothing to say",
            "<shape type='disk'><bsdf type='plastic'/></shape>",
            true,
        ),
        (
            "a warning",
            "<shape type='disk'><float name='unknown' value='1'/></shape>",
            false,
        ),
        ("a missing picture", texture, false),
    ] {
        let before = format!("<scene version='3.0.0'>{camera}<emitter type='constant'/>{GROUP}{more}");
        let text = format!("{before}\n{instances}</scene>");
        std::fs::write(&path, &text).expect("writable");
        let (picture, messages, authored, kept) = rendered(&path, headless);
        assert!(authored > 5 && kept == text.len(), "{what}: {authored} {kept}");
        let alone = rendered(&path, render_only);
        assert_eq!((&alone.0, &alone.1), (&picture, &messages), "{what}");
        assert_eq!(messages.is_empty(), is_clean, "{what}: {messages}");
        // Of the text the lines up to the last place that is spoken of, here the disk's or the picture's.
        let needed = if is_clean { 0 } else { before.len() };
        assert_eq!((alone.2, alone.3), (0, needed), "{what}");
    }
}
