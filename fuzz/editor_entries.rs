//! Every parser of the editor, as a plain function of the bytes that it reads; see `entries.rs`.
//!
//! They need Bevy, and have a fuzz target and a test of their own.

use std::fs;
use std::path::Path;
use std::sync::{Arc, LazyLock};

use bevy::ecs::message::Messages;
use bevy::math::{Affine3A, Vec3A};
use bevy::prelude::{Entity, With, World};
use bevy_egui::egui::{self, pos2, vec2};
use egui_dock::{DockArea, TabViewer};
use sunroom::app::editor::automation::monkey::Snapshot;
use sunroom::app::editor::automation::script::parse::{self, Step};
use sunroom::app::editor::command::gizmo_settings::{DEGREES, FACTORS, LENGTHS};
use sunroom::app::editor::command::panel::Panel;
use sunroom::app::editor::command::preferences::{
    LONGEST_AUTOSAVE, MOVING_SCALES, Preferences, SPEED_RANGE, UI_SCALES,
};
use sunroom::app::editor::command::traits::Effect;
use sunroom::app::editor::command::{Command, EditCommand, HistoryCommand, SceneEdit, SelectionCommand, ViewCommand};
use sunroom::app::editor::commands::apply;
use sunroom::app::editor::commands::bare_world::bare_world;
use sunroom::app::editor::session::history::History;
use sunroom::app::editor::session::kept_picture::Shown;
use sunroom::app::editor::session::layout::Layout;
use sunroom::app::editor::session::preferences::PreferencesFile;
use sunroom::app::editor::session::recovery::{self, Recovery, discard, recover};
use sunroom::app::editor::session::requests::Requests;
use sunroom::app::editor::session::stored_views::follow_views;
use sunroom::app::editor::session::trust::TrustedFolders;
use sunroom::app::editor::session::view_settings::ViewSettings;
use sunroom::app::editor::session::views_file::ViewsFile;
use sunroom::document::{self, Diagnostics, WriteError};
use sunroom::scene::read::read;
use sunroom::scene::spawn::spawn_fresh;
use sunroom::scene::write::gather::describe;
use sunroom::scene::write::{SaveError, save, save_description, to_document};
use sunroom::scene::{FreeView, OpenScene, SceneDescription, SceneState, SceneStatus, Shape, ToWorld, Trust};
use tempfile::{TempDir, tempdir};

use crate::meaning::meaning;

/// All entries by the names of their folders in the corpus.
pub const ENTRIES: [(&str, fn(&[u8])); 7] = [
    ("scripts", scripts),
    ("scenes", scenes),
    ("preferences", preferences),
    ("recovery", recovery_notes),
    ("views", views),
    ("trust", trusted_folders),
    ("shown", shown),
];

/// No file has this name.
const NOWHERE: &str = "/nowhere/scene.xml";

/// What scripts begin with: a thing of each kind.
const BEGINNING: &str = r#"<scene version="3.0.0">
  <sensor type="thinlens" id="camera"><float name="aperture_radius" value="0.1"/></sensor>
  <bsdf type="twosided" id="clay"><bsdf type="diffuse" id="inside"/></bsdf>
  <shape type="sphere" id="ball"><ref id="clay"/></shape>
  <shape type="rectangle" id="lamp"><emitter type="area"/><bsdf type="roughconductor"/></shape>
  <shape type="shapegroup" id="group"><shape type="cube" id="box"/></shape>
  <shape type="instance" id="copy"><ref id="group"/></shape>
  <emitter type="point" id="bulb"/>
</scene>"#;

/// The scene of a text, and what there is to say about it.
fn scene_of(text: &str, path: &Path) -> (SceneDescription, Diagnostics) {
    let mut document = document::parse_str(text, path, &[]);
    let scene = read(&mut document);
    (scene, document.diagnostics)
}

/// Lines of a script, done one after the other, but for those about files. All edits can be taken back and done again,
/// and the scene can be saved at the end.
pub fn scripts(bytes: &[u8]) {
    static SCENE: LazyLock<Arc<SceneDescription>> = LazyLock::new(|| {
        let (scene, diagnostics) = scene_of(BEGINNING, Path::new(NOWHERE));
        assert!(diagnostics.list.is_empty(), "{diagnostics}");
        Arc::new(scene)
    });
    let text = String::from_utf8_lossy(bytes);
    let mut world = bare_world();
    spawn_fresh(&mut world, &SCENE);
    let before = Snapshot::of(&mut world);
    for line in text.lines() {
        world.resource_mut::<Requests>().interaction += 1;
        if let Ok(Some(Step::Do(command))) = parse::line(&mut world, line)
            && is_of_the_scene(&command)
        {
            let _ = apply(&mut world, command);
        }
    }
    let after = Snapshot::of(&mut world);
    let (steps, _) = world.resource::<History>().len();
    let is_whole = world.resource::<History>().is_whole();
    for (to, expected) in [(0, &before), (steps, &after)] {
        apply(&mut world, HistoryCommand::GoTo(to)).expect("steps that are known");
        if is_whole || to == steps {
            assert_eq!(
                Snapshot::of(&mut world).difference(expected),
                None,
                "at step {to} of {steps}"
            );
        }
    }
    let scene = describe(&mut world);
    match document::to_xml(&to_document(&scene, Path::new(NOWHERE))) {
        Ok(text) => {
            let (again, _) = scene_of(&text, Path::new(NOWHERE));
            assert_eq!(again.shapes.len(), scene.shapes.len(), "{text}");
        }
        Err(WriteError::NotXml { .. }) => {}
        Err(error) => panic!("the edited scene cannot be saved: {error}"),
    }
}

fn is_of_the_scene(command: &Command) -> bool {
    let selects = matches!(
        command,
        Command::Selection(SelectionCommand::Select(..) | SelectionCommand::SelectAll | SelectionCommand::Copy)
    );
    (selects || command.traits().effect != Effect::None)
        && !matches!(command, Command::Edit(EditCommand::Scene(SceneEdit::Import(_))))
}

/// A scene file that is opened, written aside as for recovery, saved over itself, edited and saved again: what is read
/// again is what was written, and unedited parts stay the same to the byte.
pub fn scenes(bytes: &[u8]) {
    let folder = tempdir().expect("a temporary folder");
    let path = folder.path().join("main.xml");
    fs::write(&path, bytes).expect("a temporary folder");
    let Some((scene, is_native)) = opened(&path) else {
        return;
    };
    let mut world = bare_world();
    world.resource_mut::<SceneStatus>().path = Some(path.clone());
    spawn_fresh(&mut world, &Arc::new(scene.clone()));
    let described = describe(&mut world);
    // What has no camera was given one, which is called otherwise when it is read again.
    let has_camera = !scene.sensors.is_empty();
    if has_camera {
        assert_same(&described, &scene, "as entities");
    }

    let aside = folder.path().join("aside.xml");
    match save_description(&described, &aside) {
        // Files may hold control characters, which are refused when they are to be written.
        Err(SaveError::Write(WriteError::NotXml { .. })) => return,
        outcome => outcome.expect("a folder that can be written to"),
    }
    if !has_camera {
        return;
    }
    assert_saved(&described, &aside, "aside");

    let home = if is_native { &path } else { &aside };
    let before = fs::read(home).expect("a file that is there");
    assert_eq!(save(&mut world, home).expect("it was saved aside"), None);
    if is_native {
        assert_eq!(fs::read(home).expect("just written"), before, "saved over itself");
    }
    let shapes: Vec<Entity> = world.query_filtered::<Entity, With<Shape>>().iter(&world).collect();
    for shape in shapes {
        let pose = world.get::<ToWorld>(shape).map_or(Affine3A::IDENTITY, |pose| pose.0);
        let moved = Affine3A {
            translation: pose.translation + Vec3A::X,
            ..pose
        };
        world.entity_mut(shape).insert(ToWorld(moved));
    }
    let edited = describe(&mut world);
    if edited.shapes.iter().all(|shape| shape.to_world.is_finite()) {
        assert_eq!(save(&mut world, home).expect("it was saved before"), None);
        let (mut again, _) = opened(home).expect("a scene that can be read");
        for (again, edited) in again.shapes.iter_mut().zip(&edited.shapes) {
            // The steps of a transform are kept; composed they are rounded once more.
            let size = edited
                .to_world
                .to_cols_array()
                .iter()
                .fold(1.0, |most: f32, x| most.max(x.abs()));
            if again.to_world.abs_diff_eq(edited.to_world, 1e-5 * size) {
                again.to_world = edited.to_world;
            }
        }
        assert_same(&again, &edited, "edited");
    }
}

/// The scene of a file, and whether it is in the native format; None if there is an error in it.
fn opened(path: &Path) -> Option<(SceneDescription, bool)> {
    let mut document = document::load(path, &[]).ok()?;
    let scene = read(&mut document);
    (!document.diagnostics.has_errors()).then_some((scene, !document.imported))
}

fn assert_saved(scene: &SceneDescription, path: &Path, what: &str) {
    let (again, _) = opened(path).unwrap_or_else(|| panic!("{what}: {:?}", fs::read_to_string(path)));
    assert_same(&again, scene, what);
}

/// Shows the first lines that differ: the whole would fill pages.
fn assert_same(one: &SceneDescription, other: &SceneDescription, what: &str) {
    let (one, other) = (meaning(one), meaning(other));
    if one != other {
        let (one, other) = (format!("{one:#?}"), format!("{other:#?}"));
        let lines: Vec<(usize, (&str, &str))> = one.lines().zip(other.lines()).enumerate().collect();
        let place = lines.iter().position(|(_, (one, other))| one != other).unwrap_or(0);
        panic!(
            "{what}: {:?}",
            &lines[place.saturating_sub(12)..(place + 3).min(lines.len())]
        );
    }
}

/// A folder with this file in it.
fn folder_with(name: &str, bytes: &[u8]) -> TempDir {
    let folder = tempdir().expect("a temporary folder");
    fs::write(folder.path().join(name), bytes).expect("a temporary folder");
    folder
}

/// The file of preferences: understood and then within the ranges of its controls, or else set aside as it is. What is
/// stored comes back.
pub fn preferences(bytes: &[u8]) {
    const FILE: &str = "preferences.json";
    let folder = folder_with(FILE, bytes);
    let (mut file, known) = PreferencesFile::open(Some(folder.path()));
    match &file.problem {
        None => {
            let is_kept = |length: &f32| LENGTHS.contains(length);
            assert!(UI_SCALES.contains(&known.ui_scale) && MOVING_SCALES.contains(&known.moving_scale));
            assert!(SPEED_RANGE.contains(&known.speed) && known.autosave_seconds <= LONGEST_AUTOSAVE);
            assert!(DEGREES.contains(&known.steps.degrees) && FACTORS.contains(&known.steps.factor));
            assert!(known.steps.length.as_ref().is_none_or(is_kept));
            show(Layout::remembered(&known));
        }
        Some(_) => {
            assert_eq!(known, Preferences::default());
            let kept = fs::read(folder.path().join("preferences.json.bad")).expect("set aside");
            assert_eq!(kept, bytes);
        }
    }
    let mut changed = known.clone();
    changed.speed = if known.speed == 2.0 { 3.0 } else { 2.0 };
    changed.note_recent(Path::new("/a.xml"));
    file.store(changed.clone());
    let (again, back) = PreferencesFile::open(Some(folder.path()));
    assert_eq!(again.problem, None);
    // Numbers that are not understood are numbers of double precision, which are read with an error in the last place.
    let text = serde_json::to_vec(&changed).expect("plain data");
    let changed_again: Preferences = serde_json::from_slice(&text).expect("just written");
    assert_eq!(back, changed_again);
    assert_eq!(back.recent_files, changed.recent_files);
    assert_eq!(
        (back.speed, back.ui_scale, back.steps),
        (changed.speed, changed.ui_scale, changed.steps)
    );
}

/// Shows the panels in windows of several sizes, closes each of them and opens it again.
fn show(mut layout: Layout) {
    thread_local! {
        static CONTEXT: egui::Context = egui::Context::default();
    }
    static USUAL: LazyLock<serde_json::Value> = LazyLock::new(|| Layout::default().to_json());
    if layout.to_json() == *USUAL {
        return;
    }
    let again = Layout::from_json(&layout.to_json()).expect("a layout that can be shown");
    assert_eq!(again.to_json(), layout.to_json());
    CONTEXT.with(|context| {
        for size in [vec2(1280.0, 720.0), vec2(200.0, 100.0)] {
            let input = egui::RawInput {
                screen_rect: Some(egui::Rect::from_min_size(pos2(0.0, 0.0), size)),
                ..egui::RawInput::default()
            };
            let _ = context.run_ui(input, |ui| {
                layout.fit(ui.available_size());
                DockArea::new(&mut layout.0).show_inside(ui, &mut Titles);
            });
        }
    });
    for &panel in Panel::CLOSEABLE {
        layout.close(panel);
        assert!(!layout.has(panel));
    }
    for &panel in Panel::CLOSEABLE {
        layout.show(panel);
        assert!(layout.has(panel));
    }
}

/// Panels without contents.
struct Titles;

impl TabViewer for Titles {
    type Tab = Panel;

    fn id(&mut self, panel: &mut Panel) -> egui::Id {
        egui::Id::new(*panel)
    }

    fn title(&mut self, panel: &mut Panel) -> egui::WidgetText {
        panel.title().into()
    }

    fn ui(&mut self, _: &mut egui::Ui, _: &mut Panel) {}
}

/// The note beside a scene that was written aside: it is offered, opened under the name that the note says, and can be
/// thrown away.
pub fn recovery_notes(bytes: &[u8]) {
    let home = tempdir().expect("a temporary folder");
    let folder = home.path().join("recovery/one");
    let copy = folder.join("scene.xml");
    fs::create_dir_all(&folder).expect("a temporary folder");
    fs::write(folder.join("about.json"), bytes).expect("a temporary folder");
    fs::write(&copy, "<scene version='3.0.0'/>").expect("a temporary folder");
    let mut world = bare_world();
    world.insert_resource(Recovery::new(Some(home.path())));
    let follow = world.register_system(recovery::follow_scene);
    world.run_system(follow).expect("all resources are there");
    let Some(offer) = world.resource::<Recovery>().offer.clone() else {
        return;
    };
    assert_eq!(offer.folder, folder);
    let text = serde_json::to_vec(&offer.note).expect("plain data");
    assert_eq!(serde_json::from_slice(&text).ok().as_ref(), Some(&offer.note));
    recover(&mut world, offer.clone()).expect("nobody else has it");
    assert!(world.resource::<Recovery>().is_returning());
    let asked: Vec<OpenScene> = world.resource_mut::<Messages<OpenScene>>().drain().collect();
    assert_eq!(asked.len(), 1);
    assert_eq!(asked[0].path, copy);
    let mut status = world.resource_mut::<SceneStatus>();
    (status.path, status.revision, status.fresh_load) = (Some(copy), 1, true);
    status.state = SceneState::Ready;
    world.run_system(follow).expect("all resources are there");
    assert_eq!(world.resource::<SceneStatus>().path, offer.note.scene);
    assert!(!world.resource::<History>().is_saved());
    assert!(discard(&offer).is_err(), "it is in use");
    drop(world);
    assert!(discard(&offer).is_ok());
    assert!(!folder.exists());
}

/// The file of stored views: they come back when their scene is opened, can be gone to, and come back once more after
/// another was stored.
pub fn views(bytes: &[u8]) {
    let folder = folder_with("views.json", bytes);
    let known = views_after(folder.path(), |_| {});
    for view in known.iter().flatten() {
        assert!(view.pose.is_finite(), "{view:?}");
    }
    let stored = views_after(folder.path(), |world| {
        for number in 1..=9 {
            let _ = apply(world, ViewCommand::RecallView(number));
            assert!(world.resource::<FreeView>().pose.is_none_or(|pose| pose.is_finite()));
        }
        world.insert_resource(FreeView::default());
        apply(world, ViewCommand::StoreView(9)).expect("there is a camera");
    });
    assert_eq!(stored[..8], known[..8]);
    assert_eq!(views_after(folder.path(), |_| {}), stored);
}

/// The stored views of the scene `/x.xml` after `act`, with the folder of settings at `home`.
fn views_after(home: &Path, act: impl FnOnce(&mut World)) -> sunroom::app::editor::command::stored_view::StoredViews {
    let mut world = bare_world();
    spawn_fresh(&mut world, &Arc::new(SceneDescription::empty()));
    world.insert_resource(ViewsFile::new(Some(home)));
    world.insert_resource(SceneStatus {
        path: Some("/x.xml".into()),
        state: SceneState::Ready,
        revision: 1,
        fresh_load: true,
        ..SceneStatus::default()
    });
    let follow = world.register_system(follow_views);
    world.run_system(follow).expect("all resources are there");
    act(&mut world);
    world.run_system(follow).expect("all resources are there");
    world.resource::<ViewSettings>().bookmarks
}

/// How the window showed a scene whose picture is kept: what cannot be shown is left out, and what is left can be
/// written and read again.
pub fn shown(bytes: &[u8]) {
    let Some(shown) = Shown::read(&String::from_utf8_lossy(bytes)) else {
        return;
    };
    assert!(shown.time.abs() <= 1e9 && shown.samples != Some(0), "{shown:?}");
    assert!(shown.view.is_none_or(|view| view.pose.is_finite()), "{shown:?}");
    let limits = [shown.seconds, shown.noise];
    assert!(limits.iter().flatten().all(|limit| limit.is_finite()), "{shown:?}");
    let text = serde_json::to_string(&shown).expect("plain data");
    assert!(Shown::read(&text).is_some(), "{text}");
}

/// The file of folders that scenes may read: each is named in full.
pub fn trusted_folders(bytes: &[u8]) {
    let folder = folder_with("trusted-folders.json", bytes);
    let (_, trust) = TrustedFolders::open(Some(folder.path()));
    let Trust::Folders(folders) = trust else {
        panic!("a file allowed everything");
    };
    assert!(folders.iter().all(|folder| folder.is_absolute()));
}
