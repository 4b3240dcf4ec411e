//! Sudden death in the middle of a write. A limit for the length of files makes the system kill the program at the
//! first write beyond it, as SIGKILL would, but at a place that the test knows.

use std::path::Path;
use std::process::Command;
use std::time::{Duration, SystemTime};

use bevy::ecs::system::RunSystemOnce;
use bevy::prelude::*;
use sunroom::app::editor::command::recovery_offer::Offer;
use sunroom::app::editor::session::history::History;
use sunroom::app::editor::session::preferences::PreferencesFile;
use sunroom::app::editor::session::recovery::{self, Recovery};
use sunroom::app::editor::session::requests::Requests;
use sunroom::app::editor::session::toasts::Toasts;
use sunroom::app::editor::session::view_settings::ViewSettings;
use sunroom::app::headless::headless;
use sunroom::engine::{Limits, load_to_completion};
use sunroom::scene::OpenScene;

use crate::program::{OLD, Running, Workshop, picture, wait_for};
use crate::table::{Row, section};

section! { "Killed in the middle of a write"
    picture_is_half_written:
        "Killed while a picture is written.",
        "Nothing; the program is gone.",
        "The older file of that name and a file `.sunroom-….part`. A later write into the folder removes that file when it is an hour old.";
    scene_is_half_written:
        "Killed while `sunroom convert` writes a scene.",
        "Nothing; the program is gone.",
        "The older file of that name and a file `.sunroom-….part`, removed as above.";
    preferences_are_half_written:
        "Killed while the preferences are written.",
        "The next window has the preferences as they were before.",
        "The older preferences and a file `.sunroom-….part`, removed as above.";
    first_recovery_copy_is_half_written:
        "Killed while the first recovery copy of a scene is written.",
        "Nothing is offered.",
        "The folder of the copy, with a file `.sunroom-….part`. A window that is opened later removes the folder when it is an hour old.";
    later_recovery_copy_is_half_written:
        "Killed while a later recovery copy of a scene is written.",
        "The next window offers the earlier copy.",
        "The earlier copy and a file `.sunroom-….part`, which go when the copy is no longer needed.";
    part_of_gltf_is_half_written:
        "Killed while a part of a glTF file is written to the cache.",
        "The next render makes the part again.",
        "A temporary file in the cache, which no program reads.";
}

/// Files may have this length in bytes; scenes, pictures and preferences here are longer.
const LIMIT: &str = "--fsize=400";
pub const KILLED: [&str; 5] = ["env", "--default-signal=XFSZ", "prlimit", "--core=0", LIMIT];

/// The program ended by the signal of the limit, and its temporary file is still in `folder`; returns its name.
#[track_caller]
pub fn temporary_file(shop: &Workshop, folder: &str) -> String {
    let is_part = |name: &String| name.starts_with(".sunroom-") && name.ends_with(".part");
    let mut parts = shop.names(folder).into_iter().filter(is_part);
    match (parts.next(), parts.next()) {
        (Some(part), None) => part,
        _ => panic!("one temporary file was expected: {:?}", shop.names(folder)),
    }
}

#[track_caller]
pub fn is_killed(output: &std::process::Output) {
    use std::os::unix::process::ExitStatusExt;
    // SIGXFSZ.
    let said = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.signal(), Some(25), "{:?} {said}", output.status);
}

pub fn make_old(path: &Path) {
    let file = std::fs::File::options().append(true).open(path).expect("it is there");
    let long_ago = SystemTime::now() - Duration::from_secs(2 * 3600);
    file.set_modified(long_ago).expect("times can be set");
}

fn picture_is_half_written(_: &Row) {
    let shop = Workshop::new();
    let render = ["render", "scene.xml", "-o", "out/a.png"];
    std::fs::create_dir(shop.path("out")).expect("a temporary folder");
    shop.write("out/a.png", OLD);
    is_killed(&shop.run(&KILLED, &render));
    assert_eq!(std::fs::read(shop.path("out/a.png")).expect("it is there"), OLD);
    let part = temporary_file(&shop, "out");
    // A young one may belong to a program that runs.
    assert_eq!(shop.run(&[], &render).status.code(), Some(0));
    assert_eq!(shop.names("out"), [part.as_str(), "a.png"]);
    make_old(&shop.path("out").join(part));
    assert_eq!(shop.run(&[], &render).status.code(), Some(0));
    assert_eq!(shop.names("out"), ["a.png"]);
    picture(&shop.path("out/a.png"));
}

fn scene_is_half_written(_: &Row) {
    let shop = Workshop::new();
    let convert = ["convert", "scene.xml", "out/new.xml"];
    std::fs::create_dir(shop.path("out")).expect("a temporary folder");
    shop.write("out/new.xml", OLD);
    is_killed(&shop.run(&KILLED, &convert));
    assert_eq!(std::fs::read(shop.path("out/new.xml")).expect("it is there"), OLD);
    make_old(&shop.path("out").join(temporary_file(&shop, "out")));
    assert_eq!(shop.run(&[], &convert).status.code(), Some(0));
    assert_eq!(shop.names("out"), ["new.xml"]);
}

/// Runs [`child`] in a process of its own, with the limit or without.
fn run_child(shop: &Workshop, task: &str, limited: bool) -> std::process::Output {
    let before = if limited { &KILLED[..] } else { &["env"] };
    let this = std::env::current_exe().expect("this test has a file");
    let mut command = Command::new(before[0]);
    command
        .args(&before[1..])
        .arg(this)
        .args(["--exact", "killed::child", "--ignored"])
        .env("SUNROOM_TEST_TASK", task)
        .current_dir(shop.path("."))
        .stdout(std::process::Stdio::piped())
        .stderr(std::process::Stdio::piped());
    Running::start(&mut command).end()
}

#[test]
#[ignore = "a task that the rows run in a process of its own"]
fn child() {
    let folder = Path::new("config");
    match std::env::var("SUNROOM_TEST_TASK").as_deref() {
        Ok("preferences") => {
            let (mut file, mut preferences) = PreferencesFile::open(Some(folder));
            preferences.speed += 1.0;
            // Enough text for the limit.
            let scenes = (0..5).map(|number| format!("/{}/{number}.xml", "folder".repeat(10)).into());
            preferences.recent_files = scenes.collect();
            file.store(preferences);
            assert_eq!(file.problem, None);
        }
        Ok("recovery") => write_aside(folder, 1),
        Ok("recovery twice") => write_aside(folder, 2),
        task => panic!("{task:?} is no task"),
    }
}

/// The scene in this process without a window, with its recovery copies in `folder`.
fn scene_with_recovery(scene: &Path, folder: &Path) -> App {
    let scene = OpenScene {
        path: scene.canonicalize().expect("it is there"),
        ..OpenScene::default()
    };
    let mut app = headless(scene, Some(1));
    app.insert_resource(Recovery::new(Some(folder)))
        .init_resource::<History>()
        .init_resource::<ViewSettings>()
        .init_resource::<Requests>()
        .init_resource::<Toasts>();
    let loaded = load_to_completion(&mut app, &Limits::default());
    assert!(loaded.is_ok_and(|loaded| loaded));
    app
}

/// Writes a recovery copy of the scene, as the window does after a while; a second one as if the process had been
/// started with the limit.
fn write_aside(folder: &Path, copies: usize) {
    let mut app = scene_with_recovery(Path::new("scene.xml"), folder);
    for copy in 0..copies {
        if copy > 0 {
            let id = std::process::id().to_string();
            let limited = Command::new("prlimit").args(["--pid", &id, LIMIT]).status();
            assert!(limited.is_ok_and(|status| status.success()));
        }
        recovery::autosave(app.world_mut());
        wait_for("the copy", || {
            let folders = std::fs::read_dir(folder.join("recovery"))
                .into_iter()
                .flatten()
                .flatten();
            let is_there = folders
                .map(|folder| folder.path().join("scene.xml"))
                .any(|scene| scene.is_file());
            // The limit ends this process before there is a second one.
            is_there && copy == 0
        });
    }
}

/// What the next window offers for the scene.
fn offered(shop: &Workshop) -> Option<Offer> {
    let mut app = scene_with_recovery(&shop.path("scene.xml"), &shop.path("config"));
    let followed = app.world_mut().run_system_once(recovery::follow_scene);
    assert!(followed.is_ok());
    app.world().resource::<Recovery>().offer.clone()
}

/// The folder of the only recovery copy, relative to the workshop.
fn recovery_folder(shop: &Workshop) -> String {
    let names = shop.names("config/recovery");
    assert_eq!(names.len(), 1, "{names:?}");
    format!("config/recovery/{}", names[0])
}

fn first_recovery_copy_is_half_written(_: &Row) {
    let shop = Workshop::new();
    is_killed(&run_child(&shop, "recovery", true));
    let folder = recovery_folder(&shop);
    temporary_file(&shop, &folder);
    assert_eq!(offered(&shop), None);
    assert!(shop.path(&folder).exists());
    make_old(&shop.path(&folder).join("lock"));
    assert_eq!(offered(&shop), None);
    assert!(shop.names("config/recovery").is_empty());
}

fn later_recovery_copy_is_half_written(_: &Row) {
    let shop = Workshop::new();
    is_killed(&run_child(&shop, "recovery twice", false));
    let folder = recovery_folder(&shop);
    temporary_file(&shop, &folder);
    let offer = offered(&shop).expect("the first copy");
    assert_eq!(offer.folder, shop.path(&folder));
    let copy = std::fs::read_to_string(offer.folder.join("scene.xml")).expect("it is there");
    assert!(copy.trim_end().ends_with("</scene>"), "{copy}");
    recovery::discard(&offer).expect("it can be discarded");
    assert!(shop.names("config/recovery").is_empty());
}

/// A triangle whose buffer is in the file's text.
const GLTF: &str = r#"{"asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}], "nodes": [{"mesh": 0}],
  "meshes": [{"primitives": [{"attributes": {"POSITION": 0}}]}],
  "accessors": [{"bufferView": 0, "componentType": 5126, "count": 24, "type": "VEC3", "min": [0, 0, 0], "max": [1, 1, 1]}],
  "bufferViews": [{"buffer": 0, "byteLength": 288}],
  "buffers": [{"byteLength": 288, "uri": "data.bin"}]}"#;

/// Writes `a.gltf` and its buffer.
pub fn gltf(shop: &Workshop) {
    shop.write("a.gltf", GLTF);
    let corners = [[0f32, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 1.0]].repeat(8);
    let bytes: Vec<u8> = corners
        .as_flattened()
        .iter()
        .flat_map(|number| number.to_le_bytes())
        .collect();
    shop.write("data.bin", bytes);
}

fn part_of_gltf_is_half_written(_: &Row) {
    let shop = Workshop::new();
    gltf(&shop);
    let check = ["check", "a.gltf"];
    is_killed(&shop.run(&KILLED, &check));
    let output = shop.run(&[], &check);
    assert_eq!(
        output.status.code(),
        Some(0),
        "{}",
        String::from_utf8_lossy(&output.stderr)
    );
    let again = shop.run(&[], &check);
    assert_eq!(
        again.status.code(),
        Some(0),
        "{}",
        String::from_utf8_lossy(&again.stderr)
    );
}

fn preferences_are_half_written(_: &Row) {
    let shop = Workshop::new();
    let speed = || PreferencesFile::open(Some(&shop.path("config"))).1.speed;
    assert!(run_child(&shop, "preferences", false).status.success());
    let before = speed();
    is_killed(&run_child(&shop, "preferences", true));
    assert_eq!(speed(), before);
    make_old(&shop.path("config").join(temporary_file(&shop, "config")));
    assert!(run_child(&shop, "preferences", false).status.success());
    assert_eq!(shop.names("config"), ["preferences.json"]);
    assert_ne!(speed(), before);
}
