//! Files that belong together and are replaced together: a level with its lightmaps, a glTF file with its buffer, a
//! scene with its meshes.

use std::collections::BTreeMap;

use sunroom::files::finish_set;

use crate::killed::is_killed;
use crate::program::{SCENE, Workshop};
use crate::table::{Row, section};

section! { "Files that belong together"
    level_is_half_written:
        "Killed while `sunroom bake` writes over an older level.",
        "Nothing; the program is gone.",
        "The older level with its lightmaps, and files `.sunroom-….part`, removed as above.";
    disk_is_full_for_a_level:
        "The disk becomes full while `sunroom bake` writes over an older level.",
        "`error: cannot write …lightmap-0.…: File too large`, exit code 1.",
        "The older level with its lightmaps, no temporary file.";
    gltf_is_half_written:
        "Killed while `sunroom convert` writes a `.gltf` file with its buffer over older ones.",
        "Nothing; the program is gone.",
        "The older files, and files `.sunroom-….part`, removed as above.";
    disk_is_full_for_a_gltf:
        "The disk becomes full while `sunroom convert` writes a `.gltf` file with its buffer over older ones.",
        "`error: …new.gltf: File too large`, exit code 1.",
        "The older files, no temporary file.";
    scene_with_meshes_is_half_written:
        "Killed while `sunroom convert` writes a scene with meshes over an older one.",
        "Nothing; the program is gone.",
        "The older files, and files `.sunroom-….part`, removed as above.";
    disk_is_full_for_a_scene_with_meshes:
        "The disk becomes full while `sunroom convert` writes a scene with meshes over an older one.",
        "`error: …new.xml: File too large`, exit code 1.",
        "The older files, no temporary file.";
    manual_is_half_written:
        "The disk becomes full while `sunroom man` writes its pages.",
        "`error: cannot write …: File too large`, exit code 1.",
        "Nothing new: there are no empty pages.";
    set_is_killed_among_its_renames:
        "Killed after all new files are written, while they are put in the place of the old ones, at any of the renames.",
        "Nothing; the program is gone.",
        "Older files, newer ones and a file `.sunroom-….set`. Who opens the scene, or writes it or the level again, gets the newer files and no others.";
    set_is_changed_after_the_kill:
        "As before, and somebody changes one of the files before the scene is opened.",
        "`…new.gltf: is one of several files that were being replaced together when the program ended: new.gltf was changed since; write them again, or remove ….set to keep the files as they are`, exit code 1.",
        "What was there. Exporting it again replaces all of it.";
    buffer_is_of_another_export:
        "A `.gltf` file of Sunroom's lies beside the buffer of another export, as after a copy that was broken off.",
        "`the file of buffer 0 is not the one that was written with this file`, exit code 1.",
        "Nothing new.";
}

/// What the files of a folder hold, but those of the scene and of writes.
fn files(shop: &Workshop, folder: &str) -> BTreeMap<String, Vec<u8>> {
    let entries = std::fs::read_dir(shop.path(folder))
        .expect("the folder is there")
        .flatten();
    let names = entries
        .filter(|entry| entry.path().is_file())
        .map(|entry| entry.file_name());
    let names = names.map(|name| name.to_string_lossy().into_owned());
    let content = |name: String| {
        (
            name.clone(),
            std::fs::read(shop.path(folder).join(name)).expect("a file"),
        )
    };
    names
        .filter(|name| !name.starts_with(".sunroom-"))
        .map(content)
        .collect()
}

/// The names of the temporary files and notes in a folder.
fn left_behind(shop: &Workshop, folder: &str) -> Vec<String> {
    let names = shop.names(folder).into_iter();
    names.filter(|name| name.starts_with(".sunroom-")).collect()
}

/// A command that writes a set of files to the folder `out`, with two scenes of which it makes other files.
struct Set {
    shop: Workshop,
    arguments: Vec<&'static str>,
}

/// A scene with a wall of this length, which is as long a text for every length. It has lights enough to be longer than
/// the mesh of the wall.
fn scene(length: char) -> String {
    let lights = r#"<emitter type="point"><rgb name="intensity" value="1, 1, 1"/></emitter>"#.repeat(30);
    let panel = format!(
        r#"<shape type="wall"><float name="length" value="{length}"/></shape>
  <shape type="rectangle"><transform name="to_world"><translate x="{length}"/></transform></shape>
  {lights}</scene>"#
    );
    SCENE.replace("</scene>", &panel)
}

impl Set {
    fn new(arguments: &[&'static str]) -> Self {
        let set = Self {
            shop: Workshop::new(),
            arguments: arguments.to_vec(),
        };
        std::fs::create_dir(set.shop.path("out")).expect("a temporary folder");
        set
    }

    fn bake() -> Self {
        Self::new(&[
            "bake",
            "scene.xml",
            "-o",
            "out",
            "--spp",
            "2",
            "--no-denoise",
            "--atlas-size",
            "64",
            "--no-probes",
        ])
    }

    fn gltf() -> Self {
        Self::new(&["convert", "scene.xml", "out/new.gltf"])
    }

    fn scene() -> Self {
        Self::new(&["convert", "scene.xml", "out/new.xml"])
    }

    /// The file that names the others.
    fn main(&self) -> std::path::PathBuf {
        match self.arguments[0] {
            "bake" => self.shop.path("out/lightmaps.json"),
            _ => self.shop.path(self.arguments[2]),
        }
    }

    /// Writes the files of a scene, and returns them.
    #[track_caller]
    fn write(&self, length: char) -> BTreeMap<String, Vec<u8>> {
        self.shop.write("scene.xml", scene(length));
        let output = self.shop.run(&[], &self.arguments);
        let said = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(0), "{said}");
        assert_eq!(left_behind(&self.shop, "out"), [""; 0]);
        files(&self.shop, "out")
    }

    /// Files of two scenes, of which the older ones are in the folder.
    fn two(&self) -> [BTreeMap<String, Vec<u8>>; 2] {
        let newer = self.write('3');
        let older = self.write('2');
        assert!(older.len() > 1 && older.keys().eq(newer.keys()));
        assert!(older.iter().all(|(name, content)| newer.get(name) != Some(content)));
        self.shop.write("scene.xml", scene('3'));
        [older, newer]
    }

    /// Has the folder as it was.
    fn restore(&self, files: &BTreeMap<String, Vec<u8>>) {
        std::fs::remove_dir_all(self.shop.path("out")).expect("it is there");
        std::fs::create_dir(self.shop.path("out")).expect("a temporary folder");
        for (name, content) in files {
            self.shop.write(&format!("out/{name}"), content);
        }
    }

    /// Writes the newer files with this limit for their length. The older ones stay.
    fn is_not_written(&self, before: &[&str]) -> std::process::Output {
        let [older, _] = self.two();
        let output = self.shop.run(before, &self.arguments);
        assert!(files(&self.shop, "out") == older);
        // Nothing is left to do.
        finish_set(&self.main()).expect("there is no note");
        assert!(files(&self.shop, "out") == older);
        output
    }

    fn is_half_written(&self, before: &[&str]) {
        is_killed(&self.is_not_written(before));
        let left = left_behind(&self.shop, "out");
        // The first was whole, and the second was not.
        assert!(
            left.len() >= 2 && left.iter().all(|name| name.ends_with(".part")),
            "{left:?}"
        );
    }

    fn finds_the_disk_full(&self, row: &Row, before: &[&str]) {
        row.holds(&self.is_not_written(before));
        assert_eq!(left_behind(&self.shop, "out"), [""; 0]);
    }
}

/// Words that let files have this length in bytes. What writes more is killed, or finds the disk full.
fn limited(length: usize, kills: bool) -> Vec<String> {
    let signal = if kills {
        "--default-signal=XFSZ"
    } else {
        "--ignore-signal=XFSZ"
    };
    let limit = format!("--fsize={length}");
    ["env", signal, "prlimit", "--core=0", &limit]
        .map(str::to_owned)
        .to_vec()
}

fn words(words: &[String]) -> Vec<&str> {
    words.iter().map(String::as_str).collect()
}

/// The length of the level, which is shorter than its lightmaps.
fn length_of_level(set: &Set) -> usize {
    let files = set.write('3');
    let length = files["level.glb"].len();
    assert!(files.values().any(|content| content.len() > length + 100));
    length + 50
}

fn level_is_half_written(_: &Row) {
    let set = Set::bake();
    let before = limited(length_of_level(&set), true);
    set.is_half_written(&words(&before));
}

fn disk_is_full_for_a_level(row: &Row) {
    let set = Set::bake();
    let before = limited(length_of_level(&set), false);
    set.finds_the_disk_full(row, &words(&before));
}

fn gltf_is_half_written(_: &Row) {
    let set = Set::gltf();
    let length = set.write('3')["new.bin"].len();
    set.is_half_written(&words(&limited(length, true)));
}

fn disk_is_full_for_a_gltf(row: &Row) {
    let set = Set::gltf();
    let length = set.write('3')["new.bin"].len();
    set.finds_the_disk_full(row, &words(&limited(length, false)));
}

fn scene_with_meshes_is_half_written(_: &Row) {
    let set = Set::scene();
    let length = length_of_meshes(&set);
    set.is_half_written(&words(&limited(length, true)));
}

fn disk_is_full_for_a_scene_with_meshes(row: &Row) {
    let set = Set::scene();
    let length = length_of_meshes(&set);
    set.finds_the_disk_full(row, &words(&limited(length, false)));
}

/// The length of the longest mesh; the scene is longer.
fn length_of_meshes(set: &Set) -> usize {
    let files = set.write('3');
    let meshes = files.iter().filter(|(name, _)| *name != "new.xml");
    let longest = meshes.map(|(_, content)| content.len()).max().expect("a mesh");
    assert!(files["new.xml"].len() > longest);
    longest
}

fn manual_is_half_written(row: &Row) {
    let shop = Workshop::new();
    std::fs::create_dir(shop.path("pages")).expect("a temporary folder");
    let before = limited(3000, false);
    row.holds(&shop.run(&words(&before), &["man", "pages"]));
    assert_eq!(shop.names("pages"), [""; 0]);
    assert_eq!(shop.run(&[], &["man", "pages"]).status.code(), Some(0));
    let pages = files(&shop, "pages");
    assert!(pages.len() > 5 && pages.values().any(|page| page.len() > 3000));
    assert!(pages.contains_key("sunroom.1") && pages.contains_key("sunroom-render.1"));
}

/// Whether `strace` can kill a program at a system call here.
fn has_strace() -> bool {
    let found = std::process::Command::new("strace")
        .args(["-f", "-o", "/dev/null", "true"])
        .status();
    let is_there = found.is_ok_and(|status| status.success());
    if !is_there {
        println!("skipped: needs `strace`");
    }
    is_there
}

/// Runs the command and kills it at this rename or removal, counted from 1. Returns whether it was.
fn kill_at(set: &Set, call: usize) -> bool {
    // Not every machine has all of them.
    let calls = "?rename,?renameat,?renameat2,?unlink,?unlinkat";
    let inject = format!("inject={calls}:signal=KILL:when={call}");
    let trace = format!("trace={calls}");
    let strace = ["strace", "-f", "-qq", "-o", "/dev/null", "-e", &trace, "-e", &inject];
    let output = set.shop.run(&strace, &set.arguments);
    let is_killed = output.status.code() != Some(0);
    let said = String::from_utf8_lossy(&output.stderr);
    assert!(!is_killed || !said.contains("error"), "{said}");
    is_killed
}

fn set_is_killed_among_its_renames(_: &Row) {
    if !has_strace() {
        return;
    }
    for set in [Set::bake(), Set::gltf(), Set::scene()] {
        let [older, newer] = set.two();
        let (mut mixed, mut call) = (0, 0);
        loop {
            call += 1;
            assert!(call < 100, "it always ends before");
            if !kill_at(&set, call) {
                break;
            }
            let left = files(&set.shop, "out");
            let has_note = left_behind(&set.shop, "out").iter().any(|name| name.ends_with(".set"));
            let is_mixed = left != older && left != newer;
            mixed += u32::from(is_mixed);
            assert!(has_note || !is_mixed, "nobody can notice a kill at call {call}");
            finish_set(&set.main()).expect("it can be finished");
            let finished = files(&set.shop, "out");
            assert!(
                finished == if has_note { newer.clone() } else { older.clone() },
                "call {call}"
            );
            assert!(!left_behind(&set.shop, "out").iter().any(|name| name.ends_with(".set")));
            set.restore(&older);
        }
        // A kill before each rename but the first.
        assert!(mixed as usize >= older.len() - 1, "{mixed} {:?}", set.arguments);
        assert!(files(&set.shop, "out") == newer);
    }
}

/// A `.gltf` file with its buffer, killed after the buffer was replaced.
fn half_replaced() -> Option<Set> {
    if !has_strace() {
        return None;
    }
    let set = Set::gltf();
    let [older, newer] = set.two();
    for call in 1..100 {
        if !kill_at(&set, call) {
            break;
        }
        let left = files(&set.shop, "out");
        if left != older && left != newer {
            return Some(set);
        }
        set.restore(&older);
    }
    panic!("it was never killed in between");
}

fn set_is_changed_after_the_kill(row: &Row) {
    let Some(set) = half_replaced() else { return };
    let text = std::fs::read_to_string(set.main()).expect("it is there");
    set.shop.write("out/new.gltf", text + "\n");
    let before = files(&set.shop, "out");
    row.holds(&set.shop.run(&[], &["check", "out/new.gltf"]));
    assert!(files(&set.shop, "out") == before);
    set.write('3');
    assert_eq!(set.shop.run(&[], &["check", "out/new.gltf"]).status.code(), Some(0));
}

fn buffer_is_of_another_export(row: &Row) {
    let set = Set::gltf();
    let [_, newer] = set.two();
    set.shop.write("out/new.bin", &newer["new.bin"]);
    row.holds(&set.shop.run(&[], &["check", "out/new.gltf"]));
    // Other programs keep what they do not know, and write buffers of their own.
    let text = std::fs::read_to_string(set.main()).expect("it is there");
    set.shop.write(
        "out/new.gltf",
        text.replace("\"Sunroom ", "\"Another program after Sunroom "),
    );
    assert_eq!(set.shop.run(&[], &["check", "out/new.gltf"]).status.code(), Some(0));
    // The reader finds what a killed program has left.
    if let Some(set) = half_replaced() {
        assert_eq!(set.shop.run(&[], &["check", "out/new.gltf"]).status.code(), Some(0));
        assert_eq!(left_behind(&set.shop, "out"), [""; 0]);
    }
}
