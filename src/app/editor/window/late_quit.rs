//! Quitting waits for an image that gets its full film, so that the image is not lost.

use crate::app::editor::command::{Command, FileCommand};
use crate::app::editor::picture::awaited_image::{AwaitedImage, EndedImage};
use crate::app::editor::session::toasts::Toasts;

/// Whether the program is to end once the image is saved.
#[derive(Clone, Copy, Debug, Default)]
pub struct LateQuit {
    waits: bool,
}

impl LateQuit {
    /// Holds back the command to quit while an image is awaited, until it is saved. A second command cancels the image.
    /// An image that is not saved leaves the window open. `ended` is the result of the last image. To be called before
    /// the question about unsaved edits, which may hold the command back again.
    pub fn hold(
        &mut self,
        commands: &mut Vec<Command>,
        image: Option<&AwaitedImage>,
        ended: Option<&EndedImage>,
        toasts: &mut Toasts,
    ) {
        let quits = commands.contains(&Command::from(FileCommand::Quit));
        match image {
            Some(image) if quits && !self.waits => {
                commands.retain(|command| *command != Command::from(FileCommand::Quit));
                self.waits = true;
                let name = image.file_name();
                toasts.reject(format!(
                    "The window closes once {name} is saved. Close it again to give the image up."
                ));
            }
            // If the question about edits is cancelled, the window stays open after the image as well.
            Some(_) if quits => self.waits = false,
            Some(_) => {}
            None => {
                let is_saved = ended.is_some_and(|ended| ended.0.is_ok());
                if std::mem::take(&mut self.waits) && is_saved && !quits {
                    commands.push(FileCommand::Quit.into());
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::app::editor::picture::awaited_image::{Before, ImageNotSaved};
    use crate::app::editor::window::unsaved_question::UnsavedQuestion;

    fn image() -> AwaitedImage {
        AwaitedImage {
            path: "a.png".into(),
            samples: 16,
            is_denoised: false,
            before: Before::Smaller { exact_samples: None },
        }
    }

    const SAVED: EndedImage = EndedImage(Ok(()));

    #[test]
    fn quitting_waits_for_the_image_until_one_insists() {
        let image = image();
        let toasts = &mut Toasts::default();
        let mut late = LateQuit::default();
        let mut after = |image: Option<&AwaitedImage>, mut commands: Vec<Command>| {
            late.hold(&mut commands, image, Some(&SAVED), toasts);
            commands
        };
        assert_eq!(
            after(None, vec![Command::from(FileCommand::Quit)]),
            [Command::from(FileCommand::Quit)]
        );
        assert_eq!(
            after(
                Some(&image),
                vec![Command::from(FileCommand::Save), Command::from(FileCommand::Quit)]
            ),
            [Command::from(FileCommand::Save)]
        );
        assert_eq!(after(Some(&image), Vec::new()), []);
        assert_eq!(
            after(None, Vec::new()),
            [Command::from(FileCommand::Quit)],
            "the image is saved"
        );
        assert_eq!(after(None, Vec::new()), []);
        assert_eq!(after(Some(&image), vec![Command::from(FileCommand::Quit)]), []);
        assert_eq!(
            after(Some(&image), vec![Command::from(FileCommand::Quit)]),
            [Command::from(FileCommand::Quit)],
            "it was asked for twice"
        );
        assert_eq!(after(None, Vec::new()), [], "the second command was the last");
    }

    #[test]
    fn an_image_that_is_not_saved_leaves_the_window_open() {
        let file = || "a.png".to_owned();
        let failures = [
            ImageNotSaved::Changed { file: file() },
            ImageNotSaved::NotWritten("The disk is full.".to_owned()),
            ImageNotSaved::Failed {
                file: file(),
                reason: "no memory".to_owned(),
            },
        ];
        for failure in failures {
            let (mut late, toasts) = (LateQuit::default(), &mut Toasts::default());
            let mut commands = vec![Command::from(FileCommand::Quit)];
            late.hold(&mut commands, Some(&image()), None, toasts);
            let ended = EndedImage(Err(failure));
            late.hold(&mut commands, None, Some(&ended), toasts);
            assert_eq!(commands, [], "{ended:?}");
            // A later image does not close it either.
            late.hold(&mut commands, Some(&image()), Some(&ended), toasts);
            late.hold(&mut commands, None, Some(&SAVED), toasts);
            assert_eq!(commands, []);
        }
    }

    #[test]
    fn edits_made_while_the_image_is_awaited_are_asked_about() {
        let (mut late, mut question) = (LateQuit::default(), UnsavedQuestion::default());
        let toasts = &mut Toasts::default();
        let mut commands = vec![Command::from(FileCommand::Quit)];
        late.hold(&mut commands, Some(&image()), None, toasts);
        question.hold(&mut commands, false);
        assert!(commands.is_empty() && !question.is_asking());
        late.hold(&mut commands, None, Some(&SAVED), toasts);
        question.hold(&mut commands, true);
        assert!(commands.is_empty() && question.is_asking());
    }
}
