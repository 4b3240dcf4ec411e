//! The paths of one pixel, kept up to date with the scene and the view, with the names of shapes and materials at their
//! vertices.

use std::sync::Arc;

use bevy::ecs::system::SystemParam;
use bevy::prelude::*;

use super::reasons::Reasons;
use crate::app::editor::command::inspected_paths::InspectedPaths;
use crate::engine::PackedScene;
use crate::engine::reasons::{NameParts, Things, thing_name_by};
use crate::render::breakdown::{Area, Route};
use crate::render::inspect::{RecordedPath, record_paths};
use crate::render::observer::PathVertex;
use crate::render::scene::RenderScene;
use crate::render::view::View;
use crate::scene::{Material, SceneId, UsesMaterial};

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
    /// The pixels and the view of the paths that the user has requested, if any.
    pub wanted: Option<InspectedPaths>,
    /// The paths, recorded from the picture's scene; empty while that is being packed, and while paths of one group are
    /// being looked for.
    pub paths: Arc<Vec<NamedPath>>,
    /// Their pixels.
    pub area: Option<Area>,
    made_of: Option<(RenderScene, View, InspectedPaths)>,
}

#[derive(SystemParam)]
pub(crate) struct Names<'w, 's> {
    shapes: Query<'w, 's, (Option<&'static Name>, Option<&'static UsesMaterial>)>,
    materials: Query<'w, 's, (Option<&'static Name>, &'static Material)>,
    things: Query<'w, 's, NameParts>,
    renamed: Query<'w, 's, (), Or<(Changed<Name>, Changed<SceneId>)>>,
}

impl Names<'_, '_> {
    /// The name of a shape, a light or a medium.
    pub(super) fn thing(&self, entity: Entity) -> String {
        thing_name_by(self.things.get(entity).unwrap_or_default())
    }

    /// Whether anything was renamed since the system that asks ran last.
    pub(super) fn have_changed(&self) -> bool {
        !self.renamed.is_empty()
    }

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
pub(crate) fn follow_paths(
    mut inspector: ResMut<PathInspector>,
    reasons: Option<Res<Reasons>>,
    packed: Res<PackedScene>,
    names: Names,
) {
    let (Some(wanted), Some(scene), Some(view)) = (inspector.wanted, &packed.scene, &packed.view) else {
        if inspector.area.is_some() {
            inspector.paths = Arc::default();
            (inspector.area, inspector.made_of) = (None, None);
        }
        return;
    };
    let is_known = inspector
        .made_of
        .as_ref()
        .is_some_and(|(known, of, for_what)| known.is_same(scene) && of == view && *for_what == wanted);
    if is_known {
        return;
    }
    let area = wanted.area(view);
    let count = wanted.count.clamp(1, InspectedPaths::MOST);
    let found = match wanted.of {
        None => Some(first_paths(scene, view, area, count)),
        Some(group) => {
            let answer = reasons
                .as_ref()
                .and_then(|reasons| reasons.answer_about(scene, view, area));
            let things = Things::of(&packed);
            let is_of_group = |route: &Route| things.has(group, route);
            answer.map(|answer| answer.breakdown.example_paths(scene, view, is_of_group, count as usize))
        }
    };
    // Paths of a group are shown once its light is known.
    let is_found = found.is_some();
    let named = found.into_iter().flatten().map(|path| NamedPath {
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
    inspector.made_of = is_found.then(|| (scene.clone(), view.clone(), wanted));
    inspector.area = Some(area);
    inspector.paths = paths;
}

/// The first samples of a pixel, or of the pixels of an area that are spread over it.
fn first_paths(scene: &RenderScene, view: &View, area: Area, count: u32) -> Vec<RecordedPath> {
    let samples = if area.pixels() == 1 { count } else { 1 };
    let pixels = area.spread(count).into_iter();
    pixels
        .flat_map(|pixel| record_paths(scene, view, pixel, 0..samples))
        .collect()
}
