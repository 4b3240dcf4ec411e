//! Resolves materials inside materials: checks the nesting, and evaluates it at a surface point.

use std::borrow::Cow;

use glam::Vec3;

use super::bump::{Bump, BumpOptions, Orientation, displaced_normal};
use super::definition::{Material, MaterialId};
use super::scattering::{LARGEST_MIX, Part, Scattering, Single};
use super::tangents;
use crate::accel::SurfacePoint;
use crate::shading::lanes::BsdfLanes;
use crate::shading::{Bsdf, ShadingTables, TransportMode};
use crate::texture::{Parameter, TexturePoint, TextureTable};

/// The greatest depth of nested materials; the stack is finite.
const DEEPEST: usize = 64;

/// The most nested normal and bump maps. Each doubles the number of models that a path from a lamp has to consider.
const DEEPEST_MAPS: usize = 8;

/// The reason why a list of materials is not a valid table.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("material {place} {problem}")]
pub struct MaterialTableError {
    /// The index of the material in the list.
    pub place: usize,
    /// The problem of the material.
    pub problem: NestingProblem,
}

/// The problem with the materials or tables that a material refers to.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[allow(missing_docs, reason = "the messages say what the variants mean")]
pub enum NestingProblem {
    #[error("refers to number {0}, but there are only {1}")]
    OutOfRange(u32, usize),
    #[error("contains itself, or others nested deeper than {DEEPEST}")]
    TooDeep,
    #[error("holds more than {DEEPEST_MAPS} normal or bump maps inside each other")]
    TooManyMaps,
    #[error("mixes more than {LARGEST_MIX} others")]
    TooManyParts,
    #[error("refers to a table of its model that is not there")]
    NoTable,
}

impl Material {
    fn nested(&self) -> [Option<MaterialId>; 2] {
        match *self {
            Self::Plain(_) | Self::Textured(_) | Self::Null => [None, None],
            Self::TwoSided { front, back } => [Some(front), Some(back)],
            Self::Blend { first, second, .. } => [Some(first), Some(second)],
            Self::Mask { nested, .. } | Self::NormalMap { nested, .. } | Self::BumpMap { nested, .. } => {
                [Some(nested), None]
            }
        }
    }
}

pub(super) fn check(materials: &[Material], tables: &ShadingTables) -> Result<(), MaterialTableError> {
    let mut known = vec![None; materials.len()];
    let mut known_maps = vec![None; materials.len()];
    for place in 0..materials.len() {
        let error = |problem| MaterialTableError { place, problem };
        for nested in materials[place].nested().into_iter().flatten() {
            if nested.0 as usize >= materials.len() {
                return Err(error(NestingProblem::OutOfRange(nested.0, materials.len())));
            }
        }
        let parts = count_parts(materials, place, &mut known, 0).ok_or(error(NestingProblem::TooDeep))?;
        if parts > LARGEST_MIX {
            return Err(error(NestingProblem::TooManyParts));
        }
        if count_maps(materials, place, &mut known_maps) > DEEPEST_MAPS {
            return Err(error(NestingProblem::TooManyMaps));
        }
        let has_tables = match &materials[place] {
            Material::Plain(bsdf) => bsdf.has_its_tables(tables),
            Material::Textured(textured) => textured.has_its_tables(tables),
            _ => true,
        };
        if !has_tables {
            return Err(error(NestingProblem::NoTable));
        }
    }
    Ok(())
}

/// Whether each material depends on the surface's texture coordinates or tangents.
pub(super) fn parametrised(materials: &[Material]) -> Vec<bool> {
    where_any_is(materials, is_parametrised)
}

/// Whether light may pass straight through each material somewhere.
pub(super) fn clear(materials: &[Material]) -> Vec<bool> {
    where_any_is(materials, |material| match material {
        Material::Mask { .. } | Material::Null => true,
        Material::Plain(bsdf) => bsdf.has_null_lobe(),
        Material::Textured(textured) => textured.has_null_lobe(),
        _ => false,
    })
}

/// Whether `is_so` holds for each material, or for one nested in it.
fn where_any_is(materials: &[Material], is_so: impl Fn(&Material) -> bool) -> Vec<bool> {
    let mut found: Vec<bool> = materials.iter().map(is_so).collect();
    loop {
        let mut is_settled = true;
        for (place, material) in materials.iter().enumerate() {
            let mut nested = material.nested().into_iter().flatten();
            if !found[place] && nested.any(|nested| found[nested.0 as usize]) {
                (found[place], is_settled) = (true, false);
            }
        }
        if is_settled {
            return found;
        }
    }
}

/// Whether lanes can shade each material, see [`super::MaterialTable::is_for_lanes`].
pub(super) fn for_lanes(materials: &[Material], parametrised: &[bool]) -> Vec<bool> {
    let is_known = |material: &Material| matches!(material, Material::Plain(bsdf) if BsdfLanes::knows(bsdf));
    let mut found: Vec<bool> = materials.iter().map(is_known).collect();
    loop {
        let mut is_settled = true;
        for (place, material) in materials.iter().enumerate() {
            if let Material::TwoSided { front, back } = material
                && !found[place]
                && found[front.0 as usize]
                && found[back.0 as usize]
            {
                (found[place], is_settled) = (true, false);
            }
        }
        if is_settled {
            return found
                .iter()
                .zip(parametrised)
                .map(|(known, by_uv)| *known && !by_uv)
                .collect();
        }
    }
}

/// Whether the material itself, without nested ones, depends on texture coordinates or tangents.
fn is_parametrised(material: &Material) -> bool {
    match material {
        Material::Plain(bsdf) => !bsdf.is_isotropic(),
        Material::TwoSided { .. } | Material::Null => false,
        Material::Blend { weight, .. } => matches!(weight, Parameter::Texture(_)),
        Material::Mask { opacity, .. } => matches!(opacity, Parameter::Texture(_)),
        Material::Textured(_) | Material::NormalMap { .. } | Material::BumpMap { .. } => true,
    }
}

/// The most models that a material resolves to; None if it is nested too deep.
fn count_parts(materials: &[Material], index: usize, known: &mut [Option<usize>], depth: usize) -> Option<usize> {
    if depth > DEEPEST {
        return None;
    }
    if known[index].is_none() {
        let mut counts = [0; 2];
        for (count, nested) in counts.iter_mut().zip(materials[index].nested()) {
            // A reference out of range is an error of its own.
            if let Some(nested) = nested.filter(|nested| (nested.0 as usize) < materials.len()) {
                *count = count_parts(materials, nested.0 as usize, known, depth + 1)?;
            }
        }
        known[index] = Some(match materials[index] {
            Material::Plain(_) | Material::Textured(_) => 1,
            Material::TwoSided { .. } => counts[0].max(counts[1]),
            _ => counts[0] + counts[1],
        });
    }
    known[index]
}

/// The most nested maps whose normals may turn. The material must not be nested too deep.
fn count_maps(materials: &[Material], index: usize, known: &mut [Option<usize>]) -> usize {
    if let Some(count) = known[index] {
        return count;
    }
    let nested = materials[index].nested().into_iter().flatten();
    // A reference out of range is an error of its own.
    let inside = nested
        .filter(|nested| (nested.0 as usize) < materials.len())
        .map(|nested| count_maps(materials, nested.0 as usize, known))
        .max();
    let own = match &materials[index] {
        Material::NormalMap { options, .. } | Material::BumpMap { options, .. } => options.flip_invalid_normals,
        _ => false,
    };
    let count = inside.unwrap_or(0) + usize::from(own);
    known[index] = Some(count);
    count
}

/// Resolves the material `id` at a surface point.
pub(super) fn resolve<'a>(
    materials: &'a [Material],
    tables: &'a ShadingTables,
    id: MaterialId,
    point: &SurfacePoint,
    wo: Vec3,
    mode: TransportMode,
    textures: &TextureTable,
    at: &TexturePoint,
) -> Scattering<'a> {
    // The value is large, so it is built in place.
    let mut scattering = Scattering::new(wo, mode, tables);
    let upright = upright(point);
    let mut resolver = Resolver {
        materials,
        point,
        wo,
        textures,
        at,
        scattering: &mut scattering,
    };
    resolver.add(id, 1.0, upright, None);
    scattering
}

/// [`resolve`] for a material that has one model about the surface's own normal on each side; None for any other.
#[expect(clippy::too_many_arguments, reason = "those of `resolve`")]
pub(super) fn single<'a>(
    materials: &'a [Material],
    tables: &'a ShadingTables,
    mut id: MaterialId,
    point: &SurfacePoint,
    wo: Vec3,
    mode: TransportMode,
    textures: &TextureTable,
    at: &TexturePoint,
) -> Option<Single<'a>> {
    let mut orientation = upright(point);
    let bsdf = loop {
        match &materials[id.0 as usize] {
            Material::Plain(bsdf) => break Cow::Borrowed(bsdf),
            Material::Textured(textured) => break Cow::Owned(textured.at(textures, at)),
            Material::TwoSided { front, back } => (id, orientation) = side_seen([*front, *back], wo, orientation),
            _ => return None,
        }
    };
    let part = Part {
        share: 1.0,
        weight: 1.0,
        wo: orientation.to_local(wo),
        orientation,
        bump: None,
        bsdf,
    };
    Single::of(part, wo, mode, tables)
}

fn upright(point: &SurfacePoint) -> Orientation {
    Orientation {
        frame: point.shading_frame(),
        side: 1.0,
        is_of_one_side: false,
    }
}

/// The material of the side that is seen from `wo`, front or back, with the orientation of that side.
fn side_seen([front, back]: [MaterialId; 2], wo: Vec3, orientation: Orientation) -> (MaterialId, Orientation) {
    let is_before = orientation.to_local(wo).z > 0.0;
    let (seen, side) = if is_before { (front, 1.0) } else { (back, -1.0) };
    let orientation = Orientation {
        side: side * orientation.side,
        is_of_one_side: true,
        ..orientation
    };
    (seen, orientation)
}

struct Resolver<'a, 'b> {
    materials: &'a [Material],
    point: &'b SurfacePoint,
    wo: Vec3,
    textures: &'b TextureTable,
    at: &'b TexturePoint<'b>,
    scattering: &'b mut Scattering<'a>,
}

impl<'a> Resolver<'a, '_> {
    fn add(&mut self, id: MaterialId, weight: f32, orientation: Orientation, bump: Option<&Bump>) {
        if weight <= 0.0 {
            return;
        }
        let materials = self.materials;
        match &materials[id.0 as usize] {
            Material::Plain(bsdf) => self.push(Cow::Borrowed(bsdf), weight, orientation, bump),
            Material::Textured(textured) => {
                let bsdf = textured.at(self.textures, self.at);
                self.push(Cow::Owned(bsdf), weight, orientation, bump);
            }
            Material::TwoSided { front, back } => {
                let (seen, orientation) = side_seen([*front, *back], self.wo, orientation);
                self.add(seen, weight, orientation, bump);
            }
            Material::Blend {
                first,
                second,
                weight: share,
            } => {
                let share = self.textures.float(*share, self.at).clamp(0.0, 1.0);
                self.add(*first, weight * (1.0 - share), orientation, bump);
                self.add(*second, weight * share, orientation, bump);
            }
            Material::Mask { nested, opacity } => {
                let opacity = self.textures.float(*opacity, self.at).clamp(0.0, 1.0);
                self.add_null(weight * (1.0 - opacity), bump);
                self.add(*nested, weight * opacity, orientation, bump);
            }
            Material::NormalMap {
                nested,
                normals,
                gltf_tangents,
                options,
            } => {
                let mut normal = 2.0 * self.textures.color(*normals, self.at) - Vec3::ONE;
                if *gltf_tangents {
                    normal = tangents::in_frame(normal, self.point, &orientation.frame, self.at.mesh);
                }
                self.add_bumped(*nested, weight, orientation, bump, normal, *options);
            }
            Material::BumpMap {
                nested,
                height,
                scale,
                options,
            } => {
                let gradient = *scale * self.textures.gradient(*height, self.at);
                let normal = displaced_normal(self.point, orientation.frame, gradient);
                self.add_bumped(*nested, weight, orientation, bump, normal, *options);
            }
            Material::Null => self.add_null(weight, bump),
        }
    }

    /// Adds a bumped material. `normal` is in the frame of `below`, the orientation of the surface below the map.
    ///
    /// A path from the camera knows its viewer, which decides on the side of the normal. A path from a lamp does not
    /// know it yet, so it gets both normals.
    fn add_bumped(
        &mut self,
        nested: MaterialId,
        weight: f32,
        below: Orientation,
        outer: Option<&Bump>,
        normal: Vec3,
        options: BumpOptions,
    ) {
        let Some((bumped, bump)) = Bump::new(normal, false, below, outer, options) else {
            return self.add(nested, weight, below, outer);
        };
        let turned = || Bump::new(normal, true, below, outer, options);
        match self.scattering.mode() {
            TransportMode::Radiance => {
                let turned = if bump.turns_for(self.wo) { turned() } else { None };
                let (bumped, bump) = turned.unwrap_or((bumped, bump));
                self.add(nested, weight, bumped, Some(&bump));
            }
            TransportMode::Importance => {
                let other = if bump.may_turn() { turned() } else { None };
                for (bumped, bump) in [Some((bumped, bump)), other].into_iter().flatten() {
                    if bump.chance(self.wo) > 0.0 {
                        self.add(nested, weight, bumped, Some(&bump));
                    }
                }
            }
        }
    }

    /// The probability that a path is scattered by these normals.
    fn chance(&self, bump: Option<&Bump>) -> f32 {
        match (self.scattering.mode(), bump) {
            (TransportMode::Importance, Some(bump)) => bump.chance(self.wo),
            _ => 1.0,
        }
    }

    fn add_null(&mut self, share: f32, bump: Option<&Bump>) {
        let chance = self.chance(bump);
        self.scattering.add_null_lobe(share * chance);
    }

    fn push(&mut self, bsdf: Cow<'a, Bsdf>, share: f32, orientation: Orientation, bump: Option<&Bump>) {
        self.scattering.push(Part {
            share,
            weight: share * self.chance(bump),
            wo: orientation.to_local(self.wo),
            orientation,
            bump: bump.cloned(),
            bsdf,
        });
    }
}
