//! Holds the directions between the rooms of the editor and of the scene, which are the folders there, in the same way,
//! and keeps circles of imports small and within one room.

use super::imports::{Sources, circles};
use super::{code_of, named_sources};

/// A folder whose rooms have a table.
struct Rooms {
    folder: &'static str,
    /// The rooms from the lowest to the highest and what each may use besides itself. `mod.rs` puts them together and
    /// may use all; no room may use what is in it.
    rules: &'static [(&'static str, &'static [&'static str])],
    /// Pairs of files of which the first may use the second all the same.
    exceptions: &'static [(&'static str, &'static str)],
}

const EDITOR: Rooms = Rooms {
    folder: "app/editor/",
    exceptions: &[],
    rules: &[
        ("command", &[]),
        ("words", &[]),
        ("camera", &["command"]),
        ("input", &["command", "words"]),
        ("session", &["command", "words", "camera"]),
        ("picture", &["command", "words", "camera", "session"]),
        ("model", &["command", "words", "camera", "session", "picture"]),
        (
            "commands",
            &["command", "words", "camera", "session", "picture", "model"],
        ),
        (
            "viewport",
            &["command", "words", "camera", "input", "session", "picture", "model"],
        ),
        (
            "panels",
            &["command", "words", "camera", "input", "session", "picture", "model"],
        ),
        (
            "window",
            &[
                "command", "words", "camera", "input", "session", "picture", "model", "viewport", "panels",
            ],
        ),
        (
            "automation",
            &[
                "command", "words", "camera", "input", "session", "picture", "model", "commands", "viewport", "panels",
                "window",
            ],
        ),
    ],
};

const SCENE: Rooms = Rooms {
    folder: "scene/",
    // A scene that is read again is brought to the moment that was shown.
    exceptions: &[("scene/load/loading.rs", "scene/edits/posing.rs")],
    rules: &[
        ("components", &[]),
        ("encode", &["components"]),
        ("read", &["components", "encode"]),
        ("file", &["components", "read"]),
        ("assets", &["components", "read", "file"]),
        ("load", &["components", "file", "assets"]),
        ("export", &["components", "assets", "load"]),
        ("write", &["components", "encode", "read", "file", "assets", "load"]),
        ("edits", &["components", "encode", "read", "file", "load", "write"]),
    ],
};

/// Files of the editor that import each other in a circle, at most.
const LARGEST_CIRCLE: usize = 3;

/// The sources, without comments and tests.
pub fn all_sources() -> Sources {
    Sources::new(named_sources().into_iter().map(|(file, text)| (file, code_of(&text))))
}

impl Rooms {
    /// The room of a file or module by its path; None for those of no room.
    fn room(&self, path: &str) -> Option<&str> {
        let inside = path.strip_prefix(self.folder)?.split('/').next()?;
        let rooms = self.rules.iter().map(|(room, _)| *room);
        rooms.into_iter().find(|room| *room == inside)
    }

    /// What is wrong with a file of the folder, as `line: what`.
    fn violations(&self, all: &Sources, file: &str) -> Vec<String> {
        let Some((own, _)) = file.strip_prefix(self.folder).and_then(|inside| inside.split_once('/')) else {
            return Vec::new();
        };
        let Some((_, allowed)) = self.rules.iter().find(|(room, _)| *room == own) else {
            return vec![format!(
                "1: `{own}` is not in the table of the rooms of {}",
                self.folder
            )];
        };
        let mut found = Vec::new();
        for named in all.named(file) {
            let path = named.path.join("/");
            if !path.starts_with(self.folder) || path.ends_with('*') {
                continue;
            }
            // What `mod.rs` passes on is of the room that declares it.
            let declared = all.declaring_file(&named.path).unwrap_or_default();
            let other = self.room(&path).or_else(|| self.room(&declared)).unwrap_or(&path);
            let is_exception = self.exceptions.contains(&(file, &declared));
            if other != own && !allowed.contains(&other) && !is_exception {
                found.push(format!("{}: `{own}` must not use `{other}`", named.line));
            }
        }
        found
    }
}

/// What is wrong with the circles of imports.
fn bad_circles(all: &Sources) -> Vec<String> {
    let module = |file: &String| {
        file.strip_prefix(EDITOR.folder)
            .and_then(|file| file.split('/').next())
            .map(str::to_owned)
    };
    let mut found = Vec::new();
    for circle in circles(&all.imports(EDITOR.folder)) {
        let is_within = circle.iter().all(|file| module(file) == module(&circle[0]));
        if circle.len() > LARGEST_CIRCLE || !is_within {
            found.push(format!(
                "{} files import each other: {}",
                circle.len(),
                circle.join(", ")
            ));
        }
    }
    found
}

#[test]
fn rooms_keep_the_directions() {
    let all = all_sources();
    let mut found = Vec::new();
    for (rooms, least_files) in [(EDITOR, 100), (SCENE, 50)] {
        let (mut files, mut paths) = (0, 0);
        for file in all.files().filter(|file| file.starts_with(rooms.folder)) {
            files += 1;
            paths += all.named(file).len();
            let violations = rooms.violations(&all, file);
            found.extend(violations.into_iter().map(|what| format!("{file}:{what}")));
        }
        // Were the reading broken, nothing would be found at all.
        let imports: usize = all.imports(rooms.folder).values().map(|imported| imported.len()).sum();
        assert!(
            files > least_files && paths > 10 * least_files && imports > 5 * least_files,
            "{}: {files} files, {paths} paths, {imports} imports",
            rooms.folder
        );
    }
    found.extend(bad_circles(&all));
    assert!(found.is_empty(), "\n{}", found.join("\n"));
}

/// Every room may use rooms that stand before it in the table alone.
#[test]
fn the_tables_of_rooms_have_no_way_up() {
    for rooms in [EDITOR, SCENE] {
        for (place, (room, allowed)) in rooms.rules.iter().enumerate() {
            let before: Vec<&str> = rooms.rules[..place].iter().map(|(name, _)| *name).collect();
            assert!(allowed.iter().all(|name| before.contains(name)), "{room}");
        }
    }
}

#[test]
fn imports_against_the_directions_of_the_editor_are_found() {
    let with = |file: &str, code: &str| {
        let others = [
            "app/editor/mod.rs",
            "app/editor/command/mod.rs",
            "app/editor/window/mod.rs",
        ];
        let others = others.map(|other| (other.to_owned(), String::new()));
        let file = format!("app/editor/{file}");
        let all = Sources::new(others.into_iter().chain([(file.clone(), code.to_owned())]));
        EDITOR.violations(&all, &file).len()
    };
    for (file, code) in [
        ("command/tool.rs", "use crate::app::editor::window::ui::show_window;"),
        ("command/tool.rs", "use super::super::camera::pose;"),
        ("command/tool.rs", "pub use crate::app::editor::session::toasts;"),
        (
            "panels/render.rs",
            "use crate::app::editor::{command::Command, window::ui};",
        ),
        (
            "panels/outliner/row.rs",
            "fn f() {\n    super::super::super::viewport::viewport();\n}",
        ),
        (
            "commands/view.rs",
            "let x = crate::app::editor::panels::render::render;",
        ),
        ("model/gather.rs", "use crate::app::editor::EditorPlugin;"),
        ("tools/new.rs", "fn nothing() {}"),
    ] {
        assert_eq!(with(file, code), 1, "{file}: {code}");
    }
    for (file, code) in [
        (
            "window/ui.rs",
            "use crate::app::editor::panels::{render, status};\nuse super::sheet;",
        ),
        ("command/tool.rs", "use super::Command;\nuse crate::scene::Shape;"),
        ("session/toasts.rs", "use super::super::camera::pose::view_pose;"),
    ] {
        assert_eq!(with(file, code), 0, "{file}: {code}");
    }
}

#[test]
fn circles_are_found() {
    let bad = |files: &[(&str, &str)]| {
        let named = files
            .iter()
            .map(|(file, code)| (format!("app/editor/{file}"), (*code).to_owned()));
        bad_circles(&Sources::new(named)).len()
    };
    let ring = [
        ("command/mod.rs", "pub mod a;\nuse a::A;"),
        ("command/a.rs", "use super::b::B;"),
        ("command/b.rs", "use super::c;"),
        ("command/c.rs", "fn f(x: crate::app::editor::command::Command) {}"),
    ];
    assert_eq!(bad(&ring), 1);
    assert_eq!(bad(&ring[..3]), 0);
    // Three are borne within a module, not across two.
    assert_eq!(
        bad(&[("model/a.rs", "use super::b::B;"), ("model/b.rs", "use super::a::A;")]),
        0
    );
    let across = [
        ("model/a.rs", "use crate::app::editor::panels::b;"),
        ("panels/b.rs", "use crate::app::editor::model::a::A;"),
    ];
    assert_eq!(bad(&across), 1);
    // What is passed on is where it is declared.
    let by_way = [
        ("model/mod.rs", "pub use a::A;\nuse d::D;"),
        ("model/a.rs", "struct A;"),
        ("model/b.rs", "use super::A;"),
        ("model/c.rs", "use super::b::B;"),
        ("model/d.rs", "use super::c::C;"),
    ];
    assert_eq!(bad(&by_way), 0);
    let back = [
        by_way[0],
        ("model/a.rs", "use super::D;"),
        by_way[2],
        by_way[3],
        by_way[4],
    ];
    assert_eq!(bad(&back), 1);
}
