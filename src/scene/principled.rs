//! The parameters of `principled` and `principledthin`.

use std::ops::RangeInclusive;

use bevy::prelude::*;

use super::parameters::{ParameterVisitor, PrincipledIndex};
use super::texture::Parameter;
use crate::color::Rgb;

const UNIT: RangeInclusive<f32> = 0.0..=1.0;
const RATE: RangeInclusive<f32> = 0.0..=f32::MAX;
const INDEX: RangeInclusive<f32> = 0.01..=100.0;

/// Base, metal and glass under sheen and a clear coat. Numbers are in [0, 1]; rates of sampling are not negative.
#[derive(Reflect, Clone, Debug, PartialEq)]
pub struct Principled {
    pub base_color: Parameter<Rgb>,
    pub roughness: Parameter<f32>,
    pub anisotropic: Parameter<f32>,
    pub metallic: Parameter<f32>,
    pub spec_trans: Parameter<f32>,
    pub index: PrincipledIndex,
    pub spec_tint: Parameter<f32>,
    pub sheen: Parameter<f32>,
    pub sheen_tint: Parameter<f32>,
    pub flatness: Parameter<f32>,
    pub clearcoat: Parameter<f32>,
    pub clearcoat_gloss: Parameter<f32>,
    pub main_specular_sampling_rate: f32,
    pub clearcoat_sampling_rate: f32,
    pub diffuse_reflectance_sampling_rate: f32,
}

impl Default for Principled {
    fn default() -> Self {
        Self {
            base_color: Rgb::splat(0.5).into(),
            roughness: 0.5.into(),
            anisotropic: 0.0.into(),
            metallic: 0.0.into(),
            spec_trans: 0.0.into(),
            index: PrincipledIndex::default(),
            spec_tint: 0.0.into(),
            sheen: 0.0.into(),
            sheen_tint: 0.0.into(),
            flatness: 0.0.into(),
            clearcoat: 0.0.into(),
            clearcoat_gloss: 0.0.into(),
            main_specular_sampling_rate: 1.0,
            clearcoat_sampling_rate: 1.0,
            diffuse_reflectance_sampling_rate: 1.0,
        }
    }
}

impl Principled {
    /// Whether there is, or may be somewhere, glass.
    pub fn refracts(&self) -> bool {
        self.spec_trans != Parameter::Constant(0.0)
    }

    pub(super) fn visit(&mut self, visitor: &mut impl ParameterVisitor) {
        visitor.reflectance("base_color", &mut self.base_color);
        visitor.float("roughness", &mut self.roughness, UNIT);
        visitor.float("anisotropic", &mut self.anisotropic, UNIT);
        visitor.float("metallic", &mut self.metallic, UNIT);
        visitor.float("spec_trans", &mut self.spec_trans, UNIT);
        visitor.principled_index(&mut self.index);
        visitor.float("spec_tint", &mut self.spec_tint, UNIT);
        visitor.float("sheen", &mut self.sheen, UNIT);
        visitor.float("sheen_tint", &mut self.sheen_tint, UNIT);
        visitor.float("flatness", &mut self.flatness, UNIT);
        visitor.float("clearcoat", &mut self.clearcoat, UNIT);
        visitor.float("clearcoat_gloss", &mut self.clearcoat_gloss, UNIT);
        visitor.number(
            "main_specular_sampling_rate",
            &mut self.main_specular_sampling_rate,
            RATE,
        );
        visitor.number("clearcoat_sampling_rate", &mut self.clearcoat_sampling_rate, RATE);
        let rate = &mut self.diffuse_reflectance_sampling_rate;
        visitor.number("diffuse_reflectance_sampling_rate", rate, RATE);
    }
}

/// A sheet that scatters to both sides. Numbers are in [0, 1] unless stated.
#[derive(Reflect, Clone, Debug, PartialEq)]
pub struct PrincipledThin {
    pub base_color: Parameter<Rgb>,
    pub roughness: Parameter<f32>,
    pub anisotropic: Parameter<f32>,
    pub spec_trans: Parameter<f32>,
    /// Refractive index of the sheet over that around it, above 0.
    pub eta: Parameter<f32>,
    pub spec_tint: Parameter<f32>,
    pub sheen: Parameter<f32>,
    pub sheen_tint: Parameter<f32>,
    pub flatness: Parameter<f32>,
    /// Twice the share of diffuse light that is transmitted, in [0, 2].
    pub diff_trans: Parameter<f32>,
    pub specular_reflectance_sampling_rate: f32,
    pub specular_transmittance_sampling_rate: f32,
    pub diffuse_reflectance_sampling_rate: f32,
    pub diffuse_transmittance_sampling_rate: f32,
}

impl Default for PrincipledThin {
    fn default() -> Self {
        Self {
            base_color: Rgb::splat(0.5).into(),
            roughness: 0.5.into(),
            anisotropic: 0.0.into(),
            spec_trans: 0.0.into(),
            eta: 1.5.into(),
            spec_tint: 0.0.into(),
            sheen: 0.0.into(),
            sheen_tint: 0.0.into(),
            flatness: 0.0.into(),
            diff_trans: 0.0.into(),
            specular_reflectance_sampling_rate: 1.0,
            specular_transmittance_sampling_rate: 1.0,
            diffuse_reflectance_sampling_rate: 1.0,
            diffuse_transmittance_sampling_rate: 1.0,
        }
    }
}

impl PrincipledThin {
    pub(super) fn visit(&mut self, visitor: &mut impl ParameterVisitor) {
        visitor.reflectance("base_color", &mut self.base_color);
        visitor.float("roughness", &mut self.roughness, UNIT);
        visitor.float("anisotropic", &mut self.anisotropic, UNIT);
        visitor.float("spec_trans", &mut self.spec_trans, UNIT);
        visitor.float("eta", &mut self.eta, INDEX);
        visitor.float("spec_tint", &mut self.spec_tint, UNIT);
        visitor.float("sheen", &mut self.sheen, UNIT);
        visitor.float("sheen_tint", &mut self.sheen_tint, UNIT);
        visitor.float("flatness", &mut self.flatness, UNIT);
        visitor.float("diff_trans", &mut self.diff_trans, 0.0..=2.0);
        let rate = &mut self.specular_reflectance_sampling_rate;
        visitor.number("specular_reflectance_sampling_rate", rate, RATE);
        let rate = &mut self.specular_transmittance_sampling_rate;
        visitor.number("specular_transmittance_sampling_rate", rate, RATE);
        let rate = &mut self.diffuse_reflectance_sampling_rate;
        visitor.number("diffuse_reflectance_sampling_rate", rate, RATE);
        let rate = &mut self.diffuse_transmittance_sampling_rate;
        visitor.number("diffuse_transmittance_sampling_rate", rate, RATE);
    }
}

#[cfg(test)]
mod tests {
    use super::super::encode::objects;
    use super::super::{Material, SceneDescription, read};
    use super::*;
    use crate::document::{self, Category, Value};
    use std::path::Path;

    /// Reads a scene with these bsdfs; returns it and its messages.
    fn scene(bsdfs: &str) -> (SceneDescription, Vec<String>) {
        let text = format!("<scene version='3.0.0'>{bsdfs}<sensor type='perspective'/></scene>");
        let mut document = document::parse_str(&*text, Path::new("/scene.xml"), &[]);
        let scene = read::read(&mut document);
        let complaints = document.diagnostics.list.iter().map(|d| d.message.clone());
        (scene, complaints.collect())
    }

    fn material(bsdf: &str) -> Material {
        let (scene, complaints) = scene(bsdf);
        assert_eq!(complaints, [""; 0], "{bsdf}");
        scene.materials[0].material.clone()
    }

    /// The bsdf with every parameter that it writes given another value, 1 / 32, 2 / 32, ...
    fn renumbered(plugin: &str) -> String {
        let written = objects::material(&material(&format!("<bsdf type='{plugin}'/>")), Path::new("/"));
        assert_eq!(written.category, Category::Bsdf);
        let parameters = written.properties.iter().zip(1u8..).map(|(property, number)| {
            let (name, value) = (&property.name, f32::from(number) / 32.0);
            match property.value {
                Value::Rgb(_) => format!("<rgb name='{name}' value='0.5, 0.25, {value}'/>"),
                _ => format!("<float name='{name}' value='{value}'/>"),
            }
        });
        format!("<bsdf type='{plugin}'>{}</bsdf>", parameters.collect::<String>())
    }

    #[test]
    fn every_parameter_is_read_and_written() {
        for (plugin, count) in [("principled", 15), ("principledthin", 14)] {
            let file = renumbered(plugin);
            let written = objects::material(&material(&file), Path::new("/"));
            assert_eq!(written.properties.len(), count);
            for (property, number) in written.properties.iter().zip(1u8..) {
                let value = f32::from(number) / 32.0;
                let expected = match property.value {
                    Value::Rgb(_) => Value::Rgb(Rgb::new(0.5, 0.25, value)),
                    _ => Value::Float(value),
                };
                assert_eq!(property.value, expected, "{plugin} {}", property.name);
            }
        }
        let Material::Principled(principled) = material(&renumbered("principled")) else {
            panic!("not principled")
        };
        assert_eq!(principled.roughness, (2.0 / 32.0).into());
        assert_eq!(principled.clearcoat_gloss, (12.0 / 32.0).into());
        assert_eq!(principled.index, PrincipledIndex::Specular(6.0 / 32.0));
    }

    #[test]
    fn the_index_has_one_of_two_names() {
        let index = |parameters: &str| {
            let (scene, complaints) = scene(&format!("<bsdf type='principled'>{parameters}</bsdf>"));
            match &scene.materials[0].material {
                Material::Principled(principled) => (principled.index, complaints),
                other => panic!("{other:?}"),
            }
        };
        let (specular, eta) = (
            "<float name='specular' value='0.25'/>",
            "<float name='eta' value='1.25'/>",
        );
        assert_eq!(index(""), (PrincipledIndex::Specular(0.5), vec![]));
        assert_eq!(index(specular), (PrincipledIndex::Specular(0.25), vec![]));
        assert_eq!(index(eta), (PrincipledIndex::Eta(1.25), vec![]));
        let (kept, complaints) = index(&format!("{specular}{eta}"));
        assert_eq!(kept, PrincipledIndex::default());
        assert!(
            complaints.len() == 1 && complaints[0].contains("exclude each other"),
            "{complaints:?}"
        );
    }

    #[test]
    fn what_light_passes_is_not_made_two_sided() {
        let two_sided = |bsdf: &str| scene(&format!("<bsdf type='twosided'>{bsdf}</bsdf>")).1;
        assert_eq!(two_sided("<bsdf type='principled'/>"), [""; 0]);
        for bsdf in [
            "<bsdf type='principledthin'/>",
            "<bsdf type='principled'><float name='spec_trans' value='0.1'/></bsdf>",
        ] {
            let complaints = two_sided(bsdf);
            assert!(
                complaints.len() == 1 && complaints[0].contains("two sides already"),
                "{complaints:?}"
            );
        }
    }
}
