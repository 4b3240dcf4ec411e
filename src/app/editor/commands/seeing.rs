//! Applies commands that hide parts of the view, and passes them to the renderer.

use std::collections::HashSet;

use bevy::math::Vec3;
use bevy::prelude::*;

use super::grouping;
use super::view;
use super::world::control;
use crate::app::editor::camera::picking;
use crate::app::editor::camera::pose::view_pose;
use crate::app::editor::command::error::CommandError;
use crate::app::editor::command::preferences::Preferences;
use crate::app::editor::command::seeing::{CutOpen, Seeing, Walls};
use crate::app::editor::session::view_settings::ViewSettings;
use crate::engine::PackedScene;
use crate::scene::{InstanceOf, MemberOf, Shape};

pub fn set(world: &mut World, seeing: Seeing) {
    let seeing = Seeing {
        cut: seeing.cut.filter(|cut| cut.axis < 3 && cut.at.is_finite()),
        ..seeing
    };
    world.resource_mut::<ViewSettings>().seeing = seeing;
    tell_renderer(world);
}

/// Puts a cut plane through the middle of the selection, or else of the scene, that hides the camera's side.
pub fn cut_open(world: &mut World) -> Result<(), CommandError> {
    let selected = view::selected_bounds(world);
    let scene = picking::scene_bounds(world.resource::<PackedScene>());
    let bounds = match selected.is_empty() {
        true => scene.ok_or("The scene is empty.")?,
        false => selected,
    };
    let pose = view_pose(world).ok_or("There is no camera.")?;
    let forward = Vec3::from(pose.matrix3.z_axis);
    let axis = (0..3)
        .max_by(|a, b| forward[*a].abs().total_cmp(&forward[*b].abs()))
        .unwrap_or(0);
    let seeing = world.resource::<ViewSettings>().seeing;
    let cut = CutOpen {
        axis,
        at: bounds.center()[axis],
        above: forward[axis] < 0.0,
    };
    set(
        world,
        Seeing {
            cut: Some(cut),
            ..seeing
        },
    );
    Ok(())
}

/// Shows these shapes, and those in these groups, alone; all shapes, if there are none among the entities.
pub fn isolate(world: &mut World, entities: Vec<Entity>) -> Result<(), CommandError> {
    let asked = entities.len();
    let mut wanted: Vec<Entity> = Vec::new();
    for entity in entities {
        wanted.push(entity);
        if grouping::is_frame(world, entity) {
            let folder = grouping::path(world, entity);
            wanted.extend(grouping::named_within(world, &folder));
        }
    }
    let mut known = HashSet::new();
    let shapes: Vec<Entity> = wanted
        .into_iter()
        .filter(|entity| known.insert(*entity) && !grouping::is_frame(world, *entity))
        .filter(|entity| world.get::<Shape>(*entity).is_some() || world.get::<InstanceOf>(*entity).is_some())
        .filter(|entity| world.get::<MemberOf>(*entity).is_none())
        .collect();
    if asked > 0 && shapes.is_empty() {
        return Err("Only shapes can be shown alone.".into());
    }
    world.resource_mut::<ViewSettings>().isolated = shapes;
    tell_renderer(world);
    Ok(())
}

/// Hides walls, if the preferences say so, because the view looks along an axis: from there a closed room shows its
/// outside only.
pub fn note_axis_view(world: &mut World) {
    let is_wanted = world
        .get_resource::<Preferences>()
        .is_none_or(|known| known.axis_views_hide_walls);
    if is_wanted {
        hide_walls_for_view(world);
    }
}

/// Hides or shows walls as they were when a view was stored; those that the user has hidden stay hidden.
pub fn note_stored_view(world: &mut World, hides_walls: bool) {
    match hides_walls {
        true => hide_walls_for_view(world),
        false => note_other_view(world),
    }
}

fn hide_walls_for_view(world: &mut World) {
    let seeing = world.resource::<ViewSettings>().seeing;
    if seeing.walls == Walls::Shown {
        let walls = Walls::HiddenForAxis;
        set(world, Seeing { walls, ..seeing });
    }
}

/// Shows the walls again that were hidden because the view looked along an axis.
pub fn note_other_view(world: &mut World) {
    let seeing = world.resource::<ViewSettings>().seeing;
    if seeing.walls == Walls::HiddenForAxis {
        let walls = Walls::Shown;
        set(world, Seeing { walls, ..seeing });
    }
}

/// Drops shapes that are not in the scene any more.
pub fn keep_what_is_there(world: &mut World, is_there: impl Fn(&World, Entity) -> bool) {
    let isolated = &world.resource::<ViewSettings>().isolated;
    if isolated.iter().any(|entity| !is_there(world, *entity)) {
        let kept = isolated.iter().copied().filter(|entity| is_there(world, *entity));
        let kept: Vec<Entity> = kept.collect();
        world.resource_mut::<ViewSettings>().isolated = kept;
        tell_renderer(world);
    }
}

fn tell_renderer(world: &mut World) {
    let sight = world.resource::<ViewSettings>().sight();
    control(world, |control| control.sight = sight);
}
