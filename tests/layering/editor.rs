//! Holds the directions between the modules of the editor in the same way, and keeps circles of imports small and
//! within one module.

use super::imports::{Sources, circles};
use super::{code_of, named_sources};

/// The folder of the editor, with its modules from the lowest to the highest and what each may use besides itself.
/// `mod.rs` puts them together and may use all; no module may use what is in it.
const EDITOR: &str = "app/editor/";
const EDITOR_RULES: &[(&str, &[&str])] = &[
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
];

/// Files of the editor that import each other in a circle, at most.
const LARGEST_CIRCLE: usize = 3;

/// The sources, without comments and tests.
pub fn all_sources() -> Sources {
    Sources::new(named_sources().into_iter().map(|(file, text)| (file, code_of(&text))))
}

/// What is wrong with a file of the editor, as `line: what`.
fn editor_violations(all: &Sources, file: &str) -> Vec<String> {
    let Some((own, _)) = file.strip_prefix(EDITOR).and_then(|inside| inside.split_once('/')) else {
        return Vec::new();
    };
    let Some((_, allowed)) = EDITOR_RULES.iter().find(|(module, _)| *module == own) else {
        return vec![format!("1: `{own}` is not in the table of the editor's modules")];
    };
    let mut found = Vec::new();
    for named in all.named(file) {
        let [app, editor, other, ..] = &named.path[..] else {
            continue;
        };
        if (app.as_str(), editor.as_str()) == ("app", "editor") && other != own && !allowed.contains(&other.as_str()) {
            found.push(format!("{}: `{own}` must not use `{other}`", named.line));
        }
    }
    found
}

/// What is wrong with the circles of imports.
fn bad_circles(all: &Sources) -> Vec<String> {
    let module = |file: &String| {
        file.strip_prefix(EDITOR)
            .and_then(|file| file.split('/').next())
            .map(str::to_owned)
    };
    let mut found = Vec::new();
    for circle in circles(&all.imports(EDITOR)) {
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
fn modules_of_the_editor_keep_the_directions() {
    let all = all_sources();
    let (mut found, mut files, mut paths) = (Vec::new(), 0, 0);
    for file in all.files().filter(|file| file.starts_with(EDITOR)) {
        files += 1;
        paths += all.named(file).len();
        let violations = editor_violations(&all, file);
        found.extend(violations.into_iter().map(|what| format!("{file}:{what}")));
    }
    found.extend(bad_circles(&all));
    assert!(found.is_empty(), "\n{}", found.join("\n"));
    // Were the reading broken, nothing would be found at all.
    let imports: usize = all.imports(EDITOR).values().map(|imported| imported.len()).sum();
    assert!(
        files > 100 && paths > 1000 && imports > 500,
        "{files} files, {paths} paths, {imports} imports"
    );
}

/// Every module may use modules that stand before it in the table alone.
#[test]
fn the_table_of_the_editor_has_no_way_up() {
    for (place, (module, allowed)) in EDITOR_RULES.iter().enumerate() {
        let before: Vec<&str> = EDITOR_RULES[..place].iter().map(|(name, _)| *name).collect();
        assert!(allowed.iter().all(|name| before.contains(name)), "{module}");
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
        editor_violations(&all, &file).len()
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
