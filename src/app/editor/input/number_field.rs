//! Fields for numbers. A typed text counts once the field loses the focus: a number with a decimal point or a decimal
//! comma, with a unit where it is a length, and simple arithmetic. A text that is no number stays in the field, marked,
//! until it is corrected or Esc restores the value. The status line shows the problem as well.

use std::cell::{Cell, RefCell};
use std::ops::RangeInclusive;
use std::rc::Rc;

use bevy_egui::egui::emath::Numeric;
use bevy_egui::egui::response::Flags;
use bevy_egui::egui::text::{CCursor, CCursorRange};
use bevy_egui::egui::text_edit::TextEditState;
use bevy_egui::egui::{
    Area, AsId, Context, DragValue, Event, Frame, Id, Key, Order, Response, Slider, Ui, Visuals, Widget,
};

use crate::app::editor::words::arithmetic::{self, plain};
use crate::app::editor::words::figures::legible;
use crate::scene::LengthUnit;

/// The time for which a note is shown, in seconds.
const SHOWN: f64 = 6.0;

/// The kind of number in a field.
#[derive(Clone, Copy)]
pub enum Meaning {
    /// A number.
    Number,
    /// A length in a scene of this unit, which may have a unit of its own.
    Length(LengthUnit),
    /// Any text that this function parses.
    Of(fn(&str) -> Option<f64>),
}

impl Meaning {
    fn read(self, text: &str) -> Option<f64> {
        match self {
            Self::Number => arithmetic::number(text),
            Self::Length(unit) => arithmetic::value(text, |operand| length(unit, operand)),
            Self::Of(read) => read(text),
        }
    }

    /// Examples of valid texts.
    fn examples(self) -> &'static str {
        match self {
            Self::Length(_) => "30cm, 0,5 and 1/4 are some",
            Self::Number | Self::Of(_) => "0.5, 0,5 and 1/4 are some",
        }
    }
}

/// Parses a number with a unit of length: the number, and that unit in units of the scene.
fn length(unit: LengthUnit, text: &str) -> Option<(f64, f64)> {
    if let Some(number) = plain(text) {
        return Some((number, 1.0));
    }
    let length = unit.parse(text)?;
    let end = text.find(|letter: char| !(letter.is_ascii_digit() || matches!(letter, '.' | ',')));
    match plain(&text[..end?]).filter(|number| *number != 0.0) {
        Some(number) => Some((number, length / number)),
        None => Some((length, 1.0)),
    }
}

/// A text that is no number, and the value of its field.
#[derive(Clone, PartialEq)]
struct Rejected {
    text: String,
    value: f64,
}

/// The mark of a field whose text was entered, is no number, and has not been edited since.
#[derive(Clone, Copy, Default)]
struct Entered;

/// The problem with a text, and its time.
#[derive(Clone)]
struct Note {
    text: String,
    time: f64,
}

/// A field, identified by its place in the panel and the thing that it edits.
#[derive(Clone)]
struct Field {
    id: Id,
    context: Context,
    limits: (f64, f64),
    meaning: Meaning,
    /// The value as the field formats it, and the value itself.
    shown: Rc<RefCell<(String, f64)>>,
    /// Whether the text was parsed as a number in this frame.
    is_read: Rc<Cell<bool>>,
}

impl Field {
    fn new<N: Numeric>(ui: &Ui, about: impl AsId, range: &RangeInclusive<N>, meaning: Meaning) -> Self {
        Self {
            id: ui.next_auto_id().with(("typed", Id::new(about))),
            context: ui.ctx().clone(),
            limits: (range.start().to_f64(), range.end().to_f64()),
            meaning,
            shown: Rc::default(),
            is_read: Rc::default(),
        }
    }

    fn rejected(&self) -> Option<Rejected> {
        self.context.data(|data| data.get_temp(self.id))
    }

    fn forget(&self) {
        self.context.data_mut(|data| {
            data.remove::<Rejected>(self.id);
            data.remove::<Entered>(self.id);
        });
    }

    /// The text of the field: the value, or the rejected text in its place.
    fn text(&self, value: f64, text: String) -> String {
        self.shown.replace((text.clone(), value));
        match self.rejected() {
            Some(rejected) if rejected.value == value => rejected.text,
            // The value has been changed elsewhere since.
            Some(_) => {
                self.forget();
                text
            }
            None => text,
        }
    }

    /// The number of an entered text.
    fn read(&self, text: &str) -> Option<f64> {
        let (shown, value) = self.shown.borrow().clone();
        if was_given_up(&self.context) {
            self.forget();
            return None;
        }
        // An unedited value must not be rounded to the shown digits.
        if text == shown || text.trim().is_empty() {
            self.forget();
            return None;
        }
        let (least, most) = self.limits;
        match self.meaning.read(text) {
            Some(number) => {
                self.forget();
                if number < least || number > most {
                    note(&self.context, beyond(number, least, most));
                } else {
                    forget_note(&self.context);
                }
                self.is_read.set(true);
                Some(number)
            }
            None => {
                note(&self.context, self.problem(text));
                let text = text.to_owned();
                let rejected = Rejected { text, value };
                self.context.data_mut(|data| data.insert_temp(self.id, rejected));
                self.context.request_repaint();
                None
            }
        }
    }

    fn problem(&self, text: &str) -> String {
        let shown = &self.shown.borrow().0;
        let examples = self.meaning.examples();
        format!("“{text}” is no number: {examples}. Esc brings back {shown}")
    }

    /// Shows the field, and marks a text that is no number.
    fn show(&self, ui: &mut Ui, add: impl FnOnce(&mut Ui) -> Response) -> Response {
        let before = self.rejected().map(|_| ui.style().clone());
        if before.is_some() {
            mark(ui.visuals_mut());
        }
        let mut response = add(ui);
        if let Some(style) = before {
            ui.set_style(style);
        }
        if ui.input(|input| input.key_pressed(Key::Escape)) {
            let pass = ui.ctx().cumulative_pass_nr();
            ui.data_mut(|data| data.insert_temp(Id::NULL, GivenUp(pass)));
        }
        if !self.is_read.get() && is_only_typed(ui) {
            // The text has changed, but not the number.
            response.flags.remove(Flags::CHANGED);
        }
        let left_by = |key| response.lost_focus() && ui.input(|input| input.key_pressed(key));
        if left_by(Key::Escape) {
            self.forget();
            forget_note(&self.context);
        }
        let Some(rejected) = self.rejected() else {
            return response;
        };
        if left_by(Key::Enter) {
            // The field keeps the focus.
            ui.memory_mut(|memory| memory.request_focus(response.id));
            ui.data_mut(|data| data.insert_temp(self.id, Entered));
        } else if response.clicked() && ui.data_mut(|data| data.remove_temp::<Entered>(self.id)).is_some() {
            // The first click after Enter selects all, as it does in a field that Enter has left.
            let mut state = TextEditState::load(ui.ctx(), response.id).unwrap_or_default();
            let end = CCursor::new(rejected.text.chars().count());
            state
                .cursor
                .set_char_range(Some(CCursorRange::two(CCursor::new(0), end)));
            state.store(ui.ctx(), response.id);
        } else if is_typing(ui) {
            ui.data_mut(|data| data.remove::<Entered>(self.id));
        }
        let problem = self.problem(&rejected.text);
        if response.has_focus() || left_by(Key::Enter) {
            explain(ui, &response, &problem);
        } else {
            response = response.on_hover_text(problem);
        }
        response
    }
}

/// The pass in which Esc was pressed.
#[derive(Clone, Copy)]
struct GivenUp(u64);

/// Whether Esc was pressed just now. A field of egui that has lost the focus by it parses its text in the next pass.
fn was_given_up(context: &Context) -> bool {
    let pass = context.cumulative_pass_nr();
    let given_up = context.data(|data| data.get_temp(Id::NULL));
    given_up.is_some_and(|GivenUp(at)| pass <= at + 2)
}

/// Whether the input of this frame can only change a text, and not a number directly as a drag or an arrow key does.
fn is_only_typed(ui: &Ui) -> bool {
    let arrows = [Key::ArrowUp, Key::ArrowDown, Key::ArrowLeft, Key::ArrowRight];
    ui.input(|input| {
        let is_typed = input.events.iter().any(|event| {
            matches!(
                event,
                Event::Text(_) | Event::Key { .. } | Event::Paste(_) | Event::Cut | Event::Ime(_)
            )
        });
        is_typed && !input.pointer.any_down() && !arrows.into_iter().any(|key| input.key_pressed(key))
    })
}

/// Whether a key is pressed or a text arrives.
fn is_typing(ui: &Ui) -> bool {
    let is_typed = |event: &Event| {
        matches!(
            event,
            Event::Text(_) | Event::Key { pressed: true, .. } | Event::Paste(_) | Event::Cut | Event::Ime(_)
        )
    };
    ui.input(|input| input.events.iter().any(is_typed))
}

/// Sets the colours of a field whose text is no number.
fn mark(visuals: &mut Visuals) {
    let color = visuals.error_fg_color;
    visuals.override_text_color = Some(color);
    // A focused field has the frame of a selection.
    visuals.selection.stroke.color = color;
    let widgets = &mut visuals.widgets;
    for state in [&mut widgets.inactive, &mut widgets.hovered, &mut widgets.active] {
        state.bg_stroke.color = color;
        state.bg_stroke.width = state.bg_stroke.width.max(1.0);
    }
}

/// Shows the problem below the field.
fn explain(ui: &Ui, response: &Response, problem: &str) {
    Area::new(response.id.with("problem"))
        .order(Order::Tooltip)
        .interactable(false)
        .constrain(true)
        .fixed_pos(response.rect.left_bottom())
        .show(ui.ctx(), |ui| {
            Frame::popup(ui.style()).show(ui, |ui| {
                ui.set_max_width(260.0);
                ui.label(problem);
            });
        });
}

/// A number that is dragged or typed, see [`number`].
pub struct NumberField<'a> {
    drag: DragValue<'a>,
    field: Field,
}

impl Widget for NumberField<'_> {
    fn ui(self, ui: &mut Ui) -> Response {
        self.field.show(ui, |ui| ui.add(self.drag))
    }
}

/// A slider with a number, see [`slider`].
pub struct SliderField<'a> {
    slider: Slider<'a>,
    field: Field,
}

impl Widget for SliderField<'_> {
    fn ui(self, ui: &mut Ui) -> Response {
        self.field.show(ui, |ui| ui.add(self.slider))
    }
}

impl<'a> SliderField<'a> {
    /// The slider in another style.
    pub fn styled(self, style: impl FnOnce(Slider<'a>) -> Slider<'a>) -> Self {
        Self {
            slider: style(self.slider),
            field: self.field,
        }
    }
}

/// A field for numbers in this range. `about` tells it from fields that are in its place at other times. `format`
/// returns the text of a number with so many decimals.
pub fn number<'a, N: Numeric>(
    ui: &Ui,
    drag: DragValue<'a>,
    about: impl AsId,
    range: RangeInclusive<N>,
    meaning: Meaning,
    format: impl 'a + Fn(f64, RangeInclusive<usize>) -> String,
) -> NumberField<'a> {
    let field = Field::new(ui, about, &range, meaning);
    let (shown, read) = (field.clone(), field.clone());
    let drag = drag
        .range(range)
        .custom_formatter(move |value, decimals| shown.text(value, format(value, decimals)))
        .custom_parser(move |text| read.read(text))
        .update_while_editing(false);
    NumberField { drag, field }
}

/// [`number`] with a slider.
pub fn slider<'a, N: Numeric>(
    ui: &Ui,
    slider: Slider<'a>,
    about: impl AsId,
    range: RangeInclusive<N>,
    meaning: Meaning,
    format: impl 'a + Fn(f64, RangeInclusive<usize>) -> String,
) -> SliderField<'a> {
    let field = Field::new(ui, about, &range, meaning);
    let (shown, read) = (field.clone(), field.clone());
    let slider = slider
        .custom_formatter(move |value, decimals| shown.text(value, format(value, decimals)))
        .custom_parser(move |text| read.read(text))
        .update_while_editing(false);
    SliderField { slider, field }
}

fn beyond(number: f64, least: f64, most: f64) -> String {
    let shown = |number: f64| legible(number, 0..=4);
    let (limit, word) = match number < least {
        true => (least, "least"),
        false => (most, "most"),
    };
    format!("{} is not possible here: {} is the {word}", shown(number), shown(limit))
}

fn note_id() -> Id {
    Id::new("what is wrong with a text")
}

/// Shows the problem with a text in the status line.
pub fn note(context: &Context, text: String) {
    let time = context.input(|input| input.time);
    context.data_mut(|data| data.insert_temp(note_id(), Note { text, time }));
}

/// Removes the note, whose problem is solved. The status line may have been drawn in this frame already.
fn forget_note(context: &Context) {
    context.data_mut(|data| data.remove::<Note>(note_id()));
    context.request_repaint();
}

/// Restores the values of all fields with rejected texts, while the status line shows a note. Returns false if it shows
/// none, so that Esc acts elsewhere.
pub fn take_back(context: &Context) -> bool {
    let has_texts = context.data(|data| data.count::<Rejected>() > 0);
    if told(context).is_none() || !has_texts {
        return false;
    }
    context.data_mut(|data| {
        data.remove_by_type::<Rejected>();
        data.remove_by_type::<Entered>();
    });
    forget_note(context);
    true
}

/// The last problem with a text, while it is shown.
pub fn told(context: &Context) -> Option<String> {
    let note: Note = context.data(|data| data.get_temp(note_id()))?;
    let left = SHOWN - (context.input(|input| input.time) - note.time);
    if left <= 0.0 {
        context.data_mut(|data| data.remove::<Note>(note_id()));
        return None;
    }
    context.request_repaint_after_secs(left as f32);
    Some(note.text)
}

#[cfg(test)]
mod tests;
