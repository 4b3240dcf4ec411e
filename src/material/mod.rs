//! What surfaces are made of: scattering models whose parameters may be textured, and materials made of other materials.
//!
//! At a hit the table resolves textures and nesting once, into a [`Scattering`]: plain models with the shares they have. Light transport
//! asks that, in world space. Numbers are in range already but for what textures say, which is brought into range here.

mod bump;
mod nesting;
mod principled;
mod scattering;
mod textured;

pub use nesting::{LARGEST_MIX, MaterialTableError, NestingProblem};
pub use principled::{TexturedPrincipled, TexturedPrincipledThin};
pub use scattering::{Lobe, ScatterSample, Scattering, Single};
pub use textured::{TexturedBase, TexturedBsdf, TexturedFacets, TexturedSpecular};

use glam::Vec3;

use crate::accel::{Detail, SurfacePoint};
use crate::color::Rgb;
use crate::shading::Bsdf;
use crate::texture::{Parameter, TexturePoint, TextureTable};

/// An index into a [`MaterialTable`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct MaterialId(pub u32);

/// A material of the scene.
#[derive(Clone, Debug, PartialEq)]
pub enum Material {
    /// The same everywhere.
    Plain(Bsdf),
    Textured(TexturedBsdf),
    /// One material seen from the normal's side and another (or the same, mirrored) from behind.
    TwoSided {
        front: MaterialId,
        back: MaterialId,
    },
    /// `second` with the share `weight`, `first` with the rest.
    Blend {
        first: MaterialId,
        second: MaterialId,
        weight: Parameter<f32>,
    },
    /// `nested` with the share `opacity`; the rest of the light passes through.
    Mask {
        nested: MaterialId,
        opacity: Parameter<f32>,
    },
    /// `nested` about the normals of a texture: n = 2 colour - 1 in the shading frame.
    NormalMap {
        nested: MaterialId,
        normals: Parameter<Rgb>,
        options: BumpOptions,
    },
    /// `nested` about the normals that the surface has once it is moved by `scale` times a texture along its own (Blinn, Simulation of
    /// Wrinkled Surfaces, 1978).
    BumpMap {
        nested: MaterialId,
        height: Parameter<f32>,
        scale: f32,
        options: BumpOptions,
    },
    /// Light passes as if nothing were there.
    Null,
}

/// How shading copes with normals that are not the surface's.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct BumpOptions {
    /// Turn normals that face away from the viewer about the surface's own.
    pub flip_invalid_normals: bool,
    /// Soften the border of light and shadow: Estevez, Lecocq and Stein, A Microfacet-Based Shadowing Function to Solve the Bump
    /// Terminator Problem, Ray Tracing Gems 2019.
    pub use_shadowing_function: bool,
}

impl From<Bsdf> for Material {
    fn from(bsdf: Bsdf) -> Self {
        Self::Plain(bsdf)
    }
}

/// All materials of a scene.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct MaterialTable {
    materials: Vec<Material>,
    /// Whether light can pass straight through any of them.
    lets_through: bool,
    /// Per material.
    parametrised: Vec<bool>,
    /// Per material, see [`Self::is_for_lanes`].
    for_lanes: Vec<bool>,
    /// Per material, black unless it is plain, see [`PlainSide::albedo`].
    albedos: Vec<Rgb>,
}

/// The one model that a surface is made of about its own shading normal.
#[derive(Clone, Copy, Debug)]
pub struct PlainSide<'a> {
    pub bsdf: &'a Bsdf,
    /// [`Bsdf::albedo`].
    pub albedo: Rgb,
    /// From which it is seen: 1, or -1 from behind.
    pub side: f32,
}

impl MaterialTable {
    /// A table whose [`MaterialId`]s are the positions in `materials`. Nested materials must be of the same list, before or after.
    pub fn new(materials: Vec<Material>) -> Result<Self, MaterialTableError> {
        Self::check(&materials)?;
        Ok(Self::checked(materials))
    }

    /// Whether these materials can be a table: nothing is nested that is not there, in itself, or too deep.
    pub fn check(materials: &[Material]) -> Result<(), MaterialTableError> {
        nesting::check(materials)
    }

    /// As [`Self::new`], of materials that have passed [`Self::check`].
    pub fn checked(mut materials: Vec<Material>) -> Self {
        for material in &mut materials {
            if let Material::Textured(textured) = material
                && let Some(bsdf) = textured.if_constant()
            {
                *material = Material::Plain(bsdf);
            }
        }
        let lets_through = materials.iter().any(|material| match material {
            Material::Mask { .. } | Material::Null => true,
            Material::Plain(bsdf) => bsdf.lets_through(),
            Material::Textured(textured) => textured.lets_through(),
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
            lets_through,
        }
    }

    /// The same table with more materials, whose ids go on from [`Self::len`].
    pub fn with(&self, more: impl IntoIterator<Item = Material>) -> Result<Self, MaterialTableError> {
        Self::new(self.materials.iter().cloned().chain(more).collect())
    }

    pub fn len(&self) -> usize {
        self.materials.len()
    }

    pub fn is_empty(&self) -> bool {
        self.materials.is_empty()
    }

    pub fn get(&self, id: MaterialId) -> Option<&Material> {
        self.materials.get(id.0 as usize)
    }

    /// Whether any surface may let light pass straight through, so that shadow rays have to look at what they meet.
    pub fn lets_through(&self) -> bool {
        self.lets_through
    }

    /// What of a surface [`Self::scattering`] has to know.
    pub fn detail(&self, id: MaterialId) -> Detail {
        match self.parametrised[id.0 as usize] {
            true => Detail::Parametrised,
            false => Detail::Plain,
        }
    }

    /// Whether it is made of models that [`crate::shading::lanes`] knows and depends on nothing but the side it is seen from.
    pub fn is_for_lanes(&self, id: MaterialId) -> bool {
        self.for_lanes[id.0 as usize]
    }

    /// What a surface is made of, where `cos` is the cosine of the direction it is seen from. None if it is not as simple as that.
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

    /// How the surface at `point` scatters light to `wo`, a unit vector in world space. `at` is where its textures are looked up.
    pub fn scattering(
        &self,
        id: MaterialId,
        point: &SurfacePoint,
        wo: Vec3,
        textures: &TextureTable,
        at: &TexturePoint,
    ) -> Scattering<'_> {
        nesting::resolve(&self.materials, id, point, wo, textures, at)
    }
}
