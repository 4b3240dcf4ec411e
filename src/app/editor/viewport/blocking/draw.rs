//! Drawing boxes, floors and walls: a drag (or two clicks) gives the base, then the pointer gives the height until a
//! click. Numbers may be typed for both.

use bevy::math::Vec3;
use bevy_egui::egui::{Painter, Pos2};

use super::catch::{self, Caught};
use super::hand::{BlockingModel, Hand, along_line, is_drag};
use super::marks;
use super::spot::{self, Spot};
use crate::app::editor::camera::picking::SeenSurface;
use crate::app::editor::camera::screen::Screen;
use crate::app::editor::command::blocking::block::{Block, EDGES, Plane, corners};
use crate::app::editor::command::blocking::{BlockKind, snapped};
use crate::app::editor::command::{Command, SceneEdit};
use crate::app::editor::viewport::gizmo::typed::Typed;
use crate::scene::LengthUnit;

/// The state of the drawing tool.
#[derive(Clone, Debug, Default, PartialEq)]
pub(in crate::app::editor::viewport) struct DrawState {
    /// The place under the pointer, where a drawing would begin.
    spot: Option<Spot>,
    /// The corner or edge near the pointer that the drawing snaps to.
    caught: Option<Caught>,
    phase: Option<Phase>,
    /// The numbers typed for the present phase.
    typed: Typed,
    /// The heights last used for a box and for a wall.
    heights: [Option<f32>; 2],
}

#[derive(Clone, Debug, PartialEq)]
enum Phase {
    /// The base, from its first corner to the pointer.
    Base {
        from: Spot,
        to: Vec3,
        pressed_at: Pos2,
        /// Whether the button that began it is still down.
        is_held: bool,
    },
    /// The base is drawn. The height changes once the pointer has left the place where this phase began.
    Height {
        from: Spot,
        to: Vec3,
        height: f32,
        began_at: Pos2,
        follows: bool,
    },
}

/// The height and thickness of a wall, and the thickness of a floor, in a scene in metres.
const HEIGHT: f32 = 2.5;
const THICKNESS: f32 = 0.2;
const FLOOR_HEIGHT: f32 = 0.1;
/// Scenes with a grid step in this range are taken to be in metres.
const METRES: std::ops::RangeInclusive<f32> = 0.005..=1.0;
/// The usual step of a scene in metres, to which sizes in other scenes are proportional.
const USUAL_STEP: f32 = 0.1;

impl DrawState {
    pub fn is_busy(&self) -> bool {
        self.phase.is_some()
    }

    pub fn typed(&mut self) -> Option<&mut Typed> {
        self.phase.is_some().then_some(&mut self.typed)
    }

    /// Whether the base is being dragged and nothing was typed: keys typed now belong to the phase after the drag.
    pub fn is_dragging(&self) -> bool {
        matches!(self.phase, Some(Phase::Base { is_held: true, .. })) && self.typed.is_empty()
    }

    pub fn cancel(&mut self) {
        self.phase = None;
        self.typed = Typed::default();
    }

    /// The hint for the next step while something is drawn.
    pub fn hint(&self, kind: BlockKind, unit: LengthUnit) -> Option<String> {
        Some(match (self.phase.as_ref()?, kind) {
            (Phase::Base { .. }, BlockKind::Wall) => {
                "Let go or click at its end, or type its length and Enter (Esc: give it up)".to_owned()
            }
            (Phase::Base { .. }, _) => {
                "Let go or click at the opposite corner, or type its sides, such as 4,3 and Enter (Esc: give it up)"
                    .to_owned()
            }
            (Phase::Height { height, .. }, _) => format!(
                "Enter or a click: {} high. Or move the pointer up first, or type the height (Esc: give it up)",
                unit.text(*height)
            ),
        })
    }

    /// Follows the mouse; returns whether the left button is used by the tool.
    pub fn follow(
        &mut self,
        kind: BlockKind,
        seen: Option<&SeenSurface>,
        screen: &Screen,
        model: &BlockingModel,
        hand: &Hand,
        commands: &mut Vec<Command>,
    ) -> bool {
        let was_busy = self.is_busy();
        if model.is_empty {
            // A new scene has no heights used before.
            self.heights = Default::default();
        }
        self.track(kind, seen, screen, model, hand);
        match self.phase {
            None => {
                self.caught = catch::caught(kind, screen, hand.pointer, model, hand.step);
                self.spot = Spot::under(kind, hand, seen, self.caught, screen, model);
                if let (true, Some(from)) = (hand.pressed, self.spot) {
                    self.phase = Some(Phase::Base {
                        from,
                        to: from.place,
                        pressed_at: hand.pointer,
                        is_held: hand.down,
                    });
                }
            }
            Some(Phase::Base {
                pressed_at,
                ref mut is_held,
                ..
            }) => {
                let is_released = *is_held && !hand.down;
                *is_held &= hand.down;
                if hand.pressed || (is_released && is_drag(pressed_at, hand.pointer)) {
                    self.confirm(kind, seen, screen, model, hand, commands);
                }
            }
            Some(Phase::Height { .. }) => {
                if hand.pressed {
                    self.confirm(kind, seen, screen, model, hand, commands);
                }
            }
        }
        hand.pressed || (hand.down && (was_busy || self.is_busy()))
    }

    /// Brings the phase up to date with the pointer and the typed numbers.
    fn track(
        &mut self,
        kind: BlockKind,
        seen: Option<&SeenSurface>,
        screen: &Screen,
        model: &BlockingModel,
        hand: &Hand,
    ) {
        let numbers = self.typed.lengths(model.unit);
        match &mut self.phase {
            Some(Phase::Base { from, to, .. }) => {
                let under = spot::on_plane(screen, hand.pointer, from.place, from.plane.normal);
                let is_level = |place: &Vec3| spot::is_on(&from.plane, from.place, *place, model.step);
                self.caught = catch::caught(kind, screen, hand.pointer, model, hand.step)
                    .filter(|caught| is_level(&caught.place) && caught.place != from.place);
                let foot = || {
                    let seen = seen.filter(|_| kind != BlockKind::Box)?;
                    catch::foot(seen, screen, model, hand.step).filter(|foot| is_level(&foot.place))
                };
                if let Some(caught) = self.caught.or_else(foot) {
                    let is_straight = kind == BlockKind::Wall && hand.step > 0.0 && !caught.is_corner;
                    *to = match is_straight {
                        true => straight(from, caught.place),
                        false => caught.place,
                    };
                } else if let Some(under) = under {
                    *to = spot::rounded(under, &from.plane, model.step, hand.step);
                    if kind == BlockKind::Wall && hand.step > 0.0 {
                        *to = straight(from, *to);
                    }
                }
                if let Some(numbers) = numbers {
                    // Above the horizon the direction stays as it was.
                    *to = by_numbers(kind, from, under.unwrap_or(*to), &numbers);
                }
            }
            Some(Phase::Height {
                from,
                to,
                height,
                began_at,
                follows,
            }) => {
                *follows |= is_drag(*began_at, hand.pointer);
                let shown = along_line(screen, hand.pointer, *to, from.plane.normal).filter(|_| *follows);
                if let Some(&[number]) = numbers.as_deref() {
                    *height = number;
                } else if let Some(shown) = shown {
                    *height = snapped(shown, hand.step);
                }
            }
            None => {}
        }
    }

    /// Continues with the height, or adds the drawn block.
    pub fn confirm(
        &mut self,
        kind: BlockKind,
        seen: Option<&SeenSurface>,
        screen: &Screen,
        model: &BlockingModel,
        hand: &Hand,
        commands: &mut Vec<Command>,
    ) {
        self.track(kind, seen, screen, model, hand);
        let block = self.block(kind, model.step);
        self.typed = Typed::default();
        let Some(block) = block.filter(|block| block.shape().is_some()) else {
            self.phase = None;
            return;
        };
        match (self.phase.take(), kind) {
            (Some(Phase::Base { from, to, .. }), BlockKind::Box | BlockKind::Wall) => {
                self.phase = Some(Phase::Height {
                    from,
                    to,
                    height: block.height,
                    began_at: hand.pointer,
                    follows: false,
                });
            }
            _ => {
                if kind != BlockKind::Floor {
                    self.heights[usize::from(kind == BlockKind::Wall)] = Some(block.height);
                }
                commands.push(SceneEdit::Build(Box::new(block)).into());
            }
        }
    }

    /// The block as drawn so far.
    fn block(&self, kind: BlockKind, step: f32) -> Option<Block> {
        let scale = if METRES.contains(&step) { 1.0 } else { step / USUAL_STEP };
        let (from, to, height) = match self.phase.as_ref()? {
            Phase::Base { from, to, .. } => {
                let usual = match kind {
                    BlockKind::Floor => FLOOR_HEIGHT * scale,
                    BlockKind::Wall => self.heights[1].unwrap_or(HEIGHT * scale),
                    BlockKind::Box => self.heights[0].unwrap_or(scale),
                };
                (from, to, usual)
            }
            Phase::Height { from, to, height, .. } => (from, to, *height),
        };
        Some(Block {
            kind,
            name: None,
            from: from.place,
            to: *to,
            plane: from.plane,
            height,
            thickness: THICKNESS * scale,
        })
    }

    pub fn paint(&self, painter: &Painter, screen: &Screen, kind: BlockKind, model: &BlockingModel) {
        let step = model.step;
        if let Some(caught) = self
            .caught
            .filter(|_| !matches!(self.phase, Some(Phase::Height { .. })))
        {
            marks::caught(painter, screen, caught.place, caught.is_corner);
        }
        let (from, to, is_base) = match &self.phase {
            None => {
                if let Some(spot) = &self.spot {
                    cross(painter, screen, spot, step);
                }
                return;
            }
            Some(Phase::Base { from, to, .. }) => (from, *to, true),
            Some(Phase::Height { from, to, .. }) => (from, *to, false),
        };
        if kind == BlockKind::Wall {
            marks::segment(painter, screen, from.place, to);
        } else {
            let base = rectangle(from.place, to, &from.plane);
            marks::area(painter, screen, &base);
            marks::ring(painter, screen, &base);
        }
        let block = self.block(kind, step);
        let drawn = block.as_ref().and_then(Block::shape);
        if let (Some((shape, pose)), false) = (&drawn, is_base && kind == BlockKind::Box)
            && let Some(corners) = corners(shape, pose)
        {
            for [a, b] in EDGES {
                marks::segment(painter, screen, corners[a], corners[b]);
            }
        }
        marks::text(painter, screen, to, &self.caption(kind, from, to, is_base, model.unit));
    }

    /// The size so far, and the typed text.
    fn caption(&self, kind: BlockKind, from: &Spot, to: Vec3, is_base: bool, unit: LengthUnit) -> String {
        let size = match (&self.phase, is_base) {
            (Some(Phase::Height { height, .. }), false) => format!("height {}", unit.text(*height)),
            _ if kind == BlockKind::Wall => unit.text(from.place.distance(to)),
            _ => {
                let [wide, deep] = from.plane.extents(from.place, to).map(|extent| unit.text(extent.abs()));
                format!("{wide} x {deep}")
            }
        };
        match self.typed.is_empty() {
            true => size,
            false => format!("{size}   [{}]", self.typed.text()),
        }
    }
}

/// The end of a base whose size was typed: towards the pointer, with one number for the length of a wall or for both
/// sides, or with one for each side.
fn by_numbers(kind: BlockKind, from: &Spot, under: Vec3, numbers: &[f32]) -> Vec3 {
    let Plane { along, .. } = from.plane;
    let across = from.plane.across();
    let [wide, deep] = from.plane.extents(from.place, under);
    let sign = |extent: f32| if extent < 0.0 { -1.0 } else { 1.0 };
    let to = |first: f32, second: f32| from.place + along * (sign(wide) * first) + across * (sign(deep) * second);
    match numbers {
        [length] if kind == BlockKind::Wall => {
            let direction = (under - from.place).try_normalize().unwrap_or(along);
            from.place + direction * *length
        }
        [side] => to(*side, *side),
        [first, second, ..] => to(*first, *second),
        [] => under,
    }
}

/// The end of a wall, along the nearer direction of the grid if it is nearly in that direction already.
fn straight(from: &Spot, to: Vec3) -> Vec3 {
    const NEARLY: f32 = 0.06;
    let [wide, deep] = from.plane.extents(from.place, to);
    let off = match wide.abs() > deep.abs() {
        true if deep.abs() <= NEARLY * wide.abs() => from.plane.across() * deep,
        false if wide.abs() <= NEARLY * deep.abs() => from.plane.along * wide,
        _ => Vec3::ZERO,
    };
    to - off
}

fn rectangle(from: Vec3, to: Vec3, plane: &Plane) -> [Vec3; 4] {
    let [wide, deep] = plane.extents(from, to);
    let (along, across) = (plane.along * wide, plane.across() * deep);
    [from, from + along, from + along + across, from + across]
}

/// The point of the grid under the pointer.
fn cross(painter: &Painter, screen: &Screen, spot: &Spot, step: f32) {
    let reach = step.max(8.0 * screen.units_per_point(screen.depth(spot.place)));
    for direction in [spot.plane.along, spot.plane.across()] {
        marks::segment(
            painter,
            screen,
            spot.place - direction * reach,
            spot.place + direction * reach,
        );
    }
}
