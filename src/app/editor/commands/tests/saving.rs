//! Large scenes are saved on another thread while edits go on.

use std::sync::Arc;

use super::*;
use crate::app::editor::command::recovery_offer::Note;
use crate::app::editor::command::{
    FileCommand, HistoryCommand, MaterialEdit, OutlineEdit, SceneEdit, SelectionCommand, ValueEdit,
};
use crate::app::editor::commands::saving::{SaveUnderWay, copy, disturb, finish, go_on};
use crate::app::editor::commands::things::pose_of;
use crate::app::editor::session::options::SceneDefines;
use crate::app::editor::session::recovery::Recovery;
use crate::files::{LARGEST_DATA, read_text};
use crate::scene::write::snapshot::Snapshot;
use crate::scene::write::{OnChange, gather};
use crate::scene::{OpenScene, ReloadSummary, SceneDescription, SceneStatus, read, spawn};

/// More than are saved within a frame.
const BALLS: usize = 4200;

struct Large {
    world: World,
    path: PathBuf,
    _folder: tempfile::TempDir,
}

impl Large {
    fn new() -> Self {
        Self::with_materials(1)
    }

    /// So many balls have a material of their own.
    fn with_materials(count: usize) -> Self {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("scene.xml");
        let balls: String = (0..BALLS)
            .map(|ball| format!("  <shape type='sphere' id='ball-{ball}'/>\n"))
            .collect();
        let balls = balls.replacen("/>", "><bsdf type='diffuse'/></shape>", count);
        let text =
            format!("<scene version='3.0.0'>\n  <!-- balls -->\n  <sensor type='perspective'/>\n{balls}</scene>\n");
        std::fs::write(&path, text).expect("a file");
        let mut world = bare_world();
        world.init_resource::<Messages<AppExit>>();
        spawn::spawn_fresh(&mut world, &Arc::new(read_scene(&path)));
        world.resource_mut::<SceneStatus>().path = Some(path.clone());
        Self {
            world,
            path,
            _folder: folder,
        }
    }

    fn ball(&mut self, id: &str) -> Entity {
        let mut all = self.world.query::<(Entity, &SceneId)>();
        let found = all.iter(&self.world).find(|(_, its)| its.0 == id);
        found.expect("it is there").0
    }

    fn place(&mut self, id: &str, x: f32) {
        let ball = self.ball(id);
        let pose = Affine3A::from_translation(Vec3::X * x);
        say(&mut self.world, ValueEdit::Transform(vec![(ball, pose)]));
    }

    fn is_saved(&self) -> bool {
        self.world.resource::<History>().is_saved()
    }

    fn text(&self) -> String {
        read_text(&self.path, LARGEST_DATA).expect("a file")
    }

    /// The changes of a reload of the file.
    fn reload(&mut self) -> ReloadSummary {
        let scene = Arc::new(read_scene(&self.path));
        spawn::update(&mut self.world, &scene)
    }
}

fn read_scene(path: &Path) -> SceneDescription {
    read::read(&mut crate::document::load(path, &[]).expect("a scene"))
}

#[test]
fn a_save_has_what_was_there_when_it_was_copied() {
    let mut large = Large::new();
    large.place("ball-7", 1.5);
    say(&mut large.world, FileCommand::Save);
    assert!(copy(&mut large.world, usize::MAX));
    assert!(large.world.contains_resource::<SaveUnderWay>() && !large.is_saved());
    assert!(large.world.resource::<History>().is_being_saved());
    large.place("ball-7", 2.5);
    let gone = large.ball("ball-8");
    say(&mut large.world, SelectionCommand::Select(vec![gone], Extend::Replace));
    say(&mut large.world, SceneEdit::Delete);
    say(&mut large.world, SceneEdit::Add(AdditionKind::Cube.into()));
    assert!(!large.world.resource::<History>().is_being_saved());
    while large.world.contains_resource::<SaveUnderWay>() {
        go_on(&mut large.world);
    }
    let text = large.text();
    let has = |what: &str| text.contains(what);
    assert!(has("1.5") && has("'ball-8'") && has("<!-- balls -->"));
    assert!(!has("2.5") && !has("cube") && !large.is_saved());
    // The edits are edits of the new file.
    let summary = large.reload();
    assert_eq!(
        (summary.added, summary.changed, summary.removed, &summary.replaced[..]),
        (0, 0, 0, &[][..])
    );
    let ball = large.ball("ball-7");
    let pose = pose_of(&large.world, ball).expect("it has a place");
    assert_eq!(pose.translation.x, 2.5);
    for _ in 0..3 {
        say(&mut large.world, HistoryCommand::Undo);
    }
    assert!(large.is_saved());
    assert!(large.reload().is_unchanged());
    for _ in 0..3 {
        say(&mut large.world, HistoryCommand::Redo);
    }
    say(&mut large.world, FileCommand::Save);
    finish(&mut large.world).expect("saved");
    let text = large.text();
    assert!(text.contains("2.5") && text.contains("cube") && !text.contains("'ball-8'"));
    assert!(large.is_saved() && large.reload().is_unchanged());
}

#[test]
fn the_end_waits_for_a_save_and_does_not_come_after_a_failure() {
    let mut large = Large::new();
    large.place("ball-7", 1.5);
    let nowhere = large.path.join("scene.xml");
    large.world.resource_mut::<CommandQueue>().0 = vec![
        Command::from(FileCommand::SaveScene(nowhere)),
        Command::from(FileCommand::Quit),
    ];
    apply_commands(&mut large.world);
    assert!(large.world.resource::<Messages<AppExit>>().is_empty() && !large.is_saved());
    assert!(
        large
            .world
            .resource::<Toasts>()
            .texts()
            .any(|text| text.contains("scene.xml/scene.xml"))
    );
    large.world.resource_mut::<CommandQueue>().0 =
        vec![Command::from(FileCommand::Save), Command::from(FileCommand::Quit)];
    apply_commands(&mut large.world);
    assert!(!large.world.resource::<Messages<AppExit>>().is_empty() && large.is_saved());
    assert!(large.text().contains("1.5"));
}

#[test]
fn the_end_does_not_come_while_there_is_a_question_how_to_save() {
    let mut large = Large::new();
    let others = |place: &str| {
        let moved = format!("id='ball-7'><transform name='to_world'><translate {place}/></transform></shape>");
        large.text().replace("id='ball-7'/>", &moved)
    };
    let (theirs, path) = (others("x='9'"), large.path.clone());
    large.place("ball-7", 1.5);
    say(&mut large.world, FileCommand::Save);
    disturb(&mut large.world, || std::fs::write(&path, &theirs).expect("a file"));
    let losing = [
        Command::from(FileCommand::Quit),
        Command::from(FileCommand::NewScene),
        Command::from(FileCommand::OpenScene(path.clone())),
        Command::from(FileCommand::RevertScene),
    ];
    for command in losing {
        say(&mut large.world, command);
        assert!(large.world.resource::<Requests>().save_question.is_some());
        assert!(large.world.resource::<Messages<AppExit>>().is_empty() && !large.is_saved());
        assert!(large.world.resource::<Messages<OpenScene>>().is_empty());
    }
    assert!(large.text() == theirs);
    let is_said = |world: &World| {
        let mut texts = world.resource::<Toasts>().texts();
        texts.any(|text| text.contains("there is a question about its file"))
    };
    assert!(is_said(&large.world));
    large.world.resource_mut::<Requests>().save_question = None;
    say(&mut large.world, FileCommand::SaveChanged(path, OnChange::Overwrite));
    say(&mut large.world, FileCommand::Quit);
    assert!(!large.world.resource::<Messages<AppExit>>().is_empty() && large.is_saved());
    assert!(large.text().contains("1.5"));
}

#[test]
fn a_save_that_others_disturb_begins_again_beside_the_frames() {
    let mut large = Large::new();
    let theirs = large.text().replace(
        "id='ball-9'/>",
        "id='ball-9'><float name='radius' value='2.25'/></shape>",
    );
    let path = large.path.clone();
    large.place("ball-7", 1.5);
    say(&mut large.world, FileCommand::Save);
    disturb(&mut large.world, || std::fs::write(&path, theirs).expect("a file"));
    let original = large.text();
    large.place("ball-8", 3.5);
    let mut frames = 0;
    while large.world.contains_resource::<SaveUnderWay>() {
        go_on(&mut large.world);
        frames += 1;
    }
    assert!(frames > 1 && large.is_saved() && large.text() != original);
    let text = large.text();
    assert!(text.contains("1.5") && text.contains("2.25") && text.contains("3.5"));
    assert!(large.reload().is_unchanged());
}

#[test]
fn what_gets_the_id_of_a_thing_of_the_file_meanwhile_gives_way() {
    let mut large = Large::new();
    let first = large.ball("ball-0");
    let material = large.world.get::<UsesMaterial>(first).expect("its own").0;
    let shapes = vec![large.ball("ball-1")];
    let share = Command::from(MaterialEdit::UseMaterial {
        shapes,
        material: Some(material),
    });
    say(&mut large.world, share);
    say(&mut large.world, FileCommand::Save);
    assert!(copy(&mut large.world, usize::MAX));
    let other = large.ball("ball-2");
    say(&mut large.world, OutlineEdit::Rename(other, "material-1".into()));
    finish(&mut large.world).expect("saved");
    let id = |world: &World, entity| world.get::<SceneId>(entity).map(|id| id.0.clone());
    assert_eq!(id(&large.world, material).as_deref(), Some("material-1"));
    let given = id(&large.world, other).expect("it keeps an id");
    assert!(given != "material-1" && given != "ball-2", "{given}");
    say(&mut large.world, FileCommand::Save);
    finish(&mut large.world).expect("saved");
    assert!(large.text().contains(&format!("id='{given}'")) && large.reload().is_unchanged());
}

#[test]
fn a_reload_that_is_asked_for_in_the_same_frame_is_not_met_by_a_save() {
    let mut large = Large::new();
    large.world.init_resource::<SceneDefines>();
    large.place("ball-7", 1.5);
    let text = large.text();
    large.world.resource_mut::<CommandQueue>().0 = vec![
        Command::from(FileCommand::RevertScene),
        Command::from(FileCommand::Save),
    ];
    apply_commands(&mut large.world);
    assert!(!large.world.contains_resource::<SaveUnderWay>());
    assert!(!large.world.resource::<Messages<OpenScene>>().is_empty());
    let mut texts = large.world.resource::<Toasts>().texts();
    assert!(texts.any(|text| text.contains("still being read")));
    assert_eq!(large.text(), text);
}

#[test]
fn newer_edits_of_a_large_scene_are_asked_about_before_it_is_saved() {
    let mut large = Large::new();
    let home = tempfile::tempdir().expect("a folder");
    let copy = home.path().join("recovery/left");
    std::fs::create_dir_all(&copy).expect("a folder");
    let note = Note {
        scene: Some(large.path.clone()),
        time: u64::MAX,
        ..Note::default()
    };
    let text = serde_json::to_vec(&note).expect("plain data");
    std::fs::write(copy.join("about.json"), text).expect("a file");
    std::fs::write(copy.join("scene.xml"), "<scene/>").expect("a file");
    large.world.insert_resource(Recovery::new(Some(home.path())));
    large.place("ball-7", 1.5);
    say(&mut large.world, FileCommand::Save);
    assert!(!large.world.contains_resource::<SaveUnderWay>());
    let question = large.world.resource_mut::<Requests>().save_question.take();
    assert!(question.is_some_and(|question| question.copy.is_some()));
    let command = Command::from(FileCommand::SaveChanged(large.path.clone(), OnChange::Refuse));
    say(&mut large.world, command);
    finish(&mut large.world).expect("saved");
    assert!(large.is_saved() && large.text().contains("1.5"));
}

/// Edits of all kinds that a copy has to notice, of which the last is made after it has passed everything.
#[test]
fn a_copy_made_piece_by_piece_is_of_its_last_moment() {
    let mut large = Large::with_materials(3);
    let whole = |world: &mut World| gather::describe_entities(world);
    let mut snapshot = Snapshot::begin(&mut large.world);
    let mut step = |world: &mut World| snapshot.step(world, 900);
    assert!(!step(&mut large.world));
    // Some of these are copied already, others are not.
    for (place, id) in ["ball-7", "ball-4000"].into_iter().enumerate() {
        large.place(id, 2.5 + place as f32);
    }
    assert!(!step(&mut large.world));
    for id in ["ball-8", "ball-4001"] {
        let gone = large.ball(id);
        say(&mut large.world, SelectionCommand::Select(vec![gone], Extend::Replace));
        say(&mut large.world, SceneEdit::Delete);
    }
    say(&mut large.world, SceneEdit::Add(AdditionKind::Cube.into()));
    assert!(!step(&mut large.world));
    let (first, second) = (large.ball("ball-0"), large.ball("ball-1"));
    let shapes = vec![second];
    let material = None;
    say(&mut large.world, MaterialEdit::UseMaterial { shapes, material });
    say(&mut large.world, OutlineEdit::Rename(first, "zero".into()));
    let material = large.world.get::<UsesMaterial>(first).expect("its own").0;
    let red = Material::Diffuse {
        reflectance: Rgb::X.into(),
    };
    say(&mut large.world, ValueEdit::SetMaterial(material, Box::new(red)));
    assert!(!step(&mut large.world));
    say(&mut large.world, HistoryCommand::Undo);
    say(&mut large.world, HistoryCommand::Redo);
    let despawned = large.ball("ball-9");
    large.world.despawn(despawned);
    assert!(step(&mut large.world));
    let (copied, entities) = snapshot.describe();
    let (now, entities_now) = whole(&mut large.world);
    assert!(copied == now && entities == entities_now);
    assert_eq!(now.shapes.len(), BALLS - 2);
    assert!(now.shapes.iter().any(|shape| shape.identity.name == "zero"));
}

#[test]
fn a_copy_ends_though_everything_changes_all_the_time() {
    let mut large = Large::new();
    let mut snapshot = Snapshot::begin(&mut large.world);
    let mut steps = 1;
    while !snapshot.step(&mut large.world, BALLS) {
        let mut poses = large.world.query::<&mut ToWorld>();
        for mut pose in poses.iter_mut(&mut large.world) {
            pose.0.translation.x += 1.0;
        }
        steps += 1;
    }
    assert!((2..20).contains(&steps), "{steps}");
    assert!(snapshot.describe().0 == gather::describe(&mut large.world));
}

#[test]
fn edits_while_a_scene_is_copied_are_in_the_file() {
    let mut large = Large::new();
    large.place("ball-7", 1.5);
    say(&mut large.world, FileCommand::Save);
    let is_copied = copy(&mut large.world, 1);
    large.place("ball-7", 2.5);
    finish(&mut large.world).expect("saved");
    // On a quick machine the copy was complete before.
    assert!(large.text().contains(if is_copied { "1.5" } else { "2.5" }));
    assert_eq!(large.is_saved(), !is_copied);
    large.reload();
    let ball = large.ball("ball-7");
    let pose = pose_of(&large.world, ball).expect("it has a place");
    assert_eq!(pose.translation.x, 2.5);
}

/// Renames, shared materials (which saving gives ids), undo and redo in every order, before, while and after the scene
/// is saved and read again.
#[test]
fn no_id_is_given_twice_whatever_is_undone_around_saves() {
    let mut large = Large::with_materials(4);
    let names = ["material-1", "material-2", "ball-1", "ball-2", "other", ""];
    let mut state = 1u32;
    let mut random = move |below: usize| {
        state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        (state >> 16) as usize % below
    };
    let balls: Vec<Entity> = (0..6).map(|ball| large.ball(&format!("ball-{ball}"))).collect();
    let materials: Vec<Entity> = balls[..4]
        .iter()
        .map(|ball| large.world.get::<UsesMaterial>(*ball).expect("its own").0)
        .collect();
    for time in 0..160 {
        let thing = match random(2) {
            0 => balls[random(balls.len())],
            _ => materials[random(materials.len())],
        };
        match random(14) {
            0..4 => say(
                &mut large.world,
                OutlineEdit::Rename(thing, names[random(names.len())].into()),
            ),
            4..7 => say(&mut large.world, HistoryCommand::Undo),
            7..9 => say(&mut large.world, HistoryCommand::Redo),
            9 | 10 => {
                let shapes = vec![balls[random(balls.len())]];
                let material = Some(materials[random(materials.len())]);
                say(&mut large.world, MaterialEdit::UseMaterial { shapes, material });
            }
            // All of it is copied at once, or most of it later.
            11 => {
                say(&mut large.world, FileCommand::Save);
                copy(&mut large.world, random(2) * BALLS);
            }
            12 => finish(&mut large.world).expect("saved"),
            _ => {
                finish(&mut large.world).expect("saved");
                large.reload();
            }
        }
        let mut ids = large.world.query_filtered::<&SceneId, With<DocumentOrder>>();
        let mut known = std::collections::HashSet::new();
        let twice = ids.iter(&large.world).find(|id| !known.insert(&id.0));
        assert_eq!(twice, None, "after {time}");
    }
    finish(&mut large.world).expect("saved");
    say(&mut large.world, FileCommand::Save);
    finish(&mut large.world).expect("saved");
    assert!(large.is_saved() && large.reload().is_unchanged());
}
