//! Edits of media: the media inside and around things, and the fillings of shapes.

use bevy::math::Vec3;
use bevy::prelude::*;

use super::spot;
use super::things::{need, need_surface, replace};
use super::world::tell;
use crate::app::editor::camera::picking;
use crate::app::editor::command::MediumEdit;
use crate::app::editor::command::error::CommandError;
use crate::app::editor::command::material_tree::materials_inside;
use crate::app::editor::command::media::{Filling, MediumSide};
use crate::app::editor::session::history::Edit;
use crate::app::editor::session::trust;
use crate::color::Rgb;
use crate::engine::PackedScene;
use crate::scene::insert::next_order;
use crate::scene::names::free_name_for;
use crate::scene::{
    Coefficients, DeclaredIn, DocumentOrder, Emitter, ExteriorMedium, FirstNestedIn, InMedium, InteriorMedium, Locked,
    Material, Medium, PhaseFunction, SceneId, SecondNestedIn, Sensor, Shape, ShapeKind, ToWorld, UsesMaterial,
};

/// Applies the edit.
pub fn edit(edit: &mut Edit, command: MediumEdit) -> Result<(), CommandError> {
    match command {
        MediumEdit::UseMedium { things, side, medium } => use_medium(edit, &things, side, medium)?,
        MediumEdit::GiveMedium { thing, side } => give(edit, thing, side)?,
        MediumEdit::Fill { shapes, with } => fill(edit, &shapes, with)?,
    }
    Ok(())
}

/// The depth to which nested materials are searched.
const DEEPEST: usize = 8;

/// Sets the parameters of a medium. Grid files that it did not name before count as chosen by the user.
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

/// Sets or removes the medium at a side of each thing. An error if a thing has no such side.
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

/// Sets or removes the medium at a side of a thing that has such a side.
pub(super) fn set_side(edit: &mut Edit, thing: Entity, side: MediumSide, medium: Option<Entity>) {
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

/// Fills closed shapes, all with the same medium. An opaque surface gets the material `null`, which a message says.
pub fn fill(edit: &mut Edit, shapes: &[Entity], with: Filling) -> Result<(), CommandError> {
    // Selected entities that are no shapes with a surface are skipped.
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

/// Whether the surface of a shape transmits light.
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

/// A fog that transmits half of the light over seven tenths of this length, in world units.
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

/// The mean extent of a shape along the axes, in world units. None for an entity that is no shape, or one of unknown
/// size.
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
