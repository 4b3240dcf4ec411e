//! The line at the bottom: what the renderer is doing and how fast.

use bevy_egui::egui::{self, Ui};

use super::super::model::{DenoiserState, StatusModel};
use crate::engine::{RenderState, RenderStatus};

pub fn status_line(ui: &mut Ui, model: &StatusModel, message: Option<&str>) {
    let status = &model.status;
    ui.horizontal(|ui| {
        ui.set_min_height(20.0);
        let progress = status.samples as f32 / status.target.max(1) as f32;
        let bar = egui::ProgressBar::new(progress.clamp(0.0, 1.0))
            .desired_width(150.0)
            .desired_height(14.0)
            .text(format!("{} / {} spp", status.samples, status.target));
        ui.label(state_name(status));
        ui.add(bar);
        ui.separator();
        for part in parts(model) {
            ui.label(part);
            ui.separator();
        }
        if let Some(message) = message {
            ui.add(egui::Label::new(egui::RichText::new(message).strong()).truncate());
        }
    });
}

fn parts(model: &StatusModel) -> Vec<String> {
    let status = &model.status;
    let mut parts = vec![
        format!("{:.2} Mrays/s", status.mrays_per_s),
        clock(status.seconds),
        format!("{} triangles", grouped(status.triangles)),
        format!("{} nodes, {:.1} ms", grouped(status.bvh.nodes), status.bvh.build_ms),
    ];
    if let Some(latency) = status.latency.median_ms() {
        parts.push(format!("latency {latency:.0} ms"));
    }
    if status.invalid_samples > 0 {
        parts.push(format!("{} invalid samples", grouped(status.invalid_samples)));
    }
    match model.denoiser {
        DenoiserState::Running => parts.push("denoising".to_owned()),
        DenoiserState::Shown { seconds, samples } => parts.push(format!("denoised at {samples} spp in {seconds:.2} s")),
        DenoiserState::Idle | DenoiserState::Unavailable => {}
    }
    parts
}

pub fn state_name(status: &RenderStatus) -> &'static str {
    match status.state {
        RenderState::Idle => "No camera",
        RenderState::Loading => "Loading",
        RenderState::Building => "Building",
        RenderState::Rendering => "Rendering",
        RenderState::Paused => "Paused",
        RenderState::Done => "Done",
        RenderState::Failed => "Failed",
    }
}

/// `1:02` or `1:01:02`.
fn clock(seconds: f64) -> String {
    let whole = seconds.max(0.0) as u64;
    let (hours, minutes, rest) = (whole / 3600, whole / 60 % 60, whole % 60);
    match hours {
        0 if whole < 60 => format!("{seconds:.1} s"),
        0 => format!("{minutes}:{rest:02}"),
        _ => format!("{hours}:{minutes:02}:{rest:02}"),
    }
}

/// Digits in groups of three.
pub fn grouped(number: u64) -> String {
    let digits = number.to_string();
    let mut grouped = String::new();
    for (place, digit) in digits.chars().enumerate() {
        if place > 0 && (digits.len() - place).is_multiple_of(3) {
            grouped.push(',');
        }
        grouped.push(digit);
    }
    grouped
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_and_times_are_legible() {
        assert_eq!(grouped(871_414), "871,414");
        assert_eq!(grouped(12), "12");
        assert_eq!(clock(5.25), "5.2 s");
        assert_eq!(clock(3723.0), "1:02:03");
        assert_eq!(clock(62.9), "1:02");
    }
}
