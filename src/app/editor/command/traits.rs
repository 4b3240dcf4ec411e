//! The answers to everything that is asked about a command beside its work.

use bevy::prelude::Entity;

/// The effect of a command on the history and the picture.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Effect {
    /// The command changes nothing in the scene.
    None,
    /// The command begins the picture anew, but leaves the scene as it is.
    View,
    /// The command is a step of the history.
    Edit,
    /// The command is a step of the history, but several of one drag are one step.
    Drag,
}

/// The things that an edit is about, for its title in the history.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Subject {
    /// These things; without any, nothing in particular.
    Things(Vec<Entity>),
    /// The selection.
    Selection,
    /// The things that the edit makes, which are selected after it.
    Made,
}

/// What the things of an edit get, for its title in the history.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Object {
    /// Something with this name.
    Name(String),
    /// This entity.
    Thing(Entity),
}

/// The answers for one command.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Traits {
    /// Whether the command is recorded in the history, and whether it begins the picture anew.
    pub effect: Effect,
    /// The label of an edit in the history. The names of its things follow there.
    pub label: &'static str,
    /// The things that an edit is about.
    pub subject: Subject,
    /// What they get, if the title says so.
    pub object: Option<Object>,
    /// Whether the command is one of many that follow each other while the view or something in it moves.
    pub moves_picture: bool,
    /// Whether the command as a rule begins the picture anew.
    pub restarts_picture: bool,
    /// Whether the command is about single pixels of the picture.
    pub is_about_pixels: bool,
    /// Whether edits that no file has are lost with the command.
    pub loses_edits: bool,
    /// Whether the command saves the scene.
    pub saves: bool,
}

impl Traits {
    /// A command that changes nothing in the scene.
    pub const NONE: Self = Self::new(Effect::None);
    /// A command that begins the picture anew, but leaves the scene as it is.
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

    /// A step of the history.
    pub fn edit(label: &'static str) -> Self {
        let traits = Self::new(Effect::Edit);
        Self { label, ..traits }
    }

    /// A step of the history that is one with others of the same drag.
    pub fn drag(label: &'static str) -> Self {
        Self {
            effect: Effect::Drag,
            moves_picture: true,
            ..Self::edit(label)
        }
    }

    /// The edit is about these things.
    pub fn of(self, things: &[Entity]) -> Self {
        let subject = Subject::Things(things.to_vec());
        Self { subject, ..self }
    }

    /// The edit is about the selection.
    pub fn of_selection(self) -> Self {
        let subject = Subject::Selection;
        Self { subject, ..self }
    }

    /// The edit is about the things that it makes.
    pub fn of_made(self) -> Self {
        let subject = Subject::Made;
        Self { subject, ..self }
    }

    /// The things get something of this name.
    pub fn giving_name(self, name: &str) -> Self {
        let object = Some(Object::Name(name.to_owned()));
        Self { object, ..self }
    }

    /// The things get this one, or none.
    pub fn giving(self, thing: Option<Entity>) -> Self {
        match thing {
            Some(thing) => Self {
                object: Some(Object::Thing(thing)),
                ..self
            },
            None => self.giving_name("none"),
        }
    }

    /// Many such commands follow each other while the view moves.
    pub fn moving_picture(self) -> Self {
        let moves_picture = true;
        Self { moves_picture, ..self }
    }

    /// The former picture, with its lights scaled, stands for the new one during the drag.
    pub fn scaling_picture(self) -> Self {
        let moves_picture = false;
        Self { moves_picture, ..self }
    }

    /// As a rule the picture stays as it is.
    pub fn keeping_picture(self) -> Self {
        let restarts_picture = false;
        Self {
            restarts_picture,
            ..self
        }
    }

    /// The command is about single pixels of the picture.
    pub fn of_pixels(self) -> Self {
        let is_about_pixels = true;
        Self {
            is_about_pixels,
            ..self
        }
    }

    /// Edits that no file has are lost with the command.
    pub fn losing_edits(self) -> Self {
        let loses_edits = true;
        Self { loses_edits, ..self }
    }

    /// The command saves the scene to its file or to another one.
    pub fn saving(self) -> Self {
        Self { saves: true, ..self }
    }

    /// The entities that an edit names; empty for edits of the selection or of nothing in particular.
    pub fn targets(self) -> Vec<Entity> {
        match self.subject {
            Subject::Things(things) => things,
            Subject::Selection | Subject::Made => Vec::new(),
        }
    }
}
