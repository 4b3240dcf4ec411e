//! The panel of the paths of a pixel: at each vertex the surface hit, the sampled light and the continuation of the
//! path, with the densities and weights of multiple importance sampling.

use bevy_egui::egui::{self, Color32, RichText, Ui};

use super::fields;
use super::lamp_light::lamp_light;
use super::reasons::reasons;
use super::section::section;
use crate::app::editor::command::inspected_paths::InspectedPaths;
use crate::app::editor::command::{Command, ToolCommand};
use crate::app::editor::picture::lamp_light::LampFollower;
use crate::app::editor::picture::paths::{NamedPath, PathInspector};
use crate::app::editor::picture::reasons::Reasons;
use crate::color::Rgb;
use crate::material::Lobe;
use crate::render::breakdown::Area;
use crate::render::inspect::{RecordedPath, RecordedVertex};
use crate::render::observer::{MetEmitter, PathEnd};
use crate::render::tonemap::Display;

/// Shows why the inspected place is as it is, its paths, and the vertices of the chosen one.
pub fn paths(
    ui: &mut Ui,
    inspector: &PathInspector,
    known: &Reasons,
    follower: &LampFollower,
    commands: &mut Vec<Command>,
) {
    fields::leave_scroll_bar(ui);
    lamp_light(ui, follower, commands);
    let Some(wanted) = inspector.wanted else {
        ui.add_space(8.0);
        ui.weak(
            "Press P and click a pixel, or drag a rectangle: where its light comes from is told here, and its paths are drawn into the picture.",
        );
        return;
    };
    let mut edited = wanted;
    ui.horizontal(|ui| {
        ui.label(match inspector.area {
            Some(Area {
                x,
                y,
                width: 1,
                height: 1,
            }) => format!("Pixel {x}, {y}"),
            Some(Area { x, y, width, height }) => format!("{width} x {height} pixels from {x}, {y} on"),
            None => String::new(),
        });
        if ui.button("Close").on_hover_text("Stop drawing paths (Esc)").clicked() {
            commands.push(ToolCommand::InspectPaths(None).into());
        }
    });
    section(ui, "Why is it like this?", |ui| {
        reasons(ui, known, &mut edited, commands)
    });
    section(ui, "Paths", |ui| path_rows(ui, inspector, &mut edited));
    if edited != wanted {
        commands.push(ToolCommand::InspectPaths(Some(edited)).into());
    }
}

/// Shows the choice of a path, and each of its vertices.
fn path_rows(ui: &mut Ui, inspector: &PathInspector, edited: &mut InspectedPaths) {
    let wanted = *edited;
    let paths = &inspector.paths;
    if let Some(all) = wanted.of.and(Some("Show all paths")) {
        ui.horizontal_wrapped(|ui| {
            ui.weak("Paths of the chosen light only.");
            if ui.button(all).clicked() {
                edited.of = None;
            }
        });
    }
    fields::integer_slider(ui, "Paths", &mut edited.count, 1..=InspectedPaths::MOST, true);
    ui.horizontal_wrapped(|ui| {
        ui.spacing_mut().item_spacing = egui::vec2(3.0, 3.0);
        for (index, path) in (0..).zip(paths.iter()) {
            if swatch(ui, path, index == wanted.chosen) {
                edited.chosen = index;
            }
        }
    });
    edited.chosen = edited.chosen.min(edited.count.saturating_sub(1));
    let Some(NamedPath { path, names }) = paths.get(wanted.chosen as usize) else {
        return;
    };
    ui.separator();
    ui.label(format!("Sample {}: {}", path.sample, color(path.radiance)));
    for (number, (vertex, (shape, material))) in (1..).zip(path.vertices.iter().zip(names)) {
        ui.add_space(4.0);
        ui.horizontal_wrapped(|ui| {
            ui.strong(format!("{number}. {shape}"));
            ui.weak(material);
        });
        vertex_rows(ui, vertex);
    }
    light_path_rows(ui, path);
    for met in &path.escaped_to {
        ui.add_space(4.0);
        ui.strong("Surroundings");
        met_rows(ui, met);
    }
    ui.add_space(4.0);
    ui.weak(match path.end {
        PathEnd::Escaped => "It left the scene.",
        PathEnd::DepthLimit => "It is as long as it may be.",
        PathEnd::Absorbed => "It was absorbed.",
        PathEnd::Roulette => "Russian roulette ended it.",
    });
}

/// A button in the colour of the path's contribution; returns true when clicked.
fn swatch(ui: &mut Ui, path: &NamedPath, chosen: bool) -> bool {
    let [r, g, b] = Display::default().encode(path.path.radiance);
    let (rect, response) = ui.allocate_exact_size(egui::vec2(18.0, 18.0), egui::Sense::click());
    let stroke = if chosen {
        egui::Stroke::new(2.0, ui.visuals().selection.stroke.color)
    } else {
        ui.visuals().widgets.inactive.bg_stroke
    };
    ui.painter()
        .rect(rect, 2.0, Color32::from_rgb(r, g, b), stroke, egui::StrokeKind::Inside);
    let help = format!("Sample {}: {}", path.path.sample, color(path.path.radiance));
    response.widget_info(|| egui::WidgetInfo::selected(egui::WidgetType::Button, true, chosen, &help));
    response.on_hover_text(help).clicked()
}

fn vertex_rows(ui: &mut Ui, vertex: &RecordedVertex) {
    if let Some(met) = &vertex.met {
        met_rows(ui, met);
    }
    if let Some(sampled) = &vertex.sampled {
        let outcome = match sampled.arriving {
            None => "turned away",
            Some(arriving) if arriving == Rgb::ZERO => "blocked",
            Some(_) => "reached",
        };
        row(
            ui,
            "Light sampled",
            outcome,
            "Next event estimation: a light was looked for from here",
        );
        row(
            ui,
            "  pdf light",
            density(sampled.sample.pdf),
            "Density per solid angle of choosing this point of the light",
        );
        row(
            ui,
            "  pdf bsdf",
            density(sampled.bsdf_pdf),
            "Density with which the bsdf would have chosen the direction",
        );
        weight_rows(ui, sampled.weight, sampled.contribution);
    }
    if let Some(joined) = &vertex.joined {
        row(
            ui,
            "Joined",
            "reached",
            "A vertex of the path from a light was chosen, and can be seen from here",
        );
        weight_rows(ui, joined.weight, joined.contribution);
    }
    if let Some(bounce) = &vertex.bounce {
        let lobe = match bounce.lobe {
            Lobe::Smooth => "smooth",
            Lobe::Delta => "specular",
            Lobe::Null => "passes",
        };
        row(ui, "Bounce", lobe, "The kind of scattering that was sampled");
        row(
            ui,
            "  pdf bsdf",
            density(bounce.pdf),
            "Density per solid angle; of specular lobes the probability of choosing them",
        );
        if bounce.survival < 1.0 {
            row(
                ui,
                "  survival",
                format!("{:.3}", bounce.survival),
                "Russian roulette let it live with this probability",
            );
        }
        row(
            ui,
            "  throughput",
            color(bounce.throughput),
            "What light from there counts in the pixel from now on",
        );
    }
}

fn met_rows(ui: &mut Ui, met: &MetEmitter) {
    row(
        ui,
        "Light met",
        color(met.radiance),
        "The path came upon a light by itself",
    );
    if let Some(pdf) = met.bsdf_pdf {
        row(
            ui,
            "  pdf bsdf",
            density(pdf),
            "Density per solid angle with which the bsdf chose the direction",
        );
    }
    if let Some(pdf) = met.light_pdf {
        row(
            ui,
            "  pdf light",
            density(pdf),
            "Density with which sampling the lights would have chosen it",
        );
    }
    weight_rows(ui, met.weight, met.contribution);
}

fn weight_rows(ui: &mut Ui, weight: f32, contribution: Rgb) {
    row(
        ui,
        "  MIS weight",
        format!("{weight:.3}"),
        "Power heuristic of the densities of all ways to find this path",
    );
    row(
        ui,
        "  contribution",
        color(contribution),
        "What it adds to the path's radiance",
    );
}

/// Shows the light subpath, and its contribution to the lens.
fn light_path_rows(ui: &mut Ui, path: &RecordedPath) {
    if path.light_path.is_empty() {
        return;
    }
    ui.add_space(4.0);
    ui.strong("Path from a light");
    let vertices = path.light_path.len() - 1;
    row(
        ui,
        "Vertices",
        vertices.to_string(),
        "Places on surfaces, behind the start at the light",
    );
    for splat in &path.splats {
        row(
            ui,
            &format!("To {}, {}", splat.pixel.x, splat.pixel.y),
            color(splat.radiance),
            "Light that a vertex has sent through the lens to this pixel",
        );
    }
}

fn row(ui: &mut Ui, name: &str, value: impl Into<String>, help: &str) {
    ui.horizontal(|ui| {
        let size = egui::vec2(92.0, 16.0);
        let layout = egui::Layout::left_to_right(egui::Align::Center);
        let cell = ui.allocate_ui_with_layout(size, layout, |ui| {
            ui.set_min_size(size);
            ui.weak(name)
        });
        cell.inner.on_hover_text(help);
        ui.label(RichText::new(value).monospace());
    });
}

fn density(pdf: f32) -> String {
    if pdf == 0.0 || (1e-2..1e4).contains(&pdf) {
        format!("{pdf:.3}")
    } else {
        format!("{pdf:.2e}")
    }
}

fn color(color: Rgb) -> String {
    let [r, g, b] = color.to_array().map(density);
    format!("{r} {g} {b}")
}
