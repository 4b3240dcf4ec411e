//! Times of the system as texts.

use std::path::Path;
use std::time::{SystemTime, UNIX_EPOCH};

use jiff::Timestamp;
use jiff::tz::TimeZone;

/// The time of day in the zone of the system, with the date if it is not today. `seconds` count from 1970. None if the
/// time is not known.
pub fn clock_of(seconds: u64) -> Option<String> {
    clock(seconds, false)
}

/// The same with seconds, for times within a minute.
pub(crate) fn exact_clock_of(seconds: u64) -> Option<String> {
    clock(seconds, true)
}

fn clock(seconds: u64, is_exact: bool) -> Option<String> {
    let time = Timestamp::from_second(i64::try_from(seconds).ok()?).ok()?;
    let zone = TimeZone::system();
    let (then, now) = (
        time.to_zoned_datetime(zone.clone()),
        Timestamp::now().to_zoned_datetime(zone),
    );
    let mut clock = format!("{:02}:{:02}", then.hour(), then.minute());
    if is_exact {
        clock.push_str(&format!(":{:02}", then.second()));
    }
    Some(match then.date() == now.date() {
        true => clock,
        false => format!("{} {clock}", then.date()),
    })
}

/// The age of a time, such as `2 hours ago`.
pub(crate) fn ago(seconds: u64) -> String {
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

/// The time of a file's last change, in seconds since 1970.
pub(crate) fn changed_at(file: &Path) -> Option<u64> {
    let changed = std::fs::metadata(file).and_then(|data| data.modified()).ok()?;
    Some(changed.duration_since(UNIX_EPOCH).ok()?.as_secs())
}

/// The time of a file's last save, such as `Last saved at 14:32, 5 minutes ago.` None if there is no file.
pub(crate) fn last_saved(file: &Path) -> Option<String> {
    let changed = changed_at(file)?;
    let now = SystemTime::now().duration_since(UNIX_EPOCH).ok()?.as_secs();
    let age = ago(now.saturating_sub(changed));
    Some(match clock_of(changed) {
        Some(clock) => format!("Last saved at {clock}, {age}."),
        None => format!("Last saved {age}."),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn clocks_have_the_date_of_other_days() {
        let today = SystemTime::now().duration_since(UNIX_EPOCH).expect("after 1970");
        let clock = clock_of(today.as_secs()).expect("a time");
        assert!(clock.len() == 5 && clock.as_bytes()[2] == b':', "{clock}");
        // Every time zone differs from universal time by less than a day.
        assert!(clock_of(86_400).is_some_and(|clock| clock.starts_with("1970-01-0")));
        assert_eq!(clock_of(u64::MAX), None);
    }

    #[test]
    fn ages_are_legible() {
        assert_eq!((ago(3).as_str(), ago(61).as_str()), ("just now", "1 minute ago"));
        assert_eq!(
            (ago(7300).as_str(), ago(400_000).as_str()),
            ("2 hours ago", "4 days ago")
        );
    }

    #[test]
    fn a_file_says_when_it_was_saved() {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let path = folder.path().join("box.xml");
        assert_eq!(last_saved(&path), None);
        std::fs::write(&path, "<scene/>").expect("a temporary folder");
        let text = last_saved(&path).expect("it is there");
        assert!(
            text.starts_with("Last saved at ") && text.ends_with(", just now."),
            "{text}"
        );
    }
}
