//! Finds shapes with a medium inside that are not closed. The edges of a mesh are counted once, on other threads than
//! the window's.

use std::sync::{Arc, Weak};

use bevy::ecs::entity::EntityHashMap;
use bevy::ecs::query::QueryData;
use bevy::platform::collections::HashMap;
use bevy::prelude::*;
use bevy::tasks::{AsyncComputeTaskPool, Task, TaskPool, block_on, poll_once};

use crate::geometry::mesh::MeshData;
use crate::scene::{InteriorMedium, MeshHandle, Shape, ShapeKind, TriangleMesh};

/// The shapes with a medium inside that are not closed.
#[derive(Resource, Default)]
pub struct Leaks {
    /// The leak of each shape as a sentence, with its name.
    found: EntityHashMap<(String, String)>,
    /// The numbers of open edges of meshes, by the meshes' addresses.
    meshes: HashMap<usize, Counted>,
}

struct Counted {
    mesh: Weak<MeshData>,
    open_edges: OpenEdges,
}

enum OpenEdges {
    Known(usize),
    Awaited(Task<usize>),
}

impl Leaks {
    /// The leak of a shape; None if it is closed, or has no medium inside.
    pub fn of(&self, shape: Entity) -> Option<&str> {
        self.found.get(&shape).map(|(_, reason)| reason.as_str())
    }

    /// One message for each shape, in the order of their names.
    pub fn messages(&self) -> Vec<String> {
        let mut messages: Vec<String> = self
            .found
            .values()
            .map(|(name, reason)| format!("`{name}` has a medium inside, but is not closed. {reason}"))
            .collect();
        messages.sort();
        messages
    }

    fn is_awaiting(&self) -> bool {
        let awaited = |counted: &Counted| matches!(counted.open_edges, OpenEdges::Awaited(_));
        self.meshes.values().any(awaited)
    }

    /// The open edges of a mesh; None while they are being counted.
    fn open_edges(&mut self, mesh: &Arc<MeshData>) -> Option<usize> {
        let counted = self.meshes.entry(Arc::as_ptr(mesh) as usize).or_insert_with(|| {
            let pool = AsyncComputeTaskPool::get_or_init(TaskPool::default);
            let counts = mesh.clone();
            Counted {
                mesh: Arc::downgrade(mesh),
                open_edges: OpenEdges::Awaited(pool.spawn(async move { counts.open_edges() })),
            }
        });
        if let OpenEdges::Awaited(task) = &mut counted.open_edges
            && let Some(count) = block_on(poll_once(task))
        {
            counted.open_edges = OpenEdges::Known(count);
        }
        match counted.open_edges {
            OpenEdges::Known(count) => Some(count),
            OpenEdges::Awaited(_) => None,
        }
    }
}

#[derive(QueryData)]
pub(crate) struct Filled {
    entity: Entity,
    name: Option<&'static Name>,
    shape: &'static Shape,
    mesh: Option<&'static MeshHandle>,
}

/// A change of the components in [`Filled`].
type IsNew = (
    With<InteriorMedium>,
    Or<(
        Added<InteriorMedium>,
        Changed<Shape>,
        Changed<MeshHandle>,
        Changed<Name>,
    )>,
);

/// Checks shapes again when their components have changed.
pub(crate) fn find_leaks(
    mut leaks: ResMut<Leaks>,
    filled: Query<Filled, With<InteriorMedium>>,
    new: Query<(), IsNew>,
    mut emptied: RemovedComponents<InteriorMedium>,
    meshes: Res<Assets<TriangleMesh>>,
) {
    let is_news = !new.is_empty() | (emptied.read().count() > 0);
    let is_loaded = meshes.is_changed() && !filled.is_empty();
    if !is_news && !is_loaded && !leaks.is_awaiting() {
        return;
    }
    let found: EntityHashMap<(String, String)> = filled
        .iter()
        .filter_map(|it| {
            let reason = match &it.shape.kind {
                ShapeKind::Mesh(file) if !file.format.is_of_curves() => {
                    let mesh = meshes.get(&it.mesh?.0)?.data(file.shape_index)?;
                    let count = leaks.bypass_change_detection().open_edges(mesh);
                    of_mesh(count?)?
                }
                kind => of_kind(kind)?.to_owned(),
            };
            let name = it.name.map_or("the shape", Name::as_str);
            Some((it.entity, (name.to_owned(), reason)))
        })
        .collect();
    let known = leaks.bypass_change_detection();
    known.meshes.retain(|_, counted| counted.mesh.strong_count() > 0);
    if known.found != found {
        leaks.found = found;
    }
}

/// The leak of a shape of this kind; None if it is closed.
fn of_kind(kind: &ShapeKind) -> Option<&'static str> {
    match kind {
        ShapeKind::Rectangle => Some("A rectangle has no inside."),
        ShapeKind::Disk => Some("A disk has no inside."),
        ShapeKind::Triangle { .. } => Some("A triangle has no inside."),
        ShapeKind::Cylinder { .. } => Some("A cylinder has open ends."),
        ShapeKind::Mesh(file) if file.format.is_of_curves() => Some("Rays pass through curves from within."),
        ShapeKind::Sphere { .. }
        | ShapeKind::Cube
        | ShapeKind::Solid(_)
        | ShapeKind::Mesh(_)
        | ShapeKind::Instance
        | ShapeKind::Frame => None,
    }
}

fn of_mesh(open_edges: usize) -> Option<String> {
    match open_edges {
        0 => None,
        1 => Some("One edge of its mesh has no triangle on its other side.".to_owned()),
        count => Some(format!(
            "{count} edges of its mesh have no triangle on their other side."
        )),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::primitives::unit_cube;
    use crate::scene::{Medium, MeshFile, MeshShape};

    #[test]
    fn open_shapes_are_found_when_they_are_filled_and_forgotten_when_emptied() {
        let mut world = World::new();
        world.init_resource::<Leaks>();
        let mut open = unit_cube();
        open.triangles.pop();
        let mut meshes = Assets::<TriangleMesh>::default();
        let mut mesh = |data: MeshData| {
            let shape = MeshShape::new(data, Vec::new());
            let handle = meshes.add(TriangleMesh {
                shapes: vec![shape],
                dependencies: Vec::new(),
            });
            (ShapeKind::Mesh(MeshFile::default()), Some(MeshHandle(handle)))
        };
        let kinds = [
            (ShapeKind::Cube, None),
            (ShapeKind::Disk, None),
            mesh(unit_cube()),
            mesh(open),
        ];
        world.insert_resource(meshes);
        let fog = world.spawn(Medium::default()).id();
        let shapes = kinds.map(|(kind, handle)| {
            let shape = Shape {
                kind,
                ..Shape::default()
            };
            let entity = world.spawn((shape, InteriorMedium(fog), Name::new("thing"))).id();
            if let Some(handle) = handle {
                world.entity_mut(entity).insert(handle);
            }
            entity
        });
        let find = world.register_system(find_leaks);
        for _ in 0..1000 {
            world.run_system(find).expect("it runs");
            if !world.resource::<Leaks>().is_awaiting() {
                break;
            }
            std::thread::sleep(std::time::Duration::from_millis(5));
        }
        let leaks = world.resource::<Leaks>();
        assert_eq!(
            shapes.map(|shape| leaks.of(shape).is_some()),
            [false, true, false, true]
        );
        assert!(leaks.of(shapes[3]).is_some_and(|reason| reason.starts_with("3 edges")));
        assert_eq!(leaks.messages().len(), 2);
        world.entity_mut(shapes[1]).remove::<InteriorMedium>();
        world.run_system(find).expect("it runs");
        assert_eq!(world.resource::<Leaks>().of(shapes[1]), None);
    }
}
