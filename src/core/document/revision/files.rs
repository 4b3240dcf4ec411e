//! Adapts names of files in a text that is written to another folder, where they would mean another file there.

use std::borrow::Cow;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use super::edits::Edit;
use super::elements::Element;
use super::source::{Destination, Place, Source};
use super::values::revise_attribute;
use crate::document::paths::{file_candidates, file_name, settle, settle_covered};
use crate::document::{Category, Child, Document, Object, Property, SourceId, Track, Value, WriteError};
use crate::files::Access;

/// Makes the file names in a tree, which was read as `origin` and changed since, relative to the destination.
pub fn move_files(root: &mut Object, origin: &Document, destination: &Destination) {
    let names = FileNames::new(origin, destination);
    names.move_object(root, names.target_folder);
}

pub struct FileNames<'d> {
    destination: &'d Destination<'d>,
    /// The folder of the main file once it is written.
    pub target_folder: &'d Path,
    search_folders: &'d [PathBuf],
    access: Access,
    /// The absolute path of each file of the document.
    paths: Vec<PathBuf>,
}

impl<'d> FileNames<'d> {
    pub fn new(origin: &'d Document, destination: &'d Destination<'d>) -> Self {
        let sources = origin.diagnostics.sources.iter();
        Self {
            destination,
            target_folder: parent(destination.path),
            search_folders: &origin.search_folders,
            access: origin.access.apart(),
            paths: sources.map(|source| settle(&source.path)).collect(),
        }
    }

    pub fn path(&self, source: SourceId) -> &Path {
        self.paths
            .get(source.0 as usize)
            .map_or(Path::new("/"), PathBuf::as_path)
    }

    pub fn folder(&self, source: SourceId) -> &Path {
        parent(self.path(source))
    }

    /// The property, for an object of this category, as it reads in a file of `folder`. A file named by a film is
    /// written, not read, and is left alone.
    pub fn property_at<'p>(&self, property: &'p Property, owner: Category, folder: &Path) -> Cow<'p, Property> {
        let is_file = property.name == "filename" && owner != Category::Film;
        if !is_file {
            return Cow::Borrowed(property);
        }
        let from = self.folder(property.span.source);
        let moved = |value: &mut Value| match value {
            Value::String(name) => self.moved(name, from, folder).map(|moved| *name = moved).is_some(),
            _ => false,
        };
        let mut own = property.clone();
        let mut is_moved = moved(&mut own.value);
        if let Some(track) = &mut own.keys {
            let mut keys = Track::clone(track);
            for key in &mut keys.keys {
                is_moved |= moved(&mut key.value);
            }
            *track = Arc::new(keys);
        }
        match is_moved {
            true => Cow::Owned(own),
            false => Cow::Borrowed(property),
        }
    }

    /// Adapts the names of files in the subtree of an object.
    pub fn move_object(&self, object: &mut Object, folder: &Path) {
        let owner = object.category;
        for property in &mut object.properties {
            if let Cow::Owned(moved) = self.property_at(property, owner, folder) {
                *property = moved;
            }
        }
        for child in &mut object.children {
            if let Child::Object(inner) = child {
                self.move_object(Arc::make_mut(inner), folder);
            }
        }
    }

    /// The new name of a file; None if the old name is still right. A file that does not exist is named in the folder
    /// that is searched first: it may come later, and the new folder may have another file of that name.
    fn moved(&self, name: &str, from: &Path, to: &Path) -> Option<String> {
        if name.is_empty() || Path::new(name).is_absolute() {
            return None;
        }
        let Some(path) = (self.destination.find_before)(name, from) else {
            return (from != to).then(|| file_name(&settle_covered(from, Path::new(name), &self.access), to));
        };
        let stays = (self.destination.find_after)(name, to).is_some_and(|found| found == path);
        (!stays).then(|| file_name(&path, to))
    }

    /// Revises the `filename` of an `<include>`, or of a `<spectrum>` with values in a file. `known` is the file, if it
    /// is known.
    pub fn revise_name(
        &self,
        source: &Source,
        element: &Element,
        place: Place,
        known: Option<&Path>,
    ) -> Result<Vec<Edit>, WriteError> {
        let from = self.folder(place.source);
        let Some(attribute) = element.attribute(source.text(), "filename") else {
            return Ok(Vec::new());
        };
        let name = &source.text()[attribute.value];
        if from == place.folder || Path::new(name).is_absolute() {
            return Ok(Vec::new());
        }
        let find = |folders: &[PathBuf]| {
            let candidates = file_candidates(name, folders, self.search_folders);
            self.access.find(&candidates).map(|path| settle(path))
        };
        let main = self.folder(SourceId(0));
        let before = known
            .map(Path::to_owned)
            .or_else(|| find(&[from.to_owned(), main.to_owned()]));
        let after = find(&[place.folder.to_owned(), self.target_folder.to_owned()]);
        match before {
            Some(path) if after.as_ref() != Some(&path) => {
                let moved = file_name(&path, place.folder);
                let edit = revise_attribute(source.text(), element, "filename", Some(&moved))?;
                Ok(edit.into_iter().collect())
            }
            _ => Ok(Vec::new()),
        }
    }

    /// Revises a `<path>`, which is relative to the file that contains it.
    pub fn revise_folder(&self, source: &Source, element: &Element, place: Place) -> Result<Option<Edit>, WriteError> {
        let from = self.folder(place.source);
        let Some(attribute) = element.attribute(source.text(), "value") else {
            return Ok(None);
        };
        let name = &source.text()[attribute.value];
        if from == place.folder || Path::new(name).is_absolute() || name.contains('$') {
            return Ok(None);
        }
        let folder = settle_covered(from, Path::new(name), &self.access);
        let folder = match self.access.covers(&folder) {
            true => folder.canonicalize().unwrap_or(folder),
            false => folder,
        };
        revise_attribute(source.text(), element, "value", Some(&file_name(&folder, place.folder)))
    }
}

fn parent(path: &Path) -> &Path {
    path.parent().unwrap_or(Path::new("/"))
}
