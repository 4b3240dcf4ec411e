//! Very many instances of one group in a row, kept as places in space and a range of the text in place of a tree.
//!
//! A tree of a million instances takes more than half a gigabyte, although they are not edited one by one. The parser therefore packs them while it
//! reads ([`Packer`]); who writes the scene has the tree made again ([`Document::unpacked`]).

use std::collections::HashSet;
use std::ops::Range;
use std::sync::Arc;

use glam::Affine3;
use smol_str::SmolStr;

use super::parse::parse_children;
use super::{Category, Child, Diagnostics, Document, Object, SourceId, TransformOp, Value};

/// So many instances of one group in a row are packed.
const FEWEST: usize = 1024;

/// Instances of one group that follow each other in the scene, of which the file says nothing but their places.
#[derive(Clone, Debug, PartialEq)]
pub struct Crowd {
    /// The crowd stands before this child of the scene, or after the last one.
    pub position: usize,
    /// The id of the group.
    pub group: SmolStr,
    /// World from group.
    pub places: Arc<Vec<Affine3>>,
    content: Content,
}

/// What the crowd's children are made from again.
#[derive(Clone, Debug, PartialEq)]
enum Content {
    /// The bytes of a source text from the first instance to the last.
    Text { source: SourceId, range: Range<u32> },
    /// The children themselves, where the text alone does not give them: it has `$names`, say.
    Tree(Vec<Child>),
}

impl Crowd {
    /// The instances as children of the scene. `diagnostics`: those of the document that the crowd is part of, which have the text.
    pub fn children(&self, diagnostics: &Diagnostics) -> Vec<Child> {
        match &self.content {
            Content::Tree(children) => children.clone(),
            Content::Text { source, range } => match diagnostics.source(*source) {
                Some(file) => parse_children(file, *source, range.clone()),
                None => Vec::new(),
            },
        }
    }
}

impl Document {
    /// The document with all crowds as children of the scene.
    pub fn unpacked(&self) -> Self {
        let mut document = self.clone();
        let crowds = std::mem::take(&mut document.crowds);
        if !crowds.is_empty() {
            let root = Arc::make_mut(&mut document.root);
            unpack(root, crowds, &self.diagnostics);
        }
        document
    }
}

/// Packs instances as they become children of the scene.
#[derive(Debug, Default)]
pub(super) struct Packer {
    /// In the order of the file. The last one grows as long as no other child follows it.
    crowds: Vec<Open>,
    /// The last children from this one on are instances of one group, of one source.
    run: usize,
}

/// A crowd that may still grow.
#[derive(Debug)]
struct Open {
    position: usize,
    group: SmolStr,
    places: Vec<Affine3>,
    source: SourceId,
    range: Range<u32>,
}

impl Packer {
    /// A child has been added to the scene's `children`; its element ends at the byte `end` of `text`.
    pub fn note(&mut self, children: &mut Vec<Child>, text: &str, end: u32) {
        let Some((last, before)) = children.split_last() else {
            return;
        };
        let element = text.get(last.span().start as usize..end as usize);
        let Some(instance) = BareInstance::of(last).filter(|_| element.is_some_and(|text| !text.contains('$'))) else {
            self.run = children.len();
            return;
        };
        if let Some(crowd) = self.crowds.last_mut()
            && (crowd.position, crowd.source) == (before.len(), last.span().source)
            && crowd.group == *instance.group
        {
            crowd.places.push(TransformOp::compose(instance.steps).into());
            crowd.range.end = end;
            children.pop();
            return;
        }
        let continues = before.len() > self.run
            && before.last().is_some_and(|previous| {
                previous.span().source == last.span().source
                    && BareInstance::of(previous).is_some_and(|previous| previous.group == instance.group)
            });
        if !continues {
            self.run = before.len();
        }
        if children.len() - self.run < FEWEST {
            return;
        }
        let run: Vec<Child> = children.drain(self.run..).collect();
        self.crowds.extend(Open::new(self.run, &run, end));
    }

    pub fn finish(self) -> Vec<Crowd> {
        let pack = |open: Open| Crowd {
            position: open.position,
            group: open.group,
            places: Arc::new(open.places),
            content: Content::Text {
                source: open.source,
                range: open.range,
            },
        };
        self.crowds.into_iter().map(pack).collect()
    }
}

impl Open {
    fn new(position: usize, run: &[Child], end: u32) -> Option<Self> {
        let first = run.first()?;
        Some(Self {
            position,
            group: BareInstance::of(first)?.group.clone(),
            places: places(run),
            source: first.span().source,
            range: first.span().start..end,
        })
    }
}

/// Takes crowds apart whose group is not one at the top level of the scene: something is wrong with them, and others say what.
pub(super) fn keep_known(root: &mut Object, crowds: Vec<Crowd>, diagnostics: &Diagnostics) -> Vec<Crowd> {
    let groups = groups(root);
    let (mut known, mut unknown) = (Vec::new(), Vec::new());
    let mut added = 0;
    for mut crowd in crowds {
        if groups.contains(&crowd.group) {
            crowd.position += added;
            known.push(crowd);
        } else {
            added += crowd.places.len();
            unknown.push(crowd);
        }
    }
    unpack(root, unknown, diagnostics);
    known
}

/// Packs the instances that are still children of the scene, such as those of included files.
pub(super) fn pack_rest(root: &mut Object, crowds: Vec<Crowd>) -> Vec<Crowd> {
    if root.children.len() < FEWEST {
        return crowds;
    }
    let groups = groups(root);
    let group_of = |child: &Child| {
        let group = BareInstance::of(child).map(|instance| instance.group);
        group.filter(|group| groups.contains(*group)).cloned()
    };
    let mut packed = Vec::new();
    let mut kept = Vec::new();
    let mut open = crowds.into_iter().peekable();
    let mut children = std::mem::take(&mut root.children).into_iter().enumerate().peekable();
    while let Some((place, child)) = children.next() {
        while let Some(mut crowd) = open.next_if(|crowd| crowd.position <= place) {
            crowd.position = kept.len();
            packed.push(crowd);
        }
        let Some(group) = group_of(&child) else {
            kept.push(child);
            continue;
        };
        let end = open.peek().map_or(usize::MAX, |crowd| crowd.position);
        let mut run = vec![child];
        while let Some((_, next)) =
            children.next_if(|(place, next)| *place < end && group_of(next).as_ref() == Some(&group))
        {
            run.push(next);
        }
        if run.len() < FEWEST {
            kept.append(&mut run);
        } else {
            packed.push(Crowd {
                position: kept.len(),
                group,
                places: Arc::new(places(&run)),
                content: Content::Tree(run),
            });
        }
    }
    packed.extend(open.map(|crowd| Crowd {
        position: kept.len(),
        ..crowd
    }));
    kept.shrink_to_fit();
    root.children = kept;
    packed
}

/// The ids of the groups of shapes at the top level.
fn groups(root: &Object) -> HashSet<SmolStr> {
    let groups = root.objects().filter(|object| object.is_group());
    groups.filter_map(|group| group.id.clone()).collect()
}

fn places(run: &[Child]) -> Vec<Affine3> {
    let instances = run.iter().filter_map(BareInstance::of);
    instances
        .map(|instance| TransformOp::compose(instance.steps).into())
        .collect()
}

/// Puts the children of crowds, which are in the order of their positions, back where they stood.
fn unpack(root: &mut Object, crowds: Vec<Crowd>, diagnostics: &Diagnostics) {
    if crowds.is_empty() {
        return;
    }
    let old = std::mem::take(&mut root.children);
    let mut open = crowds.into_iter().peekable();
    for (place, child) in old.into_iter().enumerate() {
        while let Some(crowd) = open.next_if(|crowd| crowd.position <= place) {
            root.children.extend(crowd.children(diagnostics));
        }
        root.children.push(child);
    }
    for crowd in open {
        root.children.extend(crowd.children(diagnostics));
    }
}

/// An instance of which nothing is said but its group and its place.
struct BareInstance<'a> {
    group: &'a SmolStr,
    steps: &'a [TransformOp],
}

impl<'a> BareInstance<'a> {
    fn of(child: &'a Child) -> Option<Self> {
        let Child::Object(object) = child else { return None };
        let is_instance = object.category == Category::Shape && object.plugin == "instance" && object.id.is_none();
        match (&*object.properties, &*object.children) {
            ([place], [Child::Reference { name: None, id, .. }]) if is_instance && place.name == "to_world" => {
                match &place.value {
                    Value::Transform(steps) => Some(Self { group: id, steps }),
                    _ => None,
                }
            }
            _ => None,
        }
    }
}
