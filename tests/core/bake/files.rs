//! Checkpoints and shares of bakes that are damaged: each is told from a whole one, whatever is wrong with it. The fuzz
//! entry `bake` looks behind the checksum.

use std::io::Cursor;
use std::path::Path;

use sunroom_core::bake::part::{self, Part, PartError};

use crate::ROOT;

fn decode(file: &[u8]) -> Result<Part, PartError> {
    part::decode(&mut Cursor::new(file))
}

/// The files of the corpus: a checkpoint, and shares with and without probes.
fn whole() -> Vec<Vec<u8>> {
    let entries = std::fs::read_dir(Path::new(ROOT).join("tests/corpus/bake")).expect("the corpus");
    let files: Vec<Vec<u8>> = entries
        .map(|entry| std::fs::read(entry.expect("an entry").path()).expect("a file"))
        .filter(|file| decode(file).is_ok())
        .collect();
    assert!(files.len() >= 4, "whole files");
    files
}

fn summed(file: &mut [u8]) {
    // Behind the mark of a bake, and before the length and the mark of the state.
    let (content, tail) = file.split_last_chunk_mut::<20>().expect("a checksum");
    let mut sum = flate2::Crc::new();
    sum.update(&content[8..]);
    tail[..4].copy_from_slice(&sum.sum().to_le_bytes());
}

/// Every few places of a file, and all of those at its beginning.
fn places(length: usize) -> impl Iterator<Item = usize> {
    (0..length).filter(|place| *place < 600 || place % 97 == 0)
}

#[test]
fn files_that_are_cut_are_damaged() {
    for file in whole() {
        for end in places(file.len()) {
            let error = decode(&file[..end]).expect_err("it is cut");
            match end {
                ..8 => assert!(matches!(error, PartError::Foreign), "{end}: {error}"),
                _ => assert!(matches!(error, PartError::Damaged), "{end}: {error}"),
            }
        }
        let longer = [&file[..], &[0]].concat();
        assert!(matches!(decode(&longer), Err(PartError::Damaged)));
    }
}

#[test]
fn flipped_bits_are_found() {
    for file in whole() {
        for place in places(file.len()) {
            let mut flipped = file.clone();
            flipped[place] ^= 1 << (place % 8);
            let error = decode(&flipped).expect_err("a bit is another");
            let is_named = match place {
                ..8 => matches!(error, PartError::Foreign),
                8..12 => matches!(error, PartError::Format(_)),
                _ => matches!(error, PartError::Damaged),
            };
            assert!(is_named, "{place}: {error}");
        }
    }
}

/// Lengths and counts that promise more than there is, in files whose checksum is right. Memory for what they promise
/// would not be there.
#[test]
fn wrong_lengths_are_errors_and_take_no_memory() {
    for file in whole() {
        let mut refused = 0;
        for place in (12..file.len() - 8).filter(|place| *place < 9000) {
            let mut wrong = file.clone();
            wrong[place..place + 4].copy_from_slice(&[0xff, 0xff, 0xff, 0x7f]);
            summed(&mut wrong);
            match decode(&wrong) {
                Ok(_) => {}
                Err(PartError::Damaged) => refused += 1,
                Err(error) => panic!("{place}: {error}"),
            }
        }
        assert!(refused > 100, "{refused} of the places are lengths, or belong to names");
    }
}
