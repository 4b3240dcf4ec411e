//! The mouse cursor while the view is turned: hidden, and moved back to the middle of the picture before it reaches an
//! edge, so that turning has no end; afterwards it returns to its old place. Where a window system cannot move or hold
//! the cursor, turning ends where the cursor does.

use bevy_egui::egui::{Pos2, Rect, Vec2};

/// The farthest that the cursor may be from the picture's middle, as a share of the picture's shorter side.
const LEASH: f32 = 0.25;
/// The number of frames after which a cursor that has not arrived counts as one that cannot be moved.
const PATIENCE: u32 = 12;

/// The cursor while the user turns the view. All places are in points of the window.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct TurningCursor {
    /// The place of the cursor when the turning began; None while the cursor is free.
    pub(super) origin: Option<Pos2>,
    /// The place where it was seen last.
    last: Option<Pos2>,
    /// The place to which the window is to move it, with the pixels per point.
    pub(super) put: Option<(Pos2, f32)>,
    /// The place to which it was moved, until it is seen there.
    sent: Option<Pos2>,
    /// The frames since it was moved there.
    frames: u32,
    /// Whether the cursor does not arrive where it is moved to.
    is_stuck: bool,
}

impl TurningCursor {
    /// The movement of the mouse in this frame. `before` is the last place of the pointer, `seen` its places since, in
    /// order: the user's movement, unless the window has moved the pointer there. `device` is the movement reported by
    /// the system even for a pointer that does not move.
    pub fn follow(&mut self, before: Pos2, seen: &[Pos2], device: Vec2, picture: Rect, pixels_per_point: f32) -> Vec2 {
        let mut last = self.last.unwrap_or(before);
        let mut by = Vec2::ZERO;
        for &place in seen {
            match self.sent {
                Some(home) if (place - home).length_sq() < (place - last).length_sq() => {
                    by += place - home;
                    self.sent = None;
                }
                _ => by += place - last,
            }
            last = place;
        }
        self.last = Some(last);
        self.frames += 1;
        if self.sent.is_some() && self.frames > PATIENCE {
            (self.sent, self.is_stuck) = (None, true);
        }
        if by == Vec2::ZERO && seen.is_empty() {
            by = device;
        }
        if by != Vec2::ZERO && self.origin.is_none() {
            self.origin = Some(before);
        }
        let home = picture.center();
        let is_far = (last - home).length() > LEASH * picture.size().min_elem();
        if self.origin.is_some() && is_far && self.sent.is_none() && !self.is_stuck {
            self.sent = Some(home);
            self.frames = 0;
            self.put = Some((home, pixels_per_point));
        }
        by
    }

    /// Ends the turning.
    pub fn let_go(&mut self, pixels_per_point: f32) {
        // A move that the window has not carried out yet is kept.
        let put = self.origin.map(|origin| (origin, pixels_per_point)).or(self.put);
        *self = Self { put, ..Self::default() };
    }
}

#[cfg(test)]
mod tests {
    use bevy_egui::egui::{pos2, vec2};

    use super::*;

    /// A window system that moves the pointer some events after it is asked to.
    struct Desk {
        cursor: TurningCursor,
        pointer: Pos2,
        can_be_put: bool,
    }

    impl Desk {
        const PICTURE: Rect = Rect {
            min: pos2(100.0, 50.0),
            max: pos2(900.0, 650.0),
        };

        fn new(can_be_put: bool) -> Self {
            Self {
                cursor: TurningCursor::default(),
                pointer: pos2(110.0, 60.0),
                can_be_put,
            }
        }

        /// The mouse moves three times; the pointer stops at the edges of the screen.
        fn frame(&mut self, by: Vec2, device: Vec2) -> Vec2 {
            let before = self.pointer;
            let put = self.cursor.put.take().filter(|_| self.can_be_put);
            let mut seen = Vec::new();
            for event in 0..3 {
                if let Some((place, _)) = put.filter(|_| event == 1) {
                    self.pointer = place;
                    seen.push(place);
                }
                let next = (self.pointer + by / 3.0).clamp(Pos2::ZERO, pos2(1000.0, 700.0));
                seen.extend((next != self.pointer).then_some(next));
                self.pointer = next;
            }
            self.cursor.follow(before, &seen, device, Self::PICTURE, 1.0)
        }
    }

    #[test]
    fn turning_has_no_end_and_the_cursor_comes_back() {
        let mut desk = Desk::new(true);
        let turned = (0..400).fold(Vec2::ZERO, |all, _| all + desk.frame(vec2(-30.0, 11.0), Vec2::ZERO));
        assert!((turned - 400.0 * vec2(-30.0, 11.0)).length() < 1e-2, "{turned}");
        desk.cursor.let_go(1.0);
        assert_eq!(desk.cursor.put, Some((pos2(110.0, 60.0), 1.0)));
        assert_eq!(desk.cursor.origin, None);
    }

    #[test]
    fn where_it_cannot_be_moved_the_mouse_itself_is_asked() {
        let mut desk = Desk::new(false);
        for _ in 0..100 {
            desk.frame(vec2(-30.0, 0.0), Vec2::ZERO);
        }
        assert!(desk.cursor.is_stuck && desk.pointer.x == 0.0);
        assert_eq!(desk.frame(vec2(-30.0, 0.0), vec2(-30.0, 0.0)), vec2(-30.0, 0.0));
    }

    #[test]
    fn a_hand_at_rest_does_not_hide_it() {
        let mut desk = Desk::new(true);
        assert_eq!(desk.frame(Vec2::ZERO, Vec2::ZERO), Vec2::ZERO);
        assert_eq!((desk.cursor.origin, desk.cursor.put), (None, None));
        desk.cursor.let_go(1.0);
        assert_eq!(desk.cursor.put, None);
    }
}
