//! Materials as the user knows them: the bsdfs of the format with their own parameters.

use bevy::prelude::*;

use super::DocumentOrder;
use crate::color::Rgb;

/// A bsdf of the scene file. Colours are linear Rec. 709 in [0, 1].
#[derive(Component, Reflect, Clone, Debug, PartialEq)]
#[reflect(Component, PartialEq)]
#[require(DocumentOrder)]
pub enum Material {
    Diffuse {
        reflectance: Rgb,
    },
    Conductor {
        ior: ConductorIor,
        specular_reflectance: Rgb,
    },
    /// GGX with roughness `alpha` (the width, not its square root), above 0.
    RoughConductor {
        ior: ConductorIor,
        specular_reflectance: Rgb,
        alpha: f32,
    },
    Dielectric {
        interior: Ior,
        exterior: Ior,
        specular_reflectance: Rgb,
        specular_transmittance: Rgb,
    },
    /// A coloured mirror whose reflected direction is moved by `fuzz` (0 to 1) times a random point of the unit ball.
    Metal {
        reflectance: Rgb,
        fuzz: f32,
    },
    /// Shows [`FirstNested`] to the front and [`SecondNested`], or else the same, to the back.
    TwoSided,
}

impl Default for Material {
    /// The format's default bsdf: a grey diffuse surface.
    fn default() -> Self {
        Self::Diffuse {
            reflectance: Rgb::splat(0.5),
        }
    }
}

/// Complex index of refraction of a conductor, per colour channel.
#[derive(Reflect, Clone, Debug, PartialEq)]
pub enum ConductorIor {
    /// `Au`, `Cu`, ...; `none` is a perfect mirror.
    Named(String),
    Given {
        eta: Rgb,
        k: Rgb,
    },
}

/// Index of refraction of a dielectric.
#[derive(Reflect, Clone, Debug, PartialEq)]
pub enum Ior {
    /// `water`, `bk7`, ...
    Named(String),
    Number(f32),
}

/// A shape's material.
#[derive(Component, Reflect, Clone, Copy, Debug, PartialEq, Eq)]
#[reflect(Component, PartialEq)]
#[relationship(relationship_target = MaterialUsers)]
pub struct UsesMaterial(pub Entity);

/// The shapes that use a material.
#[derive(Component, Reflect, Clone, Debug, Default, PartialEq, Eq)]
#[relationship_target(relationship = UsesMaterial)]
pub struct MaterialUsers(Vec<Entity>);

/// The first material inside a material (the front of a two-sided one).
#[derive(Component, Reflect, Clone, Copy, Debug, PartialEq, Eq)]
#[reflect(Component, PartialEq)]
#[relationship(relationship_target = FirstNestedIn)]
pub struct FirstNested(pub Entity);

/// The materials that have this one as their first.
#[derive(Component, Reflect, Clone, Debug, Default, PartialEq, Eq)]
#[relationship_target(relationship = FirstNested)]
pub struct FirstNestedIn(Vec<Entity>);

/// The second material inside a material (the back of a two-sided one).
#[derive(Component, Reflect, Clone, Copy, Debug, PartialEq, Eq)]
#[reflect(Component, PartialEq)]
#[relationship(relationship_target = SecondNestedIn)]
pub struct SecondNested(pub Entity);

/// The materials that have this one as their second.
#[derive(Component, Reflect, Clone, Debug, Default, PartialEq, Eq)]
#[relationship_target(relationship = SecondNested)]
pub struct SecondNestedIn(Vec<Entity>);
