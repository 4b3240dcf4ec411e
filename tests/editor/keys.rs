//! Key frames in the editor: keys are set, moved, played, undone and saved, and the file says what was shown.

use bevy::prelude::*;
use sunroom::app::editor::automation::script::parse::{self, Step};
use sunroom::app::editor::command::SettingsEdit;
use sunroom::app::editor::commands::apply;
use sunroom::app::editor::commands::bare_world::bare_world;
use sunroom::app::editor::session::history::History;
use sunroom::app::editor::session::requests::Requests;
use sunroom::app::editor::session::toasts::Toasts;
use sunroom::document::{self, parse_str};
use sunroom::layer::{Layer, Layers};
use sunroom::scene::write::{gather, save, to_document};
use sunroom::scene::*;

/// A step of its own; the error in words.
fn say(world: &mut World, line: &str) -> Result<(), String> {
    world.resource_mut::<Requests>().interaction += 1;
    match parse::line(world, line) {
        Ok(Some(Step::Do(command))) => apply(world, command).map_err(|error| error.to_string()),
        Ok(other) => panic!("{line}: {other:?}"),
        Err(error) => Err(error.to_string()),
    }
}

#[track_caller]
fn do_all(world: &mut World, lines: &[&str]) {
    for line in lines {
        assert_eq!(say(world, line), Ok(()), "{line}");
    }
}

fn find(world: &mut World, name: &str) -> Entity {
    let mut names = world.query::<(Entity, &Name)>();
    let found = names.iter(world).find(|(_, known)| known.as_str() == name);
    found.map(|(entity, _)| entity).expect("a thing of that name")
}

fn place(world: &mut World, name: &str) -> Vec3 {
    let thing = find(world, name);
    let middle = world.get::<Shape>(thing).map_or(Vec3::ZERO, Shape::middle);
    world.get::<ToWorld>(thing).expect("a place").0.transform_point3(middle)
}

fn radius(world: &mut World, name: &str) -> f32 {
    let thing = find(world, name);
    match world.get::<Shape>(thing).expect("a shape").kind {
        ShapeKind::Sphere { radius, .. } => radius,
        _ => panic!("no sphere"),
    }
}

/// A scene file that is open in the editor.
fn opened(text: &str) -> (tempfile::TempDir, World) {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("scene.xml");
    std::fs::write(&path, text).expect("a file");
    let mut document = document::load(&path, &[]).expect("it can be read");
    let scene = read::read(&mut document);
    assert!(!document.diagnostics.has_errors(), "{:?}", document.diagnostics.list);
    let mut world = bare_world();
    spawn::spawn_fresh(&mut world, &scene.into());
    world.resource_mut::<SceneStatus>().path = Some(path);
    (folder, world)
}

/// The scenes that a file describes and that the world holds are the same at all of these times.
#[track_caller]
fn assert_file_shows_the_same(world: &mut World, times: &[f64]) {
    let path = world.resource::<SceneStatus>().path.clone().expect("a file");
    let document = document::load(&path, &[]).expect("it can be read");
    for &time in times {
        show_moment(world, time);
        let (here, there) = (gather::describe(world), read::read(&mut document.at(time)));
        let shapes = |scene: &SceneDescription| {
            let shapes = scene.shapes.iter();
            shapes.map(|it| (it.shape.clone(), it.to_world)).collect::<Vec<_>>()
        };
        assert_eq!(shapes(&here), shapes(&there), "{time}");
        let materials = |scene: &SceneDescription| {
            let materials = scene.materials.iter();
            materials.map(|it| it.material.clone()).collect::<Vec<_>>()
        };
        assert_eq!(materials(&here), materials(&there), "{time}");
        let lights = |scene: &SceneDescription| {
            let lights = scene.emitters.iter();
            lights.map(|it| (it.emitter.clone(), it.to_world)).collect::<Vec<_>>()
        };
        assert_eq!(lights(&here), lights(&there), "{time}");
        let cameras = |scene: &SceneDescription| {
            let cameras = scene.sensors.iter();
            cameras.map(|it| (it.sensor, it.film, it.to_world)).collect::<Vec<_>>()
        };
        assert_eq!(cameras(&here), cameras(&there), "{time}");
    }
}

#[test]
fn two_keys_make_a_thing_move() {
    let mut world = bare_world();
    do_all(
        &mut world,
        &["add sphere name=ball at=0,-1,0 size=1", "key ball", "time 2"],
    );
    do_all(&mut world, &["move ball 4,0,0", "time 0.5"]);
    assert_eq!(place(&mut world, "ball"), Vec3::X);
    do_all(&mut world, &["interpolate ball to_world step", "time 1.999"]);
    assert_eq!(place(&mut world, "ball"), Vec3::ZERO);
    do_all(&mut world, &["move-key ball to_world 2 1"]);
    assert_eq!(place(&mut world, "ball"), 4.0 * Vec3::X);
    // A removed key gives way to the others; the last one leaves the thing where it is.
    do_all(&mut world, &["time 0", "unkey ball"]);
    assert_eq!(place(&mut world, "ball"), 4.0 * Vec3::X);
    do_all(&mut world, &["stand-still ball"]);
    let ball = find(&mut world, "ball");
    assert!(world.get::<Keys>(ball).is_none());
    assert_eq!(place(&mut world, "ball"), 4.0 * Vec3::X);
}

#[test]
fn an_edit_of_a_moving_value_is_of_its_time_alone() {
    let mut world = bare_world();
    do_all(
        &mut world,
        &["add sphere name=ball at=0,-1,0 size=1", "key ball radius"],
    );
    do_all(&mut world, &["time 1", "set ball radius 3", "move ball 0,1,0"]);
    for (time, expected) in [(0.0, 1.0), (0.5, 2.0), (1.0, 3.0), (7.0, 3.0)] {
        show_moment(&mut world, time);
        assert_eq!(radius(&mut world, "ball"), expected, "{time}");
        // A value without keys is the same at all times.
        assert_eq!(place(&mut world, "ball"), Vec3::Y, "{time}");
    }
}

#[test]
fn undo_and_redo_at_other_times_leave_the_same_keys() {
    let mut world = bare_world();
    do_all(&mut world, &["add sphere name=ball at=0,-1,0 size=1", "key ball"]);
    do_all(
        &mut world,
        &["time 2", "move ball 4,0,0", "time 1", "move ball 0,2,0", "time 0.5"],
    );
    let shown = place(&mut world, "ball");
    assert_eq!(shown, Vec3::new(1.0, 1.0, 0.0));
    do_all(&mut world, &["undo"]);
    assert_eq!(place(&mut world, "ball"), Vec3::X);
    do_all(&mut world, &["time 1.5", "undo"]);
    assert_eq!(place(&mut world, "ball"), Vec3::ZERO);
    do_all(&mut world, &["redo", "redo", "time 0.5"]);
    assert_eq!(place(&mut world, "ball"), shown);
    do_all(&mut world, &["go-to 1"]);
    let ball = find(&mut world, "ball");
    assert!(world.get::<Keys>(ball).is_none());
    let labels = world.resource::<History>().len();
    assert_eq!(labels, (1, 3));
}

/// Things of every kind that move, in words that the editor would not choose.
const MOVING: &str = r#"<scene version="3.0.0">
    <sensor type="thinlens" id="eye">
        <animation name="to_world"><transform time="0"><lookat origin="0, 1, 5" target="0, 1, 0" up="0, 1, 0"/></transform>
            <transform time="2"><lookat origin="3, 1, 4" target="0, 2, 0" up="0, 1, 0"/></transform></animation>
        <animation name="focal_length"><string time="0" value="35mm"/><string time="1" value="70mm"/></animation>
        <float name="aperture_radius" value="0.1"/>
        <film type="hdrfilm"><integer name="width" value="32"/><integer name="height" value="32"/></film>
    </sensor>
    <texture type="checkerboard" id="board"><animation name="to_uv"><transform time="0"><scale x="1" y="1"/></transform>
        <transform time="1"><scale x="4" y="4"/></transform></animation></texture>
    <bsdf type="diffuse" id="tiles"><ref id="board" name="reflectance"/></bsdf>
    <bsdf type="twosided" id="paint"><bsdf type="diffuse">
        <animation name="reflectance"><spectrum time="0" value="0.1"/><spectrum time="2" value="0.9"/></animation></bsdf></bsdf>
    <shape type="sphere" id="ball"><ref id="paint"/>
        <animation name="to_world" interpolation="ease"><transform time="0"><rotate y="1" angle="0"/></transform>
            <transform time="2"><rotate y="1" angle="720"/></transform></animation></shape>
    <shape type="rectangle" id="lamp"><ref id="tiles"/>
        <emitter type="area"><animation name="radiance"><rgb time="0" value="1, 1, 1"/><rgb time="1" value="5, 1, 0"/></animation></emitter></shape>
    <shape type="shapegroup" id="grove"><shape type="cube"/></shape>
    <shape type="instance" id="tree"><ref id="grove"/>
        <animation name="to_world"><transform time="0"><translate x="1"/></transform><transform time="1"><translate x="2" y="1"/></transform></animation>
    </shape>
    <emitter type="point" id="spark"><rgb name="intensity" value="1, 1, 1"/>
        <animation name="position"><point time="0" value="0, 0, 0"/><point time="1" value="0, 3, 0"/></animation></emitter>
</scene>"#;

#[test]
fn whatever_moves_in_a_file_moves_in_the_window() {
    let (_folder, mut world) = opened(MOVING);
    assert_file_shows_the_same(&mut world, &[0.0, 0.3, 1.0, 1.7, 2.5, -1.0, 0.3, 0.0]);
}

#[test]
fn what_was_shown_is_what_the_saved_file_shows() {
    let (_folder, mut world) = opened(MOVING);
    let path = world.resource::<SceneStatus>().path.clone().expect("a file");
    do_all(&mut world, &["time 0.7"]);
    save(&mut world, &path).expect("it can be written");
    assert_eq!(
        std::fs::read_to_string(&path).expect("a file"),
        MOVING,
        "nothing was edited"
    );
    do_all(
        &mut world,
        &[
            "move ball 0.3,0.2,0.1",
            "rotate tree 0,1,0 30",
            "time 1.3",
            "set lamp radiance 2,3,4",
            "set eye aperture_radius 0.3",
        ],
    );
    do_all(
        &mut world,
        &[
            "set spark position 1,2,3",
            "key spark intensity",
            "time 1.9",
            "set spark intensity 7",
        ],
    );
    do_all(
        &mut world,
        &[
            "add cube name=box",
            "key box",
            "time 0.1",
            "move box 1,1,1",
            "select ball",
            "duplicate",
        ],
    );
    do_all(&mut world, &["time 0.9"]);
    let times = [0.0, 0.1, 0.3, 0.7, 0.9, 1.3, 1.9, 2.0, 3.0];
    let shown: Vec<Vec3> = times
        .iter()
        .map(|time| {
            show_moment(&mut world, *time);
            place(&mut world, "ball")
        })
        .collect();
    save(&mut world, &path).expect("it can be written");
    assert_file_shows_the_same(&mut world, &times);
    for (time, shown) in times.iter().zip(shown) {
        show_moment(&mut world, *time);
        assert_eq!(place(&mut world, "ball"), shown, "{time}");
    }
}

#[test]
fn a_whole_turn_stays_one_when_one_of_its_keys_is_moved() {
    let (_folder, mut world) = opened(MOVING);
    do_all(&mut world, &["time 0", "move ball 0,5,0", "time 0"]);
    let ball = find(&mut world, "ball");
    let up = |world: &World| world.get::<ToWorld>(ball).expect("a place").0;
    // Halfway in time is halfway of two whole turns: turned by 360 degrees, and half way down.
    show_moment(&mut world, 1.0);
    let there = up(&world);
    assert!((there.translation.y - 2.5).abs() < 1e-5, "{there:?}");
    assert!(there.matrix3.x_axis.x > 0.999, "{there:?}");
    show_moment(&mut world, 0.5);
    let early = up(&world);
    assert!(early.matrix3.x_axis.x < 0.99, "it turns: {early:?}");
    do_all(&mut world, &["time 2", "rotate ball 1,0,0 90"]);
    show_moment(&mut world, 1.0);
    assert!(up(&world).matrix3.x_axis.x > 0.999, "{:?}", up(&world));
}

#[test]
fn a_copy_moves_along_beside_its_original() {
    let mut world = bare_world();
    do_all(
        &mut world,
        &[
            "add sphere name=ball at=0,-1,0 size=1",
            "key ball",
            "time 1",
            "move ball 0,3,0",
        ],
    );
    do_all(&mut world, &["select ball", "series 2 along 5,0,0"]);
    for (time, height) in [(0.0, 0.0), (1.0, 3.0)] {
        show_moment(&mut world, time);
        assert_eq!(place(&mut world, "ball"), Vec3::new(0.0, height, 0.0));
        assert_eq!(place(&mut world, "ball-2"), Vec3::new(5.0, height, 0.0));
    }
}

#[test]
fn an_edit_of_the_file_and_an_edit_of_keys_are_merged_at_the_time_that_is_shown() {
    let (_folder, mut world) = opened(MOVING);
    do_all(&mut world, &["time 1", "move tree 0,2,0"]);
    // Another program makes the ball turn once, about what is above it, and lets the spark fly further.
    let text = MOVING
        .replace("angle=\"720\"", "angle=\"360\"")
        .replace("0, 3, 0", "0, 9, 0");
    let path = world.resource::<SceneStatus>().path.clone().expect("a file");
    std::fs::write(&path, &text).expect("a file");
    write::save_with(&mut world, &path, write::OnChange::TakeIn).expect("it can be written");
    assert_eq!(place(&mut world, "spark"), 9.0 * Vec3::Y);
    assert_eq!(place(&mut world, "tree"), Vec3::new(2.0, 3.0, 0.0));
    assert_file_shows_the_same(&mut world, &[0.0, 0.5, 1.0, 2.0]);
    show_moment(&mut world, 0.0);
    assert_eq!(place(&mut world, "tree"), Vec3::X);
    show_moment(&mut world, 1.0);
    let ball = find(&mut world, "ball");
    let x = world.get::<ToWorld>(ball).expect("a place").0.matrix3.x_axis;
    assert!(x.x < -0.999, "half a turn: {x:?}");
}

#[test]
fn keys_of_file_names_follow_a_scene_that_is_saved_elsewhere() {
    let folder = tempfile::tempdir().expect("a folder");
    let triangle = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";
    for name in ["one.obj", "two.obj"] {
        std::fs::write(folder.path().join(name), triangle).expect("a file");
    }
    let path = folder.path().join("scene.xml");
    let text = r#"<scene version="3.0.0"><sensor type="perspective"/><shape type="obj" id="mesh"><animation name="filename">
        <string time="0" value="one.obj"/><string time="1" value="two.obj"/></animation></shape></scene>"#;
    std::fs::write(&path, text).expect("a file");
    let mut document = document::load(&path, &[]).expect("it can be read");
    let scene = read::read(&mut document);
    let mut world = bare_world();
    spawn::spawn_fresh(&mut world, &scene.into());
    let below = folder.path().join("below");
    std::fs::create_dir(&below).expect("a folder");
    let target = below.join("copy.xml");
    save(&mut world, &target).expect("it can be written");
    let text = std::fs::read_to_string(&target).expect("a file");
    assert!(text.contains("../one.obj") && text.contains("../two.obj"), "{text}");
}

#[test]
fn a_turntable_is_one_step_that_goes_around_once() {
    let (_folder, mut world) = opened(MOVING);
    do_all(
        &mut world,
        &["timeline 10 0 19", "select lamp", "stand-still eye to_world"],
    );
    let before = place(&mut world, "eye");
    do_all(&mut world, &["add-turntable"]);
    assert!((place(&mut world, "eye") - before).length() < 1e-4);
    // The lamp is at the origin: after half of the twenty frames the camera is at the other side.
    do_all(&mut world, &["frame 10"]);
    let there = place(&mut world, "eye");
    assert!(
        (there - Vec3::new(-before.x, before.y, -before.z)).length() < 1e-3,
        "{there:?}"
    );
    do_all(&mut world, &["undo"]);
    assert!((place(&mut world, "eye") - before).length() < 1e-4);
}

#[test]
fn a_key_of_the_place_of_a_light_leaves_it_where_it_is() {
    let (_folder, mut world) = opened(
        r#"<scene version="3.0.0"><sensor type="perspective"/>
    <emitter type="point" id="spark"><point name="position" x="1" y="2" z="3"/></emitter>
    <emitter type="directional" id="sun"><vector name="direction" x="1" y="-1" z="0"/></emitter>
</scene>"#,
    );
    let sun = find(&mut world, "sun");
    let before = *world.get::<ToWorld>(sun).expect("a direction");
    do_all(&mut world, &["key spark to_world", "key sun to_world"]);
    assert_eq!(place(&mut world, "spark"), Vec3::new(1.0, 2.0, 3.0));
    assert_eq!(*world.get::<ToWorld>(sun).expect("a direction"), before);
    do_all(&mut world, &["time 1", "move spark 0,2,0", "time 0.5"]);
    assert_eq!(place(&mut world, "spark"), Vec3::new(1.0, 3.0, 3.0));
    let path = world.resource::<SceneStatus>().path.clone().expect("a file");
    save(&mut world, &path).expect("it can be written");
    let text = std::fs::read_to_string(&path).expect("a file");
    assert!(
        text.contains("<animation name=\"position\"") && text.contains("<animation name=\"direction\""),
        "{text}"
    );
    assert!(!text.contains("to_world"), "{text}");
    assert_file_shows_the_same(&mut world, &[0.0, 0.5, 1.0]);
}

#[test]
fn keys_between_frames_are_removed_where_they_are() {
    let mut world = bare_world();
    do_all(
        &mut world,
        &[
            "add sphere name=ball at=0,-1,0 size=1",
            "key ball",
            "time 0.041667",
            "key ball",
        ],
    );
    // Six decimals are not the time of the first frame, 1 / 24 s, in single precision.
    do_all(&mut world, &["time 0", "select ball", "next-key", "unkey ball"]);
    let ball = find(&mut world, "ball");
    let times = |world: &World| {
        let keys = world.get::<Keys>(ball).expect("keys");
        keys.track(&KeyPath::new("to_world")).expect("a track").keys.len()
    };
    assert_eq!(times(&world), 1);
    // The key at the first frame is shown as that frame.
    do_all(&mut world, &["frame 1", "key ball", "time 0", "next-key"]);
    assert_eq!(shown_time(&world), 1.0 / 24.0);
}

#[test]
fn a_group_that_has_a_key_takes_its_members_along() {
    let mut world = bare_world();
    do_all(
        &mut world,
        &[
            "add sphere name=left at=0,-1,0 size=1",
            "add sphere name=right at=4,-1,0 size=1",
            "select left right",
            "group",
            "key group/",
            "time 1",
            "move group/ 0,2,0",
            "time 0.5",
        ],
    );
    assert_eq!(place(&mut world, "group/left"), Vec3::Y);
    assert_eq!(place(&mut world, "group/right"), Vec3::new(4.0, 1.0, 0.0));
    do_all(&mut world, &["time 0"]);
    assert_eq!(place(&mut world, "group/left"), Vec3::ZERO);
    // So do all other edits of its keys.
    do_all(&mut world, &["move-key group/ to_world 1 2", "time 1"]);
    assert_eq!(place(&mut world, "group/right"), Vec3::new(4.0, 1.0, 0.0));
    do_all(&mut world, &["interpolate group/ to_world step"]);
    assert_eq!(place(&mut world, "group/right"), 4.0 * Vec3::X);
    do_all(
        &mut world,
        &["undo", "time 0", "select group/", "unkey group/", "time 1"],
    );
    for thing in ["group/", "group/left", "group/right"] {
        let thing = find(&mut world, thing);
        let keys = world.get::<Keys>(thing).expect("keys");
        assert!(keys.tracks().all(|(_, track)| track.span() == (2.0, 2.0)));
    }
    assert_eq!(place(&mut world, "group/left"), 2.0 * Vec3::Y);
    do_all(&mut world, &["stand-still group/"]);
    for thing in ["group/", "group/left", "group/right"] {
        let thing = find(&mut world, thing);
        assert!(world.get::<Keys>(thing).is_none());
    }
    assert_eq!(place(&mut world, "group/right"), Vec3::new(4.0, 2.0, 0.0));
}

/// A camera and an integrator with layers around it, whose longest path is keyed.
const DEEPER: &str = "<scene version='3.0.0'>
  <integrator type='aov'>
    <string name='aovs' value='dd:depth'/>
    <integrator type='path'>
      <animation name='max_depth'><integer time='0' value='2'/><integer time='4' value='10'/></animation>
    </integrator>
  </integrator>
  <sensor type='perspective' id='eye'><animation name='focal_length'>
    <string time='0' value='50mm'/><string time='2' value='100mm'/>
  </animation></sensor>
</scene>";

#[test]
fn an_edit_of_a_keyed_setting_of_the_integrator_sets_a_key() {
    let (_folder, mut world) = opened(DEEPER);
    let depths = |world: &mut World| {
        [0.0, 1.0, 2.0, 4.0].map(|time| {
            show_moment(world, time);
            world.resource::<IntegratorSettings>().max_depth.expect("bounded")
        })
    };
    let change = |world: &mut World, edit: fn(&mut IntegratorSettings)| {
        let mut settings = *world.resource::<IntegratorSettings>();
        edit(&mut settings);
        world.resource_mut::<Requests>().interaction += 1;
        apply(world, SettingsEdit::SetIntegrator(settings)).expect("applied");
    };
    assert_eq!(depths(&mut world), [2, 4, 6, 10]);
    assert_eq!(animated_span(&mut world), Some((0.0, 4.0)));
    show_moment(&mut world, 2.0);
    change(&mut world, |settings| settings.max_depth = Some(20));
    assert_eq!(depths(&mut world), [2, 11, 20, 10]);
    // Other settings and layers leave the keys alone, also if the integrator around it goes or comes.
    change(&mut world, |settings| settings.rr_depth = 9);
    let layers = world.resource::<IntegratorSettings>().layers;
    change(&mut world, |settings| settings.layers = Layers::default());
    assert_eq!(depths(&mut world), [2, 11, 20, 10]);
    do_all(&mut world, &["undo", "undo", "time 1", "undo"]);
    assert_eq!(depths(&mut world), [2, 4, 6, 10]);
    do_all(&mut world, &["redo", "redo", "redo"]);
    assert_eq!(depths(&mut world), [2, 11, 20, 10]);
    let path = world.resource::<SceneStatus>().path.clone().expect("a file");
    save(&mut world, &path).expect("saved");
    let document = document::load(&path, &[]).expect("it can be read");
    let saved = [0.0, 1.0, 2.0, 4.0].map(|time| read::read(&mut document.at(time)).integrator);
    assert_eq!(saved.map(|it| it.max_depth), [2, 11, 20, 10].map(Some));
    assert_eq!(saved.map(|it| (it.rr_depth, it.layers)), [(9, Layers::default()); 4]);
    change(&mut world, |settings| settings.layers = Layers::of(&[Layer::Depth]));
    assert_eq!(world.resource::<IntegratorSettings>().layers, layers);
    assert_eq!(depths(&mut world), [2, 11, 20, 10]);
}

#[test]
fn keys_of_the_focal_length_become_those_of_the_field_of_view() {
    let (_folder, mut world) = opened(DEEPER);
    let eye = find(&mut world, "eye");
    let views = |world: &mut World| {
        [0.0, 1.0, 2.0, 3.0].map(|time| {
            show_moment(world, time);
            world.get::<Sensor>(eye).expect("a camera").fov
        })
    };
    let [normal, _, far, _] = views(&mut world);
    assert!(normal > 45.0 && far < 25.0, "{normal} {far}");
    assert_eq!(views(&mut world), [normal, normal, far, far], "backwards as well");
    do_all(&mut world, &["time 1", "set eye fov 70"]);
    let now = views(&mut world);
    for (found, expected) in now.into_iter().zip([normal, 70.0, far, far]) {
        assert!((found - expected).abs() < 1e-3, "{now:?}");
    }
    let path = world.resource::<SceneStatus>().path.clone().expect("a file");
    save(&mut world, &path).expect("saved");
    assert_file_shows_the_same(&mut world, &[0.0, 1.0, 2.0, 3.0]);
    let text = std::fs::read_to_string(&path).expect("a file");
    assert!(
        text.contains("name=\"fov\"") && !text.contains("focal_length"),
        "{text}"
    );
}

#[test]
fn keys_that_something_else_takes_the_place_of_are_told() {
    let (_folder, mut world) = opened(
        "<scene version='3.0.0'>
          <bsdf type='roughconductor' id='steel'>
            <animation name='alpha_u'><float time='0' value='0.1'/><float time='1' value='0.4'/></animation>
            <float name='alpha_v' value='0.2'/>
          </bsdf>
        </scene>",
    );
    do_all(&mut world, &["set steel alpha 0.3"]);
    let is_told = world
        .resource::<Toasts>()
        .texts()
        .any(|text| text.contains("`alpha_u`"));
    assert!(is_told);
    let steel = find(&mut world, "steel");
    assert!(world.get::<Keys>(steel).is_none());
    do_all(&mut world, &["undo"]);
    assert!(world.get::<Keys>(steel).is_some());
}

#[test]
fn what_cannot_have_keys_says_so() {
    let mut world = bare_world();
    do_all(
        &mut world,
        &[
            "add sphere name=ball at=0,-1,0 size=1",
            "material-of ball",
            "add sphere name=far",
            "key far",
        ],
    );
    let cases = [
        ("move-key far to_world 0 1e30", "there is no such time"),
        ("key ball colour", "\"colour\" cannot be edited: there is no such value"),
        ("unkey ball", "it has no keys"),
        ("move-key ball to_world 0 1", "it has no keys"),
        ("interpolate ball to_world wobbly", "no interpolation called \"wobbly\""),
        ("time soon", "expected"),
        ("timeline 24 5 4", "a last frame that is not before the first"),
        ("next-key", "There is no further key"),
    ];
    for (line, expected) in cases {
        let found = say(&mut world, line).expect_err(line);
        assert!(found.contains(expected), "{line}: {found}");
    }
    do_all(&mut world, &["stand-still far"]);
    let document = to_document(&gather::describe(&mut world), "/x.xml".as_ref());
    assert!(
        parse_str(document::to_xml(&document).expect("text"), "/x.xml".as_ref(), &[])
            .animated_span()
            .is_none()
    );
}

/// The text of the scene's file once it is saved.
fn saved(world: &mut World) -> String {
    let path = world.resource::<SceneStatus>().path.clone().expect("a file");
    save(world, &path).expect("it can be saved");
    std::fs::read_to_string(path).expect("a file")
}

#[test]
fn keys_leave_the_spelling_of_a_transform_as_it_was() {
    let text = r#"<scene version="3.0.0">
  <sensor type="perspective"/>
  <shape type="sphere" id="ball">
    <transform name="to_world"> <!-- where it is -->
      <scale x="0.5" y='0.50' z="0.5"/>
      <rotate y="1" angle="30.0"/>
      <translate x="1"  y="0.5"/>
    </transform>
  </shape>
</scene>
"#;
    let (_folder, mut world) = opened(text);
    do_all(&mut world, &["key ball", "time 1", "move ball 1,0,0"]);
    let key = |time: &str, x: &str| {
        format!(
            r#"
      <transform time="{time}"> <!-- where it is -->
        <scale x="0.5" y='0.50' z="0.5"/>
        <rotate y="1" angle="30.0"/>
        <translate x="{x}"  y="0.5"/>
      </transform>"#
        )
    };
    let animated = |keys: &[String]| {
        let (before, rest) = text.split_once("\n    <transform name").expect("a transform");
        let (_, after) = rest.split_once("</transform>").expect("its end");
        let keys = keys.concat();
        format!("{before}\n    <animation name=\"to_world\">{keys}\n    </animation>{after}")
    };
    assert_eq!(saved(&mut world), animated(&[key("0", "1"), key("1", "2")]));
    // A key between others, one that moves, and one that is removed.
    do_all(&mut world, &["time 0.5", "key ball"]);
    let three = [key("0", "1"), key("0.5", "1.5"), key("1", "2")];
    assert_eq!(saved(&mut world), animated(&three));
    do_all(&mut world, &["move-key ball to_world 0.5 3", "time 1", "unkey ball"]);
    assert_eq!(saved(&mut world), animated(&[key("0", "1"), key("3", "1.5")]));
    do_all(&mut world, &["time 0", "stand-still ball"]);
    assert_eq!(saved(&mut world), text);
}

#[test]
fn an_edited_key_leaves_the_others_and_their_remarks_as_they_were() {
    let text = r#"<scene version="3.0.0">
    <sensor type="perspective"/>
    <shape type="sphere" id="ball">
        <animation name="radius"   interpolation="ease">
            <!-- small -->
            <float time="0.0" value="1.0"/> <!-- first -->
            <float  value="2.0" time="1e0"/>
            <float time="2" value="3.0"/>
        </animation>
    </shape>
</scene>
"#;
    let (_folder, mut world) = opened(text);
    do_all(&mut world, &["time 1", "set ball radius 5"]);
    let edited = text.replace("value=\"2.0\"", "value=\"5\"");
    assert_eq!(saved(&mut world), edited);
    do_all(
        &mut world,
        &["time 0.25", "key ball radius", "interpolate ball radius step"],
    );
    let level = radius(&mut world, "ball");
    let first = "<float time=\"0.0\" value=\"1.0\"/> <!-- first -->\n";
    let further = format!("{first}            <float time=\"0.25\" value=\"{level}\"/>\n");
    let edited = edited.replace(first, &further).replace("\"ease\"", "\"step\"");
    assert_eq!(saved(&mut world), edited);
    assert_file_shows_the_same(&mut world, &[0.0, 0.3, 1.0, 3.0]);
}
