//! Snapping of drags: to the grid, to corners and edges, and along surfaces.

use bevy::math::{Quat, Vec3};
use bevy_egui::egui::Pos2;

use super::Target;
use super::constraint::Constraint;
use super::drag::{Change, Drag, TYPED_SHARE};
use crate::app::editor::camera::rounding;
use crate::app::editor::camera::screen::Screen;
use crate::app::editor::camera::solid::Solid;

/// The smallest share of a move in one coordinate for which that coordinate snaps to the grid; below it the move is not
/// along the axis.
const LEAST_SHARE: f32 = 1e-3;

impl Drag {
    /// The move that puts the origin of the active object onto multiples of the step, in the coordinates that the move
    /// changes.
    pub(super) fn onto_grid(&self, moved: Vec3, step: f32) -> Vec3 {
        let origin = self.targets.last().map_or(self.frame.origin, Target::origin);
        let goal = rounding::rounded_place(origin + moved, f64::from(step));
        let moves = moved.abs().cmpgt(Vec3::splat(LEAST_SHARE * moved.length()));
        Vec3::select(moves, goal - origin, Vec3::ZERO)
    }

    /// The move that takes the nearest of `corners`, as moved by the pointer, to a place.
    pub fn onto_place(&mut self, screen: &Screen, pointer: Pos2, corners: &[Vec3], place: Vec3) -> Change {
        let free = self.moved(screen, pointer);
        let distance = |corner: &&Vec3| (**corner + free).distance(place);
        let nearest = corners.iter().min_by(|a, b| distance(a).total_cmp(&distance(b)));
        self.onto(screen, place - nearest.copied().unwrap_or(self.frame.origin))
    }

    /// The change that lays the selection onto a plane. `aligned_from`: the direction that is turned to the normal, if
    /// one is.
    pub fn onto_plane(
        &mut self,
        screen: &Screen,
        solids: &[Solid],
        place: Vec3,
        normal: Vec3,
        aligned_from: Option<Vec3>,
    ) -> Change {
        let aligned_from = aligned_from.filter(|_| self.constraint == Constraint::Free);
        let turn = aligned_from.map_or(Quat::IDENTITY, |up| Quat::from_rotation_arc(up, normal));
        let down = turn.inverse() * -normal;
        let origin = self.frame.origin;
        let below = solids.iter().map(|solid| solid.reach(down) - origin.dot(down));
        let by = place + normal * below.fold(0.0, f32::max) - origin;
        match self.onto(screen, by) {
            Change::Moved(by) if turn != Quat::IDENTITY => Change::Laid { turn, by },
            moved => moved,
        }
    }

    /// The part of a move that the constraint allows.
    fn onto(&mut self, screen: &Screen, by: Vec3) -> Change {
        let pixel = screen.units_per_point(screen.depth(self.frame.origin));
        self.unit = TYPED_SHARE * rounding::unit_of_pixel(pixel);
        Change::Moved(match self.constraint {
            Constraint::Axis(k) => by.project_onto_normalized(self.frame.axes[k]),
            Constraint::Plane(k) => by.reject_from_normalized(self.frame.axes[k]),
            Constraint::Free => by,
        })
    }
}
