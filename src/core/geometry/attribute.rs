//! Attributes of a mesh: one number or colour for each vertex or triangle.

use glam::Vec3;

use crate::color::linear_from_srgb8;

/// A named array of values. The prefix of its name, `vertex_` or `face_`, follows Mitsuba and need not match its
/// domain.
#[derive(Clone, Debug, PartialEq)]
pub struct MeshAttribute {
    /// The name by which textures refer to it, with its prefix.
    pub name: String,
    /// Whether vertices or triangles have the values.
    pub domain: AttributeDomain,
    /// The number of channels of a value: 1, or 3 for a colour.
    pub channels: usize,
    /// `channels` numbers for each vertex or triangle in turn.
    pub values: AttributeValues,
}

/// The mesh elements that have a value each.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum AttributeDomain {
    /// The vertices. Values are interpolated over each triangle.
    Vertex,
    /// The triangles. A polygon's value is repeated for each of its triangles.
    Triangle,
}

/// The values in their compact file format.
#[derive(Clone, Debug, PartialEq)]
pub enum AttributeValues {
    /// Bytes that stand for [0, 1], encoded as sRGB, which is how Mitsuba reads integers.
    Srgb8(Vec<u8>),
    /// Linear numbers, unchanged.
    F32(Vec<f32>),
}

impl AttributeValues {
    fn get(&self, i: usize) -> Option<f32> {
        match self {
            Self::Srgb8(values) => values.get(i).map(|&value| linear_from_srgb8(value)),
            Self::F32(values) => values.get(i).copied(),
        }
    }

    /// The number of values.
    pub(super) fn len(&self) -> usize {
        match self {
            Self::Srgb8(values) => values.len(),
            Self::F32(values) => values.len(),
        }
    }

    /// Memory held, in bytes.
    pub(super) fn heap_bytes(&self) -> usize {
        match self {
            Self::Srgb8(values) => values.capacity(),
            Self::F32(values) => 4 * values.capacity(),
        }
    }
}

impl MeshAttribute {
    /// The value on one of the mesh's `triangles`, interpolated with barycentric weights; a single channel gives a
    /// grey. Zero for indices outside the mesh.
    pub fn value(&self, triangles: &[[u32; 3]], triangle: u32, barycentric: Vec3) -> Vec3 {
        match self.domain {
            AttributeDomain::Triangle => self.element(triangle),
            AttributeDomain::Vertex => {
                let Some(&[a, b, c]) = triangles.get(triangle as usize) else {
                    return Vec3::ZERO;
                };
                barycentric.x * self.element(a) + barycentric.y * self.element(b) + barycentric.z * self.element(c)
            }
        }
    }

    fn element(&self, element: u32) -> Vec3 {
        let value = |channel| {
            self.values
                .get(self.channels * element as usize + channel)
                .unwrap_or(0.0)
        };
        match self.channels {
            1 => Vec3::splat(value(0)),
            _ => Vec3::new(value(0), value(1), value(2)),
        }
    }
}
