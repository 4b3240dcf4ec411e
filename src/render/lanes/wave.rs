//! Sixteen paths at their next rays: from vertex to vertex.

use glam::{UVec2, Vec3};

use super::camera_rays::CameraRays;
use super::light_samples::{LightLanes, ReferenceLanes};
use super::vertices::{Met, Vertices};
use super::{Job, Surroundings};
use crate::accel::{Hit, RayLanes};
use crate::light::LightReference;
use crate::math::Ray;
use crate::math::lanes::{FrameLanes, LANES, Lanes, Vec3Lanes, WordLanes, each_lane, lanes_of, offset_origins};
use crate::render::path::{
    Arrival, BOUNCE_DIMENSIONS, CAMERA_DIMENSIONS, HIGHEST_SURVIVAL, Path, PathSample, SPECULAR_GRACE, shadow_ray,
};
use crate::render::scene::SurfaceSlot;
use crate::render::view::{Strategy, View};
use crate::sampling::Sampler;
use crate::sampling::lanes::{SamplerLanes, power_heuristics};
use crate::shading::lanes::BsdfSampleLanes;

/// Whether rays have much in common, as those through one pixel have.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum Company {
    Coherent,
    Mixed,
}

/// Samples and their weights, by job.
pub(super) type Samples = Vec<(PathSample, f32)>;

/// The paths under way. What changes at every vertex lies in lanes, the rest in `homes`.
pub(super) struct Wave<'a> {
    /// A bit per lane.
    pub active: u32,
    /// Where they go next; endless but for those from the camera.
    rays: RayLanes,
    /// What these meet, in the lanes of `traced`.
    hits: [Option<Hit>; LANES],
    traced: u32,
    throughput: Vec3Lanes,
    eta_squared: Lanes,
    radiance: Vec3Lanes,
    /// Of [`Arrival::Sampled`]; negative for the other.
    arrival_pdf: Lanes,
    from: Vec3Lanes,
    from_normal: Vec3Lanes,
    /// A bit per lane.
    from_has_normal: u32,
    depth: WordLanes,
    sampler: SamplerLanes,
    homes: [Home; LANES],
    vertices: Vertices<'a>,
}

/// A path's own things, and the whole of it while it steps alone.
#[derive(Clone, Copy)]
struct Home {
    job: usize,
    weight: f32,
    path: Path,
}

impl<'a> Wave<'a> {
    /// Without paths.
    pub fn new(view: &View) -> Self {
        let nowhere = Path::new(
            Ray::new(Vec3::ZERO, Vec3::Z),
            Sampler::new(view.sequence, UVec2::ZERO, 0, view.seed),
        );
        let home = Home {
            job: 0,
            weight: 0.0,
            path: nowhere,
        };
        Self {
            active: 0,
            rays: RayLanes::NOWHERE,
            hits: [None; LANES],
            traced: 0,
            throughput: Vec3Lanes::ZERO,
            eta_squared: Lanes::ONE,
            radiance: Vec3Lanes::ZERO,
            arrival_pdf: Lanes::ZERO,
            from: Vec3Lanes::ZERO,
            from_normal: Vec3Lanes::ZERO,
            from_has_normal: 0,
            depth: WordLanes::ZERO,
            sampler: SamplerLanes::new(view.sequence),
            homes: [home; LANES],
            vertices: Vertices::new(),
        }
    }

    /// New paths from the camera, in as many lanes as there are jobs for: the first of `jobs`, which are numbered from `number` on. Returns how
    /// many these are.
    pub fn begin(&mut self, view: &View, jobs: &[Job], number: usize) -> usize {
        let count = jobs.len().min(LANES);
        let camera = CameraRays::new(view, &jobs[..count]);
        self.active = (1 << count) - 1;
        self.traced = 0;
        self.rays = camera.rays;
        self.sampler = camera.samplers;
        self.throughput = Vec3Lanes::splat(Vec3::ONE);
        self.eta_squared = Lanes::ONE;
        self.radiance = Vec3Lanes::ZERO;
        self.arrival_pdf = -Lanes::ONE;
        self.depth = WordLanes::ZERO;
        for (lane, home) in self.homes.iter_mut().enumerate().take(count) {
            home.job = number + lane;
            home.weight = camera.weights[lane];
            home.path = Path::new(self.rays.get(lane), self.sampler.get(lane));
        }
        count
    }

    /// Takes over a path of another wave into a free lane.
    pub fn take(&mut self, lane: usize, other: &mut Self, theirs: usize) {
        let number = |to: &mut Lanes, from: &Lanes| to.as_mut_array()[lane] = from.as_array()[theirs];
        let vector = |to: &mut Vec3Lanes, from: &Vec3Lanes| to.set(lane, from.get(theirs));
        vector(&mut self.rays.origin, &other.rays.origin);
        vector(&mut self.rays.dir, &other.rays.dir);
        number(&mut self.rays.t_min, &other.rays.t_min);
        number(&mut self.rays.t_max, &other.rays.t_max);
        vector(&mut self.throughput, &other.throughput);
        number(&mut self.eta_squared, &other.eta_squared);
        vector(&mut self.radiance, &other.radiance);
        number(&mut self.arrival_pdf, &other.arrival_pdf);
        vector(&mut self.from, &other.from);
        vector(&mut self.from_normal, &other.from_normal);
        self.from_has_normal &= !(1 << lane);
        self.from_has_normal |= (other.from_has_normal >> theirs & 1) << lane;
        self.depth.as_mut_array()[lane] = other.depth.as_array()[theirs];
        self.homes[lane] = other.homes[theirs];
        self.sampler.set(lane, &self.homes[lane].path.sampler);
        self.hits[lane] = other.hits[theirs];
        self.traced &= !(1 << lane);
        self.traced |= (other.traced >> theirs & 1) << lane;
        self.active |= 1 << lane;
        other.active &= !(1 << theirs);
    }

    /// The path of a lane goes home.
    fn load(&mut self, lane: usize) -> &mut Path {
        let path = &mut self.homes[lane].path;
        path.ray = self.rays.get(lane);
        path.throughput = self.throughput.get(lane);
        path.eta_squared = self.eta_squared.as_array()[lane];
        path.result.radiance = self.radiance.get(lane);
        path.depth = self.depth.as_array()[lane];
        let pdf = self.arrival_pdf.as_array()[lane];
        path.arrival = if pdf < 0.0 {
            Arrival::Only
        } else {
            Arrival::Sampled {
                pdf,
                from: LightReference {
                    position: self.from.get(lane),
                    normal: (self.from_has_normal >> lane & 1 == 1).then(|| self.from_normal.get(lane)),
                },
            }
        };
        path
    }

    /// And comes back.
    fn store(&mut self, lane: usize) {
        let path = &self.homes[lane].path;
        self.rays.set(lane, &path.ray);
        self.throughput.set(lane, path.throughput);
        self.eta_squared.as_mut_array()[lane] = path.eta_squared;
        self.radiance.set(lane, path.result.radiance);
        self.depth.as_mut_array()[lane] = path.depth;
        self.from_has_normal &= !(1 << lane);
        match path.arrival {
            Arrival::Only => self.arrival_pdf.as_mut_array()[lane] = -1.0,
            Arrival::Sampled { pdf, from } => {
                self.arrival_pdf.as_mut_array()[lane] = pdf;
                self.from.set(lane, from.position);
                if let Some(normal) = from.normal {
                    self.from_has_normal |= 1 << lane;
                    self.from_normal.set(lane, normal);
                }
            }
        }
    }

    /// The path of a lane has ended, its radiance being in its lane.
    fn finish(&mut self, lane: usize, samples: &mut Samples) {
        let home = &self.homes[lane];
        let sample = PathSample {
            radiance: self.radiance.get(lane),
            ..home.path.result
        };
        samples[home.job] = (sample, home.weight);
        self.active &= !(1 << lane);
    }

    /// Finds out what the rays meet of which that is not known. Paths that meet nothing end; what ends goes to `samples`.
    #[inline(never)]
    pub fn trace(&mut self, company: Company, around: &Surroundings, samples: &mut Samples) {
        let geometry = &around.scene.geometry;
        let asked = self.active & !self.traced;
        if asked == 0 {
            return;
        }
        let hits = match company {
            Company::Coherent => geometry.intersect_bundle(&self.rays, asked),
            Company::Mixed => geometry.intersect_lanes(&self.rays, asked),
        };
        for lane in each_lane(asked) {
            self.hits[lane] = hits[lane];
            if around.settings.hide_emitters {
                self.pass_hidden_emitters(lane, around);
            }
            if self.hits[lane].is_none() {
                self.escape(lane, around, samples);
            }
        }
        self.traced = self.active;
    }

    /// As [`Path::behind_hidden_emitters`].
    #[inline(never)]
    fn pass_hidden_emitters(&mut self, lane: usize, around: &Surroundings) {
        let hit = self.hits[lane];
        let path = self.load(lane);
        let behind = path.behind_hidden_emitters(around.scene, around.settings, hit);
        let ray = path.ray;
        self.rays.set(lane, &ray);
        self.hits[lane] = behind;
    }

    /// Takes all paths to their next vertices and on from there.
    #[inline(never)]
    pub fn step(&mut self, company: Company, around: &Surroundings<'a>, samples: &mut Samples) {
        if self.active == 0 {
            return;
        }
        self.vertices.clear();
        for lane in each_lane(self.active) {
            if let Some(hit) = self.hits[lane] {
                self.arrive(lane, hit, around, samples);
            }
        }
        self.traced = 0;
        if self.vertices.lanes != 0 {
            self.scatter(company, around, samples);
        }
    }

    /// The path of a lane leaves the scene.
    fn escape(&mut self, lane: usize, around: &Surroundings, samples: &mut Samples) {
        self.homes[lane].path.result.rays += 1;
        let path = self.load(lane);
        path.escape(around.scene, around.settings, &mut ());
        let radiance = path.result.radiance;
        self.radiance.set(lane, radiance);
        self.finish(lane, samples);
    }

    /// Takes the path of a lane to its hit. What light does there is done in lanes, or else the path goes on to its next ray by itself.
    fn arrive(&mut self, lane: usize, hit: Hit, around: &Surroundings<'a>, samples: &mut Samples) {
        let slot = around.scene.slot(&hit);
        let ray = self.rays.get(lane);
        match self.vertices.set_plain(lane, around.scene, &ray, &hit, &slot) {
            Some(met) => self.look(lane, &hit, &slot, &met, around, samples),
            None => self.arrive_elsewhere(lane, hit, &slot, around, samples),
        }
    }

    /// At a surface that is not of one of the commonest models.
    #[inline(never)]
    fn arrive_elsewhere(
        &mut self,
        lane: usize,
        hit: Hit,
        slot: &SurfaceSlot,
        around: &Surroundings<'a>,
        samples: &mut Samples,
    ) {
        let ray = self.rays.get(lane);
        if let Some(met) = self.vertices.set_other(lane, around.scene, &ray, &hit, slot) {
            self.look(lane, &hit, slot, &met, around, samples);
            return;
        }
        let path = self.load(lane);
        let goes_on = path.advance(around.scene, around.settings, Some(hit), &mut ());
        self.store(lane);
        if !goes_on {
            self.finish(lane, samples);
        }
    }

    /// What a path sees where it has come to. It ends there if that was its last vertex.
    #[inline(always)]
    fn look(
        &mut self,
        lane: usize,
        hit: &Hit,
        slot: &SurfaceSlot,
        met: &Met,
        around: &Surroundings,
        samples: &mut Samples,
    ) {
        let (scene, settings) = (around.scene, around.settings);
        let depth = self.depth.as_array()[lane];
        let is_last = depth + 1 >= settings.longest_path();
        self.homes[lane].path.result.rays += 1;
        if slot.light.is_some() || depth == 0 {
            let path = self.load(lane);
            path.arrive(scene, settings, hit, slot, &met.point, &mut ());
            let radiance = path.result.radiance;
            self.radiance.set(lane, radiance);
        }
        if !self.homes[lane].path.guided && (is_last || met.is_smooth || slot.light.is_some()) {
            let throughput = self.throughput.get(lane);
            let path = &mut self.homes[lane].path;
            path.throughput = throughput;
            path.guide(met.albedo, slot, &met.point);
        }
        if is_last {
            self.vertices.lanes &= !(1 << lane);
            self.finish(lane, samples);
        }
    }

    /// From the vertices to where their paths go on.
    fn scatter(&mut self, company: Company, around: &Surroundings, samples: &mut Samples) {
        let (scene, settings) = (around.scene, around.settings);
        let zero = Lanes::ZERO;
        let lanes = self.vertices.lanes;
        let here = lanes_of(lanes);
        let Vertices {
            position,
            error,
            geometric_normal,
            shading_normal,
            side,
            ..
        } = self.vertices;
        let bsdf = &self.vertices.bsdf;
        let one_further: WordLanes = bytemuck::cast(here);
        self.depth += WordLanes::splat(1) & one_further;
        let dimension = (self.depth - WordLanes::splat(1)) * WordLanes::splat(BOUNCE_DIMENSIONS)
            + WordLanes::splat(CAMERA_DIMENSIONS);
        let at = |draw: u32| dimension + WordLanes::splat(draw);

        let frame = FrameLanes {
            n: shading_normal * side,
            ..FrameLanes::from_normal(shading_normal)
        };
        let wo = frame.to_local(-self.rays.dir);

        let (smooth, halved) = (self.vertices.smooth() & lanes, self.vertices.halved());
        let other = self.vertices.other & lanes;
        if smooth != 0 && !(settings.strategy == Strategy::Bsdf && around.sole_light.is_some()) {
            let seen_from = ReferenceLanes {
                position,
                normal: frame.n,
                halved,
            };
            let light = LightLanes::sample(around, smooth, seen_from, &self.sampler, at);
            let (mut value, mut bsdf_pdf) = bsdf.eval_and_pdf(wo, frame.to_local(light.wi));
            if other & smooth != 0 {
                let asked = other & smooth & light.is_valid.to_bitmask();
                (value, bsdf_pdf) = self.vertices.eval_others(asked, light.wi, value, bsdf_pdf);
            }
            let weight = match settings.strategy {
                Strategy::Mis => power_heuristics(light.pdf, bsdf_pdf),
                Strategy::Light => Lanes::ONE,
                Strategy::Bsdf => zero,
            };
            let weight = lanes_of(light.is_delta).select(Lanes::ONE, weight);
            let reflected = self.throughput * value * light.radiance * (weight / light.pdf);
            let counts = light.is_valid & lanes_of(smooth) & reflected.is_not_zero();
            let asked = counts.to_bitmask();
            let origin = offset_origins(position, error, geometric_normal, light.wi);
            let is_infinite = lanes_of(light.infinite);
            let shadows = RayLanes {
                origin,
                dir: Vec3Lanes::select(is_infinite, light.wi, light.target - origin),
                t_min: zero,
                t_max: is_infinite.select(Lanes::splat(f32::INFINITY), Lanes::ONE),
            };
            let occluded = match company {
                Company::Coherent => scene.geometry.occluded_bundle(&shadows, asked),
                Company::Mixed => scene.geometry.occluded_lanes(&shadows, asked),
            };
            let lit = asked & !occluded;
            self.radiance += reflected.only(lanes_of(lit));
            let lets_through = scene.materials.lets_through();
            for lane in each_lane(if lets_through { lit } else { asked }) {
                self.homes[lane].path.result.rays += 1;
            }
            if lets_through {
                let through = look_through(
                    around,
                    occluded,
                    self.depth,
                    [origin, reflected],
                    light,
                    &mut self.homes,
                );
                self.radiance += through.only(lanes_of(occluded));
            }
        }

        if settings.hide_emitters {
            for lane in each_lane(lanes) {
                self.homes[lane].path.is_straight = false;
            }
        }
        let u_lobe = match bsdf.transmitting() | other {
            0 => zero,
            _ => self.sampler.at_1d(at(2)),
        };
        let u = self.sampler.at_2d(at(3));
        let sample = bsdf.sample(wo, u_lobe, u);
        let mut sample = BsdfSampleLanes {
            wi: frame.to_world(sample.wi),
            ..sample
        };
        // By a density, not the only direction of a lobe.
        let mut scattered = smooth;
        if other != 0 {
            let smooth_sample;
            (sample, smooth_sample) = self.vertices.sample_others(lanes, u_lobe, u, sample);
            scattered &= !other | smooth_sample;
        }
        let wi = sample.wi;
        self.throughput = Vec3Lanes::select(here, self.throughput * sample.weight, self.throughput);
        self.eta_squared = here.select(self.eta_squared * sample.eta * sample.eta, self.eta_squared);
        let mut goes_on = here & sample.returned & self.throughput.is_not_zero();

        self.rays.origin = Vec3Lanes::select(
            here,
            offset_origins(position, error, geometric_normal, wi),
            self.rays.origin,
        );
        self.rays.dir = Vec3Lanes::select(here, wi, self.rays.dir);
        self.rays.t_min = here.select(zero, self.rays.t_min);
        self.rays.t_max = here.select(Lanes::splat(f32::INFINITY), self.rays.t_max);
        let is_scattered = lanes_of(scattered);
        self.arrival_pdf = here.select(is_scattered.select(sample.pdf, -Lanes::ONE), self.arrival_pdf);
        self.from = Vec3Lanes::select(here, position, self.from);
        self.from_normal = Vec3Lanes::select(here, frame.n, self.from_normal);
        self.from_has_normal = (self.from_has_normal & !lanes) | (lanes & halved);

        let from = |depth: u32| bytemuck::cast::<_, Lanes>(self.depth.simd_ge(WordLanes::splat(depth)));
        let late = settings.rr_depth.saturating_add(SPECULAR_GRACE);
        let plays = here & ((is_scattered & from(settings.rr_depth)) | from(late));
        if plays.any() {
            let brightest = self.throughput.max_element() * self.eta_squared;
            let survival = brightest.fast_min(Lanes::splat(HIGHEST_SURVIVAL));
            let survives = self.sampler.at_1d(at(4)).simd_lt(survival);
            goes_on &= survives | !plays;
            let scaled = self.throughput * (Lanes::ONE / survival);
            self.throughput = Vec3Lanes::select(plays, scaled, self.throughput);
        }
        for lane in each_lane(lanes & !goes_on.to_bitmask()) {
            self.finish(lane, samples);
        }
    }
}

/// What of the `reflected` light of the lanes `asked` arrives at their `origin` through surfaces that let it pass.
#[inline(never)]
fn look_through(
    around: &Surroundings,
    asked: u32,
    depth: WordLanes,
    [origin, mut reflected]: [Vec3Lanes; 2],
    light: LightLanes,
    homes: &mut [Home; LANES],
) -> Vec3Lanes {
    for lane in each_lane(asked) {
        let crossings = around.settings.longest_path() - depth.as_array()[lane] - 1;
        let (origin, wi) = (origin.get(lane), light.wi.get(lane));
        let rays = &mut homes[lane].path.result.rays;
        let arriving = shadow_ray(around.scene, origin, wi, light.target(lane), crossings, rays);
        reflected.set(lane, reflected.get(lane) * arriving);
    }
    reflected
}
