//! The cheap half of noticing change: which tables may be out of date. Whether anything really differs is found out by packing
//! ([`super::extract`]); here a value written back unchanged still counts.

use std::time::Instant;

use bevy::asset::AssetLoadFailedEvent;
use bevy::ecs::system::SystemParam;
use bevy::prelude::*;

use super::control::{InputStamp, RenderControl};
use crate::scene::{
    AccelMethod, ActiveSensor, AreaLight, DocumentOrder, Emitter, Film, FirstNested, FreeView, Hidden, InstanceOf,
    IntegratorSettings, Material, MemberOf, MeshHandle, Placements, SamplerSettings, SecondNested, Sensor, Shape,
    ShapeGroup, TextureMap, ToWorld, TriangleMesh, UsesMaterial,
};

/// The tables to be packed again. Flags stay until that is done.
#[derive(Resource, Clone, Copy, Debug, PartialEq)]
pub(super) struct Dirty {
    /// The meshes, the instances and the hierarchy over them; all others but the view follow.
    pub instances: bool,
    pub surfaces: bool,
    pub materials: bool,
    pub lights: bool,
    pub view: bool,
    /// The time of the first of these changes.
    pub since: Option<Instant>,
}

impl Default for Dirty {
    /// Everything has changed, because nothing has been packed yet.
    fn default() -> Self {
        Self {
            instances: true,
            surfaces: true,
            materials: true,
            lights: true,
            view: true,
            since: None,
        }
    }
}

impl Dirty {
    pub const NOTHING: Self = Self {
        instances: false,
        surfaces: false,
        materials: false,
        lights: false,
        view: false,
        since: None,
    };

    pub fn any(&self) -> bool {
        self.instances || self.surfaces || self.materials || self.lights || self.view
    }
}

#[derive(SystemParam)]
pub(super) struct ShapeChanges<'w, 's> {
    placed: Query<
        'w,
        's,
        (),
        (
            With<Shape>,
            Or<(
                Changed<Shape>,
                Changed<ToWorld>,
                Changed<DocumentOrder>,
                Changed<MeshHandle>,
                Changed<MemberOf>,
                Changed<InstanceOf>,
                Changed<Placements>,
                Added<Hidden>,
            )>,
        ),
    >,
    groups_gone: RemovedComponents<'w, 's, ShapeGroup>,
    clad: Query<'w, 's, (), (With<Shape>, Or<(Changed<UsesMaterial>, Changed<AreaLight>)>)>,
    shapes_gone: RemovedComponents<'w, 's, Shape>,
    poses_gone: RemovedComponents<'w, 's, ToWorld>,
    meshes_gone: RemovedComponents<'w, 's, MeshHandle>,
    uses_gone: RemovedComponents<'w, 's, UsesMaterial>,
    lights_gone: RemovedComponents<'w, 's, AreaLight>,
    shown: RemovedComponents<'w, 's, Hidden>,
    meshes: MessageReader<'w, 's, AssetEvent<TriangleMesh>>,
    failed: MessageReader<'w, 's, AssetLoadFailedEvent<TriangleMesh>>,
    method: Res<'w, AccelMethod>,
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
    gone: RemovedComponents<'w, 's, Material>,
    first_gone: RemovedComponents<'w, 's, FirstNested>,
    second_gone: RemovedComponents<'w, 's, SecondNested>,
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
    changed: Query<'w, 's, (), (With<Sensor>, Or<(Changed<Sensor>, Changed<Film>, Changed<ToWorld>)>)>,
    active: Res<'w, ActiveSensor>,
    free_view: Res<'w, FreeView>,
    integrator: Res<'w, IntegratorSettings>,
    sampler: Res<'w, SamplerSettings>,
    control: Res<'w, RenderControl>,
}

/// Detects changes. Every reader is read to its end, because the rest would count again in the next frame.
pub(super) fn detect_changes(
    mut dirty: ResMut<Dirty>,
    mut stamp: ResMut<InputStamp>,
    mut shapes: ShapeChanges,
    mut materials: MaterialChanges,
    mut emitters: EmitterChanges,
    view: ViewChanges,
) {
    let instances = !shapes.placed.is_empty()
        | (shapes.shapes_gone.read().count() > 0)
        | (shapes.groups_gone.read().count() > 0)
        | (shapes.meshes_gone.read().count() > 0)
        | (shapes.meshes.read().count() > 0)
        | (shapes.failed.read().count() > 0)
        | shapes.method.is_changed();
    // Shapes and emitters cannot be told apart here.
    let shown = shapes.shown.read().count() > 0;
    // A shape, an emitter or a sensor lost its pose, which is rare.
    let pose_gone = shapes.poses_gone.read().count() > 0;
    let surfaces =
        !shapes.clad.is_empty() | (shapes.uses_gone.read().count() > 0) | (shapes.lights_gone.read().count() > 0);
    let materials = !materials.changed.is_empty()
        | (materials.pictures.read().count() > 0)
        | (materials.gone.read().count() > 0)
        | (materials.first_gone.read().count() > 0)
        | (materials.second_gone.read().count() > 0)
        // Holds the model of glass.
        | view.integrator.is_changed();
    let lights = !emitters.changed.is_empty() | (emitters.gone.read().count() > 0) | pose_gone | shown;
    let view = !view.changed.is_empty()
        | view.active.is_changed()
        | view.free_view.is_changed()
        | view.integrator.is_changed()
        | view.sampler.is_changed()
        | view.control.is_changed();
    let before = *dirty;
    let after = Dirty {
        instances: before.instances | instances | pose_gone | shown,
        surfaces: before.surfaces | surfaces,
        materials: before.materials | materials,
        lights: before.lights | lights,
        view: before.view | view | pose_gone,
        since: before.since,
    };
    let stamped = if stamp.0.is_some() { stamp.0.take() } else { None };
    if after.any() {
        *dirty = Dirty {
            since: Some(before.since.or(stamped).unwrap_or_else(Instant::now)),
            ..after
        };
    }
}
