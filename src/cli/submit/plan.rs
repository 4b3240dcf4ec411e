//! The division of a job into tasks: frames, crops, and ranges of samples at whose ends pictures may be cut.

use std::ops::RangeInclusive;

use sunroom::render::part::Crop;
use sunroom::render::passes::chunk_of;
use sunroom::render::tile::TILE;

/// The least side, in pixels, of a crop that the user has not asked for. A smaller crop costs more to start than to
/// render.
const LEAST_CROP: u32 = 256;
/// The factor by which a task may exceed the requested time, before crops divide it further.
const TOLERANCE: f64 = 1.25;

/// The tasks of a job. Task `n` renders range `n % ranges` of crop `n / ranges % crops` of the frames of group `n /
/// ranges / crops`.
#[derive(Debug, PartialEq, Eq)]
pub struct Plan {
    /// The numbers of the frames; 0 for the single picture of a still.
    pub frames: RangeInclusive<u32>,
    /// The number of frames that a task renders in turn, at least 1.
    pub frames_a_task: u32,
    /// The ends of the ranges of samples, from 0 to the number of samples per pixel.
    pub cuts: Vec<u32>,
    /// The crops of a frame, which cover it exactly.
    pub crops: Vec<Crop>,
}

/// The job to be divided.
#[derive(Clone, Debug)]
pub struct Whole {
    /// The numbers of the frames.
    pub frames: RangeInclusive<u32>,
    /// Samples per pixel.
    pub spp: u32,
    /// The width and the height of a frame in pixels.
    pub size: [u32; 2],
    /// The requested columns and rows of crops.
    pub grid: Option<[u32; 2]>,
}

impl Plan {
    /// Divides frames, each of which takes `frame_seconds`, into tasks of about `task_seconds`: either a frame is
    /// divided, or a task gets several frames. A frame is divided by its samples as long as the ranges can be short
    /// enough, and beyond that it is cropped as well.
    pub fn of_times(whole: Whole, frame_seconds: f64, task_seconds: f64) -> Result<Self, String> {
        let count = f64::from(whole.frames.end() - whole.frames.start()) + 1.0;
        let frames_a_task = match whole.grid {
            Some(_) => 1,
            None => (task_seconds / frame_seconds).floor().clamp(1.0, count) as u32,
        };
        let most = f64::from(u32::MAX);
        let shares = (frame_seconds / task_seconds).ceil().clamp(1.0, most) as u32;
        let [columns, rows] = match whole.grid {
            Some(grid) => grid,
            None => grid_for(whole.size, whole.spp, shares),
        };
        let ranges = shares.div_ceil(columns.saturating_mul(rows));
        Ok(Self {
            frames_a_task,
            ..Self::of_shares(
                Whole {
                    grid: Some([columns, rows]),
                    ..whole
                },
                ranges,
            )?
        })
    }

    /// Divides the samples of each frame into this number of ranges, or fewer if pictures cannot be cut so often. An
    /// error says that the picture has too few tiles for the requested crops.
    pub fn of_shares(whole: Whole, shares: u32) -> Result<Self, String> {
        Ok(Self {
            frames: whole.frames,
            frames_a_task: 1,
            cuts: cuts(whole.spp, shares),
            crops: crops(whole.size, whole.grid.unwrap_or([1; 2]))?,
        })
    }

    /// The number of ranges of a frame.
    pub fn ranges(&self) -> usize {
        self.cuts.len() - 1
    }

    /// The number of tasks.
    pub fn tasks(&self) -> u64 {
        let count = u64::from(self.frames.end() - self.frames.start()) + 1;
        count.div_ceil(self.frames_a_task.into()) * (self.ranges() * self.crops.len()) as u64
    }
}

/// The columns and rows of crops for this number of tasks of about equal length: no more than needed, because crops
/// take unequal times, and ranges of samples equal ones.
fn grid_for(size: [u32; 2], spp: u32, shares: u32) -> [u32; 2] {
    let most = size.map(|side| (side / LEAST_CROP).max(1));
    let is_short = |&[columns, rows]: &[u32; 2]| {
        let cuts = cuts(spp, shares.div_ceil(columns * rows));
        let longest = cuts.windows(2).map(|range| range[1] - range[0]).max().unwrap_or(spp);
        f64::from(longest) / f64::from(spp) / f64::from(columns * rows) <= TOLERANCE / f64::from(shares)
    };
    let mut grid = [1; 2];
    while !is_short(&grid) && grid != most {
        // The longer side of a crop is divided next.
        let side = |axis: usize| size[axis] / grid[axis];
        let axis = match grid[0] < most[0] && (grid[1] == most[1] || side(0) >= side(1)) {
            true => 0,
            false => 1,
        };
        grid[axis] += 1;
    }
    grid
}

/// Cuts a picture into columns and rows of crops of whole tiles, as equal as possible.
fn crops(size: [u32; 2], grid: [u32; 2]) -> Result<Vec<Crop>, String> {
    let tiles = size.map(|side| side.div_ceil(TILE));
    let [width, height] = size;
    if grid[0] > tiles[0] || grid[1] > tiles[1] {
        return Err(format!(
            "crops are made of tiles of {TILE} x {TILE} pixels: a picture of {width} x {height} pixels can be cut into {}x{} at most",
            tiles[0], tiles[1]
        ));
    }
    let edge = |axis: usize, place: u32| {
        let tile = (u64::from(tiles[axis]) * u64::from(place) / u64::from(grid[axis])) as u32;
        (tile * TILE).min(size[axis])
    };
    let of = |column: u32, row: u32| {
        let [x, y] = [edge(0, column), edge(1, row)];
        let [width, height] = [edge(0, column + 1) - x, edge(1, row + 1) - y];
        Crop { x, y, width, height }
    };
    Ok((0..grid[1])
        .flat_map(|row| (0..grid[0]).map(move |column| of(column, row)))
        .collect())
}

/// The sample indices, nearest to equal shares, at which a picture of `spp` samples may be cut.
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

    fn whole(frames: RangeInclusive<u32>, spp: u32, size: [u32; 2]) -> Whole {
        let grid = None;
        Whole {
            frames,
            spp,
            size,
            grid,
        }
    }

    #[test]
    fn long_frames_are_divided_and_short_ones_are_put_together() {
        let plan =
            |frames, spp, seconds| Plan::of_times(whole(frames, spp, [160, 120]), seconds, 600.0).expect("a plan");
        let long = plan(0..=5, 256, 3600.0);
        assert_eq!((long.frames_a_task, long.tasks()), (1, 36));
        let short = plan(1..=120, 64, 10.0);
        assert_eq!((short.frames_a_task, short.ranges(), short.tasks()), (60, 1, 2));
        assert_eq!(plan(0..=0, 64, 10.0).tasks(), 1);
        let shares = Plan::of_shares(whole(0..=0, 64, [160, 120]), 4).expect("a plan");
        assert_eq!((shares.tasks(), shares.crops.len()), (4, 1));
    }

    #[test]
    fn what_ranges_cannot_divide_is_cropped() {
        // 40 hours in tasks of ten minutes are 240 tasks, and a range has at least a sixteenth of the samples.
        let plan = |size| Plan::of_times(whole(0..=0, 4096, size), 144_000.0, 600.0).expect("a plan");
        let large = plan([1920, 1080]);
        let longest = large
            .cuts
            .windows(2)
            .map(|range| range[1] - range[0])
            .max()
            .unwrap_or(0);
        let seconds = 144_000.0 * f64::from(longest) / 4096.0 / large.crops.len() as f64;
        assert!(seconds <= TOLERANCE * 600.0, "{seconds}");
        assert!((240 * 4 / 5..400).contains(&large.tasks()), "{}", large.tasks());
        // Crops of a small picture would be too small.
        assert_eq!(plan([320, 240]).crops.len(), 1);
        assert_eq!(plan([640, 240]).crops.len(), 2);
        // Few tasks need no crops.
        let few = Plan::of_times(whole(0..=0, 4096, [1920, 1080]), 4800.0, 600.0).expect("a plan");
        assert_eq!((few.ranges(), few.crops.len()), (8, 1));
    }

    #[test]
    fn crops_are_all_of_the_picture_and_end_where_tiles_do() {
        for (size, grid) in [
            ([1920, 1080], [4, 3]),
            ([100, 33], [4, 2]),
            ([1, 1], [1, 1]),
            ([70, 4000], [3, 7]),
        ] {
            let crops = crops(size, grid).expect("there are enough tiles");
            assert_eq!(crops.len() as u32, grid[0] * grid[1]);
            assert!(
                crops.iter().all(|crop| crop.check(size[0], size[1]).is_ok()),
                "{crops:?}"
            );
            let pixels: u32 = crops.iter().map(|crop| crop.width * crop.height).sum();
            assert_eq!(pixels, size[0] * size[1]);
            let count = |tile| crops.iter().filter(|crop| crop.has(tile)).count();
            assert!(
                sunroom::render::tile::tiles(size[0], size[1])
                    .into_iter()
                    .all(|tile| count(tile) == 1)
            );
        }
        let message = crops([100, 33], [5, 1]).expect_err("four tiles are in a row");
        assert!(message.contains("4x2 at most"), "{message}");
    }

    #[test]
    fn crops_that_are_asked_for_are_divided_by_ranges() {
        let grid = Some([4, 2]);
        let asked = Whole {
            grid,
            ..whole(0..=9, 256, [640, 480])
        };
        let shares = Plan::of_shares(asked.clone(), 2).expect("a plan");
        assert_eq!((shares.ranges(), shares.tasks()), (2, 160));
        let times = Plan::of_times(asked, 9600.0, 600.0).expect("a plan");
        assert_eq!((times.frames_a_task, times.ranges(), times.tasks()), (1, 2, 160));
    }
}
