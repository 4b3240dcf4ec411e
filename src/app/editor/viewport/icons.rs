//! Icons for lights, cameras and missing meshes, which have no surface: they are drawn at their places, and the mouse
//! can pick them.

use std::f32::consts::TAU;

use bevy::math::{Affine3A, Vec3};
use bevy::prelude::Entity;
use bevy_egui::egui::{Color32, Painter, Pos2, Shape, Stroke, Vec2};

use crate::app::editor::camera::screen::Screen;
use crate::scene::marker::MarkerSymbol;
use crate::scene::{self, Emitter, EmitterKind, ShapeKind};

/// The mark of a light or a camera, which no ray hits.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Icon {
    /// The entity that a click selects.
    pub entity: Entity,
    /// The kind of drawing.
    pub kind: IconKind,
    /// World from local.
    pub pose: Affine3A,
    /// The colour of its own; None for that of all.
    pub tint: Option<Color32>,
}

/// The line of a marker that is a path.
#[derive(Clone, Debug, PartialEq)]
pub struct MarkerPath {
    /// The entity of the marker.
    pub entity: Entity,
    /// The points in its own space.
    pub points: Vec<Vec3>,
    /// World from its own space.
    pub pose: Affine3A,
    /// The line in the world.
    pub line: Vec<Vec3>,
    /// The colour of its type.
    pub tint: Color32,
}

/// Draws the lines of paths.
pub(super) fn paint_paths(
    painter: &Painter,
    screen: &Screen,
    paths: &[MarkerPath],
    color: impl Fn(Entity, Color32) -> Color32,
) {
    for path in paths {
        let color = color(path.entity, path.tint);
        let pieces = path.line.windows(2).filter_map(|ends| screen.segment(ends[0], ends[1]));
        for ends in pieces {
            painter.line_segment(ends, Stroke::new(3.0, SHADOW));
            painter.line_segment(ends, Stroke::new(1.5, color));
        }
    }
}

/// The drawings.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum IconKind {
    /// A light that shines in all directions.
    Bulb,
    /// A light that shines along +z from infinitely far away.
    Sun,
    /// A flat light from -1 to 1 along x and y that shines along +z.
    Sheet,
    /// A light that shines along +z, this many radians to every side.
    Cone(f32),
    /// A camera or projector that looks along +z.
    Frustum,
    /// A cube from -1 to 1.
    Box,
    /// A point that measures the light on the side of +z.
    Meter,
    /// A square from -1 to 1 along x and y that measures the light on the side of +z.
    MeterGrid,
    /// A cube from -1 to 1 in place of a missing mesh.
    StandIn,
    /// A marker whose direction is +z.
    Marker(MarkerSymbol),
    /// A marker that is a cube from -1 to 1.
    MarkerBox(MarkerSymbol),
    /// A marker that is a sphere of radius 1.
    MarkerSphere(MarkerSymbol),
    /// A point of a path.
    PathPoint(MarkerSymbol),
}

impl IconKind {
    /// The icon; None for lights that have no place.
    pub fn of(emitter: &Emitter) -> Option<Self> {
        match &emitter.kind {
            EmitterKind::Point { .. } => Some(Self::Bulb),
            EmitterKind::Luminaire { .. } => Some(Self::Cone(LAMP_CONE)),
            EmitterKind::Directional { .. } => Some(Self::Sun),
            EmitterKind::Spot { cone, .. } => Some(Self::Cone(cone.cutoff_angle.to_radians())),
            EmitterKind::Projector { .. } => Some(Self::Frustum),
            EmitterKind::ReflectionProbe { .. } | EmitterKind::IrradianceVolume { .. } => Some(Self::Box),
            EmitterKind::IlluminanceMeter { .. } => Some(Self::Meter),
            EmitterKind::IlluminanceGrid { .. } => Some(Self::MeterGrid),
            EmitterKind::Constant { .. } | EmitterKind::Environment { .. } | EmitterKind::SunSky(_) => None,
            EmitterKind::MarkerPoint => Some(Self::Marker(MarkerSymbol::default())),
            EmitterKind::MarkerBox => Some(Self::MarkerBox(MarkerSymbol::default())),
            EmitterKind::MarkerSphere => Some(Self::MarkerSphere(MarkerSymbol::default())),
            EmitterKind::MarkerPath => Some(Self::PathPoint(MarkerSymbol::default())),
        }
    }

    /// The icon with this symbol, if it is that of a marker.
    pub(crate) fn with_symbol(self, symbol: MarkerSymbol) -> Self {
        match self {
            Self::Marker(_) => Self::Marker(symbol),
            Self::MarkerBox(_) => Self::MarkerBox(symbol),
            Self::MarkerSphere(_) => Self::MarkerSphere(symbol),
            Self::PathPoint(_) => Self::PathPoint(symbol),
            other => other,
        }
    }

    fn symbol(self) -> Option<MarkerSymbol> {
        match self {
            Self::Marker(symbol) | Self::MarkerBox(symbol) | Self::MarkerSphere(symbol) | Self::PathPoint(symbol) => {
                Some(symbol)
            }
            _ => None,
        }
    }
}

impl IconKind {
    /// The icon of a shape that shines; None unless it is flat and reaches from -1 to 1.
    pub(crate) fn of_shape(shape: &scene::Shape) -> Option<Self> {
        let is_triangle = matches!(shape.kind, ShapeKind::Triangle { .. });
        (shape.kind.is_flat() && !is_triangle).then_some(Self::Sheet)
    }
}

/// The half angle of the icon of a lamp, in radians.
const LAMP_CONE: f32 = 0.5;

/// The radius of a bulb's disk in points; below the radius within which the pointer hits an icon, and the length of
/// icons that point along +z.
const RADIUS: f32 = 5.0;
const REACH: f32 = 11.0;
const LENGTH: f32 = 30.0;
/// The length of a camera's pyramid.
const CAMERA: f32 = 20.0;
/// The length of the two strokes of an arrow's head.
const HEAD: f32 = 6.0;
/// The most icons; more would hide the picture.
const MOST_ICONS: usize = 1000;
/// The distance from the middle of a symbol at which its arrow begins.
const SYMBOL: f32 = 9.0;
/// The pieces of a circle around a sphere.
const PIECES: usize = 32;
const SHADOW: Color32 = Color32::from_black_alpha(120);

/// Draws the icons that are in front of the camera, at most a thousand of them.
pub fn paint(painter: &Painter, screen: &Screen, icons: &[Icon], color: impl Fn(&Icon) -> Color32) {
    let seen = icons.iter().filter_map(|icon| Some((icon, place(screen, icon)?)));
    for (icon, middle) in seen.take(MOST_ICONS) {
        let lines = lines(screen, icon, middle);
        for stroke in [Stroke::new(3.0, SHADOW), Stroke::new(1.5, color(icon))] {
            painter.extend(lines.iter().map(|ends| Shape::line_segment(*ends, stroke)));
            match icon.kind {
                IconKind::Frustum | IconKind::Sheet => {}
                kind if kind.symbol().is_some_and(|symbol| symbol != MarkerSymbol::Dot) => {}
                _ => {
                    painter.circle_stroke(middle, RADIUS, stroke);
                }
            }
        }
    }
}

/// The icon nearest to the pointer, within reach.
pub(crate) fn icon_at(screen: &Screen, icons: &[Icon], pointer: Pos2) -> Option<Entity> {
    // The surface of a flat light is hit by rays.
    let distances = (icons.iter())
        .filter(|icon| icon.kind != IconKind::Sheet)
        .filter_map(|icon| Some((place(screen, icon)?.distance(pointer), icon.entity)));
    let nearest = distances.min_by(|a, b| a.0.total_cmp(&b.0));
    nearest
        .filter(|(distance, _)| *distance <= REACH)
        .map(|(_, entity)| entity)
}

/// The position of an icon in the window; None outside the picture.
pub fn place(screen: &Screen, icon: &Icon) -> Option<Pos2> {
    screen
        .project(icon.pose.translation.into())
        .filter(|at| screen.picture.contains(*at))
}

fn lines(screen: &Screen, icon: &Icon, middle: Pos2) -> Vec<[Pos2; 2]> {
    let origin = Vec3::from(icon.pose.translation);
    let unit = screen.units_per_point(screen.depth(origin));
    let [x, y, z] = [
        icon.pose.matrix3.x_axis,
        icon.pose.matrix3.y_axis,
        icon.pose.matrix3.z_axis,
    ]
    .map(|axis| Vec3::from(axis).normalize_or_zero());
    let line = |a: Vec3, b: Vec3| screen.segment(origin + a * unit, origin + b * unit);
    // An arrow along +z, with its head in the plane of the screen.
    let arrow = |from: f32, to: f32| -> Vec<[Pos2; 2]> {
        let Some([start, tip]) = line(z * from, z * to) else {
            return Vec::new();
        };
        let back = HEAD * (start - tip).normalized();
        let strokes = [back + 0.6 * back.rot90(), back - 0.6 * back.rot90()];
        [[start, tip], [tip, tip + strokes[0]], [tip, tip + strokes[1]]].into()
    };
    let rays = (0..8).map(|ray| {
        let direction = Vec2::angled(TAU * ray as f32 / 8.0);
        Some([middle + direction * (RADIUS + 2.5), middle + direction * (RADIUS + 6.0)])
    });
    match icon.kind {
        IconKind::Bulb => rays.flatten().collect(),
        IconKind::Sun => rays
            .flatten()
            .chain(arrow(RADIUS + 8.0, RADIUS + 8.0 + LENGTH))
            .collect(),
        IconKind::Meter => arrow(RADIUS, LENGTH),
        IconKind::Marker(symbol) => symbol_lines(symbol, middle).chain(arrow(SYMBOL, LENGTH)).collect(),
        IconKind::PathPoint(symbol) => symbol_lines(symbol, middle).collect(),
        IconKind::MarkerSphere(symbol) => {
            let at = |axis: usize, piece: usize| {
                let (sin, cos) = (TAU * piece as f32 / PIECES as f32).sin_cos();
                let mut point = [0.0; 3];
                (point[(axis + 1) % 3], point[(axis + 2) % 3]) = (cos, sin);
                icon.pose.transform_point3(Vec3::from_array(point))
            };
            let circles = (0..3).flat_map(|axis| (0..PIECES).map(move |piece| (axis, piece)));
            let circles = circles.filter_map(|(axis, piece)| screen.segment(at(axis, piece), at(axis, piece + 1)));
            circles.chain(symbol_lines(symbol, middle)).collect()
        }
        IconKind::Sheet | IconKind::MeterGrid => {
            let corner = |a: f32, b: f32| icon.pose.transform_point3(Vec3::new(a, b, 0.0));
            let corners = [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)].map(|(a, b)| corner(a, b));
            let edges = (0..4).filter_map(|k| screen.segment(corners[k], corners[(k + 1) % 4]));
            edges.chain(arrow(0.0, LENGTH)).collect()
        }
        IconKind::Cone(angle) => {
            // A very wide cone is drawn as wide as can be told from a disk.
            let angle = angle.clamp(0.05, 1.4);
            let rim = |place: f32| {
                let around = TAU * place / 16.0;
                LENGTH * (z * angle.cos() + (x * around.cos() + y * around.sin()) * angle.sin())
            };
            let circle = (0..16).map(|k| line(rim(k as f32), rim(k as f32 + 1.0)));
            let sides = (0..4).map(|k| line(Vec3::ZERO, rim(4.0 * k as f32)));
            circle.chain(sides).flatten().collect()
        }
        IconKind::Frustum => {
            // A camera looks along +z, with +y up and +x to the left.
            let corner = |across: f32, along: f32| CAMERA * (z + x * (across * 0.7) + y * (along * 0.5));
            let corners = [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)].map(|(a, b)| corner(a, b));
            let edges = (0..4).flat_map(|k| [line(Vec3::ZERO, corners[k]), line(corners[k], corners[(k + 1) % 4])]);
            let roof = [corner(-0.5, 1.2), corner(0.5, 1.2), corner(0.0, 1.9)];
            let upright = (0..3).map(|k| line(roof[k], roof[(k + 1) % 3]));
            edges.chain(upright).flatten().collect()
        }
        IconKind::Box | IconKind::StandIn | IconKind::MarkerBox(_) => {
            let corner = |at: usize| {
                let sign = |axis: usize| if at >> axis & 1 == 0 { -1.0 } else { 1.0 };
                icon.pose.transform_point3(Vec3::new(sign(0), sign(1), sign(2)))
            };
            let edges = (0..8).flat_map(|at| [1, 2, 4].map(|step| (at, at | step)));
            let edges = edges.filter(|(from, to)| from != to);
            let edges = edges.filter_map(|(from, to)| screen.segment(corner(from), corner(to)));
            let symbol = icon.kind.symbol().unwrap_or_default();
            edges.chain(symbol_lines(symbol, middle)).collect()
        }
    }
}

/// The strokes of a symbol around its middle, in points: x to the right, y downwards.
fn symbol_lines(symbol: MarkerSymbol, middle: Pos2) -> impl Iterator<Item = [Pos2; 2]> {
    type Stroke = &'static [(f32, f32)];
    let strokes: &'static [Stroke] = match symbol {
        MarkerSymbol::Dot => &[],
        MarkerSymbol::Flag => &[&[(-3.0, 6.5), (-3.0, -7.0)], &[(-3.0, -7.0), (5.5, -4.3), (-3.0, -1.6)]],
        MarkerSymbol::Bolt => &[&[(2.5, -7.0), (-3.0, 1.0), (2.0, 0.0), (-2.0, 7.0)]],
        MarkerSymbol::Diamond => &[&[(0.0, -6.0), (5.0, 0.0), (0.0, 6.0), (-5.0, 0.0), (0.0, -6.0)]],
        MarkerSymbol::Note => &[
            &[(5.5, -3.0), (1.5, -7.0), (1.5, 4.0)],
            &[(1.5, 4.0), (-1.0, 6.5), (-3.5, 4.0), (-1.0, 1.5), (1.5, 4.0)],
        ],
        MarkerSymbol::Star => &[&[
            (0.0, -6.5),
            (3.8, 5.3),
            (-6.2, -2.0),
            (6.2, -2.0),
            (-3.8, 5.3),
            (0.0, -6.5),
        ]],
        MarkerSymbol::Cross => &[&[(-5.0, -5.0), (5.0, 5.0)], &[(5.0, -5.0), (-5.0, 5.0)]],
    };
    let at = move |(x, y): (f32, f32)| middle + Vec2::new(x, y);
    let pairs = strokes.iter().flat_map(|stroke| stroke.windows(2));
    pairs.map(move |pair| [at(pair[0]), at(pair[1])])
}

#[cfg(test)]
mod tests {
    use bevy::prelude::World;
    use bevy_egui::egui::vec2;

    use super::*;
    use crate::app::editor::camera::screen::tests::perspective;

    #[test]
    fn the_nearest_icon_in_reach_is_taken() {
        let mut world = World::new();
        let mut icon = |x: f32, z: f32| Icon {
            entity: world.spawn_empty().id(),
            kind: IconKind::Cone(3.0),
            pose: Affine3A::from_translation(Vec3::new(x, 0.0, z)),
            tint: None,
        };
        let icons = [icon(0.0, 0.0), icon(0.3, 0.0), icon(0.0, -20.0)];
        let screen = perspective();
        let middle = screen.picture.center();
        // +x is to the left.
        assert_eq!(icon_at(&screen, &icons, middle + vec2(2.0, 3.0)), Some(icons[0].entity));
        assert_eq!(icon_at(&screen, &icons, middle - vec2(9.0, 0.0)), Some(icons[1].entity));
        assert_eq!(icon_at(&screen, &icons, middle + vec2(0.0, 40.0)), None);
        assert!(place(&screen, &icons[2]).is_none(), "behind the camera");
        let cube = Icon {
            kind: IconKind::Box,
            ..icons[0]
        };
        assert_eq!(lines(&screen, &cube, middle).len(), 12);
        let drawn = lines(&screen, &icons[0], middle);
        assert!(drawn.len() == 20 && drawn.iter().flatten().all(|at| at.distance(middle) < 2.0 * LENGTH));
    }
}
