//! Copies the selection: once, beside it, or as a series of copies or instances.

use std::collections::HashMap;

use bevy::math::Affine3A;
use bevy::prelude::*;

use super::{arranging, grouping, media_upkeep, placing, things};
use crate::app::editor::camera::rounding;
use crate::app::editor::command::arrange::{Direction, LONGEST_SERIES, Series, Way};
use crate::app::editor::command::error::CommandError;
use crate::app::editor::command::selection::Selection;
use crate::app::editor::session::history::{Edit, History, StepKind};
use crate::app::editor::session::view_settings::ViewSettings;
use crate::scene::folders::FreeFolders;
use crate::scene::free_name::free_name;
use crate::scene::insert::{names, next_order};
use crate::scene::names::TakenNames;
use crate::scene::{
    AreaLight, DocumentOrder, InstanceOf, InteriorMedium, MemberOf, ObjectState, Properties, SceneId, Shape,
    ShapeGroup, ShapeKind, ToWorld,
};

/// The entity that this one was copied from. It is no part of the scene.
#[derive(Component, Clone, Copy, Debug)]
pub struct CopyOf(Entity);

/// Copies the selection; the copies are selected then, and use the same materials and groups. A copy stands beside its
/// original, at a distance that suits its size. If the selection was itself copied just before, and perhaps moved
/// since, the copies continue that series.
pub fn duplicate(edit: &mut Edit) -> Result<(), CommandError> {
    let selected = things::selected(edit)?;
    let selected = grouping::whole_groups(edit.world, selected);
    let before = |entity: &Entity| before_in_series(edit.world, *entity);
    let series: Option<Vec<Affine3A>> = selected.iter().map(before).collect();
    let series = series.filter(|_| edit.world.resource::<History>().was_just_copied());
    let aside = beside(edit.world, &selected);
    let unit = unit(edit.world);
    let mut copier = Copier::new(edit, &selected);
    copier.find_folders(edit, &selected);
    let mut copies = Vec::new();
    for (number, original) in selected.into_iter().enumerate() {
        let pose = things::pose_of(edit.world, original).unwrap_or(Affine3A::IDENTITY);
        let pose = match series.as_ref().and_then(|series| series.get(number)) {
            Some(before) => next_in_series(before, &pose, unit),
            None => moved(&pose, aside),
        };
        copies.push(copier.copy(edit, original, pose)?);
    }
    refer_to_copies(edit, &copies);
    edit.kind = StepKind::Copy;
    edit.world.insert_resource(Selection::of(copies));
    Ok(())
}

/// Lets the references between things that were copied together lead to the copies.
fn refer_to_copies(edit: &mut Edit, copies: &[Entity]) {
    let id = |thing: Entity| Some(edit.world.get::<SceneId>(thing)?.0.clone());
    let names = |&copy: &Entity| Some((id(edit.world.get::<CopyOf>(copy)?.0)?, id(copy)?));
    let names: HashMap<String, String> = copies.iter().filter_map(names).collect();
    for &copy in copies {
        let own = edit.world.get::<Properties>(copy);
        if let Some(properties) = own.and_then(|own| own.renamed(|name| names.get(name).cloned())) {
            edit.set(copy, properties);
        }
    }
}

/// Makes a series of copies of the selection. The whole series is selected then.
pub fn series(edit: &mut Edit, series: &Series) -> Result<(), CommandError> {
    if !(2..=LONGEST_SERIES).contains(&series.count) {
        return Err(format!("A series has from 2 to {LONGEST_SERIES} things.").into());
    }
    let mut selected = things::selected(edit)?;
    selected.retain(|entity| edit.world.get::<ToWorld>(*entity).is_some());
    if selected.is_empty() {
        return Err(
            "Only things with a position can be copied in a series, and nothing that is selected has one.".into(),
        );
    }
    let copies = selected.len() as u64 * u64::from(series.count - 1);
    if copies > u64::from(LONGEST_SERIES) {
        return Err(format!("These would be {copies} copies; {LONGEST_SERIES} is the most.").into());
    }
    if series.instances && selected.iter().any(|entity| !is_instance(edit.world, *entity)) {
        selected = vec![as_instance(edit)?];
    }
    let unit = unit(edit.world);
    let mut copier = Copier::new(edit, &selected);
    let mut all = selected.clone();
    for number in 1..series.count {
        copier.find_folders(edit, &selected);
        let first = all.len();
        for original in &selected {
            let Some(pose) = things::pose_of(edit.world, *original) else {
                continue;
            };
            let pose = along(series, number, &pose, unit);
            all.push(copier.copy(edit, *original, pose)?);
        }
        refer_to_copies(edit, &all[first..]);
    }
    edit.world.insert_resource(Selection::of(all));
    Ok(())
}

/// The pose of the thing with this number in a series that begins with `pose`.
fn along(series: &Series, number: u32, pose: &Affine3A, unit: f64) -> Affine3A {
    match series.way {
        Way::Along(step) => moved(pose, step.map(|part| rounding::multiple(part, number))),
        Way::Around { .. } => with_rounded_place(series.map(number) * *pose, unit),
    }
}

fn unit(world: &World) -> f64 {
    rounding::fine_unit(world.resource::<ViewSettings>().navigation.scene_size)
}

fn moved(pose: &Affine3A, by: Vec3) -> Affine3A {
    Affine3A {
        translation: rounding::sum_of_places(pose.translation.into(), by).into(),
        ..*pose
    }
}

fn with_rounded_place(pose: Affine3A, unit: f64) -> Affine3A {
    Affine3A {
        translation: rounding::rounded_place(pose.translation.into(), unit).into(),
        ..pose
    }
}

/// The pose that follows two others as the second follows the first.
fn next_in_series(before: &Affine3A, now: &Affine3A, unit: f64) -> Affine3A {
    if before.matrix3 == now.matrix3 {
        let by = rounding::sum_of_places(now.translation.into(), (-before.translation).into());
        return moved(now, by);
    }
    let step = *now * before.inverse();
    match step.is_finite() {
        true => with_rounded_place(step * *now, unit),
        false => *now,
    }
}

/// The pose of the entity that this one was copied from.
fn before_in_series(world: &World, entity: Entity) -> Option<Affine3A> {
    let CopyOf(original) = *world.get::<CopyOf>(entity)?;
    let pose = things::pose_of(world, original)?;
    ObjectState::is_in_scene(world, original).then_some(pose)
}

/// The move that takes a copy beside these things, to the right as the picture shows it. It is a multiple of the step.
fn beside(world: &World, things: &[Entity]) -> Vec3 {
    let step = placing::step(world, Direction::Right);
    let direction = step.normalize_or_zero();
    let all = arranging::union(arranging::extent_of_each(world, things, direction.abs()));
    let size = all.map_or(0.0, |all| all.end - all.start);
    let steps = (size / step.length().max(f32::MIN_POSITIVE) + 1e-3).floor() + 1.0;
    let by = step * steps;
    match by.is_finite() {
        true => rounding::rounded_place(by, rounding::unit_below(1e-3 * step.length())),
        false => step,
    }
}

fn is_instance(world: &World, entity: Entity) -> bool {
    world
        .get::<Shape>(entity)
        .is_some_and(|shape| shape.kind == ShapeKind::Instance)
}

/// Moves the selected shapes into a group, and puts an instance of the group in their place. Its origin is that of the
/// active thing. A folder's transform is no shape: it is deleted, and the members of the folder become part of the
/// instance.
fn as_instance(edit: &mut Edit) -> Result<Entity, CommandError> {
    let all = grouping::units(edit)?.into_iter().flat_map(|unit| unit.all);
    let all = all.filter(|entity| edit.world.get::<ToWorld>(*entity).is_some());
    let (frames, shapes): (Vec<Entity>, Vec<Entity>) = all.partition(|entity| grouping::is_frame(edit.world, *entity));
    let can_be = |entity: &Entity| {
        edit.world.get::<Shape>(*entity).is_some()
            && edit.world.get::<AreaLight>(*entity).is_none()
            && edit.world.get::<MemberOf>(*entity).is_none()
            && !is_instance(edit.world, *entity)
    };
    if shapes.is_empty() || !shapes.iter().all(can_be) {
        return Err("Only shapes that do not shine can become instances.".into());
    }
    let active = things::selected(edit)?.last().copied();
    let origin = active.and_then(|active| edit.world.get::<ToWorld>(active));
    let origin = origin.map_or(Vec3::ZERO, |pose| Vec3::from(pose.0.translation));
    let name = active.and_then(|active| edit.world.get::<Name>(active));
    let name = name.map_or("shape", |name| name.trim_end_matches('/')).to_owned();
    for frame in frames {
        edit.delete(frame);
    }
    let mut taken = names(edit.world);
    let mut free = |wanted: String| {
        let free = free_name(&taken, &wanted);
        taken.insert(free.clone());
        (SceneId(free.clone()), Name::new(free))
    };
    let (group_name, instance_name) = (free(format!("{name}-group")), free(format!("{name}-instance")));
    let order = next_order(edit.world);
    let group = edit.spawn((ShapeGroup, group_name, DocumentOrder(order)));
    for shape in shapes {
        if let Some(ToWorld(pose)) = edit.world.get::<ToWorld>(shape).copied() {
            edit.set(shape, ToWorld(moved(&pose, -origin)));
        }
        edit.set(shape, MemberOf(group));
    }
    let instance = Shape {
        kind: ShapeKind::Instance,
        ..Shape::default()
    };
    let pose = ToWorld(Affine3A::from_translation(origin));
    let order = DocumentOrder(order.saturating_add(1));
    Ok(edit.spawn((instance, InstanceOf(group), instance_name, order, pose)))
}

/// The name of a copy of a thing without a name.
const UNNAMED: &str = "copy";

/// Makes copies whose names and positions in the file are their own.
struct Copier {
    taken: TakenNames,
    /// The name that the last copy of a name got, from which the next one is found quickly.
    latest: HashMap<String, String>,
    /// The folders of groups that are copied.
    folders: FreeFolders,
    order: u32,
}

impl Copier {
    fn new(edit: &mut Edit, originals: &[Entity]) -> Self {
        let wanted: Vec<String> = originals
            .iter()
            .map(|entity| edit.world.get::<Name>(*entity).map_or(UNNAMED, Name::as_str).to_owned())
            .collect();
        Self {
            taken: TakenNames::like(edit.world, wanted.iter().map(String::as_str)),
            latest: HashMap::new(),
            folders: FreeFolders::default(),
            order: next_order(edit.world),
        }
    }

    /// Finds folders for copies of the groups among these things.
    fn find_folders(&mut self, edit: &mut Edit, originals: &[Entity]) {
        let frames = originals
            .iter()
            .filter(|entity| grouping::is_frame(edit.world, **entity));
        let copied: Vec<String> = frames.map(|frame| grouping::path(edit.world, *frame)).collect();
        self.folders.find(|| names(edit.world), copied);
    }

    fn copy(&mut self, edit: &mut Edit, original: Entity, pose: Affine3A) -> Result<Entity, CommandError> {
        let mut state = ObjectState::of(edit.world, original);
        if state.placements.is_some() {
            return Err("So many instances cannot be doubled.".into());
        }
        let name = state.name.as_ref().map_or(UNNAMED, |name| name.as_str());
        let in_copy = self.folders.in_copy(name);
        let name = in_copy.as_deref().unwrap_or(name);
        let latest = self.latest.get(name).map_or(name, String::as_str);
        // Entities in a copied folder keep their names, since the folder's name is new.
        let free = self.taken.take(latest);
        self.latest.insert(name.to_owned(), free.clone());
        let name = free;
        state.id = Some(SceneId(name.clone()));
        state.name = Some(Name::new(name));
        state.order = Some(DocumentOrder(self.order));
        state.declared_in = None;
        let before = things::pose_of(edit.world, original);
        if let Some(before) = before {
            let by = pose * before.inverse();
            state.keys = state.keys.map(|keys| {
                if by == Affine3A::IDENTITY {
                    keys
                } else {
                    keys.moved(&by)
                }
            });
        }
        self.order = self.order.saturating_add(1);
        let copy = edit.spawn(());
        state.write(edit.world, copy);
        edit.world.entity_mut(copy).insert(CopyOf(original));
        if before.is_some() {
            things::set_pose(edit, copy, pose);
        }
        if let (Some(InteriorMedium(medium)), Some(before)) = (state.interior, before)
            && let Some(own) = media_upkeep::copied_with_place(edit, medium, &before, &pose)
        {
            edit.set(copy, InteriorMedium(own));
            if let Some(name) = edit.world.get::<Name>(own) {
                self.taken.note(name.as_str());
            }
            self.order = self.order.saturating_add(1);
        }
        Ok(copy)
    }
}
