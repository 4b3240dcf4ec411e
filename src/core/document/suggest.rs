//! "Did you mean ...?": the nearest known name by edit distance.

/// The longest name that gets a suggestion: the cost is quadratic in its length.
const LONGEST: usize = 48;

/// The candidate nearest to `name`, if it is near enough to be a typing error: at most a third of the letters, rounded
/// up, differ. None if `name` is itself a candidate.
pub fn closest<'c>(name: &str, candidates: impl IntoIterator<Item = &'c str>) -> Option<&'c str> {
    let length = name.chars().count();
    if length == 0 || length > LONGEST {
        return None;
    }
    let allowed = length.div_ceil(3);
    let found = candidates
        .into_iter()
        .filter(|candidate| candidate.len() <= 4 * LONGEST && candidate.chars().count().abs_diff(length) <= allowed)
        .map(|candidate| (distance(name, candidate), candidate))
        .filter(|(distance, _)| *distance <= allowed)
        .min_by_key(|(distance, candidate)| (*candidate != name, *distance, *candidate));
    found
        .map(|(_, candidate)| candidate)
        .filter(|candidate| *candidate != name)
}

/// The hint with the nearest candidate.
pub fn did_you_mean<'c>(name: &str, candidates: impl IntoIterator<Item = &'c str>) -> Option<String> {
    closest(name, candidates).map(|candidate| format!("did you mean `{candidate}`?"))
}

/// The edit distance (optimal string alignment): insertions, deletions, substitutions and swaps of neighbours cost one
/// each; case does not count.
fn distance(a: &str, b: &str) -> usize {
    let a: Vec<char> = a.chars().flat_map(char::to_lowercase).collect();
    let b: Vec<char> = b.chars().flat_map(char::to_lowercase).collect();
    let mut before = vec![0; b.len() + 1];
    let mut above: Vec<usize> = (0..=b.len()).collect();
    let mut row = vec![0; b.len() + 1];
    for i in 1..=a.len() {
        row[0] = i;
        for j in 1..=b.len() {
            let substitution = above[j - 1] + usize::from(a[i - 1] != b[j - 1]);
            row[j] = substitution.min(above[j] + 1).min(row[j - 1] + 1);
            if i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1] {
                row[j] = row[j].min(before[j - 2] + 1);
            }
        }
        std::mem::swap(&mut before, &mut above);
        std::mem::swap(&mut above, &mut row);
    }
    above[b.len()]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn slips_are_found_and_strangers_are_not() {
        let known = ["alpha", "alpha_u", "distribution", "eta", "k"];
        assert_eq!(closest("alpah", known), Some("alpha"));
        assert_eq!(closest("Alpha", known), Some("alpha"));
        assert_eq!(closest("alfa", known), Some("alpha"));
        assert_eq!(closest("distrbution", known), Some("distribution"));
        assert_eq!(closest("reflectance", known), None);
        assert_eq!(closest("", known), None);
        assert_eq!(closest("alpha_u", ["alpha_v", "alpha_u"]), None);
        assert_eq!(closest(&"a".repeat(100_000), known), None);
    }
}
