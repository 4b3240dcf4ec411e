//! The library of materials: those of `assets/materials.xml`, and the user's own from a file of the same kind in the settings folder.

use std::path::{Path, PathBuf};

use super::material_tree::MaterialTree;
use crate::document::{parse_str, parse_within};
use crate::files::{self, Access, FileError, LARGEST_NOTE};
use crate::scene::description::{DeclarationPlace, SceneDescription};
use crate::scene::read;

/// A material to choose.
#[derive(Clone, Debug, PartialEq)]
pub struct Preset {
    /// The part of its id before the `/`.
    pub group: String,
    /// The part of its id after the `/`.
    pub name: String,
    /// The tree of a material that is made from it.
    pub tree: MaterialTree,
}

impl Preset {
    /// The id that a material of the scene gets which is made from it.
    pub fn id(&self) -> String {
        self.name.replace(", ", "-").replace(' ', "-")
    }

    /// The path, such as `Metal/gold`, as in the file.
    pub fn path(&self) -> String {
        format!("{}/{}", self.group, self.name)
    }
}

const BUILT_IN: &str = include_str!("../../../../assets/materials.xml");

/// Loads all presets, and gives the problems with the user's file.
pub fn load() -> (Vec<Preset>, Vec<String>) {
    let mut presets = built_in();
    let mut complaints = Vec::new();
    if let Some(path) = own_file()
        && let Ok(text) = files::read_text(&path, LARGEST_NOTE)
    {
        let (own, wrong) = of_text(&text, &path);
        presets.extend(own);
        complaints = wrong;
    }
    (presets, complaints)
}

/// The longest file of materials in bytes; longer ones are scenes.
const LONGEST_MATERIALS: u64 = 1 << 20;

/// What an XML file holds.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum FileContent {
    /// Nothing but materials, of which this is the first.
    Materials(Box<Preset>),
    /// A scene with this number of shapes. None: it is too long to be read for that alone.
    Scene(Option<usize>),
}

/// Reads what an XML file holds. `access` is for the files that it includes.
pub(crate) fn content_of(path: &Path, access: Access) -> Result<FileContent, FileError> {
    let text = match files::read_text(path, LONGEST_MATERIALS) {
        Err(FileError::TooLarge { .. }) => return Ok(FileContent::Scene(None)),
        other => other?,
    };
    let mut document = parse_within(&*text, path, &[], access);
    let scene = read::read(&mut document);
    let is_bare = scene.shapes.is_empty() && scene.emitters.is_empty() && scene.sensors.is_empty();
    let is_whole = |place: &usize| scene.materials[*place].declared_in == DeclarationPlace::TopLevel;
    let first = (0..scene.materials.len()).find(is_whole).filter(|_| is_bare);
    let preset = first.map(|place| {
        let stem = || path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
        let id = scene.materials[place].identity.id.as_ref();
        let id = id.map_or_else(stem, |id| id.to_string());
        let (group, name) = id.split_once('/').unwrap_or(("Own", &id));
        Preset {
            group: group.to_owned(),
            name: name.to_owned(),
            tree: tree(&scene, place),
        }
    });
    let shapes = scene.shapes.len();
    Ok(preset.map_or(FileContent::Scene(Some(shapes)), |preset| {
        FileContent::Materials(Box::new(preset))
    }))
}

/// The presets that come with the program.
pub fn built_in() -> Vec<Preset> {
    of_text(BUILT_IN, Path::new("materials.xml")).0
}

/// The path of the user's presets, if there are any.
fn own_file() -> Option<PathBuf> {
    let folders = directories::ProjectDirs::from("", "", "sunroom")?;
    Some(folders.config_dir().join("materials.xml"))
}

/// The bsdfs of the file that have an id and are not inside another.
fn of_text(text: &str, path: &Path) -> (Vec<Preset>, Vec<String>) {
    let mut document = parse_str(text, path, &[]);
    let scene = read::read(&mut document);
    // The only message about the whole document is that it has no camera, as a scene would have.
    let whole = Some(document.root.span);
    let located = document.diagnostics.list.iter().filter(|told| told.span != whole);
    let complaints = located.map(|told| format!("{}: {}", path.display(), told.message));
    let presets = scene.materials.iter().enumerate().filter_map(|(place, material)| {
        let id = material.identity.id.as_ref()?;
        let is_whole = material.declared_in == DeclarationPlace::TopLevel;
        let (group, name) = id.split_once('/').unwrap_or(("Own", id));
        is_whole.then(|| Preset {
            group: group.to_owned(),
            name: name.to_owned(),
            tree: tree(&scene, place),
        })
    });
    (presets.collect(), complaints.collect())
}

/// Descriptions hold no circles.
fn tree(scene: &SceneDescription, place: usize) -> MaterialTree {
    let described = &scene.materials[place];
    let inside = described.first.into_iter().chain(described.second);
    MaterialTree {
        material: described.material.clone(),
        inside: inside.map(|place| tree(scene, place).into()).collect(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::parameters::ALPHA;
    use crate::scene::{ConductorIor, Ior, Material, ParameterInfo, ParameterRef, PrincipledIndex, Roughness};
    use crate::shading::ior;

    /// Whether the value could be that of a real material.
    fn is_possible(info: &ParameterInfo, value: ParameterRef) -> bool {
        match value {
            ParameterRef::Reflectance(color) | ParameterRef::Normals(color) => {
                // Only factors, which are 1, are whiter than fresh snow.
                let is_factor = info.name.starts_with("specular");
                let limit = if is_factor { 1.0 } else { 0.95 };
                color
                    .constant()
                    .is_some_and(|color| color.min_element() >= 0.0 && color.max_element() <= limit)
            }
            ParameterRef::Float(number) | ParameterRef::Height(number) => {
                number.constant().is_some_and(|number| info.range.contains(&number))
            }
            ParameterRef::Ior(index) => {
                let index = match index {
                    Ior::Named(known) => ior::dielectric_ior(known),
                    Ior::Number(number) => Some(*number),
                };
                index.is_some_and(|index| (1.0..=2.5).contains(&index))
            }
            ParameterRef::ConductorIor(index) => {
                matches!(index, ConductorIor::Named(name) if ior::conductor_ior(name).is_some())
            }
            ParameterRef::Roughness(roughness) | ParameterRef::UniformRoughness(roughness) => match roughness {
                Roughness::Isotropic(alpha) => alpha
                    .constant()
                    .is_some_and(|alpha| ALPHA.slider_range().contains(&alpha)),
                Roughness::Anisotropic { .. } => true,
            },
            ParameterRef::PrincipledIndex(index) => match index {
                PrincipledIndex::Specular(specular) => info.range.contains(specular),
                PrincipledIndex::Eta(_) => true,
            },
            _ => true,
        }
    }

    #[test]
    fn the_library_is_read_without_a_complaint_and_its_values_are_possible() {
        let (presets, complaints) = of_text(BUILT_IN, Path::new("materials.xml"));
        assert_eq!(complaints, [""; 0]);
        assert!(presets.len() >= 50, "{}", presets.len());
        for preset in &presets {
            preset.tree.material.visit(&mut |info, value| {
                let place = format!("{}/{} {}", preset.group, preset.name, info.name);
                assert!(is_possible(info, value), "{place}: {value:?}");
            });
            let twins = presets
                .iter()
                .filter(|other| other.name == preset.name && other.group == preset.group);
            assert_eq!(twins.count(), 1, "{}", preset.name);
        }
    }

    #[test]
    fn nested_materials_come_along() {
        let text = "<scene version='3.0.0'>
            <bsdf type='twosided' id='cloth'><bsdf type='diffuse' id='inner'/></bsdf>
            <bsdf type='diffuse'/></scene>";
        let (presets, _) = of_text(text, Path::new("own.xml"));
        let [Preset { group, name, tree }] = &presets[..] else {
            panic!("{presets:?}")
        };
        assert_eq!((group.as_str(), name.as_str()), ("Own", "cloth"));
        assert_eq!(*tree, MaterialTree::from(Material::default()).wrapped("twosided"));
    }
}
