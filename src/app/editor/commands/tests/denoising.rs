//! The picture is denoised while it is rendered, and saved so.

use std::sync::atomic::AtomicBool;

use super::full_film::{app, update_until};
use super::*;
use crate::app::editor::command::light_mix::Channel;
use crate::app::editor::command::{DisplayCommand, FileCommand, RenderCommand, ValueEdit, ViewCommand};
use crate::app::editor::picture::denoiser::{DenoiserState, follow_denoiser};
use crate::app::editor::picture::texture::{Picture, create_picture, update_picture};
use crate::engine::{EngineSystems, RenderState, RenderStatus};
use crate::files::{ExrCompression, LARGEST_DATA, read};
use crate::render::denoise::denoise_film;
use crate::render::image_io::exr::decode_exr;
use crate::render::layered_image::{Attribute, Samples};
use crate::scene::{ActiveSensor, ComponentFormat, Film, SamplerSettings, SceneStatus};

fn denoising_app(samples: u32) -> App {
    let mut app = app();
    app.add_systems(PostUpdate, follow_denoiser.after(EngineSystems::Report));
    app.world_mut().resource_mut::<RenderControl>().target_samples = Some(samples);
    apply(app.world_mut(), DisplayCommand::SetDenoising(true)).expect("it is built in");
    app
}

/// The samples per pixel of the denoised picture that is shown.
fn shown(world: &World) -> Option<u32> {
    Some(world.resource::<Denoiser>().picture()?.samples)
}

fn is_best(world: &World) -> bool {
    world.resource::<RenderStatus>().state == RenderState::Done
        && world.resource::<RenderFilm>().samples > 0
        && !awaits_denoised(world)
        && shown(world).is_some()
}

fn job(world: &World) -> u64 {
    world.resource::<RenderFilm>().job
}

/// The state in the labels of a frame, which are drawn before its commands are applied and its tiles arrive.
#[derive(Resource, Default)]
struct Labels(DenoiserState);

/// Whether the labels say that the picture is denoised, and whether it is.
fn labels_and_picture(app: &mut App) -> (bool, bool) {
    app.update();
    let world = app.world();
    let says = matches!(world.resource::<Labels>().0, DenoiserState::Shown { .. });
    (says, world.resource::<Picture>().denoised().is_some())
}

#[test]
fn no_label_calls_a_picture_denoised_that_is_shown_as_sampled() {
    let mut app = denoising_app(16);
    let write = |mut labels: ResMut<Labels>, denoiser: Res<Denoiser>, picture: Res<Picture>| {
        labels.0 = denoiser.state(true, picture.denoised());
    };
    app.init_asset::<Image>()
        .init_resource::<bevy_egui::EguiUserTextures>()
        .init_resource::<Labels>()
        .add_systems(Startup, create_picture)
        .add_systems(PreUpdate, write)
        .add_systems(PostUpdate, update_picture.after(follow_denoiser));
    apply(app.world_mut(), RenderCommand::SetLightLayers(true)).expect("set");
    // The texture is not written in every frame.
    let settle = |app: &mut App| {
        update_until(app, |world| {
            let says = matches!(world.resource::<Labels>().0, DenoiserState::Shown { .. });
            is_best(world) && says && world.resource::<Picture>().denoised().is_some()
        });
    };
    settle(&mut app);
    // The picture restarts.
    for turn in 1..4 {
        let pose = Affine3A::from_rotation_y(0.2 * turn as f32);
        apply(app.world_mut(), ViewCommand::MoveView(pose)).expect("moved");
        let before = job(app.world());
        while job(app.world()) == before || !is_best(app.world()) {
            let (says, is_denoised) = labels_and_picture(&mut app);
            assert!(is_denoised || !says);
        }
        settle(&mut app);
    }
    // The lights are mixed anew, of the same samples.
    let sky = app
        .world_mut()
        .query_filtered::<Entity, With<Emitter>>()
        .single(app.world())
        .expect("one light");
    let mut mix = LightMix::default();
    mix.set(
        sky,
        Channel {
            strength: 0.5,
            ..Channel::default()
        },
    );
    apply(app.world_mut(), DisplayCommand::SetLightMix(mix)).expect("mixed");
    // The labels of a frame are drawn before its command.
    let (_, mut was_denoised) = labels_and_picture(&mut app);
    while !is_best(app.world()) {
        let (says, is_denoised) = labels_and_picture(&mut app);
        assert!(is_denoised || was_denoised || !says);
        was_denoised = is_denoised;
    }
    settle(&mut app);
}

fn pixels(path: &Path) -> Vec<Rgb> {
    let bytes = read(path, LARGEST_DATA).expect("a file");
    let picture = image::load_from_memory(&bytes).expect("a picture").to_rgb32f();
    picture.pixels().map(|pixel| Rgb::from_array(pixel.0)).collect()
}

#[test]
fn fresher_pictures_follow_until_the_best_of_all_samples() {
    let mut app = denoising_app(256);
    let mut seen: Vec<u32> = Vec::new();
    let mut is_over = false;
    while !is_over {
        app.update();
        let samples = shown(app.world());
        if samples != seen.last().copied() {
            seen.extend(samples);
        }
        is_over = seen.last() == Some(&256) && is_best(app.world());
        std::thread::sleep(std::time::Duration::from_millis(1));
    }
    assert!(seen.is_sorted(), "{seen:?}");
    // The command line would make the same of the film.
    let denoised = app.world().resource::<Denoiser>().picture().expect("it is shown");
    let film = &app.world().resource::<RenderFilm>().film;
    let expected = denoise_film(film, Some(1), &AtomicBool::new(false)).expect("it can be denoised");
    let is_same = |(one, other): (&Rgb, &Rgb)| one.abs_diff_eq(*other, 1e-3);
    assert!(denoised.radiance.iter().zip(&expected).all(is_same));
    assert_eq!(denoised.radiance.len(), expected.len());
    // Another view is another picture.
    apply(app.world_mut(), ViewCommand::MoveView(Affine3A::from_rotation_y(0.5))).expect("moved");
    update_until(&mut app, |world| shown(world) != Some(256));
    update_until(&mut app, |world| shown(world) == Some(256) && is_best(world));
    apply(app.world_mut(), DisplayCommand::SetDenoising(false)).expect("it is off");
    app.update();
    assert_eq!(shown(app.world()), None);
}

#[test]
fn what_is_saved_is_denoised_and_the_radiance_is_saved_as_sampled_too() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("sky.exr");
    let mut app = denoising_app(6);
    app.world_mut().resource_mut::<SamplerSettings>().seed = 7;
    app.world_mut().resource_mut::<SceneStatus>().path = Some("/scenes/sky.xml".into());
    let camera = app.world().resource::<ActiveSensor>().0.expect("a camera");
    app.world_mut().entity_mut(camera).insert(Name::new("eye"));
    update_until(&mut app, is_best);
    // The window has fewer pixels than the film, of which none is denoised yet.
    apply(app.world_mut(), FileCommand::SaveImage(path.clone())).expect("it is begun");
    assert!(!path.exists());
    update_until(&mut app, |_| path.exists());
    let denoised = app.world().resource::<Denoiser>().picture().expect("it is shown");
    let is_saved = denoised.radiance == pixels(&path);
    assert_eq!((denoised.samples, denoised.is_careful, is_saved), (6, true, true));
    let film = &app.world().resource::<RenderFilm>().film;
    assert_eq!([film.width(), film.height()], [120, 80]);
    let noisy = film.radiance();
    assert_eq!(pixels(&folder.path().join("sky-noisy.exr")), noisy);
    // Both files say where they come from, as those of the command line do.
    for name in ["sky.exr", "sky-noisy.exr"] {
        let bytes = read(&folder.path().join(name), LARGEST_DATA).expect("a file");
        let described = decode_exr(&bytes).expect("an EXR file");
        let attribute = |name: &str| described.attribute(name).cloned();
        let version = concat!("Sunroom ", env!("CARGO_PKG_VERSION")).to_owned();
        assert_eq!(attribute("software"), Some(Attribute::Text(version)));
        let scene = Some(Attribute::Text("/scenes/sky.xml".to_owned()));
        assert_eq!(attribute("sunroom:scene"), scene);
        assert_eq!(attribute("sunroom:camera"), Some(Attribute::Text("eye".to_owned())));
        assert_eq!(attribute("sunroom:spp"), Some(Attribute::Int(6)));
        assert_eq!(attribute("sunroom:seed"), Some(Attribute::Int(7)));
        assert_eq!(attribute("sunroom:seconds"), None);
        for matrix in ["worldToCamera", "worldToNDC"] {
            assert!(
                matches!(attribute(matrix), Some(Attribute::Matrix(_))),
                "{name}: {matrix}"
            );
        }
    }
    // Saving it again replaces both files, and adds none.
    std::fs::write(folder.path().join("sky-noisy.exr"), "older").expect("can be written");
    apply(app.world_mut(), FileCommand::SaveImage(path.clone())).expect("saved");
    assert_eq!(pixels(&folder.path().join("sky-noisy.exr")), noisy);
    assert_eq!(std::fs::read_dir(folder.path()).expect("a folder").count(), 2);
    // Without it there is one file.
    apply(app.world_mut(), DisplayCommand::SetDenoising(false)).expect("it is off");
    app.update();
    let plain = folder.path().join("plain.exr");
    apply(app.world_mut(), FileCommand::SaveImage(plain.clone())).expect("saved");
    assert!(plain.exists() && !folder.path().join("plain-noisy.exr").exists());
    // Its colours have the precision that the film asks for.
    let precision = |path: &Path| {
        let image = decode_exr(&read(path, LARGEST_DATA).expect("a file")).expect("an EXR file");
        matches!(image.channel("R").expect("a colour").samples, Samples::Half(_))
    };
    assert!(!precision(&plain));
    let camera = app.world().resource::<ActiveSensor>().0.expect("a camera");
    let mut film = *app.world().get::<Film>(camera).expect("it has a film");
    film.storage.components = Some(ComponentFormat::Float16);
    film.storage.compression = Some(ExrCompression::None);
    apply(app.world_mut(), ValueEdit::SetFilm(camera, film)).expect("set");
    let halves = folder.path().join("halves.exr");
    apply(app.world_mut(), FileCommand::SaveImage(halves.clone())).expect("it is begun");
    update_until(&mut app, |_| halves.exists());
    assert!(precision(&halves));
    let size = |path: &Path| std::fs::metadata(path).expect("a file").len();
    assert!(size(&halves) > 120 * 80 * 6, "it is not compressed: {}", size(&halves));
}
