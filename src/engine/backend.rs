//! The back ends, which render the work items of a scene and a view into samples.

use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use rayon::{ThreadPool, ThreadPoolBuildError, ThreadPoolBuilder};

use super::priority;
use super::schedule::WorkItem;
use crate::render::gbuffer::{TileGBuffer, render_gbuffer};
use crate::render::noise::replicas::{ReplicaSums, render_replicas};
use crate::render::scene::RenderScene;
use crate::render::shutter::Shutter;
use crate::render::tile::{Tile, TilePreview, TileSamples, render_blocks, render_preview};
use crate::render::view::View;

/// A device that renders. For every back end:
///
/// - The result of an item is a function of scene, view, tile and ranges of samples alone: not of the number of its
///   workers, nor of other items, earlier or concurrent. Random numbers are those of [`crate::sampling::Sampler`].
/// - A tile's samples are summed up in order. Samples that are not finite count as black and are counted.
/// - It checks its run's flag often enough that a change of the scene does not wait, and returns nothing once the flag
///   is set.
pub(super) enum Backend {
    /// Threads that each render a tile.
    Cpu(ThreadPool),
}

/// The message of a worker; `index` is the tile's index in the job's list.
#[derive(Debug)]
pub(super) enum TileResult {
    GBuffer {
        index: usize,
        tile: TileGBuffer,
    },
    Preview(TilePreview),
    Replicas(ReplicaSums),
    Samples {
        index: usize,
        samples: TileSamples,
    },
    /// A worker panicked; the run is over.
    Failed(String),
}

/// Renders one item; None if the flag was set in the meantime.
pub(super) type Work = dyn Fn(&WorkItem, &AtomicBool) -> Option<TileResult> + Send + Sync;

impl Backend {
    /// Starts this many threads, which are `yielding` to the window if there is one.
    pub fn cpu(threads: usize, yielding: bool) -> Result<Self, ThreadPoolBuildError> {
        let pool = ThreadPoolBuilder::new()
            .num_threads(threads)
            .thread_name(|index| format!("render {index}"))
            .start_handler(move |_| {
                if yielding {
                    priority::yield_to_window();
                }
            })
            .build();
        pool.map(Self::Cpu)
    }

    /// The number of items that are rendered at the same time.
    pub fn workers(&self) -> usize {
        match self {
            Self::Cpu(pool) => pool.current_num_threads(),
        }
    }

    /// Runs `worker` to its end on a worker thread, as soon as one is free.
    pub fn spawn(&self, worker: impl FnOnce() + Send + 'static) {
        match self {
            Self::Cpu(pool) => pool.spawn(worker),
        }
    }

    /// The function by which workers render each item of a picture. With a shutter, samples see its moments, by the
    /// view's integrator.
    pub fn work(&self, scene: RenderScene, view: View, shutter: Option<Shutter>, tiles: Arc<[Tile]>) -> Box<Work> {
        let shutter = shutter.map(|shutter| shutter.with_method_of(&view));
        match self {
            Self::Cpu(_) => Box::new(move |item, cancel| match item {
                WorkItem::GBuffer { index } => {
                    let tile = render_gbuffer(&scene, &view, tiles[*index], cancel)?;
                    Some(TileResult::GBuffer { index: *index, tile })
                }
                WorkItem::Preview { index, step } => {
                    render_preview(&scene, &view, tiles[*index], *step, cancel).map(TileResult::Preview)
                }
                WorkItem::Replicas(missing) => {
                    let sums = render_replicas(&scene, &view, shutter.as_ref(), missing, cancel)?;
                    Some(TileResult::Replicas(sums))
                }
                WorkItem::Samples { index, samples, blocks } => {
                    let (tile, samples, blocks) = (tiles[*index], samples.clone(), blocks.clone());
                    let samples = match &shutter {
                        Some(shutter) => shutter.render_tile(tile, samples, cancel)?,
                        None => render_blocks(&scene, &view, tile, samples, blocks, cancel)?,
                    };
                    Some(TileResult::Samples { index: *index, samples })
                }
            }),
        }
    }
}
