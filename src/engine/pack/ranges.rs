//! Clamps the parameters of materials and lights to their declared ranges, because edits need not come from a file.

use super::Checker;
use crate::color::{BRIGHTEST, Rgb};
use crate::scene::medium::{self, ALBEDO, SIGMA_S, SIGMA_T};
use crate::scene::parameters::{
    ABSORPTION_SCALE, ALPHA, ALPHA_U, ALPHA_V, BEAM_WIDTH, CUTOFF_ANGLE, ETA, EUMELANIN, K, PHEOMELANIN,
    PRINCIPLED_ETA, SIGMA_A, SPECULAR,
};
use crate::scene::{
    Absorption, AreaLight, Coefficients, ConductorIor, Cone, Declared, Emitter, Ior, Material, Medium, Parameter,
    ParameterInfo, ParameterMut, ParameterRef, PhaseFunction, PrincipledIndex, Roughness, VolumeParameter,
};
use crate::shading::ior;

/// The number of a parameter, if it is a number.
fn number(value: Option<ParameterRef>) -> Option<f32> {
    match value? {
        ParameterRef::Float(number) | ParameterRef::Height(number) => number.constant(),
        ParameterRef::Number(number)
        | ParameterRef::Angle(number)
        | ParameterRef::Factor(number)
        | ParameterRef::SamplingWeight(number)
        | ParameterRef::ExtensionFactor(number) => Some(*number),
        ParameterRef::Cone(cone) => Some(cone.cutoff_angle),
        ParameterRef::FieldOfView(view) => Some(view.fov),
        ParameterRef::Ior(Ior::Number(index)) => Some(*index),
        ParameterRef::Ior(Ior::Named(name)) => ior::dielectric_ior(name),
        _ => None,
    }
}

impl Checker<'_> {
    /// The material with all numbers in range, and with known names of media and metals.
    pub fn material(&mut self, material: &Material) -> Material {
        self.declared(material, Material::usual(material.plugin()))
    }

    /// The light with all numbers in range.
    pub fn emitter(&mut self, emitter: &Emitter) -> Emitter {
        self.declared(emitter, Emitter::usual(emitter.plugin()))
    }

    /// The medium with all numbers in range.
    pub fn medium(&mut self, medium: &Medium) -> Medium {
        let mut mended = self.declared(medium, Some(&Medium::default()));
        self.phase(&mut mended.phase);
        mended
    }

    fn phase(&mut self, phase: &mut PhaseFunction) {
        phase.visit_mut(&mut |info, value| self.parameter(info, value, None));
        if let PhaseFunction::Blend(blend) = phase {
            blend.of.iter_mut().for_each(|part| self.phase(part));
        }
    }

    /// The emission of a shape with all numbers in range.
    pub fn area_light(&mut self, light: &AreaLight) -> AreaLight {
        self.declared(light, Some(&AreaLight::default()))
    }

    /// The value with all numbers in range. `usual` has the defaults of its plugin.
    fn declared<T: Declared + Clone>(&mut self, value: &T, usual: Option<&T>) -> T {
        let mut defaults = Vec::new();
        if let Some(usual) = usual {
            usual.visit(&mut |_, value| defaults.push(value));
        }
        let (mut mended, mut defaults) = (value.clone(), defaults.into_iter());
        mended.visit_mut(&mut |info, value| self.parameter(info, value, defaults.next()));
        mended
    }

    /// The number clamped to the declared range; `otherwise` if it is NaN.
    pub fn within(&mut self, info: &ParameterInfo, value: f32, otherwise: f32) -> f32 {
        self.number(info.name, value, *info.range.start(), *info.range.end(), otherwise)
    }

    /// Clamps a parameter to its range. `usual` is the default of its plugin.
    fn parameter(&mut self, info: &ParameterInfo, value: ParameterMut, usual: Option<ParameterRef>) {
        let otherwise = number(usual).unwrap_or(info.usual);
        match value {
            ParameterMut::Reflectance(color) | ParameterMut::Normals(color) => self.constant_color(info, color, 1.0),
            ParameterMut::UniformReflectance(color) => *color = self.reflectance(info.name, *color),
            ParameterMut::Emission(color) => *color = self.color(info.name, *color, BRIGHTEST),
            ParameterMut::TexturedEmission(color) => self.constant_color(info, color, BRIGHTEST),
            ParameterMut::Float(number) | ParameterMut::Height(number) => {
                self.constant_number(info, number, otherwise);
            }
            ParameterMut::Number(number) | ParameterMut::Angle(number) => {
                *number = self.within(info, *number, otherwise);
            }
            ParameterMut::Factor(factor)
            | ParameterMut::SamplingWeight(factor)
            | ParameterMut::ExtensionFactor(factor) => {
                let most = info.range.end().min(BRIGHTEST);
                *factor = self.number(info.name, *factor, *info.range.start(), most, otherwise);
            }
            ParameterMut::Ior(index) => self.ior(info, index, usual),
            ParameterMut::ConductorIor(index) => self.conductor(index, usual),
            ParameterMut::Roughness(roughness) | ParameterMut::UniformRoughness(roughness) => match roughness {
                Roughness::Isotropic(alpha) => self.constant_number(&ALPHA, alpha, ALPHA.usual),
                Roughness::Anisotropic { u, v } => {
                    self.constant_number(&ALPHA_U, u, ALPHA_U.usual);
                    self.constant_number(&ALPHA_V, v, ALPHA_V.usual);
                }
            },
            ParameterMut::PrincipledIndex(index) => match index {
                PrincipledIndex::Specular(specular) => *specular = self.within(&SPECULAR, *specular, SPECULAR.usual),
                PrincipledIndex::Eta(eta) => *eta = self.within(&PRINCIPLED_ETA, *eta, PRINCIPLED_ETA.usual),
            },
            ParameterMut::Absorption(absorption) => match absorption {
                Absorption::Melanin { eumelanin, pheomelanin } => {
                    *eumelanin = self.within(&EUMELANIN, *eumelanin, EUMELANIN.usual);
                    *pheomelanin = self.within(&PHEOMELANIN, *pheomelanin, PHEOMELANIN.usual);
                }
                Absorption::Given { sigma_a, scale } => {
                    *scale = self.within(&ABSORPTION_SCALE, *scale, ABSORPTION_SCALE.usual);
                    self.constant_color(&SIGMA_A, sigma_a, *SIGMA_A.range.end());
                }
            },
            ParameterMut::Cone(Cone {
                cutoff_angle,
                beam_width,
            }) => {
                *cutoff_angle = self.within(&CUTOFF_ANGLE, *cutoff_angle, otherwise);
                // A cutoff that is moved below the beam narrows the beam as well.
                let (beam, most) = (beam_width.min(*cutoff_angle), *cutoff_angle);
                *beam_width = self.number(BEAM_WIDTH.name, beam, 0.0, most, most);
            }
            ParameterMut::FieldOfView(view) => view.fov = self.within(info, view.fov, otherwise),
            ParameterMut::Coefficients(coefficients) => match coefficients {
                Coefficients::Extinction { sigma_t, albedo } => {
                    self.volume_color(&SIGMA_T, sigma_t);
                    self.volume_color(&ALBEDO, albedo);
                }
                Coefficients::Separate { sigma_s, sigma_a } => {
                    *sigma_s = self.color(SIGMA_S.name, *sigma_s, *SIGMA_S.range.end());
                    *sigma_a = self.color(medium::SIGMA_A.name, *sigma_a, *medium::SIGMA_A.range.end());
                }
            },
            ParameterMut::VolumeEmission(emission) => self.volume_color(info, emission),
            ParameterMut::VolumeShare(VolumeParameter::Constant(share) | VolumeParameter::Box { value: share, .. }) => {
                *share = self.within(info, *share, 0.5);
            }
            ParameterMut::Values(values) => self.table(info, values),
            // The packing of the sun checks values derived from its position.
            // Building parts become meshes as they are.
            ParameterMut::Length(_)
            | ParameterMut::Count(_)
            | ParameterMut::Openings(_)
            | ParameterMut::SunPosition(_)
            | ParameterMut::Integer(_)
            | ParameterMut::Flag(_)
            | ParameterMut::Extension(_)
            | ParameterMut::Distribution(_)
            | ParameterMut::Picture(_)
            | ParameterMut::OptionalTexture(_)
            | ParameterMut::Nested(_)
            | ParameterMut::Placing(_)
            | ParameterMut::Choice(_)
            | ParameterMut::Stops(_)
            | ParameterMut::VolumeShare(VolumeParameter::Grid(_)) => {}
        }
    }

    /// The constant value of a volume. A grid is checked where its file is read.
    fn volume_color(&mut self, info: &ParameterInfo, volume: &mut VolumeParameter<Rgb>) {
        if let VolumeParameter::Constant(color) | VolumeParameter::Box { value: color, .. } = volume {
            *color = self.color(info.name, *color, info.range.end().min(BRIGHTEST));
        }
    }

    /// Checks the table of a phase function. An unusable one is replaced by isotropic scattering.
    fn table(&mut self, info: &ParameterInfo, values: &mut Vec<f32>) {
        let is_good = |value: &f32| (0.0..=BRIGHTEST).contains(value);
        let sums_up = values.iter().any(|value| *value > 0.0);
        if values.len() < 2 || !values.iter().all(is_good) || !sums_up {
            let what = info.name;
            self.report(format_args!(
                "{what} should be two numbers or more, not negative and not all 0: light goes all ways alike"
            ));
            *values = vec![1.0; 2];
        }
    }

    fn constant_color(&mut self, info: &ParameterInfo, value: &mut Parameter<Rgb>, most: f32) {
        if let Parameter::Constant(color) = value {
            *color = self.color(info.name, *color, most);
        }
    }

    fn constant_number(&mut self, info: &ParameterInfo, value: &mut Parameter<f32>, otherwise: f32) {
        if let Parameter::Constant(number) = value {
            *number = self.within(info, *number, otherwise);
        }
    }

    fn ior(&mut self, info: &ParameterInfo, index: &mut Ior, usual: Option<ParameterRef>) {
        match index {
            Ior::Number(given) => *given = self.within(info, *given, number(usual).unwrap_or(info.usual)),
            Ior::Named(name) if ior::dielectric_ior(name).is_some() => {}
            Ior::Named(name) => {
                let Some(ParameterRef::Ior(Ior::Named(usual))) = usual else {
                    return;
                };
                let what = info.name;
                self.report(format_args!(
                    "there is no material named {name:?} for {what}, {usual} is used"
                ));
                name.clone_from(usual);
            }
        }
    }

    fn conductor(&mut self, index: &mut ConductorIor, usual: Option<ParameterRef>) {
        match index {
            ConductorIor::Given { eta, k } => {
                self.constant_color(&ETA, eta, *ETA.range.end());
                self.constant_color(&K, k, *K.range.end());
            }
            ConductorIor::Named(name) if ior::conductor_ior(name).is_some() => {}
            ConductorIor::Named(name) => {
                self.report(format_args!(
                    "there is no conductor named {name:?}, a perfect mirror is used"
                ));
                if let Some(ParameterRef::ConductorIor(usual)) = usual {
                    index.clone_from(usual);
                }
            }
        }
    }
}
