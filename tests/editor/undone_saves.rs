//! Edits that are undone after a save: the next save gives the file its old text back.

use std::path::PathBuf;

use bevy::prelude::{Entity, Name, World};
use sunroom::app::editor::automation::monkey::edits::{PART, random_edit};
use sunroom::app::editor::automation::monkey::random::Random;
use sunroom::app::editor::command::{Command, FileCommand, HistoryCommand, TimeCommand};
use sunroom::app::editor::commands::apply;
use sunroom::app::editor::session::history::History;
use sunroom::app::editor::session::requests::Requests;
use sunroom::scene::SceneId;
use sunroom::scene::write::OnChange;
use tempfile::TempDir;

use crate::editing::{save, say, say_all, text_of, window_on};

/// Numbers, quotes and spaces as a person may write them, with comments at all places.
const ROOM: &str = "<?xml version='1.0'?>
<!-- a room -->
<scene   version='3.0.0'>
\t<default name=\"height\" value='1.50'/>  <!-- of the lamp -->
\t<sensor type='perspective' id='eye'><float name='fov' value='45.00' /></sensor>

\t<bsdf type='diffuse' id='paint'><rgb name='reflectance' value='.5,0.50 , 5e-1'/> <!-- grey --></bsdf>
\t<texture type='checkerboard'  id='board'/>
\t<shape type='sphere' id='first'>
\t\t<float name='radius'   value='0.250'/><!-- small -->
\t\t<ref id='paint'/>
\t</shape> <!-- the first -->
\t<!-- before the second -->
\t<shape type=\"cube\" id='second'>  <!-- the second -->
\t\t<transform name='to_world'>
\t\t\t<scale value='01.0'/> <rotate y='1' angle='45.0'/>
\t\t\t<translate x='1.0' y='$height'/>
\t\t</transform>
\t\t<bsdf type='plastic'><float name=\"int_ior\" value='1.40'/></bsdf>
\t</shape>
\t<shape type='rectangle'><bsdf type='diffuse'/></shape>
\t<include filename='more.xml'/>
\t<shape type='disk' id='last'/><shape type='cylinder' id='same-line'/>
</scene>
<!-- the end -->
";

const MORE: &str = "<scene version='3.0.0'>\r
  <!-- included -->\r
  <shape type='sphere' id='far'><point name='center' x='3.0' y='0.00' z='1'/></shape>\r
</scene>\r
";

struct Room {
    folder: TempDir,
    world: World,
}

impl Room {
    fn new() -> Self {
        let folder = tempfile::tempdir().expect("a folder");
        std::fs::write(folder.path().join("room.xml"), ROOM).expect("a file");
        std::fs::write(folder.path().join("more.xml"), MORE).expect("a file");
        let world = window_on(&folder.path().join("room.xml"));
        Self { folder, world }
    }

    fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    fn save(&mut self) -> [String; 2] {
        save(&mut self.world);
        self.texts()
    }

    fn texts(&self) -> [String; 2] {
        ["room.xml", "more.xml"].map(|name| text_of(&self.path(name)))
    }

    fn say(&mut self, line: &str) {
        assert!(say(&mut self.world, line), "{line}");
    }

    fn undo_all(&mut self) {
        while apply(&mut self.world, HistoryCommand::Undo).is_ok() {}
    }
}

fn original() -> [String; 2] {
    [ROOM.to_owned(), MORE.to_owned()]
}

/// Lines of a script, which are done after each other.
const EDITS: [&[&str]; 14] = [
    &["set first radius 2"],
    &["set paint reflectance 0.2"],
    &["select second", "delete"],
    &["select first", "delete"],
    &["select far", "delete"],
    &["move far 0,1,0"],
    &["move second 1,0,0", "rotate second 0,1,0 33"],
    &["assign paint second"],
    &["assign plastic first"],
    &["select first second", "group"],
    &["rename first other"],
    &["select second", "duplicate", "select last", "delete"],
    &["make paint conductor"],
    // What was inside a material that nothing uses any more.
    &["wrap diffuse mask", "material-of rectangle", "assign diffuse-2 last"],
];

#[test]
fn a_save_after_undo_gives_the_file_its_text_back() {
    for edit in EDITS {
        let mut room = Room::new();
        for line in edit {
            room.say(line);
        }
        assert_ne!(room.save(), original(), "{edit:?}");
        room.undo_all();
        assert_eq!(room.save(), original(), "{edit:?}");
    }
}

#[test]
fn what_is_done_again_is_written_again() {
    for edit in EDITS {
        let mut room = Room::new();
        for line in edit {
            room.say(line);
        }
        let edited = room.save();
        for _ in 0..2 {
            room.undo_all();
            assert_eq!(room.save(), original(), "{edit:?}");
            while apply(&mut room.world, HistoryCommand::Redo).is_ok() {}
            assert_eq!(room.save(), edited, "{edit:?}");
        }
    }
}

/// Each save is undone for itself.
#[test]
fn each_of_several_saves_has_its_text_back() {
    let mut room = Room::new();
    let mut texts = vec![(0, original())];
    for edit in EDITS
        .iter()
        .filter(|edit| !edit.iter().any(|line| line.contains("delete")))
    {
        for line in *edit {
            // What was renamed or is in a group has another name.
            say(&mut room.world, line);
        }
        let steps = room.world.resource::<History>().len().0;
        texts.push((steps, room.save()));
    }
    for (steps, expected) in texts.iter().rev().chain(&texts) {
        apply(&mut room.world, HistoryCommand::GoTo(*steps)).expect("there is such a step");
        assert_eq!(&room.save(), expected, "after {steps} steps");
    }
}

#[test]
fn a_deleted_shape_that_came_back_is_as_it_was_beside_later_edits() {
    let mut room = Room::new();
    room.say("select second");
    room.say("delete");
    room.save();
    room.say("undo");
    room.say("set paint reflectance 0.2");
    let [text, more] = room.save();
    let expected = ROOM.replace("'.5,0.50 , 5e-1'", "'0.2,0.2 , 0.2'");
    assert_eq!((text, more.as_str()), (expected, MORE));
}

#[test]
fn an_id_that_a_save_gave_goes_with_the_edit_that_needed_it() {
    let mut room = Room::new();
    room.say("assign plastic first");
    let shared = room.save();
    assert!(shared[0].contains("<bsdf type='plastic' id="), "{}", shared[0]);
    room.say("undo");
    assert_eq!(room.save(), original());
    room.say("redo");
    assert_eq!(room.save(), shared);
}

/// The file still has the ids then, and what lost one would count as edited.
#[test]
fn things_keep_their_ids_when_a_save_fails() {
    let mut room = Room::new();
    room.say("assign plastic first");
    let shared = room.save();
    room.say("undo");
    let ids = |world: &mut World| {
        let mut things = world.query::<(Entity, &SceneId, &Name)>();
        let things = things.iter(world);
        let mut ids: Vec<_> = things
            .map(|(entity, id, name)| (entity, id.clone(), name.clone()))
            .collect();
        ids.sort_by_key(|(entity, ..)| *entity);
        ids
    };
    let before = ids(&mut room.world);
    // A folder is in the place of the file that is included.
    let more = room.path("more.xml");
    std::fs::remove_file(&more).expect("it is there");
    std::fs::create_dir(&more).expect("a folder");
    let command = Command::from(FileCommand::SaveChanged(room.path("room.xml"), OnChange::Overwrite));
    assert!(apply(&mut room.world, command).is_err());
    assert_eq!(text_of(&room.path("room.xml")), shared[0]);
    assert_eq!(ids(&mut room.world), before);
    std::fs::remove_dir(&more).expect("it is there");
    std::fs::write(&more, MORE).expect("a file");
    assert_eq!(room.save(), original());
    assert_ne!(ids(&mut room.world), before);
}

#[test]
fn changes_by_others_stay_when_an_edit_is_undone() {
    let mut room = Room::new();
    room.say("set first radius 2");
    let [text, _] = room.save();
    std::fs::write(room.path("room.xml"), text.replace("45.00", "60.0")).expect("a file");
    room.say("undo");
    let [text, more] = room.save();
    assert!(text.contains("value='60.0' /") && text.contains("'0.25'"), "{text}");
    assert_eq!(more, MORE);
    // From now on it is that text which comes back.
    room.say("set first radius 3");
    room.save();
    room.say("undo");
    assert_eq!(room.save(), [text, more]);
}

#[test]
fn a_scene_that_is_saved_elsewhere_has_nothing_of_the_old_file() {
    let mut room = Room::new();
    room.say("set first radius 2");
    room.save();
    room.say("undo");
    std::fs::create_dir(room.path("other")).expect("a folder");
    let other = room.path("other/room.xml");
    apply(&mut room.world, FileCommand::SaveScene(other.clone())).expect("saved");
    assert!(text_of(&other).contains("the first"));
    assert_eq!(room.texts()[0], ROOM.replace("0.250", "2"));
    room.say("set first radius 3");
    room.save();
    room.say("undo");
    let before = text_of(&other);
    save(&mut room.world);
    assert_ne!(text_of(&other), before);
    assert!(text_of(&other).contains("'0.25'"));
}

#[test]
fn keys_that_are_undone_after_a_save_leave_no_trace() {
    let text = "<scene version='3.0.0'>\n  <shape type='sphere' id='ball'>\n    <animation name='to_world'>\
        <transform time='0.0'><translate x='1.0'/></transform> <transform time='1.00'><translate x='2.50'/></transform>\
        </animation>\n  </shape>\n  <sensor type='perspective' id='eye'/>\n</scene>\n";
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("moving.xml");
    std::fs::write(&path, text).expect("a file");
    let mut world = window_on(&path);
    for time in [0.0, 0.5, 1.0] {
        apply(&mut world, TimeCommand::SetTime(time)).expect("a time");
        assert!(say(&mut world, "move ball 0,1,0"));
        save(&mut world);
        assert_ne!(text_of(&path), text);
        apply(&mut world, TimeCommand::SetTime(0.25)).expect("a time");
        assert!(say(&mut world, "undo"));
        save(&mut world);
        assert_eq!(text_of(&path), text, "at {time}");
    }
}

/// Random edits with saves between them, all undone: the text is the first one.
#[test]
fn whatever_was_done_and_saved_the_first_text_comes_back() {
    for seed in 0..40 {
        let mut room = Room::new();
        let part = room.path("part.xml");
        std::fs::write(&part, PART).expect("a file");
        let mut random = Random::new(0x0dd_5eed + seed);
        for _ in 0..12 {
            if let Some(edit) = random_edit(&mut room.world, &mut random, &part) {
                room.world.resource_mut::<Requests>().interaction += 1;
                say_all(&mut room.world, &edit);
            }
            if random.below(3) == 0 {
                room.save();
            }
        }
        room.save();
        room.undo_all();
        assert_eq!(room.save(), original(), "seed {seed}");
    }
}
