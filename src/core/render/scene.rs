//! The scene in the kernel: immutable tables with dense ids, shared by reference count so that an edit replaces one of
//! them.

use std::sync::Arc;

use bytemuck::{Pod, Zeroable};
use glam::{Vec2, Vec3};

use crate::accel::{Detail, Hit, Primitive, SurfacePoint, Tlas};
use crate::light::emission::Reach;
use crate::light::{LightId, LightTable, WeightedSource};
use crate::material::{MaterialId, MaterialTable, Scattering, Single};
use crate::math::Ray;
use crate::medium::{MediumInterface, MediumTable};
use crate::shading::TransportMode;
use crate::texture::{MeshPoint, ObjectPoint, TexturePoint, TextureTable};

/// The data of a scene for light transport. A clone copies six pointers and a few numbers.
#[derive(Clone, Debug)]
pub struct RenderScene {
    /// The hierarchy over all shapes.
    pub geometry: Arc<Tlas>,
    /// The material and the light of each slot of a shape.
    pub surfaces: Arc<SurfaceTable>,
    /// The materials that [`SurfaceSlot::material`] refers to.
    pub materials: Arc<MaterialTable>,
    /// The textures that parameters of materials and lights refer to.
    pub textures: Arc<TextureTable>,
    /// The lights that [`SurfaceSlot::light`] refers to, with the tree that chooses among all of them.
    pub lights: Arc<LightTable>,
    /// The region that the lights can reach, [`LightTable::reach`].
    pub reach: Reach,
    /// The participating media that [`SurfaceSlot::media`] refers to.
    pub media: Arc<MediumTable>,
}

/// The material and the light of a part of a shape's surface, and the media on its sides.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SurfaceSlot {
    /// The material, in [`RenderScene::materials`].
    pub material: MaterialId,
    /// The area light of the slot; None if it does not emit.
    pub light: Option<LightId>,
    /// The media on both sides of the surface.
    pub media: MediumInterface,
}

/// The first hit of a camera ray, whether light passes through it or not.
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct FirstHit {
    /// The instance as [`Hit::instance`] counts them.
    pub instance: u32,
    /// The material of the slot that was hit.
    pub material: MaterialId,
    /// The surface coordinates of the hit.
    pub uv: Vec2,
}

/// The slots of every shape. A shape has one slot, or one per material of its mesh file.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct SurfaceTable {
    /// The index of the first slot of each shape, as [`Tlas::shape_index`] counts them.
    pub first_slot: Vec<u32>,
    /// The slots of all shapes, contiguous for each shape.
    pub slots: Vec<SurfaceSlot>,
}

impl RenderScene {
    /// The scene with these lights in place of all of its own, and of the light of media, and with its portals.
    /// Surfaces do not shine when paths come upon them: the emitting shapes among `sources` light by being sampled
    /// alone.
    pub fn lit_by(&self, sources: &[WeightedSource]) -> Self {
        let dark = |slot: &SurfaceSlot| SurfaceSlot { light: None, ..*slot };
        let portals = self.lights.all_portals();
        let lights = LightTable::build(sources, &self.geometry, &self.textures);
        let lights = lights.with_portals(portals, &self.geometry, |shape| self.is_clear(shape));
        Self {
            surfaces: Arc::new(SurfaceTable {
                first_slot: self.surfaces.first_slot.clone(),
                slots: self.surfaces.slots.iter().map(dark).collect(),
            }),
            reach: lights.reach(&self.geometry),
            lights: Arc::new(lights),
            media: Arc::new(self.media.without_emission()),
            ..self.clone()
        }
    }

    /// Whether both scenes share all their tables.
    pub fn is_same(&self, other: &Self) -> bool {
        Arc::ptr_eq(&self.geometry, &other.geometry)
            && Arc::ptr_eq(&self.surfaces, &other.surfaces)
            && Arc::ptr_eq(&self.materials, &other.materials)
            && Arc::ptr_eq(&self.textures, &other.textures)
            && Arc::ptr_eq(&self.lights, &other.lights)
            && Arc::ptr_eq(&self.media, &other.media)
    }

    /// The point for texture lookups at `hit`, whose surface is `point`.
    pub(crate) fn texture_point(&self, hit: &Hit, point: &SurfacePoint) -> TexturePoint<'_> {
        TexturePoint {
            uv: point.uv,
            mesh: self.geometry.mesh_at(hit).map(|mesh| MeshPoint {
                mesh,
                triangle: hit.primitive,
                barycentric: Vec3::new(1.0 - hit.u - hit.v, hit.u, hit.v),
            }),
            object: self.textures.projects().then(|| self.object_point(hit, point)),
        }
    }

    /// The place on the shape at `hit`, whose surface is `point`.
    #[inline(never)]
    fn object_point(&self, hit: &Hit, point: &SurfacePoint) -> ObjectPoint {
        ObjectPoint::new(
            &self.geometry.world_from_shape(hit),
            point.position,
            point.geometric_normal,
            [point.dp_du, point.dp_dv],
        )
    }

    /// The slot a ray has hit.
    pub fn slot(&self, hit: &Hit) -> SurfaceSlot {
        let shape = self.geometry.shape_index(hit);
        let first = self.surfaces.first_slot[shape];
        let last = self.surfaces.first_slot.get(shape + 1);
        let count = last.map_or(self.surfaces.slots.len() as u32, |&next| next) - first;
        // A shape with its own BSDF has one slot, whatever its file says.
        let offset = if count > 1
            && let Primitive::Mesh(blas) = &self.geometry.shape_at(hit).primitive
        {
            let materials = &blas.mesh().material_of_triangle;
            materials
                .get(hit.primitive as usize)
                .map_or(0, |&material| u32::from(material))
        } else {
            0
        };
        self.surfaces.slots[(first + offset) as usize]
    }

    /// Whether light may pass straight through a shape's surface somewhere. Shapes are numbered as in
    /// [`Tlas::shape_index`].
    #[inline(never)]
    pub fn is_clear(&self, shape: usize) -> bool {
        let SurfaceTable { first_slot, slots } = &*self.surfaces;
        let first = first_slot[shape] as usize;
        let end = first_slot.get(shape + 1).map_or(slots.len(), |&next| next as usize);
        slots[first..end]
            .iter()
            .any(|slot| self.materials.is_clear(slot.material))
    }

    /// The surface at `hit` of `ray`, in the detail that its material and its light need.
    pub fn surface(&self, ray: &Ray, hit: &Hit, slot: &SurfaceSlot) -> SurfacePoint {
        self.geometry.surface_in(ray, hit, self.detail(slot))
    }

    /// The detail of a surface that its material and its light need.
    pub fn detail(&self, slot: &SurfaceSlot) -> Detail {
        match slot.light.is_some_and(|light| self.lights.is_textured(light)) {
            true => Detail::Parametrised,
            false => self.materials.detail(slot.material),
        }
    }

    /// The part of a camera ray's hit that the film keeps.
    pub fn first_hit(&self, ray: &Ray, hit: &Hit) -> FirstHit {
        FirstHit {
            instance: hit.instance,
            material: self.slot(hit).material,
            uv: self.geometry.surface(ray, hit).uv,
        }
    }

    /// The only model of [`Self::scattering`]; None if it mixes several, or lets light pass straight through.
    pub(crate) fn single(
        &self,
        material: MaterialId,
        hit: &Hit,
        point: &SurfacePoint,
        wo: Vec3,
        mode: TransportMode,
    ) -> Option<Single<'_>> {
        let at = self.texture_point(hit, point);
        let single = self.materials.single(material, point, wo, mode, &self.textures, &at);
        single.or_else(|| self.scattering(material, hit, point, wo, mode).take_single())
    }

    /// The scattering of the surface at `hit` for a path from `wo`, a unit vector in world space.
    pub fn scattering(
        &self,
        material: MaterialId,
        hit: &Hit,
        point: &SurfacePoint,
        wo: Vec3,
        mode: TransportMode,
    ) -> Scattering<'_> {
        let at = self.texture_point(hit, point);
        self.materials
            .scattering(material, point, wo, mode, &self.textures, &at)
    }
}
