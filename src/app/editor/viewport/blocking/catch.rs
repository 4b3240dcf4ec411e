//! Snapping of the drawing tools to existing corners, edges and walls.

use bevy::math::Vec3;
use bevy_egui::egui::{Pos2, Vec2};

use super::hand::{BlockTarget, BlockingModel};
use super::spot::rounded;
use crate::app::editor::camera::picking::{self, SeenSurface};
use crate::app::editor::camera::screen::Screen;
use crate::app::editor::camera::snapping::nearest_on;
use crate::app::editor::command::blocking::BlockKind;
use crate::app::editor::command::blocking::block::{EDGES, Plane, corners};
use crate::engine::PackedScene;
use crate::scene::{ShapeKind, Solid};

/// A place that the pointer snaps to.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Caught {
    /// The place in the world.
    pub place: Vec3,
    /// Whether it is a corner or the end of a wall, and not a place on an edge or along a wall.
    pub is_corner: bool,
    /// Whether it is at the foot of its thing.
    pub is_low: bool,
}

/// The distances from the pointer within which it snaps to corners and edges, in points.
const CORNER: f32 = 10.0;
const EDGE: f32 = 4.0;
/// The number of directions around the pointer in which shapes are searched.
const AROUND: u32 = 8;
/// The share of its distance by which a place may be behind the visible surface and still count as visible.
const BEHIND: f32 = 2e-3;
/// A box lower than this number of usual grid steps is a slab: walls stand on its upper side, wherever the pointer is
/// on it.
const SLAB_STEPS: f32 = 3.0;

/// The shapes under the pointer and close around it.
pub(super) fn shapes_around(packed: &PackedScene, screen: &Screen, pointer: Pos2) -> Vec<bevy::prelude::Entity> {
    let angle = std::f32::consts::TAU / AROUND as f32;
    let around = (0..AROUND).map(|turn| 0.8 * CORNER * Vec2::angled(angle * turn as f32));
    let mut found = Vec::new();
    for off in std::iter::once(Vec2::ZERO).chain(around) {
        let seen = picking::seen_surface(packed, &screen.ray(pointer + off), |_| false);
        if let Some(seen) = seen.filter(|seen| !found.contains(&seen.entity)) {
            found.push(seen.entity);
        }
    }
    found
}

/// The corner near the pointer, else the place on an edge there. None without a step: Control turns off snapping to
/// corners as well as to the grid.
pub(super) fn caught(
    kind: BlockKind,
    screen: &Screen,
    pointer: Pos2,
    model: &BlockingModel,
    step: f32,
) -> Option<Caught> {
    if step <= 0.0 {
        return None;
    }
    let is_laid = kind != BlockKind::Box;
    let walls: Vec<[Vec3; 2]> = model.near.iter().filter_map(BlockTarget::foot_line).collect();
    let mut found = Marks::default();
    for target in model.near {
        match target.foot_line() {
            Some(line) if is_laid => found.lines.push(Mark::foot(line)),
            _ => found.add_box(target, is_laid, model),
        }
    }
    if is_laid {
        let ends = ends_of_walls(&walls, step).into_iter();
        found.corners.extend(ends.map(Mark::foot));
    }
    let ray = screen.ray(pointer);
    let distance = |place: Vec3| screen.project(place).map_or(f32::MAX, |at| at.distance(pointer));
    let nearest = |marks: Vec<Mark<Vec3>>, reach: f32| {
        let near = marks.into_iter().map(|mark| (distance(mark.what), mark));
        near.filter(|(distance, mark)| *distance <= reach && (mark.is_inside || is_seen(mark.what, screen, model)))
            .min_by(|(one, _), (other, _)| one.total_cmp(other))
            .map(|(_, mark)| mark)
    };
    let of = |mark: Mark<Vec3>, is_corner| Caught {
        place: mark.what,
        is_corner,
        is_low: mark.is_low,
    };
    if let Some(corner) = nearest(found.corners, CORNER) {
        return Some(of(corner, true));
    }
    let on_lines = found.lines.into_iter().map(|mark| Mark {
        what: along_line(mark.what, nearest_on(mark.what, &ray), model, step),
        is_low: mark.is_low,
        is_inside: mark.is_inside,
    });
    nearest(on_lines.collect(), EDGE).map(|place| of(place, false))
}

/// The place at the foot of a wall under the pointer, on its middle line: at an end if that is near, otherwise at a
/// point of the grid.
pub(super) fn foot(seen: &SeenSurface, screen: &Screen, model: &BlockingModel, step: f32) -> Option<Caught> {
    let line = model.target(seen.entity)?.foot_line()?;
    let way = line[1] - line[0];
    let share = (seen.position - line[0]).dot(way) / way.length_squared();
    let under = line[0] + way * share.clamp(0.0, 1.0);
    let of = |place: Vec3, is_corner: bool| Caught {
        place,
        is_corner,
        is_low: true,
    };
    if step <= 0.0 {
        return Some(of(under, false));
    }
    let walls: Vec<[Vec3; 2]> = model.near.iter().filter_map(BlockTarget::foot_line).collect();
    let reach = CORNER * screen.units_per_point(screen.depth(seen.position));
    let ends = ends_of_walls(&walls, step).into_iter();
    let end = ends
        .filter(|end| end.distance(under) <= reach)
        .min_by(|one, other| one.distance(under).total_cmp(&other.distance(under)));
    Some(match end {
        Some(end) => of(end, true),
        None => of(along_line(line, under, model, step), false),
    })
}

/// The base of a drawing that begins at the upright side of a box: the foot of the box, or the upper side of a slab.
/// None for other shapes.
pub(super) fn base(seen: &SeenSurface, model: &BlockingModel) -> Option<Vec3> {
    let corners = model.target(seen.entity).and_then(BlockTarget::corners)?;
    let [low, high] = range(corners, model.up);
    let level = if is_slab(high - low, model) { high } else { low };
    Some(seen.position + model.up * (level - seen.position.dot(model.up)))
}

impl BlockTarget {
    /// The middle line of a wall at its foot, in the world.
    pub(super) fn foot_line(&self) -> Option<[Vec3; 2]> {
        match self.shape.kind {
            ShapeKind::Solid(Solid::Wall { length, .. }) => {
                Some([Vec3::ZERO, Vec3::X * length].map(|end| self.pose.transform_point3(end)))
            }
            _ => None,
        }
    }

    /// The corners of a box, in the order of [`EDGES`]. The sides of a prism or a roof are not those of the box around
    /// it.
    fn corners(&self) -> Option<[Vec3; 8]> {
        match &self.shape.kind {
            ShapeKind::Solid(Solid::Prism { .. }) => None,
            ShapeKind::Solid(part) if part.roof().is_some() => None,
            kind => corners(kind, &self.pose),
        }
    }
}

/// The candidates for snapping.
#[derive(Default)]
struct Marks {
    corners: Vec<Mark<Vec3>>,
    lines: Vec<Mark<[Vec3; 2]>>,
}

struct Mark<T> {
    what: T,
    is_low: bool,
    /// Whether it lies inside of its shape, where it is never visible itself.
    is_inside: bool,
}

impl<T> Mark<T> {
    fn foot(what: T) -> Self {
        Self {
            what,
            is_low: true,
            is_inside: true,
        }
    }

    fn on_box(what: T, is_low: bool) -> Self {
        Self {
            what,
            is_low,
            is_inside: false,
        }
    }
}

impl Marks {
    /// The corners and edges of a box or a rectangle. Of a slab only the upper ones for a drawing that lies on it.
    fn add_box(&mut self, target: &BlockTarget, is_laid: bool, model: &BlockingModel) {
        if target.shape.kind == ShapeKind::Rectangle {
            let corner = |x: f32, y: f32| target.pose.transform_point3(Vec3::new(x, y, 0.0));
            let ring = [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)].map(|(x, y)| corner(x, y));
            let next = ring.iter().cycle().skip(1);
            let edges = ring.iter().zip(next).map(|(a, b)| [*a, *b]);
            self.lines.extend(edges.take(4).map(|edge| Mark::on_box(edge, false)));
            self.corners.extend(ring.map(|corner| Mark::on_box(corner, false)));
            return;
        }
        let Some(corners) = target.corners() else { return };
        let [low, high] = range(corners, model.up);
        let is_high = |place: Vec3| place.dot(model.up) > high - 1e-3 * (high - low);
        let is_low = |place: Vec3| place.dot(model.up) < low + 1e-3 * (high - low);
        let is_upper_only = is_laid && is_slab(high - low, model);
        let counts = |place: Vec3| !is_upper_only || is_high(place);
        let places = corners.into_iter().filter(|corner| counts(*corner));
        self.corners
            .extend(places.map(|corner| Mark::on_box(corner, is_low(corner))));
        let edges = EDGES.map(|[a, b]| [corners[a], corners[b]]).into_iter();
        let edges = edges.filter(|[a, b]| counts(*a) && counts(*b));
        self.lines
            .extend(edges.map(|[a, b]| Mark::on_box([a, b], is_low(a) && is_low(b))));
    }
}

fn range(corners: [Vec3; 8], up: Vec3) -> [f32; 2] {
    let heights = corners.map(|corner| corner.dot(up));
    let low = heights.into_iter().fold(f32::MAX, f32::min);
    [low, heights.into_iter().fold(f32::MIN, f32::max)]
}

fn is_slab(height: f32, model: &BlockingModel) -> bool {
    height <= SLAB_STEPS * model.step
}

/// The corners where middle lines of walls meet, and the ends of walls that meet no other. A joint lengthens one wall
/// beyond the corner at which both were drawn, and shortens the other.
fn ends_of_walls(walls: &[[Vec3; 2]], step: f32) -> Vec<Vec3> {
    /// The steps of the grid by which a joint lengthens or shortens walls: half the thickness of usual ones, and more
    /// at sharp angles.
    const JOINT: f32 = 3.0;
    let near = JOINT * step;
    let mut meetings = Vec::new();
    for (first, a) in walls.iter().enumerate() {
        for b in &walls[first + 1..] {
            meetings.extend(meeting(*a, *b, near));
        }
    }
    let is_free = |end: &Vec3| !meetings.iter().any(|meeting: &Vec3| meeting.distance(*end) <= near);
    let free: Vec<Vec3> = walls.iter().flatten().copied().filter(is_free).collect();
    meetings.extend(free);
    meetings
}

/// The place where two lines in a plane cross, if it is on both or no farther than `near` from their ends.
fn meeting(a: [Vec3; 2], b: [Vec3; 2], near: f32) -> Option<Vec3> {
    let (ways, between) = ([a[1] - a[0], b[1] - b[0]], b[0] - a[0]);
    let lengths = ways.map(Vec3::length);
    let [u, v] = [ways[0] / lengths[0], ways[1] / lengths[1]];
    let cosine = u.dot(v);
    let sine_squared = 1.0 - cosine * cosine;
    let along_a = (between.dot(u) - cosine * between.dot(v)) / sine_squared;
    let along_b = (cosine * between.dot(u) - between.dot(v)) / sine_squared;
    let (on_a, on_b) = (a[0] + u * along_a, b[0] + v * along_b);
    let is_within = |along: f32, length: f32| (-near..=length + near).contains(&along);
    let meets = sine_squared > 0.01
        && is_within(along_a, lengths[0])
        && is_within(along_b, lengths[1])
        && on_a.distance(on_b) <= 0.01 * near;
    meets.then_some(on_a)
}

/// The place of a line that is nearest to a point of the grid near this place, and not beyond the line's ends.
fn along_line([a, b]: [Vec3; 2], place: Vec3, model: &BlockingModel, step: f32) -> Vec3 {
    let way = b - a;
    let direction = way.normalize_or_zero();
    let on_grid = Plane::of_normal(model.up, model.up);
    let level = rounded(place, &on_grid, model.step, step);
    // Edges that go upwards have their points at multiples of the step as well.
    let height = crate::app::editor::command::blocking::snapped(place.dot(model.up), step);
    let point = level + model.up * (height - level.dot(model.up)) * direction.dot(model.up).abs();
    a + direction * (point - a).dot(direction).clamp(0.0, way.length())
}

/// Whether no surface hides a place.
fn is_seen(place: Vec3, screen: &Screen, model: &BlockingModel) -> bool {
    let Some(at) = screen.project(place) else {
        return false;
    };
    let seen = picking::seen_surface(model.packed, &screen.ray(at), |_| false);
    let depth = screen.depth(place);
    seen.is_none_or(|seen| screen.depth(seen.position) >= (1.0 - BEHIND) * depth)
}
