//! The world-space surface at a hit.
//!
//! The conventions are Mitsuba 3's. A mesh's geometric normal is that of the transformed triangle, so a mirroring
//! transform turns it around. Vertex normals from a file are transformed by the inverse transpose and may disagree with
//! it; vertex normals computed from the triangles turn around with it. The normals of other shapes are transformed by
//! the inverse transpose.

use glam::{Affine3A, DAffine3, Vec2, Vec3, Vec3A};

use super::blas::Blas;
use super::hit::{Detail, Hit, SurfacePoint};
use super::instance::{Instance, Primitive};
use super::memory::prefetch;
use super::mesh_surface::Place;
use super::rounding::absolute;
use super::tlas::Tlas;
use crate::geometry::local::{LocalSurface, Parametrisation};
use crate::geometry::mesh::MeshData;
use crate::geometry::{cylinder, disk, rectangle, sphere, triangle};
use crate::math::Ray;

impl Tlas {
    /// The mesh of the hit, if it has one; `hit.primitive` is the triangle, `hit.u`, `hit.v` the weights of its corners
    /// 1 and 2.
    pub fn mesh_at(&self, hit: &Hit) -> Option<&MeshData> {
        match &self.shape_at(hit).primitive {
            Primitive::Mesh(blas) => Some(blas.mesh()),
            _ => None,
        }
    }

    /// The surface at `hit`, which must be a hit of `ray` in this hierarchy, in full detail.
    pub fn surface(&self, ray: &Ray, hit: &Hit) -> SurfacePoint {
        self.surface_in(ray, hit, Detail::Parametrised)
    }

    /// Prefetches the vertex normals at all hits, unless the scene fits into a cache.
    pub(super) fn prefetch_normals(&self, hits: &[Option<Hit>]) {
        if !(self.is_large && self.has_vertex_normals) {
            return;
        }
        let triangles = || {
            hits.iter().flatten().filter_map(|hit| {
                let shape = self.shape_at(hit);
                let mesh = shape.with_vertex_normals()?.mesh();
                Some((mesh, mesh.triangles.get(hit.primitive as usize)?))
            })
        };
        triangles().for_each(|(_, triangle)| prefetch(triangle));
        for (mesh, triangle) in triangles() {
            for &corner in triangle {
                mesh.normals.get(corner as usize).into_iter().for_each(prefetch);
            }
        }
    }

    /// Carries the point `place` on the hit shape over to `other`, a hierarchy in which the same shapes are moved.
    /// Returns `place` itself if `other` has no such shape.
    pub fn place_in(&self, other: &Self, hit: &Hit, place: Vec3) -> Vec3 {
        let Some(its) = other.transforms_at(hit) else {
            return place;
        };
        let Some(own) = self.transforms_at(hit).filter(|own| *own != its) else {
            return place;
        };
        let [own, its] = [own, its].map(|transforms| {
            let whole = transforms.into_iter().flatten();
            whole.fold(DAffine3::IDENTITY, |outer, inner| outer * inner.as_daffine3())
        });
        (its * own.inverse()).transform_point3(place.as_dvec3()).as_vec3()
    }

    /// The transform of the shape at `hit` to the world.
    pub(crate) fn world_from_shape(&self, hit: &Hit) -> Affine3A {
        match self.transforms_at(hit) {
            Some([Some(placement), Some(shape)]) => placement * shape,
            Some([_, Some(shape)]) => shape,
            _ => Affine3A::IDENTITY,
        }
    }

    /// The transforms of the placement, if the hit is in one, and of the shape. None if no shape has these numbers.
    fn transforms_at(&self, hit: &Hit) -> Option<[Option<Affine3A>; 2]> {
        let Some(place) = (hit.instance as usize).checked_sub(self.instances.len()) else {
            let shape = self.instances.get(hit.instance as usize)?;
            return Some([None, Some(shape.world_from_local)]);
        };
        let placement = self.placements.get(place)?;
        let member = self
            .groups
            .get(placement.group as usize)?
            .instances
            .get(hit.member as usize)?;
        Some([Some(placement.world_from_group()), Some(member.world_from_local)])
    }

    /// Adds the parametrisation to `plain`, the surface without one at `hit`, which must be on a mesh outside groups.
    pub(crate) fn parametrised(&self, hit: &Hit, plain: SurfacePoint) -> SurfacePoint {
        let shape = self.shape_at(hit);
        let unflipped = shape.place().side * plain.geometric_normal;
        let Parametrisation { uv, dp_du, dp_dv } = match &shape.primitive {
            Primitive::Mesh(blas) => shape.mesh_parametrisation(blas, hit, unflipped),
            _ => Parametrisation::default(),
        };
        SurfacePoint {
            uv,
            dp_du,
            dp_dv,
            ..plain
        }
    }

    /// [`Self::surface`] with no more than `detail`.
    #[inline(always)]
    pub fn surface_in(&self, ray: &Ray, hit: &Hit, detail: Detail) -> SurfacePoint {
        match self.placement_at(hit) {
            None => self.shape_at(hit).surface(ray, hit, detail),
            Some(placement) => {
                let in_group = self.shape_at(hit).surface(&placement.group_ray(ray), hit, detail);
                placement.place(&in_group)
            }
        }
    }
}

impl Instance {
    /// The surface at `hit`, which must be a hit of `ray` on this instance.
    #[inline(always)]
    fn surface(&self, ray: &Ray, hit: &Hit, detail: Detail) -> SurfacePoint {
        if let (Primitive::Rectangle | Primitive::Disk, Detail::Plain) = (&self.primitive, detail) {
            return self.plane_surface(hit);
        }
        let local = match &self.primitive {
            Primitive::Mesh(blas) => triangle::surface(blas.corners(hit), hit.u, hit.v),
            Primitive::Sphere => sphere::surface(&self.local_ray(ray), hit.t),
            Primitive::Rectangle => rectangle::surface(hit.u, hit.v),
            Primitive::Disk => disk::surface(hit.u, hit.v),
            Primitive::Cylinder => cylinder::surface(&self.local_ray(ray), hit.t),
            Primitive::Curves(curves) => curves.surface(&self.local_ray(ray), hit),
        };
        let place = self.place();
        let geometric = self.geometric_normal(&place, &local);
        let shading = self.vertex_normal(hit.primitive, [hit.u, hit.v]).unwrap_or(geometric);
        let (position, error) = match &self.primitive {
            Primitive::Mesh(_) => (place.position(&local), place.error(&local)),
            _ => self.placed(&local),
        };
        let Place { side, .. } = place;
        let parametrisation = match detail {
            Detail::Plain => Parametrisation::default(),
            Detail::Parametrised => self.parametrisation(ray, hit, local.position, geometric),
        };
        SurfacePoint {
            position,
            error,
            geometric_normal: side * geometric,
            shading_normal: side * shading,
            uv: parametrisation.uv,
            dp_du: parametrisation.dp_du,
            dp_dv: parametrisation.dp_dv,
        }
    }

    /// The mesh, if the shape is one with vertex normals that are used.
    #[inline(always)]
    pub(super) fn with_vertex_normals(&self) -> Option<&Blas> {
        match &self.primitive {
            Primitive::Mesh(blas) if !self.face_normals => {
                // A mirroring transform turns the geometric normal around, but not the normals from the file.
                let may_differ = !blas.has_flat_normals || self.mirrored && !blas.mesh().has_computed_normals;
                (may_differ && !blas.mesh().normals.is_empty()).then_some(blas)
            }
            _ => None,
        }
    }

    /// The unit shading normal in world space of a mesh's triangle at the weights `barycentric` of its corners 1 and 2,
    /// on the side that rays see. None where it is the geometric normal.
    pub fn shading_normal(&self, triangle: u32, barycentric: Vec2) -> Option<Vec3> {
        Some(self.place().side * self.vertex_normal(triangle, barycentric.to_array())?)
    }

    /// The surface of a shape in the plane z = 0, without its parametrisation.
    #[inline(always)]
    fn plane_surface(&self, hit: &Hit) -> SurfacePoint {
        let Affine3A {
            matrix3: linear,
            translation,
        } = &self.world_from_local;
        let error = self.rounding.of_position.x_axis * hit.u.abs()
            + self.rounding.of_position.y_axis * hit.v.abs()
            + self.rounding.of_translation;
        let normal = if self.flip_normals {
            -self.plane_normal
        } else {
            self.plane_normal
        };
        SurfacePoint::plain(
            (linear.x_axis * hit.u + linear.y_axis * hit.v + *translation).into(),
            error.max_element(),
            [normal; 2],
        )
    }

    /// [`Self::parametrisation`] of a mesh. `geometric` is the unit normal in the world.
    #[inline(never)]
    fn mesh_parametrisation(&self, blas: &Blas, hit: &Hit, geometric: Vec3) -> Parametrisation {
        let mesh = blas.mesh();
        let triangle = hit.primitive as usize;
        let uvs = match mesh.triangles[triangle].map(|corner| mesh.uvs.get(corner as usize)) {
            [Some(&a), Some(&b), Some(&c)] => Some([a, b, c]),
            _ => None,
        };
        let local = triangle::parametrisation(mesh.corners(triangle), hit.u, hit.v, uvs);
        if local.dp_du == Vec3::ZERO {
            let (dp_du, dp_dv) = geometric.any_orthonormal_pair();
            return Parametrisation { dp_du, dp_dv, ..local };
        }
        self.in_world(local)
    }

    /// The parametrisation at a hit of `ray`, with derivatives in world space. `position` is local, `geometric` the
    /// unit normal in the world.
    #[inline(never)]
    fn parametrisation(&self, ray: &Ray, hit: &Hit, position: Vec3, geometric: Vec3) -> Parametrisation {
        let local = match &self.primitive {
            Primitive::Mesh(blas) => return self.mesh_parametrisation(blas, hit, geometric),
            Primitive::Curves(curves) => {
                // The direction of the world's z axis, if the transform preserves angles.
                let up = self.world_from_local.matrix3.transpose() * Vec3A::Z;
                curves.parametrisation(&self.local_ray(ray), hit, up.into())
            }
            Primitive::Sphere => sphere::parametrisation(position),
            Primitive::Rectangle => rectangle::parametrisation(hit.u, hit.v),
            Primitive::Disk => disk::parametrisation(hit.u, hit.v),
            Primitive::Cylinder => cylinder::parametrisation(position),
        };
        self.in_world(local)
    }

    /// The same with derivatives in world space.
    fn in_world(&self, local: Parametrisation) -> Parametrisation {
        Parametrisation {
            dp_du: self.world_from_local.transform_vector3(local.dp_du),
            dp_dv: self.world_from_local.transform_vector3(local.dp_dv),
            ..local
        }
    }

    /// The world position and its error, as [`Place::position`] and [`Place::error`] give them. Vectors of four are
    /// faster for a single point.
    #[inline(always)]
    fn placed(&self, local: &LocalSurface) -> (Vec3, f32) {
        let error = absolute(&self.world_from_local.matrix3) * Vec3A::from(local.error)
            + self.rounding.of_position * Vec3A::from(local.position.abs())
            + self.rounding.of_translation;
        let position = self.world_from_local.transform_point3(local.position);
        (position, error.max_element())
    }

    /// Unit world normal.
    #[inline(always)]
    fn geometric_normal(&self, place: &Place, local: &LocalSurface) -> Vec3 {
        if let (Primitive::Sphere, Some(inverse)) = (&self.primitive, self.similarity) {
            // A point of the unit sphere has unit length.
            return (inverse * (self.world_from_local.matrix3 * Vec3A::from(local.normal))).into();
        }
        place.normal(local) * place.hand
    }

    /// Unit world normal of the local plane z = 0, on the side of +z.
    pub(super) fn plane_normal(local_from_world: &Affine3A) -> Vec3 {
        let normal = local_from_world.matrix3.transpose() * Vec3A::Z;
        Vec3::from(normal).try_normalize().unwrap_or(Vec3::Z)
    }
}
