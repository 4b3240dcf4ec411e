//! The lamps of a job's picture and the layers of their light.

use std::sync::Arc;

use crate::color::Rgb;
use crate::engine::light_groups::{Lamps, LightGroup};
use crate::light::WeightedSource;
use crate::memory::Reservation;
use crate::render::film::SetAside;
use crate::render::scene::RenderScene;
use crate::render::view::View;

/// The largest factor by which a layer's light may have become stronger for some of its samples, and by which the layer
/// may have fewer samples than the picture: a weak lamp gets few samples, whose noise the factor amplifies.
pub(super) const MOST_RISE: f32 = 4.0;

/// The most layers of light that are kept for lamps that are off.
pub(super) const MOST_ASIDE: usize = 4;

/// The strength of a layer's light relative to the beginning, and the least so far.
#[derive(Clone, Copy, Debug)]
pub(super) struct Strength {
    pub now: Rgb,
    pub least: Rgb,
    /// The samples per pixel that the layer's light lacks, because the lamp was off meanwhile.
    pub missed: u32,
}

impl Strength {
    pub const UNCHANGED: Self = Self {
        now: Rgb::ONE,
        least: Rgb::ONE,
        missed: 0,
    };

    pub fn changed(self, factor: Rgb) -> Self {
        let now = self.now * factor;
        let least = self.least.min(now);
        Self { now, least, ..self }
    }

    pub fn is_near_enough(self) -> bool {
        self.now.cmple(MOST_RISE * self.least).all()
    }
}

/// The kept light of lamps that are off.
pub(super) struct Aside {
    pub sources: Vec<WeightedSource>,
    pub strength: Strength,
    pub light: SetAside,
    pub _memory: Reservation,
}

/// The changes of a job's lamps since it began.
#[derive(Default)]
pub(super) struct Relighting {
    /// The strengths by layer of light; empty before the first change.
    pub strengths: Vec<Strength>,
    /// Kept layers, the latest last.
    pub aside: Vec<Aside>,
}

/// The scene, view and lamps that a picture should show.
pub struct Wanted<'a> {
    pub scene: &'a RenderScene,
    pub view: &'a View,
    /// The lights of the scene, and those of each group of the view.
    pub lamps: &'a Arc<Lamps>,
    pub light_groups: &'a Arc<[LightGroup]>,
}
