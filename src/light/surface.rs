//! A surface that emits: dispatch over the shapes, each with its own way of choosing a point or a direction.

use std::f32::consts::PI;

use glam::{Affine3A, Vec2, Vec3};

use super::bounds::{LightBounds, NormalCone};
use super::cylinder::CylinderLight;
use super::rectangle::RectangleLight;
use super::sphere::{EllipsoidLight, SphereLight};
use super::triangle::TriangleLight;
use super::{LightSample, Target};
use crate::accel::{Primitive, Tlas};
use crate::color::{Rgb, luminance};
use crate::math::{Aabb, offset_origin};
use crate::sampling::warp;

/// A place on a surface as the density of a light needs it, world space.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SurfaceHit {
    pub position: Vec3,
    /// Unit geometric normal.
    pub normal: Vec3,
    /// The mesh's triangle; zero for other shapes.
    pub primitive: u32,
}

/// A point chosen on an emitter, world space.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct SurfaceSample {
    pub position: Vec3,
    /// Unit geometric normal, to the emitting side.
    pub normal: Vec3,
    /// Density per solid angle as seen from the reference point.
    pub pdf_solid_angle: f32,
}

#[derive(Clone, Debug)]
pub(super) struct SurfaceLight {
    radiance: Rgb,
    shape: EmitterShape,
    /// Of the whole instance.
    bounds: Aabb,
    /// Bound on the rounding error of its points.
    error: f32,
}

#[derive(Clone, Debug)]
enum EmitterShape {
    Rectangle(RectangleLight),
    Disk(DiskLight),
    Cylinder(CylinderLight),
    Sphere(SphereLight),
    Ellipsoid(EllipsoidLight),
    /// In the order of the mesh.
    Mesh(Vec<TriangleLight>),
}

#[derive(Clone, Debug)]
struct DiskLight {
    world_from_local: Affine3A,
    normal: Vec3,
    area: f32,
}

/// Relative rounding error allowed for a point on an emitter: a few roundings of its largest coordinate.
const POSITION_ROUNDING: f32 = 16.0 * f32::EPSILON;

impl SurfaceLight {
    /// None if there is no such instance.
    pub fn new(geometry: &Tlas, instance: u32, slot: u32, radiance: Rgb) -> Option<Self> {
        let instance = geometry.instances().get(instance as usize)?;
        let to_world = instance.world_from_local;
        let side = if instance.flip_normals { -1.0 } else { 1.0 };
        // Normals go by the inverse transpose; its sign is that of the local normal even under a mirroring.
        let plane_normal = || {
            let normal = instance.local_from_world.matrix3.transpose() * glam::Vec3A::Z;
            side * Vec3::from(normal).normalize_or_zero()
        };
        let [x, y] = [to_world.matrix3.x_axis, to_world.matrix3.y_axis].map(Vec3::from);
        let shape = match &instance.primitive {
            Primitive::Rectangle => {
                let corner = Vec3::from(to_world.translation) - x - y;
                EmitterShape::Rectangle(RectangleLight::new(corner, 2.0 * x, 2.0 * y, plane_normal()))
            }
            Primitive::Disk => EmitterShape::Disk(DiskLight {
                world_from_local: to_world,
                normal: plane_normal(),
                area: PI * x.cross(y).length(),
            }),
            Primitive::Sphere => match SphereLight::new(&to_world, side) {
                Some(light) => EmitterShape::Sphere(light),
                None => EmitterShape::Ellipsoid(EllipsoidLight::new(to_world, instance.local_from_world, side)),
            },
            Primitive::Cylinder => {
                EmitterShape::Cylinder(CylinderLight::new(to_world, instance.local_from_world, side))
            }
            Primitive::Mesh(blas) => EmitterShape::Mesh(TriangleLight::of_mesh(blas.mesh(), slot, &to_world, side)),
        };
        let bounds = instance.world_bounds();
        let reach = bounds.min.abs().max(bounds.max.abs()).max_element();
        Some(Self {
            radiance,
            shape,
            bounds,
            error: POSITION_ROUNDING * reach,
        })
    }

    /// A mesh has one per triangle.
    pub fn parts(&self) -> u32 {
        match &self.shape {
            EmitterShape::Mesh(triangles) => triangles.len() as u32,
            _ => 1,
        }
    }

    /// The part that `hit`, a point of this surface, lies on.
    pub fn part_of(&self, hit: &SurfaceHit) -> Option<u32> {
        match &self.shape {
            EmitterShape::Mesh(triangles) => {
                let found = triangles.binary_search_by_key(&hit.primitive, |triangle| triangle.primitive);
                found.ok().map(|part| part as u32)
            }
            _ => Some(0),
        }
    }

    pub fn bounds(&self, part: u32) -> LightBounds {
        let (bounds, cone, seen_area) = match &self.shape {
            EmitterShape::Rectangle(light) => (light.bounds(), NormalCone::single(light.normal()), light.area()),
            EmitterShape::Disk(light) => (self.bounds, NormalCone::single(light.normal), light.area),
            // A surface seen from one side shows a quarter of its area, on average over all directions.
            EmitterShape::Sphere(light) => (self.bounds, NormalCone::ALL, 0.25 * light.area()),
            EmitterShape::Ellipsoid(light) => (self.bounds, NormalCone::ALL, 0.25 * light.area()),
            EmitterShape::Cylinder(light) => (self.bounds, NormalCone::ALL, 0.25 * light.area()),
            EmitterShape::Mesh(triangles) => {
                let triangle = &triangles[part as usize];
                (triangle.bounds(), triangle.normals(), triangle.area())
            }
        };
        LightBounds {
            bounds,
            cone,
            cos_emission: 0.0,
            intensity: seen_area * luminance(self.radiance),
        }
    }

    /// Radiance sent to the front from a point of this surface.
    pub fn radiance(&self, _hit: &SurfaceHit) -> Rgb {
        self.radiance
    }

    /// A direction to a part; None where no light can come from (the back, the horizon).
    pub fn sample(&self, part: u32, reference: Vec3, u: Vec2) -> Option<LightSample> {
        let point = self.sample_point(part, reference, u)?;
        let hit = SurfaceHit {
            position: point.position,
            normal: point.normal,
            primitive: self.primitive(part),
        };
        // The shadow ray ends in front of the surface, not on it.
        let end = offset_origin(point.position, self.error, point.normal, reference - point.position);
        Some(LightSample {
            wi: (point.position - reference).try_normalize()?,
            target: Target::Point(end),
            radiance: self.radiance(&hit),
            pdf: point.pdf_solid_angle,
            is_delta: false,
        })
    }

    fn primitive(&self, part: u32) -> u32 {
        match &self.shape {
            EmitterShape::Mesh(triangles) => triangles[part as usize].primitive,
            _ => 0,
        }
    }

    fn sample_point(&self, part: u32, reference: Vec3, u: Vec2) -> Option<SurfaceSample> {
        match &self.shape {
            EmitterShape::Rectangle(light) => light.sample(reference, u),
            EmitterShape::Disk(light) => {
                let p = warp::concentric_disk(u);
                let position = light.world_from_local.transform_point3(p.extend(0.0));
                SurfaceSample::from_area(position, light.normal, 1.0 / light.area, reference)
            }
            EmitterShape::Cylinder(light) => light.sample(reference, u),
            EmitterShape::Sphere(light) => light.sample(reference, u),
            EmitterShape::Ellipsoid(light) => light.sample(reference, u),
            EmitterShape::Mesh(triangles) => triangles[part as usize].sample(reference, u),
        }
    }

    /// Density per solid angle of [`Self::sample`] at a point of the part.
    pub fn pdf(&self, part: u32, reference: Vec3, hit: &SurfaceHit) -> f32 {
        match &self.shape {
            EmitterShape::Rectangle(light) => light.pdf(reference, hit),
            EmitterShape::Disk(light) => solid_angle_pdf(1.0 / light.area, hit.position, hit.normal, reference),
            EmitterShape::Cylinder(light) => light.pdf(reference, hit),
            EmitterShape::Sphere(light) => light.pdf(reference, hit),
            EmitterShape::Ellipsoid(light) => light.pdf(reference, hit),
            EmitterShape::Mesh(triangles) => triangles[part as usize].pdf(reference, hit),
        }
    }
}

impl SurfaceSample {
    /// From a density per area; None if the point shows its back or its edge.
    pub fn from_area(position: Vec3, normal: Vec3, pdf_area: f32, reference: Vec3) -> Option<Self> {
        if (reference - position).dot(normal) <= 0.0 {
            return None;
        }
        let pdf_solid_angle = solid_angle_pdf(pdf_area, position, normal, reference);
        (pdf_solid_angle > 0.0 && pdf_solid_angle.is_finite()).then_some(Self {
            position,
            normal,
            pdf_solid_angle,
        })
    }
}

/// Density per area to density per solid angle at `reference`: times distance squared over the cosine; infinite edge-on.
pub(super) fn solid_angle_pdf(pdf_area: f32, position: Vec3, normal: Vec3, reference: Vec3) -> f32 {
    let to_reference = reference - position;
    let distance_squared = to_reference.length_squared();
    let cos = to_reference.dot(normal).abs() / distance_squared.sqrt();
    pdf_area * distance_squared / cos
}
