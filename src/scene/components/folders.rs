//! Folders, which are the prefixes of names before slashes, and free folders for copies of groups.

use std::collections::{HashMap, HashSet};

use super::free_name::free_name;

/// The paths of all folders in these names.
pub(crate) fn folders_of(names: &HashSet<String>) -> HashSet<String> {
    let outer = |name: &String| around(name).map(str::to_owned).collect::<Vec<_>>();
    names.iter().flat_map(outer).collect()
}

/// The folders of a name, outermost first.
fn around(name: &str) -> impl Iterator<Item = &str> {
    name.match_indices('/').map(move |(end, _)| &name[..end])
}

/// Finds folders for copies of groups.
#[derive(Debug, Default)]
pub(crate) struct FreeFolders {
    /// The names in the scene; None until a group is copied.
    taken: Option<HashSet<String>>,
    /// The folder of the latest copy of each folder, from which the next free one is found quickly.
    latest: HashMap<String, String>,
    /// The copied folders, each with its present copy.
    copies: HashMap<String, String>,
}

impl FreeFolders {
    /// Finds a free folder for a copy of each of these folders. `names` gives the names in the scene, and is called at
    /// the first copy only.
    pub fn find(&mut self, mut names: impl FnMut() -> HashSet<String>, copied: impl IntoIterator<Item = String>) {
        for folder in copied {
            let taken = self.taken.get_or_insert_with(|| folders_of(&names()));
            let latest = self.latest.get(&folder).unwrap_or(&folder);
            let free = free_name(taken, latest);
            taken.insert(free.clone());
            self.latest.insert(folder.clone(), free.clone());
            self.copies.insert(folder, free);
        }
    }

    /// The name inside the copy of the outermost copied folder; None if it is in none.
    pub fn in_copy(&self, name: &str) -> Option<String> {
        around(name).find_map(|folder| {
            let copy = self.copies.get(folder)?;
            Some(format!("{copy}{}", &name[folder.len()..]))
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn copies_of_a_group_are_in_free_folders() {
        let names = ["house/room/ball", "house/", "house-2/", "ball"].map(str::to_owned);
        let names = HashSet::from(names);
        let mut folders = FreeFolders::default();
        for copy in ["house-3", "house-4"] {
            folders.find(|| names.clone(), ["house/room".to_owned(), "house".to_owned()]);
            assert_eq!(folders.in_copy("house/room/ball"), Some(format!("{copy}/room/ball")));
            assert_eq!(folders.in_copy("house/"), Some(format!("{copy}/")));
            assert_eq!(folders.in_copy("house-2/"), None);
        }
    }
}
