//! The factor by which all bounces between the microfacets of a rough metal make it brighter than the first bounce
//! alone.
//!
//! Albedo scaling: Turquin, Practical multiple scattering compensation for microfacet models, 2019. With the albedo
//! E(wo) of the white surface and the reflectance F0 at normal incidence, the lobe grows by 1 + F0 (1 - E) / E: exact
//! for a white metal, and a coloured one saturates. The loss of reciprocity does not matter to paths that start at the
//! camera.

use super::{ConductorSpecular, MicroalbedoId, Microfacet, ShadingTables, microalbedo};
use crate::color::Rgb;
use crate::math::{Mask, Real, Vector, real_struct};

real_struct! {
    /// The compensation for the light that a rough metal loses between its microfacets: the index of its table, and the
    /// factors that do not depend on directions.
    pub struct Compensation<R> {
        /// Whether there is compensation; otherwise the scattering is single.
        is_there: R::Mask,
        table: R::Word,
        /// The position of the roughness among the table's nodes.
        row: R,
        /// The reflectance at normal incidence.
        head_on: R::Vec3,
    }
}

impl Compensation {
    /// Single scattering.
    pub const NONE: Self = Self {
        is_there: false,
        table: 0,
        row: 0.0,
        head_on: Rgb::ZERO,
    };

    /// The compensation of a metal by its distribution's table. For anisotropic roughness the root mean square is used,
    /// which is some percent off.
    pub fn new(table: MicroalbedoId, distribution: &Microfacet, specular: &ConductorSpecular) -> Self {
        Self {
            is_there: true,
            table: table.0,
            row: microalbedo::row_of(distribution.mean_alpha()),
            head_on: specular.reflectance(1.0),
        }
    }

    /// The table of albedos; None for single scattering.
    pub fn table(&self) -> Option<MicroalbedoId> {
        self.is_there.then_some(MicroalbedoId(self.table))
    }
}

impl<R: Real> Compensation<R> {
    /// The factor on single scattering, at least 1, for a viewer at the cosine `cos` in [0, 1].
    #[inline(always)]
    pub(super) fn gain(&self, tables: &ShadingTables, cos: R) -> R::Vec3 {
        let one = R::Vec3::even(R::ONE);
        if !self.is_there.any() {
            return one;
        }
        let albedo = tables.microalbedo(self.table, self.row, cos);
        let gain = one + self.head_on * ((R::ONE - albedo) / albedo);
        R::Vec3::select(self.is_there, gain, one)
    }
}
