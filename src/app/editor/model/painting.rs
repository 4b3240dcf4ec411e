//! What panels and the viewport show of the light you want.

use std::sync::Arc;

use bevy::prelude::Entity;

use crate::app::editor::command::light_paint::{Answer, Brush, LampChoice, Proposal};
use crate::engine::lamp_freedom::FreedomKind;
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
    /// The name of the file of the wanted picture; None without one.
    pub picture: Option<String>,
    /// Whether the strokes belong to another view.
    pub is_elsewhere: bool,
    /// What may be changed of lamps, where it is not the usual.
    pub lamps: Vec<(Entity, LampChoice)>,
    /// What was found.
    pub answer: Option<Arc<Answer>>,
    /// What can change of each light with a layer besides its strength.
    pub freedoms: Arc<[(Entity, FreedomKind)]>,
    /// The finished share of the search for places, from 0 to 1; None without one.
    pub placing: Option<f32>,
    /// The places that were found.
    pub proposal: Option<Arc<Proposal>>,
}
