//! Copies of groups for instances in which box projections lay textures differently on their members.

use std::collections::{HashMap, HashSet};

use bevy::math::Affine3A;

use super::box_lying::{LyingBox, has_projection};
use super::shape_mesh::unit_form;
use crate::scene::components::description::{GroupDescription, Identity, SceneDescription, ShapeDescription};

/// The most copies of a group. Further instances show the first.
const MOST_COPIES: usize = 64;

/// The scene with a copy of each group for every set of coordinates that its members have in instances. None if each
/// group has one set. Crowds have that of their first instance.
pub(super) fn with_groups_by_box(scene: &SceneDescription) -> Option<SceneDescription> {
    let mut members: Vec<Vec<&ShapeDescription>> = vec![Vec::new(); scene.groups.len()];
    for shape in &scene.shapes {
        if let Some(group) = shape.member_of.filter(|_| has_projection(scene, shape)) {
            members[group].push(shape);
        }
    }
    let mut sets: Vec<Vec<Vec<Option<String>>>> = vec![Vec::new(); scene.groups.len()];
    let mut copy_of_instance: HashMap<usize, usize> = HashMap::new();
    for (index, shape) in scene.shapes.iter().enumerate() {
        let Some(group) = shape.instance_of.filter(|group| !members[*group].is_empty()) else {
            continue;
        };
        let places = shape.placements.as_ref();
        let first = places.and_then(|many| many.places.first().map(|place| Affine3A::from(*place)));
        let placement = first.unwrap_or(shape.to_world);
        let key = |member: &&ShapeDescription| {
            let shape_from_mesh = unit_form(&member.shape.kind).1;
            Some(LyingBox::of(scene, member, &shape_from_mesh, Some(&placement))?.key())
        };
        let keys: Vec<Option<String>> = members[group].iter().map(key).collect();
        let known = &mut sets[group];
        let copy = known.iter().position(|other| *other == keys).unwrap_or_else(|| {
            if known.len() >= MOST_COPIES {
                return 0;
            }
            known.push(keys);
            known.len() - 1
        });
        copy_of_instance.insert(index, copy);
    }
    let copies: Vec<usize> = sets.iter().map(|sets| sets.len().max(1)).collect();
    copies
        .iter()
        .any(|copies| *copies > 1)
        .then(|| copied(scene, &copies, &copy_of_instance))
}

/// The scene with so many copies of each group next to each other, and instances that show these copies.
fn copied(scene: &SceneDescription, copies: &[usize], copy_of_instance: &HashMap<usize, usize>) -> SceneDescription {
    let before: Vec<usize> = copies
        .iter()
        .scan(0, |sum, copies| {
            *sum += copies;
            Some(*sum - copies)
        })
        .collect();
    let identities = scene.shapes.iter().map(|shape| &shape.identity);
    let identities = identities.chain(scene.groups.iter().map(|group| &group.identity));
    let mut ids: HashSet<String> = identities.filter_map(|identity| identity.id.clone()).collect();
    let mut copy_of = |identity: &Identity, number: usize| Identity {
        id: identity.id.as_ref().map(|id| {
            let mut id = format!("{id}-{}", number + 1);
            while !ids.insert(id.clone()) {
                id.push('_');
            }
            id
        }),
        authored: None,
        ..identity.clone()
    };
    let mut groups = Vec::new();
    for (group, number) in scene.groups.iter().zip(copies) {
        groups.push(group.clone());
        let more = (1..*number).map(|copy| GroupDescription {
            identity: copy_of(&group.identity, copy),
        });
        groups.extend(more);
    }
    let mut shapes = Vec::new();
    for (index, shape) in scene.shapes.iter().enumerate() {
        let copy = copy_of_instance.get(&index).copied().unwrap_or(0);
        shapes.push(ShapeDescription {
            member_of: shape.member_of.map(|group| before[group]),
            instance_of: shape.instance_of.map(|group| before[group] + copy),
            ..shape.clone()
        });
        if let Some(group) = shape.member_of {
            let more = (1..copies[group]).map(|copy| ShapeDescription {
                identity: copy_of(&shape.identity, copy),
                member_of: Some(before[group] + copy),
                ..shape.clone()
            });
            shapes.extend(more);
        }
    }
    SceneDescription {
        groups,
        shapes,
        ..scene.clone()
    }
}
