//! Finds the mesh or picture that a file of this dialect names, and whether an OBJ brings its own materials.

use std::collections::{HashMap, VecDeque};
use std::ffi::OsString;
use std::io::{BufRead, BufReader};
use std::path::{Path, PathBuf};

use super::import::Import;
use crate::document::paths::settle;
use crate::document::source::MAX_FILE_BYTES;
use crate::files::Access;

/// The most files that a search by file name looks at.
const MOST_FILES: usize = 5000;
/// The most lines of an OBJ that are searched for a material.
const MOST_LINES: usize = 10_000_000;

impl Import<'_> {
    /// The folder of the scene file, absolute.
    pub fn folder(&self) -> PathBuf {
        settle(self.path).parent().unwrap_or(Path::new("/")).to_owned()
    }
}

/// The files below the folders of a scene by their names, the nearest first.
pub type FilesBelow = HashMap<OsString, Vec<PathBuf>>;

impl Import<'_> {
    /// Finds a file beside the scene, in the `assets` folders above it and above where the program was started, then anywhere below these by its
    /// file name alone: an absolute name is often one of its author's machine.
    pub fn find_file(&mut self, name: &str) -> Option<PathBuf> {
        let name = Path::new(name.trim());
        if name.as_os_str().is_empty() {
            return None;
        }
        let access = self.access;
        let folders = self.folders();
        // Joining an absolute name gives that name.
        let places: Vec<PathBuf> = folders.iter().map(|folder| folder.join(name)).collect();
        let direct = places.iter().find(|path| access.covers(path) && path.is_file());
        let found = direct.cloned().or_else(|| {
            let below = self.below.get_or_insert_with(|| files_below(&folders, access));
            let same = below.get(name.file_name()?)?;
            same.iter().find(|path| access.covers(path)).cloned()
        });
        if found.is_none() {
            // The result is not needed: `access` remembers the places.
            access.find(&places);
        }
        Some(settle(&found?))
    }

    /// The folder of the scene and the `assets` folders.
    fn folders(&self) -> Vec<PathBuf> {
        let folder = self.folder();
        let started_in = std::env::current_dir().unwrap_or_default();
        let above = folder.ancestors().chain(started_in.ancestors());
        let assets: Vec<PathBuf> = above
            .map(|folder| folder.join("assets"))
            .filter(|folder| folder.is_dir())
            .collect();
        let mut folders = vec![folder];
        for folder in assets {
            if !folders.contains(&folder) {
                folders.push(folder);
            }
        }
        folders
    }
}

/// The files in and below those of the folders that may be read.
fn files_below(folders: &[PathBuf], access: &Access) -> FilesBelow {
    let mut found = FilesBelow::new();
    let mut seen = 0;
    for folder in folders.iter().filter(|folder| access.covers(folder)) {
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
                    return found;
                }
                // Links to folders may form a circle.
                if path.is_symlink() && path.is_dir() {
                    continue;
                }
                if path.is_dir() {
                    waiting.push_back(path);
                } else if let Some(name) = path.file_name() {
                    found.entry(name.to_owned()).or_default().push(path);
                }
            }
        }
    }
    found
}

/// Whether an OBJ uses materials of a library that is there.
pub fn has_own_materials(path: &Path, access: &Access) -> bool {
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
