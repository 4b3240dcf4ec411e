//! The properties of commands: their effect, their title in the history, and flags.

use bevy::prelude::Entity;

/// The effect of a command on the history and the picture.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Effect {
    /// The command changes nothing in the scene.
    None,
    /// The command restarts the picture, but leaves the scene as it is.
    View,
    /// The command is a step of the history.
    Edit,
    /// The command is a step of the history, merged with others of one drag.
    Drag,
}

/// The things in an edit's title in the history.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Subject {
    /// These things; without any, the title names none.
    Things(Vec<Entity>),
    /// The selection.
    Selection,
    /// The things that the edit creates, which are selected after it.
    Made,
}

/// The object that an edit gives to things, for its title in the history.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Object {
    /// An object with this name.
    Name(String),
    /// This entity.
    Thing(Entity),
}

/// The properties of one command.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Traits {
    /// Whether the command is recorded in the history, and whether it restarts the picture.
    pub effect: Effect,
    /// The label of an edit in the history, followed by the names of its things.
    pub label: &'static str,
    /// The things of the title.
    pub subject: Subject,
    /// The object of the title, if it names one.
    pub object: Option<Object>,
    /// Whether the command is one of many in succession while the view or a thing moves.
    pub moves_picture: bool,
    /// Whether the command usually restarts the picture.
    pub restarts_picture: bool,
    /// Whether the command is about single pixels of the picture.
    pub is_about_pixels: bool,
    /// Whether the command loses unsaved edits.
    pub loses_edits: bool,
    /// Whether the command saves the scene.
    pub saves: bool,
}

impl Traits {
    /// The properties of a command that changes nothing in the scene.
    pub const NONE: Self = Self::new(Effect::None);
    /// The properties of a command that restarts the picture, but leaves the scene as it is.
    pub const VIEW: Self = Self::new(Effect::View);

    const fn new(effect: Effect) -> Self {
        Self {
            effect,
            label: "",
            subject: Subject::Things(Vec::new()),
            object: None,
            moves_picture: false,
            restarts_picture: !matches!(effect, Effect::None),
            is_about_pixels: false,
            loses_edits: false,
            saves: false,
        }
    }

    /// The properties of a step of the history.
    pub fn edit(label: &'static str) -> Self {
        let traits = Self::new(Effect::Edit);
        Self { label, ..traits }
    }

    /// The properties of a step that is merged with others of the same drag.
    pub fn drag(label: &'static str) -> Self {
        Self {
            effect: Effect::Drag,
            moves_picture: true,
            ..Self::edit(label)
        }
    }

    /// Sets these things as subject.
    pub fn of(self, things: &[Entity]) -> Self {
        let subject = Subject::Things(things.to_vec());
        Self { subject, ..self }
    }

    /// Sets the selection as subject.
    pub fn of_selection(self) -> Self {
        let subject = Subject::Selection;
        Self { subject, ..self }
    }

    /// Sets the created things as subject.
    pub fn of_made(self) -> Self {
        let subject = Subject::Made;
        Self { subject, ..self }
    }

    /// Sets an object of this name.
    pub fn giving_name(self, name: &str) -> Self {
        let object = Some(Object::Name(name.to_owned()));
        Self { object, ..self }
    }

    /// Sets this thing, or none, as object.
    pub fn giving(self, thing: Option<Entity>) -> Self {
        match thing {
            Some(thing) => Self {
                object: Some(Object::Thing(thing)),
                ..self
            },
            None => self.giving_name("none"),
        }
    }

    /// Marks the command as one of many in succession while the view moves.
    pub fn moving_picture(self) -> Self {
        let moves_picture = true;
        Self { moves_picture, ..self }
    }

    /// Marks that the former picture, with its lights scaled, replaces the new one during the drag.
    pub fn scaling_picture(self) -> Self {
        let moves_picture = false;
        Self { moves_picture, ..self }
    }

    /// Marks that the picture usually stays.
    pub fn keeping_picture(self) -> Self {
        let restarts_picture = false;
        Self {
            restarts_picture,
            ..self
        }
    }

    /// Marks that the command is about single pixels of the picture.
    pub fn of_pixels(self) -> Self {
        let is_about_pixels = true;
        Self {
            is_about_pixels,
            ..self
        }
    }

    /// Marks that the command loses unsaved edits.
    pub fn losing_edits(self) -> Self {
        let loses_edits = true;
        Self { loses_edits, ..self }
    }

    /// Marks that the command saves the scene to its file or to another one.
    pub fn saving(self) -> Self {
        Self { saves: true, ..self }
    }

    /// The entities that an edit names; empty for edits of the selection and edits that name none.
    pub fn targets(self) -> Vec<Entity> {
        match self.subject {
            Subject::Things(things) => things,
            Subject::Selection | Subject::Made => Vec::new(),
        }
    }
}
