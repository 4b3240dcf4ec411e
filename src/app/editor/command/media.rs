//! The sides on which things refer to media, and the fillings of shapes.

use super::traits::Traits;

use bevy::prelude::Entity;

declare_names! {
    /// A place where a thing refers to a medium.
    #[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
    pub enum MediumSide {
        /// Inside of a shape.
        Interior = "interior" => "Interior",
        /// Outside of a shape, at its surface.
        Exterior = "exterior" => "Exterior",
        /// Around a camera or a light.
        Around = "around" => "Is in",
    }
}

/// The filling of a shape.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Filling {
    /// A new medium that scatters nearly all light, mostly onwards.
    Fog,
    /// A new medium that absorbs half of the extinguished light.
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

/// An edit of the media that shapes, cameras and lights refer to.
#[derive(Clone, Debug, PartialEq)]
pub enum MediumEdit {
    /// Sets the medium inside or outside of shapes, or around cameras and lights; or removes it.
    UseMedium {
        /// The shapes, cameras or lights.
        things: Vec<Entity>,
        /// The side of the thing.
        side: MediumSide,
        /// The medium. None is empty space.
        medium: Option<Entity>,
    },
    /// Gives a thing a new medium of its own.
    GiveMedium {
        /// The shape, camera or light.
        thing: Entity,
        /// The side of the thing.
        side: MediumSide,
    },
    /// Fills closed shapes; an opaque surface gets the material `null`.
    Fill {
        /// The shapes.
        shapes: Vec<Entity>,
        /// The medium.
        with: Filling,
    },
}

impl MediumEdit {
    pub(super) fn traits(&self) -> Traits {
        match self {
            Self::UseMedium { things, medium, .. } => Traits::edit("Assign medium").of(things).giving(*medium),
            Self::GiveMedium { thing, .. } => Traits::edit("New medium").of(&[*thing]),
            Self::Fill { shapes, with } => {
                let traits = Traits::edit("Fill").of(shapes);
                match with {
                    Filling::Medium(medium) => traits.giving(Some(*medium)),
                    Filling::Fog | Filling::Smoke => traits.giving_name(with.name().unwrap_or_default()),
                }
            }
        }
    }
}
