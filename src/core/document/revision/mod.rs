//! Writes a changed document over the text that it was read from: comments, layout, `<default>`s, `<include>`s and
//! unknown elements stay; only the elements of changed parts are touched.
//!
//! Two trees are traversed together, the one that was read and the one to be written, along with the text's elements.
//! Counterparts have the same [`Span`] in both; new parts have none.

mod additions;
pub(super) mod edits;
pub mod elements;
mod files;
mod keys;
mod source;
mod values;

use std::collections::{BTreeMap, HashMap};
use std::path::{Path, PathBuf};

use self::edits::Edit;
use self::elements::Element;
use self::files::FileNames;
pub use self::files::move_files;
use self::keys::Keys;
pub use self::source::{Destination, FindFile};
use self::source::{Place, Source, is_scene, position, span_of};
use self::values::revise_attribute;
use super::paths::settle;
use super::write::{WriteError, check_finite, property_to_block};
use super::{Child, Document, Object, Property, SourceId, Span, Value};

/// The files to write, the main one last. `origin` is the document as read; the spans of `now` point into it, and names
/// of files without a span are relative to its folder.
///
/// Changes in an included file are written there if the document keeps its folder and the file is included once;
/// otherwise its text replaces the `<include>`. So does the text of a file that other programs changed since, if the
/// document moves.
pub fn revise(
    origin: &Document,
    now: &Document,
    destination: &Destination,
) -> Result<Vec<(PathBuf, String)>, WriteError> {
    let origin = &origin.unpacked();
    let sources = Source::all(origin);
    let names = FileNames::new(origin, destination);
    let mut reviser = Reviser {
        sources: &sources,
        names: &names,
        in_place: settle(&origin.path) == destination.path,
        has_changed: destination.has_changed,
        includes: origin.includes.iter().map(|one| (one.span, one.source)).collect(),
        times_read: HashMap::new(),
        objects: HashMap::new(),
        revised: BTreeMap::new(),
    };
    for include in &origin.includes {
        *reviser.times_read.entry(include.source).or_insert(0) += 1;
    }
    reviser.list_objects(&origin.root);
    let main = SourceId(0);
    let edits = match reviser.source(main).elements.root() {
        Some(root) => {
            let place = Place {
                source: main,
                folder: names.target_folder,
            };
            reviser.object(root, &origin.root, &now.root, place)?
        }
        None => Vec::new(),
    };
    let mut files: Vec<(PathBuf, String)> = Vec::new();
    for (source, text) in std::mem::take(&mut reviser.revised) {
        files.push((sources[source].file.path.clone(), text));
    }
    files.push((destination.path.to_owned(), reviser.source(main).with(edits)));
    Ok(files)
}

/// An object before and after the change.
struct Pair<'a> {
    old: &'a Object,
    now: &'a Object,
    old_children: HashMap<Span, &'a Child>,
    /// The indices of the children of `now` from files; more than one if a file is included twice.
    now_children: HashMap<Span, Vec<usize>>,
    /// The element of each child of `now` in the edited text.
    elements: Vec<Option<usize>>,
    /// The children with an element, in the order they were found.
    found: Vec<usize>,
    last_property: Option<usize>,
}

impl<'a> Pair<'a> {
    fn new(old: &'a Object, now: &'a Object) -> Self {
        let mut now_children: HashMap<Span, Vec<usize>> = HashMap::new();
        for (index, child) in now.children.iter().enumerate() {
            if child.span() != Span::default() {
                now_children.entry(child.span()).or_default().push(index);
            }
        }
        Self {
            old,
            now,
            old_children: old.children.iter().map(|child| (child.span(), child)).collect(),
            now_children,
            elements: vec![None; now.children.len()],
            found: Vec::new(),
            last_property: None,
        }
    }

    /// The child of `now` at this span for which no element was found yet.
    fn next(&self, span: Span) -> Option<usize> {
        let candidates = self.now_children.get(&span)?;
        candidates.iter().copied().find(|&index| self.elements[index].is_none())
    }
}

struct Reviser<'r> {
    sources: &'r [Source<'r>],
    names: &'r FileNames<'r>,
    in_place: bool,
    has_changed: &'r dyn Fn(&Path) -> bool,
    includes: HashMap<Span, SourceId>,
    /// The number of times that each file is included.
    times_read: HashMap<SourceId, usize>,
    /// The objects that were read, by span.
    objects: HashMap<Span, &'r Object>,
    /// The new texts of included files.
    revised: BTreeMap<usize, String>,
}

impl<'r> Reviser<'r> {
    fn source(&self, id: SourceId) -> &'r Source<'r> {
        &self.sources[id.0 as usize]
    }

    fn list_objects(&mut self, root: &'r Object) {
        let mut waiting = vec![root];
        while let Some(object) = waiting.pop() {
            self.objects.insert(object.span, object);
            waiting.extend(object.objects());
        }
    }

    /// The edits that turn the element of `old` into that of `now`.
    fn object(&mut self, index: usize, old: &Object, now: &Object, place: Place) -> Result<Vec<Edit>, WriteError> {
        let source = self.source(place.source);
        let element = source.elements.get(index);
        let mut edits = Vec::new();
        for (name, old, now) in [
            ("type", Some(old.plugin.as_str()), Some(now.plugin.as_str())),
            ("id", old.id.as_deref(), now.id.as_deref()),
            ("name", old.name.as_deref(), now.name.as_deref()),
        ] {
            if old != now {
                edits.extend(revise_attribute(source.text(), element, name, now)?);
            }
        }
        let mut pair = Pair::new(old, now);
        for &child in &element.children {
            self.item(child, &mut pair, place, &mut edits)?;
        }
        self.add(index, &pair, place, &mut edits)?;
        Ok(edits)
    }

    /// Revises one element inside that of an object.
    fn item(&mut self, index: usize, pair: &mut Pair, place: Place, edits: &mut Vec<Edit>) -> Result<(), WriteError> {
        let source = self.source(place.source);
        let element = source.elements.get(index);
        let span = span_of(element, place.source);
        match element.name(source.text()) {
            "include" => return self.include(index, pair, place, edits),
            "path" => {
                edits.extend(self.names.revise_folder(source, element, place)?);
                return Ok(());
            }
            _ => {}
        }
        if let Some(property) = pair.old.properties.iter().find(|property| property.span == span) {
            let now = pair.now.properties.iter().find(|now| now.name == property.name);
            match now {
                Some(now) => {
                    pair.last_property = Some(index);
                    edits.extend(self.property(index, property, now, pair.now, place)?);
                }
                None => edits.push(Edit::delete(source.text(), element.range())),
            }
        } else if let Some(&child) = pair.old_children.get(&span) {
            match (pair.next(span), child) {
                (None, _) => edits.push(Edit::delete(source.text(), element.range())),
                (Some(next), child) => {
                    pair.elements[next] = Some(index);
                    pair.found.push(next);
                    match (child, &pair.now.children[next]) {
                        (Child::Object(old), Child::Object(now)) => edits.extend(self.object(index, old, now, place)?),
                        (Child::Reference { id: old, .. }, Child::Reference { id: now, .. }) if old != now => {
                            edits.extend(revise_attribute(source.text(), element, "id", Some(now))?);
                        }
                        _ => {}
                    }
                }
            }
        } else if is_superseded(source, element, pair) {
            edits.push(Edit::delete(source.text(), element.range()));
        }
        Ok(())
    }

    fn property(
        &self,
        index: usize,
        old: &Property,
        now: &Property,
        owner: &Object,
        place: Place,
    ) -> Result<Vec<Edit>, WriteError> {
        let source = self.source(place.source);
        let element = source.elements.get(index);
        let now = self.names.property_at(now, owner.category, place.folder);
        if (&now.value, &now.keys) == (&old.value, &old.keys) {
            // The value came from a file.
            return match element.name(source.text()) {
                "spectrum" => self.names.revise_name(source, element, place, None),
                _ => Ok(Vec::new()),
            };
        }
        check_finite(&now.value, &now.name, owner)?;
        let keys = Keys {
            source,
            owner,
            now: &now,
        };
        if let Some(edits) = keys.revise(index, old)? {
            return Ok(edits);
        }
        let margin = edits::margin_of_line(source.text(), element.tag.start);
        let block = property_to_block(&now, owner, margin, &source.layout)?;
        Ok(vec![Edit::replace(element.range(), block)])
    }

    /// Revises the objects from an included file, or replaces the include if it cannot stay.
    fn include(
        &mut self,
        index: usize,
        pair: &mut Pair,
        place: Place,
        edits: &mut Vec<Edit>,
    ) -> Result<(), WriteError> {
        let source = self.source(place.source);
        let element = source.elements.get(index);
        let name = element.attribute(source.text(), "filename");
        let name_span = name.map(|name| Span {
            source: place.source,
            start: position(name.value.start),
            end: position(name.value.end),
        });
        let Some(&included) = name_span.and_then(|span| self.includes.get(&span)) else {
            return Ok(());
        };
        let found_before = pair.found.len();
        let last_property = pair.last_property;
        let own_place = Place {
            source: included,
            folder: self.names.folder(included),
        };
        let changes = self.content(pair, own_place)?;
        let may_be_written = self.in_place && self.times_read.get(&included) == Some(&1);
        let can_stay = changes.is_empty() && (self.in_place || !(self.has_changed)(self.names.path(included)));
        if can_stay || may_be_written {
            if !changes.is_empty() {
                let text = self.source(included).with(changes);
                self.revised.insert(included.0 as usize, text);
            }
            let path = self.names.path(included);
            edits.extend(self.names.revise_name(source, element, place, Some(path))?);
        } else {
            // The names are revised once more, for the folder to which the text moves.
            for child in pair.found.drain(found_before..) {
                pair.elements[child] = None;
            }
            let changes = self.content(
                pair,
                Place {
                    source: included,
                    folder: place.folder,
                },
            )?;
            let block = self.content_as_block(included, changes, source, element);
            edits.push(Edit::replace(element.range(), block));
        }
        // New children that follow an object of the include come after the include.
        for &child in &pair.found[found_before..] {
            pair.elements[child] = Some(index);
        }
        if pair.last_property != last_property {
            pair.last_property = Some(index);
        }
        Ok(())
    }

    /// The edits of an included file.
    fn content(&mut self, pair: &mut Pair, place: Place) -> Result<Vec<Edit>, WriteError> {
        let source = self.source(place.source);
        let mut edits = Vec::new();
        let Some(root) = source.elements.root() else {
            return Ok(edits);
        };
        if is_scene(source, root) {
            for &child in &source.elements.get(root).children {
                self.item(child, pair, place, &mut edits)?;
            }
        } else {
            self.item(root, pair, place, &mut edits)?;
        }
        Ok(edits)
    }
}

/// Whether the property has an old name whose value became a part of `to_uv`: it is removed when `to_uv` is written.
fn is_superseded(source: &Source, element: &Element, pair: &Pair) -> bool {
    let value = |object: &Object| -> Option<Value> {
        let property = object.properties.iter().find(|property| property.name == "to_uv");
        property.map(|property| property.value.clone())
    };
    let name = element.attribute(source.text(), "name");
    let name = name.map(|name| &source.text()[name.value]);
    name.is_some_and(|name| ["uoffset", "voffset", "uscale", "vscale"].contains(&name))
        && value(pair.old) != value(pair.now)
}
