//! Finds the picture files and the volume files that a scene names, and notes what is missing.

use std::collections::HashMap;
use std::path::{Path, PathBuf};

use super::mesh_search::{Found, MeshSearch};
use crate::document::paths::settle;
use crate::document::{Reader, Span};
use crate::scene::components::description::PicturePlaces;
use crate::scene::components::medium::GRID;
use crate::scene::{FileKind, MissingFile, MissingFiles, VolumeFormat};

/// The most grids of one file that a scene may name, more than any file has. The file is read for each of them.
const MOST_GRIDS: usize = 64;

/// Finds the pictures and volumes that a scene names, in the folders where its meshes are looked for, and keeps where
/// each was named.
pub struct PictureSearch {
    pub folders: MeshSearch,
    pub places: PicturePlaces,
    /// The places of volumes by the paths of their assets.
    pub volume_places: PicturePlaces,
    /// The number of grids that are named of each volume file.
    pub grids: HashMap<PathBuf, usize>,
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

    /// The file of a volume, found as a picture is. None (reported) if too many grids of it are named.
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
