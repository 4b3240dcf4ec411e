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
