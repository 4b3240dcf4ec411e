//! `$name` in attribute values: `<default>` gives a value, `-D name=value` overrides it.
//!
//! As in Mitsuba, the reader replaces the text before it parses it: the longest known name wins (`$width2` is `$width`
//! followed by a 2 if there is no `width2`), and `\$` is a plain dollar sign. Replaced text is not searched again.

use std::borrow::Cow;
use std::collections::{BTreeSet, HashMap};

use super::suggest::did_you_mean;

/// The longest value after replacement.
const LONGEST_VALUE: usize = 1 << 16;
/// The most bytes of all replaced values of a document together: defaults made of defaults grow exponentially.
const LONGEST_TOTAL: usize = 1 << 26;
const LONGEST_NAME: usize = 256;
/// The most names that are searched for a suggestion.
const MOST_CANDIDATES: usize = 1000;

#[derive(Debug)]
struct Define {
    value: String,
    from_command_line: bool,
    /// Whether a `<default>` declares it.
    declared: bool,
    used: bool,
}

#[derive(Debug, Default)]
pub struct Defines {
    by_name: HashMap<String, Define>,
    lengths: BTreeSet<usize>,
    written: usize,
}

/// The reason why an attribute value could not be made, with a hint if there is one.
#[derive(Debug, PartialEq)]
pub struct DefineError {
    pub message: String,
    pub help: Option<String>,
    /// The name that is not defined; a hint that suggests a similar name is better, and takes longer to find.
    pub undefined: Option<String>,
}

impl DefineError {
    fn new(message: String) -> Self {
        Self {
            message,
            help: None,
            undefined: None,
        }
    }
}

impl Defines {
    /// The definitions of the command line, which override the `<default>`s of the file.
    pub fn new(given: &[(String, String)]) -> Self {
        let mut defines = Self::default();
        for (name, value) in given {
            defines.insert(name, value, true);
        }
        defines
    }

    /// A `<default>`: has no effect if the name is known already.
    pub fn add_default(&mut self, name: &str, value: &str) {
        match self.by_name.get_mut(name) {
            Some(define) => define.declared = true,
            None => self.insert(name, value, false),
        }
    }

    fn insert(&mut self, name: &str, value: &str, from_command_line: bool) {
        if name.is_empty() || name.len() > LONGEST_NAME {
            return;
        }
        self.lengths.insert(name.len());
        let define = Define {
            value: value.to_owned(),
            from_command_line,
            declared: !from_command_line,
            used: false,
        };
        self.by_name.insert(name.to_owned(), define);
    }

    /// `text` with every `$name` replaced.
    pub fn substitute<'t>(&mut self, text: &'t str) -> Result<Cow<'t, str>, DefineError> {
        if !text.contains('$') {
            return Ok(Cow::Borrowed(text));
        }
        let mut result = String::new();
        let mut rest = text;
        while let Some(dollar) = rest.find('$') {
            let before = &rest[..dollar];
            rest = &rest[dollar + 1..];
            if let Some(before) = before.strip_suffix('\\') {
                result += before;
                result.push('$');
                continue;
            }
            result += before;
            let Some(length) = self.longest_name(rest) else {
                return Err(undefined(rest));
            };
            if let Some(define) = self.by_name.get_mut(&rest[..length]) {
                define.used = true;
                result += &define.value;
            }
            rest = &rest[length..];
            if result.len() > LONGEST_VALUE {
                let message = format!("longer than {LONGEST_VALUE} bytes once its `$` names are replaced");
                return Err(DefineError::new(message));
            }
        }
        result += rest;
        self.written += result.len();
        if self.written > LONGEST_TOTAL {
            return Err(DefineError::new("too much text comes from `$` names".to_owned()));
        }
        Ok(Cow::Owned(result))
    }

    /// Length of the longest known name that `text` starts with.
    fn longest_name(&self, text: &str) -> Option<usize> {
        let fits = |length: &usize| {
            let start = text.get(..*length);
            start.is_some_and(|name| self.by_name.contains_key(name))
        };
        self.lengths.iter().rev().copied().find(fits)
    }

    /// The known names, up to the number that is searched for suggestions.
    pub fn names(&self) -> impl Iterator<Item = &str> {
        self.by_name.keys().take(MOST_CANDIDATES).map(String::as_str)
    }

    /// Whether the text uses this name as `$name`, or gives it a value for which `is_usual` is false.
    pub fn has_other_use(&self, name: &str, is_usual: impl Fn(&str) -> bool) -> bool {
        let define = self.by_name.get(name);
        define.is_some_and(|define| define.used || !is_usual(&define.value))
    }

    /// Unused names from the command line, in order, each with the nearest name of a `<default>`.
    pub fn unused(&self) -> Vec<(&str, Option<String>)> {
        let given = self.by_name.iter().filter(|(_, define)| define.from_command_line);
        let mut unused: Vec<&str> = given
            .filter(|(_, define)| !define.used)
            .map(|(name, _)| name.as_str())
            .collect();
        unused.sort_unstable();
        let declared = || self.by_name.iter().filter(|(_, define)| define.declared);
        let names = || declared().map(|(name, _)| name.as_str()).take(MOST_CANDIDATES);
        let help = |name: &str| match self.by_name.get(name) {
            Some(define) if define.declared => None,
            _ => did_you_mean(name, names()),
        };
        unused.into_iter().map(|name| (name, help(name))).collect()
    }
}

/// The error for the text after a `$` that begins with no known name.
fn undefined(rest: &str) -> DefineError {
    let end = rest.find(|c: char| !c.is_alphanumeric() && c != '_');
    let name: String = rest[..end.unwrap_or(rest.len())].chars().take(64).collect();
    let (message, help) = match name.is_empty() {
        true => (
            "a `$` without a name".to_owned(),
            "write `\\$` for a plain dollar sign".to_owned(),
        ),
        false => (
            format!("`${name}` is not defined"),
            format!("give it with `-D {name}=...` or `<default name=\"{name}\" .../>`"),
        ),
    };
    DefineError {
        message,
        help: Some(help),
        undefined: Some(name).filter(|name| !name.is_empty()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn defines(pairs: &[(&str, &str)]) -> Defines {
        let owned: Vec<_> = pairs.iter().map(|(n, v)| ((*n).to_owned(), (*v).to_owned())).collect();
        Defines::new(&owned)
    }

    #[test]
    fn longest_name_wins_and_dollars_can_be_plain() {
        let mut d = defines(&[("w", "1"), ("width", "640"), ("money", "$w")]);
        assert_eq!(d.substitute("$width x $w2 $wid").unwrap(), "640 x 12 1id");
        assert_eq!(d.substitute(r"\$w costs $money").unwrap(), "$w costs $w");
        assert_eq!(d.substitute(r"a\b").unwrap(), r"a\b");
    }

    #[test]
    fn the_command_line_wins_and_is_reported_when_unused() {
        let mut d = defines(&[("spp", "8"), ("reslution", "10")]);
        d.add_default("spp", "64");
        d.add_default("resolution", "100");
        assert_eq!(d.substitute("$spp $resolution").unwrap(), "8 100");
        let help = Some("did you mean `resolution`?".to_owned());
        assert_eq!(d.unused(), vec![("reslution", help)]);
    }

    #[test]
    fn undefined_names_and_explosions_are_errors() {
        let mut d = defines(&[("alpha", "1")]);
        let error = d.substitute("$alhpa").unwrap_err();
        assert_eq!(error.message, "`$alhpa` is not defined");
        assert_eq!(error.undefined.as_deref(), Some("alhpa"));
        assert_eq!(
            did_you_mean("alhpa", d.names()).as_deref(),
            Some("did you mean `alpha`?")
        );
        assert!(d.substitute("$").is_err());
        assert!(d.substitute("$é").is_err());
        d.add_default("a0", &"x".repeat(100));
        for i in 0..60 {
            let doubled = format!("$a{i}$a{i}");
            match d.substitute(&doubled) {
                Ok(value) => {
                    let value = value.into_owned();
                    d.add_default(&format!("a{}", i + 1), &value);
                }
                Err(error) => {
                    assert!(error.message.contains("longer than"), "{error:?}");
                    return;
                }
            }
        }
        panic!("60 doublings went through");
    }
}
