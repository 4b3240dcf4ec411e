//! Materials as the user knows them: the bsdfs of the format with their own parameters.

use std::sync::Arc;

use bevy::prelude::*;

use super::DocumentOrder;
use super::parameters::{ConductorIor, Distribution, Ior, Roughness};
use super::principled::{Principled, PrincipledThin};
use super::texture::Parameter;
use crate::color::Rgb;

/// A bsdf of the scene file. Colours are linear Rec. 709 in [0, 1]. [`Material::visit`] lists the parameters with their names.
#[derive(Component, Reflect, Clone, Debug, PartialEq)]
#[reflect(Component, PartialEq)]
#[require(DocumentOrder)]
pub enum Material {
    Diffuse {
        reflectance: Parameter<Rgb>,
    },
    Conductor {
        ior: ConductorIor,
        specular_reflectance: Parameter<Rgb>,
    },
    RoughConductor {
        distribution: Distribution,
        alpha: Roughness,
        ior: ConductorIor,
        specular_reflectance: Parameter<Rgb>,
        /// Ours: whether light that bounces between facets counts as well.
        multiple_scattering: bool,
    },
    Dielectric {
        interior: Ior,
        exterior: Ior,
        specular_reflectance: Parameter<Rgb>,
        specular_transmittance: Parameter<Rgb>,
    },
    RoughDielectric {
        distribution: Distribution,
        alpha: Roughness,
        interior: Ior,
        exterior: Ior,
        specular_reflectance: Parameter<Rgb>,
        specular_transmittance: Parameter<Rgb>,
    },
    /// A pane.
    ThinDielectric {
        interior: Ior,
        exterior: Ior,
        specular_reflectance: Parameter<Rgb>,
        specular_transmittance: Parameter<Rgb>,
    },
    Plastic {
        interior: Ior,
        exterior: Ior,
        diffuse_reflectance: Parameter<Rgb>,
        specular_reflectance: Parameter<Rgb>,
        nonlinear: bool,
    },
    RoughPlastic {
        distribution: Distribution,
        /// Isotropic.
        alpha: Roughness,
        interior: Ior,
        exterior: Ior,
        diffuse_reflectance: Parameter<Rgb>,
        specular_reflectance: Parameter<Rgb>,
        nonlinear: bool,
    },
    /// A coloured mirror whose reflected direction is moved by `fuzz` (0 to 1) times a random point of the unit ball.
    Metal {
        reflectance: Parameter<Rgb>,
        fuzz: Parameter<f32>,
    },
    /// Shared until it is edited, because it is several times as large as the others.
    Principled(Arc<Principled>),
    /// Shared until it is edited, as `Principled` is.
    PrincipledThin(Arc<PrincipledThin>),
    /// Shows [`FirstNested`] to the front and [`SecondNested`], or else the same, to the back.
    TwoSided,
    /// [`SecondNested`] with the share `weight`, [`FirstNested`] with the rest.
    Blend {
        weight: Parameter<f32>,
    },
    /// [`FirstNested`] with the share `opacity`; the rest of the light passes through.
    Mask {
        opacity: Parameter<f32>,
    },
    /// Shows [`FirstNested`] with other shading normals: `2 colour - 1` in the shading frame.
    NormalMap {
        normals: Parameter<Rgb>,
        flip_invalid_normals: bool,
        use_shadowing_function: bool,
    },
    /// Shows [`FirstNested`] with the normals of a surface that is displaced by `scale` times a height; flat without a texture.
    BumpMap {
        height: Parameter<f32>,
        scale: f32,
        flip_invalid_normals: bool,
        use_shadowing_function: bool,
    },
    /// Nothing to be seen.
    Null,
}

impl Default for Material {
    /// The format's default bsdf: a grey diffuse surface.
    fn default() -> Self {
        Self::Diffuse {
            reflectance: Rgb::splat(0.5).into(),
        }
    }
}

impl Material {
    /// The names of all plugins, ours last.
    pub const PLUGINS: [&'static str; 17] = [
        "diffuse",
        "conductor",
        "roughconductor",
        "dielectric",
        "roughdielectric",
        "thindielectric",
        "plastic",
        "roughplastic",
        "principled",
        "principledthin",
        "twosided",
        "blendbsdf",
        "mask",
        "normalmap",
        "bumpmap",
        "null",
        "metal",
    ];

    /// The material that a plugin of this name is when its file gives no parameter; None if there is no such plugin.
    pub fn of_plugin(plugin: &str) -> Option<Self> {
        let white = || Parameter::Constant(Rgb::ONE);
        let mirror = || ConductorIor::Named("none".to_owned());
        let medium = |name: &str| Ior::Named(name.to_owned());
        Some(match plugin {
            "diffuse" => Self::default(),
            "conductor" => Self::Conductor {
                ior: mirror(),
                specular_reflectance: white(),
            },
            "roughconductor" => Self::RoughConductor {
                distribution: Distribution::Beckmann,
                alpha: Roughness::default(),
                ior: mirror(),
                specular_reflectance: white(),
                multiple_scattering: false,
            },
            "dielectric" => Self::Dielectric {
                interior: medium("bk7"),
                exterior: medium("air"),
                specular_reflectance: white(),
                specular_transmittance: white(),
            },
            "roughdielectric" => Self::RoughDielectric {
                distribution: Distribution::Beckmann,
                alpha: Roughness::default(),
                interior: medium("bk7"),
                exterior: medium("air"),
                specular_reflectance: white(),
                specular_transmittance: white(),
            },
            "thindielectric" => Self::ThinDielectric {
                interior: medium("bk7"),
                exterior: medium("air"),
                specular_reflectance: white(),
                specular_transmittance: white(),
            },
            "plastic" => Self::Plastic {
                interior: medium("polypropylene"),
                exterior: medium("air"),
                diffuse_reflectance: Rgb::splat(0.5).into(),
                specular_reflectance: white(),
                nonlinear: false,
            },
            "roughplastic" => Self::RoughPlastic {
                distribution: Distribution::Beckmann,
                alpha: Roughness::default(),
                interior: medium("polypropylene"),
                exterior: medium("air"),
                diffuse_reflectance: Rgb::splat(0.5).into(),
                specular_reflectance: white(),
                nonlinear: false,
            },
            "metal" => Self::Metal {
                reflectance: Rgb::splat(0.5).into(),
                fuzz: 0.0.into(),
            },
            "principled" => Self::Principled(Arc::default()),
            "principledthin" => Self::PrincipledThin(Arc::default()),
            "twosided" => Self::TwoSided,
            "blendbsdf" => Self::Blend { weight: 0.5.into() },
            "mask" => Self::Mask { opacity: 0.5.into() },
            "normalmap" => Self::NormalMap {
                normals: Rgb::new(0.5, 0.5, 1.0).into(),
                flip_invalid_normals: true,
                use_shadowing_function: true,
            },
            "bumpmap" => Self::BumpMap {
                height: 0.0.into(),
                scale: 1.0,
                flip_invalid_normals: true,
                use_shadowing_function: true,
            },
            "null" => Self::Null,
            _ => return None,
        })
    }

    /// The plugin's name in the file.
    pub fn plugin(&self) -> &'static str {
        match self {
            Self::Diffuse { .. } => "diffuse",
            Self::Conductor { .. } => "conductor",
            Self::RoughConductor { .. } => "roughconductor",
            Self::Dielectric { .. } => "dielectric",
            Self::RoughDielectric { .. } => "roughdielectric",
            Self::ThinDielectric { .. } => "thindielectric",
            Self::Plastic { .. } => "plastic",
            Self::RoughPlastic { .. } => "roughplastic",
            Self::Metal { .. } => "metal",
            Self::Principled(_) => "principled",
            Self::PrincipledThin(_) => "principledthin",
            Self::TwoSided => "twosided",
            Self::Blend { .. } => "blendbsdf",
            Self::Mask { .. } => "mask",
            Self::NormalMap { .. } => "normalmap",
            Self::BumpMap { .. } => "bumpmap",
            Self::Null => "null",
        }
    }

    /// How many materials it takes inside.
    pub fn nested_count(&self) -> std::ops::RangeInclusive<usize> {
        match self {
            Self::TwoSided => 1..=2,
            Self::Blend { .. } => 2..=2,
            Self::Mask { .. } | Self::NormalMap { .. } | Self::BumpMap { .. } => 1..=1,
            _ => 0..=0,
        }
    }

    /// Whether it refracts: then it has two sides already.
    pub fn refracts(&self) -> bool {
        match self {
            Self::Dielectric { .. }
            | Self::RoughDielectric { .. }
            | Self::ThinDielectric { .. }
            | Self::PrincipledThin(_) => true,
            Self::Principled(principled) => principled.refracts(),
            _ => false,
        }
    }
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

/// The first material inside a material (the front of a two-sided one, say).
#[derive(Component, Reflect, Clone, Copy, Debug, PartialEq, Eq)]
#[reflect(Component, PartialEq)]
#[relationship(relationship_target = FirstNestedIn)]
pub struct FirstNested(pub Entity);

/// The materials that have this one as their first.
#[derive(Component, Reflect, Clone, Debug, Default, PartialEq, Eq)]
#[relationship_target(relationship = FirstNested)]
pub struct FirstNestedIn(Vec<Entity>);

/// The second material inside a material (the back of a two-sided one, say).
#[derive(Component, Reflect, Clone, Copy, Debug, PartialEq, Eq)]
#[reflect(Component, PartialEq)]
#[relationship(relationship_target = SecondNestedIn)]
pub struct SecondNested(pub Entity);

/// The materials that have this one as their second.
#[derive(Component, Reflect, Clone, Debug, Default, PartialEq, Eq)]
#[relationship_target(relationship = SecondNested)]
pub struct SecondNestedIn(Vec<Entity>);
