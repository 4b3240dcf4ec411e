//! The intensities of the selected lamp as a solid: each direction reaches as far as its intensity says.

use std::f32::consts::TAU;
use std::sync::Arc;

use bevy::math::{Affine3A, Vec3};
use bevy_egui::egui::{self, Color32, Stroke};

use crate::app::editor::camera::screen::Screen;
use crate::photometry::PolarCurve;

const COLOR: Color32 = Color32::from_rgb(255, 214, 120);
const EDGE: Color32 = Color32::from_black_alpha(90);

/// The length of the brightest direction in points.
const LENGTH: f32 = 90.0;

/// The points of a curve between two rings.
const BETWEEN_RINGS: usize = 10;

/// A lamp and its curves.
#[derive(Clone, Debug, PartialEq)]
pub struct LampSolid {
    /// World from the lamp's space, whose +z is the axis of the beam.
    pub pose: Affine3A,
    /// The curves of planes at equal steps over half a turn.
    pub curves: Arc<[PolarCurve]>,
}

/// Paints the curves and, between them, rings around the axis.
pub(super) fn paint(painter: &egui::Painter, screen: &Screen, solid: &LampSolid) {
    let origin = Vec3::from(solid.pose.translation);
    let unit = LENGTH * screen.units_per_point(screen.depth(origin));
    let world = |local: Vec3| origin + unit * solid.pose.transform_vector3(local).normalize_or_zero() * local.length();
    for [from, to] in edges(&solid.curves) {
        if let Some(ends) = screen.segment(world(from), world(to)) {
            painter.line_segment(ends, Stroke::new(2.5, EDGE));
            painter.line_segment(ends, Stroke::new(1.0, COLOR));
        }
    }
}

/// The edges of the solid in the lamp's space, where the brightest direction has a length of 1.
fn edges(curves: &[PolarCurve]) -> Vec<[Vec3; 2]> {
    let most = curves.iter().map(|curve| curve.farthest).fold(0.0, f32::max);
    let Some(count) = curves.first().map(|curve| curve.points.len()).filter(|_| most > 0.0) else {
        return Vec::new();
    };
    let at = |curve: usize, place: usize| {
        let (sin, cos) = (0.5 * TAU * curve as f32 / curves.len() as f32).sin_cos();
        let curve = &curves[curve];
        let point = curve.points[place % count] * (curve.farthest / most);
        Vec3::new(point.x * cos, -point.x * sin, point.y)
    };
    let along = (0..curves.len()).flat_map(|curve| (0..count).map(move |place| [(curve, place), (curve, place + 1)]));
    // A ring meets every curve on one side, and then every curve on the other.
    let rings = (BETWEEN_RINGS..count / 2).step_by(BETWEEN_RINGS);
    let around = rings.flat_map(|place| {
        let on_ring = move |step: usize| match step / curves.len() % 2 {
            0 => (step % curves.len(), place),
            _ => (step % curves.len(), count - place),
        };
        (0..2 * curves.len()).map(move |step| [on_ring(step), on_ring(step + 1)])
    });
    let lines = along
        .chain(around)
        .map(|ends| ends.map(|(curve, place)| at(curve, place)));
    lines.filter(|[from, to]| from != to).collect()
}

#[cfg(test)]
mod tests {
    use bevy::math::Vec2;

    use super::*;

    #[test]
    fn an_even_lamp_is_a_ball() {
        let circle = (0..120).map(|step| {
            let (sin, cos) = (TAU * step as f32 / 120.0).sin_cos();
            Vec2::new(sin, cos)
        });
        let curve = PolarCurve {
            lumens: 1.0,
            peak: 5.0,
            farthest: 5.0,
            points: circle.collect(),
        };
        let all = edges(&vec![curve; 4]);
        assert_eq!(all.len(), 4 * 120 + 5 * 8);
        for [from, to] in all {
            assert!((from.length() - 1.0).abs() < 1e-5 && (to.length() - 1.0).abs() < 1e-5);
            // Edges of rings have a constant height, those of curves are short.
            assert!(from.distance(to) < 0.06 || (from.z - to.z).abs() < 1e-5, "{from} {to}");
        }
        assert_eq!(edges(&[]), Vec::<[Vec3; 2]>::new());
    }
}
