//! Converts materials and lights to other kinds, which keep common parameters.

use crate::scene::{Declared, Emitter, Material, Parameter, ParameterMut, ParameterRef};

/// The material converted to another kind, with the common parameters kept. Parameters of the same meaning count as
/// common, such as `reflectance`, `diffuse_reflectance` and `base_color`.
pub(crate) fn turned_into(material: &Material, plugin: &str) -> Material {
    with_common(Material::of_plugin(plugin).unwrap_or_default(), material)
}

/// The light converted to another kind, with the same colour and strength in any unit, and the other common parameters
/// kept.
pub(crate) fn emitter_turned_into(emitter: &Emitter, plugin: &str) -> Emitter {
    with_common(Emitter::of_plugin(plugin).unwrap_or_default(), emitter)
}

fn with_common<T: Declared>(mut turned: T, before: &T) -> T {
    turned.visit_mut(&mut |info, mut value| {
        before.visit(&mut |own, given| {
            if meaning(own.name) == meaning(info.name) {
                take(&mut value, given);
            }
        });
    });
    turned
}

/// Copies the value if both parameters are of the same type.
fn take(value: &mut ParameterMut, given: ParameterRef) {
    use ParameterMut as Own;
    use ParameterRef as Given;
    match (value, given) {
        (Own::Reflectance(own), Given::Reflectance(given)) | (Own::Normals(own), Given::Normals(given)) => {
            own.clone_from(given);
        }
        (Own::Float(own), Given::Float(given)) | (Own::Height(own), Given::Height(given)) => own.clone_from(given),
        (Own::Number(own), Given::Number(given))
        | (Own::Factor(own), Given::Factor(given))
        | (Own::SamplingWeight(own), Given::SamplingWeight(given)) => **own = *given,
        (Own::Flag(own), Given::Flag(given)) | (Own::Extension(own), Given::Extension(given)) => **own = *given,
        (Own::Ior(own), Given::Ior(given)) => own.clone_from(given),
        (Own::ConductorIor(own), Given::ConductorIor(given)) => own.clone_from(given),
        (Own::Distribution(own), Given::Distribution(given)) => **own = *given,
        (
            Own::Roughness(own) | Own::UniformRoughness(own),
            Given::Roughness(given) | Given::UniformRoughness(given),
        ) => own.clone_from(given),
        (Own::PrincipledIndex(own), Given::PrincipledIndex(given)) => **own = *given,
        (Own::Emission(own), Given::Emission(given) | Given::TexturedEmission(Parameter::Constant(given))) => {
            **own = *given;
        }
        (Own::TexturedEmission(own), Given::Emission(given)) => **own = Parameter::Constant(*given),
        (Own::TexturedEmission(own), Given::TexturedEmission(given)) => own.clone_from(given),
        // No two plugins have parameters of the other types in common.
        _ => {}
    }
}

/// The meaning of a parameter: one name for all colours of matt parts, and one for all emitted quantities.
fn meaning(name: &'static str) -> &'static str {
    match name {
        "diffuse_reflectance" | "base_color" => "reflectance",
        "irradiance" | "intensity" => "radiance",
        other => other,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::color::Rgb;
    use crate::scene::{ConductorIor, EmitterKind};

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
