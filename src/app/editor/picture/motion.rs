//! Notices whether the picture moves, by flying or a drag. It is then rendered at less than its full resolution, if
//! full resolution would take too long. A single change is no movement.

use std::time::{Duration, Instant};

use bevy::prelude::*;

use crate::app::editor::command::preferences::Preferences;
use crate::engine::{RenderControl, RenderFilm, RenderState, RenderStatus};

/// The time without a change after which the picture counts as still.
const STILL: Duration = Duration::from_millis(150);
/// The longest time for a sample of every pixel before the resolution is lowered, in seconds.
const QUICK: f64 = 0.03;
/// The least time of rendering, in seconds, after which its speed is known.
const SHORTEST_RUN: f64 = 0.2;

#[derive(Resource, Debug, Default)]
pub struct Motion {
    /// Whether the picture is visible, which it is not without a window.
    is_followed: bool,
    /// Whether a change was made in this frame.
    is_new: bool,
    last_change: Option<Instant>,
    moves: bool,
    /// Whether the full resolution has been requested but not rendered yet.
    sharpens: bool,
    /// The last measured camera samples per second.
    speed: Option<f64>,
}

impl Motion {
    pub fn new(followed: bool) -> Self {
        Self {
            is_followed: followed,
            ..Self::default()
        }
    }

    /// Notes that the view or something in it has moved, and may move on.
    pub fn note_change(&mut self) {
        self.is_new = self.is_followed;
    }

    /// Whether the picture has the requested resolution, and a sample of every pixel.
    pub fn is_settled(&self) -> bool {
        !self.moves && !self.sharpens
    }

    /// Ends the motion at once, for commands that need the picture at full resolution.
    pub fn stop(&mut self) {
        self.last_change = None;
    }

    /// Returns whether the resolution is to be lowered. `seconds` is the time for a sample of every pixel, None if it
    /// is not known.
    fn step(&mut self, now: Instant, seconds: Option<f64>) -> bool {
        let goes_on = self.last_change.is_some_and(|last| now.duration_since(last) < STILL);
        if std::mem::take(&mut self.is_new) {
            self.moves |= goes_on && seconds.is_some_and(|seconds| seconds > QUICK);
            self.last_change = Some(now);
        } else {
            self.moves &= goes_on;
        }
        self.moves
    }
}

/// Follows the motion. Runs after the commands and before the engine.
pub fn follow_motion(
    mut motion: ResMut<Motion>,
    mut control: ResMut<RenderControl>,
    status: Res<RenderStatus>,
    film: Res<RenderFilm>,
    preferences: Res<Preferences>,
) {
    let motion = motion.bypass_change_detection();
    if status.seconds > SHORTEST_RUN && status.msamples_per_s > 0.0 {
        motion.speed = Some(1e6 * status.msamples_per_s);
    }
    let share = f64::from(control.motion_scale).powi(2);
    let pixels = status.size.as_dvec2().element_product() / share;
    let moves = motion.step(Instant::now(), motion.speed.map(|speed| pixels / speed));
    let scale = if moves { preferences.moving_scale } else { 1.0 };
    if control.motion_scale != scale {
        control.motion_scale = scale;
    }
    // While rendering is paused, waiting would not make the picture sharper.
    let is_busy = !control.paused && matches!(status.state, RenderState::Building | RenderState::Rendering);
    let is_there = !film.is_coarse && status.samples > 0;
    motion.sharpens = moves || (motion.sharpens && is_busy && !is_there);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_goes_on_moves_and_what_rests_does_not() {
        let mut motion = Motion::new(true);
        let begin = Instant::now();
        let mut at = |milliseconds: u64, changed: bool, seconds: f64| {
            if changed {
                motion.note_change();
            }
            motion.step(begin + Duration::from_millis(milliseconds), Some(seconds))
        };
        assert!(!at(0, true, 1.0), "a single change");
        assert!(!at(500, true, 1.0), "another one");
        assert!(at(516, true, 1.0), "a movement");
        // The time is now that of the lower resolution; that changes nothing before the end.
        assert!(at(532, true, 0.001) && at(600, false, 0.001));
        assert!(!at(532 + 151, false, 0.001), "it rests");
        assert!(!at(700, true, 0.001) && !at(716, true, 0.001), "all is quick");
    }

    #[test]
    fn without_eyes_on_it_nothing_moves() {
        let mut motion = Motion::new(false);
        for _ in 0..5 {
            motion.note_change();
            assert!(!motion.step(Instant::now(), Some(1.0)));
        }
    }

    #[test]
    fn who_wants_the_picture_stops_it() {
        let mut motion = Motion::new(true);
        let now = Instant::now();
        for _ in 0..2 {
            motion.note_change();
            motion.step(now, Some(1.0));
        }
        assert!(motion.moves);
        motion.stop();
        assert!(!motion.step(now, Some(1.0)));
    }

    #[test]
    fn a_paused_picture_is_waited_for_by_nobody() {
        for (paused, is_settled) in [(false, false), (true, true)] {
            let mut world = World::new();
            world.insert_resource(Motion {
                is_followed: true,
                sharpens: true,
                ..Motion::default()
            });
            world.insert_resource(RenderControl {
                paused,
                ..RenderControl::default()
            });
            world.insert_resource(RenderStatus {
                state: RenderState::Rendering,
                ..RenderStatus::default()
            });
            world.init_resource::<RenderFilm>();
            world.resource_mut::<RenderFilm>().is_coarse = true;
            world.init_resource::<Preferences>();
            world.run_system_cached(follow_motion).expect("runs");
            assert_eq!(world.resource::<Motion>().is_settled(), is_settled);
        }
    }
}
