//! Commands about files.

use super::*;
use crate::app::editor::command::file_access::Question;
use crate::app::editor::command::scene::Replacement;
use crate::app::editor::command::shell::{Sheet, ShellCommand};
use crate::app::editor::command::{FileCommand, SceneEdit, ValueEdit};
use crate::app::editor::session::options::SceneDefines;
use crate::app::editor::session::requests::Requests;
use crate::app::editor::session::toasts::Tone;
use crate::app::editor::session::trust::TrustedFolders;
use crate::files::{LARGEST_NOTE, read_text};
use crate::scene::{SceneAccess, SceneStatus, Trust, spawn};

/// Scripts get an error where the window would ask.
#[test]
fn a_question_that_nobody_can_answer_is_an_error() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("scene.xml");
    let text = "<scene version='3.0.0'><sensor type='perspective'/><shape type='sphere' id='a'/></scene>";
    std::fs::write(&path, text).expect("a file");
    let mut world = bare_world();
    world.init_resource::<SceneStatus>();
    let error = apply_now(&mut world, FileCommand::Save)
        .expect_err("there is no file")
        .to_string();
    assert!(error.contains("save-to FILE"), "{error}");
    assert_eq!(world.resource::<Requests>().dialog, None);

    let mut document = crate::document::load(&path, &[]).expect("a scene");
    let scene = std::sync::Arc::new(crate::scene::read::read(&mut document));
    spawn::spawn_fresh(&mut world, &scene);
    world.resource_mut::<SceneStatus>().path = Some(path.clone());
    let mut shapes = world.query_filtered::<Entity, With<Shape>>();
    let ball = shapes.single(&world).expect("a ball");
    let moved = Command::from(ValueEdit::Transform(vec![(ball, Affine3A::from_translation(Vec3::X))]));
    apply_now(&mut world, moved).expect("it can be moved");
    let theirs = text.replace("id='a'/>", "id='a'><float name='radius' value='2'/></shape>");
    std::fs::write(&path, &theirs).expect("a file");
    // Another parameter of the same thing was edited: both edits stay.
    apply_now(&mut world, FileCommand::Save).expect("merged");
    let merged = read_text(&path, LARGEST_NOTE).expect("a file");
    assert!(merged.contains("radius") && merged.contains("center"), "{merged}");

    let smaller = Shape {
        kind: ShapeKind::Sphere {
            center: Vec3::ZERO,
            radius: 0.5,
        },
        ..Shape::default()
    };
    apply_now(&mut world, ValueEdit::SetShape(ball, smaller)).expect("it can be changed");
    let theirs = merged.replace("value='2'", "value='3'");
    std::fs::write(&path, &theirs).expect("a file");
    let error = apply_now(&mut world, FileCommand::Save)
        .expect_err("both changed the radius")
        .to_string();
    assert!(
        error.contains("and a was edited both there and here") && error.contains("merge"),
        "{error}"
    );
    assert!(world.resource::<Requests>().save_question.is_none());
    assert_eq!(read_text(&path, LARGEST_NOTE).expect("a file"), theirs);
}

#[test]
fn a_fault_of_a_file_stays_until_it_is_mended() {
    let folder = tempfile::tempdir().expect("a folder");
    let mesh = folder.path().join("mesh.obj");
    let mut world = bare_world();
    let mut tones_after = |commands: Vec<Command>| {
        world.resource_mut::<CommandQueue>().0 = commands;
        apply_commands(&mut world);
        let toasts = world.resource_mut::<Toasts>().current().to_vec();
        toasts.iter().map(|toast| toast.tone).collect::<Vec<Tone>>()
    };
    let import = || Command::from(SceneEdit::Import(mesh.clone()));
    let tones = tones_after(vec![Command::from(SceneEdit::Delete), import()]);
    assert_eq!(tones, [Tone::Warning, Tone::Error]);
    std::fs::write(&mesh, "v 0 0 0").expect("a file");
    assert_eq!(tones_after(vec![import()]), [Tone::Warning]);
}

/// The user is asked about a scene that cannot be imported without files outside its folder, as when it is opened.
#[test]
fn an_import_of_files_outside_the_scenes_folder_is_asked_about() {
    let folder = tempfile::tempdir().expect("a folder");
    let file = |name: &str, text: &str| {
        let path = folder.path().join(name);
        std::fs::create_dir_all(path.parent().expect("a folder")).expect("a folder");
        std::fs::write(&path, text).expect("a file");
        path.canonicalize().expect("it is there")
    };
    let outside = file(
        "outside/part.xml",
        "<scene version='3.0.0'><shape type='sphere' id='part'/></scene>",
    );
    let scene = file(
        "downloads/chair.xml",
        "<scene version='3.0.0'><include filename='../outside/part.xml'/></scene>",
    );
    let mut world = bare_world();
    world.insert_resource(Trust::Folders(Vec::new()));
    world.init_resource::<SceneAccess>();
    world.init_resource::<TrustedFolders>();
    let error = apply(&mut world, SceneEdit::Import(scene.clone()))
        .expect_err("it may not be read")
        .to_string();
    assert!(error.contains("part.xml") && error.contains("outside"), "{error}");
    let question = world.resource::<TrustedFolders>().question.clone();
    let Some(Question { files, edit, .. }) = &question else {
        panic!("nothing is asked");
    };
    assert_eq!(edit.as_ref(), Some(&SceneEdit::Import(scene.clone())));
    let named: Vec<_> = files
        .iter()
        .map(|path| path.canonicalize().expect("it is there"))
        .collect();
    assert_eq!(named, [outside]);
    assert_eq!(world.query::<&Shape>().iter(&world).count(), 0);

    let answer = Command::Shell(ShellCommand::AllowFiles(question.expect("there is one")));
    say(&mut world, answer);
    apply_commands(&mut world);
    assert_eq!(world.query::<&Shape>().iter(&world).count(), 1);

    // A replacement by the file is repeated as such.
    let mut world = bare_world();
    world.insert_resource(Trust::Folders(Vec::new()));
    world.init_resource::<SceneAccess>();
    world.init_resource::<TrustedFolders>();
    let cube = add(&mut world, AdditionKind::Cube);
    let replace = SceneEdit::Replace(Replacement::File(scene));
    apply(&mut world, replace).expect_err("it may not be read");
    let question = world.resource::<TrustedFolders>().question.clone();
    let answer = Command::Shell(ShellCommand::AllowFiles(question.expect("there is one")));
    say(&mut world, answer);
    apply_commands(&mut world);
    let shapes: Vec<(Entity, &Shape)> = world.query::<(Entity, &Shape)>().iter(&world).collect();
    assert!(
        matches!(shapes[..], [(entity, shape)] if entity == cube && matches!(shape.kind, ShapeKind::Sphere { .. })),
        "{shapes:?}"
    );
}

#[test]
fn an_opened_scene_is_not_behind_the_start_page() {
    let opens = || Command::from(FileCommand::OpenScene(PathBuf::from("/there/scene.xml")));
    for command in [opens(), Command::from(FileCommand::NewScene)] {
        let mut world = bare_world();
        world.init_resource::<SceneDefines>();
        for (sheet, then) in [(Sheet::Start, None), (Sheet::Keys, Some(Sheet::Keys))] {
            world.resource_mut::<Requests>().sheet = Some(sheet);
            apply_now(&mut world, command.clone()).expect("nothing is lost by it");
            assert_eq!(world.resource::<Requests>().sheet, then, "{command:?}");
        }
    }
}
