//! Decides whether the scene of a file has enough light, or needs a stand-in light.

use crate::document::Object;

/// The emission of a surface.
#[derive(Clone)]
pub(super) struct Glow {
    /// The area emitter.
    pub emitter: Object,
    /// The mean luminance of its radiance over the texture.
    pub mean: f32,
}

/// The mean radiance of all surfaces below which their emission does not light the scene: the picture would be nearly
/// black. The stand-in light has a radiance of about 1.
const LEAST_LIGHT: f32 = 0.03;

/// The sum of the light of the scene so far.
#[derive(Default)]
pub(super) struct Lighting {
    /// Whether there is a light that is no surface, and not black.
    pub has_lights: bool,
    /// The area of all surfaces.
    area: f64,
    /// The sum over the surfaces of mean radiance times area.
    radiance: f64,
}

impl Lighting {
    /// Adds a surface of this area.
    pub fn note_surface(&mut self, area: f32, glow: Option<&Glow>) {
        self.area += f64::from(area);
        self.radiance += f64::from(area) * glow.map_or(0.0, |glow| f64::from(glow.mean));
    }

    /// Whether there is enough light.
    pub fn is_enough(&self) -> bool {
        self.has_lights || self.radiance > f64::from(LEAST_LIGHT) * self.area
    }
}
