//! The line at the bottom: what the renderer is doing and how fast.

use bevy_egui::egui::{self, Ui};

use crate::app::editor::model::StatusModel;
use crate::app::editor::picture::denoiser::DenoiserState;
use crate::app::editor::words::figures::counted;
use crate::engine::{RenderState, RenderStatus};

/// The room for the separator before a part.
const MARGIN: f32 = 22.0;

/// One line: what the renderer is at, samples, time, speed and noise.
pub fn status_line(ui: &mut Ui, model: &StatusModel) {
    let status = &model.status;
    ui.horizontal(|ui| {
        ui.set_min_height(20.0);
        let progress = status.samples as f32 / status.target.max(1) as f32;
        let bar = egui::ProgressBar::new(progress.clamp(0.0, 1.0))
            .desired_width(150.0)
            .desired_height(14.0)
            .text(format!("{} / {} spp", status.samples, status.target));
        ui.label(state_name(status));
        ui.add(bar)
            .on_hover_text("Samples per pixel: those that are done, and those that are wanted");
        for (part, hint) in parts(model) {
            // The last entries matter least: they are left out if there is no room.
            let font = egui::TextStyle::Body.resolve(ui.style());
            let color = egui::Color32::PLACEHOLDER;
            let width = ui.painter().layout_no_wrap(part.clone(), font, color).size().x;
            if ui.available_width() < width + MARGIN {
                break;
            }
            ui.separator();
            ui.label(part).on_hover_text(hint);
        }
    });
}

/// The texts with what they mean, the most important first.
fn parts(model: &StatusModel) -> Vec<(String, &'static str)> {
    let status = &model.status;
    let mut parts = vec![
        (
            format!("{} × {}", status.size.x, status.size.y),
            "Pixels of the picture",
        ),
        (time(status), "Time spent on the picture, and left"),
        (
            format!("{:.2} Mrays/s", status.mrays_per_s),
            "Millions of rays traced in a second",
        ),
    ];
    if status.invalid_samples > 0 {
        parts.push((
            counted(status.invalid_samples, "invalid sample"),
            "Left out of the picture, as they were no numbers",
        ));
    }
    match model.denoiser {
        DenoiserState::Running => parts.push(("denoising".to_owned(), "The picture goes on meanwhile")),
        DenoiserState::Shown { seconds, samples } => parts.push((
            format!("denoised at {samples} spp in {seconds:.2} s"),
            "What is shown; the picture behind it goes on",
        )),
        DenoiserState::Idle | DenoiserState::Unavailable => {}
    }
    if status.triangles > 0 {
        parts.push((
            counted(status.triangles, "triangle"),
            "Of the scene, each instance counted",
        ));
    }
    if let Some(latency) = status.latency.median_ms() {
        parts.push((
            format!("latency {latency:.0} ms"),
            "From an edit to its first pixels, median",
        ));
    }
    if let Some(frame) = model.frame_ms {
        parts.push((
            format!("frame {frame:.0} ms"),
            "Between two pictures of the window, median",
        ));
    }
    // Even an empty hierarchy has a root.
    if status.bvh.leaves > 0 {
        parts.push((
            format!("{}, {:.1} ms", counted(status.bvh.nodes, "node"), status.bvh.build_ms),
            "Of the bounding volume hierarchy, and how long it took to build",
        ));
    }
    parts
}

/// The time, such as `0:12, 0:48 left`.
fn time(status: &RenderStatus) -> String {
    let spent = clock(status.seconds);
    if status.state != RenderState::Rendering || status.samples == 0 || status.samples >= status.target {
        return spent;
    }
    let left = status.seconds * f64::from(status.target - status.samples) / f64::from(status.samples);
    format!("{spent}, {} left", clock(left))
}

pub(crate) fn state_name(status: &RenderStatus) -> &'static str {
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

/// The part of so many samples of every pixel that is done, from 0 to 1, and the seconds until all are; None before that can be known.
pub(crate) fn progress_of(status: &RenderStatus, samples: u32) -> (f32, Option<f64>) {
    let pixels = f64::from(status.size.x) * f64::from(status.size.y);
    let wanted = pixels * f64::from(samples.max(1));
    let per_second = 1e6 * status.msamples_per_s;
    let done = (per_second * status.seconds).min(wanted);
    let is_known = status.state == RenderState::Rendering && per_second > 0.0;
    let share = if wanted > 0.0 { done / wanted } else { 0.0 };
    (share as f32, is_known.then(|| (wanted - done) / per_second))
}

/// The time as `1:02` or `1:01:02`.
pub(crate) fn clock(seconds: f64) -> String {
    let whole = seconds.max(0.0) as u64;
    let (hours, minutes, rest) = (whole / 3600, whole / 60 % 60, whole % 60);
    match hours {
        0 if whole < 60 => format!("{seconds:.1} s"),
        0 => format!("{minutes}:{rest:02}"),
        _ => format!("{hours}:{minutes:02}:{rest:02}"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::app::editor::words::figures::grouped;

    #[test]
    fn the_time_left_is_as_long_as_the_samples_left() {
        let status = RenderStatus {
            state: RenderState::Rendering,
            samples: 16,
            target: 64,
            seconds: 30.0,
            ..RenderStatus::default()
        };
        assert_eq!(time(&status), "30.0 s, 1:30 left");
        let done = RenderStatus {
            samples: 64,
            ..status.clone()
        };
        assert_eq!(time(&done), "30.0 s");
    }

    #[test]
    fn numbers_and_times_are_legible() {
        assert_eq!(grouped(871_414), "871,414");
        assert_eq!(grouped(12), "12");
        let texts = [counted(1, "node"), counted(0, "node"), counted(2345, "leaf")];
        assert_eq!(texts, ["1 node", "0 nodes", "2,345 leaves"]);
        assert_eq!(clock(5.25), "5.2 s");
        assert_eq!(clock(3723.0), "1:02:03");
        assert_eq!(clock(62.9), "1:02");
    }
}
