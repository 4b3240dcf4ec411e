//! Writes looks as materials of glTF: decides on factors and on the channels of shared pictures.

use std::collections::HashMap;
use std::path::Path;

use super::level::{Level, Map, Varying};
use super::look::{Appearance, Look};
use super::looks::Looks;
use super::messages::Messages;
use super::pictures::{Pictures, Planes};
use crate::color::Rgb;
use crate::files::Access;
use crate::geometry::mesh::MtlMaterial;
use crate::gltf::write::GltfWriter;
use crate::gltf::write::material::{
    Clearcoat, EmissiveStrength, IndexOfRefraction, Material, MaterialExtensions, TextureInfo, Transmission, Volume,
};
use crate::scene::assets::mtl_picture::mtl_picture;
use crate::scene::components::description::SceneDescription;
use crate::scene::{AreaLight, Coefficients, Parameter, ShapeKind, Texture};

/// The default index of refraction in glTF.
const USUAL_INDEX: f32 = 1.5;

/// The material data of a surface.
#[derive(Clone, Copy)]
pub(super) struct Surface<'a> {
    /// The name of the shape.
    pub shape: &'a str,
    /// The index of its material.
    pub material: Option<usize>,
    /// The material from its mesh file, with the file and the index in it.
    pub of_file: Option<(&'a Path, usize, &'a MtlMaterial)>,
    /// The emission.
    pub light: Option<&'a AreaLight>,
    /// The medium inside.
    pub interior: Option<usize>,
    /// Whether pictures are mirrored on it, as seen from the side of its normals.
    pub is_mirrored: bool,
}

/// The result of writing a surface.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Written {
    /// The surface is not there: light passes straight through.
    Nothing,
    Material {
        /// The index of the material in the file.
        index: usize,
        /// The mesh attribute with its vertex colours, and a factor on it.
        colors: Option<(String, f32)>,
        /// Whether the scene shows its back black.
        is_one_sided: bool,
        /// Whether the surface has to be flipped, so that the denser side is the inner one.
        is_inside_out: bool,
    },
}

/// The look and the emission of a surface.
#[derive(Clone)]
struct Prepared {
    look: Look,
    emission: Option<Level>,
    shines_both_ways: bool,
}

/// The materials of an export.
pub(super) struct Materials<'a> {
    scene: &'a SceneDescription,
    /// Whether surfaces are split into their sides later, so that the back of a lamp can have another material.
    has_backs: bool,
    pub pictures: Pictures<'a>,
    /// The looks of surfaces; None for invisible ones.
    prepared: HashMap<String, Option<Prepared>>,
    written: HashMap<String, Written>,
    names: HashMap<String, usize>,
}

impl<'a> Materials<'a> {
    pub fn new(scene: &'a SceneDescription, has_backs: bool, access: &'a Access) -> Self {
        Self {
            scene,
            has_backs,
            pictures: Pictures::new(access),
            prepared: HashMap::new(),
            written: HashMap::new(),
            names: HashMap::new(),
        }
    }

    /// Writes the material of a surface; equal ones share a material.
    pub fn write(&mut self, surface: &Surface, writer: &mut GltfWriter, messages: &mut Messages) -> Written {
        let prepared = self.prepare(surface, messages);
        let goes_by_side = prepared
            .as_ref()
            .is_some_and(|it| it.look.normals.is_some() && !it.look.gltf_tangents);
        let key = format!("{} {}", key_of(surface), surface.is_mirrored && goes_by_side);
        if let Some(known) = self.written.get(&key) {
            return known.clone();
        }
        let written = match prepared {
            Some(prepared) => self.write_new(prepared, surface, writer, messages),
            None => Written::Nothing,
        };
        self.written.insert(key, written.clone());
        written
    }

    /// Whether a surface has a normal map, and whether this follows the handedness of coordinates as in glTF.
    pub fn normal_map(&mut self, surface: &Surface, messages: &mut Messages) -> Option<bool> {
        let look = self.prepare(surface, messages)?.look;
        look.normals.map(|_| look.gltf_tangents)
    }

    fn prepare(&mut self, surface: &Surface, messages: &mut Messages) -> Option<Prepared> {
        let key = key_of(surface);
        if let Some(known) = self.prepared.get(&key) {
            return known.clone();
        }
        let prepared = self.prepare_new(surface, messages);
        self.prepared.insert(key, prepared.clone());
        prepared
    }

    fn prepare_new(&mut self, surface: &Surface, messages: &mut Messages) -> Option<Prepared> {
        let mut looks = Looks {
            materials: &self.scene.materials,
            pictures: &mut self.pictures,
            messages,
        };
        let in_file = surface.of_file.map(|(_, _, mtl)| mtl);
        let appearance = match (surface.material, in_file) {
            (Some(index), _) => looks.of(index),
            (None, Some(mtl)) => Appearance::Surface(looks.of_mtl(mtl).into()),
            // The format's default material, also for emissive shapes.
            (None, None) => {
                Appearance::Surface(Look::matt(Level::number(if surface.light.is_some() { 0.0 } else { 0.5 })).into())
            }
        };
        let emission = match (surface.light, in_file.filter(|_| surface.material.is_none())) {
            (Some(light), _) => Some(Level::of_color(&light.radiance)),
            (None, Some(mtl)) => match &mtl.maps.ke {
                Some(map) => Some(Level::of_color(&Parameter::Texture(mtl_picture(map, false)))),
                None => (mtl.ke.max_element() > 0.0).then_some(Level::Constant(mtl.ke)),
            },
            (None, None) => None,
        };
        let look = match appearance {
            Appearance::Surface(look) => *look,
            Appearance::Nothing if emission.is_some() => {
                messages.note(
                    "shape",
                    surface.shape,
                    "the light is that of an invisible surface, which becomes black",
                );
                Look::matt(Level::number(0.0))
            }
            Appearance::Nothing => return None,
        };
        Some(Prepared {
            look,
            emission,
            shines_both_ways: surface.light.is_some_and(|light| light.two_sided),
        })
    }

    fn write_new(
        &mut self,
        prepared: Prepared,
        surface: &Surface,
        writer: &mut GltfWriter,
        messages: &mut Messages,
    ) -> Written {
        let Prepared {
            mut look,
            emission,
            shines_both_ways,
        } = prepared;
        let in_file = surface.of_file.map(|(_, _, mtl)| mtl);
        if surface.is_mirrored && !look.gltf_tangents {
            look.normals = look.normals.map(|normals| normals.mapped(Map::Normals));
        }
        let base_name = match (surface.material, in_file) {
            (Some(index), _) => self.scene.materials[index].identity.name.to_string(),
            (None, Some(mtl)) => mtl.name.clone(),
            (None, None) => "default".to_owned(),
        };
        let name = match surface.light {
            Some(_) => format!("{base_name} ({})", surface.shape),
            None => base_name.clone(),
        };
        let name = self.free_name(name);
        let is_one_sided = !look.is_two_sided && look.transmission.is(0.0);
        let is_inside_out = look.index < 1.0;
        let look = Look {
            index: look.index.max(look.index.recip()),
            ..look
        };
        let mut material = MaterialWriter {
            name: &base_name,
            pictures: &mut self.pictures,
            writer,
            messages,
        };
        let (mut made, colors) = material.material(look);
        if let Some(emission) = emission {
            material.emit(emission, &mut made);
            // In glTF both sides of a two-sided material are emissive.
            made.shines_from_front = !shines_both_ways && made.emissive_factor != [0.0; 3];
            made.double_sided = shines_both_ways || made.double_sided && (self.has_backs || !made.shines_from_front);
        }
        if let Some(interior) = surface.interior.filter(|_| !is_inside_out) {
            self.fill(interior, &mut made, messages);
        }
        made.name = name;
        Written::Material {
            index: writer.add_material(made),
            colors,
            is_one_sided,
            is_inside_out,
        }
    }

    fn free_name(&mut self, name: String) -> String {
        let count = self.names.entry(name.clone()).or_default();
        *count += 1;
        match *count {
            1 => name,
            count => format!("{name}-{count}"),
        }
    }

    /// Sets the medium inside a material's surface, if glTF can express it.
    fn fill(&self, interior: usize, material: &mut Material, messages: &mut Messages) {
        let Some(about) = self.scene.media.get(interior) else {
            return;
        };
        let name = &*about.identity.name;
        let extensions = &mut material.extensions;
        let Some(volume) = extensions.volume.as_mut().filter(|_| extensions.transmission.is_some()) else {
            return messages.left_out("medium", name, "only glass is filled in glTF");
        };
        let medium = &about.medium;
        let (sigma_t, albedo) = medium.coefficients.sigma_t_and_albedo();
        let (Some(sigma_t), Some(albedo)) = (sigma_t.constant(), albedo.constant()) else {
            return messages.left_out("medium", name, "glTF has no media that vary in space");
        };
        if medium.emission.constant() != Some(Rgb::ZERO) {
            messages.note("medium", name, "the light that is sent out is lost");
        }
        if albedo != Rgb::ZERO
            && !matches!(&medium.coefficients, Coefficients::Separate { sigma_s, .. } if *sigma_s == Rgb::ZERO)
        {
            messages.note("medium", name, "light is only absorbed, and not scattered");
        }
        let sigma_a = (medium.scale * sigma_t * (Rgb::ONE - albedo)).max(Rgb::ZERO);
        let most = sigma_a.max_element();
        if most > 0.0 && most.is_finite() {
            // At this distance the transmittance of the most absorbed colour is 1 / e.
            volume.attenuation_distance = Some(most.recip());
            volume.attenuation_color = Some((-sigma_a / most).exp().to_array());
        }
    }
}

/// Equal surfaces have equal keys, whether pictures are mirrored or not.
fn key_of(surface: &Surface) -> String {
    let of_file = surface.of_file.map(|(path, slot, _)| (path, slot));
    let light = surface.light.map(|light| (&light.radiance, light.two_sided));
    format!("{:?} {of_file:?} {light:?} {:?}", surface.material, surface.interior)
}

/// Whether the back of such a shape can be seen.
pub(super) fn shows_its_back(kind: &ShapeKind) -> bool {
    kind.is_flat() || matches!(kind, ShapeKind::Cylinder { .. } | ShapeKind::Mesh(_))
}

struct MaterialWriter<'m, 'a> {
    name: &'m str,
    pictures: &'m mut Pictures<'a>,
    writer: &'m mut GltfWriter,
    messages: &'m mut Messages,
}

impl MaterialWriter<'_, '_> {
    fn lose(&mut self, what: impl Into<String>) {
        self.messages.note("material", self.name, what);
    }

    fn texture(&mut self, planes: Planes) -> Option<(TextureInfo, f32)> {
        self.pictures.texture(self.writer, planes, self.messages)
    }

    /// The level with mesh attributes (reported) replaced by their mean: only the base colour may have them.
    fn without_attribute(&mut self, level: Level, what: &str) -> Level {
        match level {
            Level::Varying(varying) if has_attribute(&varying.texture) => {
                self.lose(format!(
                    "{what} is the same everywhere, because glTF has no values of meshes for that"
                ));
                Level::Constant(varying.factor * varying.map.apply(guess(&varying.texture)))
            }
            level => level,
        }
    }

    /// The material, and the attribute with its vertex colours.
    fn material(&mut self, look: Look) -> (Material, Option<(String, f32)>) {
        let mut material = Material {
            double_sided: look.is_two_sided,
            ..Material::default()
        };
        let mut colors = None;
        let (base, base_factor) = match look.base.clone() {
            Level::Varying(Varying {
                texture: Texture::MeshAttribute { name, scale, times },
                factor,
                ..
            }) => {
                colors = Some((name, scale));
                // The factor on vertex colours is a picture in glTF, too.
                let times = times.map(|times| Level::of_color(&Parameter::Texture(*times)).times(factor));
                parts(self.without_attribute(times.unwrap_or(Level::Constant(factor)), "the colour"))
            }
            level => parts(self.without_attribute(level, "the colour")),
        };
        let (opacity, opacity_factor) = parts(self.without_attribute(look.opacity.clone(), "the opacity"));
        let pbr = &mut material.pbr_metallic_roughness;
        let base_color = base_factor.clamp(Rgb::ZERO, Rgb::ONE);
        pbr.base_color_factor = base_color.extend(opacity_factor.x.clamp(0.0, 1.0)).to_array();
        if opacity.is_some() || opacity_factor.x < 1.0 {
            material.alpha_mode = Some("BLEND");
        }
        let planes = Planes {
            color: base,
            channels: [None, None, None, opacity],
            srgb: true,
            counts_alpha: material.alpha_mode.is_some(),
            ..Planes::default()
        };
        let texture = self.texture(planes);
        let pbr = &mut material.pbr_metallic_roughness;
        pbr.base_color_texture = texture.map(|(info, _)| info);

        let (roughness, roughness_factor) = parts(self.without_attribute(look.roughness.clone(), "the roughness"));
        let (metallic, metallic_factor) = parts(self.without_attribute(look.metallic.clone(), "the metallic"));
        pbr_numbers(&mut material, roughness_factor, metallic_factor);
        let planes = Planes {
            channels: [None, roughness, metallic, None],
            ..Planes::default()
        };
        let texture = self.texture(planes);
        material.pbr_metallic_roughness.metallic_roughness_texture = texture.map(|(info, _)| info);

        if let Some(Level::Varying(normals)) = look.normals.clone() {
            let planes = Planes {
                color: Some(normals),
                ..Planes::default()
            };
            material.normal_texture = self.texture(planes).map(|(info, _)| info);
        }
        let extensions = &mut material.extensions;
        extensions.anisotropy = look.anisotropy_layer(&mut material.pbr_metallic_roughness);
        extensions.diffuse_transmission = look.passing_layer(&material.pbr_metallic_roughness);
        extensions.specular = look.specular_layer();
        extensions.sheen = look.sheen_layer();
        if look.index != USUAL_INDEX && look.specular > 0.0 {
            extensions.ior = Some(IndexOfRefraction { ior: look.index });
        }
        self.layers(
            look.transmission,
            look.is_thick,
            look.clearcoat,
            look.clearcoat_roughness,
            &mut material.extensions,
        );
        (material, colors)
    }

    fn layers(
        &mut self,
        transmission: Level,
        is_thick: bool,
        clearcoat: Level,
        clearcoat_roughness: f32,
        extensions: &mut MaterialExtensions,
    ) {
        let red = |plane: Option<Varying>| Planes {
            channels: [plane, None, None, None],
            ..Planes::default()
        };
        if !transmission.is(0.0) {
            let (plane, factor) = parts(self.without_attribute(transmission, "the transmission"));
            extensions.transmission = Some(Transmission {
                transmission_factor: factor.x.clamp(0.0, 1.0),
                transmission_texture: self.texture(red(plane)).map(|(info, _)| info),
            });
            extensions.volume = is_thick.then_some(Volume {
                thickness_factor: 1.0,
                attenuation_distance: None,
                attenuation_color: None,
            });
        }
        if !clearcoat.is(0.0) {
            let (plane, factor) = parts(self.without_attribute(clearcoat, "the coat"));
            extensions.clearcoat = Some(Clearcoat {
                clearcoat_factor: factor.x.clamp(0.0, 1.0),
                clearcoat_texture: self.texture(red(plane)).map(|(info, _)| info),
                clearcoat_roughness_factor: clearcoat_roughness.clamp(0.0, 1.0),
                ..Clearcoat::default()
            });
        }
    }

    /// Makes a material emissive.
    fn emit(&mut self, emission: Level, material: &mut Material) {
        let (plane, factor) = parts(self.without_attribute(emission, "the light"));
        let planes = Planes {
            color: plane,
            srgb: true,
            is_light: true,
            ..Planes::default()
        };
        let texture = self.texture(planes);
        let peak = texture.as_ref().map_or(1.0, |(_, peak)| *peak);
        material.emissive_texture = texture.map(|(info, _)| info);
        let light = (peak * factor).max(Rgb::ZERO);
        let most = light.max_element();
        if most > 1.0 {
            material.emissive_factor = (light / most).to_array();
            material.extensions.emissive_strength = Some(EmissiveStrength {
                emissive_strength: most,
            });
        } else {
            material.emissive_factor = light.to_array();
        }
    }
}

fn pbr_numbers(material: &mut Material, roughness: Rgb, metallic: Rgb) {
    let pbr = &mut material.pbr_metallic_roughness;
    pbr.roughness_factor = roughness.x.clamp(0.0, 1.0);
    pbr.metallic_factor = metallic.x.clamp(0.0, 1.0);
}

/// The texture of a level, and the factor on it.
fn parts(level: Level) -> (Option<Varying>, Rgb) {
    match level {
        Level::Constant(value) => (None, value),
        Level::Varying(varying) => {
            let factor = varying.factor;
            let factor_apart = Varying {
                factor: Rgb::ONE,
                ..varying
            };
            (Some(factor_apart), factor)
        }
    }
}

/// Whether a texture uses a mesh attribute, possibly nested.
fn has_attribute(texture: &Texture) -> bool {
    let mut found = matches!(texture, Texture::MeshAttribute { .. });
    texture.for_each_nested(&mut |nested| found |= has_attribute(nested));
    found
}

/// The assumed mean of a texture with mesh attributes, whose values are unknown: half of its scale.
fn guess(texture: &Texture) -> Rgb {
    match texture {
        Texture::MeshAttribute { scale, .. } => Rgb::splat(0.5 * scale),
        _ => Rgb::splat(0.5),
    }
}
