//! Searches the outline whenever one of its inputs has changed: first in cells so coarse that it is ready in the next
//! frame, then, when nothing changes any more, with a ray for each pixel.
//!
//! It has threads of its own, because those that render are busy until a picture is done. Its threads work little and
//! run with the window's priority.

use std::collections::HashMap;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use bevy::math::UVec2;
use bevy::prelude::*;
use crossbeam_channel::{Receiver, bounded};
use rayon::{ThreadPool, ThreadPoolBuilder};

use super::outline::{Level, OutlineImage, SelectionOutline};
use crate::accel::Tlas;
use crate::engine::WakeUp;
use crate::render::camera::Camera;
use crate::render::visibility::sight::Sight;
use crate::render::visibility::silhouette::{MarkedShapes, PixelGrid, edges};

/// The cells of the first search after a change: few enough for a few milliseconds.
const QUICK_CELLS: u32 = 30_000;
/// The most cells of the fine search, more than a screen has pixels.
const MOST_CELLS: u32 = 9_000_000;

/// The inputs of an outline.
#[derive(Clone, Debug)]
pub struct OutlineRequest {
    /// The scene.
    pub geometry: Arc<Tlas>,
    /// The entity of each instance and placement of the scene.
    pub entity_of_instance: Arc<[Entity]>,
    /// The camera of the picture.
    pub camera: Camera,
    /// See [`crate::render::view::View::sight`].
    pub sight: Sight,
    /// The size of the picture in pixels of the screen.
    pub picture: UVec2,
    /// The width of lines in pixels.
    pub width: f32,
    /// The outlined things.
    pub marked: Arc<[(Entity, Level)]>,
}

impl PartialEq for OutlineRequest {
    fn eq(&self, other: &Self) -> bool {
        Arc::ptr_eq(&self.geometry, &other.geometry)
            && Arc::ptr_eq(&self.entity_of_instance, &other.entity_of_instance)
            && (self.camera, self.picture, self.width) == (other.camera, other.picture, other.width)
            && self.sight == other.sight
            && (Arc::ptr_eq(&self.marked, &other.marked) || self.marked == other.marked)
    }
}

/// The shapes of one level, which are kept for the next request.
#[derive(Clone)]
struct LevelShapes {
    level: Level,
    entities: Vec<Entity>,
    shapes: Arc<MarkedShapes>,
}

/// The shapes of the last request, the strongest level last. Each level is searched by itself, so that a wall under the
/// pointer does not hide the selection behind it.
#[derive(Clone)]
struct KnownShapes {
    geometry: Arc<Tlas>,
    levels: Vec<LevelShapes>,
}

struct Done {
    /// The image of the outline; None if there are more edges than an outline could show.
    image: Option<Option<OutlineImage>>,
    shapes: KnownShapes,
    is_finest: bool,
}

struct Running {
    request: OutlineRequest,
    is_quick: bool,
    cancel: Arc<AtomicBool>,
    result: Receiver<Done>,
}

/// The search for outlines, and its last result.
#[derive(Resource, Default)]
pub struct OutlinePass {
    pool: Option<ThreadPool>,
    running: Option<Running>,
    /// The request of the shown outline, and whether the outline is final.
    answered: Option<(OutlineRequest, bool)>,
    shapes: Option<KnownShapes>,
    outline: SelectionOutline,
}

impl OutlinePass {
    /// The last outline.
    pub fn outline(&self) -> &SelectionOutline {
        &self.outline
    }

    /// Takes the result, if there is one.
    pub fn collect(&mut self) {
        let Some(running) = &self.running else { return };
        let done = match running.result.try_recv() {
            Ok(done) => done,
            Err(crossbeam_channel::TryRecvError::Empty) => return,
            Err(crossbeam_channel::TryRecvError::Disconnected) => {
                // The search panicked: the outline of this request is not tried again.
                self.answered = self.running.take().map(|running| (running.request, true));
                return;
            }
        };
        let Some(Running { request, .. }) = self.running.take() else {
            return;
        };
        self.shapes = Some(done.shapes);
        // Without an image, the outline of the coarser cells stays.
        if let Some(image) = done.image {
            self.outline.replace(image);
        }
        self.answered = Some((request, done.is_finest));
    }

    /// Requests an outline, or none at all. `threads` is the number of threads that may be used.
    pub fn request(&mut self, request: Option<OutlineRequest>, threads: usize, wake_up: &WakeUp) {
        let Some(request) = request.filter(|request| !request.marked.is_empty()) else {
            if self.outline.image().is_some() {
                self.outline.replace(None);
            }
            self.cancel();
            self.answered = None;
            self.shapes = None;
            return;
        };
        if let Some(running) = &self.running {
            // A quick search is not cancelled: otherwise there would be no outline while the camera moves.
            if running.request != request && !running.is_quick {
                self.cancel();
            }
        }
        let is_refined = match &self.answered {
            Some((answered, is_finest)) if *answered == request => {
                if *is_finest {
                    return;
                }
                true
            }
            _ => false,
        };
        if self.running.is_none() {
            self.start(request, is_refined, threads, wake_up.clone());
        }
    }

    fn cancel(&mut self) {
        if let Some(running) = self.running.take() {
            running.cancel.store(true, Ordering::Relaxed);
        }
    }

    fn start(&mut self, request: OutlineRequest, refined: bool, threads: usize, wake_up: WakeUp) {
        if self.pool.is_none() {
            let pool = ThreadPoolBuilder::new()
                .num_threads(threads)
                .thread_name(|index| format!("outline {index}"))
                .build();
            // Without threads there is no outline.
            self.pool = pool.ok();
        }
        let Some(pool) = &self.pool else { return };
        let (sender, result) = bounded(1);
        let cancel = Arc::new(AtomicBool::new(false));
        let known = self.shapes.clone();
        let (job, flag) = (request.clone(), cancel.clone());
        pool.spawn(move || {
            // A panic that escapes from a job of this pool would end the program.
            let found = catch_unwind(AssertUnwindSafe(|| find(&job, known, refined, &flag)));
            if let Ok(done) = found {
                let _ = sender.send(done);
            }
            drop(sender);
            if let Some(wake) = &wake_up.0 {
                wake();
            }
        });
        self.running = Some(Running {
            request,
            is_quick: !refined,
            cancel,
            result,
        });
    }
}

/// Searches the outline, with cells of a pixel if `refined`.
fn find(request: &OutlineRequest, known: Option<KnownShapes>, refined: bool, cancel: &AtomicBool) -> Done {
    let known = KnownShapes::of(request, known);
    let mut is_finest = true;
    let mut lines = Vec::new();
    let mut whole: Option<PixelGrid> = None;
    for LevelShapes { level, shapes, .. } in &known.levels {
        let Some(grid) = PixelGrid::around(&shapes.bounds(), request.camera, request.picture) else {
            continue;
        };
        let finest = grid.with_cells(MOST_CELLS);
        let grid = if refined { finest } else { grid.with_cells(QUICK_CELLS) };
        is_finest &= grid == finest;
        match edges(shapes, (&request.geometry, &request.sight), &grid, cancel) {
            Some(edges) => lines.push((*level, edges)),
            None => {
                return Done {
                    image: None,
                    shapes: known,
                    is_finest: refined,
                };
            }
        }
        whole = Some(whole.map_or(grid, |before| before.union(&grid)));
    }
    Done {
        image: Some(whole.map(|whole| OutlineImage::draw(&lines, &whole, request.width))),
        shapes: known,
        is_finest,
    }
}

impl KnownShapes {
    /// The shapes of a request. Levels that equal those of the last request are reused.
    fn of(request: &OutlineRequest, known: Option<Self>) -> Self {
        let known = known.filter(|known| Arc::ptr_eq(&known.geometry, &request.geometry));
        let mut before = known.map_or(Vec::new(), |known| known.levels);
        let mut levels = Vec::new();
        for level in [Level::Hovered, Level::Selected, Level::Active] {
            let marked = request.marked.iter().filter(|(_, own)| *own == level);
            let entities: Vec<Entity> = marked.map(|(entity, _)| *entity).collect();
            if entities.is_empty() {
                continue;
            }
            let same = |old: &LevelShapes| old.entities == entities;
            let old = before.iter().position(same).map(|place| before.swap_remove(place));
            levels.push(match old {
                Some(old) => LevelShapes { level, ..old },
                None => LevelShapes {
                    level,
                    shapes: Arc::new(shapes_of(&entities, request)),
                    entities,
                },
            });
        }
        Self {
            geometry: request.geometry.clone(),
            levels,
        }
    }
}

/// The shapes of entities, each with a mark of its own.
fn shapes_of(entities: &[Entity], request: &OutlineRequest) -> MarkedShapes {
    let marks: HashMap<Entity, u32> = entities.iter().copied().zip(1..).collect();
    let items = (0..).zip(request.entity_of_instance.iter());
    let marked = items.filter_map(|(item, entity)| Some((item, *marks.get(entity)?)));
    MarkedShapes::new(&request.geometry, marked)
}

#[cfg(test)]
mod tests {
    use std::time::{Duration, Instant};

    use bevy::math::{Affine3A, Vec2, Vec3};

    use super::*;
    use crate::app::editor::camera::picking::tests::spheres;

    const WHOLE: UVec2 = UVec2::new(400, 200);

    /// Two balls, 100 pixels apart with a radius of 20, of which `marked` has the outline. +x is to the left.
    fn request(geometry: &Arc<Tlas>, entities: &[Entity], marked: &[(Entity, Level)]) -> OutlineRequest {
        OutlineRequest {
            geometry: geometry.clone(),
            entity_of_instance: entities.into(),
            camera: Camera::orthographic(Affine3A::IDENTITY, Vec2::new(10.0, 5.0), 0.0, 100.0),
            sight: Sight::default(),
            picture: WHOLE,
            width: 2.0,
            marked: marked.into(),
        }
    }

    /// Runs frames until the finest outline of the request is there.
    fn settle(pass: &mut OutlinePass, request: &OutlineRequest) {
        let begin = Instant::now();
        loop {
            pass.request(Some(request.clone()), 2, &WakeUp::default());
            pass.collect();
            if matches!(&pass.answered, Some((answered, true)) if answered == request) {
                return;
            }
            assert!(begin.elapsed() < Duration::from_secs(600));
            std::thread::sleep(Duration::from_millis(1));
        }
    }

    fn opacity(pass: &OutlinePass, x: u32, y: u32) -> u8 {
        let image = pass.outline().image();
        image.map_or(0, |image| image.pixel(UVec2::new(x, y)).a())
    }

    #[test]
    fn an_outline_is_replaced_as_a_whole() {
        let (packed, entities) = spheres(&[Vec3::new(2.5, 0.0, 10.0), Vec3::new(-2.5, 0.0, 10.0)]);
        let geometry = packed.scene.expect("spheres").geometry;
        let mut pass = OutlinePass::default();
        // The ball at the left reaches from 130 to 170, the one at the right from 230 to 270.
        let left = request(&geometry, &entities, &[(entities[0], Level::Active)]);
        settle(&mut pass, &left);
        assert!(opacity(&pass, 130, 100) > 200 && opacity(&pass, 150, 80) > 200);
        assert_eq!([opacity(&pass, 150, 100), opacity(&pass, 230, 100)], [0, 0]);

        let right = request(&geometry, &entities, &[(entities[1], Level::Hovered)]);
        settle(&mut pass, &right);
        assert_eq!([opacity(&pass, 130, 100), opacity(&pass, 150, 80)], [0, 0]);
        assert!(opacity(&pass, 230, 100) > 100);

        let nothing = request(&geometry, &entities, &[]);
        pass.request(Some(nothing), 2, &WakeUp::default());
        assert!(pass.outline().image().is_none(), "it is gone at once");
    }

    #[test]
    fn what_is_hovered_does_not_hide_the_selection_behind_it() {
        let (packed, entities) = spheres(&[Vec3::new(0.0, 0.0, 10.0), Vec3::new(0.5, 0.0, 5.0)]);
        let geometry = packed.scene.expect("spheres").geometry;
        let marked = [(entities[1], Level::Hovered), (entities[0], Level::Active)];
        let mut pass = OutlinePass::default();
        settle(&mut pass, &request(&geometry, &entities, &marked));
        // The selected ball reaches from 180 to 220, the nearer one from 170 to 210.
        let dim = opacity(&pass, 180, 100);
        assert!(dim > 120 && dim < 180, "{dim}");
        assert!(opacity(&pass, 219, 100) > 200 && opacity(&pass, 170, 100) > 100);
    }

    #[test]
    fn while_the_camera_moves_there_is_always_an_outline() {
        let (packed, entities) = spheres(&[Vec3::new(0.0, 0.0, 10.0)]);
        let geometry = packed.scene.expect("a sphere").geometry;
        let mut pass = OutlinePass::default();
        let still = request(&geometry, &entities, &[(entities[0], Level::Active)]);
        let mut shown = 0;
        let begin = Instant::now();
        // Every frame asks for another picture than the one before.
        for frame in 0.. {
            let from = Affine3A::from_translation(Vec3::X * 1e-4 * frame as f32);
            let camera = Camera::orthographic(from, Vec2::new(10.0, 5.0), 0.0, 100.0);
            let moved = OutlineRequest {
                camera,
                ..still.clone()
            };
            pass.request(Some(moved), 2, &WakeUp::default());
            std::thread::sleep(Duration::from_millis(1));
            let before = pass.answered.clone();
            pass.collect();
            shown += u32::from(pass.answered != before);
            if shown == 5 {
                break;
            }
            assert!(begin.elapsed() < Duration::from_secs(600), "{shown} in {frame} frames");
        }
    }
}
