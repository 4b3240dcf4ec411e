//! The albedo of a rough surface of perfect mirrors in one bounce, and the factor by which all bounces make it brighter.
//!
//! Albedo scaling: Turquin, Practical multiple scattering compensation for microfacet models, 2019. With the albedo E(wo) of the white
//! surface and the reflectance F0 at normal incidence, the lobe grows by 1 + F0 (1 - E) / E: exact for a white metal, and a coloured
//! one saturates. The loss of reciprocity does not matter to paths that start at the camera.

use super::{Microfacet, MicrofacetKind};
use crate::color::Rgb;
use crate::math::gauss_legendre;
use glam::{Vec2, Vec3};
use std::sync::LazyLock;

/// Nodes over the root of alpha in [0, 1], and over the root of the cosine: the albedo is steep where both are small.
const ALPHAS: usize = 24;
const COSINES: usize = 32;
const NODES: u32 = 32;

/// The single-scattering albedo of isotropic white microfacets, by roughness up to 1 and cosine.
#[derive(Debug, PartialEq)]
pub struct Microalbedo {
    albedos: [[f32; COSINES]; ALPHAS],
}

impl Microalbedo {
    /// The table of one distribution, computed at the first call (a tenth of a second).
    pub fn of(kind: MicrofacetKind) -> &'static Self {
        static BECKMANN: LazyLock<Microalbedo> = LazyLock::new(|| Microalbedo::new(MicrofacetKind::Beckmann));
        static GGX: LazyLock<Microalbedo> = LazyLock::new(|| Microalbedo::new(MicrofacetKind::Ggx));
        match kind {
            MicrofacetKind::Beckmann => &BECKMANN,
            MicrofacetKind::Ggx => &GGX,
        }
    }

    fn new(kind: MicrofacetKind) -> Self {
        let nodes = gauss_legendre(NODES);
        let node = |i: usize, count: usize| (i as f32 / (count - 1) as f32).powi(2);
        Self {
            albedos: std::array::from_fn(|row| {
                let alpha = node(row, ALPHAS);
                let facets = Microfacet::new(kind, alpha, alpha);
                std::array::from_fn(|column| white_albedo(&facets, node(column, COSINES).max(1e-6), &nodes))
            }),
        }
    }

    /// The albedo seen at `cos` in [0, 1], bilinear between nodes; as for roughness 1 above that.
    fn albedo(&self, alpha: f32, cos: f32) -> f32 {
        let split = |x: f32, count: usize| {
            let x = x.clamp(0.0, 1.0).sqrt() * (count - 1) as f32;
            let i = (x as usize).min(count - 2);
            (i, x - i as f32)
        };
        let ((i, u), (j, v)) = (split(alpha, ALPHAS), split(cos, COSINES));
        let in_row = |row: &[f32; COSINES]| row[j] + v * (row[j + 1] - row[j]);
        let (low, high) = (in_row(&self.albedos[i]), in_row(&self.albedos[i + 1]));
        low + u * (high - low)
    }

    /// The factor on single scattering, at least 1, where a metal reflects `head_on` at normal incidence. Where roughness depends on the
    /// direction, one for its root mean square: some percent off.
    pub fn gain(&self, facets: &Microfacet, wo: Vec3, head_on: Rgb) -> Rgb {
        let albedo = self.albedo(facets.mean_alpha(), wo.z);
        Rgb::ONE + head_on * ((1.0 - albedo) / albedo)
    }
}

/// The albedo by quadrature over visible normals, each weighted with the visibility of what it reflects.
fn white_albedo(facets: &Microfacet, cos: f32, nodes: &[(f32, f32)]) -> f32 {
    let wo = Vec3::new((1.0 - cos * cos).sqrt(), 0.0, cos);
    let mut albedo = 0.0;
    for &(x, weight_x) in nodes {
        for &(y, weight_y) in nodes {
            let m = facets.sample_visible(wo, Vec2::new(x, y));
            let wi = 2.0 * wo.dot(m) * m - wo;
            if wi.z > 0.0 {
                albedo += weight_x * weight_y * facets.g1(wi);
            }
        }
    }
    albedo * facets.masking_ratio(wo)
}
