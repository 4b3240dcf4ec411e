//! New texture coordinates for shapes, in a world without a window.

use bevy::math::{Affine2, Vec2};

use super::*;
use crate::app::editor::command::texture_placing::texture_groups;
use crate::app::editor::command::uv_projection::{ProjectedFrom, Projection};
use crate::app::editor::command::{FileCommand, HistoryCommand, TextureEdit};
use crate::geometry::ply::load_ply;
use crate::scene::{DocumentOrder, MeshFile, SceneStatus, Solid, Texture, spawn};

fn board(world: &mut World) -> Entity {
    let board = Texture::Checkerboard {
        color0: Box::new(Rgb::ONE.into()),
        color1: Box::new(Rgb::ZERO.into()),
        to_uv: Box::new(Affine2::from_scale(Vec2::splat(3.0))),
    };
    let material = Material::Diffuse {
        reflectance: Parameter::Texture(board),
    };
    world
        .spawn((
            material,
            DocumentOrder(1),
            Name::new("board"),
            SceneId("board".to_owned()),
        ))
        .id()
}

fn shape(world: &mut World, kind: ShapeKind, pose: Affine3A, material: Entity) -> Entity {
    let shape = Shape {
        kind,
        ..Shape::default()
    };
    world
        .spawn((
            shape,
            ToWorld(pose),
            DocumentOrder(2),
            Name::new("thing"),
            UsesMaterial(material),
        ))
        .id()
}

fn project(world: &mut World, shapes: &[Entity], from: ProjectedFrom, tile: f32) {
    let projection = Projection { from, tile };
    let shapes = shapes.to_vec();
    apply(world, TextureEdit::ProjectTextures { shapes, projection }).expect("they have surfaces");
}

/// How the texture of a shape lies.
fn to_uv(world: &World, shape: Entity) -> Affine2 {
    let UsesMaterial(material) = world.get(shape).expect("it has one");
    texture_groups(world.get::<Material>(*material))[0].to_uv
}

fn wall(length: f32) -> ShapeKind {
    ShapeKind::Solid(Solid::Wall {
        length,
        height: 2.5,
        thickness: 0.2,
        openings: Vec::new(),
    })
}

#[test]
fn walls_keep_their_numbers_and_get_tiles_of_one_size() {
    let mut world = bare_world();
    let board = board(&mut world);
    let walls = [(5.0, 1.0), (2.0, 1.0)].map(|(length, scale)| {
        let pose = Affine3A::from_scale(Vec3::splat(scale));
        shape(&mut world, wall(length), pose, board)
    });
    project(&mut world, &walls, ProjectedFrom::Box, 0.5);
    // A wall's own coordinates are lengths.
    for shape in walls {
        assert_eq!(to_uv(&world, shape), Affine2::from_scale(Vec2::splat(2.0)));
        assert!(matches!(
            world.get::<Shape>(shape).map(|shape| &shape.kind),
            Some(ShapeKind::Solid(_))
        ));
    }
    say(&mut world, HistoryCommand::Undo);
    assert_eq!(to_uv(&world, walls[0]), Affine2::from_scale(Vec2::splat(3.0)));
    // A wall beside others gets a material of its own.
    project(&mut world, &walls[..1], ProjectedFrom::Box, 0.25);
    assert_eq!(to_uv(&world, walls[0]), Affine2::from_scale(Vec2::splat(4.0)));
    assert_eq!(to_uv(&world, walls[1]), Affine2::from_scale(Vec2::splat(3.0)));
}

#[test]
fn a_box_becomes_a_wall_that_has_the_same_surface() {
    let mut world = bare_world();
    let board = board(&mut world);
    let pose = Affine3A::from_scale(Vec3::new(2.5, 1.25, 0.1));
    let cube = shape(&mut world, ShapeKind::Cube, pose, board);
    project(&mut world, &[cube], ProjectedFrom::Box, 1.0);
    let Some(ShapeKind::Solid(Solid::Wall {
        length,
        height,
        thickness,
        ..
    })) = world.get::<Shape>(cube).map(|shape| shape.kind.clone())
    else {
        panic!("it is no wall");
    };
    let size = Vec3::new(length, height, thickness);
    assert!(size.abs_diff_eq(Vec3::new(5.0, 2.5, 0.2), 1e-4), "{size}");
    assert!(to_uv(&world, cube).abs_diff_eq(Affine2::IDENTITY, 1e-4));
}

#[test]
fn a_rectangle_has_as_many_tiles_as_it_is_long() {
    let mut world = bare_world();
    let board = board(&mut world);
    let pose = Affine3A::from_scale(Vec3::new(2.5, 1.5, 1.0));
    let rectangle = shape(&mut world, ShapeKind::Rectangle, pose, board);
    for from in [ProjectedFrom::Box, ProjectedFrom::Face] {
        project(&mut world, &[rectangle], from, 0.5);
        let [along, up] = [Vec2::X, Vec2::Y].map(|edge| to_uv(&world, rectangle).transform_vector2(edge));
        // The upper edge of the picture is up.
        assert!(
            along.abs_diff_eq(Vec2::X * 10.0, 1e-4) && up.abs_diff_eq(Vec2::Y * -6.0, 1e-4),
            "{along} {up}"
        );
    }
}

#[test]
fn other_shapes_become_meshes_in_files() {
    let mut world = bare_world();
    let board = board(&mut world);
    let sphere = ShapeKind::Sphere {
        center: Vec3::ZERO,
        radius: 2.0,
    };
    let ball = shape(&mut world, sphere.clone(), Affine3A::IDENTITY, board);
    project(&mut world, &[ball], ProjectedFrom::Box, 0.5);
    // The material stays, because the coordinates allow for it.
    assert_eq!(to_uv(&world, ball), Affine2::from_scale(Vec2::splat(3.0)));
    let Some(ShapeKind::Mesh(MeshFile {
        path, flip_tex_coords, ..
    })) = world.get::<Shape>(ball).map(|shape| shape.kind.clone())
    else {
        panic!("it is no mesh");
    };
    let mesh = load_ply(&crate::files::read(&path, crate::files::LARGEST_DATA).expect("it was written"))
        .expect("a good file")
        .mesh;
    let tile = |corner: u32| {
        let uv = mesh.uvs[corner as usize];
        3.0 * if flip_tex_coords {
            Vec2::new(uv.x, 1.0 - uv.y)
        } else {
            uv
        }
    };
    for triangle in &mesh.triangles {
        let [a, b, c] = triangle.map(|corner| (mesh.positions[corner as usize], tile(corner)));
        let normal = (b.0 - a.0).cross(c.0 - a.0).normalize();
        let axis = normal.abs().max_position();
        for (from, to) in [(a, b), (b, c), (c, a)] {
            // Seen along the axis, tiles have their size.
            let mut edge = to.0 - from.0;
            edge[axis] = 0.0;
            let tiles = (to.1 - from.1).length();
            assert!((edge.length() - 0.5 * tiles).abs() < 1e-3, "{edge} is {tiles} tiles");
        }
    }
    say(&mut world, HistoryCommand::Undo);
    assert_eq!(world.get::<Shape>(ball).map(|shape| &shape.kind), Some(&sphere));
}

#[test]
fn what_has_no_surface_or_no_size_is_refused() {
    let mut world = bare_world();
    let board = board(&mut world);
    let refused = |world: &mut World, shapes: Vec<Entity>, tile| {
        let from = ProjectedFrom::Box;
        let projection = Projection { from, tile };
        apply(world, TextureEdit::ProjectTextures { shapes, projection }).is_err()
    };
    assert!(refused(&mut world, vec![board], 1.0));
    let cube = shape(&mut world, ShapeKind::Cube, Affine3A::IDENTITY, board);
    for tile in [0.0, -1.0, f32::NAN, f32::INFINITY] {
        assert!(refused(&mut world, vec![cube], tile), "{tile}");
    }
}

/// Meshes that were made stay in a cache until the scene is saved, and go with it wherever it is saved.
#[test]
fn a_scene_that_is_saved_elsewhere_takes_its_new_meshes_along() {
    let folder = tempfile::tempdir().expect("a folder");
    let [old, new] = ["old/scene.xml", "new/deeper/scene.xml"].map(|name| folder.path().join(name));
    for path in [&old, &new] {
        std::fs::create_dir_all(path.parent().expect("a folder")).expect("it can be made");
    }
    std::fs::write(
        &old,
        "<scene version='3.0.0'><sensor type='perspective'/><shape type='sphere' id='a'/></scene>",
    )
    .expect("a file");
    let mut world = bare_world();
    world.init_resource::<SceneStatus>();
    let mut document = crate::document::load(&old, &[]).expect("a scene");
    spawn::spawn_fresh(
        &mut world,
        &std::sync::Arc::new(crate::scene::read::read(&mut document)),
    );
    world.resource_mut::<SceneStatus>().path = Some(old);
    let mut shapes = world.query_filtered::<Entity, With<Shape>>();
    let ball = shapes.single(&world).expect("a ball");
    project(&mut world, &[ball], ProjectedFrom::Box, 0.5);
    apply(&mut world, FileCommand::SaveScene(new.clone())).expect("it can be saved");
    let text = crate::files::read_text(&new, crate::files::LARGEST_NOTE).expect("a file");
    let name = text
        .split("scene-files/")
        .nth(1)
        .and_then(|rest| rest.split('"').next());
    let part = new
        .with_file_name("scene-files")
        .join(name.expect("the mesh is beside the scene"));
    assert!(part.is_file(), "{text}");
}
