//! Texts about edits that can be recovered.

use std::path::Path;
use std::time::{SystemTime, UNIX_EPOCH};

use crate::app::editor::command::recovery_offer::{Note, Offer};
use crate::app::editor::words::files::folders_apart;
use crate::app::editor::words::times::{ago, changed_at, clock_of, exact_clock_of};

/// The most scenes that a message names.
const MOST_NAMED: usize = 4;

/// The scene of an autosave, named by the path of its file.
pub(crate) fn scene_of(offer: &Offer) -> String {
    match &offer.note.scene {
        Some(path) => path.display().to_string(),
        None => unnamed(offer),
    }
}

fn unnamed(offer: &Offer) -> String {
    match offer.note.things {
        _ if offer.is_damaged => "a scene whose name is lost".to_owned(),
        None => "a scene that was never saved".to_owned(),
        Some(1) => "a scene of 1 thing that was never saved".to_owned(),
        Some(things) => format!("a scene of {things} things that was never saved"),
    }
}

/// Short names of the scenes: the file names, with as much of the folder as tells files of the same name apart.
pub(crate) fn short_names(offers: &[Offer]) -> Vec<String> {
    let mut paths: Vec<&Path> = offers.iter().filter_map(|offer| offer.note.scene.as_deref()).collect();
    paths.sort_unstable();
    paths.dedup();
    let folders = folders_apart(&paths);
    let short = |offer: &Offer| {
        let Some(path) = &offer.note.scene else {
            return unnamed(offer);
        };
        let name = path.file_name().unwrap_or(path.as_os_str()).to_string_lossy();
        let is_alone = paths
            .iter()
            .filter(|other| other.file_name() == path.file_name())
            .count()
            < 2;
        let place = paths.iter().position(|other| other == path);
        match place.map(|place| &folders[place]) {
            Some(folder) if !is_alone => format!("{folder}/{name}"),
            _ => name.into_owned(),
        }
    };
    offers.iter().map(short).collect()
}

/// The time at which an autosave was written, such as `20:48`.
pub(crate) fn time_of(note: &Note) -> Option<String> {
    clock_of(note.time)
}

/// The time at which each autosave was written, with seconds if autosaves of one scene are of the same minute.
pub(crate) fn times_of(offers: &[Offer]) -> Vec<Option<String>> {
    let time = |offer: &Offer| {
        let clock = time_of(&offer.note);
        let is_like_it = |other: &&Offer| other.note.scene == offer.note.scene && time_of(&other.note) == clock;
        match offers.iter().filter(is_like_it).count() {
            0 | 1 => clock,
            _ => exact_clock_of(offer.note.time),
        }
    };
    offers.iter().map(time).collect()
}

/// The time at which an autosave was written, with its age.
pub(crate) fn time_and_age(note: &Note) -> String {
    with_age(time_of(note), note)
}

/// A time, as of [`times_of`], with the age of the autosave. One from the future was written by another clock.
pub(crate) fn with_age(time: Option<String>, note: &Note) -> String {
    let age = SystemTime::now()
        .duration_since(UNIX_EPOCH)
        .ok()
        .and_then(|now| now.as_secs().checked_sub(note.time))
        .map(ago);
    match (time, age) {
        (Some(clock), Some(age)) => format!("at {clock}, {age}"),
        (Some(clock), None) => format!("at {clock}, by a clock that was ahead"),
        (None, Some(age)) => age,
        (None, None) => "at an unknown time".to_owned(),
    }
}

/// The number of scenes to recover, such as `1 scene has unsaved edits`, and the number of autosaves if a scene has
/// several.
pub(crate) fn count_of(offers: &[Offer]) -> String {
    // A scene that was never saved counts as one in each autosave.
    let mut scenes: Vec<&Path> = offers
        .iter()
        .map(|offer| offer.note.scene.as_ref().unwrap_or(&offer.folder).as_path())
        .collect();
    scenes.sort_unstable();
    scenes.dedup();
    let count = match scenes.len() {
        1 => "1 scene has unsaved edits".to_owned(),
        count => format!("{count} scenes have unsaved edits"),
    };
    match offers.len() {
        copies if copies > scenes.len() => format!("{count}, in {copies} copies"),
        _ => count,
    }
}

/// A sentence that sums up the edits to recover.
pub(crate) fn summary(offers: &[Offer]) -> String {
    let named = short_names(offers).into_iter().zip(times_of(offers)).take(MOST_NAMED);
    let mut named: Vec<String> = named
        .map(|(name, time)| match time {
            Some(clock) => format!("{name} of {clock}"),
            None => name,
        })
        .collect();
    if offers.len() > MOST_NAMED {
        named.push(format!("and {} more", offers.len() - MOST_NAMED));
    }
    format!("{}: {}.", count_of(offers), named.join(", "))
}

/// A sentence about the scene's file; None if the file needs no remark.
pub(crate) fn about_file(offer: &Offer) -> Option<String> {
    let path = offer.note.scene.as_deref()?;
    let Some(changed) = changed_at(path) else {
        return Some("That file is not there any more; saving makes it anew.".to_owned());
    };
    let now = SystemTime::now().duration_since(UNIX_EPOCH).unwrap_or_default();
    let age = match now.as_secs().checked_sub(changed) {
        Some(age) => format!(", {}", ago(age)),
        None => String::new(),
    };
    offer.is_outdated.then(|| {
        format!("The file was changed after that{age}: the edits here are older. Saving them replaces what is there.")
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn offer(scene: Option<&str>, time: u64) -> Offer {
        let note = Note {
            scene: scene.map(Into::into),
            time,
            ..Note::default()
        };
        Offer {
            folder: format!("/recovery/{time}").into(),
            note,
            ..Offer::default()
        }
    }

    #[test]
    fn a_scene_without_a_file_is_known_by_its_size() {
        let named = |things, is_damaged| {
            let mut offer = offer(None, 0);
            (offer.note.things, offer.is_damaged) = (things, is_damaged);
            scene_of(&offer)
        };
        assert_eq!(named(Some(3), false), "a scene of 3 things that was never saved");
        assert_eq!(named(None, false), "a scene that was never saved");
        assert_eq!(named(None, true), "a scene whose name is lost");
    }

    #[test]
    fn a_message_names_every_scene_with_its_time() {
        let time = |seconds| clock_of(seconds).expect("a time");
        let one = [offer(Some("/rooms/flat.xml"), 1000)];
        assert_eq!(
            summary(&one),
            format!("1 scene has unsaved edits: flat.xml of {}.", time(1000))
        );
        let several = [
            offer(Some("/a/box.xml"), 5000),
            offer(Some("/b/box.xml"), 4000),
            offer(None, 3000),
            offer(Some("/a/box.xml"), u64::MAX),
            offer(None, 1000),
            offer(None, 0),
        ];
        let expected = format!(
            "5 scenes have unsaved edits, in 6 copies: a/box.xml of {}, b/box.xml of {}, a scene that was never saved of {}, a/box.xml, and 2 more.",
            time(5000),
            time(4000),
            time(3000)
        );
        assert_eq!(summary(&several), expected);
    }

    #[test]
    fn copies_of_one_scene_and_one_minute_are_told_apart() {
        let exact = |seconds| exact_clock_of(seconds).expect("a time");
        // Whole minutes are so in every time zone of these days.
        let minute = 60 * 20_000_000;
        let copies = [
            offer(Some("/a/box.xml"), minute + 40),
            offer(Some("/a/box.xml"), minute + 7),
            offer(Some("/b/room.xml"), minute + 7),
        ];
        let (late, early, other) = (exact(minute + 40), exact(minute + 7), clock_of(minute).expect("a time"));
        assert!(late.ends_with(":40") && early.ends_with(":07"), "{late}, {early}");
        let expected = format!(
            "2 scenes have unsaved edits, in 3 copies: box.xml of {late}, box.xml of {early}, room.xml of {other}."
        );
        assert_eq!(summary(&copies), expected);
        assert_eq!(count_of(&copies[..2]), "1 scene has unsaved edits, in 2 copies");
    }

    #[test]
    fn a_copy_of_the_future_has_no_age() {
        let now = SystemTime::now()
            .duration_since(UNIX_EPOCH)
            .expect("after 1970")
            .as_secs();
        let told = |time| time_and_age(&offer(None, time).note);
        assert!(told(now).ends_with(", just now"), "{}", told(now));
        assert!(told(now + 7200).ends_with("by a clock that was ahead"));
        assert_eq!(told(u64::MAX), "at an unknown time");
    }

    #[test]
    fn it_is_told_when_the_file_was_changed_after_that() {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let path = folder.path().join("box.xml");
        let mut offer = offer(path.to_str(), 0);
        assert!(about_file(&offer).is_some_and(|text| text.contains("not there")));
        std::fs::write(&path, "<scene/>").expect("a temporary folder");
        assert_eq!(about_file(&offer), None);
        offer.is_outdated = true;
        assert!(about_file(&offer).is_some_and(|text| text.contains("changed after that, just now")));
    }
}
