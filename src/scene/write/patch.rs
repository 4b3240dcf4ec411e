//! Writes an edited plugin over its source: only edited parts change.

use bevy::math::Affine3A;
use smol_str::SmolStr;

use super::steps;
use crate::color::Rgb;
use crate::document::{Category, Child, Object, Property, Span, TransformOp, Value};
use crate::scene::components::emitter::frame_along;
use crate::scene::components::keys::superseded_by;
use crate::scene::components::parameters::HEIGHT;
use crate::scene::encode::poses::as_steps;
use crate::scene::{Authored, EulerAngles};

/// Factors, which are not written if they are 1.
const FACTORS: [&str; 2] = ["emission_scale", "sampling_weight"];

/// Parameters that depend on each other: writing one adds the other, unless the file has it.
const COMPANIONS: [(&str, &str); 3] = [("fov", "fov_axis"), ("fov_axis", "fov"), ("cutoff_angle", "beam_width")];

/// The default of an animated parameter that may be left out of the file. `value` is one of its values.
pub(in crate::scene) fn unwritten_value(name: &str, value: &Value) -> Option<Value> {
    match value {
        Value::Transform(_) => Some(Value::Transform(Vec::new())),
        Value::Float(_) if FACTORS.contains(&name) => Some(Value::Float(1.0)),
        Value::Float(_) => Some(Value::Float(0.0)),
        Value::Rgb(_) if name == "emission" => Some(Value::Rgb(Rgb::ZERO)),
        _ => None,
    }
}

/// The integrator with layers, around the one that traces light.
const LAYERED: &str = "aov";

/// A plugin being patched. The category of each child is known, with references followed.
pub struct Draft {
    pub object: Object,
    categories: Vec<Option<Category>>,
}

impl Draft {
    /// Begins a patch. `current` is the plugin made from the components, without nested bsdfs.
    pub fn new(authored: Option<&Authored>, current: Object) -> Self {
        let Some(authored) = authored else {
            let categories = current.objects().map(|child| Some(child.category)).collect();
            return Self {
                object: current,
                categories,
            };
        };
        let unchanged = Self {
            object: Object::clone(&authored.object),
            categories: authored.child_categories.to_vec(),
        };
        let as_read = authored.as_read();
        if is_same(&current, &as_read) {
            return unchanged;
        }
        // The unknown plugin behind an edited stand-in is dropped.
        if authored.is_stand_in() {
            return Self::new(
                None,
                Object {
                    name: authored.object.name.clone(),
                    ..current
                },
            );
        }
        let mut draft = unchanged;
        draft.patch(&as_read, &current);
        draft
    }

    /// Begins a patch of the integrator. Layers are wrapped around it or removed without a change of its other
    /// settings.
    pub fn of_integrator(authored: &Authored, current: Object) -> Self {
        let has_layers = |object: &Object| object.plugin == LAYERED;
        let inside = |object: &Object| {
            let mut objects = object.objects();
            objects.find(|child| child.category == Category::Integrator).cloned()
        };
        let as_read = authored.as_read();
        match (inside(&authored.object), inside(&current)) {
            (_, Some(now)) if has_layers(&current) && !has_layers(&authored.object) => {
                let now = Object {
                    id: None,
                    name: None,
                    span: Span::default(),
                    ..Self::new(Some(authored), now).object
                };
                // The layers around it take its span in the text.
                let around = Object {
                    id: authored.object.id.clone(),
                    name: authored.object.name.clone(),
                    span: authored.object.span,
                    children: vec![now.into()],
                    ..current
                };
                Self::new(None, around)
            }
            (Some(written), _) if has_layers(&as_read) && !has_layers(&current) => {
                Self::new(None, revised(&written.into(), inside(&as_read).as_ref(), current))
            }
            _ => Self::new(Some(authored), current),
        }
    }

    fn patch(&mut self, before: &Object, now: &Object) {
        self.object.plugin.clone_from(&now.plugin);
        for property in &now.properties {
            let old = value_of(before, &property.name);
            if old != Some(&property.value) {
                self.set(property, steps::is_turned(old, Some(&property.value)));
                self.complete(&property.name, now);
            }
        }
        for gone in &before.properties {
            if value_of(now, &gone.name).is_none() {
                if self.reset_moving(&gone.name, now) {
                    continue;
                }
                self.remove(&gone.name);
                self.remove_superseded(&gone.name);
            }
        }
        for texture in now.objects().filter(|child| is_value(child)) {
            let before = before.objects().find(|child| child.name == texture.name);
            if before != Some(texture) {
                self.set_texture(before, texture);
            }
        }
        for texture in before.objects().filter(|child| is_value(child)) {
            if let Some(name) = &texture.name
                && value_of(now, name).is_none()
                && !now.objects().any(|child| child.name == texture.name)
            {
                self.remove(name);
            }
        }
        for category in [
            Category::Integrator,
            Category::Film,
            Category::Sampler,
            Category::ReconstructionFilter,
            Category::Emitter,
            Category::Phase,
        ] {
            let of = |object: &Object| -> Vec<Object> {
                let inside = object.objects().filter(|child| child.category == category);
                inside.cloned().collect()
            };
            let (before, now) = (of(before), of(now));
            if before != now {
                self.set_plugins(category, &before, now);
            }
        }
    }

    /// `is_turned`: the angles of a transform have changed, not only their spelling.
    fn set(&mut self, property: &Property, is_turned: bool) {
        if let Some(property) = self.as_steps(property) {
            return self.set(&property, is_turned);
        }
        self.remove_children_named(&property.name);
        match self
            .object
            .properties
            .iter_mut()
            .find(|known| known.name == property.name)
        {
            Some(known) => {
                let keys = known.keys.take();
                let value = match (&known.value, &property.value) {
                    (Value::Transform(old), Value::Transform(now)) => {
                        Value::Transform(steps::revised(old, now, is_turned))
                    }
                    (_, now) => now.clone(),
                };
                *known = Property {
                    value,
                    keys,
                    ..property.clone()
                };
            }
            None => self.object.properties.push(property.clone()),
        }
        self.remove_superseded(&property.name);
    }

    /// Writes the default of an animated value explicitly if it now has it: otherwise its keys would be lost. False for
    /// other values.
    fn reset_moving(&mut self, name: &str, now: &Object) -> bool {
        if now.objects().any(|child| child.name.as_deref() == Some(name)) {
            return false;
        }
        let mut properties = self.object.properties.iter_mut();
        let Some(known) = properties.find(|known| known.name == name && known.keys.is_some()) else {
            return false;
        };
        let Some(default) = unwritten_value(name, &known.value) else {
            return false;
        };
        known.value = default;
        true
    }

    /// A position or a direction as the transform by which the file gives it.
    fn as_steps(&self, property: &Property) -> Option<Property> {
        let Some(Value::Transform(steps)) = value_of(&self.object, "to_world") else {
            return None;
        };
        let old = TransformOp::compose(steps);
        let map = match (property.name.as_str(), &property.value) {
            ("position", Value::Point(place)) => Affine3A::from_mat3_translation(old.matrix3.into(), *place),
            ("direction", Value::Vector(direction)) => {
                Affine3A::from_mat3_translation(frame_along(*direction).matrix3.into(), old.translation.into())
            }
            _ => return None,
        };
        Some(Property::new(
            "to_world",
            Value::Transform(as_steps(&map, EulerAngles::of_steps(steps))),
            Span::default(),
        ))
    }

    fn complete(&mut self, name: &str, now: &Object) {
        for (_, other) in COMPANIONS.iter().filter(|(one, _)| *one == name) {
            let companion = now.properties.iter().find(|property| property.name == *other);
            if let Some(companion) = companion
                && value_of(&self.object, other).is_none()
            {
                self.set(companion, false);
            }
        }
    }

    fn remove(&mut self, name: &str) {
        self.object.properties.retain(|property| property.name != name);
        self.remove_children_named(name);
    }

    fn remove_superseded(&mut self, name: &str) {
        for other in superseded_by(name) {
            self.remove(other);
        }
    }

    /// A texture that was given for a parameter.
    fn remove_children_named(&mut self, name: &str) {
        while let Some(place) = self.object.children.iter().position(|child| child.name() == Some(name)) {
            self.remove_child(place);
        }
    }

    /// Sets a texture or a volume, over the one given for the same parameter, or instead of a reference: others may use
    /// the referenced one as well.
    fn set_texture(&mut self, before: Option<&Object>, now: &Object) {
        let name = now.name.as_deref();
        let named = self.object.children.iter().position(|child| child.name() == name);
        // The texture of a bump map may have any parameter name or none.
        let only = || match name {
            Some(HEIGHT) => self
                .categories
                .iter()
                .position(|known| *known == Some(Category::Texture)),
            _ => None,
        };
        match named.or_else(only) {
            Some(place) => {
                let child = &mut self.object.children[place];
                let revised = revised(child, before, Object::clone(now)).into();
                *child = in_place_of(child, revised);
                self.categories[place] = Some(now.category);
            }
            None => {
                self.object.children.push(now.clone().into());
                self.categories.push(Some(now.category));
            }
        }
        if let Some(name) = name {
            self.object.properties.retain(|property| property.name != name);
            self.remove_superseded(name);
        }
    }

    fn remove_child(&mut self, place: usize) {
        self.object.children.remove(place);
        self.categories.remove(place);
    }

    /// Sets the nested plugins of a category without parameter names, in order.
    fn set_plugins(&mut self, category: Category, before: &[Object], now: Vec<Object>) {
        let is_of = |(_, known): &(usize, &Option<Category>)| **known == Some(category);
        let places = self.categories.iter().enumerate().filter(is_of).map(|(place, _)| place);
        let places: Vec<usize> = places.take(before.len().max(now.len())).collect();
        for &place in places.iter().skip(now.len()).rev() {
            self.remove_child(place);
        }
        for (index, now) in now.into_iter().enumerate() {
            let before = before.get(index);
            match places.get(index) {
                // An unedited plugin stays as it is, possibly as a reference.
                Some(_) if before == Some(&now) => {}
                Some(&place) => {
                    let child = &mut self.object.children[place];
                    *child = revised(child, before, now).into();
                }
                None => {
                    self.object.children.push(now.into());
                    self.categories.push(Some(category));
                }
            }
        }
    }

    /// Sets the medium with this parameter name, or the first one if it needs none, at the place of the old one.
    pub fn set_medium(&mut self, name: Option<&'static str>, medium: Option<Child>) {
        let mut children = self.object.children.iter().zip(&self.categories);
        let is_it = |child: &Child| name.is_none() || child.name() == name;
        let place = children.position(|(child, category)| *category == Some(Category::Medium) && is_it(child));
        match (place, medium) {
            (None, None) => {}
            (Some(place), None) => self.remove_child(place),
            (Some(place), Some(medium)) => {
                let child = &mut self.object.children[place];
                *child = in_place_of(child, medium);
            }
            (None, Some(mut medium)) => {
                // An unreadable one is at its place.
                if let Some(name) = name {
                    self.remove_children_named(name);
                }
                medium.set_name(name.map(SmolStr::new_static));
                self.object.children.push(medium);
                self.categories.push(Some(Category::Medium));
            }
        }
    }

    /// Sets the nested plugins of a category, in order, at the places of the old ones.
    pub fn set_nested(mut self, category: Category, nested: Vec<Child>) -> Object {
        let mut rest = nested.into_iter();
        let mut place = 0;
        while place < self.object.children.len() {
            if self.categories[place] == Some(category) {
                let Some(next) = rest.next() else {
                    self.remove_child(place);
                    continue;
                };
                let child = &mut self.object.children[place];
                *child = in_place_of(child, next);
            }
            place += 1;
        }
        self.object.children.extend(rest);
        self.object
    }
}

/// Writes `now` over the plugin in the file, which was read as `before`; a reference is replaced by the plugin itself.
fn revised(child: &Child, before: Option<&Object>, now: Object) -> Object {
    let (Child::Object(authored), Some(before)) = (child, before) else {
        return now;
    };
    let categories = authored.children.iter().map(|child| match child {
        Child::Object(object) => Some(object.category),
        // The parts of a phase function without a name are phase functions.
        Child::Reference { name: None, .. } if authored.category == Category::Phase => Some(Category::Phase),
        Child::Reference { .. } => None,
    });
    let authored = Authored::new(authored.clone(), before.clone(), categories.collect());
    Draft::new(Some(&authored), now).object
}

/// Whether it is the value of a parameter, which it names.
fn is_value(object: &Object) -> bool {
    matches!(object.category, Category::Texture | Category::Volume)
}

/// Puts `child` at the place of `old`: for the same parameter, and as a reference if that was one.
fn in_place_of(old: &Child, mut child: Child) -> Child {
    if let (Child::Reference { span: old, .. }, Child::Reference { span, .. }) = (old, &mut child) {
        *span = *old;
    }
    child.set_name(old.name().map(SmolStr::from));
    child
}

/// Whether two plugins are equal, in any order of their properties and children.
fn is_same(a: &Object, b: &Object) -> bool {
    let has_same = |property: &Property| value_of(b, &property.name) == Some(&property.value);
    (a.category, &a.plugin, &a.id, &a.name, &a.children) == (b.category, &b.plugin, &b.id, &b.name, &b.children)
        && a.properties.len() == b.properties.len()
        && a.properties.iter().all(has_same)
}

/// The value of a property.
pub(super) fn value_of<'o>(object: &'o Object, name: &str) -> Option<&'o Value> {
    let property = object.properties.iter().find(|property| property.name == name);
    property.map(|property| &property.value)
}
