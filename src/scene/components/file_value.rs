//! The values by which a file gives a parameter.

use std::path::Path;

use glam::{Affine2, Vec3};

use super::medium::{self, ALBEDO, Coefficients, SIGMA_S, SIGMA_T, VolumeParameter};
use super::parameter_info::ParameterInfo;
use super::parameters::{
    ABSORPTION_SCALE, ALPHA, ALPHA_U, ALPHA_V, Absorption, BEAM_WIDTH, CUTOFF_ANGLE, ConductorIor, Declared, ETA,
    EUMELANIN, FOV, FOV_AXIS, Ior, K, PHEOMELANIN, PRINCIPLED_ETA, ParameterRef, PrincipledIndex, Roughness, SIGMA_A,
    SPECULAR, SunPosition,
};
use super::pattern::Stop;
use super::texture::{Parameter, Texture};
use super::wall_openings::Opening;
use crate::color::Rgb;

/// The value of a parameter in a file.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum FileValue<'p> {
    Color(&'p Parameter<Rgb>),
    Float(&'p Parameter<f32>),
    Texture(&'p Texture),
    /// A texture that is this value everywhere.
    UniformTexture(f32),
    Number(f32),
    Flag(bool),
    Name(&'p str),
    Rgb(Rgb),
    Integer(i64),
    Path(&'p Path),
    Vector(Vec3),
    VolumeColor(&'p VolumeParameter<Rgb>),
    VolumeNumber(&'p VolumeParameter<f32>),
    Numbers(&'p [f32]),
    Openings(&'p [Opening]),
    Placing(&'p Affine2),
    Stops(&'p [Stop]),
}

impl<'p> FileValue<'p> {
    /// The texture, if it is one.
    pub fn texture(self) -> Option<&'p Texture> {
        match self {
            Self::Color(Parameter::Texture(texture))
            | Self::Float(Parameter::Texture(texture))
            | Self::Texture(texture) => Some(texture),
            _ => None,
        }
    }
}

impl<'p> ParameterRef<'p> {
    /// Calls `meet` with the values by which a file gives the parameter: usually one, two if the format has two names,
    /// or none.
    pub(crate) fn in_file(
        self,
        info: &'static ParameterInfo,
        meet: &mut impl FnMut(&'static ParameterInfo, FileValue<'p>),
    ) {
        match self {
            Self::Reflectance(color) | Self::Normals(color) => meet(info, FileValue::Color(color)),
            Self::Float(number) => meet(info, FileValue::Float(number)),
            Self::Extension(false) => {}
            // The format requires a texture here, not a number.
            Self::Height(Parameter::Constant(height)) => meet(info, FileValue::UniformTexture(*height)),
            Self::Height(Parameter::Texture(texture)) => meet(info, FileValue::Texture(texture)),
            Self::Number(number) | Self::Length(number) => meet(info, FileValue::Number(*number)),
            Self::Flag(flag) | Self::Extension(flag) => meet(info, FileValue::Flag(*flag)),
            Self::Ior(Ior::Named(name)) | Self::ConductorIor(ConductorIor::Named(name)) => {
                meet(info, FileValue::Name(name));
            }
            Self::Ior(Ior::Number(number)) => meet(info, FileValue::Number(*number)),
            Self::ConductorIor(ConductorIor::Given { eta, k }) => {
                meet(&ETA, FileValue::Color(eta));
                meet(&K, FileValue::Color(k));
            }
            Self::Distribution(distribution) => meet(info, FileValue::Name(distribution.name())),
            Self::Roughness(roughness) | Self::UniformRoughness(roughness) => match roughness {
                Roughness::Isotropic(alpha) => meet(&ALPHA, FileValue::Float(alpha)),
                Roughness::Anisotropic { u, v } => {
                    meet(&ALPHA_U, FileValue::Float(u));
                    meet(&ALPHA_V, FileValue::Float(v));
                }
            },
            Self::PrincipledIndex(PrincipledIndex::Specular(specular)) => meet(&SPECULAR, FileValue::Number(*specular)),
            Self::PrincipledIndex(PrincipledIndex::Eta(eta)) => meet(&PRINCIPLED_ETA, FileValue::Number(*eta)),
            Self::Absorption(Absorption::Melanin { eumelanin, pheomelanin }) => {
                meet(&EUMELANIN, FileValue::Number(*eumelanin));
                meet(&PHEOMELANIN, FileValue::Number(*pheomelanin));
            }
            Self::Absorption(Absorption::Given { sigma_a, scale }) => {
                meet(&SIGMA_A, FileValue::Color(sigma_a));
                meet(&ABSORPTION_SCALE, FileValue::Number(*scale));
            }
            Self::Emission(color) | Self::UniformReflectance(color) => meet(info, FileValue::Rgb(*color)),
            Self::TexturedEmission(color) => meet(info, FileValue::Color(color)),
            Self::Factor(number) | Self::Angle(number) => meet(info, FileValue::Number(*number)),
            Self::Integer(number) => meet(info, FileValue::Integer((*number).into())),
            Self::Count(number) => meet(info, FileValue::Integer((*number).into())),
            Self::Picture(path) => meet(info, FileValue::Path(path)),
            Self::OptionalTexture(texture) => {
                if let Some(texture) = texture {
                    meet(info, FileValue::Texture(texture));
                }
            }
            Self::Cone(cone) => {
                meet(&CUTOFF_ANGLE, FileValue::Number(cone.cutoff_angle));
                meet(&BEAM_WIDTH, FileValue::Number(cone.beam_width));
            }
            Self::FieldOfView(view) => {
                meet(&FOV, FileValue::Number(view.fov));
                meet(&FOV_AXIS, FileValue::Name(view.axis.name()));
            }
            Self::SunPosition(SunPosition::Direction(direction)) => meet(info, FileValue::Vector(*direction)),
            Self::SunPosition(SunPosition::PlaceAndTime(at)) => {
                at.visit(&mut |info, value| value.in_file(info, &mut *meet));
            }
            Self::SamplingWeight(factor) | Self::ExtensionFactor(factor) => {
                if *factor != 1.0 {
                    meet(info, FileValue::Number(*factor));
                }
            }
            Self::Coefficients(Coefficients::Extinction { sigma_t, albedo }) => {
                meet(&SIGMA_T, FileValue::VolumeColor(sigma_t));
                meet(&ALBEDO, FileValue::VolumeColor(albedo));
            }
            Self::Coefficients(Coefficients::Separate { sigma_s, sigma_a }) => {
                meet(&SIGMA_S, FileValue::Rgb(*sigma_s));
                meet(&medium::SIGMA_A, FileValue::Rgb(*sigma_a));
            }
            Self::VolumeEmission(emission) => {
                if emission.constant() != Some(Rgb::ZERO) {
                    meet(info, FileValue::VolumeColor(emission));
                }
            }
            Self::VolumeShare(share) => meet(info, FileValue::VolumeNumber(share)),
            Self::Values(values) => meet(info, FileValue::Numbers(values)),
            Self::Openings(openings) => meet(info, FileValue::Openings(openings)),
            Self::Nested(color) => meet(info, FileValue::Color(color)),
            Self::Placing(to_uv) => meet(info, FileValue::Placing(to_uv)),
            Self::Choice(choice) => meet(info, FileValue::Name(choice.name())),
            Self::Stops(stops) => meet(info, FileValue::Stops(stops)),
        }
    }
}
