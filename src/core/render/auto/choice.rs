//! The methods that `auto` chooses from, and the choice by the gains that a pilot has estimated.

use serde::Serialize;

use crate::render::view::{Integrator, PathSettings};

/// The gain from which on bidirectional path tracing is chosen.
pub(super) const WORTHWHILE: f64 = 1.5;
/// The gain from which on guided paths are chosen. The pilot compares single samples. Samples of pictures are well
/// distributed, which lowers the variance of guided paths further than that of others, so that pictures gain more than
/// the pilot predicts.
const WORTHWHILE_OF_GUIDE: f64 = 1.15;

/// The methods that `auto` chooses from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Method {
    /// Path tracing.
    Path,
    /// Path tracing with a guide.
    GuidedPath,
    /// Bidirectional path tracing.
    Bidirectional,
}

/// The choice for a scene and a view.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Choice {
    /// The method that pays for the scene.
    #[serde(skip)]
    pub method: Method,
    /// The gain of bidirectional path tracing: the variance of path tracing over its variance, at equal cost. None
    /// without a pilot.
    pub gain: Option<f32>,
    /// The gain of guided paths. None if they were not tried.
    pub gain_of_guide: Option<f32>,
    /// The share of the light that path tracing never finds, from 0 to 1.
    pub missed: f32,
}

impl Choice {
    /// Path tracing, without a pilot.
    pub const UNTRIED: Self = Self {
        method: Method::Path,
        gain: None,
        gain_of_guide: None,
        missed: 0.0,
    };

    /// The same choice, except that paths are always guided if guiding `is_asked` for.
    pub fn or_guided(self, is_asked: bool) -> Self {
        match (is_asked, self.method) {
            (true, Method::Path) => Self {
                method: Method::GuidedPath,
                ..self
            },
            _ => self,
        }
    }

    /// The name of the method: that of the integrator in files, or `guided path`. `has_media` says whether there are
    /// media, which only path tracing supports.
    pub fn name(&self, has_media: bool) -> &'static str {
        match (self.method, has_media) {
            (Method::Bidirectional, _) => "bdpt",
            (_, true) => "volpath",
            (Method::GuidedPath, false) => "guided path",
            (Method::Path, false) => "path",
        }
    }

    /// The chosen integrator with these settings.
    pub fn integrator(&self, settings: PathSettings) -> Integrator {
        match self.method {
            Method::Bidirectional => Integrator::Bidirectional(settings),
            Method::Path | Method::GuidedPath => Integrator::Path(settings),
        }
    }
}

/// The method for these gains over path tracing, of bidirectional path tracing and, if tried, of guided paths.
pub(super) fn method(gain: f64, gain_of_guide: Option<f64>) -> Method {
    match gain_of_guide {
        Some(guided) if guided >= WORTHWHILE_OF_GUIDE && (guided > gain || gain < WORTHWHILE) => Method::GuidedPath,
        _ if gain >= WORTHWHILE => Method::Bidirectional,
        _ => Method::Path,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_greater_gain_that_pays_is_chosen() {
        let expected = [
            ((1.0, None), Method::Path),
            ((1.0, Some(1.1)), Method::Path),
            ((1.6, None), Method::Bidirectional),
            ((1.6, Some(1.4)), Method::Bidirectional),
            ((1.6, Some(1.7)), Method::GuidedPath),
            // This larger gain is below its threshold.
            ((1.45, Some(1.4)), Method::GuidedPath),
        ];
        for ((gain, of_guide), expected) in expected {
            assert_eq!(method(gain, of_guide), expected, "{gain} {of_guide:?}");
        }
    }
}
