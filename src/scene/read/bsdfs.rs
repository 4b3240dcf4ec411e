//! Reads bsdfs, nested ones included.

use super::from_file::FromFile;
use super::picture_search::PictureSearch;
use super::scene_reader::{SceneReader, address};
use crate::document::{Category, Object, Reader, Severity};
use crate::scene::Material;
use crate::scene::components::description::{DeclarationPlace, MaterialDescription};
use crate::scene::encode::objects;

/// The deepest nesting of materials, through references too. More is an error: no scene needs it, and the stack is
/// finite.
const DEEPEST: usize = 32;

impl<'a> SceneReader<'a> {
    /// The index of this bsdf in the description; it is read once for all references. `place` is where it is declared
    /// if that is not the top level.
    pub(super) fn read_bsdf(&mut self, object: &'a Object, place: DeclarationPlace, depth: usize) -> usize {
        if let Some(&known) = self.material_of.get(&address(object)) {
            return known;
        }
        let index = self.description.materials.len();
        self.material_of.insert(address(object), index);
        self.description.materials.push(MaterialDescription {
            identity: Default::default(),
            material: Material::default(),
            first: None,
            second: None,
            declared_in: if self.is_top_level(object) {
                DeclarationPlace::TopLevel
            } else {
                place
            },
        });

        let reader = Reader::new(&self.index, object, &mut self.diagnostics);
        let (material, nested) = read_parameters(reader, &mut self.pictures);
        let mut inside = [None; 2];
        for (slot, inner) in inside.iter_mut().zip(nested) {
            if depth >= DEEPEST {
                let message = format!("{} is nested deeper than {DEEPEST} bsdfs", inner.title());
                self.diagnostics.error(object.span, message);
                break;
            }
            let read = self.read_bsdf(inner, DeclarationPlace::Material(index), depth + 1);
            *slot = Some(read);
            if material == Material::TwoSided && self.description.materials[read].material.refracts() {
                let message = format!("`{}` has two sides already: `twosided` does not take it", inner.plugin);
                self.diagnostics.error(inner.span, message);
            }
        }

        let identity = self.identity(object, |folder| objects::material(&material, folder));
        let description = &mut self.description.materials[index];
        description.identity = identity;
        description.material = material;
        [description.first, description.second] = inside;
        index
    }
}

/// The material and the bsdfs nested in it.
fn read_parameters<'a>(mut reader: Reader<'a, '_>, pictures: &mut PictureSearch) -> (Material, Vec<&'a Object>) {
    let plugin = reader.object().plugin.as_str();
    let Some(mut material) = Material::of_plugin(plugin) else {
        let message = format!("bsdf `{plugin}` is not supported: grey `diffuse` takes its place");
        let help = reader.diagnostics().did_you_mean(plugin, Material::PLUGINS);
        let span = reader.object().span;
        reader.diagnostics().push(Severity::Warning, Some(span), message, help);
        return (Material::default(), Vec::new());
    };
    let values = FromFile {
        reader: &mut reader,
        pictures,
    };
    values.read_all(&mut material);
    let nested = nested(&material, &mut reader);
    reader.finish();
    (material, nested)
}

/// The nested bsdfs; a wrong number of them is an error.
fn nested<'a>(material: &Material, reader: &mut Reader<'a, '_>) -> Vec<&'a Object> {
    let expected = &material.info().nested;
    if *expected.end() == 0 {
        return Vec::new();
    }
    let inside: Vec<&Object> = reader
        .children(Category::Bsdf)
        .into_iter()
        .map(|(_, object)| object)
        .collect();
    if !expected.contains(&inside.len()) && !reader.refers_to_nothing() {
        let wanted = match (expected.start(), expected.end()) {
            (1, 1) => "one bsdf",
            (2, 2) => "two bsdfs",
            _ => "one bsdf or two",
        };
        let message = format!("`{}` takes {wanted}, found {}", material.plugin(), inside.len());
        let span = reader.object().span;
        reader.diagnostics().error(span, message);
    }
    if *material == Material::TwoSided {
        reader.ignore(&["allow_transmission"]);
    }
    inside
}
