//! The icons of the kinds of things, drawn as lines within 12 by 12 points.

use std::f32::consts::TAU;

use bevy_egui::egui::{Color32, Painter, Pos2, Shape, Stroke, Vec2, vec2};

/// A part of an icon. Points are relative to its middle, with y downwards.
enum Part {
    /// A closed line.
    Loop(&'static [(f32, f32)]),
    /// An open line.
    Line(&'static [(f32, f32)]),
    /// An ellipse by its middle and its radii.
    Ellipse((f32, f32), f32, f32),
    /// Eight short rays between two radii.
    Rays(f32, f32),
}

use Part::{Ellipse, Line, Loop, Rays};

/// The icons, each with the names of its kinds in the outliner and in the menu *Add*.
const ICONS: [(&[&str], &[Part]); 36] = [
    (&["sphere"], &[Ellipse((0.0, 0.0), 5.0, 5.0)]),
    (
        &["rectangle"],
        &[Loop(&[(-3.0, -3.0), (5.5, -3.0), (3.0, 3.0), (-5.5, 3.0)])],
    ),
    (
        &["cube"],
        &[
            Loop(&[
                (0.0, -5.5),
                (5.0, -2.8),
                (5.0, 2.8),
                (0.0, 5.5),
                (-5.0, 2.8),
                (-5.0, -2.8),
            ]),
            Line(&[(-5.0, -2.8), (0.0, 0.0), (5.0, -2.8)]),
            Line(&[(0.0, 0.0), (0.0, 5.5)]),
        ],
    ),
    (&["disk"], &[Ellipse((0.0, 0.0), 5.0, 2.2)]),
    (
        &["cylinder"],
        &[
            Ellipse((0.0, -3.0), 5.0, 2.2),
            Line(&[(-5.0, -3.0), (-5.0, 3.5), (0.0, 5.5), (5.0, 3.5), (5.0, -3.0)]),
        ],
    ),
    (
        &["wall"],
        &[
            Loop(&[(-5.5, -4.0), (5.5, -4.0), (5.5, 4.5), (-5.5, 4.5)]),
            Loop(&[(-2.0, -1.5), (2.0, -1.5), (2.0, 1.5), (-2.0, 1.5)]),
        ],
    ),
    (
        &["stairs"],
        &[Loop(&[
            (-5.5, 5.0),
            (-5.5, 1.7),
            (-1.8, 1.7),
            (-1.8, -1.6),
            (1.9, -1.6),
            (1.9, -5.0),
            (5.5, -5.0),
            (5.5, 5.0),
        ])],
    ),
    (
        &["prism"],
        &[
            Loop(&[
                (-2.5, -5.5),
                (2.5, -5.5),
                (5.5, -3.5),
                (2.5, -1.5),
                (-2.5, -1.5),
                (-5.5, -3.5),
            ]),
            Line(&[
                (-5.5, -3.5),
                (-5.5, 3.5),
                (-2.5, 5.5),
                (2.5, 5.5),
                (5.5, 3.5),
                (5.5, -3.5),
            ]),
            Line(&[(-2.5, -1.5), (-2.5, 5.5)]),
            Line(&[(2.5, -1.5), (2.5, 5.5)]),
        ],
    ),
    (
        &["gableroof", "hiproof", "shedroof", "roof"],
        &[
            Loop(&[(-5.5, 0.0), (0.0, -4.5), (5.5, 0.0)]),
            Line(&[(-4.0, 0.0), (-4.0, 4.5), (4.0, 4.5), (4.0, 0.0)]),
        ],
    ),
    (&["triangle"], &[Loop(&[(0.0, -5.0), (5.0, 4.0), (-5.0, 4.0)])]),
    (
        &["mesh"],
        &[
            Loop(&[(0.0, -5.0), (5.5, 4.0), (-5.5, 4.0)]),
            Loop(&[(0.0, 4.0), (-2.75, -0.5), (2.75, -0.5)]),
        ],
    ),
    // Three blades of grass.
    (
        &["curves"],
        &[
            Line(&[(-3.5, 5.0), (-4.5, 0.0), (-2.0, -5.0)]),
            Line(&[(0.0, 5.0), (-1.0, 0.0), (1.5, -5.0)]),
            Line(&[(3.5, 5.0), (2.5, 0.0), (5.0, -5.0)]),
        ],
    ),
    (
        &["instance"],
        &[
            Loop(&[(-5.0, -5.0), (2.0, -5.0), (2.0, 2.0), (-5.0, 2.0)]),
            Loop(&[(-2.0, -2.0), (5.0, -2.0), (5.0, 5.0), (-2.0, 5.0)]),
        ],
    ),
    (
        &["medium", "volume", "fog"],
        &[
            Ellipse((-2.5, 1.0), 3.0, 3.0),
            Ellipse((1.0, -1.5), 3.8, 3.8),
            Ellipse((3.5, 2.0), 2.4, 2.4),
        ],
    ),
    (
        &["camera"],
        &[
            Loop(&[(-5.5, -3.0), (2.0, -3.0), (2.0, 3.0), (-5.5, 3.0)]),
            Loop(&[(2.0, 0.0), (5.5, -3.0), (5.5, 3.0)]),
        ],
    ),
    // A ceiling panel above its light.
    (
        &["area"],
        &[
            Loop(&[(-5.5, -5.0), (5.5, -5.0), (5.5, -2.5), (-5.5, -2.5)]),
            Line(&[(-3.0, -0.5), (-4.5, 5.0)]),
            Line(&[(0.0, -0.5), (0.0, 5.5)]),
            Line(&[(3.0, -0.5), (4.5, 5.0)]),
        ],
    ),
    // A bulb.
    (
        &["point"],
        &[
            Ellipse((0.0, -1.8), 3.6, 3.6),
            Line(&[(-1.8, 3.3), (1.8, 3.3)]),
            Line(&[(-1.3, 5.2), (1.3, 5.2)]),
        ],
    ),
    (
        &["spot"],
        &[
            Line(&[(-5.0, 3.5), (-1.3, -5.0), (1.3, -5.0), (5.0, 3.5)]),
            Ellipse((0.0, 3.5), 5.0, 1.9),
        ],
    ),
    // A shade with the light below it.
    (
        &["ies"],
        &[
            Line(&[(-3.5, -1.5), (-1.2, -5.0), (1.2, -5.0), (3.5, -1.5), (-3.5, -1.5)]),
            Ellipse((0.0, 2.4), 2.6, 3.6),
        ],
    ),
    (
        &["projector"],
        &[
            Loop(&[(-5.5, -2.5), (-1.0, -2.5), (-1.0, 2.5), (-5.5, 2.5)]),
            Line(&[(5.5, -5.0), (-1.0, -1.0)]),
            Line(&[(5.5, 5.0), (-1.0, 1.0)]),
        ],
    ),
    // Parallel arrows.
    (
        &["directional"],
        &[
            Line(&[(-4.0, -5.0), (-4.0, 4.5)]),
            Line(&[(-5.8, 2.5), (-4.0, 4.5), (-2.2, 2.5)]),
            Line(&[(3.0, -5.0), (3.0, 4.5)]),
            Line(&[(1.2, 2.5), (3.0, 4.5), (4.8, 2.5)]),
        ],
    ),
    (
        &["constant"],
        &[Ellipse((0.0, 0.0), 5.2, 5.2), Ellipse((0.0, 0.0), 2.0, 2.0)],
    ),
    // A globe.
    (
        &["environment map", "envmap"],
        &[
            Ellipse((0.0, 0.0), 5.2, 5.2),
            Ellipse((0.0, 0.0), 2.2, 5.2),
            Line(&[(-5.2, 0.0), (5.2, 0.0)]),
        ],
    ),
    (
        &["reflection probe", "reflectionprobe"],
        &[
            Loop(&[(-5.2, -5.2), (5.2, -5.2), (5.2, 5.2), (-5.2, 5.2)]),
            Ellipse((0.0, 0.0), 3.0, 3.0),
        ],
    ),
    (
        &["irradiance volume", "irradiancevolume"],
        &[
            Loop(&[(-5.2, -5.2), (5.2, -5.2), (5.2, 5.2), (-5.2, 5.2)]),
            Ellipse((-2.0, -2.0), 0.8, 0.8),
            Ellipse((2.0, -2.0), 0.8, 0.8),
            Ellipse((-2.0, 2.0), 0.8, 0.8),
            Ellipse((2.0, 2.0), 0.8, 0.8),
        ],
    ),
    // A dial with a needle.
    (
        &["measuring point", "illuminancemeter"],
        &[
            Ellipse((0.0, 0.0), 5.2, 5.2),
            Line(&[(0.0, 2.5), (2.6, -2.4)]),
            Ellipse((0.0, 2.5), 0.8, 0.8),
        ],
    ),
    (
        &["measuring grid", "illuminancegrid"],
        &[
            Loop(&[(-5.2, -5.2), (5.2, -5.2), (5.2, 5.2), (-5.2, 5.2)]),
            Line(&[(-1.7, -5.2), (-1.7, 5.2)]),
            Line(&[(1.7, -5.2), (1.7, 5.2)]),
            Line(&[(-5.2, -1.7), (5.2, -1.7)]),
            Line(&[(-5.2, 1.7), (5.2, 1.7)]),
        ],
    ),
    // A flag.
    (
        &["marker", "markerpoint"],
        &[
            Line(&[(-2.6, 5.4), (-2.6, -5.4)]),
            Loop(&[(-2.6, -5.4), (4.4, -3.0), (-2.6, -0.6)]),
        ],
    ),
    (
        &["box marker", "markerbox"],
        &[
            Loop(&[(-5.2, -5.2), (5.2, -5.2), (5.2, 5.2), (-5.2, 5.2)]),
            Line(&[(-1.2, 2.8), (-1.2, -2.8), (2.6, -1.4), (-1.2, 0.0)]),
        ],
    ),
    (
        &["sphere marker", "markersphere"],
        &[
            Ellipse((0.0, 0.0), 5.2, 5.2),
            Line(&[(-1.2, 2.8), (-1.2, -2.8), (2.6, -1.4), (-1.2, 0.0)]),
        ],
    ),
    (
        &["path", "markerpath"],
        &[
            Line(&[(-4.6, 3.6), (-1.4, -2.6), (1.8, 1.6), (4.6, -3.8)]),
            Ellipse((-4.6, 3.6), 1.0, 1.0),
            Ellipse((4.6, -3.8), 1.0, 1.0),
        ],
    ),
    (
        &["door"],
        &[
            Loop(&[(-3.2, -5.5), (3.2, -5.5), (3.2, 5.5), (-3.2, 5.5)]),
            Ellipse((1.4, 0.3), 0.6, 0.6),
        ],
    ),
    (
        &["window"],
        &[
            Loop(&[(-4.8, -5.0), (4.8, -5.0), (4.8, 5.0), (-4.8, 5.0)]),
            Line(&[(0.0, -5.0), (0.0, 5.0)]),
            Line(&[(-4.8, 0.0), (4.8, 0.0)]),
        ],
    ),
    (
        &["floor"],
        &[
            Loop(&[(-2.5, -2.5), (5.8, -2.5), (2.5, 1.5), (-5.8, 1.5)]),
            Line(&[(-5.8, 1.5), (-5.8, 3.2), (2.5, 3.2), (5.8, -0.8), (5.8, -2.5)]),
        ],
    ),
    // A face that is pulled upwards.
    (
        &["faces"],
        &[
            Loop(&[(-2.5, 1.0), (5.8, 1.0), (2.5, 5.0), (-5.8, 5.0)]),
            Line(&[(0.0, 2.5), (0.0, -5.5)]),
            Line(&[(-2.2, -3.2), (0.0, -5.5), (2.2, -3.2)]),
        ],
    ),
    // A sun: the sky, and kinds without an icon of their own.
    (
        &["sun and sky", "sunsky"],
        &[Ellipse((0.0, 0.0), 2.5, 2.5), Rays(4.0, 6.0)],
    ),
];

/// Paints the icon of a kind around `middle`. An unknown kind is painted as a sun, because all other things in the
/// outliner are lights.
pub(super) fn paint(painter: &Painter, middle: Pos2, kind: &str, color: Color32) {
    let stroke = Stroke::new(1.2, color);
    let known = ICONS.iter().find(|(kinds, _)| kinds.contains(&kind));
    let (_, parts) = known.unwrap_or(&ICONS[ICONS.len() - 1]);
    let points = |points: &[(f32, f32)]| points.iter().map(|&(x, y)| middle + vec2(x, y)).collect();
    for part in *parts {
        match *part {
            Loop(corners) => _ = painter.add(Shape::closed_line(points(corners), stroke)),
            Line(corners) => _ = painter.add(Shape::line(points(corners), stroke)),
            Ellipse((x, y), width, height) => {
                painter.add(Shape::ellipse_stroke(middle + vec2(x, y), vec2(width, height), stroke));
            }
            Rays(from, to) => (0..8).for_each(|ray| {
                let direction = Vec2::angled(TAU * ray as f32 / 8.0);
                painter.line_segment([middle + from * direction, middle + to * direction], stroke);
            }),
        }
    }
}
