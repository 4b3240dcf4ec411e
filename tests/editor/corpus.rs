//! Replays the corpus of the editor's parsers, and seeded mutations of it, as `tests/core/fuzz_corpus.rs` does for the kernel's. See
//! `fuzz/README.md`.

use std::path::Path;

use crate::editor_entries::ENTRIES;
use crate::replay::{Input, files, mutations, run};

/// Of each entry's corpus in an ordinary test run; the variable `MUTATIONS` sets another number.
const MUTATIONS: usize = 300;

/// Of the entry that the variable `PARSER` names, or else of all.
fn for_each_entry(inputs: impl Fn(Vec<Input>) -> Vec<Input>) {
    let wanted = std::env::var("PARSER").ok();
    for (name, entry) in ENTRIES {
        if wanted.as_ref().is_some_and(|wanted| wanted != name) {
            continue;
        }
        let corpus = files(&Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/corpus").join(name));
        assert!(!corpus.is_empty(), "there is no corpus for {name}");
        run(entry, inputs(corpus));
    }
}

#[test]
fn the_corpus_breaks_no_parser_of_the_editor() {
    for_each_entry(|corpus| corpus);
}

#[test]
fn mutations_of_the_corpus_break_no_parser_of_the_editor() {
    let wanted = std::env::var("MUTATIONS").ok();
    let count = wanted.map_or(MUTATIONS, |number| number.parse().expect("MUTATIONS is a number"));
    for_each_entry(|corpus| mutations(&corpus, count, 23));
}
