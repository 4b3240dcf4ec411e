//! Checks the mesh files of a scene that is converted without being opened.

use std::collections::{BTreeSet, HashMap, HashSet};
use std::path::PathBuf;

use crate::document::{Diagnostics, Severity, Span};
use crate::files::Access;
use crate::scene::assets::parts_cache::is_part;
use crate::scene::assets::triangle_mesh::{MeshShape, load_mesh};
use crate::scene::components::missing::sentence;
use crate::scene::{FileKind, MeshFormat, SceneDescription, ShapeKind};

/// Reads each mesh file of a shape, and reports problems at the first shape that names it: an error for an unreadable
/// mesh, a warning for parts that were left out. `missing`: the severity of missing files. Returns the pictures
/// (absolute paths) of the meshes' own materials that are in use.
pub fn check_meshes(
    scene: &SceneDescription,
    access: &Access,
    missing: Severity,
    diagnostics: &mut Diagnostics,
) -> BTreeSet<PathBuf> {
    let mut read: HashMap<_, Result<Vec<Findings>, String>> = HashMap::new();
    let mut reported = HashSet::new();
    let mut pictures = BTreeSet::new();
    for shape in &scene.shapes {
        let ShapeKind::Mesh(mesh) = &shape.shape.kind else {
            continue;
        };
        if is_part(&mesh.path) {
            continue;
        }
        if let Some(file) = scene.missing.get(&mesh.path) {
            if reported.insert((&mesh.path, 0)) {
                let message = sentence(FileKind::Mesh, &mesh.path, &file.what());
                diagnostics.push(missing, Some(file.span), message, file.help.clone());
            }
            continue;
        }
        let is_first = !read.contains_key(&mesh.path);
        let shapes = read.entry(&mesh.path).or_insert_with(|| {
            let loaded = load_mesh(&mesh.path, access).map_err(|error| error.to_string())?;
            Ok(loaded.shapes.into_iter().map(Findings::from).collect())
        });
        // A shape with a material does not use those of its file.
        if shape.material.is_none()
            && let Ok(shapes) = shapes
            && let Some(findings) = shapes.get(mesh.shape_index as usize)
        {
            pictures.extend(findings.pictures.iter().cloned());
        }
        if !reported.insert((&mesh.path, mesh.shape_index)) {
            continue;
        }
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
                Some(findings) => {
                    let warnings = findings.warnings.iter();
                    warnings.for_each(|what| report(Severity::Warning, "filename", what));
                    if let Some((_, what)) = findings.misfits.iter().find(|(format, _)| *format == mesh.format) {
                        report(Severity::Error, "filename", what);
                    }
                }
                None => {
                    let (index, count) = (mesh.shape_index, shapes.len());
                    let what = format!("there is no shape {index}: the file has {count}");
                    report(Severity::Error, "shape_index", &what);
                }
            },
        }
    }
    pictures
}

/// The results of checking a mesh, which is dropped.
struct Findings {
    warnings: Vec<String>,
    /// The pictures named by its materials.
    pictures: Vec<PathBuf>,
    /// The formats that it does not fit, with the reasons.
    misfits: Vec<(MeshFormat, String)>,
}

impl From<MeshShape> for Findings {
    fn from(shape: MeshShape) -> Self {
        let maps = shape.data.materials.iter().flat_map(|material| material.maps.iter());
        Self {
            pictures: maps.map(|map| map.file.clone()).collect(),
            misfits: MeshFormat::ALL
                .into_iter()
                .filter_map(|format| Some((format, shape.misfit(format)?)))
                .collect(),
            warnings: shape.warnings,
        }
    }
}
