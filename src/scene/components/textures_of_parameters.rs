//! The textures among the values of parameters.

use super::parameter_info::ParameterInfo;
use super::parameters::{ALPHA, ALPHA_U, ALPHA_V, Absorption, ConductorIor, ETA, K, ParameterMut, Roughness, SIGMA_A};
use super::texture::{ChosenPicture, Parameter, SquarePath, Texture};

impl ParameterMut<'_> {
    /// Sets the picture at a place of the value if its name in the file is `parameter`. If it had no texture before,
    /// the picture is raw unless the parameter is a colour.
    pub(crate) fn set_picture(self, info: &ParameterInfo, parameter: &str, place: SquarePath, picture: &ChosenPicture) {
        let is = |info: &ParameterInfo| info.name == parameter;
        match self {
            Self::Reflectance(color) if is(info) => set_picture(color, place, picture, false),
            Self::Normals(normals) if is(info) => set_picture(normals, place, picture, true),
            Self::Float(number) | Self::Height(number) if is(info) => set_picture(number, place, picture, true),
            Self::ConductorIor(ConductorIor::Given { eta, .. }) if is(&ETA) => set_picture(eta, place, picture, true),
            Self::ConductorIor(ConductorIor::Given { k, .. }) if is(&K) => set_picture(k, place, picture, true),
            Self::Absorption(Absorption::Given { sigma_a, .. }) if is(&SIGMA_A) => {
                set_picture(sigma_a, place, picture, true)
            }
            Self::Roughness(roughness) | Self::UniformRoughness(roughness) => match roughness {
                Roughness::Isotropic(alpha) if is(&ALPHA) => set_picture(alpha, place, picture, true),
                Roughness::Anisotropic { u, .. } if is(&ALPHA_U) => set_picture(u, place, picture, true),
                Roughness::Anisotropic { v, .. } if is(&ALPHA_V) => set_picture(v, place, picture, true),
                _ => {}
            },
            _ => {}
        }
    }

    /// Calls `meet` with every texture of the value, and with the declaration of its parameter.
    pub(crate) fn for_each_texture(
        self,
        info: &'static ParameterInfo,
        meet: &mut impl FnMut(&'static ParameterInfo, &mut Texture),
    ) {
        match self {
            Self::Reflectance(value) | Self::Normals(value) | Self::TexturedEmission(value) => {
                show_texture(info, value, meet);
            }
            Self::Float(value) | Self::Height(value) => show_texture(info, value, meet),
            Self::ConductorIor(ConductorIor::Given { eta, k }) => {
                show_texture(&ETA, eta, meet);
                show_texture(&K, k, meet);
            }
            Self::Absorption(Absorption::Given { sigma_a, .. }) => show_texture(&SIGMA_A, sigma_a, meet),
            Self::Roughness(roughness) | Self::UniformRoughness(roughness) => match roughness {
                Roughness::Isotropic(alpha) => show_texture(&ALPHA, alpha, meet),
                Roughness::Anisotropic { u, v } => {
                    show_texture(&ALPHA_U, u, meet);
                    show_texture(&ALPHA_V, v, meet);
                }
            },
            Self::OptionalTexture(Some(texture)) => meet(info, texture),
            _ => {}
        }
    }
}

fn show_texture<T>(
    info: &'static ParameterInfo,
    value: &mut Parameter<T>,
    meet: &mut impl FnMut(&'static ParameterInfo, &mut Texture),
) {
    if let Parameter::Texture(texture) = value {
        meet(info, texture);
    }
}

fn set_picture<T>(value: &mut Parameter<T>, place: SquarePath, picture: &ChosenPicture, raw: bool) {
    let was_plain = matches!(value, Parameter::Constant(_));
    value.set_picture_at(place, picture.clone());
    if let Parameter::Texture(Texture::Bitmap(bitmap)) = value
        && was_plain
    {
        bitmap.raw = raw;
    }
}
