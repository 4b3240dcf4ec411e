//! The parameters of a material, and what kind it is.

use bevy::math::Vec3;
use bevy_egui::egui::Ui;

use super::fields;
use crate::color::Rgb;
use crate::scene::{ConductorIor, Ior, Material};
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

#[derive(Clone, Copy, PartialEq)]
enum Kind {
    Diffuse,
    Conductor,
    RoughConductor,
    Dielectric,
    Metal,
    TwoSided,
}

/// What a two-sided material may be turned into, and the other way round, is left to the file: it has others inside.
const KINDS: [(Kind, &str); 5] = [
    (Kind::Diffuse, "diffuse"),
    (Kind::Conductor, "conductor"),
    (Kind::RoughConductor, "rough conductor"),
    (Kind::Dielectric, "dielectric"),
    (Kind::Metal, "metal with fuzz"),
];

/// True if `material` was edited.
pub fn material(ui: &mut Ui, material: &mut Material) -> bool {
    let kind = kind(material);
    if kind == Kind::TwoSided {
        fields::note(ui, "Type", "two-sided");
        return false;
    }
    let mut wanted = kind;
    if fields::choice(ui, "Type", &mut wanted, &KINDS) {
        *material = turned_into(material, wanted);
        return true;
    }
    match material {
        Material::Diffuse { reflectance } => fields::color(ui, "Reflectance", reflectance),
        Material::Conductor {
            ior,
            specular_reflectance,
        } => {
            let changed = conductor_ior(ui, ior);
            fields::color(ui, "Tint", specular_reflectance) || changed
        }
        Material::RoughConductor {
            ior,
            specular_reflectance,
            alpha,
        } => {
            let mut changed = fields::slider(ui, "Roughness", alpha, 0.001..=1.0);
            changed |= conductor_ior(ui, ior);
            fields::color(ui, "Tint", specular_reflectance) || changed
        }
        Material::Dielectric {
            interior,
            exterior,
            specular_reflectance,
            specular_transmittance,
        } => {
            let mut changed = dielectric_ior(ui, "Inside", interior);
            changed |= dielectric_ior(ui, "Outside", exterior);
            changed |= fields::color(ui, "Reflection", specular_reflectance);
            fields::color(ui, "Transmission", specular_transmittance) || changed
        }
        Material::Metal { reflectance, fuzz } => {
            let changed = fields::color(ui, "Reflectance", reflectance);
            fields::slider(ui, "Fuzz", fuzz, 0.0..=1.0) || changed
        }
        Material::TwoSided => false,
    }
}

/// The name of the kind, for lists.
pub fn kind_name(material: &Material) -> &'static str {
    let kind = kind(material);
    KINDS
        .iter()
        .find(|(k, _)| *k == kind)
        .map_or("two-sided", |(_, name)| name)
}

fn kind(material: &Material) -> Kind {
    match material {
        Material::Diffuse { .. } => Kind::Diffuse,
        Material::Conductor { .. } => Kind::Conductor,
        Material::RoughConductor { .. } => Kind::RoughConductor,
        Material::Dielectric { .. } => Kind::Dielectric,
        Material::Metal { .. } => Kind::Metal,
        Material::TwoSided => Kind::TwoSided,
    }
}

/// A material of another kind that keeps what the two have in common: colour, metal, roughness.
fn turned_into(material: &Material, kind: Kind) -> Material {
    let (color, ior, roughness) = match material {
        Material::Diffuse { reflectance } => (Some(*reflectance), None, 0.1),
        Material::Metal { reflectance, fuzz } => (Some(*reflectance), None, *fuzz),
        Material::Conductor { ior, .. } => (None, Some(ior.clone()), 0.1),
        Material::RoughConductor { ior, alpha, .. } => (None, Some(ior.clone()), *alpha),
        Material::Dielectric { .. } | Material::TwoSided => (None, None, 0.1),
    };
    let ior = ior.unwrap_or_else(|| ConductorIor::Named("Al".to_owned()));
    match kind {
        Kind::Diffuse | Kind::TwoSided => Material::Diffuse {
            reflectance: color.unwrap_or(Rgb::splat(0.5)),
        },
        Kind::Metal => Material::Metal {
            reflectance: color.unwrap_or(Rgb::splat(0.8)),
            fuzz: roughness,
        },
        Kind::Conductor => Material::Conductor {
            ior,
            specular_reflectance: Rgb::ONE,
        },
        Kind::RoughConductor => Material::RoughConductor {
            ior,
            specular_reflectance: Rgb::ONE,
            alpha: roughness.max(0.001),
        },
        Kind::Dielectric => Material::Dielectric {
            interior: Ior::Named("bk7".to_owned()),
            exterior: Ior::Named("air".to_owned()),
            specular_reflectance: Rgb::ONE,
            specular_transmittance: Rgb::ONE,
        },
    }
}

fn conductor_ior(ui: &mut Ui, ior: &mut ConductorIor) -> bool {
    const GIVEN: &str = "numbers";
    let current = match ior {
        ConductorIor::Named(name) => name.clone(),
        ConductorIor::Given { .. } => GIVEN.to_owned(),
    };
    let mut options = vec![(GIVEN, "eta and k")];
    options.extend(CONDUCTORS.iter().map(|(name, ..)| (*name, in_words(name))));
    if !options.iter().any(|(name, _)| *name == current) {
        options.push((&current, &current));
    }
    let mut choice = current.as_str();
    let mut changed = fields::choice(ui, "Metal", &mut choice, &options);
    if changed {
        *ior = match choice {
            GIVEN => {
                let (eta, k) = ior::conductor_ior(&current).unwrap_or((Rgb::ZERO, Rgb::ONE));
                ConductorIor::Given { eta, k }
            }
            name => ConductorIor::Named(name.to_owned()),
        };
    }
    if let ConductorIor::Given { eta, k } = ior {
        changed |= positive(ui, "Eta", eta);
        changed |= positive(ui, "K", k);
    }
    changed
}

fn in_words(name: &'static str) -> &'static str {
    METALS
        .iter()
        .find(|(metal, _)| *metal == name)
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
            reflectance: Rgb::new(0.6, 0.1, 0.1),
        };
        let metal = turned_into(&red, Kind::Metal);
        assert_eq!(turned_into(&metal, Kind::Diffuse), red);
        let gold = Material::Conductor {
            ior: ConductorIor::Named("Au".into()),
            specular_reflectance: Rgb::ONE,
        };
        let rough = turned_into(&gold, Kind::RoughConductor);
        assert!(matches!(&rough, Material::RoughConductor { ior, .. } if *ior == ConductorIor::Named("Au".into())));
    }
}
