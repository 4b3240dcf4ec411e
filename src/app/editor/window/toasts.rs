//! Messages over the picture that disappear by themselves, and errors that stay until they are dismissed or solved.
//! They name files without their folders, which the tool tip has.

use bevy_egui::egui::{self, Align2, Area, Color32, Frame, Id, Order, Rangef, Rect, RichText, Ui};

use crate::app::editor::command::panel::Panel;
use crate::app::editor::command::{Command, ShellCommand};
use crate::app::editor::panels::excerpt::excerpt;
use crate::app::editor::panels::look;
use crate::app::editor::session::toasts::{Toast, Toasts, Tone};
use crate::app::editor::words::files::without_folders;

const WIDTH: f32 = 380.0;
/// The gap in points to the edges of the picture.
const GAP: f32 = 10.0;

/// The rectangles that messages must not cover.
#[derive(Clone, Debug)]
pub struct Surroundings {
    /// The panel with the picture.
    pub panel: Rect,
    /// The bars over the picture and its legend. Messages are above those at the foot of the picture.
    pub bars: Vec<Rect>,
    /// Whether a question is open, which messages must not cover.
    pub has_question: bool,
}

/// Shows the messages in the lower right corner of the panel, the newest at the bottom, without messages of the tone
/// `hidden`.
pub fn show(
    toasts: &mut Toasts,
    hidden: Option<Tone>,
    context: &egui::Context,
    around: Surroundings,
    commands: &mut Vec<Command>,
) {
    let place = around.panel;
    let current = toasts.current();
    if current.is_empty() {
        return;
    }
    let width = WIDTH.min(place.width() - 24.0).max(120.0);
    let right = place.right() - GAP;
    let column = Rangef::new(right - width, right);
    let is_below = |bar: &&Rect| bar.x_range().intersects(column) && bar.top() > place.center().y;
    let tops = around.bars.iter().filter(is_below).map(|bar| bar.top());
    let bottom = tops.fold(place.bottom(), f32::min) - GAP;
    let mut dismissed = None;
    Area::new(Id::new("toasts"))
        .order(match around.has_question {
            true => Order::Middle,
            false => Order::Foreground,
        })
        .pivot(Align2::RIGHT_BOTTOM)
        .fixed_pos(egui::pos2(right, bottom))
        .constrain_to(place)
        .show(context, |ui| {
            ui.set_width(width);
            let is_shown = |toast: &Toast| Some(toast.tone) != hidden;
            for (index, toast) in current.iter().enumerate().filter(|(_, toast)| is_shown(toast)) {
                ui.push_id(toast.since, |ui| {
                    if toast_frame(ui, toast, commands) {
                        dismissed = Some(index);
                    }
                });
            }
        });
    if let Some(index) = dismissed {
        toasts.dismiss(index);
    }
}

/// Shows a message; returns true if it is dismissed.
fn toast_frame(ui: &mut Ui, toast: &Toast, commands: &mut Vec<Command>) -> bool {
    ui.set_opacity(toast.opacity());
    let visuals = ui.visuals();
    let edge = match toast.tone {
        Tone::Note => visuals.widgets.noninteractive.bg_stroke.color,
        Tone::Warning => visuals.warn_fg_color,
        Tone::Error => visuals.error_fg_color,
    };
    let frame = Frame::popup(ui.style()).stroke(egui::Stroke::new(1.0, edge));
    let mut dismissed = false;
    frame.show(ui, |ui| {
        ui.horizontal_top(|ui| {
            let close = ui.spacing().interact_size.y + ui.spacing().item_spacing.x;
            ui.vertical(|ui| {
                ui.set_width(ui.available_width() - close);
                content(ui, toast, edge, commands);
                if let Some((label, command)) = &toast.offer {
                    let button = look::primary(ui, label);
                    if ui.add(button).clicked() {
                        commands.push(command.clone());
                        dismissed = true;
                    }
                }
            });
            dismissed |= ui.small_button("×").on_hover_text("Dismiss").clicked();
        });
    });
    dismissed
}

fn content(ui: &mut Ui, toast: &Toast, edge: Color32, commands: &mut Vec<Command>) {
    let short = without_folders(&toast.text);
    let text = RichText::new(&short);
    let text = if toast.tone == Tone::Error {
        text.color(edge)
    } else {
        text
    };
    let label = ui.add(egui::Label::new(text).wrap());
    if short != toast.text {
        label.on_hover_text(&toast.text);
    }
    if let Some(lines) = &toast.excerpt {
        excerpt(ui, lines);
    }
    if toast.tone == Tone::Error
        && ui
            .small_button("Messages")
            .on_hover_text("Show everything that is wrong in the panel Messages")
            .clicked()
    {
        commands.push(ShellCommand::ShowPanel(Panel::Messages).into());
    }
}
