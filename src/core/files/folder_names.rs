//! Caches the names in folders, for a search of many files in the same folders.

use std::collections::{HashMap, HashSet};
use std::io::ErrorKind;
use std::path::{Path, PathBuf};

use super::Access;

/// How often files are sought singly in a folder before it is listed: for a few files listing would take longer.
const SOUGHT_SINGLY: u32 = 4;
/// The most names of a folder that are cached. In larger folders every file is sought by itself.
const MOST_NAMES: usize = 100_000;

/// The cached folders, each listed at most once: later changes are not seen.
#[derive(Debug, Default)]
pub struct FolderNames(HashMap<PathBuf, Folder>);

#[derive(Debug)]
enum Folder {
    /// Not listed yet, with the number of files sought in it.
    Unlisted(u32),
    /// Its names in lower case, since some file systems ignore case.
    Listed(HashSet<String>),
    /// It cannot be listed, or has too many names.
    Unknown,
}

impl FolderNames {
    /// Whether a file may exist at this path. False only if there is certainly none. Folders that `access` refuses are
    /// not listed.
    pub fn may_have(&mut self, path: &Path, access: &Access) -> bool {
        let (Some(parent), Some(name)) = (path.parent(), path.file_name().and_then(|name| name.to_str())) else {
            return true;
        };
        if !access.covers(path) {
            return true;
        }
        // File systems disagree on how non-ASCII letters are encoded.
        if !name.is_ascii() {
            return true;
        }
        if !self.0.contains_key(parent) {
            self.0.insert(parent.to_owned(), Folder::Unlisted(0));
        }
        let Some(folder) = self.0.get_mut(parent) else {
            return true;
        };
        if let Folder::Unlisted(times) = folder {
            *times += 1;
            if *times <= SOUGHT_SINGLY {
                return true;
            }
            *folder = listed(parent);
        }
        match folder {
            Folder::Listed(names) => names.contains(&name.to_ascii_lowercase()),
            Folder::Unlisted(_) | Folder::Unknown => true,
        }
    }
}

fn listed(path: &Path) -> Folder {
    let entries = match path.read_dir() {
        Ok(entries) => entries,
        Err(error) if matches!(error.kind(), ErrorKind::NotFound | ErrorKind::NotADirectory) => {
            return Folder::Listed(HashSet::new());
        }
        Err(_) => return Folder::Unknown,
    };
    let mut names = HashSet::new();
    for entry in entries {
        let Ok(entry) = entry else { return Folder::Unknown };
        if names.len() >= MOST_NAMES {
            return Folder::Unknown;
        }
        names.extend(entry.file_name().to_str().map(str::to_ascii_lowercase));
    }
    Folder::Listed(names)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_file_that_is_there_may_be_there_however_often_others_were_sought() {
        let folder = tempfile::tempdir().unwrap();
        for name in ["a.ply", "B.ply", "größe.ply"] {
            std::fs::write(folder.path().join(name), "").unwrap();
        }
        let mut names = FolderNames::default();
        let mut may_have = |path: &Path| names.may_have(path, &Access::everywhere());
        for number in 0..20 {
            let absent = folder.path().join(format!("{number}.ply"));
            assert_eq!(may_have(&absent), number < SOUGHT_SINGLY, "{number}");
            let in_nothing = folder.path().join(format!("none/{number}.ply"));
            assert_eq!(may_have(&in_nothing), number < SOUGHT_SINGLY, "{number}");
        }
        for name in ["a.ply", "B.ply", "b.ply", "größe.ply", ".."] {
            assert!(may_have(&folder.path().join(name)), "{name}");
        }
        assert!(may_have(Path::new("/")));
    }

    #[test]
    fn folders_that_are_refused_are_not_listed() {
        let folder = tempfile::tempdir().unwrap();
        let path = |name: &str| folder.path().join(name);
        for name in ["scene", "other"] {
            std::fs::create_dir(path(name)).unwrap();
        }
        let access = Access::within([path("scene")]);
        let mut names = FolderNames::default();
        for number in 0..20 {
            assert!(
                names.may_have(&path(&format!("other/{number}.ply")), &access),
                "{number}"
            );
            let inside = names.may_have(&path(&format!("scene/{number}.ply")), &access);
            assert_eq!(inside, number < SOUGHT_SINGLY, "{number}");
        }
    }
}
