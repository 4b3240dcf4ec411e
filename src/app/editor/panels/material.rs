//! The parameters of a material, and its kind.

use bevy::math::Vec3;
use bevy_egui::egui::Ui;

use super::caption::Caption;
use super::color_field;
use super::fields;
use super::light_strength::{StrengthUnits, light_strength};
use super::plain_value::PlainValue;
use super::sensor::field_of_view;
use super::texture_slot::Slot;
use crate::app::editor::command::conversion::turned_into;
use crate::app::editor::model::MaterialPlace;
use crate::app::editor::model::light_figures::LightFigures;
use crate::app::editor::model::panel_textures::PanelTextures;
use crate::color::Rgb;
use crate::scene::parameters::{
    ABSORPTION_SCALE, ALPHA, ALPHA_U, ALPHA_V, ETA, EUMELANIN, K, PHEOMELANIN, PRINCIPLED_ETA, SIGMA_A, SPECULAR,
};
use crate::scene::{
    Absorption, ConductorIor, Declared, Distribution, FLUX, Ior, Material, Parameter, ParameterInfo, ParameterMut,
    PrincipledIndex, Roughness, SquarePath,
};
use crate::shading::ior::{self, CONDUCTORS, DIELECTRICS};
use crate::shading::melanin_absorption;

/// The words for some of the format's conductors.
const METALS: [(&str, &str); 7] = [
    ("none", "perfect mirror"),
    ("Ag", "Ag, silver"),
    ("Al", "Al, aluminium"),
    ("Au", "Au, gold"),
    ("Cr", "Cr, chromium"),
    ("Cu", "Cu, copper"),
    ("W", "W, tungsten"),
];

/// The row for the plugin of a material or a light.
pub(crate) const TYPE: (&str, &str) = ("Type", "type");

/// The edits of the user in the rows of a material or a light.
#[derive(Clone, Copy, Debug, Default)]
pub struct Edit {
    /// Whether a value has changed.
    pub changed: bool,
    /// The parameter whose picture is to be chosen, and the place in it.
    pub wants_picture: Option<(&'static str, SquarePath)>,
}

/// Shows the rows of a material. `place` is the material's role within another.
pub fn material(ui: &mut Ui, material: &mut Material, place: MaterialPlace, textures: &PanelTextures) -> Edit {
    let info = material.info();
    let mut wanted = info.name;
    // The kind of a material with nested ones is not edited here.
    if *info.nested.end() > 0 {
        fields::note(ui, TYPE, info.label);
    } else {
        let plugins = Material::DECLARED.iter().filter(|other| {
            let is_taken = || Material::usual(other.name).is_some_and(|other| place.takes(other));
            other.name == info.name || (*other.nested.end() == 0 && is_taken())
        });
        let options: Vec<_> = plugins.map(|plugin| (plugin.name, plugin.label)).collect();
        fields::choice(ui, TYPE, &mut wanted, &options);
    }
    if wanted != info.name {
        *material = turned_into(material, wanted);
        return Edit {
            changed: true,
            wants_picture: None,
        };
    }
    let mut rows = Rows::new(ui, textures);
    material.visit_mut(&mut |info, value| rows.parameter(info, value));
    rows.edit
}

/// Shows one row, or a few, for each parameter.
pub(crate) struct Rows<'u> {
    /// The panel in which the rows are shown.
    pub ui: &'u mut Ui,
    /// The edits of the user so far.
    pub edit: Edit,
    /// The pictures that are shown in rows of textures.
    pub textures: &'u PanelTextures,
    /// The figures of the light that the rows show.
    pub figures: &'u LightFigures,
}

impl<'u> Rows<'u> {
    /// Begins with the rows of a plugin.
    pub fn new(ui: &'u mut Ui, textures: &'u PanelTextures) -> Self {
        Self {
            ui,
            edit: Edit::default(),
            textures,
            figures: &NO_LIGHT,
        }
    }

    /// The units of the strength of a parameter.
    pub(super) fn units(&self, info: &'static ParameterInfo) -> StrengthUnits<'u> {
        StrengthUnits {
            radiometric: info.unit,
            parameter: info.name,
            measures: &self.figures.measures,
        }
    }
}

/// The figures of what is no light.
static NO_LIGHT: LightFigures = LightFigures {
    measures: Vec::new(),
    own_flux: None,
    emitted: None,
    curves: None,
};

impl Rows<'_> {
    pub(crate) fn parameter(&mut self, info: &'static ParameterInfo, value: ParameterMut) {
        match value {
            ParameterMut::Reflectance(value) => {
                self.texturable(info, "colour", value, Rgb::splat(0.5), |ui, caption, color| {
                    color_field::color(ui, caption, color)
                });
            }
            ParameterMut::Normals(value) => {
                let straight_up = Rgb::new(0.5, 0.5, 1.0);
                self.texturable(info, "none", value, straight_up, |ui, caption, _| {
                    note(ui, caption, "flat")
                });
            }
            ParameterMut::Float(value) => self.float(info, value),
            ParameterMut::Height(value) => {
                self.texturable(info, "none", value, 0.0, |ui, caption, _| note(ui, caption, "flat"));
            }
            ParameterMut::Number(value) if info.name == FLUX.name => self.flux(value),
            ParameterMut::Number(value) if info.offered.is_some() => {
                self.edit.changed |= fields::slider(self.ui, info, value, info.slider_range());
            }
            ParameterMut::Number(value) | ParameterMut::SamplingWeight(value) => {
                self.edit.changed |= fields::quantity(self.ui, info, value, 0.01, info.range.clone(), info.unit);
            }
            ParameterMut::Flag(value) | ParameterMut::Extension(value) => {
                self.edit.changed |= fields::checkbox(self.ui, info, value);
            }
            ParameterMut::Ior(value) => self.edit.changed |= dielectric_ior(self.ui, info, value),
            ParameterMut::ConductorIor(value) => self.conductor_ior(info, value),
            ParameterMut::Distribution(value) => {
                self.edit.changed |= fields::choice(self.ui, info, value, &Distribution::LABELED);
            }
            ParameterMut::Roughness(value) => self.roughness(value),
            ParameterMut::UniformRoughness(value) => self.alphas(value),
            ParameterMut::PrincipledIndex(value) => self.principled_index(value),
            ParameterMut::Absorption(value) => self.absorption(info, value),
            ParameterMut::Emission(value) => {
                let units = self.units(info);
                self.edit.changed |= color_field::emission(self.ui, info, units, 0.0, value);
            }
            ParameterMut::TexturedEmission(value) => self.textured_emission(info, value),
            ParameterMut::UniformReflectance(value) => self.edit.changed |= color_field::color(self.ui, info, value),
            ParameterMut::Factor(value) | ParameterMut::ExtensionFactor(value) => {
                let units = self.units(info);
                self.edit.changed |= light_strength(self.ui, info, units, 1.0, value);
            }
            ParameterMut::Angle(value) => {
                self.edit.changed |= fields::quantity(self.ui, info, value, 0.1, info.range.clone(), info.unit);
            }
            ParameterMut::Integer(value) => {
                let range = *info.range.start() as i32..=*info.range.end() as i32;
                self.edit.changed |= fields::integer(self.ui, info, value, range);
            }
            ParameterMut::Picture(value) => self.picture(info, value),
            ParameterMut::OptionalTexture(value) => self.optional_texture(info, value),
            ParameterMut::Cone(value) => self.cone(value),
            ParameterMut::FieldOfView(value) => {
                self.edit.changed |= field_of_view(self.ui, &mut value.fov, &mut value.axis);
            }
            ParameterMut::SunPosition(value) => self.sun_position(info, value),
            ParameterMut::Coefficients(value) => self.coefficients(value),
            ParameterMut::VolumeEmission(value) => self.volume_emission(info, value),
            ParameterMut::VolumeShare(value) => self.volume_share(info, value),
            ParameterMut::Values(value) => self.values(info, value),
            // Building parts and patterns have rows of their own.
            ParameterMut::Length(_)
            | ParameterMut::Count(_)
            | ParameterMut::Openings(_)
            | ParameterMut::Nested(_)
            | ParameterMut::Placing(_)
            | ParameterMut::Choice(_)
            | ParameterMut::Stops(_) => {}
        }
    }

    /// Shows a parameter that may be a texture; `plain` is the name of its value without one, `otherwise` the value if
    /// the texture has none to restore.
    pub(crate) fn texturable<T: PlainValue>(
        &mut self,
        info: &'static ParameterInfo,
        plain: &'static str,
        value: &mut Parameter<T>,
        otherwise: T,
        plain_rows: impl FnOnce(&mut Ui, Caption<'_>, &mut T) -> bool,
    ) {
        let slot = Slot {
            caption: info.into(),
            plain,
            textures: self.textures,
            place: SquarePath::WHOLE,
        };
        let edit = slot.show(self.ui, value, otherwise, plain_rows);
        self.edit.changed |= edit.changed;
        if let Some(place) = edit.wants_picture {
            self.edit.wants_picture = Some((info.name, place));
        }
    }

    fn float(&mut self, info: &'static ParameterInfo, value: &mut Parameter<f32>) {
        self.texturable(info, "number", value, 0.5, |ui, caption, number| {
            fields::slider(ui, caption, number, info.slider_range())
        });
    }

    fn conductor_ior(&mut self, info: &'static ParameterInfo, value: &mut ConductorIor) {
        self.edit.changed |= choose_conductor(self.ui, info.into(), value);
        if let ConductorIor::Given { eta, k } = value {
            for (info, value) in [(&ETA, eta), (&K, k)] {
                self.texturable(info, "numbers", value, Rgb::ONE, positive);
            }
        }
    }

    fn alphas(&mut self, value: &mut Roughness) {
        match value {
            Roughness::Isotropic(alpha) => self.float(&ALPHA, alpha),
            Roughness::Anisotropic { u, v } => {
                self.float(&ALPHA_U, u);
                self.float(&ALPHA_V, v);
            }
        }
    }

    fn roughness(&mut self, value: &mut Roughness) {
        self.alphas(value);
        let mut brushed = matches!(value, Roughness::Anisotropic { .. });
        if fields::checkbox(self.ui, Caption::from(&ALPHA_U).titled("Brushed"), &mut brushed) {
            *value = turned_roughness(value);
            self.edit.changed = true;
        }
    }

    fn principled_index(&mut self, value: &mut PrincipledIndex) {
        let ways = [(false, "specular level"), (true, "index of refraction")];
        let mut by_index = matches!(value, PrincipledIndex::Eta(_));
        let caption = Caption::from(&SPECULAR).titled("Reflects by");
        if fields::choice(self.ui, caption, &mut by_index, &ways) {
            *value = turned_index(*value);
            self.edit.changed = true;
        }
        self.edit.changed |= match value {
            PrincipledIndex::Specular(specular) => {
                fields::slider(self.ui, &SPECULAR, specular, SPECULAR.slider_range())
            }
            PrincipledIndex::Eta(eta) => fields::slider(self.ui, &PRINCIPLED_ETA, eta, PRINCIPLED_ETA.slider_range()),
        };
    }
}

impl Rows<'_> {
    fn absorption(&mut self, info: &'static ParameterInfo, value: &mut Absorption) {
        let mut is_given = matches!(value, Absorption::Given { .. });
        let ways = [(false, "pigments"), (true, "absorption")];
        if fields::choice(self.ui, Caption::from(info).titled("Colour by"), &mut is_given, &ways) {
            *value = turned_absorption(value);
            self.edit.changed = true;
        }
        let mut quantity = |ui: &mut Ui, info: &'static ParameterInfo, value: &mut f32| {
            self.edit.changed |= fields::quantity(ui, info, value, 0.01, info.range.clone(), info.unit);
        };
        match value {
            Absorption::Melanin { eumelanin, pheomelanin } => {
                quantity(self.ui, &EUMELANIN, eumelanin);
                quantity(self.ui, &PHEOMELANIN, pheomelanin);
            }
            Absorption::Given { sigma_a, scale } => {
                quantity(self.ui, &ABSORPTION_SCALE, scale);
                self.texturable(&SIGMA_A, "numbers", sigma_a, Rgb::ONE, positive);
            }
        }
    }
}

/// The absorption of given pigments, or else the pigments of new hair: few colours are those of any pigments.
fn turned_absorption(absorption: &Absorption) -> Absorption {
    match absorption {
        Absorption::Melanin { eumelanin, pheomelanin } => Absorption::Given {
            sigma_a: melanin_absorption(*eumelanin, *pheomelanin).into(),
            scale: ABSORPTION_SCALE.usual,
        },
        Absorption::Given { .. } => Absorption::default(),
    }
}

/// One roughness as two equal ones, or the first of two as one.
fn turned_roughness(roughness: &Roughness) -> Roughness {
    match roughness {
        Roughness::Isotropic(alpha) => Roughness::Anisotropic {
            u: alpha.clone(),
            v: alpha.clone(),
        },
        Roughness::Anisotropic { u, .. } => Roughness::Isotropic(u.clone()),
    }
}

/// The other parameter for the reflectance at normal incidence: 0.08 `specular` = ((eta - 1) / (eta + 1))^2 (Burley,
/// Physically-Based Shading at Disney, 2012, section 5.5).
fn turned_index(index: PrincipledIndex) -> PrincipledIndex {
    match index {
        PrincipledIndex::Specular(specular) => {
            let root = (0.08 * specular.clamp(0.0, 1.0)).sqrt();
            PrincipledIndex::Eta((1.0 + root) / (1.0 - root))
        }
        PrincipledIndex::Eta(eta) => {
            let root = (eta - 1.0) / (eta + 1.0);
            PrincipledIndex::Specular((root * root / 0.08).clamp(0.0, 1.0))
        }
    }
}

/// A row without anything to edit.
fn note(ui: &mut Ui, caption: Caption<'_>, text: &str) -> bool {
    fields::note(ui, caption, text);
    false
}

fn choose_conductor(ui: &mut Ui, caption: Caption<'_>, ior: &mut ConductorIor) -> bool {
    const GIVEN: &str = "numbers";
    let current = match ior {
        ConductorIor::Named(name) => name.clone(),
        ConductorIor::Given { .. } => GIVEN.to_owned(),
    };
    let mut options = vec![(GIVEN, "eta and k")];
    options.extend(CONDUCTORS.iter().map(|&(name, ..)| {
        let words = METALS.iter().find(|(known, _)| *known == name);
        (name, words.map_or(name, |(_, words)| words))
    }));
    if !options.iter().any(|(name, _)| *name == current) {
        options.push((&current, &current));
    }
    let mut choice = current.as_str();
    let changed = fields::choice(ui, caption, &mut choice, &options);
    if changed {
        *ior = match choice {
            GIVEN => {
                let (eta, k) = ior::conductor_ior(&current).unwrap_or((Rgb::ZERO, Rgb::ONE));
                ConductorIor::Given {
                    eta: eta.into(),
                    k: k.into(),
                }
            }
            name => ConductorIor::Named(name.to_owned()),
        };
    }
    changed
}

fn positive(ui: &mut Ui, caption: Caption<'_>, value: &mut Vec3) -> bool {
    let changed = fields::vector(ui, caption, value, 0.01, "");
    if changed {
        *value = value.max(Vec3::splat(1e-3));
    }
    changed
}

fn dielectric_ior(ui: &mut Ui, info: &'static ParameterInfo, ior: &mut Ior) -> bool {
    let caption = Caption::from(info);
    const NUMBER: &str = "number";
    let current = match ior {
        Ior::Named(name) => name.clone(),
        Ior::Number(_) => NUMBER.to_owned(),
    };
    let mut options = vec![(NUMBER, NUMBER)];
    options.extend(DIELECTRICS.iter().map(|(name, _)| (*name, *name)));
    if !options.iter().any(|(name, _)| *name == current) {
        options.push((&current, &current));
    }
    let mut choice = current.as_str();
    let mut changed = fields::choice(ui, caption, &mut choice, &options);
    if changed {
        *ior = match choice {
            NUMBER => Ior::Number(ior::dielectric_ior(&current).unwrap_or(1.5)),
            name => Ior::Named(name.to_owned()),
        };
    }
    if let Ior::Number(index) = ior {
        let title = format!("{} index", caption.text);
        changed |= fields::slider(ui, caption.titled(&title), index, info.slider_range());
    }
    changed
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn both_ways_to_say_the_index_agree() {
        // The default of 0.5 stands for 1.5: ((1.5 - 1) / (1.5 + 1))^2 = 0.04.
        let PrincipledIndex::Eta(eta) = turned_index(PrincipledIndex::Specular(0.5)) else {
            panic!("not an index")
        };
        assert!((eta - 1.5).abs() < 1e-5, "{eta}");
        let PrincipledIndex::Specular(specular) = turned_index(PrincipledIndex::Eta(eta)) else {
            panic!("not a share")
        };
        assert!((specular - 0.5).abs() < 1e-5, "{specular}");
    }
}
