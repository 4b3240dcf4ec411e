//! Lambert's ideally diffuse reflection; black from behind.

use super::{BsdfSample, DiffuseLobe, Model, ShadingTables, TransportMode};
use crate::math::{Mask, Real, Vector, real_struct};
use crate::sampling::warp;

real_struct! {
    /// A surface that looks equally bright from everywhere above it.
    pub struct Diffuse<R> {
        /// Reflected fraction of the power, [0, 1].
        pub reflectance: R::Vec3,
    }
}

impl<R: Real> Model<R> for Diffuse<R> {
    const IS_SHORT: bool = true;

    #[inline(always)]
    fn eval_and_pdf(&self, _: &ShadingTables, wo: R::Vec3, wi: R::Vec3, _: TransportMode) -> (R::Vec3, R) {
        let pdf = warp::cosine_hemisphere_pdf(wi.z()).only(wo.z().is_more(R::ZERO));
        (self.reflectance * pdf, pdf)
    }

    #[inline(always)]
    fn sample(&self, _: &ShadingTables, wo: R::Vec3, _: R, u: [R; 2], _: TransportMode) -> BsdfSample<R> {
        let wi = warp::cosine_hemisphere(u);
        let pdf = warp::cosine_hemisphere_pdf(wi.z()).only(wo.z().is_more(R::ZERO));
        BsdfSample {
            wi,
            weight: self.reflectance,
            pdf,
            is_delta: R::Mask::NEVER,
            eta: R::ONE,
            is_returned: pdf.is_more(R::ZERO),
        }
    }

    #[inline(always)]
    fn diffuse_lobe(&self, _: &ShadingTables, _: R::Vec3) -> DiffuseLobe<R> {
        DiffuseLobe::ALL
    }
}
