//! Why the inspected place is as it is: its light by lamps and ways as sentences with bars, and what the noise there is
//! made of. A click on a share shows its paths, and a click on a name selects the thing.

use std::time::Duration;

use bevy::prelude::Entity;
use bevy_egui::egui::{self, Align2, Response, RichText, Sense, TextStyle, Ui, WidgetInfo, WidgetType};

use crate::app::editor::command::inspected_paths::InspectedPaths;
use crate::app::editor::command::selection::Extend;
use crate::app::editor::command::{Command, SelectionCommand};
use crate::app::editor::picture::reasons::{Explanation, NamedPortion, Reasons};
use crate::app::editor::picture::search::SearchState;
use crate::engine::reasons::{Grouping, NO_LIGHT, listed, percent};
use crate::photometry::units::Nit;

/// The size of a bar in points.
const BAR: egui::Vec2 = egui::vec2(92.0, 18.0);

/// The time after which progress is shown anew.
const PROGRESS: Duration = Duration::from_millis(250);

/// Shows the reasons, or the search for them. The choice of a grouping or a group changes `wanted`.
pub fn reasons(
    ui: &mut Ui,
    Reasons { explanation, state, .. }: &Reasons,
    wanted: &mut InspectedPaths,
    commands: &mut Vec<Command>,
) {
    let Some(known) = explanation.as_deref() else {
        return search_without_result(ui, state);
    };
    let [value, error] = [known.value.luminance, known.value.error].map(|watts| Nit::of_watts(f64::from(watts)));
    ui.horizontal_wrapped(|ui| {
        ui.label(value.with_error(error.0));
        let more = match (known.is_final, state) {
            (true, _) => String::new(),
            (false, SearchState::Failed(reason)) => format!("; more could not be traced: {reason}"),
            (false, state) => format!(", more are being traced{}", share_done(ui, state)),
        };
        ui.weak(format!("by {} samples{more}", known.samples));
    });
    ui.horizontal_wrapped(|ui| {
        for (grouping, label) in Grouping::LABELED {
            let button = ui.selectable_label(wanted.grouping == grouping, label);
            if button.clicked() && wanted.grouping != grouping {
                (wanted.grouping, wanted.of) = (grouping, None);
            }
        }
    });
    if known.value.luminance == 0.0 {
        ui.weak(NO_LIGHT);
    }
    let place = Grouping::ALL.iter().position(|grouping| *grouping == wanted.grouping);
    let portions = place.and_then(|place| known.groupings.get(place));
    let portions = portions.map_or(&[][..], Vec::as_slice);
    let (told, rest) = listed(portions, |named| named.portion.share);
    for named in told {
        row(ui, named, wanted, commands);
    }
    if !rest.is_empty() && known.value.luminance != 0.0 {
        let share: f32 = rest.iter().map(|named| named.portion.share).sum();
        let groups = if rest.len() == 1 { "group" } else { "groups" };
        ui.weak(format!("{:.1} % in {} smaller {groups}", 100.0 * share, rest.len()));
    }
    noise(ui, known);
}

/// Says how a search that has found nothing so far is going.
pub(super) fn search_without_result(ui: &mut Ui, state: &SearchState) {
    match state {
        SearchState::Failed(reason) => {
            let text =
                format!("Nothing could be traced: {reason}. The next change of the scene or the view tries again.");
            ui.label(text);
        }
        SearchState::Idle | SearchState::Running(_) => {
            let text = format!("Tracing…{}", share_done(ui, state));
            ui.weak(text);
        }
    }
}

/// The finished share of a search that takes more than a moment, in words with a blank before them.
fn share_done(ui: &Ui, state: &SearchState) -> String {
    let SearchState::Running(done) = state else {
        return String::new();
    };
    ui.ctx().request_repaint_after(PROGRESS);
    match (100.0 * done).floor() {
        percent @ 1.0.. => format!(" {percent} %"),
        _ => String::new(),
    }
}

/// A group: the bar of its share, which is a button, and its sentence.
fn row(ui: &mut Ui, named: &NamedPortion, wanted: &mut InspectedPaths, commands: &mut Vec<Command>) {
    let group = named.portion.key;
    ui.horizontal_wrapped(|ui| {
        ui.spacing_mut().item_spacing.x = 4.0;
        if bar(ui, named, wanted.of == Some(group)) {
            wanted.of = (wanted.of != Some(group)).then_some(group);
            wanted.chosen = 0;
        }
        for (word, thing) in &named.words {
            match thing {
                Some(entity) => link(ui, word, *entity, commands),
                None => drop(ui.label(word)),
            }
        }
    });
}

/// A bar with the share; returns true when clicked.
fn bar(ui: &mut Ui, named: &NamedPortion, is_chosen: bool) -> bool {
    let portion = &named.portion;
    let sentence: Vec<&str> = named.words.iter().map(|(word, _)| word.as_str()).collect();
    let share = percent(portion.share, portion.share_error);
    let response = share_bar(ui, &share, portion.share, &sentence.join(" "), is_chosen);
    let [value, error] = [portion.luminance, portion.error].map(|watts| Nit::of_watts(f64::from(watts)));
    let help = format!(
        "{}, and {:.0} % of the noise.\nClick to see its paths.",
        value.with_error(error.0),
        100.0 * portion.noise
    );
    response.on_hover_text(help).clicked()
}

/// A bar with a share from 0 to 1 and its text. `sentence` says what it is a share of.
pub(super) fn share_bar(ui: &mut Ui, text: &str, share: f32, sentence: &str, is_chosen: bool) -> Response {
    let (rect, response) = ui.allocate_exact_size(BAR, Sense::click());
    let visuals = ui.visuals();
    let painter = ui.painter();
    painter.rect_filled(rect, 2.0, visuals.extreme_bg_color);
    let filled = rect.width() * share.clamp(0.0, 1.0);
    let part = egui::Rect::from_min_size(rect.min, egui::vec2(filled, rect.height()));
    painter.rect_filled(part, 2.0, visuals.selection.bg_fill.gamma_multiply(0.6));
    let stroke = match (is_chosen, response.hovered()) {
        (true, _) => egui::Stroke::new(2.0, visuals.selection.stroke.color),
        (false, true) => visuals.widgets.hovered.bg_stroke,
        (false, false) => visuals.widgets.inactive.bg_stroke,
    };
    painter.rect_stroke(rect, 2.0, stroke, egui::StrokeKind::Inside);
    let font = TextStyle::Small.resolve(ui.style());
    let end = rect.right_center() - egui::vec2(4.0, 0.0);
    painter.text(end, Align2::RIGHT_CENTER, text, font, visuals.strong_text_color());
    response.widget_info(|| WidgetInfo::selected(WidgetType::Button, true, is_chosen, format!("{text} {sentence}")));
    response
}

/// The name of a thing; a click selects it.
pub(super) fn link(ui: &mut Ui, name: &str, thing: Entity, commands: &mut Vec<Command>) {
    if ui.link(name).on_hover_text("Select it").clicked() {
        commands.push(SelectionCommand::Select(vec![thing], Extend::Replace).into());
    }
}

/// The reasons of the noise, with the methods that help.
fn noise(ui: &mut Ui, known: &Explanation) {
    if known.advice.is_empty() {
        return;
    }
    ui.add_space(4.0);
    ui.weak("The noise here is made of:");
    for advice in &known.advice {
        let trouble = advice.trouble;
        ui.horizontal_wrapped(|ui| {
            ui.label(format!("{:.0} % {}.", 100.0 * advice.noise, trouble.label()));
            ui.label(RichText::new(trouble.remedy()).weak());
        });
    }
}
