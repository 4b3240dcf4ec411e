//! Shapes.

use std::path::PathBuf;

use bevy::prelude::*;

use super::euler::upright_rest;
use crate::scene::{DocumentOrder, Solid, ToWorld};

/// A surface. Its material is [`crate::scene::UsesMaterial`], its emission [`crate::scene::AreaLight`].
#[derive(Component, Reflect, Clone, Debug, PartialEq)]
#[reflect(Component, PartialEq)]
#[require(ToWorld, DocumentOrder)]
pub struct Shape {
    /// Its geometry.
    pub kind: ShapeKind,
    /// Flips the normals: the side that emits and, for one-sided materials, the side that is visible.
    pub flip_normals: bool,
    /// The lightmap texels per length relative to other shapes, in [`Self::LIGHTMAP_SCALES`]; 0 means no lightmap.
    pub lightmap_scale: f32,
    /// Whether a rectangle is a portal: light of the sky comes in through it. Other shapes are none.
    pub portal: bool,
}

impl Default for Shape {
    fn default() -> Self {
        Self {
            kind: ShapeKind::default(),
            flip_normals: false,
            lightmap_scale: 1.0,
            portal: false,
        }
    }
}

impl Shape {
    /// The range of [`lightmap_scale`](Self::lightmap_scale).
    pub const LIGHTMAP_SCALES: std::ops::RangeInclusive<f32> = 0.0..=100.0;

    /// The reference point of the shape in its own space: the centre of a sphere, the first end of a cylinder, the
    /// first corner of a triangle, the origin for others.
    pub fn middle(&self) -> Vec3 {
        match self.kind {
            ShapeKind::Sphere { center, .. } => center,
            ShapeKind::Cylinder { p0, .. } => p0,
            ShapeKind::Triangle { corners } => corners[0],
            _ => Vec3::ZERO,
        }
    }

    /// The shape with its [`middle`](Self::middle) moved in its own space. None for shapes at the origin.
    pub(crate) fn moved_to(&self, middle: Vec3) -> Option<Self> {
        let mut moved = self.clone();
        let by = middle.as_dvec3() - self.middle().as_dvec3();
        // Adding numbers of few digits gives few digits.
        let beside = |place: Vec3| short_together([(place.as_dvec3() + by).as_vec3()], 7)[0];
        match &mut moved.kind {
            ShapeKind::Sphere { center, .. } => *center = middle,
            ShapeKind::Cylinder { p0, p1, .. } => {
                *p1 = beside(*p1);
                *p0 = middle;
            }
            ShapeKind::Triangle {
                corners: [first, second, third],
            } => {
                *second = beside(*second);
                *third = beside(*third);
                *first = middle;
            }
            _ => return None,
        }
        Some(moved)
    }

    /// Whether the shape has position parameters of its own, besides its transform.
    pub(crate) fn has_own_place(&self) -> bool {
        matches!(
            self.kind,
            ShapeKind::Sphere { .. } | ShapeKind::Cylinder { .. } | ShapeKind::Triangle { .. }
        )
    }

    /// The shape with the points of another one of its kind.
    pub(crate) fn placed_as(&self, other: &Self) -> Self {
        let mut placed = self.clone();
        match (&mut placed.kind, &other.kind) {
            (ShapeKind::Sphere { center, .. }, ShapeKind::Sphere { center: its, .. }) => *center = *its,
            (
                ShapeKind::Cylinder { p0, p1, .. },
                ShapeKind::Cylinder {
                    p0: first, p1: second, ..
                },
            ) => {
                (*p0, *p1) = (*first, *second);
            }
            (ShapeKind::Triangle { corners }, ShapeKind::Triangle { corners: its }) => *corners = *its,
            _ => {}
        }
        placed
    }

    /// The rest angles of the shape in a world with this upward direction, at which building parts stand upright. Its
    /// rotation is shown relative to them.
    pub(crate) fn rest_angles(&self, up: Vec3) -> Vec3 {
        match self.kind {
            ShapeKind::Solid(_) => upright_rest(up),
            _ => Vec3::ZERO,
        }
    }

    /// Whether it is made of curves, which cannot be lights.
    pub fn is_of_curves(&self) -> bool {
        matches!(&self.kind, ShapeKind::Mesh(file) if file.format.is_of_curves())
    }

    /// The scale of its lightmap: 0 for curves, whose tubes would have more texels than all rooms.
    pub(crate) fn scale_of_lightmap(&self) -> f32 {
        match self.is_of_curves() {
            true => 0.0,
            false => self.lightmap_scale,
        }
    }

    /// Whether it is the transform of a folder, which has no surface, material or light.
    pub(crate) fn is_frame(&self) -> bool {
        self.kind == ShapeKind::Frame
    }

    /// Whether v grows upwards, as seen from the side where u grows to the right. Pictures begin with their top row, so
    /// that they are upside down there.
    pub(crate) fn shows_pictures_upside_down(&self) -> bool {
        match &self.kind {
            ShapeKind::Rectangle | ShapeKind::Cylinder { .. } => true,
            // Programs that write such files let v grow upwards.
            ShapeKind::Mesh(file) => matches!(file.format, MeshFormat::Obj | MeshFormat::Ply) && !file.flip_tex_coords,
            // On these shapes v grows downwards, or around the centre. On curves it grows along them.
            ShapeKind::Sphere { .. }
            | ShapeKind::Cube
            | ShapeKind::Disk
            | ShapeKind::Triangle { .. }
            | ShapeKind::Solid(_)
            | ShapeKind::Instance
            | ShapeKind::Frame => false,
        }
    }
}

/// Rounds the points to a common unit, in which the largest coordinate has `digits` digits: beside 3, a coordinate of
/// 2.4e-7 becomes 0.
pub(crate) fn short_together<const N: usize>(points: [Vec3; N], digits: i32) -> [Vec3; N] {
    let largest = points
        .iter()
        .fold(0.0f32, |most, point| most.max(point.abs().max_element()));
    let unit = 10f64.powf(f64::from(largest).log10().floor()) * 10f64.powi(1 - digits);
    points.map(|point| {
        point.map(|number| {
            let multiple = (f64::from(number) / unit).round() * unit;
            // Adding zero makes -0 positive.
            if multiple.is_finite() {
                multiple as f32 + 0.0
            } else {
                number
            }
        })
    })
}

/// The kinds of shapes, by their plugins.
#[derive(Reflect, Clone, Debug, Default, PartialEq)]
pub enum ShapeKind {
    /// A sphere; `center` and `radius` are in local space.
    Sphere {
        /// The centre in local space.
        center: Vec3,
        /// The radius in local space, above 0.
        radius: f32,
    },
    /// The square [-1, 1]^2 in the local plane z = 0, its normal +z.
    #[default]
    Rectangle,
    /// The cube [-1, 1]^3.
    Cube,
    /// The unit disk in the local plane z = 0, its normal +z.
    Disk,
    /// One triangle, in local space; its front is the side from which its corners are counter-clockwise.
    Triangle {
        /// The corners in local space.
        corners: [Vec3; 3],
    },
    /// An open cylinder without caps, with the ends' centres in local space. The normals point outwards.
    Cylinder {
        /// The centre of the first end.
        p0: Vec3,
        /// The centre of the other end.
        p1: Vec3,
        /// The radius, above 0.
        radius: f32,
    },
    /// A wall, stairs, a prism or a roof.
    Solid(Solid),
    /// The triangles or the curves of a file.
    Mesh(MeshFile),
    /// The shapes of the group that `InstanceOf` names.
    Instance,
    /// Invisible: it holds the transform of a folder, and its name is that of the folder with a slash.
    Frame,
}

impl ShapeKind {
    /// Whether such a shape is flat: it encloses no volume at any size, so that both sides can be seen.
    pub(crate) fn is_flat(&self) -> bool {
        matches!(self, Self::Rectangle | Self::Disk | Self::Triangle { .. })
    }

    /// The names of all plugins except groups.
    pub const PLUGINS: [&'static str; 18] = [
        "sphere",
        "rectangle",
        "cube",
        "disk",
        "triangle",
        "cylinder",
        "wall",
        "stairs",
        "prism",
        "gableroof",
        "hiproof",
        "shedroof",
        "instance",
        "obj",
        "ply",
        "serialized",
        "bsplinecurve",
        "linearcurve",
    ];
}

/// A mesh in a file, or the curves of one.
#[derive(Reflect, Clone, Debug, Default, PartialEq)]
pub struct MeshFile {
    /// The absolute path.
    pub path: PathBuf,
    /// The format, given by the plugin that names the file, not by its extension.
    pub format: MeshFormat,
    /// The index of the shape in a serialized file, from 0.
    pub shape_index: u32,
    /// Whether to shade with geometric normals instead of vertex normals.
    pub face_normals: bool,
    /// Whether v is flipped. This is the default for OBJ, where v grows upwards.
    pub flip_tex_coords: bool,
}

declare_names! {
    /// The formats of mesh files, and of files of curves.
    #[derive(Reflect, Clone, Copy, Debug, Default, PartialEq, Eq)]
    pub enum MeshFormat {
        /// Wavefront OBJ, with materials of MTL libraries.
        #[default]
        Obj = "obj" => "OBJ mesh",
        /// PLY, as text or binary of either byte order.
        Ply = "ply" => "PLY mesh",
        /// Mitsuba's own format, with several shapes to a file.
        Serialized = "serialized" => "serialized mesh",
        /// Cubic B-splines with round cross-sections, as text with a control point in each line.
        BSplineCurve = "bsplinecurve" => "B-spline curves",
        /// Cones between spheres, from the same text.
        LinearCurve = "linearcurve" => "linear curves",
    }
}

impl MeshFormat {
    /// Whether the file has curves, which have neither vertex normals nor texture coordinates of their own.
    pub fn is_of_curves(self) -> bool {
        matches!(self, Self::BSplineCurve | Self::LinearCurve)
    }

    /// The default of `flip_tex_coords`.
    pub(crate) fn flips_tex_coords(self) -> bool {
        self == Self::Obj
    }
}
