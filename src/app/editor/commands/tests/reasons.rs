//! The searches for reasons and for the light of a lamp: they begin when asked, tell how far they are, and begin anew
//! after an edit.

use super::full_film::{app, update_until};
use super::*;
use crate::app::editor::command::ToolCommand;
use crate::app::editor::command::inspected_paths::InspectedPaths;
use crate::app::editor::picture::lamp_light::{LampFollower, follow_lamp};
use crate::app::editor::picture::paths::{PathInspector, follow_paths};
use crate::app::editor::picture::reasons::{Reasons, follow_reasons};
use crate::app::editor::picture::search::SearchState;
use crate::engine::EngineSystems;
use crate::scene::EmitterKind;

/// An editor with a sky and a ball that shines, which is in the middle of the picture.
fn editor() -> (App, Entity) {
    let mut app = app();
    app.init_resource::<Reasons>()
        .init_resource::<LampFollower>()
        .init_resource::<PathInspector>()
        .add_systems(
            PostUpdate,
            (follow_reasons, follow_lamp, follow_paths)
                .chain()
                .before(EngineSystems::Detect),
        );
    let ball = Shape {
        kind: ShapeKind::Sphere {
            center: Vec3::new(0.0, 0.0, 4.0),
            radius: 1.0,
        },
        ..Shape::default()
    };
    let ball = app
        .world_mut()
        .spawn((DocumentOrder(2), ball, AreaLight::default()))
        .id();
    app.world_mut().resource_mut::<RenderControl>().target_samples = Some(4);
    update_until(&mut app, |world| world.resource::<PackedScene>().scene.is_some());
    (app, ball)
}

fn known(world: &World) -> Option<(bool, f32)> {
    let reasons = world.resource::<Reasons>();
    reasons
        .explanation
        .as_ref()
        .map(|known| (known.is_final, known.value.luminance))
}

fn is_final(world: &World) -> bool {
    known(world).is_some_and(|(is_final, _)| is_final)
}

fn state(world: &World) -> SearchState {
    world.resource::<Reasons>().state.clone()
}

#[test]
fn a_place_is_explained_and_again_after_an_edit() {
    let (mut app, ball) = editor();
    assert_eq!((state(app.world()), known(app.world())), (SearchState::Idle, None));
    let middle = InspectedPaths::at(Vec2::splat(0.5));
    apply(app.world_mut(), ToolCommand::InspectPaths(Some(middle))).expect("applied");
    app.update();
    assert!(matches!(state(app.world()), SearchState::Running(done) if (0.0..=1.0).contains(&done)));
    // The first answer comes before the final one.
    update_until(&mut app, |world| known(world).is_some());
    assert!(!is_final(app.world()));
    update_until(&mut app, is_final);
    assert_eq!(state(app.world()), SearchState::Idle);
    let (_, bright) = known(app.world()).expect("known");
    assert!((bright - 1.0).abs() < 1e-3, "{bright}");
    // Nothing is asked anew without a change.
    app.update();
    assert_eq!(state(app.world()), SearchState::Idle);
    let dim = AreaLight {
        radiance: Rgb::splat(0.25).into(),
        ..AreaLight::default()
    };
    apply(app.world_mut(), ValueEdit::SetAreaLight(ball, Some(dim))).expect("applied");
    update_until(&mut app, |world| {
        known(world).is_none_or(|(_, luminance)| luminance != bright)
    });
    update_until(&mut app, is_final);
    let (_, dimmed) = known(app.world()).expect("known");
    assert!((dimmed - 0.25).abs() < 1e-3, "{dimmed}");
    apply(app.world_mut(), ToolCommand::InspectPaths(None)).expect("applied");
    app.update();
    assert_eq!((state(app.world()), known(app.world())), (SearchState::Idle, None));
}

#[test]
fn an_edit_gives_up_the_search_that_is_going_on() {
    let (mut app, ball) = editor();
    // All pixels: this takes a while.
    let all = InspectedPaths::between([Vec2::ZERO, Vec2::ONE]);
    apply(app.world_mut(), ToolCommand::InspectPaths(Some(all))).expect("applied");
    app.update();
    assert!(matches!(state(app.world()), SearchState::Running(_)));
    apply(app.world_mut(), ValueEdit::SetAreaLight(ball, None)).expect("applied");
    let black = EmitterKind::Constant { radiance: Rgb::ZERO };
    let sky = app
        .world_mut()
        .query_filtered::<Entity, With<Emitter>>()
        .single(app.world())
        .expect("a sky");
    apply(app.world_mut(), ValueEdit::SetEmitter(sky, black.into())).expect("applied");
    update_until(&mut app, is_final);
    // The answer is that of the scene after the edits, in which nothing shines.
    assert_eq!(known(app.world()), Some((true, 0.0)));
}

#[test]
fn the_light_of_a_lamp_is_followed_until_it_is_forgotten() {
    let (mut app, ball) = editor();
    let follower = |app: &App| {
        let follower = app.world().resource::<LampFollower>();
        (follower.light.clone(), follower.state.clone())
    };
    apply(app.world_mut(), ToolCommand::FollowLamp(Some(ball))).expect("applied");
    app.update();
    let (light, state) = follower(&app);
    assert!(light.is_none() && matches!(state, SearchState::Running(_)), "{state:?}");
    update_until(&mut app, |world| world.resource::<LampFollower>().light.is_some());
    let (light, state) = follower(&app);
    // Nothing is around the ball.
    let light = light.expect("known");
    assert!(
        (light.escaped[0] - 1.0).abs() < 1e-5 && light.receivers.is_empty(),
        "{light:?}"
    );
    assert_eq!(state, SearchState::Idle);
    apply(app.world_mut(), ToolCommand::FollowLamp(None)).expect("applied");
    app.update();
    assert_eq!(follower(&app), (None, SearchState::Idle));
    // What does not shine cannot be followed.
    apply(app.world_mut(), ValueEdit::SetAreaLight(ball, None)).expect("applied");
    update_until(&mut app, |world| {
        !world.resource::<PackedScene>().lamps.owners.contains(&ball)
    });
    apply(app.world_mut(), ToolCommand::FollowLamp(Some(ball))).expect("applied");
    app.update();
    assert_eq!(app.world().resource::<LampFollower>().lamp, None);
}
