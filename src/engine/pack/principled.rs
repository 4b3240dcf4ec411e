//! Packs the principled materials.

use super::bsdf::MaterialPacker;
use crate::material::{TexturedPrincipled, TexturedPrincipledThin};
use crate::scene::{Principled, PrincipledIndex, PrincipledThin};
use crate::shading::{SamplingRates, ThinSamplingRates, eta_from_specular};

/// An index of 1 would leave glass without a surface; these are Mitsuba's smallest differences from it.
const LEAST_SPECULAR: f32 = 1e-3;
const LEAST_GLASS_ETA: f32 = 1.001;

impl MaterialPacker<'_, '_, '_> {
    pub(super) fn principled(&mut self, material: &Principled) -> TexturedPrincipled {
        let rates = SamplingRates {
            main_specular: material.main_specular_sampling_rate,
            clearcoat: material.clearcoat_sampling_rate,
            diffuse_reflectance: material.diffuse_reflectance_sampling_rate,
        };
        TexturedPrincipled {
            base_color: self.textures.packed(&material.base_color),
            roughness: self.textures.packed(&material.roughness),
            anisotropic: self.textures.packed(&material.anisotropic),
            metallic: self.textures.packed(&material.metallic),
            spec_trans: self.textures.packed(&material.spec_trans),
            eta: principled_eta(material),
            spec_tint: self.textures.packed(&material.spec_tint),
            sheen: self.textures.packed(&material.sheen),
            sheen_tint: self.textures.packed(&material.sheen_tint),
            flatness: self.textures.packed(&material.flatness),
            clearcoat: self.textures.packed(&material.clearcoat),
            clearcoat_gloss: self.textures.packed(&material.clearcoat_gloss),
            rates,
        }
    }

    pub(super) fn principled_thin(&mut self, material: &PrincipledThin) -> TexturedPrincipledThin {
        let rates = ThinSamplingRates {
            specular_reflectance: material.specular_reflectance_sampling_rate,
            specular_transmittance: material.specular_transmittance_sampling_rate,
            diffuse_reflectance: material.diffuse_reflectance_sampling_rate,
            diffuse_transmittance: material.diffuse_transmittance_sampling_rate,
        };
        TexturedPrincipledThin {
            base_color: self.textures.packed(&material.base_color),
            roughness: self.textures.packed(&material.roughness),
            anisotropic: self.textures.packed(&material.anisotropic),
            spec_trans: self.textures.packed(&material.spec_trans),
            diff_trans: self.textures.packed(&material.diff_trans),
            eta: self.textures.packed(&material.eta),
            spec_tint: self.textures.packed(&material.spec_tint),
            sheen: self.textures.packed(&material.sheen),
            sheen_tint: self.textures.packed(&material.sheen_tint),
            flatness: self.textures.packed(&material.flatness),
            rates,
        }
    }
}

/// The refractive index inside over that outside.
fn principled_eta(material: &Principled) -> f32 {
    let refracts = material.refracts();
    match material.index {
        PrincipledIndex::Specular(specular) if refracts => eta_from_specular(specular.max(LEAST_SPECULAR)),
        PrincipledIndex::Specular(specular) => eta_from_specular(specular),
        PrincipledIndex::Eta(1.0) if refracts => LEAST_GLASS_ETA,
        PrincipledIndex::Eta(eta) => eta,
    }
}

#[cfg(test)]
mod tests {
    use super::super::material::{MaterialSource, pack_materials};
    use super::super::texture::TexturePacker;
    use super::*;
    use crate::color::Rgb;
    use crate::material::{Material as Packed, TexturedBsdf};
    use crate::scene::{Material, Parameter};
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
