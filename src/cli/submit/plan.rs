//! The division of a job into tasks: frames, and ranges of samples at whose ends pictures may be cut.

use std::ops::RangeInclusive;

use sunroom::render::passes::chunk_of;

/// The tasks of a job. Task `n` renders range `n % ranges` of the frames of group `n / ranges`.
#[derive(Debug, PartialEq, Eq)]
pub struct Plan {
    /// The numbers of the frames; 0 is the one picture of a still.
    pub frames: RangeInclusive<u32>,
    /// The frames that a task renders one after the other, at least 1.
    pub frames_a_task: u32,
    /// The ends of the ranges of samples, from 0 to the number of samples per pixel.
    pub cuts: Vec<u32>,
}

impl Plan {
    /// Divides `spp` samples of each frame, of which one frame takes `frame_seconds`, into tasks of about `task_seconds`: either a frame is divided, or a task
    /// gets several frames.
    pub fn of_times(frames: RangeInclusive<u32>, spp: u32, frame_seconds: f64, task_seconds: f64) -> Self {
        let count = f64::from(frames.end() - frames.start()) + 1.0;
        let frames_a_task = (task_seconds / frame_seconds).floor().clamp(1.0, count) as u32;
        let shares = (frame_seconds / task_seconds).ceil().clamp(1.0, f64::from(spp)) as u32;
        Self {
            frames,
            frames_a_task,
            cuts: cuts(spp, shares),
        }
    }

    /// Divides each frame into this number of ranges, or fewer where pictures cannot be cut so often.
    pub fn of_shares(frames: RangeInclusive<u32>, spp: u32, shares: u32) -> Self {
        Self {
            frames,
            frames_a_task: 1,
            cuts: cuts(spp, shares),
        }
    }

    /// The number of ranges of a frame.
    pub fn ranges(&self) -> usize {
        self.cuts.len() - 1
    }

    /// The number of tasks.
    pub fn tasks(&self) -> u64 {
        let count = u64::from(self.frames.end() - self.frames.start()) + 1;
        count.div_ceil(self.frames_a_task.into()) * self.ranges() as u64
    }
}

/// The places nearest to equal shares at which a picture of `spp` samples may be cut.
fn cuts(spp: u32, shares: u32) -> Vec<u32> {
    let shares = shares.clamp(1, spp.max(1));
    let mut cuts: Vec<u32> = (0..shares)
        .map(|share| {
            let ideal = (u64::from(spp) * u64::from(share) / u64::from(shares)) as u32;
            let around = chunk_of(ideal);
            match ideal - around.start <= around.end - ideal {
                true => around.start,
                false => around.end,
            }
        })
        .collect();
    cuts.retain(|&cut| cut < spp);
    cuts.push(spp);
    cuts.dedup();
    cuts
}

#[cfg(test)]
mod tests {
    use sunroom::render::passes::is_cut;

    use super::*;

    #[test]
    fn ranges_are_nearly_equal_and_begin_where_pictures_may_be_cut() {
        assert_eq!(cuts(256, 8), [0, 32, 64, 96, 128, 160, 192, 224, 256]);
        assert_eq!(cuts(256, 1), [0, 256]);
        assert_eq!(cuts(1, 7), [0, 1]);
        for (spp, shares) in [(1000, 3), (10, 10), (4096, 100), (1_000_000, 1000), (37, 5)] {
            let cuts = cuts(spp, shares);
            assert!(
                cuts.len() >= 2 && cuts[0] == 0 && cuts[cuts.len() - 1] == spp,
                "{cuts:?}"
            );
            assert!(cuts.is_sorted_by(|a, b| a < b), "{cuts:?}");
            assert!(cuts[..cuts.len() - 1].iter().all(|&cut| is_cut(cut)), "{cuts:?}");
        }
    }

    #[test]
    fn long_frames_are_divided_and_short_ones_are_put_together() {
        let long = Plan::of_times(0..=5, 256, 3600.0, 600.0);
        assert_eq!((long.frames_a_task, long.tasks()), (1, 36));
        let short = Plan::of_times(1..=120, 64, 10.0, 600.0);
        assert_eq!((short.frames_a_task, short.ranges(), short.tasks()), (60, 1, 2));
        let still = Plan::of_times(0..=0, 64, 10.0, 600.0);
        assert_eq!(still.tasks(), 1);
        assert_eq!(Plan::of_shares(0..=0, 64, 4).tasks(), 4);
    }
}
