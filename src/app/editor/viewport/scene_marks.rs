//! Paints the marks that have their place in the scene: icons, handles, distances, names, lines.

use bevy_egui::egui::{self, Align2, Color32, Shape, Stroke, Ui};

use super::icons::IconKind;
use super::marks::{Tags, tag};
use super::model::ViewportModel;
use super::state::ViewportState;
use super::{extent, icons, lamp_solid, path_lines, rulers, series, stand_ins, volume_boxes};
use crate::app::editor::camera::screen::Screen;
use crate::app::editor::picture::outline::Level;
use crate::app::editor::picture::overlay::edges;

const SCENE_BOX: Color32 = Color32::from_rgba_premultiplied(60, 200, 90, 200);
const WIRE: Color32 = Color32::from_rgba_premultiplied(190, 150, 60, 200);
const MESH_BOX: Color32 = Color32::from_rgba_premultiplied(60, 130, 230, 160);

/// Paints what has its place in the scene. `has_pointer` says that this is the view in which the mouse is used.
pub(super) fn paint_scene(
    ui: &Ui,
    painter: &egui::Painter,
    screen: &Screen,
    model: &ViewportModel,
    state: &ViewportState,
    has_pointer: bool,
) {
    paint_lines(painter, screen, model);
    let pointer = ui.input(|input| input.pointer.latest_pos()).filter(|_| has_pointer);
    let chosen = model.paths.wanted.map_or(0, |wanted| wanted.chosen as usize);
    path_lines::paint(painter, screen, &model.paths.paths, chosen, model.navigation.scene_size);
    let level = |entity| Level::of(entity, model.keys.selection, state.pointer.hovered);
    icons::paint_paths(painter, screen, model.marker_paths, |entity, tint| {
        match level(entity) {
            Level::None => tint,
            level => level.color(),
        }
    });
    icons::paint(painter, screen, model.icons, |icon| match level(icon.entity) {
        Level::None if icon.kind == IconKind::StandIn => stand_ins::COLOR,
        level @ Level::None => icon.tint.unwrap_or(level.color()),
        level => level.color(),
    });
    let mut tags = Tags::default();
    stand_ins::paint_names(painter, screen, model.stand_ins, &mut tags);
    if model.keys.dimensions
        && let Some(bounds) = model.extent
    {
        extent::paint(painter, screen, &bounds, model.gizmo.unit, &mut tags);
    }
    if let Some(series) = &model.series {
        series::paint(painter, screen, series, model.gizmo.targets);
    }
    let begun = state.pointer.measured_from;
    rulers::paint(painter, screen, model, begun, pointer, &mut tags);
    let tool = state.tool(model.keys.tool);
    tool.paint(painter, screen, model, pointer);
    state.grips.paint_grips(painter, screen, &model.grips(), has_pointer);
    state.path_grips.paint(painter, screen, &model.path_grips());
    state.pointer.paint(painter, pointer);
    if let Some(note) = state.gizmo.note(screen, &model.gizmo).filter(|_| has_pointer) {
        tag(
            painter,
            screen.picture.center_bottom() - egui::vec2(0.0, 8.0),
            Align2::CENTER_BOTTOM,
            &note,
        );
    }
}

/// Paints the boxes of the hierarchy, the wireframe and the boxes of volumes.
fn paint_lines(painter: &egui::Painter, screen: &Screen, model: &ViewportModel) {
    if model.keys.overlay.shown {
        for world_box in &model.boxes.boxes {
            let color = if world_box.over_instances { SCENE_BOX } else { MESH_BOX };
            let lines = edges(&screen.camera, world_box)
                .into_iter()
                .map(|ends| Shape::line_segment(ends.map(|film| screen.point_of_film(film)), Stroke::new(1.0, color)));
            painter.extend(lines);
        }
    }
    let lines = (model.wireframe.lines.iter()).filter_map(|[from, to]| screen.segment(*from, *to));
    painter.extend(lines.map(|ends| Shape::line_segment(ends, Stroke::new(1.0, WIRE))));
    volume_boxes::paint(painter, screen, model.volume_boxes);
    if let Some(solid) = model.lamp_solid {
        lamp_solid::paint(painter, screen, solid);
    }
}
