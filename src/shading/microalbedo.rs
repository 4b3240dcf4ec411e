//! Tables of the albedo of a rough surface of perfect mirrors in one bounce.

use super::{Microfacet, MicrofacetKind};
use crate::math::gauss_legendre;
use glam::{Vec2, Vec3};
use std::sync::LazyLock;

/// Nodes over the root of alpha in [0, 1], and over the root of the cosine: the albedo is steep where both are small.
const ALPHAS: usize = 24;
const COSINES: usize = 32;
const NODES: u32 = 32;

/// The single-scattering albedo of isotropic white microfacets, by roughness up to 1 and cosine.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Microalbedo {
    albedos: [[f32; COSINES]; ALPHAS],
}

/// The table of one distribution, computed at the first call (a tenth of a second) and kept.
pub(super) fn of(kind: MicrofacetKind) -> &'static Microalbedo {
    static BECKMANN: LazyLock<Microalbedo> = LazyLock::new(|| Microalbedo::new(MicrofacetKind::Beckmann));
    static GGX: LazyLock<Microalbedo> = LazyLock::new(|| Microalbedo::new(MicrofacetKind::Ggx));
    match kind {
        MicrofacetKind::Beckmann => &BECKMANN,
        MicrofacetKind::Ggx => &GGX,
    }
}

impl Microalbedo {
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

    /// The albedo at the place `row` of [`row_of`], seen at `cos` in [0, 1], bilinear between nodes.
    pub fn albedo(&self, row: f32, cos: f32) -> f32 {
        let split = |x: f32, count: usize| {
            let i = (x as usize).min(count - 2);
            (i, x - i as f32)
        };
        let ((i, u), (j, v)) = (split(row, ALPHAS), split(place(cos, COSINES), COSINES));
        let in_row = |row: &[f32; COSINES]| row[j] + v * (row[j + 1] - row[j]);
        let (low, high) = (in_row(&self.albedos[i]), in_row(&self.albedos[i + 1]));
        low + u * (high - low)
    }
}

/// The place of a roughness among the nodes of every table; as of 1 above that.
pub(super) fn row_of(alpha: f32) -> f32 {
    place(alpha, ALPHAS)
}

/// The place of a number in [0, 1] among `count` nodes, and of one outside as of the nearest inside.
fn place(x: f32, count: usize) -> f32 {
    x.clamp(0.0, 1.0).sqrt() * (count - 1) as f32
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
