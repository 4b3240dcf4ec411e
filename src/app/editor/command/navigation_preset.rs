//! The presets of mouse navigation.

use serde::{Deserialize, Serialize};

/// A preset of mouse navigation, named after the program whose users are used to it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum NavigationPreset {
    /// A drag with the left or the right button looks around.
    #[default]
    Sunroom,
    /// The middle button orbits, pans and dollies; the left one draws a box.
    Blender,
    /// The mouse works as in Blender, and the right button looks around.
    Godot,
    /// The right button looks around, the middle one pans.
    #[serde(rename = "trenchbroom")]
    TrenchBroom,
}

impl NavigationPreset {
    /// All presets with their names and descriptions.
    pub const ALL: [(Self, &'static str, &'static str); 4] = [
        (
            Self::Sunroom,
            "Sunroom",
            "Left and right drag look around, middle drag pans, Shift and middle drag orbits",
        ),
        (
            Self::Blender,
            "Blender",
            "Middle drag orbits, with Shift it pans, with Ctrl it dollies; left drag selects by a box",
        ),
        (
            Self::Godot,
            "Godot",
            "Middle drag orbits, with Shift it pans; right drag looks around; left drag selects by a box",
        ),
        (
            Self::TrenchBroom,
            "TrenchBroom",
            "Right drag looks around, with Alt it orbits; middle drag pans; left drag selects by a box",
        ),
    ];

    /// The name of the preset.
    pub fn name(self) -> &'static str {
        Self::ALL
            .iter()
            .find(|(preset, ..)| *preset == self)
            .map_or("", |(_, name, _)| name)
    }
}
