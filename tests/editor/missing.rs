//! Scenes with missing files in the window: what is told of them, how they are found, and that a save keeps what is not
//! found.

use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use bevy::prelude::*;
use bevy_egui::egui;
use egui_kittest::Harness;
use egui_kittest::kittest::Queryable;
use sunroom::app::editor::command::light_mix::{FilmLights, LightMix};
use sunroom::app::editor::command::selection::Selection;
use sunroom::app::editor::command::shell::{ShellCommand, SoughtFile};
use sunroom::app::editor::command::{Command, HistoryCommand, SceneEdit, ValueEdit};
use sunroom::app::editor::commands::{apply, scene_watch};
use sunroom::app::editor::model::MissingItem;
use sunroom::app::editor::panels::missing_files::{MissingForm, missing_files};
use sunroom::app::editor::picture::paths::PathInspector;
use sunroom::app::editor::session::history::History;
use sunroom::app::editor::session::options;
use sunroom::app::editor::session::recovery::Recovery;
use sunroom::app::editor::session::requests::{CommandQueue, Requests};
use sunroom::app::editor::session::toasts::Toasts;
use sunroom::app::editor::session::trust::TrustedFolders;
use sunroom::app::editor::session::view_settings::ViewSettings;
use sunroom::engine::{PackedScene, RenderControl, RenderFilm};
use sunroom::math::Aabb;
use sunroom::scene::write;
use sunroom::scene::*;
use tempfile::TempDir;

/// No test takes so long, however busy the machine is.
const HANG: Duration = Duration::from_secs(600);
const MESH: &str = "v 0 0 0\nv 2 0 0\nv 0 4 0\nf 1 2 3\n";
const PIXEL: &str = "P3 1 1 255 90 90 90\n";
const SCENE: &str = "<scene version='3.0.0'>
  <sensor type='perspective' id='eye'/>
  <shape type='obj' id='chair'><string name='filename' value='models/chair.obj'/></shape>
  <shape type='obj' id='stool'><string name='filename' value='models/chair.obj'/>
    <transform name='to_world'><translate x='10'/></transform></shape>
  <shape type='obj' id='lamp'><string name='filename' value='models/lamp.obj'/></shape>
  <bsdf type='roughconductor' id='metal'><texture type='bitmap' name='alpha'><string name='filename' value='textures/worn.ppm'/></texture></bsdf>
  <emitter type='envmap' id='sky'><string name='filename' value='textures/sky.ppm'/></emitter>
</scene>
";

/// What the window has of scenes and messages.
struct Window {
    app: App,
    folder: TempDir,
}

impl Window {
    fn new() -> Self {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let mut app = App::new();
        app.add_plugins((MinimalPlugins, FileSourcePlugin, asset_plugin(), ScenePlugin))
            .init_resource::<ViewSettings>()
            .init_resource::<Requests>()
            .init_resource::<Toasts>()
            .init_resource::<CommandQueue>()
            .init_resource::<RenderControl>()
            .init_resource::<PackedScene>()
            .init_resource::<Selection>()
            .init_resource::<History>()
            .init_resource::<LightMix>()
            .init_resource::<FilmLights>()
            .init_resource::<RenderFilm>()
            .init_resource::<PathInspector>()
            .insert_resource(options::SceneDefines(Vec::new()))
            .insert_resource(Recovery::new(None))
            .add_systems(
                PreUpdate,
                (scene_watch::follow_scene, scene_watch::follow_files)
                    .chain()
                    .after(SceneSystems::Follow),
            );
        app.finish();
        app.cleanup();
        let window = Self { app, folder };
        window.write("level/scene.xml", SCENE);
        window
    }

    /// Absolute and without links, as the program names files.
    fn path(&self, name: &str) -> PathBuf {
        let folder = self.folder.path().canonicalize().expect("it is there");
        folder.join(name)
    }

    fn write(&self, name: &str, text: &str) {
        let path = self.path(name);
        std::fs::create_dir_all(path.parent().expect("inside the folder")).expect("a writable folder");
        let aside = path.with_extension("tmp");
        std::fs::write(&aside, text).expect("a writable folder");
        std::fs::rename(&aside, &path).expect("a writable folder");
    }

    #[track_caller]
    fn until(&mut self, what: &str, done: impl Fn(&World) -> bool) {
        let deadline = Instant::now() + HANG;
        while !done(self.app.world()) {
            assert!(Instant::now() < deadline, "not in time: {what}: {:?}", self.status());
            std::thread::sleep(Duration::from_millis(5));
            self.app.update();
        }
    }

    /// Opens a scene, and waits for its files and for the frame after.
    fn open(&mut self, name: &str) {
        let path = self.path(name);
        let before = self.status().revision;
        self.app.world_mut().write_message(OpenScene {
            path,
            ..OpenScene::default()
        });
        self.until("the scene", |world| {
            let status = world.resource::<SceneStatus>();
            status.revision != before && status.is_complete()
        });
        self.app.update();
    }

    fn status(&self) -> &SceneStatus {
        self.app.world().resource::<SceneStatus>()
    }

    /// The names of the missing files.
    fn missing(&self) -> Vec<String> {
        let name = |problem: &FileProblem| problem.path.file_name().unwrap().to_string_lossy().into_owned();
        self.status().missing_files().map(name).collect()
    }

    fn texts(&self) -> Vec<String> {
        self.app
            .world()
            .resource::<Toasts>()
            .texts()
            .map(str::to_owned)
            .collect()
    }

    fn about_missing(&self) -> Vec<String> {
        let is_about = |text: &String| text.contains("of the scene") && text.contains("missing");
        self.texts().into_iter().filter(is_about).collect()
    }

    fn find(&mut self, missing: &str, found: &str, others: bool) -> Result<(), String> {
        let command = Command::from(SceneEdit::FindFile {
            missing: self.path(missing),
            found: self.path(found),
            others,
        });
        apply(self.app.world_mut(), command).map_err(|error| error.to_string())
    }

    fn settle(&mut self) {
        self.app.update();
        self.until("the files", |world| world.resource::<SceneStatus>().is_complete());
        self.app.update();
    }

    fn saved(&mut self, name: &str) -> String {
        let path = self.path(name);
        write::save(self.app.world_mut(), &path).expect("it is saved");
        std::fs::read_to_string(&path).expect("the scene")
    }

    /// The bounds of the boxes that stand in the place of meshes, by the names of their shapes.
    fn stand_ins(&mut self) -> Vec<(String, Aabb)> {
        let world = self.app.world_mut();
        let mut state = bevy::ecs::system::SystemState::<StandIns>::new(world);
        let stand_ins = state.get(world).expect("its parameters");
        let found = stand_ins.shapes();
        let bounds: Vec<_> = found
            .iter()
            .map(|entity| stand_ins.bounds(*entity).expect("a box"))
            .collect();
        let name = |entity: &Entity| world.get::<SceneId>(*entity).expect("an id").0.clone();
        let mut all: Vec<_> = found.iter().map(name).zip(bounds).collect();
        all.sort_by(|a, b| a.0.cmp(&b.0));
        all
    }
}

#[test]
fn a_missing_member_of_a_group_has_a_box_at_each_of_its_places() {
    let mut window = Window::new();
    let scene = "<scene version='3.0.0'>
  <sensor type='perspective' id='eye'/>
  <shape type='shapegroup' id='seats'>
    <shape type='obj' id='chair'><string name='filename' value='models/chair.obj'/>
      <transform name='to_world'><translate y='1'/></transform></shape>
  </shape>
  <shape type='instance' id='left'><ref id='seats'/><transform name='to_world'><translate x='-5'/></transform></shape>
  <shape type='instance' id='right'><ref id='seats'/><transform name='to_world'><translate x='5'/></transform></shape>
</scene>
";
    window.write("level/scene.xml", scene);
    window.open("level/scene.xml");
    let world = window.app.world_mut();
    let mut state = bevy::ecs::system::SystemState::<StandIns>::new(world);
    let stand_ins = state.get(world).expect("its parameters");
    let [chair] = stand_ins.shapes()[..] else {
        panic!("one mesh is missing")
    };
    let places = stand_ins.places(chair);
    let mut found: Vec<(String, Vec3)> = places
        .iter()
        .map(|(instance, pose)| {
            let id = world.get::<SceneId>(*instance).expect("an id").0.clone();
            (id, pose.translation.into())
        })
        .collect();
    found.sort_by(|a, b| a.0.cmp(&b.0));
    let expected = [("left", -5.0), ("right", 5.0)].map(|(id, x)| (id.to_owned(), Vec3::new(x, 1.0, 0.0)));
    assert_eq!(found, expected);
}

#[test]
fn a_scene_opens_without_its_files_and_they_are_told_of_once() {
    let mut window = Window::new();
    window.open("level/scene.xml");
    assert_eq!(window.status().state, SceneState::Ready);
    assert_eq!(window.missing(), ["chair.obj", "lamp.obj", "sky.ppm", "worn.ppm"]);
    let expected = "4 files of the scene are missing: chair.obj, lamp.obj, sky.ppm and worn.ppm";
    assert_eq!(window.about_missing(), [expected]);
    assert!(
        !window.texts().iter().any(|text| text.contains("no such file")),
        "{:?}",
        window.texts()
    );
    // Boxes stand in place of the meshes.
    let boxes = window.stand_ins();
    let names: Vec<&str> = boxes.iter().map(|(name, _)| name.as_str()).collect();
    assert_eq!(names, ["chair", "lamp", "stool"]);
    let unit = Aabb::from_points([Vec3::splat(-0.5), Vec3::splat(0.5)]);
    assert!(boxes.iter().all(|(_, bounds)| *bounds == unit));
    // A save keeps all names, here and elsewhere.
    assert_eq!(window.saved("level/scene.xml"), SCENE);
    let elsewhere = window.saved("copy.xml");
    for name in [
        "level/models/chair.obj",
        "level/models/lamp.obj",
        "level/textures/worn.ppm",
        "level/textures/sky.ppm",
    ] {
        assert!(elsewhere.contains(name), "{elsewhere}");
    }
}

#[test]
fn a_box_is_moved_like_its_mesh() {
    let mut window = Window::new();
    window.open("level/scene.xml");
    let world = window.app.world_mut();
    let lamp = find_by_id(world, "lamp");
    let pose = bevy::math::Affine3A::from_translation(Vec3::new(1.0, 2.0, 3.0));
    apply(world, ValueEdit::Transform(vec![(lamp, pose)])).expect("it can be moved");
    window.settle();
    assert_eq!(window.stand_ins().len(), 3);
    let text = window.saved("level/scene.xml");
    assert!(text.contains("models/lamp.obj") && text.contains("1, 2, 3"), "{text}");
    assert!(!text.contains("cube"), "{text}");
}

fn find_by_id(world: &mut World, id: &str) -> Entity {
    let mut all = world.query::<(Entity, &SceneId)>();
    let found = all.iter(world).find(|(_, known)| known.0 == id);
    found.map(|(entity, _)| entity).expect("it is there")
}

#[test]
fn a_file_that_appears_takes_the_place_of_its_box() {
    let mut window = Window::new();
    window.open("level/scene.xml");
    window.write("level/models/chair.obj", MESH);
    window.until("the mesh", |world| {
        world.resource::<SceneStatus>().mesh_errors.len() == 1
    });
    window.settle();
    assert_eq!(window.stand_ins().len(), 1);
    let expected = "3 files of the scene are missing: lamp.obj, sky.ppm and worn.ppm";
    assert_eq!(window.about_missing(), [expected]);
    window.write("level/models/lamp.obj", MESH);
    window.write("level/textures/worn.ppm", PIXEL);
    window.write("level/textures/sky.ppm", PIXEL);
    window.until("all files", |world| {
        world.resource::<SceneStatus>().missing_files().next().is_none()
    });
    window.settle();
    assert_eq!(window.about_missing(), [""; 0]);
    assert!(window.stand_ins().is_empty() && !window.status().has_errors());
}

/// The box is the one around the mesh as it was last seen.
#[test]
fn a_box_has_the_bounds_that_are_known() {
    let mut window = Window::new();
    window.write("level/models/chair.obj", MESH);
    window.write("other.xml", "<scene version='3.0.0'><shape type='sphere'/></scene>");
    window.open("level/scene.xml");
    window.open("other.xml");
    assert_eq!(window.about_missing(), [""; 0], "they were of the other scene");
    std::fs::remove_file(window.path("level/models/chair.obj")).expect("it was there");
    window.open("level/scene.xml");
    let boxes = window.stand_ins();
    let around = Aabb::from_points([Vec3::ZERO, Vec3::new(2.0, 4.0, 0.0)]);
    let of = |name: &str| boxes.iter().find(|(known, _)| known == name).expect("a box").1;
    assert_eq!((of("chair"), of("stool")), (around, around));
    assert_ne!(of("lamp"), around);
}

#[test]
fn a_file_is_found_with_those_beside_it_and_that_can_be_undone() {
    let mut window = Window::new();
    window.open("level/scene.xml");
    for (name, text) in [
        ("moved/models/chair.obj", MESH),
        ("moved/models/lamp.obj", MESH),
        ("moved/textures/sky.ppm", PIXEL),
    ] {
        window.write(name, text);
    }
    window
        .find("level/models/chair.obj", "moved/models/chair.obj", true)
        .expect("it is found");
    window.settle();
    assert_eq!(window.missing(), ["worn.ppm"]);
    assert!(window.stand_ins().is_empty());
    let texts = window.texts();
    let expected = "Found chair.obj and 2 other files; one file is still missing";
    assert!(texts.iter().any(|text| text == expected), "{texts:?}");
    assert_eq!(window.about_missing(), ["A file of the scene is missing: worn.ppm"]);
    let text = window.saved("level/scene.xml");
    for name in [
        "../moved/models/chair.obj",
        "../moved/models/lamp.obj",
        "../moved/textures/sky.ppm",
        "textures/worn.ppm",
    ] {
        assert!(text.contains(name), "{text}");
    }
    // All of it is one step.
    apply(window.app.world_mut(), HistoryCommand::Undo).expect("it is undone");
    window.settle();
    assert_eq!(window.missing().len(), 4);
    assert_eq!(window.saved("level/scene.xml"), SCENE);
}

#[test]
fn only_the_file_that_was_asked_for_is_found_if_others_are_not_wanted() {
    let mut window = Window::new();
    window.open("level/scene.xml");
    window.write("moved/chair.obj", MESH);
    window.write("moved/lamp.obj", MESH);
    window.write("moved/chair.ply", "ply\n");
    window
        .find("level/models/chair.obj", "moved/chair.obj", false)
        .expect("it is found");
    window.settle();
    assert_eq!(window.missing(), ["lamp.obj", "sky.ppm", "worn.ppm"]);
    for (missing, found, part) in [
        ("level/models/lamp.obj", "moved/none.obj", "there is no such file"),
        ("level/models/lamp.obj", "moved/chair.ply", "of the kind .obj"),
        (
            "level/models/table.obj",
            "moved/lamp.obj",
            "Nothing in the scene names table.obj",
        ),
    ] {
        let error = window.find(missing, found, true).expect_err("it cannot be");
        assert!(error.contains(part), "{error}");
    }
    assert_eq!(window.missing().len(), 3, "nothing was changed");
}

/// A scene from elsewhere may name files so that the way from one to the other leads out of the folder that the user
/// has chosen.
#[test]
fn only_what_lies_in_the_chosen_folder_is_allowed() {
    let mut window = Window::new();
    let settings = window.path("settings");
    let (trusted, trust) = TrustedFolders::open(Some(&settings));
    window.app.insert_resource(trusted).insert_resource(trust);
    let mesh = |file: &str| format!("<shape type='obj'><string name='filename' value='{file}'/></shape>");
    let texture =
        "<texture type='bitmap' name='reflectance'><string name='filename' value='deep/down/here/worn.ppm'/></texture>";
    let scene = [
        "<scene version='3.0.0'>",
        &format!("<bsdf type='diffuse' id='worn'>{texture}</bsdf>"),
        &mesh("deep/down/here/chair.obj"),
        &mesh("table.obj"),
        "</scene>",
    ];
    window.write("a/level/scene.xml", &scene.concat());
    for (name, text) in [
        ("a/chosen/here/worn.ppm", PIXEL),
        ("a/chosen/here/chair.obj", MESH),
        ("a/chosen/here/private.obj", MESH),
        ("table.obj", MESH),
    ] {
        window.write(name, text);
    }
    window.open("a/level/scene.xml");
    assert_eq!(window.missing(), ["chair.obj", "table.obj", "worn.ppm"]);
    window
        .find("a/level/deep/down/here/worn.ppm", "a/chosen/here/worn.ppm", true)
        .expect("it is found");
    window.settle();
    // The table is found as well; whether the scene may read it is for the user to say.
    assert_eq!(window.missing(), [""; 0]);
    let refused = window.app.world().resource::<SceneAccess>().refused();
    assert_eq!(refused, [window.path("table.obj")]);
    let now = window.app.world().resource::<Trust>().clone();
    let (_, next_run) = TrustedFolders::open(Some(&settings));
    for trust in [now, next_run] {
        let access = trust.access(Path::new(""));
        for (name, is_allowed) in [
            ("a/chosen/here/worn.ppm", true),
            ("a/chosen/here/chair.obj", true),
            ("a/chosen/here/private.obj", false),
            ("table.obj", false),
        ] {
            assert_eq!(access.covers(&window.path(name)), is_allowed, "{name}");
        }
    }
}

struct Shown {
    items: Vec<MissingItem>,
    form: MissingForm,
    commands: Vec<Command>,
    is_closed: bool,
}

fn list(items: Vec<MissingItem>) -> Harness<'static, Shown> {
    let shown = Shown {
        items,
        form: MissingForm::default(),
        commands: Vec::new(),
        is_closed: false,
    };
    let mut harness = Harness::builder().with_size(egui::vec2(600.0, 400.0)).build_ui_state(
        |ui, shown: &mut Shown| {
            shown.is_closed |= missing_files(ui, &mut shown.form, &shown.items, &mut shown.commands);
        },
        shown,
    );
    harness.run_steps(3);
    harness
}

#[test]
fn each_file_of_the_list_has_a_button_that_asks_for_it() {
    let item = |kind, path: &str| MissingItem {
        kind,
        path: Path::new(path).to_owned(),
    };
    let items = vec![
        item(FileKind::Mesh, "/a/chair.obj"),
        item(FileKind::Picture, "/a/paper.png"),
    ];
    let mut harness = list(items);
    assert!(harness.query_by_label("chair.obj").is_some() && harness.query_by_label("mesh in /a").is_some());
    let asked = |others| {
        let sought = SoughtFile {
            kind: FileKind::Picture,
            path: "/a/paper.png".into(),
            others,
        };
        Command::Shell(ShellCommand::FindFile(sought))
    };
    assert_eq!(harness.query_all_by_label("Find…").count(), 2);
    harness.query_all_by_label("Find…").nth(1).expect("a button").click();
    harness.run_steps(3);
    harness.get_by_label("Look in that folder for the others").click();
    harness.run_steps(3);
    harness.query_all_by_label("Find…").nth(1).expect("a button").click();
    harness.run_steps(3);
    assert_eq!(harness.state().commands, [asked(true), asked(false)]);
    harness.get_by_label("Close").click();
    harness.run_steps(3);
    assert!(harness.state().is_closed);
    let harness = list(Vec::new());
    assert!(harness.query_by_label("All files of the scene are there.").is_some());
}
