//! Points on emitting surfaces, hit by rays or chosen by sampling.

use glam::{Affine3A, Mat3A, Vec2, Vec3};

use super::reference::Reference;
use super::{LightSample, Target};
use crate::accel::{Hit, SurfacePoint};
use crate::math::{Real, Vector, offset_origin};

/// A surface point, in world space, with the data that a light's density needs.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SurfaceHit {
    /// The point on the surface.
    pub position: Vec3,
    /// Unit geometric normal.
    pub normal: Vec3,
    /// Unit shading normal, on the emitting side.
    pub shading_normal: Vec3,
    /// The mesh's triangle; zero for other shapes.
    pub primitive: u32,
    /// The weights of the triangle's corners 1 and 2; zero for other shapes.
    pub barycentric: Vec2,
    /// The surface coordinates, for textured light.
    pub uv: Vec2,
}

impl SurfaceHit {
    /// The surface point of a ray's hit.
    pub fn at(hit: &Hit, point: &SurfacePoint) -> Self {
        Self {
            position: point.position,
            normal: point.geometric_normal,
            shading_normal: point.shading_normal,
            primitive: hit.primitive,
            barycentric: Vec2::new(hit.u, hit.v),
            uv: point.uv,
        }
    }
}

/// A point chosen on an emitter, world space.
#[derive(Clone, Copy, Debug)]
pub(super) struct SurfaceSample<R: Real = f32> {
    pub position: R::Vec3,
    /// Unit normal of the surface, on the side of the reference point.
    pub normal: R::Vec3,
    /// Density per solid angle as seen from the reference point; zero where the point is invisible from there.
    pub pdf_solid_angle: R,
}

/// A point chosen on an emitter independently of any reference point, in world space.
#[derive(Clone, Copy, Debug)]
pub(super) struct AreaSample<R: Real = f32> {
    pub position: R::Vec3,
    /// Unit normal on the emitting side, or on either if both emit.
    pub normal: R::Vec3,
    /// Density per area.
    pub pdf_area: R,
}

impl<R: Real> AreaSample<R> {
    /// The sample with the normal on the side of `reference`, for a surface that emits on both sides.
    pub fn facing(self, reference: R::Vec3) -> Self {
        let is_behind = (reference - self.position).dot(self.normal).is_less(R::ZERO);
        Self {
            normal: R::Vec3::select(is_behind, -self.normal, self.normal),
            ..self
        }
    }

    /// The sample as seen from `reference`; the density is zero where the surface faces away or is seen edge-on.
    #[inline(always)]
    pub fn seen_from(self, reference: R::Vec3) -> SurfaceSample<R> {
        let Self {
            position,
            normal,
            pdf_area,
        } = self;
        let is_before = (reference - position).dot(normal).is_more(R::ZERO);
        let pdf = solid_angle_pdf(pdf_area, position, normal, reference);
        SurfaceSample {
            position,
            normal,
            pdf_solid_angle: pdf.only(is_before & pdf.is_less(R::splat(f32::INFINITY))),
        }
    }
}

impl<R: Real> SurfaceSample<R> {
    /// Calls `sample` for each reference and pair of numbers in turn, where `asked` is set.
    #[inline(always)]
    pub fn each(from: &Reference<R>, [u, v]: [R; 2], sample: impl Fn(Vec3, Vec2) -> Option<SurfaceSample>) -> Self {
        let place = from.position;
        let numbers = [place.x(), place.y(), place.z(), u, v];
        let [x, y, z, normal_x, normal_y, normal_z, pdf] = R::each(from.asked, numbers, |[x, y, z, u, v]| {
            sample(Vec3::new(x, y, z), Vec2::new(u, v)).map_or([0.0; 7], |sample| {
                let (place, normal) = (sample.position, sample.normal);
                [
                    place.x,
                    place.y,
                    place.z,
                    normal.x,
                    normal.y,
                    normal.z,
                    sample.pdf_solid_angle,
                ]
            })
        });
        Self {
            position: R::Vec3::of(x, y, z),
            normal: R::Vec3::of(normal_x, normal_y, normal_z),
            pdf_solid_angle: pdf,
        }
    }

    /// Selects `yes` where `condition` holds, else `no`.
    #[inline(always)]
    pub fn select(condition: R::Mask, yes: Self, no: Self) -> Self {
        Self {
            position: R::Vec3::select(condition, yes.position, no.position),
            normal: R::Vec3::select(condition, yes.normal, no.normal),
            pdf_solid_angle: R::select(condition, yes.pdf_solid_angle, no.pdf_solid_angle),
        }
    }

    /// The direction from `reference` to the point, with the radiance from there. `error` bounds the error of the
    /// point's coordinates.
    #[inline(always)]
    pub fn towards(self, reference: R::Vec3, error: R, radiance: R::Vec3) -> LightSample<R> {
        let to_point = self.position - reference;
        let distance_squared = to_point.length_squared();
        let is_apart = R::is_above(distance_squared, 0.0) & distance_squared.is_less(R::splat(f32::INFINITY));
        // The shadow ray ends in front of the surface, not on it.
        let end = offset_origin(self.position, error, self.normal, -to_point);
        LightSample {
            wi: to_point.normalize(),
            target: Target::Point(end),
            radiance,
            pdf: self.pdf_solid_angle.only(is_apart),
            is_delta: false,
        }
    }
}

/// The images of the three axes.
#[inline(always)]
pub(super) fn axes(map: &Affine3A) -> [Vec3; 3] {
    let Mat3A { x_axis, y_axis, z_axis } = map.matrix3;
    [x_axis, y_axis, z_axis].map(Vec3::from)
}

/// Density per area to density per solid angle at `reference`: times distance squared over the cosine; infinite
/// edge-on.
#[inline(always)]
pub(super) fn solid_angle_pdf<R: Real>(pdf_area: R, position: R::Vec3, normal: R::Vec3, reference: R::Vec3) -> R {
    let to_reference = reference - position;
    let distance_squared = to_reference.length_squared();
    let cos = to_reference.dot(normal).abs() / distance_squared.sqrt();
    pdf_area * distance_squared / cos
}
