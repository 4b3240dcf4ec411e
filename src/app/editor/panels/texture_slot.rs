//! Shows a parameter that may be a texture: one row with a menu that switches between the two, and below it, on demand,
//! the texture's own parameters.

use std::path::Path;

use bevy_egui::egui::{self, Color32, Ui};

use super::caption::Caption;
use super::color_field;
use super::fields::{self, name_cell};
use super::pattern_rows::shown_colors;
use super::plain_value::PlainValue;
use super::texture::{self, TextureKind};
use crate::app::editor::model::panel_textures::PanelTextures;
use crate::color::Rgb;
use crate::scene::texture_parameters::{COLOR0, COLOR1, SCALE, TIMES};
use crate::scene::{Parameter, Pattern, SquarePath, Texture};

/// The edits of the user in a slot.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct SlotEdit {
    pub changed: bool,
    /// The place in the texture whose picture is to be chosen.
    pub wants_picture: Option<SquarePath>,
}

impl SlotEdit {
    pub(super) fn add(&mut self, other: Self) {
        self.changed |= other.changed;
        self.wants_picture = self.wants_picture.or(other.wants_picture);
    }
}

/// A slot: its caption, the thumbnails, and its place in nested textures.
#[derive(Clone, Copy)]
pub(crate) struct Slot<'a> {
    pub caption: Caption<'a>,
    /// The name of the value without a texture.
    pub plain: &'static str,
    pub textures: &'a PanelTextures,
    pub place: SquarePath,
}

const MENU_WIDTH: f32 = 18.0;
/// The room between the menu and the row before it, in points, and that of both.
const GAP: f32 = 3.0;
pub(super) const BESIDE: f32 = MENU_WIDTH + GAP;
/// The edge of a square of the menu's icon, in points.
const SQUARE: f32 = 3.5;
const THUMBNAIL: egui::Vec2 = egui::vec2(28.0, 18.0);

impl Slot<'_> {
    /// Shows the slot. `plain_rows` shows the value without a texture; `otherwise` is that value if the texture has
    /// none to restore.
    pub fn show<T: PlainValue>(
        &self,
        ui: &mut Ui,
        value: &mut Parameter<T>,
        otherwise: T,
        plain_rows: impl FnOnce(&mut Ui, Caption<'_>, &mut T) -> bool,
    ) -> SlotEdit {
        let mut edit = SlotEdit::default();
        let id = ui.make_persistent_id((self.caption.text, "opened"));
        let mut is_open: bool = ui.data(|data| data.get_temp(id)).unwrap_or(false);
        let kind = match value {
            Parameter::Constant(_) => TextureKind::Plain,
            Parameter::Texture(texture) => TextureKind::of(texture),
        };
        let mut wanted = None;
        ui.horizontal_top(|ui| {
            let spacing = ui.spacing().item_spacing;
            ui.spacing_mut().item_spacing.x = GAP;
            let width = ui.available_width() - BESIDE;
            let layout = egui::Layout::top_down(egui::Align::Min);
            ui.allocate_ui_with_layout(egui::vec2(width, 0.0), layout, |ui| {
                ui.spacing_mut().item_spacing = spacing;
                ui.set_width(width);
                match value {
                    Parameter::Constant(plain) => edit.changed |= plain_rows(ui, self.caption, plain),
                    Parameter::Texture(texture) => {
                        if self.texture_row(ui, texture, is_open) {
                            is_open = !is_open;
                        }
                    }
                }
            });
            wanted = self.menu(ui, kind);
        });
        match wanted {
            Some(TextureKind::Bitmap) => edit.wants_picture = Some(self.place),
            Some(other) if other != kind => {
                texture::switch(value, other, otherwise);
                edit.changed = true;
                is_open = true;
            }
            _ => {}
        }
        ui.data_mut(|data| data.insert_temp(id, is_open));
        if let Parameter::Texture(texture) = value
            && is_open
        {
            ui.spacing_mut().indent = 10.0;
            ui.indent(id, |ui| edit.add(self.parameters(ui, texture)));
        }
        edit
    }

    /// Shows the row of a texture; returns true when it is to be opened or closed.
    fn texture_row(&self, ui: &mut Ui, texture: &Texture, is_open: bool) -> bool {
        ui.horizontal(|ui| {
            let label = name_cell(ui, self.caption);
            ui.spacing_mut().item_spacing.x = 4.0;
            let picture = thumbnail(ui, texture, self.textures);
            let text = format!(
                "{} {}",
                if is_open { "\u{23f7}" } else { "\u{23f5}" },
                shown_name(texture)
            );
            let size = egui::vec2(ui.available_width(), ui.spacing().interact_size.y);
            // A text at the right, even an empty one, keeps the main text at the left.
            let button = egui::Button::selectable(false, text).right_text("").truncate();
            let name = ui.add(button.min_size(size));
            let name = named(name, self.caption, &label);
            let name = match texture {
                Texture::Bitmap(bitmap) => name.on_hover_text(bitmap.path.to_string_lossy()),
                _ => name,
            };
            picture.clicked() || name.clicked()
        })
        .inner
    }

    fn menu(&self, ui: &mut Ui, kind: TextureKind) -> Option<TextureKind> {
        let mut chosen = None;
        let size = egui::vec2(MENU_WIDTH, ui.spacing().interact_size.y);
        let button = ui.add(egui::Button::new("").min_size(size));
        squares(ui, button.rect, kind != TextureKind::Plain);
        egui::Popup::menu(&button).show(|ui| {
            for option in TextureKind::all() {
                let name = option.name(self.plain);
                if ui.selectable_label(option == kind, name).clicked() {
                    chosen = Some(option);
                    ui.close();
                }
            }
        });
        let name = format!("{} source", self.caption.text);
        button
            .on_hover_text("A constant, or a texture")
            .widget_info(|| egui::WidgetInfo::labeled(egui::WidgetType::Button, true, &name));
        chosen
    }

    fn parameters(&self, ui: &mut Ui, texture: &mut Texture) -> SlotEdit {
        let mut edit = SlotEdit::default();
        match texture {
            Texture::Bitmap(bitmap) => {
                if ui.button("Choose another picture\u{2026}").clicked() {
                    edit.wants_picture = Some(self.place);
                }
                edit.changed |= texture::bitmap(ui, bitmap);
            }
            Texture::Checkerboard { color0, color1, to_uv } => {
                for (square, info, color) in [(0, &COLOR0, color0), (1, &COLOR1, color1)] {
                    let slot = Slot {
                        caption: info.into(),
                        plain: "colour",
                        textures: self.textures,
                        place: self.place.within(square),
                    };
                    let shown = slot.show(ui, color, Rgb::splat(0.5), |ui, caption, color| {
                        color_field::color(ui, caption, color)
                    });
                    edit.add(shown);
                }
                edit.changed |= texture::placing(ui, to_uv);
            }
            Texture::MeshAttribute { name, scale, times } => {
                edit.changed |= texture::mesh_attribute(ui, name);
                edit.changed |= fields::number(ui, &SCALE, scale, 0.01, f32::MIN..=f32::MAX);
                if let Some(inside) = times.take() {
                    let mut value = Parameter::Texture(*inside);
                    let slot = Slot {
                        caption: (&TIMES).into(),
                        plain: "nothing",
                        textures: self.textures,
                        place: self.place.within(0),
                    };
                    let shown = slot.show(ui, &mut value, Rgb::ONE, |ui, caption, color| {
                        color_field::color(ui, caption, color)
                    });
                    edit.add(shown);
                    if let Parameter::Texture(texture) = value {
                        *times = Some(Box::new(texture));
                    }
                }
            }
            Texture::Pattern(pattern) => self.pattern(ui, pattern, &mut edit),
        }
        edit
    }
}

/// Shows the row of a picture file that is no texture, such as an environment's; returns true when another is to be
/// chosen.
pub(crate) fn picture_row(ui: &mut Ui, caption: Caption<'_>, path: &Path, textures: &PanelTextures) -> bool {
    let texture = Texture::of_picture(path.to_owned(), None);
    ui.horizontal(|ui| {
        let label = name_cell(ui, caption);
        ui.spacing_mut().item_spacing.x = 4.0;
        let picture = thumbnail(ui, &texture, textures);
        let name = match shown_name(&texture) {
            name if name.is_empty() => "Choose\u{2026}".to_owned(),
            name => name,
        };
        let size = egui::vec2(ui.available_width(), ui.spacing().interact_size.y);
        let button = ui
            .add(egui::Button::new(name).truncate().min_size(size))
            .on_hover_text("Choose another picture");
        let button = named(button, caption, &label);
        picture.clicked() || button.clicked()
    })
    .inner
}

/// Names a button after its row, not after its text.
fn named(button: egui::Response, caption: Caption<'_>, label: &egui::Response) -> egui::Response {
    button.widget_info(|| egui::WidgetInfo::labeled(egui::WidgetType::Button, true, caption.text));
    button.labelled_by(label.id)
}

fn shown_name(texture: &Texture) -> String {
    match texture {
        Texture::Bitmap(bitmap) => {
            let file = bitmap.path.file_name().unwrap_or_default();
            file.to_string_lossy().into_owned()
        }
        Texture::Checkerboard { .. } => "checkerboard".to_owned(),
        Texture::MeshAttribute { name, .. } => name.clone(),
        Texture::Pattern(pattern) => Pattern::label(pattern.plugin()).to_owned(),
    }
}

/// Paints the icon of the menu: squares of a checkerboard, bright if the parameter has a texture.
fn squares(ui: &Ui, button: egui::Rect, is_textured: bool) {
    let color = match is_textured {
        true => ui.visuals().text_color(),
        false => ui.visuals().weak_text_color(),
    };
    let corner = button.center() - egui::Vec2::splat(1.5 * SQUARE);
    for (column, row) in [(0, 0), (2, 0), (1, 1), (0, 2), (2, 2)] {
        let place = corner + SQUARE * egui::vec2(column as f32, row as f32);
        let square = egui::Rect::from_min_size(place, egui::Vec2::splat(SQUARE));
        ui.painter().rect_filled(square, 0.0, color);
    }
}

/// Shows a thumbnail of the texture; a missing bitmap is crossed out.
fn thumbnail(ui: &mut Ui, texture: &Texture, textures: &PanelTextures) -> egui::Response {
    let (rect, response) = ui.allocate_exact_size(THUMBNAIL, egui::Sense::click());
    paint(ui, rect, texture, textures);
    match texture {
        Texture::Bitmap(bitmap) => match textures.picture(&bitmap.path) {
            Some(picture) => response.on_hover_ui(|ui| {
                let [width, height] = picture.size;
                let longer = width.max(height) as f32;
                let size = egui::vec2(width as f32, height as f32) * (192.0 / longer);
                ui.image((picture.texture, size));
                ui.weak(format!("{width} x {height}"));
            }),
            None => response.on_hover_text("The picture does not exist, or is not loaded yet."),
        },
        _ => response,
    }
}

fn paint_color(ui: &Ui, rect: egui::Rect, color: &Parameter<Rgb>, textures: &PanelTextures) {
    match color {
        Parameter::Constant(color) => {
            let [r, g, b] = color.to_array();
            ui.painter().rect_filled(rect, 0.0, egui::Rgba::from_rgb(r, g, b));
        }
        Parameter::Texture(inside) => paint(ui, rect, inside, textures),
    }
}

fn paint(ui: &Ui, rect: egui::Rect, texture: &Texture, textures: &PanelTextures) {
    let painter = ui.painter();
    let frame = ui.visuals().widgets.noninteractive.bg_stroke;
    match texture {
        Texture::Bitmap(bitmap) => match textures.picture(&bitmap.path) {
            Some(picture) => {
                let whole = egui::Rect::from_min_max(egui::Pos2::ZERO, egui::pos2(1.0, 1.0));
                painter.image(picture.texture, rect, whole, Color32::WHITE);
            }
            None => {
                painter.line_segment([rect.left_top(), rect.right_bottom()], frame);
                painter.line_segment([rect.left_bottom(), rect.right_top()], frame);
            }
        },
        Texture::Checkerboard { color0, color1, .. } => {
            let half = 0.5 * rect.size();
            for (row, column) in [(0, 0), (0, 1), (1, 0), (1, 1)] {
                let color = if row == column { color1 } else { color0 };
                let corner = rect.min + egui::vec2(column as f32, row as f32) * half;
                let square = egui::Rect::from_min_size(corner, half);
                paint_color(ui, square, color, textures);
            }
        }
        Texture::MeshAttribute { .. } => {
            let corners = [
                (rect.left_bottom(), Color32::from_rgb(200, 70, 60)),
                (rect.right_bottom(), Color32::from_rgb(70, 170, 80)),
                (rect.center_top(), Color32::from_rgb(70, 100, 210)),
            ];
            let mut triangle = egui::Mesh::default();
            for (corner, color) in corners {
                triangle.colored_vertex(corner, color);
            }
            triangle.add_triangle(0, 1, 2);
            painter.add(triangle);
        }
        Texture::Pattern(pattern) => {
            let colors = shown_colors(pattern);
            let size = egui::vec2(rect.width() / colors.len() as f32, rect.height());
            for (place, color) in colors.iter().enumerate() {
                let part = egui::Rect::from_min_size(rect.min + egui::vec2(place as f32 * size.x, 0.0), size);
                paint_color(ui, part, color, textures);
            }
        }
    }
    painter.rect_stroke(rect, 1.0, frame, egui::StrokeKind::Inside);
}
