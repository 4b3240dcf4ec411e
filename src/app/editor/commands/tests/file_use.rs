//! Tests of files that are dropped into the picture or used for the selection.

use super::*;
use crate::accel::Primitive;
use crate::app::editor::camera::picking::tests::scene_of;
use crate::app::editor::command::asset_kind::FileUse;
use crate::app::editor::command::{HistoryCommand, OutlineEdit, SceneEdit, SelectionCommand};
use crate::app::editor::picture::material_ball;
use crate::render::camera::Camera;
use crate::render::view::View;
use crate::scene::Texture;

/// A floor with its top at y = 0 below the sky, seen from above and before. It has a material if `material` is given.
fn with_floor(material: Option<Material>) -> (World, Entity) {
    let mut world = bare_world();
    let level = Affine3A::from_rotation_x(-std::f32::consts::FRAC_PI_2) * Affine3A::from_scale(Vec3::splat(4.0));
    let floor = world.spawn((Shape::default(), ToWorld(level))).id();
    if let Some(material) = material {
        let material = world.spawn(material).id();
        world.entity_mut(floor).insert(UsesMaterial(material));
    }
    let (eye, at) = (Vec3::new(0.0, 2.0, 6.0), Vec3::ZERO);
    let pose = Affine3A::look_at_rh(eye, at, Vec3::Y).inverse() * Affine3A::from_rotation_y(std::f32::consts::PI);
    world.insert_resource(PackedScene {
        view: Some(View {
            camera: Camera::new(pose, 40.0, 1.0, 0.1, 1e3, None),
            ..material_ball::view(16)
        }),
        scene: Some(scene_of([(Primitive::Rectangle, level)].into_iter())),
        entity_of_instance: vec![floor].into(),
        ..PackedScene::default()
    });
    (world, floor)
}

fn written(folder: &tempfile::TempDir, name: &str, text: &str) -> PathBuf {
    let path = folder.path().join(name);
    std::fs::write(&path, text).expect("it can be written");
    path.canonicalize().expect("just written")
}

fn use_file(world: &mut World, path: &Path, at: Option<Vec2>) -> Result<(), CommandError> {
    let bounds = Some([Vec3::new(1.0, -1.0, 1.0), Vec3::new(3.0, 1.0, 3.0)]);
    let path = path.to_owned();
    apply_now(world, SceneEdit::UseFile(Box::new(FileUse { path, at, bounds })))
}

fn reflectance(world: &World, shape: Entity) -> Option<PathBuf> {
    let material = world.get::<UsesMaterial>(shape)?.0;
    match world.get::<Material>(material)? {
        Material::Diffuse {
            reflectance: Parameter::Texture(Texture::Bitmap(bitmap)),
        } => Some(bitmap.path.clone()),
        _ => None,
    }
}

const MIDDLE: Option<Vec2> = Some(Vec2::splat(0.5));
const SKY: Option<Vec2> = Some(Vec2::new(0.5, 0.02));

#[test]
fn a_picture_covers_the_shape_or_is_all_around() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let picture = written(&folder, "wood.png", "");
    for material in [None, Some(Material::default())] {
        let (mut world, floor) = with_floor(material);
        use_file(&mut world, &picture, MIDDLE).expect("there is a floor");
        assert_eq!(reflectance(&world, floor), Some(picture.clone()));
        say(&mut world, HistoryCommand::Undo);
        assert_eq!(reflectance(&world, floor), None);
    }
    let (mut world, floor) = with_floor(None);
    use_file(&mut world, &picture, SKY).expect("beside the floor is nothing");
    assert_eq!(reflectance(&world, floor), None);
    let mut skies = world.query::<&Emitter>();
    assert!(skies.single(&world).expect("one sky").is_environment());
    // The selection takes it where no place is given.
    say(&mut world, SelectionCommand::Select(vec![floor], Extend::Replace));
    use_file(&mut world, &picture, None).expect("the floor is selected");
    assert_eq!(reflectance(&world, floor), Some(picture.clone()));
    say(&mut world, OutlineEdit::Lock(vec![floor], true));
    assert!(use_file(&mut world, &picture, MIDDLE).is_err());
    let gone = folder.path().join("gone.png");
    assert!(use_file(&mut world, &gone, SKY).is_err());
}

#[test]
fn other_shapes_of_the_same_material_stay_as_they_are() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let picture = written(&folder, "wood.png", "");
    let (mut world, floor) = with_floor(Some(Material::default()));
    let shared = world.get::<UsesMaterial>(floor).expect("it has one").0;
    let wall = world.spawn((Shape::default(), UsesMaterial(shared))).id();
    use_file(&mut world, &picture, MIDDLE).expect("there is a floor");
    assert_eq!(
        (reflectance(&world, floor), reflectance(&world, wall)),
        (Some(picture.clone()), None)
    );
    assert_eq!(world.get::<UsesMaterial>(wall).map(|uses| uses.0), Some(shared));
    say(&mut world, HistoryCommand::Undo);
    // Both are selected: they still share it afterwards.
    say(&mut world, SelectionCommand::Select(vec![floor, wall], Extend::Replace));
    use_file(&mut world, &picture, None).expect("both have a colour");
    assert_eq!(
        (reflectance(&world, floor), reflectance(&world, wall)),
        (Some(picture.clone()), Some(picture))
    );
    assert_eq!(world.get::<UsesMaterial>(floor), world.get::<UsesMaterial>(wall));
}

#[test]
fn a_material_without_a_colour_is_left_alone() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let picture = written(&folder, "wood.png", "");
    let glass = Material::of_plugin("dielectric").expect("a plugin");
    let (mut world, floor) = with_floor(Some(glass.clone()));
    assert!(use_file(&mut world, &picture, MIDDLE).is_err());
    let material = world.get::<UsesMaterial>(floor).expect("it has one").0;
    assert_eq!(world.get::<Material>(material), Some(&glass));
}

#[test]
fn a_mesh_stands_where_it_was_dropped() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let mesh = written(&folder, "box.obj", "");
    let (mut world, _) = with_floor(None);
    use_file(&mut world, &mesh, MIDDLE).expect("a mesh");
    let made = world.resource::<Selection>().active().expect("it is selected");
    let place = Vec3::from(world.get::<ToWorld>(made).expect("a pose").0.translation);
    // Its foot, at (2, -1, 2) of its own space, is in the middle of the floor.
    assert!(place.distance(Vec3::new(-2.0, 1.0, -2.0)) < 0.05, "{place}");
    // One undo reverts all of it.
    say(&mut world, HistoryCommand::Undo);
    assert!(!ObjectState::is_in_scene(&world, made));
    // Without a place it is where its file says.
    use_file(&mut world, &mesh, None).expect("a mesh");
    let made = world.resource::<Selection>().active().expect("it is selected");
    assert_eq!(
        world
            .get::<ToWorld>(made)
            .map_or(Vec3::ZERO, |pose| pose.0.translation.into()),
        Vec3::ZERO
    );
}

#[test]
fn a_mesh_of_which_nothing_is_known_stands_on_its_lower_side_as_well() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let mesh = written(&folder, "a.obj", "v -1 -1 0\nv 1 -1 0\nv 0 3 0\nf 1 2 3\n");
    let (mut world, _) = with_floor(None);
    let file = FileUse {
        path: mesh,
        at: MIDDLE,
        bounds: None,
    };
    apply_now(&mut world, SceneEdit::UseFile(Box::new(file))).expect("a mesh");
    let made = world.resource::<Selection>().active().expect("it is selected");
    let place = Vec3::from(world.get::<ToWorld>(made).expect("a pose").0.translation);
    assert!(place.distance(Vec3::Y) < 0.05, "{place}");
}

#[test]
fn a_file_of_materials_is_for_the_shape_and_other_scenes_are_added() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let text = "<scene version='3.0.0'><bsdf type='plastic' id='Own/red'/><bsdf type='diffuse' id='b'/></scene>";
    let material = written(&folder, "red.xml", text);
    let (mut world, floor) = with_floor(None);
    assert!(use_file(&mut world, &material, SKY).is_err());
    use_file(&mut world, &material, MIDDLE).expect("there is a floor");
    let given = world.get::<UsesMaterial>(floor).expect("it has one").0;
    assert_eq!(world.get::<Material>(given).map(Material::plugin), Some("plastic"));
    assert_eq!(world.get::<SceneId>(given), Some(&SceneId("red".to_owned())));

    let scene = written(
        &folder,
        "ball.xml",
        "<scene version='3.0.0'><shape type='sphere'/></scene>",
    );
    use_file(&mut world, &scene, MIDDLE).expect("a scene");
    let mut shapes = world.query::<&Shape>();
    assert_eq!(shapes.iter(&world).count(), 2);
    let broken = written(&folder, "broken.xml", "<scene");
    assert!(use_file(&mut world, &broken, MIDDLE).is_err());
}
