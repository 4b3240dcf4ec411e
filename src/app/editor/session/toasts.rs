//! Messages to the user: notes that disappear by themselves, and errors that stay until they are dismissed or solved.

use std::time::{Duration, Instant};

use bevy::prelude::*;

use crate::app::editor::command::Command;
use crate::app::editor::words::files::in_plain_words;

/// The severity of a message, which decides its colour and duration.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Tone {
    /// A report of something done.
    Note,
    /// A request that cannot be met, or may be unintended.
    Warning,
    /// A failure.
    Error,
}

/// The topic of a message, by which it is removed once the problem is solved.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Topic {
    /// The open file cannot be read at present.
    SceneFile,
    /// The scene could not be saved.
    Saving,
    /// Files of the scene are missing.
    MissingFiles,
    /// There are edits that can be recovered.
    Recovery,
    /// All other topics, whose messages never become obsolete by themselves.
    Other,
}

/// A message over the window.
#[derive(Clone, Debug)]
pub struct Toast {
    /// Errors stay until dismissed, all others disappear.
    pub tone: Tone,
    /// The topic.
    pub topic: Topic,
    /// One or two sentences.
    pub text: String,
    /// Lines of a file, with marks under them.
    pub excerpt: Option<String>,
    /// A button's label and its command.
    pub offer: Option<(&'static str, Command)>,
    /// Whether it stays until it is dismissed. Errors do in any case.
    pub stays: bool,
    /// The time at which it appeared.
    pub since: Instant,
}

/// The time for which notes and warnings are shown.
pub(crate) const SHOWN: Duration = Duration::from_secs(5);
/// The time for which a message with a button is shown.
pub(crate) const OFFERED: Duration = Duration::from_secs(20);
/// The last part of that time, in which they fade.
pub(crate) const FADING: Duration = Duration::from_millis(400);
/// The time between two frames of a fading message.
pub(crate) const FADE_STEP: Duration = Duration::from_millis(40);
/// The most messages that are shown at once; the oldest make room.
pub(crate) const MOST: usize = 5;

/// The shown messages, the newest last.
#[derive(Resource, Clone, Debug, Default)]
pub struct Toasts(Vec<Toast>);

impl Toasts {
    /// Shows a note that something was done.
    pub(crate) fn info(&mut self, message: impl Into<String>) {
        let message = message.into();
        info!("{message}");
        self.add(Tone::Note, Topic::Other, message, None);
    }

    /// Shows a note with a button for a follow-up.
    pub(crate) fn offer(&mut self, message: impl Into<String>, label: &'static str, command: Command) {
        self.info(message);
        if let Some(toast) = self.0.last_mut() {
            toast.offer = Some((label, command));
        }
    }

    /// Shows a note with a button. It stays until it is dismissed, or until [`Self::forget`] removes it.
    pub(crate) fn keep_offering(
        &mut self,
        (tone, topic): (Tone, Topic),
        message: String,
        label: &'static str,
        command: Command,
    ) {
        self.forget(topic);
        self.add(tone, topic, message, None);
        if let Some(toast) = self.0.last_mut() {
            toast.offer = Some((label, command));
            toast.stays = true;
        }
    }

    /// Shows a warning that a request of the user cannot be met.
    pub(crate) fn reject(&mut self, message: impl Into<String>) {
        let message = message.into();
        info!("{message}");
        self.add(Tone::Warning, Topic::Other, message, None);
    }

    /// Shows a warning about something that may be unintended.
    pub(crate) fn warn(&mut self, message: impl Into<String>) {
        let message = message.into();
        warn!("{message}");
        self.add(Tone::Warning, Topic::Other, message, None);
    }

    /// Shows a long note on something that was done only in part; it stays until it is dismissed.
    pub fn report(&mut self, message: String) {
        self.add(Tone::Warning, Topic::Other, message, None);
        if let Some(toast) = self.0.last_mut() {
            toast.stays = true;
        }
    }

    /// Shows an error. It stays until it is dismissed, or until [`Self::forget`] removes it. `excerpt` holds the lines
    /// of the file that the error is about.
    pub fn error(&mut self, topic: Topic, message: impl Into<String>, excerpt: Option<String>) {
        let message = message.into();
        error!("{message}");
        self.add(Tone::Error, topic, message, excerpt);
    }

    /// Adds a message without a line in the log.
    pub fn add(&mut self, tone: Tone, topic: Topic, text: String, excerpt: Option<String>) {
        let text = in_plain_words(&text);
        // A repeated message replaces its older copy.
        self.0.retain(|toast| toast.text != text);
        if tone == Tone::Error && topic != Topic::Other {
            self.forget(topic);
        }
        self.0.push(Toast {
            tone,
            topic,
            text,
            excerpt,
            offer: None,
            stays: false,
            since: Instant::now(),
        });
        if self.0.len() > MOST {
            let first = |goes: fn(&Toast) -> bool| self.0.iter().position(goes);
            let passing = first(|toast| toast.tone != Tone::Error && !toast.stays);
            let other = || first(|toast| toast.tone != Tone::Error);
            self.0.remove(passing.or_else(other).unwrap_or(0));
        }
    }

    /// Removes the persistent messages about `topic`, whose problem is solved. Returns false if none was shown.
    pub fn forget(&mut self, topic: Topic) -> bool {
        let count = self.0.len();
        let stays = |toast: &Toast| toast.tone == Tone::Error || toast.stays;
        self.0.retain(|toast| !stays(toast) || toast.topic != topic);
        self.0.len() < count
    }

    /// The time until the next message fades or disappears. None if all stay.
    pub fn wait(&self) -> Option<Duration> {
        let waits = self
            .0
            .iter()
            .filter_map(Toast::left)
            .map(|left| if left > FADING { left - FADING } else { FADE_STEP });
        waits.min()
    }

    /// The messages without excerpts, the oldest first.
    pub fn texts(&self) -> impl Iterator<Item = &str> {
        self.0.iter().map(|toast| toast.text.as_str())
    }

    /// The messages without expired ones.
    pub fn current(&mut self) -> &[Toast] {
        self.0.retain(|toast| toast.left() != Some(Duration::ZERO));
        &self.0
    }

    /// Removes one of [`Self::current`].
    pub(crate) fn dismiss(&mut self, index: usize) {
        self.0.remove(index);
    }
}

impl Toast {
    /// The time left; None for messages that stay.
    fn left(&self) -> Option<Duration> {
        let shown = if self.offer.is_some() { OFFERED } else { SHOWN };
        (self.tone != Tone::Error && !self.stays).then(|| shown.saturating_sub(self.since.elapsed()))
    }

    /// The opacity, in [0, 1].
    pub(crate) fn opacity(&self) -> f32 {
        self.left()
            .map_or(1.0, |left| (left.as_secs_f32() / FADING.as_secs_f32()).min(1.0))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn add(toasts: &mut Toasts, tone: Tone, text: &str) {
        toasts.add(tone, Topic::SceneFile, text.to_owned(), None);
    }

    #[test]
    fn errors_stay_until_they_are_mended_and_then_nothing_is_waited_for() {
        let mut toasts = Toasts::default();
        add(&mut toasts, Tone::Error, "broken");
        assert_eq!(toasts.wait(), None);
        add(&mut toasts, Tone::Note, "done");
        add(&mut toasts, Tone::Error, "broken elsewhere");
        assert_eq!(toasts.texts().collect::<Vec<_>>(), ["done", "broken elsewhere"]);
        assert!(toasts.wait().is_some_and(|wait| wait <= SHOWN - FADING));
        toasts.forget(Topic::SceneFile);
        assert_eq!(toasts.texts().collect::<Vec<_>>(), ["done"]);
        // The message has expired long ago, but is not removed yet.
        if let Some(long_ago) = Instant::now().checked_sub(2 * SHOWN) {
            toasts.0[0].since = long_ago;
            assert_eq!(toasts.wait(), Some(FADE_STEP));
        }
    }

    #[test]
    fn there_are_never_many_and_errors_give_way_last() {
        let mut toasts = Toasts::default();
        add(&mut toasts, Tone::Error, "broken");
        for number in 0..20 {
            add(&mut toasts, Tone::Note, &number.to_string());
        }
        let texts: Vec<&str> = toasts.texts().collect();
        assert_eq!((texts.len(), texts[0], texts[MOST - 1]), (MOST, "broken", "19"));
    }
}
