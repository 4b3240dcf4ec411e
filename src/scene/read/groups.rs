//! `shapegroup` and `instance`.

use std::ops::Range;

use rayon::prelude::*;

use super::{SceneReader, address};
use crate::document::{Category, Child, Object, TransformOp, Value};
use crate::scene::description::{GroupDescription, Identity, ShapeDescription};
use crate::scene::{Placements, Shape, ShapeKind};

/// So many instances of one group in a row become one thing, [`Placements`]: one entity each would take several kilobytes.
const CROWD: usize = 1024;

pub(super) fn is_group(object: &Object) -> bool {
    object.category == Category::Shape && object.plugin == "shapegroup"
}

impl<'a> SceneReader<'a> {
    /// Every group is known before anything that refers to it is read.
    pub(super) fn list_groups(&mut self) {
        for object in self.root.objects().filter(|object| is_group(object)) {
            let identity = self.identity(object, Object::new(Category::Shape, "shapegroup"));
            self.group_of.insert(address(object), self.description.groups.len());
            self.description.groups.push(GroupDescription { identity });
        }
    }

    pub(super) fn read_group(&mut self, object: &'a Object) -> bool {
        let Some(&group) = self.group_of.get(&address(object)) else {
            let message = "a shapegroup stands at the top level of the scene: this one is left out";
            self.diagnostics.warn(object.span, message);
            return false;
        };
        let mut reader = self.reader(object);
        let shapes = reader.children(Category::Shape);
        reader.finish();
        let mut left_out = Vec::new();
        for (place, (_, shape)) in shapes.into_iter().enumerate() {
            let is_member = if !object.objects().any(|inside| std::ptr::eq(inside, shape)) {
                let message = "the shapes of a shapegroup are written inside it: those it refers to are left out";
                self.diagnostics.warn(object.span, message);
                false
            } else if is_group(shape) || shape.plugin == "instance" {
                let message = format!("{} cannot be part of a shapegroup", shape.title());
                self.diagnostics.error(shape.span, message);
                false
            } else {
                self.read_shape(shape, Some(group))
            };
            if !is_member {
                left_out.push(place);
            }
        }
        if let Some(authored) = &mut self.description.groups[group].identity.authored {
            let children = authored.child_categories.iter_mut();
            let shapes = children.filter(|category| **category == Some(Category::Shape));
            for (_, category) in shapes.enumerate().filter(|(place, _)| left_out.contains(place)) {
                *category = None;
            }
        }
        true
    }

    /// The group of an `instance`, None if it names none.
    pub(super) fn group_of_instance(
        &mut self,
        object: &'a Object,
        shapes: &[(Option<&str>, &'a Object)],
    ) -> Option<usize> {
        let mut groups = shapes
            .iter()
            .map(|(_, shape)| self.group_of.get(&address(shape)).copied());
        match (groups.next(), groups.next()) {
            (Some(Some(group)), None) => Some(group),
            // A lost reference has been reported.
            _ if object.children.iter().any(|child| self.index.resolve(child).is_none()) => None,
            _ => {
                let message = "shape `instance` needs a reference to one shapegroup: it is left out";
                self.diagnostics.error(object.span, message);
                None
            }
        }
    }

    /// If very many instances of one group begin at this child of the scene: reads them, and says which they were.
    pub(super) fn read_crowd(&mut self, first: usize) -> Option<Range<usize>> {
        let children: &'a [Child] = &self.root.children[first..];
        let Some(Child::Object(object)) = children.first() else {
            return None;
        };
        let (id, _) = bare_instance(&children[0])?;
        let group = self
            .index
            .get(id)
            .and_then(|group| self.group_of.get(&address(group)).copied())?;
        let of_group = |child| bare_instance(child).filter(|(other, _)| *other == id);
        let instances: Vec<&[TransformOp]> = children.iter().map_while(of_group).map(|(_, steps)| steps).collect();
        if instances.len() < CROWD {
            return None;
        }
        let range = first..first + instances.len();
        let order = self.order(object);
        let placements = Placements {
            places: instances.par_iter().map(|steps| TransformOp::compose(steps)).collect(),
            children: range.clone(),
        };
        let as_read = Object::new(Category::Shape, "instance");
        self.description.shapes.push(ShapeDescription {
            identity: Identity {
                name: format!("{} instances", instances.len()),
                order,
                ..self.identity(object, as_read)
            },
            shape: Shape {
                kind: ShapeKind::Instance,
                flip_normals: false,
            },
            to_world: bevy::math::Affine3A::IDENTITY,
            material: None,
            area_light: None,
            member_of: None,
            instance_of: Some(group),
            placements: Some(placements),
        });
        Some(range)
    }
}

/// The group and the place of an instance of which nothing else is said.
fn bare_instance(child: &Child) -> Option<(&str, &[TransformOp])> {
    let Child::Object(object) = child else { return None };
    let is_instance = object.category == Category::Shape && object.plugin == "instance" && object.id.is_none();
    match (&*object.properties, &*object.children) {
        ([place], [Child::Reference { name: None, id, .. }]) if is_instance && place.name == "to_world" => {
            match &place.value {
                Value::Transform(steps) => Some((id, steps)),
                _ => None,
            }
        }
        _ => None,
    }
}
