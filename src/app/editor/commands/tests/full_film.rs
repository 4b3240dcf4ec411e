//! The full film: rendered on demand, asked about, and saved.

use std::num::NonZeroUsize;
use std::path::Path;
use std::time::{Duration, Instant};

use bevy::asset::AssetPlugin;

use super::*;
use crate::app::editor::command::resolution::{FullFilm, Resolution};
use crate::app::editor::command::{FileCommand, RenderCommand, ViewCommand};
use crate::app::editor::commands::finished;
use crate::app::editor::commands::full_film::{confirm, follow_awaited_image};
use crate::app::editor::picture::awaited_image::AwaitedImage;
use crate::app::editor::picture::carrying::Carrying;
use crate::engine::{EnginePlugin, EngineSystems, RenderState, RenderStatus};
use crate::files::{LARGEST_NOTE, read};
use crate::layer::{Layer, Layers};
use crate::memory;
use crate::render::film;
use crate::render::image_io::exr::decode_exr;
use crate::render::layered_image::Attribute;
use crate::scene::{self, EmitterKind, IntegratorSettings, ScenePlugin};

/// A sky, and a film of 120 x 80 pixels that is shown in 60 x 60.
pub(super) fn app() -> App {
    let mut app = App::new();
    app.add_plugins((MinimalPlugins, AssetPlugin::default(), ScenePlugin, EnginePlugin))
        .add_systems(PostUpdate, follow_awaited_image.before(EngineSystems::Detect));
    add_resources(&mut app);
    let world = app.world_mut();
    world.spawn((
        DocumentOrder(0),
        Emitter::from(EmitterKind::Constant { radiance: Rgb::ONE }),
    ));
    let film = scene::Film {
        width: 120,
        height: 80,
        sample_count: 1_000_000,
        ..default()
    };
    let sensor = world
        .spawn((DocumentOrder(1), Sensor::default(), ToWorld::default(), film))
        .id();
    world.insert_resource(ActiveSensor(Some(sensor)));
    let mut control = world.resource_mut::<RenderControl>();
    control.threads = NonZeroUsize::MIN;
    control.interactive = true;
    control.view_size = Some(UVec2::splat(60));
    app
}

/// The resources that commands need besides the scene and the engine.
pub(super) fn add_resources(app: &mut App) {
    app.init_resource::<ViewSettings>()
        .init_resource::<Requests>()
        .init_resource::<Toasts>()
        .init_resource::<CommandQueue>()
        .init_resource::<FrameTimes>()
        .init_resource::<Pacing>()
        .init_resource::<Selection>()
        .init_resource::<History>()
        .init_resource::<LightMix>()
        .init_resource::<crate::app::editor::command::light_mix::FilmLights>()
        .init_resource::<Comparison>()
        .init_resource::<Carrying>()
        .init_resource::<Denoiser>();
}

pub(super) fn update_until(app: &mut App, reached: impl Fn(&World) -> bool) {
    let begin = Instant::now();
    app.update();
    while !reached(app.world()) {
        let status = app.world().resource::<RenderStatus>();
        assert!(begin.elapsed() < Duration::from_secs(600), "{status:?}");
        std::thread::sleep(Duration::from_millis(1));
        app.update();
    }
}

fn size(world: &World) -> (u32, u32) {
    let film = &world.resource::<RenderFilm>().film;
    (film.width(), film.height())
}

fn begin_to_save(app: &mut App, path: &Path) {
    update_until(app, |world| world.resource::<RenderStatus>().samples >= 3);
    assert_eq!(size(app.world()), (60, 40));
    apply(app.world_mut(), FileCommand::SaveImage(path.to_owned())).expect("it is begun");
    assert!(app.world().contains_resource::<AwaitedImage>() && !path.exists());
}

/// The same for an image that has not all its samples before a test ends.
fn begin_to_save_for_long(app: &mut App, path: &Path) {
    begin_to_save(app, path);
    const MANY: u32 = 1_000_000_000;
    app.world_mut().resource_mut::<AwaitedImage>().samples = MANY;
    app.world_mut().resource_mut::<RenderControl>().exact_samples = Some(MANY);
}

#[test]
fn an_image_is_saved_with_all_pixels_of_the_film() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("sky.png");
    let mut app = app();
    begin_to_save(&mut app, &path);
    let samples = app.world().resource::<AwaitedImage>().samples;
    update_until(&mut app, |world| !world.contains_resource::<AwaitedImage>());
    let bytes = read(&path, LARGEST_NOTE).expect("a file");
    let saved = image::load_from_memory(&bytes).expect("a picture").to_rgb8();
    assert_eq!(saved.dimensions(), (120, 80));
    assert!(saved.pixels().all(|pixel| pixel.0 == [255; 3]));
    let control = app.world().resource::<RenderControl>();
    assert_eq!((control.exact_samples, control.full_until_change), (None, true));
    assert!(samples >= 3);
    let told = format!("with {samples} samples per pixel and the tone map");
    let texts: Vec<&str> = app.world().resource::<Toasts>().texts().collect();
    assert!(texts.iter().any(|text| text.contains(&told)), "{texts:?}");
    // Now the full film is there, so that the image is saved at once.
    let again = folder.path().join("again.png");
    apply(app.world_mut(), FileCommand::SaveImage(again.clone())).expect("saved");
    assert!(again.exists());
    apply(app.world_mut(), RenderCommand::StopFull).expect("it is stopped");
    update_until(&mut app, |world| size(world) == (60, 40));
}

/// It has the samples that the window had in its time, and is traced without a limit of time itself.
#[test]
fn an_image_of_a_window_with_a_limit_of_time_says_its_seconds() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("sky.exr");
    let mut app = app();
    app.world_mut().resource_mut::<RenderControl>().time_limit = Some(1e6);
    begin_to_save(&mut app, &path);
    update_until(&mut app, |world| !world.contains_resource::<AwaitedImage>());
    let saved = decode_exr(&read(&path, LARGEST_NOTE).expect("a file")).expect("an EXR file");
    let seconds = saved.attribute("sunroom:seconds");
    assert!(
        matches!(seconds, Some(Attribute::Float(seconds)) if *seconds > 0.0),
        "{seconds:?}"
    );
}

/// The window does not know the frame before.
#[test]
fn an_image_without_its_motion_says_so_where_things_move() {
    let folder = tempfile::tempdir().expect("a folder");
    let mut app = app();
    let world = app.world_mut();
    world.resource_mut::<RenderControl>().view_size = None;
    let layers = Layers::of(&[Layer::Motion]);
    world.insert_resource(IntegratorSettings {
        layers,
        ..IntegratorSettings::default()
    });
    update_until(&mut app, |world| world.resource::<RenderStatus>().samples >= 1);
    let told = |app: &mut App, name: &str| {
        let path = folder.path().join(name);
        apply(app.world_mut(), FileCommand::SaveImage(path)).expect("it is saved");
        let toasts = app.world().resource::<Toasts>();
        let text = toasts.texts().find(|text| text.contains(name)).expect("it is told");
        text.contains("with 0 as motion")
    };
    assert!(!told(&mut app, "still.exr"));
    app.world_mut().spawn(scene::Keys::default());
    assert!(told(&mut app, "moved.exr"));
    assert!(!told(&mut app, "moved.png"));
}

/// The samples may have taken a night.
#[test]
fn a_picture_that_has_all_pixels_is_not_begun_anew_to_be_denoised() {
    let folder = tempfile::tempdir().expect("a folder");
    let mut app = app();
    let world = app.world_mut();
    world.resource_mut::<RenderControl>().view_size = None;
    world.resource_mut::<ViewSettings>().denoising = true;
    if !finished::is_denoising(world) {
        eprintln!("there is no denoiser here: not tested");
        return;
    }
    update_until(&mut app, |world| world.resource::<RenderStatus>().samples >= 3);
    assert_eq!(size(app.world()), (120, 80));
    let job = app.world().resource::<RenderFilm>().job;
    let path = folder.path().join("sky.png");
    apply(app.world_mut(), FileCommand::SaveImage(path)).expect("it is begun");
    assert!(app.world().contains_resource::<AwaitedImage>());
    update_until(&mut app, |world| {
        world.resource::<RenderStatus>().state == RenderState::Paused
    });
    assert_eq!(app.world().resource::<RenderFilm>().job, job);
    assert!(app.world().resource::<RenderStatus>().samples >= 3);
    // Nothing filters it in this test. Without the awaited image rendering continues.
    apply(app.world_mut(), RenderCommand::StopFull).expect("it is stopped");
    update_until(&mut app, |world| !world.contains_resource::<AwaitedImage>());
    assert!(!app.world().resource::<RenderControl>().paused);
    assert_eq!(app.world().resource::<RenderFilm>().job, job);
}

#[test]
fn a_change_in_between_saves_nothing_and_says_so() {
    let changes: [fn(&mut World); 3] = [
        |world| {
            apply(world, RenderCommand::StopFull).expect("it is stopped");
        },
        |world| {
            apply(world, ViewCommand::MoveView(Affine3A::from_rotation_y(0.5))).expect("moved");
        },
        |world| {
            apply(world, RenderCommand::SetResolution(Resolution::View)).expect("set");
        },
    ];
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("sky.png");
    for change in changes {
        let mut app = app();
        begin_to_save(&mut app, &path);
        app.update();
        change(app.world_mut());
        update_until(&mut app, |world| !world.contains_resource::<AwaitedImage>());
        assert!(!path.exists());
        let texts: Vec<&str> = app.world().resource::<Toasts>().texts().collect();
        assert!(
            texts.iter().any(|text| text.starts_with("sky.png was not saved")),
            "{texts:?}"
        );
        assert_eq!(app.world().resource::<RenderControl>().exact_samples, None);
    }
}

#[test]
fn an_image_that_is_cancelled_leaves_the_samples_of_its_film() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("sky.png");
    let mut app = app();
    begin_to_save_for_long(&mut app, &path);
    update_until(&mut app, |world| {
        size(world) == (120, 80) && world.resource::<RenderStatus>().samples >= 3
    });
    let job = app.world().resource::<RenderFilm>().job;
    apply(app.world_mut(), RenderCommand::StopFull).expect("it is cancelled");
    for _ in 0..3 {
        app.update();
    }
    let world = app.world();
    assert!(!world.contains_resource::<AwaitedImage>() && !path.exists());
    assert_eq!((world.resource::<RenderFilm>().job, size(world)), (job, (120, 80)));
    assert!(world.resource::<RenderStatus>().samples >= 3);
    let texts: Vec<&str> = world.resource::<Toasts>().texts().collect();
    assert_eq!(texts, ["sky.png was not saved: it was cancelled."]);
    // Asked for again, it goes back to the pixels of the window.
    apply(app.world_mut(), RenderCommand::StopFull).expect("it is stopped");
    update_until(&mut app, |world| size(world) == (60, 40));
}

#[test]
fn the_full_film_as_a_setting_hides_no_change() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("sky.png");
    let mut app = app();
    begin_to_save_for_long(&mut app, &path);
    update_until(&mut app, |world| size(world) == (120, 80));
    apply(app.world_mut(), RenderCommand::SetResolution(Resolution::Full)).expect("set");
    app.world_mut().resource_mut::<RenderControl>().view_size = None;
    update_until(&mut app, |world| world.resource::<RenderStatus>().samples >= 3);
    assert!(app.world().contains_resource::<AwaitedImage>());
    // Only one image can be waited for at a time.
    let other = folder.path().join("other.png");
    let request = FullFilm {
        save_to: Some(other),
        is_confirmed: false,
    };
    let refused = apply(app.world_mut(), RenderCommand::RenderFull(request)).expect_err("one at a time");
    assert!(refused.to_string().contains("sky.png"), "{refused}");
    assert!(app.world().contains_resource::<AwaitedImage>());
    apply(app.world_mut(), ViewCommand::MoveView(Affine3A::from_rotation_y(0.5))).expect("moved");
    for _ in 0..3 {
        app.update();
    }
    assert!(!app.world().contains_resource::<AwaitedImage>() && !path.exists());
}

/// A world whose picture is a small one of a film with this number of pixels on each side.
fn world_with_film(side: u32) -> World {
    let mut world = bare_world();
    world.insert_resource(RenderStatus {
        state: RenderState::Rendering,
        size: UVec2::splat(100),
        full_size: UVec2::splat(side),
        ..RenderStatus::default()
    });
    world
}

#[test]
fn a_large_film_is_asked_about_and_one_that_is_too_large_refused() {
    let limit = memory::budget().limit();
    let side_of =
        |bytes: u64| ((bytes / film::Film::memory_bytes(32, 32, Default::default()) * 1024) as f64).sqrt() as u32;
    let is_full = |world: &World| world.resource::<RenderControl>().full_until_change;

    let mut world = world_with_film(side_of(limit / 100));
    apply(&mut world, RenderCommand::RenderFull(FullFilm::default())).expect("it is begun");
    assert!(is_full(&world) && world.resource::<Requests>().full_film_question.is_none());

    let mut world = world_with_film(side_of(limit / 2));
    apply(&mut world, RenderCommand::RenderFull(FullFilm::default())).expect("it is asked");
    assert!(!is_full(&world));
    let question = world.resource::<Requests>().full_film_question.clone();
    let question = question.expect("a question");
    assert!(question.text().contains("GB of memory") || question.text().contains("MB of memory"));
    confirm(&mut world).expect("it is begun");
    assert!(is_full(&world) && world.resource::<Requests>().full_film_question.is_none());

    let mut world = world_with_film(side_of(2 * limit));
    let refused = apply(&mut world, RenderCommand::RenderFull(FullFilm::default()));
    let reason = refused.expect_err("it is too large").to_string();
    assert!(reason.contains("of memory"), "{reason}");
    assert!(!is_full(&world));

    let mut world = world_with_film(300);
    world.resource_mut::<RenderControl>().paused = true;
    assert!(apply(&mut world, RenderCommand::RenderFull(FullFilm::default())).is_err());
}
