//! Measures how quickly the window responds: frame times, and the time from a command to the first changed pixels in the texture.

use std::io::Write;
use std::time::{Duration, Instant};

use bevy::math::{Affine3A, Vec3};
use bevy::prelude::*;

use super::script::assign;
use crate::app::editor::camera::pose::view_pose;
use crate::app::editor::command::Command;
use crate::app::editor::picture::frame_times::{Frame, FrameTimes, median};
use crate::app::editor::picture::resolution::PicturePlace;
use crate::app::editor::picture::texture::Picture;
use crate::app::editor::session::history::History;
use crate::app::editor::session::requests::CommandQueue;
use crate::app::editor::session::view_settings::ViewSettings;
use crate::engine::{RenderFilm, RenderState, RenderStatus};
use crate::scene::{AreaLight, Emitter, Material, MeshHandle, Shape, ShapeKind, ToWorld, TriangleMesh, UsesMaterial};

/// The measurement that the command line asks for: this many edits of each kind, one after the other.
#[derive(Resource)]
pub struct LatencyProbe {
    /// Edits of each kind.
    count: usize,
    phase: Phase,
    kind: usize,
    results: Vec<f32>,
    frames: Vec<Frame>,
    /// The other value is next.
    skipped: bool,
    pub done: bool,
}

#[derive(Clone, Copy, PartialEq)]
enum Phase {
    /// Lets the picture run so that the edit interrupts real work.
    Rest(Instant),
    Waiting {
        since: Instant,
        job: u64,
        revision: u64,
    },
}

/// The longest wait for an edit to show. After it the edit is taken to have changed nothing.
const PATIENCE: Duration = Duration::from_secs(5);

/// The rest between two edits that are independent.
const REST: Duration = Duration::from_millis(400);

enum Act {
    /// The command that performs the measured act for the given time; None if the scene has nothing to apply it to.
    Command(fn(&mut World, usize) -> Option<Command>),
    /// Reads the file of the largest mesh again, as if it had changed: a new mesh and a new acceleration structure.
    ReadMesh,
}

/// The kinds of edits that are measured, with the rest before each: without a rest the picture counts as moving, see
/// [`crate::app::editor::picture::motion`].
const KINDS: [(&str, Act, Duration); 8] = [
    ("fly", Act::Command(fly), REST),
    ("fly on and on", Act::Command(fly), Duration::ZERO),
    ("drag a mesh", Act::Command(drag), REST),
    ("drag it on and on", Act::Command(drag), Duration::ZERO),
    ("material slider", Act::Command(change_material), REST),
    ("light slider", Act::Command(change_light), REST),
    ("undo and redo", Act::Command(undo), REST),
    ("read a mesh again", Act::ReadMesh, REST),
];

impl Act {
    /// Does it; false where there is nothing to do it to.
    fn begin(&self, world: &mut World, time: usize) -> bool {
        match self {
            Self::Command(command) => {
                let command = command(world, time);
                let is_possible = command.is_some();
                world.resource_mut::<CommandQueue>().0.extend(command);
                is_possible
            }
            Self::ReadMesh => read_mesh(world).is_some(),
        }
    }
}

impl LatencyProbe {
    pub fn new(count: u32) -> Self {
        Self {
            count: count as usize,
            phase: Phase::Rest(Instant::now()),
            kind: 0,
            results: Vec::new(),
            frames: Vec::new(),
            skipped: false,
            done: count == 0,
        }
    }

    fn next_kind(&mut self) {
        self.results.clear();
        self.frames.clear();
        self.kind += 1;
        self.done = self.kind >= KINDS.len();
    }
}

/// Says the next command, as a panel would.
pub fn act_for_probe(world: &mut World) {
    let Some(mut probe) = world.remove_resource::<LatencyProbe>() else {
        return;
    };
    let status = world.resource::<RenderStatus>();
    let has_picture = matches!(status.state, RenderState::Rendering | RenderState::Done) && status.samples > 0;
    if let Phase::Rest(since) = probe.phase
        && has_picture
        && world.resource::<PicturePlace>().is_settled()
        && !probe.done
        && since.elapsed() >= KINDS[probe.kind].2
    {
        let (name, act, _) = &KINDS[probe.kind];
        if act.begin(world, probe.results.len() + usize::from(probe.skipped)) {
            probe.phase = Phase::Waiting {
                since: Instant::now(),
                job: world.resource::<RenderFilm>().job,
                revision: world.resource::<Picture>().revision,
            };
        } else {
            say(format_args!("{name}: the scene has nothing for it"));
            probe.next_kind();
        }
    }
    world.insert_resource(probe);
}

/// Stops the clock when the new picture's first pixels are in the texture.
pub fn watch_probe(
    mut probe: ResMut<LatencyProbe>,
    film: Res<RenderFilm>,
    picture: Res<Picture>,
    frames: Res<FrameTimes>,
    status: Res<RenderStatus>,
) {
    probe.frames.push(frames.last_frame());
    let Phase::Waiting { since, job, revision } = probe.phase else {
        return;
    };
    if since.elapsed() > PATIENCE {
        // The value was there already: nothing has changed.
        probe.phase = Phase::Rest(Instant::now());
        probe.skipped = !probe.skipped;
        return;
    }
    if film.job == job || picture.revision == revision {
        return;
    }
    probe.results.push(1e3 * since.elapsed().as_secs_f32());
    probe.phase = Phase::Rest(Instant::now());
    if probe.results.len() < probe.count {
        return;
    }
    let of = |values: &[f32], q| median(values.to_vec(), q).unwrap_or(f32::NAN);
    say(format_args!(
        "{}: command to first changed pixel: median {:.1} ms, 95 % {:.1} ms, worst {:.1} ms, {} times, {}x{} pixels",
        KINDS[probe.kind].0,
        of(&probe.results, 0.5),
        of(&probe.results, 0.95),
        of(&probe.results, 1.0),
        probe.results.len(),
        status.size.x,
        status.size.y,
    ));
    let figures = |name: &str, part: fn(&Frame) -> Option<f32>| {
        let times: Vec<f32> = probe.frames.iter().filter_map(part).collect();
        let [median, most, worst] = [0.5, 0.95, 1.0].map(|q| of(&times, q));
        say(format_args!(
            "  {name}: median {median:.1} ms, 95 % {most:.1} ms, worst {worst:.1} ms"
        ));
    };
    figures("frames from one to the next", |frame| frame.whole);
    figures("  of that the window's own systems", |frame| Some(frame.own));
    figures("  beside them the drawing thread and the driver", |frame| {
        Some(frame.drawing)
    });
    probe.next_kind();
}

/// Prints a line. A closed pipe is no reason to fail.
fn say(line: std::fmt::Arguments) {
    let _ = writeln!(std::io::stdout(), "{line}");
}

/// The sign, -1 and 1 in turn, so that the scene stays about what it was.
fn sign(time: usize) -> f32 {
    if time.is_multiple_of(2) { 1.0 } else { -1.0 }
}

fn fly(world: &mut World, time: usize) -> Option<Command> {
    let pose = view_pose(world)?;
    let turned = Affine3A {
        matrix3: pose.matrix3 * bevy::math::Mat3A::from_axis_angle(Vec3::Y, 0.01 * sign(time)),
        translation: pose.translation,
    };
    Some(Command::MoveView(turned))
}

/// The mesh of the most triangles, by a hundredth of the scene.
fn drag(world: &mut World, time: usize) -> Option<Command> {
    let (entity, pose) = largest_mesh(world)?;
    let by = 0.01 * world.resource::<ViewSettings>().navigation.scene_size * sign(time);
    Some(Command::Transform(vec![(
        entity,
        Affine3A::from_translation(Vec3::X * by) * pose,
    )]))
}

fn read_mesh(world: &mut World) -> Option<()> {
    let (entity, _) = largest_mesh(world)?;
    let path = world.get::<MeshHandle>(entity)?.0.path()?.clone();
    world.resource::<AssetServer>().reload(path);
    Some(())
}

fn largest_mesh(world: &mut World) -> Option<(Entity, Affine3A)> {
    let mut shapes = world.query::<(Entity, &ToWorld, &Shape, Option<&MeshHandle>)>();
    let meshes = world.get_resource::<Assets<TriangleMesh>>();
    let triangles = |shape: &Shape, handle: Option<&MeshHandle>| {
        let ShapeKind::Mesh(file) = &shape.kind else {
            return None;
        };
        let data = meshes?.get(&handle?.0)?.data(file.shape_index)?;
        Some(data.triangles.len())
    };
    let largest = shapes
        .iter(world)
        .max_by_key(|(_, _, shape, handle)| triangles(shape, *handle));
    largest.map(|(entity, pose, ..)| (entity, pose.0))
}

/// Changes the first colour that can be set in the material of that mesh, or in any material.
fn change_material(world: &mut World, time: usize) -> Option<Command> {
    let of_mesh = largest_mesh(world).and_then(|(entity, _)| world.get::<UsesMaterial>(entity).map(|uses| uses.0));
    let mut all: Vec<Entity> = of_mesh.into_iter().collect();
    all.extend(world.query_filtered::<Entity, With<Material>>().iter(world));
    let color = format!("{}", 0.5 + 0.1 * sign(time));
    all.into_iter().find_map(|entity| {
        let mut material = world.get::<Material>(entity)?.clone();
        let names = [
            "reflectance",
            "base_color",
            "diffuse_reflectance",
            "specular_reflectance",
        ];
        names
            .iter()
            .find(|name| assign::material(&mut material, name, &color).is_ok())?;
        Some(Command::SetMaterial(entity, Box::new(material)))
    })
}

fn change_light(world: &mut World, time: usize) -> Option<Command> {
    let color = format!("{}", 5.0 + sign(time));
    let mut lights = world.query::<(Entity, &AreaLight)>();
    if let Some((entity, light)) = lights.iter(world).next() {
        let mut light = light.clone();
        assign::area_light(&mut light, "radiance", &color).ok()?;
        return Some(Command::SetAreaLight(entity, Some(light)));
    }
    let mut emitters = world.query::<(Entity, &Emitter)>();
    emitters.iter(world).find_map(|(entity, emitter)| {
        let mut emitter = emitter.clone();
        let names = ["radiance", "intensity", "irradiance", "scale"];
        names
            .iter()
            .find(|name| assign::emitter(&mut emitter, name, &color).is_ok())?;
        Some(Command::SetEmitter(entity, emitter))
    })
}

/// Undoes the edits that are left in the history.
fn undo(world: &mut World, time: usize) -> Option<Command> {
    if world.resource::<History>().len() == (0, 0) {
        return None;
    }
    Some(if time.is_multiple_of(2) {
        Command::Undo
    } else {
        Command::Redo
    })
}
