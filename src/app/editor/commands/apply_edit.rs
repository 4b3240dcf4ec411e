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
use crate::app::editor::command::error::CommandError;
use crate::app::editor::command::selection::Selection;
use crate::app::editor::command::{
    ArrangeEdit, CameraEdit, EditCommand, MaterialEdit, MediumEdit, OutlineEdit, SceneEdit, SettingsEdit, TextureEdit,
    TimeEdit, ValueEdit,
};
use crate::app::editor::session::history::{Edit, StepKind};
use crate::app::editor::session::trust;
use crate::document::paths::settle;
use crate::scene::{
    AccelMethod, AreaLight, Hidden, IntegratorSettings, Locked, Material, MemberOf, SamplerSettings, UsesMaterial,
};

/// Applies an edit. After an error the caller undoes what was done before it.
pub fn apply(edit: &mut Edit, command: EditCommand) -> Result<(), CommandError> {
    match command {
        EditCommand::Scene(SceneEdit::Import(path)) => adding::import_chosen(edit, &path)?,
        EditCommand::Scene(SceneEdit::UseFile(file)) => use_file(edit, &file)?,
        EditCommand::Scene(SceneEdit::FindFile { missing, found, others }) => {
            finding::find(edit, &missing, &found, others)?
        }
        EditCommand::Scene(SceneEdit::Paste(text)) => adding::paste(edit, &text)?,
        EditCommand::Scene(SceneEdit::Add(addition)) => adding::add(edit, addition)?,
        EditCommand::Scene(SceneEdit::Build(block)) => blocking::build(edit, *block)?,
        EditCommand::Scene(SceneEdit::Reshape(entity, shape, pose, _)) => blocking::reshape(edit, entity, shape, pose)?,
        EditCommand::Scene(SceneEdit::Delete) => delete_selection(edit)?,
        EditCommand::Scene(SceneEdit::Cut) => {
            super::files::copy(edit.world)?;
            delete_selection(edit)?;
        }
        EditCommand::Scene(SceneEdit::Duplicate) => copying::duplicate(edit)?,
        EditCommand::Scene(SceneEdit::MakeSeries(series)) => copying::series(edit, &series)?,
        EditCommand::Arrange(ArrangeEdit::Align(axis, side, to)) => arranging::align(edit, axis, side, to)?,
        EditCommand::Arrange(ArrangeEdit::Distribute(axis, by)) => arranging::distribute(edit, axis, by)?,
        EditCommand::Arrange(ArrangeEdit::FitToView(entities)) => fitting::fit_to_view(edit, &entities)?,
        EditCommand::Outline(OutlineEdit::Rename(entity, name)) => rename(edit, entity, &name)?,
        EditCommand::Outline(OutlineEdit::Reorder { moved, before }) => reorder(edit, &moved, before),
        EditCommand::Outline(OutlineEdit::Group) => grouping::group(edit)?,
        EditCommand::Outline(OutlineEdit::Ungroup) => grouping::ungroup(edit)?,
        EditCommand::Outline(OutlineEdit::PutInto { things, folder }) => {
            grouping::put_into(edit, things, folder.as_deref())?
        }
        EditCommand::Outline(OutlineEdit::Hide(entities, hidden)) => hide(edit, &entities, hidden),
        EditCommand::Outline(OutlineEdit::HideOthers) => {
            let selection = edit.world.resource::<Selection>().clone();
            let others = visible_things(edit.world, |entity| !selection.contains(entity));
            hide(edit, &others, true);
        }
        EditCommand::Outline(OutlineEdit::ShowAll) => {
            let mut hidden = edit.world.query_filtered::<Entity, With<Hidden>>();
            let hidden: Vec<Entity> = hidden.iter(edit.world).collect();
            hide(edit, &hidden, false);
        }
        EditCommand::Outline(OutlineEdit::Lock(entities, locked)) => {
            for entity in entities {
                if locked {
                    edit.set(entity, Locked);
                } else {
                    edit.remove::<Locked>(entity);
                }
            }
        }
        EditCommand::Camera(CameraEdit::MoveCameraToView) => {
            view::move_camera_to_view(edit)?;
        }
        EditCommand::Arrange(ArrangeEdit::Nudge(direction)) => {
            edit.kind = StepKind::Move;
            placing::nudge(edit, direction)?;
        }
        EditCommand::Arrange(ArrangeEdit::Drop) => placing::drop(edit)?,
        EditCommand::Arrange(ArrangeEdit::SnapToGrid) => placing::onto_grid(edit)?,
        EditCommand::Value(ValueEdit::Transform(poses)) => {
            edit.kind = StepKind::Move;
            let poses = grouping::with_members(edit, poses);
            transform(edit, poses)?;
        }
        EditCommand::Value(ValueEdit::Turn(entity, pose, angles)) => {
            edit.kind = StepKind::Move;
            let poses = grouping::with_members(edit, vec![(entity, pose)]);
            transform(edit, poses)?;
            set_angles(edit, entity, Some(angles));
        }
        EditCommand::Value(ValueEdit::SetShape(entity, shape)) => replace(edit, entity, shape)?,
        EditCommand::Value(ValueEdit::SetMaterial(entity, material)) => {
            replace(edit, entity, *material)?;
            materials::check_sides(edit.world, entity)?;
        }
        EditCommand::Texture(TextureEdit::SetPicture {
            owner,
            parameter,
            place,
            path,
        }) => {
            let path = settle(&path);
            trust::allow_chosen(edit.world, &path);
            set_picture(edit, owner, parameter, place, path);
        }
        EditCommand::Material(MaterialEdit::UseMaterial { shapes, material }) => {
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
        EditCommand::Texture(TextureEdit::PlaceTextures { owner, before, after }) => {
            texturing::place(edit, owner, before, after)?
        }
        EditCommand::Texture(TextureEdit::ProjectTextures { shapes, projection }) => {
            uv_projection::project(edit, &shapes, projection)?
        }
        EditCommand::Material(MaterialEdit::GiveMaterial { shape }) => {
            need_surface(edit, shape)?;
            let before = edit.world.get::<UsesMaterial>(shape).map(|uses| uses.0);
            let material = materials::copy_or_grey(edit, before);
            edit.set(shape, UsesMaterial(material));
        }
        EditCommand::Material(MaterialEdit::DropMaterial { material, at }) => materials::drop_at(edit, material, at)?,
        EditCommand::Material(MaterialEdit::BuildMaterial { targets, tree }) => {
            materials::build(edit, &targets, &tree)?
        }
        EditCommand::Material(MaterialEdit::UsePreset { preset, shapes }) => {
            materials::use_preset(edit, &preset, &shapes)?
        }
        EditCommand::Material(MaterialEdit::DropPreset { preset, at }) => {
            let shape = materials::shape_at(edit, at)?;
            materials::use_preset(edit, &preset, &[shape])?;
        }
        EditCommand::Value(ValueEdit::SetMedium(entity, medium)) => media::set(edit, entity, *medium)?,
        EditCommand::Medium(MediumEdit::UseMedium { things, side, medium }) => {
            media::use_medium(edit, &things, side, medium)?
        }
        EditCommand::Medium(MediumEdit::GiveMedium { thing, side }) => media::give(edit, thing, side)?,
        EditCommand::Medium(MediumEdit::Fill { shapes, with }) => media::fill(edit, &shapes, with)?,
        EditCommand::Value(ValueEdit::SetAreaLight(entity, light)) => match light {
            Some(light) => {
                need_surface(edit, entity)?;
                if edit.world.get::<MemberOf>(entity).is_some() {
                    return Err("Shapes that stand there as instances cannot shine.".into());
                }
                edit.set(entity, light);
            }
            None => edit.remove::<AreaLight>(entity),
        },
        EditCommand::Value(ValueEdit::SetEmitter(entity, emitter)) => replace(edit, entity, emitter)?,
        EditCommand::Value(ValueEdit::SetSensor(entity, sensor)) => replace(edit, entity, sensor)?,
        EditCommand::Camera(CameraEdit::FocusAt(film)) => view::focus(edit, film)?,
        EditCommand::Value(ValueEdit::SetFilm(entity, film)) => replace(edit, entity, film)?,
        EditCommand::Settings(SettingsEdit::SetIntegrator(settings)) => {
            super::world::set_resource::<IntegratorSettings>(edit.world, settings)
        }
        EditCommand::Settings(SettingsEdit::SetSampler(settings)) => {
            super::world::set_resource::<SamplerSettings>(edit.world, settings)
        }
        EditCommand::Settings(SettingsEdit::SetAccel(method)) => {
            super::world::set_resource::<AccelMethod>(edit.world, method)
        }
        EditCommand::Settings(SettingsEdit::SetUnit(unit)) => super::world::set_unit(edit.world, unit),
        EditCommand::Settings(SettingsEdit::BakeLights) => mixing::bake(edit)?,
        EditCommand::Camera(CameraEdit::KeepLimits) => limits::keep(edit)?,
        EditCommand::Time(TimeEdit::AddTurntable) => timeline::add_turntable(edit)?,
        EditCommand::Time(TimeEdit::Key(targets, how)) => timeline::edit(edit, &targets, how)?,
        EditCommand::OnSelection(command) => {
            several::carry_to_others(edit, &command);
            apply(edit, (*command).into())?;
        }
    }
    Ok(())
}
