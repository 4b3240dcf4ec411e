//! The comparisons of the picture with a snapshot.

/// The comparison of picture and snapshot in the viewport.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum CompareView {
    /// The picture alone.
    #[default]
    Off,
    /// The snapshot left of this fraction of the width, the picture right of it.
    Wipe(f32),
    /// The picture as sampled left of this fraction of the width, denoised right of it. It needs no snapshot, but a
    /// denoised picture.
    Noisy(f32),
    /// The level lit by the lightmaps of the bake left of this fraction of the width, the picture right of it. It needs
    /// a bake.
    Baked(f32),
    /// The difference of each component.
    Difference,
}

impl CompareView {
    /// The border between both parts, as a fraction of the width; None without one.
    pub fn border(self) -> Option<f32> {
        match self {
            Self::Wipe(at) | Self::Noisy(at) | Self::Baked(at) => Some(at),
            Self::Off | Self::Difference => None,
        }
    }

    /// The same with the border at this fraction of the width, if it has one.
    pub fn with_border(self, at: f32) -> Self {
        match self {
            Self::Wipe(_) => Self::Wipe(at),
            Self::Noisy(_) => Self::Noisy(at),
            Self::Baked(_) => Self::Baked(at),
            Self::Off | Self::Difference => self,
        }
    }
}
