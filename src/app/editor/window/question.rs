//! Questions as data: a heading, answers with their consequences, and one row of buttons.
//!
//! All questions look alike. A destructive answer stands at the left, apart from the others; the usual answer stands at
//! the right, in the colour of the primary button.

use std::borrow::Cow;

use bevy_egui::egui::{Align, Button, Context, Layout, Ui};

use super::dialog;
use crate::app::editor::panels::look;

/// The place and the colour of an answer's button.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Role {
    /// The usual answer: the rightmost button, in the accent colour.
    Primary,
    /// A destructive answer: at the left, in the colour of errors.
    Danger,
    /// Another answer, left of the primary one.
    Other,
    /// Nothing is done. Esc gives this answer as well.
    Cancel,
}

/// An answer to a question, and the value that it returns.
pub struct Answer<A> {
    label: String,
    name: Option<&'static str>,
    consequence: Option<Cow<'static, str>>,
    help: Option<&'static str>,
    role: Role,
    is_entered: bool,
    value: A,
}

impl<A> Answer<A> {
    fn new(role: Role, label: impl Into<String>, value: A) -> Self {
        Self {
            label: label.into(),
            name: None,
            consequence: None,
            help: None,
            role,
            is_entered: false,
            value,
        }
    }

    /// The usual answer.
    pub fn primary(label: impl Into<String>, value: A) -> Self {
        Self::new(Role::Primary, label, value)
    }

    /// A destructive answer.
    pub fn danger(label: impl Into<String>, value: A) -> Self {
        Self::new(Role::Danger, label, value)
    }

    /// Another answer.
    pub fn other(label: impl Into<String>, value: A) -> Self {
        Self::new(Role::Other, label, value)
    }

    /// The answer that does nothing, which Esc gives as well. Each question has one.
    pub fn cancel(label: impl Into<String>, value: A) -> Self {
        Self::new(Role::Cancel, label, value).help("Esc")
    }

    /// Sets the consequence of the answer, as the rest of a sentence after its name.
    pub fn does(mut self, consequence: impl Into<Cow<'static, str>>) -> Self {
        self.consequence = Some(consequence.into());
        self
    }

    /// Sets the name before the consequence, if it is not the label without its dots.
    pub fn named(mut self, name: &'static str) -> Self {
        self.name = Some(name);
        self
    }

    /// Sets the tool tip of the button.
    pub fn help(mut self, help: &'static str) -> Self {
        self.help = Some(help);
        self
    }

    /// Makes Enter give this answer, unless a button has the keyboard.
    pub fn on_enter(mut self) -> Self {
        self.is_entered = true;
        self
    }

    fn button(&self, ui: &Ui) -> Button<'static> {
        match self.role {
            Role::Primary => look::primary(ui, &self.label),
            Role::Danger => look::danger(ui, &self.label),
            Role::Other | Role::Cancel => Button::new(self.label.clone()),
        }
    }
}

/// A question to the user.
pub struct Question<A> {
    /// The name of the window in egui.
    pub id: &'static str,
    /// The width in points.
    pub width: f32,
    /// The heading.
    pub heading: String,
    /// The answers, in the order in which their consequences are listed.
    pub answers: Vec<Answer<A>>,
}

impl<A> Question<A> {
    /// Shows the question with `text` below the heading. Returns the answer once it is given.
    pub fn ask(mut self, context: &Context, text: impl FnOnce(&mut Ui)) -> Option<A> {
        let mut given = None;
        let cover = dialog::question(context, self.id, self.width, &self.heading, |ui| {
            text(ui);
            for answer in &self.answers {
                if let Some(consequence) = &answer.consequence {
                    let name = answer.name.unwrap_or(answer.label.trim_end_matches('.'));
                    dialog::consequence(ui, name, consequence);
                }
            }
            let entered = self.answers.iter().position(|answer| answer.is_entered);
            given = entered.filter(|_| dialog::is_entered(ui));
            ui.add_space(10.0);
            ui.horizontal(|ui| {
                self.buttons(ui, |role| role == Role::Danger, &mut given);
                ui.with_layout(Layout::right_to_left(Align::Center), |ui| {
                    for role in [Role::Primary, Role::Other, Role::Cancel] {
                        self.buttons(ui, |other| other == role, &mut given);
                    }
                });
            });
        });
        let cancels = || self.answers.iter().position(|answer| answer.role == Role::Cancel);
        let place = given.or_else(|| cancels().filter(|_| cover.should_close()))?;
        Some(self.answers.swap_remove(place).value)
    }

    /// Shows the buttons of some answers.
    fn buttons(&self, ui: &mut Ui, is_here: impl Fn(Role) -> bool, given: &mut Option<usize>) {
        for (place, answer) in self
            .answers
            .iter()
            .enumerate()
            .filter(|(_, answer)| is_here(answer.role))
        {
            let mut response = ui.add(answer.button(ui));
            if let Some(help) = answer.help {
                response = response.on_hover_text(help);
            }
            if response.clicked() {
                *given = given.or(Some(place));
            }
        }
    }
}
