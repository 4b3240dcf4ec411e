//! Turns materials of the file into bsdfs and area emitters of the scene format (glTF 2.0, section 3.9 and appendix B).
//!
//! Metallic-roughness is `principled`, which means the same by both numbers. Both sides are shown: a path tracer has no use for
//! culling. Thin transmission (without a volume) is `principledthin`; a volume that absorbs light is a medium inside. What is no metal and has a
//! specular factor of 0 is `diffuse`: glTF's model is Lambert's then, which `principled` is not.

use glam::{Affine2, Mat4, Vec2, Vec3};

use super::Gltf;
use super::mesh::VERTEX_COLOR;
use super::objects::{object, with, with_child, with_color, with_float};
use super::picture::{Made, Picture};
use super::scene::Builder;
use super::schema::{Material, Pbr, Primitive, TextureInfo, Transmission};
use crate::document::{Category, Object, TransformOp, Value};

const DEFAULT_IOR: f32 = 1.5;
const MIRROR: u32 = 33648;
const CLAMP: u32 = 33071;
const REPEAT: u32 = 10497;
const NEAREST: u32 = 9728;
/// The alpha cutoff if the file does not give one.
const CUTOFF: f32 = 0.5;

impl TextureInfo {
    fn set(&self) -> usize {
        let transform = self.extensions.transform.as_ref();
        transform
            .and_then(|transform| transform.tex_coord)
            .unwrap_or(self.tex_coord)
    }
}

impl Material {
    /// The share of the light that it lets through; None if it is opaque.
    fn transmission(&self) -> Option<&Transmission> {
        let transmission = self.extensions.transmission.as_ref();
        transmission.filter(|transmission| transmission.transmission_factor > 0.0)
    }

    /// Whether its surfaces are the border of something thick.
    fn has_volume(&self) -> bool {
        let volume = self.extensions.volume.as_ref();
        volume.is_some_and(|volume| volume.thickness_factor > 0.0)
    }

    /// The absorption coefficient inside, per unit of length; None if nothing is absorbed. After the attenuation distance light has the attenuation colour
    /// (KHR_materials_volume).
    pub(super) fn absorption(&self) -> Option<Vec3> {
        /// The least share of light that is left: black would absorb infinitely much.
        const DARKEST: f32 = 1e-10;
        /// The most absorption, which is also the most that a scene file may have.
        const MOST: f32 = 1e9;
        let is_thick = self.transmission().is_some() && self.has_volume() && self.extensions.unlit.is_none();
        let volume = self.extensions.volume.as_ref().filter(|_| is_thick)?;
        let distance = volume.attenuation_distance.filter(|distance| *distance > 0.0)?;
        let color = Vec3::from(volume.attenuation_color.unwrap_or([1.0; 3]));
        let left = color.clamp(Vec3::splat(DARKEST), Vec3::ONE);
        let sigma_a = left.map(|left| (-left.ln() / distance).min(MOST));
        (sigma_a.is_finite() && sigma_a.max_element() > 0.0).then_some(sigma_a)
    }

    /// Whether it is diffuse and nothing else: it is no metal, mirrors nothing and has no further layers (KHR_materials_specular).
    fn is_matt(&self) -> bool {
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

    fn textures(&self) -> impl Iterator<Item = &TextureInfo> {
        let pbr = &self.pbr_metallic_roughness;
        let all = [
            &pbr.base_color_texture,
            &self.normal_texture,
            &pbr.metallic_roughness_texture,
            &self.emissive_texture,
        ];
        all.into_iter().flatten()
    }
}

impl Gltf {
    /// The only set of coordinates of a mesh that is read: that of its material's first texture.
    pub(super) fn uv_set(&self, primitive: &Primitive) -> usize {
        let material = primitive.material.and_then(|index| self.root.materials.get(index));
        let first = material.and_then(|material| material.textures().next());
        first.map_or(0, TextureInfo::set)
    }
}

impl Builder<'_> {
    /// The bsdf of a primitive. `index`: of its material, None for the default.
    pub(super) fn bsdf(&mut self, index: Option<usize>, vertex_colors: bool) -> Object {
        let gltf = self.gltf;
        let default = Material::default();
        let material = index
            .and_then(|index| gltf.root.materials.get(index))
            .unwrap_or(&default);
        self.report_limits(material, &title(index, material));
        let pbr = &material.pbr_metallic_roughness;
        let extensions = &material.extensions;
        let transmission = material.transmission();
        let is_thin = transmission.is_some() && !material.has_volume();
        let plugin = if extensions.unlit.is_some() || material.is_matt() {
            "diffuse"
        } else if is_thin {
            "principledthin"
        } else {
            "principled"
        };
        let mut bsdf = object(Category::Bsdf, plugin);
        let color_name = if plugin == "diffuse" {
            "reflectance"
        } else {
            "base_color"
        };
        bsdf = self.with_base_color(bsdf, color_name, pbr, vertex_colors);
        if plugin != "diffuse" {
            let roughness = pbr.metallic_roughness_texture.as_ref();
            bsdf = self.with_number(bsdf, "roughness", pbr.roughness_factor, roughness, 1);
            bsdf = with_float(bsdf, "eta", index_of_refraction(material));
            if let Some(transmission) = transmission {
                let texture = transmission.transmission_texture.as_ref();
                bsdf = self.with_number(bsdf, "spec_trans", transmission.transmission_factor, texture, 0);
            }
            if let Some(sheen) = &extensions.sheen {
                bsdf = with_float(bsdf, "sheen", Vec3::from(sheen.sheen_color_factor).max_element());
            }
        }
        if plugin == "principled" {
            let metallic = pbr.metallic_roughness_texture.as_ref();
            bsdf = self.with_number(bsdf, "metallic", pbr.metallic_factor, metallic, 2);
            if let Some(coat) = extensions.clearcoat.as_ref().filter(|coat| coat.clearcoat_factor > 0.0) {
                bsdf = self.with_number(
                    bsdf,
                    "clearcoat",
                    coat.clearcoat_factor,
                    coat.clearcoat_texture.as_ref(),
                    0,
                );
                bsdf = with_float(
                    bsdf,
                    "clearcoat_gloss",
                    1.0 - coat.clearcoat_roughness_factor.clamp(0.0, 1.0),
                );
            }
        }
        if let Some(texture) = &material.normal_texture
            && let Some(bitmap) = self.bitmap("normalmap", texture, Made::Normals { scale: texture.scale })
        {
            bsdf = with_child(with_child(object(Category::Bsdf, "normalmap"), bitmap), bsdf);
        }
        if transmission.is_none() {
            bsdf = with_child(object(Category::Bsdf, "twosided"), bsdf);
        }
        self.masked(bsdf, material)
    }

    fn masked(&mut self, bsdf: Object, material: &Material) -> Object {
        let factor = material.pbr_metallic_roughness.base_color_factor[3];
        let cutoff = match material.alpha_mode.as_deref() {
            Some("MASK") => Some(material.alpha_cutoff.unwrap_or(CUTOFF)),
            Some("BLEND") => None,
            _ => return bsdf,
        };
        let texture = material.pbr_metallic_roughness.base_color_texture.as_ref();
        let bitmap = texture.and_then(|texture| self.bitmap("opacity", texture, Made::Alpha { factor, cutoff }));
        let opacity = match cutoff {
            Some(cutoff) => f32::from(u8::from(factor >= cutoff)),
            None => factor,
        };
        let mask = object(Category::Bsdf, "mask");
        match bitmap {
            Some(bitmap) => with_child(with_child(mask, bitmap), bsdf),
            None if opacity >= 1.0 => bsdf,
            None => with_child(with_float(mask, "opacity", opacity.max(0.0)), bsdf),
        }
    }

    /// The light of a primitive, if it shines.
    pub(super) fn emitter(&mut self, index: Option<usize>) -> Option<Object> {
        let gltf = self.gltf;
        let material = gltf.root.materials.get(index?)?;
        let strength = material.extensions.emissive_strength.as_ref();
        let radiance =
            Vec3::from(material.emissive_factor) * strength.map_or(1.0, |strength| strength.emissive_strength);
        let radiance = self.possible_light(radiance, &title(index, material));
        if radiance.max_element() <= 0.0 {
            return None;
        }
        let area = object(Category::Emitter, "area");
        let texture = material.emissive_texture.as_ref();
        let bitmap = texture.and_then(|texture| self.bitmap("radiance", texture, Made::Color(radiance.to_array())));
        Some(match bitmap {
            Some(bitmap) => with_child(area, bitmap),
            None => with_color(area, "radiance", radiance),
        })
    }

    fn with_base_color(&mut self, bsdf: Object, name: &str, pbr: &Pbr, vertex_colors: bool) -> Object {
        let [r, g, b, _] = pbr.base_color_factor;
        let texture = pbr.base_color_texture.as_ref();
        if let Some(bitmap) = texture.and_then(|texture| self.bitmap(name, texture, Made::Color([r, g, b]))) {
            return with_child(bsdf, bitmap);
        }
        if vertex_colors {
            let attribute = with(
                object(Category::Texture, "mesh_attribute"),
                "name",
                Value::String(VERTEX_COLOR.into()),
            );
            return with_child(bsdf, named(attribute, name));
        }
        with_color(bsdf, name, Vec3::new(r, g, b))
    }

    fn with_number(
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

    /// A texture of the format; None (reported) if the file's is broken.
    fn bitmap(&mut self, name: &str, info: &TextureInfo, made: Made) -> Option<Object> {
        let gltf = self.gltf;
        let texture = gltf.root.textures.get(info.index);
        let image = texture.and_then(|texture| texture.source);
        let Some((texture, image)) = texture.zip(image).filter(|&(_, image)| image < gltf.root.images.len()) else {
            self.warn(format!(
                "texture {} has no image that can be read: it is left out",
                info.index
            ));
            return None;
        };
        let sampler = texture.sampler.and_then(|sampler| gltf.root.samplers.get(sampler));
        let picture = Picture { image, made };
        let file = self.reference_picture(picture)?;
        let mut bitmap = with(object(Category::Texture, "bitmap"), "filename", Value::String(file));
        if made.is_raw() {
            bitmap = with(bitmap, "raw", Value::Boolean(true));
        }
        let wrap = |given: Option<u32>| given.unwrap_or(REPEAT);
        let (s, t) = sampler.map_or((REPEAT, REPEAT), |sampler| (wrap(sampler.wrap_s), wrap(sampler.wrap_t)));
        if s != t {
            self.warn(format!(
                "texture {} repeats otherwise along v than along u: v follows u",
                info.index
            ));
        }
        let wrap = match s {
            CLAMP => Some("clamp"),
            MIRROR => Some("mirror"),
            _ => None,
        };
        if let Some(wrap) = wrap {
            bitmap = with(bitmap, "wrap_mode", Value::String(wrap.into()));
        }
        if sampler.is_some_and(|sampler| sampler.mag_filter == Some(NEAREST)) {
            bitmap = with(bitmap, "filter_type", Value::String("nearest".into()));
        }
        if let Some(transform) = &info.extensions.transform {
            // v points down in the picture, so that a turn to the left there is one to the right in these coordinates.
            let map = Affine2::from_scale_angle_translation(
                Vec2::from(transform.scale),
                -transform.rotation,
                Vec2::from(transform.offset),
            );
            let (x, y, by) = (map.matrix2.x_axis, map.matrix2.y_axis, map.translation);
            let matrix = Mat4::from_cols(
                x.extend(0.0).extend(0.0),
                y.extend(0.0).extend(0.0),
                glam::Vec4::Z,
                by.extend(0.0).extend(1.0),
            );
            bitmap = with(bitmap, "to_uv", Value::Transform(vec![TransformOp::Matrix(matrix)]));
        }
        Some(named(bitmap, name))
    }

    /// Says what of a material is not seen.
    fn report_limits(&mut self, material: &Material, title: &str) {
        let extensions = &material.extensions;
        let coat = extensions.clearcoat.as_ref();
        let sets: Vec<usize> = material.textures().map(TextureInfo::set).collect();
        let limits = [
            (
                coat.is_some_and(|coat| coat.clearcoat_roughness_texture.is_some()),
                "the roughness of its coat has no texture",
            ),
            (
                extensions
                    .sheen
                    .as_ref()
                    .is_some_and(|sheen| sheen.sheen_color_texture.is_some()),
                "its sheen has no texture",
            ),
            (
                extensions
                    .specular
                    .as_ref()
                    .is_some_and(|specular| specular.specular_texture.is_some()),
                "its specular reflection has no texture",
            ),
            (
                extensions.specular.as_ref().is_some_and(|specular| {
                    specular.specular_color_factor.is_some_and(|color| color != [1.0; 3])
                        || specular.specular_color_texture.is_some()
                }),
                "its specular reflection has no colour",
            ),
            (
                extensions.unlit.is_some(),
                "it is unlit: a diffuse surface takes its place",
            ),
            (
                sets.windows(2).any(|two| two[0] != two[1]),
                "its textures use several sets of coordinates: the first one's is taken",
            ),
        ];
        for (_, what) in limits.into_iter().filter(|&(is_so, _)| is_so) {
            self.warn(format!("{title}: {what}"));
        }
    }
}

/// The name of a material in messages.
fn title(index: Option<usize>, material: &Material) -> String {
    match (index, &material.name) {
        (Some(index), Some(name)) => format!("material {index} ({name})"),
        (Some(index), None) => format!("material {index}"),
        (None, _) => "the default material".to_owned(),
    }
}

fn named(texture: Object, name: &str) -> Object {
    Object {
        name: Some(name.into()),
        ..texture
    }
}

/// The index of refraction with the reflectance at normal incidence that the specular factor leaves.
fn index_of_refraction(material: &Material) -> f32 {
    let given = material.extensions.ior.as_ref().map_or(DEFAULT_IOR, |given| given.ior);
    // `principled` needs a surface that refracts at least a little.
    const POSSIBLE: std::ops::RangeInclusive<f32> = 1.0001..=100.0;
    let clamped = |eta: f32| eta.clamp(*POSSIBLE.start(), *POSSIBLE.end());
    let Some(specular) = &material.extensions.specular else {
        return clamped(given);
    };
    let amplitude = (given - 1.0) / (given + 1.0) * specular.specular_factor.clamp(0.0, 1.0).sqrt();
    clamped((1.0 + amplitude) / (1.0 - amplitude))
}
