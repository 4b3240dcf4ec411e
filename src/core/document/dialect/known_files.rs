//! Cached facts about the files that a scene of this dialect names.

use std::collections::{HashMap, VecDeque};
use std::ffi::OsString;
use std::io::{BufRead, BufReader};
use std::path::{Path, PathBuf};

use crate::document::source::MAX_FILE_BYTES;
use crate::files::Access;

/// The most files that a search by file name looks at.
const MOST_FILES: usize = 5000;
/// The most lines of an OBJ that are searched for a material.
const MOST_LINES: usize = 10_000_000;

/// Cached facts about files: a scene may name the same file, or a missing one, any number of times.
#[derive(Default)]
pub struct KnownFiles {
    /// The files below the searched folders by name, the nearest first. None before the first search.
    below: Option<HashMap<OsString, Vec<PathBuf>>>,
    /// For each OBJ whether it uses materials of its own library.
    own_materials: HashMap<PathBuf, bool>,
}

impl KnownFiles {
    /// The files in and below the folders by name, the nearest first. The folders are the same at every call.
    pub fn below(&mut self, folders: &[PathBuf]) -> &HashMap<OsString, Vec<PathBuf>> {
        self.below.get_or_insert_with(|| files_below(folders))
    }

    /// Whether an OBJ uses materials of an existing library.
    pub fn has_own_materials(&mut self, path: PathBuf, access: &Access) -> bool {
        let known = self.own_materials.entry(path);
        *known.or_insert_with_key(|path| has_own_materials(path, access))
    }
}

/// The files in and below the folders by name, the nearest first.
fn files_below(folders: &[PathBuf]) -> HashMap<OsString, Vec<PathBuf>> {
    let mut files: HashMap<OsString, Vec<PathBuf>> = HashMap::new();
    let mut seen = 0;
    for folder in folders {
        let mut waiting = VecDeque::from([folder.clone()]);
        while let Some(folder) = waiting.pop_front() {
            let Ok(entries) = std::fs::read_dir(&folder) else {
                continue;
            };
            let mut paths: Vec<PathBuf> = entries.flatten().map(|entry| entry.path()).collect();
            paths.sort();
            for path in paths {
                seen += 1;
                if seen > MOST_FILES {
                    return files;
                }
                // Links to folders may form a cycle.
                if path.is_symlink() && path.is_dir() {
                    continue;
                }
                if path.is_dir() {
                    waiting.push_back(path);
                } else if let Some(name) = path.file_name() {
                    files.entry(name.to_owned()).or_default().push(path);
                }
            }
        }
    }
    files
}

/// Whether an OBJ uses materials of an existing library.
fn has_own_materials(path: &Path, access: &Access) -> bool {
    let Ok(file) = access.open(path, MAX_FILE_BYTES) else {
        return false;
    };
    let folder = path.parent().unwrap_or(Path::new(""));
    let (mut has_library, mut uses_one) = (false, false);
    for line in BufReader::new(file).split(b'\n').take(MOST_LINES) {
        let Ok(line) = line else { return false };
        let line = String::from_utf8_lossy(&line);
        let line = line.trim();
        if let Some(names) = line.strip_prefix("mtllib") {
            let library = folder.join(names.trim());
            has_library |= access.covers(&library) && library.is_file();
        }
        uses_one |= line.strip_prefix("usemtl").is_some_and(|name| !name.trim().is_empty());
        if has_library && uses_one {
            return true;
        }
    }
    false
}
