//! Queries of the packed scene: the surface under the mouse, and the sizes of things.

use std::collections::{BTreeSet, HashSet};

use bevy::ecs::entity::EntityHashMap;
use bevy::math::{Affine3A, Vec2, Vec3};
use bevy::prelude::Entity;

use crate::accel::{Detail, Hit, RayLanes};
use crate::engine::PackedScene;
use crate::material::Material;
use crate::math::lanes::LANES;
use crate::math::{Aabb, Ray, offset_origin};
use crate::medium::{MediumId, Way};
use crate::render::camera::Camera;
use crate::render::scene::RenderScene;

/// The visible shape at a point of the picture, (0, 0) top left, (1, 1) bottom right. A shape that is only the border
/// of a medium counts as visible if the medium hides most of the light from behind it, or there is no surface behind
/// it.
pub fn pick(packed: &PackedScene, film: Vec2) -> Option<Entity> {
    let (scene, view) = (packed.scene.as_ref()?, packed.view.as_ref()?);
    let ray = view.camera.sharp().ray(film, Vec2::ZERO);
    let ray = view.sight.narrow(&scene.geometry, ray);
    let mut medium = view.medium;
    // The first border, and the optical depth behind it.
    let mut border: Option<(Entity, f32)> = None;
    let mut rest = ray;
    for _ in 0..MOST_PASSED {
        let hit = scene.geometry.intersect(&rest);
        let end = hit.map_or(rest.t_max, |hit| hit.t);
        if let (Some((entity, depth)), Some(medium)) = (&mut border, medium) {
            *depth += depth_of(scene, medium, &rest, end);
            if *depth > HIDING {
                return Some(*entity);
            }
        }
        let Some(hit) = hit else { break };
        let entity = packed.entity_of_instance.get(hit.instance as usize).copied()?;
        if !is_border(scene, &hit) {
            return Some(entity);
        }
        border.get_or_insert((entity, 0.0));
        let normal = scene.geometry.surface_in(&rest, &hit, Detail::Plain).geometric_normal;
        medium = scene.slot(&hit).media.entered(medium, ray.dir, normal);
        rest = behind(&rest, hit.t);
    }
    border.map(|(entity, _)| entity)
}

/// The optical depth beyond which less than half of the light is transmitted.
const HIDING: f32 = std::f32::consts::LN_2;

/// The optical depth along a ray up to `t`, in the channel that transmits most.
fn depth_of(scene: &RenderScene, medium: MediumId, ray: &Ray, t: f32) -> f32 {
    let length = ray.dir.length();
    let way = Way {
        origin: ray.at(ray.t_min),
        dir: ray.dir / length,
        length: (t - ray.t_min) * length,
    };
    scene.media.get(medium).optical_depth(&way).min_element()
}

/// Whether the surface does not scatter light: it is only the border of a medium.
fn is_border(scene: &RenderScene, hit: &Hit) -> bool {
    if scene.media.is_empty() {
        return false;
    }
    let slot = scene.slot(hit);
    slot.light.is_none()
        && slot.media.is_transition()
        && matches!(scene.materials.get(slot.material), Some(Material::Null))
}

/// The part of a ray beyond a surface at `t`.
fn behind(ray: &Ray, t: f32) -> Ray {
    let step = BEHIND * (ray.origin.abs().max_element() / ray.dir.length().max(f32::MIN_POSITIVE));
    let passed = t + step + BEHIND * t;
    Ray {
        origin: ray.at(passed),
        t_min: 0.0,
        t_max: ray.t_max - passed,
        ..*ray
    }
}

/// The most rays along either side of a box.
const MOST_ACROSS: f32 = 256.0;

/// The visible shapes in a box of the picture, in the order of the scene. `corners` are film coordinates; `pixels` is
/// its size on the screen. Every pixel is tested unless there are very many.
pub fn seen_in(packed: &PackedScene, corners: [Vec2; 2], pixels: [f32; 2]) -> Vec<Entity> {
    let (Some(scene), Some(view)) = (&packed.scene, &packed.view) else {
        return Vec::new();
    };
    let min = corners[0].min(corners[1]).clamp(Vec2::ZERO, Vec2::ONE);
    let max = corners[0].max(corners[1]).clamp(Vec2::ZERO, Vec2::ONE);
    if min.cmpge(max).any() {
        return Vec::new();
    }
    let [columns, rows] = pixels.map(|count| count.ceil().clamp(1.0, MOST_ACROSS) as u32);
    let camera = view.camera.sharp();
    let count = Vec2::new(columns as f32, rows as f32);
    let ray = |place: u32| {
        let cell = Vec2::new((place % columns) as f32, (place / columns) as f32) + 0.5;
        let ray = camera.ray(min + cell / count * (max - min), Vec2::ZERO);
        view.sight.narrow(&scene.geometry, ray)
    };
    let mut instances = BTreeSet::new();
    for first in (0..columns * rows).step_by(LANES) {
        let rays: Vec<Ray> = (first..(columns * rows).min(first + LANES as u32)).map(ray).collect();
        let hits = scene
            .geometry
            .intersect_packet(&RayLanes::of(&rays), (1 << rays.len()) - 1);
        for (ray, hit) in rays.iter().zip(&hits) {
            let Some(hit) = hit else { continue };
            instances.insert(hit.instance);
            // A shape that is visible through the border of a medium counts as well.
            if is_border(scene, hit)
                && let Some((_, hit, _)) = first_hit(packed, ray, |_| false)
            {
                instances.insert(hit.instance);
            }
        }
    }
    let entities = instances
        .iter()
        .filter_map(|instance| packed.entity_of_instance.get(*instance as usize));
    let mut known = HashSet::new();
    entities.copied().filter(|entity| known.insert(*entity)).collect()
}

/// A point on a surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SeenSurface {
    pub position: Vec3,
    /// The error bound of `position`, per coordinate.
    error: f32,
    /// The unit geometric normal on the visible side.
    pub normal: Vec3,
    pub entity: Entity,
    /// The shape or placement, as [`Hit::instance`] counts them.
    pub item: u32,
}

impl SeenSurface {
    /// A point in front of the surface, `distance` world units from it, or farther if the rounding error requires it.
    pub fn before(&self, distance: f32) -> Vec3 {
        offset_origin(self.position, self.error.max(distance), self.normal, self.normal)
    }
}

/// The most surfaces that a ray passes.
const MOST_PASSED: usize = 256;
/// The offset behind a surface at which a ray continues, as a share of its length so far and of the origin's
/// coordinates: well above rounding, and well below what is visible.
const BEHIND: f32 = 1e-5;

/// The first surface along a ray, except for the entities that `is_passed` accepts. The ray's direction need not have
/// unit length.
pub fn surface(packed: &PackedScene, ray: &Ray, is_passed: impl Fn(Entity) -> bool) -> Option<SeenSurface> {
    surface_of_items(packed, ray, |_, entity| is_passed(entity))
}

/// [`surface`]; `is_passed` gets the shape or placement as well, as [`Hit::instance`] counts them.
pub fn surface_of_items(
    packed: &PackedScene,
    ray: &Ray,
    is_passed: impl Fn(u32, Entity) -> bool,
) -> Option<SeenSurface> {
    let geometry = &packed.scene.as_ref()?.geometry;
    let (rest, hit, entity) = first_hit_of_items(packed, ray, is_passed)?;
    let point = geometry.surface_in(&rest, &hit, Detail::Plain);
    let normal = point.geometric_normal;
    Some(SeenSurface {
        position: point.position,
        error: point.error,
        normal: if normal.dot(ray.dir) > 0.0 { -normal } else { normal },
        entity,
        item: hit.instance,
    })
}

/// A point on a surface with its texture coordinates.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MappedSurface {
    /// The point, in world space.
    pub position: Vec3,
    /// The unit geometric normal on the visible side.
    pub normal: Vec3,
    /// The texture coordinates there.
    pub uv: Vec2,
    /// The partial derivatives of the point by u and by v, in world space.
    pub dp_duv: [Vec3; 2],
    /// Whether there are texture coordinates: a mesh may have none.
    pub is_mapped: bool,
    /// The shape.
    pub entity: Entity,
}

/// [`surface`] with its texture coordinates.
pub fn mapped_surface(packed: &PackedScene, ray: &Ray, is_passed: impl Fn(Entity) -> bool) -> Option<MappedSurface> {
    let geometry = &packed.scene.as_ref()?.geometry;
    let (rest, hit, entity) = first_hit(packed, ray, is_passed)?;
    let point = geometry.surface(&rest, &hit);
    let normal = point.geometric_normal;
    Some(MappedSurface {
        position: point.position,
        normal: if normal.dot(ray.dir) > 0.0 { -normal } else { normal },
        uv: point.uv,
        dp_duv: [point.dp_du, point.dp_dv],
        is_mapped: geometry.mesh_at(&hit).is_none_or(|mesh| !mesh.uvs.is_empty()),
        entity,
    })
}

/// The first hit of [`surface`], with its ray. Borders of media are passed.
pub fn first_hit(packed: &PackedScene, ray: &Ray, is_passed: impl Fn(Entity) -> bool) -> Option<(Ray, Hit, Entity)> {
    first_hit_of_items(packed, ray, |_, entity| is_passed(entity))
}

fn first_hit_of_items(
    packed: &PackedScene,
    ray: &Ray,
    is_passed: impl Fn(u32, Entity) -> bool,
) -> Option<(Ray, Hit, Entity)> {
    let scene = packed.scene.as_ref()?;
    let geometry = &scene.geometry;
    let step = BEHIND * (ray.origin.abs().max_element() / ray.dir.length().max(f32::MIN_POSITIVE));
    let mut passed = 0.0;
    for _ in 0..MOST_PASSED {
        let rest = Ray {
            origin: ray.at(passed),
            t_min: (ray.t_min - passed).max(0.0),
            t_max: ray.t_max - passed,
            ..*ray
        };
        let hit = geometry.intersect(&rest)?;
        let entity = *packed.entity_of_instance.get(hit.instance as usize)?;
        if !is_passed(hit.instance, entity) && !is_border(scene, &hit) {
            return Some((rest, hit, entity));
        }
        passed += hit.t + step + BEHIND * (passed + hit.t);
    }
    None
}

/// The first visible surface along one of the camera's rays. The ray passes parts that are hidden in the view, and
/// entities that `is_passed` accepts.
pub fn seen_surface(packed: &PackedScene, ray: &Ray, is_passed: impl Fn(Entity) -> bool) -> Option<SeenSurface> {
    surface(packed, &narrowed(packed, ray)?, is_passed)
}

/// The visible part of a ray from the camera; None without a scene.
pub fn narrowed(packed: &PackedScene, ray: &Ray) -> Option<Ray> {
    let (scene, view) = (packed.scene.as_ref()?, packed.view.as_ref());
    Some(view.map_or(*ray, |view| view.sight.narrow(&scene.geometry, *ray)))
}

/// The first point on a surface in the middle of the picture.
pub fn ahead(packed: &PackedScene) -> Option<SeenSurface> {
    let camera = &packed.view.as_ref()?.camera;
    seen_surface(packed, &camera.ray(Vec2::splat(0.5), Vec2::splat(0.5)), |_| false)
}

/// The distance of that point from the camera itself, not from the near clipping plane.
pub fn distance_ahead(packed: &PackedScene) -> Option<f32> {
    let camera = &packed.view.as_ref()?.camera;
    ahead(packed).map(|seen| camera.project(seen.position).1)
}

/// The height of the picture in world units, or its width if that is less, at the depth of a point; None without a
/// view, and behind the camera. `pose`: world from camera.
pub fn view_height(packed: &PackedScene, pose: &Affine3A, at: Vec3) -> Option<f32> {
    let camera = &packed.view.as_ref()?.camera;
    let (place, depth) = camera.project(at);
    // The segment is so short that both ends have nearly the same scale.
    let step = 1e-2 * depth;
    let across = [pose.matrix3.x_axis, pose.matrix3.y_axis].map(|axis| {
        let (beside, _) = camera.project(at + Vec3::from(axis).normalize_or_zero() * step);
        step / (beside - place).length()
    });
    let least = across[0].min(across[1]);
    (depth > 0.0 && least.is_finite()).then_some(least)
}

/// World bounds of everything; None without geometry.
pub fn scene_bounds(packed: &PackedScene) -> Option<Aabb> {
    let bounds = packed.scene.as_ref()?.geometry.bounds();
    (!bounds.is_empty()).then_some(bounds)
}

/// World bounds of one shape; None if it is not in the picture.
pub fn bounds_of(packed: &PackedScene, entity: Entity) -> Option<Aabb> {
    let geometry = &packed.scene.as_ref()?.geometry;
    let items = (0..).zip(packed.entity_of_instance.iter());
    let own = items.filter(|(_, its)| **its == entity);
    let bounds = own.filter_map(|(item, _)| geometry.exact_bounds_of(item));
    let bounds = bounds.fold(Aabb::EMPTY, Aabb::union);
    (!bounds.is_empty()).then_some(bounds)
}

/// [`bounds_of`] the entity that has this shape or placement, as [`Hit::instance`] counts them. It does not search all
/// shapes, since the shapes of an entity are adjacent in the tables.
pub fn bounds_of_item(packed: &PackedScene, item: u32) -> Option<Aabb> {
    let geometry = &packed.scene.as_ref()?.geometry;
    let entities = &packed.entity_of_instance;
    let entity = entities.get(item as usize)?;
    let is_own = |item: &u32| entities.get(*item as usize) == Some(entity);
    let before = (0..item).rev().take_while(is_own);
    let own = before.chain((item..).take_while(is_own));
    let bounds = own.filter_map(|item| geometry.exact_bounds_of(item));
    let bounds = bounds.fold(Aabb::EMPTY, Aabb::union);
    (!bounds.is_empty()).then_some(bounds)
}

/// The world bounds of each of some shapes; None for a shape that is not in the picture.
pub fn bounds_of_each(packed: &PackedScene, entities: &[Entity]) -> Vec<Option<Aabb>> {
    let mut bounds = vec![Aabb::EMPTY; entities.len()];
    if let Some(scene) = &packed.scene {
        let places: EntityHashMap<usize> = entities.iter().copied().zip(0..).collect();
        for (item, entity) in (0..).zip(packed.entity_of_instance.iter()) {
            if let Some(&place) = places.get(entity)
                && let Some(own) = scene.geometry.exact_bounds_of(item)
            {
                bounds[place] = bounds[place].union(own);
            }
        }
    }
    bounds
        .into_iter()
        .map(|bounds| (!bounds.is_empty()).then_some(bounds))
        .collect()
}

/// Half the field of view in radians along the picture's narrower side.
pub fn half_fov(camera: &Camera) -> f32 {
    let axis = camera.ray(Vec2::splat(0.5), Vec2::splat(0.5)).dir;
    let half = |film| camera.ray(film, Vec2::splat(0.5)).dir.angle_between(axis);
    half(Vec2::new(0.0, 0.5)).min(half(Vec2::new(0.5, 0.0)))
}

#[cfg(test)]
pub(crate) mod tests {
    use std::sync::Arc;

    use bevy::prelude::World;

    use super::*;
    use crate::accel::{Blas, Instance, Primitive, SplitMethod, Tlas};
    use crate::geometry::primitives::unit_cube;
    use crate::render::scene::RenderScene;

    /// Unit spheres at these places, each an entity.
    pub fn spheres(places: &[Vec3]) -> (PackedScene, Vec<Entity>) {
        let mut world = World::new();
        let entities: Vec<Entity> = places.iter().map(|_| world.spawn_empty().id()).collect();
        let shapes = places
            .iter()
            .map(|place| (Primitive::Sphere, Affine3A::from_translation(*place)));
        let packed = PackedScene {
            scene: Some(scene_of(shapes)),
            entity_of_instance: entities.clone().into(),
            ..PackedScene::default()
        };
        (packed, entities)
    }

    /// A scene that has only shapes at their places.
    pub fn scene_of(shapes: impl Iterator<Item = (Primitive, Affine3A)>) -> RenderScene {
        let instances = shapes.filter_map(|(primitive, pose)| Instance::new(primitive, pose));
        RenderScene {
            media: Arc::default(),
            geometry: Arc::new(Tlas::build(instances.collect(), SplitMethod::Sah)),
            surfaces: Arc::default(),
            materials: Arc::default(),
            textures: Arc::default(),
            lights: Arc::default(),
            reach: Default::default(),
        }
    }

    #[test]
    fn what_is_passed_over_is_not_in_the_way() {
        let (packed, entities) = spheres(&[
            Vec3::new(0.0, 0.0, 5.0),
            Vec3::new(0.2, 0.0, 5.5),
            Vec3::new(0.0, 0.0, 1e3),
        ]);
        let ray = Ray::new(Vec3::ZERO, Vec3::Z * 2.0);
        let seen = |passed: &[Entity]| surface(&packed, &ray, |entity| passed.contains(&entity));
        assert_eq!(seen(&[]).map(|seen| seen.entity), Some(entities[0]));
        assert_eq!(seen(&entities[..1]).map(|seen| seen.entity), Some(entities[1]));
        let far = seen(&entities[..2]);
        assert!(
            far.is_some_and(|far| far.entity == entities[2] && (far.position.z - 999.0).abs() < 1e-2),
            "{far:?}"
        );
        assert_eq!(seen(&entities), None);
    }

    #[test]
    fn bounds_of_an_item_are_those_of_its_entity() {
        let places: Vec<Vec3> = (0..5).map(|k| Vec3::X * (3 * k) as f32).collect();
        let (mut packed, entities) = spheres(&places);
        packed.entity_of_instance = [0, 1, 1, 1, 2].map(|place| entities[place]).into();
        for item in 0..5 {
            let entity = packed.entity_of_instance[item as usize];
            assert_eq!(bounds_of_item(&packed, item), bounds_of(&packed, entity), "{item}");
        }
        assert_eq!(bounds_of_item(&packed, 5), None);
    }

    #[test]
    fn bounds_are_of_those_asked_for() {
        let (packed, entities) = spheres(&[Vec3::ZERO, Vec3::X * 5.0]);
        let stranger = Entity::PLACEHOLDER;
        let found = bounds_of_each(&packed, &[entities[1], stranger]);
        assert!(found[0].is_some_and(|bounds| (bounds.center() - Vec3::X * 5.0).length() < 1e-4));
        assert_eq!(found[1], None);
    }

    /// Rays need the margin that is left out here; a size of 9 is no other number for it.
    #[test]
    fn bounds_are_exact() {
        let pose =
            Affine3A::from_scale_rotation_translation(Vec3::new(4.5, 0.5, 3.0), bevy::math::Quat::IDENTITY, Vec3::Y);
        let (cube, entity) = (unit_cube(), World::new().spawn_empty().id());
        let mesh = Primitive::Mesh(Arc::new(Blas::build(Arc::new(cube), SplitMethod::Sah)));
        for primitive in [Primitive::Sphere, mesh] {
            let packed = PackedScene {
                scene: Some(scene_of([(primitive, pose)].into_iter())),
                entity_of_instance: [entity].into(),
                ..PackedScene::default()
            };
            let found = [
                bounds_of(&packed, entity),
                bounds_of_item(&packed, 0),
                bounds_of_each(&packed, &[entity])[0],
            ];
            let expected = Aabb::from_points([Vec3::new(-4.5, 0.5, -3.0), Vec3::new(4.5, 1.5, 3.0)]);
            assert_eq!(found, [Some(expected); 3]);
            let geometry = &packed.scene.as_ref().expect("a scene").geometry;
            assert!(
                geometry
                    .bounds_of(0)
                    .is_some_and(|wide| wide.max.cmpgt(expected.max).all())
            );
        }
    }
}
