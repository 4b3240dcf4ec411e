//! What lights the scene of a file: whether something has to stand in for light depends on that.

use crate::document::Object;

/// The light of a surface.
#[derive(Clone)]
pub(super) struct Glow {
    /// The area emitter.
    pub emitter: Object,
    /// The luminance of its radiance, on average over the picture of it.
    pub mean: f32,
}

/// The light of all surfaces together, as the mean of their radiance, below which they do not light the scene: the
/// picture would be nearly black then. What stands in for light has about 1.
const LEAST_LIGHT: f32 = 0.03;

/// What lights the scene so far.
#[derive(Default)]
pub(super) struct Lighting {
    /// Whether there is a light that is no surface, and not black.
    pub has_lights: bool,
    /// The area of all surfaces.
    area: f64,
    /// The mean radiance of each surface, times its area.
    radiance: f64,
}

impl Lighting {
    /// Notes a surface of this area.
    pub fn note_surface(&mut self, area: f32, glow: Option<&Glow>) {
        self.area += f64::from(area);
        self.radiance += f64::from(area) * glow.map_or(0.0, |glow| f64::from(glow.mean));
    }

    /// Whether the scene is lit.
    pub fn is_enough(&self) -> bool {
        self.has_lights || self.radiance > f64::from(LEAST_LIGHT) * self.area
    }
}
