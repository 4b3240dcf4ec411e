//! Cutting doors and windows into a wall or an upright box: a click cuts one of the usual size, a drag draws one.

use bevy::math::Vec3;
use bevy_egui::egui::{Painter, Pos2};

use super::hand::{BlockTarget, BlockingModel, Hand, is_drag};
use super::{marks, spot};
use crate::app::editor::camera::picking::SeenSurface;
use crate::app::editor::camera::screen::Screen;
use crate::app::editor::command::blocking::openings::{self, Cut, Side};
use crate::app::editor::command::blocking::{OpeningKind, Reshaping};
use crate::app::editor::command::{Command, SceneEdit};
use crate::app::editor::viewport::gizmo::typed::Typed;
use crate::scene::{LengthUnit, Shape};

/// The state of the cutting tool.
#[derive(Clone, Debug, Default, PartialEq)]
pub(in crate::app::editor::viewport) struct CutState {
    begun: Option<Begun>,
}

/// An opening that is being drawn.
#[derive(Clone, Debug, PartialEq)]
struct Begun {
    /// The wall as it was at the press.
    target: BlockTarget,
    /// The point of the press in the world, and the normal there.
    place: Vec3,
    normal: Vec3,
    pressed_at: Pos2,
    pointer: Pos2,
    typed: Typed,
}

impl CutState {
    pub fn is_busy(&self) -> bool {
        self.begun.is_some()
    }

    pub fn typed(&mut self) -> Option<&mut Typed> {
        self.begun.as_mut().map(|begun| &mut begun.typed)
    }

    pub fn cancel(&mut self) {
        self.begun = None;
    }

    /// The hint for the next step while an opening is drawn.
    pub fn hint(&self) -> Option<&'static str> {
        self.begun.as_ref().map(|_| {
            "Let go at once for one of the usual size, or at the opposite corner, or type its size, such as 1.8,1.3 and Enter (Esc: give it up)"
        })
    }

    /// Follows the mouse; returns whether the left button is used by the tool.
    pub fn follow(
        &mut self,
        kind: OpeningKind,
        seen: Option<&SeenSurface>,
        screen: &Screen,
        model: &BlockingModel,
        hand: &Hand,
        commands: &mut Vec<Command>,
    ) -> bool {
        if hand.pressed
            && let Some(seen) = seen
            && let Some(target) = model.target(seen.entity)
            && usual(kind, seen, model, hand.step).is_some()
        {
            self.begun = Some(Begun {
                target: target.clone(),
                place: seen.position,
                normal: seen.normal,
                pressed_at: hand.pointer,
                pointer: hand.pointer,
                typed: Typed::default(),
            });
        }
        let Some(begun) = &mut self.begun else {
            return false;
        };
        begun.pointer = hand.pointer;
        if !hand.down {
            self.confirm(kind, screen, model, hand.step, commands);
        }
        true
    }

    /// Cuts the drawn opening.
    pub fn confirm(
        &mut self,
        kind: OpeningKind,
        screen: &Screen,
        model: &BlockingModel,
        step: f32,
        commands: &mut Vec<Command>,
    ) {
        let Some(begun) = self.begun.take() else { return };
        if let Some(cut) = begun.cut(kind, screen, model, step) {
            let (kind, pose) = cut.done();
            let shape = Shape {
                kind,
                ..begun.target.shape
            };
            commands.push(SceneEdit::Reshape(begun.target.entity, shape, pose, Reshaping::Cut).into());
        }
    }

    pub fn paint(
        &self,
        painter: &Painter,
        screen: &Screen,
        kind: OpeningKind,
        seen: Option<&SeenSurface>,
        model: &BlockingModel,
        step: f32,
    ) {
        let cut = match &self.begun {
            Some(begun) => begun.cut(kind, screen, model, step),
            None => seen.and_then(|seen| usual(kind, seen, model, step)),
        };
        let Some(cut) = cut else { return };
        let corners = cut.corners();
        let (near, far) = corners.split_at(4);
        marks::area(painter, screen, near);
        marks::ring(painter, screen, near);
        marks::ring(painter, screen, far);
        for (a, b) in near.iter().zip(far) {
            marks::segment(painter, screen, *a, *b);
        }
        let typed = self.begun.as_ref().map_or("", |begun| begun.typed.text());
        marks::text(painter, screen, near[0], &caption(&cut, kind, typed, model.unit));
    }
}

impl Begun {
    fn cut(&self, kind: OpeningKind, screen: &Screen, model: &BlockingModel, step: f32) -> Option<Cut> {
        let side = Side {
            place: self.place,
            normal: self.normal,
            up: model.up,
        };
        let (shape, pose) = (&self.target.shape.kind, &self.target.pose);
        let size = self.typed.lengths(model.unit);
        if size.is_none() && !is_drag(self.pressed_at, self.pointer) {
            return openings::at(shape, pose, &side, kind, step);
        }
        let to = spot::on_plane(screen, self.pointer, self.place, self.normal)?;
        openings::between(shape, pose, &side, to, size.as_deref().unwrap_or_default(), kind, step)
    }
}

/// The opening of the usual size at a place.
fn usual(kind: OpeningKind, seen: &SeenSurface, model: &BlockingModel, step: f32) -> Option<Cut> {
    let target = model.target(seen.entity)?;
    let side = Side {
        place: seen.position,
        normal: seen.normal,
        up: model.up,
    };
    openings::at(&target.shape.kind, &target.pose, &side, kind, step)
}

/// The opening's name, its size and place, and the typed text.
pub(super) fn caption(cut: &Cut, kind: OpeningKind, typed: &str, unit: LengthUnit) -> String {
    let of = |length: f32| unit.text(length);
    let [wide, high, from, sill] = cut.sizes().map(of);
    let name = cut.name(kind);
    let place = match cut.is_hole {
        true => format!("{from} and {sill} from the corner"),
        false if cut.opening.sill == 0.0 => format!("{from} from the start"),
        false => format!("{from} from the start, {sill} up"),
    };
    let typed = if typed.is_empty() {
        String::new()
    } else {
        format!("   [{typed}]")
    };
    format!("{name} {wide} x {high}, {place}{typed}")
}
