//! Participating media: the matter between surfaces, and how it absorbs, scatters and emits light (PBR 4th ed.,
//! chapters 11 and 14; Novák et al., Monte Carlo Methods for Volumetric Light Transport Simulation, 2018).
//!
//! A medium is described by its extinction coefficient `sigma_t` (per unit of length), its single-scattering `albedo`,
//! the radiance `emission` that a unit of length adds, and a [`Phase`] function. Each of the first three is a
//! [`Volume`]: constant or a grid.
//!
//! In homogeneous media distances and transmittances have formulas (`uniform.rs`). Otherwise they are found by
//! null-collision tracking against a grid of majorants (`tracking.rs`, `majorants.rs`). [`Medium::travel`] and
//! [`Medium::transmit`] choose between both. Surfaces name the media on their sides by a [`MediumInterface`].

mod equiangular;
mod grid;
mod majorants;
mod optical_depth;
mod phase;
mod tabulated_phase;
mod tracking;
mod uniform;
pub mod vdb;
mod vol_file;
mod volume;

pub use grid::{GridError, Mended, VolumeGrid, Voxels};
pub use majorants::Limited;
pub(crate) use phase::PlainPhase;
pub use phase::{BlendedPhase, Phase};
pub use tabulated_phase::TabulatedPhase;
pub(crate) use uniform::{PlainMedium, Uniform};
pub use vol_file::{VolError, VolFile, read_vol, write_vol};
pub use volume::{GridVolume, Volume, VolumeFilter, VolumeWrap};

use glam::{Vec2, Vec3};

use self::majorants::MajorantGrid;
use crate::color::Rgb;
use crate::math::{Real, Vector, real_struct};
use crate::sampling::RandomStream;

/// An index into the scene's [`MediumTable`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct MediumId(pub u32);

/// The media on the two sides of a surface (PBR 4th ed., section 11.4); None is empty space.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct MediumInterface {
    /// The medium on the side that the geometric normal points away from.
    pub interior: Option<MediumId>,
    /// The medium on the side that the geometric normal points to.
    pub exterior: Option<MediumId>,
}

impl MediumInterface {
    /// Whether the surface separates media. Light that crosses any other surface stays in its medium.
    #[inline(always)]
    pub fn is_transition(&self) -> bool {
        self.interior.is_some() || self.exterior.is_some()
    }

    /// The medium of light that leaves the surface in direction `dir` after it was in `before`. `normal` is the
    /// geometric normal.
    #[inline(always)]
    pub fn entered(&self, before: Option<MediumId>, dir: Vec3, normal: Vec3) -> Option<MediumId> {
        match self.is_transition() {
            false => before,
            true if dir.dot(normal) > 0.0 => self.exterior,
            true => self.interior,
        }
    }
}

/// The description of a medium.
#[derive(Clone, Debug, PartialEq)]
pub struct MediumSource {
    /// The extinction coefficient per unit of length in world space, not negative, before `scale`.
    pub sigma_t: Volume,
    /// The factor on `sigma_t`, not negative.
    pub scale: f32,
    /// The single-scattering albedo, in [0, 1]: the scattered part of the extinction.
    pub albedo: Volume,
    /// The radiance that is emitted per unit of length, W/(m^3 sr), not negative. It does not depend on the
    /// extinction.
    pub emission: Volume,
    /// The phase function.
    pub phase: Phase,
}

impl MediumSource {
    /// Whether light is scattered anywhere. Where it is only absorbed, it need not be absorbed at random.
    #[inline(always)]
    fn scatters(&self) -> bool {
        self.albedo != Volume::ZERO
    }

    /// The albedo at a point of world space, in [0, 1].
    #[inline]
    fn albedo_at(&self, point: Vec3) -> Rgb {
        self.albedo.at(point).clamp(Rgb::ZERO, Rgb::ONE)
    }
}

/// A medium prepared for light transport.
#[derive(Clone, Debug, PartialEq)]
pub struct Medium {
    source: MediumSource,
    distances: Distances,
    /// The medium's data for lanes, if it is of the commonest kind.
    plain: Option<PlainMedium>,
}

/// The sampling of distances in a medium.
#[derive(Clone, Debug, PartialEq)]
enum Distances {
    /// By formulas, where extinction and emission are constant.
    Uniform(Uniform),
    /// By null-collision tracking.
    Tracked(MajorantGrid),
}

/// The media of a scene.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct MediumTable {
    media: Vec<Medium>,
}

impl MediumTable {
    /// The media with these sources, in the same order. Building majorants takes time for large volumes.
    pub fn new(sources: Vec<MediumSource>) -> Self {
        Self::default().with(sources)
    }

    /// The media with these sources; unchanged ones are not prepared again.
    pub fn with(&self, sources: Vec<MediumSource>) -> Self {
        let prepare = |(index, source): (usize, MediumSource)| match self.media.get(index) {
            Some(before) => before.with(source),
            None => Medium::new(source),
        };
        Self {
            media: sources.into_iter().enumerate().map(prepare).collect(),
        }
    }

    /// Whether a medium emits light.
    pub fn glows(&self) -> bool {
        self.media.iter().any(|medium| medium.source.emission != Volume::ZERO)
    }

    /// The same media without light of their own.
    pub fn without_emission(&self) -> Self {
        let dark = |medium: &Medium| MediumSource {
            emission: Volume::ZERO,
            ..medium.source.clone()
        };
        self.with(self.media.iter().map(dark).collect())
    }

    /// Whether there are no media.
    pub fn is_empty(&self) -> bool {
        self.media.is_empty()
    }

    /// All media in the order of their ids.
    pub fn iter(&self) -> impl Iterator<Item = &Medium> {
        self.media.iter()
    }

    /// The medium of an id of this table.
    #[inline(always)]
    pub fn get(&self, id: MediumId) -> &Medium {
        &self.media[id.0 as usize]
    }
}

real_struct! {
    /// A straight path segment through a medium.
    pub struct Way<R> {
        /// The start, in world space.
        pub origin: R::Vec3,
        /// Unit vector.
        pub dir: R::Vec3,
        /// The length in world space; it may be infinite.
        pub length: R,
    }
}

impl<R: Real> Way<R> {
    /// The point at a distance from the start.
    #[inline(always)]
    pub(crate) fn at(&self, distance: R) -> R::Vec3 {
        self.origin + self.dir * distance
    }
}

/// The result of sampling a path segment through a medium.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Travel {
    /// The distance at which light is scattered; None if it arrives at the end.
    pub scattered_at: Option<f32>,
    /// The probability of having come this far, given the tentative collisions on the segment, if no lamp had been
    /// sampled.
    ///
    /// It turns a density per solid angle at the start of the segment into that of arriving, which multiple importance
    /// sampling compares (Miller, Georgiev and Jarosz, A Null-Scattering Path Integral Formulation of Light Transport,
    /// 2019).
    pub passed: f32,
    /// The radiance that the segment's medium emits to the segment's start, times the throughput there.
    pub emitted: Rgb,
}

impl Medium {
    /// Prepares a medium.
    pub fn new(source: MediumSource) -> Self {
        let distances = match (&source.sigma_t, &source.emission) {
            (Volume::Constant(sigma_t), Volume::Constant(_)) => Distances::Uniform(Uniform {
                sigma_t: *sigma_t * source.scale,
                scatters: source.scatters(),
            }),
            _ => Distances::Tracked(MajorantGrid::new(&source)),
        };
        Self {
            plain: plain(&source, &distances),
            source,
            distances,
        }
    }

    /// Whether it sends light of its own.
    pub fn glows(&self) -> bool {
        self.source.emission != Volume::ZERO
    }

    /// The medium with another source. Majorants are rebuilt only if their sources have changed.
    fn with(&self, source: MediumSource) -> Self {
        fn tracked(source: &MediumSource) -> (&Volume, f32, &Volume) {
            (&source.sigma_t, source.scale, &source.emission)
        }
        match &self.distances {
            Distances::Tracked(majorants) if tracked(&self.source) == tracked(&source) => Self {
                distances: Distances::Tracked(majorants.clone()),
                source,
                plain: None,
            },
            _ => Self::new(source),
        }
    }

    /// The part of the extinction that is too dense to be tracked and is clamped; None in nearly all media.
    pub fn limited(&self) -> Option<Limited> {
        match &self.distances {
            Distances::Uniform(_) => None,
            Distances::Tracked(majorants) => majorants.limited(),
        }
    }

    /// The phase function.
    pub fn phase(&self) -> &Phase {
        &self.source.phase
    }

    /// The medium's data for lanes; None if lanes cannot handle its kind.
    #[inline(always)]
    pub(crate) fn plain(&self) -> Option<&PlainMedium> {
        self.plain.as_ref()
    }

    /// The distance along a segment of this length around which lamps are chosen for [`Self::travel`]. None where light
    /// is not scattered, or where the medium is tracked.
    #[inline]
    pub fn midway(&self, length: f32) -> Option<f32> {
        match &self.distances {
            Distances::Uniform(uniform) => Some(uniform.midway(length)).filter(|&midway| midway > 0.0),
            Distances::Tracked(_) => None,
        }
    }

    /// Samples the distance that light travels, and turns the `throughput` at the segment's start into that after it:
    /// after scattering, or at the end. `u` decides everything where there are formulas, and the first collision
    /// otherwise; `stream` gives further numbers. `throughput` must not be zero. With the position of a `lamp`, more
    /// distances near it are sampled; the estimate stays unbiased.
    #[inline]
    pub fn travel(
        &self,
        way: &Way,
        lamp: Option<Vec3>,
        throughput: &mut Rgb,
        u: Vec2,
        stream: &mut RandomStream,
    ) -> Travel {
        match &self.distances {
            Distances::Uniform(uniform) => {
                let emitted = match self.source.emission.at(way.origin) {
                    Rgb::ZERO => Rgb::ZERO,
                    emission => *throughput * emission * uniform::optical_length(uniform.sigma_t, way.length),
                };
                let (place, has_lamp) = (lamp.unwrap_or_default(), lamp.is_some());
                let albedo = |distance| self.source.albedo_at(way.at(distance));
                let passage = uniform.travel(way, place, has_lamp, *throughput, u.to_array(), albedo);
                *throughput = passage.throughput;
                Travel {
                    scattered_at: passage.is_scattered.then_some(passage.distance),
                    passed: passage.passed,
                    emitted,
                }
            }
            Distances::Tracked(majorants) => tracking::travel(&self.source, majorants, way, throughput, u.y, stream),
        }
    }

    /// An unbiased estimate of the segment's transmittance, exact where there are formulas. `carried` is the throughput
    /// of the light, up to a factor, and is updated to the segment's end. Also returns the probability with which
    /// [`Self::travel`] would have passed likewise.
    #[inline]
    pub fn transmit(&self, way: &Way, carried: &mut Rgb, stream: &mut RandomStream) -> (Rgb, f32) {
        match &self.distances {
            Distances::Uniform(uniform) => {
                let (passing, passed) = uniform.transmit(way.length, *carried);
                *carried *= passing;
                (passing, passed)
            }
            Distances::Tracked(majorants) => tracking::transmit(&self.source, majorants, way, carried, stream),
        }
    }
}

/// The data for lanes of a medium with formulas, a constant albedo, a phase function with a formula, and no emission.
fn plain(source: &MediumSource, distances: &Distances) -> Option<PlainMedium> {
    match (distances, &source.albedo) {
        (Distances::Uniform(uniform), Volume::Constant(albedo)) if source.emission == Volume::ZERO => {
            Some(PlainMedium {
                uniform: *uniform,
                albedo: albedo.clamp(Rgb::ZERO, Rgb::ONE),
                phase: source.phase.plain()?,
            })
        }
        _ => None,
    }
}

/// The probability that light of this `throughput` passes, where its channels pass with the probabilities `passing`. A
/// channel decides with a probability of its share of the throughput: multiple importance sampling over channels by the
/// balance heuristic.
///
/// Divided by it, `throughput * passing` keeps the sum of `throughput`. Probabilities along parts of a segment
/// therefore multiply to the probability of the whole.
#[inline(always)]
fn chance<R: Real>(throughput: R::Vec3, passing: R::Vec3) -> R {
    throughput.dot(passing) / throughput.sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_transition_says_what_is_behind_the_surface_and_no_other_surface_does() {
        let (fog, milk) = (Some(MediumId(0)), Some(MediumId(1)));
        let glass = MediumInterface {
            interior: milk,
            exterior: None,
        };
        let normal = Vec3::Z;
        assert_eq!(glass.entered(fog, Vec3::Z, normal), None);
        assert_eq!(glass.entered(fog, -Vec3::Z, normal), milk);
        assert_eq!(MediumInterface::default().entered(fog, -Vec3::Z, normal), fog);
    }

    #[test]
    fn chances_of_parts_multiply_to_the_chance_of_the_whole() {
        let throughput = Rgb::new(0.3, 0.1, 2.0);
        let (first, second) = (Rgb::new(0.5, 0.9, 0.2), Rgb::new(0.3, 0.4, 0.8));
        let after = throughput * first / chance::<f32>(throughput, first);
        let product = chance::<f32>(throughput, first) * chance::<f32>(after, second);
        assert!((product - chance::<f32>(throughput, first * second)).abs() < 1e-6);
        assert!((after.element_sum() - throughput.element_sum()).abs() < 1e-6);
    }
}
