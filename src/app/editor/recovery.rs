//! Edits that no file has are written aside now and then, and offered again after a crash. Each scene has a folder of its own for that:
//! the scene as it was then, and a note of which file it is.

use std::path::{Path, PathBuf};
use std::time::{Duration, Instant, SystemTime, UNIX_EPOCH};

use bevy::prelude::*;
use bevy::tasks::{IoTaskPool, Task, block_on, futures::check_ready};
use bevy_egui::egui::{self, Id, Modal};
use serde::{Deserialize, Serialize};

use super::command::Command;
use super::history::History;
use super::preferences::Preferences;
use super::shell::ShellCommand;
use super::state::EditorState;
use super::toasts::{Tone, Topic};
use crate::document::write_atomically;
use crate::scene::write::{gather, save_description};
use crate::scene::{OpenScene, SceneDescription, SceneState, SceneStatus};

const SCENE: &str = "scene.xml";
const NOTE: &str = "about.json";

/// What is known of edits that were written aside.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Note {
    /// None: of a scene that was never saved.
    pub scene: Option<PathBuf>,
    /// Seconds since 1970.
    pub time: u64,
    /// The program that wrote it.
    process: u32,
}

/// Edits that can be had back.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Offer {
    pub folder: PathBuf,
    pub note: Note,
}

#[derive(Resource, Default)]
pub struct Recovery {
    /// Of all scenes; None: nothing is written aside.
    folder: Option<PathBuf>,
    /// The file of the scene, whatever was asked for since in vain.
    scene: Option<PathBuf>,
    /// Since when there have been edits that are not written aside.
    since: Option<Instant>,
    is_due: bool,
    task: Option<Task<Result<(), String>>>,
    /// Folders that are of no use once the scene is saved.
    mine: Vec<PathBuf>,
    /// What the user is asked about.
    pub offer: Option<Offer>,
    /// Being opened.
    returning: Option<Offer>,
    /// The last load of the scene that was looked at.
    revision: u64,
}

impl Recovery {
    pub fn new(folder: Option<&Path>) -> Self {
        Self {
            folder: folder.map(|folder| folder.join("recovery")),
            ..Self::default()
        }
    }

    fn forget(&mut self) {
        // What is being written is to be removed as well.
        if let Some(task) = self.task.take() {
            let _ = block_on(task);
        }
        for folder in self.mine.drain(..) {
            remove(&folder);
        }
        self.since = None;
    }
}

/// Beside what else is in the folder of all.
fn folder_of(all: &Path, scene: Option<&Path>) -> PathBuf {
    let process = std::process::id();
    all.join(match scene {
        Some(scene) => format!("{:016x}-{process}", hash(scene.as_os_str().as_encoded_bytes())),
        None => format!("untitled-{process}"),
    })
}

/// FNV-1a: the same in every version of the program.
fn hash(bytes: &[u8]) -> u64 {
    bytes.iter().fold(0xcbf2_9ce4_8422_2325, |hash, byte| {
        (hash ^ u64::from(*byte)).wrapping_mul(0x0100_0000_01b3)
    })
}

/// The note comes last: without it there is nothing to offer.
fn write_aside(folder: &Path, scene: &SceneDescription, path: Option<PathBuf>) -> Result<(), String> {
    let described = |error: std::io::Error| format!("{}: {error}", folder.display());
    std::fs::create_dir_all(folder).map_err(described)?;
    save_description(scene, &folder.join(SCENE)).map_err(|error| error.to_string())?;
    let since_1970 = SystemTime::now().duration_since(UNIX_EPOCH).unwrap_or_default();
    let note = Note {
        scene: path,
        time: since_1970.as_secs(),
        process: std::process::id(),
    };
    let text = serde_json::to_vec_pretty(&note).map_err(|error| error.to_string())?;
    write_atomically(&folder.join(NOTE), text).map_err(described)
}

/// Only a folder that is one of ours.
fn remove(folder: &Path) {
    if folder.join(NOTE).is_file() {
        // What cannot be removed is offered again, which does no harm.
        let _ = std::fs::remove_dir_all(folder);
    }
}

/// The newest of what programs that run no more have left in `all`: for this scene, or for any. Not what is older than its scene.
fn find(all: &Path, scene: Option<&Path>) -> Option<Offer> {
    let folders = std::fs::read_dir(all).ok()?;
    let offers = folders.filter_map(|entry| {
        let folder = entry.ok()?.path();
        let note: Note = serde_json::from_slice(&std::fs::read(folder.join(NOTE)).ok()?).ok()?;
        Some(Offer { folder, note })
    });
    offers
        .filter(|offer| scene.is_none() || offer.note.scene.as_deref() == scene)
        .filter(|offer| offer.folder.join(SCENE).is_file() && !is_running(offer.note.process))
        .filter(|offer| {
            offer
                .note
                .scene
                .as_ref()
                .is_none_or(|scene| is_older(scene, &offer.note))
        })
        .max_by_key(|offer| offer.note.time)
}

/// Another window may be at work on it. Where processes cannot be looked for, none is.
fn is_running(process: u32) -> bool {
    process != std::process::id() && Path::new("/proc").join(process.to_string()).is_dir()
}

fn is_older(scene: &Path, note: &Note) -> bool {
    let changed = std::fs::metadata(scene).and_then(|data| data.modified());
    let changed = changed.ok().and_then(|at| at.duration_since(UNIX_EPOCH).ok());
    changed.is_none_or(|changed| changed.as_secs() <= note.time)
}

/// Notices new scenes: what was left of them is offered, and what belonged to the scene before is of no use any more. To run after the
/// history has begun anew.
pub fn follow_scene(
    mut recovery: ResMut<Recovery>,
    mut status: ResMut<SceneStatus>,
    mut history: ResMut<History>,
    mut state: ResMut<EditorState>,
    mut started: Local<bool>,
) {
    let recovery = recovery.bypass_change_detection();
    let is_first = !std::mem::replace(&mut *started, true);
    let Some(all) = recovery.folder.clone() else {
        return;
    };
    if is_first && status.path.is_none() {
        recovery.offer = find(&all, None);
    }
    if status.revision == recovery.revision {
        if status.state == SceneState::Failed
            && let Some(offer) = recovery.returning.take()
        {
            let file = offer.folder.join(SCENE);
            let text = format!("{} could not be read; it is kept.", file.display());
            state.toasts.add(Tone::Error, Topic::Other, text, None);
        }
        return;
    }
    recovery.revision = status.revision;
    if !status.fresh_load {
        return;
    }
    recovery.forget();
    match recovery.returning.take() {
        Some(offer) => {
            status.path.clone_from(&offer.note.scene);
            history.note_unsaved();
            recovery.mine.push(offer.folder);
            state.say("Recovered; save the scene to keep it");
        }
        None => recovery.offer = status.path.as_deref().and_then(|scene| find(&all, Some(scene))),
    }
}

/// Decides when to write, and removes what is of no use any more.
pub fn plan_autosave(
    mut recovery: ResMut<Recovery>,
    mut state: ResMut<EditorState>,
    history: Res<History>,
    status: Res<SceneStatus>,
    preferences: Res<Preferences>,
) {
    let recovery = recovery.bypass_change_detection();
    recovery.is_due = false;
    if recovery.folder.is_none() {
        return;
    }
    if status.state == SceneState::Ready && recovery.scene != status.path {
        recovery.scene.clone_from(&status.path);
    }
    if let Some(outcome) = recovery.task.as_mut().and_then(check_ready) {
        recovery.task = None;
        if let Err(error) = outcome {
            let text = format!("The edits could not be written aside: {error}");
            state.toasts.add(Tone::Error, Topic::Saving, text, None);
        }
    }
    if recovery.task.is_some() {
        return;
    }
    if history.is_saved() {
        if !recovery.mine.is_empty() {
            recovery.forget();
        }
        recovery.since = None;
        return;
    }
    let since = *recovery.since.get_or_insert_with(Instant::now);
    let interval = Duration::from_secs(preferences.autosave_seconds.into());
    let is_over = !interval.is_zero() && since.elapsed() >= interval;
    recovery.is_due = is_over && recovery.returning.is_none() && status.state != SceneState::Loading;
}

pub fn is_due(recovery: Res<Recovery>) -> bool {
    recovery.is_due
}

/// Describes the scene here, and writes it in the background.
pub fn autosave(world: &mut World) {
    let started = Instant::now();
    let scene = gather::describe(world);
    let mut recovery = world.resource_mut::<Recovery>();
    let path = recovery.scene.clone();
    let Some(folder) = recovery.folder.as_deref().map(|all| folder_of(all, path.as_deref())) else {
        return;
    };
    if !recovery.mine.contains(&folder) {
        recovery.mine.push(folder.clone());
    }
    recovery.since = Some(Instant::now());
    let task = IoTaskPool::get().spawn(async move { write_aside(&folder, &scene, path) });
    recovery.task = Some(task);
    debug!("described the scene in {:.2} ms", 1e3 * started.elapsed().as_secs_f32());
}

/// After a good end nothing is left over.
pub fn clean_up(mut exits: MessageReader<AppExit>, mut recovery: ResMut<Recovery>) {
    if exits.read().any(AppExit::is_success) {
        if let Some(task) = recovery.task.take() {
            // What is written now would otherwise be left over.
            let _ = block_on(task);
        }
        recovery.forget();
    }
}

/// Opens what was written aside.
pub fn recover(world: &mut World, offer: Offer) {
    let path = offer.folder.join(SCENE);
    world.resource_mut::<Recovery>().returning = Some(offer);
    let defines = Vec::new();
    world.write_message(OpenScene { path, defines });
}

pub fn discard(offer: &Offer) {
    remove(&offer.folder);
}

/// Asks what is to become of the edits; `offer` is None once that is answered.
pub fn question(context: &egui::Context, offer: &mut Option<Offer>, commands: &mut Vec<Command>) {
    let Some(asked) = offer else {
        return;
    };
    let mut answer = None;
    let modal = Modal::new(Id::new("recovery")).show(context, |ui| {
        ui.set_width(420.0);
        ui.heading("Recover unsaved edits?");
        ui.add_space(4.0);
        let scene = match &asked.note.scene {
            Some(path) => path.display().to_string(),
            None => "a scene that was never saved".to_owned(),
        };
        let since_1970 = SystemTime::now().duration_since(UNIX_EPOCH).unwrap_or_default();
        let age = ago(since_1970.as_secs().saturating_sub(asked.note.time));
        ui.label(format!(
            "The program ended {age} without saving the last edits of {scene}."
        ));
        ui.add_space(8.0);
        ui.with_layout(egui::Layout::right_to_left(egui::Align::Center), |ui| {
            let recover = ui.button("Recover").on_hover_text("Open the scene with those edits");
            if recover.clicked() {
                answer = Some(ShellCommand::Recover(asked.clone()));
            }
            let discard = ui.button("Discard").on_hover_text("Those edits are lost then");
            if discard.clicked() {
                answer = Some(ShellCommand::DiscardRecovery(asked.clone()));
            }
            let later = ui.button("Later").on_hover_text("Ask again next time (Esc)");
            if later.clicked() {
                ui.close();
            }
        });
    });
    if answer.is_some() || modal.should_close() {
        commands.extend(answer.map(Command::Shell));
        *offer = None;
    }
}

fn ago(seconds: u64) -> String {
    let count = |number: u64, unit: &str| match number {
        1 => format!("1 {unit} ago"),
        _ => format!("{number} {unit}s ago"),
    };
    match seconds {
        0..60 => "just now".to_owned(),
        60..3600 => count(seconds / 60, "minute"),
        3600..86_400 => count(seconds / 3600, "hour"),
        _ => count(seconds / 86_400, "day"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn aside(all: &Path, name: &str, note: &Note) -> PathBuf {
        let folder = all.join(name);
        std::fs::create_dir_all(&folder).expect("a temporary folder");
        std::fs::write(folder.join(SCENE), "<scene version=\"3.0.0\"/>").expect("a temporary folder");
        let text = serde_json::to_vec(note).expect("plain data");
        std::fs::write(folder.join(NOTE), text).expect("a temporary folder");
        folder
    }

    /// Left by a program that runs no more: no process has the largest number.
    fn note(scene: Option<&Path>, time: u64) -> Note {
        Note {
            scene: scene.map(Path::to_owned),
            time,
            process: u32::MAX,
        }
    }

    #[test]
    fn what_is_written_aside_is_found_for_its_scene() {
        let all = tempfile::tempdir().expect("a temporary folder");
        let path = all.path().join("box.xml");
        let folder = folder_of(all.path(), Some(&path));
        assert_ne!(folder, folder_of(all.path(), None));
        write_aside(&folder, &SceneDescription::empty(), Some(path.clone())).expect("it can be written");
        let offer = find(all.path(), Some(&path)).expect("there is one");
        assert_eq!(
            (&offer.folder, offer.note.scene.as_deref()),
            (&folder, Some(path.as_path()))
        );
        assert_eq!(find(all.path(), Some(Path::new("/other.xml"))), None);
        discard(&offer);
        assert_eq!(find(all.path(), None), None);
        assert!(!folder.exists());
    }

    #[test]
    fn the_newest_is_offered_and_nothing_older_than_its_scene() {
        let all = tempfile::tempdir().expect("a temporary folder");
        let path = all.path().join("box.xml");
        aside(all.path(), "a", &note(None, 1000));
        let newest = aside(all.path(), "b", &note(Some(&path), 2000));
        assert_eq!(find(all.path(), None).map(|offer| offer.folder), Some(newest));
        // The scene was saved long after.
        std::fs::write(&path, "<scene/>").expect("a temporary folder");
        assert_eq!(find(all.path(), Some(&path)), None);
        assert_eq!(find(all.path(), None).map(|offer| offer.note.time), Some(1000));
    }

    #[test]
    fn what_is_half_written_or_of_a_running_program_is_left_alone() {
        let all = tempfile::tempdir().expect("a temporary folder");
        let path = Path::new("/box.xml");
        let half = aside(all.path(), "half", &note(Some(path), 1000));
        std::fs::remove_file(half.join(SCENE)).expect("it is there");
        std::fs::write(aside(all.path(), "odd", &note(None, 1)).join(NOTE), "{").expect("a temporary folder");
        if cfg!(target_os = "linux") {
            let process = 1;
            let running = Note {
                process,
                ..note(Some(path), 3000)
            };
            aside(all.path(), "running", &running);
        }
        assert_eq!(find(all.path(), None), None);
        // Folders without a note are none of ours.
        let other = all.path().join("other");
        std::fs::create_dir(&other).expect("a temporary folder");
        remove(&other);
        assert!(other.exists());
    }

    #[test]
    fn ages_are_legible() {
        assert_eq!((ago(3).as_str(), ago(61).as_str()), ("just now", "1 minute ago"));
        assert_eq!(
            (ago(7300).as_str(), ago(400_000).as_str()),
            ("2 hours ago", "4 days ago")
        );
    }
}
