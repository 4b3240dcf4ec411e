//! Quitting waits for an image that gets its full film, so that it is not lost.

use crate::app::editor::command::Command;
use crate::app::editor::picture::awaited_image::AwaitedImage;
use crate::app::editor::session::toasts::Toasts;

/// Whether the program is to end once the image is there.
#[derive(Clone, Copy, Debug, Default)]
pub struct LateQuit {
    waits: bool,
}

impl LateQuit {
    /// Holds back the command to quit while an image is awaited. A second one gives the image up.
    pub fn hold(&mut self, commands: &mut Vec<Command>, image: Option<&AwaitedImage>, toasts: &mut Toasts) {
        let quits = commands.contains(&Command::Quit);
        match image {
            Some(image) if quits && !self.waits => {
                commands.retain(|command| *command != Command::Quit);
                self.waits = true;
                let name = image.file_name();
                toasts.reject(format!(
                    "The window closes once {name} is saved. Close it again to give the image up."
                ));
            }
            Some(_) => {}
            None if std::mem::take(&mut self.waits) && !quits => commands.push(Command::Quit),
            None => {}
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quitting_waits_for_the_image_until_one_insists() {
        let image = AwaitedImage {
            path: "a.png".into(),
            samples: 16,
            is_denoised: false,
            exact_before: None,
        };
        let toasts = &mut Toasts::default();
        let mut late = LateQuit::default();
        let mut after = |image: Option<&AwaitedImage>, mut commands: Vec<Command>| {
            late.hold(&mut commands, image, toasts);
            commands
        };
        assert_eq!(after(None, vec![Command::Quit]), [Command::Quit]);
        assert_eq!(after(Some(&image), vec![Command::Save, Command::Quit]), [Command::Save]);
        assert_eq!(after(Some(&image), Vec::new()), []);
        assert_eq!(after(None, Vec::new()), [Command::Quit], "the image is there");
        assert_eq!(after(None, Vec::new()), []);
        assert_eq!(after(Some(&image), vec![Command::Quit]), []);
        assert_eq!(
            after(Some(&image), vec![Command::Quit]),
            [Command::Quit],
            "it was asked for twice"
        );
    }
}
