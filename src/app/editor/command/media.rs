//! The places where things refer to media, and what a shape can be filled with.

use bevy::prelude::Entity;

/// A place where a thing refers to a medium.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum MediumSide {
    /// Inside of a shape.
    Interior,
    /// Outside of a shape, at its surface.
    Exterior,
    /// Around a camera or a light.
    Around,
}

impl MediumSide {
    /// The sides with their words in scripts, and the labels of their rows.
    pub const ALL: [(Self, &'static str, &'static str); 3] = [
        (Self::Interior, "interior", "Interior"),
        (Self::Exterior, "exterior", "Exterior"),
        (Self::Around, "around", "Is in"),
    ];

    /// The word in scripts, which is also the name of what differs among selected things.
    pub fn name(self) -> &'static str {
        Self::ALL[self as usize].1
    }

    /// The label of its row.
    pub fn label(self) -> &'static str {
        Self::ALL[self as usize].2
    }
}

/// What a shape is filled with.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Filling {
    /// A new medium that scatters nearly all light, mostly onwards.
    Fog,
    /// A new medium that absorbs half of the light that it takes out.
    Smoke,
    /// A medium of the scene.
    Medium(Entity),
}

impl Filling {
    /// The word for a new medium, which becomes its name; None for one of the scene.
    pub fn name(self) -> Option<&'static str> {
        match self {
            Self::Fog => Some("fog"),
            Self::Smoke => Some("smoke"),
            Self::Medium(_) => None,
        }
    }
}
