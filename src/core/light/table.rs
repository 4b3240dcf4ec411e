//! The table of all lights of a scene.
//!
//! A scene's only light, for sixteen surfaces at once.

use std::sync::Arc;

use glam::{Vec2, Vec3};

use super::choice::{Chosen, LightChoice};
use super::constant::ConstantLight;
use super::directional::DirectionalLight;
use super::emission_choice::EmissionChoice;
use super::environment::EnvironmentLight;
use super::finite::FiniteLight;
use super::infinite::InfiniteLight;
use super::luminaire::LuminaireLight;
use super::point::PointLight;
use super::portal::{Portal, Portals, Rooms};
use super::projector::ProjectorLight;
use super::reference::Reference;
use super::spot::SpotLight;
use super::sun_sky::SunSkyLight;
use super::surface::SurfaceLight;
use super::{LightId, LightReference, LightSample, LightSource, ReferenceLanes, SurfaceHit, WeightedSource};
use crate::accel::{Primitive, Tlas};
use crate::color::Rgb;
use crate::light::plain::{Glow, PlainSurface};
use crate::light::rectangle::UniformRectangle;
use crate::math::lanes::{LANES, Lanes, Vec3Lanes};
use crate::math::{Aabb, Real, Same};
use crate::sampling::hash::pcg3d;
use crate::texture::TextureTable;

mod chosen;
mod emitting;

pub(crate) use self::chosen::Alike;

/// The place of a source's light in the tables.
#[derive(Clone, Copy, Debug)]
enum Place {
    /// Index into the finite lights.
    Finite(u32),
    /// Index into the infinite lights.
    Infinite(u32),
    /// A source without area.
    Nowhere,
}

/// A finite light and the range of its parts in the list of parts.
#[derive(Clone, Debug)]
struct Finite {
    id: LightId,
    light: FiniteLight,
    first_part: u32,
}

/// The lights in the order of their sources.
#[derive(Clone, Debug, Default)]
pub struct LightTable {
    /// The indices by [`LightId`].
    places: Vec<Place>,
    finite: Vec<Finite>,
    infinite: Vec<(LightId, InfiniteLight)>,
    /// The portals of the lights at infinity; none where they do not help.
    portals: Vec<Option<Portals>>,
    /// The portals that they were chosen from.
    all_portals: Arc<[Portal]>,
    /// The light of each part of all finite lights.
    light_of_part: Vec<u32>,
    choice: LightChoice,
    emission: EmissionChoice,
    textures: Arc<TextureTable>,
    /// The lights that a ray sees where it hits nothing.
    seen_at_infinity: Vec<LightId>,
    /// The instances of which all parts emit, ascending, with their bounds.
    lamps: Vec<(u32, Aabb)>,
    /// The box around all finite lights.
    finite_bounds: Option<Aabb>,
    /// Whether lights are textured, by [`LightId`]; see [`Self::is_textured`].
    textured: Vec<bool>,
}

impl LightTable {
    /// Builds the table. It has to be rebuilt when the geometry of emitting surfaces changes, and for textured sources
    /// when the textures do.
    pub fn build(sources: &[WeightedSource], geometry: &Tlas, textures: &Arc<TextureTable>) -> Self {
        let mut table = Self {
            textures: textures.clone(),
            textured: sources.iter().map(|weighted| weighted.source.is_textured()).collect(),
            ..Self::default()
        };
        let (mut part_bounds, mut infinite_weights) = (Vec::new(), Vec::new());
        // The instances with the number of their parts that emit.
        let mut shining: Vec<(u32, u32)> = Vec::new();
        for (id, weighted) in (0..).map(LightId).zip(sources) {
            let place = match Self::light(&weighted.source, geometry, textures) {
                None => Place::Nowhere,
                Some(Light::Finite(light)) => {
                    if let LightSource::Surface { instance, .. } = weighted.source {
                        shining.push((instance, light.parts()));
                    }
                    let first_part = table.light_of_part.len() as u32;
                    let index = table.finite.len() as u32;
                    for part in 0..light.parts() {
                        table.light_of_part.push(index);
                        let bounds = light.bounds(part);
                        table.finite_bounds = Some(bounds.bounds.union(table.finite_bounds.unwrap_or(Aabb::EMPTY)));
                        part_bounds.push(bounds.weighted(weighted.sampling_weight));
                    }
                    table.finite.push(Finite { id, light, first_part });
                    Place::Finite(index)
                }
                Some(Light::Infinite(light)) => {
                    if light.is_seen() {
                        table.seen_at_infinity.push(id);
                    }
                    infinite_weights.push(weighted.sampling_weight * light.irradiance());
                    table.infinite.push((id, light));
                    Place::Infinite(table.infinite.len() as u32 - 1)
                }
            };
            table.places.push(place);
        }
        shining.sort_unstable();
        table.lamps = (shining.chunk_by(|one, other| one.0 == other.0))
            .map(|slots| (slots[0].0, slots.iter().map(|slot| slot.1).sum()))
            .filter(|&(instance, parts)| shines_whole(geometry, instance, parts))
            .filter_map(|(instance, _)| Some((instance, geometry.bounds_of(instance)?)))
            .collect();
        table.choice = LightChoice::new(&part_bounds, &infinite_weights);
        table.emission = EmissionChoice::new(&part_bounds, &infinite_weights);
        table
    }

    /// The table with portals in place of those that it has: directions to lights at infinity are sampled through them
    /// at places where that makes less noise, which rays through the scene tell. `is_clear` is true for shapes that
    /// light may pass straight through, by their numbers of [`Tlas::shape_index`].
    pub fn with_portals(mut self, portals: &Arc<[Portal]>, geometry: &Tlas, is_clear: impl Fn(usize) -> bool) -> Self {
        self.portals.clear();
        self.all_portals = portals.clone();
        if !portals.is_empty() && !self.seen_at_infinity.is_empty() {
            let rooms = Rooms::new(portals, geometry, &is_clear);
            self.portals = self.infinite.iter().map(|(_, light)| rooms.portals_of(light)).collect();
        }
        self
    }

    /// The portals of [`Self::with_portals`].
    pub(crate) fn all_portals(&self) -> &Arc<[Portal]> {
        &self.all_portals
    }

    /// The light at infinity of this index, with its portals.
    fn at_index(&self, index: u32) -> (LightId, &InfiniteLight, Option<&Portals>) {
        let (id, light) = &self.infinite[index as usize];
        let portals = self.portals.get(index as usize).and_then(Option::as_ref);
        (*id, light, portals)
    }

    /// Prepares a light; None for a surface without area.
    fn light(source: &LightSource, geometry: &Tlas, textures: &TextureTable) -> Option<Light> {
        Some(match *source {
            LightSource::Surface {
                instance,
                slot,
                radiance,
                is_two_sided,
            } => Light::Finite(FiniteLight::Surface(SurfaceLight::new(
                geometry,
                (instance, slot),
                radiance,
                is_two_sided,
                textures,
            )?)),
            LightSource::Point { position, intensity } => {
                Light::Finite(FiniteLight::Point(PointLight { position, intensity }))
            }
            LightSource::Directional { direction, irradiance } => {
                Light::Infinite(InfiniteLight::Directional(DirectionalLight { direction, irradiance }))
            }
            LightSource::Spot(spot) => Light::Finite(FiniteLight::Spot(SpotLight::new(spot, textures))),
            LightSource::Luminaire(ref luminaire) => {
                Light::Finite(FiniteLight::Luminaire(LuminaireLight::new(luminaire)))
            }
            LightSource::Projector(projector) => {
                Light::Finite(FiniteLight::Projector(ProjectorLight::new(projector, textures)))
            }
            LightSource::Constant { radiance } => Light::Infinite(InfiniteLight::Constant(ConstantLight { radiance })),
            LightSource::Environment {
                ref map,
                world_from_local,
                scale,
            } => Light::Infinite(InfiniteLight::Environment(EnvironmentLight {
                map: map.clone(),
                world_from_local,
                scale,
            })),
            LightSource::SunSky {
                atmosphere,
                world_from_local,
            } => {
                let light = SunSkyLight::new(atmosphere, world_from_local);
                Light::Infinite(InfiniteLight::SunSky(Box::new(light)))
            }
        })
    }

    /// The number of lights; ids are below it.
    pub fn len(&self) -> usize {
        self.places.len()
    }

    /// Whether the scene is without lights.
    pub fn is_empty(&self) -> bool {
        self.places.is_empty()
    }

    /// Whether the light is a projector.
    pub fn is_projector(&self, id: LightId) -> bool {
        self.finite(id)
            .is_some_and(|finite| matches!(finite.light, FiniteLight::Projector(_)))
    }

    /// Whether the light has a texture; that of a surface is then looked up by texture coordinates.
    pub fn is_textured(&self, id: LightId) -> bool {
        self.textured[id.0 as usize]
    }

    /// Chooses a light by `u_choice`, then a direction to it by `u`. None where the chosen light does not reach
    /// `reference`.
    pub fn sample(&self, reference: &LightReference, u_choice: f32, u: Vec2) -> Option<(LightId, LightSample)> {
        let choice = self.choose(reference, u_choice, u)?;
        let (id, sample) = self.sample_chosen::<f32>(choice, &reference.into(), u.to_array());
        let sample = sample.if_lit()?;
        debug_assert!(
            sample.wi.is_normalized() && sample.radiance.is_finite(),
            "{id:?} is sampled as {sample:?} from {reference:?}"
        );
        Some((id, sample))
    }

    /// Chooses a light as [`Self::sample`] does, and returns the probability of the choice.
    fn choose(&self, reference: &LightReference, u_choice: f32, u: Vec2) -> Option<(Chosen, f32)> {
        debug_assert!(
            reference.normal.is_none_or(|normal| normal.is_normalized()),
            "{reference:?} has a normal that is not of unit length"
        );
        self.choice.sample(reference, || refined(u_choice, u))
    }

    /// Directions to a light as of [`Self::sample`], in the lanes that have chosen it, with the probabilities `pmf`.
    #[inline(always)]
    fn sample_chosen<R: Real>(
        &self,
        (chosen, pmf): (Chosen, R),
        from: &Reference<R>,
        u: [R; 2],
    ) -> (LightId, LightSample<R>) {
        let (id, sample) = match chosen {
            Chosen::Part(part) => {
                let finite = self.finite_of(part);
                let part = part - finite.first_part;
                (finite.id, finite.light.sample(part, from, u, &self.textures))
            }
            Chosen::Infinite(index) => {
                let (id, light, portals) = self.at_index(index);
                (id, light.sample_with(portals, from, u))
            }
        };
        let pdf = (pmf * sample.pdf).only(from.asked);
        (id, LightSample { pdf, ..sample })
    }

    /// A point on a light that is chosen as [`Self::sample`] does; None if the light is at infinity. It is a cheap hint
    /// without a density.
    pub(crate) fn sample_place(&self, reference: &LightReference, u_choice: f32, u: Vec2) -> Option<Vec3> {
        let Chosen::Part(part) = self.choice.sample(reference, || refined(u_choice, u))?.0 else {
            return None;
        };
        let finite = self.finite_of(part);
        Some(finite.light.sample_place(part - finite.first_part, u))
    }

    /// The box around all finite lights; None if there are none.
    pub(crate) fn finite_bounds(&self) -> Option<Aabb> {
        self.finite_bounds
    }

    /// Radiance that light `id` sends along the unit vector `wo` from a point of its surface.
    pub fn emitted(&self, id: LightId, hit: &SurfaceHit, wo: Vec3) -> Rgb {
        debug_assert!(wo.is_normalized(), "{wo} is not of unit length");
        let radiance = self
            .finite(id)
            .map_or(Rgb::ZERO, |finite| finite.light.emitted(hit, wo, &self.textures));
        debug_assert!(radiance.is_finite(), "{id:?} emits {radiance} along {wo} at {hit:?}");
        radiance
    }

    /// The density with which [`Self::sample`] gives the direction from `reference` to this point of light `id`.
    pub fn pdf_of_hit(&self, id: LightId, reference: &LightReference, hit: &SurfaceHit) -> f32 {
        let Some(finite) = self.finite(id) else {
            return 0.0;
        };
        let Some(part) = finite.light.part_of(hit) else {
            return 0.0;
        };
        match self.choice.pmf(reference, Chosen::Part(finite.first_part + part)) {
            0.0 => 0.0,
            pmf => pmf * finite.light.pdf(part, reference, hit),
        }
    }

    /// The lights that a ray sees when it leaves the scene.
    pub fn infinite(&self) -> &[LightId] {
        &self.seen_at_infinity
    }

    /// Radiance of infinite light `id` arriving against the direction `wi`.
    pub fn radiance_from(&self, id: LightId, wi: Vec3) -> Rgb {
        debug_assert!(wi.is_normalized(), "{wi} is not of unit length");
        let radiance = self.at_infinity(id).map_or(Rgb::ZERO, |(_, light)| light.radiance(wi));
        debug_assert!(radiance.is_finite(), "{id:?} sends {radiance} from {wi}");
        radiance
    }

    /// Whether the direction `wi` leads to the sun of a light that is sky and sun.
    pub fn is_sun(&self, id: LightId, wi: Vec3) -> bool {
        self.at_infinity(id).is_some_and(|(_, light)| light.is_sun(wi))
    }

    /// The radiance as [`Self::radiance_from`], and the density with which [`Self::sample`] gives the direction `wi` to
    /// infinite light `id`.
    pub fn radiance_and_pdf_from(&self, id: LightId, reference: &LightReference, wi: Vec3) -> (Rgb, f32) {
        self.at_infinity(id).map_or((Rgb::ZERO, 0.0), |(index, light)| {
            debug_assert!(wi.is_normalized(), "{wi} is not of unit length");
            let (radiance, pdf) = match self.at_index(index).2 {
                None => light.radiance_and_pdf(reference, wi),
                Some(portals) => light.radiance_and_pdf_through(portals, reference, wi),
            };
            debug_assert!(
                radiance.is_finite() && pdf >= 0.0,
                "{id:?} sends {radiance} from {wi} with density {pdf}"
            );
            (radiance, self.choice.pmf(reference, Chosen::Infinite(index)) * pdf)
        })
    }

    fn finite_of(&self, part: u32) -> &Finite {
        &self.finite[self.light_of_part[part as usize] as usize]
    }

    fn finite(&self, id: LightId) -> Option<&Finite> {
        match self.places[id.0 as usize] {
            Place::Finite(index) => Some(&self.finite[index as usize]),
            Place::Infinite(_) | Place::Nowhere => None,
        }
    }

    fn at_infinity(&self, id: LightId) -> Option<(u32, &InfiniteLight)> {
        match self.places[id.0 as usize] {
            Place::Infinite(index) => Some((index, &self.infinite[index as usize].1)),
            Place::Finite(_) | Place::Nowhere => None,
        }
    }
}

/// A light made from its source.
#[expect(clippy::large_enum_variant, reason = "there is one at a time, for a moment")]
enum Light {
    Finite(FiniteLight),
    Infinite(InfiniteLight),
}

/// Whether `parts` emitting parts are all parts of an instance.
fn shines_whole(geometry: &Tlas, instance: u32, parts: u32) -> bool {
    let shape = geometry.instances().get(instance as usize);
    shape.is_some_and(|shape| match &shape.primitive {
        Primitive::Mesh(blas) => blas.mesh().triangles.len() as u64 <= u64::from(parts),
        _ => true,
    })
}

/// `u_choice`, which has 24 random bits, with 29 more bits from a hash of all three numbers: enough to tell millions of
/// lights apart.
fn refined(u_choice: f32, u: Vec2) -> f64 {
    let [bits, ..] = pcg3d([u_choice, u.x, u.y].map(f32::to_bits));
    f64::from(u_choice) + f64::from(bits >> 3) * (1.0 / (1u64 << 53) as f64)
}

/// A bit for every lane.
const ALL: u32 = (1 << LANES) - 1;

/// The commonest lights that a scene has alone.
#[derive(Clone, Copy, Debug)]
pub(crate) enum SoleLight<'a> {
    Rectangle(UniformRectangle, Glow),
    Constant(&'a ConstantLight),
    Sky(Sky<'a>),
}

/// Any other light that is seen at infinity.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Sky<'a> {
    light: &'a InfiniteLight,
    portals: Option<&'a Portals>,
}

impl Sky<'_> {
    /// Not inlined, because each kind of light has its own code.
    #[inline(never)]
    fn sample(&self, from: &Reference<Lanes>, u: [Lanes; 2]) -> LightSample<Lanes> {
        self.light.sample_with(self.portals, from, u)
    }
}

impl LightTable {
    /// The scene's only light, if there is one alone and it can be sampled in lanes.
    pub(crate) fn sole(&self) -> Option<(LightId, SoleLight<'_>)> {
        if !self.choice.is_certain() {
            return None;
        }
        match (&self.finite[..], &self.infinite[..]) {
            ([finite], []) => match &finite.light {
                FiniteLight::Surface(light) => match light.plain()? {
                    PlainSurface::Rectangle(shape, glow) => Some((finite.id, SoleLight::Rectangle(shape, glow))),
                    PlainSurface::Sphere(..) => None,
                },
                _ => None,
            },
            ([], [(id, light)]) if light.is_seen() => match (light, self.at_index(0).2) {
                (InfiniteLight::Constant(light), None) => Some((*id, SoleLight::Constant(light))),
                (light, portals) => Some((*id, SoleLight::Sky(Sky { light, portals }))),
            },
            _ => None,
        }
    }
}

impl SoleLight<'_> {
    /// Directions to the light as of [`LightTable::sample`].
    #[inline(always)]
    pub fn sample(&self, reference: &ReferenceLanes, u: [Lanes; 2]) -> LightSample<Lanes> {
        match self {
            Self::Rectangle(shape, glow) => {
                let point = Same::<Lanes>::same(*shape).sample(reference.position, u);
                Same::<Lanes>::same(*glow).towards(point, reference.position)
            }
            Self::Constant(light) => light.sample(&reference.of_lanes(ALL), u),
            Self::Sky(sky) => sky.sample(&reference.of_lanes(ALL), u),
        }
    }

    /// Places on the light as of [`LightTable::sample_place`]; None if it is at infinity.
    #[inline(always)]
    pub fn place(&self, u: [Lanes; 2]) -> Option<Vec3Lanes> {
        match self {
            Self::Rectangle(shape, _) => Some(Same::<Lanes>::same(*shape).at(u)),
            Self::Constant(_) | Self::Sky(_) => None,
        }
    }
}
