//! Scattering at the vertices of sixteen paths: the steps of [`crate::render::path`] from a vertex to the next ray, in
//! lanes.

use super::batch::PathBatch;
use super::context::{Coherence, Context, Samples};
use super::guided::Guided;
use super::light_samples::LightLanes;
use super::vertices::Vertices;
use crate::accel::RayLanes;
use crate::color::Rgb;
use crate::light::ReferenceLanes;
use crate::math::lanes::{Lanes, Vec3Lanes, each_lane, lanes_of, ones_in};
use crate::math::{Frame, Held, PerLane, Vector, offset_origin};
use crate::medium::PlainMedium;
use crate::render::dimensions::{BounceDraw, MediumDraw};
use crate::render::medium_path::{ENCLOSED_SHARE, is_enclosed};
use crate::render::roulette;
use crate::render::transmittance::{Between, EmptySpace, Media, ShadowRay, passing};
use crate::render::view::{PathSettings, Strategy};
use crate::sampling::Sampler;
use crate::shading::{BsdfSample, ShadingTables};

/// The surfaces at the vertices, and the directions to their viewers.
#[derive(Clone, Copy)]
struct Surfaces {
    /// The lanes that are at a vertex, a bit per lane.
    lanes: u32,
    /// The same lanes as a mask.
    here: Lanes,
    /// The reference points for light sampling, with the shading normals on the side seen.
    reference: ReferenceLanes,
    /// The errors as in [`crate::accel::SurfacePoint`].
    error: Lanes,
    geometric_normal: Vec3Lanes,
    frame: Frame<Lanes>,
    /// The directions to the previous vertices, in `frame`.
    wo: Vec3Lanes,
    /// The lanes that scatter by a density.
    smooth: u32,
    /// The lanes whose models are evaluated one by one.
    other: u32,
}

impl Surfaces {
    #[inline(always)]
    fn new<const MEDIA: bool>(vertices: &Vertices<'_, MEDIA>, dir: Vec3Lanes) -> Self {
        let lanes = vertices.lanes;
        let frame = vertices.frames();
        Self {
            lanes,
            here: lanes_of(lanes),
            reference: ReferenceLanes {
                position: vertices.position,
                normal: frame.n,
                halved: vertices.halved(),
            },
            error: vertices.error,
            geometric_normal: vertices.geometric_normal,
            frame,
            wo: frame.to_local(-dir),
            smooth: vertices.smooth() & lanes,
            other: vertices.other & lanes,
        }
    }

    /// The origins of rays that leave the surfaces in the directions `dir`.
    #[inline(always)]
    fn leave(&self, dir: Vec3Lanes) -> Vec3Lanes {
        offset_origin(self.reference.position, self.error, self.geometric_normal, dir)
    }
}

/// Lights sampled from the vertices. It is passed by value, so that it stays in registers.
#[derive(Clone, Copy)]
struct SoughtLight {
    /// The lanes where the light would be scattered along the path, a bit per lane.
    lanes: u32,
    light: LightLanes,
    /// The densities with which the paths would have sampled the same directions.
    bsdf_pdf: Lanes,
    /// The throughput that paths would have in these directions.
    carried: Vec3Lanes,
    /// The light scattered along the paths if it is unoccluded.
    reflected: Vec3Lanes,
}

impl SoughtLight {
    /// The light of a lane that is scattered along the path, where media would let the path reach the light with the
    /// probability `passed`.
    fn reflected(&self, lane: usize, strategy: Strategy, passed: f32) -> Rgb {
        let [pdf, bsdf_pdf] = [self.light.pdf, self.bsdf_pdf].map(|pdf| pdf.as_array()[lane]);
        let is_delta = self.light.is_delta >> lane & 1 == 1;
        let weight = strategy.light_weight(is_delta, pdf, bsdf_pdf * passed);
        self.carried.get(lane) * self.light.radiance.get(lane) * (weight / pdf)
    }
}

impl<const MEDIA: bool> PathBatch<'_, MEDIA> {
    /// Steps from the vertices to the next rays.
    pub(super) fn scatter(&mut self, coherence: Coherence, context: &Context, samples: &mut Samples) {
        let surfaces = Surfaces::new(&self.vertices, self.paths.ray.dir);
        self.paths.depth += ones_in(surfaces.lanes);
        let guided = context.field.and_then(|field| {
            let asked = self.vertices.guided() & surfaces.lanes;
            let tables = context.scene.materials.tables();
            let lobes = self
                .vertices
                .diffuse_lobes(tables, asked, surfaces.frame.n, surfaces.wo);
            Guided::of(field, asked, surfaces.reference.position, lobes)
        });
        if surfaces.smooth != 0 && context.samples_lights() {
            self.sample_lights(&surfaces, coherence, context, guided.as_ref(), samples);
        }
        self.note_scattering(samples);
        let (sample, scattered) = self.sample_bsdfs(&surfaces, context, guided.as_ref());
        let is_scattered = lanes_of(scattered);
        let mut goes_on = self.bounce(&surfaces, &sample, scattered);
        goes_on &= self.play_roulette(&surfaces, context.settings, is_scattered);
        for lane in each_lane(surfaces.lanes & !goes_on.to_bitmask()) {
            self.finish_here(lane, samples);
        }
    }

    /// Samples lights from the vertices and adds the light that is scattered along the paths (next event estimation).
    #[inline(always)]
    fn sample_lights(
        &mut self,
        surfaces: &Surfaces,
        coherence: Coherence,
        context: &Context,
        guided: Option<&Guided>,
        samples: &mut Samples,
    ) {
        let Surfaces { frame, wo, .. } = *surfaces;
        let (smooth, raised) = match surfaces.smooth & self.vertices.in_media() {
            0 => (surfaces.smooth, None),
            in_media => self.seek_light(surfaces.smooth, in_media),
        };
        let light = LightLanes::sample(
            context,
            smooth,
            surfaces.reference,
            &self.paths.sampler,
            self.paths.depth,
            raised,
        );
        let tables = context.scene.materials.tables();
        let (mut value, mut bsdf_pdf) = self.vertices.eval_and_pdf(tables, wo, frame, light.wi);
        if surfaces.other & smooth != 0 {
            let asked = surfaces.other & smooth & light.is_valid.to_bitmask();
            (value, bsdf_pdf) = self.vertices.eval_others(asked, light.wi, value, bsdf_pdf);
        }
        if let Some(guided) = guided {
            bsdf_pdf = guided.mixed(light.wi, bsdf_pdf);
        }
        let strategy = context.settings.strategy;
        let weight = strategy.light_weight(lanes_of(light.is_delta), light.pdf, bsdf_pdf);
        let mut carried = self.paths.throughput * value;
        if let Some(raised) = raised {
            carried = carried * raised;
        }
        let reflected = carried * light.radiance * (weight / light.pdf);
        let counts = light.is_valid & lanes_of(smooth) & reflected.is_not_zero();
        let sought = SoughtLight {
            lanes: counts.to_bitmask(),
            light,
            bsdf_pdf,
            carried,
            reflected,
        };
        self.trace_shadow_rays(surfaces, coherence, context, sought, samples);
    }

    /// The lanes of `smooth` from which lights are sampled, as of [`crate::render::path::Scatterer`]: not all of those
    /// in `in_media`. The second value is the factor on the light, if there is one.
    #[inline(never)]
    fn seek_light(&self, smooth: u32, in_media: u32) -> (u32, Option<Lanes>) {
        let enclosed = in_media & is_enclosed(self.paths.eta_squared).to_bitmask();
        if enclosed == 0 {
            return (smooth, None);
        }
        let u_choice = self.paths.sampler.at_1d(BounceDraw::LightChoice.at(self.paths.depth));
        let chosen = u_choice.simd_lt(Lanes::splat(ENCLOSED_SHARE)).to_bitmask();
        let raised = lanes_of(enclosed).select(Lanes::splat(1.0 / ENCLOSED_SHARE), Lanes::ONE);
        (smooth & (!enclosed | chosen), Some(raised))
    }

    /// Adds the sampled light that arrives.
    #[inline(always)]
    fn trace_shadow_rays(
        &mut self,
        surfaces: &Surfaces,
        coherence: Coherence,
        context: &Context,
        sought: SoughtLight,
        samples: &mut Samples,
    ) {
        let SoughtLight {
            lanes: asked,
            light,
            reflected,
            ..
        } = sought;
        let origin = surfaces.leave(light.wi);
        let is_infinite = lanes_of(light.infinite);
        let shadows = RayLanes {
            origin,
            dir: Vec3Lanes::select(is_infinite, light.wi, light.target - origin),
            t_min: Lanes::ZERO,
            t_max: is_infinite.select(Lanes::splat(f32::INFINITY), Lanes::ONE),
        };
        let obstacles = coherence.obstacles(context.scene, &shadows, asked);
        let lit = asked & !(obstacles.opaque | obstacles.clear);
        let seen = match self.in_media_towards(lit, &light.wi) {
            0 => reflected,
            dimmed => self.dimmed(context, dimmed, shadows, sought),
        };
        self.paths.radiance += seen.only(lanes_of(lit));
        self.note_light(lit, &light.light, seen, samples);
        self.paths.rays += ones_in(asked);
        match obstacles.only_clear() {
            0 => {}
            asked => {
                let through = self.transmitted(context, asked, origin, sought);
                self.paths.radiance += through.only(lanes_of(asked));
                self.note_light(asked, &light.light, through, samples);
            }
        }
    }

    /// The sampled light, attenuated by media for the lanes `asked`, whose `shadows` are unoccluded.
    #[inline(never)]
    fn dimmed(&self, context: &Context, asked: u32, shadows: RayLanes, sought: SoughtLight) -> Vec3Lanes {
        let SoughtLight { light, carried, .. } = sought;
        let (mut media, mut others) = (Held::<PlainMedium<Lanes>>::default(), 0);
        for lane in each_lane(asked) {
            let medium = self.medium_towards(lane, light.wi.get(lane));
            match medium.and_then(|id| context.scene.media.get(id).plain()) {
                Some(medium) => media.set(lane, *medium),
                None => others |= 1 << lane,
            }
        }
        let strategy = context.settings.strategy;
        let mut reflected = sought.reflected;
        if let Some((here, medium)) = media.held() {
            let length = shadows.t_max * shadows.dir.length_squared().sqrt();
            let (passing, passed) = medium.uniform.transmit(length, carried);
            let weight = strategy.light_weight(lanes_of(light.is_delta), light.pdf, sought.bsdf_pdf * passed);
            let of_path = carried * light.radiance * (weight / light.pdf) * passing;
            reflected = Vec3Lanes::select(here, of_path, reflected);
        }
        for lane in each_lane(others) {
            let ray = shadows.get(lane);
            let mut media = self.media_of_shadow(lane, &sought);
            let arriving = media.medium(context.scene, &ray, ray.t_max);
            reflected.set(lane, sought.reflected(lane, strategy, media.passed) * arriving);
        }
        reflected
    }

    /// The media along the shadow ray of a lane.
    fn media_of_shadow(&self, lane: usize, sought: &SoughtLight) -> Media {
        let draw = MediumDraw::Shadow.at(self.paths.depth.as_array()[lane]);
        let sampler = Sampler::gather_lane(&self.paths.sampler, lane);
        let medium = self.medium_towards(lane, sought.light.wi.get(lane));
        Media::new(medium, sought.carried.get(lane), sampler.stream(draw))
    }

    /// The transmitted light of the lanes `asked` at their `origin`, through surfaces that may let it pass, and through
    /// media.
    #[inline(never)]
    fn transmitted(&mut self, context: &Context, asked: u32, origin: Vec3Lanes, sought: SoughtLight) -> Vec3Lanes {
        let SoughtLight {
            light, mut reflected, ..
        } = sought;
        for lane in each_lane(asked) {
            let shadow = ShadowRay {
                origin: origin.get(lane),
                wi: light.wi.get(lane),
                target: light.target(lane),
                crossings: context.settings.crossings(self.paths.depth.as_array()[lane]),
            };
            let part = if context.settings.media {
                let mut media = self.media_of_shadow(lane, &sought);
                let rays = &mut self.paths.rays.as_mut_array()[lane];
                let arriving = passing(context.scene, &shadow, &mut media, rays);
                sought.reflected(lane, context.settings.strategy, media.passed) * arriving
            } else {
                let rays = &mut self.paths.rays.as_mut_array()[lane];
                reflected.get(lane) * passing(context.scene, &shadow, &mut EmptySpace, rays)
            };
            reflected.set(lane, part);
        }
        reflected
    }

    /// Samples directions for the paths, in world space, and returns the lanes whose direction has a density rather
    /// than being the only one of a lobe.
    #[inline(always)]
    fn sample_bsdfs(
        &self,
        surfaces: &Surfaces,
        context: &Context,
        guided: Option<&Guided>,
    ) -> (BsdfSample<Lanes>, u32) {
        let Surfaces { lanes, other, .. } = *surfaces;
        let (bsdf, sampler) = (&self.vertices.bsdf, &self.paths.sampler);
        let u_lobe = match bsdf.choosing() | other {
            0 => Lanes::ZERO,
            _ => sampler.at_1d(BounceDraw::Lobe.at(self.paths.depth)),
        };
        let u_direction = sampler.at_2d(BounceDraw::Direction.at(self.paths.depth));
        let tables = context.scene.materials.tables();
        let local = self.vertices.sample(tables, surfaces.wo, u_lobe, u_direction);
        let mut sample = BsdfSample::<Lanes> {
            wi: surfaces.frame.to_world(local.wi),
            ..local
        };
        if let Some(factor) = self.vertices.bump_shadow(sample.wi) {
            sample.weight = sample.weight * factor;
            sample.is_returned &= factor.simd_gt(Lanes::ZERO);
        }
        if other != 0 {
            sample = self.vertices.sample_others(lanes, u_lobe, u_direction, sample);
        }
        let smooth = surfaces.smooth & !sample.is_delta.to_bitmask();
        match guided {
            Some(guided) => {
                // A direction from a smooth coat is a delta sample and stays.
                let delta = sample.is_delta & sample.is_returned;
                let here = guided.lanes() & !delta.to_bitmask();
                let sample = self.guide(guided, surfaces, tables, here, u_direction, sample);
                (sample, smooth | here)
            }
            None => (sample, smooth),
        }
    }

    /// The BSDF samples `sample`, in world space, and in guided lanes samples of the mixture with their guides. Not
    /// inlined, so that the code for paths without a guide is unchanged.
    #[inline(never)]
    fn guide(
        &self,
        guided: &Guided,
        surfaces: &Surfaces,
        tables: &ShadingTables,
        here: u32,
        u: [Lanes; 2],
        sample: BsdfSample<Lanes>,
    ) -> BsdfSample<Lanes> {
        let Surfaces { frame, wo, .. } = *surfaces;
        let u_lobe = self.paths.sampler.at_1d(BounceDraw::Lobe.at(self.paths.depth));
        let others = surfaces.other & here;
        let eval_and_pdf = |wi: Vec3Lanes, is_there: u32| {
            let (value, pdf) = self.vertices.eval_and_pdf(tables, wo, frame, wi);
            match others & is_there {
                0 => (value, pdf),
                asked => self.vertices.eval_others(asked, wi, value, pdf),
            }
        };
        guided.sample(here, eval_and_pdf, u_lobe, u, sample)
    }

    /// Sets the next rays of the paths. True in the lanes whose light is not absorbed.
    #[inline(always)]
    fn bounce(&mut self, surfaces: &Surfaces, sample: &BsdfSample<Lanes>, scattered: u32) -> Lanes {
        let Surfaces { lanes, here, .. } = *surfaces;
        let path = &mut self.paths;
        path.throughput = Vec3Lanes::select(here, path.throughput * sample.weight, path.throughput);
        path.eta_squared = here.select(roulette::eta_squared(path.eta_squared, sample.eta), path.eta_squared);
        path.is_straight &= !lanes;

        path.arrival.is_sampled = path.arrival.is_sampled & !lanes | scattered;
        path.arrival.pdf = here.select(sample.pdf, path.arrival.pdf);
        let from = &mut path.arrival.from;
        from.position = Vec3Lanes::select(here, surfaces.reference.position, from.position);
        from.normal = Vec3Lanes::select(here, surfaces.reference.normal, from.normal);
        from.halved = from.halved & !lanes | surfaces.reference.halved & lanes;

        path.ray.origin = Vec3Lanes::select(here, surfaces.leave(sample.wi), path.ray.origin);
        path.ray.dir = Vec3Lanes::select(here, sample.wi, path.ray.dir);
        path.ray.t_min = here.select(Lanes::ZERO, path.ray.t_min);
        path.ray.t_max = here.select(Lanes::splat(f32::INFINITY), path.ray.t_max);
        let goes_on = here & sample.is_returned & path.throughput.is_not_zero();
        if MEDIA && self.vertices.borders != 0 {
            self.enter_media(self.vertices.borders & lanes, &sample.wi);
        }
        goes_on
    }

    /// Plays Russian roulette. True in the lanes that continue.
    #[inline(always)]
    fn play_roulette(&mut self, surfaces: &Surfaces, settings: &PathSettings, is_scattered: Lanes) -> Lanes {
        let path = &mut self.paths;
        let plays = surfaces.here & roulette::is_played::<Lanes>(settings, path.depth - path.uncounted, is_scattered);
        if !plays.any() {
            return surfaces.here;
        }
        let mut survival = roulette::survival(path.throughput.max_element(), path.eta_squared);
        if self.vertices.in_media() != 0 {
            let in_media = roulette::survival_in_media(path.throughput.max_element(), path.eta_squared);
            survival = lanes_of(self.vertices.in_media()).select(in_media, survival);
        }
        let u = path.sampler.at_1d(BounceDraw::Roulette.at(path.depth));
        path.throughput = Vec3Lanes::select(plays, path.throughput / survival, path.throughput);
        u.simd_lt(survival) | !plays
    }
}
