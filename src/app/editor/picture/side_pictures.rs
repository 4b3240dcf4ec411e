//! The pictures of the side views, traced on a thread of low priority: first half as wide and high, so that they
//! follow a drag, then with a few samples per pixel, until nothing changes any more.
//!
//! One thread suffices, since only first hits are traced, and the picture of the main view keeps its cores.

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};

use bevy::math::UVec2;
use bevy::prelude::error;
use bevy_egui::egui::ColorImage;
use crossbeam_channel::{Receiver, Sender, unbounded};

use crate::app::editor::command::side_views::SIDES;
use crate::engine::{WakeUp, yield_to_rendering};
use crate::render::camera::Camera;
use crate::render::film::Film;
use crate::render::filter::PixelFilter;
use crate::render::scene::RenderScene;
use crate::render::tile::{render_tile, tiles};
use crate::render::tonemap::Display;
use crate::render::view::{Integrator, PathSettings, Shown, Strategy, View};
use crate::render::visibility::sight::Sight;
use crate::sampling::SequenceKind;

/// The number of side views.
pub const COUNT: usize = SIDES.len();
/// The samples per pixel after each pass.
const SAMPLES: [u32; 3] = [1, 2, 4];
/// The factor by which the first picture has fewer pixels along either side.
const COARSE: u32 = 2;

/// The view of a scene by an orthographic camera of a side view, in pixels of `size`.
pub fn side_view(camera: Camera, size: UVec2, is_clay: bool, sight: Sight) -> View {
    View {
        camera,
        film_camera: None,
        width: size.x,
        height: size.y,
        medium: None,
        filter: PixelFilter::Box,
        // First hits need no paths.
        integrator: Integrator::Path(PathSettings {
            max_depth: 1,
            rr_depth: 1,
            hide_emitters: false,
            strategy: Strategy::Mis,
            media: false,
        }),
        shown: if is_clay { Shown::Clay } else { Shown::Headlight },
        sight,
        light_groups: Default::default(),
        layers: Default::default(),
        before: None,
        sequence: SequenceKind::Sobol,
        seed: 0,
        photons: Default::default(),
        clamp: None,
        guide: None,
    }
}

/// A side view to be traced.
struct Order {
    scene: RenderScene,
    view: View,
    /// Whether another order has replaced it.
    is_stale: AtomicBool,
}

impl Order {
    fn new(scene: &RenderScene, view: &View) -> Self {
        Self {
            scene: scene.clone(),
            view: view.clone(),
            is_stale: AtomicBool::new(false),
        }
    }

    fn is_of(&self, scene: &RenderScene, view: &View) -> bool {
        // Lights do not show in side views, so that a change of their strength changes nothing.
        let is_same = RenderScene {
            lights: scene.lights.clone(),
            ..self.scene.clone()
        }
        .is_same(scene);
        is_same && self.view == *view
    }
}

/// The picture of a side view.
#[derive(Clone, Debug)]
pub struct SidePicture {
    /// The camera that took it.
    pub camera: Camera,
    /// The pixels.
    pub image: Arc<ColorImage>,
    /// The number of the picture, different for all pictures.
    pub number: u64,
}

/// The tracer of the side views, and their last pictures.
#[derive(Default)]
pub struct SidePictures {
    tracer: Option<Tracer>,
    pictures: [Option<SidePicture>; COUNT],
    count: u64,
}

struct Tracer {
    desk: Arc<Desk>,
    pictures: Receiver<(usize, Camera, ColorImage)>,
}

/// The place where the window leaves orders for the thread.
#[derive(Default)]
struct Desk {
    wanted: Mutex<Wanted>,
    changed: Condvar,
    /// Whether the thread shall end. It is set while `wanted` is locked, so that a waiting thread notices it.
    ends: AtomicBool,
}

#[derive(Default)]
struct Wanted {
    orders: [Option<Arc<Order>>; COUNT],
    /// The view that is traced first, because the user works in it.
    first: Option<usize>,
}

impl Desk {
    fn wanted(&self) -> MutexGuard<'_, Wanted> {
        // What is wanted is whole at any time.
        self.wanted.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Leaves orders for these views of a scene. Returns whether some are new.
    fn order(&self, scene: &RenderScene, views: [Option<&View>; COUNT], first: Option<usize>) -> bool {
        let mut wanted = self.wanted();
        wanted.first = first;
        let mut is_new = false;
        for (order, view) in wanted.orders.iter_mut().zip(views) {
            let is_same = match (&*order, view) {
                (Some(order), Some(view)) => order.is_of(scene, view),
                (order, view) => order.is_none() && view.is_none(),
            };
            if is_same {
                continue;
            }
            if let Some(old) = order.take() {
                old.is_stale.store(true, Ordering::Relaxed);
            }
            *order = view.map(|view| Arc::new(Order::new(scene, view)));
            is_new = true;
        }
        is_new
    }
}

impl SidePictures {
    /// The last picture of a side view.
    pub fn picture(&self, side: usize) -> Option<&SidePicture> {
        self.pictures.get(side)?.as_ref()
    }

    /// Takes the pictures that are ready.
    pub fn collect(&mut self) {
        let Some(tracer) = &self.tracer else { return };
        for (side, camera, image) in tracer.pictures.try_iter() {
            self.count += 1;
            self.pictures[side] = Some(SidePicture {
                camera,
                image: Arc::new(image),
                number: self.count,
            });
        }
    }

    /// Requests the pictures of these views of a scene. `first` is the view that the user works in.
    pub fn request(&mut self, scene: &RenderScene, views: [Option<&View>; COUNT], first: Option<usize>, wake: &WakeUp) {
        if self.tracer.is_none() {
            self.tracer = Tracer::start(wake.clone());
        }
        let Some(tracer) = &self.tracer else { return };
        if tracer.desk.order(scene, views, first) {
            tracer.desk.changed.notify_one();
        }
    }

    /// Ends the thread and drops the pictures.
    pub fn clear(&mut self) {
        *self = Self {
            count: self.count,
            ..Self::default()
        };
    }
}

impl Tracer {
    fn start(wake: WakeUp) -> Option<Self> {
        let desk = Arc::new(Desk::default());
        let (sender, pictures) = unbounded();
        let of_thread = desk.clone();
        let thread = std::thread::Builder::new().name("side views".to_owned());
        match thread.spawn(move || work(&of_thread, &sender, &wake)) {
            Ok(_) => Some(Self { desk, pictures }),
            Err(error) => {
                error!("The thread of the side views could not be started: {error}");
                None
            }
        }
    }
}

impl Drop for Tracer {
    fn drop(&mut self) {
        let mut wanted = self.desk.wanted();
        self.desk.ends.store(true, Ordering::Relaxed);
        for order in wanted.orders.iter_mut().filter_map(Option::take) {
            order.is_stale.store(true, Ordering::Relaxed);
        }
        drop(wanted);
        self.desk.changed.notify_one();
    }
}

/// An order under way.
struct Work {
    order: Arc<Order>,
    /// The samples of the fine passes; None before the first.
    film: Option<Film>,
    /// The number of passes done, the coarse one among them.
    passes: usize,
}

impl Work {
    fn new(order: Arc<Order>) -> Self {
        Self {
            order,
            film: None,
            passes: 0,
        }
    }

    fn is_done(&self) -> bool {
        self.passes > SAMPLES.len()
    }

    /// Makes the next pass; None if the order has become stale meanwhile, or the thread `ends`. After a panic the order
    /// counts as done, so that the other views and later orders are traced.
    fn advance(&mut self, ends: &AtomicBool) -> Option<ColorImage> {
        catch_unwind(AssertUnwindSafe(|| self.next_pass(ends))).unwrap_or_else(|_| {
            self.film = None;
            self.passes = SAMPLES.len() + 1;
            None
        })
    }

    fn next_pass(&mut self, ends: &AtomicBool) -> Option<ColorImage> {
        let Order { scene, view, is_stale } = &*self.order;
        let pass = self.passes;
        self.passes += 1;
        let Some(&samples) = pass.checked_sub(1).and_then(|pass| SAMPLES.get(pass)) else {
            let coarse = View {
                width: view.width.div_ceil(COARSE),
                height: view.height.div_ceil(COARSE),
                ..view.clone()
            };
            let mut film = Film::new(coarse.width, coarse.height);
            // It is finished even if stale: otherwise nothing would be seen while the view moves.
            add_samples(&mut film, scene, &coarse, 1, ends)?;
            return Some(image(&film));
        };
        let film = self.film.get_or_insert_with(|| Film::new(view.width, view.height));
        add_samples(film, scene, view, samples, is_stale)?;
        Some(image(film))
    }
}

/// Brings all pixels to this number of samples; None if `cancel` was set meanwhile.
fn add_samples(film: &mut Film, scene: &RenderScene, view: &View, samples: u32, cancel: &AtomicBool) -> Option<()> {
    let done = film.sample_count();
    for tile in tiles(view.width, view.height) {
        film.add(&render_tile(scene, view, tile, done..samples, cancel)?);
    }
    Some(())
}

fn image(film: &Film) -> ColorImage {
    let radiance = film.radiance();
    let mut rgba = vec![0; 4 * radiance.len()];
    Display::default().encode_rgba(&radiance, &mut rgba);
    ColorImage::from_rgba_unmultiplied([film.width() as usize, film.height() as usize], &rgba)
}

/// Traces what is wanted until the window ends the thread.
fn work(desk: &Desk, pictures: &Sender<(usize, Camera, ColorImage)>, wake: &WakeUp) {
    yield_to_rendering();
    let mut works = Works::default();
    while let Some(side) = works.next(desk) {
        let Some(work) = &mut works.of_sides[side] else {
            continue;
        };
        let Some(image) = work.advance(&desk.ends) else {
            continue;
        };
        if pictures.send((side, work.order.view.camera, image)).is_err() {
            return;
        }
        if let Some(wake) = &wake.0 {
            wake();
        }
    }
}

/// The orders under way.
#[derive(Default)]
struct Works {
    of_sides: [Option<Work>; COUNT],
    /// The turn in which each view was traced last. It outlives the orders: an edit that goes on replaces all of them
    /// before each turn, and every view shall follow it.
    last_turns: [u64; COUNT],
    turn: u64,
}

impl Works {
    /// Waits for an order that is not done and returns its view; None when the thread shall end.
    fn next(&mut self, desk: &Desk) -> Option<usize> {
        let mut wanted = desk.wanted();
        loop {
            if desk.ends.load(Ordering::Relaxed) {
                return None;
            }
            let old = self.take_orders(&wanted);
            if !old.is_empty() {
                // The window must not wait until a large scene is freed.
                drop(wanted);
                drop(old);
                wanted = desk.wanted();
                continue;
            }
            if let Some(side) = self.least_done(wanted.first) {
                self.turn += 1;
                self.last_turns[side] = self.turn;
                return Some(side);
            }
            wanted = desk.changed.wait(wanted).unwrap_or_else(PoisonError::into_inner);
        }
    }

    /// Takes the orders that are new. Returns the work on those that they replace.
    fn take_orders(&mut self, wanted: &Wanted) -> Vec<Work> {
        let mut old = Vec::new();
        for (work, order) in self.of_sides.iter_mut().zip(&wanted.orders) {
            let is_same = match (&*work, order) {
                (Some(work), Some(order)) => Arc::ptr_eq(&work.order, order),
                (work, order) => work.is_none() && order.is_none(),
            };
            if !is_same {
                old.extend(std::mem::replace(work, order.clone().map(Work::new)));
            }
        }
        old
    }

    /// The view with the fewest passes. Among views without any it is the one that was traced longest ago, and among
    /// other equals the `first`.
    fn least_done(&self, first: Option<usize>) -> Option<usize> {
        let waiting = self.of_sides.iter().enumerate().filter_map(|(side, work)| {
            let passes = work.as_ref().filter(|work| !work.is_done())?.passes;
            let last_turn = if passes == 0 { self.last_turns[side] } else { 0 };
            Some((passes, last_turn, first != Some(side), side))
        });
        waiting.min().map(|(.., side)| side)
    }
}

#[cfg(test)]
mod tests;
