//! Places on the ground and on surfaces, on the points of the grid.

use bevy::math::Vec3;
use bevy_egui::egui::Pos2;

use super::catch::{self, Caught};
use super::floor;
use super::hand::{BlockingModel, Hand};
use crate::app::editor::camera::picking::SeenSurface;
use crate::app::editor::camera::screen::Screen;
use crate::app::editor::command::blocking::block::Plane;
use crate::app::editor::command::blocking::{BlockKind, snapped};

/// A place where a drawing can begin.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Spot {
    pub place: Vec3,
    pub plane: Plane,
}

/// The share of a step to which places across a plane are rounded, so that a surface at 0 is not at 0.0000001.
const ROUNDING: f32 = 1e-3;
/// The largest distance of the ground, in steps of the grid.
const FARTHEST: f32 = 2000.0;

/// The least cosine between the upward direction and the normal of a surface on which walls and floors are placed;
/// others are sides.
const LAID: f32 = 0.5;

impl Spot {
    /// The place under the pointer: the corner or edge that it snaps to, else the floor at the foot of a wall, else the
    /// surface that is seen there, else the ground through the origin. Walls and floors lie level at the foot of a wall
    /// or beside a box.
    pub fn under(
        kind: BlockKind,
        hand: &Hand,
        seen: Option<&SeenSurface>,
        caught: Option<Caught>,
        screen: &Screen,
        model: &BlockingModel,
    ) -> Option<Self> {
        let (up, is_laid) = (model.up, kind != BlockKind::Box);
        let level = Plane::of_normal(up, up);
        let floor = seen.and_then(|seen| floor::at_foot(seen, hand, screen, model));
        if let Some(caught) = caught {
            let seen = seen.filter(|_| !is_laid && !caught.is_low);
            let surface = seen.map(|seen| (seen.position, Plane::of_normal(seen.normal, up)));
            let surfaces = floor.filter(|_| !is_laid).into_iter().chain(surface);
            let plane = surfaces
                .filter(|(place, plane)| is_on(plane, *place, caught.place, model.step))
                .map(|(_, plane)| plane)
                .next();
            return Some(Self {
                place: caught.place + Vec3::ZERO,
                plane: plane.unwrap_or(level),
            });
        }
        let foot = || catch::foot(seen.filter(|_| is_laid)?, screen, model, hand.step);
        if let Some(foot) = foot() {
            return Some(Self {
                place: foot.place + Vec3::ZERO,
                plane: level,
            });
        }
        let (place, plane) = match seen {
            Some(seen) if is_laid && seen.normal.dot(up).abs() < LAID => {
                let base = catch::base(seen, model).map(|place| (place, level));
                base.or(floor).unwrap_or((seen.position, level))
            }
            Some(seen) => floor.unwrap_or_else(|| (seen.position, Plane::of_normal(seen.normal, up))),
            None => {
                let place = on_plane(screen, hand.pointer, Vec3::ZERO, up)?;
                let is_at_horizon = screen.depth(place) > FARTHEST * model.step;
                if is_at_horizon && !screen.camera.is_orthographic() {
                    return None;
                }
                (place, level)
            }
        };
        Some(Self {
            place: rounded(place, &plane, model.step, hand.step),
            plane,
        })
    }
}

/// Whether a place is on the plane through another one, up to a small part of a step of the grid.
pub(super) fn is_on(plane: &Plane, through: Vec3, place: Vec3, grid: f32) -> bool {
    const OFF: f32 = 0.02;
    (place - through).dot(plane.normal).abs() <= OFF * grid
}

/// The point of a plane under the pointer; None if the pointer is above the plane's horizon.
pub(in crate::app::editor::viewport) fn on_plane(
    screen: &Screen,
    pointer: Pos2,
    through: Vec3,
    normal: Vec3,
) -> Option<Vec3> {
    let ray = screen.ray(pointer);
    let towards = ray.dir.dot(normal);
    let t = (through - ray.origin).dot(normal) / towards;
    let is_seen = t.is_finite() && t > 0.0 && towards.abs() > 1e-4 * ray.dir.length();
    is_seen.then(|| ray.at(t))
}

/// The point of the plane's grid nearest to a place of the plane. The grid is that of the world: its points are
/// multiples of the step.
pub(super) fn rounded(place: Vec3, plane: &Plane, grid: f32, step: f32) -> Vec3 {
    let (along, across) = (plane.along, plane.across());
    let above = snapped(place.dot(plane.normal), ROUNDING * grid);
    let level = [along, across].map(|direction| direction * snapped(place.dot(direction), step));
    let place = level[0] + level[1] + plane.normal * above;
    // Adding zero turns -0 into 0 for files.
    place + Vec3::ZERO
}
