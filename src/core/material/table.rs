//! The table of a scene's materials, which gives light transport the scattering at surfaces.

use glam::Vec3;

use super::definition::{Material, MaterialId};
use super::nesting::{self, MaterialTableError};
use super::scattering::{Scattering, Single};
use crate::accel::{Detail, SurfacePoint};
use crate::color::Rgb;
use crate::shading::{Bsdf, ShadingTables, TransportMode};
use crate::texture::{TexturePoint, TextureTable};

/// The table of all materials of a scene.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct MaterialTable {
    materials: Vec<Material>,
    /// The tables to which the models of the materials refer.
    tables: ShadingTables,
    /// Whether light can pass straight through each material somewhere.
    clear: Vec<bool>,
    /// Whether it can through any of the materials.
    has_null_lobe: bool,
    /// Whether any of them has a delta lobe.
    has_delta_lobe: bool,
    /// Whether each material depends on texture coordinates or tangents.
    parametrised: Vec<bool>,
    /// Whether lanes can shade each material, see [`Self::is_for_lanes`].
    for_lanes: Vec<bool>,
    /// The albedo of each material, black unless it is plain, see [`PlainSide::albedo`].
    albedos: Vec<Rgb>,
}

/// The only model of a surface, about its own shading normal.
#[derive(Clone, Copy, Debug)]
pub struct PlainSide<'a> {
    /// The model, in a frame whose z is along the shading normal.
    pub bsdf: &'a Bsdf,
    /// The colour for denoisers, see [`Bsdf::albedo`].
    pub albedo: Rgb,
    /// The side seen by the viewer: 1, or -1 from behind.
    pub side: f32,
}

impl MaterialTable {
    /// A table in which the index in `materials` is the [`MaterialId`], without models that need [`ShadingTables`].
    /// Nested materials must be in the same list, before or after.
    pub fn new(materials: Vec<Material>) -> Result<Self, MaterialTableError> {
        Self::with_tables(materials, ShadingTables::default())
    }

    /// A table as [`Self::new`] builds it, of materials whose models may have ids of `tables`.
    pub fn with_tables(materials: Vec<Material>, tables: ShadingTables) -> Result<Self, MaterialTableError> {
        Self::check(&materials, &tables)?;
        Ok(Self::checked(materials, tables))
    }

    /// Checks that these materials can be a table: nested materials exist, contain neither themselves nor too many
    /// levels, and all ids are from `tables`.
    pub fn check(materials: &[Material], tables: &ShadingTables) -> Result<(), MaterialTableError> {
        nesting::check(materials, tables)
    }

    /// Builds as [`Self::with_tables`], from materials that have passed [`Self::check`].
    pub fn checked(mut materials: Vec<Material>, tables: ShadingTables) -> Self {
        for material in &mut materials {
            if let Material::Textured(textured) = material
                && let Some(bsdf) = textured.if_constant()
            {
                *material = Material::Plain(bsdf);
            }
        }
        let clear = nesting::clear(&materials);
        let has_delta_lobe = materials.iter().any(|material| match material {
            Material::Plain(bsdf) => bsdf.has_delta_lobe(),
            Material::Textured(textured) => textured.has_delta_lobe(),
            _ => false,
        });
        let parametrised = nesting::parametrised(&materials);
        let albedo = |material: &Material| match material {
            Material::Plain(bsdf) => bsdf.albedo(),
            _ => Rgb::ZERO,
        };
        Self {
            albedos: materials.iter().map(albedo).collect(),
            for_lanes: nesting::for_lanes(&materials, &parametrised),
            parametrised,
            materials,
            tables,
            has_null_lobe: clear.contains(&true),
            clear,
            has_delta_lobe,
        }
    }

    /// The same table with more materials, whose ids continue from [`Self::len`].
    pub fn with(&self, more: impl IntoIterator<Item = Material>) -> Result<Self, MaterialTableError> {
        let materials = self.materials.iter().cloned().chain(more).collect();
        Self::with_tables(materials, self.tables.clone())
    }

    /// The number of materials, nested ones included.
    pub fn len(&self) -> usize {
        self.materials.len()
    }

    /// The tables to which the models of the materials refer.
    pub(crate) fn tables(&self) -> &ShadingTables {
        &self.tables
    }

    /// Whether there is no material.
    pub fn is_empty(&self) -> bool {
        self.materials.is_empty()
    }

    /// Returns the material of an id; None for an id of another table.
    pub fn get(&self, id: MaterialId) -> Option<&Material> {
        self.materials.get(id.0 as usize)
    }

    /// Whether light may pass straight through any material, so that shadow rays have to evaluate their hits.
    pub fn has_null_lobe(&self) -> bool {
        self.has_null_lobe
    }

    /// Whether light may pass straight through the material somewhere.
    pub(crate) fn is_clear(&self, id: MaterialId) -> bool {
        self.clear[id.0 as usize]
    }

    /// Whether any material has a delta lobe, as mirrors and glass have.
    pub fn has_delta_lobe(&self) -> bool {
        self.has_delta_lobe
    }

    /// Whether the material is invisible: light passes as if there were no surface.
    pub(crate) fn is_null(&self, id: MaterialId) -> bool {
        matches!(self.materials.get(id.0 as usize), Some(Material::Null))
    }

    /// The detail of a surface point that [`Self::scattering`] needs for this material.
    pub(crate) fn detail(&self, id: MaterialId) -> Detail {
        match self.parametrised[id.0 as usize] {
            true => Detail::Parametrised,
            false => Detail::Plain,
        }
    }

    /// Whether all its models are in [`crate::shading::lanes`], chosen only by the side seen.
    pub(crate) fn is_for_lanes(&self, id: MaterialId) -> bool {
        self.for_lanes[id.0 as usize]
    }

    /// The model of a surface, where `cos` is the cosine of the direction to the viewer. None for materials other than
    /// plain and two-sided ones.
    #[inline(always)]
    pub fn plain(&self, mut id: MaterialId, cos: f32) -> Option<PlainSide<'_>> {
        let mut side = 1.0;
        loop {
            match self.materials.get(id.0 as usize)? {
                Material::Plain(bsdf) => {
                    let albedo = self.albedos[id.0 as usize];
                    return Some(PlainSide { bsdf, albedo, side });
                }
                Material::TwoSided { front, .. } if cos * side > 0.0 => id = *front,
                Material::TwoSided { back, .. } => (id, side) = (*back, -side),
                _ => return None,
            }
        }
    }

    /// The scattering of the surface at `point` for a path from `wo`, a unit vector in world space. Textures are
    /// evaluated at `at`.
    pub fn scattering(
        &self,
        id: MaterialId,
        point: &SurfacePoint,
        wo: Vec3,
        mode: TransportMode,
        textures: &TextureTable,
        at: &TexturePoint,
    ) -> Scattering<'_> {
        nesting::resolve(&self.materials, &self.tables, id, point, wo, mode, textures, at)
    }

    /// The only model of [`Self::scattering`], if it is cheap to find; None for mixtures, normal maps, and models
    /// through which light passes straight.
    pub(crate) fn single(
        &self,
        id: MaterialId,
        point: &SurfacePoint,
        wo: Vec3,
        mode: TransportMode,
        textures: &TextureTable,
        at: &TexturePoint,
    ) -> Option<Single<'_>> {
        nesting::single(&self.materials, &self.tables, id, point, wo, mode, textures, at)
    }
}
