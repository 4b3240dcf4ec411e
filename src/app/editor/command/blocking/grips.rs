//! Moving and resizing the openings of a wall by their handles.

use crate::scene::{Opening, Solid};

declare_names! {
    /// The handles of an opening.
    #[derive(Clone, Copy, Debug, PartialEq, Eq)]
    pub enum Grip {
        /// The middle, which moves the opening.
        Middle = "middle",
        /// The edge nearer to the wall's start.
        Left = "left",
        /// The edge farther from the wall's start.
        Right = "right",
        /// The lower edge.
        Bottom = "bottom",
        /// The upper edge.
        Top = "top",
    }
}

/// The least extent that a drag leaves, as a share of the wall's shorter side.
const LEAST: f32 = 0.01;

impl Grip {
    /// The place of the handle on the wall's face: along the wall and upwards, in the wall's units.
    pub fn place(self, opening: &Opening) -> [f32; 2] {
        let Opening {
            from,
            sill,
            width,
            height,
        } = *opening;
        let middle = [from + 0.5 * width, sill + 0.5 * height];
        match self {
            Self::Middle => middle,
            Self::Left => [from, middle[1]],
            Self::Right => [from + width, middle[1]],
            Self::Bottom => [middle[0], sill],
            Self::Top => [middle[0], sill + height],
        }
    }

    /// The opening after a drag of this handle by a way along the wall and upwards. Edges go where `snap` puts them,
    /// given the place and the axis (0 along the wall, 1 upwards), and stay in the wall. `stands`: whether an opening
    /// with the sill 0 keeps it when it is moved, as a door does. None for parts that are no walls.
    pub fn dragged(
        self,
        wall: &Solid,
        opening: &Opening,
        by: [f32; 2],
        stands: bool,
        snap: impl Fn(f32, usize) -> f32,
    ) -> Option<Opening> {
        let Solid::Wall { length, height, .. } = *wall else {
            return None;
        };
        let least = LEAST * length.min(height);
        let mut spans = [
            [opening.from, opening.from + opening.width],
            [opening.sill, opening.sill + opening.height],
        ];
        let most = [length, height];
        let (axis, is_far) = match self {
            Self::Middle => {
                for axis in 0..2 {
                    let is_kept = axis == 1 && stands && opening.sill == 0.0;
                    if !is_kept && by[axis] != 0.0 {
                        spans[axis] = shifted(spans[axis], by[axis], most[axis], |place| snap(place, axis));
                    }
                }
                // The size stays to the last digit.
                return Some(Opening {
                    from: spans[0][0],
                    sill: spans[1][0],
                    ..*opening
                });
            }
            Self::Left => (0, false),
            Self::Right => (0, true),
            Self::Bottom => (1, false),
            Self::Top => (1, true),
        };
        // Beginning a drag does not put an edge onto the grid.
        if by[axis] == 0.0 {
            return Some(*opening);
        }
        let [start, end] = spans[axis];
        spans[axis] = match is_far {
            true => [
                start,
                snap(end + by[axis], axis).clamp(start + least, most[axis].max(start + least)),
            ],
            false => [
                snap(start + by[axis], axis).clamp(0.0_f32.min(end - least), end - least),
                end,
            ],
        };
        let [start, end] = spans[axis];
        Some(match axis {
            0 => Opening {
                from: start,
                width: end - start,
                ..*opening
            },
            _ => Opening {
                sill: start,
                height: end - start,
                ..*opening
            },
        })
    }
}

/// The span moved by a way, with one of its ends where `snap` puts it, inside 0 to `most`.
fn shifted([start, end]: [f32; 2], by: f32, most: f32, snap: impl Fn(f32) -> f32) -> [f32; 2] {
    let extent = end - start;
    let (low, high) = (start + by, end + by);
    // The end that has to go less far to its place.
    let (at_low, at_high) = (snap(low), snap(high) - extent);
    let to = if (at_high - low).abs() < (at_low - low).abs() {
        at_high
    } else {
        at_low
    };
    let to = to.clamp(0.0, (most - extent).max(0.0));
    [to, to + extent]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::app::editor::command::blocking::snapped;

    /// After a drag in a wall of 4 x 2.5 on a grid of 0.1.
    fn after(grip: Grip, opening: Opening, by: [f32; 2]) -> [f32; 4] {
        let wall = Solid::default();
        let now = grip.dragged(&wall, &opening, by, true, |place, _| snapped(place, 0.1));
        let Opening {
            from,
            sill,
            width,
            height,
        } = now.expect("a wall");
        [from, sill, width, height]
    }

    fn is(found: [f32; 4], expected: [f32; 4]) {
        let off = (0..4).map(|k| (found[k] - expected[k]).abs()).fold(0.0, f32::max);
        assert!(off < 1e-5, "{found:?} {expected:?}");
    }

    #[test]
    fn an_edge_goes_alone_and_the_middle_takes_all_along() {
        let window = Opening::WINDOW;
        is(after(Grip::Middle, window, [0.52, -0.31]), [1.0, 0.6, 1.2, 1.2]);
        is(after(Grip::Left, window, [0.28, 9.0]), [0.8, 0.9, 0.9, 1.2]);
        is(after(Grip::Right, window, [0.28, 9.0]), [0.5, 0.9, 1.5, 1.2]);
        is(after(Grip::Bottom, window, [9.0, -0.88]), [0.5, 0.0, 1.2, 2.1]);
        is(after(Grip::Top, window, [9.0, 0.22]), [0.5, 0.9, 1.2, 1.4]);
    }

    #[test]
    fn openings_stay_in_their_wall_and_keep_an_extent() {
        let window = Opening::WINDOW;
        is(after(Grip::Middle, window, [99.0, 99.0]), [2.8, 1.3, 1.2, 1.2]);
        is(after(Grip::Middle, window, [-99.0, -99.0]), [0.0, 0.0, 1.2, 1.2]);
        is(after(Grip::Right, window, [99.0, 0.0]), [0.5, 0.9, 3.5, 1.2]);
        is(after(Grip::Right, window, [-99.0, 0.0]), [0.5, 0.9, 0.025, 1.2]);
        is(after(Grip::Top, window, [0.0, -99.0]), [0.5, 0.9, 1.2, 0.025]);
        // An opening that reached beyond the wall in the file comes inside, and one that is too large begins at 0.
        let beyond = Opening {
            from: -1.0,
            width: 9.0,
            ..window
        };
        assert_eq!(after(Grip::Middle, beyond, [0.5, 0.0])[0], 0.0);
    }

    #[test]
    fn a_door_stays_on_the_floor() {
        let [_, sill, _, height] = after(Grip::Middle, Opening::DOOR, [0.4, 0.7]);
        assert_eq!((sill, height), (0.0, Opening::DOOR.height));
        let stairs = Solid::of_plugin("stairs").expect("a part");
        let none = Grip::Middle.dragged(&stairs, &Opening::DOOR, [0.1, 0.0], true, |place, _| place);
        assert_eq!(none, None);
    }
}
