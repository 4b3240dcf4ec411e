//! Holds the links between the pages: every file that a page of the documentation links to exists, and so does every
//! heading. So does every source file that a page names.

use std::collections::HashSet;
use std::fs;
use std::path::{Path, PathBuf};

use super::{ROOT, sources};

/// Folders with pages, without those inside them.
const FOLDERS: [&str; 4] = ["", "docs", "benches", "fuzz"];

/// The lines of a page outside of code blocks.
fn prose(page: &str) -> impl Iterator<Item = (usize, &str)> {
    let mut is_code = false;
    (1..).zip(page.lines()).filter(move |(_, line)| {
        let is_fence = line.trim_start().starts_with("```");
        is_code ^= is_fence;
        !is_fence && !is_code
    })
}

/// The anchors of a page's headings, as forges make them: in lower case, without punctuation, with hyphens for blanks.
fn anchors(page: &str) -> HashSet<String> {
    let headings = prose(page).filter_map(|(_, line)| {
        line.trim_start_matches('#')
            .strip_prefix(' ')
            .filter(|_| line.starts_with('#'))
    });
    let anchor = |heading: &str| {
        let kept = heading
            .trim()
            .chars()
            .filter(|c| c.is_alphanumeric() || " -_".contains(*c));
        kept.collect::<String>().to_lowercase().replace(' ', "-")
    };
    headings.map(anchor).collect()
}

/// Line and target of each link and each picture.
fn links(page: &str) -> Vec<(usize, &str)> {
    let mut found = Vec::new();
    for (number, line) in prose(page) {
        let targets = line
            .match_indices("](")
            .filter_map(|(at, _)| line[at + 2..].split(')').next());
        found.extend(targets.map(|target| (number, target)));
    }
    found
}

/// The links of a page that lead nowhere. `path` is the page's file, from which its links start.
fn broken(path: &Path, page: &str) -> Vec<String> {
    let folder = path.parent().unwrap_or(Path::new(""));
    let leads_somewhere = |target: &str| {
        let (file, anchor) = target.split_once('#').unwrap_or((target, ""));
        let place = if file.is_empty() {
            path.to_owned()
        } else {
            folder.join(file)
        };
        let has_anchor = || match file {
            "" => anchors(page).contains(anchor),
            _ => fs::read_to_string(&place).is_ok_and(|page| anchors(&page).contains(anchor)),
        };
        (file.is_empty() || place.exists()) && (anchor.is_empty() || has_anchor())
    };
    let internal = links(page).into_iter().filter(|(_, target)| !target.contains("://"));
    let lost = internal.filter(|(_, target)| !leads_somewhere(target));
    lost.map(|(line, target)| format!("{}:{line}: {target}", path.display()))
        .collect()
}

fn pages() -> Vec<PathBuf> {
    let root = Path::new(ROOT);
    let entries = FOLDERS
        .iter()
        .filter_map(|folder| fs::read_dir(root.join(folder)).ok())
        .flatten();
    let files = entries.map(|entry| entry.expect("the folder can be read").path());
    files
        .filter(|path| path.extension().is_some_and(|extension| extension == "md"))
        .collect()
}

#[test]
fn links_between_pages_lead_somewhere() {
    let mut lost = Vec::new();
    let mut count = 0;
    for path in pages() {
        let page = fs::read_to_string(&path).expect("pages are text");
        count += links(&page).len();
        lost.extend(broken(&path, &page));
    }
    assert!(lost.is_empty(), "\n{}", lost.join("\n"));
    // Were the reading broken, nothing would be found at all.
    assert!(count > 40, "only {count} links");
}

#[test]
fn broken_links_are_found() {
    let page = "# A *page* (`x`)\n[a](Cargo.toml) [b](#a-page-x) [c](https://example.org/nowhere)\n```\n[d](nothing)\n# none\n```\n";
    let path = Path::new(ROOT).join("page.md");
    assert_eq!(broken(&path, page), [""; 0]);
    for link in ["nothing.md", "#none", "README.md#no-such-heading"] {
        let page = format!("{page}![e]({link})\n");
        assert_eq!(broken(&path, &page), [format!("{}:7: {link}", path.display())]);
    }
}

/// The source files that a page names in backticks. Placeholders are in capitals.
fn named_sources(page: &str) -> impl Iterator<Item = (usize, &str)> {
    let is_source = |name: &&str| {
        name.ends_with(".rs")
            && name
                .chars()
                .all(|c| c.is_ascii_lowercase() || "0123456789_/.".contains(c))
    };
    let words =
        prose(page).flat_map(|(number, line)| line.split('`').skip(1).step_by(2).map(move |word| (number, word)));
    words.filter(move |(_, word)| is_source(word))
}

#[test]
fn source_files_that_pages_name_exist() {
    let mut files = Vec::new();
    for folder in ["src", "tests", "benches", "examples", "crates", "fuzz"] {
        sources(&Path::new(ROOT).join(folder), &mut files);
    }
    let exists = |name: &str| files.iter().any(|file| file.ends_with(name)) || Path::new(ROOT).join(name).exists();
    let (mut lost, mut count) = (Vec::new(), 0);
    for path in pages() {
        let page = fs::read_to_string(&path).expect("pages are text");
        for (line, name) in named_sources(&page) {
            count += 1;
            if !exists(name) {
                lost.push(format!("{}:{line}: {name}", path.display()));
            }
        }
    }
    assert!(lost.is_empty(), "\n{}", lost.join("\n"));
    assert!(count > 100, "only {count} names");
    assert!(!exists("render/nothing.rs") && exists("engine/extract.rs"));
}
