//! A surface that emits: dispatch over the shapes, each with its own way of choosing a point or a direction.

use glam::{Affine3A, Vec2, Vec3};

use super::mesh::MeshLight;
use super::rectangle::RectangleLight;
use super::sphere::{EllipsoidLight, SphereLight};
use crate::accel::{Primitive, Tlas};
use crate::color::Rgb;
use crate::math::offset_origin;
use crate::sampling::warp;

/// A place on a surface as the density of a light needs it, world space.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SurfaceHit {
    pub position: Vec3,
    /// Unit geometric normal.
    pub normal: Vec3,
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
    pub radiance: Rgb,
    pub area: f32,
    shape: EmitterShape,
    /// Bound on the rounding error of its points.
    error: f32,
}

#[derive(Clone, Debug)]
enum EmitterShape {
    Rectangle(RectangleLight),
    Disk(DiskLight),
    Sphere(SphereLight),
    Ellipsoid(EllipsoidLight),
    Mesh(MeshLight),
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
    /// None when the surface has no area.
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
        let parallelogram = x.cross(y).length();
        let (shape, area) = match &instance.primitive {
            Primitive::Rectangle => {
                let light = RectangleLight::new(
                    Vec3::from(to_world.translation) - x - y,
                    2.0 * x,
                    2.0 * y,
                    plane_normal(),
                );
                (EmitterShape::Rectangle(light), 4.0 * parallelogram)
            }
            Primitive::Disk => {
                let area = std::f32::consts::PI * parallelogram;
                let light = DiskLight {
                    world_from_local: to_world,
                    normal: plane_normal(),
                    area,
                };
                (EmitterShape::Disk(light), area)
            }
            Primitive::Sphere => match SphereLight::new(&to_world, side) {
                Some(light) => (EmitterShape::Sphere(light), light.area()),
                None => {
                    let light = EllipsoidLight::new(to_world, instance.local_from_world, side);
                    (EmitterShape::Ellipsoid(light), light.area())
                }
            },
            Primitive::Mesh(blas) => {
                let light = MeshLight::new(blas.mesh(), slot, &to_world, side)?;
                let area = light.area();
                (EmitterShape::Mesh(light), area)
            }
        };
        let bounds = instance.world_bounds();
        let reach = bounds.min.abs().max(bounds.max.abs()).max_element();
        (area > 0.0 && area.is_finite()).then_some(Self {
            radiance,
            area,
            shape,
            error: POSITION_ROUNDING * reach,
        })
    }

    /// A point as seen from `reference`; None where no light can come from (the back, the horizon).
    pub fn sample(&self, reference: Vec3, u: Vec2) -> Option<SurfaceSample> {
        match &self.shape {
            EmitterShape::Rectangle(light) => light.sample(reference, u),
            EmitterShape::Disk(light) => {
                let p = warp::concentric_disk(u);
                let position = light.world_from_local.transform_point3(p.extend(0.0));
                SurfaceSample::from_area(position, light.normal, 1.0 / light.area, reference)
            }
            EmitterShape::Sphere(light) => light.sample(reference, u),
            EmitterShape::Ellipsoid(light) => light.sample(reference, u),
            EmitterShape::Mesh(light) => light.sample(reference, u),
        }
    }

    /// Density per solid angle of [`Self::sample`] at a point of this surface.
    pub fn pdf(&self, reference: Vec3, hit: &SurfaceHit) -> f32 {
        match &self.shape {
            EmitterShape::Rectangle(light) => light.pdf(reference, hit),
            EmitterShape::Disk(light) => solid_angle_pdf(1.0 / light.area, hit.position, hit.normal, reference),
            EmitterShape::Sphere(light) => light.pdf(reference, hit),
            EmitterShape::Ellipsoid(light) => light.pdf(reference, hit),
            EmitterShape::Mesh(light) => solid_angle_pdf(1.0 / light.area(), hit.position, hit.normal, reference),
        }
    }

    /// The end of a shadow ray from `reference` to a sampled point: moved off the surface towards it.
    pub fn shadow_target(&self, sample: &SurfaceSample, reference: Vec3) -> Vec3 {
        offset_origin(sample.position, self.error, sample.normal, reference - sample.position)
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
