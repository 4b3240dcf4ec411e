//! The attributes that elements of this dialect have.

use super::import::Import;
use super::tree::Node;

impl Import<'_> {
    /// Warns of attributes that mean nothing, in the element and in all inside of it.
    pub fn check_attributes(&mut self, root: Node) {
        let mut waiting = vec![root];
        while let Some(node) = waiting.pop() {
            // The last one is taken first.
            let first = waiting.len();
            waiting.extend(node.children());
            waiting[first..].reverse();
            let Some(known) = known_attributes(node.name()) else {
                continue;
            };
            for (name, span) in node.attributes() {
                // Declarations of namespaces are XML's own.
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

/// The attributes of an element; None if the element itself is not known, which is said elsewhere.
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
