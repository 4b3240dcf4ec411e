//! The tutorial in the window: five steps, each of which notices its completion.

use bevy::prelude::Resource;

use crate::app::editor::command::{ArrangeEdit, Command, EditCommand, FileCommand, SceneEdit, ValueEdit, ViewCommand};

/// A step of the tutorial.
#[derive(Debug, PartialEq, Eq)]
pub struct Lesson {
    /// The heading.
    pub title: &'static str,
    /// The instruction, as sentences.
    pub text: &'static str,
}

/// The steps in their order.
pub const LESSONS: [Lesson; 5] = [
    Lesson {
        title: "Look around",
        text: "Hold the right mouse button over the picture and move the mouse. Fly with W, A, S and D, with Q down and with E up. The wheel goes towards \
               the pointer. Home shows everything.",
    },
    Lesson {
        title: "Add something",
        text: "Choose Add > Sphere, or draw a box: press Shift+B, drag its foot on the floor, then move the mouse up and click. The tools that build \
               are at the left of the picture, too.",
    },
    Lesson {
        title: "Move it",
        text: "Escape leaves the drawing tool. Click the thing and drag one of its arrows, or press G, X, 1, Enter: that moves it by 1 along x. Ctrl+Z undoes any step.",
    },
    Lesson {
        title: "Give it a material",
        text: "Open the tab Library at the left and click a material. It goes to what is selected. Its colours and numbers are in the inspector at the right.",
    },
    Lesson {
        title: "Save the scene or the picture",
        text: "Ctrl+S saves the scene, F12 the picture. The picture gets better while you wait; the bar at the bottom says how far it is.",
    },
];

/// The number of frames in which the view has to move before the step of looking around counts as done.
const ENOUGH_LOOKING: u32 = 6;

/// The user's progress in the tutorial.
#[derive(Resource, Clone, Debug, Default, PartialEq, Eq)]
pub struct Tutorial {
    /// The step that is shown; None while there is no tutorial.
    pub step: Option<usize>,
    /// The steps that were done.
    pub done: [bool; LESSONS.len()],
    looked: u32,
}

impl Tutorial {
    /// Shows a step, or leaves the tutorial. The first step restarts it.
    pub fn go_to(&mut self, step: Option<usize>) {
        match step {
            Some(0) | None => *self = Self::default(),
            Some(_) => {}
        }
        self.step = step.filter(|step| *step < LESSONS.len());
    }

    /// Notes a completed command. `is_saved`: the scene equals its file.
    pub fn note(&mut self, command: &Command, is_saved: bool) {
        let Some(step) = self.step else { return };
        if matches!(command, Command::View(ViewCommand::MoveView(_))) {
            self.looked += 1;
        }
        self.done[step] |= match step {
            0 => {
                self.looked >= ENOUGH_LOOKING
                    || matches!(
                        command,
                        Command::View(ViewCommand::FrameAll | ViewCommand::LookAlong(_))
                    )
            }
            1 => matches!(
                command,
                Command::Edit(EditCommand::Scene(
                    SceneEdit::Add(_)
                        | SceneEdit::Build(_)
                        | SceneEdit::Duplicate
                        | SceneEdit::Import(_)
                        | SceneEdit::Paste(_)
                ))
            ),
            2 => matches!(
                command,
                Command::Edit(
                    EditCommand::Value(ValueEdit::Transform(_) | ValueEdit::Turn(..))
                        | EditCommand::Arrange(ArrangeEdit::Nudge(_) | ArrangeEdit::NudgeAlong(_) | ArrangeEdit::Drop)
                )
            ),
            3 => is_about_material(command),
            _ => {
                let saves = matches!(
                    command,
                    Command::File(FileCommand::Save | FileCommand::SaveScene(_) | FileCommand::SaveChanged(..))
                );
                saves && is_saved || matches!(command, Command::File(FileCommand::SaveImage(_)))
            }
        };
    }
}

fn is_about_material(command: &Command) -> bool {
    let of_value = |value: &ValueEdit| matches!(value, ValueEdit::SetMaterial(..));
    match command {
        Command::Edit(EditCommand::Value(value)) => of_value(value),
        Command::Edit(EditCommand::OnSelection(value)) => of_value(value),
        command => matches!(command, Command::Edit(EditCommand::Material(_))),
    }
}

#[cfg(test)]
mod tests {
    use bevy::math::Affine3A;

    use super::*;
    use crate::app::editor::command::MaterialEdit;
    use crate::app::editor::command::addition::AdditionKind;

    #[test]
    fn steps_are_done_by_what_they_ask_for_and_nothing_else() {
        let mut tutorial = Tutorial::default();
        let add = Command::from(SceneEdit::Add(AdditionKind::Sphere.into()));
        tutorial.note(&add, true);
        assert_eq!(tutorial, Tutorial::default(), "nothing is noted before it begins");
        tutorial.go_to(Some(0));
        tutorial.note(&add, true);
        assert_eq!(tutorial.done, [false; 5]);
        for _ in 0..ENOUGH_LOOKING {
            assert!(!tutorial.done[0]);
            tutorial.note(&Command::from(ViewCommand::MoveView(Affine3A::IDENTITY)), true);
        }
        assert!(tutorial.done[0]);
        for (step, command) in [
            (1, add),
            (2, Command::from(ValueEdit::Transform(Vec::new()))),
            (
                3,
                Command::from(MaterialEdit::UseMaterial {
                    shapes: Vec::new(),
                    material: None,
                }),
            ),
            (4, Command::from(FileCommand::SaveImage("a.png".into()))),
        ] {
            tutorial.go_to(Some(step));
            assert!(!tutorial.done[step]);
            tutorial.note(&command, false);
            assert!(tutorial.done[step], "{step}");
        }
        tutorial.go_to(Some(0));
        assert_eq!(tutorial.done, [false; 5], "it begins anew");
        tutorial.go_to(None);
        assert_eq!(tutorial, Tutorial::default());
    }

    #[test]
    fn a_save_that_asks_for_a_file_first_does_not_count() {
        let mut tutorial = Tutorial::default();
        tutorial.go_to(Some(4));
        tutorial.note(&Command::from(FileCommand::Save), false);
        assert!(!tutorial.done[4]);
        tutorial.note(&Command::from(FileCommand::SaveScene("a.xml".into())), true);
        assert!(tutorial.done[4]);
        tutorial.go_to(Some(5));
        assert_eq!(tutorial.step, None, "there is no sixth step");
    }
}
