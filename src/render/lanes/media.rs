//! The ways of paths in lanes through participating media: the steps of [`crate::render::medium_path`]. How far a ray goes is found lane by lane. Where it is
//! scattered is a vertex like those on surfaces, and the rest is done in lanes.

use super::batch::PathBatch;
use super::context::{Context, Samples};
use crate::accel::Hit;
use crate::color::Rgb;
use crate::math::PerLane;
use crate::math::lanes::each_lane;
use crate::medium::{MediumId, Way};
use crate::render::medium_path::Leg;
use crate::render::observer::PathObserver;
use crate::sampling::Sampler;

impl<'a> PathBatch<'a> {
    /// The medium that the path of a lane is in.
    #[inline(always)]
    pub(super) fn medium(&self, lane: usize) -> Option<MediumId> {
        // Without media the list is not looked at.
        if self.has_media { self.paths.medium[lane] } else { None }
    }

    /// The lanes whose paths are in media, a bit each.
    #[inline(always)]
    pub(super) fn in_media(&self) -> u32 {
        match self.has_media {
            false => 0,
            true => {
                each_lane(self.active).fold(0, |lanes, lane| lanes | u32::from(self.medium(lane).is_some()) << lane)
            }
        }
    }

    /// Takes the path of a lane through its medium, up to `hit` or to the place where it is scattered before.
    #[inline(never)]
    pub(super) fn travel(
        &mut self,
        lane: usize,
        id: MediumId,
        hit: Option<Hit>,
        context: &Context<'a>,
        samples: &mut Samples,
    ) {
        let (scene, settings) = (context.scene, context.settings);
        let medium = scene.media.get(id);
        let depth = self.paths.depth.as_array()[lane];
        let hides_emitters = settings.hide_emitters && depth == 0;
        let Some(g) = medium.plain_phase().filter(|_| !hides_emitters) else {
            self.advance_alone(lane, hit, context, samples);
            return;
        };
        let ray = self.paths.ray.get(lane);
        let segments = depth - self.paths.uncounted.as_array()[lane];
        let leg = Leg {
            way: Way {
                origin: ray.origin,
                dir: ray.dir,
                length: hit.map_or(f32::INFINITY, |hit| hit.t),
            },
            depth,
            segments,
            sampler: Sampler::gather_lane(&self.paths.sampler, lane),
        };
        let mut throughput = self.paths.throughput.get(lane);
        let travel = leg.travel(scene, settings, medium, &mut throughput);
        self.paths.throughput.set(lane, throughput);
        self.paths.arrival.pdf.as_mut_array()[lane] *= travel.passed;
        let mut observer = samples.observer(self.outputs[lane].job);
        if travel.emitted != Rgb::ZERO && settings.max_depth > 0 {
            let radiance = self.paths.radiance.get(lane) + travel.emitted;
            self.paths.radiance.set(lane, radiance);
            observer.emitted(travel.emitted);
        }
        let Some(distance) = travel.scattered_at else {
            match hit {
                _ if throughput == Rgb::ZERO => self.finish_here(lane, samples),
                Some(hit) => self.arrive(lane, hit, context, samples),
                None => self.escape(lane, context, samples),
            }
            return;
        };
        let record = &mut self.paths.record[lane];
        if let Some(hit) = &hit {
            if depth == 0 {
                record.meet(hit);
            }
            observer.met(&ray, hit);
        }
        if throughput == Rgb::ZERO {
            self.finish_here(lane, samples);
            return;
        }
        record.take_medium_features(throughput);
        if settings.is_last(segments + 1) {
            self.finish_here(lane, samples);
            return;
        }
        self.vertices
            .set_medium(lane, leg.way.origin + leg.way.dir * distance, ray.dir, g);
    }
}
