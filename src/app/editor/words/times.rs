//! Times of the system as texts.

use jiff::Timestamp;
use jiff::tz::TimeZone;

/// The time of day in the zone of the system, with the date if it is not today. `seconds` count from 1970. None if the time is not known.
pub fn clock_of(seconds: u64) -> Option<String> {
    let time = Timestamp::from_second(i64::try_from(seconds).ok()?).ok()?;
    let zone = TimeZone::system();
    let (then, now) = (
        time.to_zoned_datetime(zone.clone()),
        Timestamp::now().to_zoned_datetime(zone),
    );
    let clock = format!("{:02}:{:02}", then.hour(), then.minute());
    Some(match then.date() == now.date() {
        true => clock,
        false => format!("{} {clock}", then.date()),
    })
}
