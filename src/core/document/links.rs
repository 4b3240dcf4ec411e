//! Checks references between objects: each needs a target, and they must not form a cycle.

use std::collections::{HashMap, HashSet};
use std::sync::Arc;

use smol_str::SmolStr;

use super::object::MAX_DEPTH;
use super::value::quote;
use super::{Child, Diagnostics, Index, Object, Severity, Span};

/// The most objects of a scene in which every reference is replaced by a copy. References to references to references,
/// each twice, grow exponentially; readers that follow them need a bound.
const MAX_EXPANDED: u64 = 50_000_000;

/// The help about a cycle names at most this many references.
const MOST_PLACES: usize = 8;

/// `<alias id="..." as="...">`: another name for an object.
#[derive(Debug)]
pub struct Alias {
    pub name: String,
    pub id: String,
    pub span: Span,
}

/// Replaces alias names in references by the object's own id, reports references without target (they stay), and
/// disconnects and reports those that close a cycle or nest too deep. `not_read`: an include whose file could not be
/// read, or the place from which on a file is broken. The missing objects may be there, so that references without
/// target are only counted then.
pub fn link(
    root: &mut Object,
    ids: &HashMap<SmolStr, Span>,
    aliases: &[Alias],
    not_read: Option<Span>,
    diagnostics: &mut Diagnostics,
) {
    let mut known = Known {
        ids,
        not_read,
        missed: 0,
    };
    let names = resolve_aliases(&mut known, aliases, diagnostics);
    check_references(root, &mut known, &names, diagnostics);
    if known.missed > 0 {
        let references = match known.missed {
            1 => "1 reference leads to an id".to_owned(),
            count => format!("{count} references lead to ids"),
        };
        let message = format!("{references} that nothing has, perhaps because this file could not be read");
        diagnostics.push(Severity::Note, not_read, message, None);
    }
    let index = Index::new(root);
    let mut walk = Walk {
        index: &index,
        diagnostics,
        measured: HashMap::new(),
        open: HashSet::new(),
        followed: Vec::new(),
        cut: HashSet::new(),
    };
    walk.measure(root, 0);
    let cut = walk.cut;
    if !cut.is_empty() {
        disconnect(root, &cut);
    }
}

/// The ids of a document.
struct Known<'i> {
    ids: &'i HashMap<SmolStr, Span>,
    not_read: Option<Span>,
    /// The number of references without target that were not reported.
    missed: usize,
}

/// Maps each alias to the id it stands for.
fn resolve_aliases<'a>(
    known: &mut Known,
    aliases: &'a [Alias],
    diagnostics: &mut Diagnostics,
) -> HashMap<&'a str, &'a str> {
    let mut names: HashMap<&str, &str> = HashMap::new();
    let ids = known.ids;
    for alias in aliases {
        let target = names.get(alias.id.as_str()).copied().unwrap_or(&alias.id);
        if ids.contains_key(alias.name.as_str()) || names.contains_key(alias.name.as_str()) {
            diagnostics.error(alias.span, format!("the id {} is given twice", quote(&alias.name)));
        } else if ids.contains_key(target) {
            names.insert(&alias.name, target);
        } else {
            known.report_missing(&alias.id, alias.span, diagnostics);
        }
    }
    names
}

impl Known<'_> {
    fn report_missing(&mut self, id: &str, span: Span, diagnostics: &mut Diagnostics) {
        if self.not_read.is_some() {
            self.missed += 1;
            return;
        }
        let help = diagnostics.did_you_mean(id, self.ids.keys().map(SmolStr::as_str));
        let message = format!("there is no object with the id {}", quote(id));
        diagnostics.push(Severity::Error, Some(span), message, help);
    }
}

fn check_references(
    object: &mut Object,
    known: &mut Known,
    names: &HashMap<&str, &str>,
    diagnostics: &mut Diagnostics,
) {
    for child in &mut object.children {
        match child {
            Child::Object(object) => check_references(Arc::make_mut(object), known, names, diagnostics),
            Child::Reference { id, .. } if known.ids.contains_key(id.as_str()) => {}
            Child::Reference { id, span, .. } => match names.get(id.as_str()) {
                Some(own_id) => *id = (*own_id).into(),
                None => known.report_missing(id, *span, diagnostics),
            },
        }
    }
}

/// The size of the subtree of an object, with references followed.
#[derive(Clone, Copy)]
struct Extent {
    height: usize,
    objects: u64,
}

struct Walk<'a, 'd> {
    index: &'a Index<'a>,
    diagnostics: &'d mut Diagnostics,
    /// The extents of the objects with ids.
    measured: HashMap<&'a str, Extent>,
    /// The objects with ids on the path from the root to the present one.
    open: HashSet<&'a str>,
    /// The references on the path from the root to the present object, with their ids.
    followed: Vec<(&'a str, Span)>,
    /// References to disconnect.
    cut: HashSet<Span>,
}

impl<'a> Walk<'a, '_> {
    /// Measures the subtree of an object. Recursion is bounded: references are followed to a `depth` of [`MAX_DEPTH`],
    /// and nested tags add at most as much again.
    fn measure(&mut self, object: &'a Object, depth: usize) -> Extent {
        if let Some(id) = &object.id {
            self.open.insert(id);
        }
        let mut extent = Extent { height: 0, objects: 1 };
        for child in &object.children {
            let below = match child {
                Child::Object(object) => Some(self.measure(object, depth + 1)),
                Child::Reference { id, span, .. } => self.follow(id, *span, depth + 1),
            };
            let Some(below) = below else { continue };
            let objects = extent.objects.saturating_add(below.objects);
            if objects > MAX_EXPANDED {
                let message = format!("references of references: more than {MAX_EXPANDED} objects in all");
                self.cut(child.span(), message);
                continue;
            }
            extent.objects = objects;
            extent.height = extent.height.max(below.height + 1);
        }
        if let Some(id) = &object.id {
            self.open.remove(id.as_str());
            self.measured.insert(id, extent);
        }
        extent
    }

    fn follow(&mut self, id: &'a str, span: Span, depth: usize) -> Option<Extent> {
        let target = self.index.get(id)?;
        if self.open.contains(id) {
            self.report_circle(id, span);
            return None;
        }
        let known = self.measured.get(id).copied();
        let height = known.map_or(0, |extent| extent.height);
        if depth + height > MAX_DEPTH {
            self.cut(span, format!("references lead more than {MAX_DEPTH} objects deep"));
            return None;
        }
        if known.is_some() {
            return known;
        }
        self.followed.push((id, span));
        let measured = self.measure(target, depth);
        self.followed.pop();
        Some(measured)
    }

    /// Reports a cycle. `span` is the reference that closes it; the help names the others, unless there are too many
    /// messages: finding a place takes time in proportion to the file.
    fn report_circle(&mut self, id: &'a str, span: Span) {
        // The object is open since a reference to it was followed, or since its declaration was entered.
        let first = self.followed.iter().position(|&(followed, _)| followed == id);
        let most = if self.diagnostics.has_many() { 0 } else { MOST_PLACES };
        let others = self.followed.iter().skip(first.map_or(0, |first| first + 1));
        let places: Vec<String> = others
            .filter_map(|&(id, span)| {
                let (path, line, column) = self.diagnostics.locate(span)?;
                Some(format!(
                    "{} is referred to at {}:{line}:{column}",
                    quote(id),
                    path.display()
                ))
            })
            .take(most)
            .collect();
        let message = format!("a circle of references leads back to {}", quote(id));
        let help = (!places.is_empty()).then(|| places.join(", "));
        self.diagnostics.push(Severity::Error, Some(span), message, help);
        self.cut.insert(span);
    }

    fn cut(&mut self, span: Span, message: String) {
        self.diagnostics.error(span, message);
        self.cut.insert(span);
    }
}

/// Gives the references at `cut` the empty id, which no object has. If they were removed, missing parts would be
/// reported as well.
fn disconnect(object: &mut Object, cut: &HashSet<Span>) {
    for child in &mut object.children {
        match child {
            Child::Reference { id, span, .. } if cut.contains(span) => *id = SmolStr::default(),
            Child::Reference { .. } => {}
            Child::Object(object) => disconnect(Arc::make_mut(object), cut),
        }
    }
}
