//! Texture coordinates around a point of a surface as a flat sheet in the world, and one tile of a texture on it.

use bevy::math::{Affine2, Mat2, Vec2, Vec3};
use bevy_egui::egui::Pos2;

use crate::app::editor::camera::picking::MappedSurface;
use crate::app::editor::camera::screen::Screen;

/// Texture coordinates in the plane that touches a surface: exact on flat faces, nearly so around the place on curved
/// ones.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Sheet {
    place: Vec3,
    uv: Vec2,
    /// Two directions across the normal, of unit length: that in which u grows, and the one that is to its left as
    /// seen from the front.
    axes: [Vec3; 2],
    /// Lengths along `axes` from uv.
    lengths_from_uv: Mat2,
}

impl Sheet {
    /// The sheet at a point; None if there are no texture coordinates, or they do not span a plane.
    pub fn at(surface: &MappedSurface) -> Option<Self> {
        let [du, dv] = surface.dp_duv.map(|edge| edge.reject_from(surface.normal));
        let along = du.try_normalize()?;
        let axes = [along, surface.normal.cross(along)];
        let in_plane = |edge: Vec3| Vec2::from(axes.map(|axis| edge.dot(axis)));
        let lengths_from_uv = Mat2::from_cols(in_plane(du), in_plane(dv));
        let is_flat = lengths_from_uv.determinant().abs() <= 1e-6 * du.length() * dv.length();
        (surface.is_mapped && !is_flat && lengths_from_uv.inverse().is_finite()).then_some(Self {
            place: surface.position,
            uv: surface.uv,
            axes,
            lengths_from_uv,
        })
    }

    /// The texture coordinates at its point of contact.
    pub fn uv(&self) -> Vec2 {
        self.uv
    }

    /// Lengths in the plane, along u and to its left, from differences of uv.
    pub fn lengths_from_uv(&self) -> Mat2 {
        self.lengths_from_uv
    }

    /// The point in the world with these texture coordinates.
    pub fn world(&self, uv: Vec2) -> Vec3 {
        let along = self.lengths_from_uv * (uv - self.uv);
        self.place + self.axes[0] * along.x + self.axes[1] * along.y
    }

    /// The texture coordinates under a point of the window; None above the horizon of the plane.
    pub fn uv_under(&self, screen: &Screen, at: Pos2) -> Option<Vec2> {
        let ray = screen.ray(at);
        let normal = self.axes[0].cross(self.axes[1]);
        let t = (self.place - ray.origin).dot(normal) / ray.dir.dot(normal);
        let from = ray.at(t) - self.place;
        let along = Vec2::from(self.axes.map(|axis| from.dot(axis)));
        (t > 0.0 && t.is_finite()).then(|| self.uv + self.lengths_from_uv.inverse() * along)
    }
}

/// A square of tiles of a texture on a sheet: one as a rule, several if one would be too small for the pointer, a part
/// of one that is too large.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Tile {
    pub sheet: Sheet,
    /// The transform to coordinates of the texture from uv.
    pub to_uv: Affine2,
    /// The corner with the smallest coordinates, in tiles.
    pub base: Vec2,
    /// The length of its edges, in tiles.
    pub span: f32,
}

/// The shortest edge that the pointer can hit well, in points.
const SHORTEST: f32 = 44.0;
/// The longest edge, as a share of the picture's shorter one.
const LONGEST: f32 = 0.8;
/// The most times that the span is doubled or halved.
const MOST_STEPS: u32 = 12;

impl Tile {
    /// The tile around a point of the texture, in a size that suits the screen.
    pub fn around(sheet: Sheet, to_uv: Affine2, focus: Vec2, screen: &Screen) -> Option<Self> {
        let inverse = to_uv.inverse();
        if !inverse.is_finite() {
            return None;
        }
        let middle = sheet.world(inverse.transform_point2(focus));
        let units = screen.units_per_point(screen.depth(middle)).abs();
        let lengths = sheet.lengths_from_uv * inverse.matrix2;
        let edges = [lengths.x_axis.length() / units, lengths.y_axis.length() / units];
        let [shorter, longer] = [edges[0].min(edges[1]), edges[0].max(edges[1])];
        let most = LONGEST * screen.picture.size().min_elem();
        let mut span = 1.0;
        for _ in 0..MOST_STEPS {
            if span * longer > most {
                span *= 0.5;
            } else if span * shorter < SHORTEST && 2.0 * span * longer <= most {
                span *= 2.0;
            }
        }
        Some(Self {
            sheet,
            to_uv,
            base: (focus / span).floor() * span,
            span,
        })
    }

    /// The texture coordinates in tiles at shares of the edges from the base.
    pub fn texture(&self, share: Vec2) -> Vec2 {
        self.base + self.span * share
    }

    /// The point in the world at shares of the edges.
    pub fn world(&self, share: Vec2) -> Vec3 {
        self.sheet.world(self.uv(self.texture(share)))
    }

    /// The uv coordinates of a point of the texture.
    pub fn uv(&self, texture: Vec2) -> Vec2 {
        self.to_uv.inverse().transform_point2(texture)
    }

    /// The point of the window at shares of the edges; None behind the camera.
    pub fn point(&self, screen: &Screen, share: Vec2) -> Option<Pos2> {
        screen.project(self.world(share))
    }

    /// Lengths in the plane of the sheet from differences in the texture.
    pub fn lengths_from_texture(&self) -> Mat2 {
        self.sheet.lengths_from_uv * self.to_uv.matrix2.inverse()
    }

    /// The lengths of the edges of one whole tile, in world units.
    pub fn size(&self) -> Vec2 {
        let lengths = self.lengths_from_texture();
        Vec2::new(lengths.x_axis.length(), lengths.y_axis.length())
    }
}
