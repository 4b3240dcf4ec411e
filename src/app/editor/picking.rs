//! Questions to the scene as it is being rendered: what is under the mouse, how large things are.

use bevy::math::Vec2;
use bevy::prelude::Entity;

use crate::engine::CurrentScene;
use crate::math::Aabb;
use crate::render::camera::Camera;

/// The shape seen at a place of the picture, (0, 0) top left, (1, 1) bottom right.
pub fn pick(current: &CurrentScene, film: Vec2) -> Option<Entity> {
    let (scene, view) = (current.scene.as_ref()?, current.view.as_ref()?);
    let ray = view.camera.ray(film, Vec2::splat(0.5));
    let hit = scene.geometry.intersect(&ray)?;
    current.entity_of_instance.get(hit.instance as usize).copied()
}

/// How far the first thing is in the middle of the picture.
pub fn distance_ahead(current: &CurrentScene) -> Option<f32> {
    let (scene, view) = (current.scene.as_ref()?, current.view.as_ref()?);
    let ray = view.camera.ray(Vec2::splat(0.5), Vec2::splat(0.5));
    scene.geometry.intersect(&ray).map(|hit| hit.t)
}

/// World bounds of everything; None without geometry.
pub fn scene_bounds(current: &CurrentScene) -> Option<Aabb> {
    let bounds = current.scene.as_ref()?.geometry.bounds();
    (!bounds.is_empty()).then_some(bounds)
}

/// World bounds of one shape; None if it is not in the picture.
pub fn bounds_of(current: &CurrentScene, entity: Entity) -> Option<Aabb> {
    let geometry = &current.scene.as_ref()?.geometry;
    let of_entity = (0..)
        .zip(current.entity_of_instance.iter())
        .filter(|&(_, &other)| other == entity);
    let bounds = of_entity.filter_map(|(item, _)| geometry.bounds_of(item));
    let bounds = bounds.fold(Aabb::EMPTY, Aabb::union);
    (!bounds.is_empty()).then_some(bounds)
}

/// Half the field of view in radians along the picture's narrower side.
pub fn half_fov(camera: &Camera) -> f32 {
    let axis = camera.ray(Vec2::splat(0.5), Vec2::splat(0.5)).dir;
    let half = |film| camera.ray(film, Vec2::splat(0.5)).dir.angle_between(axis);
    half(Vec2::new(0.0, 0.5)).min(half(Vec2::new(0.5, 0.0)))
}
