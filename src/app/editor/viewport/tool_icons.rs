//! The icons of the toolbar, drawn as lines on a square of 16 by 16 points, and the button that has one.

use std::f32::consts::TAU;
use std::ops::RangeInclusive;

use bevy_egui::egui::{self, Button, Color32, Painter, Pos2, Rect, Response, Shape, Stroke, Ui, Vec2, vec2};

/// An icon of the toolbar.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ToolIcon {
    /// An arrow as of the mouse: select.
    Select,
    /// Arrows in four directions.
    Move,
    /// An arrow in a circle.
    Rotate,
    /// A small square that becomes a large one.
    Scale,
    /// A globe: the axes of the world.
    World,
    /// A tilted square: the axes of the thing.
    Local,
    /// A chequered sheet with an arrow: placing textures.
    Texture,
    /// A magnet: snapping.
    Magnet,
    /// A sphere with a shadow: the display mode.
    Shading,
    /// Grains that become a line: the denoiser.
    Denoise,
    /// A grid.
    Grid,
    /// Two overlapping squares: the overlays.
    Overlays,
    /// A square in four parts: one view or four.
    Views,
    /// A cube: draw a box.
    Box,
    /// A flat slab: draw a floor.
    Floor,
    /// Bricks: draw a wall.
    Wall,
    /// A face with an arrow: push and pull.
    Push,
    /// A door.
    Door,
    /// A window of four panes.
    Window,
    /// A ruler: measure.
    Ruler,
    /// A brush with rays: paint the light you want.
    LightBrush,
}

impl ToolIcon {
    /// All icons.
    pub const ALL: [Self; 21] = [
        Self::Select,
        Self::Move,
        Self::Rotate,
        Self::Scale,
        Self::World,
        Self::Local,
        Self::Texture,
        Self::Magnet,
        Self::Shading,
        Self::Denoise,
        Self::Grid,
        Self::Overlays,
        Self::Views,
        Self::Box,
        Self::Floor,
        Self::Wall,
        Self::Push,
        Self::Door,
        Self::Window,
        Self::Ruler,
        Self::LightBrush,
    ];
}

/// The edge of an icon, in points.
const EDGE: f32 = 16.0;
/// The width of the lines, in points.
const LINE: f32 = 1.4;
/// The size of a button, in points.
const BUTTON: Vec2 = vec2(26.0, 24.0);

/// A piece of an icon. Places count from its upper left corner; angles are in degrees from the right, clockwise.
enum Mark {
    Line(&'static [(f32, f32)]),
    Loop(&'static [(f32, f32)]),
    /// Middle, radius and angles.
    Arc((f32, f32), f32, RangeInclusive<f32>),
    /// Middle and radii.
    Oval((f32, f32), (f32, f32)),
    /// Middle and radius.
    Dot((f32, f32), f32),
    /// Middle and radius of a disk, of which the right half is painted.
    Half((f32, f32), f32),
}

use Mark::{Arc, Dot, Half, Line, Loop, Oval};

fn marks(icon: ToolIcon) -> &'static [Mark] {
    match icon {
        ToolIcon::Select => &[Loop(&[
            (4.0, 1.5),
            (4.0, 12.5),
            (6.8, 10.0),
            (8.8, 14.5),
            (10.8, 13.6),
            (8.9, 9.3),
            (12.5, 9.0),
        ])],
        ToolIcon::Move => &[
            Line(&[(8.0, 1.5), (8.0, 14.5)]),
            Line(&[(1.5, 8.0), (14.5, 8.0)]),
            Line(&[(6.0, 3.5), (8.0, 1.5), (10.0, 3.5)]),
            Line(&[(6.0, 12.5), (8.0, 14.5), (10.0, 12.5)]),
            Line(&[(3.5, 6.0), (1.5, 8.0), (3.5, 10.0)]),
            Line(&[(12.5, 6.0), (14.5, 8.0), (12.5, 10.0)]),
        ],
        ToolIcon::Rotate => &[
            Arc((8.0, 8.5), 5.5, -20.0..=270.0),
            Line(&[(5.6, 0.6), (8.4, 3.0), (5.8, 5.6)]),
        ],
        ToolIcon::Scale => &[
            Loop(&[(1.5, 9.0), (7.0, 9.0), (7.0, 14.5), (1.5, 14.5)]),
            Line(&[(7.0, 9.0), (14.0, 2.0)]),
            Line(&[(9.5, 2.0), (14.0, 2.0), (14.0, 6.5)]),
        ],
        ToolIcon::World => &[
            Oval((8.0, 8.0), (6.0, 6.0)),
            Oval((8.0, 8.0), (2.6, 6.0)),
            Line(&[(2.0, 8.0), (14.0, 8.0)]),
        ],
        ToolIcon::Local => &[
            Loop(&[(6.5, 2.0), (14.0, 6.5), (9.5, 14.0), (2.0, 9.5)]),
            Dot((8.0, 8.0), 1.5),
        ],
        ToolIcon::Texture => &[
            Loop(&[(1.5, 4.5), (11.5, 4.5), (11.5, 14.5), (1.5, 14.5)]),
            Line(&[(6.5, 4.5), (6.5, 14.5)]),
            Line(&[(1.5, 9.5), (11.5, 9.5)]),
            Line(&[(11.5, 4.5), (14.5, 1.5)]),
            Dot((4.0, 7.0), 1.7),
            Dot((9.0, 12.0), 1.7),
            Dot((14.2, 1.8), 1.5),
        ],
        ToolIcon::Magnet => &[
            Line(&[(3.2, 2.0), (3.2, 8.5)]),
            Line(&[(12.8, 2.0), (12.8, 8.5)]),
            Arc((8.0, 8.5), 4.8, 0.0..=180.0),
            Line(&[(1.6, 4.8), (4.8, 4.8)]),
            Line(&[(11.2, 4.8), (14.4, 4.8)]),
        ],
        ToolIcon::Shading => &[Oval((8.0, 8.0), (6.0, 6.0)), Half((8.0, 8.0), 6.0)],
        ToolIcon::Denoise => &[
            Dot((2.5, 4.0), 1.1),
            Dot((4.5, 9.5), 1.1),
            Dot((2.0, 12.5), 1.1),
            Dot((6.0, 6.0), 1.1),
            Line(&[(8.0, 11.5), (9.5, 8.5), (11.0, 7.2), (12.5, 6.8), (14.5, 6.6)]),
        ],
        ToolIcon::Grid => &[
            Line(&[(1.5, 5.5), (14.5, 5.5)]),
            Line(&[(1.5, 10.5), (14.5, 10.5)]),
            Line(&[(5.5, 1.5), (5.5, 14.5)]),
            Line(&[(10.5, 1.5), (10.5, 14.5)]),
        ],
        ToolIcon::Overlays => &[
            Loop(&[(1.5, 1.5), (10.0, 1.5), (10.0, 10.0), (1.5, 10.0)]),
            Loop(&[(6.0, 6.0), (14.5, 6.0), (14.5, 14.5), (6.0, 14.5)]),
        ],
        ToolIcon::Views => &[
            Loop(&[(1.5, 2.5), (14.5, 2.5), (14.5, 13.5), (1.5, 13.5)]),
            Line(&[(8.0, 2.5), (8.0, 13.5)]),
            Line(&[(1.5, 8.0), (14.5, 8.0)]),
            Dot((4.75, 5.25), 1.5),
        ],
        ToolIcon::Box => &[
            Loop(&[
                (8.0, 1.5),
                (14.0, 4.7),
                (14.0, 11.3),
                (8.0, 14.5),
                (2.0, 11.3),
                (2.0, 4.7),
            ]),
            Line(&[(2.0, 4.7), (8.0, 8.0), (14.0, 4.7)]),
            Line(&[(8.0, 8.0), (8.0, 14.5)]),
        ],
        ToolIcon::Floor => &[
            Loop(&[(8.0, 3.5), (15.0, 7.0), (8.0, 10.5), (1.0, 7.0)]),
            Line(&[(1.0, 7.0), (1.0, 9.5), (8.0, 13.0), (15.0, 9.5), (15.0, 7.0)]),
        ],
        ToolIcon::Wall => &[
            Loop(&[(1.5, 2.5), (14.5, 2.5), (14.5, 13.5), (1.5, 13.5)]),
            Line(&[(1.5, 6.2), (14.5, 6.2)]),
            Line(&[(1.5, 9.8), (14.5, 9.8)]),
            Line(&[(6.0, 2.5), (6.0, 6.2)]),
            Line(&[(10.0, 6.2), (10.0, 9.8)]),
            Line(&[(6.0, 9.8), (6.0, 13.5)]),
        ],
        ToolIcon::Push => &[
            Loop(&[(1.5, 5.0), (5.5, 2.0), (5.5, 11.0), (1.5, 14.0)]),
            Line(&[(5.5, 8.0), (14.5, 8.0)]),
            Line(&[(11.3, 4.8), (14.5, 8.0), (11.3, 11.2)]),
        ],
        ToolIcon::Door => &[
            Line(&[(1.0, 14.5), (15.0, 14.5)]),
            Line(&[(3.8, 14.5), (3.8, 1.5), (12.2, 1.5), (12.2, 14.5)]),
            Dot((9.8, 8.5), 1.1),
        ],
        ToolIcon::Window => &[
            Loop(&[(2.5, 2.0), (13.5, 2.0), (13.5, 12.5), (2.5, 12.5)]),
            Line(&[(8.0, 2.0), (8.0, 12.5)]),
            Line(&[(2.5, 7.2), (13.5, 7.2)]),
            Line(&[(1.0, 14.5), (15.0, 14.5)]),
        ],
        ToolIcon::Ruler => &[
            Loop(&[(1.5, 10.8), (10.8, 1.5), (14.5, 5.2), (5.2, 14.5)]),
            Line(&[(4.6, 7.7), (6.3, 9.4)]),
            Line(&[(6.9, 5.4), (8.6, 7.1)]),
            Line(&[(9.2, 3.1), (10.9, 4.8)]),
        ],
        ToolIcon::LightBrush => &[
            Line(&[(14.5, 1.5), (9.0, 7.0)]),
            Loop(&[(9.0, 7.0), (6.6, 7.6), (4.4, 11.6), (8.4, 9.4)]),
            Line(&[(1.2, 14.8), (2.6, 13.4)]),
            Line(&[(1.0, 9.4), (2.8, 10.2)]),
            Line(&[(6.6, 15.0), (5.8, 13.2)]),
            Line(&[(4.6, 4.2), (5.4, 5.8)]),
            Line(&[(11.8, 11.4), (10.2, 10.6)]),
        ],
    }
}

/// Paints an icon in the middle of a rectangle.
pub fn paint(painter: &Painter, icon: ToolIcon, rect: Rect, color: Color32) {
    let corner = rect.center() - Vec2::splat(0.5 * EDGE);
    let at = |&(x, y): &(f32, f32)| corner + vec2(x, y);
    let stroke = Stroke::new(LINE, color);
    let arc = |middle: &(f32, f32), radius: f32, angles: RangeInclusive<f32>| -> Vec<Pos2> {
        let steps = 24;
        let angles = (0..=steps).map(|step| egui::lerp(angles.clone(), step as f32 / steps as f32) / 360.0 * TAU);
        angles.map(|angle| at(middle) + radius * Vec2::angled(angle)).collect()
    };
    for mark in marks(icon) {
        match mark {
            Line(points) => {
                painter.line(points.iter().map(at).collect(), stroke);
            }
            Loop(points) => {
                painter.add(Shape::closed_line(points.iter().map(at).collect(), stroke));
            }
            Arc(middle, radius, angles) => {
                painter.line(arc(middle, *radius, angles.clone()), stroke);
            }
            Oval(middle, radii) => {
                painter.add(Shape::ellipse_stroke(at(middle), vec2(radii.0, radii.1), stroke));
            }
            Dot(middle, radius) => {
                painter.circle_filled(at(middle), *radius, color);
            }
            Half(middle, radius) => {
                let half = arc(middle, *radius, -90.0..=90.0);
                painter.add(Shape::convex_polygon(half, color, Stroke::NONE));
            }
        }
    }
}

/// A button with an icon, which is found by its name; `help` is its tool tip.
pub(crate) fn icon_button(ui: &mut Ui, icon: ToolIcon, is_on: bool, name: &str, help: &str) -> Response {
    let response = ui.add(Button::selectable(is_on, "").min_size(BUTTON));
    let color = match ui.is_enabled() {
        true => ui.visuals().text_color(),
        // A disabled icon fades as a whole.
        false => ui.visuals().weak_text_color(),
    };
    paint(ui.painter(), icon, response.rect, color);
    let is_enabled = ui.is_enabled();
    response.widget_info(|| egui::WidgetInfo::selected(egui::WidgetType::Button, is_enabled, is_on, name));
    response.on_hover_text(help).on_disabled_hover_text(help)
}

/// A button with an icon that opens a menu.
pub(crate) fn icon_menu(
    ui: &mut Ui,
    icon: ToolIcon,
    is_on: bool,
    name: &str,
    help: &str,
    content: impl FnOnce(&mut Ui),
) {
    let response = icon_button(ui, icon, is_on, name, help);
    egui::Popup::menu(&response).show(content);
}
