//! The native scene under construction.
//!
//! Numbers: the original program reads them as C's `atof` does: text that is no number is 0, and trailing text is
//! ignored. Such text is a typing error, so that it is an error here, and the value counts as not given; an empty text
//! is 0 with a warning, as programs write it that know no value.

use std::collections::{HashMap, HashSet};
use std::path::{Path, PathBuf};

use glam::Vec3;

use super::known_files::KnownFiles;
use super::tree::Node;
use crate::document::paths::settle;
use crate::document::value::quote;
use crate::document::{Diagnostics, Object, Severity, Span};
use crate::files::Access;

/// A native scene under construction.
pub struct Import<'i> {
    pub path: &'i Path,
    pub access: &'i Access,
    /// Whether rotations are in radians; they are in degrees otherwise.
    pub radians: bool,
    pub root: Object,
    /// Cached facts about files.
    pub files: KnownFiles,
    /// Ids given so far.
    pub ids: HashSet<String>,
    /// The next number to try for a free id, for each name.
    pub next_numbers: HashMap<String, u32>,
    /// Whether the integrator already has the depth that subsurface scattering needs.
    pub is_deep: bool,
    pub diagnostics: &'i mut Diagnostics,
}

impl Import<'_> {
    /// Adds a note about a choice that the import made.
    pub fn note(&mut self, span: Span, message: impl Into<String>) {
        self.diagnostics.push(Severity::Note, Some(span), message.into(), None);
    }

    pub fn warn(&mut self, span: Span, message: impl Into<String>) {
        self.diagnostics.warn(span, message);
    }

    pub fn error(&mut self, span: Span, message: impl Into<String>) {
        self.diagnostics.error(span, message);
    }

    /// Warns of child elements with names not in `known`.
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

    /// A free id made from `name`; None without a name.
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

impl Import<'_> {
    /// The folder of the scene file, absolute.
    pub fn folder(&self) -> PathBuf {
        settle(self.path).parent().unwrap_or(Path::new("/")).to_owned()
    }

    /// Finds a file beside the scene, in the `assets` folders above it and above the working directory, then anywhere
    /// below these by its file name alone: an absolute name often belongs to its author's machine.
    pub fn find_file(&mut self, name: &str) -> Option<PathBuf> {
        let name = Path::new(name.trim());
        if name.as_os_str().is_empty() {
            return None;
        }
        let (folder, access) = (self.folder(), self.access);
        let started_in = std::env::current_dir().unwrap_or_default();
        let above = folder.ancestors().chain(started_in.ancestors());
        let assets = above
            .map(|folder| folder.join("assets"))
            .filter(|folder| folder.is_dir());
        let mut folders = vec![folder.clone()];
        for folder in assets {
            if !folders.contains(&folder) {
                folders.push(folder);
            }
        }
        // Joining an absolute name gives that name.
        let places: Vec<PathBuf> = folders.iter().map(|folder| folder.join(name)).collect();
        let direct = places.iter().find(|path| access.covers(path) && path.is_file());
        folders.retain(|folder| access.covers(folder));
        let by_name = || {
            let named = self.files.below(&folders).get(name.file_name()?)?;
            named.iter().find(|path| access.covers(path)).cloned()
        };
        let found = direct.cloned().or_else(by_name);
        if found.is_none() {
            // The result is not needed: `access` remembers the paths.
            access.find(&places);
        }
        Some(settle(&found?))
    }

    /// Whether an OBJ uses materials of an existing library.
    pub fn has_own_materials(&mut self, path: PathBuf) -> bool {
        self.files.has_own_materials(path, self.access)
    }
}

impl Import<'_> {
    /// Warns of unknown attributes in the subtree of an element.
    pub fn check_attributes(&mut self, root: Node) {
        let mut waiting = vec![root];
        while let Some(node) = waiting.pop() {
            // The list is popped from its end.
            let first = waiting.len();
            waiting.extend(node.children());
            waiting[first..].reverse();
            let Some(known) = known_attributes(node.name()) else {
                continue;
            };
            for (name, span) in node.attributes() {
                // Namespace declarations belong to XML itself.
                if known.contains(&name) || name.contains(':') || name == "xmlns" {
                    continue;
                }
                let has = match known {
                    [] => "has none".to_owned(),
                    _ => format!("has `{}`", known.join("`, `")),
                };
                let element = node.name();
                self.warn(
                    span,
                    format!("the attribute `{name}` is not known in <{element}>, which {has}; it is ignored"),
                );
            }
        }
    }
}

/// The attributes of an element; None for an unknown element, which is reported elsewhere.
fn known_attributes(element: &str) -> Option<&'static [&'static str]> {
    Some(match element {
        "ItemContainer" | "Scene" | "Config" | "Camera" | "Lights" | "Sun" | "PointLights" | "Materials"
        | "Objects" => &[],
        "Width" | "Height" | "Aspect_ratio" | "Samples_Per_Pixel" | "Samples" | "Max_Depth" | "Depth"
        | "Viewport_Width" | "Focal_Length" | "Aperture" | "Focus_Distance" | "Intensity" | "Strength" | "Fuzz"
        | "IOR" | "Refraction_Index" | "Metallic" | "Roughness" | "ScatterDistance" | "Radius" => &["value"],
        "FOV" => &["angle", "value"],
        "Look_From" | "LookFrom" | "Look_at" | "LookAt" | "Up" | "Direction" | "Dir" | "Position" | "Center"
        | "Scale" | "Rotation" | "V0" | "V1" | "V2" | "Vertex0" | "Vertex1" | "Vertex2" | "U" | "V" => &["x", "y", "z"],
        "Color" | "ScatterColor" => &["r", "g", "b"],
        "PointLight" => &["name", "enabled"],
        "Environment" => &["hdri", "intensity", "rotation"],
        "Lambertian" | "Metal" | "Dielectric" | "Emissive" | "PBR" | "GGX" | "SSS" | "File" | "Material" => &["name"],
        "Sphere" | "Triangle" | "Quad" | "Mesh" => &["name", "material"],
        _ => return None,
    })
}

impl Import<'_> {
    /// The attribute as a number; None if it is absent or no number.
    pub fn number(&mut self, node: Node, attribute: &str) -> Option<f32> {
        self.given(node, attribute).ok().flatten()
    }

    /// The attribute as a number; None if it is absent.
    fn given(&mut self, node: Node, attribute: &str) -> Result<Option<f32>, Slip> {
        let Some((text, span)) = node.attribute(attribute) else {
            return Ok(None);
        };
        if text.trim().is_empty() {
            self.warn(span, "expected a number, found nothing; it is read as 0");
            return Ok(Some(0.0));
        }
        let Some(number) = finite(&text) else {
            self.error(span, format!("expected a number, found {}", quote(&text)));
            return Err(Slip);
        };
        let bounded = number.clamp(-LARGEST_NUMBER, LARGEST_NUMBER);
        if bounded != number {
            self.warn(span, format!("{} is too large; it is read as {bounded}", quote(&text)));
        }
        Ok(Some(bounded))
    }

    /// The `value` of the first child element with one of these names.
    pub fn value(&mut self, node: Node, names: &[&str]) -> Option<f32> {
        self.number(node.child(names)?, "value")
    }

    /// The `x`, `y` and `z` of the first child element with one of these names; missing ones are 0.
    pub fn triple(&mut self, node: Node, names: &[&str]) -> Option<Vec3> {
        self.parts(node.child(names)?, ["x", "y", "z"])
    }

    /// Three attributes; missing ones are 0. None if one is no number.
    fn parts(&mut self, node: Node, names: [&str; 3]) -> Option<Vec3> {
        let [x, y, z] = names.map(|name| self.given(node, name).map(Option::unwrap_or_default));
        Some(Vec3::new(x.ok()?, y.ok()?, z.ok()?))
    }

    /// The `r`, `g` and `b` of the first child element with one of these names, not negative.
    pub fn color(&mut self, node: Node, names: &[&str]) -> Option<Vec3> {
        let node = node.child(names)?;
        let color = self.parts(node, ["r", "g", "b"])?;
        if color.min_element() < 0.0 {
            self.warn(node.span(), "a colour below 0 is read as 0");
        }
        Some(color.max(Vec3::ZERO))
    }
}

/// The largest number: products of three such numbers are finite.
const LARGEST_NUMBER: f32 = 1e12;

/// A text that is no number, which has been reported. Using a replacement value causes no further message.
struct Slip;

/// The text as a finite number.
fn finite(text: &str) -> Option<f32> {
    text.trim().parse().ok().filter(|number: &f32| number.is_finite())
}

#[cfg(test)]
mod tests {
    use super::finite;

    #[test]
    fn a_number_is_all_of_its_text() {
        for (text, expected) in [
            (" 1.5 ", Some(1.5)),
            ("-.5e1", Some(-5.0)),
            ("+3", Some(3.0)),
            ("2,5", None),
            ("3 m", None),
            ("1e", None),
            ("", None),
            ("red", None),
            ("nan", None),
            ("inf", None),
            // C would give infinity.
            ("1e99", None),
        ] {
            assert_eq!(finite(text), expected, "{text:?}");
        }
    }
}
