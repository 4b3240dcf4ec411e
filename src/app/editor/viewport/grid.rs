//! The grid on the ground and the axes of the world, drawn over the picture where no surface hides them.
//!
//! Lines fade where they would be too close to each other on the screen, so the far end of the grid vanishes and no
//! level of it appears or disappears all at once.

use std::sync::Arc;

use bevy::math::{Vec2, Vec3};
use bevy_egui::egui::{self, Color32, Id, Mesh, Pos2, Rect, Shape};

use crate::app::editor::camera::ground::GridPlane;
use crate::app::editor::camera::screen::Screen;
use crate::app::editor::command::grid_settings::GridSettings;
use crate::app::editor::picture::axis_colors::AXIS_COLORS;
use crate::app::editor::picture::depths::Depths;

/// The number of lines of each level on either side of the middle.
const LINES: i32 = 60;
/// Each level has lines ten times as far apart as the one before.
const LEVELS: u32 = 3;
/// Lines become visible while their distance on the screen, in points, grows from the first of these numbers to the
/// second.
const APPEAR: [f32; 2] = [9.0, 40.0];
/// Lines become stronger while their distance on the screen grows from the first of these numbers to the second.
const STRONG: [f32; 2] = [70.0, 300.0];
/// The opacity that lines gain while they become visible, and then while they become stronger.
const FAINT: f32 = 0.16;
const FIRM: f32 = 0.16;
const AXIS: f32 = 0.75;
/// The distance along a line, in points, between two places where the depth of the picture is looked up.
const LOOK: f32 = 4.0;
/// The most such places from one vertex of a line to the next.
const MOST_LOOKS: usize = 12;
/// A point counts as on a surface within this share of its distance from the camera.
const ON_SURFACE: f32 = 2e-3;

/// The last drawn grid with its inputs.
#[derive(Clone)]
struct Drawn {
    screen: Screen,
    up: Vec3,
    settings: GridSettings,
    depths: [u64; 2],
    mesh: Arc<Mesh>,
}

/// Draws the grid over the picture of a view, which `id` names. `up` is the world's upward axis. While neither the view
/// nor the picture changes, it is the mesh of the last frame.
pub(crate) fn paint(
    painter: &egui::Painter,
    id: Id,
    screen: &Screen,
    up: Vec3,
    settings: &GridSettings,
    depths: Depths,
) {
    if !settings.shown {
        return;
    }
    let id = id.with("grid over the picture");
    let version = depths.version();
    let last: Option<Drawn> = painter.ctx().data(|data| data.get_temp(id));
    let is_same = |last: &Drawn| {
        (last.screen, last.up, last.settings) == (*screen, up, *settings) && Some(last.depths) == version
    };
    if let Some(last) = last.filter(is_same) {
        painter.add(Shape::Mesh(last.mesh));
        return;
    }
    let mesh = Arc::new(mesh(screen, up, settings, depths));
    if let Some(depths) = version {
        let drawn = Drawn {
            screen: *screen,
            up,
            settings: *settings,
            depths,
            mesh: mesh.clone(),
        };
        painter.ctx().data_mut(|data| data.insert_temp(id, drawn));
    }
    painter.add(Shape::Mesh(mesh));
}

/// The triangles of all lines.
pub fn mesh(screen: &Screen, up: Vec3, settings: &GridSettings, depths: Depths) -> Mesh {
    let plane = GridPlane::of(screen, up);
    let middle = plane.middle(screen);
    let step = plane.step(screen, settings);
    let mut lines = Lines {
        view: View::new(screen, depths),
        plane,
        middle,
        mesh: Mesh::default(),
    };
    for (along, across) in [(0, 1), (1, 0)] {
        for level in 0..LEVELS {
            lines.level(along, across, level, step);
        }
    }
    let reach = step * 10f32.powi(LEVELS as i32 - 1) * LINES as f32;
    for axis in [Vec3::X, Vec3::Y, Vec3::Z] {
        lines.axis(axis, reach);
    }
    lines.mesh
}

/// The data of the view that every point of a line needs.
struct View<'v> {
    screen: &'v Screen,
    depths: Depths<'v>,
    /// The place of a perspective camera; None if rays are parallel.
    eye: Option<Vec3>,
    /// World units from one pixel of the depths to the next, at distance 1 in a perspective.
    pixel: f32,
}

impl<'v> View<'v> {
    fn new(screen: &'v Screen, depths: Depths<'v>) -> Self {
        let eye = (!screen.camera.is_orthographic()).then(|| screen.camera.unproject(Vec2::splat(0.5), 0.0));
        let pixel = screen.units_per_point(1.0) * screen.picture.width() / depths.width().max(1) as f32;
        Self {
            screen,
            depths,
            eye,
            pixel,
        }
    }

    /// Whether the picture shows no surface before a point of a plane with this normal.
    fn sees(&self, at: Pos2, world: Vec3, normal: Vec3) -> bool {
        let film = self.screen.film(at);
        let Some(seen) = self.depths.at(film) else {
            return true;
        };
        let way = world - self.eye.unwrap_or_else(|| self.screen.camera.unproject(film, 0.0));
        let distance = way.length();
        // The width of a pixel at that distance, times the slope of the plane, is how much the depth of the plane
        // varies within the pixel.
        let width = self.pixel * self.eye.map_or(1.0, |_| distance);
        let grazing = (way.dot(normal) / distance).abs().max(1e-3);
        distance <= seen + ON_SURFACE * distance + width / grazing
    }
}

struct Lines<'v> {
    view: View<'v>,
    plane: GridPlane,
    middle: Vec3,
    mesh: Mesh,
}

/// A line of the grid that is being drawn.
#[derive(Clone, Copy)]
struct Line {
    /// A point of the line, from which `reach` is measured.
    middle: Vec3,
    /// The unit direction.
    along: Vec3,
    /// The vector to the next line.
    across: Vec3,
    /// The length in both directions, in world units.
    reach: f32,
    /// The normal of the line's plane.
    normal: Vec3,
    color: Color32,
    style: Style,
}

#[derive(Clone, Copy, PartialEq)]
enum Style {
    Grid,
    Axis,
}

impl Lines<'_> {
    /// The lines of a level along one axis of the plane, without those that a coarser level has.
    fn level(&mut self, along: usize, across: usize, level: u32, step: f32) {
        let [along, across] = [along, across].map(|axis| self.plane.axes[axis]);
        let step = step * 10f32.powi(level as i32);
        let first = (self.middle.dot(across) / step).round();
        // Farther away, single precision cannot tell neighbouring numbers of steps apart.
        if first.is_nan() || first.abs() > 1e6 {
            return;
        }
        let is_last = level + 1 == LEVELS;
        for line in first as i32 - LINES..=first as i32 + LINES {
            if line == 0 || (!is_last && line % 10 == 0) {
                continue;
            }
            let off = across * (line as f32 * step - self.middle.dot(across));
            self.line(Line {
                middle: self.middle + off,
                along,
                across: across * step,
                reach: step * LINES as f32,
                normal: self.plane.normal,
                color: Color32::WHITE,
                style: Style::Grid,
            });
        }
    }

    fn axis(&mut self, axis: Vec3, reach: f32) {
        let is_across = self.plane.normal.dot(axis).abs() > 0.5;
        if is_across && self.view.eye.is_none() && self.view.screen.forward().dot(axis).abs() > 0.999 {
            return;
        }
        // The axis at right angles to the plane lies in no plane of the grid, so that any normal towards the viewer
        // will do.
        let normal = match is_across {
            true => axis.cross(self.view.screen.forward()).cross(axis).normalize_or_zero(),
            false => self.plane.normal,
        };
        self.line(Line {
            middle: axis * axis.dot(self.middle),
            along: axis,
            across: Vec3::ZERO,
            reach,
            normal,
            color: AXIS_COLORS[axis.max_position()],
            style: Style::Axis,
        });
    }

    fn line(&mut self, line: Line) {
        let ends = [-line.reach, line.reach].map(|along| line.middle + line.along * along);
        let Some(part) = VisiblePart::of(self.view.screen, ends) else {
            return;
        };
        let length = part.points[0].distance(part.points[1]);
        let looks = ((length / LOOK).ceil() as usize).clamp(1, 4096);
        let mut strip = Strip::new(&mut self.mesh, part.points, line.style);
        let mut since_vertex = MOST_LOOKS;
        let mut was_visible = false;
        for look in 0..=looks {
            let (at, world) = part.at(look as f32 / looks as f32);
            let is_visible = self.view.sees(at, world, line.normal);
            since_vertex += 1;
            if is_visible && (since_vertex >= MOST_LOOKS || !was_visible || look == looks) {
                strip.vertex(at, line.color, opacity(self.view.screen, &line, world, at));
                since_vertex = 0;
            } else if was_visible && !is_visible {
                let (at, world) = part.at((look as f32 - 0.5) / looks as f32);
                strip.vertex(at, line.color, opacity(self.view.screen, &line, world, at));
                strip.interrupt();
            }
            was_visible = is_visible;
        }
    }
}

/// The opacity of a line at a point of it.
fn opacity(screen: &Screen, line: &Line, world: Vec3, at: Pos2) -> f32 {
    let share = (world - line.middle).dot(line.along) / line.reach;
    let inside = 1.0 - share * share;
    if line.style == Style::Axis {
        return AXIS * inside.max(0.0);
    }
    let (Some(beside), Some(ahead)) = (
        screen.project(world + line.across),
        screen.project(world + line.along * line.across.length()),
    ) else {
        return 0.0;
    };
    let direction = (ahead - at).normalized();
    let way = beside - at;
    let apart = (way.x * direction.y - way.y * direction.x).abs();
    let strength = FAINT * ramp(apart, APPEAR) + FIRM * ramp(apart, STRONG);
    strength * inside.clamp(0.0, 1.0)
}

/// From 0 at `from` or below to 1 at `to`, smoothly.
fn ramp(x: f32, [from, to]: [f32; 2]) -> f32 {
    let t = ((x - from) / (to - from)).clamp(0.0, 1.0);
    t * t * (3.0 - 2.0 * t)
}

/// The part of a segment in world space that is in the picture.
struct VisiblePart {
    points: [Pos2; 2],
    /// Distances along the view axis.
    depths: [f32; 2],
    world: [Vec3; 2],
    is_parallel: bool,
}

impl VisiblePart {
    fn of(screen: &Screen, ends: [Vec3; 2]) -> Option<Self> {
        let depths = ends.map(|end| screen.depth(end));
        let nearest = 1e-3 * depths[0].abs().max(depths[1].abs()).max(1e-6);
        // Depth is linear along the segment: an end behind the camera moves to just before it.
        let cut = |from: usize, to: usize| match depths[from] >= nearest {
            true => Some((ends[from], depths[from])),
            false if depths[to] > nearest => {
                let share = (nearest - depths[from]) / (depths[to] - depths[from]);
                Some((ends[from].lerp(ends[to], share), nearest))
            }
            false => None,
        };
        let ((a, depth_a), (b, depth_b)) = (cut(0, 1)?, cut(1, 0)?);
        let points = [screen.project(a)?, screen.project(b)?];
        let whole = Self {
            points,
            depths: [depth_a, depth_b],
            world: [a, b],
            is_parallel: screen.camera.is_orthographic(),
        };
        let [from, to] = inside(screen.picture, points)?;
        let (start, end) = (whole.at(from), whole.at(to));
        Some(Self {
            points: [start.0, end.0],
            depths: [start.1, end.1].map(|world| screen.depth(world)),
            world: [start.1, end.1],
            ..whole
        })
    }

    /// The point at a share of the visible part on the screen, and its place in the world.
    fn at(&self, share: f32) -> (Pos2, Vec3) {
        let [a, b] = self.points;
        let [near, far] = self.depths;
        let in_world = match self.is_parallel {
            true => share,
            // One over the depth is linear on the screen.
            false => share * near / (far + share * (near - far)),
        };
        (a + (b - a) * share, self.world[0].lerp(self.world[1], in_world))
    }
}

/// The range of the segment from `a` to `b` inside a rectangle, as shares of its length (Liang and Barsky 1984); None
/// if it misses the rectangle.
fn inside(rect: Rect, [a, b]: [Pos2; 2]) -> Option<[f32; 2]> {
    let way = b - a;
    let (mut from, mut to) = (0.0f32, 1.0f32);
    for (start, step, min, max) in [
        (a.x, way.x, rect.left(), rect.right()),
        (a.y, way.y, rect.top(), rect.bottom()),
    ] {
        if step == 0.0 {
            if start < min || start > max {
                return None;
            }
            continue;
        }
        let ends = [(min - start) / step, (max - start) / step];
        from = from.max(ends[0].min(ends[1]));
        to = to.min(ends[0].max(ends[1]));
    }
    (from < to).then_some([from, to])
}

/// A line one point wide with soft edges and a dark line beside it, so that it is visible on bright pictures as well.
struct Strip<'m> {
    mesh: &'m mut Mesh,
    /// The vector across the line towards the dark line, one point long.
    side: egui::Vec2,
    /// The opacity of the dark line as a share of that of the line.
    shadow: f32,
    goes_on: bool,
}

/// The places of a strip's vertices across it, in points: edge, line, dark line, edge.
const ACROSS: [f32; 4] = [-1.0, 0.0, 1.0, 2.0];
/// The opacity of the dark line, as a share of that of the line; the colours of axes need little help.
const SHADOW: f32 = 0.7;
const AXIS_SHADOW: f32 = 0.2;

impl<'m> Strip<'m> {
    fn new(mesh: &'m mut Mesh, [a, b]: [Pos2; 2], style: Style) -> Self {
        let side = (b - a).normalized().rot90();
        // The dark line is below or at the right.
        let is_above = side.y < -1e-3 || (side.y <= 1e-3 && side.x < 0.0);
        Self {
            mesh,
            side: if is_above { -side } else { side },
            shadow: if style == Style::Axis { AXIS_SHADOW } else { SHADOW },
            goes_on: false,
        }
    }

    fn vertex(&mut self, at: Pos2, color: Color32, opacity: f32) {
        let first = self.mesh.vertices.len() as u32;
        let rows = ACROSS.len() as u32;
        let colors = [
            Color32::TRANSPARENT,
            color.gamma_multiply(opacity),
            Color32::BLACK.gamma_multiply(self.shadow * opacity),
            Color32::TRANSPARENT,
        ];
        for (across, color) in ACROSS.into_iter().zip(colors) {
            self.mesh.colored_vertex(at + self.side * across, color);
        }
        if self.goes_on && first >= rows {
            for edge in 0..rows - 1 {
                let (a, b) = (first - rows + edge, first + edge);
                self.mesh.add_triangle(a, a + 1, b);
                self.mesh.add_triangle(a + 1, b + 1, b);
            }
        }
        self.goes_on = true;
    }

    fn interrupt(&mut self) {
        self.goes_on = false;
    }
}
