//! What a job knows of the lamps of its picture.

use std::sync::Arc;

use crate::color::Rgb;
use crate::engine::light_groups::{Lamps, LightGroup};
use crate::light::WeightedSource;
use crate::memory::Reservation;
use crate::render::film::SetAside;
use crate::render::scene::RenderScene;
use crate::render::view::View;

/// The light of a layer may be so many times as strong as it was for some of its samples, and may have so many times
/// fewer samples than there are: a weak lamp gets few samples, whose noise grows with it.
pub(super) const MOST_RISE: f32 = 4.0;

/// The most layers of light that are set aside.
pub(super) const MOST_ASIDE: usize = 4;

/// How many times as strong the light of a layer is as at the beginning, and the least that it was.
#[derive(Clone, Copy, Debug)]
pub(super) struct Strength {
    pub now: Rgb,
    pub least: Rgb,
    /// The samples of a pixel that the light of the layer is not of, because it was set aside meanwhile.
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

/// The light of lamps that do not shine.
pub(super) struct Aside {
    pub sources: Vec<WeightedSource>,
    pub strength: Strength,
    pub light: SetAside,
    pub _memory: Reservation,
}

/// What has become of the lamps of a job since it began.
#[derive(Default)]
pub(super) struct Relighting {
    /// By layer of light; empty while all is as it was.
    pub strengths: Vec<Strength>,
    /// The latest is the last.
    pub aside: Vec<Aside>,
}

/// What a picture is to be of.
pub struct Wanted<'a> {
    pub scene: &'a RenderScene,
    pub view: &'a View,
    /// The lights of the scene, and those of each group of the view.
    pub lamps: &'a Arc<Lamps>,
    pub light_groups: &'a Arc<[LightGroup]>,
}
