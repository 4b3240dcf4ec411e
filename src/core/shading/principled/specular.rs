//! Reflection and refraction by microfacets, for the main specular lobes (Burley 2012; Walter et al., Microfacet Models
//! for Refraction through Rough Surfaces, EGSR 2007).

use crate::math::{Real, Vector};
use crate::shading::{Ggx, LEAST_HALF_VECTOR};

/// The least width of a lobe.
const LEAST_ALPHA: f32 = 1e-3;

/// The microfacets of a surface of `roughness` (the square of which is perceptually even), stretched along the first
/// tangent by `anisotropic`, in [0, 1].
#[inline(always)]
pub(super) fn microfacets<R: Real>(roughness: R, anisotropic: R) -> Ggx<R> {
    let aspect = (R::ONE - R::splat(0.9) * anisotropic).sqrt();
    let (alpha, least) = (roughness * roughness, R::splat(LEAST_ALPHA));
    Ggx::new((alpha / aspect).max(least), (alpha * aspect).max(least))
}

/// The facet between two directions. Its value f |cos wi| is `pdf` x `unmasked` times its reflectance or transmittance
/// (refracted radiance: over the squared relative index).
#[derive(Clone, Copy)]
pub(super) struct Facet<R: Real> {
    /// Unit normal, z > 0.
    pub normal: R::Vec3,
    /// Cosine between `wo` and it, above 0.
    pub cos: R,
    /// Solid angle density of `wi` if normals are sampled as visible from `wo`.
    pub pdf: R,
    /// The fraction of its light that no other facet blocks, in [0, 1].
    pub unmasked: R,
    /// Whether there is such a facet.
    pub is_there: R::Mask,
}

/// The facet that reflects `wi` to `wo`, both above the surface. None where rounding puts it edge-on.
#[inline(always)]
pub(super) fn reflecting<R: Real>(distribution: &Ggx<R>, wo: R::Vec3, wi: R::Vec3) -> Facet<R> {
    let half = wo + wi;
    let length_squared = half.length_squared();
    let normal = half * (R::ONE / length_squared.sqrt());
    let cos = wo.dot(normal);
    Facet {
        normal,
        cos,
        pdf: distribution.density(normal) * distribution.g1_over_four_cos(wo),
        unmasked: distribution.g1(wi),
        is_there: length_squared.is_more(R::splat(LEAST_HALF_VECTOR)) & cos.is_more(R::ZERO),
    }
}

/// The facet that refracts `wi`, below the surface where the index is `eta` times that above, to `wo` above it. None if
/// no facet can.
#[inline(always)]
pub(super) fn refracting<R: Real>(distribution: &Ggx<R>, eta: R, wo: R::Vec3, wi: R::Vec3) -> Facet<R> {
    let half = wo + wi * eta;
    let length_squared = half.length_squared();
    let normal = half * (R::ONE / length_squared.sqrt()).copy_sign(half.z());
    let (cos, cos_i) = (wo.dot(normal), wi.dot(normal));
    let visible = R::splat(4.0) * distribution.density(normal) * distribution.g1_over_four_cos(wo) * cos;
    let is_connected = cos.is_more(R::ZERO) & cos_i.is_less(R::ZERO);
    Facet {
        normal,
        cos,
        pdf: visible * (eta / (cos + eta * cos_i)).squared() * -cos_i,
        unmasked: distribution.g1(wi),
        is_there: length_squared.is_more(R::splat(LEAST_HALF_VECTOR)) & is_connected,
    }
}
