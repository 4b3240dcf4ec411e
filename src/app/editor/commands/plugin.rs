//! The resources of commands, and the systems that no other room has to be ordered with.

use bevy::prelude::*;

use super::flight::Flights;
use super::{baking, scene_watch};
use crate::app::editor::command::baking::BakePlan;
use crate::app::editor::command::light_mix::{FilmLights, LightMix};
use crate::app::editor::command::light_paint::LightPainting;
use crate::app::editor::command::selection::Selection;
use crate::engine::EngineSystems;
use crate::scene::SceneSystems;

pub(crate) struct CommandsPlugin {
    /// Whether the camera flies to where a command puts it.
    pub flies: bool,
}

impl Plugin for CommandsPlugin {
    fn build(&self, app: &mut App) {
        app.init_resource::<BakePlan>()
            .init_resource::<FilmLights>()
            .init_resource::<LightMix>()
            .init_resource::<LightPainting>()
            .init_resource::<Selection>()
            .insert_resource(Flights::new(self.flies))
            .add_systems(PreUpdate, scene_watch::hold_reloads.before(SceneSystems::Apply))
            .add_systems(PostUpdate, baking::follow.after(EngineSystems::Report));
    }
}
