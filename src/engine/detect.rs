//! The cheap half of change detection: which tables may be out of date. Packing ([`super::extract`]) finds out whether
//! they really differ; here a value written back unchanged still counts.

use std::time::Instant;

use bevy::asset::AssetLoadFailedEvent;
use bevy::ecs::entity::EntityHashSet;
use bevy::ecs::system::SystemParam;
use bevy::prelude::*;

use super::control::{InputStamp, RenderControl};
use crate::scene::changes::Changes;
use crate::scene::{
    AccelMethod, ActiveSensor, AreaLight, DocumentOrder, Emitter, ExteriorMedium, Film, FirstNested, FreeView, Hidden,
    InMedium, InstanceOf, IntegratorSettings, InteriorMedium, Material, Medium, MemberOf, MeshHandle, Placements,
    SamplerSettings, SecondNested, Sensor, Shape, ShapeGroup, TextureMap, ToWorld, TriangleMesh, UsesMaterial,
    VolumeMap,
};

/// All shapes are packed if more than this number have changed.
const MOST_TOUCHED: usize = 4096;

/// The shapes that may have changed.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Touched {
    /// Only these entities may have changed. Some may be gone, and some may not be shapes.
    These(EntityHashSet),
    All,
}

impl Touched {
    pub fn any(&self) -> bool {
        match self {
            Self::These(shapes) => !shapes.is_empty(),
            Self::All => true,
        }
    }

    fn add(&mut self, entities: impl IntoIterator<Item = Entity>) {
        if let Self::These(shapes) = self {
            shapes.extend(entities);
            if shapes.len() > MOST_TOUCHED {
                *self = Self::All;
            }
        }
    }
}

impl Default for Touched {
    fn default() -> Self {
        Self::These(EntityHashSet::new())
    }
}

/// The tables to be packed again. Flags stay set until that is done.
#[derive(Resource, Clone, Debug, PartialEq)]
pub(super) struct Dirty {
    /// The meshes, the instances and the hierarchy over them; all tables but the view follow from these.
    pub instances: Touched,
    /// The materials and lights of shapes.
    pub surfaces: Touched,
    pub materials: bool,
    pub lights: bool,
    pub media: bool,
    pub view: bool,
    /// The time of the first change.
    pub since: Option<Instant>,
}

impl Default for Dirty {
    /// Initially all tables are dirty, because nothing has been packed yet.
    fn default() -> Self {
        Self {
            instances: Touched::All,
            surfaces: Touched::All,
            materials: true,
            lights: true,
            media: true,
            view: true,
            since: None,
        }
    }
}

impl Dirty {
    pub fn nothing() -> Self {
        Self {
            instances: Touched::default(),
            surfaces: Touched::default(),
            materials: false,
            lights: false,
            media: false,
            view: false,
            since: None,
        }
    }

    /// The changes that are left after packing: `has_shapes` tells whether the shapes are packed. Shapes that have
    /// changed while all were packed are noted already.
    pub fn left(&mut self, has_shapes: bool) -> Self {
        match has_shapes {
            true => Self {
                instances: std::mem::take(&mut self.instances),
                ..Self::nothing()
            },
            false => Self {
                view: false,
                ..std::mem::take(self)
            },
        }
    }

    /// All shapes have to be packed again.
    pub fn all_shapes(&mut self) {
        self.instances = Touched::All;
    }

    pub fn any(&self) -> bool {
        self.instances.any() || self.surfaces.any() || self.materials || self.lights || self.media || self.view
    }
}

#[derive(SystemParam)]
pub(super) struct ShapeChanges<'w, 's> {
    shapes: Changes<'w, 's, Shape>,
    poses: Changes<'w, 's, ToWorld, With<Shape>>,
    orders: Changes<'w, 's, DocumentOrder, With<Shape>>,
    mesh_handles: Changes<'w, 's, MeshHandle, With<Shape>>,
    members: Changes<'w, 's, MemberOf, With<Shape>>,
    instances: Changes<'w, 's, InstanceOf, With<Shape>>,
    placements: Changes<'w, 's, Placements, With<Shape>>,
    hidden: Query<'w, 's, Entity, (With<Shape>, Added<Hidden>)>,
    groups_gone: RemovedComponents<'w, 's, ShapeGroup>,
    uses: Changes<'w, 's, UsesMaterial, With<Shape>>,
    lights: Changes<'w, 's, AreaLight, With<Shape>>,
    interiors: Changes<'w, 's, InteriorMedium, With<Shape>>,
    exteriors: Changes<'w, 's, ExteriorMedium, With<Shape>>,
    shapes_gone: RemovedComponents<'w, 's, Shape>,
    poses_gone: RemovedComponents<'w, 's, ToWorld>,
    meshes_gone: RemovedComponents<'w, 's, MeshHandle>,
    uses_gone: RemovedComponents<'w, 's, UsesMaterial>,
    lights_gone: RemovedComponents<'w, 's, AreaLight>,
    interiors_gone: RemovedComponents<'w, 's, InteriorMedium>,
    exteriors_gone: RemovedComponents<'w, 's, ExteriorMedium>,
    shown: RemovedComponents<'w, 's, Hidden>,
    meshes: MessageReader<'w, 's, AssetEvent<TriangleMesh>>,
    failed: MessageReader<'w, 's, AssetLoadFailedEvent<TriangleMesh>>,
    method: Res<'w, AccelMethod>,
}

impl ShapeChanges<'_, '_> {
    /// Calls `visit` for the shapes whose geometry, transform or visibility may have changed.
    fn each_placed(&self, mut visit: impl FnMut(Entity)) {
        self.shapes.for_each(&mut visit);
        self.poses.for_each(&mut visit);
        self.orders.for_each(&mut visit);
        self.mesh_handles.for_each(&mut visit);
        self.members.for_each(&mut visit);
        self.instances.for_each(&mut visit);
        self.placements.for_each(&mut visit);
    }
}

#[derive(SystemParam)]
pub(super) struct MaterialChanges<'w, 's> {
    changed: Query<
        'w,
        's,
        (),
        (
            With<Material>,
            Or<(
                Changed<Material>,
                Changed<DocumentOrder>,
                Changed<FirstNested>,
                Changed<SecondNested>,
            )>,
        ),
    >,
    pictures: MessageReader<'w, 's, AssetEvent<TextureMap>>,
    failed: MessageReader<'w, 's, AssetLoadFailedEvent<TextureMap>>,
    gone: RemovedComponents<'w, 's, Material>,
    first_gone: RemovedComponents<'w, 's, FirstNested>,
    second_gone: RemovedComponents<'w, 's, SecondNested>,
}

#[derive(SystemParam)]
pub(super) struct MediumChanges<'w, 's> {
    changed: Query<'w, 's, (), (With<Medium>, Or<(Changed<Medium>, Changed<DocumentOrder>)>)>,
    volumes: MessageReader<'w, 's, AssetEvent<VolumeMap>>,
    gone: RemovedComponents<'w, 's, Medium>,
    filled: Query<'w, 's, (), With<InteriorMedium>>,
}

#[derive(SystemParam)]
pub(super) struct EmitterChanges<'w, 's> {
    changed: Query<
        'w,
        's,
        (),
        (
            With<Emitter>,
            Or<(
                Changed<Emitter>,
                Changed<ToWorld>,
                Changed<DocumentOrder>,
                Added<Hidden>,
            )>,
        ),
    >,
    gone: RemovedComponents<'w, 's, Emitter>,
}

#[derive(SystemParam)]
pub(super) struct ViewChanges<'w, 's> {
    changed: Query<
        'w,
        's,
        (),
        (
            With<Sensor>,
            Or<(Changed<Sensor>, Changed<Film>, Changed<ToWorld>, Changed<InMedium>)>,
        ),
    >,
    out_of_medium: RemovedComponents<'w, 's, InMedium>,
    active: Res<'w, ActiveSensor>,
    free_view: Res<'w, FreeView>,
    integrator: Res<'w, IntegratorSettings>,
    sampler: Res<'w, SamplerSettings>,
    control: Res<'w, RenderControl>,
}

/// Detects changes. Every reader is read to its end, because unread changes would count again in the next frame.
pub(super) fn detect_changes(
    mut dirty: ResMut<Dirty>,
    mut stamp: ResMut<InputStamp>,
    mut shapes: ShapeChanges,
    mut materials: MaterialChanges,
    mut media: MediumChanges,
    mut emitters: EmitterChanges,
    mut view: ViewChanges,
) {
    let dirty = dirty.bypass_change_detection();
    let all_instances = (shapes.groups_gone.read().count() > 0)
        | (shapes.meshes.read().count() > 0)
        | (shapes.failed.read().count() > 0)
        | shapes.method.is_changed();
    if all_instances {
        dirty.instances = Touched::All;
    }
    shapes.each_placed(|entity| dirty.instances.add([entity]));
    dirty.instances.add(shapes.hidden.iter());
    dirty.instances.add(shapes.shapes_gone.read());
    dirty.instances.add(shapes.meshes_gone.read());
    // Shapes and emitters cannot be told apart here.
    let shown: Vec<Entity> = shapes.shown.read().collect();
    // A shape, an emitter or a sensor lost its pose, which is rare.
    let pose_gone: Vec<Entity> = shapes.poses_gone.read().collect();
    shapes.uses.for_each(|entity| dirty.surfaces.add([entity]));
    shapes.lights.for_each(|entity| dirty.surfaces.add([entity]));
    dirty.surfaces.add(shapes.uses_gone.read());
    dirty.surfaces.add(shapes.lights_gone.read());
    // A medium exists if a shape with it inside is not hidden.
    let mut borders = shapes
        .hidden
        .iter()
        .chain(shown.iter().copied())
        .any(|entity| media.filled.contains(entity));
    shapes.interiors.for_each(|entity| {
        dirty.surfaces.add([entity]);
        borders = true;
    });
    shapes.exteriors.for_each(|entity| dirty.surfaces.add([entity]));
    dirty
        .surfaces
        .add(shapes.interiors_gone.read().inspect(|_| borders = true));
    dirty.surfaces.add(shapes.exteriors_gone.read());
    let materials = !materials.changed.is_empty()
        | (materials.pictures.read().count() > 0)
        | (materials.failed.read().count() > 0)
        | (materials.gone.read().count() > 0)
        | (materials.first_gone.read().count() > 0)
        | (materials.second_gone.read().count() > 0)
        // The integrator has the model of glass.
        | view.integrator.is_changed();
    let lights =
        !emitters.changed.is_empty() | (emitters.gone.read().count() > 0) | !pose_gone.is_empty() | !shown.is_empty();
    let media = borders
        | !media.changed.is_empty()
        | (media.volumes.read().count() > 0)
        | (media.gone.read().count() > 0)
        // The integrator decides whether light meets media.
        | view.integrator.is_changed();
    let view = !view.changed.is_empty()
        | (view.out_of_medium.read().count() > 0)
        | view.active.is_changed()
        | view.free_view.is_changed()
        | view.integrator.is_changed()
        | view.sampler.is_changed()
        | view.control.is_changed();
    dirty.materials |= materials;
    dirty.lights |= lights;
    dirty.media |= media;
    dirty.view |= view | !pose_gone.is_empty();
    dirty.instances.add(shown);
    dirty.instances.add(pose_gone);
    let stamped = if stamp.0.is_some() { stamp.0.take() } else { None };
    if dirty.any() {
        dirty.since = Some(dirty.since.or(stamped).unwrap_or_else(Instant::now));
    }
}
