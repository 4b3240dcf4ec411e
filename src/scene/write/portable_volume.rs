//! Writes grids of `.vdb` files as `.vol` files beside the scene, which Mitsuba reads.

use std::collections::HashSet;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use bevy::math::{Affine3A, Mat4};

use super::error::SaveError;
use super::patch::value_of;
use crate::document::{Category, Child, Object, TransformOp, Value};
use crate::files::{Access, FileSet};
use crate::scene::VolumeFormat;
use crate::scene::assets::volume_map::load_volume;
use crate::scene::components::medium::GRID;
use crate::scene::components::texture_parameters::FILENAME;

/// The volume files written beside a scene.
pub(super) struct VolumeFiles<'f> {
    /// The scene's file, absolute.
    target: &'f Path,
    /// Finds a file by its name in the scene.
    find: &'f dyn Fn(&str) -> Option<PathBuf>,
    access: Access,
    /// The files that are being written.
    set: &'f mut FileSet,
    /// The files to which no grid may be written: the scene names them, or a grid is written there already.
    taken: HashSet<PathBuf>,
    /// The written grids, by their assets: the names of their files, and their own transforms.
    written: Vec<(PathBuf, String, Affine3A)>,
}

impl<'f> VolumeFiles<'f> {
    pub(super) fn new(
        target: &'f Path,
        find: &'f dyn Fn(&str) -> Option<PathBuf>,
        access: Access,
        set: &'f mut FileSet,
    ) -> Self {
        Self {
            target,
            find,
            access,
            set,
            taken: HashSet::new(),
            written: Vec::new(),
        }
    }

    /// Turns every `vdbvolume` of a document into a `gridvolume`, see [`Self::translate`].
    pub(super) fn translate_all(mut self, root: &mut Object) -> Result<(), SaveError> {
        self.note_files(root);
        self.translate(root)
    }

    /// Notes the files named by nested volumes, so that none of them is replaced.
    fn note_files(&mut self, object: &Object) {
        for inner in object.objects() {
            self.note_files(inner);
        }
        if object.category == Category::Volume
            && let Some(Value::String(name)) = value_of(object, FILENAME.name)
        {
            self.taken.insert(self.found(name));
        }
    }

    /// The path of the file with this name in the scene.
    fn found(&self, name: &str) -> PathBuf {
        (self.find)(name).unwrap_or_else(|| self.target.with_file_name(name))
    }

    /// Turns every nested `vdbvolume` into a `gridvolume` at the same place. An error names a file that cannot be read
    /// or written.
    fn translate(&mut self, object: &mut Object) -> Result<(), SaveError> {
        for child in &mut object.children {
            if let Child::Object(inner) = child {
                self.translate(Arc::make_mut(inner))?;
            }
        }
        let mut format = VolumeFormat::Vdb { grid: None };
        if object.category != Category::Volume || object.plugin != format.plugin() {
            return Ok(());
        }
        if let Some(Value::String(name)) = value_of(object, GRID)
            && !name.is_empty()
        {
            format = VolumeFormat::Vdb {
                grid: Some(name.clone()),
            };
        }
        let Some(Value::String(name)) = value_of(object, FILENAME.name) else {
            return Ok(());
        };
        let path = self.found(name);
        let (name, world_from_local) = self.write(&path, &format)?;
        let to_world = match value_of(object, "to_world") {
            Some(Value::Transform(steps)) => TransformOp::compose(steps),
            _ => Default::default(),
        };
        // The same product as in the renderer, so that the picture is the same.
        let to_world = Mat4::from(to_world * world_from_local);
        object.plugin = VolumeFormat::Vol.plugin().into();
        let replaced = [FILENAME.name, GRID, "to_world"];
        object
            .properties
            .retain(|property| !replaced.contains(&property.name.as_str()));
        *object = object
            .clone()
            .with(FILENAME.name, Value::String(name))
            .with("to_world", Value::Transform(vec![TransformOp::Matrix(to_world)]));
        Ok(())
    }

    /// Writes a grid once; returns the name of its file, and the transform to the space of the `.vdb` file from that in
    /// which the grid fills the unit cube.
    fn write(&mut self, path: &Path, format: &VolumeFormat) -> Result<(String, Affine3A), SaveError> {
        let asset = format.asset_path(path);
        if let Some((_, name, world_from_local)) = self.written.iter().find(|(known, ..)| *known == asset) {
            return Ok((name.clone(), *world_from_local));
        }
        let volume = load_volume(&asset, &self.access).map_err(|error| SaveError::Volume {
            path: path.to_owned(),
            reason: error.to_string(),
        })?;
        let stem = self.target.file_stem().unwrap_or_default().to_string_lossy();
        let is_free = |name: &String| !self.taken.contains(&self.target.with_file_name(name));
        let mut names = (1..).map(|number| format!("{stem}.volume-{number}.vol"));
        let name = names.find(is_free).unwrap_or_default();
        self.taken.insert(self.target.with_file_name(&name));
        self.set.add(&self.target.with_file_name(&name), volume.to_vol())?;
        let world_from_local = volume.world_from_local;
        self.written.push((asset, name.clone(), world_from_local));
        Ok((name, world_from_local))
    }
}
