//! The lobe of a model whose directions follow the cosine with the normal.

use crate::math::{Real, real_struct};

real_struct! {
    /// The range of `u_lobe` in which [`Bsdf::sample`](super::Bsdf::sample) samples a direction by the cosine with the
    /// normal: from `start` to `start + share`, within [0, 1].
    pub struct DiffuseLobe<R> {
        /// The start of the range.
        pub start: R,
        /// The probability of the lobe.
        pub share: R,
    }
}

impl<R: Real> DiffuseLobe<R> {
    /// No diffuse lobe.
    pub const NONE: Self = Self {
        start: R::ONE,
        share: R::ZERO,
    };
    /// The whole model is the lobe.
    pub const ALL: Self = Self {
        start: R::ZERO,
        share: R::ONE,
    };

    /// The base below a coat that is sampled with the probability `coat`; empty where the base is not seen.
    #[inline(always)]
    pub(super) fn below(coat: R, is_seen: R::Mask) -> Self {
        Self {
            start: R::select(is_seen, coat, R::ONE),
            share: (R::ONE - coat).only(is_seen),
        }
    }

    /// This lobe where `condition` holds, else `other`.
    #[inline(always)]
    pub(super) fn or(self, condition: R::Mask, other: Self) -> Self {
        Self {
            start: R::select(condition, self.start, other.start),
            share: R::select(condition, self.share, other.share),
        }
    }
}
