//! The outline of the selection and of the hovered thing, as an image over the picture. Saved images do not have it.
//!
//! `outline_pass` finds the edges; here they become lines of constant width with smooth borders. The line of a hidden
//! part is dim.

use std::sync::Arc;

use bevy::math::{UVec2, Vec2};
use bevy::prelude::Entity;
use bevy_egui::egui::{
    Color32, ColorImage, Id, Painter, Pos2, Rect, TextureHandle, TextureOptions, Vec2 as Points, pos2,
};

use crate::app::editor::command::selection::Selection;
use crate::render::visibility::silhouette::{EdgePoint, PixelGrid};

/// The emphasis of a thing's outline. Where two overlap, the later level is shown.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
pub enum Level {
    /// It has no outline.
    #[default]
    None,
    /// It is under the pointer.
    Hovered,
    /// It is selected, but not the active one.
    Selected,
    /// The one that was selected last.
    Active,
}

impl Level {
    /// The strongest level that holds for `entity`.
    pub fn of(entity: Entity, selection: &Selection, hovered: Option<Entity>) -> Self {
        if selection.active() == Some(entity) {
            Self::Active
        } else if selection.contains(entity) {
            Self::Selected
        } else if hovered == Some(entity) {
            Self::Hovered
        } else {
            Self::None
        }
    }

    /// The colour of outlines and icons.
    pub fn color(self) -> Color32 {
        match self {
            Self::None => Color32::from_rgb(235, 225, 170),
            Self::Hovered => Color32::from_white_alpha(130),
            Self::Selected => Color32::from_rgb(226, 112, 24),
            Self::Active => Color32::from_rgb(255, 190, 70),
        }
    }
}

/// The opacity of the line of a hidden part, as a share of that of a visible one.
const HIDDEN: f32 = 0.6;

/// An image of lines that covers a part of the picture.
#[derive(Clone, Debug, PartialEq)]
pub struct OutlineImage {
    /// The size of the whole picture in pixels.
    picture: UVec2,
    /// Its upper left pixel in the picture.
    min: UVec2,
    size: UVec2,
    /// Row by row.
    pixels: Vec<Color32>,
}

impl OutlineImage {
    /// Draws lines `width` pixels wide along the edges of each level, which were found in `grid`. Later levels are
    /// drawn over earlier ones, and visible edges over hidden ones.
    pub fn draw(edges: &[(Level, Vec<EdgePoint>)], grid: &PixelGrid, width: f32) -> Self {
        let reach = 0.5 * width + 0.5;
        let margin = UVec2::splat(reach.ceil() as u32);
        let min = grid.min.saturating_sub(margin);
        let size = (grid.max + margin).min(grid.picture) - min;
        let mut image = Self {
            picture: grid.picture,
            min,
            size,
            pixels: vec![Color32::TRANSPARENT; size.element_product() as usize],
        };
        let mut coverage = Vec::new();
        for visible in [false, true] {
            for (level, edges) in edges {
                coverage.clear();
                for edge in edges.iter().filter(|edge| edge.visible == visible) {
                    if coverage.is_empty() {
                        coverage.resize(image.pixels.len(), 0);
                    }
                    image.cover(&mut coverage, edge.at, reach);
                }
                let share = if visible { 1.0 } else { HIDDEN };
                let color = level.color().to_array().map(|channel| f32::from(channel) * share);
                for (pixel, &covered) in image.pixels.iter_mut().zip(&coverage) {
                    if covered > 0 {
                        *pixel = over(*pixel, color, f32::from(covered) / 255.0);
                    }
                }
            }
        }
        image
    }

    /// Notes how much of the pixels around a point is covered by a disc of radius `reach` with an edge that is smooth
    /// over a pixel.
    fn cover(&self, coverage: &mut [u8], at: Vec2, reach: f32) {
        let at = at - self.min.as_vec2();
        let last = self.size.as_vec2() - 1.0;
        let from = (at - reach - 0.5).ceil().clamp(Vec2::ZERO, last).as_uvec2();
        let to = (at + reach - 0.5).floor().clamp(Vec2::ZERO, last).as_uvec2();
        for y in from.y..=to.y {
            for x in from.x..=to.x {
                let distance = (UVec2::new(x, y).as_vec2() + 0.5).distance(at);
                let covered = (255.0 * (reach - distance).clamp(0.0, 1.0)) as u8;
                let pixel = &mut coverage[(y * self.size.x + x) as usize];
                *pixel = covered.max(*pixel);
            }
        }
    }

    /// The rectangle of the image in the window, for a picture at this rectangle.
    fn place(&self, picture: Rect) -> Rect {
        let corner = |pixel: UVec2| {
            let film = pixel.as_vec2() / self.picture.as_vec2();
            picture.min + Points::new(film.x, film.y) * picture.size()
        };
        Rect::from_min_max(corner(self.min), corner(self.min + self.size))
    }

    /// The colour of a pixel of the picture; transparent outside of the image.
    pub fn pixel(&self, at: UVec2) -> Color32 {
        let within = at.cmpge(self.min).all() && at.cmplt(self.min + self.size).all();
        if !within {
            return Color32::TRANSPARENT;
        }
        let at = at - self.min;
        self.pixels[(at.y * self.size.x + at.x) as usize]
    }
}

/// Blends `color` (premultiplied, 0 to 255) over a pixel.
fn over(below: Color32, color: [f32; 4], covered: f32) -> Color32 {
    let kept = 1.0 - color[3] / 255.0 * covered;
    let below = below.to_array();
    let [r, g, b, a] =
        std::array::from_fn(|channel| (color[channel] * covered + f32::from(below[channel]) * kept + 0.5) as u8);
    Color32::from_rgba_premultiplied(r, g, b, a)
}

/// The last outline.
#[derive(Clone, Debug, Default)]
pub struct SelectionOutline {
    image: Option<Arc<OutlineImage>>,
    /// The number of the image, which changes with it.
    number: u64,
}

/// The image that is on the GPU, by its number.
type Uploaded = Option<(u64, TextureHandle)>;

impl SelectionOutline {
    /// The image; None without outlines.
    pub fn image(&self) -> Option<&OutlineImage> {
        self.image.as_deref()
    }

    /// Shows this image in place of the last one.
    pub(crate) fn replace(&mut self, image: Option<OutlineImage>) {
        self.image = image.map(Arc::new);
        self.number += 1;
    }

    /// Paints the image over the picture, whose rectangle in the window is `picture`. `view` tells the outlines of
    /// views beside each other apart.
    pub fn paint(&self, painter: &Painter, picture: Rect, view: Id) {
        let Some(image) = &self.image else { return };
        let id = view.with("outline texture");
        let context = painter.ctx();
        let mut uploaded: Uploaded = context.data(|data| data.get_temp(id)).flatten();
        if uploaded.as_ref().is_none_or(|(number, _)| *number != self.number) {
            let size = [image.size.x as usize, image.size.y as usize];
            let pixels = ColorImage::new(size, image.pixels.clone());
            match &mut uploaded {
                Some((number, texture)) => {
                    texture.set(pixels, TextureOptions::LINEAR);
                    *number = self.number;
                }
                None => {
                    let texture = context.load_texture("outline", pixels, TextureOptions::LINEAR);
                    uploaded = Some((self.number, texture));
                }
            }
            context.data_mut(|data| data.insert_temp(id, uploaded.clone()));
        }
        if let Some((_, texture)) = uploaded {
            let whole = Rect::from_min_max(Pos2::ZERO, pos2(1.0, 1.0));
            painter.image(texture.id(), image.place(picture), whole, Color32::WHITE);
        }
    }
}

#[cfg(test)]
mod tests {
    use bevy::math::Affine3A;

    use super::*;
    use crate::render::camera::Camera;

    fn grid() -> PixelGrid {
        PixelGrid {
            camera: Camera::new(Affine3A::IDENTITY, 60.0, 2.0, 0.1, 10.0, None),
            picture: UVec2::new(40, 20),
            min: UVec2::new(10, 5),
            max: UVec2::new(30, 15),
            step: 1,
        }
    }

    /// A line down the middle of the grid.
    fn line(x: f32, level: Level, visible: bool) -> (Level, Vec<EdgePoint>) {
        let place = |n: u32| Vec2::new(x, 6.0 + 0.25 * n as f32);
        let points = (0..32).map(|n| EdgePoint {
            at: place(n),
            mark: 1,
            visible,
        });
        (level, points.collect())
    }

    #[test]
    fn lines_are_as_wide_as_asked_wherever_they_lie() {
        for x in [20.0, 20.25, 20.5, 20.9] {
            for width in [2.0, 3.0, 4.0] {
                let image = OutlineImage::draw(&[line(x, Level::Active, true)], &grid(), width);
                let across: f32 = (0..40)
                    .map(|x| f32::from(image.pixel(UVec2::new(x, 10)).a()) / 255.0)
                    .sum();
                assert!((across - width).abs() < 0.1, "{across} for {width} at {x}");
            }
        }
    }

    #[test]
    fn hidden_lines_are_dim_and_the_active_one_wins() {
        let middle = UVec2::new(20, 10);
        let drawn = |lines: &[(Level, Vec<EdgePoint>)]| OutlineImage::draw(lines, &grid(), 2.0).pixel(middle);
        let [hidden, seen] = [false, true].map(|visible| line(20.5, Level::Active, visible));
        let dim = drawn(&[hidden]);
        let bright = drawn(std::slice::from_ref(&seen));
        assert_eq!(bright, Level::Active.color());
        assert!(dim.a() > 120 && dim.a() < 180, "{dim:?}");
        assert_eq!(drawn(&[line(20.5, Level::Selected, true), seen]), bright);
        assert_eq!(drawn(&[]), Color32::TRANSPARENT);
    }

    #[test]
    fn it_lies_where_the_grid_was() {
        let image = OutlineImage::draw(&[], &grid(), 2.0);
        let picture = Rect::from_min_size(pos2(100.0, 50.0), Points::new(80.0, 40.0));
        // A margin of two pixels, each of two points.
        assert_eq!(
            image.place(picture),
            Rect::from_min_max(pos2(116.0, 56.0), pos2(164.0, 84.0))
        );
    }
}
