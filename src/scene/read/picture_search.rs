//! Finds the picture files and the volume files that a scene names, and notes what is missing.

use std::path::{Path, PathBuf};

use super::mesh_search::{Found, MeshSearch};
use crate::document::paths::settle;
use crate::document::{Reader, Span};
use crate::scene::description::PicturePlaces;
use crate::scene::{FileKind, MissingFile, MissingFiles, VolumeFormat};

/// Finds the pictures and volumes that a scene names, in the folders where its meshes are looked for, and keeps where each was named.
pub struct PictureSearch {
    pub folders: MeshSearch,
    pub places: PicturePlaces,
    /// The places of volumes by the paths of their assets.
    pub volume_places: PicturePlaces,
    /// Files of all kinds that were not found.
    pub missing: MissingFiles,
}

impl PictureSearch {
    /// The picture's file; the first place where it was looked for if there is none: it may come later.
    pub fn find(&mut self, name: &str, reader: &mut Reader) -> PathBuf {
        let (path, span) = self.look(FileKind::Picture, name, reader);
        self.places.entry(path.clone()).or_insert(span);
        path
    }

    /// The file of a volume, found as a picture is.
    pub fn find_volume(&mut self, name: &str, format: &VolumeFormat, reader: &mut Reader) -> PathBuf {
        let (path, span) = self.look(FileKind::Volume, name, reader);
        self.volume_places.entry(format.asset_path(&path)).or_insert(span);
        path
    }

    fn look(&mut self, kind: FileKind, name: &str, reader: &mut Reader) -> (PathBuf, Span) {
        let span = reader.span_of("filename");
        let source = reader.diagnostics().source(span.source);
        let file = source.map(|file| settle(&file.path)).unwrap_or_default();
        let path = match self.folders.find(name, file.parent().unwrap_or(Path::new("/"))) {
            Found::At(path) => path,
            Found::Nowhere(places) => self.note_missing(kind, places, span, None),
        };
        (path, span)
    }

    /// Notes a file that is in none of these places. Returns the first of them, by which it is known.
    pub fn note_missing(&mut self, kind: FileKind, places: Vec<PathBuf>, span: Span, help: Option<String>) -> PathBuf {
        let mut places = places.into_iter();
        let path = places.next().unwrap_or_default();
        self.missing.entry(path.clone()).or_insert_with(|| MissingFile {
            kind,
            span,
            others: places.collect(),
            help,
        });
        path
    }
}
