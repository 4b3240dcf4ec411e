//! Finds the edit of the scene that an edit command asks for.

use bevy::prelude::*;

use super::edits::{delete_selection, hide, rename, reorder, visible_things};
use super::file_use::use_file;
use super::pictures::set_picture;
use super::things::{need, need_surface, replace, set_angles, transform};
use super::{
    adding, arranging, blocking, copying, finding, fitting, grouping, limits, materials, media, mixing, placing,
    several, texturing, timeline, uv_projection, view,
};
use crate::app::editor::command::Command;
use crate::app::editor::command::error::CommandError;
use crate::app::editor::command::selection::Selection;
use crate::app::editor::session::history::{Edit, StepKind};
use crate::app::editor::session::trust;
use crate::document::paths::settle;
use crate::scene::{
    AccelMethod, AreaLight, Hidden, IntegratorSettings, Locked, Material, MemberOf, SamplerSettings, UsesMaterial,
};

/// Applies an edit. After an error the caller undoes what was done before it.
pub fn apply(edit: &mut Edit, command: Command) -> Result<(), CommandError> {
    match command {
        Command::Import(path) => adding::import_chosen(edit, &path)?,
        Command::UseFile(file) => use_file(edit, &file)?,
        Command::FindFile { missing, found, others } => finding::find(edit, &missing, &found, others)?,
        Command::Paste(text) => adding::paste(edit, &text)?,
        Command::Add(addition) => adding::add(edit, addition)?,
        Command::Build(block) => blocking::build(edit, *block)?,
        Command::Reshape(entity, shape, pose, _) => blocking::reshape(edit, entity, shape, pose)?,
        Command::Delete => delete_selection(edit)?,
        Command::Cut => {
            super::files::copy(edit.world)?;
            delete_selection(edit)?;
        }
        Command::Duplicate => copying::duplicate(edit)?,
        Command::MakeSeries(series) => copying::series(edit, &series)?,
        Command::Align(axis, side, to) => arranging::align(edit, axis, side, to)?,
        Command::Distribute(axis, by) => arranging::distribute(edit, axis, by)?,
        Command::FitToView(entities) => fitting::fit_to_view(edit, &entities)?,
        Command::Rename(entity, name) => rename(edit, entity, &name)?,
        Command::Reorder { moved, before } => reorder(edit, &moved, before),
        Command::Group => grouping::group(edit)?,
        Command::Ungroup => grouping::ungroup(edit)?,
        Command::PutInto { things, folder } => grouping::put_into(edit, things, folder.as_deref())?,
        Command::Hide(entities, hidden) => hide(edit, &entities, hidden),
        Command::HideOthers => {
            let selection = edit.world.resource::<Selection>().clone();
            let others = visible_things(edit.world, |entity| !selection.contains(entity));
            hide(edit, &others, true);
        }
        Command::ShowAll => {
            let mut hidden = edit.world.query_filtered::<Entity, With<Hidden>>();
            let hidden: Vec<Entity> = hidden.iter(edit.world).collect();
            hide(edit, &hidden, false);
        }
        Command::Lock(entities, locked) => {
            for entity in entities {
                if locked {
                    edit.set(entity, Locked);
                } else {
                    edit.remove::<Locked>(entity);
                }
            }
        }
        Command::MoveCameraToView => {
            view::move_camera_to_view(edit)?;
        }
        Command::Nudge(direction) => {
            edit.kind = StepKind::Move;
            placing::nudge(edit, direction)?;
        }
        Command::Drop => placing::drop(edit)?,
        Command::SnapToGrid => placing::onto_grid(edit)?,
        Command::Transform(poses) => {
            edit.kind = StepKind::Move;
            let poses = grouping::with_members(edit, poses);
            transform(edit, poses)?;
        }
        Command::Turn(entity, pose, angles) => {
            edit.kind = StepKind::Move;
            let poses = grouping::with_members(edit, vec![(entity, pose)]);
            transform(edit, poses)?;
            set_angles(edit, entity, Some(angles));
        }
        Command::SetShape(entity, shape) => replace(edit, entity, shape)?,
        Command::SetMaterial(entity, material) => {
            replace(edit, entity, *material)?;
            materials::check_sides(edit.world, entity)?;
        }
        Command::SetPicture {
            owner,
            parameter,
            place,
            path,
        } => {
            let path = settle(&path);
            trust::allow_chosen(edit.world, &path);
            set_picture(edit, owner, parameter, place, path);
        }
        Command::UseMaterial { shapes, material } => {
            if let Some(material) = material {
                need::<Material>(edit, material)?;
            }
            for shape in shapes {
                need_surface(edit, shape)?;
                match material {
                    Some(material) => edit.set(shape, UsesMaterial(material)),
                    None => edit.remove::<UsesMaterial>(shape),
                }
            }
        }
        Command::PlaceTextures { owner, before, after } => texturing::place(edit, owner, before, after)?,
        Command::ProjectTextures { shapes, projection } => uv_projection::project(edit, &shapes, projection)?,
        Command::GiveMaterial { shape } => {
            need_surface(edit, shape)?;
            let before = edit.world.get::<UsesMaterial>(shape).map(|uses| uses.0);
            let material = materials::copy_or_grey(edit, before);
            edit.set(shape, UsesMaterial(material));
        }
        Command::DropMaterial { material, at } => materials::drop_at(edit, material, at)?,
        Command::BuildMaterial { targets, tree } => materials::build(edit, &targets, &tree)?,
        Command::UsePreset { preset, shapes } => materials::use_preset(edit, &preset, &shapes)?,
        Command::DropPreset { preset, at } => {
            let shape = materials::shape_at(edit, at)?;
            materials::use_preset(edit, &preset, &[shape])?;
        }
        Command::SetMedium(entity, medium) => media::set(edit, entity, *medium)?,
        Command::UseMedium { things, side, medium } => media::use_medium(edit, &things, side, medium)?,
        Command::GiveMedium { thing, side } => media::give(edit, thing, side)?,
        Command::Fill { shapes, with } => media::fill(edit, &shapes, with)?,
        Command::SetAreaLight(entity, light) => match light {
            Some(light) => {
                need_surface(edit, entity)?;
                if edit.world.get::<MemberOf>(entity).is_some() {
                    return Err("Shapes that stand there as instances cannot shine.".into());
                }
                edit.set(entity, light);
            }
            None => edit.remove::<AreaLight>(entity),
        },
        Command::SetEmitter(entity, emitter) => replace(edit, entity, emitter)?,
        Command::SetSensor(entity, sensor) => replace(edit, entity, sensor)?,
        Command::FocusAt(film) => view::focus(edit, film)?,
        Command::SetFilm(entity, film) => replace(edit, entity, film)?,
        Command::SetIntegrator(settings) => super::world::set_resource::<IntegratorSettings>(edit.world, settings),
        Command::SetSampler(settings) => super::world::set_resource::<SamplerSettings>(edit.world, settings),
        Command::SetAccel(method) => super::world::set_resource::<AccelMethod>(edit.world, method),
        Command::SetUnit(unit) => super::world::set_unit(edit.world, unit),
        Command::BakeLights => mixing::bake(edit)?,
        Command::KeepLimits => limits::keep(edit)?,
        Command::AddTurntable => timeline::add_turntable(edit)?,
        Command::Key(targets, how) => timeline::edit(edit, &targets, how)?,
        Command::OnSelection(command) => {
            several::carry_to_others(edit, &command);
            apply(edit, *command)?;
        }
        // The others are no edits.
        _ => {}
    }
    Ok(())
}
