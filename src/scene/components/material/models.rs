//! The declaration of every bsdf: its plugin's name, its parameters with their defaults, and their explanations.

use std::sync::Arc;

use bevy::prelude::*;

use super::principled::{Principled, PrincipledThin};
use crate::color::Rgb;
use crate::scene::components::declare::{PluginInfo, declare_plugins};
use crate::scene::components::identity::DocumentOrder;
use crate::scene::components::parameter_info::ParameterInfo;
use crate::scene::components::parameters::{
    ALPHA, Absorption, ConductorIor, Declared, Distribution, EUMELANIN, HEIGHT, INDICES, Ior, MATERIAL,
    OFFERED_INDICES, ParameterMut, ParameterRef, Roughness,
};
use crate::scene::components::texture::Parameter;

declare_plugins! {
    /// A bsdf of the scene file. Colours are linear Rec. 709 in [0, 1].
    #[derive(Component, Reflect, Clone, Debug, PartialEq)]
    #[reflect(Component, PartialEq)]
    #[require(DocumentOrder)]
    pub enum Material {
        [PluginInfo::new("diffuse", "diffuse")]
        Diffuse {
            reflectance: Parameter<Rgb> = grey() => Reflectance(REFLECTANCE),
        },

        [PluginInfo::new("conductor", "conductor")]
        Conductor {
            ior: ConductorIor = mirror() => ConductorIor(MATERIAL),
            specular_reflectance: Parameter<Rgb> = white() => Reflectance(SPECULAR_REFLECTANCE),
        },

        [PluginInfo::new("roughconductor", "rough conductor")]
        RoughConductor {
            distribution: Distribution = Distribution::Beckmann => Distribution(DISTRIBUTION),
            alpha: Roughness = Roughness::default() => Roughness(ALPHA),
            ior: ConductorIor = mirror() => ConductorIor(MATERIAL),
            specular_reflectance: Parameter<Rgb> = white() => Reflectance(SPECULAR_REFLECTANCE),
            /// Ours: whether light that bounces between facets counts as well.
            multiple_scattering: bool = false => Extension(ParameterInfo::switch(
                "multiple_scattering",
                "Multiscatter",
                "Counts light that bounces between facets more than once, which the model leaves out: rough metals keep their brightness. Known to this program only.",
            )),
        },

        [PluginInfo::new("dielectric", "dielectric").refracting()]
        Dielectric {
            interior: Ior = medium("bk7") => Ior(INT_IOR),
            exterior: Ior = medium("air") => Ior(EXT_IOR),
            specular_reflectance: Parameter<Rgb> = white() => Reflectance(SPECULAR_REFLECTANCE),
            specular_transmittance: Parameter<Rgb> = white() => Reflectance(SPECULAR_TRANSMITTANCE),
        },

        [PluginInfo::new("roughdielectric", "rough dielectric").refracting()]
        RoughDielectric {
            distribution: Distribution = Distribution::Beckmann => Distribution(DISTRIBUTION),
            alpha: Roughness = Roughness::default() => Roughness(ALPHA),
            interior: Ior = medium("bk7") => Ior(INT_IOR),
            exterior: Ior = medium("air") => Ior(EXT_IOR),
            specular_reflectance: Parameter<Rgb> = white() => Reflectance(SPECULAR_REFLECTANCE),
            specular_transmittance: Parameter<Rgb> = white() => Reflectance(SPECULAR_TRANSMITTANCE),
        },

        /// A pane.
        [PluginInfo::new("thindielectric", "thin dielectric").refracting()]
        ThinDielectric {
            interior: Ior = medium("bk7") => Ior(INT_IOR),
            exterior: Ior = medium("air") => Ior(EXT_IOR),
            specular_reflectance: Parameter<Rgb> = white() => Reflectance(SPECULAR_REFLECTANCE),
            specular_transmittance: Parameter<Rgb> = white() => Reflectance(SPECULAR_TRANSMITTANCE),
        },

        [PluginInfo::new("plastic", "plastic")]
        Plastic {
            interior: Ior = medium("polypropylene") => Ior(INT_IOR),
            exterior: Ior = medium("air") => Ior(EXT_IOR),
            diffuse_reflectance: Parameter<Rgb> = grey() => Reflectance(DIFFUSE_REFLECTANCE),
            specular_reflectance: Parameter<Rgb> = white() => Reflectance(SPECULAR_REFLECTANCE),
            nonlinear: bool = false => Flag(NONLINEAR),
        },

        [PluginInfo::new("roughplastic", "rough plastic")]
        RoughPlastic {
            distribution: Distribution = Distribution::Beckmann => Distribution(DISTRIBUTION),
            /// The roughness, the same in all directions.
            alpha: Roughness = Roughness::default() => UniformRoughness(ALPHA),
            interior: Ior = medium("polypropylene") => Ior(INT_IOR),
            exterior: Ior = medium("air") => Ior(EXT_IOR),
            diffuse_reflectance: Parameter<Rgb> = grey() => Reflectance(DIFFUSE_REFLECTANCE),
            specular_reflectance: Parameter<Rgb> = white() => Reflectance(SPECULAR_REFLECTANCE),
            nonlinear: bool = false => Flag(NONLINEAR),
        },

        /// Boxed and shared until edited, because it is several times as large as the others.
        [PluginInfo::new("principled", "principled")]
        Principled(shared: Arc<Principled> => Arc::make_mut),

        [PluginInfo::new("principledthin", "principledthin").refracting()]
        PrincipledThin(shared: Arc<PrincipledThin> => Arc::make_mut),

        /// A fibre, on a shape that is round across it, such as a cylinder.
        [PluginInfo::new("hair", "hair").refracting()]
        Hair {
            absorption: Absorption = Absorption::default() => Absorption(EUMELANIN),
            longitudinal_roughness: f32 = 0.3 => Number(ParameterInfo::new(
                "longitudinal_roughness",
                "Rough along",
                "How far light is spread along the fibre: the length of highlights.",
                "0 to 1",
            )
            .within(0.0..=1.0)),
            azimuthal_roughness: f32 = 0.3 => Number(ParameterInfo::new(
                "azimuthal_roughness",
                "Rough around",
                "How far light is spread around the fibre: how soft and translucent many of them look together.",
                "0 to 1",
            )
            .within(0.0..=1.0)),
            /// Degrees.
            scale_tilt: f32 = 2.0 => Angle(ParameterInfo::degrees(
                "scale_tilt",
                "Scale tilt",
                "Angle of the scales on the fibre, which moves highlights along it.",
                "degrees, -90 to 90; 2 to 4 on human hair",
            )
            .within(-90.0..=90.0)),
            interior: Ior = medium("amber") => Ior(INT_IOR),
            exterior: Ior = medium("air") => Ior(EXT_IOR),
        },

        /// Shows the first material inside to the front and the second, or else the same, to the back.
        [PluginInfo::new("twosided", "two-sided").nesting(1..=2)]
        TwoSided,

        /// The second material inside with the share `weight`, the first with the rest.
        [PluginInfo::new("blendbsdf", "blend").nesting(2..=2)]
        Blend {
            weight: Parameter<f32> = 0.5.into() => Float(ParameterInfo::share(
                "weight",
                "Weight",
                "The share of the second material; the first has the rest.",
            )),
        },

        /// The material inside with the share `opacity`; the rest of the light passes through.
        [PluginInfo::new("mask", "mask").nesting(1..=1)]
        Mask {
            opacity: Parameter<f32> = 0.5.into() => Float(ParameterInfo::share(
                "opacity",
                "Opacity",
                "The share of the material inside; the rest of the light goes straight through, as through a leaf's cut-out.",
            )),
        },

        /// Shows the material inside with other shading normals: `2 colour - 1` in the shading frame.
        [PluginInfo::new("normalmap", "normal map").nesting(1..=1)]
        NormalMap {
            normals: Parameter<Rgb> = Rgb::new(0.5, 0.5, 1.0).into() => Normals(ParameterInfo::new(
                "normalmap",
                "Normals",
                "A picture of normals: red along u, green along v, blue outwards, each 0 to 1 for -1 to 1. It is to be read raw.",
                "a texture",
            )),
            gltf_tangents: bool = false => Flag(ParameterInfo::switch(
                "gltf_tangents",
                "As in glTF",
                "Green goes against v, or as the mesh's own tangents say, as in glTF, Blender and game engines. Off, it goes along the normal times the direction of u, as in Mitsuba, which is the other way where coordinates are mirrored.",
            )),
            flip_invalid_normals: bool = true => Flag(FLIP_INVALID_NORMALS),
            use_shadowing_function: bool = true => Flag(USE_SHADOWING_FUNCTION),
        },

        /// Shows the material inside with the normals of a surface that is displaced by `scale` times a height; flat
        /// without a texture.
        [PluginInfo::new("bumpmap", "bump map").nesting(1..=1)]
        BumpMap {
            height: Parameter<f32> = 0.0.into() => Height(ParameterInfo::new(
                HEIGHT,
                "Height",
                "How far the surface is moved outwards, for its normals only: the outline stays. Bitmaps give bumps; what has no slope gives none.",
                "units of the scene, from a texture",
            )),
            scale: f32 = 1.0 => Number(ParameterInfo::new(
                "scale",
                "Scale",
                "Factor on the height; below 0 bumps turn into dents.",
                "any number",
            )),
            flip_invalid_normals: bool = true => Flag(FLIP_INVALID_NORMALS),
            use_shadowing_function: bool = true => Flag(USE_SHADOWING_FUNCTION),
        },

        /// Nothing is visible.
        [PluginInfo::new("null", "nothing")]
        Null,

        /// A model of this program: a coloured mirror whose reflected direction is moved by `fuzz` (0 to 1) times a
        /// random point of the unit ball.
        [PluginInfo::new("metal", "metal with fuzz")]
        Metal {
            reflectance: Parameter<Rgb> = grey() => Reflectance(REFLECTANCE),
            fuzz: Parameter<f32> = 0.0.into() => Float(ParameterInfo::share(
                "fuzz",
                "Fuzz",
                "How far the mirrored direction is moved by chance: a simple blur.",
            )),
        },
    }
}

impl Default for Material {
    /// The format's default bsdf: a grey diffuse surface.
    fn default() -> Self {
        Self::Diffuse { reflectance: grey() }
    }
}

fn grey() -> Parameter<Rgb> {
    Rgb::splat(0.5).into()
}

fn white() -> Parameter<Rgb> {
    Rgb::ONE.into()
}

fn mirror() -> ConductorIor {
    ConductorIor::Named("none".to_owned())
}

fn medium(name: &str) -> Ior {
    Ior::Named(name.to_owned())
}

// These parameters belong to several models.

const REFLECTANCE: ParameterInfo = ParameterInfo::reflectance(
    "reflectance",
    "Reflectance",
    "The share of the light that is scattered back, by colour.",
);

const DIFFUSE_REFLECTANCE: ParameterInfo = ParameterInfo::reflectance(
    "diffuse_reflectance",
    "Base",
    "Colour of the matt base below the clear layer: the share of the light that it scatters back.",
);

const SPECULAR_REFLECTANCE: ParameterInfo = ParameterInfo::reflectance(
    "specular_reflectance",
    "Reflection",
    "Factor on what is mirrored. Real materials have 1: anything else is there for looks.",
);

const SPECULAR_TRANSMITTANCE: ParameterInfo = ParameterInfo::reflectance(
    "specular_transmittance",
    "Transmission",
    "Factor on what is let through. Tints glass at its surface, however thick it is.",
);

const INT_IOR: ParameterInfo = ParameterInfo::new(
    "int_ior",
    "Inside",
    "Index of refraction on the side that the normal turns away from: the glass, the water, the clear layer.",
    "a medium of the list, or a number from 0.01 to 100",
)
.within(INDICES)
.offering(OFFERED_INDICES);

const EXT_IOR: ParameterInfo = ParameterInfo::new(
    "ext_ior",
    "Outside",
    "Index of refraction on the side of the normal, air as a rule.",
    "a medium of the list, or a number from 0.01 to 100",
)
.within(INDICES)
.offering(OFFERED_INDICES);

const DISTRIBUTION: ParameterInfo = ParameterInfo::new(
    "distribution",
    "Microfacets",
    "How the slopes of the surface's tiny facets are spread. GGX has longer tails: highlights with a wide glow, as measured surfaces have them.",
    "Beckmann or GGX",
);

const NONLINEAR: ParameterInfo = ParameterInfo::switch(
    "nonlinear",
    "Nonlinear",
    "Lets the colour grow more saturated as light bounces about between base and clear layer.",
);

const FLIP_INVALID_NORMALS: ParameterInfo = ParameterInfo::switch(
    "flip_invalid_normals",
    "Flip invalid",
    "Turns normals that face away from the viewer about the true one, so that they stay lit.",
);

const USE_SHADOWING_FUNCTION: ParameterInfo = ParameterInfo::switch(
    "use_shadowing_function",
    "Soft shadows",
    "Softens the hard border of light and shadow that bent normals make.",
);
