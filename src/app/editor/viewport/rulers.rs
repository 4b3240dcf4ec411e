//! Measuring: the point under the pointer, and the measured distances.

use bevy::math::Vec3;
use bevy_egui::egui::{self, Color32, Painter, Pos2, Stroke};

use super::marks::Tags;
use super::model::ViewportModel;
use crate::app::editor::camera::ground::GridPlane;
use crate::app::editor::camera::screen::Screen;
use crate::app::editor::camera::snapping;
use crate::app::editor::command::ruler::Ruler;
use crate::app::editor::command::snapping::SnapTo;
use crate::app::editor::command::tool::Tool;
use crate::scene::LengthUnit;

const COLOR: Color32 = Color32::from_rgb(255, 214, 90);
const EDGE: Color32 = Color32::from_black_alpha(170);

/// The measured point at a point of the window: a corner if one is near, else the surface there, else the ground.
pub(super) fn point_at(pointer: Pos2, screen: &Screen, model: &ViewportModel) -> Option<Vec3> {
    let nearest = |to| snapping::find(model.packed, screen, pointer, to, |_| false).map(|found| found.place);
    let on_ground = || GridPlane::of(screen, model.navigation.up).hit(&screen.ray(pointer));
    nearest(SnapTo::Vertices)
        .or_else(|| nearest(SnapTo::Faces))
        .or_else(on_ground)
}

/// Paints the distances, and the unfinished one from `begun` to the pointer.
pub(super) fn paint(
    painter: &Painter,
    screen: &Screen,
    model: &ViewportModel,
    begun: Option<Vec3>,
    pointer: Option<Pos2>,
    tags: &mut Tags,
) {
    for ruler in model.rulers {
        paint_ruler(painter, screen, ruler, model.gizmo.unit, tags);
    }
    if model.keys.tool != Tool::Ruler {
        return;
    }
    let under = pointer
        .filter(|pointer| screen.picture.contains(*pointer))
        .and_then(|pointer| point_at(pointer, screen, model));
    if let Some(at) = under.and_then(|point| screen.project(point)) {
        dot(painter, at);
    }
    if let (Some(from), Some(to)) = (begun, under) {
        paint_ruler(painter, screen, &Ruler { from, to }, model.gizmo.unit, tags);
    }
}

fn paint_ruler(painter: &Painter, screen: &Screen, ruler: &Ruler, unit: LengthUnit, tags: &mut Tags) {
    let Some(ends) = screen.segment(ruler.from, ruler.to) else {
        return;
    };
    painter.line_segment(ends, Stroke::new(3.5, EDGE));
    painter.line_segment(ends, Stroke::new(1.5, COLOR));
    for at in [ruler.from, ruler.to].into_iter().filter_map(|end| screen.project(end)) {
        dot(painter, at);
    }
    let middle = ends[0].lerp(ends[1], 0.5) - egui::vec2(0.0, 20.0);
    tags.tag(painter, middle, &ruler.text(unit));
}

fn dot(painter: &Painter, at: Pos2) {
    painter.circle(at, 3.5, COLOR, Stroke::new(1.0, EDGE));
}
