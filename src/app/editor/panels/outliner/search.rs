//! The search of the list: words that all have to be found in the name or the kind of a thing, and words after
//! `material:`, `type:` and `has:`.

use std::collections::HashSet;

use bevy::prelude::Entity;

use crate::app::editor::model::{Item, Outline};
use crate::scene::marker::TYPE;

/// The words of a search, in lower case.
pub struct Search {
    terms: Vec<Term>,
}

enum Term {
    /// A part of the name or the kind.
    Any(String),
    /// A part of the kind, of the type of a marker, or the heading in the singular: `type:light` finds all lights.
    Type(String),
    /// The materials with this part in their names; finds them and the shapes that use them.
    Material(HashSet<Entity>),
    /// The name of a property, or of the type of a component without its path: `has:door` finds `game::Door`.
    Has(String),
}

impl Search {
    /// Reads the text of a search.
    pub fn new(text: &str, outline: &Outline) -> Self {
        let text = text.to_lowercase();
        let terms = text.split_whitespace().map(|word| match word.split_once(':') {
            Some(("material", part)) => {
                let named = outline
                    .materials
                    .iter()
                    .filter(|item| item.name.to_lowercase().contains(part));
                Term::Material(named.map(|item| item.entity).collect())
            }
            Some(("type", part)) => Term::Type(part.to_owned()),
            Some(("has", part)) => Term::Has(part.to_owned()),
            _ => Term::Any(word.to_owned()),
        });
        let terms = terms.collect();
        Self { terms }
    }

    /// Whether everything is found.
    pub fn is_empty(&self) -> bool {
        self.terms.is_empty()
    }

    /// Whether the search finds a thing that is listed under this heading.
    pub fn finds(&self, heading: &str, item: &Item) -> bool {
        self.terms.iter().all(|term| match term {
            Term::Any(word) => item.name.to_lowercase().contains(word) || item.kind.contains(word.as_str()),
            Term::Type(word) => {
                let singular = heading.trim_end_matches('s').to_lowercase();
                let own = item.properties.as_ref().and_then(|properties| properties.get(TYPE));
                let is_own = own.is_some_and(|value| value.text().to_lowercase().contains(word));
                is_own || item.kind.contains(word.as_str()) || singular == *word
            }
            Term::Has(word) => item.properties.as_ref().is_some_and(|properties| {
                let mut names = properties.iter().map(|(name, _)| name.to_lowercase());
                names.any(|name| name == *word || name.rsplit("::").next() == Some(word))
            }),
            Term::Material(materials) => {
                materials.contains(&item.entity) || item.uses.is_some_and(|used| materials.contains(&used))
            }
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::{Properties, PropertyType};

    fn item(number: u32, name: &str, kind: &'static str, uses: Option<Entity>) -> Item {
        Item {
            entity: Entity::from_raw_u32(number).expect("a small number"),
            name: name.to_owned(),
            kind,
            hidden: false,
            locked: false,
            can_hide: true,
            inside_of: None,
            uses,
            properties: None,
        }
    }

    #[test]
    fn words_and_fields_have_to_agree() {
        let oak = item(1, "Oak-oiled", "plastic", None);
        let table = item(2, "table top", "cube", Some(oak.entity));
        let value = PropertyType::of_name("integer").expect("a type").new_value();
        let properties = Properties::default().with("health", Some(value.clone()));
        let properties = Some(properties.with("game::Door", Some(value)));
        let lamp = Item {
            properties,
            ..item(3, "lamp", "point", None)
        };
        let outline = Outline {
            shapes: vec![table.clone()].into(),
            materials: vec![oak.clone()].into(),
            lights: vec![lamp.clone()].into(),
            ..Outline::default()
        };
        let found = |text: &str| {
            let search = Search::new(text, &outline);
            let all = [("Shapes", &table), ("Materials", &oak), ("Lights", &lamp)];
            let found = all.into_iter().filter(|(heading, item)| search.finds(heading, item));
            found.map(|(_, item)| item.name.as_str()).collect::<Vec<_>>()
        };
        assert_eq!(found("").len(), 3);
        assert_eq!(found("TOP  table"), ["table top"]);
        assert_eq!(found("cube"), ["table top"]);
        assert_eq!(found("material:oak"), ["table top", "Oak-oiled"]);
        assert_eq!(found("material:oak type:cube"), ["table top"]);
        assert_eq!(found("type:light"), ["lamp"]);
        assert_eq!(found("type:material"), ["Oak-oiled"]);
        assert_eq!(found("has:health"), ["lamp"]);
        assert_eq!(found("has:door type:point"), ["lamp"]);
        assert!(found("has:heal").is_empty() && found("has:door table").is_empty());
        assert!(found("material:pine").is_empty() && found("top chair").is_empty());
    }
}
