//! Tests of commands on a world without a window.

mod blocking;
mod carrying;
#[cfg(feature = "denoise")]
mod denoising;
mod exporting;
mod file_use;
mod files;
mod full_film;
mod grouping;
mod kept_picture;
mod light_paint;
mod lights;
mod markers;
mod material_trees;
mod materials;
mod picking;
mod placing;
mod projecting;
mod properties;
mod reasons;
mod replacing;
mod saving;
mod seeing;
mod steps;
mod views;

use std::path::{Path, PathBuf};

use bevy::math::Affine3A;

use super::bare_world::bare_world;
use super::*;
use crate::app::editor::command::addition::{Addition, AdditionKind};
use crate::app::editor::command::arrange::Direction;
use crate::app::editor::command::display::{DisplayMode, DisplaySettings};
use crate::app::editor::command::gizmo_settings::{GizmoSettings, Steps};
use crate::app::editor::command::light_mix::LightMix;
use crate::app::editor::command::material_tree::MaterialTree;
use crate::app::editor::command::selection::{Extend, Selection};
use crate::app::editor::command::tool::Tool;
use crate::app::editor::command::{
    ArrangeEdit, DisplayCommand, EditCommand, HistoryCommand, MaterialEdit, OutlineEdit, RenderCommand, SceneEdit,
    SelectionCommand, TextureEdit, ToolCommand, ValueEdit, ViewCommand,
};
use crate::app::editor::picture::compare::Comparison;
use crate::app::editor::session::history;
use crate::app::editor::session::requests::{CommandQueue, Requests};
use crate::app::editor::session::view_settings::ViewSettings;
use crate::color::Rgb;
use crate::engine::{PackedScene, RenderControl, RenderFilm, ViewMode};
use crate::scene::{
    ActiveSensor, AreaLight, DocumentOrder, Emitter, FirstNested, Hidden, Material, ObjectState, Parameter, SceneId,
    Sensor, Shape, ShapeKind, SquarePath, ToWorld, UsesMaterial,
};

fn say(world: &mut World, command: impl Into<Command>) {
    world.resource_mut::<CommandQueue>().0.push(command.into());
    apply_commands(world);
}

#[test]
fn saying_what_is_so_changes_nothing() {
    let mut world = bare_world();
    let material = Material::default();
    let entity = world.spawn(material.clone()).id();
    world.clear_trackers();
    say(&mut world, ValueEdit::SetMaterial(entity, Box::new(material)));
    let paused = world.resource::<RenderControl>().paused;
    say(&mut world, RenderCommand::SetPaused(paused));
    assert!(
        !world
            .entity(entity)
            .get_ref::<Material>()
            .is_some_and(|m| m.is_changed())
    );
    assert!(!world.resource_ref::<RenderControl>().is_changed());
    let red = Material::Diffuse {
        reflectance: Rgb::X.into(),
    };
    say(&mut world, ValueEdit::SetMaterial(entity, Box::new(red.clone())));
    assert_eq!(world.get::<Material>(entity), Some(&red));
    assert!(
        world
            .entity(entity)
            .get_ref::<Material>()
            .is_some_and(|m| m.is_changed())
    );
}

#[test]
fn a_picture_goes_to_whatever_has_one() {
    let mut world = bare_world();
    let lamp = world.spawn((Shape::default(), AreaLight::default())).id();
    let sky = world.spawn(Emitter::of_plugin("envmap").expect("a plugin")).id();
    for owner in [lamp, sky] {
        let path = PathBuf::from("/pictures/sky.exr");
        let parameter = "filename";
        let place = SquarePath::WHOLE;
        let command = Command::from(TextureEdit::SetPicture {
            owner,
            parameter,
            place,
            path,
        });
        say(&mut world, command);
    }
    let mut found = Vec::new();
    if let Some(Emitter { kind, .. }) = world.get(sky) {
        Emitter::from(kind.clone()).for_each_picture(&mut |path| found.push(path.clone()));
    }
    if let Some(Parameter::Texture(texture)) = world.get::<AreaLight>(lamp).map(|light| &light.radiance) {
        texture.for_each_bitmap(&mut |bitmap| found.push(bitmap.path.clone()));
    }
    assert_eq!(found, [Path::new("/pictures/sky.exr"); 2]);
}

#[test]
fn the_tool_that_places_textures_says_what_it_needs() {
    let mut world = bare_world();
    let tool = Command::from(ToolCommand::SetTool(Tool::PlaceTexture));
    let said = |world: &mut World| apply(world, tool.clone()).expect_err("there is no texture").to_string();
    assert!(said(&mut world).contains("a picture or a checkerboard"));
    let shape = add(&mut world, AdditionKind::Cube);
    say(&mut world, MaterialEdit::GiveMaterial { shape });
    assert!(said(&mut world).contains("a picture or a checkerboard"));
    assert_eq!(world.resource::<ViewSettings>().tool, Tool::Select);
    let choose = Command::from(TextureEdit::SetPicture {
        owner: world.get::<UsesMaterial>(shape).expect("its own").0,
        parameter: "reflectance",
        place: SquarePath::WHOLE,
        path: "/pictures/one.png".into(),
    });
    say(&mut world, choose);
    apply(&mut world, tool.clone()).expect("there is one");
    assert_eq!(world.resource::<ViewSettings>().tool, Tool::PlaceTexture);
}

#[test]
fn a_picture_is_put_upright_onto_what_shows_it_upside_down() {
    for (kind, turned) in [
        (AdditionKind::Rectangle, true),
        (AdditionKind::Cylinder, true),
        (AdditionKind::Sphere, false),
        (AdditionKind::Cube, false),
    ] {
        let mut world = bare_world();
        let shape = add(&mut world, kind);
        say(&mut world, MaterialEdit::GiveMaterial { shape });
        let owner = world.get::<UsesMaterial>(shape).expect("its own").0;
        for path in ["/pictures/one.png", "/pictures/other.png"] {
            let choose = Command::from(TextureEdit::SetPicture {
                owner,
                parameter: "reflectance",
                place: SquarePath::WHOLE,
                path: path.into(),
            });
            say(&mut world, choose);
            let mut to_uv = None;
            let material = world.get::<Material>(owner).expect("a material");
            material.for_each_texture(&mut |texture| texture.for_each_bitmap(&mut |bitmap| to_uv = Some(bitmap.to_uv)));
            let upper = to_uv.expect("a picture").transform_point2(Vec2::Y);
            let expected = if turned { Vec2::ZERO } else { Vec2::Y };
            assert!(upper.abs_diff_eq(expected, 1e-6), "{kind:?}: {upper}");
        }
    }
}

#[test]
fn commands_about_what_is_gone_do_no_harm() {
    let mut world = bare_world();
    let gone = world.spawn_empty().id();
    world.despawn(gone);
    say(&mut world, ValueEdit::SetEmitter(gone, Emitter::default()));
    say(&mut world, ViewCommand::MoveView(Affine3A::IDENTITY));
    say(&mut world, ViewCommand::LookThrough(gone));
    assert!(world.query::<&Emitter>().iter(&world).next().is_none());
}

fn add(world: &mut World, kind: AdditionKind) -> Entity {
    say(world, SceneEdit::Add(kind.into()));
    world
        .resource::<Selection>()
        .active()
        .expect("what was added is selected")
}

#[test]
fn the_history_says_what_a_change_of_pose_does() {
    let mut world = bare_world();
    let ball = add(&mut world, AdditionKind::Cube);
    let pose = world.get::<ToWorld>(ball).expect("a pose").0;
    let last = |world: &World| {
        world
            .resource::<History>()
            .labels()
            .0
            .last()
            .map(|label| label.to_string())
    };
    for (change, verb) in [
        (Affine3A::from_translation(Vec3::X), "Move"),
        (Affine3A::from_rotation_y(1.0), "Rotate"),
        (Affine3A::from_scale(Vec3::splat(2.0)), "Scale"),
    ] {
        world.resource_mut::<Requests>().interaction += 1;
        let after = pose * change;
        say(&mut world, ValueEdit::Transform(vec![(ball, after)]));
        let label = last(&world).expect("a step");
        assert!(label.starts_with(verb), "{label}");
        say(&mut world, HistoryCommand::Undo);
    }
}

#[test]
fn the_history_names_what_a_step_was_about() {
    let mut world = bare_world();
    let ball = add(&mut world, AdditionKind::Sphere);
    say(&mut world, OutlineEdit::Rename(ball, "ball".into()));
    say(&mut world, SceneEdit::Duplicate);
    let both = world.query_filtered::<Entity, With<Shape>>().iter(&world).collect();
    say(&mut world, SelectionCommand::Select(both, Extend::Replace));
    say(&mut world, ArrangeEdit::Nudge(Direction::Up));
    say(&mut world, SelectionCommand::Select(vec![ball], Extend::Replace));
    say(&mut world, SceneEdit::Delete);
    assert_eq!(
        world.resource::<History>().labels().0,
        [
            "Add sphere `sphere`",
            "Rename `sphere`: ball",
            "Duplicate `ball`",
            "Move 2 things",
            "Delete `ball`"
        ]
    );
}

#[test]
fn steps_add_up_to_round_numbers() {
    let mut world = bare_world();
    let ball = add(&mut world, AdditionKind::Sphere);
    let steps = Steps {
        length: Some(0.1),
        ..Steps::default()
    };
    let gizmo = GizmoSettings {
        steps,
        ..GizmoSettings::default()
    };
    say(&mut world, ToolCommand::SetGizmo(gizmo));
    for _ in 0..7 {
        say(&mut world, ArrangeEdit::Nudge(Direction::Up));
    }
    let place = |world: &World, entity| world.get::<ToWorld>(entity).map(|pose| pose.0.translation.y);
    assert_eq!(place(&world, ball).map(|y| y.to_string()), Some("1.2".to_owned()));
}

#[test]
fn a_drag_is_one_step_and_comes_back() {
    let mut world = bare_world();
    let ball = add(&mut world, AdditionKind::Sphere);
    let before = ObjectState::of(&world, ball);
    for x in 1..5 {
        let pose = Affine3A::from_translation(Vec3::X * x as f32);
        say(&mut world, ValueEdit::Transform(vec![(ball, pose)]));
    }
    assert_eq!(world.resource::<History>().len(), (2, 0));
    say(&mut world, HistoryCommand::Undo);
    assert_eq!(ObjectState::of(&world, ball), before);
    say(&mut world, HistoryCommand::Redo);
    let pose = world.get::<ToWorld>(ball).map(|pose| pose.0.translation.x);
    assert_eq!(pose, Some(4.0));
    world.resource_mut::<Requests>().interaction += 1;
    say(&mut world, ValueEdit::Transform(vec![(ball, Affine3A::IDENTITY)]));
    assert_eq!(world.resource::<History>().len(), (3, 0));
    say(&mut world, HistoryCommand::GoTo(0));
    assert!(!ObjectState::of(&world, ball).is_there());
    assert!(world.resource::<Selection>().is_empty());
}

#[test]
fn what_fails_leaves_nothing_behind() {
    let mut world = bare_world();
    let ball = add(&mut world, AdditionKind::Sphere);
    let before = (ObjectState::of(&world, ball), world.resource::<History>().len());
    let failed = apply(
        &mut world,
        SceneEdit::Paste("<shape type=\"sphere\"><float name=\"radius\"/></shape>".into()),
    );
    assert!(failed.is_err_and(|error| error.to_string().contains("clipboard.xml:1:")));
    assert!(apply(&mut world, OutlineEdit::Rename(ball, "a.b".into())).is_err());
    assert_eq!(
        (ObjectState::of(&world, ball), world.resource::<History>().len()),
        before
    );
}

#[test]
fn what_is_copied_can_be_pasted() {
    let mut world = bare_world();
    let ball = add(&mut world, AdditionKind::Sphere);
    say(&mut world, MaterialEdit::GiveMaterial { shape: ball });
    say(&mut world, SelectionCommand::Copy);
    let text = world.resource_mut::<Requests>().clipboard.take().expect("a text");
    let shapes_text = text.clone();
    say(&mut world, SceneEdit::Paste(text.clone()));
    let copy = world.resource::<Selection>().active().expect("the copy");
    assert_ne!(copy, ball);
    assert_eq!(world.get::<Name>(copy).map(Name::as_str), Some("sphere-2"));
    assert_eq!(world.get::<Shape>(copy), world.get::<Shape>(ball));
    // Its material exists already.
    let uses = |world: &World, shape| world.get::<UsesMaterial>(shape).copied();
    assert!(uses(&world, copy).is_some() && uses(&world, copy) == uses(&world, ball));
    let materials = |world: &mut World| world.query::<&Material>().iter(world).count();
    assert_eq!(materials(&mut world), 1);
    // A material that was changed in the meantime is another one.
    let material = uses(&world, ball).map(|uses| uses.0).expect("a material");
    let red = Material::Diffuse {
        reflectance: Rgb::X.into(),
    };
    say(&mut world, ValueEdit::SetMaterial(material, Box::new(red.clone())));
    say(&mut world, SceneEdit::Paste(text.clone()));
    let other = world.resource::<Selection>().active().expect("the copy");
    assert_ne!(uses(&world, other), uses(&world, ball));
    assert_eq!(materials(&mut world), 2);
    // A material by itself is copied.
    say(&mut world, SelectionCommand::Select(vec![material], Extend::Replace));
    say(&mut world, SelectionCommand::Copy);
    let text = world.resource_mut::<Requests>().clipboard.take().expect("a text");
    say(&mut world, SceneEdit::Paste(text));
    let copy = world.resource::<Selection>().active().expect("the copy");
    assert_eq!((copy != material, world.get::<Material>(copy)), (true, Some(&red)));
    // The material comes along into another scene.
    let mut elsewhere = bare_world();
    say(&mut elsewhere, SceneEdit::Paste(shapes_text));
    assert_eq!(materials(&mut elsewhere), 1);
}

#[test]
fn new_things_have_names_of_their_own_and_go_where_they_are_told() {
    let mut world = bare_world();
    add(&mut world, AdditionKind::Cube);
    let light = Addition {
        at: Some(Vec3::Y * 3.0),
        ..AdditionKind::AreaLight.into()
    };
    say(&mut world, SceneEdit::Add(light));
    let second = add(&mut world, AdditionKind::Cube);
    assert_eq!(world.get::<Name>(second).map(Name::as_str), Some("cube-2"));
    let mut lights = world.query::<(&AreaLight, &ToWorld)>();
    let places: Vec<Vec3> = lights
        .iter(&world)
        .map(|(_, pose)| pose.0.transform_vector3(Vec3::Z))
        .collect();
    assert!(matches!(places[..], [down] if down.y < 0.0), "{places:?}");
    assert!(apply(&mut world, SceneEdit::Add(AdditionKind::Emitter("envmap").into())).is_err());
}

#[test]
fn groups_are_names_in_a_folder() {
    let mut world = bare_world();
    let [a, b] = [add(&mut world, AdditionKind::Cube), add(&mut world, AdditionKind::Disk)];
    say(&mut world, SelectionCommand::Select(vec![a, b], Extend::Replace));
    say(&mut world, OutlineEdit::Group);
    let name = |entity| world.get::<Name>(entity).map(|name| name.as_str().to_owned());
    assert_eq!(
        (name(a), name(b)),
        (Some("group/cube".into()), Some("group/disk".into()))
    );
}

#[test]
fn the_heat_map_is_another_view() {
    let mut world = bare_world();
    let display = DisplaySettings {
        mode: DisplayMode::BvhSteps,
        ..DisplaySettings::default()
    };
    say(&mut world, DisplayCommand::SetDisplay(display));
    assert_eq!(world.resource::<RenderControl>().view_mode, ViewMode::BvhSteps);
}

#[test]
fn an_edit_of_one_is_made_to_all_that_is_selected() {
    let mut world = bare_world();
    let balls = [0; 3].map(|_| add(&mut world, AdditionKind::Sphere));
    let cube = add(&mut world, AdditionKind::Cube);
    let materials = balls.map(|ball| {
        say(&mut world, MaterialEdit::GiveMaterial { shape: ball });
        world.get::<UsesMaterial>(ball).expect("a material").0
    });
    let radius = |world: &World, ball| match world.get::<Shape>(ball).map(|shape| shape.kind.clone()) {
        Some(ShapeKind::Sphere { radius, .. }) => radius,
        other => panic!("{other:?}"),
    };
    let selected = vec![balls[0], cube, balls[1]];
    say(&mut world, SelectionCommand::Select(selected, Extend::Replace));
    let steps = world.resource::<History>().len().0;
    let untouched = radius(&world, balls[2]);
    let mut larger = world.get::<Shape>(balls[1]).cloned().expect("a shape");
    larger.kind = ShapeKind::Sphere {
        center: Vec3::ZERO,
        radius: 7.0,
    };
    say(
        &mut world,
        EditCommand::OnSelection(Box::new(ValueEdit::SetShape(balls[1], larger))),
    );
    assert_eq!(balls.map(|ball| radius(&world, ball)), [7.0, 7.0, untouched]);
    let red = Material::Diffuse {
        reflectance: Rgb::X.into(),
    };
    let paint = ValueEdit::SetMaterial(materials[1], Box::new(red.clone()));
    say(&mut world, EditCommand::OnSelection(Box::new(paint)));
    let is_red = materials.map(|material| world.get::<Material>(material) == Some(&red));
    assert_eq!(is_red, [true, true, false]);
    // Only the changed part of the place is taken; turns are about the own origin.
    let before = [balls[0], cube].map(|thing| world.get::<ToWorld>(thing).expect("a place").0);
    let mut pose = world.get::<ToWorld>(balls[1]).expect("a place").0;
    pose.translation.y += 5.0;
    pose.matrix3 *= bevy::math::Mat3A::from_rotation_x(1.0);
    let place = ValueEdit::Transform(vec![(balls[1], pose)]);
    say(&mut world, EditCommand::OnSelection(Box::new(place)));
    for (thing, before) in [balls[0], cube].into_iter().zip(before) {
        let now = world.get::<ToWorld>(thing).expect("a place").0;
        assert_eq!(now.translation.y, pose.translation.y);
        assert_eq!(
            (now.translation.x, now.translation.z),
            (before.translation.x, before.translation.z)
        );
        let turned = before.matrix3 * bevy::math::Mat3A::from_rotation_x(1.0);
        assert!(now.matrix3.abs_diff_eq(turned, 1e-5));
    }
    // One step each.
    assert_eq!(world.resource::<History>().len().0, steps + 3);
}

#[test]
fn what_can_never_come_back_is_despawned() {
    let mut world = bare_world();
    let kept = add(&mut world, AdditionKind::Cube);
    let spawned = |world: &World| world.entities().count_spawned();
    let before = spawned(&world);
    for _ in 0..2000 {
        add(&mut world, AdditionKind::Sphere);
        // The edit is undone, and then lost by the next edit.
        say(&mut world, HistoryCommand::Undo);
        history::despawn_forgotten(&mut world);
    }
    assert!(spawned(&world) < before + 600, "{} {before}", spawned(&world));
    let deleted = add(&mut world, AdditionKind::Sphere);
    say(&mut world, SceneEdit::Delete);
    for _ in 0..700 {
        add(&mut world, AdditionKind::Sphere);
        say(&mut world, HistoryCommand::Undo);
        history::despawn_forgotten(&mut world);
    }
    assert!(world.get_entity(deleted).is_ok(), "it can be undone");
    assert!(world.get::<Shape>(kept).is_some());
    say(&mut world, HistoryCommand::GoTo(2));
    assert!(world.get::<Shape>(deleted).is_some());
    world.resource_mut::<History>().clear();
    assert_eq!(world.resource::<History>().bytes(), 0);
}

#[test]
fn the_history_is_bounded_in_memory() {
    let mut world = bare_world();
    let ball = add(&mut world, AdditionKind::Sphere);
    let megabyte = "n".repeat(1 << 20);
    for number in 0..200 {
        let name = format!("{megabyte}{number}");
        apply(&mut world, OutlineEdit::Rename(ball, name)).expect("a name");
    }
    let history = world.resource::<History>();
    assert!(history.bytes() <= history::MOST_BYTES, "{}", history.bytes());
    assert!(history.len().0 > 5 && !history.is_whole());
    say(&mut world, HistoryCommand::Undo);
    let name = world.get::<Name>(ball).expect("a name");
    assert!(name.as_str().ends_with("198"));
}

#[test]
fn what_comes_back_does_not_share_an_id() {
    let mut world = bare_world();
    let balls = [0; 2].map(|_| add(&mut world, AdditionKind::Sphere));
    let [one, two] = balls.map(|shape| {
        say(&mut world, MaterialEdit::GiveMaterial { shape });
        world.get::<UsesMaterial>(shape).expect("a material").0
    });
    // Saving gives ids to materials that several shapes have, and takes the first id that no thing of the scene has.
    let id = || SceneId("material-1".to_owned());
    world.entity_mut(one).insert(id());
    say(&mut world, SelectionCommand::Select(vec![one], Extend::Replace));
    say(&mut world, SceneEdit::Delete);
    world.entity_mut(two).insert(id());
    say(&mut world, HistoryCommand::Undo);
    let ids = [one, two].map(|material| world.get::<SceneId>(material).cloned());
    assert!(ids[0].is_some() && ids[0] != ids[1], "{ids:?}");
    assert_eq!(ids[1], Some(id()));
}
