//! The colours of the three axes, in the picture and in the panels.

use bevy_egui::egui::Color32;

/// The colours of x, y and z.
pub const AXIS_COLORS: [Color32; 3] = [
    Color32::from_rgb(236, 76, 76),
    Color32::from_rgb(112, 196, 60),
    Color32::from_rgb(74, 132, 246),
];
