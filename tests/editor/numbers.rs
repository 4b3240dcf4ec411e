//! Numbers stay those that were typed, from the command to the file and back.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use bevy::math::{Affine3A, Vec3};
use bevy::prelude::*;
use bevy_egui::egui::{self, Key, Modifiers, Ui};
use egui_kittest::Harness;
use egui_kittest::kittest::Queryable;
use sunroom::app::editor::automation::script::parse::{self, Step};
use sunroom::app::editor::command::key_bindings::NO_BINDINGS;
use sunroom::app::editor::command::selection::Selection;
use sunroom::app::editor::command::{Command, FileCommand};
use sunroom::app::editor::commands::apply;
use sunroom::app::editor::commands::bare_world::bare_world;
use sunroom::app::editor::model::{Inspected, Model};
use sunroom::app::editor::panels::inspector::{InspectorState, inspector};
use sunroom::app::editor::session::requests::Requests;
use sunroom::app::editor::session::view_settings::ViewSettings;
use sunroom::app::editor::window::field_keys::{FieldKeys, Keyboard};
use sunroom::scene::*;
use tempfile::TempDir;

use crate::support::presses;

/// A window on a scene file of its own.
pub struct Window {
    pub world: World,
    pub path: PathBuf,
    _folder: TempDir,
}

fn described(path: &Path) -> SceneDescription {
    let mut document = sunroom::document::load(path, &[]).expect("a scene");
    let scene = sunroom::scene::read::read(&mut document);
    assert!(!document.diagnostics.has_errors(), "{}", document.diagnostics);
    scene
}

impl Window {
    pub fn on(body: &str) -> Self {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("scene.xml");
        std::fs::write(&path, format!("<scene version=\"3.0.0\">\n{body}\n</scene>\n")).expect("a file");
        let mut world = bare_world();
        spawn::spawn_fresh(&mut world, &Arc::new(described(&path)));
        world.resource_mut::<SceneStatus>().path = Some(path.clone());
        Self {
            world,
            path,
            _folder: folder,
        }
    }

    /// Says a line, which is a step of the history of its own.
    pub fn say(&mut self, line: &str) {
        self.world.resource_mut::<Requests>().interaction += 1;
        match parse::line(&mut self.world, line) {
            Ok(Some(Step::Do(command))) => {
                apply(&mut self.world, command).unwrap_or_else(|error| panic!("{line}: {error}"))
            }
            other => panic!("{line}: {other:?}"),
        }
    }

    /// The text of the file after saving.
    pub fn saved(&mut self) -> String {
        apply(&mut self.world, FileCommand::Save).expect("saved");
        std::fs::read_to_string(&self.path).expect("a file")
    }

    /// Merges another text of the file.
    fn read_again(&mut self, from: &str, to: &str) -> ReloadSummary {
        let text = std::fs::read_to_string(&self.path).expect("a file");
        assert!(text.contains(from), "{text}");
        std::fs::write(&self.path, text.replace(from, to)).expect("a file");
        spawn::update(&mut self.world, &Arc::new(described(&self.path)))
    }

    fn named(&mut self, name: &str) -> Entity {
        let mut all = self.world.query::<(Entity, &Name)>();
        let found = all.iter(&self.world).find(|(_, its)| its.as_str() == name);
        found.unwrap_or_else(|| panic!("no {name}")).0
    }

    fn angles(&mut self, name: &str) -> [f32; 3] {
        let thing = self.named(name);
        self.world
            .get::<EulerAngles>(thing)
            .copied()
            .unwrap_or_default()
            .0
            .to_array()
    }

    pub fn shape(&mut self, name: &str) -> (Shape, Affine3A) {
        let thing = self.named(name);
        let shape = self.world.get::<Shape>(thing).cloned().expect("a shape");
        (shape, self.world.get::<ToWorld>(thing).expect("a place").0)
    }
}

fn file_angles(path: &Path, index: usize) -> [f32; 3] {
    let angles = described(path).shapes[index].identity.angles;
    angles.unwrap_or_default().0.to_array()
}

#[test]
fn typed_angles_are_saved_and_come_back() {
    let mut window = Window::on("  <shape type=\"cube\" id=\"box\"/>");
    window.say("set box rotation 0,180,0");
    let text = window.saved();
    assert!(
        text.contains("<rotate y=\"1\" angle=\"180\"/>") && !text.contains("<rotate x"),
        "{text}"
    );
    assert_eq!(file_angles(&window.path, 0), [0.0, 180.0, 0.0]);
    // The same rotation by other angles is those.
    for angles in ["180,0,180", "0,540,0", "33.333,-90,12.5", "0.1,0.2,-0.3"] {
        window.say(&format!("set box rotation {angles}"));
        let expected: Vec<f32> = angles
            .split(',')
            .map(|angle| angle.parse().expect("a number"))
            .collect();
        assert_eq!(window.angles("box").to_vec(), expected);
        window.saved();
        assert_eq!(file_angles(&window.path, 0).to_vec(), expected, "{angles}");
    }
    // A move and a scale leave them.
    window.say("move box 1,2,3");
    window.say("set box scale 4.5,0.5,3");
    assert_eq!(window.angles("box"), [0.1, 0.2, -0.3]);
    let text = window.saved();
    assert!(text.contains("<scale value=\"4.5, 0.5, 3\"/>"), "{text}");
    assert!(
        text.contains("<rotate z=\"1\" angle=\"-0.3\"/>") && text.contains("<translate value=\"1, 2, 3\"/>"),
        "{text}"
    );
    // Undo goes back to the angles before.
    for _ in 0..3 {
        window.say("undo");
    }
    assert_eq!(window.angles("box"), [33.333, -90.0, 12.5]);
}

#[test]
fn turns_without_typed_angles_have_the_smallest() {
    let mut window = Window::on(
        "  <shape type=\"cube\" id=\"box\"/>\n  <shape type=\"cube\" id=\"other\"><transform name=\"to_world\"><rotate y=\"1\" angle=\"170\"/></transform></shape>",
    );
    window.say("rotate box 0,1,0 180");
    window.say("rotate other 0,1,0 20");
    assert_eq!(
        (window.angles("box"), window.angles("other")),
        ([0.0, 180.0, 0.0], [0.0, -170.0, 0.0])
    );
    let text = window.saved();
    assert!(
        text.contains("angle=\"180\"") && text.contains("<rotate y=\"1\" angle=\"-170\"/>"),
        "{text}"
    );
    for _ in 0..24 {
        window.say("rotate other 0,1,0 15");
    }
    assert_eq!(window.angles("other"), [0.0, -170.0, 0.0]);
    // Two half turns are none.
    window.say("rotate box 0,1,0 180");
    assert_eq!(window.angles("box"), [0.0, 0.0, 0.0]);
    let text = window.saved();
    assert!(
        !text.contains("angle=\"180\"") && !text.contains("angle=\"360\""),
        "{text}"
    );
}

#[test]
fn a_file_keeps_its_own_rotations_until_they_are_edited() {
    let odd = "<rotate x=\"0.6\" y=\"0.8\" angle=\"30\"/>";
    let body = format!(
        "  <shape type=\"cube\" id=\"box\"><transform name=\"to_world\">{odd}<translate x=\"1\"/></transform></shape>"
    );
    let mut window = Window::on(&body);
    window.say("move box 0,0,5");
    let text = window.saved();
    assert!(text.contains(odd), "{text}");
    window.say("set box rotation 0,45,0");
    let text = window.saved();
    assert!(text.contains("angle=\"45\"") && !text.contains("0.6"), "{text}");
    assert_eq!(file_angles(&window.path, 0), [0.0, 45.0, 0.0]);
}

#[test]
fn building_parts_stand_upright_at_rotation_0() {
    for plugin in ["wall", "stairs", "prism"] {
        let mut window = Window::on("  <sensor type=\"perspective\"/>");
        window.say(&format!("add {plugin} at=0,0,0"));
        let (_, added) = window.shape(plugin);
        window.say(&format!("set {plugin} rotation 0,0,0"));
        assert_eq!(window.shape(plugin).1.matrix3, added.matrix3, "{plugin}");
        assert_eq!(added.transform_vector3(Vec3::Z), Vec3::Y, "{plugin}");
        window.say(&format!("set {plugin} rotation 0,90,0"));
        let text = window.saved();
        let rotations = "<rotate x=\"1\" angle=\"-90\"/>";
        assert!(
            text.contains(rotations) && text.contains("<rotate y=\"1\" angle=\"90\"/>"),
            "{text}"
        );
        assert!(!text.contains("<rotate z"), "{text}");
        assert_eq!(window.angles(plugin), [-90.0, 90.0, 0.0]);
        // In a world whose z is up, their own z is up already.
        window.world.resource_mut::<ViewSettings>().navigation.up = Vec3::Z;
        window.say(&format!("set {plugin} rotation 0,0,30"));
        assert_eq!(window.angles(plugin), [0.0, 0.0, 30.0]);
    }
}

#[test]
fn what_has_a_place_of_its_own_is_moved_by_that() {
    let body = "  <shape type=\"sphere\" id=\"ball\"><point name=\"center\" x=\"-2\" y=\"1\" z=\"0.1\"/></shape>
  <shape type=\"cylinder\" id=\"pipe\"><point name=\"p0\" value=\"0.1, 0, 0\"/><point name=\"p1\" value=\"0.1, 0.3, 2\"/></shape>
  <shape type=\"triangle\" id=\"sail\"><point name=\"v0\" value=\"0, 0, 0\"/><point name=\"v1\" value=\"1, 0, 0\"/><point name=\"v2\" value=\"0, 1, 0\"/></shape>
  <emitter type=\"point\" id=\"lamp\"><point name=\"position\" x=\"1\" y=\"2\" z=\"3\"/></emitter>";
    let mut window = Window::on(body);
    window.say("move ball 0.8,0,0.2");
    window.say("move pipe 0.2,0.1,0");
    window.say("move sail 0,0,0.7");
    window.say("move lamp 0,0.5,0");
    let text = window.saved();
    assert!(!text.contains("to_world"), "{text}");
    let shapes = described(&window.path).shapes;
    let kinds: Vec<&ShapeKind> = shapes.iter().map(|shape| &shape.shape.kind).collect();
    let pipe = ShapeKind::Cylinder {
        p0: Vec3::new(0.3, 0.1, 0.0),
        p1: Vec3::new(0.3, 0.4, 2.0),
        radius: 1.0,
    };
    let corners = [Vec3::ZERO, Vec3::X, Vec3::Y].map(|corner| corner + Vec3::Z * 0.7);
    assert!(
        matches!(kinds[0], ShapeKind::Sphere { center, .. } if *center == Vec3::new(-1.2, 1.0, 0.3)),
        "{kinds:?}"
    );
    assert_eq!((kinds[1], kinds[2]), (&pipe, &ShapeKind::Triangle { corners }));
    let lamp = described(&window.path).emitters[0].to_world;
    assert_eq!(lamp.translation, Vec3::new(1.0, 2.5, 3.0).into());
    // Copies are moved in the same way.
    let ball = window.named("ball");
    window.world.insert_resource(Selection::of([ball]));
    window.say("series 3 along 0,0,1");
    assert!(!window.saved().contains("to_world"));
    let centers: Vec<f32> = described(&window.path)
        .shapes
        .iter()
        .filter_map(|shape| match shape.shape.kind {
            ShapeKind::Sphere { center, .. } => Some(center.z),
            _ => None,
        })
        .collect();
    assert_eq!(centers, [0.3, 1.3, 2.3]);
}

#[test]
fn what_has_a_transform_is_moved_by_that() {
    let body = "  <shape type=\"sphere\" id=\"ball\"><point name=\"center\" x=\"1\" y=\"0\" z=\"0\"/>
    <transform name=\"to_world\"><translate x=\"1\"/></transform></shape>
  <shape type=\"sphere\" id=\"egg\"/>";
    let mut window = Window::on(body);
    window.say("move ball 0,0,5");
    window.say("set egg scale 1,2,1");
    let text = window.saved();
    assert!(
        text.contains("<translate x=\"1\" z=\"5\"/>")
            && text.contains("<point name=\"center\" x=\"1\" y=\"0\" z=\"0\"/>"),
        "{text}"
    );
    assert!(text.contains("<scale value=\"1, 2, 1\"/>"), "{text}");
    // The position is that of the centre.
    window.say("set ball position 3,0,5");
    assert_eq!(window.shape("ball").1.translation, Vec3::new(2.0, 0.0, 5.0).into());
}

#[test]
fn a_centre_that_the_file_moves_as_well_is_that_of_one_side() {
    let body = "  <shape type=\"sphere\" id=\"ball\"><point name=\"center\" x=\"0\" y=\"0\" z=\"0\"/><float name=\"radius\" value=\"1\"/></shape>";
    let place = |window: &mut Window| {
        let (shape, pose) = window.shape("ball");
        pose.transform_point3(shape.middle()).x
    };
    let mut window = Window::on(body);
    window.say("move ball 0.8,0,0");
    let summary = window.read_again("x=\"0\"", "x=\"-2\"");
    assert_eq!((summary.replaced.len(), place(&mut window)), (1, -2.0));
    // Another number of the file leaves the move.
    window.say("move ball 0.8,0,0");
    let summary = window.read_again("value=\"1\"", "value=\"3\"");
    assert_eq!((summary.replaced.len(), place(&mut window)), (0, -1.2));
    assert!(matches!(
        window.shape("ball").0.kind,
        ShapeKind::Sphere { radius: 3.0, .. }
    ));
}

#[test]
fn a_box_with_projected_textures_stands_as_before() {
    let board = "<texture type=\"checkerboard\" name=\"reflectance\"/>";
    for scale in ["0.1, 1.25, 4", "4, 0.5, 1", "1, 1, 1"] {
        let body = format!(
            "  <shape type=\"cube\" id=\"box\"><transform name=\"to_world\"><scale value=\"{scale}\"/><rotate y=\"1\" angle=\"30\"/></transform>
    <bsdf type=\"diffuse\">{board}</bsdf></shape>"
        );
        let mut window = Window::on(&body);
        window.say("project-texture box 0.5 box");
        let (shape, pose) = window.shape("box");
        let ShapeKind::Solid(Solid::Wall {
            length,
            height,
            thickness,
            ..
        }) = shape.kind
        else {
            panic!("{shape:?}")
        };
        let size: Vec<f32> = scale
            .split(',')
            .map(|number| 2.0 * number.trim().parse::<f32>().expect("a number"))
            .collect();
        let found = [length, height, thickness];
        assert!(
            found.iter().zip(&size).all(|(one, other)| (one - other).abs() < 1e-5),
            "{found:?} {size:?}"
        );
        // Upright, and turned as the box was.
        assert_eq!(window.angles("box"), [-90.0, 30.0, 0.0]);
        let middle = pose.transform_point3(0.5 * Vec3::new(length, 0.0, height));
        assert!(middle.abs_diff_eq(Vec3::ZERO, 1e-5), "{middle}");
    }
}

/// The inspector on a thing of a window, and the keys of the window beside it.
struct Typing {
    window: Window,
    panel: InspectorState,
    keys: FieldKeys,
    keyboard: Option<Keyboard>,
}

fn inspect_ball(ui: &mut Ui, typing: &mut Typing) {
    let context = ui.ctx().clone();
    let mut commands = Vec::new();
    let pressed = presses(ui);
    for press in typing.keys.take(&context, pressed, typing.keyboard, &NO_BINDINGS) {
        let is_of_saving = press.key == Key::S && press.modifiers.command;
        commands.extend(is_of_saving.then_some(Command::from(FileCommand::Save)));
    }
    let ball = typing.window.named("ball");
    let (shape, pose) = typing.window.shape("ball");
    let model = Model {
        inspected: Some(Inspected {
            to_world: Some(pose),
            shape: Some(shape),
            ..Inspected::new(ball, "ball")
        }),
        ..Model::default()
    };
    inspector(ui, &model, 10.0, &mut typing.panel, &mut commands);
    typing.keys.end_frame(&context);
    typing.keyboard = Keyboard::of(&context, false);
    for command in commands {
        apply(&mut typing.window.world, command).expect("it can be done");
    }
}

/// Without Enter before it.
#[test]
fn saving_takes_the_number_that_is_being_typed() {
    for (text, expected) in [("0,5", 0.5), ("1/4", 0.25), ("3", 3.0)] {
        let typing = Typing {
            window: Window::on("  <shape type=\"sphere\" id=\"ball\"><float name=\"radius\" value=\"2\"/></shape>"),
            panel: InspectorState::default(),
            keys: FieldKeys::default(),
            keyboard: None,
        };
        let mut harness = Harness::builder()
            .with_size(egui::vec2(340.0, 1000.0))
            .build_ui_state(inspect_ball, typing);
        harness.run_steps(3);
        harness.get_by_label("Radius").click();
        harness.run_steps(4);
        harness.event(egui::Event::Text(text.into()));
        harness.run_steps(2);
        harness.key_press_modifiers(Modifiers::COMMAND, Key::S);
        harness.run_steps(5);
        let saved = std::fs::read_to_string(&harness.state().window.path).expect("a file");
        let told = format!("<float name=\"radius\" value=\"{expected}\"/>");
        assert!(saved.contains(&told), "{text}: {saved}");
    }
}
