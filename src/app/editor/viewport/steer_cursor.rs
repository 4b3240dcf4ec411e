//! Moves and hides the window's cursor as the turning view requests.

use bevy::prelude::*;
use bevy::window::{CursorGrabMode, CursorOptions, PrimaryWindow};

use super::state::ViewportState;

pub(crate) fn steer_cursor(
    mut state: ResMut<ViewportState>,
    mut windows: Query<(&mut Window, &mut CursorOptions), With<PrimaryWindow>>,
) {
    let Ok((mut window, mut options)) = windows.single_mut() else {
        return;
    };
    let cursor = &mut state.bypass_change_detection().pointer.cursor;
    let turns = cursor.origin.is_some();
    if options.visible == turns {
        options.visible = !turns;
        options.grab_mode = match turns {
            true => CursorGrabMode::Locked,
            false => CursorGrabMode::None,
        };
    }
    if let Some((place, pixels)) = cursor.put.take() {
        let physical = pixels * place.to_vec2();
        window.set_physical_cursor_position(Some(bevy::math::DVec2::new(physical.x.into(), physical.y.into())));
    }
}
