//! Media in the editor, without a window: fog, what shapes are filled with, and what saving keeps of it.

use std::path::Path;
use std::sync::Arc;

use bevy::math::{Affine3A, UVec3, Vec3};
use bevy::prelude::*;
use sunroom::accel::{Instance, Primitive, SplitMethod, Tlas};
use sunroom::app::editor::automation::monkey::Snapshot;
use sunroom::app::editor::automation::script::parse::{self, Step};
use sunroom::app::editor::command::media::MediumSide;
use sunroom::app::editor::command::selection::Selection;
use sunroom::app::editor::command::{Command, FileCommand, MediumEdit, ValueEdit};
use sunroom::app::editor::commands::apply;
use sunroom::app::editor::commands::bare_world::bare_world;
use sunroom::app::editor::session::history::History;
use sunroom::app::editor::session::toasts::Toasts;
use sunroom::color::Rgb;
use sunroom::engine::PackedScene;
use sunroom::material::MaterialId;
use sunroom::math::Aabb;
use sunroom::medium::{MediumId, MediumInterface, VolumeGrid, Voxels, write_vol};
use sunroom::render::scene::{RenderScene, SurfaceSlot, SurfaceTable};
use sunroom::scene::{Material, *};

fn say(world: &mut World, line: &str) -> Result<(), String> {
    match parse::line(world, line) {
        Ok(Some(Step::Do(command))) => apply(world, command).map_err(|error| format!("{error:?}")),
        Err(error) => Err(error.to_string()),
        other => panic!("{line}: {other:?}"),
    }
}

fn said(world: &mut World, lines: &[&str]) {
    for line in lines {
        if let Err(error) = say(world, line) {
            panic!("{line}: {error}");
        }
    }
}

fn named(world: &mut World, name: &str) -> Entity {
    let mut things = world.query::<(Entity, &Name)>();
    let mut found = things.iter(world).filter(|(_, its)| its.as_str() == name);
    found.next().unwrap_or_else(|| panic!("no {name}")).0
}

fn medium<'w>(world: &'w mut World, name: &str) -> &'w Medium {
    let entity = named(world, name);
    world.get::<Medium>(entity).expect("a medium")
}

fn steps(world: &World) -> usize {
    world.resource::<History>().len().0
}

fn plugin(world: &World) -> PathPlugin {
    let settings = world.get_resource::<IntegratorSettings>();
    settings.map_or(PathPlugin::Path, |settings| settings.plugin)
}

fn tells(world: &World, what: &str) -> bool {
    world.resource::<Toasts>().texts().any(|text| text.contains(what))
}

#[test]
fn fog_is_around_everything_and_one_step() {
    let mut world = bare_world();
    said(
        &mut world,
        &["add camera name=eye at=0,1,4", "add cube name=milk at=0,0,0 size=0.5"],
    );
    said(&mut world, &["fill smoke milk", "undo", "fill smoke milk"]);
    let before = (Snapshot::of(&mut world), steps(&world));
    said(&mut world, &["add fog"]);
    assert_eq!(steps(&world), before.1 + 1);
    let (border, fog) = (named(&mut world, "fog"), named(&mut world, "fog-medium"));
    assert_eq!(world.get::<InteriorMedium>(border), Some(&InteriorMedium(fog)));
    assert_eq!(world.resource::<Selection>().active(), Some(border));
    let material = world.get::<UsesMaterial>(border).expect("a material").0;
    assert_eq!(world.get(material), Some(&Material::Null));
    // A path has to know what it begins in, and what is behind the border of the smoke.
    let (eye, milk) = (named(&mut world, "eye"), named(&mut world, "milk"));
    assert_eq!(world.get::<InMedium>(eye), Some(&InMedium(fog)));
    assert_eq!(world.get::<ExteriorMedium>(milk), Some(&ExteriorMedium(fog)));
    let local = world.get::<ToWorld>(border).expect("a place").0.inverse();
    for place in [Vec3::new(0.0, 1.0, 4.0), Vec3::new(0.5, 0.0, 0.5)] {
        assert!(local.transform_point3(place).abs().max_element() < 1.0);
    }
    said(&mut world, &["undo"]);
    assert_eq!(Snapshot::of(&mut world).difference(&before.0), None);
}

#[test]
fn the_integrator_changes_with_the_first_medium_and_back_with_undo() {
    for line in [
        "add fog",
        "add fog-box at=0,0,0",
        "fill fog ball",
        "medium-of ball",
        "medium-of eye around",
    ] {
        let mut world = bare_world();
        said(
            &mut world,
            &["add sphere name=ball at=0,0,0", "add camera name=eye at=0,0,5"],
        );
        assert_eq!(plugin(&world), PathPlugin::Path);
        said(&mut world, &[line]);
        assert_eq!(plugin(&world), PathPlugin::VolPath, "{line}");
        assert!(tells(&world, "`volpath`"), "{line}");
        said(&mut world, &["undo"]);
        assert_eq!(plugin(&world), PathPlugin::Path, "{line}");
        said(&mut world, &["redo"]);
        assert_eq!(plugin(&world), PathPlugin::VolPath, "{line}");
    }
}

#[test]
fn a_surface_that_hides_its_filling_is_taken_away_and_glass_is_not() {
    let mut world = bare_world();
    said(
        &mut world,
        &[
            "add sphere name=ball at=0,0,0",
            "add sphere name=other at=3,0,0",
            "add sphere name=glass at=6,0,0",
            "material-of ball",
            "assign material other",
            "material-of glass",
            "make material-2 roughdielectric",
            "fill fog ball glass",
        ],
    );
    let [ball, other, glass] = ["ball", "other", "glass"].map(|name| named(&mut world, name));
    let material = |world: &World, shape: Entity| {
        let used = world.get::<UsesMaterial>(shape).expect("a material").0;
        world.get::<Material>(used).expect("a material").plugin()
    };
    assert_eq!(
        [ball, other, glass].map(|shape| material(&world, shape)),
        ["null", "diffuse", "roughdielectric"]
    );
    assert!(tells(&world, "`ball` has the material `null` now"));
    // Both have the same fog, and another filling makes another medium.
    let inside = |world: &World, shape: Entity| world.get::<InteriorMedium>(shape).map(|medium| medium.0);
    assert_eq!(inside(&world, ball), inside(&world, glass));
    said(&mut world, &["fill smoke other", "fill fog other"]);
    let [fog, smoke] = ["fog", "smoke"].map(|name| named(&mut world, name));
    assert_eq!(
        inside(&world, other),
        Some(fog),
        "the medium of this name, not a new one"
    );
    assert_ne!(fog, smoke);
}

#[test]
fn what_has_no_inside_is_not_filled() {
    let mut world = bare_world();
    said(
        &mut world,
        &["add rectangle name=floor at=0,0,0", "add camera name=eye at=0,0,5"],
    );
    let before = Snapshot::of(&mut world);
    for (line, reason) in [
        ("fill fog floor", "no inside"),
        ("fill fog eye", "no shape"),
        ("medium-of eye", "cannot be done"),
        ("medium-of floor around", "Only cameras and lights"),
        ("medium floor interior floor", "cannot be done"),
        ("medium none inside floor", "no place of a medium called"),
    ] {
        let error = say(&mut world, line).expect_err(line);
        assert!(error.contains(reason), "{line}: {error}");
    }
    assert_eq!(Snapshot::of(&mut world).difference(&before), None);
}

#[test]
fn parameters_are_set_by_their_names_in_the_file_and_in_lengths() {
    let mut world = bare_world();
    said(&mut world, &["add cube name=box at=0,0,0", "fill fog box", "unit-cm"]);
    said(
        &mut world,
        &[
            "set fog albedo 0.1,0.2,0.3",
            "set fog scale 2",
            "set fog mean_free_path 2m",
            "set fog phase hg",
            "set fog g -0.4",
            "set fog emission 1,2,3",
        ],
    );
    let fog = medium(&mut world, "fog").clone();
    let (sigma_t, albedo) = fog.coefficients.sigma_t_and_albedo();
    assert_eq!(albedo, Rgb::new(0.1, 0.2, 0.3).into());
    // 200 cm, of which the density takes half.
    let sigma_t = sigma_t.constant().expect("the same everywhere");
    assert!(sigma_t.abs_diff_eq(Rgb::splat(1.0 / 400.0), 1e-7), "{sigma_t}");
    assert_eq!(fog.phase, PhaseFunction::HenyeyGreenstein { g: -0.4 });
    assert_eq!(fog.emission, Rgb::new(1.0, 2.0, 3.0).into());
    // By the name of the shape that it is in, too, and one length for each colour.
    said(&mut world, &["set box mean_free_path 10cm,20cm,50"]);
    let sigma_t = medium(&mut world, "fog")
        .coefficients
        .uniform_extinction()
        .expect("uniform");
    assert!(sigma_t.abs_diff_eq(Rgb::new(0.05, 0.025, 0.01), 1e-7), "{sigma_t}");
    for (line, reason) in [
        ("set fog mean_free_path 0", "above 0"),
        ("set fog phase sggx", "expected isotropic, hg, rayleigh, tabphase"),
        ("set fog g 2", "found 2"),
        ("set fog albedo 2", "within 0 to 1"),
        ("set fog sigma_z 1", "sigma_t"),
    ] {
        let error = say(&mut world, line).expect_err(line);
        assert!(error.contains(reason), "{line}: {error}");
    }
}

fn write_smoke(path: &Path) {
    let size = UVec3::new(2, 1, 4);
    let grid = VolumeGrid::new(size, 1, Voxels::U8(vec![255; 8])).expect("eight voxels");
    let bounds = Aabb {
        min: Vec3::ZERO,
        max: Vec3::ONE,
    };
    std::fs::write(path, write_vol(&grid, &bounds)).expect("a file");
}

fn grid_place(world: &mut World, name: &str) -> Affine3A {
    let mut place = None;
    medium(world, name).for_each_grid(&mut |grid| place = Some(grid.to_world));
    place.expect("a grid")
}

/// The unit cube of the grid fills the cube.
fn fills(world: &mut World, shape: &str, medium: &str) -> bool {
    let grid = grid_place(world, medium);
    let shape = named(world, shape);
    let pose = world.get::<ToWorld>(shape).expect("a place").0;
    let cube = Affine3A::from_translation(Vec3::NEG_ONE) * Affine3A::from_scale(Vec3::splat(2.0));
    grid.abs_diff_eq(pose * cube, 1e-5)
}

#[test]
fn a_volume_comes_in_a_box_that_it_fills_wherever_that_goes() {
    let folder = tempfile::tempdir().expect("a folder");
    let file = folder.path().join("puff.vol");
    write_smoke(&file);
    let mut world = bare_world();
    said(&mut world, &[&format!("import-file {}", file.display())]);
    assert_eq!(steps(&world), 1);
    let shape = named(&mut world, "puff");
    let axes = world.get::<ToWorld>(shape).expect("a place").0.matrix3;
    let sides = [axes.x_axis, axes.y_axis, axes.z_axis].map(|axis| axis.length());
    assert!((sides[2] / sides[0] - 2.0).abs() < 1e-3 && (sides[2] / sides[1] - 4.0).abs() < 1e-3);
    assert!(fills(&mut world, "puff", "puff-medium"));
    for line in [
        "move puff 1,2,3",
        "rotate puff 0,1,0 30",
        "scale puff 1.7",
        "select puff",
        "nudge-left",
    ] {
        said(&mut world, &[line]);
        assert!(fills(&mut world, "puff", "puff-medium"), "{line}");
    }
    // A copy is full as well, and each goes its own way then.
    said(&mut world, &["select puff", "duplicate", "move puff-2 0,5,0"]);
    for (shape, medium) in [("puff", "puff-medium"), ("puff-2", "puff-medium-2")] {
        assert!(fills(&mut world, shape, medium), "{shape}");
    }
    said(&mut world, &["undo", "undo"]);
    assert!(fills(&mut world, "puff", "puff-medium"));
    let error = say(&mut world, "import-file /nowhere/puff.vol").expect_err("there is none");
    assert!(error.contains("no such file"), "{error}");
    std::fs::write(&file, b"VOL").expect("a file");
    let error = say(&mut world, &format!("import-file {}", file.display())).expect_err("it is broken");
    assert!(error.contains("puff.vol") && error.contains("ends early"), "{error}");
}

#[test]
fn media_that_others_have_stay_where_they_are() {
    let mut world = bare_world();
    let smoke = "<medium type='heterogeneous' id='smoke'><volume type='constvolume' name='sigma_t'>\
                 <float name='value' value='2'/></volume></medium>\
                 <shape type='cube' id='a'><ref name='interior' id='smoke'/></shape>\
                 <shape type='cube' id='b'><ref name='interior' id='smoke'/></shape>";
    said(&mut world, &[&format!("paste {smoke}")]);
    let place = |world: &mut World| {
        let mut place = None;
        let (sigma_t, _) = medium(world, "smoke").coefficients.sigma_t_and_albedo();
        if let VolumeParameter::Box { to_world, .. } = sigma_t {
            place = Some(to_world);
        }
        place.expect("a box")
    };
    said(&mut world, &["move a 1,0,0"]);
    assert_eq!(place(&mut world), Affine3A::IDENTITY);
    said(&mut world, &["undo", "select a b", "nudge-left"]);
    let (a, moved) = (named(&mut world, "a"), place(&mut world));
    let pose = world.get::<ToWorld>(a).expect("a place").0;
    assert!(moved.translation.length() > 0.0 && moved.translation.abs_diff_eq(pose.translation, 1e-5));
}

#[test]
fn media_are_renamed_copied_deleted_and_come_back() {
    let mut world = bare_world();
    said(&mut world, &["add cube name=box at=0,0,0", "fill fog box"]);
    let full = Snapshot::of(&mut world);
    said(
        &mut world,
        &["rename fog haze", "set haze scale 3", "select haze", "duplicate"],
    );
    assert_eq!(medium(&mut world, "haze-2").scale, 3.0);
    said(&mut world, &["medium haze-2 interior box", "select haze-2", "delete"]);
    let shape = named(&mut world, "box");
    assert_eq!(world.get::<InteriorMedium>(shape), None);
    let emptied = Snapshot::of(&mut world);
    said(&mut world, &["go-to 2"]);
    assert_eq!(Snapshot::of(&mut world).difference(&full), None);
    said(&mut world, &["go-to 7"]);
    assert_eq!(Snapshot::of(&mut world).difference(&emptied), None);
}

fn read_scene(path: &Path) -> SceneDescription {
    let mut document = sunroom::document::load(path, &[]).expect("a scene");
    sunroom::scene::read::read(&mut document)
}

#[test]
fn what_is_saved_is_read_again_and_the_rest_of_the_file_stays() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("scene.xml");
    let text = "<scene version='3.0.0'>\n  <!-- a room -->\n  <integrator type='path'/>\n  <sensor type='perspective' id='eye'/>\n  \
                <shape type='cube' id='box'/>\n</scene>\n";
    std::fs::write(&path, text).expect("a file");
    write_smoke(&folder.path().join("puff.vol"));
    let mut world = bare_world();
    spawn::spawn_fresh(&mut world, &Arc::new(read_scene(&path)));
    world.resource_mut::<SceneStatus>().path = Some(path.clone());
    said(
        &mut world,
        &[
            "add fog",
            "fill smoke box",
            "set smoke mean_free_path 2",
            "set smoke emission 1,0.5,0",
            &format!("import-file {}", folder.path().join("puff.vol").display()),
        ],
    );
    let edited = Snapshot::of(&mut world).contents();
    apply(&mut world, FileCommand::Save).expect("saved");
    let saved = std::fs::read_to_string(&path).expect("a file");
    assert!(
        saved.contains("<!-- a room -->") && saved.contains("volpath"),
        "{saved}"
    );
    assert!(
        saved.contains("puff.vol") && !saved.contains(&*folder.path().to_string_lossy()),
        "{saved}"
    );
    let mut again = bare_world();
    spawn::spawn_fresh(&mut again, &Arc::new(read_scene(&path)));
    assert_eq!(Snapshot::of(&mut again).contents(), edited, "{saved}");
}

#[test]
fn a_new_camera_is_in_the_medium_of_the_one_that_is_looked_through() {
    let mut world = bare_world();
    said(&mut world, &["add camera name=eye at=0,0,5", "add fog"]);
    let eye = named(&mut world, "eye");
    world.insert_resource(ActiveSensor(Some(eye)));
    said(&mut world, &["add camera name=second at=0,0,4"]);
    let second = named(&mut world, "second");
    assert!(world.get::<InMedium>(second).is_some());
    assert_eq!(world.get::<InMedium>(second), world.get::<InMedium>(eye));
}

#[test]
fn what_was_in_fog_that_is_deleted_is_in_what_was_around_it() {
    let mut world = bare_world();
    said(
        &mut world,
        &[
            "add camera name=eye at=0,0,5",
            "add sphere name=ball at=0,0,0 size=1",
            "fill smoke ball",
            "add fog",
        ],
    );
    let [eye, ball, medium] = ["eye", "ball", "fog-medium"].map(|name| named(&mut world, name));
    let around = |world: &World| {
        let of_eye = world.get::<InMedium>(eye).map(|medium| medium.0);
        (of_eye, world.get::<ExteriorMedium>(ball).map(|medium| medium.0))
    };
    assert_eq!(around(&world), (Some(medium), Some(medium)));
    let text = Snapshot::of(&mut world).contents();
    said(&mut world, &["select fog", "delete"]);
    assert_eq!(around(&world), (None, None));
    said(&mut world, &["undo"]);
    assert_eq!(Snapshot::of(&mut world).contents(), text);
    let smoke = named(&mut world, "smoke");
    let fog = named(&mut world, "fog");
    let with_smoke = Command::from(MediumEdit::UseMedium {
        things: vec![fog],
        side: MediumSide::Interior,
        medium: Some(smoke),
    });
    apply(&mut world, with_smoke).expect("filled anew");
    assert_eq!(around(&world), (Some(smoke), Some(smoke)));
}

/// A ball of radius 1 around the origin with a medium in it, as the engine packs it.
fn packed_ball(medium: Entity) -> PackedScene {
    let ball = Instance::new(Primitive::Sphere, Affine3A::IDENTITY).expect("a good pose");
    let id = MediumId(0);
    let slot = SurfaceSlot {
        material: MaterialId(0),
        light: None,
        media: MediumInterface {
            interior: Some(id),
            exterior: None,
        },
    };
    PackedScene {
        scene: Some(RenderScene {
            geometry: Arc::new(Tlas::build(vec![ball], SplitMethod::Sah)),
            surfaces: Arc::new(SurfaceTable {
                first_slot: vec![0],
                slots: vec![slot],
            }),
            materials: Arc::default(),
            textures: Arc::default(),
            lights: Arc::default(),
            reach: Default::default(),
            media: Arc::default(),
        }),
        medium_of_entity: Arc::new([(medium, id)].into_iter().collect()),
        ..PackedScene::default()
    }
}

#[test]
fn cameras_and_lights_that_move_through_borders_are_in_other_media() {
    let mut world = bare_world();
    said(
        &mut world,
        &[
            "add sphere name=ball at=0,-1,0 size=1",
            "fill fog ball",
            "add camera name=eye at=0,0,5",
            "add point name=lamp at=5,0,0",
        ],
    );
    let (ball, fog) = (named(&mut world, "ball"), named(&mut world, "fog"));
    let things = ["eye", "lamp"].map(|name| named(&mut world, name));
    for thing in things {
        let pose = ToWorld(Affine3A::from_translation(Vec3::new(0.0, 0.0, 5.0)));
        world.entity_mut(thing).insert(pose);
    }
    world.insert_resource(packed_ball(fog));
    let media = |world: &World| things.map(|thing| world.get::<InMedium>(thing).map(|medium| medium.0));
    said(&mut world, &["move eye 0,0,-5", "move lamp 0,0,-5"]);
    assert_eq!(media(&world), [Some(fog); 2]);
    said(&mut world, &["undo", "undo"]);
    assert_eq!(media(&world), [None; 2]);
    said(&mut world, &["redo", "redo", "move eye 0,0,0.5", "move lamp 0,0,7"]);
    assert_eq!(media(&world), [Some(fog), None]);
    // With the ball goes what is in it.
    let far = |z: f32| Affine3A::from_translation(Vec3::Z * z);
    let both = vec![(ball, far(9.0)), (things[0], far(9.5))];
    apply(&mut world, ValueEdit::Transform(both)).expect("moved");
    assert_eq!(media(&world), [Some(fog), None]);
}

/// The file changes while the window has edits, and the window has not reloaded it. Saving reads the change first, as a
/// reload does.
#[test]
fn an_edit_of_a_medium_and_a_change_in_the_file_come_together() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("scene.xml");
    let text = "<scene version='3.0.0'>\n  <integrator type='volpath'/>\n  <medium type='homogeneous' id='fog'>\n    \
                <float name='sigma_t' value='0.5'/>\n  </medium>\n  \
                <medium type='homogeneous' id='milk'>\n    <float name='albedo' value='0.5'/>\n  </medium>\n  \
                <shape type='cube' id='box'>\n    <ref name='interior' id='fog'/>\n  </shape>\n  \
                <shape type='cube' id='glass'>\n    <ref name='interior' id='milk'/>\n  </shape>\n</scene>\n";
    std::fs::write(&path, text).expect("a file");
    let mut world = bare_world();
    spawn::spawn_fresh(&mut world, &Arc::new(read_scene(&path)));
    world.resource_mut::<SceneStatus>().path = Some(path.clone());
    said(&mut world, &["set fog scale 3", "medium fog exterior glass"]);
    std::fs::write(
        &path,
        text.replace(
            "value='0.5'/>\n  </medium>\n  <shape",
            "value='0.25'/>\n  </medium>\n  <shape",
        ),
    )
    .expect("a file");
    apply(&mut world, FileCommand::Save).expect("saved");
    let saved = std::fs::read_to_string(&path).expect("a file");
    assert!(saved.contains("'0.25'") && saved.contains("name=\"scale\""), "{saved}");
    let albedo = medium(&mut world, "milk").coefficients.sigma_t_and_albedo().1;
    assert_eq!(albedo, Rgb::splat(0.25).into());
    said(&mut world, &["undo", "undo"]);
    assert_eq!(medium(&mut world, "fog").scale, 1.0);
    let glass = named(&mut world, "glass");
    assert_eq!(world.get::<ExteriorMedium>(glass), None);
    assert_eq!(medium(&mut world, "milk").coefficients.sigma_t_and_albedo().1, albedo);
}
