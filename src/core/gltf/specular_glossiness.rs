//! Converts materials of the archived extension KHR_materials_pbrSpecularGlossiness to the most similar
//! metallic-roughness ones.
//!
//! Its diffuse and specular colour are taken as those of a metallic-roughness material whose dielectric part reflects 4
//! % at normal incidence.

use glam::Vec3;

use super::schema::{Material, Pbr, Specular, SpecularGlossiness, TextureInfo};
use crate::color::luminance;

/// The reflectance of dielectrics at normal incidence.
const DIELECTRIC: f32 = 0.04;

impl Material {
    /// Converts the material to metallic-roughness, unless the file gives that as well. Of the archived extension only
    /// what has a specular picture is kept.
    pub(super) fn settle(&mut self) {
        let is_given = !self.pbr_metallic_roughness.is_usual();
        let Some(given) = self.extensions.specular_glossiness.take().filter(|_| !is_given) else {
            return;
        };
        let (pbr, specular) = converted(&given);
        self.pbr_metallic_roughness = pbr;
        // Where nothing is mirrored, the picture says nothing.
        let picture = given.specular_glossiness_texture.as_ref();
        match picture.filter(|_| given.specular_factor != [0.0; 3]) {
            Some(_) => self.extensions.specular_glossiness = Some(given),
            None => self.extensions.specular = specular,
        }
    }

    /// The picture of specular colour and glossiness, and the factor on the glossiness.
    pub(super) fn specular_picture(&self) -> Option<(&TextureInfo, f32)> {
        let given = self.extensions.specular_glossiness.as_ref()?;
        Some((given.specular_glossiness_texture.as_ref()?, given.glossiness_factor))
    }
}

impl Pbr {
    fn is_usual(&self) -> bool {
        let usual = Self::default();
        self.base_color_factor == usual.base_color_factor
            && (self.metallic_factor, self.roughness_factor) == (usual.metallic_factor, usual.roughness_factor)
            && self.base_color_texture.is_none()
            && self.metallic_roughness_texture.is_none()
    }
}

fn converted(given: &SpecularGlossiness) -> (Pbr, Option<Specular>) {
    let [r, g, b, alpha] = given.diffuse_factor;
    let (diffuse, mirrored) = (Vec3::new(r, g, b), Vec3::from(given.specular_factor));
    let bright = luminance(mirrored);
    let (base, metallic) = match given.diffuse_texture.is_none() && given.specular_glossiness_texture.is_none() {
        true => metallic_look(diffuse, mirrored),
        false => (diffuse.clamp(Vec3::ZERO, Vec3::ONE), 0.0),
    };
    let pbr = Pbr {
        base_color_factor: base.extend(alpha).to_array(),
        base_color_texture: given.diffuse_texture.clone(),
        metallic_factor: metallic,
        roughness_factor: 1.0 - given.glossiness_factor.clamp(0.0, 1.0),
        metallic_roughness_texture: None,
    };
    let specular = (metallic == 0.0).then(|| Specular {
        specular_factor: (bright / DIELECTRIC).clamp(0.0, 1.0),
        specular_texture: None,
        specular_color_factor: (bright > DIELECTRIC).then_some([bright / DIELECTRIC; 3]),
        specular_color_texture: None,
    });
    (pbr, specular)
}

/// The base colour and the metallic for a diffuse and a specular colour.
pub(super) fn metallic_look(diffuse: Vec3, mirrored: Vec3) -> (Vec3, f32) {
    let rest = 1.0 - mirrored.max_element().clamp(0.0, 1.0);
    let (dark, bright) = (luminance(diffuse), luminance(mirrored));
    let metallic = match bright > DIELECTRIC {
        true => share_of_metal(dark * rest / (1.0 - DIELECTRIC), bright),
        false => 0.0,
    };
    // The base colour required by the dielectric part, and that by the metal.
    let of_diffuse = diffuse / (1.0 - metallic).max(1e-3);
    let of_metal = (mirrored - DIELECTRIC * (1.0 - metallic)) / metallic.max(1e-3);
    let base = of_diffuse.lerp(of_metal, metallic * metallic);
    (base.clamp(Vec3::ZERO, Vec3::ONE), metallic)
}

/// The metallic share m for which the base colour c = `diffuse` / (1 - m), as a metal's, gives the reflectance
/// `mirrored`: 0.04 (1 - m) + c m.
fn share_of_metal(diffuse: f32, mirrored: f32) -> f32 {
    let b = diffuse + mirrored - 2.0 * DIELECTRIC;
    let c = DIELECTRIC - mirrored;
    let root = (b * b - 4.0 * DIELECTRIC * c).max(0.0).sqrt();
    ((root - b) / (2.0 * DIELECTRIC)).clamp(0.0, 1.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(diffuse: [f32; 3], specular: [f32; 3]) -> (Pbr, Option<Specular>) {
        let [r, g, b] = diffuse;
        converted(&SpecularGlossiness {
            diffuse_factor: [r, g, b, 0.5],
            specular_factor: specular,
            glossiness_factor: 0.75,
            ..SpecularGlossiness::default()
        })
    }

    #[test]
    fn paint_keeps_its_colour_and_metal_its_mirror_image() {
        let (paint, specular) = of([0.1, 0.4, 0.2], [0.0; 3]);
        assert_eq!(paint.base_color_factor, [0.1, 0.4, 0.2, 0.5]);
        assert_eq!((paint.metallic_factor, paint.roughness_factor), (0.0, 0.25));
        assert_eq!(specular.expect("none is mirrored").specular_factor, 0.0);
        let (plastic, specular) = of([0.2; 3], [0.04; 3]);
        let factor = specular.expect("the usual").specular_factor;
        assert!(
            plastic.metallic_factor == 0.0 && (factor - 1.0).abs() < 1e-5,
            "{factor}"
        );
        let (gold, _) = of([0.0; 3], [1.0, 0.7, 0.3]);
        assert!(gold.metallic_factor > 0.99, "{}", gold.metallic_factor);
        let [r, g, b, _] = gold.base_color_factor;
        assert!(Vec3::new(r, g, b).abs_diff_eq(Vec3::new(1.0, 0.7, 0.3), 0.02));
    }
}
