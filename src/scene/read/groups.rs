//! Reads `shapegroup` and `instance`.

use std::collections::HashSet;

use super::scene_reader::{SceneReader, address};
use crate::document::{Category, Object};
use crate::scene::components::description::{GroupDescription, Identity, ShapeDescription};
use crate::scene::{Placements, Shape, ShapeKind};

impl<'a> SceneReader<'a> {
    /// Lists all groups before the instances are read.
    pub(super) fn list_groups(&mut self) {
        for object in self.root.objects().filter(|object| object.is_group()) {
            let identity = self.identity(object, |_| Object::new(Category::Shape, "shapegroup"));
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
        let inside: HashSet<usize> = object.objects().map(address).collect();
        let mut left_out = Vec::new();
        for (place, (_, shape)) in shapes.into_iter().enumerate() {
            let is_member = if !inside.contains(&address(shape)) {
                let message = "the shapes of a shapegroup are written inside it: those it refers to are left out";
                self.diagnostics.warn(object.span, message);
                false
            } else if shape.is_group() || shape.plugin == "instance" {
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
            let children = authored.child_categories.iter().enumerate();
            let shapes = children.filter(|(_, category)| **category == Some(Category::Shape));
            let places: Vec<usize> = shapes.map(|(child, _)| child).collect();
            for shape in left_out {
                authored.leave_out(places[shape]);
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
            // A reference without target has been reported.
            _ if object.children.iter().any(|child| self.index.resolve(child).is_none()) => None,
            _ => {
                let message = "shape `instance` needs a reference to one shapegroup: it is left out";
                self.diagnostics.error(object.span, message);
                None
            }
        }
    }

    /// Reads the crowds of the document before this child of the scene, each as one shape. Returns the order of the
    /// last one in the file.
    pub(super) fn read_crowds(&mut self, position: usize) -> Option<u32> {
        let mut last = None;
        while let Some(crowd) = self
            .crowds
            .get(self.crowds_read)
            .filter(|crowd| crowd.position <= position)
        {
            let group = self.index.get(&crowd.group);
            let group = group.and_then(|group| self.group_of.get(&address(group)).copied());
            let order = self.crowd_orders.get(self.crowds_read).copied().unwrap_or_default();
            self.description.shapes.push(ShapeDescription {
                identity: Identity {
                    name: format!("{} instances", crowd.places.len()).into(),
                    order,
                    ..Identity::default()
                },
                shape: Shape {
                    kind: ShapeKind::Instance,
                    ..Shape::default()
                },
                to_world: bevy::math::Affine3A::IDENTITY,
                material: None,
                interior: None,
                exterior: None,
                area_light: None,
                member_of: None,
                instance_of: group,
                placements: Some(Placements {
                    places: crowd.places.clone(),
                }),
            });
            self.crowds_read += 1;
            last = Some(order);
        }
        last
    }
}
