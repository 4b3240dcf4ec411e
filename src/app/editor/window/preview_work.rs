//! Renders a picture of a material on a thread of the lowest priority, in passes.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use bevy::prelude::*;
use bevy_egui::egui;
use crossbeam_channel::{Receiver, Sender, unbounded};

use crate::app::editor::model::panel_textures::Ball;
use crate::app::editor::picture::ball_picture::without_noise;
use crate::app::editor::picture::material_ball::{BallMaterial, MaterialBall};
use crate::app::editor::session::picture_cache::{Kept, PictureCache};
use crate::engine::{WakeUp, yield_to_all, yield_to_window};
use crate::render::tonemap::Display;

/// The quality of a picture.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Quality {
    /// The edge in pixels: sharp at twice its size in points.
    pub edge: u32,
    /// The samples of a pixel.
    pub samples: u32,
}

/// The samples that all pictures get before any gets more.
pub(super) const ROUGH: u32 = 4;

/// A picture that is being rendered.
pub(super) struct Work {
    pub ball: Ball,
    pub look: BallMaterial,
    /// Its final quality.
    pub quality: Quality,
    cancel: Arc<AtomicBool>,
    pub passes: Receiver<Pass>,
}

/// The picture after another pass.
pub(super) struct Pass {
    pub samples: u32,
    pub image: egui::ColorImage,
}

impl Drop for Work {
    fn drop(&mut self) {
        self.cancel.store(true, Ordering::Relaxed);
    }
}

/// Starts the rendering. `kept`: the cache of pictures, and the key in it.
pub(super) fn start(
    ball: Ball,
    look: BallMaterial,
    quality: Quality,
    kept: Option<(Arc<str>, PictureCache)>,
    wake_up: WakeUp,
) -> Option<Work> {
    let cancel = Arc::new(AtomicBool::new(false));
    let (sender, passes) = unbounded();
    let (flag, shown) = (cancel.clone(), look.clone());
    let work = move || {
        // A first picture must appear soon, so that its thread yields to the window only.
        if quality.samples <= ROUGH {
            yield_to_window();
        } else {
            yield_to_all();
        }
        match &kept {
            Some((key, cache)) => render_or_take(&shown, quality, (key, cache), &flag, &sender, &wake_up),
            None => drop(render(&shown, quality, &flag, &sender, &wake_up)),
        }
        // The channel is closed before the window polls it again.
        drop(sender);
        wake(&wake_up);
    };
    match std::thread::Builder::new().name("preview".to_owned()).spawn(work) {
        Ok(_) => Some(Work {
            ball,
            look,
            quality,
            cancel,
            passes,
        }),
        Err(error) => {
            error!("A thread for the preview of a material could not be started: {error}");
            None
        }
    }
}

/// Takes the picture from the cache, or renders and caches it.
fn render_or_take(
    look: &BallMaterial,
    quality: Quality,
    (key, cache): (&str, &PictureCache),
    cancel: &AtomicBool,
    passes: &Sender<Pass>,
    wake_up: &WakeUp,
) {
    let edge = quality.edge as usize;
    if let Some(kept) = cache.get(key).filter(|kept| kept.image.size == [edge; 2]) {
        // The receiver is gone if the picture is no longer needed.
        let _ = passes.send(Pass {
            samples: quality.samples,
            image: kept.image,
        });
    } else if let Some(image) = render(look, quality, cancel, passes, wake_up)
        && quality.samples > ROUGH
    {
        let text = String::new();
        cache.keep(key, &Kept { image, text });
    }
}

/// Renders in passes, each doubling the samples, until there are enough or the picture is no longer needed. Returns the
/// last.
fn render(
    look: &BallMaterial,
    quality: Quality,
    cancel: &AtomicBool,
    passes: &Sender<Pass>,
    wake_up: &WakeUp,
) -> Option<egui::ColorImage> {
    let Quality { edge, samples } = quality;
    let ball = MaterialBall::new(look, edge)?;
    let mut film = ball.film();
    let mut rgba = vec![0; (4 * edge * edge) as usize];
    loop {
        let more = film.sample_count().max(1);
        ball.refine(&mut film, more, cancel)?;
        let done = film.sample_count();
        let radiance = match done >= ROUGH {
            true => without_noise(&film, Some(1), cancel),
            false => film.radiance(),
        };
        Display::default().encode_rgba(&radiance, &mut rgba);
        let image = egui::ColorImage::from_rgba_unmultiplied([edge as usize; 2], &rgba);
        let pass = Pass {
            samples: done,
            image: image.clone(),
        };
        passes.send(pass).ok()?;
        wake(wake_up);
        if done >= samples {
            return Some(image);
        }
    }
}

pub(super) fn wake(wake_up: &WakeUp) {
    if let Some(wake) = &wake_up.0 {
        wake();
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::color::Rgb;
    use crate::material::{Material, MaterialId, MaterialTable};
    use crate::shading::{Bsdf, Diffuse};

    #[test]
    fn passes_double_and_end() {
        let paint = Material::Plain(Bsdf::Diffuse(Diffuse {
            reflectance: Rgb::splat(0.5),
        }));
        let look = BallMaterial {
            materials: Arc::new(MaterialTable::new(vec![paint]).expect("no circles")),
            textures: Arc::default(),
            material: MaterialId(0),
            inside: None,
        };
        const QUALITY: Quality = Quality { edge: 8, samples: 4 };
        let entity = Entity::from_raw_u32(1).expect("a small index is valid");
        let work = start(Ball::Material(entity), look, QUALITY, None, WakeUp::default()).expect("a thread");
        let samples: Vec<u32> = work.passes.iter().map(|pass| pass.samples).collect();
        assert_eq!(samples, [1, 2, 4]);
    }
}
