//! Turns materials of the file into bsdfs of the scene format (glTF 2.0, section 3.9 and appendix B).
//!
//! Metallic-roughness is `principled`, in which both numbers have the same meaning. Both sides are shown: a path tracer
//! has no use for culling. Thin transmission (without a volume) is `principledthin`, blended with metal if there is
//! some; a volume that absorbs light is a medium inside. A dielectric with a specular factor of 0 is `diffuse`: glTF's
//! model is Lambert's then, which `principled` is not.

use glam::Vec3;

use super::Gltf;
use super::mesh::{MeshValues, VERTEX_ALPHA, VERTEX_COLOR};
use super::objects::{object, with, with_child, with_color, with_float};
use super::picture::{Alpha, Made};
use super::scene::Builder;
use super::schema::{Material, Primitive, TextureInfo, Transmission};
use crate::color::luminance;
use crate::document::{Category, Object, Value};

const DEFAULT_IOR: f32 = 1.5;
/// The alpha cutoff if the file does not give one.
const CUTOFF: f32 = 0.5;

impl TextureInfo {
    pub(super) fn set(&self) -> usize {
        let transform = self.extensions.transform.as_ref();
        transform
            .and_then(|transform| transform.tex_coord)
            .unwrap_or(self.tex_coord)
    }
}

impl Material {
    /// The transmission; None if the material is opaque.
    pub(super) fn transmission(&self) -> Option<&Transmission> {
        let transmission = self.extensions.transmission.as_ref();
        transmission.filter(|transmission| transmission.transmission_factor > 0.0)
    }

    /// Whether the material bounds a volume.
    fn has_volume(&self) -> bool {
        let volume = self.extensions.volume.as_ref();
        volume.is_some_and(|volume| volume.thickness_factor > 0.0)
    }

    /// Whether light is transmitted without refraction, as through a pane.
    pub(super) fn is_thin(&self) -> bool {
        self.transmission().is_some() && !self.has_volume()
    }

    /// Whether its alpha is used.
    pub(super) fn counts_alpha(&self) -> bool {
        self.cutoff().is_some() || self.alpha_mode.as_deref() == Some("BLEND")
    }

    /// The alpha below which the surface is absent, if it has a cutoff.
    pub(super) fn cutoff(&self) -> Option<f32> {
        (self.alpha_mode.as_deref() == Some("MASK")).then(|| self.alpha_cutoff.unwrap_or(CUTOFF))
    }

    /// The absorption coefficient inside, per unit of length; None if nothing is absorbed. After the attenuation
    /// distance light has the attenuation colour (KHR_materials_volume).
    pub(super) fn absorption(&self) -> Option<Vec3> {
        /// The least transmittance: black would need infinite absorption.
        const DARKEST: f32 = 1e-10;
        /// The most absorption, which is also the limit of scene files.
        const MOST: f32 = 1e9;
        let is_thick = self.transmission().is_some() && self.has_volume() && self.extensions.unlit.is_none();
        let volume = self.extensions.volume.as_ref().filter(|_| is_thick)?;
        let distance = volume.attenuation_distance.filter(|distance| *distance > 0.0)?;
        let color = Vec3::from(volume.attenuation_color.unwrap_or([1.0; 3]));
        let left = color.clamp(Vec3::splat(DARKEST), Vec3::ONE);
        let sigma_a = left.map(|left| (-left.ln() / distance).min(MOST));
        (sigma_a.is_finite() && sigma_a.max_element() > 0.0).then_some(sigma_a)
    }

    /// Whether it is purely diffuse: no metal, no specular reflection and no further layers (KHR_materials_specular).
    pub(super) fn is_matt(&self) -> bool {
        let extensions = &self.extensions;
        let specular = extensions.specular.as_ref();
        let coat = extensions.clearcoat.as_ref().map(|coat| coat.clearcoat_factor);
        let sheen = extensions.sheen.as_ref().map(|sheen| sheen.sheen_color_factor);
        self.pbr_metallic_roughness.metallic_factor == 0.0
            && specular.is_some_and(|specular| specular.specular_factor == 0.0)
            && self.transmission().is_none()
            && coat.is_none_or(|coat| coat == 0.0)
            && sheen.is_none_or(|sheen| sheen == [0.0; 3])
    }

    /// The textures that are read, by decreasing importance.
    pub(super) fn textures(&self) -> impl Iterator<Item = &TextureInfo> {
        let pbr = &self.pbr_metallic_roughness;
        let coat = self.extensions.clearcoat.as_ref();
        let anisotropy = self.extensions.anisotropy.as_ref();
        let sheen = self.extensions.sheen.as_ref();
        let passing = self.diffuse_transmission();
        let all = [
            pbr.base_color_texture.as_ref(),
            self.normal_texture.as_ref(),
            pbr.metallic_roughness_texture.as_ref(),
            self.emissive_texture.as_ref(),
            self.transmission()
                .and_then(|layer| layer.transmission_texture.as_ref()),
            coat.and_then(|layer| layer.clearcoat_texture.as_ref()),
            coat.and_then(|layer| layer.clearcoat_roughness_texture.as_ref()),
            self.specular_picture().map(|(info, _)| info),
            anisotropy.and_then(|layer| layer.anisotropy_texture.as_ref()),
            passing.and_then(|layer| layer.diffuse_transmission_color_texture.as_ref()),
            passing.and_then(|layer| layer.diffuse_transmission_texture.as_ref()),
            sheen.and_then(|layer| layer.sheen_color_texture.as_ref()),
        ];
        all.into_iter().flatten()
    }
}

impl Gltf {
    /// The only set of texture coordinates of a mesh that is read: that of its material's first texture.
    pub(super) fn uv_set(&self, primitive: &Primitive) -> usize {
        let material = primitive.material.and_then(|index| self.root.materials.get(index));
        let first = material.and_then(|material| material.textures().next());
        first.map_or(0, TextureInfo::set)
    }
}

/// What a surface has its look from.
pub(super) struct Surface<'a> {
    pub material: &'a Material,
    pub mesh: MeshValues,
    /// The name of the material in messages.
    pub title: &'a str,
}

impl Builder<'_> {
    /// The bsdf of a primitive. `index`: the material, None for the default.
    pub(super) fn bsdf(&mut self, index: Option<usize>, mesh: MeshValues) -> Object {
        let gltf = self.gltf;
        let default = Material::default();
        let material = index
            .and_then(|index| gltf.root.materials.get(index))
            .unwrap_or(&default);
        let title = title(index, material);
        self.report_limits(material, mesh, &title);
        let surface = Surface {
            material,
            mesh,
            title: &title,
        };
        let mut bsdf = self.surface(&surface);
        let mut is_two_sided = material.transmission().is_none() || bsdf.plugin == "diffuse";
        if material.matt_sheet().is_some() {
            is_two_sided = false;
        } else if let Some(passing) = material.diffuse_transmission().filter(|_| is_two_sided) {
            bsdf = self.with_passing_light(bsdf, passing, material);
            is_two_sided = false;
        }
        if material.is_thin() && bsdf.plugin != "diffuse" {
            bsdf = self.with_metal(bsdf, &surface);
            // Pure metal transmits no light.
            is_two_sided = bsdf.plugin == "principled";
        }
        if let Some(texture) = &material.normal_texture
            && let Some(bitmap) = self.bitmap("normalmap", texture, Made::Normals { scale: texture.scale })
        {
            let map = with(
                object(Category::Bsdf, "normalmap"),
                "gltf_tangents",
                Value::Boolean(true),
            );
            bsdf = with_child(with_child(map, bitmap), bsdf);
        }
        if is_two_sided {
            bsdf = with_child(object(Category::Bsdf, "twosided"), bsdf);
        }
        self.masked(bsdf, material, mesh)
    }

    /// The bsdf of the surface, without wrappers such as masks.
    fn surface(&mut self, surface: &Surface) -> Object {
        let (material, mesh) = (surface.material, surface.mesh);
        if let Some(passing) = material.matt_sheet() {
            let sheet = object(Category::Bsdf, "principledthin");
            let sheet = self.with_base_color(sheet, "base_color", material, mesh);
            return with_float(sheet, "diff_trans", passing.min(2.0));
        }
        let plugin = if material.extensions.unlit.is_some() || material.is_matt() {
            "diffuse"
        } else if material.is_thin() {
            "principledthin"
        } else {
            "principled"
        };
        if plugin == "diffuse" {
            return self.with_base_color(object(Category::Bsdf, plugin), "reflectance", material, mesh);
        }
        let mut bsdf = self.with_base_color(object(Category::Bsdf, plugin), "base_color", material, mesh);
        bsdf = self.with_roughness(bsdf, surface);
        bsdf = with_float(bsdf, "eta", index_of_refraction(material));
        bsdf = self.with_specular_tint(bsdf, surface);
        if let Some(transmission) = material.transmission() {
            let texture = transmission.transmission_texture.as_ref();
            bsdf = self.with_number(bsdf, "spec_trans", transmission.transmission_factor, texture, 0);
        }
        bsdf = self.with_sheen(bsdf, surface);
        if plugin == "principled" {
            bsdf = self.with_metallic(bsdf, material);
            bsdf = self.with_coat(bsdf, material);
        }
        bsdf
    }

    fn with_coat(&mut self, bsdf: Object, material: &Material) -> Object {
        let Some(coat) = material
            .extensions
            .clearcoat
            .as_ref()
            .filter(|coat| coat.clearcoat_factor > 0.0)
        else {
            return bsdf;
        };
        let texture = coat.clearcoat_texture.as_ref();
        let bsdf = self.with_number(bsdf, "clearcoat", coat.clearcoat_factor, texture, 0);
        let factor = coat.clearcoat_roughness_factor.clamp(0.0, 1.0);
        let roughness = coat.clearcoat_roughness_texture.as_ref();
        let gloss = Made::Complement { channel: 1, factor };
        match roughness.and_then(|texture| self.bitmap("clearcoat_gloss", texture, gloss)) {
            Some(bitmap) => with_child(bsdf, bitmap),
            None => with_float(bsdf, "clearcoat_gloss", 1.0 - factor),
        }
    }

    fn with_metallic(&mut self, bsdf: Object, material: &Material) -> Object {
        let pbr = &material.pbr_metallic_roughness;
        let metal = |diffuse, specular, of| Made::MetalOfSpecular { diffuse, specular, of };
        match self.of_specular("metallic", material, metal) {
            Some(bitmap) => with_child(bsdf, bitmap),
            None => self.with_number(
                bsdf,
                "metallic",
                pbr.metallic_factor,
                pbr.metallic_roughness_texture.as_ref(),
                2,
            ),
        }
    }

    /// A texture made of the pictures of specular and of diffuse colour; None if there is none of specular colour, or
    /// if the two lie differently.
    fn of_specular(
        &mut self,
        name: &str,
        material: &Material,
        made: impl Fn([f32; 3], [f32; 3], Option<usize>) -> Made,
    ) -> Option<Object> {
        let (info, _) = material.specular_picture()?;
        let given = material.extensions.specular_glossiness.as_ref()?;
        let [r, g, b, _] = given.diffuse_factor;
        let of = match &given.diffuse_texture {
            Some(diffuse) => Some(self.images_alike(info, diffuse)?.1),
            None => None,
        };
        self.bitmap(name, info, made([r, g, b], given.specular_factor, of))
    }

    /// A thin surface blended with its opaque share of metal (appendix B.2).
    fn with_metal(&mut self, thin: Object, surface: &Surface) -> Object {
        let (material, mesh) = (surface.material, surface.mesh);
        let pbr = &material.pbr_metallic_roughness;
        if pbr.metallic_factor <= 0.0 {
            return thin;
        }
        let metal = self.with_base_color(object(Category::Bsdf, "principled"), "base_color", material, mesh);
        let metal = self.with_roughness(metal, surface);
        let metal = self.with_coat(with_float(metal, "metallic", 1.0), material);
        if pbr.metallic_factor >= 1.0 && pbr.metallic_roughness_texture.is_none() {
            return metal;
        }
        let share = pbr.metallic_roughness_texture.as_ref();
        let blend = self.with_number(
            object(Category::Bsdf, "blendbsdf"),
            "weight",
            pbr.metallic_factor,
            share,
            2,
        );
        with_child(
            with_child(blend, thin),
            with_child(object(Category::Bsdf, "twosided"), metal),
        )
    }

    fn masked(&mut self, bsdf: Object, material: &Material, mesh: MeshValues) -> Object {
        if !material.counts_alpha() {
            return bsdf;
        }
        let pbr = &material.pbr_metallic_roughness;
        let (factor, cutoff) = (pbr.base_color_factor[3], material.cutoff());
        let texture = pbr.base_color_texture.as_ref();
        let mask = object(Category::Bsdf, "mask");
        // The product of vertex alpha and a texture that is cut off cannot be cut off again.
        if mesh.alpha && (cutoff.is_none() || texture.is_none()) {
            let alpha = Made::Alpha(Alpha {
                factor: 1.0,
                cutoff: None,
            });
            let bitmap = texture.and_then(|texture| self.bitmap("times", texture, alpha));
            let values = with_float(mesh_attribute(VERTEX_ALPHA, "opacity"), "scale", factor.max(0.0));
            return with_child(with_child(mask, bitmap.into_iter().fold(values, with_child)), bsdf);
        }
        let bitmap = texture.and_then(|texture| self.bitmap("opacity", texture, Made::Alpha(Alpha { factor, cutoff })));
        let opacity = Alpha { factor, cutoff }.of(1.0);
        match bitmap {
            Some(bitmap) => with_child(with_child(mask, bitmap), bsdf),
            None if opacity >= 1.0 => bsdf,
            None => with_child(with_float(mask, "opacity", opacity.max(0.0)), bsdf),
        }
    }

    fn with_base_color(&mut self, bsdf: Object, name: &str, material: &Material, mesh: MeshValues) -> Object {
        let pbr = &material.pbr_metallic_roughness;
        let [r, g, b, _] = pbr.base_color_factor;
        let texture = pbr.base_color_texture.as_ref();
        let base = |diffuse, specular, of| Made::BaseOfSpecular { diffuse, specular, of };
        if mesh.colors {
            // The vertex colours include the factor, unless there is a specular picture.
            let factor = match material.specular_picture() {
                Some(_) => [r, g, b],
                None => [1.0; 3],
            };
            let picture = match self.of_specular("times", material, base) {
                Some(bitmap) => Some(bitmap),
                None => texture.and_then(|texture| self.bitmap("times", texture, Made::Color(factor))),
            };
            let colors = picture.into_iter().fold(mesh_attribute(VERTEX_COLOR, name), with_child);
            return with_child(bsdf, colors);
        }
        if let Some(bitmap) = self.of_specular(name, material, base) {
            return with_child(bsdf, bitmap);
        }
        match texture.and_then(|texture| self.bitmap(name, texture, Made::Color([r, g, b]))) {
            Some(bitmap) => with_child(bsdf, bitmap),
            None => with_color(bsdf, name, Vec3::new(r, g, b)),
        }
    }

    pub(super) fn with_number(
        &mut self,
        bsdf: Object,
        name: &str,
        factor: f32,
        texture: Option<&TextureInfo>,
        channel: usize,
    ) -> Object {
        match texture.and_then(|texture| self.bitmap(name, texture, Made::Channel { channel, factor })) {
            Some(bitmap) => with_child(bsdf, bitmap),
            None => with_float(bsdf, name, factor),
        }
    }
}

/// A mesh attribute as a texture for the parameter `parameter`.
fn mesh_attribute(name: &str, parameter: &str) -> Object {
    let attribute = object(Category::Texture, "mesh_attribute");
    let attribute = with(attribute, "name", Value::String(name.into()));
    Object {
        name: Some(parameter.into()),
        ..attribute
    }
}

/// The name of a material in messages.
pub(super) fn title(index: Option<usize>, material: &Material) -> String {
    match (index, &material.name) {
        (Some(index), Some(name)) => format!("material {index} ({name})"),
        (Some(index), None) => format!("material {index}"),
        (None, _) => "the default material".to_owned(),
    }
}

/// The index of refraction that gives the reflectance at normal incidence after the specular factor and the luminance
/// of the specular colour (KHR_materials_specular).
fn index_of_refraction(material: &Material) -> f32 {
    let given = material.extensions.ior.as_ref().map_or(DEFAULT_IOR, |given| given.ior);
    // `principled` needs some refraction.
    const POSSIBLE: std::ops::RangeInclusive<f32> = 1.0001..=100.0;
    let clamped = |eta: f32| eta.clamp(*POSSIBLE.start(), *POSSIBLE.end());
    let of_index = ((given - 1.0) / (given + 1.0)).powi(2);
    // An index of 0 stands for one without bounds: all light is reflected.
    let Some(specular) = &material.extensions.specular else {
        return clamped(if given == 0.0 { f32::INFINITY } else { given });
    };
    let color = Vec3::from(specular.specular_color_factor.unwrap_or([1.0; 3])).max(Vec3::ZERO);
    let reflectance = luminance((of_index * color).min(Vec3::ONE)) * specular.specular_factor.clamp(0.0, 1.0);
    let amplitude = reflectance.sqrt();
    clamped((1.0 + amplitude) / (1.0 - amplitude))
}
