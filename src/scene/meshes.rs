//! Mesh assets follow the shapes that name them, and their troubles reach the status.

use std::collections::HashMap;

use bevy::asset::{AssetLoadFailedEvent, AssetPath, LoadState};
use bevy::prelude::*;

use super::assets::cause;
use super::loading::SceneFile;
use super::{Authored, DocumentOrder, MeshFile, MeshHandle, MeshProblem, SceneStatus, Shape, ShapeKind, TriangleMesh};
use crate::document::Diagnostics;

pub(super) fn follow_mesh_files(
    mut commands: Commands,
    server: Res<AssetServer>,
    shapes: Query<(Entity, &Shape, Option<&MeshHandle>), Changed<Shape>>,
) {
    for (entity, shape, current) in &shapes {
        match &shape.kind {
            // Without a file the mesh is one that the program has made.
            ShapeKind::Mesh(file) if file.path.as_os_str().is_empty() => {}
            ShapeKind::Mesh(file) => {
                let handle = MeshHandle(server.load(asset_path(file)));
                if current != Some(&handle) {
                    commands.entity(entity).insert(handle);
                }
            }
            _ if current.is_some() => {
                commands.entity(entity).remove::<MeshHandle>();
            }
            _ => {}
        }
    }
}

/// What the loader of meshes calls this one: the first shape of a file is the file, others are labelled with their numbers.
fn asset_path(mesh: &MeshFile) -> AssetPath<'static> {
    let path = AssetPath::from_path_buf(mesh.path.clone());
    match mesh.shape_index {
        0 => path,
        index => path.with_label(index.to_string()),
    }
}

/// Brings errors, warnings and the number of missing meshes up to date, whenever a mesh or a shape has changed.
pub(super) fn report_meshes(
    mut status: ResMut<SceneStatus>,
    file: Res<SceneFile>,
    server: Res<AssetServer>,
    assets: Res<Assets<TriangleMesh>>,
    mut events: MessageReader<AssetEvent<TriangleMesh>>,
    mut failures: MessageReader<AssetLoadFailedEvent<TriangleMesh>>,
    changed: Query<(), Or<(Changed<MeshHandle>, Changed<DocumentOrder>)>>,
    mut removed: RemovedComponents<MeshHandle>,
    shapes: Query<(&Shape, &MeshHandle, &DocumentOrder, Option<&Authored>)>,
) {
    let news = [
        events.read().count(),
        failures.read().count(),
        removed.read().count(),
        changed.iter().count(),
    ];
    if news == [0; 4] && status.meshes_loading == 0 {
        return;
    }
    // One message per file, at the first shape that names it.
    let mut first_use = HashMap::new();
    for (shape, handle, order, authored) in &shapes {
        let entry = first_use.entry(handle.0.id()).or_insert((order, shape, authored));
        if *order < *entry.0 {
            *entry = (order, shape, authored);
        }
    }
    let mut uses: Vec<_> = first_use.into_iter().collect();
    uses.sort_by_key(|(_, (order, ..))| **order);
    let mut errors = Vec::new();
    let mut warnings = Vec::new();
    let mut loading = 0;
    for (id, (_, shape, authored)) in uses {
        let ShapeKind::Mesh(mesh) = &shape.kind else {
            continue;
        };
        let shown = mesh.path.display();
        if let Some(asset) = assets.get(id) {
            warnings.extend(asset.warnings.iter().map(|warning| format!("{shown}: {warning}")));
        }
        match server.load_state(id) {
            LoadState::Failed(error) => errors.push(MeshProblem {
                path: mesh.path.clone(),
                message: format!(
                    "{}mesh {shown}: {}",
                    place(authored, &file.good_diagnostics),
                    cause(&error)
                ),
            }),
            LoadState::Loaded => {}
            LoadState::NotLoaded | LoadState::Loading => loading += usize::from(!assets.contains(id)),
        }
    }
    for problem in errors.iter().filter(|problem| !status.mesh_errors.contains(problem)) {
        error!("{}", problem.message);
    }
    if status.mesh_errors != errors || status.mesh_warnings != warnings || status.meshes_loading != loading {
        status.mesh_errors = errors;
        status.mesh_warnings = warnings;
        status.meshes_loading = loading;
    }
}

/// `file:line:column: ` of a shape in its scene file.
fn place(authored: Option<&Authored>, diagnostics: &Diagnostics) -> String {
    let Some(authored) = authored else {
        return String::new();
    };
    let named = authored
        .object
        .properties
        .iter()
        .find(|property| property.name == "filename");
    let span = named.map_or(authored.object.span, |property| property.span);
    match diagnostics.locate(span) {
        Some((path, line, column)) => format!("{}:{line}:{column}: ", path.display()),
        None => String::new(),
    }
}
