//! Parses one line of a script into commands. Things are called by their names, and parameters by those of the file.

use std::path::{Path, PathBuf};

use bevy::math::{Affine3A, Quat};
use bevy::prelude::*;

use super::assign;
use super::baking::{self, BakeWait};
use super::error::ScriptError;
use super::names::{all_named, count, material_of, named, sample_count, unknown};
use super::placing::{about_origin, looking, transformed};
use super::set::set;
use super::verbs::VERBS;
use super::{blocking, keys, layers, media, placing, rendering, texturing, timeline};
use crate::app::editor::camera::navigation::scale_of;
use crate::app::editor::camera::pose::view_pose;
use crate::app::editor::camera::rounding;
use crate::app::editor::command::addition::{Addition, AdditionKind};
use crate::app::editor::command::asset_kind::FileUse;
use crate::app::editor::command::baking::BakeCommand;
use crate::app::editor::command::display::{DisplayMode, DisplaySettings};
use crate::app::editor::command::grid_settings::GridSettings;
use crate::app::editor::command::light_mix::LightMix;
use crate::app::editor::command::material_tree::{MaterialTree, can_wrap};
use crate::app::editor::command::preferences::Preferences;
use crate::app::editor::command::ruler::Ruler;
use crate::app::editor::command::seeing::{Seeing, Walls};
use crate::app::editor::command::selection::{Extend, Selection};
use crate::app::editor::command::shell::ShellCommand;
use crate::app::editor::command::{
    Command, DisplayCommand, FileCommand, HistoryCommand, MaterialEdit, OutlineEdit, RenderCommand, SceneEdit,
    SelectionCommand, TextureEdit, TimeCommand, ToolCommand, ValueEdit, ViewCommand,
};
use crate::app::editor::input::actions::{self, ActionContext};
use crate::app::editor::model::EditorModel;
use crate::app::editor::session::tutorial::LESSONS;
use crate::app::editor::session::view_settings::ViewSettings;
use crate::app::editor::viewport::model::action_context;
use crate::document::paths::settle;
use crate::document::value::{parse_float, parse_vec3};
use crate::engine::RenderControl;
use crate::render::tonemap::ToneMap;
use crate::scene::write::OnChange;
use crate::scene::{AreaLight, KeyEdit, Material};

/// The request of a line.
#[derive(Clone, Debug, PartialEq)]
pub enum Step {
    /// A command for this frame.
    Do(Command),
    /// The lines after it wait.
    Wait(Wait),
    /// A bake into this folder. The lines after it wait for the end of it.
    Bake(PathBuf),
    /// The lines after it wait for the bake that is under way.
    AwaitBake(BakeWait),
    /// The whole window, as PNG.
    Screenshot(PathBuf),
}

/// The event that a line waits for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Wait {
    /// The picture of the present scene has exactly this number of samples per pixel, and gets no more; 0: everything
    /// is loaded.
    Samples(u32),
    /// The picture has reached one of its own limits.
    Done,
}

/// Reads one line of a script; None for a comment or an empty line. Names are looked up in the scene of `world` as it
/// is now.
pub fn line(world: &mut World, text: &str) -> Result<Option<Step>, ScriptError> {
    let text = text.trim();
    if text.is_empty() || text.starts_with('#') {
        return Ok(None);
    }
    // XML is not split into words.
    if let Some(xml) = text.strip_prefix("paste ") {
        return Ok(Some(Step::Do(SceneEdit::Paste(xml.to_owned()).into())));
    }
    let words = words(text)?;
    let (verb, arguments) = words.split_first().ok_or("expected a command")?;
    let arguments: Vec<&str> = arguments.iter().map(String::as_str).collect();
    // The state that a switch of the menus is to have.
    let wanted = match arguments[..] {
        ["on"] => Some(true),
        ["off"] => Some(false),
        _ => None,
    };
    if let Some(action) = actions::find(verb)
        && (arguments.is_empty() || wanted.is_some())
    {
        let selection = world.resource::<Selection>().clone();
        let context = context(world, &selection);
        if wanted.is_some() {
            match action.switch(&context) {
                None => return Err(no_words_behind(verb)),
                is_on if is_on == wanted => return Ok(None),
                _ => {}
            }
        }
        let command = (action.command)(&context);
        let nothing = || ScriptError::from(format!("`{verb}`: nothing is selected")).of_scene();
        let command = command.ok_or_else(nothing)?;
        return Ok(Some(Step::Do(command)));
    }
    let step = verb_step(world, verb, &arguments);
    step.map(Some)
        .map_err(|error| match VERBS.iter().find(|(name, _)| name == verb) {
            Some((verb, usage)) => {
                let error = Box::new(error);
                ScriptError::Usage { error, verb, usage }
            }
            None => error,
        })
}

fn no_words_behind(verb: &str) -> ScriptError {
    format!("`{verb}` takes no words behind it").into()
}

fn context<'a>(world: &World, selection: &'a Selection) -> ActionContext<'a> {
    ActionContext {
        paused: world.resource::<RenderControl>().paused,
        has_textures: true,
        has_kept_picture: true,
        has_missing: true,
        can_revert: true,
        ..action_context(
            world.resource::<ViewSettings>(),
            &world.resource::<EditorModel>().0,
            selection,
        )
    }
}

/// A place of the picture.
fn parse_place(text: &str) -> Result<Vec2, ScriptError> {
    match crate::document::value::parse_floats(text)?[..] {
        [x, y] => Ok(Vec2::new(x, y)),
        _ => Err("expected two numbers".into()),
    }
}

fn verb_step(world: &mut World, verb: &str, arguments: &[&str]) -> Result<Step, ScriptError> {
    let command = match (verb, arguments) {
        ("open", [path]) => Command::from(FileCommand::OpenScene(path.into())),
        ("save-to", [path]) => Command::from(FileCommand::SaveScene(path.into())),
        ("save-to", [path, "merge"]) => Command::from(FileCommand::SaveChanged(path.into(), OnChange::TakeIn)),
        ("save-to", [path, "overwrite"]) => Command::from(FileCommand::SaveChanged(path.into(), OnChange::Overwrite)),
        ("export-to", [path]) => Command::from(FileCommand::ExportScene(path.into())),
        ("bake-with", words) if !words.is_empty() => baking::choices(world, words)?,
        ("bake-to", [folder]) => return Ok(Step::Bake(folder.into())),
        ("begin-bake", [folder]) => Command::Bake(BakeCommand::Begin(folder.into())),
        ("wait-for-bake", [wait]) => return Ok(Step::AwaitBake(baking::wait(wait)?)),
        ("show-lightmap", [number]) => baking::page(number)?,
        ("save-image-to", [path]) => Command::from(FileCommand::SaveImage(path.into())),
        ("import-file", [path]) => Command::from(SceneEdit::Import(path.into())),
        ("find-file", [missing, found]) => Command::from(SceneEdit::FindFile {
            missing: settle(Path::new(missing)),
            found: settle(Path::new(found)),
            others: true,
        }),
        ("use-file", [path, at @ ..]) if at.len() < 2 => {
            let at = at.first().map(|at| parse_place(at)).transpose()?;
            let path = std::path::absolute(path).unwrap_or_else(|_| path.into());
            Command::from(SceneEdit::UseFile(Box::new(FileUse { path, at, bounds: None })))
        }
        ("select", names) => Command::from(SelectionCommand::Select(all_named(world, names)?, Extend::Replace)),
        ("select-also", names) => Command::from(SelectionCommand::Select(all_named(world, names)?, Extend::Add)),
        ("pick", [place]) => Command::from(SelectionCommand::Pick(parse_place(place)?, Extend::Replace)),
        ("add", [kind, options @ ..]) => Command::from(SceneEdit::Add(addition(kind, options)?)),
        ("draw", [kind, from, to, options @ ..]) => blocking::draw(world, kind, [from, to], options)?,
        ("push", [name, face, distance]) => blocking::push(world, name, face, distance)?,
        ("cut", [kind, wall, from, options @ ..]) => blocking::cut(world, wall, kind, from, options)?,
        ("move", [name, by]) => {
            let by = parse_vec3(by)?;
            transformed(world, name, |pose| Affine3A {
                translation: rounding::sum_of_places(pose.translation.into(), by).into(),
                ..pose
            })?
        }
        ("rotate", [name, axis, degrees]) => {
            let axis = parse_vec3(axis)?.try_normalize().ok_or("the axis has no length")?;
            let turn = Affine3A::from_quat(Quat::from_axis_angle(axis, parse_float(degrees)?.to_radians()));
            transformed(world, name, |pose| about_origin(turn, pose))?
        }
        ("scale", [name, factor]) => {
            let factor = Affine3A::from_scale(Vec3::splat(parse_float(factor)?));
            transformed(world, name, |pose| about_origin(factor, pose))?
        }
        ("align", words) => placing::align(words)?,
        ("distribute", words) => placing::distribute(words)?,
        ("series", words) => placing::series(words)?,
        ("snap", [to, how @ ..]) => placing::snap(world, to, how)?,
        ("set", [name, parameter, value @ ..]) if !value.is_empty() => {
            let entity = named(world, name)?;
            set(world, entity, parameter, &value.join(" "))?
        }
        ("place-texture", [name, options @ ..]) => {
            let owner = named(world, name)?;
            texturing::place(world, owner, options)?
        }
        ("project-texture", [from, tile, shapes @ ..]) if !shapes.is_empty() => {
            let projection = texturing::projection(world, from, tile)?;
            Command::from(TextureEdit::ProjectTextures {
                shapes: all_named(world, shapes)?,
                projection,
            })
        }
        ("material-of", [shape]) => Command::from(MaterialEdit::GiveMaterial {
            shape: named(world, shape)?,
        }),
        ("make", [name, plugin]) => {
            let material = Material::of_plugin(plugin);
            let material = material.ok_or_else(|| unknown("material", plugin, Material::PLUGINS))?;
            if *material.info().nested.start() > 0 {
                return Err(format!("a {plugin} has others inside: paste it as XML").into());
            }
            let thing = named(world, name)?;
            let entity = material_of(world, thing).ok_or("it has no material")?;
            let is_two_sided = world.get::<Material>(entity) == Some(&Material::TwoSided);
            let wrapper = (is_two_sided && can_wrap("twosided", &material)).then_some("twosided");
            let tree = MaterialTree::from(material);
            Command::from(MaterialEdit::BuildMaterial {
                targets: vec![entity],
                tree: Box::new(match wrapper {
                    Some(wrapper) => tree.wrapped(wrapper),
                    None => tree,
                }),
            })
        }
        ("wrap", [name, plugin]) => layers::wrap(world, name, plugin)?,
        ("unwrap", [name, which @ ..]) if which.len() <= 1 => layers::unwrap(world, name, which.first().copied())?,
        ("assign", [material, shapes @ ..]) if !shapes.is_empty() => Command::from(MaterialEdit::UseMaterial {
            shapes: all_named(world, shapes)?,
            material: Some(named(world, material)?),
        }),
        ("preset", [path, shapes @ ..]) if !shapes.is_empty() => {
            let shapes = all_named(world, shapes)?;
            let presets = world.resource::<EditorModel>().0.presets.clone();
            let preset = presets.iter().find(|preset| preset.path() == *path);
            let paths: Vec<String> = presets.iter().map(|preset| preset.path()).collect();
            let preset = preset.ok_or_else(|| unknown("preset", path, paths.iter().map(String::as_str)))?;
            Command::from(MaterialEdit::UsePreset {
                preset: Box::new(preset.clone()),
                shapes,
            })
        }
        ("medium", [medium, side, things @ ..]) if !things.is_empty() => media::medium(world, medium, side, things)?,
        ("medium-of", [thing, side @ ..]) if side.len() <= 1 => media::new_medium(world, thing, side.first().copied())?,
        ("fill", [with, shapes @ ..]) if !shapes.is_empty() => media::fill(world, with, shapes)?,
        ("emit", [shape, "none"]) => Command::from(ValueEdit::SetAreaLight(named(world, shape)?, None)),
        ("emit", [shape, radiance]) => {
            let mut light = AreaLight::default();
            assign::area_light(&mut light, "radiance", radiance)?;
            Command::from(ValueEdit::SetAreaLight(named(world, shape)?, Some(light)))
        }
        ("rename", [name, new]) => Command::from(OutlineEdit::Rename(named(world, name)?, (*new).to_owned())),
        ("hide-thing", names) if !names.is_empty() => Command::from(OutlineEdit::Hide(all_named(world, names)?, true)),
        ("lock", [switch, names @ ..]) if !names.is_empty() => {
            let is_on = rendering::switch(switch)?;
            Command::from(OutlineEdit::Lock(all_named(world, names)?, is_on))
        }
        ("put-into", [folder, names @ ..]) if !names.is_empty() => Command::from(OutlineEdit::PutInto {
            things: all_named(world, names)?,
            folder: (*folder != "none").then(|| (*folder).to_owned()),
        }),
        ("put-before", [name, other]) => Command::from(OutlineEdit::Reorder {
            moved: vec![named(world, name)?],
            before: Some(named(world, other)?),
        }),
        ("look", [from, at]) => {
            // The extent that an orthographic camera sees stays the same.
            let extent = view_pose(world).map_or(Vec3::ONE, |pose| scale_of(&pose));
            Command::from(ViewCommand::MoveView(
                looking(parse_vec3(from)?, parse_vec3(at)?)? * Affine3A::from_scale(extent),
            ))
        }
        ("look-through", [camera]) => Command::from(ViewCommand::LookThrough(named(world, camera)?)),
        ("go-to", [step]) => Command::from(HistoryCommand::GoTo(count(step)? as usize)),
        ("samples", [number]) => Command::from(RenderCommand::SetTargetSamples(sample_count(number)?)),
        ("show", [mode]) => {
            let mode = mode.replace('-', " ");
            let known = DisplayMode::ALL
                .iter()
                .find(|(_, name)| name.eq_ignore_ascii_case(&mode));
            let known = known.ok_or_else(|| unknown("mode", &mode, DisplayMode::ALL.iter().map(|(_, name)| *name)))?;
            display(world, |display| display.mode = known.0)
        }
        ("exposure", [stops]) => {
            let stops = assign::within(parse_float(stops)?, &DisplaySettings::EXPOSURES)?;
            display(world, |display| display.exposure = stops)
        }
        ("tone-map", [name]) => {
            let known = ToneMap::ALL.into_iter().find(|map| map.name() == *name);
            let known = known.ok_or_else(|| unknown("tone map", name, ToneMap::ALL.iter().map(|map| map.name())))?;
            display(world, |display| display.tone_map = known)
        }
        ("white", [kelvin, tint @ ..]) if tint.len() <= 1 => {
            let white_balance = rendering::white(kelvin, tint.first().copied())?;
            display(world, |display| display.white_balance = white_balance)
        }
        ("limit-time", [seconds]) => Command::from(RenderCommand::SetTimeLimit(rendering::positive(seconds)?)),
        ("limit-noise", [noise]) => Command::from(RenderCommand::SetNoiseTarget(rendering::noise(noise)?)),
        ("adaptive", [word]) => Command::from(RenderCommand::SetAdaptive(rendering::switch(word)?)),
        ("resolution", [name]) => Command::from(RenderCommand::SetResolution(rendering::resolution(name)?)),
        ("enlarge", [name]) => Command::from(DisplayCommand::SetEnlarging(rendering::enlarging(name)?)),
        ("region", corners) => Command::from(RenderCommand::SetRegion(rendering::region(corners)?)),
        ("layers", names) => rendering::layers(world, names)?,
        ("choose-integrator", [switch]) => Command::from(RenderCommand::SetPathIsAuto(rendering::switch(switch)?)),
        ("split-strategies", [switch]) => Command::from(RenderCommand::SetStrategySplit(rendering::switch(switch)?)),
        ("measure-between", [from, to]) => Command::from(ToolCommand::AddRuler(Ruler {
            from: parse_vec3(from)?,
            to: parse_vec3(to)?,
        })),
        ("show-grid", [switch]) => Command::from(DisplayCommand::SetGrid(GridSettings {
            shown: rendering::switch(switch)?,
            ..world.resource::<ViewSettings>().grid
        })),
        ("hide-walls", [switch]) => seeing(world, |seen| {
            seen.walls = match rendering::switch(switch)? {
                true => Walls::Hidden,
                false => Walls::Shown,
            };
            Ok(())
        })?,
        ("cut-plane", words) => seeing(world, |seen| {
            seen.cut = rendering::cut(words)?;
            Ok(())
        })?,
        ("show-alone", ["none"]) => Command::from(ViewCommand::Isolate(Vec::new())),
        ("show-alone", names) if !names.is_empty() => Command::from(ViewCommand::Isolate(all_named(world, names)?)),
        ("keep-lights-apart", [switch]) => Command::from(RenderCommand::SetLightLayers(rendering::switch(switch)?)),
        ("mix", ["none"]) => Command::from(DisplayCommand::SetLightMix(LightMix::default())),
        ("mix", [light, gain @ ..]) => rendering::mix(world, light, gain)?,
        ("compare", view) => Command::from(DisplayCommand::SetCompareView(rendering::compare_view(view)?)),
        ("bind", [action, key]) => keys::choose(world.get_resource::<Preferences>(), action, key)?,
        ("tutorial-step", ["off"]) => Command::Shell(ShellCommand::ShowTutorial(None)),
        ("tutorial-step", [number]) => {
            let step = (count(number)? as usize).checked_sub(1);
            let step = step
                .filter(|step| *step < LESSONS.len())
                .ok_or("expected off or 1 to 5")?;
            Command::Shell(ShellCommand::ShowTutorial(Some(step)))
        }
        ("time", [time]) => Command::from(TimeCommand::SetTime(timeline::precise(time)?)),
        ("frame", [frame]) => {
            let frames = world.resource::<ViewSettings>().timeline;
            Command::from(TimeCommand::SetTime(frames.time(timeline::frame(frame)?)))
        }
        ("timeline", [fps, first, last]) => timeline::frames(fps, first, last)?,
        ("key", [name, path @ ..]) if path.len() <= 1 => timeline::set(world, name, path.first().copied())?,
        ("unkey", [name, path @ ..]) if path.len() <= 1 => {
            timeline::remove(world, name, path.first().copied(), KeyEdit::Remove)?
        }
        ("stand-still", [name, path @ ..]) if path.len() <= 1 => {
            timeline::remove(world, name, path.first().copied(), KeyEdit::RemoveAll)?
        }
        ("move-key", [name, path, from, to]) => timeline::shift(world, name, path, [from, to])?,
        ("interpolate", [name, path, way]) => timeline::interpolate(world, name, path, way)?,
        ("wait", ["done"]) => return Ok(Step::Wait(Wait::Done)),
        ("wait", [samples]) => return Ok(Step::Wait(Wait::Samples(count(samples)?))),
        ("screenshot", [path]) => return Ok(Step::Screenshot(path.into())),
        _ if VERBS.iter().any(|(name, _)| *name == verb) => return Err(format!("`{verb}` takes other words").into()),
        _ if actions::find(verb).is_some() => return Err(no_words_behind(verb)),
        _ => {
            let actions = actions::ACTIONS.iter().map(|action| action.name);
            return Err(unknown(
                "command",
                verb,
                VERBS.iter().map(|(name, _)| *name).chain(actions),
            ));
        }
    };
    Ok(Step::Do(command))
}

/// Blanks separate words; quotes keep them together, `key=value` needs none around the whole.
fn words(text: &str) -> Result<Vec<String>, ScriptError> {
    let mut words = Vec::new();
    let mut word: Option<String> = None;
    let mut quoted = false;
    for c in text.chars() {
        match c {
            '"' => {
                quoted = !quoted;
                word.get_or_insert_default();
            }
            c if c.is_whitespace() && !quoted => words.extend(word.take()),
            c => word.get_or_insert_default().push(c),
        }
    }
    if quoted {
        return Err("a quotation mark is not closed".into());
    }
    words.extend(word);
    Ok(words)
}

fn addition(kind: &str, options: &[&str]) -> Result<Addition, ScriptError> {
    let known = AdditionKind::of_name(kind).ok_or_else(|| {
        let names: Vec<&str> = AdditionKind::all().map(AdditionKind::name).collect();
        format!("\"{kind}\" cannot be added, only {}", names.join(", "))
    })?;
    let mut addition = Addition::from(known);
    for option in options {
        match option.split_once('=') {
            Some(("name", name)) => addition.name = Some(name.to_owned()),
            Some(("at", place)) => addition.at = Some(parse_vec3(place)?),
            Some(("size", size)) => {
                let size = assign::within(parse_float(size)?, &(f32::MIN_POSITIVE..=f32::MAX))?;
                addition.size = Some(size);
            }
            _ => return Err(format!("expected name=, at= or size=, found `{option}`").into()),
        }
    }
    // The same whatever the camera sees.
    if addition.at.is_some() {
        addition.size.get_or_insert(known.usual_size());
    }
    Ok(addition)
}

fn display(world: &World, change: impl FnOnce(&mut DisplaySettings)) -> Command {
    let mut display = world.resource::<ViewSettings>().display;
    change(&mut display);
    Command::from(DisplayCommand::SetDisplay(display))
}

fn seeing(world: &World, change: impl FnOnce(&mut Seeing) -> Result<(), ScriptError>) -> Result<Command, ScriptError> {
    let mut seeing = world.resource::<ViewSettings>().seeing;
    change(&mut seeing)?;
    Ok(ViewCommand::SetSeeing(seeing).into())
}
