//! Fetches the material libraries that an OBJ file names.

use std::collections::HashSet;
use std::io;

use super::mesh::MtlMaterial;
use super::mesh_file::{Place, Warnings, excerpt};
use super::mtl::{MOST_MATERIALS, read_mtl};

/// The most libraries that are looked for, more than any real file names.
const MOST_LIBRARIES: usize = 64;

/// The libraries of a file while its statements are gone through.
pub(super) struct Libraries<'l> {
    fetch: &'l mut dyn FnMut(&str) -> io::Result<Vec<u8>>,
    /// The names that were asked for. However often the file has a name, it is asked for once.
    asked: HashSet<String>,
    /// The materials so far, in the order of the statements.
    pub materials: Vec<MtlMaterial>,
}

impl<'l> Libraries<'l> {
    /// `fetch` gives the content of the library with a name.
    pub fn new(fetch: &'l mut dyn FnMut(&str) -> io::Result<Vec<u8>>) -> Self {
        Self {
            fetch,
            asked: HashSet::new(),
            materials: Vec::new(),
        }
    }

    /// Reads the library or libraries of a statement: `names` is one file name, spaces and all, or if there is no such
    /// file, several.
    pub fn add(&mut self, names: &str, place: Place, warnings: &mut Warnings) {
        let whole = names.trim_matches('"');
        let Err(error) = self.read(whole, place, warnings) else {
            return;
        };
        let several = names.split_whitespace().take(MOST_LIBRARIES);
        if several.clone().count() < 2 {
            warnings.add(place, &unreadable(whole, &error));
            return;
        }
        for name in several {
            if let Err(error) = self.read(name, place, warnings) {
                warnings.add(place, &unreadable(name, &error));
            }
        }
    }

    /// Reads one library, unless it was asked for before.
    fn read(&mut self, name: &str, place: Place, warnings: &mut Warnings) -> io::Result<()> {
        if self.asked.contains(name) {
            return Ok(());
        }
        if self.asked.len() == MOST_LIBRARIES || self.materials.len() >= MOST_MATERIALS {
            warnings.add(place, "further material libraries are ignored");
            return Ok(());
        }
        self.asked.insert(name.to_owned());
        let bytes = (self.fetch)(name)?;
        self.materials.extend(read_mtl(&bytes, name, warnings));
        Ok(())
    }
}

fn unreadable(name: &str, error: &io::Error) -> String {
    let name = excerpt(name.as_bytes());
    format!("the material library {name} cannot be read: {error}")
}
