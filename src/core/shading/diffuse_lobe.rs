//! The part of a model whose directions are spread by the cosine.

use crate::math::{Real, real_struct};

real_struct! {
    /// The numbers `u_lobe` for which [`Bsdf::sample`](super::Bsdf::sample) takes a direction with the density of the
    /// cosine with the normal: those from `start` on, up to `start + share`, from 0 to 1.
    pub struct DiffuseLobe<R> {
        /// The first number.
        pub start: R,
        /// The probability of the lobe.
        pub share: R,
    }
}

impl<R: Real> DiffuseLobe<R> {
    /// No such part.
    pub const NONE: Self = Self {
        start: R::ONE,
        share: R::ZERO,
    };
    /// All of a model.
    pub const ALL: Self = Self {
        start: R::ZERO,
        share: R::ONE,
    };

    /// The part below a coat that is sampled with the probability `coat`, seen from `wo`: none from behind.
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
