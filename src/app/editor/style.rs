//! The look of the panels: dark and quiet, so that the picture is judged against a neutral grey.

use bevy_egui::EguiContexts;
use bevy_egui::egui::{self, Color32};

pub fn set_style(mut contexts: EguiContexts) -> bevy::prelude::Result {
    let context = contexts.ctx_mut()?;
    context.set_theme(egui::Theme::Dark);
    context.all_styles_mut(|style| {
        style.spacing.item_spacing = egui::vec2(6.0, 4.0);
        style.spacing.slider_width = 96.0;
        style.visuals.panel_fill = Color32::from_gray(36);
        style.visuals.window_fill = Color32::from_gray(40);
        style.visuals.extreme_bg_color = Color32::from_gray(20);
        style.visuals.error_fg_color = Color32::from_rgb(255, 120, 105);
        style.visuals.override_text_color = Some(Color32::from_gray(215));
        style.visuals.weak_text_color = Some(Color32::from_gray(150));
    });
    Ok(())
}
