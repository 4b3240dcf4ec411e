//! Where [`Command`]s come true: the only place of the editor that writes to the world.
//!
//! Values are compared before they are written, so that saying what is already so changes nothing. Edits of the scene become steps of the
//! [`History`]; one that fails leaves nothing behind.

mod adding;
mod edits;
mod files;
mod finished;
mod materials;
mod mixing;
mod placing;
mod view;

use bevy::prelude::*;

use super::command::{Command, Effect};
use super::compare::Comparison;
use super::denoiser::Denoiser;
use super::display::{DisplayMode, DisplaySettings};
use super::history::{self, Edit, History};
use super::latency::FrameTimes;
use super::layout::Panel;
use super::light_mix::LightMix;
use super::pacing::Pacing;
use super::paths::PathInspector;
use super::picking;
use super::selection::{Extend, Selection};
use super::shell;
use super::state::{CommandQueue, EditorState};
use super::toasts::Topic;
use super::tool::Tool;
use crate::engine::{CurrentScene, InputStamp, RenderControl, RenderFilm, WakeUp};
use crate::scene::{
    ActiveSensor, DocumentOrder, Emitter, Hidden, Locked, MemberOf, ObjectState, SceneStatus, Sensor, Shape,
};
pub use view::{camera_pose, view_pose};

/// Applies this frame's commands in order.
pub fn apply_commands(world: &mut World) {
    let commands = std::mem::take(&mut world.resource_mut::<CommandQueue>().0);
    if commands.is_empty() {
        return;
    }
    note_input(world, commands.iter().any(Command::restarts_picture));
    for command in commands {
        let is_about_file = command.is_about_file();
        let outcome = apply(world, command);
        let mut state = world.resource_mut::<EditorState>();
        match outcome {
            Ok(()) if is_about_file => state.toasts.forget(Topic::Saving),
            Ok(()) => {}
            Err(message) if is_about_file => state.complain(Topic::Saving, message, None),
            Err(message) => state.refuse(message),
        }
    }
}

/// As a command of this frame, but the error is handed back.
pub fn apply_now(world: &mut World, command: Command) -> Result<(), String> {
    note_input(world, command.restarts_picture());
    apply(world, command)
}

fn note_input(world: &mut World, restarts: bool) {
    // Input is taken in at the start of the frame.
    let arrived = world.resource::<FrameTimes>().frame_started();
    world.insert_resource(InputStamp(arrived));
    world.resource_mut::<Pacing>().note_commands(restarts);
}

/// Does what the command says. The error is a sentence for the user; nothing is changed then.
pub fn apply(world: &mut World, command: Command) -> Result<(), String> {
    let effect = command.effect();
    match effect {
        Effect::Edit | Effect::Drag => edit(world, command, effect == Effect::Drag)?,
        Effect::View | Effect::None => act(world, command)?,
    }
    keep_what_is_there(world);
    Ok(())
}

fn edit(world: &mut World, command: Command, merges: bool) -> Result<(), String> {
    let (label, targets) = (command.label(), command.targets());
    let interaction = world.resource::<EditorState>().interaction;
    let mut edit = Edit::begin(world);
    match edits::apply(&mut edit, command) {
        Ok(()) => {
            let title = edit.titled(label, &targets);
            keep_what_is_there(edit.world);
            edit.finish(title, merges.then_some((interaction, (label, targets))));
            Ok(())
        }
        Err(message) => {
            edit.abandon();
            Err(message)
        }
    }
}

fn act(world: &mut World, command: Command) -> Result<(), String> {
    match command {
        Command::NewScene => files::new_scene(world),
        Command::OpenScene(path) => files::open_scene(world, path),
        Command::ReloadScene => {
            let path = world.resource::<SceneStatus>().path.clone();
            files::open_scene(world, path.ok_or("No scene is open.")?);
        }
        Command::Save => files::save(world)?,
        Command::SaveScene(path) => files::save_scene(world, &path)?,
        Command::SaveImage(path) => files::save_image(world, &path)?,
        Command::ShowDialog(kind) => world.resource_mut::<EditorState>().dialog = Some(kind),
        Command::Quit => {
            world.write_message(AppExit::Success);
        }
        Command::Copy => files::copy(world)?,

        Command::Undo => history::undo(world)?,
        Command::Redo => history::redo(world)?,
        Command::GoTo(steps) => {
            while world.resource::<History>().len().0 > steps && history::undo(world).is_ok() {}
            while world.resource::<History>().len().0 < steps && history::redo(world).is_ok() {}
        }

        Command::Select(entities, how) => select(world, &entities, how),
        Command::SelectAll => {
            let mut things = world.query_filtered::<(Entity, &DocumentOrder), (
                Or<(With<Shape>, With<Emitter>)>,
                Without<Locked>,
                Without<Hidden>,
                Without<MemberOf>,
            )>();
            let mut things: Vec<_> = things.iter(world).map(|(entity, order)| (*order, entity)).collect();
            things.sort();
            let things: Vec<Entity> = things.into_iter().map(|(_, entity)| entity).collect();
            select(world, &things, Extend::Replace);
        }
        Command::Pick(film, how) => {
            let found = picking::pick(world.resource::<CurrentScene>(), film);
            let found = found.filter(|entity| world.get::<Locked>(*entity).is_none());
            match (found, how) {
                (None, Extend::Add | Extend::Toggle) => {}
                (found, how) => select(world, found.as_slice(), how),
            }
        }
        Command::FrameSelection => view::frame_selection(world)?,
        Command::FrameAll => view::frame_all(world)?,
        Command::MoveView(pose) => view::move_view(world, pose),
        Command::LookThrough(entity) => view::look_through(world, entity),
        Command::LookAlong(axis) => view::look_along(world, axis),
        Command::StoreView(number) => view::store(world, number),
        Command::RecallView(number) => view::recall(world, number)?,
        Command::SetSpeed(speed) => world.resource_mut::<EditorState>().navigation.set_speed(speed),

        Command::SetPaused(paused) => control(world, |control| control.paused = paused),
        Command::Restart => control(world, |control| control.restart_requested = true),
        Command::SetTargetSamples(samples) => control(world, |control| control.target_samples = Some(samples.max(1))),
        Command::SetTimeLimit(limit) => control(world, |control| control.time_limit = limit),
        Command::SetNoiseTarget(target) => control(world, |control| control.noise_target = target),
        Command::SetRegion(region) => {
            let region = region.map(|region| Rect::from_corners(region.min, region.max));
            control(world, |control| control.region = region);
        }
        Command::SetStrategySplit(split) => control(world, |control| control.strategy_split = split),
        Command::SetLightLayers(kept) => {
            control(world, |control| control.light_layers = kept);
            let display = world.resource::<EditorState>().display;
            if !kept && matches!(display.mode, DisplayMode::LightGroup(_)) {
                let mode = DisplayMode::Shaded;
                view::set_display(world, DisplaySettings { mode, ..display });
            }
        }
        Command::SetLightMix(mix) => set_resource(world, mix),
        Command::ExposeAutomatically => finished::expose(world)?,
        Command::TakeSnapshot => finished::take_snapshot(world)?,
        Command::SetCompareView(view) => world.resource_mut::<Comparison>().view = view,
        Command::Measure => finished::measure(world)?,
        Command::SetResolutionScale(scale) => {
            control(world, |control| control.resolution_scale = scale.clamp(0.05, 1.0));
        }
        Command::SetDisplay(display) => view::set_display(world, display),
        Command::SetOverlay(overlay) => world.resource_mut::<EditorState>().overlay = overlay,
        Command::SetTool(tool) => {
            let before = std::mem::replace(&mut world.resource_mut::<EditorState>().tool, tool);
            if before == Tool::Paths && tool == Tool::Select {
                world.resource_mut::<PathInspector>().wanted = None;
            }
        }
        Command::ShowSafeFrame(shown) => world.resource_mut::<EditorState>().safe_frame = shown,
        Command::InspectPaths(wanted) => world.resource_mut::<PathInspector>().wanted = wanted,
        Command::SetGizmo(settings) => world.resource_mut::<EditorState>().gizmo = settings,
        Command::Denoise => {
            let wake_up = world.resource::<WakeUp>().clone();
            let threads = world.resource::<RenderControl>().threads;
            world.resource_scope(|world, mut denoiser: Mut<Denoiser>| {
                let (film, mix) = (world.resource::<RenderFilm>(), world.resource::<LightMix>());
                denoiser.start(film, mix, threads, wake_up);
            });
        }
        Command::DropDenoised => world.resource_mut::<Denoiser>().clear(),
        Command::ShowPanels(shown) => world.resource_mut::<EditorState>().panels_shown = shown,
        Command::Shell(command) => shell::apply(world, command),
        // The others are edits.
        _ => {}
    }
    Ok(())
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

fn select(world: &mut World, entities: &[Entity], how: Extend) {
    world.resource_mut::<Selection>().extend(entities.iter().copied(), how);
    if !entities.is_empty() {
        world.resource_mut::<EditorState>().wanted_panel = Some(Panel::Inspector);
    }
}

/// The selection and the camera in use are of the scene.
fn keep_what_is_there(world: &mut World) {
    let is_there = ObjectState::is_in_scene;
    let selection = world.resource::<Selection>().clone();
    if selection.entities().iter().any(|entity| !is_there(world, *entity)) {
        let mut kept = selection;
        kept.retain(|entity| is_there(world, *entity));
        world.insert_resource(kept);
    }
    let active = world.resource::<ActiveSensor>().0;
    if active.is_none_or(|sensor| world.get::<Sensor>(sensor).is_none()) {
        let mut sensors = world.query_filtered::<(&DocumentOrder, Entity), With<Sensor>>();
        let first = sensors.iter(world).min().map(|(_, entity)| entity);
        if first != active {
            view::look_through_first(world, first);
        }
    }
}

/// Names and describes edits.
impl Edit<'_> {
    /// "Move ball", "Move 3 things", "Delete".
    fn titled(&self, label: &str, targets: &[Entity]) -> String {
        match targets {
            [] => label.to_owned(),
            [only] => match self.world.get::<Name>(*only) {
                Some(name) => format!("{label}: {name}"),
                None => label.to_owned(),
            },
            several => format!("{label}: {} things", several.len()),
        }
    }
}

#[cfg(test)]
mod tests {
    use std::path::{Path, PathBuf};

    use bevy::math::Affine3A;

    use super::*;
    use crate::app::editor::command::{Addition, AdditionKind};
    use crate::color::Rgb;
    use crate::engine::ViewMode;
    use crate::scene::{AreaLight, FreeView, Material, Parameter, SquarePath, ToWorld, UsesMaterial};

    fn world() -> World {
        let mut world = World::new();
        world.init_resource::<EditorState>();
        world.init_resource::<CommandQueue>();
        world.init_resource::<RenderControl>();
        world.init_resource::<ActiveSensor>();
        world.init_resource::<FrameTimes>();
        world.init_resource::<Pacing>();
        world.init_resource::<Selection>();
        world.init_resource::<History>();
        world.init_resource::<FreeView>();
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
        say(
            &mut world,
            Command::UseMaterial {
                shapes: vec![shape],
                material: None,
            },
        );
        assert!(world.get::<UsesMaterial>(shape).is_none());
    }

    #[test]
    fn a_picture_goes_to_whatever_has_one() {
        let mut world = world();
        let lamp = world.spawn((Shape::default(), AreaLight::default())).id();
        let sky = world.spawn(Emitter::of_plugin("envmap").expect("a plugin")).id();
        for owner in [lamp, sky] {
            let path = PathBuf::from("/pictures/sky.exr");
            let parameter = "filename";
            let place = SquarePath::WHOLE;
            let command = Command::SetPicture {
                owner,
                parameter,
                place,
                path,
            };
            say(&mut world, command);
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
        say(&mut world, Command::MoveView(Affine3A::IDENTITY));
        say(&mut world, Command::LookThrough(gone));
        assert!(world.query::<&Emitter>().iter(&world).next().is_none());
    }

    fn add(world: &mut World, kind: AdditionKind) -> Entity {
        say(world, Command::Add(kind.into()));
        world
            .resource::<Selection>()
            .active()
            .expect("what was added is selected")
    }

    #[test]
    fn a_drag_is_one_step_and_comes_back() {
        let mut world = world();
        let ball = add(&mut world, AdditionKind::Sphere);
        let before = ObjectState::of(&world, ball);
        for x in 1..5 {
            let pose = Affine3A::from_translation(Vec3::X * x as f32);
            say(&mut world, Command::Transform(vec![(ball, pose)]));
        }
        assert_eq!(world.resource::<History>().len(), (2, 0));
        say(&mut world, Command::Undo);
        assert_eq!(ObjectState::of(&world, ball), before);
        say(&mut world, Command::Redo);
        let pose = world.get::<ToWorld>(ball).map(|pose| pose.0.translation.x);
        assert_eq!(pose, Some(4.0));
        world.resource_mut::<EditorState>().interaction += 1;
        say(&mut world, Command::Transform(vec![(ball, Affine3A::IDENTITY)]));
        assert_eq!(world.resource::<History>().len(), (3, 0));
        say(&mut world, Command::GoTo(0));
        assert!(!ObjectState::of(&world, ball).is_there());
        assert!(world.resource::<Selection>().is_empty());
    }

    #[test]
    fn a_deleted_material_comes_back_to_its_shapes() {
        let mut world = world();
        let ball = add(&mut world, AdditionKind::Sphere);
        say(&mut world, Command::GiveMaterial { shape: ball });
        let material = world.get::<UsesMaterial>(ball).map(|uses| uses.0).expect("a material");
        say(&mut world, Command::Select(vec![material], Extend::Replace));
        say(&mut world, Command::Delete);
        assert!(world.get::<UsesMaterial>(ball).is_none() && world.get::<Material>(material).is_none());
        say(&mut world, Command::Undo);
        assert_eq!(world.get::<UsesMaterial>(ball).map(|uses| uses.0), Some(material));
        assert!(world.get::<Material>(material).is_some());
    }

    #[test]
    fn what_fails_leaves_nothing_behind() {
        let mut world = world();
        let ball = add(&mut world, AdditionKind::Sphere);
        let before = (ObjectState::of(&world, ball), world.resource::<History>().len());
        let failed = apply(
            &mut world,
            Command::Paste("<shape type=\"sphere\"><float name=\"radius\"/></shape>".into()),
        );
        assert!(failed.is_err_and(|message| message.contains("clipboard.xml:1:")));
        assert!(apply(&mut world, Command::Rename(ball, "a.b".into())).is_err());
        assert_eq!(
            (ObjectState::of(&world, ball), world.resource::<History>().len()),
            before
        );
    }

    #[test]
    fn what_is_copied_can_be_pasted() {
        let mut world = world();
        let ball = add(&mut world, AdditionKind::Sphere);
        say(&mut world, Command::GiveMaterial { shape: ball });
        say(&mut world, Command::Copy);
        let text = world.resource_mut::<EditorState>().clipboard.take().expect("a text");
        say(&mut world, Command::Paste(text));
        let copy = world.resource::<Selection>().active().expect("the copy");
        assert_ne!(copy, ball);
        assert_eq!(world.get::<Name>(copy).map(Name::as_str), Some("sphere-2"));
        assert!(
            world
                .get::<UsesMaterial>(copy)
                .is_some_and(|uses| world.get::<UsesMaterial>(ball) != Some(uses))
        );
        assert_eq!(world.get::<Shape>(copy), world.get::<Shape>(ball));
    }

    #[test]
    fn new_things_have_names_of_their_own_and_go_where_they_are_told() {
        let mut world = world();
        add(&mut world, AdditionKind::Cube);
        let light = Addition {
            at: Some(Vec3::Y * 3.0),
            ..AdditionKind::AreaLight.into()
        };
        say(&mut world, Command::Add(light));
        let second = add(&mut world, AdditionKind::Cube);
        assert_eq!(world.get::<Name>(second).map(Name::as_str), Some("cube-2"));
        let mut lights = world.query::<(&AreaLight, &ToWorld)>();
        let places: Vec<Vec3> = lights
            .iter(&world)
            .map(|(_, pose)| pose.0.transform_vector3(Vec3::Z))
            .collect();
        assert!(matches!(places[..], [down] if down.y < 0.0), "{places:?}");
        assert!(apply(&mut world, Command::Add(AdditionKind::Emitter("envmap").into())).is_err());
    }

    #[test]
    fn groups_are_names_in_a_folder() {
        let mut world = world();
        let [a, b] = [add(&mut world, AdditionKind::Cube), add(&mut world, AdditionKind::Disk)];
        say(&mut world, Command::Select(vec![a, b], Extend::Replace));
        say(&mut world, Command::Group);
        let name = |entity| world.get::<Name>(entity).map(|name| name.as_str().to_owned());
        assert_eq!(
            (name(a), name(b)),
            (Some("group/cube".into()), Some("group/disk".into()))
        );
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
