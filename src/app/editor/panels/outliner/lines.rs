//! The lines of the list, in order: headings, folders, things. A name like `table/leg` is a leg in the folder table; a
//! nested material is listed under the one around it. A folder is listed once: lights and cameras in a folder of shapes
//! are listed there.

use std::borrow::Cow;
use std::collections::{HashMap, HashSet};
use std::ops::Range;
use std::sync::{Arc, Weak};

use bevy::prelude::Entity;

use super::search::Search;
use super::shared_folders::{Place, SharedFolders};
use crate::app::editor::model::item_list::ItemList;
use crate::app::editor::model::{Item, Outline};

/// The kind of an entity that holds a folder's transform.
const GROUP: &str = "group";

/// The depth below which nested materials and folders are shown at one level.
pub const DEEPEST: usize = 16;

#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Line {
    Heading {
        name: &'static str,
        count: usize,
    },
    /// A folder with its path and the number of things in it.
    Folder {
        path: String,
        depth: usize,
        members: Vec<Entity>,
        /// Whether all members are hidden; None if they cannot be.
        hidden: Option<bool>,
        /// Whether all members are locked.
        locked: bool,
        /// The entity that holds the folder's transform, if there is one.
        frame: Option<Entity>,
    },
    Item {
        /// The index into [`Outline::groups`], and below that the index within the group.
        group: usize,
        index: usize,
        depth: usize,
        /// Whether it has nested materials.
        has_inside: bool,
    },
}

/// The folders and things that are closed or open.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Folding {
    /// The closed headings and folders, by the names of their lines.
    pub closed: HashSet<String>,
    /// The materials that show their nested ones.
    pub open: HashSet<Entity>,
}

/// The lines of an outline, rebuilt only after a change: scenes of thousands of shapes are usual.
#[derive(Clone, Debug, Default)]
pub struct Lines {
    made_of: Option<(Weak<Outline>, String, Folding)>,
    lines: Arc<LineList>,
}

/// Lines in order. Plain things that follow each other in the outline are kept as a range.
#[derive(Clone, Debug, Default)]
pub struct LineList {
    /// The parts of the list, each with the number of lines before it.
    parts: Vec<(usize, Part)>,
    len: usize,
}

#[derive(Clone, Debug)]
enum Part {
    One(Line),
    /// Things of a group without nested ones.
    Run {
        group: usize,
        indices: Range<usize>,
        depth: usize,
    },
}

impl LineList {
    /// The number of lines.
    pub fn len(&self) -> usize {
        self.len
    }

    /// The line at this index; None beyond the last.
    pub fn get(&self, place: usize) -> Option<Cow<'_, Line>> {
        let part = self.parts.partition_point(|(before, _)| *before <= place);
        let (before, part) = self.parts.get(part.checked_sub(1)?)?;
        match part {
            Part::One(line) => (place == *before).then_some(Cow::Borrowed(line)),
            Part::Run { group, indices, depth } => {
                let index = indices.start + (place - before);
                let line = Line::Item {
                    group: *group,
                    index,
                    depth: *depth,
                    has_inside: false,
                };
                (index < indices.end).then_some(Cow::Owned(line))
            }
        }
    }

    /// All lines.
    pub fn iter(&self) -> impl Iterator<Item = Cow<'_, Line>> {
        (0..self.len).filter_map(|place| self.get(place))
    }

    /// The index of the line of a thing, given the index of its group and its index in the group.
    pub fn place_of(&self, wanted: (usize, usize)) -> Option<usize> {
        self.parts.iter().find_map(|(before, part)| match part {
            Part::One(Line::Item { group, index, .. }) => ((*group, *index) == wanted).then_some(*before),
            Part::One(_) => None,
            Part::Run { group, indices, .. } => {
                let is_here = *group == wanted.0 && indices.contains(&wanted.1);
                is_here.then(|| before + wanted.1 - indices.start)
            }
        })
    }

    /// The index of the line of a group, given the entity that holds its transform.
    pub fn place_of_group(&self, wanted: Entity) -> Option<usize> {
        let is_wanted = |part: &Part| matches!(part, Part::One(Line::Folder { frame, .. }) if *frame == Some(wanted));
        let found = self.parts.iter().find(|(_, part)| is_wanted(part));
        found.map(|(before, _)| *before)
    }

    /// The listed things.
    pub fn things(&self, outline: &Outline) -> impl Iterator<Item = Entity> {
        let groups = outline.groups();
        self.iter().filter_map(move |line| match *line {
            Line::Item { group, index, .. } => Some(groups[group].1[index].entity),
            _ => None,
        })
    }

    fn push(&mut self, line: Line) {
        let part = match line {
            Line::Item {
                group,
                index,
                depth,
                has_inside: false,
            } => {
                if let Some((
                    _,
                    Part::Run {
                        group: of,
                        indices,
                        depth: at,
                    },
                )) = self.parts.last_mut()
                    && (*of, *at, indices.end) == (group, depth, index)
                {
                    indices.end += 1;
                    self.len += 1;
                    return;
                }
                let indices = index..index + 1;
                Part::Run { group, indices, depth }
            }
            line => Part::One(line),
        };
        self.parts.push((self.len, part));
        self.len += 1;
    }

    fn push_run(&mut self, group: usize, indices: Range<usize>) {
        let count = indices.len();
        let depth = 0;
        self.parts.push((self.len, Part::Run { group, indices, depth }));
        self.len += count;
    }
}

impl Lines {
    /// The lines of things with `filter` in their name or kind. While there is a filter, everything is open.
    pub fn of(&mut self, outline: &Arc<Outline>, filter: &str, folding: &Folding) -> Arc<LineList> {
        let is_known = self.made_of.as_ref().is_some_and(|(known, filtered, folded)| {
            known.as_ptr() == Arc::as_ptr(outline) && filtered == filter && folded == folding
        });
        if !is_known {
            self.lines = Arc::new(lines(outline, filter, folding));
            self.made_of = Some((Arc::downgrade(outline), filter.to_owned(), folding.clone()));
        }
        self.lines.clone()
    }
}

/// The last part of a name.
pub fn leaf(name: &str) -> &str {
    name.rsplit('/').next().unwrap_or(name)
}

/// The folders that a name is in, outermost first.
pub fn folders_of(name: &str) -> impl Iterator<Item = &str> {
    name.match_indices('/').map(|(end, _)| &name[..end])
}

/// Whether the thing is the transform of a folder.
fn is_frame(item: &Item) -> bool {
    item.kind == GROUP && item.name.ends_with('/')
}

fn lines(outline: &Outline, filter: &str, folding: &Folding) -> LineList {
    let search = Search::new(filter, outline);
    let groups = outline.groups();
    let shared = SharedFolders::of(outline);
    let mut lines = LineList::default();
    for (group, (name, items)) in groups.into_iter().enumerate() {
        let takes_others = group == 0 && !shared.others.is_empty();
        if search.is_empty() && !items.is_empty() && items.is_flat() && !takes_others {
            lines.push(Line::Heading {
                name,
                count: items.len(),
            });
            if !folding.closed.contains(name) {
                lines.push_run(group, 0..items.len());
            }
            continue;
        }
        let is_wanted = |place: &Place| search.finds(groups[place.0].0, &groups[place.0].1[place.1]);
        let own = (0..items.len()).map(|index| (group, index));
        let own = own.filter(|place| !shared.others.contains(place));
        let others = shared.others.iter().copied().filter(|_| takes_others);
        let found: Vec<Place> = own.chain(others).filter(is_wanted).collect();
        if found.is_empty() {
            continue;
        }
        let (roots, inside) = nesting(&groups, &found);
        let count = roots.len();
        lines.push(Line::Heading { name, count });
        if search.is_empty() && folding.closed.contains(name) {
            continue;
        }
        let mut writer = Writer {
            groups: &groups,
            inside,
            folding: search.is_empty().then_some(folding),
            lines: &mut lines,
        };
        let (flat, nested): (Vec<Place>, _) = roots.into_iter().partition(|place| shared.repeated.contains(place));
        flat.into_iter().for_each(|place| writer.item(place, 0));
        writer.folder("", 0, &nested);
    }
    lines
}

/// The items of `found` that are nested in no other of them, and for each its nested items.
fn nesting(groups: &Groups, found: &[Place]) -> (Vec<Place>, HashMap<Entity, Vec<Place>>) {
    let item = |place: Place| &groups[place.0].1[place.1];
    let places: HashMap<Entity, Place> = found.iter().map(|&place| (item(place).entity, place)).collect();
    let outer = |place: Place| places.get(&item(place).inside_of?).copied();
    // A material that contains itself counts as nested in none.
    let is_deep = |place: Place| {
        let chain = std::iter::successors(outer(place), |&next| outer(next));
        chain.take(DEEPEST).count() == DEEPEST
    };
    let mut inside: HashMap<Entity, Vec<Place>> = HashMap::new();
    let mut roots = Vec::new();
    for &place in found {
        match outer(place).filter(|_| !is_deep(place)) {
            Some(outer) => inside.entry(item(outer).entity).or_default().push(place),
            None => roots.push(place),
        }
    }
    (roots, inside)
}

/// The lists with their headings.
type Groups<'a> = [(&'static str, &'a ItemList); 5];

struct Writer<'a> {
    groups: &'a Groups<'a>,
    inside: HashMap<Entity, Vec<Place>>,
    /// The folding. None: everything is open.
    folding: Option<&'a Folding>,
    lines: &'a mut LineList,
}

enum Entry<'a> {
    Item(Place),
    Folder(&'a str, Vec<Place>),
}

impl<'a> Writer<'a> {
    fn at(&self, (group, index): Place) -> &'a Item {
        &self.groups[group].1[index]
    }

    /// Adds the lines of the folder with this path (empty: of the top level): its folders, each at the position of its
    /// first member, and its things.
    fn folder(&mut self, path: &str, depth: usize, places: &[Place]) {
        let mut entries: Vec<Entry<'a>> = Vec::new();
        let mut known: HashMap<&str, usize> = HashMap::new();
        for &place in places {
            match self.folder_below(path, depth, place) {
                // The folder's own line stands for its transform.
                None if is_frame(self.at(place)) => {}
                None => entries.push(Entry::Item(place)),
                Some(name) => {
                    let entry = *known.entry(name).or_insert_with(|| {
                        entries.push(Entry::Folder(name, Vec::new()));
                        entries.len() - 1
                    });
                    if let Entry::Folder(_, members) = &mut entries[entry] {
                        members.push(place);
                    }
                }
            }
        }
        for entry in entries {
            match entry {
                Entry::Item(place) => self.item(place, depth),
                Entry::Folder(name, members) => {
                    let path = match path {
                        "" => name.to_owned(),
                        outer => format!("{outer}/{name}"),
                    };
                    let is_open = self.folding.is_none_or(|folding| !folding.closed.contains(&path));
                    let own = format!("{path}/");
                    let is_own = |place: &&Place| self.at(**place).name == own;
                    let frame = members.iter().find(is_own).map(|&place| self.at(place).entity);
                    let others = members.iter().filter(|place| !is_own(place));
                    let others = others.map(|&place| self.at(place).entity);
                    self.lines.push(Line::Folder {
                        path: path.clone(),
                        depth,
                        // The thing selected last becomes active.
                        members: others.chain(frame).collect(),
                        frame,
                        hidden: self.hidden(&members),
                        locked: members.iter().all(|&place| self.at(place).locked),
                    });
                    if is_open {
                        self.folder(&path, depth + 1, &members);
                    }
                }
            }
        }
    }

    /// Whether all of these are hidden; None if none of them can be.
    fn hidden(&self, members: &[Place]) -> Option<bool> {
        let mut can_hide = members.iter().map(|&place| self.at(place)).filter(|item| item.can_hide);
        let first = can_hide.next()?;
        Some(first.hidden && can_hide.all(|item| item.hidden))
    }

    /// The name of the subfolder that leads to this thing.
    fn folder_below(&self, path: &str, depth: usize, place: Place) -> Option<&'a str> {
        let name = self.at(place).name.trim_start_matches('/');
        let rest = name.get(path.len()..)?;
        let rest = rest.strip_prefix('/').unwrap_or(rest);
        let (folder, _) = rest.split_once('/')?;
        (depth < DEEPEST).then_some(folder)
    }

    fn item(&mut self, (group, index): Place, depth: usize) {
        let entity = self.at((group, index)).entity;
        let inside = self.inside.get(&entity).cloned().unwrap_or_default();
        self.lines.push(Line::Item {
            group,
            index,
            depth,
            has_inside: !inside.is_empty(),
        });
        if self.folding.is_none_or(|folding| folding.open.contains(&entity)) {
            for inner in inside {
                self.item(inner, depth + 1);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn item(number: u32, name: &str) -> Item {
        Item {
            entity: Entity::from_raw_u32(number).expect("a small number"),
            name: name.to_owned(),
            kind: "cube",
            hidden: false,
            locked: false,
            can_hide: true,
            inside_of: None,
            uses: None,
            properties: None,
        }
    }

    fn text(outline: &Outline, filter: &str, folding: &Folding) -> Vec<String> {
        let text = |line: &Line| match line {
            Line::Heading { name, count } => format!("{name} {count}"),
            Line::Folder { path, members, .. } => format!("[{path} {}]", members.len()),
            Line::Item {
                group, index, depth, ..
            } => format!("{depth} {}", leaf(&outline.groups()[*group].1[*index].name)),
        };
        lines(outline, filter, folding).iter().map(|line| text(&line)).collect()
    }

    #[test]
    fn folders_are_where_their_first_member_stands() {
        let outline = Outline {
            shapes: vec![
                item(1, "floor"),
                item(2, "table/leg"),
                item(3, "lamp"),
                item(4, "table/top/plate"),
            ]
            .into(),
            ..Outline::default()
        };
        let mut folding = Folding::default();
        let all = [
            "Shapes 4",
            "0 floor",
            "[table 2]",
            "1 leg",
            "[table/top 1]",
            "2 plate",
            "0 lamp",
        ];
        assert_eq!(text(&outline, "", &folding), all);
        folding.closed.insert("table".to_owned());
        assert_eq!(
            text(&outline, "", &folding),
            ["Shapes 4", "0 floor", "[table 2]", "0 lamp"]
        );
        assert_eq!(
            text(&outline, "plate", &folding),
            ["Shapes 1", "[table 1]", "[table/top 1]", "2 plate"]
        );
    }

    #[test]
    fn what_is_inside_a_material_is_under_it() {
        let mut materials = vec![item(1, "cloth"), item(2, "weave"), item(3, "round"), item(4, "about")];
        materials[1].inside_of = Some(materials[0].entity);
        // Two materials nested in each other, as a file may wrongly have them.
        materials[2].inside_of = Some(materials[3].entity);
        materials[3].inside_of = Some(materials[2].entity);
        let outline = Outline {
            materials: materials.into(),
            ..Outline::default()
        };
        let mut folding = Folding::default();
        assert_eq!(
            text(&outline, "", &folding),
            ["Materials 3", "0 cloth", "0 round", "0 about"]
        );
        folding.open.insert(outline.materials[0].entity);
        assert_eq!(text(&outline, "", &folding)[1..3], ["0 cloth", "1 weave"]);
        // A match is found at any depth.
        assert_eq!(text(&outline, "weave", &Folding::default()), ["Materials 1", "0 weave"]);
    }

    #[test]
    fn plain_things_are_ranges_among_folders_and_headings() {
        let shapes = (0..40).map(|number| item(number, if number == 20 { "room/door" } else { "wall" }));
        let outline = Outline {
            shapes: shapes.collect(),
            lights: vec![item(50, "lamp")].into(),
            ..Outline::default()
        };
        let list = lines(&outline, "", &Folding::default());
        assert_eq!((list.len(), list.parts.len()), (44, 7));
        assert!(list.get(44).is_none());
        for (place, line) in list.iter().enumerate() {
            if let Line::Item { group, index, .. } = *line {
                assert_eq!(list.place_of((group, index)), Some(place));
            }
        }
        assert_eq!(
            text(&outline, "", &Folding::default())[20..24],
            ["0 wall", "[room 1]", "1 door", "0 wall"]
        );
    }

    #[test]
    fn a_folder_with_shapes_and_lights_is_listed_once() {
        let mut group = item(1, "lamp/");
        group.kind = GROUP;
        let mut bulb = item(3, "lamp/bulb");
        bulb.kind = "point";
        let outline = Outline {
            shapes: vec![group, item(2, "lamp/shade"), item(5, "floor")].into(),
            // The shade shines as well.
            lights: vec![item(2, "lamp/shade"), bulb, item(4, "sky/sun")].into(),
            ..Outline::default()
        };
        let all = [
            "Shapes 4", "[lamp 3]", "1 shade", "1 bulb", "0 floor", "Lights 2", "0 shade", "[sky 1]", "1 sun",
        ];
        assert_eq!(text(&outline, "", &Folding::default()), all);
        assert_eq!(
            text(&outline, "bulb", &Folding::default()),
            ["Shapes 1", "[lamp 1]", "1 bulb"]
        );
    }

    #[test]
    fn folders_of_a_name_come_outermost_first() {
        assert_eq!(folders_of("a/b/c").collect::<Vec<_>>(), ["a", "a/b"]);
        assert_eq!(folders_of("lamp").count(), 0);
    }
}
