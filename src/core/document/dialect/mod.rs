//! Imports the course project's scene files (roots `ItemContainer` and `Scene`) as a document of the native format.
//!
//! The import follows the pictures of the project's own loader. Where these are not physical, or where the loader
//! ignores an explicit statement of a file, it makes a choice and notes it. Messages have the places of the original
//! file.

mod import;
mod known_files;
mod lights;
mod materials;
mod objects;
mod settings;
mod subsurface;
mod tree;

use std::collections::{HashMap, HashSet};
use std::sync::Arc;

use quick_xml::Reader;
use quick_xml::events::Event;

use self::import::Import;
use self::known_files::KnownFiles;
use self::materials::Materials;
use self::tree::{Node, Tree};
use super::value::quote;
use super::{Category, Diagnostics, Document, Object, Severity, SourceFile, SourceId, Span};
use crate::files::Access;

const ROOTS: [&str; 2] = ["ItemContainer", "Scene"];

/// The name on the command line (`-D rotation=radians`) that gives the unit of `<Rotation>`.
const ROTATION: &str = "rotation";

/// Whether the root element belongs to this dialect.
pub fn is_dialect(text: &str) -> bool {
    let mut reader = Reader::from_str(text);
    loop {
        match reader.read_event() {
            Ok(Event::Start(tag) | Event::Empty(tag)) => return ROOTS.contains(&tag.name().as_ref()),
            Ok(Event::Eof) | Err(_) => return false,
            Ok(_) => {}
        }
    }
}

/// The document of a scene of this dialect; `source` is its text without a byte order mark.
pub fn import(source: SourceFile, defines: &[(String, String)], access: Access) -> Document {
    let path = source.path.clone();
    let text = source.text.clone();
    let mut diagnostics = Diagnostics::default();
    diagnostics.sources.push(source);
    let mut document = Document {
        imported: true,
        ..Document::new(&path, Object::new(Category::Scene, ""))
    };
    match Tree::read(&text) {
        Ok(tree) => {
            let mut import = Import {
                path: &path,
                access: &access,
                radians: false,
                root: Object::new(Category::Scene, ""),
                files: KnownFiles::default(),
                ids: HashSet::new(),
                next_numbers: HashMap::new(),
                is_deep: false,
                diagnostics: &mut diagnostics,
            };
            import.read_defines(defines);
            import.read(tree.root());
            document.root = Arc::new(import.root);
        }
        Err((at, message)) => {
            let at = u32::try_from(at).unwrap_or(u32::MAX);
            let span = Span {
                source: SourceId(0),
                start: at,
                end: at,
            };
            diagnostics.error(span, format!("broken XML: {message}"));
        }
    }
    document.access = access;
    document.diagnostics = diagnostics;
    document
}

impl Import<'_> {
    fn read_defines(&mut self, defines: &[(String, String)]) {
        for (name, value) in defines {
            let message = match (name.as_str(), value.as_str()) {
                (ROTATION, "degrees") => continue,
                (ROTATION, "radians") => {
                    self.radians = true;
                    continue;
                }
                (ROTATION, _) => format!("-D {ROTATION}: expected `degrees` or `radians`, found {}", quote(value)),
                _ => format!("`-D {name}=...` has no effect: files of this kind have no names of values"),
            };
            self.diagnostics.push(Severity::Warning, None, message, None);
        }
    }

    fn read(&mut self, root: Node) {
        self.root.span = root.span();
        self.check_children(
            root,
            &[
                "Config",
                "Camera",
                "Lights",
                "Sun",
                "Materials",
                "Objects",
                "Environment",
            ],
        );
        self.check_attributes(root);
        self.read_settings(root);
        self.read_lights(root);
        let mut materials = Materials::default();
        self.read_materials(root, &mut materials);
        self.read_objects(root, &mut materials);
    }
}
