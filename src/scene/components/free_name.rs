//! Numbers for names that are taken.

use std::collections::HashSet;

/// The name `wanted`, with a number if it is taken.
pub(crate) fn free_name(taken: &HashSet<String>, wanted: &str) -> String {
    if !taken.contains(wanted) {
        return wanted.to_owned();
    }
    // The number of a folder comes before its slash.
    let (wanted, end) = match wanted.strip_suffix('/') {
        Some(folder) => (folder, "/"),
        None => (wanted, ""),
    };
    let (stem, number) = match wanted.rsplit_once('-') {
        Some((stem, number)) => match number.parse::<u32>() {
            Ok(number) => (stem, number),
            Err(_) => (wanted, 1),
        },
        None => (wanted, 1),
    };
    let mut next = number;
    loop {
        next = next.saturating_add(1);
        let name = format!("{stem}-{next}{end}");
        if !taken.contains(&name) || next == u32::MAX {
            return name;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_that_are_taken_get_the_next_number() {
        let taken = |names: &[&str]| names.iter().map(|name| (*name).to_owned()).collect::<HashSet<_>>();
        assert_eq!(free_name(&taken(&[]), "ball"), "ball");
        assert_eq!(free_name(&taken(&["ball"]), "ball"), "ball-2");
        assert_eq!(free_name(&taken(&["ball", "ball-2"]), "ball-2"), "ball-3");
        assert_eq!(free_name(&taken(&["a-b"]), "a-b"), "a-b-2");
    }
}
