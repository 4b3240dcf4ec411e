//! The names that the properties of an object have so far.

use std::collections::HashSet;

use smol_str::SmolStr;

use crate::document::Property;

/// Up to this number, names are compared one by one.
const FEW: usize = 16;

/// Answers whether a name is given twice. Nearly all objects have few properties, and need no set of names.
#[derive(Debug, Default)]
pub(super) struct Names(HashSet<SmolStr>);

impl Names {
    /// Whether one of the properties has this name. `properties` must be those of the same object each time, and may
    /// only grow.
    pub fn contain(&mut self, name: &str, properties: &[Property]) -> bool {
        if properties.len() <= FEW {
            return properties.iter().any(|property| property.name == name);
        }
        let new = &properties[self.0.len()..];
        self.0.extend(new.iter().map(|property| property.name.clone()));
        self.0.contains(name)
    }
}
