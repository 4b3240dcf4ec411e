//! Reads parameters of a plugin: numbers, colours, spectra or textures.

use std::ops::RangeInclusive;

use bevy::math::Affine3A;

use super::from_file::FromFile;
use super::parameters::Parameters;
use super::picture_search::PictureSearch;
use super::spectra::{is_spectrum, read_spectrum};
use super::textures::read_texture;
use crate::color::Rgb;
use crate::document::spectrum::Role;
use crate::document::{Category, Object, Reader, TransformOp};
use crate::scene::{Declared, Parameter, Texture, ToWorld};

/// The most nested textures of a parameter.
const MOST_TEXTURES: usize = 256;

impl Parameters for Reader<'_, '_> {
    fn reflectance(&mut self, name: &str, pictures: &mut PictureSearch) -> Option<Parameter<Rgb>> {
        let given = self.unbounded_color(name, pictures);
        if let Some(Parameter::Constant(color)) = given
            && color.max_element() > 1.0
        {
            self.warn_at(name, format!("`{name}` is above 1: more light leaves than arrives"));
        }
        given
    }

    fn unbounded_color(&mut self, name: &str, pictures: &mut PictureSearch) -> Option<Parameter<Rgb>> {
        if self.child(name).is_none() {
            return self.rgb_in(name, 0.0..).map(Parameter::Constant);
        }
        let given = self.spectrum_or_texture(name, pictures)?;
        if is_negative(&given) {
            self.error_at(name, format!("`{name}` is negative"));
            return None;
        }
        Some(given)
    }

    fn float_parameter(
        &mut self,
        name: &str,
        range: RangeInclusive<f32>,
        pictures: &mut PictureSearch,
    ) -> Option<Parameter<f32>> {
        if self.child(name).is_none() {
            return self.mean_in(name, range).map(Parameter::Constant);
        }
        let number = match self.spectrum_or_texture(name, pictures)? {
            Parameter::Texture(texture) => return Some(Parameter::Texture(texture)),
            // Mitsuba uses the mean of a colour as a number.
            Parameter::Constant(color) => color.element_sum() / 3.0,
        };
        if !range.contains(&number) {
            let (low, high) = range.into_inner();
            self.error_at(
                name,
                format!("`{name}` is {number}, but should be from {low} to {high}"),
            );
            return None;
        }
        Some(Parameter::Constant(number))
    }

    fn radiometric(&mut self, name: &str, pictures: &mut PictureSearch) -> Option<Parameter<Rgb>> {
        let given = match self.child(name) {
            Some(_) => self.spectrum_or_texture(name, pictures)?,
            None => Parameter::Constant(self.emission(name)?),
        };
        if is_negative(&given) {
            self.error_at(name, format!("`{name}` is negative: light cannot be taken away"));
            return None;
        }
        Some(given)
    }

    fn spectrum_or_texture(&mut self, name: &str, pictures: &mut PictureSearch) -> Option<Parameter<Rgb>> {
        let role = Role::of(self.object().category, name);
        let object = self.child(name)?;
        if object.category != Category::Texture || !is_spectrum(&object.plugin) {
            return self.texture(name, pictures).map(Parameter::Texture);
        }
        check_textures_inside(self, name, object)?;
        self.nested(object, |reader| read_spectrum(reader, role, pictures))
    }

    fn texture(&mut self, name: &str, pictures: &mut PictureSearch) -> Option<Texture> {
        let object = self.child(name)?;
        if object.category != Category::Texture {
            let message = format!("`{name}` should be a colour or a texture, found {}", object.title());
            self.diagnostics().error(object.span, message);
            return None;
        }
        check_textures_inside(self, name, object)?;
        self.nested(object, |reader| read_texture(reader, pictures))
    }

    fn declared(&mut self, values: &mut impl Declared, pictures: &mut PictureSearch) {
        FromFile { reader: self, pictures }.read_all(values);
    }

    fn to_world(&mut self) -> Option<Affine3A> {
        let Some(steps) = self.transform("to_world") else {
            return Some(Affine3A::IDENTITY);
        };
        let map = TransformOp::compose(&steps);
        if ToWorld(map).is_invertible() {
            return Some(map);
        }
        let owner = self.object().title();
        self.error_at(
            "to_world",
            format!("`to_world` cannot be undone: it flattens the space of {owner}, or is not finite"),
        );
        None
    }
}

/// Checks that a texture, or a spectrum with a texture inside, has few enough nested ones. None has been reported.
fn check_textures_inside<'a>(reader: &mut Reader<'a, '_>, name: &str, object: &'a Object) -> Option<()> {
    if reader.count_inside(object, Category::Texture, MOST_TEXTURES) > MOST_TEXTURES {
        let message = format!("`{name}` consists of more than {MOST_TEXTURES} textures");
        reader.error_at(name, message);
        return None;
    }
    Some(())
}

fn is_negative(given: &Parameter<Rgb>) -> bool {
    matches!(given, Parameter::Constant(color) if color.min_element() < 0.0)
}
