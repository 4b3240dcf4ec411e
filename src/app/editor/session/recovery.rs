//! Writes autosaves of edits that no file has, and offers them after a crash.

use std::path::{Path, PathBuf};
use std::time::{Duration, Instant, SystemTime, UNIX_EPOCH};

use bevy::prelude::*;
use bevy::tasks::{IoTaskPool, Task, block_on, futures::check_ready};

use super::aside::{Aside, SCENE, copy_of, left_over, remove_fragments};
use super::copying::Copying;
use super::file_hashes::FileHashes;
use super::history::History;
use super::recovery_words::summary;
use super::requests::Requests;
use super::stable_hash::stable_hash;
use super::toasts::{Toasts, Tone, Topic};
use crate::app::editor::command::Command;
use crate::app::editor::command::error::CommandError;
use crate::app::editor::command::preferences::Preferences;
use crate::app::editor::command::recovery_offer::Offer;
use crate::app::editor::command::shell::{Sheet, ShellCommand};
use crate::scene::write::KnownTexts;
use crate::scene::{OpenScene, SceneFile, SceneState, SceneStatus, Trust, ask_for};

/// The time per frame for copying the scene, and the number of things that are copied between two looks at the clock.
const LONGEST: Duration = Duration::from_millis(10);
const STEP: usize = 256;

/// The state of autosaving and recovery.
#[derive(Resource, Default)]
pub struct Recovery {
    /// The folder of all autosaves. None: nothing is autosaved.
    folder: Option<PathBuf>,
    /// The name of this run of the program.
    run: String,
    /// The time since which there have been edits without an autosave.
    since: Option<Instant>,
    is_due: bool,
    /// Whether there will be no later frame for an autosave.
    is_last_chance: bool,
    /// The autosave in progress.
    copy: Option<Copying>,
    task: Option<Task<Result<(), String>>>,
    /// The folders of this scene, which are removed once the scene is saved.
    mine: Vec<Aside>,
    /// The autosaves of other runs, the newest first, without those of running windows.
    pub left: Vec<Offer>,
    /// The hashes of the files of their scenes.
    hashes: FileHashes,
    /// The autosave that the user is asked about.
    pub offer: Option<Offer>,
    /// Whether a message has named the autosaves of other runs.
    is_told: bool,
    /// Whether there is no user: autosaves are kept for the next start.
    is_unattended: bool,
    /// The autosave that is being opened.
    returning: Option<(Offer, Aside)>,
    /// The last seen load of the scene, and the last seen failure.
    seen: (u64, u64),
}

impl Recovery {
    /// Whether the scene is being copied, a slice in each frame.
    pub(crate) fn is_copying(&self) -> bool {
        self.copy.is_some()
    }

    /// Autosaves into a folder below `folder`; without one, nothing is autosaved.
    pub fn new(folder: Option<&Path>) -> Self {
        let begun = SystemTime::now().duration_since(UNIX_EPOCH).unwrap_or_default();
        Self {
            folder: folder.map(|folder| folder.join("recovery")),
            run: format!("{}-{:x}", std::process::id(), begun.as_nanos()),
            ..Self::default()
        }
    }

    /// The same state, which shows questions only if a user is there to answer them.
    pub fn asking(self, is_attended: bool) -> Self {
        Self {
            is_unattended: !is_attended,
            ..self
        }
    }

    /// Finds the autosaves of other runs.
    pub(crate) fn look(&mut self) {
        let mut hashes = std::mem::take(&mut self.hashes);
        let all = self.folder.as_deref().filter(|_| !self.is_unattended);
        let left = all.map(|all| left_over(all, |folder| self.is_own(folder), &mut hashes));
        self.left = left.unwrap_or_default();
        self.hashes = hashes;
    }

    /// Whether this run has made or claimed the folder. Without file locks, this is the only test.
    fn is_own(&self, folder: &Path) -> bool {
        let returning = self.returning.iter().map(|(_, aside)| aside);
        let is_claimed = self.mine.iter().chain(returning).any(|aside| aside.folder == folder);
        let name = folder.file_name().unwrap_or_default().to_string_lossy();
        is_claimed || name.ends_with(&format!("-{}", self.run))
    }

    /// Finds them again, and updates the message if it is still shown.
    fn look_again(&mut self, toasts: &mut Toasts) {
        let before = std::mem::take(&mut self.left);
        self.look();
        if self.left != before && std::mem::take(&mut self.is_told) && toasts.forget(Topic::Recovery) {
            self.tell(toasts);
        }
    }

    /// Shows a message that names them, except the one that the user is asked about.
    fn tell(&mut self, toasts: &mut Toasts) {
        let is_other = |offer: &&Offer| self.offer.as_ref() != Some(*offer);
        let others: Vec<Offer> = self.left.iter().filter(is_other).cloned().collect();
        if !others.is_empty() {
            let text = summary(&others);
            let recover = Command::Shell(ShellCommand::ShowRecovery);
            info!("{text}");
            toasts.keep_offering((Tone::Note, Topic::Recovery), text, "Recover…", recover);
            self.is_told = true;
        }
    }

    /// The autosave of the scene at this path, if it has edits that the file has not. None if a window may be using it.
    pub(crate) fn newer_copy_of(&mut self, path: &Path) -> Option<Offer> {
        self.look();
        copy_of(&self.left, Some(path), false)
            .filter(|offer| !offer.is_outdated)
            .cloned()
    }

    /// Whether an autosave is being opened.
    pub fn is_returning(&self) -> bool {
        self.returning.is_some()
    }

    fn forget(&mut self) {
        // The write in progress is removed as well, even if that fails.
        if let Some(task) = self.task.take() {
            let _ = block_on(task);
        }
        self.copy = None;
        for aside in self.mine.drain(..) {
            aside.remove();
        }
        self.since = None;
    }

    /// The folder for autosaves of this scene; None without autosaving.
    fn folder_of(&self, scene: Option<&Path>) -> Option<PathBuf> {
        let name = match scene {
            Some(scene) => format!(
                "{:016x}-{}",
                stable_hash(scene.as_os_str().as_encoded_bytes()),
                self.run
            ),
            None => format!("untitled-{}", self.run),
        };
        Some(self.folder.as_ref()?.join(name))
    }
}

/// Notices new scenes, and scenes that cannot be read: their autosaves are offered, and those of the previous scene are
/// removed. At the start, autosaves of other runs are reported. To run after the history was cleared.
pub fn follow_scene(
    mut recovery: ResMut<Recovery>,
    mut status: ResMut<SceneStatus>,
    mut file: ResMut<SceneFile>,
    mut history: ResMut<History>,
    mut toasts: ResMut<Toasts>,
    mut known: ResMut<KnownTexts>,
    requests: Option<Res<Requests>>,
    mut started: Local<bool>,
) {
    let recovery = recovery.bypass_change_detection();
    let is_first = !std::mem::replace(&mut *started, true);
    let Some(all) = recovery.folder.clone() else {
        return;
    };
    // The start page lists them all.
    let is_on_page = requests.is_some_and(|requests| requests.sheet == Some(Sheet::Start));
    if is_first {
        remove_fragments(&all);
        recovery.look();
    }
    if is_first && status.subject().is_none() {
        recovery.offer = recovery.left.first().filter(|_| !is_on_page).cloned();
        recovery.tell(&mut toasts);
    }
    let seen = std::mem::replace(&mut recovery.seen, (status.revision, status.failures));
    let begins = !recovery.is_told && seen == (0, 0);
    if seen.1 != status.failures {
        let is_it = |(offer, _): &mut (Offer, Aside)| status.asked == Some(offer.folder.join(SCENE));
        let returning = recovery.returning.take_if(is_it);
        recovery.look();
        match returning {
            Some((offer, _)) => {
                let file = offer.folder.join(SCENE);
                let text = format!("{} could not be read; it is kept.", file.display());
                toasts.add(Tone::Error, Topic::Other, text, None);
            }
            // The open scene has no autosave.
            None if status.asked == status.path => {}
            None => recovery.offer = copy_of(&recovery.left, status.asked.as_deref(), false).cloned(),
        }
        if begins {
            recovery.tell(&mut toasts);
        }
    }
    if seen.0 == status.revision || !status.fresh_load {
        return;
    }
    recovery.forget();
    match recovery.returning.take() {
        Some((offer, aside)) => {
            file.leave();
            // Changes by others from now on must not be overwritten without a question.
            if let Some(scene) = &offer.note.scene {
                known.note_present(scene);
            }
            status.path = offer.note.scene;
            history.note_unsaved();
            recovery.mine.push(aside);
            recovery.look_again(&mut toasts);
            toasts.info("Recovered; save the scene to keep it");
        }
        None => {
            recovery.look_again(&mut toasts);
            let copy = copy_of(&recovery.left, status.path.as_deref(), seen.0 == 0);
            recovery.offer = copy.filter(|_| !is_on_page).cloned();
            if begins {
                recovery.tell(&mut toasts);
            }
        }
    }
}

/// Decides when to autosave, and removes folders that are no longer needed. A run that ends without asking the user,
/// such as by a signal, autosaves at once.
pub(crate) fn plan_autosave(
    mut recovery: ResMut<Recovery>,
    mut toasts: ResMut<Toasts>,
    history: Res<History>,
    status: Res<SceneStatus>,
    preferences: Res<Preferences>,
    mut exits: MessageReader<AppExit>,
) {
    let recovery = recovery.bypass_change_detection();
    recovery.is_due = false;
    let copy = recovery.copy.take();
    if recovery.folder.is_none() {
        return;
    }
    let breaks_off = exits.read().any(AppExit::is_error);
    let outcome = match breaks_off {
        true => recovery.task.take().map(block_on),
        false => recovery.task.as_mut().and_then(check_ready),
    };
    if let Some(outcome) = outcome {
        recovery.task = None;
        if let Err(error) = outcome {
            let text = format!("The edits could not be written aside: {error}");
            toasts.add(Tone::Error, Topic::Saving, text, None);
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
    // Another scene may be about to replace this one, whose edits will not be needed then; but until it has, they exist
    // nowhere else.
    let is_staying = recovery.returning.is_none() && status.state != SceneState::Loading;
    // While the scene is being saved its entities do not all belong to one file.
    recovery.is_due = breaks_off || is_over && is_staying && !history.is_saving();
    recovery.is_last_chance = breaks_off;
    if recovery.is_due {
        recovery.copy = copy;
    }
}

/// Whether [`autosave`] is to run in this frame.
pub fn is_due(recovery: Res<Recovery>) -> bool {
    recovery.is_due
}

/// Copies the scene, over several frames if it is large, and writes the autosave in the background.
pub fn autosave(world: &mut World) {
    let begun = Instant::now();
    let copy = world.resource_mut::<Recovery>().copy.take();
    let mut copy = copy.unwrap_or_else(|| Copying::begin(world));
    while !copy.scene.step(world, STEP) {
        if begun.elapsed() > LONGEST && !world.resource::<Recovery>().is_last_chance {
            world.resource_mut::<Recovery>().copy = Some(copy);
            return;
        }
    }
    let mut recovery = world.resource_mut::<Recovery>();
    let Some(folder) = recovery.folder_of(copy.path.as_deref()) else {
        return;
    };
    if !recovery.mine.iter().any(|aside| aside.folder == folder) {
        recovery.mine.extend(Aside::claim(&folder));
    }
    recovery.since = Some(Instant::now());
    recovery.task = Some(IoTaskPool::get().spawn(async move { copy.write(&folder).await }));
}

/// Removes the autosaves after a good end. Otherwise waits for the write in progress.
pub(crate) fn clean_up(mut exits: MessageReader<AppExit>, mut recovery: ResMut<Recovery>) {
    let Some(exit) = exits.read().last() else {
        return;
    };
    if exit.is_success() {
        recovery.forget();
    } else if let Some(task) = recovery.task.take() {
        match block_on(task) {
            Ok(()) => info!("The unsaved edits are kept and will be offered when the scene is opened again"),
            Err(error) => error!("The unsaved edits could not be written aside: {error}"),
        }
    }
}

/// Opens an autosave.
pub fn recover(world: &mut World, offer: Offer) -> Result<(), CommandError> {
    let path = offer.folder.join(SCENE);
    let aside = claim(&offer)?;
    // It names files in the folder of the scene.
    if let Some(folder) = offer.note.scene.as_deref().and_then(Path::parent)
        && let Trust::Folders(folders) = &mut *world.resource_mut::<Trust>()
    {
        folders.push(folder.to_owned());
    }
    if let Some(mut requests) = world.get_resource_mut::<Requests>() {
        requests.leave_start_page();
    }
    world.resource_mut::<Recovery>().returning = Some((offer, aside));
    let request = OpenScene {
        path,
        ..OpenScene::default()
    };
    ask_for(world, request);
    Ok(())
}

/// Whether the autosave is of the scene in this file.
pub(crate) fn is_copy_of(offer: &Offer, scene: &Path) -> bool {
    copy_of(std::slice::from_ref(offer), Some(scene), false).is_some()
}

/// Deletes an autosave. An error if another window has it open, or had.
pub fn discard(offer: &Offer) -> Result<(), CommandError> {
    claim(offer)?.remove();
    Ok(())
}

/// Claims the folder of an autosave.
fn claim(offer: &Offer) -> Result<Aside, CommandError> {
    let is_there = || offer.folder.join(SCENE).is_file();
    if !is_there() {
        return Err(GONE.into());
    }
    let aside = Aside::claim(&offer.folder).ok_or(IN_USE)?;
    // Another window may just have removed it.
    if !is_there() {
        aside.remove();
        return Err(GONE.into());
    }
    Ok(aside)
}

const IN_USE: &str = "Another window is at work on those edits.";
const GONE: &str = "Those edits are not there any more: another window has recovered or discarded them.";

/// Asks about the autosaves of other runs; if there are several, all are listed.
pub(crate) fn show(world: &mut World) {
    look_again(world);
    let left = world.resource::<Recovery>().left.clone();
    match &left[..] {
        [] => {
            let text = "There is nothing to recover: no scene has edits that were lost.";
            world.resource_mut::<Toasts>().info(text);
        }
        [only] => world.resource_mut::<Recovery>().offer = Some(only.clone()),
        _ => world.resource_mut::<Requests>().sheet = Some(Sheet::Recovery),
    }
}

/// Finds autosaves again, for instance because the user has been in another window.
pub(crate) fn look_again(world: &mut World) {
    world.resource_scope(|world, mut recovery: Mut<Recovery>| {
        let mut toasts = world.resource_mut::<Toasts>();
        recovery.look_again(&mut toasts);
    });
}

#[cfg(test)]
mod tests {
    use super::super::aside::write_aside;
    use super::super::requests::Requests;
    use super::super::view_settings::ViewSettings;
    use super::*;
    use crate::scene::SceneDescription;

    #[test]
    fn what_is_written_aside_is_found_for_its_scene() {
        let home = tempfile::tempdir().expect("a temporary folder");
        let all = home.path().join("recovery");
        let path = home.path().join("box.xml");
        let folder = Recovery::new(Some(home.path()))
            .folder_of(Some(&path))
            .expect("a folder");
        write_aside(&folder, &SceneDescription::empty(), Some(path.clone()), None).expect("it can be written");
        let left_over = |all| left_over(all, |_| false, &mut FileHashes::default());
        let offers = left_over(&all);
        let offer = copy_of(&offers, Some(&path), false).expect("there is one");
        let camera_and_sky = Some(2);
        assert_eq!(
            (&offer.folder, offer.note.scene.as_deref(), offer.note.things),
            (&folder, Some(path.as_path()), camera_and_sky)
        );
        assert_eq!(copy_of(&offers, Some(Path::new("/other.xml")), true), None);
        assert!(discard(offer).is_ok());
        assert_eq!(left_over(&all), []);
        assert!(!folder.exists());
    }

    #[test]
    fn a_run_that_breaks_off_while_a_scene_is_read_keeps_the_edits_of_the_one_before() {
        use bevy::ecs::system::RunSystemOnce;
        let home = tempfile::tempdir().expect("a temporary folder");
        let mut world = World::new();
        world.insert_resource(Recovery::new(Some(home.path())));
        world.init_resource::<ViewSettings>();
        world.init_resource::<Requests>();
        world.init_resource::<Toasts>();
        world.init_resource::<History>();
        world.init_resource::<Preferences>();
        world.init_resource::<Messages<AppExit>>();
        world.insert_resource(SceneStatus {
            state: SceneState::Loading,
            ..SceneStatus::default()
        });
        world.resource_mut::<History>().note_unsaved();
        let mut plan = || {
            world.run_system_once(plan_autosave).expect("it runs");
            let is_due = world.resource::<Recovery>().is_due;
            world.write_message(AppExit::error());
            is_due
        };
        assert_eq!([plan(), plan()], [false, true]);
    }

    /// Process ids are reused.
    #[test]
    fn runs_do_not_share_folders() {
        let folders: Vec<_> = (0..2)
            .map(|_| Recovery::new(Some(Path::new("/home"))))
            .flat_map(|run| [run.folder_of(None), run.folder_of(Some(Path::new("/a.xml")))])
            .collect();
        for (index, folder) in folders.iter().enumerate() {
            assert!(!folders[..index].contains(folder), "{folders:?}");
        }
    }
}
