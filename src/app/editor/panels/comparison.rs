//! The comparison of the picture with a snapshot.

use bevy_egui::egui::{self, Ui};

use super::fields;
use crate::app::editor::command::compare_view::CompareView;
use crate::app::editor::command::{Command, DisplayCommand};
use crate::app::editor::model::ComparisonModel;
use crate::app::editor::words::figures::counted;
use crate::metrics::Errors;

/// Shows buttons to take and show a snapshot, the choice of the comparison, and the figures of the difference.
pub fn comparison(ui: &mut Ui, model: &ComparisonModel, commands: &mut Vec<Command>) {
    fields::buttons(ui, |ui| {
        let take = ui.button("Take snapshot");
        if take
            .on_hover_text("Keep the picture as it is now, to compare later ones with it")
            .clicked()
        {
            commands.push(DisplayCommand::TakeSnapshot.into());
        }
        let measure = ui.add_enabled(model.snapshot.is_some(), egui::Button::new("Measure"));
        let measure = measure.on_hover_text("The error of the picture, with the snapshot as the truth");
        if measure.on_disabled_hover_text("Take a snapshot first").clicked() {
            commands.push(DisplayCommand::Measure.into());
        }
    });
    let kept = model.snapshot.map(|samples| {
        let samples = counted(samples.into(), "sample");
        match model.is_of_other_scene {
            true => format!("{samples}, another scene"),
            false => samples,
        }
    });
    fields::note(ui, "Snapshot", kept.as_deref().unwrap_or("none"));
    // The row exists before the snapshot does, so that nothing below it moves away from the pointer.
    let has_other = model.snapshot.is_some() || model.denoising || matches!(model.view, CompareView::Baked(_));
    ui.add_enabled_ui(has_other, |ui| view_rows(ui, model, commands));
    if let (Some(_), Some(measured)) = (model.snapshot, &model.figures) {
        fields::note(ui, "Measured at", counted(measured.samples.into(), "sample"));
        figure_rows(ui, &measured.figures);
    }
}

/// Shows the comparisons with the snapshot or the noisy picture, one click for each.
fn view_rows(ui: &mut Ui, model: &ComparisonModel, commands: &mut Vec<Command>) {
    let mut view = model.view;
    // The choice does not depend on the border, which stays where it is.
    let border = model.view.border().unwrap_or(0.5);
    let mut views = vec![(CompareView::Off, "off")];
    let is_baked = matches!(model.view, CompareView::Baked(_));
    if model.snapshot.is_some() || !model.denoising && !is_baked {
        views.push((CompareView::Wipe(border), "wipe"));
        views.push((CompareView::Difference, "difference"));
    }
    if model.denoising {
        views.push((CompareView::Noisy(border), "noisy"));
    }
    // The panel of the bake starts this comparison.
    if is_baked {
        views.push((model.view, "baked"));
    }
    let mut changed = fields::switch(ui, "Compare", &mut view, &views);
    if let CompareView::Wipe(share) | CompareView::Noisy(share) | CompareView::Baked(share) = &mut view {
        changed |= fields::slider(ui, "Border", share, 0.0..=1.0);
    }
    if changed {
        commands.push(DisplayCommand::SetCompareView(view).into());
    }
}

fn figure_rows(ui: &mut Ui, figures: &Errors) {
    let [picture, snapshot] = figures.means;
    fields::note(ui, "Means", format!("{picture:.5}, {snapshot:.5}"));
    fields::note(ui, "MSE", format!("{:.3e}", figures.mse));
    fields::note(ui, "Relative MSE", format!("{:.3e}", figures.relative_mse));
    fields::note(ui, "PSNR", format!("{:.2} dB", figures.psnr));
}
