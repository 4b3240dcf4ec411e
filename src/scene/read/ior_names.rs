//! Names of dielectrics and metals allowed in scene files; any other name is an error with its place in the file.
//!
//! The renderer has the numbers, which this layer does not know; a test keeps both lists equal.

use crate::document::suggest::closest;

/// The names for `int_ior` and `ext_ior`.
pub(crate) const DIELECTRICS: [&str; 23] = [
    "vacuum",
    "helium",
    "hydrogen",
    "air",
    "carbon dioxide",
    "water",
    "acetone",
    "ethanol",
    "carbon tetrachloride",
    "glycerol",
    "benzene",
    "silicone oil",
    "bromine",
    "water ice",
    "fused quartz",
    "pyrex",
    "acrylic glass",
    "polypropylene",
    "bk7",
    "sodium chloride",
    "amber",
    "pet",
    "diamond",
];

/// The names for `material`; each may also be written with `_palik` after it.
pub(crate) const CONDUCTORS: [&str; 42] = [
    "none", "a-C", "Ag", "Al", "AlAs", "AlSb", "Au", "Be", "Cr", "CsI", "Cu", "Cu2O", "Cu_palik", "CuO", "d-C", "Hg",
    "HgTe", "Ir", "K", "Li", "MgO", "Mo", "Na_palik", "Nb", "Ni_palik", "Rh", "Se", "Se-e", "SiC", "SnTe", "Ta", "Te",
    "Te-e", "ThF4", "TiC", "TiN", "TiO2", "TiO2-e", "V_palik", "VC", "VN", "W",
];

/// English words for some of the conductors, with their names in files.
const METALS: [(&str, &str); 8] = [
    ("aluminium", "Al"),
    ("aluminum", "Al"),
    ("chromium", "Cr"),
    ("copper", "Cu"),
    ("gold", "Au"),
    ("mirror", "none"),
    ("silver", "Ag"),
    ("tungsten", "W"),
];

/// The advice for a name that is no conductor. Chemical symbols are too short for suggestions.
pub(crate) fn conductor_help(name: &str) -> String {
    let is_meant = |word: &str| word == name || closest(name, [word]).is_some();
    match METALS.iter().find(|(word, _)| is_meant(word)) {
        Some((_, symbol)) => format!("did you mean `{symbol}`?"),
        None => format!("known are {}", CONDUCTORS.join(", ")),
    }
}

/// Whether this is the name of a dielectric, ignoring case.
pub(crate) fn is_dielectric(name: &str) -> bool {
    DIELECTRICS.iter().any(|known| known.eq_ignore_ascii_case(name))
}

/// Whether this is the name of a conductor, ignoring case.
pub(crate) fn is_conductor(name: &str) -> bool {
    let known = |name: &str| CONDUCTORS.iter().any(|known| known.eq_ignore_ascii_case(name));
    known(name) || name.strip_suffix("_palik").is_some_and(known)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn words_for_metals_are_understood() {
        for name in ["Gold", "gold", "glod"] {
            assert_eq!(conductor_help(name), "did you mean `Au`?", "{name}");
        }
        assert!(METALS.iter().all(|(_, symbol)| is_conductor(symbol)));
        assert!(conductor_help("Fe").starts_with("known are none, a-C"));
    }

    #[test]
    fn the_renderer_knows_every_name_and_no_other() {
        assert!(crate::shading::ior::DIELECTRICS.iter().map(|row| row.0).eq(DIELECTRICS));
        assert!(crate::shading::ior::CONDUCTORS.iter().map(|row| row.0).eq(CONDUCTORS));
        for name in ["Au", "au", "Au_palik", "none", "Xy", "water", "_palik"] {
            assert_eq!(
                is_conductor(name),
                crate::shading::ior::conductor_ior(name).is_some(),
                "{name}"
            );
            assert_eq!(
                is_dielectric(name),
                crate::shading::ior::dielectric_ior(name).is_some(),
                "{name}"
            );
        }
    }
}
