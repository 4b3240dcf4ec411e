//! The names that things may have: free ones, found in one pass over the scene.

use std::sync::{Arc, Weak};

use bevy::platform::collections::{HashMap, HashSet};
use bevy::prelude::*;
use smol_str::SmolStr;

use super::{Authored, AuthoredScene, DocumentOrder, SceneId};
use crate::document::{Document, Object};

/// The ids of a file whose elements became no entities, such as textures.
#[derive(Resource, Default)]
struct ForeignIds {
    /// The files that were looked through.
    of: Weak<Document>,
    ids: HashSet<String>,
}

/// The taken names among those that could be given to things of some names.
#[derive(Debug, Default)]
pub(crate) struct TakenNames {
    exact: HashSet<String>,
    /// The numbers that are taken of each stem, such as 3 of `ball` by `ball-3`.
    numbers: HashMap<String, HashSet<u32>>,
}

impl TakenNames {
    /// Looks for names that are in the way of any of `wanted`.
    pub fn like<'a>(world: &mut World, wanted: impl IntoIterator<Item = &'a str>) -> Self {
        let mut taken = Self::default();
        let mut names: HashSet<&str> = HashSet::default();
        for name in wanted {
            names.insert(name);
            taken.numbers.entry(stem(name).0.to_owned()).or_default();
        }
        each_name(world, |name| {
            if names.contains(name) {
                taken.exact.insert(name.to_owned());
            }
            if let Some((stem, number)) = numbered(name)
                && let Some(numbers) = taken.numbers.get_mut(stem)
            {
                numbers.insert(number);
            }
        });
        taken
    }

    /// The name, which must be among those that were looked for, with a number if it is taken. From now on the result is taken as well.
    pub fn take(&mut self, wanted: &str) -> String {
        let name = if self.exact.contains(wanted) {
            let (stem, number) = stem(wanted);
            let taken = self.numbers.get(stem);
            let is_free = |number: &u32| taken.is_none_or(|taken| !taken.contains(number));
            let next = (number.saturating_add(1)..u32::MAX).find(is_free).unwrap_or(u32::MAX);
            format!("{stem}-{next}")
        } else {
            wanted.to_owned()
        };
        if let Some((stem, number)) = numbered(&name)
            && let Some(numbers) = self.numbers.get_mut(stem)
        {
            numbers.insert(number);
        }
        self.exact.insert(name.clone());
        name
    }
}

/// The name `wanted`, with a number if something in the scene has it.
pub(crate) fn free_name_for(world: &mut World, wanted: &str) -> String {
    TakenNames::like(world, [wanted]).take(wanted)
}

/// Whether something in the scene has this name.
pub(crate) fn is_taken(world: &mut World, wanted: &str) -> bool {
    let mut found = false;
    each_name(world, |name| found |= name == wanted);
    found
}

/// Calls `visit` for the names of all that is in the scene, some of them twice. Names of the file also count.
pub(super) fn each_name(world: &mut World, mut visit: impl FnMut(&str)) {
    foreign_ids(world).iter().for_each(|id| visit(id));
    let mut named = world.query_filtered::<(Option<&SceneId>, Option<&Name>), With<DocumentOrder>>();
    for (id, name) in named.iter(world) {
        let id = id.map(|id| id.0.as_str());
        let name = name.map(Name::as_str);
        id.into_iter().for_each(&mut visit);
        name.filter(|_| id != name).into_iter().for_each(&mut visit);
    }
}

fn foreign_ids(world: &mut World) -> &HashSet<String> {
    let scene = world.get_resource::<AuthoredScene>();
    let origin = scene.and_then(|scene| scene.origin.clone());
    let known = world.get_resource_or_init::<ForeignIds>();
    let wanted = origin.as_ref().map_or_else(Weak::new, Arc::downgrade);
    if !known.of.ptr_eq(&wanted) {
        let mut ids = HashSet::default();
        if let Some(origin) = &origin {
            collect_ids(&origin.root, &mut ids);
        }
        let mut authored = world.query::<&Authored>();
        for authored in authored.iter(world) {
            if let Some(id) = &authored.object.id {
                ids.remove(id.as_str());
            }
        }
        world.insert_resource(ForeignIds { of: wanted, ids });
    }
    &world.get_resource_or_init::<ForeignIds>().into_inner().ids
}

fn collect_ids(object: &Object, ids: &mut HashSet<String>) {
    ids.extend(object.id.as_ref().map(SmolStr::to_string));
    object.objects().for_each(|inner| collect_ids(inner, ids));
}

/// The part of a wanted name before its number, and the number; 1 for a name without one.
fn stem(wanted: &str) -> (&str, u32) {
    let parts = wanted.rsplit_once('-');
    let numbered = parts.and_then(|(stem, number)| Some((stem, number.parse().ok()?)));
    numbered.unwrap_or((wanted, 1))
}

/// The stem and the number of a name as [`TakenNames::take`] makes them.
fn numbered(name: &str) -> Option<(&str, u32)> {
    let (stem, digits) = name.rsplit_once('-')?;
    let is_plain = digits.bytes().all(|digit| digit.is_ascii_digit()) && (digits == "0" || !digits.starts_with('0'));
    Some((stem, digits.parse().ok().filter(|_| is_plain)?))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn world(names: &[&str]) -> World {
        let mut world = World::new();
        for (name, order) in names.iter().zip(0..) {
            world.spawn((DocumentOrder(order), SceneId((*name).to_owned())));
        }
        world
    }

    #[test]
    fn several_get_names_one_after_the_other() {
        let mut world = world(&["ball", "ball-3", "lamp"]);
        let wanted = ["ball", "lamp", "ball", "ball-3", "sky", "sky"];
        let mut taken = TakenNames::like(&mut world, wanted);
        let given = wanted.map(|name| taken.take(name));
        assert_eq!(given, ["ball-2", "lamp-2", "ball-4", "ball-5", "sky", "sky-2"]);
    }
}
