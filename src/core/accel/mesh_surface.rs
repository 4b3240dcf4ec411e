//! The world-space surface of placed meshes, for one hit or for sixteen.

use glam::Vec3;

use super::blas::Blas;
use super::hit::{Hit, SurfacePoint};
use super::instance::{Instance, Primitive};
use super::tlas::Tlas;
use crate::geometry::local::LocalSurface;
use crate::geometry::mesh::MeshData;
use crate::geometry::triangle;
use crate::math::lanes::{LANES, Lanes, Vec3Lanes, each_lane};
use crate::math::{LanesOf, Mask, Matrix, Real, Vector, gamma, real_struct};

real_struct! {
    /// The transforms and signs of a placed shape.
    pub(super) struct Place<R> {
        pub world_from_local: Matrix<R>,
        pub translation: R::Vec3,
        pub local_from_world: Matrix<R>,
        /// The bound on the rounding of the translation, as in [`super::rounding::Rounding`], whose other bounds follow
        /// from the matrices.
        pub of_translation: R::Vec3,
        /// -1 where a mirroring transform turns the geometric normal of a triangle around, else 1.
        pub hand: R,
        /// -1 where normals are flipped, else 1.
        pub side: R,
        /// Whether the transform preserves angles.
        pub keeps_angles: R::Mask,
    }
}

real_struct! {
    /// A triangle that was hit, in local space.
    struct Triangle<R> {
        a: R::Vec3,
        b: R::Vec3,
        c: R::Vec3,
        /// The weights of the corners `b` and `c`.
        u: R,
        v: R,
    }
}

real_struct! {
    /// The normals at the corners of a triangle, in local space.
    struct VertexNormals<R> {
        a: R::Vec3,
        b: R::Vec3,
        c: R::Vec3,
        /// -1 where a mirroring transform turns them around, else 1.
        hand: R,
        /// Whether the shape is shaded by vertex normals.
        are_there: R::Mask,
    }
}

/// The surfaces at sixteen hits, as [`SurfacePoint`] without texture coordinates.
pub(crate) struct SurfaceLanes {
    /// The lanes with a surface, a bit each.
    pub lanes: u32,
    pub position: Vec3Lanes,
    pub error: Lanes,
    pub geometric_normal: Vec3Lanes,
    pub shading_normal: Vec3Lanes,
}

impl Tlas {
    /// The surfaces at the hits whose bits are set in `asked` and that are on meshes outside groups.
    #[inline(never)]
    pub(crate) fn mesh_surfaces(&self, hits: &[Option<Hit>; LANES], asked: u32) -> Option<SurfaceLanes> {
        let mut found: Option<(Place<Lanes>, Triangle<Lanes>, VertexNormals<Lanes>)> = None;
        let mut lanes = 0;
        for lane in each_lane(asked) {
            let Some((hit, shape, blas)) = hits[lane].as_ref().and_then(|hit| self.lone_mesh_at(hit)) else {
                continue;
            };
            let (place, triangle) = (shape.place(), Triangle::at(blas, hit));
            let (places, triangles, normals) = found.get_or_insert_with(|| {
                (
                    LanesOf::splat(place),
                    LanesOf::splat(triangle),
                    LanesOf::splat(VertexNormals::NONE),
                )
            });
            places.set_lane(lane, place);
            triangles.set_lane(lane, triangle);
            if let Some(own) = VertexNormals::at(shape, hit.primitive) {
                normals.set_lane(lane, own);
            }
            lanes |= 1 << lane;
        }
        let (places, triangles, normals) = found?;
        let local = triangle::surface([triangles.a, triangles.b, triangles.c], triangles.u, triangles.v);
        let geometric = places.normal(&local) * places.hand;
        let shading = match normals.are_there.any() {
            true => normals.at_weights(&places, [triangles.u, triangles.v], geometric),
            false => geometric,
        };
        Some(SurfaceLanes {
            lanes,
            position: places.position(&local),
            error: places.error(&local),
            geometric_normal: geometric * places.side,
            shading_normal: shading * places.side,
        })
    }

    /// The mesh that was hit, unless it is in a group.
    #[inline(always)]
    fn lone_mesh_at<'a>(&'a self, hit: &'a Hit) -> Option<(&'a Hit, &'a Instance, &'a Blas)> {
        let shape = self.instances.get(hit.instance as usize)?;
        match &shape.primitive {
            Primitive::Mesh(blas) => Some((hit, shape, blas)),
            _ => None,
        }
    }
}

impl SurfaceLanes {
    /// The surface of a lane.
    #[inline(always)]
    pub fn get(&self, lane: usize) -> SurfacePoint {
        SurfacePoint::plain(
            self.position.get(lane),
            self.error.as_array()[lane],
            [self.geometric_normal.get(lane), self.shading_normal.get(lane)],
        )
    }
}

impl Triangle {
    #[inline(always)]
    fn at(blas: &Blas, hit: &Hit) -> Self {
        let [a, b, c] = blas.corners(hit);
        let (u, v) = (hit.u, hit.v);
        Self { a, b, c, u, v }
    }
}

impl VertexNormals {
    const NONE: Self = Self {
        a: Vec3::ZERO,
        b: Vec3::ZERO,
        c: Vec3::ZERO,
        hand: 1.0,
        are_there: false,
    };

    /// The normals at the corners of a triangle. None if the shape is shaded by its geometric normals.
    #[inline(always)]
    fn at(shape: &Instance, triangle: u32) -> Option<Self> {
        let mesh: &MeshData = shape.with_vertex_normals()?.mesh();
        let corners = mesh.triangles.get(triangle as usize)?;
        let [a, b, c] = corners.map(|corner| mesh.normals.get(corner as usize).copied());
        Some(Self {
            a: a?,
            b: b?,
            c: c?,
            hand: sign(shape.mirrored && mesh.has_computed_normals),
            are_there: true,
        })
    }
}

impl<R: Real> VertexNormals<R> {
    /// The interpolated normal, not flipped, or `geometric` where there is none. Each normal is transformed to the
    /// world and normalised first, as if the mesh had been stored transformed.
    #[inline(always)]
    fn at_weights(&self, place: &Place<R>, [u, v]: [R; 2], geometric: R::Vec3) -> R::Vec3 {
        let mean = |[a, b, c]: [R::Vec3; 3]| a * (R::ONE - u - v) + b * u + c * v;
        let normals = [self.a, self.b, self.c];
        // Where angles are preserved, all lengths scale alike, so that one transform suffices.
        let mut world = place.world_normal(mean(normals));
        if (self.are_there & !place.keeps_angles).any() {
            let unit = |normal: R::Vec3| {
                let world = place.world_normal(normal);
                unit_or::<R>(world, R::Vec3::even(R::ZERO))
            };
            world = R::Vec3::select(place.keeps_angles, world, mean(normals.map(unit)));
        }
        let (normal, is_one) = unit::<R>(world);
        R::Vec3::select(self.are_there & is_one, normal * self.hand, geometric)
    }
}

impl Instance {
    /// The shape's transforms and signs.
    #[inline(always)]
    pub(super) fn place(&self) -> Place {
        Place {
            world_from_local: self.world_from_local.matrix3.into(),
            translation: self.world_from_local.translation.into(),
            local_from_world: self.local_from_world.matrix3.into(),
            of_translation: self.rounding.of_translation.into(),
            hand: sign(self.mirrored && matches!(self.primitive, Primitive::Mesh(_))),
            side: sign(self.flip_normals),
            keeps_angles: self.similarity.is_some(),
        }
    }

    /// The unit shading normal of a mesh's triangle at the weights of its corners 1 and 2, not flipped. None where it
    /// is the geometric normal.
    #[inline(always)]
    pub(super) fn vertex_normal(&self, triangle: u32, weights: [f32; 2]) -> Option<Vec3> {
        let normals = VertexNormals::at(self, triangle)?;
        let normal = normals.at_weights(&self.place(), weights, Vec3::ZERO);
        (normal != Vec3::ZERO).then_some(normal)
    }
}

impl<R: Real> Place<R> {
    #[inline(always)]
    pub fn position(&self, local: &LocalSurface<R>) -> R::Vec3 {
        self.world_from_local.times(local.position) + self.translation
    }

    /// The unit normal in the world, neither mirrored nor flipped.
    #[inline(always)]
    pub fn normal(&self, local: &LocalSurface<R>) -> R::Vec3 {
        unit_or::<R>(self.world_normal(local.normal), R::Vec3::same(Vec3::Z))
    }

    /// The local error in world units, with the rounding of the transform to the world and of the next ray's transform
    /// back.
    #[inline(always)]
    pub fn error(&self, local: &LocalSurface<R>) -> R {
        let (out, back) = (self.world_from_local.abs(), self.local_from_world.abs());
        let image = out.times(local.position.map(R::abs));
        let in_local = local.error + back.times(image) * R::splat(gamma(8));
        (out.times(in_local) + image * R::splat(gamma(4)) + self.of_translation).max_element()
    }

    /// Transforms a normal by the inverse transpose. The result is not of unit length, but neither overflows nor
    /// vanishes for sensible transforms.
    #[inline(always)]
    fn world_normal(&self, local: R::Vec3) -> R::Vec3 {
        self.local_from_world
            .transposed_times(local / local.map(R::abs).max_element())
    }
}

/// The normalised vector, and whether its length is neither zero nor infinite.
#[inline(always)]
fn unit<R: Real>(v: R::Vec3) -> (R::Vec3, R::Mask) {
    let inverse = R::ONE / v.length_squared().sqrt();
    let is_one = R::is_above(inverse, 0.0) & inverse.is_less(R::splat(f32::INFINITY));
    (v * inverse, is_one)
}

#[inline(always)]
fn unit_or<R: Real>(v: R::Vec3, other: R::Vec3) -> R::Vec3 {
    let (unit, is_one) = unit::<R>(v);
    R::Vec3::select(is_one, unit, other)
}

#[inline(always)]
fn sign(is_turned: bool) -> f32 {
    if is_turned { -1.0 } else { 1.0 }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use glam::{Affine3A, Mat3A, Quat};

    use super::*;
    use crate::accel::{Detail, Placement, SplitMethod};
    use crate::geometry::primitives::unit_cube;
    use crate::math::Ray;
    use crate::sampling::hash::pcg3d;
    use crate::sampling::unit_float;

    /// Meshes with and without vertex normals, rotated, sheared, mirrored, flipped and tiny, a sphere and a group.
    fn scene() -> Tlas {
        let mut bent = unit_cube();
        for (normal, place) in bent.normals.iter_mut().zip(&bent.positions) {
            *normal = (*normal + 0.5 * *place).normalize();
        }
        let mut computed = bent.clone();
        computed.has_computed_normals = true;
        let bare = MeshData {
            normals: Vec::new(),
            ..unit_cube()
        };
        let meshes =
            [unit_cube(), bent, computed, bare].map(|mesh| Arc::new(Blas::build(Arc::new(mesh), SplitMethod::Sah)));
        let turn = Mat3A::from_quat(Quat::from_rotation_z(0.4) * Quat::from_rotation_x(1.1));
        let mirror = Mat3A::from_diagonal(Vec3::new(1.0, 1.0, -1.0));
        let shear = Mat3A::from_cols_array(&[1.0, 0.0, 0.3, 0.2, 1.5, 0.0, 0.0, -0.4, 0.7]);
        let linear = [
            turn,
            turn * mirror,
            shear,
            shear * mirror * turn,
            turn * 1e-3,
            turn * 1.3,
        ];
        let mut shapes = Vec::new();
        for (number, (mesh, linear)) in meshes
            .iter()
            .flat_map(|mesh| linear.map(|linear| (mesh, linear)))
            .enumerate()
        {
            let translation = Vec3::new(3.0 * (number % 6) as f32, 4.0 * (number / 6) as f32, 0.0);
            let placed = Affine3A::from_mat3_translation(linear.into(), translation);
            let mut shape = Instance::new(Primitive::Mesh(mesh.clone()), placed).unwrap();
            shape.flip_normals = number % 3 == 0;
            shape.face_normals = number % 5 == 4;
            shapes.push(shape);
        }
        let ball = Instance::new(Primitive::Sphere, Affine3A::from_translation(Vec3::new(-4.0, 0.0, 0.0))).unwrap();
        let group = Tlas::build(vec![shapes[0].clone()], SplitMethod::Sah);
        shapes.push(ball);
        let placement = Placement::new(0, &Affine3A::from_translation(Vec3::new(-4.0, 5.0, 0.0))).unwrap();
        Tlas::with_placements(shapes, vec![Arc::new(group)], vec![placement], SplitMethod::Sah)
    }

    #[test]
    fn surfaces_in_lanes_are_those_of_one() {
        let scene = scene();
        let mut found = [0; 25];
        for round in 0..20_000 {
            let number = |lane: usize, which: u32| Vec3::from(pcg3d([round, lane as u32, which]).map(unit_float));
            let rays: [Ray; LANES] = std::array::from_fn(|lane| {
                let target = number(lane, 0) * Vec3::new(25.0, 16.0, 2.0) - Vec3::new(6.0, 2.0, 1.0);
                let origin = target + 40.0 * (number(lane, 1) - 0.5);
                Ray::new(origin, (target - origin).normalize())
            });
            let hits = rays.each_ref().map(|ray| scene.intersect(ray));
            let asked = 0xbfff;
            let Some(lanes) = scene.mesh_surfaces(&hits, asked) else {
                continue;
            };
            for (lane, (ray, hit)) in rays.iter().zip(&hits).enumerate() {
                let is_there = lanes.lanes >> lane & 1 == 1;
                let is_mesh = hit.is_some_and(|hit| hit.instance < 24);
                assert_eq!(is_there, is_mesh && asked >> lane & 1 == 1);
                let Some(hit) = hit.filter(|_| is_there) else { continue };
                found[hit.instance as usize] += 1;
                let (one, here) = (scene.surface_in(ray, &hit, Detail::Plain), lanes.get(lane));
                assert!((one.position - here.position).abs().max_element() <= one.error);
                assert!(
                    (one.error - here.error).abs() <= 1e-3 * one.error,
                    "{} {}",
                    one.error,
                    here.error
                );
                assert!(one.geometric_normal.abs_diff_eq(here.geometric_normal, 1e-6));
                assert!(one.shading_normal.abs_diff_eq(here.shading_normal, 1e-6));
                let (whole, parametrised) = (scene.surface(ray, &hit), scene.parametrised(&hit, here));
                assert_eq!(
                    (whole.uv, whole.dp_du, whole.dp_dv),
                    (parametrised.uv, parametrised.dp_du, parametrised.dp_dv)
                );
            }
        }
        // The tiny ones are hit by chance.
        let seen = found.iter().filter(|&&found| found > 50).count();
        assert!(seen >= 20, "{found:?}");
    }
}
