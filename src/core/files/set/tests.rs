//! Sets that are replaced, interrupted, and completed.

use super::*;

/// A folder with a main file, one beside it and one below it, of three sets: an older one, and a newer one of other
/// files.
struct Shop(tempfile::TempDir);

const MAIN: &str = "scene.gltf";
const FIRST: [&str; 3] = ["scene.bin", "scene-files/a.ply", MAIN];
const SECOND: [&str; 3] = ["scene.bin", "scene-files/b.ply", MAIN];

impl Shop {
    fn new() -> Self {
        let shop = Self(tempfile::tempdir().expect("a temporary folder"));
        fs::create_dir(shop.path("scene-files")).expect("a writable folder");
        for name in FIRST {
            fs::write(shop.path(name), "first").expect("a writable folder");
        }
        shop
    }

    fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    fn second(&self) -> FileSet {
        // Files are added in another order than they are renamed.
        let mut set = FileSet::new(&self.path(MAIN));
        for name in SECOND.iter().rev() {
            set.add(&self.path(name), "second").expect("it can be written");
        }
        set.remove(&self.path("scene-files/a.ply"));
        set
    }

    /// The content of files by name; names of temporary files and notes are shortened.
    fn content(&self) -> Vec<(String, String)> {
        let mut all = Vec::new();
        for folder in ["", "scene-files/"] {
            for entry in fs::read_dir(self.path(folder)).expect("it is there").flatten() {
                let name = entry.file_name().to_string_lossy().into_owned();
                if entry.path().is_file() {
                    let text = fs::read_to_string(entry.path()).expect("a text");
                    all.push((format!("{folder}{name}"), text));
                }
            }
        }
        all.sort();
        all
    }

    fn is(&self, names: [&str; 3], text: &str) -> bool {
        let mut expected = names.map(|name| (name.to_owned(), text.to_owned()));
        expected.sort();
        self.content() == expected
    }

    fn finish(&self) -> Result<(), String> {
        finish_set(&self.path(MAIN)).map_err(|error| error.to_string())
    }

    /// The note, and its only temporary file.
    fn note(&self) -> PathBuf {
        note_path(&self.path(MAIN).canonicalize().expect("it is there"))
    }
}

/// Three renames, the removal of an old file, and that of the note.
const STEPS: usize = 4;

#[test]
fn a_set_is_replaced_as_a_whole() {
    let shop = Shop::new();
    let set = shop.second();
    drop(set);
    assert!(shop.is(FIRST, "first"));
    shop.second().replace().expect("it can be written");
    assert!(shop.is(SECOND, "second"), "{:?}", shop.content());
}

#[test]
fn the_reader_finishes_what_a_killed_program_began() {
    for stop in 0..=STEPS {
        let shop = Shop::new();
        shop.second().replace_until(stop).expect("it can be written");
        // The main file is renamed last.
        let main = fs::read_to_string(shop.path(MAIN)).expect("it is there");
        assert_eq!(main == "second", stop >= 3, "{stop}");
        assert!(shop.note().exists());
        shop.finish().expect("it can be finished");
        assert!(shop.is(SECOND, "second"), "{stop}: {:?}", shop.content());
        assert!(!shop.note().exists());
    }
}

#[test]
fn the_next_writer_finishes_what_a_killed_program_began() {
    for stop in 0..=STEPS {
        let shop = Shop::new();
        shop.second().replace_until(stop).expect("it can be written");
        let mut third = FileSet::new(&shop.path(MAIN));
        third.add(&shop.path(MAIN), "third").expect("it can be written");
        third.replace().expect("it can be written");
        let expected = [
            ("scene-files/b.ply", "second"),
            ("scene.bin", "second"),
            (MAIN, "third"),
        ];
        let expected = expected.map(|(name, text)| (name.to_owned(), text.to_owned()));
        assert_eq!(shop.content(), expected, "{stop}");
    }
}

#[test]
fn readers_and_writers_of_any_file_of_a_set_finish_it() {
    for stop in 0..=STEPS {
        for writes in [false, true] {
            let shop = Shop::new();
            shop.second().replace_until(stop).expect("it can be written");
            let part = shop.path("scene.bin");
            match writes {
                false => finish_set(&part).expect("it can be finished"),
                true => FileSet::new(&part).replace().expect("nothing is replaced"),
            }
            assert!(shop.is(SECOND, "second"), "{stop} {writes}: {:?}", shop.content());
        }
    }
}

#[test]
fn a_first_set_has_no_older_files() {
    for stop in 0..=2 {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let path = |name: &str| folder.path().join(name);
        let mut set = FileSet::new(&path("a.gltf"));
        for name in ["a.bin", "a.gltf"] {
            set.add(&path(name), name).expect("it can be written");
        }
        set.replace_until(stop).expect("it can be written");
        finish_set(&path("a.gltf")).expect("it can be finished");
        let names = fs::read_dir(folder.path()).expect("it is there").count();
        assert_eq!(
            (path("a.gltf").exists(), path("a.bin").exists(), names),
            (true, true, 2)
        );
    }
}

#[test]
fn what_was_changed_since_is_not_replaced() {
    for (name, stop) in [(MAIN, 1), ("scene.bin", 1), ("scene.bin", 3)] {
        let shop = Shop::new();
        shop.second().replace_until(stop).expect("it can be written");
        fs::write(shop.path(name), "the user's own").expect("a writable folder");
        let before = shop.content();
        let message = shop.finish().expect_err("files of the user");
        assert!(
            message.contains(&format!("{name} was changed since"))
                || message.contains(&format!("{name} is not the new one")),
            "{message}"
        );
        assert!(
            message.contains(&format!("remove {}", shop.note().display())),
            "{message}"
        );
        assert_eq!(shop.content(), before);
        // Another set replaces it, and no file of the old one is left.
        shop.second().replace().expect("it can be written");
        shop.finish().expect("there is nothing to finish");
        let left = shop.content();
        assert!(left.iter().all(|(name, _)| !name.contains(".sunroom")), "{left:?}");
    }
}

#[test]
fn notes_of_others_rename_and_remove_nothing_elsewhere() {
    let shop = Shop::new();
    let inner = shop.path("inner");
    fs::create_dir(&inner).expect("a writable folder");
    let part = inner.join(".sunroom-evil.part");
    #[cfg(unix)]
    std::os::unix::fs::symlink("..", inner.join("link")).expect("a writable folder");
    fs::write(&part, "evil").expect("a writable folder");
    fs::write(inner.join("own.txt"), "evil").expect("a writable folder");
    let stamp = Stamp::of(&part).expect("it is there");
    let old = Stamp::of(&shop.path("scene.bin")).expect("it is there");
    let absolute = shop.path("new.txt");
    for (from, to, is_there) in [
        (".sunroom-evil.part", "../new.txt", false),
        (".sunroom-evil.part", "../scene.bin", true),
        (".sunroom-evil.part", "link/new.txt", false),
        (".sunroom-evil.part", absolute.to_str().expect("a text"), false),
        ("own.txt", "new.txt", false),
    ] {
        let plan = Plan {
            files: vec![Rename {
                from: from.into(),
                to: to.into(),
                new: stamp,
                old: is_there.then_some(old),
            }],
            outdated: vec![("../scene.bin".into(), old)],
        };
        let note = note_path(&inner.join(MAIN));
        fs::write(&note, serde_json::to_vec(&plan).expect("a text")).expect("a writable folder");
        let why = plan.finish(&inner, &Access::everywhere()).expect_err(to);
        assert!(why.contains("in another folder"), "{why}");
        finish_set(&inner.join(MAIN)).expect("nothing was begun");
        assert!(!note.exists() && !absolute.exists() && shop.path("scene.bin").exists());
        assert!(inner.join("own.txt").exists());
        fs::write(&part, "evil").expect("a writable folder");
    }
}

#[test]
fn notes_of_others_tell_nothing_of_what_may_not_be_read() {
    let shop = Shop::new();
    let inner = shop.path("inner");
    fs::create_dir(&inner).expect("a writable folder");
    let secret = shop.path("scene.bin");
    let stamp = Stamp::of(&secret).expect("it is there");
    let other = Stamp { length: 77, ..stamp };
    let access = Access::within([inner.clone()]);
    let message = |from: &Path, to: &Path, new: Stamp| {
        let plan = Plan {
            files: vec![Rename {
                from: from.to_owned(),
                to: to.to_owned(),
                new,
                old: None,
            }],
            outdated: Vec::new(),
        };
        let note = note_path(&inner.join(MAIN));
        fs::write(&note, serde_json::to_vec(&plan).expect("a text")).expect("a writable folder");
        finish_set_within(&inner.join(MAIN), &access)
            .expect_err("the note is broken")
            .to_string()
    };
    let absent = shop.path("nothing");
    for new in [stamp, other] {
        assert_eq!(
            message(&secret, Path::new("x"), new),
            message(&absent, Path::new("x"), new)
        );
        let [there, missing] =
            [&secret, &absent].map(|to| message(Path::new("x"), to, new).replace(&to.display().to_string(), ""));
        assert_eq!(there, missing);
    }
}

#[test]
fn waiting_files_are_no_leftovers() {
    let shop = Shop::new();
    shop.second().replace_until(1).expect("it can be written");
    let waiting = finish_all(shop.0.path());
    assert!(waiting.is_empty() && shop.is(SECOND, "second"));
    // A set that cannot be completed keeps its files.
    let shop = Shop::new();
    shop.second().replace_until(1).expect("it can be written");
    fs::write(shop.path(MAIN), "the user's own").expect("a writable folder");
    let waiting = finish_all(shop.0.path());
    assert_eq!(waiting.len(), 3);
    // One temporary file has been renamed.
    assert_eq!(waiting.iter().filter(|path| path.exists()).count(), 2);
}

#[test]
fn nothing_stays_of_a_set_of_which_nothing_can_be_renamed() {
    let shop = Shop::new();
    let set = shop.second();
    // This file is the first of the set.
    fs::create_dir(shop.path("scene-files/b.ply")).expect("a writable folder");
    let error = set.replace().expect_err("a folder is there");
    assert_eq!(error.path, shop.path("scene-files/b.ply"));
    assert!(shop.is(FIRST, "first"), "{:?}", shop.content());
    shop.finish().expect("there is nothing to finish");
    // The same if the program was killed before that rename failed.
    fs::remove_dir(shop.path("scene-files/b.ply")).expect("it is empty");
    shop.second().replace_until(0).expect("it can be written");
    fs::write(shop.path("scene-files/b.ply"), "first").expect("a writable folder");
    shop.finish().expect("nothing was begun");
    fs::remove_file(shop.path("scene-files/b.ply")).expect("it is there");
    assert!(shop.is(FIRST, "first"), "{:?}", shop.content());
}

#[test]
fn a_rename_that_fails_later_is_mended() {
    let shop = Shop::new();
    let set = shop.second();
    fs::remove_file(shop.path("scene.bin")).expect("it is there");
    fs::create_dir(shop.path("scene.bin")).expect("a writable folder");
    let error = set.replace().expect_err("a folder is there");
    assert_eq!(error.path, shop.path("scene.bin"));
    let source = error.source.to_string();
    assert!(
        source.contains("what opens or writes") && source.contains(MAIN),
        "{source}"
    );
    let before = shop.content();
    shop.finish().expect_err("the folder is there still");
    assert_eq!(shop.content(), before);
    fs::remove_dir(shop.path("scene.bin")).expect("it is empty");
    shop.finish().expect("it can be finished");
    assert!(shop.is(SECOND, "second"), "{:?}", shop.content());
}

#[test]
fn a_set_with_a_file_elsewhere_is_finished_or_left_alone() {
    let shop = Shop::new();
    fs::create_dir(shop.path("level")).expect("a writable folder");
    // Files other than the main one are renamed in the order in which they were added.
    let names = ["level/near.xml", "far.xml", "level/main.xml"];
    let main = shop.path(names[2]);
    let stopped = |stop: usize| {
        for name in names {
            fs::write(shop.path(name), "first").expect("a writable folder");
        }
        let mut set = FileSet::new(&main);
        for name in names {
            set.add(&shop.path(name), "second").expect("it can be written");
        }
        set.replace_until(stop).expect("it can be written");
        let outcome = finish_set(&main).map_err(|error| error.to_string());
        let read = |name: &str| fs::read_to_string(shop.path(name)).expect("it is there");
        (outcome, names.map(read))
    };
    // Nothing was renamed: the old files can be read, and no temporary files are left.
    let (outcome, read) = stopped(0);
    outcome.expect("nothing was begun");
    assert_eq!(read, ["first"; 3]);
    let left = fs::read_dir(shop.path("level")).expect("it is there").count();
    assert_eq!(left, 2);
    let (outcome, _) = stopped(1);
    let message = outcome.expect_err("half of the set is replaced");
    assert!(message.contains("in another folder"), "{message}");
    let (outcome, read) = stopped(2);
    outcome.expect("the rest is in the folder");
    assert_eq!(read, ["second"; 3]);
}

#[test]
fn a_note_that_is_being_worked_on_is_waited_for() {
    let shop = Shop::new();
    shop.second().replace_until(1).expect("it can be written");
    let file = File::open(shop.note()).expect("it is there");
    file.lock().expect("nobody else has it");
    let main = shop.path(MAIN);
    let reader = std::thread::spawn(move || finish_set(&main).map_err(|error| error.to_string()));
    std::thread::sleep(Duration::from_millis(20));
    assert!(!reader.is_finished());
    drop(file);
    reader.join().expect("no panic").expect("it can be finished");
    assert!(shop.is(SECOND, "second"));
}

#[test]
fn nothing_is_replaced_if_one_file_cannot_be() {
    let shop = Shop::new();
    fs::create_dir(shop.path("folder")).expect("a writable folder");
    let long = "a".repeat(300);
    for name in ["folder", "absent/b.ply", &long] {
        let mut set = FileSet::new(&shop.path(MAIN));
        set.add(&shop.path(MAIN), "second").expect("it can be written");
        let error = set.add(&shop.path(name), "second").expect_err(name);
        assert_eq!(error.path, shop.path(name));
        drop(set);
        assert!(shop.is(FIRST, "first"), "{:?}", shop.content());
    }
}
