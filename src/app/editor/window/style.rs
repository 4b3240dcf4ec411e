//! The look of the panels: quiet and without a hue, so that the picture is judged against a neutral grey.

use bevy::prelude::*;
use bevy::window::{PrimaryWindow, WindowTheme};
use bevy_egui::EguiContexts;
use bevy_egui::egui::{self, Color32, Theme};

use crate::app::editor::command::preferences::{Preferences, ThemeChoice, UI_SCALES};

pub fn set_styles(mut contexts: EguiContexts) -> Result {
    let context = contexts.ctx_mut()?;
    context.all_styles_mut(|style| {
        style.spacing.item_spacing = egui::vec2(6.0, 4.0);
        style.spacing.slider_width = 96.0;
    });
    context.style_mut_of(Theme::Dark, |style| {
        let visuals = &mut style.visuals;
        visuals.panel_fill = Color32::from_gray(36);
        visuals.window_fill = Color32::from_gray(40);
        visuals.extreme_bg_color = Color32::from_gray(20);
        visuals.error_fg_color = Color32::from_rgb(255, 120, 105);
        visuals.override_text_color = Some(Color32::from_gray(215));
        visuals.weak_text_color = Some(Color32::from_gray(150));
    });
    context.style_mut_of(Theme::Light, |style| {
        let visuals = &mut style.visuals;
        visuals.panel_fill = Color32::from_gray(236);
        visuals.window_fill = Color32::from_gray(246);
        visuals.extreme_bg_color = Color32::from_gray(254);
        visuals.error_fg_color = Color32::from_rgb(176, 24, 16);
        visuals.warn_fg_color = Color32::from_rgb(146, 82, 0);
        visuals.override_text_color = Some(Color32::from_gray(24));
        visuals.weak_text_color = Some(Color32::from_gray(96));
    });
    Ok(())
}

/// Keeps the scale of the preferences and that of egui, which has keys of its own for it, in step.
#[derive(Default)]
pub enum Scale {
    #[default]
    Unknown,
    /// The scale was given to egui, which applies it at the beginning of the next frame.
    Told(f32),
    Taken(f32),
}

pub fn follow_preferences(
    mut contexts: EguiContexts,
    mut preferences: ResMut<Preferences>,
    windows: Query<&Window, With<PrimaryWindow>>,
    mut scale: Local<Scale>,
) -> Result {
    let context = contexts.ctx_mut()?;
    let of_system = windows.single().ok().and_then(|window| window.window_theme);
    let theme = match preferences.theme {
        ThemeChoice::System if of_system == Some(WindowTheme::Light) => Theme::Light,
        ThemeChoice::Dark | ThemeChoice::System => Theme::Dark,
        ThemeChoice::Light => Theme::Light,
    };
    if context.theme() != theme {
        context.set_theme(theme);
    }
    let wanted = preferences.ui_scale;
    *scale = match *scale {
        Scale::Told(told) if told == wanted => Scale::Taken(told),
        Scale::Taken(taken) if taken == wanted => {
            let now = context.zoom_factor().clamp(*UI_SCALES.start(), *UI_SCALES.end());
            if now != wanted {
                preferences.ui_scale = now;
            }
            Scale::Taken(now)
        }
        _ => {
            context.set_zoom_factor(wanted);
            Scale::Told(wanted)
        }
    };
    Ok(())
}
