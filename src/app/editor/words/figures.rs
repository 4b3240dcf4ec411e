//! Numbers as texts, with their nouns.

use std::ops::RangeInclusive;

use bevy_egui::egui;

/// The number with its noun: `1 node`, `2,345 nodes`, `3 leaves`.
pub fn counted(number: u64, what: &str) -> String {
    match what.strip_suffix('f') {
        _ if number == 1 => format!("1 {what}"),
        Some(stem) => format!("{} {stem}ves", grouped(number)),
        None => format!("{} {what}s", grouped(number)),
    }
}

/// The digits in groups of three.
pub fn grouped(number: u64) -> String {
    let digits = number.to_string();
    let mut grouped = String::new();
    for (place, digit) in digits.chars().enumerate() {
        if place > 0 && (digits.len() - place).is_multiple_of(3) {
            grouped.push(',');
        }
        grouped.push(digit);
    }
    grouped
}

/// A length in three digits, such as `0.5`, `12.2` or `1230`.
pub(crate) fn length(units: f32) -> String {
    if units == 0.0 || !units.is_finite() {
        return "0".to_owned();
    }
    let decimals = (2 - units.abs().log10().floor() as i32).clamp(0, 6) as usize;
    let text = format!("{units:.decimals$}");
    match text.contains('.') {
        true => text.trim_end_matches('0').trim_end_matches('.').to_owned(),
        false => text,
    }
}

/// A number in few characters: large ones have three digits and the power of ten, and zero has no minus.
pub(crate) fn legible(number: f64, decimals: RangeInclusive<usize>) -> String {
    const LARGEST: f64 = 1e7;
    if number.abs() >= LARGEST {
        return format!("{number:.2e}");
    }
    let text = egui::emath::format_with_decimals_in_range(number, decimals);
    match text.strip_prefix('-') {
        Some(unsigned) if unsigned.bytes().all(|byte| byte == b'0' || byte == b'.') => unsigned.to_owned(),
        _ => text,
    }
}

/// The decimals of numbers that stand side by side, at most.
pub(crate) const MOST_DECIMALS: usize = 3;

/// The decimals of numbers in panels, unless they need more to be told from others.
pub(crate) const USUAL_DECIMALS: usize = 2;

/// The unit of angles.
pub(crate) const DEGREES: &str = "°";

/// The decimals of numbers in this unit in panels, unless they need more. Times are whole numbers mostly, and the sign
/// of degrees takes the room of a decimal.
pub(crate) fn usual_decimals(unit: &str) -> usize {
    match unit {
        " h" | " min" | " s" => 0,
        DEGREES => 1,
        _ => USUAL_DECIMALS,
    }
}

/// A number in a panel: with the decimals that are usual in its unit, and with more, of those in the range, if it needs
/// them. Large whole numbers have none.
pub(crate) fn tidy(unit: &str, number: f64, decimals: RangeInclusive<usize>) -> String {
    const MANY: f64 = 100.0;
    let most = *decimals.end();
    let shown = |decimals: usize| format!("{number:.decimals$}").parse::<f64>().unwrap_or_default();
    if most == 0 || (number.abs() >= MANY && shown(0) == shown(most)) {
        return legible(number, 0..=0);
    }
    let fewest = usual_decimals(unit).min(most);
    let needed = (fewest..most)
        .find(|fewer| shown(*fewer) == shown(most))
        .unwrap_or(most);
    legible(number, needed..=needed)
}

/// The number of decimals that shows a number as exactly as [`MOST_DECIMALS`] do.
pub(crate) fn decimals(number: f32) -> usize {
    let shown = |decimals: usize| format!("{number:.decimals$}").parse::<f64>().unwrap_or_default();
    (0..MOST_DECIMALS)
        .find(|fewer| shown(*fewer) == shown(MOST_DECIMALS))
        .unwrap_or(MOST_DECIMALS)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_stay_short() {
        let shown = |number: f64| legible(number, 0..=3);
        assert_eq!(shown(1.5), "1.5");
        assert_eq!(shown(-1e-9), "0");
        assert_eq!(legible(-1e-9, 2..=3), "0.00");
        assert_eq!(shown(-0.25), "-0.25");
        assert_eq!(shown(f64::from(f32::MAX)), "3.40e38");
        assert_eq!(shown(-2e7), "-2.00e7");
    }

    #[test]
    fn numbers_of_panels_have_two_decimals_or_the_ones_that_they_need() {
        let cases = [
            (f64::from(5.8_f32), "5.80"),
            (0.0, "0.00"),
            (1.0, "1.00"),
            (35.6894, "35.6894"),
            (1e-3, "0.001"),
            (600.0, "600"),
            (600.5, "600.50"),
            (10_000.0, "10000"),
            (-0.2, "-0.20"),
            (2e8, "2.00e8"),
        ];
        for (number, text) in cases {
            assert_eq!(tidy("", number, 1..=4), text);
        }
        assert_eq!(
            [tidy("", 0.0, 1..=1), tidy("", 6504.0, 0..=0), tidy("", 0.46, 0..=1)],
            ["0.0", "6504", "0.5"]
        );
    }

    #[test]
    fn times_are_whole_and_angles_have_a_decimal_unless_they_need_more() {
        let cases = [
            (" h", 9.0, "9"),
            (" h", 9.5, "9.5"),
            (" s", 0.0, "0"),
            (" min", 12.25, "12.25"),
            (DEGREES, 45.0, "45.0"),
            (DEGREES, 22.55, "22.55"),
            (DEGREES, 180.0, "180"),
            (DEGREES, f64::from(39.308_f32), "39.308"),
            (" m", 9.0, "9.00"),
        ];
        for (unit, number, text) in cases {
            assert_eq!(tidy(unit, number, 0..=3), text, "{unit}");
        }
    }

    #[test]
    fn numbers_have_the_decimals_that_they_need() {
        for (number, needed) in [(4.0, 0), (0.1, 1), (-0.25, 2), (1e-5, 0), (1.0 / 3.0, 3), (3e38, 0)] {
            assert_eq!(decimals(number), needed, "{number}");
        }
    }
}
