//! Tables of the single-scattering albedo of rough surfaces made of perfect mirrors.

use std::sync::LazyLock;

use glam::Vec3;

use super::{Microfacet, MicrofacetKind};
use crate::math::{Real, Word, gauss_legendre};

/// Nodes over the root of alpha in [0, 1], and over the root of the cosine: the albedo is steep where both are small.
const ALPHAS: usize = 24;
const COSINES: usize = 32;
const QUADRATURE: u32 = 32;

/// The nodes of a table.
pub(super) const NODES: usize = ALPHAS * COSINES;

/// The single-scattering albedo of isotropic white microfacets, by roughness up to 1 and cosine.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Microalbedo {
    albedos: [[f32; COSINES]; ALPHAS],
}

/// The table of a distribution, computed at the first call (a tenth of a second) and kept.
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
        let nodes = gauss_legendre(QUADRATURE);
        let node = |i: usize, count: usize| (i as f32 / (count - 1) as f32).powi(2);
        Self {
            albedos: std::array::from_fn(|row| {
                let alpha = node(row, ALPHAS);
                let facets = Microfacet::new(kind, alpha, alpha);
                std::array::from_fn(|column| white_albedo(&facets, node(column, COSINES).max(1e-6), &nodes))
            }),
        }
    }

    /// The albedo at an index into the table's rows, which are stored one after the other.
    pub fn node(&self, place: usize) -> f32 {
        self.albedos[place / COSINES][place % COSINES]
    }
}

/// The albedo at the row position `row` of [`row_of`] and the cosine `cos` in [0, 1], bilinear between the nodes, which
/// `node` returns as [`Microalbedo::node`] does.
#[inline(always)]
pub(super) fn albedo<R: Real>(row: R, cos: R, node: impl Fn(R::Word) -> R) -> R {
    let (i, u) = node_before(row, ALPHAS);
    let (j, v) = node_before(place(cos, COSINES), COSINES);
    let first = i * R::Word::splat(COSINES as u32) + j;
    let at = |offset: usize| node(first + R::Word::splat(offset as u32));
    let (low, high) = (at(0).mix(at(1), v), at(COSINES).mix(at(COSINES + 1), v));
    low.mix(high, u)
}

/// The node before a position among `count` nodes, and the weight of the next one.
#[inline(always)]
pub(super) fn node_before<R: Real>(place: R, count: usize) -> (R::Word, R) {
    let first = place.floor().min(R::splat((count - 2) as f32));
    (first.whole(), place - first)
}

/// The position of a roughness among the rows of every table, clamped at a roughness of 1.
pub(super) fn row_of(alpha: f32) -> f32 {
    place(alpha, ALPHAS)
}

/// The position among `count` nodes of a number clamped to [0, 1].
#[inline(always)]
fn place<R: Real>(x: R, count: usize) -> R {
    x.saturated().sqrt() * R::splat((count - 1) as f32)
}

/// The albedo by quadrature over visible normals, each weighted by the visibility of the light that it reflects.
fn white_albedo(facets: &Microfacet, cos: f32, nodes: &[(f32, f32)]) -> f32 {
    let wo = Vec3::new((1.0 - cos * cos).sqrt(), 0.0, cos);
    let mut albedo = 0.0;
    for &(x, weight_x) in nodes {
        for &(y, weight_y) in nodes {
            let m = facets.sample_visible(wo, [x, y]);
            let wi = 2.0 * wo.dot(m) * m - wo;
            if wi.z > 0.0 {
                albedo += weight_x * weight_y * facets.g1(wi);
            }
        }
    }
    albedo * facets.masking_ratio(wo)
}
