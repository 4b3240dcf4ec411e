//! Runs entries on the corpus and on seeded mutations of it, for ordinary tests: `entries.rs` says what an entry is.

use std::fs;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::Path;
use std::sync::mpsc::{RecvTimeoutError, channel};
use std::time::Duration;

use crate::split_mix::Random;

/// An input that takes longer counts as endless. The slowest one needs a thousandth of this on an idle machine.
const LONGEST: Duration = Duration::from_secs(100);

/// An input with a name that says where it came from.
pub type Input = (String, Vec<u8>);

/// The files of a folder in the order of their names.
pub fn files(folder: &Path) -> Vec<Input> {
    let entries = fs::read_dir(folder).unwrap_or_else(|error| panic!("{}: {error}", folder.display()));
    let mut paths: Vec<_> = entries.flatten().map(|entry| entry.path()).collect();
    paths.sort();
    let input = |path: &std::path::PathBuf| {
        let bytes = fs::read(path).unwrap_or_else(|error| panic!("{}: {error}", path.display()));
        (path.display().to_string(), bytes)
    };
    paths.iter().map(input).collect()
}

/// So many mutations of the inputs. The same seed always gives the same ones.
pub fn mutations(inputs: Vec<Input>, count: usize, seed: u64) -> impl Iterator<Item = Input> + Send + 'static {
    let mut random = Random(seed);
    (0..count).map(move |number| {
        let (name, bytes) = random.one_of(&inputs);
        let mut bytes = bytes.clone();
        for _ in 0..1 + random.below(4) {
            random.mutate(&mut bytes, &inputs);
        }
        (format!("mutation {number} (seed {seed}) of {name}"), bytes)
    })
}

/// The number that a variable holds, or else the usual one.
pub fn number_of(variable: &str, usual: u64) -> u64 {
    let given = std::env::var(variable).ok();
    given.map_or(usual, |number| {
        number.parse().unwrap_or_else(|_| panic!("{variable} is no number"))
    })
}

/// Whether the variable `PARSER` names this entry, or none.
pub fn is_wanted(name: &str) -> bool {
    std::env::var("PARSER").map_or(true, |wanted| wanted == name)
}

/// Runs the entry on each input. Panics if one of them makes it panic, or runs for ever.
pub fn run(entry: impl Fn(&[u8]) + Send + 'static, inputs: impl IntoIterator<Item = Input> + Send + 'static) {
    let (begin, begun) = channel();
    let worker = std::thread::spawn(move || {
        let mut broken = Vec::new();
        for (name, bytes) in inputs {
            // Fails only after the receiver gave up.
            let _ = begin.send(name.clone());
            if let Err(panic) = catch_unwind(AssertUnwindSafe(|| entry(&bytes))) {
                let message = panic.downcast_ref::<String>().map(String::as_str);
                let message = message.or(panic.downcast_ref::<&str>().copied()).unwrap_or_default();
                broken.push(format!("{name}: {message}\n  {}", excerpt(&bytes)));
            }
        }
        broken
    });
    let mut current = String::new();
    loop {
        match begun.recv_timeout(LONGEST) {
            Ok(name) => current = name,
            Err(RecvTimeoutError::Disconnected) => break,
            Err(RecvTimeoutError::Timeout) => panic!("{current}: no end after {LONGEST:?}"),
        }
    }
    let broken = worker.join().expect("panics were caught");
    assert!(broken.is_empty(), "{} inputs:\n{}", broken.len(), broken.join("\n"));
}

/// Enough of the bytes to make a file of, if there are not too many.
fn excerpt(bytes: &[u8]) -> String {
    bytes[..bytes.len().min(4000)].escape_ascii().to_string()
}

impl Random {
    /// Changes the bytes at one place.
    fn mutate(&mut self, bytes: &mut Vec<u8>, others: &[Input]) {
        if bytes.is_empty() {
            bytes.push(self.next() as u8);
            return;
        }
        let place = self.below(bytes.len());
        let end = (place + 1 + self.below(32)).min(bytes.len());
        match self.below(9) {
            0 => bytes[place] ^= 1 << self.below(8),
            1 => bytes[place] = *self.one_of(b"\0\x01\x7f\x80\xff <>/\"'=&;$\\#%:,.-+0179eEnx\n\r\t{}[]"),
            2 => drop(bytes.drain(place..end)),
            3 => {
                let copy = bytes[place..end].to_vec();
                let target = self.below(bytes.len());
                bytes.splice(target..target, copy);
            }
            4 => bytes.truncate(place + 1),
            5 => {
                let word = *self.one_of(&[
                    0,
                    1,
                    u32::MAX,
                    1 << 31,
                    i32::MAX as u32,
                    0x7f80_0000,
                    0x7fc0_0000,
                    1 << 24,
                ]);
                let word = if self.below(2) == 0 {
                    word.to_le_bytes()
                } else {
                    word.to_be_bytes()
                };
                let length = word.len().min(bytes.len() - place);
                bytes[place..place + length].copy_from_slice(&word[..length]);
            }
            6 => {
                // A number of the text becomes another.
                const NUMBERS: [&str; 14] = [
                    "0",
                    "-1",
                    "1e38",
                    "-1e38",
                    "1e-45",
                    "1e999",
                    "nan",
                    "inf",
                    "2147483648",
                    "4294967295",
                    "65536",
                    "9223372036854775807",
                    "18446744073709551616",
                    "0.5",
                ];
                let is_part = |byte: &u8| byte.is_ascii_digit() || b".-+".contains(byte);
                if let Some(start) = bytes[place..].iter().position(is_part).map(|after| place + after) {
                    let length = bytes[start..].iter().take_while(|byte| is_part(byte)).count();
                    bytes.splice(start..start + length, self.one_of(&NUMBERS).bytes());
                }
            }
            7 => {
                let (_, other) = self.one_of(others);
                let from = self.below(other.len());
                let to = (from + 1 + self.below(64)).min(other.len());
                bytes.splice(place..place, other[from.min(to)..to].iter().copied());
            }
            _ => bytes[place] = self.next() as u8,
        }
    }
}
