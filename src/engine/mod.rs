//! The engine: the only code that knows both the authored scene and the renderer. It detects changes in the ECS, packs
//! them into the renderer's tables, hands tiles to worker threads and collects their results. It draws nothing and
//! reads no input.

mod adaptation;
mod attributes;
mod authored;
mod auto;
mod backend;
mod blas_cache;
pub mod blocking;
mod choosing;
mod clipping;
mod collect;
pub mod control;
mod deferred_drop;
mod detect;
mod dispatch;
mod event_loop_waker;
mod extract;
pub mod film;
mod instances;
mod job;
pub mod lamp_freedom;
mod layers;
mod light_groups;
mod light_measures;
mod pack;
pub mod packed_scene;
pub mod placing;
mod portals;
mod priority;
pub mod reasons;
mod renderer;
mod report;
mod resolution;
mod run;
mod saved;
mod scene_change;
mod schedule;
pub mod shutter;
mod sight;
pub mod status;
mod stop_condition;

use bevy::asset::AssetEventSystems;
use bevy::prelude::*;

pub use blocking::{
    Limits, Outcome, RenderError, choose_integrator, load_to_completion, render_to_completion, render_watched,
};
pub use choosing::set_choice;
pub use control::{ClosedGate, Filling, Framing, Gate, InputStamp, RenderControl, SightControl, ViewMode, WakeUp};
pub(crate) use deferred_drop::DeferredDrop;
pub use film::RenderFilm;
pub use layers::{PictureNames, describe_picture, file_options, layered_picture, named_lamps, single_picture};
pub use light_groups::{Lamps, LightGroup};
pub use light_measures::{MeasureOf, measures_of_area_light, measures_of_emitter, own_flux};
pub(crate) use pack::material::pack_loose;
pub(crate) use pack::medium::pack_medium_without_files;
pub use packed_scene::PackedScene;
pub(crate) use priority::{yield_to_all, yield_to_rendering, yield_to_window};
pub use resolution::{active_film, fit, framing, full_size};
pub use saved::{job_state, reserve_film, resume};
pub use shutter::{OpenShutter, open_shutter};
pub(crate) use sight::SeenThrough;
pub use status::{AutoStatus, BvhStatus, GuideStatus, LatencyStats, Outdated, RenderState, RenderStatus};
pub use stop_condition::StopReason;

use crate::scene::SceneSystems;

/// The steps of a frame, in this order, in `PostUpdate`.
///
/// Systems that show the picture run after `Collect`; systems that edit the scene run before `Detect`. Results come
/// first, so that a change that waited for the preview of the previous one is dispatched in the frame in which that
/// preview is complete.
#[derive(SystemSet, Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum EngineSystems {
    /// Takes the results that have arrived.
    Collect,
    /// Marks tables that may be out of date.
    Detect,
    /// Packs these tables, and keeps the old ones where nothing really differs.
    Extract,
    /// Cancels and starts jobs.
    Dispatch,
    /// Brings [`RenderStatus`] up to date.
    Report,
}

/// Adds the engine's resources and systems to an app that has [`crate::scene::ScenePlugin`].
pub struct EnginePlugin;

impl Plugin for EnginePlugin {
    fn build(&self, app: &mut App) {
        app.init_resource::<RenderControl>()
            .init_resource::<RenderStatus>()
            .init_resource::<RenderFilm>()
            .init_resource::<PackedScene>()
            .init_resource::<InputStamp>()
            .init_resource::<OpenShutter>()
            .init_resource::<WakeUp>()
            .init_resource::<Gate>()
            .init_resource::<detect::Dirty>()
            .init_resource::<deferred_drop::DeferredDrop>()
            .init_resource::<extract::Extracted>()
            .init_resource::<blas_cache::BlasCache>()
            .init_resource::<renderer::Renderer>()
            .init_resource::<saved::Resumed>()
            .init_resource::<auto::AutoIntegrator>()
            .init_resource::<choosing::PilotSearch>()
            .configure_sets(
                PostUpdate,
                (
                    EngineSystems::Collect,
                    EngineSystems::Detect,
                    EngineSystems::Extract,
                    EngineSystems::Dispatch,
                    EngineSystems::Report,
                )
                    .chain()
                    // A mesh that arrived in this frame is noticed in this frame.
                    .after(AssetEventSystems),
            )
            // Systems that show the scene in this frame find no picture of the previous one.
            .add_systems(
                PreUpdate,
                scene_change::clear_for_other_scene.after(SceneSystems::Apply),
            )
            .add_systems(
                PostUpdate,
                (
                    collect::collect_results.in_set(EngineSystems::Collect),
                    (scene_change::clear_for_other_scene, detect::detect_changes)
                        .chain()
                        .in_set(EngineSystems::Detect),
                    extract::extract_scene.in_set(EngineSystems::Extract),
                    (choosing::seek_choice, dispatch::dispatch_job)
                        .chain()
                        .in_set(EngineSystems::Dispatch),
                    report::report_status.in_set(EngineSystems::Report),
                ),
            );
    }
}
