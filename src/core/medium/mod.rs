//! Participating media: what fills the space between surfaces, and how light is absorbed, scattered and emitted there
//! (PBR 4th ed., chapters 11 and 14; Novák et al., Monte Carlo Methods for Volumetric Light Transport Simulation,
//! 2018).
//!
//! A medium is described by its extinction coefficient `sigma_t` (per unit of length), the part `albedo` of it that is
//! scattering, the radiance `emission` that a unit of length adds, and a [`Phase`] function. Each of the first three is
//! a [`Volume`]: the same everywhere, or a grid.
//!
//! Where all is the same everywhere, distances and transmittances have formulas (`uniform.rs`). Otherwise they are
//! found by null-collision tracking against a grid of majorants (`tracking.rs`, `majorants.rs`). Both forms are used
//! through [`Medium::travel`] and [`Medium::transmit`]. Surfaces name the media on their sides by a
//! [`MediumInterface`].

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
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct MediumId(pub u32);

/// The media on the two sides of a surface (PBR 4th ed., section 11.4); None is empty space.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct MediumInterface {
    /// On the side that the geometric normal points away from.
    pub interior: Option<MediumId>,
    /// On the side that the geometric normal points to.
    pub exterior: Option<MediumId>,
}

impl MediumInterface {
    /// Whether the surface says what is on its sides. Light that crosses any other surface stays in the medium that it
    /// was in.
    #[inline(always)]
    pub fn is_transition(&self) -> bool {
        self.interior.is_some() || self.exterior.is_some()
    }

    /// The medium into which light goes that leaves the surface in direction `dir`, and was in `before`. `normal` is
    /// the geometric normal.
    #[inline(always)]
    pub fn entered(&self, before: Option<MediumId>, dir: Vec3, normal: Vec3) -> Option<MediumId> {
        match self.is_transition() {
            false => before,
            true if dir.dot(normal) > 0.0 => self.exterior,
            true => self.interior,
        }
    }
}

/// What a medium is made from.
#[derive(Clone, Debug, PartialEq)]
pub struct MediumSource {
    /// The extinction coefficient per unit of length in world space, not negative, before `scale`.
    pub sigma_t: Volume,
    /// The factor on `sigma_t`, not negative.
    pub scale: f32,
    /// The part of the extinction that is scattering, in [0, 1].
    pub albedo: Volume,
    /// The radiance that is emitted per unit of length, W/(m^3 sr), not negative. It does not depend on the
    /// extinction.
    pub emission: Volume,
    /// The directions of scattered light.
    pub phase: Phase,
}

impl MediumSource {
    /// Whether light is scattered anywhere. Where it is only absorbed, it need not be lost at random.
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

/// A medium that is ready for light transport.
#[derive(Clone, Debug, PartialEq)]
pub struct Medium {
    source: MediumSource,
    distances: Distances,
    /// What is needed of it in lanes, if it is of the commonest kind.
    plain: Option<PlainMedium>,
}

/// The way in which distances are found in a medium.
#[derive(Clone, Debug, PartialEq)]
enum Distances {
    /// By formulas, where extinction and emission are the same everywhere.
    Uniform(Uniform),
    /// By null collisions.
    Tracked(MajorantGrid),
}

/// The media of a scene.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct MediumTable {
    media: Vec<Medium>,
}

impl MediumTable {
    /// The media with these sources, in the same order. The grids of majorants take a while for large volumes.
    pub fn new(sources: Vec<MediumSource>) -> Self {
        Self::default().with(sources)
    }

    /// The media with these sources, of which those that are as they were before are not prepared again.
    pub fn with(&self, sources: Vec<MediumSource>) -> Self {
        let prepare = |(index, source): (usize, MediumSource)| match self.media.get(index) {
            Some(before) => before.with(source),
            None => Medium::new(source),
        };
        Self {
            media: sources.into_iter().enumerate().map(prepare).collect(),
        }
    }

    /// Whether all space is empty.
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
    /// A straight way through a medium.
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

/// What has become of light on its way through a medium.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Travel {
    /// The distance at which it is scattered; None if it arrives at the end.
    pub scattered_at: Option<f32>,
    /// The probability of having come so far, given the tentative collisions on the way, if no lamp had been
    /// considered.
    ///
    /// With it a density per solid angle at the start of the way becomes that of arriving, which is what multiple
    /// importance sampling compares (Miller, Georgiev and Jarosz, A Null-Scattering Path Integral Formulation of
    /// Light Transport, 2019).
    pub passed: f32,
    /// The radiance that the medium has emitted along the way, as it arrives at the start, times the throughput there.
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

    /// The medium with another source. Majorants are only prepared again if what they depend on has changed.
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

    /// What of its extinction is too dense to be tracked and counts as less; None in nearly all media.
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

    /// What is needed of the medium in lanes, if it is of the kind that goes there.
    #[inline(always)]
    pub(crate) fn plain(&self) -> Option<&PlainMedium> {
        self.plain.as_ref()
    }

    /// The distance along a way of this length around which lights are worth looking for, to be considered in
    /// [`Self::travel`]. None where light is not scattered, or where there are no formulas.
    #[inline]
    pub fn midway(&self, length: f32) -> Option<f32> {
        match &self.distances {
            Distances::Uniform(uniform) => Some(uniform.midway(length)).filter(|&midway| midway > 0.0),
            Distances::Tracked(_) => None,
        }
    }

    /// Samples how far light goes, and turns the `throughput` before the way into that after it: behind the scattering,
    /// or at the end. `u` decides where there are formulas, and the first collision where there are none; `stream`
    /// gives what numbers are needed beyond. `throughput` is not zero. With the place of a `lamp`, light is
    /// scattered more often near it; the mean is the same.
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

    /// An unbiased estimate of the share of light that passes the whole way, exact where there are formulas. `carried`
    /// is the throughput of the light, up to a factor; it becomes that at the end. Also returns the probability
    /// with which [`Self::travel`] would have passed in the same manner.
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

/// The medium, if it does not shine, has one albedo, and has formulas for scattering and for distances.
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

/// The probability that light of this `throughput` passes where each of its colours would do so with the probabilities
/// `passing`. The colours decide by turns, each as often as its share of the throughput, which is multiple importance
/// sampling over them by the balance heuristic.
///
/// Divided by it, `throughput * passing` has the sum that `throughput` had. Probabilities of parts of a way therefore
/// multiply to that of the whole.
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
