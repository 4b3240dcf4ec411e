//! Replays the corpus of the fuzz targets, and seeded mutations of it: no parser breaks its promises. See
//! `fuzz/README.md`.

use std::path::Path;

use crate::ROOT;

#[path = "../../fuzz/entries.rs"]
pub mod entries;
#[path = "../../fuzz/replay.rs"]
mod replay;

use entries::{ENTRIES, Entry};
use replay::{Input, files, is_wanted, mutations, number_of, run};

/// Mutations of each entry's corpus in an ordinary test run; the variable `MUTATIONS` sets another number, and `SEED`
/// other mutations.
const MUTATIONS: u64 = 1000;

fn corpus(name: &str) -> Vec<Input> {
    files(&Path::new(ROOT).join("tests/corpus").join(name))
}

/// Calls this with each entry and its corpus: those of the entry that the variable `PARSER` names, or else of all.
fn for_each_entry(run: impl Fn(Entry, Vec<Input>)) {
    for (name, entry) in ENTRIES.into_iter().filter(|(name, _)| is_wanted(name)) {
        let corpus = corpus(name);
        assert!(!corpus.is_empty(), "there is no corpus for {name}");
        run(entry, corpus);
    }
}

#[test]
fn the_corpus_breaks_no_parser() {
    for_each_entry(run);
}

/// Some entries leave most inputs aside. If they did so with all of them, they would find nothing.
#[test]
fn some_inputs_come_to_the_end_of_their_entries() {
    let entries: [(&str, fn(&[u8]) -> bool); 8] = [
        ("animation", entries::animation),
        ("media", entries::media),
        ("bake", entries::bake),
        ("part", entries::part),
        ("layered", entries::layered),
        ("includes", entries::includes),
        ("set", entries::set),
        ("manifest", entries::manifest),
    ];
    for (name, entry) in entries {
        assert!(corpus(name).iter().any(|(_, bytes)| entry(bytes)), "{name}");
    }
}

#[test]
fn mutations_of_the_corpus_break_no_parser() {
    let (count, seed) = (number_of("MUTATIONS", MUTATIONS), number_of("SEED", 19));
    for_each_entry(|entry, corpus| run(entry, mutations(corpus, count as usize, seed)));
}

/// Files that are made to be slow: where the effort grew with the square of the length, each would take a quarter of an
/// hour.
#[test]
fn large_files_take_time_in_proportion_to_their_length() {
    let dialect = |materials: &str, objects: &str| {
        format!("<Scene><Materials>{materials}</Materials><Objects>{objects}</Objects></Scene>").into_bytes()
    };
    let native = |body: &str| format!("<scene version='3.0.0'>{body}</scene>").into_bytes();
    let many = |one: &dyn Fn(usize) -> String| (0..150_000).map(one).collect::<String>();
    let digits = "9".repeat(3_000_000);
    let inputs = [
        (
            "objects of one name",
            dialect("", &many(&|_| "<Sphere name='a'/>".to_owned())),
        ),
        (
            "materials that are not there",
            dialect("", &many(&|i| format!("<Sphere material='material{i}'/>"))),
        ),
        (
            "a number of many digits",
            dialect("", &format!("<Sphere><Radius value='{digits}'/></Sphere>")),
        ),
        (
            "a comment, then objects of one id",
            native(&format!(
                "<!--{digits}--><bsdf id='a' type='b'/>{}",
                many(&|_| "<bsdf id='a' type='b'/>".to_owned())
            )),
        ),
        (
            "references to nothing",
            native(&many(&|i| format!("<bsdf id='a{i}' type='b'/><ref id='b{i}'/>"))),
        ),
        (
            "folders that are not there",
            native(&many(&|i| format!("<path value='folder{i}'/>"))),
        ),
    ];
    let inputs = inputs.map(|(name, bytes)| (name.to_owned(), bytes));
    run(entries::xml, inputs);
}
