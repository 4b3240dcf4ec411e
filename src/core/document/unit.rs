//! The unit of length of a scene, which a file says as `<default name="length_unit" value="cm"/>`.
//!
//! It is a `default` because other readers of the format accept names there that they do not know. In the tree it is a
//! property of the scene.

use super::{Category, Object};

/// The name of the `default`, and of the property.
pub const UNIT: &str = "length_unit";
/// The values that are units. With another value it is a `default` like any other.
const NAMES: [&str; 5] = ["m", "cm", "mm", "in", "ft"];

/// Whether a `default` directly inside of `object` says the unit of the scene.
pub(super) fn is_unit(object: &Object, name: &str, value: &str) -> bool {
    object.category == Category::Scene && name == UNIT && is_unit_name(value)
}

/// Whether a value of the `default` is a unit.
pub(super) fn is_unit_name(value: &str) -> bool {
    NAMES.contains(&value)
}
