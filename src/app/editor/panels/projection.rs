//! The form for new texture coordinates.

use bevy::prelude::Entity;
use bevy_egui::egui::{self, Ui};

use super::{fields, lengths, look};
use crate::app::editor::command::uv_projection::{ProjectedFrom, Projection};
use crate::app::editor::command::{Command, TextureEdit};

/// The entries of the form, which stay while the window is open.
#[derive(Clone, Debug, PartialEq)]
pub struct ProjectionForm {
    from: ProjectedFrom,
    /// The edge of a tile in world units; None for one metre.
    tile: Option<f32>,
}

impl Default for ProjectionForm {
    fn default() -> Self {
        Self {
            from: ProjectedFrom::Box,
            tile: None,
        }
    }
}

/// Shows the form for these shapes. Returns true when it is finished.
pub fn projection(ui: &mut Ui, form: &mut ProjectionForm, shapes: &[Entity], commands: &mut Vec<Command>) -> bool {
    fields::choice(ui, "From", &mut form.from, &ProjectedFrom::LABELED);
    let metre = lengths::unit(ui).parse("1m").map_or(1.0, |metre| metre as f32);
    let mut tile = form.tile.unwrap_or(metre);
    if lengths::length(
        ui,
        "Edge of a tile",
        &mut tile,
        0.01 * metre,
        1e-4 * metre..=1e6 * metre,
    ) {
        form.tile = Some(tile);
    }
    let text = "Walls, stairs, prisms and boxes keep their numbers where sides of a box suffice, and so do rectangles. Other shapes become meshes.";
    ui.add(egui::Label::new(egui::RichText::new(text).weak()).wrap());
    ui.add_space(6.0);
    let (projects, cancels) = look::form_buttons(ui, "Project", "Gives what is selected new texture coordinates");
    if projects {
        let from = form.from;
        commands.push(
            TextureEdit::ProjectTextures {
                shapes: shapes.to_vec(),
                projection: Projection { from, tile },
            }
            .into(),
        );
    }
    projects || cancels
}
