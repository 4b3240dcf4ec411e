//! Shapes as the user knows them.

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
    /// Turns the normals over: the side that emits and, for one-sided materials, the side that is seen.
    pub flip_normals: bool,
    /// How many times as many texels of a lightmap lie along a length of it as on other shapes, in
    /// [`Self::LIGHTMAP_SCALES`]; 0: it has none.
    pub lightmap_scale: f32,
}

impl Default for Shape {
    fn default() -> Self {
        Self {
            kind: ShapeKind::default(),
            flip_normals: false,
            lightmap_scale: 1.0,
        }
    }
}

impl Shape {
    /// The range of [`lightmap_scale`](Self::lightmap_scale).
    pub const LIGHTMAP_SCALES: std::ops::RangeInclusive<f32> = 0.0..=100.0;

    /// The place of the shape in its own space, as users know it: the centre of a sphere, the first end of a cylinder,
    /// the first corner of a triangle, the origin for others.
    pub fn middle(&self) -> Vec3 {
        match self.kind {
            ShapeKind::Sphere { center, .. } => center,
            ShapeKind::Cylinder { p0, .. } => p0,
            ShapeKind::Triangle { corners } => corners[0],
            _ => Vec3::ZERO,
        }
    }

    /// The shape with its [`middle`](Self::middle) elsewhere in its own space. None for shapes that are at the origin
    /// of that.
    pub(crate) fn moved_to(&self, middle: Vec3) -> Option<Self> {
        let mut moved = self.clone();
        let by = middle.as_dvec3() - self.middle().as_dvec3();
        // The sum of numbers of few digits has few digits.
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

    /// Whether the shape is placed by numbers of its own, and not by its transform alone.
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

    /// The angles at which the shape is at rest in a world with this upward direction: building parts stand upright
    /// then. Its rotation is shown from there.
    pub(crate) fn rest_angles(&self, up: Vec3) -> Vec3 {
        match self.kind {
            ShapeKind::Solid(_) => upright_rest(up),
            _ => Vec3::ZERO,
        }
    }

    /// Whether it is the transform of a folder, which has no surface, material or light.
    pub(crate) fn is_frame(&self) -> bool {
        self.kind == ShapeKind::Frame
    }

    /// Whether v grows from the bottom up, as seen from the side where u grows to the right. Pictures begin with their
    /// uppermost row, so that they are upside down there.
    pub(crate) fn shows_pictures_upside_down(&self) -> bool {
        match &self.kind {
            ShapeKind::Rectangle | ShapeKind::Cylinder { .. } => true,
            // Programs that write such files count v from the bottom up.
            ShapeKind::Mesh(file) => file.format != MeshFormat::Serialized && !file.flip_tex_coords,
            // On these shapes v grows downwards, or around the middle.
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

/// Rounds the points to a unit that gives the largest of all coordinates `digits` digits: beside 3, a coordinate of
/// 2.4e-7 becomes 0.
pub(crate) fn short_together<const N: usize>(points: [Vec3; N], digits: i32) -> [Vec3; N] {
    let largest = points
        .iter()
        .fold(0.0f32, |most, point| most.max(point.abs().max_element()));
    let unit = 10f64.powf(f64::from(largest).log10().floor()) * 10f64.powi(1 - digits);
    points.map(|point| {
        point.map(|number| {
            let multiple = (f64::from(number) / unit).round() * unit;
            // Adding zero turns -0 into 0.
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
    /// One triangle, in local space; its front is where its corners run counter-clockwise.
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
    /// A wall, stairs or a prism.
    Solid(Solid),
    /// The triangles of a file.
    Mesh(MeshFile),
    /// The shapes of the group that `InstanceOf` names.
    Instance,
    /// It is invisible: it holds the transform of a folder, and its name is that of the folder with a slash behind it.
    Frame,
}

impl ShapeKind {
    /// Whether a shape of this kind encloses nothing, whatever its size: both sides of its surface can be seen.
    pub(crate) fn is_flat(&self) -> bool {
        matches!(self, Self::Rectangle | Self::Disk | Self::Triangle { .. })
    }

    /// The names of all plugins, groups apart.
    pub const PLUGINS: [&'static str; 13] = [
        "sphere",
        "rectangle",
        "cube",
        "disk",
        "triangle",
        "cylinder",
        "wall",
        "stairs",
        "prism",
        "instance",
        "obj",
        "ply",
        "serialized",
    ];
}

/// A mesh by its file.
#[derive(Reflect, Clone, Debug, Default, PartialEq)]
pub struct MeshFile {
    /// The absolute path.
    pub path: PathBuf,
    /// The format, by the plugin that names the file, not by its extension.
    pub format: MeshFormat,
    /// The index of the shape in a serialized file, from 0.
    pub shape_index: u32,
    /// Whether to shade with the triangles' own normals, not the vertices'.
    pub face_normals: bool,
    /// Turns the file's v upside down. Unless the scene says otherwise so for OBJ, where v counts from the bottom up.
    pub flip_tex_coords: bool,
}

declare_names! {
    /// The formats of mesh files.
    #[derive(Reflect, Clone, Copy, Debug, Default, PartialEq, Eq)]
    pub enum MeshFormat {
        /// Wavefront OBJ, with materials of MTL libraries.
        #[default]
        Obj = "obj" => "OBJ mesh",
        /// PLY, as text or binary of either byte order.
        Ply = "ply" => "PLY mesh",
        /// Mitsuba's own format, with several shapes to a file.
        Serialized = "serialized" => "serialized mesh",
    }
}

impl MeshFormat {
    /// The value of `flip_tex_coords` where the scene does not give it.
    pub(crate) fn flips_tex_coords(self) -> bool {
        self == Self::Obj
    }
}
