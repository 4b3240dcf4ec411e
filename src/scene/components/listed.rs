//! Lists of names within sentences.

/// The names as a part of a sentence, such as `a, b and c`, or `a, b and 7 more` if there are more than `most` names.
pub(crate) fn listed<T: AsRef<str>>(names: &[T], most: usize) -> String {
    let mut parts: Vec<String> = names.iter().take(most).map(|name| name.as_ref().to_owned()).collect();
    if let Some(more @ 1..) = names.len().checked_sub(most) {
        parts.push(format!("{more} more"));
    }
    match parts.pop() {
        None => String::new(),
        Some(last) if parts.is_empty() => last,
        Some(last) => format!("{} and {last}", parts.join(", ")),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_beyond_the_limit_are_counted() {
        for (names, expected) in [
            (&[][..], ""),
            (&["a"], "a"),
            (&["a", "b"], "a and b"),
            (&["a", "b", "c"], "a, b and c"),
            (&["a", "b", "c", "d", "e"], "a, b, c and 2 more"),
        ] {
            assert_eq!(listed(names, 3), expected);
        }
    }
}
