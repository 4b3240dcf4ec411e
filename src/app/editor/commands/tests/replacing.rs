//! Tests of shapes that get the geometry of others.

use bevy::math::Affine3A;

use super::*;
use crate::app::editor::command::HistoryCommand;
use crate::app::editor::command::scene::Replacement;
use crate::app::editor::commands::things::pose_of;

/// A ball with a centre of its own and a cube that is turned, both with materials, and both selected.
fn two(world: &mut World) -> [Entity; 2] {
    let turned = Affine3A::from_rotation_translation(bevy::math::Quat::from_rotation_y(0.4), Vec3::new(1.0, 2.0, 3.0));
    let ball = ShapeKind::Sphere {
        center: Vec3::X,
        radius: 0.5,
    };
    let made = [(ball, Affine3A::IDENTITY), (ShapeKind::Cube, turned)].map(|(kind, pose)| {
        let material = world.spawn(Material::default()).id();
        let shape = Shape {
            kind,
            lightmap_scale: 3.0,
            ..Shape::default()
        };
        world
            .spawn((shape, ToWorld(pose), Name::new("thing"), UsesMaterial(material)))
            .id()
    });
    say(world, SelectionCommand::Select(made.to_vec(), Extend::Replace));
    made
}

/// The pose, the material, the name and the lightmap of a shape.
fn rest(world: &World, shape: Entity) -> (Option<Affine3A>, Entity, String, f32) {
    let material = world.get::<UsesMaterial>(shape).expect("a material").0;
    let name = world.get::<Name>(shape).expect("a name").to_string();
    let scale = world.get::<Shape>(shape).expect("a shape").lightmap_scale;
    (pose_of(world, shape), material, name, scale)
}

#[test]
fn shapes_keep_everything_but_their_geometry() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("tree.ply");
    std::fs::write(&path, "ply\n").expect("a file");
    for by_file in [true, false] {
        let mut world = bare_world();
        let source = world.spawn(Shape::default()).id();
        let shapes = two(&mut world);
        let whole = |world: &World, shape| (world.get::<Shape>(shape).cloned(), world.get::<ToWorld>(shape).copied());
        let before = shapes.map(|shape| (rest(&world, shape), whole(&world, shape)));
        let by = match by_file {
            true => Replacement::File(path.clone()),
            false => Replacement::Shape(source),
        };
        say(&mut world, SceneEdit::Replace(by));
        for (shape, (before, _)) in shapes.iter().zip(&before) {
            let kind = &world.get::<Shape>(*shape).expect("a shape").kind;
            let is_it = match kind {
                ShapeKind::Mesh(mesh) => by_file && mesh.path.ends_with("tree.ply"),
                other => !by_file && *other == ShapeKind::Rectangle,
            };
            assert!(is_it, "{kind:?}");
            assert_eq!(rest(&world, *shape), *before);
        }
        say(&mut world, HistoryCommand::Undo);
        for (shape, (_, before)) in shapes.iter().zip(before) {
            assert_eq!(whole(&world, *shape), before);
        }
    }
}

#[test]
fn what_is_no_geometry_is_refused() {
    let folder = tempfile::tempdir().expect("a folder");
    let two_balls = "<scene version='3.0.0'><shape type='sphere'/><shape type='cube'/></scene>";
    let file = |name: &str, text: &str| {
        let path = folder.path().join(name);
        std::fs::write(&path, text).expect("a file");
        Replacement::File(path)
    };
    let mut world = bare_world();
    let shapes = two(&mut world);
    let frame = world
        .spawn(Shape {
            kind: ShapeKind::Frame,
            ..Shape::default()
        })
        .id();
    let wrong = [
        file("a.txt", "no mesh"),
        file("b.xml", two_balls),
        Replacement::File(folder.path().join("absent.obj")),
        Replacement::Shape(frame),
    ];
    for by in wrong {
        assert!(apply_now(&mut world, SceneEdit::Replace(by)).is_err());
        assert_eq!(world.get::<Shape>(shapes[1]).expect("a shape").kind, ShapeKind::Cube);
    }
    // The source alone has nothing to replace.
    say(&mut world, SelectionCommand::Select(vec![shapes[1]], Extend::Replace));
    assert!(apply_now(&mut world, SceneEdit::Replace(Replacement::Shape(shapes[1]))).is_err());
}

#[test]
fn the_shape_of_a_scene_keeps_its_own_transform() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("tall.xml");
    let text = "<scene version='3.0.0'><shape type='cylinder'><transform name='to_world'><scale x='2' y='3' z='4'/>\
        </transform></shape></scene>";
    std::fs::write(&path, text).expect("a file");
    let mut world = bare_world();
    let [_, cube] = two(&mut world);
    let before = pose_of(&world, cube).expect("a pose");
    say(&mut world, SceneEdit::Replace(Replacement::File(path)));
    let shape = world.get::<Shape>(cube).expect("a shape");
    assert!(matches!(shape.kind, ShapeKind::Cylinder { .. }), "{shape:?}");
    let expected = before * Affine3A::from_scale(Vec3::new(2.0, 3.0, 4.0));
    let now = pose_of(&world, cube).expect("a pose");
    assert!(now.abs_diff_eq(expected, 1e-5), "{now:?} {expected:?}");
}
