//! Converts components to plugins of a document. Reading uses this to know what saving would write for an unedited
//! thing.

mod into_object;
pub mod lights;
pub mod objects;
pub mod poses;

use crate::document::Object;
use crate::scene::Properties;

/// The plugin as which a folder's transform is written.
pub const FRAME: &str = "constvolume";

/// The plugin with the properties of the thing.
pub fn with_properties(mut object: Object, properties: Option<&Properties>) -> Object {
    object
        .properties
        .extend(properties.into_iter().flat_map(Properties::for_file));
    object
}
