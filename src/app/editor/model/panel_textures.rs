//! Textures of panels: thumbnails of picture files, and rendered balls of materials.

use std::collections::HashMap;
use std::path::{Path, PathBuf};

use bevy::prelude::*;
use bevy_egui::egui;

/// The textures of panels, by their content.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct PanelTextures {
    /// Thumbnails of pictures by absolute path.
    pub pictures: HashMap<PathBuf, Thumbnail>,
    /// Rendered balls.
    pub balls: HashMap<Ball, egui::TextureId>,
    /// The colours of balls that are not rendered yet.
    pub colors: HashMap<Ball, egui::Color32>,
}

/// The material of a rendered ball.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Ball {
    /// A material of the scene.
    Material(Entity),
    /// A material of the library, by its index there.
    Preset(usize),
}

/// A small version of a picture.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Thumbnail {
    /// The texture that egui paints.
    pub texture: egui::TextureId,
    /// Width and height of the picture itself, in pixels.
    pub size: [u32; 2],
}

impl PanelTextures {
    /// Paints the rendered ball, or a plain disc in the colour of the material while there is no picture.
    pub(crate) fn paint_ball(&self, ui: &egui::Ui, ball: Ball, rect: egui::Rect) {
        match self.balls.get(&ball) {
            Some(texture) => {
                let whole = egui::Rect::from_min_max(egui::Pos2::ZERO, egui::pos2(1.0, 1.0));
                ui.painter().image(*texture, rect, whole, egui::Color32::WHITE);
            }
            None => {
                let radius = 0.42 * rect.size().min_elem();
                let unknown = ui.visuals().widgets.noninteractive.bg_stroke.color;
                let color = self.colors.get(&ball).copied().unwrap_or(unknown);
                ui.painter().circle_filled(rect.center(), radius, color);
            }
        }
    }

    /// The thumbnail of a picture by its absolute path; None until it is made.
    pub fn picture(&self, path: &Path) -> Option<Thumbnail> {
        self.pictures.get(path).copied()
    }
}
