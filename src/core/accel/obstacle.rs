//! What is in the way of rays, where light may pass straight through some shapes, which are called clear.

/// What a ray meets.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Obstacle {
    /// Nothing.
    Nothing,
    /// Shapes that are called clear, and none other that has been found.
    Clear,
    /// A shape that is not clear.
    Opaque,
}

/// What rays meet, a bit for each lane. Of a ray that meets an opaque shape it is not known whether it meets clear
/// ones.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Obstacles {
    /// The rays that meet a shape that is not clear.
    pub opaque: u32,
    /// The rays that meet a shape that is called clear.
    pub clear: u32,
}

impl Obstacles {
    /// Notes that the rays of `lanes`, a bit each, meet a shape.
    #[inline(always)]
    pub(super) fn add(&mut self, lanes: u32, is_clear: bool) {
        match is_clear {
            true => self.clear |= lanes,
            false => self.opaque |= lanes,
        }
    }

    /// Notes what the ray of a lane meets.
    #[inline(always)]
    pub(super) fn add_lane(&mut self, lane: usize, obstacle: Obstacle) {
        self.opaque |= u32::from(obstacle == Obstacle::Opaque) << lane;
        self.clear |= u32::from(obstacle == Obstacle::Clear) << lane;
    }

    /// The rays that meet shapes of which all are clear.
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
