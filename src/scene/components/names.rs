//! The names of things: finds free ones in one pass over the scene.

use bevy::platform::collections::{HashMap, HashSet};
use bevy::prelude::*;

use crate::scene::{AuthoredScene, DocumentOrder, SceneId};

/// Up to this number of stems, names are compared with them one by one.
const FEW: usize = 4;

/// The taken names that may collide with numbered names.
#[derive(Debug, Default)]
pub(crate) struct TakenNames {
    exact: HashSet<String>,
    /// For each stem the taken numbers, such as 3 for `ball` from `ball-3`; first for things, then for folders, whose
    /// names end with a slash.
    numbers: [HashMap<String, HashSet<u32>>; 2],
}

impl TakenNames {
    /// Collects names that may collide with any of `wanted`.
    pub fn like<'a>(world: &mut World, wanted: impl IntoIterator<Item = &'a str>) -> Self {
        let mut taken = Self::default();
        let mut names: HashSet<&str> = HashSet::default();
        for name in wanted {
            names.insert(name);
            let (stem, _, is_folder) = stem(name);
            taken.numbers[usize::from(is_folder)]
                .entry(stem.to_owned())
                .or_default();
        }
        let stems: Vec<String> = taken.numbers.iter().flat_map(HashMap::keys).cloned().collect();
        // Comparing the beginnings of all names is quicker than hash lookups.
        let is_far = |name: &str| stems.len() <= FEW && !stems.iter().any(|stem| name.starts_with(stem));
        each_name(world, |name| {
            if is_far(name) {
                return;
            }
            if names.contains(name) {
                taken.exact.insert(name.to_owned());
            }
            taken.note_number(name);
        });
        taken
    }

    fn note_number(&mut self, name: &str) {
        if let Some((stem, number, is_folder)) = numbered(name)
            && let Some(numbers) = self.numbers[usize::from(is_folder)].get_mut(stem)
        {
            numbers.insert(number);
        }
    }

    /// The name, with a number if it is taken, see [`super::free_name::free_name`]; the result is then taken as well.
    /// The name must be in `wanted` of [`Self::like`], a result for one of them, or known to be free.
    pub fn take(&mut self, wanted: &str) -> String {
        let name = if self.exact.contains(wanted) {
            let (stem, number, is_folder) = stem(wanted);
            let taken = self.numbers[usize::from(is_folder)].get(stem);
            let is_free = |number: &u32| taken.is_none_or(|taken| !taken.contains(number));
            let next = (number.saturating_add(1)..u32::MAX).find(is_free).unwrap_or(u32::MAX);
            format!("{stem}-{next}{}", if is_folder { "/" } else { "" })
        } else {
            wanted.to_owned()
        };
        self.note(&name);
        name
    }

    /// Marks a name as taken.
    pub fn note(&mut self, name: &str) {
        self.note_number(name);
        self.exact.insert(name.to_owned());
    }
}

/// The name `wanted`, with a number if it is taken in the scene.
pub(crate) fn free_name_for(world: &mut World, wanted: &str) -> String {
    TakenNames::like(world, [wanted]).take(wanted)
}

/// Whether this name is taken in the scene.
pub(crate) fn is_taken(world: &mut World, wanted: &str) -> bool {
    let mut found = false;
    each_name(world, |name| found |= name == wanted);
    found
}

/// All names in the scene.
pub fn names(world: &mut World) -> std::collections::HashSet<String> {
    let mut names = std::collections::HashSet::new();
    each_name(world, |name| {
        names.insert(name.to_owned());
    });
    names
}

/// Calls `visit` with all names in the scene, some of them twice. Names of the file also count.
pub(in crate::scene) fn each_name(world: &mut World, mut visit: impl FnMut(&str)) {
    if let Some(scene) = world.get_resource::<AuthoredScene>() {
        scene.foreign_ids.iter().for_each(|id| visit(id));
    }
    let mut named = world.query_filtered::<(Option<&SceneId>, Option<&Name>), With<DocumentOrder>>();
    for (id, name) in named.iter(world) {
        let id = id.map(|id| id.0.as_str());
        let name = name.map(Name::as_str);
        id.into_iter().for_each(&mut visit);
        name.filter(|_| id != name).into_iter().for_each(&mut visit);
    }
}

/// The name without the slash of a folder, and whether it had one.
fn without_slash(name: &str) -> (&str, bool) {
    match name.strip_suffix('/') {
        Some(folder) => (folder, true),
        None => (name, false),
    }
}

/// The stem of a wanted name, its number, which is 1 if it has none, and whether it is a folder.
fn stem(wanted: &str) -> (&str, u32, bool) {
    let (wanted, is_folder) = without_slash(wanted);
    let parts = wanted.rsplit_once('-');
    let numbered = parts.and_then(|(stem, number)| Some((stem, number.parse().ok()?)));
    let (stem, number) = numbered.unwrap_or((wanted, 1));
    (stem, number, is_folder)
}

/// The stem and the number of a name in the form of [`TakenNames::take`], and whether it is a folder.
fn numbered(name: &str) -> Option<(&str, u32, bool)> {
    let (name, is_folder) = without_slash(name);
    let (stem, digits) = name.rsplit_once('-')?;
    let is_plain = digits.bytes().all(|digit| digit.is_ascii_digit()) && (digits == "0" || !digits.starts_with('0'));
    Some((stem, digits.parse().ok().filter(|_| is_plain)?, is_folder))
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
        // From a result the search goes on.
        assert_eq!(taken.take("ball-5"), "ball-6");
    }
}
