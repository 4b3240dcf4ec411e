//! Finds the properties of a PLY element that are attributes of the mesh, under the names that Mitsuba gives them:
//!
//! - `r g b` or `red green blue` are `vertex_color` (`face_color` of faces);
//! - neighbours that share a prefix and end in `_x _y _z`, `_r _g _b`, `_0 _1 _2` or `_1 _2 _3` are `vertex_PREFIX`,
//!   with `_color` behind it for `_r _g _b`; one alone (`_x`, `_r`, `_0`, `_1`) is a number; other counts are left out,
//!   and so are properties without such an ending.
//!
//! Whole numbers stand for [0, 1], encoded as sRGB, as Mitsuba reads them (but for `uchar`, which its version 3.9
//! leaves at 0 to 255, unlike all others and its versions before). Alpha is not kept.

use std::collections::HashSet;

use super::attribute::{AttributeDomain, AttributeValues, MeshAttribute};
use super::mesh::MeshData;
use super::mesh_file::Warnings;
use super::ply_header::{Element, Kind, Property, Scalar};
use super::ply_records::Records;
use crate::color::linear_from_srgb;

/// The attributes of an element while it is read: values of a record are set in any order, then the record is pushed.
pub(super) struct Attributes {
    attributes: Vec<MeshAttribute>,
    /// The file type of each slot of a record.
    types: Vec<Scalar>,
    /// For each property of the element its slot in the record.
    places: Vec<Option<usize>>,
    record: Vec<f64>,
}

impl Attributes {
    /// Prepares for an element. `is_taken` says which properties are already used for geometry. About `expected`
    /// records will follow.
    pub fn new(element: &Element, domain: AttributeDomain, is_taken: impl Fn(&str) -> bool, expected: usize) -> Self {
        let mut result = Self {
            attributes: Vec::new(),
            types: Vec::new(),
            places: vec![None; element.properties.len()],
            record: Vec::new(),
        };
        let prefix = match domain {
            AttributeDomain::Vertex => "vertex_",
            AttributeDomain::Triangle => "face_",
        };
        for (name, members) in groups(&element.properties, is_taken) {
            let first = result.types.len();
            for (channel, &(property, scalar)) in members.iter().enumerate() {
                result.places[property] = Some(first + channel);
                result.types.push(scalar);
            }
            let numbers = expected * members.len();
            let values = match result.types[first..].iter().all(|&scalar| scalar == Scalar::U8) {
                true => AttributeValues::Srgb8(Vec::with_capacity(numbers)),
                false => AttributeValues::F32(Vec::with_capacity(numbers)),
            };
            result.attributes.push(MeshAttribute {
                name: format!("{prefix}{name}"),
                domain,
                channels: members.len(),
                values,
            });
        }
        result.record = vec![0.0; result.types.len()];
        result
    }

    /// The slot of a property in the record; `None` if it is no attribute.
    pub fn place_of(&self, property: usize) -> Option<usize> {
        self.places[property]
    }

    pub fn set(&mut self, place: usize, number: f64) {
        self.record[place] = number;
    }

    /// Reads the attributes of all records, each of one vertex or triangle.
    pub fn read(&mut self, records: &Records) {
        if self.attributes.is_empty() {
            return;
        }
        records.each(|number| {
            for (property, place) in self.places.iter().enumerate() {
                if let Some(place) = *place {
                    self.record[place] = number(property, self.types[place]);
                }
            }
            self.push(1);
        });
    }

    /// The memory of the values of one record, in bytes.
    pub fn bytes_per_record(&self) -> u64 {
        let bytes = |attribute: &MeshAttribute| match attribute.values {
            AttributeValues::Srgb8(_) => attribute.channels,
            AttributeValues::F32(_) => 4 * attribute.channels,
        };
        self.attributes.iter().map(bytes).sum::<usize>() as u64
    }

    /// Ends a record, whose values are repeated for `times` vertices or triangles.
    pub fn push(&mut self, times: usize) {
        let mut place = 0;
        for attribute in &mut self.attributes {
            let places = place..place + attribute.channels;
            place = places.end;
            for _ in 0..times {
                match &mut attribute.values {
                    AttributeValues::Srgb8(values) => {
                        values.extend(self.record[places.clone()].iter().map(|&n| n as u8))
                    }
                    AttributeValues::F32(values) => values.extend(
                        places
                            .clone()
                            .map(|place| linear_number(self.record[place], self.types[place])),
                    ),
                }
            }
        }
    }

    pub fn finish(mut self) -> Vec<MeshAttribute> {
        for attribute in &mut self.attributes {
            match &mut attribute.values {
                AttributeValues::Srgb8(values) => values.shrink_to_fit(),
                AttributeValues::F32(values) => values.shrink_to_fit(),
            }
        }
        self.attributes
    }
}

/// Drops the attributes of faces if there are also triangles of strips, which have none.
pub(super) fn drop_attributes_beside_strips(mesh: &mut MeshData, warnings: &mut Warnings) {
    let triangles = mesh.triangles.len();
    mesh.attributes.retain(|attribute| {
        let is_whole =
            attribute.domain == AttributeDomain::Vertex || attribute.values.len() == attribute.channels * triangles;
        if !is_whole {
            warnings.add(
                format_args!("attribute `{}`", attribute.name),
                "is ignored, because triangles of strips have no values",
            );
        }
        is_whole
    });
}

fn linear_number(number: f64, scalar: Scalar) -> f32 {
    match scalar.largest_whole() {
        Some(largest) => linear_from_srgb((number / largest) as f32),
        None => number as f32,
    }
}

/// The name of an attribute and its properties in order, with their types.
type Group = (String, Vec<(usize, Scalar)>);

fn groups(properties: &[Property], is_taken: impl Fn(&str) -> bool) -> Vec<Group> {
    let mut groups = Groups::default();
    let find = |name: &str| {
        let scalar_named = |(i, property): (usize, &Property)| match property.kind {
            Kind::Scalar(scalar) if property.name == name => Some((i, scalar)),
            _ => None,
        };
        properties.iter().enumerate().find_map(scalar_named)
    };
    for names in [["r", "g", "b"], ["red", "green", "blue"]] {
        if let [Some(r), Some(g), Some(b)] = names.map(find)
            && groups.list.is_empty()
        {
            groups.add("color".into(), vec![r, g, b]);
        }
    }
    let mut run = Run::default();
    for (i, property) in properties.iter().enumerate() {
        let split = property
            .name
            .rsplit_once('_')
            .filter(|(_, ending)| ending.len() == 1 && !is_taken(&property.name));
        match (split, property.kind) {
            (Some((prefix, ending)), Kind::Scalar(scalar)) => {
                if run.prefix != prefix {
                    run.finish(&mut groups);
                    run.prefix = prefix;
                }
                run.endings.push_str(ending);
                run.members.push((i, scalar));
            }
            _ => run.finish(&mut groups),
        }
    }
    run.finish(&mut groups);
    groups.list
}

/// Groups of properties in the order of the file, with unique names.
#[derive(Default)]
struct Groups {
    list: Vec<Group>,
    names: HashSet<String>,
}

impl Groups {
    fn add(&mut self, name: String, members: Vec<(usize, Scalar)>) {
        if self.names.insert(name.clone()) {
            self.list.push((name, members));
        }
    }
}

/// Neighbouring properties with the same prefix.
#[derive(Default)]
struct Run<'a> {
    prefix: &'a str,
    endings: String,
    members: Vec<(usize, Scalar)>,
}

impl Run<'_> {
    fn finish(&mut self, groups: &mut Groups) {
        let run = std::mem::take(self);
        let name = match &*run.endings {
            "x" | "xyz" | "0" | "012" | "1" | "123" => run.prefix.to_owned(),
            "r" | "rgb" => format!("{}_color", run.prefix),
            // Alpha is not kept.
            "rgba" => format!("{}_color", run.prefix),
            _ => return,
        };
        groups.add(name, run.members.into_iter().take(3).collect());
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn names(properties: &str) -> Vec<String> {
        let properties: Vec<Property> = properties
            .split_whitespace()
            .map(|name| Property {
                name: name.into(),
                kind: Kind::Scalar(Scalar::F32),
            })
            .collect();
        let groups = groups(&properties, |name| name == "texture_u");
        groups
            .iter()
            .map(|(name, members)| {
                let members: Vec<&str> = members.iter().map(|member| &*properties[member.0].name).collect();
                format!("{name}={}", members.join(","))
            })
            .collect()
    }

    #[test]
    fn groups_have_the_names_mitsuba_gives() {
        for (properties, expected) in [
            ("x y z nx ny nz", vec![]),
            ("x y z red green blue alpha", vec!["color=red,green,blue"]),
            ("b r a g", vec!["color=r,g,b"]),
            ("r g", vec![]),
            ("r g b red green blue", vec!["color=r,g,b"]),
            (
                "a_x a_y a_z b_0 c_1 c_2 c_3",
                vec!["a=a_x,a_y,a_z", "b=b_0", "c=c_1,c_2,c_3"],
            ),
            (
                "my_paint_r my_paint_g my_paint_b",
                vec!["my_paint_color=my_paint_r,my_paint_g,my_paint_b"],
            ),
            ("p_r p_g p_b p_a", vec!["p_color=p_r,p_g,p_b"]),
            // Two or four values, a wrong order, a gap, a suffix of more than one letter: no attribute.
            ("a_x a_y", vec![]),
            ("a_0 a_1 a_2 a_3", vec![]),
            ("a_z a_y a_x", vec![]),
            ("a_x other a_y a_z", vec!["a=a_x"]),
            ("texture_u texture_v material_index confidence", vec![]),
        ] {
            assert_eq!(names(properties), expected, "{properties}");
        }
    }
}
