//! The emission of materials: area emitters of the scene format, and their brightness.

use glam::Vec3;

use super::lighting::Glow;
use super::material::title;
use super::mesh::MeshValues;
use super::objects::{object, with, with_child, with_color};
use super::picture::{Alpha, Made, Picture};
use super::scene::Builder;
use super::schema::Material;
use crate::color::luminance;
use crate::document::{Category, Object, Value};

impl Builder<'_> {
    /// The emission of a primitive; None if it has none.
    pub(super) fn glow(&mut self, index: Option<usize>, mesh: MeshValues) -> Option<Glow> {
        let gltf = self.gltf;
        let material = gltf.root.materials.get(index?)?;
        let strength = material.extensions.emissive_strength.as_ref();
        let radiance =
            Vec3::from(material.emissive_factor) * strength.map_or(1.0, |strength| strength.emissive_strength);
        let title = title(index, material);
        let radiance = self.possible_light(radiance, &title);
        if radiance.max_element() <= 0.0 {
            return None;
        }
        let (radiance, bitmap) = self.seen_light(material, radiance, mesh, &title);
        let (emitter, mean) = match bitmap {
            Some((bitmap, picture)) => {
                let mean = self.mean_of_picture(picture);
                (with_child(object(Category::Emitter, "area"), bitmap), mean)
            }
            None => (
                with_color(object(Category::Emitter, "area"), "radiance", radiance),
                radiance,
            ),
        };
        let emitter = match material.double_sided {
            true => with(emitter, "two_sided", Value::Boolean(true)),
            false => emitter,
        };
        let mean = luminance(mean);
        // A black emitter would take samples from other lights.
        (mean > 0.0).then_some(Glow { emitter, mean })
    }

    /// The emission as a colour, or as a texture with its picture, multiplied by the alpha, since only the visible part
    /// of the surface emits.
    fn seen_light(
        &mut self,
        material: &Material,
        radiance: Vec3,
        mesh: MeshValues,
        title: &str,
    ) -> (Vec3, Option<(Object, Picture)>) {
        let pbr = &material.pbr_metallic_roughness;
        let emissive = material.emissive_texture.as_ref();
        let plain = Made::Color(radiance.to_array());
        let textured = |builder: &mut Self, info, made| {
            let picture = builder.picture(info, made)?;
            Some((builder.bitmap("radiance", info, made)?, picture))
        };
        if !material.counts_alpha() {
            return (radiance, emissive.and_then(|info| textured(self, info, plain)));
        }
        if mesh.alpha {
            self.warn(format!("{title}: alpha of vertices does not dim its light"));
        }
        let alpha = Alpha {
            factor: pbr.base_color_factor[3],
            cutoff: material.cutoff(),
        };
        let color = radiance.to_array();
        let light = |of| Made::Light { color, of, alpha };
        match (emissive, pbr.base_color_texture.as_ref()) {
            (None, None) => (radiance * alpha.of(1.0).max(0.0), None),
            (None, Some(base)) => (radiance, textured(self, base, light(None))),
            (Some(info), None) => {
                let made = Made::Color((radiance * alpha.of(1.0).max(0.0)).to_array());
                (radiance, textured(self, info, made))
            }
            (Some(info), Some(base)) => match self.images_alike(info, base) {
                Some((shining, _)) => (radiance, textured(self, base, light(Some(shining)))),
                None => {
                    self.warn(format!(
                        "{title}: alpha does not dim its light, because its pictures lie differently"
                    ));
                    (radiance, textured(self, info, plain))
                }
            },
        }
    }
}
