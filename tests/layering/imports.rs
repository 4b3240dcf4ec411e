//! Which file imports which, read from the sources as text, and the circles that such imports form.

use std::collections::{BTreeMap, BTreeSet};

/// A path that a file names, from the crate's root on, with its line.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Named {
    pub line: usize,
    pub path: Vec<String>,
    /// `pub use`: others may name it by way of this file.
    pub is_passed_on: bool,
}

/// What sources name of their own crate, by their names relative to `src`, with `/`.
pub struct Sources {
    modules: BTreeMap<Vec<String>, String>,
    named: BTreeMap<String, Vec<Named>>,
    passed_on: PassedOn,
}

/// By module and name, the paths of what `pub use` passes on.
type PassedOn = BTreeMap<(Vec<String>, String), Vec<String>>;

impl Sources {
    /// `files`: their names and texts, without comments and tests.
    pub fn new(files: impl IntoIterator<Item = (String, String)>) -> Self {
        let files: BTreeMap<String, String> = files.into_iter().collect();
        let modules = files.keys().map(|file| (module(file), file.clone())).collect();
        let named = |(file, code): (&String, &String)| (file.clone(), named(&module(file), code, &modules));
        let named = files.iter().map(named).collect();
        Self {
            passed_on: passed_on(&named),
            named,
            modules,
        }
    }

    pub fn files(&self) -> impl Iterator<Item = &String> {
        self.named.keys()
    }

    /// What a file names of this crate, in `use` lines and elsewhere.
    pub fn named(&self, file: &str) -> &[Named] {
        self.named.get(file).map_or(&[], Vec::as_slice)
    }

    /// The files that each file of a folder imports from there. Passing on what is in one's own folder is no import.
    pub fn imports(&self, folder: &str) -> BTreeMap<String, BTreeSet<String>> {
        let mut all = BTreeMap::new();
        for (file, named) in self.named.iter().filter(|(file, _)| file.starts_with(folder)) {
            let own = module(file);
            let imported = named
                .iter()
                .filter(|named| !(named.is_passed_on && named.path.starts_with(&own)));
            let targets = imported.filter_map(|named| self.declaring_file(&named.path));
            let others = targets.filter(|target| target != file && target.starts_with(folder));
            all.insert(file.clone(), others.collect());
        }
        all
    }

    /// The file in which what a path names is declared; None for a path to no file of these.
    pub fn declaring_file(&self, path: &[String]) -> Option<String> {
        declaring_file(path, &self.modules, &self.passed_on, 0)
    }
}

fn passed_on(files: &BTreeMap<String, Vec<Named>>) -> PassedOn {
    let mut all = BTreeMap::new();
    for (file, named) in files {
        for named in named.iter().filter(|named| named.is_passed_on) {
            if let Some(name) = named.path.last() {
                all.insert((module(file), name.clone()), named.path.clone());
            }
        }
    }
    all
}

/// The module that a file is.
fn module(file: &str) -> Vec<String> {
    let name = file.trim_end_matches(".rs").trim_end_matches("/mod");
    name.split('/').map(str::to_owned).collect()
}

fn declaring_file(
    path: &[String],
    modules: &BTreeMap<Vec<String>, String>,
    passed_on: &PassedOn,
    depth: usize,
) -> Option<String> {
    let (length, file) = (1..=path.len())
        .rev()
        .find_map(|length| Some((length, modules.get(&path[..length])?)))?;
    let further = path
        .get(length)
        .and_then(|name| passed_on.get(&(path[..length].to_vec(), name.clone())));
    match further {
        Some(further) if depth < 5 => declaring_file(further, modules, passed_on, depth + 1),
        _ => Some(file.clone()),
    }
}

/// What the code of a module names of its crate.
fn named(own: &[String], code: &str, modules: &BTreeMap<Vec<String>, String>) -> Vec<Named> {
    let mut found = Vec::new();
    for spelled in spelled_paths(code) {
        let absolute = match spelled.path[0].as_str() {
            "crate" => Some(spelled.path[1..].to_vec()),
            "self" => Some([own, &spelled.path[1..]].concat()),
            "super" => {
                let ups = spelled.path.iter().take_while(|part| *part == "super").count();
                let base = own.len().checked_sub(ups);
                base.map(|base| [&own[..base], &spelled.path[ups..]].concat())
            }
            child => {
                let is_child = modules.contains_key(&[own, &[child.to_owned()]].concat());
                is_child.then(|| [own, &spelled.path[..]].concat())
            }
        };
        found.extend(absolute.map(|path| Named { path, ..spelled }));
    }
    found
}

fn is_word(c: char) -> bool {
    c.is_alphanumeric() || c == '_'
}

/// The paths of code as they are spelled: those of `use` lines, with their braces taken apart, and those of two parts
/// and more elsewhere.
fn spelled_paths(code: &str) -> Vec<Named> {
    let mut found = Vec::new();
    let (mut at, mut line, mut counted) = (0, 1, 0);
    while let Some(start) = code[at..].find(|c: char| is_word(c)).map(|start| at + start) {
        let length = code[start..].find(|c| !is_word(c)).unwrap_or(code.len() - start);
        line += code[counted..start].matches('\n').count();
        counted = start;
        if &code[start..start + length] == "use" && code[start + length..].starts_with(' ') {
            let end = code[start..].find(';').map_or(code.len(), |end| start + end);
            let before = code[..start].rsplit(['\n', ';', '}']).next().unwrap_or_default();
            let is_passed_on = before.trim_start().starts_with("pub");
            let spaceless: String = code[start + length..end]
                .split_whitespace()
                .collect::<Vec<_>>()
                .join(" ");
            for path in branches(&spaceless) {
                found.push(Named {
                    line,
                    path,
                    is_passed_on,
                });
            }
            at = end;
            continue;
        }
        let spelled = code[start..]
            .find(|c| !is_word(c) && c != ':')
            .unwrap_or(code.len() - start);
        let parts: Vec<&str> = code[start..start + spelled].split("::").collect();
        let is_first = !code[..start].ends_with([':', '$', '\'']);
        let is_visibility = code[..start].ends_with("pub(in ");
        if is_first && !is_visibility && parts.len() > 1 && parts.iter().all(|part| !part.contains(':')) {
            let named = parts.iter().filter(|part| !part.is_empty());
            found.push(Named {
                line,
                path: named.map(|part| (*part).to_owned()).collect(),
                is_passed_on: false,
            });
        }
        at = start + spelled.max(1);
    }
    found
}

/// The paths of a `use` tree; `self` at the end of one is left out, and so are new names.
fn branches(tree: &str) -> Vec<Vec<String>> {
    let Some((head, rest)) = tree.split_once('{') else {
        let path = tree.split(" as ").next().unwrap_or_default();
        let parts = path.split("::").map(str::trim).filter(|part| !part.is_empty());
        let mut parts: Vec<String> = parts.map(str::to_owned).collect();
        if parts.len() > 1 && parts.last().is_some_and(|last| last == "self") {
            parts.pop();
        }
        return if parts.is_empty() { Vec::new() } else { vec![parts] };
    };
    let inner = rest.rsplit_once('}').map_or(rest, |(inner, _)| inner);
    let mut depth = 0;
    let parts = inner.split(|c| {
        depth += match c {
            '{' => 1,
            '}' => -1,
            _ => 0,
        };
        c == ',' && depth == 0
    });
    let whole = parts.filter(|part| !part.trim().is_empty());
    whole
        .flat_map(|part| branches(&format!("{head}{}", part.trim())))
        .collect()
}

/// The groups of files of which each imports each other, on whatever way; the largest first.
pub fn circles(imports: &BTreeMap<String, BTreeSet<String>>) -> Vec<Vec<String>> {
    let reach = |from: &String| {
        let mut seen = BTreeSet::new();
        let mut next = vec![from];
        while let Some(file) = next.pop() {
            let targets = imports.get(file).into_iter().flatten();
            next.extend(targets.filter(|target| seen.insert((*target).clone())));
        }
        seen
    };
    let reached: BTreeMap<&String, BTreeSet<String>> = imports.keys().map(|file| (file, reach(file))).collect();
    let mut done = BTreeSet::new();
    let mut found = Vec::new();
    for (file, targets) in &reached {
        if !targets.contains(*file) || done.contains(*file) {
            continue;
        }
        let circle: Vec<String> = targets
            .iter()
            .filter(|target| reached.get(target).is_some_and(|back| back.contains(*file)))
            .cloned()
            .collect();
        done.extend(circle.iter().cloned());
        found.push(circle);
    }
    found.sort_by_key(|circle| std::cmp::Reverse(circle.len()));
    found
}
