//! The native scene while it grows.

use std::collections::{HashMap, HashSet};
use std::path::Path;

use super::known_files::KnownFiles;
use super::tree::Node;
use crate::document::{Diagnostics, Object, Severity, Span};
use crate::files::Access;

/// A native scene while it grows.
pub struct Import<'i> {
    pub path: &'i Path,
    pub access: &'i Access,
    /// Whether rotations are in radians; they are in degrees otherwise.
    pub radians: bool,
    pub root: Object,
    /// What is known of files.
    pub files: KnownFiles,
    /// Ids given so far.
    pub ids: HashSet<String>,
    /// The number that the next thing of this name may get.
    pub next_numbers: HashMap<String, u32>,
    /// Whether the integrator goes as deep as light below surfaces needs.
    pub is_deep: bool,
    pub diagnostics: &'i mut Diagnostics,
}

impl Import<'_> {
    /// A remark on a choice that was made.
    pub fn note(&mut self, span: Span, message: impl Into<String>) {
        self.diagnostics.push(Severity::Note, Some(span), message.into(), None);
    }

    pub fn warn(&mut self, span: Span, message: impl Into<String>) {
        self.diagnostics.warn(span, message);
    }

    pub fn error(&mut self, span: Span, message: impl Into<String>) {
        self.diagnostics.error(span, message);
    }

    /// Warns of elements that are none of these.
    pub fn check_children(&mut self, node: Node, known: &[&str]) {
        for child in node.children() {
            if !known.contains(&child.name()) {
                let help = self.diagnostics.did_you_mean(child.name(), known.iter().copied());
                let message = format!("<{}> is not known in <{}>; it is ignored", child.name(), node.name());
                self.diagnostics
                    .push(Severity::Warning, Some(child.span()), message, help);
            }
        }
    }

    pub fn add(&mut self, object: Object) {
        self.root.children.push(object.into());
    }

    /// An id like `name` that nothing has yet; None for a thing without a name.
    pub fn free_id(&mut self, name: Option<String>) -> Option<String> {
        let name = name.filter(|name| !name.trim().is_empty())?;
        if self.ids.insert(name.clone()) {
            return Some(name);
        }
        let number = self.next_numbers.entry(name.clone()).or_insert(2);
        loop {
            let id = format!("{name}-{number}");
            *number += 1;
            if self.ids.insert(id.clone()) {
                return Some(id);
            }
        }
    }
}
