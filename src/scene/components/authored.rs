//! Keeps the source text's plugins beside the components made of them. Saving starts from them, so that everything that
//! was not understood or not edited stays as it was written.

use std::collections::HashSet;
use std::ops::Deref;
use std::path::PathBuf;
use std::sync::Arc;

use bevy::prelude::*;
use smol_str::SmolStr;

use crate::document::{Category, Child, Document, Object, Property, Span};

/// The source of an entity. Absent on entities made in the editor. Clones share one source.
#[derive(Component, Clone, Debug)]
pub struct Authored(Arc<Source>);

/// The part of a scene file that one entity was read from.
#[derive(Clone, Debug, PartialEq)]
pub struct Source {
    /// The plugin as it is in the file; shared with the document that was read.
    pub object: Arc<Object>,
    /// The category of each child of `object`, with references followed; None for references without target and for
    /// children that were left out.
    pub child_categories: Box<[Option<Category>]>,
    as_read: AsRead,
}

/// A plugin with every parameter spelled out, stored as its difference from the plugin in the file.
#[derive(Clone, Debug, PartialEq)]
struct AsRead {
    /// A bit set: bit `i` stands for the property `i` of the plugin in the file.
    shared: u64,
    /// The other parameters. None if there are none and the plugin is the same.
    rest: Option<Box<Object>>,
}

impl Authored {
    /// Stores the source `object`. `as_read` is the plugin that [`crate::scene::write`] would have written from the
    /// components made of it.
    pub fn new(object: Arc<Object>, as_read: Object, child_categories: Box<[Option<Category>]>) -> Self {
        let as_read = AsRead::new(&object, as_read);
        Self(Arc::new(Source {
            object,
            child_categories,
            as_read,
        }))
    }

    /// Marks a child that became no component.
    pub(crate) fn leave_out(&mut self, child: usize) {
        Arc::make_mut(&mut self.0).child_categories[child] = None;
    }

    /// Marks the media inside as left out, except those for which `is_read` holds, given their names and indices.
    /// Saving leaves them as they are written.
    pub(crate) fn leave_out_media(&mut self, is_read: impl Fn(Option<&str>, usize) -> bool) {
        let categories = self.child_categories.iter().enumerate();
        let media = categories.filter(|(_, category)| **category == Some(Category::Medium));
        let places: Vec<usize> = media.map(|(place, _)| place).collect();
        for (number, place) in places.into_iter().enumerate() {
            if !is_read(self.object.children[place].name(), number) {
                self.leave_out(place);
            }
        }
    }
}

impl Deref for Authored {
    type Target = Source;

    fn deref(&self) -> &Source {
        &self.0
    }
}

impl PartialEq for Authored {
    fn eq(&self, other: &Self) -> bool {
        Arc::ptr_eq(&self.0, &other.0) || self.0 == other.0
    }
}

impl Source {
    /// The plugin that [`crate::scene::write`] would have written from the components made of it. Any difference at the
    /// time of saving is an edit. The properties are in no particular order.
    pub(crate) fn as_read(&self) -> Object {
        let (file, as_read) = (&*self.object, &self.as_read);
        let mut whole = match &as_read.rest {
            Some(rest) => Object::clone(rest),
            None => Object::new(file.category, file.plugin.clone()),
        };
        let shared = (0..).zip(&file.properties).filter(|(i, _)| as_read.has(*i));
        whole.properties.extend(shared.map(|(_, property)| Property {
            span: Span::default(),
            ..property.clone()
        }));
        whole
    }

    /// Whether the plugin of the file was not understood and another one stands in for it.
    pub(crate) fn is_stand_in(&self) -> bool {
        let rest = self.as_read.rest.as_ref();
        rest.is_some_and(|rest| rest.plugin != self.object.plugin)
    }
}

impl AsRead {
    fn new(file: &Object, mut whole: Object) -> Self {
        let mut shared = 0;
        whole.properties.retain(|property| {
            let is_same = |known: &Property| known.name == property.name && known.value == property.value;
            let place = file.properties.iter().take(u64::BITS as usize).position(is_same);
            shared |= place.map_or(0, |place| 1 << place);
            place.is_none()
        });
        whole.properties.shrink_to_fit();
        let is_plain = whole == Object::new(file.category, file.plugin.clone());
        Self {
            shared,
            rest: (!is_plain).then(|| Box::new(whole)),
        }
    }

    fn has(&self, property: u32) -> bool {
        property < u64::BITS && self.shared & (1 << property) != 0
    }
}

/// The owner of a material that is written inside it in the file; absent on materials at the top level.
#[derive(Component, Reflect, Clone, Copy, Debug, PartialEq, Eq)]
#[reflect(Component, PartialEq)]
#[relationship(relationship_target = Declares)]
pub(crate) struct DeclaredIn(pub Entity);

/// The materials written inside this entity.
#[derive(Component, Reflect, Clone, Debug, Default, PartialEq, Eq)]
#[relationship_target(relationship = DeclaredIn)]
pub(crate) struct Declares(Vec<Entity>);

/// The parts of the scene that became no entity.
#[derive(Resource, Clone, Debug, Default, PartialEq)]
pub struct AuthoredScene {
    /// The files as they were read, without messages; None for a new scene.
    pub origin: Option<Arc<Document>>,
    /// The integrator with its order in the file.
    pub integrator: Option<(u32, Authored)>,
    /// The folders in which files are searched besides the scene's folder (`<path>`), absolute.
    pub search_folders: Vec<PathBuf>,
    /// The properties of the scene itself.
    pub properties: Vec<Property>,
    /// The plugins and references that were left out, with their order in the file.
    pub rest: Vec<(u32, Child)>,
    /// The ids of file elements that are not entities, such as textures.
    pub foreign_ids: Arc<HashSet<SmolStr>>,
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::document::Value;

    fn source(file: &Object, as_read: &Object) -> Authored {
        Authored::new(Arc::new(file.clone()), as_read.clone(), Box::default())
    }

    #[test]
    fn what_was_read_comes_back_though_only_the_difference_is_kept() {
        let place = Span {
            start: 7,
            end: 9,
            ..Span::default()
        };
        let file = Object::new(Category::Shape, "sphere").at(place);
        let file = file
            .with("unknown", Value::Boolean(true))
            .with("radius", Value::Float(2.0));
        let read = Object::new(Category::Shape, "sphere");
        let read = read
            .with("center", Value::Point(Vec3::ZERO))
            .with("radius", Value::Float(2.0));
        let authored = source(&file, &read);
        let mut again = authored.as_read();
        again.properties.sort_by(|a, b| a.name.cmp(&b.name));
        assert_eq!(again, read);
        assert!(!authored.is_stand_in());

        // For a plugin with every parameter spelled out, nothing is stored.
        let whole = source(&read.clone().at(place), &read);
        assert_eq!((whole.as_read.rest.as_ref(), whole.as_read()), (None, read));
    }

    #[test]
    fn a_stand_in_is_another_plugin() {
        let file = Object::new(Category::Bsdf, "hair").with("reflectance", Value::Float(0.5));
        let read = Object::new(Category::Bsdf, "diffuse").with("reflectance", Value::Float(0.5));
        let authored = source(&file, &read);
        assert!(authored.is_stand_in());
        assert_eq!(authored.as_read(), read);
    }
}
