//! The boxes of lines that stand in place of meshes whose files are missing or broken, with their names.

use bevy::math::{Affine3A, Vec3};
use bevy::prelude::Entity;
use bevy_egui::egui::{Color32, Painter};

use super::icons::{Icon, IconKind, place};
use super::marks::Tags;
use crate::app::editor::camera::screen::Screen;
use crate::math::Aabb;

/// The colour of the lines, and of the word before the name.
pub(super) const COLOR: Color32 = Color32::from_rgb(235, 70, 60);
/// The most names; more would hide the picture.
const MOST_NAMES: usize = 100;

/// A box in place of a mesh.
#[derive(Clone, Debug, PartialEq)]
pub struct StandIn {
    /// The name of the shape.
    pub name: String,
    /// The box as it is drawn and picked.
    pub icon: Icon,
    /// The box around it in the world.
    pub bounds: Aabb,
}

impl StandIn {
    /// The box around `local`, in the space of the shape.
    pub fn new(entity: Entity, name: String, local: &Aabb, to_world: &Affine3A) -> Self {
        // A flat box gets some thickness, so that it is visible.
        let half = (0.5 * local.extent()).max(Vec3::splat(1e-6));
        let box_from_cube = Affine3A::from_translation(local.center()) * Affine3A::from_scale(half);
        Self {
            name,
            icon: Icon {
                entity,
                kind: IconKind::StandIn,
                pose: *to_world * box_from_cube,
                tint: None,
            },
            bounds: local.transformed(to_world),
        }
    }
}

/// Writes the names beside the boxes.
pub(super) fn paint_names(painter: &Painter, screen: &Screen, stand_ins: &[StandIn], tags: &mut Tags) {
    let seen = stand_ins.iter().filter_map(|it| Some((it, place(screen, &it.icon)?)));
    for (stand_in, at) in seen.take(MOST_NAMES) {
        let below = painter.clip_rect().clamp(at + bevy_egui::egui::vec2(0.0, 20.0));
        tags.tag(painter, below, &format!("{} has no mesh", stand_in.name));
    }
}

#[cfg(test)]
mod tests {
    use bevy::prelude::World;

    use super::*;

    #[test]
    fn a_box_fills_the_bounds_of_the_mesh() {
        let entity = World::new().spawn_empty().id();
        let local = Aabb::from_points([Vec3::ZERO, Vec3::new(2.0, 4.0, 0.0)]);
        let to_world = Affine3A::from_translation(Vec3::X) * Affine3A::from_scale(Vec3::splat(10.0));
        let stand_in = StandIn::new(entity, "chair".to_owned(), &local, &to_world);
        let corner = |sign: f32| stand_in.icon.pose.transform_point3(Vec3::new(sign, sign, 0.0));
        assert_eq!((corner(-1.0), corner(1.0)), (Vec3::X, Vec3::new(21.0, 40.0, 0.0)));
        assert_eq!(
            (stand_in.bounds.min, stand_in.bounds.max),
            (Vec3::X, Vec3::new(21.0, 40.0, 0.0))
        );
    }
}
