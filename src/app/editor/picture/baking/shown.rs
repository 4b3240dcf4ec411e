//! The pictures of a bake that the window shows. The thread that bakes makes them.

use std::sync::Arc;
use std::time::{Duration, Instant};

use bevy_egui::egui::{Color32, ColorImage};

use super::thread::Shared;
use crate::app::editor::picture::compare::{LitPicture, Look, Snapshot};
use crate::bake::glimpse::Glimpse;
use crate::bake::job::BakeJob;
use crate::bake::preview::SeenPixels;
use crate::memory::Shortage;
use crate::render::tonemap::Display;

/// The longest side of the small picture of a lightmap, in pixels.
const LARGEST: u32 = 512;
/// The time between two pictures while light is gathered.
const INTERVAL: Duration = Duration::from_millis(500);
/// While the window wants the same view, pictures take at most the share 1 / (1 + this) of the time, or more after
/// [`LONGEST_PAUSE`].
const WORK_PER_PICTURE: u32 = 20;
/// The longest pause after a picture, so that it is seen to grow on a slow or busy machine as well.
const LONGEST_PAUSE: Duration = Duration::from_secs(2);
/// The same while the view that the window wants changes, such as its camera.
const WORK_PER_CHANGE: u32 = 3;

/// The pictures that the window wants.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Wanted {
    /// The lightmap, from 0.
    pub page: usize,
    /// The settings that turn light into colours.
    pub display: Display,
    /// The view of the level lit by its lightmaps; None if it is not shown.
    pub look: Option<Look>,
}

/// A small picture of a lightmap.
#[derive(Clone, Debug)]
pub struct PagePicture {
    /// The lightmap, from 0.
    pub page: usize,
    /// The picture: the look of a white surface there; transparent outside of surfaces.
    pub image: Arc<ColorImage>,
}

/// The pictures of a bake: when the last was made, and how long it took.
#[derive(Default)]
pub(super) struct Showing {
    last: Option<(Instant, Duration, Wanted)>,
    /// The visible point in each pixel of the last view.
    seen: Option<(Look, SeenPixels)>,
}

impl Showing {
    /// Makes new pictures of the job, if it is time.
    pub fn look(&mut self, shared: &Shared, job: &BakeJob) {
        let wanted = shared.wanted();
        let is_early = |(at, cost, shown): &(Instant, Duration, Wanted)| {
            let pause = match *shown == wanted {
                true => INTERVAL.max(*cost * WORK_PER_PICTURE),
                false => *cost * WORK_PER_CHANGE,
            };
            at.elapsed() < pause.min(LONGEST_PAUSE)
        };
        if !self.last.as_ref().is_some_and(is_early) {
            self.show_now(shared, job, &wanted);
        }
    }

    /// Makes new pictures of the job.
    pub fn show_now(&mut self, shared: &Shared, job: &BakeJob, wanted: &Wanted) {
        let begin = Instant::now();
        let page = wanted.page.min(job.blueprint().page_count() - 1);
        let glimpse = match job.baked() {
            Some(baked) => job.blueprint().glimpse_of(page, &baked.lightmaps[page], LARGEST),
            None => job.blueprint().glimpse(page, job.light(), LARGEST),
        };
        let image = Arc::new(picture(&glimpse, &wanted.display));
        let lit = match &wanted.look {
            Some(look) => self.lit(job, look).map(Some),
            None => {
                self.seen = None;
                Ok(None)
            }
        };
        let blind = lit
            .as_ref()
            .err()
            .map(|shortage| format!("The level is not shown by its lightmaps: that needs {shortage}"));
        shared.tell(|news| {
            news.picture = Some(PagePicture { page, image });
            news.lit = lit.unwrap_or_default();
            news.blind = blind;
        });
        self.last = Some((Instant::now(), begin.elapsed(), wanted.clone()));
    }
}

impl Showing {
    fn lit(&mut self, job: &BakeJob, look: &Look) -> Result<Arc<LitPicture>, Shortage> {
        let known = self.seen.take().filter(|(known, _)| known == look);
        let seen = match known {
            Some((_, seen)) => seen,
            None => job.see(&look.camera, look.size.into(), &look.sight, look.hides_emitters)?,
        };
        let picture = Snapshot {
            size: look.size,
            film_corners: look.film_corners,
            radiance: job.lit(&seen),
            samples: job.light().samples(),
        };
        self.seen = Some((look.clone(), seen));
        Ok(Arc::new(LitPicture {
            look: look.clone(),
            picture,
            is_finished: job.baked().is_some(),
        }))
    }
}

fn picture(glimpse: &Glimpse, display: &Display) -> ColorImage {
    let encoder = display.encoder();
    let color = |white: &Option<_>| match white {
        Some(white) => {
            let [red, green, blue] = encoder.encode(*white);
            Color32::from_rgb(red, green, blue)
        }
        None => Color32::TRANSPARENT,
    };
    let size = glimpse.size.to_array().map(|side| side as usize);
    ColorImage::new(size, glimpse.white.iter().map(color).collect())
}
