//! The side views: orthographic views from above, from the front and from the right beside the main view.

use std::ops::RangeInclusive;

use serde::{Deserialize, Serialize};

use super::axis_view::AxisView;

/// The side views with their names, in the order of [`SideViews::places`].
pub const SIDES: [(AxisView, &str); 3] = [
    (AxisView::Top, "Top"),
    (AxisView::Front, "Front"),
    (AxisView::Right, "Right"),
];

/// The range of [`SidePlace::height`], in world units.
const HEIGHTS: RangeInclusive<f32> = 1e-6..=1e9;
/// The largest coordinate of [`SidePlace::center`], in world units.
const FARTHEST: f32 = 1e9;

/// The settings of the side views.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct SideViews {
    /// Whether they are shown beside the main view.
    pub shown: bool,
    /// Whether all surfaces are shown in one grey instead of their own colours.
    pub clay: bool,
    /// The place of each of [`SIDES`]; None until the scene has been framed.
    pub places: [Option<SidePlace>; 3],
    /// Whether each of [`SIDES`] shows outer walls and roofs in place of the rooms behind them.
    pub closed: [bool; 3],
}

/// The part of the world that a side view shows.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct SidePlace {
    /// The point in its middle, in world space.
    pub center: [f32; 3],
    /// The height of the view in world units.
    pub height: f32,
}

impl SideViews {
    /// The settings without places that cannot be shown. A file may hold any numbers.
    pub(crate) fn within_range(self) -> Self {
        Self {
            places: self.places.map(|place| place.filter(SidePlace::is_possible)),
            ..self
        }
    }

    /// The settings with another place of the side view with this number, or the same if that place cannot be shown.
    pub(crate) fn with_place(mut self, side: usize, place: SidePlace) -> Self {
        if let Some(old) = self.places.get_mut(side).filter(|_| place.is_possible()) {
            *old = Some(place);
        }
        self
    }

    /// The settings in which the side view with this number shows outer walls, or else the rooms behind them.
    pub(crate) fn with_closed(mut self, side: usize, closed: bool) -> Self {
        if let Some(old) = self.closed.get_mut(side) {
            *old = closed;
        }
        self
    }
}

impl SidePlace {
    /// Whether the place can be shown.
    pub(crate) fn is_possible(&self) -> bool {
        self.center.iter().all(|x| x.abs() <= FARTHEST) && HEIGHTS.contains(&self.height)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn places_that_cannot_be_shown_are_left_out() {
        let place = |x: f32, height: f32| SidePlace {
            center: [x, 0.0, 2.0],
            height,
        };
        let good = place(1.0, 3.0);
        let views = SideViews {
            places: [Some(good), Some(place(f32::NAN, 3.0)), Some(place(1.0, 0.0))],
            ..SideViews::default()
        };
        assert_eq!(views.within_range().places, [Some(good), None, None]);
        assert_eq!(
            SideViews::default().with_place(1, good).places,
            [None, Some(good), None]
        );
        for wrong in [place(f32::INFINITY, 1.0), place(0.0, -1.0), place(0.0, f32::NAN)] {
            assert_eq!(views.with_place(0, wrong).places[0], Some(good));
        }
    }
}
