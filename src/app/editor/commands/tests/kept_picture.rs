//! Pictures that are kept beside their scene, and resumed.

use std::num::NonZeroUsize;

use super::full_film::{add_resources, update_until};
use super::*;
use crate::app::editor::command::{
    DisplayCommand, HistoryCommand, KeptPicture, OutlineEdit, RenderCommand, ValueEdit, ViewCommand,
};
use crate::app::editor::commands::kept_picture::follow;
use crate::app::editor::session::kept_picture::{KeptPictures, Returning, kept_file};
use crate::app::editor::session::options::SceneDefines;
use crate::engine::{EnginePlugin, EngineSystems, RenderState, RenderStatus};
use crate::files::{LARGEST_DATA, read};
use crate::scene::{FileSourcePlugin, FreeView, OpenScene, ScenePlugin, SceneState, SceneStatus, asset_plugin};

const SCENE: &str = r#"<scene version="3.0.0">
  <sensor type="perspective">
    <transform name="to_world"><lookat origin="0, 0, 5" target="0, 0, 0" up="0, 1, 0"/></transform>
    <film type="hdrfilm"><integer name="width" value="40"/><integer name="height" value="24"/></film>
    <sampler type="independent"><integer name="sample_count" value="96"/></sampler>
  </sensor>
  <sensor type="perspective">
    <transform name="to_world"><lookat origin="1, 0, 5" target="0, 0, 0" up="0, 1, 0"/></transform>
    <film type="hdrfilm"><integer name="width" value="36"/><integer name="height" value="48"/></film>
  </sensor>
  <shape type="sphere"><bsdf type="diffuse"/></shape>
  <emitter type="constant"/>
</scene>
"#;

/// Samples that a picture of a few pixels does not get in a moment.
const MANY: u32 = 4000;

/// The scene with a picture that comes to no end.
fn endless() -> String {
    SCENE.replace("\"96\"", "\"100000000\"")
}

struct Desk {
    folder: tempfile::TempDir,
}

impl Desk {
    fn new() -> Self {
        Self::of(SCENE)
    }

    fn of(scene: &str) -> Self {
        let desk = Self {
            folder: tempfile::tempdir().expect("a folder"),
        };
        std::fs::write(desk.scene(), scene).expect("a file");
        desk
    }

    fn scene(&self) -> PathBuf {
        self.folder.path().join("room.xml")
    }

    fn kept(&self) -> PathBuf {
        kept_file(&self.scene())
    }

    /// A window that has just opened the scene, without a window. `returns`: as for a user.
    fn open(&self, returns: bool, room: [u32; 2]) -> App {
        let mut app = App::new();
        app.add_plugins((MinimalPlugins, FileSourcePlugin, asset_plugin()))
            .add_plugins((ScenePlugin, EnginePlugin))
            .init_resource::<SceneDefines>()
            .insert_resource(KeptPictures::new(returns))
            .add_systems(PostUpdate, follow.before(EngineSystems::Detect));
        add_resources(&mut app);
        let mut control = app.world_mut().resource_mut::<RenderControl>();
        control.threads = NonZeroUsize::MIN;
        control.interactive = true;
        control.view_size = Some(room.into());
        app.world_mut().write_message(OpenScene {
            path: self.scene(),
            ..OpenScene::default()
        });
        update_until(&mut app, |world| {
            let is_ready = world.resource::<SceneStatus>().state == SceneState::Ready;
            is_ready && !world.contains_resource::<Returning>()
        });
        app
    }
}

fn samples(world: &World) -> u32 {
    world.resource::<RenderStatus>().samples
}

fn is_done(world: &World) -> bool {
    world.resource::<RenderStatus>().state == RenderState::Done
}

fn texts(app: &App) -> Vec<String> {
    let toasts = app.world().resource::<Toasts>();
    toasts.texts().map(str::to_owned).collect()
}

fn tell(app: &mut App, command: KeptPicture) -> Result<(), String> {
    apply(app.world_mut(), Command::KeptPicture(command)).map_err(|error| error.to_string())
}

/// The sums of the film, bit by bit.
fn bits(app: &App) -> Vec<[u32; 3]> {
    let film = &app.world().resource::<RenderFilm>().film;
    let bits = |color: Rgb| color.to_array().map(f32::to_bits);
    film.radiance().into_iter().map(bits).collect()
}

/// Sets a view of its own through the other camera, a region, and another number of samples, none of which is in the
/// file.
fn look(app: &mut App) {
    let world = app.world_mut();
    let mut cameras = world.query_filtered::<(&DocumentOrder, Entity), With<Sensor>>();
    let other = cameras.iter(world).max().expect("two cameras").1;
    let pose = Affine3A::from_translation(Vec3::new(0.3, 0.1, -4.0));
    for command in [
        Command::from(ViewCommand::LookThrough(other)),
        Command::from(ViewCommand::MoveView(pose)),
        Command::from(RenderCommand::SetTargetSamples(80)),
        Command::from(RenderCommand::SetAdaptive(true)),
        Command::from(RenderCommand::SetRegion(Some(Rect::new(0.0, 0.0, 1.0, 0.4)))),
        Command::from(RenderCommand::SetLightLayers(true)),
    ] {
        apply(world, command).expect("it can be done");
    }
}

#[test]
fn a_kept_picture_goes_on_to_the_same_bits() {
    let acts: [fn(&mut App); 2] = [|_| {}, look];
    for act in acts {
        let desk = Desk::new();
        let mut whole = desk.open(true, [33, 50]);
        act(&mut whole);
        update_until(&mut whole, is_done);
        let mut first = desk.open(true, [33, 50]);
        act(&mut first);
        update_until(&mut first, |world| samples(world) >= 8);
        tell(&mut first, KeptPicture::Keep).expect("it is kept");
        assert!(
            texts(&first).iter().any(|text| text.contains("Kept the picture")),
            "{:?}",
            texts(&first)
        );
        drop(first);
        // The window has another size this time.
        let mut second = desk.open(true, [100, 100]);
        assert!(samples(second.world()) >= 8, "{:?}", texts(&second));
        update_until(&mut second, is_done);
        assert_eq!(second.world().resource::<KeptPictures>().failure, None);
        assert_eq!(samples(second.world()), samples(whole.world()));
        assert!(bits(&second) == bits(&whole));
        let history = second.world().resource::<History>();
        assert!(history.is_saved() && history.len() == (0, 0));
        // A change is of the window's size again.
        apply(second.world_mut(), ViewCommand::MoveView(Affine3A::IDENTITY)).expect("moved");
        update_until(&mut second, |world| {
            let film = &world.resource::<RenderFilm>().film;
            (film.width(), film.height()) != size_of(&whole)
        });
    }
}

fn size_of(app: &App) -> (u32, u32) {
    let film = &app.world().resource::<RenderFilm>().film;
    (film.width(), film.height())
}

#[test]
fn all_samples_are_there_at_once() {
    let desk = Desk::of(&endless());
    let mut first = desk.open(true, [8, 8]);
    assert!(tell(&mut first, KeptPicture::Continue).is_err_and(|error| error.contains("No picture")));
    update_until(&mut first, |world| samples(world) >= MANY);
    let is_offered = |app: &App| app.world().resource::<KeptPictures>().is_there;
    assert!(!is_offered(&first));
    tell(&mut first, KeptPicture::Keep).expect("it is kept");
    first.update();
    assert!(is_offered(&first));
    // Without a user it is resumed only on request.
    let mut second = desk.open(false, [8, 8]);
    assert!(samples(second.world()) < MANY);
    // From wherever the user looks now.
    apply(
        second.world_mut(),
        ViewCommand::MoveView(Affine3A::from_translation(Vec3::Z)),
    )
    .expect("moved");
    tell(&mut second, KeptPicture::Continue).expect("it is begun");
    update_until(&mut second, |world| !world.contains_resource::<Returning>());
    assert_eq!(second.world().resource::<KeptPictures>().failure, None);
    assert!(samples(second.world()) >= MANY, "{:?}", texts(&second));
    tell(&mut second, KeptPicture::Discard).expect("it is removed");
    assert!(!desk.kept().exists());
    second.update();
    assert!(!is_offered(&second));
    assert!(tell(&mut second, KeptPicture::Discard).is_err());
}

#[test]
fn keeping_it_on_quitting_quits_only_if_that_succeeds() {
    let desk = Desk::new();
    let mut app = desk.open(true, [8, 8]);
    let quits = |app: &App| !app.world().resource::<Messages<AppExit>>().is_empty();
    std::fs::create_dir(desk.kept()).expect("a folder in its place");
    update_until(&mut app, |world| samples(world) >= 8);
    assert!(tell(&mut app, KeptPicture::KeepAndQuit).is_err() && !quits(&app));
    std::fs::remove_dir(desk.kept()).expect("it is empty");
    tell(&mut app, KeptPicture::KeepAndQuit).expect("it is kept");
    assert!(quits(&app) && desk.kept().is_file());
}

#[test]
fn a_picture_of_a_changed_scene_begins_anew_and_says_why() {
    let desk = Desk::of(&endless());
    let mut first = desk.open(true, [8, 8]);
    update_until(&mut first, |world| samples(world) >= MANY);
    tell(&mut first, KeptPicture::Keep).expect("it is kept");
    std::fs::write(desk.scene(), endless().replace("diffuse", "conductor")).expect("a file");
    let kept = read(&desk.kept(), LARGEST_DATA).expect("a file");
    let mut second = desk.open(true, [50, 50]);
    // The user's view stays.
    let pose = Affine3A::from_translation(Vec3::Z);
    apply(second.world_mut(), ViewCommand::MoveView(pose)).expect("moved");
    assert!(tell(&mut second, KeptPicture::Continue).is_err_and(|error| error.contains("another content")));
    assert_eq!(second.world().resource::<FreeView>().pose, Some(pose));
    let texts = texts(&second);
    assert!(
        texts.iter().any(|text| text.contains("room.xml has another content")),
        "{texts:?}"
    );
    assert_eq!(second.world().resource::<RenderControl>().framing_until_change, None);
    assert!(samples(second.world()) < MANY);
    assert!(read(&desk.kept(), LARGEST_DATA).expect("it stays") == kept);
}

#[test]
fn what_cannot_be_kept_is_refused_and_the_last_file_stays() {
    let desk = Desk::new();
    let mut app = desk.open(true, [40, 24]);
    update_until(&mut app, |world| samples(world) >= 8);
    tell(&mut app, KeptPicture::Keep).expect("it is kept");
    let kept = read(&desk.kept(), LARGEST_DATA).expect("a file");
    let refused = |app: &mut App, part: &str| {
        let error = tell(app, KeptPicture::Keep).expect_err(part);
        assert!(error.contains(part), "{error}");
        assert!(read(&desk.kept(), LARGEST_DATA).expect("it stays") == kept);
    };
    let world = app.world_mut();
    let mode = DisplaySettings {
        mode: DisplayMode::Clay,
        ..DisplaySettings::default()
    };
    apply(world, DisplayCommand::SetDisplay(mode)).expect("set");
    refused(&mut app, "whole scene");
    apply(app.world_mut(), DisplayCommand::SetDisplay(DisplaySettings::default())).expect("set");
    apply(app.world_mut(), RenderCommand::Restart).expect("begun anew");
    let sphere = app
        .world_mut()
        .query_filtered::<Entity, With<Shape>>()
        .single(app.world())
        .expect("one");
    apply(app.world_mut(), OutlineEdit::Hide(vec![sphere], true)).expect("hidden");
    refused(&mut app, "whole scene");
    apply(app.world_mut(), HistoryCommand::Undo).expect("undone");
    let pose = Affine3A::from_translation(Vec3::X);
    apply(app.world_mut(), ValueEdit::Transform(vec![(sphere, pose)])).expect("moved");
    refused(&mut app, "not saved");
    assert!(tell(&mut app, KeptPicture::Continue).is_err_and(|error| error.contains("not saved")));
    apply(app.world_mut(), HistoryCommand::Undo).expect("undone");
    std::fs::write(desk.kept(), &kept[..kept.len() / 2]).expect("a file");
    assert!(tell(&mut app, KeptPicture::Continue).is_err_and(|error| error.contains("room.xml.unfinished.exr")));
}
