//! Readers of parameters that many plugins have, with their checks and stand-ins.

use std::ops::RangeInclusive;

use bevy::math::Affine3A;

use super::picture_search::PictureSearch;
use crate::color::Rgb;
use crate::document::{Reader, Severity};
use crate::scene::{Declared, Parameter, Texture};

/// Reads one kind of parameter. None if the file does not give it, or if its value is invalid, which has been reported.
pub trait Parameters {
    /// A colour between 0 and 1; above 1 is a warning, below 0 an error.
    fn reflectance(&mut self, name: &str, pictures: &mut PictureSearch) -> Option<Parameter<Rgb>>;
    /// A colour without upper bound.
    fn unbounded_color(&mut self, name: &str, pictures: &mut PictureSearch) -> Option<Parameter<Rgb>>;
    fn float_parameter(
        &mut self,
        name: &str,
        range: RangeInclusive<f32>,
        pictures: &mut PictureSearch,
    ) -> Option<Parameter<f32>>;
    /// The emission of a light; not negative.
    fn radiometric(&mut self, name: &str, pictures: &mut PictureSearch) -> Option<Parameter<Rgb>>;
    /// The plugin given for a parameter: the colour of a spectrum, or a texture.
    fn spectrum_or_texture(&mut self, name: &str, pictures: &mut PictureSearch) -> Option<Parameter<Rgb>>;
    /// The texture given for a parameter.
    fn texture(&mut self, name: &str, pictures: &mut PictureSearch) -> Option<Texture>;
    /// Reads all declared parameters that the file gives.
    fn declared(&mut self, values: &mut impl Declared, pictures: &mut PictureSearch);
    /// The transform `to_world`; the identity if it is absent, None (with an error) if it is not invertible.
    fn to_world(&mut self) -> Option<Affine3A>;
}

/// Reports a shape or an emitter that cannot be read. A plugin that Mitsuba has is a limit of this program: a warning,
/// since the rest of the scene can be shown. An unknown plugin is a misspelt name: an error, because Mitsuba does not
/// read such a file either.
pub fn report_left_out(reader: &mut Reader, is_known_elsewhere: bool, help: Option<String>) {
    if reader.object().plugin.is_empty() {
        // The empty name was already reported.
        return;
    }
    let title = reader.object().title();
    let span = Some(reader.object().span);
    let (severity, message) = match is_known_elsewhere {
        true => (Severity::Warning, format!("{title} is not supported: it is left out")),
        false => (Severity::Error, format!("{title} is not known")),
    };
    reader.diagnostics().push(severity, span, message, help);
}
