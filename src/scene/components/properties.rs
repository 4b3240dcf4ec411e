//! Properties that the user gives to things of the scene, for the code of a game: named values of a type.
//!
//! In the file each is a `default` inside the thing, `<default name="health: integer" value="100"/>`, which other
//! readers of the format take for an unused name. A Bevy component is a property whose name is the path of its type:
//! `<default name="game::Door: component" value='{"locked": true}'/>`.

use std::collections::BTreeMap;
use std::sync::Arc;

use bevy::prelude::*;
use smol_str::SmolStr;

use crate::color::Rgb;
use crate::document::suggest::did_you_mean;
use crate::document::value::{format_float, parse_boolean, parse_float, parse_integer, parse_rgb, parse_vec3, quote};
use crate::document::{Diagnostics, Object, Property, Severity, Span, Value, property_name};

/// The type of [`FORM`], which no property has.
pub(in crate::scene) const FORM_TYPE: &str = "form";

/// The properties of a thing by their names. A thing without properties has none of these.
#[derive(Component, Clone, Debug, Default, PartialEq)]
pub struct Properties(Arc<BTreeMap<SmolStr, PropertyValue>>);

/// The properties of the scene itself.
#[derive(Resource, Clone, Debug, Default, PartialEq)]
pub struct SceneProperties(pub Properties);

/// Declares the types of properties: for each its variant, what it holds, its name in files and scripts, its label, the
/// value of a new one, and how it is read and written.
macro_rules! property_types {
    ($($(#[$doc:meta])* $Variant:ident($of:ty) = $name:literal => $label:literal, $new:expr, $parse:expr, $format:expr;)*) => {
        /// One value of a property.
        #[derive(Clone, Debug, PartialEq)]
        pub enum PropertyItem {
            $($(#[$doc])* $Variant($of),)*
        }

        declare_names! {
            /// The type of one value of a property.
            #[derive(Clone, Copy, Debug, PartialEq, Eq)]
            pub enum ItemType {
                $($(#[$doc])* $Variant = $name => $label),*
            }
        }

        impl PropertyItem {
            /// The type.
            pub fn kind(&self) -> ItemType {
                match self {
                    $(Self::$Variant(_) => ItemType::$Variant,)*
                }
            }

            /// The value as text. It reads back to the same value.
            pub fn text(&self) -> String {
                match self {
                    $(Self::$Variant(value) => $format(value),)*
                }
            }
        }

        impl ItemType {
            /// The value of a new property.
            pub fn new_item(self) -> PropertyItem {
                match self {
                    $(Self::$Variant => PropertyItem::$Variant($new),)*
                }
            }

            /// Reads a value. The error says what was expected, and quotes what was found.
            pub fn parse(self, text: &str) -> Result<PropertyItem, String> {
                match self {
                    $(Self::$Variant => $parse(text).map(PropertyItem::$Variant).map_err(|error| error.to_string()),)*
                }
            }
        }
    };
}

property_types! {
    /// True or false.
    Boolean(bool) = "boolean" => "yes or no", false, parse_boolean, bool::to_string;
    /// A whole number of 64 bits.
    Integer(i64) = "integer" => "integer", 0, parse_integer, i64::to_string;
    /// A finite number.
    Number(f32) = "number" => "number", 0.0, parse_float, |number: &f32| format_float(*number);
    /// Any text.
    Text(String) = "text" => "text", String::new(), any_text, String::clone;
    /// Three finite numbers.
    Vector(Vec3) = "vector" => "vector", Vec3::ZERO, parse_vec3, |vector: &Vec3| triple(vector.to_array());
    /// A colour, linear Rec. 709.
    Color(Rgb) = "color" => "colour", Rgb::ONE, parse_rgb, |color: &Rgb| triple(color.to_array());
    /// A file, relative to the scene's folder or absolute.
    File(String) = "file" => "file", String::new(), any_text, String::clone;
    /// Another thing, by its name.
    Reference(String) = "reference" => "reference", String::new(), any_text, String::clone;
    /// A Bevy component, whose type's path is the name of the property: its value in the JSON of Bevy's
    /// reflection, which is kept as it is.
    Component(String) = "component" => "component", "{}".to_owned(), any_json, String::clone;
}

fn any_text(text: &str) -> Result<String, &'static str> {
    Ok(text.to_owned())
}

/// A text in JSON, unchanged.
fn any_json(text: &str) -> Result<String, String> {
    match serde_json::from_str::<serde_json::Value>(text) {
        Ok(_) => Ok(text.trim().to_owned()),
        Err(error) => Err(format!(
            "expected JSON such as {{\"speed\": 1.5}}, found {}: {error}",
            quote(text)
        )),
    }
}

fn triple(numbers: [f32; 3]) -> String {
    numbers.map(format_float).join(", ")
}

/// The type of a property: one value, or a list of them.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct PropertyType {
    /// The type of each value.
    pub item: ItemType,
    /// Whether it is a list.
    pub is_list: bool,
}

impl PropertyType {
    /// All types, in the order in which they are offered.
    pub fn all() -> impl Iterator<Item = Self> {
        let single = ItemType::ALL.map(|item| Self { item, is_list: false });
        let lists = ItemType::ALL.map(|item| Self { item, is_list: true });
        let lists = lists.into_iter().filter(|list| list.item != ItemType::Component);
        single.into_iter().chain(lists)
    }

    /// The name in files and scripts: `integer`, `integer list`.
    pub fn name(self) -> String {
        let list = if self.is_list { " list" } else { "" };
        format!("{}{list}", self.item.name())
    }

    /// The name in panels.
    pub fn label(self) -> String {
        match self.is_list {
            false => self.item.label().to_owned(),
            true => format!("list: {}", self.item.label()),
        }
    }

    /// The type of this name; None if there is none.
    pub fn of_name(name: &str) -> Option<Self> {
        let single = name.trim();
        let (item, is_list) = match single.strip_suffix("list") {
            Some(item) if item.ends_with(' ') => (item.trim_end(), true),
            _ => (single, false),
        };
        let item = ItemType::of_name(item)?;
        (!is_list || item != ItemType::Component).then_some(Self { item, is_list })
    }

    /// The value of a new property.
    pub fn new_value(self) -> PropertyValue {
        match self.is_list {
            false => PropertyValue::One(self.item.new_item()),
            true => PropertyValue::List(self.item, Vec::new()),
        }
    }

    /// Reads a value: the values of a list stand between `;`, and `\;` stands for a semicolon in one of them. The error
    /// says what was expected, and quotes what was found.
    pub fn parse(self, text: &str) -> Result<PropertyValue, String> {
        if !self.is_list {
            return self.item.parse(text).map(PropertyValue::One);
        }
        let items = split_list(text).into_iter().map(|item| self.item.parse(&item));
        Ok(PropertyValue::List(self.item, items.collect::<Result<_, _>>()?))
    }
}

/// The values of a list, without the blanks around them. An empty text is a list without values.
fn split_list(text: &str) -> Vec<String> {
    let mut items = Vec::new();
    let mut item = String::new();
    let mut chars = text.chars();
    while let Some(c) = chars.next() {
        match c {
            '\\' => item.extend(chars.next()),
            ';' => items.push(std::mem::take(&mut item)),
            c => item.push(c),
        }
    }
    if !text.trim().is_empty() {
        items.push(item);
    }
    items.into_iter().map(|item| item.trim().to_owned()).collect()
}

/// The value of a property.
#[derive(Clone, Debug, PartialEq)]
pub enum PropertyValue {
    /// One value.
    One(PropertyItem),
    /// Values of one type.
    List(ItemType, Vec<PropertyItem>),
}

impl PropertyValue {
    /// The type.
    pub fn kind(&self) -> PropertyType {
        match self {
            Self::One(item) => PropertyType {
                item: item.kind(),
                is_list: false,
            },
            Self::List(item, _) => PropertyType {
                item: *item,
                is_list: true,
            },
        }
    }

    /// The value as text, which [`PropertyType::parse`] reads.
    pub fn text(&self) -> String {
        let escaped = |item: &PropertyItem| item.text().replace('\\', "\\\\").replace(';', "\\;");
        match self {
            Self::One(item) => item.text(),
            // A list of one empty text is not an empty list.
            Self::List(_, items) if items.len() == 1 && items[0].text().is_empty() => "\\".to_owned(),
            Self::List(_, items) => items.iter().map(escaped).collect::<Vec<_>>().join("; "),
        }
    }

    /// The values.
    pub fn items(&self) -> &[PropertyItem] {
        match self {
            Self::One(item) => std::slice::from_ref(item),
            Self::List(_, items) => items,
        }
    }

    fn items_mut(&mut self) -> &mut [PropertyItem] {
        match self {
            Self::One(item) => std::slice::from_mut(item),
            Self::List(_, items) => items,
        }
    }
}

impl Properties {
    /// The longest name of a property in bytes.
    pub const LONGEST_NAME: usize = 256;

    /// The properties by name.
    pub fn iter(&self) -> impl Iterator<Item = (&str, &PropertyValue)> {
        self.0.iter().map(|(name, value)| (name.as_str(), value))
    }

    /// The value of this name.
    pub fn get(&self, name: &str) -> Option<&PropertyValue> {
        self.0.get(name)
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    /// Itself; None if it is empty.
    pub fn some(self) -> Option<Self> {
        (!self.is_empty()).then_some(self)
    }

    /// These properties with another value of this name, or without it.
    pub fn with(&self, name: &str, value: Option<PropertyValue>) -> Self {
        let mut all = BTreeMap::clone(&self.0);
        match value {
            Some(value) => _ = all.insert(name.into(), value),
            None => _ = all.remove(name),
        }
        Self(Arc::new(all))
    }

    /// These properties with their references to things by other names. None if none of them changes.
    pub fn renamed(&self, new_name: impl Fn(&str) -> Option<String>) -> Option<Self> {
        let mut all = BTreeMap::clone(&self.0);
        let mut is_changed = false;
        for item in all.values_mut().flat_map(PropertyValue::items_mut) {
            if let PropertyItem::Reference(thing) = item
                && let Some(new) = new_name(thing)
            {
                *thing = new;
                is_changed = true;
            }
        }
        is_changed.then(|| Self(Arc::new(all)))
    }

    /// Three-way merge by names: what differs between `base` and `theirs` is taken from `theirs`, and the rest from
    /// `ours`.
    pub(in crate::scene) fn merged(base: &Self, theirs: &Self, ours: &Self) -> Self {
        let names = [base, theirs, ours].into_iter().flat_map(|it| it.0.keys());
        let mut all = BTreeMap::new();
        for name in names {
            let [before, new, own] = [base, theirs, ours].map(|it| it.0.get(name));
            if let Some(value) = if new == before { own } else { new } {
                all.insert(name.clone(), value.clone());
            }
        }
        Self(Arc::new(all))
    }

    /// The name without blanks around it. An error if a file cannot hold it.
    pub fn checked_name(name: &str) -> Result<&str, String> {
        let name = name.trim();
        // XML has neither control characters nor these two.
        let is_strange = |c: char| c.is_control() || matches!(c, '\u{fffe}' | '\u{ffff}');
        if name.is_empty() || name.len() > Self::LONGEST_NAME || name.contains(is_strange) {
            return Err(format!(
                "A property needs a name of at most {} characters.",
                Self::LONGEST_NAME
            ));
        }
        // What a file has before the type has to be the name again.
        let whole = property_name(&format!("{name}: text"));
        match whole.is_some_and(|whole| whole.strip_suffix(": text") == Some(name)) {
            true => Ok(name),
            false => Err(format!("{} cannot be the name of a property.", quote(name))),
        }
    }

    /// An estimate of the allocated memory in bytes.
    pub(crate) fn bytes(&self) -> usize {
        let of_item = |item: &PropertyItem| size_of::<PropertyItem>() + item.text().len();
        let one =
            |(name, value): (&str, &PropertyValue)| name.len() + 64 + value.items().iter().map(of_item).sum::<usize>();
        self.iter().map(one).sum()
    }

    /// The properties of an object of the file. A value that is not of its type is an error there; a type that is not
    /// known is a warning, and the text stays in the file.
    pub(in crate::scene) fn of(object: &Object, diagnostics: &mut Diagnostics) -> Option<Self> {
        let mut all = BTreeMap::new();
        for property in &object.properties {
            let Value::String(text) = &property.value else { continue };
            let Some(whole) = property_name(&property.name) else {
                continue;
            };
            let Some((name, kind)) = whole.rsplit_once(": ") else {
                continue;
            };
            if kind == FORM_TYPE {
                continue;
            }
            let Some(known) = PropertyType::of_name(kind) else {
                let message = format!("{} is no type of a property: `{name}` has no effect", quote(kind));
                let help = did_you_mean(kind, ItemType::ALL.map(ItemType::name));
                diagnostics.push(Severity::Warning, Some(property.span), message, help);
                continue;
            };
            match known.parse(text) {
                Ok(value) if !all.contains_key(name) => _ = all.insert(SmolStr::from(name), value),
                Ok(_) => {
                    let message = format!("the property {} is given twice in {}", quote(name), object.title());
                    diagnostics.error(property.span, message);
                }
                Err(error) => {
                    diagnostics.error(property.span, format!("the property {}: {error}", quote(name)));
                }
            }
        }
        Self(Arc::new(all)).some()
    }

    /// Whether a value in a file is a property of a known type.
    pub(in crate::scene) fn is_one(property: &Property) -> bool {
        let kind = property.name.rsplit_once(": ").map(|(_, kind)| kind);
        kind.is_some_and(|kind| PropertyType::of_name(kind).is_some())
    }

    /// The properties as the file has them.
    pub(in crate::scene) fn for_file(&self) -> impl Iterator<Item = Property> {
        self.iter().map(|(name, value)| {
            let name = format!("{name}: {}", value.kind().name());
            Property::new(name, Value::String(value.text()), Span::default())
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_read_back_from_their_texts() {
        for (kind, text) in [
            ("boolean", "true"),
            ("integer", "-9007199254740993"),
            ("number", "0.1"),
            ("text", "  a \\ ; b "),
            ("vector", "1, -2.5, 0"),
            ("color", "0.5, 0.25, 1"),
            ("integer list", "1; 2; 3"),
            ("text list", "a\\;b; c\\\\; ; d"),
            ("text list", ";"),
            ("vector list", "0, 0, 0; 1, 2, 3"),
            ("reference list", ""),
            ("component", "{\"locked\": true, \"speed\": [1.5, null]}"),
            ("component", "\"Low\""),
        ] {
            let kind = PropertyType::of_name(kind).expect(kind);
            let value = kind.parse(text).expect(text);
            assert_eq!(value.kind(), kind);
            assert_eq!(kind.parse(&value.text()).as_ref(), Ok(&value), "{text}");
        }
        assert_eq!(PropertyType::of_name("component list"), None);
        assert_eq!(PropertyType::of_name("list"), None);
        let component = PropertyType::of_name("component").expect("a type");
        assert!(component.parse("{locked: true}").is_err() && component.parse("").is_err());
        let list = PropertyType::of_name("number list").expect("a type");
        assert_eq!(list.parse("1; x"), Err("expected a number, found `x`".to_owned()));
        for kind in PropertyType::all() {
            assert_eq!(PropertyType::of_name(&kind.name()), Some(kind));
            assert_eq!(kind.new_value().kind(), kind);
        }
    }

    #[test]
    fn names_are_those_that_a_file_can_hold() {
        assert_eq!(Properties::checked_name(" game::Door "), Ok("game::Door"));
        assert_eq!(Properties::checked_name("hit points"), Ok("hit points"));
        for wrong in ["", "  ", "a\nb", "x".repeat(257).as_str()] {
            assert!(Properties::checked_name(wrong).is_err(), "{wrong:?}");
        }
    }
}
