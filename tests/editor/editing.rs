//! Edits of a scene without a window: what is undone, redone and replayed.

use std::path::Path;
use std::sync::Arc;

use bevy::prelude::*;
use sunroom::app::editor::automation::monkey::Snapshot;
use sunroom::app::editor::automation::monkey::edits::{PART, names, random_edit};
use sunroom::app::editor::automation::monkey::random::Random;
use sunroom::app::editor::automation::script::parse::{self, Step};
use sunroom::app::editor::command::selection::Selection;
use sunroom::app::editor::command::{Command, FileCommand, MaterialEdit, OutlineEdit, SelectionCommand, ValueEdit};
use sunroom::app::editor::commands::apply;
use sunroom::app::editor::commands::bare_world::bare_world;
use sunroom::app::editor::session::history::History;
use sunroom::app::editor::session::requests::Requests;
use sunroom::engine::{LightGroup, RenderControl, RenderFilm};
use sunroom::layer::{Layer, Layers};
use sunroom::scene::write::{self, gather};
use sunroom::scene::{Material, *};

/// As the engine has them: every light in a layer of its own.
fn keep_lights_apart(world: &mut World) {
    let mut lights = world.query_filtered::<(&DocumentOrder, Entity), Or<(With<Emitter>, With<AreaLight>)>>();
    let mut lights: Vec<(DocumentOrder, Entity)> = lights.iter(world).map(|(order, light)| (*order, light)).collect();
    lights.sort();
    let groups = lights
        .into_iter()
        .map(|(_, light)| LightGroup { entities: vec![light] });
    world.resource_mut::<RenderFilm>().light_groups = groups.collect();
}

/// One line of a script; false if it could not be done.
pub(crate) fn say(world: &mut World, line: &str) -> bool {
    keep_lights_apart(world);
    match parse::line(world, line) {
        Ok(Some(Step::Do(command))) => apply(world, command).is_ok(),
        Err(_) => false,
        other => panic!("{line}: {other:?}"),
    }
}

/// Everything of the scene, free of entities: equal if and only if the scenes are.
fn state(world: &mut World) -> Snapshot {
    Snapshot::of(world)
}

/// Says what differs, for the whole would fill pages.
fn assert_same(one: &Snapshot, other: &Snapshot) {
    assert_eq!(one.difference(other), None);
}

/// The lines of a step, up to the first that cannot be done: the others were meant for what that one would have
/// selected.
pub(crate) fn say_all(world: &mut World, step: &[String]) -> bool {
    step.iter().all(|line| say(world, line))
}

#[test]
fn random_edits_with_undo_and_redo_are_as_a_replay_without() {
    let folder = tempfile::tempdir().expect("a folder");
    let file = folder.path().join("part.xml");
    std::fs::write(&file, PART).expect("a file");
    let mut world = bare_world();
    let mut random = Random::new(0x5eed_1234_9abc_def1);
    // What a replay would have to do, and what could be done again, each a step of the history.
    let (mut done, mut undone): (Vec<Vec<String>>, Vec<Vec<String>>) = (Vec::new(), Vec::new());
    let (mut refused, mut forgotten) = (0, 0);
    for number in 0..10_000 {
        match random.below(4) {
            0 if world.resource::<History>().len().0 > 0 => {
                assert!(say(&mut world, "undo"));
                undone.extend(done.pop());
            }
            1 if world.resource::<History>().len().1 > 0 => {
                assert!(say(&mut world, "redo"));
                done.extend(undone.pop());
            }
            _ => {
                let Some(step) = random_edit(&mut world, &mut random, &file) else {
                    continue;
                };
                world.resource_mut::<Requests>().interaction += 1;
                let before = world.resource::<History>().last_step();
                refused += usize::from(!say_all(&mut world, &step));
                // What changes nothing is no step.
                if world.resource::<History>().last_step() != before {
                    done.push(step);
                    undone.clear();
                }
            }
        }
        let known = world.resource::<History>().len();
        // The oldest of more than a thousand can be undone no more.
        forgotten = forgotten.max(done.len().saturating_sub(1000));
        assert_eq!(known.0, done.len() - forgotten, "step {number}");
        assert_eq!(known.1, undone.len(), "step {number}");
    }
    let edited = state(&mut world);

    let mut replayed = bare_world();
    for step in &done {
        replayed.resource_mut::<Requests>().interaction += 1;
        say_all(&mut replayed, step);
    }
    assert_same(&state(&mut replayed), &edited);

    let (steps, _) = world.resource::<History>().len();
    assert!(say(&mut world, "go-to 0"));
    assert_eq!(world.resource::<History>().len().0, 0);
    assert!(say(&mut world, &format!("go-to {steps}")));
    assert_same(&state(&mut world), &edited);
    println!(
        "{} steps in effect, {steps} in the history, {} things, {refused} refused",
        done.len(),
        edited.things()
    );
    // Names that several things have are refused, so the steps that took effect are counted.
    assert!(steps > 500 && edited.things() > 20 && done.len() > 1500);
}

#[test]
fn several_edits_of_one_drag_are_one_step() {
    let mut world = bare_world();
    say(&mut world, "add sphere at=0,0,0");
    let steps = |world: &World| world.resource::<History>().len().0;
    let before = state(&mut world);
    for x in 1..9 {
        assert!(say(&mut world, &format!("set sphere position {x},0,0")));
    }
    assert_eq!(steps(&world), 2);
    // Back to where it began: nothing has happened.
    let x = 0;
    assert!(say(&mut world, &format!("set sphere position {x},1,0")));
    assert_eq!(steps(&world), 1);
    assert_eq!(state(&mut world), before);
}

#[test]
fn materials_are_put_into_others_and_taken_out_again() {
    let mut world = bare_world();
    for line in ["add cube name=box", "material-of box", "make box plastic"] {
        assert!(say(&mut world, line), "{line}");
    }
    let before = state(&mut world);
    for wrapper in ["twosided", "blendbsdf", "mask", "bumpmap", "normalmap"] {
        assert!(say(&mut world, &format!("wrap box {wrapper}")), "{wrapper}");
        assert_ne!(state(&mut world), before, "{wrapper}");
        assert!(say(&mut world, "unwrap box first"), "{wrapper}");
        assert_same(&state(&mut world), &before);
    }
    assert!(say(&mut world, "wrap box blendbsdf") && say(&mut world, "unwrap box second"));
    assert_ne!(state(&mut world), before, "the second is a new one");
    for wrong in ["wrap box plastic", "unwrap box", "unwrap box third"] {
        assert!(!say(&mut world, wrong), "{wrong}");
    }
}

#[test]
fn the_history_knows_what_is_saved() {
    let mut world = bare_world();
    let is_saved = |world: &World| world.resource::<History>().is_saved();
    assert!(is_saved(&world));
    say(&mut world, "add sphere at=0,0,0");
    assert!(!is_saved(&world));
    world.resource_mut::<History>().note_saved();
    say(&mut world, "move sphere 1,0,0");
    assert!(!is_saved(&world));
    say(&mut world, "undo");
    assert!(is_saved(&world));
    say(&mut world, "undo");
    say(&mut world, "add cube at=0,0,0");
    // The state that was saved can never come back.
    for line in ["undo", "redo"] {
        say(&mut world, line);
        assert!(!is_saved(&world), "{line}");
    }
}

#[test]
fn lines_that_cannot_be_done_say_why() {
    let mut world = bare_world();
    say(&mut world, "add sphere at=0,0,0 name=ball");
    say(&mut world, "material-of ball");
    let cases = [
        ("move bal 1,0,0", "no thing called \"bal\"; did you mean `ball`"),
        ("moove ball 1,0,0", "did you mean `move`"),
        ("set ball radius -1", "expected"),
        ("set ball roughness 1", "there is no `roughness`, only position"),
        ("set ball radus 1", "there is no `radus`; did you mean `radius`?"),
        ("set ball reflectence 0.5", "did you mean `reflectance`?"),
        ("set ball reflectance 2", "within 0 to 1"),
        ("make ball difuse", "did you mean `diffuse`"),
        ("add teapot", "\"teapot\" cannot be added, only sphere, rectangle"),
        ("add cube size=-1", "expected more than 0, found -1"),
        (
            "add cube at=0,0,0 colour=red",
            "expected name=, at= or size=, found `colour=red`",
        ),
        ("limit-time -1", "expected more than 0, found -1"),
        ("limit-time 0", "expected more than 0, found 0"),
        ("limit-noise 0", "expected a noise above 0 and up to 1"),
        ("limit-noise 200%", "found `200%`"),
        ("bake-with noise=2", "expected a noise above 0 and up to 1"),
        ("bake-with samples=0", "expected 1 to 1073741824, found 0"),
        ("samples 0", "expected 1 to 1073741824, found 0"),
        ("exposure 5000", "expected -20 to 20, found 5000"),
        ("white 100", "expected 1000 to 15000, found 100"),
        ("white 5000 999", "expected -150 to 150, found 999"),
        ("compare wipe 2", "expected 0 to 1, found 2"),
        ("compare noisy -1", "expected 0 to 1, found -1"),
        ("region 0,0 2,2", "expected 0 to 1, found 2"),
        ("frame -1", "expected a frame from 0 to 9999999, found -1"),
        ("layers dept", "there is no layer `dept`; the layers are alpha, albedo"),
        ("layers", "expected `none` or names of layers"),
        ("move ball", "usage: move NAME X,Y,Z"),
        ("select \"ball", "not closed"),
        ("duplicate", "nothing is selected"),
        ("import lamp.obj", "`import` takes no words behind it"),
        ("show albdo", "did you mean"),
    ];
    for (line, part) in cases {
        let _ = apply(&mut world, SelectionCommand::Select(Vec::new(), Default::default()));
        let error = parse::line(&mut world, line).expect_err(line).to_string();
        assert!(error.contains(part), "{line}: {error}");
    }
}

#[test]
fn switches_of_the_menus_take_on_and_off() {
    let mut world = bare_world();
    let switches = [
        ("timeline-shown on", "timeline-shown off"),
        ("grid off", "grid on"),
        ("safe-frame on", "safe-frame off"),
    ];
    let mut command = |line: &str| match parse::line(&mut world, line) {
        Ok(Some(Step::Do(command))) => {
            apply(&mut world, command).expect(line);
            true
        }
        Ok(None) => false,
        other => panic!("{line}: {other:?}"),
    };
    for (there, back) in switches {
        assert!(command(there), "{there}");
        // It is so already.
        assert!(!command(there), "{there}");
        assert!(command(back) && !command(back), "{back}");
    }
    for line in ["undo on", "grid maybe", "denoise maybe"] {
        let error = parse::line(&mut world, line).expect_err(line).to_string();
        assert!(error.contains("words"), "{line}: {error}");
    }
}

#[test]
fn limits_of_the_window_are_kept_with_the_camera() {
    let mut world = bare_world();
    assert!(say(&mut world, "add camera name=eye at=0,0,5"));
    let mut sensors = world.query_filtered::<Entity, With<Sensor>>();
    let eye = sensors.single(&world).expect("a camera");
    world.insert_resource(ActiveSensor(Some(eye)));
    let limits = |world: &World| {
        let film = world.get::<Film>(eye).expect("it has a film");
        (film.sample_count, film.noise_target, film.adaptive)
    };
    // What the picture ends by: the film counts where the window says nothing.
    let effective = |world: &World| {
        let (samples, noise, adaptive) = limits(world);
        let control = world.resource::<RenderControl>();
        (
            control.target_samples.unwrap_or(samples),
            control.noise_target.or(noise).filter(|noise| *noise > 0.0),
            control.adaptive.unwrap_or(adaptive),
        )
    };
    let refusal = |world: &mut World| {
        let Ok(Some(Step::Do(command))) = parse::line(world, "keep-limits") else {
            panic!("it is a command");
        };
        apply(world, command).expect_err("there is nothing to keep").to_string()
    };
    let before = limits(&world);
    assert_eq!(refusal(&mut world), "The camera has these limits already.");
    for line in ["samples 96", "limit-noise 25%", "adaptive on"] {
        assert!(say(&mut world, line), "{line}");
    }
    // They are of the window alone.
    assert_eq!(limits(&world), before);
    assert!(say(&mut world, "keep-limits"));
    assert_eq!(limits(&world), (96, Some(0.25), true));
    let document = write::to_document(&gather::describe(&mut world), Path::new("/scene.xml"));
    let text = sunroom::document::to_xml(&document).expect("it can be written");
    assert!(text.contains("noise_target") && text.contains("value=\"96\""), "{text}");
    assert_eq!(refusal(&mut world), "The camera has these limits already.");
    say(&mut world, "undo");
    assert_eq!((limits(&world), effective(&world)), (before, (96, Some(0.25), true)));
    say(&mut world, "redo");
    assert_eq!(effective(&world), limits(&world));
    assert!(say(&mut world, "limit-noise none") && say(&mut world, "keep-limits"));
    assert_eq!(
        (limits(&world), effective(&world)),
        ((96, None, true), (96, None, true))
    );
    world.insert_resource(ActiveSensor(None));
    assert_eq!(refusal(&mut world), "There is no camera.");
}

#[test]
fn the_choice_of_layers_is_undone() {
    let mut world = bare_world();
    world.init_resource::<IntegratorSettings>();
    let layers = |world: &World| world.resource::<IntegratorSettings>().layers;
    assert!(say(&mut world, "layers depth cryptomatte"));
    let chosen = Layers::of(&[Layer::Depth, Layer::CryptoObject, Layer::CryptoMaterial]);
    assert_eq!(layers(&world), chosen);
    // Choices one after the other are one step.
    say(&mut world, "add sphere at=0,0,0");
    assert!(say(&mut world, "layers none"));
    assert_eq!(layers(&world), Layers::default());
    say(&mut world, "undo");
    assert_eq!(layers(&world), chosen);
    say(&mut world, "undo");
    say(&mut world, "undo");
    assert_eq!(layers(&world), Layers::default());
}

#[test]
fn hiding_is_undone_but_is_no_change_of_the_file() {
    let mut world = bare_world();
    say(&mut world, "add sphere at=0,0,0");
    world.resource_mut::<History>().note_saved();
    say(&mut world, "hide-thing sphere");
    assert!(world.resource::<History>().is_saved());
    assert_eq!(names::<With<Hidden>>(&mut world), ["sphere"]);
    say(&mut world, "undo");
    assert!(names::<With<Hidden>>(&mut world).is_empty());
}

#[test]
fn what_was_deleted_does_not_come_back_by_a_late_command() {
    let mut world = bare_world();
    say(&mut world, "add sphere at=0,0,0");
    let ball = world.resource::<Selection>().active().expect("the ball");
    say(&mut world, "delete");
    let before = state(&mut world);
    let late = [
        Command::from(ValueEdit::SetShape(ball, Shape::default())),
        Command::from(ValueEdit::Transform(vec![(ball, Default::default())])),
        Command::from(MaterialEdit::GiveMaterial { shape: ball }),
        Command::from(OutlineEdit::Rename(ball, "ghost".to_owned())),
        Command::from(OutlineEdit::Hide(vec![ball], true)),
    ];
    for command in late {
        let _ = apply(&mut world, command);
    }
    assert_same(&state(&mut world), &before);
    say(&mut world, "undo");
    assert_eq!(names::<With<Shape>>(&mut world), ["sphere"]);
}

#[test]
fn a_material_deleted_inside_another_leaves_one_in_its_place() {
    let mut world = bare_world();
    say(
        &mut world,
        "paste <shape type=\"cube\"><bsdf type=\"twosided\"><bsdf type=\"conductor\" id=\"inner\"/></bsdf></shape>",
    );
    say(&mut world, "select inner");
    assert!(say(&mut world, "delete"));
    let scene = gather::describe(&mut world);
    let outer = scene
        .materials
        .iter()
        .find(|it| it.material.plugin() == "twosided")
        .expect("it");
    let inner = outer.first.map(|index| scene.materials[index].material.plugin());
    assert_eq!(inner, Some("diffuse"));
}

#[test]
fn what_was_inside_of_a_material_goes_when_it_becomes_another() {
    let mut world = bare_world();
    let paste =
        "paste <shape type=\"cube\"><bsdf type=\"twosided\" id=\"clay\"><bsdf type=\"diffuse\"/></bsdf></shape>";
    assert!(say(&mut world, paste));
    let before = state(&mut world);
    let message = parse::line(&mut world, "set clay reflectance 0.2")
        .expect_err("that is inside")
        .to_string();
    let expected = "there is no `reflectance`; the material is made of `diffuse`";
    assert!(message.starts_with(expected), "{message}");
    for (plugin, expected) in [
        ("plastic", &["twosided", "plastic"][..]),
        ("dielectric", &["dielectric"]),
    ] {
        assert!(say(&mut world, &format!("make clay {plugin}")));
        let scene = gather::describe(&mut world);
        let plugins: Vec<_> = scene.materials.iter().map(|it| it.material.plugin()).collect();
        assert_eq!(plugins, expected);
        assert!(say(&mut world, "undo"));
    }
    assert_same(&state(&mut world), &before);
}

#[test]
fn a_saved_scene_without_a_camera_of_its_own_keeps_the_one_it_got() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("scene.xml");
    std::fs::write(&path, "<scene version='3.0.0'><shape type='sphere' id='ball'/></scene>").expect("a file");
    let read = || {
        let mut document = sunroom::document::load(&path, &[]).expect("a scene");
        sunroom::scene::read::read(&mut document)
    };
    let mut world = bare_world();
    spawn::spawn_fresh(&mut world, &read().into());
    let camera = world.resource::<ActiveSensor>().0.expect("a stand-in");
    assert_eq!(write::save(&mut world, &path).expect("saved"), None);
    spawn::update(&mut world, &read().into());
    assert_eq!(world.resource::<ActiveSensor>().0, Some(camera));
    assert!(world.get::<Sensor>(camera).is_some());
}

#[test]
fn after_a_save_the_file_and_the_things_still_belong_together() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("scene.xml");
    let bsdf = |value: &str| format!("<bsdf type='diffuse'><rgb name='reflectance' value='{value}'/></bsdf>");
    let text = format!(
        "<scene version='3.0.0'>\n<sensor type='perspective'/>\n<bsdf type='conductor' id='metal'/>\n\
         <shape type='sphere' id='a'>{}</shape>\n<shape type='sphere' id='b'>{}</shape>\n</scene>\n",
        bsdf("0.1"),
        bsdf("0.2")
    );
    std::fs::write(&path, &text).expect("a file");
    let read = || {
        let mut document = sunroom::document::load(&path, &[]).expect("a scene");
        sunroom::scene::read::read(&mut document)
    };
    let mut world = bare_world();
    spawn::spawn_fresh(&mut world, &read().into());
    // The material written inside of a is nobody's any more, and is not written.
    say(&mut world, "assign metal a");
    say(&mut world, "rotate b 0,1,0 33");
    write::save(&mut world, &path).expect("saved");
    let saved = std::fs::read_to_string(&path).expect("a file");
    // The other changes in the file, and b is gone from it.
    std::fs::write(&path, saved.replace("0.2", "0.7")).expect("a file");
    spawn::update(&mut world, &read().into());
    let color = |world: &mut World, name: &str| {
        let scene = gather::describe(world);
        let shape = scene
            .shapes
            .iter()
            .find(|shape| shape.identity.id.as_deref() == Some(name))?;
        match &scene.materials[shape.material?].material {
            Material::Diffuse { reflectance } => reflectance.constant().map(|color| color.x),
            _ => None,
        }
    };
    assert_eq!(color(&mut world, "b"), Some(0.7));
    let start = saved.find("<shape type='sphere' id='b'>").expect("b");
    let end = start + saved[start..].find("</shape>").expect("its end") + "</shape>".len();
    std::fs::write(&path, [&saved[..start], &saved[end..]].concat()).expect("a file");
    let summary = spawn::update(&mut world, &read().into());
    assert_eq!((summary.removed > 0, summary.kept), (true, 0), "{summary:?}");
    assert_eq!(names::<With<Shape>>(&mut world), ["a"]);
}

/// A world with the scene of this file, as a window of its own has it.
pub(crate) fn window_on(path: &Path) -> World {
    let mut world = bare_world();
    spawn::spawn_fresh(&mut world, &Arc::new(read_scene(path)));
    world.resource_mut::<SceneStatus>().path = Some(path.to_owned());
    world
}

fn read_scene(path: &Path) -> SceneDescription {
    let mut document = sunroom::document::load(path, &[]).expect("a scene");
    sunroom::scene::read::read(&mut document)
}

pub(crate) fn text_of(path: &Path) -> String {
    std::fs::read_to_string(path).expect("a file")
}

/// x of each shape in the file, in its order.
fn places(path: &Path) -> Vec<f32> {
    let shapes = read_scene(path).shapes;
    let place =
        |shape: &sunroom::scene::description::ShapeDescription| shape.to_world.transform_point3(shape.shape.middle());
    shapes.iter().map(|shape| place(shape).x).collect()
}

fn is_asked(world: &World) -> bool {
    world.resource::<Requests>().save_question.is_some()
}

pub(crate) fn save(world: &mut World) {
    apply(world, FileCommand::Save).expect("saved or asked");
}

const TWO: &str = "<scene version='3.0.0'>\n  <!-- two balls -->\n  <sensor type='perspective' id='eye'/>\n  \
    <shape type='sphere' id='a'/>\n  <shape type='sphere' id='b'/>\n</scene>\n";

#[test]
fn two_windows_keep_what_each_saved() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("scene.xml");
    std::fs::write(&path, TWO).expect("a file");
    let (mut one, mut other) = (window_on(&path), window_on(&path));
    say(&mut one, "set a position 1,0,0");
    save(&mut one);
    // The other has not heard of it.
    say(&mut other, "set b position 2,0,0");
    save(&mut other);
    assert!(!is_asked(&other) && other.resource::<History>().is_saved());
    assert_eq!(places(&path), [1.0, 2.0]);
    assert!(text_of(&path).contains("<!-- two balls -->"));
    // What was taken in is in the other window too, and belongs to the file: it is not an edit of that window.
    let summary = &other.resource::<SceneStatus>().reload;
    assert_eq!((summary.changed, summary.replaced.len()), (1, 0));
    let before = text_of(&path);
    save(&mut other);
    assert_eq!(text_of(&path), before);
    assert!(say(&mut other, "undo") && !say(&mut other, "undo"));
    save(&mut other);
    assert_eq!(places(&path), [1.0, 0.0]);
}

#[test]
fn what_a_file_changed_since_comes_back_with_redo() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("scene.xml");
    std::fs::write(&path, TWO).expect("a file");
    let mut world = window_on(&path);
    say(&mut world, "set a position 1,0,0");
    say(&mut world, "add sphere name=c at=0,0,0 size=1");
    save(&mut world);
    let text = text_of(&path);
    let own = places(&path);
    let (old, new) = ("value=\"1, 0, 0\"", "value=\"3, 0, 0\"");
    assert!(text.contains(old), "{text}");
    std::fs::write(&path, text.replace(old, new)).expect("a file");
    save(&mut world);
    assert!(say(&mut world, "undo") && say(&mut world, "undo"));
    assert!(say(&mut world, "redo") && say(&mut world, "redo"));
    save(&mut world);
    assert_eq!(places(&path), [[3.0].as_slice(), &own[1..]].concat());
}

/// Whatever the order in which they come to write.
#[test]
fn windows_that_save_at_the_same_moment_lose_nothing() {
    const WINDOWS: usize = 4;
    const SAVES: usize = 12;
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("scene.xml");
    let balls: String = (0..WINDOWS)
        .map(|ball| format!("  <shape type='sphere' id='ball-{ball}'/>\n"))
        .collect();
    std::fs::write(
        &path,
        format!("<scene version='3.0.0'>\n  <sensor type='perspective'/>\n{balls}</scene>\n"),
    )
    .expect("a file");
    let worlds: Vec<World> = (0..WINDOWS).map(|_| window_on(&path)).collect();
    let path = &path;
    std::thread::scope(|scope| {
        for (ball, mut world) in worlds.into_iter().enumerate() {
            scope.spawn(move || {
                for place in 1..=SAVES {
                    assert!(say(&mut world, &format!("set ball-{ball} position {place},{ball},0")));
                    // An error is that the others have been saving for too long, as may be on a busy machine.
                    while let Err(error) = apply(&mut world, FileCommand::Save) {
                        assert!(error.to_string().contains("try again"), "{error}");
                    }
                    assert!(!is_asked(&world), "ball {ball}, save {place}");
                }
            });
        }
    });
    assert_eq!(places(path), [SAVES as f32; WINDOWS]);
}

#[test]
fn what_both_windows_changed_is_asked_about() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("scene.xml");
    let conflict = || {
        std::fs::write(&path, TWO).expect("a file");
        let (mut one, mut other) = (window_on(&path), window_on(&path));
        say(&mut one, "set a position 1,0,0");
        save(&mut one);
        say(&mut other, "set a position 5,0,0");
        say(&mut other, "set b position 2,0,0");
        save(&mut other);
        assert!(is_asked(&other) && !other.resource::<History>().is_saved());
        assert_eq!(places(&path), [1.0, 0.0], "nothing is written before it is answered");
        other.resource_mut::<Requests>().save_question = None;
        other
    };
    for (words, expected) in [("merge", [1.0, 2.0]), ("overwrite", [5.0, 2.0])] {
        let mut other = conflict();
        assert!(say(&mut other, &format!("save-to {} {words}", path.display())));
        assert!(!is_asked(&other) && other.resource::<History>().is_saved());
        assert_eq!(places(&path), expected, "{words}");
    }
    // Under another name nothing is in the way, and the file stays.
    let mut other = conflict();
    let elsewhere = folder.path().join("other.xml");
    assert!(say(&mut other, &format!("save-to {}", elsewhere.display())));
    assert_eq!((places(&path), places(&elsewhere)), (vec![1.0, 0.0], vec![5.0, 2.0]));
    save(&mut other);
    assert!(!is_asked(&other));
}

#[test]
fn a_file_written_anew_with_the_same_content_is_no_change() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("scene.xml");
    std::fs::write(&path, format!("\u{feff}{TWO}")).expect("a file");
    let mut world = window_on(&path);
    say(&mut world, "set a position 1,0,0");
    std::fs::write(&path, format!("\u{feff}{TWO}")).expect("a file");
    save(&mut world);
    assert_eq!(world.resource::<SceneStatus>().revision, 0, "nothing was read again");
    // A comment is a change, which loses nothing.
    let commented = text_of(&path).replace("two balls", "both balls");
    std::fs::write(&path, &commented).expect("a file");
    say(&mut world, "set b position 2,0,0");
    save(&mut world);
    assert!(text_of(&path).starts_with('\u{feff}') && text_of(&path).contains("both balls"));
    assert_eq!(places(&path), [1.0, 2.0]);
}

#[test]
fn changes_of_included_files_are_noticed() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("scene.xml");
    let part = folder.path().join("part.xml");
    let with_include = TWO.replace("<shape type='sphere' id='b'/>", "<include filename='part.xml'/>");
    let part_text = "<scene version='3.0.0'>\n  <shape type='sphere' id='b'/>\n</scene>\n";
    let windows = || {
        std::fs::write(&path, &with_include).expect("a file");
        std::fs::write(&part, part_text).expect("a file");
        let (mut one, other) = (window_on(&path), window_on(&path));
        say(&mut one, "set b position 2,0,0");
        save(&mut one);
        assert_eq!(text_of(&path), with_include);
        other
    };
    let mut other = windows();
    say(&mut other, "set a position 1,0,0");
    save(&mut other);
    assert!(!is_asked(&other));
    assert_eq!(places(&path), [1.0, 2.0]);

    let mut other = windows();
    say(&mut other, "set b position 7,0,0");
    save(&mut other);
    assert!(is_asked(&other));
    assert!(say(&mut other, &format!("save-to {} merge", path.display())));
    assert_eq!(places(&path), [0.0, 2.0]);

    // Overwriting makes all files what the window has, also those that were not edited in it.
    let mut other = windows();
    say(&mut other, "set a position 1,0,0");
    assert!(say(&mut other, &format!("save-to {} overwrite", path.display())));
    assert_eq!((places(&path), text_of(&part).as_str()), (vec![1.0, 0.0], part_text));

    // Elsewhere the file that was changed would be included as it is now: its old text goes along.
    let mut other = windows();
    say(&mut other, "set a position 1,0,0");
    let elsewhere = folder.path().join("other.xml");
    assert!(say(&mut other, &format!("save-to {}", elsewhere.display())));
    assert_eq!(places(&elsewhere), [1.0, 0.0]);

    // A part that is gone comes back with the scene.
    let mut other = windows();
    std::fs::remove_file(&part).expect("a file");
    std::fs::remove_file(&path).expect("a file");
    say(&mut other, "set a position 1,0,0");
    save(&mut other);
    assert_eq!((is_asked(&other), places(&path)), (false, vec![1.0, 0.0]));
}

#[test]
fn a_file_that_was_broken_or_replaced_elsewhere_is_not_lost() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("scene.xml");
    std::fs::write(&path, TWO).expect("a file");
    let mut world = window_on(&path);
    say(&mut world, "set a position 1,0,0");
    for broken in ["<scene version='3.0.0'><shape", "\u{89}PNG\r\n", ""] {
        std::fs::write(&path, broken).expect("a file");
        save(&mut world);
        assert!(is_asked(&world), "{broken}");
        assert_eq!(text_of(&path), broken);
        assert!(say(&mut world, &format!("save-to {} merge", path.display())) && is_asked(&world));
        assert_eq!(text_of(&path), broken, "it cannot be merged");
        world.resource_mut::<Requests>().save_question = None;
    }
    assert!(say(&mut world, &format!("save-to {} overwrite", path.display())));
    assert_eq!(places(&path), [1.0, 0.0]);
    // A folder by its name is in the way, whatever is asked for.
    std::fs::remove_file(&path).expect("a file");
    std::fs::create_dir(&path).expect("a folder");
    for words in ["", " merge", " overwrite"] {
        assert!(
            !say(&mut world, &format!("save-to {}{words}", path.display())),
            "{words}"
        );
        assert!(path.is_dir() && !is_asked(&world));
    }
}

#[test]
fn a_recovered_scene_does_not_overwrite_what_was_changed_since() {
    let folder = tempfile::tempdir().expect("a folder");
    let (path, aside) = (folder.path().join("scene.xml"), folder.path().join("aside.xml"));
    for file in [&path, &aside] {
        std::fs::write(file, TWO).expect("a file");
    }
    let mut world = window_on(&aside);
    world.resource_mut::<SceneStatus>().path = Some(path.clone());
    world.init_resource::<write::KnownTexts>();
    world.resource_mut::<write::KnownTexts>().note_present(&path);
    say(&mut world, "set a position 1,0,0");
    std::fs::write(&path, TWO.replace("two", "three")).expect("a file");
    save(&mut world);
    assert!(is_asked(&world));
    // It is taken back: nothing is in the way any more.
    std::fs::write(&path, TWO).expect("a file");
    world.resource_mut::<Requests>().save_question = None;
    save(&mut world);
    assert!(!is_asked(&world));
    assert_eq!(places(&path), [1.0, 0.0]);
}

#[test]
fn instances_that_come_back_after_a_save_are_written_again() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("scene.xml");
    let instances = |group: &str, count: usize| -> String {
        let at = |x: usize| format!("<transform name='to_world'><translate x='{x}'/></transform>");
        (1..=count)
            .map(|x| format!("<shape type='instance'><ref id='{group}'/>{}</shape>\n", at(x)))
            .collect()
    };
    let group = |id: &str| format!("<shape type='shapegroup' id='{id}'><shape type='sphere'/></shape>\n");
    let text = format!(
        "<scene version='3.0.0'>\n<sensor type='perspective'/>\n{}{}{}{}</scene>\n",
        group("few"),
        group("many"),
        instances("few", 1100),
        instances("many", 1200)
    );
    std::fs::write(&path, &text).expect("a file");
    let counts = || -> Vec<(Option<String>, usize)> {
        let scene = read_scene(&path);
        let crowds = scene.shapes.iter().filter_map(|shape| {
            let group = scene.groups[shape.instance_of?].identity.id.clone();
            Some((group, shape.placements.as_ref()?.places.len()))
        });
        crowds.collect()
    };
    let both = counts();
    assert_eq!(both, [(Some("few".into()), 1100), (Some("many".into()), 1200)]);
    let mut world = window_on(&path);
    assert!(say(&mut world, "select \"1100 instances\"") && say(&mut world, "delete"));
    save(&mut world);
    assert_eq!(counts(), both[1..]);
    assert!(say(&mut world, "undo"));
    save(&mut world);
    let mut again = counts();
    again.sort();
    assert_eq!(again, both);
    let scene = read_scene(&path);
    let first = scene.shapes.iter().find_map(|shape| shape.placements.as_ref());
    let place = first.expect("instances").places[77].translation;
    assert_eq!(place, Vec3::new(78.0, 0.0, 0.0));
}

#[test]
fn a_name_that_several_things_have_is_none() {
    let mut world = bare_world();
    for order in 0..3 {
        let shape = ShapeKind::Sphere {
            center: Vec3::ZERO,
            radius: 1.0,
        };
        let shape = Shape {
            kind: shape,
            ..Shape::default()
        };
        world.spawn((DocumentOrder(order), Name::new("sphere"), shape, ToWorld::default()));
    }
    let error = parse::line(&mut world, "set sphere radius 2")
        .expect_err("three of them")
        .to_string();
    assert!(error.contains("3 things called \"sphere\""), "{error}");
    // An id wins over names.
    let mut shapes = world.query_filtered::<Entity, With<Shape>>();
    let first = shapes.iter(&world).next().expect("a shape");
    world.entity_mut(first).insert(SceneId("sphere".to_owned()));
    assert!(say(&mut world, "set sphere radius 2"));
}
