//! The list of every material's parameters, written down once: reading, writing, showing and comparing visit that list.

use std::ops::RangeInclusive;
use std::path::Path;
use std::sync::Arc;

use super::material::Material;
use super::parameters::{ConductorIor, Distribution, Ior, NORMALS, ParameterVisitor, PrincipledIndex, Roughness};
use super::texture::{Parameter, SquarePath, Texture};
use crate::color::Rgb;

const UNIT: RangeInclusive<f32> = 0.0..=1.0;

impl Material {
    /// Shows `visitor` every parameter. Materials inside this one are not among them.
    pub fn visit(&mut self, visitor: &mut impl ParameterVisitor) {
        match self {
            Self::Diffuse { reflectance } => visitor.reflectance("reflectance", reflectance),
            Self::Conductor {
                ior,
                specular_reflectance,
            } => {
                visitor.conductor_ior(ior);
                visitor.reflectance("specular_reflectance", specular_reflectance);
            }
            Self::RoughConductor {
                distribution,
                alpha,
                ior,
                specular_reflectance,
                multiple_scattering,
            } => {
                visitor.distribution(distribution);
                visitor.roughness(alpha);
                visitor.conductor_ior(ior);
                visitor.reflectance("specular_reflectance", specular_reflectance);
                visitor.extension("multiple_scattering", multiple_scattering);
            }
            Self::RoughDielectric {
                distribution,
                alpha,
                interior,
                exterior,
                specular_reflectance,
                specular_transmittance,
            } => {
                visitor.distribution(distribution);
                visitor.roughness(alpha);
                visitor.ior("int_ior", interior);
                visitor.ior("ext_ior", exterior);
                visitor.reflectance("specular_reflectance", specular_reflectance);
                visitor.reflectance("specular_transmittance", specular_transmittance);
            }
            Self::Plastic {
                interior,
                exterior,
                diffuse_reflectance,
                specular_reflectance,
                nonlinear,
            } => {
                visitor.ior("int_ior", interior);
                visitor.ior("ext_ior", exterior);
                visitor.reflectance("diffuse_reflectance", diffuse_reflectance);
                visitor.reflectance("specular_reflectance", specular_reflectance);
                visitor.flag("nonlinear", nonlinear);
            }
            Self::RoughPlastic {
                distribution,
                alpha,
                interior,
                exterior,
                diffuse_reflectance,
                specular_reflectance,
                nonlinear,
            } => {
                visitor.distribution(distribution);
                visitor.roughness(alpha);
                visitor.ior("int_ior", interior);
                visitor.ior("ext_ior", exterior);
                visitor.reflectance("diffuse_reflectance", diffuse_reflectance);
                visitor.reflectance("specular_reflectance", specular_reflectance);
                visitor.flag("nonlinear", nonlinear);
            }
            Self::Dielectric {
                interior,
                exterior,
                specular_reflectance,
                specular_transmittance,
            }
            | Self::ThinDielectric {
                interior,
                exterior,
                specular_reflectance,
                specular_transmittance,
            } => {
                visitor.ior("int_ior", interior);
                visitor.ior("ext_ior", exterior);
                visitor.reflectance("specular_reflectance", specular_reflectance);
                visitor.reflectance("specular_transmittance", specular_transmittance);
            }
            Self::Metal { reflectance, fuzz } => {
                visitor.reflectance("reflectance", reflectance);
                visitor.float("fuzz", fuzz, UNIT);
            }
            Self::Principled(principled) => Arc::make_mut(principled).visit(visitor),
            Self::PrincipledThin(thin) => Arc::make_mut(thin).visit(visitor),
            Self::TwoSided | Self::Null => {}
            Self::Blend { weight } => visitor.float("weight", weight, UNIT),
            Self::Mask { opacity } => visitor.float("opacity", opacity, UNIT),
            Self::NormalMap {
                normals,
                flip_invalid_normals,
                use_shadowing_function,
            } => {
                visitor.reflectance(NORMALS, normals);
                visitor.flag("flip_invalid_normals", flip_invalid_normals);
                visitor.flag("use_shadowing_function", use_shadowing_function);
            }
            Self::BumpMap {
                height,
                scale,
                flip_invalid_normals,
                use_shadowing_function,
            } => {
                visitor.height(height);
                visitor.number("scale", scale, -f32::MAX..=f32::MAX);
                visitor.flag("flip_invalid_normals", flip_invalid_normals);
                visitor.flag("use_shadowing_function", use_shadowing_function);
            }
        }
    }
}

impl Material {
    /// Shows `meet` every texture among the parameters, with the parameter's name.
    pub fn visit_textures(&mut self, meet: impl FnMut(&'static str, &mut Texture)) {
        self.visit(&mut Texturable(Textures(meet)));
    }

    /// The picture at `path` at a place of the parameter of this name. Where there was no texture before, a picture of anything but colours
    /// is looked at raw.
    pub fn set_picture(&mut self, parameter: &str, place: SquarePath, path: &Path) {
        self.visit(&mut Texturable(PictureSetter { parameter, place, path }));
    }
}

/// Meets the parameters that may be textures, whatever they are of.
trait TexturableVisitor {
    /// `is_color`: as opposed to numbers, a picture of which is looked at raw.
    fn meet<T>(&mut self, name: &'static str, value: &mut Parameter<T>, is_color: bool);
}

/// Leaves all other parameters alone.
struct Texturable<V>(V);

impl<V: TexturableVisitor> ParameterVisitor for Texturable<V> {
    fn reflectance(&mut self, name: &'static str, value: &mut Parameter<Rgb>) {
        self.0.meet(name, value, name != NORMALS);
    }

    fn color(&mut self, name: &'static str, value: &mut Parameter<Rgb>) {
        self.0.meet(name, value, false);
    }

    fn float(&mut self, name: &'static str, value: &mut Parameter<f32>, _range: RangeInclusive<f32>) {
        self.0.meet(name, value, false);
    }

    fn number(&mut self, _name: &'static str, _value: &mut f32, _range: RangeInclusive<f32>) {}

    fn flag(&mut self, _name: &'static str, _value: &mut bool) {}

    fn principled_index(&mut self, _value: &mut PrincipledIndex) {}

    fn ior(&mut self, _name: &'static str, _value: &mut Ior) {}

    fn conductor_ior(&mut self, value: &mut ConductorIor) {
        if let ConductorIor::Given { eta, k } = value {
            self.color("eta", eta);
            self.color("k", k);
        }
    }

    fn distribution(&mut self, _value: &mut Distribution) {}

    fn roughness(&mut self, value: &mut Roughness) {
        match value {
            Roughness::Isotropic(alpha) => self.0.meet("alpha", alpha, false),
            Roughness::Anisotropic { u, v } => {
                self.0.meet("alpha_u", u, false);
                self.0.meet("alpha_v", v, false);
            }
        }
    }
}

struct Textures<F>(F);

impl<F: FnMut(&'static str, &mut Texture)> TexturableVisitor for Textures<F> {
    fn meet<T>(&mut self, name: &'static str, value: &mut Parameter<T>, _is_color: bool) {
        if let Parameter::Texture(texture) = value {
            self.0(name, texture);
        }
    }
}

struct PictureSetter<'a> {
    parameter: &'a str,
    place: SquarePath,
    path: &'a Path,
}

impl TexturableVisitor for PictureSetter<'_> {
    fn meet<T>(&mut self, name: &'static str, value: &mut Parameter<T>, is_color: bool) {
        if name != self.parameter {
            return;
        }
        let was_plain = matches!(value, Parameter::Constant(_));
        value.set_picture_at(self.place, self.path.to_owned());
        if let Parameter::Texture(Texture::Bitmap(bitmap)) = value
            && was_plain
        {
            bitmap.raw = !is_color;
        }
    }
}
