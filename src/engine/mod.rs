//! The engine: the only code that knows both the authored scene and the renderer. It notices what changed in the ECS, packs just
//! that into the renderer's tables, hands tiles to worker threads and gathers their results. It draws nothing and reads no input.

pub mod control;
pub mod status;

use bevy::prelude::*;

pub use control::{InputStamp, RenderControl, ViewMode, WakeUp};
pub use status::{BvhStatus, LatencyStats, RenderState, RenderStatus};

/// The steps of a frame, in this order, in `PostUpdate`.
#[derive(SystemSet, Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum EngineSystems {
    /// Which tables may be out of date.
    Detect,
    /// Packs these tables, and keeps the old one where nothing really differs.
    Extract,
    /// Cancels and starts jobs.
    Dispatch,
    /// Takes the results that have arrived.
    Collect,
}

/// Adds the engine's resources and systems.
pub struct EnginePlugin;

impl Plugin for EnginePlugin {
    fn build(&self, app: &mut App) {
        app.init_resource::<RenderControl>()
            .init_resource::<RenderStatus>()
            .init_resource::<InputStamp>()
            .init_resource::<WakeUp>()
            .configure_sets(
                PostUpdate,
                (
                    EngineSystems::Detect,
                    EngineSystems::Extract,
                    EngineSystems::Dispatch,
                    EngineSystems::Collect,
                )
                    .chain(),
            );
    }
}
