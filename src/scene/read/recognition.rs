//! Recognises things without ids after their file has changed. A longest common subsequence pairs equal things, and
//! things between these are paired in order, as in comparisons of texts (Hunt and McIlroy, "An Algorithm for
//! Differential File Comparison", 1976).

/// The most comparisons for one list; beyond them only its ends are compared.
const MOST_COMPARISONS: usize = 4_000_000;

/// For each thing of `now` its index in `before`, ascending; None for new things.
pub(in crate::scene) fn recognised<T: PartialEq>(before: &[T], now: &[T]) -> Vec<Option<usize>> {
    let head = before.iter().zip(now).take_while(|(a, b)| a == b).count();
    let tails = before[head..].iter().rev().zip(now[head..].iter().rev());
    let tail = tails.take_while(|(a, b)| a == b).count();
    let (old, new) = (&before[head..before.len() - tail], &now[head..now.len() - tail]);
    let mut pairs: Vec<(usize, usize)> = (0..head).map(|place| (place, place)).collect();
    pairs.extend(
        common_subsequence(old, new)
            .into_iter()
            .map(|(a, b)| (head + a, head + b)),
    );
    pairs.extend((0..=tail).rev().map(|left| (before.len() - left, now.len() - left)));
    // Between two pairs, things are paired in order. A final pair stands for the ends of the lists.
    let mut found = Vec::with_capacity(now.len());
    let mut next = 0;
    for (a, b) in pairs {
        found.extend((found.len()..b).map(|_| {
            let free = (next < a).then_some(next);
            next += 1;
            free
        }));
        if b < now.len() {
            found.push(Some(a));
        }
        next = a + 1;
    }
    found
}

/// The longest ascending list of index pairs of equal things.
fn common_subsequence<T: PartialEq>(a: &[T], b: &[T]) -> Vec<(usize, usize)> {
    if a.len().saturating_mul(b.len()) > MOST_COMPARISONS {
        return Vec::new();
    }
    // The length of the longest common subsequence of the suffixes from (i, j) on.
    let width = b.len() + 1;
    let mut lengths = vec![0u32; (a.len() + 1) * width];
    for i in (0..a.len()).rev() {
        for j in (0..b.len()).rev() {
            lengths[i * width + j] = if a[i] == b[j] {
                lengths[(i + 1) * width + j + 1] + 1
            } else {
                lengths[(i + 1) * width + j].max(lengths[i * width + j + 1])
            };
        }
    }
    let (mut i, mut j) = (0, 0);
    let mut pairs = Vec::new();
    while i < a.len() && j < b.len() {
        if a[i] == b[j] {
            pairs.push((i, j));
            (i, j) = (i + 1, j + 1);
        } else if lengths[(i + 1) * width + j] >= lengths[i * width + j + 1] {
            i += 1;
        } else {
            j += 1;
        }
    }
    pairs
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Each letter is a thing; capitals are of `before`. A dash is a new one.
    fn pairs(before: &str, now: &str) -> String {
        let letters = |text: &str| text.chars().collect::<Vec<_>>();
        let (before, now) = (letters(before), letters(now));
        let found = recognised(&before, &now);
        let name = |place: Option<usize>| place.map_or('-', |place| before[place]);
        assert_eq!(found.len(), now.len());
        found.into_iter().map(name).collect()
    }

    #[test]
    fn what_is_equal_is_found_again() {
        assert_eq!(pairs("abc", "abc"), "abc");
        assert_eq!(pairs("abc", "ac"), "ac");
        assert_eq!(pairs("abc", "bc"), "bc");
        assert_eq!(pairs("ac", "abc"), "a-c");
        assert_eq!(pairs("", "ab"), "--");
        assert_eq!(pairs("ab", ""), "");
        assert_eq!(pairs("aab", "ab"), "ab");
    }

    #[test]
    fn what_changed_is_what_stands_in_its_place() {
        assert_eq!(pairs("abc", "axc"), "abc");
        // One removed, another changed.
        assert_eq!(pairs("abcd", "acx"), "acd");
        assert_eq!(pairs("abcd", "xbcyd"), "abc-d");
        assert_eq!(pairs("abc", "xyz"), "abc");
    }

    #[test]
    fn long_lists_are_compared_from_their_ends() {
        let before: Vec<u32> = (0..10_000).collect();
        let mut now = before.clone();
        now.remove(5000);
        let found = recognised(&before, &now);
        assert!(
            found
                .iter()
                .zip(&now)
                .all(|(place, value)| *place == Some(*value as usize))
        );
        let unlike: Vec<u32> = (20_000..30_000).collect();
        assert!(
            recognised(&before, &unlike)
                .iter()
                .eq((0..10_000).map(Some).collect::<Vec<_>>().iter())
        );
    }
}
