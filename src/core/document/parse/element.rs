//! The meaning of each tag: plugins, values, references, defaults.

use smol_str::SmolStr;

use super::parser::Names;
use super::parser::{Frame, MAX_PROPERTIES, Parser};
use crate::document::links::Alias;
use crate::document::naming::{rename, snake_case};
use crate::document::parsed::{property_name, scene_unit};
use crate::document::property::{
    TRANSFORM_TAGS, VALUE_TAGS, color_of_spectrum, read_spectrum, read_transform_op, read_value,
};
use crate::document::source::read_text_within;
use crate::document::spectrum::{Role, SampledSpectrum};
use crate::document::tag::Tag;
use crate::document::value::quote;
use crate::document::{Category, Child, Object, Property, Severity, Span, TransformOp, Value};

impl Parser {
    pub(super) fn enter_root(&mut self, tag: &mut Tag, second: bool) -> Option<Frame> {
        if second {
            let message = format!("<{}> stands after the end of the scene", tag.name);
            self.diagnostics.error(tag.span, message);
            return None;
        }
        let Some(category) = Category::of_name(tag.name) else {
            let message = format!("a scene file starts with <scene>, not <{}>", tag.name);
            self.diagnostics.error(tag.span, message);
            return None;
        };
        match tag.take("version") {
            Some((version, span)) => self.check_version(&version, span),
            None => self
                .diagnostics
                .warn(tag.span, "no `version` is given; it is read as version 3.0.0"),
        }
        Some(self.object_frame(tag, category))
    }

    fn check_version(&mut self, version: &str, span: Span) {
        let parts: Result<Vec<u32>, _> = version.trim().split('.').map(str::parse).collect();
        match parts {
            Ok(parts) if parts.len() <= 3 => {
                if parts[0] > 3 {
                    let message = format!("version {} is newer than this reader, which knows 3", quote(version));
                    self.diagnostics.warn(span, message);
                }
            }
            _ => self.diagnostics.error(
                span,
                format!("expected a version like `3.0.0`, found {}", quote(version)),
            ),
        }
    }

    fn object_frame(&mut self, tag: &mut Tag, category: Category) -> Frame {
        let plugin = match category {
            Category::Scene => tag.take("type"),
            _ => tag.need("type", &mut self.diagnostics),
        };
        let mut object = Object::new(
            category,
            plugin.map_or_else(SmolStr::default, |(plugin, _)| plugin.into()),
        );
        object.span = tag.span;
        object.properties = self.spare.properties.take();
        object.children = self.spare.children.take();
        object.name = self.name_of(tag);
        object.id = tag.take("id").and_then(|(id, span)| self.register_id(id.into(), span));
        Frame::Object {
            object,
            names: Names::default(),
        }
    }

    fn name_of(&mut self, tag: &mut Tag) -> Option<SmolStr> {
        let (name, _) = tag.take("name")?;
        Some(snake_case(&name)).filter(|name| !name.is_empty())
    }

    /// Registers an id; None if it is not valid.
    fn register_id(&mut self, id: SmolStr, span: Span) -> Option<SmolStr> {
        if id.is_empty() {
            self.diagnostics.warn(span, "an empty id is ignored");
            return None;
        }
        if let Some(first) = self.ids.get(&id) {
            // Finding a place takes time in proportion to the file.
            let place = match self.diagnostics.has_many() {
                true => None,
                false => self.diagnostics.locate(*first),
            };
            let help =
                place.map(|(path, line, column)| format!("the first one is at {}:{line}:{column}", path.display()));
            let message = format!("the id {} is given twice", quote(&id));
            self.diagnostics.push(Severity::Error, Some(span), message, help);
            return None;
        }
        self.ids.insert(id.clone(), span);
        Some(id)
    }

    pub(super) fn enter_transform_op(&mut self, tag: &mut Tag, ops: &mut Vec<TransformOp>) -> Option<Frame> {
        if tag.name == "lookAt" {
            tag.name = "lookat";
        }
        let Some(known) = known(&TRANSFORM_TAGS, tag.name) else {
            let message = format!("<{}> is not a step of a transform", tag.name);
            let help = self.diagnostics.did_you_mean(tag.name, TRANSFORM_TAGS);
            self.diagnostics.push(Severity::Error, Some(tag.span), message, help);
            return None;
        };
        ops.extend(read_transform_op(tag, &mut self.diagnostics));
        Some(leaf(known, tag.span))
    }

    pub(super) fn enter_in_object(
        &mut self,
        tag: &mut Tag,
        object: &mut Object,
        names: &mut Names,
        depth: usize,
    ) -> Option<Frame> {
        let is_plugin = tag.name == "spectrum" && tag.has("type");
        if let Some(known) = known(&VALUE_TAGS, tag.name).filter(|_| !is_plugin) {
            self.read_property(tag, object, names);
            return Some(leaf(known, tag.span));
        }
        match tag.name {
            "scene" => {
                self.diagnostics
                    .error(tag.span, "<scene> cannot stand inside another tag");
                None
            }
            // A spectrum without a `type` is a value.
            "spectrum" => Some(self.object_frame(tag, Category::Texture)),
            "transform" => Some(Frame::Transform {
                name: self.property_name(tag),
                time: None,
                ops: self.spare.steps.take(),
                span: tag.span,
            }),
            "animation" => self.open_animation(tag, object.category).map(Frame::Animation),
            "ref" => {
                let id = tag.need("id", &mut self.diagnostics);
                let name = self.name_of(tag);
                if let Some((id, _)) = id {
                    object.children.push(Child::Reference {
                        name,
                        id: id.into(),
                        span: tag.span,
                    });
                }
                Some(leaf("ref", tag.span))
            }
            "default" => {
                let name = tag.need("name", &mut self.diagnostics);
                let given = tag.has("value");
                match (name, tag.take("value")) {
                    (Some((name, _)), Some((value, _))) => {
                        self.defines.add_default(&name, &value);
                        let unit = scene_unit(object, &name, &value).map(SmolStr::new_static);
                        // If there are several, the first one counts, as for all `<default>`s.
                        if let Some(own) = unit.or_else(|| property_name(&name))
                            && !names.contain(&own, &object.properties)
                        {
                            let value = Value::String(value.into_owned());
                            self.add_property(object, names, Property::new(own, value, tag.span));
                        }
                    }
                    (_, None) if !given => self
                        .diagnostics
                        .error(tag.span, "<default> needs the attribute `value`"),
                    _ => {}
                }
                Some(leaf("default", tag.span))
            }
            "alias" => {
                let id = tag.need("id", &mut self.diagnostics);
                let other = tag.need("as", &mut self.diagnostics);
                if let (Some((id, _)), Some((other, _))) = (id, other) {
                    self.aliases.push(Alias {
                        name: other.into_owned(),
                        id: id.into_owned(),
                        span: tag.span,
                    });
                }
                Some(leaf("alias", tag.span))
            }
            "path" => {
                if let Some((folder, span)) = tag.need("value", &mut self.diagnostics) {
                    self.add_search_folder(&folder, span);
                }
                Some(leaf("path", tag.span))
            }
            "include" => {
                let name = self.name_of(tag);
                if let Some((file, span)) = tag.need("filename", &mut self.diagnostics) {
                    self.include(&file, span, name, object, names, depth);
                }
                Some(leaf("include", tag.span))
            }
            name if TRANSFORM_TAGS.contains(&name) || name == "lookAt" => {
                let message = format!("<{name}> can only stand inside <transform>");
                self.diagnostics.error(tag.span, message);
                None
            }
            name => match Category::of_name(name) {
                Some(category) => Some(self.object_frame(tag, category)),
                None => {
                    let structure = ["transform", "animation", "ref", "default", "include", "path", "alias"];
                    let categories = Category::ALL.map(Category::name);
                    let known = VALUE_TAGS.into_iter().chain(structure).chain(categories);
                    let help = self.diagnostics.did_you_mean(name, known);
                    let message = format!("<{name}> is not known; it is ignored with all it contains");
                    self.diagnostics.push(Severity::Warning, Some(tag.span), message, help);
                    None
                }
            },
        }
    }

    pub(super) fn property_name(&mut self, tag: &mut Tag) -> Option<SmolStr> {
        let (name, _) = tag.need("name", &mut self.diagnostics)?;
        Some(snake_case(&name))
    }

    fn read_property(&mut self, tag: &mut Tag, object: &mut Object, names: &mut Names) {
        let name = self.property_name(tag);
        let value = if tag.name == "spectrum" {
            self.read_spectrum_tag(tag, object.category, name.as_deref().unwrap_or_default())
        } else {
            read_value(tag, &mut self.diagnostics)
        };
        if let (Some(name), Some(value)) = (name, value) {
            self.add_property(object, names, Property::new(name, value, tag.span));
        }
    }

    pub(super) fn read_spectrum_tag(&mut self, tag: &mut Tag, category: Category, name: &str) -> Option<Value> {
        let role = Role::of(category, name);
        if let Some((file, span)) = tag.take("filename") {
            let path = self.find_file(&file, span)?;
            let (access, diagnostics) = (&self.access, &self.diagnostics);
            let color = self.spectra.color(&path, role, || {
                let text = read_text_within(&path, access).map_err(|error| error.to_string())?;
                let parsed = SampledSpectrum::parse_file(text.trim_start_matches('\u{feff}'));
                parsed.map_err(|error| match diagnostics.is_outside(&path) {
                    // The message quotes the file.
                    true => {
                        format!("{file}: expected lines of a wavelength and a value, with wavelengths that increase")
                    }
                    false => format!("{file}: {error}"),
                })
            });
            return match color {
                Ok(color) => Some(color_of_spectrum(color, span, &mut self.diagnostics)),
                Err(message) => {
                    self.diagnostics.error(span, message);
                    None
                }
            };
        }
        let (text, span) = tag.need("value", &mut self.diagnostics)?;
        read_spectrum(&text, span, role, &mut self.diagnostics)
    }

    pub(super) fn add_property(&mut self, object: &mut Object, names: &mut Names, mut property: Property) {
        rename(object, &mut property.name);
        if object.properties.len() >= MAX_PROPERTIES {
            let message = format!(
                "{} has more than {MAX_PROPERTIES} parameters: the others are left out",
                object.title()
            );
            self.diagnostics.error(object.span, message);
        } else if !names.contain(&property.name, &object.properties) {
            object.properties.push(property);
        } else {
            let message = format!("{} is given twice in {}", quote(&property.name), object.title());
            self.diagnostics.error(property.span, message);
        }
    }
}

pub(super) fn leaf(tag: &'static str, span: Span) -> Frame {
    Frame::Leaf { tag, span }
}

/// The element of `names` that equals `name`.
pub(super) fn known(names: &[&'static str], name: &str) -> Option<&'static str> {
    names.iter().copied().find(|known| *known == name)
}
