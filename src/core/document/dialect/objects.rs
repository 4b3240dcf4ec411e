//! Reads `<Objects>`: spheres, triangles, quads and meshes.

use std::path::Path;

use glam::{Mat4, Vec3, Vec4};

use super::import::Import;
use super::materials::{Look, Materials, black, grey};
use super::tree::Node;
use crate::document::paths::file_name;
use crate::document::value::quote;
use crate::document::{Category, Child, Object, Span, TransformOp, Value};

impl Import<'_> {
    pub fn read_objects(&mut self, root: Node, materials: &mut Materials) {
        let Some(list) = root.child(&["Objects"]) else {
            self.warn(root.span(), "there are no <Objects>");
            return;
        };
        self.check_children(list, &["Sphere", "Triangle", "Quad", "Mesh", "GLTF"]);
        let mut rotated = None;
        for node in list.children() {
            let shape = match node.name() {
                "Sphere" => self.sphere(node),
                "Triangle" => self.triangle(node),
                "Quad" => self.quad(node),
                "Mesh" => self.mesh(node, &mut rotated),
                "GLTF" => {
                    self.warn(
                        node.span(),
                        "glTF files are not read in scenes of this kind: the object is left out",
                    );
                    None
                }
                _ => None,
            };
            if let Some(shape) = shape {
                let shape = self.finish(node, shape, materials);
                self.add(shape);
            }
        }
        if let Some(span) = rotated {
            let message = match self.radians {
                true => "rotations are read as radians, as the original program does",
                false => {
                    "rotations are read as degrees, as the files mean them; the original program takes the numbers as radians (-D rotation=radians)"
                }
            };
            self.note(span, message);
        }
    }

    /// Gives a shape its name and its material.
    fn finish(&mut self, node: Node, mut shape: Object, materials: &mut Materials) -> Object {
        shape.id = self.free_id(node.text_of("name")).map(Into::into);
        let in_child = node.child(&["Material"]).and_then(|child| child.attribute("name"));
        let named = in_child.or_else(|| node.attribute("material"));
        let own_materials = shape.children.is_empty() && self.brings_materials(&shape);
        if own_materials {
            if let Some((name, span)) = named {
                let message = format!("the materials of the OBJ file win over {}", quote(&name));
                self.note(span, message);
            }
            return shape;
        }
        let look = named.and_then(|(name, span)| self.look(&name, span, materials));
        match look {
            Some(Look::Bsdf(id)) => shape.children.push(reference(None, id, node.span())),
            Some(Look::Subsurface {
                border,
                medium,
                surface,
            }) => match has_inside(&shape) {
                true => {
                    self.deepen(node.span());
                    shape.children.push(reference(None, border, node.span()));
                    shape.children.push(reference(Some("interior"), medium, node.span()));
                }
                false => {
                    let message = "only closed objects have an inside that light could scatter in: it is diffuse";
                    self.note(node.span(), message);
                    shape.children.push(reference(None, surface, node.span()));
                }
            },
            Some(Look::Light(radiance)) => {
                let closed = shape.plugin == "sphere";
                if !closed {
                    self.note(
                        node.span(),
                        "a light shines from its front; in the original from both sides",
                    );
                }
                let emitter = Object::new(Category::Emitter, "area").at(node.span());
                shape = shape
                    .with_child(emitter.with("radiance", Value::Rgb(radiance)))
                    .with_child(black(node.span()));
            }
            None => shape = shape.with_child(grey(node.span())),
        }
        shape
    }

    fn brings_materials(&mut self, shape: &Object) -> bool {
        let name = shape.properties.iter().find_map(|property| match &property.value {
            Value::String(name) if property.name == "filename" => Some(name),
            _ => None,
        });
        shape.plugin == "obj" && name.is_some_and(|name| self.has_own_materials(self.folder().join(name)))
    }

    /// Reads a sphere. `Scale` and `Rotation` neither stretch nor rotate it.
    fn sphere(&mut self, node: Node) -> Option<Object> {
        self.check_children(node, &["Radius", "Position", "Center", "Scale", "Rotation", "Material"]);
        let radius = self.value(node, &["Radius"]).unwrap_or(0.5).abs();
        let center = self.triple(node, &["Position", "Center"]).unwrap_or(Vec3::ZERO);
        if radius == 0.0 {
            self.warn(node.span(), "a sphere without a radius is left out");
            return None;
        }
        if let Some(scale) = self.triple(node, &["Scale"])
            && scale != Vec3::ONE
        {
            self.note(node.span(), "the original does not scale spheres: they stay round");
        }
        let object = shape("sphere", node.span());
        let object = object.with("center", Value::Point(center));
        Some(object.with("radius", Value::Float(radius)))
    }

    fn triangle(&mut self, node: Node) -> Option<Object> {
        self.check_children(
            node,
            &[
                "V0", "V1", "V2", "Vertex0", "Vertex1", "Vertex2", "Position", "Scale", "Rotation", "Material",
            ],
        );
        let names = [["V0", "Vertex0"], ["V1", "Vertex1"], ["V2", "Vertex2"]];
        let corners = names.map(|names| self.triple(node, &names));
        let [Some(a), Some(b), Some(c)] = corners else {
            if names.iter().any(|names| node.child(names).is_none()) {
                self.warn(node.span(), "a triangle without three corners is left out");
            }
            return None;
        };
        if (b - a).cross(c - a).try_normalize().is_none() {
            self.warn(node.span(), "a triangle without an area is left out");
            return None;
        }
        let object = shape("triangle", node.span());
        let object = object.with("v0", Value::Point(a)).with("v1", Value::Point(b));
        Some(object.with("v2", Value::Point(c)))
    }

    /// The parallelogram from `Position` along `U` and `V`, as a transformed square.
    fn quad(&mut self, node: Node) -> Option<Object> {
        self.check_children(node, &["Position", "U", "V", "Material"]);
        let corner = self.triple(node, &["Position"]).unwrap_or(Vec3::ZERO);
        let u = self.triple(node, &["U"]).unwrap_or(Vec3::X);
        let v = self.triple(node, &["V"]).unwrap_or(Vec3::Z);
        let Some(normal) = u.cross(v).try_normalize() else {
            self.warn(node.span(), "a quad without an area is left out");
            return None;
        };
        let axis = |v: Vec3| Vec4::from((v, 0.0));
        let center = Vec4::from((corner + 0.5 * (u + v), 1.0));
        let matrix = Mat4::from_cols(axis(0.5 * u), axis(0.5 * v), axis(normal), center);
        let steps = Value::Transform(vec![TransformOp::Matrix(matrix)]);
        Some(shape("rectangle", node.span()).with("to_world", steps))
    }

    fn mesh(&mut self, node: Node, rotated: &mut Option<Span>) -> Option<Object> {
        self.check_children(node, &["File", "Position", "Scale", "Rotation", "Material"]);
        let file = node.child(&["File"]).and_then(|file| file.attribute("name"));
        let Some((name, span)) = file else {
            self.warn(node.span(), "a mesh without a <File> is left out");
            return None;
        };
        let folder = self.folder();
        let Some(path) = self.find_file(&name) else {
            self.warn(
                span,
                format!("mesh not found: {}; the object is left out", quote(&name)),
            );
            return None;
        };
        let extension = path.extension().unwrap_or_default().to_ascii_lowercase();
        let plugin = match extension.to_str() {
            Some("ply") => "ply",
            Some("obj") => "obj",
            _ => {
                self.warn(
                    span,
                    format!("{} is neither OBJ nor PLY: the object is left out", quote(&name)),
                );
                return None;
            }
        };
        self.say_where_from(Path::new(&name), &path, &folder, span);
        let steps = self.steps(node, rotated)?;
        let object = shape(plugin, node.span());
        let object = object.with("filename", Value::String(file_name(&path, &folder)));
        let object = object.with("face_normals", Value::Boolean(true));
        Some(match steps.is_empty() {
            true => object,
            false => object.with("to_world", Value::Transform(steps)),
        })
    }

    fn say_where_from(&mut self, name: &Path, path: &Path, folder: &Path, span: Span) {
        if name.is_absolute() && name != path {
            let found = file_name(path, folder);
            self.note(
                span,
                format!(
                    "{} is not there; {found} takes its place",
                    quote(&name.to_string_lossy())
                ),
            );
        }
    }

    /// The transform: translation x rotation about x, y, z x scale, so that the scale applies first, then z. None
    /// (reported) if it makes the object vanish.
    fn steps(&mut self, node: Node, rotated: &mut Option<Span>) -> Option<Vec<TransformOp>> {
        let position = self.triple(node, &["Position"]).unwrap_or(Vec3::ZERO);
        let scale = self.triple(node, &["Scale"]).unwrap_or(Vec3::ONE);
        let rotation = self.triple(node, &["Rotation"]).unwrap_or(Vec3::ZERO);
        if scale.to_array().contains(&0.0) {
            self.warn(node.span(), "a mesh scaled by 0 is left out");
            return None;
        }
        let mut steps = Vec::new();
        if scale != Vec3::ONE {
            steps.push(TransformOp::Scale(scale));
        }
        for (axis, angle) in [(Vec3::Z, rotation.z), (Vec3::Y, rotation.y), (Vec3::X, rotation.x)] {
            if angle != 0.0 {
                let degrees = if self.radians { angle.to_degrees() } else { angle };
                steps.push(TransformOp::Rotate { axis, degrees });
                rotated.get_or_insert(node.span());
            }
        }
        if position != Vec3::ZERO {
            steps.push(TransformOp::Translate(position));
        }
        Some(steps)
    }
}

/// Whether a shape is closed; meshes are assumed to be.
fn has_inside(shape: &Object) -> bool {
    !matches!(&*shape.plugin, "rectangle" | "triangle")
}

fn reference(name: Option<&str>, id: String, span: Span) -> Child {
    Child::Reference {
        name: name.map(Into::into),
        id: id.into(),
        span,
    }
}

fn shape(plugin: &str, span: Span) -> Object {
    Object::new(Category::Shape, plugin).at(span)
}
