//! Bakes of the editor without a window: what they write, and what is left of those that are stopped or given up.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::process::Command as Process;
use std::time::{Duration, Instant};

use bevy::prelude::*;
use sunroom::app::editor::automation::script::baking::{BakeWait, has_come, is_lit_level_seen};
use sunroom::app::editor::automation::script::parse::{Step, line};
use sunroom::app::editor::command::baking::{BakeChoices, BakeCommand, BakePlan};
use sunroom::app::editor::command::compare_view::CompareView;
use sunroom::app::editor::command::error::CommandError;
use sunroom::app::editor::command::selection::Selection;
use sunroom::app::editor::command::{Command, DisplayCommand, FileCommand};
use sunroom::app::editor::commands::bare_world::bare_world;
use sunroom::app::editor::commands::scene_watch::follow_scene;
use sunroom::app::editor::commands::{apply, baking};
use sunroom::app::editor::picture::baking::{Baking, Work};
use sunroom::app::editor::picture::compare::Comparison;
use sunroom::app::editor::picture::paths::PathInspector;
use sunroom::app::editor::session::history::History;
use sunroom::app::editor::session::options::SceneDefines;
use sunroom::app::editor::session::recovery::Recovery;
use sunroom::app::editor::session::requests::Requests;
use sunroom::app::editor::session::toasts::Toasts;
use sunroom::app::editor::session::view_settings::ViewSettings;
use sunroom::engine::{EnginePlugin, PackedScene, RenderControl, RenderFilm, RenderState, RenderStatus};
use sunroom::scene::*;
use tempfile::TempDir;

/// No test takes so long, however busy the machine is.
const HANG: Duration = Duration::from_secs(600);

/// A floor below a lamp, a wall that leaves with `secret`, and a bulb; the camera has a seed of its own.
const SCENE: &str = r#"<scene version="3.0.0">
  <integrator type="path"><integer name="max_depth" value="4"/></integrator>
  <sensor type="perspective">
    <transform name="to_world"><lookat origin="0, 2, 5" target="0, 0.5, 0" up="0, 1, 0"/></transform>
    <film type="hdrfilm"><integer name="width" value="40"/><integer name="height" value="30"/></film>
    <sampler type="independent"><integer name="seed" value="7"/></sampler>
  </sensor>
  <shape type="rectangle" id="floor">
    <transform name="to_world"><scale value="4"/><rotate x="1" angle="-90"/></transform>
    <bsdf type="diffuse"><rgb name="reflectance" value="0.8, 0.7, 0.6"/></bsdf>
  </shape>
  <shape type="rectangle" id="lamp">
    <transform name="to_world"><rotate x="1" angle="90"/><translate y="3"/></transform>
    <emitter type="area"><rgb name="radiance" value="4, 4, 4"/></emitter>
  </shape>
  <emitter type="point" id="bulb"><point name="position" x="2" y="1" z="0"/><rgb name="intensity" value="3, 3, 3"/></emitter>
</scene>
"#;

const QUICK: BakeChoices = BakeChoices {
    texels_per_unit: Some(4.0),
    atlas_size: 64,
    samples: Some(16),
    time: None,
    noise: None,
    indirect_only: false,
    probes: false,
    denoise: false,
};

/// What the window has of scenes, of the engine and of bakes.
struct Window {
    app: App,
    folder: TempDir,
}

impl Window {
    fn new() -> Self {
        Self::with(SCENE)
    }

    fn with(scene: &str) -> Self {
        let folder = tempfile::tempdir().expect("a temporary folder");
        std::fs::write(folder.path().join("scene.xml"), scene).expect("a writable folder");
        let mut app = App::new();
        app.add_plugins((
            MinimalPlugins,
            FileSourcePlugin,
            asset_plugin(),
            ScenePlugin,
            EnginePlugin,
        ))
        .init_resource::<ViewSettings>()
        .init_resource::<Comparison>()
        .init_resource::<Requests>()
        .init_resource::<Toasts>()
        .init_resource::<SceneDefines>()
        .init_resource::<Selection>()
        .init_resource::<History>()
        .add_systems(Last, baking::follow);
        app.finish();
        app.cleanup();
        let mut window = Self { app, folder };
        let path = window.path("scene.xml");
        window.app.world_mut().write_message(OpenScene {
            path,
            ..OpenScene::default()
        });
        window.until("the scene", |world| {
            let status = world.resource::<SceneStatus>();
            let is_read = status.state == SceneState::Ready && status.files_loading() == 0;
            is_read && world.resource::<RenderStatus>().is_up_to_date
        });
        window
    }

    fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    #[track_caller]
    fn until(&mut self, what: &str, done: impl Fn(&World) -> bool) {
        let deadline = Instant::now() + HANG;
        while !done(self.app.world()) {
            assert!(Instant::now() < deadline, "not in time: {what}");
            std::thread::sleep(Duration::from_millis(5));
            self.app.update();
        }
    }

    fn say(&mut self, command: BakeCommand) -> Result<(), CommandError> {
        apply(self.app.world_mut(), Command::Bake(command))
    }

    #[track_caller]
    fn begin(&mut self, choices: BakeChoices, folder: &str) {
        let folder = self.path(folder);
        self.say(BakeCommand::Choose(choices)).expect("choices");
        self.say(BakeCommand::Begin(folder)).expect("a folder");
    }

    /// Waits for the end of the bake.
    #[track_caller]
    fn end(&mut self) {
        self.until("the bake", |world| !world.resource::<Baking>().is_busy());
    }

    fn failure(&self) -> Option<&str> {
        self.app.world().resource::<Baking>().failure.as_deref()
    }

    /// The failure that *Messages* shows.
    fn notice(&self) -> Option<&str> {
        self.app.world().resource::<Baking>().notice()
    }

    fn told(&self) -> String {
        let toasts = self.app.world().resource::<Toasts>();
        toasts.texts().collect::<Vec<_>>().join("\n")
    }

    /// The samples of each texel so far.
    fn samples(world: &World) -> u32 {
        let thread = world.resource::<Baking>().thread();
        let gathered = thread.and_then(|thread| thread.news().progress?.gathered);
        gathered.map_or(0, |gathered| gathered.samples)
    }
}

/// The files of a folder with their content.
fn files(folder: &Path) -> BTreeMap<String, Vec<u8>> {
    let entries = std::fs::read_dir(folder)
        .expect("the folder")
        .map(|entry| entry.expect("an entry").path());
    let name = |path: &Path| path.file_name().expect("a name").to_string_lossy().into_owned();
    entries
        .map(|path| (name(&path), std::fs::read(&path).expect("a file")))
        .collect()
}

/// What the command line bakes.
fn by_command_line(scene: &Path, folder: &Path, samples: u32, more: &[&str]) -> BTreeMap<String, Vec<u8>> {
    let mut command = Process::new(env!("CARGO_BIN_EXE_sunroom"));
    command.arg("bake").arg(scene).arg("-o").arg(folder).arg("--quiet");
    command.args([
        "--texels-per-unit",
        "4",
        "--atlas-size",
        "64",
        "--spp",
        samples.to_string().as_str(),
        "--no-denoise",
    ]);
    let output = command.args(more).output().expect("the program starts");
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    files(folder)
}

#[track_caller]
fn assert_same(found: &BTreeMap<String, Vec<u8>>, expected: &BTreeMap<String, Vec<u8>>) {
    assert!(
        found.keys().eq(expected.keys()),
        "{:?} {:?}",
        found.keys(),
        expected.keys()
    );
    for (name, content) in expected {
        assert!(found[name] == *content, "{name} is another file");
    }
}

#[test]
fn the_window_writes_the_files_of_the_command_line() {
    let mut window = Window::new();
    // What the window alone does is no part of a bake.
    let there = FreeView::at(bevy::math::Affine3A::from_translation(Vec3::new(0.3, 1.0, 2.0)));
    window.app.world_mut().insert_resource(there);
    window.begin(QUICK, "plain");
    window.end();
    assert_eq!(window.failure(), None);
    assert!(
        window.told().contains("The level with its lightmaps is in"),
        "{}",
        window.told()
    );
    let expected = by_command_line(&window.path("scene.xml"), &window.path("by-line"), 16, &["--no-probes"]);
    assert!(expected.len() >= 4, "{:?}", expected.keys());
    assert_same(&files(&window.path("plain")), &expected);
    // The panel has a picture of the lightmap.
    window.until("a picture", |world| {
        let thread = world.resource::<Baking>().thread();
        thread.is_some_and(|thread| thread.news().picture.is_some())
    });

    let choices = BakeChoices {
        indirect_only: true,
        probes: true,
        samples: Some(2),
        ..QUICK
    };
    window.begin(choices, "nested/indirect");
    window.end();
    assert_eq!(window.failure(), None);
    let folder = window.path("by-line-indirect");
    let expected = by_command_line(&window.path("scene.xml"), &folder, 2, &["--indirect-only"]);
    let found = files(&window.path("nested/indirect"));
    assert!(
        found.keys().any(|name| name.starts_with("irradiance-")),
        "{:?}",
        found.keys()
    );
    assert_same(&found, &expected);
}

#[test]
fn a_bake_that_is_stopped_writes_what_there_is() {
    let mut window = Window::new();
    let endless = BakeChoices {
        samples: Some(1 << 24),
        ..QUICK
    };
    window.begin(endless, "stopped");
    window.until("some samples", |world| Window::samples(world) > 0);
    // The picture in the panel grows with the samples.
    let image = |world: &World| {
        let thread = world.resource::<Baking>().thread();
        thread.and_then(|thread| Some(thread.news().picture?.image))
    };
    window.until("a picture", |world| image(world).is_some());
    for _ in 0..3 {
        let before = image(window.app.world()).expect("it is there");
        window.until("another picture", |world| {
            image(world).is_some_and(|now| now.pixels != before.pixels)
        });
    }
    let other = window.path("other");
    let refused = window
        .say(BakeCommand::Begin(other))
        .expect_err("one is under way")
        .to_string();
    assert!(refused.contains("still under way"), "{refused}");
    let has_come = |window: &Window, wait| has_come(window.app.world(), wait).expect("it has not failed");
    assert!(has_come(&window, BakeWait::Samples(1)));
    assert!(!has_come(&window, BakeWait::Samples(1 << 24)) && !has_come(&window, BakeWait::End));
    window.say(BakeCommand::Stop).expect("it is under way");
    window.end();
    assert!(has_come(&window, BakeWait::End));
    assert_eq!(window.failure(), None);
    let files = files(&window.path("stopped"));
    assert!(files.contains_key("lightmaps.json") && files.contains_key("lightmap-0.exr"));
    let about: serde_json::Value = serde_json::from_slice(&files["lightmaps.json"]).expect("JSON");
    let samples = about["samples"].as_u64().expect("a number");
    assert!(samples > 0 && samples < 1 << 24, "{samples}");
    assert!(window.told().contains("The bake was stopped"), "{}", window.told());
    assert!(!window.path("other").exists());
    window.say(BakeCommand::Close).expect("it has ended");
    assert!(window.app.world().resource::<Baking>().thread().is_none());
    assert!(window.say(BakeCommand::Stop).is_err());
}

#[test]
fn a_bake_that_is_stopped_leaves_a_level_with_more_samples_as_it_was() {
    let mut window = Window::new();
    window.begin(QUICK, "level");
    window.end();
    let manifest = window.path("level/lightmaps.json");
    let text = std::fs::read_to_string(&manifest).expect("it is written");
    let more = text.replace("\"samples\": 16", "\"samples\": 9000000");
    assert_ne!(text, more);
    std::fs::write(&manifest, more).expect("a writable folder");
    let before = files(&window.path("level"));
    let endless = BakeChoices {
        samples: Some(1 << 24),
        ..QUICK
    };
    window.begin(endless, "level");
    window.until("some samples", |world| Window::samples(world) > 0);
    let news = window.app.world().resource::<Baking>().thread().expect("a bake").news();
    assert_eq!(
        news.stays.map(|there| (there.samples, there.probes)),
        Some((9_000_000, 0))
    );
    window.say(BakeCommand::Stop).expect("it is under way");
    window.end();
    let said = window.failure().expect("nothing is written").to_owned();
    assert!(
        said.contains("level keeps its level, which has 9000000 samples per texel and 0 probes"),
        "{said}"
    );
    assert_same(&files(&window.path("level")), &before);
}

#[test]
fn nothing_is_left_of_a_bake_that_is_given_up() {
    let mut window = Window::new();
    let endless = BakeChoices {
        samples: Some(1 << 24),
        ..QUICK
    };
    window.begin(endless, "new/level");
    window.until("some samples", |world| Window::samples(world) > 0);
    assert!(window.path("new/level").is_dir());
    window.say(BakeCommand::Discard).expect("it is under way");
    // Another one in the same folder waits until the first has left it.
    window.begin(QUICK, "new/level");
    let baking = |window: &Window| {
        let baking = window.app.world().resource::<Baking>();
        (matches!(baking.work, Work::Waiting(_)), baking.ending.len())
    };
    assert_eq!(baking(&window), (true, 1));
    window.until("the other bake", |world| world.resource::<Baking>().thread().is_some());
    assert_eq!(baking(&window), (false, 0));
    window.end();
    assert_eq!(window.failure(), None);
    assert!(window.path("new/level/lightmaps.json").is_file());

    window.begin(endless, "second/level");
    window.until("some samples", |world| Window::samples(world) > 0);
    baking::end_at_exit(window.app.world_mut());
    assert!(!window.path("second").exists());
    // What was there stays.
    std::fs::create_dir(window.path("own")).expect("a folder");
    window.begin(endless, "own");
    window.until("some samples", |world| Window::samples(world) > 0);
    window.say(BakeCommand::Discard).expect("it is under way");
    baking::end_at_exit(window.app.world_mut());
    assert!(files(&window.path("own")).is_empty());
}

#[test]
fn a_bad_folder_and_a_bad_scene_are_told() {
    let mut window = Window::new();
    let scene = window.path("scene.xml");
    let error = window
        .say(BakeCommand::Begin(scene.clone()))
        .expect_err("it is a file")
        .to_string();
    let output = Process::new(env!("CARGO_BIN_EXE_sunroom"))
        .arg("bake")
        .arg(&scene)
        .arg("-o")
        .arg(&scene)
        .output()
        .expect("the program starts");
    let said = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(
        error.contains("is a file: a bake needs a folder") && said.contains(&error),
        "{error} {said}"
    );
    assert!(!window.app.world().resource::<Baking>().is_busy());
    assert_eq!(window.failure(), Some(error.as_str()));

    // The floor has 8 units along a side.
    let fine = BakeChoices {
        texels_per_unit: Some(100.0),
        ..QUICK
    };
    window.begin(fine, "failed");
    window.end();
    let reason = window.failure().expect("it fails").to_owned();
    let is_told = reason.starts_with("The scene is not baked: `floor` needs") && window.told().contains(&reason);
    assert!(is_told && reason.contains("7.5 texels per unit"), "{reason}");
    assert_eq!(window.notice(), Some(&*reason));
    baking::end_at_exit(window.app.world_mut());
    assert!(!window.path("failed").exists());
    // The next bake that begins is another matter, and so is another scene.
    window.begin(QUICK, "level");
    assert_eq!(window.notice(), None);
    window.end();
    window.begin(fine, "failed");
    window.end();
    assert!(window.notice().is_some());
    apply(window.app.world_mut(), FileCommand::OpenScene(scene)).expect("a scene");
    assert_eq!(window.notice(), None);
}

#[test]
fn a_bake_that_fails_takes_its_preview_away() {
    let mut window = Window::new();
    let compare = Command::from(DisplayCommand::SetCompareView(CompareView::Baked(0.5)));
    let coarse = BakeChoices {
        texels_per_unit: Some(1e9),
        ..QUICK
    };
    window.begin(QUICK, "level");
    apply(window.app.world_mut(), compare.clone()).expect("it is allowed");
    window.end();
    window.until("the lit level", |world| world.resource::<Comparison>().baked.is_some());
    window.begin(coarse, "failed");
    // What the bake before has left is no picture of this one.
    let comparison = |window: &Window| window.app.world().resource::<Comparison>().clone();
    assert!(comparison(&window).baked.is_none());
    assert_eq!(comparison(&window).view, CompareView::Baked(0.5));
    window.end();
    assert!(window.failure().is_some());
    assert!(comparison(&window).baked.is_none());
    assert_eq!(comparison(&window).view, CompareView::Off);

    // One that cannot even begin.
    window.begin(QUICK, "level");
    apply(window.app.world_mut(), compare).expect("it is allowed");
    window.app.world_mut().resource_mut::<PackedScene>().scene = None;
    window.end();
    let reason = window.failure().expect("it fails");
    assert!(reason.contains("There is nothing to bake"), "{reason}");
    assert_eq!(comparison(&window).view, CompareView::Off);
}

#[test]
fn a_bake_that_waits_is_of_no_other_scene() {
    let mut window = Window::new();
    let other = window.path("other.xml");
    std::fs::write(&other, SCENE).expect("a writable folder");
    window.begin(QUICK, "new/level");
    apply(window.app.world_mut(), FileCommand::OpenScene(other)).expect("a scene");
    assert!(!window.app.world().resource::<Baking>().is_busy());
    let reason = window.failure().expect("it is given up");
    assert!(reason.contains("another scene was opened"), "{reason}");
    assert_eq!(window.notice(), None);
    assert!(!window.path("new").exists());
}

#[test]
fn a_failure_is_no_matter_of_a_scene_that_was_opened_meanwhile() {
    let mut window = Window::new();
    let other = window.path("other.xml");
    std::fs::write(&other, SCENE).expect("a writable folder");
    let fine = BakeChoices {
        texels_per_unit: Some(100.0),
        ..QUICK
    };
    window.begin(fine, "failed");
    window.until("the bake", |world| world.resource::<Baking>().thread().is_some());
    apply(window.app.world_mut(), FileCommand::OpenScene(other)).expect("a scene");
    window.end();
    let reason = window.failure().expect("it fails");
    assert!(window.told().contains(reason), "{reason}");
    assert_eq!(window.notice(), None);
}

#[test]
fn an_edit_leaves_the_level_of_the_bake_as_it_was() {
    let mut window = Window::new();
    let endless = BakeChoices {
        samples: Some(1 << 24),
        ..QUICK
    };
    window.begin(endless, "level");
    let compare = Command::from(DisplayCommand::SetCompareView(CompareView::Baked(0.5)));
    apply(window.app.world_mut(), compare).expect("it is allowed");
    let lit = |world: &World| {
        let camera = world.resource::<PackedScene>().view.as_ref().map(|view| view.camera)?;
        let comparison = world.resource::<Comparison>();
        let seen = comparison.other(Some(&camera))?;
        let floor = seen.radiance[seen.radiance.len() / 3 * 2..]
            .iter()
            .copied()
            .sum::<Vec3>();
        (seen.samples > 0).then_some((seen.samples, floor))
    };
    window.until("the lit level", |world| lit(world).is_some());
    let (before, bright) = lit(window.app.world()).expect("it is there");
    // The lamp, the bulb and the floor go.
    let world = window.app.world_mut();
    let things: Vec<Entity> = world
        .query_filtered::<Entity, With<ToWorld>>()
        .iter(world)
        .filter(|thing| {
            world
                .get::<Name>(*thing)
                .is_some_and(|name| ["lamp", "floor"].contains(&name.as_str()))
        })
        .collect();
    assert_eq!(things.len(), 2);
    for thing in things {
        world.despawn(thing);
    }
    window.until("the edit", |world| {
        world.resource::<RenderStatus>().is_up_to_date
            && world
                .resource::<RenderFilm>()
                .film
                .radiance()
                .iter()
                .all(|pixel| *pixel == Vec3::ZERO)
    });
    window.until("more samples", |world| lit(world).is_some_and(|(now, _)| now > before));
    let (_, after) = lit(window.app.world()).expect("it is there");
    assert!((after / bright - 1.0).abs().max_element() < 0.2, "{bright} {after}");
    window.say(BakeCommand::Discard).expect("it is under way");
    baking::end_at_exit(window.app.world_mut());
    assert!(!window.path("level").exists());
}

#[test]
fn the_level_by_its_lightmaps_is_as_bright_as_the_true_picture() {
    let mut window = Window::new();
    window.app.world_mut().resource_mut::<RenderControl>().target_samples = Some(64);
    window.begin(QUICK, "level");
    let compare = Command::from(DisplayCommand::SetCompareView(CompareView::Baked(0.5)));
    apply(window.app.world_mut(), compare).expect("it is allowed");
    window.app.update();
    // A script that saves the picture now waits for it, and then for the finished lightmaps.
    assert!(!is_lit_level_seen(window.app.world()));
    window.end();
    assert!(has_come(window.app.world(), BakeWait::Samples(16)).expect("it has not failed"));
    let is_finished = |world: &World| {
        world
            .resource::<Comparison>()
            .baked
            .as_ref()
            .is_some_and(|lit| lit.is_finished)
    };
    assert_eq!(is_lit_level_seen(window.app.world()), is_finished(window.app.world()));
    window.until("the lit level", is_lit_level_seen);
    assert!(is_finished(window.app.world()));
    let samples = |world: &World| {
        let baked = world.resource::<Comparison>().baked.as_ref()?;
        Some(baked.picture.samples)
    };
    window.until("the finished lightmaps", |world| {
        let status = world.resource::<RenderStatus>();
        samples(world) == Some(16) && status.state == RenderState::Done && status.is_up_to_date
    });
    let world = window.app.world();
    let comparison = world.resource::<Comparison>();
    let camera = world.resource::<PackedScene>().view.as_ref().map(|view| view.camera);
    let lit = comparison.other(camera.as_ref()).expect("it is of this view");
    let film = &world.resource::<RenderFilm>().film;
    assert_eq!(lit.size, [film.width(), film.height()]);
    let truth = film.radiance();
    // The lower third of the picture is floor alone.
    let rows = lit.radiance.len() / 3 * 2..;
    let mean = |pixels: &[Vec3]| pixels[rows.clone()].iter().copied().sum::<Vec3>();
    let ratio = mean(&lit.radiance) / mean(&truth);
    assert!((ratio - 1.0).abs().max_element() < 0.03, "{ratio}");
    // Nothing is beside the floor, and the lamp shines downwards.
    assert!(truth[0] == Vec3::ZERO && lit.radiance[0] == Vec3::ZERO);
    // From somewhere else it is seen once that is looked at.
    let there = FreeView::at(bevy::math::Affine3A::from_rotation_translation(
        Quat::from_rotation_y(std::f32::consts::PI),
        Vec3::new(0.0, 1.0, 4.0),
    ));
    window.app.world_mut().insert_resource(there);
    window.app.update();
    let is_seen = |world: &World| {
        let camera = world.resource::<PackedScene>().view.as_ref().map(|view| view.camera);
        camera.is_some_and(|camera| world.resource::<Comparison>().other(Some(&camera)).is_some())
    };
    window.until("the other view", is_seen);
    window.say(BakeCommand::Close).expect("it has ended");
    let comparison = window.app.world().resource::<Comparison>();
    assert!(comparison.baked.is_none() && comparison.view == CompareView::Off);
}

#[test]
fn glass_and_mirrors_show_lightmaps_behind_them_and_in_them() {
    let more = r#"
  <shape type="rectangle" id="pane">
    <transform name="to_world"><scale x="0.6" y="3" z="1"/><translate x="-1" y="0" z="3.5"/></transform>
    <bsdf type="thindielectric"><rgb name="specular_transmittance" value="1, 0.5, 0.5"/></bsdf>
  </shape>
  <shape type="rectangle" id="mirror">
    <transform name="to_world"><scale x="1.2" y="1" z="1"/><translate x="0.8" y="1" z="1"/></transform>
    <bsdf type="conductor"><string name="material" value="none"/></bsdf>
  </shape>
</scene>"#;
    let mut window = Window::with(&SCENE.replace("</scene>", more));
    window.app.world_mut().resource_mut::<RenderControl>().target_samples = Some(64);
    window.begin(QUICK, "level");
    apply(
        window.app.world_mut(),
        DisplayCommand::SetCompareView(CompareView::Baked(0.5)),
    )
    .expect("it is allowed");
    window.end();
    window.until("the finished lightmaps", |world| {
        let status = world.resource::<RenderStatus>();
        is_lit_level_seen(world) && status.state == RenderState::Done && status.is_up_to_date
    });
    let world = window.app.world();
    let camera = world.resource::<PackedScene>().view.as_ref().map(|view| view.camera);
    let lit = world
        .resource::<Comparison>()
        .other(camera.as_ref())
        .expect("it is of this view");
    let film = &world.resource::<RenderFilm>().film;
    let truth = film.radiance();
    // The means over a few pixels around a place of the picture.
    let mean = |pixels: &[Vec3], [x, y]: [f32; 2]| {
        let (width, height) = (film.width() as i32, film.height() as i32);
        let [column, row] = [(x * width as f32) as i32, (y * height as f32) as i32];
        let around = (-2..=2).flat_map(|down| (-2..=2).map(move |across| (row + down) * width + column + across));
        around.map(|index| pixels[index as usize]).sum::<Vec3>() / 25.0
    };
    for (what, place) in [("through the pane", [0.05, 0.8]), ("in the mirror", [0.6, 0.5])] {
        let (seen, traced) = (mean(&lit.radiance, place), mean(&truth, place));
        assert!(traced.min_element() > 0.01, "{what}: {traced}");
        // What is seen through the pane has its color.
        assert_eq!(
            traced.x > 1.5 * traced.y,
            what == "through the pane",
            "{what}: {traced}"
        );
        // The pane reflects a tenth of the light.
        let ratio = seen / traced;
        assert!((ratio - 1.0).abs().max_element() < 0.2, "{what}: {seen} {traced}");
    }
}

#[test]
fn lines_say_how_lightmaps_are_baked_and_what_is_waited_for() {
    let mut world = World::new();
    let choose = |world: &mut World, text: &str| {
        let step = line(world, text).expect("a good line").expect("it says something");
        let Step::Do(Command::Bake(BakeCommand::Choose(choices))) = step else {
            panic!("{step:?}");
        };
        world.get_resource_or_init::<BakePlan>().choices = choices;
        choices
    };
    let first = choose(
        &mut world,
        "bake-with texels-per-unit=8 page-size=256 samples=16 light=indirect",
    );
    let expected = BakeChoices {
        texels_per_unit: Some(8.0),
        atlas_size: 256,
        samples: Some(16),
        indirect_only: true,
        ..BakeChoices::default()
    };
    assert_eq!(first, expected);
    // What is not named stays.
    let second = choose(
        &mut world,
        "bake-with samples=none time=2 noise=0.02 probes=off denoise=off",
    );
    let expected = BakeChoices {
        samples: None,
        time: Some(2.0),
        noise: Some(0.02),
        probes: false,
        denoise: false,
        ..first
    };
    assert_eq!(second, expected);

    let step = |world: &mut World, text: &str| line(world, text).expect("a good line");
    assert!(matches!(step(&mut world, "bake-to level"), Some(Step::Bake(folder)) if folder.ends_with("level")));
    let begins = step(&mut world, "begin-bake level");
    assert!(
        matches!(begins, Some(Step::Do(Command::Bake(BakeCommand::Begin(_))))),
        "{begins:?}"
    );
    let waits = step(&mut world, "wait-for-bake 8");
    assert!(
        matches!(waits, Some(Step::AwaitBake(BakeWait::Samples(8)))),
        "{waits:?}"
    );
    let waits = step(&mut world, "wait-for-bake done");
    assert!(matches!(waits, Some(Step::AwaitBake(BakeWait::End))), "{waits:?}");
    let shows = step(&mut world, "show-lightmap 2");
    assert!(
        matches!(shows, Some(Step::Do(Command::Bake(BakeCommand::ShowPage(2))))),
        "{shows:?}"
    );
    for wrong in [
        "bake-with",
        "bake-with samples",
        "bake-with page-size=1",
        "bake-with noise=2",
        "bake-with light=none",
        "bake-to",
        "wait-for-bake soon",
        "show-lightmap -1",
    ] {
        assert!(line(&mut world, wrong).is_err(), "{wrong}");
    }
}

#[test]
fn a_bake_that_has_failed_ends_the_wait_with_its_reason() {
    let mut world = World::new();
    assert!(has_come(&world, BakeWait::End).expect("nothing has failed"));
    world.insert_resource(Baking {
        failure: Some("no room".to_owned()),
        ..Baking::default()
    });
    let error = has_come(&world, BakeWait::End).expect_err("it has failed");
    assert_eq!(error.to_string(), "no room");
    assert!(is_lit_level_seen(&world));
    world.insert_resource(Comparison {
        view: CompareView::Baked(0.5),
        ..Comparison::default()
    });
    assert!(is_lit_level_seen(&world), "there is no bake");
}

#[test]
fn the_lightmaps_of_another_scene_are_not_shown_beside_the_picture() {
    let mut window = Window::new();
    let other = window.path("other.xml");
    std::fs::write(&other, SCENE).expect("a writable folder");
    let compare = Command::from(DisplayCommand::SetCompareView(CompareView::Baked(0.5)));
    window.begin(QUICK, "level");
    apply(window.app.world_mut(), compare.clone()).expect("it is of this scene");
    window.end();
    apply(window.app.world_mut(), FileCommand::OpenScene(other)).expect("a scene");
    let refusal = apply(window.app.world_mut(), compare).expect_err("it is of another scene");
    assert!(refusal.to_string().contains("was open when it began"), "{refusal}");
}

#[test]
fn another_scene_ends_the_comparison_and_a_reload_does_not() {
    let mut world = bare_world();
    world.init_resource::<PathInspector>();
    world.insert_resource(Recovery::new(None));
    world.insert_resource(Comparison {
        view: CompareView::Baked(0.5),
        ..Comparison::default()
    });
    let follow = world.register_system(follow_scene);
    for (fresh_load, expected) in [(false, CompareView::Baked(0.5)), (true, CompareView::Off)] {
        let mut status = world.resource_mut::<SceneStatus>();
        status.revision += 1;
        (status.state, status.fresh_load) = (SceneState::Ready, fresh_load);
        world.run_system(follow).expect("all resources are there");
        assert_eq!(world.resource::<Comparison>().view, expected);
    }
}
