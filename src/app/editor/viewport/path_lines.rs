//! Paths drawn into the picture: their segments from the camera on, the light samples at each vertex, their ends, and
//! the light subpaths that they were connected with.

use bevy::math::Vec3;
use bevy_egui::egui::{self, Color32, Shape, Stroke};

use super::marks::tag;
use crate::app::editor::camera::screen::Screen;
use crate::app::editor::picture::paths::NamedPath;
use crate::light::Target;
use crate::math::Ray;

/// The length of rays that hit nothing, as a share of the scene's size.
const VOID: f32 = 0.5;
const CHOSEN: Color32 = Color32::from_rgb(90, 190, 255);
const OTHER: Color32 = Color32::from_rgba_premultiplied(50, 80, 100, 110);
const REACHED: Color32 = Color32::from_rgb(255, 220, 70);
const BLOCKED: Color32 = Color32::from_rgb(230, 70, 60);
const FROM_LIGHT: Color32 = Color32::from_rgb(255, 150, 40);

/// Paints the paths. `chosen` is the one that is drawn in full, the others are faint. `scene_size` is in world units.
pub fn paint(painter: &egui::Painter, screen: &Screen, paths: &[NamedPath], chosen: usize, scene_size: f32) {
    for (index, path) in paths.iter().enumerate() {
        if index != chosen {
            let line = Stroke::new(1.0, OTHER);
            painter.extend(
                segments(path, scene_size)
                    .filter_map(|[a, b]| screen.segment(a, b))
                    .map(|ends| Shape::line_segment(ends, line)),
            );
        }
    }
    let Some(path) = paths.get(chosen) else {
        return;
    };
    for [a, b] in segments(path, scene_size) {
        if let Some(ends) = screen.segment(a, b) {
            painter.line_segment(ends, Stroke::new(2.0, CHOSEN));
        }
    }
    for pair in path.path.light_path.windows(2) {
        if let Some(ends) = screen.segment(pair[0], pair[1]) {
            painter.line_segment(ends, Stroke::new(2.0, FROM_LIGHT));
        }
    }
    for at in path
        .path
        .light_path
        .iter()
        .skip(1)
        .filter_map(|&place| screen.project(place))
    {
        painter.circle(at, 3.0, FROM_LIGHT, Stroke::new(1.0, Color32::BLACK));
    }
    for (number, vertex) in (1..).zip(&path.path.vertices) {
        let place = vertex.place.position();
        if let Some(joined) = &vertex.joined
            && let Some(ends) = screen.segment(place, joined.position)
        {
            painter.extend(Shape::dashed_line(&ends, Stroke::new(1.5, FROM_LIGHT), 6.0, 4.0));
        }
        if let Some(sampled) = &vertex.sampled {
            let target = match sampled.sample.target {
                Target::Point(point) => point,
                Target::Infinity => place + sampled.sample.wi * (VOID * scene_size),
            };
            let reached = sampled.arriving.is_some_and(|arriving| arriving.max_element() > 0.0);
            let color = if reached { REACHED } else { BLOCKED };
            if let Some(ends) = screen.segment(place, target) {
                painter.extend(Shape::dashed_line(&ends, Stroke::new(1.5, color), 6.0, 4.0));
            }
        }
        if let Some(at) = screen.project(place) {
            painter.circle(at, 4.0, CHOSEN, Stroke::new(1.0, Color32::BLACK));
            let corner = at + egui::vec2(6.0, -6.0);
            tag(painter, corner, egui::Align2::LEFT_BOTTOM, &number.to_string());
        }
    }
}

/// The segments from vertex to vertex. The first one, from the camera, would look like a point from there, and is left
/// out.
fn segments(path: &NamedPath, scene_size: f32) -> impl Iterator<Item = [Vec3; 2]> + '_ {
    let vertices = &path.path.vertices;
    let between = vertices
        .windows(2)
        .map(|pair| [pair[0].place.position(), pair[1].place.position()]);
    let last = vertices.last().and_then(|vertex| {
        let bounce = vertex.bounce?;
        let ray = Ray::new(vertex.place.position(), bounce.wi);
        Some([ray.origin, ray.at(VOID * scene_size)])
    });
    between.chain(last)
}
