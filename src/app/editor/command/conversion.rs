//! Materials and lights of another kind, which keep what both kinds have.

use std::ops::RangeInclusive;
use std::path::PathBuf;

use crate::color::Rgb;
use crate::scene::{
    ConductorIor, Distribution, Emitter, EmitterVisitor, FovAxis, Ior, Material, Parameter, ParameterVisitor,
    PrincipledIndex, Roughness, SunPosition, Texture,
};

/// A material of another kind that keeps the parameters that the two have in common. Those of the same meaning count as the same, such as
/// `reflectance`, `diffuse_reflectance` and `base_color`.
pub(crate) fn turned_into(material: &Material, plugin: &str) -> Material {
    let mut turned = Material::of_plugin(plugin).unwrap_or_default();
    let mut common = Common::default();
    material.clone().visit(&mut common);
    common.given = true;
    turned.visit(&mut common);
    turned
}

/// A light of another kind with the same colour and strength, whatever the unit, and the other parameters that the two have in common.
pub(crate) fn emitter_turned_into(emitter: &Emitter, plugin: &str) -> Emitter {
    let mut turned = Emitter::of_plugin(plugin).unwrap_or_default();
    let mut common = Common::default();
    emitter.clone().visit(&mut common);
    common.given = true;
    turned.visit(&mut common);
    turned
}

/// First collects the parameters of one plugin, then gives them to another.
#[derive(Default)]
struct Common {
    given: bool,
    colors: Vec<(&'static str, Parameter<Rgb>)>,
    floats: Vec<(&'static str, Parameter<f32>)>,
    numbers: Vec<(&'static str, f32)>,
    integers: Vec<(&'static str, i32)>,
    flags: Vec<(&'static str, bool)>,
    iors: Vec<(&'static str, Ior)>,
    pictures: Vec<((), PathBuf)>,
    textures: Vec<((), Texture)>,
    fields_of_view: Vec<((), (f32, FovAxis))>,
    conductor: Vec<((), ConductorIor)>,
    distribution: Vec<((), Distribution)>,
    roughness: Vec<((), Roughness)>,
    principled_index: Vec<((), PrincipledIndex)>,
}

/// One name for all that plugins call the colour of their matt part, and one for what they send out.
fn meaning(name: &'static str) -> &'static str {
    match name {
        "diffuse_reflectance" | "base_color" => "reflectance",
        "irradiance" | "intensity" => "radiance",
        other => other,
    }
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
        exchange(self.given, &mut self.colors, meaning(name), value);
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

impl EmitterVisitor for Common {
    fn emission(&mut self, name: &'static str, value: &mut Rgb) {
        let mut emitted = Parameter::Constant(*value);
        exchange(self.given, &mut self.colors, meaning(name), &mut emitted);
        *value = emitted.constant().unwrap_or(*value);
    }

    fn textured_emission(&mut self, name: &'static str, value: &mut Parameter<Rgb>) {
        exchange(self.given, &mut self.colors, meaning(name), value);
    }

    fn uniform_reflectance(&mut self, _name: &'static str, _value: &mut Rgb) {}

    fn integer(&mut self, name: &'static str, value: &mut i32, _range: RangeInclusive<i32>) {
        exchange(self.given, &mut self.integers, name, value);
    }

    fn angle(&mut self, name: &'static str, value: &mut f32, _range: RangeInclusive<f32>) {
        exchange(self.given, &mut self.numbers, name, value);
    }

    fn picture(&mut self, _name: &'static str, value: &mut PathBuf) {
        exchange(self.given, &mut self.pictures, (), value);
    }

    fn optional_texture(&mut self, _name: &'static str, value: &mut Option<Texture>) {
        if let Some(texture) = value {
            exchange(self.given, &mut self.textures, (), texture);
        }
    }

    fn cone(&mut self, _cutoff_angle: &mut f32, _beam_width: &mut f32) {}

    fn field_of_view(&mut self, fov: &mut f32, axis: &mut FovAxis) {
        let mut both = (*fov, *axis);
        exchange(self.given, &mut self.fields_of_view, (), &mut both);
        (*fov, *axis) = both;
    }

    fn sun_position(&mut self, _value: &mut SunPosition) {}

    fn sampling_weight(&mut self, value: &mut f32) {
        exchange(self.given, &mut self.numbers, "sampling_weight", value);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::EmitterKind;

    #[test]
    fn turning_keeps_what_is_common() {
        let red = Material::Diffuse {
            reflectance: Rgb::new(0.6, 0.1, 0.1).into(),
        };
        for plugin in ["metal", "plastic", "principled", "principledthin", "roughplastic"] {
            let turned = turned_into(&red, plugin);
            assert_eq!(turned.plugin(), plugin);
            assert_eq!(turned_into(&turned, "diffuse"), red, "{plugin}");
        }
        let mut gold = Material::of_plugin("conductor").expect("a plugin");
        let Material::Conductor { ior, .. } = &mut gold else {
            panic!("{gold:?}")
        };
        *ior = ConductorIor::Named("Au".into());
        let rough = turned_into(&gold, "roughconductor");
        assert!(matches!(&rough, Material::RoughConductor { ior, .. } if *ior == ConductorIor::Named("Au".into())));
    }

    #[test]
    fn a_light_keeps_its_colour_and_strength() {
        let warm = Rgb::new(30.0, 20.0, 10.0);
        let mut spot: Emitter = EmitterKind::Point { intensity: warm }.into();
        spot.sampling_weight = 0.25;
        for plugin in ["spot", "directional", "constant", "projector", "point"] {
            spot = emitter_turned_into(&spot, plugin);
            assert_eq!((spot.plugin(), spot.sampling_weight), (plugin, 0.25));
        }
        assert_eq!(spot.kind, EmitterKind::Point { intensity: warm });
        // A light that emits only a picture has no colour to keep.
        let sky = emitter_turned_into(&spot, "envmap");
        assert_eq!(sky.plugin(), "envmap");
    }
}
