//! What a material of an MTL library is meant to be.

use super::mesh::MtlMaterial;

/// A diffuse colour up to this is written by exporters that avoid zero.
const AS_GOOD_AS_BLACK: f32 = 0.02;

/// The kinds of surfaces that MTL materials stand for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum MtlModel {
    /// Clear glass, through which light comes out in the colour `tf`.
    Glass {
        /// The index of refraction.
        index: f32,
    },
    /// Rough metal in the colour `kd`.
    Metal {
        /// The square root of the spread of its facets, as the file gives it: at least [`MtlModel::LEAST_ROUGHNESS`]
        /// is meant.
        roughness: f32,
    },
    /// A mirror in the colour `ks`.
    Mirror,
    /// Diffuse `kd`.
    Matt,
}

impl MtlModel {
    /// The least roughness of a metal.
    pub const LEAST_ROUGHNESS: f32 = 0.03;
}

impl MtlMaterial {
    /// The kind of surface. MTL describes Phong-like shading, so this is an interpretation. Of what is no glass, the
    /// share [`MtlMaterial::d`] is there.
    pub fn model(&self) -> MtlModel {
        let refracts = (self.ni - 1.0).abs() > 1e-3 && self.ni > 0.0;
        if matches!(self.illum, Some(6 | 7)) || refracts && matches!(self.illum, Some(4 | 9)) {
            let index = if refracts { self.ni } else { 1.5 };
            return MtlModel::Glass { index };
        }
        if self.pm.is_some_and(|metallic| metallic > 0.5) {
            let roughness = self.pr.unwrap_or(0.0);
            return MtlModel::Metal { roughness };
        }
        match self.illum {
            Some(3 | 5) if self.kd.max_element() <= AS_GOOD_AS_BLACK => MtlModel::Mirror,
            _ => MtlModel::Matt,
        }
    }
}
