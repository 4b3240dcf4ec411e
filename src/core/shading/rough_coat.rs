//! Tables of the light that a rough dielectric coat transmits from outside, and of the diffuse light below it that it
//! reflects back inside.
//!
//! They are computed by quadrature over visible normals: light that a facet transmits or reflects counts if it is on
//! the right side of the surface and not masked. One table serves all surfaces with the same distribution, index and
//! roughness, or with any roughness up to 1. It takes some ten milliseconds to compute and 260 bytes per roughness.

use super::fresnel::{self, DielectricModel};
use super::microalbedo::node_before;
use super::{Microfacet, MicrofacetKind};
use crate::math::{Real, Word, gauss_legendre};
use glam::Vec3;
use std::collections::HashMap;
use std::sync::{Arc, LazyLock, Mutex, PoisonError};

/// The number of nodes over the cosine, as in the renderer whose scene format this program reads: the interpolation
/// between the first two is visible in images.
const COSINES: usize = 64;

/// Nodes over the root of the roughness, where it varies.
const ALPHAS: usize = 32;

/// Gauss nodes along each of the two numbers that sample a normal. The integrand with total internal reflection has
/// kinks.
const NODES: u32 = 32;
const NODES_WITH_KINKS: u32 = 48;

/// A coat at one roughness.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct CoatLayer {
    /// The transmitted fraction by the cosine outside.
    transmittance: [f32; COSINES],
    /// The fraction of diffuse light from below that is reflected.
    internal_reflectance: f32,
}

/// The key of a coat: the distribution, and the bits of the index of refraction and of the roughness, which is None
/// where it varies.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) struct CoatKey {
    pub kind: MicrofacetKind,
    eta: u32,
    alpha: Option<u32>,
}

impl CoatKey {
    pub fn new(kind: MicrofacetKind, eta: f32, alpha: Option<f32>) -> Self {
        Self {
            kind,
            eta: eta.to_bits(),
            alpha: alpha.map(f32::to_bits),
        }
    }

    /// The refractive index of the coat relative to the outside.
    pub fn eta(&self) -> f32 {
        f32::from_bits(self.eta)
    }
}

/// The layers of a coat: one, or [`ALPHAS`] with roughness in equal steps of its root from 0 to 1. They are computed
/// once and kept for later scenes.
pub(super) fn layers(key: CoatKey) -> Arc<[CoatLayer]> {
    static COMPUTED: LazyLock<Mutex<HashMap<CoatKey, Arc<[CoatLayer]>>>> = LazyLock::new(Mutex::default);
    // A thread that panics while it holds the lock leaves no incomplete entry.
    let mut computed = COMPUTED.lock().unwrap_or_else(PoisonError::into_inner);
    let compute = || match key.alpha {
        Some(alpha) => Arc::from([CoatLayer::new(key.kind, key.eta(), f32::from_bits(alpha))]),
        None => {
            let alpha = |i: usize| (i as f32 / (ALPHAS - 1) as f32).powi(2);
            (0..ALPHAS)
                .map(|i| CoatLayer::new(key.kind, key.eta(), alpha(i)))
                .collect()
        }
    };
    computed.entry(key).or_insert_with(compute).clone()
}

/// A coat at the roughness of a surface point.
#[derive(Clone, Copy)]
pub(super) struct CoatThere<'a, R: Real> {
    /// Whether the distribution of the coat's microfacet normals is Beckmann's.
    pub is_beckmann: R::Mask,
    /// The refractive index of the coat relative to the outside.
    pub eta: R,
    /// All layers of the scene, and the indices of the coat's layers below and above the roughness.
    pub layers: &'a [CoatLayer],
    pub low: R::Word,
    pub high: R::Word,
    /// The weight of `high` against `low`, in [0, 1].
    pub between: R,
}

impl<R: Real> CoatThere<'_, R> {
    /// The layer `number`; lanes that are not in use may have any number.
    #[inline(always)]
    fn layer(&self, number: usize) -> &CoatLayer {
        &self.layers[number.min(self.layers.len() - 1)]
    }

    /// The transmitted fraction at the cosine `cos` in [0, 1], into the coat or, by reciprocity, out.
    #[inline(always)]
    pub fn transmittance(&self, cos: R) -> R {
        let (i, share) = node_before(cos.saturated() * R::splat((COSINES - 1) as f32), COSINES);
        let node = |layer: R::Word, i: R::Word| {
            let place = layer * R::Word::splat(COSINES as u32) + i;
            R::gather(place, |place| {
                self.layer(place / COSINES).transmittance[place % COSINES]
            })
        };
        let in_layer = |layer: R::Word| node(layer, i).mix(node(layer, i + R::Word::splat(1)), share);
        in_layer(self.low).mix(in_layer(self.high), self.between)
    }

    /// The fraction of diffuse light from below that is reflected.
    #[inline(always)]
    pub fn internal_reflectance(&self) -> R {
        let in_layer = |layer: R::Word| R::gather(layer, |layer| self.layer(layer).internal_reflectance);
        in_layer(self.low).mix(in_layer(self.high), self.between)
    }
}

impl CoatLayer {
    fn new(kind: MicrofacetKind, eta: f32, alpha: f32) -> Self {
        let facets = Microfacet::new(kind, alpha, alpha);
        let nodes = |eta: f32| gauss_legendre(if eta > 1.0 { NODES } else { NODES_WITH_KINKS });
        let cosine = |i: usize| (i as f32 / (COSINES - 1) as f32).max(1e-6);
        let (outside, inside) = (nodes(eta), nodes(eta.recip()));
        // The plain mean over the nodes, with full weight at the ends: 1.5 % less than the integral for glass, as in
        // the images to be matched.
        let reflected: f32 = (0..COSINES)
            .map(|i| cosine(i) * split(&facets, cosine(i), eta.recip(), &inside).reflected)
            .sum();
        Self {
            transmittance: std::array::from_fn(|i| split(&facets, cosine(i), eta, &outside).transmitted),
            internal_reflectance: 2.0 * reflected / COSINES as f32,
        }
    }
}

/// The split of light at a rough interface; the rest would meet other facets.
struct Split {
    reflected: f32,
    transmitted: f32,
}

/// The split at the cosine `cos`, where `eta` is the index behind the interface over that in front.
fn split(facets: &Microfacet, cos: f32, eta: f32, nodes: &[(f32, f32)]) -> Split {
    let wo = Vec3::new((1.0 - cos * cos).sqrt(), 0.0, cos);
    let mut split = Split {
        reflected: 0.0,
        transmitted: 0.0,
    };
    for &(x, weight_x) in nodes {
        for &(y, weight_y) in nodes {
            let m = facets.sample_visible(wo, [x, y]);
            let cos_m = wo.dot(m).max(0.0);
            let fresnel = fresnel::dielectric(cos_m, eta, DielectricModel::Exact);
            let mirrored = 2.0 * cos_m * m - wo;
            if mirrored.z > 0.0 {
                split.reflected += weight_x * weight_y * fresnel.reflectance * facets.g1(mirrored);
            }
            let refracted = (fresnel.eta_ti * cos_m + fresnel.cos_t) * m - fresnel.eta_ti * wo;
            if refracted.z < 0.0 {
                split.transmitted += weight_x * weight_y * (1.0 - fresnel.reflectance) * facets.g1(refracted);
            }
        }
    }
    split
}
