//! What the inspector says of a light beside its parameters.

use std::sync::Arc;

use crate::engine::MeasureOf;
use crate::photometry::PolarCurve;

/// The horizontal angles in degrees of the planes in which lamps are drawn.
pub const PLANES: [f64; 4] = [0.0, 45.0, 90.0, 135.0];

/// The figures of a light.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct LightFigures {
    /// The measures of its parameters; none if the scene shows its lights in radiometric units.
    pub measures: Vec<MeasureOf>,
    /// The flux in lumens that the file of a lamp gives.
    pub own_flux: Option<f32>,
    /// The flux in lumens that a lamp with a file emits, and its greatest intensity in candela: with its strength, and
    /// with the flux that replaces that of the file.
    pub emitted: Option<[f32; 2]>,
    /// The intensities of the file of a lamp, in the planes of [`PLANES`].
    pub curves: Option<Arc<[PolarCurve]>>,
}
