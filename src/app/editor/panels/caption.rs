//! The captions of rows.

use crate::scene::ParameterInfo;

/// The caption of a row, with its tool tip.
#[derive(Clone, Copy, Debug)]
pub struct Caption<'a> {
    /// The name that the row shows and by which its control is found.
    pub text: &'a str,
    /// The name of the value among the differences of selected things; without one, the row is never marked.
    pub(super) name: &'a str,
    pub(super) info: Option<&'static ParameterInfo>,
    /// The tool tip of a row that is no parameter of the format.
    pub(super) about: Option<&'a str>,
}

impl<'a> From<&'a str> for Caption<'a> {
    fn from(text: &'a str) -> Self {
        Self {
            text,
            name: "",
            info: None,
            about: None,
        }
    }
}

impl<'a> From<(&'a str, &'a str)> for Caption<'a> {
    fn from((text, name): (&'a str, &'a str)) -> Self {
        Self {
            name,
            ..Self::from(text)
        }
    }
}

impl<'a> From<&'a String> for Caption<'a> {
    fn from(text: &'a String) -> Self {
        Self::from(text.as_str())
    }
}

impl<'a> Caption<'a> {
    /// Returns the caption with the same explanation under another name.
    pub(crate) fn titled(self, text: &'a str) -> Self {
        Self { text, ..self }
    }

    /// The caption with this tool tip in place of the explanation of a parameter.
    pub(crate) fn explained(self, about: &'a str) -> Self {
        Self {
            info: None,
            about: Some(about),
            ..self
        }
    }

    /// The caption of a component of the value, which has no explanation of its own.
    pub(crate) fn part(self, text: &'a str) -> Self {
        Self {
            text,
            info: None,
            ..self
        }
    }
}

impl From<&'static ParameterInfo> for Caption<'_> {
    fn from(info: &'static ParameterInfo) -> Self {
        Self {
            text: info.label,
            name: info.name,
            info: Some(info),
            about: None,
        }
    }
}

#[cfg(test)]
mod tests {
    use bevy::math::Vec3;
    use bevy_egui::egui;

    use super::*;
    use crate::app::editor::panels::fields::NAME_WIDTH;
    use crate::color::Rgb;
    use crate::scene::texture_parameters::{
        COLOR0, COLOR1, FILENAME, FILTER_TYPE, NAME, RAW, SCALE, TIMES, TO_UV, WRAP_MODE, WRAP_MODE_V,
    };
    use crate::scene::{
        Absorption, Coefficients, ConductorIor, Declared, Distribution, Emitter, EmitterKind, Material, Medium,
        ParameterRef, PhaseFunction, Principled, PrincipledIndex, Roughness, SunPosition, SunSky,
    };

    /// The declarations of all parameters.
    fn declared() -> Vec<&'static ParameterInfo> {
        let mut materials: Vec<Material> = Material::PLUGINS.into_iter().filter_map(Material::of_plugin).collect();
        materials.push(Material::RoughConductor {
            distribution: Distribution::Ggx,
            alpha: Roughness::Anisotropic {
                u: 0.1.into(),
                v: 0.2.into(),
            },
            ior: ConductorIor::Given {
                eta: Rgb::ONE.into(),
                k: Rgb::ONE.into(),
            },
            specular_reflectance: Rgb::ONE.into(),
            multiple_scattering: true,
        });
        let by_index = Principled {
            index: PrincipledIndex::Eta(1.5),
            ..Principled::default()
        };
        materials.push(Material::Principled(by_index.into()));
        let mut hair = Material::of_plugin("hair").expect("a plugin");
        if let Material::Hair { absorption, .. } = &mut hair {
            *absorption = Absorption::Given {
                sigma_a: Rgb::ONE.into(),
                scale: 1.0,
            };
        }
        materials.push(hair);
        let mut emitters: Vec<Emitter> = Emitter::PLUGINS.into_iter().filter_map(Emitter::of_plugin).collect();
        let by_direction = SunSky {
            sun: SunPosition::Direction(Vec3::X),
            ..SunSky::default()
        };
        emitters.push(EmitterKind::SunSky(by_direction).into());
        let mut found = vec![
            &FILENAME,
            &FILTER_TYPE,
            &WRAP_MODE,
            &WRAP_MODE_V,
            &TIMES,
            &RAW,
            &TO_UV,
            &COLOR0,
            &COLOR1,
            &NAME,
            &SCALE,
        ];
        let mut parts = Vec::new();
        let mut meet = |info: &'static ParameterInfo, value: ParameterRef| {
            found.push(info);
            value.in_file(info, &mut |info, _| parts.push(info));
        };
        let media = [
            Medium::default(),
            Medium {
                coefficients: Coefficients::Separate {
                    sigma_s: Rgb::ONE,
                    sigma_a: Rgb::ONE,
                },
                ..Medium::default()
            },
        ];
        media.iter().for_each(|medium| medium.visit(&mut meet));
        let phases = PhaseFunction::PLUGINS.into_iter().filter_map(PhaseFunction::of_plugin);
        let phases: Vec<PhaseFunction> = phases.collect();
        phases.iter().for_each(|phase| phase.visit(&mut meet));
        materials.iter().for_each(|material| material.visit(&mut meet));
        emitters.iter().for_each(|emitter| emitter.visit(&mut meet));
        found.extend(parts);
        found
    }

    #[test]
    fn every_parameter_is_explained() {
        let declared = declared();
        let is_missing =
            |info: &&&ParameterInfo| info.label.is_empty() || info.about.is_empty() || info.values.is_empty();
        assert_eq!(declared.iter().find(is_missing), None);
        // The format has about as many, so that the collection cannot be empty.
        assert!(declared.len() > 150, "{}", declared.len());
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
            widths = declared()
                .into_iter()
                .map(|info| (info.label, width(info.label)))
                .collect();
        })
        .run();
        assert!(!widths.is_empty());
        for (label, width) in widths {
            assert!(width <= NAME_WIDTH, "{label}: {width}");
        }
    }
}
