//! The paths of one pixel, kept up to date with the scene and the view, with the names of shapes and materials at their
//! vertices.

use std::sync::Arc;

use bevy::ecs::system::SystemParam;
use bevy::math::{UVec2, Vec2};
use bevy::prelude::*;

use crate::app::editor::command::inspected_paths::InspectedPaths;
use crate::engine::PackedScene;
use crate::render::inspect::{RecordedPath, record_paths};
use crate::render::observer::PathVertex;
use crate::render::scene::RenderScene;
use crate::render::view::View;
use crate::scene::{Material, UsesMaterial};

/// A path and the names of its vertices.
#[derive(Clone, Debug, PartialEq)]
pub struct NamedPath {
    /// The path that the renderer recorded.
    pub path: RecordedPath,
    /// The names of the shape and of its material at each vertex.
    pub names: Vec<(String, String)>,
}

/// The inspected paths, which are drawn and described.
#[derive(Resource, Debug, Default)]
pub struct PathInspector {
    /// The pixel and view of the paths that the user has requested, if any.
    pub wanted: Option<InspectedPaths>,
    /// The paths, recorded from the picture's scene; empty while that is being packed.
    pub paths: Arc<Vec<NamedPath>>,
    /// Their pixel.
    pub pixel: UVec2,
    made_of: Option<(RenderScene, View, InspectedPaths)>,
}

#[derive(SystemParam)]
pub(crate) struct Names<'w, 's> {
    shapes: Query<'w, 's, (Option<&'static Name>, Option<&'static UsesMaterial>)>,
    materials: Query<'w, 's, (Option<&'static Name>, &'static Material)>,
}

impl Names<'_, '_> {
    fn of(&self, entity: Option<Entity>) -> (String, String) {
        let Some((name, uses)) = entity.and_then(|entity| self.shapes.get(entity).ok()) else {
            return ("?".to_owned(), String::new());
        };
        let material = uses.and_then(|uses| self.materials.get(uses.0).ok());
        let material = material.map_or_else(String::new, |(name, material)| match name {
            Some(name) if name.as_str() != material.info().label => format!("{name}, {}", material.info().label),
            _ => material.info().label.to_owned(),
        });
        (
            name.map_or_else(|| "shape".to_owned(), |name| name.to_string()),
            material,
        )
    }
}

/// Traces the paths again when the scene or the view has changed, which takes less than a frame.
pub(crate) fn follow_paths(mut inspector: ResMut<PathInspector>, packed: Res<PackedScene>, names: Names) {
    let (Some(wanted), Some(scene), Some(view)) = (inspector.wanted, &packed.scene, &packed.view) else {
        if !inspector.paths.is_empty() {
            inspector.paths = Arc::default();
            inspector.made_of = None;
        }
        return;
    };
    let is_known = inspector
        .made_of
        .as_ref()
        .is_some_and(|(known, of, for_what)| is_same(known, scene) && of == view && *for_what == wanted);
    if is_known {
        return;
    }
    let size = UVec2::new(view.width, view.height);
    let place = view.picture_of_film(wanted.place).clamp(Vec2::ZERO, Vec2::ONE);
    let pixel = (place * size.as_vec2()).as_uvec2().min(size - UVec2::ONE);
    let paths = record_paths(scene, view, pixel, 0..wanted.count.clamp(1, InspectedPaths::MOST));
    let named = paths.into_iter().map(|path| NamedPath {
        names: path
            .vertices
            .iter()
            .map(|vertex| match vertex.place {
                PathVertex::Surface(surface) => {
                    names.of(packed.entity_of_instance.get(surface.instance as usize).copied())
                }
                PathVertex::Medium(_) => ("a medium".to_owned(), String::new()),
            })
            .collect(),
        path,
    });
    let paths = Arc::new(named.collect());
    inspector.made_of = Some((scene.clone(), view.clone(), wanted));
    inspector.pixel = pixel;
    inspector.paths = paths;
}

fn is_same(one: &RenderScene, other: &RenderScene) -> bool {
    Arc::ptr_eq(&one.geometry, &other.geometry)
        && Arc::ptr_eq(&one.surfaces, &other.surfaces)
        && Arc::ptr_eq(&one.materials, &other.materials)
        && Arc::ptr_eq(&one.textures, &other.textures)
        && Arc::ptr_eq(&one.media, &other.media)
        && Arc::ptr_eq(&one.lights, &other.lights)
}
