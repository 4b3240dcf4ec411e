//! The timeline below the picture: buttons and fields for the time, and a band: a ruler on which the time is dragged,
//! and a track of keys below it. Keys take no presses on the ruler, so that the time can be dragged away from a key.

use std::ops::RangeInclusive;

use bevy_egui::egui::emath::{Numeric, format_with_decimals_in_range};
use bevy_egui::egui::{
    self, Color32, CursorIcon, DragValue, Rect, Response, Sense, Shape, Stroke, Ui, Vec2, pos2, vec2,
};

use super::look;
use crate::app::editor::command::key_bindings::KeyBindings;
use crate::app::editor::command::timeline::{TimeStep, Timeline};
use crate::app::editor::command::{Command, TimeCommand, TimeEdit};
use crate::app::editor::input::actions;
use crate::app::editor::input::number_field::{self, Meaning};
use crate::app::editor::model::timeline::{TickTime, TimelineModel};
use crate::document::Interpolation;
use crate::scene::{KeyEdit, KeyPath};

/// Half the width in points of the time's marker, which must not hide the number of its line.
const HALF_MARKER: f32 = 5.0;
/// The heights in points of the ruler, on which the time is dragged, and of the track of the keys below it.
const RULER: f32 = 22.0;
const TRACK: f32 = 22.0;
/// The margins at both ends of the band.
const MARGIN: f32 = 12.0;
/// The half diagonal of a key's mark, and the distance within which the pointer hits it.
const MARK: f32 = 5.0;
/// The least distance between the numbers of two frames.
const NUMBERS: f32 = 56.0;

/// The state that the timeline keeps between frames.
#[derive(Clone, Copy, Debug, Default)]
pub struct TimelineState {
    /// The dragged key, and its present time in seconds.
    dragged: Option<(TickTime, f64)>,
    /// The key whose menu is open.
    menu: Option<TickTime>,
}

/// Shows the time, the range of frames, and the keys: those of the selection bright, others dim.
pub fn timeline(
    ui: &mut Ui,
    model: &TimelineModel,
    bound: &KeyBindings,
    state: &mut TimelineState,
    commands: &mut Vec<Command>,
) {
    ui.add_space(2.0);
    ui.horizontal(|ui| {
        buttons(ui, model, bound, commands);
        ui.separator();
        times(ui, model, commands);
        ui.separator();
        range(ui, &model.frames, commands);
        ui.with_layout(egui::Layout::right_to_left(egui::Align::Center), |ui| {
            let close = ui.button("×").on_hover_text("Hide the timeline");
            if close.clicked() {
                commands.push(TimeCommand::ShowTimeline(false).into());
            }
        });
    });
    band(ui, model, state, commands);
}

fn buttons(ui: &mut Ui, model: &TimelineModel, bound: &KeyBindings, commands: &mut Vec<Command>) {
    let mut button = |ui: &mut Ui, text: &str, hint: &str, name: &str, command: Command| {
        let hint = actions::hint(hint, name, bound);
        if ui.button(text).on_hover_text(hint).clicked() {
            commands.push(command);
        }
    };
    let step = |it| TimeCommand::StepTime(it).into();
    button(ui, "⏮", "First frame", "first-frame", step(TimeStep::FirstFrame));
    button(ui, "⏴ key", "Previous key", "previous-key", step(TimeStep::PreviousKey));
    button(
        ui,
        "⏴",
        "Previous frame",
        "previous-frame",
        step(TimeStep::PreviousFrame),
    );
    let (text, hint) = match model.is_playing {
        true => ("⏸", "Hold"),
        false => ("▶", "Play"),
    };
    button(
        ui,
        text,
        hint,
        "play",
        TimeCommand::SetPlaying(!model.is_playing).into(),
    );
    button(ui, "⏵", "Next frame", "next-frame", step(TimeStep::NextFrame));
    button(ui, "key ⏵", "Next key", "next-key", step(TimeStep::NextKey));
    button(ui, "⏭", "Last frame", "last-frame", step(TimeStep::LastFrame));
    ui.separator();
    let (set, remove) = (
        Command::from(TimeEdit::Key(Vec::new(), KeyEdit::Set)),
        Command::from(TimeEdit::Key(Vec::new(), KeyEdit::Remove)),
    );
    button(ui, "+ key", "Set a key of the place of the selection", "set-key", set);
    button(
        ui,
        "− key",
        "Remove the keys of the selection at this time",
        "remove-key",
        remove,
    );
}

/// Shows the present frame and time.
fn times(ui: &mut Ui, model: &TimelineModel, commands: &mut Vec<Command>) {
    let mut frame = model.frames.frame(model.time);
    // A whole number of frames has rounding errors in seconds.
    if (frame - frame.round()).abs() < 1e-4 {
        frame = frame.round();
    }
    let drag = DragValue::new(&mut frame).speed(0.2).max_decimals(2);
    if named(ui, "Frame", drag, ALL).changed() {
        commands.push(TimeCommand::SetTime(model.frames.time(frame)).into());
    }
    let mut time = model.time;
    let drag = DragValue::new(&mut time).speed(0.01).max_decimals(3).suffix(" s");
    if named(ui, "Time", drag, ALL).changed() {
        commands.push(TimeCommand::SetTime(time).into());
    }
}

/// Shows the range of frames.
fn range(ui: &mut Ui, frames: &Timeline, commands: &mut Vec<Command>) {
    let mut edited = *frames;
    let most = Timeline::MOST;
    named(ui, "From", DragValue::new(&mut edited.first), 0..=most);
    let first = edited.first;
    named(ui, "to", DragValue::new(&mut edited.last), first..=most);
    let fps = DragValue::new(&mut edited.fps).max_decimals(3);
    named(ui, "fps", fps, Timeline::FPS);
    if edited != *frames {
        commands.push(TimeCommand::SetTimeline(edited.within_range()).into());
    }
}

/// The range of a number of which every value is possible.
const ALL: RangeInclusive<f64> = f64::NEG_INFINITY..=f64::INFINITY;

fn named<N: Numeric>(ui: &mut Ui, name: &str, drag: DragValue, range: RangeInclusive<N>) -> Response {
    let label = ui.weak(name);
    let field = number_field::number(ui, drag, name, range, Meaning::Number, format_with_decimals_in_range);
    ui.add(field).labelled_by(label.id)
}

/// The map from times to positions on the band.
struct Scale {
    first: f64,
    last: f64,
    left: f32,
    width: f32,
}

impl Scale {
    /// The scale at which all frames and all keys fit.
    fn new(model: &TimelineModel, rect: Rect) -> Self {
        let frames = &model.frames;
        let mut times = vec![
            frames.time(frames.first.into()),
            frames.time(frames.last.into()),
            model.time,
        ];
        times.extend(model.all.first().into_iter().chain(model.all.last()));
        let first = times.iter().copied().fold(f64::INFINITY, f64::min);
        let last = times.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        Self {
            first,
            last: last.max(first + frames.time(1.0)),
            left: rect.left() + MARGIN,
            width: (rect.width() - 2.0 * MARGIN).max(1.0),
        }
    }

    fn place(&self, time: f64) -> f32 {
        self.left + ((time - self.first) / (self.last - self.first)) as f32 * self.width
    }

    fn time(&self, place: f32) -> f64 {
        let share = f64::from((place - self.left) / self.width).clamp(0.0, 1.0);
        self.first + share * (self.last - self.first)
    }
}

fn band(ui: &mut Ui, model: &TimelineModel, state: &mut TimelineState, commands: &mut Vec<Command>) {
    let size = vec2(ui.available_width(), RULER + TRACK);
    let (rect, response) = ui.allocate_exact_size(size, Sense::click_and_drag());
    response.widget_info(|| egui::WidgetInfo::labeled(egui::WidgetType::Other, true, "Frames and keys"));
    let scale = Scale::new(model, rect);
    let track = rect.with_min_y(rect.top() + RULER);
    let is_whole = !ui.input(|input| input.modifiers.command);
    let time_at = |place: f32| match is_whole {
        true => model.frames.snapped(scale.time(place)),
        false => scale.time(place),
    };
    let pointer = response.interact_pointer_pos();
    let key_at = |place: egui::Pos2| {
        let near = |time: &&TickTime| (scale.place(time.0) - place.x).abs() <= MARK && place.y >= track.top();
        model.selected.keys().find(near).copied()
    };
    if response.drag_started() {
        let origin = ui.input(|input| input.pointer.press_origin());
        state.dragged = origin.and_then(key_at).map(|key| (key, key.0));
    }
    if let (Some((key, _)), Some(place), true) = (state.dragged, pointer, response.dragged()) {
        state.dragged = Some((key, time_at(place.x)));
    } else if response.drag_stopped()
        && let Some((key, to)) = state.dragged.take()
    {
        if to != key.0
            && let Some(tick) = model.selected.get(&key)
        {
            commands.push(TimeEdit::Key(tick.values.clone(), KeyEdit::Move { from: key.0, to }).into());
        }
    } else if let Some(place) = pointer.filter(|_| response.dragged() || response.clicked()) {
        let key = key_at(place).filter(|_| response.clicked());
        let time = key.map_or_else(|| time_at(place.x), |key| model.frames.time_of_key(key.0));
        if time != model.time {
            commands.push(TimeCommand::SetTime(time).into());
        }
    }
    if response.secondary_clicked() {
        state.menu = pointer.and_then(key_at);
    }
    let hovered = response.hover_pos().and_then(key_at);
    let cursor = match state.dragged.map(|(key, _)| key).or(hovered) {
        _ if state.menu.is_some() => CursorIcon::Default,
        Some(_) if state.dragged.is_some() => CursorIcon::Grabbing,
        Some(_) => CursorIcon::Grab,
        None => CursorIcon::ResizeHorizontal,
    };
    let response = response.on_hover_and_drag_cursor(cursor);
    if let Some(key) = state.menu {
        let shown = response.context_menu(|ui| key_menu(ui, model, key, commands));
        if shown.is_none() {
            state.menu = None;
        }
    } else if let Some(tick) = hovered.and_then(|key| model.selected.get(&key)) {
        let mut names: Vec<&str> = tick.values.iter().map(|(_, path)| path.as_str()).collect();
        names.sort_unstable();
        names.dedup();
        response.clone().on_hover_text(names.join(", "));
    }
    paint(ui, model, &scale, rect, track, state);
}

fn key_menu(ui: &mut Ui, model: &TimelineModel, key: TickTime, commands: &mut Vec<Command>) {
    let Some(tick) = model.selected.get(&key) else {
        return ui.close();
    };
    if ui.button("Remove this key").clicked() {
        commands.push(TimeCommand::SetTime(model.frames.time_of_key(key.0)).into());
        commands.push(TimeEdit::Key(tick.values.clone(), KeyEdit::Remove).into());
        ui.close();
    }
    ui.separator();
    let track = |(thing, path): &(bevy::prelude::Entity, KeyPath)| {
        let tracks = model.tracks.get(thing)?;
        tracks
            .iter()
            .find(|(known, _)| known == path)
            .map(|(_, track)| track.clone())
    };
    let present = tick.values.first().and_then(track).map(|track| track.interpolation);
    for way in Interpolation::ALL {
        let text = match way {
            Interpolation::Linear => "Linear: at constant speed",
            Interpolation::Ease => "Ease: from rest to rest",
            Interpolation::Step => "Step: hold until the next key",
        };
        if ui.selectable_label(present == Some(way), text).clicked() {
            commands.push(TimeEdit::Key(tick.values.clone(), KeyEdit::Interpolate(way)).into());
            ui.close();
        }
    }
}

fn paint(ui: &Ui, model: &TimelineModel, scale: &Scale, rect: Rect, track: Rect, state: &TimelineState) {
    let painter = ui.painter_at(rect);
    let visuals = ui.visuals();
    let frames = &model.frames;
    painter.rect_filled(rect, 3.0, visuals.extreme_bg_color);
    let ends = [frames.first, frames.last].map(|frame| scale.place(frames.time(frame.into())));
    let played = Rect::from_x_y_ranges(ends[0]..=ends[1], rect.y_range());
    painter.rect_filled(played, 0.0, visuals.faint_bg_color);
    // Numbers at round frames, as many as fit.
    let (first, last) = (frames.frame(scale.first), frames.frame(scale.last));
    let font = egui::TextStyle::Small.resolve(ui.style());
    for frame in numbered(first, last, f64::from(scale.width / NUMBERS)) {
        let x = scale.place(frames.time(frame));
        let color = visuals.weak_text_color();
        painter.vline(
            x,
            rect.top()..=rect.bottom(),
            Stroke::new(1.0, color.gamma_multiply(0.3)),
        );
        let number = painter.layout_no_wrap(format!("{frame:.0}"), font.clone(), color);
        // A number that would be cut off behind its line stands before it.
        let gap = HALF_MARKER + 2.0;
        let is_cut = x + gap + number.size().x > rect.right();
        let left = if is_cut { x - gap - number.size().x } else { x + gap };
        painter.galley(pos2(left, rect.top() + 1.0), number, color);
    }
    painter.hline(
        rect.x_range(),
        track.top(),
        Stroke::new(1.0, visuals.weak_text_color().gamma_multiply(0.4)),
    );
    // Keys are drawn over the line of the time, which takes no drags from them.
    let now = scale.place(model.time);
    let accent = look::accent(visuals);
    painter.vline(now, rect.y_range(), Stroke::new(2.0, accent));
    painter.add(Shape::convex_polygon(
        vec![
            pos2(now - HALF_MARKER, rect.top()),
            pos2(now + HALF_MARKER, rect.top()),
            pos2(now, rect.top() + 7.0),
        ],
        accent,
        Stroke::NONE,
    ));
    let row = track.center().y;
    for time in model.all.iter() {
        painter.add(mark(
            pos2(scale.place(*time), row),
            visuals.weak_text_color().gamma_multiply(0.6),
            0.6,
        ));
    }
    for time in model.selected.keys() {
        let shown = state
            .dragged
            .filter(|(key, _)| key == time)
            .map_or(time.0, |(_, to)| to);
        painter.add(mark(pos2(scale.place(shown), row), key_color(ui), 1.0));
    }
}

/// The round frames from `first` to `last` that have numbers. `most` is the number of steps between numbers that fit.
fn numbered(first: f64, last: f64, most: f64) -> impl Iterator<Item = f64> {
    let least = ((last - first) / most).max(1.0);
    let power = 10_f64.powi(least.log10().floor() as i32);
    let steps = [1.0, 2.0, 5.0].map(|digit| digit * power);
    let step = steps.into_iter().find(|step| *step >= least).unwrap_or(10.0 * power);
    let begin = (first / step).round();
    let count = ((last / step).round() - begin).min(most + 1.0) as u32;
    (0..=count).map(move |index| (begin + f64::from(index)) * step)
}

/// The colour of keys.
pub(crate) fn key_color(ui: &Ui) -> Color32 {
    match ui.visuals().dark_mode {
        true => Color32::from_rgb(240, 190, 70),
        false => Color32::from_rgb(190, 120, 0),
    }
}

/// A diamond.
pub(crate) fn mark(place: egui::Pos2, color: Color32, size: f32) -> Shape {
    let half = MARK * size;
    let corners = [vec2(0.0, -half), vec2(half, 0.0), vec2(0.0, half), vec2(-half, 0.0)];
    let corners = corners.map(|corner: Vec2| place + corner);
    Shape::convex_polygon(corners.to_vec(), color, Stroke::NONE)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn as_many_frames_have_numbers_as_have_room() {
        let numbers = |first: f64, last: f64| numbered(first, last, 10.0).collect::<Vec<_>>();
        assert_eq!(
            numbers(0.0, 95.0),
            [0.0, 10.0, 20.0, 30.0, 40.0, 50.0, 60.0, 70.0, 80.0, 90.0, 100.0]
        );
        assert_eq!(numbers(-4.0, 3.0), [-4.0, -3.0, -2.0, -1.0, 0.0, 1.0, 2.0, 3.0]);
        assert_eq!(numbers(0.0, 1001.0), [0.0, 200.0, 400.0, 600.0, 800.0, 1000.0]);
        for last in [1e6, 24e9, 1e14, 24e30] {
            let found = numbers(-last, last);
            assert!((4..=12).contains(&found.len()), "{last}: {found:?}");
        }
    }
}
