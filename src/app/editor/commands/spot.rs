//! Finds a place and a size for new things if none are given: in the middle of the picture, on the surface there,
//! beside similar things.

use bevy::math::{Affine3A, Vec3};
use bevy::prelude::*;

use super::taken::{Taken, Things};
use crate::app::editor::camera::picking::{self, SeenSurface};
use crate::app::editor::camera::{pose, rounding};
use crate::app::editor::session::view_settings::ViewSettings;
use crate::engine::PackedScene;
use crate::math::{Aabb, Ray};
use crate::scene::Shape;

/// Half the size of the first thing of a scene, world units.
const FIRST: f32 = 0.5;
/// Half the size of a new thing, as a share of the height of the picture at its place.
const SIZE_IN_VIEW: f32 = 0.125;
/// The distance from the middle of one new thing to that of the next, in half sizes.
const APART: f32 = 2.5;
/// Things no wider than this many half sizes count as similar: new things go beside them, not on them.
const WIDEST_BESIDE: f32 = 3.0;
/// Things longer than this multiple of their width are walls, beyond which nothing is placed.
const LONGEST_BESIDE: f32 = 6.0;
/// The most places that are tried.
const MOST_TRIED: usize = 64;
/// The largest distance of the ground, as a multiple of the scene's size.
const FARTHEST: f32 = 3.0;
/// The distance from a surface at which rays start, in half sizes.
const OFF: f32 = 1e-3;
/// The cosine of the steepest slope, to the upward direction. Steeper surfaces are walls, on which nothing is put.
const STEEPEST: f32 = 0.1;

/// The place of a new thing.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Spot {
    /// The foot of the thing, in world space.
    pub foot: Vec3,
    /// Half its size.
    pub size: f32,
    /// The surface that it stands on, if there is one.
    pub on: Option<SeenSurface>,
}

/// A place: the foot, and the surface there.
type Place = (Vec3, Option<SeenSurface>);

/// Finds a place. `lift` is the distance from the foot to the position, in half sizes.
pub fn find(world: &mut World, size: Option<f32>, lift: f32, is_light: bool) -> Spot {
    let has_shapes = world.query::<&Shape>().iter(world).next().is_some();
    let mut things = Things::new(world);
    let world = &*world;
    let nothing = PackedScene::default();
    let packed = world.get_resource::<PackedScene>().unwrap_or(&nothing);
    let up = world.resource::<ViewSettings>().navigation.up;
    let pose = pose::view_pose(world).unwrap_or_default();
    let ground = Ground::of(packed, up);
    let surface = picking::ahead(packed).filter(|_| has_shapes);
    let seen = match surface {
        Some(surface) => surface.position,
        None if has_shapes => looked_at(&pose, &ground),
        None => Vec3::ZERO,
    };
    let suits = || match has_shapes {
        true => picking::view_height(packed, &pose, seen).map_or(FIRST, |height| rounded(SIZE_IN_VIEW * height)),
        false => FIRST,
    };
    let size = size.unwrap_or_else(suits);
    let is_passed = |item: u32| picking::bounds_of_item(packed, item).is_some_and(|bounds| is_like(&bounds, size, up));
    let ahead = Vec3::from(pose.matrix3.z_axis).normalize_or(Vec3::Z);
    let right = -Vec3::from(pose.matrix3.x_axis)
        .reject_from(up)
        .normalize_or(up.any_orthonormal_vector());
    let towards_eye = -ahead.reject_from(up).normalize_or_zero() * size;
    let stand = match surface {
        Some(surface) if surface.normal.dot(up) > STEEPEST => (surface.position, Some(surface)),
        // If the surface does not face up, the thing goes in front of it, onto the surface below.
        Some(surface) => {
            let before = surface.before(OFF * size);
            let step = match is_free(packed, before, towards_eye, |_| false) {
                true => towards_eye,
                false => Vec3::ZERO,
            };
            fall(packed, before + step, &ground)
        }
        None if has_shapes => fall(packed, seen + towards_eye - ahead * (OFF * size), &ground),
        None => (seen, None),
    };
    // Beside a thing of similar size, whichever side of it is visible.
    let start = match surface {
        Some(surface) if is_passed(surface.item) => (surface.position, Some(surface)),
        _ => stand,
    };
    let mut taken = Taken {
        world,
        things: &mut things,
        packed,
        lights: is_light,
    };
    // Walks to a free place. None if an obstacle that is no similar thing blocks it.
    let walk = |way: Vec3| -> Option<Place> {
        let mut place = start;
        for _ in 0..MOST_TRIED {
            let (foot, on) = place;
            let beside = match on.and_then(|on| picking::bounds_of_item(packed, on.item)) {
                Some(bounds) if is_like(&bounds, size, up) => {
                    bounds.center() + way * (0.5 * bounds.extent().dot(way.abs()))
                }
                _ if taken.is_at(foot, up * size, lift, |bounds| is_like(bounds, size, up)) => {
                    foot + way * ((APART - 1.0) * size)
                }
                _ => break,
            };
            let next = beside + way * size;
            // The step is as high as its middle, and reaches to its far side.
            let step = (next - foot).reject_from(up) + way * size;
            if !is_free(packed, foot + up * size, step, is_passed) {
                return None;
            }
            // The fall begins above all similar things.
            place = fall(packed, next + up * (APART * size), &ground);
        }
        Some(place)
    };
    // The side that has room sooner is taken.
    let sides = [right, -right].into_iter().filter_map(walk);
    let nearest = sides.min_by(|(one, _), (other, _)| one.distance(seen).total_cmp(&other.distance(seen)));
    let (foot, on) = nearest.unwrap_or(stand);
    Spot { foot, size, on }
}

/// The place in the middle of the picture, on any surface but those of `except`, or else on the ground; and the height
/// in world units that the picture covers at that distance. None without a picture.
pub fn seen(world: &World, except: &[Entity]) -> Option<(Vec3, f32)> {
    let packed = world.get_resource::<PackedScene>()?;
    let up = world.resource::<ViewSettings>().navigation.up;
    let pose = pose::view_pose(world)?;
    let camera = &packed.view.as_ref()?.camera;
    let ground = Ground::of(packed, up);
    let is_passed = |entity: Entity| except.contains(&entity);
    let ahead = picking::seen_surface(packed, &camera.ray(Vec2::splat(0.5), Vec2::splat(0.5)), is_passed);
    let place = match ahead {
        Some(surface) if surface.normal.dot(up) > STEEPEST => surface.position,
        Some(surface) => {
            let before = surface.before(OFF * surface.position.distance(pose.translation.into()));
            let below = picking::surface(packed, &Ray::new(before, -up), is_passed);
            below.map_or_else(|| ground.under(before), |below| below.position)
        }
        None => looked_at(&pose, &ground),
    };
    Some((place, picking::view_height(packed, &pose, place)?))
}

/// The free height above the place, at most `wanted`.
pub fn headroom(world: &World, spot: &Spot, wanted: f32) -> f32 {
    let up = world.resource::<ViewSettings>().navigation.up;
    let Some(packed) = world.get_resource::<PackedScene>() else {
        return wanted;
    };
    let off = OFF * wanted;
    let start = spot.on.map_or(spot.foot + up * off, |on| on.before(off));
    let above = picking::surface(packed, &Ray::new(start, up), |_| false);
    above.map_or(wanted, |above| wanted.min(0.9 * above.position.distance(spot.foot)))
}

/// The ground plane below all shapes.
struct Ground {
    up: Vec3,
    /// The height along `up`.
    height: f32,
    bounds: Option<Aabb>,
}

impl Ground {
    fn of(packed: &PackedScene, up: Vec3) -> Self {
        let bounds = picking::scene_bounds(packed);
        let lowest = |bounds: Aabb| bounds.center().dot(up) - 0.5 * bounds.extent().dot(up.abs());
        let height = bounds.map_or(0.0, lowest);
        Self { up, height, bounds }
    }

    fn under(&self, point: Vec3) -> Vec3 {
        point + self.up * (self.height - point.dot(self.up))
    }

    /// The distance from the eye to the far side of the scene.
    fn reach(&self, eye: Vec3) -> f32 {
        let reach = |bounds: Aabb| bounds.center().distance(eye) + 0.5 * bounds.extent().length();
        self.bounds.map_or(eye.length(), reach).max(f32::MIN_POSITIVE)
    }
}

/// The point of the ground in the middle of the picture, or just ahead of the camera.
fn looked_at(pose: &Affine3A, ground: &Ground) -> Vec3 {
    let eye = Vec3::from(pose.translation);
    let forward = Vec3::from(pose.matrix3.z_axis).normalize_or(Vec3::Z);
    let reach = ground.reach(eye);
    let way = (ground.height - eye.dot(ground.up)) / forward.dot(ground.up);
    match way > 0.0 && way < FARTHEST * reach {
        true => eye + forward * way,
        false => eye + forward * (0.5 * reach),
    }
}

/// Whether a step meets only items that may be passed.
fn is_free(packed: &PackedScene, from: Vec3, step: Vec3, is_passed: impl Fn(u32) -> bool) -> bool {
    let way = Ray::segment(from, from + step);
    step == Vec3::ZERO || picking::surface_of_items(packed, &way, |item, _| is_passed(item)).is_none()
}

/// The first surface below a point, or the ground.
fn fall(packed: &PackedScene, from: Vec3, ground: &Ground) -> Place {
    let below = picking::surface(packed, &Ray::new(from, -ground.up), |_| false);
    (below.map_or(ground.under(from), |below| below.position), below)
}

/// Whether these are the bounds of a similar thing, and not of a floor or a table.
fn is_like(bounds: &Aabb, size: f32, up: Vec3) -> bool {
    let across = Vec3::AXES.into_iter().filter(|axis| axis.dot(up).abs() < 0.5);
    let (narrow, wide) = across.fold((f32::MAX, 0.0f32), |(narrow, wide), axis| {
        let extent = bounds.extent().dot(axis);
        (narrow.min(extent), wide.max(extent))
    });
    // A thing that is short beside the new one may have any proportions.
    let is_wall = wide > size && wide > LONGEST_BESIDE * narrow;
    wide <= WIDEST_BESIDE * size && !is_wall
}

/// The size rounded to one digit.
pub fn rounded(size: f32) -> f32 {
    let size = f64::from(size.max(f32::MIN_POSITIVE));
    let digit = 10f64.powf(size.log10().floor());
    (((size / digit).round() * digit) as f32).max(f32::MIN_POSITIVE)
}

/// Rounds a place to a hundredth of `size` or finer, so that the numbers are short in a file.
pub fn rounded_place(place: Vec3, size: f32) -> Vec3 {
    rounding::rounded_place(place, 0.01 * rounding::unit_below(size))
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use super::*;
    use crate::accel::{Blas, Primitive, SplitMethod};
    use crate::app::editor::camera::picking::tests::scene_of;
    use crate::app::editor::picture::material_ball;
    use crate::app::editor::session::requests::Requests;
    use crate::app::editor::session::toasts::Toasts;
    use crate::geometry::primitives::unit_cube;
    use crate::render::camera::Camera;
    use crate::render::view::View;
    use crate::scene::{ActiveSensor, FreeView, ShapeKind};
    use crate::scene::{AreaLight, Emitter, MemberOf, ToWorld};

    #[test]
    fn a_rounded_place_has_short_numbers() {
        let place = Vec3::new(0.123_456, 2.987_65, -31.415_92);
        assert_eq!(rounded_place(place, 0.5), Vec3::new(0.123, 2.988, -31.416));
        assert_eq!(rounded_place(1e3 * place, 700.0), Vec3::new(123.0, 2988.0, -31416.0));
    }

    /// Looks along -z at the origin, a little from above; only beyond `near` it sees.
    fn world(near: f32) -> World {
        world_from(Vec3::new(0.0, 2.0, 6.0), Vec3::ZERO, near)
    }

    fn world_from(eye: Vec3, at: Vec3, near: f32) -> World {
        let pose = Affine3A::look_at_rh(eye, at, Vec3::Y).inverse() * Affine3A::from_rotation_y(std::f32::consts::PI);
        let mut world = World::new();
        let sensor = world.spawn(ToWorld(pose)).id();
        world.insert_resource(ActiveSensor(Some(sensor)));
        world.init_resource::<FreeView>();
        world.init_resource::<ViewSettings>();
        world.init_resource::<Requests>();
        world.init_resource::<Toasts>();
        world.insert_resource(PackedScene {
            view: Some(View {
                camera: Camera::new(pose, 40.0, 1.0, near, 1e3, None),
                ..material_ball::view(16)
            }),
            ..PackedScene::default()
        });
        world
    }

    /// Adds shapes with these poses to the world and to the picture.
    fn show(world: &mut World, shapes: &[(Primitive, Affine3A)]) {
        let entities = shapes
            .iter()
            .map(|(_, pose)| world.spawn((Shape::default(), ToWorld(*pose))).id());
        let entities: Vec<Entity> = entities.collect();
        let mut packed = world.resource_mut::<PackedScene>();
        packed.scene = Some(scene_of(shapes.iter().cloned()));
        packed.entity_of_instance = entities.into();
    }

    /// A floor with its top at y = 0.
    fn floor() -> (Primitive, Affine3A) {
        let level = Affine3A::from_rotation_x(-std::f32::consts::FRAC_PI_2);
        (Primitive::Rectangle, level * Affine3A::from_scale(Vec3::splat(20.0)))
    }

    fn ball(at: Vec3) -> (Primitive, Affine3A) {
        let pose = Affine3A::from_translation(at) * Affine3A::from_scale(Vec3::splat(FIRST));
        (Primitive::Sphere, pose)
    }

    fn moved((primitive, pose): (Primitive, Affine3A), by: Vec3) -> (Primitive, Affine3A) {
        (primitive, Affine3A::from_translation(by) * pose)
    }

    #[test]
    fn the_first_thing_is_at_the_origin_and_later_ones_are_not_smaller_and_smaller() {
        let mut world = world(0.01);
        let first = find(&mut world, None, 1.0, false);
        assert_eq!((first.foot, first.size), (Vec3::ZERO, FIRST));
        let mut balls = vec![ball(Vec3::Y * FIRST)];
        for _ in 0..4 {
            show(&mut world, &balls);
            let next = find(&mut world, None, 1.0, false);
            assert!(next.size > 0.5 * FIRST && next.size < 2.0 * FIRST, "{next:?}");
            assert!(next.foot.y.abs() < 1e-3, "{next:?}");
            let middle = next.foot + Vec3::Y * next.size;
            for (_, other) in &balls {
                let apart = Vec3::from(other.translation).distance(middle);
                assert!(apart > 0.99 * (FIRST + next.size), "{apart} {next:?}");
            }
            balls.push(ball(middle + Vec3::Y * (FIRST - next.size)));
        }
    }

    #[test]
    fn things_stand_on_what_is_seen_wherever_the_camera_begins_to_see() {
        for near in [0.01, 3.0] {
            let mut world = world(near);
            show(&mut world, &[floor()]);
            let spot = find(&mut world, None, 1.0, false);
            assert!(spot.on.is_some() && spot.foot.length() < 1e-3, "{near}: {spot:?}");
            // Things before a wall stand on the floor.
            let wall = (
                Primitive::Rectangle,
                Affine3A::from_translation(Vec3::Z) * Affine3A::from_scale(Vec3::splat(9.0)),
            );
            show(&mut world, &[floor(), wall]);
            let spot = find(&mut world, None, 1.0, false);
            assert!(
                spot.foot.y.abs() < 1e-3 && spot.foot.z > 1.0 + 0.9 * spot.size,
                "{near}: {spot:?}"
            );
        }
    }

    #[test]
    fn nothing_stands_on_a_ceiling_that_is_looked_up_at() {
        let mut world = world_from(Vec3::new(0.0, -2.0, 6.0), Vec3::ZERO, 0.01);
        show(&mut world, &[floor(), moved(floor(), Vec3::NEG_Y * 3.0)]);
        let spot = find(&mut world, None, 1.0, false);
        assert!(spot.on.is_some() && (spot.foot.y + 3.0).abs() < 1e-3, "{spot:?}");
    }

    #[test]
    fn nothing_is_put_behind_a_wall_beside_what_is_there() {
        let turned = Affine3A::from_rotation_y(std::f32::consts::FRAC_PI_2) * Affine3A::from_scale(Vec3::splat(9.0));
        let wall = |x: f32| moved((Primitive::Rectangle, turned), Vec3::X * x);
        for side in [-1.0, 1.0] {
            let mut world = world(0.01);
            show(&mut world, &[floor(), ball(Vec3::Y * FIRST), wall(0.8 * side)]);
            let spot = find(&mut world, None, 1.0, false);
            assert!(spot.foot.x * side < -FIRST, "{spot:?}");
        }
        let mut world = world(0.01);
        show(&mut world, &[floor(), ball(Vec3::Y * FIRST), wall(0.8), wall(-0.8)]);
        let spot = find(&mut world, None, 1.0, false);
        assert!(spot.foot.x.abs() < 0.8, "{spot:?}");
    }

    #[test]
    fn in_a_room_nothing_is_put_behind_walls_of_boxes() {
        let wall = |at: Vec3, half: Vec3| {
            let blas = Blas::build(Arc::new(unit_cube()), SplitMethod::Sah);
            let pose = Affine3A::from_translation(at) * Affine3A::from_scale(half);
            (Primitive::Mesh(Arc::new(blas)), pose)
        };
        let (x, z) = (Vec3::new(0.1, 1.25, 2.0), Vec3::new(3.0, 1.25, 0.1));
        // From outside so much is seen that new things are as large as the inner wall is long.
        for (at, middle) in [(0.0, -0.3), (0.0, 0.0), (-1.0, -0.9)] {
            let mut world = world_from(Vec3::new(at, 9.0, 9.0), Vec3::new(at, 0.0, 0.0), 0.01);
            let room = [
                floor(),
                wall(Vec3::new(-3.0, 1.25, 0.0), x),
                wall(Vec3::new(3.0, 1.25, 0.0), x),
                wall(Vec3::new(middle, 1.25, 0.0), x),
                wall(Vec3::new(0.0, 1.25, -2.0), z),
            ];
            show(&mut world, &room);
            let spot = find(&mut world, Some(1.6), 0.0, false);
            assert!(spot.foot.x.abs() < 3.0 && spot.foot.z.abs() < 4.0, "{middle}: {spot:?}");
        }
    }

    #[test]
    fn far_from_the_origin_things_stand_as_they_do_near_it() {
        // The steps of floats are about a hundredth there.
        let far = Vec3::new(-1.1e5, 1.3e5, 0.9e5);
        for angle in [0.0f32, 0.1, 0.2, 0.3] {
            let mut world = world_from(far + Vec3::new(0.0, 2.0, 6.0), far, 0.01);
            let (primitive, level) = floor();
            let tilted = (primitive, Affine3A::from_rotation_z(angle) * level);
            show(&mut world, &[moved(tilted, far)]);
            let spot = find(&mut world, None, 1.0, false);
            assert!(spot.on.is_some() && spot.foot.distance(far) < 0.1, "{angle}: {spot:?}");
            assert_eq!(headroom(&world, &spot, 0.1), 0.1, "{angle}");
        }
    }

    #[test]
    fn a_light_is_where_its_shape_is() {
        let mut world = world(0.01);
        show(&mut world, &[floor()]);
        let spot = find(&mut world, None, 4.0, true);
        let shape = Shape {
            kind: ShapeKind::Sphere {
                center: spot.foot + Vec3::Y * (4.0 * spot.size) - Vec3::X * 5.0,
                radius: 0.1,
            },
            ..Shape::default()
        };
        let pose = ToWorld(Affine3A::from_translation(Vec3::X * 5.0));
        let light = world.spawn((shape, pose, AreaLight::default())).id();
        let group = world.spawn_empty().id();
        let is_apart = |world: &mut World| find(world, Some(spot.size), 4.0, true).foot.distance(spot.foot) > spot.size;
        assert!(is_apart(&mut world));
        world.entity_mut(light).insert(MemberOf(group));
        assert!(!is_apart(&mut world));
    }

    #[test]
    fn lights_are_not_put_into_each_other() {
        let mut world = world(0.01);
        show(&mut world, &[floor()]);
        let mut places: Vec<Vec3> = Vec::new();
        for _ in 0..4 {
            let spot = find(&mut world, None, 4.0, true);
            let place = spot.foot + Vec3::Y * (4.0 * spot.size);
            assert!(
                places.iter().all(|other| other.distance(place) > spot.size),
                "{places:?} {place}"
            );
            places.push(place);
            let pose = ToWorld(Affine3A::from_translation(place));
            world.spawn((pose, Emitter::of_plugin("point").expect("a plugin")));
        }
    }

    #[test]
    fn sizes_have_one_digit() {
        assert_eq!(rounded(0.0537), 0.05);
        assert!((rounded(2371.0) - 2000.0).abs() < 1e-2);
        assert!(rounded(0.0) > 0.0);
    }
}
