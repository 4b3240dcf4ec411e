//! The input of the block-out tools: the data that they act on, the mouse, and the conversion of pointer positions to
//! places.

use bevy::ecs::entity::EntityHashSet;
use bevy::math::{Affine3A, Vec3};
use bevy::prelude::Entity;
use bevy_egui::egui::{self, Event, PointerButton, Pos2};

use crate::app::editor::camera::screen::Screen;
use crate::app::editor::command::tool::Tool;
use crate::engine::PackedScene;
use crate::scene::{LengthUnit, Shape, ShapeKind, Solid};

/// The shape under the pointer.
#[derive(Clone, Debug, PartialEq)]
pub struct BlockTarget {
    /// The entity.
    pub entity: Entity,
    /// Its geometry.
    pub shape: Shape,
    /// World from local.
    pub pose: Affine3A,
}

/// Whether it is a wall with openings.
pub fn has_openings(shape: &Shape) -> bool {
    matches!(&shape.kind, ShapeKind::Solid(Solid::Wall { openings, .. }) if !openings.is_empty())
}

/// The data that the tools act on.
#[derive(Clone, Copy, Debug)]
pub struct BlockingModel<'a> {
    /// The tool in use.
    pub tool: Tool,
    /// The shapes that were at and around the pointer in the last frame.
    pub near: &'a [BlockTarget],
    /// The step of the grid, in world units.
    pub step: f32,
    /// The world's upward direction.
    pub up: Vec3,
    /// The unit of the scene, for lengths that are typed.
    pub unit: LengthUnit,
    /// The packed scene, to find surfaces.
    pub packed: &'a PackedScene,
    /// The shapes that are locked.
    pub locked: &'a EntityHashSet,
    /// Whether the scene has no shapes.
    pub is_empty: bool,
}

impl<'a> BlockingModel<'a> {
    /// The shape of this entity, if it is near.
    pub(super) fn target(&self, entity: Entity) -> Option<&'a BlockTarget> {
        self.near.iter().find(|target| target.entity == entity)
    }
}

/// The mouse and the modifiers at a moment of a frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(in crate::app::editor::viewport) struct Hand {
    pub pointer: Pos2,
    /// Whether the left button has just gone down on the picture.
    pub pressed: bool,
    /// Whether the left button has just gone down or up.
    pub is_turn: bool,
    /// Whether the left button is down.
    pub down: bool,
    /// The step to which places are rounded; 0 with Control.
    pub step: f32,
}

/// The place along a line (in units of its direction, of unit length) that is nearest to the ray of the pointer; None
/// where the line is seen end on.
pub(super) fn along_line(screen: &Screen, pointer: Pos2, origin: Vec3, direction: Vec3) -> Option<f32> {
    let ray = screen.ray(pointer);
    let towards = ray.dir.normalize_or_zero();
    let between = origin - ray.origin;
    let cosine = direction.dot(towards);
    let sine_squared = 1.0 - cosine * cosine;
    // If the line were seen more nearly end on, one pixel would stand for a very long distance.
    const END_ON: f32 = 3e-3;
    (sine_squared > END_ON).then(|| (cosine * towards.dot(between) - direction.dot(between)) / sine_squared)
}

/// The moments of a frame at which the left button went down or up, and its end: a quick drag begins and ends within
/// one frame of a slow picture. `hand` is the mouse at the end.
pub(super) fn moments(events: &[Event], is_over: bool, hand: Hand) -> Vec<Hand> {
    let buttons = events.iter().filter_map(|event| match *event {
        Event::PointerButton {
            pos,
            button: PointerButton::Primary,
            pressed,
            modifiers,
        } => Some((pos, pressed, modifiers.alt)),
        _ => None,
    });
    let moments = buttons.map(|(pointer, down, alt)| Hand {
        pointer,
        pressed: down && is_over && !alt,
        is_turn: true,
        down,
        step: hand.step,
    });
    moments.chain([hand]).collect()
}

/// Whether the pointer has moved so far that it is a drag.
pub(super) fn is_drag(from: Pos2, to: Pos2) -> bool {
    const FARTHEST_CLICK: f32 = 5.0;
    egui::Vec2::length(to - from) > FARTHEST_CLICK
}
