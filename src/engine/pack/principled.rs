//! The principled materials' part of the mapping.

use super::bsdf::{HIGHEST_IOR, LOWEST_IOR, MaterialPacker};
use crate::material::{TexturedPrincipled, TexturedPrincipledThin};
use crate::scene::{Parameter, Principled, PrincipledIndex, PrincipledThin};
use crate::shading::{SamplingRates, ThinSamplingRates, eta_from_specular};
use crate::texture;

/// Glass of index 1 has no surface; Mitsuba's smallest differences instead.
const LEAST_SPECULAR: f32 = 1e-3;
const LEAST_GLASS_ETA: f32 = 1.001;

impl MaterialPacker<'_, '_, '_> {
    pub(super) fn principled(&mut self, material: &Principled) -> TexturedPrincipled {
        let rates = SamplingRates {
            main_specular: self.rate("main_specular_sampling_rate", material.main_specular_sampling_rate),
            clearcoat: self.rate("clearcoat_sampling_rate", material.clearcoat_sampling_rate),
            diffuse_reflectance: self.rate(
                "diffuse_reflectance_sampling_rate",
                material.diffuse_reflectance_sampling_rate,
            ),
        };
        TexturedPrincipled {
            base_color: self.reflectance("base_color", &material.base_color),
            roughness: self.share("roughness", &material.roughness, 0.5),
            anisotropic: self.share("anisotropic", &material.anisotropic, 0.0),
            metallic: self.share("metallic", &material.metallic, 0.0),
            spec_trans: self.share("spec_trans", &material.spec_trans, 0.0),
            eta: self.principled_eta(material),
            spec_tint: self.share("spec_tint", &material.spec_tint, 0.0),
            sheen: self.share("sheen", &material.sheen, 0.0),
            sheen_tint: self.share("sheen_tint", &material.sheen_tint, 0.0),
            flatness: self.share("flatness", &material.flatness, 0.0),
            clearcoat: self.share("clearcoat", &material.clearcoat, 0.0),
            clearcoat_gloss: self.share("clearcoat_gloss", &material.clearcoat_gloss, 0.0),
            rates,
        }
    }

    fn principled_eta(&mut self, material: &Principled) -> f32 {
        let refracts = material.refracts();
        match material.index {
            PrincipledIndex::Specular(specular) => {
                let specular = self.check.number("specular", specular, 0.0, 1.0, 0.5);
                eta_from_specular(if refracts {
                    specular.max(LEAST_SPECULAR)
                } else {
                    specular
                })
            }
            PrincipledIndex::Eta(eta) => match self.check.number("eta", eta, LOWEST_IOR, HIGHEST_IOR, 1.5) {
                1.0 if refracts => LEAST_GLASS_ETA,
                eta => eta,
            },
        }
    }

    pub(super) fn principled_thin(&mut self, material: &PrincipledThin) -> TexturedPrincipledThin {
        let rates = ThinSamplingRates {
            specular_reflectance: self.rate(
                "specular_reflectance_sampling_rate",
                material.specular_reflectance_sampling_rate,
            ),
            specular_transmittance: self.rate(
                "specular_transmittance_sampling_rate",
                material.specular_transmittance_sampling_rate,
            ),
            diffuse_reflectance: self.rate(
                "diffuse_reflectance_sampling_rate",
                material.diffuse_reflectance_sampling_rate,
            ),
            diffuse_transmittance: self.rate(
                "diffuse_transmittance_sampling_rate",
                material.diffuse_transmittance_sampling_rate,
            ),
        };
        TexturedPrincipledThin {
            base_color: self.reflectance("base_color", &material.base_color),
            roughness: self.share("roughness", &material.roughness, 0.5),
            anisotropic: self.share("anisotropic", &material.anisotropic, 0.0),
            spec_trans: self.share("spec_trans", &material.spec_trans, 0.0),
            diff_trans: self.float("diff_trans", &material.diff_trans, 0.0, 2.0, 0.0),
            eta: self.float("eta", &material.eta, LOWEST_IOR, HIGHEST_IOR, 1.5),
            spec_tint: self.share("spec_tint", &material.spec_tint, 0.0),
            sheen: self.share("sheen", &material.sheen, 0.0),
            sheen_tint: self.share("sheen_tint", &material.sheen_tint, 0.0),
            flatness: self.share("flatness", &material.flatness, 0.0),
            rates,
        }
    }

    fn share(&mut self, name: &str, value: &Parameter<f32>, otherwise: f32) -> texture::Parameter<f32> {
        self.float(name, value, 0.0, 1.0, otherwise)
    }

    fn rate(&mut self, name: &str, rate: f32) -> f32 {
        self.check.number(name, rate, 0.0, f32::MAX, 1.0)
    }
}

#[cfg(test)]
mod tests {
    use super::super::material::{MaterialSource, pack_materials};
    use super::super::texture::TexturePacker;
    use super::*;
    use crate::color::Rgb;
    use crate::material::{Material as Packed, TexturedBsdf};
    use crate::scene::Material;
    use crate::shading::DielectricModel;
    use bevy::prelude::Entity;

    fn packed(material: Material) -> (TexturedBsdf, Vec<String>) {
        let source = MaterialSource {
            entity: Entity::PLACEHOLDER,
            name: "m".into(),
            material: &material,
            first: None,
            second: None,
        };
        let mut errors = Vec::new();
        let packed = pack_materials(
            &[source],
            DielectricModel::Exact,
            &mut TexturePacker::new(&|_| None),
            &mut errors,
        );
        match packed.materials.last().expect("one was packed") {
            Packed::Textured(bsdf) => (bsdf.clone(), errors),
            other => panic!("{other:?}"),
        }
    }

    #[test]
    fn glass_has_a_surface() {
        let eta = |index, spec_trans: f32| {
            let material = Principled {
                index,
                spec_trans: spec_trans.into(),
                ..Principled::default()
            };
            match packed(Material::Principled(material.into())) {
                (TexturedBsdf::Principled(principled), errors) if errors.is_empty() => principled.eta,
                other => panic!("{other:?}"),
            }
        };
        assert_eq!(eta(PrincipledIndex::default(), 0.0), eta_from_specular(0.5));
        assert_eq!(eta(PrincipledIndex::Specular(0.0), 0.0), 1.0);
        assert_eq!(eta(PrincipledIndex::Specular(0.0), 0.5), eta_from_specular(1e-3));
        assert_eq!(eta(PrincipledIndex::Eta(1.0), 0.0), 1.0);
        assert_eq!(eta(PrincipledIndex::Eta(1.0), 0.5), 1.001);
        assert_eq!(eta(PrincipledIndex::Eta(0.8), 1.0), 0.8);
    }

    #[test]
    fn nothing_that_is_no_number_gets_in() {
        let nan = f32::NAN;
        let wild = || Parameter::Constant(nan);
        let solid = Principled {
            base_color: Rgb::new(nan, f32::INFINITY, -1.0).into(),
            roughness: wild(),
            anisotropic: wild(),
            metallic: wild(),
            spec_trans: wild(),
            index: PrincipledIndex::Eta(nan),
            spec_tint: wild(),
            sheen: wild(),
            sheen_tint: wild(),
            flatness: wild(),
            clearcoat: wild(),
            clearcoat_gloss: wild(),
            main_specular_sampling_rate: nan,
            clearcoat_sampling_rate: nan,
            diffuse_reflectance_sampling_rate: nan,
        };
        let thin = PrincipledThin {
            base_color: Rgb::new(nan, f32::INFINITY, -1.0).into(),
            roughness: wild(),
            anisotropic: wild(),
            spec_trans: wild(),
            eta: wild(),
            spec_tint: wild(),
            sheen: wild(),
            sheen_tint: wild(),
            flatness: wild(),
            diff_trans: wild(),
            specular_reflectance_sampling_rate: nan,
            specular_transmittance_sampling_rate: nan,
            diffuse_reflectance_sampling_rate: nan,
            diffuse_transmittance_sampling_rate: nan,
        };
        for (material, count) in [
            (Material::Principled(solid.into()), 15),
            (Material::PrincipledThin(thin.into()), 14),
        ] {
            let (packed, errors) = packed(material);
            let text = format!("{packed:?}");
            assert!(
                !text.contains("NaN") && !text.contains("inf") && !text.contains('-'),
                "{text}"
            );
            assert_eq!(errors.len(), count, "{errors:?}");
        }
    }
}
