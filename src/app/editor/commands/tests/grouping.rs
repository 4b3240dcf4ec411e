//! Tests of groups: folders with a transform of their own.

use bevy::math::Affine3A;

use super::*;
use crate::app::editor::command::selection::Alike;
use crate::app::editor::model::EditorModel;
use crate::app::editor::model::inspection::gather_selection;
use crate::app::editor::model::leaks::Leaks;
use crate::app::editor::model::mixed::Mixed;
use crate::scene::{TriangleMesh, UsesMaterial};

fn ball(world: &mut World, name: &str, x: f32) -> Entity {
    let addition = Addition {
        name: Some(name.into()),
        at: Some(Vec3::X * x),
        size: Some(0.5),
        ..AdditionKind::Sphere.into()
    };
    say(world, SceneEdit::Add(addition));
    active(world)
}

fn active(world: &World) -> Entity {
    world.resource::<Selection>().active().expect("something is selected")
}

fn name(world: &World, entity: Entity) -> String {
    world.get::<Name>(entity).map_or_else(String::new, Name::to_string)
}

fn pose(world: &World, entity: Entity) -> Affine3A {
    world.get::<ToWorld>(entity).expect("a pose").0
}

fn select(world: &mut World, things: &[Entity]) {
    say(world, SelectionCommand::Select(things.to_vec(), Extend::Replace));
}

/// Two balls in a group, and the group.
fn pair(world: &mut World) -> [Entity; 3] {
    let balls = [ball(world, "left", -1.0), ball(world, "right", 3.0)];
    select(world, &balls);
    say(world, OutlineEdit::Group);
    [balls[0], balls[1], active(world)]
}

#[test]
fn what_is_in_a_group_moves_with_it() {
    let mut world = bare_world();
    let [left, right, group] = pair(&mut world);
    assert_eq!(
        [left, right, group].map(|it| name(&world, it)),
        ["group/left", "group/right", "group/"]
    );
    // The group's place is the middle of the bounds of its members.
    assert_eq!(Vec3::from(pose(&world, group).translation), Vec3::new(1.0, 0.5, 0.0));
    let turned =
        Affine3A::from_rotation_translation(bevy::math::Quat::from_rotation_y(std::f32::consts::FRAC_PI_2), Vec3::Y);
    select(&mut world, &[group]);
    say(
        &mut world,
        EditCommand::OnSelection(Box::new(ValueEdit::Transform(vec![(group, turned)]))),
    );
    let place = |world: &World, entity| Vec3::from(pose(world, entity).translation);
    assert!(
        place(&world, left).abs_diff_eq(Vec3::new(0.0, 1.0, 2.0), 1e-5),
        "{}",
        place(&world, left)
    );
    assert!(place(&world, right).abs_diff_eq(Vec3::new(0.0, 1.0, -2.0), 1e-5));
    // A member that is moved as well is where it was put, and a locked one stays.
    say(&mut world, HistoryCommand::Undo);
    say(&mut world, OutlineEdit::Lock(vec![right], true));
    let [to, own] = [5.0, 7.0].map(|x| Affine3A::from_translation(Vec3::X * x));
    say(&mut world, ValueEdit::Transform(vec![(left, own), (group, to)]));
    assert_eq!((place(&world, left).x, place(&world, right).x), (7.0, 3.0));
}

#[test]
fn groups_are_in_groups_and_come_out_again() {
    let mut world = bare_world();
    let [left, right, inner] = pair(&mut world);
    say(&mut world, OutlineEdit::Rename(inner, "pair".into()));
    let other = ball(&mut world, "other", 9.0);
    select(&mut world, &[other, left, right, inner]);
    say(&mut world, OutlineEdit::Group);
    let outer = active(&world);
    assert_eq!(world.resource::<Requests>().nameless_group, Some(outer));
    let names = |world: &World| [left, right, inner, other, outer].map(|it| name(world, it));
    let nested = [
        "group/pair/left",
        "group/pair/right",
        "group/pair/",
        "group/other",
        "group/",
    ];
    assert_eq!(names(&world), nested);
    let before = pose(&world, left).translation.x;
    let moved = Affine3A::from_translation(Vec3::X) * pose(&world, outer);
    say(&mut world, ValueEdit::Transform(vec![(outer, moved)]));
    assert_eq!(pose(&world, left).translation.x, before + 1.0);
    // The first selects the group of a ball, the next the group around that.
    select(&mut world, &[left]);
    say(&mut world, SelectionCommand::SelectGroup);
    assert_eq!(
        (active(&world), world.resource::<Selection>().entities().len()),
        (inner, 3)
    );
    say(&mut world, SelectionCommand::SelectGroup);
    assert_eq!(
        (active(&world), world.resource::<Selection>().entities().len()),
        (outer, 5)
    );
    assert!(apply(&mut world, SelectionCommand::SelectGroup).is_err());
    assert!(
        apply(
            &mut world,
            OutlineEdit::PutInto {
                things: vec![outer],
                folder: Some("group/pair".into())
            }
        )
        .is_err()
    );
    say(&mut world, OutlineEdit::Ungroup);
    assert_eq!(names(&world)[..4], ["pair/left", "pair/right", "pair/", "other"]);
    assert!(!ObjectState::is_in_scene(&world, outer));
    say(&mut world, HistoryCommand::Undo);
    assert_eq!(names(&world), nested);
}

#[test]
fn a_copy_of_a_group_is_a_group() {
    let mut world = bare_world();
    pair(&mut world);
    say(&mut world, SceneEdit::Duplicate);
    let copies = world.resource::<Selection>().entities().to_vec();
    let names: Vec<String> = copies.iter().map(|it| name(&world, *it)).collect();
    assert_eq!(names, ["group-2/left", "group-2/right", "group-2/"]);
}

#[test]
fn the_frame_of_a_group_is_copied_with_what_is_in_the_group() {
    for command in [
        Command::from(SceneEdit::Duplicate),
        Command::from(SelectionCommand::Copy),
    ] {
        let mut world = bare_world();
        let [.., group] = pair(&mut world);
        select(&mut world, &[group]);
        let copies = command == Command::from(SelectionCommand::Copy);
        say(&mut world, command);
        let clipboard = world.resource::<Requests>().clipboard.clone();
        if let Some(text) = clipboard.filter(|_| copies) {
            say(&mut world, SceneEdit::Paste(text));
        }
        let selected = world.resource::<Selection>().entities().to_vec();
        let names: Vec<String> = selected.iter().map(|it| name(&world, *it)).collect();
        assert_eq!(names, ["group-2/left", "group-2/right", "group-2/"]);
    }
}

#[test]
fn a_copy_of_a_group_can_be_pasted() {
    let mut world = bare_world();
    pair(&mut world);
    say(&mut world, SelectionCommand::Copy);
    let text = world.resource_mut::<Requests>().clipboard.take().expect("a text");
    say(&mut world, SceneEdit::Paste(text.clone()));
    let names = |world: &World| {
        let pasted = world.resource::<Selection>().entities().iter();
        pasted.map(|it| name(world, *it)).collect::<Vec<_>>()
    };
    assert_eq!(names(&world), ["group-2/left", "group-2/right", "group-2/"]);
    let mut elsewhere = bare_world();
    say(&mut elsewhere, SceneEdit::Paste(text));
    assert_eq!(names(&elsewhere), ["group/left", "group/right", "group/"]);
}

#[test]
fn a_group_that_comes_out_of_another_stays_whole() {
    let mut world = bare_world();
    let outside = pair(&mut world);
    let inside = pair(&mut world);
    let left = ball(&mut world, "ball", 9.0);
    let house = [inside[0], inside[1], inside[2], left];
    select(&mut world, &house);
    say(&mut world, OutlineEdit::Group);
    let frame = active(&world);
    say(&mut world, OutlineEdit::Rename(frame, "house".into()));
    say(&mut world, OutlineEdit::Rename(inside[2], "house/group".into()));
    ball(&mut world, "ball", 12.0);
    let names = |world: &World, things: &[Entity]| things.iter().map(|it| name(world, *it)).collect::<Vec<_>>();
    let before = names(&world, &house);
    assert_eq!(before[2..], ["house/group/", "house/ball"]);
    select(&mut world, &[frame]);
    say(&mut world, OutlineEdit::Ungroup);
    let freed = names(&world, &house);
    assert!(
        freed[0].starts_with("group-2/") && freed[1].starts_with("group-2/"),
        "{freed:?}"
    );
    assert_eq!(freed[2..], ["group-2/", "ball-2"]);
    assert_eq!(names(&world, &outside), ["group/left", "group/right", "group/"]);
    // A group inside one of the same name takes its place.
    say(&mut world, HistoryCommand::Undo);
    say(&mut world, OutlineEdit::Rename(inside[2], "house/house".into()));
    select(&mut world, &[frame]);
    say(&mut world, OutlineEdit::Ungroup);
    assert_eq!(names(&world, &house)[2..], ["house/", "ball-2"]);
}

#[test]
fn a_number_that_is_typed_is_for_all_that_is_selected() {
    let mut world = bare_world();
    let alone = ball(&mut world, "alone", 8.0);
    let [left, right, group] = pair(&mut world);
    let xs = |world: &World| [alone, left, right, group].map(|it| pose(world, it).translation.x);
    for (active, others) in [(group, [alone, left, right]), (alone, [left, right, group])] {
        select(&mut world, &[others[0], others[1], others[2], active]);
        let mut after = pose(&world, active);
        after.translation.x = 5.0;
        let typed = ValueEdit::Transform(vec![(active, after)]);
        say(&mut world, EditCommand::OnSelection(Box::new(typed)));
        assert_eq!(xs(&world), [5.0, 3.0, 7.0, 5.0]);
        say(&mut world, HistoryCommand::Undo);
        assert_eq!(xs(&world), [8.0, -1.0, 3.0, 1.0]);
    }
}

#[test]
fn members_keep_the_coordinates_along_which_a_group_does_not_move() {
    let mut world = bare_world();
    let [left, _, group] = pair(&mut world);
    let odd = Vec3::new(-1.0, 0.123_456_79, 1.0 / 3.0);
    say(
        &mut world,
        ValueEdit::Transform(vec![(left, Affine3A::from_translation(odd))]),
    );
    let moved = Affine3A::from_translation(Vec3::X) * pose(&world, group);
    say(&mut world, ValueEdit::Transform(vec![(group, moved)]));
    let place = Vec3::from(pose(&world, left).translation);
    assert_eq!(place, Vec3::new(0.0, odd.y, odd.z));
}

#[test]
fn a_group_becomes_instances_of_what_is_in_it() {
    use crate::app::editor::command::arrange::{Series, Way};
    use crate::app::editor::command::{HistoryCommand, SceneEdit};
    use crate::scene::MemberOf;
    let mut world = bare_world();
    let [left, right, group] = pair(&mut world);
    let series = |instances| {
        Command::from(SceneEdit::MakeSeries(Series {
            count: 3,
            way: Way::Along(Vec3::Z),
            instances,
        }))
    };
    say(&mut world, series(false));
    let copies: Vec<String> = world.resource::<Selection>().entities()[3..]
        .iter()
        .map(|it| name(&world, *it))
        .collect();
    assert_eq!(copies[2..4], ["group-2/", "group-3/left"]);
    say(&mut world, HistoryCommand::Undo);
    select(&mut world, &[group]);
    say(&mut world, series(true));
    assert!(!ObjectState::is_in_scene(&world, group));
    assert!([left, right].iter().all(|it| world.get::<MemberOf>(*it).is_some()));
    let instances = world.resource::<Selection>().entities().to_vec();
    assert_eq!((instances.len(), &*name(&world, instances[0])), (3, "group-instance"));
    say(&mut world, HistoryCommand::Undo);
    assert!(ObjectState::is_in_scene(&world, group) && world.get::<MemberOf>(left).is_none());
}

#[test]
fn a_group_is_shown_alone_with_what_is_in_it() {
    let mut world = bare_world();
    let [left, right, group] = pair(&mut world);
    say(&mut world, ViewCommand::Isolate(vec![group]));
    assert_eq!(world.resource::<RenderControl>().sight.only, [left, right]);
    say(&mut world, OutlineEdit::Ungroup);
    let empty = Shape {
        kind: ShapeKind::Frame,
        ..Shape::default()
    };
    let empty = world.spawn((empty, DocumentOrder(99), Name::new("empty/"))).id();
    assert!(apply(&mut world, ViewCommand::Isolate(vec![empty])).is_err());
}

#[test]
fn a_group_has_no_surface_and_is_in_the_file() {
    let mut world = bare_world();
    let [.., group] = pair(&mut world);
    assert!(apply(&mut world, MaterialEdit::GiveMaterial { shape: group }).is_err());
    assert!(apply(&mut world, ValueEdit::SetAreaLight(group, Some(AreaLight::default()))).is_err());
    let scene = crate::scene::write::gather::describe(&mut world);
    let document = crate::scene::write::to_document(&scene, Path::new("/group.xml"));
    let text = crate::document::to_xml(&document).expect("it can be written");
    let mut again = crate::document::parse_str(&*text, Path::new("/group.xml"), &[]);
    let read = crate::scene::read::read(&mut again);
    assert!(!again.diagnostics.has_errors(), "{}", again.diagnostics);
    assert!(text.contains("<volume type=\"constvolume\" id=\"group/\">"), "{text}");
    let found = read.shapes.iter().find(|shape| shape.shape.is_frame());
    let place = found.map(|shape| Vec3::from(shape.to_world.translation));
    assert_eq!(place, Some(Vec3::new(1.0, 0.5, 0.0)));
    assert_eq!(read.shapes.len(), 3);
}

#[test]
fn a_selected_group_is_inspected_by_its_own_transform() {
    let mut world = bare_world();
    world.init_resource::<EditorModel>();
    world.init_resource::<Assets<TriangleMesh>>();
    world.init_resource::<Leaks>();
    let [left, _, group] = pair(&mut world);
    let inspected = |world: &mut World| {
        world.run_system_cached(gather_selection).expect("runs");
        let inspected = world.resource::<EditorModel>().0.inspected.clone();
        inspected.map(|shown| (shown.entity, shown.members, shown.mixed == Mixed::default()))
    };
    assert_eq!(inspected(&mut world), Some((group, Some(2), true)));
    // With anything else it is one of several.
    let other = ball(&mut world, "other", 9.0);
    select(&mut world, &[left, other, group]);
    assert_eq!(inspected(&mut world), Some((group, None, false)));
}

#[test]
fn things_that_are_alike_are_selected_together() {
    let mut world = bare_world();
    let [left, right, other] =
        [("left", 0.0), ("right", 2.0), ("other", 4.0)].map(|(name, x)| ball(&mut world, name, x));
    say(&mut world, SceneEdit::Add(AdditionKind::Cube.into()));
    let cube = active(&world);
    let [oak, pine] = [world.spawn_empty().id(), world.spawn_empty().id()];
    for (shape, material) in [(left, oak), (right, pine), (other, oak), (cube, oak)] {
        world.entity_mut(shape).insert(UsesMaterial(material));
    }
    let mut alike = |thing, alike| {
        select(&mut world, &[thing]);
        say(&mut world, SelectionCommand::SelectAlike(alike));
        world.resource::<Selection>().entities().to_vec()
    };
    assert_eq!(alike(left, Alike::Material), [left, other, cube]);
    assert_eq!(alike(right, Alike::Material), [right]);
    assert_eq!(alike(left, Alike::Type), [left, right, other]);
    assert_eq!(alike(cube, Alike::Type), [cube]);
    select(&mut world, &[oak]);
    let alike = SelectionCommand::SelectAlike(Alike::Type);
    assert!(apply(&mut world, alike).is_err(), "it is neither shape nor light");
}
