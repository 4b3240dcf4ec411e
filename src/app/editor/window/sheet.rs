//! Shows the sheet that covers the window until it is closed: the palette, the overview of keys, the preferences with
//! the list of keys, forms, the start page.

use bevy::math::Vec3;
use bevy_egui::egui::{self, Align2, Color32, Id, Modal, RichText, Ui};

use super::dialog::{self, is_typed};
use super::palette::Palette;
use super::shortcuts::shortcuts;
use super::widgets::Widgets;
use super::{recovery_question, start_page};
use crate::app::editor::command::Command;
use crate::app::editor::command::preferences::Preferences;
use crate::app::editor::command::recovery_offer::Offer;
use crate::app::editor::command::shell::{Sheet, ShellCommand};
use crate::app::editor::input::actions::{self, ActionContext};
use crate::app::editor::input::press::Press;
use crate::app::editor::model::Model;
use crate::app::editor::panels::key_bindings::{KeyList, key_bindings};
use crate::app::editor::panels::lengths;
use crate::app::editor::panels::missing_files::missing_files;
use crate::app::editor::panels::preferences::preferences;
use crate::app::editor::panels::projection::projection;
use crate::app::editor::panels::series::series;

/// The width of the preferences and of the missing files, in points.
const WIDTH: f32 = 480.0;

/// The data of the sheets besides the model.
#[derive(Clone, Copy)]
pub struct SheetModel<'a> {
    pub actions: ActionContext<'a>,
    pub preferences: &'a Preferences,
    /// A problem with the file of the preferences.
    pub problem: Option<&'a str>,
    /// The keys that went down in this frame.
    pub presses: &'a [Press],
    /// The edits that can be recovered.
    pub left: &'a [Offer],
    /// A step that suits the selection, for a series of copies.
    pub step: Vec3,
}

pub fn show(
    context: &egui::Context,
    model: &Model,
    shown: SheetModel,
    sheet: &mut Option<Sheet>,
    widgets: &mut Widgets,
    commands: &mut Vec<Command>,
) {
    if *sheet != Some(Sheet::Palette) {
        // The palette opens without a query.
        widgets.palette = Palette::default();
    }
    if *sheet != Some(Sheet::Keys) {
        widgets.keys = KeyList::default();
    }
    let Some(open) = *sheet else {
        return;
    };
    let recent = &shown.preferences.recent_files;
    let stays = match open {
        Sheet::Palette => widgets.palette.show(context, model, &shown.actions, recent, commands),
        Sheet::Shortcuts => shortcuts(context, shown.preferences.navigation, shown.actions.bound),
        Sheet::Preferences | Sheet::Keys => pages(context, shown, sheet, &mut widgets.keys, commands),
        Sheet::Series => {
            let form = &mut widgets.series;
            // The picture beside it shows the boxes of the copies.
            let id = Id::new("series");
            let area = Modal::default_area(id).anchor(Align2::RIGHT_CENTER, egui::vec2(-16.0, 0.0));
            let modal = Modal::new(id).area(area).backdrop_color(Color32::TRANSPARENT);
            form_sheet(context, modal, "Series of copies", model, |ui| {
                series(ui, form, shown.step, commands)
            })
        }
        Sheet::Projection => {
            let (form, shapes) = (&mut widgets.projection, shown.actions.selection.entities());
            let modal = Modal::new(Id::new("projection"));
            form_sheet(context, modal, "Project texture", model, |ui| {
                projection(ui, form, shapes, commands)
            })
        }
        Sheet::Missing => {
            let form = &mut widgets.missing;
            let modal = dialog::form(context, Modal::new(Id::new("missing files")), |ui| {
                ui.set_width(WIDTH);
                ui.label(RichText::new("Missing files").heading().strong());
                ui.add_space(6.0);
                if missing_files(ui, form, &model.missing, commands) {
                    ui.close();
                }
            });
            !modal.should_close()
        }
        Sheet::Bake => widgets.bake.sheet(context, &model.bake, commands),
        Sheet::Recovery => recovery_question::list(context, shown.left, commands),
        Sheet::Start => start_page::show(
            context,
            shown.preferences,
            shown.left,
            &shown.actions,
            shown.presses,
            commands,
        ),
    };
    if !stays {
        *sheet = None;
    }
}

/// Shows a form, whose content returns true when it is finished; returns false when it is to be closed.
fn form_sheet(
    context: &egui::Context,
    modal: Modal,
    title: &str,
    model: &Model,
    content: impl FnOnce(&mut Ui) -> bool,
) -> bool {
    let modal = dialog::form(context, modal, |ui| {
        ui.set_width(320.0);
        ui.label(RichText::new(title).heading().strong());
        ui.add_space(6.0);
        if lengths::in_unit(ui, model.unit, content) {
            ui.close();
        }
    });
    !modal.should_close()
}

/// Shows the preferences or the list of keys, with tabs to switch between both; returns false when they are to be
/// closed.
fn pages(
    context: &egui::Context,
    shown: SheetModel,
    sheet: &mut Option<Sheet>,
    keys: &mut KeyList,
    commands: &mut Vec<Command>,
) -> bool {
    if keys.waits() {
        // The list uses the press: Esc must not close the sheet, and Tab must not move on to another control.
        context.input_mut(|input| input.events.retain(|event| !is_typed(event)));
    }
    let modal = dialog::form(context, Modal::new(Id::new("preferences")), |ui| {
        ui.set_width(WIDTH);
        ui.label(RichText::new("Preferences").heading().strong());
        ui.add_space(4.0);
        ui.horizontal(|ui| {
            for (page, name) in [(Sheet::Preferences, "General"), (Sheet::Keys, "Keys")] {
                if ui.selectable_label(*sheet == Some(page), name).clicked() {
                    *sheet = Some(page);
                }
            }
        });
        ui.separator();
        page(ui, shown, *sheet, keys, commands);
        ui.add_space(6.0);
        ui.with_layout(egui::Layout::right_to_left(egui::Align::Center), |ui| {
            if ui
                .button("Close")
                .on_hover_text("They are kept as they are (Esc)")
                .clicked()
            {
                ui.close();
            }
        });
    });
    !modal.should_close()
}

fn page(ui: &mut Ui, shown: SheetModel, sheet: Option<Sheet>, keys: &mut KeyList, commands: &mut Vec<Command>) {
    if sheet != Some(Sheet::Keys) {
        preferences(ui, shown.preferences, shown.problem, commands);
        return;
    }
    if let Some(chosen) = key_bindings(ui, keys, shown.actions.bound, shown.presses) {
        let preferences = Preferences {
            keys: chosen,
            ..shown.preferences.clone()
        };
        commands.push(ShellCommand::SetPreferences(Box::new(preferences)).into());
    }
    let palette = actions::hint(
        "Everything can also be found by its name",
        "palette",
        shown.actions.bound,
    );
    ui.weak(palette);
}
