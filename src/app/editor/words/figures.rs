//! Numbers with words.

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
