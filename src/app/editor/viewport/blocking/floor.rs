//! The foot of a wall: near the edge between wall and floor the pointer means the floor.

use bevy::math::Vec3;
use bevy_egui::egui::Vec2;

use super::hand::{BlockingModel, Hand};
use super::spot::on_plane;
use crate::app::editor::camera::picking::{self, SeenSurface};
use crate::app::editor::camera::screen::Screen;
use crate::app::editor::command::blocking::block::Plane;

/// The distance from the pointer down to the foot of a wall within which it means the floor, in points.
const REACH: f32 = 10.0;
/// The number of points within that distance at which the floor is searched.
const PROBES: u32 = 5;
/// The largest cosine between the upward direction and the normal of a wall, and the least one of a floor.
const WALL: f32 = 0.3;
const FLOOR: f32 = 0.9;

/// The place where the wall under the pointer meets the floor, with the plane of the floor, if the pointer is a few
/// points above it: a drawing that began on the wall and went down or towards the viewer would go through the floor.
/// None elsewhere, and with Control, which gives the surface under the pointer alone.
pub(super) fn at_foot(
    seen: &SeenSurface,
    hand: &Hand,
    screen: &Screen,
    model: &BlockingModel,
) -> Option<(Vec3, Plane)> {
    if hand.step <= 0.0 || seen.normal.dot(model.up).abs() > WALL {
        return None;
    }
    let point = screen.units_per_point(screen.depth(seen.position));
    let below = screen.project(seen.position - model.up * point)?;
    let down = (below - screen.project(seen.position)?).normalized();
    if down == Vec2::ZERO {
        return None;
    }
    let probes = (1..=PROBES).map(|probe| REACH * probe as f32 / PROBES as f32);
    let floors = probes.filter_map(|off| {
        let at = hand.pointer + off * down;
        match picking::seen_surface(model.packed, &screen.ray(at), |_| false) {
            Some(floor) => (floor.normal.dot(model.up) >= FLOOR).then_some((floor.position, floor.normal)),
            None => Some((on_plane(screen, at, Vec3::ZERO, model.up)?, model.up)),
        }
    });
    let foot = |(floor, normal): (Vec3, Vec3)| {
        let height = (seen.position - floor).dot(normal) / model.up.dot(normal);
        let foot = seen.position - model.up * height;
        let is_near = screen.project(foot)?.distance(hand.pointer) <= REACH + 1.0;
        (height >= 0.0 && is_near).then(|| (foot, Plane::of_normal(normal, model.up)))
    };
    floors.filter_map(foot).next()
}
