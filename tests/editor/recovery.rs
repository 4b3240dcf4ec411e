//! Edits that a run of the program left behind: who is told of them, how they are got at, and what is saved over them.

use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use bevy::ecs::system::SystemId;
use bevy::prelude::*;
use bevy::tasks::{IoTaskPool, TaskPool};
use sunroom::app::editor::command::recovery_offer::{Note, Offer};
use sunroom::app::editor::command::shell::{Sheet, ShellCommand};
use sunroom::app::editor::command::{Command, FileCommand, FileDialogKind};
use sunroom::app::editor::commands::apply;
use sunroom::app::editor::commands::bare_world::bare_world;
use sunroom::app::editor::session::recovery::{self, Recovery};
use sunroom::app::editor::session::requests::Requests;
use sunroom::app::editor::session::toasts::Toasts;
use sunroom::scene::write::OnChange;
use sunroom::scene::{OpenScene, SceneState, SceneStatus};
use tempfile::TempDir;

use crate::editing::{say, text_of, window_on};

const BALL: &str = "<scene version='3.0.0'>\n  <sensor type='perspective' id='eye'/>\n  \
    <shape type='sphere' id='ball'/>\n</scene>\n";

/// Longer than the slowest machine needs.
const HANG: Duration = Duration::from_secs(60);

/// A folder with scenes and settings.
struct Home(TempDir);

/// A window that has begun.
struct Window {
    world: World,
    follow: SystemId,
}

impl Home {
    fn new() -> Self {
        let home = Self(tempfile::tempdir().expect("a temporary folder"));
        for name in ["ball.xml", "other.xml"] {
            std::fs::write(home.path(name), BALL).expect("a temporary folder");
        }
        home
    }

    fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    fn copies(&self) -> Vec<PathBuf> {
        let all = std::fs::read_dir(self.path("recovery")).into_iter().flatten().flatten();
        all.map(|folder| folder.path())
            .filter(|folder| folder.join("scene.xml").is_file())
            .collect()
    }

    /// A copy of a scene, as an older version of the program left it.
    fn leave(&self, name: &str, scene: Option<PathBuf>, time: u64) {
        let folder = self.path("recovery").join(name);
        std::fs::create_dir_all(&folder).expect("a temporary folder");
        std::fs::write(folder.join("scene.xml"), BALL).expect("a temporary folder");
        let note = Note {
            scene,
            time,
            ..Note::default()
        };
        let text = serde_json::to_vec(&note).expect("plain data");
        std::fs::write(folder.join("about.json"), text).expect("a temporary folder");
    }

    /// A window that begins with this scene, and with the start page if there is none.
    fn begin(&self, scene: Option<&str>) -> Window {
        let mut world = match scene {
            Some(name) => window_on(&self.path(name)),
            None => bare_world(),
        };
        world.insert_resource(Recovery::new(Some(self.0.path())));
        let follow = world.register_system(recovery::follow_scene);
        let mut window = Window { world, follow };
        match scene {
            Some(name) => window.opened(Some(&self.path(name))),
            None => {
                // The program shows some scene behind the page.
                window.world.resource_mut::<Requests>().sheet = Some(Sheet::Start);
                window.opened(Some(Path::new("/sunroom/scenes/cornell.xml")));
            }
        }
        window
    }

    /// A window in which the ball was moved, and that is killed when that is written aside.
    fn crash(&self, name: &str) {
        drop(self.edit_aside(name));
    }

    /// A window in which the ball was moved, which is written aside.
    fn edit_aside(&self, name: &str) -> Window {
        let mut window = self.begin(Some(name));
        window.world.resource_mut::<Recovery>().offer = None;
        assert!(say(&mut window.world, "move ball 1,0,0"));
        let before = self.copies().len();
        IoTaskPool::get_or_init(TaskPool::default);
        recovery::autosave(&mut window.world);
        let begun = Instant::now();
        while self.copies().len() == before {
            assert!(begun.elapsed() < HANG, "nothing was written aside");
            std::thread::sleep(Duration::from_millis(2));
        }
        window
    }
}

impl Window {
    /// A scene has just been opened.
    fn opened(&mut self, path: Option<&Path>) {
        let mut status = self.world.resource_mut::<SceneStatus>();
        status.path = path.map(Path::to_owned);
        status.revision += 1;
        (status.state, status.fresh_load) = (SceneState::Ready, true);
        self.world.run_system(self.follow).expect("all resources are there");
    }

    fn shell(&mut self, command: ShellCommand) -> bool {
        apply(&mut self.world, Command::Shell(command)).is_ok()
    }

    fn offer(&self) -> Option<&Offer> {
        self.world.resource::<Recovery>().offer.as_ref()
    }

    fn left(&self) -> Vec<Option<String>> {
        let left = &self.world.resource::<Recovery>().left;
        let names = left.iter().map(|offer| offer.note.scene.as_deref()?.file_name());
        names.map(|name| Some(name?.to_string_lossy().into_owned())).collect()
    }

    fn sheet(&self) -> Option<Sheet> {
        self.world.resource::<Requests>().sheet
    }

    fn told(&self) -> String {
        self.world.resource::<Toasts>().texts().collect::<Vec<_>>().join("\n")
    }

    /// The copy that is asked about before a save.
    fn asked(&self) -> Option<&Offer> {
        let question = self.world.resource::<Requests>().save_question.as_ref();
        question.and_then(|question| question.copy.as_ref())
    }
}

#[test]
fn a_window_that_begins_names_every_scene_with_a_copy() {
    let home = Home::new();
    home.leave("a", Some(home.path("other.xml")), 200_000);
    home.leave("b", Some(home.path("gone/room.xml")), 300_000);
    // With another file.
    let mut window = home.begin(Some("ball.xml"));
    let told = window.told();
    assert!(
        told.contains("2 scenes have unsaved edits: room.xml of 1970-"),
        "{told}"
    );
    assert!(told.contains("other.xml of 1970-"), "{told}");
    assert_eq!(window.offer(), None);
    // It is said once.
    window.world.insert_resource(Toasts::default());
    window.opened(Some(&home.path("ball.xml")));
    assert_eq!(window.told(), "");
    // With the very file: that one is asked about, and the rest is told.
    let window = home.begin(Some("other.xml"));
    assert_eq!(
        window.offer().and_then(|offer| offer.note.scene.clone()),
        Some(home.path("other.xml"))
    );
    assert!(window.told().contains("1 scene has unsaved edits: room.xml of"));
    // Without a file the page lists them.
    let window = home.begin(None);
    assert_eq!(
        window.left(),
        [Some("room.xml".to_owned()), Some("other.xml".to_owned())]
    );
    assert_eq!((window.offer(), window.sheet()), (None, Some(Sheet::Start)));
}

#[test]
fn a_scene_without_a_file_is_asked_about_at_once() {
    let home = Home::new();
    home.leave("a", None, 2000);
    let window = home.begin(Some("ball.xml"));
    assert!(window.offer().is_some_and(|offer| offer.note.scene.is_none()));
    assert_eq!(window.told(), "");
    // The page lists it.
    let window = home.begin(None);
    assert_eq!((window.offer(), window.left().len()), (None, 1));
}

#[test]
fn what_a_running_window_has_written_aside_is_not_offered() {
    let home = Home::new();
    let running = home.edit_aside("other.xml");
    let mut window = home.begin(Some("other.xml"));
    assert_eq!((window.offer(), window.left().len()), (None, 0));
    assert!(window.shell(ShellCommand::ShowRecovery));
    assert!(window.told().contains("nothing to recover"));
    assert_eq!((window.offer(), window.sheet()), (None, None));
    // It crashes while this one is open.
    drop(running);
    assert!(window.shell(ShellCommand::ShowRecovery));
    assert_eq!(window.left(), [Some("other.xml".to_owned())]);
    assert!(window.offer().is_some_and(|offer| !offer.is_outdated));
}

#[test]
fn a_question_that_was_put_off_can_be_had_back() {
    let home = Home::new();
    home.crash("ball.xml");
    let mut window = home.begin(Some("ball.xml"));
    let offer = window.offer().cloned().expect("asked about");
    window.world.resource_mut::<Recovery>().offer = None;
    assert!(window.shell(ShellCommand::ShowRecovery));
    assert_eq!(window.offer(), Some(&offer));
    // Several are listed.
    window.world.resource_mut::<Recovery>().offer = None;
    home.crash("other.xml");
    assert!(window.shell(ShellCommand::ShowRecovery));
    assert_eq!((window.offer(), window.sheet()), (None, Some(Sheet::Recovery)));
    assert!(window.shell(ShellCommand::AskAboutRecovery(offer.clone())));
    assert_eq!(window.offer(), Some(&offer));
    assert!(window.shell(ShellCommand::DiscardRecovery(offer.clone())));
    assert_eq!(window.left(), [Some("other.xml".to_owned())]);
    // Another window may have been quicker.
    for late in [
        ShellCommand::Recover(offer.clone()),
        ShellCommand::DiscardRecovery(offer),
    ] {
        assert!(!window.shell(late));
        assert!(window.world.resource::<Messages<OpenScene>>().is_empty());
        assert_eq!(home.copies().len(), 1);
    }
}

#[test]
fn a_message_goes_with_what_it_tells_of() {
    let home = Home::new();
    home.crash("other.xml");
    let mut window = home.begin(Some("ball.xml"));
    assert!(window.told().contains("other.xml of "), "{}", window.told());
    let offer = window.world.resource::<Recovery>().left[0].clone();
    assert!(window.shell(ShellCommand::DiscardRecovery(offer)));
    assert_eq!(window.told(), "");
}

#[test]
fn saving_over_a_scene_with_newer_edits_asks_first() {
    let home = Home::new();
    home.crash("ball.xml");
    let path = home.path("ball.xml");
    let mut window = home.begin(Some("ball.xml"));
    window.world.resource_mut::<Recovery>().offer = None;
    assert!(say(&mut window.world, "move ball 0,3,0"));
    for command in [
        Command::from(FileCommand::Save),
        Command::from(FileCommand::SaveScene(path.clone())),
    ] {
        apply(&mut window.world, command).expect("asked");
        assert!(window.asked().is_some());
        assert_eq!(text_of(&path), BALL);
        window.world.resource_mut::<Requests>().save_question = None;
    }
    // The user says that it is meant; the copy stays, and is older now.
    apply(
        &mut window.world,
        FileCommand::SaveChanged(path.clone(), OnChange::Refuse),
    )
    .expect("saved");
    let saved = text_of(&path);
    assert_ne!(saved, BALL);
    assert_eq!(home.copies().len(), 1);
    assert!(say(&mut window.world, "move ball 0,3,0"));
    apply(&mut window.world, FileCommand::Save).expect("saved");
    assert_eq!(window.asked(), None);
    assert_ne!(text_of(&path), saved);
    assert!(window.shell(ShellCommand::ShowRecovery));
    assert!(window.offer().is_some_and(|offer| offer.is_outdated));
}

/// Some network disks have no locks.
#[test]
fn where_files_cannot_be_locked_own_copies_are_not_offered() {
    let home = Home::new();
    let unlock = || {
        let copy = home.copies().remove(0);
        std::fs::remove_file(copy.join("lock")).expect("it is there");
    };
    let mut window = home.edit_aside("ball.xml");
    unlock();
    assert!(window.shell(ShellCommand::ShowRecovery));
    assert_eq!((window.left().len(), window.offer()), (0, None));
    apply(&mut window.world, FileCommand::Save).expect("saved");
    assert_eq!(window.asked(), None);
    assert_ne!(text_of(&home.path("ball.xml")), BALL);
    // Nor is a copy that this window is opening.
    drop(window);
    let mut window = home.begin(Some("other.xml"));
    let offer = window.world.resource::<Recovery>().left[0].clone();
    assert!(window.shell(ShellCommand::Recover(offer)));
    unlock();
    assert!(window.shell(ShellCommand::ShowRecovery));
    assert_eq!((window.left().len(), window.offer()), (0, None));
}

#[test]
fn saving_elsewhere_asks_only_about_what_is_there() {
    let home = Home::new();
    home.crash("other.xml");
    let mut window = home.begin(Some("ball.xml"));
    apply(&mut window.world, FileCommand::Save).expect("saved");
    apply(&mut window.world, FileCommand::SaveScene(home.path("new.xml"))).expect("saved");
    assert_eq!(window.asked(), None);
    apply(&mut window.world, FileCommand::SaveScene(home.path("other.xml"))).expect("asked");
    assert!(window.asked().is_some());
    // What this window has written aside itself is no reason to ask.
    let mut own = home.edit_aside("ball.xml");
    apply(&mut own.world, FileCommand::Save).expect("saved");
    assert_eq!(own.asked(), None);
    assert_ne!(text_of(&home.path("ball.xml")), BALL);
    // A scene without a file is not asked about, but for a name.
    home.leave("unnamed", None, u64::MAX);
    let mut window = home.begin(Some("ball.xml"));
    window.world.resource_mut::<SceneStatus>().path = None;
    apply(&mut window.world, FileCommand::Save).expect("asked for a name");
    assert_eq!(
        (window.asked(), window.world.resource::<Requests>().dialog),
        (None, Some(FileDialogKind::SaveScene))
    );
}
