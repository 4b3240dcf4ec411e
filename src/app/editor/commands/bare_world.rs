//! A world in which commands can be applied without a window, for tests and fuzzing.

use bevy::ecs::message::Messages;
use bevy::prelude::World;

use crate::app::editor::command::light_mix::{FilmLights, LightMix};
use crate::app::editor::command::selection::Selection;
use crate::app::editor::model::EditorModel;
use crate::app::editor::picture::frame_times::FrameTimes;
use crate::app::editor::picture::pacing::Pacing;
use crate::app::editor::session::history::History;
use crate::app::editor::session::requests::{CommandQueue, Requests};
use crate::app::editor::session::toasts::Toasts;
use crate::app::editor::session::view_settings::ViewSettings;
use crate::engine::{PackedScene, RenderControl, RenderFilm};
use crate::scene::write::KnownTexts;
use crate::scene::{ActiveSensor, FreeView, OpenScene, SceneFile, SceneStatus, Trust};

/// A world without a scene that has the resources of edits, and nothing that draws.
pub fn bare_world() -> World {
    let mut world = World::new();
    world.init_resource::<ViewSettings>();
    world.init_resource::<Requests>();
    world.init_resource::<Toasts>();
    world.init_resource::<CommandQueue>();
    world.init_resource::<FrameTimes>();
    world.init_resource::<Pacing>();
    world.init_resource::<RenderControl>();
    world.init_resource::<RenderFilm>();
    world.init_resource::<PackedScene>();
    world.init_resource::<ActiveSensor>();
    world.init_resource::<FreeView>();
    world.init_resource::<EditorModel>();
    world.init_resource::<Selection>();
    world.init_resource::<History>();
    world.init_resource::<SceneStatus>();
    world.init_resource::<SceneFile>();
    world.init_resource::<KnownTexts>();
    world.init_resource::<Trust>();
    world.init_resource::<Messages<OpenScene>>();
    world.init_resource::<LightMix>();
    world.init_resource::<FilmLights>();
    world
}
