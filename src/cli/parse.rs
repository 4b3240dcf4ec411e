//! Parses the values of command-line arguments; errors are sentences for the user.

use std::ffi::OsString;
use std::ops::{Range, RangeInclusive};
use std::str::FromStr;
use std::time::Duration;

use bevy::math::{UVec2, Vec3};
use sunroom::document::value::parse_noise;
use sunroom::layer::Layers;
use sunroom::photometry::exposure;
use sunroom::render::part::Crop;
use sunroom::render::tonemap::Display;
use sunroom::render::white_balance::WhiteBalance;
use sunroom::scene::IntegratorSettings;

/// The arguments, in which a word such as `-1` or `-5s` is joined to the option before it as its value. No option
/// begins with a digit, so that this is unambiguous, and the option itself checks the value.
pub fn with_negative_values(arguments: impl IntoIterator<Item = OsString>) -> Vec<OsString> {
    let is_negative = |word: &str| {
        let number = word.strip_prefix('-').map(|word| word.trim_start_matches('.'));
        number.is_some_and(|number| number.starts_with(|first: char| first.is_ascii_digit()))
    };
    let is_option = |word: &str| word.len() > 1 && word.starts_with('-') && !word.contains('=') && !is_negative(word);
    let mut joined: Vec<OsString> = Vec::new();
    let mut is_over = false;
    for argument in arguments {
        let option = joined.last_mut().filter(|last| last.to_str().is_some_and(is_option));
        match option {
            Some(option) if !is_over && argument.to_str().is_some_and(is_negative) => {
                let is_long = option.to_str().is_some_and(|option| option.starts_with("--"));
                option.push(if is_long { "=" } else { "" });
                option.push(argument);
            }
            _ => {
                is_over |= argument == "--";
                joined.push(argument);
            }
        }
    }
    joined
}

/// `NAME=VALUE`
pub fn define(text: &str) -> Result<(String, String), String> {
    match text.split_once('=') {
        Some((name, value)) if !name.is_empty() => Ok((name.to_owned(), value.to_owned())),
        _ => Err("expected NAME=VALUE".to_owned()),
    }
}

/// `z`, `-y`
pub fn axis(text: &str) -> Result<Vec3, String> {
    let (sign, name) = text.strip_prefix('-').map_or((1.0, text), |name| (-1.0, name));
    let place = ["x", "y", "z"].iter().position(|axis| *axis == name);
    let axis = place.map(|place| sign * Vec3::AXES[place]);
    axis.ok_or_else(|| "expected x, y, z, -x, -y or -z".to_owned())
}

/// `depth,normal`
pub fn layers(text: &str) -> Result<Layers, String> {
    Layers::parse(text).map_err(|error| error.to_string())
}

/// `0..256`
pub fn samples(text: &str) -> Result<Range<u32>, String> {
    let ends = text.split_once("..");
    let range = ends.and_then(|(start, end)| Some(start.trim().parse().ok()?..end.trim().parse().ok()?));
    range
        .filter(|range: &Range<u32>| !range.is_empty())
        .ok_or_else(|| "expected A..B, two whole numbers of which the second is greater".to_owned())
}

/// `0,0,640,480`
pub fn crop(text: &str) -> Result<Crop, String> {
    let numbers: Option<Vec<u32>> = text.split(',').map(|number| number.trim().parse().ok()).collect();
    match numbers.as_deref() {
        Some(&[x, y, width, height]) if width > 0 && height > 0 => Ok(Crop { x, y, width, height }),
        _ => Err("expected X,Y,WIDTH,HEIGHT in pixels".to_owned()),
    }
}

/// `320,240`, a pixel
pub fn pixel(text: &str) -> Result<UVec2, String> {
    let place = text.split_once(',');
    let place = place.and_then(|(x, y)| Some(UVec2::new(x.trim().parse().ok()?, y.trim().parse().ok()?)));
    place.ok_or_else(|| "expected X,Y in pixels".to_owned())
}

/// `4x2`, columns and rows
pub fn grid(text: &str) -> Result<[u32; 2], String> {
    let parts = text.split_once(['x', 'X']);
    let numbers = parts.and_then(|(columns, rows)| Some([columns.parse().ok()?, rows.parse().ok()?]));
    numbers
        .filter(|numbers| numbers.iter().all(|number| (1..=2048).contains(number)))
        .ok_or_else(|| "expected COLUMNSxROWS, each from 1 to 2048".to_owned())
}

/// `1280x720`
pub fn size(text: &str) -> Result<(u32, u32), String> {
    sides(text, 64..=16384)
}

/// Parses the size of a picture, as [`size`] does, but allows smaller ones.
pub fn picture_size(text: &str) -> Result<(u32, u32), String> {
    sides(text, 1..=65536)
}

fn sides(text: &str, possible: RangeInclusive<u32>) -> Result<(u32, u32), String> {
    let parts = text.split_once(['x', 'X']);
    parts
        .and_then(|(width, height)| Some((width.parse().ok()?, height.parse().ok()?)))
        .filter(|(width, height)| possible.contains(width) && possible.contains(height))
        .ok_or_else(|| {
            let (least, most) = (possible.start(), possible.end());
            format!("expected WIDTHxHEIGHT in pixels, each from {least} to {most}")
        })
}

/// `KELVIN` or `KELVIN,TINT`
pub fn white(text: &str) -> Result<WhiteBalance, String> {
    let (temperature, tint) = text.split_once(',').unwrap_or((text, "0"));
    let number = |text: &str| text.trim().parse::<f32>().ok();
    let balance = number(temperature).zip(number(tint));
    let (kelvin, tints) = (WhiteBalance::TEMPERATURES, WhiteBalance::TINTS);
    balance
        .filter(|(temperature, tint)| kelvin.contains(temperature) && tints.contains(tint))
        .map(|(temperature, tint)| WhiteBalance { temperature, tint })
        .ok_or_else(|| {
            format!(
                "expected a temperature from {} to {} kelvin, and perhaps a comma and a tint from {} to {}",
                kelvin.start(),
                kelvin.end(),
                tints.start(),
                tints.end()
            )
        })
}

/// A number in a range; `expected` describes the range.
pub fn within<T: FromStr + PartialOrd>(text: &str, range: RangeInclusive<T>, expected: &str) -> Result<T, String> {
    let number = text.trim().parse().ok();
    number
        .filter(|number| range.contains(number))
        .ok_or_else(|| format!("expected {expected}"))
}

/// An exposure in stops, of any form that [`exposure::parse`] takes.
pub fn exposure(text: &str) -> Result<f32, String> {
    let range = Display::EXPOSURES;
    let stops = exposure::parse(text).filter(|stops| range.contains(stops));
    stops.ok_or_else(|| {
        let (start, end) = (range.start(), range.end());
        format!("expected a number of stops from {start} to {end}, such as 1.5, or such as ev100:12 or f/8,1/60,400")
    })
}

/// The name of a layer or a channel.
pub fn layer(text: &str) -> Result<String, String> {
    match text.trim().is_empty() {
        true => Err("expected the name of a layer or channel, such as Albedo".to_owned()),
        false => Ok(text.to_owned()),
    }
}

/// A number with a unit: `500ms`, `60s`, `5m`, `2h`; seconds without one.
pub fn duration(text: &str) -> Result<Duration, String> {
    let split = text.find(|c: char| c.is_ascii_alphabetic()).unwrap_or(text.len());
    let (number, unit) = text.split_at(split);
    let seconds_per_unit = match unit {
        "ms" => 1e-3,
        "" | "s" => 1.0,
        "m" | "min" => 60.0,
        "h" => 3600.0,
        _ => return Err(format!("unknown unit `{unit}`: expected ms, s, m or h")),
    };
    let seconds = number
        .trim()
        .parse::<f64>()
        .map_err(|_| format!("`{number}` is not a number"))?
        * seconds_per_unit;
    Duration::try_from_secs_f64(seconds)
        .ok()
        .filter(|duration| !duration.is_zero())
        .ok_or_else(|| "expected a time above zero".to_owned())
}

/// A relative noise: `0.01` or `1%`.
pub fn noise(text: &str) -> Result<f32, String> {
    parse_noise(text).map_err(|error| error.to_string())
}

/// The percentile of a clamp.
pub fn percentile(text: &str) -> Result<f32, String> {
    let range = IntegratorSettings::CLAMP_PERCENTILES;
    let (start, end) = (range.start(), range.end());
    let expected = format!("a percentile from {start} to {end}, such as 99.9");
    within(text, range, &expected)
}

/// A number above 0.
pub fn density(text: &str) -> Result<f32, String> {
    let number = text.trim().parse::<f32>().ok();
    number
        .filter(|number| *number > 0.0 && number.is_finite())
        .ok_or_else(|| "expected a number above 0, such as 16".to_owned())
}

/// `HOST:PORT`
pub fn address(text: &str) -> Result<String, String> {
    let parts = text.rsplit_once(':');
    let is_good = parts.is_some_and(|(host, port)| !host.is_empty() && port.parse::<u16>().is_ok());
    let message = || "expected a host and a port, such as localhost:14158".to_owned();
    is_good.then(|| text.to_owned()).ok_or_else(message)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn negative_numbers_are_values_of_the_options_before_them() {
        let joined = |line: &str| {
            let words = with_negative_values(line.split(' ').map(OsString::from));
            words.join(" ".as_ref()).into_string().expect("it is text")
        };
        for (line, expected) in [
            ("render a.xml --exposure -1 -q", "render a.xml --exposure=-1 -q"),
            ("render --frames -3..5 -t -2", "render --frames=-3..5 -t-2"),
            ("render --time -5s --noise -.5", "render --time=-5s --noise=-.5"),
            ("render -3.xml --spp=4 -1", "render -3.xml --spp=4 -1"),
            ("submit a.xml -- --spp -1", "submit a.xml -- --spp -1"),
            ("merge -- -1 -2", "merge -- -1 -2"),
        ] {
            assert_eq!(joined(line), expected);
        }
    }

    #[test]
    fn addresses_have_a_host_and_a_port() {
        for good in ["localhost:14158", "10.0.0.1:1", "[::1]:80"] {
            assert_eq!(address(good).as_deref(), Ok(good));
        }
        for wrong in [
            "",
            "localhost",
            ":14158",
            "localhost:",
            "localhost:tev",
            "localhost:70000",
        ] {
            assert!(address(wrong).is_err(), "{wrong}");
        }
    }

    #[test]
    fn noise_is_a_share_or_percents() {
        assert_eq!([noise("0.02"), noise("2%"), noise("2 %")], [const { Ok(0.02) }; 3]);
        assert_eq!(noise("5%"), Ok(0.05));
        for wrong in ["", "%", "0", "-1%", "nan", "inf", "1e-60", "quiet", "0,01", "5", "101%"] {
            assert!(noise(wrong).is_err(), "{wrong}");
        }
    }

    #[test]
    fn durations_have_units() {
        assert_eq!(duration("60s"), Ok(Duration::from_secs(60)));
        assert_eq!(duration("1.5m"), Ok(Duration::from_secs(90)));
        assert_eq!(duration("250ms"), Ok(Duration::from_millis(250)));
        assert_eq!(duration("7"), Ok(Duration::from_secs(7)));
        for bad in ["", "s", "-1s", "0", "1 day", "1e400s", "NaN"] {
            assert!(duration(bad).is_err(), "{bad}");
        }
    }

    #[test]
    fn whites_are_temperatures_with_a_tint() {
        let balance = |temperature, tint| Ok(WhiteBalance { temperature, tint });
        assert_eq!(white("5000"), balance(5000.0, 0.0));
        assert_eq!(white("3200, -20"), balance(3200.0, -20.0));
        for bad in ["", "999", "15001", "5000,", "5000,151", "5000,1,2", "NaN"] {
            assert!(white(bad).is_err(), "{bad}");
        }
    }

    #[test]
    fn sizes_and_defines() {
        assert_eq!(size("1280x720"), Ok((1280, 720)));
        assert!(size("1280").is_err() && size("0x10").is_err() && size("1x-1").is_err());
        assert_eq!(picture_size("1x20"), Ok((1, 20)));
        assert!(picture_size("0x10").is_err());
        assert_eq!(define("spp=4=2"), Ok(("spp".into(), "4=2".into())));
        assert!(define("spp").is_err() && define("=4").is_err());
    }
}
