//! The timeline and the marks of values that move.

use std::collections::HashMap;
use std::sync::Arc;

use bevy::prelude::Entity;
use bevy_egui::egui::{self, pos2};
use egui_kittest::Harness;
use egui_kittest::kittest::Queryable;
use sunroom::app::editor::command::key_bindings::NO_BINDINGS;
use sunroom::app::editor::command::timeline::{TimeStep, Timeline};
use sunroom::app::editor::command::{Command, EditCommand, TimeCommand, TimeEdit};
use sunroom::app::editor::model::timeline::{Tick, TickTime, Ticks, TimelineModel, values_of};
use sunroom::app::editor::panels::timeline::{TimelineState, timeline};
use sunroom::document::{Interpolation, Key, Track, Value};
use sunroom::scene::{KeyEdit, KeyPath};

struct Shown {
    model: TimelineModel,
    state: TimelineState,
    commands: Vec<Command>,
}

/// A ball with keys at 0 and 1 s, on a timeline of two seconds.
fn shown() -> Harness<'static, Shown> {
    let values = vec![(Entity::from_raw_u32(1).expect("an entity"), KeyPath::new("radius"))];
    let key = |time: f64| Key {
        time,
        value: Value::Float(1.0),
    };
    let track = Track {
        keys: vec![key(0.0), key(1.0)],
        interpolation: Interpolation::Linear,
    };
    let tick = |time| {
        let values = values.clone();
        (TickTime(time), Tick { values })
    };
    let selected: Ticks = [0.0, 1.0].into_iter().map(tick).collect();
    let model = TimelineModel {
        frames: Timeline {
            fps: 10.0,
            first: 0,
            last: 20,
        },
        all: Arc::new(vec![0.0, 1.0]),
        values: Arc::new(values_of(&selected)),
        selected: Arc::new(selected),
        tracks: Arc::new(HashMap::from([(
            values[0].0,
            vec![(KeyPath::new("radius"), Arc::new(track))],
        )])),
        ..TimelineModel::default()
    };
    let state = Shown {
        model,
        state: TimelineState::default(),
        commands: Vec::new(),
    };
    let show = |ui: &mut egui::Ui, shown: &mut Shown| {
        timeline(ui, &shown.model, &NO_BINDINGS, &mut shown.state, &mut shown.commands);
    };
    Harness::builder()
        .with_size(egui::vec2(1000.0, 160.0))
        .build_ui_state(show, state)
}

/// The heights of the ruler and of a track below it.
const RULER: f32 = 22.0;
const TRACK: f32 = 16.0;

/// The place of a time on the band, at this height above the foot of the first track.
fn at_height(harness: &Harness<Shown>, time: f32, height: f32) -> egui::Pos2 {
    let band = harness.get_by_label("Frames and keys").rect();
    let (left, right) = (band.left() + 12.0, band.right() - 12.0);
    pos2(left + (right - left) * time / 2.0, band.top() + RULER + TRACK - height)
}

/// The place of a time on the band, in the row of the keys.
fn at(harness: &Harness<Shown>, time: f32) -> egui::Pos2 {
    at_height(harness, time, 0.5 * TRACK)
}

fn drag(harness: &mut Harness<Shown>, from: egui::Pos2, to: egui::Pos2) {
    harness.drag_at(from);
    harness.run_steps(2);
    harness.hover_at(from.lerp(to, 0.5));
    harness.run_steps(2);
    harness.hover_at(to);
    harness.run_steps(2);
    harness.drop_at(to);
    harness.run_steps(2);
}

#[test]
fn the_time_is_dragged_from_frame_to_frame() {
    let mut harness = shown();
    harness.run_steps(2);
    let (from, to) = (at(&harness, 0.3), at(&harness, 0.72));
    drag(&mut harness, from, to);
    assert_eq!(harness.state().commands.last(), Some(&TimeCommand::SetTime(0.7).into()));
}

#[test]
fn a_key_is_dragged_to_another_time() {
    let mut harness = shown();
    harness.run_steps(2);
    let (from, to) = (at(&harness, 1.0), at(&harness, 1.5));
    drag(&mut harness, from, to);
    let [Command::Edit(EditCommand::Time(TimeEdit::Key(values, KeyEdit::Move { from, to })))] =
        &harness.state().commands[..]
    else {
        panic!("{:?}", harness.state().commands);
    };
    assert_eq!((values.len(), *from, *to), (1, 1.0, 1.5));
}

#[test]
fn the_time_is_dragged_away_from_a_key_and_the_key_from_the_time() {
    // The time that is shown is that of the key. Its handle at the top of the ruler, and the foot of the ruler.
    for height in [TRACK + RULER - 2.0, TRACK + 1.0] {
        let mut harness = shown();
        harness.state_mut().model.time = 1.0;
        harness.run_steps(2);
        let (from, to) = (at_height(&harness, 1.0, height), at(&harness, 1.5));
        drag(&mut harness, from, to);
        let commands = &harness.state().commands;
        assert_eq!(commands.last(), Some(&TimeCommand::SetTime(1.5).into()), "{height}");
        let is_time = |command: &Command| matches!(command, Command::Time(TimeCommand::SetTime(_)));
        assert!(commands.iter().all(is_time), "{height}: {commands:?}");
    }
    // The mark of the key, and the ends of the track above and below it.
    for height in [0.5 * TRACK, TRACK - 1.0, 2.0] {
        let mut harness = shown();
        harness.state_mut().model.time = 1.0;
        harness.run_steps(2);
        let (from, to) = (at_height(&harness, 1.0, height), at(&harness, 0.5));
        drag(&mut harness, from, to);
        let commands = &harness.state().commands;
        assert!(
            matches!(
                commands[..],
                [Command::Edit(EditCommand::Time(TimeEdit::Key(
                    _,
                    KeyEdit::Move { from: 1.0, to: 0.5 }
                )))]
            ),
            "{height}: {commands:?}"
        );
    }
}

#[test]
fn the_timeline_is_as_high_for_many_values_as_for_none() {
    let mut harness = shown();
    harness.run_steps(2);
    let mut heights = Vec::new();
    for names in [&[][..], &["radius"], &["a", "b", "c", "d"], &["a", "b", "c", "d", "e"]] {
        harness.state_mut().model.values = Arc::new(names.iter().map(|name| KeyPath::new(*name)).collect());
        harness.run_steps(2);
        heights.push(harness.get_by_label("Frames and keys").rect().height());
    }
    assert!(heights.iter().all(|height| *height == heights[0]), "{heights:?}");
}

#[test]
fn buttons_step_and_play() {
    let mut harness = shown();
    harness.run_steps(2);
    for name in ["⏭", "▶"] {
        harness.get_by_label(name).click();
        harness.run_steps(2);
    }
    let expected = [
        Command::from(TimeCommand::StepTime(TimeStep::LastFrame)),
        Command::from(TimeCommand::SetPlaying(true)),
    ];
    assert_eq!(harness.state().commands, expected);
}
