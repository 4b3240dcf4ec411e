//! The resources of the picture, and the systems that no other room has to be ordered with.

use bevy::prelude::*;

use super::baking::Baking;
use super::carrying::Carrying;
use super::compare::Comparison;
use super::denoiser::Denoiser;
use super::frame_times::{self, FrameTimes};
use super::lamp_light::LampFollower;
use super::light_search::{LampPlacing, StrokeLux};
use super::metering::Metering;
use super::motion::Motion;
use super::noise_trend::NoiseTrend;
use super::outline_pass::OutlinePass;
use super::pacing::{self, Pacing};
use super::paths::PathInspector;
use super::reasons::Reasons;
use super::resolution::PicturePlace;
use super::texture;

pub(crate) struct PicturePlugin {
    /// Whether motion lowers the resolution and old pictures are carried over, as for a user.
    pub is_live: bool,
    /// Whether the window is not drawn.
    pub undrawn: bool,
}

impl Plugin for PicturePlugin {
    fn build(&self, app: &mut App) {
        app.init_resource::<Baking>()
            .init_resource::<Comparison>()
            .init_resource::<FrameTimes>()
            .init_resource::<Metering>()
            .init_resource::<NoiseTrend>()
            .init_resource::<LampFollower>()
            .init_resource::<LampPlacing>()
            .init_resource::<StrokeLux>()
            .init_resource::<OutlinePass>()
            .init_resource::<PathInspector>()
            .init_resource::<PicturePlace>()
            .init_resource::<Reasons>()
            .insert_resource(Carrying::new(self.is_live))
            .insert_resource(Denoiser::new())
            .insert_resource(Motion::new(self.is_live))
            .insert_resource(Pacing::new(self.undrawn))
            .add_systems(Startup, (texture::create_picture, pacing::connect_wake_up));
        frame_times::time_drawing(app);
    }
}
