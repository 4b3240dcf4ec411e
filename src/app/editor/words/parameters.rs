//! What parameters are called in the panels, and what is told of them: one table for bsdfs, textures and lights.
//!
//! Meanings are those of the format (its documentation describes the same plugins); what is said of units and ranges holds for this
//! program too. Names are those of the file.

use super::parameter::Words;
use super::{of_lights, of_materials};

/// The words for a parameter of a plugin; None for what no plugin has.
pub fn find(plugin: &str, name: &str) -> Option<&'static Words> {
    let own = |words: &&Words| words.name == name && words.plugins.contains(&plugin);
    let common = |words: &&Words| words.name == name && words.plugins.is_empty();
    all().find(own).or_else(|| all().find(common))
}

fn all() -> impl Iterator<Item = &'static Words> {
    of_materials::TABLE.iter().chain(of_lights::TABLE)
}

#[cfg(test)]
mod tests {
    use std::path::{Path, PathBuf};

    use bevy_egui::egui;

    use super::*;
    use crate::app::editor::panels::fields::NAME_WIDTH;
    use crate::color::Rgb;
    use crate::document::Object;
    use crate::scene::{
        AreaLight, ConductorIor, Emitter, Material, Parameter, PrincipledIndex, Roughness, SquarePath, SunPosition,
        SunSky, Texture, encode,
    };
    use bevy::math::{Affine2, Affine3A, Vec2, Vec3};

    /// Every name that plugins are written with, and the plugin: what the writer knows is what the format has.
    fn written() -> Vec<(String, String)> {
        let folder = Path::new("/");
        let mut materials: Vec<Material> = Material::PLUGINS.into_iter().filter_map(Material::of_plugin).collect();
        let mut brushed = Material::of_plugin("roughconductor").expect("a plugin");
        if let Material::RoughConductor {
            alpha,
            ior,
            multiple_scattering,
            ..
        } = &mut brushed
        {
            *alpha = Roughness::Anisotropic {
                u: 0.1.into(),
                v: 0.2.into(),
            };
            *ior = ConductorIor::Given {
                eta: Rgb::ONE.into(),
                k: Rgb::ONE.into(),
            };
            *multiple_scattering = true;
        }
        let mut by_index = Material::of_plugin("principled").expect("a plugin");
        if let Material::Principled(principled) = &mut by_index {
            std::sync::Arc::make_mut(principled).index = PrincipledIndex::Eta(1.5);
        }
        let to_uv = Affine2::from_scale(Vec2::splat(2.0));
        let bitmap = Texture::of_picture(PathBuf::from("/a.png"), None);
        let textures = [
            Texture::MeshAttribute {
                name: "vertex_color".into(),
                scale: 1.0,
            },
            Texture::Checkerboard {
                color0: Box::new(Parameter::Texture(bitmap.clone())),
                color1: Box::new(Rgb::ONE.into()),
                to_uv: Box::new(to_uv),
            },
            bitmap.clone(),
        ];
        let heights = textures.into_iter().map(|texture| Material::BumpMap {
            height: Parameter::Texture(texture),
            scale: 1.0,
            flip_invalid_normals: true,
            use_shadowing_function: true,
        });
        materials.extend([brushed, by_index]);
        materials.extend(heights);
        let mut found = Vec::new();
        for material in &materials {
            collect(&encode::objects::material(material, folder), &mut found);
        }
        let by_direction = SunSky {
            sun: SunPosition::Direction(Vec3::X),
            ..SunSky::default()
        };
        let mut emitters: Vec<Emitter> = Emitter::PLUGINS.into_iter().filter_map(Emitter::of_plugin).collect();
        emitters.push(crate::scene::EmitterKind::SunSky(by_direction).into());
        for emitter in &mut emitters {
            emitter.set_picture(SquarePath::WHOLE, "/a.png".into());
            // The usual one is left out.
            emitter.sampling_weight = 0.5;
            collect(
                &encode::lights::emitter(emitter, &Affine3A::IDENTITY, folder),
                &mut found,
            );
        }
        collect(&encode::lights::area_light(&AreaLight::default(), folder), &mut found);
        found
    }

    fn collect(object: &Object, found: &mut Vec<(String, String)>) {
        for property in &object.properties {
            // Where a light is: a matter of the transform.
            if !["to_world", "position", "direction"].contains(&property.name.as_str()) {
                found.push((object.plugin.to_string(), property.name.to_string()));
            }
        }
        for child in object.objects() {
            if let Some(name) = &child.name {
                found.push((object.plugin.to_string(), name.to_string()));
            }
            collect(child, found);
        }
    }

    #[test]
    fn every_parameter_of_every_plugin_is_explained() {
        let written = written();
        let missing: Vec<_> = written
            .iter()
            .filter(|(plugin, name)| {
                find(plugin, name).is_none_or(|words| words.about.is_empty() || words.range.is_empty())
            })
            .collect();
        assert!(missing.is_empty(), "{missing:?}");
        // As many as there are in the format, so that the collection cannot be empty.
        assert!(written.len() > 120, "{}", written.len());
    }

    #[test]
    fn labels_fit_their_column() {
        let mut widths = Vec::new();
        egui_kittest::Harness::new_ui(|ui| {
            let font = egui::TextStyle::Body.resolve(ui.style());
            let width = |text: &str| {
                let layout = ui
                    .painter()
                    .layout_no_wrap(text.to_owned(), font.clone(), egui::Color32::WHITE);
                layout.size().x
            };
            widths = all().map(|words| (words.label, width(words.label))).collect();
        })
        .run();
        assert_eq!(widths.len(), all().count());
        for (label, width) in widths {
            assert!(width <= NAME_WIDTH, "{label}: {width}");
        }
    }

    #[test]
    fn nothing_is_explained_that_no_plugin_has() {
        let written = written();
        for words in all() {
            let is_met = written
                .iter()
                .any(|(plugin, name)| find(plugin, name).is_some_and(|found| std::ptr::eq(found, words)));
            assert!(is_met, "{words:?}");
        }
    }
}
