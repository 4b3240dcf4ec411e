//! The picture against one that was kept.

use bevy_egui::egui::{self, Ui};

use super::fields;
use crate::app::editor::command::Command;
use crate::app::editor::command::compare_view::CompareView;
use crate::app::editor::model::ComparisonModel;
use crate::app::editor::picture::compare::Figures;
use crate::app::editor::words::figures::counted;

/// Shows buttons to take and show a snapshot, and the figures of the difference.
pub fn comparison(ui: &mut Ui, model: &ComparisonModel, commands: &mut Vec<Command>) {
    ui.horizontal(|ui| {
        if ui.button("Take snapshot").clicked() {
            commands.push(Command::TakeSnapshot);
        }
        if ui
            .add_enabled(model.snapshot.is_some(), egui::Button::new("Measure"))
            .clicked()
        {
            commands.push(Command::Measure);
        }
    });
    let Some(samples) = model.snapshot else {
        return;
    };
    fields::note(ui, "Snapshot", format!("{samples} samples"));
    let mut view = model.view;
    // The place of the border does not matter to the choice.
    let wipe = match model.view {
        CompareView::Wipe(_) => model.view,
        _ => CompareView::Wipe(0.5),
    };
    let views = [
        (CompareView::Off, "off"),
        (wipe, "wipe"),
        (CompareView::Difference, "difference"),
    ];
    let mut changed = fields::choice(ui, "Compare", &mut view, &views);
    if let CompareView::Wipe(share) = &mut view {
        changed |= fields::slider(ui, "Border", share, 0.0..=1.0);
    }
    if changed {
        commands.push(Command::SetCompareView(view));
    }
    if let Some(measured) = &model.figures {
        fields::note(ui, "Measured at", counted(measured.samples.into(), "sample"));
        figure_rows(ui, &measured.figures);
    }
}

fn figure_rows(ui: &mut Ui, figures: &Figures) {
    let [picture, snapshot] = figures.means;
    fields::note(ui, "Means", format!("{picture:.5}, {snapshot:.5}"));
    fields::note(ui, "MSE", format!("{:.3e}", figures.mse));
    fields::note(ui, "Relative MSE", format!("{:.3e}", figures.relative_mse));
    fields::note(ui, "PSNR", format!("{:.2} dB", figures.psnr));
}
