//! Adds the content of files and of the clipboard. A glTF file becomes a group of its name.

use std::cmp::Reverse;
use std::path::{Path, PathBuf};

use bevy::math::Affine3A;
use bevy::prelude::*;

use super::adding::{self, set_sky, sky, turned_up};
use super::files::CLIPBOARD;
use super::fitting;
use super::grouping::is_frame;
use super::things::{is_no_name, select_new};
use super::volumes;
use crate::app::editor::command::SceneEdit;
use crate::app::editor::command::addition::{Addition, AdditionKind};
use crate::app::editor::command::error::CommandError;
use crate::app::editor::command::selection::Selection;
use crate::app::editor::session::history::Edit;
use crate::app::editor::session::toasts::{Toasts, Topic};
use crate::app::editor::session::trust;
use crate::app::editor::session::view_settings::ViewSettings;
use crate::app::editor::words::files::{LAMPS, PICTURES, VOLUMES, extension};
use crate::color::Rgb;
use crate::document::{Diagnostics, Severity, parse_within};
use crate::scene::assets::scene_asset::load_document;
use crate::scene::description::{Identity, ShapeDescription};
use crate::scene::insert::{insert, next_order};
use crate::scene::names::free_name_for;
use crate::scene::{
    DocumentOrder, Emitter, EmitterKind, MeshFile, MeshFormat, SceneAccess, SceneDescription, SceneId, Shape,
    ShapeKind, SquarePath, Trust, read,
};

/// The content of a file that the user has chosen joins the scene, which may read the file from then on.
pub fn import_chosen(edit: &mut Edit, path: &Path) -> Result<(), CommandError> {
    import(edit, path)?;
    fitting::note_import(edit.world);
    trust::allow_chosen(edit.world, path);
    Ok(())
}

/// The absolute path of a file that is there.
pub fn file_of(path: &Path) -> Result<PathBuf, CommandError> {
    let path = read::settle(path);
    match path.is_file() {
        true => Ok(path),
        false => Err(CommandError::file(format!(
            "{}: there is no such file.",
            path.display()
        ))),
    }
}

/// The format of a mesh file with this extension; None for other files, also for those of curves.
pub fn mesh_format(extension: &str) -> Option<MeshFormat> {
    let formats = [MeshFormat::Obj, MeshFormat::Ply, MeshFormat::Serialized];
    formats.into_iter().find(|format| format.name() == extension)
}

/// The geometry of a mesh file.
pub fn mesh_of(path: PathBuf, format: MeshFormat) -> ShapeKind {
    ShapeKind::Mesh(MeshFile {
        path,
        format,
        flip_tex_coords: format.flips_tex_coords(),
        ..MeshFile::default()
    })
}

/// A file's content joins the scene.
fn import(edit: &mut Edit, path: &Path) -> Result<(), CommandError> {
    let path = file_of(path)?;
    let extension = extension(&path);
    if let Some(format) = mesh_format(&extension) {
        add_mesh(edit, path, format);
        edit.world.resource_mut::<Toasts>().forget(Topic::Saving);
        return Ok(());
    }
    match extension.as_str() {
        volume if VOLUMES.contains(&volume) => volumes::import(edit, &path, None)?,
        picture if PICTURES.contains(&picture) => set_environment(edit, path),
        lamp if LAMPS.contains(&lamp) => add_lamp(edit, path, None)?,
        "xml" | "gltf" | "glb" => {
            let mut content = scene_of(edit, &path, SceneEdit::Import)?;
            if extension != "xml" {
                group_as(&mut content, &name_of(&path));
            }
            insert_all(edit, content).map_err(CommandError::file)?;
        }
        _ => {
            return Err(CommandError::file(format!(
                "{}: not a file that can be imported (obj, ply, serialized, xml, gltf, glb, hdr, exr, png, jpg, pfm, bmp, tga, ppm, pgm, vol, vdb, ies, ldt)",
                path.display()
            )));
        }
    }
    edit.world.resource_mut::<Toasts>().forget(Topic::Saving);
    Ok(())
}

/// The content of a scene or a glTF file. Where it names files that may not be read, the user is asked; once they are
/// allowed, the edit that needs the content is repeated, which `again` makes from the path.
pub fn scene_of(
    edit: &mut Edit,
    path: &Path,
    again: impl FnOnce(PathBuf) -> SceneEdit,
) -> Result<SceneDescription, CommandError> {
    let trust = edit.world.get_resource::<Trust>().cloned().unwrap_or_default();
    let access = trust.access(path);
    let mut document = load_document(path, &[], access).map_err(CommandError::file)?;
    let scene = read::read(&mut document);
    let refused = document.access.refused();
    if document.diagnostics.has_errors() && !refused.is_empty() {
        trust::ask_about_edit(edit.world, again(path.to_owned()), refused);
    }
    check(&document.diagnostics).map_err(CommandError::file)?;
    Ok(without_setting(scene, document.stand_in_light.as_deref()))
}

/// The scene without cameras and without the light that stands in where a file has none: the scene that imports it has
/// its own.
fn without_setting(mut scene: SceneDescription, stand_in_light: Option<&str>) -> SceneDescription {
    scene.sensors.clear();
    if let Some(stand_in) = stand_in_light {
        scene
            .emitters
            .retain(|emitter| emitter.identity.id.as_deref() != Some(stand_in));
    }
    scene
}

/// Puts the things of a file into a group of this name, whose place is the origin of the file. What is in a folder of
/// that name already stays there, and a single thing gets the name itself.
fn group_as(scene: &mut SceneDescription, name: &str) {
    let lights = scene.emitters.iter_mut().filter(|light| !light.emitter.is_sky());
    let shapes = scene.shapes.iter_mut().map(|shape| &mut shape.identity);
    let mut things: Vec<&mut Identity> = shapes.chain(lights.map(|light| &mut light.identity)).collect();
    let folder = format!("{name}/");
    match &mut things[..] {
        [] => return,
        [only] => return rename(only, name.to_owned()),
        _ => {}
    }
    if !things.iter().all(|thing| thing.name.starts_with(&folder)) {
        for thing in &mut things {
            let inside = format!("{folder}{}", thing.name);
            rename(thing, inside);
        }
    }
    if things.iter().any(|thing| thing.name == folder) {
        return;
    }
    let order = things.iter().map(|thing| thing.order).max().unwrap_or_default();
    let frame = Shape {
        kind: ShapeKind::Frame,
        ..Shape::default()
    };
    scene.shapes.push(ShapeDescription {
        identity: Identity {
            id: Some(folder.clone()),
            name: folder.into(),
            order: order.saturating_add(1),
            ..Identity::default()
        },
        shape: frame,
        to_world: Affine3A::IDENTITY,
        material: None,
        interior: None,
        exterior: None,
        area_light: None,
        member_of: None,
        instance_of: None,
        placements: None,
    });
}

fn rename(thing: &mut Identity, name: String) {
    thing.id = Some(name.clone());
    thing.name = name.into();
}

/// A name for the content of a file: its own without the extension.
fn name_of(file: &Path) -> String {
    let stem = file.file_stem().unwrap_or_default().to_string_lossy();
    let plain = stem.replace(|c| is_no_name(c) || c == '/', "-");
    if plain.is_empty() { "mesh".to_owned() } else { plain }
}

fn add_mesh(edit: &mut Edit, path: PathBuf, format: MeshFormat) {
    let name = free_name_for(edit.world, &name_of(&path));
    let shape = Shape {
        kind: mesh_of(path, format),
        ..Shape::default()
    };
    let order = DocumentOrder(next_order(edit.world));
    let entity = edit.spawn((order, SceneId(name.clone()), Name::new(name), shape));
    select_new(edit, vec![entity]);
}

/// Adds a lamp with the intensities of a file, which shines down from `position`, or from where new lights stand.
pub fn add_lamp(edit: &mut Edit, path: PathBuf, position: Option<Vec3>) -> Result<(), CommandError> {
    let addition = Addition {
        name: Some(name_of(&path)),
        at: position,
        // It is placed as a spot, which becomes the lamp.
        ..AdditionKind::Emitter("spot").into()
    };
    adding::add(edit, addition)?;
    let lamp = edit.world.resource::<Selection>().active();
    let lamp = lamp.ok_or("The lamp could not be added.")?;
    let kind = EmitterKind::Luminaire {
        profile: path,
        scale: Rgb::ONE,
        flux: 0.0,
    };
    edit.set(lamp, Emitter::from(kind));
    Ok(())
}

/// Replaces the environment, since a scene has one sky.
fn set_environment(edit: &mut Edit, picture: PathBuf) {
    let up = edit.world.resource::<ViewSettings>().navigation.up;
    let emitter = match sky(edit.world) {
        Some(entity) => edit.world.get::<Emitter>(entity).cloned(),
        None => None,
    };
    let emitter = match emitter {
        Some(mut known) if matches!(known.kind, EmitterKind::Environment { .. }) => {
            known.set_picture(SquarePath::WHOLE, picture);
            known
        }
        _ => Emitter::from(EmitterKind::Environment {
            picture,
            scale: 1.0,
            mis_compensation: true,
        }),
    };
    let entity = set_sky(edit, emitter, turned_up(up, Vec3::Y), "environment");
    select_new(edit, vec![entity]);
}

/// Plugins as XML: a whole scene, or single elements.
pub fn paste(edit: &mut Edit, text: &str) -> Result<(), CommandError> {
    let text = text.trim();
    if !text.starts_with('<') {
        return Err("The clipboard holds no XML.".into());
    }
    let is_scene = text.contains("<scene");
    let text = if is_scene {
        text.to_owned()
    } else {
        format!("<scene version=\"3.0.0\">{text}</scene>")
    };
    // A text from elsewhere may name files that its reader does not know.
    let mut document = parse_within(&*text, Path::new(CLIPBOARD), &[], SceneAccess::of(edit.world));
    let scene = read::read(&mut document);
    check(&document.diagnostics)?;
    Ok(insert_all(edit, scene)?)
}

/// The first error as a sentence for the user.
fn check(diagnostics: &Diagnostics) -> Result<(), String> {
    let mut errors = diagnostics.list.iter();
    match errors.find(|diagnostic| diagnostic.severity == Severity::Error) {
        Some(first) => Err(diagnostics.line(first)),
        None => Ok(()),
    }
}

/// The error is a sentence for the user.
fn insert_all(edit: &mut Edit, scene: SceneDescription) -> Result<(), String> {
    let inserted = insert(edit.world, &scene);
    if inserted.all.is_empty() {
        return Err("There is nothing in it.".to_owned());
    }
    edit.spawned(inserted.all);
    // Groups follow their members, as they are selected: the last one, which is an outermost one, becomes active.
    let is_group = |entity: &Entity| is_frame(edit.world, *entity);
    let (mut groups, mut objects): (Vec<Entity>, Vec<Entity>) = inserted.objects.into_iter().partition(is_group);
    let depth = |entity: &Entity| {
        edit.world
            .get::<Name>(*entity)
            .map_or(0, |name| name.matches('/').count())
    };
    groups.sort_by_key(|group| Reverse(depth(group)));
    objects.extend(groups);
    select_new(edit, objects);
    Ok(())
}
