//! Lists a folder: its folders, and the files that the program can read.

use std::fs::{self, DirEntry};
use std::path::Path;

use crate::app::editor::command::asset_kind::AssetKind;
use crate::app::editor::model::assets::{AssetEntry, Listing};
use crate::app::editor::words::files::in_plain_words;

/// The most entries that are listed, since a folder may hold any number.
const MOST: usize = 4000;

/// The content of a folder, without hidden entries.
pub(super) fn list(folder: &Path) -> Listing {
    let mut listing = Listing {
        folder: folder.to_owned(),
        ..Listing::default()
    };
    match fs::read_dir(folder) {
        Ok(entries) => {
            let mut entries = entries.flatten().filter_map(|found| entry(&found));
            listing.entries = entries.by_ref().take(MOST).collect();
            if entries.next().is_some() {
                listing.problem = Some(format!("Only {MOST} entries of the folder are shown."));
            }
        }
        Err(error) => listing.problem = Some(in_plain_words(&format!("The folder cannot be read: {error}"))),
    }
    listing.entries.sort_by_cached_key(|entry| entry.name.to_lowercase());
    listing
}

fn entry(found: &DirEntry) -> Option<AssetEntry> {
    let path = found.path();
    let name = found
        .file_name()
        .into_string()
        .ok()
        .filter(|name| !name.starts_with('.'))?;
    // Links count as their targets.
    let about = fs::metadata(&path).ok()?;
    let kind = AssetKind::of(&path);
    let is_of_use = about.is_dir() || (about.is_file() && kind.is_some());
    is_of_use.then(|| AssetEntry {
        name,
        kind: kind.filter(|_| about.is_file()),
        bytes: if about.is_file() { about.len() } else { 0 },
        modified: about.modified().ok(),
        path,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_the_program_cannot_read_is_left_out() {
        let folder = tempfile::tempdir().expect("a temporary folder");
        for name in ["b.PNG", "a.ply", "c.txt", ".hidden.png", "sky.hdr"] {
            fs::write(folder.path().join(name), name).expect("it can be written");
        }
        fs::create_dir(folder.path().join("meshes.xml")).expect("it can be made");
        let listing = list(folder.path());
        let found = listing
            .entries
            .iter()
            .map(|entry| (entry.name.as_str(), entry.kind, entry.bytes));
        assert_eq!(
            found.collect::<Vec<_>>(),
            [
                ("a.ply", Some(AssetKind::Mesh), 5),
                ("b.PNG", Some(AssetKind::Picture), 5),
                ("meshes.xml", None, 0),
                ("sky.hdr", Some(AssetKind::Environment), 7),
            ]
        );
        assert_eq!(listing.problem, None);
        let gone = list(&folder.path().join("gone"));
        assert!(gone.entries.is_empty() && gone.problem.is_some());
    }
}
