//! The question what to do with edits that were written aside.

use std::time::{SystemTime, UNIX_EPOCH};

use bevy_egui::egui;

use super::dialog;
use crate::app::editor::command::Command;
use crate::app::editor::command::recovery_offer::{Note, Offer};
use crate::app::editor::command::shell::ShellCommand;
use crate::app::editor::panels::look;
use crate::app::editor::words::times::{ago, changed_at, clock_of};

/// Asks what to do with the edits; `offer` is None once that is answered.
pub fn question(context: &egui::Context, offer: &mut Option<Offer>, commands: &mut Vec<Command>) {
    let Some(asked) = offer else {
        return;
    };
    let since_1970 = SystemTime::now().duration_since(UNIX_EPOCH).unwrap_or_default();
    let since = |time: u64| ago(since_1970.as_secs().saturating_sub(time));
    let clock = clock_of(asked.note.time);
    let mut answer = None;
    let modal = dialog::question(context, "recovery", 460.0, "Recover unsaved edits?", |ui| {
        let scene = name_of(&asked.note);
        let age = since(asked.note.time);
        let when = match &clock {
            Some(clock) => format!("at {clock}, {age}"),
            None => age,
        };
        ui.label(format!(
            "The program ended without saving the last edits of {scene}. A copy of them was written {when}."
        ));
        let changed = asked.note.scene.as_deref().map(changed_at);
        if let Some(file) = changed.and_then(|changed| about_file(changed, asked.note.time, since)) {
            ui.add_space(4.0);
            ui.label(file);
        }
        ui.add_space(6.0);
        dialog::consequence(
            ui,
            "Recover",
            "the scene opens with those edits. No file is changed until you save.",
        );
        dialog::consequence(
            ui,
            "Later",
            "the copy stays, and the question comes again at the next start.",
        );
        dialog::consequence(ui, "Discard", "the copy is deleted, and the edits are lost.");
        let discard = look::danger(ui, "Discard");
        let recover = look::primary(ui, &recover_text(clock.as_deref()));
        let (mut discards, mut recovers) = (false, false);
        dialog::answers(
            ui,
            |ui| discards = ui.add(discard).clicked(),
            |ui| {
                recovers = ui.add(recover).clicked();
                if ui.button("Later").on_hover_text("Esc").clicked() {
                    ui.close();
                }
            },
        );
        if recovers {
            answer = Some(ShellCommand::Recover(asked.clone()));
        } else if discards {
            answer = Some(ShellCommand::DiscardRecovery(asked.clone()));
        }
    });
    if answer.is_some() || modal.should_close() {
        commands.extend(answer.map(Command::Shell));
        *offer = None;
    }
}

/// The text of the button, such as "Recover the copy of 14:32".
fn recover_text(clock: Option<&str>) -> String {
    match clock {
        Some(clock) => format!("Recover the copy of {clock}"),
        None => "Recover the copy".to_owned(),
    }
}

fn name_of(note: &Note) -> String {
    match (&note.scene, note.things) {
        (Some(path), _) => path.display().to_string(),
        (None, None) => "a scene that was never saved".to_owned(),
        (None, Some(1)) => "a scene of 1 thing that was never saved".to_owned(),
        (None, Some(things)) => format!("a scene of {things} things that was never saved"),
    }
}

/// A sentence about changes of the file since then. `changed` is None if the file is gone. The sentence is empty if the file has not changed.
fn about_file(changed: Option<u64>, written: u64, since: impl Fn(u64) -> String) -> Option<String> {
    match changed {
        None => Some("That file is not there any more; saving makes it anew.".to_owned()),
        Some(changed) if changed > written => Some(format!(
            "The file was changed after that, {}: the edits here are older. Saving them replaces what is there.",
            since(changed)
        )),
        Some(_) => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn it_is_told_when_the_file_was_changed_after_that() {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let path = folder.path().join("box.xml");
        std::fs::write(&path, "<scene/>").expect("a temporary folder");
        let told = |written| about_file(changed_at(&path), written, |_| "now".to_owned());
        assert!(told(2000).is_some_and(|text| text.contains("changed after that, now")));
        assert_eq!(told(u64::MAX), None);
        assert!(about_file(None, 0, |_| String::new()).is_some_and(|text| text.contains("not there")));
    }

    #[test]
    fn a_scene_without_a_file_is_known_by_its_size() {
        let named = |things| {
            name_of(&Note {
                things,
                ..Note::default()
            })
        };
        assert_eq!(named(Some(3)), "a scene of 3 things that was never saved");
        assert_eq!(named(None), "a scene that was never saved");
    }

    #[test]
    fn the_button_says_which_copy() {
        assert_eq!(recover_text(Some("14:32")), "Recover the copy of 14:32");
        let today = SystemTime::now().duration_since(UNIX_EPOCH).expect("after 1970");
        let clock = clock_of(today.as_secs()).expect("a time");
        assert!(clock.len() == 5 && clock.as_bytes()[2] == b':', "{clock}");
        // Every time zone differs from universal time by less than a day.
        assert!(clock_of(86_400).is_some_and(|clock| clock.starts_with("1970-01-0")));
        assert_eq!(clock_of(u64::MAX), None);
    }
}
