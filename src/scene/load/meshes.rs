//! Loads the meshes of shapes, and reports problems with them to the status.

use std::collections::{HashMap, HashSet};

use bevy::asset::{AssetLoadFailedEvent, AssetPath, LoadState};
use bevy::prelude::*;

use super::scene_file::SceneFile;
use crate::document::Span;
use crate::scene::assets::{cause, is_missing};
use crate::scene::file::changes::Changes;
use crate::scene::{
    Authored, DocumentOrder, FileKind, FileProblem, MeshHandle, SceneStatus, Shape, ShapeKind, TriangleMesh,
};

pub(in crate::scene) fn follow_mesh_files(
    mut commands: Commands,
    server: Res<AssetServer>,
    changed: Changes<Shape>,
    shapes: Query<(&Shape, Option<&MeshHandle>)>,
) {
    changed.for_each(|entity| {
        let Ok((shape, current)) = shapes.get(entity) else {
            return;
        };
        match &shape.kind {
            // A mesh without a file was made by the program.
            ShapeKind::Mesh(file) if file.path.as_os_str().is_empty() => {}
            ShapeKind::Mesh(file) => {
                let handle = MeshHandle(server.load(AssetPath::from_path_buf(file.path.clone())));
                if current != Some(&handle) {
                    commands.entity(entity).insert(handle);
                }
            }
            _ if current.is_some() => {
                commands.entity(entity).remove::<MeshHandle>();
            }
            _ => {}
        }
    });
}

/// Updates errors, warnings and the number of loading meshes, whenever a mesh or a shape has changed.
pub(in crate::scene) fn report_meshes(
    mut status: ResMut<SceneStatus>,
    file: Res<SceneFile>,
    server: Res<AssetServer>,
    assets: Res<Assets<TriangleMesh>>,
    mut events: MessageReader<AssetEvent<TriangleMesh>>,
    mut failures: MessageReader<AssetLoadFailedEvent<TriangleMesh>>,
    changed: (Changes<Shape>, Changes<MeshHandle>, Changes<DocumentOrder>),
    mut removed: RemovedComponents<MeshHandle>,
    shapes: Query<(&Shape, &MeshHandle, &DocumentOrder, Option<&Authored>)>,
) {
    let news = [events.read().count(), failures.read().count(), removed.read().count()];
    let has_changed = changed.0.any() | changed.1.any() | changed.2.any();
    if news == [0; 3] && !has_changed && status.meshes_loading == 0 {
        return;
    }
    // One message per mesh, at the first shape that names it.
    let mut first_use = HashMap::new();
    for (shape, handle, order, authored) in &shapes {
        let ShapeKind::Mesh(mesh) = &shape.kind else {
            continue;
        };
        let entry = first_use
            .entry((handle.0.id(), mesh.shape_index))
            .or_insert((order, mesh, authored));
        if *order < *entry.0 {
            *entry = (order, mesh, authored);
        }
    }
    let mut uses: Vec<_> = first_use.into_iter().collect();
    uses.sort_by_key(|(_, (order, ..))| **order);
    let mut errors = Vec::new();
    let mut warnings = Vec::new();
    // The warnings of a file are reported once, for all of its shapes.
    let (mut failed, mut loading) = (HashSet::new(), HashSet::new());
    for ((id, index), (_, mesh, authored)) in uses {
        let problem = |property: &str, what: &str| {
            let what = format!("mesh {}: {what}", mesh.path.display());
            FileProblem::new(&mesh.path, place(authored, property), what, &file.good_diagnostics)
        };
        let asset = assets.get(id);
        if let Some(asset) = asset {
            match asset.shapes.get(index as usize) {
                Some(shape) => {
                    warnings.extend(shape.warnings.iter().map(|warning| problem("filename", warning)));
                    errors.extend(shape.misfit(mesh.format).map(|what| problem("filename", &what)));
                }
                None => {
                    let what = format!("there is no shape {index}: the file has {}", asset.shapes.len());
                    errors.push(problem("shape_index", &what));
                }
            }
        }
        match server.load_state(id) {
            LoadState::Failed(error) => {
                if failed.insert(id) {
                    // The mesh read before stays in the picture, without a stand-in.
                    errors.push(match is_missing(&error) && asset.is_none() {
                        true => file.missing_file(FileKind::Mesh, &mesh.path, place(authored, "filename")),
                        false => problem("filename", &cause(&error)),
                    });
                }
            }
            LoadState::Loaded => {}
            LoadState::NotLoaded | LoadState::Loading => {
                if asset.is_none() {
                    loading.insert(id);
                }
            }
        }
    }
    let loading = loading.len();
    for problem in errors.iter().filter(|problem| !status.mesh_errors.contains(problem)) {
        error!("{}", problem.message);
    }
    if status.mesh_errors != errors || status.mesh_warnings != warnings || status.meshes_loading != loading {
        status.mesh_errors = errors;
        status.mesh_warnings = warnings;
        status.meshes_loading = loading;
    }
}

/// The span of a shape's property in its scene file, or of the shape if it does not give the property.
fn place(authored: Option<&Authored>, property: &str) -> Option<Span> {
    let object = &authored?.object;
    let named = object.properties.iter().find(|given| given.name == property);
    Some(named.map_or(object.span, |property| property.span))
}
