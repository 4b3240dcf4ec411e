//! Finds the objects of a document by their ids.

use std::collections::HashMap;

use super::{Child, Document, Object};

/// The objects that have ids. A parsed document has each id once, and no reference in it leads in a circle; one that
/// leads nowhere has been reported.
#[derive(Debug, Default)]
pub struct Index<'a> {
    by_id: HashMap<&'a str, &'a Object>,
}

impl<'a> Index<'a> {
    /// Walks the whole tree under `root`. If an id occurs twice, one of the two is found.
    pub fn new(root: &'a Object) -> Self {
        let mut by_id = HashMap::new();
        let mut waiting = vec![root];
        while let Some(object) = waiting.pop() {
            if let Some(id) = &object.id {
                by_id.entry(id.as_str()).or_insert(object);
            }
            waiting.extend(object.objects());
        }
        Self { by_id }
    }

    /// Returns the object with this id.
    pub fn get(&self, id: &str) -> Option<&'a Object> {
        self.by_id.get(id).copied()
    }

    /// The object that `child` stands for: itself, or the one it refers to. None if there is none of that id.
    pub fn resolve(&self, child: &'a Child) -> Option<&'a Object> {
        match child {
            Child::Object(object) => Some(object),
            Child::Reference { id, .. } => self.get(id),
        }
    }
}

impl Document {
    /// The index of the document, for readers that look up more than one id.
    pub fn index(&self) -> Index<'_> {
        Index::new(&self.root)
    }

    /// The object with this id; walks the whole tree.
    pub fn by_id(&self, id: &str) -> Option<&Object> {
        self.index().get(id)
    }
}
