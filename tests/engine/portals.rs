//! Portals follow the openings of walls, marked rectangles, and what stands before them.

use std::f32::consts::{FRAC_PI_2, PI};

use bevy::asset::AssetPlugin;
use bevy::math::Affine3A;
use bevy::prelude::*;
use sunroom::color::Rgb;
use sunroom::engine::{EnginePlugin, PackedScene};
use sunroom::light::{LightId, LightReference};
use sunroom::scene::{
    ActiveSensor, DocumentOrder, Emitter, EmitterKind, Film, Opening, ScenePlugin, Sensor, Shape, ShapeKind, Solid,
    ToWorld,
};

/// A closed room 4 by 4 by 2.5, z upwards, below a white sky, with a window in the wall along y = 0.
struct Room {
    app: App,
    wall: Entity,
    board: Entity,
}

const FREE: f32 = 1.0 / (4.0 * PI);

const WINDOW: Opening = Opening {
    from: 1.0,
    sill: 0.8,
    width: 1.4,
    height: 1.2,
};

fn wall(openings: Vec<Opening>) -> Shape {
    let kind = ShapeKind::Solid(Solid::Wall {
        length: 4.0,
        height: 2.5,
        thickness: 0.2,
        openings,
    });
    Shape {
        kind,
        ..Shape::default()
    }
}

fn plate(size: Vec3, at: Vec3) -> (Shape, ToWorld) {
    let place = Affine3A::from_scale_rotation_translation(size, Quat::IDENTITY, at);
    (Shape::default(), ToWorld(place))
}

impl Room {
    fn new() -> Self {
        let mut app = App::new();
        app.add_plugins((MinimalPlugins, AssetPlugin::default(), ScenePlugin, EnginePlugin));
        let world = app.world_mut();
        let mut order = 0..;
        let mut next = || DocumentOrder(order.next().unwrap_or_default());
        let upright = |corner: Vec3, angle: f32| {
            ToWorld(Affine3A::from_rotation_translation(
                Quat::from_rotation_z(angle),
                corner,
            ))
        };
        let first = world.spawn((next(), wall(vec![WINDOW]), upright(Vec3::ZERO, 0.0))).id();
        for (corner, angle) in [
            (Vec3::X * 4.0, FRAC_PI_2),
            (Vec3::new(4.0, 4.0, 0.0), PI),
            (Vec3::Y * 4.0, -FRAC_PI_2),
        ] {
            world.spawn((next(), wall(Vec::new()), upright(corner, angle)));
        }
        for height in [0.0, 2.5] {
            world.spawn((next(), plate(Vec3::new(2.1, 2.1, 1.0), Vec3::new(2.0, 2.0, height))));
        }
        let board = world.spawn((next(), plate(Vec3::ONE, Vec3::X * 50.0))).id();
        let white = EmitterKind::Constant { radiance: Rgb::ONE };
        world.spawn((next(), Emitter::from(white)));
        let film = Film {
            width: 8,
            height: 8,
            ..Film::default()
        };
        let sensor = world.spawn((next(), Sensor::default(), ToWorld::default(), film)).id();
        world.insert_resource(ActiveSensor(Some(sensor)));
        Self {
            app,
            wall: first,
            board,
        }
    }

    /// The density of the direction from the middle of the room to a place.
    fn density(&mut self, to: Vec3) -> f32 {
        self.app.update();
        let packed = self.app.world().resource::<PackedScene>();
        let scene = packed.scene.as_ref().expect("a scene has been packed");
        let position = Vec3::new(2.0, 2.0, 1.2);
        let from = LightReference { position, normal: None };
        let wi = (to - position).normalize();
        scene.lights.radiance_and_pdf_from(LightId(0), &from, wi).1
    }

    fn set<C: Component>(&mut self, entity: Entity, component: C) {
        self.app.world_mut().entity_mut(entity).insert(component);
    }
}

fn middle(window: Opening) -> Vec3 {
    Vec3::new(window.from + 0.5 * window.width, 0.0, window.sill + 0.5 * window.height)
}

#[test]
fn portals_follow_the_openings_of_walls() {
    let mut room = Room::new();
    let window = middle(WINDOW);
    let at_first = room.density(window);
    assert!(at_first > 3.0 * FREE, "{at_first}");
    assert!(room.density(Vec3::Y * 4.0) < 0.5 * FREE);
    // Another window, none, and the first again.
    let small = Opening {
        from: 3.0,
        width: 0.6,
        ..WINDOW
    };
    room.set(room.wall, wall(vec![small]));
    assert!(room.density(middle(small)) > 10.0 * FREE);
    assert!(room.density(window) < 0.5 * FREE);
    room.set(room.wall, wall(Vec::new()));
    assert_eq!(room.density(window), FREE);
    room.set(room.wall, wall(vec![WINDOW]));
    assert_eq!(room.density(window), at_first);
    // A wall that is moved takes its portals along, and one that is deleted leaves none.
    room.set(room.wall, ToWorld(Affine3A::from_translation(Vec3::new(0.7, 0.0, 0.1))));
    assert!(room.density(window + Vec3::new(1.3, 0.0, 0.1)) > 3.0 * FREE);
    room.app.world_mut().despawn(room.wall);
    assert_eq!(room.density(window), FREE);
}

#[test]
fn what_stands_before_a_window_counts() {
    let mut room = Room::new();
    let window = middle(WINDOW);
    let open = room.density(window);
    let shutter = |y: f32| {
        let turned = Quat::from_rotation_x(FRAC_PI_2);
        let at = Vec3::new(2.0, y, 1.25);
        ToWorld(Affine3A::from_scale_rotation_translation(
            Vec3::new(3.0, 3.0, 1.0),
            turned,
            at,
        ))
    };
    room.set(room.board, shutter(-0.2));
    assert_eq!(room.density(window), FREE);
    room.set(room.board, shutter(-60.0));
    assert!(room.density(window) > 3.0 * FREE && open > 3.0 * FREE);
}

#[test]
fn a_rectangle_is_a_portal_where_it_is_marked() {
    let mut room = Room::new();
    let window = middle(WINDOW);
    // A skylight: the ceiling has a gap, over which the board lies that marks it.
    room.set(room.wall, wall(Vec::new()));
    assert_eq!(room.density(window), FREE);
    let gap = Vec3::new(3.5, 2.0, 2.5);
    let mut plates = room.app.world_mut().query::<(Entity, &Shape, &ToWorld)>();
    let ceiling = plates
        .iter(room.app.world())
        .find(|(_, shape, place)| shape.kind == ShapeKind::Rectangle && place.0.translation.z == 2.5)
        .map(|found| found.0)
        .expect("a ceiling");
    let (_, narrow) = plate(Vec3::new(1.6, 2.1, 1.0), Vec3::new(1.4, 2.0, 2.5));
    room.set(ceiling, narrow);
    assert_eq!(room.density(gap), FREE);
    let (mark, place) = plate(Vec3::new(0.5, 2.0, 1.0), gap + Vec3::Z * 0.05);
    room.set(room.board, place);
    assert_eq!(room.density(gap), FREE);
    let marked = Shape { portal: true, ..mark };
    room.set(room.board, marked);
    // It is opaque without a material that light passes.
    assert_eq!(room.density(gap), FREE);
    let null = room
        .app
        .world_mut()
        .spawn((DocumentOrder(100), sunroom::scene::Material::Null))
        .id();
    room.set(room.board, sunroom::scene::UsesMaterial(null));
    assert!(room.density(gap) > 3.0 * FREE);
}
