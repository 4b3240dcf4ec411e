//! Warns of properties of glTF materials that the models of the scene format lack. Each sentence names the material.

use std::collections::BTreeMap;

use super::is_supported;
use super::material::title;
use super::mesh::MeshValues;
use super::scene::Builder;
use super::schema::{Material, TextureInfo};
use super::write::SHEEN_ROUGHNESS;

/// The most elements that a warning names.
const MOST_NAMES: usize = 5;

/// The names of the first elements, and the number of others.
pub(super) fn first_names<T>(things: &[T], name: impl Fn(&T) -> String) -> String {
    let names: Vec<String> = things.iter().take(MOST_NAMES).map(name).collect();
    match things.len().saturating_sub(MOST_NAMES) {
        0 => names.join(", "),
        others => format!("{} and {others} more", names.join(", ")),
    }
}

impl Builder<'_> {
    /// Warns of extensions that are not read, with the materials that have them. A file may have extensions that it
    /// does not list.
    pub(super) fn report_extensions(&mut self) {
        let root = &self.gltf.root;
        let listed = root.extensions_used.iter().filter(|name| !is_supported(name));
        let mut unread: BTreeMap<&str, Vec<usize>> = listed.map(|name| (name.as_str(), Vec::new())).collect();
        for (index, material) in root.materials.iter().enumerate() {
            for name in material.extensions.unread.keys() {
                unread.entry(name).or_default().push(index);
            }
        }
        let variants = &root.extensions.variants.variants;
        let names = first_names(variants, |variant| format!("`{}`", variant.name));
        if !variants.is_empty() {
            self.warn(format!(
                "the materials are those without a variant; the file also has {names} (KHR_materials_variants)"
            ));
        }
        for (name, materials) in unread {
            let titles = first_names(&materials, |&index| title(Some(index), &root.materials[index]));
            self.warn(match materials.is_empty() {
                true => format!("the extension {name} is not read"),
                false => format!("the extension {name} of {titles} is not read"),
            });
        }
    }

    pub(super) fn report_limits(&mut self, material: &Material, mesh: MeshValues, title: &str) {
        for what in limits(material, mesh) {
            self.warn(format!("{title}: {what}"));
        }
        let diffuse = material.pbr_metallic_roughness.base_color_texture.as_ref();
        if let (Some((info, _)), Some(diffuse)) = (material.specular_picture(), diffuse)
            && self.images_alike(info, diffuse).is_none()
        {
            let sentence = "its specular picture gives no colour, because its pictures lie differently";
            self.warn(format!("{title}: {sentence}"));
        }
    }
}

fn limits(material: &Material, mesh: MeshValues) -> Vec<&'static str> {
    let extensions = &material.extensions;
    let mut limits = Vec::new();
    let mut check = |is_so: bool, what: &'static str| {
        if is_so {
            limits.push(what);
        }
    };
    if let Some(coat) = extensions.clearcoat.as_ref().filter(|coat| coat.clearcoat_factor > 0.0) {
        let index = |texture: &Option<TextureInfo>| texture.as_ref().map(|texture| texture.index);
        check(
            index(&coat.clearcoat_normal_texture) != index(&material.normal_texture),
            "its coat has the normals of what is below it",
        );
        check(
            material.is_thin(),
            "its coat is left out where light goes through, because thin surfaces have none",
        );
    }
    if let Some(sheen) = extensions
        .sheen
        .as_ref()
        .filter(|sheen| sheen.sheen_color_factor != [0.0; 3])
    {
        check(
            sheen.sheen_color_texture.is_some(),
            "its sheen has the brightness of its texture, not the colour",
        );
        check(
            sheen.sheen_roughness_factor != SHEEN_ROUGHNESS || sheen.sheen_roughness_texture.is_some(),
            "its sheen has a width of its own, whatever its roughness",
        );
    }
    if let Some(specular) = extensions.specular.as_ref() {
        check(
            specular.specular_texture.is_some() || specular.specular_color_texture.is_some(),
            "its specular reflection has no texture",
        );
    }
    if let Some(layer) = extensions
        .anisotropy
        .as_ref()
        .filter(|layer| layer.anisotropy_strength > 0.0)
    {
        check(
            layer.anisotropy_rotation != 0.0 || layer.anisotropy_texture.is_some(),
            "its highlights are stretched along the texture coordinates, and in no other direction",
        );
    }
    if material.diffuse_transmission().is_some() {
        check(
            material.transmission().is_some(),
            "its matt light does not go through, because clear light does",
        );
        check(
            extensions.volume.is_some() && material.transmission().is_none(),
            "light goes through it as through a thin sheet, without its volume",
        );
        let pbr = &material.pbr_metallic_roughness;
        let is_metal = pbr.metallic_factor >= 1.0 && pbr.metallic_roughness_texture.is_none();
        check(
            material.transmission().is_none() && !material.is_matt() && !is_metal,
            "its mirror reflection is dimmed by the share of matt light that goes through",
        );
    }
    let film = extensions.iridescence.as_ref();
    check(
        film.is_some_and(|film| film.iridescence_factor > 0.0),
        "its thin film has no colours (iridescence)",
    );
    let dispersion = extensions.dispersion.as_ref();
    check(
        dispersion.is_some_and(|given| given.dispersion > 0.0),
        "all its colours are refracted alike (no dispersion)",
    );
    check(
        extensions.unlit.is_some(),
        "it is unlit: a diffuse surface takes its place",
    );
    let sets: Vec<usize> = material.textures().map(TextureInfo::set).collect();
    check(
        sets.windows(2).any(|two| two[0] != two[1]),
        "its textures use several sets of coordinates: the first one's is taken",
    );
    if mesh.alpha && material.cutoff().is_some() {
        let has_picture = material.pbr_metallic_roughness.base_color_texture.is_some();
        check(
            has_picture,
            "alpha of vertices does not count beside a picture that is cut off",
        );
        check(!has_picture, "alpha of vertices fades, and is not cut off");
    }
    limits
}
