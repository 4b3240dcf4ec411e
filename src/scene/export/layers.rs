//! The layers of glTF materials that follow from numbers of the principled models.

use super::level::Level;
use super::look::Look;
use crate::color::{Rgb, luminance};
use crate::gltf::write::SHEEN_ROUGHNESS;
use crate::gltf::write::material::{Anisotropy, DiffuseTransmission, Pbr, Sheen, Specular};
use crate::scene::Parameter;

/// The largest width of facets along the tangent, which is that of roughness 1.
const MOST_ALPHA: f32 = 1.0;

impl Look {
    /// The reflection of dielectrics, unless it is the usual one.
    pub fn specular_layer(&self) -> Option<Specular> {
        let is_usual = self.specular >= 1.0 && self.specular_tint == Rgb::ONE;
        (!is_usual).then(|| Specular {
            specular_factor: self.specular.min(1.0),
            specular_color_factor: (self.specular_tint != Rgb::ONE).then(|| self.specular_tint.to_array()),
            ..Specular::default()
        })
    }

    /// The sheen, if there is some.
    pub fn sheen_layer(&self) -> Option<Sheen> {
        (self.sheen != Rgb::ZERO).then(|| Sheen {
            sheen_color_factor: self.sheen.clamp(Rgb::ZERO, Rgb::ONE).to_array(),
            sheen_roughness_factor: SHEEN_ROUGHNESS,
            ..Sheen::default()
        })
    }

    /// The stretch of highlights, if there is some beside a constant roughness, which becomes that across the tangent.
    pub fn anisotropy_layer(&self, pbr: &mut Pbr) -> Option<Anisotropy> {
        if self.anisotropic <= 0.0 || self.roughness.constant().is_none() {
            return None;
        }
        // The widths of facets of `principled`; the extension widens them to mix(alpha, 1, strength^2) along the
        // tangent.
        let aspect = (1.0 - 0.9 * self.anisotropic.min(1.0)).sqrt();
        let alpha = pbr.roughness_factor * pbr.roughness_factor;
        let (along, across) = ((alpha / aspect).min(MOST_ALPHA), alpha * aspect);
        pbr.roughness_factor = across.sqrt();
        let strength = ((along - across) / (1.0 - across).max(f32::MIN_POSITIVE)).clamp(0.0, 1.0);
        Some(Anisotropy {
            anisotropy_strength: strength.sqrt(),
            ..Anisotropy::default()
        })
    }

    /// The matt light that goes through, in the colour of the surface, if there is some.
    pub fn passing_layer(&self, pbr: &Pbr) -> Option<DiffuseTransmission> {
        let [r, g, b, _] = pbr.base_color_factor;
        (self.passing > 0.0).then(|| DiffuseTransmission {
            diffuse_transmission_factor: self.passing.min(1.0),
            diffuse_transmission_color_factor: [r, g, b],
            diffuse_transmission_color_texture: pbr.base_color_texture.clone(),
            ..DiffuseTransmission::default()
        })
    }
}

/// White with this share of the hue of a colour; None if that is textured and matters.
pub(super) fn tinted(base: &Level, share: &Parameter<f32>) -> Option<Rgb> {
    let share = share.constant()?.clamp(0.0, 1.0);
    if share == 0.0 {
        return Some(Rgb::ONE);
    }
    let base = base.constant()?;
    let bright = luminance(base);
    let hue = if bright > f32::MIN_POSITIVE {
        base / bright
    } else {
        Rgb::ONE
    };
    Some(Rgb::ONE.lerp(hue, share))
}
