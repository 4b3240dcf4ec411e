//! Replays the corpus of the editor's parsers, and seeded mutations of it, as `tests/core/fuzz_corpus.rs` does for the
//! kernel's. See `fuzz/README.md`.

use std::path::Path;

use crate::editor_entries::ENTRIES;
use crate::replay::{Input, files, is_wanted, mutations, number_of, run};

/// Of each entry's corpus in an ordinary test run; the variable `MUTATIONS` sets another number, and `SEED` other
/// mutations.
const MUTATIONS: u64 = 300;

/// Calls this with each entry and its corpus: those of the entry that the variable `PARSER` names, or else of all.
fn for_each_entry(run: impl Fn(fn(&[u8]), Vec<Input>)) {
    for (name, entry) in ENTRIES.into_iter().filter(|(name, _)| is_wanted(name)) {
        let corpus = files(&Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/corpus").join(name));
        assert!(!corpus.is_empty(), "there is no corpus for {name}");
        run(entry, corpus);
    }
}

#[test]
fn the_corpus_breaks_no_parser_of_the_editor() {
    for_each_entry(run);
}

#[test]
fn mutations_of_the_corpus_break_no_parser_of_the_editor() {
    let (count, seed) = (number_of("MUTATIONS", MUTATIONS), number_of("SEED", 23));
    for_each_entry(|entry, corpus| run(entry, mutations(corpus, count as usize, seed)));
}
