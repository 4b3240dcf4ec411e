//! Chooses the monkey's next acts at random among the acts of a user.

use bevy::prelude::*;

use super::act::{Act, OwnFile};
use super::edits::{names, random_edit};
use super::folder::{Folder, Writing};
use super::random::Random;
use super::tampering;
use crate::app::editor::command::Command;
use crate::app::editor::command::display::DisplayMode;
use crate::app::editor::command::panel::Panel;
use crate::app::editor::command::resolution::Resolution;
use crate::app::editor::command::shell::{Sheet, ShellCommand};
use crate::app::editor::session::history::History;
use crate::render::tonemap::ToneMap;
use crate::scene::{AreaLight, Emitter, Material, Medium, SceneStatus, Sensor, Shape};

/// Kinds of acts with their shares in percent.
const KINDS: [(&str, usize); 12] = [
    ("edit", 36),
    ("undo or redo", 22),
    ("camera", 13),
    ("display", 6),
    ("rendering", 5),
    ("selection", 5),
    ("import", 3),
    ("window", 3),
    ("files of the scene", 2),
    ("scene's file", 2),
    ("saving", 2),
    ("rest", 1),
];

/// The kind's name, and acts for as many frames. The list is empty if the scene has nothing that the chosen act applies
/// to.
pub fn next_acts(world: &mut World, random: &mut Random, folder: &Folder, own: OwnFile) -> (&'static str, Vec<Act>) {
    let total: usize = KINDS.iter().map(|(_, share)| share).sum();
    let mut ticket = random.below(total);
    let mut kinds = KINDS.iter();
    let kind = loop {
        match kinds.next() {
            Some((kind, share)) if ticket < *share => break *kind,
            Some((_, share)) => ticket -= share,
            None => break "rest",
        }
    };
    let acts = match kind {
        "scene's file" | "saving" if own == OwnFile::Untouched => Vec::new(),
        "edit" => edit(world, random, folder),
        "undo or redo" => undo_or_redo(world, random),
        "camera" => camera(world, random),
        "display" => display(random),
        "rendering" => rendering(world, random),
        "selection" => selection(world, random),
        "import" => import(random, folder),
        "window" => window(random),
        "files of the scene" => {
            let (path, content) = folder.changed_import(random);
            vec![Act::Write {
                path,
                content,
                how: Writing::ALL[random.below(3)],
                awaited: false,
            }]
        }
        "scene's file" => tampering::acts(world, random, own),
        "saving" => saving(world, random, folder),
        _ => vec![Act::Rest(1 + random.below(20))],
    };
    (kind, after_packing(acts))
}

/// The commands that use the scene as the engine has packed it last (places of things, the picture), which may be older
/// than the last edit.
const FROM_PACKED: [&str; 9] = [
    "align ",
    "bake-lights",
    "camera-to-view",
    "distribute ",
    "frame-",
    "pick ",
    "switch-projection",
    "use-file ",
    "view-",
];

/// Delays such acts until the engine has packed all edits, so that a run can be repeated.
fn after_packing(acts: Vec<Act>) -> Vec<Act> {
    let depends = |line: &String| FROM_PACKED.iter().any(|start| line.starts_with(start));
    let depends = |act: &Act| matches!(act, Act::Say(lines) if lines.iter().any(depends));
    match acts.iter().any(depends) {
        true => [vec![Act::AwaitPicture], acts].concat(),
        false => acts,
    }
}

fn say(line: impl Into<String>) -> Vec<Act> {
    vec![Act::Say(vec![line.into()])]
}

fn edit(world: &mut World, random: &mut Random, folder: &Folder) -> Vec<Act> {
    let shapes = names::<With<Shape>>(world);
    match random.below(10) {
        // A drag: many frames that are one step of the history.
        0 => {
            let Some(shape) = random.one_of(&shapes) else {
                return Vec::new();
            };
            let step = format!("move {shape} 0.0{},0.01,0", random.below(10));
            (0..2 + random.below(20)).flat_map(|_| say(step.clone())).collect()
        }
        1 => {
            let Some(shape) = random.one_of(&shapes) else {
                return Vec::new();
            };
            let value = 0.1 + random.fraction();
            let lines = [
                format!("scale {shape} {value}"),
                format!("set {shape} reflectance {value},0.5,0.1"),
                format!("set {shape} radius {value}"),
                format!("set {shape} radiance {value}"),
            ];
            say(lines[random.below(lines.len())].clone())
        }
        _ => random_edit(world, random, &folder.part()).map_or(Vec::new(), |lines| vec![Act::Say(lines)]),
    }
}

fn undo_or_redo(world: &World, random: &mut Random) -> Vec<Act> {
    let (done, undone) = world.resource::<History>().len();
    let kind = random.below(12);
    // Several in a row, as with a held key.
    let rows = match kind {
        0 => return say(format!("go-to {}", random.below(done + undone + 1))),
        1 | 2 => 1 + random.below(30),
        _ => 1,
    };
    let (line, possible) = match (done, undone, kind % 2) {
        // This also happens now and then when the history is empty.
        (0, 0, _) => ("undo", 1),
        (0, ..) => ("redo", undone),
        (_, 0, _) | (.., 0) => ("undo", done),
        _ => ("redo", undone),
    };
    (0..rows.min(possible)).flat_map(|_| say(line)).collect()
}

fn camera(world: &mut World, random: &mut Random) -> Vec<Act> {
    match random.below(8) {
        0..3 => {
            // A flight of some frames.
            let from = [(); 3].map(|()| random.number());
            let at = random.vector();
            let frames = 1 + random.below(20);
            let place = |frame: usize| format!("{},{},{}", from[0] + 0.05 * frame as f32, from[1], from[2]);
            (0..frames)
                .flat_map(|frame| say(format!("look {} {at}", place(frame))))
                .collect()
        }
        3 => say(["frame-all", "frame-selection", "switch-projection", "walk"][random.below(4)]),
        4 => say(format!(
            "view-{}",
            ["front", "back", "left", "right", "top", "bottom"][random.below(6)]
        )),
        5 => say(format!(
            "{}-{}",
            ["view", "store-view"][random.below(2)],
            1 + random.below(9)
        )),
        6 => say("camera-to-view"),
        _ => {
            let cameras = names::<With<Sensor>>(world);
            random
                .one_of(&cameras)
                .map_or(Vec::new(), |camera| say(format!("look-through {camera}")))
        }
    }
}

fn display(random: &mut Random) -> Vec<Act> {
    match random.below(12) {
        0 | 1 => {
            let (_, mode) = DisplayMode::ALL[random.below(DisplayMode::ALL.len())];
            say(format!("show {}", mode.replace(' ', "-").to_lowercase()))
        }
        2 => say(format!("exposure {}", random.number() * 0.5)),
        3 => {
            let maps: Vec<ToneMap> = ToneMap::ALL.into_iter().collect();
            let map = random.one_of(&maps);
            map.map_or(Vec::new(), |map| say(format!("tone-map {}", map.name())))
        }
        4 => say(format!("white {}", 3000 + random.below(6000))),
        5 => say("take-snapshot"),
        6 => match random.below(3) {
            0 => say("compare off"),
            1 => say(format!("compare wipe {}", random.fraction())),
            _ => say("compare difference"),
        },
        7 => say(["see-into-rooms", "cut-open", "isolate", "wireframe"][random.below(4)]),
        8 => say(format!(
            "cut-plane {} {}",
            ["x", "-y", "z"][random.below(3)],
            random.number()
        )),
        9 => say(["grid", "dimensions", "clear-rulers"][random.below(3)]),
        10 => say(format!("measure-between {} {}", random.vector(), random.vector())),
        _ => say(["expose-automatically", "boxes", "safe-frame", "measure", "four-views"][random.below(5)]),
    }
}

fn rendering(world: &mut World, random: &mut Random) -> Vec<Act> {
    match random.below(11) {
        0 => say(format!("samples {}", 1 + random.below(64))),
        1 => say([
            "limit-noise none",
            "limit-noise 0.1",
            "adaptive on",
            "adaptive off",
            "keep-limits",
        ][random.below(5)]),
        2 => match random.below(2) {
            0 => say("region none"),
            _ => {
                let [a, b, c, d] = [(); 4].map(|()| random.fraction());
                say(format!("region {a},{b} {c},{d}"))
            }
        },
        3 => say(format!("split-strategies {}", ["on", "off"][random.below(2)])),
        4 => say(format!("keep-lights-apart {}", ["on", "off"][random.below(2)])),
        5 => {
            let mut lights = names::<With<Emitter>>(world);
            lights.extend(names::<With<AreaLight>>(world));
            let light = random.one_of(&lights).cloned();
            light.map_or(Vec::new(), |light| say(format!("mix {light} {}", random.fraction())))
        }
        6 => {
            let cameras = names::<With<Sensor>>(world);
            let camera = random.one_of(&cameras).cloned();
            camera.map_or(Vec::new(), |camera| {
                let side = ["width", "height"][random.below(2)];
                say(format!("set {camera} {side} {}", 16 + random.below(400)))
            })
        }
        7 => say("denoise"),
        8 => say(format!(
            "resolution {}",
            Resolution::ALL[random.below(Resolution::ALL.len())].name()
        )),
        9 => say(["render-full", "stop-full", "enlarge sharp", "enlarge smooth"][random.below(4)]),
        _ => say("restart"),
    }
}

fn selection(world: &mut World, random: &mut Random) -> Vec<Act> {
    let mut all = names::<With<Shape>>(world);
    all.extend(names::<With<Material>>(world));
    all.extend(names::<With<Medium>>(world));
    all.extend(names::<With<Emitter>>(world));
    all.extend(names::<With<Sensor>>(world));
    let Some(name) = random.one_of(&all).cloned() else {
        return Vec::new();
    };
    let select = format!("select {name}");
    match random.below(6) {
        0 => say("select-all"),
        1 => vec![Act::Say(vec![select, "copy".to_owned()])],
        2 => vec![Act::Say(vec![select, "nudge-left".to_owned()])],
        3 => vec![Act::Say(vec![select, "frame-selection".to_owned()])],
        // A click may hit another thing while the picture is coarse, and later acts must not depend on it.
        4 => vec![Act::Say(vec![
            format!("pick {},{}", random.fraction(), random.fraction()),
            select,
        ])],
        _ => say(select),
    }
}

fn import(random: &mut Random, folder: &Folder) -> Vec<Act> {
    match random.below(4) {
        0 => say(format!(
            "paste <shape type=\"rectangle\" id=\"poster\"><bsdf type=\"diffuse\"><texture type=\"bitmap\" name=\"reflectance\">\
             <string name=\"filename\" value=\"{}\"/></texture></bsdf></shape>",
            folder.picture().display()
        )),
        1 => {
            let [x, y] = [(); 2].map(|()| random.fraction());
            let file = folder.any_import(random);
            say(format!("use-file {} {x},{y}", file.display()))
        }
        _ => say(format!("import-file {}", folder.any_import(random).display())),
    }
}

fn window(random: &mut Random) -> Vec<Act> {
    let shell = |command| vec![Act::Do(Command::Shell(command))];
    match random.below(6) {
        0 => shell(ShellCommand::ShowPanel(
            Panel::CLOSEABLE[random.below(Panel::CLOSEABLE.len())],
        )),
        1 => shell(ShellCommand::ClosePanel(
            Panel::CLOSEABLE[random.below(Panel::CLOSEABLE.len())],
        )),
        2 => shell(ShellCommand::ResetLayout),
        3 => {
            const SHEETS: [Sheet; 9] = [
                Sheet::Palette,
                Sheet::Shortcuts,
                Sheet::Preferences,
                Sheet::Keys,
                Sheet::Series,
                Sheet::Projection,
                Sheet::Bake,
                Sheet::Missing,
                Sheet::Start,
            ];
            let sheet = SHEETS[random.below(SHEETS.len())];
            let mut acts = shell(ShellCommand::ShowSheet(sheet));
            acts.extend([Act::Rest(1 + random.below(5)), Act::CloseSheet]);
            acts
        }
        4 => vec![Act::Do(ShellCommand::ShowPanels(random.below(4) > 0).into())],
        _ => vec![Act::Resize(Vec2::new(
            0.5 + 0.7 * random.fraction(),
            0.5 + 0.7 * random.fraction(),
        ))],
    }
}

fn saving(world: &World, random: &mut Random, folder: &Folder) -> Vec<Act> {
    let own = world.resource::<SceneStatus>().path.clone();
    match (random.below(3), own) {
        (0, _) => say(format!("save-image-to {}", folder.image(random).display())),
        (1, _) => say("reload"),
        (_, Some(own)) => say(format!("save-to {}", own.display())),
        (_, None) => Vec::new(),
    }
}
