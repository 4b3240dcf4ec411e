//! The look of the panels: quiet and without a hue, so that the picture is judged against a neutral grey. Texts have a
//! contrast of at least 4.5 to 1 against their background (WCAG 2.2, level AA), and are at least 11 points high; tests
//! hold both.

use bevy::prelude::*;
use bevy::window::{PrimaryWindow, WindowTheme};
use bevy_egui::EguiContexts;
use bevy_egui::egui::epaint::FontColorTransferFunction;
use bevy_egui::egui::style::WidgetVisuals;
use bevy_egui::egui::{self, Color32, FontId, Stroke, Style, TextStyle, Theme};

use crate::app::editor::command::preferences::{Preferences, ThemeChoice, UI_SCALES};

/// The size of the smallest texts, in points.
const SMALL: f32 = 11.0;
/// The factor by which the dark letters of the light theme are thickened: egui's font is a light one.
const DARK_LETTERS: f32 = 0.65;

pub(super) fn set_styles_of_window(mut contexts: EguiContexts) -> Result {
    set_styles(contexts.ctx_mut()?);
    Ok(())
}

/// Changes egui's styles of both themes to the editor's.
pub fn set_styles(context: &egui::Context) {
    for theme in [Theme::Dark, Theme::Light] {
        context.style_mut_of(theme, |style| set_style(style, theme));
    }
}

/// Changes egui's style of a theme to the editor's.
fn set_style(style: &mut Style, theme: Theme) {
    style.spacing.item_spacing = egui::vec2(6.0, 3.0);
    style.spacing.interact_size.y = 17.0;
    style.spacing.slider_width = 96.0;
    style.spacing.slider_rail_height = 3.0;
    style.text_styles.insert(TextStyle::Small, FontId::proportional(SMALL));
    let visuals = &mut style.visuals;
    match theme {
        Theme::Dark => {
            visuals.panel_fill = Color32::from_gray(36);
            visuals.window_fill = Color32::from_gray(40);
            visuals.extreme_bg_color = Color32::from_gray(20);
            visuals.error_fg_color = Color32::from_rgb(255, 120, 105);
            visuals.hyperlink_color = Color32::from_rgb(110, 180, 255);
            visuals.override_text_color = Some(Color32::from_gray(215));
            visuals.weak_text_color = Some(Color32::from_gray(165));
            let inactive = &mut visuals.widgets.inactive;
            inactive.weak_bg_fill = Color32::from_gray(52);
            // The rail of a slider and the box of a tick.
            inactive.bg_fill = Color32::from_gray(74);
        }
        Theme::Light => {
            visuals.panel_fill = Color32::from_gray(232);
            visuals.window_fill = Color32::from_gray(240);
            visuals.extreme_bg_color = Color32::from_gray(254);
            visuals.faint_bg_color = Color32::from_gray(224);
            visuals.error_fg_color = Color32::from_rgb(168, 20, 14);
            visuals.warn_fg_color = Color32::from_rgb(124, 68, 0);
            visuals.hyperlink_color = Color32::from_rgb(0, 78, 158);
            visuals.override_text_color = Some(Color32::from_gray(16));
            visuals.weak_text_color = Some(Color32::from_gray(76));
            visuals.selection.bg_fill = Color32::from_rgb(164, 206, 240);
            visuals.text_options.color_transfer_function = FontColorTransferFunction::Gamma(DARK_LETTERS);
            let widgets = &mut visuals.widgets;
            field(&mut widgets.inactive, 252, 128);
            field(&mut widgets.hovered, 255, 80);
            field(&mut widgets.active, 206, 0);
            field(&mut widgets.open, 244, 80);
            // The rail of a slider and the box of a tick.
            widgets.inactive.bg_fill = Color32::from_gray(198);
            widgets.hovered.bg_fill = Color32::from_gray(184);
        }
    }
}

/// The greys of a field, which hardly differ from a light panel, so that fields have an edge.
fn field(widget: &mut WidgetVisuals, fill: u8, edge: u8) {
    widget.weak_bg_fill = Color32::from_gray(fill);
    widget.bg_fill = Color32::from_gray(fill);
    widget.bg_stroke = Stroke::new(1.0, Color32::from_gray(edge));
}

/// Synchronizes the scale of the preferences with that of egui, which has keys of its own for it.
#[derive(Default)]
pub(super) enum Scale {
    #[default]
    Unknown,
    /// The scale was set in egui, which applies it at the beginning of the next frame.
    Told(f32),
    Taken(f32),
}

pub(super) fn follow_preferences(
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::app::editor::panels::look;
    use crate::color::linear_from_srgb8;

    fn style(theme: Theme) -> Style {
        let mut style = Style {
            visuals: theme.default_visuals(),
            ..Style::default()
        };
        set_style(&mut style, theme);
        style
    }

    /// The relative luminance of WCAG 2.2.
    fn luminance(color: Color32) -> f32 {
        let [r, g, b] = [color.r(), color.g(), color.b()].map(linear_from_srgb8);
        0.2126 * r + 0.7152 * g + 0.0722 * b
    }

    /// The contrast ratio of WCAG 2.2, from 1 to 21.
    fn contrast(one: Color32, other: Color32) -> f32 {
        let (one, other) = (luminance(one), luminance(other));
        (one.max(other) + 0.05) / (one.min(other) + 0.05)
    }

    #[test]
    fn the_ratio_is_that_of_the_standard() {
        assert!((contrast(Color32::BLACK, Color32::WHITE) - 21.0).abs() < 1e-3);
        // The grey that just passes on white.
        assert!((contrast(Color32::from_gray(118), Color32::WHITE) - 4.54).abs() < 0.01);
    }

    #[test]
    fn texts_are_legible_on_everything_they_stand_on() {
        for theme in [Theme::Dark, Theme::Light] {
            let style = style(theme);
            let visuals = &style.visuals;
            let widgets = &visuals.widgets;
            let grounds = [
                ("panel", visuals.panel_fill),
                ("window", visuals.window_fill),
                ("text field", visuals.extreme_bg_color),
                ("header of a section", look::strip(visuals)),
            ];
            let controls = [
                ("field", widgets.inactive.weak_bg_fill),
                ("field below the pointer", widgets.hovered.weak_bg_fill),
                ("pressed field", widgets.active.weak_bg_fill),
                ("open field", widgets.open.weak_bg_fill),
                ("selection", visuals.selection.bg_fill),
            ];
            let texts = [
                ("text", visuals.text_color()),
                ("strong text", visuals.strong_text_color()),
            ];
            let tinted = [
                ("weak text", visuals.weak_text_color()),
                ("error", visuals.error_fg_color),
                ("warning", visuals.warn_fg_color),
                ("link", visuals.hyperlink_color),
            ];
            let on_all = texts
                .iter()
                .flat_map(|text| grounds.iter().chain(&controls).map(move |on| (text, on)));
            let on_grounds = tinted.iter().flat_map(|text| grounds.iter().map(move |on| (text, on)));
            let accent = (
                ("text of the primary button", look::ON_ACCENT),
                ("accent", look::accent(visuals)),
            );
            for ((text, color), (ground, on)) in on_all.chain(on_grounds).chain([(&accent.0, &accent.1)]) {
                let ratio = contrast(*color, *on);
                assert!(ratio >= 4.5, "{theme:?}: {text} on {ground}: {ratio:.2}");
            }
        }
    }

    #[test]
    fn fields_stand_out_from_a_light_panel() {
        let style = style(Theme::Light);
        let visuals = &style.visuals;
        let ratio = contrast(visuals.widgets.inactive.bg_stroke.color, visuals.panel_fill);
        assert!(ratio >= 3.0, "{ratio:.2}");
    }

    #[test]
    fn no_text_is_smaller_than_eleven_points() {
        for theme in [Theme::Dark, Theme::Light] {
            for (name, font) in &style(theme).text_styles {
                assert!(font.size >= 11.0, "{name}: {}", font.size);
            }
        }
    }
}
