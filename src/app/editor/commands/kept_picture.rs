//! Keeps an unfinished picture beside its scene, and resumes it later.
//!
//! The file is a checkpoint like those of the command line, which also holds the window's view of the scene. The origin
//! of the picture is compared before it is resumed: a picture of a changed scene starts again, and the file stays.

use std::path::{Path, PathBuf};

use bevy::prelude::*;

use super::seeing::note_other_view;
use super::view::look_through_first;
use super::world::{control, set_resource};
use crate::app::checkpoint::Piece;
use crate::app::editor::camera::pose::{is_orthographic, lens_of_view, view_pose};
use crate::app::editor::command::KeptPicture;
use crate::app::editor::command::error::CommandError;
use crate::app::editor::command::stored_view::StoredView;
use crate::app::editor::picture::awaited_image::{AwaitedImage, Before};
use crate::app::editor::session::history::History;
use crate::app::editor::session::kept_picture::{KeptPictures, Returning, Shown, kept_file};
use crate::app::editor::session::options::SceneDefines;
use crate::app::editor::session::toasts::{Toasts, Topic};
use crate::app::editor::session::view_settings::ViewSettings;
use crate::app::editor::words::figures::counted;
use crate::app::origin::{origin_of_open, take_choice};
use crate::engine::{
    Framing, PackedScene, RenderControl, RenderFilm, RenderState, RenderStatus, SightControl, ViewMode, active_film,
    framing,
};
use crate::files::FileError;
use crate::render::layered_image::{Attribute, LayeredImage};
use crate::render::part::{Crop, Origin, PartFile};
use crate::scene::{
    AccelMethod, ActiveSensor, DocumentOrder, Film, FreeView, Hidden, SceneAccess, SceneState, SceneStatus, Sensor,
    show_moment, shown_time,
};

/// The name of the text in the file that says how the window showed the scene.
const SHOWN: &str = "sunroom:window";

pub fn apply(world: &mut World, command: KeptPicture) -> Result<(), CommandError> {
    match command {
        KeptPicture::Keep => keep(world),
        KeptPicture::KeepAndQuit => keep(world).map(|()| {
            world.write_message(AppExit::Success);
        }),
        KeptPicture::Continue => begin_to_continue(world),
        KeptPicture::Discard => discard(world),
    }
}

fn keep(world: &mut World) -> Result<(), CommandError> {
    let scene = keepable(world)?;
    let path = kept_file(&scene);
    if !SceneAccess::of(world).covers(&path) {
        return Err(CommandError::file(format!(
            "{}: {}",
            name_of(&path),
            FileError::Outside
        )));
    }
    let film = world.resource::<RenderFilm>();
    let (job, size) = (film.job, [film.film.width(), film.film.height()]);
    let shown = shown(world);
    let status = world.resource::<RenderStatus>();
    let (samples, seconds, target) = (status.samples, status.seconds, status.target);
    let piece = Piece {
        origin: origin(world, &scene).map_err(CommandError::file)?,
        size,
        crop: Crop::whole(size[0], size[1]),
        samples: [0, target],
        samples_of_whole: None,
    };
    let mut described = LayeredImage::new(size[0], size[1]);
    let shown = serde_json::to_string(&shown).map_err(CommandError::file)?;
    let texts = [
        ("software", concat!("Sunroom ", env!("CARGO_PKG_VERSION")).to_owned()),
        ("sunroom:scene", scene.display().to_string()),
        (SHOWN, shown),
    ];
    for (name, text) in texts {
        described.set_attribute(name, Attribute::Text(text));
    }
    let written = piece.write_checkpoint(world, &path, &described);
    written.map_err(CommandError::file)?;
    world.resource_mut::<KeptPictures>().note_kept(job, seconds);
    let mut toasts = world.resource_mut::<Toasts>();
    toasts.forget(Topic::Saving);
    toasts.info(format!(
        "Kept the picture with {samples} samples in {}: rendering resumes when the scene is opened again",
        name_of(&path)
    ));
    Ok(())
}

/// The scene whose picture can be kept. The error says why there is none.
fn keepable(world: &World) -> Result<PathBuf, CommandError> {
    let scene = saved_scene(world)?;
    let status = world.resource::<RenderStatus>();
    let has_picture = matches!(
        status.state,
        RenderState::Rendering | RenderState::Paused | RenderState::Done
    );
    if !has_picture || status.samples == 0 || !status.is_up_to_date {
        return Err("There is no picture yet.".into());
    }
    if let Some(image) = world.get_resource::<AwaitedImage>()
        && matches!(image.before, Before::Smaller { .. })
    {
        let file = image.file_name();
        return Err(format!("The full film is still rendered for {file}: keep the picture after it.").into());
    }
    let control = world.resource::<RenderControl>();
    let is_plain = control.view_mode == ViewMode::Path && !control.strategy_split;
    // Files cannot hide things.
    let hides = world
        .try_query_filtered::<(), With<Hidden>>()
        .is_some_and(|mut hidden| hidden.iter(world).next().is_some());
    if !is_plain || hides || control.sight != SightControl::default() {
        return Err(
            "Only a picture of the whole scene can be kept: show everything, and light instead of false colours."
                .into(),
        );
    }
    Ok(scene)
}

/// The path of the open scene, if its file has all edits.
fn saved_scene(world: &World) -> Result<PathBuf, CommandError> {
    let status = world.resource::<SceneStatus>();
    if status.state == SceneState::Loading {
        return Err("A scene is still being read.".into());
    }
    let history = world.resource::<History>();
    match &status.path {
        None => Err("The scene has no file yet: save it, and its picture can be kept beside it.".into()),
        Some(_) if !history.is_saved() || history.is_saving() => {
            Err("The picture is of edits that are not saved: save the scene first.".into())
        }
        Some(path) => Ok(path.clone()),
    }
}

/// The origin of the picture: scene, camera and settings.
fn origin(world: &World, scene: &Path) -> Result<Origin, String> {
    let sensor = world.resource::<ActiveSensor>().0;
    let film = sensor.and_then(|sensor| world.get::<Film>(sensor));
    let is_adaptive = film.is_some_and(|film| film.adaptive);
    let is_adaptive = world.resource::<RenderControl>().adaptive.unwrap_or(is_adaptive);
    let accel = world.resource::<AccelMethod>().name();
    // The settings have the names that the command line uses.
    let mut settings = vec![("the acceleration structure".to_owned(), accel.to_owned())];
    let defines = world.resource::<SceneDefines>().0.iter();
    settings.extend(defines.map(|(name, value)| (format!("-D {name}"), value.clone())));
    settings.push(("adaptive sampling".to_owned(), is_adaptive.to_string()));
    if shows_surroundings(world) {
        settings.push(("the frame".to_owned(), "the film with its surroundings".to_owned()));
    }
    let time = shown_time(world);
    if time != 0.0 {
        settings.push(("the time in seconds".to_owned(), time.to_string()));
    }
    origin_of_open(world, scene, settings)
}

/// Whether the view shows the surroundings of the film as well.
fn shows_surroundings(world: &World) -> bool {
    let view = world.resource::<PackedScene>().view.as_ref();
    view.is_some_and(|view| view.film_camera.is_some())
}

/// The cameras in the order of the file.
fn cameras(world: &mut World) -> Vec<Entity> {
    let mut cameras = world.query_filtered::<(&DocumentOrder, Entity), With<Sensor>>();
    let mut cameras: Vec<_> = cameras.iter(world).collect();
    cameras.sort();
    cameras.into_iter().map(|(_, entity)| entity).collect()
}

/// How the window shows the scene.
fn shown(world: &mut World) -> Shown {
    let cameras = cameras(world);
    let active = world.resource::<ActiveSensor>().0;
    let free = world.resource::<FreeView>();
    let is_free = free.pose.is_some() || free.lens.is_some();
    let orthographic = is_orthographic(world);
    let view = view_pose(world).filter(|_| is_free);
    let control = world.resource::<RenderControl>();
    let extent = match shows_surroundings(world) {
        true => active_film(world).map_or(Vec2::ONE, |film| framing(film, control).extent),
        false => Vec2::ONE,
    };
    Shown {
        camera: cameras.iter().position(|camera| Some(*camera) == active).unwrap_or(0),
        view: view.map(|pose| StoredView {
            pose,
            orthographic,
            hides_walls: false,
        }),
        time: shown_time(world),
        samples: control.target_samples,
        seconds: control.time_limit,
        noise: control.noise_target,
        adaptive: control.adaptive,
        extent: extent.into(),
        keeps_lights_apart: control.light_layers,
        lights_are_free: control.lights_are_free,
        region: control.region.map(|region| [region.min.into(), region.max.into()]),
    }
}

/// Restores the stored view of the scene, except the size of the picture.
fn show(world: &mut World, shown: &Shown) {
    world.resource_mut::<ViewSettings>().playback.stop();
    // A kept picture is of all of the scene.
    note_other_view(world);
    if shown.time != shown_time(world) {
        show_moment(world, shown.time);
    }
    let camera = cameras(world).get(shown.camera).copied();
    if camera.is_some() && camera != world.resource::<ActiveSensor>().0 {
        look_through_first(world, camera);
    }
    let view = match shown.view {
        Some(view) => FreeView {
            pose: Some(view.pose),
            lens: lens_of_view(world, view.orthographic),
        },
        None => FreeView::default(),
    };
    set_resource(world, view);
    control(world, |control| {
        control.paused = false;
        control.exact_samples = None;
        control.target_samples = shown.samples;
        control.time_limit = shown.seconds;
        control.noise_target = shown.noise;
        control.adaptive = shown.adaptive;
        control.region = shown.region.map(|[min, max]| Rect {
            min: min.into(),
            max: max.into(),
        });
        control.light_layers = shown.keeps_lights_apart;
        control.lights_are_free &= shown.lights_are_free;
    });
}

fn begin_to_continue(world: &mut World) -> Result<(), CommandError> {
    let scene = saved_scene(world)?;
    let path = kept_file(&scene);
    if !path.exists() {
        return Err("No picture of this scene is kept.".into());
    }
    let name = name_of(&path);
    let file = PartFile::open_within(&path, &SceneAccess::of(world))
        .map_err(|error| CommandError::file(format!("{name}: {error}")))?;
    let mut texts = file.header().about.texts.iter();
    let text = texts.find(|(name, _)| name == SHOWN).map(|(_, text)| text.as_str());
    let shown = text.and_then(Shown::read).ok_or_else(|| {
        CommandError::file(format!(
            "{name} was not kept by the window: resume it by `sunroom render --resume`"
        ))
    })?;
    // A scene that was edited since keeps its view. Settings depend on the view, so they are compared later.
    let (now, then) = (
        origin(world, &scene).map_err(CommandError::file)?,
        &file.header().origin,
    );
    if let Some(changed) = now.changed_file(then) {
        let text = another_scene(&format!("{} has another content", changed.path));
        return Err(CommandError::file(format!("{name}: {text}")));
    }
    show(world, &shown);
    // The view that is shown now is not packed before the end of this frame.
    world.resource_mut::<RenderStatus>().is_up_to_date = false;
    world.resource_mut::<KeptPictures>().failure = None;
    let is_sized = false;
    world.insert_resource(Returning {
        scene,
        file,
        extent: shown.extent.into(),
        is_sized,
    });
    Ok(())
}

fn discard(world: &mut World) -> Result<(), CommandError> {
    let scene = world.resource::<SceneStatus>().path.clone();
    let path = scene.map(|scene| kept_file(&scene)).filter(|path| path.exists());
    let path = path.ok_or("No picture of this scene is kept.")?;
    std::fs::remove_file(&path).map_err(|error| CommandError::file(format!("{}: {error}", path.display())))?;
    let text = format!("Removed {}", name_of(&path));
    world.resource_mut::<Toasts>().info(text);
    Ok(())
}

fn name_of(path: &Path) -> String {
    path.file_name().unwrap_or_default().to_string_lossy().into_owned()
}

/// Resumes the kept picture of a scene that was opened, and notes whether there is a picture worth keeping. Runs in
/// every frame after the commands.
pub(crate) fn follow(world: &mut World) {
    let status = world.resource::<SceneStatus>();
    if status.is_opening {
        return;
    }
    let (revision, is_fresh) = (status.revision, status.fresh_load);
    let is_kept = status.path.as_deref().is_some_and(|scene| kept_file(scene).is_file());
    let mut pictures = world.resource_mut::<KeptPictures>();
    pictures.is_there = is_kept;
    let is_opened = pictures.take_opened(revision, is_fresh);
    // A recovered scene belongs to no file.
    if is_opened
        && is_kept
        && world.resource::<History>().is_saved()
        && let Err(error) = begin_to_continue(world)
    {
        fail(world, error.to_string());
    }
    if let Some(returning) = world.remove_resource::<Returning>() {
        go_on(world, returning);
    }
    let (job, status) = (world.resource::<RenderFilm>().job, world.resource::<RenderStatus>());
    let (seconds, state) = (status.seconds, status.state);
    let is_much = world.resource_mut::<KeptPictures>().note(job, seconds);
    let is_unfinished = matches!(state, RenderState::Rendering | RenderState::Paused);
    let is_offered = is_much && is_unfinished && keepable(world).is_ok();
    world.resource_mut::<KeptPictures>().is_offered = is_offered;
}

fn go_on(world: &mut World, mut returning: Returning) {
    let path = world.resource::<SceneStatus>().path.as_deref();
    if path != Some(&*returning.scene) || !world.resource::<History>().is_saved() {
        return fail(
            world,
            "The kept picture is not resumed: the scene was changed meanwhile.".to_owned(),
        );
    }
    let status = world.resource::<RenderStatus>();
    if status.state == RenderState::Failed {
        return fail(
            world,
            "The kept picture is not resumed: rendering has failed.".to_owned(),
        );
    }
    // While the view moves, the picture has fewer pixels.
    if !status.is_up_to_date || world.resource::<RenderControl>().motion_scale < 1.0 {
        return world.insert_resource(returning);
    }
    let header = returning.file.header();
    let size = [header.width, header.height];
    if !returning.is_sized {
        returning.is_sized = true;
        let framing = Framing {
            size: size.into(),
            extent: returning.extent,
        };
        control(world, |control| control.framing_until_change = Some(framing));
        return world.insert_resource(returning);
    }
    let name = name_of(&kept_file(&returning.scene));
    let samples = match take_up(world, &returning, size) {
        Ok(samples) => samples,
        Err(error) => {
            control(world, |control| control.framing_until_change = None);
            return fail(world, format!("{name}: {error}"));
        }
    };
    world.resource_mut::<KeptPictures>().note_resumed();
    control(world, |control| control.restart_requested = true);
    let asked = world.resource::<RenderStatus>().target;
    let text = match samples > asked {
        true => {
            format!("{name} has {samples} samples already, and {asked} are asked for: the picture keeps all of them")
        }
        false => format!(
            "Resumed the picture in {name}, at {}",
            counted(samples.into(), "sample")
        ),
    };
    world.resource_mut::<Toasts>().info(text);
}

/// Resumes the picture, if its origin equals the present scene. Returns the samples that every pixel has. The error
/// names the difference.
fn take_up(world: &mut World, returning: &Returning, size: [u32; 2]) -> Result<u32, String> {
    let view = world.resource::<PackedScene>().view.as_ref();
    if view.is_none_or(|view| [view.width, view.height] != size) {
        return Err("the view was changed meanwhile, and the picture begins anew".to_owned());
    }
    let header = returning.file.header();
    take_choice(world, &header.origin);
    let origin = origin(world, &returning.scene)?;
    let differences = origin.differences(&header.origin);
    if !differences.is_empty() {
        return Err(another_scene(&differences.join("; ")));
    }
    let piece = Piece {
        origin,
        size,
        crop: Crop::whole(size[0], size[1]),
        samples: [0, header.samples[1]],
        samples_of_whole: None,
    };
    piece.take_up(world, &returning.file)
}

fn another_scene(difference: &str) -> String {
    format!("the picture is of another scene and begins anew: {difference}")
}

fn fail(world: &mut World, text: String) {
    world.resource_mut::<Toasts>().error(Topic::Other, &text, None);
    world.resource_mut::<KeptPictures>().failure = Some(text);
}
