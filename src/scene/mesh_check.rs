//! The mesh files of a scene that is converted without being opened: whether they can be read.

use std::collections::{HashMap, HashSet};

use super::assets::parts_cache::is_part;
use super::assets::triangle_mesh::{MeshShape, load_mesh};
use super::{SceneDescription, ShapeKind};
use crate::document::{Diagnostics, Severity, Span};
use crate::files::Access;

/// Reads each mesh file that a shape names, and reports what is wrong with it at the first shape that names it: an error for a mesh that cannot be
/// read, a warning for what was left out of it. Files that are not there have been reported when the scene was read.
pub fn check_meshes(scene: &SceneDescription, access: &Access, diagnostics: &mut Diagnostics) {
    let mut read: HashMap<_, Result<Vec<Vec<String>>, String>> = HashMap::new();
    let mut reported = HashSet::new();
    for shape in &scene.shapes {
        let ShapeKind::Mesh(mesh) = &shape.shape.kind else {
            continue;
        };
        let is_new = reported.insert((&mesh.path, mesh.shape_index));
        if !is_new || is_part(&mesh.path) || scene.missing.contains(&mesh.path) {
            continue;
        }
        let is_first = !read.contains_key(&mesh.path);
        let shapes = read.entry(&mesh.path).or_insert_with(|| {
            let warnings = |shape: MeshShape| shape.warnings;
            let loaded = load_mesh(&mesh.path, access).map_err(|error| error.to_string())?;
            Ok(loaded.shapes.into_iter().map(warnings).collect())
        });
        let mut report = |severity, property: &str, what: &str| {
            let given = shape.identity.authored.as_ref().and_then(|authored| {
                let mut properties = authored.object.properties.iter();
                properties.find(|given| given.name == property)
            });
            let span: Span = given.map_or(shape.identity.span, |given| given.span);
            let message = format!("mesh {}: {what}", mesh.path.display());
            diagnostics.push(severity, Some(span), message, None);
        };
        match shapes {
            Err(error) if is_first => report(Severity::Error, "filename", error),
            Err(_) => {}
            Ok(shapes) => match shapes.get(mesh.shape_index as usize) {
                Some(warnings) => warnings
                    .iter()
                    .for_each(|what| report(Severity::Warning, "filename", what)),
                None => {
                    let (index, count) = (mesh.shape_index, shapes.len());
                    let what = format!("there is no shape {index}: the file has {count}");
                    report(Severity::Error, "shape_index", &what);
                }
            },
        }
    }
}
