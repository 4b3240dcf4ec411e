//! Reflection and refraction by microfacets, for the main specular lobes (Burley 2012; Walter et al., Microfacet Models for Refraction through
//! Rough Surfaces, EGSR 2007).

use glam::Vec3;

use crate::shading::Ggx;

/// The least width of a lobe.
const LEAST_ALPHA: f32 = 1e-3;

/// The microfacets of a surface of `roughness` (its square looks even), stretched along the first tangent by `anisotropic`, in [0, 1].
pub(super) fn microfacets(roughness: f32, anisotropic: f32) -> Ggx {
    let aspect = (1.0 - 0.9 * anisotropic).sqrt();
    let alpha = roughness * roughness;
    Ggx::new((alpha / aspect).max(LEAST_ALPHA), (alpha * aspect).max(LEAST_ALPHA))
}

/// A facet that takes light from `wi` to `wo`. Of the light that it reflects or refracts, f |cos wi| is `pdf` x `unmasked` (refracted
/// radiance: over the squared relative index).
#[derive(Clone, Copy)]
pub(super) struct Facet {
    /// Unit normal, z > 0.
    pub normal: Vec3,
    /// Cosine between `wo` and it, above 0.
    pub cos: f32,
    /// Solid angle density of `wi` if normals are sampled as visible from `wo`.
    pub pdf: f32,
    /// The part of its light that no other facet blocks, in [0, 1].
    pub unmasked: f32,
}

/// The facet that reflects `wi` to `wo`, both above the surface. `None` where rounding lets it face neither.
pub(super) fn reflecting(distribution: &Ggx, wo: Vec3, wi: Vec3) -> Option<Facet> {
    let normal = (wo + wi).try_normalize()?;
    let cos = wo.dot(normal);
    (cos > 0.0).then(|| Facet {
        normal,
        cos,
        pdf: distribution.density(normal) * distribution.g1_over_four_cos(wo),
        unmasked: distribution.g1(wi),
    })
}

/// The facet that refracts `wi`, below the surface where the index is `eta` times that above, to `wo` above it. `None` if none can.
pub(super) fn refracting(distribution: &Ggx, eta: f32, wo: Vec3, wi: Vec3) -> Option<Facet> {
    let half = wo + eta * wi;
    let normal = half.try_normalize()? * half.z.signum();
    let (cos_o, cos_i) = (wo.dot(normal), wi.dot(normal));
    if cos_o <= 0.0 || cos_i >= 0.0 {
        return None;
    }
    let visible = 4.0 * distribution.density(normal) * distribution.g1_over_four_cos(wo) * cos_o;
    Some(Facet {
        normal,
        cos: cos_o,
        pdf: visible * (eta / (cos_o + eta * cos_i)).powi(2) * -cos_i,
        unmasked: distribution.g1(wi),
    })
}
