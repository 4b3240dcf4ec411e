//! The part of a model whose directions are spread by the cosine.

/// The numbers `u_lobe` for which [`Bsdf::sample`](super::Bsdf::sample) takes a direction with the density of the cosine with the normal: those from `start` on, up to
/// `start + share`, from 0 to 1.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DiffuseLobe {
    /// The first number.
    pub start: f32,
    /// The probability of the lobe.
    pub share: f32,
}

impl DiffuseLobe {
    /// No such part.
    pub const NONE: Self = Self { start: 1.0, share: 0.0 };
    /// All of a model.
    pub const ALL: Self = Self { start: 0.0, share: 1.0 };

    /// The part below a coat that is sampled with the probability `coat`.
    pub(super) fn below(coat: f32) -> Self {
        Self {
            start: coat,
            share: 1.0 - coat,
        }
    }
}
