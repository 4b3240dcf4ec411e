//! Holds the directions between the modules: who may use whom, and where Bevy is known.
//!
//! Reads the sources as text: every path that begins with `crate::`, in `use` lines or elsewhere, and every name of a
//! Bevy crate. Comments and a file's closing `mod tests` are left out: a test may compare two sides that do not know
//! each other. The rooms of the editor and of the scene have tables of their own in `rooms`. The links of the
//! documentation, which are read as text too, are held by `pages`.

mod imports;
mod pages;
mod recipes;
mod rooms;

use std::fs;
use std::path::{Path, PathBuf};

/// The root of the repository.
const ROOT: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../..");

/// What a module may use besides itself, and whether it may know Bevy. The longest matching name holds for a file, so
/// that a folder can have more rights than the one around it. A module that is not in the table is a violation.
const RULES: &[(&str, &[&str], bool)] = &[
    ("names", &[], false),
    ("math", &[], false),
    ("files", &[], false),
    ("memory", &["files"], false),
    ("color", &["math"], false),
    ("layer", &[], false),
    ("sampling", &["math"], false),
    ("geometry", &["math", "color", "memory", "sampling"], false),
    ("accel", &["math", "color", "sampling", "geometry"], false),
    ("photometry", &[], false),
    ("inverse_lighting", &["color", "photometry", "sampling"], false),
    (
        "texture",
        &["math", "color", "memory", "sampling", "geometry", "photometry"],
        false,
    ),
    ("shading", BELOW_SHADING, false),
    (
        "material",
        &["math", "color", "sampling", "geometry", "accel", "texture", "shading"],
        false,
    ),
    ("light", BELOW_SHADING, false),
    ("medium", &["math", "color", "sampling", "memory"], false),
    ("metrics", &["math", "color"], false),
    ("render", &["KERNEL", "files"], false),
    ("document", &["math", "color", "files"], false),
    (
        "gltf",
        &[
            "math",
            "color",
            "files",
            "memory",
            "geometry",
            "photometry",
            "texture",
            "document",
        ],
        false,
    ),
    ("bake", &["KERNEL", "files", "gltf"], false),
    ("meter", &["KERNEL", "bake"], false),
    ("scene", &["math", "color", "layer", "files", "document"], true),
    (
        "scene/assets",
        &[
            "math",
            "color",
            "layer",
            "files",
            "memory",
            "document",
            "geometry",
            "gltf",
            "photometry",
            "texture",
            "medium",
        ],
        true,
    ),
    ("scene/components/atmosphere", &["light"], true),
    ("scene/components/solid", &["geometry"], true),
    (
        "scene/export",
        &[
            "math",
            "color",
            "files",
            "memory",
            "document",
            "geometry",
            "gltf",
            "photometry",
            "texture",
            "shading",
        ],
        true,
    ),
    ("engine", &["KERNEL", "document", "scene"], true),
    (
        "app",
        &[
            "KERNEL", "bake", "meter", "files", "document", "gltf", "scene", "engine",
        ],
        true,
    ),
    // The program on top of the library: there everything goes.
    (
        "cli",
        &[
            "KERNEL", "bake", "meter", "files", "document", "gltf", "scene", "engine", "app",
        ],
        true,
    ),
    ("main", &["KERNEL", "document", "scene", "engine", "app", "cli"], true),
];

const BELOW_SHADING: &[&str] = &[
    "math",
    "color",
    "sampling",
    "geometry",
    "accel",
    "texture",
    "photometry",
];

/// `"KERNEL"` in the table stands for these and `render`.
const KERNEL: &[&str] = &[
    "math",
    "memory",
    "color",
    "sampling",
    "geometry",
    "accel",
    "photometry",
    "texture",
    "shading",
    "material",
    "light",
    "medium",
    "layer",
    "metrics",
    "inverse_lighting",
];

fn may_use(allowed: &[&str], module: &str) -> bool {
    allowed.contains(&module) || (allowed.contains(&"KERNEL") && (KERNEL.contains(&module) || module == "render"))
}

/// The folder of `sunroom-core` in `src`. Its modules are named without it, as `crate::` names them in both packages.
const CORE: &str = "core/";

/// The sources by their names in `crate::`: below `src` or `src/core`, with `/`.
fn named_sources() -> Vec<(String, String)> {
    let root = Path::new(ROOT).join("src");
    let mut files = Vec::new();
    sources(&root, &mut files);
    files.sort();
    let named = files.iter().map(|path| {
        let relative = path.strip_prefix(&root).expect("found inside").to_string_lossy();
        let relative = relative.replace('\\', "/");
        let text = fs::read_to_string(path).expect("the sources are text");
        (relative.strip_prefix(CORE).unwrap_or(&relative).to_owned(), text)
    });
    // The crate roots only name the modules.
    named.filter(|(file, _)| file != "lib.rs").collect()
}

/// What is wrong with a file, as `line: what`. `file` is named as in `named_sources`.
fn violations(file: &str, text: &str) -> Vec<String> {
    let name = file.trim_end_matches(".rs");
    let own = name.split('/').next().unwrap_or(name);
    let covers = |rule: &str| name == rule || name.strip_prefix(rule).is_some_and(|rest| rest.starts_with('/'));
    let rule = RULES
        .iter()
        .filter(|rule| covers(rule.0))
        .max_by_key(|rule| rule.0.len());
    let Some((_, allowed, bevy)) = rule else {
        return vec![format!("1: `{own}` is not in the table of layers")];
    };
    let code = code_of(text);
    let mut found = Vec::new();
    for (line, module) in crate_paths(&code) {
        if module != own && !may_use(allowed, &module) {
            found.push(format!("{line}: `{own}` must not use `{module}`"));
        }
    }
    if !bevy {
        let lines = code.lines().zip(1..).filter(|(line, _)| names_bevy(line));
        found.extend(lines.map(|(_, number)| format!("{number}: `{own}` must not know Bevy")));
    }
    found
}

/// The lines without comments, up to the closing tests.
fn code_of(text: &str) -> String {
    let mut code = String::new();
    let mut lines = text.lines().peekable();
    while let Some(line) = lines.next() {
        if line == "#[cfg(test)]" && lines.peek().is_some_and(|next| next.starts_with("mod tests {")) {
            break;
        }
        code.push_str(line.split("//").next().unwrap_or_default());
        code.push('\n');
    }
    code
}

fn is_word(c: char) -> bool {
    c.is_alphanumeric() || c == '_'
}

/// Line and first name of each `crate::name`, and of each name in `crate::{name::.., name}`.
fn crate_paths(code: &str) -> Vec<(usize, String)> {
    let mut found = Vec::new();
    for (at, _) in code.match_indices("crate::") {
        if code[..at].ends_with(|c| is_word(c) || c == '$') {
            continue;
        }
        let path = &code[at + "crate::".len()..];
        let line = 1 + code[..at].matches('\n').count();
        let mut depth = 0;
        // At the start, and in the outermost braces after each comma, a name begins.
        let mut begins = true;
        let mut rest = path;
        while let Some(c) = rest.chars().next() {
            let word = rest.find(|c| !is_word(c)).unwrap_or(rest.len());
            if word > 0 {
                if begins {
                    found.push((line, rest[..word].to_owned()));
                }
                begins = false;
                rest = &rest[word..];
                if depth == 0 {
                    break;
                }
                continue;
            }
            match c {
                '{' => depth += 1,
                '}' => depth -= 1,
                ',' => begins = depth == 1,
                _ => {}
            }
            if depth == 0 {
                break;
            }
            rest = &rest[c.len_utf8()..];
        }
    }
    found
}

fn names_bevy(line: &str) -> bool {
    let mut words = line.split(|c| !is_word(c));
    words.any(|word| word == "bevy" || word.starts_with("bevy_"))
}

fn sources(folder: &Path, into: &mut Vec<PathBuf>) {
    for entry in fs::read_dir(folder).expect("the sources are there") {
        let path = entry.expect("the sources are readable").path();
        if path.is_dir() {
            sources(&path, into);
        } else if path.extension().is_some_and(|extension| extension == "rs") {
            into.push(path);
        }
    }
}

/// Folders in which no files import each other in a circle.
const WITHOUT_CIRCLES: [&str; 15] = [
    "memory/",
    "geometry/",
    "accel/",
    "texture/",
    "shading/",
    "material/",
    "light/",
    "render/lanes/",
    "render/denoise",
    "document/",
    "gltf/",
    "bake/",
    "scene/",
    "engine/",
    "cli/",
];

#[test]
fn results_lie_below_the_code_that_produces_them() {
    let all = rooms::all_sources();
    for folder in WITHOUT_CIRCLES {
        let imports = all.imports(folder);
        // Were the reading broken, nothing would be found at all.
        assert!(imports.values().any(|imported| !imported.is_empty()), "{folder}");
        let found = imports::circles(&imports);
        assert!(found.is_empty(), "{folder}: {found:?}");
    }
}

#[test]
fn sources_keep_the_directions() {
    let files = named_sources();
    let mut found = Vec::new();
    let mut paths = 0;
    for (file, text) in &files {
        paths += crate_paths(&code_of(text)).len();
        found.extend(violations(file, text).into_iter().map(|what| format!("{file}:{what}")));
    }
    assert!(found.is_empty(), "\n{}", found.join("\n"));
    // Were the reading broken, nothing would be found at all.
    assert!(paths > 50, "only {paths} paths in {} files", files.len());
}

/// How a file can be opened for reading past `crate::files`, each with what may follow it all the same.
const OPENINGS: [(&str, &[&str]); 6] = [
    ("File::open", &[]),
    // Appending alone reads nothing.
    ("File::options()", &[".create(true).append(true)"]),
    ("ImageReader::open", &[]),
    ("fs::read", &["_dir", "_link"]),
    ("OpenOptions", &[]),
    ("image::open", &[]),
];

/// What opens files by itself, as `line: what`.
fn openings(file: &str, text: &str) -> Vec<String> {
    if file.starts_with("files/") {
        return Vec::new();
    }
    let code = code_of(text);
    let opening = |line: &str| {
        OPENINGS.iter().find(|(opening, allowed)| {
            let mut places = line.match_indices(opening);
            places.any(|(at, _)| {
                let (before, after) = (&line[..at], &line[at + opening.len()..]);
                !before.ends_with(is_word) && !allowed.iter().any(|allowed| after.starts_with(allowed))
            })
        })
    };
    // What the system says of the process is no file of the user.
    let lines = code.lines().zip(1..).filter(|(line, _)| !line.contains("\"/proc/"));
    lines
        .filter_map(|(line, number)| Some(format!("{number}: `{}`: use `crate::files`", opening(line)?.0)))
        .collect()
}

#[test]
fn files_are_opened_in_one_place() {
    let mut found = Vec::new();
    for (file, text) in named_sources() {
        found.extend(openings(&file, &text).into_iter().map(|what| format!("{file}:{what}")));
    }
    assert!(found.is_empty(), "\n{}", found.join("\n"));
}

/// The comments wider than 120 columns, as line numbers. Rows of tables cannot be broken.
fn wide_comments(text: &str) -> Vec<usize> {
    let lines = text.lines().zip(1..);
    let is_wide = |line: &str| {
        let words = line.trim_start().trim_start_matches(['/', '!']);
        line.chars().count() > 120 && words.len() < line.trim_start().len() - 1 && !words.trim_start().starts_with('|')
    };
    lines
        .filter(|(line, _)| is_wide(line))
        .map(|(_, number)| number)
        .collect()
}

#[test]
fn comments_have_at_most_120_columns() {
    let mut found = Vec::new();
    for (file, text) in named_sources() {
        found.extend(wide_comments(&text).into_iter().map(|line| format!("{file}:{line}")));
    }
    assert!(found.is_empty(), "\n{}", found.join("\n"));
    let long = "word ".repeat(24);
    assert_eq!(wide_comments(&format!("let a = 1;\n    /// {long}\n")), [2]);
    assert!(wide_comments(&format!("/// | {long} |\nlet a = \"{long}\";\n")).is_empty());
}

#[test]
fn openings_of_files_are_found() {
    for line in [
        "let file = std::fs::File::open(path)?;",
        "    bytes = std::fs::read(&path)?;",
        "    texts.map(fs::read_to_string)",
        "let file = OpenOptions::new().read(true).open(path);",
        "let picture = image::open(path)?;",
        "let picture = ImageReader::open(path)?.decode()?;",
        "let file = File::options().read(true).open(path)?;",
    ] {
        assert_eq!(openings("scene/mod.rs", line).len(), 1, "{line}");
        assert!(openings("files/reading.rs", line).is_empty(), "{line}");
    }
    assert!(openings("scene/mod.rs", "SerializedFile::open(&bytes)?").is_empty());
    let entries = "for entry in fs::read_dir(folder)? { fs::read_link(entry)?; } // not fs::read";
    assert!(openings("scene/mod.rs", entries).is_empty());
    assert!(
        openings(
            "scene/mod.rs",
            "File::options().create(true).append(true).open(marker)?"
        )
        .is_empty()
    );
}

#[test]
fn bad_lines_are_found() {
    let cases = [
        ("render/film.rs", "use crate::scene::Shape;"),
        ("render/denoise/ffi.rs", "use crate::document::Document;"),
        ("scene/shape.rs", "use crate::render::film::Film;"),
        ("scene/shape.rs", "use crate::accel::Tlas;"),
        ("scene/shape.rs", "use crate::geometry::MeshData;"),
        ("scene/assets/mesh.rs", "use crate::engine::Dirty;"),
        ("document/parse.rs", "use crate::scene::Shape;"),
        ("math/ray.rs", "use crate::color::Rgb;"),
        ("color.rs", "fn f() -> crate::light::Light { todo!() }"),
        ("geometry/mesh.rs", "use crate::{math::Ray, accel::{Tlas, Blas}};"),
        (
            "geometry/mesh.rs",
            "use crate::{\n    math::{Aabb, Ray},\n    render,\n};",
        ),
        ("accel/tlas.rs", "pub(in crate::render) fn f() {}"),
        ("engine/mod.rs", "use crate::app::App;"),
        ("light/mod.rs", "use crate::shading::Bsdf;"),
        ("render/tile.rs", "use bevy::prelude::*;"),
        ("math/mod.rs", "let v: bevy_math::Vec3 = x;"),
        ("document/mod.rs", "    use bevy as b;"),
        ("extras/mod.rs", "fn nothing() {}"),
        ("math.rs", "use crate::nowhere::Thing;"),
    ];
    for (file, text) in cases {
        assert_eq!(
            violations(file, text).len(),
            1,
            "{file}: {text}: {:?}",
            violations(file, text)
        );
    }
    let two = violations("math/ray.rs", "\nuse crate::{render, math, color as c};");
    assert_eq!(
        two,
        ["2: `math` must not use `render`", "2: `math` must not use `color`"]
    );
}

#[test]
fn good_lines_pass() {
    let cases = [
        (
            "render/film.rs",
            "use crate::{accel::Tlas, light::{self, Light}, render::scene::RenderScene};",
        ),
        (
            "render/film.rs",
            "//! Knows nothing of [`crate::scene`] or bevy.\nlet x = 1; // crate::scene",
        ),
        (
            "render/film.rs",
            "#[cfg(test)]\nmod tests {\n    use crate::document::Document;\n}",
        ),
        ("scene/shape.rs", "use bevy::prelude::*;\nuse crate::document::Value;"),
        (
            "scene/assets/mesh.rs",
            "use crate::geometry::MeshData;\nuse crate::scene::Status;",
        ),
        (
            "engine/extract.rs",
            "use crate::render::film::Film;\nuse crate::scene::Shape;",
        ),
        (
            "app/editor/window/ui.rs",
            "use crate::engine::Control;\nuse bevy_egui::egui;",
        ),
        ("main.rs", "use crate::cli::Cli;"),
        ("math/ray.rs", "$crate::render!(); mycrate::render(); abbevyation::x();"),
    ];
    for (file, text) in cases {
        assert_eq!(violations(file, text), Vec::<String>::new(), "{file}: {text}");
    }
}
