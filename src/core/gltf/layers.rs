//! The layers of glTF materials that the models of the scene format have in other terms: stretched facets, the colours
//! of sheen and of dielectric reflection, and light that goes through thin matt sheets.

use glam::Vec3;

use super::combine::{Stretch, StretchImages, stretched};
use super::material::Surface;
use super::objects::{object, with_child, with_color, with_float};
use super::picture::{Made, Picture};
use super::scene::Builder;
use super::schema::{DiffuseTransmission, Material, TextureInfo};
use crate::color::luminance;
use crate::document::{Category, Object};

/// The largest distance of two hues that count as equal.
const SAME_HUE: f32 = 0.1;

/// The hue of a colour: the colour over its luminance. White for black.
fn hue(color: Vec3) -> Vec3 {
    let bright = luminance(color);
    match bright > f32::MIN_POSITIVE {
        true => color / bright,
        false => Vec3::ONE,
    }
}

/// The share of the hue of `base` that gives white the hue of `wanted`, and whether it is reached.
fn tint(wanted: Vec3, base: Vec3) -> (f32, bool) {
    let [wanted, base] = [wanted, base].map(|color| hue(color) - Vec3::ONE);
    let share = match base.length_squared() > SAME_HUE * SAME_HUE {
        true => (wanted.dot(base) / base.length_squared()).clamp(0.0, 1.0),
        false => 0.0,
    };
    (share, (share * base - wanted).length() <= SAME_HUE)
}

impl Material {
    /// The transmission of matt light; None if the material has none.
    pub(super) fn diffuse_transmission(&self) -> Option<&DiffuseTransmission> {
        let layer = self.extensions.diffuse_transmission.as_ref();
        layer.filter(|layer| layer.diffuse_transmission_factor > 0.0 && self.extensions.unlit.is_none())
    }

    /// Twice the share of transmitted light, if the material is a matt sheet of one colour, as `principledthin` is.
    pub(super) fn matt_sheet(&self) -> Option<f32> {
        let passing = self.diffuse_transmission()?;
        let pbr = &self.pbr_metallic_roughness;
        let [r, g, b, _] = pbr.base_color_factor;
        let is_same = passing.diffuse_transmission_color_factor == [r, g, b]
            && passing.diffuse_transmission_color_texture == pbr.base_color_texture
            && passing.diffuse_transmission_texture.is_none();
        (is_same && self.is_matt()).then_some(2.0 * passing.diffuse_transmission_factor)
    }
}

impl Builder<'_> {
    /// The surface with its roughness, and with the stretch of its facets.
    pub(super) fn with_roughness(&mut self, bsdf: Object, surface: &Surface) -> Object {
        let material = surface.material;
        let pbr = &material.pbr_metallic_roughness;
        let (factor, texture) = (pbr.roughness_factor, pbr.metallic_roughness_texture.as_ref());
        if let Some((info, glossiness)) = material.specular_picture() {
            let made = Made::Complement {
                channel: 3,
                factor: glossiness,
            };
            return match self.bitmap("roughness", info, made) {
                Some(bitmap) => with_child(bsdf, bitmap),
                None => with_float(bsdf, "roughness", factor),
            };
        }
        let layer = material.extensions.anisotropy.as_ref();
        let Some(layer) = layer.filter(|layer| layer.anisotropy_strength > 0.0) else {
            return self.with_number(bsdf, "roughness", factor, texture, 1);
        };
        let strength = layer.anisotropy_strength.min(1.0);
        let (info, images) = match (texture, layer.anisotropy_texture.as_ref()) {
            (None, None) => {
                let [roughness, anisotropic] = stretched(factor, strength);
                return with_float(with_float(bsdf, "roughness", roughness), "anisotropic", anisotropic);
            }
            (Some(roughness), None) => (roughness, StretchImages::Roughness),
            (None, Some(strength)) => (strength, StretchImages::Strength),
            (Some(roughness), Some(strength)) => match self.images_alike(roughness, strength) {
                Some((_, image)) => (roughness, StretchImages::Both(image)),
                None => {
                    let sentence = "its anisotropy has no texture, because its pictures lie differently";
                    self.warn(format!("{}: {sentence}", surface.title));
                    (roughness, StretchImages::Roughness)
                }
            },
        };
        let [roughness, anisotropic] = stretched(factor, strength);
        let parts = [
            ("roughness", Stretch::Roughness, roughness),
            ("anisotropic", Stretch::Anisotropic, anisotropic),
        ];
        parts.into_iter().fold(bsdf, |bsdf, (name, part, number)| {
            let made = Made::Stretched {
                part,
                images,
                factors: [factor, strength],
            };
            match self.bitmap(name, info, made) {
                Some(bitmap) => with_child(bsdf, bitmap),
                None => with_float(bsdf, name, number),
            }
        })
    }

    /// The mean base colour of a surface whose base colour is referenced already.
    fn mean_base(&mut self, surface: &Surface) -> Vec3 {
        let pbr = &surface.material.pbr_metallic_roughness;
        let [r, g, b, _] = pbr.base_color_factor;
        let made = Made::Color(if surface.mesh.colors { [1.0; 3] } else { [r, g, b] });
        let image = pbr
            .base_color_texture
            .as_ref()
            .filter(|_| surface.material.specular_picture().is_none());
        match image.and_then(|info| self.image_of(info)) {
            Some(image) => self.mean_of_picture(Picture { image, made }),
            None => Vec3::new(r, g, b),
        }
    }

    /// The surface with the colour of its dielectric reflection, as far as the base colour has it.
    pub(super) fn with_specular_tint(&mut self, bsdf: Object, surface: &Surface) -> Object {
        let specular = surface.material.extensions.specular.as_ref();
        let Some(color) = specular.and_then(|specular| specular.specular_color_factor) else {
            return bsdf;
        };
        let base = self.mean_base(surface);
        let (share, is_reached) = tint(color.into(), base);
        if !is_reached {
            let sentence = "its specular reflection has the brightness of its colour, but not all of the colour";
            self.warn(format!("{}: {sentence}", surface.title));
        }
        match share > 0.0 {
            true => with_float(bsdf, "spec_tint", share),
            false => bsdf,
        }
    }

    /// The surface with its sheen.
    pub(super) fn with_sheen(&mut self, bsdf: Object, surface: &Surface) -> Object {
        let sheen = surface.material.extensions.sheen.as_ref();
        let Some(sheen) = sheen.filter(|sheen| sheen.sheen_color_factor != [0.0; 3]) else {
            return bsdf;
        };
        let color = sheen.sheen_color_factor;
        let bitmap = match &sheen.sheen_color_texture {
            Some(info) => self.bitmap("sheen", info, Made::Brightness(color)),
            None => None,
        };
        let bsdf = match bitmap {
            Some(bitmap) => with_child(bsdf, bitmap),
            None => with_float(bsdf, "sheen", luminance(color.into())),
        };
        let base = self.mean_base(surface);
        let (share, is_reached) = tint(color.into(), base);
        if !is_reached {
            let sentence = "its sheen has the brightness of its colour, but not all of the colour";
            self.warn(format!("{}: {sentence}", surface.title));
        }
        match share > 0.0 {
            true => with_float(bsdf, "sheen_tint", share),
            false => bsdf,
        }
    }

    /// A surface blended with a sheet that lets matt light through (KHR_materials_diffuse_transmission).
    pub(super) fn with_passing_light(
        &mut self,
        opaque: Object,
        passing: &DiffuseTransmission,
        material: &Material,
    ) -> Object {
        let color = passing.diffuse_transmission_color_factor;
        let texture = passing.diffuse_transmission_color_texture.as_ref();
        let sheet = object(Category::Bsdf, "principledthin");
        let sheet = with_float(
            self.with_color_of(sheet, "base_color", color, texture),
            "diff_trans",
            2.0,
        );
        let pbr = &material.pbr_metallic_roughness;
        let matt = match pbr.metallic_roughness_texture {
            Some(_) => 1.0,
            None => 1.0 - pbr.metallic_factor.clamp(0.0, 1.0),
        };
        let factor = passing.diffuse_transmission_factor.clamp(0.0, 1.0) * matt;
        let shares = passing.diffuse_transmission_texture.as_ref();
        let blend = self.with_number(object(Category::Bsdf, "blendbsdf"), "weight", factor, shares, 3);
        let opaque = with_child(object(Category::Bsdf, "twosided"), opaque);
        with_child(with_child(blend, opaque), sheet)
    }

    fn with_color_of(&mut self, bsdf: Object, name: &str, color: [f32; 3], texture: Option<&TextureInfo>) -> Object {
        match texture.and_then(|texture| self.bitmap(name, texture, Made::Color(color))) {
            Some(bitmap) => with_child(bsdf, bitmap),
            None => with_color(bsdf, name, color.into()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tints_are_found_along_the_hue_of_the_base() {
        let base = Vec3::new(0.8, 0.2, 0.1);
        for share in [0.0, 0.4, 1.0] {
            let wanted = 0.3 * Vec3::ONE.lerp(hue(base), share);
            let (found, is_reached) = tint(wanted, base);
            assert!((found - share).abs() < 1e-5 && is_reached, "{found} {share}");
        }
        assert_eq!(tint(Vec3::new(0.1, 0.2, 0.9), Vec3::splat(0.5)), (0.0, false));
        assert!(!tint(Vec3::new(0.1, 0.2, 0.9), base).1);
        assert_eq!(tint(Vec3::splat(0.5), Vec3::ZERO), (0.0, true));
    }
}
