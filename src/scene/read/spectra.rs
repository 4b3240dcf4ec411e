//! Reads the plugins of `<spectrum type="...">` as RGB colours.
//!
//! `uniform`, `d65`, `srgb` and `rawconstant` are read as in the RGB modes of Mitsuba 3: numbers are used unchanged,
//! and the wavelengths of `uniform` have no effect. `regular`, `irregular` and `blackbody`, which those modes do not
//! evaluate, are integrated as Mitsuba integrates the wavelengths and values of a `<spectrum value="...">`.

use glam::Vec3;

use super::picture_search::PictureSearch;
use super::textures::read_texture;
use crate::color::Rgb;
use crate::document::spectrum::{BlackBody, CLAMPED, Role, SampledSpectrum, SpectrumError};
use crate::document::{Category, Reader, Value};
use crate::scene::Parameter;
use crate::scene::components::texture_parameters::UNIFORM;

const BLACK_BODY: &str = "blackbody";
const REGULAR: &str = "regular";
const IRREGULAR: &str = "irregular";
pub(crate) const D65: &str = "d65";
const PLUGINS: [&str; 7] = [UNIFORM, D65, "srgb", "rawconstant", BLACK_BODY, REGULAR, IRREGULAR];

/// The default range of wavelengths of black bodies, in nm.
const VISIBLE_NM: [f32; 2] = [360.0, 830.0];

/// Whether a colour plugin is a spectrum of this module and not a texture.
pub(crate) fn is_spectrum(plugin: &str) -> bool {
    PLUGINS.contains(&plugin)
}

/// Whether the RGB modes of Mitsuba refuse to evaluate a spectrum.
pub(crate) fn is_spectral_only(plugin: &str) -> bool {
    [BLACK_BODY, REGULAR, IRREGULAR].contains(&plugin)
}

/// The colour of a spectrum, or the texture inside a `d65`. None has been reported.
pub(crate) fn read_spectrum(reader: &mut Reader, role: Role, pictures: &mut PictureSearch) -> Option<Parameter<Rgb>> {
    let color = match reader.object().plugin.as_str() {
        UNIFORM => Rgb::splat(uniform(reader)?),
        D65 => return d65(reader, role, pictures),
        "srgb" => srgb(reader)?,
        "rawconstant" => needed(reader, "value", raw_constant)?,
        _ => integrated(reader, role)?,
    };
    Some(color.into())
}

/// The value of a `uniform`; None after a reported error.
pub(crate) fn uniform(reader: &mut Reader) -> Option<f32> {
    reader.ignore(&["wavelength_min", "wavelength_max"]);
    needed(reader, "value", |reader| reader.float("value"))
}

/// The colour of a spectrum given by wavelengths; None after a reported error.
pub(crate) fn integrated(reader: &mut Reader, role: Role) -> Option<Rgb> {
    let (color, was_clamped) = match reader.object().plugin.as_str() {
        BLACK_BODY => black_body(reader, role)?.to_rgb(role),
        REGULAR => {
            let first = needed(reader, "wavelength_min", |reader| reader.float("wavelength_min"));
            let last = needed(reader, "wavelength_max", |reader| reader.float("wavelength_max"));
            let values = needed(reader, "values", |reader| reader.string("values"));
            let spectrum = SampledSpectrum::parse_regular(first?, last?, values?);
            sampled(spectrum, reader)?.to_rgb(role)
        }
        _ => {
            let wavelengths = needed(reader, "wavelengths", |reader| reader.string("wavelengths"));
            let values = needed(reader, "values", |reader| reader.string("values"));
            let spectrum = SampledSpectrum::parse_irregular(wavelengths?, values?);
            sampled(spectrum, reader)?.to_rgb(role)
        }
    };
    if was_clamped {
        let span = reader.object().span;
        reader.diagnostics().warn(span, CLAMPED);
    }
    Some(color)
}

fn black_body(reader: &mut Reader, role: Role) -> Option<BlackBody> {
    let kelvin = needed(reader, "temperature", |reader| {
        reader.float_in("temperature", f32::MIN_POSITIVE..)
    });
    let [first_nm, last_nm] = VISIBLE_NM;
    let first_nm = reader.float_or("wavelength_min", first_nm);
    let last_nm = reader.float_or("wavelength_max", last_nm);
    if !matches!(role, Role::Emission | Role::Daylight) {
        let message = "`blackbody` is light: it can be given only for the light of an emitter";
        let span = reader.object().span;
        reader.diagnostics().error(span, message);
        return None;
    }
    Some(BlackBody {
        kelvin: kelvin?,
        first_nm,
        last_nm,
    })
}

/// A required parameter of a spectrum.
fn needed<'a, T>(
    reader: &mut Reader<'a, '_>,
    name: &str,
    read: impl FnOnce(&mut Reader<'a, '_>) -> Option<T>,
) -> Option<T> {
    if !reader.has(name) {
        let message = format!("`{}` needs a `{name}`", reader.object().plugin);
        reader.error_at(name, message);
    }
    read(reader)
}

/// Reads a `d65`: white times `scale`, times a colour, or times a nested spectrum of wavelengths; any other nested
/// texture is used without `scale`, as in Mitsuba.
fn d65(reader: &mut Reader, role: Role, pictures: &mut PictureSearch) -> Option<Parameter<Rgb>> {
    let scale = reader.float("scale");
    let color = reader.rgb("color");
    let Some(&(_, inner)) = reader.children(Category::Texture).first() else {
        return Some((scale.unwrap_or(1.0) * color.unwrap_or(Vec3::ONE)).into());
    };
    if color.is_some() {
        reader.error_at("color", "`color` and a texture inside of a `d65` exclude each other");
    }
    let role = inside_d65(role);
    if is_spectral_only(&inner.plugin) {
        let spectrum = reader.nested(inner, |reader| integrated(reader, role))?;
        return Some((scale.unwrap_or(1.0) * spectrum).into());
    }
    if scale.is_some() {
        reader.warn_at("scale", "`scale` has no effect on the texture inside of a `d65`");
    }
    reader.nested(inner, |reader| match is_spectrum(&inner.plugin) {
        true => read_spectrum(reader, role, pictures),
        false => read_texture(reader, pictures).map(Parameter::Texture),
    })
}

/// The role of a spectrum nested in a `d65` with this role.
pub(crate) fn inside_d65(role: Role) -> Role {
    match role {
        Role::Emission => Role::Daylight,
        seen_under_d65 => seen_under_d65,
    }
}

fn srgb(reader: &mut Reader) -> Option<Rgb> {
    let color = needed(reader, "color", |reader| reader.rgb("color"))?;
    let is_unbounded = reader.boolean_or("unbounded", false);
    if color.min_element() < 0.0 || color.max_element() > 1.0 && !is_unbounded {
        let message = "the `color` of `srgb` should be between 0 and 1; `<rgb>` has no such bound";
        reader.error_at("color", message);
        return None;
    }
    Some(color)
}

/// One number, or the three of a vector.
fn raw_constant(reader: &mut Reader) -> Option<Rgb> {
    match reader.value("value") {
        Some(Value::Vector(_) | Value::Point(_)) => reader.vector("value"),
        Some(Value::Rgb(_)) => {
            reader.error_at(
                "value",
                "the `value` of `rawconstant` should be a float or a vector, found rgb",
            );
            None
        }
        _ => reader.float("value").map(Rgb::splat),
    }
}

fn sampled(spectrum: Result<SampledSpectrum, SpectrumError>, reader: &mut Reader) -> Option<SampledSpectrum> {
    let report = |error: SpectrumError| reader.error_at("values", error.to_string());
    spectrum.map_err(report).ok()
}
