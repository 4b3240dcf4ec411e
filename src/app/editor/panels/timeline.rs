//! The timeline below the picture: buttons and fields for the time, and a band: a ruler on which the time is dragged,
//! and tracks of keys below it. Keys take no presses on the ruler, so that the time can be dragged away from a key.

use std::ops::RangeInclusive;

use bevy::prelude::Entity;
use bevy_egui::egui::emath::{Numeric, format_with_decimals_in_range};
use bevy_egui::egui::{self, CursorIcon, DragValue, Rect, Response, Sense, Shape, Stroke, Ui, pos2, vec2};

use super::key_buttons::{MARK, Sign, key_color, mark, sign_button};
use super::look;
use super::tracks::{self, TrackKey, Tracks};
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
/// The heights in points of the ruler, on which the time is dragged, and of a track of keys below it.
const RULER: f32 = 22.0;
const TRACK: f32 = 16.0;
/// The height in points of the band. It is that of most tracks, since another height for another selection would change
/// the size of the picture, which would then begin anew.
const BAND: f32 = RULER + TRACK * tracks::MOST as f32;
/// The height in points above the foot of the ruler at which the keys of other things are.
const OTHERS: f32 = 5.0;
/// The margins at both ends of the band.
const MARGIN: f32 = 12.0;
/// The width in points of the names of the tracks.
const NAMES: f32 = 84.0;
/// The least distance between the numbers of two frames.
const NUMBERS: f32 = 56.0;

/// The state that the timeline keeps between frames.
#[derive(Clone, Copy, Debug, Default)]
pub struct TimelineState {
    /// The dragged key, and its present time in seconds.
    dragged: Option<(TrackKey, f64)>,
    /// The key whose menu is open.
    menu: Option<TrackKey>,
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
    let tracks = Tracks::of(model);
    ui.horizontal_top(|ui| {
        ui.spacing_mut().item_spacing.x = 4.0;
        names(ui, tracks);
        band(ui, model, tracks, state, commands);
    });
}

/// Shows the names of the tracks.
fn names(ui: &mut Ui, tracks: Tracks) {
    let size = vec2(NAMES, BAND);
    let (rect, _) = ui.allocate_exact_size(size, Sense::hover());
    let font = egui::TextStyle::Small.resolve(ui.style());
    let painter = ui.painter_at(rect);
    for track in 0..tracks.count() {
        let place = pos2(rect.right() - 4.0, rect.top() + RULER + TRACK * (track as f32 + 0.5));
        let color = ui.visuals().weak_text_color();
        painter.text(
            place,
            egui::Align2::RIGHT_CENTER,
            tracks.name(track),
            font.clone(),
            color,
        );
    }
}

fn buttons(ui: &mut Ui, model: &TimelineModel, bound: &KeyBindings, commands: &mut Vec<Command>) {
    let mut button = |ui: &mut Ui, text: &str, hint: &str, name: &str, command: Command| {
        let hint = actions::hint(hint, name, bound);
        if ui.button(text).on_hover_text(hint).clicked() {
            commands.push(command);
        }
    };
    let step = |it| TimeCommand::StepTime(it).into();
    let mut pressed = Vec::new();
    let mut key_button = |ui: &mut Ui, sign: Sign, text: &str, name: &str, command: Command| {
        if sign_button(ui, sign, text, actions::hint(text, name, bound)) {
            pressed.push(command);
        }
    };
    button(ui, "⏮", "First frame", "first-frame", step(TimeStep::FirstFrame));
    key_button(
        ui,
        Sign::Before,
        "Previous key",
        "previous-key",
        step(TimeStep::PreviousKey),
    );
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
    key_button(ui, Sign::After, "Next key", "next-key", step(TimeStep::NextKey));
    button(ui, "⏭", "Last frame", "last-frame", step(TimeStep::LastFrame));
    ui.separator();
    let (set, remove) = (
        Command::from(TimeEdit::Key(Vec::new(), KeyEdit::Set)),
        Command::from(TimeEdit::Key(Vec::new(), KeyEdit::Remove)),
    );
    key_button(
        ui,
        Sign::Plus,
        "Set a key of the place of the selection",
        "set-key",
        set,
    );
    key_button(
        ui,
        Sign::Minus,
        "Remove the keys of the selection at this time",
        "remove-key",
        remove,
    );
    commands.append(&mut pressed);
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

fn band(ui: &mut Ui, model: &TimelineModel, tracks: Tracks, state: &mut TimelineState, commands: &mut Vec<Command>) {
    let size = vec2(ui.available_width(), BAND);
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
        let row = ((place.y - track.top()) / TRACK).floor();
        let near = |key: &TrackKey| key.track as f32 == row && (scale.place(key.time.0) - place.x).abs() <= MARK;
        tracks.keys().find(near)
    };
    if response.drag_started() {
        let origin = ui.input(|input| input.pointer.press_origin());
        state.dragged = origin.and_then(key_at).map(|key| (key, key.time.0));
    }
    if let (Some((key, _)), Some(place), true) = (state.dragged, pointer, response.dragged()) {
        state.dragged = Some((key, time_at(place.x)));
    } else if response.drag_stopped()
        && let Some((key, to)) = state.dragged.take()
    {
        let from = key.time.0;
        if to != from {
            let values = tracks.values(key).cloned().collect();
            commands.push(TimeEdit::Key(values, KeyEdit::Move { from, to }).into());
        }
    } else if let Some(place) = pointer.filter(|_| response.dragged() || response.clicked()) {
        let key = key_at(place).filter(|_| response.clicked());
        let time = key.map_or_else(|| time_at(place.x), |key| model.frames.time_of_key(key.time.0));
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
        let values = tracks.values(key).cloned().collect();
        let shown = response.context_menu(|ui| key_menu(ui, model, key.time, values, commands));
        if shown.is_none() {
            state.menu = None;
        }
    } else if let Some(key) = hovered {
        let mut names: Vec<&str> = tracks.values(key).map(|(_, path)| path.as_str()).collect();
        names.sort_unstable();
        names.dedup();
        response.clone().on_hover_text(names.join(", "));
    }
    paint(ui, model, tracks, &scale, rect, track, state);
}

fn key_menu(
    ui: &mut Ui,
    model: &TimelineModel,
    key: TickTime,
    values: Vec<(Entity, KeyPath)>,
    commands: &mut Vec<Command>,
) {
    if values.is_empty() {
        return ui.close();
    }
    if ui.button("Remove this key").clicked() {
        commands.push(TimeCommand::SetTime(model.frames.time_of_key(key.0)).into());
        commands.push(TimeEdit::Key(values.clone(), KeyEdit::Remove).into());
        ui.close();
    }
    ui.separator();
    let track = |(thing, path): &(Entity, KeyPath)| {
        let tracks = model.tracks.get(thing)?;
        tracks
            .iter()
            .find(|(known, _)| known == path)
            .map(|(_, track)| track.clone())
    };
    let present = values.first().and_then(track).map(|track| track.interpolation);
    for way in Interpolation::ALL {
        let text = match way {
            Interpolation::Linear => "Linear: at constant speed",
            Interpolation::Ease => "Ease: from rest to rest",
            Interpolation::Step => "Step: hold until the next key",
        };
        if ui.selectable_label(present == Some(way), text).clicked() {
            commands.push(TimeEdit::Key(values.clone(), KeyEdit::Interpolate(way)).into());
            ui.close();
        }
    }
}

fn paint(
    ui: &Ui,
    model: &TimelineModel,
    tracks: Tracks,
    scale: &Scale,
    rect: Rect,
    track: Rect,
    state: &TimelineState,
) {
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
    let line = Stroke::new(1.0, visuals.weak_text_color().gamma_multiply(0.4));
    let row = |track_number: usize| track.top() + TRACK * (track_number as f32 + 0.5);
    for number in 0..tracks.count() {
        painter.hline(rect.x_range(), row(number) - 0.5 * TRACK, line);
    }
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
    let dim = visuals.weak_text_color().gamma_multiply(0.6);
    for time in tracks.times_of_others() {
        painter.add(mark(pos2(scale.place(time), track.top() - OTHERS), dim, 0.6));
    }
    for key in tracks.keys() {
        let dragged = state.dragged.filter(|(dragged, _)| *dragged == key);
        let shown = dragged.map_or(key.time.0, |(_, to)| to);
        painter.add(mark(pos2(scale.place(shown), row(key.track)), key_color(ui), 1.0));
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
