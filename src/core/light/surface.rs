//! A surface that emits: dispatch over the shapes, each with its own sampling.

use std::f32::consts::PI;
use std::sync::Arc;

use glam::{Affine3A, Vec2, Vec3};

use super::bounds::{LightBounds, NormalCone};
use super::cylinder::CylinderLight;
use super::hit::{AreaSample, SurfaceHit, SurfaceSample, axes, solid_angle_pdf};
use super::plain::{Glow, PlainSurface};
use super::rectangle::RectangleLight;
use super::reference::Reference;
use super::sphere::{EllipsoidLight, SphereLight};
use super::texture_density::{self, mean_luminance};
use super::triangle::TriangleLight;
use super::{LightReference, LightSample};
use crate::accel::{Blas, Instance, Primitive, Tlas};
use crate::color::{Rgb, luminance};
use crate::geometry::mesh::MeshData;
use crate::geometry::{cylinder, disk, rectangle, sphere};
use crate::math::{Aabb, Mask, Real, Same, Vector, offset_origin};
use crate::sampling::warp;
use crate::texture::{MeshPoint, Parameter, TexturePoint, TextureTable};

#[derive(Clone, Debug)]
pub(super) struct SurfaceLight {
    radiance: Parameter<Rgb>,
    /// Whether the back emits as the front does.
    shines_both_ways: bool,
    /// Average luminance of the radiance: one value for the whole surface, or one per part.
    brightness: Vec<f32>,
    shape: EmitterShape,
    /// The bounds of the whole instance.
    bounds: Aabb,
    mesh: Option<Arc<MeshData>>,
    /// The placed shape, if it is a mesh of which some triangles emit on the side of their shading normals.
    smooth: Option<Box<Instance>>,
    local_from_world: Affine3A,
    /// The bound on the rounding error of its points.
    error: f32,
}

#[derive(Clone, Debug)]
enum EmitterShape {
    Rectangle(RectangleLight),
    Disk(DiskLight),
    Cylinder(CylinderLight),
    Sphere(SphereLight),
    Ellipsoid(EllipsoidLight),
    /// The triangles in the order of the mesh.
    Mesh(Vec<TriangleLight>),
}

#[derive(Clone, Debug)]
struct DiskLight {
    world_from_local: Affine3A,
    normal: Vec3,
    area: f32,
}

impl DiskLight {
    /// A point that is uniform in area.
    #[inline(always)]
    fn sample_area<R: Real>(&self, u: [R; 2]) -> AreaSample<R> {
        let [x, y] = warp::concentric_disk(u);
        AreaSample {
            position: R::Vec3::same(self.world_from_local.translation.into())
                + R::Vec3::of(x, y, R::ZERO).along(axes(&self.world_from_local)),
            normal: R::Vec3::same(self.normal),
            pdf_area: R::splat(1.0 / self.area),
        }
    }
}

/// Relative rounding error allowed for a point on an emitter: a few roundings of its largest coordinate.
const POSITION_ROUNDING: f32 = 16.0 * f32::EPSILON;

/// The least brightness of a triangle of a textured mesh, relative to the average.
const LEAST_BRIGHTNESS: f32 = 0.1;

impl SurfaceLight {
    /// The light of a slot of an instance; None if there is no such instance.
    pub fn new(
        geometry: &Tlas,
        (instance, slot): (u32, u32),
        radiance: Parameter<Rgb>,
        shines_both_ways: bool,
        textures: &TextureTable,
    ) -> Option<Self> {
        let instance = geometry.instances().get(instance as usize)?;
        let to_world = instance.world_from_local;
        let side = if instance.flip_normals { -1.0 } else { 1.0 };
        let plane_normal = side * instance.plane_normal;
        let [x, y] = [to_world.matrix3.x_axis, to_world.matrix3.y_axis].map(Vec3::from);
        let shape = match &instance.primitive {
            Primitive::Rectangle => {
                let corner = Vec3::from(to_world.translation) - x - y;
                let light = RectangleLight::new(corner, 2.0 * x, 2.0 * y, plane_normal);
                EmitterShape::Rectangle(light.with_density(texture_density::density(textures, radiance)))
            }
            Primitive::Disk => EmitterShape::Disk(DiskLight {
                world_from_local: to_world,
                normal: plane_normal,
                area: PI * x.cross(y).length(),
            }),
            Primitive::Sphere => match SphereLight::new(&to_world, side) {
                Some(light) => EmitterShape::Sphere(light),
                None => EmitterShape::Ellipsoid(EllipsoidLight::new(to_world, instance.local_from_world, side)),
            },
            Primitive::Cylinder => {
                EmitterShape::Cylinder(CylinderLight::new(to_world, instance.local_from_world, side))
            }
            // As in Mitsuba, curves cannot be lights.
            Primitive::Curves(_) => return None,
            Primitive::Mesh(blas) => {
                let triangles = TriangleLight::of_mesh(instance, blas.mesh(), slot, shines_both_ways);
                match radiance {
                    Parameter::Constant(_) => rectangle_of(blas, &to_world, &triangles),
                    Parameter::Texture(_) => None,
                }
                .map_or(EmitterShape::Mesh(triangles), EmitterShape::Rectangle)
            }
        };
        let bounds = instance.world_bounds();
        let reach = bounds.min.abs().max(bounds.max.abs()).max_element();
        let mesh = match &instance.primitive {
            Primitive::Mesh(blas) => Some(blas.mesh().clone()),
            _ => None,
        };
        let is_smooth = match &shape {
            EmitterShape::Mesh(triangles) => triangles.iter().any(TriangleLight::emits_by_shading_normal),
            _ => false,
        };
        let mut light = Self {
            smooth: is_smooth.then(|| Box::new(instance.clone())),
            radiance,
            shines_both_ways,
            brightness: vec![mean_luminance(textures, radiance)],
            shape,
            bounds,
            mesh,
            local_from_world: instance.local_from_world,
            error: POSITION_ROUNDING * reach,
        };
        if let Parameter::Texture(_) = radiance
            && let Some(brightness) = light.brightness_of_triangles(textures)
        {
            light.brightness = brightness;
        }
        Some(light)
    }

    /// The surface as a plain one: of a common shape, with constant radiance on one side. Otherwise None.
    #[inline(always)]
    pub fn plain(&self) -> Option<PlainSurface> {
        let Parameter::Constant(radiance) = self.radiance else {
            return None;
        };
        let glow = Glow {
            radiance: radiance.max(Rgb::ZERO),
            error: self.error,
        };
        match &self.shape {
            _ if self.shines_both_ways => None,
            EmitterShape::Rectangle(shape) => Some(PlainSurface::Rectangle(shape.uniform()?, glow)),
            EmitterShape::Sphere(shape) => Some(PlainSurface::Sphere(*shape, glow)),
            _ => None,
        }
    }

    /// The number of parts; a mesh has one per triangle.
    pub fn parts(&self) -> u32 {
        match &self.shape {
            EmitterShape::Mesh(triangles) => triangles.len() as u32,
            _ => 1,
        }
    }

    /// The part that `hit`, a point of this surface, is on.
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
            // A surface emitting on one side shows a quarter of its area, averaged over all directions.
            EmitterShape::Sphere(light) => (self.bounds, NormalCone::ALL, 0.25 * light.area()),
            EmitterShape::Ellipsoid(light) => (self.bounds, NormalCone::ALL, 0.25 * light.area()),
            EmitterShape::Cylinder(light) => (self.bounds, NormalCone::ALL, 0.25 * light.area()),
            EmitterShape::Mesh(triangles) => {
                let triangle = &triangles[part as usize];
                (
                    triangle.bounds(),
                    triangle.normals(self.smooth.as_deref()),
                    triangle.area(),
                )
            }
        };
        LightBounds {
            bounds,
            cone: if self.shines_both_ways { NormalCone::ALL } else { cone },
            cos_emission: 0.0,
            intensity: seen_area * self.brightness.get(part as usize).unwrap_or(&self.brightness[0]),
        }
    }

    /// Whether light leaves a point of this surface along `wo`.
    pub fn shines_to(&self, hit: &SurfaceHit, wo: Vec3) -> bool {
        let cos = wo.dot(hit.shading_normal);
        cos > 0.0 || self.shines_both_ways && cos < 0.0
    }

    /// Radiance sent from a point of this surface, on the sides that emit.
    pub fn radiance(&self, hit: &SurfaceHit, textures: &TextureTable) -> Rgb {
        textures.light(self.radiance, &self.texture_point(hit))
    }

    fn texture_point(&self, hit: &SurfaceHit) -> TexturePoint<'_> {
        let Vec2 { x, y } = hit.barycentric;
        TexturePoint {
            uv: hit.uv,
            mesh: self.mesh.as_deref().map(|mesh| MeshPoint {
                mesh,
                triangle: hit.primitive,
                barycentric: Vec3::new(1.0 - x - y, x, y),
            }),
            object: None,
        }
    }

    /// The brightness of each triangle, from a few texture lookups each; None for other shapes. Triangles that look
    /// black keep a little, because lookups may miss bright spots.
    fn brightness_of_triangles(&self, textures: &TextureTable) -> Option<Vec<f32>> {
        let (EmitterShape::Mesh(triangles), Some(mesh)) = (&self.shape, &self.mesh) else {
            return None;
        };
        const LOOKUPS: [Vec2; 4] = [
            Vec2::new(1.0 / 3.0, 1.0 / 3.0),
            Vec2::new(0.1, 0.1),
            Vec2::new(0.8, 0.1),
            Vec2::new(0.1, 0.8),
        ];
        let of_triangle = |triangle: &TriangleLight| {
            let at = |barycentric| {
                let hit = SurfaceHit {
                    position: Vec3::ZERO,
                    normal: Vec3::Z,
                    shading_normal: Vec3::Z,
                    primitive: triangle.primitive,
                    barycentric,
                    uv: mesh_uv(mesh, triangle.primitive, barycentric),
                };
                luminance(self.radiance(&hit, textures)).max(0.0)
            };
            LOOKUPS.map(at).iter().sum::<f32>() / LOOKUPS.len() as f32
        };
        let mut brightness: Vec<f32> = triangles.iter().map(of_triangle).collect();
        let mean = brightness.iter().sum::<f32>() / brightness.len() as f32;
        brightness
            .iter_mut()
            .for_each(|value| *value += LEAST_BRIGHTNESS * mean);
        Some(brightness)
    }

    /// A point of the surface with the data that textures need, if it has any.
    fn hit(&self, part: u32, position: Vec3, normal: Vec3) -> SurfaceHit {
        let mut hit = SurfaceHit {
            position,
            normal,
            shading_normal: normal,
            primitive: self.primitive(part),
            barycentric: Vec2::ZERO,
            uv: Vec2::ZERO,
        };
        if let Parameter::Texture(_) = self.radiance {
            let local = self.local_from_world.transform_point3(position);
            hit.uv = match (&self.shape, &self.mesh) {
                (EmitterShape::Rectangle(_), _) => rectangle::parametrisation(local.x, local.y).uv,
                (EmitterShape::Disk(_), _) => disk::parametrisation(local.x, local.y).uv,
                (EmitterShape::Sphere(_) | EmitterShape::Ellipsoid(_), _) => sphere::uv(local.normalize_or_zero()),
                (EmitterShape::Cylinder(_), _) => cylinder::uv(local),
                (EmitterShape::Mesh(triangles), Some(mesh)) => {
                    hit.barycentric = triangles[part as usize].barycentric(position);
                    mesh_uv(mesh, hit.primitive, hit.barycentric)
                }
                (EmitterShape::Mesh(_), None) => Vec2::ZERO,
            };
        }
        hit
    }

    /// Samples a direction to a part; the density is zero where no light can come from there (the back, the horizon).
    #[inline(always)]
    pub fn sample<R: Real>(
        &self,
        part: u32,
        from: &Reference<R>,
        u: [R; 2],
        textures: &TextureTable,
    ) -> LightSample<R> {
        let point = self.sample_point(part, from, u);
        let radiance = match self.radiance {
            Parameter::Constant(radiance) => R::Vec3::same(radiance.max(Rgb::ZERO)),
            Parameter::Texture(_) => {
                let is_there = from.asked & R::is_above(point.pdf_solid_angle, 0.0);
                let numbers = [point.position.x(), point.position.y(), point.position.z()];
                let [red, green, blue] = R::each(is_there, numbers, |position| {
                    let hit = self.hit(part, position.into(), Vec3::Z);
                    self.radiance(&hit, textures).to_array()
                });
                R::Vec3::of(red, green, blue)
            }
        };
        point.towards(from.position, R::splat(self.error), radiance)
    }

    /// [`Self::sample`] with the point that was chosen.
    pub fn sample_hit(
        &self,
        part: u32,
        reference: &LightReference,
        u: Vec2,
        textures: &TextureTable,
    ) -> Option<(LightSample, SurfaceHit)> {
        let point = self.sample_point::<f32>(part, &reference.into(), u.to_array());
        if point.pdf_solid_angle <= 0.0 {
            return None;
        }
        let hit = self.hit(part, point.position, point.normal);
        let sample = point.towards(reference.position, self.error, self.radiance(&hit, textures));
        Some((sample.if_lit()?, hit))
    }

    /// A point on a part from which light starts, and its density per area; None where the part has no area.
    pub fn sample_start(&self, part: u32, u: Vec2) -> Option<(SurfaceHit, f32)> {
        let AreaSample {
            position,
            normal,
            pdf_area,
        } = self.sample_area(part, u.to_array());
        let mut hit = self.hit(part, position, normal);
        if let (Some(instance), EmitterShape::Mesh(triangles)) = (&self.smooth, &self.shape)
            && triangles[part as usize].emits_by_shading_normal()
        {
            hit.shading_normal = triangles[part as usize].shading_normal(instance, position);
        }
        (pdf_area > 0.0 && pdf_area.is_finite() && normal.is_normalized()).then_some((hit, pdf_area))
    }

    /// Density per area of [`Self::sample_start`] at a point of the part.
    pub fn start_pdf(&self, part: u32, hit: &SurfaceHit) -> f32 {
        match &self.shape {
            EmitterShape::Rectangle(light) => light.pdf_area(hit.uv),
            EmitterShape::Disk(light) => 1.0 / light.area,
            EmitterShape::Cylinder(light) => light.pdf_area(hit.position),
            EmitterShape::Sphere(light) => 1.0 / light.area(),
            EmitterShape::Ellipsoid(light) => light.pdf_area(hit.position),
            EmitterShape::Mesh(triangles) => 1.0 / triangles[part as usize].area(),
        }
    }

    /// Whether light leaves a part on both sides, or only on the shading normal's.
    pub fn is_two_sided(&self, part: u32) -> bool {
        self.shines_both_ways
            || matches!(&self.shape, EmitterShape::Mesh(triangles) if triangles[part as usize].emits_by_shading_normal())
    }

    /// The origin of a ray that leaves a point of the surface.
    pub fn leave(&self, hit: &SurfaceHit, dir: Vec3) -> Vec3 {
        offset_origin(hit.position, self.error, hit.normal, dir)
    }

    /// A point of a part; the normal is zero if the part has no area.
    #[inline(always)]
    fn sample_area<R: Real>(&self, part: u32, u: [R; 2]) -> AreaSample<R> {
        match &self.shape {
            EmitterShape::Rectangle(light) => light.sample_area(u),
            EmitterShape::Disk(light) => light.sample_area(u),
            EmitterShape::Cylinder(light) => light.sample_area(u),
            EmitterShape::Sphere(light) => Same::<R>::same(*light).sample_area(u),
            EmitterShape::Ellipsoid(light) => light.sample_area(u),
            EmitterShape::Mesh(triangles) => {
                let triangle = &triangles[part as usize];
                let [x, y, z] = R::each(R::Mask::ALWAYS, u, |u| triangle.at(u.into()).to_array());
                AreaSample {
                    position: R::Vec3::of(x, y, z),
                    normal: R::Vec3::same(triangle.normal().unwrap_or(Vec3::ZERO)),
                    pdf_area: R::splat(1.0 / triangle.area()),
                }
            }
        }
    }

    fn primitive(&self, part: u32) -> u32 {
        match &self.shape {
            EmitterShape::Mesh(triangles) => triangles[part as usize].primitive,
            _ => 0,
        }
    }

    #[inline(always)]
    fn sample_point<R: Real>(&self, part: u32, from: &Reference<R>, u: [R; 2]) -> SurfaceSample<R> {
        let reference = from.position;
        match &self.shape {
            EmitterShape::Mesh(triangles) => SurfaceSample::each(from, u, |reference, u| {
                let triangle = &triangles[part as usize];
                let sample = triangle.sample(reference, u)?;
                let smooth = self.smooth.as_deref();
                let shines = smooth.is_none_or(|smooth| triangle.shines(smooth, sample.position, reference));
                shines.then_some(sample)
            }),
            EmitterShape::Rectangle(light) if !self.shines_both_ways => light.sample(reference, u),
            EmitterShape::Sphere(light) if !self.shines_both_ways => Same::<R>::same(*light).sample(reference, u),
            _ if self.shines_both_ways => self.sample_area(part, u).facing(reference).seen_from(reference),
            _ => self.sample_area(part, u).seen_from(reference),
        }
    }

    /// A point on a part, or the centre of round shapes.
    pub fn sample_place(&self, part: u32, u: Vec2) -> Vec3 {
        match &self.shape {
            EmitterShape::Rectangle(light) => light.at(u.to_array()),
            EmitterShape::Disk(light) => light.sample_area(u.to_array()).position,
            EmitterShape::Mesh(triangles) => triangles[part as usize].at(u),
            EmitterShape::Cylinder(light) => light.on_axis(u.y),
            EmitterShape::Sphere(_) | EmitterShape::Ellipsoid(_) => self.bounds.center(),
        }
    }

    /// Density per solid angle of [`Self::sample`] at a point of the part.
    pub fn pdf(&self, part: u32, reference: Vec3, hit: &SurfaceHit) -> f32 {
        if self.shines_both_ways && !matches!(self.shape, EmitterShape::Mesh(_)) {
            return solid_angle_pdf(self.start_pdf(part, hit), hit.position, hit.normal, reference);
        }
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

/// The rectangle made up of two triangles, as lights from modelling programs often are: sampled as one, they cost less
/// and give less noise.
fn rectangle_of(blas: &Blas, to_world: &Affine3A, triangles: &[TriangleLight]) -> Option<RectangleLight> {
    let [a, b] = triangles else {
        return None;
    };
    // The square is made of the mesh's regular triangles; a light may be a triangle that no ray can hit, and a triangle
    // of the square may be no light.
    let is_regular = |triangle: &TriangleLight| blas.mesh().regular_corners(triangle.primitive as usize).is_some();
    if !is_regular(a) || !is_regular(b) {
        return None;
    }
    let (normal, other) = (a.emitting_normal()?, b.emitting_normal()?);
    let placed = (to_world.as_daffine3() * blas.local_from_square()?).as_affine3a();
    let [x, y] = [placed.matrix3.x_axis, placed.matrix3.y_axis].map(Vec3::from);
    let light = RectangleLight::new(Vec3::from(placed.translation) - x - y, 2.0 * x, 2.0 * y, normal);
    (normal.dot(other) > 0.0 && light.is_rectangle()).then_some(light)
}

/// The texture coordinates of a mesh's hit at these weights.
fn mesh_uv(mesh: &MeshData, triangle: u32, barycentric: Vec2) -> Vec2 {
    let corners = mesh.triangles[triangle as usize].map(|corner| mesh.uvs.get(corner as usize));
    match corners {
        [Some(a), Some(b), Some(c)] => *a + barycentric.x * (*b - *a) + barycentric.y * (*c - *a),
        _ => barycentric,
    }
}
