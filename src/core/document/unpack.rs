//! Decides which instances of a scene stay packed in crowds, and unpacks crowds into children of the scene.

use std::collections::HashSet;
use std::sync::Arc;

use smol_str::SmolStr;

use super::crowd::{BareInstance, Content, FEWEST, places};
use super::parse::parse_children;
use super::{Child, Crowd, Diagnostics, Document, Object};

impl Crowd {
    /// The instances as children of the scene. `diagnostics` belong to the document of the crowd, and have its text.
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

/// Unpacks crowds whose group is not at the top level of the scene. They are errors, which are reported elsewhere.
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

/// Inserts the children of crowds, given in the order of their positions, at these positions.
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
