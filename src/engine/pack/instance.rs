//! Shapes placed in the world.

use bevy::math::{Affine3A, Mat3};
use bevy::prelude::*;

use super::super::blas_cache::BuiltMesh;
use crate::accel::{Instance, Primitive};
use crate::light::Portal;
use crate::math::Frame;
use crate::scene::assets::solid_mesh::openings_of;
use crate::scene::{DocumentOrder, Shape, ShapeKind};

/// A shape of the scene whose geometry is available: the data of its [`Instance`], and those of its surface.
#[derive(Clone, Debug)]
pub(in crate::engine) struct InstanceRecord {
    pub order: DocumentOrder,
    pub entity: Entity,
    /// The material; None for a shape without one.
    pub material: Option<Entity>,
    /// Whether it has an area light.
    pub has_light: bool,
    /// The media on its inner and its outer side.
    pub media: [Option<Entity>; 2],
    pub primitive: Primitive,
    world_from_local: Affine3A,
    face_normals: bool,
    flip_normals: bool,
    /// The number of material slots of its mesh; 1 for other shapes.
    pub slots: u32,
    /// The openings of a wall, or the rectangle itself if it is a portal; in the space of the shape's transform.
    pub portals: Box<[Portal]>,
}

/// The components from which a shape is packed.
#[derive(Clone, Copy)]
pub(in crate::engine) struct ShapeSource<'a> {
    pub order: DocumentOrder,
    pub entity: Entity,
    pub shape: &'a Shape,
    pub to_world: Affine3A,
    pub material: Option<Entity>,
    pub has_light: bool,
    pub media: [Option<Entity>; 2],
}

impl InstanceRecord {
    /// The sort key among all shapes.
    pub fn key(&self) -> (DocumentOrder, Entity) {
        (self.order, self.entity)
    }

    /// Whether both have the same mesh, or are the same shape otherwise.
    pub fn is_of_same_mesh(&self, other: &Self) -> bool {
        self.primitive.is_same(&other.primitive)
    }

    /// Whether rays meet the same surface (the transform's inverse follows from the transform).
    pub fn same_geometry(&self, other: &Self) -> bool {
        self.primitive.is_same(&other.primitive)
            && self.world_from_local == other.world_from_local
            && self.face_normals == other.face_normals
            && self.flip_normals == other.flip_normals
            && self.slots == other.slots
    }
}

/// The reason why a shape has no extent or no valid transform.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub(in crate::engine) enum ShapeError {
    #[error("a sphere of radius {radius} is left out")]
    Sphere { radius: f32 },
    #[error("a cylinder of radius {radius} and length {length} is left out")]
    Cylinder { radius: f32, length: f32 },
    #[error("a triangle without an area is left out")]
    Triangle,
    #[error("its transform cannot be inverted, the shape is left out")]
    Transform,
}

/// Packs a shape; None while its mesh is not available. `mesh` is the mesh that the shape's kind names, if any.
pub(in crate::engine) fn pack_instance(
    source: &ShapeSource,
    mesh: Option<&BuiltMesh>,
) -> Result<Option<(Instance, InstanceRecord)>, ShapeError> {
    let ShapeSource { shape, to_world, .. } = *source;
    let mesh_primitive = || mesh.map(|mesh| mesh.primitive.clone());
    let (primitive, world_from_local, face_normals) = match &shape.kind {
        ShapeKind::Sphere { center, radius } => {
            if radius.is_nan() || *radius <= 0.0 {
                return Err(ShapeError::Sphere { radius: *radius });
            }
            let scale = Affine3A::from_scale(Vec3::splat(*radius));
            let world_from_unit = to_world * Affine3A::from_translation(*center) * scale;
            (Some(Primitive::Sphere), world_from_unit, false)
        }
        ShapeKind::Rectangle => (Some(Primitive::Rectangle), to_world, false),
        ShapeKind::Disk => (Some(Primitive::Disk), to_world, false),
        ShapeKind::Cylinder { p0, p1, radius } => {
            let axis = *p1 - *p0;
            let (length, direction) = (axis.length(), axis.try_normalize());
            let (Some(direction), true) = (direction, *radius > 0.0) else {
                let radius = *radius;
                return Err(ShapeError::Cylinder { radius, length });
            };
            // The zero of the angle is also Mitsuba's.
            let Frame { s, t, n } = Frame::from_normal(direction);
            let axes = Mat3::from_cols(s * *radius, t * *radius, n * length);
            (
                Some(Primitive::Cylinder),
                to_world * Affine3A::from_mat3_translation(axes, *p0),
                false,
            )
        }
        // These kinds are not shapes of their own.
        ShapeKind::Instance | ShapeKind::Frame => return Ok(None),
        ShapeKind::Cube | ShapeKind::Solid(_) => (mesh_primitive(), to_world, false),
        ShapeKind::Triangle { corners: [a, b, c] } => {
            let (u, v) = (*b - *a, *c - *a);
            let Some(normal) = u.cross(v).try_normalize() else {
                return Err(ShapeError::Triangle);
            };
            let local_from_unit = Affine3A::from_mat3_translation(Mat3::from_cols(u, v, normal), *a);
            (mesh_primitive(), to_world * local_from_unit, true)
        }
        ShapeKind::Mesh(file) => {
            // The control points of curves have this part of the transform already.
            let stretch = mesh.map_or(Mat3::IDENTITY, |mesh| mesh.stretch);
            let world_from_local = match stretch == Mat3::IDENTITY {
                true => to_world,
                false => to_world * Affine3A::from_mat3(stretch.inverse()),
            };
            (mesh_primitive(), world_from_local, file.face_normals)
        }
    };
    let Some(primitive) = primitive else {
        return Ok(None);
    };
    let Some(mut instance) = Instance::new(primitive, world_from_local) else {
        return Err(ShapeError::Transform);
    };
    instance.face_normals = face_normals;
    instance.flip_normals = shape.flip_normals;
    let record = InstanceRecord {
        order: source.order,
        entity: source.entity,
        material: source.material,
        has_light: source.has_light,
        media: source.media,
        primitive: instance.primitive.clone(),
        world_from_local: instance.world_from_local,
        face_normals,
        flip_normals: shape.flip_normals,
        slots: mesh.map_or(1, |mesh| mesh.slots),
        portals: portals_of(shape, to_world),
    };
    Ok(Some((instance, record)))
}

/// The places of a shape through which light may come in.
fn portals_of(shape: &Shape, to_world: Affine3A) -> Box<[Portal]> {
    match &shape.kind {
        ShapeKind::Solid(part) => openings_of(part)
            .into_iter()
            .map(|(corner, edges)| Portal {
                corner: to_world.transform_point3(corner),
                edges: edges.map(|edge| to_world.transform_vector3(edge)),
            })
            .collect(),
        ShapeKind::Rectangle if shape.portal => {
            let portal = Portal {
                corner: to_world.transform_point3(Vec3::new(-1.0, -1.0, 0.0)),
                edges: [Vec3::X, Vec3::Y].map(|half| to_world.transform_vector3(2.0 * half)),
            };
            Box::new([portal])
        }
        ShapeKind::Rectangle
        | ShapeKind::Sphere { .. }
        | ShapeKind::Cube
        | ShapeKind::Disk
        | ShapeKind::Triangle { .. }
        | ShapeKind::Cylinder { .. }
        | ShapeKind::Mesh(_)
        | ShapeKind::Instance
        | ShapeKind::Frame => Box::default(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn pack(shape: &Shape, to_world: Affine3A) -> Result<Instance, ShapeError> {
        let source = ShapeSource {
            order: DocumentOrder(0),
            entity: Entity::PLACEHOLDER,
            shape,
            to_world,
            material: None,
            has_light: false,
            media: [None; 2],
        };
        let packed = pack_instance(&source, None)?;
        Ok(packed.expect("it needs no mesh").0)
    }

    fn sphere(center: Vec3, radius: f32) -> Shape {
        Shape {
            kind: ShapeKind::Sphere { center, radius },
            ..Shape::default()
        }
    }

    fn cylinder(p0: Vec3, p1: Vec3, radius: f32) -> Shape {
        Shape {
            kind: ShapeKind::Cylinder { p0, p1, radius },
            ..Shape::default()
        }
    }

    #[test]
    fn a_cylinders_ends_and_radius_go_into_its_transform() {
        let (p0, p1) = (Vec3::new(1.0, 2.0, 3.0), Vec3::new(-4.0, 0.5, 7.0));
        let packed = pack(&cylinder(p0, p1, 2.0), Affine3A::IDENTITY);
        let map = packed.expect("a good cylinder").world_from_local;
        // Rounding of numbers up to 10, a few times.
        assert!(map.transform_point3(Vec3::ZERO).abs_diff_eq(p0, 1e-5));
        assert!(map.transform_point3(Vec3::Z).abs_diff_eq(p1, 1e-5));
        for around in [Vec3::X, Vec3::Y] {
            let radius = map.transform_vector3(around);
            assert!((radius.length() - 2.0).abs() < 1e-5 && radius.dot(p1 - p0).abs() < 1e-5);
        }
        assert!(map.matrix3.determinant() > 0.0);
    }

    #[test]
    fn a_spheres_center_and_radius_go_into_its_transform() {
        let to_world = Affine3A::from_rotation_z(0.5) * Affine3A::from_scale(Vec3::new(1.0, 2.0, 3.0));
        let center = Vec3::new(4.0, 5.0, 6.0);
        let packed = pack(&sphere(center, 7.0), to_world);
        let world_from_unit = packed.expect("a good sphere").world_from_local;
        let expected = to_world.transform_point3(center + 7.0 * Vec3::Y);
        // Two products of numbers up to 60 with rounding 2^-24 each.
        assert!(world_from_unit.transform_point3(Vec3::Y).abs_diff_eq(expected, 1e-4));
    }

    #[test]
    fn what_has_no_extent_is_left_out_and_reported() {
        let flat = Affine3A::from_scale(Vec3::new(1.0, 1.0, 0.0));
        let nowhere = Affine3A::from_translation(Vec3::NAN);
        let good = sphere(Vec3::ZERO, 1.0);
        let cases = [
            (sphere(Vec3::ZERO, 0.0), Affine3A::IDENTITY),
            (sphere(Vec3::ZERO, f32::NAN), Affine3A::IDENTITY),
            (sphere(Vec3::NAN, 1.0), Affine3A::IDENTITY),
            (cylinder(Vec3::ONE, Vec3::ONE, 1.0), Affine3A::IDENTITY),
            (cylinder(Vec3::ZERO, Vec3::ONE, -1.0), Affine3A::IDENTITY),
            (good.clone(), flat),
            (good, nowhere),
        ];
        for (shape, to_world) in cases {
            let error = pack(&shape, to_world).expect_err("it has no extent or no place");
            assert!(
                error.to_string().ends_with("left out"),
                "{shape:?} {to_world:?} {error}"
            );
        }
    }
}
