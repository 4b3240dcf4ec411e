//! The stand-in boxes for meshes whose files are missing or broken.

use std::collections::{HashMap, HashSet};
use std::path::{Path, PathBuf};

use bevy::ecs::system::SystemParam;
use bevy::math::Affine3A;
use bevy::prelude::*;

use crate::math::Aabb;
use crate::scene::{
    Hidden, InstanceOf, Instances, MemberOf, MeshFile, MeshHandle, Placements, SceneStatus, Shape, ShapeKind, ToWorld,
    TriangleMesh,
};

/// The most meshes whose bounds are kept.
const MOST_MESHES: usize = 100_000;

/// The bounds, in their own space, of all meshes loaded since the program was started.
#[derive(Resource, Debug, Default)]
pub struct KnownBounds(HashMap<(PathBuf, u32), Aabb>);

impl KnownBounds {
    /// The stand-in box of a missing mesh: its bounds when it was last loaded, or else a box of length 1 around the
    /// origin.
    pub fn of(&self, mesh: &MeshFile) -> Aabb {
        let known = self.0.get(&(mesh.path.clone(), mesh.shape_index));
        known
            .copied()
            .unwrap_or_else(|| Aabb::from_points([Vec3::splat(-0.5), Vec3::splat(0.5)]))
    }
}

/// Records the bounds of meshes that have arrived.
pub(in crate::scene) fn note_bounds(
    mut known: ResMut<KnownBounds>,
    server: Res<AssetServer>,
    meshes: Res<Assets<TriangleMesh>>,
    mut events: MessageReader<AssetEvent<TriangleMesh>>,
) {
    for event in events.read() {
        if let AssetEvent::Added { id } | AssetEvent::Modified { id } = event
            && let Some(mesh) = meshes.get(*id)
            && let Some(path) = server.get_path(*id)
        {
            if known.0.len() > MOST_MESHES {
                known.0.clear();
            }
            for (index, shape) in (0..).zip(&mesh.shapes) {
                if !shape.bounds.is_empty() && shape.bounds.extent().is_finite() {
                    known.0.insert((path.path().to_owned(), index), shape.bounds);
                }
            }
        }
    }
}

/// Finds the shapes without their meshes.
#[derive(SystemParam)]
pub struct StandIns<'w, 's> {
    status: Res<'w, SceneStatus>,
    known: Res<'w, KnownBounds>,
    meshes: Res<'w, Assets<TriangleMesh>>,
    shapes: Query<'w, 's, (Entity, &'static Shape, &'static ToWorld, &'static MeshHandle)>,
    members: Query<'w, 's, &'static MemberOf>,
    groups: Query<'w, 's, &'static Instances>,
    instances: Query<'w, 's, &'static ToWorld, SeenInstance>,
}

/// Crowds have no boxes: they would hide the picture.
type SeenInstance = (With<InstanceOf>, Without<Hidden>, Without<Placements>);

/// The most boxes of a group's member.
const MOST_PLACES: usize = 1000;

impl StandIns<'_, '_> {
    /// Whether the list of [`Self::shapes`] may have changed since the last frame. The shapes themselves may change as
    /// well.
    pub fn may_differ(&self) -> bool {
        self.status.is_changed()
    }

    /// The shapes without a mesh to show, because of their files.
    pub fn shapes(&self) -> Vec<Entity> {
        let paths: HashSet<&Path> = self
            .status
            .mesh_errors
            .iter()
            .map(|error| error.path.as_path())
            .collect();
        if paths.is_empty() {
            return Vec::new();
        }
        let shapes = self.shapes.iter().filter(|(_, shape, _, handle)| {
            let ShapeKind::Mesh(file) = &shape.kind else {
                return false;
            };
            paths.contains(&*file.path)
                && self
                    .meshes
                    .get(&handle.0)
                    .and_then(|mesh| mesh.data(file.shape_index))
                    .is_none()
        });
        shapes.map(|(entity, ..)| entity).collect()
    }

    /// The instances of such a shape: the transform world from its own space, and the entity that a click there
    /// selects, the shape or an instance of its group.
    pub fn places(&self, entity: Entity) -> Vec<(Entity, Affine3A)> {
        let Ok((_, _, to_world, _)) = self.shapes.get(entity) else {
            return Vec::new();
        };
        let Ok(MemberOf(group)) = self.members.get(entity) else {
            return vec![(entity, to_world.0)];
        };
        let instances = self
            .groups
            .get(*group)
            .into_iter()
            .flat_map(|instances| instances.iter());
        let places =
            instances.filter_map(|instance| Some((instance, self.instances.get(instance).ok()?.0 * to_world.0)));
        places.take(MOST_PLACES).collect()
    }

    /// The box of such a shape, in its own space.
    pub fn bounds(&self, entity: Entity) -> Option<Aabb> {
        let (_, shape, ..) = self.shapes.get(entity).ok()?;
        match &shape.kind {
            ShapeKind::Mesh(file) => Some(self.known.of(file)),
            _ => None,
        }
    }
}
