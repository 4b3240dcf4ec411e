//! The state of an unfinished path, declared once for paths traced one by one and for paths in lanes.

use glam::Vec3;

use crate::accel::Hit;
use crate::color::Rgb;
use crate::light::LightReference;
use crate::math::{Ray, per_lane, per_lane_array};
use crate::medium::MediumId;
use crate::sampling::Sampler;

/// The result of one camera ray.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct PathSample {
    /// The radiance along the ray, linear Rec. 709.
    pub radiance: Rgb,
    /// The part of `radiance` that the camera sees directly, in mirrors or through glass: not scattered by a density.
    pub seen: Rgb,
    /// The colour of the first surface that is not perfectly specular, in [0, 1]; a feature for the denoiser.
    pub albedo: Rgb,
    /// The world normal of the same surface.
    pub normal: Vec3,
    /// Distance from the camera ray's origin to the first surface; 0 without one.
    pub depth: f32,
    /// The first hit; None if the camera ray hits nothing.
    pub first_hit: Option<Hit>,
    /// Rays traced, shadow rays included.
    pub rays: u32,
}

per_lane! {
    /// An unfinished path.
    pub(super) struct PathState in PathLanes {
        /// The ray to the next vertex.
        pub ray: Ray,
        pub throughput: Rgb,
        /// The squared relative index of refraction so far: inside glass radiance is scaled by it, which roulette must
        /// ignore.
        pub eta_squared: f32,
        /// The radiance that the path has found so far.
        pub radiance: Rgb,
        pub arrival: Arrival,
        /// The number of vertices so far: surfaces hit and scatterings in media, without the hidden emitters that the
        /// camera ray has passed.
        pub depth: u32,
        /// The number of those vertices that do not end a counted segment.
        pub uncounted: u32,
        /// The medium along the ray.
        pub medium: Option<MediumId>,
        /// Whether all surfaces hit so far have let the camera ray pass straight on.
        pub is_straight: bool,
        /// Rays traced, shadow rays included.
        pub rays: u32,
        pub sampler: Sampler,
        pub record: PathRecord,
    }
}

per_lane! {
    /// The sampling of the direction to the current vertex, on which the weight of an emitter there depends.
    pub(super) struct Arrival in ArrivalLanes {
        /// Whether a bsdf chose the direction by a density. Otherwise the path comes from the camera or from a delta
        /// lobe, and no other technique could have found the emitter.
        pub is_sampled: bool,
        /// The density per solid angle, if the direction was sampled.
        pub pdf: f32,
        /// The vertex that the direction was sampled from.
        pub from: LightReference,
    }
}

/// Notes along a path that are not part of the picture. They affect neither the path nor its radiance.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct PathRecord {
    /// The albedo for the denoiser in [0, 1], and (next) its normal in the world.
    pub albedo: Rgb,
    pub normal: Vec3,
    pub has_features: bool,
    /// The radiance found so far before the path was scattered by a density.
    pub seen: Rgb,
    /// The first hit; None before the camera ray has hit a surface. Its `t` counts from the original origin of the
    /// camera ray.
    pub first_hit: Option<Hit>,
    /// Distance from the camera to the origin of its ray, which hidden emitters have moved.
    pub passed: f32,
}

per_lane_array!(PathRecord, Option<MediumId>);

impl Arrival {
    /// The arrival from the camera or a delta lobe.
    pub const UNSAMPLED: Self = Self {
        is_sampled: false,
        pdf: 0.0,
        from: LightReference {
            position: Vec3::ZERO,
            normal: None,
        },
    };
}

impl PathState {
    /// A path that begins with the camera ray `ray`, in `medium`.
    pub fn new(ray: Ray, sampler: Sampler, medium: Option<MediumId>) -> Self {
        Self {
            ray,
            throughput: Rgb::ONE,
            eta_squared: 1.0,
            radiance: Rgb::ZERO,
            arrival: Arrival::UNSAMPLED,
            depth: 0,
            uncounted: 0,
            medium,
            is_straight: true,
            rays: 0,
            sampler,
            record: PathRecord::default(),
        }
    }

    /// The result of a finished path.
    pub fn sample(&self) -> PathSample {
        self.record.sample(self.radiance, self.rays)
    }
}

impl PathRecord {
    /// Records the first surface, at `hit` of a camera ray.
    pub fn meet(&mut self, hit: &Hit) {
        let mut first = *hit;
        first.t += self.passed;
        self.first_hit = Some(first);
    }

    /// Whether the denoiser's features are taken at this surface, which the path does not pass straight. They are those
    /// of the first surface that scatters by a density or emits, or else of the last one.
    pub fn wants_features(&self, is_smooth: bool, is_light: bool, is_last: bool) -> bool {
        !self.has_features && (is_smooth || is_light || is_last)
    }

    /// Takes the denoiser's features at a surface with this shading normal, whose colour is `albedo` unless it is a
    /// light.
    pub fn take_features(&mut self, throughput: Rgb, albedo: Rgb, normal: Vec3, is_light: bool) {
        self.has_features = true;
        let colour = if is_light { Rgb::ONE } else { albedo };
        self.albedo = (throughput * colour).clamp(Rgb::ZERO, Rgb::ONE);
        self.normal = normal;
    }

    /// Takes the denoiser's features at a scattering in a medium, unless it has them. `throughput` includes the albedo
    /// of the medium; there is no normal.
    pub fn take_medium_features(&mut self, throughput: Rgb) {
        if !self.has_features {
            self.take_features(throughput, Rgb::ONE, Vec3::ZERO, false);
        }
    }

    /// Records `radiance` of a hit emitter, which is seen directly unless the path was scattered before.
    #[inline(always)]
    pub fn come_upon(&mut self, radiance: Rgb) {
        if !self.has_features {
            self.seen += radiance;
        }
    }

    /// Records that the path has left the scene with this `radiance`.
    pub fn escape(&mut self, radiance: Rgb) {
        if !self.has_features {
            self.albedo = radiance.clamp(Rgb::ZERO, Rgb::ONE);
        }
    }

    /// The result of a path that has found this `radiance` with this many `rays`.
    pub fn sample(&self, radiance: Rgb, rays: u32) -> PathSample {
        PathSample {
            radiance,
            seen: self.seen,
            albedo: self.albedo,
            normal: self.normal,
            depth: self.first_hit.map_or(0.0, |hit| hit.t),
            first_hit: self.first_hit,
            rays,
        }
    }
}
