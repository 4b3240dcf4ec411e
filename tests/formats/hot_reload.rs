//! Files that change on disk while their scene is open: what changes with them, and what must not.

use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::{Duration, Instant};

use bevy::asset::AssetId;
use bevy::math::{Affine3A, Vec3A};
use bevy::prelude::*;
use sunroom::color::Rgb;
use sunroom::geometry::mesh::MeshData;
use sunroom::scene::{Material, *};

const SCENE: &str = "<scene version='3.0.0'>
  <sensor type='perspective' id='eye'><float name='fov' value='40'/>
    <transform name='to_world'><lookat origin='0,0,5' target='0,0,0' up='0,1,0'/></transform></sensor>
  <include filename='light.xml'/>
  <bsdf type='diffuse' id='red'><rgb name='reflectance' value='0.8,0.1,0.1'/></bsdf>
  <bsdf type='diffuse' id='blue'><rgb name='reflectance' value='0.1,0.1,0.8'/></bsdf>
  <shape type='sphere' id='ball'><ref id='red'/></shape>
  <shape type='cube'><ref id='blue'/></shape>
  <shape type='disk'/>
  <shape type='obj' id='first'><string name='filename' value='first.obj'/></shape>
  <shape type='obj' id='second'><string name='filename' value='second.obj'/></shape>
  <bsdf type='diffuse'><texture type='bitmap' name='reflectance'>
    <string name='filename' value='sentinel.ppm'/></texture></bsdf>
</scene>
";
/// A picture that is written so that all changes before it are known to have been noticed when it is read again.
const SENTINEL: &str = "sentinel.ppm";
const PIXEL: &str = "P3 1 1 255 90 90 90\n";
const LIGHT: &str =
    "<scene version='3.0.0'><emitter type='constant' id='sky'><rgb name='radiance' value='1'/></emitter></scene>";
const TRIANGLE: &str = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";
const QUAD: &str = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3 4\n";

/// Which entities the last frames changed.
#[derive(Resource, Default)]
struct Seen {
    materials: Vec<Entity>,
    shapes: Vec<Entity>,
    poses: Vec<Entity>,
    links: Vec<Entity>,
    settings: usize,
    read_again: Vec<PathBuf>,
}

fn record(
    mut seen: ResMut<Seen>,
    materials: Query<Entity, Changed<Material>>,
    shapes: Query<Entity, Changed<Shape>>,
    poses: Query<Entity, Changed<ToWorld>>,
    links: Query<Entity, Or<(Changed<UsesMaterial>, Changed<MeshHandle>)>>,
    integrator: Res<IntegratorSettings>,
    mut read_again: MessageReader<FileReadAgain>,
) {
    seen.materials.extend(&materials);
    seen.shapes.extend(&shapes);
    seen.poses.extend(&poses);
    seen.links.extend(&links);
    seen.settings += usize::from(integrator.is_changed());
    seen.read_again
        .extend(read_again.read().map(|FileReadAgain(path)| path.clone()));
}

struct Open {
    app: App,
    folder: tempfile::TempDir,
}

impl Open {
    fn new() -> Self {
        let folder = tempfile::tempdir().unwrap();
        put(folder.path().join(SENTINEL), PIXEL).unwrap();
        for (name, text) in [
            ("scene.xml", SCENE),
            ("light.xml", LIGHT),
            ("first.obj", TRIANGLE),
            ("second.obj", TRIANGLE),
        ] {
            put(folder.path().join(name), text).unwrap();
        }
        let mut app = App::new();
        app.add_plugins((MinimalPlugins, FileSourcePlugin, asset_plugin(), ScenePlugin));
        app.init_resource::<Seen>().add_systems(PostUpdate, record);
        app.finish();
        app.cleanup();
        let path = folder.path().join("scene.xml");
        app.world_mut().write_message(OpenScene {
            path,
            defines: Vec::new(),
            ..OpenScene::default()
        });
        let mut open = Self { app, folder };
        open.until("the scene is loaded", |world| {
            world.resource::<SceneStatus>().is_complete()
        });
        // The watch needs a frame to hear of the meshes.
        open.settle();
        open
    }

    fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    fn until(&mut self, what: &str, mut done: impl FnMut(&mut World) -> bool) {
        let deadline = Instant::now() + HANG;
        loop {
            self.app.update();
            if done(self.app.world_mut()) {
                return;
            }
            assert!(Instant::now() < deadline, "not in time: {what}: {:?}", self.status());
            std::thread::sleep(Duration::from_millis(5));
        }
    }

    fn stay(&mut self, time: Duration, check: impl Fn(&SceneStatus)) {
        let end = Instant::now() + time;
        while Instant::now() < end {
            self.app.update();
            check(self.status());
            std::thread::sleep(Duration::from_millis(5));
        }
    }

    /// Until every change on disk so far has been noticed and what it led to has been read.
    fn settle(&mut self) {
        let sentinel = self.path(SENTINEL);
        // The watch needs a frame to hear of new files.
        (0..5).for_each(|_| self.app.update());
        let pictures = self.app.world().resource::<Pictures>();
        if pictures.paths().any(|path| path.ends_with(SENTINEL)) {
            *self.app.world_mut().resource_mut::<Seen>() = Seen::default();
            put(&sentinel, PIXEL).unwrap();
            self.until("the sentinel is read", |world| {
                let read_again = &world.resource::<Seen>().read_again;
                read_again.iter().any(|path| path.ends_with(SENTINEL)) && world.resource::<SceneWatch>().is_idle()
            });
            (0..5).for_each(|_| self.app.update());
        } else {
            // What has not been noticed by then makes no test fail, only weaker.
            self.stay(Duration::from_millis(500), |_| ());
        }
        *self.app.world_mut().resource_mut::<Seen>() = Seen::default();
    }

    fn status(&self) -> &SceneStatus {
        self.app.world().resource::<SceneStatus>()
    }

    fn seen(&self) -> &Seen {
        self.app.world().resource::<Seen>()
    }

    fn until_revision(&mut self, revision: u64) {
        self.until("another revision", |world| {
            world.resource::<SceneStatus>().revision >= revision
        });
    }

    fn by_id(&mut self, id: &str) -> Entity {
        let world = self.app.world_mut();
        let found = world
            .query::<(Entity, &SceneId)>()
            .iter(world)
            .find(|(_, found)| found.0 == id);
        found.unwrap_or_else(|| panic!("no {id}")).0
    }

    fn get<C: Component + Clone>(&mut self, id: &str) -> C {
        let entity = self.by_id(id);
        self.app.world().get::<C>(entity).unwrap().clone()
    }

    fn mesh(&mut self, id: &str) -> (AssetId<TriangleMesh>, Arc<MeshData>) {
        let handle = self.get::<MeshHandle>(id).0;
        let meshes = self.app.world().resource::<Assets<TriangleMesh>>();
        (handle.id(), meshes.get(&handle).unwrap().shapes[0].data.clone())
    }

    fn count<C: Component>(&mut self) -> usize {
        let world = self.app.world_mut();
        world.query::<&C>().iter(world).count()
    }
}

/// No test takes so long, however busy the machine is.
const HANG: Duration = Duration::from_secs(600);

/// In one step, so that however slow the machine is there is one change to notice, and never half a file.
fn put(path: impl AsRef<Path>, text: impl AsRef<str>) -> std::io::Result<()> {
    let aside = path.as_ref().with_extension("tmp");
    std::fs::write(&aside, text.as_ref())?;
    std::fs::rename(&aside, path)
}

fn by_rename(path: &Path, text: &str) {
    put(path, text).unwrap();
}

#[test]
fn only_what_was_edited_changes_however_the_editor_saves() {
    let mut open = Open::new();
    let red = open.by_id("red");
    let edited = SCENE.replace("0.8,0.1,0.1", "0.9,0.2,0.2");
    std::fs::write(open.path("scene.xml"), &edited).unwrap();
    open.until("the edit", |world| {
        world.query::<&Material>().iter(world).any(|material| {
            matches!(material, Material::Diffuse { reflectance } if reflectance.constant() == Some(Vec3::new(0.9, 0.2, 0.2)))
        })
    });
    assert_eq!(
        open.get::<Material>("red"),
        Material::Diffuse {
            reflectance: Vec3::new(0.9, 0.2, 0.2).into()
        }
    );
    assert_eq!(open.seen().materials, [red]);
    assert!(open.seen().shapes.is_empty() && open.seen().poses.is_empty() && open.seen().links.is_empty());
    assert_eq!(open.seen().settings, 0);
    assert!(!open.status().fresh_load);

    open.settle();
    let before = open.status().revision;
    by_rename(
        &open.path("scene.xml"),
        &edited.replace("id='ball'>", "id='ball'><float name='radius' value='2'/>"),
    );
    open.until_revision(before + 1);
    let ball = open.by_id("ball");
    assert_eq!(
        open.get::<Shape>("ball").kind,
        ShapeKind::Sphere {
            center: Vec3::ZERO,
            radius: 2.0
        }
    );
    assert_eq!(open.seen().shapes, [ball]);
    assert!(open.seen().materials.is_empty());
}

#[test]
fn a_spectrum_that_is_edited_is_read_again() {
    let mut open = Open::new();
    let with_sky = |scale: &str| {
        let sky = format!(
            "<emitter type='constant' id='white'><spectrum type='d65' name='radiance'><float name='scale' value='{scale}'/></spectrum></emitter></scene>"
        );
        SCENE.replace("</scene>", &sky)
    };
    for (revision, scale, expected) in [(2, "0.5", 0.5), (3, "2", 2.0)] {
        std::fs::write(open.path("scene.xml"), with_sky(scale)).unwrap();
        open.until_revision(revision);
        let EmitterKind::Constant { radiance } = open.get::<Emitter>("white").kind else {
            panic!("no light")
        };
        assert_eq!(radiance, Vec3::splat(expected));
        open.settle();
    }
}

#[test]
fn a_file_touched_without_a_change_changes_nothing() {
    let mut open = Open::new();
    // Comments move every line.
    put(
        open.path("scene.xml"),
        SCENE.replacen("version='3.0.0'>", "version='3.0.0'><!-- hello -->\n\n", 1),
    )
    .unwrap();
    open.until_revision(2);
    let seen = open.seen();
    let changes = [&seen.materials, &seen.shapes, &seen.poses, &seen.links].map(Vec::len);
    assert_eq!((changes, seen.settings), ([0; 4], 0));
}

#[test]
fn a_broken_edit_keeps_the_scene_and_fixing_it_recovers() {
    let mut open = Open::new();
    put(
        open.path("scene.xml"),
        SCENE.replace("value='0.8,0.1,0.1'", "value='0.8,oops,0.1'"),
    )
    .unwrap();
    open.until("the failure", |world| {
        world.resource::<SceneStatus>().state == SceneState::Failed
    });
    let text = open.status().diagnostics.to_string();
    assert!(text.contains("scene.xml:5:"), "{text}");
    assert_eq!(open.status().revision, 1);
    assert!(open.status().file_is_broken);
    assert_eq!(
        open.get::<Material>("red"),
        Material::Diffuse {
            reflectance: Vec3::new(0.8, 0.1, 0.1).into()
        }
    );
    assert_eq!(open.count::<Shape>(), 5);

    // Half a file, as from an editor that truncates first.
    std::fs::write(open.path("scene.xml"), &SCENE[..SCENE.len() / 2]).unwrap();
    open.settle();
    assert_eq!(open.count::<Shape>(), 5);
    assert_eq!(open.status().state, SceneState::Failed);

    put(open.path("scene.xml"), SCENE.replace("0.8,0.1,0.1", "0.7,0.1,0.1")).unwrap();
    open.until("the recovery", |world| {
        world.resource::<SceneStatus>().state == SceneState::Ready
    });
    assert_eq!(
        open.get::<Material>("red"),
        Material::Diffuse {
            reflectance: Vec3::new(0.7, 0.1, 0.1).into()
        }
    );
    assert!(!open.status().diagnostics.has_errors() && !open.status().file_is_broken);
}

#[test]
fn a_removed_shape_is_one_entity_less() {
    let mut open = Open::new();
    let ball = open.by_id("ball");
    put(
        open.path("scene.xml"),
        SCENE.replace("<shape type='sphere' id='ball'><ref id='red'/></shape>", ""),
    )
    .unwrap();
    open.until_revision(2);
    assert_eq!(open.count::<Shape>(), 4);
    assert!(open.app.world().get::<Shape>(ball).is_none());
    assert!(open.seen().shapes.is_empty(), "the others are what they were");

    put(open.path("scene.xml"), SCENE).unwrap();
    open.until_revision(3);
    assert_eq!(open.count::<Shape>(), 5);
    let red = open.by_id("red");
    assert_eq!(open.get::<UsesMaterial>("ball").0, red);
}

#[test]
fn an_edited_mesh_is_read_again_and_no_other() {
    let mut open = Open::new();
    let (first, old) = open.mesh("first");
    let (_, second) = open.mesh("second");
    let path = open.path("first.obj");
    by_rename(&path, QUAD);
    open.until("the new mesh", |world| {
        world
            .resource::<Assets<TriangleMesh>>()
            .get(first)
            .is_some_and(|mesh| mesh.shapes[0].data.triangles.len() == 2)
    });
    assert!(!Arc::ptr_eq(&open.mesh("first").1, &old));
    open.until("the news of it", |world| {
        world.resource::<Seen>().read_again == [path.clone()]
    });
    open.settle();
    assert!(
        Arc::ptr_eq(&open.mesh("second").1, &second),
        "the other mesh was not read again"
    );
    assert_eq!(open.status().revision, 1, "the scene was not read again");

    // A broken mesh keeps the last good one, and says where it is named.
    put(&path, "v 0 0 0\nf 1 2 3\n").unwrap();
    open.until("the failure", |world| {
        !world.resource::<SceneStatus>().mesh_errors.is_empty()
    });
    assert_eq!(open.mesh("first").1.triangles.len(), 2);
    let message = &open.status().mesh_errors[0].message;
    assert!(
        message.contains("scene.xml:10:") && message.contains("line 2"),
        "{message}"
    );
    put(&path, TRIANGLE).unwrap();
    open.until("the recovery", |world| {
        world.resource::<SceneStatus>().mesh_errors.is_empty()
    });
    assert_eq!(open.mesh("first").1.triangles.len(), 1);
}

#[test]
fn a_file_that_goes_is_told_and_what_was_read_of_it_stays() {
    let mut open = Open::new();
    let (scene, mesh) = (open.path("scene.xml"), open.path("first.obj"));
    let gone = |files: &[&PathBuf]| {
        let files: Vec<PathBuf> = files.iter().map(|file| (*file).clone()).collect();
        move |world: &mut World| world.resource::<SceneStatus>().files_gone == files
    };
    std::fs::remove_file(&mesh).unwrap();
    open.until("the mesh is gone", gone(&[&mesh]));
    let aside = open.path("aside.xml");
    std::fs::rename(&scene, &aside).unwrap();
    open.until("the scene is gone", gone(&[&mesh, &scene]));
    assert_eq!((open.count::<Shape>(), open.status().has_errors()), (5, false));
    assert_eq!(open.mesh("first").1.triangles.len(), 1);
    put(&mesh, QUAD).unwrap();
    std::fs::rename(&aside, &scene).unwrap();
    open.until("both are back", gone(&[]));
    open.until("the mesh is read", |world| {
        !world.resource::<Seen>().read_again.is_empty()
    });
    assert_eq!(open.mesh("first").1.triangles.len(), 2);

    // As some text editors save: away for a moment, here long enough to be noticed.
    open.settle();
    std::fs::rename(&mesh, open.path("first.obj~")).unwrap();
    let away = Instant::now();
    open.stay(Duration::from_millis(250), |status| {
        // On a busy machine it may be away for long.
        if away.elapsed() < Duration::from_millis(500) {
            assert_eq!(status.files_gone, Vec::<PathBuf>::new());
        }
    });
    put(&mesh, TRIANGLE).unwrap();
    open.until("the mesh is read", |world| {
        !world.resource::<Seen>().read_again.is_empty()
    });
    open.stay(Duration::from_millis(700), |status| {
        assert_eq!(status.files_gone, Vec::<PathBuf>::new());
    });
    assert_eq!(open.seen().read_again, [mesh], "once");
}

#[test]
fn material_libraries_and_includes_are_watched() {
    let mut open = Open::new();
    let path = open.path("first.obj");
    let (first, _) = open.mesh("first");
    let kd = |world: &World| {
        let mesh = world.resource::<Assets<TriangleMesh>>().get(first)?;
        mesh.shapes[0].data.materials.first().map(|material| material.kd.x)
    };
    put(&path, format!("mtllib lib.mtl\nusemtl paint\n{TRIANGLE}")).unwrap();
    // The library comes later: its place is watched already.
    open.until("the missing library is noticed", |world| {
        !world.resource::<SceneStatus>().mesh_warnings.is_empty()
    });
    open.settle();
    put(open.path("lib.mtl"), "newmtl paint\nKd 0.25 0 0\n").unwrap();
    open.until("the library", |world| kd(world) == Some(0.25));
    by_rename(&open.path("lib.mtl"), "newmtl paint\nKd 0.75 0 0\n");
    open.until("the edited library", |world| kd(world) == Some(0.75));

    put(open.path("light.xml"), LIGHT.replace("value='1'", "value='2'")).unwrap();
    open.until_revision(2);
    assert_eq!(
        open.get::<Emitter>("sky").kind,
        EmitterKind::Constant {
            radiance: Vec3::splat(2.0)
        }
    );
    assert_eq!(open.status().files_read_again, [open.path("light.xml")]);
}

#[test]
fn the_users_camera_stays_until_the_file_moves_its_own() {
    let mut open = Open::new();
    let eye = open.by_id("eye");
    assert_eq!(open.app.world().resource::<ActiveSensor>().0, Some(eye));
    let flown = Affine3A::from_translation(Vec3::new(1.0, 2.0, 3.0));
    open.app.world_mut().get_mut::<ToWorld>(eye).unwrap().0 = flown;
    put(open.path("scene.xml"), SCENE.replace("0.8,0.1,0.1", "0.9,0.2,0.2")).unwrap();
    open.until_revision(2);
    assert_eq!(open.get::<ToWorld>("eye").0, flown);

    put(
        open.path("scene.xml"),
        SCENE.replace("origin='0,0,5'", "origin='0,0,9'"),
    )
    .unwrap();
    open.until_revision(3);
    assert_eq!(
        open.get::<ToWorld>("eye").0.translation,
        Vec3::new(0.0, 0.0, 9.0).into()
    );
    assert_eq!(open.app.world().resource::<ActiveSensor>().0, Some(eye));
}

#[test]
fn edits_stay_where_the_file_did_not_change_the_same() {
    let mut open = Open::new();
    let (ball, red, blue) = (open.by_id("ball"), open.by_id("red"), open.by_id("blue"));
    let grey = Material::Diffuse {
        reflectance: Rgb::splat(0.3).into(),
    };
    let moved = ToWorld(Affine3A::from_translation(Vec3::X));
    let world = open.app.world_mut();
    world.entity_mut(ball).insert(moved);
    world.entity_mut(blue).insert(grey.clone());
    let made = world
        .spawn((Shape::default(), DocumentOrder(100), Name::new("made here")))
        .id();

    let text = SCENE
        .replace("0.8,0.1,0.1", "0.9,0.2,0.2")
        .replace("0.1,0.1,0.8", "0.2,0.2,0.9");
    put(open.path("scene.xml"), text).unwrap();
    open.until_revision(2);
    let color = |open: &Open, entity| match open.app.world().get::<Material>(entity) {
        Some(Material::Diffuse { reflectance }) => reflectance.constant(),
        _ => None,
    };
    assert_eq!(color(&open, red), Some(Rgb::new(0.9, 0.2, 0.2)));
    assert_eq!(
        color(&open, blue),
        Some(Rgb::new(0.2, 0.2, 0.9)),
        "both sides changed it"
    );
    assert_eq!(open.app.world().get::<ToWorld>(ball), Some(&moved));
    assert!(open.app.world().get::<Shape>(made).is_some());
    let expected = ReloadSummary {
        changed: 1,
        replaced: vec!["blue".to_owned()],
        ..ReloadSummary::default()
    };
    assert_eq!(open.status().reload, expected);
    assert_eq!(open.status().files_read_again, [open.path("scene.xml")]);

    // What is gone from the file but was edited here is not lost.
    let text = SCENE.replace("<shape type='sphere' id='ball'><ref id='red'/></shape>", "");
    put(open.path("scene.xml"), text).unwrap();
    open.until_revision(3);
    assert_eq!(open.app.world().get::<ToWorld>(ball), Some(&moved));
    assert_eq!((open.status().reload.kept, open.status().reload.removed), (1, 0));
}

#[test]
fn a_scene_saved_under_another_name_is_that_file_from_then_on() {
    let mut open = Open::new();
    let red = open.by_id("red");
    let grey = Material::Diffuse {
        reflectance: Rgb::splat(0.3).into(),
    };
    open.app.world_mut().entity_mut(red).insert(grey.clone());
    let other = open.path("other.xml");
    write::save(open.app.world_mut(), &other).unwrap();
    open.settle();
    assert_eq!(open.status().path, Some(other.canonicalize().unwrap()));
    assert_eq!(std::fs::read_to_string(open.path("scene.xml")).unwrap(), SCENE);

    put(open.path("scene.xml"), SCENE.replace("0.8,0.1,0.1", "0.9,0.2,0.2")).unwrap();
    open.settle();
    assert_eq!(
        open.get::<Material>("red"),
        grey,
        "the old file is no matter of this scene"
    );

    let text = std::fs::read_to_string(&other).unwrap();
    put(&other, text.replace("<shape type='disk'/>", "")).unwrap();
    open.until("the new file is followed", |world| {
        world.query::<&Shape>().iter(world).count() == 4
    });
    assert_eq!(open.get::<Material>("red"), grey);
    assert_eq!(open.by_id("red"), red);
}

/// What an include or a mesh has in it would be lost.
#[test]
fn a_scene_is_not_saved_over_other_files_of_it() {
    let mut open = Open::new();
    std::fs::create_dir(open.path("inside")).unwrap();
    for name in ["light.xml", "inside/../light.xml", SENTINEL] {
        let path = open.path(name);
        for on_change in [write::OnChange::Refuse, write::OnChange::Overwrite] {
            let refused = write::save_with(open.app.world_mut(), &path, on_change).unwrap_err();
            let told = refused.to_string();
            assert!(
                told.ends_with(": the scene is made of this file; choose another name")
                    && told.contains(&name[name.len() - 9..]),
                "{told}"
            );
        }
    }
    let text = |open: &Open, name: &str| std::fs::read_to_string(open.path(name)).unwrap();
    assert_eq!(text(&open, "light.xml"), LIGHT);
    assert_eq!(text(&open, SENTINEL), PIXEL);
    // Its own file is replaced, and one that it has left.
    for name in ["scene.xml", "other.xml", "scene.xml"] {
        let path = open.path(name);
        assert_eq!(write::save(open.app.world_mut(), &path).unwrap(), None, "{name}");
    }
}

#[test]
fn a_missing_mesh_that_appears_completes_the_scene() {
    let folder = tempfile::tempdir().unwrap();
    let scenes = folder.path().join("scenes");
    std::fs::create_dir(&scenes).unwrap();
    let path = scenes.join("scene.xml");
    let text = "<scene version='3.0.0'><sensor type='perspective'/>
        <shape type='obj' id='late'><string name='filename' value='../assets/models/late.obj'/></shape></scene>";
    put(&path, text).unwrap();
    let mut app = App::new();
    app.add_plugins((MinimalPlugins, FileSourcePlugin, asset_plugin(), ScenePlugin));
    app.init_resource::<Seen>();
    app.finish();
    app.cleanup();
    app.world_mut().write_message(OpenScene {
        path,
        defines: Vec::new(),
        ..OpenScene::default()
    });
    let mut open = Open { app, folder };
    open.until("the scene without the mesh", |world| {
        world.resource::<SceneStatus>().is_complete()
    });
    let status = open.status();
    assert!(status.has_errors() && status.lacks_only_files());
    let text = &status.mesh_errors[0].message;
    assert!(
        text.contains("scene.xml:2:") && text.contains("no such file; also looked for as "),
        "{text}"
    );
    assert_eq!(open.count::<Shape>(), 1, "the shape is there");
    open.settle();
    // The folders are not there either.
    let models = open.path("assets/models");
    std::fs::create_dir_all(&models).unwrap();
    put(models.join("late.obj"), TRIANGLE).unwrap();
    open.until("the mesh", |world| {
        let status = world.resource::<SceneStatus>();
        status.is_complete() && !status.has_errors()
    });
    assert_eq!(open.mesh("late").1.triangles.len(), 1);
}

fn open_scene(open: &mut Open, name: &str, keeps_edits: bool) {
    let path = open.path(name);
    open.app.world_mut().write_message(OpenScene {
        path,
        keeps_edits,
        ..OpenScene::default()
    });
}

#[test]
fn a_file_that_could_not_be_opened_does_not_come_back_by_itself() {
    let mut open = Open::new();
    let other = open.path("other.xml");
    put(&other, "<scene version='3.0.0'><shape type='sphere' id='stranger'>").unwrap();
    open.settle();
    open_scene(&mut open, "other.xml", false);
    open.until("the failure", |world| {
        world.resource::<SceneStatus>().state == SceneState::Failed
    });
    let status = open.status();
    assert_eq!(status.path.as_deref(), Some(&*open.path("scene.xml")));
    assert_eq!(status.subject(), Some(&*other));
    assert!(!status.file_is_broken);
    // It is mended, while the scene that is open was edited.
    let ball = open.by_id("ball");
    open.app
        .world_mut()
        .entity_mut(ball)
        .insert(ToWorld(Affine3A::from_translation(Vec3::X)));
    let mended = "<scene version='3.0.0'><shape type='sphere' id='stranger'/></scene>";
    put(&other, mended).unwrap();
    open.settle();
    assert_eq!((open.status().revision, open.count::<Shape>()), (1, 5));
    assert_eq!(open.by_id("ball"), ball);
    // The open one is still watched.
    put(open.path("scene.xml"), SCENE.replace("0.8,0.1,0.1", "0.7,0.1,0.1")).unwrap();
    open.until_revision(2);
    assert_eq!(open.get::<ToWorld>("ball").0.translation, Vec3A::X);
    assert_eq!(
        (open.status().state, open.status().asked.as_deref()),
        (SceneState::Ready, None)
    );
    // Asked for again, it is opened.
    open_scene(&mut open, "other.xml", false);
    open.until_revision(3);
    assert_eq!(open.count::<Shape>(), 1);
    assert!(open.status().fresh_load);
}

#[test]
fn a_scene_read_again_keeps_edits_or_loses_them() {
    let mut open = Open::new();
    let ball = open.by_id("ball");
    let moved = ToWorld(Affine3A::from_translation(Vec3::X));
    open.app.world_mut().entity_mut(ball).insert(moved);
    open_scene(&mut open, "scene.xml", true);
    open.until_revision(2);
    assert!(!open.status().fresh_load && open.status().reload.is_unchanged());
    assert_eq!((open.by_id("ball"), open.get::<ToWorld>("ball")), (ball, moved));
    open_scene(&mut open, "scene.xml", false);
    open.until_revision(3);
    assert!(open.status().fresh_load);
    assert_eq!(open.get::<ToWorld>("ball"), ToWorld::default());
}

/// Each nameless cube stays the entity it was, whatever goes or comes before it.
#[test]
fn nameless_things_are_recognised_by_what_they_are() {
    let mut open = Open::new();
    let cube = |x: u32| {
        format!(
            "<shape type='cube'><transform name='to_world'><translate x='{x}'/></transform><bsdf type='diffuse'><rgb name='reflectance' value='0.{x}'/></bsdf></shape>"
        )
    };
    let scene = |cubes: &[u32]| {
        let cubes: String = cubes.iter().map(|x| cube(*x)).collect();
        format!("<scene version='3.0.0'><sensor type='perspective'/>{cubes}</scene>")
    };
    let at = |open: &mut Open, x: f32| {
        let world = open.app.world_mut();
        let mut cubes = world.query::<(Entity, &ToWorld, &UsesMaterial)>();
        let found = cubes.iter(world).find(|(_, pose, _)| pose.0.translation.x == x);
        found.map(|(entity, _, uses)| (entity, uses.0))
    };
    put(open.path("cubes.xml"), scene(&[1, 2, 3, 4])).unwrap();
    open.settle();
    open_scene(&mut open, "cubes.xml", false);
    open.until_revision(2);
    let [second, third, fourth] = [2.0, 3.0, 4.0].map(|x| at(&mut open, x));
    assert!(second.is_some() && third.is_some() && fourth.is_some());
    // An edit of the third is one of the third afterwards.
    let tall = Shape {
        flip_normals: true,
        ..Shape::default()
    };
    let edited = third.expect("a cube").0;
    open.app.world_mut().entity_mut(edited).insert(tall.clone());
    put(open.path("cubes.xml"), scene(&[2, 7, 3, 4])).unwrap();
    open.until_revision(3);
    assert_eq!([2.0, 3.0, 4.0].map(|x| at(&mut open, x)), [second, third, fourth]);
    assert_eq!(open.app.world().get::<Shape>(edited), Some(&tall));
    let reload = open.status().reload.clone();
    // The cube in the first place went, and with it its material; another came.
    assert_eq!((reload.added, reload.removed, reload.changed), (2, 2, 0), "{reload:?}");
    assert!(at(&mut open, 1.0).is_none() && at(&mut open, 7.0).is_some());
}

#[test]
fn what_the_file_calls_as_something_here_gives_way() {
    let mut open = Open::new();
    let mine = open
        .app
        .world_mut()
        .spawn((
            Shape::default(),
            ToWorld::default(),
            DocumentOrder(900),
            SceneId("lamp".into()),
            Name::new("lamp"),
        ))
        .id();
    let text = SCENE.replace("</scene>", "<shape type='disk' id='lamp'/></scene>");
    put(open.path("scene.xml"), text).unwrap();
    open.until_revision(2);
    let reload = open.status().reload.clone();
    assert_eq!((reload.added, reload.renamed), (1, 1), "{}", reload.text());
    assert_ne!(open.by_id("lamp"), mine);
    assert_eq!(open.by_id("lamp-2"), mine);
    assert_eq!(open.get::<Name>("lamp-2").as_str(), "lamp-2");
}

#[test]
fn another_scene_replaces_all_of_this_one() {
    let mut open = Open::new();
    let other = open.path("other.xml");
    let text = "<scene version='3.0.0'><default name='r' value='1'/><sensor type='perspective' id='eye2'/>
        <shape type='sphere' id='ball'><float name='radius' value='$r'/></shape></scene>";
    put(&other, text).unwrap();
    // Or else its coming into being counts as an edit.
    open.settle();
    let old = open.by_id("ball");
    let defines = vec![("r".to_owned(), "3".to_owned())];
    open.app.world_mut().write_message(OpenScene {
        path: other,
        defines,
        ..OpenScene::default()
    });
    open.until_revision(2);
    assert!(open.status().fresh_load);
    assert_eq!(
        (
            open.count::<Shape>(),
            open.count::<Sensor>(),
            open.count::<Material>(),
            open.count::<Emitter>()
        ),
        (1, 1, 0, 0)
    );
    assert!(open.app.world().get_entity(old).is_err());
    assert_eq!(
        open.get::<Shape>("ball").kind,
        ShapeKind::Sphere {
            center: Vec3::ZERO,
            radius: 3.0
        }
    );
    let eye = open.by_id("eye2");
    assert_eq!(open.app.world().resource::<ActiveSensor>().0, Some(eye));

    // The scene before is no longer watched, and its meshes are gone.
    open.settle();
    put(open.path("scene.xml"), SCENE).unwrap();
    open.settle();
    assert_eq!(open.status().revision, 2);
    assert_eq!(open.app.world().resource::<Assets<TriangleMesh>>().len(), 0);

    // Asked for again with other values, it is read again.
    let path = open.path("other.xml");
    open.app.world_mut().write_message(OpenScene {
        path,
        defines: Vec::new(),
        ..OpenScene::default()
    });
    open.until_revision(3);
    assert_eq!(
        open.get::<Shape>("ball").kind,
        ShapeKind::Sphere {
            center: Vec3::ZERO,
            radius: 1.0
        }
    );
}

fn move_ball(open: &mut Open, x: f32) {
    let ball = open.by_id("ball");
    let moved = ToWorld(Affine3A::from_translation(Vec3::X * x));
    open.app.world_mut().entity_mut(ball).insert(moved);
}

/// A reading that began before the scene was saved arrives after that: it knows nothing of the edit.
#[test]
fn an_older_reading_takes_back_nothing_that_was_saved_since() {
    let mut open = Open::new();
    let path = open.path("scene.xml");
    let server = open.app.world().resource::<AssetServer>().clone();
    server.reload(path.clone());
    // On most machines it is read by then, and arrives with the next frame.
    std::thread::sleep(Duration::from_millis(300));
    move_ball(&mut open, 4.0);
    write::save(open.app.world_mut(), &path).unwrap();
    let saved = std::fs::read_to_string(&path).unwrap();
    for _ in 0..200 {
        open.app.update();
        assert_eq!(open.get::<ToWorld>("ball").0.translation, Vec3A::X * 4.0);
        std::thread::sleep(Duration::from_millis(2));
    }
    open.settle();
    assert_eq!(open.get::<ToWorld>("ball").0.translation, Vec3A::X * 4.0);
    // What others change after that is taken over as ever.
    put(&path, saved.replace("0.8,0.1,0.1", "0.9,0.2,0.2")).unwrap();
    open.until("the change", |world| {
        world.query::<&Material>().iter(world).any(|material| {
            matches!(material, Material::Diffuse { reflectance } if reflectance.constant() == Some(Vec3::new(0.9, 0.2, 0.2)))
        })
    });
    assert_eq!(open.get::<ToWorld>("ball").0.translation, Vec3A::X * 4.0);
}

#[test]
fn what_is_read_waits_while_the_file_is_held() {
    let mut open = Open::new();
    let path = open.path("scene.xml");
    move_ball(&mut open, 4.0);
    open.app.world_mut().resource_mut::<SceneFile>().hold(true);
    let ball = "<shape type='sphere' id='ball'>";
    let theirs = SCENE.replace(
        ball,
        &format!("{ball}<transform name='to_world'><translate x='9'/></transform>"),
    );
    put(&path, &theirs).unwrap();
    open.settle();
    assert_eq!(open.get::<ToWorld>("ball").0.translation, Vec3A::X * 4.0);
    assert_eq!(open.status().revision, 1);
    open.app.world_mut().resource_mut::<SceneFile>().hold(false);
    open.until_revision(2);
    assert_eq!(open.get::<ToWorld>("ball").0.translation, Vec3A::X * 9.0);

    // It was written over before it was let in: it is of no use any more.
    open.settle();
    move_ball(&mut open, 5.0);
    open.app.world_mut().resource_mut::<SceneFile>().hold(true);
    put(&path, theirs.replace("x='9'", "x='8'")).unwrap();
    open.settle();
    let world = open.app.world_mut();
    let refused = write::save_with(world, &path, write::OnChange::Refuse);
    assert!(
        matches!(
            refused,
            Err(write::SaveError::Changed {
                edited_twice: Some(ref names),
                ..
            }) if names == &["ball"]
        ),
        "{refused:?}"
    );
    assert_eq!(
        write::save_with(world, &path, write::OnChange::Overwrite).unwrap(),
        None
    );
    open.app.world_mut().resource_mut::<SceneFile>().hold(false);
    open.settle();
    assert_eq!(open.get::<ToWorld>("ball").0.translation, Vec3A::X * 5.0);
    assert!(!std::fs::read_to_string(&path).unwrap().contains("x='8'"));
}
