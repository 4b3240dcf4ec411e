//! The factor by which all bounces between the microfacets of a rough metal make it brighter than the first bounce alone.
//!
//! Albedo scaling: Turquin, Practical multiple scattering compensation for microfacet models, 2019. With the albedo E(wo) of the white
//! surface and the reflectance F0 at normal incidence, the lobe grows by 1 + F0 (1 - E) / E: exact for a white metal, and a coloured
//! one saturates. The loss of reciprocity does not matter to paths that start at the camera.

use super::{ConductorSpecular, MicroalbedoId, Microfacet, ShadingTables, microalbedo};
use crate::color::Rgb;

/// The compensation for the light that a rough metal loses between its microfacets: an id of its table, and the factors that do not depend on
/// directions.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Compensation {
    table: MicroalbedoId,
    /// The place of the roughness among the nodes.
    row: f32,
    /// The reflectance at normal incidence.
    head_on: Rgb,
}

impl Compensation {
    /// The compensation of a metal by the table of its distribution. Where roughness depends on the direction, it is that of the root mean
    /// square: some percent off.
    pub fn new(table: MicroalbedoId, distribution: &Microfacet, specular: &ConductorSpecular) -> Self {
        Self {
            table,
            row: microalbedo::row_of(distribution.mean_alpha()),
            head_on: specular.reflectance(1.0),
        }
    }

    /// The table of albedos.
    pub(crate) fn table(&self) -> MicroalbedoId {
        self.table
    }

    /// The factor on single scattering, at least 1, seen at `cos` in [0, 1].
    pub(super) fn gain(&self, tables: &ShadingTables, cos: f32) -> Rgb {
        let albedo = tables.microalbedo(self.table).albedo(self.row, cos);
        Rgb::ONE + self.head_on * ((1.0 - albedo) / albedo)
    }
}
