//! The scene, settings and version from which a picture was rendered, and the differences between two of them.

use std::collections::HashMap;

use serde::{Deserialize, Serialize};

/// A file that was read, and a digest of its content.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct FileDigest {
    /// The path, relative to the folder of the scene if it is below that.
    pub path: String,
    /// A digest of the content.
    pub digest: String,
}

/// All inputs on which the samples of a picture depend.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Origin {
    /// The version of the program.
    pub version: String,
    /// The version of its samples, [`Self::SAMPLES`]. It is 0 in files without it.
    #[serde(default)]
    pub samples: u32,
    /// The files of the scene, in the order of their paths.
    pub files: Vec<FileDigest>,
    /// All other inputs, by name.
    pub settings: Vec<(String, String)>,
}

/// The longest value of a setting that a message quotes, in bytes.
const LONGEST_QUOTED: usize = 60;

impl Origin {
    /// The version of samples. Raise it with every change that alters a sample of the same scene, settings, seed and
    /// index, in pictures or in bakes: changes of paths, of their densities, or of the random numbers that they use.
    /// Files of an older version would be continued with other samples, and the result would have the bits of neither
    /// version.
    pub const SAMPLES: u32 = 2;

    /// A file of both pictures whose content has changed since `then`.
    pub fn changed_file(&self, then: &Self) -> Option<&FileDigest> {
        let then = first_of_each(then.files.iter().map(|file| (&file.path, &file.digest)));
        let has_changed = |file: &&FileDigest| then.get(&file.path).is_some_and(|digest| **digest != file.digest);
        self.files.iter().find(has_changed)
    }

    /// The differences between this picture and `then`, a sentence each.
    pub fn differences(&self, then: &Self) -> Vec<String> {
        let mut found = Vec::new();
        if self.version != then.version {
            found.push(format!(
                "the version of Sunroom is {}, and was {}",
                self.version, then.version
            ));
        }
        if self.samples != then.samples {
            found.push(format!(
                "the version of samples, which changes with how light is computed, is {}, and was {}",
                self.samples, then.samples
            ));
        }
        let [now_files, then_files] =
            [self, then].map(|origin| first_of_each(origin.files.iter().map(|file| (&file.path, &file.digest))));
        for file in &self.files {
            match then_files.get(&file.path) {
                Some(digest) if **digest == file.digest => {}
                Some(_) => found.push(format!("{} has another content", file.path)),
                None => found.push(format!("{} was not part of the scene", file.path)),
            }
        }
        for file in &then.files {
            if !now_files.contains_key(&file.path) {
                found.push(format!("{} is no longer part of the scene", file.path));
            }
        }
        let [now_set, then_set] =
            [self, then].map(|origin| first_of_each(origin.settings.iter().map(|(name, value)| (name, value))));
        let value_in = |settings: &HashMap<&String, &String>, name: &String| match settings.get(name) {
            None => "not set".to_owned(),
            Some(value) if value.is_empty() => "empty".to_owned(),
            Some(value) => value.to_string(),
        };
        let own = self.settings.iter().map(|(name, _)| name);
        let gone = then.settings.iter().map(|(name, _)| name);
        let gone = gone.filter(|name| !now_set.contains_key(name));
        for name in own.chain(gone) {
            let [now, before] = [&now_set, &then_set].map(|settings| value_in(settings, name));
            if now != before {
                found.push(match now.len().max(before.len()) <= LONGEST_QUOTED {
                    true => format!("{name} is {now}, and was {before}"),
                    false => format!("{name} differs"),
                });
            }
        }
        found
    }
}

/// The values by name; the first of several with one name counts. A file may have millions.
fn first_of_each<'a>(list: impl Iterator<Item = (&'a String, &'a String)>) -> HashMap<&'a String, &'a String> {
    let mut first = HashMap::new();
    for (name, value) in list {
        first.entry(name).or_insert(value);
    }
    first
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn origins_may_have_very_many_settings() {
        let settings = |value: &str| (0..200_000).map(|i| (format!("-D x{i}"), value.to_owned())).collect();
        let then = Origin {
            settings: settings("1"),
            ..Origin::default()
        };
        assert_eq!(then.differences(&then), [""; 0]);
        let now = Origin {
            settings: settings("2"),
            ..Origin::default()
        };
        let found = now.differences(&then);
        assert_eq!((found.len(), found[7].as_str()), (200_000, "-D x7 is 2, and was 1"));
        assert_eq!(now.differences(&Origin::default()).len(), 200_000);
    }

    #[test]
    fn differences_are_named() {
        let file = |path: &str, digest: &str| FileDigest {
            path: path.to_owned(),
            digest: digest.to_owned(),
        };
        let setting = |name: &str, value: &str| (name.to_owned(), value.to_owned());
        let then = Origin {
            version: "1".to_owned(),
            samples: 3,
            files: vec![file("a.xml", "1"), file("b.obj", "1"), file("c.png", "1")],
            settings: vec![setting("the seed", "1"), setting("-D x", "2")],
        };
        assert_eq!(then.differences(&then), [""; 0]);
        let now = Origin {
            version: "2".to_owned(),
            samples: 4,
            files: vec![file("a.xml", "1"), file("b.obj", "2"), file("d.png", "1")],
            settings: vec![setting("the seed", "3")],
        };
        let expected = [
            "the version of Sunroom is 2, and was 1",
            "the version of samples, which changes with how light is computed, is 4, and was 3",
            "b.obj has another content",
            "d.png was not part of the scene",
            "c.png is no longer part of the scene",
            "the seed is 3, and was 1",
            "-D x is not set, and was 2",
        ];
        assert_eq!(now.differences(&then), expected);
    }

    #[test]
    fn files_that_say_no_version_of_samples_have_other_ones() {
        let text = r#"{"version": "1", "files": [], "settings": []}"#;
        let then: Origin = serde_json::from_str(text).expect("an origin");
        let now = Origin {
            samples: Origin::SAMPLES,
            ..then.clone()
        };
        assert_eq!(now.differences(&then).len(), 1);
    }
}
