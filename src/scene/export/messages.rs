//! Collects the messages of an export about losses: a sentence for each material, and one for all other things with the
//! same loss.

use std::collections::{HashMap, HashSet};

/// The most things that a sentence names.
const MOST_NAMES: usize = 5;

/// The messages of an export.
#[derive(Default)]
pub(super) struct Messages {
    order: Vec<Loss>,
    names: HashMap<Loss, Names>,
}

/// The names of the things with the same loss.
#[derive(Default)]
struct Names {
    /// The names in the message, in the order of their occurrence.
    told: Vec<String>,
    all: HashSet<String>,
}

/// The loss of things of a kind (`shape`, `light`).
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
struct Loss {
    kind: &'static str,
    is_left_out: bool,
    /// A sentence that fits one thing and several, or the reason why they are left out.
    what: String,
}

impl Messages {
    /// Notes a loss of a thing of this kind, in a sentence that fits one thing and several.
    pub fn note(&mut self, kind: &'static str, name: &str, what: impl Into<String>) {
        self.add(kind, name, false, what.into());
    }

    /// Notes that a thing is left out, and why.
    pub fn left_out(&mut self, kind: &'static str, name: &str, why: impl Into<String>) {
        self.add(kind, name, true, why.into());
    }

    fn add(&mut self, kind: &'static str, name: &str, is_left_out: bool, what: String) {
        let key = Loss {
            kind,
            is_left_out,
            what,
        };
        let names = self.names.entry(key.clone()).or_default();
        if names.all.is_empty() {
            self.order.push(key);
        }
        if names.all.insert(name.to_owned()) && names.told.len() < MOST_NAMES {
            names.told.push(name.to_owned());
        }
    }

    /// The sentences, in the order of their occurrence.
    pub fn sentences(mut self) -> Vec<String> {
        let sentence = |key: Loss| {
            let names = self.names.remove(&key).unwrap_or_default();
            let Loss {
                kind,
                is_left_out,
                what,
            } = key;
            let quoted: Vec<String> = names.told.iter().map(|name| format!("`{name}`")).collect();
            let count = names.all.len();
            let mut listed = quoted.join(", ");
            if let Some(others) = count.checked_sub(MOST_NAMES).filter(|others| *others > 0) {
                listed += &format!(" and {others} more");
            }
            let kinds = match (count, kind) {
                (1, kind) => kind.to_owned(),
                (_, "medium") => "media".to_owned(),
                (_, kind) => format!("{kind}s"),
            };
            let is_left_out = match (is_left_out, count) {
                (false, _) => "",
                (true, 1) => " is left out",
                (true, _) => " are left out",
            };
            format!("{kinds} {listed}{is_left_out}: {what}")
        };
        self.order.drain(..).map(sentence).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn things_that_lose_the_same_share_a_sentence() {
        let mut messages = Messages::default();
        messages.left_out("shape", "a", "no room");
        messages.note("light", "sky", "the colour is lost");
        for name in ["b", "a", "c", "d", "e", "f", "g"] {
            messages.left_out("shape", name, "no room");
        }
        messages.left_out("medium", "fog", "no room");
        messages.left_out("medium", "mist", "no room");
        let expected = [
            "shapes `a`, `b`, `c`, `d`, `e` and 2 more are left out: no room",
            "light `sky`: the colour is lost",
            "media `fog`, `mist` are left out: no room",
        ];
        assert_eq!(messages.sentences(), expected);
    }
}
