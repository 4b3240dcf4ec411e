//! Edits of media: which medium is inside and around things, what shapes are filled with, and fog.

use bevy::math::{Affine3A, Vec3};
use bevy::prelude::*;

use super::spot;
use super::things::{need, need_surface, replace};
use super::world::tell;
use crate::app::editor::camera::{picking, pose, rounding};
use crate::app::editor::command::error::CommandError;
use crate::app::editor::command::material_tree::materials_inside;
use crate::app::editor::command::media::{Filling, MediumSide};
use crate::app::editor::session::history::Edit;
use crate::app::editor::session::trust;
use crate::color::Rgb;
use crate::engine::PackedScene;
use crate::math::Aabb;
use crate::scene::insert::next_order;
use crate::scene::medium::{InteriorOf, users_of_medium};
use crate::scene::names::free_name_for;
use crate::scene::{
    Coefficients, DeclaredIn, DocumentOrder, Emitter, ExteriorMedium, FirstNestedIn, InMedium, IntegratorSettings,
    InteriorMedium, Keys, Locked, Material, Medium, ObjectState, PathPlugin, PhaseFunction, SceneId, SecondNestedIn,
    Sensor, Shape, ShapeKind, ToWorld, UsesMaterial,
};

/// The depth to which materials inside of others are looked through.
const DEEPEST: usize = 8;

/// Sets the parameters of a medium. Files of grids that it did not name before were chosen by the user.
pub fn set(edit: &mut Edit, entity: Entity, medium: Medium) -> Result<(), CommandError> {
    let mut known = Vec::new();
    if let Some(before) = edit.world.get::<Medium>(entity) {
        before.for_each_grid(&mut |grid| known.push(grid.path.clone()));
    }
    medium.for_each_grid(&mut |grid| {
        if !known.contains(&grid.path) {
            trust::allow_chosen(edit.world, &grid.path);
        }
    });
    replace(edit, entity, medium)
}

/// Sets the medium at a place of each thing, or takes it away. An error where a thing has no such place.
pub fn use_medium(
    edit: &mut Edit,
    things: &[Entity],
    side: MediumSide,
    medium: Option<Entity>,
) -> Result<(), CommandError> {
    if let Some(medium) = medium {
        need::<Medium>(edit, medium)?;
    }
    for &thing in things {
        need_side(edit, thing, side)?;
        set_side(edit, thing, side, medium);
    }
    Ok(())
}

fn set_side(edit: &mut Edit, thing: Entity, side: MediumSide, medium: Option<Entity>) {
    match (side, medium) {
        (MediumSide::Interior, Some(medium)) => edit.set(thing, InteriorMedium(medium)),
        (MediumSide::Exterior, Some(medium)) => edit.set(thing, ExteriorMedium(medium)),
        (MediumSide::Around, Some(medium)) => edit.set(thing, InMedium(medium)),
        (MediumSide::Interior, None) => edit.remove::<InteriorMedium>(thing),
        (MediumSide::Exterior, None) => edit.remove::<ExteriorMedium>(thing),
        (MediumSide::Around, None) => edit.remove::<InMedium>(thing),
    }
}

fn need_side(edit: &Edit, thing: Entity, side: MediumSide) -> Result<(), CommandError> {
    match side {
        MediumSide::Interior | MediumSide::Exterior => need_surface(edit, thing),
        MediumSide::Around => {
            let is_in_space = edit.world.get::<Sensor>(thing).is_some() || edit.world.get::<Emitter>(thing).is_some();
            match is_in_space {
                true => Ok(()),
                false => {
                    Err("Only cameras and lights are in a medium; a shape has an interior and an exterior.".into())
                }
            }
        }
    }
}

/// Gives a thing a new medium that suits its size.
pub fn give(edit: &mut Edit, thing: Entity, side: MediumSide) -> Result<(), CommandError> {
    need_side(edit, thing, side)?;
    let size = size_of(edit.world, thing).unwrap_or(1.0);
    let medium = spawn(edit, "medium", fog(size));
    use_medium(edit, &[thing], side, Some(medium))
}

/// A new medium of the scene, under this name if it is free.
pub fn spawn(edit: &mut Edit, name: &str, medium: Medium) -> Entity {
    let order = DocumentOrder(next_order(edit.world));
    let name = free_name_for(edit.world, name);
    edit.spawn((medium, order, SceneId(name.clone()), Name::new(name)))
}

/// Fills closed shapes. All of them get the same medium. A surface that lets no light in gets the material `null`, which a message says.
pub fn fill(edit: &mut Edit, shapes: &[Entity], with: Filling) -> Result<(), CommandError> {
    // What is selected may hold other things.
    let is_free = |shape: &Entity| need_surface(edit, *shape).is_ok() && edit.world.get::<Locked>(*shape).is_none();
    let shapes: Vec<Entity> = shapes.iter().copied().filter(is_free).collect();
    if shapes.is_empty() {
        return Err("There is no shape that could be filled.".into());
    }
    for &shape in &shapes {
        let kind = edit.world.get::<Shape>(shape).map(|shape| &shape.kind);
        if kind.is_some_and(ShapeKind::is_flat) {
            return Err("Only a closed shape can be filled: this one has no inside.".into());
        }
    }
    let sizes = shapes.iter().filter_map(|shape| size_of(edit.world, *shape));
    let size = sizes.fold(0.0, f32::max);
    let size = if size > 0.0 { size } else { 1.0 };
    let medium = match with {
        Filling::Medium(medium) => medium,
        Filling::Fog => spawn(edit, "fog", fog(0.5 * size)),
        Filling::Smoke => spawn(edit, "smoke", smoke(0.25 * size)),
    };
    use_medium(edit, &shapes, MediumSide::Interior, Some(medium))?;
    let opaque = shapes.iter().copied();
    let opaque: Vec<Entity> = opaque.filter(|shape| !lets_light_in(edit.world, *shape)).collect();
    open_surfaces(edit, &opaque);
    Ok(())
}

/// Gives shapes the material `null`, and says so.
fn open_surfaces(edit: &mut Edit, shapes: &[Entity]) {
    if shapes.is_empty() {
        return;
    }
    let null = null_material(edit);
    for &shape in shapes {
        edit.set(shape, UsesMaterial(null));
    }
    let what = match *shapes {
        [only] => edit
            .world
            .get::<Name>(only)
            .map_or("The shape".into(), |name| format!("`{name}`")),
        _ => format!("{} shapes", shapes.len()),
    };
    let verb = if shapes.len() == 1 { "has" } else { "have" };
    tell(
        edit.world,
        format!(
            "{what} {verb} the material `null` now: the one before let no light in, and would have hidden what is inside."
        ),
    );
}

/// The material `null` of the scene, or a new one.
pub fn null_material(edit: &mut Edit) -> Entity {
    let mut known = edit.world.query_filtered::<(&DocumentOrder, Entity, &Material), (
        With<SceneId>,
        Without<DeclaredIn>,
        Without<FirstNestedIn>,
        Without<SecondNestedIn>,
    )>();
    let known = known
        .iter(edit.world)
        .filter(|(.., material)| **material == Material::Null);
    if let Some((_, known)) = known.map(|(order, entity, _)| (*order, entity)).min() {
        return known;
    }
    let order = DocumentOrder(next_order(edit.world));
    let name = free_name_for(edit.world, "null");
    edit.spawn((Material::Null, order, SceneId(name.clone()), Name::new(name)))
}

/// Whether light comes through the surface of a shape.
pub fn lets_light_in(world: &World, shape: Entity) -> bool {
    fn passes(world: &World, material: Entity, deepest: usize) -> bool {
        let Some(own) = world.get::<Material>(material) else {
            return false;
        };
        let is_opaque_around = matches!(own, Material::TwoSided);
        own.refracts()
            || matches!(own, Material::Null | Material::Mask { .. })
            || !is_opaque_around
                && deepest.checked_sub(1).is_some_and(|deepest| {
                    let mut inside = materials_inside(world, material).into_iter();
                    inside.any(|inner| passes(world, inner, deepest))
                })
    }
    let used = world.get::<UsesMaterial>(shape);
    used.is_some_and(|used| passes(world, used.0, DEEPEST))
}

/// A fog through which half of what is behind it is seen over seven tenths of this length, in world units.
pub fn fog(mean_free_path: f32) -> Medium {
    let albedo = Rgb::new(0.9, 0.94, 0.97);
    Medium {
        phase: PhaseFunction::HenyeyGreenstein { g: 0.5 },
        ..scattering(mean_free_path, albedo)
    }
}

fn smoke(mean_free_path: f32) -> Medium {
    Medium {
        phase: PhaseFunction::HenyeyGreenstein { g: 0.3 },
        ..scattering(mean_free_path, Rgb::new(0.5, 0.47, 0.45))
    }
}

/// A medium whose extinction has one digit, so that it is short in a file.
fn scattering(mean_free_path: f32, albedo: Rgb) -> Medium {
    Medium {
        coefficients: Coefficients::Extinction {
            sigma_t: Rgb::splat(spot::rounded(1.0 / mean_free_path)).into(),
            albedo: albedo.into(),
        },
        ..Medium::default()
    }
}

/// The mean extent of a shape along the axes, in world units. None for what is no shape, or one of unknown size.
fn size_of(world: &World, shape: Entity) -> Option<f32> {
    world.get::<Shape>(shape)?;
    let packed = world.get_resource::<PackedScene>();
    let bounds = packed.and_then(|packed| picking::bounds_of(packed, shape));
    let mean = |extent: Vec3| extent.element_sum() / 3.0;
    let size = match bounds {
        Some(bounds) => mean(bounds.extent()),
        None => {
            let axes = world.get::<ToWorld>(shape)?.0.matrix3;
            2.0 * mean(Vec3::new(
                axes.x_axis.length(),
                axes.y_axis.length(),
                axes.z_axis.length(),
            ))
        }
    };
    (size.is_finite() && size > 0.0).then_some(size)
}

/// Completes an edit, at its end: volumes move with the shapes that they fill, a medium without borders surrounds nothing, cameras and lights that have
/// moved through borders of media are in others, and where something has got a medium, the integrator traces media.
pub fn follow(edit: &mut Edit) {
    carry_volumes(edit);
    leave_borderless(edit);
    cross_borders(edit);
    let is_new = |edit: &Edit| {
        edit.touched().any(|(entity, before)| {
            let has = |now: bool, before: bool| now && !before;
            has(
                edit.world.get::<InteriorMedium>(entity).is_some(),
                before.interior.is_some(),
            ) || has(
                edit.world.get::<ExteriorMedium>(entity).is_some(),
                before.exterior.is_some(),
            ) || has(edit.world.get::<InMedium>(entity).is_some(), before.in_medium.is_some())
        })
    };
    if is_new(edit) {
        trace(edit.world, 0);
    }
}

/// Lets the integrator trace media, with paths of at least `depth` segments, and says what has changed.
pub fn trace(world: &mut World, depth: u32) {
    let before = world.get_resource::<IntegratorSettings>().copied().unwrap_or_default();
    let mut after = before;
    if !before.plugin.traces_media() {
        after.plugin = PathPlugin::VolPath;
    }
    after.max_depth = before.max_depth.map(|most| most.max(depth));
    if after == before {
        return;
    }
    world.insert_resource(after);
    if after.plugin != before.plugin {
        tell(
            world,
            "The integrator is `volpath` now: with `path` no medium is there.",
        );
    }
    if after.max_depth != before.max_depth {
        let text =
            format!("Paths have up to {depth} segments now, because light is scattered often below the surface.");
        tell(world, text);
    }
}

/// A shape that has moved, with the medium inside of it.
struct Carried {
    medium: Entity,
    shape: Entity,
    before: Affine3A,
    after: Affine3A,
}

/// Moves the volumes of media with the shapes that they fill, if all of those have moved alike.
fn carry_volumes(edit: &mut Edit) {
    let moved = edit.touched().filter_map(|(shape, before)| {
        let medium = edit.world.get::<InteriorMedium>(shape)?;
        let [old, new] = [before.to_world?.0, edit.world.get::<ToWorld>(shape)?.0];
        let is_carried = old != new && before.interior == Some(*medium) && edit.world.get::<Keys>(shape).is_none();
        is_carried.then_some(Carried {
            medium: medium.0,
            shape,
            before: old,
            after: new,
        })
    });
    let moved: Vec<Carried> = moved.collect();
    let edited = edit.touched().filter(|(_, before)| before.medium.is_some());
    let edited: Vec<Entity> = edited.map(|(medium, _)| medium).collect();
    let mut done: Vec<Entity> = edited;
    for first in &moved {
        if done.contains(&first.medium) {
            continue;
        }
        done.push(first.medium);
        let step = |of: &Carried| of.after * of.before.inverse();
        let own: Vec<&Carried> = moved.iter().filter(|other| other.medium == first.medium).collect();
        let users = edit.world.get::<InteriorOf>(first.medium);
        let users = users.into_iter().flat_map(|users| users.iter());
        let mut users = users.filter(|user| ObjectState::is_in_scene(edit.world, *user));
        let have_all_moved = users.all(|user| own.iter().any(|moved| moved.shape == user));
        let is_one_step = own.iter().all(|other| step(other).abs_diff_eq(step(first), ALIKE));
        if let (true, true, Some(medium)) = (have_all_moved, is_one_step, edit.world.get::<Medium>(first.medium))
            && medium.has_place()
        {
            let carried = self::moved(medium, &first.before, &first.after);
            edit.set(first.medium, carried);
        }
    }
}

/// Where the last shape that a medium was inside of goes, or gets another medium, what was in that medium is in the one that is there now.
fn leave_borderless(edit: &mut Edit) {
    let emptied = edit.touched().filter_map(|(shape, before)| {
        let medium = before.interior?.0;
        let now = edit.world.get::<InteriorMedium>(shape).map(|now| now.0);
        let around = before.exterior.map(|around| around.0);
        let is_borderless = edit
            .world
            .get::<InteriorOf>(medium)
            .is_none_or(|shapes| shapes.is_empty());
        let instead = now
            .or(around)
            .filter(|medium| ObjectState::is_in_scene(edit.world, *medium));
        is_borderless.then_some((medium, instead))
    });
    let emptied: Vec<(Entity, Option<Entity>)> = emptied.collect();
    for (medium, instead) in emptied {
        let surrounded: Vec<Entity> = users_of_medium(edit.world, medium).collect();
        for thing in surrounded {
            let side = match edit.world.get::<ExteriorMedium>(thing) {
                Some(_) => MediumSide::Exterior,
                None => MediumSide::Around,
            };
            set_side(edit, thing, side, instead);
        }
    }
}

/// Tells cameras and lights that have moved through borders of media what they are in now, unless borders have moved as well.
fn cross_borders(edit: &mut Edit) {
    let mut moved = Vec::new();
    for (thing, before) in edit.touched() {
        let (Some(ToWorld(old)), Some(ToWorld(new))) = (before.to_world, edit.world.get(thing)) else {
            continue;
        };
        let thing_now = edit.world.entity(thing);
        if old == *new {
            continue;
        }
        if thing_now.contains::<InteriorMedium>() || thing_now.contains::<ExteriorMedium>() {
            return;
        }
        let is_in_space = thing_now.contains::<Sensor>() || thing_now.contains::<Emitter>();
        let around = thing_now.get::<InMedium>().copied();
        if is_in_space && around == before.in_medium && !thing_now.contains::<Keys>() {
            moved.push((thing, around, [old, *new].map(|pose| Vec3::from(pose.translation))));
        }
    }
    for (thing, before, [old, new]) in moved {
        let packed = edit.world.get_resource::<PackedScene>();
        let before = before.map(|before| before.0);
        let now = packed.map_or(before, |packed| packed.medium_at(old, before, new));
        if now != before {
            set_side(edit, thing, MediumSide::Around, now);
        }
    }
}

/// The difference up to which moves are the same.
const ALIKE: f32 = 1e-4;

/// The medium with its volumes moved as a shape was that had the first pose and has the second.
fn moved(medium: &Medium, before: &Affine3A, after: &Affine3A) -> Medium {
    let by = *after * before.inverse();
    let mut moved = medium.clone();
    let filling = *before * cube_from_unit();
    let size = filling
        .matrix3
        .to_cols_array()
        .into_iter()
        .fold(0.0f32, |most, it| most.max(it.abs()));
    moved.for_each_place(&mut |to_world| {
        // A grid that fills a cube fills it exactly, however often that is moved.
        *to_world = match to_world.abs_diff_eq(filling, ALIKE * size) {
            true => *after * cube_from_unit(),
            false => by * *to_world,
        };
    });
    moved
}

/// The space of the shape `cube` from the unit cube, which volumes fill.
pub fn cube_from_unit() -> Affine3A {
    Affine3A::from_translation(Vec3::NEG_ONE) * Affine3A::from_scale(Vec3::splat(2.0))
}

/// A copy of a medium whose volumes were moved by a step in the world, for a copy of the shape that it fills. None if it is the same everywhere: the copies share it.
pub fn copied_with_place(edit: &mut Edit, medium: Entity, before: &Affine3A, after: &Affine3A) -> Option<Entity> {
    let own = edit.world.get::<Medium>(medium).filter(|medium| medium.has_place())?;
    let copy = moved(own, before, after);
    let name = edit.world.get::<Name>(medium).map_or("medium", Name::as_str).to_owned();
    Some(spawn(edit, &name, copy))
}

/// Puts the whole scene, with all cameras, into a box of fog, and returns the box. The medium is called `NAME-medium`.
pub fn surround(edit: &mut Edit, name: &str) -> Entity {
    let packed = edit.world.get_resource::<PackedScene>();
    let bounds = packed.and_then(picking::scene_bounds);
    let ahead = packed.and_then(picking::distance_ahead);
    let mut cameras = edit.world.query_filtered::<&ToWorld, With<Sensor>>();
    let mut eyes: Vec<Vec3> = cameras.iter(edit.world).map(|pose| pose.0.translation.into()).collect();
    eyes.extend(pose::view_pose(edit.world).map(|pose| Vec3::from(pose.translation)));
    let bounds = bounds.unwrap_or(Aabb {
        min: Vec3::splat(-ALONE),
        max: Vec3::splat(ALONE),
    });
    let bounds = eyes.into_iter().fold(bounds, Aabb::grown);
    let size = bounds.extent().length();
    let half = (0.5 * bounds.extent() + Vec3::splat(AROUND * size)).map(|half| rounding::with_digits(half, 3));
    let center = spot::rounded_place(bounds.center(), size);
    let pose = Affine3A::from_translation(center) * Affine3A::from_scale(half);
    // In the middle of the picture four tenths of the light are the fog's.
    let medium = fog(2.0 * ahead.filter(|ahead| *ahead > 0.0).unwrap_or(size));
    bounded(edit, name, pose, medium)
}

/// The part of a box of a medium that is sunk into what it stands on, in half heights. If its face were in the same plane, light would meet one or the other
/// at random.
pub const SUNK: f32 = 0.02;
/// Half the edge of the box of fog in a scene without shapes, in world units.
const ALONE: f32 = 10.0;
/// The distance of the box of fog from everything, as a share of the scene's diagonal.
const AROUND: f32 = 0.05;

/// A box that light does not notice, with this pose, of a new medium. What is in it is told that.
pub fn bounded(edit: &mut Edit, name: &str, pose: Affine3A, medium: Medium) -> Entity {
    let around = around(edit.world, &pose);
    let null = null_material(edit);
    let order = DocumentOrder(next_order(edit.world));
    let name = free_name_for(edit.world, name);
    let shape = Shape {
        kind: ShapeKind::Cube,
        ..Shape::default()
    };
    let called = (SceneId(name.clone()), Name::new(name.clone()));
    let entity = edit.spawn((shape, order, called, ToWorld(pose), UsesMaterial(null)));
    let medium = spawn(edit, &format!("{name}-medium"), medium);
    edit.set(entity, InteriorMedium(medium));
    if let Some(around) = around {
        edit.set(entity, ExteriorMedium(around));
    }
    enclose(edit, entity, &pose, medium);
    entity
}

/// Tells cameras and borders of other media that are in a cube, and in no other medium, that its medium is around them.
fn enclose(edit: &mut Edit, cube: Entity, pose: &Affine3A, medium: Entity) {
    let local = pose.inverse();
    let is_inside = |point: Vec3| local.transform_point3(point).abs().max_element() < 1.0;
    let mut cameras = edit
        .world
        .query_filtered::<(Entity, &ToWorld), (With<Sensor>, Without<InMedium>)>();
    let cameras = cameras.iter(edit.world);
    let cameras = cameras.filter(|(_, pose)| is_inside(pose.0.translation.into()));
    let cameras: Vec<Entity> = cameras.map(|(camera, _)| camera).collect();
    for camera in cameras {
        edit.set(camera, InMedium(medium));
    }
    let mut borders = edit
        .world
        .query_filtered::<(Entity, &ToWorld, &Shape), (With<InteriorMedium>, Without<ExteriorMedium>)>();
    let borders = borders.iter(edit.world).filter(|(entity, pose, shape)| {
        let middle = pose.0.transform_point3(shape.middle());
        *entity != cube && is_inside(middle)
    });
    let borders: Vec<Entity> = borders.map(|(entity, ..)| entity).collect();
    for border in borders {
        edit.set(border, ExteriorMedium(medium));
    }
}

/// The medium of the smallest cube that this one is inside of.
fn around(world: &mut World, pose: &Affine3A) -> Option<Entity> {
    let corners: Vec<Vec3> = (0..8)
        .map(|corner| {
            let sign = |axis: u32| if corner >> axis & 1 == 0 { -1.0 } else { 1.0 };
            pose.transform_point3(Vec3::new(sign(0), sign(1), sign(2)))
        })
        .collect();
    let mut cubes = world.query::<(&Shape, &ToWorld, &InteriorMedium, &DocumentOrder)>();
    let holding = cubes.iter(world).filter(|(shape, pose, ..)| {
        let local = pose.0.inverse();
        let is_inside = |corner: &Vec3| local.transform_point3(*corner).abs().max_element() < 1.0;
        shape.kind == ShapeKind::Cube && corners.iter().all(is_inside)
    });
    let volume = |pose: &ToWorld| pose.0.matrix3.determinant().abs();
    let smallest = holding.min_by(|(_, one, _, first), (_, other, _, second)| {
        volume(one).total_cmp(&volume(other)).then(first.cmp(second))
    });
    smallest.map(|(_, _, medium, _)| medium.0)
}
