//! The content of a folder in the file dialog.

use std::cmp::Reverse;
use std::path::{Path, PathBuf};
use std::time::UNIX_EPOCH;

use bevy::log::error;
use crossbeam_channel::{Receiver, bounded};

use crate::app::editor::words::files::{extension, in_plain_words};
use crate::app::editor::words::times::clock_of;

/// A file or a folder.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Entry {
    /// Its name, without the folder.
    pub name: String,
    /// Whether it is a folder, or a link to one.
    pub is_folder: bool,
    /// The size of a file in bytes.
    pub bytes: u64,
    /// When it was changed, in seconds since 1970.
    pub changed: u64,
}

/// The column by which entries are ordered.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Column {
    /// By name.
    #[default]
    Name,
    /// By size, the largest first.
    Size,
    /// By time of change, the newest first.
    Changed,
}

/// An order of the entries. Folders always come first.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Order {
    /// The column.
    pub column: Column,
    /// Whether the last come first.
    pub is_reversed: bool,
}

/// The filter of entries.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Filter {
    /// The extensions of shown files, in lower case; all files if it is empty.
    pub extensions: Vec<&'static str>,
    /// A part of the names of shown entries.
    pub part: String,
    /// Whether only folders are shown.
    pub only_folders: bool,
    /// Whether names that begin with a dot are shown.
    pub shows_hidden: bool,
}

/// The entries of a folder, unordered; and the problem with the folder, or that its list is incomplete.
pub type Listed = (Vec<Entry>, Option<String>);

/// The most entries that are read, since a folder may hold any number.
const MOST: usize = 20_000;

/// Begins to read a folder on a thread: a network folder may take long, and the window must not wait for it.
pub fn begin(folder: PathBuf) -> Receiver<Listed> {
    let (sender, receiver) = bounded(1);
    // The receiver is gone if another folder has been requested by then.
    let work = move || drop(sender.send(read(&folder)));
    if let Err(error) = std::thread::Builder::new().name("listing".to_owned()).spawn(work) {
        error!("A thread for the file dialog could not be started: {error}");
    }
    receiver
}

fn read(folder: &Path) -> Listed {
    let listed = match std::fs::read_dir(folder) {
        Ok(listed) => listed,
        Err(error) => {
            let problem = in_plain_words(&format!("{}: {error}", folder.display()));
            return (Vec::new(), Some(problem));
        }
    };
    let mut found = listed.filter_map(|entry| entry_of(&entry.ok()?.path()));
    let entries = found.by_ref().take(MOST).collect();
    let is_cut = found.next().is_some();
    let problem = is_cut.then(|| format!("Only {MOST} entries of the folder are listed."));
    (entries, problem)
}

/// The entry of a path, following links; None without a name. A broken link has no size.
fn entry_of(path: &Path) -> Option<Entry> {
    let name = path.file_name()?.to_string_lossy().into_owned();
    let Ok(data) = std::fs::metadata(path) else {
        return Some(Entry {
            name,
            ..Entry::default()
        });
    };
    let changed = data.modified().ok()?.duration_since(UNIX_EPOCH).unwrap_or_default();
    Some(Entry {
        name,
        is_folder: data.is_dir(),
        bytes: data.len(),
        changed: changed.as_secs(),
    })
}

/// The indices of the entries that pass a filter, in an order.
pub fn shown(entries: &[Entry], filter: &Filter, order: Order) -> Vec<usize> {
    let part = filter.part.to_lowercase();
    let passes = |entry: &Entry| {
        let is_known = entry.is_folder
            || (!filter.only_folders
                && (filter.extensions.is_empty()
                    || filter.extensions.contains(&extension(Path::new(&entry.name)).as_str())));
        is_known
            && (filter.shows_hidden || !entry.name.starts_with('.'))
            && (part.is_empty() || entry.name.to_lowercase().contains(&part))
    };
    let mut places: Vec<usize> = (0..entries.len()).filter(|place| passes(&entries[*place])).collect();
    places.sort_by_cached_key(|place| {
        let entry = &entries[*place];
        let by_column = match order.column {
            Column::Name => 0,
            Column::Size => entry.bytes,
            Column::Changed => entry.changed,
        };
        // Large and new files come first: they are the ones users look for.
        (Reverse(by_column), natural(&entry.name), entry.name.clone())
    });
    if order.is_reversed {
        places.reverse();
    }
    places.sort_by_key(|place| !entries[*place].is_folder);
    places
}

/// A sort key by which `wall 9` comes before `wall 10`, and case does not matter.
fn natural(name: &str) -> Vec<(u64, String)> {
    let mut parts = vec![(0u64, String::new())];
    let mut in_digits = false;
    for letter in name.to_lowercase().chars() {
        let Some((number, text)) = parts.last_mut() else { break };
        match letter.to_digit(10) {
            Some(digit) if in_digits || text.is_empty() => {
                *number = number.saturating_mul(10).saturating_add(u64::from(digit))
            }
            Some(digit) => parts.push((u64::from(digit), String::new())),
            None => text.push(letter),
        }
        in_digits = letter.is_ascii_digit();
    }
    // The number of a part stands after the text of the one before.
    parts
}

/// The time of the last change as text: the time of day, before today with the date.
pub fn changed_text(entry: &Entry) -> String {
    match entry.changed {
        0 => String::new(),
        seconds => clock_of(seconds).unwrap_or_default(),
    }
}

/// The folders of these files, each once.
pub fn folders_of(files: &[PathBuf]) -> Vec<PathBuf> {
    let mut folders: Vec<PathBuf> = Vec::new();
    for folder in files.iter().filter_map(|file| file.parent()) {
        if !folder.as_os_str().is_empty() && !folders.iter().any(|known| known == folder) {
            folders.push(folder.to_path_buf());
        }
    }
    folders
}

#[cfg(test)]
mod tests {
    use super::*;

    fn entry(name: &str, is_folder: bool, bytes: u64) -> Entry {
        Entry {
            name: name.to_owned(),
            is_folder,
            bytes,
            changed: 1000 - bytes,
        }
    }

    fn names(filter: &Filter, order: Order) -> Vec<String> {
        let entries = [
            entry("wall 10.xml", false, 20),
            entry("Wall 9.XML", false, 10),
            entry("picture.png", false, 30),
            entry(".hidden.xml", false, 1),
            entry("zoo", true, 5),
            entry("attic", true, 6),
        ];
        let shown = shown(&entries, filter, order);
        shown.iter().map(|place| entries[*place].name.clone()).collect()
    }

    #[test]
    fn folders_come_first_and_numbers_are_counted() {
        let scenes = Filter {
            extensions: vec!["xml"],
            ..Filter::default()
        };
        let order = Order::default();
        assert_eq!(names(&scenes, order), ["attic", "zoo", "Wall 9.XML", "wall 10.xml"]);
        assert!(natural("wall 99999999999999999999") > natural("wall 9"));
        let by_size = Order {
            column: Column::Size,
            is_reversed: false,
        };
        let all = names(&Filter::default(), by_size);
        assert_eq!(all, ["attic", "zoo", "picture.png", "wall 10.xml", "Wall 9.XML"]);
        let by_age = Order {
            column: Column::Changed,
            is_reversed: true,
        };
        assert_eq!(names(&scenes, by_age), ["attic", "zoo", "wall 10.xml", "Wall 9.XML"]);
    }

    #[test]
    fn a_part_of_the_name_and_hidden_files_are_matters_of_the_filter() {
        let filter = Filter {
            part: "WALL".to_owned(),
            ..Filter::default()
        };
        assert_eq!(names(&filter, Order::default()), ["Wall 9.XML", "wall 10.xml"]);
        let filter = Filter {
            part: "hid".to_owned(),
            shows_hidden: true,
            ..Filter::default()
        };
        assert_eq!(names(&filter, Order::default()), [".hidden.xml"]);
        let filter = Filter {
            only_folders: true,
            ..Filter::default()
        };
        assert_eq!(names(&filter, Order::default()), ["attic", "zoo"]);
    }

    #[test]
    fn a_folder_is_listed_with_what_is_wrong_with_it() {
        let folder = tempfile::tempdir().expect("a folder");
        std::fs::create_dir(folder.path().join("inner")).expect("a folder");
        std::fs::write(folder.path().join("a.xml"), "<scene/>").expect("a file");
        let (mut entries, problem) = read(folder.path());
        assert_eq!(problem, None);
        entries.sort_by(|a, b| a.name.cmp(&b.name));
        let found: Vec<_> = entries
            .iter()
            .map(|entry| (entry.name.as_str(), entry.is_folder))
            .collect();
        assert_eq!(found, [("a.xml", false), ("inner", true)]);
        assert_eq!(entries[0].bytes, 8);
        let (entries, problem) = read(&folder.path().join("none"));
        assert!(entries.is_empty() && problem.is_some_and(|problem| problem.contains("none")));
    }

    #[test]
    fn folders_of_files_come_once() {
        let files = ["/a/b.xml", "/c/d.xml", "/a/e.xml", "f.xml"].map(PathBuf::from);
        assert_eq!(folders_of(&files), ["/a", "/c"].map(PathBuf::from));
    }
}
