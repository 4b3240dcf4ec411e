//! The tables that models refer to by index. They are part of a scene, as flat lists without pointers, so that they can
//! be copied to another device unchanged.

use super::MicrofacetKind;
use super::microalbedo::{self, Microalbedo};
use super::rough_coat::{self, CoatKey, CoatLayer, CoatThere};
use crate::math::lanes::WordLanes;
use crate::math::{LanesOf, Real, Word};
use std::collections::HashMap;

/// An index into the coats of [`ShadingTables`], or one per lane.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct CoatId<W = u32>(pub W);

impl LanesOf<CoatId> for CoatId<WordLanes> {
    #[inline(always)]
    fn splat(one: CoatId) -> Self {
        Self(LanesOf::splat(one.0))
    }

    #[inline(always)]
    fn set_lane(&mut self, lane: usize, one: CoatId) {
        self.0.set_lane(lane, one.0);
    }
}

/// An index into the micro-albedos of [`ShadingTables`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct MicroalbedoId(pub u32);

/// A rough coat, with `layer_count` layers of the list from `first_layer` on.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Coat {
    kind: MicrofacetKind,
    eta: f32,
    first_layer: u32,
    layer_count: u32,
}

/// The tabulated data of scattering models: transmittances of rough coats, albedos of rough mirrors. The same requests
/// in the same order give equal tables.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ShadingTables {
    coats: Vec<Coat>,
    /// The layers of all coats, adjacent for each coat.
    layers: Vec<CoatLayer>,
    microalbedos: Vec<Microalbedo>,
    /// An index of the existing coats.
    coat_ids: HashMap<CoatKey, CoatId>,
    microalbedo_ids: HashMap<MicrofacetKind, MicroalbedoId>,
}

impl ShadingTables {
    /// The coat of constant roughness with the refractive index `eta` relative to the outside, above 0. It is added if
    /// missing.
    pub fn uniform_coat(&mut self, kind: MicrofacetKind, eta: f32, alpha: f32) -> CoatId {
        self.coat_of(CoatKey::new(kind, eta, Some(alpha)))
    }

    /// The coat for any roughness between 0 and 1 (clamped at 1). It is added if missing.
    pub fn varying_coat(&mut self, kind: MicrofacetKind, eta: f32) -> CoatId {
        self.coat_of(CoatKey::new(kind, eta, None))
    }

    fn coat_of(&mut self, key: CoatKey) -> CoatId {
        *self.coat_ids.entry(key).or_insert_with(|| {
            let layers = rough_coat::layers(key);
            self.coats.push(Coat {
                kind: key.kind,
                eta: key.eta(),
                first_layer: self.layers.len() as u32,
                layer_count: layers.len() as u32,
            });
            self.layers.extend_from_slice(&layers);
            CoatId(self.coats.len() as u32 - 1)
        })
    }

    /// The micro-albedo of a distribution. It is added if missing.
    pub fn microalbedo_of(&mut self, kind: MicrofacetKind) -> MicroalbedoId {
        *self.microalbedo_ids.entry(kind).or_insert_with(|| {
            self.microalbedos.push(microalbedo::of(kind).clone());
            MicroalbedoId(self.microalbedos.len() as u32 - 1)
        })
    }

    /// Whether the coat exists.
    pub(crate) fn has_coat(&self, id: CoatId) -> bool {
        (id.0 as usize) < self.coats.len()
    }

    /// Whether the micro-albedo exists.
    pub(crate) fn has_microalbedo(&self, id: MicroalbedoId) -> bool {
        (id.0 as usize) < self.microalbedos.len()
    }

    /// A coat at the roughness `alpha`, which only matters if the coat's roughness varies.
    #[inline(always)]
    pub(super) fn coat<R: Real>(&self, coat: R::Word, alpha: R) -> CoatThere<'_, R> {
        let of_coat = |get: &dyn Fn(&Coat) -> f32| R::gather(coat, |coat| get(&self.coats[coat]));
        // The layers' numbers are below 2^24, so that floats hold them exactly.
        let (first, count) = (
            of_coat(&|coat| coat.first_layer as f32),
            of_coat(&|coat| coat.layer_count as f32),
        );
        let place = alpha.saturated().sqrt() * (count - R::ONE);
        let low = place.floor();
        let high = (low + R::ONE).min(count - R::ONE);
        CoatThere {
            is_beckmann: !of_coat(&|coat| f32::from(coat.kind == MicrofacetKind::Beckmann)).equals(R::ZERO),
            eta: of_coat(&|coat| coat.eta),
            layers: &self.layers,
            low: (first + low).whole(),
            high: (first + high).whole(),
            between: place - low,
        }
    }

    /// The micro-albedo from the table `table`, at the row position `row` of [`microalbedo::row_of`], for a viewer at
    /// the cosine `cos` in [0, 1].
    #[inline(always)]
    pub(super) fn microalbedo<R: Real>(&self, table: R::Word, row: R, cos: R) -> R {
        let size = R::Word::splat(microalbedo::NODES as u32);
        microalbedo::albedo(row, cos, |node| {
            let place = table * size + node;
            // Lanes that are not in use may have any index.
            R::gather(place, |place| {
                let table = self.microalbedos.get(place / microalbedo::NODES);
                table.map_or(0.0, |table| table.node(place % microalbedo::NODES))
            })
        })
    }
}
