//! The line at the bottom: the activity of the renderer and its speed.

use std::borrow::Cow;

use bevy::math::UVec2;
use bevy_egui::egui::{self, Ui};

use crate::app::editor::input::number_field;
use crate::app::editor::model::StatusModel;
use crate::app::editor::picture::denoiser::DenoiserState;
use crate::app::editor::words::figures::counted;
use crate::engine::{AutoStatus, RenderState, RenderStatus, StopReason};
use crate::render::auto::{Choice, Method};

/// The room for the separator before a part.
const MARGIN: f32 = 22.0;
/// The factor from which on rays count as traced more slowly than possible.
const SLOWED: f64 = 1.05;
/// The size of the curve of the noise in points, and the number of its points.
const CURVE: egui::Vec2 = egui::vec2(40.0, 12.0);
const CURVE_POINTS: usize = 21;

/// Shows one line: the renderer's activity, samples, time, speed and noise.
pub fn status_line(ui: &mut Ui, model: &StatusModel, pointed: Option<&str>) {
    let status = &model.status;
    ui.horizontal(|ui| {
        ui.set_min_height(20.0);
        let bar = egui::ProgressBar::new(status.done() as f32)
            .desired_width(150.0)
            .desired_height(14.0)
            .text(format!("{} / {} spp", status.samples, status.target));
        ui.label(state_name(status));
        if let Some(note) = number_field::told(ui.ctx()) {
            ui.colored_label(ui.visuals().warn_fg_color, note);
            ui.separator();
        }
        ui.add(bar)
            .on_hover_text("Samples per pixel: those that are done, and those that are wanted. A limit of time or noise may end the picture sooner");
        for part in parts(model, pointed) {
            // The last entries matter least: they are left out if there is no room.
            let font = egui::TextStyle::Body.resolve(ui.style());
            let color = egui::Color32::PLACEHOLDER;
            let words = ui.painter().layout_no_wrap(part.text.clone(), font, color).size().x;
            let curve = if part.trend.is_empty() { 0.0 } else { CURVE.x + MARGIN };
            if ui.available_width() < words + curve + MARGIN {
                break;
            }
            ui.separator();
            ui.label(part.text).on_hover_text(&*part.hint);
            if !part.trend.is_empty() {
                trend(ui, &part.trend).on_hover_text(&*part.hint);
            }
        }
    });
}

/// One entry of the line.
struct Part {
    text: String,
    /// The meaning of the text, as a tool tip.
    hint: Cow<'static, str>,
    /// The heights of a curve beside the text, from 0 to 1; empty without one.
    trend: Vec<f32>,
}

impl Part {
    fn new(text: impl Into<String>, hint: impl Into<Cow<'static, str>>) -> Self {
        Self {
            text: text.into(),
            hint: hint.into(),
            trend: Vec::new(),
        }
    }
}

/// The entries, the most important first.
fn parts(model: &StatusModel, pointed: Option<&str>) -> Vec<Part> {
    let status = &model.status;
    let mut parts = vec![
        size(status),
        Part::new(time(status), "Time spent on the picture, and left"),
    ];
    parts.extend(pointed.map(|light| {
        let hint = "Luminance of the pixel under the pointer with its standard error, or the illuminance there in that display mode; \
                    an unknown error is a question mark";
        Part::new(light, hint)
    }));
    parts.extend(noise(model));
    parts.extend(status.auto.as_ref().map(auto));
    parts.push(rays_per_second(status));
    if status.invalid_samples > 0 {
        parts.push(Part::new(
            counted(status.invalid_samples, "invalid sample"),
            "Left out of the picture, as they were no numbers",
        ));
    }
    match model.denoiser {
        DenoiserState::Shown { seconds, samples } => parts.push(Part::new(
            format!(
                "denoised at {samples} spp in {seconds:.decimals$} s",
                decimals = if seconds < 10.0 { 2 } else { 0 }
            ),
            "What is shown; the picture behind it goes on",
        )),
        DenoiserState::Off | DenoiserState::Waiting | DenoiserState::Unavailable => {}
    }
    if status.triangles > 0 {
        parts.push(Part::new(
            counted(status.triangles, "triangle"),
            "Triangles of the scene; those of an instance count each time that it is placed",
        ));
    }
    if model.developer_figures {
        developer_parts(model, &mut parts);
    }
    parts
}

fn developer_parts(model: &StatusModel, parts: &mut Vec<Part>) {
    let status = &model.status;
    if let Some(latency) = status.latency.median_ms() {
        parts.push(Part::new(
            format!("latency {latency:.0} ms"),
            "From an edit to its first pixels, median",
        ));
    }
    if let Some(frame) = model.frame_ms {
        parts.push(Part::new(
            format!("frame {frame:.0} ms"),
            "Between two pictures of the window, median",
        ));
    }
    // An empty hierarchy has a root, too, but no leaves.
    if status.bvh.leaves > 0 {
        parts.push(Part::new(
            format!("{}, {:.1} ms", counted(status.bvh.nodes, "node"), status.bvh.build_ms),
            "Of the bounding volume hierarchy, and how long it took to build",
        ));
    }
}

/// The speed of tracing, and the speed it would have if the window used no processor time.
fn rays_per_second(status: &RenderStatus) -> Part {
    let [now, undisturbed] = [status.mrays_per_s, status.undisturbed_mrays_per_s];
    match undisturbed > SLOWED * now {
        true => Part::new(
            format!("{now:.2} of {undisturbed:.2} Mrays/s"),
            "Millions of rays traced in a second, and how many it would be if the window, the denoiser and other programs took nothing of the processors",
        ),
        false => Part::new(format!("{now:.2} Mrays/s"), "Millions of rays traced in a second"),
    }
}

/// The rendered pixels, and those of the film if they are more.
fn size(status: &RenderStatus) -> Part {
    let (size, full) = (status.size, status.full_size);
    let traced = format!("{} × {}", size.x, size.y);
    if status.is_beyond_film {
        let hint = format!(
            "Pixels of the view, which fills its place in the window; a saved picture has the {} × {} pixels of the film",
            full.x, full.y
        );
        return Part::new(traced, hint);
    }
    if size.x >= full.x && size.y >= full.y {
        return Part::new(traced, "Pixels of the picture");
    }
    if size == UVec2::ZERO {
        return Part::new(format!("{} × {}", full.x, full.y), "Pixels of the film");
    }
    Part::new(
        format!("{traced} of {} × {}", full.x, full.y),
        "Pixels of the picture, which are those that the window shows, and pixels of the film; Render full film traces all of them",
    )
}

/// The choice of the integrator `auto`.
fn auto(auto: &AutoStatus) -> Part {
    let hint =
        "What the integrator auto stands for; Light transport in the panel Render says why, and can name another one";
    Part::new(format!("auto: {}", auto.integrator), hint)
}

/// The choice of the integrator `auto`, and its reason.
pub fn auto_words(auto: &AutoStatus) -> String {
    let name = auto.integrator;
    let Choice {
        method,
        gain,
        gain_of_guide,
        ..
    } = auto.choice;
    match (method, gain) {
        _ if auto.is_searching => format!("{name}, while a pilot is traced"),
        (_, None) => name.to_owned(),
        (Method::Path, Some(gain)) => format!(
            "{name}: bdpt has {:.1} times the variance of path for the cost",
            gain.recip()
        ),
        (Method::GuidedPath, Some(gain)) => {
            let gain = gain_of_guide.unwrap_or(gain);
            format!("{name}: {gain:.1} times less variance for its cost")
        }
        (Method::Bidirectional, Some(gain)) => format!("{name}: {gain:.1} times less variance for its cost"),
    }
}

/// The noise, and its trend.
fn noise(model: &StatusModel) -> Option<Part> {
    let noise = model.status.noise?;
    let points = model.noise_trend.points();
    let half = points
        .iter()
        .rev()
        .find(|(samples, _)| 2 * samples <= model.status.samples);
    let before = half.map_or(String::new(), |(samples, before)| {
        format!(
            " It was {} at {}.",
            percent(*before),
            counted((*samples).into(), "sample")
        )
    });
    let is_done = model.status.state == RenderState::Done;
    let missed = model.status.missed_noise().filter(|_| is_done);
    let stopped_by = match model.status.stopped_by {
        Some(StopReason::Time) => "Limit time",
        _ => "Samples",
    };
    let more = match missed {
        Some(_) => format!(
            "{stopped_by} in Render has ended the picture before Limit noise: raise {stopped_by}, and the picture goes on."
        ),
        None => "Limit noise in Render stops at a value.".to_owned(),
    };
    let noise = percent(noise);
    Some(Part {
        text: match (missed, model.status.noise_target) {
            (Some(limit), _) => format!("noise {noise}, limit {} not reached", percent(limit)),
            (None, Some(target)) => format!("noise {noise}, limit {}", percent(target)),
            (None, None) => format!("noise {noise}"),
        },
        hint: format!("The error that is expected of a pixel, as a share of the picture's brightness.{before} {more}")
            .into(),
        trend: heights(points),
    })
}

/// A share as a percentage with two digits or more. That of a picture which is nothing but noise has no digits.
pub(super) fn percent(share: f32) -> String {
    if share > 1.0 {
        return "above 100 %".to_owned();
    }
    let percent = 100.0 * share;
    let decimals = usize::from(percent < 10.0) + usize::from(percent < 1.0);
    format!("{percent:.decimals$} %")
}

/// The heights of the curve, with both axes as logarithms: noise falls along a straight line there. Empty without two
/// points.
fn heights(points: &[(u32, f32)]) -> Vec<f32> {
    let [(first, _), .., (last, _)] = points else {
        return Vec::new();
    };
    let log = |noise: f32| noise.max(1e-6).ln();
    let (from, to) = ((*first as f32).ln(), (*last as f32).ln());
    let at = |share: f32| {
        let wanted = from + share * (to - from);
        let known = points
            .iter()
            .rev()
            .find(|(samples, _)| (*samples as f32).ln() <= wanted + 1e-4);
        log(known.unwrap_or(&points[0]).1)
    };
    let heights: Vec<f32> = (0..CURVE_POINTS)
        .map(|k| at(k as f32 / (CURVE_POINTS - 1) as f32))
        .collect();
    let (low, high) = heights.iter().fold((f32::MAX, f32::MIN), |(low, high), &height| {
        (low.min(height), high.max(height))
    });
    let range = (high - low).max(1e-3);
    heights.iter().map(|height| (height - low) / range).collect()
}

/// Paints a small curve.
fn trend(ui: &mut Ui, heights: &[f32]) -> egui::Response {
    let (rect, response) = ui.allocate_exact_size(CURVE, egui::Sense::hover());
    let step = rect.width() / (heights.len().max(2) - 1) as f32;
    let points = heights.iter().zip(0..).map(|(height, k)| {
        egui::pos2(
            rect.left() + step * k as f32,
            egui::lerp(rect.bottom() - 1.0..=rect.top() + 1.0, *height),
        )
    });
    let stroke = egui::Stroke::new(1.0, ui.visuals().text_color());
    ui.painter().line(points.collect(), stroke);
    response
}

/// The time, such as `1:12, 4 min left`.
fn time(status: &RenderStatus) -> String {
    let spent = clock(status.seconds);
    match status.seconds_left().filter(|left| *left > 0.0) {
        Some(left) => format!("{spent}, {} left", roughly(left)),
        None => spent,
    }
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

/// The share of the wanted samples that is done, from 0 to 1, and the seconds until all are done; None while that is
/// unknown.
pub(crate) fn progress_of(status: &RenderStatus, samples: u32) -> (f32, Option<f64>) {
    let pixels = f64::from(status.size.x) * f64::from(status.size.y);
    let wanted = pixels * f64::from(samples.max(1));
    let per_second = 1e6 * status.msamples_per_s;
    let done = (per_second * status.seconds).min(wanted);
    let is_known = status.state == RenderState::Rendering && per_second > 0.0;
    let share = if wanted > 0.0 { done / wanted } else { 0.0 };
    (share as f32, is_known.then(|| (wanted - done) / per_second))
}

/// An estimated time, in so many digits as it deserves: `8 s`, `90 s`, `4 min`, `1.5 h`, `12 h`; at least a second.
pub(crate) fn roughly(seconds: f64) -> String {
    let seconds = seconds.max(1.0);
    // The bounds are those from which on the number of the smaller unit would be rounded up to them.
    match seconds {
        ..10.0 => format!("{:.0} s", seconds.ceil()),
        ..117.5 => format!("{:.0} s", 5.0 * (seconds / 5.0).round()),
        ..5370.0 => format!("{:.0} min", (seconds / 60.0).round()),
        ..35_820.0 => format!("{:.1} h", seconds / 3600.0),
        _ => format!("{:.0} h", (seconds / 3600.0).round()),
    }
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
        assert_eq!(time(&status), "30.0 s, 90 s left");
        let done = RenderStatus {
            samples: 64,
            ..status.clone()
        };
        assert_eq!(time(&done), "30.0 s");
        // Half of the noise takes more than three times the samples.
        let quiet = RenderStatus {
            target: u32::MAX,
            noise: Some(0.02),
            noise_target: Some(0.01),
            ..status.clone()
        };
        assert_eq!(time(&quiet), "30.0 s, 65 s left");
        let short = RenderStatus {
            time_limit: Some(45.0),
            ..quiet
        };
        assert_eq!(time(&short), "30.0 s, 15 s left");
    }

    #[test]
    fn an_estimate_has_no_more_digits_than_it_deserves() {
        let cases = [
            (0.0, "1 s"),
            (0.2, "1 s"),
            (12.3, "10 s"),
            (89.0, "90 s"),
            (119.0, "2 min"),
            (250.0, "4 min"),
            (5_360.0, "89 min"),
            (5_380.0, "1.5 h"),
            (10_474.0, "2.9 h"),
            (35_900.0, "10 h"),
        ];
        for (seconds, text) in cases {
            assert_eq!(roughly(seconds), text);
        }
    }

    #[test]
    fn the_noise_is_shown_with_its_fall() {
        let mut model = StatusModel::default();
        assert!(noise(&model).is_none());
        for samples in [2, 4, 8, 16, 32, 64] {
            model.status.samples = samples;
            model.status.noise = Some(0.4 / (samples as f32).sqrt());
            model.noise_trend.note(1, samples, model.status.noise);
        }
        let part = noise(&model).expect("it is known");
        assert_eq!(part.text, "noise 5.0 %");
        assert!(part.hint.contains("It was 7.1 % at 32 samples."), "{}", part.hint);
        assert_eq!((part.trend[0], part.trend[CURVE_POINTS - 1]), (1.0, 0.0));
        assert!(part.trend.windows(2).all(|pair| pair[0] >= pair[1]));
        assert_eq!(
            [percent(0.123), percent(0.0042), percent(75.2)],
            ["12 %", "0.42 %", "above 100 %"]
        );

        // A limit that was not reached is reported once the picture has ended.
        model.status.noise_target = Some(0.02);
        assert_eq!(noise(&model).expect("it is known").text, "noise 5.0 %, limit 2.0 %");
        model.status.noise = Some(75.0);
        assert_eq!(
            noise(&model).expect("it is known").text,
            "noise above 100 %, limit 2.0 %"
        );
        model.status.noise = Some(0.05);
        model.status.state = RenderState::Done;
        model.status.stopped_by = Some(StopReason::Samples);
        let part = noise(&model).expect("it is known");
        assert_eq!(part.text, "noise 5.0 %, limit 2.0 % not reached");
        assert!(part.hint.contains("Samples in Render has ended"), "{}", part.hint);
        model.status.noise = Some(0.02);
        model.status.stopped_by = Some(StopReason::Noise);
        assert_eq!(noise(&model).expect("it is known").text, "noise 2.0 %, limit 2.0 %");
    }

    #[test]
    fn only_a_denoised_picture_is_called_denoised() {
        let told = |denoiser: DenoiserState| {
            let model = StatusModel {
                denoiser,
                ..StatusModel::default()
            };
            parts(&model, None).iter().any(|part| part.text.starts_with("denoised"))
        };
        let shown = DenoiserState::Shown {
            samples: 16,
            seconds: 0.25,
        };
        assert!(told(shown) && !told(DenoiserState::Waiting));
    }

    #[test]
    fn a_smaller_picture_is_told_with_its_film() {
        let text = |size: [u32; 2], full: [u32; 2]| {
            let status = RenderStatus {
                size: size.into(),
                full_size: full.into(),
                ..RenderStatus::default()
            };
            super::size(&status).text
        };
        assert_eq!(text([800, 600], [800, 600]), "800 × 600");
        assert_eq!(text([1000, 562], [3840, 2160]), "1000 × 562 of 3840 × 2160");
        assert_eq!(text([0, 0], [800, 600]), "800 × 600", "nothing is rendered yet");
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
