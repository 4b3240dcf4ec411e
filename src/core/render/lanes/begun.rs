//! Paths in lanes that do not begin at the camera.

use std::sync::atomic::{AtomicBool, Ordering};

use super::batch::PathBatch;
use super::context::{Coherence, Context, STEPS_TO_CANCEL, Samples};
use crate::color::Rgb;
use crate::math::lanes::{LANES, each_lane};
use crate::render::gathering::Arrived;
use crate::render::path::PathSample;
use crate::render::path_state::PathState;

/// All lanes.
const ALL: u32 = (1 << LANES) - 1;

/// See [`super::trace_begun`].
pub(super) fn trace<const MEDIA: bool>(
    context: &Context,
    begun: &[PathState],
    cancel: &AtomicBool,
) -> Option<Vec<Arrived>> {
    let mut batch = PathBatch::<MEDIA>::new(context.view);
    let mut samples = Samples {
        list: vec![(PathSample::default(), 1.0); begun.len()],
        notes: None,
    };
    let mut backs = vec![false; begun.len()];
    let mut waiting = begun.iter().enumerate();
    loop {
        if cancel.load(Ordering::Relaxed) {
            return None;
        }
        for _ in 0..STEPS_TO_CANCEL {
            let mut new = 0;
            for lane in each_lane(!batch.active & ALL) {
                let next = waiting.find(|(job, path)| {
                    let goes_on = path.throughput != Rgb::ZERO;
                    samples.list[*job].0 = path.sample();
                    goes_on
                });
                let Some((job, path)) = next else {
                    break;
                };
                batch.set(lane, path, job);
                new |= 1 << lane;
            }
            if batch.active == 0 {
                let arrived = |((sample, _), meets_back): (&(PathSample, f32), bool)| Arrived {
                    light: sample.radiance,
                    meets_back,
                    rays: sample.rays,
                };
                return Some(samples.list.iter().zip(backs).map(arrived).collect());
            }
            batch.trace(Coherence::Incoherent, context, &mut samples);
            for lane in each_lane(new & batch.active) {
                backs[batch.outputs[lane].job] = batch.meets_back(lane, context);
            }
            batch.step(Coherence::Incoherent, context, &mut samples);
        }
    }
}
