//! One start tag: its name and its attributes, unescaped and with `$names` replaced, each with its place.

use std::borrow::Cow;

use arrayvec::ArrayVec;
use quick_xml::XmlVersion;
use quick_xml::events::BytesStart;

use super::define::{DefineError, Defines};
use super::{Diagnostics, Severity, Span};

/// The most attributes of a tag. No tag of the format has more than six.
const MAX_ATTRIBUTES: usize = 64;

/// The most different attributes that are read from a tag.
const MAX_ASKED: usize = 8;

#[derive(Debug)]
pub struct Attribute<'t> {
    name: &'t str,
    /// None if the value was invalid, which has been reported.
    value: Option<Cow<'t, str>>,
    span: Span,
}

/// A start tag. Values without escapes and `$names` are borrowed from the source text.
#[derive(Debug)]
pub struct Tag<'t> {
    pub name: &'t str,
    pub span: Span,
    attributes: Vec<Attribute<'t>>,
    /// The names of the attributes read, for suggestions.
    asked: ArrayVec<&'static str, MAX_ASKED>,
}

impl<'t> Tag<'t> {
    /// Begins to read a tag. `text` is the whole source, `span` the tag's range in it.
    pub fn new(
        start: &'t BytesStart,
        text: &str,
        span: Span,
        defines: &mut Defines,
        diagnostics: &mut Diagnostics,
    ) -> Self {
        let mut attributes: Vec<Attribute> = Vec::new();
        for (count, attribute) in start.attributes().with_checks(false).enumerate() {
            let attribute = match attribute {
                Ok(_) if count >= MAX_ATTRIBUTES => {
                    diagnostics.error(span, format!("a tag with more than {MAX_ATTRIBUTES} attributes"));
                    break;
                }
                Ok(attribute) => attribute,
                Err(error) => {
                    diagnostics.error(span, format!("attributes of this tag cannot be read: {error}"));
                    break;
                }
            };
            let name = attribute.key.into_inner();
            let place = value_span(&attribute.value, text, span);
            if attributes.iter().any(|earlier| earlier.name == name) {
                diagnostics.error(place, format!("attribute `{name}` is given twice"));
                continue;
            }
            let value = match attribute.normalized_value(XmlVersion::Implicit1_0) {
                Ok(raw) => match substitute(raw, defines) {
                    Ok(value) => Some(value),
                    Err(error) => {
                        let nearest = error
                            .undefined
                            .and_then(|name| diagnostics.did_you_mean(&name, defines.names()));
                        diagnostics.push(Severity::Error, Some(place), error.message, nearest.or(error.help));
                        None
                    }
                },
                Err(error) => {
                    let message = format!("attribute `{name}` cannot be read: {error}");
                    let help = "write `&amp;` for `&`; entities other than amp, lt, gt, quot, apos are not supported";
                    diagnostics.push(Severity::Error, Some(place), message, Some(help.to_owned()));
                    None
                }
            };
            attributes.push(Attribute {
                name,
                value,
                span: place,
            });
        }
        Self {
            name: start.name().into_inner(),
            span,
            attributes,
            asked: ArrayVec::new(),
        }
    }

    /// The attribute's value and span; None if it is absent or invalid.
    pub fn take(&mut self, name: &'static str) -> Option<(Cow<'t, str>, Span)> {
        if !self.asked.is_full() {
            self.asked.push(name);
        }
        let index = self.attributes.iter().position(|attribute| attribute.name == name)?;
        let attribute = self.attributes.remove(index);
        attribute.value.map(|value| (value, attribute.span))
    }

    /// A required attribute that must not be empty; errors are reported.
    pub fn need(&mut self, name: &'static str, diagnostics: &mut Diagnostics) -> Option<(Cow<'t, str>, Span)> {
        let present = self.has(name);
        let taken = self.take(name);
        match &taken {
            None if !present => {
                diagnostics.error(self.span, format!("<{}> needs the attribute `{name}`", self.name));
            }
            Some((value, span)) if value.is_empty() => {
                diagnostics.error(*span, format!("attribute `{name}` is empty"));
                return None;
            }
            _ => {}
        }
        taken
    }

    pub fn has(&self, name: &str) -> bool {
        self.attributes.iter().any(|attribute| attribute.name == name)
    }

    /// Warns of attributes that were not read.
    pub fn finish(self, diagnostics: &mut Diagnostics) {
        for attribute in self.attributes {
            let known = self.asked.iter().copied();
            let help = diagnostics.did_you_mean(attribute.name, known);
            let message = format!("<{}> has no attribute `{}`; it is ignored", self.name, attribute.name);
            diagnostics.push(Severity::Warning, Some(attribute.span), message, help);
        }
    }
}

/// The value with its `$names` replaced.
fn substitute<'t>(raw: Cow<'t, str>, defines: &mut Defines) -> Result<Cow<'t, str>, DefineError> {
    match raw {
        Cow::Borrowed(text) => defines.substitute(text),
        Cow::Owned(text) => Ok(Cow::Owned(defines.substitute(&text)?.into_owned())),
    }
}

/// The span of an attribute's raw value, which is a part of `text`. If it is a copy, the span of the whole tag.
fn value_span(value: &str, text: &str, tag: Span) -> Span {
    let place = (value.as_ptr() as usize).checked_sub(text.as_ptr() as usize);
    let range = place.and_then(|start| Some((u32::try_from(start).ok()?, u32::try_from(start + value.len()).ok()?)));
    match range {
        Some((start, end)) if tag.start <= start && end <= tag.end => Span { start, end, ..tag },
        _ => tag,
    }
}
