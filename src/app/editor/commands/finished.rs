//! The present picture, for commands that save or copy it.

use std::sync::atomic::AtomicBool;

use bevy::prelude::*;

use super::display::set_display;
use crate::app::editor::command::display::{DisplayMode, DisplaySettings};
use crate::app::editor::command::error::CommandError;
use crate::app::editor::command::light_mix::{FilmLights, LightMix};
use crate::app::editor::picture::awaited_image::{AwaitedImage, Before};
use crate::app::editor::picture::compare::{Comparison, Measured, PixelComparison, Snapshot};
use crate::app::editor::picture::denoised::Denoised;
use crate::app::editor::picture::denoiser::Denoiser;
use crate::app::editor::picture::painter::{Painter, Scales};
use crate::app::editor::picture::reframing::of_film;
use crate::app::editor::session::view_settings::ViewSettings;
use crate::color::Rgb;
use crate::engine::{
    PackedScene, RenderControl, RenderFilm, RenderState, RenderStatus, describe_picture, layered_picture,
};
use crate::layer::Layer;
use crate::metrics::errors;
use crate::render::denoise::denoise_film;
use crate::render::exposure::auto_exposure;
use crate::render::image_io::ImageRgb;
use crate::render::layered_image::LayeredImage;
use crate::render::tile::tiles;
use crate::render::view::View;
use crate::scene::SceneStatus;

/// The picture as it is shown: with its lights mixed, and denoised if the denoised picture is shown.
pub fn picture(world: &World) -> ImageRgb {
    let film = world.resource::<RenderFilm>();
    let mode = world.resource::<ViewSettings>().display.mode;
    let mix = match mode {
        // One light by itself.
        mode @ DisplayMode::LightGroup(_) => Scales::of(&film.film, mode, Vec::new(), &Scales::default()).mix,
        _ => factors(world),
    };
    let denoised = world.resource::<Denoiser>().picture();
    let is_shown =
        |denoised: &&Denoised| mode == DisplayMode::Shaded && denoised.mix == mix && denoised.job == film.job;
    let pixels = match denoised.filter(is_shown) {
        Some(denoised) => denoised.radiance.clone(),
        None => film.film.mixed(&mix),
    };
    ImageRgb {
        width: film.film.width(),
        height: film.film.height(),
        pixels,
    }
}

/// The picture with its layers. The denoised picture is computed now unless it is shown.
pub fn layered(world: &World, picture: &ImageRgb) -> LayeredImage {
    let (film, job) = (&world.resource::<RenderFilm>().film, world.resource::<RenderFilm>().job);
    let is_shown = world
        .resource::<Denoiser>()
        .picture()
        .filter(|denoised| denoised.job == job)
        .map(|denoised| denoised.radiance.clone());
    let denoised = match film.layers().layers.contains(Layer::Denoised) {
        true => is_shown.or_else(|| denoise_film(film, None, &AtomicBool::new(false)).ok()),
        false => None,
    };
    let mut layered = layered_picture(world, picture, denoised.as_deref());
    describe(world, &mut layered);
    layered
}

/// Writes the origin of the picture into its metadata.
pub fn describe(world: &World, picture: &mut LayeredImage) {
    let scene = world.get_resource::<SceneStatus>();
    let scene = scene.and_then(|scene| scene.path.as_deref());
    let seconds = is_limited_in_time(world).then(|| world.resource::<RenderStatus>().seconds);
    describe_picture(picture, world, scene, seconds);
}

/// Whether the number of samples depends on the time. The full film that is traced for an image has no limit of time
/// itself, but gets the samples that the window had by then.
fn is_limited_in_time(world: &World) -> bool {
    let follows_window = world
        .get_resource::<AwaitedImage>()
        .is_some_and(|image| image.before == Before::Smaller { exact_samples: None });
    let is_limited = world.resource::<RenderStatus>().time_limit.is_some();
    is_limited || follows_window && world.resource::<RenderControl>().time_limit.is_some()
}

/// The picture with the snapshot wiped over it, or their difference, if that is shown.
pub fn compared(world: &World, picture: ImageRgb) -> ImageRgb {
    let comparison = world.resource::<Comparison>();
    let is_shaded = world.resource::<ViewSettings>().display.mode == DisplayMode::Shaded;
    let view = world
        .get_resource::<PackedScene>()
        .and_then(|packed| packed.view.as_ref());
    let snapshot = comparison.other(view.map(View::of_film).as_ref()).filter(|_| is_shaded);
    let size = [picture.width, picture.height];
    match snapshot.and_then(|snapshot| PixelComparison::new(comparison.view, snapshot, size, film_corners(world))) {
        Some(compared) => ImageRgb {
            pixels: compared.picture(&picture.pixels),
            ..picture
        },
        None => picture,
    }
}

/// The film as bytes in display modes that show no light: its size and three bytes a pixel, black where nothing is
/// rendered yet.
pub fn painted(world: &World) -> ([u32; 2], Vec<u8>) {
    let film = &world.resource::<RenderFilm>().film;
    let (width, height) = (film.width(), film.height());
    let display = world.resource::<ViewSettings>().display;
    let scales = Scales::of(film, display.mode, Vec::new(), &Scales::default());
    let mut rgba = vec![0; 4 * width as usize * height as usize];
    Painter::new(film, &display, &scales).paint(&tiles(width, height), &mut rgba);
    let rgb = rgba.chunks_exact(4).flat_map(|pixel| pixel[..3].to_vec()).collect();
    ([width, height], rgb)
}

/// The factors of the film's layers in the displayed picture.
pub fn factors(world: &World) -> Vec<Rgb> {
    let groups = &world.resource::<RenderFilm>().light_groups;
    let lights = world.resource::<FilmLights>();
    world.resource::<LightMix>().factors(groups, lights)
}

/// Whether the denoised picture that the user wants is still to come: the final one of a finished picture, or else the
/// first.
pub(crate) fn awaits_denoised(world: &World) -> bool {
    let film = world.resource::<RenderFilm>();
    match world.resource::<RenderStatus>().state {
        RenderState::Done | RenderState::Paused => film.samples > 0 && owes_denoised(world),
        RenderState::Loading | RenderState::Building | RenderState::Rendering => {
            is_denoising(world) && world.resource::<Denoiser>().awaits_first(film)
        }
        RenderState::Idle | RenderState::Failed => false,
    }
}

/// Whether denoising is on and the denoised picture does not have all present samples yet.
pub fn owes_denoised(world: &World) -> bool {
    let mix = factors(world);
    is_denoising(world) && world.resource::<Denoiser>().owes(world.resource::<RenderFilm>(), &mix)
}

/// Whether the picture is shown denoised, or will be.
pub fn is_denoising(world: &World) -> bool {
    let settings = world.resource::<ViewSettings>();
    let is_wanted = settings.denoising && settings.display.mode == DisplayMode::Shaded;
    is_wanted && world.get_resource::<Denoiser>().is_some_and(Denoiser::is_available)
}

/// The picture as sampled, if [`picture`] is a denoised one.
pub fn noisy_picture(world: &World) -> Option<ImageRgb> {
    let film = world.resource::<RenderFilm>();
    let mix = factors(world);
    let denoised = world.resource::<Denoiser>().picture();
    denoised
        .filter(|denoised| is_denoising(world) && denoised.mix == mix && denoised.job == film.job)
        .map(|_| ImageRgb {
            width: film.film.width(),
            height: film.film.height(),
            pixels: film.film.mixed(&mix),
        })
}

pub fn expose(world: &mut World) -> Result<(), CommandError> {
    let stops = auto_exposure(&picture(world).pixels).ok_or("The picture is black.")?;
    let display = world.resource::<ViewSettings>().display;
    // Exposure is rounded to tenths of a stop, so that it is easy to read.
    let exposure = (10.0 * stops).round() / 10.0;
    set_display(world, DisplaySettings { exposure, ..display });
    Ok(())
}

pub fn take_snapshot(world: &mut World) -> Result<(), CommandError> {
    let picture = picture(world);
    if picture.pixels.is_empty() {
        return Err("There is no picture to keep.".into());
    }
    let samples = world.resource::<RenderFilm>().samples;
    if samples == 0 {
        return Err("The picture has no samples yet. Take the snapshot when it has its first one.".into());
    }
    let film_corners = film_corners(world);
    let mut comparison = world.resource_mut::<Comparison>();
    comparison.snapshot = Some(Snapshot {
        size: [picture.width, picture.height],
        film_corners,
        radiance: picture.pixels,
        samples,
    });
    comparison.is_of_other_scene = false;
    comparison.figures = None;
    comparison.revision += 1;
    Ok(())
}

/// The corners of the film in the picture.
fn film_corners(world: &World) -> [Vec2; 2] {
    let view = world.get_resource::<RenderFilm>().and_then(|film| film.view.as_ref());
    view.map_or(View::WHOLE_FILM, View::film_corners)
}

pub fn measure(world: &mut World) -> Result<(), CommandError> {
    let picture = picture(world);
    let film = world.resource::<RenderFilm>();
    let (job, samples) = (film.job, film.film.sample_count());
    let film_corners = film_corners(world);
    let mut comparison = world.resource_mut::<Comparison>();
    let snapshot = comparison.snapshot.as_ref().ok_or("There is no snapshot.")?;
    let frame = (UVec2::new(picture.width, picture.height), film_corners);
    let (size, now) = of_film(&picture.pixels, frame);
    let frame = (UVec2::from(snapshot.size), snapshot.film_corners);
    let (snapshot_size, then) = of_film(&snapshot.radiance, frame);
    let has_its_size = snapshot_size == size;
    let found = errors(&now, &then).filter(|_| has_its_size);
    comparison.figures = found.map(|figures| Measured { figures, job, samples });
    match found {
        Some(_) => Ok(()),
        None if has_its_size => Err("The picture or the snapshot has values that are no numbers.".into()),
        None => {
            let [snapshot, picture] = [snapshot_size, size].map(|size| format!("{} × {}", size.x, size.y));
            let help = "take the snapshot again, or render the full film for both";
            Err(format!("The snapshot has {snapshot} pixels and the picture {picture}: {help}.").into())
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::app::editor::command::compare_view::CompareView;
    use crate::app::editor::session::requests::Requests;
    use crate::app::editor::session::toasts::Toasts;

    #[test]
    fn what_is_compared_is_saved_compared() {
        let mut world = World::new();
        world.init_resource::<ViewSettings>();
        world.init_resource::<Requests>();
        world.init_resource::<Toasts>();
        let snapshot = Some(Snapshot {
            size: [4, 1],
            film_corners: View::WHOLE_FILM,
            radiance: vec![Rgb::ONE; 4],
            samples: 1,
        });
        world.insert_resource(Comparison {
            snapshot,
            ..Comparison::default()
        });
        let mut saved = |view: CompareView| {
            world.resource_mut::<Comparison>().view = view;
            let picture = ImageRgb {
                width: 4,
                height: 1,
                pixels: vec![Rgb::splat(3.0); 4],
            };
            let red = |pixel: &Rgb| pixel.x;
            compared(&world, picture).pixels.iter().map(red).collect::<Vec<f32>>()
        };
        assert_eq!(saved(CompareView::Off), [3.0; 4]);
        assert_eq!(saved(CompareView::Wipe(0.5)), [1.0, 1.0, 3.0, 3.0]);
        assert_eq!(saved(CompareView::Difference), [2.0; 4]);
    }
}
