//! Inverse lighting: the strengths and colours of lamps that come closest to a wanted picture.
//!
//! Light is linear in the lamps, so that with the light of each lamp in a layer of its own this is a linear
//! least-squares problem with limits (Schoeneman, Dorsey, Smits, Arvo and Greenberg, "Painting with Light", SIGGRAPH
//! 1993). [`Observations`] hold the light of the lamps at places of the picture, and the light that is wanted there;
//! [`solve`] finds the gains; [`Painting`] makes observations of brush strokes and a picture; [`place`] looks for
//! numbers that light is not linear in, such as places of lamps and the hour of the sun.

mod coverage;
mod observations;
mod painting;
mod pixel_light;
mod placing;
mod solve;
mod wish;

pub use coverage::{Coverage, Stroke};
pub use observations::{Observation, Observations, Wanted};
pub use painting::{LampLight, Painting, Seen, Target};
pub use pixel_light::{PixelLight, Places};
pub use placing::{Placed, Range, Tried, place};
pub use solve::{Fit, LampLimits, Limit, PULL, Unsolvable, solve};
pub use wish::Wish;

#[cfg(test)]
mod tests;
