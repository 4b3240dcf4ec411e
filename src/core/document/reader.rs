//! Reads the parameters of one plugin, and notices those that were not read.
//!
//! `Reader` knows value types; the caller knows the parameters. The names the caller asks for are the dictionary
//! against which the file's names are held in [`Reader::finish`].
//!
//! ```text
//! let mut diagnostics = document.diagnostics.clone();
//! let index = document.index();
//! let mut r = Reader::new(&index, object, &mut diagnostics);
//! let alpha = r.float_in("alpha", 0.0..=1.0).unwrap_or(0.1);
//! let eta = r.rgb("eta");
//! r.ignore(&["distribution"]);
//! let nested: Vec<_> = r.children(Category::Bsdf);
//! r.finish();
//! ```

use std::ops::{Bound, RangeBounds};

use glam::Vec3;
use smol_str::SmolStr;

use super::parsed::property_name;
use super::spectrum::equal_energy_white;
use super::value::format_float;
use super::{Category, Child, Diagnostics, Index, Object, Severity, Span, TransformOp, Value};
use crate::color::Rgb;

/// Reads the parameters of one object. Every getter returns None if the parameter is absent or unusable; the latter has
/// been reported.
pub struct Reader<'a, 'd> {
    index: &'d Index<'a>,
    object: &'a Object,
    diagnostics: &'d mut Diagnostics,
    asked: Vec<SmolStr>,
    /// Parameters that belong to other plugins, each with the words for its owner.
    elsewhere: Vec<(&'static str, &'static str)>,
    property_read: Vec<bool>,
    child_read: Vec<bool>,
}

impl<'a, 'd> Reader<'a, 'd> {
    /// Begins to read `object`. References are looked up in `index`, and messages are added to `diagnostics`.
    pub fn new(index: &'d Index<'a>, object: &'a Object, diagnostics: &'d mut Diagnostics) -> Self {
        Self {
            index,
            object,
            diagnostics,
            asked: Vec::new(),
            elsewhere: Vec::new(),
            // Properties with a type belong to no plugin.
            property_read: (object.properties.iter())
                .map(|property| property_name(&property.name).is_some())
                .collect(),
            child_read: vec![false; object.children.len()],
        }
    }

    /// Returns the object that is read.
    pub fn object(&self) -> &'a Object {
        self.object
    }

    /// Whether one of the object's references has no target, which was reported when the file was read.
    pub fn refers_to_nothing(&self) -> bool {
        let mut children = self.object.children.iter();
        children.any(|child| self.index.resolve(child).is_none())
    }

    /// The diagnostics, for the caller's own messages.
    pub fn diagnostics(&mut self) -> &mut Diagnostics {
        self.diagnostics
    }

    /// The span of a property or of the plugin for it; the object's own span if the file does not give it.
    pub fn span_of(&self, name: &str) -> Span {
        let property = self.object.properties.iter().find(|property| property.name == name);
        let child = || self.object.children.iter().find(|child| child.name() == Some(name));
        let span = property.map(|property| property.span);
        span.or_else(|| child().map(Child::span)).unwrap_or(self.object.span)
    }

    /// Whether the file gives this property; does not count as reading it.
    pub fn has(&mut self, name: &str) -> bool {
        self.ask(name);
        self.object.properties.iter().any(|property| property.name == name)
    }

    /// Reports an error at a property: `message` says what is wrong with it.
    pub fn error_at(&mut self, name: &str, message: impl Into<String>) {
        let span = self.span_of(name);
        self.diagnostics.error(span, message);
    }

    /// A warning at a property.
    pub fn warn_at(&mut self, name: &str, message: impl Into<String>) {
        let span = self.span_of(name);
        self.diagnostics.warn(span, message);
    }

    /// The property as given in the file, of any type.
    pub fn value(&mut self, name: &str) -> Option<&'a Value> {
        self.ask(name);
        let place = self
            .object
            .properties
            .iter()
            .position(|property| property.name == name)?;
        self.property_read[place] = true;
        Some(&self.object.properties[place].value)
    }

    /// A number; integers are accepted.
    pub fn float(&mut self, name: &str) -> Option<f32> {
        self.get(name, "a float", as_float)
    }

    /// A number, or `default` if it is absent or unusable.
    pub fn float_or(&mut self, name: &str, default: f32) -> f32 {
        self.float(name).unwrap_or(default)
    }

    /// A number in `range`; one outside is an error.
    pub fn float_in(&mut self, name: &str, range: impl RangeBounds<f32>) -> Option<f32> {
        let value = self.float(name)?;
        self.check(name, value, &range, |number| format_float(*number))
    }

    /// A number in `range` where a texture is allowed as well. A colour with components in `range` counts as their
    /// mean, as in Mitsuba.
    pub fn mean_in(&mut self, name: &str, range: impl RangeBounds<f32>) -> Option<f32> {
        let components = self.get(name, "a float, a colour or a texture", |value| match value {
            Value::Rgb(colour) => Some(colour.to_array()),
            other => as_float(other).map(|number| [number; 3]),
        })?;
        if let [number, _, _] = components
            && components == [number; 3]
        {
            return self.check(name, number, &range, |number| format_float(*number));
        }
        for component in components {
            self.check(name, component, &range, |number| format_float(*number))?;
        }
        Some(components.iter().sum::<f32>() / 3.0)
    }

    /// An integer; a `<float>` is an error even if its value is whole.
    pub fn integer(&mut self, name: &str) -> Option<i64> {
        self.get(name, "an integer", |value| match value {
            Value::Integer(number) => Some(*number),
            _ => None,
        })
    }

    /// An integer in `range`; one outside is an error.
    pub fn integer_in(&mut self, name: &str, range: impl RangeBounds<i64>) -> Option<i64> {
        let value = self.integer(name)?;
        self.check(name, value, &range, i64::to_string)
    }

    /// A boolean; other types are errors.
    pub fn boolean(&mut self, name: &str) -> Option<bool> {
        self.get(name, "a boolean", |value| match value {
            Value::Boolean(truth) => Some(*truth),
            _ => None,
        })
    }

    /// A boolean, or `default` if it is absent or unusable.
    pub fn boolean_or(&mut self, name: &str, default: bool) -> bool {
        self.boolean(name).unwrap_or(default)
    }

    /// A string; other types are errors.
    pub fn string(&mut self, name: &str) -> Option<&'a str> {
        self.get(name, "a string", |value| match value {
            Value::String(text) => Some(text.as_str()),
            _ => None,
        })
    }

    /// A string, or `default` if it is absent or unusable.
    pub fn string_or(&mut self, name: &str, default: &'a str) -> &'a str {
        self.string(name).unwrap_or(default)
    }

    /// A position; `<vector>` is accepted.
    pub fn point(&mut self, name: &str) -> Option<Vec3> {
        self.get(name, "a point", as_vec3)
    }

    /// A direction or an extent; `<point>` is accepted.
    pub fn vector(&mut self, name: &str) -> Option<Vec3> {
        self.get(name, "a vector", as_vec3)
    }

    /// A colour: `<rgb>`, or a number (`<spectrum>`, `<float>`) for all three components.
    pub fn rgb(&mut self, name: &str) -> Option<Rgb> {
        self.get(name, "a colour", |value| match value {
            Value::Rgb(colour) => Some(*colour),
            Value::Spectrum(number) => Some(Rgb::splat(*number)),
            other => as_float(other).map(Rgb::splat),
        })
    }

    /// A colour whose components are all in `range`.
    pub fn rgb_in(&mut self, name: &str, range: impl RangeBounds<f32>) -> Option<Rgb> {
        let colour = self.rgb(name)?;
        for component in colour.to_array() {
            self.check(name, component, &range, |number| format_float(*number))?;
        }
        Some(colour)
    }

    /// The colour of a light: as [`Self::rgb`], but a `<spectrum>` of one number means that power at every wavelength,
    /// which is slightly purple beside the white of Rec. 709 (so in Mitsuba's RGB mode); a `<float>` means white.
    pub fn emission(&mut self, name: &str) -> Option<Rgb> {
        match self.value(name) {
            Some(Value::Spectrum(number)) => Some(*number * equal_energy_white()),
            _ => self.rgb(name),
        }
    }

    /// The steps of a transform in the order in which they apply.
    pub fn transform(&mut self, name: &str) -> Option<Vec<TransformOp>> {
        self.get(name, "a transform", |value| match value {
            Value::Transform(ops) => Some(ops.clone()),
            _ => None,
        })
    }

    /// Marks parameters that exist but have no effect here as read, so that they cause no warning, be they properties
    /// or children.
    pub fn ignore(&mut self, names: &[&str]) {
        for name in names {
            self.value(name);
            self.child(name);
        }
    }

    /// Declares parameters of other plugins that a user may put here by mistake, for the help of [`Self::finish`]:
    /// `owner` is such as `the sampler`.
    pub fn belongs_to(&mut self, owner: &'static str, names: &[&'static str]) {
        self.elsewhere.extend(names.iter().map(|&name| (name, owner)));
    }

    /// The plugin given for this parameter: `<texture name="reflectance">` or `<ref name="reflectance">`.
    pub fn child(&mut self, name: &str) -> Option<&'a Object> {
        self.ask(name);
        let children: &'a [Child] = &self.object.children;
        let place = children.iter().position(|child| child.name() == Some(name))?;
        self.child_read[place] = true;
        self.index.resolve(&children[place])
    }

    /// Reads another object with the same index and diagnostics, then calls [`Self::finish`] on it.
    pub fn nested<T>(&mut self, object: &'a Object, read: impl FnOnce(&mut Reader<'a, '_>) -> T) -> T {
        let mut reader = Reader::new(self.index, object, self.diagnostics);
        let read = read(&mut reader);
        reader.finish();
        read
    }

    /// Reads another object with the same index and diagnostics. Unlike [`Self::nested`] it leaves calling
    /// [`Self::finish`] to `read`.
    pub fn apart<T>(&mut self, object: &'a Object, read: impl FnOnce(Reader<'a, '_>) -> T) -> T {
        read(Reader::new(self.index, object, self.diagnostics))
    }

    /// The plugins of a category in another object, with references resolved. They do not count as read.
    pub fn inside(&self, object: &'a Object, category: Category) -> impl Iterator<Item = &'a Object> {
        let children = object.children.iter();
        let inside = children.filter_map(|child| self.index.resolve(child));
        inside.filter(move |child| child.category == category)
    }

    /// The number of plugins of a category in another object, itself included, each counted as often as it is referred
    /// to: references can make a short file expand to very many. Counting stops a little above `most`.
    pub fn count_inside(&self, object: &'a Object, category: Category, most: usize) -> usize {
        let mut count = 0;
        let mut waiting = vec![object];
        while let Some(object) = waiting.pop().filter(|_| count <= most) {
            count += 1;
            waiting.extend(self.inside(object, category).take(most));
        }
        count
    }

    /// The plugins of a category, in file order, with their names; references are resolved.
    pub fn children(&mut self, category: Category) -> Vec<(Option<&'a str>, &'a Object)> {
        let mut found = Vec::new();
        let children: &'a [Child] = &self.object.children;
        for (child, read) in children.iter().zip(&mut self.child_read) {
            if let Some(object) = self.index.resolve(child)
                && object.category == category
            {
                *read = true;
                found.push((child.name(), object));
            }
        }
        found
    }

    /// Warns of each property and plugin that was not read.
    pub fn finish(self) {
        if self.diagnostics.is_full() {
            // Many objects may refer to one that has very many mistakes.
            let unread = self.property_read.iter().filter(|read| !**read).count() + self.unread_children().count();
            return self.diagnostics.count_warnings(unread);
        }
        let owner = || self.object.title();
        let dictionary = || self.asked.iter().map(SmolStr::as_str);
        for (property, read) in self.object.properties.iter().zip(&self.property_read) {
            if !read {
                let name = &property.name;
                // The name is known, but as another type.
                let message = if dictionary().any(|asked| asked == name) {
                    let kind = property.value.kind();
                    format!("{kind} given for `{name}` has no effect in {}", owner())
                } else {
                    format!("`{name}` is not a parameter of {}", owner())
                };
                let elsewhere = self.elsewhere.iter().find(|(known, _)| known == name);
                let help = match elsewhere {
                    Some((_, owner)) => Some(format!("it is a parameter of {owner}")),
                    None => self.diagnostics.did_you_mean(name, dictionary()),
                };
                self.diagnostics
                    .push(Severity::Warning, Some(property.span), message, help);
            }
        }
        for (child, object) in self.unread_children().collect::<Vec<_>>() {
            let (message, help) = match child.name() {
                Some(name) => (
                    format!(
                        "{} is given for `{name}`, which {} does not read",
                        object.title(),
                        owner()
                    ),
                    self.diagnostics.did_you_mean(name, dictionary()),
                ),
                None => (format!("{} has no effect in {}", object.title(), owner()), None),
            };
            self.diagnostics
                .push(Severity::Warning, Some(child.span()), message, help);
        }
    }

    /// The children that were not read, with the objects they resolve to. A reference without target was reported when
    /// it was read.
    fn unread_children(&self) -> impl Iterator<Item = (&'a Child, &'a Object)> {
        let children = self.object.children.iter().zip(&self.child_read);
        let unread = children.filter(|(_, read)| !**read);
        unread.filter_map(|(child, _)| Some((child, self.index.resolve(child)?)))
    }

    fn ask(&mut self, name: &str) {
        if !self.asked.iter().any(|asked| asked == name) {
            self.asked.push(name.into());
        }
    }

    fn get<T>(&mut self, name: &str, expected: &str, convert: impl Fn(&'a Value) -> Option<T>) -> Option<T> {
        let value = self.value(name)?;
        let converted = convert(value);
        if converted.is_none() {
            let message = format!("`{name}` should be {expected}, found {}", value.kind());
            self.error_at(name, message);
        }
        converted
    }

    fn check<T: Copy + PartialOrd>(
        &mut self,
        name: &str,
        value: T,
        range: &impl RangeBounds<T>,
        show: impl Fn(&T) -> String,
    ) -> Option<T> {
        if range.contains(&value) {
            return Some(value);
        }
        // The least positive number stands for the limit zero, which is left out.
        let is_least = |text: &str| text.parse() == Ok(f32::MIN_POSITIVE);
        let low = match range.start_bound() {
            Bound::Included(low) if is_least(&show(low)) => Some("above 0".to_owned()),
            Bound::Included(low) => Some(format!("at least {}", show(low))),
            Bound::Excluded(low) => Some(format!("above {}", show(low))),
            Bound::Unbounded => None,
        };
        let high = match range.end_bound() {
            Bound::Included(high) => Some(format!("at most {}", show(high))),
            Bound::Excluded(high) => Some(format!("below {}", show(high))),
            Bound::Unbounded => None,
        };
        let limits: Vec<String> = low.into_iter().chain(high).collect();
        let message = format!("`{name}` is {}, but should be {}", show(&value), limits.join(" and "));
        self.error_at(name, message);
        None
    }
}

/// The value as a float; a `<spectrum>` of one number is accepted.
fn as_float(value: &Value) -> Option<f32> {
    match value {
        Value::Float(number) | Value::Spectrum(number) => Some(*number),
        Value::Integer(number) => Some(*number as f32),
        _ => None,
    }
}

fn as_vec3(value: &Value) -> Option<Vec3> {
    match value {
        Value::Point(xyz) | Value::Vector(xyz) => Some(*xyz),
        _ => None,
    }
}
