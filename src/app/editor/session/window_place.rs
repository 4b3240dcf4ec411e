//! The size and the place of the window, which are remembered between runs.

use std::path::Path;

use bevy::prelude::*;
use bevy::window::{Monitor, MonitorSelection, PrimaryWindow, WindowMode};

use super::preferences;
use crate::app::editor::command::preferences::WindowPlace;

/// The pixels of a window's upper edge that have to be on a screen, so that its title can be dragged.
const REACHABLE: i32 = 64;

/// The place of the window when it was last closed; None at the first start, and without a user.
pub fn remembered(attended: bool) -> Option<WindowPlace> {
    let folder = preferences::folder(attended).filter(|_| attended)?;
    preferences::window_place(&folder)
}

impl WindowPlace {
    /// The present place of a window; None in full screen and the like, where the system decides it.
    pub(super) fn of(window: &Window) -> Option<Self> {
        let position = match window.position {
            WindowPosition::At(position) => Some(position.to_array()),
            _ => None,
        };
        let size = [window.width(), window.height()].map(|side| side.round() as u32);
        (window.mode == WindowMode::Windowed).then_some(Self { size, position })
    }
}

/// Moves the window to a screen if its last one is gone. Done once, when the screens are known.
pub fn keep_on_screen(
    monitors: Query<&Monitor>,
    mut windows: Query<&mut Window, With<PrimaryWindow>>,
    mut is_done: Local<bool>,
) {
    if *is_done || monitors.is_empty() {
        return;
    }
    *is_done = true;
    let Ok(mut window) = windows.single_mut() else {
        return;
    };
    if let WindowPosition::At(position) = window.position {
        let screens = monitors.iter().map(|monitor| {
            let corner = monitor.physical_position;
            IRect::from_corners(corner, corner + monitor.physical_size().as_ivec2())
        });
        let width = window.physical_width() as i32;
        if !screens.into_iter().any(|screen| is_reachable(position, width, screen)) {
            window.position = WindowPosition::Centered(MonitorSelection::Primary);
        }
    }
}

/// Whether enough of a window's upper edge is on a screen. All in pixels; `corner` is the window's upper left one.
fn is_reachable(corner: IVec2, width: i32, screen: IRect) -> bool {
    let left = corner.x.max(screen.min.x);
    let right = corner.x.saturating_add(width).min(screen.max.x);
    let is_high_enough = corner.y >= screen.min.y - REACHABLE / 2 && corner.y <= screen.max.y - REACHABLE;
    right.saturating_sub(left) >= REACHABLE && is_high_enough
}

/// Reads the window's place from the preferences in this folder; None if they cannot be read, which is reported when
/// they are opened.
pub(super) fn read(folder: &Path, file: &str) -> Option<WindowPlace> {
    let text = crate::files::read_text(&folder.join(file), crate::files::LARGEST_NOTE).ok()?;
    let value: serde_json::Value = serde_json::from_str(&text).ok()?;
    let place: WindowPlace = serde_json::from_value(value.get("window")?.clone()).ok()?;
    Some(place.within_range())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_window_can_be_taken_by_its_title() {
        let screen = IRect::new(0, 0, 1920, 1080);
        for (corner, expected) in [
            ((0, 0), true),
            ((-1200, 500), true),
            ((-1250, 500), false),
            ((1900, 500), false),
            ((100, 1070), false),
            ((100, -500), false),
            ((i32::MAX, i32::MIN), false),
        ] {
            assert_eq!(is_reachable(corner.into(), 1280, screen), expected, "{corner:?}");
        }
        assert!(is_reachable(
            IVec2::new(2000, 300),
            1280,
            IRect::new(1920, 0, 3840, 1080)
        ));
    }

    #[test]
    fn a_place_is_read_with_sane_values_or_not_at_all() {
        let folder = tempfile::tempdir().expect("a folder");
        let place = |text: &str| {
            std::fs::write(folder.path().join("p.json"), text).expect("a writable folder");
            read(folder.path(), "p.json")
        };
        assert_eq!(place("{"), None);
        assert_eq!(place("{}"), None);
        assert_eq!(place(r#"{"window": null}"#), None);
        assert_eq!(
            place(r#"{"window": {"size": [1, 100000], "position": [5, -2000000000]}}"#),
            Some(WindowPlace {
                size: [
                    WindowPlace::SIDES.start().to_owned(),
                    WindowPlace::SIDES.end().to_owned()
                ],
                position: None,
            })
        );
        assert_eq!(
            place(r#"{"window": {"size": [1600, 900], "position": [-20, 40]}}"#),
            Some(WindowPlace {
                size: [1600, 900],
                position: Some([-20, 40]),
            })
        );
    }
}
