//! The obstacles of shadow rays. Shapes that light may pass straight through are called clear.

/// The obstacle on a ray.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Obstacle {
    /// Nothing.
    Nothing,
    /// Only clear shapes, as far as the search went.
    Clear,
    /// A shape that is not clear.
    Opaque,
}

/// The obstacles on sixteen rays, a bit each. A ray that meets an opaque shape may or may not have its bit set in
/// `clear`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Obstacles {
    /// The rays that meet a shape that is not clear.
    pub opaque: u32,
    /// The rays that meet a shape that is called clear.
    pub clear: u32,
}

impl Obstacles {
    /// Records that the rays of `lanes`, a bit each, meet a shape.
    #[inline(always)]
    pub(super) fn add(&mut self, lanes: u32, is_clear: bool) {
        match is_clear {
            true => self.clear |= lanes,
            false => self.opaque |= lanes,
        }
    }

    /// Records the obstacle on the ray of one lane.
    #[inline(always)]
    pub(super) fn add_lane(&mut self, lane: usize, obstacle: Obstacle) {
        self.opaque |= u32::from(obstacle == Obstacle::Opaque) << lane;
        self.clear |= u32::from(obstacle == Obstacle::Clear) << lane;
    }

    /// The rays that meet clear shapes alone.
    pub fn only_clear(self) -> u32 {
        self.clear & !self.opaque
    }
}

impl Obstacle {
    #[inline(always)]
    pub(super) fn of(is_clear: bool) -> Self {
        match is_clear {
            true => Self::Clear,
            false => Self::Opaque,
        }
    }
}
