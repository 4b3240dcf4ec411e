//! Crowds: very many consecutive instances of one group, stored as transforms and a range of the text instead of a
//! tree.
//!
//! A tree of a million instances takes more than half a gigabyte, although they are not edited one by one. The parser
//! therefore packs them while it reads ([`Packer`]); writing the scene rebuilds the tree (`unpack`).

use std::ops::Range;
use std::sync::Arc;

use glam::Affine3;
use smol_str::SmolStr;

use super::{Category, Child, SourceId, TransformOp, Value};

/// The least number of consecutive instances of one group that are packed.
pub(super) const FEWEST: usize = 1024;

/// Consecutive instances of one group, for which the file gives only the transforms.
#[derive(Clone, Debug, PartialEq)]
pub struct Crowd {
    /// The index of the child of the scene before which the crowd is inserted.
    pub position: usize,
    /// The id of the group.
    pub group: SmolStr,
    /// The transform of each instance, world from group.
    pub places: Arc<Vec<Affine3>>,
    pub(super) content: Content,
}

/// The data from which the children of the crowd are rebuilt.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Content {
    /// The bytes of a source text from the first instance to the last.
    Text { source: SourceId, range: Range<u32> },
    /// The children themselves, if the text alone cannot give them, for instance because of `$names`.
    Tree(Vec<Child>),
}

/// Packs instances as they become children of the scene.
#[derive(Debug, Default)]
pub(super) struct Packer {
    /// The crowds in the order of the file. The last one grows until another child follows it.
    crowds: Vec<Open>,
    /// The index from which all children are instances of one group, from one source.
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
    /// Call after adding a child to the `children` of the scene: packs it if it continues a run of instances. Its
    /// element ends at the byte `end` of `text`.
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

pub(super) fn places(run: &[Child]) -> Vec<Affine3> {
    let instances = run.iter().filter_map(BareInstance::of);
    instances
        .map(|instance| TransformOp::compose(instance.steps).into())
        .collect()
}

/// An instance with nothing but its group and its transform, and without keys.
pub(super) struct BareInstance<'a> {
    pub group: &'a SmolStr,
    pub steps: &'a [TransformOp],
}

impl<'a> BareInstance<'a> {
    pub fn of(child: &'a Child) -> Option<Self> {
        let Child::Object(object) = child else { return None };
        let is_instance = object.category == Category::Shape && object.plugin == "instance" && object.id.is_none();
        match (&*object.properties, &*object.children) {
            ([place], [Child::Reference { name: None, id, .. }])
                if is_instance && place.name == "to_world" && place.keys.is_none() =>
            {
                match &place.value {
                    Value::Transform(steps) => Some(Self { group: id, steps }),
                    _ => None,
                }
            }
            _ => None,
        }
    }
}
