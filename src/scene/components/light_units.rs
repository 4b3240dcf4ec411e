//! The units in which the lights of a scene are shown and typed. The picture and the values of the file stay the same:
//! they are radiometric.
//!
//! The file has the choice as `<default name="light_units" value="photometric"/>`, which other readers of the format
//! take for an unused name.

use bevy::prelude::*;

declare_names! {
    /// The units in which lights are shown and typed.
    #[derive(Resource, Reflect, Clone, Copy, Debug, Default, PartialEq, Eq)]
    #[reflect(Resource, PartialEq)]
    pub enum LightUnits {
        /// Watts, W/sr, W/m² and W/(m² sr), as in the file, which need not say so.
        #[default]
        Radiometric = "radiometric" => "watts and radiance",
        /// Lumens, candela, lux and nits.
        Photometric = "photometric" => "lumens, candela, lux and nits",
    }
}
