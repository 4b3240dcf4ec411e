//! Files outside the folder of a scene in the window: when the user is asked, what an answer allows, and that no edit
//! is lost by it.

use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use bevy::math::{Affine3A, Vec3A};
use bevy::prelude::*;
use sunroom::app::editor::command::error::CommandError;
use sunroom::app::editor::command::file_access::Question;
use sunroom::app::editor::command::light_mix::{FilmLights, LightMix};
use sunroom::app::editor::command::recovery_offer::{Note, Offer};
use sunroom::app::editor::command::selection::Selection;
use sunroom::app::editor::command::{Command, FileCommand, SceneEdit, ShellCommand};
use sunroom::app::editor::commands::apply;
use sunroom::app::editor::commands::scene_watch;
use sunroom::app::editor::picture::paths::PathInspector;
use sunroom::app::editor::session::history::History;
use sunroom::app::editor::session::options;
use sunroom::app::editor::session::recovery::{self, Recovery};
use sunroom::app::editor::session::requests::{CommandQueue, Requests};
use sunroom::app::editor::session::toasts::Toasts;
use sunroom::app::editor::session::trust::{TrustedFolders, follow_access};
use sunroom::app::editor::session::view_settings::ViewSettings;
use sunroom::engine::{PackedScene, RenderControl, RenderFilm};
use sunroom::scene::write::{self, SaveError};
use sunroom::scene::*;
use tempfile::TempDir;

/// No test takes so long, however busy the machine is.
const HANG: Duration = Duration::from_secs(600);
const MESH: &str = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";
const MORE: &str = "<scene version='3.0.0'><shape type='sphere' id='more'/></scene>";

fn scene(content: &str) -> String {
    format!(
        "<scene version='3.0.0'>\n  <sensor type='perspective'/>\n  <shape type='sphere' id='ball'/>\n  {content}\n</scene>\n"
    )
}

fn mesh(name: &str) -> String {
    scene(&format!(
        "<shape type='obj' id='mesh'><string name='filename' value='{name}'/></shape>"
    ))
}

/// What the window has of scenes and of trust. The settings are in the folder `settings`.
struct Window {
    app: App,
    folder: TempDir,
}

impl Window {
    fn new(files: &[(&str, &str)]) -> Self {
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
            .insert_resource(options::SceneDefines(Vec::new()))
            .init_resource::<PathInspector>()
            .add_systems(
                PreUpdate,
                (follow_access, recovery::follow_scene, scene_watch::follow_scene)
                    .chain()
                    .after(SceneSystems::Follow),
            );
        let settings = folder.path().join("settings");
        let (trusted, trust) = TrustedFolders::open(Some(&settings));
        app.insert_resource(trusted)
            .insert_resource(trust)
            .insert_resource(Recovery::new(Some(&settings)));
        app.finish();
        app.cleanup();
        let window = Self { app, folder };
        for (name, text) in files {
            window.write(name, text);
        }
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

    /// Reads the scene, with all that it names.
    fn open(&mut self, name: &str, keeps_edits: bool) {
        let path = self.path(name);
        let before = (self.status().revision, self.status().failures);
        self.app.world_mut().write_message(OpenScene {
            path,
            keeps_edits,
            ..OpenScene::default()
        });
        self.until("the scene", |world| {
            let status = world.resource::<SceneStatus>();
            (status.revision, status.failures) != before && status.files_loading() == 0
        });
        // What was refused is asked about in the frame after.
        self.app.update();
    }

    fn status(&self) -> &SceneStatus {
        self.app.world().resource::<SceneStatus>()
    }

    fn trusted(&self) -> &TrustedFolders {
        self.app.world().resource::<TrustedFolders>()
    }

    #[track_caller]
    fn question(&self) -> Question {
        self.trusted().question.clone().expect("the user is asked")
    }

    /// The user says that the files are to be read.
    #[track_caller]
    fn allow(&mut self) {
        let question = self.question();
        self.app.world_mut().resource_mut::<TrustedFolders>().question = None;
        self.apply(ShellCommand::AllowFiles(question)).expect("it can be done");
    }

    fn apply(&mut self, command: impl Into<Command>) -> Result<(), CommandError> {
        apply(self.app.world_mut(), command)
    }

    fn by_id(&mut self, id: &str) -> Option<Entity> {
        let world = self.app.world_mut();
        let mut all = world.query::<(Entity, &SceneId)>();
        all.iter(world)
            .find(|(_, found)| found.0 == id)
            .map(|(entity, _)| entity)
    }

    fn move_ball(&mut self) {
        let ball = self.by_id("ball").expect("there is a ball");
        let moved = ToWorld(Affine3A::from_translation(Vec3::X));
        self.app.world_mut().entity_mut(ball).insert(moved);
        self.app.world_mut().resource_mut::<History>().note_unsaved();
    }

    fn ball_is_moved(&mut self) -> bool {
        let ball = self.by_id("ball").expect("there is a ball");
        self.app
            .world()
            .get::<ToWorld>(ball)
            .expect("it has a place")
            .0
            .translation
            == Vec3A::X
    }

    fn has_mesh(&mut self) -> bool {
        let handle = self
            .by_id("mesh")
            .and_then(|mesh| self.app.world().get::<MeshHandle>(mesh));
        handle.is_some_and(|handle| self.app.world().resource::<Assets<TriangleMesh>>().contains(&handle.0))
    }
}

#[test]
fn edits_stay_when_an_include_is_allowed() {
    let mut window = Window::new(&[("scene/a.xml", &scene("")), ("outside/more.xml", MORE)]);
    window.open("scene/a.xml", false);
    window.move_ball();
    window.write("scene/a.xml", &scene("<include filename='../outside/more.xml'/>"));
    window.open("scene/a.xml", true);
    assert_eq!(window.status().state, SceneState::Failed);
    assert_eq!(
        window.question(),
        Question {
            files: vec![window.path("scene/../outside/more.xml")],
            shown: vec![window.path("outside/more.xml")],
            folders: vec![window.path("outside")],
            is_needed: true,
            edit: None,
        }
    );
    window.allow();
    window.until("the include", |world| world.resource::<SceneStatus>().revision >= 2);
    assert!(!window.status().fresh_load && window.ball_is_moved());
    assert!(window.by_id("more").is_some());
    assert_eq!(window.trusted().opens, None);
    assert_eq!(
        window.app.world().resource::<SceneAccess>().refused(),
        [] as [PathBuf; 0]
    );
}

/// A recovered scene is in no file: what it was in must not be opened in its place.
#[test]
fn a_recovered_scene_stays_when_its_files_are_allowed() {
    let mut window = Window::new(&[("scene/a.xml", &scene("")), ("outside/mesh.obj", MESH)]);
    let aside = "settings/recovery/left-over";
    let moved = mesh(&window.path("outside/mesh.obj").display().to_string()).replace(
        "id='ball'/>",
        "id='ball'><transform name='to_world'><translate x='1'/></transform></shape>",
    );
    window.write(&format!("{aside}/scene.xml"), &moved);
    let note = Note {
        scene: Some(window.path("scene/a.xml")),
        time: 1,
        ..Note::default()
    };
    let folder = window.path(aside);
    window.write(
        &format!("{aside}/about.json"),
        &serde_json::to_string(&note).expect("plain data"),
    );
    let offer = Offer {
        folder,
        note,
        ..Offer::default()
    };
    recovery::recover(window.app.world_mut(), offer).expect("it is there");
    window.until("the recovered scene", |world| {
        let status = world.resource::<SceneStatus>();
        status.revision == 1 && status.files_loading() == 0
    });
    window.app.update();
    assert!(window.ball_is_moved() && !window.has_mesh());
    window.allow();
    window.until("the mesh", |world| {
        world.resource::<SceneStatus>().mesh_errors.is_empty()
    });
    // Time enough to begin to read another scene.
    (0..20).for_each(|_| window.app.update());
    assert_eq!(
        (window.status().revision, window.status().state),
        (1, SceneState::Ready)
    );
    assert!(window.ball_is_moved() && window.has_mesh());
    assert!(window.path(aside).join("scene.xml").is_file());
}

/// Opening it would lose the edits of the one that is open, so that is left to those who ask about these.
#[test]
fn another_scene_is_opened_by_way_of_the_question_about_edits() {
    let include = scene("<include filename='../outside/more.xml'/>");
    let mut window = Window::new(&[
        ("scene/a.xml", &scene("")),
        ("other/b.xml", &include),
        ("outside/more.xml", MORE),
    ]);
    window.open("scene/a.xml", false);
    window.move_ball();
    window.open("other/b.xml", false);
    assert_eq!(window.status().state, SceneState::Failed);
    window.allow();
    (0..20).for_each(|_| window.app.update());
    assert_eq!((window.status().revision, window.ball_is_moved()), (1, true));
    assert_eq!(window.trusted().opens, Some(window.path("other/b.xml")));
}

#[test]
fn the_open_scene_may_read_its_files_after_another_could_not_be_read() {
    let mut window = Window::new(&[
        ("scene/a.xml", &mesh("mesh.obj")),
        ("scene/mesh.obj", MESH),
        ("other/b.xml", "<scene version='3.0.0'><shape"),
    ]);
    window.open("scene/a.xml", false);
    assert!(window.has_mesh());
    window.open("other/b.xml", false);
    assert_eq!(window.status().state, SceneState::Failed);
    window.write("scene/picture.pfm", "no picture");
    window.write("scene/more.xml", MORE);
    let texture = "<texture name='reflectance' type='bitmap'><string name='filename' value='picture.pfm'/></texture>";
    let content = format!("<include filename='more.xml'/><bsdf type='diffuse'>{texture}</bsdf>");
    // As if the watch had noticed the change.
    window.write("scene/a.xml", &scene(&content));
    let path = window.path("scene/a.xml");
    window.app.world().resource::<AssetServer>().reload(path);
    window.until("the change", |world| {
        let status = world.resource::<SceneStatus>();
        status.revision >= 2 && status.files_loading() == 0
    });
    assert!(window.by_id("more").is_some());
    let problems = &window.status().damaged_pictures;
    assert!(!problems[0].message.contains("outside"), "{problems:?}");
    assert_eq!(window.trusted().question, None);
}

#[test]
fn nobody_is_asked_about_a_scene_that_has_its_files_beside_it() {
    let mut window = Window::new(&[
        ("scene/a.xml", &mesh("mesh.obj")),
        ("scene/mesh.obj", MESH),
        ("scene/nothing.xml", &mesh("../outside/nothing.obj")),
        ("scene/c.xml", &mesh("c.obj")),
        ("assets/mesh.obj", MESH),
        ("assets/c.obj", MESH),
    ]);
    window.open("scene/a.xml", false);
    assert!(window.has_mesh());
    assert_eq!(window.trusted().question, None);
    // Nor about what is not there at all.
    window.open("scene/nothing.xml", false);
    assert!(!window.has_mesh());
    assert_eq!(window.trusted().question, None);
    // It is elsewhere only.
    window.open("scene/c.xml", false);
    let asked = window.question();
    assert_eq!(asked.files, [window.path("assets/c.obj")]);
    assert_eq!(asked.folders, [window.path("assets")]);
}

#[test]
fn only_what_is_needed_is_allowed() {
    let mut window = Window::new(&[
        (
            "project/scene/a.xml",
            &scene("<path value='../lib'/><path value='../lib/inner'/><path value='../nowhere'/>"),
        ),
        ("project/lib/inner/mesh.obj", MESH),
    ]);
    window.open("project/scene/a.xml", false);
    assert_eq!(window.question().folders, [window.path("project/lib")]);
    #[cfg(unix)]
    {
        let link = window.path("project/scene/link.obj");
        std::os::unix::fs::symlink(window.path("project/lib/inner/mesh.obj"), link).expect("a link");
        window.write("project/scene/b.xml", &mesh("link.obj"));
        window.open("project/scene/b.xml", false);
        assert_eq!(window.question().folders, [window.path("project/lib/inner")]);
        window.allow();
        window.until("the mesh", |world| {
            let status = world.resource::<SceneStatus>();
            status.revision == 2 && status.is_complete()
        });
        assert!(window.has_mesh());
    }
}

#[cfg(unix)]
#[test]
fn what_a_link_outside_leads_to_can_be_allowed() {
    let mut window = Window::new(&[
        ("scene/a.xml", &mesh("../way/mesh.obj")),
        ("elsewhere/deep/mesh.obj", MESH),
    ]);
    std::os::unix::fs::symlink("elsewhere/deep", window.path("way")).expect("a link");
    window.open("scene/a.xml", false);
    assert_eq!(window.question().folders, [window.path("elsewhere/deep")]);
    window.allow();
    window.until("the mesh", |world| {
        let status = world.resource::<SceneStatus>();
        status.revision == 2 && status.is_complete()
    });
    assert!(window.has_mesh());
    assert_eq!(window.trusted().question, None);
}

#[cfg(unix)]
#[test]
fn the_folder_of_a_link_is_not_allowed_with_the_link() {
    let mut window = Window::new(&[
        ("scene/a.xml", &mesh("../home/link.obj")),
        ("elsewhere/mesh.obj", MESH),
        ("home/secret", ""),
    ]);
    std::os::unix::fs::symlink("../elsewhere/mesh.obj", window.path("home/link.obj")).expect("a link");
    window.open("scene/a.xml", false);
    assert_eq!(window.question().folders, [window.path("elsewhere")]);
    window.allow();
    window.until("the mesh", |world| {
        let status = world.resource::<SceneStatus>();
        status.revision == 2 && status.is_complete()
    });
    assert!(window.has_mesh());
    let (_, trust) = TrustedFolders::open(Some(&window.path("settings")));
    let access = trust.access(Path::new(""));
    for (name, is_allowed) in [
        ("home/link.obj", true),
        ("elsewhere/mesh.obj", true),
        ("home/secret", false),
    ] {
        assert_eq!(access.covers(&window.path(name)), is_allowed, "{name}");
    }
}

#[test]
fn what_was_allowed_and_read_is_said() {
    let mut window = Window::new(&[
        ("scene/a.xml", &mesh("../scene/../outside/mesh.obj")),
        ("outside/mesh.obj", MESH),
    ]);
    window.open("scene/a.xml", false);
    let question = window.question();
    assert!(!question.is_needed);
    assert_eq!(question.shown, [window.path("outside/mesh.obj")]);
    window.allow();
    window.until("the mesh", |world| world.resource::<SceneStatus>().revision == 2);
    window.app.update();
    let said: Vec<&str> = window.app.world().resource::<Toasts>().texts().collect();
    assert!(said.contains(&"Read mesh.obj"), "{said:?}");
    assert!(!said.iter().any(|text| text.contains("nothing new")), "{said:?}");
}

#[test]
fn the_question_tells_of_a_scene_that_cannot_be_shown_without_the_files() {
    let part = "<scene version='3.0.0'><bsdf type='diffuse' id='red'/></scene>";
    let mut window = Window::new(&[
        (
            "scene/b.xml",
            &scene("<include filename='deep/../../outside/part.xml'/>"),
        ),
        ("scene/deep/file", ""),
        ("outside/part.xml", part),
    ]);
    window.open("scene/b.xml", false);
    window.app.update();
    let question = window.question();
    assert!(question.is_needed);
    assert_eq!(question.shown, [window.path("outside/part.xml")]);
}

#[test]
fn who_leaves_a_file_out_is_asked_about_others_only() {
    let mut window = Window::new(&[
        ("scene/a.xml", &mesh("../outside/mesh.obj")),
        ("outside/mesh.obj", MESH),
    ]);
    window.write("else/where.obj", MESH);
    window.open("scene/a.xml", false);
    window.app.world_mut().resource_mut::<TrustedFolders>().question = None;
    let other = window.path("else/where.obj");
    window.app.world().resource::<SceneAccess>().get().permits(&other);
    window.app.update();
    assert_eq!(window.question().files, [other]);
}

#[test]
fn chosen_files_are_not_asked_about_when_the_scene_is_read_again() {
    let mut window = Window::new(&[
        ("scene/a.xml", &scene("")),
        ("models/mesh.obj", MESH),
        ("pictures/sky.pfm", "no picture"),
        ("pictures/private.txt", ""),
    ]);
    #[cfg(unix)]
    std::os::unix::fs::symlink("sky.pfm", window.path("pictures/link.pfm")).expect("a link");
    window.open("scene/a.xml", false);
    let pictures: &[&str] = match cfg!(unix) {
        true => &["pictures/sky.pfm", "pictures/link.pfm"],
        false => &["pictures/sky.pfm"],
    };
    for name in ["models/mesh.obj"].iter().chain(pictures) {
        let path = window.path(name);
        window.apply(SceneEdit::Import(path)).expect("it can be imported");
    }
    let path = window.path("scene/a.xml");
    write::save(window.app.world_mut(), &path).expect("it can be saved");
    window.open("scene/a.xml", false);
    assert!(window.has_mesh());
    let problems = &window.status().damaged_pictures;
    assert!(
        problems.len() == 1 && !problems[0].message.contains("outside"),
        "{problems:?}"
    );
    assert_eq!(window.trusted().question, None);
    // The next run knows them as well: the mesh with what may lie beside it, of the picture nothing else.
    let (_, trust) = TrustedFolders::open(Some(&window.path("settings")));
    let access = trust.access(Path::new(""));
    for (name, is_allowed) in [
        ("models/library.mtl", true),
        ("pictures/sky.pfm", true),
        (pictures[pictures.len() - 1], true),
        ("pictures/private.txt", false),
        ("scene/a.xml", false),
    ] {
        assert_eq!(access.covers(&window.path(name)), is_allowed, "{name}");
    }
}

#[test]
fn saving_and_pasting_read_nothing_outside() {
    let mut window = Window::new(&[("scene/a.xml", &scene("")), ("outside/more.xml", MORE)]);
    window.write("outside/values.spd", "400 0.5\n700 0.5\n");
    window.open("scene/a.xml", false);
    window.move_ball();
    let spectrum = window.path("outside/values.spd");
    let spectrum = format!(
        "<bsdf type='diffuse'><spectrum name='reflectance' filename='{}'/></bsdf>",
        spectrum.display()
    );
    let said = window
        .apply(SceneEdit::Paste(spectrum))
        .expect_err("it is refused")
        .to_string();
    assert!(said.contains("outside the scene's folder"), "{said}");
    window.app.update();
    assert_eq!(window.question().folders, [window.path("outside")]);
    // The watch might be first: what it reads waits.
    window.app.world_mut().resource_mut::<SceneFile>().hold(true);
    window.write("scene/a.xml", &scene("<include filename='../outside/more.xml'/>"));
    let path = window.path("scene/a.xml");
    match write::save(window.app.world_mut(), &path) {
        Err(SaveError::Broken { reason, .. }) => assert!(reason.contains("outside the scene's folder"), "{reason}"),
        other => panic!("{other:?}"),
    }
    assert_eq!(window.by_id("more"), None);
}

/// Scenes that have no file, as that of a window without one, may read no more than others.
#[test]
fn a_scene_without_a_file_has_no_folder_of_its_own() {
    let mut window = Window::new(&[("scene/a.xml", &mesh("mesh.obj")), ("scene/mesh.obj", MESH)]);
    window.open("scene/a.xml", false);
    window.apply(FileCommand::NewScene).expect("it can be done");
    let access = window.app.world().resource::<SceneAccess>().get();
    assert!(!access.covers(&window.path("scene/mesh.obj")));
}
