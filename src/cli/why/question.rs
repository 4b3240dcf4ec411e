//! The arguments of `sunroom why`, and the question that they ask about a loaded scene.

use std::sync::Arc;
use std::sync::atomic::AtomicBool;
use std::sync::mpsc::{self, RecvTimeoutError};
use std::time::{Duration, Instant};

use bevy::prelude::*;
use clap::Args;
use sunroom::engine::reasons::Things;
use sunroom::render::breakdown::{LEAST_SAMPLES, Progress};
use sunroom::render::part::Crop;
use sunroom::render::scene::RenderScene;
use sunroom::render::view::View;

use crate::cli::args::{MemoryArgs, MissingArgs, SceneArgs, ThreadArgs, TrustArgs};
use crate::cli::parse;
use crate::cli::picture_args::SizeArgs;
use crate::cli::progress::{self, Shown};

#[derive(Args)]
pub struct WhyArgs {
    #[command(flatten)]
    pub scene: SceneArgs,
    #[command(flatten)]
    pub subject: Subject,
    /// Samples per pixel; with --lamp paths from the lamp [default: 65536 in all, at least 64 per pixel; 262144 paths]
    #[arg(short, long, value_parser = clap::value_parser!(u32).range(i64::from(LEAST_SAMPLES)..))]
    pub spp: Option<u32>,
    /// Camera of the picture, by its id or its index from 0 on [default: the first]
    #[arg(long, value_name = "NAME|INDEX")]
    pub camera: Option<String>,
    #[command(flatten)]
    pub size: SizeArgs,
    /// Seed of the random numbers; the same seed gives the same figures on any number of threads
    #[arg(long)]
    pub seed: Option<u32>,
    /// Print one JSON object
    #[arg(long)]
    pub json: bool,
    #[command(flatten)]
    pub threads: ThreadArgs,
    #[command(flatten)]
    pub memory: MemoryArgs,
    #[command(flatten)]
    pub trust: TrustArgs,
    #[command(flatten)]
    pub missing: MissingArgs,
    /// Treat warnings about the scene as errors
    #[arg(long)]
    pub strict: bool,
    /// No progress
    #[arg(short, long)]
    pub quiet: bool,
}

/// The subject of the question: a pixel, a rectangle of pixels, or a lamp.
#[derive(Args)]
#[group(required = true, multiple = false)]
pub struct Subject {
    /// Pixel of the picture, (0, 0) at the upper left
    #[arg(long, value_name = "X,Y", value_parser = parse::pixel)]
    pub at: Option<UVec2>,
    /// Rectangle of pixels
    #[arg(long, value_name = "X,Y,W,H", value_parser = parse::crop)]
    pub region: Option<Crop>,
    /// Lamp whose light is followed, by its id or name
    #[arg(long, value_name = "NAME")]
    pub lamp: Option<String>,
}

/// A loaded scene and what is asked about it.
pub struct Question<'a> {
    pub args: &'a WhyArgs,
    pub world: &'a World,
    pub things: Things,
    pub scene: RenderScene,
    pub view: View,
    pub cancel: Arc<AtomicBool>,
}

/// The time between two looks at the progress. What is found earlier shows none.
const TICK: Duration = Duration::from_secs(1);

impl Question<'_> {
    /// Searches on the threads of `pool`, and shows the progress. None if interrupted.
    pub fn search<T: Send>(
        &self,
        pool: &rayon::ThreadPool,
        search: impl FnOnce(&Progress) -> Option<T> + Send,
    ) -> Option<T> {
        let progress = &Progress::cancelled_by(self.cancel.clone());
        let mut shown = progress::Progress::new(self.args.quiet, None);
        let (begin, mut last) = (Instant::now(), Shown::default());
        let found = std::thread::scope(|scope| {
            let (sender, found) = mpsc::channel();
            scope.spawn(move || drop(sender.send(pool.install(|| search(progress)))));
            loop {
                match found.recv_timeout(TICK) {
                    Ok(found) => return found,
                    // The scope passes on the panic of the thread.
                    Err(RecvTimeoutError::Disconnected) => return None,
                    Err(RecvTimeoutError::Timeout) => {
                        last = Shown {
                            done: progress.done(),
                            seconds: begin.elapsed().as_secs_f64(),
                            message: "traced".to_owned(),
                            ..Shown::default()
                        };
                        shown.show(&last);
                    }
                }
            }
        });
        shown.end(&last);
        found
    }
}
