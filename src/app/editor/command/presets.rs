//! The library of materials: those of `assets/materials.xml` and, with textures, of `assets/surfaces.xml`, and the
//! user's own from a file of the same kind in the settings folder.
//!
//! A material with a medium below its surface is a shape there, with the medium as its interior. Textures that box
//! projection lays on shapes are in metres, with y upwards.

use std::path::{Path, PathBuf};

use bevy::math::{Affine2, Vec2, Vec3};

use super::material_tree::{Inside, MaterialTree};
use crate::color::Rgb;
use crate::document::{parse_str, parse_within};
use crate::files::{self, Access, FileError, LARGEST_NOTE};
use crate::scene::description::{DeclarationPlace, SceneDescription};
use crate::scene::{Declared, LengthUnit, Material, Medium, read};

/// An entry of the library.
#[derive(Clone, Debug, PartialEq)]
pub struct Preset {
    /// The part of its id before the `/`.
    pub group: String,
    /// The part of its id after the `/`.
    pub name: String,
    /// The tree of the material, with lengths in metres and y upwards.
    pub tree: MaterialTree,
    /// The medium inside of shapes with the material, with its coefficients per millimetre.
    pub medium: Option<Medium>,
}

impl Preset {
    /// The id of a material of the scene that is made from it.
    pub fn id(&self) -> String {
        self.name.replace(", ", "-").replace(' ', "-")
    }

    /// The tree of the material in a scene of this unit of length, in which the direction `up` is up.
    pub fn tree_in(&self, unit: LengthUnit, up: Vec3) -> MaterialTree {
        let mut tree = self.tree.clone();
        fit(
            &mut tree,
            unit.metres() as f32,
            if up.z.abs() > 0.5 { "z" } else { "y" },
        );
        tree
    }

    /// The medium in a scene of this unit of length.
    pub fn medium_in(&self, unit: LengthUnit) -> Option<Medium> {
        self.medium_at(1000.0 * unit.metres() as f32)
    }

    /// The medium in a scene whose unit is so many millimetres.
    pub fn medium_at(&self, millimetres: f32) -> Option<Medium> {
        let medium = self.medium.clone()?;
        // A scale of zero emission would only lengthen the file.
        let shines = medium.emission != Rgb::ZERO.into();
        let emission_scale = medium.emission_scale * if shines { millimetres } else { 1.0 };
        Some(Medium {
            scale: medium.scale * millimetres,
            emission_scale,
            ..medium
        })
    }

    /// The path, such as `Metal/gold`, as in the file.
    pub fn path(&self) -> String {
        format!("{}/{}", self.group, self.name)
    }
}

/// Lays the textures of a material with lengths in metres on shapes of a scene whose unit is so many metres.
fn fit(tree: &mut MaterialTree, metres: f32, up: &str) {
    let mut has_lengths = false;
    tree.material.visit_mut(&mut |info, value| {
        value.for_each_texture(info, &mut |_, texture| {
            texture.for_each_projection(&mut |to_uv, axis| {
                *to_uv *= Affine2::from_scale(Vec2::splat(metres));
                *axis = axis.of_name(up).unwrap_or(*axis);
                has_lengths = true;
            });
        });
    });
    if let Material::BumpMap { scale, .. } = &mut tree.material
        && has_lengths
    {
        *scale /= metres;
    }
    for inside in &mut tree.inside {
        if let Inside::New(inner) = inside {
            fit(inner, metres, up);
        }
    }
}

const BUILT_IN: [(&str, &str); 2] = [
    ("surfaces.xml", include_str!("../../../../assets/surfaces.xml")),
    ("materials.xml", include_str!("../../../../assets/materials.xml")),
];

/// Loads all presets, and returns the problems with the user's file.
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

/// The content of an XML file.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum FileContent {
    /// Only materials, of which this is the first.
    Materials(Box<Preset>),
    /// A scene with this number of shapes. None: it is too long to be read for the number.
    Scene(Option<usize>),
}

/// Reads the content of an XML file. `access` is for included files.
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
            medium: None,
        }
    });
    let shapes = scene.shapes.len();
    Ok(preset.map_or(FileContent::Scene(Some(shapes)), |preset| {
        FileContent::Materials(Box::new(preset))
    }))
}

/// The presets that come with the program.
pub fn built_in() -> Vec<Preset> {
    let of_file = |(name, text): (&str, &str)| of_text(text, Path::new(name)).0;
    BUILT_IN.into_iter().flat_map(of_file).collect()
}

/// The path of the user's presets, if there are any.
fn own_file() -> Option<PathBuf> {
    let folders = directories::ProjectDirs::from("", "", "sunroom")?;
    Some(folders.config_dir().join("materials.xml"))
}

/// The presets in a text: bsdfs that have an id and are not nested, and then shapes that have an id and an interior.
fn of_text(text: &str, path: &Path) -> (Vec<Preset>, Vec<String>) {
    let mut document = parse_str(text, path, &[]);
    let scene = read::read(&mut document);
    // The only message about the whole document is that it has no camera, as a scene would have.
    let whole = Some(document.root.span);
    let located = document.diagnostics.list.iter().filter(|told| told.span != whole);
    let complaints = located.map(|told| format!("{}: {}", path.display(), told.message));
    let preset = |id: &str, place: usize, medium: Option<usize>| {
        let (group, name) = id.split_once('/').unwrap_or(("Own", id));
        Preset {
            group: group.to_owned(),
            name: name.to_owned(),
            tree: tree(&scene, place),
            medium: medium.map(|medium| scene.media[medium].medium.clone()),
        }
    };
    let surfaces = scene.materials.iter().enumerate().filter_map(|(place, material)| {
        let id = material.identity.id.as_ref()?;
        let is_whole = material.declared_in == DeclarationPlace::TopLevel;
        is_whole.then(|| preset(id, place, None))
    });
    let bodies = scene.shapes.iter().filter_map(|shape| {
        let (id, interior) = (shape.identity.id.as_ref()?, shape.interior?);
        Some(preset(id, shape.material?, Some(interior)))
    });
    (surfaces.chain(bodies).collect(), complaints.collect())
}

/// The tree of a material; descriptions have no cycles.
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
    use crate::app::editor::command::texture_placing::has_textures;
    use crate::scene::parameters::ALPHA;
    use crate::scene::{
        ConductorIor, Ior, Parameter, ParameterInfo, ParameterRef, Pattern, PrincipledIndex, Roughness, Texture,
    };
    use crate::shading::ior;

    /// Whether the texture lies on shapes by lengths, and no colour in it is beyond the limit.
    fn is_possible_texture(texture: &Texture, limit: f32) -> bool {
        fn are_within(texture: &Texture, limit: f32) -> bool {
            let mut found = true;
            if let Texture::Pattern(pattern) = texture {
                pattern.visit(&mut |_, value| {
                    found &= match value {
                        ParameterRef::Stops(stops) => stops.iter().all(|stop| stop.color.max_element() <= limit),
                        _ => true,
                    };
                });
            }
            texture.for_each_nested(&mut |nested| found &= are_within(nested, limit));
            found
        }
        let is_projected =
            matches!(texture, Texture::Pattern(pattern) if matches!(**pattern, Pattern::BoxProjection { .. }));
        is_projected && are_within(texture, limit.max(1.2))
    }

    /// Whether the value could be that of a real material.
    fn is_possible(info: &ParameterInfo, value: ParameterRef) -> bool {
        match value {
            ParameterRef::Reflectance(color) | ParameterRef::Normals(color) => {
                // Only factors, which are 1, are whiter than fresh snow.
                let is_factor = info.name.starts_with("specular");
                let limit = if is_factor { 1.0 } else { 0.95 };
                match color {
                    Parameter::Constant(color) => color.min_element() >= 0.0 && color.max_element() <= limit,
                    Parameter::Texture(texture) => is_possible_texture(texture, limit),
                }
            }
            ParameterRef::Float(number) | ParameterRef::Height(number) => match number {
                Parameter::Constant(number) => info.range.contains(number),
                Parameter::Texture(texture) => is_possible_texture(texture, f32::MAX),
            },
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
        let (mut presets, mut complaints) = (Vec::new(), Vec::new());
        for (name, text) in BUILT_IN {
            let (found, wrong) = of_text(text, Path::new(name));
            presets.extend(found);
            complaints.extend(wrong);
        }
        assert_eq!(complaints, [""; 0]);
        let is_textured = |preset: &&Preset| has_textures(preset.tree.materials());
        let textured = presets.iter().filter(is_textured).count();
        assert!(textured >= 30 && presets.len() >= 80, "{textured} {}", presets.len());
        for preset in &presets {
            preset.tree.material.visit(&mut |info, value| {
                let place = format!("{}/{} {}", preset.group, preset.name, info.name);
                assert!(is_possible(info, value), "{place}: {value:?}");
            });
            if let Some(medium) = &preset.medium {
                let (sigma_t, albedo) = medium.coefficients.sigma_t_and_albedo();
                let [sigma_t, albedo] = [sigma_t, albedo].map(|volume| volume.constant().expect("the same everywhere"));
                assert!(
                    sigma_t.min_element() > 0.0 && albedo.max_element() < 1.0,
                    "{}",
                    preset.name
                );
                assert!(preset.tree.material.refracts(), "{}", preset.name);
            }
            let twins = presets
                .iter()
                .filter(|other| other.name == preset.name && other.group == preset.group);
            assert_eq!(twins.count(), 1, "{}", preset.name);
        }
    }

    /// The diffuse reflectance of a thick body with isotropic scattering and a border that reflects light back inside
    /// (Jensen et al. 2001, section 2.3).
    fn diffuse_reflectance(albedo: f32, eta: f32) -> f32 {
        let internal = -1.440 / (eta * eta) + 0.710 / eta + 0.668 + 0.0636 * eta;
        let border = (1.0 + internal) / (1.0 - internal);
        let root = (3.0 * (1.0 - albedo)).sqrt();
        0.5 * albedo * (1.0 + (-4.0 / 3.0 * border * root).exp()) * (-root).exp()
    }

    /// A wrong digit in a coefficient would show in the reflectance, which is in the table as well.
    #[test]
    fn measured_media_reflect_what_their_table_says() {
        let measured = [
            ("skin, light", 1.3, [0.63, 0.44, 0.34]),
            ("skin, dark", 1.3, [0.44, 0.22, 0.13]),
            ("marble", 1.5, [0.83, 0.79, 0.75]),
            ("milk", 1.3, [0.91, 0.88, 0.76]),
            ("milk, skimmed", 1.3, [0.81, 0.81, 0.69]),
            ("cream", 1.3, [0.98, 0.90, 0.73]),
            ("ketchup", 1.3, [0.16, 0.01, 0.00]),
        ];
        let presets = built_in();
        for (name, eta, expected) in measured {
            let found = presets
                .iter()
                .find(|preset| preset.path() == format!("Scattering/{name}"));
            let medium = found.and_then(|preset| preset.medium.as_ref()).expect(name);
            let (_, albedo) = medium.coefficients.sigma_t_and_albedo();
            let albedo = albedo.constant().expect("the same everywhere").to_array();
            for (albedo, expected) in albedo.into_iter().zip(expected) {
                let reflectance = diffuse_reflectance(albedo, eta);
                assert!(
                    (reflectance - expected).abs() < 0.015,
                    "{name}: {reflectance} {expected}"
                );
            }
        }
    }

    #[test]
    fn coefficients_are_per_millimetre_whatever_the_unit_of_the_scene() {
        let presets = built_in();
        let milk = presets
            .iter()
            .find(|preset| preset.path() == "Scattering/milk")
            .expect("milk");
        let scale = |unit| milk.medium_in(unit).expect("a medium").scale;
        assert_eq!(scale(LengthUnit::Millimetre), 1.0);
        assert_eq!((scale(LengthUnit::Centimetre), scale(LengthUnit::Inch)), (10.0, 25.4));
        assert_eq!((scale(LengthUnit::Metre), scale(LengthUnit::None)), (1000.0, 1000.0));
    }

    #[test]
    fn textures_are_in_metres_whatever_the_unit_of_the_scene() {
        let presets = built_in();
        let brick = presets
            .iter()
            .find(|preset| preset.path() == "Brick/red brick")
            .expect("a brick");
        let parts = |tree: &MaterialTree| {
            let Material::BumpMap {
                height: Parameter::Texture(Texture::Pattern(pattern)),
                scale,
                ..
            } = &tree.material
            else {
                panic!("{tree:?}")
            };
            let Pattern::BoxProjection { to_uv, up, .. } = &**pattern else {
                panic!("{tree:?}")
            };
            (to_uv.matrix2.x_axis.x, *scale, up.name())
        };
        let (one, height, _) = parts(&brick.tree);
        assert_eq!(brick.tree_in(LengthUnit::Metre, Vec3::Y), brick.tree);
        let (factor, scale, up) = parts(&brick.tree_in(LengthUnit::Millimetre, Vec3::Z));
        assert_eq!((factor, up), (0.001 * one, "z"));
        assert!((scale - 1000.0 * height).abs() < 1e-3);
    }

    #[test]
    fn nested_materials_come_along() {
        let text = "<scene version='3.0.0'>
            <bsdf type='twosided' id='cloth'><bsdf type='diffuse' id='inner'/></bsdf>
            <bsdf type='diffuse'/></scene>";
        let (presets, _) = of_text(text, Path::new("own.xml"));
        let [
            Preset {
                group,
                name,
                tree,
                medium: None,
            },
        ] = &presets[..]
        else {
            panic!("{presets:?}")
        };
        assert_eq!((group.as_str(), name.as_str()), ("Own", "cloth"));
        assert_eq!(*tree, MaterialTree::from(Material::default()).wrapped("twosided"));
    }
}
