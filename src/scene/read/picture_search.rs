//! Finds the picture files and the volume files of a scene, and notes missing ones.

use std::collections::HashMap;
use std::path::{Path, PathBuf};

use super::mesh_search::{Found, MeshSearch};
use crate::document::paths::settle;
use crate::document::{Reader, Span};
use crate::scene::components::description::PicturePlaces;
use crate::scene::components::medium::GRID;
use crate::scene::{FileKind, MissingFile, MissingFiles, VolumeFormat};

/// The most grids of one file in a scene, more than any file has. The file is read for each of them.
const MOST_GRIDS: usize = 64;

/// Finds the pictures and volumes of a scene, in the same folders as its meshes, and keeps the spans of their names.
pub struct PictureSearch {
    pub folders: MeshSearch,
    pub places: PicturePlaces,
    /// The spans of volumes by the paths of their assets.
    pub volume_places: PicturePlaces,
    /// The number of grids used from each volume file.
    pub grids: HashMap<PathBuf, usize>,
    /// The missing files of all kinds.
    pub missing: MissingFiles,
}

impl PictureSearch {
    /// The picture's file; if it is missing, the first path that was tried, since it may appear later.
    pub fn find(&mut self, name: &str, reader: &mut Reader) -> PathBuf {
        let (path, span) = self.look(FileKind::Picture, name, reader);
        self.places.entry(path.clone()).or_insert(span);
        path
    }

    /// The file of a volume, searched like a picture. None (reported) if too many of its grids are used.
    pub fn find_volume(&mut self, name: &str, format: &VolumeFormat, reader: &mut Reader) -> Option<PathBuf> {
        let (path, span) = self.look(FileKind::Volume, name, reader);
        let asset = format.asset_path(&path);
        if !self.volume_places.contains_key(&asset) {
            let grids = self.grids.entry(path.clone()).or_default();
            if *grids == MOST_GRIDS {
                reader.error_at(GRID, format!("more than {MOST_GRIDS} grids of one file are named"));
                return None;
            }
            *grids += 1;
            self.volume_places.insert(asset, span);
        }
        Some(path)
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

    /// Notes a file that is missing at all these paths. Returns the first of them, its key.
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
