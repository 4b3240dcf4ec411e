//! Pictures of the whole window.

use std::time::{Duration, Instant};

use bevy::prelude::*;

use crate::app::editor::picture::pacing::Pacing;
use crate::app::editor::window::preview::Previews;
use crate::app::terminal;
use crate::files::write_atomically;
use crate::scene::SceneWatch;

/// The longest wait for the previews of materials. They are rendered in the time that everything else leaves, so that
/// on a busy machine they may take minutes.
const LONGEST_WAIT: Duration = Duration::from_secs(20);

/// Waits until the window is complete for a screenshot: previews of materials come last.
#[derive(Debug, Default)]
pub(crate) struct WindowWait {
    since: Option<Instant>,
}

impl WindowWait {
    /// Whether the window is complete, or the wait was too long. To be called in every frame once all other parts are
    /// complete.
    pub fn is_over(&mut self, pacing: &Pacing, previews: &Previews) -> bool {
        let is_complete = pacing.rests() && previews.are_done();
        let is_over = self.ends(is_complete, Instant::now());
        if is_over && !is_complete {
            terminal::line(format_args!(
                "note: the previews of materials were not finished after {} s, and are in the screenshot as they were",
                LONGEST_WAIT.as_secs()
            ));
        }
        is_over
    }

    fn ends(&mut self, is_complete: bool, now: Instant) -> bool {
        let since = *self.since.get_or_insert(now);
        let is_over = is_complete || now.duration_since(since) >= LONGEST_WAIT;
        if is_over {
            self.since = None;
        }
        is_over
    }
}

/// Saves a captured window as PNG. It does not replace files of the scene.
pub(crate) fn save_window(
    image: &Image,
    path: &std::path::Path,
    scene: &SceneWatch,
) -> Result<(), Box<dyn std::error::Error>> {
    if scene.has_file(path) {
        return Err("the scene is made of this file; choose another name".into());
    }
    let picture = image.clone().try_into_dynamic()?;
    let mut png = std::io::Cursor::new(Vec::new());
    picture.to_rgb8().write_to(&mut png, image::ImageFormat::Png)?;
    Ok(write_atomically(path, png.into_inner())?)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_wait_ends() {
        let mut wait = WindowWait::default();
        let start = Instant::now();
        assert!(!wait.ends(false, start));
        assert!(!wait.ends(false, start + LONGEST_WAIT / 2));
        assert!(wait.ends(false, start + LONGEST_WAIT));
        // The next wait is as long.
        assert!(!wait.ends(false, start + LONGEST_WAIT));
        assert!(!wait.ends(false, start + LONGEST_WAIT * 3 / 2));
        assert!(wait.ends(true, start + LONGEST_WAIT * 3 / 2));
    }
}
