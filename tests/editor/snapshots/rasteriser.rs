//! Draws the triangles of egui on the processor, so that pictures of panels need no graphics driver and are the same on
//! every machine. Textures and colours of vertices are multiplied as they are encoded, and blended as light, as in the
//! window.

use std::cell::RefCell;
use std::collections::HashMap;
use std::rc::Rc;

use bevy_egui::egui::epaint::{ClippedPrimitive, ImageDelta, Primitive, Vertex};
use bevy_egui::egui::{Color32, ColorImage, ImageData, Pos2, Rangef, Rect, TextureId, TexturesDelta};
use egui_kittest::TestRenderer;
use image::{Rgb, RgbImage};
use sunroom::color::{linear_from_srgb, srgb_from_linear};

/// The textures of egui, which the harness fills.
#[derive(Clone, Default)]
pub struct Textures(Rc<RefCell<HashMap<TextureId, ColorImage>>>);

impl TestRenderer for Textures {
    fn handle_delta(&mut self, delta: &mut TexturesDelta) {
        let mut textures = self.0.borrow_mut();
        for (id, changes) in std::mem::take(&mut delta.set) {
            for ImageDelta { image, pos, .. } in changes {
                let ImageData::Color(image) = image;
                match pos {
                    None => _ = textures.insert(id, (*image).clone()),
                    Some(corner) => {
                        let whole = textures.get_mut(&id).expect("a part of a known texture");
                        copy(&image, whole, corner);
                    }
                }
            }
        }
        // The last frame is drawn after its textures were freed: they stay.
        delta.free.clear();
    }
}

fn copy(part: &ColorImage, whole: &mut ColorImage, [left, top]: [usize; 2]) {
    for (row, pixels) in part.pixels.chunks(part.size[0]).enumerate() {
        let first = (top + row) * whole.size[0] + left;
        whole.pixels[first..first + pixels.len()].copy_from_slice(pixels);
    }
}

/// Draws the primitives at one pixel per point.
pub fn draw(size: [u32; 2], background: Color32, primitives: &[ClippedPrimitive], textures: &Textures) -> RgbImage {
    let [width, height] = size.map(|side| side as usize);
    let mut picture = Picture {
        width,
        height,
        pixels: vec![linear(background.to_normalized_gamma_f32()); width * height],
    };
    let textures = textures.0.borrow();
    for ClippedPrimitive { clip_rect, primitive } in primitives {
        let Primitive::Mesh(mesh) = primitive else { continue };
        let texture = textures.get(&mesh.texture_id);
        for corners in mesh.indices.chunks_exact(3) {
            let corners = [0, 1, 2].map(|corner| mesh.vertices[corners[corner] as usize]);
            picture.triangle(corners, *clip_rect, texture);
        }
    }
    let encoded = |channel: &f32| (255.0 * srgb_from_linear(channel.clamp(0.0, 1.0))).round() as u8;
    RgbImage::from_fn(size[0], size[1], |x, y| {
        Rgb(picture.pixels[y as usize * width + x as usize].each_ref().map(encoded))
    })
}

fn linear([r, g, b, _]: [f32; 4]) -> [f32; 3] {
    [r, g, b].map(linear_from_srgb)
}

/// Linear colours, row by row from the top.
struct Picture {
    width: usize,
    height: usize,
    pixels: Vec<[f32; 3]>,
}

impl Picture {
    /// Covers the pixels whose centres are in a triangle. A centre on an edge of two triangles belongs to one of them.
    fn triangle(&mut self, mut corners: [Vertex; 3], clip: Rect, texture: Option<&ColorImage>) {
        let area = side(corners[0].pos, corners[1].pos, corners[2].pos);
        if area == 0.0 {
            return;
        }
        if area < 0.0 {
            corners.swap(1, 2);
        }
        let [a, b, c] = corners.map(|corner| corner.pos);
        let place = Rect::from_points(&[a, b, c]).intersect(clip);
        let edges = [(b, c), (c, a), (a, b)];
        let first = corners[0];
        // Most of a panel has one colour.
        let is_flat = corners
            .iter()
            .all(|corner| (corner.uv, corner.color) == (first.uv, first.color));
        let flat = is_flat.then(|| Over::new(color(&corners, [1.0, 0.0, 0.0], texture)));
        for row in covered(place.top(), place.bottom(), self.height) {
            let y = row as f32 + 0.5;
            let reach = reach(edges, y, place);
            for column in covered(reach.min, reach.max, self.width) {
                let at = Pos2::new(column as f32 + 0.5, y);
                let sides = edges.map(|(from, to)| side(from, to, at));
                let is_inside = |(side, (from, to)): (&f64, (Pos2, Pos2))| {
                    *side > 0.0 || (*side == 0.0 && is_top_or_left(from, to))
                };
                if sides.iter().zip(edges).all(is_inside) {
                    let over = flat.unwrap_or_else(|| {
                        let shares = sides.map(|side| (side / area.abs()) as f32);
                        Over::new(color(&corners, shares, texture))
                    });
                    over.blend(&mut self.pixels[row * self.width + column]);
                }
            }
        }
    }
}

/// A colour that is put over others.
#[derive(Clone, Copy)]
struct Over {
    /// Linear, and multiplied by the opacity.
    color: [f32; 3],
    transparency: f32,
}

impl Over {
    fn new(color: [f32; 4]) -> Self {
        Self {
            color: linear(color),
            transparency: 1.0 - color[3],
        }
    }

    fn blend(self, pixel: &mut [f32; 3]) {
        for (below, over) in pixel.iter_mut().zip(self.color) {
            *below = over + *below * self.transparency;
        }
    }
}

/// The part of a row that a triangle may cover.
fn reach(edges: [(Pos2, Pos2); 3], y: f32, place: Rect) -> Rangef {
    let mut reach = Rangef::NOTHING;
    for (from, to) in edges {
        if (from.y - y) * (to.y - y) <= 0.0 {
            let share = if from.y == to.y {
                0.0
            } else {
                (y - from.y) / (to.y - from.y)
            };
            let crossing = from.x + share * (to.x - from.x);
            reach.min = reach.min.min(crossing);
            reach.max = reach.max.max(crossing);
        }
    }
    // The crossings are rounded.
    Rangef::new(
        (reach.min - 1.0).max(place.left()),
        (reach.max + 1.0).min(place.right()),
    )
}

/// The pixels whose centres are between two coordinates.
fn covered(from: f32, to: f32, count: usize) -> std::ops::Range<usize> {
    let first = (from - 0.5).ceil().max(0.0) as usize;
    first..((to - 0.5).ceil().max(0.0) as usize).min(count)
}

/// Twice the area of a triangle, which is negative if its corners go anticlockwise on the screen.
fn side(a: Pos2, b: Pos2, c: Pos2) -> f64 {
    let [a, b, c] = [a, b, c].map(|at| [f64::from(at.x), f64::from(at.y)]);
    (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
}

fn is_top_or_left(from: Pos2, to: Pos2) -> bool {
    to.y < from.y || (to.y == from.y && to.x > from.x)
}

fn color(corners: &[Vertex; 3], shares: [f32; 3], texture: Option<&ColorImage>) -> [f32; 4] {
    let mut color = [0.0; 4];
    let mut at = [0.0; 2];
    for (corner, share) in corners.iter().zip(shares) {
        let own = corner.color.to_normalized_gamma_f32();
        for (sum, channel) in color.iter_mut().zip(own) {
            *sum += share * channel;
        }
        at[0] += share * corner.uv.x;
        at[1] += share * corner.uv.y;
    }
    // A picture that no test has given is grey.
    let Some(texture) = texture else {
        return [0.4, 0.4, 0.4, color[3]];
    };
    let texel = bilinear(texture, at);
    std::array::from_fn(|channel| color[channel] * texel[channel])
}

/// The colour of a texture at (0, 0), its top left corner, to (1, 1).
fn bilinear(texture: &ColorImage, [u, v]: [f32; 2]) -> [f32; 4] {
    let [width, height] = texture.size;
    let (x, y) = (u * width as f32 - 0.5, v * height as f32 - 0.5);
    let texel = |column: f32, row: f32| {
        let column = column.clamp(0.0, width as f32 - 1.0) as usize;
        let row = row.clamp(0.0, height as f32 - 1.0) as usize;
        texture.pixels[row * width + column].to_normalized_gamma_f32()
    };
    let (left, top) = (x.floor(), y.floor());
    let (right, below) = (x - left, y - top);
    let four = [
        (texel(left, top), (1.0 - right) * (1.0 - below)),
        (texel(left + 1.0, top), right * (1.0 - below)),
        (texel(left, top + 1.0), (1.0 - right) * below),
        (texel(left + 1.0, top + 1.0), right * below),
    ];
    std::array::from_fn(|channel| four.iter().map(|(color, share)| share * color[channel]).sum())
}
