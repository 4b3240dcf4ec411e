//! Where [`Command`]s come true: the only place of the editor that writes to the world.
//!
//! Values are compared before they are written, so that saying what is already so changes nothing.

use std::path::{Path, PathBuf};

use bevy::math::Affine3A;
use bevy::prelude::*;

use super::command::Command;
use super::denoiser::Denoiser;
use super::display::{DisplayMode, DisplaySettings};
use super::latency::FrameTimes;
use super::navigation;
use super::options::SceneDefines;
use super::pacing::Pacing;
use super::picking;
use super::state::{CommandQueue, EditorState, RightTab};
use crate::engine::{CurrentScene, InputStamp, RenderControl, RenderFilm, RenderState, RenderStatus, ViewMode, WakeUp};
use crate::math::Aabb;
use crate::render::image_io::{ImageRgb, write_image};
use crate::scene::{
    AccelMethod, ActiveSensor, AreaLight, DocumentOrder, Emitter, IntegratorSettings, Lens, Material, OpenScene,
    Placements, SamplerSettings, SceneStatus, Sensor, Texture, ToWorld, UsesMaterial, write,
};

/// Applies this frame's commands in order.
pub fn apply_commands(world: &mut World) {
    let commands = std::mem::take(&mut world.resource_mut::<CommandQueue>().0);
    if commands.is_empty() {
        return;
    }
    // Input is taken in at the start of the frame.
    let arrived = world.resource::<FrameTimes>().frame_started();
    world.insert_resource(InputStamp(arrived));
    let restarts = commands.iter().any(Command::restarts_picture);
    world.resource_mut::<Pacing>().note_commands(restarts);
    for command in commands {
        if let Err(message) = apply(world, command) {
            world.resource_mut::<EditorState>().say(message);
        }
    }
}

/// The error is a sentence for the user.
fn apply(world: &mut World, command: Command) -> Result<(), String> {
    match command {
        Command::OpenScene(path) => open_scene(world, path),
        Command::ReloadScene => {
            let path = world.resource::<SceneStatus>().path.clone();
            open_scene(world, path.ok_or("No scene is open.")?);
        }
        Command::SaveScene(path) => save_scene(world, &path)?,
        Command::SaveImage(path) => save_image(world, &path)?,
        Command::ShowDialog(kind) => world.resource_mut::<EditorState>().dialog = Some(kind),
        Command::Quit => {
            world.write_message(AppExit::Success);
        }

        Command::Select(entity) => select(world, entity),
        Command::Pick(film) => {
            let entity = picking::pick(world.resource::<CurrentScene>(), film);
            select(world, entity);
        }
        Command::FrameSelection => {
            let selection = world.resource::<EditorState>().selection;
            let current = world.resource::<CurrentScene>();
            let bounds = selection.and_then(|entity| picking::bounds_of(current, entity));
            frame(world, bounds.ok_or("Nothing that is in the picture is selected.")?);
        }
        Command::FrameAll => {
            let bounds = picking::scene_bounds(world.resource::<CurrentScene>());
            frame(world, bounds.ok_or("The scene is empty.")?);
        }
        Command::MoveCamera(pose) => {
            if let Some(sensor) = world.resource::<ActiveSensor>().0 {
                let pose = with_extent_of(world, sensor, pose);
                set(world, sensor, ToWorld(pose));
            }
        }
        Command::LookThrough(entity) => {
            if let Some(ToWorld(pose)) = world.get::<ToWorld>(entity).copied() {
                world.resource_mut::<EditorState>().navigation.up = navigation::up_axis(&pose);
            }
            set_resource(world, ActiveSensor(Some(entity)));
        }
        Command::SetSpeed(speed) => {
            let mut state = world.resource_mut::<EditorState>();
            state.navigation.speed = speed.clamp(*navigation::SPEED_RANGE.start(), *navigation::SPEED_RANGE.end());
        }

        Command::SetToWorld(entity, _) if world.get::<Placements>(entity).is_some() => {
            return Err("So many instances stay where the file has them.".into());
        }
        Command::SetToWorld(entity, to_world) => set(world, entity, ToWorld(to_world)),
        Command::SetShape(entity, shape) => set(world, entity, shape),
        Command::SetMaterial(entity, material) => set(world, entity, *material),
        Command::SetPicture { owner, parameter, path } => set_picture(world, owner, parameter, &path),
        Command::UseMaterial { shape, material } => match material {
            Some(material) => set(world, shape, UsesMaterial(material)),
            None => remove::<UsesMaterial>(world, shape),
        },
        Command::GiveMaterial { shape } => give_material(world, shape),
        Command::SetAreaLight(entity, light) => match light {
            Some(light) => set(world, entity, light),
            None => remove::<AreaLight>(world, entity),
        },
        Command::SetEmitter(entity, emitter) => set(world, entity, emitter),
        Command::SetSensor(entity, sensor) => set(world, entity, sensor),
        Command::SetFilm(entity, film) => set(world, entity, film),
        Command::SetIntegrator(settings) => set_resource::<IntegratorSettings>(world, settings),
        Command::SetSampler(settings) => set_resource::<SamplerSettings>(world, settings),
        Command::SetAccel(method) => set_resource::<AccelMethod>(world, method),

        Command::SetPaused(paused) => control(world, |control| control.paused = paused),
        Command::Restart => control(world, |control| control.restart_requested = true),
        Command::SetTargetSamples(samples) => control(world, |control| control.target_samples = Some(samples.max(1))),
        Command::SetResolutionScale(scale) => {
            control(world, |control| control.resolution_scale = scale.clamp(0.05, 1.0));
        }
        Command::SetDisplay(display) => set_display(world, display),
        Command::SetOverlay(overlay) => world.resource_mut::<EditorState>().overlay = overlay,
        Command::Denoise => {
            let wake_up = world.resource::<WakeUp>().clone();
            let threads = world.resource::<RenderControl>().threads;
            world.resource_scope(|world, mut denoiser: Mut<Denoiser>| {
                denoiser.start(world.resource::<RenderFilm>(), threads, wake_up);
            });
        }
        Command::DropDenoised => world.resource_mut::<Denoiser>().clear(),
        Command::ShowPanels(shown) => world.resource_mut::<EditorState>().panels_shown = shown,
    }
    Ok(())
}

/// Looked at as the picture before it; other textures become a plain picture. Lights have one parameter that may be a picture.
fn set_picture(world: &mut World, owner: Entity, parameter: &str, path: &Path) {
    if let Some(mut edited) = world.get::<Material>(owner).cloned() {
        edited.visit_textures(|name, texture| {
            if name == parameter {
                *texture = Texture::of_picture(path.to_owned(), Some(texture));
            }
        });
        set(world, owner, edited);
    }
    if let Some(mut edited) = world.get::<AreaLight>(owner).cloned() {
        edited.radiance.set_picture(path.to_owned());
        set(world, owner, edited);
    }
    if let Some(mut edited) = world.get::<Emitter>(owner).cloned() {
        edited.set_picture(path.to_owned());
        set(world, owner, edited);
    }
}

/// Writes a component if it differs.
fn set<C: Component + PartialEq>(world: &mut World, entity: Entity, value: C) {
    if let Ok(mut entity) = world.get_entity_mut(entity)
        && entity.get::<C>() != Some(&value)
    {
        entity.insert(value);
    }
}

fn remove<C: Component>(world: &mut World, entity: Entity) {
    if let Ok(mut entity) = world.get_entity_mut(entity) {
        entity.remove::<C>();
    }
}

fn set_resource<R: Resource + PartialEq>(world: &mut World, value: R) {
    if world.get_resource::<R>() != Some(&value) {
        world.insert_resource(value);
    }
}

fn control(world: &mut World, edit: impl FnOnce(&mut RenderControl)) {
    let mut edited = world.resource::<RenderControl>().clone();
    edit(&mut edited);
    set_resource(world, edited);
}

fn set_display(world: &mut World, display: DisplaySettings) {
    let display = DisplaySettings {
        exposure: display.exposure.clamp(-20.0, 20.0),
        ..display
    };
    world.resource_mut::<EditorState>().display = display;
    let view_mode = match display.mode {
        DisplayMode::BvhSteps => ViewMode::BvhSteps,
        _ => ViewMode::Path,
    };
    control(world, |control| control.view_mode = view_mode);
}

fn select(world: &mut World, entity: Option<Entity>) {
    let mut state = world.resource_mut::<EditorState>();
    state.selection = entity;
    if entity.is_some() {
        state.right_tab = RightTab::Inspector;
    }
}

fn is_orthographic(world: &World, sensor: Entity) -> bool {
    let lens = world.get::<Sensor>(sensor).map(|sensor| sensor.lens);
    lens == Some(Lens::Orthographic)
}

/// The pose with the scale that an orthographic camera has now: flying does not change how much it sees.
fn with_extent_of(world: &World, sensor: Entity, pose: Affine3A) -> Affine3A {
    match world.get::<ToWorld>(sensor) {
        Some(ToWorld(now)) if is_orthographic(world, sensor) => {
            let axes = now.matrix3;
            let extent = Vec3::new(axes.x_axis.length(), axes.y_axis.length(), axes.z_axis.length());
            pose * Affine3A::from_scale(extent)
        }
        _ => pose,
    }
}

fn frame(world: &mut World, bounds: Aabb) {
    let Some(sensor) = world.resource::<ActiveSensor>().0 else {
        return;
    };
    let view = world.resource::<CurrentScene>().view.as_ref();
    let half_fov = view.map_or(0.3, |view| picking::half_fov(&view.camera));
    let aspect = view.map_or(1.0, |view| view.width as f32 / view.height as f32);
    let Some(ToWorld(pose)) = world.get::<ToWorld>(sensor).copied() else {
        return;
    };
    let framed = if is_orthographic(world, sensor) {
        navigation::framing_parallel(pose, &bounds, aspect)
    } else {
        navigation::framing(pose, &bounds, half_fov)
    };
    if let Some(pose) = framed {
        set(world, sensor, ToWorld(pose));
    }
}

fn give_material(world: &mut World, shape: Entity) {
    let last = world
        .query::<&DocumentOrder>()
        .iter(world)
        .map(|order| order.0)
        .max()
        .unwrap_or(0);
    let name = Name::new("new material");
    let material = world
        .spawn((Material::default(), DocumentOrder(last.saturating_add(1)), name))
        .id();
    set(world, shape, UsesMaterial(material));
}

fn open_scene(world: &mut World, path: PathBuf) {
    let defines = world.resource::<SceneDefines>().0.clone();
    world.write_message(OpenScene { path, defines });
}

fn save_scene(world: &mut World, path: &Path) -> Result<(), String> {
    write::save(world, path).map_err(|error| error.to_string())?;
    world
        .resource_mut::<EditorState>()
        .say(format!("Saved {}", path.display()));
    Ok(())
}

/// The denoised picture if that is what is shown.
fn save_image(world: &mut World, path: &Path) -> Result<(), String> {
    if world.resource::<RenderStatus>().state == RenderState::Idle {
        return Err("There is no picture to save.".to_owned());
    }
    let film = &world.resource::<RenderFilm>().film;
    let pixels = match world.resource::<Denoiser>().picture() {
        Some(denoised) => denoised.radiance.clone(),
        None => film.radiance(),
    };
    let image = ImageRgb {
        width: film.width(),
        height: film.height(),
        pixels,
    };
    let display = world.resource::<EditorState>().display.tone();
    write_image(path, &image, &display).map_err(|error| error.to_string())?;
    world
        .resource_mut::<EditorState>()
        .say(format!("Saved {}", path.display()));
    Ok(())
}

/// The pose of the camera in use.
pub fn camera_pose(active: &ActiveSensor, poses: &Query<&ToWorld>) -> Option<Affine3A> {
    poses.get(active.0?).ok().map(|pose| pose.0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::color::Rgb;
    use crate::scene::Parameter;

    fn world() -> World {
        let mut world = World::new();
        world.init_resource::<EditorState>();
        world.init_resource::<CommandQueue>();
        world.init_resource::<RenderControl>();
        world.init_resource::<ActiveSensor>();
        world.init_resource::<FrameTimes>();
        world.init_resource::<Pacing>();
        world
    }

    fn say(world: &mut World, command: Command) {
        world.resource_mut::<CommandQueue>().0.push(command);
        apply_commands(world);
    }

    #[test]
    fn saying_what_is_so_changes_nothing() {
        let mut world = world();
        let material = Material::default();
        let entity = world.spawn(material.clone()).id();
        world.clear_trackers();
        say(&mut world, Command::SetMaterial(entity, Box::new(material)));
        let paused = world.resource::<RenderControl>().paused;
        say(&mut world, Command::SetPaused(paused));
        assert!(
            !world
                .entity(entity)
                .get_ref::<Material>()
                .is_some_and(|m| m.is_changed())
        );
        assert!(!world.resource_ref::<RenderControl>().is_changed());
        let red = Material::Diffuse {
            reflectance: Rgb::X.into(),
        };
        say(&mut world, Command::SetMaterial(entity, Box::new(red.clone())));
        assert_eq!(world.get::<Material>(entity), Some(&red));
        assert!(
            world
                .entity(entity)
                .get_ref::<Material>()
                .is_some_and(|m| m.is_changed())
        );
    }

    #[test]
    fn a_new_material_belongs_to_its_shape() {
        let mut world = world();
        let shape = world.spawn(crate::scene::Shape::default()).id();
        say(&mut world, Command::GiveMaterial { shape });
        let used = world.get::<UsesMaterial>(shape).map(|uses| uses.0);
        assert!(used.is_some_and(|material| world.get::<Material>(material).is_some()));
        say(&mut world, Command::UseMaterial { shape, material: None });
        assert!(world.get::<UsesMaterial>(shape).is_none());
    }

    #[test]
    fn a_picture_goes_to_whatever_has_one() {
        let mut world = world();
        let lamp = world.spawn(AreaLight::default()).id();
        let sky = world.spawn(Emitter::of_plugin("envmap").expect("a plugin")).id();
        for owner in [lamp, sky] {
            let path = PathBuf::from("/pictures/sky.exr");
            let parameter = "filename";
            say(&mut world, Command::SetPicture { owner, parameter, path });
        }
        let mut found = Vec::new();
        if let Some(Emitter { kind, .. }) = world.get(sky) {
            Emitter::from(kind.clone()).for_each_picture(&mut |path| found.push(path.clone()));
        }
        if let Some(Parameter::Texture(texture)) = world.get::<AreaLight>(lamp).map(|light| &light.radiance) {
            texture.for_each_bitmap(&mut |bitmap| found.push(bitmap.path.clone()));
        }
        assert_eq!(found, [Path::new("/pictures/sky.exr"); 2]);
    }

    #[test]
    fn commands_about_what_is_gone_do_no_harm() {
        let mut world = world();
        let gone = world.spawn_empty().id();
        world.despawn(gone);
        say(&mut world, Command::SetEmitter(gone, Emitter::default()));
        say(&mut world, Command::MoveCamera(Affine3A::IDENTITY));
        say(&mut world, Command::LookThrough(gone));
        assert!(world.query::<&Emitter>().iter(&world).next().is_none());
    }

    #[test]
    fn the_heat_map_is_another_view() {
        let mut world = world();
        let display = DisplaySettings {
            mode: DisplayMode::BvhSteps,
            ..DisplaySettings::default()
        };
        say(&mut world, Command::SetDisplay(display));
        assert_eq!(world.resource::<RenderControl>().view_mode, ViewMode::BvhSteps);
    }
}
