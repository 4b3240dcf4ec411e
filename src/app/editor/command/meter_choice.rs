//! The quantities that the meters of the window measure.

/// The quantities that the meters of the window measure.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct MeterChoice {
    /// Whether daylight factors are measured under an overcast sky, in place of illuminance by the scene's own lights.
    pub daylight: bool,
    /// Whether the glare of the view is rated as well.
    pub glare: bool,
}
