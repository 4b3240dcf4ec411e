//! Tests of groups: folders with a transform of their own.

use bevy::math::Affine3A;

use super::*;

fn ball(world: &mut World, name: &str, x: f32) -> Entity {
    let addition = Addition {
        name: Some(name.into()),
        at: Some(Vec3::X * x),
        size: Some(0.5),
        ..AdditionKind::Sphere.into()
    };
    say(world, Command::Add(addition));
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
    say(world, Command::Select(things.to_vec(), Extend::Replace));
}

/// Two balls in a group, and the group.
fn pair(world: &mut World) -> [Entity; 3] {
    let balls = [ball(world, "left", -1.0), ball(world, "right", 3.0)];
    select(world, &balls);
    say(world, Command::Group);
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
    // Its place is the middle of the bounds of what is in it.
    assert_eq!(Vec3::from(pose(&world, group).translation), Vec3::new(1.0, 0.5, 0.0));
    let turned =
        Affine3A::from_rotation_translation(bevy::math::Quat::from_rotation_y(std::f32::consts::FRAC_PI_2), Vec3::Y);
    select(&mut world, &[group]);
    say(
        &mut world,
        Command::OnSelection(Box::new(Command::Transform(vec![(group, turned)]))),
    );
    let place = |world: &World, entity| Vec3::from(pose(world, entity).translation);
    assert!(
        place(&world, left).abs_diff_eq(Vec3::new(0.0, 1.0, 2.0), 1e-5),
        "{}",
        place(&world, left)
    );
    assert!(place(&world, right).abs_diff_eq(Vec3::new(0.0, 1.0, -2.0), 1e-5));
    // What is moved as well is where it was put, and what is locked stays.
    say(&mut world, Command::Undo);
    say(&mut world, Command::Lock(vec![right], true));
    let [to, own] = [5.0, 7.0].map(|x| Affine3A::from_translation(Vec3::X * x));
    say(&mut world, Command::Transform(vec![(left, own), (group, to)]));
    assert_eq!((place(&world, left).x, place(&world, right).x), (7.0, 3.0));
}

#[test]
fn groups_are_in_groups_and_come_out_again() {
    let mut world = bare_world();
    let [left, right, inner] = pair(&mut world);
    say(&mut world, Command::Rename(inner, "pair".into()));
    let other = ball(&mut world, "other", 9.0);
    select(&mut world, &[other, left, right, inner]);
    say(&mut world, Command::Group);
    let outer = active(&world);
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
    say(&mut world, Command::Transform(vec![(outer, moved)]));
    assert_eq!(pose(&world, left).translation.x, before + 1.0);
    // From a ball to its group, and on to the group around that.
    select(&mut world, &[left]);
    say(&mut world, Command::SelectGroup);
    assert_eq!(
        (active(&world), world.resource::<Selection>().entities().len()),
        (inner, 3)
    );
    say(&mut world, Command::SelectGroup);
    assert_eq!(
        (active(&world), world.resource::<Selection>().entities().len()),
        (outer, 5)
    );
    assert!(apply(&mut world, Command::SelectGroup).is_err());
    assert!(
        apply(
            &mut world,
            Command::PutInto {
                things: vec![outer],
                folder: Some("group/pair".into())
            }
        )
        .is_err()
    );
    say(&mut world, Command::Ungroup);
    assert_eq!(names(&world)[..4], ["pair/left", "pair/right", "pair/", "other"]);
    assert!(!ObjectState::is_in_scene(&world, outer));
    say(&mut world, Command::Undo);
    assert_eq!(names(&world), nested);
}

#[test]
fn a_copy_of_a_group_is_a_group() {
    let mut world = bare_world();
    pair(&mut world);
    say(&mut world, Command::Duplicate);
    let copies = world.resource::<Selection>().entities().to_vec();
    let names: Vec<String> = copies.iter().map(|it| name(&world, *it)).collect();
    assert_eq!(names, ["group-2/left", "group-2/right", "group-2/"]);
}

#[test]
fn a_group_has_no_surface_and_is_in_the_file() {
    let mut world = bare_world();
    let [.., group] = pair(&mut world);
    assert!(apply(&mut world, Command::GiveMaterial { shape: group }).is_err());
    assert!(apply(&mut world, Command::SetAreaLight(group, Some(AreaLight::default()))).is_err());
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
