//! Path segments through participating media in lanes: the steps of [`crate::render::medium_path`]. A scattering in a
//! medium is a vertex like those on surfaces. The commonest media are handled in lanes; in others the paths take their
//! steps one by one.

use glam::{Vec2, Vec3};

use super::batch::PathBatch;
use super::context::{Context, Samples, Travelled};
use crate::accel::{Detail, Hit};
use crate::light::LightReference;
use crate::math::lanes::{Lanes, Vec3Lanes, WordLanes, each_lane, lanes_of};
use crate::math::{Held, PerLane, Ray, Real, Vector, offset_origin};
use crate::medium::{MediumId, PlainMedium, Uniform, Way};
use crate::render::dimensions::MediumDraw;
use crate::render::medium_path::is_enclosed;
use crate::render::observer::PathObserver;
use crate::render::roulette;
use crate::render::scene::SurfaceSlot;

impl<'a, const MEDIA: bool> PathBatch<'a, MEDIA> {
    /// The medium that the path of a lane is in.
    #[inline(always)]
    pub(super) fn medium(&self, lane: usize) -> Option<MediumId> {
        if MEDIA { self.paths.medium[lane] } else { None }
    }

    /// The lanes whose paths are in media, a bit each.
    #[inline(always)]
    pub(super) fn in_media(&self) -> u32 {
        match MEDIA {
            false => 0,
            true => {
                each_lane(self.active).fold(0, |lanes, lane| lanes | u32::from(self.medium(lane).is_some()) << lane)
            }
        }
    }

    /// The medium of a path that leaves the vertex of a lane in direction `dir`.
    #[inline(always)]
    pub(super) fn medium_towards(&self, lane: usize, dir: Vec3) -> Option<MediumId> {
        self.vertices.entered(lane, self.medium(lane), dir)
    }

    /// The lanes among `lanes` whose paths are in media after they have left their vertices in the directions `dir`, a
    /// bit each.
    #[inline(always)]
    pub(super) fn in_media_towards(&self, lanes: u32, dir: &Vec3Lanes) -> u32 {
        let is_in_medium = |lane| u32::from(self.medium_towards(lane, dir.get(lane)).is_some());
        match MEDIA {
            false => 0,
            true => each_lane(lanes).fold(0, |found, lane| found | is_in_medium(lane) << lane),
        }
    }

    /// Sets the media that the paths of `lanes` have entered from their vertices in the directions `dir`.
    #[inline(never)]
    pub(super) fn enter_media(&mut self, lanes: u32, dir: &Vec3Lanes) {
        for lane in each_lane(lanes) {
            self.paths.medium[lane] = self.medium_towards(lane, dir.get(lane));
        }
    }

    /// Takes the paths of the lanes `in_media` through the commonest media, up to their hits or to the vertices where
    /// they are scattered before.
    #[inline(never)]
    pub(super) fn travel(&mut self, in_media: u32, context: &Context<'a>) -> Travelled {
        let (scene, settings) = (context.scene, context.settings);
        let mut media = Held::<PlainMedium<Lanes>>::default();
        let mut length = Lanes::splat(f32::INFINITY);
        for lane in each_lane(in_media) {
            // The segment of a camera ray that passes hidden emitters begins before its origin.
            let is_hiding = settings.hide_emitters && self.paths.depth.as_array()[lane] == 0;
            let medium = self.medium(lane).and_then(|id| scene.media.get(id).plain());
            if let Some(medium) = medium.filter(|_| !is_hiding) {
                media.set(lane, *medium);
                if let Some(hit) = &self.hits[lane] {
                    length.as_mut_array()[lane] = hit.t;
                }
            }
        }
        let Some((here, medium)) = media.held() else {
            return Travelled::NOTHING;
        };
        let way = Way::<Lanes> {
            origin: self.paths.ray.origin,
            dir: self.paths.ray.dir,
            length,
        };
        let depth = self.paths.depth + WordLanes::splat(1);
        let u = self.paths.sampler.at_2d(MediumDraw::Distance.at(depth));
        let (lamp, has_lamp) = self.lamps_near(here, &medium.uniform, &way, depth, context);
        let travel = (medium.uniform).travel(&way, lamp, has_lamp, self.paths.throughput, u, |_| medium.albedo);
        let paths = &mut self.paths;
        paths.throughput = Vec3Lanes::select(here, travel.throughput, paths.throughput);
        paths.arrival.pdf = here.select(paths.arrival.pdf * travel.passed, paths.arrival.pdf);
        let scattered = travel.is_scattered.to_bitmask() & media.lanes;
        self.vertices
            .set_media(scattered, way.at(travel.distance), way.dir, medium.phase);
        Travelled {
            lanes: media.lanes,
            scattered,
        }
    }

    /// Points on lights as of [`crate::render::medium_path::Leg`], with a mask of the lanes that have one. The lanes
    /// `here` are in media.
    #[inline(always)]
    fn lamps_near(
        &self,
        here: Lanes,
        medium: &Uniform<Lanes>,
        way: &Way<Lanes>,
        depth: WordLanes,
        context: &Context,
    ) -> (Vec3Lanes, Lanes) {
        let (lights, settings) = (&context.scene.lights, context.settings);
        let nothing = (Vec3Lanes::ZERO, Lanes::ZERO);
        let Some(bounds) = lights.finite_bounds().filter(|_| settings.strategy.samples_lights()) else {
            return nothing;
        };
        let is_last = Lanes::is_at_least(depth - self.paths.uncounted, settings.longest_path());
        let near = medium.may_be_near(way, Vec3Lanes::splat(bounds.center()), bounds.radius())
            & here
            & !is_last
            & !is_enclosed(self.paths.eta_squared);
        if !near.any() {
            return nothing;
        }
        let u = self.paths.sampler.at_2d(MediumDraw::LampPoint.at(depth));
        if let Some(places) = context.sole_light.and_then(|(_, light)| light.place(u)) {
            return (places, near);
        }
        let u_choice = self.paths.sampler.at_1d(MediumDraw::Lamp.at(depth));
        let middle = way.at(medium.midway(way.length));
        let (mut places, mut found) = (Vec3Lanes::ZERO, 0);
        for lane in each_lane(near.to_bitmask()) {
            let [u_choice, x, y] = [u_choice, u[0], u[1]].map(|numbers| numbers.as_array()[lane]);
            let reference = LightReference {
                position: middle.get(lane),
                normal: None,
            };
            if let Some(place) = lights.sample_place(&reference, u_choice, Vec2::new(x, y)) {
                places.set(lane, place);
                found |= 1 << lane;
            }
        }
        (places, lanes_of(found))
    }

    /// Continues the path of a lane at the end of its segment through a medium.
    #[inline(never)]
    pub(super) fn go_on(
        &mut self,
        lane: usize,
        hit: Option<Hit>,
        travelled: Travelled,
        context: &Context<'a>,
        samples: &mut Samples,
    ) {
        if travelled.lanes >> lane & 1 == 0 {
            self.advance_alone(lane, hit, context, samples);
            return;
        }
        let throughput = self.paths.throughput.get(lane);
        if travelled.scattered >> lane & 1 == 0 {
            match hit {
                _ if throughput == Vec3::ZERO => self.finish_here(lane, samples),
                Some(hit) => self.arrive(lane, hit, context, samples),
                None => self.escape(lane, context, samples),
            }
            return;
        }
        let depth = self.paths.depth.as_array()[lane];
        let segments = depth - self.paths.uncounted.as_array()[lane];
        let record = &mut self.paths.record[lane];
        if let Some(hit) = &hit {
            if depth == 0 {
                record.meet(hit);
            }
            let mut observer = samples.observer(self.outputs[lane].job);
            observer.met(&self.paths.ray.get(lane), hit);
        }
        if throughput != Vec3::ZERO {
            record.take_medium_features(throughput);
        }
        if throughput == Vec3::ZERO || context.settings.is_last(segments + 1) {
            self.vertices.leave_medium(lane);
            self.finish_here(lane, samples);
        }
    }

    /// Takes the path of a lane to a surface with media on its sides.
    #[inline(never)]
    pub(super) fn arrive_at_border(
        &mut self,
        lane: usize,
        hit: Hit,
        slot: &SurfaceSlot,
        context: &Context<'a>,
        samples: &mut Samples,
    ) {
        let is_unnoticed = slot.light.is_none() && context.scene.materials.is_null(slot.material);
        if is_unnoticed && samples.notes.is_none() && self.pass(lane, &hit, slot, context) {
            return;
        }
        let ray = self.paths.ray.get(lane);
        let met = match self.vertices.set_plain(lane, context.scene, &ray, &hit, slot) {
            Some(met) => Some(met),
            None => self.vertices.set_other(lane, context.scene, &ray, &hit, slot),
        };
        match met {
            Some(met) => {
                self.vertices.set_sides(lane, slot.media);
                self.look(lane, &hit, slot, &met, context, samples);
            }
            None => self.arrive_alone(lane, hit, context, samples),
        }
    }

    /// Lets the path of a lane pass an invisible surface. False, without a change, if roulette might end the path
    /// there.
    #[inline(always)]
    fn pass(&mut self, lane: usize, hit: &Hit, slot: &SurfaceSlot, context: &Context<'a>) -> bool {
        let depth = self.paths.depth.as_array()[lane];
        let uncounted = self.paths.uncounted.as_array()[lane];
        if roulette::is_played::<f32>(context.settings, depth - uncounted, false) {
            return false;
        }
        let ray = self.paths.ray.get(lane);
        let point = context.scene.geometry.surface_in(&ray, hit, Detail::Plain);
        if depth == 0 {
            self.paths.record[lane].meet(hit);
        }
        (depth + 1).scatter_lane(&mut self.paths.depth, lane);
        (uncounted + 1).scatter_lane(&mut self.paths.uncounted, lane);
        let normal = point.geometric_normal;
        self.paths.medium[lane] = slot.media.entered(self.medium(lane), ray.dir, normal);
        let beyond = offset_origin(point.position, point.error, normal, ray.dir);
        Ray::new(beyond, ray.dir).scatter_lane(&mut self.paths.ray, lane);
        true
    }
}
