//! Messages over the picture that go by themselves, and errors that stay until they are dismissed or mended.

use std::time::{Duration, Instant};

use bevy_egui::egui::{self, Align2, Area, Color32, FontId, Frame, Id, Order, Rect, RichText, Ui};

use super::command::Command;
use super::layout::Panel;
use super::shell::ShellCommand;

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Tone {
    /// Something was done.
    Note,
    /// Something that was asked for cannot be done, or is perhaps not meant.
    Warning,
    /// Something is broken.
    Error,
}

/// What an error is about, so that it can go when that is mended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Topic {
    SceneFile,
    Saving,
    Other,
}

#[derive(Clone, Debug)]
pub struct Toast {
    pub tone: Tone,
    pub topic: Topic,
    pub text: String,
    /// Lines of a file, with marks under them.
    pub excerpt: Option<String>,
    since: Instant,
}

/// Notes and warnings are shown so long.
const SHOWN: Duration = Duration::from_secs(5);
/// Of which they fade so long.
const FADING: Duration = Duration::from_millis(400);
/// Between two pictures of something that fades.
const FADE_STEP: Duration = Duration::from_millis(40);
/// Older ones give way.
const MOST: usize = 5;
const WIDTH: f32 = 380.0;
/// Points that the gizmo's bar takes at the upper edge of the picture.
const BELOW_BAR: f32 = 46.0;

#[derive(Clone, Debug, Default)]
pub struct Toasts(Vec<Toast>);

impl Toasts {
    pub fn add(&mut self, tone: Tone, topic: Topic, text: String, excerpt: Option<String>) {
        // Of the same again only the newest.
        self.0.retain(|toast| toast.text != text);
        if tone == Tone::Error && topic != Topic::Other {
            self.forget(topic);
        }
        self.0.push(Toast {
            tone,
            topic,
            text,
            excerpt,
            since: Instant::now(),
        });
        if self.0.len() > MOST {
            let first_passing = self.0.iter().position(|toast| toast.tone != Tone::Error);
            self.0.remove(first_passing.unwrap_or(0));
        }
    }

    /// It is mended.
    pub fn forget(&mut self, topic: Topic) {
        self.0.retain(|toast| toast.tone != Tone::Error || toast.topic != topic);
    }

    /// When the next one changes by itself; None while nothing will.
    pub fn wait(&self) -> Option<Duration> {
        let waits = self
            .0
            .iter()
            .filter_map(Toast::left)
            .map(|left| if left > FADING { left - FADING } else { FADE_STEP });
        waits.min()
    }

    pub fn texts(&self) -> impl Iterator<Item = &str> {
        self.0.iter().map(|toast| toast.text.as_str())
    }

    /// At the right of `place`, below the bar at its upper edge.
    pub fn show(&mut self, context: &egui::Context, place: Rect, commands: &mut Vec<Command>) {
        self.0.retain(|toast| toast.left() != Some(Duration::ZERO));
        if self.0.is_empty() {
            return;
        }
        let width = WIDTH.min(place.width() - 24.0).max(120.0);
        let mut dismissed = None;
        Area::new(Id::new("toasts"))
            .order(Order::Foreground)
            .pivot(Align2::RIGHT_TOP)
            .fixed_pos(place.right_top() + egui::vec2(-10.0, BELOW_BAR))
            .constrain_to(place)
            .show(context, |ui| {
                ui.set_width(width);
                for (index, toast) in self.0.iter().enumerate().rev() {
                    ui.push_id(toast.since, |ui| {
                        if toast_frame(ui, toast, commands) {
                            dismissed = Some(index);
                        }
                    });
                }
            });
        if let Some(index) = dismissed {
            self.0.remove(index);
        }
    }
}

impl Toast {
    /// None for those that stay.
    fn left(&self) -> Option<Duration> {
        (self.tone != Tone::Error).then(|| SHOWN.saturating_sub(self.since.elapsed()))
    }

    fn opacity(&self) -> f32 {
        self.left()
            .map_or(1.0, |left| (left.as_secs_f32() / FADING.as_secs_f32()).min(1.0))
    }
}

/// True when dismissed.
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
            });
            dismissed = ui.small_button("×").on_hover_text("Dismiss").clicked();
        });
    });
    dismissed
}

fn content(ui: &mut Ui, toast: &Toast, edge: Color32, commands: &mut Vec<Command>) {
    let text = RichText::new(&toast.text);
    let text = if toast.tone == Tone::Error {
        text.color(edge)
    } else {
        text
    };
    ui.add(egui::Label::new(text).wrap());
    if let Some(lines) = &toast.excerpt {
        excerpt(ui, lines);
    }
    if toast.tone == Tone::Error
        && ui
            .small_button("Messages")
            .on_hover_text("Show everything that is wrong in the panel Messages")
            .clicked()
    {
        commands.push(Command::Shell(ShellCommand::ShowPanel(Panel::Messages)));
    }
}

/// Lines of a file as they stand there; those that are too long can be scrolled.
pub fn excerpt(ui: &mut Ui, lines: &str) {
    egui::ScrollArea::horizontal().show(ui, |ui| {
        let text = RichText::new(lines).font(FontId::monospace(11.0));
        ui.add(egui::Label::new(text).extend());
    });
}

#[cfg(test)]
mod tests {
    use super::*;

    fn add(toasts: &mut Toasts, tone: Tone, text: &str) {
        toasts.add(tone, Topic::SceneFile, text.to_owned(), None);
    }

    #[test]
    fn errors_stay_until_they_are_mended_and_then_nothing_is_waited_for() {
        let mut toasts = Toasts::default();
        add(&mut toasts, Tone::Error, "broken");
        assert_eq!(toasts.wait(), None);
        add(&mut toasts, Tone::Note, "done");
        add(&mut toasts, Tone::Error, "broken elsewhere");
        assert_eq!(toasts.texts().collect::<Vec<_>>(), ["done", "broken elsewhere"]);
        assert!(toasts.wait().is_some_and(|wait| wait <= SHOWN - FADING));
        toasts.forget(Topic::SceneFile);
        assert_eq!(toasts.texts().collect::<Vec<_>>(), ["done"]);
        // Long over, but not taken away yet.
        if let Some(long_ago) = Instant::now().checked_sub(2 * SHOWN) {
            toasts.0[0].since = long_ago;
            assert_eq!(toasts.wait(), Some(FADE_STEP));
        }
    }

    #[test]
    fn there_are_never_many_and_errors_give_way_last() {
        let mut toasts = Toasts::default();
        add(&mut toasts, Tone::Error, "broken");
        for number in 0..20 {
            add(&mut toasts, Tone::Note, &number.to_string());
        }
        let texts: Vec<&str> = toasts.texts().collect();
        assert_eq!((texts.len(), texts[0], texts[MOST - 1]), (MOST, "broken", "19"));
    }
}
