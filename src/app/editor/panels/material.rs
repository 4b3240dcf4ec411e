//! The parameters of a material, and what kind it is.

use std::ops::RangeInclusive;

use bevy::math::Vec3;
use bevy_egui::egui::Ui;

use super::fields;
use crate::color::Rgb;
use crate::scene::{
    ConductorIor, Distribution, HEIGHT, Ior, Material, Parameter, ParameterVisitor, PrincipledIndex, Roughness, Texture,
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

/// What plugins are called in lists, where not by their own name.
const KINDS: [(&str, &str); 10] = [
    ("roughconductor", "rough conductor"),
    ("roughdielectric", "rough dielectric"),
    ("thindielectric", "thin dielectric"),
    ("roughplastic", "rough plastic"),
    ("twosided", "two-sided"),
    ("blendbsdf", "blend"),
    ("normalmap", "normal map"),
    ("bumpmap", "bump map"),
    ("null", "nothing"),
    ("metal", "metal with fuzz"),
];

/// What parameters are called, where not by their own name.
const LABELS: [(&str, &str); 13] = [
    ("alpha", "Roughness"),
    ("diffuse_reflectance", "Base"),
    ("specular_reflectance", "Reflection"),
    ("multiple_scattering", "All bounces"),
    ("specular_transmittance", "Transmission"),
    ("int_ior", "Inside"),
    ("ext_ior", "Outside"),
    ("flip_invalid_normals", "Flip invalid"),
    ("use_shadowing_function", "Soft shadows"),
    ("mis_compensation", "MIS compensation"),
    ("sampling_weight", "Sampled"),
    ("sun_aperture", "Sun size"),
    ("complex_sun", "Dark rim"),
];

/// The units of numbers that have one.
const UNITS: [(&str, &str); 4] = [("timezone", " h"), ("hour", " h"), ("minute", " min"), ("second", " s")];

/// What the user did with the rows of a material or a light.
#[derive(Clone, Copy, Debug, Default)]
pub struct Edit {
    pub changed: bool,
    /// The parameter that is to be another picture.
    pub wants_picture: Option<&'static str>,
}

pub fn material(ui: &mut Ui, material: &mut Material) -> Edit {
    let plugin = material.plugin();
    let mut wanted = plugin;
    let mut changed = false;
    // What has others inside keeps its kind: the file decides there.
    if *material.nested_count().end() > 0 {
        fields::note(ui, "Type", kind_name(material));
    } else {
        let plugins = Material::PLUGINS.iter().filter(|plugin| {
            let nested = Material::of_plugin(plugin).map_or(0, |material| *material.nested_count().end());
            nested == 0
        });
        let options: Vec<_> = plugins.map(|&plugin| (plugin, in_words(&KINDS, plugin))).collect();
        changed |= fields::choice(ui, "Type", &mut wanted, &options);
    }
    if wanted != plugin {
        *material = turned_into(material, wanted);
        return Edit {
            changed: true,
            wants_picture: None,
        };
    }
    let mut rows = Rows::new(ui);
    material.visit(&mut rows);
    Edit {
        changed: rows.edit.changed || changed,
        ..rows.edit
    }
}

/// The name of the kind, for lists.
pub fn kind_name(material: &Material) -> &'static str {
    in_words(&KINDS, material.plugin())
}

/// A material of another kind that keeps the parameters that the two have in common.
fn turned_into(material: &Material, plugin: &str) -> Material {
    let mut turned = Material::of_plugin(plugin).unwrap_or_default();
    let mut common = Common::default();
    material.clone().visit(&mut common);
    common.given = true;
    turned.visit(&mut common);
    turned
}

/// First collects the parameters of one material, then gives them to another.
#[derive(Default)]
struct Common {
    given: bool,
    colors: Vec<(&'static str, Parameter<Rgb>)>,
    floats: Vec<(&'static str, Parameter<f32>)>,
    numbers: Vec<(&'static str, f32)>,
    flags: Vec<(&'static str, bool)>,
    iors: Vec<(&'static str, Ior)>,
    conductor: Vec<((), ConductorIor)>,
    distribution: Vec<((), Distribution)>,
    roughness: Vec<((), Roughness)>,
    principled_index: Vec<((), PrincipledIndex)>,
}

fn exchange<N: PartialEq, T: Clone>(given: bool, known: &mut Vec<(N, T)>, name: N, value: &mut T) {
    if !given {
        known.push((name, value.clone()));
    } else if let Some((_, common)) = known.iter().find(|(known, _)| *known == name) {
        *value = common.clone();
    }
}

impl ParameterVisitor for Common {
    fn reflectance(&mut self, name: &'static str, value: &mut Parameter<Rgb>) {
        exchange(self.given, &mut self.colors, name, value);
    }

    fn color(&mut self, name: &'static str, value: &mut Parameter<Rgb>) {
        exchange(self.given, &mut self.colors, name, value);
    }

    fn float(&mut self, name: &'static str, value: &mut Parameter<f32>, _range: RangeInclusive<f32>) {
        exchange(self.given, &mut self.floats, name, value);
    }

    fn number(&mut self, name: &'static str, value: &mut f32, _range: RangeInclusive<f32>) {
        exchange(self.given, &mut self.numbers, name, value);
    }

    fn flag(&mut self, name: &'static str, value: &mut bool) {
        exchange(self.given, &mut self.flags, name, value);
    }

    fn ior(&mut self, name: &'static str, value: &mut Ior) {
        exchange(self.given, &mut self.iors, name, value);
    }

    fn conductor_ior(&mut self, value: &mut ConductorIor) {
        exchange(self.given, &mut self.conductor, (), value);
    }

    fn distribution(&mut self, value: &mut Distribution) {
        exchange(self.given, &mut self.distribution, (), value);
    }

    fn roughness(&mut self, value: &mut Roughness) {
        exchange(self.given, &mut self.roughness, (), value);
    }

    fn principled_index(&mut self, value: &mut PrincipledIndex) {
        exchange(self.given, &mut self.principled_index, (), value);
    }
}

/// One row, or a few, for each parameter.
pub struct Rows<'u> {
    pub ui: &'u mut Ui,
    pub edit: Edit,
}

impl<'u> Rows<'u> {
    pub fn new(ui: &'u mut Ui) -> Self {
        let edit = Edit::default();
        Self { ui, edit }
    }

    /// A texture is named, with its picture; it can be given up for `otherwise`, and the picture for another.
    pub fn texture<T>(&mut self, name: &'static str, value: &mut Parameter<T>, otherwise: T) {
        if let Parameter::Texture(texture) = value
            && self.texture_row(name, texture)
        {
            *value = Parameter::Constant(otherwise);
        }
    }

    /// Whether the texture is to go.
    pub fn texture_row(&mut self, name: &'static str, texture: &Texture) -> bool {
        let shown = match texture {
            Texture::Bitmap(bitmap) => bitmap
                .path
                .file_name()
                .unwrap_or_default()
                .to_string_lossy()
                .into_owned(),
            Texture::Checkerboard { .. } => "checkerboard".to_owned(),
            Texture::MeshAttribute { name, .. } => name.clone(),
        };
        let label = label(name);
        let (replace, choose) = self
            .ui
            .horizontal(|ui| {
                let replace = ui
                    .small_button("\u{d7}")
                    .on_hover_text("Replace the texture by a constant");
                let choose = ui.small_button("\u{2026}").on_hover_text("Choose a picture");
                fields::note(ui, &label, shown);
                (replace.clicked(), choose.clicked())
            })
            .inner;
        if choose {
            self.edit.wants_picture = Some(name);
        }
        self.edit.changed |= replace;
        replace
    }

    /// A picture that is to be had, `shown` as what it is now.
    pub fn choose_picture(&mut self, name: &'static str, label: &str, shown: &str) {
        let chosen = self
            .ui
            .horizontal(|ui| {
                let choose = ui.small_button("\u{2026}").on_hover_text("Choose a picture");
                fields::note(ui, label, shown);
                choose.clicked()
            })
            .inner;
        if chosen {
            self.edit.wants_picture = Some(name);
        }
    }
}

impl ParameterVisitor for Rows<'_> {
    fn reflectance(&mut self, name: &'static str, value: &mut Parameter<Rgb>) {
        let label = label(name);
        match value {
            Parameter::Constant(color) => self.edit.changed |= fields::color(self.ui, &label, color),
            Parameter::Texture(_) => self.texture(name, value, Rgb::splat(0.5)),
        }
    }

    fn color(&mut self, name: &'static str, value: &mut Parameter<Rgb>) {
        let label = label(name);
        match value {
            Parameter::Constant(color) => self.edit.changed |= positive(self.ui, &label, color),
            Parameter::Texture(_) => self.texture(name, value, Rgb::ONE),
        }
    }

    fn float(&mut self, name: &'static str, value: &mut Parameter<f32>, range: RangeInclusive<f32>) {
        let label = label(name);
        match value {
            Parameter::Constant(number) => self.edit.changed |= fields::slider(self.ui, &label, number, range),
            Parameter::Texture(_) => self.texture(name, value, 0.5),
        }
    }

    fn height(&mut self, value: &mut Parameter<f32>) {
        match value {
            Parameter::Constant(_) => fields::note(self.ui, &label(HEIGHT), "flat"),
            Parameter::Texture(_) => self.texture(HEIGHT, value, 0.0),
        }
    }

    fn number(&mut self, name: &'static str, value: &mut f32, range: RangeInclusive<f32>) {
        let unit = UNITS
            .iter()
            .find(|(known, _)| *known == name)
            .map_or("", |(_, unit)| unit);
        self.edit.changed |= fields::quantity(self.ui, &label(name), value, 0.01, range, unit);
    }

    fn flag(&mut self, name: &'static str, value: &mut bool) {
        self.edit.changed |= fields::checkbox(self.ui, &label(name), value);
    }

    fn ior(&mut self, name: &'static str, value: &mut Ior) {
        self.edit.changed |= dielectric_ior(self.ui, &label(name), value);
    }

    fn conductor_ior(&mut self, value: &mut ConductorIor) {
        let chosen = choose_conductor(self.ui, value);
        self.edit.changed |= chosen;
        if let ConductorIor::Given { eta, k } = value {
            self.color("eta", eta);
            self.color("k", k);
        }
    }

    fn distribution(&mut self, value: &mut Distribution) {
        let options = [(Distribution::Beckmann, "Beckmann"), (Distribution::Ggx, "GGX")];
        self.edit.changed |= fields::choice(self.ui, "Facets", value, &options);
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
    }

    fn principled_index(&mut self, value: &mut PrincipledIndex) {
        self.edit.changed |= match value {
            PrincipledIndex::Specular(specular) => fields::slider(self.ui, "Specular", specular, 0.0..=1.0),
            PrincipledIndex::Eta(eta) => fields::slider(self.ui, "Index", eta, 1.0..=3.0),
        };
    }
}

/// What a parameter is called in the panel.
pub fn label(name: &'static str) -> String {
    if let Some((_, label)) = LABELS.iter().find(|(known, _)| *known == name) {
        return (*label).to_owned();
    }
    let spaced = name.replace('_', " ");
    let mut letters = spaced.chars();
    let first = letters.next().map(|letter| letter.to_ascii_uppercase());
    first.into_iter().chain(letters).collect()
}

fn choose_conductor(ui: &mut Ui, ior: &mut ConductorIor) -> bool {
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
    let changed = fields::choice(ui, "Metal", &mut choice, &options);
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

fn in_words<'n>(names: &[(&str, &'static str)], name: &'n str) -> &'n str
where
    'static: 'n,
{
    names
        .iter()
        .find(|(known, _)| *known == name)
        .map_or(name, |(_, words)| words)
}

fn positive(ui: &mut Ui, name: &str, value: &mut Vec3) -> bool {
    let changed = fields::vector(ui, name, value, 0.01, "");
    if changed {
        *value = value.max(Vec3::splat(1e-3));
    }
    changed
}

fn dielectric_ior(ui: &mut Ui, side: &str, ior: &mut Ior) -> bool {
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
    let mut changed = fields::choice(ui, side, &mut choice, &options);
    if changed {
        *ior = match choice {
            NUMBER => Ior::Number(ior::dielectric_ior(&current).unwrap_or(1.5)),
            name => Ior::Named(name.to_owned()),
        };
    }
    if let Ior::Number(index) = ior {
        changed |= fields::slider(ui, &format!("{side} index"), index, 1.0..=3.0);
    }
    changed
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn turning_keeps_what_is_common() {
        let red = Material::Diffuse {
            reflectance: Rgb::new(0.6, 0.1, 0.1).into(),
        };
        let metal = turned_into(&red, "metal");
        assert_eq!(turned_into(&metal, "diffuse"), red);
        let mut gold = Material::of_plugin("conductor").expect("a plugin");
        let Material::Conductor { ior, .. } = &mut gold else {
            panic!("{gold:?}")
        };
        *ior = ConductorIor::Named("Au".into());
        let rough = turned_into(&gold, "roughconductor");
        assert!(matches!(&rough, Material::RoughConductor { ior, .. } if *ior == ConductorIor::Named("Au".into())));
    }

    #[test]
    fn labels_are_words() {
        assert_eq!(label("alpha"), "Roughness");
        assert_eq!(label("spec_tint"), "Spec tint");
    }
}
