//! The outlines of some shapes as the camera sees them, also where other shapes hide them: for drawing over the
//! picture.
//!
//! One ray goes through the centre of every cell of a grid, against these shapes alone. Cells at an edge get sixteen
//! more, so that the edge is known to a quarter of a cell. Only there is the rest of the scene tested for occlusion:
//! the work depends on the size of the shapes in the picture and the length of their edges, not on the rest of the
//! scene.

use std::sync::atomic::{AtomicBool, Ordering};

use glam::{UVec2, Vec2};
use rayon::prelude::*;

use super::sight::Sight;
use crate::accel::{Hit, RayLanes, SplitMethod, Tlas};
use crate::math::Aabb;
use crate::math::lanes::{LANES, Lanes, each_lane};
use crate::render::camera::Camera;

/// Some shapes of a scene, each with a mark above 0. Edges are found between shapes of different marks.
#[derive(Clone, Debug)]
pub struct MarkedShapes {
    shapes: Tlas,
    /// The marks by [`Hit::instance`].
    marks: Vec<u32>,
}

impl MarkedShapes {
    /// Copies shapes and placements out of `scene`, by [`Hit::instance`] in ascending order, with their marks.
    pub fn new(scene: &Tlas, marked: impl IntoIterator<Item = (u32, u32)>) -> Self {
        let count = scene.instances().len() + scene.placements().len();
        let (items, marks): (Vec<u32>, Vec<u32>) =
            marked.into_iter().filter(|(item, _)| (*item as usize) < count).unzip();
        Self {
            shapes: scene.part(&items, SplitMethod::default()),
            marks,
        }
    }

    /// World bounds of the shapes; empty if there are none.
    pub fn bounds(&self) -> Aabb {
        self.shapes.bounds()
    }

    fn mark(&self, hit: &Option<Hit>) -> u32 {
        hit.as_ref()
            .and_then(|hit| self.marks.get(hit.instance as usize).copied())
            .unwrap_or(0)
    }
}

/// A grid of square cells over a part of a picture.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PixelGrid {
    /// The camera, used as a pinhole.
    pub camera: Camera,
    /// The size of the whole picture in screen pixels.
    pub picture: UVec2,
    /// The first pixel of the part.
    pub min: UVec2,
    /// The pixel after the last one of the part, along either axis.
    pub max: UVec2,
    /// The edge length of a cell in pixels, above 0.
    pub step: u32,
}

impl PixelGrid {
    /// The part of a picture in which `bounds` is visible, with cells of one pixel. None if it is not visible at all.
    pub fn around(bounds: &Aabb, camera: Camera, picture: UVec2) -> Option<Self> {
        if bounds.is_empty() || picture.x == 0 || picture.y == 0 {
            return None;
        }
        let (mut least, mut largest) = (Vec2::INFINITY, Vec2::NEG_INFINITY);
        let (nearest, farthest) = camera.depth_range(bounds);
        if farthest <= 0.0 {
            return None;
        }
        for corner in 0..8 {
            let pick = |axis: usize| match corner >> axis & 1 {
                0 => bounds.min[axis],
                _ => bounds.max[axis],
            };
            let (film, _) = camera.project([pick(0), pick(1), pick(2)].into());
            (least, largest) = (least.min(film), largest.max(film));
        }
        // A box that reaches behind the camera may be visible anywhere.
        if nearest <= 0.0 || !(least.is_finite() && largest.is_finite()) {
            (least, largest) = (Vec2::ZERO, Vec2::ONE);
        }
        let size = picture.as_vec2();
        let min = ((least * size).floor() - 1.0).clamp(Vec2::ZERO, size).as_uvec2();
        let max = ((largest * size).ceil() + 1.0).clamp(Vec2::ZERO, size).as_uvec2();
        (min.x < max.x && min.y < max.y).then_some(Self {
            camera,
            picture,
            min,
            max,
            step: 1,
        })
    }

    /// The same part of the picture with larger cells, so that there are at most about `most`.
    pub fn with_cells(self, most: u32) -> Self {
        let pixels = self.max - self.min;
        let pixels = pixels.x as f32 * pixels.y as f32;
        let step = (pixels / most.max(1) as f32).sqrt().ceil() as u32;
        Self {
            step: step.max(1),
            ..self
        }
    }

    /// A grid of the same picture over both parts and the area between them.
    pub fn union(&self, other: &Self) -> Self {
        Self {
            min: self.min.min(other.min),
            max: self.max.max(other.max),
            ..*self
        }
    }

    /// The number of columns and rows.
    pub fn cells(&self) -> UVec2 {
        let pixels = self.max - self.min;
        UVec2::new(pixels.x.div_ceil(self.step), pixels.y.div_ceil(self.step))
    }

    /// The position of a point of the grid, in pixels from the corner of the picture; `cell` is in units of cells.
    fn pixel(&self, cell: Vec2) -> Vec2 {
        self.min.as_vec2() + cell * self.step as f32
    }

    /// The rays through sixteen points of the grid.
    fn rays(&self, cells: [Vec2; LANES]) -> RayLanes {
        let camera = self.camera.sharp();
        let film = cells.map(|cell| self.pixel(cell) / self.picture.as_vec2());
        let lanes = [film.map(|film| film.x), film.map(|film| film.y)].map(Lanes::new);
        camera
            .pinhole_rays(lanes)
            .unwrap_or_else(|| RayLanes::of(&film.map(|film| camera.ray(film, Vec2::ZERO))))
    }
}

/// A point of an edge.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EdgePoint {
    /// The position in pixels from the upper left corner of the picture.
    pub at: Vec2,
    /// The larger of the marks on both sides.
    pub mark: u32,
    /// Whether no shape of the scene hides the shape with that mark.
    pub visible: bool,
}

/// The samples along either side of a cell at an edge; their square is [`LANES`].
const FINE: u32 = 4;
/// The most cells at edges. A picture full of fur has more, of which an outline would be unreadable.
const MOST_EDGE_CELLS: usize = 200_000;
/// The fraction of the distance to a shape within which other shapes do not hide it.
const CLEARANCE: f32 = 1e-4;

/// A cell at an edge.
struct EdgeCell {
    place: UVec2,
    /// The marks of its samples, row by row.
    marks: [u32; LANES],
    /// The samples whose shape is visible, a bit each.
    visible: u32,
}

/// Points on the edges of `shapes`, at most a quarter of a cell of `grid` apart. `scene` is the geometry that may hide
/// them, except for the parts invisible by `sight`. None if `cancel` was set in the meantime, or if there are too many.
/// It uses all threads of the calling pool.
pub fn edges(
    shapes: &MarkedShapes,
    (scene, sight): (&Tlas, &Sight),
    grid: &PixelGrid,
    cancel: &AtomicBool,
) -> Option<Vec<EdgePoint>> {
    let UVec2 { x: width, y: height } = grid.cells();
    let mut marks = vec![0; width as usize * height as usize];
    (marks.par_chunks_exact_mut(width as usize).zip(0..height)).for_each(|(row, y)| {
        if !cancel.load(Ordering::Relaxed) {
            fill_row(shapes, grid, y, row);
        }
    });
    let places = edge_places(&marks, width, height);
    if cancel.load(Ordering::Relaxed) || places.len() > MOST_EDGE_CELLS {
        return None;
    }
    let cells: Option<Vec<EdgeCell>> = (places.par_iter().with_min_len(64))
        .map(|&place| (!cancel.load(Ordering::Relaxed)).then(|| EdgeCell::new(shapes, (scene, sight), grid, place)))
        .collect();
    let cells = cells?;
    let mut edge_cell = vec![NONE; marks.len()];
    for (number, cell) in (0..).zip(&cells) {
        edge_cell[(cell.place.y * width + cell.place.x) as usize] = number;
    }
    let found = Found {
        grid,
        width,
        height,
        marks: &marks,
        cells: &cells,
        edge_cell: &edge_cell,
    };
    let mut points = Vec::with_capacity(8 * cells.len());
    for cell in &cells {
        found.add_points_of(cell, &mut points);
    }
    Some(points)
}

const NONE: u32 = u32::MAX;

/// Traces the marks of a row of cells.
fn fill_row(shapes: &MarkedShapes, grid: &PixelGrid, y: u32, row: &mut [u32]) {
    for (chunk, cells) in row.chunks_mut(LANES).enumerate() {
        let first = (chunk * LANES) as f32;
        let rays = grid.rays(std::array::from_fn(|lane| {
            Vec2::new(first + lane as f32, y as f32) + 0.5
        }));
        let hits = shapes.shapes.intersect_packet(&rays, (1 << cells.len()) - 1);
        for (mark, hit) in cells.iter_mut().zip(&hits) {
            *mark = shapes.mark(hit);
        }
    }
}

/// The cells that have a neighbour of another mark.
fn edge_places(marks: &[u32], width: u32, height: u32) -> Vec<UVec2> {
    let row = |y: u32| &marks[(y * width) as usize..((y + 1) * width) as usize];
    let of_row = |y: u32| {
        let rows = [row(y.saturating_sub(1)), row(y), row((y + 1).min(height - 1))];
        let differs = move |x: u32| {
            let around = x.saturating_sub(1) as usize..=(x + 1).min(width - 1) as usize;
            let own = rows[1][x as usize];
            rows.iter()
                .any(|row| row[around.clone()].iter().any(|mark| *mark != own))
        };
        (0..width).filter(move |x| differs(*x)).map(move |x| UVec2::new(x, y))
    };
    (0..height).into_par_iter().flat_map_iter(of_row).collect()
}

impl EdgeCell {
    fn new(shapes: &MarkedShapes, (scene, sight): (&Tlas, &Sight), grid: &PixelGrid, place: UVec2) -> Self {
        let sample = |lane: usize| UVec2::new(lane as u32 % FINE, lane as u32 / FINE).as_vec2() + 0.5;
        let mut rays = grid.rays(std::array::from_fn(|lane| place.as_vec2() + sample(lane) / FINE as f32));
        let hits = shapes.shapes.intersect_packet(&rays, (1 << LANES) - 1);
        let marks = std::array::from_fn(|lane| shapes.mark(&hits[lane]));
        // One sample of each mark decides on the visibility of all samples with that mark.
        let is_first = |lane: usize| marks[lane] != 0 && !marks[..lane].contains(&marks[lane]);
        let firsts = (0..LANES)
            .filter(|lane| is_first(*lane))
            .fold(0, |bits, lane| bits | 1 << lane);
        sight.narrow_lanes(scene, &mut rays, firsts);
        let mut within = 0;
        for lane in each_lane(firsts) {
            let mut ray = rays.get(lane);
            let t = hits[lane].map_or(0.0, |hit| hit.t);
            within |= u32::from(ray.t_min <= t && t <= ray.t_max) << lane;
            ray.t_max = t * (1.0 - CLEARANCE);
            rays.set(lane, &ray);
        }
        let seen = within & !scene.occluded_packet(&rays, within);
        let seen_marks = |mark: u32| each_lane(seen).any(|lane| marks[lane] == mark);
        let visible = (0..LANES).filter(|lane| seen_marks(marks[*lane]));
        Self {
            place,
            marks,
            visible: visible.fold(0, |bits, lane| bits | 1 << lane),
        }
    }
}

/// The state of the search.
struct Found<'a> {
    grid: &'a PixelGrid,
    width: u32,
    height: u32,
    /// The mark of each cell, and (next) the index of its edge cell, if it is one.
    marks: &'a [u32],
    cells: &'a [EdgeCell],
    edge_cell: &'a [u32],
}

/// A sample: its mark, and whether its shape is visible, if known.
type Sample = (u32, Option<bool>);

impl Found<'_> {
    /// Adds the points between samples of a cell and their neighbours. Those to the left and above belong to the
    /// neighbouring cell there, if it is at an edge as well.
    fn add_points_of(&self, cell: &EdgeCell, points: &mut Vec<EdgePoint>) {
        let corner = (FINE * cell.place).as_ivec2();
        for lane in 0..LANES {
            let place = corner + UVec2::new(lane as u32 % FINE, lane as u32 / FINE).as_ivec2();
            let own = (cell.marks[lane], Some(cell.visible >> lane & 1 != 0));
            for (step, is_before) in [
                (glam::IVec2::X, false),
                (glam::IVec2::Y, false),
                (glam::IVec2::NEG_X, true),
                (glam::IVec2::NEG_Y, true),
            ] {
                let Some((other, is_edge)) = self.sample(place + step) else {
                    continue;
                };
                if other.0 == own.0 || (is_before && is_edge) {
                    continue;
                }
                let (mark, visible) = if other.0 > own.0 { other } else { own };
                let middle = place.as_vec2() + 0.5 + 0.5 * step.as_vec2();
                points.push(EdgePoint {
                    at: self.grid.pixel(middle / FINE as f32),
                    mark,
                    visible: visible.unwrap_or(cell.visible != 0),
                });
            }
        }
    }

    /// The sample at a position of the fine grid, and whether its cell is at an edge. None outside of the grid.
    fn sample(&self, place: glam::IVec2) -> Option<(Sample, bool)> {
        if place.min_element() < 0 {
            return None;
        }
        let (cell, within) = (place.as_uvec2() / FINE, place.as_uvec2() % FINE);
        if cell.x >= self.width || cell.y >= self.height {
            return None;
        }
        let index = (cell.y * self.width + cell.x) as usize;
        match self.cells.get(self.edge_cell[index] as usize) {
            Some(edge) => {
                let lane = (within.y * FINE + within.x) as usize;
                Some(((edge.marks[lane], Some(edge.visible >> lane & 1 != 0)), true))
            }
            None => Some(((self.marks[index], None), false)),
        }
    }
}
