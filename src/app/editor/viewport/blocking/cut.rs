//! Cutting doors and windows by a click on a wall or an upright box.

use bevy_egui::egui::Painter;

use super::hand::{BlockingModel, Hand};
use super::marks;
use crate::app::editor::camera::picking::SeenSurface;
use crate::app::editor::camera::screen::Screen;
use crate::app::editor::command::Command;
use crate::app::editor::command::blocking::openings::{self, Cut};
use crate::app::editor::command::blocking::{OpeningKind, Reshaping};
use crate::scene::Shape;

pub(super) fn follow(
    kind: OpeningKind,
    seen: Option<&SeenSurface>,
    model: &BlockingModel,
    hand: &Hand,
    commands: &mut Vec<Command>,
) {
    if hand.clicked
        && let Some((cut, target)) = under(kind, seen, model, hand.step).zip(model.target)
    {
        let (kind, pose) = cut.done();
        let flip_normals = target.shape.flip_normals;
        let shape = Shape { kind, flip_normals };
        commands.push(Command::Reshape(target.entity, shape, pose, Reshaping::Cut));
    }
}

pub(super) fn paint(
    painter: &Painter,
    screen: &Screen,
    kind: OpeningKind,
    seen: Option<&SeenSurface>,
    model: &BlockingModel,
    step: f32,
) {
    let Some(cut) = under(kind, seen, model, step) else {
        return;
    };
    let corners = cut.corners();
    let (near, far) = corners.split_at(4);
    marks::area(painter, screen, near);
    marks::ring(painter, screen, near);
    marks::ring(painter, screen, far);
    for (a, b) in near.iter().zip(far) {
        marks::segment(painter, screen, *a, *b);
    }
    let (from, sill) = (model.unit.text(cut.opening.from), model.unit.text(cut.opening.sill));
    marks::text(painter, screen, near[0], &format!("{from} from the start, {sill} up"));
}

fn under(kind: OpeningKind, seen: Option<&SeenSurface>, model: &BlockingModel, step: f32) -> Option<Cut> {
    let (seen, target) = (seen?, model.target?);
    if target.entity != seen.entity {
        return None;
    }
    openings::at(
        &target.shape.kind,
        &target.pose,
        seen.position,
        seen.normal,
        model.up,
        kind,
        step,
    )
}
