//! The types of a game's components, as its schema says: the answer to the request `registry.schema` of Bevy's remote
//! protocol, in a file that the property `component types` of the scene names.

use std::collections::BTreeMap;

use serde_json::{Map, Value};

/// The property of the scene with the name of the file.
pub const TYPES: &str = "component types";

/// The depth to which the fields of new values are filled in.
const DEEPEST: usize = 16;

/// The types of a game, by their paths.
#[derive(Debug, Default, PartialEq)]
pub struct GameTypes(BTreeMap<String, Value>);

/// The fields of a struct: the name and the path of the type of each.
pub type Fields<'t> = Vec<(&'t str, &'t str)>;

/// The form of a type's values in JSON.
#[derive(Clone, Debug, PartialEq)]
pub enum Form<'t> {
    /// `true` or `false`.
    Boolean,
    /// A whole number.
    Integer,
    /// A number.
    Number,
    /// A text.
    Text,
    /// An object with a value for each field.
    Struct(Fields<'t>),
    /// The name of a variant, or an object with it as its key.
    Enum(Vec<Variant<'t>>),
    /// The value of the only field, of this type.
    Newtype(&'t str),
    /// Anything else.
    Other,
}

/// A variant of an enum.
#[derive(Clone, Debug, PartialEq)]
pub struct Variant<'t> {
    /// The name.
    pub name: &'t str,
    /// The content; None for a variant without any.
    pub content: Option<Content<'t>>,
}

/// The content of a variant.
#[derive(Clone, Debug, PartialEq)]
pub enum Content<'t> {
    /// An object with a value for each field.
    Fields(Fields<'t>),
    /// One value of this type.
    One(&'t str),
    /// A list of values of these types.
    Several(Vec<&'t str>),
}

impl GameTypes {
    /// Reads a schema: an object with a type for each path, or the whole answer of the protocol with it as `result`.
    pub fn read(text: &str) -> Result<Self, String> {
        let value: Value = serde_json::from_str(text).map_err(|error| format!("it is no JSON: {error}"))?;
        let Value::Object(mut whole) = value else {
            return Err("expected an object with the types by their paths".to_owned());
        };
        if let Some(Value::Object(result)) = whole.get_mut("result") {
            whole = std::mem::take(result);
        }
        let is_type = |value: &Value| value.get("typePath").is_some_and(Value::is_string);
        let types: BTreeMap<String, Value> = whole.into_iter().filter(|(_, value)| is_type(value)).collect();
        match types.is_empty() {
            true => Err("it has no types: expected the answer to `registry.schema` of Bevy".to_owned()),
            false => Ok(Self(types)),
        }
    }

    /// The paths of all types that are components.
    pub fn components(&self) -> impl Iterator<Item = &str> {
        let is_component = |value: &Value| {
            let reflected = value.get("reflectTypes").and_then(Value::as_array);
            reflected.is_some_and(|names| names.iter().any(|name| name == "Component"))
        };
        let all = self.0.iter().filter(move |(_, value)| is_component(value));
        all.map(|(path, _)| path.as_str())
    }

    /// Whether the type is known.
    pub fn knows(&self, path: &str) -> bool {
        self.0.contains_key(path)
    }

    /// What the game says of the type.
    pub fn about(&self, path: &str) -> Option<&str> {
        self.0.get(path)?.get("description")?.as_str()
    }

    /// The form of the values of a type.
    pub fn form(&self, path: &str) -> Form<'_> {
        match path {
            "bool" => return Form::Boolean,
            "f32" | "f64" => return Form::Number,
            "i8" | "i16" | "i32" | "i64" | "isize" | "u8" | "u16" | "u32" | "u64" | "usize" => return Form::Integer,
            "alloc::string::String" | "&str" | "alloc::borrow::Cow<str>" => return Form::Text,
            _ => {}
        }
        let Some(schema) = self.0.get(path) else {
            return Form::Other;
        };
        // What has a text of its own, as a vector of glam has, is not the object of its fields.
        if path.starts_with("glam::") || path.starts_with("core::option::Option") {
            return Form::Other;
        }
        match schema.get("kind").and_then(Value::as_str) {
            Some("Struct") => fields_of(schema).map_or(Form::Other, Form::Struct),
            Some("TupleStruct") => match &items_of(schema)[..] {
                [only] => Form::Newtype(only),
                _ => Form::Other,
            },
            Some("Enum") => {
                let variants = schema.get("oneOf").and_then(Value::as_array);
                let variants = variants.map(|all| all.iter().map(variant_of).collect::<Option<Vec<_>>>());
                variants.flatten().map_or(Form::Other, Form::Enum)
            }
            _ => Form::Other,
        }
    }

    /// A value of a type: zero, an empty text, the first variant. None if the form of it or of a part is not known.
    pub fn new_value(&self, path: &str) -> Option<Value> {
        self.made(path, DEEPEST)
    }

    fn made(&self, path: &str, deepest: usize) -> Option<Value> {
        let deeper = deepest.checked_sub(1)?;
        let object = |fields: &Fields| {
            let made = fields
                .iter()
                .map(|(name, of)| Some(((*name).to_owned(), self.made(of, deeper)?)));
            made.collect::<Option<Map<String, Value>>>().map(Value::Object)
        };
        match self.form(path) {
            Form::Boolean => Some(Value::from(false)),
            Form::Integer => Some(Value::from(0)),
            Form::Number => Some(Value::from(0.0)),
            Form::Text => Some(Value::from("")),
            Form::Struct(fields) => object(&fields),
            Form::Newtype(of) => self.made(of, deeper),
            Form::Enum(variants) => self.new_variant(variants.first()?, deeper),
            Form::Other if path.starts_with("core::option::Option") => Some(Value::Null),
            Form::Other => {
                let count = glam_numbers(path)?;
                Some(Value::from(vec![0.0; count]))
            }
        }
    }

    /// A value of an enum's variant.
    pub fn variant(&self, variant: &Variant) -> Option<Value> {
        self.new_variant(variant, DEEPEST)
    }

    fn new_variant(&self, variant: &Variant, deepest: usize) -> Option<Value> {
        let content = match &variant.content {
            None => return Some(Value::from(variant.name)),
            Some(Content::One(of)) => self.made(of, deepest)?,
            Some(Content::Several(all)) => {
                let made = all.iter().map(|of| self.made(of, deepest));
                Value::Array(made.collect::<Option<_>>()?)
            }
            Some(Content::Fields(fields)) => {
                let made = fields
                    .iter()
                    .map(|(name, of)| Some(((*name).to_owned(), self.made(of, deepest)?)));
                Value::Object(made.collect::<Option<_>>()?)
            }
        };
        Some(Value::Object(Map::from_iter([(variant.name.to_owned(), content)])))
    }
}

/// The count of numbers of a vector of glam.
fn glam_numbers(path: &str) -> Option<usize> {
    let name = path.strip_prefix("glam::")?;
    ["Vec2", "Vec3", "Vec4"]
        .iter()
        .position(|known| *known == name)
        .map(|place| place + 2)
}

/// The path of the type to which a schema of a field refers.
fn type_of(schema: &Value) -> Option<&str> {
    schema.get("type")?.get("$ref")?.as_str()?.strip_prefix("#/$defs/")
}

fn fields_of(schema: &Value) -> Option<Fields<'_>> {
    let Some(properties) = schema.get("properties").and_then(Value::as_object) else {
        return Some(Vec::new());
    };
    let fields = properties
        .iter()
        .map(|(name, field)| Some((name.as_str(), type_of(field)?)));
    fields.collect()
}

fn items_of(schema: &Value) -> Vec<&str> {
    let items = schema.get("prefixItems").and_then(Value::as_array);
    items.map_or_else(Vec::new, |items| items.iter().filter_map(type_of).collect())
}

fn variant_of(schema: &Value) -> Option<Variant<'_>> {
    if let Some(name) = schema.as_str() {
        return Some(Variant { name, content: None });
    }
    let name = schema.get("shortPath").or(schema.get("typePath"))?.as_str()?;
    let name = name.rsplit("::").next()?;
    let content = match &items_of(schema)[..] {
        [] => Content::Fields(fields_of(schema)?),
        [only] => Content::One(only),
        several => Content::Several(several.to_vec()),
    };
    Some(Variant {
        name,
        content: Some(content),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    const SCHEMA: &str = r##"{"jsonrpc": "2.0", "id": 1, "result": {
        "game::Door": {"shortPath": "Door", "typePath": "game::Door", "kind": "Struct", "type": "object",
            "reflectTypes": ["Component", "Default"], "description": "A door.",
            "properties": {"locked": {"type": {"$ref": "#/$defs/bool"}}, "speed": {"type": {"$ref": "#/$defs/f32"}},
                "state": {"type": {"$ref": "#/$defs/game::State"}}, "at": {"type": {"$ref": "#/$defs/glam::Vec3"}}}},
        "game::State": {"typePath": "game::State", "kind": "Enum", "type": "string",
            "oneOf": ["Shut", {"shortPath": "Ajar", "typePath": "game::State::Ajar", "kind": "Tuple",
                "prefixItems": [{"type": {"$ref": "#/$defs/u32"}}]}]},
        "glam::Vec3": {"typePath": "glam::Vec3", "kind": "Struct"},
        "game::Coin": {"typePath": "game::Coin", "kind": "Struct", "reflectTypes": ["Component"]},
        "game::Health": {"typePath": "game::Health", "kind": "TupleStruct", "reflectTypes": ["Component"],
            "prefixItems": [{"type": {"$ref": "#/$defs/i32"}}]}}}"##;

    #[test]
    fn a_schema_tells_the_form_of_values() {
        let types = GameTypes::read(SCHEMA).expect("a schema");
        let components: Vec<&str> = types.components().collect();
        assert_eq!(components, ["game::Coin", "game::Door", "game::Health"]);
        assert_eq!(types.about("game::Door"), Some("A door."));
        let door = types.new_value("game::Door").expect("all forms are known");
        let expected = serde_json::json!({ "locked": false, "speed": 0.0, "state": "Shut", "at": [0.0, 0.0, 0.0] });
        assert_eq!(door, expected);
        assert_eq!(types.new_value("game::Coin"), Some(serde_json::json!({})));
        assert_eq!(types.form("game::Health"), Form::Newtype("i32"));
        let Form::Enum(variants) = types.form("game::State") else {
            panic!("an enum")
        };
        assert_eq!(types.variant(&variants[1]), Some(serde_json::json!({ "Ajar": 0 })));
        assert_eq!(types.new_value("game::Unknown"), None);
    }

    #[test]
    fn what_is_no_schema_is_an_error() {
        for text in ["", "[]", "{\"a\": 1}", "{\"result\": {}}"] {
            assert!(GameTypes::read(text).is_err(), "{text}");
        }
    }
}
