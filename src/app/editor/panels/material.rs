//! The parameters of a material, and what kind it is.

use std::ops::RangeInclusive;

use bevy::math::Vec3;
use bevy_egui::egui::Ui;

use super::color_field;
use super::fields::{self, Caption};
use super::plain_value::PlainValue;
use super::texture_slot::Slot;
use crate::app::editor::command::conversion::turned_into;
use crate::app::editor::model::MaterialPlace;
use crate::app::editor::model::panel_textures::PanelTextures;
use crate::app::editor::words::kinds::{in_words, material_kind, plugin_name};
use crate::app::editor::words::parameters as words;
use crate::color::Rgb;
use crate::scene::{
    ConductorIor, Distribution, HEIGHT, Ior, Material, NORMALS, Parameter, ParameterVisitor, PrincipledIndex,
    Roughness, SquarePath,
};
use crate::shading::ior::{self, CONDUCTORS, DIELECTRICS};

/// What some of the format's conductors are called in words.
const METALS: [(&str, &str); 7] = [
    ("none", "perfect mirror"),
    ("Ag", "Ag, silver"),
    ("Al", "Al, aluminium"),
    ("Au", "Au, gold"),
    ("Cr", "Cr, chromium"),
    ("Cu", "Cu, copper"),
    ("W", "W, tungsten"),
];

/// What the user did with the rows of a material or a light.
#[derive(Clone, Copy, Debug, Default)]
pub struct Edit {
    /// Whether a value is another than before.
    pub changed: bool,
    /// The parameter that is to be another picture, and the place in it.
    pub wants_picture: Option<(&'static str, SquarePath)>,
}

/// `place`: what the material is within another.
pub fn material(ui: &mut Ui, material: &mut Material, place: MaterialPlace, textures: &PanelTextures) -> Edit {
    let plugin = material.plugin();
    let mut wanted = plugin;
    // What has others inside keeps its kind here.
    if *material.nested_count().end() > 0 {
        fields::note(ui, "Type", material_kind(material));
    } else {
        let plugins = Material::PLUGINS.iter().filter(|plugin| {
            let is_offered = |other: Material| *other.nested_count().end() == 0 && place.takes(&other);
            **plugin == material.plugin() || Material::of_plugin(plugin).is_some_and(is_offered)
        });
        let options: Vec<_> = plugins.map(|&plugin| (plugin, plugin_name(plugin))).collect();
        fields::choice(ui, "Type", &mut wanted, &options);
    }
    if wanted != plugin {
        *material = turned_into(material, wanted);
        return Edit {
            changed: true,
            wants_picture: None,
        };
    }
    let mut rows = Rows::new(ui, plugin, textures);
    material.visit(&mut rows);
    rows.edit
}

/// One row, or a few, for each parameter.
pub struct Rows<'u> {
    /// Where the rows are shown.
    pub ui: &'u mut Ui,
    /// What the user did with the rows so far.
    pub edit: Edit,
    plugin: &'static str,
    textures: &'u PanelTextures,
}

impl<'u> Rows<'u> {
    /// Begins with the rows of a plugin.
    pub fn new(ui: &'u mut Ui, plugin: &'static str, textures: &'u PanelTextures) -> Self {
        Self {
            ui,
            edit: Edit::default(),
            plugin,
            textures,
        }
    }

    /// What the parameter is called in the panel, with its explanation.
    pub fn caption(&self, name: &'static str) -> Caption<'static> {
        words::find(self.plugin, name).map_or(Caption::from(name), Caption::from)
    }

    /// A parameter that may be a texture; `plain` is what its value is called where it is none, `otherwise` the value if the texture has
    /// none to give back.
    pub(crate) fn slot<T: PlainValue>(
        &mut self,
        name: &'static str,
        plain: &'static str,
        value: &mut Parameter<T>,
        otherwise: T,
        plain_rows: impl FnOnce(&mut Ui, Caption<'_>, &mut T) -> bool,
    ) {
        let slot = Slot {
            caption: self.caption(name),
            plain,
            textures: self.textures,
            place: SquarePath::WHOLE,
        };
        let edit = slot.show(self.ui, value, otherwise, plain_rows);
        self.edit.changed |= edit.changed;
        if let Some(place) = edit.wants_picture {
            self.edit.wants_picture = Some((name, place));
        }
    }

    /// What stands behind the parameter's number.
    pub fn unit(&self, name: &str) -> &'static str {
        words::find(self.plugin, name).map_or("", |words| words.suffix)
    }

    /// The pictures that are shown in rows of textures.
    pub fn textures(&self) -> &'u PanelTextures {
        self.textures
    }
}

impl ParameterVisitor for Rows<'_> {
    fn reflectance(&mut self, name: &'static str, value: &mut Parameter<Rgb>) {
        if name == NORMALS {
            // Straight up.
            let flat = Rgb::new(0.5, 0.5, 1.0);
            return self.slot(name, "none", value, flat, |ui, caption, _| note(ui, caption, "flat"));
        }
        self.slot(name, "colour", value, Rgb::splat(0.5), |ui, caption, color| {
            color_field::color(ui, caption, color)
        });
    }

    fn color(&mut self, name: &'static str, value: &mut Parameter<Rgb>) {
        self.slot(name, "numbers", value, Rgb::ONE, |ui, caption, color| {
            positive(ui, caption, color)
        });
    }

    fn float(&mut self, name: &'static str, value: &mut Parameter<f32>, range: RangeInclusive<f32>) {
        self.slot(name, "number", value, 0.5, |ui, caption, number| {
            fields::slider(ui, caption, number, range)
        });
    }

    fn height(&mut self, value: &mut Parameter<f32>) {
        self.slot(HEIGHT, "none", value, 0.0, |ui, caption, _| note(ui, caption, "flat"));
    }

    fn number(&mut self, name: &'static str, value: &mut f32, range: RangeInclusive<f32>) {
        let unit = self.unit(name);
        if is_light_factor(self.plugin, name) {
            self.edit.changed |= fields::strength(self.ui, self.caption(name), value, unit);
            return;
        }
        self.edit.changed |= fields::quantity(self.ui, self.caption(name), value, 0.01, range, unit);
    }

    fn flag(&mut self, name: &'static str, value: &mut bool) {
        self.edit.changed |= fields::checkbox(self.ui, self.caption(name), value);
    }

    fn ior(&mut self, name: &'static str, value: &mut Ior) {
        self.edit.changed |= dielectric_ior(self.ui, self.caption(name), value);
    }

    fn conductor_ior(&mut self, value: &mut ConductorIor) {
        let chosen = choose_conductor(self.ui, self.caption("material"), value);
        self.edit.changed |= chosen;
        if let ConductorIor::Given { eta, k } = value {
            self.color("eta", eta);
            self.color("k", k);
        }
    }

    fn distribution(&mut self, value: &mut Distribution) {
        let options = [(Distribution::Beckmann, "Beckmann"), (Distribution::Ggx, "GGX")];
        self.edit.changed |= fields::choice(self.ui, self.caption("distribution"), value, &options);
    }

    fn roughness(&mut self, value: &mut Roughness) {
        // To zero it would be no rough surface.
        const RANGE: RangeInclusive<f32> = 0.001..=1.0;
        match value {
            Roughness::Isotropic(alpha) => self.float("alpha", alpha, RANGE),
            Roughness::Anisotropic { u, v } => {
                self.float("alpha_u", u, RANGE);
                self.float("alpha_v", v, RANGE);
            }
        }
        // The format's `roughplastic` has one roughness for all directions.
        if self.plugin != "roughplastic" {
            let is_brushed = matches!(value, Roughness::Anisotropic { .. });
            let mut brushed = is_brushed;
            if fields::checkbox(self.ui, self.caption("alpha_u").titled("Brushed"), &mut brushed) {
                *value = turned_roughness(value);
                self.edit.changed = true;
            }
        }
    }

    fn principled_index(&mut self, value: &mut PrincipledIndex) {
        let ways = [(false, "reflectance"), (true, "index of refraction")];
        let by_index = matches!(value, PrincipledIndex::Eta(_));
        let mut wanted = by_index;
        if fields::choice(
            self.ui,
            self.caption("specular").titled("Mirrors by"),
            &mut wanted,
            &ways,
        ) {
            *value = turned_index(*value);
            self.edit.changed = true;
        }
        self.edit.changed |= match value {
            PrincipledIndex::Specular(specular) => {
                fields::slider(self.ui, self.caption("specular"), specular, 0.0..=1.0)
            }
            PrincipledIndex::Eta(eta) => fields::slider(self.ui, self.caption("eta"), eta, 1.0..=3.0),
        };
    }
}

/// What is turned up and down over decades.
fn is_light_factor(plugin: &str, name: &str) -> bool {
    matches!(
        (plugin, name),
        ("envmap" | "projector", "scale") | ("sunsky", "sun_scale" | "sky_scale")
    )
}

/// One roughness as two, or the first of two as one.
fn turned_roughness(roughness: &Roughness) -> Roughness {
    match roughness {
        Roughness::Isotropic(alpha) => Roughness::Anisotropic {
            u: alpha.clone(),
            v: alpha.clone(),
        },
        Roughness::Anisotropic { u, .. } => Roughness::Isotropic(u.clone()),
    }
}

/// The other way to say how strongly it mirrors head on: 0.08 `specular` = ((eta - 1) / (eta + 1))^2 (Burley, Physically-Based Shading at
/// Disney, 2012, section 5.5).
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
    options.extend(CONDUCTORS.iter().map(|(name, ..)| (*name, in_words(&METALS, name))));
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

fn dielectric_ior(ui: &mut Ui, caption: Caption<'_>, ior: &mut Ior) -> bool {
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
        changed |= fields::slider(ui, caption.titled(&title), index, 1.0..=3.0);
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
