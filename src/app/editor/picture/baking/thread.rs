//! The thread that bakes: it reports its progress, and makes the small pictures of lightmaps that the window shows.
//!
//! The window's thread reads the reports and sets the wanted pictures, both under a lock that is held for a moment.

use std::num::NonZeroUsize;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use super::shown::{PagePicture, Showing, Wanted};
use crate::app::baking::{BakedLevel, baked_level};
use crate::app::editor::picture::compare::LitPicture;
use crate::bake::files::{self, Content, OutputFolder};
use crate::bake::job::{BakeEnding, BakeJob, BakeSettings, BakeSource};
use crate::bake::limits::BakeLimits;
use crate::bake::progress::{Progress, Stage, about_invalid};
use crate::engine::{WakeUp, yield_to_window};
use crate::files::Access;
use crate::render::scene::RenderScene;
use crate::render::view::View;
use crate::scene::description::SceneDescription;
use crate::scene::export::Hidden;

/// The input of a bake. It is a copy: later edits of the scene do not affect the bake.
pub struct BakeOrder {
    /// The scene that light is traced in.
    pub scene: RenderScene,
    /// The settings of paths, the medium around all surfaces, and the seed of random numbers.
    pub view: View,
    /// The scene that the level is written from.
    pub level: SceneDescription,
    /// The hidden parts of the scene, which the level lacks.
    pub hidden: Hidden,
    /// The files that may be read.
    pub access: Access,
    /// The settings of lightmaps and probes.
    pub settings: BakeSettings,
    /// The limits of samples and time.
    pub limits: BakeLimits,
    /// The folder for the files.
    pub folder: PathBuf,
    /// The number of threads that trace rays.
    pub threads: NonZeroUsize,
    /// Wakes the window when there are new pictures.
    pub wake_up: WakeUp,
}

/// The result of a bake that has written its files.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Written {
    /// Whether it was stopped before its limits.
    pub is_stopped: bool,
    /// The samples of each texel of a lightmap.
    pub samples: u32,
}

/// The progress of a bake, for the window.
#[derive(Clone, Debug, Default)]
pub struct BakeNews {
    /// The present stage, in words.
    pub stage: String,
    /// The progress of the stage; None before the first.
    pub progress: Option<Progress>,
    /// The samples that each texel of the lightmaps has.
    pub samples: u32,
    /// The content of the level that is in the folder, if this bake has less and would not replace it when stopped now.
    pub stays: Option<Content>,
    /// The number of lightmaps; 0 before it is known.
    pub pages: usize,
    /// Width and height of a lightmap.
    pub page_size: [u32; 2],
    /// The small picture of a lightmap; None before the first.
    pub picture: Option<PagePicture>,
    /// The level lit by its lightmaps, if the window wants it.
    pub lit: Option<Arc<LitPicture>>,
    /// Sentences about settings that could not be followed.
    pub warnings: Arc<Vec<String>>,
    /// The reason why the wanted view of the lit level cannot be shown, as a sentence.
    pub blind: Option<String>,
    /// The result of the bake, or its error as a sentence.
    pub ended: Option<Result<Written, String>>,
}

/// The state of the bake's output folder.
#[derive(Default)]
struct Folder {
    /// The folder; None once the bake has left it and writes nothing more.
    held: Option<OutputFolder>,
    /// Whether files are being written into it.
    is_written: bool,
}

#[derive(Default)]
pub(super) struct Shared {
    /// Set to end the tracing of light.
    cancel: AtomicBool,
    /// Set to write and finish nothing more.
    discards: Arc<AtomicBool>,
    /// Set when the window has closed the bake.
    closes: AtomicBool,
    folder: Mutex<Folder>,
    wanted: Mutex<Wanted>,
    is_wanted_anew: Condvar,
    news: Mutex<BakeNews>,
    wake_up: WakeUp,
}

fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

impl Shared {
    /// Applies `change` to the progress, and wakes the window.
    pub fn tell(&self, change: impl FnOnce(&mut BakeNews)) {
        change(&mut lock(&self.news));
        if let Some(wake) = &self.wake_up.0 {
            wake();
        }
    }

    fn tell_progress(&self, stage: String, progress: &Progress) {
        self.tell(|news| {
            (news.stage, news.progress) = (stage, Some(*progress));
            if let Some(gathered) = progress.gathered.filter(|_| progress.stage == Stage::Lightmaps) {
                news.samples = gathered.samples;
            }
        });
    }

    /// Notes that files are being written; returns false if the bake was discarded and has left its folder.
    fn begin_to_write(&self) -> bool {
        let mut folder = lock(&self.folder);
        folder.is_written = folder.held.is_some();
        folder.is_written
    }

    /// Leaves the folder, and removes it if it was made for this bake and is empty.
    fn leave_folder(&self) {
        *lock(&self.folder) = Folder::default();
    }

    /// The pictures that the window wants.
    pub fn wanted(&self) -> Wanted {
        lock(&self.wanted).clone()
    }

    /// Blocks the baking thread until the window wants other pictures than `before`. Returns false once the window has
    /// closed the bake.
    fn wait_for_other(&self, before: &Wanted) -> bool {
        let mut wanted = lock(&self.wanted);
        while *wanted == *before && !self.closes.load(Ordering::Relaxed) {
            wanted = self.is_wanted_anew.wait(wanted).unwrap_or_else(PoisonError::into_inner);
        }
        !self.closes.load(Ordering::Relaxed)
    }
}

/// A bake on a thread of its own.
pub struct BakeThread {
    shared: Arc<Shared>,
    thread: JoinHandle<()>,
    folder: PathBuf,
}

impl BakeThread {
    /// Begins to bake into the order's folder, which is `held`. The error is that of the system if it cannot start a
    /// thread.
    pub fn begin(order: BakeOrder, held: OutputFolder, wanted: Wanted) -> std::io::Result<Self> {
        let shared = Arc::new(Shared {
            folder: Mutex::new(Folder {
                held: Some(held),
                is_written: false,
            }),
            wanted: Mutex::new(wanted),
            wake_up: order.wake_up.clone(),
            ..Shared::default()
        });
        let (folder, own) = (order.folder.clone(), shared.clone());
        let thread = std::thread::Builder::new().name("bake".to_owned()).spawn(move || {
            let mut showing = Showing::default();
            let baked = catch_unwind(AssertUnwindSafe(|| bake(order, &own, &mut showing)));
            let baked = baked.unwrap_or_else(|_| Err("the bake has failed by a fault of the program".to_owned()));
            let (job, ended) = match baked {
                Ok((job, written)) => (Some(job), Ok(written)),
                Err(reason) => (None, Err(reason)),
            };
            own.leave_folder();
            own.tell(|news| news.ended = Some(ended));
            let Some(job) = job else { return };
            loop {
                let seen = own.wanted();
                showing.show_now(&own, &job, &seen);
                if !own.wait_for_other(&seen) {
                    return;
                }
            }
        })?;
        Ok(Self { shared, thread, folder })
    }

    /// The folder for the files.
    pub fn folder(&self) -> &Path {
        &self.folder
    }

    /// The present progress.
    pub fn news(&self) -> BakeNews {
        lock(&self.shared.news).clone()
    }

    /// The level lit by its lightmaps.
    pub fn lit(&self) -> Option<Arc<LitPicture>> {
        lock(&self.shared.news).lit.clone()
    }

    /// The result; None while the bake runs.
    pub fn ended(&self) -> Option<Result<Written, String>> {
        lock(&self.shared.news).ended.clone()
    }

    /// Ends the tracing of light; the light so far will be written.
    pub fn stop(&self) {
        self.shared.cancel.store(true, Ordering::Relaxed);
    }

    /// Whether it was stopped.
    pub fn is_stopped(&self) -> bool {
        self.shared.cancel.load(Ordering::Relaxed)
    }

    /// Sets the pictures that the window wants.
    pub fn show(&self, wanted: Wanted) {
        let mut known = lock(&self.shared.wanted);
        if *known != wanted {
            *known = wanted;
            self.shared.is_wanted_anew.notify_all();
        }
    }

    /// The pictures that the window wants.
    pub fn wanted(&self) -> Wanted {
        self.shared.wanted()
    }

    /// Discards the bake. Nothing is written, and a folder that was made for it is removed at once; files that are
    /// being written already are all written, so that they fit together.
    pub fn discard(self) -> LeftThread {
        self.shared.discards.store(true, Ordering::Relaxed);
        self.shared.cancel.store(true, Ordering::Relaxed);
        let mut folder = lock(&self.shared.folder);
        if !folder.is_written {
            folder.held = None;
        }
        drop(folder);
        // Under the lock, so that the thread does not begin to wait between its check and the notification.
        let wanted = lock(&self.shared.wanted);
        self.shared.closes.store(true, Ordering::Relaxed);
        self.shared.is_wanted_anew.notify_all();
        drop(wanted);
        LeftThread {
            shared: self.shared,
            thread: self.thread,
        }
    }
}

/// The thread of a discarded or closed bake. It ends soon, except while it describes a large level or finds the
/// neighbours of the triangles of a large mesh.
pub struct LeftThread {
    shared: Arc<Shared>,
    thread: JoinHandle<()>,
}

impl LeftThread {
    /// Whether it has ended.
    pub fn is_finished(&self) -> bool {
        self.thread.is_finished()
    }

    fn is_writing(&self) -> bool {
        lock(&self.shared.folder).is_written
    }
}

/// Waits before the program ends: until files that are being written are complete, and for the other threads, all
/// together, 0.3 seconds at most. Those that take longer write nothing, and end with the program.
pub fn wait_at_exit(threads: Vec<LeftThread>) {
    let begin = Instant::now();
    for thread in threads {
        while !thread.is_finished() && (thread.is_writing() || begin.elapsed() < LAST_WAIT) {
            std::thread::sleep(Duration::from_millis(5));
        }
    }
}

/// The time that the end of the program waits for a bake that writes nothing.
const LAST_WAIT: Duration = Duration::from_millis(300);

/// The error of a discarded bake.
const GIVEN_UP: &str = "the bake is given up";

/// Bakes and writes the files. The error is a sentence.
fn bake(order: BakeOrder, shared: &Shared, showing: &mut Showing) -> Result<(BakeJob, Written), String> {
    yield_to_window();
    let BakeOrder { settings, folder, .. } = &order;
    shared.tell_progress("Describing the level".to_owned(), &Progress::default());
    let BakedLevel {
        writer,
        probes,
        messages,
    } = baked_level(&order.level, &order.hidden, folder, &order.access).map_err(|error| error.to_string())?;
    if shared.discards.load(Ordering::Relaxed) {
        return Err(GIVEN_UP.to_owned());
    }
    shared.tell(|news| news.warnings = Arc::new(messages));
    let pool = rayon::ThreadPoolBuilder::new()
        .num_threads(order.threads.get())
        .start_handler(|_| yield_to_window());
    let source = BakeSource {
        scene: order.scene.clone(),
        view: order.view.clone(),
        level: writer,
        probes,
        pool: Arc::new(pool.build().map_err(|error| error.to_string())?),
        is_seen: true,
        discards: shared.discards.clone(),
        layers: None,
    };
    let mut prepared = |now: &Progress, words: &str| shared.tell_progress(with_large_letter(words), now);
    let mut job =
        BakeJob::prepare(source, settings, &shared.cancel, &mut prepared).map_err(|error| error.to_string())?;
    shared.tell(|news| {
        Arc::make_mut(&mut news.warnings).extend_from_slice(job.warnings());
        news.pages = job.blueprint().page_count();
        news.page_size = job.blueprint().places.size.to_array();
    });
    let there = Content::of_folder(folder);
    let stays = |job: &BakeJob| there.filter(|there| !job.content().may_replace(there));
    let mut watch = |job: &BakeJob, now: &Progress| {
        showing.look(shared, job);
        lock(&shared.news).stays = stays(job);
        let words = now.stage.words(Some(job.blueprint()));
        shared.tell_progress(with_large_letter(&words), now);
    };
    let ending = job
        .run(&order.limits, &shared.cancel, &mut watch)
        .map_err(|error| error.to_string())?;
    let is_discarded = || shared.discards.load(Ordering::Relaxed);
    if ending == BakeEnding::Cancelled && !is_discarded() {
        if let Some(there) = stays(&job) {
            let (gathered, folder) = (job.content(), folder.display());
            return Err(format!(
                "it was stopped with {gathered}, and {folder} keeps its level, which has {there}"
            ));
        }
        job.finish_so_far(&mut watch).map_err(|error| error.to_string())?;
    }
    let Some(baked) = job.baked().filter(|_| !is_discarded()) else {
        return Err(GIVEN_UP.to_owned());
    };
    if !shared.begin_to_write() {
        return Err(GIVEN_UP.to_owned());
    }
    shared.tell(|news| (news.stage, news.progress) = ("Writing the files".to_owned(), None));
    files::write(folder, job.blueprint(), baked).map_err(|error| error.to_string())?;
    let written = Written {
        is_stopped: ending == BakeEnding::Cancelled,
        samples: baked.samples,
    };
    if let Some(warning) = about_invalid(job.invalid_samples()) {
        shared.tell(|news| Arc::make_mut(&mut news.warnings).push(warning));
    }
    Ok((job, written))
}

fn with_large_letter(words: &str) -> String {
    let mut letters = words.chars();
    let first = letters.next().into_iter().flat_map(char::to_uppercase);
    first.chain(letters).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_end_of_the_program_waits_for_all_threads_together() {
        let left = |is_written: bool, time: Duration| {
            let shared = Arc::new(Shared::default());
            lock(&shared.folder).is_written = is_written;
            LeftThread {
                shared,
                thread: std::thread::spawn(move || std::thread::sleep(time)),
            }
        };
        let slow = || left(false, Duration::from_secs(60));
        let begin = Instant::now();
        wait_at_exit((0..8).map(|_| slow()).collect());
        let waited = begin.elapsed();
        assert!(waited >= LAST_WAIT && waited < 6 * LAST_WAIT, "{waited:?}");
        // Files that are being written are completed, however long the wait for other threads was.
        let time = 2 * LAST_WAIT;
        let begin = Instant::now();
        wait_at_exit(vec![slow(), left(true, time)]);
        assert!(begin.elapsed() >= time);
    }
}
