//! Large scenes: an edit of a few shapes leaves the tables as packing everything anew would.

use std::num::NonZeroUsize;
use std::sync::Arc;
use std::time::{Duration, Instant};

use bevy::asset::AssetPlugin;
use bevy::math::Affine3A;
use bevy::prelude::*;
use sunroom::color::Rgb;
use sunroom::engine::{EnginePlugin, PackedScene, RenderControl, RenderFilm};
use sunroom::render::scene::RenderScene;
use sunroom::scene::{
    AccelMethod, ActiveSensor, AreaLight, DocumentOrder, Film, Hidden, Material, ScenePlugin, SceneStatus, Sensor,
    Shape, ShapeKind, ToWorld, UsesMaterial,
};

use crate::split_mix::Random;

const SHAPES: u32 = 2600;
/// So many that the window packs them in several frames.
const MANY_SHAPES: u32 = 16_500;

struct Field {
    app: App,
    random: Random,
    materials: Vec<Entity>,
    next_order: u32,
}

impl Field {
    fn new(shapes: u32) -> Self {
        let mut app = App::new();
        app.add_plugins((MinimalPlugins, AssetPlugin::default(), ScenePlugin, EnginePlugin));
        let world = app.world_mut();
        let mut control = world.resource_mut::<RenderControl>();
        control.threads = NonZeroUsize::MIN;
        control.paused = true;
        let film = Film {
            width: 8,
            height: 8,
            ..Film::default()
        };
        let sensor = world.spawn((DocumentOrder(0), Sensor::default(), ToWorld::default(), film));
        let sensor = sensor.id();
        world.insert_resource(ActiveSensor(Some(sensor)));
        let materials = (1..5).map(|order| {
            let reflectance = Rgb::splat(0.1 * order as f32).into();
            world
                .spawn((DocumentOrder(order), Material::Diffuse { reflectance }))
                .id()
        });
        let materials = materials.collect();
        let mut field = Self {
            app,
            random: Random(1),
            materials,
            next_order: 5,
        };
        for _ in 0..shapes {
            field.add();
        }
        field
    }

    fn pose(&mut self) -> ToWorld {
        let place = Vec3::from_array([(); 3].map(|()| 0.05 * self.random.below(1000) as f32));
        ToWorld(Affine3A::from_translation(place))
    }

    fn add(&mut self) -> Entity {
        let kind = match self.random.below(6) {
            0 => ShapeKind::Cube,
            1 => ShapeKind::Rectangle,
            2 => ShapeKind::Cylinder {
                p0: Vec3::ZERO,
                p1: Vec3::Z,
                radius: 0.2,
            },
            _ => ShapeKind::Sphere {
                center: Vec3::ZERO,
                radius: 0.4,
            },
        };
        let shape = Shape {
            kind,
            ..Shape::default()
        };
        let pose = self.pose();
        let material = self.material();
        let order = DocumentOrder(self.next_order);
        self.next_order += 1;
        let world = self.app.world_mut();
        world.spawn((order, shape, pose, UsesMaterial(material))).id()
    }

    fn material(&mut self) -> Entity {
        *self.random.one_of(&self.materials)
    }

    fn shapes(&mut self) -> Vec<Entity> {
        let world = self.app.world_mut();
        let mut shapes = world.query_filtered::<(&DocumentOrder, Entity), With<Shape>>();
        let mut shapes: Vec<_> = shapes.iter(world).map(|(order, entity)| (*order, entity)).collect();
        shapes.sort();
        shapes.into_iter().map(|(_, entity)| entity).collect()
    }

    /// The shapes that are seen, in their order.
    fn shown(&mut self) -> Vec<Entity> {
        let mut shapes = self.shapes();
        let world = self.app.world();
        shapes.retain(|entity| {
            let entity = world.entity(*entity);
            let pose = entity.get::<ToWorld>().expect("shapes have poses");
            !entity.contains::<Hidden>() && pose.0 != Affine3A::ZERO
        });
        shapes
    }

    /// One edit of any kind.
    fn edit(&mut self) {
        let shapes = self.shapes();
        let entity = *self.random.one_of(&shapes);
        let (pose, material) = (self.pose(), self.material());
        let kind = self.random.below(14);
        if kind == 0 {
            self.add();
            return;
        }
        let mut it = self.app.world_mut().entity_mut(entity);
        match kind {
            1 => it.despawn(),
            2 => drop(it.insert(Hidden)),
            3 => drop(it.remove::<Hidden>()),
            4 => drop(it.insert(UsesMaterial(material))),
            5 => drop(it.remove::<UsesMaterial>()),
            6 => drop(it.insert(AreaLight::default())),
            7 => drop(it.remove::<AreaLight>()),
            8 => drop(it.insert(DocumentOrder(3 + pose.0.translation.x as u32 * 40))),
            9 => drop(it.insert(ToWorld(Affine3A::ZERO))),
            10 => drop(it.remove::<Shape>()),
            11 => {
                let radius = 0.1 + 0.01 * pose.0.translation.x;
                let center = Vec3::Y;
                let kind = ShapeKind::Sphere { center, radius };
                it.insert(Shape {
                    kind,
                    flip_normals: true,
                    ..Shape::default()
                });
            }
            _ => drop(it.insert(pose)),
        }
    }

    fn packed(&self) -> &PackedScene {
        self.app.world().resource::<PackedScene>()
    }

    fn scene(&self) -> RenderScene {
        self.packed().scene.clone().expect("a scene has been packed")
    }
}

#[test]
fn edits_leave_the_tables_as_packing_all_would() {
    let mut field = Field::new(SHAPES);
    field.app.update();
    for step in 0..150 {
        for _ in 0..1 + step % 3 {
            field.edit();
        }
        field.app.update();
        let edited = field.scene();
        let entities = field.packed().entity_of_instance.clone();
        // What is seen is what the entities say, in their order.
        let shown = field.shown();
        let world = field.app.world();
        assert_eq!(*entities, shown, "step {step}");
        for (entity, instance) in shown.iter().zip(edited.geometry.instances().iter()) {
            let entity = world.entity(*entity);
            let (shape, pose) = (entity.get::<Shape>(), entity.get::<ToWorld>());
            let (shape, pose) = (shape.expect("a shape"), pose.expect("a pose").0);
            let local = match shape.kind {
                ShapeKind::Sphere { center, .. } => center,
                _ => Vec3::ZERO,
            };
            assert_eq!(
                instance.world_from_local.translation,
                (pose * Affine3A::from_translation(local)).translation
            );
            assert_eq!(instance.flip_normals, shape.flip_normals);
        }
        // Everything is packed anew, and nothing differs.
        field.app.world_mut().resource_mut::<AccelMethod>().set_changed();
        field.app.update();
        let anew = field.scene();
        assert!(Arc::ptr_eq(&edited.geometry, &anew.geometry), "step {step}");
        assert!(Arc::ptr_eq(&edited.surfaces, &anew.surfaces), "step {step}");
        assert!(Arc::ptr_eq(&edited.materials, &anew.materials), "step {step}");
        assert!(Arc::ptr_eq(&edited.lights, &anew.lights), "step {step}");
    }
}

#[test]
fn edits_while_many_shapes_are_packed_are_packed_afterwards() {
    let mut field = Field::new(MANY_SHAPES);
    field.app.world_mut().resource_mut::<RenderControl>().interactive = true;
    field.app.update();
    assert!(
        field.packed().entity_of_instance.is_empty(),
        "one frame does not pack so many"
    );
    let begin = Instant::now();
    while field.packed().entity_of_instance.is_empty() {
        field.edit();
        field.app.update();
        assert!(begin.elapsed() < Duration::from_secs(600), "they are never packed");
    }
    // The last edit is packed with all those before it.
    let shown = field.shown();
    let (last, place) = (shown[0], Vec3::splat(100.0));
    let kind = ShapeKind::Cube;
    let pose = ToWorld(Affine3A::from_translation(place));
    let moved = (
        Shape {
            kind,
            ..Shape::default()
        },
        pose,
    );
    field.app.world_mut().entity_mut(last).insert(moved);
    let is_packed = |field: &Field| {
        let instances = field.scene();
        let first = instances
            .geometry
            .instances()
            .iter()
            .next()
            .map(|it| it.world_from_local.translation);
        first == Some(place.into())
    };
    while !is_packed(&field) {
        std::thread::sleep(Duration::from_millis(1));
        field.app.update();
        assert!(begin.elapsed() < Duration::from_secs(600), "edits are never packed");
    }
    assert_eq!(*field.packed().entity_of_instance, shown);
    let edited = field.scene();
    let world = field.app.world_mut();
    world.resource_mut::<RenderControl>().interactive = false;
    world.resource_mut::<AccelMethod>().set_changed();
    field.app.update();
    let anew = field.scene();
    assert!(Arc::ptr_eq(&edited.geometry, &anew.geometry));
    assert!(Arc::ptr_eq(&edited.surfaces, &anew.surfaces));
    assert!(Arc::ptr_eq(&edited.materials, &anew.materials));
    assert!(Arc::ptr_eq(&edited.lights, &anew.lights));
}

#[test]
fn nothing_of_the_scene_before_is_rendered_while_many_shapes_are_packed() {
    let mut field = Field::new(10);
    let mut control = field.app.world_mut().resource_mut::<RenderControl>();
    (control.interactive, control.paused) = (true, false);
    let width = |field: &Field| field.app.world().resource::<RenderFilm>().film.width();
    let begin = Instant::now();
    let update = |field: &mut Field| {
        field.app.update();
        std::thread::sleep(Duration::from_millis(2));
        assert!(begin.elapsed() < Duration::from_secs(600), "it takes too long");
    };
    while width(&field) == 0 {
        update(&mut field);
    }
    // Another scene.
    for _ in 0..MANY_SHAPES {
        field.add();
    }
    let world = field.app.world_mut();
    world.resource_mut::<AccelMethod>().set_changed();
    let mut status = world.resource_mut::<SceneStatus>();
    (status.revision, status.fresh_load) = (status.revision + 1, true);
    let mut frames = 0;
    loop {
        update(&mut field);
        if field.packed().entity_of_instance.len() > 10 {
            break;
        }
        assert_eq!(width(&field), 0, "frame {frames}");
        frames += 1;
    }
    assert!(frames > 0, "one frame does not pack so many");
    while width(&field) == 0 {
        update(&mut field);
    }
}

/// Most of an edited hierarchy is the same memory.
#[test]
fn an_edit_keeps_the_rest_of_the_hierarchy() {
    let mut field = Field::new(SHAPES);
    field.app.update();
    let before = field.scene();
    let moved = field.shapes()[1000];
    let pose = field.pose();
    field.app.world_mut().entity_mut(moved).insert(pose);
    field.app.update();
    let after = field.scene();
    let (before, after) = (before.geometry.instances(), after.geometry.instances());
    let is_shared = |number: &usize| std::ptr::eq(&before[*number], &after[*number]);
    let shared = (0..before.len()).filter(is_shared).count();
    assert!(shared < before.len() && shared > before.len() - 100, "{shared}");
}
