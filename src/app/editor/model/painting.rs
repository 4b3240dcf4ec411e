//! What panels and the viewport show of the light you want.

use std::sync::Arc;

use bevy::prelude::Entity;

use crate::app::editor::command::light_paint::{Answer, Brush, LampChoice};
use crate::inverse_lighting::Stroke;

/// The light you want.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct PaintingModel {
    /// Whether the tool that paints is in use.
    pub tool_is_on: bool,
    /// The brush for the next stroke.
    pub brush: Brush,
    /// The strokes.
    pub strokes: Arc<[Stroke]>,
    /// Whether a picture is wanted.
    pub has_picture: bool,
    /// Whether the strokes belong to another view.
    pub is_elsewhere: bool,
    /// What may be changed of lamps, where it is not the usual.
    pub lamps: Vec<(Entity, LampChoice)>,
    /// What was found.
    pub answer: Option<Arc<Answer>>,
}
