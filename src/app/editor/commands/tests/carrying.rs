//! Carried-over pixels are shown until the new picture has enough samples, and are in no saved file.

use super::full_film::{app, update_until};
use super::*;
use crate::app::editor::command::preferences::Preferences;
use crate::app::editor::command::{DisplayCommand, OutlineEdit, ValueEdit, ViewCommand};
use crate::app::editor::picture::carrying::{Carrying, ask_for_gbuffer, follow_carrying};
use crate::app::editor::picture::painter::{Painter, Scales};
use crate::app::editor::picture::texture::{Picture, create_picture, update_picture};
use crate::engine::{EngineSystems, RenderState, RenderStatus};
use crate::render::tile::tiles;
use crate::scene::{AreaLight, Hidden, Shape, ShapeKind};

const SAMPLES: u32 = 1024;

/// An editor whose pictures are carried over, with a ball in the sky. Its picture of [`SAMPLES`] samples is finished.
fn watched() -> (App, Entity) {
    let mut app = app();
    app.init_asset::<Image>()
        .init_resource::<bevy_egui::EguiUserTextures>()
        .init_resource::<Preferences>()
        .insert_resource(Carrying::new(true))
        .add_systems(Startup, create_picture)
        .add_systems(PostUpdate, ask_for_gbuffer.before(EngineSystems::Detect))
        .add_systems(
            PostUpdate,
            (follow_carrying, update_picture).chain().after(EngineSystems::Report),
        );
    let world = app.world_mut();
    let ball = Shape {
        kind: ShapeKind::Sphere {
            center: Vec3::new(0.0, 0.0, 4.0),
            radius: 1.0,
        },
        ..Shape::default()
    };
    let ball = world.spawn((DocumentOrder(2), ball)).id();
    world.resource_mut::<RenderControl>().target_samples = Some(SAMPLES);
    update_until(&mut app, is_done);
    (app, ball)
}

fn is_done(world: &World) -> bool {
    let status = world.resource::<RenderStatus>();
    status.state == RenderState::Done && status.is_up_to_date
}

/// The bytes of the texture, and those of the film alone.
fn shown_and_film(world: &World) -> (Vec<u8>, Vec<u8>) {
    let images = world.resource::<Assets<Image>>();
    let (size, shown) = world.resource::<Picture>().pixels(images).expect("a picture");
    let film = &world.resource::<RenderFilm>().film;
    assert_eq!([size.x, size.y], [film.width(), film.height()]);
    let settings = world.resource::<ViewSettings>().display;
    let scales = Scales::default();
    let mut rgba = vec![0; shown.len()];
    Painter::new(film, &settings, &scales).paint(&tiles(size.x, size.y), &mut rgba);
    (shown.to_vec(), rgba)
}

/// Whether something was seen carried over until the picture was finished, after this command.
fn is_carried_after(app: &mut App, command: impl Into<Command>) -> bool {
    let before = app.world().resource::<RenderFilm>().job;
    apply(app.world_mut(), command).expect("applied");
    let mut is_seen = false;
    loop {
        app.update();
        let world = app.world();
        is_seen |= world.resource::<Carrying>().is_seen();
        if is_done(world) && world.resource::<RenderFilm>().job > before {
            break;
        }
    }
    // The frame after the last samples shows them alone.
    app.update();
    app.update();
    assert!(!app.world().resource::<Carrying>().is_seen());
    let (shown, film) = shown_and_film(app.world());
    assert!(shown == film, "the finished picture is not that of the film");
    is_seen
}

#[test]
fn the_picture_before_is_shown_until_the_new_one_is_finished_and_not_longer() {
    let (mut app, ball) = watched();
    for turn in 1..4 {
        let pose = Affine3A::from_rotation_y(0.02 * turn as f32);
        assert!(is_carried_after(&mut app, ViewCommand::MoveView(pose)));
    }
    let light = AreaLight::default();
    assert!(is_carried_after(&mut app, ValueEdit::SetAreaLight(ball, Some(light))));
    assert!(is_carried_after(&mut app, OutlineEdit::Hide(vec![ball], true)));
    assert!(app.world().get::<Hidden>(ball).is_some());
}

#[test]
fn another_display_in_between_loses_nothing() {
    let (mut app, _) = watched();
    for (mode, turn) in [(DisplayMode::Headlight, 0.02), (DisplayMode::Normal, 0.04)] {
        let shown = |mode| {
            Command::from(DisplayCommand::SetDisplay(DisplaySettings {
                mode,
                ..DisplaySettings::default()
            }))
        };
        apply(app.world_mut(), shown(mode)).expect("applied");
        (0..3).for_each(|_| app.update());
        assert!(!app.world().resource::<Carrying>().is_seen());
        update_until(&mut app, is_done);
        apply(app.world_mut(), shown(DisplayMode::Shaded)).expect("applied");
        app.update();
        let pose = Affine3A::from_rotation_y(turn);
        assert!(is_carried_after(&mut app, ViewCommand::MoveView(pose)), "{mode:?}");
    }
}

#[test]
fn a_finished_region_is_not_painted_again() {
    let (mut app, _) = watched();
    app.world_mut().resource_mut::<RenderControl>().region = Some(Rect::new(0.0, 0.0, 0.5, 0.5));
    apply(app.world_mut(), ViewCommand::MoveView(Affine3A::from_rotation_y(0.02))).expect("applied");
    let before = app.world().resource::<RenderFilm>().job;
    update_until(&mut app, |world| {
        is_done(world) && world.resource::<RenderFilm>().job > before
    });
    app.update();
    app.update();
    let revision = |app: &App| app.world().resource::<Picture>().revision;
    let at_rest = revision(&app);
    (0..5).for_each(|_| app.update());
    assert_eq!(revision(&app), at_rest);
    assert!(!app.world().resource::<Carrying>().is_seen());
}

#[test]
fn a_preference_switches_it_off() {
    let (mut app, _) = watched();
    app.world_mut().resource_mut::<Preferences>().carries_over = false;
    app.update();
    assert!(!app.world().resource::<RenderControl>().gbuffer);
    let pose = Affine3A::from_rotation_y(0.02);
    assert!(!is_carried_after(&mut app, ViewCommand::MoveView(pose)));
    assert!(app.world().resource::<RenderFilm>().gbuffer.is_empty());
}
