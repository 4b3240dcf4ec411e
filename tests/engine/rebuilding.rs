//! The engine from outside: what a change rebuilds, what restarts the picture, and that pictures do not depend on how
//! they are made.

use std::num::NonZeroUsize;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use bevy::asset::AssetPlugin;
use bevy::math::Affine3A;
use bevy::prelude::*;
use sunroom::color::Rgb;
use sunroom::engine::{
    EnginePlugin, EngineSystems, Limits, Outcome, Outdated, PackedScene, RenderControl, RenderError, RenderFilm,
    RenderState, RenderStatus, WakeUp, render_to_completion,
};
use sunroom::geometry::mesh::{MeshData, MtlMaterial};
use sunroom::geometry::primitives::unit_cube;
use sunroom::material;
use sunroom::render::scene::RenderScene;
use sunroom::scene::{
    AccelMethod, ActiveSensor, AreaLight, DocumentOrder, Emitter, EmitterKind, Film, InMedium, IntegratorSettings,
    InteriorMedium, Material, Medium, MeshFile, MeshHandle, MeshShape, PathPlugin, PhaseFunction, Roughness,
    SamplerSettings, ScenePlugin, SceneStatus, Sensor, Shape, ShapeKind, ToWorld, TriangleMesh, UsesMaterial,
};

/// The entities of the little scene that the tests change.
struct Room {
    app: App,
    floor: Entity,
    ball: Entity,
    lamp: Entity,
    paint: Entity,
    sky: Entity,
    sensor: Entity,
}

fn app() -> App {
    let mut app = App::new();
    app.add_plugins((MinimalPlugins, AssetPlugin::default(), ScenePlugin, EnginePlugin));
    let mut control = app.world_mut().resource_mut::<RenderControl>();
    control.threads = NonZeroUsize::MIN;
    app
}

fn shape(kind: ShapeKind) -> Shape {
    Shape {
        kind,
        ..Shape::default()
    }
}

/// A floor, a ball on it, a lamp above and a sky; 70 x 40 pixels, 6 samples.
fn room() -> Room {
    let mut app = app();
    let world = app.world_mut();
    let paint = world
        .spawn((
            DocumentOrder(0),
            Material::Diffuse {
                reflectance: Rgb::new(0.7, 0.4, 0.2).into(),
            },
        ))
        .id();
    let floor_pose = Affine3A::from_rotation_x(-90f32.to_radians()) * Affine3A::from_scale(Vec3::splat(3.0));
    let floor = world
        .spawn((
            DocumentOrder(1),
            shape(ShapeKind::Rectangle),
            ToWorld(floor_pose),
            UsesMaterial(paint),
        ))
        .id();
    let ball = world
        .spawn((
            DocumentOrder(2),
            shape(ShapeKind::Sphere {
                center: Vec3::Y,
                radius: 0.8,
            }),
            UsesMaterial(paint),
        ))
        .id();
    let lamp_pose =
        Affine3A::from_translation(Vec3::new(0.0, 3.0, 0.0)) * Affine3A::from_rotation_x(90f32.to_radians());
    let lamp = world
        .spawn((
            DocumentOrder(3),
            shape(ShapeKind::Rectangle),
            ToWorld(lamp_pose),
            AreaLight {
                radiance: Rgb::splat(5.0).into(),
                ..AreaLight::default()
            },
        ))
        .id();
    let sky = world
        .spawn((
            DocumentOrder(4),
            Emitter::from(EmitterKind::Constant {
                radiance: Rgb::splat(0.2),
            }),
        ))
        .id();
    let look = Affine3A::look_to_rh(Vec3::new(0.0, 1.5, -6.0), Vec3::NEG_Z, Vec3::Y).inverse();
    let sensor = world
        .spawn((
            DocumentOrder(5),
            Sensor::default(),
            ToWorld(look),
            Film {
                width: 70,
                height: 40,
                sample_count: 6,
                ..Film::default()
            },
        ))
        .id();
    world.insert_resource(ActiveSensor(Some(sensor)));
    Room {
        app,
        floor,
        ball,
        lamp,
        paint,
        sky,
        sensor,
    }
}

/// Which tables of a scene are the same objects as in another, and whether the picture was restarted.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Rebuilt {
    geometry: bool,
    surfaces: bool,
    materials: bool,
    lights: bool,
    restart: bool,
}

const NOTHING: Rebuilt = Rebuilt {
    geometry: false,
    surfaces: false,
    materials: false,
    lights: false,
    restart: false,
};
const RESTART: Rebuilt = Rebuilt {
    restart: true,
    ..NOTHING
};

impl Room {
    fn scene(&self) -> RenderScene {
        self.app
            .world()
            .resource::<PackedScene>()
            .scene
            .clone()
            .expect("a scene has been packed")
    }

    fn status(&self) -> RenderStatus {
        self.app.world().resource::<RenderStatus>().clone()
    }

    fn job(&self) -> u64 {
        self.app.world().resource::<RenderFilm>().job
    }

    fn last_restart(&self) -> Instant {
        self.app.world().resource::<RenderStatus>().last_restart
    }

    fn picture(&self) -> Vec<Rgb> {
        self.app.world().resource::<RenderFilm>().film.radiance()
    }

    fn get_mut<C: Component<Mutability = bevy::ecs::component::Mutable>>(&mut self, entity: Entity) -> Mut<'_, C> {
        self.app
            .world_mut()
            .get_mut::<C>(entity)
            .expect("a component of the room")
    }

    fn control(&mut self) -> Mut<'_, RenderControl> {
        self.app.world_mut().resource_mut::<RenderControl>()
    }

    fn finish(&mut self) {
        let outcome = render_to_completion(&mut self.app, &Limits::default(), |_| {});
        assert_eq!(outcome, Ok(Outcome::Complete), "{:?}", self.status().errors);
    }

    /// Updates until `reached`; the deadline is for tests that hang.
    fn update_until(&mut self, reached: impl Fn(&Self) -> bool) {
        let begin = Instant::now();
        while !reached(self) {
            assert!(begin.elapsed() < Duration::from_secs(600), "{:?}", self.status());
            self.app.update();
            std::thread::sleep(Duration::from_millis(1));
        }
    }

    fn rebuilt_by(&mut self, change: impl FnOnce(&mut Self)) -> Rebuilt {
        let (before, last_restart) = (self.scene(), self.last_restart());
        change(self);
        // Twice: what is noticed late must not be missed.
        self.app.update();
        self.app.update();
        let after = self.scene();
        Rebuilt {
            geometry: !Arc::ptr_eq(&before.geometry, &after.geometry),
            surfaces: !Arc::ptr_eq(&before.surfaces, &after.surfaces),
            materials: !Arc::ptr_eq(&before.materials, &after.materials),
            lights: !Arc::ptr_eq(&before.lights, &after.lights),
            restart: self.last_restart() != last_restart,
        }
    }
}

#[test]
fn a_change_rebuilds_what_depends_on_it_and_no_more() {
    type Change = fn(&mut Room);
    let table: [(&str, Change, Rebuilt); 19] = [
        ("nothing", |_| {}, NOTHING),
        (
            "the same pose written back",
            |room| {
                let ball = room.ball;
                room.get_mut::<ToWorld>(ball).set_changed();
            },
            NOTHING,
        ),
        (
            "the same material written back",
            |room| {
                let paint = room.paint;
                room.get_mut::<Material>(paint).set_changed();
            },
            NOTHING,
        ),
        (
            "the same settings written back",
            |room| room.control().set_changed(),
            NOTHING,
        ),
        (
            "camera moved",
            |room| {
                let sensor = room.sensor;
                room.get_mut::<ToWorld>(sensor).0.translation.x += 0.1;
            },
            RESTART,
        ),
        (
            "film smaller",
            |room| {
                let sensor = room.sensor;
                room.get_mut::<Film>(sensor).width = 50;
            },
            RESTART,
        ),
        (
            "shallower paths",
            |room| room.app.world_mut().resource_mut::<IntegratorSettings>().max_depth = Some(2),
            RESTART,
        ),
        (
            "another seed",
            |room| room.app.world_mut().resource_mut::<SamplerSettings>().seed = 7,
            RESTART,
        ),
        (
            "half the resolution",
            |room| room.control().resolution_scale = 0.5,
            RESTART,
        ),
        (
            "restart asked for",
            |room| room.control().restart_requested = true,
            RESTART,
        ),
        (
            "another colour",
            |room| {
                let paint = room.paint;
                *room.get_mut::<Material>(paint) = Material::default();
            },
            Rebuilt {
                materials: true,
                ..RESTART
            },
        ),
        (
            "a material that nobody uses gone",
            |room| {
                let unused = room.app.world_mut().spawn((DocumentOrder(9), Material::TwoSided)).id();
                room.app.update();
                room.app.world_mut().despawn(unused);
                room.app.update();
            },
            // A table came and went, and another of the same content is there now.
            Rebuilt {
                materials: true,
                ..RESTART
            },
        ),
        (
            "an object moved within the scene's bounds",
            |room| {
                let ball = room.ball;
                room.get_mut::<ToWorld>(ball).0.translation.x = 0.5;
            },
            Rebuilt {
                geometry: true,
                ..RESTART
            },
        ),
        (
            "a lamp moved",
            |room| {
                let lamp = room.lamp;
                room.get_mut::<ToWorld>(lamp).0.translation.x = 0.5;
            },
            Rebuilt {
                geometry: true,
                lights: true,
                ..RESTART
            },
        ),
        (
            "a brighter lamp",
            |room| {
                let lamp = room.lamp;
                room.get_mut::<AreaLight>(lamp).radiance = Rgb::splat(10.0).into();
            },
            Rebuilt {
                lights: true,
                ..RESTART
            },
        ),
        (
            "the lamp out",
            |room| {
                let lamp = room.lamp;
                room.app.world_mut().entity_mut(lamp).remove::<AreaLight>();
            },
            Rebuilt {
                lights: true,
                surfaces: true,
                ..RESTART
            },
        ),
        (
            "the sky gone",
            |room| {
                let sky = room.sky;
                room.app.world_mut().despawn(sky);
            },
            Rebuilt {
                lights: true,
                ..RESTART
            },
        ),
        (
            "another material",
            |room| {
                let ball = room.ball;
                room.app.world_mut().entity_mut(ball).remove::<UsesMaterial>();
            },
            Rebuilt {
                surfaces: true,
                ..RESTART
            },
        ),
        (
            "no hierarchy",
            |room| *room.app.world_mut().resource_mut::<AccelMethod>() = AccelMethod::Linear,
            Rebuilt {
                geometry: true,
                ..RESTART
            },
        ),
    ];
    for (what, change, expected) in table {
        let mut room = room();
        room.finish();
        assert_eq!(room.rebuilt_by(change), expected, "{what}");
    }
}

/// The tables that models refer to are packed anew with every change, and are the same again for the same materials.
#[test]
fn tabulated_models_are_rebuilt_only_if_they_change() {
    let mut room = room();
    let plugin = |name| Material::of_plugin(name).expect("a plugin");
    let mut metal = plugin("roughconductor");
    if let Material::RoughConductor {
        multiple_scattering, ..
    } = &mut metal
    {
        *multiple_scattering = true;
    }
    let (paint, floor) = (room.paint, room.floor);
    *room.get_mut::<Material>(paint) = plugin("roughplastic");
    let metal = room.app.world_mut().spawn((DocumentOrder(0), metal)).id();
    room.app.world_mut().entity_mut(floor).insert(UsesMaterial(metal));
    room.finish();
    let touch = |room: &mut Room| room.get_mut::<Material>(paint).set_changed();
    assert_eq!(room.rebuilt_by(touch), NOTHING);
    let polish = |room: &mut Room| {
        if let Material::RoughPlastic { alpha, .. } = &mut *room.get_mut::<Material>(paint) {
            *alpha = Roughness::Isotropic(0.05.into());
        }
    };
    let expected = Rebuilt {
        materials: true,
        ..RESTART
    };
    assert_eq!(room.rebuilt_by(polish), expected);
}

#[test]
fn a_medium_rebuilds_its_table_and_neither_geometry_nor_lights() {
    let mut room = room();
    let (ball, sensor) = (room.ball, room.sensor);
    let world = room.app.world_mut();
    world.resource_mut::<IntegratorSettings>().plugin = PathPlugin::VolPath;
    let fog = world.spawn((DocumentOrder(6), Medium::default())).id();
    world.entity_mut(ball).insert(InteriorMedium(fog));
    world.entity_mut(sensor).insert(InMedium(fog));
    room.finish();
    let medium_of_camera = |room: &Room| {
        let packed = room.app.world().resource::<PackedScene>();
        packed.view.as_ref().and_then(|view| view.medium)
    };
    assert!(medium_of_camera(&room).is_some() && !room.scene().media.is_empty());
    type Change<'c> = &'c dyn Fn(&mut Room);
    let table: [(&str, Change, bool, Rebuilt); 6] = [
        (
            "written back",
            &|room| room.get_mut::<Medium>(fog).set_changed(),
            false,
            NOTHING,
        ),
        ("denser", &|room| room.get_mut::<Medium>(fog).scale = 2.0, true, RESTART),
        (
            "another phase function",
            &|room| room.get_mut::<Medium>(fog).phase = PhaseFunction::Rayleigh,
            true,
            RESTART,
        ),
        (
            "out of the ball",
            &|room| {
                room.app.world_mut().entity_mut(ball).remove::<InteriorMedium>();
            },
            false,
            Rebuilt {
                surfaces: true,
                ..RESTART
            },
        ),
        (
            "another medium before it",
            &|room| {
                room.app.world_mut().spawn((DocumentOrder(0), Medium::default()));
            },
            true,
            RESTART,
        ),
        (
            "out of the fog",
            &|room| {
                room.app.world_mut().entity_mut(sensor).remove::<InMedium>();
            },
            false,
            RESTART,
        ),
    ];
    for (what, change, media, expected) in table {
        let before = room.scene().media;
        let rebuilt = room.rebuilt_by(change);
        let is_new = !Arc::ptr_eq(&before, &room.scene().media);
        assert_eq!((is_new, rebuilt), (media, expected), "{what}");
    }
    assert!(medium_of_camera(&room).is_none());
    room.app.world_mut().resource_mut::<IntegratorSettings>().plugin = PathPlugin::Path;
    room.finish();
    assert!(room.scene().media.is_empty());
}

#[test]
fn removed_shapes_leave_no_ghosts() {
    let mut room = room();
    room.finish();
    let count = |room: &Room| {
        let scene = room.app.world().resource::<PackedScene>();
        (
            scene.scene.as_ref().map(|scene| scene.geometry.instances().len()),
            scene.entity_of_instance.to_vec(),
        )
    };
    assert_eq!(count(&room), (Some(3), vec![room.floor, room.ball, room.lamp]));
    room.app.world_mut().despawn(room.ball);
    room.app.update();
    assert_eq!(count(&room), (Some(2), vec![room.floor, room.lamp]));
    room.app.world_mut().entity_mut(room.lamp).remove::<Shape>();
    room.app.update();
    assert_eq!(count(&room), (Some(1), vec![room.floor]));
}

#[test]
fn an_emptied_scene_is_a_black_picture() {
    let mut room = room();
    room.finish();
    assert!(room.picture().iter().any(|&radiance| radiance != Rgb::ZERO));
    for entity in [room.floor, room.ball, room.lamp, room.paint, room.sky, room.sensor] {
        room.app.world_mut().despawn(entity);
    }
    room.finish();
    assert!(room.picture().iter().all(|&radiance| radiance == Rgb::ZERO));
    assert_eq!((room.picture().len(), room.status().samples), (70 * 40, 6));
}

#[test]
fn an_app_without_a_sensor_says_so() {
    let outcome = render_to_completion(&mut app(), &Limits::default(), |_| {});
    assert_eq!(outcome, Err(RenderError::NoSensor));
}

#[test]
fn order_in_tables_is_the_documents() {
    let mut room = room();
    room.get_mut::<DocumentOrder>(room.lamp).0 = 0;
    room.finish();
    let scene = room.app.world().resource::<PackedScene>();
    assert_eq!(*scene.entity_of_instance, [room.lamp, room.floor, room.ball]);
}

#[test]
fn equal_seeds_give_equal_bits_however_the_work_is_done() {
    let picture = |threads: usize, interactive: bool, interrupted: bool| {
        let mut room = room();
        {
            let mut control = room.control();
            control.threads = NonZeroUsize::new(threads).expect("not zero");
            control.interactive = interactive;
            // Not a multiple of the longest pass.
            control.target_samples = Some(101);
        }
        if interrupted {
            let mut pauses = 0;
            while room.status().state != RenderState::Done {
                room.control().paused = pauses % 2 == 0;
                room.app.update();
                pauses += 1;
            }
            assert!(pauses > 10, "{pauses}");
        }
        room.finish();
        assert_eq!(room.job(), 1);
        assert_eq!(room.status().invalid_samples, 0);
        room.picture()
    };
    let reference = picture(1, false, false);
    for (threads, interactive, interrupted) in [(4, false, false), (4, true, false), (3, true, true)] {
        // Bits, not values: no tolerance.
        let same = picture(threads, interactive, interrupted) == reference;
        assert!(
            same,
            "{threads} threads, interactive {interactive}, interrupted {interrupted}"
        );
    }
}

#[test]
fn more_samples_continue_and_pausing_keeps_them() {
    let mut room = room();
    room.finish();
    let (job, rays) = (room.job(), room.status().rays);
    room.control().target_samples = Some(40);
    room.app.update();
    assert!(room.status().samples >= 6);
    room.control().paused = true;
    room.app.update();
    let paused = room.status();
    assert_eq!(paused.state, RenderState::Paused);
    std::thread::sleep(Duration::from_millis(20));
    room.app.update();
    assert_eq!(room.status().rays, paused.rays);
    assert_eq!(room.status().seconds, paused.seconds, "pauses do not count");
    room.control().paused = false;
    room.finish();
    assert_eq!((room.job(), room.status().samples), (job, 40));
    assert!(room.status().rays > rays);
    // Fewer than there are: they stay.
    room.control().target_samples = Some(4);
    room.app.update();
    assert_eq!(
        (room.job(), room.status().samples, room.status().state),
        (job, 40, RenderState::Done)
    );
}

#[test]
fn cancelling_is_quick_and_leaves_a_picture() {
    let mut room = room();
    room.control().film_size_override = Some(UVec2::new(1000, 1000));
    let limits = Limits {
        samples: Some(1_000_000),
        ..Limits::default()
    };
    let mut at = None;
    let cancel = limits.cancel.clone();
    let outcome = render_to_completion(&mut room.app, &limits, |status| {
        if at.is_none() && status.samples >= 1 {
            cancel.store(true, Ordering::Relaxed);
            at = Some(Instant::now());
        }
    });
    assert_eq!(outcome, Ok(Outcome::Cancelled));
    let spent = at.expect("a first pass").elapsed();
    // A row of a tile takes under a millisecond, all the samples hours; between them there is room for any machine.
    assert!(spent < Duration::from_secs(600), "{spent:?}");
    assert!(room.picture().iter().any(|&radiance| radiance != Rgb::ZERO));
}

#[test]
fn a_time_limit_ends_with_a_whole_pass() {
    let ends_with_whole_pass = |time: Duration| {
        let mut room = room();
        let limits = Limits {
            samples: Some(1_000_000),
            time: Some(time),
            ..Limits::default()
        };
        assert_eq!(
            render_to_completion(&mut room.app, &limits, |_| {}),
            Ok(Outcome::TimeUp)
        );
        let film = &room.app.world().resource::<RenderFilm>().film;
        let least = film.sample_count();
        let is_equal = |(x, y)| film.samples(x, y) == least;
        least > 0 && [(0, 0), (35, 20), (69, 39)].into_iter().all(is_equal)
    };
    // A pass that is not over soon after the limit is broken off, which may be so for the first ones where other
    // programs need the machine.
    let limits = [200, 2000, 20_000, 60_000].map(Duration::from_millis);
    assert!(limits.into_iter().any(ends_with_whole_pass));
}

#[test]
fn numbers_that_are_none_do_not_reach_the_picture() {
    let mut room = room();
    let (ball, lamp, paint, sensor) = (room.ball, room.lamp, room.paint, room.sensor);
    *room.get_mut::<Material>(paint) = Material::Diffuse {
        reflectance: Rgb::NAN.into(),
    };
    room.get_mut::<AreaLight>(lamp).radiance = Rgb::new(f32::INFINITY, 5.0, 5.0).into();
    room.get_mut::<ToWorld>(ball).0.translation.x = f32::NAN;
    room.finish();
    room.get_mut::<ToWorld>(sensor).0 = Affine3A::ZERO;
    let rebuilt = room.rebuilt_by(|_| {});
    assert_eq!(rebuilt, NOTHING, "the last good pose stays");
    assert_eq!(room.status().errors.len(), 4, "{:?}", room.status().errors);
    assert_eq!(room.status().invalid_samples, 0);
    assert!(room.picture().iter().all(|radiance| radiance.is_finite()));
}

/// A mesh of 2 n^2 triangles over [-1, 1]^2, a little bent.
fn sheet(n: u32) -> MeshData {
    let at = |i: u32| 2.0 * i as f32 / n as f32 - 1.0;
    let corner = |x: u32, y: u32| y * (n + 1) + x;
    let cells = (0..n).flat_map(|y| (0..n).map(move |x| (x, y)));
    MeshData {
        positions: (0..=n)
            .flat_map(|y| (0..=n).map(move |x| Vec3::new(at(x), at(y), 0.1 * at(x) * at(y))))
            .collect(),
        triangles: cells
            .flat_map(|(x, y)| {
                let [a, b, c, d] = [corner(x, y), corner(x + 1, y), corner(x + 1, y + 1), corner(x, y + 1)];
                [[a, b, c], [a, c, d]]
            })
            .collect(),
        ..MeshData::default()
    }
}

fn mesh_asset(data: MeshData) -> TriangleMesh {
    TriangleMesh {
        shapes: vec![MeshShape::new(data, Vec::new())],
        dependencies: Vec::new(),
    }
}

fn add_mesh(room: &mut Room, order: u32, handle: &Handle<TriangleMesh>) -> Entity {
    let bundle = (
        DocumentOrder(order),
        shape(ShapeKind::Mesh(MeshFile::default())),
        MeshHandle(handle.clone()),
    );
    room.app.world_mut().spawn(bundle).id()
}

#[test]
fn one_hierarchy_per_mesh_and_a_new_one_when_its_file_changes() {
    use sunroom::accel::Primitive;
    let mut room = room();
    let mut meshes = room.app.world_mut().resource_mut::<Assets<TriangleMesh>>();
    let (large, small) = (meshes.add(mesh_asset(sheet(70))), meshes.add(mesh_asset(unit_cube())));
    let [first, _second, _third] =
        [(6, &large), (7, &large), (8, &small)].map(|(i, mesh)| add_mesh(&mut room, i, mesh));
    room.finish();
    let blases = |room: &Room| -> Vec<_> {
        let scene = room.scene();
        let primitives = scene
            .geometry
            .instances()
            .iter()
            .map(|instance| instance.primitive.clone());
        primitives
            .filter_map(|primitive| match primitive {
                Primitive::Mesh(blas) => Some(blas),
                _ => None,
            })
            .collect()
    };
    let before = blases(&room);
    assert_eq!(before.len(), 3);
    assert!(Arc::ptr_eq(&before[0], &before[1]), "shared");
    assert_eq!(room.status().triangles, 2 * 9800 + 12);

    // Interactive: the large one is built behind the picture, which shows the old mesh until then.
    room.control().interactive = true;
    let rebuilt = room.rebuilt_by(|room| room.get_mut::<ToWorld>(first).0.translation.x = 0.2);
    assert!(rebuilt.geometry);
    assert!(
        blases(&room).iter().zip(&before).all(|(a, b)| Arc::ptr_eq(a, b)),
        "moving builds no mesh"
    );
    let handle = large.clone();
    let mut meshes = room.app.world_mut().resource_mut::<Assets<TriangleMesh>>();
    meshes.get_mut(&handle).expect("the sheet").shapes[0].data = Arc::new(sheet(80));
    room.update_until(|room| room.status().triangles == 2 * 12_800 + 12);
    let after = blases(&room);
    assert!(Arc::ptr_eq(&after[0], &after[1]) && !Arc::ptr_eq(&after[0], &before[0]));
    assert!(Arc::ptr_eq(&after[2], &before[2]), "the other mesh is as it was");

    // The asset goes: its shapes do, too.
    room.app
        .world_mut()
        .resource_mut::<Assets<TriangleMesh>>()
        .remove(&handle);
    room.update_until(|room| blases(room).len() == 1);
    assert_eq!(room.status().meshes_loading, 2);
}

#[test]
fn meshes_bring_their_own_materials_and_lights_unless_told_otherwise() {
    use sunroom::shading::Bsdf;
    let mtl = |ke: f32, pm: Option<f32>| MtlMaterial {
        name: "m".into(),
        kd: Rgb::splat(0.3),
        ks: Rgb::ZERO,
        ke: Rgb::splat(ke),
        ns: 1.0,
        ni: 1.0,
        d: 1.0,
        tf: Rgb::ONE,
        illum: None,
        pr: None,
        pm,
        maps: Default::default(),
    };
    let mut data = unit_cube();
    data.material_of_triangle = (0..12).map(|triangle| triangle / 6).collect();
    data.materials = vec![mtl(0.0, None), mtl(3.0, Some(1.0))];
    let mut room = room();
    let handle = room
        .app
        .world_mut()
        .resource_mut::<Assets<TriangleMesh>>()
        .add(mesh_asset(data));
    let cube = add_mesh(&mut room, 6, &handle);
    let twin = add_mesh(&mut room, 7, &handle);
    room.finish();
    let slots = |room: &Room| {
        let scene = room.scene();
        let first = scene.surfaces.first_slot[3] as usize;
        (scene.surfaces.slots[first..first + 4].to_vec(), scene.materials.len())
    };
    let (own, models) = slots(&room);
    assert_eq!(
        own.iter().map(|slot| slot.light.is_some()).collect::<Vec<_>>(),
        [false, true, false, true]
    );
    assert_eq!(
        (own[0].material, own[1].material),
        (own[2].material, own[3].material),
        "shared by the mesh's shapes"
    );
    let scene = room.scene();
    let Some(material::Material::TwoSided { front, .. }) = scene.materials.get(own[1].material) else {
        panic!("two-sided")
    };
    assert!(matches!(
        scene.materials.get(*front),
        Some(material::Material::Plain(Bsdf::RoughConductor(_)))
    ));
    // The two fixed ones, the paint, and two models for each of the file's.
    assert_eq!(models, 3 + 4);

    for shape in [cube, twin] {
        let bundle = (UsesMaterial(room.paint), AreaLight::default());
        room.app.world_mut().entity_mut(shape).insert(bundle);
    }
    room.app.update();
    let (given, models) = slots(&room);
    assert!(
        given
            .iter()
            .all(|slot| slot.material == given[0].material && slot.light.is_some())
    );
    assert_eq!(models, 3);
}

#[test]
fn a_picture_of_another_resolution_replaces_the_last_one_pixel_by_pixel() {
    let mut room = room();
    {
        let mut control = room.control();
        control.interactive = true;
        control.film_size_override = Some(UVec2::new(600, 400));
        control.target_samples = Some(1_000_000);
    }
    room.update_until(|room| room.status().samples >= 1);
    let film = |room: &Room| {
        let film = room.app.world().resource::<RenderFilm>();
        (film.job, film.film.width(), film.is_coarse)
    };
    let (mut job, mut width) = (room.job(), 600);
    for (scale, new_width) in [(0.5, 300), (1.0, 600)] {
        room.control().motion_scale = scale;
        while room.job() == job {
            assert_eq!(
                film(&room),
                (job, width, scale == 1.0),
                "the last picture is there until then"
            );
            room.app.update();
        }
        (job, width) = (job + 1, new_width);
        assert_eq!(film(&room), (job, width, scale < 1.0));
        // What was seen coarsely is not replaced by something coarser: no pixel is of a preview.
        let film = &room.app.world().resource::<RenderFilm>().film;
        let pixels = (0..film.height()).flat_map(|y| (0..width).map(move |x| (x, y)));
        let mut seen = 0;
        for (x, y) in pixels {
            assert_eq!(film.pixel(x, y).is_some(), film.samples(x, y) > 0, "{x}, {y}");
            seen += film.samples(x, y);
        }
        assert!(seen > 0);
        room.update_until(|room| room.status().samples >= 1);
    }
}

#[test]
fn a_moving_camera_restarts_once_per_preview_and_is_timed() {
    let mut room = room();
    let woken = Arc::new(AtomicBool::new(false));
    let flag = woken.clone();
    room.app
        .insert_resource(WakeUp(Some(Arc::new(move || flag.store(true, Ordering::Relaxed)))));
    {
        let mut control = room.control();
        control.interactive = true;
        control.film_size_override = Some(UVec2::new(600, 400));
        control.target_samples = Some(1_000_000);
    }
    room.update_until(|room| room.status().samples >= 1);
    assert!(woken.load(Ordering::Relaxed));
    let begin = Instant::now();
    let first = room.job();
    let mut frames = 0;
    while room.job() - first < 3 {
        assert!(
            begin.elapsed() < Duration::from_secs(600),
            "the picture does not follow the camera"
        );
        let sensor = room.sensor;
        room.get_mut::<ToWorld>(sensor).0.translation.x += 0.01;
        room.app.update();
        frames += 1;
    }
    let restarts = room.job() - first;
    assert!(restarts < frames, "{restarts} restarts in {frames} frames");
    // The last position is shown in the end.
    room.update_until(|room| room.status().samples >= 1);
    let latency = room.status().latency;
    assert!(latency.len() as u64 >= restarts);
    assert!(
        latency.median_ms().is_some_and(|ms| ms > 0.0),
        "{:?}",
        latency.median_ms()
    );
    println!(
        "latency: median {:?} ms, 95 % {:?} ms, {restarts} restarts",
        latency.median_ms(),
        latency.p95_ms()
    );
}

#[test]
fn another_scene_begins_without_the_picture_of_the_last() {
    #[derive(Resource, Default)]
    struct Shown(u32);
    let mut room = room();
    // What shows the scene runs before results are collected.
    let show = |film: Res<RenderFilm>, mut shown: ResMut<Shown>| shown.0 = film.film.width();
    room.app
        .init_resource::<Shown>()
        .add_systems(PostUpdate, show.before(EngineSystems::Collect));
    room.finish();
    let width = |room: &Room| room.app.world().resource::<RenderFilm>().film.width();
    let shown = |room: &Room| room.app.world().resource::<Shown>().0;
    let loaded = |room: &mut Room, fresh_load: bool| {
        let mut status = room.app.world_mut().resource_mut::<SceneStatus>();
        (status.revision, status.fresh_load) = (status.revision + 1, fresh_load);
        room.app.update();
    };
    let job = room.job();
    loaded(&mut room, false);
    assert_eq!((width(&room), room.job()), (70, job), "it was only read again");
    assert_eq!(shown(&room), 70);
    room.control().paused = true;
    loaded(&mut room, true);
    assert_eq!((width(&room), room.job()), (0, job + 1));
    assert_eq!(shown(&room), 0, "in the frame in which the scene comes");
    assert_eq!(room.status().outdated, Some(Outdated::Scene));
    room.control().paused = false;
    room.finish();
    assert_eq!((width(&room), room.status().outdated), (70, None));
}

#[test]
fn a_paused_picture_says_what_it_is_older_than() {
    let mut room = room();
    room.finish();
    room.control().paused = true;
    let outdated = |room: &mut Room, change: &dyn Fn(&mut Room)| {
        change(room);
        room.app.update();
        room.status().outdated
    };
    let (sensor, paint) = (room.sensor, room.paint);
    let shift = |room: &mut Room, by: f32| room.get_mut::<ToWorld>(sensor).0.translation.x += by;
    assert_eq!(outdated(&mut room, &|_| {}), None);
    assert_eq!(outdated(&mut room, &|room| shift(room, 1.0)), Some(Outdated::View));
    assert_eq!(outdated(&mut room, &|room| shift(room, -1.0)), None);
    let smaller = |room: &mut Room| room.control().resolution_scale = 0.5;
    assert_eq!(outdated(&mut room, &smaller), None, "it is the same with fewer pixels");
    let paint_it = |room: &mut Room| *room.get_mut::<Material>(paint) = Material::default();
    assert_eq!(outdated(&mut room, &paint_it), Some(Outdated::Scene));
    let go_on = |room: &mut Room| room.control().paused = false;
    assert_eq!(outdated(&mut room, &go_on), None);
}
