//! The names that things may have: free ones, found in one pass over the scene.

use bevy::platform::collections::{HashMap, HashSet};
use bevy::prelude::*;

use crate::scene::{AuthoredScene, DocumentOrder, SceneId};

/// Up to this number, stems are compared one by one.
const FEW: usize = 4;

/// The names that are taken and could be in the way of names with a number.
#[derive(Debug, Default)]
pub(crate) struct TakenNames {
    exact: HashSet<String>,
    /// The numbers that are taken of each stem, such as 3 of `ball` by `ball-3`; then those of folders, whose names
    /// end with a slash.
    numbers: [HashMap<String, HashSet<u32>>; 2],
}

impl TakenNames {
    /// Looks for names that are in the way of any of `wanted`.
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
        // Looking at the beginnings of all names is quicker than looking them up.
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

    /// The name, with a number if it is taken: see [`super::free_name::free_name`]. From now on the result is taken as
    /// well. The name must be among those that were looked for, or a result for one of them, or known to be free.
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

    /// Counts a name as taken.
    pub fn note(&mut self, name: &str) {
        self.note_number(name);
        self.exact.insert(name.to_owned());
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

/// The names of all that is in the scene.
pub fn names(world: &mut World) -> std::collections::HashSet<String> {
    let mut names = std::collections::HashSet::new();
    each_name(world, |name| {
        names.insert(name.to_owned());
    });
    names
}

/// Calls `visit` for the names of all that is in the scene, some of them twice. Names of the file also count.
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

/// The name without the slash of a folder, and whether there is one.
fn without_slash(name: &str) -> (&str, bool) {
    match name.strip_suffix('/') {
        Some(folder) => (folder, true),
        None => (name, false),
    }
}

/// The part of a wanted name before its number, the number, which is 1 for a name without one, and whether it is that
/// of a folder.
fn stem(wanted: &str) -> (&str, u32, bool) {
    let (wanted, is_folder) = without_slash(wanted);
    let parts = wanted.rsplit_once('-');
    let numbered = parts.and_then(|(stem, number)| Some((stem, number.parse().ok()?)));
    let (stem, number) = numbered.unwrap_or((wanted, 1));
    (stem, number, is_folder)
}

/// The stem and the number of a name as [`TakenNames::take`] makes them, and whether it is that of a folder.
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
