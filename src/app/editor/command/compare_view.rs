//! The ways of comparing the picture with a snapshot.

/// The way in which picture and snapshot share the viewport.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum CompareView {
    /// The picture alone.
    #[default]
    Off,
    /// The snapshot left of this fraction of the width, the picture right of it.
    Wipe(f32),
    /// The picture as sampled left of this fraction of the width, denoised right of it. It needs no snapshot, but a denoised picture.
    Noisy(f32),
    /// The difference of each component.
    Difference,
}
