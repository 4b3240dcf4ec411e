//! The keys that the user has changed.

use std::collections::BTreeMap;

use serde::{Deserialize, Deserializer, Serialize, Serializer};
use serde_json::Value;

use super::shortcut::Shortcut;

/// The keys that replace the defaults, by the names of actions. In a file they are texts such as `Ctrl+Shift+Z`.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct KeyBindings(BTreeMap<String, Vec<Shortcut>>);

/// The default keys alone.
pub static NO_BINDINGS: KeyBindings = KeyBindings(BTreeMap::new());

impl KeyBindings {
    /// The chosen keys of an action, which may be none at all. None: the default keys.
    pub fn of(&self, name: &str) -> Option<&[Shortcut]> {
        self.0.get(name).map(Vec::as_slice)
    }

    /// Binds these keys to an action.
    pub fn set(&mut self, name: &str, keys: Vec<Shortcut>) {
        self.0.insert(name.to_owned(), keys);
    }

    /// Restores the default keys of an action.
    pub fn reset(&mut self, name: &str) {
        self.0.remove(name);
    }

    /// Whether all keys are the defaults.
    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }
}

impl Serialize for KeyBindings {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let named = |keys: &Vec<Shortcut>| keys.iter().map(Shortcut::name).collect::<Vec<_>>();
        serializer.collect_map(self.0.iter().map(|(name, keys)| (name, named(keys))))
    }
}

/// Unknown keys and entries that are no texts are skipped: a keyboard of a later version must not cost the user all
/// preferences.
impl<'de> Deserialize<'de> for KeyBindings {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let value = Value::deserialize(deserializer)?;
        let entries = value.as_object().into_iter().flatten();
        let keys = |value: &Value| {
            let texts = match value {
                Value::Array(texts) => texts.as_slice(),
                Value::String(_) => std::slice::from_ref(value),
                _ => return None,
            };
            let texts = texts.iter().filter_map(Value::as_str);
            Some(texts.filter_map(Shortcut::parse).collect())
        };
        Ok(Self(
            entries
                .filter_map(|(name, value)| Some((name.clone(), keys(value)?)))
                .collect(),
        ))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn they_come_back_from_their_texts() {
        let text = r#"{"save":["Ctrl+Shift+F5","Numpad 7"],"undo":[]}"#;
        let bindings: KeyBindings = serde_json::from_str(text).expect("two actions");
        assert_eq!(bindings.of("save").map(<[_]>::len), Some(2));
        assert_eq!(bindings.of("undo"), Some(&[][..]));
        assert_eq!(bindings.of("redo"), None);
        assert_eq!(serde_json::to_string(&bindings).ok().as_deref(), Some(text));
    }

    #[test]
    fn texts_without_a_key_are_left_out() {
        let bindings: KeyBindings = serde_json::from_str(r#"{"save":["Hyper+Q","F2"]}"#).expect("a map");
        let f2 = Shortcut::parse("F2").expect("a key");
        assert_eq!(bindings.of("save"), Some(&[f2][..]));
        let bindings: KeyBindings = serde_json::from_str(r#"{"save":"F2","undo":7,"redo":[7]}"#).expect("a map");
        assert_eq!(bindings.of("save"), Some(&[f2][..]));
        assert_eq!((bindings.of("undo"), bindings.of("redo")), (None, Some(&[][..])));
    }
}
